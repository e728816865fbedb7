"""Translation of our contact laws into exactly equal forces of LAMMPS' ``pair_style granular`` and ``wall/gran``.

With the overlap δ, v = dδ/dt, and the effective mass m and radius R, the forces of LAMMPS are (with ``limit_damping``
they are never attractive)

* ``hooke k``: k δ; ``hertz K``: K √R δ^{3/2},
* ``damping velocity``, coefficient γ: γ v; ``damping viscoelastic``, coefficient h: h m √(R δ) v,
* ``damping coeff_restitution``, coefficient e: c √(m F/δ) v with F the elastic force, c = 2b for hooke, √5 b for hertz
  and b = −ln e/√(π² + ln² e).

The last form is that of our linear dashpot, γ = 2b√(m k), and of Tsuji's law, α √(m k) δ^{1/4} with α = √5 b; one
coefficient serves all masses. Its e is not ε: for the same b, our force has another restitution because it never
attracts. We give LAMMPS the e that has our b. ``damping tsuji`` is another fit and is not used. For viscoelastic
spheres h = (3/2) ρ A/(m √R).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ... import _core
from ...contact.contact import Law
from ..box import Floats
from ..contacts import contact, of_pairs
from ..system import ParticleSystem

Integers = NDArray[np.int64]
Flags = NDArray[np.bool_]

#: LAMMPS has 32 groups, and each type needs one for the walls.
MAX_TYPES: Final = 30
#: Largest ratio of damping to critical damping; above it e would underflow.
LARGEST_RATIO: Final = 0.99
COMMON: Final = "limit_damping tangential linear_nohistory 0.0 0.0"


@dataclass(frozen=True)
class Types:
    """Types of particles; all particles of a type have the same coefficients."""

    of_particle: Integers  #: type of each particle (N,), counted from 0
    bodies: list[tuple[float, float]]  #: mass [kg] and radius [m] of a particle of each type

    def __len__(self) -> int:
        return len(self.bodies)


def types_of(system: ParticleSystem, law: Law) -> Types:
    """Sort the particles into the types that LAMMPS needs under a law."""
    needed = model_of(law).needs(law, contact(law, 1.0, 1.0))
    columns = [getattr(system, name) for name in needed]
    if not columns:
        body = (float(system.mass[0]), float(system.radius[0]))
        return Types(np.zeros(system.n, np.int64), [body])
    _, first, inverse = np.unique(np.stack(columns, axis=1), axis=0, return_index=True, return_inverse=True)
    if len(first) > MAX_TYPES:
        raise ValueError(
            f"{' | '.join(needed)}: got {len(first)} different values, must be at most {MAX_TYPES} for engine "
            "'lammps', whose coefficients depend on them under this law"
        )
    bodies = [(float(system.mass[i]), float(system.radius[i])) for i in first]
    return Types(inverse.reshape(-1).astype(np.int64), bodies)


class Model(NamedTuple):
    """One of our laws in LAMMPS."""

    #: From the law, the contact, and its effective mass [kg] and radius [m].
    coefficients: Callable[[Law, Any, float, float], str]
    needs: Callable[[Law, Any], tuple[str, ...]]  #: the attributes of particles on which they depend


def model_of(law: Law) -> Model:
    """The law in LAMMPS. Raises ValueError if it has none."""
    name = law.record["name"]
    if name not in MODELS:
        raise ValueError(f"law: got {law!r}, must be one of {', '.join(MODELS)} for engine 'lammps'")
    return MODELS[name]


def between(law: Law, body: tuple[float, float], other: tuple[float, float]) -> str:
    """The coefficients for a contact of two bodies, given as mass [kg] and radius [m]; both are infinite for a wall."""
    mass, radius = (_core.effective(a, b) for a, b in zip(body, other, strict=True))
    coefficients = model_of(law).coefficients(law, contact(law, mass, radius), mass, radius)
    return f"{coefficients} {COMMON}"


def _damping_ratio(of: Any, mass: float) -> float:
    stiffness, damping = of.values()
    return float(0.5 * damping / (math.sqrt(stiffness) * math.sqrt(mass)))


def _lammps_restitution(ratio: float) -> float:
    """The e of LAMMPS, with −ln e/√(π² + ln² e) = b."""
    return math.exp(-math.pi * ratio / math.sqrt((1.0 - ratio) * (1.0 + ratio)))


def _linear(law: Law, of: Any, mass: float, radius: float) -> str:
    stiffness, damping = of.values()
    ratio = _damping_ratio(of, mass)
    if "damping" in law.parameters or ratio > LARGEST_RATIO:
        return f"hooke {stiffness!r} {damping!r} damping velocity"
    return f"hooke {stiffness!r} {_lammps_restitution(ratio)!r} damping coeff_restitution"


def _linear_needs(law: Law, of: Any) -> tuple[str, ...]:
    strong = _damping_ratio(of, 1.0) > LARGEST_RATIO
    return ("mass",) if "restitution" in law.parameters and strong else ()


def _viscoelastic(law: Law, of: Any, mass: float, radius: float) -> str:
    rho, time = of.values()
    along = rho / math.sqrt(radius)
    return f"hertz {along!r} {1.5 * along * time / mass!r} damping viscoelastic"


def _viscoelastic_needs(law: Law, of: Any) -> tuple[str, ...]:
    if of.values()[1] == 0.0:
        return ()
    return ("mass",) if "dissipative_time" in law.parameters else ("mass", "radius")


def _tsuji(law: Law, of: Any, mass: float, radius: float) -> str:
    prefactor, alpha = of.values()
    e = _lammps_restitution(alpha / math.sqrt(5.0))
    return f"hertz {prefactor / math.sqrt(radius)!r} {e!r} damping coeff_restitution"


def _tsuji_needs(law: Law, of: Any) -> tuple[str, ...]:
    ratio = of.values()[1] / math.sqrt(5.0)
    if ratio > LARGEST_RATIO:
        raise ValueError(
            f"law: got {law!r}, whose damping is {ratio:.3g} times the critical one, must be at most "
            f"{LARGEST_RATIO:g} times it for engine 'lammps'"
        )
    return ("radius",) if "elastic_prefactor" in law.parameters else ()


MODELS: Final = {
    "linear": Model(_linear, _linear_needs),
    "viscoelastic": Model(_viscoelastic, _viscoelastic_needs),
    "tsuji": Model(_tsuji, _tsuji_needs),
}


class Pairs:
    """Forces and energies of our law for the contacts of a system."""

    def __init__(self, system: ParticleSystem, law: Law) -> None:
        self._system, self._law = system, law

    def apart(self, first: Integers, second: Integers) -> Floats:
        """Distance of the centres at touch [m]; for a wall (``second`` < 0), the radius."""
        radius = self._system.radius
        return radius[first] + np.where(second < 0, 0.0, radius[second])

    def effective_mass(self, first: Integers, second: Integers) -> Floats:
        """Effective mass [kg]."""
        mass, other = self._system.mass[first], self._system.mass[second]
        return np.where(second < 0, mass, mass * other / (mass + other))

    def force(self, first: Integers, second: Integers, compression: Floats, rate: Floats) -> Floats:
        """Repulsive force [N]."""
        return self._each(first, second, lambda contact, at: contact.force(compression[at], rate[at]))

    def energy(self, first: Integers, second: Integers, compression: Floats) -> Floats:
        """Elastic energy [J]."""
        return self._each(first, second, lambda contact, at: contact.energy(compression[at]))

    def _each(self, first: Integers, second: Integers, value: Callable[[Any, Integers], Floats]) -> Floats:
        """Evaluate a function of all contacts, with one call per kind of contact."""
        values = np.zeros(len(first))
        for rows, of_pair in of_pairs(self._system, self._law, first, second):
            values[rows] = value(of_pair, rows)
        return values
