"""Choice of the time step of a run by steps, from its errors in isolated contacts."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final

import numpy as np

from .. import _core
from ..contact.contact import Law
from ..support import validation
from . import contacts
from .system import ParticleSystem
from .theory import Gas
from .thermostats import Andersen

DEFAULT_ERROR: Final = 1e-3  #: of ε, and for engine "steps" of energy and positions
SMALLEST_ERROR: Final = 1e-9  #: about ten thousand steps per contact
LARGEST_ERROR: Final = 0.05
#: Speeds of the test contacts, relative to the largest expected speed.
SPEEDS: Final = (1.0, 0.1, 0.01)
#: Largest distance that a particle moves in a step, relative to the smallest radius.
FARTHEST: Final = 0.1
#: The error of velocity Verlet in a motion of the angular frequency ω is (ω Δt)² over this.
VERLET: Final = 12.0
#: ε of a heated gas that loses less: its temperature would rise without limit.
LARGEST_RESTITUTION: Final = 0.999
#: Longest step [s] of an integration scheme, as a function of contact, speed [m/s] and error.
LongestStep = Callable[[_core.Contact, float, float], float]


def chosen(
    system: ParticleSystem,
    law: Law,
    restitution_error: Any,
    time_step: Any,
    longest_step: LongestStep = _core.longest_step,
) -> float:
    """The time step [s] of a run: the given one, or the longest one with the accepted error."""
    if restitution_error is not None and time_step is not None:
        raise ValueError("restitution_error | time_step: got both, must be at most one of them")
    if time_step is None:
        return _longest(system, law, accepted_error(restitution_error), longest_step)
    step = validation.number("time_step", time_step, 0.0)
    limit = _longest(system, law, LARGEST_ERROR, longest_step)
    if step > limit:
        raise ValueError(
            f"time_step: got {step:.6g} s, must be <= {validation.at_most(limit)} s, "
            "the longest step with which the contacts of this system are stable"
        )
    return step


def accepted_error(value: Any) -> float:
    """The error of ε that a time step may cause: the given one, or the default if it is None."""
    wanted = DEFAULT_ERROR if value is None else value
    limits = {"lowest_allowed": True, "highest_allowed": True}
    return validation.number("restitution_error", wanted, SMALLEST_ERROR, LARGEST_ERROR, **limits)


def _longest(system: ParticleSystem, law: Law, error: float, longest_step: LongestStep) -> float:
    """The longest step with this error in all expected contacts in which no particle can pass through another."""
    top = max(largest_speed(system), 2.0 * heated_speed(system, law))
    # Without motion and gravity only initial overlaps drive contacts; their speed does not matter here.
    tried = top if top > 0.0 else 1.0
    found = FARTHEST * float(system.radius.min()) / tried if top > 0.0 else math.inf
    shaken = max((wall.frequency for wall in system.walls.values() if wall.oscillates), default=0.0)
    if shaken > 0.0:
        found = min(found, math.sqrt(VERLET * error) / (2.0 * math.pi * shaken))
    for contact in contacts.of_kinds(system, law):
        for relative_speed in SPEEDS:
            found = min(found, longest_step(contact, relative_speed * tried, error))
    return found


def largest_speed(system: ParticleSystem) -> float:
    """The largest expected impact speed [m/s]: twice the largest speed, plus the speed after a fall through the box.

    In a sheared box speeds are relative to the mean flow, whose difference over a diameter is added.
    """
    velocities = system.velocities - system.domain.mean_flow(system.positions)
    fastest = math.sqrt(float(np.einsum("ij,ij->i", velocities, velocities).max()))
    fastest += abs(system.shear_rate) * float(system.radius.max())
    fall = float(np.abs(system.gravity) @ system.box)
    return 2.0 * (fastest + system.domain.fastest_wall) + math.sqrt(2.0 * fall)


def heated_speed(system: ParticleSystem, law: Law) -> float:
    """The largest expected speed of a particle in the steady state of a thermostat [m/s]; 0 without one."""
    heat, mean = system.thermostat, float(system.mass.mean())
    if heat is None:
        return 0.0
    if isinstance(heat, Andersen):
        temperature = heat.temperature
    else:  # the steady state of a gas of mean particles, whose ε depends on its temperature
        size, volume, d = float(system.radius.mean()), float(np.prod(system.box)), system.dimension
        gas, temperature = Gas(system.n, size, mean, volume, d), 0.0
        for _ in range(10):
            speed = math.sqrt(math.pi * temperature)
            found = min(
                float(one.restitution(np.array([speed]))[0]) for one in contacts.of_kinds(system, law)
            )
            temperature = gas.heated_temperature(heat.power, min(found, LARGEST_RESTITUTION))
    # The fastest of N particles with Maxwell's distribution.
    highest = system.dimension + 2.0 * math.log(system.n)
    return math.sqrt(temperature * mean / float(system.mass.min()) * highest)
