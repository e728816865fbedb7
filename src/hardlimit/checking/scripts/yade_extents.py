"""How far numbers drawn at random, predicates, surfaces and files of meshes reach in scripts of YADE.

``pack.py``, ``geom.py``, ``ymport.py`` and the predicates of ``pack`` in YADE 2023.02a. What is turned is taken as the
ball around it: the ends are those that it does not exceed.
"""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any, Final

import numpy as np

from . import meshes
from .commands import text_of
from .description import Direction, Range
from .python import Instance, Unknown
from .yade_container import LARGEST, Ends, Face, box_around, is_number, shape_of, union, vector

#: Functions of random numbers without arguments, and those between their first two.
UNIT: Final = ("random", "rand", "random_sample")
BETWEEN: Final = ("uniform", "randint", "randrange")
ANY: Final = ("gauss", "normalvariate", "normal", "randn")
OPERATORS: Final[dict[type, Callable[[float, float], float]]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
#: Methods that leave a surface or a pack where it is.
UNMOVED: Final = ("is_closed", "aabb", "dim", "center", "volume", "write", "coarsen")
#: Objects that draw numbers at random.
GENERATORS: Final = ("default_rng", "Random", "RandomState")
#: Arguments of cylindrical predicates.
CAPS: Final = ("centerBottom", "centerTop")


@dataclass(frozen=True)
class Drawn(Unknown):
    """A number drawn at random, of which only the ends are known."""

    low: float = -math.inf
    high: float = math.inf


@dataclass(frozen=True)
class Centre(Unknown):
    """A centre of a sphere in a loop over a SpherePack, all of which are between these ends."""

    ends: tuple[Ends | None, ...] = (None,)


# --- numbers drawn at random ------------------------------------------------------------------------------------


def draw(name: str, owner: Any, instance: Instance) -> Drawn | None:
    """The value of a function of random numbers; None for other functions."""
    arguments, module = instance.arguments, owner.rpartition(".")[2] if isinstance(owner, str) else ""
    generator = isinstance(owner, Instance) and owner.name in GENERATORS
    if not (owner is None or generator or module in ("random", "pylab")):
        return None
    if name in UNIT and not arguments and not instance.attributes:
        return Drawn(instance.text, 0.0, 1.0)
    number = 3 if name == "randrange" and len(arguments) == 3 else 2
    if (
        name in BETWEEN
        and len(arguments) == number
        and all(map(is_number, arguments))
        and not instance.attributes
    ):
        return Drawn(instance.text, *sorted(map(float, arguments[:2])))
    if name in ANY:
        return Drawn(instance.text)
    return None


def span(value: Any) -> Range | None:
    """The ends of a number; None if they are not known."""
    if isinstance(value, Drawn):
        return value.low, value.high
    return (float(value), float(value)) if is_number(value) else None


def computed(left: Any, sign: ast.operator, right: Any, text: str) -> Any:
    """The value of an operation with what is drawn, with centres, predicates or bodies; None for others."""
    if isinstance(left, Drawn) or isinstance(right, Drawn):
        first, second, of = span(left), span(right), OPERATORS.get(type(sign))
        if first is None or second is None or of is None:
            return None
        if of is operator.truediv and second[0] <= 0.0 <= second[1]:
            return None
        values = [of(a, b) for a, b in product(first, second)]
        known = not any(map(math.isnan, values))
        return Drawn(text, min(values), max(values)) if known else Drawn(text)
    if isinstance(left, Centre) and isinstance(sign, ast.Add | ast.Sub):
        by = vector(right)
        turned = 1.0 if isinstance(sign, ast.Add) else -1.0
        return None if by is None else Centre(text, tuple(shifted(ends, by, turned) for ends in left.ends))
    if isinstance(left, Instance) and isinstance(right, Instance) and is_space(left) and is_space(right):
        return Instance("space", (), {"ends": both(left, sign, right)}, left.line, text)
    return None


def shifted(ends: Ends | None, by: Sequence[float], sign: float = 1.0) -> Ends | None:
    """Ends moved by a vector."""
    if ends is None:
        return None
    low, high = (tuple(x + sign * d for x, d in zip(end, by, strict=True)) for end in ends)
    return low, high


# --- predicates and surfaces ------------------------------------------------------------------------------------


def is_space(instance: Instance) -> bool:
    """Whether this is a predicate."""
    return instance.name == "space" or re.match(r"(in|notIn)[A-Z]", instance.name) is not None


def both(left: Instance, sign: ast.operator, right: Instance) -> Ends | None:
    """The ends of a difference, an intersection or a union of predicates; None if they are not known."""
    ends = ends_of_space(left), ends_of_space(right)
    if isinstance(sign, ast.Sub):
        return ends[0]
    if isinstance(sign, ast.BitAnd):
        return common(*ends)
    return None if ends[0] is None or ends[1] is None else union([ends[0], ends[1]])


def common(first: Ends | None, second: Ends | None) -> Ends | None:
    """What two spaces have in common; of an unknown one, all of the other."""
    if first is None or second is None:
        return first or second
    low = tuple(map(max, first[0], second[0]))
    return low, tuple(map(max, low, map(min, first[1], second[1])))


def ends_of_space(space: Any) -> Ends | None:
    """The ends of a predicate or a surface; None if they are not known."""
    if not isinstance(space, Instance):
        return None
    if "ends" in space.attributes:
        return space.attributes["ends"]  # type: ignore[no-any-return]
    name, at = space.name, [vector(argument) for argument in space.arguments]
    first = at[0] if at else None
    if name == "inAlignedBox":
        low, high = (vector(space.argument(k, word)) for k, word in enumerate(("minAABB", "maxAABB")))
        return None if low is None or high is None else (low, high)
    if name == "inSphere":
        return box_around(space.argument(0, "center"), (space.argument(1, "radius"),) * 3)
    if name == "inEllipsoid":
        return box_around(space.argument(0, "centerPoint"), space.argument(1, "abc"))
    if name in ("inCylinder", "inHyperboloid"):
        radius = space.argument(2, "radius")
        caps = [box_around(space.argument(k, word), (radius,) * 3) for k, word in enumerate(CAPS)]
        return union([cap for cap in caps if cap is not None]) if None not in caps else None
    if name == "inParallelepiped" and first is not None and len(at) == 4 and None not in at:
        edges = [tuple(b - a for a, b in zip(first, end, strict=True)) for end in at[1:] if end is not None]
        corners = [
            tuple(
                first[k] + sum(on * edge[k] for on, edge in zip(each, edges, strict=True)) for k in range(3)
            )
            for each in product((0, 1), repeat=3)
        ]
        return ends_of_points(corners)
    if name == "inGtsSurface":
        return ends_of_space(space.argument(0, "surface"))
    if name == "sweptPolylines2gtsSurface":
        return ends_of_points(points_in(space.argument(0, "pts")))
    if name == "Vertex":
        return ends_of_points([vector(space.arguments)])
    if name in ("Edge", "Face"):
        return all_of([*map(ends_of_space, space.arguments)])
    return None


def points_in(values: Any) -> Iterable[Any]:
    """The points in nested lists."""
    for value in values if isinstance(values, list | tuple) else [None]:
        if isinstance(value, list | tuple) and value and all(isinstance(x, list | tuple) for x in value):
            yield from points_in(value)
        else:
            yield vector(value)


def ends_of_points(points: Iterable[Any]) -> Ends | None:
    """The ends of points; None if one of them is not known."""
    pairs = [None if point is None else (point, point) for point in points]
    known = [pair for pair in pairs if pair is not None]
    return union(known) if known and len(known) == len(pairs) else None


def moved(space: Instance, name: str, instance: Instance) -> None:
    """A method of a surface, which may move it or add to it."""
    if name in UNMOVED:
        return
    arguments, ends = instance.arguments, ends_of_space(space)
    by = vector(arguments if len(arguments) == 3 else instance.argument(0, "translation"))
    after: Ends | None = None
    if name in ("add", "copy"):  # of a face, or of all faces of a surface
        empty = space.name == "Surface" and "ends" not in space.attributes
        after = all_of([*map(ends_of_space, arguments), *([] if empty else [ends])])
    elif ends is None:
        after = None
    elif name == "scale" and by is not None:
        after = ends_of_points([vector([a * b for a, b in zip(end, by, strict=True)]) for end in ends])
    elif name == "rotate" and len(arguments) == 4:
        after = around_ball(ends, (0.0, 0.0, 0.0))
    elif name == "translate" and by is not None:
        after = shifted(ends, by)
    space.attributes["ends"] = after


def all_of(parts: Sequence[Ends | None]) -> Ends | None:
    """The smallest box around all; None if one of them is not known."""
    known = [part for part in parts if part is not None]
    return union(known) if known and len(known) == len(parts) else None


def around_ball(ends: Ends, centre: Sequence[float] | None = None) -> Ends:
    """The box around what is between these ends, however it is turned about a centre, by default its middle."""
    middle = tuple(0.5 * (a + b) for a, b in zip(*ends, strict=True)) if centre is None else tuple(centre)
    corners = product(*zip(*ends, strict=True))
    radius = max(math.dist(corner, middle) for corner in corners)
    turned = box_around(middle, (radius,) * 3)
    return ends if turned is None else turned


# --- facets and meshes ------------------------------------------------------------------------------------------


def ends_of_facets(instance: Instance, folder: Path | None) -> Ends | None:
    """The ends of facets that a function makes or reads from a file; None if they are not known."""
    name, centre = instance.name, vector(instance.argument(0, "center"))
    if name == "gtsSurface2Facets":
        return ends_of_space(instance.argument(0, "surf"))
    if name in ("stl", "gmsh"):
        return ends_of_mesh(instance, folder)

    def number(place: int, word: str, default: float | None = None) -> float:
        value = instance.argument(place, word, default)
        return float(value) if is_number(value) else math.inf

    radius = height = math.inf
    bottom = 0.0
    if name in ("facetBox", "facetParallelepiped", "box"):
        half = vector(instance.argument(1, "extents"))
        ends, turn = box_around((0.0,) * 3, half), turn_of(instance)
        if ends is None or centre is None:
            return None
        if turn is None or name == "facetParallelepiped":
            return shifted(around_ball(ends), centre)
        return shifted(ends_of_rows(np.array([*product(*zip(*ends, strict=True))]) @ turn.T), centre)
    if name == "facetSphere":
        radius = number(1, "radius")
        height, bottom = 2.0 * radius, -radius
    elif name == "facetCylinder":
        radius, height = number(1, "radius"), number(2, "height")
        bottom = -0.5 * height
    elif name == "facetCone":
        radius, height = max(number(1, "radiusTop"), number(2, "radiusBottom")), number(3, "height")
        bottom = -0.5 * height
    elif name == "facetBunker":
        radius = 0.5 * max(number(1, "dBunker"), number(2, "dOutput"))
        height = number(3, "hBunker") + number(4, "hOutput") + number(5, "hPipe", 0.0)
    if centre is None or not abs(radius) + abs(height) < LARGEST:
        return None
    turn = turn_of(instance)
    if turn is None:
        box = (-radius, -radius, bottom), (radius, radius, bottom + height)
        return shifted(around_ball(box, (0.0,) * 3), centre)
    wide = radius * np.sqrt(np.maximum(1.0 - turn[:, 2] ** 2, 0.0))  # of a disk across the turned axis z
    rims = [turn[:, 2] * z + sign * wide for z in (bottom, bottom + height) for sign in (-1.0, 1.0)]
    return shifted(ends_of_rows(np.array(rims)), centre)


def turn_of(instance: Instance) -> np.ndarray | None:
    """The matrix of ``orientation=Quaternion(axis, angle)``, also of its arguments in turn; None if it is not known."""
    turned = instance.attributes.get("orientation")
    if turned is None:
        placed = [each for each in instance.arguments[2:] if isinstance(each, Instance | Unknown)]
        return None if placed else np.eye(3)
    arguments = turned.arguments if isinstance(turned, Instance) and turned.name == "Quaternion" else ()
    axes, angles = [vector(each) for each in arguments], [each for each in arguments if is_number(each)]
    axis = next((np.array(each) for each in axes if each is not None and any(each)), None)
    if len(arguments) != 2 or axis is None or len(angles) != 1:
        return None
    from scipy.spatial.transform import Rotation  # which other uses must not wait for

    # YADE makes a quaternion of unit length from (cos α/2, axis sin α/2), whatever the length of the axis.
    half = 0.5 * angles[0]
    return np.asarray(Rotation.from_quat([*(math.sin(half) * axis), math.cos(half)]).as_matrix())


def ends_of_rows(points: np.ndarray) -> Ends:
    """The ends of points in rows."""
    return tuple(map(float, points.min(axis=0))), tuple(map(float, points.max(axis=0)))


def triangles_of(instance: Instance, folder: Path | None) -> np.ndarray | None:
    """The triangles of facets that are not turned, corners by axes; None if they are not known."""
    name = instance.name
    if name == "stl":
        mesh, turn = points_of_mesh(instance, folder), turn_of(instance)
        return None if mesh is None or turn is None else (mesh[0] @ turn.T + mesh[1]).reshape(-1, 3, 3)
    if name == "facet":
        corners = [vector(corner) for corner in instance.argument(0, "vertices") or ()]
        return np.array([corners]) if len(corners) == 3 and None not in corners else None
    shape = shape_of(instance) if name == "facetBox" else None
    if shape is not None:
        return np.array([triangle for face in shape[1] for triangle in halves(face)]).reshape(-1, 3, 3)
    surface = instance.argument(0, "surf") if name == "gtsSurface2Facets" else None
    if not isinstance(surface, Instance) or surface.name != "sweptPolylines2gtsSurface":
        return None
    return None if "ends" in surface.attributes else swept(surface)


def halves(face: Face) -> list[list[Direction]]:
    """The two triangles of a rectangle."""
    j, k = (axis for axis in range(3) if axis != face.axis)
    low, high = face.ends
    corners = []
    for end_j, end_k in ((low, low), (high, low), (high, high), (low, high)):
        corner = list(low)
        corner[j], corner[k] = end_j[j], end_k[k]
        corners.append(tuple(corner))
    return [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]


def swept(surface: Instance) -> np.ndarray | None:
    """The triangles of ``sweptPolylines2gtsSurface``: between lines, and at its ends fans from their first points."""
    lines = surface.argument(0, "pts")
    try:
        points = np.array([[vector(point) for point in line] for line in lines], float)
    except (TypeError, ValueError):
        return None
    if points.ndim != 3 or not np.isfinite(points).all():
        return None
    a, b, c, d = points[:-1, :-1], points[:-1, 1:], points[1:, :-1], points[1:, 1:]
    triangles = [np.stack(each, axis=2).reshape(-1, 3, 3) for each in ((a, b, d), (a, d, c))]
    for k, (place, name) in enumerate(((0, "capStart"), (-1, "capEnd"))):
        if surface.argument(2 + k, name, False) not in (False, 0):
            end = points[place]
            triangles += [np.array([[end[0], end[j], end[j + 1]] for j in range(1, len(end) - 1)])]
    return np.concatenate([each.reshape(-1, 3, 3) for each in triangles])


def ends_of_mesh(instance: Instance, folder: Path | None) -> Ends | None:
    """The ends of a mesh in a file beside the script; None if they are not known."""
    mesh, turn = points_of_mesh(instance, folder), turn_of(instance)
    if mesh is None:
        return None
    points, by = mesh
    if turn is None:
        return shifted(around_ball(ends_of_rows(points), (0.0,) * 3), by)
    return shifted(ends_of_rows(points @ turn.T), by)


def points_of_mesh(instance: Instance, folder: Path | None) -> tuple[np.ndarray, Direction] | None:
    """The vertices in a file beside the script before they are turned, and by what they are moved then.

    None if the file is not there, or not understood.
    """
    name = instance.argument(0, "file" if instance.name == "stl" else "meshfile")
    scale, by = (
        instance.attributes.get("scale", 1.0),
        vector(instance.attributes.get("shift", (0.0, 0.0, 0.0))),
    )
    placed = len(instance.arguments) == 1 or not instance.arguments
    if folder is None or not isinstance(name, str) or not is_number(scale) or by is None or not placed:
        return None
    points = vertices(folder / name, instance.name)
    if points is None or not len(points) or not np.isfinite(points).all():
        return None
    return scale * points, by


def vertices(path: Path, kind: str) -> np.ndarray | None:
    """The vertices in a file of STL or GMSH's ``.mesh``; None if it cannot be read."""
    if kind == "stl":
        corners = meshes.read(path)
        return None if corners is None else corners.reshape(-1, 3)
    try:
        lines = (text_of(path) or "").splitlines()
        start = next(k for k, line in enumerate(lines) if line.split() == ["Vertices"]) + 2
        rows = [line.split()[:3] for line in lines[start : start + int(lines[start - 1])]]
        return np.array(rows, float).reshape(-1, 3)
    except (ValueError, IndexError, StopIteration):
        return None
