"""Viscoelastic spheres with numba: fixed Runge-Kutta steps for each combination of contacts; every switch is located.

The √ξ singularity of the force at first touch would reduce the order of any method. While a contact acts, the
coordinate is therefore s = √ξ and dt = s dτ (both acting: dt = s_u s_w dτ), in which the equations are polynomial.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numba

from . import scaled
from .runge_kutta import FAST, TABLEAUX, jit, over_rows, unrolled


@numba.njit(fastmath=FAST, error_model="numpy")
def slopes(a, b, p, q, t, floor, pair, kappa, c1, c2, g, k1):
    f01 = f12 = 0.0
    clock = su = sw = 1.0
    if floor:
        f01 = k1 * a * (a * a - c1 * p)
        su = a
    if pair:
        f12 = b * (b * b - c2 * q)
        sw = b
    clock = su * sw
    da = -0.5 * p * sw if floor else p * clock
    db = -0.5 * q * su if pair else q * clock
    return da, db, clock * (f01 - g - kappa * f12), clock * (f12 - f01), clock


@jit
def distance(on, x, rate, c):
    """A function that falls to zero at the next switch of a contact."""
    if on:
        return x - math.sqrt(max(0.0, c * rate))
    return x + c * max(rate, 0.0)


@jit
def slope(on, dx, rate, drate, c):
    if on:
        return dx - (0.5 * drate * math.sqrt(c / rate) if rate > 0.0 else 0.0)
    return dx + c * drate if rate > 0.0 else dx


@lru_cache
def kernel(method):
    step = unrolled(TABLEAUX[method], ("a", "b", "p", "q", "t"), slopes)

    @jit
    def first_zero(h, e0, s0, e1, s1, of_pair, c, y, dy, m):
        """τ in (0, h] at which the contact switches; infinity if it does not."""
        on = m[1] if of_pair else m[0]
        lo, hi = 0.0, h
        if e1 > 0.0:
            if not (s0 < 0.0 < s1):
                return math.inf
            x = s0 / (s0 - s1)
            if e0 + 0.5 * h * x * s0 > 0.2 * min(e0, e1):
                return math.inf
            lo3, hi3 = 0.0, h  # the minimum, by ternary search
            for _ in range(40):
                t1, t2 = lo3 + (hi3 - lo3) / 3.0, hi3 - (hi3 - lo3) / 3.0
                y1, y2 = step(t1, *y, *dy, *m), step(t2, *y, *dy, *m)
                g1 = distance(on, y1[1], y1[3], c) if of_pair else distance(on, y1[0], y1[2], c)
                g2 = distance(on, y2[1], y2[3], c) if of_pair else distance(on, y2[0], y2[2], c)
                if g1 <= 0.0 or g2 <= 0.0:
                    hi, e1 = (t1, g1) if g1 <= 0.0 else (t2, g2)
                    break
                if g1 < g2:
                    hi3 = t2
                else:
                    lo3 = t1
            if e1 > 0.0:
                return math.inf
        side = 0
        for _ in range(100):  # Illinois
            t = lo + (hi - lo) * e0 / (e0 - e1) if e0 > 0.0 else 0.5 * (lo + hi)
            if not (lo < t < hi):
                t = 0.5 * (lo + hi)
            y1 = step(t, *y, *dy, *m)
            e = distance(on, y1[1], y1[3], c) if of_pair else distance(on, y1[0], y1[2], c)
            if abs(e) < 1e-14 or hi - lo < 1e-14 * h:
                return t
            if e > 0.0:
                lo, e0 = t, e
                if side == 1:
                    e1 *= 0.5
                side = 1
            else:
                hi, e1 = t, e
                if side == -1:
                    e0 *= 0.5
                side = -1
        return t

    @jit
    def solve(row, fraction):
        kappa, c1, c2, g, delta, k1 = row[0], row[1], row[2], row[3], row[4], row[5]
        floor_scale = k1**-0.2
        a, b, p, q, t = 0.0, delta, -1.0, 0.0, 0.0
        floor, pair, met_again, counted = True, False, False, False
        n = 0
        vr = sep = t_end = math.nan
        for _ in range(1000000):
            if not floor and not pair:
                clear = a + 0.5 * p * max(p, 0.0) / g >= 0.0
                if q >= 0.0 and clear:
                    break
                if q < 0.0 and clear:  # parabola to the next contact
                    fall = (p + math.sqrt(p * p + 2.0 * g * a)) / g
                    meet = -b / q
                    if fall <= meet:
                        break
                    a, b, p, t = a + meet * (p - 0.5 * g * meet), 0.0, p - g * meet, t + meet
                    pair = counted = True
                    n += 1
                    vr = sep = t_end = math.nan
                    continue
            m = (floor, pair, kappa, c1, c2, g, k1)
            h = fraction
            if floor:
                h = fraction / floor_scale if pair else fraction * floor_scale
            y = (a, b, p, q, t)
            dy = slopes(a, b, p, q, t, floor, pair, kappa, c1, c2, g, k1)
            ef0, sf0 = distance(floor, a, p, c1), slope(floor, dy[0], p, dy[2], c1)
            ep0, sp0 = distance(pair, b, q, c2), slope(pair, dy[1], q, dy[3], c2)
            while True:
                y1 = step(h, *y, *dy, *m)
                dy1 = slopes(*y1, *m)
                ef1, sf1 = distance(floor, y1[0], y1[2], c1), slope(floor, dy1[0], y1[2], dy1[2], c1)
                ep1, sp1 = distance(pair, y1[1], y1[3], c2), slope(pair, dy1[1], y1[3], dy1[3], c2)
                if ef1 <= 0.0 or ep1 <= 0.0 or (sf0 < 0.0 < sf1) or (sp0 < 0.0 < sp1):
                    tf = first_zero(h, ef0, sf0, ef1, sf1, False, c1, y, dy, m)
                    tp = first_zero(h, ep0, sp0, ep1, sp1, True, c2, y, dy, m)
                    if tf < math.inf or tp < math.inf:
                        break
                y, dy = y1, dy1
                ef0, sf0, ep0, sp0 = ef1, sf1, ep1, sp1
            a, b, p, q, t = step(min(tf, tp), *y, *dy, *m)
            if tf <= tp:
                if floor:
                    a = -c1 * p
                elif p < 0.0:  # the gap had opened: second floor contact
                    a = 0.0
                    met_again = True
                    if not (pair and counted):
                        break
                else:
                    a = math.sqrt(c1 * p)
                floor = not floor
            else:
                if pair:
                    b = -c2 * q
                    if counted:
                        vr, t_end = q, t
                        if met_again:
                            break
                else:
                    b = 0.0 if q < 0.0 else math.sqrt(c2 * q)
                    counted = not met_again
                    if counted:
                        n += 1
                        vr = sep = t_end = math.nan
                pair = not pair
            if not floor and not pair and n > 0 and math.isnan(sep) and q >= 0.0:
                sep = q
        return n, vr, sep, t_end

    return over_rows(solve)


def run(points: scaled.Points, method: str, fraction: float) -> scaled.Results:
    """``method`` is "RK4" or "DOP853"; ``fraction`` the step in units in which a collision takes about 3."""
    rows, speed, rate = scaled.viscoelastic(points)
    return scaled.Results.of(kernel(method)(rows, fraction), speed, rate)
