"""What a script of YADE fills its cell with, the speeds of impacts that it states, and files of spheres beside it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

from . import census
from .commands import text_of
from .description import Contents, Direction, Lot, Range, Speed, Stage
from .python import Instance, flat
from .yade_container import Container, Ends, axis_of, box_around, is_number, vector

#: Fewest spheres in one stack that are taken as a bed.
PILE: Final = 10
#: Porosity of ``makeCloud`` by default, and from which on it makes no spheres smaller.
POROSITY, LOOSE = 0.65, 0.75
#: Functions of ``ymport`` whose files have lines ``x y z r``.
TEXTS: Final = ("text", "textExt")


@dataclass
class YadeFilling:
    """The cell, the spheres that are made, where they are and how they move."""

    census: census.Census = field(default_factory=census.Census)
    cell: tuple[float, ...] | None = None  #: edges of the periodic cell
    periodic: bool = False
    #: Where centres of spheres are made, and their radius; of a cloud, its corners and 0.
    places: list[tuple[Direction, Direction, float]] = field(default_factory=list)
    #: Ends of walls, boxes and facets.
    floors: list[tuple[Direction, Direction]] = field(default_factory=list)
    velocities: dict[int, Direction] = field(default_factory=dict)  #: of single bodies
    known: bool = True  #: whether no velocity is unknown
    container: Container = field(default_factory=Container)

    def contents(self, stage: Stage) -> Contents:
        """What a run has in its cell, and the speeds that are stated for it."""
        volume = math.prod(self.cell) if self.periodic and self.cell else None
        speeds = [*falls(self, stage), *(relative(self) if self.known else ())]
        lots = self.census.known
        return Contents(self.census.count, self.census.filled(3), volume, tuple(speeds), lots=lots)

    def bed(self, contents: Contents, down: Direction) -> Contents:
        """With the area on which the spheres lie, and the height above which none of them comes to rest."""
        cell = self.cell if self.periodic else None
        if self.periodic and (cell is None or len(cell) != 3):
            return contents
        floor, height = self.container.floor(down, cell), self.container.height(down)
        if height is None or (cell is not None and floor is None):
            return contents
        source = "from the floor to where spheres are made"
        if contents.count and contents.filled:
            diameter = 2.0 * (0.75 / math.pi * contents.filled / contents.count) ** (1.0 / 3.0)
            if contents.count * diameter < height and contents.count < PILE:
                return contents
            if contents.count * diameter < height:
                height, source = contents.count * diameter, "of spheres in one stack"
        return replace(contents, floor=floor, walled=cell is None, height=height, height_from=source)


def corners_of(instance: Instance) -> list[Direction | None]:
    """The corners of ``makeCloud``."""
    corners = [vector(instance.argument(k, name)) for k, name in enumerate(("minCorner", "maxCorner"))]
    if corners[0] is None and not instance.arguments and "minCorner" not in instance.attributes:
        corners[0] = (0.0, 0.0, 0.0)
    return corners


def ends_of(instance: Instance, name: str = "") -> Ends | None:
    """Where ``makeCloud``, ``sphere``, ``add``, or a simple cubic packing in a box makes spheres.

    None if it is not known, and of packings that may be denser than a bed.
    """
    if (name or instance.name) == "makeCloud":
        low, high = corners_of(instance)
        known = low is not None and high is not None and "hSize" not in instance.attributes
        return (low, high) if known and low is not None and high is not None else None
    if (name or instance.name) in ("sphere", "add"):
        radius = instance.argument(1, "radius")
        return box_around(instance.argument(0, "center"), (radius,) * 3)
    space = instance.argument(0, "predicate")
    loose = (name or instance.name) == "regularOrtho"
    if not loose or not isinstance(space, Instance) or space.name != "inAlignedBox":
        return None
    low, high = (vector(space.argument(k, name)) for k, name in enumerate(("minAABB", "maxAABB")))
    return None if low is None or high is None else (low, high)


def cloud(filling: YadeFilling, pack: Instance, instance: Instance) -> float | None:
    """The number of spheres of ``makeCloud``, and where they are."""
    corners = corners_of(instance)
    if corners[0] is not None and corners[1] is not None:
        filling.places.append((corners[0], corners[1], 0.0))
        if instance.argument(5, "periodic", False) in (True, 1):
            pack.attributes["cell"] = tuple(b - a for a, b in zip(*corners, strict=True))
    number = instance.argument(4, "num", -1)
    return float(number) if is_number(number) and number > 0 else None


def mean_radius(instance: Instance) -> Any:
    """``rMean`` of ``makeCloud``. If it is not positive, YADE takes the one with which ``num`` spheres have a porosity.

    V (1 − porosity) = num 4/3 π r³ (1 + fuzz²), and smaller spheres if they find no place. That is not so from a
    porosity of :data:`LOOSE` on: of its 1000 tries for each sphere, 30 succeed.
    """
    mean, number = instance.argument(2, "rMean", -1), instance.argument(4, "num", -1)
    corners = [corner for corner in corners_of(instance) if corner is not None]
    fuzz, porosity = instance.argument(3, "rRelFuzz", 0.0), instance.argument(6, "porosity", POROSITY)
    if not is_number(mean) or mean > 0.0 or len(corners) < 2 or "hSize" in instance.attributes:
        return mean
    volume = math.prod(b - a for a, b in zip(*corners, strict=True))
    known = is_number(number) and is_number(fuzz) and is_number(porosity)
    if not known or number <= 0 or volume <= 0.0 or not LOOSE <= porosity < 1.0:
        return None
    return (0.75 * volume * (1.0 - porosity) / (math.pi * (1.0 + fuzz * fuzz) * number)) ** (1.0 / 3.0)


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
    elif instance.name == "facet":
        vertices = instance.argument(0, "vertices")
        corners = [vector(corner) for corner in (vertices if isinstance(vertices, list | tuple) else ())]
        known = [corner for corner in corners if corner is not None]
        if known and len(known) == len(corners):
            axes = list(zip(*known, strict=True))
            filling.floors.append(((*map(min, axes),), (*map(max, axes),)))
    elif (centre := vector(first)) is not None and (half := vector(second)) is not None:
        ends = [tuple(c + sign * h for c, h in zip(centre, half, strict=True)) for sign in (-1.0, 1.0)]
        if instance.name == "facetBox":  # hollow: its bottom
            ends[1] = ends[0]
        filling.floors.append((ends[0], ends[1]))


def falls(filling: YadeFilling, stage: Stage) -> Iterator[Speed]:
    """The speed with which the highest sphere reaches the highest obstacle below it."""
    along = axis_of(stage.down or ())
    if along is None or not stage.gravity:
        return
    k, sign = along
    tops = [max(sign * low[k], sign * high[k]) - radius for low, high, radius in filling.places]
    ends = [max(sign * low[k], sign * high[k]) for low, high in filling.floors]
    for top in tops:
        below = [end for end in ends if end < top]
        if below and math.isfinite(top - max(below)):
            height = top - max(below)
            source = "the fall of {height} from where spheres are made"
            yield Speed(math.sqrt(2.0 * stage.gravity * height), source, height)


def relative(filling: YadeFilling) -> Iterator[Speed]:
    """The largest relative velocity of bodies whose velocities are set, and of those at rest."""
    velocities = [*filling.velocities.values(), (0.0, 0.0, 0.0)]
    largest = max(math.dist(a, b) for a in velocities for b in velocities)
    if largest > 0.0:
        yield Speed(largest, "the velocities that are set")


def radii_in(folder: Path | None, instance: Instance, pack: bool) -> list[float] | None:
    """Radii in a file of spheres beside the script; None if it is not there, or not understood."""
    name = instance.argument(0, "fileName")
    scale = 1.0 if pack else instance.argument(2, "scale", 1.0)
    form = instance.argument(1, "format", "x_y_z_r") if instance.name == "textExt" else "x_y_z_r"
    if instance.name == "textExt":
        scale = instance.argument(3, "scale", 1.0)
    if folder is None or not isinstance(name, str) or not is_number(scale) or form != "x_y_z_r":
        return None
    text = text_of(folder / name)
    lines = [] if text is None else [line.split() for line in text.splitlines()]
    try:
        if any(words[:1] == ["#format"] and words[1:] != ["x_y_z_r"] for words in lines):
            return None
        radii = [scale * float(words[3]) for words in lines if words and not words[0].startswith("#")]
    except (IndexError, ValueError):
        return None
    return radii if radii and all(0.0 < radius < math.inf for radius in radii) else None


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
