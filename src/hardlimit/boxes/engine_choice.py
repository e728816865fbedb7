"""Choice of the engine for Newton's equations, by an estimate of the cost per contact."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final, NamedTuple

import numpy as np

from .. import _core
from ..contact.contact import Law
from ..contact.friction import SPRING
from ..contact.laws import LinearDashpot
from ..support import validation
from . import time_step
from .box import AXES
from .contacts import impact_temperature, mean_contact, rubs
from .falling_frame import engine_arguments
from .system import ROUNDING, ParticleSystem
from .theory import Gas

#: Shortest periodic edge for engine events, in units of the largest radius.
SMALLEST_EDGE: Final = 4.2
#: Cost of a contact [µs], fitted to boxes of 300 to 4000 particles (docs/engines.md). By events: a constant, and the
#: factor of t_c ν. By steps: a constant, and the factor of 1/(ν Δt), the number of steps between two contacts.
BY_EVENTS: Final = (1.6, 35.0)
BY_STEPS: Final = (9.0, 0.0045)
#: The same with friction, under linear laws with a tangential spring.
BY_EVENTS_WITH_FRICTION: Final = (25.0, 1.5e3)
BY_STEPS_WITH_FRICTION: Final = (30.0, 0.0033)
#: Packing fraction of the densest disordered packings, by dimension.
DENSEST: Final = {2: 0.84, 3: 0.64}


class Choice(NamedTuple):
    engine: str
    reason: str


class Overlap(NamedTuple):
    """t_c ν, the number of contacts that a particle makes during one contact, and the part of the run it holds for."""

    tc_nu: float
    when: str


def chosen(system: ParticleSystem, law: Law, until: float, of_steps: Mapping[str, Any]) -> Choice:
    """The engine for a run until a time [s]: steps if an option is given that only steps accept, else the one that is
    :func:`estimated` to be cheaper."""
    for name, value in of_steps.items():
        if value is not None:
            return Choice("steps", f"only engine steps accepts {name}")
    return estimated(system, law, until)


def estimated(
    system: ParticleSystem, law: Law, until: float, restitution_error: float | None = None
) -> Choice:
    """The engine with the lower cost per contact, for a time step with this error of ε.

    The costs and the three values of t_c ν are described in the notes of :func:`hardlimit.molecular_dynamics`.
    """
    if rubs(law) and not has_whole_contacts(law):
        return Choice(
            "steps", "with friction only contacts under linear laws with a spring are fast by events"
        )
    try:
        check_box(system)
        check_friction(law)
    except ValueError as error:
        return Choice("steps", str(error))
    duration, restitution, temperature = typical_contact(system, law)
    rate = _collision_rate(system, temperature)
    most = max(
        Overlap(rate * duration if rate > 0.0 else 0.0, "at the start"),
        Overlap(open_contacts(system), "by the contacts that are open at the start"),
        of_bed(system, duration, restitution, until),
    )
    if most.tc_nu == 0.0:
        return Choice("events", "no contacts are expected")
    if not most.tc_nu < 2.0 * system.dimension:  # contacts per particle of an isostatic packing
        return Choice("steps", f"contacts last, t_c ν = {most.tc_nu:.2g} {most.when}")
    at = f"at t_c ν = {most.tc_nu:.2g} {most.when} a contact costs about"
    of_events, of_steps = (BY_EVENTS, BY_STEPS)
    if rubs(law):
        of_events, of_steps = (BY_EVENTS_WITH_FRICTION, BY_STEPS_WITH_FRICTION)
    by_events, by_steps = of_events[0] + of_events[1] * most.tc_nu, of_steps[0]
    if by_events <= by_steps:  # for any time step; the search for the step would take time
        return Choice("events", f"{at} {by_events:.2g} µs by events, more than {by_steps:g} µs by steps")
    step = time_step.chosen(system, law, restitution_error, None)
    by_steps += of_steps[1] * duration / (most.tc_nu * step)
    name = "events" if by_events <= by_steps else "steps"
    return Choice(name, f"{at} {by_events:.2g} µs by events, {by_steps:.2g} µs by steps")


def has_whole_contacts(law: Law) -> bool:
    """Whether engine events solves an isolated contact with friction as a whole: a linear law with a spring."""
    return law.friction is not None and law.friction.model == SPRING and isinstance(law, LinearDashpot)


def typical_contact(system: ParticleSystem, law: Law) -> tuple[float, float, float]:
    """Duration [s] (infinite if it does not end) and ε of a typical contact, and the initial temperature [m²/s²].

    The contact is that of two particles of mean mass and radius at the mean impact speed √(πT), where T is the initial
    temperature or that of the atmosphere that settles, whichever is larger. Moving walls heat to about their own speed.
    """
    temperature = max(impact_temperature(system), system.domain.fastest_wall**2)
    hottest = max(temperature, _bed_temperature(system))
    contact = mean_contact(system, law)
    speed = np.array([math.sqrt(math.pi * hottest) or 1.0])
    duration, restitution = float(contact.duration(speed)[0]), float(contact.restitution(speed)[0])
    return duration if duration >= 0.0 else math.inf, restitution if restitution >= 0.0 else 0.0, temperature


def open_contacts(system: ParticleSystem) -> float:
    """Number of open contacts per particle in this state; in a gas its mean is t_c ν."""
    if system._deepest_relative_overlap <= 2.0 * ROUNDING:
        return 0.0
    at_rest = engine_arguments(system.replace(velocities=np.zeros_like(system.velocities)))
    law = ("linear", 0, [1.0, 1.0], None)
    in_contact = _core.make_engine("newton_steps", *at_rest, law=law, time_step=1.0).observe()["n_in_contact"]
    return 2.0 * float(in_contact) / system.n


def of_bed(system: ParticleSystem, duration: float, restitution: float, until: float) -> Overlap:
    """t_c ν at the end of a run in which gravity g pulls the particles to a wall.

    The particles are modelled as an isothermal atmosphere of temperature T over a floor of area A, with
    L = Nσ^(d−1)/A layers. Its energy per unit mass is (d/2 + 1)T and its collision rate ν = a g/√T. It loses
    (1 − ε²) T ν/2 in collisions of pairs, and at the floor as much as a bouncing ball. √T therefore decreases linearly:
    d√T/dt = −g [(1 − ε²) b/2 + (1 − ε) c]/(d + 2), with a = b + c/(d + 2), b = (d − 1)√π L, c = √(d + 2)/2. The bed is
    at rest after the time of the fall plus the time in which T reaches zero. χ is taken as 1. Not for
    moving walls, over which a bed does not come to rest.
    """
    axis, pull = _pull(system)
    if pull == 0.0 or system.domain.fastest_wall > 0.0:
        return Overlap(0.0, "")
    pull, d = abs(pull), system.dimension
    layers = float(np.sum((2.0 * system.radius) ** (d - 1))) / float(np.prod(np.delete(system.box, axis)))
    pairs = (d - 1) * math.sqrt(math.pi) * layers
    floor = 0.5 * math.sqrt(d + 2.0)
    slows = pull * (1.0 - restitution) * (0.5 * (1.0 + restitution) * pairs + floor) / (d + 2)
    start = math.sqrt(_bed_temperature(system))
    at_rest = math.sqrt(2.0 * _fall(system) / pull) + (start / slows if slows > 0.0 else math.inf)
    if until >= at_rest or start == 0.0:
        return Overlap(math.inf, f"in a bed that is at rest after about {at_rest if start else 0.0:.2g} s")
    end = start * (1.0 - until / at_rest)
    return Overlap(duration * pull * (pairs + floor / (d + 2)) / end, "at the end, in a bed that settles")


def check_friction(law: Law) -> None:
    """Refuse friction that the engine by events does not solve: forces that jump, and springs that begin singular.

    Raises
    ------
    ValueError
    """
    friction = law.friction
    if friction is None or friction.coefficient == 0.0 or friction.model == "none":
        return
    if not (friction.damping_ratio or friction.damping):
        return
    if friction.limit == "spring" and friction.coefficient < math.inf:
        raise ValueError(
            "limit: got 'spring' with tangential damping, must be 'total' for engine='events' (or engine='steps')"
        )
    if friction.damping and friction.model != "spring":
        raise ValueError(
            f"damping: got it with the model {friction.model}, must be damping_ratio for engine='events'"
        )


def check_box(system: ParticleSystem) -> None:
    """Refuse boxes in which a particle could come near two images of another one: engine events cannot handle them."""
    least = SMALLEST_EDGE * float(system.radius.max())
    for axis, side in enumerate(system.boundary):
        if side == "periodic" and not system.box[axis] >= least:
            raise ValueError(
                f"box: got {system.box[axis]:.6g} m along {AXES[axis]} (periodic), must be >= "
                f"{validation.at_least(least)} m for engine 'events', {SMALLEST_EDGE:g} times the largest radius"
            )


def _collision_rate(system: ParticleSystem, temperature: float) -> float:
    """Enskog's collision rate [1/s] for particles of mean size, with the density limited to that of a packing."""
    n, d = system.n, system.dimension
    packed = system.packing_fraction * system.domain.volume / DENSEST[d]
    gas = Gas(n, float(system.radius.mean()), 1.0, max(system.domain.volume, packed), d)
    return (n - 1) / n * float(gas.collision_rate(temperature))


def _pull(system: ParticleSystem) -> tuple[int, float]:
    """The axis with walls along which gravity is largest, and its signed component [m/s²]."""
    pulls = system.gravity - system.domain.common_fall
    axis = int(np.argmax(np.abs(pulls)))
    return axis, float(pulls[axis])


def _bed_temperature(system: ParticleSystem) -> float:
    """Temperature [m²/s²] of an atmosphere with the energy that these particles have above a packing at rest."""
    pull = abs(_pull(system)[1])
    if pull == 0.0:
        return 0.0
    energy = system.kinetic_energy / float(system.mass.sum()) + pull * _fall(system)
    return 2.0 * energy / (system.dimension + 2)


def _fall(system: ParticleSystem) -> float:
    """Height of the centre of mass above that of a packing on the floor [m]."""
    axis, pull = _pull(system)
    height = float(system.mass @ system.positions[:, axis]) / float(system.mass.sum())
    above = height if pull < 0.0 else float(system.box[axis]) - height
    area = float(np.prod(np.delete(system.box, axis)))
    packed = system.packing_fraction * system.domain.volume / (DENSEST[system.dimension] * area)
    return max(0.0, above - max(0.5 * packed, float(system.radius.mean())))
