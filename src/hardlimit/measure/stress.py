"""Pressure tensor of a run in its steady state, with errors, and its antisymmetric part over time."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
import xarray as xr

from ..boxes.box import Floats, component_axes
from ..boxes.result import ContactResult, ParticleResult
from ..support import validation
from .labelled import array, axes, regular, variable
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


def antisymmetric_stress(run: ParticleResult | ContactResult) -> xr.DataArray:
    """Antisymmetric part of the pressure tensor P of a run with friction: P_yz − P_zy, P_zx − P_xz, P_xy − P_yx.

    Parameters
    ----------
    run : ParticleResult or ContactResult
        With friction, in a box without walls.

    Returns
    -------
    DataArray
        Over ``time`` and ``axis``; for disks P_xy − P_yx over ``time`` [Pa; disks N/m]. Each value is the mean since
        the previous sample, and NaN at the first sample.

    Raises
    ------
    ValueError
        If it is no result of a box, has no friction, or has walls or a thermostat that change spins.

    Notes
    -----
    A contact conserves angular momentum: a force F on j at the distance r from i to j changes the spins of both by
    −r × F in all. Therefore P_ab − P_ba = −ε_abk (dS_k/dt)/V with the spin S = Σ I ω of the box (de Groot & Mazur,
    Non-Equilibrium Thermodynamics (1962), chapter XII). This is exact with our engines; contacts of LAMMPS conserve
    angular momentum to the order of overlap over diameter. The mean over a steady state is zero. Couple stresses, the
    fluxes of spin by contacts and flights, are not measured: this does not balance the spin of a part of the box.

    Examples
    --------
    >>> x, v = [[0.03, 0.05], [0.05, 0.05]], [[0.1, 0.0], [-0.1, 0.0]]
    >>> pair = {"radius": 0.005, "density": 2500.0, "box": 0.1}
    >>> disks = hl.ParticleSystem(x, v, angular_velocities=[10.0, 10.0], **pair)
    >>> friction = hl.Friction(coefficient=0.5)
    >>> law = hl.LinearDashpot(stiffness=1e3, restitution=0.9, friction=friction)
    >>> run = hl.molecular_dynamics(
    ...     disks, law=law, until=0.1, samples=1, engine="steps"
    ... )
    >>> bool(hl.measure.antisymmetric_stress(run)[-1] > 0.0)  # the disks lose spin
    True
    """
    if not isinstance(run, ParticleResult | ContactResult):
        raise ValueError(f"run: got {validation.shown(run)}, must be a result of a box of grains")
    system, series = run.system, run.series
    if "spin" not in series:
        raise ValueError(
            "run: got one without friction, must have friction: its pressure tensor is symmetric"
        )
    if "wall" in system.boundary:
        raise ValueError(
            "run: got one with walls, must have none: their torques on the grains are not summed"
        )
    if system.thermostat is not None and system.thermostat.rotational is not None:
        raise ValueError(
            f"run: got one with {system.thermostat!r}, must have no thermostat that changes spins"
        )
    time, spin = series["time"].values, series["spin"]
    growth = np.diff(spin.values, axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = -(growth.T / np.diff(time)).T / system.domain.volume
    values = np.concatenate([np.full((1, *growth.shape[1:]), math.nan), mean])
    units = series["pressure"].attrs["units"]
    coordinates = {str(dim): spin[dim].variable for dim in spin.dims}
    about = "antisymmetric part of the pressure tensor, mean since the previous sample"
    return array("antisymmetric_stress", spin.dims, values, units, about, **coordinates)


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
