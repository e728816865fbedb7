"""What a script says about grains and contacts, in the script's own units."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from datetime import datetime
from typing import NamedTuple

from ...boxes.box import UNIT_BALL
from ...convert.tangential import Tangential

#: Most grains that are judged as single contacts; more of them make a bed.
FEW = 2
#: Packing fraction that no bed exceeds: that of the densest equal spheres, rounded up.
DENSEST = 0.75
#: Second type of a contact with a wall.
WALL = "wall"
#: The comment at the end of a corrected line: the ε for which it has its number.
WANTED = re.compile(r"# for a restitution of (0?\.\d+|[01](?:\.\d*)?)\s*$")

Range = tuple[float, float]  #: smallest and largest value
Direction = tuple[float, ...]  #: a unit vector


@dataclass(frozen=True)
class Setting:
    """A setting and its place in the script."""

    words: tuple[str, ...]
    line: int
    text: str

    @property
    def wanted(self) -> float | None:
        """The ε for which a corrected line has its number; None without the comment that says so."""
        comment = WANTED.search(self.text)
        return None if comment is None else float(comment[1])


Settings = dict[str, Setting]


@dataclass(frozen=True)
class Quote:
    """A statement as messages quote it."""

    file: str  #: path as the script names it; empty for text that is not a file
    line: int  #: counted from 1
    text: str  #: one line
    part: str = ""  #: words of it that were not understood; empty for all


@dataclass(frozen=True)
class Grains:
    """The grains of one type. A range is None if the script does not state it.

    At most one of ``densities`` and ``masses`` is given: in LAMMPS, another diameter leaves the mass as it is.
    """

    type: str
    radii: Range | None = None
    densities: Range | None = None
    masses: Range | None = None
    frozen: bool = False  #: whether none of them moves
    counted: bool = False  #: whether the code's formulas use their mass although none of them moves
    partly_frozen: bool = False  #: whether some of them, but not all, do not move
    fixed: Grains | None = None  #: those, if their sizes are not those of the others
    alone: bool = False  #: whether only one of them moves, which then touches none like itself
    pair: tuple[Grains, Grains] | None = None  #: both, if there are only two, which are not alike
    inertia_factor: float = 0.4  #: q of the moment of inertia q m R²; infinite if the grains do not spin


@dataclass(frozen=True)
class Speed:
    """A speed of impacts that a script states."""

    value: float
    source: str  #: where it comes from, in words; ``{height}`` stands for the height
    height: float | None = None  #: of a fall
    decides: bool = False  #: whether it is that of a gas, and no estimate


class Lot(NamedTuple):
    """Grains of one type: how many, and the sums of the squares and cubes of their radii. None: not known."""

    kind: int
    number: float | None = None
    squares: float | None = None
    cubes: float | None = None

    def times(self, share: float) -> Lot:
        """A share of these grains, drawn at random."""
        parts = [None if value is None else share * value for value in self[1:]]
        return Lot(self.kind, *parts)

    def of_radius(self, radius: float | None) -> Lot:
        """The same number of grains of another radius."""
        if radius is None or self.number is None:
            return self._replace(squares=None, cubes=None)
        return self._replace(
            squares=self.number * radius * radius, cubes=self.number * radius * radius * radius
        )


@dataclass(frozen=True)
class Contents:
    """What a script says of the grains in its box. None: it does not."""

    count: float | None = None  #: number of grains that move
    filled: float | None = None  #: their volume, in two dimensions their area
    volume: float | None = None  #: of the box
    speeds: tuple[Speed, ...] = ()
    floor: float | None = None  #: area on which they lie, in two dimensions its width
    walled: bool = False  #: whether side walls or grains that do not move may carry a part of the weight
    height: float | None = None  #: that no bed of these grains exceeds
    height_from: str = ""  #: where this comes from, in words
    packed: float = 0.0  #: packing fraction of the grains when they are made, if it may exceed that of a bed
    without: str = ""  #: what else may press them, in words
    layer: float | None = None  #: thickness of the vertical layer in which they are made; None without one
    lots: tuple[Lot, ...] = ()  #: the grains of each command; empty if not all are known
    stream: float | None = None  #: largest packing fraction of a stream into open space
    never_meet: bool = False  #: whether no grain meets another or a wall
    pours: bool = False  #: whether all that is below the grains is open, as a funnel is
    concentration: float = 1.0  #: force on a sphere of a clump over that on a sphere like it, at most
    other_clumps: bool = False  #: whether there are clumps of which this is not known
    poured: bool = False  #: whether all grains fall from where they are inserted, few at a time
    most: float | None = None  #: number of grains at most, if they are inserted again and again ...
    most_filled: float | None = None  #: ... and their volume, in two dimensions their area

    def diameter(self, dimension: int = 3) -> float | None:
        """Of a grain of the mean size; None if it is not known."""
        if not (self.count and self.filled):
            return None
        diameter: float = 2.0 * (self.filled / self.count / UNIT_BALL[dimension]) ** (1.0 / dimension)
        return diameter

    @property
    def at_most(self) -> Contents:
        """With the largest number of grains if it is not known, so that their weight is a bound."""
        if self.filled is not None or self.most_filled is None:
            return self
        return replace(self, count=self.most, filled=self.most_filled, walled=True)


NOTHING = Contents()


@dataclass(frozen=True)
class Motion:
    """How a wall, or grains that follow no force, move. None stands for what is not known."""

    amplitude: Direction | None = None  #: of an oscillation along each axis
    frequency: float | None = None  #: angular, of this oscillation
    velocity: float | None = None  #: of a steady motion
    course: Direction | None = None  #: its components
    turning: Direction | None = None  #: angular velocity of a steady rotation
    radius: float | None = None  #: of a cylinder that turns about its axis


@dataclass(frozen=True)
class ContactSettings:
    """The settings of the normal force between two types, or between a type and a wall."""

    types: tuple[str, str]  #: the second is :data:`WALL` at a wall
    wall: str | None  #: name of the wall; None between grains
    settings: Settings  #: by name, as in ``reads`` of the files in ``hardlimit/convert/codes``
    quotes: tuple[Quote, ...]  #: the statements that these settings come from
    wall_mass: float | None = None  #: of a fixed wall if the code's formulas use it, as for YADE's boxes
    wall_radius: float = 1.0  #: effective radius in the code's formulas over that at other walls
    asked: float | None = None  #: restitution in the script if the force leaves it out
    pushes: tuple[Direction, ...] | None = None  #: of a wall on grains; None if not known
    since: str = ""  #: first version of the code in which they mean this, if not all do
    adhesion: str = ""  #: what makes its force adhesive or plastic, in words
    friction: float | None = (
        0.0  #: coefficient of sliding friction, 0 without tangential forces; None if not known
    )
    tangential: Tangential | None = None  #: the tangential force; None without one, or if it is not known
    #: The tangential force in versions of the code that have another one, with these versions in words.
    other_tangential: tuple[tuple[str, Tangential], ...] = ()
    differs: str = ""  #: how it differs in these versions, in words
    motion: Motion | None = None  #: of the wall, or of the grains that do not follow forces; None at rest
    sheds: bool = False  #: whether it is a wall off which grains slide wherever they land


@dataclass(frozen=True)
class Note:
    """Something that is in the script beside the normal contacts."""

    what: str
    types: tuple[str, ...] | None = None  #: the types that it concerns; None for all
    quote: Quote | None = None


class Bath(NamedTuple):
    """A thermostat that restores a temperature: dT/dt = rate (T_bath − T)."""

    temperature: float  #: as an energy k_B T
    rate: float
    spin_temperature: float = 0.0  #: of the spins
    spin_rate: float = 0.0  #: 0 if it leaves spins alone


@dataclass(frozen=True)
class Stage:
    """What holds during one run."""

    quote: Quote  #: the command that runs
    time_step: float | None
    time_step_given: bool  #: False for the code's default
    steps: int | None
    contacts: tuple[ContactSettings, ...]
    grains: dict[str, Grains]  #: by type
    gravity: float | None  #: magnitude; None without gravity
    numerical_damping: float | None  #: of the integrator; None in codes without it
    down: Direction | None = None  #: the direction of gravity; None if not known
    pressed: tuple[Note, ...] = ()  #: what prescribes a pressure or shrinks the box
    pressure: float | None = None  #: that is prescribed: the mean over the axes
    uniaxial: bool = False  #: whether it is prescribed along one axis alone
    strained: bool = False  #: whether the grains are compressed along another axis at a given rate
    pressure_changes: bool = False  #: whether a callback of the run changes it
    edges: tuple[float | None, ...] = (None, None, None)  #: of the box
    driven: tuple[Note, ...] = ()  #: what else moves the box or its walls, or heats the grains
    shear_rate: float | None = None  #: of a box in steady shear
    bath: Bath | None = None  #: the thermostat of the grains
    units: str = "si"
    units_given: bool = True  #: False for the code's default
    dimension: int = 3
    system: int = 0  #: number of the system that runs; ``clear`` begins another one
    contents: Contents = NOTHING


@dataclass(frozen=True)
class Description:
    """What a script says: the state of its settings at each run, and what else affects its grains."""

    code: str
    version: str | None  #: as it is given, or as a log states it
    stages: tuple[Stage, ...]
    ignored: tuple[Note, ...] = field(default=())  #: leaves head-on collisions as they are
    invalidates: tuple[Note, ...] = ()  #: makes contacts sticky, dissipates elsewhere, ties grains
    warnings: tuple[Note, ...] = field(default=())  #: what the friction of the script really does
    unknown: tuple[Quote, ...] = field(default=())  #: statements that were not understood
    #: Messages that refuse those of them, and of what invalidates, on which the force of contacts depends.
    refused: tuple[str, ...] = field(default=())


def date(version: str) -> tuple[int, ...] | None:
    """A version as numbers that can be compared: ``2 Sep 2026`` or ``2023.02a``."""
    if day := re.search(r"\d{1,2} [A-Z][a-z]{2} \d{4}", version):
        try:
            moment = datetime.strptime(day[0], "%d %b %Y")
        except ValueError:
            return None
        return moment.year, moment.month, moment.day
    numbers = re.search(r"\d+(?:\.\d+)+", version)
    return tuple(map(int, numbers[0].split("."))) if numbers else None
