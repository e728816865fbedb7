"""What the engines of boxes take and give: arguments in, state and sums out.

Engines compute in a frame that falls with the particles along periodic axes and is at rest at the start of the run:
no wall stops that fall, speeds do not grow in it, and neither does the rate at which particles cross cells.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import _core
from ..contact.contact import Law
from .box import Floats
from .system import ParticleSystem


def engine_arguments(system: ParticleSystem) -> tuple[_core.Box, Floats, Floats, Floats, Floats]:
    """Box, positions, velocities, radius and mass as compiled engines take them: without the common fall."""
    return (
        system.domain.of_core(),
        system.positions,
        system.velocities,
        np.ascontiguousarray(system.radius),
        np.ascontiguousarray(system.mass),
    )


def law_arguments(law: Law) -> tuple[str, int, list[float]]:
    """A law as compiled engines take it: name, alternative, parameters."""
    return law.record["name"], law.alternative, list(law.parameters.values())


def state(system: ParticleSystem, time: float, falling: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
    """Positions along unfolded paths [m] and velocities [m/s] in the laboratory, (N, d) each.

    ``falling`` holds those of the falling frame at ``time`` [s], and is changed in place.
    """
    positions, velocities = falling
    gained = time * system.domain.common_fall
    if gained.any():
        positions += 0.5 * time * gained
        velocities += gained
    return positions, velocities


def present(system: ParticleSystem, time: float, falling: tuple[Floats, Floats]) -> ParticleSystem:
    """The system at ``time`` [s], inside the box; ``falling`` as for :func:`state`."""
    positions, velocities = state(system, time, falling)
    system.domain.fold(positions)
    return system._moved(positions, velocities)


def laboratory_sums(system: ParticleSystem, time: Any, sums: dict[str, Any]) -> dict[str, Any]:
    """Energies and momentum of the laboratory from those of the falling frame, each a number or one for each ``time``
    [s], with the granular temperature. ``sums["potential_energy"]`` is that of all gravity.

    The temperature is the same in both frames, but would lose digits in the laboratory where the fall is fast.
    """
    mass, kinetic, momentum = float(system.mass.sum()), sums["kinetic_energy"], np.asarray(sums["momentum"])
    drift = (momentum * momentum).sum(axis=-1)
    temperature = np.maximum(2.0 * kinetic - drift / mass, 0.0) / (system.dimension * mass)
    gained = np.multiply.outer(time, system.domain.common_fall)
    fallen = 0.5 * mass * (gained * gained).sum(axis=-1)
    return sums | {
        "kinetic_energy": kinetic + (gained * momentum).sum(axis=-1) + fallen,
        "potential_energy": sums["potential_energy"] - fallen,
        "momentum": momentum + mass * gained,
        "granular_temperature": temperature,
    }
