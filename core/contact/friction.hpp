// Friction between two surfaces: what a contact states beside its normal law (P. A. Cundall & O. D. L. Strack,
// Géotechnique 29, 47 (1979)).
//
// The tangential force on the second body is −(T + γ_t g): g is the velocity of its surface relative to the first, T an
// elastic force with T = 0 at touch, and γ_t a damping. While the surfaces stick,
//   dT/dt = k_t g + m T (da/dt)/a,   a ∝ √ξ the contact radius,
// where m is a number of the model, one while ξ grows and one while it falls. F_n is the normal force. Coulomb's limit:
//   |T + γ_t g| <= μ F_n   SlipLimit::total (LAMMPS): T = μ F_n f − γ_t g while they slip, f a unit vector
//   |T| <= μ F_n           SlipLimit::spring (LIGGGHTS, YADE): T = μ F_n f while they slip, without damping
// k_t and γ_t are powers of the compression. Nothing here is integrated: a force that keeps its own history cannot be
// evaluated between two steps, where events are located. Each solver integrates T.
#pragma once
#include "law.hpp"

namespace hardlimit {

enum class SlipLimit : unsigned char { total, spring };
inline constexpr const char* slip_limit_names[] = {"total", "spring"};

enum class FrictionModel : unsigned char {
    spring,
    mindlin,
    mindlin_force,
    mindlin_rescale,
    mindlin_rescale_force,
    none,
};

struct FrictionModelRecord {
    const char* name;
    const char* summary;
    const char* source;
    int loading, unloading;  // m while ξ grows and while it falls
};
inline constexpr FrictionModelRecord friction_models[] = {
    {"spring", "spring of constant stiffness k_t", "Cundall & Strack, Géotechnique 29, 47 (1979)", 0, 0},
    {"mindlin", "k_t = 8 G* √(R ξ) times the displacement", "Mindlin, J. Appl. Mech. 16, 259 (1949)", 1, 1},
    {"mindlin_force", "k_t = 8 G* √(R ξ), increments of the force are added",
     "Mindlin & Deresiewicz, J. Appl. Mech. 20, 327 (1953)", 0, 0},
    {"mindlin_rescale", "as mindlin, and the displacement shrinks with the contact radius while that falls",
     "Thornton, Cummins & Cleary, Powder Technol. 233, 30 (2013)", 1, 2},
    {"mindlin_rescale_force",
     "as mindlin_force, and the force shrinks with the contact radius while that falls",
     "Thornton, Cummins & Cleary, Powder Technol. 233, 30 (2013)", 0, 1},
    {"none", "no spring, only damping: surfaces never stick", "Haff & Werner, Powder Technol. 48, 239 (1986)",
     0, 0},
};
constexpr const FrictionModelRecord& record_of(FrictionModel m) {
    return friction_models[static_cast<int>(m)];
}

// Friction as the user gives it. NaN: not given.
struct Friction {
    double coefficient = 0.0;  // μ, 0 to infinity
    FrictionModel model = FrictionModel::spring;
    SlipLimit limit = SlipLimit::total;
    double stiffness_ratio = math::nan;  // k_t over the stiffness dF/dξ of the normal force without damping
    double stiffness = math::nan;        // k_t [N/m]
    double damping_ratio = math::nan;    // γ_t over the damping of the normal force
    double damping = math::nan;          // γ_t [kg/s]
};
inline constexpr Parameter friction_parameters[] = {
    {"coefficient", "1", 0.0, math::infinity, true, true, "coefficient of friction μ; infinite: never slips"},
    positive("stiffness_ratio", "1", "k_t over the stiffness of the normal force"),
    positive("stiffness", "N/m", "k_t"),
    not_negative("damping_ratio", "1", "γ_t over the damping of the normal force"),
    not_negative("damping", "kg/s", "γ_t"),
};

// factor · ξ^(power/4)
struct PowerTerm {
    double factor = 0.0;
    int power = 0;

    HL_FN double operator()(double compression) const {
        return power == 0 ? factor : factor * math::pow(compression, 0.25 * power);
    }
};

// The friction of one contact.
struct FrictionTerms {
    double coefficient = 0.0;        // μ
    PowerTerm stiffness;             // k_t [N/m]
    PowerTerm damping;               // γ_t [kg/s]
    int loading = 0, unloading = 0;  // m while ξ grows and while it falls
    SlipLimit limit = SlipLimit::total;
};

// The friction of a contact with this normal force F = K ξ^(elastic/4) + C ξ^(damping/4) ξ̇.
HL_FN FrictionTerms friction_terms(const Friction& f, Powers powers, Coefficients normal) {
    FrictionTerms terms{.coefficient = f.coefficient,
                        .stiffness = {},
                        .damping = {},
                        .loading = record_of(f.model).loading,
                        .unloading = record_of(f.model).unloading,
                        .limit = f.limit};
    if (f.stiffness_ratio == f.stiffness_ratio)
        terms.stiffness = {f.stiffness_ratio * (0.25 * powers.elastic) * normal.elastic, powers.elastic - 4};
    if (f.stiffness == f.stiffness) terms.stiffness = {f.stiffness, 0};
    if (f.damping_ratio == f.damping_ratio)
        terms.damping = {f.damping_ratio * normal.damping, powers.damping};
    if (f.damping == f.damping) terms.damping = {f.damping, 0};
    return terms;
}

// 1/m_t = 1/m_n + R_i²/I_i + R_j²/I_j [1/kg], with I = q m R² and masses of a wall infinite.
HL_FN double inverse_tangential_mass(double mass, double inertia_factor, double other_mass,
                                     double other_inertia_factor) {
    const auto of_body = [](double m, double q) { return m == math::infinity ? 0.0 : (1.0 + 1.0 / q) / m; };
    return of_body(mass, inertia_factor) + of_body(other_mass, other_inertia_factor);
}

// A normal law with friction.
template <class Normal>
    requires PowerLaw<Normal>
struct WithFriction : Normal {
    static_assert(FrictionlessLaw<Normal>);
    using Frictionless = Normal;
    FrictionTerms friction;
};

}  // namespace hardlimit
