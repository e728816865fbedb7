"""Fixed Runge-Kutta steps with numba for each combination of contacts; every switch of a contact is located.

Switches are detected at the end of each step and, where the slopes at both ends allow two switches within a step, at
the minimum in between. Newton's method in a bracket locates a switch; each iterate is a step from the start. Free
flight is a parabola. The module of a law provides compiled functions: ``slopes`` and its ``constants``, ``distance``
(falls to zero at the next switch of a contact) and its ``slope``, ``engaged`` (coordinate at which a force sets in
again) and ``step_length``.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from types import ModuleType

from .runge_kutta import TABLEAUX, jit, over_rows, unrolled


@lru_cache
def kernel(law: ModuleType, method: str) -> Callable:
    """The compiled solver of a law (a module) for rows of points; ``method`` is "RK4" or "DOP853"."""
    slopes, distance, slope = law.slopes, law.distance, law.slope
    engaged, step_length, constants = law.engaged, law.step_length, law.constants
    step = unrolled(TABLEAUX[method], ("a", "b", "p", "q", "t"), slopes)

    @jit
    def event(y, dy, m, of_pair):
        """The function of a contact that falls to zero at its next switch, and its derivative."""
        _, _, p, q, _ = y
        if of_pair:
            return distance(m[1], y[1], q, m[4]), slope(m[1], dy[1], q, dy[3], m[4])
        return distance(m[0], y[0], p, m[3]), slope(m[0], dy[0], p, dy[2], m[3])

    @jit
    def event_at(h, y, dy, m, of_pair):
        y1 = step(h, *y, *dy, *m)
        return event(y1, slopes(*y1, *m), m, of_pair)

    @jit
    def first_zero(h, e0, s0, e1, s1, of_pair, y, dy, m):
        """Time in (0, h] at which the contact switches; infinity if it does not."""
        if e1 > 0.0:
            if not (s0 < 0.0 < s1):
                return math.inf
            # Two zeros within the step? Search only if the minimum of the cubic is close to zero.
            x = s0 / (s0 - s1)
            if e0 + h * x * (s0 + 0.5 * x * (s1 - s0)) > 0.2 * min(e0, e1):
                return math.inf
            a, b, t = 0.0, h, x * h
            for _ in range(40):
                e, s = event_at(t, y, dy, m, of_pair)
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
            h, e1 = t, e
        a, b = 0.0, h
        t = h * e0 / (e0 - e1) if e0 > 0.0 else 0.5 * h
        for _ in range(60):
            e, s = event_at(t, y, dy, m, of_pair)
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
        kappa, d1, d2, g, delta, k1 = row[0], row[1], row[2], row[3], row[4], row[5]
        a, b, p, q, t = 0.0, delta if delta > 0.0 else 1e-300, -1.0, 0.0, 0.0
        floor, pair, met_again, counted = True, False, False, False
        n = 0
        vr = sep = t_end = math.nan
        for _ in range(1000000):
            if not floor and not pair:
                if q >= 0.0 and n > 0 and math.isnan(sep):
                    sep = q
                if (
                    a + 0.5 * p * max(p, 0.0) / g >= 0.0
                ):  # the floor force cannot resume before the gap has opened
                    if q >= 0.0:
                        break
                    fall = (p + math.sqrt(p * p + 2.0 * g * a)) / g  # parabola to the next contact
                    meet = -b / q
                    if fall <= meet:
                        break
                    a, b, p, t = a + meet * (p - 0.5 * g * meet), 0.0, p - g * meet, t + meet
                    pair = counted = True
                    n += 1
                    vr = sep = t_end = math.nan
                    continue
            m = constants(floor, pair, kappa, d1, d2, g, k1)
            h = step_length(fraction, floor, pair, k1)
            y = (a, b, p, q, t)
            dy = slopes(*y, *m)
            ef0, sf0 = event(y, dy, m, False)
            ep0, sp0 = event(y, dy, m, True)
            while True:
                y1 = step(h, *y, *dy, *m)
                dy1 = slopes(*y1, *m)
                ef1, sf1 = event(y1, dy1, m, False)
                ep1, sp1 = event(y1, dy1, m, True)
                if ef1 <= 0.0 or ep1 <= 0.0 or (sf0 < 0.0 < sf1) or (sp0 < 0.0 < sp1):
                    tf = first_zero(h, ef0, sf0, ef1, sf1, False, y, dy, m)
                    tp = first_zero(h, ep0, sp0, ep1, sp1, True, y, dy, m)
                    if tf < math.inf or tp < math.inf:
                        break
                y, dy = y1, dy1
                ef0, sf0, ep0, sp0 = ef1, sf1, ep1, sp1
            a, b, p, q, t = step(min(tf, tp), *y, *dy, *m)
            if tf <= tp:
                if floor:
                    a = -d1 * p
                elif p < 0.0:  # the gap had opened: second floor contact
                    a, met_again = 0.0, True
                    if not (pair and counted):
                        break
                else:
                    a = engaged(d1, p)
                floor = not floor
                continue
            if pair:
                b = -d2 * q
                if counted:
                    vr, t_end = q, t
                    if met_again:
                        break
            else:
                b = 0.0 if q < 0.0 else engaged(d2, q)
                counted = not met_again
                if counted:
                    n += 1
                    vr = sep = t_end = math.nan
            pair = not pair
        return n, vr, sep, t_end

    return over_rows(solve)
