"""Observables of particle positions: pairs near contact, clustering, distance between two trajectories."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from ..boxes.box import UNIT_BALL, Floats
from ..boxes.system import ParticleSystem

#: Pairs closer than this, in units of R_i + R_j, are near contact.
NEAR: Final = 1.1
#: Mean number of particles in a cell for the variance of the density.
CELL: Final = 8


class Observer:
    """Computes observables of one system from unfolded positions."""

    def __init__(self, system: ParticleSystem) -> None:
        self.system = system
        self._expected_pairs = _expected_pairs(system)
        edge = (float(np.prod(system.box)) * CELL / system.n) ** (1.0 / system.dimension)
        self._cells = tuple(max(1, round(float(length) / edge)) for length in system.box)

    def _folded(self, positions: Floats) -> Floats:
        found = positions.copy()
        self.system.domain.fold(found)
        return found

    def pair_correlation(self, positions: Floats) -> float:
        """Pair correlation function g near contact: the number of pairs closer than 1.1 (R_i + R_j), including
        overlapping pairs, divided by the number expected between touch and this distance for independent positions. NaN
        for one particle."""
        if self.system.n < 2:
            return math.nan
        return near_pairs(self.system, self._folded(positions)) / self._expected_pairs

    def density_variance(self, positions: Floats) -> float:
        """Variance divided by mean of the number of centres in cells of about 8 particles: 1 for independent positions,
        smaller in a dense fluid, larger with clusters. NaN for a single cell."""
        cells = self._cells
        if math.prod(cells) < 2:
            return math.nan
        at = (self._folded(positions) / self.system.box * cells).astype(np.int64)
        found = np.ravel_multi_index(tuple(np.minimum(at, np.array(cells) - 1).T), cells)
        counts = np.bincount(found, minlength=math.prod(cells))
        return float(counts.var() / counts.mean())

    def divergence(self, positions: Floats, others: Floats) -> float:
        """Root mean square distance, in radii, between the same particles on two unfolded trajectories."""
        apart = np.einsum("ij,ij->i", positions - others, positions - others)
        return math.sqrt(float(np.mean(apart / self.system.radius**2)))


def near_pairs(system: ParticleSystem, positions: Floats) -> int:
    """Number of pairs closer than 1.1 (R_i + R_j), counting the nearest periodic image."""
    from scipy.spatial import cKDTree

    edges = np.where(system.domain.periodic, system.box, np.inf)
    wrapped = positions % edges  # an edge is its own image
    tree = cKDTree(wrapped, boxsize=np.where(np.isinf(edges), 0.0, edges))
    pairs = tree.query_pairs(2.0 * NEAR * float(system.radius.max()), output_type="ndarray")
    apart = wrapped[pairs[:, 0]] - wrapped[pairs[:, 1]]
    apart -= np.where(np.isinf(edges), 0.0, system.box * np.round(apart / system.box))
    limit = NEAR * system.radius[pairs].sum(axis=1)
    return int(np.count_nonzero(np.einsum("ij,ij->i", apart, apart) < limit**2))


def _expected_pairs(system: ParticleSystem) -> float:
    """Expected pairs between 1 and 1.1 (R_i + R_j) for independent positions, by power sums of the radii."""
    n, d = system.n, system.dimension
    one, two, three = (float(np.sum(system.radius**power)) for power in (1, 2, 3))
    if d == 2:
        pairs = 0.5 * (2.0 * n * two + 2.0 * one**2 - 4.0 * two)
    else:
        pairs = 0.5 * (2.0 * n * three + 6.0 * one * two - 8.0 * three)
    return UNIT_BALL[d] * (NEAR**d - 1.0) * pairs / float(np.prod(system.box))
