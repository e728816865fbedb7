"""The box: its edges, the boundary of each axis, gravity, and the numbers of its walls; checks of each."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..support import validation

Floats = NDArray[np.float64]
#: One number for all axes, or one for each.
Vector = float | Sequence[float] | Floats

AXES: Final = ("x", "y", "z")
#: Volume of a ball of radius 1, by dimension.
UNIT_BALL: Final = {2: math.pi, 3: 4.0 / 3.0 * math.pi}
BOUNDARIES: Final = ("periodic", "wall")
#: Largest length, speed and acceleration: the squares of larger ones would overflow.
LARGEST: Final = 1e100
#: Shortest edge in units of the largest radius. A particle then touches at most one image of another particle, and at
#: most one of two opposite walls.
SHORTEST_EDGE: Final = {"periodic": 4, "wall": 2}
#: Meaning of a wall's number, for the logs of all engines.
WALL_NUMBERS: Final = "−1 − 2·axis wall at 0, −2 − 2·axis at L"


@dataclass(frozen=True, eq=False)
class Box:
    """A rectangular box from 0 to ``edges``, with boundaries and gravity."""

    edges: Floats  #: (d,) [m]
    boundary: tuple[str, ...]  #: ``"periodic"`` or ``"wall"`` for each axis
    gravity: Floats  #: (d,) [m/s²]

    @property
    def dimension(self) -> int:
        return len(self.edges)

    @property
    def periodic(self) -> list[bool]:
        return [side == "periodic" for side in self.boundary]

    @property
    def volume(self) -> float:
        """Volume [m³], in 2-D the area [m²]."""
        return float(np.prod(self.edges))

    @property
    def common_fall(self) -> Floats:
        """Gravity along the periodic axes (d,) [m/s²], 0 along the others. It accelerates all particles equally."""
        return np.where(self.periodic, self.gravity, 0.0)

    def walls(self) -> Iterator[tuple[int, int, bool]]:
        """For each wall: its number, its axis, and whether it is the upper one."""
        for axis, side in enumerate(self.boundary):
            if side == "wall":
                yield -1 - 2 * axis, axis, False
                yield -2 - 2 * axis, axis, True

    def of_core(self) -> _core.Box:
        """The box for the core, whose gravity is that in the frame of the common fall."""
        gravity = self.gravity - self.common_fall
        return _core.Box(self.edges.tolist(), list(self.boundary), gravity.tolist())

    def fold(self, positions: Floats) -> None:
        """Map unfolded positions (N, d) [m] into the box, in place."""
        for axis, periodic in enumerate(self.periodic):
            x, edge = positions[:, axis], self.edges[axis]
            if periodic:
                x -= edge * np.floor(x / edge)
            np.clip(x, 0.0, edge, out=x)

    def check_size(self, largest_radius: float) -> None:
        """Refuse a box in which a particle could touch two images of another one, or two opposite walls."""
        for axis, side in enumerate(self.boundary):
            radii = SHORTEST_EDGE[side]
            if not self.edges[axis] >= radii * largest_radius:
                raise ValueError(
                    f"box: got {self.edges[axis]:.16g} along {AXES[axis]} ({side}), must be >= "
                    f"{validation.at_least(radii * largest_radius)}, {radii} times the largest radius"
                )


def component_axes(dimension: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """First and second axis of each component of a symmetric tensor, in LAMMPS' order: xx, yy, zz, xy, xz, yz."""
    equal, (first, second) = np.arange(dimension), np.triu_indices(dimension, 1)
    return np.concatenate([equal, first]), np.concatenate([equal, second])


def wall_name(number: int) -> str:
    """Name of a wall, such as ``z = 0``, from its number in logs: −1 − 2·axis at 0, −2 − 2·axis at the edge."""
    axis, upper = divmod(-1 - number, 2)
    return f"{AXES[axis]} = {'L' if upper else '0'}"


def checked_edges(box: Any, d: int) -> Floats:
    """Edges [m] from one number, or from one for each axis."""
    return np.array(validation.numbers("box", box, d, lowest=0.0, highest=LARGEST, highest_allowed=True))


def checked_boundary(boundary: Any, d: int) -> tuple[str, ...]:
    """The boundary of each axis, from one word or from one for each axis."""
    if isinstance(boundary, str):
        return (validation.one_of("boundary", boundary, BOUNDARIES),) * d
    sides = validation.instances("boundary", boundary, str, "word")
    if len(sides) != d:
        raise ValueError(f"boundary: got {len(sides)} words, must be 1, or {d}: one for each axis")
    return tuple(validation.one_of(f"boundary[{i}]", side, BOUNDARIES) for i, side in enumerate(sides))


def checked_gravity(gravity: Any, d: int) -> Floats:
    """Gravity as a vector [m/s²]; one number g is (0, …, −g)."""
    limits = {"lowest": -LARGEST, "highest": LARGEST, "lowest_allowed": True, "highest_allowed": True}
    values = validation.numbers("gravity", gravity, d, **limits)
    if np.ndim(gravity) == 0:
        return np.array([0.0] * (d - 1) + [-values[0] if values[0] else 0.0])
    return np.array(values)


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    array.flags.writeable = False
    return array
