"""What a picture of a box shows at one instant: pairs near contact, clusters, how far paths have come apart."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ..boxes.box import Floats
from ..boxes.system import ParticleSystem

Indices = NDArray[np.int64]

#: Pairs nearer than this, in sums of their radii, are near contact.
NEAR: Final = 1.1
#: Particles for each cell in which they are counted.
CELL: Final = 8


class Observer:
    """Measures the places of the particles of one system, whatever they have become."""

    def __init__(self, system: ParticleSystem) -> None:
        self.system = system
        self._expected_near = _expected_near(system)
        self._cells = _counting_cells(system)

    def pair_correlation(self, positions: Floats) -> float:
        """g near contact: pairs nearer than 1.1 (R_i + R_j), those that overlap included, over how many there would be
        of them between touch and there if places were independent. NaN for one particle."""
        if self.system.n < 2:
            return math.nan
        return near_pairs(self.system, positions) / self._expected_near

    def density_variance(self, positions: Floats) -> float:
        """Variance over mean of the number of centres in cells of some 8 particles; 1 if places were independent,
        less in a dense fluid, more where there are clusters. NaN where there is but one cell."""
        cells = self._cells
        if math.prod(cells) < 2:
            return math.nan
        at = (folded(self.system, positions) / self.system.box * cells).astype(np.int64)
        found = np.ravel_multi_index(tuple(np.minimum(at, np.array(cells) - 1).T), cells)
        counts = np.bincount(found, minlength=math.prod(cells))
        return float(counts.var() / counts.mean())

    def divergence(self, positions: Floats, others: Floats) -> float:
        """Root mean square distance of the same particles on two unfolded paths, in radii."""
        apart = np.einsum("ij,ij->i", positions - others, positions - others)
        return math.sqrt(float(np.mean(apart / self.system.radius**2)))


def folded(system: ParticleSystem, positions: Floats) -> Floats:
    """Unfolded positions back in the box."""
    found = positions.copy()
    for axis, side in enumerate(system.boundary):
        edge = system.box[axis]
        if side == "periodic":
            found[:, axis] -= edge * np.floor(found[:, axis] / edge)
        np.clip(found[:, axis], 0.0, edge, out=found[:, axis])
    return found


def _counting_cells(system: ParticleSystem) -> tuple[int, ...]:
    """Cells along each axis, as cubic as the box allows."""
    edge = (float(np.prod(system.box)) * CELL / system.n) ** (1.0 / system.dimension)
    return tuple(max(1, round(float(length) / edge)) for length in system.box)


def _expected_near(system: ParticleSystem) -> float:
    """Pairs between 1 and 1.1 sums of radii if places were independent, by power sums of the radii."""
    n, d = system.n, system.dimension
    one, two, three = (float(np.sum(system.radius**power)) for power in (1, 2, 3))
    if d == 2:
        unit, pairs = math.pi, 0.5 * (2.0 * n * two + 2.0 * one**2 - 4.0 * two)
    else:
        unit, pairs = 4.0 / 3.0 * math.pi, 0.5 * (2.0 * n * three + 6.0 * one * two - 8.0 * three)
    return unit * (NEAR**d - 1.0) * pairs / float(np.prod(system.box))


# --- near pairs ---------------------------------------------------------------------------------------------


def near_pairs(system: ParticleSystem, positions: Floats) -> int:
    """Pairs nearer than 1.1 sums of their radii, each once, the nearest images of periodic ones."""
    places = folded(system, positions)
    reach = 2.0 * NEAR * float(system.radius.max())
    periodic = np.array([side == "periodic" for side in system.boundary])
    count = 0
    for first, second in _candidates(places, system.box, periodic, reach):
        apart = places[first] - places[second]
        apart -= np.where(periodic, system.box * np.round(apart / system.box), 0.0)
        limit = NEAR * (system.radius[first] + system.radius[second])
        count += int(np.count_nonzero(np.einsum("ij,ij->i", apart, apart) < limit**2))
    return count


def _candidates(
    places: Floats, box: Floats, periodic: NDArray[np.bool_], reach: float
) -> Iterator[tuple[Indices, Indices]]:
    """All pairs that may be nearer than ``reach``, each once: those of a cell, and of a cell with each one beside it
    on one side. An axis with room for fewer than three cells has one."""
    cells = np.floor(box / reach).astype(np.int64)
    cells = np.where(cells < 3, 1, np.minimum(cells, 1024))
    at = np.minimum((places / box * cells).astype(np.int64), cells - 1)
    cell = np.ravel_multi_index(tuple(at.T), tuple(cells))
    order = np.argsort(cell, kind="stable")
    counts = np.bincount(cell, minlength=int(np.prod(cells)))
    begin = np.cumsum(counts) - counts
    steps = [(0,) if n == 1 else (-1, 0, 1) for n in cells]
    for step in itertools.product(*steps):
        if step < (0,) * len(step):
            continue
        beside = at + np.array(step)
        inside = (periodic | ((beside >= 0) & (beside < cells))).all(axis=1)
        own = np.flatnonzero(inside)
        other = np.ravel_multi_index(tuple((beside[own] % cells).T), tuple(cells))
        first = np.repeat(own, counts[other])
        within = np.arange(len(first)) - np.repeat(np.cumsum(counts[other]) - counts[other], counts[other])
        second = order[np.repeat(begin[other], counts[other]) + within]
        if not any(step):
            first, second = first[first < second], second[first < second]
        yield first, second
