"""Tangential models of LIGGGHTS 3.8.0, from its sources (``tangential_model_*.h``, ``normal_model_*.h``).

The normal model gives k_t and γ_t; ``tangential`` only says whether there is a spring. With one, μ |F_n| limits the
spring alone, and there is no damping while it slips. Without, it limits the damping.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Final, NamedTuple

from ...contact.friction import FrictionTerms
from . import NormalContact, TangentialModel

GivenNumbers = Mapping[str, float | None]

#: k_t/k_n of ``ktToKnUser on``, which LIGGGHTS writes with nine digits.
KT_TO_KN_USER: Final = 0.285714286


class Coefficients(NamedTuple):
    """k_t = stiffness · ξ^(stiffness_power/4) and γ_t = damping · ξ^(damping_power/4)."""

    stiffness: float
    stiffness_power: int
    damping: float
    damping_power: int


def effective_shear_modulus(first: tuple[float, float], second: tuple[float, float]) -> float:
    """G* of two materials, each by Young's modulus and Poisson's ratio: 1/G* = Σ 2 (2 − ν)(1 + ν)/E."""
    return 1.0 / sum(2.0 * (2.0 - nu) * (1.0 + nu) / modulus for modulus, nu in (first, second))


def _hooke(numbers: GivenNumbers, normal: NormalContact) -> Coefficients:
    """k_t = k_n unless ``ktToKnUser on``, and γ_t = γ_n."""
    ratio = KT_TO_KN_USER if numbers.get("ktToKnUser") else 1.0
    return Coefficients(ratio * normal.force.stiffness, 0, normal.force.damping, 0)


def _hertz(numbers: GivenNumbers, normal: NormalContact) -> Coefficients:
    """k_t = 8 G* √(R ξ). γ_t = √(k_t/S_n) γ_n with S_n = dF/dξ = 3/2 K √ξ of the normal force K ξ^(3/2)."""
    modulus = numbers.get("shear_modulus")
    if modulus is None:
        material = normal.numbers["youngs_modulus"], normal.numbers["poisson_ratio"]
        modulus = effective_shear_modulus(material, material)
    stiffness = 8.0 * modulus * math.sqrt(normal.written.pair.radius)
    damping = math.sqrt(stiffness / (1.5 * normal.force.stiffness)) * normal.force.damping
    return Coefficients(stiffness, 2, damping, 1)


def _given(numbers: GivenNumbers, normal: NormalContact, power: int) -> Coefficients:
    """kt and gammat as the user gives them, with the factors of kn and gamman."""
    factor = math.sqrt(normal.written.pair.radius) if power else 1.0
    absolute, relative = numbers.get("absolute_damping"), numbers.get("damping") or 0.0
    if absolute is None:
        absolute = normal.written.force({**normal.numbers, "damping": relative}).damping
    return Coefficients(factor * (numbers.get("stiffness") or 0.0), power, absolute, power)


#: What each normal model makes of its numbers, and the units of these.
NORMAL: Final[
    dict[
        str,
        tuple[Callable[[GivenNumbers, NormalContact], Coefficients], dict[str, tuple[float, float, float]]],
    ]
] = {
    "hooke": (_hooke, {"ktToKnUser": (0.0, 0.0, 0.0)}),
    "hertz": (_hertz, {"shear_modulus": (1.0, -1.0, -2.0)}),
    "hooke/stiffness": (
        partial(_given, power=0),
        {"stiffness": (1.0, 0.0, -2.0), "damping": (0.0, 0.0, -1.0), "absolute_damping": (1.0, 0.0, -1.0)},
    ),
    "hertz/stiffness": (
        partial(_given, power=2),
        {"stiffness": (1.0, -1.0, -2.0), "damping": (0.0, -1.0, -1.0)},
    ),
}


def _terms(numbers: GivenNumbers, normal: NormalContact, of: str, history: bool) -> FrictionTerms:
    """The friction of a contact; ``tangential_damping`` is on unless it is 0."""
    coefficients = NORMAL[of][0](numbers, normal)
    if numbers.get("tangential_damping") == 0.0:
        coefficients = coefficients._replace(damping=0.0)
    coefficient = numbers["coefficient"] or 0.0
    if not history or coefficients.stiffness == 0.0:
        if history:  # a spring without stiffness never reaches the limit
            coefficient = math.inf
            if not normal.force.powers.attracts and coefficients.damping > 0.0:
                raise ValueError("kt: got 0 with limitForce on, must be > 0: its damping outlasts the force")
        coefficients = coefficients._replace(stiffness=0.0, stiffness_power=0)
        model, limit = "none", "total"
    else:
        model, limit = ("mindlin" if coefficients.stiffness_power else "spring"), "spring"
    return FrictionTerms.of_model(model, limit, coefficient=coefficient, **coefficients._asdict())


#: One for each normal model and each tangential one: ``hooke history``, …
MODELS: Final = [
    TangentialModel(
        f"{normal} {name}",
        {"coefficient": (0.0, 0.0, 0.0), "tangential_damping": (0.0, 0.0, 0.0), **units},
        partial(_terms, of=normal, history=name == "history"),
    )
    for normal, (_, units) in NORMAL.items()
    for name in ("history", "no_history")
]
