"""One head-on contact under the normal force of a particle code: F = K ξ^p + C ξ^q dξ/dt, clipped at zero or not."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Final

import numpy as np

from .. import _core
from ..boxes.lammps import half_steps
from ..contact.contact import Floats

#: With more damping than this in units of the spring, no code's contact is meant.
MOST_DAMPING: Final = 1e6


@dataclass(frozen=True)
class Powers:
    """The form of a force: four times p and q, and whether it may attract at the end of a contact."""

    elastic: int
    damping: int
    attracts: bool = False

    @property
    def arguments(self) -> tuple[int, int, bool]:
        """For the core."""
        return self.elastic, self.damping, self.attracts


@dataclass(frozen=True)
class Force:
    """The force in one contact. It has what the search of a time step asks of a ``Contact``."""

    powers: Powers
    stiffness: float  #: K [N/m^p]
    damping: float  #: C [N s/m^(1 + q)]
    effective_mass: float  #: [kg]

    @classmethod
    def with_restitution(
        cls, powers: Powers, stiffness: float, effective_mass: float, restitution: float, speed: float
    ) -> Force:
        """The force whose restitution at ``speed`` [m/s] is ``restitution``, in (0, 1]."""
        undamped = cls(powers, stiffness, 0.0, effective_mass)
        return cls(
            powers, stiffness, damping_for(powers, restitution) * undamped._unit(speed), effective_mass
        )

    def collision(self, speed: float) -> Collision:
        """What a collision at ``speed`` [m/s] does; the bodies stay together where its restitution is 0."""
        length, time = self._scales(speed)
        return _collision(self.powers, self.relative_damping(speed)).scaled(length, time, self.effective_mass)

    def numerically_damped(self, speed: float, damping: float) -> Collision:
        """The collision where a program adds to each body the part ``damping`` of its force, against its velocity.

        It brakes with 1 + d of the force and drives with 1 − d of it, as if the mass were 1/(1 + d) and 1/(1 − d) of
        itself. Without other damping that makes ε = √((1 − d)/(1 + d)). For forces whose ε does not depend on the
        speed, q = (p − 1)/2; of their duration nothing is said.
        """
        loading, unloading = (
            replace(self, effective_mass=self.effective_mass / part).collision(speed)
            for part in (1.0 + damping, 1.0 - damping)
        )
        exponent = 0.5 * (0.25 * self.powers.elastic + 1.0)
        released = (loading.compression / unloading.compression) ** exponent
        return replace(loading, restitution=released * unloading.restitution, duration=math.nan)

    def relative_damping(self, speed: float) -> float:
        """C in units in which K, the mass and the speed are 1: all that the restitution depends on."""
        return min(self.damping / self._unit(speed), MOST_DAMPING)

    def force(self, compression: Floats, rate: Floats) -> Floats:
        """[N], repulsive ones positive, same shape."""
        p, q = 0.25 * self.powers.elastic, 0.25 * self.powers.damping
        push = self.stiffness * compression**p + self.damping * compression**q * rate
        return np.where(compression > 0.0, push if self.powers.attracts else np.maximum(push, 0.0), 0.0)

    def restitution(self, speed: Floats) -> Floats:
        """At each speed [m/s]."""
        return np.array([self.collision(v).restitution for v in speed.tolist()])

    def duration(self, speed: Floats) -> Floats:
        """[s], at each speed [m/s]."""
        return np.array([self.collision(v).duration for v in speed.tolist()])

    def longest_step(self, speed: float, error: float) -> float:
        """The longest time step [s] whose error of ε is at most ``error``; NaN where the bodies stay together."""
        # Rounded, so that pairs and codes with the same damping share one search.
        damping = float(f"{self.relative_damping(speed):.10g}")
        return float(self._scales(speed)[1] * _longest_step(self.powers, damping, error))

    def error_of_step(self, speed: float, time_step: float) -> float:
        """The error of ε that a time step [s] makes; infinite where the contact does not end with it."""
        collision = self.collision(speed)
        if collision.restitution == 0.0:
            return math.nan
        # With more steps than are tried, the error is taken to fall with the step.
        tried = max(time_step, collision.duration / half_steps.MOST)
        scaled = Force(self.powers, 1.0, self.relative_damping(speed), 1.0)
        error = half_steps.restitution_error(scaled, 1.0, tried / self._scales(speed)[1])
        return float(error * time_step / tried)

    def _scales(self, speed: float) -> tuple[float, float]:
        """Units of length [m] and time [s] of a collision."""
        p = 0.25 * self.powers.elastic
        length = (self.effective_mass / self.stiffness * speed * speed) ** (1.0 / (p + 1.0))
        return length, length / speed

    def _unit(self, speed: float) -> float:
        """Of the damping C."""
        length, time = self._scales(speed)
        return float(self.effective_mass / (time * length ** (0.25 * self.powers.damping)))


@dataclass(frozen=True)
class Collision:
    """One collision of two free bodies."""

    restitution: float
    duration: float  #: [s]
    compression: float  #: the greatest [m]
    force: float  #: the greatest [N]

    def scaled(self, length: float, time: float, mass: float) -> Collision:
        """In these units of length [m], time [s] and mass [kg]."""
        force = self.force * mass * length / (time * time)
        return Collision(self.restitution, self.duration * time, self.compression * length, force)


@lru_cache(maxsize=4096)
def _collision(powers: Powers, damping: float) -> Collision:
    return Collision(*_core.power_collision(*powers.arguments, damping))


@lru_cache(maxsize=4096)
def damping_for(powers: Powers, restitution: float) -> float:
    """The relative damping with this restitution in (0, 1]."""
    return float(_core.power_damping(*powers.arguments, restitution))


@lru_cache(maxsize=1024)
def _longest_step(powers: Powers, damping: float, error: float) -> float:
    if _collision(powers, damping).restitution == 0.0:
        return math.nan
    scaled: Any = Force(powers, 1.0, damping, 1.0)
    return float(half_steps.longest_step(scaled, 1.0, error))
