"""Means over replicas with their standard errors, paired differences, and when a difference is first told apart."""

from __future__ import annotations

import math
from bisect import bisect_left
from functools import cache
from typing import Final, NamedTuple

import numpy as np

from ..boxes.box import Floats

#: Chance that a difference of nothing lies outside its bars.
LEVEL: Final = 0.01
#: Relative differences below this are not told apart: Newton's equations themselves are solved to 1e-9.
SMALLEST: Final = 1e-8
MOST_REPLICAS: Final = 1_000_000


class Estimate(NamedTuple):
    """A value with its standard error, NaN where one replica gives none; made by ``Fidelity.difference``.

    Examples
    --------
    >>> from hardlimit.fidelity_study.statistics import relative_difference
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


def bar(error: Floats, replicas: int) -> Floats:
    """How long a bar is: Student's quantile of the standard error; NaN for one replica."""
    found: Floats = math.nan * error if replicas < 2 else student(replicas - 1) * error
    return found


def outside(
    difference: Estimate, replicas: int, level: float = LEVEL
) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Whether a difference is told apart from nothing: larger than its bar."""
    if replicas < 2:
        return np.zeros(np.shape(difference.mean), bool)
    found = np.abs(difference.mean) > np.maximum(student(replicas - 1, level) * difference.error, SMALLEST)
    return np.asarray(found)


def departure(difference: Estimate, replicas: int) -> int | None:
    """The first sample at which the difference is told apart from nothing, though many are looked at; None if there is
    none.

    Half of the level, 1 %, is divided among all samples (Bonferroni). The other half is for a difference that lasts:
    samples are looked at backwards from the last one up to the first that is inside, and tests in a fixed sequence all
    have the level of the first (Maurer, Hothorn & Lehmacher, Biometrie in der chemisch-pharmazeutischen Industrie 6, 3
    (1995)). Whatever the samples have to do with each other, the chance is 1 % at most that the sample given or any
    before it is told apart from nothing by mistake.
    """
    known = np.flatnonzero(np.isfinite(difference.mean))
    if not len(known):
        return None
    single = outside(difference, replicas, 0.5 * LEVEL / len(known))
    inside = known[~outside(difference, replicas, 0.5 * LEVEL)[known]]
    lasting = known[known > inside.max(initial=-1)]
    return min((int(found[0]) for found in (known[single[known]], lasting) if len(found)), default=None)


def replicas_needed(error: float, replicas: int, resolution: float) -> float:
    """How many replicas make the bar as short as ``resolution`` if the standard error falls as the square root of their
    number; infinite above a million, NaN for one replica."""
    if not math.isfinite(error):
        return math.nan
    scatter, counts = error * math.sqrt(replicas), range(2, MOST_REPLICAS + 1)
    enough = bisect_left(counts, True, key=lambda n: student(n - 1) * scatter / math.sqrt(n) <= resolution)
    return float(counts[enough]) if enough < len(counts) else math.inf


@cache
def student(freedom: int, level: float = LEVEL) -> float:
    """How many standard errors the bars are long: t with P(|T| > t) = level for so many degrees of freedom."""
    freedom = min(freedom, 1000)  # from there on it falls by 0.2 %
    low, high = 0.0, 0.5 * math.pi
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if _student_inside(middle, freedom) > 1.0 - level else (middle, high)
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
