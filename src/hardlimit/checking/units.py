"""Contacts and states of a dump in SI units."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Final

from . import dumps
from .contacts import Case, CheckedContact
from .supplied import SCALES

#: Units of force and length of each system of units.
UNIT_NAMES: Final = {"si": ("N", "m"), "cgs": ("dyn", "cm"), "micro": ("nN", "µm"), "nano": ("pN", "nm")}
#: Powers of mass, length and time in the numbers of a contact.
POWERS: Final = {
    "radius": (0, 1, 0),
    "other_radius": (0, 1, 0),
    "density": (1, -3, 0),
    "speed": (0, 1, -1),
    "duration": (0, 0, 1),
    "time_step": (0, 0, 1),
    "rayleigh_time": (0, 0, 1),
    "p_wave_time": (0, 0, 1),
}


def contact_in_si(case: Case, row: CheckedContact, units: str) -> CheckedContact:
    """The numbers of a contact in SI units."""
    scales = SCALES[units]
    changed: dict[str, Any] = {"stiffness_unit": unit_of(case.spring_powers, units)}
    for name, powers in POWERS.items():
        if (value := getattr(row, name)) is not None:
            changed[name] = value * math.prod(s**p for s, p in zip(scales, powers, strict=True))
    others = [
        version._replace(duration=version.duration and version.duration * scales[2])
        for version in row.other_versions
    ]
    return replace(row, **changed, other_versions=tuple(others))


def unit_of(powers: tuple[float, float, float] | None, units: str) -> str:
    """The unit of a stiffness or a modulus; empty in lj units."""
    if powers is None or units not in UNIT_NAMES or (powers[0], powers[2]) != (1.0, -2.0):
        return ""
    force, length = UNIT_NAMES[units]
    power = 1.0 - powers[1]
    if units == "si" and power == 2.0:
        return "Pa"
    return f"{force}/{length}{'' if power == 1.0 else f'^{power:g}'}"


def state_in_si(state: dumps.State, length: float, time: float) -> dumps.State:
    """What a dump shows, in SI units."""
    t, d = state.temperature, state.mean_diameter
    return replace(
        state,
        temperature=None if t is None else t * (length / time) ** 2,
        mean_diameter=None if d is None else d * length,
    )
