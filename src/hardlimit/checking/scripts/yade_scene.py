"""The scene of a YADE script as it is now: materials, bodies and engines, and what is noted of them."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any, Final, NamedTuple

from ...convert.tangential.yade import FRICTION_ANGLE
from .description import Direction, Grains, Lot, Note, Quote, Range
from .population import union
from .python import Instance, Unknown, flat
from .reader import Reader
from .statements import quoted, refusal
from .yade_container import Ends
from .yade_filling import YadeFilling

#: Materials that are read, with the defaults of their numbers.
MATERIALS: Final[dict[str, dict[str, float]]] = {
    name: {"young": 1e9, "poisson": 0.25, "density": 1000.0, "frictionAngle": FRICTION_ANGLE}
    for name in ("FrictMat", "ViscElMat", "CohFrictMat")
}
MATERIALS["CohFrictMat"]["normalCohesion"] = -1.0
MATERIALS["ViscElMat"]["mR"] = 0.0
OF_VISCOELASTIC: Final = "Ip2_ViscElMat_ViscElMat_ViscElPhys"
#: Spheres of unknown number.
UNCOUNTED: Final = Lot(0)


@dataclass
class Body:
    """Spheres of one call, or a wall."""

    kind: str  #: "sphere", or what the wall is made of
    radii: Range | None
    material: int
    frozen: bool
    quote: Quote
    mass: float | None = None  #: of a box; None for other bodies, and if it is not known
    several: bool = False  #: whether there may be more than one
    filled: bool = False  #: whether they fill the space between their ends
    unsure: bool = False  #: whether some of them may not move
    locked: Quote | None = None  #: what keeps it from turning as a free or a fixed sphere does
    planar: bool = False  #: whether it moves in a plane only
    weighed: bool = False  #: whether its mass is set, and is not that of its material
    lot: Lot = UNCOUNTED  #: of spheres: how many, and the sums of their radii
    ends: Ends | None = None  #: of spheres: between which they are made


class Push(NamedTuple):
    """The velocity of a wall, or of an unknown body, that a script sets. None: not known."""

    velocity: Direction | None
    place: Ends | None
    quote: Quote
    is_wall: bool  #: whether it is known to be no sphere


class Saved(NamedTuple):
    """What ``O.save`` keeps of a scene."""

    materials: list[Instance]
    bodies: list[Body]
    engines: list[Any]
    elsewhere: bool
    time_step: float | None
    time_step_given: bool
    filling: YadeFilling


@dataclass
class Scene(Reader):
    """Materials, bodies and engines, with notes and the stages so far."""

    code, version = "yade", None

    file: str
    part: bool  #: whether the script is a part: at its end, and also at a ``wall`` that it lacks
    revives: bool  #: whether the script revives dead engines
    instances: list[Instance]  #: all that the script makes
    materials: list[Instance] = field(default_factory=list)
    bodies: list[Body] = field(default_factory=list)
    elsewhere: bool = False  #: whether there are bodies that are not known
    numbered: int = 0  #: bodies from the first on whose numbers are known
    counted: float = math.inf  #: at most so many are, since a clump has a number as well
    filling: YadeFilling = field(default_factory=YadeFilling)
    engines: list[Any] = field(default_factory=list)
    engines_quote: Quote | None = None
    engines_given: bool = False
    time_step: float | None = None
    time_step_given: bool = False
    strain: tuple[Any, Quote] | None = None  #: of the periodic cell, as velGrad
    pushed: Push | None = None  #: the last one
    some_fixed: bool = False  #: whether some spheres do not move of which it is not known which ones they are
    locked: Quote | None = None  #: what locks bodies of which it is not known which ones they are
    planar: bool = False  #: whether bodies move in a plane only of which it is not known which ones they are
    weighed: bool = False  #: whether masses are set of such bodies
    growing: bool = False  #: whether a controller has made the spheres larger
    system: int = 0  #: number of the scene
    changed: bool = True  #: whether anything may have changed since the last run
    saved: Saved | None = None

    def __post_init__(self) -> None:
        self.begin()

    # --- notes --------------------------------------------------------------------------------------------------

    def quote(self, line: int, text: str) -> Quote:
        return quoted(self.file, line, text)

    def at(self, source: Instance) -> Quote:
        """The statement that makes something."""
        return self.quote(source.line, source.text)

    def ignore(self, what: str, quote: Quote | None) -> None:
        """Note what leaves head-on collisions as they are."""
        self.ignored[Note(what, None, quote)] = None

    def invalidate(self, what: str, quote: Quote) -> None:
        """Note what makes hard spheres wrong."""
        self.invalidates[Note(what, None, quote)] = None

    def refuse(self, quote: Quote, must: str) -> None:
        """Note a statement on which the force of contacts depends."""
        self.refused[str(refusal(quote.line, quote.text, must, self.file))] = None

    # --- changes ------------------------------------------------------------------------------------------------

    def reset(self) -> None:
        """Begin another scene, without engines."""
        self.system += 1
        self.materials.clear()
        self.bodies, self.numbered, self.counted, self.filling = [], 0, math.inf, YadeFilling()
        self.engines, self.engines_given, self.engines_quote = [], True, None
        self.elsewhere, self.time_step, self.time_step_given = False, None, False
        self.planar, self.weighed, self.growing = False, False, False
        self.pushed, self.some_fixed = None, False

    def save(self) -> None:
        parts = list(self.materials), list(self.bodies), self.engines, self.elsewhere
        self.saved = Saved(*parts, self.time_step, self.time_step_given, copy.deepcopy(self.filling))

    def load(self) -> bool:
        """The scene that was saved last; False if there is none."""
        if self.saved is None:
            return False
        saved = self.saved
        self.materials[:], self.bodies[:], self.engines = saved.materials, saved.bodies, saved.engines
        self.elsewhere, self.numbered = saved.elsewhere, 0
        self.time_step, self.time_step_given = saved.time_step, saved.time_step_given
        self.filling = copy.deepcopy(saved.filling)
        return True

    def remove_bodies(self) -> None:
        """All bodies; the cell stays."""
        self.bodies, self.numbered, self.counted, self.elsewhere = [], 0, math.inf, False
        self.filling = YadeFilling(cell=self.filling.cell, periodic=self.filling.periodic)

    def index(self, material: Instance) -> int:
        """The number of a material, which is added to ``O.materials`` if it is new."""
        for k, known in enumerate(self.materials):
            if known is material:
                return k
        self.materials.append(material)
        return len(self.materials) - 1

    def body_at(self, k: Any) -> Instance | None:
        """A body by its number; None if it is not known which one that is."""
        if not isinstance(k, int) or not -len(self.bodies) <= k < len(self.bodies) or self.elsewhere:
            return None
        most = min(len(self.bodies), self.counted)
        while self.numbered < most and not self.bodies[self.numbered].several:
            self.numbered += 1
        k %= len(self.bodies)
        if k >= self.numbered:
            return None
        body = self.bodies[k]
        return Instance("Body", (), {}, body.quote.line, body.quote.text, [body])

    # --- engines ------------------------------------------------------------------------------------------------

    @property
    def bare(self) -> bool:
        """Whether the script has no bodies, and no functors in ``O.engines`` that make contacts."""
        functors = self.engines_given and any(inside(self.engines, "Ip2_"))
        return not (functors or self.bodies or self.elsewhere)

    @property
    def apart(self) -> bool:
        """Whether a script makes engines and does not enter them in ``O.engines``, as a part of a script may."""
        parts = ("Ip2_", "Law2_", "NewtonIntegrator", *["ViscElMat"] * self.bare)
        entered = self.engines_given and not self.bare
        return not entered and any(instance.name.startswith(parts) for instance in self.instances)

    def used(self, start: str) -> list[Instance]:
        """Instances whose name begins so: those of ``O.engines``, or all of a script that makes them beside it.

        Without engines that are dead, if the script never revives one.
        """
        instances = inside(self.instances if self.apart else self.engines, start)
        return [each for each in instances if self.revives or not each.attributes.get("dead", False)]

    # --- grains -------------------------------------------------------------------------------------------------

    def number(self, instance: Instance, name: str) -> float:
        """A number of a material, or its default."""
        default = MATERIALS.get(instance.name, {"density": 1000.0}).get(name)
        value = instance.attributes.get(name, instance.attributes.get("**", default))
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            said = value.text if isinstance(value, Unknown) else value
            raise refusal(
                instance.line, instance.text, f"have a known number for {name}, not {said}", self.file
            )
        return float(value)

    def name(self, k: int) -> str:
        """The name of a material: its label, or its number."""
        label = self.materials[k].attributes.get("label")
        return label if isinstance(label, str) and label else str(k)

    def spheres(self) -> list[Body]:
        """Spheres of the script, and those that factories will make."""
        spheres = [body for body in self.bodies if body.kind == "sphere"]
        for factory in (*self.used("BoxFactory"), *self.used("CircularFactory")):
            attributes = factory.attributes
            radii = union([as_range(attributes.get(name)) for name in ("rMin", "rMax")])
            number, quote = attributes.get("materialId", -1), self.at(factory)
            if isinstance(number, int) and -len(self.materials) <= number < len(self.materials):
                diameters = attributes.get("PSDsizes")
                if isinstance(diameters, list | tuple):
                    ends = union([as_range(diameter) for diameter in diameters])
                    sizes = None if ends is None else (0.5 * ends[0], 0.5 * ends[1])
                else:
                    sizes = radii if diameters is None else None
                material = number % len(self.materials)
                spheres.append(Body("sphere", sizes, material, False, quote, several=True))
            else:
                self.unknown[quote] = None
        return spheres

    def kinds(self) -> list[int]:
        """Materials of spheres, or all if the script makes none."""
        kinds = sorted({sphere.material for sphere in self.spheres()})
        return list(range(len(self.materials))) if self.elsewhere or not kinds else kinds

    def grains(self) -> dict[str, Grains]:
        """The grains of each material: those that move, if some do."""
        grains, several = {}, self.elsewhere or len(self.bodies) > 1
        for k in self.kinds():
            spheres = [sphere for sphere in self.spheres() if sphere.material == k]
            fixed = [sphere for sphere in spheres if sphere.frozen]
            moving = [sphere for sphere in spheres if not sphere.frozen]
            frozen = bool(fixed) and not self.elsewhere and not moving
            kind = self.grains_of(k, fixed if frozen else moving, frozen)
            if moving and (self.some_fixed or any(sphere.unsure for sphere in moving)):
                kind = replace(kind, partly_frozen=True)
            if fixed and not frozen:
                kind = replace(kind, partly_frozen=True, fixed=self.grains_of(k, fixed, True))
            lone = len(moving) == 1 and not moving[0].several and several and not self.elsewhere
            grains[kind.type] = replace(kind, alone=lone)
        return grains

    def grains_of(self, k: int, spheres: list[Body], frozen: bool) -> Grains:
        """Spheres of one material."""
        radii = None if self.elsewhere and not frozen else union([sphere.radii for sphere in spheres])
        density = self.number(self.materials[k], "density") if spheres or self.elsewhere else None
        # ViscElPhys takes the mass of a fixed sphere; MindlinPhys does not.
        counted = self.materials[k].name == "ViscElMat" and any(
            functor.name == OF_VISCOELASTIC for functor in self.used("Ip2_")
        )
        weighed = self.weighed or any(sphere.weighed for sphere in spheres)
        densities = None if density is None or weighed else (density, density)
        radii = None if self.growing and not frozen else radii
        return Grains(self.name(k), radii, densities, None, frozen, counted)


def inside(instances: Iterable[Any], start: str) -> Iterator[Instance]:
    """These instances and those in their arguments whose name begins so, each once."""
    pending, seen = list(reversed([*instances])), set[int]()
    while pending:
        instance = pending.pop()
        if isinstance(instance, Instance) and id(instance) not in seen:
            seen.add(id(instance))
            if instance.name.startswith(start):
                yield instance
            pending += reversed(flat([*instance.arguments, *instance.attributes.values()]))


def is_active(engine: Instance) -> bool:
    """Whether an engine is neither dead nor inactive."""
    return not engine.attributes.get("dead", False) and bool(engine.attributes.get("active", True))


def as_range(value: Any) -> Range | None:
    """One known positive number as a range."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < math.inf:
        return None
    return float(value), float(value)
