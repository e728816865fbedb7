"""Tangential models of LAMMPS: gran/hooke, gran/hooke/history, gran/hertz/history, and those of ``granular``.

Source: gran_sub_mod_tangential.cpp and gran_sub_mod_damping.cpp, pair_gran_hooke_history.cpp and
pair_gran_hertz_history.cpp, fix_wall_gran.cpp of LAMMPS, and runs of 23 Jun 2022, 2 Aug 2023, 29 Aug 2024 and
22 Jul 2025. The limit is μ |F_n| with the damping of the normal force, also where an unclipped force attracts.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Final

from ...contact.friction import DEFAULT_RATIO, FrictionTerms
from . import NormalContact, Tangential, TangentialModel

Given = Mapping[str, float | None]

#: γ_t over γ_n in a style gran/… whose γ_t is NULL.
DEFAULT_DAMPING: Final = 0.5
#: Powers of mass, length and time in N/m, Pa, 1/s, 1/(m s) and m.
STIFFNESS: Final = (1.0, 0.0, -2.0)
MODULUS: Final = (1.0, -1.0, -2.0)
RATE: Final = (0.0, 0.0, -1.0)
RATE_BY_LENGTH: Final = (0.0, -1.0, -1.0)
LENGTH: Final = (0.0, 1.0, 0.0)
NUMBER: Final = (0.0, 0.0, 0.0)
#: The contact radius √(R ξ), as four times the power of ξ.
RADIUS: Final = 2


def material_stiffness(youngs_modulus: float, poisson_ratio: float) -> float:
    """k_t [Pa] of a Mindlin model whose k_t is NULL: 8 G*, of two bodies of one material."""
    return 2.0 * youngs_modulus / ((2.0 - poisson_ratio) * (1.0 + poisson_ratio))


def _gran(given: Given, contact: NormalContact, model: str, hertz: bool = False) -> FrictionTerms:
    """A style gran/…; at a wall, such a force in ``fix wall/gran``. γ_t is γ_t/m_eff in its input."""
    stiffness, damping = given.get("stiffness"), given["damping"]
    if stiffness is None:
        stiffness = DEFAULT_RATIO * contact.numbers["stiffness"]
    if damping is None:
        damping = DEFAULT_DAMPING * contact.numbers["damping"]
    pair = contact.written.pair
    mass = pair.mass if pair.formula_mass is None else pair.formula_mass
    scale = math.sqrt(pair.radius) if hertz else 1.0
    power = RADIUS if hertz else 0
    return _terms(given, model, stiffness * scale, power, damping * mass * scale, power)


def _granular(given: Given, contact: NormalContact, model: str, radius: bool = False) -> FrictionTerms:
    """A tangential model of ``granular``; with ``radius``, k_t multiplies the contact radius.

    γ_t is x_t times the coefficient of the normal damping.
    """
    stiffness = 0.0 if model == "none" else given["stiffness"]
    if stiffness is None:
        material = [contact.numbers.get(name) for name in ("youngs_modulus", "poisson_ratio")]
        if None in material:
            raise ValueError("tangential: k_t is NULL, must be a number for this normal model")
        stiffness = material_stiffness(*(x for x in material if x is not None))
    scale = math.sqrt(contact.written.pair.radius) if radius else 1.0
    damping = (given["damping_ratio"] or 0.0) * contact.force.damping
    return _terms(
        given,
        model,
        stiffness * scale,
        RADIUS if radius else 0,
        damping,
        contact.force.powers.damping,
    )


def _terms(
    given: Given, model: str, stiffness: float, stiffness_power: int, damping: float, damping_power: int
) -> FrictionTerms:
    coefficient = given["coefficient"]
    assert coefficient is not None
    still = given.get("static_coefficient", coefficient)
    if still != coefficient:
        raise ValueError(
            f"tangential: static μ {still:g} and dynamic μ {coefficient:g} differ, must be equal"
        )
    if model != "none" and stiffness == 0.0 and damping > 0.0:
        raise ValueError("tangential: k_t is 0, must be > 0: LAMMPS divides by it where the surfaces slip")
    return FrictionTerms.of_model(
        model,
        "total",
        coefficient=coefficient,
        stiffness=0.0 if model == "none" else stiffness,
        stiffness_power=0 if model == "none" else stiffness_power,
        damping=damping,
        damping_power=damping_power,
    )


def _scaled_wall(given: Given, contact: NormalContact) -> FrictionTerms:
    """``fix wall/gran hooke/history`` with the error: k_t times the contact radius, as a number in the script's unit."""
    right = _gran(given, contact, "mindlin")
    unit = given["length_unit"]
    assert unit is not None
    factor = math.sqrt(contact.written.pair.radius) / unit
    return right._replace(stiffness=right.stiffness * factor, stiffness_power=RADIUS)


Terms = Callable[[Given, NormalContact], FrictionTerms]


def _model(name: str, terms: Terms, **numbers: tuple[float, float, float]) -> TangentialModel:
    return TangentialModel(name, {**numbers, "coefficient": NUMBER}, terms)


_HISTORIES: Final = ("mindlin", "mindlin_force", "mindlin_rescale", "mindlin_rescale_force")
_HERTZ: Final = partial(_gran, model="mindlin", hertz=True)
_MINDLIN: Final = partial(_granular, model="mindlin", radius=True)
_LINEAR: Final = partial(_granular, model="spring")
_RATIO: Final = {"damping_ratio": NUMBER}
_STATIC: Final = {**_RATIO, "static_coefficient": NUMBER}

#: The models by the name that a script gives them; those of the styles gran/… are those of classic walls as well.
MODELS: Final = (
    _model("gran/hooke", partial(_gran, model="none"), damping=RATE),
    _model("gran/hooke/history", partial(_gran, model="spring"), stiffness=STIFFNESS, damping=RATE),
    _model("gran/hertz/history", _HERTZ, stiffness=MODULUS, damping=RATE_BY_LENGTH),
    _model("linear_nohistory", partial(_granular, model="none"), **_RATIO),
    _model("linear_history", _LINEAR, stiffness=STIFFNESS, **_RATIO),
    _model("linear_history_classic", _LINEAR, stiffness=STIFFNESS, **_RATIO),
    _model("linear_history/static", _LINEAR, stiffness=STIFFNESS, **_STATIC),
    _model("mindlin_classic", _MINDLIN, stiffness=MODULUS, **_RATIO),
    *(
        _model(
            name.replace("_force", "/force"),
            partial(_granular, model=name, radius=True),
            stiffness=MODULUS,
            **_RATIO,
        )
        for name in _HISTORIES
    ),
    _model("mindlin/static", _MINDLIN, stiffness=MODULUS, **_STATIC),
    # Walls with the error of 2023 to 2026: the spring is multiplied by the contact radius once too often.
    _model("scaled hooke/history", _scaled_wall, stiffness=STIFFNESS, damping=RATE, length_unit=LENGTH),
    _model("scaled hertz/history", _HERTZ, stiffness=MODULUS, damping=RATE_BY_LENGTH, length_unit=LENGTH),
)
