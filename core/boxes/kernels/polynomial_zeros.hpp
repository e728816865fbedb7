// First zero of a polynomial of degree 16 in time, for event functions that are power series.
#pragma once
#include <cstddef>

#include "../../base/math.hpp"

namespace hardlimit::boxes::series {

inline constexpr int order = 16;
inline constexpr int length = order + 1;

using Four = Vector<4>::Real;  // three coordinates and a spare one

// A plain array, because the linker could merge a member function of std::array with its copy for another instruction
// set. The alignment is the same for all instruction sets.
template <class T>
struct alignas(sizeof(T)) Series {
    T of[length];

    T& operator[](std::size_t k) { return of[k]; }
    const T& operator[](std::size_t k) const { return of[k]; }
};
using Terms = Series<double>;
using Path = Series<Four>;

inline Four load_four(const double* x) { return load_lanes<Four>(x); }

// Σ f_k t^k, four terms at a time, to avoid a long chain of dependent products.
template <int groups>
double sum_of_powers(const Four* f, double t) {
    const double t2 = t * t, t4 = t2 * t2;
    Four sum = f[groups - 1];
    HL_UNROLL
    for (int g = groups - 2; g >= 0; --g) sum = sum * t4 + f[g];
    sum *= Four{1.0, t, t2, t2 * t};
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

// Lower bound on the distance to the next zero of a function with this positive value, this slope and |f''| <= bend:
// the zero of the parabola with f'' = −bend.
inline double zero_free_interval(double value, double slope, double bend) {
    const double root = math::sqrt(slope * slope + 2.0 * bend * value);
    return slope > 0.0 ? (root + slope) / bend : 2.0 * value / (root - slope);
}

// First zero in (0, end] of a polynomial that is positive at 0; infinity if there is none. Usually there is none, which
// is certain once the zero-free intervals from both ends meet.
inline double first_zero(const double* f, double end) {
    static_assert(order == 16);
    constexpr Four index = {1.0, 2.0, 3.0, 4.0};
    Four value[5], slope[4], bends[4];  // f, f' and a bound on |f''|
    HL_UNROLL
    for (int g = 0; g < 4; ++g) {
        value[g] = load_four(f + 4 * g);
        slope[g] = (index + 4.0 * g) * load_four(f + 4 * g + 1);
        const Four two_on = g < 3 ? load_four(f + 4 * g + 2) : Four{f[14], f[15], f[16], 0.0};
        const Four bend = (index + 4.0 * g) * (index + (4.0 * g + 1.0)) * two_on;
        bends[g] = math::max<Four>(bend, -bend);
    }
    value[4] = Four{f[16], 0.0, 0.0, 0.0};
    const double bend = sum_of_powers<4>(bends, end);
    double t = 0.0, at = f[0], rate = f[1], last = end;
    for (int i = 0; i < 1000; ++i) {
        if (!(at > 0.0)) return t;
        const double step = zero_free_interval(at, rate, bend);
        if (!(t + step <= last)) return math::infinity;
        if (t + step <= t * (1.0 + 2.0 * math::epsilon)) return t;
        t += step;
        if (i == 0) {
            at = sum_of_powers<5>(value, end);
            if (at > 0.0) last = end - zero_free_interval(at, -sum_of_powers<4>(slope, end), bend);
            if (!(t <= last)) return math::infinity;
        }
        at = sum_of_powers<5>(value, t);
        rate = sum_of_powers<4>(slope, t);
    }
    return t;
}

// The same for a polynomial that is 0 at 0 and falls at first: its first term above rounding, of order k, is negative.
// A dip of at most `rounding` before it rises does not count.
inline double zero_of_falling(const double* f, int k, double end, double rounding) {
    double above[length] = {rounding}, below[length] = {rounding};
    for (int n = k; n < length; ++n) above[n] = f[n], below[n] = -f[n];
    const double fallen = first_zero(above, end);
    return fallen <= end && first_zero(below, fallen) > fallen ? 0.0 : fallen;
}

// The same for a polynomial that is zero at 0, up to `rounding`, because its event has just occurred. Leading terms
// that are rounding errors are dropped. A function that changes by less than `rounding` within a step counts as zero.
inline double next_zero(const double* f, double end, double step, double rounding) {
    double whole = 0.0, terms[length] = {}, power = 1.0;
    for (int k = 1; k < length; ++k) {
        power *= step;
        terms[k] = math::abs(f[k]) * power;
        whole += terms[k];
    }
    if (math::abs(f[0]) > math::max(1e-9 * whole, rounding)) return f[0] > 0.0 ? first_zero(f, end) : 0.0;
    if (!(whole > rounding)) return math::infinity;
    int k = 1;
    while (k < length && !(terms[k] > 1e-10 * whole)) ++k;
    if (k == length) return math::infinity;
    if (f[k] < 0.0) return zero_of_falling(f, k, end, rounding);
    double rest[length] = {};
    for (int n = k; n < length; ++n) rest[n - k] = f[n];
    return first_zero(rest, end);
}

}  // namespace hardlimit::boxes::series
