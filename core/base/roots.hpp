// Polynomials: value, slope, and the first zero by steps that provably cannot pass it; the first zeros of a
// parabola; zeros of other functions.
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

// State of the search in first_crossing.
template <class R>
struct Search {
    R theta, found;
    Mask<R> active;

    // One step to the zero of the parabola above g, but to no more than twice θ where the bound holds only that far.
    template <int D, bool narrow>
    HL_FN void step(const R* g, R bound) {
        const R value = value_at<D>(g, theta), slope = slope_at<D>(g, theta);
        const Mask<R> there = active & (value >= 0.0);
        const R root = math::sqrt<R>(slope * slope - 2.0 * bound * value), speed = slope + root;
        // Close to zero the sum has lost digits; too long a step would pass the zero.
        const R step = select<R>(speed > -1e-6 * slope, -2.0 * value / speed, (root - slope) / bound);
        R moved = theta + step;
        if constexpr (narrow) moved = math::min<R>(moved, theta + theta);
        active = active & negation(there) & ((speed > 0.0) | (slope < 0.0)) & (moved <= 1.0);
        theta = select<R>(active, moved, theta);
        const Mask<R> converged = active & (step <= math::epsilon * moved);
        found = select<R>(there | converged, theta, found);
        active = active & negation(converged);
    }
};

// A polynomial of high degree that starts almost at zero stays far below its parabola over [0, 1], which then gives
// short steps. The parabola over [0, 2θ] is closer and holds up to 2θ.
template <int D, class R>
HL_FN_APART Search<R> search_closer(const R* g, Search<R> at) {
    for (int i = 0; i < 500 && any(at.active); ++i) {
        const R within = math::min<R>(at.theta + at.theta, broadcast<R>(1.0));
        R bound = R{}, power = broadcast<R>(1.0);
        for (int n = 2; n <= D; ++n, power = power * within)
            bound = bound + (n * (n - 1.0)) * (math::abs<R>(g[n]) * power);
        at.template step<D, true>(g, bound);
    }
    return at;
}

// First θ in [0, 1] at which sign·f, a polynomial of degree D, rises to zero from below; `never` if it does not. A
// function that vanishes at θ = 0 because the last event put it there is divided by θ first (`at_zero`). Each step goes
// to the zero of a parabola above f (|f''| <= bound), so no zero can be passed, and the steps converge quadratically.
template <int D, class R>
HL_FN_APART_ON_GPU R first_crossing(const R* f, R sign, Mask<R> at_zero) {
    R g[D + 1];
    for (int n = 0; n < D; ++n) g[n] = sign * select<R>(at_zero, f[n + 1], f[n]);
    g[D] = sign * select<R>(at_zero, R{}, f[D]);
    HL_ROLL
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
    const Mask<R> may = (g[0] < 0.0) & (highest >= 0.0);
    Search<R> at{R{}, select<R>(g[0] >= 0.0, R{}, broadcast<R>(never)), may};
    for (int i = 0; i < 500 && any(at.active); ++i) at.template step<D, false>(g, bound);
    if (any(at.active)) at = search_closer<D, R>(g, at);
    return select<R>(at.active, at.theta, at.found);
}

// First t >= 0 at which v + s t − g t²/2 falls to zero; v <= 0 means that it is zero now.
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

// Zero of a function between `low`, where it has the value `above` > 0, and `high`, where it has `below` <= 0, by false
// position with the weight of an end that stays halved (Illinois), up to values of `rounding`.
template <class F>
double falling_zero(const F& f, double low, double above, double high, double below, double rounding) {
    double t = high;
    for (int i = 0, side = 0; i < 100; ++i) {
        t = low + (high - low) * (above / (above - below));
        const double value = f(t);
        if (math::abs(value) <= rounding || !(low < t && t < high)) break;
        if (value > 0.0) {
            low = t;
            above = value;
            if (side > 0) below *= 0.5;
            side = 1;
        } else {
            high = t;
            below = value;
            if (side < 0) above *= 0.5;
            side = -1;
        }
    }
    return t;
}

// s > 0 with f(s) = target for an f that is nearly a power of s: secant steps in the logarithms.
template <class F>
double solve_power(const F& f, double target) {
    double s = 1.0;
    for (int i = 0; i < 4; ++i) {
        const double value = f(s);
        const double exponent = math::log(f(2.0 * s) / value) / math::log(2.0);
        s *= math::exp(math::log(target / value) / exponent);
    }
    return s;
}

}  // namespace hardlimit::roots
