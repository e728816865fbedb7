"""Error of ε by LAMMPS' integration scheme, computed for isolated contacts.

LAMMPS' velocity Verlet evaluates the damping at the velocity half a step earlier: v_{n+½} = v_{n−½} − F(ξ_n, v_{n−½})
Δt/m, ξ_{n+1} = ξ_n + v_{n+½} Δt. With damping this scheme is of first order in the step.
"""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

#: Phases of the first touch between two steps. The error jumps where the number of steps in the contact changes;
#: between these phases it is at most a few per cent larger.
PHASES: Final = (np.arange(128) + 0.6) / 128
BETWEEN: Final = 1.03
MIN_STEPS: Final = 10  #: smallest number of steps per contact, as for engine "steps"
#: Largest number of steps per contact that is tested. Beyond it the error is assumed proportional to the step.
MAX_STEPS: Final = 2000
MARGIN: Final = 1.1  #: safety factor of this assumption
TESTED: Final = np.array([1.0, 1.03, 1.07, 1.12, 1.2])  #: relative numbers of steps tested together


def restitution_error(contact: Any, speed: float, time_step: float) -> float:
    """The largest error of ε over all phases of the first touch; infinite if a contact does not end."""
    compression, rate = speed * time_step * PHASES, np.full(len(PHASES), speed)
    over_mass = time_step / contact.effective_mass
    steps = math.ceil(float(contact.duration(np.array([speed]))[0]) / time_step)
    for _ in range(4 * steps + 100):
        force = contact.force(np.maximum(compression, 0.0), rate)
        if not np.any((force != 0.0) | (rate > 0.0)):  # an attractive force lasts until the bodies separate
            break
        rate = rate - force * over_mass
        compression = compression + rate * time_step
    else:
        return math.inf
    exact = float(contact.restitution(np.array([speed]))[0])
    return float(np.abs(-rate / speed - exact).max())


def longest_step(contact: Any, speed: float, error: float) -> float:
    """The longest time step [s] with an error of ε of at most ``error``; at most a tenth of the contact duration."""
    duration = float(contact.duration(np.array([speed]))[0])

    def largest_error(steps: float) -> float:
        # The error is not monotonic in the step, so slightly shorter steps are tested as well.
        return BETWEEN * max(restitution_error(contact, speed, duration / n) for n in TESTED * steps)

    steps = float(MIN_STEPS)
    while (worst := largest_error(steps)) > error:
        if steps >= MAX_STEPS:
            return duration / (MARGIN * steps * worst / error)
        steps = min(MAX_STEPS, steps * min(4.0, max(1.1, worst / error)))
    return duration / steps
