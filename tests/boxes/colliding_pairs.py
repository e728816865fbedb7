"""Means over the collisions of hard spheres by their rule, beside those of contacts followed in time."""

import numpy as np

from hardlimit.boxes import transport


def of_rule(restitution, grip, theta, q) -> transport.Transport:
    """That of hard spheres with ``grip``, 1 + β(tan γ). ``theta``: T_r/T. ``q``: inertia factor."""
    n = 4096
    velocities, spins = transport.impacts(n, theta, q, 3)
    speed = -velocities[:, 2]
    surface = velocities[:, :2] + np.stack([-spins[:, 1], spins[:, 0]], axis=1)
    tangents = np.linalg.norm(surface, axis=1) / speed
    impulses = np.zeros_like(velocities)  # over m/2
    impulses[:, 2] = (1.0 + restitution) * speed
    impulses[:, :2] = -(grip(tangents) / (1.0 + 1.0 / q))[:, None] * surface
    after, normal = velocities + impulses, np.zeros_like(velocities)
    normal[:, 2] = 1.0
    changes = np.einsum("ni,nj->nij", after, after) - np.einsum("ni,nj->nij", velocities, velocities)
    virials = np.einsum("ni,nj->nij", impulses, normal)
    return transport.of_collisions(changes, virials, velocities, np.full(n, 1.0 / n))
