"""The ways in which particle codes are given the stiffness of a contact, each under a name that the files in ``codes``
select: the K of F = K ξ^p + … from the code's numbers, and those numbers from K.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

DEFAULT_POISSON_RATIO: Final = 0.3


@dataclass(frozen=True)
class Where:
    """What a spring may depend on besides its numbers."""

    mass: float  #: effective, as the code's formula has it [kg]
    radius: float  #: effective [m]
    speed: float  #: of impact [m/s]
    number: float | None  #: that gives the damping: a restitution, where the code is given one
    poisson_ratio: float


Numbers = dict[str, float]


@dataclass(frozen=True)
class Spring:
    """One way to give a stiffness."""

    value: Callable[[Mapping[str, float], Where], float]
    numbers: Callable[[float, Where], Numbers | None]  #: None if no numbers give this stiffness
    damped: bool = False  #: whether there is none without damping


def modulus(youngs_modulus: float, poisson_ratio: float) -> float:
    """The effective modulus [Pa] of two bodies of one material: Y/(2 (1 − ν²))."""
    return 0.5 * youngs_modulus / ((1.0 - poisson_ratio) * (1.0 + poisson_ratio))


def impact_stiffness(effective_modulus: float, where: Where) -> float:
    """The linear spring [N/m] that an undamped impact compresses as far as a Hertz contact of this modulus [Pa]."""
    hertz = 16.0 / 15.0 * math.sqrt(where.radius) * effective_modulus
    return float(hertz * (where.mass * where.speed**2 / hertz) ** 0.2)


def _of_modulus(effective_modulus: float, where: Where) -> Numbers:
    nu = where.poisson_ratio
    return {"youngs_modulus": 2.0 * (1.0 - nu) * (1.0 + nu) * effective_modulus, "poisson_ratio": nu}


def _modulus_of(numbers: Mapping[str, float], where: Where) -> float:
    return modulus(numbers["youngs_modulus"], numbers["poisson_ratio"])


def _impact(numbers: Mapping[str, float], where: Where) -> float:
    moved = Where(where.mass, where.radius, numbers["characteristic_speed"], None, where.poisson_ratio)
    return impact_stiffness(_modulus_of(numbers, where), moved)


def _impact_numbers(stiffness: float, where: Where) -> Numbers:
    energy = where.mass * where.speed**2
    hertz = (stiffness**5 / energy) ** 0.25
    found = _of_modulus(15.0 / 16.0 * hertz / math.sqrt(where.radius), where)
    return {**found, "characteristic_speed": where.speed}


def _decay(where: Where) -> float:
    assert where.number is not None
    return where.mass * (math.pi**2 + math.log(where.number) ** 2)


def _relaxation(stiffness: float, where: Where) -> Numbers | None:
    """τ of K = m/(τζ)²; without damping there is none."""
    return {"timeconst": math.sqrt(where.mass / stiffness) / where.number} if where.number else None


SPRINGS: Final[dict[str, Spring]] = {
    "stiffness": Spring(lambda n, _: n["stiffness"], lambda value, _: {"stiffness": value}),
    "modulus": Spring(_modulus_of, _of_modulus),
    "young": Spring(lambda n, _: n["youngs_modulus"], lambda value, _: {"youngs_modulus": value}),
    "impact": Spring(_impact, _impact_numbers),
    "contact_time": Spring(
        lambda n, where: _decay(where) / n["contact_time"] ** 2,
        lambda value, where: {"contact_time": math.sqrt(_decay(where) / value)},
    ),
    "stiffness_by_mass": Spring(
        lambda n, where: n["stiffness"] * where.mass, lambda value, where: {"stiffness": value / where.mass}
    ),
    "relaxation": Spring(
        lambda n, where: where.mass / (n["timeconst"] * n["dampratio"]) ** 2, _relaxation, damped=True
    ),
}
