// Two balls on a floor under the linear law: dimensionless groups and state.
#pragma once
#include "../contact/linear_dashpot.hpp"

namespace hardlimit::column {

// The dimensionless groups of the problem.
template <class R>
struct Groups {
    R a1, a2;   // floor and reaction couplings
    R c1, c2;   // damping times γ/k of floor and pair
    R gravity;  // G = g/(V ω)
};
using TwoBall = Groups<double>;

// Units of the scaled problem: length speed/rate, time 1/rate.
struct Units {
    double speed, rate;
};

// Fully coupled balls: time in units of the pair's own 1/ω12.
HL_FN TwoBall coupled_groups(const contact::LinearDashpot& floor, const contact::LinearDashpot& pair,
                             double m1, double m2, double gravity, double speed, Units& units) {
    const double reduced = effective(m1, m2);
    const double rate = math::sqrt(pair.stiffness / reduced);
    units = {speed, rate};
    return {(floor.stiffness / pair.stiffness) * (reduced / m1), reduced / m1, floor.relaxation_time() * rate,
            pair.relaxation_time() * rate, gravity / (speed * rate)};
}

// Gaps of floor and pair, and their rates.
template <class R>
struct GapState {
    R u, du, w, dw;
};
using Gaps = GapState<double>;

}  // namespace hardlimit::column
