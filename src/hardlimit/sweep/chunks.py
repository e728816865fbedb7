"""Chunks of a grid: contiguous ranges of points that are also boxes.

A chunk can therefore be one call of a kernel, one chunk of a Zarr array, and one task on a cluster.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from .computation import Computation

#: Largest number of points of a chunk, about 20 MB with all variables. It is smaller if each point is integrated
#: numerically, so that an interruption loses little work.
POINTS: Final = 1 << 19
POINTS_INTEGRATED: Final = 1 << 14


@dataclass(frozen=True)
class Chunks:
    """Boxes of ``box_shape`` points over a grid of ``shape``, numbered in C order.

    ``box_shape`` is 1 along the first dimensions and the full size along the last ones. Along one dimension in between
    it has any size, and the last box may be smaller.
    """

    shape: tuple[int, ...]
    box_shape: tuple[int, ...]

    @classmethod
    def of(cls, computation: Computation) -> Chunks:
        """The chunks of a computation; they do not depend on the engine."""
        return cls.within(computation.shape, POINTS_INTEGRATED if computation.integrated else POINTS)

    @classmethod
    def within(cls, shape: tuple[int, ...], most: int) -> Chunks:
        """Chunks of at most ``most`` points."""
        return cls(shape, _largest_box(shape, most))

    @classmethod
    def whole(cls, computation: Computation) -> Chunks:
        """One chunk for everything."""
        return cls(computation.shape, computation.shape)

    @property
    def counts(self) -> tuple[int, ...]:
        """Number of chunks along each dimension."""
        return tuple(-(-n // b) for n, b in zip(self.shape, self.box_shape, strict=True))

    @property
    def number(self) -> int:
        """Number of chunks; it may be too large for ``len``."""
        return math.prod(self.counts)

    def __len__(self) -> int:
        return self.number

    def position(self, chunk: int) -> tuple[int, ...]:
        """Index of a chunk along each dimension."""
        return tuple(int(i) for i in np.unravel_index(chunk, self.counts)) if self.shape else ()

    def box(self, chunk: int) -> tuple[slice, ...]:
        """The points of a chunk along each dimension."""
        corners = [i * b for i, b in zip(self.position(chunk), self.box_shape, strict=True)]
        ends = [min(c + b, n) for c, b, n in zip(corners, self.box_shape, self.shape, strict=True)]
        return tuple(slice(c, e) for c, e in zip(corners, ends, strict=True))

    def span(self, chunk: int) -> tuple[int, int]:
        """Index of the first point of a chunk in the whole grid, and number of its points."""
        first, count = 0, 1
        for s, n in zip(self.box(chunk), self.shape, strict=True):
            first = first * n + s.start
            count *= s.stop - s.start
        return first, count


def _largest_box(shape: tuple[int, ...], most: int) -> tuple[int, ...]:
    """The largest box of at most ``most`` points that divides its dimension into nearly equal parts."""
    inner = 1
    for dim in reversed(range(len(shape))):
        if inner * shape[dim] > most:
            pieces = -(-shape[dim] // (most // inner))
            return (1,) * dim + (-(-shape[dim] // pieces),) + shape[dim + 1 :]
        inner *= shape[dim]
    return shape
