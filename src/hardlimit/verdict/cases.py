"""The contacts of a script, of a system or of numbers: which bodies meet, and by which force."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from itertools import permutations

import numpy as np

from .. import _core
from ..boxes.system import ParticleSystem
from ..contact.balls import Ball
from ..contact.contact import Law
from ..convert import texts
from ..convert.codes import Code, Model, Pair, Written, code
from ..convert.force import Force
from ..convert.formulas import DEFAULT_POISSON_RATIO, Numbers
from ..convert.wanted import LAWS
from ..scripts import ContactSettings, Description, Grains, Stage
from ..support.formatting import listed
from .contacts import Body, Case, KnownBody

WALL = "wall"
#: In place of the name of a wall: the second grain is one of those of its type that do not move.
FIXED = "fixed"


@dataclass(frozen=True)
class ModelForce:
    """The force of a model of a code, with the settings that it was read from."""

    model: Model
    numbers: Numbers
    attraction: bool
    contact: ContactSettings

    def written(self, first: KnownBody, second: KnownBody | None, speed: float) -> Written:
        """The model applied to two bodies."""
        other = KnownBody(math.inf, math.inf, self.contact.wall_mass) if second is None else second
        mass, radius = _core.effective(first.mass, other.mass), _core.effective(first.radius, other.radius)
        counted = None if other.formula_mass is None else _core.effective(first.mass, other.formula_mass)
        pair = Pair("", mass, radius * self.contact.wall_radius, second is None, formula_mass=counted)
        nu = self.numbers.get("poisson_ratio", DEFAULT_POISSON_RATIO)
        return Written(self.model, pair, speed, self.attraction, nu)

    def __call__(self, first: KnownBody, second: KnownBody | None, speed: float) -> Force:
        return self.written(first, second, speed).force(self.numbers)

    @property
    def spring(self) -> tuple[str, float, float] | None:
        """The number that sets the stiffness, its value, and the power with which it does."""
        power = 0.8 if self.model.spring.given == "impact" else 1.0
        return _spring(self.numbers, power)


def _spring(numbers: Mapping[str, float], power: float) -> tuple[str, float, float] | None:
    name = next((one for one in ("stiffness", "youngs_modulus", "elastic_prefactor") if one in numbers), None)
    return None if name is None else (name, numbers[name], power)


@dataclass(frozen=True)
class LawForce:
    """The force of one of our own laws."""

    law: Law

    def __call__(self, first: KnownBody, second: KnownBody | None, speed: float) -> Force:
        ball = Ball(first.radius, mass=first.mass)
        contact = self.law.between(
            *[ball] if second is None else [ball, Ball(second.radius, mass=second.mass)]
        )
        name, mass = self.law.record["name"], contact.effective_mass
        if name == "linear":
            return Force(LAWS[name], contact.stiffness, contact.damping, mass)
        k = contact.elastic_prefactor
        c = (
            contact.damping_coefficient * math.sqrt(mass * k)
            if name == "tsuji"
            else 1.5 * k * contact.dissipative_time
        )
        return Force(LAWS[name], k, c, mass)


# --- scripts ------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Remarks:
    """What the contacts of a script add to its lists."""

    versions: tuple[str, ...]  #: differences between versions of the code
    not_modelled: tuple[
        tuple[tuple[str, str], str], ...
    ]  #: types of contacts that no model describes, and why


def of_script(description: Description) -> tuple[list[Case], Remarks]:
    """Each contact of each stage at the smallest and the largest sizes, in the units of the script.

    A stage whose contacts and time step are those of the stage before is left out, as are pairs that do not move.
    """
    found = code(description.code)
    cases: list[Case] = []
    versions, failed = dict[str, dict[str, None]](), dict[tuple[tuple[str, str], str], None]()
    before: Stage | None = None
    for number, stage in enumerate(description.stages, 1):
        if before is not None and _state(stage) == _state(before):
            continue
        before = stage
        forces: list[tuple[ContactSettings, ModelForce | None]] = []
        for contact in stage.contacts:
            try:
                force, limit = _force(found, contact, description.version)
                if limit:
                    versions.setdefault(limit, {})[force.model.name] = None
                forces.append((contact, force))
            except ValueError as error:
                failed[contact.types, str(error).removeprefix("input: ")] = None
                forces.append((contact, None))
        materials = _materials(forces)
        for contact, known in forces:
            cases += _ends(number, stage, contact, known, materials)
    said = [
        f"{listed(list(names))} as in {found.title} since {limit}; before, another ε."
        for limit, names in versions.items()
    ]
    return cases, Remarks(tuple(said), tuple(failed))


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
            one.types,
            one.wall,
            one.wall_mass,
            one.wall_radius,
            {name: setting.words for name, setting in one.settings.items()},
        )
        for one in stage.contacts
    ]
    return contacts, stage.grains, stage.time_step, stage.numerical_damping


def _force(found: Code, contact: ContactSettings, version: str | None) -> tuple[ModelForce, str]:
    """The force of a contact, and the version before which it may be another one, empty if there is none."""
    wall = contact.types[1] == WALL
    read = texts.interpreted(found, found.models, contact.settings, wall)
    model, limit = _of_version(read.model, version)
    attracts = {"always": True, "never": False}.get(model.attracts, read.attracts)
    return ModelForce(model, read.numbers, attracts, contact), limit


def _of_version(model: Model, version: str | None) -> tuple[Model, str]:
    """The model as in this version of the code, by default the newest; then also the version that changed it."""
    other = model.difference
    if other is None:
        return model, ""
    changed = replace(model, damping=other.damping, attracts=other.attracts or model.attracts)
    limit = other.since or other.before
    known = None if version is None else _date(version)
    newer = known is None or known >= (_date(limit) or known)
    chosen = changed if newer == bool(other.since) else model
    return chosen, "" if version is not None else limit or ""


def _date(version: str) -> tuple[int, ...] | None:
    """A version as numbers that can be compared: ``2 Sep 2026`` or ``2023.02a``."""
    if day := re.search(r"\d{1,2} [A-Z][a-z]{2} \d{4}", version):
        try:
            moment = datetime.strptime(day[0], "%d %b %Y")
        except ValueError:
            return None
        return moment.year, moment.month, moment.day
    numbers = re.search(r"\d+(?:\.\d+)+", version)
    return tuple(map(int, numbers[0].split("."))) if numbers else None


def _ends(
    number: int,
    stage: Stage,
    contact: ContactSettings,
    force: ModelForce | None,
    materials: Mapping[str, tuple[float, float]],
) -> Iterator[Case]:
    """The contact at the smallest and at the largest sizes; one if they are equal. Then those with fixed grains."""
    grains = [stage.grains.get(name, Grains(name)) for name in contact.types if name != WALL]
    if all(one.frozen for one in grains):
        return
    if not (len(set(contact.types)) == 1 and grains[0].alone):
        yield from _between(number, stage, contact, force, materials, grains)
    for first, second in {
        (one.type, other.type): (one, other) for one, other in permutations(grains, 2)
    }.values():
        if second.partly_frozen and not first.frozen:
            pair = [first, second.fixed or replace(second, frozen=True)]
            yield from _between(number, stage, replace(contact, wall=FIXED), force, materials, pair)


def _between(
    number: int,
    stage: Stage,
    contact: ContactSettings,
    force: ModelForce | None,
    materials: Mapping[str, tuple[float, float]],
    grains: list[Grains],
) -> Iterator[Case]:
    """The contact of two grains, or of a grain and a wall, at the ends of their sizes."""
    grains.sort(key=lambda one: one.frozen)  # the first moves
    ends = [[body(one, k) for one in grains] for k in (0, 1)]
    for bodies in ends if ends[0] != ends[1] else ends[:1]:
        yield Case(
            contact.types,
            number,
            contact.wall,
            bodies[0],
            bodies[1] if len(bodies) > 1 else None,
            force,
            None if force is None else force.model.name,
            None if force is None else force.numbers.get("restitution", contact.asked),
            None if force is None else not force.attraction,
            stage.time_step,
            stage.numerical_damping,
            (materials.get(grains[0].type), materials.get(grains[-1].type)),
            None if force is None else force.spring,
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
    return Body(radius, math.inf if grains.frozen and not fixed else mass, density, fixed)


# --- systems and numbers --------------------------------------------------------------------------------------


def of_law(balls: Sequence[Ball], law: Law, walls: bool, time_step: float | None) -> list[Case]:
    """The contacts of the smallest and the largest ball under one of our laws, and with a wall."""
    bodies = [Body(ball.radius, ball.mass, ball.density) for ball in balls]
    force, p = LawForce(law), law.parameters
    material = (p["youngs_modulus"], p["poisson_ratio"]) if "youngs_modulus" in p else None

    def case(first: Body, second: Body | None) -> Case:
        types = (str(bodies.index(first) + 1), WALL if second is None else str(bodies.index(second) + 1))
        return Case(
            types,
            1,
            None,
            first,
            second,
            force,
            law.record["name"],
            law.parameters.get("restitution"),
            True,
            time_step,
            materials=(material, material),
            spring=_spring(law.parameters, 1.0),
        )

    pairs = [case(one, other) for i, one in enumerate(bodies) for other in bodies[i:]]
    return pairs + [case(one, None) for one in bodies] * walls


def sizes(system: ParticleSystem) -> list[Ball]:
    """The smallest and the largest particle of a system."""
    ends = dict.fromkeys(int(f(system.radius)) for f in (np.argmin, np.argmax))
    balls = [Ball(float(system.radius[k]), mass=float(system.mass[k])) for k in ends]
    return balls[:1] if len(set(balls)) == 1 else balls
