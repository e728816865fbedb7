"""Linear dashpot, heyoka.py: Taylor series with terminal events, one point at a time or eight in a batch.

One integrator for all motions, chosen by parameters. The switch of a contact is one event with a rising
zero, sign·(gap + c·rate): sign = 1 while the force acts, −1 while it does not; c = 0 once the gap has
opened, which is the second event. Callbacks change the parameters and let the integration go on; in a
batch, the callback that ends a point puts the next one into its lane, so that no lane waits for another.
"""

from __future__ import annotations

from functools import lru_cache

import heyoka as hy
import numpy as np

from . import scaled
from .sequence import Sequence

KAPPA, G, D1, D2, FLOOR, PAIR, SIGN_U, C_U, SIGN_W, C_W = range(10)
FAR = 1e9

# Its root finder warns now and then ("too many iterations"). At tol 1e-7, 13 of 2000 random points warned,
# all with the right count; the one wrong count came without a warning.
hy.set_logger_level_error()


def system():
    u, w, p, q = hy.make_vars("u", "w", "p", "q")
    par = hy.par
    f01 = -par[FLOOR] * par[KAPPA] * (u + par[D1] * p)
    f12 = -par[PAIR] * (w + par[D2] * q)
    equations = [(u, p), (w, q), (p, f01 - par[KAPPA] * f12 - par[G]), (q, f12 - f01)]
    events = [par[SIGN_U] * (u + par[C_U] * p), u, par[SIGN_W] * (w + par[C_W] * q), w]
    return equations, events


def handle(which, s, state, par, t):
    """One switch; returns whether the sequence is over."""
    u, _, p, q = state
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


class Scalar:
    def __init__(self, tol: float) -> None:
        equations, events = system()
        rising = hy.event_direction.positive
        made = [hy.t_event(e, callback=self._callback(i), direction=rising) for i, e in enumerate(events)]
        self.ta = hy.taylor_adaptive(equations, [0.0] * 4, pars=[0.0] * 10, t_events=made, tol=tol)
        self.sequence = None

    def _callback(self, which):
        def call(ta, sign):
            return not handle(which, self.sequence, ta.state.tolist(), ta.pars, ta.time)

        return call

    def solve_all(self, rows: np.ndarray) -> np.ndarray:
        out = np.empty((len(rows), 4))
        ta = self.ta
        for i, row in enumerate(rows.tolist()):
            self.sequence = Sequence(row[3])
            ta.time = 0.0
            ta.reset_cooldowns()
            ta.state[:] = (0.0, row[4], -1.0, 0.0)
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
        zeros = {"state": np.zeros((4, n)), "pars": np.zeros((10, n))}
        self.ta = hy.taylor_adaptive_batch(equations, t_events=made, tol=tol, **zeros)

    def _callback(self, which):
        def call(ta, sign, lane):
            s = self.sequence[lane]
            state, par = self.state[:, lane], self.pars[:, lane]
            t = ta.time[lane] - self.start[lane]
            if s is not None and handle(which, s, state.tolist(), par, t):
                self.out[self.point[lane]] = s.row()
                return self._load(lane, ta.time[lane])
            return True

        return call

    def _load(self, lane, time):
        """The next point into a lane; returns whether any lane has work."""
        if self.next == len(self.rows):
            self.sequence[lane] = None
            self.state[:, lane] = (1.0, 1.0, 0.0, 0.0)  # rests out of reach
            self.pars[:, lane] = 0.0
            self.busy -= 1
            return self.busy > 0
        row = self.rows[self.next]
        self.sequence[lane] = Sequence(row[3])
        self.point[lane], self.start[lane] = self.next, time
        self.state[:, lane] = (0.0, row[4], -1.0, 0.0)
        self.pars[:, lane] = parameters(row)
        self.ta.reset_cooldowns(lane)
        self.next += 1
        return True

    def solve_all(self, rows: np.ndarray) -> np.ndarray:
        self.rows, self.out = rows.tolist(), np.empty((len(rows), 4))
        self.state, self.pars = self.ta.state, self.ta.pars
        self.next, self.busy = 0, self.lanes
        self.sequence, self.point, self.start = [None] * self.lanes, [0] * self.lanes, [0.0] * self.lanes
        self.ta.set_time(0.0)
        for lane in range(self.lanes):
            self._load(lane, 0.0)
        self.ta.propagate_until(FAR)
        return self.out


@lru_cache
def integrator(mode: str, tol: float):
    return {"scalar": Scalar, "batch": Batch}[mode](tol)


def run(points: scaled.Points, mode: str, tol: float) -> scaled.Results:
    rows, speed, rate = scaled.linear(points)
    return scaled.Results.of(integrator(mode, tol).solve_all(rows), speed, rate)
