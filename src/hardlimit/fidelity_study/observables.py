"""Observables of a state: pairs near contact, clustering, flow in layers, distance between two trajectories."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from ..boxes.box import UNIT_BALL, Floats
from ..boxes.system import ParticleSystem
from ..measure.pairs import near

#: Pairs closer than this, in units of R_i + R_j, are near contact.
NEAR: Final = 1.1
#: Mean number of particles in a cell for the variance of the density.
CELL: Final = 8
#: Least mean number of particles in a layer across the gradient of a sheared box, and the largest number of layers.
LAYER: Final = 20
MOST_LAYERS: Final = 8


class Observer:
    """Computes observables of one system from unfolded positions and velocities."""

    def __init__(self, system: ParticleSystem) -> None:
        self.system = system
        self._expected_pairs = _expected_pairs(system)
        edge = (float(np.prod(system.box)) * CELL / system.n) ** (1.0 / system.dimension)
        self._cells = tuple(max(1, round(float(length) / edge)) for length in system.box)

    def _folded(self, positions: Floats, time: float, velocities: Floats | None = None) -> Floats:
        folded = positions.copy()
        self.system.domain.fold(folded, velocities, time)
        return folded

    def pair_correlation(self, positions: Floats, time: float = 0.0) -> float:
        """Pair correlation function g near contact: the number of pairs closer than 1.1 (R_i + R_j), including
        overlapping pairs, divided by the number expected between touch and this distance for independent positions. NaN
        for one particle."""
        if self.system.n < 2:
            return math.nan
        close, _ = near(self.system, self._folded(positions, time), NEAR, time)
        return len(close) / self._expected_pairs

    def density_variance(self, positions: Floats, time: float = 0.0) -> float:
        """Variance divided by mean of the number of centres in cells of about 8 particles: 1 for independent positions,
        smaller in a dense fluid, larger with clusters. NaN for a single cell."""
        cells = self._cells
        if math.prod(cells) < 2:
            return math.nan
        at = (self._folded(positions, time) / self.system.box * cells).astype(np.int64)
        cell = np.ravel_multi_index(tuple(np.clip(at, 0, np.array(cells) - 1).T), cells)
        counts = np.bincount(cell, minlength=math.prod(cells))
        return float(counts.var() / counts.mean())

    def nonlinear_flow(self, positions: Floats, velocities: Floats, time: float = 0.0) -> float:
        """Share of the mean square T of v_x, about the linear flow, that is a flow in layers across the gradient.

        With V_l the mean velocity of layer l relative to the linear flow and N_l its particles, Σ N_l V_l² is
        (layers − 1) T by thermal noise alone, and N T if all motion is such a flow. The share is zero on average
        without one, and near 1 in shear bands. NaN without shear and for fewer than 40 particles.
        Particles of different masses count alike.
        """
        axis, n = self.system.domain.gradient, self.system.n
        layers = min(MOST_LAYERS, n // LAYER)
        if axis is None or layers < 2:
            return math.nan
        moving = velocities.copy()
        folded = self._folded(positions, time, moving)
        flow = (moving - self.system.domain.mean_flow(folded))[:, 0]
        flow -= flow.mean()
        at = np.minimum((folded[:, axis] / self.system.box[axis] * layers).astype(np.int64), layers - 1)
        count = np.bincount(at, minlength=layers)
        ordered = float(np.sum(np.bincount(at, flow, layers) ** 2 / np.maximum(count, 1)))
        noise = (layers - 1) / n
        return (ordered / float(flow @ flow) - noise) / (1.0 - noise)

    def divergence(self, positions: Floats, others: Floats) -> float:
        """Root mean square distance, in radii, between the same particles on two unfolded trajectories."""
        apart = np.einsum("ij,ij->i", positions - others, positions - others)
        return math.sqrt(float(np.mean(apart / self.system.radius**2)))


def _expected_pairs(system: ParticleSystem) -> float:
    """Expected pairs between 1 and 1.1 (R_i + R_j) for independent positions, by power sums of the radii."""
    n, d = system.n, system.dimension
    radii, squares, cubes = (float(np.sum(system.radius**power)) for power in (1, 2, 3))
    if d == 2:
        pairs = 0.5 * (2.0 * n * squares + 2.0 * radii**2 - 4.0 * squares)
    else:
        pairs = 0.5 * (2.0 * n * cubes + 6.0 * radii * squares - 8.0 * cubes)
    return UNIT_BALL[d] * (NEAR**d - 1.0) * pairs / float(np.prod(system.box))
