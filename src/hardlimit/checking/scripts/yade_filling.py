"""What a script of YADE fills its cell with, the speeds of impacts that it states, and files of spheres beside it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from . import census
from .commands import text_of
from .description import Contents, Direction, Range, Speed, Stage
from .python import Instance, flat

#: Cosine of the angle up to which gravity counts as along an axis.
ALONG: Final = 1.0 - 1e-6
#: Largest number whose third power is finite.
LARGEST: Final = 1e100
#: Functions of ``ymport`` whose files have lines ``x y z r``.
TEXTS: Final = ("text", "textExt")


@dataclass
class YadeFilling:
    """The cell, the spheres that are made, where they are and how they move."""

    census: census.Census = field(default_factory=census.Census)
    cell: tuple[float, ...] | None = None  #: edges of the periodic cell
    periodic: bool = False
    places: list[tuple[Direction, Direction]] = field(default_factory=list)  #: where spheres are made
    floors: list[tuple[Direction, Direction]] = field(
        default_factory=list
    )  #: ends of walls, boxes and facets
    velocities: dict[int, Direction] = field(default_factory=dict)  #: of single bodies
    known: bool = True  #: whether no velocity is unknown

    def contents(self, stage: Stage) -> Contents:
        """What a run has in its cell, and the speeds that are stated for it."""
        volume = math.prod(self.cell) if self.periodic and self.cell else None
        speeds = [*falls(self, stage), *(relative(self) if self.known else ())]
        return Contents(self.census.count, self.census.filled(3), volume, tuple(speeds))


def vector(value: Any) -> Direction | None:
    """Three known numbers."""
    if isinstance(value, list | tuple) and len(value) == 3 and all(map(is_number, value)):
        return float(value[0]), float(value[1]), float(value[2])
    return None


def is_number(value: Any) -> bool:
    """Whether a value is a known number whose powers are finite."""
    return isinstance(value, int | float) and not isinstance(value, bool) and -LARGEST < value < LARGEST


def cloud(filling: YadeFilling, pack: Instance, instance: Instance) -> float | None:
    """The number of spheres of ``makeCloud``, and where they are."""
    corners = [vector(instance.argument(k, name)) for k, name in enumerate(("minCorner", "maxCorner"))]
    if corners[0] is None and not instance.arguments and "minCorner" not in instance.attributes:
        corners[0] = (0.0, 0.0, 0.0)
    if corners[0] is not None and corners[1] is not None:
        filling.places.append((corners[0], corners[1]))
        if instance.argument(5, "periodic", False) in (True, 1):
            pack.attributes["cell"] = tuple(b - a for a, b in zip(*corners, strict=True))
    number = instance.argument(4, "num", -1)
    return float(number) if is_number(number) and number > 0 else None


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
    axes = [k for k, part in enumerate(stage.down or ()) if abs(part) > ALONG]
    if not axes or not stage.gravity or stage.down is None:
        return
    k, sign = axes[0], -1.0 if stage.down[axes[0]] > 0.0 else 1.0
    tops = [max(sign * low[k], sign * high[k]) for low, high in filling.places]
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


def lot_of(radii: Sequence[float]) -> census.Lot:
    """Spheres of known radii."""
    squares, cubes = (math.fsum(radius**p for radius in radii) for p in (2, 3))
    return census.Lot(0, float(len(radii)), squares, cubes)


def uniform(count: float | None, radii: Range | None) -> census.Lot:
    """Spheres whose radii are uniform in a range."""
    return census.lot(0, count, None if radii is None else census.moments(radii))


def volume_of(matrix: Any) -> tuple[float, ...] | None:
    """The volume of a cell from ``Matrix3`` of its edges; None if it is not known."""
    if not isinstance(matrix, Instance) or len(parts := flat([matrix.arguments])) != 9:
        return None
    if not all(map(is_number, parts)):
        return None
    a, b, c, d, e, f, g, h, i = map(float, parts)
    return (abs(a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)),)
