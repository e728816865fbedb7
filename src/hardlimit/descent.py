"""The minimum of a smooth function in a box, of arguments whose sum may be given; bounds are kept exactly.

Sequential quadratic programming with the update of Broyden, Fletcher, Goldfarb and Shanno, damped as by Powell: Nocedal
& Wright, Numerical Optimization (2006), chapters 16 and 18. The gradient is a difference quotient. MINUIT, which fits
use, knows no common constraint, and makes of a bound a curve on which the slope vanishes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

STEP: Final = 1e-6  #: of the difference quotients
MOST_ITERATIONS: Final = 200
ENOUGH: Final = 1e-11  #: decrease that the model promises, below which the search is over
SUFFICIENT: Final = 1e-4  #: part of the promised decrease with which a step is taken
SHORTEST: Final = 1e-8  #: part of a step that is tried
STEEPEST: Final = 1e8  #: curvature that is believed; a jump of the function looks like more
ROUNDING: Final = 1e-12  #: of the curvatures in a model, which keeps it convex


@dataclass(frozen=True)
class Domain:
    """Arguments between two bounds; ``summed`` keeps their sum."""

    lowest: float
    highest: float
    summed: bool

    def nearest(self, given: Floats, total: float | None) -> Floats:
        """Arguments in the domain: these, moved by the same amount until their sum is right, but not beyond a bound."""
        if total is None:
            return np.clip(given, self.lowest, self.highest)
        low, high = self.lowest - float(np.max(given)), self.highest - float(np.min(given))
        for _ in range(80):
            middle = 0.5 * (low + high)
            moved = np.clip(given + middle, self.lowest, self.highest)
            low, high = (middle, high) if moved.sum() < total else (low, middle)
        return moved

    def step(self, at: Floats, gradient: Floats, curvature: Floats) -> Floats:
        """The d that minimises g·d + d·B d/2 with ``at`` + d in the domain, by an active set that begins at d = 0."""
        low, high = self.lowest - at, self.highest - at
        found = np.zeros_like(at)
        bound = ((low >= 0.0) & (gradient > 0.0)) | ((high <= 0.0) & (gradient < 0.0))
        for _ in range(20 * at.size):
            free = np.flatnonzero(~bound)
            aim, level = self._free_minimum(found, free, gradient, curvature)
            way = aim - found
            with np.errstate(divide="ignore", invalid="ignore"):
                room = np.where(
                    way > 0.0, (high - found) / way, np.where(way < 0.0, (low - found) / way, np.inf)
                )
            first = int(np.argmin(room))
            if room[first] < 1.0:
                found = np.clip(found + max(room[first], 0.0) * way, low, high)
                bound[first] = True
                continue
            found = np.clip(aim, low, high)
            slope = gradient + curvature @ found - level
            inward = np.where(bound, np.where(found <= low, -slope, slope), 0.0)
            worst = int(np.argmax(inward))
            if inward[worst] <= 1e-12 * (1.0 + float(np.max(np.abs(gradient)))):
                break
            bound[worst] = False
        return found

    def _free_minimum(
        self, at: Floats, free: NDArray[np.intp], gradient: Floats, curvature: Floats
    ) -> tuple[Floats, float]:
        """The minimum over the free arguments, and the multiplier of the sum."""
        aim = at.copy()
        if free.size <= self.summed:
            slope = gradient + curvature @ at
            return aim, float(slope[free[0]]) if free.size else 0.0
        slope = (gradient + curvature @ at)[free]
        inner = curvature[np.ix_(free, free)]
        inner = inner + ROUNDING * np.trace(inner) * np.eye(free.size)
        if not self.summed:
            aim[free] -= np.linalg.solve(inner, slope)
            return aim, 0.0
        ones = np.ones(free.size)
        down, even = np.linalg.solve(inner, np.stack([slope, ones], axis=1)).T
        level = float(down.sum() / even.sum())
        aim[free] += level * even - down
        return aim, level


def descend(function: Callable[[Floats], float], start: Floats, domain: Domain) -> tuple[Floats, float]:
    """Where a function is least, as far as steps downhill from ``start`` lead, and its value there."""
    at, value = np.array(start, dtype=float), function(start)
    slope, curvature = _gradient(function, at, value), np.eye(at.size)
    fresh = True  # whether nothing is known of the curvature yet
    for _ in range(MOST_ITERATIONS):
        step = domain.step(at, slope, curvature)
        promised = -float(slope @ step)
        taken = _shortened(function, at, value, step, promised) if promised > ENOUGH else None
        if taken is None:
            if fresh:
                break
            curvature, fresh = np.eye(at.size), True
            continue
        at, value, way = taken
        before, slope = slope, _gradient(function, at, value)
        curvature, fresh = _updated(curvature, way, slope - before), False
    return at, value


def _gradient(function: Callable[[Floats], float], at: Floats, value: float) -> Floats:
    found = np.empty_like(at)
    for i in range(at.size):
        beside = at.copy()
        beside[i] -= STEP
        found[i] = (value - function(beside)) / STEP
    return found


def _shortened(
    function: Callable[[Floats], float], at: Floats, value: float, step: Floats, promised: float
) -> tuple[Floats, float, Floats] | None:
    """The first point along a step that is low enough, its value and the way to it; None if there is none."""
    part = 1.0
    while part >= SHORTEST:
        there = at + part * step
        found = function(there)
        if found <= value - SUFFICIENT * part * promised:
            return there, found, part * step
        # The minimum of the parabola through both values and the slope here.
        part *= min(max(0.5 * part * promised / (found - value + part * promised), 0.1), 0.5)
    return None


def _updated(curvature: Floats, way: Floats, change: Floats) -> Floats:
    """B with what a step has told of it; kept positive."""
    moved = curvature @ way
    before, measured = float(way @ moved), float(way @ change)
    if measured < 0.2 * before:
        share = 0.8 * before / (before - measured)
        change = share * change + (1.0 - share) * moved
    if not float(change @ change) <= STEEPEST * float(way @ change):
        return curvature
    return curvature - np.outer(moved, moved) / before + np.outer(change, change) / float(way @ change)
