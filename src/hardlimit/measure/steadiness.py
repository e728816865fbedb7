"""Steady states: end of the equilibration, statistical inefficiency, mean with error; contact value of a run."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

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

#: Number of starts of the steady part that are tried.
STARTS: Final = 50
#: Smallest number of samples of a series.
FEWEST: Final = 4


@dataclass(frozen=True)
class Steady:
    """Mean of a series in its steady state; made by :func:`hardlimit.measure.steady`."""

    mean: Estimate[float]  #: with standard error and 95 % confidence interval (Student's t)
    start: float  #: first time or index of the steady part
    n_discarded: int  #: number of samples before it
    inefficiency: float  #: statistical inefficiency g [samples]: one of g samples is independent
    n_independent: float  #: number of independent samples
    series: xr.DataArray  #: the series without NaN at its start

    def __str__(self) -> str:
        along = self.series[self.series.dims[0]]
        units = [one.attrs.get("units", "1") for one in (self.series, along)]
        value, since = (f" {unit}" if unit != "1" else "" for unit in units)
        return (
            f"{self.mean}{value}, steady from {along.name} {self.start:.6g}{since} on, statistical inefficiency "
            f"{self.inefficiency:.3g} samples, {self.n_independent:.3g} independent samples"
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
    Of 50 starts in the first half of the series, the steady part begins at the one that leaves the most independent
    samples (Chodera, J. Chem. Theory Comput. 12, 1799 (2016)). The statistical inefficiency is
    g = 1 + 2 Σ (1 − k/n) C_k, with the autocorrelation C_k summed up to its first negative value. The variance of the
    mean is g/n times that of the samples. With fewer than some ten independent samples the error is too small: take a
    longer series. A drift over more than half of the series appears as a large inefficiency. Blocking (Flyvbjerg &
    Petersen, J. Chem. Phys. 91, 461 (1989)) estimates the same error.

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
    n, dim = len(x), str(values.dims[0])
    starts = np.unique(np.linspace(0, n // 2, min(n // 2, STARTS) + 1).astype(int))
    found = [(int(k), inefficiency(x[k:])) for k in starts]
    first, g = max(found, key=lambda one: (n - one[0]) / one[1])
    part = x[first:]
    independent = len(part) / g
    error = float(part.std(ddof=1)) / math.sqrt(independent)
    at = float(values[dim].values[first])
    return Steady(_student(float(part.mean()), error, independent), at, first, g, independent, values)


def _student(mean: float, error: float, n: float) -> Estimate[float]:
    from scipy.stats import t

    half = float(t.ppf(0.975, max(n - 1.0, 1.0))) * error
    return Estimate(mean, error, mean - half, mean + half)


def inefficiency(x: Floats) -> float:
    """Statistical inefficiency [samples] of a stationary series; at least 1."""
    n, deviation = len(x), x - x.mean()
    power = (
        np.abs(np.fft.rfft(deviation, 2 * n)) ** 2
    )  # padded with zeros, so that no sample meets the other end
    correlation = np.fft.irfft(power)[:n] / np.arange(n, 0, -1)
    if not correlation[0] > 0.0:
        return 1.0  # a constant
    c = correlation[1:] / correlation[0]
    end = int(np.argmax(c <= 0.0)) if (c <= 0.0).any() else len(c)
    return max(1.0, 1.0 + 2.0 * float((1.0 - np.arange(1, end + 1) / n) @ c[:end]))


def _checked(series: Any) -> xr.DataArray:
    given = series
    if not isinstance(given, xr.DataArray):
        found = validation.as_array(series)
        if found is None or found.ndim != 1:
            raise ValueError(f"series: got {validation.shown(series)}, must be numbers over one dimension")
        given = xr.DataArray(found, dims="sample", name="series")
    if given.ndim != 1 or given.dtype.kind not in "buif":
        raise ValueError(f"series: got {given.dtype} over {given.dims}, must be numbers over one dimension")
    good = ~np.isnan(given.values.astype(float))
    if given.dims[0] not in given.coords:
        given = given.assign_coords({given.dims[0]: np.arange(len(given))})
    kept = given[int(np.argmax(good)) :] if good.any() else given[:0]
    along = kept[kept.dims[0]].values
    if along.dtype.kind in "iuf" and regular(along) == len(along) - 1:
        kept = kept[:-1]
    if len(kept) < FEWEST or not np.isfinite(kept.values.astype(float)).all():
        raise ValueError(
            f"series: got {validation.shown(given.values)}, must be at least {FEWEST} finite numbers"
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
    found = series["collision_rate"].values[1:] / expected
    time = variable("time", series["time"].values[1:], "s", "time after the start of the run")
    return steady(array("contact_value", "time", found, "1", "pair correlation at contact χ", time=time))
