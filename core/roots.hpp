// Polynomials: value, slope, and the first zero by steps that provably cannot pass it; the first zeros of a parabola.
#pragma once
#include "math.hpp"

namespace hardlimit::roots {

// Polynomial of degree D and its derivative, by Horner's rule on every fourth coefficient: four short chains of
// dependent operations instead of one long one.
template <int D, class R>
HL_FN R value_at(const R* f, R x) {
    const R x2 = x * x, x4 = x2 * x2;
    R part[4] = {};
    HL_UNROLL
    for (int n = D; n >= 0; --n) part[n % 4] = n > D - 4 ? f[n] : part[n % 4] * x4 + f[n];
    return (part[0] + x * part[1]) + x2 * (part[2] + x * part[3]);
}
template <int D, class R>
HL_FN R slope_at(const R* f, R x) {
    const R x2 = x * x, x4 = x2 * x2;
    R part[4] = {};
    HL_UNROLL
    for (int n = D; n >= 1; --n) {
        const R term = static_cast<double>(n) * f[n];
        part[(n - 1) % 4] = n > D - 4 ? term : part[(n - 1) % 4] * x4 + term;
    }
    return (part[0] + x * part[1]) + x2 * (part[2] + x * part[3]);
}

inline constexpr double never = math::infinity;

// First θ in [0, 1] at which sign·f, a polynomial of degree D, rises to zero from below; `never` if it does not. A
// function that vanishes at θ = 0 because the last event put it there is divided by θ first (`at_zero`). Each step goes
// to the zero of a parabola above f (|f''| <= bound), so no zero can be passed, and the steps converge quadratically.
template <int D, class R>
HL_FN R first_crossing(const R* f, R sign, Mask<R> at_zero) {
    R g[D + 1];
    for (int n = 0; n < D; ++n) g[n] = sign * select<R>(at_zero, f[n + 1], f[n]);
    g[D] = sign * select<R>(at_zero, R{}, f[D]);
    for (int i = 0; i < D; ++i) {  // touching without approach: zero of higher order
        const Mask<R> again = at_zero & (g[0] == 0.0);
        if (!any(again)) break;
        for (int n = 0; n < D; ++n) g[n] = select<R>(again, g[n + 1], g[n]);
        g[D] = select<R>(again, R{}, g[D]);
    }
    R highest = g[0], bound = R{};
    for (int n = 1; n <= D; ++n) {
        highest = highest + math::max<R>(g[n], R{});
        bound = bound + (n * (n - 1.0)) * math::abs<R>(g[n]);
    }
    Mask<R> active = (g[0] < 0.0) & (highest >= 0.0);
    R theta = R{}, found = select<R>(g[0] >= 0.0, R{}, broadcast<R>(never));
    for (int i = 0; i < 500 && any(active); ++i) {
        const R value = value_at<D>(g, theta), slope = slope_at<D>(g, theta);
        const Mask<R> there = active & (value >= 0.0);
        const R speed = slope + math::sqrt<R>(slope * slope - 2.0 * bound * value);
        const R step = -2.0 * value / speed;
        const R moved = theta + step;
        active = active & negation(there) & (speed > 0.0) & (moved <= 1.0);
        theta = select<R>(active, moved, theta);
        const Mask<R> converged = active & (step <= math::epsilon * moved);
        found = select<R>(there | converged, theta, found);
        active = active & negation(converged);
    }
    return select<R>(active, theta, found);
}

// First t >= 0 at which v + s t − g t²/2 falls to zero; v <= 0 means that it lies on zero now.
HL_FN double first_fall(double v, double s, double g) {
    if (v <= 0.0) {
        if (s < 0.0 || (s == 0.0 && g > 0.0)) return 0.0;
        return g > 0.0 ? 2.0 * s / g : never;
    }
    const double root = math::sqrt(s * s + 2.0 * g * v);
    if (s > 0.0) return g > 0.0 ? (s + root) / g : never;
    return root - s > 0.0 ? 2.0 * v / (root - s) : never;
}

// First t at which v + s t − g t²/2 (v <= 0) rises to zero.
HL_FN double first_rise(double v, double s, double g) {
    const double square = s * s + 2.0 * g * v;
    if (!(s > 0.0) || square < 0.0) return never;
    return -2.0 * v / (s + math::sqrt(square));
}

}  // namespace hardlimit::roots
