// Appendix A of the paper: the upper ball does not act on the lower one (exact for R1 ≫ R2).
//
// Without the reaction, Eq. 14 becomes
//   m1 z̈1 = −m1 g + F01,   m2 z̈2 = −m2 g + F12,
// the motions A (Eqs. A1–A2), B (A3–A4), C (A5) and D (A6). In gaps this is the system of exact.hpp with the
// reaction a2 = 0 and time in units of 1/ω, ω² = k12/m2: the pair spring moves the upper ball's own mass, no longer
// m_eff. The solver is therefore the same. Amplitude and phase of A4, whose p is 0/0 at z = z_inh, are not formed:
// the state itself is propagated. Damping constants stay those of the real contacts.
#pragma once
#include "two_ball.hpp"

namespace hardlimit::column {

HL_FN TwoBall adiabatic_groups(const contact::LinearDashpot& floor, const contact::LinearDashpot& pair,
                               double m1, double m2, double gravity, double speed, Units& units) {
    const double rate = math::sqrt(pair.stiffness / m2);
    units = {speed, rate};
    return {(floor.stiffness / pair.stiffness) * (m2 / m1), 0.0, floor.relaxation_time() * rate,
            pair.relaxation_time() * rate, gravity / (speed * rate)};
}

}  // namespace hardlimit::column
