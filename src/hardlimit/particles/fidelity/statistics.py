"""Means over replicas with their standard errors, paired differences, and when a difference leaves its bars."""

from __future__ import annotations

import math
from functools import cache
from typing import Final, NamedTuple

import numpy as np

from ..system import Floats

#: Chance that a difference of nothing lies outside its bars.
LEVEL: Final = 0.01
#: Relative differences below this are not told apart: Newton's equations themselves are solved to 1e-9.
RESOLUTION: Final = 1e-8


class Estimate(NamedTuple):
    """A value with its standard error, NaN where one replica gives none; made by ``Fidelity.difference``.

    Examples
    --------
    >>> from hardlimit.particles.fidelity.statistics import relative_difference
    >>> law, newton = np.array([1.1, 1.3, 1.2]), np.array([1.0, 1.2, 1.1])
    >>> found = relative_difference(law, newton)
    >>> f"{found.mean:.3f} ± {found.error:.3f}"
    '0.091 ± 0.005'
    """

    mean: Floats  #: over replicas
    error: Floats  #: its standard error


def mean(values: Floats) -> Estimate:
    """Over replicas, the first axis."""
    return Estimate(values.mean(axis=0), _standard_error(values))


def relative_difference(values: Floats, reference: Floats) -> Estimate:
    """(⟨values⟩ − ⟨reference⟩)/|⟨reference⟩| over replicas, the first axis; NaN where the reference is zero.

    Values and references of one replica started from the same state: their differences scatter less than they do. The
    error is that of a ratio of means to first order, from what is left of each replica (Cochran, Sampling Techniques,
    6.3).
    """
    scale = reference.mean(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = values.mean(axis=0) / scale
        left = (values - ratio * reference) / np.abs(scale)
        found = np.where(scale == 0.0, math.nan, (ratio - 1.0) * np.sign(scale))
        return Estimate(found, np.where(scale == 0.0, math.nan, _standard_error(left)))


def _standard_error(values: Floats) -> Floats:
    n = len(values)
    if n < 2:
        return np.full(values.shape[1:], math.nan)
    found: Floats = values.std(axis=0, ddof=1) / math.sqrt(n)
    return found


def outside(difference: Estimate, replicas: int) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Whether a difference is told apart from nothing: larger than Student's quantile of its errors."""
    if replicas < 2:
        return np.zeros(np.shape(difference.mean), bool)
    bars = np.maximum(student(replicas - 1) * difference.error, RESOLUTION)
    found = np.abs(difference.mean) > bars
    return np.asarray(found)


def departure(difference: Estimate, replicas: int) -> int | None:
    """The first sample outside the bars whose follower is outside as well; the last one has none. None if there is
    no such sample."""
    out = outside(difference, replicas)
    lasting = np.flatnonzero(out & np.append(out[1:], True))
    return int(lasting[0]) if len(lasting) else None


@cache
def student(freedom: int) -> float:
    """How many standard errors the bars are long: t with P(|T| > t) = 1 % for so many degrees of freedom."""
    low, high = 0.0, 0.5 * math.pi
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if _student_inside(middle, freedom) > 1.0 - LEVEL else (middle, high)
    return math.sqrt(freedom) * math.tan(low)


def _student_inside(angle: float, freedom: int) -> float:
    """P(|T| < t) for t = √freedom·tan(angle): Abramowitz & Stegun, 26.7.3 and 26.7.4."""
    sine, cosine = math.sin(angle), math.cos(angle)
    odd = freedom % 2 == 1
    term, total = (cosine, 0.0) if odd else (1.0, 0.0)
    for k in range(freedom // 2):
        total += term
        term *= cosine**2 * ((2 * k + 2) / (2 * k + 3) if odd else (2 * k + 1) / (2 * k + 2))
    return 2.0 / math.pi * (angle + sine * total) if odd else sine * total
