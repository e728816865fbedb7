// Linear dashpot: F = max(0, k ξ + γ ξ̇) while ξ > 0 (Eq. 7; the force counts as repulsive when positive).
//
// One collision, with ω0² = k/m, β = γ/(2m) and b = β/ω0. With damping, the contact ends at F = 0, before ξ = 0:
//   ω0 t_c = 2 acos(b)/√(1 − b²)      for b < 1,    2 at b = 1,    2 acosh(b)/√(b² − 1) for b > 1,
//   ε      = exp(−b · ω0 t_c).
// These are Eqs. 11–13 as one smooth function of b: the arctan branches of Eq. 11 become one atan2, and the third line
// of Eq. 13 is the second continued to imaginary ω. Each ε in (0, 1] corresponds to exactly one b. The usual DEM
// relation b = −ln ε/√(π² + ln²ε) assumes that the contact ends at ξ = 0, after an attractive force; with the force cut
// off at zero it does not give the ε that was asked for.
#pragma once
#include "law.hpp"

namespace hardlimit::contact {

// ω0 t_c as a function of b = β/ω0.
template <class R>
HL_FN R linear_scaled_duration(R b) {
    const R one = broadcast<R>(1.0);
    const R below = math::min<R>(b, one), above = math::max<R>(b, one);
    const R w = math::sqrt<R>((1.0 - below) * (1.0 + below));
    // √(b² − 1) without overflow. b − 1 is exact near 1; 1 − 1/b would lose four digits there.
    const R s = math::sqrt<R>(above - 1.0) * math::sqrt<R>(above + 1.0);
    const R swinging = 2.0 * math::atan2_upper<R>(w, below) / w;
    const R creeping = 2.0 * math::log1p<R>((above - 1.0) + s) / s;
    return select<R>(b < 1.0, swinging, select<R>(b > 1.0, creeping, one + one));
}

// −ln ε as a function of b.
HL_FN double linear_loss_exponent(double b) { return b * linear_scaled_duration(b); }

// Inverse: b from L = −ln ε >= 0, by Newton's method on ln b: b dL/db = b (ω0 t_c − 2b)/(1 − b²) lies between L and 2,
// and the step is exact in both limits, L = πb and L = 2 ln 2b.
template <class R>
HL_FN R linear_damping_ratio(R loss_exponent) {
    const R L = loss_exponent;
    R b = select<R>(L < 2.0, L / (math::pi - 0.57 * L), 0.5 * math::exp<R>(0.5 * L));
    Mask<R> active = L > 0.0;
    for (int i = 0; i < 20 && any(active); ++i) {
        const R tau = linear_scaled_duration<R>(b);
        // (1 − b²) → 0 at critical damping; the derivative there is 4/3 − (8/15)(b − 1).
        const R regular = (tau - 2.0 * b) / ((1.0 - b) * (1.0 + b)),
                near = 4.0 / 3.0 - (8.0 / 15.0) * (b - 1.0);
        const R slope = select<R>(math::abs<R>(b - 1.0) < 1e-3, near, select<R>(b < 1e8, regular, 2.0 / b));
        const R step = (L - b * tau) / (b * slope);
        b = select<R>(active, b * math::exp<R>(math::clamp<R>(step, -1.0, 1.0)), b);
        active = active & (math::abs<R>(step) >= 2.0 * math::epsilon);
    }
    return select<R>(L > 0.0, b, R{});
}

struct LinearDashpot {
    double stiffness;  // k [N/m]
    double damping;    // γ [N s/m]

    static constexpr int onset_power = 1;
    static constexpr bool linear = true;
    static constexpr LawRecord record = {
        "linear",
        "LinearDashpot",
        "Linear dashpot: F = max(0, k ξ + γ dξ/dt) while ξ > 0.",
        "Müller & Pöschel, Phys. Rev. E 83, 041304 (2011), Eqs. 7 and 11–13",
        1,
        {positive("stiffness", "N/m", "spring constant k")},
        2,
        {1, 1},
        {{fraction("restitution",
                   "coefficient of restitution ε; every contact gets the damping that yields it")},
         {not_negative("damping", "N s/m", "dashpot constant γ, the same for every contact")}},
        2,
        {{"stiffness", "N/m", "k"}, {"damping", "N s/m", "γ"}},
        {4, 0}};

    void values(double* out) const {
        out[0] = stiffness;
        out[1] = damping;
    }
    Coefficients coefficients() const { return {stiffness, damping}; }

    // p: the common parameters, then those of the alternative.
    static LinearDashpot from_parameters(int alternative, const double* p, PairGeometry pair) {
        if (alternative == 1) return {p[0], p[1]};
        return from_damping_ratio(p[0], linear_damping_ratio(-math::log(p[1])), pair.effective_mass);
    }
    static LinearDashpot from_damping_ratio(double stiffness, double b, double mass) {
        return {stiffness, 2.0 * b * math::sqrt(stiffness) * math::sqrt(mass)};
    }

    template <class T>
    T force(T s, T rate) const {
        return stiffness * s + damping * rate;
    }
    template <class T>
    T elastic_force(T s) const {
        return stiffness * s;
    }
    template <class T>
    T energy(T s) const {
        return 0.5 * stiffness * s * s;
    }
    // The force ends at ξ + (γ/k) ξ̇ = 0.
    Slack slack(double rate) const { return {-relaxation_time() * rate, -relaxation_time()}; }
    double relaxation_time() const { return damping / stiffness; }

    double damping_ratio(double mass) const {
        return 0.5 * damping / (math::sqrt(stiffness) * math::sqrt(mass));
    }
    double restitution(double /*speed*/, double mass) const {
        return math::exp(-linear_loss_exponent(damping_ratio(mass)));
    }
    double duration(double /*speed*/, double mass) const {
        return linear_scaled_duration(damping_ratio(mass)) * (math::sqrt(mass) / math::sqrt(stiffness));
    }
};

}  // namespace hardlimit::contact
