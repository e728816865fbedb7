"""Viscoelastic spheres, heyoka.py: Taylor series with terminal events, one point at a time or a batch.

As linear_heyoka.py, in the coordinates in which the equations are polynomial: s = √ξ and dt = s dτ while a
contact acts (both acting: dt = s_u s_w dτ), else the gap and t. Physical time is a fifth variable.
"""

from __future__ import annotations

import math
from functools import lru_cache

import heyoka as hy
import numpy as np

from . import scaled
from .sequence import Sequence

KAPPA, G, C1, C2, K1, FLOOR, PAIR, SLACK_U, SLACK_W = range(9)
FAR = 1e9

hy.set_logger_level_error()


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


def handle(which, s, state, par):
    """One switch; returns whether the sequence is over."""
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


class Scalar:
    def __init__(self, tol: float) -> None:
        equations, events = system()
        rising = hy.event_direction.positive
        made = [hy.t_event(e, callback=self._callback(i), direction=rising) for i, e in enumerate(events)]
        self.ta = hy.taylor_adaptive(equations, [0.0] * 5, pars=[0.0] * 9, t_events=made, tol=tol)
        self.sequence = None

    def _callback(self, which):
        def call(ta, sign):
            return not handle(which, self.sequence, ta.state, ta.pars)

        return call

    def solve_all(self, rows: np.ndarray) -> np.ndarray:
        out = np.empty((len(rows), 4))
        ta = self.ta
        for i, row in enumerate(rows.tolist()):
            self.sequence = Sequence(row[3])
            ta.time = 0.0
            ta.reset_cooldowns()
            ta.state[:] = (0.0, row[4], -1.0, 0.0, 0.0)
            ta.pars[:] = parameters(row)
            ta.propagate_until(FAR)
            out[i] = self.sequence.row()
        return out


class Batch:
    def __init__(self, tol: float) -> None:
        equations, events = system()
        rising = hy.event_direction.positive
        make = hy.t_event_batch
        made = [make(e, callback=self._callback(i), direction=rising) for i, e in enumerate(events)]
        self.lanes = n = hy.recommended_simd_size()
        zeros = {"state": np.zeros((5, n)), "pars": np.zeros((9, n))}
        self.ta = hy.taylor_adaptive_batch(equations, t_events=made, tol=tol, **zeros)

    def _callback(self, which):
        def call(ta, sign, lane):
            s = self.sequence[lane]
            if s is not None and handle(which, s, self.state[:, lane], self.pars[:, lane]):
                self.out[self.point[lane]] = s.row()
                return self._load(lane)
            return True

        return call

    def _load(self, lane):
        """The next point into a lane; returns whether any lane has work."""
        if self.next == len(self.rows):
            self.sequence[lane] = None
            self.state[:, lane] = (1.0, 1.0, 0.0, 0.0, 0.0)  # rests out of reach
            self.pars[:, lane] = 0.0
            self.busy -= 1
            return self.busy > 0
        row = self.rows[self.next]
        self.sequence[lane] = Sequence(row[3])
        self.point[lane] = self.next
        self.state[:, lane] = (0.0, row[4], -1.0, 0.0, 0.0)
        self.pars[:, lane] = parameters(row)
        self.ta.reset_cooldowns(lane)
        self.next += 1
        return True

    def solve_all(self, rows: np.ndarray) -> np.ndarray:
        self.rows, self.out = rows.tolist(), np.empty((len(rows), 4))
        self.state, self.pars = self.ta.state, self.ta.pars
        self.next, self.busy = 0, self.lanes
        self.sequence, self.point = [None] * self.lanes, [0] * self.lanes
        self.ta.set_time(0.0)
        for lane in range(self.lanes):
            self._load(lane)
        self.ta.propagate_until(FAR)
        return self.out


@lru_cache
def integrator(mode: str, tol: float):
    return {"scalar": Scalar, "batch": Batch}[mode](tol)


def run(points: scaled.Points, mode: str, tol: float) -> scaled.Results:
    rows, speed, rate = scaled.viscoelastic(points)
    return scaled.Results.of(integrator(mode, tol).solve_all(rows), speed, rate)
