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
    twice = energies_of(checked_system(system).mass, relative_velocities(system, streaming, bins))
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
    energies = energies_of(checked_system(system).mass, relative_velocities(system, streaming, bins))
    rounding = 1e-20 * 2.0 * system.kinetic_energy / system.n
    value = fourth_cumulant(energies, system.dimension, rounding)
    return array("a2", (), value, "1", "fourth cumulant a2 of the velocities")


def fourth_cumulant(energies: Floats, axes: int, rounding: float) -> float:
    """f⟨c⁴⟩/((f + 2)⟨c²⟩²) − 1 of f axes, from c² [J] of each particle; NaN if ⟨c²⟩ is not above ``rounding``."""
    mean = float(energies.mean())
    if not mean > rounding:
        return math.nan
    return axes * float(np.mean((energies / mean) ** 2)) / (axes + 2) - 1.0


def energies_of(inertia: Floats, relative: Floats) -> Floats:
    """Mass times the square of the velocity of each particle, or inertia times that of its spin [J]."""
    energies: Floats = inertia * np.einsum("ij,ij->i", relative, relative)
    return energies


def relative_velocities(system: ParticleSystem, streaming: Streaming, bins: Any) -> Floats:
    """Velocities relative to the streaming velocity, v − u (N, d) [m/s]."""
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
    relative: Floats = velocities - flow
    return relative


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
        centre is. If the particles have angular velocities, also ``mean_angular_velocity`` Σ I ω/Σ I [rad/s] (of
        spheres over ``axis``) and ``rotational_temperature`` [m²/s²], which contains the mean rotation. Velocities and
        temperatures are NaN in an empty bin.

    Raises
    ------
    ValueError
        If a value is outside its range.

    Notes
    -----
    Sums over the bins are the totals: with the volume V of a bin, ρ V is the mass, ρ u V the momentum and
    ρ (u² + d T) V/2 the kinetic energy (Goldhirsch, Powder Technol. 182, 130 (2008), without smoothing). That of the
    rotation is ρ f T_r V/2, with f = 3 for spheres and 1 for disks.
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
            **_of_rotation(system, axis, bin_of, in_bin),
        },
        coordinates,
    )


def _of_rotation(
    system: ParticleSystem, axis: str, bin_of: NDArray[np.int64], in_bin: Floats
) -> dict[str, Any]:
    """Profiles of the spins, from the mass in each bin; none without angular velocities."""
    if system.angular_velocities is None:
        return {}
    spins, inertia, bins = system.angular_velocities.reshape(system.n, -1), system.inertia, len(in_bin)
    axes, twice = spins.shape[1], inertia * np.einsum("ij,ij->i", spins, spins)
    sums = np.stack([_sums(bin_of, inertia * w, bins) for w in spins.T], axis=1)
    with np.errstate(invalid="ignore"):
        means = sums / _sums(bin_of, inertia, bins)[:, None]
        temperature = _sums(bin_of, twice, bins) / (axes * in_bin)
    dims, means = ((axis, "axis"), means) if axes == 3 else ((axis,), means[:, 0])
    return {
        "mean_angular_velocity": variable(dims, means, "rad/s", "mean spin Ω"),
        "rotational_temperature": variable(axis, temperature, "m2/s2", "rotational temperature"),
    }


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
