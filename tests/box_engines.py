"""Helpers for tests: particle engines from plain numbers."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hardlimit import _core


def box_of(edges: ArrayLike, periodic: ArrayLike, gravity: ArrayLike = 0.0, dimension: int = 0) -> _core.Box:
    """A box; scalars are repeated for each axis."""
    d = dimension or len(np.atleast_1d(edges))
    sides = ["periodic" if wraps else "wall" for wraps in np.broadcast_to(periodic, d)]
    return _core.Box(
        np.broadcast_to(edges, d).astype(float).tolist(),
        sides,
        np.broadcast_to(gravity, d).astype(float).tolist(),
    )


def hard_spheres(
    position: ArrayLike,
    velocity: ArrayLike,
    *,
    box: ArrayLike,
    radius: ArrayLike = 0.5,
    mass: ArrayLike = 1.0,
    periodic: ArrayLike = True,
    gravity: ArrayLike = 0.0,
    rule: str = "constant",
    restitution: float = 1.0,
    law: Any = None,
    contact_duration: float = math.nan,
    log: bool = True,
) -> _core.Engine:
    """A hard-sphere engine; scalars are repeated for each particle and axis."""
    position = np.array(position, dtype=float)
    n, d = position.shape
    return _core.make_engine(
        "hard_spheres",
        box_of(box, periodic, gravity, d),
        position,
        np.array(velocity, dtype=float),
        np.broadcast_to(radius, n).astype(float),
        np.broadcast_to(mass, n).astype(float),
        law=law,
        rule=rule,
        restitution=restitution,
        rule_parameters=[contact_duration] if rule == "tc" else [],
        log=log,
    )


def grow_packing(
    radius: ArrayLike, box: Sequence[float], periodic: Sequence[bool], seed: int
) -> np.ndarray[Any, Any]:
    """Random positions without overlap."""
    return np.asarray(_core.grow_packing(box_of(box, periodic), np.asarray(radius, dtype=float), seed))


def logged(engine: _core.Engine) -> tuple[Any, ...]:
    """The columns of the contact log."""
    return tuple(engine.take_log().values())
