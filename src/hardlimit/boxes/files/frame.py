"""A frame of a file: a box of grains at one instant."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from ...support.saving import write_all
from .. import spins
from ..thermostats import Andersen, RandomKicks
from ..walls import MovingWall

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Frame:
    """The values of a ParticleSystem and the time."""

    positions: Floats  #: (N, d) [m]
    velocities: Floats  #: (N, d) [m/s]
    radius: Floats  #: (N,) [m]
    mass: Floats  #: (N,) [kg]
    box: Floats  #: (d,) [m]
    boundary: tuple[str, ...]  #: "periodic", "wall" or "lees-edwards" for each axis
    gravity: Floats  #: (d,) [m/s²]
    walls: Mapping[str, MovingWall] = field(default_factory=dict)  #: those that move
    thermostat: RandomKicks | Andersen | None = None
    shear_rate: float = 0.0  #: of a Lees–Edwards boundary [1/s]
    shear_displacement: float = 0.0  #: of the images beyond its far side, along the first axis [m]
    time: float = 0.0  #: [s]
    angular_velocities: Floats | None = None  #: (N, 3), in 2-D (N,) [rad/s]
    inertia_factor: Floats | None = None  #: (N,)

    @property
    def sides(self) -> tuple[list[bool], tuple[int, float, float] | None]:
        """The boundary as files hold it: whether each axis wraps, and the shear, see :func:`boundary_of`."""
        wraps = [side != "wall" for side in self.boundary]
        if "lees-edwards" not in self.boundary:
            return wraps, None
        return wraps, (self.boundary.index("lees-edwards"), self.shear_rate, self.shear_displacement)


#: Function that appends a frame to a file.
Append = Callable[[Frame], None]

BLOCK: Final = 65536  #: number of rows formatted at a time


@dataclass(frozen=True)
class Found:
    """What a file has of a system, unchecked and in its own units."""

    arguments: dict[str, Any]  #: of ParticleSystem; also ``angular_momenta``
    rounding: float = 0.0  #: rounding error of a coordinate and of a radius together
    units: str | None = None  #: the units that the file names
    types: list[str] | None = None  #: (N,)
    sides: tuple[str, ...] | None = (
        None  #: both ends of each axis, as in LAMMPS' dumps, in place of ``boundary``
    )
    tilt: Floats | None = None  #: xy, xz and yz of a box that may tilt
    is_folded: bool = True  #: whether all positions lie in the box


def three(values: Floats, last: float = 0.0) -> Floats:
    """Rows of three columns; in 2-D the third column is filled with ``last``."""
    missing = 3 - values.shape[-1]
    return np.concatenate([values, np.full((*values.shape[:-1], missing), last)], axis=-1)


def write_rows(file: BinaryIO, labels: Iterable[str], *columns: Floats) -> None:
    """Write a line for each row of numbers, which begins with its label."""
    table, label = np.column_stack(columns), iter(labels)
    for first in range(0, len(table), BLOCK):
        rows = table[first : first + BLOCK].tolist()
        write_all(file, "".join(f"{next(label)} {' '.join(map(repr, row))}\n" for row in rows).encode())


def read_table(name: str, lines: Iterable[Any], columns: list[int] | None = None) -> Floats:
    """Lines of numbers as an array; ``name`` is for error messages."""
    try:
        return np.loadtxt(lines, usecols=columns, comments=None, ndmin=2, encoding="utf-8")
    except (ValueError, IndexError) as error:
        raise ValueError(f"{name}: {str(error).splitlines()[0]}") from None


def boundary_of(wraps: Iterable[Any], shear: Any = None) -> dict[str, Any]:
    """Arguments from :attr:`Frame.sides`; shear: axis of the gradient, rate [1/s], displacement of the images [m]."""
    sides = ["periodic" if flag else "wall" for flag in wraps]
    if shear is None:
        return {"boundary": tuple(sides)}
    axis, rate, displacement = (float(value) for value in shear)
    if axis not in range(1, len(sides)):
        raise ValueError(f"shear: got axis {axis:g}, must be a whole number in [1, {len(sides) - 1}]")
    sides[int(axis)] = "lees-edwards"
    return {"boundary": tuple(sides), "shear_rate": rate, "shear_displacement": displacement}


def spins_of(rows: Floats, dimension: int) -> Floats:
    """Angular velocities from the three columns of a file."""
    if dimension == 2 and np.any(rows[:, :2]):
        raise ValueError("dimension: got 2, must be 3 for particles that spin about x or y")
    return spins.from_core(rows, dimension)


def wraps_of(sides: Iterable[str]) -> list[bool]:
    """Whether each axis is periodic, from its sides in a dump of LAMMPS, such as pp or fs."""
    return [side.startswith("p") for side in sides]


def rounding_of(values: Iterable[Floats]) -> float:
    """Rounding error of decimal numbers: half of the last digit of the largest one.

    All have as many digits as the longest, at least 6, as C's %g has: shorter ones end in zeros.
    """
    x = np.abs(np.concatenate(list(values)))
    x = x[x > 0.0]
    if not x.size:
        return 0.0
    exponents = np.floor(np.log10(x))
    for digits in range(6, 13):
        scaled = x * 10.0 ** (digits - 1 - exponents)
        if (np.abs(scaled - np.rint(scaled)) <= 8.0 * np.finfo(float).eps * scaled).all():
            break
    return float(0.5 * 10.0 ** (exponents.max() - digits + 1))


def sorted_by_id(ids: Floats) -> NDArray[np.int64]:
    """The order of particles by their numbers, which may have gaps."""
    order = np.argsort(ids, kind="stable")
    twice = np.flatnonzero(np.diff(ids[order]) == 0.0)
    if len(twice):
        raise ValueError(
            f"id: got {ids[order][twice[0]]:.16g} twice, must be another number for each particle"
        )
    return order


def check_frame(frame: int, count: int) -> None:
    """Refuse the index of a frame that a file with ``count`` frames does not have."""
    if not count:
        raise ValueError("is empty, must have one frame or more")
    if not -count <= frame < count:
        raise ValueError(f"frame: got {frame}, must be in [{-count}, {count - 1}]")
