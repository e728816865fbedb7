// Independent-collisions model (ICM): every contact is an instantaneous collision with a coefficient of restitution.
//
// Between collisions all balls fall together, so pair gaps change linearly and only the lowest ball's height is a
// parabola. Collision of i and j (Eqs. 1–3): v_i' = v_i + (1 + ε)(m_eff/m_i) v_rel, and v' = −ε v on the floor. In
// the two-ball drop, Eq. 4 gives v'_r = ε (1 + ε) V for every gap and every pair of masses once v12 is read as
// v'10 − g (t12 − t10) (the printed v12 = v'10 − g t12 contradicts Eq. 5); its inverse is effective_restitution.
// The simulation is event-driven, for any number of balls, and continues after the upward cascade.
//
// Collapse. Infinitely many collisions can happen in a finite time. A ball that bounces on the floor comes to rest
// after 2 ε V/(g (1 − ε)). The sum of the times is also finite under a law with ε → 1 at small speed, and for three
// balls that collide with each other. A collision slower than 1e-8 times the fastest one so far is therefore treated as
// perfectly inelastic: it joins the pair and all balls that touch it and move with it to within that speed. The
// neglected energies and heights are 1e-16 of those of the fastest collision, below rounding. Balls joined in flight
// stay together (gap and rate 0) until one of them is hit; then the rules for touching balls apply. Balls joined with
// the floor rest on it and act as the floor for the ball above, until a collision sets the uppermost of them in motion.
// The outcome is collapse only if ε < 1 and the collisions accumulated. They did not if the last one came after a wait
// longer than all the time before: then it was a late collision of balls of nearly equal velocity.
#pragma once
#include <algorithm>

#include "../base/stop.hpp"
#include "effective_restitution.hpp"
#include "sequence.hpp"
#include "state.hpp"

namespace hardlimit::column {

// State of the balls between two collisions. gaps[0] is the height of the lowest ball's underside (cradle: its
// displacement).
struct Flight {
    double t;  // after release [s]
    std::vector<double> gaps, velocity;
    int resting = 0;       // number of balls, from the lowest, that rest on the floor
    double fastest = 0.0;  // speed of approach in the fastest collision so far [m/s]
};

// Result of a simulation: contacts, and states from which any other state is recomputed.
struct IndependentRun {
    // Least number of collisions between stored states; see every().
    static constexpr std::size_t stride = 64;

    Sequence sequence;
    std::vector<Contact> contacts;  // all collisions
    std::vector<Flight> states;     // before the collisions 0, s, 2s, … with s = every()
    double origin = 0.0;            // time of the first floor touch after release (cradle: 0)
    double t_first = 0.0;           // release, after the first floor touch
    double t_last = 0.0;            // end of the known motion, after the first floor touch

    static std::size_t every(int balls) { return std::max(stride, static_cast<std::size_t>(balls)); }
};

namespace independent {

inline constexpr long most_events = 1'000'000;
inline constexpr double joining_speed = 1e-8;  // in units of the fastest collision so far

struct Event {
    double in;  // time until the collision [s]
    int pair;
};

// The next collision. Of simultaneous collisions, as in touching stacks, the uppermost comes first, which is the limit
// of equal gaps that tend to zero.
template <class Law>
Event next_event(const Column<Law>& c, const Flight& f) {
    Event e{math::infinity, -1};
    if (c.floor && f.resting == 0) {
        const double fall = fall_time(f.gaps[0], f.velocity[0], c.gravity);
        if (fall < e.in) e = {fall, 0};
    }
    if (f.resting > 0 && f.resting < c.balls) {
        const int j = f.resting;
        const double fall = fall_time(f.gaps[j], f.velocity[j], c.gravity);
        if (fall < e.in) e = {fall, j};
    }
    for (int j = f.resting + 1; j < c.balls; ++j) {
        const double rate = f.velocity[j] - f.velocity[j - 1];
        if (!(rate < 0.0)) continue;
        const double wait = math::max(0.0, f.gaps[j]) / -rate;
        if (wait <= e.in) e = {wait, j};
    }
    return e;
}

template <class Law>
void advance(const Column<Law>& c, Flight& f, double dt) {
    const int lowest = f.resting;  // lowest moving ball; also the index of the pair below it
    if (lowest < c.balls) f.gaps[lowest] += dt * (f.velocity[lowest] - 0.5 * c.gravity * dt);
    for (int j = lowest + 1; j < c.balls; ++j) f.gaps[j] += dt * (f.velocity[j] - f.velocity[j - 1]);
    for (int i = lowest; i < c.balls; ++i) f.velocity[i] -= c.gravity * dt;
    f.t += dt;
}

template <class Law>
double approach_speed(const Flight& f, int pair) {
    return (pair == 0 ? 0.0 : f.velocity[pair - 1]) - f.velocity[pair];
}

template <class Law>
double restitution(const Column<Law>& c, int pair, double speed) {
    const double mass = pair == 0 ? c.mass[0] : effective(c.mass[pair - 1], c.mass[pair]);
    return c.contacts[pair].restitution(speed, mass);
}

// Gives a common velocity to the balls of a pair and to all that touch them and move with them to within `speed`.
template <class Law>
void join(const Column<Law>& c, Flight& f, int pair, double speed) {
    const auto together = [&](int j) {
        return f.gaps[j] == 0.0 && math::abs(f.velocity[j] - f.velocity[j - 1]) <= speed;
    };
    int low = math::max(pair - 1, 0), high = pair;
    while (high + 1 < c.balls && together(high + 1)) ++high;
    while (low > 0 && together(low)) --low;
    const bool on_floor = pair == 0 || low < f.resting;
    double momentum = 0.0, mass = 0.0;
    for (int i = low; i <= high; ++i) {
        momentum += c.mass[i] * f.velocity[i];
        mass += c.mass[i];
    }
    for (int i = low; i <= high; ++i) f.velocity[i] = on_floor ? 0.0 : momentum / mass;
    if (on_floor) f.resting = high + 1;
}

// Applies a collision; returns whether it was perfectly inelastic and joined the pair.
template <class Law>
bool collide(const Column<Law>& c, Flight& f, int pair) {
    f.gaps[pair] = 0.0;
    const double speed = approach_speed<Law>(f, pair);
    const double slow = joining_speed * f.fastest;
    f.fastest = math::max(f.fastest, speed);
    if (!(speed > slow)) {
        join(c, f, pair, slow);
        return true;
    }
    if (pair == 0) {
        f.velocity[0] = restitution(c, 0, speed) * speed;
        return false;
    }
    const double m1 = c.mass[pair - 1], m2 = c.mass[pair];
    const double impulse = (1.0 + restitution(c, pair, speed)) * effective(m1, m2) * speed;
    f.velocity[pair - 1] -= impulse / m1;
    f.velocity[pair] += impulse / m2;
    f.resting = std::min(f.resting, pair - 1);
    return false;
}

// Smallest rate of the pair gaps; if it is not negative, no pair collides before the floor is hit.
template <class Law>
double slowest_opening(const Column<Law>& c, const Flight& f) {
    double rate = math::infinity;
    for (int j = 1; j < c.balls; ++j) rate = math::min(rate, f.velocity[j] - f.velocity[j - 1]);
    return rate;
}

template <class Law>
class Run {
public:
    Run(const Column<Law>& column, double until, Stop* stop, long max_events)
        : c(column),
          until_(until),
          stop_(stop),
          max_events_(max_events),
          f{0.0, column.gaps, column.velocity} {
        q.one_ball = c.balls == 1;
        if (c.floor) return;
        q.t_first_touch = 0.0;
        q.floor_opened = true;
    }

    IndependentRun solve() {
        for (long i = 0; !over(); ++i) {
            const Event e = next_event(c, f);
            known_ = f.t + e.in;
            if (e.pair < 0) {
                if (math::is_nan(q.t_first_touch)) q.outcome = Outcome::never_lands;
                break;
            }
            if (q.finished && known_ > end()) break;
            if (i == max_events_) {
                q.outcome = Outcome::unresolved;
                break;
            }
            if (i % IndependentRun::every(c.balls) == 0) run.states.push_back(f);
            process_collision(e);
        }
        if (run.states.empty()) run.states.push_back(f);
        finish();
        return std::move(run);
    }

private:
    const Column<Law>& c;
    const double until_;
    Stop* const stop_;
    const long max_events_;
    IndependentRun run;
    Sequence& q = run.sequence;
    Flight f;
    double known_ = 0.0;  // time after release of the next collision

    double end() const {
        return math::is_nan(q.t_first_touch) ? math::infinity
                                             : q.t_first_touch + until_;  // NaN without `until`
    }

    bool over() {
        if (stop_ && (*stop_)()) return true;
        if (!q.finished) q.moves_freely(slowest_opening(c, f), q.floor_opened);
        return q.finished && !(f.t < end());
    }

    void process_collision(const Event& e) {
        const double before = f.t;
        advance(c, f, e.in);
        const double speed = approach_speed<Law>(f, e.pair);
        const bool joined = collide(c, f, e.pair);
        if (joined && e.in <= before && speed > 0.0 && restitution(c, e.pair, speed) < 1.0)
            q.outcome = Outcome::collapse;
        run.contacts.push_back({e.pair, f.t, f.t});
        if (e.pair == 0) {
            q.floor_begins(f.t);
            if (f.resting > 0) return;
            q.floor_ends(f.t);
            q.floor_opens();
        } else if (q.pair_begins()) {
            q.pair_ends(f.t, c.balls == 2 ? f.velocity[1] - f.velocity[0] : math::nan);
        }
    }

    void finish() {
        const double origin = run.origin = math::is_nan(q.t_first_touch) ? 0.0 : q.t_first_touch;
        for (Contact& k : run.contacts) k = {k.pair, k.begin - origin, k.end - origin};
        run.t_first = 0.0 - origin;  // not −0
        run.t_last = f.t - origin;
        if (q.outcome == Outcome::unresolved) {
            run.t_last = known_ - origin;
        } else if (!math::is_nan(until_)) {
            run.t_last = math::max(until_, run.t_last);
        }
        q.t_second_touch -= origin;
        q.t_end -= origin;
        q.t_floor_end -= origin;
        if (c.balls != 2) q.relative_velocity = q.separation_velocity = math::nan;
        if (!c.floor) q.t_floor_end = math::nan;
        q.close();
    }
};

}  // namespace independent

// `until` in s after the first floor touch (cradle: release); NaN: end of the sequence. The result of a stopped run is
// invalid; a run that reaches `max_events` collisions is unresolved.
template <class Law>
IndependentRun solve_independent(const Column<Law>& c, double until, Stop* stop = nullptr,
                                 long max_events = independent::most_events) {
    return independent::Run<Law>(c, until, stop, max_events).solve();
}

// The state of a run at any time; fastest for ascending times. Both arguments must outlive it.
template <class Law>
class IndependentMotion {
public:
    IndependentMotion(const Column<Law>& column, const IndependentRun& of)
        : c(column), run(of), f(of.states[0]) {}

    // State at `time` [s] after the first floor touch (cradle: release), time >= t_first. At the instant of a
    // collision, the state after it; NaN beyond t_last.
    Flight at(double time) {
        const auto after = std::upper_bound(run.contacts.begin(), run.contacts.end(), time,
                                            [](double t, const Contact& k) { return t < k.begin; });
        Flight state = after_collisions(static_cast<std::size_t>(after - run.contacts.begin()));
        independent::advance(c, state, time - (f.t - run.origin));
        state.t = time;
        if (!(time <= run.t_last)) {  // the run reached its limit on collisions
            std::fill(state.gaps.begin(), state.gaps.end(), math::nan);
            std::fill(state.velocity.begin(), state.velocity.end(), math::nan);
        }
        return state;
    }

    // State after the first n collisions, at the instant of the last one (n = 0: at release).
    const Flight& after_collisions(std::size_t n) {
        const std::size_t every = IndependentRun::every(c.balls);
        const std::size_t kept = std::min(n / every, run.states.size() - 1);
        if (n < next || next < kept * every) {
            next = kept * every;
            f = run.states[kept];
        }
        for (; next < n; ++next) {
            const independent::Event e = independent::next_event(c, f);
            independent::advance(c, f, e.in);
            independent::collide(c, f, e.pair);
        }
        return f;
    }

private:
    const Column<Law>& c;
    const IndependentRun& run;
    Flight f;
    std::size_t next = 0;  // index of the first collision after f
};

}  // namespace hardlimit::column
