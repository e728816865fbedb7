"""Friction of a contact in LAMMPS: its tangential model with numbers, and what it really does, in words."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final, NamedTuple

from ...contact.friction import DEFAULT_RATIO
from ...convert.tangential import Tangential
from ...convert.tangential.lammps import DEFAULT_DAMPING, MODELS, material_stiffness, scaled
from .description import WALL, ContactSettings, Grains, Settings, date
from .granular_words import ADHESIVE, Words, is_zero

#: Normal models with Young's modulus and Poisson's ratio.
MATERIALS: Final = ("hertz/material", *ADHESIVE)
#: Models whose spring is multiplied by the contact radius once too often in some versions; gran/… at walls only.
SCALED: Final = ("gran/hooke/history", "gran/hertz/history", "linear_history_classic", "mindlin_classic")
#: Size ratio beyond which velocities of half a step before matter.
LARGE_RATIO: Final = 3.0

#: A setting that says which normal model limits friction by its elastic force.
ELASTIC: Final = "elastic_limit"
#: A setting that says that k_t follows from the modulus of two materials.
MIXED: Final = "mixed_modulus"
#: A setting with a coefficient of friction that has no effect.
UNUSED: Final = "unused_friction"

#: Names of the numbers of each model.
NUMBERS: Final = {model.name: tuple(model.numbers) for model in MODELS}

Number = Callable[[str], float | None]


def tangential(words: Words, number: Number) -> Tangential | None:
    """The tangential force of a contact; None without one, or if a number of it is not known."""
    if not words.tangential or is_zero(words.friction):
        return None
    taken = {name: word for name, word in words.numbers.items() if name in NUMBERS[words.tangential]}
    values = {name: None if word == "NULL" else number(word) for name, word in taken.items()}
    known = all(values[name] is not None or word == "NULL" for name, word in taken.items())
    positive = all(value is None or value >= 0.0 for value in values.values())
    has_coefficient = values["coefficient"] is not None and values.get("static_coefficient", 0.0) is not None
    return Tangential(words.tangential, values) if known and positive and has_coefficient else None


def marked(settings: Settings, words: Words) -> Settings:
    """Settings that keep a coefficient of friction that has no effect."""
    coefficient = words.numbers.get("coefficient", "0")
    if is_zero(coefficient) or not is_zero(words.friction):
        return settings
    return {**settings, UNUSED: replace(settings["normal"], words=(coefficient,))}


def mixed(
    forces: Sequence[Tangential | None], settings: Sequence[Settings], mixture: Settings
) -> Tangential | None:
    """The tangential force of two types without their own: all numbers have their geometric mean.

    If k_t is NULL, LAMMPS takes the mixed modulus E* in place of E, and the mean of Poisson's ratios.
    """
    first, other = forces
    if first is None or other is None or first.model != other.model:
        return None
    numbers: dict[str, float | None] = {}
    for name, value in first.numbers.items():
        pair = value, other.numbers[name]
        known = [x for x in pair if x is not None]
        numbers[name] = math.sqrt(math.prod(known)) if len(known) == len(pair) else None
    if numbers.get("stiffness", 0.0) is None:
        normals = [each["normal"].words for each in settings]
        if any(words[0] not in MATERIALS for words in normals):
            return None
        ratio = math.sqrt(math.prod(float(words[3]) for words in normals))
        numbers["stiffness"] = material_stiffness(0.75 * float(mixture["normal"].words[1]), ratio)
    return Tangential(first.model, numbers)


# --- versions ---------------------------------------------------------------------------------------------------

#: Versions of which runs are known (tests/data/friction_lammps.csv), and one that changed the walls of ``granular``.
BEFORE_REWRITE, REWRITTEN, FIRST, SECOND = "23 Jun 2022", "28 Mar 2023", "2 Aug 2023", "29 Aug 2024"
#: The last update of 22 Jul 2025 that was examined.
EXAMINED_UPDATE: Final = 4


class Difference(NamedTuple):
    """How a tangential force differs in some versions."""

    since: str  #: the first version of which this is sure
    before: str  #: the first version of which it is not
    old: str  #: the last version before ``since`` that is known to be without; empty if none is
    mended: str  #: the first version that is known to be without
    what: str  #: it, in words
    when: str  #: its versions, in words
    others: str  #: the other versions, in words

    def holds(self, version: str) -> bool | None:
        """Whether a version has this difference; None if that is not known."""
        day, since, before, mended = map(_day, (version, self.since, self.before, self.mended))
        if not day or day >= mended or (self.old and day <= _day(self.old)):
            return False if day else None
        update = re.search(r"Update (\d+)", version)
        examined = update is None or int(update[1]) <= EXAMINED_UPDATE
        return True if since <= day < before and examined else None


def _day(version: str) -> tuple[int, ...]:
    return date(version) or ()


#: https://github.com/lammps/lammps/pull/5007 mended it after the release of 30 Mar 2026.
SCALED_SPRING: Final = Difference(
    FIRST,
    "4 Jul 2026",
    BEFORE_REWRITE,
    "2 Sep 2026",
    "{} of LAMMPS from 2 Aug 2023 until it was mended in 2026 (PR 5007) has k_t times the contact radius in the "
    "script's unit of length: almost no friction in SI units",
    "from 2 Aug 2023 to 2026",
    "since it was mended in 2026",
)
LOST_SPRING: Final = SCALED_SPRING._replace(
    what="{} of LAMMPS from 2 Aug 2023 until it was mended in 2026 (PR 5007) loses its spring at each slip"
)
SHIFTED_NUMBERS: Final = Difference(
    FIRST,
    "3 Aug 2023",
    BEFORE_REWRITE,
    SECOND,
    "{} of LAMMPS 2 Aug 2023 takes the number k_t for γ_t/γ_n, and γ_t/γ_n for μ",
    f"in {FIRST}",
    f"since {SECOND}",
)
WALL_MODULUS: Final = Difference(
    "",
    REWRITTEN,
    "",
    REWRITTEN,
    f"{{}} NULL of a wall has k_t = E (2 − ν)(1 + ν)/4 in LAMMPS before {REWRITTEN}, and 8 G* since",
    f"before {REWRITTEN}",
    f"since {REWRITTEN}",
)


def different(
    force: Tangential, words: Words, wall: bool, number: Number
) -> tuple[Difference, Tangential] | None:
    """How versions of LAMMPS differ in a force, and the force there."""
    if force.model in SCALED and (wall or not force.model.startswith("gran/")):
        lost = force.model in ("gran/hertz/history", "mindlin_classic")
        return LOST_SPRING if lost else SCALED_SPRING, scaled(force)
    if wall and force.model == "gran/hooke" and (shifted := _shifted(words, number)):
        return SHIFTED_NUMBERS, shifted
    name, *normal = words.settings.get("normal", ("",))
    material = wall and name in MATERIALS and force.model.startswith("mindlin")
    if material and force.numbers["stiffness"] is None:
        modulus, ratio = number(normal[0]), number(normal[2])
        if modulus is not None and ratio is not None:
            old = 0.25 * modulus * (2.0 - ratio) * (1.0 + ratio)
            return WALL_MODULUS, Tangential(force.model, {**force.numbers, "stiffness": old})
    return None


def _shifted(words: Words, number: Number) -> Tangential | None:
    """The numbers of ``fix wall/gran hooke`` in the version that takes each for the next."""
    normal = [number(word) for word in words.settings["normal"][1:3]]
    if None in normal or not normal[1]:
        return None
    stiffness, damping = (x for x in normal if x is not None)
    ratio, slip = words.numbers["stiffness"], words.numbers["damping"]
    taken = DEFAULT_RATIO * stiffness if ratio == "NULL" else number(ratio)
    coefficient = DEFAULT_DAMPING * damping if slip == "NULL" else number(slip)
    if taken is None or coefficient is None:
        return None
    return Tangential("gran/hooke", {"damping": taken * damping, "coefficient": coefficient / damping})


class Versions(NamedTuple):
    """A tangential force in a version, by default the newest, and in others."""

    force: Tangential | None  #: None without one, or if it is not known
    others: tuple[tuple[str, Tangential], ...] = ()  #: after their versions in words
    what: str = ""  #: the difference, in words


def in_versions(
    force: Tangential | None, words: Words, wall: bool, version: str | None, number: Number
) -> Versions:
    """The tangential force of a contact in this version, and in others."""
    differs = None if force is None else different(force, words, wall, number)
    if force is None or differs is None:
        return Versions(force)
    difference, other = differs
    holds = None if version is None else difference.holds(version)
    if holds is False:
        return Versions(force)
    where = f"wall/gran {force.model.removeprefix('gran/')}" if wall else f"tangential {force.model}"
    if force.model.startswith("mindlin"):
        where = f"tangential {force.model}"
    text = difference.what.format(where)
    if holds:
        return Versions(other, ((difference.others, force),), f"{text}; the version is {version}")
    if version is None:
        return Versions(
            force, ((difference.when, other),), f"{text}; give the version (--version), or the log"
        )
    both = ((difference.when, other), (difference.others, force))
    return Versions(None, both, f"{text}; whether {version} does is not known")


def divides_by_zero(settings: Settings, version: str | None) -> bool:
    """Whether a wall gran/… has forces that are not numbers: without normal damping, from 2 Aug 2023 on."""
    old = version is not None and () < _day(version) <= _day(BEFORE_REWRITE)
    return settings["normal"].words[0].startswith("gran/") and undamped(settings) and not old


# --- what it really does ----------------------------------------------------------------------------------------

HALF_STEP: Final = (
    "sizes differ by more than a factor of 3: the tangential force mixes positions with velocities of half a step "
    "before, so that small grains may stick to large ones (Vyas et al. 2025)"
)
SMOOTH: Final = "no history, and no damping: no tangential force, whatever μ is"
IDLE: Final = "μ {} without a tangential spring or damping: no tangential force"
NO_HISTORY: Final = "no history: no static friction, and surfaces never rebound, β ≤ 0"
NO_DAMPING: Final = "x_t multiplies a normal damping of 0: there is no tangential damping"
DEFAULT_SPRING: Final = "k_t NULL is 2/7 k_n, about a third of that of elastic spheres"
DEFAULT_MODULUS: Final = "k_t NULL is 2/7 k_n, about a quarter of Mindlin's 3 (1 − ν)/(2 − ν) k_n"
DAMPFLAG: Final = "dampflag 0 leaves out the tangential damping only"
ATTRACTIVE: Final = (
    "without limit_damping, the normal force attracts at the end, and μ |F_n| limits friction there as well"
)
ELASTIC_LIMIT: Final = "{}: μ times the elastic force limits friction, without damping; its β is not known"
NOT_A_NUMBER: Final = f"γ_n is 0: since {FIRST}, LAMMPS divides by it at this wall, and grains vanish (NaN)"
SAME_MATERIAL: Final = "the wall has the material of its line on both sides: as a large grain, not rigid"
MIXED_SPRING: Final = (
    "k_t NULL of two types that are mixed: LAMMPS takes E* for E, so that k_t is 1/(2 (1 − ν²)) of Mindlin's"
)
KEPT_SPRING: Final = (
    "{} with γ_t: beyond tan γ ≈ μ/x_t the spring begins against the slip and grows with the contact radius, so that "
    "β may depend on the time step and be below −1"
)
DISKS: Final = (
    "grains in two dimensions spin as spheres, I = 2/5 m R²; disks have 1/2 (fix nve/sphere … disc)"
)
NO_SPIN: Final = "no fix changes their spins (nve/sphere does): friction acts on velocities alone"


def undamped(settings: Settings) -> bool:
    """Whether the normal force has no damping."""
    name, *numbers = settings["normal"].words
    by_restitution = (
        settings.get("damping") is not None and settings["damping"].words[0] == "coeff_restitution"
    )
    number = numbers[1] if len(numbers) > 1 else ""
    try:
        return float(number) == (1.0 if by_restitution and not name.startswith("gran/") else 0.0)
    except ValueError:
        return False


def remarks(
    contact: ContactSettings, version: str | None, grains: Mapping[str, Grains], dimension: int
) -> Iterator[str]:
    """What the friction of a contact really does, beside the error that multiplies springs."""
    if contact.wall and divides_by_zero(contact.settings, version):
        yield NOT_A_NUMBER
    if contact.friction == 0.0 and UNUSED in contact.settings:
        yield IDLE.format(contact.settings[UNUSED].words[0])
    if contact.friction != 0.0:
        yield from _of_grains(contact, grains, dimension)
        yield from _of_model(contact)
    yield from _of_rolling(contact.settings)


def _of_model(contact: ContactSettings) -> Iterator[str]:
    force, settings, name = contact.tangential, contact.settings, contact.settings["normal"].words[0]
    smooth = undamped(settings)
    if force is not None:
        yield from _of_numbers(force, settings, smooth)
    if MIXED in settings:
        yield MIXED_SPRING
    if ELASTIC in settings and not smooth:
        yield ELASTIC_LIMIT.format(settings[ELASTIC].words[0])
    if "dampflag" in settings:
        yield DAMPFLAG
    if "limit_damping" not in settings and not smooth:
        yield ATTRACTIVE
    if contact.wall and name in MATERIALS:
        yield SAME_MATERIAL


def _of_numbers(force: Tangential, settings: Settings, smooth: bool) -> Iterator[str]:
    model, numbers = force.model.removeprefix("scaled "), force.numbers
    damping = numbers.get("damping_ratio", numbers.get("damping"))
    if "damping_ratio" in numbers and damping and smooth:
        yield SMOOTH if model == "linear_nohistory" else NO_DAMPING
    elif model in ("gran/hooke", "linear_nohistory"):
        yield NO_HISTORY
    if model.startswith("gran/") and numbers.get("stiffness", 0.0) is None:
        yield DEFAULT_MODULUS if model == "gran/hertz/history" else DEFAULT_SPRING
    kept = model in ("mindlin", "mindlin_rescale", "mindlin_classic", "mindlin/static")
    if kept and damping and not smooth and settings["damping"].words[0] != "viscoelastic":
        yield KEPT_SPRING.format(f"tangential {model}")


def _of_grains(contact: ContactSettings, grains: Mapping[str, Grains], dimension: int) -> Iterator[str]:
    kinds = [grains[name] for name in contact.types if name != WALL and name in grains]
    moving = [kind for kind in kinds if not kind.frozen]
    if any(math.isinf(kind.inertia_factor) for kind in moving):
        yield NO_SPIN
    elif dimension == 2 and any(kind.inertia_factor == 0.4 for kind in moving):
        yield DISKS
    radii = [radius for kind in kinds for radius in kind.radii or ()]
    lowest = min(radii, default=0.0)
    mends = "synchronized_verlet"
    wide = lowest > 0.0 and max(radii) > LARGE_RATIO * lowest
    if wide and not contact.wall and mends not in contact.settings:
        granular = not contact.settings["normal"].words[0].startswith("gran/")
        yield HALF_STEP + (f"; {mends} mends it" if granular else "")


def _of_rolling(settings: Settings) -> Iterator[str]:
    """The angular impulse of rolling and twisting resistance in one collision."""
    for name, about in (
        ("rolling", "ω_i − ω_j across the normal"),
        ("twisting", "ω_i − ω_j about the normal"),
    ):
        words = settings[name].words if name in settings else ("none",)
        if words[0] == "none" or (len(words) > 1 and is_zero(words[-1])):
            continue
        number = words[-1] if len(words) > 1 else "μ_r" if name == "rolling" else "μ_w"
        size = {"rolling": f"{number} R_eff J_n", "sds": f"{number} J_n"}
        most = size["rolling"] if name == "rolling" else size.get(words[0], "2/3 μ a J_n (a: contact radius)")
        yield (
            f"{name} {words[0]}: a collision with the normal impulse J_n adds an angular impulse of at most {most} "
            f"against {about}, and less where less stops it"
        )
