"""Conversion between the laboratory and the falling frame in which the engines of boxes compute.

The frame falls freely along periodic axes, where no wall stops the particles, and is at rest at the start of the run.
In this frame the fall does not increase the speeds, nor the rate at which particles cross cells.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import _core
from . import spins
from .box import Floats, component_axes
from .system import ParticleSystem


def engine_arguments(system: ParticleSystem) -> tuple[_core.Box, Floats, Floats, Floats, Floats]:
    """Arguments of a compiled engine: box without the common fall, positions, velocities, radius and mass."""
    return (
        system.domain.of_core(),
        system.positions,
        system.velocities,
        np.ascontiguousarray(system.radius),
        np.ascontiguousarray(system.mass),
    )


def state(system: ParticleSystem, time: float, falling: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
    """Positions [m] and velocities [m/s] of the unfolded paths in the laboratory, (N, d) each.

    ``falling`` contains those in the falling frame at ``time`` [s]; it is changed in place.
    """
    positions, velocities = falling
    gained = time * system.domain.common_fall
    if gained.any():
        positions += 0.5 * time * gained
        velocities += gained
    return positions, velocities


def spin_arguments(system: ParticleSystem) -> dict[str, Floats]:
    """Arguments of a compiled engine: spins and inertia factors, if there are any."""
    if system.angular_velocities is None or system.inertia_factor is None:
        return {}
    factor = np.ascontiguousarray(system.inertia_factor)
    return {"spins": spins.for_core(system.angular_velocities), "inertia_factor": factor}


def system_at(
    system: ParticleSystem, time: float, falling: tuple[Floats, Floats], spin: Floats | None = None
) -> ParticleSystem:
    """The system at ``time`` [s], with positions in the box; ``falling`` as for :func:`state`. ``spin``: angular
    velocities of the core; None: they have not changed."""
    unfolded, velocities = state(system, time, falling)
    positions = unfolded.copy()
    system.domain.fold(positions, velocities, time)
    turning = None if spin is None else spins.from_core(spin, system.dimension)
    return system._moved(positions, velocities, time, unfolded, turning)


def laboratory_sums(system: ParticleSystem, time: Any, sums: dict[str, Any]) -> dict[str, Any]:
    """Energies and momentum in the laboratory from those in the falling frame, and the granular temperature.

    Each is a number, or an array over ``time`` [s]. ``sums["potential_energy"]`` includes all gravity. The temperature
    and ``kinetic_tensor``, Σ m v⊗v and then Σ m v'⊗v', are the same in both frames; computed in the laboratory, they
    would lose digits in a fast fall. In a sheared box both use velocities relative to the mean flow, whose momentum
    along the first axis is ``flow_momentum``.
    """
    mass, kinetic, momentum = float(system.mass.sum()), sums["kinetic_energy"], np.asarray(sums["momentum"])
    relative, twice = momentum, 2.0 * kinetic
    if system.domain.gradient is not None:
        relative = momentum.copy()
        relative[..., 0] -= sums["flow_momentum"]
        twice = sums["kinetic_tensor"][..., : system.dimension].sum(axis=-1)
    drift = (relative * relative).sum(axis=-1)
    temperature = np.maximum(twice - drift / mass, 0.0) / (system.dimension * mass)
    first, second = component_axes(system.dimension)
    gained = np.multiply.outer(time, system.domain.common_fall)
    fallen = 0.5 * mass * (gained * gained).sum(axis=-1)
    return sums | {
        "kinetic_energy": kinetic + (gained * momentum).sum(axis=-1) + fallen,
        "potential_energy": sums["potential_energy"] - fallen,
        "momentum": momentum + mass * gained,
        "granular_temperature": temperature,
        "kinetic_tensor": sums["kinetic_tensor"] - relative[..., first] * relative[..., second] / mass,
    }
