"""Linear dashpot with numba: fixed Runge-Kutta steps for each combination of contacts; every switch is located.

The step is a fixed fraction of 1/ω of the fastest active oscillation. Switches are detected at the end of each step
and, where the slopes at both ends allow two switches within a step, at the minimum in between. Newton's method in a
bracket locates a switch; each iterate is a step from the start. Free flight is a parabola.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numba

from . import scaled
from .runge_kutta import FAST, TABLEAUX, jit, over_rows, unrolled


@numba.njit(fastmath=FAST, error_model="numpy")
def slopes(u, w, p, q, ku, cu, kw, cw, kappa, g):
    f01 = -(ku * u + cu * p)
    f12 = -(kw * w + cw * q)
    return p, q, f01 - g - kappa * f12, f12 - f01


@jit
def distance(on, gap, rate, slope, d):
    """A function that falls to zero at the next switch of a contact, and its derivative."""
    if on:
        return -(gap + d * rate), -(rate + d * slope)
    if rate > 0.0:
        return gap + d * rate, rate + d * slope
    return gap, rate


@lru_cache
def kernel(method):
    step = unrolled(TABLEAUX[method], ("u", "w", "p", "q"), slopes)

    @jit
    def first_zero(h, e0, s0, e1, s1, pair, on, d, u, w, p, q, du, dw, dp, dq, ku, cu, kw, cw, kappa, g):
        """Time in (0, h] at which the contact switches; infinity if it does not."""
        if e1 > 0.0:
            if not (s0 < 0.0 and s1 > 0.0):
                return math.inf
            # Two zeros within the step? Search only if the minimum of the cubic is close to zero.
            x = s0 / (s0 - s1)
            low = e0 + h * x * (s0 + 0.5 * x * (s1 - s0))
            if low > 0.2 * min(e0, e1):
                return math.inf
            a, b = 0.0, h
            t = x * h
            for _ in range(12):
                u1, w1, p1, q1 = step(t, u, w, p, q, du, dw, dp, dq, ku, cu, kw, cw, kappa, g)
                _, _, dp1, dq1 = slopes(u1, w1, p1, q1, ku, cu, kw, cw, kappa, g)
                e, s = distance(on, w1, q1, dq1, d) if pair else distance(on, u1, p1, dp1, d)
                if e <= 0.0:
                    break
                if s < 0.0:
                    a, s0 = t, s
                else:
                    b, s1 = t, s
                new = a + (b - a) * s0 / (s0 - s1)
                if abs(new - t) < 1e-6 * h or not (a < new < b):
                    return math.inf
                t = new
            else:
                return math.inf
            h = t
            e1 = e
        a, b = 0.0, h
        t = h * e0 / (e0 - e1) if e0 > 0.0 else 0.5 * h
        for _ in range(60):
            u1, w1, p1, q1 = step(t, u, w, p, q, du, dw, dp, dq, ku, cu, kw, cw, kappa, g)
            _, _, dp1, dq1 = slopes(u1, w1, p1, q1, ku, cu, kw, cw, kappa, g)
            e, s = distance(on, w1, q1, dq1, d) if pair else distance(on, u1, p1, dp1, d)
            if e > 0.0:
                a = t
            else:
                b = t
            new = t - e / s
            if abs(new - t) <= 1e-13 * h or b - a <= 1e-13 * h:
                return t
            t = new if a < new < b else 0.5 * (a + b)
        return t

    @jit
    def solve(row, fraction):
        kappa, d1, d2, g, delta = row[0], row[1], row[2], row[3], row[4]
        u, w, p, q, t = 0.0, delta, -1.0, 0.0, 0.0
        floor, pair, met_again, counted = True, False, False, False
        if delta == 0.0:
            w = 1e-300
        n = 0
        vr = sep = t_end = math.nan
        for _ in range(1000000):
            if not floor and not pair:
                clear = u + 0.5 * p * max(p, 0.0) / g >= 0.0
                if q >= 0.0 and clear:
                    if n > 0 and math.isnan(sep):
                        sep = q
                    break
                if q < 0.0 and clear:  # parabola to the next contact
                    fall = (p + math.sqrt(p * p + 2.0 * g * u)) / g
                    meet = -w / q
                    if fall <= meet:
                        break
                    u, w, p, t = u + meet * (p - 0.5 * g * meet), 0.0, p - g * meet, t + meet
                    pair = counted = True
                    n += 1
                    vr = sep = t_end = math.nan
                    continue
            ku, cu = (kappa, kappa * d1) if floor else (0.0, 0.0)
            kw, cw = (1.0, d2) if pair else (0.0, 0.0)
            h = fraction / math.sqrt(kw + (kappa if floor or not pair else 0.0))
            du, dw, dp, dq = slopes(u, w, p, q, ku, cu, kw, cw, kappa, g)
            ef0, sf0 = distance(floor, u, p, dp, d1)
            ep0, sp0 = distance(pair, w, q, dq, d2)
            while True:
                u1, w1, p1, q1 = step(h, u, w, p, q, du, dw, dp, dq, ku, cu, kw, cw, kappa, g)
                du1, dw1, dp1, dq1 = slopes(u1, w1, p1, q1, ku, cu, kw, cw, kappa, g)
                ef1, sf1 = distance(floor, u1, p1, dp1, d1)
                ep1, sp1 = distance(pair, w1, q1, dq1, d2)
                if ef1 <= 0.0 or ep1 <= 0.0 or (sf0 < 0.0 < sf1) or (sp0 < 0.0 < sp1):
                    tf = first_zero(h, ef0, sf0, ef1, sf1, False, floor, d1,
                                    u, w, p, q, du, dw, dp, dq, ku, cu, kw, cw, kappa, g)  # fmt: skip
                    tp = first_zero(h, ep0, sp0, ep1, sp1, True, pair, d2,
                                    u, w, p, q, du, dw, dp, dq, ku, cu, kw, cw, kappa, g)  # fmt: skip
                    if tf < math.inf or tp < math.inf:
                        break
                u, w, p, q, du, dw, dp, dq = u1, w1, p1, q1, du1, dw1, dp1, dq1
                ef0, sf0, ep0, sp0 = ef1, sf1, ep1, sp1
                t += h
            h = min(tf, tp)
            u, w, p, q = step(h, u, w, p, q, du, dw, dp, dq, ku, cu, kw, cw, kappa, g)
            t += h
            if tf <= tp:
                if floor:
                    u = -d1 * p
                elif p < 0.0:  # the gap had opened: second floor contact
                    u = 0.0
                    met_again = True
                    if not (pair and counted):
                        break
                else:
                    u = -d1 * p
                floor = not floor
            else:
                w = 0.0 if not pair and q < 0.0 else -d2 * q
                pair = not pair
                if pair:
                    counted = not met_again
                    if counted:
                        n += 1
                        vr = sep = t_end = math.nan
                elif counted:
                    vr, t_end = q, t
                    if met_again:
                        break
            if not floor and not pair and n > 0 and math.isnan(sep) and q >= 0.0:
                sep = q
        return n, vr, sep, t_end

    return over_rows(solve)


def run(points: scaled.Points, method: str, fraction: float) -> scaled.Results:
    """``method`` is "RK4" or "DOP853"; ``fraction`` the step in units of 1/ω of the fastest oscillation."""
    rows, speed, rate = scaled.linear(points)
    return scaled.Results.of(kernel(method)(rows, fraction), speed, rate)
