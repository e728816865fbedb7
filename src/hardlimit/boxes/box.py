"""The box: its edges, the boundary of each axis, gravity, and the numbers of its walls; checks of each."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..support import validation
from . import walls as moving_walls
from .walls import Walls

Floats = NDArray[np.float64]
#: One number for all axes, or one for each.
Vector = float | Sequence[float] | Floats

AXES: Final = moving_walls.AXES
#: Volume of a ball of radius 1, by dimension.
UNIT_BALL: Final = {2: math.pi, 3: 4.0 / 3.0 * math.pi}
BOUNDARIES: Final = ("periodic", "wall", "lees-edwards")
LARGEST: Final = moving_walls.LARGEST
#: Limits of radii and edges [m], as arguments of validation.
LENGTHS: Final[dict[str, Any]] = {
    "lowest": 1.0 / LARGEST,
    "highest": LARGEST,
    "lowest_allowed": True,
    "highest_allowed": True,
}
#: Latest time of a run [s]. Motion by the smallest length is then faster than 1e-90 m/s, and squares do not underflow.
LATEST: Final = 1e60
#: Shortest edge in units of the largest radius. A particle then touches at most one image of another particle, and at
#: most one of two opposite walls.
SHORTEST_EDGE: Final = {"periodic": 4, "wall": 2, "lees-edwards": 5}
#: Meaning of a wall's number, for the logs of all engines.
WALL_NUMBERS: Final = "−1 − 2·axis wall at 0, −2 − 2·axis at L"


@dataclass(frozen=True, eq=False)
class Box:
    """A rectangular box from 0 to ``edges``, with boundaries and gravity."""

    edges: Floats  #: (d,) [m]
    boundary: tuple[str, ...]  #: one of :data:`BOUNDARIES` for each axis
    gravity: Floats  #: (d,) [m/s²]
    moving: Walls = field(default_factory=dict)  #: the walls that move
    shear_rate: float = 0.0  #: of a Lees–Edwards boundary [1/s]
    shear_displacement: float = 0.0  #: of the images beyond its far side, along the first axis [m]

    @property
    def dimension(self) -> int:
        return len(self.edges)

    @property
    def periodic(self) -> list[bool]:
        return [side == "periodic" for side in self.boundary]

    @property
    def wraps(self) -> list[bool]:
        """For each axis, whether a particle that leaves through one side comes back through the other."""
        return [side != "wall" for side in self.boundary]

    @property
    def gradient(self) -> int | None:
        """The axis of the gradient in a sheared box, or None."""
        return self.boundary.index("lees-edwards") if "lees-edwards" in self.boundary else None

    def mean_flow(self, positions: Floats) -> Floats:
        """Velocity of the mean flow in a sheared box at positions (N, d) [m/s]: γ̇(y − L/2) along the first axis."""
        flow, axis = np.zeros_like(positions), self.gradient
        if axis is not None:
            flow[:, 0] = self.shear_rate * (positions[:, axis] - 0.5 * self.edges[axis])
        return flow

    @property
    def mean_spin(self) -> Floats:
        """Angular velocity (3,) at which the mean flow of a sheared box turns, half of its vorticity [rad/s]."""
        turning, axis = np.zeros(3), self.gradient
        if axis is not None:  # ∇ × v: −γ̇ along z for a gradient along y, γ̇ along y for one along z
            turning[3 - axis] = (-0.5 if axis == 1 else 0.5) * self.shear_rate
        return turning

    def displacement_after(self, time: float) -> float:
        """Displacement of the images beyond the far side of a sheared box after a time [m], in [0, edge)."""
        if self.gradient is None:
            return 0.0
        moved = self.shear_displacement + self.shear_rate * float(self.edges[self.gradient]) * time
        return moved % float(self.edges[0]) % float(self.edges[0])

    @property
    def volume(self) -> float:
        """Volume between the walls where they are [m³], in 2-D the area [m²]."""
        return math.prod(high - low for low, high in map(self.limits, range(self.dimension)))

    def mean_lengths(self, begin: Floats, end: Floats) -> Floats:
        """Mean length of each axis between two times (times, d) [m], for walls that move."""
        lengths = np.tile(self.edges, (len(begin), 1))
        for name, wall in self.moving.items():
            moved = wall.mean_displacement(begin, end)
            lengths[:, AXES.index(name[0])] += moved if name[1] == "+" else -moved
        return lengths

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

    def limits(self, axis: int, time: float = 0.0) -> tuple[float, float]:
        """The ends of an axis at a time [m]: 0 and the edge, or where the walls are."""
        ends = 0.0, float(self.edges[axis])
        names = (moving_walls.name_of(axis, upper) for upper in (False, True))
        at = [self.moving[name].displacement(time) if name in self.moving else 0.0 for name in names]
        return ends[0] + at[0], ends[1] + at[1]

    @property
    def fastest_wall(self) -> float:
        """Largest speed of a wall [m/s]."""
        return max((wall.fastest for wall in self.moving.values()), default=0.0)

    @property
    def resolved_until(self) -> float:
        """Time up to which a run resolves small speeds, the phases of walls and the places of sliding images [s]."""
        rates = [wall.frequency for wall in self.moving.values()]
        if self.gradient is not None:  # images pass each other
            rates.append(abs(self.shear_rate) * float(self.edges[self.gradient] / self.edges[0]))
        fastest = max(rates, default=0.0)
        return min(LATEST, moving_walls.MOST_PERIODS / fastest) if fastest > 0.0 else LATEST

    def has_moving_walls(self, axis: int) -> bool:
        return any(name[0] == AXES[axis] for name in self.moving)

    def of_core(self) -> _core.Box:
        """The box for the core, whose gravity is that in the frame of the common fall."""
        gravity = self.gravity - self.common_fall
        walls = list(moving_walls.of_core(self.moving))
        shear = (self.shear_rate, self.shear_displacement)
        # Images that are aligned and stay so are those of a periodic box.
        sides = [
            "periodic" if side == "lees-edwards" and shear == (0.0, 0.0) else side for side in self.boundary
        ]
        return _core.Box(self.edges.tolist(), sides, gravity.tolist(), walls, *shear)

    def fold(self, positions: Floats, velocities: Floats | None = None, time: float = 0.0) -> None:
        """Map positions [m] and velocities [m/s] of unfolded paths at a time [s] into the box, in place; (N, d) each.

        Only a sheared box uses velocities and time.
        """
        if (sheared := self.gradient) is not None:
            edge = float(self.edges[sheared])
            crossed = np.floor(positions[:, sheared] / edge)
            positions[:, sheared] -= crossed * edge
            np.clip(positions[:, sheared], 0.0, edge, out=positions[:, sheared])
            positions[:, 0] -= crossed * (self.shear_displacement + self.shear_rate * edge * time)
            if velocities is not None:
                velocities[:, 0] -= crossed * (self.shear_rate * edge)
        for axis, periodic in enumerate(self.periodic):
            x, edge = positions[:, axis], self.edges[axis]
            if periodic:
                x -= edge * np.floor(x / edge)
            if not self.has_moving_walls(axis):
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
            if not self.has_moving_walls(axis):
                continue
            names = (moving_walls.name_of(axis, upper) for upper in (False, True))
            low, high = (self.moving.get(name, moving_walls.MovingWall()) for name in names)
            narrowest = float(self.edges[axis]) + moving_walls.least_widening(low, high)
            if not narrowest >= 2.0 * largest_radius:
                raise ValueError(
                    f"walls: got a distance of {narrowest:.6g} m along {AXES[axis]} where they are closest, must be >= "
                    f"{validation.at_least(2.0 * largest_radius)}, the largest diameter"
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
    return np.array(validation.numbers("box", box, d, **LENGTHS))


def checked_boundary(boundary: Any, d: int) -> tuple[str, ...]:
    """The boundary of each axis, from one word or from one for each axis."""
    if isinstance(boundary, str):
        return (validation.one_of("boundary", boundary, BOUNDARIES),) * d
    sides = validation.instances("boundary", boundary, str, "word")
    if len(sides) != d:
        raise ValueError(f"boundary: got {len(sides)} words, must be 1, or {d}: one for each axis")
    return tuple(validation.one_of(f"boundary[{i}]", side, BOUNDARIES) for i, side in enumerate(sides))


def checked_shear(
    boundary: tuple[str, ...], rate: Any, displacement: Any, edges: Floats, gravity: Floats
) -> tuple[float, float]:
    """Shear rate [1/s] and displacement of the images [m], in [0, edge); both 0 without a Lees–Edwards boundary."""
    limits: dict[str, Any] = {"lowest": -LARGEST, "highest": LARGEST, "lowest_allowed": True}
    pair = (
        validation.number("shear_rate", rate, **limits),
        validation.number("shear_displacement", displacement, **limits),
    )
    sheared = boundary.count("lees-edwards")
    if not sheared:
        for name, value in zip(("shear_rate", "shear_displacement"), pair, strict=True):
            if value:
                raise ValueError(f"{name}: got {value:.16g}, must be 0 without the boundary 'lees-edwards'")
        return 0.0, 0.0
    axis = boundary.index("lees-edwards")
    if sheared > 1 or axis == 0 or boundary[0] != "periodic":
        raise ValueError(
            f"boundary: got {boundary}, must be 'periodic' along x and 'lees-edwards' along only one other axis"
        )
    for k in (0, axis):
        if gravity[k]:
            raise ValueError(
                f"gravity: got {gravity[k]:.16g} along {AXES[k]}, must be 0 along the flow and the gradient of a "
                "sheared box"
            )
    return pair[0] + 0.0, pair[1] % float(edges[0]) % float(edges[0])


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
