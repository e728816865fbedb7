"""Where a script of YADE has walls and makes spheres: how high they may lie, and on which area.

``utils.py`` and ``geom.py`` of YADE 2023.02a: wall, box, aabbWalls, facetBox, facetCylinder.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Final, NamedTuple

from .description import Direction
from .python import Instance

#: Cosine of the angle up to which gravity counts as along an axis.
ALONG: Final = 1.0 - 1e-6
#: Largest number whose third power is finite.
LARGEST: Final = 1e100
#: Rounding error of positions over the largest of them.
ROUNDING: Final = 1e-9
#: Arguments of facetBox and facetCylinder that turn them or leave out parts.
TURNED: Final = {"orientation", "angleRange", "closeGap", "radiusTopInner", "radiusBottomInner"}
#: The bit of the mask of a cylinder for its side.
SIDE: Final = 4

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
    plain: bool = True  #: whether all walls are such faces and cylinders
    spheres: list[Ends | None] = field(default_factory=list)  #: of each command; None if not known
    known: bool = True  #: whether all walls are known and at rest

    def add(self, instance: Instance) -> None:
        """A wall, a box or facets."""
        shape = shape_of(instance)
        if shape is None:
            self.known = False
            return
        ends, faces = shape
        (self.solid if instance.name == "box" else self.ends).append(ends)
        self.faces += faces
        if instance.name == "facetCylinder":
            radius, number = float(instance.argument(1, "radius")), instance.argument(4, "segmentsNumber", 10)
            area = 0.5 * number * radius**2 * math.sin(2.0 * math.pi / number)
            self.cylinders.append(Cylinder(ends, area, instance.argument(5, "wallMask", 7)))
        self.plain &= instance.name != "facet"

    @property
    def around(self) -> Ends | None:
        """The ends of all spheres; None if they are not known."""
        known = [ends for ends in self.spheres if ends is not None]
        return union(known) if known and len(known) == len(self.spheres) and self.known else None

    def height(self, down: Direction) -> float | None:
        """From the lowest end of walls to the highest one of the spheres when they are made: no bed is higher."""
        space, along = self.around, axis_of(down)
        if space is None or along is None:
            return None
        k, sign = along
        ends = [sign * end[k] for pair in self.ends for end in pair if math.isfinite(end[k])]
        tops = [max(sign * end[k] for end in pair) for pair in self.solid]
        bottom, height = min((*ends, *tops), default=math.inf), max(sign * end[k] for end in space)
        return height - bottom if bottom <= _lowest(space, along) + ROUNDING * abs(height) else None

    def floor(self, down: Direction, cell: Direction | None) -> float | None:
        """The area on which all spheres lie, across gravity; None if it is not known. ``cell``: if it is periodic."""
        space, along = self.around, axis_of(down)
        if space is None or along is None or not self.plain:
            return None
        k, sign = along
        numbers = [abs(x) for end in (*space, *(face.ends[0] for face in self.faces)) for x in end]
        small = ROUNDING * max(number for number in numbers if number < math.inf)
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


def _flat(space: Ends, k: int, at: float) -> Ends:
    """A space without extent along an axis."""
    low, high = (tuple(at if j == k else x for j, x in enumerate(end)) for end in space)
    return low, high


def union(spaces: list[Ends]) -> Ends:
    """The smallest box around all."""
    lows, highs = zip(*spaces, strict=True)
    return tuple(map(min, *lows, lows[0])), tuple(map(max, *highs, highs[0]))


def axis_of(down: Direction) -> tuple[int, float] | None:
    """The axis along which gravity is, and the sign of what is up."""
    axes = [k for k, part in enumerate(down) if abs(part) > ALONG]
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
