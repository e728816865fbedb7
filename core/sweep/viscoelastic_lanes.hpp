// Many two-ball drops under the viscoelastic law at once, one drop in each lane of a vector.
//
// In the units of an elastic impact of the pair (two_ball.hpp) and with compressions ξ = −gap, their rates v and
// f = ξ + c v, the equations of motion (1: floor, 2: pair; forces F = √ξ f of closed contacts only) are
//   v1' = G − a1 F1 + a2 F2,      v2' = a1 F1 − F2,
// so that every switch is defined as in lanes.hpp, on the same functions. Only the steps are others: with the closed
// contact a that is nearest to its onset, and b the other one,
//   ξ_a = s²,  dt = s dτ:   ds/dτ = v_a/2,   dξ_b/dτ = s v_b,   dv/dτ = s G + k_a ξ_a f_a + k_b s F_b,
// which is polynomial but for √ξ_b and therefore smooth through the onset and the end of contact a. The Taylor series
// of this system about the present state is summed by recurrence, its last terms give the length of the step, and
// every switch within is the first zero of a polynomial. The root √ξ_b limits the step where b comes near its own
// onset, which then makes it contact a.
//
// A drop that needs too many steps is left to the general solver (Status::left); one whose contacts never end is
// known by its energy (Status::rests).
#pragma once
#include "lane_state.hpp"

namespace hardlimit::sweep {

namespace viscoelastic {

using namespace lanes;

inline constexpr int order = 15;
// Of a step (6e-11), in units of the impact speed and of the pair's compression.
inline constexpr double log2_tolerance = -34.0;
inline constexpr double most_steps = 3000.0;
inline constexpr double elastic = 1e-12;     // damping time below which the force ends with the compression
inline constexpr double first_touch = 0.02;  // τ in which a pair that only touches feels less than rounding

// Divides a polynomial that the last switch put on zero at τ = 0 by τ; again if it touches without approach.
template <int D, class R>
HL_FN void leave_zero(R* f, Mask<R> at_zero) {
    for (int i = 0; i < D && any(at_zero); ++i) {
        for (int n = 0; n < D; ++n) f[n] = select<R>(at_zero, f[n + 1], f[n]);
        f[D] = select<R>(at_zero, R{}, f[D]);
        at_zero = at_zero & (f[0] == 0.0);
    }
}

// Whether a positive polynomial may fall to zero in [0, h]: not if a parabola and the falling ones among its other
// terms leave it positive.
template <int D, class R>
HL_FN Mask<R> may_fall(const R* f, R h) {
    R rest = R{};
    HL_UNROLL
    for (int n = D; n >= 3; --n) rest = (rest + math::min<R>(f[n], R{})) * h;
    rest = rest * (h * h);
    const R drop = f[1] * f[1] / (4.0 * f[2]), end = f[0] + h * (f[1] + h * f[2]);
    const Mask<R> vertex = (f[1] < 0.0) & (f[1] + 2.0 * (f[2] * h) > 0.0);
    const R least = select<R>(vertex, f[0] - drop, math::min<R>(f[0], end));
    return (f[0] > 0.0) & (least + rest <= 0.0);
}

// First τ in [0, h] at which a positive polynomial falls to zero; `never` if it does not. Each step goes to the zero of
// a parabola below it (its second derivative, bounded from below on [0, h]), so no zero can be passed.
template <int D, class R>
HL_FN R falls(const R* f, R h, Mask<R> active) {
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

// Binary logarithm and power by the bits of the exponent and a straight line in between, to 0.09 and 6 %.
template <class R>
HL_FN R rough_log2(R x) {
    return (real_of<R>((bits_of<R>(x) >> 32) | 0x4330000000000000ULL) - 4503599627370496.0) * 0x1p-20 -
           1023.0;
}
template <class R>
HL_FN R rough_exp2(R y) {
    return real_of<R>(bits_of<R>((y + 1023.0) * 0x1p20 + 4503599627370496.0) << 32);
}

// Σ x_i y_{n−i}, the two products with a newest factor last: all others need not wait for it.
template <class R>
HL_FN R product(const R* x, const R* y, int n) {
    if (n == 0) return x[0] * y[0];
    R sum = x[0] * y[n] + x[n] * y[0];
    if (n == 1) return sum;
    R inner = x[1] * y[n - 1];
    HL_UNROLL
    for (int i = 2; i < n; ++i) inner = inner + x[i] * y[n - i];
    return inner + sum;
}
// Σ x_i x_{n−i} without the terms of x_0.
template <class R>
HL_FN R inner_square(const R* x, int n) {
    R sum = R{};
    HL_UNROLL
    for (int i = 1; 2 * i < n; ++i) sum = sum + x[i] * x[n - i];
    sum = sum + sum;
    if (n > 0 && n % 2 == 0) sum = sum + x[n / 2] * x[n / 2];
    return sum;
}

// Taylor coefficients in τ.
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

// From p's coefficients of order 0. `both`: in some lanes contact b is closed, too.
template <bool both, class R>
HL_FN void expand(const Couplings<R>& k, Mask<R> b_closed, Expansion<R>& p) {
    constexpr int N = order;
    R fa[N], fb[N], root[N], force[N];
    R half{};
    if constexpr (both) {
        root[0] = math::sqrt<R>(select<R>(b_closed, p.xb[0], constant<R>(1.0)));
        half = 0.5 / root[0];
    }
    p.xa[0] = p.s[0] * p.s[0];
    HL_UNROLL
    for (int n = 0; n < N; ++n) {
        const double inverse = 1.0 / (n + 1.0);
        if (n > 0) p.xa[n] = inner_square(p.s, n) + 2.0 * (p.s[0] * p.s[n]);
        fa[n] = p.xa[n] + k.ca * p.va[n];
        const R push = product(p.xa, fa, n);
        R a = p.s[n] * k.Ga - k.Kaa * push, b = p.s[n] * k.Gb + k.Kba * push;
        if constexpr (both) {
            if (n > 0) root[n] = (p.xb[n] - inner_square(root, n)) * half;
            fb[n] = p.xb[n] + k.cb * p.vb[n];
            force[n] = select<R>(b_closed, product(root, fb, n), R{});
            const R other = product(p.s, force, n);
            a = a + k.Kab * other;
            b = b - k.Kbb * other;
        }
        p.t[n + 1] = p.s[n] * inverse;
        p.s[n + 1] = p.va[n] * (0.5 * inverse);
        p.xb[n + 1] = product(p.s, p.vb, n) * inverse;
        p.va[n + 1] = a * inverse;
        p.vb[n + 1] = b * inverse;
    }
    p.xa[N] = inner_square(p.s, N) + 2.0 * (p.s[0] * p.s[N]);
}

// Length for which the last terms stay below the tolerance.
template <class R>
HL_FN R length(const Expansion<R>& p) {
    R log_h = constant<R>(40.0);
    for (int n = order - 2; n <= order; ++n) {
        const R speeds = math::max<R>(math::abs<R>(p.va[n]), math::abs<R>(p.vb[n]));
        const R lengths = math::max<R>(math::abs<R>(p.s[n]), math::abs<R>(p.xb[n]));
        const R largest = math::max<R>(math::max<R>(speeds, lengths), constant<R>(1e-300));
        log_h = math::min<R>(log_h, (log2_tolerance - rough_log2<R>(largest)) * (1.0 / n));
    }
    return rough_exp2<R>(math::max<R>(log_h, constant<R>(-1000.0)));
}

// Gravity holds both contacts closed for good (the energy argument of column/integrate.hpp, in units of m_eff V²). A
// contact that carries K √ξ f under the weight W has the excess energy B(ξ) = 0.4 K ξ^(5/2) − W ξ + 0.6 W ξs above its
// equilibrium K ξs^(3/2) = W. It can end only at ξ + c ξ̇ = 0, which at ξ < ξs/2 takes at least B(ξs/2) and at
// ξ > ξs/2 a kinetic energy of at least m (ξs/2c)²/2. Only asked where both carry about their weight already.
template <class R>
HL_FN Mask<R> rests(const State<R>& q, Mask<R> m) {
    const R lower = 1.0 / q.s.a2, upper = 1.0 / (1.0 - q.s.a2);  // masses
    const R K[2] = {q.s.a1 * lower, constant<R>(1.0)},
            W[2] = {q.s.gravity * (lower * upper), q.s.gravity * upper};
    const R x[2] = {-q.x.u, -q.x.w}, v[2] = {-q.x.du, -q.x.dw}, c[2] = {q.s.c1, q.s.c2},
            mass[2] = {lower, constant<R>(1.0)};
    R s[2];
    m = m & q.floor & q.pair & (q.s.gravity > 0.0) & (q.pieces > 20.0);
    if (!any(m)) return m;
    for (int j = 0; j < 2; ++j) {
        s[j] = math::sqrt<R>(math::max<R>(x[j], R{}));
        m = m & (math::abs<R>(K[j] * (s[j] * (x[j] + c[j] * v[j])) - W[j]) < 0.3 * W[j]);
    }
    if (!any(m)) return m;
    const R climb = v[0] + v[1];
    R energy = 0.5 * (lower * (v[0] * v[0]) + upper * (climb * climb)), barrier = constant<R>(never);
    for (int j = 0; j < 2; ++j) {
        const R depth = math::exp<R>(math::log<R>(W[j] / K[j]) * (2.0 / 3.0));
        const R reach = 0.5 * depth / math::max<R>(c[j], constant<R>(1e-100));
        energy = energy + ((0.4 * K[j]) * (x[j] * x[j] * s[j]) + W[j] * (0.6 * depth - x[j]));
        barrier =
            math::min<R>(barrier, math::min<R>(0.17 * (W[j] * depth), 0.5 * (mass[j] * (reach * reach))));
    }
    return m & (energy < 0.99 * barrier);
}

// One step of the lanes of m, in each of which a contact is closed; without `both` it is only one.
template <bool both, class R>
HL_FN void step(State<R>& q, Mask<R>& resting, Mask<R> m) {
    constexpr int N = order;
    using column::exact::value_at;
    using M = Mask<R>;
    const R x1 = -q.x.u, v1 = -q.x.du, x2 = -q.x.w, v2 = -q.x.dw;
    // Nearest to its onset: by the time that has passed or will, or its own period.
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
    expand<both, R>(k, b_closed, p);
    R h = length<R>(p);
    h = select<R>(touching, math::min<R>(h, constant<R>(first_touch)), h);

    // Each switch as a polynomial that falls to zero. A contact without damping ends with its compression.
    const M on_a = select<M>(first, q.on_u, q.on_w), on_b = select<M>(first, q.on_w, q.on_u);
    const M on_la = select<M>(first, q.on_l1, q.on_l2), on_lb = select<M>(first, q.on_l2, q.on_l1);
    const M root_a = k.ca < elastic, root_b = k.cb < elastic;
    const M forced = b_closed & negation(root_b);
    const R sign = select<R>(b_open, constant<R>(-1.0), constant<R>(1.0)),
            damped = select<R>(forced, k.cb, R{});
    const R none = constant<R>(never);
    R fa[N + 1], fb[N + 1];
    HL_UNROLL
    for (int n = 0; n <= N; ++n) {
        fa[n] = select<R>(root_a, p.s[n], p.xa[n] + k.ca * p.va[n]);
        fb[n] = sign * (p.xb[n] + damped * p.vb[n]);
    }
    leave_zero<N, R>(fa, m & select<M>(root_a, on_a, on_la));
    leave_zero<N, R>(fb, m & select<M>(forced, on_lb, on_b));
    R end_a = select<R>(fa[0] <= 0.0, R{}, none), main_b = select<R>(fb[0] <= 0.0, R{}, none), press_b = none;
    const M may_a = m & may_fall<N, R>(fa, h), may_b = m & negation(touching) & may_fall<N, R>(fb, h);
    if (any(may_a | may_b)) {  // both in one search, but where both are due
        R f[N + 1];
        HL_UNROLL
        for (int n = 0; n <= N; ++n) f[n] = select<R>(may_a, fa[n], fb[n]);
        const R zero = falls<N, R>(f, h, may_a | may_b);
        end_a = select<R>(may_a, zero, end_a);
        main_b = select<R>(may_b, zero, main_b);
        if (any(may_a & may_b)) main_b = select<R>(may_a & may_b, falls<N, R>(fb, h, may_a & may_b), main_b);
    }
    main_b = select<R>(touching, none, main_b);
    if (any(m & b_slack)) {
        for (int n = 0; n <= N; ++n) fb[n] = -(p.xb[n] + k.cb * p.vb[n]);
        leave_zero<N, R>(fb, m & b_slack & on_lb);
        press_b = select<R>(fb[0] <= 0.0, R{}, falls<N, R>(fb, h, m & b_slack & may_fall<N, R>(fb, h)));
        press_b = select<R>(b_slack, press_b, none);
    }
    const R now = math::min<R>(math::min<R>(end_a, main_b), press_b);
    const M hit = m & (now != never);
    const M hit_a = hit & (end_a == now), again = hit & negation(hit_a) & (press_b == now);
    const M hit_b = hit & negation(hit_a | again);
    const R tau = select<R>(hit, now, h);

    const R s = value_at<N>(p.s, tau), xa = s * s, va = value_at<N>(p.va, tau);
    const R xb = value_at<N>(p.xb, tau), vb = value_at<N>(p.vb, tau), dt = value_at<N>(p.t, tau);
    const GapState<R> y = {-select<R>(first, xa, xb), -select<R>(first, va, vb), -select<R>(first, xb, xa),
                           -select<R>(first, vb, va)};
    advance<R>(q, m, dt, y);
    assign<R>(m, q.pieces, q.pieces + 1.0);
    const R sum = (q.x.u + q.x.du) + (q.x.w + q.x.dw) + q.t;
    const M lost = m & negation(((sum - sum) == 0.0) & (q.pieces < most_steps));
    raise(q.left, lost);
    finish<R>(q, lost);
    const M still = rests<R>(q, m & q.active & negation(hit));
    raise(resting, still);
    finish<R>(q, still);
    assign<R>(still, q.t_end, constant<R>(math::nan));
    assign<R>(still, q.relative, R{});
    assign<R>(still, q.separation, R{});

    const M second = negation(first), go = q.active;
    const M touched = touching & go & negation(hit);
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

// Solves the drops of a block.
template <class R>
HL_FN void solve_viscoelastic_block(const Block& b) {
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
            fly<R>(q, free);
        }
        bool loaded = false;
        for (int lane = 0; lane < W; ++lane) {
            if (get_flag(q.active, lane)) continue;
            if (drop[lane] >= 0) store(q, lane, b, drop[lane]);
            if (get_flag(resting, lane)) b.status[drop[lane]] = static_cast<int>(Status::rests);
            put_flag(resting, lane, false);
            drop[lane] = -1;
            if (next == b.count) continue;
            load(q, lane, b, next);
            drop[lane] = next++;
            loaded = true;
        }
        if (loaded) continue;
        if (!any(q.active)) break;
        // A step for both kinds of lanes costs about twice the step for those with a single closed contact.
        const Mask<R> coupled = q.active & q.floor & q.pair, single = q.active & negation(q.floor & q.pair);
        if (5 * count(coupled) >= 4 * count(single))
            viscoelastic::step<true, R>(q, resting, q.active);
        else
            viscoelastic::step<false, R>(q, resting, single);
    }
}

}  // namespace hardlimit::sweep
