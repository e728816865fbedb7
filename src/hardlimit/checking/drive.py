"""What drives a gas: the temperature at which collisions dissipate what heating or shear supplies, and shaken walls."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np

from ..boxes import theory
from ..boxes.box import UNIT_BALL, Floats
from ..boxes.spins import AXES_OF_ROTATION, HIGHEST, SMALLEST
from ..boxes.system import ParticleSystem
from ..boxes.theory import FLUID, Gas, Heat, RotatingGas
from ..boxes.thermostats import Andersen, RandomKicks
from ..contact import frictional_contact
from ..contact.impact import FrictionalContact
from ..convert.force import AdhesiveForce
from ..support import validation
from ..support.formatting import digits, quantity
from .contacts import Case, restitution_of
from .friction import contact_of
from .scripts import Bath, ContactSettings, Stage
from .scripts.description import WALL, Motion
from .scripts.motion import acceleration, sinking

#: Number of steps in which ε and the speed, on which it may depend, become consistent.
STEPS: Final = 40
#: Restitution below which kinetic theory of shear is not used.
LEAST_IN_SHEAR: Final = 0.5
#: Packing fraction up to which it is used. In event-driven runs of 500 spheres (2 each), ε = 0.95 and 0.8, T over that
#: of theory is 1.17 and 0.93 at φ = 0.49, 1.20 and 0.94 at 0.5, 1.32 and 1.04 at 0.55; the collision rate at this T
#: over Enskog's is 1.16 and 1.37, 1.18 and 1.44, 1.52 and 2.20 (the run of studies/sheared_gas.py).
DENSEST_IN_SHEAR: Final = 0.5
#: 1 − ε below which grains count as elastic: more than the rounding error of a computed ε.
ELASTIC: Final = 1e-10
#: Grains and packing fraction of ``hardlimit gas compare`` without options.
BOX: Final = (1000, 0.3)
#: Edge of a box over the amplitude of its wall in which these grains have room.
ROOMY: Final = 4.0


class Steady(NamedTuple):
    """The steady state of grains."""

    speed: float  #: mean impact speed √(πT)
    temperature_ratio: float | None = None  #: T_r/T with friction; None where theory leaves it out


@dataclass(frozen=True)
class Drive:
    """What keeps a gas in motion: a heating power of each grain, a shear rate, a bath, or shear and power."""

    power: float | None = None
    shear_rate: float | None = None
    bath: Bath | None = None
    per_mass: bool = True  #: whether the bath has temperatures in m²/s², not energies
    spin_power: float = 0.0  #: of each grain, on its spin

    def in_units(self, mass: float, length: float, time: float) -> Drive:
        """The same in units of these sizes."""
        watt = mass * length**2 / time**3
        power = None if self.power is None else self.power / watt
        rate = None if self.shear_rate is None else self.shear_rate * time
        bath = self.bath
        if bath is not None:
            unit = (1.0 if self.per_mass else mass) * (length / time) ** 2
            bath = Bath(
                bath.temperature / unit,
                bath.rate * time,
                bath.spin_temperature / unit,
                bath.spin_rate * time,
            )
        return Drive(power, rate, bath, self.per_mass, self.spin_power / watt)

    @property
    def quantity(self) -> str:
        """The quantity for which the box is run, whose error decides."""
        return "temperature" if self.shear_rate is None else "stress"

    @property
    def option(self) -> str:
        """The option that states it."""
        return "--power" if self.shear_rate is None else "--shear"

    @property
    def heats_spins(self) -> bool:
        """Whether a thermostat acts on spins as well."""
        return self.spin_power > 0.0 or (self.bath is not None and self.bath.spin_rate > 0.0)

    def words(self, plain: bool) -> str:
        """What supplies the energy."""
        if self.power is not None and self.shear_rate is not None:
            return "shear and a thermostat"
        if self.power is not None:
            shown = [
                digits(power, 3) if plain else quantity(power, "W", 3)
                for power in (self.power, self.spin_power)
            ]
            return f"a power of {shown[0]} for each grain{f' and {shown[1]} for its spin' * self.heats_spins}"
        if self.shear_rate is not None:
            return f"a shear rate of {digits(self.shear_rate, 3)}{'' if plain else '/s'}"
        return f"the thermostat{' of velocities and spins' * self.heats_spins}"

    def temperature(self, gas: Gas, restitution: float) -> float:
        """Granular temperature of smooth grains in the steady state. ``gas`` has one grain."""
        if self.power is not None:
            return gas.heated_temperature(self.power, restitution)
        if self.shear_rate is not None:
            return gas.rotating(restitution, 0.0, 0.0).sheared_temperature(self.shear_rate)
        assert self.bath is not None
        hot, rate = self.bath.temperature / (1.0 if self.per_mass else gas.mass), self.bath.rate
        # rate (T_b − T) = (1 − ε²) ν(T) T/d with ν ∝ √T, in x = √(T/T_b): x² + c x³ = 1.
        c = (1.0 - restitution**2) * float(gas.collision_rate(hot)) / (gas.dimension * rate)
        if not c > 0.0:
            return hot
        size: float = c ** (-1.0 / 3.0)
        x = size * theory.root_with_drag(size * size)
        return hot * x * x

    @property
    def moves_nothing(self) -> bool:
        """Whether it heats the spins alone, so that grains without friction rest."""
        if self.bath is not None:
            return self.bath.temperature == 0.0
        return self.power == 0.0

    def heats(self, gas: Gas) -> tuple[Heat, Heat]:
        """What the thermostat does to T and T_r. ``gas`` has one grain."""
        if self.bath is not None:
            unit = 1.0 if self.per_mass else gas.mass
            hot, rate, spinning, spin_rate = self.bath
            return Heat(rate * hot / unit, rate), Heat(spin_rate * spinning / unit, spin_rate)
        axes = AXES_OF_ROTATION[gas.dimension]
        return (
            Heat(2.0 * (self.power or 0.0) / (gas.dimension * gas.mass)),
            Heat(2.0 * self.spin_power / (axes * gas.mass)),
        )

    def heat_share(self, gas: Gas, speed: float) -> float:
        """Error of the temperature over that at equal heating power, at this mean impact speed.

        A bath restores the temperature: with r(T_b − T) ∝ T^(3/2) and a relative error of the loss, the change of T
        is −(T_b − T)/(T + 3/2 (T_b − T)) of that error, at equal power −2/3.
        """
        assert self.bath is not None
        temperature = speed**2 / math.pi
        below = max(self.bath.temperature / (1.0 if self.per_mass else gas.mass) - temperature, 0.0)
        return 1.5 * below / (temperature + 1.5 * below)

    def steady(self, case: Case, dimension: int, packing_fraction: float | None) -> Steady | None:
        """The steady state of a contact's grains; None if it is not known, or theory does not apply.

        ε and β are those of the contact at the mean impact speed. Grains of two sizes count as equal ones of their mean
        size and mass. Where β is not known, theory is that of grains without friction.
        """
        gas = None if case.force is None else self.gas(case, dimension, packing_fraction)
        if gas is None:
            return None
        state = Steady(math.sqrt(math.pi * self._all_on_velocities().temperature(gas, 0.9)))
        for _ in range(STEPS):
            speed = state.speed
            if not 0.0 < speed < math.inf:
                return None
            restitution = restitution_of(case, speed)
            rubbing = rotating(case, gas, speed, restitution)
            elastic = restitution > 1.0 - ELASTIC and self.bath is None and rubbing is None
            if elastic or (restitution < LEAST_IN_SHEAR and self.shear_rate is not None):
                return None
            state = self._state(gas, restitution, rubbing)
            if abs(state.speed - speed) <= 1e-12 * state.speed:
                break
        return state if 0.0 < state.speed < math.inf else None

    def _all_on_velocities(self) -> Drive:
        """A drive whose state is not far, for a start: that gives velocities what spins get, too."""
        bath = self.bath and self.bath._replace(
            temperature=max(self.bath.temperature, self.bath.spin_temperature)
        )
        return replace(self, power=None if self.power is None else self.power + self.spin_power, bath=bath)

    def _state(self, gas: Gas, restitution: float, rubbing: RotatingGas | None) -> Steady:
        """The steady state at this ε, of smooth grains without ``rubbing``; a speed of 0 if there is none."""
        if rubbing is None:
            return Steady(math.sqrt(math.pi * self.temperature(gas, restitution)))
        if self.shear_rate is not None:
            try:
                sheared = rubbing.sheared_state(self.shear_rate)
            except ValueError:  # nothing is dissipated
                return Steady(0.0)
            return Steady(math.sqrt(math.pi * sheared.temperature), sheared.temperature_ratio)
        heated = rubbing.heated_state(*self.heats(gas))
        if heated is None:
            return Steady(0.0)
        return Steady(math.sqrt(math.pi * heated.temperature), heated.temperature_ratio)

    def without_friction(self, case: Case, gas: Gas, speed: float) -> float | None:
        """Error of the temperature, under shear of the stress, of hard spheres that leave friction out, at this mean
        impact speed."""
        restitution = restitution_of(case, speed)
        rubbing = rotating(case, gas, speed, restitution)
        if self.shear_rate is not None:
            return None if rubbing is None else self._smooth_stress(gas, restitution, rubbing)
        state = None if rubbing is None else rubbing.heated_state(*self.heats(gas))
        if state is None or (restitution > 1.0 - ELASTIC and self.bath is None):
            return None
        return self.temperature(gas, restitution) / state.temperature - 1.0

    def _smooth_stress(self, gas: Gas, restitution: float, rubbing: RotatingGas) -> float | None:
        """The shear stress without friction over that with it, less 1; None if one has no steady state."""
        assert self.shear_rate is not None
        if not LEAST_IN_SHEAR <= restitution <= 1.0 - ELASTIC:
            return None
        both = (gas.rotating(restitution, 0.0, 0.0), rubbing)
        try:
            states = [grains.sheared_state(self.shear_rate) for grains in both]
        except ValueError:  # nothing is dissipated
            return None
        smooth, rough = (-float(state.pressure_tensor[0, 1]) for state in states)
        return smooth / rough - 1.0

    def gas(self, case: Case, dimension: int, packing_fraction: float | None) -> Gas | None:
        """One grain of the mean size and mass of a contact's grains, in its share of the box; None if not known."""
        bodies = (case.first, case.second or case.first)
        radii, masses = [body.radius for body in bodies], [body.mass for body in bodies]
        if None in radii or None in masses or self.why_not(dimension, packing_fraction):
            return None
        assert packing_fraction is not None
        radius = 0.5 * math.fsum(radius for radius in radii if radius is not None)
        finite = [mass for mass in masses if mass is not None and math.isfinite(mass)]
        if not finite:
            return None
        ball = math.pi * radius**2 if dimension == 2 else 4.0 / 3.0 * math.pi * radius**3
        return Gas(1, radius, math.fsum(finite) / len(finite), ball / packing_fraction, dimension)

    def why_not(self, dimension: int, packing_fraction: float | None) -> str:
        """Why kinetic theory gives no speed; empty if it does, or if it depends on ε."""
        if packing_fraction is None:
            return "the packing is not known"
        sheared = self.shear_rate is not None and dimension == 3
        densest = DENSEST_IN_SHEAR if sheared else FLUID[dimension]
        if packing_fraction > densest:
            return f"kinetic theory is that of a fluid, up to a packing fraction of {densest:g}"
        if self.shear_rate is not None and dimension == 2:
            return "kinetic theory of shear is that of spheres"
        if self.shear_rate is not None and self.power is not None:
            return "kinetic theory of shear has no thermostat"
        return ""


#: Spacing of ln tan γ in a table of β; its ends, which reach beyond all angles of a gas; and the part around μ beyond
#: which contacts stick as at head-on impacts, or slide.
SPACING: Final = 0.05
ENDS: Final = (-16.0, 24.0)
AROUND: Final = (-7.0, 7.0)


def rotating(case: Case, gas: Gas, speed: float, restitution: float) -> RotatingGas | None:
    """The gas of grains that rub as in this contact at an impact speed; None for smooth ones, or if it is not known."""
    law, bodies = case.friction, (case.first, case.second or case.first)
    factors = {body.inertia_factor for body in bodies}
    if not law.coefficient or law.terms is None or case.force is None or len(factors) > 1:
        return None
    (factor,) = factors
    if not SMALLEST <= factor <= HIGHEST:  # grains that do not spin
        return None
    first, second = case.first.tried(0), None if case.second is None else case.second.tried(0)
    force = case.force(first, second, speed)
    if isinstance(force, AdhesiveForce) or not restitution > 0.0:
        return None
    contact = contact_of(law.terms, force, (first, second), speed)
    beta = _table(frictional_contact.in_own_units(contact, speed))
    if beta is None:
        return None
    return theory.tabulated(replace(gas, inertia_factor=factor), restitution, *beta)


@lru_cache(maxsize=256)
def _table(own: FrictionalContact) -> tuple[Floats, Floats] | None:
    """tan γ and β, None if β is not known."""
    if frictional_contact.is_too_stiff(own):
        return None
    scale = own.terms.coefficient if math.isfinite(own.terms.coefficient) else 1.0
    first, last = (round(end / SPACING) for end in AROUND)
    low = min(first, math.floor((ENDS[0] - math.log(scale)) / SPACING))
    high = max(last, math.ceil((ENDS[1] - math.log(scale)) / SPACING))
    tangents = scale * np.exp(SPACING * np.arange(low, high + 1))
    own_range = slice(first - low, last - low + 1)
    beta = np.empty_like(tangents)
    beta[own_range] = frictional_contact.of_tangents(own, tangents[own_range])
    beta[: own_range.start] = beta[own_range.start]
    end = own_range.stop - 1
    slides = math.isfinite(own.terms.coefficient)
    beta[end + 1 :] = (1.0 + beta[end]) * tangents[end] / tangents[end + 1 :] - 1.0 if slides else beta[end]
    return (tangents, beta) if np.isfinite(beta).all() else None


def checked_drive(power: float | None, shear_rate: float | None, speeds: tuple[float, ...]) -> Drive | None:
    """The options of a check."""
    options = {"speed": speeds or None, "power": power, "shear_rate": shear_rate}
    names = [name for name, value in options.items() if value is not None]
    if len(names) > 1:
        raise ValueError(f"{' | '.join(names)}: got {len(names)} of them, must be at most one")
    if power is not None:
        return Drive(power=validation.number("power", power, 0.0))
    if shear_rate is not None:
        return Drive(shear_rate=validation.number("shear_rate", shear_rate, 0.0))
    return None


def of_stage(stage: Stage, mass: float, length: float, time: float) -> Drive | None:
    """The drive of a script's run, in SI units; None without shear and thermostat."""
    if stage.shear_rate is None and stage.bath is None:
        return None
    power = math.nan if stage.shear_rate is not None and stage.bath is not None else None
    bath = None if stage.shear_rate is not None else stage.bath
    return Drive(power, stage.shear_rate, bath, False).in_units(1.0 / mass, 1.0 / length, 1.0 / time)


def of_system(system: ParticleSystem) -> Drive | None:
    """The drive of a system; None without shear and thermostat."""
    thermostat = system.thermostat
    rotational = 0.0 if thermostat is None or thermostat.rotational is None else thermostat.rotational
    if isinstance(thermostat, Andersen):
        turning = 0.0 if thermostat.rotational is None else thermostat.rate
        return Drive(bath=Bath(thermostat.temperature, thermostat.rate, rotational, turning))
    power = thermostat.power / system.n if isinstance(thermostat, RandomKicks) else None
    shear_rate = abs(system.shear_rate) if system.shear_rate != 0.0 else None
    if power is None and shear_rate is None:
        return None
    return Drive(power, shear_rate, spin_power=rotational / system.n)


# --- grains that rest, and shaken ones ------------------------------------------------------------------------


class Support(NamedTuple):
    """What holds grains against gravity, and how it moves."""

    rests: bool  #: whether grains can rest on it
    moves: bool  #: whether walls move
    shaking: float | None = (
        None  #: Γ = A ω²/g of what holds the grains; None if nothing oscillates, or if not known
    )
    motion: Motion | None = None  #: this oscillation


def support(stage: Stage) -> Support:
    """Grains rest on a wall that stops their fall, unless its acceleration exceeds that of gravity."""
    walls = [contact for contact in stage.contacts if contact.types[1] == WALL or fixed(stage, contact.types)]
    moves = any(wall.motion is not None for wall in walls)
    holding = [wall for wall in walls if holds(stage, wall)] if stage.gravity else []
    if not holding or not stage.gravity:
        return Support(False, moves)

    def strength(motion: Motion | None) -> float:
        return 0.0 if motion is None else acceleration(motion, stage.down) / (stage.gravity or math.inf)

    # A floor of grains that throws others up may keep them from a wall below it that does not.
    thrown = any(wall.types[1] != WALL and 1.0 < strength(wall.motion) < math.inf for wall in holding)
    still = (
        any(wall.pushes and stage.down and strength(wall.motion) <= 1.0 for wall in holding) and not thrown
    )
    strongest = max((wall.motion for wall in holding), key=strength)
    largest = strength(strongest)
    known = strongest is not None and math.isfinite(largest) and largest > 0.0
    return Support(still or largest <= 1.0, moves, largest if known else None, strongest if known else None)


def support_of_system(system: ParticleSystem) -> Support:
    """As :func:`support`. Γ is that of the wall towards which the grains fall."""
    supported = system.gravity - system.domain.common_fall  # by walls
    if system.thermostat is not None or system.shear_rate != 0.0 or not supported.any():
        return Support(False, system._walls_move)
    largest, motion = 0.0, None
    for axis, pull in enumerate(map(float, supported)):
        wall = system.walls.get(f"{'xyz'[axis]}{'-' if pull < 0.0 else '+'}") if pull else None
        if wall is None or not wall.fastest:
            continue
        sine = wall.waveform != "triangle" and not wall.velocity
        strength = wall.acceleration / abs(pull) if sine else math.inf
        if strength > largest:
            along = tuple(wall.amplitude * (k == axis) for k in range(3))
            largest, motion = strength, Motion(along, 2.0 * math.pi * wall.frequency)
    known = 0.0 < largest < math.inf
    rests = largest <= 1.0 and not any(wall.velocity for wall in system.walls.values())
    return Support(rests, system._walls_move, largest if known else None, motion if known else None)


def holds(stage: Stage, contact: ContactSettings) -> bool:
    """Whether a wall, or grains that do not move, may stop the fall of grains; true if the directions are not known."""
    if contact.types[1] != WALL:
        return fixed(stage, contact.types)
    if contact.sheds:
        return False
    if stage.down is None or contact.pushes is None:
        return True
    return any(sum(p * g for p, g in zip(push, stage.down, strict=True)) < -1e-12 for push in contact.pushes)


def presses(stage: Stage) -> bool:
    """Whether a wall moves steadily along gravity, as a piston does."""
    moving = [wall.motion for wall in stage.contacts if wall.types[1] == WALL and wall.motion is not None]
    return any(sinking(motion, stage.down) > 0.0 for motion in moving)


def fixed(stage: Stage, types: Sequence[str]) -> bool:
    """Whether some grains of these types do not move."""
    grains = [stage.grains[name] for name in types if name in stage.grains]
    return any(kind.frozen or kind.partly_frozen for kind in grains)


def words_of(stage: Stage | None, walls: Support) -> str:
    """What drives a box for which there is no law of the error; empty if nothing does."""
    if walls.shaking is not None:
        return f"walls drive this box (Γ = A ω²/g = {digits(walls.shaking, 3)})"
    if walls.moves:
        return "walls drive this box"
    notes = () if stage is None else (*stage.driven, *stage.pressed)
    return f"{notes[0].what} drives this box" if notes else ""


def option_of(
    walls: Support, gravity: float, radius: float | None, dimension: int, length: float, time: float
) -> str:
    """Options of ``hardlimit gas`` that shake grains of this radius in the same way; length and time are units in SI.

    The packing fraction is among them where the usual box would be too small.
    """
    motion = walls.motion
    if walls.shaking is None or motion is None or motion.amplitude is None or motion.frequency is None:
        return ""
    size, rate = math.hypot(*motion.amplitude) * length, motion.frequency / (2.0 * math.pi * time)
    values = (quantity(size, "m", 3), quantity(rate, "Hz", 3))
    options = ["--shake", ":".join(value.replace(" ", "") for value in values)]
    options += ["--gravity", digits(gravity * length / time**2, 3), *["--dimension", "2"] * (dimension == 2)]
    if radius is not None:
        options += ["--radius", quantity(radius * length, "m", 3).replace(" ", "")]
        number, usual = BOX
        packing = number * UNIT_BALL[dimension] * (radius * length / (ROOMY * size)) ** dimension
        options += ["--packing-fraction", digits(packing, 2)] * (packing < usual)
    return " ".join(options)
