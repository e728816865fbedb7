"""Motion of the particles of a run: unfolded paths, mean square displacement, diffusion coefficient."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
import xarray as xr

from ..boxes.box import Floats
from ..boxes.contacts import checked_system
from ..boxes.system import ParticleSystem
from ..support import validation
from ..support.estimate import Estimate
from .labelled import array, axes, regular, variable

#: Default of the range of lags of :func:`diffusion`, as fractions of the longest lag.
FITTED: Final = (0.05, 0.25)
#: Accepted exponent of the mean square displacement over lag, 1 for diffusion and 2 for ballistic flight.
EXPONENT: Final = (0.75, 1.25)
PATHS: Final = ("time", "particle", "axis")


def paths(system: ParticleSystem) -> xr.DataArray:
    """Unfolded positions (``particle``, ``axis``) [m]: a particle that leaves a periodic box goes on.

    With ``observe={"paths": hl.measure.paths}`` a run keeps them at each sample, 8·N·d bytes each, for
    :func:`hardlimit.measure.msd` and :func:`hardlimit.measure.diffusion`.

    Parameters
    ----------
    system : ParticleSystem

    Raises
    ------
    ValueError
        If it is no system.

    Notes
    -----
    Engines count how often each particle crosses the box, as the image flags of LAMMPS do (Thompson et al., Comput.
    Phys. Commun. 271, 108171 (2022)). The interval between samples may therefore have any length.
    """
    x = checked_system(system).unfolded_positions
    return array("paths", PATHS[1:], x, "m", "unfolded position", axis=axes(system))


def msd(paths: xr.DataArray) -> xr.DataArray:
    """Mean square displacement [m²] over ``lag`` [s]: mean over all particles and all pairs of samples at this lag.

    Parameters
    ----------
    paths : DataArray over time, particle, axis
        From the series of a run with ``observe={"paths": hl.measure.paths}``. ``paths.sel(axis=["x"])`` gives the
        displacement along one axis, and ``paths - paths.mean("particle")`` removes a common drift.

    Raises
    ------
    ValueError
        If the dimensions are others, or the samples are fewer than two or not equally spaced. A last sample before the
        next regular time is left out.

    Notes
    -----
    The windowed average of Frenkel & Smit, Understanding Molecular Simulation (2002), section 4.4, and of MDAnalysis'
    ``EinsteinMSD``. Long lags have few independent samples.

    Examples
    --------
    >>> box = hl.ParticleSystem.random(
    ...     200, 0.3, radius=1e-3, density=2500.0, rms_speed=1.0
    ... )
    >>> run = hl.event_driven(
    ...     box, restitution=1.0, until=0.1, observe={"paths": hl.measure.paths}
    ... )
    >>> hl.measure.msd(run.series.paths).sizes["lag"]
    101
    >>> print(hl.measure.diffusion(run.series.paths))  # [m²/s]
    0.000... ± ...
    """
    x, spacing = _checked(paths)
    n = len(x)
    values = [float(_squares(x, k).mean()) for k in range(n)]
    lag = variable("lag", spacing * np.arange(n), "s", "time lag")
    return array("msd", "lag", values, "m2", "mean square displacement", lag=lag)


def diffusion(
    paths: xr.DataArray, *, start: float | None = None, stop: float | None = None
) -> Estimate[float]:
    """Diffusion coefficient D [m²/s] with its standard error and 95 % confidence interval.

    D is the slope of the mean square displacement over lag, divided by 2d.

    Parameters
    ----------
    paths : DataArray over time, particle, axis
        As for :func:`hardlimit.measure.msd`.
    start, stop : float [s], optional
        Range of lags of the fitted line; 5 % and 25 % of the longest lag by default. ``start`` must be several mean
        free times.

    Raises
    ------
    ValueError
        If the paths are refused, there are fewer than two lags in the range or particles, or the displacement does not
        grow with the lag as in diffusion: its exponent must be in [0.75, 1.25].

    Notes
    -----
    Einstein's relation (Frenkel & Smit 2002). The error is that of the mean of the slopes of the particles, as if these
    were independent. D in a periodic box of edge L is smaller than in an infinite one, in 3-D by 2.84 k_B T/(6πηL)
    (Yeh & Hummer, J. Phys. Chem. B 108, 15873 (2004)).
    """
    x, spacing = _checked(paths)
    n, particles, d = x.shape
    longest = spacing * (n - 1)
    low, high = (
        fraction * longest
        if end is None
        else validation.number(name, end, 0.0, longest, highest_allowed=True)
        for name, end, fraction in zip(("start", "stop"), (start, stop), FITTED, strict=True)
    )
    steps = [k for k in range(1, n) if low * (1 - 1e-9) <= k * spacing <= high * (1 + 1e-9)]
    if len(steps) < 2 or particles < 2:
        raise ValueError(
            f"start | stop: got {len(steps)} lags in [{low:.6g}, {high:.6g}] s and {particles} particles, must be at "
            "least 2 each: take more samples"
        )
    lags = spacing * np.array(steps)
    squares = np.stack([_squares(x, k) for k in steps])
    centred = lags - lags.mean()
    slopes = centred @ squares / (centred @ centred)
    size = squares.mean(axis=1)
    exponent = float(np.polyfit(np.log(lags), np.log(size), 1)[0]) if size.all() else math.nan
    if not EXPONENT[0] <= exponent <= EXPONENT[1]:
        raise ValueError(
            f"start | stop: got {low:.6g} s and {high:.6g} s, where the mean square displacement grows as "
            f"lag^{exponent:.2f}, must be a range of diffusion, lag^1: longer lags than the mean free time"
        )
    value, error = (float(q) / (2.0 * d) for q in (slopes.mean(), slopes.std(ddof=1) / math.sqrt(particles)))
    return normal_estimate(value, error)


def normal_estimate(value: float, error: float) -> Estimate[float]:
    """An estimate of many samples, with its 95 % confidence interval."""
    return Estimate(value, error, value - 1.96 * error, value + 1.96 * error)


def _squares(x: Floats, step: int) -> Floats:
    """Mean square displacement of each particle over this number of samples."""
    moved = x[step:] - x[: len(x) - step]
    means: Floats = np.einsum("tij,tij->i", moved, moved) / len(moved)
    return means


def _checked(paths: Any) -> tuple[Floats, float]:
    """Positions (time, particle, axis) [m] at equally spaced times, and the spacing [s]."""
    if not isinstance(paths, xr.DataArray) or set(paths.dims) != set(PATHS) or "time" not in paths.coords:
        shown = validation.shown(getattr(paths, "dims", paths))
        raise ValueError(
            f"paths: got {shown}, must be a DataArray over time, particle and axis: observe={{'paths': measure.paths}}"
        )
    x = np.asarray(paths.transpose(*PATHS).values, float)
    time = np.asarray(paths["time"].values, float)
    if (whole := regular(time)) > 1 and time[1] > time[0]:
        return x[:whole], float(time[1] - time[0])
    raise ValueError(
        f"paths: got samples at {validation.shown(time)} s, must be two or more at equal intervals"
    )
