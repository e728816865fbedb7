"""Steady states: end of the equilibration, statistical inefficiency, mean with error; contact value of a run."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
import xarray as xr

from ..boxes.box import Floats
from ..boxes.result import ContactResult, ParticleResult
from ..boxes.theory import Gas
from ..support import validation
from ..support.estimate import Estimate
from .labelled import array, regular, variable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Number of intervals in the first half of a series at which the steady part may begin.
STARTS: Final = 25
#: Standard errors by which the beginning of the steady part may differ from the second half, and the number of lengths
#: of the beginning that are compared.
DIFFERENT: Final = 2.0
LENGTHS: Final = 8
#: Fewest independent samples of a mean with an error.
RESOLVED: Final = 10.0
#: Largest number of values, means of blocks if there are more samples.
BLOCKS: Final = 400
#: Correlation times: their number, the shortest [blocks] and the longest over the length.
TIMES: Final = 17
SHORTEST, LONGEST = 0.5, 1.0
#: Spectrum of uncorrelated noise over the height of that of the correlated part.
NOISES: Final = np.append(0.0, np.geomspace(2.0**-17, 2.0, 13))
#: Probability of the interval of one standard error.
ONE_SIGMA: Final = 0.6827
#: Error of the width of an interval, over the largest that it may have.
PRECISION: Final = 1e-12
#: Decay times of what is left of a transient, over the length.
DECAYS: Final = (0.03, 0.1, 0.3)
#: Smallest number of samples of a series.
FEWEST: Final = 4


@dataclass(frozen=True)
class Steady:
    """Mean of a series in its steady state; made by :func:`hardlimit.measure.steady`."""

    mean: Estimate[float]  #: with standard error and 95 % interval
    start: float  #: first time or index of the steady part
    n_discarded: int  #: number of samples before it
    inefficiency: float  #: statistical inefficiency g [samples]: one of g samples is independent
    n_independent: float  #: number of independent samples
    series: xr.DataArray  #: the series without NaN at its start

    @property
    def resolved(self) -> bool:
        """Whether there are at least ten independent samples; a constant has no error."""
        return self.n_independent >= RESOLVED or self.mean.error == 0.0

    def __str__(self) -> str:
        along = self.series[self.series.dims[0]]
        units = [labelled.attrs.get("units", "1") for labelled in (self.series, along)]
        value, since = (f" {unit}" if unit != "1" else "" for unit in units)
        return (
            f"{self.mean}{value}, steady from {along.name} {self.start:.6g}{since} on, statistical inefficiency "
            f"{self.inefficiency:.3g} samples, {self.n_independent:.3g} independent samples"
            + ("" if self.resolved else f": not resolved, fewer than {RESOLVED:g}")
        )

    def plot(self) -> Figure:
        """Plot the series and the mean of its steady part: :func:`hardlimit.measure.plot`."""
        from ..plots import measured

        return measured.measured(self)


def steady(series: Any) -> Steady:
    """Mean of a series in its steady state, with an error that accounts for correlation.

    Parameters
    ----------
    series : DataArray or numbers
        Over time, at equal intervals, such as ``run.series.pressure``. NaN at the start is left out. So is a last
        sample after a shorter interval, as of a run that ``max_collisions`` stopped.

    Raises
    ------
    ValueError
        If it has other dimensions, fewer than four values, or NaN later.

    Notes
    -----
    The steady part begins where no beginning of it, of any length up to a quarter of the series, differs from the
    second half by more than two standard errors, or at twice that time, at most at half of the series.

    The error follows from the spectrum at low frequencies (Heidelberger & Welch, Commun. ACM 24, 233 (1981)). The
    spectrum of an exponential correlation and uncorrelated noise is fitted to the squares of the cosine transform by
    Whittle's likelihood (Ark. Mat. 2, 423 (1953)), with and without an exponential rest of the transient. The interval
    is that of all these fits, weighted by their likelihood: uncorrelated samples and no transient have half of the
    weight before the fit. It contains the mean in 93 to 99 % of series with correlation times of 0 to 30 samples and at
    least two independent ones, with and without transients (tests/measure/test_steadiness.py). Fewer than ten
    independent samples are not enough to know the correlation: the mean is then not resolved. A drift over more than
    half of the series appears as a correlation.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> relaxing = 1.0 + np.exp(-np.arange(1000) / 20) + 0.1 * rng.normal(size=1000)
    >>> s = hl.measure.steady(relaxing)
    >>> print(s.mean)
    0.99... ± 0.003...
    >>> 20 < s.start < 200
    True
    """
    values = _checked(series)
    x = values.values.astype(float)
    first = _start(x)
    part = x[first:]
    error, half = half_widths(part, (ONE_SIGMA, 0.95), DECAYS)
    g = _inefficiency(part, error)
    at, mean = float(values[str(values.dims[0])].values[first]), float(part.mean())
    interval = Estimate(mean, error, mean - half, mean + half)
    return Steady(interval, at, first, g, len(part) / g, values)


def _start(x: Floats) -> int:
    """The first sample of the steady part, by its cumulative sums."""
    half = x[len(x) // 2 :]
    (error,) = half_widths(half, (ONE_SIGMA,))
    sums = np.append(0.0, np.cumsum(x - half.mean()))
    lengths = np.unique(np.geomspace(1, max(len(x) // 4, 1), LENGTHS).astype(int))
    # A mean of few samples scatters at most as much as one of them.
    variance = np.minimum(error**2 * len(half) / lengths, half.var(ddof=1))
    allowed = DIFFERENT * np.sqrt(variance + error**2) + 1e-12 * float(np.abs(x).max())
    for k in np.unique(np.linspace(0, len(x) // 2, STARTS + 1).astype(int)):
        if (np.abs(sums[k + lengths] - sums[k]) <= allowed * lengths).all():
            break
    return min(2 * int(k), len(x) // 2)


def inefficiency(x: Floats) -> float:
    """Statistical inefficiency [samples] of a stationary series; at least 1."""
    return _inefficiency(x, half_widths(x, (ONE_SIGMA,))[0])


def _inefficiency(x: Floats, error: float) -> float:
    variance = float(x.var(ddof=1))
    return max(1.0, len(x) * error**2 / variance) if error > 0.0 else 1.0


class _Spectra(NamedTuple):
    """Spectra of unit height at frequency zero over frequency, one a row, for a number of values."""

    inverse: Floats  #: 1/S at the frequencies of the cosine transform
    logarithm: Floats  #: Σ log S
    variance: Floats  #: mean S
    weight: Floats  #: logarithm of the weight before the fit


@lru_cache(maxsize=8)
def _spectra(k: int) -> _Spectra:
    """Uncorrelated noise, and exponential correlations, each with several amounts of uncorrelated noise.

    The spectrum of a correlation a^|j| is ∝ 1/(1 − 2a cos ω + a²).
    """
    cosine = np.cos(np.pi * np.arange(1, k) / k)
    a = np.exp(-1.0 / np.geomspace(SHORTEST, max(LONGEST * k, 2.0), TIMES))[:, None]
    correlated = (1.0 - a) ** 2 / (1.0 - 2.0 * a * cosine + a * a)
    noisy = ((NOISES[:, None, None] + correlated) / (1.0 + NOISES[:, None, None])).reshape(-1, k - 1)
    s = np.vstack([noisy, np.ones(k - 1)])
    weight = np.append(np.full(len(noisy), 0.5 / len(noisy)), 0.5)
    return _Spectra(1.0 / s, np.log(s).sum(axis=1), s.mean(axis=1), np.log(weight))


def half_widths(x: Floats, levels: Sequence[float], decays: Sequence[float] = ()) -> list[float]:
    """Half-widths of intervals about the mean of a series, which contain its expectation with these probabilities.

    Given a spectrum of height s² S, the mean has Student's distribution of variance s² S(0)/k about the expectation.
    A transient A e^(−t/θ), with A normally distributed before the fit with the variance of the series, shifts it.
    """
    if not np.ptp(x) > 0.0:
        return [0.0] * len(levels)
    block = max(1, len(x) // BLOCKS)
    k = len(x) // block
    y = x[len(x) - k * block :].reshape(k, block).mean(axis=1)
    spectra, freedom = _spectra(k), k - 1
    c = _cosines(y)
    squares = spectra.inverse @ (c * c)
    likelihood = spectra.weight - 0.5 * spectra.logarithm
    fits = [(likelihood - 0.5 * freedom * np.log(squares), 0.0 * squares, squares / k)]
    for theta in decays:
        transient = np.exp(-np.arange(k) / (theta * k))
        d, shift = _cosines(transient), float(transient.mean())
        curvature = spectra.inverse @ (d * d) + 1.0 / spectra.variance
        amplitude = spectra.inverse @ (c * d) / curvature
        left = squares - amplitude**2 * curvature
        evidence = likelihood - 0.5 * freedom * np.log(left) - 0.5 * np.log(curvature * spectra.variance)
        fits.append(
            (evidence - math.log(len(decays)), amplitude * shift, left * (1.0 / k + shift**2 / curvature))
        )
    logarithm, shifts, variances = (np.concatenate(part) for part in zip(*fits, strict=True))
    weight = np.exp(logarithm - logarithm.max())
    likely = weight > 1e-6 * weight.sum()
    weight, shifts, sigma = weight[likely], shifts[likely], np.sqrt(variances[likely] / freedom)
    return [_quantile(level, weight / weight.sum(), shifts, sigma, freedom) for level in levels]


def _cosines(y: Floats) -> Floats:
    """Cosine transform without the mean."""
    from scipy.fft import dct

    coefficients: Floats = dct(y - y.mean(), norm="ortho")[1:]
    return coefficients


def _quantile(level: float, weight: Floats, shift: Floats, sigma: Floats, freedom: int) -> float:
    """The h with P(|x| ≤ h) = level for a mixture of Student's distributions."""
    from scipy.optimize import brentq
    from scipy.special import stdtr, stdtrit

    def excess(h: float) -> float:
        inside = stdtr(freedom, (h - shift) / sigma) - stdtr(freedom, (-h - shift) / sigma)
        return float(weight @ inside) - level

    high = float((np.abs(shift) + sigma).max()) * float(stdtrit(freedom, 0.5 + 0.5 * level) + 1.0)
    return float(brentq(excess, 0.0, high, xtol=PRECISION * high))


def _checked(series: Any) -> xr.DataArray:
    labelled = series
    if not isinstance(labelled, xr.DataArray):
        values = validation.as_array(series)
        if values is None or values.ndim != 1:
            raise ValueError(f"series: got {validation.shown(series)}, must be numbers over one dimension")
        labelled = xr.DataArray(values, dims="sample", name="series")
    if labelled.ndim != 1 or labelled.dtype.kind not in "buif":
        raise ValueError(
            f"series: got {labelled.dtype} over {labelled.dims}, must be numbers over one dimension"
        )
    good = ~np.isnan(labelled.values.astype(float))
    if labelled.dims[0] not in labelled.coords:
        labelled = labelled.assign_coords({labelled.dims[0]: np.arange(len(labelled))})
    kept = labelled[int(np.argmax(good)) :] if good.any() else labelled[:0]
    along = kept[kept.dims[0]].values
    if along.dtype.kind in "iuf" and regular(along) == len(along) - 1:
        kept = kept[:-1]
    if len(kept) < FEWEST or not np.isfinite(kept.values.astype(float)).all():
        raise ValueError(
            f"series: got {validation.shown(labelled.values)}, must be at least {FEWEST} finite numbers"
        )
    return kept


def contact_value(run: ParticleResult | ContactResult) -> Steady:
    """Pair correlation function at contact, χ = g(2R⁺), from the collision rate of a run, without bins.

    χ is the measured collision rate of pairs over Enskog's for χ = 1, in each interval between samples. It is the limit
    of :func:`hardlimit.measure.rdf` at contact.

    Parameters
    ----------
    run : ParticleResult or ContactResult
        Of equal particles in a periodic box without gravity.

    Returns
    -------
    Steady
        With the value ``mean``.

    Raises
    ------
    ValueError
        If the particles differ, the box has walls or gravity, or the run has fewer than four intervals or no motion.

    Notes
    -----
    Enskog's rate is 4√π n (2R)² χ √T for spheres and 2√π n (2R) χ √T for disks (Chapman & Cowling 1970), here with
    N − 1 partners. √T is the mean of both ends of an interval, which must be short compared with the cooling time. The
    velocities must be nearly Maxwellian: a fourth cumulant a₂ changes the rate by a factor 1 − a₂/16 (van Noije & Ernst
    1998). Under Newton's equations χ includes the effect of contacts that last.
    """
    if not isinstance(run, ParticleResult | ContactResult):
        raise ValueError(f"run: got {validation.shown(run)}, must be a result of a box of grains")
    system, series = run.system, run.series
    if "wall" in system.boundary or system.gravity.any() or np.ptp(system.radius) or np.ptp(system.mass):
        raise ValueError(f"run: got {system!r}, must be of equal particles in a periodic box without gravity")
    gas = Gas(
        system.n, float(system.radius[0]), float(system.mass[0]), system.domain.volume, system.dimension
    )
    root = np.sqrt(series["granular_temperature"].values)
    if system.n < 2 or not root.min() > 0.0:
        raise ValueError(
            "run: got a system without relative motion, must have a granular temperature above 0"
        )
    speed = 0.5 * (root[1:] + root[:-1])
    # Enskog's rate has N partners and their relative speed √(2T); N particles have N − 1 and √(2T N/(N − 1)).
    expected = float(gas.collision_rate(1.0)) / gas.contact_value * math.sqrt(1.0 - 1.0 / system.n) * speed
    values = series["collision_rate"].values[1:] / expected
    time = variable("time", series["time"].values[1:], "s", "time after the start of the run")
    return steady(array("contact_value", "time", values, "1", "pair correlation at contact χ", time=time))
