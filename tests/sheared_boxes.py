"""What the tests of sheared boxes share: a slow and plain solution of hard spheres, and boxes of displaced images."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np

import hardlimit as hl


def collisions(system: Any, restitution: float, count: int) -> list[tuple[float, int, int, float]]:
    """Time, first, second and impact speed of the first collisions of a system whose other axes are periodic.

    Independent of the core: all pairs and all nearby images at each collision. The state is that in the box, the images
    are those of Lees & Edwards (1972).
    """
    x, v = np.array(system.positions), np.array(system.velocities)
    edges, axis, rate = np.array(system.box), system.boundary.index("lees-edwards"), system.shear_rate
    n, d = x.shape
    first, second = np.triu_indices(n, 1)
    touch = (system.radius[first] + system.radius[second])[:, None]
    flags = np.array(list(itertools.product((-1, 0, 1), repeat=d)))
    speed = rate * edges[axis]
    displaced, now, last, events = system.shear_displacement, 0.0, None, []
    while len(events) < count:
        # Relative position and velocity of all images (pairs, images, d).
        shift = flags * edges
        shift[:, 0] += flags[:, axis] * displaced
        r = (x[second] - x[first])[:, None, :] + shift
        r[..., 0] = (r[..., 0] + 1.5 * edges[0]) % edges[0] + (flags[:, 0] - 0.5) * edges[0]
        u = (v[second] - v[first])[:, None, :] + np.zeros(flags.shape)
        u[..., 0] += flags[:, axis] * speed
        a, b, c = (u * u).sum(-1), (r * u).sum(-1), (r * r).sum(-1) - touch**2
        root = np.sqrt(np.maximum(b * b - a * c, 0.0))
        with np.errstate(invalid="ignore", divide="ignore"):
            wait = np.where((b < 0.0) & (b * b > a * c), np.maximum(c, 0.0) / (root - b), np.inf)
        if last is not None:
            wait[last] = np.inf
        pair, image = np.unravel_index(int(wait.argmin()), wait.shape)
        # Images farther away than those above may come near later.
        step = min(float(wait[pair, image]), 0.1 * float(edges.min()) / (np.abs(u).max() + abs(speed)))
        x, now, displaced = x + step * v, now + step, displaced + speed * step
        last = None
        if step == wait[pair, image]:
            i, j = int(first[pair]), int(second[pair])
            gap, rel = r[pair, image] + step * u[pair, image], u[pair, image]
            normal = gap / np.sqrt(gap @ gap)
            impact = -float(rel @ normal)
            impulse = (1.0 + restitution) * impact / (1.0 / system.mass[i] + 1.0 / system.mass[j])
            v[i] -= impulse / system.mass[i] * normal
            v[j] += impulse / system.mass[j] * normal
            events.append((now, i, j, impact))
            last = (pair, slice(None))
        crossed = np.floor(x[:, axis] / edges[axis])
        x[:, 0] -= crossed * displaced
        v[:, 0] -= crossed * speed
        x -= edges * np.floor(x / edges)
    return events


def closest(system: hl.ParticleSystem, unfolded: Any = None, time: float = 0.0) -> float:
    """The smallest gap over the sum of the radii, of all pairs and all images, without cells; of the system, or of
    these positions at a time later."""
    edges, axis = np.array(system.box), system.boundary.index("lees-edwards")
    moved = system.shear_displacement + system.shear_rate * edges[axis] * time
    x = np.array(system.positions if unfolded is None else unfolded)
    layers = np.floor(x[:, axis] / edges[axis])
    x[:, axis] -= layers * edges[axis]
    x[:, 0] -= layers * moved
    first, second = np.triu_indices(system.n, 1)
    touch = system.radius[first] + system.radius[second]
    r, least = x[second] - x[first], np.inf
    for layer in (-1, 0, 1):
        image = r.copy()
        image[:, axis] += layer * edges[axis]
        image[:, 0] += layer * moved
        across = [k for k in range(len(edges)) if k != axis]
        image[:, across] -= edges[across] * np.round(image[:, across] / edges[across])
        least = min(least, float((np.sqrt((image**2).sum(1)) / touch).min()) - 1.0)
    return least


def displaced(system: hl.ParticleSystem, fraction: float) -> hl.ParticleSystem:
    """The same particles at places where they do not overlap if the images are displaced by a fraction of the edge.

    They get there by collisions while the images slide as far. The velocities relative to the flow are the old ones.
    """
    speed = 1.0
    axis = system.boundary.index("lees-edwards")
    sliding = system.replace(shear_rate=speed / system.box[axis])
    until = fraction * float(system.box[0]) / speed
    there = (
        hl.event_driven(
            sliding, restitution=1.0, until=until, samples=1, max_collisions=1000 * system.n
        ).system
        if until > 0.0
        else system
    )
    there = there.replace(shear_rate=system.shear_rate)
    off = system.velocities - system.domain.mean_flow(system.positions)
    return there.replace(velocities=off + there.domain.mean_flow(there.positions))


def contact_value(phi: float) -> float:
    """Carnahan & Starling's pair correlation at contact."""
    return (1.0 - 0.5 * phi) / (1.0 - phi) ** 3


def lun(phi: float, mass: float, diameter: float, restitution: float) -> tuple[float, float]:
    """Viscosity over √T and dissipation per volume over T^(3/2).

    Lun, Savage, Jeffrey & Chepurniy, J. Fluid Mech. 140, 223 (1984).
    """
    eta, g = 0.5 * (1.0 + restitution), contact_value(phi)
    mu = 5.0 * mass / (16.0 * diameter**2 * math.sqrt(math.pi))
    bulk = 256.0 * mu * phi**2 * g * eta / (5.0 * math.pi)
    first, second = 1.0 + 1.6 * eta * phi * g, 1.0 + 1.6 * eta * (3.0 * eta - 2.0) * phi * g
    viscosity = mu * first * second / (eta * (2.0 - eta) * g) + 0.6 * bulk
    density = mass / (math.pi / 6.0 * diameter**3)
    loss = 48.0 / math.sqrt(math.pi) * eta * (1.0 - eta) * density * phi**2 * g / diameter
    return viscosity, loss
