"""Pressure tensor of a run in its steady state: kinetic and collisional parts, with errors."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
import xarray as xr

from ..boxes.box import Floats, component_axes
from ..boxes.result import ContactResult, ParticleResult
from ..support import validation
from .labelled import axes, regular, variable
from .steadiness import FEWEST, inefficiency, steady

#: Variables of the Dataset, and of the series of a run.
PARTS: Final = {
    "pressure_tensor": "pressure_tensor",
    "kinetic": "kinetic_pressure_tensor",
    "collisional": "collisional_pressure_tensor",
}


def pressure_tensor(run: ParticleResult | ContactResult, *, start: float | None = None) -> xr.Dataset:
    """Pressure tensor of a run in its steady state, and its kinetic and collisional parts.

    Parameters
    ----------
    run : ParticleResult or ContactResult
    start : float [s], optional
        Where the steady part begins. By default where that of the pressure does (:func:`hardlimit.measure.steady`).

    Returns
    -------
    Dataset
        ``pressure_tensor``, ``kinetic`` and ``collisional`` [Pa; disks N/m], over ``row`` and ``column`` ("x", "y",
        "z"), positive in compression, and the standard error of each with the suffix ``_error``. The attribute
        ``start`` is where the first interval of the steady part begins [s].

    Raises
    ------
    ValueError
        If it is no result of a box, or fewer than four intervals between samples follow ``start``.

    Notes
    -----
    P = ⟨Σ m v'⊗v' + Σ r⊗Δp per time⟩/V, the kinetic and the collisional part, with the velocities v' relative to the
    mean flow in a sheared box and r between the centres of the pairs (LAMMPS' sign and ``compute pressure``: Thompson,
    Plimpton & Mattson, J. Chem. Phys. 131, 154107 (2009)). The shear stress is −P_xy, and the first normal stress
    difference P_yy − P_xx, with the flow along x and its gradient along y. Errors are corrected for the correlation of
    the samples by the statistical inefficiency of each component. The kinetic part of an interval is the mean of both
    samples: its error decreases with the interval.

    Examples
    --------
    >>> box = hl.ParticleSystem.random(
    ...     200, 0.3, radius=1e-3, density=2500.0, rms_speed=1.0
    ... )
    >>> run = hl.event_driven(box, restitution=1.0, until=0.1)
    >>> p = hl.measure.pressure_tensor(run)
    >>> p.kinetic.dims, p.sizes["row"], p.attrs["units"]
    (('row', 'column'), 3, 'Pa')
    >>> bool(
    ...     p.collisional.sel(row="x", column="x") > p.kinetic.sel(row="x", column="x")
    ... )
    True
    """
    if not isinstance(run, ParticleResult | ContactResult):
        raise ValueError(f"run: got {validation.shown(run)}, must be a result of a box of grains")
    series, system = run.series, run.system
    time = series["time"].values
    # A value belongs to the interval before its time; the first one is NaN.
    if start is None:
        at = steady(series["pressure"]).start
        used = np.flatnonzero(time[1:] >= at) + 1
    else:
        at = validation.number("start", start, -math.inf)
        used = np.flatnonzero(time[:-1] >= at - 1e-9 * abs(at)) + 1
    used = used[used < (regular(time) or len(time))]
    if len(used) < FEWEST:
        raise ValueError(f"start: got {at:.6g}, must leave at least {FEWEST} intervals between samples")
    units = series["pressure_tensor"].attrs["units"]
    data = {}
    for name, of in PARTS.items():
        mean, error = _averages(series[of].values[used])
        data[name] = variable(("row", "column"), _matrix(mean, system.dimension), units, _meaning(name))
        about = f"standard error of the {_meaning(name)}"
        data[f"{name}_error"] = variable(("row", "column"), _matrix(error, system.dimension), units, about)
    return xr.Dataset(
        data,
        {"row": axes(system), "column": axes(system)},
        {"units": units, "start": float(time[used[0] - 1])},
    )


def _meaning(name: str) -> str:
    return "pressure tensor" if name == "pressure_tensor" else f"{name} part of the pressure tensor"


def _averages(values: Floats) -> tuple[Floats, Floats]:
    """Mean of each component over the samples, and its standard error."""
    inefficiencies = np.array([inefficiency(x) for x in values.T])
    error: Floats = values.std(axis=0, ddof=1) * np.sqrt(inefficiencies / len(values))
    return values.mean(axis=0), error


def _matrix(components: Floats, dimension: int) -> Floats:
    """The symmetric matrix with these components, xx, yy, zz, xy, xz, yz."""
    first, second = component_axes(dimension)
    matrix = np.empty((dimension, dimension))
    matrix[first, second] = matrix[second, first] = components
    return matrix
