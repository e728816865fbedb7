"""Impact speed in a driven gas: the temperature at which collisions dissipate what heating or shear supplies."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from ..boxes.system import ParticleSystem
from ..boxes.theory import FLUID, Gas
from ..boxes.thermostats import Andersen, RandomKicks
from ..support import validation
from ..support.formatting import digits, quantity
from .contacts import Case, restitution_of

#: Number of steps in which ε and the speed, on which it may depend, become consistent.
STEPS: Final = 40
#: Restitution below which kinetic theory of shear is not used.
LEAST_IN_SHEAR: Final = 0.5
#: 1 − ε below which grains count as elastic: more than the rounding error of a computed ε.
ELASTIC: Final = 1e-10


@dataclass(frozen=True)
class Drive:
    """What keeps a gas in motion: a heating power of each grain, a shear rate, Andersen's bath, or shear and power."""

    power: float | None = None
    shear_rate: float | None = None
    bath: tuple[float, float] | None = None  #: temperature and rate

    def in_units(self, mass: float, length: float, time: float) -> Drive:
        """The same in units of these sizes."""
        power = None if self.power is None else self.power * time**3 / (mass * length**2)
        return Drive(power, None if self.shear_rate is None else self.shear_rate * time)

    def words(self, plain: bool) -> str:
        """What supplies the energy."""
        if self.power is not None and self.shear_rate is not None:
            return "shear and a thermostat"
        if self.power is not None:
            return f"a power of {digits(self.power, 3) if plain else quantity(self.power, 'W', 3)} for each grain"
        if self.shear_rate is not None:
            return f"a shear rate of {digits(self.shear_rate, 3)}{'' if plain else '/s'}"
        return "the thermostat"

    def temperature(self, gas: Gas, restitution: float) -> float:
        """Granular temperature in the steady state. ``gas`` has one grain."""
        if self.power is not None:
            return gas.heated_temperature(self.power, restitution)
        if self.shear_rate is not None:
            return gas.sheared_temperature(self.shear_rate, restitution)
        assert self.bath is not None
        hot, rate = self.bath
        # rate (T_b − T) = (1 − ε²) ν(T) T/d with ν ∝ √T, in x = √(T/T_b): x² + c x³ = 1.
        c = (1.0 - restitution**2) * float(gas.collision_rate(hot)) / (gas.dimension * rate)
        roots = np.roots([c, 1.0, 0.0, -1.0]) if c > 0.0 else np.array([1.0])
        x = next(float(one.real) for one in roots if abs(one.imag) < 1e-9 and one.real > 0.0)
        return hot * x * x

    def speed(self, case: Case, dimension: int, packing_fraction: float | None) -> float | None:
        """Mean impact speed √(πT) of a contact's grains; None if it is not known, or theory does not apply.

        ε is that of the contact at this speed. Grains of two sizes count as equal ones of their mean size and mass.
        """
        bodies = (case.first, case.second or case.first)
        radii, masses = [one.radius for one in bodies], [one.mass for one in bodies]
        if case.force is None or None in radii or None in masses or self.why_not(dimension, packing_fraction):
            return None
        assert packing_fraction is not None
        radius = 0.5 * math.fsum(one for one in radii if one is not None)
        finite = [one for one in masses if one is not None and math.isfinite(one)]
        if not finite:
            return None
        ball = math.pi * radius**2 if dimension == 2 else 4.0 / 3.0 * math.pi * radius**3
        gas = Gas(1, radius, math.fsum(finite) / len(finite), ball / packing_fraction, dimension)
        speed, restitution = 0.0, 0.9
        for _ in range(STEPS):
            before, speed = speed, math.sqrt(math.pi * self.temperature(gas, restitution))
            if not 0.0 < speed < math.inf:
                return None
            restitution = restitution_of(case, speed)
            least = LEAST_IN_SHEAR if self.shear_rate is not None else 0.0
            if (restitution > 1.0 - ELASTIC and self.bath is None) or restitution < least:
                return None
            if abs(speed - before) <= 1e-12 * speed:
                break
        return speed

    def why_not(self, dimension: int, packing_fraction: float | None) -> str:
        """Why kinetic theory gives no speed; empty if it does, or if it depends on ε."""
        if packing_fraction is None:
            return "the packing is not known"
        if packing_fraction > FLUID[dimension]:
            return f"kinetic theory is that of a fluid, up to a packing fraction of {FLUID[dimension]:g}"
        if self.shear_rate is not None and dimension == 2:
            return "kinetic theory of shear is that of spheres"
        if self.shear_rate is not None and self.power is not None:
            return "kinetic theory of shear has no thermostat"
        return ""


def checked_drive(power: float | None, shear_rate: float | None, speeds: tuple[float, ...]) -> Drive | None:
    """The options of a check."""
    given = {"speed": speeds or None, "power": power, "shear_rate": shear_rate}
    names = [name for name, value in given.items() if value is not None]
    if len(names) > 1:
        raise ValueError(f"{' | '.join(names)}: got {len(names)} of them, must be at most one")
    if power is not None:
        return Drive(power=validation.number("power", power, 0.0))
    if shear_rate is not None:
        return Drive(shear_rate=validation.number("shear_rate", shear_rate, 0.0))
    return None


def of_system(system: ParticleSystem) -> Drive | None:
    """The drive of a system; None without shear and thermostat."""
    thermostat = system.thermostat
    if isinstance(thermostat, Andersen):
        return Drive(bath=(thermostat.temperature, thermostat.rate))
    power = thermostat.power / system.n if isinstance(thermostat, RandomKicks) else None
    shear_rate = abs(system.shear_rate) if system.shear_rate != 0.0 else None
    return None if power is None and shear_rate is None else Drive(power, shear_rate)
