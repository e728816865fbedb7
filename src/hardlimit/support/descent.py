"""The minimum of a smooth function in a box, of arguments whose sum may be given; bounds are kept exactly.

The steps are those of SLSQP (Kraft, ACM Trans. Math. Softw. 20, 262 (1994)) in NLopt; the gradient is a difference
quotient. MINUIT, which fits use, knows no common constraint, and makes of a bound a curve on which the slope vanishes.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

STEP: Final = 1e-6  #: of the difference quotients
MOST_VALUES: Final = 400  #: on one way down, gradients apart
ENOUGH: Final = 1e-11  #: decrease from one step to the next, with which the search is over
SHORTEST: Final = 1e-9  #: change of the arguments, likewise


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


def descend(function: Callable[[Floats], float], start: Floats, domain: Domain) -> tuple[Floats, float]:
    """Where a function is least, as far as steps downhill from ``start`` lead, and its value there."""
    import nlopt  # only stacks search

    total = float(np.sum(start)) if domain.summed else None
    at = domain.nearest(np.array(start, dtype=float), total)
    value = function(at)

    def look(given: Floats, gradient: Floats) -> float:
        nonlocal at, value
        there = domain.nearest(given, total)
        found = function(there)
        if found < value:
            at, value = there, found
        if gradient.size:
            gradient[:] = _gradient(function, there, found)
        return found

    def excess(given: Floats, gradient: Floats) -> float:
        if gradient.size:
            gradient[:] = 1.0
        return float(np.sum(given)) - float(np.sum(start))

    search: Any = nlopt.opt(nlopt.LD_SLSQP, at.size)
    search.set_min_objective(look)
    search.set_lower_bounds(domain.lowest)
    search.set_upper_bounds(domain.highest)
    if domain.summed:
        search.add_equality_constraint(excess, 1e-12)
    search.set_ftol_abs(ENOUGH)
    search.set_xtol_abs(SHORTEST)
    search.set_maxeval(MOST_VALUES)
    # A jump has no gradient; the lowest point that was seen holds.
    with suppress(nlopt.RoundoffLimited, RuntimeError):
        search.optimize(at)
    return at, value


def _gradient(function: Callable[[Floats], float], at: Floats, value: float) -> Floats:
    found = np.empty_like(at)
    for i in range(at.size):
        beside = at.copy()
        beside[i] -= STEP
        found[i] = (value - function(beside)) / STEP
    return found
