"""Random initial states: radii, masses, edge of the box, positions without overlap, Maxwellian velocities and spins."""

from __future__ import annotations

import math
import operator
from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from .. import _core
from ..contact.balls import ball_masses
from ..support import machine, validation
from ..support.formatting import size
from ..support.progress import Report
from . import spins
from .box import LARGEST, LENGTHS, UNIT_BALL, Box, Floats

#: Limits of a mass [kg]; the squares of momenta neither underflow nor overflow.
LIGHTEST: Final = 1e-100
HEAVIEST: Final = 1e100
MAX_PARTICLES: Final = 2**31 - 1
#: Memory per particle during the growth of a random start or during a run [bytes].
BYTES_PER_PARTICLE: Final = 300
#: ``rms_spin`` of a start whose rotational temperature equals the granular temperature.
EQUAL: Final = "equal"
#: Largest packing fraction of a random start, by dimension.
DENSEST: Final = {2: 0.82, 3: 0.62}


class Generators:
    """Independent random generators for radii, positions, velocities and spins, from one seed."""

    def __init__(self, seed: Any) -> None:
        root = np.random.SeedSequence(validation.whole("seed", seed, 0, 2**63 - 1))
        radii, positions, velocities, spins = root.spawn(4)
        self.radii = np.random.default_rng(radii)
        self.velocities = np.random.default_rng(velocities)
        self.spins = np.random.default_rng(spins)
        self.seed_of_positions = int(positions.generate_state(1, np.uint64)[0] >> np.uint64(1))


def count(n: Any) -> int:
    """The number of particles, checked to fit in memory."""
    wanted = validation.whole("n", n, 1, MAX_PARTICLES)
    needed, free = wanted * BYTES_PER_PARTICLE, machine.free_memory()
    if needed > free:
        raise ValueError(
            f"n: got {wanted}, must fit into the free memory: needs {size(needed)}, {size(free)} are free"
        )
    return wanted


def radii(radius: Any, n: int, generators: Generators) -> Floats:
    """N radii [m]: one for all, one for each particle, or uniformly distributed between two limits."""
    if n == 2 or isinstance(radius, str | bytes) or operator.length_hint(radius, -1) != 2:
        return validation.each("radius", radius, n, **LENGTHS)
    smallest, largest = validation.numbers("radius", radius, 2, **LENGTHS)
    if smallest > largest:
        raise ValueError(
            f"radius: got {smallest:.16g} and {largest:.16g}, the first must not be the larger one"
        )
    drawn = generators.radii.uniform(smallest, largest, n)
    drawn.flags.writeable = False
    return drawn


def checked_masses(parameter: str, amount: Floats, radius: Floats) -> Floats:
    """Masses [kg] from the densities or masses ``amount``; a broadcast number if all are equal."""
    if parameter == "mass":
        mass = amount
    elif amount.strides == radius.strides == (0,):
        mass = np.broadcast_to(np.float64(_core.ball_mass(float(amount[0]), float(radius[0]))), len(amount))
    else:
        mass = ball_masses(amount, radius)
    good = (mass >= LIGHTEST) & (mass <= HEAVIEST)
    if not good.all():
        bad = int(np.argmin(good))
        raise ValueError(
            f"radius | {parameter}: got {radius[bad]:.16g} and {amount[bad]:.16g} for particle {bad}, a mass of "
            f"{mass[bad]:g} kg, must be in [{LIGHTEST:g}, {HEAVIEST:g}]"
        )
    return mass


def solid_volume(radius: Floats, dimension: int) -> float:
    """Total volume [m³] of the particles, in 2-D their area [m²]."""
    return UNIT_BALL[dimension] * float(np.sum(radius**dimension))


def edge(packing_fraction: Any, radius: Floats, dimension: int) -> float:
    """Edge [m] of the square or cube with this packing fraction."""
    densest = DENSEST[dimension]
    fraction = validation.number("packing_fraction", packing_fraction, 0.0, densest, highest_allowed=True)
    length = (solid_volume(radius, dimension) / fraction) ** (1.0 / dimension)
    return validation.number("packing_fraction | radius: edge of the box", length, **LENGTHS)


def check_size(box: Box, radius: Floats) -> None:
    """Refuse a box that is too small for its boundaries."""
    try:
        box.check_size(float(radius.max()))
    except ValueError as error:
        raise ValueError(
            f"n | packing_fraction: got {len(radius)} particles, must be more at this packing fraction: {error}"
        ) from None


def positions(radius: Floats, box: Box, generators: Generators, report: Report) -> Floats:
    """Positions (N, d) [m] without overlap; progress is reported in thousandths of the growth.

    Where a moving wall starts inside the box, the particles grow in the space that it leaves.
    """
    low = np.zeros(box.dimension)
    edges = box.edges.copy()
    for axis in range(box.dimension):
        at, end = box.limits(axis)
        low[axis], edges[axis] = max(at, 0.0), min(end, edges[axis]) - max(at, 0.0)
    packed = _core.grow_packing(
        Box(edges, box.boundary, box.gravity).of_core(),  # without shear: all images are aligned
        np.ascontiguousarray(radius),
        generators.seed_of_positions,
        lambda fraction, collisions: report(int(1000.0 * fraction), 1000),
    )
    return np.asarray(packed, np.float64) + low if low.any() else np.asarray(packed, np.float64)


def velocities(
    mass: Floats, dimension: int, rms_speed: float, periodic: Sequence[bool], generators: Generators
) -> Floats:
    """Maxwellian velocities (N, d) [m/s] with this root mean square, and no total momentum along periodic axes."""
    n = len(mass)
    if rms_speed == 0.0:
        return np.zeros((n, dimension))
    if n == 1 and all(periodic):
        raise ValueError(
            f"rms_speed: got {rms_speed:.16g}, must be 0 for a single particle, whose momentum is zero"
        )
    normal = generators.velocities.standard_normal((n, dimension)) / np.sqrt(mass / mass.max())[:, None]
    for axis, wrapped in enumerate(periodic):
        if wrapped:
            normal[:, axis] -= np.average(normal[:, axis], weights=mass)
    scaled: Floats = normal * (rms_speed / math.sqrt(float(np.mean(np.einsum("ij,ij->i", normal, normal)))))
    return scaled


def checked_rms_spin(rms_spin: Any) -> float | str:
    """``rms_spin`` of a random start: a number [rad/s] or ``"equal"``."""
    if isinstance(rms_spin, str) and rms_spin == EQUAL:
        return EQUAL
    limits = {"lowest_allowed": True, "highest_allowed": True}
    if not validation.is_number(rms_spin):
        shown = validation.shown(rms_spin)
        raise ValueError(f"rms_spin: got {shown}, must be a number in [0, {LARGEST:g}] or 'equal'")
    return validation.number("rms_spin", rms_spin, 0.0, LARGEST, **limits)


def rotation(
    mass: Floats,
    radius: Floats,
    velocities: Floats,
    box: Box,
    rms_spin: Any,
    inertia_factor: Any,
    generators: Generators,
) -> dict[str, Floats | None]:
    """Spins and inertia factors as fields of a system. ``velocities`` are relative to the mean flow."""
    n, d = velocities.shape
    if rms_spin is None:
        return spins.checked(None, inertia_factor, n, d)
    factor = spins.checked_factor(inertia_factor, n, d)
    drawn = _spins(mass, factor * mass * radius**2, velocities, checked_rms_spin(rms_spin), generators)
    drawn += box.mean_spin[3 - drawn.shape[1] :]
    return {"angular_velocities": drawn if d == 3 else drawn[:, 0].copy(), "inertia_factor": factor}


def _spins(
    mass: Floats, inertia: Floats, velocities: Floats, rms_spin: float | str, generators: Generators
) -> Floats:
    """Maxwellian angular velocities (N, f) [rad/s], f = 3 axes of spheres, 1 of disks: the same mean energy for all.

    They have this root mean square, or the rotational temperature Σ I ω²/(f Σ m) is the granular temperature. Their
    total is not zero: friction does not conserve it.
    """
    n, d = velocities.shape
    axes = spins.AXES_OF_ROTATION[d]
    normal = generators.spins.standard_normal((n, axes)) / np.sqrt(inertia / inertia.max())[:, None]
    square = np.einsum("ij,ij->i", normal, normal)
    if isinstance(rms_spin, str):
        relative = velocities - mass @ velocities / mass.sum()
        energy = float(np.einsum("i,ij,ij->", mass, relative, relative)) / d
        scale = math.sqrt(energy * axes / float(inertia @ square))
    else:
        scale = rms_spin / math.sqrt(float(np.mean(square)))
    scaled: Floats = normal * scale
    return scaled
