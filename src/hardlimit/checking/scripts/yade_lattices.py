"""Where ``pack.regularHexa`` and ``pack.regularOrtho`` of YADE 2023.02a make spheres within simple predicates."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from .python import Instance
from .yade_container import Ends, is_number, vector
from .yade_extents import ends_of_space

#: Most places of a lattice that are looked at.
LARGEST: Final = 2_000_000


def centres(instance: Instance) -> np.ndarray | None:
    """The centres of the spheres of a lattice in rows; None if they are not known."""
    names = ("predicate", "radius", "gap")
    space, radius, gap = (instance.argument(k, name) for k, name in enumerate(names))
    ends = ends_of_space(space)
    if ends is None or not (is_number(radius) and is_number(gap)) or not 0.0 < radius <= radius + gap:
        return None
    points = hexagonal(ends, radius, gap) if instance.name == "regularHexa" else orthogonal(ends, radius, gap)
    within = None if points is None else inside(space, points, radius)
    return None if points is None or within is None else points[within]


def grid(numbers: list[int]) -> np.ndarray | None:
    """The indices of a lattice in rows; None if it is too large."""
    if not 0 <= math.prod(numbers) <= LARGEST:
        return None
    return np.stack(np.meshgrid(*map(np.arange, numbers), indexing="ij"), axis=-1).reshape(-1, 3)


def hexagonal(ends: Ends, radius: float, gap: float) -> np.ndarray | None:
    """The places of ``regularHexa``: layers of equilateral triangles, of which every other one is above gaps."""
    step = 2.0 * radius + gap
    spacings = (step, step * math.sqrt(0.75), step * math.sqrt(2.0 / 3.0))
    rows = grid([int((b - a) / d) + 1 for a, b, d in zip(*ends, spacings, strict=True)])
    if rows is None:
        return None
    i, j, k = rows.T
    shifted = 2 * i + (j + k) % 2, math.sqrt(3.0) * (j + k % 2 / 3.0), math.sqrt(32.0 / 3.0) / 2.0 * k
    return np.array(ends[0]) + 0.5 * step * np.stack(shifted, axis=-1)


def orthogonal(ends: Ends, radius: float, gap: float) -> np.ndarray | None:
    """The places of ``regularOrtho``: a simple cubic lattice."""
    step = 2.0 * radius + gap
    rows = grid([max(math.ceil((b - a - 2.0 * radius) / step), 0) for a, b in zip(*ends, strict=True)])
    return None if rows is None else np.array(ends[0]) + radius + step * rows


def inside(space: Instance, points: np.ndarray, pad: float) -> np.ndarray | None:
    """Which spheres of radius ``pad`` a predicate holds; None for predicates that are not known."""
    at = [vector(argument) for argument in space.arguments]
    if space.name == "inAlignedBox" and len(at) == 2:
        low, high = (np.array(end) for end in at)
        return np.asarray(((low + pad <= points) & (points <= high - pad)).all(axis=1))
    if space.name == "inSphere" and len(at) == 2 and is_number(radius := space.arguments[1]):
        return np.asarray(((points - np.array(at[0])) ** 2).sum(axis=1) <= max(radius - pad, 0.0) ** 2)
    return None
