// One contact with friction and a fixed normal, under any normal force F = K ξ^p + C ξ^q ξ̇ and any FrictionTerms: the
// hard limit of a collision, exact at walls. frictional_impact.hpp solves it.
//
// The slip velocity keeps its line, because the spring is zero at touch: it is a number g, and m_t ġ = −D with the
// tangential force D. Scaled: ξ = L X with K L^(p+1) = m v², time in L/v, G = g/g_0, forces along the normal in m v²/L
// and tangential ones in m_t g_0 v/L. Then
//   X'' = −f,  G' = −D,  |D| <= M |f|,  M = κ μ v/g_0 = 1/ψ,  κ = m/m_t,
// X(0) = 0, X'(0) = 1, G(0) = 1, β = −G(end). While the surfaces stick, D = S + c G with the force S of the spring,
//   S' = R G + m S X'/(2X),
// and a slip ends when the spring alone would yield faster than its limit falls: when N σ < 0,
//   N = R G − S' + m S X'/(2X),  S = σ M |f| − c G (SlipLimit::total) or S = σ M |f| (SlipLimit::spring),
// with the direction σ of the slip.
//
// Under SlipLimit::spring with damping, a slip may end where the force of sticking bodies would lead back to the limit
// at once: then the spring follows its limit without slip, and the damping acts in part (the solution of Filippov
// between both; codes alternate from step to step). Where it does so until F_n = 0 before an attraction, both sticking
// and slip go on from there: sticking is taken. Codes take either, as the size of the step decides; mostly sticking.
// Without a spring D is c G limited by M |f|, under both limits.
#pragma once
#include "friction.hpp"

namespace hardlimit::contact {

// One contact in the units above.
struct ScaledImpact {
    Powers powers;
    double normal_damping;         // of X^q X'
    PowerTerm stiffness, damping;  // R and c as functions of X
    int loading, unloading;        // m while X grows and while it falls
    SlipLimit limit;
    double coefficient;  // M
};

enum class Surfaces : unsigned char {
    stick,
    slip,
    follow
};  // follow: the spring follows its limit without slip

namespace impact {

// Without a limit there is no force, and without a force no limit is reached. A limit far above the forces of sticking
// surfaces is reached within rounding error of the end only: it counts as infinite, since M |f| would lose all digits.
HL_FN ScaledImpact simplified(ScaledImpact of) {
    constexpr double far = 1e16;
    if (of.coefficient == 0.0) of.stiffness.factor = of.damping.factor = 0.0;
    if (of.stiffness.factor == 0.0 && of.damping.factor == 0.0) of.coefficient = 0.0;
    if (of.coefficient > far * (1.0 + of.stiffness.factor + of.damping.factor))
        of.coefficient = math::infinity;
    return of;
}

// At one instant, scaled.
struct State {
    double time, compression, rate, force;  // τ, X, X', f
    double slip, spring, tangential_force;  // G, S, D
};

// Work until now, scaled: of the damping of the normal force; of c G while the surfaces stick; of S while they stick
// (follow is a way to stick); of D while they slip.
struct Work {
    double normal_damping = 0.0, damping = 0.0, sticking = 0.0, slipping = 0.0;
};

// What a solution tells of each piece of the contact between two of its times: observe(surfaces, begin, end, at), where
// at(time) is the State within.
struct NoObserver {
    template <class At>
    HL_FN void operator()(Surfaces /*surfaces*/, double /*begin*/, double /*end*/, const At& /*at*/) {}
    HL_FN void finish(const State& /*last*/) {}
};

}  // namespace impact

}  // namespace hardlimit::contact
