"""Words of contact models in LAMMPS and LIGGGHTS: ``pair_style granular``, ``gran/…`` and ``gran model …``."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from ...convert.tangential import lammps as tangential_models
from .description import Direction
from .formulas import NUMBER
from .statements import Statement, refusal, refused

# --- LAMMPS ---------------------------------------------------------------------------------------------------

#: Normal models of ``pair_style granular`` and their number of parameters.
NORMAL: Final = {"hooke": 2, "hertz": 2, "hertz/material": 3}
#: Those with adhesion, whose constant is the last number.
ADHESIVE: Final = {"dmt": 4, "jkr": 4}
#: Those with plasticity.
PLASTIC: Final = {"mdr": 6, "epa_linear": 6, "epa_nonlinear": 8}
DAMPING: Final = ("none", "velocity", "mass_velocity", "viscoelastic", "tsuji", "coeff_restitution")
#: Names of the numbers after each tangential model.
TANGENTIAL: Final = {"none": (), **{model.name: tuple(model.numbers) for model in tangential_models.GRANULAR}}
BESIDE: Final = {
    "tangential": {name: len(numbers) for name, numbers in TANGENTIAL.items()},
    "rolling": {"none": 0, "sds": 3},
    "twisting": {"none": 0, "marshall": 0, "sds": 3},
    "heat": {"none": 0, "radius": 1, "area": 1},
}
GRAN: Final = ("hooke", "hooke/history", "hertz/history")
#: Shapes of walls and their number of parameters.
WALLS: Final = {"xplane": 2, "yplane": 2, "zplane": 2, "zcylinder": 1, "region": 1}


def pushes(shape: str, low: bool = True, high: bool = True) -> tuple[Direction, ...] | None:
    """The directions in which a plane or cylinder along an axis pushes grains; None for other shapes.

    ``low``, ``high``: whether there is a plane below and above the grains.
    """
    axis = "xyz".find(shape[:1])
    if shape[1:] not in ("plane", "cylinder") or axis < 0:
        return None
    signs = [sign for sign, there in ((1.0, low), (-1.0, high)) if there]
    return tuple(
        tuple(sign * (k == at) for at in range(3))
        for k in range(3)
        if (k == axis) == (shape[1:] == "plane")
        for sign in signs
    )


@dataclass(frozen=True)
class Words:
    """What the words of a contact model say."""

    settings: Mapping[str, tuple[str, ...]]  #: of the normal force
    beside: tuple[str, ...] = ()  #: other forces, such as ``tangential mindlin``
    rest: tuple[str, ...] = ()  #: from the shape of a wall on
    friction: str = "0"  #: coefficient of sliding friction; 0 without tangential forces
    tangential: str = ""  #: tangential model
    numbers: Mapping[str, str] = field(default_factory=dict)  #: its numbers by name


#: A model without words.
NONE: Final = Words({})


def unaccelerated(style: str) -> str:
    """A style without the suffix of an accelerator package."""
    return re.sub(r"/(omp|kk|kk/host|kk/device|gpu|intel|opt)$", "", style)


def gran(statement: Statement, words: Sequence[str], wall: bool = False) -> Words:
    """``STYLE Kn Kt gamma_n gamma_t xmu dampflag [limit_damping]``, and for walls their shape."""
    if not words or words[0] not in GRAN or len(words) < 7:
        raise refused(statement, f"be {', '.join(GRAN)} with six numbers")
    name = "gran/hertz" if words[0] == "hertz/history" else "gran/hooke"
    settings: dict[str, tuple[str, ...]] = {"normal": (name, words[1], words[3])}
    if NUMBER.fullmatch(words[6]) and float(words[6]) not in (0.0, 1.0):
        raise refusal(statement.line, words[6], "be 0 or 1 for dampflag", statement.file)
    if is_zero(words[6]):
        settings["dampflag"] = ("0",)
    rest = words[7:]
    if rest[:1] and rest[0] == "limit_damping":
        settings["limit_damping"] = ()
        rest = rest[1:]
    if rest and not (wall and rest[0] in WALLS):
        raise refusal(
            statement.line,
            rest[0],
            f"be limit_damping or the end in '{' '.join(statement.words)}'",
            statement.file,
        )
    beside = () if is_zero(words[5]) else (f"tangential {words[0]}",)
    numbers = {"stiffness": words[2], "damping": "0" if is_zero(words[6]) else words[4]}
    tangent = ["0" if words[0] == "hooke" else words[2], *list(numbers.values())[1:]]
    if tangent[1] == "NULL":
        tangent[1] = words[3]
    return Words(
        settings,
        beside,
        rest=tuple(rest),
        friction=sliding([*tangent, words[5]]),
        tangential=f"gran/{words[0]}",
        numbers={**numbers, "coefficient": words[5]},
    )


def sliding(numbers: Sequence[str]) -> str:
    """The coefficient of friction, the last number of a tangential model; 0 if its spring and its damping are 0."""
    return "0" if not numbers or all(map(is_zero, numbers[:-1])) else numbers[-1]


def granular(statement: Statement, words: Sequence[str], wall: bool = False, adhesion: bool = False) -> Words:
    """``MODEL numbers [damping …] [tangential …] … [limit_damping]``, up to the shape of a wall."""
    settings: dict[str, tuple[str, ...]] = {"damping": ("viscoelastic",)}
    normal = {**NORMAL, **(ADHESIVE | PLASTIC if adhesion else {})}
    beside, friction, k = list[str](), "0", 0
    tangential, numbers = "", dict[str, str]()
    while k < len(words) and not (wall and words[k] in WALLS):
        word, after = words[k], words[k + 1 : k + 2]
        if word in normal:
            step = 1 + normal[word]
            settings["normal"] = tuple(words[k : k + step])
        elif word == "damping" and after and after[0] in DAMPING:
            step = 2
            settings["damping"] = (after[0],)
        elif word == "damping" and after and after[0] == "mdr" and adhesion:
            step = 3
            settings["damping"] = tuple(words[k + 1 : k + 3])
        elif word in BESIDE and after and after[0] in BESIDE[word]:
            step = 2 + BESIDE[word][after[0]]
            beside += [] if after[0] == "none" else [f"{word} {after[0]}"]
            if word == "tangential":
                friction = sliding(words[k + 2 : k + step])
                tangential = after[0]
                numbers = dict(zip(TANGENTIAL[tangential], words[k + 2 : k + step], strict=False))
            elif word in ("rolling", "twisting"):
                settings[word] = tuple(words[k + 1 : k + step])
        elif word in ("limit_damping", "synchronized_verlet", "cutoff"):
            step = 1 if word != "cutoff" else 2
            settings[word] = ()
        else:
            raise refusal(
                statement.line,
                " ".join([word, *after]),
                f"be words of pair granular without adhesion: {', '.join(NORMAL)}, damping, tangential, …",
                statement.file,
            )
        if k + step > len(words):
            raise refused(statement, f"have {step - 1} words after {word}")
        k += step
    if (
        settings["damping"] == ("none",) and "normal" in settings
    ):  # the damping coefficient is read, and does nothing
        name, stiffness, _, *others = settings["normal"]
        settings |= {"damping": ("velocity",), "normal": (name, stiffness, "0", *others)}
    return Words(settings, tuple(beside), tuple(words[k:]), friction, tangential, numbers)


def wall(statement: Statement, words: Sequence[str], adhesion: bool = False) -> Words:
    """The words of ``fix … wall/gran`` after its style."""
    if words[:1] and words[0] == "granular":
        parsed = granular(statement, words[1:], True, adhesion)
    else:
        parsed = gran(statement, words, True)
    if "limit_damping" in parsed.rest:
        raise refused(statement, f"have limit_damping before {parsed.rest[0]}")
    return parsed


def ordered(first: str, second: str) -> tuple[str, str]:
    """Two types, the smaller number first."""
    both_numbers = first.isdigit() and second.isdigit()
    return (second, first) if both_numbers and int(second) < int(first) else (first, second)


def is_zero(word: str) -> bool:
    """Whether a word is the number 0."""
    try:
        return float(word) == 0.0
    except ValueError:
        return False


# --- LIGGGHTS -------------------------------------------------------------------------------------------------

#: Words of ``pair_style gran`` and ``fix … wall/gran`` with their allowed values; None allows any value.
LIGGGHTS: Final[dict[str, tuple[str, ...] | None]] = {
    "tangential": None,
    "rolling_friction": None,
    "cohesion": ("off",),
    "tangential_reduce": ("on", "off"),
    "surface": ("default",),
    "limitForce": ("on", "off"),
    "tangential_damping": ("on", "off"),
    "ktToKnUser": ("on", "off"),
    "torsionTorque": ("on", "off"),
    "viscous": ("off",),
    "absolute_damping": ("on", "off"),
    "computeElasticPotential": None,
    "computeDissipatedEnergy": None,
    "computeDissipation": None,
    "capillaryModel": None,  # of cohesion capillary
}
#: Models whose force is that of another one, except between the fragments of one grain.
OF_FRAGMENTS: Final = {"hertz/break": "hertz"}
#: Styles of ``fix property/global`` with the number of types of a value.
PROPERTIES: Final = {"peratomtype": 1, "peratomtypepair": 2, "scalar": 0}


def gran_model(statement: Statement, words: Sequence[str]) -> Words:
    """``model NAME word value …``, up to the shape of a wall."""
    if len(words) < 2 or words[0] != "model":
        raise refused(statement, "begin with model NAME")
    settings: dict[str, tuple[str, ...]] = {"model": (OF_FRAGMENTS.get(words[1], words[1]),)}
    beside, shape, k = list[str](), list[str](), 2
    if words[1] in OF_FRAGMENTS:
        beside.append(f"weaker forces between the fragments of one grain ({words[1]})")
    while k < len(words):
        word, after = words[k], words[k + 1 : k + 2]
        if (shape or word in ("primitive", "mesh")) and word not in LIGGGHTS:
            shape.append(word)
            k += 1
            continue
        sticks = word == "cohesion" and after
        if not sticks and (word not in LIGGGHTS or not after or after[0] not in (LIGGGHTS[word] or after)):
            known = LIGGGHTS.get(word)
            must = f"be {word} {' or '.join(known)}" if known else f"be a setting of model {words[1]}"
            raise refusal(
                statement.line,
                " ".join([word, *after]),
                f"{must}: nothing else is supported",
                statement.file,
            )
        settings[word] = (after[0],)
        if word in ("tangential", "rolling_friction") and after[0] not in ("off", "no_history"):
            beside.append(f"{word} {after[0]}")
        elif word == "tangential" and after[0] == "no_history":
            beside.append("tangential no_history")
        k += 2
    if words[1] == "hooke/stiffness":
        settings.setdefault("absolute_damping", ("off",))
    return Words(settings, tuple(beside), tuple(shape))
