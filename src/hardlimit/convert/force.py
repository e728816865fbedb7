"""One head-on contact under the normal force of a particle code: F = K ξ^p + C ξ^q dξ/dt, clipped at zero or not."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Final, Literal

import numpy as np
import scipy

from .. import _core
from ..boxes.lammps import integration_error
from ..contact.contact import Floats

#: Impact speeds [m/s] at which no square underflows or overflows.
MIN_SPEED: Final = 1e-100
MAX_SPEED: Final = 1e100
#: Largest damping in units of the spring; no code uses more.
MAX_DAMPING: Final = 1e6


@dataclass(frozen=True)
class Powers:
    """The form of a force: four times p and q, and whether it may attract at the end of a contact."""

    elastic: int
    damping: int
    attracts: bool = False

    @property
    def units(self) -> tuple[str, str]:
        """Units of K and of C."""
        p, q = 0.25 * self.elastic, 0.25 * self.damping
        return _to_power("N/m", p), _to_power("N s/m", 1.0 + q)

    @property
    def arguments(self) -> tuple[int, int, bool]:
        """Arguments for the core."""
        return self.elastic, self.damping, self.attracts


def _to_power(of: str, power: float) -> str:
    return of if power == 1.0 else f"{of}^{power:g}"


@dataclass(frozen=True)
class Force:
    """The force in one contact. The search for a time step can use it like a ``Contact``."""

    powers: Powers
    stiffness: float  #: K [N/m^p]
    damping: float  #: C [N s/m^(1 + q)]
    effective_mass: float  #: [kg]

    @classmethod
    def with_restitution(
        cls, powers: Powers, stiffness: float, effective_mass: float, restitution: float, speed: float
    ) -> Force:
        """The force with this restitution in (0, 1] at ``speed`` [m/s]."""
        undamped = cls(powers, stiffness, 0.0, effective_mass)
        return cls(
            powers, stiffness, damping_for(powers, restitution) * undamped._unit(speed), effective_mass
        )

    def collision(self, speed: float) -> Collision:
        """The collision at ``speed`` [m/s]. Its restitution is 0 if the bodies stay together."""
        length, time = self.scales(speed)
        return _collision(self.powers, self.relative_damping(speed)).scaled(length, time, self.effective_mass)

    def numerically_damped(self, speed: float, damping: float) -> Collision:
        """The collision with a numerical damping: a fraction d of the force on each body acts against its velocity.

        Decelerating forces are multiplied by 1 + d and accelerating forces by 1 − d, as if the mass were divided by
        these factors. Without other damping this gives ε = √((1 − d)/(1 + d)). Requires an ε that does not depend on
        the speed, q = (p − 1)/2. The duration is NaN.
        """
        loading, unloading = (
            replace(self, effective_mass=self.effective_mass / part).collision(speed)
            for part in (1.0 + damping, 1.0 - damping)
        )
        exponent = 0.5 * (0.25 * self.powers.elastic + 1.0)
        released = (loading.compression / unloading.compression) ** exponent
        return replace(loading, restitution=released * unloading.restitution, duration=math.nan)

    def relative_damping(self, speed: float) -> float:
        """C in units in which K, the mass and the speed are 1. The restitution depends on it alone."""
        return min(self.damping / self._unit(speed), MAX_DAMPING)

    def force(self, compression: Floats, rate: Floats) -> Floats:
        """Force [N], positive if repulsive, in the same shape."""
        p, q = 0.25 * self.powers.elastic, 0.25 * self.powers.damping
        push = self.stiffness * compression**p
        if self.damping != 0.0:
            push += self.damping * compression**q * rate
        if not self.powers.attracts:
            np.maximum(push, 0.0, out=push)
        push[compression <= 0.0] = 0.0
        return push

    def restitution(self, speed: Floats) -> Floats:
        """Restitution at each speed [m/s]."""
        return np.array([self.collision(v).restitution for v in speed.tolist()])

    def duration(self, speed: Floats) -> Floats:
        """Duration [s] at each speed [m/s]."""
        return np.array([self.collision(v).duration for v in speed.tolist()])

    def longest_step(self, speed: float, error: float) -> float:
        """The longest time step [s] with an error of ε of at most ``error``; NaN if the bodies stay together."""
        damping = _rounded(self.relative_damping(speed))
        return float(self.scales(speed)[1] * _longest_step(self.powers, damping, error))

    def error_of_step(self, speed: float, time_step: float) -> float:
        """The error of ε by a time step [s]; infinite if the contact does not end with this step."""
        collision = self.collision(speed)
        if not collision.restitution > 0.0:
            return math.nan
        # Beyond the largest number of steps tried, the error is taken as proportional to the step.
        tried = max(time_step, collision.duration / integration_error.MAX_STEPS)
        return self._error_of_step(speed, tried) * time_step / tried

    def _error_of_step(self, speed: float, time_step: float) -> float:
        damping, unit = _rounded(self.relative_damping(speed)), self.scales(speed)[1]
        return _error_of_step(Force(self.powers, 1.0, damping, 1.0), 1.0, _rounded(time_step / unit))

    def scales(self, speed: float) -> tuple[float, float]:
        """Units of length [m] and time [s] of a collision, in which K, the mass and the speed are 1."""
        p = 0.25 * self.powers.elastic
        length = (self.effective_mass / self.stiffness * speed * speed) ** (1.0 / (p + 1.0))
        return length, length / speed

    def _unit(self, speed: float) -> float:
        """Unit of the damping C."""
        length, time = self.scales(speed)
        return float(self.effective_mass / (time * length ** (0.25 * self.powers.damping)))


@dataclass(frozen=True)
class ContactArea:
    """The area [m²] of a contact of two spheres in LIGGGHTS' models of cohesion."""

    model: Literal["sjkr", "sjkr2"]
    first: float  #: radius [m]
    second: float  #: radius [m]; infinite at a wall

    def __call__(self, compression: Floats) -> Floats:
        """The area at each compression [m]. That of sjkr is the circle in which the spheres intersect."""
        x, a, b = compression, self.first, self.second
        wall = math.isinf(b)
        if self.model == "sjkr2":  # at a wall half of what the effective radius gives
            return (2.0 * math.pi * a if wall else 4.0 * math.pi * a * b / (a + b)) * x
        area: Floats = math.pi * x * (2.0 * a - x)
        return area if wall else area * (2.0 * b - x) * (2.0 * (a + b) - x) / (2.0 * (a + b - x)) ** 2


@dataclass(frozen=True)
class AdhesiveForce(Force):
    """A force with the attraction w A(ξ) while bodies overlap. The bodies may stay together."""

    energy_density: float  #: w [J/m³]
    area: ContactArea

    def force(self, compression: Floats, rate: Floats) -> Floats:
        """Force [N], positive if repulsive, in the same shape."""
        attraction = np.where(compression > 0.0, self.energy_density * self.area(compression), 0.0)
        return super().force(compression, rate) - attraction

    def collision(self, speed: float) -> Collision:
        """The collision at ``speed`` [m/s]. Its restitution is 0 if the bodies stay together, NaN if crushed."""
        return _adhesive_collision(self, speed)

    def longest_step(self, speed: float, error: float) -> float:
        """The longest time step [s] with an error of ε of at most ``error``; NaN if the bodies stay together."""
        if not self.collision(speed).restitution > 0.0:
            return math.nan
        return float(integration_error.longest_step(self, speed, error))

    def _error_of_step(self, speed: float, time_step: float) -> float:
        return _error_of_step(self, speed, time_step)


@dataclass(frozen=True)
class Collision:
    """One collision of two free bodies."""

    restitution: float
    duration: float  #: [s]
    compression: float  #: largest [m]
    force: float  #: largest [N]

    def scaled(self, length: float, time: float, mass: float) -> Collision:
        """The collision in SI units, from units of length [m], time [s] and mass [kg]."""
        force = self.force * mass * length / (time * time)
        return Collision(self.restitution, self.duration * time, self.compression * length, force)


@lru_cache(maxsize=4096)
def _collision(powers: Powers, damping: float) -> Collision:
    return Collision(*_core.power_collision(*powers.arguments, damping))


@lru_cache(maxsize=4096)
def _adhesive_collision(force: AdhesiveForce, speed: float) -> Collision:
    """Integrated in the units of the collision without adhesion.

    Bodies whose separation comes to rest within the contact stay together, because damping only dissipates. There is no
    result where the smaller one is compressed by more than its radius.
    """
    length, time = force.scales(speed)
    unit = force.effective_mass * length / (time * time)

    def push(x: float, v: float) -> float:
        return float(force.force(np.array([max(x, 0.0) * length]), np.array([v * speed]))[0]) / unit

    def event(value: Callable[[Floats], float], direction: float, terminal: bool = True) -> Any:
        function: Any = lambda _, y: value(y)  # noqa: E731
        function.direction, function.terminal = direction, terminal
        return function

    smaller = min(force.area.first, force.area.second) / length
    separated, compressed = event(lambda y: y[0], -1.0), event(lambda y: y[1], -1.0, False)
    together, swallowed = event(lambda y: y[1], 1.0), event(lambda y: y[0] - smaller, 1.0)
    done = scipy.integrate.solve_ivp(
        lambda _, y: [y[1], -push(*y)],
        (0.0, 1e4),
        [0.0, 1.0],
        "DOP853",
        events=[separated, compressed, together, swallowed],
        rtol=1e-10,
        atol=1e-13,
    )
    largest, compression = max(map(push, *done.y)) * unit, float(done.y[0].max()) * length
    if len(done.y_events[1]):
        compression = float(done.y_events[1][0, 0]) * length
    if len(done.t_events[3]):
        return Collision(math.nan, math.nan, compression, largest)
    if not len(done.t_events[0]):
        return Collision(0.0, math.inf, compression, largest)
    return Collision(-float(done.y[1, -1]), float(done.t[-1]) * time, compression, largest)


@lru_cache(maxsize=4096)
def damping_for(powers: Powers, restitution: float) -> float:
    """The relative damping with this restitution in (0, 1]."""
    return float(_core.power_damping(*powers.arguments, restitution))


def _rounded(value: float) -> float:
    """The value to ten digits, so that pairs, stages and codes with the same number share one computation."""
    return float(f"{value:.10g}")


@lru_cache(maxsize=1024)
def _error_of_step(force: Force, speed: float, time_step: float) -> float:
    with np.errstate(over="ignore", invalid="ignore"):  # a contact that gains energy without end
        return integration_error.restitution_error(force, speed, time_step)


@lru_cache(maxsize=1024)
def _longest_step(powers: Powers, damping: float, error: float) -> float:
    if _collision(powers, damping).restitution == 0.0:
        return math.nan
    scaled: Any = Force(powers, 1.0, damping, 1.0)
    return float(integration_error.longest_step(scaled, 1.0, error))
