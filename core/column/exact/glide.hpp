// Large steps through a lasting contact of both balls (motion C), over many pieces in which no event can occur.
//
// The energies of the derivatives never increase (rest.hpp) and bound d²L/dt². So L1 and L2 stay below parabolas. While
// these are negative no contact ends, and a power of exp(M h) advances the state. A light ball that oscillates between
// the floor and a heavy ball makes those energies large. In that case only the slow mode is bounded by a parabola, and
// the amplitude of the fast mode is added.
#pragma once
#include "rest.hpp"

namespace hardlimit::column::exact {

// exp(M t) of motion C without gravity, acting on (q, q̇, w, ẇ). q is the height of the heavier ball, u or s = u + w;
// computed from the other height, its slow motion would be lost to rounding. The diagonal is stored twice: minus 1,
// which keeps the digits of slow modes through many squarings, and unchanged, which keeps those of decayed modes.
struct Propagator {
    double m[4][4];  // exp(M t) − 1
    double kept[4];  // diagonal of exp(M t)

    // Over a time h of at most one piece, by Taylor series of its columns.
    HL_FN static Propagator of(const TwoBall& s, double h) {
        Propagator p;
        for (int j = 0; j < 4; ++j) {
            double q0 = j == 0, q1 = j == 1 ? h : 0.0, w0 = j == 2, w1 = j == 3 ? h : 0.0;
            double q = 0.0, dq = 0.0, w = 0.0, dw = 0.0, share = 1.0;  // share: 1/n!
            for (int n = 1; n <= order; ++n) {
                const double u0 = s.light() ? q0 - w0 : q0, u1 = s.light() ? q1 - w1 : q1;
                const double l1 = h * h * u0 + h * s.c1 * u1, l2 = h * h * w0 + h * s.c2 * w1;
                const double q2 = s.light() ? -s.b2 * l2 : s.a2 * l2 - s.a1 * l1, w2 = s.a1 * l1 - l2;
                share /= n;
                q += share * q1;
                dq += share * q2;
                w += share * w1;
                dw += share * w2;
                q0 = q1;
                q1 = q2;
                w0 = w1;
                w1 = w2;
            }
            const double column[4] = {q, dq / h, w, dw / h};
            for (int i = 0; i < 4; ++i) p.m[i][j] = column[i];
            p.kept[j] = 1.0 + p.m[j][j];
        }
        return p;
    }
    // An element of exp(M t).
    HL_FN double at(int i, int j) const { return i == j ? kept[i] : m[i][j]; }
    // Replaces W by W + Φᵀ W Φ with Φ = exp(M t).
    HL_FN void double_form(double (&form)[4][4]) const {
        double half[4][4] = {};
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j)
                for (int k = 0; k < 4; ++k) half[i][j] += form[i][k] * at(k, j);
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j)
                for (int k = 0; k < 4; ++k) form[i][j] += at(k, i) * half[k][j];
    }
    HL_FN Propagator squared() const {
        Propagator p;
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j) {
                double others = 0.0;
                for (int k = 0; k < 4; ++k)
                    if (k != i && k != j) others += m[i][k] * m[k][j];
                if (i != j) {
                    p.m[i][j] = m[i][j] * (kept[i] + kept[j]) + others;
                } else if (decayed(i)) {
                    p.kept[i] = kept[i] * kept[i] + others;
                    p.m[i][i] = p.kept[i] - 1.0;
                } else {
                    p.m[i][i] = m[i][i] * (1.0 + kept[i]) + others;
                    p.kept[i] = 1.0 + p.m[i][i];
                }
            }
        return p;
    }
    HL_FN Gaps moved(const TwoBall& s, const Gaps& x) const {
        const double w0 = -s.gravity / s.b2, u0 = w0 / s.a1;
        const double y = x.u - u0, v = x.w - w0;
        const double still[4] = {s.light() ? u0 + w0 : u0, 0.0, w0, 0.0};
        const double from[4] = {s.light() ? y + v : y, s.light() ? x.du + x.dw : x.du, v, x.dw};
        double change[4], to[4];
        for (int i = 0; i < 4; ++i) {
            double others = 0.0;
            for (int k = 0; k < 4; ++k)
                if (k != i) others += m[i][k] * from[k];
            change[i] = m[i][i] * from[i] + others;
            to[i] = still[i] + (kept[i] * from[i] + others);
        }
        if (!s.light())
            return {decayed(0) ? to[0] : x.u + change[0], decayed(1) ? to[1] : x.du + change[1],
                    decayed(2) ? to[2] : x.w + change[2], decayed(3) ? to[3] : x.dw + change[3]};
        return {decayed(0) && decayed(2) ? to[0] - to[2] : x.u + (change[0] - change[2]),
                decayed(1) && decayed(3) ? to[1] - to[3] : x.du + (change[1] - change[3]),
                decayed(2) ? to[2] : x.w + change[2], decayed(3) ? to[3] : x.dw + change[3]};
    }

private:
    HL_FN bool decayed(int i) const { return math::abs(kept[i]) < 0.5; }
};

inline constexpr int most_doublings = 200;

// State after a time t of motion C.
HL_FN Gaps double_contact_motion(const TwoBall& s, const Gaps& x, double t) {
    const double h = piece_length(s, true, true);
    int doublings = 0;
    double piece = t;
    for (; piece > h && doublings < most_doublings; ++doublings) piece *= 0.5;
    Propagator p = Propagator::of(s, math::min(piece, h));
    for (; doublings > 0; --doublings) p = p.squared();
    return p.moved(s, x);
}

// Upper bounds on L1 and L2 at all later times, while both contacts are closed.
struct ContactBounds {
    double l1, l2, rate1, rate2;  // L1, L2 and their current rates
    double level1, level2;        // bounds on the rates
    double bend1, bend2;          // bounds on the second derivatives
    double own, gain;  // second bound on L2'': own + gain t, the pair as an oscillator driven by the floor

    HL_FN static ContactBounds of(const TwoBall& s, const Gaps& x) {
        const Derivatives d = derivatives(s, x);
        ContactBounds g{d.l1[0], d.l2[0], d.l1[1], d.l2[1], never, never, never, never, never, never};
        const double reach = 1.0 / math::sqrt(s.a1) + s.c1;
        if (s.a2 > 0.0) {
            const double second = amplitude(s, d, 2), third = amplitude(s, d, 3);
            const double to_floor = math::sqrt(s.a2 / s.b2) / s.a1, to_pair = 1.0 / math::sqrt(s.b2);
            g.level1 = second * to_floor;
            g.level2 = second * to_pair;
            g.bend1 = math::min(third * to_floor, second * math::sqrt(s.a2) * reach);
            g.bend2 = math::min(third * to_pair, second * (1.0 + s.c2));
        } else {
            const double second = floor_amplitude(s, d, 2), third = floor_amplitude(s, d, 3);
            g.level1 = second / s.a1;
            g.bend1 = math::min(third / s.a1, second * reach);
        }
        g.own = (1.0 + s.c2) * math::sqrt(d.w[3] * d.w[3] + d.w[2] * d.w[2]);
        g.gain = (1.0 + s.c2) * (s.a1 * g.bend1);
        return g;
    }
    // Whether the bounds exclude the end of a contact within t.
    HL_FN bool holds(double t) const {
        const double half = 0.5 * t * t, bend = math::min(bend2, own + gain * t);
        return (l1 + level1 * t < 0.0 || l1 + rate1 * t + bend1 * half < 0.0) &&
               (l2 + level2 * t < 0.0 || l2 + rate2 * t + bend * half < 0.0);
    }
};

// Upper bounds on L1 and L2 at all later times for coupled balls, from the two modes of the undamped motion.
//
// With p = y/√a2 and r = (y + v)/√b2, y and v being the distances of u and w from the equilibrium, the equations read
// q̈ + C q̇ + K q = 0 for q = (p, r), with symmetric C and K. Along the eigenvectors of K, slow (sin θ, cos θ) and fast
// (cos θ, −sin θ), only the element C_fs couples, and the energy bounds every velocity by E = √(|q̇|² + q·K q). So the
// amplitudes of both grow no faster than |C_fs| E.
class ModeBounds {
public:
    HL_FN static ModeBounds of(const TwoBall& s, const Gaps& x) {
        const double root1 = math::sqrt(s.a2), root2 = math::sqrt(s.b2);
        const double half = 0.5 * (s.a1 + 1.0), product = s.a1 * s.b2;
        const double fast = half + math::sqrt(math::max(half * half - product, 0.0)), slow = product / fast;
        const double tangent = root1 * root2 / ((s.a1 + s.a2) - slow);
        const double cos = 1.0 / math::sqrt(1.0 + tangent * tangent), sin = tangent * cos;
        const double w0 = -s.gravity / s.b2, u0 = w0 / s.a1, y = x.u - u0;
        const double p = y / root1, r = (y + (x.w - w0)) / root2;
        const double dp = x.du / root1, dr = (x.du + x.dw) / root2;
        const double along = root2 * cos - root1 * sin,
                     across = -(root1 * cos + root2 * sin);  // w of the modes

        ModeBounds m;
        const double floor = s.a1 * s.c1, ringing = cos * p - sin * r, rate = cos * dp - sin * dr;
        const double damping_slow = floor * (sin * sin) + s.c2 * (along * along);
        const double damping_fast = floor * (cos * cos) + s.c2 * (across * across);
        const double rounding = 1e-14 * (math::abs(p) + math::abs(r));
        m.coupling = math::abs(floor * (sin * cos) + s.c2 * (along * across));
        m.q = sin * p + cos * r;
        m.dq = sin * dp + cos * dr;
        m.ddq = -slow * m.q - damping_slow * m.dq - (floor * (sin * cos) + s.c2 * (along * across)) * rate;
        m.amplitude = math::sqrt(ringing * ringing + rate * rate / fast) + rounding;
        m.energy = math::sqrt((dp * dp + dr * dr) + (slow * (m.q * m.q) + fast * (ringing * ringing)));
        m.own_energy = math::sqrt(m.dq * m.dq + slow * (m.q * m.q));
        m.slow = slow;
        m.fast = fast;
        m.damping_slow = damping_slow;
        m.damping_fast = damping_fast;
        m.floor = {u0, s.c1, root1 * sin, root1 * cos};
        m.pair = {w0, s.c2, along, math::abs(across)};
        return m;
    }
    // Whether the bounds exclude the end of a contact within t.
    HL_FN bool holds(double t) const {
        const double grown = coupling * energy * t, own = own_energy + grown,
                     ring = amplitude + grown / math::sqrt(fast);
        const double second = (math::sqrt(slow) + damping_slow) * own + coupling * energy;
        const double third = slow * own + damping_slow * second +
                             coupling * (math::sqrt(fast) + damping_fast + coupling) * energy;
        const auto closed = [&](const Force& f) {
            const double now = q + f.c * dq, rate = dq + f.c * ddq, bend = second + f.c * third;
            const double most = f.slow * (now + rate * t) + math::abs(f.slow) * (0.5 * bend * t * t);
            // The maximum of a parabola that bends up is at one of the two ends.
            const double from = f.slow * now;
            return f.still + math::max(most, from) + f.fast * ring * math::sqrt(1.0 + f.c * f.c * fast) < 0.0;
        };
        return closed(floor) && closed(pair);
    }

private:
    // L = still + slow (q + c q̇) + fast (the same of the other mode).
    struct Force {
        double still, c, slow, fast;
    };
    Force floor, pair;
    double q, dq, ddq, own_energy;                // the slow mode
    double amplitude, energy;                     // of the fast mode; E
    double slow, fast;                            // squares of the frequencies
    double damping_slow, damping_fast, coupling;  // elements C_ss, C_ff and |C_fs|
};

// Propagators of 2^n pieces, computed on demand by squaring.
class Powers {
    static constexpr int most = 64;
    Propagator power[most];
    int known = 0;

public:
    // Largest n such that no event can occur within 2^n pieces and these fit into `span`; −1: too few to be worthwhile.
    HL_FN static int doublings(const TwoBall& s, const Gaps& x, double span) {
        constexpr int least = 3;
        const ContactBounds g = ContactBounds::of(s, x);
        const bool coupled = s.a2 > 0.0;
        const ModeBounds ringing = coupled ? ModeBounds::of(s, x) : ModeBounds{};
        double t = 8.0 * piece_length(s, true, true);
        int n = least - 1;
        for (; n + 1 < most && t <= span && (g.holds(t) || (coupled && ringing.holds(t))); t *= 2.0) ++n;
        return n >= least ? n : -1;
    }
    HL_FN const Propagator& of(const TwoBall& s, int doublings) {
        if (known == 0) power[known++] = Propagator::of(s, piece_length(s, true, true));
        for (; known <= doublings; ++known) power[known] = power[known - 1].squared();
        return power[doublings];
    }
};

}  // namespace hardlimit::column::exact
