// Modal decomposition of the motion of two balls with closed contacts under the linear law: modes e^(λt) of one drop.
//
// With the gaps x = (u − u0, w − w0) relative to equilibrium, motion C is ẍ + C ẋ + K x = 0,
//   C = ((a1 c1, −a2 c2), (−a1 c1, c2)),   K = ((a1, −a2), (−a1, 1)).
// A mode e^(λt) (r, 1) has the left eigenvector ψ with ψᵀ(λ² + λC + K) = 0, and its amplitude in a state is
//   ψᵀ(ẋ + (λ + C) x)/ψᵀ(2λ + C)(r, 1).
// Motions B (floor alone) and D (pair alone) are the sum of one mode and a parabola.
#pragma once
#include "../base/complex.hpp"
#include "../base/math.hpp"
#include "../column/exact/groups.hpp"

namespace hardlimit::sweep::lanes {

using column::GapState;
using column::Groups;

// 1 + c λ, the ratio of a mode's amplitude in L to that in the gap.
template <class R>
HL_FN Complex<R> pull(R c, Complex<R> rate) {
    return {1.0 + c * rate.re, c * rate.im};
}

// A pair of conjugate modes of motion C: w = Re(share e^(λt)), u = Re(shape share e^(λt)). share(x): complex amplitude
// in a state.
template <class R>
struct Mode {
    Complex<R> rate, shape, of_u, of_du, of_w, of_dw;
    HL_FN Complex<R> share(const GapState<R>& x) const {
        return {(of_u.re * x.u + of_du.re * x.du) + (of_w.re * x.w + of_dw.re * x.dw),
                (of_u.im * x.u + of_du.im * x.du) + (of_w.im * x.w + of_dw.im * x.dw)};
    }
};

template <class R>
struct Modes {
    // Motion C.
    Mode<R> fast, slow;
    R can_ring;              // 1: both modes oscillate and were found; otherwise 0
    R rest1, rest2;          // gaps in equilibrium
    R period, size;          // 1/ω and |λ| of the fast mode
    R floor_share;           // ratio of its amplitudes in L1 and L2
    R crest, crest_inverse;  // first maximum of e^(Re λ t) sin ωt,
    R crest_phase;           // and its ωt
    // Motion B: ω, or 0 if the floor contact does not oscillate; 1/ω; 1/(1 + c1 λ); gap in equilibrium.
    R floor_rate, floor_period;
    Complex<R> from_pull;
    R floor_rest;
    // Motion D: ω, or 0 if the pair contact does not oscillate; 1/ω.
    R pair_rate, pair_period;
};

// ---- elementary functions ---------------------------------------------------------------------------------------
// The rough ones serve for estimates that are refined later.

// e^x with relative error 3e-6 for x < 700; at least 1e-304.
template <class R>
HL_FN R rough_exp(R y) {
    const R x = math::max<R>(y, broadcast<R>(-700.0));
    const R k = math::round_small<R>(x * 1.44269504088896338700);
    const R r = x - k * 0.693147180559945309417;
    R p = r * (1.0 / 120.0) + 1.0 / 24.0;
    p = p * r + 1.0 / 6.0;
    p = p * r + 0.5;
    return (1.0 + (r + (r * r) * p)) * math::exp2_integer<R>(k);
}

// Angle of z in [0, 2π), to 1e-5 (Abramowitz and Stegun 4.4.49).
template <class R>
HL_FN R rough_angle(Complex<R> z) {
    const R x = math::abs<R>(z.re), y = math::abs<R>(z.im);
    const Mask<R> steep = y > x;
    const R t = select<R>(steep, x, y) / select<R>(steep, y, x);
    const R t2 = t * t;
    R p = t2 * 0.0208351 - 0.0851330;
    p = p * t2 + 0.1801410;
    p = p * t2 - 0.3302995;
    p = p * t2 + 0.9998660;
    R angle = t * p;
    angle = select<R>(steep, 0.5 * math::pi - angle, angle);
    angle = select<R>(z.re < 0.0, math::pi - angle, angle);
    return select<R>(z.im < 0.0, 2.0 * math::pi - angle, angle);
}

// arcsin x to 7e-5 (Abramowitz and Stegun 4.4.45).
template <class R>
HL_FN R rough_arcsine(R x) {
    const R a = math::abs<R>(x);
    const R p = 1.5707288 + a * (-0.2121144 + a * (0.0742610 - a * 0.0187293));
    const R angle = 0.5 * math::pi - math::sqrt<R>(1.0 - a) * p;
    return select<R>(x < 0.0, -angle, angle);
}

// e^(λt).
template <class R>
HL_FN_APART_ON_GPU Complex<R> evolution(Complex<R> rate, R t) {
    const R size = math::exp_inside<R>(rate.re * t);
    const math::SinCos<R> a = math::sincos<R>(rate.im * t);
    return {size * a.cos, size * a.sin};
}
// The same to 3e-6.
template <class R>
HL_FN_APART_ON_GPU Complex<R> rough_evolution(Complex<R> rate, R t) {
    const R size = rough_exp<R>(rate.re * t);
    const R x = rate.im * t, k = math::round_small<R>(x * 0.636619772367581343076);
    const R r = x - k * (0.5 * math::pi), z = r * r;
    const R sine = r + (r * z) * (-1.0 / 6.0 + z * (1.0 / 120.0 - z * (1.0 / 5040.0)));
    const R cosine = 1.0 + z * (-0.5 + z * (1.0 / 24.0 - z * (1.0 / 720.0)));
    const math::SinCos<R> a = math::in_quadrant<R>(k, sine, cosine);
    return {size * a.cos, size * a.sin};
}

// e^z for |z| < 0.03: 8 terms leave 2e-17.
template <class R>
HL_FN Complex<R> nudge(Complex<R> z) {
    const Complex<R> z2 = z * z, z4 = z2 * z2;
    const auto four = [&](double a, double b, double c, double d) {  // a + b z + z² (c + d z)
        const Complex<R> high = z2 * Complex<R>{c + d * z.re, d * z.im};
        return Complex<R>{(a + b * z.re) + high.re, b * z.im + high.im};
    };
    return four(1.0, 1.0, 1.0 / 2.0, 1.0 / 6.0) +
           z4 * four(1.0 / 24.0, 1.0 / 120.0, 1.0 / 720.0, 1.0 / 5040.0);
}

// ---- modes of a drop --------------------------------------------------------------------------------------------

// λ from a guess by Newton's method on (λ² + a1 p1)(λ² + p2) = a1 a2 p1 p2, p = 1 + c λ.
template <class R>
HL_FN Complex<R> eigenvalue(const Groups<R>& s, Complex<R> l, R& last) {
    const R kappa = s.a1 * (1.0 - s.a2);
    const R coefficients[4] = {s.c2 + s.a1 * s.c1, (1.0 + s.a1) + kappa * (s.c1 * s.c2),
                               kappa * (s.c1 + s.c2), kappa};
    for (int i = 0; i < 5; ++i) {
        Complex<R> value = {broadcast<R>(1.0), R{}}, slope = {R{}, R{}};
        HL_UNROLL
        for (int n = 0; n < 4; ++n) {
            slope = slope * l + value;
            value = value * l;
            value.re = value.re + coefficients[n];
        }
        const Complex<R> step = value / slope;
        l = l - step;
        last = (step.re * step.re + step.im * step.im) / (l.re * l.re + l.im * l.im);
    }
    return l;
}

template <class R>
HL_FN void find_floor_mode(const Groups<R>& s, Modes<R>& k) {
    const R half = 0.5 * (s.a1 * s.c1), square = s.a1 - half * half, omega = math::sqrt<R>(square);
    k.floor_rate = select<R>(square > 0.01 * s.a1, omega, R{});
    k.floor_period = 1.0 / omega;
    k.from_pull = Complex<R>{broadcast<R>(1.0), R{}} / pull<R>(s.c1, {-half, omega});
    k.floor_rest = -s.gravity / s.a1;
}

// A pair of conjugate modes from the squares of its undamped frequency and of the other pair's. `good`: both modes
// oscillate and were found.
template <class R>
HL_FN_APART_ON_GPU Mode<R> pair_mode(const Groups<R>& s, R square, R other, bool fast, Mask<R>& good) {
    const R d1 = s.a1 * s.c1, kappa = s.a1 * (1.0 - s.a2);
    // The damping rate without coupling to the other pair.
    const R half = 0.5 * (s.c2 * (square - kappa) + d1 * (square - (1.0 - s.a2))) / (square - other);
    const R swing2 = square - half * half;
    Mode<R> mode;
    R last;
    mode.rate = eigenvalue<R>(s, {-half, math::sqrt<R>(math::max<R>(swing2, 0.01 * square))}, last);
    const Complex<R> l = mode.rate, l2 = l * l;
    const Complex<R> p1 = pull<R>(s.c1, l), p2 = pull<R>(s.c2, l);
    const Complex<R> one = {broadcast<R>(1.0), R{}}, two = {broadcast<R>(2.0), R{}};
    const Complex<R> first = l2 + scaled<R>(s.a1, p1), second = l2 + p2;
    // Each eigenvector satisfies two equivalent equations. One tends to 0/0 as the coupling a2 vanishes, since the
    // faster mode becomes that of the stiffer contact: of the pair if a1 < 1, else of the floor.
    const Mask<R> of_pair = fast ? s.a1 <= 1.0 : s.a1 > 1.0;
    const Complex<R> by1 = scaled<R>(s.a1, p1), by2 = scaled<R>(s.a2, p2);
    mode.shape = choose<R>(of_pair, by2, second) / choose<R>(of_pair, first, by1);
    const Complex<R> left = choose<R>(of_pair, by1, by2) / choose<R>(of_pair, first, second);
    const Complex<R> left1 = choose<R>(of_pair, left, one), left2 = choose<R>(of_pair, one, left);
    const Complex<R> damp1 = scaled<R>(d1, left1 - left2),
                     damp2 = scaled<R>(s.c2, left2 - scaled<R>(s.a2, left1));
    const Complex<R> norm = scaled<R>(two.re, l) * (left1 * mode.shape + left2) + damp1 * mode.shape + damp2;
    const Complex<R> inverse = two / norm;  // factor 2 for the conjugate pair
    mode.of_du = left1 * inverse;
    mode.of_dw = left2 * inverse;
    mode.of_u = (l * left1 + damp1) * inverse;
    mode.of_w = (l * left2 + damp2) * inverse;
    good = (last < 1e-18) & (l.im > 0.05 * magnitude(l)) & (l.re <= 0.0);
    return mode;
}

template <class R>
HL_FN void find_pair_modes(const Groups<R>& s, Modes<R>& k) {
    const R kappa = s.a1 * (1.0 - s.a2), trace = 1.0 + s.a1;
    // Squares of the undamped frequencies.
    const R fast2 = 0.5 * (trace + math::sqrt<R>(trace * trace - 4.0 * kappa)), slow2 = kappa / fast2;
    Mask<R> found_fast{}, found_slow{};
    k.fast = pair_mode<R>(s, fast2, slow2, true, found_fast);
    k.slow = pair_mode<R>(s, slow2, fast2, false, found_slow);
    Mask<R> good = (s.a2 < 1.0) & found_fast & found_slow;
    good = good & (k.fast.rate.im > 1.2 * k.slow.rate.im);
    // Where the modes are not used they are multiplied by zero and must be finite.
    const Complex<R> zero = {R{}, R{}};
    k.slow.rate = choose<R>(good, k.slow.rate, zero);
    k.slow.shape = choose<R>(good, k.slow.shape, zero);
    k.can_ring = select<R>(good, broadcast<R>(1.0), R{});
    k.rest2 = -s.gravity / (1.0 - s.a2);
    k.rest1 = k.rest2 / s.a1;
    k.period = 1.0 / k.fast.rate.im;
    k.size = magnitude(k.fast.rate);
    k.floor_share = magnitude(pull<R>(s.c1, k.fast.rate) * k.fast.shape / pull<R>(s.c2, k.fast.rate));
    k.crest_phase = 0.5 * math::pi - rough_angle<R>({k.fast.rate.im, -k.fast.rate.re});
    k.crest = k.fast.rate.im * rough_exp<R>(k.fast.rate.re * (k.period * k.crest_phase)) / k.size;
    k.crest_inverse = 1.0 / k.crest;
    const R pair = math::sqrt<R>(1.0 - 0.25 * (s.c2 * s.c2));
    k.pair_rate = select<R>(pair > 0.1, pair, R{});
    k.pair_period = 1.0 / pair;
}

template <class R>
HL_FN Modes<R> find_modes(const Groups<R>& s) {
    Modes<R> k;
    find_floor_mode<R>(s, k);
    find_pair_modes<R>(s, k);
    return k;
}

}  // namespace hardlimit::sweep::lanes
