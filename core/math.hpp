// Elementary functions without libm: + - * / and sqrt are correctly rounded everywhere, so a function built
// from them alone returns the same bits with every compiler, instruction set and device (contraction to
// fused multiply-add must be off). Every branch is a select, so a loop over lanes vectorises.
// Each function's error is tested against 40-digit arithmetic (tests/test_math.py): below 2 ulp for
// exp, log, log1p, below 3 ulp for sin, cos up to |x| = 1.6e6, below 6 ulp for atan2 (half-angle reductions) of
// normal numbers up to 1e300, |y log x| ulp for pow.
#pragma once
#include "portable.hpp"

namespace hardlimit::math {

inline constexpr double pi = 3.14159265358979323846;
inline constexpr double infinity = __builtin_huge_val();
inline constexpr double nan = __builtin_nan("");
inline constexpr double epsilon = 2.220446049250313e-16;  // spacing of doubles at 1

HL_FN double sqrt(double x) { return sqrt_of(x); }
HL_FN double abs(double x) { return x < 0.0 ? -x : x; }
HL_FN double min(double a, double b) { return b < a ? b : a; }
HL_FN double max(double a, double b) { return a < b ? b : a; }
HL_FN double clamp(double x, double lo, double hi) { return min(max(x, lo), hi); }
HL_FN bool is_nan(double x) { return x != x; }
HL_FN bool is_finite(double x) { return x - x == 0.0; }

// Nearest integer for |x| < 2^51: adding 1.5·2^52 pushes the fraction out of the significand.
HL_FN double round_small(double x) {
    constexpr double shift = 6755399441055744.0;
    return (x + shift) - shift;
}

// 2^k for an integral k in [-1022, 1023].
HL_FN double exp2_integer(double k) {
    constexpr double shift = 6755399441055744.0;
    return double_of((bits_of(k + shift) + 1023) << 52);
}

// e^x: x = k ln2 + r, |r| <= ln2/2, Taylor polynomial of degree 13 (remainder 4e-18). 2^k is applied in two
// halves so that results below the normal range are rounded, not lost.
HL_FN double exp(double x) {
    constexpr double ln2_hi = 6.93147180369123816490e-01, ln2_lo = 1.90821492927058770002e-10;
    const double clipped = clamp(x, -746.0, 710.0);
    const double k = round_small(clipped * 1.44269504088896338700);
    const double r = (clipped - k * ln2_hi) - k * ln2_lo;
    double p = 1.0 / 6227020800.0;
    p = p * r + 1.0 / 479001600.0;
    p = p * r + 1.0 / 39916800.0;
    p = p * r + 1.0 / 3628800.0;
    p = p * r + 1.0 / 362880.0;
    p = p * r + 1.0 / 40320.0;
    p = p * r + 1.0 / 5040.0;
    p = p * r + 1.0 / 720.0;
    p = p * r + 1.0 / 120.0;
    p = p * r + 1.0 / 24.0;
    p = p * r + 1.0 / 6.0;
    p = p * r + 0.5;
    const double value = 1.0 + (r + (r * r) * p);
    const double half = round_small(0.5 * k);
    const double scaled = (value * exp2_integer(half)) * exp2_integer(k - half);
    return is_nan(x) ? x : scaled;
}

// ln(m) for m in [1/sqrt2, sqrt2] given f = m - 1 exactly: with s = f/(2+f), ln m = 2 artanh s
// = f - s (f - R), the form that keeps f's own digits.
HL_FN double log_of_one_plus(double f) {
    const double s = f / (2.0 + f);
    const double z = s * s;
    double p = 2.0 / 25.0;
    p = p * z + 2.0 / 23.0;
    p = p * z + 2.0 / 21.0;
    p = p * z + 2.0 / 19.0;
    p = p * z + 2.0 / 17.0;
    p = p * z + 2.0 / 15.0;
    p = p * z + 2.0 / 13.0;
    p = p * z + 2.0 / 11.0;
    p = p * z + 2.0 / 9.0;
    p = p * z + 2.0 / 7.0;
    p = p * z + 2.0 / 5.0;
    p = p * z + 2.0 / 3.0;
    const double r = z * p;
    return f - s * (f - r);
}

// ln x for x > 0; -inf at 0, NaN below.
HL_FN double log(double x) {
    constexpr double ln2_hi = 6.93147180369123816490e-01, ln2_lo = 1.90821492927058770002e-10;
    const bool tiny = x < 2.2250738585072014e-308;
    const double y = tiny ? x * 18014398509481984.0 : x;  // 2^54
    const u64 b = bits_of(y);
    // Exponent and significand such that the significand lies in [1/sqrt2, sqrt2).
    const u64 shifted = b - 0x3fe6a09e667f3bcdULL;
    const double k = static_cast<double>(static_cast<i64>(shifted) >> 52) - (tiny ? 54.0 : 0.0);
    const double m = double_of((shifted & 0x000fffffffffffffULL) + 0x3fe6a09e667f3bcdULL);
    const double value = k * ln2_hi + (log_of_one_plus(m - 1.0) + k * ln2_lo);
    return x > 0.0 ? (x == infinity ? x : value) : (x == 0.0 ? -infinity : nan);
}

// ln(1 + x) without losing the digits of a small x.
HL_FN double log1p(double x) {
    const double y = 1.0 + x;
    const double direct = log_of_one_plus(x);
    // What rounding 1 + x lost, relative to y, is the whole first-order correction.
    const double corrected = log(y) + (y > 1e15 ? 0.0 : ((x - (y - 1.0)) / y));
    return x > -0.25 && x < 0.4 ? direct : corrected;
}

struct SinCos {
    double sin, cos;
};

// Sine and cosine: x = k pi/2 + r, pi/2 in three parts (exact products for |k| < 2^20), Taylor polynomials
// on |r| <= pi/4 (remainders 5e-18).
HL_FN SinCos sincos(double x) {
    constexpr double a = 1.57079632673412561417e+00, b = 6.07710050630396597660e-11,
                     c = 2.02226624879595063154e-21;
    const double k = round_small(x * 0.636619772367581343076);
    const double head = x - k * a;
    const double r = (head - k * b) - k * c;
    const double z = r * r;
    double s = 1.0 / 355687428096000.0;
    s = s * z - 1.0 / 1307674368000.0;
    s = s * z + 1.0 / 6227020800.0;
    s = s * z - 1.0 / 39916800.0;
    s = s * z + 1.0 / 362880.0;
    s = s * z - 1.0 / 5040.0;
    s = s * z + 1.0 / 120.0;
    s = s * z - 1.0 / 6.0;
    const double sine = r + r * (z * s);
    double q = 1.0 / 20922789888000.0;
    q = q * z - 1.0 / 87178291200.0;
    q = q * z + 1.0 / 479001600.0;
    q = q * z - 1.0 / 3628800.0;
    q = q * z + 1.0 / 40320.0;
    q = q * z - 1.0 / 720.0;
    q = q * z + 1.0 / 24.0;
    const double half = 0.5 * z;
    const double lead = 1.0 - half;
    const double cosine = lead + (((1.0 - lead) - half) + (z * z) * q);
    const double quarter = k - 4.0 * round_small(0.25 * k);  // in {-2, -1, 0, 1, 2}
    const bool swap = quarter == 1.0 || quarter == -1.0;
    const double u = swap ? cosine : sine, v = swap ? sine : cosine;
    const bool negate_sin = quarter == -1.0 || abs(quarter) == 2.0;
    const bool negate_cos = quarter == 1.0 || abs(quarter) == 2.0;
    return {negate_sin ? -u : u, negate_cos ? -v : v};
}
HL_FN double sin(double x) { return sincos(x).sin; }
HL_FN double cos(double x) { return sincos(x).cos; }

// Angle of (x, y) for y >= 0, in [0, pi]. Three half-angle steps tan(a/2) = t/(1 + sqrt(1 + t^2)) bring the
// argument below tan(pi/16) for x >= 0; the left half plane is the mirror image.
HL_FN double atan2_upper(double y, double x) {
    const double ax = abs(x);
    const double larger = max(ax, y);
    const double ratio = larger == 0.0 ? 0.0 : min(ax, y) / larger;
    const double radius = larger * sqrt(1.0 + ratio * ratio);  // without overflow
    const double t1 = y == 0.0 ? 0.0 : y / (ax + radius);
    const double t2 = t1 / (1.0 + sqrt(1.0 + t1 * t1));
    const double t = t2 / (1.0 + sqrt(1.0 + t2 * t2));
    const double z = t * t;
    double p = 1.0 / 25.0;
    p = 1.0 / 23.0 - p * z;
    p = 1.0 / 21.0 - p * z;
    p = 1.0 / 19.0 - p * z;
    p = 1.0 / 17.0 - p * z;
    p = 1.0 / 15.0 - p * z;
    p = 1.0 / 13.0 - p * z;
    p = 1.0 / 11.0 - p * z;
    p = 1.0 / 9.0 - p * z;
    p = 1.0 / 7.0 - p * z;
    p = 1.0 / 5.0 - p * z;
    p = 1.0 / 3.0 - p * z;
    const double angle = 8.0 * (t - t * (z * p));
    return x < 0.0 ? pi - angle : angle;
}

// x^y for x > 0.
HL_FN double pow(double x, double y) { return exp(y * log(x)); }

}  // namespace hardlimit::math
