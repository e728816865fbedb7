"""Check that contacts are stiff enough for the speeds in a system."""

from __future__ import annotations

import math

import numpy as np

from ..contact import compression
from ..contact.contact import Law
from .system import ParticleSystem
from .time_step import contacts


def typical_speed(system: ParticleSystem) -> float:
    """Mean impact speed √(πT) [m/s] in a gas; if there are walls, T includes the mean motion."""
    squares = np.einsum("ij,ij->i", system.velocities, system.velocities)
    if "wall" not in system.boundary:
        return math.sqrt(math.pi * system.granular_temperature)
    return math.sqrt(math.pi * float(np.average(squares, weights=system.mass)) / system.dimension)


def refuse_too_soft(system: ParticleSystem, law: Law | None) -> None:
    """Refuse a law under which every impact at the mean speed would exceed the largest allowed compression."""
    speed = typical_speed(system)
    if law is None or not 0.0 < speed < math.inf:
        return
    impact = np.array([speed])
    # The smaller radius is at most twice the effective one.
    least = min(float(c.compression(impact)[0]) / (2.0 * c.effective_radius) for c in contacts(system, law))
    if least >= compression.DEEPEST:
        raise ValueError(
            f"law: got {law!r}, under which an impact at the mean speed of {speed:.3g} m/s would compress "
            f"contacts by {least:.3g} of the smaller radius or more, must be stiff enough for less than "
            f"{compression.DEEPEST:g}"
        )
