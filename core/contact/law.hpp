// Interface of a contact law: the members that every law provides and the solvers use.
//
// A law is a small value type with the parameters of one contact. Every law provides (concept NormalLaw)
//   onset_power              p such that the force is a polynomial in s = ξ^(1/p) and ξ̇ (1: linear, 2: Hertz)
//   force(s, rate)           repulsive force before clipping [N]; any scalar type
//   elastic_force(s)         force at rate 0 [N]; never decreases with s
//   energy(s)                energy stored in the compression [J], elastic_force = dE/dξ
//   slack(rate)              compression up to which the force is zero at this rate (see Slack)
//   coefficients()           optional: K and C of a law whose force is exactly K ξ^p + C ξ^q ξ̇, with the powers of its
//                            record. Contacts with the same ratio of damping to elastic force are then equal up to
//                            scaling, and the law can be compared with the forces of other codes
//   linear                   optional, true: the force is k ξ + γ ξ̇ with constant k and γ. Contacts that overlap in
//                            time are then solved by power series
//   relaxation_time()        optional: slack is exactly −relaxation_time · rate, which gives closed forms [s]
//   restitution(speed, m)    coefficient of restitution of an isolated collision
//   duration(speed, m)       time from first touch to zero force [s]
//   from_parameters(...)     the law of one contact from the user's parameters
//   values(...)              the constants of the contact, in the order of record.constants
//   record                   names, units, powers and documentation, read by bindings, command line, docs and tests
//
// A law with friction (concept FrictionalLaw) has in addition
//   friction                 FrictionTerms (friction.hpp): stiffness, damping and limit of the tangential force. A
//                            solver integrates that force
// The engines of boxes accept such a law. Columns and tables of contacts need a FrictionlessLaw.
#pragma once
#include "../base/math.hpp"

namespace hardlimit {

// The properties of the two bodies that a contact law depends on.
struct PairGeometry {
    double effective_mass;    // m_i m_j/(m_i + m_j) [kg]; the floor has infinite mass
    double effective_radius;  // R_i R_j/(R_i + R_j) [m]; the floor has infinite radius
};

// Largest compression to which a contact law applies, over the smaller radius (at a wall, the radius); see
// docs/limits.md. A run that reaches it ends with the outcome too_deep.
inline constexpr double deepest_compression = 0.5;

// a b/(a + b); effective(a, b) and effective(b, a) are identical in every bit.
HL_FN double effective(double a, double b) {
    if (b == math::infinity) return a;
    return a == math::infinity ? b : a * b / (a + b);
}

// The coordinate s = ξ^(1/p) of a law; 0 if ξ <= 0 and p > 1.
template <int p>
HL_FN double onset_root(double compression) {
    static_assert(p >= 1);
    if constexpr (p == 1) return compression;
    if (!(compression > 0.0)) return 0.0;
    if constexpr (p == 2) return math::sqrt(compression);
    if constexpr (p == 4) return math::sqrt(math::sqrt(compression));
    return math::pow(compression, 1.0 / p);
}

// Compression at which the force vanishes. At a given rate dξ/dt a repulsive force acts if and only if
// ξ > max(depth, 0). The depth is a continuous function of the rate that never increases with it, and is positive only
// while the bodies separate (rate < 0). If it is zero or less, the force lasts down to ξ = 0.
struct Slack {
    double depth;  // [m]
    double slope;  // d depth/d rate [s]; may be set to zero where depth <= 0
};

struct FrictionTerms;

template <class Law>
concept NormalLaw = requires(const Law& law, double x) {
    Law::onset_power;
    law.force(x, x) + law.elastic_force(x) + law.energy(x) + law.slack(x).depth;
    law.restitution(x, x) + law.duration(x, x);
};
template <class Law>
concept FrictionalLaw =
    NormalLaw<Law> && requires(const Law& law, void takes(const FrictionTerms&)) { takes(law.friction); };
template <class Law>
concept FrictionlessLaw = NormalLaw<Law> && !FrictionalLaw<Law>;

// Powers of a force F = K ξ^p + C ξ^q ξ̇ at small compressions, and its coefficients.
struct Powers {
    int elastic, damping;   // 4p and 4q
    bool attracts = false;  // the force may be attractive; otherwise it is cut off at zero
};
struct Coefficients {
    double elastic;  // K [N/m^p]
    double damping;  // C [N s/m^(1 + q)]
};
template <class Law>
concept PowerLaw = requires(const Law& law) { law.coefficients().elastic + law.coefficients().damping; };

struct Parameter {
    const char* name;
    const char* unit;
    double lowest, highest;
    bool lowest_allowed, highest_allowed;
    const char* meaning;
};

// Parameters with the ranges (0, ∞), [0, ∞) and (0, 1].
constexpr Parameter positive(const char* name, const char* unit, const char* meaning) {
    return {name, unit, 0.0, math::infinity, false, false, meaning};
}
constexpr Parameter not_negative(const char* name, const char* unit, const char* meaning) {
    return {name, unit, 0.0, math::infinity, true, false, meaning};
}
constexpr Parameter fraction(const char* name, const char* meaning) {
    return {name, "1", 0.0, 1.0, false, true, meaning};
}

// Description of a constant of one contact, which the law computes from the user's parameters and the two bodies.
struct ContactConstant {
    const char* name;
    const char* unit;
    const char* meaning;
};

inline constexpr int max_parameters = 4;  // of one law: the common ones and those of one alternative
inline constexpr int max_alternatives = 4;

struct LawRecord {
    const char* name;        // for the command line and files
    const char* class_name;  // in Python
    const char* summary;
    const char* source;
    int n_common;
    Parameter common[max_parameters];  // always required
    int n_alternatives;
    int n_in_alternative[max_alternatives];
    Parameter alternatives[max_alternatives][max_parameters];  // the user gives exactly one of these sets
    int n_constants;
    ContactConstant constants[max_parameters];
    Powers powers;
};

// A law whose force is linear in compression and rate.
template <class Law>
concept LinearLaw = requires { requires Law::linear; };

}  // namespace hardlimit
