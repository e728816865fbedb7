// When gravity holds contacts closed for good, and what still happens then.
#pragma once
#include "motions.hpp"

namespace hardlimit::column::exact {

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

}  // namespace hardlimit::column::exact
