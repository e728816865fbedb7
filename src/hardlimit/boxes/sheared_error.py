"""What Newton's equations change in the shear viscosity of spheres that rub, by quadratures over isolated contacts.

The four means of transport.py, for contacts that turn while they last and for a fixed normal: docs/driven_gases.md.

Units: radii 1, masses 2, T = 1; rates over ν.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np

from .. import _core
from ..contact.contact import Contact
from .box import Floats
from .frictional_error import FLAT, INSTANTS, SIZE, TURNING, Setting, mean_duration
from .transport import Transport, impacts, of_collisions, viscosity

#: Relative changes of the means by the pressure of neighbours over s w/d, those of smooth spheres.
PRESSED: Final = Transport(0.0, 0.5, 0.5, 0.25 * math.pi)
NODES, WEIGHTS = np.polynomial.legendre.leggauss(INSTANTS)
#: Nodes in the normal and in the tangential velocity of smooth spheres, and the largest of both.
SPEEDS: Final = 12
FASTEST: Final = 12.0


class Flowing(NamedTuple):
    """Hard spheres, and how much their means change with the turn of contacts, relative and over w/d."""

    hard: Transport
    turned: Transport


def viscosity_ratio(
    flowing: Flowing,
    *,
    density: float,
    slope: float,
    growth: float,
    loss: float,
    tc_nu: float,
    dissipation: float,
) -> float:
    """Viscosity of hard spheres over that under Newton's equations at equal kinetic temperature.

    Means change to first order in t_c ν, by which none becomes negative. NaN where nothing is left of
    the relaxation or the viscosity.

    ``density``, ``slope``, ``growth``: D 2^D φ χ, s and D φ χ'/χ of the fluid. ``loss``: of a collision in m T.
    ``dissipation``: that under Newton's equations over that of hard spheres at equal temperature.
    """
    rate, hard = density / math.sqrt(math.pi), flowing.hard
    after = Transport(
        *(
            mean * max(1.0 + tc_nu * (turn + slope * (press - 1.0) - growth) / density, 0.0)
            for mean, turn, press in zip(hard, flowing.turned, PRESSED, strict=True)
        )
    )
    soft = viscosity(after, rate, loss * dissipation) if after.relaxation > 0.0 else 0.0
    return viscosity(hard, rate, loss) / soft if soft > 0.0 else math.nan


@lru_cache(maxsize=128)
def flowing(setting: Setting) -> Flowing:
    """The means of spheres at the temperature ratio of the setting."""
    contact = setting.contact()
    pairs = _smooth_impacts() if setting.friction.coefficient == 0.0 else _impacts(contact, setting.theta)
    diameter = mean_duration(contact) / (math.sqrt(math.pi) * SIZE)
    turning, hard = (_transport(contact, d, *pairs) for d in (diameter, FLAT * diameter))
    changes = ((turn / flat - 1.0) / SIZE for turn, flat in zip(turning, hard, strict=True))
    return Flowing(hard, Transport(*changes))


def _impacts(contact: Contact, theta: float) -> tuple[Floats, Floats, Floats]:
    """Velocities, spins times the diameter, and weights of pairs that collide."""
    velocities, spins = impacts(TURNING[True], theta, contact.ball.inertia_factor, 3)
    return velocities, spins, np.full(len(velocities), 1.0 / len(velocities))


def _smooth_impacts() -> tuple[Floats, Floats, Floats]:
    """Those of smooth spheres, which depend on two speeds only."""
    node, of_node = np.polynomial.legendre.leggauss(SPEEDS)
    speed = 0.5 * FASTEST * (1.0 + node)
    share = 0.25 * FASTEST * of_node * speed * np.exp(-0.25 * speed**2)
    velocities = np.zeros((SPEEDS**2, 3))
    velocities[:, 2], velocities[:, 0] = -np.repeat(speed, SPEEDS), np.tile(speed, SPEEDS)
    return velocities, np.zeros_like(velocities), np.outer(share, share).ravel()


def _transport(
    contact: Contact, diameter: float, velocities: Floats, spins: Floats, weights: Floats
) -> Transport:
    """That of contacts at a diameter; ``spins``: times it."""
    normal = np.array([0.0, 0.0, 1.0])
    ratio = contact.effective_mass / contact.tangential_mass - 1.0
    changes, virials = np.zeros((2, len(velocities), 3, 3))
    for i, (v, s) in enumerate(zip(velocities, spins / diameter, strict=True)):
        approach = contact.core, diameter, diameter, ratio, normal, v, s
        end = _core.turning_contact(*approach)
        after, half = np.array(end["velocity"]), 0.5 * end["duration"]
        path = _core.turning_path(*approach, half * (1.0 + NODES))[:, 3:6]
        squares = half * np.einsum("t,ti,tj->ij", WEIGHTS, path, path)
        # ∫ F r dt = [v r] − ∫ v v dt, in the effective mass
        first, last = diameter * normal, diameter * normal + np.array(end["shift"])
        virials[i] = (np.outer(after, last) - np.outer(v, first) - squares) / diameter
        changes[i] = np.outer(after, after) - np.outer(v, v)
    return of_collisions(changes, virials, velocities, weights)
