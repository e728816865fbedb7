"""Largest stable time step of a packing: the highest frequency of its network of contacts."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import scipy
import xarray as xr
from numpy.typing import NDArray

from ..boxes import contacts, spins
from ..boxes.box import Floats
from ..boxes.system import ROUNDING, ParticleSystem
from ..contact.contact import Law
from ..contact.friction import FrictionTerms
from ..support import validation
from . import pairs
from .labelled import variable

Indices = NDArray[np.int64]

#: A matrix of at most this many rows is solved as a dense one.
DENSE: Final = 60
#: Relative accuracy of the time step, and the largest number of its corrections for damping.
ACCURACY: Final = 1e-6
MOST_CORRECTIONS: Final = 50


def largest_stable_time_step(system: ParticleSystem, law: Law, *, tolerance: float = ROUNDING) -> xr.Dataset:
    """Largest stable time step of velocity Verlet (leapfrog) for grains that rest on each other.

    The contacts of a state are springs, along the normal and, with friction, along the surfaces, between bodies that
    move and turn. Beyond 2/ω, ω the highest frequency of this network, equal steps amplify the fastest motion. Dashpots
    shorten the step further where their force is computed from the velocity of half a step before, as most codes do.

    Parameters
    ----------
    system : ParticleSystem
        A state with contacts, such as ``result.system`` of a bed at rest. Pairs and walls that overlap are in contact.
    law : Law
        Of all pairs and walls. Laws that are not linear count with dF/dξ at the compression of each contact.
    tolerance : float
        Largest gap of a contact, relative to the sum of the radii (at a wall, to the radius); in [0, 1].

    Returns
    -------
    Dataset
        ``time_step`` [s], infinite without contacts; ``frequency``, the highest angular frequency ω without dashpots
        [rad/s]; ``coordination`` and ``largest_coordination``, the mean and largest number of contacts of a particle.

    Raises
    ------
    ValueError
        If a value is outside its range, or the force of the law is not K ξ^p + C ξ^q dξ/dt.

    Notes
    -----
    With stiffness K, dashpots C and mass M, steps Δt are stable if the largest eigenvalue of M⁻¹(Δt² K + 2 Δt C) is
    less than 4: each mode obeys λ² − (2 − Δt² k − Δt c) λ + 1 − Δt c = 0, and leaves the unit circle at λ = −1. One
    contact: Δt < (2/ω)(√(1 + ζ²) − ζ). All contacts stick here; slip lowers their stiffness. The forces themselves add
    terms of the order of compression over radius, which are left out. A grain that gets another contact later has a
    higher frequency: stay below the result. Without dashpots: O'Sullivan & Bray, Eng. Comput. 21, 278 (2004).

    Examples
    --------
    Two grains of 1 kg at k = 1 N/m have ω² = 2k/m.

    >>> pair = hl.ParticleSystem(
    ...     [[1, 2, 2], [1.99, 2, 2]],
    ...     [[0, 0, 0]] * 2,
    ...     0.5,
    ...     mass=1.0,
    ...     box=4.0,
    ...     allowed_overlap=0.1,
    ... )
    >>> law = hl.LinearDashpot(stiffness=1.0, damping=0.0)
    >>> hl.measure.largest_stable_time_step(pair, law).time_step.item()
    1.41421356...
    """
    contacts.checked_system(system)
    allowed = validation.number("tolerance", tolerance, 0.0, 1.0, lowest_allowed=True, highest_allowed=True)
    of = network(system, allowed)
    frequency, step = _limits(_springs(system, contacts.checked_law(law), of))
    counts = of.counts(system.n)
    return xr.Dataset(
        {
            "time_step": variable((), step, "s", "largest stable time step"),
            "frequency": variable((), frequency, "rad/s", "highest angular frequency without dashpots"),
            "coordination": variable((), counts.mean(), "1", "mean number of contacts of a particle"),
            "largest_coordination": variable(
                (), counts.max(), "1", "largest number of contacts of a particle"
            ),
        }
    )


@dataclass(frozen=True)
class Network:
    """Contacts of a state, one row each."""

    first: Indices  #: particle
    second: Indices  #: particle; −1 for a wall
    normal: Floats  #: (C, d) from the first to the second
    overlap: Floats  #: [m], at least 0
    arms: Floats  #: (2, C) of the surfaces: distances from the centres [m]; 0 for a wall

    def counts(self, n: int) -> Indices:
        """Number of contacts of each particle."""
        return np.bincount(np.concatenate([self.first, self.second[self.second >= 0]]), minlength=n)


@dataclass(frozen=True)
class _Springs:
    """Springs and dashpots, one row for each direction of each contact."""

    stretching: Any  #: sparse, rate of each spring over the velocities √m v and √I ω
    stiffness: Floats  #: [N/m]
    damping: Floats  #: [kg/s]


def network(system: ParticleSystem, tolerance: float) -> Network:
    """Contacts of surfaces whose gap is at most ``tolerance`` times the sum of the radii."""
    first, second = pairs.touching(system, tolerance)
    apart = system.positions[second] - system.positions[first]
    for axis in reversed(range(system.dimension)):  # the axis of the gradient before x
        if system.domain.wraps[axis]:
            turns = np.round(apart[:, axis] / system.box[axis])
            apart[:, axis] -= turns * system.box[axis]
            if axis == system.domain.gradient:
                apart[:, 0] -= turns * system.domain.displacement_after(0.0)
    distance = np.sqrt(np.einsum("ij,ij->i", apart, apart))
    reach = system.radius[first] + system.radius[second]
    rows = [
        (first, second, apart / distance[:, None], reach - distance,
         np.stack([system.radius[first], system.radius[second]]) * distance / reach)
    ]  # fmt: skip
    for _, axis, upper in system.domain.walls():
        inward = system.positions[:, axis] - system.domain.limits(axis)[upper]
        gap = (-inward if upper else inward) - system.radius
        near = np.flatnonzero(gap <= tolerance * system.radius)
        normal = np.zeros((len(near), system.dimension))
        normal[:, axis] = 1.0 if upper else -1.0
        radius = system.radius[near]
        rows.append((near, np.full(len(near), -1), normal, -gap[near], np.stack([radius, 0.0 * radius])))
    bodies, partners, normals, overlaps, arms = zip(*rows, strict=True)
    return Network(
        np.concatenate(bodies), np.concatenate(partners), np.concatenate(normals),
        np.maximum(np.concatenate(overlaps), 0.0), np.concatenate(arms, axis=1),
    )  # fmt: skip


def _springs(system: ParticleSystem, law: Law, of: Network) -> _Springs:
    p, q = (0.25 * power for power in law.record["powers"])
    normal, across = np.zeros((2, 2, len(of.first)))  # stiffness and damping of each contact
    for rows, contact in contacts.of_pairs(system, law, of.first, of.second):
        if contact.coefficients is None:
            raise ValueError(f"law: got {type(law).__name__}, must have a force K ξ^p + C ξ^q dξ/dt")
        elastic, viscous = contact.coefficients
        xi, terms = of.overlap[rows], FrictionTerms(*contact.friction_terms)
        normal[:, rows] = elastic * p * xi ** (p - 1.0), viscous * xi**q
        if terms.coefficient > 0.0:
            across[0, rows] = terms.stiffness * xi ** (0.25 * terms.stiffness_power)
            across[1, rows] = terms.damping * xi ** (0.25 * terms.damping_power)
    parts = [(_stretching(system, of, of.normal, turns=False), normal)]
    if across.any():
        parts += [(_stretching(system, of, tangent, turns=True), across) for tangent in _tangents(of.normal)]
    stiffness, damping = np.concatenate([values for _, values in parts], axis=1)
    return _Springs(scipy.sparse.vstack([rates for rates, _ in parts]).tocsr(), stiffness, damping)


def _tangents(normal: Floats) -> list[Floats]:
    """Unit vectors across each normal: one in the plane, two in space."""
    if normal.shape[1] == 2:
        return [np.stack([-normal[:, 1], normal[:, 0]], axis=1)]
    least = np.eye(3)[np.abs(normal).argmin(axis=1)]
    first = np.cross(normal, least)
    first /= np.linalg.norm(first, axis=1)[:, None]
    return [first, np.cross(normal, first)]


def _cross(a: Floats, b: Floats) -> Floats:
    """Rows of a × b; in the plane its one component, across it."""
    if a.shape[1] == 3:
        return np.cross(a, b)
    return a[:, :1] * b[:, 1:] - a[:, 1:] * b[:, :1]


def _stretching(system: ParticleSystem, of: Network, along: Floats, turns: bool) -> Any:
    """Rate at which the surfaces of each contact move apart along a direction (rows), over √m v and √I ω (columns)."""
    n, d = system.n, system.dimension
    axes = spins.AXES_OF_ROTATION[d]
    torque = _cross(of.normal, along)
    shape = len(along), n * (d + axes)
    total = scipy.sparse.csr_array(shape)
    for body, arm, sign in ((of.first, of.arms[0], -1.0), (of.second, of.arms[1], 1.0)):
        row = np.flatnonzero(body >= 0)
        who = body[row]
        moves = sign * along[row] / np.sqrt(system.mass[who])[:, None]
        spun = -(arm[row] / np.sqrt(system.inertia[who]))[:, None] * torque[row] * turns
        columns = np.concatenate(
            [who[:, None] * d + np.arange(d), n * d + who[:, None] * axes + np.arange(axes)], axis=1
        )
        values = np.concatenate([moves, spun], axis=1)
        at = np.repeat(row, d + axes), columns.ravel()
        total = total + scipy.sparse.csr_array((values.ravel(), at), shape)
    return total


def _fastest(springs: _Springs, weights: Floats) -> tuple[float, Floats]:
    """The largest eigenvalue of Σ weight·rate² of the springs, and the rate of each spring in its mode."""
    matrix = (springs.stretching.T @ scipy.sparse.diags_array(weights) @ springs.stretching).tocsr()
    if matrix.shape[0] <= DENSE:
        values, vectors = np.linalg.eigh(matrix.toarray())
    else:
        start = np.random.default_rng(0).standard_normal(matrix.shape[0])  # the same bits each time
        values, vectors = scipy.sparse.linalg.eigsh(matrix, k=1, which="LA", v0=start, tol=ACCURACY)
    return float(values[-1]), springs.stretching @ vectors[:, -1]


def _limits(springs: _Springs) -> tuple[float, float]:
    """The highest frequency [rad/s] and the largest stable time step [s]."""
    if not springs.stiffness.any():
        return 0.0, math.inf
    square, rates = _fastest(springs, springs.stiffness)
    frequency = math.sqrt(square)
    step = 2.0 / frequency
    for _ in range(MOST_CORRECTIONS if springs.damping.any() else 0):
        # The step at which the fastest mode of the last one is at its limit: never less than the result.
        k, c = (float(rates**2 @ values) for values in (springs.stiffness, springs.damping))
        before, step = step, 4.0 / (c + math.sqrt(c * c + 4.0 * k))
        if abs(step - before) <= ACCURACY * step:
            break
        _, rates = _fastest(springs, step * step * springs.stiffness + 2.0 * step * springs.damping)
    return frequency, step
