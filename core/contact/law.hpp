// What every contact law states about itself, and what the solvers ask of it.
//
// A law is a small value type: the parameters of ONE contact. It provides
//   onset_power                  p such that the force is a polynomial in s = ξ^(1/p) and ξ̇ (1: linear, 2: Hertz)
//   force(s, rate)               repulsive force before clipping [N]; any scalar type
//   elastic_force(s)             its part at rest [N]
//   energy(s)                    energy stored in the compression [J], elastic_force = dE/dξ
//   drive(s, rate)               has the sign of force and a simple zero where the contact ends, also when
//                                force itself vanishes to higher order at ξ = 0 [m]
//   relaxation_time()            drive = ξ + relaxation_time · ξ̇ [s]
//   restitution(speed, m)        ratio of speeds of one isolated collision
//   duration(speed, m)           time from first touch to zero force [s]
//   from_parameters(...)         contact parameters from the user's
// and `record`, which the bindings, the command line and the generic tests read.
#pragma once
#include "../math.hpp"

namespace hardlimit {

// What a contact knows of its two bodies.
struct PairGeometry {
    double effective_mass;    // m_i m_j/(m_i + m_j) [kg]; the floor has infinite mass
    double effective_radius;  // R_i R_j/(R_i + R_j) [m]; the floor has infinite radius
};

// Symmetric to the last bit.
HL_FN double effective(double a, double b) {
    if (b == math::infinity) return a;
    return a == math::infinity ? b : a * b / (a + b);
}

struct Parameter {
    const char* name;
    const char* unit;
    double lowest, highest;
    bool lowest_allowed, highest_allowed;
    const char* meaning;
};

inline constexpr int max_parameters = 4;

struct LawRecord {
    const char* name;        // for the command line and files
    const char* class_name;  // in Python
    const char* summary;
    const char* source;
    int n_common;
    Parameter common[max_parameters];  // always needed
    int n_alternatives;
    int n_in_alternative[2];
    Parameter alternatives[2][max_parameters];  // exactly one set of these
    int n_contact;
    const char* contact_parameters[max_parameters];  // attributes of one contact, in the order of values()
};

}  // namespace hardlimit
