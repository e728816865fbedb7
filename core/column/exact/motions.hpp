// Exact solution of Newton's equations for two balls on a floor under the linear dashpot law (Eq. 14 with Eq. 7).
//
// With gaps u (floor) and w (pair), L1 = u + c1 u̇, L2 = w + c2 ẇ (c = γ/k, force = −k L while in contact):
//   ü = −G − a1 L1 [floor] + a2 L2 [pair],      ẅ = a1 L1 [floor] − L2 [pair],
// in units of length V/ω, time 1/ω, speed V, with ω² = k12/m_eff, a1 = k01/(m1 ω²), a2 = m_eff/m1. Terms in brackets
// apply while that contact is closed. Other values of the groups give the adiabatic problem (groups.hpp).
//
// Between two events the system is linear with constant coefficients (motion A: free, B: floor, C: both,
// D: pair): the state after t is exp(M t) times the initial state. The exponential is evaluated by its Taylor series on
// pieces of length h = 1.5/|M|: 22 terms leave a remainder below rounding (1.5²²/22! = 7e-18) for any damping.
// Eigenvectors would lose digits where eigenvalues coincide (critical damping). Motion A is a parabola. Each event is
// the first zero of a polynomial on [0, 1], found by steps that provably do not pass it (first_crossing).
#pragma once
#include "../../base/roots.hpp"
#include "groups.hpp"

namespace hardlimit::column {

// State at the start of a piece, and which contacts are closed in it.
struct Node {
    double t;
    Gaps x;
    bool floor, pair;
};

namespace exact {

using roots::first_crossing;
using roots::first_fall;
using roots::first_rise;
using roots::never;
using roots::slope_at;
using roots::value_at;

inline constexpr int order = 22;
inline constexpr long max_pieces = 4'000'000,
                      max_lasting = 2'000'000;  // pieces in a run; pieces between two events

// Taylor polynomials of u, w, L1 and L2 in θ = (t − t0)/h.
template <class R, int N = order>
struct Series {
    R h;
    R u[N + 1], w[N + 1], l1[N], l2[N];
};

// 1/n!
template <int N>
struct InverseFactorials {
    double of[N + 1];
    constexpr InverseFactorials() : of() {
        of[0] = 1.0;
        for (int n = 1; n <= N; ++n) of[n] = of[n - 1] / n;
    }
};

using Piece = Series<double>;

// Upper bound on the rates (moduli of the eigenvalues) of the motion.
template <class R>
HL_FN R rate_bound(const Groups<R>& s, Mask<R> floor, Mask<R> pair) {
    const R square = select<R>(floor, s.a1, R{}) + select<R>(pair, broadcast<R>(1.0), R{});
    const R damping = select<R>(floor, s.a1 * s.c1, R{}) + select<R>(pair, s.c2, R{});
    return math::max<R>(math::sqrt(square), damping);
}

inline constexpr double reach = 1.5;  // length of a piece times rate_bound
HL_FN double piece_length(const TwoBall& s, bool floor, bool pair) {
    return reach / rate_bound(s, floor, pair);
}

// Computes the Taylor polynomials of a piece. The recurrence runs on derivatives (n! times the coefficients), for which
// its factors do not depend on n: u⁽ⁿ⁺²⁾ = reaction·L2⁽ⁿ⁾ − k1·L1⁽ⁿ⁾. L⁽ⁿ⁾ is multiplied out to shorten the chain of
// dependent operations.
template <class R, int N>
HL_FN void expand(const Groups<R>& s, const GapState<R>& x, Mask<R> floor, Mask<R> pair, R h,
                  Series<R, N>& p) {
    constexpr InverseFactorials<N> inverse;
    const R square = h * h, d1 = s.c1 / h, d2 = s.c2 / h;
    const R k1 = select<R>(floor, s.a1, R{}) * square, k2 = select<R>(pair, square, R{});
    const R reaction = select<R>(pair, s.a2, R{}) * square;
    const R k1d = k1 * d1, k2d = k2 * d2, reaction_d = reaction * d2;
    p.h = h;
    R u0 = x.u, w0 = x.w, u1 = x.du * h, w1 = x.dw * h;
    R weight = s.gravity * square;
    HL_UNROLL
    for (int n = 0; n < N; ++n) {
        p.u[n] = inverse.of[n] * u0;
        p.w[n] = inverse.of[n] * w0;
        p.l1[n] = inverse.of[n] * (u0 + d1 * u1);
        p.l2[n] = inverse.of[n] * (w0 + d2 * w1);
        const R push = k1d * u1, u2 = ((reaction * w0 - k1 * u0) - weight) + (reaction_d * w1 - push);
        const R w2 = (k1 * u0 - k2 * w0) + (push - k2d * w1);
        u0 = u1;
        w0 = w1;
        u1 = u2;
        w1 = w2;
        weight = R{};
    }
    p.u[N] = inverse.of[N] * u0;
    p.w[N] = inverse.of[N] * w0;
}

template <class R, int N>
HL_FN GapState<R> evaluate(const Series<R, N>& p, R theta) {
    return {value_at<N>(p.u, theta), slope_at<N>(p.u, theta) / p.h, value_at<N>(p.w, theta),
            slope_at<N>(p.w, theta) / p.h};
}

// ∫ L2 dt from the start of a piece to θ.
HL_FN double impulse(const Piece& p, double theta) {
    double sum = 0.0;
    for (int n = order - 1; n >= 0; --n) sum = sum * theta + p.l2[n] / (n + 1.0);
    return p.h * theta * sum;
}

// State after a time t of free flight (motion A).
template <class R>
HL_FN GapState<R> free_motion(const Groups<R>& s, const GapState<R>& x, R t) {
    return {x.u + t * (x.du - 0.5 * s.gravity * t), x.du - s.gravity * t, x.w + x.dw * t, x.dw};
}

// Damped oscillator ÿ + 2λ ẏ + κ y = 0 at time t (Eq. A4 with cosine and sine amplitudes).
HL_FN void oscillate(double kappa, double lambda, double t, double& y, double& dy) {
    const double square = kappa - lambda * lambda;
    const double slope = dy + lambda * y;
    if (square > 0.0) {
        const double omega = math::sqrt(square);
        const auto a = math::sincos(omega * t);
        const double decay = math::exp(-lambda * t);
        const double now = decay * (y * a.cos + slope * (a.sin / omega));
        dy = decay * (slope * a.cos - y * omega * a.sin) - lambda * now;
        y = now;
    } else {
        const double omega = math::sqrt(-square),
                     slow = kappa / (lambda + omega);  // λ − Ω without cancellation
        const double decay = math::exp(-slow * t), fast = math::exp(-2.0 * omega * t);
        const double cosh = 0.5 * (1.0 + fast);
        const double sinh = omega * t > 1e-8 ? 0.5 * (1.0 - fast) / omega : t;
        const double now = decay * (y * cosh + slope * sinh);
        dy = decay * (slope * cosh + y * (omega * omega * sinh)) - lambda * now;
        y = now;
    }
}

// State after a time t of motion B, in closed form.
HL_FN Gaps floor_motion(const TwoBall& s, const Gaps& x, double t) {
    const double u0 = -s.gravity / s.a1;
    double y = x.u - u0, dy = x.du;
    oscillate(s.a1, 0.5 * s.a1 * s.c1, t, y, dy);
    const double upper = x.u + x.w, upper_rate = x.du + x.dw;  // the upper ball falls freely
    const double u = u0 + y;
    return {u, dy, (upper + t * (upper_rate - 0.5 * s.gravity * t)) - u, (upper_rate - s.gravity * t) - dy};
}

// State after a time t while only the pair is in contact, in closed form: ẅ = −L2, ü = −g + a2 L2.
HL_FN Gaps pair_motion(const TwoBall& s, const Gaps& x, double t) {
    double w = x.w, dw = x.dw;
    oscillate(1.0, 0.5 * s.c2, t, w, dw);
    const Gaps free = free_motion<double>(s, x, t);
    return {free.u - s.a2 * (w - free.w), free.du - s.a2 * (dw - x.dw), w, dw};
}

}  // namespace exact

}  // namespace hardlimit::column
