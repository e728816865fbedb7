// Initial state and units of the two-ball solvers, and conversion of their results to SI units.
#pragma once
#include "../flight.hpp"
#include "../sequence.hpp"
#include "groups.hpp"

namespace hardlimit::column {

enum class Coupling { full, adiabatic };

// A two-ball problem in scaled units.
struct Start {
    TwoBall groups;
    Units units;
    // State at release, and where the solver starts: at the floor touch, or at release if the pair meets first.
    Gaps released, first;
    double per_metre;  // scaled length of one metre
    double fall;       // scaled time from release to the floor touch
    double t;          // scaled time of `first`; 0 at the floor touch
    Outcome outcome;
};

// Sets the initial gap of the pair and the state at which the solver starts.
HL_FN void release_pair(Start& s, double gap) {
    s.released.w = gap * s.per_metre;
    const double w_touch = s.released.w + s.released.dw * s.fall;
    const bool pair_first = s.released.dw < 0.0 && w_touch < 0.0 && s.fall > 0.0;
    s.first = pair_first ? s.released : Gaps{0.0, -1.0, w_touch, s.released.dw};
    s.t = pair_first ? -s.fall : 0.0;
}

// Scales a problem of any law, given its groups and units. The unit of speed is the impact speed at the floor.
HL_FN Start start_scaled(const TwoBall& groups, const Units& units, double gravity, Gaps released) {
    Start s{};
    const double speed = units.speed;
    const double fall = fall_time(released.u, released.du, gravity);
    s.groups = groups;
    s.units = units;
    s.outcome = !(speed > 0.0) ? Outcome::invalid : math::is_nan(fall) ? Outcome::never_lands : Outcome::ok;
    s.per_metre = s.units.rate / speed;
    s.released = {released.u * s.per_metre, released.du / speed, 0.0, released.dw / speed};
    s.fall = fall * s.units.rate;
    release_pair(s, released.w);
    return s;
}

HL_FN Start start_two_ball(const contact::LinearDashpot& floor, const contact::LinearDashpot& pair,
                           const TwoBalls& balls, Coupling coupling) {
    const double speed = impact_speed(balls.released.u, balls.released.du, balls.gravity);
    Units units;
    const TwoBall groups = coupling == Coupling::full ? coupled_groups(floor, pair, balls, speed, units)
                                                      : adiabatic_groups(floor, pair, balls, speed, units);
    return start_scaled(groups, units, balls.gravity, balls.released);
}

// Converts a scaled sequence to SI units, with times from the first floor touch.
template <class Q, class R>
HL_FN void to_si(Q& q, R speed, R rate) {
    const R t0 = select<R>(math::is_nan(q.t_first_touch), R{}, q.t_first_touch);
    q.t_end = (q.t_end - t0) / rate;
    q.t_floor_end = (q.t_floor_end - t0) / rate;
    q.relative_velocity = q.relative_velocity * speed;
    q.separation_velocity = q.separation_velocity * speed;
    q.t_first_touch = t0 / rate;
}
HL_FN void to_si(Sequence& q, const Units& units) {
    q.t_second_touch = (q.t_second_touch - q.t_first_touch) / units.rate;
    to_si(q, units.speed, units.rate);
}

}  // namespace hardlimit::column
