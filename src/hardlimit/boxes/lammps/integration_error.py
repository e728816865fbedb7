"""Errors of ε and β by LAMMPS' integration scheme, computed for isolated contacts.

LAMMPS' velocity Verlet evaluates the damping at the velocity half a step earlier: v_{n+½} = v_{n−½} − F(ξ_n, v_{n−½})
Δt/m, ξ_{n+1} = ξ_n + v_{n+½} Δt. With damping this scheme is of first order in the step.
"""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from ...contact import frictional_contact, impact
from ...contact.contact import Floats
from ...contact.friction import LIMITS, FrictionTerms

#: Phases of the first touch between two steps. The error jumps where the number of steps in the contact changes;
#: between these phases it is at most a few per cent larger.
PHASES: Final = (np.arange(128) + 0.6) / 128
BETWEEN: Final = 1.03
#: After so many steps it is tested whether all contacts have ended. Further steps do not change a contact that has: an
#: attractive force, too, lasts until the bodies separate.
LOOK: Final = 8
MIN_STEPS: Final = 10  #: smallest number of steps per contact, as for engine "steps"
#: Largest number of steps per contact that is tested. Beyond it the error is assumed proportional to the step.
MAX_STEPS: Final = 2000
MARGIN: Final = 1.1  #: safety factor of this assumption
TESTED: Final = np.array([1.0, 1.03, 1.07, 1.12, 1.2])  #: relative numbers of steps tested together
#: Phases for the error of β, and the largest number of steps for which it is computed.
FEW_PHASES: Final = PHASES[4::8]
SLOW: Final = 0.03  #: tangential speed at which surfaces stick, over μ and the normal speed
MAX_FRICTION_STEPS: Final = 400


def restitution_error(contact: Any, speed: float, time_step: float) -> float:
    """The largest error of ε over all phases of the first touch; infinite if a contact does not end."""
    return float(_restitution_errors(contact, speed, np.array([time_step]))[0])


def _restitution_errors(contact: Any, speed: float, time_steps: Floats) -> Floats:
    """The largest error of ε with each time step [s]: the contacts of all steps and phases are computed together."""
    time_step = np.repeat(time_steps, len(PHASES))
    compression, rate = speed * time_step * np.tile(PHASES, len(time_steps)), np.full(len(time_step), speed)
    over_mass = time_step / contact.effective_mass
    steps = math.ceil(float(contact.duration(np.array([speed]))[0]) / time_steps.min())
    for step in range(4 * steps + 100):
        force = contact.force(np.maximum(compression, 0.0), rate)
        if step % LOOK == 0 and not np.any((force != 0.0) | (rate > 0.0)):
            break
        rate = rate - force * over_mass
        compression = compression + rate * time_step
    exact = float(contact.restitution(np.array([speed]))[0])
    error = np.where((force != 0.0) | (rate > 0.0), math.inf, np.abs(-rate / speed - exact))
    largest: Floats = error.reshape(len(time_steps), -1).max(axis=1)
    return largest


def tangential_restitution(
    contact: Any,
    friction: FrictionTerms,
    tangential_mass: float,
    speed: float,
    tangential_speeds: Floats,
    time_step: float,
) -> Floats | None:
    """β under the scheme, by phase of the first touch and tangential speed; None if a contact does not end.

    The elastic tangential force grows by k_t g Δt in each step, at the slip rate g of half a step earlier, and is then
    reduced to Coulomb's limit. Before, a change of the contact radius multiplies it.
    """
    compression, rate = speed * time_step * FEW_PHASES, np.full(len(FEW_PHASES), speed)
    slip_rate = np.repeat(np.asarray(tangential_speeds)[None, :], len(FEW_PHASES), axis=0)
    elastic, before = np.zeros_like(slip_rate), np.zeros_like(compression)
    steps = math.ceil(float(contact.duration(np.array([speed]))[0]) / time_step)
    for step in range(4 * steps + 100):
        depth = np.maximum(compression, 0.0)
        force = contact.force(depth, rate)
        if step % LOOK == 0 and not np.any((force != 0.0) | (rate > 0.0)):
            return -slip_rate / tangential_speeds
        elastic = elastic * np.reshape(_kept(friction, before, depth), (-1, 1))
        columns = slip_rate, depth[:, None], np.abs(force)[:, None]
        elastic, tangential = _limited(friction, elastic, *columns, time_step)
        slip_rate = slip_rate - tangential * (time_step / tangential_mass)
        rate = rate - force * (time_step / contact.effective_mass)
        before, compression = depth, compression + rate * time_step
    return None


def _kept(friction: FrictionTerms, before: Floats, depth: Floats) -> Floats | float:
    """The factor by which a change of the contact radius multiplies the elastic force."""
    if friction.loading == friction.unloading == 0:
        return 1.0
    power = 0.5 * np.where(depth > before, friction.loading, friction.unloading)
    return np.where(before > 0.0, (depth / np.where(before > 0.0, before, 1.0)) ** power, 0.0)


def _limited(
    friction: FrictionTerms,
    elastic: Floats,
    slip_rate: Floats,
    depth: Floats,
    force: Floats,
    time_step: float,
) -> tuple[Floats, Floats]:
    """The elastic and the whole tangential force after a step."""
    touching = depth > 0.0
    powered = np.where(touching, depth, 1.0)
    stiffness = touching * friction.stiffness * powered ** (0.25 * friction.stiffness_power)
    damping = touching * friction.damping * powered ** (0.25 * friction.damping_power)
    limit = np.zeros_like(force)
    np.multiply(friction.coefficient, force, out=limit, where=force > 0.0)
    elastic, damped = elastic + stiffness * slip_rate * time_step, damping * slip_rate
    if friction.limit == LIMITS.index("total"):
        tangential = np.clip(elastic + damped, -limit, limit)
        slips = (tangential != elastic + damped) & (stiffness > 0.0)  # without a spring, nothing is kept
        return np.where(slips, tangential - damped, elastic), tangential
    clipped = np.clip(elastic, -limit, limit)
    return clipped, np.where(clipped == elastic, elastic + damped, clipped)


def longest_step(contact: Any, speed: float, error: float) -> float:
    """The longest time step [s] with an error of ε of at most ``error``; at most a tenth of the contact duration."""
    duration = float(contact.duration(np.array([speed]))[0])

    def largest_error(steps: float) -> float:
        # The error is not monotonic in the step, so slightly shorter steps are tested as well.
        return float(BETWEEN * _restitution_errors(contact, speed, duration / (TESTED * steps)).max())

    steps = float(MIN_STEPS)
    while (worst := largest_error(steps)) > error:
        if steps >= MAX_STEPS:
            return duration / (MARGIN * steps * worst / error)
        steps = min(MAX_STEPS, steps * min(4.0, max(1.1, worst / error)))
    return duration / steps


class LongestStep:
    """The longest time step [s] with an error of ε, and of β of surfaces that stick, of at most ``error``.

    The error of β is of first order without damping as well, since a contact begins between two steps.
    """

    def __init__(self, powers: tuple[int, int], inertia_factor: float) -> None:
        self._powers = (*powers, False)  #: 4p and 4q of K ξ^p + C ξ^q dξ/dt
        self._mass_ratio = 1.0 / (1.0 + 1.0 / inertia_factor)
        self._tried: dict[
            tuple[impact.FrictionalContact, float], float
        ] = {}  #: steps of contacts in their own units

    def __call__(self, contact: Any, speed: float, error: float) -> float:
        mass, terms = contact.effective_mass, FrictionTerms(*contact.friction_terms)
        numbers = impact.FrictionalContact(
            self._powers, contact.coefficients, mass, mass * self._mass_ratio, terms
        )
        own = frictional_contact.in_own_units(numbers, speed), error
        duration = float(contact.duration(np.array([speed]))[0])
        if own not in self._tried:
            fewest = duration / longest_step(contact, speed, error)
            self._tried[own] = _steps_of_friction(contact, numbers, speed, error, fewest)
        return duration / self._tried[own]


def _steps_of_friction(
    contact: Any, numbers: impact.FrictionalContact, speed: float, error: float, fewest: float
) -> float:
    """Number of steps per contact with this error of β, at least ``fewest``."""
    duration, most = float(contact.duration(np.array([speed]))[0]), float(MAX_FRICTION_STEPS)
    slow = np.array([SLOW * min(numbers.terms.coefficient, 1.0) * speed])
    exact = frictional_contact.tangential_restitution(numbers, speed, np.arctan(slow / speed))

    def largest_error(steps: float) -> float:
        values = numbers.terms, numbers.tangential_mass, speed, slow, duration / steps
        beta = tangential_restitution(contact, *values)
        return math.inf if beta is None else float(np.abs(beta - exact).max())

    steps = max(fewest, MARGIN * most * largest_error(most) / error)
    while steps < most and (worst := largest_error(steps)) > error:
        steps = min(most, steps * min(4.0, max(1.1, worst / error)))
    return steps
