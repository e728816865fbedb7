// Independent-collisions model (ICM): every contact is instantaneous, one coefficient of restitution each.
//
// Between collisions all balls fall together, so pair gaps change linearly and only the lowest ball's height is a
// parabola. Collision of i and j (Eqs. 1–3): v_i' = v_i + (1 + ε)(m_eff/m_i) v_rel, and v' = −ε v on the floor. In
// the two-ball drop, Eq. 4 gives v'_r = ε (1 + ε) V for every gap and every pair of masses once v12 is read as
// v'10 − g (t12 − t10) (the printed v12 = v'10 − g t12 contradicts Eq. 5); its inverse is effective_restitution.
// The sequence is event-driven for any number of balls: it does not stop after the upward cascade.
#pragma once
#include "effective_restitution.hpp"
#include "sequence.hpp"
#include "state.hpp"

namespace hardlimit::column {

// A collision-free stretch: state at its beginning. Times from the first floor touch (cradle: from release).
struct Flight {
    double t;
    std::vector<double> gaps, velocity;
    double lowest;  // position of ball 1 [m]
};

struct IndependentRun {
    Sequence sequence;
    std::vector<Contact> contacts;
    std::vector<Flight> flights;
};

namespace independent {

inline constexpr int max_events = 200'000;

struct Event {
    double in;
    int pair;
};

// First closing of any gap. Ties, as in touching stacks, go to the upper pair: the limit of equal vanishing gaps.
template <class Law>
Event next_event(const Column<Law>& c, const Flight& f) {
    Event e{math::infinity, -1};
    if (c.floor) {
        const double fall = fall_time(f.gaps[0], f.velocity[0], c.gravity);
        if (fall < e.in && (fall > 0.0 || f.velocity[0] < 0.0)) e = {fall, 0};
    }
    for (int j = 1; j < c.balls; ++j) {
        const double rate = f.velocity[j] - f.velocity[j - 1];
        const double wait = math::max(0.0, f.gaps[j]) / -rate;
        if (rate < 0.0 && wait <= e.in) e = {wait, j};
    }
    return e;
}

template <class Law>
void advance(const Column<Law>& c, Flight& f, double dt) {
    const double drift = dt * (f.velocity[0] - 0.5 * c.gravity * dt);
    f.lowest += drift;
    f.gaps[0] += drift;
    for (int j = 1; j < c.balls; ++j) f.gaps[j] += dt * (f.velocity[j] - f.velocity[j - 1]);
    for (double& v : f.velocity) v -= c.gravity * dt;
    f.t += dt;
}

template <class Law>
void collide(const Column<Law>& c, Flight& f, int pair) {
    f.gaps[pair] = 0.0;
    if (pair == 0) {
        const double speed = -f.velocity[0];
        f.velocity[0] = c.contacts[0].restitution(speed, c.mass[0]) * speed;
        return;
    }
    const double m1 = c.mass[pair - 1], m2 = c.mass[pair], reduced = effective(m1, m2);
    const double speed = f.velocity[pair - 1] - f.velocity[pair];
    const double impulse = (1.0 + c.contacts[pair].restitution(speed, reduced)) * reduced * speed;
    f.velocity[pair - 1] -= impulse / m1;
    f.velocity[pair] += impulse / m2;
}

// Pairs separate for good, as far as the sequence goes.
template <class Law>
double slowest_opening(const Column<Law>& c, const Flight& f) {
    double rate = math::infinity;
    for (int j = 1; j < c.balls; ++j) rate = math::min(rate, f.velocity[j] - f.velocity[j - 1]);
    return rate;
}

}  // namespace independent

template <class Law>
IndependentRun solve_independent(const Column<Law>& c, double until) {
    using namespace independent;
    IndependentRun run;
    Sequence& q = run.sequence;
    Flight f{0.0, c.gaps, c.velocity, c.gaps[0] + c.radius[0]};
    if (!c.floor) {
        q.t_first_touch = 0.0;
        q.floor_opened = true;
    }
    const bool timed = !math::is_nan(until);
    run.flights.push_back(f);
    for (int i = 0;; ++i) {
        const double opening = slowest_opening(c, f);
        q.moves_freely(opening, q.floor_opened);
        const double origin = math::is_nan(q.t_first_touch) ? math::infinity : q.t_first_touch;
        if (q.finished && !(timed && f.t < origin + until)) break;
        const Event e = next_event(c, f);
        if (e.pair < 0) {
            if (math::is_nan(q.t_first_touch)) q.outcome = Outcome::never_lands;
            break;
        }
        if (i == max_events) {
            q.outcome = Outcome::collapse;
            break;
        }
        if (q.finished && f.t + e.in > origin + until) break;
        advance(c, f, e.in);
        collide(c, f, e.pair);
        run.contacts.push_back({e.pair, f.t, f.t});
        if (e.pair == 0) {
            q.floor_begins(f.t);
            q.floor_ends(f.t);
            q.floor_opens();
        } else if (q.pair_begins()) {
            q.pair_ends(f.t, c.balls == 2 ? f.velocity[1] - f.velocity[0] : math::nan);
        }
        run.flights.push_back(f);
    }
    const double origin = math::is_nan(q.t_first_touch) ? 0.0 : q.t_first_touch;
    for (Contact& k : run.contacts) k = {k.pair, k.begin - origin, k.end - origin};
    for (Flight& k : run.flights) k.t -= origin;
    q.t_second_touch -= origin;
    q.t_end -= origin;
    q.t_floor_end -= origin;
    if (c.balls != 2) q.relative_velocity = q.separation_velocity = math::nan;
    if (!c.floor) q.t_floor_end = math::nan;
    q.close();
    return run;
}

}  // namespace hardlimit::column
