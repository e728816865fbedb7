"""Contacts that the particles of a system have under a law, and a check that they are stiff enough."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..contact import compression
from ..contact.balls import Ball
from ..contact.contact import Law
from ..contact.contact import checked_law as checked_contact_law
from ..support import validation
from ..support.formatting import listed
from .box import AXES, Floats
from .system import ParticleSystem

Indices = NDArray[np.int64]

#: Accepted momentum over duration of an impact at 1 m/s [N]. Squares of forces are then finite up to ``box.LARGEST``,
#: and not zero at the slowest speeds at which grains move during a run.
WEAKEST: Final = 1e-30
STRONGEST: Final = 1e100
#: With more kinds of particles than this, only the lightest, heaviest, smallest and largest are considered.
MAX_KINDS: Final = 6


def checked_law(law: Any, smooth: str = "") -> Law:
    """``law``, if it is one; ``smooth`` names what refuses a law with friction."""
    return checked_contact_law(law, smooth)


def rubs(law: Law) -> bool:
    """Whether grains under a law have friction."""
    return law.friction is not None and law.friction.coefficient > 0.0


def checked_system(system: Any) -> ParticleSystem:
    if not isinstance(system, ParticleSystem):
        raise ValueError(f"system: got {validation.shown(system)}, must be a ParticleSystem")
    return system


def law_arguments(law: Law) -> tuple[str, int, list[float], Any]:
    """A law as arguments of the core: name, alternative, parameters, friction."""
    friction = None if law.friction is None else law.friction.core
    return law.record["name"], law.alternative, list(law.parameters.values()), friction


def contact(law: Law, mass: float, radius: float) -> _core.Contact:
    """A contact with this effective mass [kg] and radius [m]."""
    name, alternative, parameters, friction = law_arguments(law)
    return _core.make_contact(name, alternative, parameters, mass, radius, friction)


def mean_contact(system: ParticleSystem, law: Law) -> _core.Contact:
    """The contact of two particles of mean mass and radius."""
    return contact(law, 0.5 * float(system.mass.mean()), 0.5 * float(system.radius.mean()))


def mean_grain(system: ParticleSystem) -> Ball:
    """A particle of mean mass, radius and inertia factor."""
    factor = system.inertia / (system.mass * system.radius**2)
    return Ball(
        float(system.radius.mean()), mass=float(system.mass.mean()), inertia_factor=float(factor.mean())
    )


def _unique_pairs(first: Floats, second: Floats) -> tuple[Floats, Indices]:
    """The different pairs of numbers, in ascending order, and the index of each. Rows of an array are sorted slowly."""
    pairs, index = np.unique(first + 1j * second, return_inverse=True)
    return np.stack([pairs.real, pairs.imag], axis=1), index


def of_kinds(system: ParticleSystem, law: Law) -> Iterator[_core.Contact]:
    """A contact for each pair of kinds of particles, and for each kind with a wall if there are walls."""
    kinds, _ = _unique_pairs(system.mass, system.radius)
    if len(kinds) > MAX_KINDS:
        ends = [f(kinds[:, column]) for column in (0, 1) for f in (np.argmin, np.argmax)]
        kinds = kinds[sorted(set(map(int, ends)))]
    partners = kinds.tolist() + ([[math.inf, math.inf]] if "wall" in system.boundary else [])
    for i, kind in enumerate(kinds.tolist()):
        for partner in partners[i:]:
            mass, radius = map(_core.effective, kind, partner)
            yield contact(law, mass, radius)


def of_pairs(
    system: ParticleSystem, law: Law, first: Indices, second: Indices
) -> Iterator[tuple[Indices, _core.Contact]]:
    """The contact of each pair of particles; a negative ``second`` is a wall. Yields the rows of equal contacts."""
    pair = second >= 0  # a wall has no mass or radius to look up
    mass, radius = (values[first] for values in (system.mass, system.radius))
    for own, values in ((mass, system.mass), (radius, system.radius)):
        other = values[second[pair]]
        own[pair] *= other / (own[pair] + other)
    kinds, kind = _unique_pairs(mass, radius)
    order = np.argsort(kind, kind="stable")
    ends = np.cumsum(np.bincount(kind, minlength=len(kinds)))
    for (m, r), rows in zip(kinds.tolist(), np.split(order, ends[:-1]), strict=False):
        if len(rows):
            yield rows, contact(law, m, r)


def impact_temperature(system: ParticleSystem) -> float:
    """Granular temperature T [m²/s²], with the mean motion if there are walls. The mean impact speed is √(πT)."""
    if "wall" in system.boundary:
        return 2.0 * system.kinetic_energy / (system.dimension * float(system.mass.sum()))
    return system.granular_temperature


def refuse_fall_past_walls(system: ParticleSystem, has_friction: bool) -> None:
    """Refuse walls with friction past which all particles fall: runs are computed in the frame that falls with them, in
    which these walls would be at rest."""
    if has_friction and "wall" in system.boundary and system.domain.common_fall.any():
        axes = [axis for axis, g in zip(AXES, system.domain.common_fall.tolist(), strict=False) if g]
        raise ValueError(
            f"gravity: got a component along the periodic {listed(axes, 'and')}, must be none with friction at walls; "
            "take walls along this axis, too"
        )


def refuse_too_soft(system: ParticleSystem, law: Law | None) -> None:
    """Refuse a law under which every impact at the mean speed would exceed the largest allowed compression, and one
    whose forces are so small or large that their squares underflow or overflow."""
    if law is None:
        return
    for c in of_kinds(system, law):
        force = c.effective_mass / float(c.duration(np.ones(1))[0])
        if not WEAKEST <= force <= STRONGEST:
            raise ValueError(
                f"law | mass: got {law!r} and masses from {system.mass.min():g} to {system.mass.max():g} kg, a force "
                f"of {force:.3g} N at an impact of 1 m/s, must be in [{WEAKEST:g}, {STRONGEST:g}]"
            )
    speed = math.sqrt(math.pi * impact_temperature(system))
    if not 0.0 < speed < math.inf:
        return
    impact: Floats = np.array([speed])
    # The smaller radius is at most twice the effective one.
    least = min(float(c.compression(impact)[0]) / (2.0 * c.effective_radius) for c in of_kinds(system, law))
    if least >= compression.DEEPEST:
        raise ValueError(
            f"law: got {law!r}, must be stiffer: at the mean impact speed of {speed:.3g} m/s it compresses contacts by "
            f"{least:.3g} of the smaller radius or more; contact laws hold below {compression.DEEPEST:g}"
        )
