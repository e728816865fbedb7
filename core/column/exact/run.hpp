// The run of the exact two-ball solver: from switch to switch until the sequence is over.
#pragma once
#include "../sequence.hpp"
#include "events.hpp"
#include "rest.hpp"

namespace hardlimit::column {

namespace exact {

// One run: finds the next switch, moves there, throws it, until the sequence is over.
template <class Observer>
class Run {
public:
    HL_FN Run(const TwoBall& groups, const Gaps& start, double time, double span_, Observer& seen)
        : s(groups), x(start), t(time), span(span_), until(span_ > -never ? never : -never), observer(seen) {
        on.u = x.u == 0.0;
        on.w = x.w == 0.0;
    }

    HL_FN Sequence run() {
        for (long steps = 0; !sequence.finished || t < until; ++steps) {
            observer.node(Node{t, x, phase.floor, phase.pair});
            if (steps == max_pieces || observer.stopped()) {
                sequence.outcome = Outcome::unresolved;
                break;
            }
            find_next();
            if (stopped) break;
            move();
            throw_switch();
        }
        observer.node(Node{t, x, phase.floor, phase.pair});
        sequence.close();
        return sequence;
    }

private:
    enum class Motion { flight, floor_rest, rest, series };

    const TwoBall& s;
    Gaps x;
    double t, span, until;  // `until` is on the clock of t: known once the floor has been touched
    Observer& observer;
    Sequence sequence;
    Phase phase;
    OnSurface on;
    bool counted = false;  // the pair contact now closed belongs to the sequence
    bool stopped = false;
    // The coming stretch: how the balls move, for how long, and what ends it.
    Motion motion = Motion::flight;
    Piece piece;
    Next next;
    double dt = 0.0;

    HL_FN void find_next() {
        next = Next{};
        const bool alone = phase.floor && !phase.pair && phase.pair_open && !on.w;
        motion = !phase.floor && !phase.pair                        ? Motion::flight
                 : alone && rests_on_floor(s, x)                    ? Motion::floor_rest
                 : phase.floor && phase.pair && rests_on_both(s, x) ? Motion::rest
                                                                    : Motion::series;
        if (motion == Motion::flight)
            find_in_flight();
        else if (motion == Motion::floor_rest)
            next.consider(dt = closing_on_rest(s, x), Switch::pair_begins);
        else if (motion == Motion::rest)
            rest();
        else
            find_in_piece();
        if (dt == never && !(math::abs(until) < never)) stopped = true;
        if (t < until && t + dt >= until) {  // the state asked for comes first
            if (next.at != never && dt > until - t) next = Next{};
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
        if (!(dt > 0.0)) return;  // what lies on an event surface stays there
        x = motion == Motion::flight       ? fly<double>(s, x, dt)
            : motion == Motion::floor_rest ? lie_on_floor(s, x, dt)
            : motion == Motion::rest       ? lie_together(s, x, dt)
                                           : evaluate(piece, dt / piece.h);
        t += dt;
        on = OnSurface{};
    }

    HL_FN void throw_switch() {
        switch (next.what) {
            case Switch::none:
                break;
            case Switch::floor_begins:
                floor_begins();
                break;
            case Switch::floor_ends:
                floor_ends();
                break;
            case Switch::floor_opens:
                floor_opens();
                break;
            case Switch::pair_begins:
                pair_begins();
                break;
            case Switch::pair_ends:
                pair_ends();
                break;
            case Switch::pair_opens:
                pair_opens();
                break;
        }
    }

    // Each switch puts the state exactly on its surface.
    HL_FN void floor_begins() {
        x.u = phase.floor_open ? 0.0 : -s.c1 * x.du;
        on.u = phase.floor_open;
        on.l1 = !phase.floor_open || s.c1 == 0.0 || x.du == 0.0;
        phase.floor = true;
        phase.floor_open = false;
        sequence.floor_begins(t);
        until = span + sequence.t_first_touch;
        observer.begins(0, t);
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

// Runs the sequence from `start` (at time `t`, all contacts open), and on to `span` after the first floor touch if
// that is later (-infinity: no later). `Observer` sees the nodes and the contacts.
template <class Observer>
HL_FN Sequence run_two_ball(const TwoBall& s, const Gaps& start, double t, double span, Observer& observer) {
    return exact::Run<Observer>(s, start, t, span, observer).run();
}

// For maps: nothing but the sequence itself.
struct NoRecorder {
    HL_FN void node(const Node&) {}
    HL_FN void begins(int, double) {}
    HL_FN void ends(int, double) {}
    HL_FN bool stopped() { return false; }
};

}  // namespace hardlimit::column
