"""Where a script of YADE has walls and makes spheres: how high they may lie, and on which area.

``utils.py`` and ``geom.py`` of YADE 2023.02a: wall, box, aabbWalls, facetBox, facetCylinder.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Final, NamedTuple

import numpy as np

from .description import Direction
from .meshes import Triangles, sheds
from .python import Instance

#: Cosine of the angle up to which gravity counts as along an axis.
ALONG: Final = 1.0 - 1e-6
#: The same for a slope, on which a bed is as high everywhere in a periodic cell: 45°.
TILTED: Final = math.sqrt(0.5)
#: Angle [°] of a slope up to which a bed may stay on it: in YADE 2023.02a heaps stay on 6 to 22° and creep at 31°.
STAYS: Final = 30.0
#: Width over the diameter of grains of an opening that they do not block for long: Zuriguel et al., Phys. Rev. E 71,
#: 051303 (2005).
ARCH: Final = 4.94
#: Largest number whose third power is finite.
LARGEST: Final = 1e100
#: Rounding error of positions over the largest of them.
ROUNDING: Final = 1e-9
#: Arguments of facetBox and facetCylinder that turn them or leave out parts.
TURNED: Final = {"orientation", "angleRange", "closeGap", "radiusTopInner", "radiusBottomInner"}
#: The bit of the mask of a cylinder for its side, and for its end below gravity along -z and +z.
SIDE: Final = 4
LOWER: Final = {1.0: 2, -1.0: 1}
#: Facets around the axis z with such a mask: its place among the arguments, and its default.
ROUND: Final = {"facetCylinder": (5, 7), "facetCone": (6, 7), "facetBunker": (8, 4)}

#: Area of a wall that moves along gravity over that of the bed, up to which it is no piston.
NARROW: Final = 0.25

Ends = tuple[Direction, Direction]  #: lowest and highest coordinates


class Face(NamedTuple):
    """A rectangle across an axis."""

    axis: int
    ends: Ends

    @property
    def at(self) -> float:
        """Its place along the axis."""
        return self.ends[0][self.axis]

    def covers(self, ends: Ends, small: float) -> bool:
        """Whether it reaches from end to end across its axis."""
        low, high = self.ends
        return all(
            low[j] <= ends[0][j] + small and high[j] >= ends[1][j] - small for j in range(3) if j != self.axis
        )

    def within(self, ends: Ends, small: float) -> bool:
        """Whether a part of it is inside a space, not on its surface."""
        low, high = self.ends
        return all(low[j] < ends[1][j] - small and high[j] > ends[0][j] + small for j in range(3))


class Cylinder(NamedTuple):
    """Facets around the axis z."""

    ends: Ends
    area: float
    mask: int


@dataclass
class Container:
    """Walls of a scene and its spheres."""

    faces: list[Face] = field(default_factory=list)
    cylinders: list[Cylinder] = field(default_factory=list)
    ends: list[Ends] = field(default_factory=list)  #: of walls and facets
    solid: list[Ends] = field(default_factory=list)  #: of boxes
    bumps: list[Ends] = field(default_factory=list)  #: of spheres that do not move
    masks: dict[Ends, int] = field(default_factory=dict)  #: of what stands around the axis z, by its ends
    vessels: list[Ends] = field(default_factory=list)  #: of meshes and other facets of functions
    meshes: dict[Ends, Triangles] = field(default_factory=dict)  #: triangles of facets, by their ends
    appended: dict[str, list[Ends | None]] = field(default_factory=dict)  #: walls by the text of the call
    walls_only: set[str] = field(default_factory=set)  #: texts of the calls that append nothing else
    unsure: list[Ends | None] = field(default_factory=list)  #: of spheres some of which may not move
    plain: bool = True  #: whether all walls are such faces and cylinders
    normals: set[int] = field(default_factory=set)  #: the axes along which walls push
    slanted: bool = False  #: whether some walls push in other directions, or in unknown ones
    spheres: list[Ends | None] = field(default_factory=list)  #: of each command; None if not known
    known: bool = True  #: whether walls and spheres stay where they are made, or move as in ``moves``
    everywhere: bool = True  #: whether it is known how far all walls reach
    rough: bool = False  #: whether some spheres do not move
    farther: float = 0.0  #: reach of clumps beyond the spheres that they replace
    moves: list[Direction | None] = field(default_factory=list)  #: velocities of walls; None if not known
    packed: float = (
        0.0  #: largest packing fraction of spheres when they are made, if it may exceed that of a bed
    )

    def add(self, instance: Instance, reach: Ends | None, mesh: Triangles | None) -> None:
        """A wall, a box or facets, with how far they reach and their triangles if that is known."""
        if instance.attributes.get("mask") == 0 or instance.attributes.get("noBound") in (True, 1):
            return  # it touches nothing
        mask = mask_of(instance)
        if mask is not None and reach is not None:
            self.masks[reach] = self.masks.get(reach, 0) | mask
        shape = shape_of(instance)
        place = reach if shape is None else shape[0]
        if mesh is not None and place is not None:
            known = self.meshes.get(place)
            self.meshes[place] = mesh if known is None else np.concatenate([known, mesh])
        if shape is None or (instance.name == "facet" and flat_axis(shape[0]) is None):
            self.slanted = True
        if shape is None:
            self.plain = False
            self.everywhere &= reach is not None
            known_reach = [] if reach is None else [reach]
            self.ends += known_reach
            self.vessels += known_reach if instance.name != "facetBox" else []
            return
        ends, faces = shape
        flat = flat_axis(ends) if instance.name == "facet" else None
        self.normals |= {face.axis for face in faces} | (set() if flat is None else {flat})
        if instance.name == "facetCylinder" and mask is not None and mask & SIDE:
            self.normals |= {0, 1}
        (self.solid if instance.name == "box" else self.ends).append(ends)
        self.faces += faces
        if instance.name == "facetCylinder":
            radius, number = float(instance.argument(1, "radius")), instance.argument(4, "segmentsNumber", 10)
            area = 0.5 * number * radius**2 * math.sin(2.0 * math.pi / number)
            self.cylinders.append(Cylinder(ends, area, instance.argument(5, "wallMask", 7)))
        self.plain &= instance.name != "facet"

    @property
    def pushes(self) -> tuple[Direction, ...] | None:
        """The directions in which walls push the spheres, to both sides; None if they are not known."""
        if self.slanted or not self.known:
            return None
        units = [
            tuple(sign * (j == k) for j in range(3)) for k in sorted(self.normals) for sign in (-1.0, 1.0)
        ]
        return tuple(units)

    @property
    def walls(self) -> list[Ends]:
        """The ends of walls, facets and boxes."""
        return [*self.ends, *self.solid]

    def bottoms(self, k: int, sign: float) -> list[float]:
        """The lower ends of meshes, and of what stands around the axis z if it is closed there."""
        closed = [ends for ends, mask in self.masks.items() if k != 2 or mask & LOWER[sign]]
        hollow = [*closed, *(ends for ends in self.vessels if ends not in self.masks)]
        return [min(sign * end[k] for end in ends) for ends in hollow]

    @property
    def around(self) -> Ends | None:
        """The ends of all spheres; None if they are not known."""
        known = [ends for ends in self.spheres if ends is not None]
        return union(known) if known and len(known) == len(self.spheres) and self.known else None

    def thickness(self, down: Direction) -> float:
        """The smallest extent of all spheres across gravity; infinite if it is not known."""
        space, along = self.around, axis_of(down)
        if space is None or along is None:
            return math.inf
        return min(high - low for k, (low, high) in enumerate(zip(*space, strict=True)) if k != along[0])

    def is_narrow(self, text: str, down: Direction) -> bool:
        """Whether the walls of a call cover at most a part of the area of the spheres, and no bed, across gravity."""
        space, along, walls = self.around, axis_of(down), self.appended.get(text, [None])
        known = [ends for ends in walls if ends is not None]
        if space is None or along is None or len(known) < len(walls) or not known:
            return False
        sizes = [
            math.prod(min(high[k] - low[k], LARGEST) for k in range(3) if k != along[0])
            for low, high in (union(known), space)
        ]
        return sizes[0] <= NARROW * sizes[1]

    def fix(self, spheres: list[Ends | None]) -> None:
        """Spheres that do not move."""
        self.rough |= bool(spheres)
        self.bumps += [ends for ends in spheres if ends is not None]
        self.everywhere &= None not in spheres

    def height(self, down: Direction, cell: Direction | None = None) -> float | None:
        """From the lowest end of walls to the highest one of the spheres when they are made: no bed is higher.

        If it is not known how far all walls reach, from a floor below all spheres on.
        """
        space, along = self.around, axis_of(down, cell is not None)
        if space is None or along is None:
            return None
        k, sign = along
        lowest, height = _lowest(space, along), max(sign * end[k] for end in space)
        ends = [sign * end[k] for pair in self.ends for end in pair if math.isfinite(end[k])]
        tops = [max(sign * end[k] for end in pair) for pair in (*self.solid, *self.bumps)]
        if not self.everywhere:
            ends = [max((sign * face.at for face in self.floors(space, along, cell)), default=math.inf)]
            tops = []
        unsure = [min(sign * end[k] for end in pair) for pair in self.unsure if pair is not None]
        bottom = min((*ends, *tops, *unsure), default=math.inf)
        inside = bottom <= lowest + ROUNDING * abs(height)
        return height + self.farther - bottom if inside and math.isfinite(height) else None

    def pours(self, down: Direction, diameter: float) -> bool:
        """Whether nothing below spheres of this diameter catches them: all that reaches there is open below."""
        space, along = self.around, axis_of(down)
        if space is None or along is None or not self.everywhere or self.unsure:
            return False
        (k, sign), lowest = along, _lowest(space, along)
        below = [
            ends
            for ends in (*self.walls, *self.bumps)
            if math.isfinite(low := min(sign * end[k] for end in ends)) and low < lowest
        ]
        rounded = [ends for ends in below if ends in self.masks]
        facets = [self.meshes[ends] for ends in below if ends not in self.masks and ends in self.meshes]
        if not below or len(rounded) + len(facets) < len(below):
            return False
        if any(k != 2 or self.masks[ends] & LOWER[sign] for ends in rounded):
            return False
        top = max(sign * end[k] for end in space)
        return not facets or sheds(np.concatenate(facets), down, STAYS, top, ARCH * diameter)

    def turned(self, axis: Direction) -> float | None:
        """The diameter of the circle around the axis in which all walls and spheres turn: no bed in them is higher."""
        walls = [pair for pair in self.ends if all(map(math.isfinite, (*pair[0], *pair[1])))]
        if self.around is None or not self.everywhere or not walls or not any(axis):
            return None
        low, high = union([*walls, self.around])
        along = [part / math.hypot(*axis) for part in axis]
        round_walls = [cylinder.ends for cylinder in self.cylinders]
        if (
            all(wall in round_walls for wall in walls)
            and (low, high) in round_walls
            and abs(along[2]) > ALONG
        ):
            return high[0] - low[0]
        squares = [(b - a) ** 2 * (1.0 - t * t) for a, b, t in zip(low, high, along, strict=True)]
        diameter = math.sqrt(math.fsum(squares)) + 2.0 * self.farther
        return diameter if math.isfinite(diameter) else None

    def based(self, down: Direction, cell: Direction) -> bool:
        """Whether a floor covers a periodic cell below all spheres, which do not reach beyond its ends."""
        space, along = self.around, axis_of(down, tilted=True)
        if space is None or along is None or not self.floors(space, along, cell):
            return False
        k, small = along[0], self.small(space)
        return space[0][k] >= -small and space[1][k] <= cell[k] + small

    def floors(self, space: Ends, along: tuple[int, float], cell: Direction | None) -> list[Face]:
        """The faces below all spheres that catch them, wherever they are made, or all over a periodic cell."""
        k, sign = along
        small, lowest = self.small(space), _lowest(space, along)
        reach = space if cell is None else _over(cell, space, k)
        return [
            face
            for face in self.faces
            if face.axis == k and sign * face.at <= lowest + small and face.covers(reach, small)
        ]

    def small(self, space: Ends) -> float:
        """Rounding error of positions."""
        numbers = [abs(x) for end in (*space, *(face.ends[0] for face in self.faces)) for x in end]
        return ROUNDING * max((number for number in numbers if number < math.inf), default=0.0)

    def floor(self, down: Direction, cell: Direction | None) -> float | None:
        """The area on which all spheres lie, across gravity; None if it is not known. ``cell``: if it is periodic."""
        space, along = self.around, axis_of(down, cell is not None)
        if space is None or along is None or not self.plain or not self.everywhere or self.unsure:
            return None
        k, sign = along
        small = self.small(space)
        if any(max(sign * end[k] for end in pair) > _lowest(space, along) + small for pair in self.bumps):
            return None
        below = [
            face for face in self.faces if face.axis == k and sign * face.at <= _lowest(space, along) + small
        ]
        for floor in sorted(below, key=lambda face: -sign * face.at):
            limits = _limits(space, along, floor.at)
            area = self._area(limits, k, floor, cell, small)
            if area is not None:
                return area
        return None

    def _area(self, limits: Ends, k: int, floor: Face, cell: Direction | None, small: float) -> float | None:
        """The area between side walls above a floor, if nothing else is there."""
        alone = not self.cylinders or (cell is None and len(self.cylinders) == 1)
        if not alone or (cell is not None and not self._periodic(limits, k, floor, cell, small)):
            return None
        inner = self._between(limits, k, floor, cell, small)
        whole = floor.covers(_flat(inner, k, floor.at), small)
        if not whole or any(face.within(inner, small) for face in self.faces):
            return None
        across = [j for j in range(3) if j != k]
        holds = all(
            inner[0][j] - small <= limits[0][j] and limits[1][j] <= inner[1][j] + small for j in across
        )
        if self.cylinders:
            ends, area, mask = self.cylinders[0]
            stands = k == 2 and mask & SIDE and ends[0][2] - small <= floor.at < ends[1][2]
            return area if stands and holds else None
        area = math.prod(inner[1][j] - inner[0][j] for j in across)
        return area if math.isfinite(area) and (cell is not None or holds) else None

    def _between(self, limits: Ends, k: int, floor: Face, cell: Direction | None, small: float) -> Ends:
        """The space between the nearest side walls; infinite without them."""
        low, high = list(limits[0]), list(limits[1])
        for j in (j for j in range(3) if j != k):
            if cell is not None:
                low[j], high[j] = 0.0, cell[j]
            elif self.cylinders:
                low[j], high[j] = (end[j] for end in self.cylinders[0].ends)
            else:
                sides = [
                    face for face in self.faces if face.axis == j and _beside(face, floor, limits, k, small)
                ]
                left = [face.at for face in sides if face.at <= limits[0][j] + small]
                right = [face.at for face in sides if face.at >= limits[1][j] - small]
                low[j], high[j] = max(left, default=-math.inf), min(right, default=math.inf)
        return tuple(low), tuple(high)

    def _periodic(self, limits: Ends, k: int, floor: Face, cell: Direction, small: float) -> bool:
        """Whether a periodic cell has no side walls above the floor, and spheres are between its ends."""
        beside = [face for face in self.faces if face.axis != k and not _under(face, floor, limits, k, small)]
        return not beside and limits[0][k] >= -small and limits[1][k] <= cell[k] + small


def _under(face: Face, floor: Face, limits: Ends, k: int, small: float) -> bool:
    """Whether a side of a box is below its top, on which the spheres lie."""
    up = floor.at <= limits[0][k]
    return face.ends[1][k] <= floor.at + small if up else face.ends[0][k] >= floor.at - small


def _beside(face: Face, floor: Face, limits: Ends, k: int, small: float) -> bool:
    """Whether a side wall begins at the floor, and reaches along the spheres."""
    (other,) = [j for j in range(3) if j not in (k, face.axis)]
    low, high = face.ends
    reaches = low[other] <= limits[0][other] + small and high[other] >= limits[1][other] - small
    return reaches and low[k] - small <= floor.at <= high[k] + small


def _lowest(space: Ends, along: tuple[int, float]) -> float:
    """The lowest end, counted against gravity."""
    k, sign = along
    return min(sign * end[k] for end in space)


def _limits(space: Ends, along: tuple[int, float], at: float) -> Ends:
    """A space that reaches down to a floor."""
    return union([space, _flat(space, along[0], at)])


def _over(cell: Direction, space: Ends, k: int) -> Ends:
    """A periodic cell as high as a space along an axis."""
    low, high = (
        tuple(at if j == k else x for j, x in enumerate(end))
        for end, at in zip(((0.0,) * 3, cell), (space[0][k], space[1][k]), strict=True)
    )
    return low, high


def _flat(space: Ends, k: int, at: float) -> Ends:
    """A space without extent along an axis."""
    low, high = (tuple(at if j == k else x for j, x in enumerate(end)) for end in space)
    return low, high


def union(spaces: list[Ends]) -> Ends:
    """The smallest box around all."""
    lows, highs = zip(*spaces, strict=True)
    return tuple(map(min, *lows, lows[0])), tuple(map(max, *highs, highs[0]))


def axis_of(down: Direction, tilted: bool = False) -> tuple[int, float] | None:
    """The axis along which gravity is, or the nearest one if it may be tilted, and the sign of what is up."""
    axes = [k for k, part in enumerate(down) if abs(part) > (TILTED if tilted else ALONG)]
    return (axes[0], -1.0 if down[axes[0]] > 0.0 else 1.0) if axes else None


def vector(value: Any) -> Direction | None:
    """Three known numbers."""
    if isinstance(value, list | tuple) and len(value) == 3 and all(map(is_number, value)):
        return float(value[0]), float(value[1]), float(value[2])
    return None


def is_number(value: Any) -> bool:
    """Whether a value is a known number whose powers are finite."""
    return isinstance(value, int | float) and not isinstance(value, bool) and -LARGEST < value < LARGEST


def box_around(centre: Any, half: Any) -> Ends | None:
    """The ends of a box or a sphere; None if they are not known."""
    middle, sizes = vector(centre), vector(half)
    if middle is None or sizes is None or min(sizes) < 0.0:
        return None
    low, high = (tuple(c + sign * h for c, h in zip(middle, sizes, strict=True)) for sign in (-1.0, 1.0))
    return low, high


def faces_of(ends: Ends, mask: int = 63) -> Iterator[Face]:
    """Both faces of a box across each axis: those in the mask, in the order -x, +x, -y and so on."""
    for k in range(6):
        if mask >> k & 1:
            yield Face(k // 2, _flat(ends, k // 2, ends[k % 2][k // 2]))


def shape_of(instance: Instance) -> tuple[Ends, list[Face]] | None:
    """The ends of a wall, a box or facets, and their faces across the axes; None if they are not known."""
    name, attributes = instance.name, instance.attributes
    if TURNED & attributes.keys():
        return None
    if name == "wall":
        return _wall(instance)
    if name == "facet":
        vertices = instance.argument(0, "vertices")
        corners = [vector(corner) for corner in (vertices if isinstance(vertices, list | tuple) else ())]
        points = [(corner, corner) for corner in corners if corner is not None]
        return (union(points), []) if points and len(points) == len(corners) else None
    if name == "aabbWalls":
        return _six_walls(instance)
    if name == "facetCylinder":
        return _cylinder(instance)
    fixed = instance.argument(3, "fixed", False) in (True, 1) or attributes.get("dynamic") in (False, 0)
    ends = box_around(instance.argument(0, "center"), instance.argument(1, "extents"))
    mask = instance.argument(3, "wallMask", 63) if name == "facetBox" else 63
    turned = len(instance.arguments) > 2
    if name not in ("box", "facetBox") or ends is None or turned or not isinstance(mask, int):
        return None
    return (ends, [*faces_of(ends, mask)]) if name == "facetBox" or fixed else None


def flat_axis(ends: Ends) -> int | None:
    """The axis across which a facet with these ends lies; None if it is slanted."""
    axes = [k for k in range(3) if ends[0][k] == ends[1][k]]
    return axes[0] if len(axes) == 1 else None


def mask_of(instance: Instance) -> int | None:
    """Which parts of facets around the axis z there are; None for others, turned ones, or if it is not known."""
    if instance.name not in ROUND or "orientation" in instance.attributes:
        return None
    place, default = ROUND[instance.name]
    turned = any(isinstance(each, Instance) for each in instance.arguments)
    mask = instance.argument(place, "wallMask", default)
    return mask if isinstance(mask, int) and not turned else None


def _wall(instance: Instance) -> tuple[Ends, list[Face]] | None:
    """``wall(position, axis)``: an infinite plane."""
    place, axis = instance.argument(0, "position"), instance.argument(1, "axis")
    if axis not in (0, 1, 2) or isinstance(axis, bool):
        return None
    at = vector(place)[axis] if vector(place) is not None else place  # type: ignore[index]
    if not is_number(at):
        return None
    ends = _flat(((-math.inf,) * 3, (math.inf,) * 3), axis, float(at))
    return ends, [Face(axis, ends)]


def _six_walls(instance: Instance) -> tuple[Ends, list[Face]] | None:
    """``aabbWalls([low, high], thickness, oversizeFactor)``: six plates outside."""
    extrema, factor = instance.argument(0, "extrema"), instance.argument(2, "oversizeFactor", 1.5)
    corners = extrema if isinstance(extrema, list | tuple) and len(extrema) == 2 else (None, None)
    low, high = map(vector, corners)
    if low is None or high is None or not is_number(factor):
        return None
    if factor < 1.0 or any(a >= b for a, b in zip(low, high, strict=True)):
        return None
    middle = tuple(0.5 * (a + b) for a, b in zip(low, high, strict=True))
    wide = box_around(middle, tuple(0.5 * factor * (b - a) for a, b in zip(low, high, strict=True)))
    assert wide is not None
    plates = [Face(k, _flat(wide, k, end[k])) for k in range(3) for end in (low, high)]
    return (low, high), plates


def _cylinder(instance: Instance) -> tuple[Ends, list[Face]] | None:
    """``facetCylinder(center, radius, height)``; its closed ends as squares."""
    radius, height = instance.argument(1, "radius"), instance.argument(2, "height")
    number, mask = instance.argument(4, "segmentsNumber", 10), instance.argument(5, "wallMask", 7)
    turned = len(instance.arguments) > 3
    if turned or not (is_number(radius) and is_number(height) and radius > 0.0 and height > 0.0):
        return None
    if not isinstance(number, int) or number < 3 or not isinstance(mask, int):
        return None
    ends = box_around(instance.argument(0, "center"), (radius, radius, 0.5 * height))
    closed = (mask >> 1 & 1) << 4 | (mask & 1) << 5
    return None if ends is None else (ends, [*faces_of(ends, closed)])
