// Hertz contact with the damping of Tsuji, Tanaka & Ishida: F = max(0, k ξ^{3/2} + α√(m_eff k) ξ^{1/4} ξ̇) while ξ > 0.
//
// The power 1/4 makes the coefficient of restitution independent of the speed: in X = ξ^{5/4} a collision is that of
// the linear dashpot (linear_map.hpp, q = 1/4), with b = β/ω0 = α/√5 exactly. The duration decreases with the impact
// speed as V^{−1/5}. As in the other laws the force is never attractive: the contact ends at ξ^{5/4} + α√(m_eff/k) ξ̇ =
// 0, not at ξ = 0. So α(ε) differs from published fits, which allow an attractive force at the end of the contact.
#pragma once
#include "hertz.hpp"
#include "linear_map.hpp"

namespace hardlimit::contact {

struct Tsuji {
    double elastic_prefactor;    // k [N/m^{3/2}]
    double damping_coefficient;  // α
    double effective_mass;       // [kg]; enters the damping force

    static constexpr int onset_power = 4;
    static constexpr Parameter prefactor =
        positive("elastic_prefactor", "N/m^1.5", "Hertz stiffness k, the same for every contact");
    static constexpr Parameter restitution_given =
        fraction("restitution", "coefficient of restitution ε, the same at every speed");
    static constexpr Parameter damping_given = not_negative(
        "damping_coefficient", "1", "damping coefficient α; ε is that of the linear dashpot at β/ω0 = α/√5");
    static constexpr LawRecord record = {
        "tsuji",
        "Tsuji",
        "Hertz contact, restitution independent of speed: F = max(0, k ξ^(3/2) + α √(m_eff k) ξ^(1/4) dξ/dt), k given "
        "or k = 2Y√R_eff/(3(1 − ν²)).",
        "Tsuji, Tanaka & Ishida, Powder Technology 71, 239 (1992)",
        0,
        {},
        4,
        {2, 2, 3, 3},
        {{prefactor, restitution_given},
         {prefactor, damping_given},
         {youngs_modulus, poisson_ratio, restitution_given},
         {youngs_modulus, poisson_ratio, damping_given}},
        2,
        {{"elastic_prefactor", "N/m^1.5", "k"}, {"damping_coefficient", "1", "α"}},
        {6, 1}};

    void values(double* out) const {
        out[0] = elastic_prefactor;
        out[1] = damping_coefficient;
    }
    Coefficients coefficients() const {
        return {elastic_prefactor, damping_coefficient * math::sqrt(effective_mass * elastic_prefactor)};
    }

    static Tsuji from_parameters(int alternative, const double* p, PairGeometry pair) {
        const bool material = alternative >= 2, given_restitution = alternative % 2 == 0;
        const double k = material ? hertz_prefactor(p[0], p[1], pair.effective_radius) : p[0];
        const double last = p[material ? 2 : 1];
        const double alpha = given_restitution ? root_five * linear_damping_ratio(-math::log(last)) : last;
        return {k, alpha, pair.effective_mass};
    }

    template <class T>
    T force(T s, T rate) const {
        return elastic_prefactor * (s * (s * s * s * s * s + relaxation() * rate));
    }
    template <class T>
    T elastic_force(T s) const {
        return elastic_prefactor * (s * s * s) * (s * s * s);
    }
    template <class T>
    T energy(T s) const {
        return 0.4 * elastic_prefactor * (s * s * s * s * s) * (s * s * s * s * s);
    }
    // d = (−α√(m/k) ξ̇)^{4/5}
    Slack slack(double rate) const {
        const double product = -relaxation() * rate;
        if (!(product > 0.0)) return {0.0, 0.0};
        const double depth = math::pow(product, 0.8);
        return {depth, 0.8 * depth / rate};
    }

    double restitution(double /*speed*/, double /*mass*/) const {
        return math::exp(-linear_loss_exponent(damping_ratio()));
    }
    double duration(double speed, double mass) const {
        const double frequency = math::sqrt(0.8 * elastic_prefactor) / math::sqrt(mass);
        return 0.8 / frequency * math::pow(frequency / speed, 0.2) * mapped_duration(damping_ratio(), 0.2);
    }

private:
    static constexpr double root_five = 2.2360679774997896964;
    double damping_ratio() const { return damping_coefficient / root_five; }
    // α√(m_eff/k): the force is k ξ^{1/4} (ξ^{5/4} + relaxation · ξ̇).
    double relaxation() const {
        return damping_coefficient * (math::sqrt(effective_mass) / math::sqrt(elastic_prefactor));
    }
};

}  // namespace hardlimit::contact
