// Newton's equations for two balls on a floor with the linear dashpot (Eq. 14 with Eq. 7), solved exactly.
//
// With gaps u (floor) and w (pair), L1 = u + c1 u̇, L2 = w + c2 ẇ (c = γ/k, force = −k L while in contact):
//   ü = −G − a1 L1 [floor] + a2 L2 [pair],      ẅ = a1 L1 [floor] − L2 [pair],
// in units of length V/ω, time 1/ω, speed V, with ω² = k12/m_eff, a1 = k01/(m1 ω²), a2 = m_eff/m1. Other values of
// the groups give the adiabatic problem (adiabatic.hpp).
//
// Between two switches the system is linear with constant coefficients (motion A: free, B: floor, C: both,
// D: pair), so the state is exp(M t) acting on the last one. The exponential is evaluated through its Taylor
// series over pieces of length h = 1.5/|M|: 22 terms leave a remainder below rounding (1.5²²/22! = 7e-18), whatever
// the damping, without the digits that eigenvectors lose where eigenvalues meet (critical damping). Motion A is the
// parabola itself. Each switch is the first zero of a polynomial on [0, 1], found by steps that provably cannot
// pass it (first_crossing).
#pragma once
#include "sequence.hpp"
#include "two_ball.hpp"

namespace hardlimit::column {

// State at the start of a piece, and which contacts are closed in it.
struct Node {
    double t;
    Gaps x;
    bool floor, pair;
};

namespace exact {

inline constexpr int order = 22;
inline constexpr long max_pieces = 4'000'000;

// Polynomials in θ = (t − t0)/h, and the reciprocals 1/((n + 1)(n + 2)) of their recurrence.
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

using Piece = Series<double>;

// Bound on the rates of the motion.
template <class R>
HL_FN R rate_bound(const Groups<R>& s, Mask<R> floor, Mask<R> pair) {
    const R square = select<R>(floor, s.a1, R{}) + select<R>(pair, broadcast<R>(1.0), R{});
    const R damping = select<R>(floor, s.a1 * s.c1, R{}) + select<R>(pair, s.c2, R{});
    return math::max<R>(math::sqrt(square), damping);
}

inline constexpr double reach = 1.5;  // length of a piece times the bound on the rates
HL_FN double piece_length(const TwoBall& s, bool floor, bool pair) {
    return reach / rate_bound(s, floor, pair);
}

// The recurrence runs on derivatives (n! times the coefficients), where its factors do not depend on n:
// u⁽ⁿ⁺²⁾ = reaction·L2⁽ⁿ⁾ − k1·L1⁽ⁿ⁾, with L⁽ⁿ⁾ multiplied out so that few operations depend on the last one.
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

// The parabola of motion A.
template <class R>
HL_FN GapState<R> fly(const Groups<R>& s, const GapState<R>& x, R t) {
    return {x.u + t * (x.du - 0.5 * s.gravity * t), x.du - s.gravity * t, x.w + x.dw * t, x.dw};
}

inline constexpr double never = math::infinity;

// First θ in [0, 1] at which sign·f, a polynomial of degree D, rises to zero from below; `never` if it does not. A
// function that vanishes at θ = 0 because the last switch put it there is divided by θ first (`at_zero`). Each step
// goes to the zero of a parabola above f (|f''| <= bound), so no zero can be passed, and converges quadratically.
template <int D, class R>
HL_FN R first_crossing(const R* f, R sign, Mask<R> at_zero) {
    R g[D + 1];
    for (int n = 0; n < D; ++n) g[n] = sign * select<R>(at_zero, f[n + 1], f[n]);
    g[D] = sign * select<R>(at_zero, R{}, f[D]);
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
    Mask<R> active = (g[0] < 0.0) & (highest >= 0.0);
    R theta = R{}, found = select<R>(g[0] >= 0.0, R{}, broadcast<R>(never));
    for (int i = 0; i < 500 && any(active); ++i) {
        const R value = value_at<D>(g, theta), slope = slope_at<D>(g, theta);
        const Mask<R> there = active & (value >= 0.0);
        const R speed = slope + math::sqrt<R>(slope * slope - 2.0 * bound * value);
        const R step = -2.0 * value / speed;
        const R moved = theta + step;
        active = active & negation(there) & (speed > 0.0) & (moved <= 1.0);
        theta = select<R>(active, moved, theta);
        const Mask<R> converged = active & (step <= math::epsilon * moved);
        found = select<R>(there | converged, theta, found);
        active = active & negation(converged);
    }
    return select<R>(active, theta, found);
}

// First t >= 0 at which v + s t − g t²/2 falls to zero; v <= 0 means that it lies on zero now.
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

enum class Switch { none, floor_begins, floor_ends, floor_opens, pair_begins, pair_ends, pair_opens };

struct Next {
    double at = never;  // θ within a piece, or time in motion A
    Switch what = Switch::none;
    HL_FN void consider(double when, Switch candidate) {
        if (when < at) {
            at = when;
            what = candidate;
        }
    }
};

// Which event functions the last switch put exactly on zero.
struct OnSurface {
    bool u = false, w = false, l1 = false, l2 = false;
};

// A contact that is not closed is either open (gap >= 0) or overlaps with its force clipped to zero.
struct Phase {
    bool floor = false, pair = false;          // force acts
    bool floor_open = true, pair_open = true;  // gap >= 0
};

HL_FN Next next_in_flight(const TwoBall& s, const Gaps& x, const Phase& p) {
    Next next;
    if (p.floor_open) {
        next.consider(first_fall(x.u, x.du, s.gravity), Switch::floor_begins);
    } else {
        next.consider(first_rise(x.u, x.du, s.gravity), Switch::floor_opens);
        next.consider(first_fall(x.u + s.c1 * x.du, x.du - s.c1 * s.gravity, s.gravity),
                      Switch::floor_begins);
    }
    if (p.pair_open)
        next.consider(first_fall(x.w, x.dw, 0.0), Switch::pair_begins);
    else
        next.consider(first_rise(x.w, x.dw, 0.0), Switch::pair_opens);
    return next;
}

HL_FN Next next_in_piece(const Piece& piece, const Phase& p, const OnSurface& on) {
    Next next;
    if (p.floor) {
        next.consider(first_crossing<order - 1>(piece.l1, 1.0, on.l1), Switch::floor_ends);
    } else if (p.floor_open) {
        next.consider(first_crossing<order>(piece.u, -1.0, on.u), Switch::floor_begins);
    } else {
        next.consider(first_crossing<order>(piece.u, 1.0, on.u), Switch::floor_opens);
        next.consider(first_crossing<order - 1>(piece.l1, -1.0, on.l1), Switch::floor_begins);
    }
    if (p.pair) {
        next.consider(first_crossing<order - 1>(piece.l2, 1.0, on.l2), Switch::pair_ends);
    } else if (p.pair_open) {
        next.consider(first_crossing<order>(piece.w, -1.0, on.w), Switch::pair_begins);
    } else {
        next.consider(first_crossing<order>(piece.w, 1.0, on.w), Switch::pair_opens);
        next.consider(first_crossing<order - 1>(piece.l2, -1.0, on.l2), Switch::pair_begins);
    }
    return next;
}

// Gravity holds both contacts closed for good: the energy about the static equilibrium (never rising) is too
// small for L1 or L2 to reach zero. Adiabatic: the floor is judged alone and must be still before the pair is.
template <class R>
HL_FN Mask<R> rests_on_both(const Groups<R>& s, const GapState<R>& x) {
    const R w0 = -s.gravity / (1.0 - s.a2), u0 = w0 / s.a1;
    const R y = x.u - u0, v = x.w - w0, sum = x.du + x.dw;
    const R floor = x.du * x.du + s.a1 * y * y,
            pair = x.dw * x.dw + v * v;  // twice the energies over the masses
    const R floor_reach = 1.0 / math::sqrt<R>(s.a1) + s.c1, pair_reach = 1.0 + s.c2;
    // Coupled: twice the energy in units of m_eff V² bounds both amplitudes.
    const R amplitude = math::sqrt<R>(floor / s.a2 + sum * sum / (1.0 - s.a2) + v * v);
    const Mask<R> coupled =
        (amplitude * math::sqrt<R>(s.a2) * floor_reach < -u0) & (amplitude * pair_reach < -w0);
    const R damping = math::min<R>(broadcast<R>(1.0), s.a1 * s.c1 + s.c2);
    const Mask<R> adiabatic = (math::sqrt<R>(floor) * floor_reach < -1e-3 * u0 * damping) &
                              (math::sqrt<R>(pair) * pair_reach < -0.5 * w0);
    return (s.gravity > 0.0) & select<Mask<R>>(s.a2 > 0.0, coupled, adiabatic);
}

// The same for the floor contact alone; the pair gap then closes under gravity some time later.
template <class R>
HL_FN Mask<R> rests_on_floor(const Groups<R>& s, const GapState<R>& x) {
    const R u0 = -s.gravity / s.a1, y = x.u - u0;
    const R amplitude = math::sqrt<R>(x.du * x.du + s.a1 * y * y);
    return (s.gravity > 0.0) & (amplitude * (1.0 / math::sqrt<R>(s.a1) + s.c1) < -u0);
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

// Motion B in closed form over any time.
HL_FN Gaps lie_on_floor(const TwoBall& s, const Gaps& x, double t) {
    const double u0 = -s.gravity / s.a1;
    double y = x.u - u0, dy = x.du;
    oscillate(s.a1, 0.5 * s.a1 * s.c1, t, y, dy);
    const double upper = x.u + x.w, upper_rate = x.du + x.dw;  // the upper ball falls freely
    const double u = u0 + y;
    return {u, dy, (upper + t * (upper_rate - 0.5 * s.gravity * t)) - u, (upper_rate - s.gravity * t) - dy};
}

// Time at which the pair gap closes on a lower ball that rests on the floor. w is concave there; Newton's method
// from a time at which it is surely closed comes down to the zero from the right.
HL_FN double closing_on_rest(const TwoBall& s, const Gaps& x) {
    const double u0 = -s.gravity / s.a1;
    const double largest = math::sqrt(x.du * x.du / s.a1 + (x.u - u0) * (x.u - u0));
    double t = first_fall(x.u + x.w - u0 + largest, x.du + x.dw, s.gravity);
    for (int i = 0; i < 100; ++i) {
        const Gaps y = lie_on_floor(s, x, t);
        if (!(y.dw < 0.0)) break;
        const double step = y.w / y.dw;
        t -= step;
        if (math::abs(step) <= 2.0 * math::epsilon * t) break;
    }
    return math::max(t, 0.0);
}

// Motion C over any time: exp(M t) about the static equilibrium, its factor for one piece raised to a power by squaring.
struct Propagator {
    double m[4][4];

    HL_FN static Propagator of(const TwoBall& s, double h) {
        TwoBall weightless = s;
        weightless.gravity = 0.0;
        Propagator p;
        for (int j = 0; j < 4; ++j) {
            Piece piece;
            expand(weightless,
                   Gaps{j == 0 ? 1.0 : 0.0, j == 1 ? 1.0 : 0.0, j == 2 ? 1.0 : 0.0, j == 3 ? 1.0 : 0.0}, true,
                   true, h, piece);
            const Gaps x = evaluate(piece, 1.0);
            const double column[4] = {x.u, x.du, x.w, x.dw};
            for (int i = 0; i < 4; ++i) p.m[i][j] = column[i];
        }
        return p;
    }
    HL_FN Propagator squared() const {
        Propagator p;
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j) {
                p.m[i][j] = 0.0;
                for (int k = 0; k < 4; ++k) p.m[i][j] += m[i][k] * m[k][j];
            }
        return p;
    }
    HL_FN Gaps times(const Gaps& x) const {
        const auto row = [&](int i) {
            return m[i][0] * x.u + m[i][1] * x.du + m[i][2] * x.w + m[i][3] * x.dw;
        };
        return {row(0), row(1), row(2), row(3)};
    }
};

HL_FN Gaps lie_together(const TwoBall& s, const Gaps& x, double t) {
    const double w0 = -s.gravity / (1.0 - s.a2), u0 = w0 / s.a1;
    double pieces = 1.0;
    while (t / pieces > piece_length(s, true, true)) pieces *= 2.0;
    Propagator p = Propagator::of(s, t / pieces);
    for (; pieces > 1.0; pieces *= 0.5) p = p.squared();
    const Gaps y = p.times({x.u - u0, x.du, x.w - w0, x.dw});
    return {y.u + u0, y.du, y.w + w0, y.dw};
}

// One run: finds the next switch, moves there, throws it, until the sequence is over.
template <class Observer>
class Run {
public:
    HL_FN Run(const TwoBall& groups, const Gaps& start, double time, double span_, Observer& seen)
        : s(groups), x(start), t(time), span(span_), until(span_ > -never ? never : -never), observer(seen) {
        on.u = x.u == 0.0;
        on.w = x.w == 0.0;
    }

    HL_FN Sequence run() {
        for (long steps = 0; !sequence.finished || t < until; ++steps) {
            observer.node(Node{t, x, phase.floor, phase.pair});
            if (steps == max_pieces) {
                if (!sequence.finished) sequence.outcome = Outcome::unresolved;
                break;
            }
            find_next();
            if (stopped) break;
            move();
            throw_switch();
        }
        observer.node(Node{t, x, phase.floor, phase.pair});
        sequence.close();
        return sequence;
    }

private:
    enum class Motion { flight, floor_rest, rest, series };

    const TwoBall& s;
    Gaps x;
    double t, span, until;  // `until` is on the clock of t: known once the floor has been touched
    Observer& observer;
    Sequence sequence;
    Phase phase;
    OnSurface on;
    bool counted = false;  // the pair contact now closed belongs to the sequence
    bool stopped = false;
    // The coming stretch: how the balls move, for how long, and what ends it.
    Motion motion = Motion::flight;
    Piece piece;
    Next next;
    double dt = 0.0;

    HL_FN void find_next() {
        next = Next{};
        const bool alone = phase.floor && !phase.pair && phase.pair_open && !on.w;
        motion = !phase.floor && !phase.pair                        ? Motion::flight
                 : alone && rests_on_floor(s, x)                    ? Motion::floor_rest
                 : phase.floor && phase.pair && rests_on_both(s, x) ? Motion::rest
                                                                    : Motion::series;
        if (motion == Motion::flight)
            find_in_flight();
        else if (motion == Motion::floor_rest)
            next.consider(dt = closing_on_rest(s, x), Switch::pair_begins);
        else if (motion == Motion::rest)
            rest();
        else
            find_in_piece();
        if (dt == never && !(math::abs(until) < never)) stopped = true;
        if (t < until && t + dt >= until) {  // the state asked for comes first
            if (next.at != never && dt > until - t) next = Next{};
            dt = until - t;
        }
    }

    HL_FN void find_in_flight() {
        sequence.moves_freely(x.dw, sequence.floor_opened && phase.floor_open);
        next = next_in_flight(s, x, phase);
        dt = next.at;
        if (sequence.finished && !(t < until)) stopped = true;
        if (dt == never && math::is_nan(sequence.t_first_touch)) {
            sequence.outcome = Outcome::never_lands;
            stopped = true;
        }
    }

    HL_FN void rest() {
        if (!sequence.finished) sequence.comes_to_rest(true);
        dt = never;
        if (!(t < until)) stopped = true;
    }

    HL_FN void find_in_piece() {
        const double whole = piece_length(s, phase.floor, phase.pair);
        const double h = t < until ? math::min(whole, until - t) : whole;
        expand(s, x, phase.floor, phase.pair, h, piece);
        next = next_in_piece(piece, phase, on);
        dt = next.at == never ? h : next.at * h;
    }

    HL_FN void move() {
        if (!(dt > 0.0)) return;  // what lies on an event surface stays there
        x = motion == Motion::flight       ? fly<double>(s, x, dt)
            : motion == Motion::floor_rest ? lie_on_floor(s, x, dt)
            : motion == Motion::rest       ? lie_together(s, x, dt)
                                           : evaluate(piece, dt / piece.h);
        t += dt;
        on = OnSurface{};
    }

    HL_FN void throw_switch() {
        switch (next.what) {
            case Switch::none:
                break;
            case Switch::floor_begins:
                floor_begins();
                break;
            case Switch::floor_ends:
                floor_ends();
                break;
            case Switch::floor_opens:
                floor_opens();
                break;
            case Switch::pair_begins:
                pair_begins();
                break;
            case Switch::pair_ends:
                pair_ends();
                break;
            case Switch::pair_opens:
                pair_opens();
                break;
        }
    }

    // Each switch puts the state exactly on its surface.
    HL_FN void floor_begins() {
        x.u = phase.floor_open ? 0.0 : -s.c1 * x.du;
        on.u = phase.floor_open;
        on.l1 = !phase.floor_open || s.c1 == 0.0 || x.du == 0.0;
        phase.floor = true;
        phase.floor_open = false;
        sequence.floor_begins(t);
        until = span + sequence.t_first_touch;
        observer.begins(0, t);
    }
    HL_FN void floor_ends() {
        x.u = -s.c1 * x.du;
        on.l1 = true;
        phase.floor = false;
        phase.floor_open = on.u = s.c1 == 0.0;
        sequence.floor_ends(t);
        observer.ends(0, t);
        if (phase.floor_open) sequence.floor_opens();
    }
    HL_FN void floor_opens() {
        x.u = 0.0;
        phase.floor_open = on.u = true;
        sequence.floor_opens();
    }
    HL_FN void pair_begins() {
        x.w = phase.pair_open ? 0.0 : -s.c2 * x.dw;
        on.w = phase.pair_open;
        on.l2 = !phase.pair_open || s.c2 == 0.0 || x.dw == 0.0;
        phase.pair = true;
        phase.pair_open = false;
        counted = sequence.pair_begins();
        observer.begins(1, t);
    }
    HL_FN void pair_ends() {
        x.w = -s.c2 * x.dw;
        on.l2 = true;
        phase.pair = false;
        phase.pair_open = on.w = s.c2 == 0.0;
        if (counted) sequence.pair_ends(t, x.dw);
        counted = false;
        observer.ends(1, t);
    }
    HL_FN void pair_opens() {
        x.w = 0.0;
        phase.pair_open = on.w = true;
    }
};

}  // namespace exact

// Runs the sequence from `start` (at time `t`, all contacts open), and on to `span` after the first floor touch if
// that is later (-infinity: no later). `Observer` sees the nodes and the contacts.
template <class Observer>
HL_FN Sequence run_two_ball(const TwoBall& s, const Gaps& start, double t, double span, Observer& observer) {
    return exact::Run<Observer>(s, start, t, span, observer).run();
}

// For maps: nothing but the sequence itself.
struct NoRecorder {
    HL_FN void node(const Node&) {}
    HL_FN void begins(int, double) {}
    HL_FN void ends(int, double) {}
};

}  // namespace hardlimit::column
