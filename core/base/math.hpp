// Elementary functions without libm: + - * / and sqrt are correctly rounded everywhere, so a function built
// from them alone returns the same bits with every compiler, instruction set and device (contraction to
// fused multiply-add must be off). Every branch is a select, so a loop over lanes vectorises.
// Each function's error is tested against 40-digit arithmetic (tests/base/test_math.py): below 2 ulp for
// exp, log, log1p, below 3 ulp for sin, cos up to |x| = 1.6e6, below 6 ulp for atan2 (half-angle reductions) of
// normal numbers up to 1e300, |y log x| ulp for pow.
#pragma once
#include "portable.hpp"

namespace hardlimit::math {

inline constexpr double pi = 3.14159265358979323846;
inline constexpr double infinity = __builtin_huge_val();
inline constexpr double nan = __builtin_nan("");
inline constexpr double epsilon = 2.220446049250313e-16;  // spacing of doubles at 1

template <class R>
HL_FN R sqrt(R x) {
    return sqrt_of(x);
}
template <class R>
HL_FN R abs(R x) {
    return real_of<R>(bits_of<R>(x) & 0x7fffffffffffffffULL);
}
template <class R>
HL_FN R min(R a, R b) {
    return min_of(a, b);
}
template <class R>
HL_FN R max(R a, R b) {
    return max_of(a, b);
}
template <class R>
HL_FN R clamp(R x, double lo, double hi) {
    return min(max(x, broadcast<R>(lo)), broadcast<R>(hi));
}
template <class R>
HL_FN Mask<R> is_nan(R x) {
    return x != x;
}
HL_FN bool is_finite(double x) { return x - x == 0.0; }

template <int n>
HL_FN double power(double x) {
    double product = 1.0;
    for (int i = 0; i < n; ++i) product *= x;
    return product;
}

// Nearest integer for |x| < 2^51: adding 1.5·2^52 pushes the fraction out of the significand.
template <class R>
HL_FN R round_small(R x) {
    constexpr double shift = 6755399441055744.0;
    return (x + shift) - shift;
}

// Largest integer that is not above x, for |x| < 2^51.
HL_FN double floor_small(double x) {
    const double whole = round_small(x);
    return whole > x ? whole - 1.0 : whole;
}

// 2^k for an integral k in [-1022, 1023].
template <class R>
HL_FN R exp2_integer(R k) {
    constexpr double shift = 6755399441055744.0;
    return real_of<R>((bits_of<R>(k + shift) + 1023) << 52);
}

// e^x = 2^k value for |x| < 750: x = k ln2 + r, |r| <= ln2/2, Taylor polynomial of degree 13 (remainder 4e-18).
template <class R>
struct Power {
    R k, value;
};
template <class R>
HL_FN Power<R> power_of_e(R x) {
    constexpr double ln2_hi = 6.93147180369123816490e-01, ln2_lo = 1.90821492927058770002e-10;
    const R k = round_small<R>(x * 1.44269504088896338700);
    const R r = (x - k * ln2_hi) - k * ln2_lo;
    // Two terms at a time, then two pairs: a short chain of dependent operations.
    const R r2 = r * r, r4 = r2 * r2, r8 = r4 * r4;
    const R a = (0.5 + r * (1.0 / 6.0)) + r2 * (1.0 / 24.0 + r * (1.0 / 120.0));
    const R b = (1.0 / 720.0 + r * (1.0 / 5040.0)) + r2 * (1.0 / 40320.0 + r * (1.0 / 362880.0));
    const R c =
        (1.0 / 3628800.0 + r * (1.0 / 39916800.0)) + r2 * (1.0 / 479001600.0 + r * (1.0 / 6227020800.0));
    const R p = (a + r4 * b) + r8 * c;
    return {k, 1.0 + (r + r2 * p)};
}

// e^x. 2^k is applied in two halves so that results below the normal range are rounded, not lost.
template <class R>
HL_FN R exp(R x) {
    const Power<R> p = power_of_e<R>(clamp(x, -746.0, 710.0));
    const R half = round_small<R>(0.5 * p.k);
    const R scaled = (p.value * exp2_integer<R>(half)) * exp2_integer<R>(p.k - half);
    return select<R>(is_nan(x), x, scaled);
}
// The same for x < 700, nonsense beyond; never below 1e-304.
template <class R>
HL_FN R exp_inside(R x) {
    const Power<R> p = power_of_e<R>(max(x, broadcast<R>(-700.0)));
    return p.value * exp2_integer<R>(p.k);
}

// ln(m) for m in [1/sqrt2, sqrt2] given f = m - 1 exactly: with s = f/(2+f), ln m = 2 artanh s
// = f - s (f - R), the form that keeps f's own digits.
template <class R>
HL_FN R log_of_one_plus(R f) {
    const R s = f / (2.0 + f);
    const R z = s * s;
    R p = broadcast<R>(2.0 / 25.0);
    HL_UNROLL
    for (int n = 23; n >= 3; n -= 2) p = p * z + 2.0 / n;
    const R r = z * p;
    return f - s * (f - r);
}

// ln x for x > 0; -inf at 0, NaN below.
template <class R>
HL_FN R log(R x) {
    constexpr double ln2_hi = 6.93147180369123816490e-01, ln2_lo = 1.90821492927058770002e-10;
    constexpr u64 root_half = 0x3fe6a09e667f3bcdULL;  // 1/sqrt2
    const Mask<R> tiny = x < 2.2250738585072014e-308;
    const R y = select<R>(tiny, x * 18014398509481984.0, x);  // 2^54
    // Exponent and significand such that the significand lies in [1/sqrt2, sqrt2); the exponent becomes a double
    // by its place in the significand of 2^52.
    const auto shifted = bits_of<R>(y) - root_half;
    const R biased = real_of<R>(((shifted + 0x3ff0000000000000ULL) >> 52) | 0x4330000000000000ULL);
    const R k = (biased - 4503599627371519.0) - select<R>(tiny, broadcast<R>(54.0), R{});
    const R m = real_of<R>((shifted & 0x000fffffffffffffULL) + root_half);
    const R value = k * ln2_hi + (log_of_one_plus<R>(m - 1.0) + k * ln2_lo);
    const R edge = select<R>(x == 0.0, broadcast<R>(-infinity), broadcast<R>(nan));
    return select<R>(x > 0.0, select<R>(x == infinity, x, value), edge);
}

// ln(1 + x) without losing the digits of a small x.
template <class R>
HL_FN R log1p(R x) {
    const R y = 1.0 + x;
    const R direct = log_of_one_plus<R>(x);
    // What rounding 1 + x lost, relative to y, is the whole first-order correction.
    const R corrected = log(y) + select<R>(y > 1e15, R{}, (x - (y - 1.0)) / y);
    return select<R>((x > -0.25) & (x < 0.4), direct, corrected);
}

template <class R>
struct SinCos {
    R sin, cos;
};

// Sine and cosine of k pi/2 + r from those of r, by the last two bits of k.
template <class R>
HL_FN SinCos<R> in_quadrant(R k, R sine, R cosine) {
    const auto bits = bits_of<R>(k + 6755399441055744.0);  // as in round_small
    const Mask<R> swap = (bits & 1) != 0;
    const R u = select<R>(swap, cosine, sine), v = select<R>(swap, sine, cosine);
    return {real_of<R>(bits_of<R>(u) ^ ((bits & 2) << 62)),
            real_of<R>(bits_of<R>(v) ^ (((bits + 1) & 2) << 62))};
}

// Sine and cosine: x = k pi/2 + r, pi/2 in three parts (exact products for |k| < 2^20), Taylor polynomials
// on |r| <= pi/4 (remainders 5e-18).
template <class R>
HL_FN SinCos<R> sincos(R x) {
    constexpr double a = 1.57079632673412561417e+00, b = 6.07710050630396597660e-11,
                     c = 2.02226624879595063154e-21;
    const R k = round_small<R>(x * 0.636619772367581343076);
    const R head = x - k * a;
    const R r = (head - k * b) - k * c;
    const R z = r * r;
    const R z2 = z * z, z4 = z2 * z2;
    const R s = ((-1.0 / 6.0 + z * (1.0 / 120.0)) + z2 * (-1.0 / 5040.0 + z * (1.0 / 362880.0))) +
                z4 * ((-1.0 / 39916800.0 + z * (1.0 / 6227020800.0)) +
                      z2 * (-1.0 / 1307674368000.0 + z * (1.0 / 355687428096000.0)));
    const R sine = r + r * (z * s);
    const R q = ((1.0 / 24.0 - z * (1.0 / 720.0)) + z2 * (1.0 / 40320.0 - z * (1.0 / 3628800.0))) +
                z4 * ((1.0 / 479001600.0 - z * (1.0 / 87178291200.0)) + z2 * (1.0 / 20922789888000.0));
    const R half = 0.5 * z;
    const R lead = 1.0 - half;
    const R cosine = lead + (((1.0 - lead) - half) + z2 * q);
    return in_quadrant<R>(k, sine, cosine);
}
template <class R>
HL_FN R sin(R x) {
    return sincos(x).sin;
}
template <class R>
HL_FN R cos(R x) {
    return sincos(x).cos;
}

// Angle of (x, y) for y >= 0, in [0, pi]. Three half-angle steps tan(a/2) = t/(1 + sqrt(1 + t^2)) bring the
// argument below tan(pi/16) for x >= 0; the left half plane is the mirror image.
template <class R>
HL_FN R atan2_upper(R y, R x) {
    const R ax = abs(x);
    const R larger = max(ax, y);
    const R ratio = select<R>(larger == 0.0, R{}, min(ax, y) / larger);
    const R radius = larger * sqrt<R>(1.0 + ratio * ratio);  // without overflow
    const R t1 = select<R>(y == 0.0, R{}, y / (ax + radius));
    const R t2 = t1 / (1.0 + sqrt<R>(1.0 + t1 * t1));
    const R t = t2 / (1.0 + sqrt<R>(1.0 + t2 * t2));
    const R z = t * t;
    R p = broadcast<R>(1.0 / 25.0);
    HL_UNROLL
    for (int n = 23; n >= 3; n -= 2) p = 1.0 / n - p * z;
    const R angle = 8.0 * (t - t * (z * p));
    return select<R>(x < 0.0, pi - angle, angle);
}

// x^y for x > 0.
template <class R>
HL_FN R pow(R x, R y) {
    return exp<R>(y * log(x));
}

}  // namespace hardlimit::math
