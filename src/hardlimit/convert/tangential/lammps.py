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

GivenNumbers = Mapping[str, float | None]

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
#: Steps in a contact whose spring is lost at each slip.
STEPS: Final = 5000


def material_stiffness(youngs_modulus: float, poisson_ratio: float) -> float:
    """k_t [Pa] of a Mindlin model whose k_t is NULL: 8 G*, of two bodies of one material."""
    return 2.0 * youngs_modulus / ((2.0 - poisson_ratio) * (1.0 + poisson_ratio))


def _gran(numbers: GivenNumbers, contact: NormalContact, model: str, hertz: bool = False) -> FrictionTerms:
    """A style gran/…; at a wall, such a force in ``fix wall/gran``. γ_t is γ_t/m_eff in its input."""
    stiffness, damping = numbers.get("stiffness"), numbers["damping"]
    if stiffness is None:
        stiffness = DEFAULT_RATIO * contact.numbers["stiffness"]
    if damping is None:
        damping = DEFAULT_DAMPING * contact.numbers["damping"]
    pair = contact.written.pair
    mass = pair.mass if pair.formula_mass is None else pair.formula_mass
    scale = math.sqrt(pair.radius) if hertz else 1.0
    power = RADIUS if hertz else 0
    return _terms(numbers, model, stiffness * scale, power, damping * mass * scale, power)


def _granular(
    numbers: GivenNumbers, contact: NormalContact, model: str, radius: bool = False
) -> FrictionTerms:
    """A tangential model of ``granular``; with ``radius``, k_t multiplies the contact radius.

    γ_t is x_t times the coefficient of the normal damping.
    """
    stiffness = 0.0 if model == "none" else numbers["stiffness"]
    if stiffness is None:
        material = [contact.numbers.get(name) for name in ("youngs_modulus", "poisson_ratio")]
        if None in material:
            raise ValueError("tangential: k_t is NULL, must be a number for this normal model")
        stiffness = material_stiffness(*(x for x in material if x is not None))
    scale = math.sqrt(contact.written.pair.radius) if radius else 1.0
    damping = (numbers["damping_ratio"] or 0.0) * contact.force.damping
    return _terms(
        numbers,
        model,
        stiffness * scale,
        RADIUS if radius else 0,
        damping,
        contact.force.powers.damping,
    )


def _terms(
    numbers: GivenNumbers,
    model: str,
    stiffness: float,
    stiffness_power: int,
    damping: float,
    damping_power: int,
) -> FrictionTerms:
    coefficient = numbers["coefficient"]
    assert coefficient is not None
    still = numbers.get("static_coefficient")
    if still not in (None, coefficient):
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


Terms = Callable[[GivenNumbers, NormalContact], FrictionTerms]


def _scaled(numbers: GivenNumbers, contact: NormalContact, right: Terms) -> FrictionTerms:
    """A linear spring with the error: its k_t times the contact radius, as a number in the script's unit."""
    terms, unit = right(numbers, contact), numbers["length_unit"]
    assert unit is not None
    factor = math.sqrt(contact.written.pair.radius) / unit
    history = FrictionTerms.of_model("mindlin", "total", coefficient=terms.coefficient)
    return terms._replace(
        stiffness=terms.stiffness * factor,
        stiffness_power=RADIUS,
        loading=history.loading,
        unloading=history.unloading,
    )


def _worn(
    numbers: GivenNumbers,
    contact: NormalContact,
    tangential_mass: float,
    speed: float,
    tangential_speed: float,
    terms: Terms,
) -> float:
    """β of a spring that loses most of its force at every slip, by small steps."""
    friction, length_unit = terms(numbers, contact), numbers["length_unit"]
    assert length_unit is not None
    force, radius = contact.force, contact.written.pair.radius
    step = force.collision(speed).duration / STEPS
    p, q = 0.25 * force.powers.elastic, 0.25 * force.powers.damping
    k, c = 0.25 * friction.stiffness_power, 0.25 * friction.damping_power
    x, v, g, spring = 0.0, speed, tangential_speed, 0.0
    for _ in range(2 * STEPS):
        before, middle = x, v
        for _ in range(2):  # implicit midpoint rule: fixed point
            half = max(0.5 * (before + x), 0.0)
            normal = force.stiffness * half**p + force.damping * half**q * middle
            x = before + step * middle
            middle = v - 0.5 * step * normal / force.effective_mass
        v = 2.0 * middle - v
        if x <= 0.0 or (normal <= 0.0 and not force.powers.attracts):
            break
        spring = spring * math.sqrt(x / before) if before > 0.0 else 0.0
        spring += friction.stiffness * x**k * g * step
        damping, limit = friction.damping * x**c * g, friction.coefficient * abs(normal)
        total = spring + damping
        if abs(total) > limit:
            total = math.copysign(limit, total)
            spring = (total - damping) * math.sqrt(radius * x) / length_unit
        g -= total / tangential_mass * step
    return -g / tangential_speed


def _model(name: str, terms: Terms, **numbers: tuple[float, float, float]) -> TangentialModel:
    return TangentialModel(name, {**numbers, "coefficient": NUMBER}, terms)


def _of(models: tuple[TangentialModel, ...], name: str) -> TangentialModel:
    """The model of a name."""
    return next(model for model in models if model.name == name)


_HISTORIES: Final = ("mindlin", "mindlin_force", "mindlin_rescale", "mindlin_rescale_force")
_RATIO: Final = {"damping_ratio": NUMBER}
_STATIC: Final = {**_RATIO, "static_coefficient": NUMBER}
_HOOKE: Final = partial(_gran, model="spring")
_HERTZ: Final = partial(_gran, model="mindlin", hertz=True)
_LINEAR: Final = partial(_granular, model="spring")
_MINDLIN: Final = partial(_granular, model="mindlin", radius=True)

#: Models with the words in ``pair_style gran/…`` and, without ``gran/``, ``fix wall/gran``.
GRAN: Final = (
    _model("gran/hooke", partial(_gran, model="none"), damping=RATE),
    _model("gran/hooke/history", _HOOKE, stiffness=STIFFNESS, damping=RATE),
    _model("gran/hertz/history", _HERTZ, stiffness=MODULUS, damping=RATE_BY_LENGTH),
)
#: Models after ``tangential``, with their numbers in the order of the script.
GRANULAR: Final = (
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
)
#: Models with an error of the versions from 2 Aug 2023 until it was mended in 2026: the spring is multiplied by the
#: contact radius, a number in the script's unit of length, once too often: a linear spring always, and each of them
#: after every slip, where T becomes T a. The terms do not say the latter; ``restitution`` does.
SCALED: Final = tuple(
    TangentialModel(
        f"scaled {model.name}",
        {**model.numbers, "length_unit": LENGTH},
        terms,
        partial(_worn, terms=terms),
    )
    for model, terms in (
        (_of(GRAN, "gran/hooke/history"), partial(_scaled, right=_HOOKE)),
        (_of(GRAN, "gran/hertz/history"), _HERTZ),
        (_of(GRANULAR, "linear_history_classic"), partial(_scaled, right=_LINEAR)),
        (_of(GRANULAR, "mindlin_classic"), _MINDLIN),
    )
)
MODELS: Final = (*GRAN, *GRANULAR, *SCALED)


def scaled(tangential: Tangential) -> Tangential:
    """A model as it was in the versions with the error; the numbers are in the script's units."""
    return Tangential(f"scaled {tangential.model}", {**tangential.numbers, "length_unit": 1.0})
