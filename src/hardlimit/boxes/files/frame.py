"""A frame of a file: a box of grains at one instant."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Frame:
    """The values of a ParticleSystem and the time."""

    positions: Floats  #: (N, d) [m]
    velocities: Floats  #: (N, d) [m/s]
    radius: Floats  #: (N,) [m]
    mass: Floats  #: (N,) [kg]
    box: Floats  #: (d,) [m]
    boundary: tuple[str, ...]  #: "periodic" or "wall" for each axis
    gravity: Floats  #: (d,) [m/s²]
    time: float = 0.0  #: [s]


#: Function that appends a frame to a file.
Append = Callable[[Frame], None]


@dataclass(frozen=True)
class Found:
    """The arguments of ParticleSystem read from a file, unchecked."""

    arguments: dict[str, Any]
    rounding: float = 0.0  #: rounding error of distances, relative to a radius


def three(values: Floats, last: float = 0.0) -> Floats:
    """Rows of three columns; in 2-D the third column is filled with ``last``."""
    missing = 3 - values.shape[-1]
    return np.concatenate([values, np.full((*values.shape[:-1], missing), last)], axis=-1)


def boundary_of(periodic: Any) -> tuple[str, ...]:
    """The boundary of each axis, from flags that are true for periodic axes."""
    return tuple("periodic" if flag else "wall" for flag in periodic)
