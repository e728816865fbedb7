"""Linear dashpot with heyoka.py.

A contact switches at a rising zero of sign·(gap + c·rate): sign = 1 while the force acts, −1 while it does not; c = 0
once the gap has opened, which is a second event.
"""

from __future__ import annotations

import heyoka as hy

from . import scaled
from .taylor import Problem, solve_all

KAPPA, G, D1, D2, FLOOR, PAIR, SIGN_U, C_U, SIGN_W, C_W = range(10)


def system():
    u, w, p, q = hy.make_vars("u", "w", "p", "q")
    par = hy.par
    f01 = -par[FLOOR] * par[KAPPA] * (u + par[D1] * p)
    f12 = -par[PAIR] * (w + par[D2] * q)
    equations = [(u, p), (w, q), (p, f01 - par[KAPPA] * f12 - par[G]), (q, f12 - f01)]
    events = [par[SIGN_U] * (u + par[C_U] * p), u, par[SIGN_W] * (w + par[C_W] * q), w]
    return equations, events


def handle(which, s, state, par, t):
    """A switch; returns whether the sequence is over."""
    u, _, p, q = state.tolist()
    if which == 1:  # the gaps open
        if not s.floor:
            par[C_U] = 0.0
        return False
    if which == 3:
        if not s.pair:
            par[C_W] = 0.0
        return False
    if which == 0:
        over = s.floor_switches(u, p, q)
        par[FLOOR], par[SIGN_U], par[C_U] = s.floor, 1.0 if s.floor else -1.0, par[D1]
        return over
    over = s.pair_switches(t, u, p, q)
    par[PAIR], par[SIGN_W], par[C_W] = s.pair, 1.0 if s.pair else -1.0, par[D2]
    return over


def parameters(row):
    kappa, d1, d2, g, _ = row
    return kappa, g, d1, d2, 1.0, 0.0, 1.0, d1, -1.0, 0.0


PROBLEM = Problem(system, handle, parameters, 4, 10)


def run(points: scaled.Points, mode: str, tol: float) -> scaled.Results:
    """``mode`` is "scalar" or "batch"."""
    return solve_all(PROBLEM, scaled.linear(points), mode, tol)
