// Criteria for contacts that gravity keeps closed forever, and the events that remain possible then.
//
// Two criteria are used; each bounds the motion by an energy that never increases. The energy relative to the static
// equilibrium bounds L1 and L2. The derivatives of the motion obey the same equations without gravity, so their energy
// never increases either. It bounds the accelerations, and a contact stays closed while no ball accelerates as in free
// fall. For an overdamped, creeping ball the second criterion holds long before the first.
#pragma once
#include "motions.hpp"

namespace hardlimit::column::exact {

// Whether the energy relative to the equilibrium is too small for L1 or L2 to reach zero. `upper` is b2. Adiabatic
// model: the floor contact is examined alone and must be nearly at rest.
template <class R>
HL_FN Mask<R> rests_on_both(const Groups<R>& s, R upper, const GapState<R>& x) {
    const R w0 = -s.gravity / upper, u0 = w0 / s.a1;
    const R y = x.u - u0, v = x.w - w0, sum = x.du + x.dw;
    const R floor = x.du * x.du + s.a1 * y * y,
            pair = x.dw * x.dw + v * v;  // twice the energy per mass
    const R floor_reach = 1.0 / math::sqrt<R>(s.a1) + s.c1, pair_reach = 1.0 + s.c2;
    // Coupled balls: twice the energy in units of m_eff V² is the square of a bound on both amplitudes.
    const R amplitude = math::sqrt<R>(floor / s.a2 + sum * sum / upper + v * v);
    const Mask<R> coupled =
        (amplitude * math::sqrt<R>(s.a2) * floor_reach < -u0) & (amplitude * pair_reach < -w0);
    // 1e-3: the floor must be nearly at rest, because its motion drives the pair; less damping lets the pair resonate
    // longer. 0.5: the other half of the margin of the pair is left to that motion.
    const R damping = math::min<R>(broadcast<R>(1.0), s.a1 * s.c1 + s.c2);
    const Mask<R> adiabatic = (math::sqrt<R>(floor) * floor_reach < -1e-3 * u0 * damping) &
                              (math::sqrt<R>(pair) * pair_reach < -0.5 * w0);
    return (s.gravity > 0.0) & select<Mask<R>>(s.a2 > 0.0, coupled, adiabatic);
}

// The same for the floor contact alone; the pair gap closes under gravity later.
template <class R>
HL_FN Mask<R> rests_on_floor(const Groups<R>& s, const GapState<R>& x) {
    const R u0 = -s.gravity / s.a1, y = x.u - u0;
    const R amplitude = math::sqrt<R>(x.du * x.du + s.a1 * y * y);
    return (s.gravity > 0.0) & (amplitude * (1.0 / math::sqrt<R>(s.a1) + s.c1) < -u0);
}

// d^n/dt^n of u, w and s = u + w, n = 2 … 4, while both contacts are closed, and the first derivatives of L1 and L2.
struct Derivatives {
    double u[5], w[5], s[5], l1[2], l2[2];
};

HL_FN Derivatives derivatives(const TwoBall& s, const Gaps& x) {
    Derivatives d{};
    d.u[0] = x.u;
    d.u[1] = x.du;
    d.w[0] = x.w;
    d.w[1] = x.dw;
    double weight = s.gravity;
    for (int n = 0; n < 3; ++n) {
        const double l1 = d.u[n] + s.c1 * d.u[n + 1], l2 = d.w[n] + s.c2 * d.w[n + 1];
        if (n < 2) {
            d.l1[n] = l1;
            d.l2[n] = l2;
        }
        d.w[n + 2] = s.a1 * l1 - l2;
        d.s[n + 2] = -weight - s.b2 * l2;
        d.u[n + 2] = s.light() ? d.s[n + 2] - d.w[n + 2] : (s.a2 * l2 - s.a1 * l1) - weight;
        weight = 0.0;
    }
    return d;
}

// √(2 × energy of the nth derivative, in units of m_eff); never increases. Coupled balls only.
HL_FN double amplitude(const TwoBall& s, const Derivatives& d, int n) {
    const double floor = d.u[n + 1] * d.u[n + 1] + s.a1 * (d.u[n] * d.u[n]);
    return math::sqrt(floor / s.a2 + d.s[n + 1] * d.s[n + 1] / s.b2 + d.w[n] * d.w[n]);
}
// The same for the lower ball alone on the floor, in units of its mass.
HL_FN double floor_amplitude(const TwoBall& s, const Derivatives& d, int n) {
    return math::sqrt(d.u[n + 1] * d.u[n + 1] + s.a1 * (d.u[n] * d.u[n]));
}

// Rescales the state so that gravity is 1: squares then neither overflow nor underflow, however soft the contacts.
HL_FN void in_units_of_gravity(TwoBall& s, Gaps& x) {
    x = {x.u / s.gravity, x.du / s.gravity, x.w / s.gravity, x.dw / s.gravity};
    s.gravity = 1.0;
}

// Whether the lower ball alone stays on the floor, |ü| < G at all later times. Either the energy of u̇ or that of ü may
// prove it: the first gives a weaker bound but is less sensitive to rounding.
HL_FN bool creeps_on_floor(TwoBall s, Gaps x) {
    if (!(s.gravity > 0.0)) return false;
    in_units_of_gravity(s, x);
    const double u2 = -1.0 - s.a1 * (x.u + s.c1 * x.du), u3 = -s.a1 * (x.du + s.c1 * u2);
    return u2 * u2 + s.a1 * (x.du * x.du) < 1.0 || u3 * u3 + s.a1 * (u2 * u2) < s.a1;
}

// Bounds for an overdamped lower ball on the floor, from its two modes: `acceleration` on |d²u/dt²|, `jerk` on
// |d³u/dt³| and on ∫|d⁴u/dt⁴| dt.
struct FloorCreep {
    double acceleration, jerk;
};
HL_FN bool overdamped_floor(const TwoBall& s) { return s.a1 * (s.c1 * s.c1) > 4.0; }
HL_FN FloorCreep floor_creep(const TwoBall& s, const Gaps& x) {
    const double half = 0.5 * s.a1 * s.c1, root = math::sqrt(half * half - s.a1);
    const double fast = half + root, slow = s.a1 / fast, y = x.u + s.gravity / s.a1;
    const double a = math::abs(fast * y + x.du) / (2.0 * root), b = math::abs(slow * y + x.du) / (2.0 * root);
    return {slow * slow * a + fast * fast * b, slow * slow * slow * a + fast * fast * fast * b};
}

// Whether both contacts stay closed: neither the upper ball nor both balls together ever accelerate as in free fall.
HL_FN bool creeps_on_both(TwoBall s, Gaps x) {
    if (!(s.gravity > 0.0)) return false;
    in_units_of_gravity(s, x);
    const Derivatives d = derivatives(s, x);
    if (s.a2 > 0.0)
        return amplitude(s, d, 1) * math::sqrt(s.b2) < 1.0 ||
               amplitude(s, d, 2) * math::sqrt(1.0 + s.a2 / s.a1) < 1.0;
    // Adiabatic model: the second derivative of w is an oscillator driven by d⁴u/dt⁴.
    if (!overdamped_floor(s)) return false;
    const FloorCreep floor = floor_creep(s, x);
    const double pair = math::sqrt(d.w[3] * d.w[3] + d.w[2] * d.w[2]) + floor.jerk;
    return floor.acceleration + pair < 1.0;
}

// A time within which a slack pair (overlap without force) above a lower ball that stays on the floor neither opens nor
// engages: w stays below a parabola, and L2 above one.
HL_FN double slack_for(const TwoBall& s, const Gaps& x) {
    const double u2 = -s.gravity - s.a1 * (x.u + s.c1 * x.du), u3 = -s.a1 * (x.du + s.c1 * u2);
    double jerk = math::sqrt(u3 * u3 + s.a1 * (u2 * u2));
    const double acceleration =
        math::min(jerk / math::sqrt(s.a1), math::sqrt(u2 * u2 + s.a1 * (x.du * x.du)));
    if (overdamped_floor(s)) jerk = math::min(jerk, floor_creep(s, x).jerk);
    const double ddw = -s.gravity - u2, rate = x.dw + s.c2 * ddw;  // dL2/dt
    const double opens = first_rise(x.w, x.dw, math::max(s.gravity - acceleration, 0.0));
    const double pushes = first_fall(x.w + s.c2 * x.dw, rate, (s.gravity + acceleration) + s.c2 * jerk);
    return 0.99 * math::min(opens, pushes);  // 1 % below the bound, for rounding errors
}

// Time at which the pair gap closes on a lower ball that rests on the floor. w is concave there. Newton's method starts
// at a time at which the gap is certainly closed and converges to the zero monotonically from the right.
HL_FN double closing_on_rest(const TwoBall& s, const Gaps& x) {
    const double u0 = -s.gravity / s.a1;
    const double largest = math::sqrt(x.du * x.du / s.a1 + (x.u - u0) * (x.u - u0));
    double t = first_fall(x.u + x.w - u0 + largest, x.du + x.dw, s.gravity);
    for (int i = 0; i < 100; ++i) {
        const Gaps y = floor_motion(s, x, t);
        if (!(y.dw < 0.0)) break;
        const double step = y.w / y.dw;
        t -= step;
        if (math::abs(step) <= 2.0 * math::epsilon * t) break;
    }
    return math::max(t, 0.0);
}

}  // namespace hardlimit::column::exact
