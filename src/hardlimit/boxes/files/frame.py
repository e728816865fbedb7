"""What a file holds of a box of grains at one instant."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Frame:
    """One instant: the values of a ParticleSystem, and the time."""

    positions: Floats  #: (N, d) [m]
    velocities: Floats  #: (N, d) [m/s]
    radius: Floats  #: (N,) [m]
    mass: Floats  #: (N,) [kg]
    box: Floats  #: (d,) [m]
    boundary: tuple[str, ...]  #: "periodic" or "wall" for each axis
    gravity: Floats  #: (d,) [m/s²]
    time: float = 0.0  #: [s]


#: Writes one more frame at the end of a file.
Append = Callable[[Frame], None]


@dataclass(frozen=True)
class Found:
    """What was read: arguments of ParticleSystem as they stand in the file, unchecked."""

    arguments: dict[str, Any]
    rounding: float = 0.0  #: largest error of a distance in the file's precision, relative to a radius


def three(values: Floats, last: float = 0.0) -> Floats:
    """Rows of three columns, of a plane with ``last`` in the third."""
    missing = 3 - values.shape[-1]
    return np.concatenate([values, np.full((*values.shape[:-1], missing), last)], axis=-1)


def words(periodic: Any) -> tuple[str, ...]:
    """The sides of a box from one flag for each axis."""
    return tuple("periodic" if flag else "wall" for flag in periodic)
