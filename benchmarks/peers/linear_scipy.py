"""Linear dashpot with SciPy: solve_ivp with DOP853 and terminal events, restarted after each switch."""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import solve_ivp

from . import scaled
from .sequence import Sequence


def solve(row, tol: float):
    kappa, d1, d2, g, delta = row
    s = Sequence(g)
    t, y = 0.0, (0.0, delta, -1.0, 0.0)

    def slopes(_, y):
        u, w, p, q = y
        f01 = -kappa * (u + d1 * p) if s.floor else 0.0
        f12 = -(w + d2 * q) if s.pair else 0.0
        return p, q, f01 - kappa * f12 - g, f12 - f01

    def floor_event(_, y):
        u, _, p, _ = y
        return -(u + d1 * p) if s.floor else u + d1 * max(p, 0.0)

    def pair_event(_, y):
        _, w, _, q = y
        return -(w + d2 * q) if s.pair else w + d2 * max(q, 0.0)

    for event in (floor_event, pair_event):
        event.terminal, event.direction = True, -1.0
    while True:
        solution = solve_ivp(
            slopes, (t, math.inf), y, "DOP853", events=(floor_event, pair_event), rtol=tol, atol=tol
        )
        at_floor, _ = solution.t_events
        t = solution.t[-1]
        u, w, p, q = solution.y[:, -1]
        if len(at_floor):  # exactly on the event surface, where the next event function starts
            u = 0.0 if not s.floor and p < 0.0 else -d1 * p
            over = s.floor_switches(u, p, q)
        else:
            w = 0.0 if not s.pair and q < 0.0 else -d2 * q
            over = s.pair_switches(t, u, p, q)
        if over:
            return s.row()
        y = (u, w, p, q)


def run(points: scaled.Points, tol: float) -> scaled.Results:
    rows, speed, rate = scaled.linear(points)
    return scaled.Results.of(np.array([solve(row, tol) for row in rows.tolist()]), speed, rate)
