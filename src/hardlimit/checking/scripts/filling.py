"""What a script of LAMMPS or LIGGGHTS fills its box with, and the speeds of impacts that it states.

Formats: docs.lammps.org, pages create_box, boundary, region, velocity, fix_pour and replicate; LIGGGHTS' fix_insert.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from ...support.formatting import digits
from . import census, free_fall, streams
from .census import Census, Lattice
from .description import Contents, Direction, Lot, Range, Speed, Stage
from .motion import AXES, BOLTZMANN

if TYPE_CHECKING:
    from .population import Batch
    from .state import Fix, State
    from .statements import Statement

#: The style of a region and its numbers in absolute units.
Region = tuple[object, ...]
PLANES: Final = ("xplane", "yplane", "zplane")
AT_MOST: Final = "at most"  #: in the words of a speed that is a bound
#: Number of words of a region before its options.
REGION_WORDS: Final = {"block": 6, "prism": 9, "sphere": 4, "cylinder": 6, "plane": 6}
#: Cosine of the angle up to which gravity counts as along an axis.
ALONG: Final = 1.0 - 1e-6
#: Largest component of the direction of gravity along an axis that counts as level.
LEVEL: Final = 1e-9


class Insertion(NamedTuple):
    """Where grains are made, and with which velocity. None: not known."""

    region: Region | None  #: empty for the whole box
    velocity: tuple[float, ...] = (0.0, 0.0, 0.0)
    poured: bool = True  #: whether a fix inserts them, and no ``create_atoms``
    stream: streams.Stream | None = None  #: of ``fix insert/stream``
    lasting: bool = False  #: whether it inserts few grains at a time


@dataclass
class Repeated:
    """Grains that a fix inserts again and again."""

    statement: Statement
    lot: int  #: place among those of the census
    each: Lot  #: of one insertion, at most
    every: int  #: steps
    steps: int = 0  #: of all runs with this fix


@dataclass
class Filling:
    """The box, the grains that are made in it, and their velocities."""

    census: Census = field(default_factory=Census)
    box: dict[int, Range] = field(default_factory=dict)  #: by axis
    boundary: tuple[str, ...] = ("p", "p", "p")
    lattice: Lattice = field(default_factory=Lattice)
    regions: dict[str, Region | None] = field(default_factory=dict)
    insertions: list[Insertion] = field(default_factory=list)
    launches: list[free_fall.Launch] = field(default_factory=list)  #: of all grains
    heat: list[Speed] = field(default_factory=list)  #: of velocities drawn at random
    drifts: dict[str, tuple[float | None, ...]] = field(default_factory=dict)  #: velocities of groups
    velocities_known: bool = True  #: whether none of them is unknown
    repeated: list[Repeated] = field(default_factory=list)
    #: Least distance of grains placed at random since the last run; infinite without them.
    apart: float = math.inf

    def forget(self) -> None:
        """What is in the box depends on what only a run knows, or on a file that is not read."""
        self.census.complete = self.velocities_known = False

    def copied(self) -> Filling:
        """A copy that changes on its own."""
        return copy.deepcopy(self)

    @property
    def ends(self) -> list[Range]:
        """The ends of the box; those that are not known are infinite."""
        return [self.box.get(k, (-math.inf, math.inf)) for k in range(3)]

    def periodic(self, axis: int) -> bool:
        """Whether a box has no ends along an axis."""
        return self.boundary[axis].startswith("p")


# --- box, lattice and regions -----------------------------------------------------------------------------------


def read_lattice(state: State, statement: Statement) -> None:
    """``lattice STYLE SCALE …``; one with more words than an origin is not understood."""
    style, size, *rest = (*statement.words[1:], "", "")
    scale = state.coefficient(size)
    cell = census.lattice(style, scale or 0.0, state.dimension, state.units == "lj")
    rest = [word for word in rest if word]
    if (
        rest[:1] == ["origin"]
        and len(rest) == 4
        and None not in (origin := [*map(state.coefficient, rest[1:])])
    ):
        cell = Lattice(cell.sites, cell.edges, tuple(x or 0.0 for x in origin))
    elif rest:
        cell = Lattice(None, None)
    state.filling.lattice = cell


def read_region(state: State, statement: Statement) -> None:
    """The numbers of a region in absolute units, when it is defined."""
    name, *words = statement.words[1:]
    state.filling.regions[name] = numbers_of(state, words)


def numbers_of(state: State, words: Sequence[str]) -> Region | None:
    """The numbers of the words of a region; None if they are not known, or if it is the space outside."""
    count = REGION_WORDS.get(words[0], 0)
    options = words[1 + count :]
    cell = state.filling.lattice.edges if "box" not in options else census.SQUARE
    if not count or len(words) <= count or "out" in options or cell is None:
        return None
    axis = words[1] if words[0] == "cylinder" else ""
    numbers: list[object] = [axis] if axis else []
    for k, word in enumerate(words[1 + len(numbers) : 1 + count]):
        unit = cell[axis_of(words[0], axis, k)]
        low = k % 2 == 0 if words[0] != "cylinder" else k == 3
        if word in ("INF", "EDGE"):
            numbers.append(-math.inf if low else math.inf)
        elif (value := state.coefficient(word)) is not None:
            numbers.append(unit * value)
        else:
            return None
    return words[0], *numbers


def axis_of(style: str, axis: str, k: int) -> int:
    """The axis whose unit the number ``k`` of a region has."""
    if style in ("block", "prism"):
        return k // 2 if k < 6 else 0
    if style in ("sphere", "plane"):
        return k % 3
    along = "xyz".find(axis)
    across = [other for other in range(3) if other != along]
    return across[k] if k < 2 else across[0] if k == 2 else max(along, 0)


def read_box(state: State, region: str) -> None:
    """The ends of the box from its region."""
    style, *numbers = state.filling.regions.get(region) or ("",)
    if style in ("block", "prism"):
        known = [number for number in numbers if isinstance(number, float)]
        pairs = zip(known[:6:2], known[1:6:2], strict=True)
        state.filling.box = {k: pair for k, pair in enumerate(pairs) if pair[0] < pair[1]}


def read_header(state: State, text: str) -> None:
    """The ends of the box from the header of a data file."""
    for line in text.splitlines()[1:60]:
        words = line.partition("#")[0].split()
        for k, axis in enumerate(AXES):
            if words[2:] == [f"{axis}lo", f"{axis}hi"]:
                low, high = state.coefficient(words[0]), state.coefficient(words[1])
                if low is not None and high is not None and low < high:
                    state.filling.box[k] = (low, high)


def read_data(state: State, text: str, grains: Sequence[tuple[int, Batch]], shift: int) -> None:
    """The box, the grains and the velocities of a data file; ``shift``: of its types."""
    filling, sums = state.filling, dict[int, list[float]]()
    filling.launches.append(free_fall.UNKNOWN)
    read_header(state, text)
    for kind, batch in grains:
        radius = batch.radii[0] if batch.radii else math.nan
        own = sums.setdefault(kind + shift, [0.0, 0.0, 0.0])
        for power, by in enumerate((0, 2, 3)):
            own[power] += radius**by
    for kind, totals in sums.items():
        filling.census.add(Lot(kind, *totals))
    lines = text.splitlines()
    starts = [k for k, line in enumerate(lines) if line.partition("#")[0].split() == ["Velocities"]]
    if not starts or len(grains) < 2:
        return
    rows = [line.split() for line in lines[starts[0] + 1 : starts[0] + 2 + len(grains)] if line.strip()]
    try:
        velocities = np.array([row[1 : 1 + state.dimension] for row in rows], float)
    except ValueError:
        velocities = np.empty((0, state.dimension))
    if (
        len(velocities) != len(grains)
        or not np.isfinite(velocities).all()
        or len({batch for _, batch in grains}) > 1
    ):
        filling.velocities_known = False
    elif (heat := float(velocities.var(axis=0).mean())) > 0.0:
        source = "the velocities in the data file"
        filling.heat.append(Speed(math.sqrt(math.pi * heat), source, decides=True))


def replicate(state: State, words: Sequence[str]) -> None:
    """``replicate NX NY NZ``: copies of the box and of its grains."""
    filling = state.filling
    filling.launches.append(free_fall.UNKNOWN)
    if len(words) != 3 or not all(word.isdecimal() and 0 < len(word) < 5 for word in words):
        filling.box, filling.census.complete = {}, False
        return
    times = [int(word) for word in words]
    filling.census.repeat(math.prod(times))
    filling.box = {k: (low, low + times[k] * (high - low)) for k, (low, high) in filling.box.items()}


# --- grains -----------------------------------------------------------------------------------------------------


def create_atoms(state: State, kind: int, words: Sequence[str]) -> None:
    """Grains of ``create_atoms``, from the words after the type on: 0.5 in radius."""
    style, filling = (*words, "")[0], state.filling
    region: Region | None = ()
    number = 2 if style == "random" else 0
    if style in ("region", "random"):
        name = (*words[1 + number :], "")[0]
        region = () if name == "NULL" else filling.regions.get(name)
    count: float | None = None
    some = {"mol", "var", "ratio", "subset", "basis"} & set(words)
    if style == "random" and not some:
        count = state.coefficient((*words, "", "")[1])
    elif style == "single":
        count = 1.0
    elif style in ("box", "region") and region is not None and not some:
        periodic = [filling.periodic(k) for k in range(3)]
        ends = filling.ends
        count = (
            None
            if math.inf in {x for end in ends for x in end}
            else census.sites_in(filling.lattice, region, ends, periodic, state.dimension)
        )
    filling.census.add(census.lot(kind, count, census.moments((0.5, 0.5))))
    if style == "random":
        distance = words[words.index("overlap") + 1] if "overlap" in words[:-1] else "0"
        filling.apart = min(filling.apart, state.coefficient(distance) or 0.0)
    if style != "single":
        filling.insertions.append(Insertion(region, poured=False))
    if style == "single":
        filling.launches.append(free_fall.single(state, words[1:]))
    else:
        on_sites = style in ("box", "region") and not some
        filling.launches.append(free_fall.on_lattice(state) if on_sites else free_fall.UNKNOWN)


def poured(state: State, fix: Fix, kind: int, count: float | None, means: tuple[float, float] | None) -> None:
    """Grains that a fix inserts."""
    words = (*fix.words, "")
    name = words[words.index("region") + 1] if "region" in words[:-1] else ""
    state.filling.census.add(census.lot(kind, count, means))
    velocity = velocity_of(state, fix)
    lasting = "once" not in fix.words
    state.filling.insertions.append(Insertion(state.filling.regions.get(name), velocity, lasting=lasting))
    state.filling.launches.append(free_fall.inserted(fix, velocity))


def inserted(state: State, fix: Fix, kind: int, radii: Range | None, densities: Range | None = None) -> None:
    """Grains of ``fix insert``: a number, a mass, or a share of the volume of a region that is filled once."""

    def number(name: str) -> float | None:
        return state.coefficient(fix.words[fix.words.index(name) + 1]) if name in fix.words[:-1] else None

    filling, share, count = state.filling, number("volumefraction_region"), number("nparticles")
    mass, total = number("mass"), number("nparticles")
    again = fix.style.startswith("insert/pack") and "once" not in fix.words
    if again or "once" in fix.words:
        count = number("particles_in_region") if count is None else count
        mass = number("mass_in_region") if mass is None else mass
    name = (*fix.words[fix.words.index("region") + 1 :], "")[0] if "region" in fix.words else ""
    means = alike(radii)
    poured(state, fix, kind, count, means)
    region = filling.regions.get(name)
    space = census.volume(region, filling.ends) if region and share is not None else None
    if share is not None and space is not None and math.isfinite(space):
        filling.census.lots[-1] = census.of_volume(kind, share * space, means)
    elif count is None and mass is not None and densities is not None and densities[0] == densities[1]:
        filling.census.lots[-1] = census.of_volume(kind, mass / densities[0], means)
    if not again:
        return
    each, every = filling.census.lots[-1], number("insert_every")
    filling.census.lots[-1] = census.lot(kind, None, means)
    if every and every >= 1.0 and total is None:
        filling.repeated.append(Repeated(fix.statement, len(filling.census.lots) - 1, each, int(every)))


def lengthen(state: State, steps: int | None) -> None:
    """More steps of the fixes that insert grains again and again; without their number no bound is known."""
    active = {fix.statement.quote for fix in state.fixes.values()}
    running = [each for each in state.filling.repeated if each.statement.quote in active]
    for each in running:
        each.steps += steps or 0
    if steps is None:
        state.filling.repeated = [each for each in state.filling.repeated if each not in running]


def at_most(state: State) -> Census | None:
    """The census with as many grains as fixes that insert again and again make at most; None without such fixes."""
    filling = state.filling
    lots = list(filling.census.lots)
    for each in filling.repeated:
        if each.lot < len(lots) and lots[each.lot].kind == each.each.kind:
            lots[each.lot] = each.each.times(1 + each.steps // each.every)
    moving = [lot for lot in lots if not state.frozen(lot.kind)]
    return replace(filling.census, lots=moving) if filling.repeated else None


def streamed(state: State, fix: Fix, volume_rate: float | None) -> None:
    """What is special about the grains of the last insertion if they are those of a stream."""
    filling = state.filling
    stream = streams.read(state, fix, velocity_of(state, fix), volume_rate)
    filling.insertions[-1] = filling.insertions[-1]._replace(stream=stream)
    filling.launches[-1] = free_fall.streaming(stream)


def alike(radii: Range | None) -> tuple[float, float] | None:
    """Means of r² and r³ of grains of one size; None for others, whose distribution is not read."""
    return census.moments(radii) if radii is not None and radii[0] == radii[1] else None


def velocity_of(state: State, fix: Fix) -> tuple[float, ...]:
    """The fastest velocity with which a fix inserts grains; 0 along an axis for which it is not known."""
    words = list(fix.words)
    if fix.style == "pour" and "vel" in words:  # vxlo vxhi vylo vyhi vz
        along = [state.coefficient(word) or 0.0 for word in words[words.index("vel") + 1 :][:5]]
        pairs = [*zip(along[::2], along[1::2], strict=False)]
        if len(along) == 5:
            return (*(max(pair, key=abs) for pair in pairs[:2]), along[4])
    if fix.style.startswith("insert") and "vel" in words:
        at = words.index("vel") + 2
        numbers = [state.coefficient(word) or 0.0 for word in words[at : at + 3]]
        if len(numbers) == 3:
            return tuple(numbers)
    if fix.style == "deposit":
        ends = [
            max(
                (state.coefficient(word) or 0.0 for word in words[words.index(name) + 1 :][:2]),
                key=abs,
                default=0.0,
            )
            if (name := f"v{axis}") in words
            else 0.0
            for axis in AXES
        ]
        return tuple(ends)
    return 0.0, 0.0, 0.0


# --- velocities -------------------------------------------------------------------------------------------------


def read_velocity(state: State, statement: Statement) -> None:
    """``velocity GROUP create|scale T …`` and ``set VX VY VZ``."""
    group, style, *words = (*statement.words[1:], "", "")
    filling, members = state.filling, state.members(group)
    moving = {kind for kind in state.present() if not state.frozen(kind)}
    every = members.whole and (members.types is None or members.types >= moving)
    if style in ("create", "scale"):
        mass, heat = mean_mass(state), state.coefficient(words[0] if words else "")
        known = heat is not None and heat >= 0.0 and bool(mass) and state.units in BOLTZMANN
        if not known or not every or "sum" in words:
            filling.velocities_known = False
        elif heat and mass and heat is not None:
            speed = math.sqrt(math.pi * BOLTZMANN[state.units] * heat / mass)
            filling.heat.append(
                Speed(speed, f"velocities created at a temperature of {digits(heat, 3)}", decides=True)
            )
    elif style == "set":
        parts = [0.0 if word == "NULL" else state.coefficient(word) for word in words[:3]]
        filling.drifts = {**(filling.drifts if not every else {}), group: tuple(parts)}
        if None in parts:
            filling.velocities_known = False
    elif style == "ramp":
        filling.velocities_known = False


def mean_mass(state: State) -> float | None:
    """Mean mass of the grains that move; None if it is not known."""
    numbers = dict.fromkeys(state.present(), 0.0)
    for lot in state.filling.census.lots:
        if lot.kind in numbers:
            numbers[lot.kind] = math.nan if lot.number is None else numbers[lot.kind] + lot.number
    masses = dict[int, float]()
    for kind in numbers:
        grains = state.grains(kind)
        if grains.frozen:
            continue
        ends = grains.masses
        if grains.densities is not None and grains.radii is not None:
            pairs = zip(grains.radii, grains.densities, strict=True)
            ends = tuple(4.0 / 3.0 * math.pi * r * r * r * density for r, density in pairs)  # type: ignore[assignment]
        if ends is None or not math.isclose(*ends, rel_tol=1e-9):
            return None
        masses[kind] = ends[0]
    if not masses:
        return None
    if math.isclose(min(masses.values()), max(masses.values()), rel_tol=1e-9):
        return next(iter(masses.values()))
    total = math.fsum(numbers[kind] for kind in masses)
    mean = math.fsum(numbers[kind] * mass for kind, mass in masses.items()) / (total or math.nan)
    return mean if state.filling.census.complete and math.isfinite(mean) else None


# --- what follows for a run -------------------------------------------------------------------------------------


def contents(state: State, stage: Stage) -> Contents:
    """What a run has in its box, and the speeds that are stated for it."""
    filling = state.filling
    heat = filling.heat if overlap_free(filling, stage) else [overlapping(speed) for speed in filling.heat]
    stated = (*heat, *drift(state, stage)) if filling.velocities_known else ()
    floor, walled = floor_of(state, stage)
    stream = streams.only(state, stage) if free_fall.undisturbed(state) else None
    free = any(fix.style.endswith("6dof") for fix in state.fixes.values())
    stated = stated if stream is None else (streams.speed(stream),)
    moving = replace(filling.census, lots=[lot for lot in filling.census.lots if not state.frozen(lot.kind)])
    most = at_most(state)
    return Contents(
        count=moving.count,
        filled=moving.filled(state.dimension),
        most=None if most is None else most.count,
        most_filled=None if most is None else most.filled(state.dimension),
        volume=volume(state),
        speeds=(*stated, *(falls(state, stage) if stream is None else ())),
        stream=stream.packing_fraction if stream is not None and stream.along_face else None,
        floor=floor,
        walled=walled or any(kind.partly_frozen for kind in stage.grains.values()),
        without="the weight of the body that moves freely (6dof)" if free else "",
        lots=filling.census.known,
        never_meet=free_fall.never_meet(state, stage),
        poured=bool(filling.insertions) and all(insertion.lasting for insertion in filling.insertions),
        **height_of(state, stage),
    )


def height_of(state: State, stage: Stage) -> dict[str, Any]:
    """The height between plane walls along gravity, where the box is not known."""
    axes = [k for k, part in enumerate(stage.down or ()) if abs(part) > ALONG]
    places = {x for axis in axes for x in planes(state).get(axis, []) if axis not in state.filling.box}
    if len(places) < 2 or not all(map(math.isfinite, places)):
        return {}
    return {"height": max(places) - min(places), "height_from": "between plane walls"}


def overlap_free(filling: Filling, stage: Stage) -> bool:
    """Whether grains that are placed at random do not overlap."""
    radii = [0.0 if kind.radii is None else kind.radii[1] for kind in stage.grains.values()]
    return filling.apart >= 2.0 * (1.0 - 1e-6) * max(radii, default=0.0)


def overlapping(speed: Speed) -> Speed:
    """A speed of grains that overlap when they are made: they push each other, so that it decides nothing."""
    return replace(speed, source=f"{speed.source}, though grains that overlap add to it", decides=False)


def planes(state: State) -> dict[int, list[float]]:
    """Where plane walls stand along each axis."""
    known: dict[int, list[float]] = {}
    for fix in state.fixes.values():
        if not fix.style.startswith("wall/gran"):
            continue
        words = fix.words
        for k, shape in enumerate(PLANES):
            for at in [at for at, word in enumerate(words) if word == shape]:
                ends = words[at + 1 : at + (2 if state.code == "liggghts" else 3)]
                values = [state.coefficient(word) for word in ends if word != "NULL"]
                known.setdefault(k, []).extend(math.nan if value is None else value for value in values)
        for k, place in (faces_of_region(state, fix) or NO_FACES).flat:
            known.setdefault(k, []).append(place)
    return known


def cylinders(state: State) -> list[tuple[int, float]]:
    """The axes and the radii of the walls that are cylinders; NaN: not known."""
    known = []
    for fix in state.fixes.values():
        for k, axis in enumerate(AXES):
            shape = f"{axis}cylinder"
            if fix.style.startswith("wall/gran") and shape in fix.words[:-1]:
                radius = state.coefficient(fix.words[fix.words.index(shape) + 1])
                known.append((k, math.nan if radius is None else radius))
        if fix.style.startswith("wall/gran"):
            known += (faces_of_region(state, fix) or NO_FACES).curved
    return known


class Faces(NamedTuple):
    """The faces of a region that are walls: planes by axis and place, cylinders by axis and radius."""

    flat: list[tuple[int, float]]
    curved: list[tuple[int, float]]


NO_FACES: Final = Faces([], [])


def faces_of_region(state: State, wall: Fix) -> Faces | None:
    """The faces of the one region that a wall is; None if it is none, or of another shape."""
    name = wall.words[wall.words.index("region") + 1] if "region" in wall.words[:-1] else ""
    parts = [*state.parts_of(name).values()]
    region = numbers_of(state, parts[0]) if len(parts) == 1 and parts[0] else None
    if region is None:
        return None
    opened = {face for word, face in pairwise(parts[0]) if word == "open"}
    numbers = [number for number in region if isinstance(number, float)]
    flat, curved = list[tuple[int, float]](), list[tuple[int, float]]()
    if region[0] == "block":
        flat = [(k // 2, x) for k, x in enumerate(numbers) if str(k + 1) not in opened]
    elif region[0] == "cylinder" and "3" not in opened:
        axis = AXES.index(str(region[1]))
        flat = [(axis, x) for face, x in zip("12", numbers[3:], strict=True) if face not in opened]
        curved = [(axis, numbers[2])]
    elif region[0] == "plane":
        normal = numbers[3:]
        flat = [(k, numbers[k]) for k in range(3) if abs(normal[k]) > ALONG * math.hypot(*normal)]
    return Faces([face for face in flat if math.isfinite(face[1])], curved) if flat or curved else None


def extent(state: State, axes: Sequence[int]) -> float | None:
    """Product of the edges of the box along these axes: between periodic ends or plane walls, or in one cylinder.

    None if a wall has another shape: it may hold the grains in a part of the box.
    """
    walls, round_walls = planes(state), cylinders(state)
    all_walls = [fix for fix in state.fixes.values() if fix.style.startswith("wall/gran")]
    if len(round_walls) > 1 or not all(has_known_shape(state, fix) for fix in all_walls):
        return None
    sizes, across = [], set[int]()
    for along, radius in round_walls:
        across = {k for k in range(3) if k != along}
        if not across <= {*axes}:
            return None
        sizes.append(math.pi * radius**2)
    for k in axes:
        if k in across:
            continue
        open_sides = state.filling.periodic(k) and k not in walls
        ends = state.filling.box.get(k) if open_sides else walls.get(k)
        if ends is None or len(set(ends)) != 2:
            return None
        sizes.append(max(ends) - min(ends))
    size = math.prod(sizes)
    return size if math.isfinite(size) else None


def volume(state: State) -> float | None:
    """Volume of the box, in two dimensions its area."""
    return extent(state, range(state.dimension))


def floor_of(state: State, stage: Stage) -> tuple[float | None, bool]:
    """The area across the axis nearest to gravity, and whether side walls are around it.

    None if a side wall has another shape, or stands where a slope ends.
    """
    down = stage.down
    if down is None:
        return None, False
    axis = max(range(state.dimension), key=lambda k: abs(down[k]))
    across = [k for k in range(state.dimension) if k != axis]
    walls = planes(state)
    closed = [k for k in across if not state.filling.periodic(k) or k in walls]
    if any(abs(down[k]) > LEVEL for k in closed):
        return None, False
    return extent(state, across), bool(closed or cylinders(state))


def has_known_shape(state: State, wall: Fix) -> bool:
    """Whether a wall is made of planes, or is a cylinder."""
    round_or_plane = {*PLANES, *(f"{axis}cylinder" for axis in AXES)}
    return faces_of_region(state, wall) is not None or not round_or_plane.isdisjoint(wall.words)


def falls(state: State, stage: Stage) -> Iterator[Speed]:
    """The speeds with which grains reach the floor from where they are made; without gravity, those of insertions."""
    if not any(fix.style == "gravity" for fix in state.fixes.values()):
        launched = {each.velocity for each in state.filling.insertions}
        others = (
            launched | {still()} if any(contact.wall is not None for contact in stage.contacts) else launched
        )
        if largest := max((math.dist(a, b) for a in launched for b in others), default=0.0):
            yield Speed(largest, "the insertion" if len(launched) == 1 else "the insertions")
        return
    axes = [k for k, part in enumerate(stage.down or ()) if abs(part) > ALONG]
    if (
        not axes
        or stage.gravity is None
        or stage.gravity <= 0.0
        or stage.down is None
        or state.filling.periodic(axes[0])
    ):
        return
    axis, sign = axes[0], -1.0 if stage.down[axes[0]] > 0.0 else 1.0
    box = state.filling.box.get(axis)
    walls = [sign * place for place in planes(state).get(axis, []) if math.isfinite(place)]
    ends = [] if box is None else [sign * end for end in box]
    for insertion in state.filling.insertions:
        limits = census.extents(insertion.region, state.filling.ends) if insertion.region else None
        top = max((sign * end for end in limits[axis]), default=None) if limits else None
        unknown = insertion.region is None and any(contact.wall is not None for contact in stage.contacts)
        if insertion.region == () or unknown:
            top = max(ends, default=None)
        below = [] if top is None else [wall for wall in walls if wall < top]
        floor = max(below, default=min(ends, default=None))
        fall = None if top is None or floor is None else top - floor
        start = max(0.0, -sign * insertion.velocity[axis])
        height = fall if fall is not None and 0.0 < fall < math.inf else 0.0
        if height or start:
            place = " within the box" if unknown or not insertion.poured else " from the insertion region"
            place += f" ({AT_MOST}: through the whole of it)" if unknown else ""
            place += "" if below or unknown else f" ({AT_MOST}: to the end of the box)"
            yield fallen(height, start, stage.gravity, place)


def fallen(height: float, start: float, gravity: float, place: str) -> Speed:
    """The speed after a fall."""
    source = "the insertion" if not height else "the fall of {height}" + place
    if height:
        source += " and the speed of the insertion" if start else ""
    return Speed(math.hypot(start, math.sqrt(2.0 * gravity * height)), source, height or None)


def drift(state: State, stage: Stage) -> Iterator[Speed]:
    """The largest relative velocity of groups whose velocities are set, and of what stands still."""
    drifts = [tuple(x or 0.0 for x in velocity) for velocity in state.filling.drifts.values()]
    whole = "all" in state.filling.drifts or len(drifts) > 1 or state.filling.census.count == 1.0
    others = [*drifts, *([] if whole else [still()])]
    largest = max((math.dist(a, b) for a in drifts for b in others), default=0.0)
    walls = [contact.pushes for contact in stage.contacts if contact.wall is not None]
    at_walls = [towards(velocity, pushes) for velocity in drifts for pushes in walls]
    if largest := max([largest, *at_walls]):
        yield Speed(largest, "the velocities that are set")


def towards(velocity: Sequence[float], pushes: Sequence[Direction] | None) -> float:
    """The largest velocity across a wall that pushes so, which need not be known; no motion along it is an impact."""
    if pushes is None:
        return math.hypot(*velocity)
    axes = {tuple(map(abs, push)) for push in pushes}  # two across a cylinder
    return math.hypot(*(sum(v * n for v, n in zip(velocity, axis, strict=True)) for axis in axes))


def still() -> Direction:
    """The velocity of what does not move."""
    return 0.0, 0.0, 0.0
