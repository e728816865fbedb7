"""Means over replicas, paired differences, and the first time at which a difference is significant."""

from __future__ import annotations

import math
from bisect import bisect_left
from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ..boxes.box import Floats
from ..support.estimate import Estimate

#: Probability that a true difference of zero lies outside its confidence interval.
LEVEL: Final = 0.01
#: Smallest half-width of an interval of relative differences: Newton's equations are solved to 1e-9.
SMALLEST: Final = 1e-8
MAX_REPLICAS: Final = 1_000_000


def mean(values: Floats) -> Estimate[Floats]:
    """Mean over replicas, the first axis."""
    return with_interval(values.mean(axis=0), _standard_error(values), len(values))


def relative_difference(values: Floats, reference: Floats) -> Estimate[Floats]:
    """(⟨values⟩ − ⟨reference⟩)/|⟨reference⟩| over replicas, the first axis; NaN where the reference is zero.

    Values and references of a replica share their initial state, so their differences scatter less than they do. The
    error is that of a ratio of means to first order, from the residuals of the replicas (Cochran, Sampling Techniques,
    6.3).
    """
    scale = reference.mean(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = values.mean(axis=0) / scale
        residual = (values - ratio * reference) / np.abs(scale)
        difference = np.where(scale == 0.0, math.nan, (ratio - 1.0) * np.sign(scale))
        error = np.where(scale == 0.0, math.nan, _standard_error(residual))
    return with_interval(difference, error, len(values))


def with_interval(value: Floats, error: Floats, replicas: int) -> Estimate[Floats]:
    """The confidence interval of a mean over replicas: Student's distribution; NaN for one replica."""
    half = np.maximum(student(replicas - 1) * error, SMALLEST)
    return Estimate(value, error, value - half, value + half)


def _standard_error(values: Floats) -> Floats:
    n = len(values)
    if n < 2:
        return np.full(values.shape[1:], math.nan)
    error: Floats = values.std(axis=0, ddof=1) / math.sqrt(n)
    return error


def significant(difference: Estimate[Floats], replicas: int, level: float = LEVEL) -> NDArray[np.bool_]:
    """Whether a difference is outside the interval of zero at this level; never with one replica."""
    half = np.maximum(student(replicas - 1, level) * difference.error, SMALLEST)
    return np.asarray(np.abs(difference.value) > half)


def departure(difference: Estimate[Floats], replicas: int) -> int | None:
    """The first sample at which the difference is significant by the tests of :meth:`Fidelity.departure`, or None.

    The probability that this sample, or an earlier one, is a false positive is at most 1 %, whatever the correlation
    between samples: each of the two tests has half of this level.
    """
    known = np.flatnonzero(np.isfinite(difference.value))
    if not len(known):
        return None
    single = known[significant(difference, replicas, 0.5 * LEVEL / len(known))[known]]
    inside = known[~significant(difference, replicas, 0.5 * LEVEL)[known]]
    lasting = known[known > inside.max(initial=-1)]
    return min((int(samples[0]) for samples in (single, lasting) if len(samples)), default=None)


def replicas_needed(error: float, replicas: int, resolution: float) -> float:
    """Number of replicas for which the half-width of the confidence interval would be ``resolution``.

    The standard error is taken to fall as the square root of the number. Infinite above a million, NaN for one replica.
    """
    if not math.isfinite(error):
        return math.nan
    scatter, counts = error * math.sqrt(replicas), range(2, MAX_REPLICAS + 1)
    enough = bisect_left(counts, True, key=lambda n: student(n - 1) * scatter / math.sqrt(n) <= resolution)
    return float(counts[enough]) if enough < len(counts) else math.inf


@cache
def student(freedom: int, level: float = LEVEL) -> float:
    """t with P(|T| > t) = level for Student's distribution; NaN without degrees of freedom."""
    from scipy.special import stdtrit

    return float(stdtrit(freedom, 1.0 - 0.5 * level)) if freedom > 0 else math.nan
