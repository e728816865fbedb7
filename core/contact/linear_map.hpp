// Collisions that a change of coordinate maps to those of the linear dashpot. The equation of motion
//   m ξ̈ = −k ξ^{2q+1} − c ξ^q ξ̇
// becomes with X = ξ^{q+1}
//   v dv/dX = −ω² X − 2βv,   ω² = k/((q + 1) m),  2β = c/((q + 1) m).
// The speed v = dξ/dt is the same in both, and so is the end of the force, X + 2βv/ω² = 0. The coefficient of
// restitution is therefore that of the linear dashpot at b = β/ω = c/(2√((q + 1) k m)), at every impact speed V. Only
// the time differs: dt = dξ/v, while dX/v is the time of the linear dashpot, so that
//   t_c = (V/ω)^{−h} J(b, h)/((q + 1) ω),   h = q/(q + 1),   J = ∫ x^{−h} dθ over 0 … θ_c,
// x(θ) = e^{−bθ} sin(√(1 − b²) θ)/√(1 − b²) being the linear collision in units of 1/ω and V/ω, which ends at θ_c.
// For q = 1/4 see Tsuji, Tanaka & Ishida, Powder Technol. 71, 239 (1992).
#pragma once
#include "linear_dashpot.hpp"

namespace hardlimit::contact {

// (1 − e^{−y})/y for y >= 0, without cancellation.
HL_FN double decay_mean(double y) {
    if (y > 0.5) return (1.0 - math::exp(-y)) / y;
    double sum = 1.0;
    for (int n = 14; n >= 1; --n) sum = 1.0 - sum * (y / (n + 1));
    return sum;
}

// The compression x(θ) of a linear collision with V = ω = 1. `left`: θ_c − θ, from which the sine is computed near the
// end of the collision, without cancellation.
HL_FN double linear_compression(double b, double theta, double left) {
    if (b < 1.0) {
        const double w = math::sqrt((1.0 - b) * (1.0 + b));
        const double before_zero = w * left + 2.0 * math::atan2_upper(b, w);
        const double phase = w * theta < 0.5 * math::pi ? w * theta : before_zero;
        return math::exp(-b * theta) * math::sin(phase) / w;
    }
    const double s = math::sqrt(b - 1.0) * math::sqrt(b + 1.0);
    return theta * math::exp(-theta / (b + s)) * decay_mean(2.0 * s * theta);
}

// J(b, h) for 0 <= h <= 1/2 by the double exponential rule (Takahasi & Mori, Publ. RIMS 9, 721 (1974)): the integrand
// is singular at θ = 0 and, for small b, just beyond θ_c, and the rule clusters its points at both ends. Accurate to
// 1e-14.
HL_FN double mapped_duration(double b, double h) {
    constexpr double step = 1.0 / 16.0;
    constexpr int reach = 72;  // points on each side of the middle
    const double length = linear_scaled_duration(b);
    double sum = 0.0;
    for (int i = -reach; i <= reach; ++i) {
        const double grown = math::exp(math::abs(i * step));
        const double cosh = 0.5 * (grown + 1.0 / grown), sinh = 0.5 * (grown - 1.0 / grown);
        const double small = math::exp(-math::pi * sinh);
        const double near = small / (1.0 + small), far = 1.0 / (1.0 + small);  // fractions of the length
        const double theta = length * (i < 0 ? near : far), left = length * (i < 0 ? far : near);
        const double weight = math::pi * cosh * near * far;
        sum += weight * math::exp(-h * math::log(linear_compression(b, theta, left)));
    }
    return step * length * sum;
}

}  // namespace hardlimit::contact
