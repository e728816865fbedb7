// Two balls on a floor under the linear law: dimensionless groups and state.
#pragma once
#include "../contact/linear_dashpot.hpp"

namespace hardlimit::column {

// The dimensionless groups of the problem.
struct TwoBall {
    double a1, a2;   // floor and reaction couplings
    double c1, c2;   // damping times γ/k of floor and pair
    double gravity;  // G = g/(V ω)
};

// Units of the scaled problem: length speed/rate, time 1/rate.
struct Units {
    double speed, rate;
};

// Fully coupled balls: time in units of the pair's own 1/ω12.
HL_FN TwoBall coupled_groups(const contact::LinearDashpot& floor, const contact::LinearDashpot& pair, double m1,
                             double m2, double gravity, double speed, Units& units) {
    const double reduced = effective(m1, m2);
    const double rate = math::sqrt(pair.stiffness / reduced);
    units = {speed, rate};
    return {(floor.stiffness / pair.stiffness) * (reduced / m1), reduced / m1, floor.relaxation_time() * rate,
            pair.relaxation_time() * rate, gravity / (speed * rate)};
}

struct Gaps {
    double u, du, w, dw;
};

}  // namespace hardlimit::column
