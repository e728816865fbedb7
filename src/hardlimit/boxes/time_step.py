"""Choice of the time step of a run by steps, from its errors in isolated contacts."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final

import numpy as np

from .. import _core
from ..contact.contact import Law
from ..contact.friction import FrictionTerms
from ..support import validation
from . import contacts, spins
from .box import Box
from .system import ParticleSystem
from .theory import Gas
from .thermostats import Andersen
from .walls import MovingWall

DEFAULT_ERROR: Final = 1e-3  #: of ε, and for engine "steps" of energy and positions
SMALLEST_ERROR: Final = 1e-9  #: about ten thousand steps per contact
LARGEST_ERROR: Final = 0.05
#: Speeds of the test contacts, relative to the largest expected speed.
SPEEDS: Final = (1.0, 0.1, 0.01)
#: Largest distance that a particle moves in a step, relative to the smallest radius.
FARTHEST: Final = 0.1
#: The error of velocity Verlet in a motion of the angular frequency ω is (ω Δt)² over this.
VERLET: Final = 12.0
#: Largest share of a tangential speed that its damping takes in a step: packings, where up to twelve contacts turn a
#: particle, are stable up to 0.37, and up to 0.25 with the springs of the longest steps.
DAMPED: Final = 0.25
#: Oscillations of a wall during a contact up to which the ball follows it, and its energy is that of an impact.
SLOW_WALL: Final = 0.1
#: Steps of the first trial of a particle on such a wall, and how often the step may be halved.
MOST_TRIED: Final = 20_000
MOST_HALVINGS: Final = 6
ENERGIES: Final = ("kinetic", "potential", "contact", "dissipated")
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
        error = accepted_error(restitution_error)
        return _longest_at_walls(system, law, error, _longest(system, law, error, longest_step))
    step = validation.number("time_step", time_step, 0.0)
    # Shear may end before it has heated the grains.
    limit = _longest(system, law, LARGEST_ERROR, longest_step, shear_heats=False)
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


def _longest(
    system: ParticleSystem, law: Law, error: float, longest_step: LongestStep, shear_heats: bool = True
) -> float:
    """The longest step with this error in all expected contacts in which no particle can pass through another."""
    top = max(largest_speed(system), 2.0 * heated_speed(system, law, shear_heats))
    # Without motion and gravity only initial overlaps drive contacts; their speed does not matter here.
    tried = top if top > 0.0 else 1.0
    step = FARTHEST * float(system.radius.min()) / tried if top > 0.0 else math.inf
    shaken = max((wall.frequency for wall in system.walls.values() if wall.oscillates), default=0.0)
    if shaken > 0.0:
        step = min(step, math.sqrt(VERLET * error) / (2.0 * math.pi * shaken))
    for contact in contacts.of_kinds(system, law):
        for relative_speed in SPEEDS:
            step = min(step, longest_step(contact, relative_speed * tried, error))
            step = min(step, _longest_of_friction(system, contact, relative_speed * tried, error))
    return step


def _longest_of_friction(system: ParticleSystem, contact: _core.Contact, speed: float, error: float) -> float:
    """The longest step with this error of β while the surfaces stick, which is stable in a packing as well.

    β is then cos ωt of the tangential spring, at the end t of the contact. Velocity Verlet makes ω larger by the factor
    1 + (ω Δt)²/24, so that β changes by (ω Δt)² ωt/24 at most.
    """
    terms = FrictionTerms(*contact.friction_terms)
    if not terms.coefficient > 0.0:
        return math.inf
    at = np.array([speed])
    deepest, lasts = float(contact.compression(at)[0]), float(contact.duration(at)[0])
    factor = spins.solid(1, system.dimension) if system.inertia_factor is None else system.inertia_factor
    tangential_mass = contact.effective_mass / (1.0 + 1.0 / float(factor.min()))
    stiffness = terms.stiffness * deepest ** (0.25 * terms.stiffness_power)
    if not stiffness > 0.0:
        return math.inf
    damping = terms.damping * deepest ** (0.25 * terms.damping_power)
    longest = DAMPED * tangential_mass / damping if damping > 0.0 else math.inf
    frequency = math.sqrt(stiffness / tangential_mass)
    return min(longest, math.sqrt(2.0 * VERLET * error / (frequency * lasts)) / frequency)


def _longest_at_walls(system: ParticleSystem, law: Law, error: float, longest: float) -> float:
    """The longest step with which the lightest and the heaviest particle balance their energy on oscillating walls.

    If a wall oscillates during a contact, its work on the particle is the small difference of large gains and losses:
    the step must be shorter than impacts at the speed of the wall require. Otherwise nothing is tried.
    """
    for wall in system.walls.values():
        for i in {int(system.mass.argmin()), int(system.mass.argmax())}:
            grain = float(system.radius[i]), float(system.mass[i])
            lasts = float(contacts.contact(law, grain[1], grain[0]).duration(np.array([wall.fastest]))[0])
            if wall.oscillates and wall.frequency * lasts > SLOW_WALL:
                until = min(3.0 * lasts + 10.0 / wall.frequency, MOST_TRIED * longest)
                for _ in range(MOST_HALVINGS):
                    if _imbalance(system, law, wall, grain, until, longest) <= error:
                        break
                    longest *= 0.5
    return longest


def _imbalance(
    system: ParticleSystem, law: Law, wall: MovingWall, grain: tuple[float, float], until: float, step: float
) -> float:
    """Error of the energy balance of a particle (radius, mass) that lies on a wall at its highest place.

    Relative to its largest kinetic or dissipated energy. Without gravity it falls at a thousandth of the acceleration
    of the wall.
    """
    radius, mass = grain
    pull = max(float(np.abs(system.gravity).max()), 1e-3 * wall.amplitude * wall.frequency**2)
    moving = MovingWall(wall.amplitude, wall.frequency, wall.waveform)
    edges = np.full(2, 8.0 * (radius + wall.amplitude))
    box = Box(edges, ("periodic", "wall"), np.array([0.0, -pull]), {"y-": moving})
    engine = _core.make_engine(
        "newton_steps",
        box.of_core(),
        np.array([[radius, radius + (1.0 + 1e-4) * wall.amplitude]]),
        np.zeros((1, 2)),
        np.array([radius]),
        np.array([mass]),
        law=contacts.law_arguments(law),
        time_step=step,
    )
    total, scale = [], 0.0
    for time in np.linspace(0.0, until, 21):
        engine.advance(time)
        now = engine.observe()
        total.append(sum(now[f"{kind}_energy"] for kind in ENERGIES) - now["wall_work"])
        scale = max(scale, now["kinetic_energy"], now["dissipated_energy"])
    return max(abs(energy - total[0]) for energy in total) / scale if scale > 0.0 else 0.0


def largest_speed(system: ParticleSystem) -> float:
    """The largest expected impact speed [m/s]: twice the largest speed, plus the speed after a fall through the box.

    In a sheared box speeds are relative to the mean flow, whose difference over a diameter is added.
    """
    velocities = system.velocities - system.domain.mean_flow(system.positions)
    fastest = math.sqrt(float(np.einsum("ij,ij->i", velocities, velocities).max()))
    fastest += abs(system.shear_rate) * float(system.radius.max())
    fall = float(np.abs(system.gravity) @ system.box)
    return 2.0 * (fastest + system.domain.fastest_wall) + math.sqrt(2.0 * fall)


def heated_speed(system: ParticleSystem, law: Law, shear_heats: bool = True) -> float:
    """The largest expected speed of a particle in the steady state of a thermostat or of shear [m/s]; 0 without.

    Heat of spins counts as heat of velocities: friction transfers at most all of it.
    """
    rate = system.shear_rate if shear_heats else 0.0
    heat, mean = system.thermostat, float(system.mass.mean())
    temperature = max(heat.temperature, heat.rotational or 0.0) if isinstance(heat, Andersen) else 0.0
    power = 0.0 if heat is None or isinstance(heat, Andersen) else heat.power + (heat.rotational or 0.0)
    if power or rate:  # a gas of mean particles, whose ε depends on its temperature
        size, volume, d = float(system.radius.mean()), float(np.prod(system.box)), system.dimension
        gas = Gas(system.n, size, mean, volume, d)
        for _ in range(10):
            speed = math.sqrt(math.pi * temperature)
            smallest = min(
                float(contact.restitution(np.array([speed]))[0]) for contact in contacts.of_kinds(system, law)
            )
            e = min(smallest, LARGEST_RESTITUTION)
            temperature = gas.heated_temperature(power, e) + _sheared_temperature(gas, rate, e)
    # The fastest of N particles with Maxwell's distribution.
    highest = system.dimension + 2.0 * math.log(system.n)
    return math.sqrt(temperature * mean / float(system.mass.min()) * highest)


def _sheared_temperature(gas: Gas, rate: float, restitution: float) -> float:
    """Granular temperature in steady shear [m²/s²], in which the work of the viscous stress is dissipated.

    η γ̇² = (1 − ε²) ν n m T/2, with Enskog's η of elastic spheres (Chapman & Cowling 1970) or disks (Gass, J. Chem.
    Phys. 54, 1898 (1971)). An estimate also beyond the range of :meth:`Gas.sheared_temperature`.
    """
    sigma, chi, root = 2.0 * gas.radius, gas.contact_value, math.sqrt(math.pi)
    if gas.dimension == 3:
        dilute, b, collisional = 5.0 / (16.0 * sigma**2 * root), 4.0 * gas.packing_fraction, (0.8, 0.7614)
    else:
        dilute, b, collisional = 1.0 / (2.0 * sigma * root), 2.0 * gas.packing_fraction, (1.0, 0.8729)
    viscosity = dilute * (1.0 / chi + collisional[0] * b + collisional[1] * b * b * chi)  # over m √T
    lost = 0.5 * (1.0 - restitution**2) * gas.n / gas.volume * float(gas.collision_rate(1.0))
    return viscosity * rate**2 / lost
