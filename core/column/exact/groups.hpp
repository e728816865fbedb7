// Dimensionless groups and state of two balls on a floor under the linear law.
#pragma once
#include "../../contact/linear_dashpot.hpp"

namespace hardlimit::column {

// Whether two balls on a floor have a piecewise closed-form solution under a law.
template <class Law>
inline constexpr bool has_exact_solver = false;
template <>
inline constexpr bool has_exact_solver<contact::LinearDashpot> = true;

// Dimensionless groups; the equations of motion are in motions.hpp.
template <class R>
struct Groups {
    R a1, a2;   // coupling of the floor force, and of the reaction of the upper ball on the lower
    R c1, c2;   // relaxation times γ/k of floor and pair
    R gravity;  // G = g/(V ω)
};

// Below this b2 the lower ball counts as light: 1 − a2 would lose digits by cancellation.
inline constexpr double light_below = 1.0 / 512.0;

// Above this scaled gravity squares overflow. Contacts are then so soft that the static compression under the weight is
// 1e100 times that of the impact.
inline constexpr double strongest_gravity = 1e100;

// The groups of one problem, and b2, the coupling of the pair force to the upper ball: the height s = u + w obeys
// s̈ = −G − b2 L2. Exactly, b2 = 1 − a2. If b2 is small, this difference loses digits and with them the momentum of a
// heavy upper ball; b2 is then computed as m_eff/m2.
struct TwoBall : Groups<double> {
    double b2;
    // The lower ball is much lighter. The velocity of the upper ball is then computed from its own momentum balance.
    HL_FN bool light() const { return b2 < light_below; }
};

// Units of the scaled problem: length speed/rate, time 1/rate.
struct Units {
    double speed, rate;
};

// Gaps of floor and pair, and their rates.
template <class R>
struct GapState {
    R u, du, w, dw;
};
using Gaps = GapState<double>;

// Two balls at release, in SI units.
struct TwoBalls {
    double m1, m2, gravity;
    Gaps released;
};

// b2 = m_eff/m2, computed without cancellation.
HL_FN double upper_share(double reduced, double m1, double m2) {
    const double rest = 1.0 - reduced / m1;
    return rest < light_below ? reduced / m2 : rest;
}

// Groups of fully coupled balls; time in units of 1/ω, ω² = k12/m_eff.
HL_FN TwoBall coupled_groups(const contact::LinearDashpot& floor, const contact::LinearDashpot& pair,
                             const TwoBalls& balls, double speed, Units& units) {
    const double m1 = balls.m1, m2 = balls.m2, reduced = effective(m1, m2);
    const double rate = math::sqrt(pair.stiffness / reduced);
    units = {speed, rate};
    return {{(floor.stiffness / pair.stiffness) * (reduced / m1), reduced / m1,
             floor.relaxation_time() * rate, pair.relaxation_time() * rate, balls.gravity / (speed * rate)},
            upper_share(reduced, m1, m2)};
}

// Groups of the adiabatic model (Appendix A of the paper): the upper ball does not act on the lower one. Exact for
// R1 ≫ R2.
//
// Without the reaction, Eq. 14 becomes
//   m1 z̈1 = −m1 g + F01,   m2 z̈2 = −m2 g + F12,
// the motions A (Eqs. A1–A2), B (A3–A4), C (A5) and D (A6). In gaps this is the system of motions.hpp with a2 = 0 and
// time in units of 1/ω, ω² = k12/m2: the pair spring accelerates the mass m2 instead of m_eff. So the same solver
// applies. It propagates the state and does not need amplitude and phase of A4, whose p is 0/0 at z = z_inh. The
// damping constants are those of the actual contacts.
HL_FN TwoBall adiabatic_groups(const contact::LinearDashpot& floor, const contact::LinearDashpot& pair,
                               const TwoBalls& balls, double speed, Units& units) {
    const double rate = math::sqrt(pair.stiffness / balls.m2);
    units = {speed, rate};
    return {{(floor.stiffness / pair.stiffness) * (balls.m2 / balls.m1), 0.0, floor.relaxation_time() * rate,
             pair.relaxation_time() * rate, balls.gravity / (speed * rate)},
            1.0};
}

}  // namespace hardlimit::column
