"""Velocities of a state: granular temperature, fourth cumulant, and profiles along an axis."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..boxes.box import Floats
from ..boxes.contacts import checked_system
from ..boxes.system import ParticleSystem
from ..support import validation
from .labelled import array, axes, checked_axis, checked_bins, variable

#: The streaming velocity: an axis along which bins have their mean velocity, or u(positions).
Streaming = str | Callable[[Floats], Any] | None


def granular_temperature(
    system: ParticleSystem, *, streaming: Streaming = None, bins: int = 20
) -> xr.DataArray:
    """Granular temperature T = Σ m|v − u|²/(d Σ m) [m²/s²], with the streaming velocity u removed.

    Parameters
    ----------
    system : ParticleSystem
    streaming : axis ("x", "y" or "z") or callable, optional
        The streaming velocity. By default the velocity of the centre of mass; in a sheared box the mean flow, plus the
        velocity of the centre of mass relative to it. With an axis, the mean velocity of each bin along it. A function
        gets the positions (N, d) [m] and returns velocities (N, d) [m/s].
    bins : int
        Number of equal bins along the axis. Many bins make T too small, by a fraction of about bins/N; few bins make it
        too large in a shear flow, by (shear rate × width of a bin)²/(12 d).

    Raises
    ------
    ValueError
        If a value is outside its range, or ``streaming`` does not return velocities.

    Notes
    -----
    Goldhirsch, Powder Technol. 182, 130 (2008). LAMMPS calls it ``compute temp/profile``.
    """
    twice = _thermal(system, streaming, bins)
    value = float(twice.sum()) / (system.dimension * float(system.mass.sum()))
    return array("granular_temperature", (), value, "m2/s2", "granular temperature Σ m|v − u|²/(d Σ m)")


def a2(system: ParticleSystem, *, streaming: Streaming = None, bins: int = 20) -> xr.DataArray:
    """Fourth cumulant of the velocities, a₂ = d⟨c⁴⟩/((d + 2)⟨c²⟩²) − 1: 0 for Maxwell's distribution.

    c² is m|v − u|², so that a mixture in equilibrium has a₂ = 0 too. NaN without relative motion. Parameters and
    errors are those of :func:`hardlimit.measure.granular_temperature`.

    Notes
    -----
    The coefficient of the second Sonine polynomial (van Noije & Ernst, Granular Matter 1, 57 (1998)). The standard
    error of one state is √(8/(d (d + 2) N)) for nearly Maxwellian velocities.
    """
    squared = _thermal(system, streaming, bins)
    d, mean = system.dimension, float(squared.mean())
    rounding = 1e-20 * 2.0 * system.kinetic_energy / system.n
    value = d * float(np.mean((squared / mean) ** 2)) / (d + 2) - 1.0 if mean > rounding else math.nan
    return array("a2", (), value, "1", "fourth cumulant a2 of the velocities")


def _thermal(system: ParticleSystem, streaming: Streaming, bins: Any) -> Floats:
    """m|v − u|² of each particle [J]."""
    checked_system(system)
    mass, velocities = system.mass, system.velocities
    count = checked_bins(bins)
    if streaming is None:
        flow = system.domain.mean_flow(system.positions)
        flow += mass @ (velocities - flow) / mass.sum()
    elif isinstance(streaming, str):
        bin_of = _bins(system, checked_axis("streaming", streaming, system), count)
        flow = _mean_velocities(system, bin_of, count)[bin_of]
    elif callable(streaming):
        flow = validation.rows("streaming", streaming(system.positions), (system.dimension,))
        if len(flow) != system.n:
            raise ValueError(
                f"streaming: got shape {flow.shape}, must be {velocities.shape} as the positions"
            )
    else:
        raise ValueError(
            f"streaming: got {validation.shown(streaming)}, must be an axis or a function of positions"
        )
    relative = velocities - flow
    energies: Floats = mass * np.einsum("ij,ij->i", relative, relative)
    return energies


def _bins(system: ParticleSystem, axis: int, bins: int) -> NDArray[np.int64]:
    """The bin of each centre."""
    at: NDArray[np.int64] = (system.positions[:, axis] / system.box[axis] * bins).astype(np.int64)
    return np.clip(at, 0, bins - 1)  # a wall that moves lets particles out of the box


def _sums(bin_of: NDArray[np.int64], values: Floats, bins: int) -> Floats:
    """Sum of the values in each bin."""
    return np.asarray(np.bincount(bin_of, values, bins), float)


def _mean_velocities(system: ParticleSystem, bin_of: NDArray[np.int64], bins: int) -> Floats:
    """Mean velocity of the mass in each bin (bins, d) [m/s]; NaN in an empty bin."""
    momentum = [_sums(bin_of, system.mass * v, bins) for v in system.velocities.T]
    with np.errstate(invalid="ignore"):
        means: Floats = np.transpose(momentum / _sums(bin_of, system.mass, bins))
    return means


def profiles(system: ParticleSystem, axis: str, *, bins: int = 20) -> xr.Dataset:
    """Profiles along an axis: densities, packing fraction, mean velocity, granular temperature.

    Parameters
    ----------
    system : ParticleSystem
    axis : "x", "y" or "z"
    bins : int
        Number of equal bins from 0 to the edge of the box. Particles beyond, at a wall that has moved out, count in the
        outermost bin.

    Returns
    -------
    Dataset
        Over the axis [m], at the centres of the bins: ``number_density`` [1/m³; disks 1/m²], ``mass_density``,
        ``packing_fraction``, ``mean_velocity`` (of the mass, also over ``axis``) and ``granular_temperature`` about the
        mean velocity of the bin: in a sheared box it contains the mean flow, unless the axis is the gradient. The
        packing fraction is that of the volume of the particles inside the bin; all others count a particle where its
        centre is. Velocity and temperature are NaN in an empty bin.

    Raises
    ------
    ValueError
        If a value is outside its range.

    Notes
    -----
    Sums over the bins are the totals: with the volume V of a bin, ρ V is the mass, ρ u V the momentum and
    ρ (u² + d T) V/2 the kinetic energy (Goldhirsch, Powder Technol. 182, 130 (2008), without smoothing).
    """
    k, count = checked_axis("axis", axis, checked_system(system)), checked_bins(bins)
    d, mass, bin_of = system.dimension, system.mass, _bins(system, k, count)
    volume, of_disks = float(np.prod(system.box)) / count, d == 2
    means = _mean_velocities(system, bin_of, count)
    relative = system.velocities - means[bin_of]
    thermal = _sums(bin_of, mass * np.einsum("ij,ij->i", relative, relative), count)
    in_bin = _sums(bin_of, mass, count)
    with np.errstate(invalid="ignore"):
        temperature = thermal / (d * in_bin)
    numbers = np.bincount(bin_of, minlength=count)
    edges = np.linspace(0.0, float(system.box[k]), count + 1)
    filled = np.diff([_below(system, k, float(edge)) for edge in edges])
    per = "1/m2" if of_disks else "1/m3"
    coordinates = {
        axis: variable(axis, 0.5 * (edges[1:] + edges[:-1]), "m", axis),
        "axis": axes(system),
    }
    return xr.Dataset(
        {
            "number_density": variable(axis, numbers / volume, per, "number density"),
            "mass_density": variable(axis, in_bin / volume, per.replace("1", "kg"), "mass density ρ"),
            "packing_fraction": variable(axis, filled / volume, "1", "packing fraction φ"),
            "mean_velocity": variable((axis, "axis"), means, "m/s", "mean velocity u"),
            "granular_temperature": variable(axis, temperature, "m2/s2", "granular temperature T"),
        },
        coordinates,
    )


def _below(system: ParticleSystem, axis: int, edge: float) -> float:
    """Volume [m³; disks: area, m²] of the particles, and of their images inside the box, below a plane."""
    radius, x = system.radius, system.positions[:, axis]
    shifts = (-system.box[axis], 0.0, system.box[axis]) if system.domain.wraps[axis] else (0.0,)
    total = 0.0
    for shift in shifts:
        # Heights of both planes above the centre; the plane at 0 excludes what lies outside the box.
        total += float(
            np.sum(_cap((edge - x - shift) / radius, system) - _cap((-x - shift) / radius, system))
        )
    return total


def _cap(height: Floats, system: ParticleSystem) -> Floats:
    """Volume of a particle below a plane at ``height`` radii above its centre."""
    t = np.clip(height, -1.0, 1.0)
    if system.dimension == 2:
        return system.radius**2 * (t * np.sqrt(1.0 - t * t) + np.arcsin(t) + 0.5 * math.pi)
    return math.pi / 3.0 * system.radius**3 * (2.0 + 3.0 * t - t**3)
