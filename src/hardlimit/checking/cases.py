"""The contacts of a script, of a system or of numbers: which bodies meet, and by which force."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import permutations
from typing import Any, Final, NamedTuple

import numpy as np

from .. import _core
from ..boxes.system import ParticleSystem
from ..contact.balls import Ball
from ..contact.contact import Contact, Law, law_parameters
from ..contact.friction import FrictionTerms
from ..contact.frictional_contact import tangential_restitution
from ..convert.codes import Code, Model, Pair, Written, code
from ..convert.force import AdhesiveForce, ContactArea, Force
from ..convert.formulas import DEFAULT_POISSON_RATIO, Numbers
from ..convert.tangential import NormalContact, Tangential, models_of
from ..convert.wanted import LAWS
from ..support.formatting import digits, listed, quantity
from ..support.units import SYSTEMS
from .contacts import Body, Case, CheckedContact, KnownBody
from .friction import OBLIQUE, FrictionLaw, MakeRestitution, MakeTerms, contact_of
from .models import selected
from .scripts import ContactSettings, Description, Grains, Quote, Stage
from .scripts.description import date

WALL = "wall"
#: In place of the name of a wall: the second grain is one of those of its type that do not move.
FIXED = "fixed"
#: Most differences in a remark, and the smallest relative one.
MOST, DIFFERENT = 4, 0.02


@dataclass(frozen=True)
class ModelForce:
    """The force of a model of a code, with the settings that it was read from."""

    model: Model
    numbers: Numbers
    attraction: bool
    contact: ContactSettings
    cohesion: tuple[Any, float] | None = None  #: LIGGGHTS' model and its energy density [J/m³]
    #: The force before versions of the code that changed it, if the version is not known.
    others: tuple[tuple[str, ModelForce], ...] = ()

    def written(self, first: KnownBody, second: KnownBody | None, speed: float) -> Written:
        """The model applied to two bodies."""
        other = KnownBody(math.inf, math.inf, self.contact.wall_mass) if second is None else second
        mass, radius = _core.effective(first.mass, other.mass), _core.effective(first.radius, other.radius)
        counted = None if other.formula_mass is None else _core.effective(first.mass, other.formula_mass)
        pair = Pair("", mass, radius * self.contact.wall_radius, second is None, formula_mass=counted)
        nu = self.numbers.get("poisson_ratio", DEFAULT_POISSON_RATIO)
        return Written(self.model, pair, speed, self.attraction, nu)

    def __call__(self, first: KnownBody, second: KnownBody | None, speed: float) -> Force:
        force = self.written(first, second, speed).force(self.numbers)
        if self.cohesion is None:
            return force
        kind, density = self.cohesion
        area = ContactArea(kind, first.radius, math.inf if second is None else second.radius)
        return AdhesiveForce(
            force.powers, force.stiffness, force.damping, force.effective_mass, density, area
        )

    @property
    def spring(self) -> tuple[str, float, float] | None:
        """The number that sets the stiffness, its value, and the power with which it does."""
        power = 0.8 if self.model.spring.given == "impact" else 1.0
        name = next((name for name in SPRINGS if name in self.numbers), None)
        return None if name is None else (name, self.numbers[name], power)


def friction_of(source: Code, contact: ContactSettings, force: ModelForce | None) -> FrictionLaw:
    """The friction of a contact, with its terms if the tangential model is understood."""
    law = FrictionLaw(contact.friction)
    if force is None or contact.friction == 0.0:
        return law
    others = [(when, _oblique(source, contact, force, model)) for when, model in contact.other_tangential]
    own = contact.tangential
    model = None if own is None else models_of(source.name).get(own.model)
    if own is not None and model is not None and model.restitution is not None:
        others.insert(0, ("in this version", _oblique(source, contact, force, own)))
        until_slip = _terms_of(source, contact, force, own)
        law = law._replace(model=own.model, not_known="only β at 45° is known")
        law, own = law._replace(sticking=None if isinstance(until_slip, str) else until_slip), None
    law = law._replace(others=tuple((when, beta) for when, beta in others if beta is not None))
    if own is None:
        return law
    terms = _terms_of(source, contact, force, own)
    if isinstance(terms, str):
        return law._replace(not_known=terms)
    return law._replace(model=own.model, terms=terms)


def _oblique(
    source: Code, contact: ContactSettings, force: ModelForce, tangential: Tangential
) -> MakeRestitution | None:
    """β at 45° under a tangential force; None if it is not known."""
    model, terms = models_of(source.name).get(tangential.model), _terms_of(source, contact, force, tangential)
    if model is None or isinstance(terms, str):
        return None

    def beta(first: KnownBody, second: KnownBody | None, speed: float) -> float:
        normal_force = force(first, second, speed)
        if not normal_force.collision(speed).restitution > 0.0:
            return math.nan
        own = contact_of(terms, normal_force, (first, second), speed)
        if model.restitution is None:
            return float(tangential_restitution(own, speed, OBLIQUE)[0])
        written = force.written(first, second, speed)
        normal = NormalContact(written, force.numbers, written.force(force.numbers))
        slip = math.tan(float(OBLIQUE[0])) * speed
        return model.restitution(tangential.numbers, normal, own.tangential_mass, speed, slip)

    return beta


def _terms_of(
    source: Code, contact: ContactSettings, force: ModelForce, tangential: Tangential
) -> MakeTerms | str:
    """The terms of a tangential force, or why they are not known."""
    model = models_of(source.name).get(tangential.model)
    if model is None:
        return f"tangential model {tangential.model} not understood"

    def terms(first: KnownBody, second: KnownBody | None, speed: float) -> FrictionTerms:
        written = force.written(first, second, speed)
        normal = NormalContact(written, force.numbers, written.force(force.numbers))
        return model.terms(tangential.numbers, normal)

    tried = Body(None, None).tried(0)
    try:
        terms(tried, None if contact.types[1] == WALL else tried, 1.0)
    except ValueError as error:
        return str(error)
    return terms


def energy_density(contact: ContactSettings, units: str = "si") -> tuple[Any, float] | None:
    """LIGGGHTS' model of cohesion and its energy density [J/m³]; None without one, or if that is not known."""
    mass, length, time = SYSTEMS[units]
    model, density = (contact.settings.get(name) for name in ("cohesion", "cohesionEnergyDensity"))
    if model is None or model.words[0] not in ("sjkr", "sjkr2") or density is None:
        return None
    return model.words[0], float(density.words[0]) * mass / (length * time**2)


#: The model with the stiffness of LIGGGHTS' models with adhesion: k₁ of the first compression, E of JKR.
REPULSION: Final = {"hooke/hysteresis": "hooke", "jkr": "hertz"}
#: The numbers of codes that set a stiffness.
SPRINGS: Final = ("stiffness", "youngs_modulus")
#: Unit of a stiffness or a modulus, with the power of length.
STIFFNESS_UNIT: Final = re.compile(r"Pa|N/m(?:\^([\d.]+))?")


def _spring_of(law: Law) -> tuple[str, tuple[float, float, float]] | None:
    """The parameter that sets the stiffness, and the powers of mass, length and time in its unit."""
    known = law_parameters(type(law))
    for name in law.parameters:
        if unit := STIFFNESS_UNIT.fullmatch(known[name]["unit"]):
            power = 2.0 if unit[0] == "Pa" else float(unit[1] or 1.0)
            return name, (1.0, 1.0 - power, -2.0)
    return None


@dataclass(frozen=True)
class LawForce:
    """The force of one of our own laws."""

    law: Law

    def __call__(self, first: KnownBody, second: KnownBody | None, speed: float) -> Force:
        contact = self._between(first, second)
        coefficients = contact.core.coefficients
        assert coefficients is not None  # check accepts no other law
        return Force(LAWS[self.law.record["name"]], *coefficients, contact.effective_mass)

    def _between(self, first: KnownBody, second: KnownBody | None) -> Contact:
        balls = [
            Ball(body.radius, mass=body.mass, inertia_factor=body.inertia_factor)
            for body in (first, second)
            if body is not None
        ]
        return self.law.between(*balls)

    def friction(self) -> FrictionLaw:
        """The friction of this law."""
        friction = self.law.friction
        if friction is None:
            return FrictionLaw()

        def terms(first: KnownBody, second: KnownBody | None, speed: float) -> FrictionTerms:
            known = self._between(first, second).friction_terms
            assert known is not None
            return known

        return FrictionLaw(friction.coefficient, friction.model, terms)


# --- scripts ------------------------------------------------------------------------------------------------


class NotModelled(NamedTuple):
    """A contact that no model describes."""

    types: tuple[str, str]
    why: str
    quote: Quote | None


@dataclass(frozen=True)
class Remarks:
    """What the contacts of a script add to its lists."""

    versions: tuple[str, ...]  #: what holds only since a version of the code
    not_modelled: tuple[NotModelled, ...]


def of_script(description: Description, kinds: Sequence[object]) -> tuple[list[Case], Remarks]:
    """Each contact of each stage at the smallest and the largest sizes, in the units of the script.

    A stage whose contacts, time step and kind of system (one of ``kinds`` for each stage) are those of the stage before
    is left out, as are pairs that do not move.
    """
    source = code(description.code)
    cases: list[Case] = []
    since, failed = dict[str, dict[str, None]](), dict[NotModelled, None]()
    before: object = None
    for number, (stage, kind) in enumerate(zip(description.stages, kinds, strict=True), 1):
        if (_state(stage), kind) == before:
            continue
        before = _state(stage), kind
        forces: list[tuple[ContactSettings, ModelForce | None]] = []
        for contact in stage.contacts:
            if contact.adhesion and energy_density(contact) is None:
                forces.append((contact, None))
                continue
            try:
                forces.append((contact, force_of(source, contact, description.version)))
                if contact.since and description.version is None:
                    since.setdefault(contact.since, {})["–".join(contact.types)] = None
            except ValueError as error:
                why = str(error).removeprefix("input: ")
                failed[NotModelled(contact.types, why, contact.quotes[0] if contact.quotes else None)] = None
                forces.append((contact, None))
        materials = _materials(forces)
        for contact, known in forces:
            friction = friction_of(source, contact, known)
            repulsion = _without_adhesion(source, contact, description.version) if contact.adhesion else None
            ends = _ends(number, stage, contact, known, friction, materials)
            cases += (replace(case, repulsion=repulsion) for case in ends)
    said = [
        f"{listed(list(names))}: mixed as {source.title} does since {limit}; before, their numbers do not determine ε."
        for limit, names in since.items()
    ]
    return cases, Remarks(tuple(said), tuple(failed))


def _without_adhesion(source: Code, contact: ContactSettings, version: str | None) -> ModelForce | None:
    """The force of a contact without its cohesion, or on its first compression; None if it is not known."""
    settings = {name: setting for name, setting in contact.settings.items() if name != "cohesion"}
    model = settings.get("model")
    if model is not None and (plain := REPULSION.get(model.words[0])):
        settings["model"] = replace(model, words=(plain, *model.words[1:]))
    try:
        return force_of(source, replace(contact, settings=settings, adhesion=""), version)
    except ValueError:
        return None


def of_other_versions(script: Description, rows: Sequence[CheckedContact]) -> Iterator[str]:
    """What contacts are in other versions of the code, for rows in SI units, or in ``lj`` units if their run is."""
    differences: dict[str, dict[str, dict[str, None]]] = {}
    for row in rows:
        plain = script.stages[row.stage - 1].units == "lj"
        for before, *values in row.other_versions:
            parts = differences.setdefault(before, {})
            for name, old, new in zip(("ε", "t_c"), values, (row.restitution, row.duration), strict=True):
                if old is not None and new is not None and not math.isclose(old, new, rel_tol=DIFFERENT):
                    shown = [
                        digits(x, 3) if plain or name == "ε" else quantity(x, "s", 3) for x in (old, new)
                    ]
                    pairs = parts.setdefault(f"{name} {shown[0]} instead of {shown[1]}", {})
                    pairs["–".join(row.types)] = None
    for before, parts in differences.items():
        texts = [f"{text} ({', '.join(pairs)})" for text, pairs in parts.items()]
        more = len(texts) - MOST
        if texts:
            rest = f"; and {more} more" if more > 0 else ""
            yield f"{code(script.code).title} before {before}: {'; '.join(texts[:MOST])}{rest}."


def _materials(
    forces: Sequence[tuple[ContactSettings, ModelForce | None]],
) -> dict[str, tuple[float, float]]:
    """Young's modulus and Poisson's ratio of each type; between two types, settings may have effective ones."""
    return {
        contact.types[0]: (force.numbers["youngs_modulus"], force.numbers.get("poisson_ratio", 0.0))
        for contact, force in forces
        if force is not None and len(set(contact.types)) == 1 and "youngs_modulus" in force.numbers
    }


def _state(stage: Stage) -> object:
    """What two stages must share for their contacts to be the same."""
    contacts = [
        (
            contact.types,
            contact.wall,
            contact.wall_mass,
            contact.wall_radius,
            contact.friction,
            (contact.tangential, contact.other_tangential),
            {name: setting.words for name, setting in contact.settings.items()},
        )
        for contact in stage.contacts
    ]
    return contacts, stage.grains, stage.time_step, stage.numerical_damping, stage.units, stage.dimension


def force_of(
    source: Code,
    contact: ContactSettings,
    version: str | None,
    models: Sequence[Model] = (),
    units: str = "si",
) -> ModelForce:
    """The force of a contact as in this version of the code, by default the newest.

    ``models``: those of the code by default. ``units``: of the script, to have the numbers in SI units.
    """
    read = selected(source, models or source.models, contact.settings, units)
    known = None if version is None else date(version)
    if contact.since and known is not None and known < (date(contact.since) or known):
        raise ValueError(f"not mixed before {contact.since}")

    def force(version: tuple[int, ...] | None) -> ModelForce:
        model = _as_of(read.model, version, contact.types[1] == WALL)
        attracts = {"always": True, "never": False}.get(model.attracts, read.attracts)
        return ModelForce(model, read.numbers, attracts, contact, energy_density(contact, units))

    examined = [
        difference for difference in read.model.difference if not difference.unknown and known is None
    ]
    limits = {difference.since or difference.before for difference in examined}
    older: list[tuple[str, ModelForce]] = []
    newest = later = force(known)
    for limit in sorted(limits, key=_just_before, reverse=True):
        before = force(_just_before(limit))
        if before.model != later.model:
            older.append((limit, before))
        later = before
    return replace(newest, others=tuple(older))


def _as_of(model: Model, version: tuple[int, ...] | None, wall: bool) -> Model:
    """The model in a version of the code, by default the newest."""
    for difference in model.difference:
        since = not difference.since or version is None or version >= (date(difference.since) or version)
        before = not difference.before or (
            version is not None and version < (date(difference.before) or version)
        )
        if since and before and (wall or not difference.walls):
            if difference.unknown:
                raise ValueError(
                    f"{model.name}: another force from {difference.since} to {difference.before}, which is not known"
                )
            damping, spring = difference.damping or model.damping, difference.spring or model.spring
            model = replace(
                model, damping=damping, spring=spring, attracts=difference.attracts or model.attracts
            )
    return model


def _just_before(limit: str) -> tuple[int, ...]:
    """A version older than this one, and not older than those before."""
    *first, last = date(limit) or (0,)
    return (*first, last - 1)


def _asked(force: ModelForce) -> float | None:
    """The ε that the script asks for: that of a corrected line, whose own number is another one, comes first."""
    restitution = force.numbers.get("restitution", force.contact.asked)
    wanted = {setting.wanted for setting in force.contact.settings.values()} - {None}
    return restitution if restitution is None or len(wanted) != 1 else wanted.pop()


def _ends(
    number: int,
    stage: Stage,
    contact: ContactSettings,
    force: ModelForce | None,
    friction: FrictionLaw,
    materials: Mapping[str, tuple[float, float]],
) -> Iterator[Case]:
    """The contact at the smallest and at the largest sizes; one if they are equal. Then those with fixed grains."""
    grains = [stage.grains.get(name, Grains(name)) for name in contact.types if name != WALL]
    if all(kind.frozen for kind in grains):
        return
    if len({kind.type for kind in grains}) == 1 and (both := grains[0].pair):
        groups = [[*both]] if len(grains) == 2 else [[each] for each in both]
        for group in groups:
            yield from _between(number, stage, contact, force, friction, materials, group)
        return
    if not (len(set(contact.types)) == 1 and grains[0].alone):
        yield from _between(number, stage, contact, force, friction, materials, grains)
    for first, second in {
        (first.type, other.type): (first, other) for first, other in permutations(grains, 2)
    }.values():
        if second.partly_frozen and not first.frozen:
            pair, fixed = [first, second.fixed or replace(second, frozen=True)], replace(contact, wall=FIXED)
            yield from _between(number, stage, fixed, force, friction, materials, pair)


def _between(
    number: int,
    stage: Stage,
    contact: ContactSettings,
    force: ModelForce | None,
    friction: FrictionLaw,
    materials: Mapping[str, tuple[float, float]],
    grains: list[Grains],
) -> Iterator[Case]:
    """The contact of two grains, or of a grain and a wall, at the ends of their sizes."""
    grains.sort(key=lambda kind: kind.frozen)  # the first moves
    ends = [[body(kind, k) for kind in grains] for k in (0, 1)]
    for bodies in ends if ends[0] != ends[1] else ends[:1]:
        yield Case(
            types=contact.types,
            stage=number,
            wall=contact.wall,
            first=bodies[0],
            second=bodies[1] if len(bodies) > 1 else None,
            force=force,
            model=None if force is None else force.model.name,
            restitution_asked=None if force is None else _asked(force),
            clipped=None if force is None else not force.attraction,
            time_step=stage.time_step,
            numerical_damping=stage.numerical_damping,
            materials=(materials.get(grains[0].type), materials.get(grains[-1].type)),
            spring=None if force is None else force.spring,
            others=() if force is None else force.others,
            friction=friction,
            spring_powers=None
            if force is None or force.spring is None
            else force.model.unit(force.spring[0]),
        )


def body(grains: Grains, end: int) -> Body:
    """The smallest (``end`` 0) or the largest grain."""
    radius, density, mass = (
        None if ends is None or not 0.0 < ends[end] < math.inf else ends[end]
        for ends in (grains.radii, grains.densities, grains.masses)
    )
    if radius is not None:
        volume = 4.0 / 3.0 * math.pi * radius**3
        if mass is None and density is not None:
            mass = volume * density or None
        elif density is None and mass is not None and volume > 0.0:
            density = mass / volume
    fixed = grains.frozen and grains.counted
    moved = math.inf if grains.frozen and not fixed else mass
    return Body(radius, moved, density, fixed, grains.inertia_factor)


# --- systems and numbers --------------------------------------------------------------------------------------


def of_law(balls: Sequence[Ball], law: Law, walls: bool, time_step: float | None) -> list[Case]:
    """The contacts of the smallest and the largest ball under one of our laws, and with a wall."""
    bodies = [
        Body(ball.radius, ball.mass, ball.density, inertia_factor=ball.inertia_factor) for ball in balls
    ]
    force, p, spring = LawForce(law), law.parameters, _spring_of(law)
    friction = force.friction()
    material = (p["youngs_modulus"], p["poisson_ratio"]) if "youngs_modulus" in p else None

    def case(first: Body, second: Body | None) -> Case:
        types = (str(bodies.index(first) + 1), WALL if second is None else str(bodies.index(second) + 1))
        return Case(
            types=types,
            stage=1,
            wall=None,
            first=first,
            second=second,
            force=force,
            model=law.record["name"],
            restitution_asked=law.parameters.get("restitution"),
            clipped=True,
            time_step=time_step,
            materials=(material, material),
            spring=spring and (spring[0], p[spring[0]], 1.0),
            friction=friction,
            spring_powers=spring and spring[1],
        )

    pairs = [case(body, other) for i, body in enumerate(bodies) for other in bodies[i:]]
    return pairs + [case(body, None) for body in bodies] * walls


def sizes(system: ParticleSystem) -> list[Ball]:
    """The smallest and the largest particle of a system, and those of the ends of q if it varies."""
    q = system._inertia_factor
    ends = [int(f(values)) for values in (system.radius, q) for f in (np.argmin, np.argmax) if np.ptp(values)]
    balls = [
        Ball(float(system.radius[k]), mass=float(system.mass[k]), inertia_factor=float(q[k]))
        for k in ends or [0]
    ]
    return list(dict.fromkeys(balls))
