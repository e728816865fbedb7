// Many two-ball drops at once: the exact solver of column/exact.hpp with one drop in each lane of a vector.
//
// Lanes run in step. A round takes every lane through one stage of floor contact (motion B) and one of pair contact
// (C and D), so that lanes at the same point of their sequence do the same work; a lane that is done takes the next
// drop of the block. Two kinds of step:
//   quick    one closed form (B) or one long Taylor series (C, D) to the next switch, taken only when bounds show
//            that nothing else can happen before it;
//   careful  one piece exactly as in column/exact.hpp, for whatever the bounds cannot exclude.
// Resting contacts and very long sequences are left to the scalar solver (Status::left). The result of a lane does
// not depend on its neighbours, hence neither on the width of the vector nor on the order of the drops.
#pragma once
#include "lane_state.hpp"

namespace hardlimit::sweep {

namespace lanes {

inline constexpr double most_pieces = 3000.0;

// ---- careful step ----------------------------------------------------------------------------------------------

// Gravity holds a contact closed for good: not for this solver.
template <class R>
HL_FN Mask<R> rests(const State<R>& q) {
    using namespace column::exact;
    const Mask<R> alone = q.floor & negation(q.pair) & q.pair_open & negation(q.on_w);
    return (alone & rests_on_floor<R>(q.s, q.x)) | (q.floor & q.pair & rests_on_both<R>(q.s, q.x));
}

template <class R>
HL_FN void careful(State<R>& q, Mask<R> m) {
    using namespace column::exact;
    const Mask<R> still = m & rests<R>(q);
    raise(q.left, still);
    finish<R>(q, still);
    m = m & q.active;
    if (!any(m)) return;
    Series<R> p;
    const R h = reach / rate_bound<R>(q.s, q.floor, q.pair);
    expand<R>(q.s, q.x, q.floor, q.pair, h, p);
    const R up = constant<R>(1.0), down = constant<R>(-1.0), none = constant<R>(never);
    const Mask<R> floor_slack = m & negation(q.floor | q.floor_open),
                  pair_slack = m & negation(q.pair | q.pair_open);
    // Where the contact is closed its force ends, where it is open its gap closes, where it is slack the gap opens.
    R f[order + 1];
    for (int n = 0; n < order; ++n) f[n] = select<R>(q.floor, p.l1[n], p.u[n]);
    f[order] = select<R>(q.floor, R{}, p.u[order]);
    const R at1 = first_crossing<order>(f, select<R>(negation(q.floor) & q.floor_open, down, up),
                                        select<Mask<R>>(q.floor, q.on_l1, q.on_u));
    for (int n = 0; n < order; ++n) f[n] = select<R>(q.pair, p.l2[n], p.w[n]);
    f[order] = select<R>(q.pair, R{}, p.w[order]);
    const R at2 = first_crossing<order>(f, select<R>(negation(q.pair) & q.pair_open, down, up),
                                        select<Mask<R>>(q.pair, q.on_l2, q.on_w));
    const R press1 = any(floor_slack)
                         ? select<R>(floor_slack, first_crossing<order - 1>(p.l1, down, q.on_l1), none)
                         : none;
    const R press2 =
        any(pair_slack) ? select<R>(pair_slack, first_crossing<order - 1>(p.l2, down, q.on_l2), none) : none;
    const R first = math::min<R>(math::min<R>(at1, at2), math::min<R>(press1, press2));
    const Mask<R> hit = m & (first != never);
    const R theta = select<R>(hit, first, up);
    const Mask<R> one = hit & (at1 == first), again1 = hit & negation(one) & (press1 == first);
    const Mask<R> two = hit & negation(one | again1) & (at2 == first),
                  again2 = hit & negation(one | again1 | two);
    advance<R>(q, m, theta * h, evaluate<R>(p, theta));
    assign<R>(m, q.pieces, q.pieces + 1.0);
    const Mask<R> was_floor = q.floor, was_open1 = q.floor_open, was_pair = q.pair, was_open2 = q.pair_open;
    floor_ends<R>(q, one & was_floor);
    floor_begins<R>(q, (one & negation(was_floor) & was_open1) | again1);
    floor_opens<R>(q, one & negation(was_floor | was_open1));
    pair_ends<R>(q, two & was_pair);
    pair_begins<R>(q, (two & negation(was_pair) & was_open2) | again2);
    pair_opens<R>(q, two & negation(was_pair | was_open2));
    const Mask<R> long_run = m & (q.pieces > most_pieces);
    raise(q.left, long_run);
    finish<R>(q, long_run);
}

// ---- quick step, floor only (motion B) -------------------------------------------------------------------------

// The lower ball swings, u = u* + e^(−λt) (A cos ωt + B sin ωt), the upper one falls freely.
template <class R>
struct Swing {
    R rest, lambda, omega, A, B;  // of u
    R P, Q;                       // the same of u̇: e^(−λt) (P cos ωt + Q sin ωt)
    R height, climb, gravity;     // u + w = height + climb t − gravity t²/2
    R a1, c1;

    HL_FN explicit Swing(const Groups<R>& s, const GapState<R>& x) {
        a1 = s.a1;
        c1 = s.c1;
        gravity = s.gravity;
        rest = -s.gravity / s.a1;
        lambda = 0.5 * s.a1 * s.c1;
        omega = math::sqrt<R>(math::max<R>(s.a1 - lambda * lambda, constant<R>(1e-300)));
        A = x.u - rest;
        B = (x.du + lambda * A) / omega;
        P = omega * B - lambda * A;
        Q = -(omega * A + lambda * B);
        height = x.u + x.w;
        climb = x.du + x.dw;
    }
    HL_FN GapState<R> at(R t, R decay, R cosine, R sine) const {
        const R u = rest + decay * (A * cosine + B * sine), du = decay * (P * cosine + Q * sine);
        return {u, du, (height + t * (climb - 0.5 * gravity * t)) - u, (climb - gravity * t) - du};
    }
    HL_FN GapState<R> at(R t) const {
        const math::SinCos<R> a = math::sincos<R>(omega * t);
        return at(t, math::exp<R>(-lambda * t), a.cos, a.sin);
    }
    // A short way on from the state x at t: Taylor series of u about t.
    HL_FN GapState<R> on(const GapState<R>& x, R t, R dt) const {
        constexpr int N = 10;
        R c[N + 1] = {x.u - rest, x.du};
        for (int n = 0; n + 2 <= N; ++n)
            c[n + 2] = -(a1 * (c[n] + c1 * ((n + 1.0) * c[n + 1]))) * (1.0 / ((n + 1.0) * (n + 2.0)));
        R u = c[N], du = R{};
        for (int n = N - 1; n >= 0; --n) {
            du = du * dt + u;
            u = u * dt + c[n];
        }
        u = u + rest;
        const R now = t + dt;
        return {u, du, (height + now * (climb - 0.5 * gravity * now)) - u, (climb - gravity * now) - du};
    }
    HL_FN R pull(const GapState<R>& x) const { return x.u + c1 * x.du; }  // L1
};

// A slack pair opens without its force switching on again. The floor's pull on the gap is at most M, so it opens at
// the latest at the first zero t of w + ẇ t − M t²/2, and until then L2 >= ẇ t − M (t²/2 + c2 t).
template <class R>
HL_FN Mask<R> opens_quietly(const State<R>& q, const Swing<R>& swing) {
    const R amplitude = math::sqrt<R>(swing.A * swing.A + swing.B * swing.B) +
                        swing.c1 * math::sqrt<R>(swing.P * swing.P + swing.Q * swing.Q);
    const R pull = q.s.a1 * amplitude + q.s.gravity;
    const R square = q.x.dw * q.x.dw + 2.0 * pull * q.x.w;
    const R opens = -2.0 * q.x.w / (q.x.dw + math::sqrt<R>(math::max<R>(square, R{})));
    return (q.x.dw > 0.0) & (square > 0.0) & (q.x.dw > 1.01 * pull * (0.5 * opens + q.s.c2));
}

// Lanes of m whose next switch was found: the pair closes, or the floor lets go.
template <class R>
HL_FN Mask<R> quick_floor(State<R>& q, Mask<R> m) {
    const Swing<R> swing(q.s, q.x);
    const R w0 = q.x.w, dw0 = q.x.dw;
    const Mask<R> slack = negation(q.pair_open);
    m = m & (swing.lambda * swing.lambda < 0.99 * q.s.a1) & (negation(slack) | opens_quietly<R>(q, swing));
    // Release without gravity: phase and state without trigonometry.
    const R cosine_part = swing.A + swing.c1 * swing.P, sine_part = swing.B + swing.c1 * swing.Q;
    const R down = math::max<R>(-cosine_part, R{});
    const R release = math::atan2_upper<R>(down, sine_part) / swing.omega;
    const R radius = math::sqrt<R>(down * down + sine_part * sine_part);
    const R decay = math::exp<R>(-swing.lambda * release);
    const GapState<R> r = swing.at(release, decay, sine_part / radius, down / radius);
    const R pull = swing.pull(r), pull_rate = r.du - q.s.c1 * (q.s.a1 * pull + q.s.gravity);
    const R later = -pull / pull_rate;  // what gravity adds
    const R rate = math::sqrt<R>(q.s.a1);
    m = m & (pull_rate > 0.0) & (math::abs<R>(later) * rate < 0.02) & (release > 0.0);
    const R doubt = 4.0 * math::abs<R>(r.dw * later) + 1e-9 * (math::abs<R>(r.u) + math::abs<R>(w0));
    const Mask<R> lets_go = m & (r.w > doubt), closes = m & (r.w < -doubt) & (r.dw < 0.0);
    Mask<R> handled = lets_go & negation(lets_go);
    if (any(lets_go)) {
        R dt = later;
        GapState<R> x = swing.on(r, release, dt);
        for (int i = 0; i < 3; ++i) {
            const R l1 = swing.pull(x), slope = x.du - q.s.c1 * (q.s.a1 * l1 + q.s.gravity);
            dt = dt - l1 / slope;
            x = swing.on(r, release, dt);
        }
        const Mask<R> good = lets_go & (math::abs<R>(dt) * rate < 0.05) & (x.w > 0.0);
        advance<R>(q, good, release + dt, x);
        raise(q.pair_open, good);
        floor_ends<R>(q, good);
        handled = handled | good;
    }
    if (any(closes)) {
        // Parabola through w, ẇ now and w at release, then Halley's method with ẅ = a1 L1.
        const R bend = (r.w - w0 - dw0 * release) / (release * release);
        const R root = math::sqrt<R>(math::max<R>(dw0 * dw0 - 4.0 * bend * w0, R{}));
        R t = select<R>(dw0 < 0.0, 2.0 * w0 / (root - dw0), (dw0 + root) / (-2.0 * bend));
        R step = R{};
        GapState<R> x;
        for (int i = 0; i < 3; ++i) {
            t = t + step;
            x = swing.at(t);
            const R bent = q.s.a1 * swing.pull(x);
            step = -2.0 * x.w * x.dw / (2.0 * x.dw * x.dw - x.w * bent);
        }
        const Mask<R> near = math::abs<R>(step) * rate < 0.02;
        GapState<R> y = swing.on(x, t, step);
        R last = -y.w / y.dw;
        y = swing.on(x, t, step + last);
        const R when = t + (step + last);
        const Mask<R> good = closes & near & (math::abs<R>(last) * rate < 1e-6) & (y.dw < 0.0) &
                             (swing.pull(y) < 0.0) & (when > 0.0) & (when < release) &
                             (math::abs<R>(y.w) < 1e-13);
        advance<R>(q, good, when, y);
        raise(q.pair_open, good);
        pair_begins<R>(q, good);
        handled = handled | good;
    }
    return handled;
}

// ---- quick step, pair closed (motions C and D) -----------------------------------------------------------------

inline constexpr int long_order = 38;
inline constexpr double long_reach = 5.2;  // 5.2³⁸/38! = 3e-18

// Lanes of m, with a pair contact that begins now, whose next switch is the end of that contact. L2 falls from the
// touch on, and rises once within the reach of the series (less than a period), so it has one zero there.
template <class R>
HL_FN Mask<R> quick_pair(State<R>& q, Mask<R> m) {
    const Groups<R>& s = q.s;
    m = m & q.on_w & (q.x.dw < 0.0) & (s.c2 < 1.6) & (s.a1 * s.c1 * s.c1 < 2.5) & (q.floor | q.floor_open);
    if (!any(m)) return m;
    column::exact::Series<R, long_order> p;
    const R h = constant<R>(long_reach) / math::sqrt<R>(1.0 + s.a1);
    column::exact::expand<R>(s, q.x, q.floor, q.pair, h, p);
    // Isolated contact as the guess: t_c = 2 atan2(ω, β)/ω, β = c2/2.
    const R beta = 0.5 * s.c2, omega = math::sqrt<R>(math::max<R>(1.0 - beta * beta, constant<R>(0.1)));
    R theta = math::min<R>(2.0 * math::atan2_upper<R>(omega, beta) / (omega * h), constant<R>(0.97));
    using column::exact::slope_at, column::exact::value_at;
    constexpr int rough = 24, full = long_order - 1;
    R slope = R{}, step = R{};
    for (int i = 0; i < 6; ++i) {
        slope = i < 3 ? slope_at<rough>(p.l2, theta) : slope_at<full>(p.l2, theta);
        step = -(i < 3 ? value_at<rough>(p.l2, theta) : value_at<full>(p.l2, theta)) / slope;
        theta = math::clamp<R>(theta + step, 0.05, 1.0);
    }
    m = m & (slope > 0.0) & (math::abs<R>(step) < 1e-11) & (theta < 1.0);
    // Nothing else before: L1 stays below zero by its values at both ends and a bound on its curvature; an open floor
    // gap is concave while the pair pushes.
    R curvature[full - 1];
    for (int n = 2; n <= full; ++n) curvature[n - 2] = (n * (n - 1.0)) * math::abs<R>(p.l1[n]);
    const R bound = value_at<full - 2>(curvature, theta);
    const GapState<R> x = column::exact::evaluate<R>(p, theta);
    const R worst = math::max<R>(p.l1[0], x.u + s.c1 * x.du);
    const Mask<R> stays = (worst + 0.125 * bound * theta * theta < 0.0) & negation(q.on_l1);
    const Mask<R> good = m & select<Mask<R>>(q.floor, stays, x.u > 0.0);
    advance<R>(q, good, theta * h, x);
    pair_ends<R>(q, good);
    return good;
}

// ---- glide over a lasting contact (motion C) -------------------------------------------------------------------

template <class R>
struct Complex {
    R re, im;
};
template <class R>
HL_FN Complex<R> operator+(Complex<R> a, Complex<R> b) {
    return {a.re + b.re, a.im + b.im};
}
template <class R>
HL_FN Complex<R> operator*(Complex<R> a, Complex<R> b) {
    return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
template <class R>
HL_FN Complex<R> operator*(R a, Complex<R> b) {
    return {a * b.re, a * b.im};
}
template <class R>
HL_FN Complex<R> operator/(Complex<R> a, Complex<R> b) {
    const R size = b.re * b.re + b.im * b.im;
    return {(a.re * b.re + a.im * b.im) / size, (a.im * b.re - a.re * b.im) / size};
}
template <class R>
HL_FN R magnitude(Complex<R> a) {
    return math::sqrt<R>(a.re * a.re + a.im * a.im);
}

// One pair of conjugate modes of motion C: e^(λt) (r, 1) in the gaps, and its share in the present state.
template <class R>
struct Mode {
    Complex<R> rate, shape, share;
};

// λ from a guess by Newton's method on λ⁴ + λ² (p2 + a1 p1) + a1 (1 − a2) p1 p2 = 0, p = 1 + c λ.
template <class R>
HL_FN Complex<R> eigenvalue(const Groups<R>& s, Complex<R> l, R& last) {
    const R kappa = s.a1 * (1.0 - s.a2);
    const R b3 = s.c2 + s.a1 * s.c1, b2 = (1.0 + s.a1) + kappa * (s.c1 * s.c2), b1 = kappa * (s.c1 + s.c2);
    for (int i = 0; i < 7; ++i) {
        Complex<R> value = {constant<R>(1.0), R{}}, slope = {R{}, R{}};
        const R coefficients[4] = {b3, b2, b1, kappa};
        for (const R& coefficient : coefficients) {
            slope = slope * l + value;
            value = value * l;
            value.re = value.re + coefficient;
        }
        const Complex<R> step = value / slope;
        l = {l.re - step.re, l.im - step.im};
        last = magnitude(step) / magnitude(l);
    }
    return l;
}

// Modes of the symmetric problem M ẍ + C ẋ + K x = 0 in the gaps about the static equilibrium, in units of m_eff:
// M = ((m1 + m2, m2), (m2, m2)), m1 = 1/a2, m2 = 1/(1 − a2), C = diag(a1 c1/a2, c2), K = diag(a1/a2, 1). A mode's
// share is φᵀ(M ẋ + (λM + C) x)/φᵀ(2λM + C)φ. Returns the lanes where both modes ring.
template <class R>
HL_FN Mask<R> find_modes(const State<R>& q, Mode<R>& fast, Mode<R>& slow) {
    const Groups<R>& s = q.s;
    const R m2 = 1.0 / (1.0 - s.a2), m12 = 1.0 / s.a2 + m2, d1 = s.a1 * s.c1 / s.a2;
    const R trace = 1.0 + s.a1, kappa = s.a1 * (1.0 - s.a2);
    const R fast2 = 0.5 * (trace + math::sqrt<R>(trace * trace - 4.0 * kappa)), slow2 = kappa / fast2;
    const R y = q.x.u + s.gravity * m2 / s.a1, v = q.x.w + s.gravity * m2;
    Mask<R> good = s.a2 > 0.0;
    for (int i = 0; i < 2; ++i) {
        Mode<R>& mode = i == 0 ? fast : slow;
        const R square = i == 0 ? fast2 : slow2;
        // Undamped shape, its damping, and Newton from there.
        const R r0 = i == 0 ? s.a2 / (s.a1 - square) : (1.0 - square) / s.a1;
        const R half = 0.5 * (d1 * r0 * r0 + s.c2) / (m12 * r0 * r0 + 2.0 * m2 * r0 + m2);
        R last;
        const R swing2 = square - half * half;
        mode.rate = eigenvalue<R>(s, {-half, math::sqrt<R>(math::max<R>(swing2, 0.01 * square))}, last);
        const Complex<R> l = mode.rate, l2 = l * l;
        const Complex<R> p1 = {1.0 + s.c1 * l.re, s.c1 * l.im}, p2 = {1.0 + s.c2 * l.re, s.c2 * l.im};
        mode.shape = i == 0 ? (s.a2 * p2) / (l2 + s.a1 * p1) : (l2 + p2) / (s.a1 * p1);
        const Complex<R> r = mode.shape;
        const Complex<R> mr = {m12 * r.re + m2, m12 * r.im}, mw = {m2 * r.re + m2, m2 * r.im};  // φᵀM
        const Complex<R> top = {mr.re * q.x.du + mw.re * q.x.dw + d1 * r.re * y + s.c2 * v,
                                mr.im * q.x.du + mw.im * q.x.dw + d1 * r.im * y};
        const Complex<R> mx = {mr.re * y + mw.re * v, mr.im * y + mw.im * v};
        const Complex<R> rr = r * r,
                         mass = {m12 * rr.re + 2.0 * m2 * r.re + m2, m12 * rr.im + 2.0 * m2 * r.im};
        Complex<R> bottom = constant<R>(2.0) * (l * mass);
        bottom = {bottom.re + d1 * rr.re + s.c2, bottom.im + d1 * rr.im};
        mode.share = (top + l * mx) / bottom;
        good = good & (last < 1e-9) & (l.im > 0.05 * magnitude(l)) & (l.re <= 0.0);
    }
    return good & (fast.rate.im > 1.2 * slow.rate.im);
}

// f(t) = level + 2 Re(slow e^(λ_s t)) + 2 |fast| e^(Re λ_f t): above L1 or L2 at all times.
template <class R>
struct Envelope {
    R level, ring, decay;
    Complex<R> slow, rate;
    HL_FN R at(R t, R& slope) const {
        const math::SinCos<R> a = math::sincos<R>(rate.im * t);
        const R size = 2.0 * math::exp<R>(rate.re * t);
        const R cosine = size * (slow.re * a.cos - slow.im * a.sin),
                sine = size * (slow.re * a.sin + slow.im * a.cos);
        const R ringing = ring * math::exp<R>(decay * t);
        slope = rate.re * cosine - rate.im * sine + decay * ringing;
        return level + cosine + ringing;
    }
};

// Phase in (−π, π].
template <class R>
HL_FN R phase(Complex<R> z) {
    const R upper = math::atan2_upper<R>(math::abs<R>(z.im), z.re);
    return select<R>(z.im < 0.0, -upper, upper);
}

// A lasting contact is a slow part S that follows the floor, and a decaying ring. From the time on at which the ring
// first pushes towards separation, nothing happens while S + its amplitude < 0 in L1 and L2: go close to the end of
// that time in one step of the closed form.
template <class R>
HL_FN Mask<R> glide(State<R>& q, Mask<R> m) {
    const Groups<R>& s = q.s;
    Mode<R> fast, slow;
    m = m & negation(q.glided) & (s.gravity * s.gravity * 400.0 < s.a1) & find_modes<R>(q, fast, slow);
    if (!any(m)) return m;
    const R rest2 = -s.gravity / (1.0 - s.a2), rest1 = rest2 / s.a1;
    const auto pull = [&](const Mode<R>& mode, R c) {
        return Complex<R>{1.0 + c * mode.rate.re, c * mode.rate.im} * mode.share;
    };
    const Complex<R> slow2 = pull(slow, s.c2), fast2 = pull(fast, s.c2);
    const Complex<R> slow1 = pull(slow, s.c1) * slow.shape, fast1 = pull(fast, s.c1) * fast.shape;
    const Envelope<R> one = {rest1, 2.0 * magnitude(fast1), fast.rate.re, slow1, slow.rate};
    const Envelope<R> two = {rest2, 2.0 * magnitude(fast2), fast.rate.re, slow2, slow.rate};
    // The ring in L2 is negative until its phase reaches 3π/2.
    const R start = phase<R>(fast2);
    const R turned = select<R>(start < 0.0, start + 2.0 * math::pi, start);
    const R quiet = select<R>(fast2.re < 0.0, (1.5 * math::pi - turned) / fast.rate.im, R{});
    R ignored, slope;
    const R now1 = one.at(R{}, ignored), then1 = one.at(quiet, ignored), then2 = two.at(quiet, ignored);
    const R slow_now = rest2 + 2.0 * slow2.re;
    m = m & (now1 < 0.0) & (then1 < 0.0) & (then2 < 0.0) & (slow_now < 0.0);
    // The slow parts rise through zero at phase 3π/2; Newton from there on the envelopes.
    R until = constant<R>(1e300);
    const Envelope<R>* const envelopes[2] = {&one, &two};
    for (const Envelope<R>* e : envelopes) {
        const R angle = phase<R>(e->slow);
        const R turn = select<R>(angle < 0.0, angle + 2.0 * math::pi, angle);
        m = m & (turn > 0.25 * math::pi) & (turn < 1.5 * math::pi);
        R t = (1.5 * math::pi - turn) / slow.rate.im;
        for (int i = 0; i < 4; ++i) {
            const R value = e->at(t, slope);
            t = t - math::clamp<R>(value / slope, -1e3, 1e3);
        }
        m = m & (slope > 0.0);
        until = math::min<R>(until, t);
    }
    until = until - (0.05 + 1e-3 * until);
    m = m & (until > quiet) & (until > 3.0) & (until * slow.rate.im < 1.5 * math::pi);
    m = m & (one.at(until, ignored) < 0.0) & (two.at(until, ignored) < 0.0);
    if (!any(m)) return m;
    GapState<R> x = {rest1, R{}, rest2, R{}};
    const Mode<R>* const modes[2] = {&fast, &slow};
    for (const Mode<R>* mode : modes) {
        const math::SinCos<R> a = math::sincos<R>(mode->rate.im * until);
        const R size = 2.0 * math::exp<R>(mode->rate.re * until);
        const Complex<R> w = Complex<R>{size * a.cos, size * a.sin} * mode->share, u = w * mode->shape;
        const Complex<R> dw = w * mode->rate, du = u * mode->rate;
        x = {x.u + u.re, x.du + du.re, x.w + w.re, x.dw + dw.re};
    }
    advance<R>(q, m, until, x);
    raise(q.glided, m);
    return m;
}

// Which step each lane needs next, so that a round can be spent on the step most lanes wait for.
template <class M>
struct Waiting {
    M lying{}, pressed{}, lasting{}, stuck{};  // quick_floor, quick_pair, glide, careful

    HL_FN void drop(int lane) {
        put_flag(lying, lane, false);
        put_flag(pressed, lane, false);
        put_flag(lasting, lane, false);
        put_flag(stuck, lane, false);
    }
};

// A lasting contact looks worth a glide: the ring about the slow pull S = a1 L1 is not much larger than S.
template <class R>
HL_FN Mask<R> may_glide(const State<R>& q) {
    const R slow = q.s.a1 * (q.x.u + q.s.c1 * q.x.du), off = (q.x.w + q.s.c2 * q.x.dw) - slow;
    const R bound = (1.0 + q.s.c2) * slow;
    return q.floor & q.pair & negation(q.glided) & (slow < 0.0) &
           (off * off + q.x.dw * q.x.dw < bound * bound);
}

// Sorts the lanes of m, whose last step is over, by their next one. Flights are flown here.
template <class R>
HL_FN void sort(State<R>& q, Waiting<Mask<R>>& wait, Mask<R> m) {
    for (;;) {
        const Mask<R> free = m & q.active & negation(q.floor | q.pair);
        if (!any(free)) break;
        fly<R>(q, free);
    }
    m = m & q.active;
    const Mask<R> lying = m & q.floor & negation(q.pair), lasting = m & may_glide<R>(q);
    const Mask<R> fresh = m & q.pair & q.on_w & negation(lasting);
    set(wait.lying, m, lying);
    set(wait.pressed, m, fresh);
    set(wait.lasting, m, lasting);
    set(wait.stuck, m, negation(fresh | lying | lasting));
}

// One round: the step that most lanes wait for.
template <class R>
HL_FN Mask<R> step(State<R>& q, Waiting<Mask<R>>& wait) {
    const int n[4] = {count(wait.lying), count(wait.pressed), count(wait.lasting), count(wait.stuck)};
    int most = 0;
    for (int i = 1; i < 4; ++i)
        if (n[i] > n[most]) most = i;
    if (most == 0) {
        const Mask<R> m = wait.lying, done = quick_floor<R>(q, m);
        clear(wait.lying, m);
        raise(wait.stuck, m & negation(done));
        return done;
    }
    if (most == 1) {
        const Mask<R> m = wait.pressed, done = quick_pair<R>(q, m);
        clear(wait.pressed, m);
        raise(wait.stuck, m & negation(done));
        return done;
    }
    if (most == 2) {
        const Mask<R> m = wait.lasting, fresh = q.on_w, done = glide<R>(q, m);
        clear(wait.lasting, m);
        raise(wait.pressed, m & fresh & negation(done));
        raise(wait.stuck, m & (done | negation(fresh)));
        return m & negation(m);
    }
    const Mask<R> m = wait.stuck;
    careful<R>(q, m);
    clear(wait.stuck, m);
    return m;
}

}  // namespace lanes

// b of each loss exponent of a list, in place.
template <class R>
HL_FN void damping_ratios(double* values, int count) {
    constexpr int W = Lanes<R>::count;
    for (int i = 0; i < count; i += W) {
        R x{};
        for (int lane = 0; lane < W && i + lane < count; ++lane) lanes::put(x, lane, values[i + lane]);
        x = contact::linear_damping_ratio<R>(x);
        for (int lane = 0; lane < W && i + lane < count; ++lane) values[i + lane] = lanes::get(x, lane);
    }
}

// Solves the drops of a block.
template <class R>
HL_FN void solve_block(const Block& b) {
    using namespace lanes;
    constexpr int W = Lanes<R>::count;
    State<R> q{};
    Waiting<Mask<R>> wait;
    int drop[W];
    for (int& none : drop) none = -1;
    int next = 0;
    Mask<R> moved = negation(q.active);
    for (;;) {
        sort<R>(q, wait, moved);
        Mask<R> loaded{};
        for (int lane = 0; lane < W; ++lane) {
            if (get_flag(q.active, lane)) continue;
            if (drop[lane] >= 0) store(q, lane, b, drop[lane]);
            drop[lane] = -1;
            wait.drop(lane);
            if (next == b.count) continue;
            load(q, lane, b, next);
            put_flag(loaded, lane, true);
            drop[lane] = next++;
        }
        if (any(loaded)) {
            moved = loaded;
            continue;
        }
        if (!any(q.active)) break;
        moved = step<R>(q, wait);
    }
}

}  // namespace hardlimit::sweep
