// Interface of a contact law: what every law states about itself, and what the solvers ask of it.
//
// A law is a small value type with the parameters of one contact. Every law provides (concept NormalLaw)
//   onset_power              p such that the force is a polynomial in s = ξ^(1/p) and ξ̇ (1: linear, 2: Hertz)
//   force(s, rate)           repulsive force before clipping [N]; any scalar type
//   elastic_force(s)         its part at rest [N], which never falls as s grows
//   energy(s)                energy stored in the compression [J], elastic_force = dE/dξ
//   slack(rate)              compression up to which the force is zero at this rate (see Slack)
//   similar                  true, only where the force is a power of ξ and another power of ξ times ξ̇: then contacts
//                            of the same damping force, in units of the elastic one, are copies on another scale
//   linear                   true, only where the force is k ξ + γ ξ̇, with constant k and γ: then contacts that overlap
//                            in time move by power series
//   relaxation_time()        only where slack is −relaxation_time · rate exactly, which has closed forms [s]
//   restitution(speed, m)    ratio of speeds of one isolated collision
//   duration(speed, m)       time from first touch to zero force [s]
//   from_parameters(...)     contact parameters from the user's
//   values(...)              the constants of the contact, in the order of record.constants
// and `record`, which the bindings, the command line, the documentation and the generic tests read.
//
// A law with friction provides in addition (concept FrictionalLaw)
//   History                  state that it keeps for each contact: trivially copyable, value-initialized at touch;
//                            reverse() swaps the two bodies
//   tangential_force(m, h)   force on the second body in the tangent plane [N] from a ContactMotion; updates its History
// The engine that takes small steps accepts it. Columns, clusters of bodies in contact and tables of contacts need the
// closed forms of a FrictionlessLaw.
#pragma once
#include "../base/math.hpp"

namespace hardlimit {

// What a contact knows of its two bodies.
struct PairGeometry {
    double effective_mass;    // m_i m_j/(m_i + m_j) [kg]; the floor has infinite mass
    double effective_radius;  // R_i R_j/(R_i + R_j) [m]; the floor has infinite radius
};

// Largest compression to which a contact law applies, over the smaller radius (at a wall, the radius). A law describes
// two surfaces that touch; a run that gets here ends as too_deep. docs/limits.md gives the reason.
inline constexpr double deepest_compression = 0.5;

// Symmetric to the last bit.
HL_FN double effective(double a, double b) {
    if (b == math::infinity) return a;
    return a == math::infinity ? b : a * b / (a + b);
}

// ξ^(1/p), the coordinate s of a law; 0 without compression.
template <int p>
HL_FN double onset_root(double compression) {
    static_assert(p >= 1);
    if constexpr (p == 1) return compression;
    if (!(compression > 0.0)) return 0.0;
    if constexpr (p == 2) return math::sqrt(compression);
    if constexpr (p == 4) return math::sqrt(math::sqrt(compression));
    return math::pow(compression, 1.0 / p);
}

// Where a contact ends. At a given rate dξ/dt the bodies push each other exactly while ξ > max(depth, 0). The
// depth is a continuous function of the rate that never grows with it, positive only where they separate
// (rate < 0); where it is zero or less, the force lasts down to ξ = 0.
struct Slack {
    double depth;  // [m]
    double slope;  // d depth/d rate [s]; where depth <= 0 it may be zero, else it is the derivative
};

// Two surfaces in contact at one step. Motion is that of the second body relative to the first, at the contact point.
struct ContactMotion {
    double compression, rate;    // ξ [m], dξ/dt [m/s]
    double normal_force;         // [N]
    double normal[3];            // unit vector from the first body to the second
    double sliding_velocity[3];  // in the tangent plane [m/s]
    double duration;             // since the step before, or since touch [s]
};
struct TangentialForce {
    double component[3];  // [N]
};

template <class Law>
concept NormalLaw = requires(const Law& law, double x) {
    Law::onset_power;
    law.force(x, x) + law.elastic_force(x) + law.energy(x) + law.slack(x).depth;
    law.restitution(x, x) + law.duration(x, x);
};
template <class Law>
concept FrictionalLaw =
    NormalLaw<Law> && requires(const Law& law, const ContactMotion& m, typename Law::History& h) {
        law.tangential_force(m, h).component[0];
        h.reverse();
    };
template <class Law>
concept FrictionlessLaw = NormalLaw<Law> && !FrictionalLaw<Law>;

// State of a contact under any law; empty without friction.
struct NoHistory {};
template <class Law>
struct HistoryOf {
    using Type = NoHistory;
};
template <FrictionalLaw Law>
struct HistoryOf<Law> {
    using Type = typename Law::History;
};

struct Parameter {
    const char* name;
    const char* unit;
    double lowest, highest;
    bool lowest_allowed, highest_allowed;
    const char* meaning;
};

// A constant of one contact, as the law computes it from the user's parameters and the two bodies.
struct ContactConstant {
    const char* name;
    const char* unit;
    const char* meaning;
};

inline constexpr int max_parameters = 4;  // of one law: those always needed and those of one alternative
inline constexpr int max_alternatives = 4;

struct LawRecord {
    const char* name;        // for the command line and files
    const char* class_name;  // in Python
    const char* summary;
    const char* source;
    int n_common;
    Parameter common[max_parameters];  // always needed
    int n_alternatives;
    int n_in_alternative[max_alternatives];
    Parameter alternatives[max_alternatives][max_parameters];  // exactly one of these sets
    int n_constants;
    ContactConstant constants[max_parameters];
};

// A law with a force linear in compression and rate, which says so by `linear`.
template <class Law>
concept LinearLaw = requires { requires Law::linear; };

}  // namespace hardlimit
