"""Friction in a script of YADE: the tangential force of a contact, and what its words do against expectation."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, Final

from ...convert.tangential import Tangential
from .description import WALL, Note
from .yade_numbers import Contact

if TYPE_CHECKING:
    from .python import Instance

#: A law without tangential force, and one whose spring follows the compression only if asked.
SMOOTH_LAW: Final = "Law2_ScGeom_MindlinPhys_MindlinDeresiewitz"
LINEAR_LAW: Final = "Law2_ScGeom_MindlinPhys_HertzWithLinearShear"
#: What resists rolling and twisting in ``CohFrictMat``, with its defaults.
OF_COHESIVE: Final = {"alphaKr": 2.0, "alphaKtw": 2.0, "etaRoll": -1.0, "etaTwist": -1.0}


def friction_angle(contact: Contact) -> float | None:
    """The smaller angle of the two materials, or the functor's, in radians; None if it is not known."""
    try:
        angles = contact.both("frictionAngle")
        if "frictAngle" not in contact.functor.attributes:
            return min(angles)
        return contact.matched("frictAngle", None if contact.physics == "ViscElPhys" else angles)
    except ValueError:
        return None


def tangential_of(contact: Contact) -> tuple[float | None, Tangential | None]:
    """The coefficient of friction and the tangential force; None if they are not known.

    Without friction there is no tangential force.
    """
    if contact.physics == "MindlinPhys" and any(law.name == SMOOTH_LAW for law in contact.laws):
        return 0.0, None
    angle = friction_angle(contact)
    if angle is None or not 0.0 <= angle <= 0.5 * math.pi:
        return None, None
    if angle == 0.0 and contact.physics != "ViscElPhys":
        return 0.0, None
    numbers = known(contact)
    if unlimited(numbers):
        return None, None
    if numbers is None or angle == 0.0:
        return math.tan(angle), None
    linear = any(law.name == LINEAR_LAW for law in contact.laws)
    model = "HertzWithLinearShear" if linear and contact.physics == "MindlinPhys" else contact.physics
    return math.tan(angle), Tangential(model, {"friction_angle": angle, **numbers})


def known(contact: Contact) -> dict[str, float | None] | None:
    """The numbers of the tangential force beside friction; None if they are not known."""
    try:
        return words(contact)
    except (ValueError, ZeroDivisionError):
        return None


def unlimited(numbers: Mapping[str, float | None] | None) -> bool:
    """Whether there is a damping and no spring: Coulomb's law limits nothing, and the normal force may end before."""
    return (
        numbers is not None and 0.0 in (numbers.get("ks"), numbers.get("poisson")) and bool(numbers.get("cs"))
    )


def words(contact: Contact) -> dict[str, float | None] | None:
    """The same, or an error."""
    if any(law.attributes.get("shear_creep") for law in contact.laws):
        return None
    if contact.physics == "MindlinPhys":
        return of_mindlin(contact)
    if contact.physics == "ViscElPhys":
        return of_viscoelastic(contact)
    numbers: dict[str, float | None] = {}
    if "ks" in contact.functor.attributes:
        numbers["ks"] = contact.matched("ks")
        return None if numbers["ks"] is None else numbers
    return ratio_of_springs(contact)


def ratio_of_springs(contact: Contact) -> dict[str, float | None] | None:
    """k_s/k_n of springs in series, ν Y of each body over Y. A spring of 0 N/m is left out by ViscElPhys."""
    young, ratios = contact.both("young"), contact.both("poisson")
    shear = (young[0] * ratios[0], young[1] * ratios[1])
    if not all(shear):
        if contact.physics == "FrictPhys":
            return {"poisson": 0.0} if any(shear) else None  # YADE divides 0 by 0
        if contact.physics == "CohFrictPhys" or not any(shear):
            return {"poisson": 0.0}
        return None
    normal = contact.mean_modulus(young)
    tangential = contact.mean_modulus(shear)
    if ratios[0] == ratios[1]:
        return {"poisson": ratios[0]}
    return {"poisson": tangential / normal} if normal and tangential else None


def of_mindlin(contact: Contact) -> dict[str, float | None] | None:
    """Poisson's ratio with 4 G*/E* of the two materials, and the damping."""
    young, ratios = contact.both("young"), contact.both("poisson")
    bodies = [*zip(young, ratios, strict=True)]
    stiffness = 2.0 * sum((1.0 - nu**2) / modulus for modulus, nu in bodies)
    stiffness /= sum((2.0 - nu) * (1.0 + nu) / modulus for modulus, nu in bodies)
    poisson = ratios[0] if ratios[0] == ratios[1] else 2.0 * (1.0 - stiffness) / (2.0 - stiffness)
    numbers: dict[str, float | None] = {"poisson": poisson}
    linear = [law for law in contact.laws if law.name == LINEAR_LAW]
    if linear:
        value = linear[-1].attributes.get("nonLin", 0)
        return {**numbers, "nonLin": float(value > 0)} if isinstance(value, int | float) else None
    for name in ("es", "betas"):
        if name in contact.functor.attributes:
            numbers[name] = contact.matched(name)
            if numbers[name] is None:
                return None
    return numbers


def of_viscoelastic(contact: Contact) -> dict[str, float | None] | None:
    """``et``, ``ks`` and ``cs``, or ν and ``cs``, as YADE chooses them."""
    if contact.has_duration:
        et = contact.mean("et")
        return {"et": et} if et is not None and 0.0 < et <= 1.0 else None
    if contact.have("kn", "cn", "ks", "cs"):
        return {name: contact.in_series(name) for name in ("ks", "cs")}
    numbers = ratio_of_springs(contact)
    if numbers is not None and contact.have("cn", "cs"):
        numbers["cs"] = contact.in_series("cs")
    return numbers


#: What β leaves out.
WITHOUT: Final = "β is without it"


# --- what a reader of the script does not expect ------------------------------------------------------------------


def warnings(contact: Contact, tangential: Tangential | None) -> Iterator[Note]:
    """What the friction of a contact really does."""
    types, at = contact.types, contact.scene.at
    functor, material = at(contact.functor), at(contact.pair[0])
    for law in contact.laws:
        if text := of_law(law):
            yield Note(text, types, at(law))
    angle = friction_angle(contact)
    if angle is not None and not 0.0 <= angle <= 0.5 * math.pi:
        yield Note(f"an angle of friction of {angle:g}, which YADE takes in radians", types, material)
    if contact.physics == "ViscElPhys" and unlimited(known(contact)):
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
        if halved or et > 0.0:
            yield Note(of_half_mass(contact.kind) if halved else OF_ET, types, source)
    yield from (Note(text, types, functor) for text in of_rolling(contact))


#: What ``et`` is, in one line for all pairs.
OF_ET: Final = "et reverses the velocity of the surfaces: β = +et in a contact of duration tc without slip"


def of_half_mass(kind: str) -> str:
    """What ``et`` is at a body without mass."""
    return (
        f"at {kind}, YADE computes kn, cn, ks and cs with half the mass of the sphere: a contact lasts √2 tc, and"
        " neither is ε = en, nor β = et"
    )


def of_law(law: Instance) -> str:
    """What a law leaves out."""
    if law.name == SMOOTH_LAW:
        return "no tangential force at all: MindlinDeresiewitz adds up a displacement and computes no force from it"
    if law.name == LINEAR_LAW and not law.attributes.get("nonLin", 0):
        return "ks does not depend on the compression: YADE takes the number of 8 G* √R, in N/m^1.5, as N/m"
    return ""


def of_rolling(contact: Contact) -> Iterator[str]:
    """What resists rolling and twisting, as the angular impulse of one collision."""
    if contact.physics == "MindlinPhys":
        yield from of_bending(contact)
    elif contact.physics == "ViscElPhys":
        yield from of_drag(contact)
    elif contact.physics == "CohFrictPhys":
        yield from of_moments(contact)


def of_bending(contact: Contact) -> Iterator[str]:
    """``krot`` and ``ktwist`` of MindlinPhys."""
    attributes = contact.functor.attributes
    stiffness = {name: attributes[name] for name in ("krot", "ktwist") if attributes.get(name)}
    if not stiffness:
        return
    shown = " and ".join(
        f"{name} = {value:g}" if isinstance(value, int | float) else name for name, value in stiffness.items()
    )
    if not any(law.attributes.get("includeMoment") for law in contact.laws):
        yield f"{shown} without effect: the law lacks includeMoment=True"
        return
    eta = attributes.get("eta", 0.0)
    limit = "not limited"
    if isinstance(eta, int | float) and eta > 0.0:
        limit = f"that against rolling limited to {eta:g} R J_n"
    impulse = "an angular impulse of up to k ω t_c²/2 per collision"
    yield f"springs against rolling and twisting ({shown}): {impulse}, {limit}; {WITHOUT}"


def of_drag(contact: Contact) -> Iterator[str]:
    """``mR`` of ViscElPhys, which multiplies the relative spin, not its direction as it was meant."""
    try:
        resistance = contact.in_series("mR")
    except ValueError:
        yield "resistance against rolling (mR), whose number is not known"
        return
    if resistance > 0.0:
        factor = " |R₁ω₁ + R₂ω₂|" if contact.pair[0].attributes.get("mRtype", 1) == 2 else ""
        impulse = (
            f"an angular impulse of up to mR{factor} ω J_n per collision, with the relative spin ω itself"
        )
        yield f"resistance against rolling and twisting (mR = {resistance:g}): {impulse}; {WITHOUT}"


def of_moments(contact: Contact) -> Iterator[str]:
    """``alphaKr`` and ``alphaKtw`` of CohFrictPhys, which only bonds have by default."""
    if not all(each.attributes.get("momentRotationLaw", False) for each in contact.pair):
        return
    if not any(law.attributes.get("always_use_moment_law") for law in contact.laws):
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
