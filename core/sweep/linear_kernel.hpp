// Vector kernel for two-ball drops under the linear law: one drop in each lane of a vector.
//
// A quick step advances lanes to their next event with the modes of their motion (linear_modes.hpp). It starts from an
// estimate, takes one step of a third-order method with a rough evaluation, one with an accurate evaluation, and a
// final correction. It is accepted only if bounds prove that this is the next event. Otherwise a careful step advances
// one piece as column/exact/run.hpp does. Each round executes the step that most lanes wait for; finished lanes load
// the next drops.
//
// Resting contacts and very long sequences are solved by the scalar solver (Status::unsolved). The result of a lane
// does not depend on the other lanes, and therefore not on the vector width or the order of the drops.
#pragma once
#include "lane_state.hpp"
#include "linear_modes.hpp"

namespace hardlimit::sweep {

namespace lanes {

inline constexpr double most_pieces = 3000.0;

// ---- careful step ----------------------------------------------------------------------------------------------

// Lanes in which gravity keeps a contact closed forever; they are not solved here.
template <class R>
HL_FN Mask<R> rests(const State<R>& q) {
    using namespace column::exact;
    const Mask<R> alone = q.floor & negation(q.pair) & q.pair_open & negation(q.on_w);
    return (alone & rests_on_floor<R>(q.s, q.x)) |
           (q.floor & q.pair & rests_on_both<R>(q.s, 1.0 - q.s.a2, q.x));
}

template <class R>
HL_FN void taylor_step(State<R>& q, Mask<R> m) {
    using namespace column::exact;
    const Mask<R> still = m & rests<R>(q);
    raise(q.unsolved, still);
    finish<R>(q, still);
    m = m & q.active;
    if (!any(m)) return;
    Series<R> p;
    const R h = reach / rate_bound<R>(q.s, q.floor, q.pair);
    expand<R>(q.s, q.x, q.floor, q.pair, h, p);
    const R up = constant<R>(1.0), down = constant<R>(-1.0), none = constant<R>(never);
    const Mask<R> floor_slack = m & negation(q.floor | q.floor_open),
                  pair_slack = m & negation(q.pair | q.pair_open);
    // The event searched for: a closed contact loses its force, an open one closes, a slack one opens.
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
    raise(q.unsolved, long_run);
    finish<R>(q, long_run);
}

// ---- quick steps ------------------------------------------------------------------------------------------------

// Step to a nearby zero of f from its first three derivatives f[1 … 3] (Householder's method of third order).
template <class R>
HL_FN R to_zero(const R* f) {
    const R inverse = 1.0 / f[1];
    const R h = -f[0] * inverse, bend = (0.5 * h) * (f[2] * inverse),
            twist = ((1.0 / 6.0) * (h * h)) * (f[3] * inverse);
    return h * (1.0 + bend) / (1.0 + 2.0 * bend + twist);
}
// The same, expanded for a short step.
template <class R>
HL_FN R to_near_zero(const R* f) {
    const R inverse = 1.0 / f[1];
    const R h = -f[0] * inverse, bend = (0.5 * h) * (f[2] * inverse),
            twist = ((1.0 / 6.0) * (h * h)) * (f[3] * inverse);
    return h * (1.0 - (bend - (2.0 * (bend * bend) - twist)));
}

// The final correction (Halley's method).
template <class R>
HL_FN R polish(R f, R f1, R f2) {
    const R inverse = 1.0 / f1, h = -f * inverse;
    return h * (1.0 - (0.5 * h) * (f2 * inverse));
}

// Largest admissible lengths of the short step and of the final correction, in units of 1/ω.
inline constexpr double nearby = 0.02, polished = 1e-6;

// Advances lanes in floor contact (motion B) to the next event: the pair closes, its force sets in again, or the floor
// contact ends. While the floor force acts w is concave, so it has a zero before the end of the contact if and only if
// it is negative at that end. Returns the lanes that were advanced.
template <class R>
HL_FN Mask<R> floor_step(State<R>& q, const Modes<R>& k, Mask<R> m) {
    const Groups<R>& s = q.s;
    const R rest = k.floor_rest, omega = k.floor_rate;
    const Complex<R> rate = {-0.5 * (s.a1 * s.c1), omega};
    const R y = q.x.u - rest, w0 = q.x.w, dw0 = q.x.dw;
    const Complex<R> swing = {y, (rate.re * y - q.x.du) * k.floor_period};  // u = rest + Re(swing e^(λt))
    const Complex<R> force = pull<R>(s.c1, rate) * swing;
    const R height = q.x.u + w0, climb = q.x.du + dw0;  // of the upper ball, in free fall
    const R l1 = q.x.u + s.c1 * q.x.du, l1_rate = q.x.du - s.c1 * (s.a1 * l1 + s.gravity), now = -s.a1 * l1;
    m = m & (omega > 0.0) & (l1 <= 0.0);
    // Estimate of the end of the floor contact: at phase 3π/2, with a small correction for gravity.
    const R strength = magnitude(force), late = -rest / strength;
    const R release = (1.5 * math::pi + late - rough_angle(force)) * k.floor_period;
    const R left_over = strength * rough_exp(rate.re * release);
    const Complex<R> swing_then = Complex<R>{late * left_over, -left_over} * k.from_pull;
    const R u_then = rest + swing_then.re, du_then = real_product<R>(rate, swing_then);
    const R w_then = (height + release * (climb - 0.5 * s.gravity * release)) - u_then,
            dw_then = (climb - s.gravity * release) - du_then;
    const R doubt =
        1e-4 * (math::abs<R>(u_then) + math::abs<R>(w0) + (release + k.floor_period) * math::abs<R>(dw_then));
    // A slack pair opens no later than the zero of w + ẇ t − worst t²/2, where worst is a bound on −ẅ until then. Since
    // L2 = w + c2 ẇ >= 0, that zero is before 2 c2. Its force does not set in earlier if L2 only rises, or if L2 is
    // concave, because it is positive at both ends. Nor does it set in before the floor contact ends if L2' > 0 until
    // then. Otherwise it sets in near the second zero of a parabola through L2.
    const Mask<R> slack = negation(q.pair_open);
    const R steepest = strength * omega, rise = select<R>(l1_rate >= 0.0, R{}, s.a1 * steepest);
    const R worst = now + rise * (2.0 * s.c2), square = dw0 * dw0 + 2.0 * (worst * w0),
            then = math::sqrt<R>(math::max<R>(square, R{}));
    const R by = -2.0 * w0 / (dw0 + then);
    const Mask<R> concave = l1 + (by + s.c2) * (math::max<R>(l1_rate, R{}) + (by * omega) * steepest) < 0.0;
    const Mask<R> opens =
        slack & (dw0 > 0.0) & (square > 0.0) & (concave | (then > worst * s.c2)) & (by < 0.9 * release);
    const Mask<R> parts =
        slack & negation(opens) & (dw_then > 1.01 * (s.c2 * (now + rise * release)) + 1e-4 * steepest);
    const Mask<R> presses = slack & negation(opens | parts) & q.on_l2;
    m = m & (negation(slack) | opens | parts | presses) & (release > 0.0) & (late < 0.02);
    const Mask<R> lets_go = parts | (negation(presses) & (w_then > -doubt));  // to be confirmed
    // Otherwise the estimate is the zero of a parabola: through w and ẇ now and w at the end of the floor contact, or,
    // for a short time, with the current ẅ.
    const R soon = math::sqrt<R>(math::max<R>(dw0 * dw0 + 2.0 * (now * w0), R{}));
    const Mask<R> shortly = (dw0 + soon) * omega < 0.3 * now;
    const R bend = (w_then - w0 - dw0 * release) / (release * release),
            later = math::sqrt<R>(math::max<R>(dw0 * dw0 - 4.0 * bend * w0, R{}));
    const R root = select<R>(shortly, soon, later), doubled = select<R>(shortly, now, -2.0 * bend);
    const Mask<R> falls = dw0 < 0.0;
    const R top = select<R>(presses, 2.0 * (dw0 - s.c2 * now), select<R>(falls, 2.0 * w0, dw0 + root)),
            bottom = select<R>(presses, now - (s.a1 * s.c2) * l1_rate, select<R>(falls, root - dw0, doubled));
    R t = select<R>(lets_go, release, top / bottom);
    const R level = select<R>(lets_go, rest, height - rest), speed = select<R>(lets_go, R{}, climb),
            fall = select<R>(lets_go, R{}, s.gravity),
            sign = select<R>(lets_go, constant<R>(1.0), constant<R>(-1.0)),
            lag = select<R>(lets_go, s.c1, select<R>(presses, s.c2, R{}));
    // f = x + lag ẋ, where x is u or w.
    const auto derivatives = [&](Complex<R> z, R at, R* f) {
        const Complex<R> x0 = swing * z, x1 = rate * x0, x2 = rate * x1, x3 = rate * x2;
        const R x4 = real_product<R>(rate, x3);
        const R y1 = (speed - fall * at) + sign * x1.re, y2 = sign * x2.re - fall, y3 = sign * x3.re;
        f[0] = (level + at * (speed - 0.5 * fall * at)) + sign * x0.re + lag * y1;
        f[1] = y1 + lag * y2;
        f[2] = y2 + lag * y3;
        f[3] = y3 + lag * (sign * x4);
    };
    R f[4];
    derivatives(rough_evolution(rate, t), t, f);
    t = t + to_zero<R>(f);
    Complex<R> z = evolution(rate, t);
    derivatives(z, t, f);
    const R dt = to_near_zero<R>(f);
    z = z * nudge(scaled<R>(dt, rate));
    t = t + dt;
    const Complex<R> x0 = swing * z, x1 = rate * x0;
    const R x2 = real_product<R>(rate, x1), x3 = -s.a1 * (x1.re + s.c1 * x2);
    const R u = rest + x0.re, du = x1.re, ddw = -s.gravity - x2;
    const R w = ((height - rest) + t * (climb - 0.5 * s.gravity * t)) - x0.re,
            dw = (climb - s.gravity * t) - du;
    const R slope = select<R>(lets_go, du + s.c1 * x2, dw + lag * ddw);
    const R turn = select<R>(lets_go, x2 + s.c1 * x3, ddw - lag * x3);
    const R last = polish<R>(select<R>(lets_go, u + s.c1 * du, w + lag * dw), slope, turn);
    const GapState<R> at = {u + last * (du + 0.5 * (last * x2)), du + last * x2,
                            w + last * (dw + 0.5 * (last * ddw)), dw + last * ddw};
    const R when = t + last, pushing = at.u + s.c1 * at.du;
    m = m & (math::abs<R>(dt) * omega < nearby) & (math::abs<R>(last) * omega < polished) & (when > 0.0);
    const Mask<R> ends =
        m & lets_go & (parts | (at.w > 0.0)) & (slope > 0.0) & (math::abs<R>(when - release) * omega < 0.02);
    const Mask<R> ends_before = m & negation(lets_go) & (when < release) & (slope < 0.0) & (pushing < 0.0);
    const Mask<R> closes = ends_before & negation(presses);
    // Conditions under which L2 is concave before this instant and w increases.
    const Mask<R> pressed = ends_before & presses & (at.w < 0.0) & (at.dw > 0.0) &
                            (l1 + s.c2 * l1_rate < 0.0) & (pushing + s.c2 * (at.du + s.c1 * x2) < 0.0) &
                            (when * omega < 1.0);
    const Mask<R> good = ends | closes | pressed;
    advance<R>(q, good, when, at);
    raise(q.pair_open, closes | (ends & (at.w > 0.0)));
    floor_ends<R>(q, ends);
    pair_begins<R>(q, closes | pressed);
    return good;
}

// Advances lanes in pair contact (motions C and D) to the end of that contact, if it is the next event. L2 is the sum
// of the slow mode S and the fast mode ("ring"). The first zero lies where the ring rises, if the ring dominates S
// there. If the floor contact may end earlier, that zero is stored in q.parting, and the next such step searches for
// the zero of L1. Returns the lanes that were advanced.
template <class R>
HL_FN Mask<R> pair_step(State<R>& q, const Modes<R>& k, Mask<R> m) {
    const Groups<R>& s = q.s;
    const Mask<R> both = q.floor;
    const R rest2 = select<R>(both, k.rest2, R{}), rest1 = select<R>(both, k.rest1, R{}), beta = 0.5 * s.c2;
    const GapState<R> x = {q.x.u - rest1, q.x.du, q.x.w - rest2, q.x.dw};
    const Complex<R> none = {R{}, R{}};
    const Complex<R> rate = choose<R>(both, k.fast.rate, {-beta, k.pair_rate}),
                     fast = choose<R>(both, k.fast.share(x), {x.w, -(x.dw + beta * x.w) * k.pair_period}),
                     slow_rate = choose<R>(both, k.slow.rate, none),
                     slow = choose<R>(both, k.slow.share(x), none),
                     shape = choose<R>(both, k.fast.shape, {-s.a2, R{}}),
                     slow_shape = choose<R>(both, k.slow.shape, none);
    m = m & (select<R>(both, k.can_ring, k.pair_rate) > 0.0);
    // f = S + ring is L2, or L1 if the floor contact may end first.
    const Mask<R> floor_may_end = both & q.floor_may_end;
    const Complex<R> at_floor = shape * fast, at_floor_slow = slow_shape * slow;
    const R c = select<R>(floor_may_end, s.c1, s.c2), rest = select<R>(floor_may_end, rest1, rest2);
    const Complex<R> ring = pull<R>(c, rate) * choose<R>(floor_may_end, at_floor, fast),
                     drift = pull<R>(c, slow_rate) * choose<R>(floor_may_end, at_floor_slow, slow);
    const Complex<R> drift1 = slow_rate * drift;
    const R ring1 = real_product<R>(rate, ring), drift2 = real_product<R>(slow_rate, drift1);
    const R size2 = ring.re * ring.re + ring.im * ring.im, size = math::sqrt<R>(size2),
            period = select<R>(both, k.period, k.pair_period);
    // Estimate: the ring rises through −S, with S from its parabola; or S crosses zero, if S changes faster than the
    // ring. A crest in the past is excluded.
    const R ring_slope = size * select<R>(both, k.size, constant<R>(1.0));
    const Mask<R> drifts = drift1.re > ring_slope;
    R phase = rough_angle(ring);
    phase = select<R>(both & (phase > k.crest_phase + 1.5 * math::pi), phase - 2.0 * math::pi, phase);
    const R middle = (1.5 * math::pi - phase) * period, ahead = math::max<R>(middle, R{});
    const R start = rest + drift.re, level = start + ahead * (drift1.re + 0.5 * (ahead * drift2));
    const R ratio =
        select<R>(drifts, start, level) / select<R>(drifts, drift1.re, size * rough_exp(rate.re * middle));
    const R sine = math::clamp<R>(-ratio, -1.0, 1.0),
            of_crest = math::min<R>(sine * k.crest_inverse, constant<R>(1.0));
    // Near the crest the arcsine is scaled to its phase and height. Both estimates err equally at about 0.55 of the
    // height (0.48 … 0.57 for damping ratios of 0.02 … 0.3).
    const Mask<R> high = both & (of_crest > 0.55);
    const R angle = rough_arcsine<R>(select<R>(high, of_crest, sine));
    const R lean = select<R>(high, angle * (k.crest_phase * (2.0 / math::pi)), angle);
    R t = math::max<R>(select<R>(drifts, -ratio, middle + lean * period), R{});
    const auto derivatives = [&](Complex<R> z, Complex<R> zs, R* f) {
        const Complex<R> r0 = ring * z, r1 = rate * r0, r2 = rate * r1, d0 = drift * zs, d1 = slow_rate * d0,
                         d2 = slow_rate * d1;
        f[0] = rest + (r0.re + d0.re);
        f[1] = r1.re + d1.re;
        f[2] = r2.re + d2.re;
        f[3] = real_product<R>(rate, r2) + real_product<R>(slow_rate, d2);
    };
    R f[4];
    derivatives(rough_evolution(rate, t), rough_evolution(slow_rate, t), f);
    t = t + to_zero<R>(f);
    Complex<R> z = evolution(rate, t), zs = evolution(slow_rate, t);
    derivatives(z, zs, f);
    const R dt = to_near_zero<R>(f);
    z = z * nudge(scaled<R>(dt, rate));
    zs = zs * nudge(scaled<R>(dt, slow_rate));
    t = t + dt;
    const Complex<R> w0 = fast * z, v0 = slow * zs, u0 = at_floor * z, y0 = at_floor_slow * zs;
    const R climb = select<R>(both, R{}, q.x.du + s.a2 * q.x.dw), fall = select<R>(both, R{}, s.gravity);
    const R base = select<R>(both, rest1, q.x.u + s.a2 * q.x.w);
    const GapState<R> at = {(base + t * (climb - 0.5 * fall * t)) + (u0.re + y0.re),
                            (climb - fall * t) + (real_product<R>(rate, u0) + real_product<R>(slow_rate, y0)),
                            rest2 + (w0.re + v0.re),
                            real_product<R>(rate, w0) + real_product<R>(slow_rate, v0)};
    const R l1 = at.u + s.c1 * at.du, l2 = at.w + s.c2 * at.dw, press = select<R>(both, s.a1 * l1, R{});
    const R ddw = press - l2, ddu = (s.a2 * l2 - s.gravity) - press;
    const R rate1 = at.du + s.c1 * ddu, rate2 = at.dw + s.c2 * ddw;  // L1', L2'
    const R press1 = select<R>(both, s.a1 * rate1, R{});
    const R slope = select<R>(floor_may_end, rate1, rate2);
    const R bend =
        select<R>(floor_may_end, ddu + s.c1 * (s.a2 * rate2 - press1), ddw + s.c2 * (press1 - rate2));
    const R last = polish<R>(select<R>(floor_may_end, l1, l2), slope, bend);
    const GapState<R> end = {at.u + last * (at.du + 0.5 * (last * ddu)), at.du + last * ddu,
                             at.w + last * (at.dw + 0.5 * (last * ddw)), at.dw + last * ddw};
    const R when = t + last;
    const Mask<R> found =
        (slope > 0.0) & (math::abs<R>(dt) < nearby) & (math::abs<R>(last) < polished) & (when > 0.0);
    // It is the first zero if L2 has at most one extremum before it, a minimum. That holds in three cases: the slope of
    // the ring dominates that of S up to its peak at phase 2π (ringing); S always rises faster than the ring can fall
    // (drifting); S rises and the ring has no peak in between (rising). For ringing, |S'| stays below half the largest
    // slope of the ring (0.25 in squares). For rising, the phase is past 2π/3: until the ring rises at π, its curvature
    // is at least half the largest one, and |S''| stays below 0.4 of that (0.16 in squares), so the slope increases.
    const Complex<R> drift_then = drift1 * zs;
    const R drift2_then = real_product<R>(slow_rate, drift_then),
            least = math::min<R>(drift1.re, drift_then.re);
    const R omega = rate.im, left = (size2 * (omega * omega)) * (z.re * z.re + z.im * z.im),
            steep = drift1.re * drift1.re + drift1.im * drift1.im;
    const Mask<R> no_peak = phase + omega * when < 2.0 * math::pi,
                  no_dip = (drift2 >= 0.0) | (drift2_then <= 0.0);
    const Mask<R> ringing =
        no_peak & (steep < 0.25 * left) & ((phase > math::pi) | (ring1 + drift1.re < 0.0));
    const Mask<R> drifting = no_dip & (least > ring_slope);
    const Mask<R> rising = no_peak & no_dip & (least > 0.0) & (phase > 2.0 / 3.0 * math::pi) &
                           (steep * (slow_rate.im * slow_rate.im) < 0.16 * (left * (omega * omega)));
    // The floor contact does not end earlier if the slow part of L1 stays below zero by more than the ring's amplitude.
    const Complex<R> floor_drift = pull<R>(s.c1, slow_rate) * at_floor_slow, then = floor_drift * zs;
    const R bends = real_product<R>(slow_rate, floor_drift), bends_then = real_product<R>(slow_rate, then);
    const Mask<R> stays = (rest1 + math::max<R>(floor_drift.re, then.re) + size * k.floor_share < 0.0) &
                          ((bends <= 0.0) | (bends_then >= 0.0)) & (slow_rate.im * when < math::pi);
    // An open floor gap is concave in time while the pair force acts. A slack floor contact does not engage if L1' > 0;
    // whether it has opened follows from u at the end.
    const Mask<R> slack = negation(both | q.floor_open);
    const Mask<R> clear_of_floor = select<Mask<R>>(
        slack, (end.du > s.c1 * (s.gravity + s.a2 * size)) & (math::abs<R>(end.u) > 1e-12 * end.du),
        end.u > 0.0);
    const Mask<R> first = m & found & (ringing | drifting | rising);
    const Mask<R> good = first & select<Mask<R>>(floor_may_end, when < q.pair_end,
                                                 select<Mask<R>>(both, stays, clear_of_floor));
    const Mask<R> unsure = first & both & negation(floor_may_end | stays);
    advance<R>(q, good, when, end);
    set(q.floor_may_end, m, unsure);
    assign<R>(unsure, q.pair_end, when);
    const Mask<R> opened = good & slack & (end.u > 0.0);
    raise(q.floor_open, opened);
    raise(q.opened, opened);
    floor_ends<R>(q, good & floor_may_end);
    pair_ends<R>(q, good & negation(floor_may_end));
    return good;
}

// ---- large step through a lasting contact (motion C) ----------------------------------------------------------------

// Upper bound on L1 or L2: the slow mode S plus the amplitude of the ring.
template <class R>
struct Envelope {
    R level, ring, decay;
    Complex<R> slow, rate;
    HL_FN R at(Complex<R> z, R fading, R& slope) const {
        const Complex<R> now = slow * z;
        const R ringing = ring * fading;
        slope = real_product<R>(rate, now) + decay * ringing;
        return level + now.re + ringing;
    }
};

// In a lasting contact the motion is the sum of a slow part S that follows the floor and a decaying ring. Once the ring
// has first acted towards separation, no event occurs while S + ring amplitude < 0 in L1 and L2. One step advances
// close to the end of that interval. Returns the lanes that were advanced.
template <class R>
HL_FN Mask<R> large_step(State<R>& q, const Modes<R>& k, Mask<R> m) {
    const Groups<R>& s = q.s;
    const GapState<R> x = {q.x.u - k.rest1, q.x.du, q.x.w - k.rest2, q.x.dw};
    const Complex<R> rate = k.fast.rate, slow_rate = k.slow.rate;
    const Complex<R> fast = k.fast.share(x), slow = k.slow.share(x);
    const Complex<R> fast2 = pull<R>(s.c2, rate) * fast, slow2 = pull<R>(s.c2, slow_rate) * slow,
                     slow1 = pull<R>(s.c1, slow_rate) * (k.slow.shape * slow);
    // Only where the weight is below 1/20 of the force of an impact on the floor (G < √a1/20): the slow parts then rise
    // through zero near phase 3π/2, as is assumed below.
    m = m & negation(q.large_step_tried) & (k.can_ring > 0.0) & (s.gravity * s.gravity * 400.0 < s.a1);
    const R ring = magnitude(fast2);
    const Envelope<R> one = {k.rest1, ring * k.floor_share, rate.re, slow1, slow_rate};
    const Envelope<R> two = {k.rest2, ring, rate.re, slow2, slow_rate};
    // Up to phase 3π/2 the ring in L2 is negative or falls faster than S rises; up to 2π it is at most its next crest;
    // after that its amplitude is the bound.
    R phase = rough_angle(fast2);
    phase = select<R>(phase > k.crest_phase + 1.5 * math::pi, phase - 2.0 * math::pi, phase);
    const R peak = (2.0 * math::pi - phase) * k.period, middle = peak - (0.5 * math::pi) * k.period;
    const Complex<R> z1 = rough_evolution(slow_rate, peak),
                     z0 = rough_evolution(slow_rate, math::max<R>(middle, R{}));
    const R fading = rough_exp(rate.re * peak), loudest = ring * rough_exp(rate.re * middle) * k.crest;
    const Complex<R> drift1 = slow_rate * slow2, drift_then = drift1 * z1;
    const R ring1 = real_product<R>(rate, fast2);
    R ignored, slope;
    const R now2 = k.rest2 + slow2.re, middle2 = k.rest2 + (slow2 * z0).re, then2 = k.rest2 + (slow2 * z1).re;
    m = m & (one.level + one.slow.re + one.ring < 0.0) & (one.at(z1, fading, ignored) < 0.0) & (now2 < 0.0) &
        (math::max<R>(middle2, then2) + 1.0001 * loudest < 0.0) &
        ((phase > 0.5 * math::pi) | (ring1 + math::max<R>(drift1.re, drift_then.re) < 0.0)) &
        ((drift1.re <= 0.0) | (drift_then.re >= 0.0));
    // The slow parts rise through zero at phase 3π/2; Newton's method on the envelopes starts there.
    const R inverse = 1.0 / slow_rate.im;
    R until = constant<R>(1e300);
    const Envelope<R>* const envelopes[2] = {&one, &two};
    HL_ROLL
    for (const Envelope<R>* e : envelopes) {
        const R turn = rough_angle(e->slow);
        m = m & (turn > 0.25 * math::pi) & (turn < 1.5 * math::pi);
        R t = (1.5 * math::pi - turn) * inverse;
        HL_ROLL
        for (int i = 0; i < 3; ++i) {
            const R value =
                e->at(rough_evolution(slow_rate, t), rough_exp(math::min<R>(rate.re * t, R{})), slope);
            t = t - math::clamp<R>(value / slope, -1e3, 1e3);
        }
        m = m & (slope > 0.0);
        until = math::min<R>(until, t);
    }
    until = until - (0.05 + 1e-3 * until);
    m = m & (until > peak) & (until > 1.0) & (until * slow_rate.im < 1.5 * math::pi);
    if (!any(m)) return m;
    until = select<R>(m, until, R{});
    const Complex<R> zs = evolution(slow_rate, until), z = evolution(rate, until);
    const R left = magnitude(z);
    m = m & (one.at(zs, left, ignored) < 0.0) & (two.at(zs, left, ignored) < 0.0);
    const Complex<R> w0 = fast * z, w1 = rate * w0, v0 = slow * zs, v1 = slow_rate * v0;
    const Complex<R> u0 = k.fast.shape * w0, u1 = rate * u0, y0 = k.slow.shape * v0, y1 = slow_rate * y0;
    advance<R>(q, m, until,
               {k.rest1 + (u0.re + y0.re), u1.re + y1.re, k.rest2 + (w0.re + v0.re), w1.re + v1.re});
    return m;
}

// The kind of step that each lane takes next. Each round executes the kind that most lanes wait for.
template <class M>
struct NextSteps {
    M flight{}, floor{}, pair{}, large{},
        taylor{};  // free flight, floor_step, pair_step, large_step, taylor_step
    M rejected{};  // by pair_step

    HL_FN void clear(M m) {
        M* const all[] = {&flight, &floor, &pair, &large, &taylor, &rejected};
        for (M* kind : all) lanes::clear(*kind, m);
    }
};

// Lanes for which large_step() is worthwhile: the ring about the slow force S = a1 L1 is not much larger than S.
template <class R>
HL_FN Mask<R> may_take_large_step(const State<R>& q) {
    const R slow = q.s.a1 * (q.x.u + q.s.c1 * q.x.du), off = (q.x.w + q.s.c2 * q.x.dw) - slow;
    const R bound = (1.0 + q.s.c2) * slow;
    return q.floor & q.pair & negation(q.large_step_tried) & (slow < 0.0) &
           (off * off + q.x.dw * q.x.dw < bound * bound);
}

// Assigns the lanes of m, whose last step is done, to their next step.
template <class R>
HL_FN void sort(const State<R>& q, NextSteps<Mask<R>>& next, Mask<R> m) {
    next.clear(m);
    m = m & q.active;
    const Mask<R> lasting = m & may_take_large_step<R>(q);
    raise(next.flight, m & negation(q.floor | q.pair));
    raise(next.floor, m & q.floor & negation(q.pair));
    raise(next.pair, m & q.pair & negation(lasting));
    raise(next.large, lasting);
}

// Executes one round: the step that most lanes wait for, or free flight, which is short, as soon as a few lanes wait
// for it. Returns the lanes whose step is done.
template <class R>
HL_FN Mask<R> step(State<R>& q, const Modes<R>& k, NextSteps<Mask<R>>& next) {
    constexpr int few = (Lanes<R>::count + 3) / 4;
    const int n[4] = {count(next.floor), count(next.pair), count(next.large), count(next.taylor)};
    int most = 0;
    for (int i = 1; i < 4; ++i)
        if (n[i] > n[most]) most = i;
    const int flights = count(next.flight);
    if (flights >= few || flights > n[most]) {
        const Mask<R> m = next.flight;
        free_motion<R>(q, m);
        return m;
    }
    if (most == 0) {
        const Mask<R> m = next.floor, done = floor_step<R>(q, k, m);
        clear(next.floor, m);
        raise(next.taylor, m & negation(done));
        return done;
    }
    if (most == 1) {
        const Mask<R> m = next.pair, done = pair_step<R>(q, k, m);
        const Mask<R> again = m & q.floor_may_end,
                      lasting = m & q.floor & negation(done | q.large_step_tried | again);
        clear(next.pair, m & negation(again));
        raise(next.large, lasting);
        raise(next.rejected, lasting);
        raise(next.taylor, m & negation(done | lasting | again));
        return done;
    }
    if (most == 2) {
        const Mask<R> m = next.large, done = large_step<R>(q, k, m);
        const Mask<R> refused = m & next.rejected & negation(done);
        clear(next.large, m);
        raise(q.large_step_tried, done);
        clear(next.rejected, m);
        raise(next.taylor, refused);
        raise(next.pair, m & negation(refused));
        return Mask<R>{};
    }
    const Mask<R> m = next.taylor;
    taylor_step<R>(q, m);
    return m;
}

// Computes the modes of the next drops of a batch, once for consecutive drops with equal groups.
template <class R>
class ModesCache {
    static constexpr int W = Lanes<R>::count;
    Modes<R> modes{};
    int first = 0, end = 0, source = 0, row = -1;

public:
    // Writes the modes of drop i into a lane that holds the modes of row `held`. i must increase by 1 from call to
    // call.
    HL_FN void put_into(Modes<R>& k, int lane, int& held, const Batch& b, int i) {
        if (!alike(b, i, 0.0)) {
            if (i >= end) find(b, i);
            source = i - first;
            ++row;
        }
        if (held == row) return;
        held = row;
        const R* from = reinterpret_cast<const R*>(&modes);
        R* const to = reinterpret_cast<R*>(&k);
        for (unsigned j = 0; j < sizeof(Modes<R>) / sizeof(R); ++j)
            set_lane(to[j], lane, lane_of(from[j], source));
    }

private:
    HL_FN void find(const Batch& b, int i) {
        first = i;
        end = i + W;
        Groups<R> s{};
        for (int lane = 0; lane < W; ++lane) {
            const int j = i + lane < b.count ? i + lane : b.count - 1;
            load(s, lane, b, j);
        }
        modes = find_modes<R>(s);
    }
};

}  // namespace lanes

// Replaces each ε of a list by b = β/ω0.
template <class R>
HL_FN void damping_ratios(double* values, int count) {
    constexpr int W = Lanes<R>::count;
    for (int i = 0; i < count; i += W) {
        R x = broadcast<R>(1.0);
        for (int lane = 0; lane < W && i + lane < count; ++lane) set_lane(x, lane, values[i + lane]);
        x = contact::linear_damping_ratio<R>(-math::log<R>(x));
        for (int lane = 0; lane < W && i + lane < count; ++lane) values[i + lane] = lane_of(x, lane);
    }
}

// Solves the drops of a batch.
template <class R>
HL_FN void solve_batch(const Batch& b) {
    using namespace lanes;
    constexpr int W = Lanes<R>::count;
    State<R> q{};
    Modes<R> k{};
    ModesCache<R> ahead;
    NextSteps<Mask<R>> steps;
    int drop[W], row[W];
    for (int& none : drop) none = -1;
    for (int& none : row) none = -1;
    int next = 0;
    for (;;) {
        const int running = count(q.active);
        if (running == 0 || (W - running >= due<R>(b, next, (3 * W + 3) / 4) && next < b.count)) {
            Mask<R> loaded{};
            for (unsigned idle = lane_bits(negation(q.active)); idle != 0; idle &= idle - 1) {
                const int lane = first_bit(idle);
                if (drop[lane] >= 0) store(q, lane, b, drop[lane]);
                drop[lane] = -1;
                if (next == b.count) continue;
                load(q, lane, b, next);
                ahead.put_into(k, lane, row[lane], b, next);
                set_flag(loaded, lane, true);
                drop[lane] = next++;
            }
            if (running == 0 && !any(loaded)) break;
            start<R>(q, loaded);
            sort<R>(q, steps, loaded);
        }
        const Mask<R> moved = step<R>(q, k, steps);
        sort<R>(q, steps, moved);
    }
}

}  // namespace hardlimit::sweep
