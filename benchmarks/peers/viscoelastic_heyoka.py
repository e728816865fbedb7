"""Viscoelastic spheres with heyoka.py, in coordinates in which the equations are polynomial.

While a contact acts, the coordinate is s = √ξ and dt = s dτ (both acting: dt = s_u s_w dτ), else the gap and t.
Physical time is a fifth variable.
"""

from __future__ import annotations

import math

import heyoka as hy

from . import scaled
from .taylor import Problem, solve_all

KAPPA, G, C1, C2, K1, FLOOR, PAIR, SLACK_U, SLACK_W = range(9)


def system():
    a, b, p, q, t = hy.make_vars("a", "b", "p", "q", "t")
    par = hy.par
    floor, pair = par[FLOOR], par[PAIR]
    su, sw = 1.0 + floor * (a - 1.0), 1.0 + pair * (b - 1.0)
    clock = su * sw
    f01 = floor * par[K1] * a * (a * a - par[C1] * p)
    f12 = pair * b * (b * b - par[C2] * q)
    equations = [
        (a, p * sw * ((1.0 - floor) * su - 0.5 * floor)),
        (b, q * su * ((1.0 - pair) * sw - 0.5 * pair)),
        (p, clock * (f01 - par[KAPPA] * f12 - par[G])),
        (q, clock * (f12 - f01)),
        (t, clock),
    ]
    events = [
        floor * (par[C1] * p - a * a) - (1.0 - floor) * (a + par[SLACK_U] * p),
        (1.0 - floor) * a - floor,
        pair * (par[C2] * q - b * b) - (1.0 - pair) * (b + par[SLACK_W] * q),
        (1.0 - pair) * b - pair,
    ]
    return equations, events


def handle(which, s, state, par, _):
    """A switch; returns whether the sequence is over."""
    a, _, p, q, t = state.tolist()
    if which == 1:  # the gaps open
        par[SLACK_U] = 0.0
        return False
    if which == 3:
        par[SLACK_W] = 0.0
        return False
    u = -a * a if s.floor else a
    if which == 0:
        over = s.floor_switches(u, p, q)
        c = par[C1]
        par[FLOOR], par[SLACK_U] = s.floor, c
        state[0] = (math.sqrt(c * p) if p > 0.0 else 0.0) if s.floor else -c * p
        return over
    over = s.pair_switches(t, u, p, q)
    c = par[C2]
    par[PAIR], par[SLACK_W] = s.pair, c
    state[1] = (math.sqrt(c * q) if q > 0.0 else 0.0) if s.pair else -c * q
    return over


def parameters(row):
    kappa, c1, c2, g, _, k1 = row
    return kappa, g, c1, c2, k1, 1.0, 0.0, 0.0, 0.0


PROBLEM = Problem(system, handle, parameters, 5, 9)


def run(points: scaled.Points, mode: str, tol: float) -> scaled.Results:
    """``mode`` is "scalar" or "batch"."""
    return solve_all(PROBLEM, scaled.viscoelastic(points), mode, tol)
