"""Steady state of a driven box: where it begins, and averages with errors over time and replicas."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from ..boxes.box import Floats
from ..measure.steadiness import DECAYS, FEWEST, ONE_SIGMA, RESOLVED, half_widths, inefficiency, steady
from ..support.estimate import Estimate
from ..support.formatting import digits, percent_with_error
from . import statistics

#: Smallest number of independent samples of a steady state in each replica; all together need ``RESOLVED``.
OF_EACH: Final = 3.0

#: Probability that a steady state is refused, for all series together.
REFUSED: Final = 0.001
#: Quantities that must be steady.
EXAMINED: Final = ("granular_temperature", "pressure", "dissipation_rate", "collision_rate")


@dataclass(frozen=True)
class SteadyState:
    """Where the steady state of all models begins; made by ``Fidelity.steady``."""

    first: int  #: number of intervals between samples before it
    start: float  #: its time [s]; NaN if there is none
    reason: str = ""  #: why there is none


def detected(series: Mapping[tuple[str, str], Floats], times: Floats) -> SteadyState:
    """The steady state that all series share.

    ``series`` has the values (replica, interval) by names of quantity and model. Of each, the mean over replicas is
    examined. It is steady from the time that :func:`hardlimit.measure.steady` finds. There is no steady state if the
    means of both halves of this part differ significantly (99.9 % for all series together), or if it has fewer than ten
    independent samples of all replicas together, or fewer than three of each.
    """
    if len(times) - 1 < 2 * FEWEST:
        return SteadyState(0, math.nan, f"it has fewer than {2 * FEWEST} samples")
    if not series:
        return SteadyState(0, math.nan, "and no model reached the end in every replica")
    means = {name: values.mean(axis=0) for name, values in series.items()}
    first = max(steady(mean).n_discarded for mean in means.values())
    for (quantity, model), mean in means.items():
        replicas = len(series[quantity, model])
        reason = _drift(mean[first:], REFUSED / len(means), max(RESOLVED / replicas, OF_EACH))
        if reason:
            return SteadyState(first, math.nan, f"the {quantity} {model} {reason}")
    return SteadyState(first, float(times[first]))


def _drift(part: Floats, level: float, least: float) -> str:
    """Why a series is not steady; empty if it is."""
    if np.ptp(part) == 0.0:
        return ""
    # A drift makes a series look correlated: its own correlation is that of the rest about a line.
    at = np.linspace(-1.0, 1.0, len(part))
    rest = part - part.mean() - at * float(at @ part) / float(at @ at)
    independent = len(part) / inefficiency(rest)
    half = len(part) // 2
    error = 2.0 * float(rest.std(ddof=2)) / math.sqrt(independent)  # of the difference of the halves
    change = float(part[-half:].mean() - part[:half].mean())
    if abs(change) > statistics.student(max(int(independent) - 2, 1), level) * error:
        scale = abs(float(part.mean()))
        return f"still changes by {percent_with_error(change / scale, error / scale)}"
    independent = len(part) / inefficiency(part)
    if independent >= least:
        return ""
    rounded = math.floor(10.0 * independent) / 10.0
    return f"has {digits(rounded, 3)} independent samples, fewer than {digits(least, 2)}"


def average(values: Floats, state: SteadyState) -> Estimate[float]:
    """Mean over the steady state, (replica, interval).

    Error: Student's distribution over replicas; for one replica from the spectrum of its samples.
    """
    part = values[:, state.first :]
    if len(part) > 1:
        return _plain(statistics.mean(part.mean(axis=1)))
    error, half = _within(part[0])
    return _interval(float(part.mean()), error, half)


def difference(values: Floats, reference: Floats, state: SteadyState) -> Estimate[float]:
    """(⟨values⟩ − ⟨reference⟩)/|⟨reference⟩| over the steady state, paired by replica; for one replica, both errors are
    independent."""
    parts = [window[:, state.first :] for window in (values, reference)]
    means = [window.mean(axis=1) for window in parts]
    if len(values) > 1:
        return _plain(statistics.relative_difference(*means))
    value, of_reference = (float(mean[0]) for mean in means)
    if of_reference == 0.0:
        return Estimate(math.nan, math.nan, math.nan, math.nan)
    scale = abs(of_reference)
    bars = [
        math.hypot(own, other * value / of_reference) / scale
        for own, other in zip(*(_within(mean[0]) for mean in parts), strict=True)
    ]
    return _interval((value - of_reference) / scale, *bars)


def _within(part: Floats) -> tuple[float, float]:
    """Standard error of the mean of a stationary series, and the half-width of its interval."""
    error, half = half_widths(part, (ONE_SIGMA, 1.0 - statistics.LEVEL), DECAYS)
    return error, half


def _interval(value: float, error: float, half: float) -> Estimate[float]:
    half = max(half, statistics.SMALLEST)
    return Estimate(value, error, value - half, value + half)


def _plain(estimate: Estimate[Floats]) -> Estimate[float]:
    return Estimate(*(float(part) for part in estimate))
