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
#: t_c ν at which slopes are taken.
SMALL: Final = 1e-4
NODES, WEIGHTS = np.polynomial.legendre.leggauss(INSTANTS)


class Flowing(NamedTuple):
    """Hard spheres, and how much their means change with the turn of contacts, relative and over w/d."""

    hard: Transport
    turned: Transport


def viscosity_slope(
    flowing: Flowing, *, density: float, slope: float, growth: float, loss: float, loss_slope: float
) -> float:
    """d ln η/d(t_c ν) under Newton's equations at equal kinetic temperature.

    ``density``, ``slope``, ``growth``: D 2^D φ χ, s and D φ χ'/χ of the fluid. ``loss``: of a collision in m T.
    ``loss_slope``: d ln of the dissipation at equal temperature.
    """
    rate, hard = density / math.sqrt(math.pi), flowing.hard
    # The source follows the response by Onsager's symmetry.
    turned = flowing.turned._replace(source=flowing.turned.response)
    after = Transport(
        *(
            mean * (1.0 + SMALL * (turn + slope * (press - 1.0) - growth) / density)
            for mean, turn, press in zip(hard, turned, PRESSED, strict=True)
        )
    )
    dissipating = loss * (1.0 + SMALL * loss_slope)
    return math.log(viscosity(after, rate, dissipating) / viscosity(hard, rate, loss)) / SMALL


@lru_cache(maxsize=128)
def flowing(setting: Setting) -> Flowing:
    """The means of spheres at the temperature ratio of the setting."""
    contact = setting.contact()
    velocities, spins = impacts(TURNING[True], setting.theta, contact.ball.inertia_factor, 3)
    diameter = mean_duration(contact) / (math.sqrt(math.pi) * SIZE)
    turning, hard = (_transport(contact, d, velocities, spins) for d in (diameter, FLAT * diameter))
    changes = ((turn / flat - 1.0) / SIZE for turn, flat in zip(turning, hard, strict=True))
    return Flowing(hard, Transport(*changes))


def _transport(contact: Contact, diameter: float, velocities: Floats, spins: Floats) -> Transport:
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
    return of_collisions(changes, virials, velocities)
