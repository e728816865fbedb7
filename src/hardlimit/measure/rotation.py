"""Spins of a state: their fourth cumulant, and correlations of spins and velocities."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from ..boxes.box import Floats
from ..boxes.contacts import checked_system
from ..boxes.spins import AXES_OF_ROTATION
from ..boxes.system import ParticleSystem
from .labelled import array
from .velocities import Streaming, energies_of, fourth_cumulant, relative_velocities


def a02(system: ParticleSystem) -> xr.DataArray:
    """Fourth cumulant of the spins, a₀₂ = f⟨w⁴⟩/((f + 2)⟨w²⟩²) − 1: 0 for Maxwell's distribution.

    w² is I|ω − Ω|² with the mean spin Ω = Σ I ω/Σ I, and f is 3 for spheres and 1 for disks. NaN if no spin differs
    from the mean.

    Parameters
    ----------
    system : ParticleSystem
        With angular velocities.

    Raises
    ------
    ValueError
        If it is no system, or has no angular velocities.

    Notes
    -----
    Santos, Kremer & dos Santos, Phys. Fluids 23, 030604 (2011), for spheres; Megías & Santos, Phys. Rev. E 108, 014902
    (2023), for disks too. The standard error of one state is √(8/(f (f + 2) N)) for nearly Maxwellian spins.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> box = hl.ParticleSystem.random(
    ...     500, 0.1, radius=1e-3, density=2500.0, rms_speed=1.0
    ... )
    >>> box = box.replace(angular_velocities=rng.normal(size=(500, 3)))
    >>> abs(hl.measure.a02(box).item()) < 0.2
    True
    """
    value = fourth_cumulant(_energies(system), AXES_OF_ROTATION[system.dimension], _rounding(system))
    return array("a02", (), value, "1", "fourth cumulant a02 of the spins")


def a11(system: ParticleSystem, *, streaming: Streaming = None, bins: int = 20) -> xr.DataArray:
    """Correlation of the energies of translation and rotation, a₁₁ = ⟨c²w²⟩/(⟨c²⟩⟨w²⟩) − 1: 0 if independent.

    c² is m|v − u|² as for :func:`hardlimit.measure.a2`, and w² is I|ω − Ω|² as for :func:`hardlimit.measure.a02`. NaN
    if either is 0. Parameters and errors are those of :func:`hardlimit.measure.granular_temperature`; a system without
    angular velocities is refused too.

    Notes
    -----
    Santos, Kremer & dos Santos, Phys. Fluids 23, 030604 (2011). The standard error of one state is 2/√(d f N) for
    nearly Maxwellian distributions, f = 3 for spheres and 1 for disks.
    """
    spins = _energies(system)
    speeds = energies_of(system.mass, relative_velocities(system, streaming, bins))
    rotation, translation = float(spins.mean()), float(speeds.mean())
    moves = translation > 1e-20 * 2.0 * system.kinetic_energy / system.n and rotation > _rounding(system)
    value = float((spins * speeds).mean()) / (rotation * translation) - 1.0 if moves else math.nan
    return array("a11", (), value, "1", "correlation a11 of the energies of translation and rotation")


def alignment(system: ParticleSystem, *, streaming: Streaming = None, bins: int = 20) -> xr.DataArray:
    """Mean square of the cosine of the angle between spin and velocity of a sphere, K = ⟨cos²ψ⟩.

    1/3 if their directions are independent; more if spheres spin about their path as a rifle bullet does, less if they
    spin across it as a sliced tennis ball does. Velocities are relative to u, spins to their mean Ω, as for
    :func:`hardlimit.measure.a11`. A sphere without either counts not; NaN if none is left. Parameters are those of
    :func:`hardlimit.measure.granular_temperature`.

    Raises
    ------
    ValueError
        As for that function, or if the particles are disks, which spin at right angles to their paths, or have no
        angular velocities.

    Notes
    -----
    Brilliantov, Pöschel, Kranz & Zippelius, Phys. Rev. Lett. 98, 128001 (2007). The standard error of one state is
    √(4/(45 N)) for nearly independent directions.
    """
    spins, velocities = _relative_spins(system), relative_velocities(system, streaming, bins)
    if system.dimension == 2:
        raise ValueError(f"system: got {system.count()}, must be spheres: disks spin across their paths")
    squares = [np.einsum("ij,ij->i", vectors, vectors) for vectors in (spins, velocities)]
    # Others are rounding errors.
    directed = np.all([square > 1e-24 * square.mean() for square in squares], axis=0)
    cosines = np.einsum("ij,ij->i", spins, velocities)[directed] / np.sqrt(squares[0] * squares[1])[directed]
    value = float((cosines * cosines).mean()) if directed.any() else math.nan
    return array("alignment", (), value, "1", "mean square cosine of spin and velocity")


def _relative_spins(system: ParticleSystem) -> Floats:
    """Angular velocities relative to their mean Σ I ω/Σ I (N, f) [rad/s]."""
    if checked_system(system).angular_velocities is None:
        raise ValueError(f"system: got {system!r} without angular velocities, must have angular_velocities")
    assert system.angular_velocities is not None
    spins = system.angular_velocities.reshape(system.n, -1)
    relative: Floats = spins - system.inertia @ spins / system.inertia.sum()
    return relative


def _energies(system: ParticleSystem) -> Floats:
    """I|ω − Ω|² of each particle [J]."""
    spins = _relative_spins(system)
    return energies_of(system.inertia, spins)


def _rounding(system: ParticleSystem) -> float:
    """Mean of I|ω − Ω|² up to which differences from the mean are rounding errors [J]."""
    return 1e-20 * 2.0 * system.rotational_energy / system.n
