// Contact law for test_recipes.py: the elastic force of a cone pressed on a plane, F ~ ξ² (I. N. Sneddon, Proc. Camb.
// Philos. Soc. 44, 492 (1948)), with the damping that makes the restitution independent of the speed:
//   F = max(0, k ξ² + c √ξ ξ̇) while ξ > 0, the case q = 1/2 of linear_map.hpp. It ends at ξ^{3/2} + (c/k) ξ̇ = 0.
#pragma once
#include "linear_map.hpp"

namespace hardlimit::contact {

struct Conical {
    double stiffness;  // k [N/m²]
    double damping;    // c [N s/m^1.5]

    static constexpr int onset_power = 2;
    static constexpr LawRecord record = {
        "conical",
        "Conical",
        "Cone on a plane: F = max(0, k ξ^2 + c √ξ dξ/dt) while ξ > 0.",
        "Sneddon, Proc. Camb. Philos. Soc. 44, 492 (1948)",
        1,
        {{"cone_stiffness", "N/m^2", 0.0, math::infinity, false, false, "stiffness k"}},
        2,
        {1, 1},
        {{{"restitution", "1", 0.0, 1.0, false, true, "coefficient of restitution ε"}},
         {{"cone_damping", "N s/m^1.5", 0.0, math::infinity, true, false, "damping c"}}},
        2,
        {{"cone_stiffness", "N/m^2", "k"}, {"cone_damping", "N s/m^1.5", "c"}},
        {8, 2}};

    void values(double* out) const {
        out[0] = stiffness;
        out[1] = damping;
    }
    Coefficients coefficients() const { return {stiffness, damping}; }
    static Conical from_parameters(int alternative, const double* p, PairGeometry pair) {
        if (alternative == 1) return {p[0], p[1]};
        const double b = linear_damping_ratio(-math::log(p[1]));
        return {p[0], 2.0 * b * math::sqrt(1.5 * p[0]) * math::sqrt(pair.effective_mass)};
    }

    template <class T>
    T force(T s, T rate) const {
        return s * (stiffness * (s * s * s) + damping * rate);
    }
    template <class T>
    T elastic_force(T s) const {
        return stiffness * (s * s) * (s * s);
    }
    template <class T>
    T energy(T s) const {
        return stiffness / 3.0 * (s * s) * (s * s) * (s * s);
    }
    Slack slack(double rate) const {
        const double product = -(damping / stiffness) * rate;
        if (!(product > 0.0)) return {0.0, 0.0};
        const double depth = math::pow(product, 2.0 / 3.0);
        return {depth, 2.0 / 3.0 * depth / rate};
    }

    double damping_ratio(double mass) const {
        return 0.5 * damping / (math::sqrt(1.5 * stiffness) * math::sqrt(mass));
    }
    double restitution(double /*speed*/, double mass) const {
        return math::exp(-linear_loss_exponent(damping_ratio(mass)));
    }
    double duration(double speed, double mass) const {
        const double frequency = math::sqrt(stiffness / 1.5) / math::sqrt(mass);
        const double scale = math::pow(frequency / speed, 1.0 / 3.0) / (1.5 * frequency);
        return scale * mapped_duration(damping_ratio(mass), 1.0 / 3.0);
    }
};

}  // namespace hardlimit::contact
