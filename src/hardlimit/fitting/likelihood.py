"""Likelihood of a law: maximum, profile intervals, identifiable parameters, and the probability of χ²."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product
from statistics import NormalDist
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from ..support.estimate import Estimate
from .candidates import Candidate
from .measurements import HOPELESS, Measured

if TYPE_CHECKING:
    from iminuit import Minuit

Floats = NDArray[np.float64]

SCATTER: Final = "scatter"
#: A parameter is not identifiable if a factor e changes all values by less than this many standard errors.
FLAT: Final = 1e-3
#: A message names the parameters with components above this in an unidentifiable direction.
NAMED: Final = 0.2
#: Number of starting points, the best of a coarse grid.
STARTS: Final = 3


@dataclass(frozen=True, eq=False)
class Minimum:
    """The maximum of the likelihood."""

    estimates: dict[str, Estimate[float]]
    covariance: Floats  #: of the free parameters in their order, and of the scatter if it is free
    deviations: Floats  #: decorrelated, in standard errors
    chi_square: float
    minus_two_log_likelihood: float


class Likelihood:
    """−2 ln L of a candidate as a function of its fitted variables; the last is the scatter if it is free."""

    def __init__(self, data: Measured, candidate: Candidate, scatter: bool) -> None:
        self.data, self.candidate, self.scatter = data, candidate, scatter

    def parts(self, variables: Any) -> tuple[Floats, float]:
        """Decorrelated deviations in standard errors, and ln det of the covariance."""
        free = self.candidate.free
        if not np.isfinite(variables).all():  # a step of MINUIT where the likelihood is flat
            return np.full(self.data.n, HOPELESS), 0.0
        values = [p.outer(float(x)) for p, x in zip(free, variables, strict=False)]
        scatter = float(variables[len(free)]) if self.scatter else 0.0
        return self.data.deviations(self.candidate, self.candidate.made(values), scatter)

    def __call__(self, variables: Any) -> float:
        white, logarithm = self.parts(variables)
        value = float(white @ white) + logarithm + white.size * math.log(2.0 * math.pi)
        return value if math.isfinite(value) else 1e300

    def starts(self) -> list[list[float]]:
        """The best points of a coarse grid."""
        guess = [self.data.spread()] if self.scatter else []
        grids = [[p.inner(float(v)) for v in p.grid()] for p in self.candidate.free]
        points = [[*point, *guess] for point in product(*grids)]
        return sorted(points, key=self)[: STARTS if len(points[0]) > 1 else 1]

    def check_identifiable(self, variables: Any) -> None:
        """Refuse parameters, or combinations of them, on which the data do not depend.

        Raises a ValueError if there are any; names them and says what to do.
        """
        free = self.candidate.free
        at = np.array(variables, dtype=float)
        columns = []
        for i, p in enumerate(free):
            scale = 1.0 if p.logarithmic else at[i]
            above, below = at.copy(), at.copy()
            above[i], below[i] = np.clip([at[i] + 1e-4 * scale, at[i] - 1e-4 * scale], *p.limits)
            change = self.parts(above)[0] - self.parts(below)[0]
            columns.append(change / (above[i] - below[i]) * scale)
        _, sizes, directions = np.linalg.svd(np.column_stack(columns), full_matrices=False)
        if sizes.size < len(free):
            raise ValueError(f"free: got {len(free)} parameters, must be at most {sizes.size}, one per value")
        if sizes[-1] > FLAT:
            return
        names = [p.name for p, part in zip(free, directions[-1], strict=True) if abs(part) > NAMED]
        if len(names) == 1:
            raise ValueError(
                f"{names[0]}: cannot be determined from {self.data.what}, must be given in fixed"
            )
        raise ValueError(
            f"{' | '.join(names)}: only a combination of them can be determined from {self.data.what}, "
            "all but one must be given in fixed"
        )


def minimum(data: Measured, candidate: Candidate, scatter: bool, confidence: float) -> Minimum:
    """The most likely parameters and their intervals.

    Raises a ValueError if the data do not determine them.
    """
    from iminuit import Minuit

    likelihood = Likelihood(data, candidate, scatter)
    starts = likelihood.starts()
    fits = [_prepared(Minuit(likelihood, start), likelihood).migrad() for start in starts]
    best = min(fits, key=lambda fit: fit.fval)
    likelihood.check_identifiable(best.values if np.isfinite(best.values).all() else starts[0])
    if scatter and not data.has_errors and best.values[-1] < 2.0 * best.limits[len(candidate.free)][0]:
        raise ValueError(
            "scatter: got values that agree with the law exactly, must have errors of measurement or differ from it"
        )
    best.hesse()
    return _read(best, likelihood, confidence)


def _prepared(fit: Minuit, likelihood: Likelihood) -> Minuit:
    fit.errordef, fit.tol = 1.0, 1e-3
    free = likelihood.candidate.free
    for i, p in enumerate(free):
        fit.limits[i] = p.limits
        fit.errors[i] = 0.1 if p.logarithmic else 0.02
    if likelihood.scatter:
        least = 0.0 if likelihood.data.has_errors else 1e-6 * likelihood.data.spread()
        fit.limits[len(free)] = (least, None)
        fit.errors[len(free)] = 0.1 * likelihood.data.spread()
    return fit


def _read(fit: Minuit, likelihood: Likelihood, confidence: float) -> Minimum:
    free, names = likelihood.candidate.free, [p.name for p in likelihood.candidate.free]
    slopes = [p.outer(fit.values[i]) if p.logarithmic else 1.0 for i, p in enumerate(free)]
    if likelihood.scatter:
        names, slopes = [*names, SCATTER], [*slopes, 1.0]
    inner = np.array(fit.covariance if fit.covariance is not None else np.full((len(names),) * 2, math.nan))
    covariance = inner * np.outer(slopes, slopes)
    values, errors = list(fit.values), np.sqrt(np.diag(covariance))
    white, _ = likelihood.parts(values)
    lowest = float(fit.fval)
    fit.errordef = NormalDist().inv_cdf(0.5 + 0.5 * confidence) ** 2
    fit.hesse()
    ends = [_ends(fit, i) for i in range(len(names))]
    # MINUIT's curvature vanishes at a limit of a variable. The differences below go away from the limit.
    at, (low, high) = np.array(values), np.array(fit.limits).T
    widths = np.abs(np.array(ends) - at[:, None]).max(axis=1) / math.sqrt(fit.errordef)
    if (np.minimum(at - low, high - at) < widths).any():
        steps = 0.1 * widths * np.where(high - at < at - low, -1.0, 1.0)
        curvature = _curvature(likelihood, at, steps)
        if np.linalg.eigvalsh(curvature)[0] > 0.0:
            covariance = 2.0 * np.linalg.inv(curvature) * np.outer(slopes, slopes)
    errors = np.sqrt(np.diag(covariance))
    estimates = {}
    for i, name in enumerate(names):
        outer = free[i].outer if i < len(free) else float
        lower, upper = (outer(end) for end in ends[i])
        estimates[name] = Estimate(outer(values[i]), float(errors[i]), lower, upper)
    return Minimum(estimates, covariance, white, float(white @ white), lowest)


def _curvature(likelihood: Likelihood, at: Floats, steps: Floats) -> Floats:
    """Second derivatives of −2 ln L, by differences towards one side of each variable."""
    shifts = np.diag(steps)
    base = likelihood(at)
    matrix = np.empty((len(at), len(at)))
    for i, shift in enumerate(shifts):
        for j, other in enumerate(shifts):
            apart = likelihood(at + shift) + likelihood(at + other) - base
            matrix[i, j] = (likelihood(at + shift + other) - apart) / (steps[i] * steps[j])
    return matrix


def _ends(fit: Minuit, i: int) -> tuple[float, float]:
    """Ends of the profile interval of one variable; a limit of its range if the likelihood stays above the level."""
    name = fit.parameters[i]
    low, high = fit.limits[i]
    try:
        fit.minos(name)
    except RuntimeError:  # MINOS has left the minimum; use the curvature
        return max(fit.values[i] - fit.errors[i], low), min(fit.values[i] + fit.errors[i], high)
    errors = fit.merrors[name]
    lower = fit.values[i] + errors.lower if errors.lower_valid else low
    upper = fit.values[i] + errors.upper if errors.upper_valid else high
    return max(lower, low), min(upper, high)


def chi_square_probability(chi_square: float, degrees: int) -> float:
    """Probability that χ² with this number of degrees of freedom exceeds ``chi_square``; NaN for zero degrees."""
    from scipy.special import chdtrc

    return float(chdtrc(degrees, chi_square)) if degrees > 0 else math.nan
