"""Linear dashpot with numba. The step is a fixed fraction of 1/ω of the fastest active oscillation."""

from __future__ import annotations

import math
import sys

import numba
import numpy as np

from . import scaled, switches_numba
from .runge_kutta import FAST, jit


@jit
def constants(floor, pair, kappa, d1, d2, g, k1):
    ku, kw = k1 if floor else 0.0, 1.0 if pair else 0.0
    return floor, pair, kappa, d1, d2, g, ku, ku * d1, kw, kw * d2


@numba.njit(fastmath=FAST, error_model="numpy")
def slopes(u, w, p, q, t, floor, pair, kappa, d1, d2, g, ku, cu, kw, cw):
    f01 = -(ku * u + cu * p)
    f12 = -(kw * w + cw * q)
    return p, q, f01 - g - kappa * f12, f12 - f01, 1.0


@jit
def distance(on, gap, rate, d):
    return -(gap + d * rate) if on else gap + d * max(rate, 0.0)


@jit
def slope(on, gap_rate, rate, acceleration, d):
    if on:
        return -(gap_rate + d * acceleration)
    return gap_rate + d * acceleration if rate > 0.0 else gap_rate


@jit
def engaged(d, rate):
    return -d * rate


@jit
def step_length(fraction, floor, pair, k1):
    return fraction / math.sqrt((1.0 if pair else 0.0) + (k1 if floor or not pair else 0.0))


def run(points: scaled.Points, method: str, fraction: float) -> scaled.Results:
    """``method`` is "RK4" or "DOP853"; ``fraction`` the step in units of 1/ω of the fastest oscillation."""
    rows, speed, rate = scaled.linear(points)
    with_stiffness = np.column_stack((rows, rows[:, 0]))  # k1 = κ
    return scaled.Results.of(
        switches_numba.kernel(sys.modules[__name__], method)(with_stiffness, fraction), speed, rate
    )
