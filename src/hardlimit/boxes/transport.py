"""Shear viscosity of a gas of spheres from means over its collisions, of any rule of collision.

To first order in the shear rate the velocities have ⟨c c⟩ = T (1 + A), and a pair that touches moves at E·k d besides,
with E the symmetric gradient of the flow and k the normal. Both are weights of the collisions of a gas at rest,
A:g g/4T and d k·E·g/2T for the relative velocity g. Four means over the collisions make the viscosity:

* relaxation R: −⟨Δ(g g)⟩ by A, at which collisions take the deformation A from the velocities;
* source S: ⟨Δ(g g)⟩ by E and the mean virial, what collisions add to the deformation by the flow;
* response C: the virial ⟨F r⟩ by A, the stress that collisions carry because of A;
* layers M: ⟨F r⟩ by E, the stress that collisions carry between layers of the flow.

A = −2 E (1 + S − q)/R and η = (1 + S − q)(1 + C)/R + M in n m d √T. q is the share by which ⟨c_y²⟩ along the gradient
is below T: the kinetic stress heats along the flow only, and collisions take this heat from all directions,
q R = L s/3 with the loss L and the share s of the kinetic stress in the work. For ε → 1 and without friction it is
Enskog's viscosity.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final, NamedTuple

import numpy as np

from .box import Floats

COLLISIONS: Final = 4096  #: of the means


class Transport(NamedTuple):
    """Means over collisions, over ν d/√T but for the relaxation, which is over ν."""

    relaxation: float
    source: float
    response: float
    layers: float


def viscosity(transport: Transport, rate: float, loss: float) -> float:
    """η in n m d √T. ``rate``: ν d/√T. ``loss``: of a collision in m T."""
    relaxation, source, response, layers = (rate * mean for mean in transport)
    free, lost, coupled = (1.0 + source) / relaxation, rate * loss / (3.0 * relaxation**2), 1.0 + response
    # a = (1 + S − q)/R and s = a/η: (1 + C) a² + (M + L/3R² − (1 + C)(1 + S)/R) a = M (1 + S)/R.
    linear = layers + lost - coupled * free
    kinetic = (math.sqrt(linear**2 + 4.0 * coupled * layers * free) - linear) / (2.0 * coupled)
    return kinetic * coupled + layers


def of_collisions(changes: Floats, virials: Floats, velocities: Floats) -> Transport:
    """From the changes of g g, the virials over m d/2, and g at touch, in a gas of T = 1; the normal is z."""
    normal = np.zeros_like(velocities)
    normal[:, 2] = 1.0
    means = (
        -_along(changes, velocities, velocities),
        20.0 / 3.0 * np.trace(virials, axis1=1, axis2=2) - _along(changes, normal, velocities),
        _along(virials, velocities, velocities),
        -_along(virials, normal, velocities),
    )
    return Transport(*(float(mean.mean()) / 80.0 for mean in means))


def _along(tensors: Floats, first: Floats, second: Floats) -> Floats:
    """The symmetric traceless parts of tensors, contracted with two vectors each."""
    symmetric = 0.5 * (_products(first, second) + _products(second, first))
    trace = np.trace(tensors, axis1=1, axis2=2) * np.sum(first * second, axis=1)
    along: Floats = np.einsum("nij,nij->n", tensors, symmetric) - trace / 3.0
    return along


def _products(first: Floats, second: Floats) -> Floats:
    product: Floats = first[:, :, None] * second[:, None, :]
    return product


def of_rule(restitution: float, beta: Callable[[Floats], Floats], theta: float, q: float) -> Transport:
    """That of hard spheres with β(tan γ). ``theta``: T_r/T. ``q``: inertia factor."""
    velocities, spins = impacts(COLLISIONS, theta, q, 3)
    speed = -velocities[:, 2]
    surface = velocities[:, :2] + np.stack([-spins[:, 1], spins[:, 0]], axis=1)
    tangents = np.linalg.norm(surface, axis=1) / speed
    impulses = np.zeros_like(velocities)  # over m/2
    impulses[:, 2] = (1.0 + restitution) * speed
    impulses[:, :2] = -((1.0 + beta(tangents)) / (1.0 + 1.0 / q))[:, None] * surface
    after, normal = velocities + impulses, np.zeros_like(velocities)
    normal[:, 2] = 1.0
    changes = _products(after, after) - _products(velocities, velocities)
    return of_collisions(changes, _products(impulses, normal), velocities)


def impacts(n: int, theta: float, q: float, dimension: int) -> tuple[Floats, Floats]:
    """Velocities and spins times the diameter of the pairs that collide in a gas of T = 1: (n, 3) each.

    The normal is z and the first particle is at rest: the second approaches along −z. Quasi-random, with fixed seed.
    """
    from scipy import special
    from scipy.stats import qmc  # which other uses must not wait for

    u = qmc.Sobol(5, seed=1).random(n)
    velocity, spin = np.zeros((n, 3)), np.zeros((n, 3))
    velocity[:, 2] = -2.0 * np.sqrt(-np.log1p(-u[:, 0]))
    width = math.sqrt(2.0 * theta / q)
    if dimension == 3:
        velocity[:, 0] = 2.0 * np.sqrt(-np.log1p(-u[:, 1]))
        spin[:] = width * special.ndtri(np.clip(u[:, 2:], 1e-12, 1.0 - 1e-12))
    else:
        normal = special.ndtri(np.clip(u[:, 1:3], 1e-12, 1.0 - 1e-12))
        velocity[:, 0], spin[:, 1] = math.sqrt(2.0) * normal[:, 0], width * normal[:, 1]
    return velocity, spin
