"""Viscoelastic spheres with numba.

The √ξ singularity of the force at first touch would reduce the order of any method. While a contact acts, the
coordinate is therefore s = √ξ and dt = s dτ (both acting: dt = s_u s_w dτ), in which the equations are polynomial.
"""

from __future__ import annotations

import math
import sys

import numba

from . import scaled, switches_numba
from .runge_kutta import FAST, jit


@jit
def constants(*values):
    return values


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
    return x - math.sqrt(max(0.0, c * rate)) if on else x + c * max(rate, 0.0)


@jit
def slope(on, dx, rate, drate, c):
    if on:
        return dx - (0.5 * drate * math.sqrt(c / rate) if rate > 0.0 else 0.0)
    return dx + c * drate if rate > 0.0 else dx


@jit
def engaged(c, rate):
    return math.sqrt(c * rate)


@jit
def step_length(fraction, floor, pair, k1):
    if not floor:
        return fraction
    return fraction / k1**-0.2 if pair else fraction * k1**-0.2


def run(points: scaled.Points, method: str, fraction: float) -> scaled.Results:
    """``method`` is "RK4" or "DOP853"; ``fraction`` the step in units in which a collision takes about 3."""
    rows, speed, rate = scaled.viscoelastic(points)
    return scaled.Results.of(
        switches_numba.kernel(sys.modules[__name__], method)(rows, fraction), speed, rate
    )
