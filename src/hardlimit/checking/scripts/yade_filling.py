"""What a script of YADE fills its cell with, the speeds of impacts that it states, and files of spheres beside it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from . import census
from .commands import text_of
from .description import DENSEST, FEW, Contents, Direction, Lot, Range, Speed, Stage
from .python import Instance, flat
from .yade_clumps import Clumped
from .yade_container import Container, Ends, axis_of, box_around, is_number, shape_of, union, vector
from .yade_extents import ends_of_space, shifted, span

#: Packing fractions of packings: of lattices without gaps, and of random ones that were pressed together.
REGULAR: Final = ("regularHexa", "regularOrtho")
DENSITIES: Final = {
    "regularHexa": math.pi / math.sqrt(18.0),
    "regularOrtho": math.pi / 6.0,
    "randomDensePack": 0.64,
    "filterSpherePack": 0.64,
}
#: Porosity of ``makeCloud`` by default, and from which on it makes no spheres smaller.
POROSITY, LOOSE = 0.65, 0.75
#: Packing fraction up to which ``makeCloud`` finds place for all its spheres, over ``rRelFuzz``: in YADE 2023.02a, 300
#: and 2000 of them between six walls. Then the share of this for fewer spheres than a number, in a few of which it was
#: seen, and that in a periodic cell.
ROOM: Final = {0.0: 0.25, 0.2: 0.32, 0.5: 0.36, 0.8: 0.34}
FEWER, LESS_ROOM, MORE_ROOM = 100, 0.8, 1.1
#: Rounding error of the place of a sphere that touches a floor.
TOUCHING: Final = 1e-9
#: Extent of spheres over their mean diameter up to which they are one layer.
IN_LAYER: Final = 1.5
#: Functions of ``ymport`` whose files have lines ``x y z r``.
TEXTS: Final = ("text", "textExt")


@dataclass
class YadeFilling:
    """The cell, the spheres that are made, where they are and how they move."""

    census: census.Census = field(default_factory=census.Census)
    fixed: list[Lot] = field(default_factory=list)  #: those of the census that do not move
    cell: tuple[float, ...] | None = None  #: edges of the periodic cell
    periodic: bool = False
    #: Where centres of spheres are made, and their radius; of a cloud, its corners and 0.
    places: list[tuple[Direction, Direction, float]] = field(default_factory=list)
    #: Ends of walls, boxes and facets.
    floors: list[tuple[Direction, Direction]] = field(default_factory=list)
    velocities: dict[int, Direction] = field(default_factory=dict)  #: of single bodies
    known: bool = True  #: whether no velocity is unknown
    container: Container = field(default_factory=Container)
    clumped: Clumped | None = None  #: the clumps that spheres are in; None if there are none

    def contents(self, stage: Stage, damped: float = 0.0) -> Contents:
        """What a run has in its cell, and the speeds that are stated for it; ``damped`` as in :func:`falls`."""
        volume = math.prod(self.cell) if self.periodic and self.cell else None
        speeds = [*falls(self, stage, damped), *(relative(self) if self.known else ())]
        return Contents(
            count=self.census.count,
            filled=self.census.filled(3),
            volume=volume,
            speeds=tuple(speeds),
            lots=() if self.clumped else self.census.known,
            concentration=self.clumped.concentration if self.clumped else 1.0,
            other_clumps=self.clumped is not None and self.clumped.unknown,
        )

    @property
    def is_few(self) -> bool:
        """Whether there are so few spheres that each contact counts."""
        return self.census.count is not None and self.census.count <= FEW

    @property
    def moving(self) -> float | None:
        """The number of spheres that are not fixed; None if it is not known."""
        fixed = [lot.number for lot in self.fixed]
        known = self.census.count is not None and None not in fixed
        return (self.census.count or 0.0) - math.fsum(number or 0.0 for number in fixed) if known else None

    def without_fixed(self, contents: Contents) -> Contents:
        """A bed without the spheres that do not move, of which a few others are no bed."""
        lots = list(self.census.lots)
        for lot in self.fixed:
            lots.remove(lot)
        moving = replace(self.census, lots=lots)
        if not self.fixed or contents.count is None or moving.count is None or moving.count <= FEW:
            return contents
        return replace(contents, count=moving.count, filled=moving.filled(3), lots=moving.known)

    def bed(
        self,
        contents: Contents,
        down: Direction,
        sources: Sequence[Ends | None],
        turning: Direction | None,
        moving: bool,
    ) -> Contents:
        """With the area on which the spheres lie, and the height above which none of them comes to rest.

        ``sources``: where factories make spheres. ``turning``: the axis about which walls turn across gravity.
        ``moving``: whether they move or turn.
        """
        cell = self.cell if self.periodic else None
        if self.periodic and (cell is None or len(cell) != 3):
            return contents
        container = replace(self.container, spheres=[*self.container.spheres, *sources])
        contents = replace(
            contents, pours=not self.periodic and container.pours(down, contents.diameter() or 0.0)
        )
        floor = None if moving else container.floor(down, cell)
        height = container.height(down, cell) if turning is None else container.turned(turning)
        if height is None or (cell is not None and floor is None and not container.based(down, cell)):
            return contents
        contents = self.without_fixed(contents)
        source = "from the floor to where spheres are made"
        if turning is not None:
            source = "across the circle in which walls turn"
        if contents.count and (diameter := contents.diameter()):
            stack, few = contents.count * diameter, contents.count <= FEW
            one_layer = container.thickness(down) < IN_LAYER * diameter
            contents = replace(contents, layer=diameter if one_layer else None)
            if stack < height and few:
                return contents
            if stack < height:
                height, source = stack, "of spheres in one stack"
        return replace(
            contents,
            floor=floor,
            walled=cell is None or container.rough,
            height=height,
            height_from=source,
            packed=max(container.packed, DENSEST * self.clumped.heavier if self.clumped else 0.0),
            without="what moving walls add" if moving else "",
        )


def corners_of(instance: Instance) -> list[Direction | None]:
    """The corners of ``makeCloud``."""
    corners = [vector(instance.argument(k, name)) for k, name in enumerate(("minCorner", "maxCorner"))]
    if corners[0] is None and not instance.arguments and "minCorner" not in instance.attributes:
        corners[0] = (0.0, 0.0, 0.0)
    return corners


def ends_of(instance: Instance, name: str = "") -> Ends | None:
    """Where ``makeCloud``, ``sphere``, ``add`` or a packing makes spheres; None if it is not known."""
    name = name or instance.name
    if name == "makeCloud":
        low, high = corners_of(instance)
        if low is None or high is None or "hSize" in instance.attributes:
            return None
        return tuple(map(min, low, high)), tuple(map(max, low, high))
    if name in ("sphere", "add"):
        return around_sphere(instance.argument(0, "center"), instance.argument(1, "radius"))
    return ends_of_space(instance.argument(0, "predicate")) if name in DENSITIES else None


def around_sphere(centre: Any, radius: Any) -> Ends | None:
    """The ends of a sphere, whose place and radius may be drawn at random."""
    spans, size = [span(x) for x in centre] if isinstance(centre, list | tuple) else [], span(radius)
    known = [each for each in spans if each is not None]
    if len(known) != 3 or len(spans) != 3 or size is None or size[1] < 0.0:
        return None
    return tuple(low - size[1] for low, _ in known), tuple(high + size[1] for _, high in known)


def packed(instance: Instance, name: str = "") -> float:
    """The packing fraction of a packing when it is made; 0 for clouds and spheres, which are looser than beds."""
    dense = DENSITIES.get(name or instance.name, 0.0)
    radius, gap = instance.argument(1, "radius"), instance.argument(2, "gap", 0.0)
    spaced = is_number(radius) and is_number(gap) and radius > 0.0 and gap > 0.0
    return dense / (1.0 + 0.5 * gap / radius) ** 3 if spaced and instance.name in REGULAR else dense


def cloud(filling: YadeFilling, pack: Instance, instance: Instance) -> float | None:
    """The number of spheres of ``makeCloud``, and where they are."""
    corners = corners_of(instance)
    if corners[0] is not None and corners[1] is not None:
        filling.places.append((corners[0], corners[1], 0.0))
        if instance.argument(5, "periodic", False) in (True, 1):
            pack.attributes["cell"] = tuple(b - a for a, b in zip(*corners, strict=True))
    number = instance.argument(4, "num", -1)
    return float(number) if is_number(number) and number > 0 and not is_overfull(instance) else None


def is_overfull(instance: Instance) -> bool:
    """Whether the spheres that ``makeCloud`` is asked for may find no place: it then makes the largest ones alone."""
    mean, number = instance.argument(2, "rMean", -1), instance.argument(4, "num", -1)
    fuzz, (low, high) = instance.argument(3, "rRelFuzz", 0.0), corners_of(instance)
    if low is None or high is None or "hSize" in instance.attributes:
        return False
    if not (is_number(mean) and is_number(number) and is_number(fuzz) and mean > 0.0 and number > 0):
        return False
    volume = abs(math.prod(b - a for a, b in zip(low, high, strict=True)))
    filled = float(number) * 4.0 / 3.0 * math.pi * float(mean) ** 3 * (1.0 + float(fuzz) ** 2)
    room = float(np.interp(float(fuzz), list(ROOM), list(ROOM.values())))
    room *= LESS_ROOM if number < FEWER else 1.0
    room *= MORE_ROOM if instance.argument(5, "periodic", False) in (True, 1) else 1.0
    return 0.0 < volume * room < filled


def mean_radius(instance: Instance) -> Range | None:
    """The ends of ``rMean`` of ``makeCloud``.

    If it is not positive, YADE takes the one with which ``num`` spheres have a porosity, V (1 − porosity) =
    num 4/3 π r³ (1 + fuzz²), and smaller spheres if they find no place. That is not so from a porosity of :data:`LOOSE`
    on: of its 1000 tries for each sphere, 30 succeed.
    """
    mean, number = instance.argument(2, "rMean", -1), instance.argument(4, "num", -1)
    corners = [corner for corner in corners_of(instance) if corner is not None]
    fuzz, porosity = instance.argument(3, "rRelFuzz", 0.0), instance.argument(6, "porosity", POROSITY)
    if not is_number(mean) or mean > 0.0 or len(corners) < 2 or "hSize" in instance.attributes:
        return (mean, mean) if is_number(mean) and mean > 0.0 else None
    volume = math.prod(b - a for a, b in zip(*corners, strict=True))
    known = is_number(number) and is_number(fuzz) and is_number(porosity)
    if not known or number <= 0 or volume <= 0.0 or not 0.0 < porosity < 1.0:
        return None

    def radius(porosity: float) -> float:
        return float(
            (0.75 * volume * (1.0 - porosity) / (math.pi * (1.0 + fuzz * fuzz) * number)) ** (1.0 / 3.0)
        )

    return radius(max(porosity, LOOSE)), radius(porosity)


def obstacle(filling: YadeFilling, instance: Instance) -> None:
    """Where a wall, a box or a facet ends along each axis."""
    first, second = instance.argument(0, "center"), instance.argument(1, "extents")
    if instance.name == "wall":
        place, axis = instance.argument(0, "position"), instance.argument(1, "axis")
        at = (
            place[axis]
            if isinstance(place, list | tuple) and len(place) == 3 and axis in (0, 1, 2)
            else place
        )
        if is_number(at) and axis in (0, 1, 2):
            low, high = [-math.inf] * 3, [math.inf] * 3
            low[axis] = high[axis] = float(at)
            filling.floors.append(((low[0], low[1], low[2]), (high[0], high[1], high[2])))
    elif instance.name == "aabbWalls":
        shape = shape_of(instance)
        filling.floors += [] if shape is None else [face.ends for face in shape[1]]
    elif instance.name == "facet":
        vertices = instance.argument(0, "vertices")
        corners = [vector(corner) for corner in (vertices if isinstance(vertices, list | tuple) else ())]
        known = [corner for corner in corners if corner is not None]
        if known and len(known) == len(corners):
            axes = list(zip(*known, strict=True))
            filling.floors.append(((*map(min, axes),), (*map(max, axes),)))
    elif instance.name == "facetBox" and (shape := shape_of(instance)) is not None:  # hollow
        filling.floors += [face.ends for face in shape[1]]
    elif (centre := vector(first)) is not None and (half := vector(second)) is not None:
        ends = [tuple(c + sign * h for c, h in zip(centre, half, strict=True)) for sign in (-1.0, 1.0)]
        if instance.name == "facetBox":  # turned: where its bottom was before
            ends[1] = tuple(
                high if axis != 2 else low for axis, (low, high) in enumerate(zip(*ends, strict=True))
            )
        filling.floors.append((ends[0], ends[1]))


def falls(filling: YadeFilling, stage: Stage, damped: float) -> Iterator[Speed]:
    """The speed with which the highest sphere reaches the highest obstacle below it, with the velocity that is set.

    For few spheres, fixed ones are obstacles, too; among many they may be those of side walls. Of two spheres above
    each other, the upper one falls on the lower one. ``damped``: the numerical damping, which acts on the weight, too.
    """
    along = axis_of(stage.down or ())
    if along is None or not stage.gravity:
        return
    k, sign = along
    tops = [max(sign * low[k], sign * high[k]) - radius for low, high, radius in filling.places]
    if len(tops) == 2 and filling.is_few and are_stacked(filling, k):
        upper = tops.index(max(tops))
        tops[upper] -= 2.0 * filling.places[1 - upper][2]
    across = [axis for axis in range(3) if axis != k]
    obstacles = [
        *(ends for ends in filling.floors if all(ends[0][axis] < ends[1][axis] for axis in across)),
        *(filling.container.bumps if filling.is_few else []),
    ]
    ends = [max(sign * low[k], sign * high[k]) for low, high in obstacles]
    ends += filling.container.bottoms(k, sign)
    along_it = [sign * velocity[k] for velocity in filling.velocities.values()] if filling.known else []
    rising = math.sqrt((1.0 - damped) / (1.0 + damped))  # what is left of a speed upwards back at its height
    start = max((v * rising if v > 0.0 else -v for v in along_it), default=0.0)
    for top in tops:
        below = [end for end in ends if end <= top + TOUCHING * abs(top)]
        height = top - max(below, default=top)
        if TOUCHING * abs(top) < height < math.inf:
            source = "the fall of {height} from where spheres are made"
            source += " with the velocity that is set" * bool(start)
            yield Speed(math.sqrt(start**2 + 2.0 * (1.0 - damped) * stage.gravity * height), source, height)


def are_stacked(filling: YadeFilling, k: int) -> bool:
    """Whether the centre of one of two spheres is above the other one."""
    (first, _, radius), (second, _, other) = filling.places
    across = [first[j] - second[j] for j in range(3) if j != k]
    return math.hypot(*across) < max(radius, other)


def relative(filling: YadeFilling) -> Iterator[Speed]:
    """The largest relative velocity of bodies whose velocities are set, and of those at rest.

    That of one sphere beside flat walls which all lie across one axis is that along it: it slides along them.
    """
    velocities = [*filling.velocities.values(), (0.0, 0.0, 0.0)]
    across = {axis for axis in range(3) for low, high in filling.floors if low[axis] == high[axis]}
    flat = all(any(low[axis] == high[axis] for axis in across) for low, high in filling.floors)
    if filling.census.count == 1.0 and len(across) == 1 and flat:
        velocities = [tuple(v * (k in across) for k, v in enumerate(each)) for each in velocities]
    largest = max(math.dist(a, b) for a in velocities for b in velocities)
    if largest > 0.0:
        yield Speed(largest, "the velocities that are set")


def spheres_in(folder: Path | None, instance: Instance, pack: bool) -> tuple[list[float], Ends | None] | None:
    """Radii in a file of spheres beside the script, and their ends; None if it is not there, or not understood."""
    name, by = instance.argument(0, "fileName"), (0.0, 0.0, 0.0)
    place = 3 if instance.name == "textExt" else 2
    scale = 1.0 if pack else instance.argument(place, "scale", 1.0)
    shift = by if pack else vector(instance.argument(place - 1, "shift", by))
    form = instance.argument(1, "format", "x_y_z_r") if instance.name == "textExt" else "x_y_z_r"
    if folder is None or not isinstance(name, str) or not is_number(scale) or form != "x_y_z_r":
        return None
    text = text_of(folder / name)
    lines = [] if text is None else [line.split() for line in text.splitlines()]
    try:
        if any(words[:1] == ["#format"] and words[1:] != ["x_y_z_r"] for words in lines):
            return None
        rows = [
            [scale * float(word) for word in words[:4]] for words in lines if words and words[0][0] != "#"
        ]
        radii = [row[3] for row in rows]
        boxes = [box_around(at, (radius,) * 3) for *at, radius in rows]
        ends = None if None in boxes else union([box for box in boxes if box is not None])
    except (IndexError, ValueError):
        return None
    if not radii or not all(0.0 < radius < math.inf for radius in radii):
        return None
    return radii, shifted(ends, shift) if shift is not None else None


def lot_of(radii: Sequence[float]) -> Lot:
    """Spheres of known radii."""
    squares, cubes = (math.fsum(radius**p for radius in radii) for p in (2, 3))
    return Lot(0, float(len(radii)), squares, cubes)


def uniform(count: float | None, radii: Range | None) -> Lot:
    """Spheres whose radii are uniform in a range."""
    return census.lot(0, count, None if radii is None else census.moments(radii))


def volume_of(matrix: Any) -> tuple[float, ...] | None:
    """The edges of a cell from a ``Matrix3``, or the volume of an inclined one; None if it is not known."""
    if not isinstance(matrix, Instance) or len(parts := flat([matrix.arguments])) != 9:
        return None
    if not all(map(is_number, parts)):
        return None
    a, b, c, d, e, f, g, h, i = map(float, parts)
    if not any((b, c, d, f, g, h)):
        return abs(a), abs(e), abs(i)
    return (abs(a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)),)
