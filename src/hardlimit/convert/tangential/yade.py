"""Tangential forces of YADE 2023.02: the increments of a spring's force, and a damping while the surfaces stick.

Coulomb's law limits the force of the spring. What the documentation leaves open was read off ``Interaction.phys`` and
the forces in runs.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

from ...contact.friction import FrictionTerms, mindlin_ratio
from ..formulas import thornton
from . import NormalContact, TangentialModel

Given = Mapping[str, float | None]

#: Defaults of the materials.
FRICTION_ANGLE: Final = 0.5
POISSON_RATIO: Final = 0.25
NUMBER: Final = (0.0, 0.0, 0.0)
STIFFNESS: Final = (1.0, 0.0, -2.0)
DAMPING: Final = (1.0, 0.0, -1.0)
#: What every model has.
COMMON: Final = {"friction_angle": NUMBER, "poisson": NUMBER}


def _number(numbers: Given, name: str, default: float) -> float:
    value = numbers.get(name)
    return default if value is None else value


def _coefficient(numbers: Given) -> float:
    return math.tan(_number(numbers, "friction_angle", FRICTION_ANGLE))


def _spring(numbers: Given, stiffness: float, damping: float = 0.0) -> FrictionTerms:
    return FrictionTerms.of_model(
        "spring", "spring", coefficient=_coefficient(numbers), stiffness=stiffness, damping=damping
    )


def cundall_strack(numbers: Given, contact: NormalContact) -> FrictionTerms:
    """k_s = ν k_n of each body, both in series; or ``ks`` of the functor."""
    ratio = _number(numbers, "poisson", POISSON_RATIO)
    return _spring(numbers, _number(numbers, "ks", ratio * contact.force.stiffness))


def _tangent(numbers: Given, contact: NormalContact) -> float:
    """8 G* √R, which times √ξ is the tangential stiffness: 4 G*/E* of that of the normal force."""
    return 1.5 * mindlin_ratio(_number(numbers, "poisson", POISSON_RATIO)) * contact.force.stiffness


def mindlin(numbers: Given, contact: NormalContact) -> FrictionTerms:
    """c_s = 2 betas √(m k_s), with betas from ``es`` by the formula for ``en``; by default that of the normal force."""
    force, tangent = contact.force, _tangent(numbers, contact)
    es = numbers.get("es")
    usual = 0.5 * force.damping / math.sqrt(1.5 * force.effective_mass * force.stiffness)
    ratio = _number(numbers, "betas", usual if es is None else thornton(es))
    return FrictionTerms.of_model(
        "mindlin_force",
        "spring",
        coefficient=_coefficient(numbers),
        stiffness=tangent,
        stiffness_power=2,
        damping=2.0 * ratio * math.sqrt(force.effective_mass * tangent),
        damping_power=1,
    )


def linear_shear(numbers: Given, contact: NormalContact) -> FrictionTerms:
    """Without damping. With ``nonLin=0``, k_s in N/m is the number of 8 G* √R in N/m^1.5."""
    tangent = _tangent(numbers, contact)
    if not numbers.get("nonLin"):
        return _spring(numbers, tangent)
    return FrictionTerms.of_model(
        "mindlin_force",
        "spring",
        coefficient=_coefficient(numbers),
        stiffness=tangent,
        stiffness_power=2,
    )


def viscoelastic(numbers: Given, contact: NormalContact) -> FrictionTerms:
    """From ``tc`` and ``et``, from ``ks`` and ``cs``, or ν k_n with ``cs``.

    ``et`` is the restitution of the surfaces, reversed, of a contact that does not slip and lasts ``tc``: with the mass
    m of the normal force, k_s = (2/7) m (π² + ln² et)/tc² and c_s = −(4/7) m ln(et)/tc. Each body has twice the spring
    and dashpot of the contact. Without a spring nothing would limit the damping, not even the end of the normal force.
    """
    force, et, ks = contact.force, numbers.get("et"), numbers.get("ks")
    if et is not None:
        mass = force.stiffness / (math.pi**2 + math.log(contact.numbers["restitution"]) ** 2)  # m/tc²
        decay, time = math.log(et), contact.numbers["contact_time"]
        return _spring(
            numbers, 2.0 / 7.0 * mass * (math.pi**2 + decay**2), abs(4.0 / 7.0 * mass * decay * time)
        )
    spring = _number(numbers, "poisson", POISSON_RATIO) * force.stiffness if ks is None else 0.5 * ks
    return _spring(numbers, spring, 0.5 * _number(numbers, "cs", 0.0))


#: By the names of their interactions, and a law of ``MindlinPhys`` by its own.
MODELS: Final = [
    TangentialModel("FrictPhys", {**COMMON, "ks": STIFFNESS}, cundall_strack),
    TangentialModel("CohFrictPhys", COMMON, cundall_strack),
    TangentialModel("MindlinPhys", {**COMMON, "es": NUMBER, "betas": NUMBER}, mindlin),
    TangentialModel("HertzWithLinearShear", {**COMMON, "nonLin": NUMBER}, linear_shear),
    TangentialModel("ViscElPhys", {**COMMON, "et": NUMBER, "ks": STIFFNESS, "cs": DAMPING}, viscoelastic),
]
