// Vector kernel for two-ball drops under the viscoelastic law: one drop in each lane of a vector.
//
// In the units of an elastic impact of the pair (viscoelastic_scaling.hpp) and with compressions ξ = −gap, their
// rates v and f = ξ + c v, the equations of motion (1: floor, 2: pair; forces F = √ξ f of closed contacts only) are
//   v1' = G − a1 F1 + a2 F2,      v2' = a1 F1 − F2,
// so that the event functions are those of linear_kernel.hpp. Only the steps differ. With a the closed contact that is
// nearest to its onset, and b the other contact,
//   ξ_a = s²,  dt = s dτ:   ds/dτ = v_a/2,   dξ_b/dτ = s v_b,   dv/dτ = s G + k_a ξ_a f_a + k_b s F_b,
// which is polynomial except for √ξ_b and therefore smooth through the onset and the end of contact a. The Taylor
// series of this system about the current state is computed by recurrence. Its last terms determine the length of the
// step, and each event is the first zero of a polynomial. The root √ξ_b limits the step where b is near its onset; b
// then becomes contact a.
//
// A drop that needs too many steps is solved by the general solver (Status::unsolved). A drop whose energy is too small
// to end any contact is at rest (Status::rests).
#pragma once
#include "lane_state.hpp"

namespace hardlimit::sweep {

namespace viscoelastic {

using namespace lanes;

inline constexpr int order = 15;
inline constexpr double most_steps = 3000.0;
inline constexpr double elastic = 1e-12;  // damping time below which the force ends with the compression
inline constexpr double first_touch =
    0.02;  // step in τ within which the force of a pair that touches at rate 0 is below rounding

// Divides a polynomial that the last event set to zero at τ = 0 by τ, repeatedly if its slope there is also zero.
template <int D, class R>
HL_FN_APART void leave_zero(R* f, Mask<R> at_zero) {
    for (int i = 0; i < D && any(at_zero); ++i) {
        HL_ROLL
        for (int n = 0; n < D; ++n) f[n] = select<R>(at_zero, f[n + 1], f[n]);
        f[D] = select<R>(at_zero, R{}, f[D]);
        at_zero = at_zero & (f[0] == 0.0);
    }
}

// Σ least(f_n) x^n, n = first … D; by Horner's rule on every second coefficient.
template <int D, int first, class R, class Least>
HL_FN R tail(const R* f, R x, Least least) {
    const R x2 = x * x;
    R part[2] = {};
    HL_UNROLL
    for (int n = D; n >= first; --n) {
        R& sum = part[(n - first) % 2];
        sum = n > D - 2 ? least(f[n]) : sum * x2 + least(f[n]);
    }
    return part[0] + part[1] * x;
}

// Whether a positive polynomial may fall to zero in [0, h]. It cannot if its quadratic part plus its other negative
// terms is positive.
template <int D, class R>
HL_FN_APART Mask<R> may_fall(const R* f, R h) {
    const R square = h * h;
    const R rest = tail<D, 3>(f, h, [](R x) { return math::min<R>(x, R{}); }) * (square * h);
    const R drop = f[1] * f[1] / (4.0 * f[2]), end = f[0] + h * (f[1] + h * f[2]);
    const Mask<R> vertex = (f[1] < 0.0) & (f[1] + 2.0 * (f[2] * h) > 0.0);
    const R least = select<R>(vertex, f[0] - drop, math::min<R>(f[0], end));
    return (f[0] > 0.0) & (least + rest <= 0.0);
}

// First τ in [0, h] at which a positive polynomial falls to zero; `never` if it does not. Each step goes to the zero of
// a parabola that lies below the polynomial (from a lower bound on its second derivative on [0, h]), so no zero is
// missed.
template <int D, class R>
HL_FN_APART R falls_anyhow(const R* f, R h, Mask<R> active) {
    R bound = R{};
    HL_UNROLL
    for (int n = D; n >= 3; --n) bound = (bound + (n * (n - 1.0)) * math::min<R>(f[n], R{})) * h;
    bound = bound + 2.0 * f[2];
    R tau = R{}, found = constant<R>(never);
    for (int i = 0; i < 200 && any(active); ++i) {
        const R value = column::exact::value_at<D>(f, tau), slope = column::exact::slope_at<D>(f, tau);
        const Mask<R> there = active & (value <= 0.0);
        const R square = slope * slope - 2.0 * bound * value;
        const R speed = math::sqrt<R>(math::max<R>(square, R{})) - slope;
        const R step = 2.0 * value / speed;
        const R moved = tau + step;
        found = select<R>(there, tau, found);
        active = active & negation(there) & (square >= 0.0) & (speed > 0.0) & (moved <= h);
        tau = select<R>(active, moved, tau);
        const Mask<R> converged = active & (step <= (4.0 * math::epsilon) * moved);
        found = select<R>(converged, tau, found);
        active = active & negation(converged);
    }
    return select<R>(active, tau, found);
}

// The same, faster: Halley's method from the zero of a parabola. The result is the first zero if the polynomial
// decreases monotonically to it or is concave; otherwise falls_anyhow() is used.
template <int D, class R>
HL_FN_APART R falls(const R* f, R h, Mask<R> active) {
    using column::exact::slope_at, column::exact::value_at;
    R rate[D];
    HL_UNROLL
    for (int n = 0; n < D; ++n) rate[n] = (n + 1.0) * f[n + 1];
    const R square = f[1] * f[1] - 4.0 * (f[0] * f[2]);
    R tau = 2.0 * f[0] / (math::sqrt<R>(math::max<R>(square, R{})) - f[1]);
    tau = select<R>((tau > 0.0) & (tau < h), tau, h);
    Mask<R> near = negation(active);
    R last = R{};
    for (int i = 0; i < 4 && any(active & negation(near)); ++i) {
        const R value = value_at<D>(f, tau), slope = value_at<D - 1>(rate, tau);
        const R bend = slope_at<D - 1>(rate, tau);
        const R step = 2.0 * (value * slope) / (2.0 * (slope * slope) - value * bend);
        tau = select<R>(near, tau, tau - step);
        // Accept only cubic convergence; at a nearly double zero there is none.
        const R size = math::abs<R>(step);
        near = near | ((size < 2e-4 * tau) & (size < 0.02 * last));
        last = size;
    }
    const auto rising = [](R x) { return math::max<R>(x, R{}); };
    Mask<R> good = near & (tau > 0.0) & (tau <= h);
    const Mask<R> steep = rate[0] + tau * tail<D - 1, 1>(rate, tau, rising) < 0.0;
    if (any(active & good & negation(steep))) {
        R bend[D - 1];
        HL_UNROLL
        for (int n = 0; n < D - 1; ++n) bend[n] = (n + 1.0) * rate[n + 1];
        good = good & (steep | (bend[0] + tau * tail<D - 2, 1>(bend, tau, rising) < 0.0));
    }
    const Mask<R> doubtful = active & negation(good);
    R found = select<R>(active & good, tau, constant<R>(never));
    if (any(doubtful)) found = select<R>(doubtful, falls_anyhow<D, R>(f, h, doubtful), found);
    return found;
}

// Binary logarithm and exponential from the exponent bits, linear in between; errors 0.09 and 6 %.
template <class R>
HL_FN R rough_log2(R x) {
    return (real_of<R>((bits_of<R>(x) >> 32) | 0x4330000000000000ULL) - 4503599627370496.0) * 0x1p-20 -
           1023.0;
}
template <class R>
HL_FN R rough_exp2(R y) {
    return real_of<R>(bits_of<R>((y + 1023.0) * 0x1p20 + 4503599627370496.0) << 32);
}

// Cauchy products for orders n (even) and n + 1 together, so that each factor is read once. The sums run over the
// coefficients below order n; inner() adds the newest coefficients.
template <class R>
struct Sums {
    R now{}, next{};
    // Σ x_i y_{n−i}, i = 1 … n − 1, and Σ x_i y_{n+1−i}, i = 2 … n − 1.
    HL_FN void gather(const R* x, const R* y, int n) {
        if (n < 2) return;
        now = x[1] * y[n - 1];
        if (n > 2) next = x[2] * y[n - 1];
        HL_UNROLL
        for (int m = n - 2; m >= 1; --m) {
            now = now + x[n - m] * y[m];
            if (m > 1) next = next + x[n + 1 - m] * y[m];
        }
    }
    // The same for x = y.
    HL_FN void gather_square(const R* x, int n) {
        if (n < 2) return;
        now = x[n / 2] * x[n / 2];
        if (n > 2) {
            R sum = x[1] * x[n - 1];
            next = x[2] * x[n - 1];
            HL_UNROLL
            for (int i = 2; 2 * i < n; ++i) {
                sum = sum + x[i] * x[n - i];
                next = next + x[i + 1] * x[n - i];
            }
            now = now + (sum + sum);
        }
    }
    // Σ x_i y_{n−i}, i = 1 … n − 1, for either parity of n.
    HL_FN R inner(const R* x, const R* y, int n) const {
        if (n % 2 == 0) return now;
        return n == 1 ? R{} : next + (x[1] * y[n - 1] + x[n - 1] * y[1]);
    }
    HL_FN R inner_square(const R* x, int n) const {
        if (n % 2 == 0) return now;
        const R half = next + x[1] * x[n - 1];
        return half + half;
    }
};

// Taylor coefficients in τ of s, t, ξ_a, v_a, ξ_b and v_b.
template <class R>
struct Expansion {
    static constexpr int N = order;
    R s[N + 1], t[N + 1], xa[N + 1], va[N + 1], xb[N + 1], vb[N + 1];
};

// Constants of the two equations: dv_a/dτ = s Ga − Kaa ξ_a f_a + Kab s F_b, and so on.
template <class R>
struct Couplings {
    R ca, cb, Ga, Gb, Kaa, Kab, Kba, Kbb;
    HL_FN Couplings(const Groups<R>& s, Mask<R> floor_first) {
        const R one = constant<R>(1.0);
        ca = select<R>(floor_first, s.c1, s.c2);
        cb = select<R>(floor_first, s.c2, s.c1);
        Ga = select<R>(floor_first, s.gravity, R{});
        Gb = select<R>(floor_first, R{}, s.gravity);
        Kaa = select<R>(floor_first, s.a1, one);
        Kba = select<R>(floor_first, s.a1, s.a2);
        Kab = select<R>(floor_first, s.a2, s.a1);
        Kbb = select<R>(floor_first, one, s.a1);
    }
};

// Computes the Taylor coefficients of all orders from those of order 0. Terms that do not depend on the newest
// velocities are summed first, to shorten the chain of dependent operations from one order to the next. Lanes with a
// single closed contact need only half the work, but separate code for them costs as much through instruction-cache
// misses.
template <class R>
HL_FN_APART void expand(const Couplings<R>& k, Mask<R> b_closed, Expansion<R>& p) {
    constexpr int N = order;
    R fa[N], fb[N], root[N], force[N];
    Sums<R> s_s, xa_fa, s_vb, root_root, root_fb, s_force;
    const R s0 = p.s[0], xa0 = s0 * s0;
    p.xa[0] = xa0;
    fa[0] = xa0 + k.ca * p.va[0];
    const R Kab = select<R>(b_closed, k.Kab, R{}), Kbb = select<R>(b_closed, k.Kbb, R{});
    root[0] = math::sqrt<R>(select<R>(b_closed, p.xb[0], constant<R>(1.0)));
    fb[0] = p.xb[0] + k.cb * p.vb[0];
    force[0] = root[0] * fb[0];
    const R half = 0.5 / root[0], brake = (s0 * root[0]) * k.cb;
    const R twice = s0 + s0, lead = xa0 + fa[0], drag = xa0 * k.ca;
    HL_UNROLL
    for (int n = 0; n < N; ++n) {
        const double inverse = 1.0 / (n + 1.0);
        if (n % 2 == 0) {
            s_s.gather_square(p.s, n);
            xa_fa.gather(p.xa, fa, n);
            s_vb.gather(p.s, p.vb, n);
            root_root.gather_square(root, n);
            root_fb.gather(root, fb, n);
            s_force.gather(p.s, force, n);
        }
        R push = xa0 * xa0, cross = s0 * p.vb[0];
        if (n > 0) {
            p.xa[n] = twice * p.s[n];
            if (n > 1) p.xa[n] = p.xa[n] + s_s.inner_square(p.s, n);
            push = p.xa[n] * lead;
            cross = s0 * p.vb[n] + p.s[n] * p.vb[0];
            if (n > 1) {
                push = push + xa_fa.inner(p.xa, fa, n);
                cross = cross + s_vb.inner(p.s, p.vb, n);
            }
            fa[n] = p.xa[n] + k.ca * p.va[n];
        }
        R free = root[0] * p.xb[0], other = s0 * free;  // terms of the force without the newest velocity
        if (n > 0) {
            const R xb = select<R>(b_closed, p.xb[n], R{});
            root[n] = (n > 1 ? xb - root_root.inner_square(root, n) : xb) * half;
            free = root[0] * p.xb[n] + root[n] * fb[0];
            if (n > 1) free = free + root_fb.inner(root, fb, n);
            other = p.s[n] * force[0];
            if (n > 1) other = other + s_force.inner(p.s, force, n);
            other = other + s0 * free;
            fb[n] = p.xb[n] + k.cb * p.vb[n];
            force[n] = free + (root[0] * k.cb) * p.vb[n];
        }
        other = other + brake * p.vb[n];
        push = push + drag * p.va[n];
        const R a = (p.s[n] * k.Ga - k.Kaa * push) + Kab * other;
        const R b = (p.s[n] * k.Gb + k.Kba * push) - Kbb * other;
        p.t[n + 1] = p.s[n] * inverse;
        p.s[n + 1] = p.va[n] * (0.5 * inverse);
        p.xb[n + 1] = cross * inverse;
        p.va[n + 1] = a * inverse;
        p.vb[n + 1] = b * inverse;
    }
    if constexpr (N % 2 == 0) s_s.gather_square(p.s, N);
    p.xa[N] = twice * p.s[N] + s_s.inner_square(p.s, N);
}

// Step for which the last terms stay below the tolerance. The weights convert errors of lengths to errors of
// velocities: that of s by about 2s √(1.5s), which is 0.4 while the balls oscillate, that of ξ_b by the frequency of
// contact b. The factors 0.25 and 0.125 below are of this order.
template <class R>
HL_FN R length(const Expansion<R>& p, R log2_of_tolerance) {
    R log_h = constant<R>(40.0);
    for (int n = order - 2; n <= order; ++n) {
        const R speeds = math::max<R>(math::abs<R>(p.va[n]), math::abs<R>(p.vb[n]));
        const R lengths = math::max<R>(0.25 * math::abs<R>(p.s[n]), 0.125 * math::abs<R>(p.xb[n]));
        const R largest = math::max<R>(math::max<R>(speeds, lengths), constant<R>(1e-300));
        log_h = math::min<R>(log_h, (log2_of_tolerance - rough_log2<R>(largest)) * (1.0 / n));
    }
    return rough_exp2<R>(math::max<R>(log_h, constant<R>(-1000.0)));
}

// Lanes in which gravity keeps both contacts closed forever (energy criterion of column/general/rest.hpp, in units of
// m_eff V²). A contact with the force K √ξ f under the weight W has the energy B(ξ) = 0.4 K ξ^(5/2) − W ξ + 0.6 W ξs
// above its equilibrium K ξs^(3/2) = W. It can end only at ξ + c ξ̇ = 0. At ξ < ξs/2 this requires at least the energy
// B(ξs/2), at ξ > ξs/2 a kinetic energy of at least m (ξs/2c)²/2.
template <class R>
HL_FN_APART Mask<R> at_rest(const State<R>& q, Mask<R> m) {
    const R lower = 1.0 / q.s.a2, upper = 1.0 / (1.0 - q.s.a2);  // masses
    const R K[2] = {q.s.a1 * lower, constant<R>(1.0)},
            W[2] = {q.s.gravity * (lower * upper), q.s.gravity * upper};
    const R x[2] = {-q.x.u, -q.x.w}, v[2] = {-q.x.du, -q.x.dw}, c[2] = {q.s.c1, q.s.c2},
            mass[2] = {lower, constant<R>(1.0)};
    R s[2];
    for (int j = 0; j < 2; ++j) s[j] = math::sqrt<R>(math::max<R>(x[j], R{}));
    const R climb = v[0] + v[1];
    R energy = 0.5 * (lower * (v[0] * v[0]) + upper * (climb * climb)), barrier = constant<R>(never);
    for (int j = 0; j < 2; ++j) {
        const R depth = math::exp<R>(math::log<R>(W[j] / K[j]) * (2.0 / 3.0));
        const R reach = 0.5 * depth / math::max<R>(c[j], constant<R>(1e-100));
        energy = energy + ((0.4 * K[j]) * (x[j] * x[j] * s[j]) + W[j] * (0.6 * depth - x[j]));
        // B(ξs/2) = W ξs (0.4/2^{5/2} − 0.5 + 0.6) = 0.1707 W ξs.
        barrier =
            math::min<R>(barrier, math::min<R>(0.17 * (W[j] * depth), 0.5 * (mass[j] * (reach * reach))));
    }
    return m & (energy < 0.99 * barrier);
}

template <class R>
HL_FN Mask<R> rests(const State<R>& q, Mask<R> m) {
    m = m & q.floor & q.pair & (q.s.gravity > 0.0) & (q.pieces > 20.0);
    const R upper = 1.0 - q.s.a2;  // 1/mass
    // Quick test: the contact force over the weight is between 0.7 and 1.3. Written with squares to avoid roots and
    // divisions.
    const R f1 = (q.s.a1 * upper) * (q.x.u + q.s.c1 * q.x.du), f2 = upper * (q.x.w + q.s.c2 * q.x.dw);
    const R square = q.s.gravity * q.s.gravity, carried1 = -(f1 * f1) * q.x.u, carried2 = -(f2 * f2) * q.x.w;
    m = m & (f1 < 0.0) & (f2 < 0.0) & (carried1 > 0.49 * square) & (carried1 < 1.69 * square) &
        (carried2 > 0.49 * square) & (carried2 < 1.69 * square);
    return any(m) ? at_rest<R>(q, m) : m;
}

// One step of all active lanes; each has a closed contact. The tolerance is in units of the impact speed and of the
// pair's compression.
template <class R>
HL_FN_APART void step(State<R>& q, Mask<R>& resting, double log2_tolerance) {
    constexpr int N = order;
    using column::exact::value_at;
    using M = Mask<R>;
    const M m = q.active;
    const R x1 = -q.x.u, v1 = -q.x.du, x2 = -q.x.w, v2 = -q.x.dw;
    // Contact a is the one nearest in time to its onset or its end.
    const R near1 = x1 * (math::abs<R>(v2) + x2);
    const R near2 = x2 * (math::abs<R>(v1) + math::sqrt<R>(q.s.a1) * x1);
    const M first = q.floor & (negation(q.pair) | (near1 < near2));
    const M b_closed = q.floor & q.pair;
    const M b_open = negation(b_closed) & select<M>(first, q.pair_open, q.floor_open);
    const M b_slack = negation(b_closed | b_open);
    const M touching = m & q.floor & negation(q.pair) & q.pair_open & q.on_w & (q.x.dw == 0.0);
    const Couplings<R> k(q.s, first);
    Expansion<R> p;
    p.s[0] = math::sqrt<R>(math::max<R>(select<R>(first, x1, x2), R{}));
    p.t[0] = R{};
    p.va[0] = select<R>(first, v1, v2);
    p.xb[0] = select<R>(first, x2, x1);
    p.vb[0] = select<R>(first, v2, v1);
    expand<R>(k, b_closed, p);
    // Smaller tolerance before the first floor touch, since a long fall amplifies velocity errors.
    R h = length<R>(p, select<R>(q.t < 0.0, constant<R>(log2_tolerance - 12.0), constant<R>(log2_tolerance)));
    h = select<R>(touching, math::min<R>(h, constant<R>(first_touch)), h);

    // Event functions as polynomials that fall to zero. A contact without damping ends at zero compression.
    const M on_a = select<M>(first, q.on_u, q.on_w), on_b = select<M>(first, q.on_w, q.on_u);
    const M on_la = select<M>(first, q.on_l1, q.on_l2), on_lb = select<M>(first, q.on_l2, q.on_l1);
    const M root_a = k.ca < elastic, root_b = k.cb < elastic;
    const M forced = b_closed & negation(root_b);
    const R sign = select<R>(b_open, constant<R>(-1.0), constant<R>(1.0)),
            damped = select<R>(forced, k.cb, R{});
    R fa[N + 1], fb[N + 1], fc[N + 1];  // end of a; onset, end or opening of b; b engages
    HL_ROLL
    for (int n = 0; n <= N; ++n) {
        fa[n] = p.xa[n] + k.ca * p.va[n];
        fb[n] = sign * p.xb[n] + damped * p.vb[n];
    }
    if (any(m & root_a)) HL_ROLL
    for (int n = 0; n <= N; ++n) fa[n] = select<R>(root_a, p.s[n], fa[n]);
    leave_zero<N, R>(fa, m & select<M>(root_a, on_a, on_la));
    leave_zero<N, R>(fb, m & select<M>(forced, on_lb, on_b));
    const M watched = m & negation(touching), slack = m & b_slack;
    M due_a = m & may_fall<N, R>(fa, h), due_b = watched & may_fall<N, R>(fb, h), due_c{};
    M zero_a = m & (fa[0] <= 0.0), zero_b = watched & (fb[0] <= 0.0), zero_c = due_c;
    if (any(slack)) {
        HL_ROLL
        for (int n = 0; n <= N; ++n) fc[n] = -(p.xb[n] + k.cb * p.vb[n]);
        leave_zero<N, R>(fc, slack & on_lb);
        due_c = slack & may_fall<N, R>(fc, h);
        zero_c = slack & (fc[0] <= 0.0);
    }
    R tau = h;
    M hit_a{}, hit_b{}, again{};
    if (any(due_a | due_b | due_c | zero_a | zero_b | zero_c)) {
        const R none = constant<R>(never);
        R end_a = select<R>(zero_a, R{}, none), main_b = select<R>(zero_b, R{}, none),
          press_b = select<R>(zero_c, R{}, none);
        while (any(due_a | due_b | due_c)) {  // a lane with several candidate events needs several rounds
            const M search_b = due_b & negation(due_a), search_c = due_c & negation(due_a | due_b);
            R f[N + 1];
            HL_ROLL
            for (int n = 0; n <= N; ++n) f[n] = select<R>(search_b, fb[n], fa[n]);
            if (any(search_c)) HL_ROLL
            for (int n = 0; n <= N; ++n) f[n] = select<R>(search_c, fc[n], f[n]);
            const R zero = falls<N, R>(f, h, due_a | due_b | due_c);
            assign<R>(due_a, end_a, zero);
            assign<R>(search_b, main_b, zero);
            assign<R>(search_c, press_b, zero);
            clear(due_c, search_c);
            clear(due_b, search_b);
            due_a = M{};
        }
        const R now = math::min<R>(math::min<R>(end_a, main_b), press_b);
        const M hit = m & (now != never);
        hit_a = hit & (end_a == now);
        again = hit & negation(hit_a) & (press_b == now);
        hit_b = hit & negation(hit_a | again);
        tau = select<R>(hit, now, h);
    }
    R s = value_at<N>(p.s, tau);
    // With little damping a contact ends so shortly before s = 0 that the series may have missed it.
    const M passed = m & (s < 0.0) & (p.s[0] > 0.0);
    if (any(passed)) {
        const R zero = falls<N, R>(p.s, tau, passed);
        const M found = passed & (zero != never);
        raise(hit_a, found);
        clear(hit_b, found);
        clear(again, found);
        tau = select<R>(found, zero, tau);
        s = select<R>(found, R{}, s);
    }
    const M hit = hit_a | hit_b | again;

    const R xa = s * s, va = value_at<N>(p.va, tau);
    const R xb = value_at<N>(p.xb, tau), vb = value_at<N>(p.vb, tau), dt = value_at<N>(p.t, tau);
    const GapState<R> y = {-select<R>(first, xa, xb), -select<R>(first, va, vb), -select<R>(first, xb, xa),
                           -select<R>(first, vb, va)};
    advance<R>(q, m, dt, y);
    assign<R>(m, q.pieces, q.pieces + 1.0);
    const R sum = (q.x.u + q.x.du) + (q.x.w + q.x.dw) + q.t;
    const M lost = m & negation(((sum - sum) == 0.0) & (q.pieces < most_steps));
    raise(q.unsolved, lost);
    finish<R>(q, lost);
    const M still = rests<R>(q, m & q.active & negation(hit));
    raise(resting, still);
    finish<R>(q, still);
    assign<R>(still, q.t_end, constant<R>(math::nan));
    assign<R>(still, q.relative, R{});
    assign<R>(still, q.separation, R{});

    const M touched = touching & q.active & negation(hit);
    if (!any(hit | touched)) return;
    const M second = negation(first), go = q.active;
    if (any(touched)) {
        pair_begins<R>(q, touched);
        assign<R>(touched, q.x.w, y.w);
        clear(q.on_w, touched);
        clear(q.on_l2, touched);
    }
    floor_ends<R>(q, go & ((hit_a & first) | (hit_b & second & b_closed)));
    pair_ends<R>(q, go & ((hit_a & second) | (hit_b & first & b_closed)));
    floor_begins<R>(q, go & second & ((hit_b & b_open) | again));
    pair_begins<R>(q, go & first & ((hit_b & b_open) | again));
    floor_opens<R>(q, go & hit_b & second & b_slack);
    pair_opens<R>(q, go & hit_b & first & b_slack);
}

}  // namespace viscoelastic

// Solves the drops of a batch.
template <class R>
HL_FN void solve_viscoelastic_batch(const Batch& b, double log2_tolerance) {
    using namespace lanes;
    constexpr int W = Lanes<R>::count;
    State<R> q{};
    Mask<R> resting{};  // lanes whose drop has come to rest
    int drop[W];
    for (int& none : drop) none = -1;
    int next = 0;
    for (;;) {
        for (;;) {
            const Mask<R> free = q.active & negation(q.floor | q.pair);
            if (!any(free)) break;
            free_motion<R>(q, free);
        }
        const int running = count(q.active);
        if (running == 0 || (W - running >= due<R>(b, next, W) && next < b.count)) {
            Mask<R> loaded{};
            for (int lane = 0; lane < W; ++lane) {
                if (lane_of(q.active, lane)) continue;
                if (drop[lane] >= 0) store(q, lane, b, drop[lane]);
                if (lane_of(resting, lane)) b.status[drop[lane]] = static_cast<int>(Status::rests);
                set_flag(resting, lane, false);
                drop[lane] = -1;
                if (next == b.count) continue;
                load(q, lane, b, next);
                drop[lane] = next++;
                set_flag(loaded, lane, true);
            }
            if (any(loaded)) {
                start<R>(q, loaded);
                continue;
            }
            if (running == 0) break;
        }
        viscoelastic::step<R>(q, resting, log2_tolerance);
    }
}

}  // namespace hardlimit::sweep
