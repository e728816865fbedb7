"""Shear viscosity of a gas of spheres from means over its collisions, which may last.

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
from typing import NamedTuple

import numpy as np

from .box import Floats


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


def of_collisions(changes: Floats, virials: Floats, velocities: Floats, weights: Floats) -> Transport:
    """From the changes of g g, the virials over m d/2, and g at touch, in a gas of T = 1; the normal is z."""
    normal = np.zeros_like(velocities)
    normal[:, 2] = 1.0
    means = (
        -along(changes, velocities, velocities),
        20.0 / 3.0 * np.trace(virials, axis1=1, axis2=2) - along(changes, normal, velocities),
        along(virials, velocities, velocities),
        -along(virials, normal, velocities),
    )
    return Transport(*(float(weights @ mean) / 80.0 for mean in means))


def along(tensors: Floats, first: Floats, second: Floats) -> Floats:
    """The symmetric traceless parts of tensors, contracted with two vectors each."""
    forth, back = (np.einsum(f"n{ij},ni,nj->n", tensors, first, second) for ij in ("ij", "ji"))
    contracted: Floats = 0.5 * (forth + back)
    contracted -= np.trace(tensors, axis1=1, axis2=2) * np.sum(first * second, axis=1) / 3.0
    return contracted


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
