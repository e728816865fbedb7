"""Taylor integration with heyoka.py and terminal events, one point at a time or a batch of points.

One integrator serves all motions, selected by its parameters. Callbacks change the parameters and let the integration
continue. In a batch, the callback that ends a point loads the next point into its lane, so that no lane idles.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import heyoka as hy
import numpy as np

from . import scaled
from .sequence import Sequence

FAR = 1e9

# heyoka's root finder sometimes warns ("too many iterations"). At tol 1e-7, 13 of 2000 random points of the linear law
# warned, all with the right count; the only wrong count came without a warning.
hy.set_logger_level_error()


class Problem(NamedTuple):
    """Equations and events of a law. The variables start at (0, δ, −1, 0, …)."""

    system: Callable  # () -> equations, events with rising zeros
    handle: Callable  # (event, sequence, state, parameters, time) -> whether the sequence is over
    parameters: Callable  # row -> parameters at the start
    n_variables: int
    n_parameters: int

    def events(self, make, events, callback) -> list:
        rising = hy.event_direction.positive
        return [make(e, callback=callback(i), direction=rising) for i, e in enumerate(events)]

    def start(self, row) -> list[float]:
        return [0.0, row[4], -1.0] + [0.0] * (self.n_variables - 3)


class Scalar:
    def __init__(self, problem: Problem, tol: float) -> None:
        self.problem, self.sequence = problem, None
        equations, events = problem.system()
        t_events = problem.events(hy.t_event, events, self._callback)
        state = [0.0] * problem.n_variables
        self.ta = hy.taylor_adaptive(
            equations, state, pars=[0.0] * problem.n_parameters, t_events=t_events, tol=tol
        )

    def _callback(self, which):
        def call(ta, sign):
            return not self.problem.handle(which, self.sequence, ta.state, ta.pars, ta.time)

        return call

    def solve_all(self, rows: np.ndarray) -> np.ndarray:
        out = np.empty((len(rows), 4))
        ta = self.ta
        for i, row in enumerate(rows.tolist()):
            self.sequence = Sequence(row[3])
            ta.time = 0.0
            ta.reset_cooldowns()
            ta.state[:] = self.problem.start(row)
            ta.pars[:] = self.problem.parameters(row)
            ta.propagate_until(FAR)
            out[i] = self.sequence.row()
        return out


class Batch:
    def __init__(self, problem: Problem, tol: float) -> None:
        self.problem = problem
        equations, events = problem.system()
        t_events = problem.events(hy.t_event_batch, events, self._callback)
        self.lanes = n = hy.recommended_simd_size()
        zeros = {"state": np.zeros((problem.n_variables, n)), "pars": np.zeros((problem.n_parameters, n))}
        self.ta = hy.taylor_adaptive_batch(equations, t_events=t_events, tol=tol, **zeros)

    def _callback(self, which):
        def call(ta, sign, lane):
            s = self.sequence[lane]
            state, par = self.state[:, lane], self.pars[:, lane]
            if s is not None and self.problem.handle(which, s, state, par, ta.time[lane] - self.begin[lane]):
                self.out[self.point[lane]] = s.row()
                return self._load(lane, ta.time[lane])
            return True

        return call

    def _load(self, lane, time) -> bool:
        """Load the next point into a lane; returns whether any lane has work."""
        if self.next == len(self.rows):
            self.sequence[lane] = None
            at_rest = [1.0, 1.0] + [0.0] * (self.problem.n_variables - 2)  # out of contact
            self.state[:, lane] = at_rest
            self.pars[:, lane] = 0.0
            self.busy -= 1
            return self.busy > 0
        row = self.rows[self.next]
        self.sequence[lane] = Sequence(row[3])
        self.point[lane], self.begin[lane] = self.next, time
        self.state[:, lane] = self.problem.start(row)
        self.pars[:, lane] = self.problem.parameters(row)
        self.ta.reset_cooldowns(lane)
        self.next += 1
        return True

    def solve_all(self, rows: np.ndarray) -> np.ndarray:
        self.rows, self.out = rows.tolist(), np.empty((len(rows), 4))
        self.state, self.pars = self.ta.state, self.ta.pars
        self.next, self.busy = 0, self.lanes
        self.sequence, self.point, self.begin = [None] * self.lanes, [0] * self.lanes, [0.0] * self.lanes
        self.ta.set_time(0.0)
        for lane in range(self.lanes):
            self._load(lane, 0.0)
        self.ta.propagate_until(FAR)
        return self.out


@lru_cache
def integrator(problem: Problem, mode: str, tol: float) -> Scalar | Batch:
    """``mode`` is "scalar" or "batch"."""
    return {"scalar": Scalar, "batch": Batch}[mode](problem, tol)


def solve_all(problem: Problem, units: tuple, mode: str, tol: float) -> scaled.Results:
    """``units``: rows, speeds and rates of the points, as from `scaled.py`."""
    rows, speed, rate = units
    return scaled.Results.of(integrator(problem, mode, tol).solve_all(rows), speed, rate)
