"""The wanted restitution and stiffness of a contact."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final

from ..contact import laws
from ..support import validation
from ..support.formatting import listed
from .force import MAX_SPEED, MIN_SPEED, Force, Powers
from .formulas import DEFAULT_POISSON_RATIO, Where, impact_stiffness, modulus
from .friction import Walton

#: Powers of our own laws whose force is K ξ^p + C ξ^q dξ/dt. They are never attractive.
LAWS: Final = {
    name: Powers(*law.record["powers"]) for name, law in laws.LAWS.items() if law.record["power_law"]
}
#: Powers of the elastic force, four times each, whose K a stiffness or a modulus sets.
LINEAR: Final = 4
HERTZ: Final = 6
SETTING: Final = {"stiffness": (LINEAR,), "youngs_modulus": (LINEAR, HERTZ)}
#: The default law of each elastic force is the first whose restitution does not depend on the speed: 2q = p − 1.
DEFAULTS: Final = {
    powers.elastic: name
    for name, powers in reversed(LAWS.items())
    if 2 * powers.damping == powers.elastic - LINEAR
}
LOWEST: Final = 1e-3  #: smallest restitution
LARGEST: Final = 1e30  #: largest compression [m] and duration [s], and one over the smallest


@dataclass(frozen=True)
class Wanted:
    """The wanted restitution and stiffness; returned by :func:`hardlimit.convert`."""

    restitution: float  #: ε
    speed: float  #: impact speed [m/s]
    law: str  #: name of the law
    given: str  #: "stiffness", "youngs_modulus", "duration" or "compression"
    value: float  #: value of ``given`` [N/m], [Pa], [s] or [m]
    poisson_ratio: float  #: ν
    friction: float | None = None  #: coefficient of friction μ; None for smooth grains
    tangential_restitution: float | None = None  #: β0 of a gas of these grains; None for smooth grains

    @property
    def walton(self) -> Walton | None:
        """Walton's grains with this friction; None for smooth grains.

        :meta private:
        """
        if self.friction is None or self.tangential_restitution is None:
            return None
        return Walton(self.friction, self.tangential_restitution)

    def force(self, mass: float, radius: float) -> Force:
        """The force of our own law for this effective mass [kg] and radius [m].

        :meta private:
        """
        powers = LAWS[self.law]
        try:
            stiffness = self._stiffness(powers, mass, radius)
            force = Force.with_restitution(powers, stiffness, mass, self.restitution, self.speed)
            scales = force.scales(self.speed)
        except (OverflowError, ZeroDivisionError):
            scales = math.inf, math.inf
        if not all(1.0 / LARGEST < scale < LARGEST for scale in scales):
            raise ValueError(
                f"{self.given}: got {self.value:.6g}, must give contacts with compressions [m] and durations [s] "
                f"between {1.0 / LARGEST:g} and {LARGEST:g}"
            )
        return force

    def _stiffness(self, powers: Powers, mass: float, radius: float) -> float:
        if self.given == "stiffness":
            return self.value
        if self.given == "youngs_modulus":
            effective = modulus(self.value, self.poisson_ratio)
            where = Where(mass, radius, self.speed, None, self.poisson_ratio)
            if powers.elastic == LINEAR:
                return impact_stiffness(effective, where)
            return 4.0 / 3.0 * effective * math.sqrt(radius)
        return self._stiffness_of_collision(powers, mass)

    def _stiffness_of_collision(self, powers: Powers, mass: float) -> float:
        """K from the duration or the largest compression, which are powers of K."""
        unit = Force.with_restitution(powers, 1.0, mass, self.restitution, self.speed).collision(self.speed)
        exponent = 0.25 * powers.elastic + 1.0
        size = unit.duration if self.given == "duration" else unit.compression
        return float((size / self.value) ** exponent)


def wanted(
    restitution: Any,
    speed: Any,
    law: Any,
    stiffness: Any,
    youngs_modulus: Any,
    poisson_ratio: Any,
    duration: Any,
    compression: Any,
    friction: Any = None,
    tangential_restitution: Any = None,
) -> Wanted:
    """Check the arguments of :func:`hardlimit.convert`.

    Raises
    ------
    ValueError
        If a value is outside its range, or the stiffness is not given exactly once.
    """
    epsilon = validation.number(
        "restitution", restitution, LOWEST, 1.0, lowest_allowed=True, highest_allowed=True
    )
    v = validation.number("speed", speed, MIN_SPEED, MAX_SPEED)
    ways = {
        "stiffness": stiffness,
        "youngs_modulus": youngs_modulus,
        "duration": duration,
        "compression": compression,
    }
    way = validation.exactly_one(**ways)
    if law is None:
        law = DEFAULTS[HERTZ if way == "youngs_modulus" else LINEAR]
    name = validation.one_of("law", law, list(LAWS))
    elastic = LAWS[name].elastic
    possible = [name for name in ways if elastic in SETTING.get(name, (elastic,))]
    if way not in possible:
        raise ValueError(f"{way}: got it with the law {name}, must be {listed(possible, 'or')}")
    value = validation.number(way, ways[way], 0.0)
    nu = DEFAULT_POISSON_RATIO if poisson_ratio is None else poisson_ratio
    nu = validation.number("poisson_ratio", nu, -1.0, 0.5, highest_allowed=True)
    if way == "youngs_modulus" and poisson_ratio is None:
        raise ValueError("poisson_ratio: missing, must be in (-1, 0.5] beside youngs_modulus")
    return Wanted(epsilon, v, name, way, value, nu, *_wanted_friction(friction, tangential_restitution))


def _wanted_friction(friction: Any, tangential_restitution: Any) -> tuple[float | None, float | None]:
    """μ and β0, of which none or both are given."""
    mu = None if friction is None else validation.number("friction", friction, 0.0)
    if tangential_restitution is None:
        if mu is not None:
            raise ValueError("tangential_restitution: missing, must be in (-1, 1] beside friction")
        return None, None
    beta = validation.number(
        "tangential_restitution", tangential_restitution, -1.0, 1.0, highest_allowed=True
    )
    if mu is None:
        raise ValueError("friction: missing, must be > 0 and finite beside tangential_restitution")
    return mu, beta
