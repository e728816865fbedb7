"""Friction of a contact in LIGGGHTS: its tangential model with numbers, and what it really does, in words."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from typing import Final

from ...convert.tangential import Tangential
from ...convert.tangential.liggghts import NORMAL, effective_shear_modulus
from .description import ContactSettings, Settings

#: Words after ``tangential`` that are understood.
KNOWN: Final = ("off", "history", "no_history")
#: Words after ``rolling_friction`` that are understood.
ROLLING: Final = ("off", "cdt", "epsd", "epsd2", "epsd3")
ROLLING_PROPERTIES: Final = ("coefficientRollingFriction", "coefficientRollingViscousDamping")
#: Properties of two types on which friction depends, beside those of the normal force.
PROPERTIES: Final = ("coefficientFriction", "kt", "gammat", "gammat_abs", *ROLLING_PROPERTIES)
#: Words of the settings of a model that are understood.
KNOWN_WORDS: Final = {"tangential": KNOWN, "rolling_friction": ROLLING}

#: The values of a property for two types, the same twice for a pair; None if one is not known.
Values = Callable[[str], tuple[float, float] | None]


def word(settings: Settings, name: str, default: str = "off") -> str:
    """The word of a setting of a model."""
    return settings[name].words[0] if name in settings else default


def tangential(model: Settings, values: Values) -> Tangential | None:
    """The tangential force between two types; None without one, or if a number of it is not known."""
    normal, kind = word(model, "model"), word(model, "tangential")
    if kind not in KNOWN[1:] or normal not in NORMAL:
        return None
    numbers: dict[str, float | None] = {"coefficient": first(values("coefficientFriction"))}
    needed = ["coefficient"]
    if normal == "hertz":
        moduli, ratios = values("youngsModulus"), values("poissonsRatio")
        if moduli is None or ratios is None:
            return None
        numbers["shear_modulus"] = effective_shear_modulus(*zip(moduli, ratios, strict=True))
    elif normal == "hooke":
        numbers["ktToKnUser"] = on(model, "ktToKnUser")
    else:
        absolute = word(model, "absolute_damping") == "on"
        damping = "absolute_damping" if absolute else "damping"
        numbers["stiffness"] = first(values("kt"))
        numbers[damping] = first(values("gammat_abs" if absolute else "gammat"))
        needed += ["stiffness", damping]
    numbers["tangential_damping"] = on(model, "tangential_damping")
    known = all(numbers[name] is not None for name in needed)
    return Tangential(f"{normal} {kind}", numbers) if known else None


def first(pair: tuple[float, float] | None) -> float | None:
    """The value of a pair of types."""
    return None if pair is None else pair[0]


def on(settings: Settings, name: str) -> float | None:
    """1 for on, 0 for off, None if it is not given."""
    return {"on": 1.0, "off": 0.0}.get(word(settings, name, ""))


# --- what it really does ----------------------------------------------------------------------------------------

EQUAL_STIFFNESS: Final = "k_t = k_n, the default of model hooke; ktToKnUser on gives 2/7 k_n"
NO_SPRING: Final = "tangential no_history has no spring: no static friction, β ≤ 0 at all angles"
NO_FORCE: Final = (
    "tangential no_history without damping: no tangential force, whatever coefficientFriction is"
)
UNLIMITED: Final = "kt is 0: the damping is not limited, whatever coefficientFriction is"
SPRING_LIMITED: Final = (
    "μ |F_n| limits the spring alone: damping adds to it while surfaces stick, and is off while they slip"
)
NO_DAMPING: Final = "tangential_damping off leaves the spring and μ |F_n|: friction without γ_t"
ATTRACTIVE: Final = (
    "limitForce off: the normal force attracts at the end, and μ |F_n| limits friction there as well"
)

#: In runs of hooke, hooke/stiffness and hertz/stiffness; hertz had none at 200 angles and five ε.
STEPS_DECIDE: Final = (
    "limitForce off with γ_t: near the angle of full sliding, β depends on where the time steps fall (by up to 0.16 in "
    "runs); with limitForce on it does not"
)


def remarks(contact: ContactSettings) -> Iterator[str]:
    """What the sliding friction of a contact really does."""
    if contact.friction != 0.0 and word(contact.settings, "tangential") in KNOWN[1:]:
        yield from _of_sliding(contact)


def _of_sliding(contact: ContactSettings) -> Iterator[str]:
    settings = contact.settings
    if word(settings, "tangential") == "no_history":
        yield NO_SPRING if _is_damped(contact) else NO_FORCE
    elif contact.tangential is not None and contact.tangential.numbers.get("stiffness") == 0.0:
        yield UNLIMITED if _is_damped(contact) else NO_FORCE
    else:
        if word(settings, "model") == "hooke" and word(settings, "ktToKnUser") == "off":
            yield EQUAL_STIFFNESS
        if word(settings, "tangential_damping", "on") == "off":
            yield NO_DAMPING
        elif _is_damped(contact):
            yield SPRING_LIMITED
    if word(settings, "limitForce") == "off" and not _normal_is_undamped(settings):
        yield ATTRACTIVE
        spring = word(settings, "tangential") == "history" and word(settings, "model") != "hertz"
        if spring and _is_damped(contact):
            yield STEPS_DECIDE


#: What makes a normal force undamped: a property and its value.
UNDAMPED: Final = {"coefficientRestitution": 1.0, "gamman": 0.0, "gamman_abs": 0.0}


def _normal_is_undamped(settings: Settings) -> bool:
    """Whether the property from which the model has its damping says that there is none."""
    name = "coefficientRestitution"
    if "/stiffness" in word(settings, "model"):
        name = "gamman_abs" if word(settings, "absolute_damping") == "on" else "gamman"
    return name in settings and float(settings[name].words[0]) == UNDAMPED[name]


def _is_damped(contact: ContactSettings) -> bool:
    """Whether γ_t > 0."""
    force = contact.tangential
    if word(contact.settings, "tangential_damping", "on") == "off":
        return False
    if force is not None and "/stiffness" in force.model:
        return bool(force.numbers.get("damping") or force.numbers.get("absolute_damping"))
    return not _normal_is_undamped(contact.settings)


def rolling_remarks(contacts: Iterable[ContactSettings]) -> Iterator[tuple[str, list[ContactSettings]]]:
    """What rolling resistance does, with the contacts that differ in its coefficient at most."""
    groups: dict[str, list[ContactSettings]] = {}
    for contact in contacts:
        groups.setdefault(_of_rolling(contact.settings, "{}"), []).append(contact)
    for text, same in groups.items():
        values = sorted({word(contact.settings, ROLLING_PROPERTIES[0], "") for contact in same}, key=_value)
        most = " or ".join(f"{float(value):g}" if value else "μ_r" for value in values)
        if text:
            yield text.format(most), same


def _value(word: str) -> float:
    return float(word) if word else math.inf


def _of_rolling(settings: Settings, most: str) -> str:
    """The angular impulse of rolling resistance in one collision; cdt and the limit of epsd2 agree with runs.

    ``most``: its coefficient, in words. Empty without such a resistance.
    """
    kind = word(settings, "rolling_friction")
    coefficient, damping = (word(settings, name, "") for name in ROLLING_PROPERTIES)
    if kind not in ROLLING[1:] or (coefficient and float(coefficient) == 0.0):
        return ""
    most = f"{most} R_eff J_n"
    about = "" if word(settings, "torsionTorque") == "on" else " across the normal"
    impulse = f"an angular impulse of {'' if kind == 'cdt' else 'up to '}{most} against ω_i − ω_j{about}"
    ends = ["and at most what stops it"] if kind == "cdt" else []
    if kind == "epsd2":
        ends = ["and its spring may reverse that"]
    elif kind != "cdt" and not (damping and float(damping) == 0.0):
        ends = ["and more by its dashpot, which has no limit"]
    words = [f"rolling_friction {kind}: a collision with the normal impulse J_n adds {impulse}", *ends]
    return f"{', '.join(words)}; β leaves it out"
