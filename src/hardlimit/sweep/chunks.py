"""A map cut into tiles: contiguous ranges of its points that are also boxes of its grid.

Being both, a tile is one call of the kernel, one chunk of a Zarr array and one task of a cluster.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from .plan import MODELS, Plan

#: Points of a tile: few enough that a tile with all its variables takes some 20 MB and, where each point is
#: integrated numerically, that little is lost with a tile; enough that the cost of a tile is in its points.
POINTS: Final = 1 << 19
POINTS_INTEGRATED: Final = 1 << 14


@dataclass(frozen=True)
class Tiles:
    """Boxes of ``block`` points over a grid of ``shape``, numbered in C order.

    ``block`` is 1 along the first dimensions, whole along the last ones, and anything along one in between,
    where the last box may be smaller.
    """

    shape: tuple[int, ...]
    block: tuple[int, ...]

    @classmethod
    def of(cls, plan: Plan) -> Tiles:
        """The tiles of a sweep. They depend on what is computed only, never on where."""
        integrated = plan.model != MODELS[2] and plan.law != "linear"
        return cls.within(plan.shape, POINTS_INTEGRATED if integrated else POINTS)

    @classmethod
    def within(cls, shape: tuple[int, ...], most: int) -> Tiles:
        """Tiles of at most ``most`` points."""
        return cls(shape, _block(shape, most))

    @classmethod
    def whole(cls, plan: Plan) -> Tiles:
        """One tile for everything."""
        return cls(plan.shape, plan.shape)

    @property
    def counts(self) -> tuple[int, ...]:
        """Number of tiles along each dimension."""
        return tuple(-(-n // b) for n, b in zip(self.shape, self.block, strict=True))

    def __len__(self) -> int:
        return math.prod(self.counts)

    def position(self, tile: int) -> tuple[int, ...]:
        """Number of a tile along each dimension."""
        return tuple(int(i) for i in np.unravel_index(tile, self.counts)) if self.shape else ()

    def box(self, tile: int) -> tuple[slice, ...]:
        """The points of a tile along each dimension."""
        corners = [i * b for i, b in zip(self.position(tile), self.block, strict=True)]
        ends = [min(c + b, n) for c, b, n in zip(corners, self.block, self.shape, strict=True)]
        return tuple(slice(c, e) for c, e in zip(corners, ends, strict=True))

    def box_shape(self, tile: int) -> tuple[int, ...]:
        """Number of points of a tile along each dimension."""
        return tuple(s.stop - s.start for s in self.box(tile))

    def span(self, tile: int) -> tuple[int, int]:
        """First point of a tile and number of its points, counted through the whole map."""
        first = 0
        for s, n in zip(self.box(tile), self.shape, strict=True):
            first = first * n + s.start
        return first, math.prod(self.box_shape(tile))

    def cut(self, plan: Plan, tile: int) -> Plan:
        """A tile as a sweep of its own, with the values it needs and no others."""
        shape = self.box_shape(tile)
        values, strides = list(plan.values), list(plan.strides)
        for dim, box in enumerate(self.box(tile)):
            along = (plan.shape[dim], math.prod(plan.shape[dim + 1 :]))
            for i, (v, stride) in enumerate(zip(plan.values, plan.strides, strict=True)):
                if len(v) > 1 and (len(v), stride) == along:
                    values[i], strides[i] = v[box], math.prod(shape[dim + 1 :])
        return dataclasses.replace(
            plan, values=tuple(values), strides=tuple(strides), shape=shape, coordinates=()
        )


def _block(shape: tuple[int, ...], most: int) -> tuple[int, ...]:
    """The largest box of at most ``most`` points, the same along its dimension but for rounding."""
    inner = 1
    for dim in reversed(range(len(shape))):
        if inner * shape[dim] > most:
            pieces = -(-shape[dim] // (most // inner))
            return (1,) * dim + (-(-shape[dim] // pieces),) + shape[dim + 1 :]
        inner *= shape[dim]
    return shape
