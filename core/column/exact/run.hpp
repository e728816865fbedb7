// Main loop of the exact two-ball solver: advances from event to event until the sequence is over.
#pragma once
#include "../../base/stop.hpp"
#include "../sequence.hpp"
#include "events.hpp"
#include "glide.hpp"

namespace hardlimit::column {

namespace exact {

template <class Observer>
class Run {
public:
    HL_FN Run(const TwoBall& groups, const Gaps& start, double time, double span_, Observer& observer_)
        : s(groups),
          x(start),
          t(time),
          span(span_),
          until(span_ > -never ? never : -never),
          observer(observer_) {
        if (s.gravity > strongest_gravity) {
            unit = s.gravity;
            in_units_of_gravity(s, x);
        }
        on.u = x.u == 0.0;
        on.w = x.w == 0.0;
        rise = x.du + x.dw;
    }

    HL_FN Sequence run() {
        for (long steps = 0; !sequence.finished || t < until; ++steps) {
            if (!spanned()) record_node();
            const bool finite = math::is_finite(x.u + x.du + x.w + x.dw);
            if (steps == max_pieces || lasting == max_lasting || !finite || observer.stopped()) {
                sequence.outcome = Outcome::unresolved;
                break;
            }
            find_next();
            if (stopped) break;
            move();
            apply_event();
        }
        record_node();
        sequence.close();
        sequence.relative_velocity *= unit;
        sequence.separation_velocity *= unit;
        return sequence;
    }

private:
    enum class Motion { flight, floor_rest, floor_large_step, rest, large_step, series };
    // Number of pieces without an event after which the run tests for creep, and after which it may take large steps
    // (glide.hpp) during and after the sequence.
    static constexpr long creeps_after = 32, large_steps_after = 4000, large_steps_later_after = 32;
    // Number of pieces between two recorded nodes of a lasting contact of both balls after the sequence.
    static constexpr long pieces_per_node = 32;

    TwoBall s;
    Gaps x;
    double unit = 1.0;      // of the lengths and velocities in this run
    double t, span, until;  // `until` is known once the floor has been touched
    Observer& observer;
    Sequence sequence;
    Phase phase;
    OnSurface on;
    bool counted = false;  // the pair contact now closed belongs to the sequence
    bool stopped = false;
    // The next step: kind of motion, duration dt and the event at its end.
    Motion motion = Motion::flight;
    Piece piece;
    NextEvent next;
    double dt = 0.0;
    long lasting = 0;  // pieces since the last event
    double rise =
        0.0;  // velocity of the upper ball, from its momentum balance; used if the lower ball is light
    Powers powers;
    int doublings = 0;  // a large step spans 2^doublings pieces

    HL_FN void record_node() {
        observer.node(Node{t, {x.u * unit, x.du * unit, x.w * unit, x.dw * unit}, phase.floor, phase.pair});
    }

    // Whether this state need not be recorded: the closed form from an earlier node gives it.
    HL_FN bool spanned() const {
        return sequence.finished && phase.floor && phase.pair && lasting % pieces_per_node != 0;
    }

    HL_FN Motion next_motion() {
        if (!phase.floor && !phase.pair) return Motion::flight;
        if (!phase.floor) return Motion::series;
        const bool creeping = lasting > creeps_after;
        if (!phase.pair) {
            const bool alone = phase.pair_open && !on.w;
            if (alone && rests_on_floor(s, x)) return Motion::floor_rest;
            if (!creeping || !creeps_on_floor(s, x)) return Motion::series;
            if (alone) return Motion::floor_rest;
            dt = phase.pair_open ? 0.0 : slack_for(s, x);
            return dt > 8.0 * piece_length(s, true, false) ? Motion::floor_large_step : Motion::series;
        }
        if (rests_on_both(s, s.b2, x) || (creeping && creeps_on_both(s, x))) return Motion::rest;
        const bool may_be_large = lasting > (sequence.finished ? large_steps_later_after : large_steps_after);
        doublings = may_be_large ? Powers::doublings(s, x, t < until ? until - t : never) : -1;
        return doublings >= 0 ? Motion::large_step : Motion::series;
    }

    HL_FN void find_next() {
        next = NextEvent{};
        motion = next_motion();
        ++lasting;
        if (motion == Motion::flight)
            find_in_flight();
        else if (motion == Motion::floor_rest)
            next.consider(dt = closing_on_rest(s, x), Event::pair_begins);
        else if (motion == Motion::rest)
            rest();
        else if (motion == Motion::large_step)
            dt = math::exp2_integer(static_cast<double>(doublings)) * piece_length(s, true, true);
        else if (motion == Motion::series)
            find_in_piece();
        if (dt == never && !(math::abs(until) < never)) stopped = true;
        if (t < until && t + dt >= until) {  // the requested time comes first
            if (next.at != never && dt > until - t) next = NextEvent{};
            dt = until - t;
        }
    }

    HL_FN void find_in_flight() {
        sequence.moves_freely(x.dw, sequence.floor_opened && phase.floor_open);
        next = next_in_flight(s, x, phase);
        dt = next.at;
        if (sequence.finished && !(t < until)) stopped = true;
        if (dt == never && math::is_nan(sequence.t_first_touch)) {
            sequence.outcome = Outcome::never_lands;
            stopped = true;
        }
    }

    HL_FN void rest() {
        if (!sequence.finished) sequence.comes_to_rest(true);
        dt = never;
        if (!(t < until)) stopped = true;
    }

    HL_FN void find_in_piece() {
        const double whole = piece_length(s, phase.floor, phase.pair);
        const double h = t < until ? math::min(whole, until - t) : whole;
        expand(s, x, phase.floor, phase.pair, h, piece);
        next = next_in_piece(piece, phase, on);
        dt = next.at == never ? h : next.at * h;
    }

    HL_FN void move() {
        if (!(dt > 0.0)) return;  // the state stays exactly on the zero of its event function
        if (s.light()) follow_upper_ball();
        x = moved();
        if (s.light()) match_upper_ball();
        t += dt;
        on = OnSurface{};
    }

    HL_FN Gaps moved() {
        if (motion == Motion::flight) return free_motion<double>(s, x, dt);
        if (motion == Motion::rest) return double_contact_motion(s, x, dt);
        if (motion == Motion::large_step) return powers.of(s, doublings).moved(s, x);
        if (motion == Motion::series) return evaluate(piece, dt / piece.h);
        return floor_motion(s, x, dt);
    }

    // Updates the velocity of the upper ball from gravity and the pair force. Computed as u̇ + ẇ, which both follow the
    // fast light ball, its change would be a small difference of large numbers.
    HL_FN void follow_upper_ball() {
        rise -= s.gravity * dt;
        if (motion == Motion::series && phase.pair) rise -= s.b2 * impulse(piece, dt / piece.h);
    }
    // Makes u̇ + ẇ equal to the velocity of the upper ball, by correcting u̇ (with a pair force) or ẇ (without).
    HL_FN void match_upper_ball() {
        if (motion == Motion::large_step || motion == Motion::rest)
            rise = x.du + x.dw;
        else if (phase.pair)
            x.du = rise - x.dw;
        else if (phase.floor)
            x.dw = rise - x.du;
    }

    HL_FN void apply_event() {
        if (next.what != Event::none) lasting = 0;
        switch (next.what) {
            case Event::none:
                return;
            case Event::floor_begins:
                return floor_begins();
            case Event::floor_ends:
                return floor_ends();
            case Event::floor_opens:
                return floor_opens();
            case Event::pair_begins:
                return pair_begins();
            case Event::pair_ends:
                return pair_ends();
            case Event::pair_opens:
                return pair_opens();
        }
    }

    // Each event sets the state exactly on the zero of its event function.
    HL_FN void floor_begins() {
        x.u = phase.floor_open ? 0.0 : -s.c1 * x.du;
        on.u = phase.floor_open;
        on.l1 = !phase.floor_open || s.c1 == 0.0 || x.du == 0.0;
        phase.floor = true;
        phase.floor_open = false;
        const bool first = math::is_nan(sequence.t_first_touch);
        sequence.floor_begins(t);
        if (first) restart_clock();
        observer.begins(0, t);
    }
    // Sets the origin of time to the first floor touch: a long flight before it would cost digits.
    HL_FN void restart_clock() {
        observer.clock_restarts(t);
        sequence.clock_restarts();
        t = 0.0;
        until = span;
    }
    HL_FN void floor_ends() {
        x.u = -s.c1 * x.du;
        on.l1 = true;
        phase.floor = false;
        phase.floor_open = on.u = s.c1 == 0.0;
        sequence.floor_ends(t);
        observer.ends(0, t);
        if (phase.floor_open) sequence.floor_opens();
    }
    HL_FN void floor_opens() {
        x.u = 0.0;
        phase.floor_open = on.u = true;
        sequence.floor_opens();
    }
    HL_FN void pair_begins() {
        x.w = phase.pair_open ? 0.0 : -s.c2 * x.dw;
        on.w = phase.pair_open;
        on.l2 = !phase.pair_open || s.c2 == 0.0 || x.dw == 0.0;
        phase.pair = true;
        phase.pair_open = false;
        counted = sequence.pair_begins();
        observer.begins(1, t);
    }
    HL_FN void pair_ends() {
        x.w = -s.c2 * x.dw;
        on.l2 = true;
        phase.pair = false;
        phase.pair_open = on.w = s.c2 == 0.0;
        if (counted) sequence.pair_ends(t, x.dw);
        counted = false;
        observer.ends(1, t);
    }
    HL_FN void pair_opens() {
        x.w = 0.0;
        phase.pair_open = on.w = true;
    }
};

}  // namespace exact

// Solves the sequence from `start` (at time `t`, all contacts open), and continues to `span` after the first floor
// touch if that is later (-infinity: ends with the sequence). The observer receives the nodes and the contacts.
template <class Observer>
HL_FN Sequence run_two_ball(const TwoBall& s, const Gaps& start, double t, double span, Observer& observer) {
    return exact::Run<Observer>(s, start, t, span, observer).run();
}

// Observer that records nothing, for maps, which need only the sequence.
struct NoRecorder {
    Stop* stop = nullptr;
    double last = 0.0;  // time of the last node

    HL_FN void node(const Node& n) { last = n.t; }
    HL_FN void clock_restarts(double) {}
    HL_FN void begins(int, double) {}
    HL_FN void ends(int, double) {}
    HL_FN bool stopped() const { return stop && (*stop)(); }
};

}  // namespace hardlimit::column
