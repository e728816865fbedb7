"""Friction in a script of YADE: the tangential force of a contact, and what its words do against expectation."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from ...convert.tangential import Tangential
from .description import WALL, Note

if TYPE_CHECKING:
    from .python import Instance
    from .yade import Yade

FRICTION_ANGLE: Final = 0.5  #: default of all materials
#: A law without tangential force, and one whose spring follows the compression only if asked.
SMOOTH_LAW: Final = "Law2_ScGeom_MindlinPhys_MindlinDeresiewitz"
LINEAR_LAW: Final = "Law2_ScGeom_MindlinPhys_HertzWithLinearShear"
#: What resists rolling and twisting in ``CohFrictMat``, with its defaults.
OF_COHESIVE: Final = {"alphaKr": 2.0, "alphaKtw": 2.0, "etaRoll": -1.0, "etaTwist": -1.0}


class Contact(NamedTuple):
    """Two materials, their functor, and the size of a wall over that of the sphere if the second is one."""

    functor: Instance
    pair: tuple[Instance, Instance]
    ends: tuple[int, int]
    wall: float | None
    kind: str = ""  #: of the wall

    @property
    def physics(self) -> str:
        """The name of the interaction, such as ``FrictPhys``."""
        return self.functor.name.rpartition("_")[2]


def mixed(matcher: Instance, values: tuple[float, float]) -> float | None:
    """The number of a MatchMaker for two that it does not list; None if that is not known."""
    first, second = values
    mixes: Mapping[str, Any] = {
        "avg": 0.5 * (first + second),
        "min": min(values),
        "max": max(values),
        "harmAvg": 2.0 * first * second / (first + second) if first + second else 0.0,
        "zero": 0.0,
        "val": matcher.attributes.get("val"),
    }
    value = mixes.get(matcher.attributes.get("algo", "avg"))
    return float(value) if isinstance(value, int | float) else None


def friction_angle(script: Yade, contact: Contact) -> float | None:
    """The smaller angle of the two materials, or the functor's, in radians; None if it is not known."""
    try:
        angles = [script.number(material, "frictionAngle") for material in contact.pair]
        if "frictAngle" not in contact.functor.attributes:
            return min(angles)
        values = None if contact.physics == "ViscElPhys" else (angles[0], angles[1])
        return script.matched(contact.functor, "frictAngle", contact.ends, values)
    except ValueError:
        return None


def tangential_of(script: Yade, contact: Contact) -> tuple[float | None, Tangential | None]:
    """The coefficient of friction and the tangential force; None if they are not known.

    Without friction there is no tangential force.
    """
    if contact.physics == "MindlinPhys" and any(law.name == SMOOTH_LAW for law in laws(script, contact)):
        return 0.0, None
    angle = friction_angle(script, contact)
    if angle is None or not 0.0 <= angle <= 0.5 * math.pi:
        return None, None
    if angle == 0.0 and contact.physics != "ViscElPhys":
        return 0.0, None
    numbers = known(script, contact)
    if unlimited(numbers):
        return None, None
    if numbers is None or angle == 0.0:
        return math.tan(angle), None
    linear = any(law.name == LINEAR_LAW for law in laws(script, contact))
    model = "HertzWithLinearShear" if linear and contact.physics == "MindlinPhys" else contact.physics
    return math.tan(angle), Tangential(model, {"friction_angle": angle, **numbers})


def known(script: Yade, contact: Contact) -> dict[str, float | None] | None:
    """The numbers of the tangential force beside friction; None if they are not known."""
    try:
        return words(script, contact)
    except (ValueError, ZeroDivisionError):
        return None


def unlimited(numbers: Mapping[str, float | None] | None) -> bool:
    """Whether there is a damping and no spring: Coulomb's law limits nothing, and the normal force may end before."""
    return (
        numbers is not None and 0.0 in (numbers.get("ks"), numbers.get("poisson")) and bool(numbers.get("cs"))
    )


def laws(script: Yade, contact: Contact) -> list[Instance]:
    """The laws of this interaction."""
    return [law for law in script.used("Law2_") if f"_{contact.physics}_" in law.name]


def words(script: Yade, contact: Contact) -> dict[str, float | None] | None:
    """The same, or an error."""
    if any(law.attributes.get("shear_creep") for law in laws(script, contact)):
        return None
    if contact.physics == "MindlinPhys":
        return of_mindlin(script, contact)
    if contact.physics == "ViscElPhys":
        return of_viscoelastic(script, contact)
    numbers: dict[str, float | None] = {}
    if "ks" in contact.functor.attributes:
        numbers["ks"] = script.matched(contact.functor, "ks", contact.ends)
        return None if numbers["ks"] is None else numbers
    return ratio_of_springs(script, contact)


def ratio_of_springs(script: Yade, contact: Contact) -> dict[str, float | None] | None:
    """k_s/k_n of springs in series, ν Y of each body over Y. A spring of 0 N/m is left out by ViscElPhys."""
    young, ratios = ([script.number(each, name) for each in contact.pair] for name in ("young", "poisson"))
    shear = [modulus * ratio for modulus, ratio in zip(young, ratios, strict=True)]
    if not all(shear):
        if contact.physics == "FrictPhys":
            return {"poisson": 0.0} if any(shear) else None  # YADE divides 0 by 0
        if contact.physics == "CohFrictPhys" or not any(shear):
            return {"poisson": 0.0}
        return None
    normal = script.mean_modulus(young, contact.ends, contact.wall)
    tangential = script.mean_modulus(shear, contact.ends, contact.wall)
    if ratios[0] == ratios[1]:
        return {"poisson": ratios[0]}
    return {"poisson": tangential / normal} if normal and tangential else None


def of_mindlin(script: Yade, contact: Contact) -> dict[str, float | None] | None:
    """Poisson's ratio with 4 G*/E* of the two materials, and the damping."""
    young, ratios = ([script.number(each, name) for each in contact.pair] for name in ("young", "poisson"))
    bodies = [*zip(young, ratios, strict=True)]
    stiffness = 2.0 * sum((1.0 - nu**2) / modulus for modulus, nu in bodies)
    stiffness /= sum((2.0 - nu) * (1.0 + nu) / modulus for modulus, nu in bodies)
    poisson = ratios[0] if ratios[0] == ratios[1] else 2.0 * (1.0 - stiffness) / (2.0 - stiffness)
    numbers: dict[str, float | None] = {"poisson": poisson}
    linear = [law for law in laws(script, contact) if law.name == LINEAR_LAW]
    if linear:
        value = linear[-1].attributes.get("nonLin", 0)
        return {**numbers, "nonLin": float(value > 0)} if isinstance(value, int | float) else None
    for name in ("es", "betas"):
        if name in contact.functor.attributes:
            numbers[name] = script.matched(contact.functor, name, contact.ends)
            if numbers[name] is None:
                return None
    return numbers


def of_viscoelastic(script: Yade, contact: Contact) -> dict[str, float | None] | None:
    """``et``, ``ks`` and ``cs``, or ν and ``cs``, as YADE chooses them."""
    pair, functor = contact.pair, contact.functor

    def have(*names: str) -> bool:
        return all(name in each.attributes for each in pair for name in names)

    if have("tc", "en", "et") or {"tc", "en", "et"} <= functor.attributes.keys():
        if "et" in functor.attributes:
            et = script.matched(functor, "et", contact.ends)
        else:
            et = 0.5 * sum(script.number(each, "et") for each in pair)
        return {"et": et} if et is not None and 0.0 < et <= 1.0 else None
    if have("kn", "cn", "ks", "cs"):
        return {name: script.in_series(name, pair) for name in ("ks", "cs")}
    numbers = ratio_of_springs(script, contact)
    if numbers is not None and have("cn", "cs"):
        numbers["cs"] = script.in_series("cs", pair)
    return numbers


#: What β leaves out.
WITHOUT: Final = "β is without it"


# --- what a reader of the script does not expect ------------------------------------------------------------------


def warnings(
    script: Yade, contact: Contact, types: tuple[str, str], tangential: Tangential | None
) -> Iterator[Note]:
    """What the friction of a contact really does."""
    functor = script.at(contact.functor)
    material = script.at(contact.pair[0])
    for law in laws(script, contact):
        if text := of_law(law):
            yield Note(text, types, script.at(law))
    angle = friction_angle(script, contact)
    if angle is not None and not 0.0 <= angle <= 0.5 * math.pi:
        yield Note(f"an angle of friction of {angle:g}, which YADE takes in radians", types, material)
    if contact.physics == "ViscElPhys" and unlimited(known(script, contact)):
        text = "a damping cs that nothing limits, whatever the angle of friction: YADE limits the spring, and ks = 0"
        yield Note(text, types, material)
    numbers = {} if tangential is None else tangential.numbers
    if (es := numbers.get("es")) is not None:
        text = (
            f"es = {es:g} is no restitution of the surfaces: YADE 2023.02 computes cs from it as it computes cn from"
            " en; before, es has no effect"
        )
        yield Note(text, types, functor)
    if (et := numbers.get("et")) is not None:
        source = functor if "et" in contact.functor.attributes else material
        halved = types[1] == WALL and contact.kind != "boxes"
        yield Note(of_half_mass(contact.kind, et) if halved else of_et(et), types, source)
    yield from (Note(text, types, functor) for text in of_rolling(script, contact))


def of_et(et: float) -> str:
    """What ``et`` is."""
    return f"et = {et:g} reverses the velocity of the surfaces: β = +{et:g} in a contact of duration tc without slip"


def of_half_mass(kind: str, et: float) -> str:
    """What ``et`` is at a body without mass."""
    return (
        f"at {kind}, YADE computes kn, cn, ks and cs with half the mass of the sphere: a contact lasts √2 tc, and"
        f" neither is ε = en, nor β = et = {et:g}"
    )


def of_law(law: Instance) -> str:
    """What a law leaves out."""
    if law.name == SMOOTH_LAW:
        return "no tangential force at all: MindlinDeresiewitz adds up a displacement and computes no force from it"
    if law.name == LINEAR_LAW and not law.attributes.get("nonLin", 0):
        return "ks does not depend on the compression: YADE takes the number of 8 G* √R, in N/m^1.5, as N/m"
    return ""


def of_rolling(script: Yade, contact: Contact) -> Iterator[str]:
    """What resists rolling and twisting, as the angular impulse of one collision."""
    if contact.physics == "MindlinPhys":
        yield from of_bending(script, contact)
    elif contact.physics == "ViscElPhys":
        yield from of_drag(script, contact)
    elif contact.physics == "CohFrictPhys":
        yield from of_moments(script, contact)


def of_bending(script: Yade, contact: Contact) -> Iterator[str]:
    """``krot`` and ``ktwist`` of MindlinPhys."""
    attributes = contact.functor.attributes
    stiffness = {name: attributes[name] for name in ("krot", "ktwist") if attributes.get(name)}
    if not stiffness:
        return
    shown = " and ".join(
        f"{name} = {value:g}" if isinstance(value, int | float) else name for name, value in stiffness.items()
    )
    if not any(law.attributes.get("includeMoment") for law in laws(script, contact)):
        yield f"{shown} without effect: the law lacks includeMoment=True"
        return
    eta = attributes.get("eta", 0.0)
    limit = "not limited"
    if isinstance(eta, int | float) and eta > 0.0:
        limit = f"that against rolling limited to {eta:g} R J_n"
    impulse = "an angular impulse of up to k ω t_c²/2 per collision"
    yield f"springs against rolling and twisting ({shown}): {impulse}, {limit}; {WITHOUT}"


def of_drag(script: Yade, contact: Contact) -> Iterator[str]:
    """``mR`` of ViscElPhys, which multiplies the relative spin, not its direction as it was meant."""
    try:
        resistance = script.in_series("mR", contact.pair)
    except ValueError:
        yield "resistance against rolling (mR), whose number is not known"
        return
    if resistance > 0.0:
        factor = " |R₁ω₁ + R₂ω₂|" if contact.pair[0].attributes.get("mRtype", 1) == 2 else ""
        impulse = (
            f"an angular impulse of up to mR{factor} ω J_n per collision, with the relative spin ω itself"
        )
        yield f"resistance against rolling and twisting (mR = {resistance:g}): {impulse}; {WITHOUT}"


def of_moments(script: Yade, contact: Contact) -> Iterator[str]:
    """``alphaKr`` and ``alphaKtw`` of CohFrictPhys, which only bonds have by default."""
    if not all(each.attributes.get("momentRotationLaw", False) for each in contact.pair):
        return
    if not any(law.attributes.get("always_use_moment_law") for law in laws(script, contact)):
        missing = "the contacts are not cohesive, and the law lacks always_use_moment_law=True"
        yield f"momentRotationLaw without effect: {missing}"
        return
    numbers = {
        name: [each.attributes.get(name, value) for each in contact.pair]
        for name, value in OF_COHESIVE.items()
    }
    shown = ", ".join(f"{name} = {listed(values)}" for name, values in numbers.items())
    limits = numbers["etaRoll"]
    limit = "not limited"
    if all(isinstance(value, int | float) and value >= 0.0 for value in limits):
        limit = "limited to etaRoll R J_n"
    impulse = "an angular impulse of up to alphaKr ks R₁R₂ ω t_c²/2 per collision"
    yield f"springs against rolling and twisting ({shown}): {impulse}, {limit}; {WITHOUT}"


def listed(values: list[Any]) -> str:
    """Values of two materials: the common one, or both."""
    texts = [f"{value:g}" if isinstance(value, int | float) else "?" for value in values]
    return " | ".join(dict.fromkeys(texts))
