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

The tangential forces of LAMMPS are, with the displacement s of the surfaces and their velocity g, at most μ F in total

* ``linear_history k_t x_t μ``: k_t s + γ_t g; ``linear_nohistory x_t μ``: γ_t g; ``mindlin… K_t x_t μ``:
  K_t √(R δ) s + γ_t g, with the history of our model of that name,

where γ_t is x_t times the factor of v in the normal force. Its arms differ from ours by the compression: R in g and
R − δ/2 in the torque of a pair. Those of walls are ours.
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
from ...contact.friction import LIMITS, NONE, SPRING, Friction, FrictionTerms
from ...support.formatting import listed
from .. import spins
from ..box import Floats
from ..contacts import contact, of_pairs, refuse_fall_past_walls, rubs
from ..system import ParticleSystem

Integers = NDArray[np.int64]
Flags = NDArray[np.bool_]

#: LAMMPS has 32 groups, and each type needs one for the walls.
MAX_TYPES: Final = 30
#: Largest ratio of damping to critical damping; above it e would underflow.
LARGEST_RATIO: Final = 0.99
#: Names of our models of friction in LAMMPS, but for that without a spring.
HISTORIES: Final = {
    SPRING: "linear_history",
    "mindlin": "mindlin",
    "mindlin_force": "mindlin/force",
    "mindlin_rescale": "mindlin_rescale",
    "mindlin_rescale_force": "mindlin_rescale/force",
}
#: Moments of inertia q m R² of ``fix nve/sphere``, and the words for them after it, by dimension.
INERTIA: Final = {2: {0.4: "", 0.5: " disc"}, 3: {0.4: ""}}


@dataclass(frozen=True)
class Types:
    """Types of particles; all particles of a type have the same coefficients."""

    of_particle: Integers  #: type of each particle (N,), counted from 0
    bodies: list[tuple[float, float]]  #: mass [kg] and radius [m] of a particle of each type

    def __len__(self) -> int:
        return len(self.bodies)


def types_of(system: ParticleSystem, law: Law) -> Types:
    """Sort the particles into the types that LAMMPS needs under a law."""
    of = contact(law, 1.0, 1.0)
    needed = model_of(law).needs(law, of)
    friction = friction_of(law)
    if friction is not None and _own_damping(friction) and "restitution" in law.parameters:
        needed = needed or ("mass",)  # on which x_t depends
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
    of = contact(law, mass, radius)
    coefficients = model_of(law).coefficients(law, of, mass, radius)
    return f"{coefficients} limit_damping tangential {_tangential(law, of, radius)}"


def _tangential(law: Law, of: Any, radius: float) -> str:
    """The coefficients of the tangential force."""
    friction = friction_of(law)
    if friction is None:
        return "linear_nohistory 0.0 0.0"
    terms = FrictionTerms(*of.friction_terms)
    own = _own_damping(friction)
    ratio = own / _damping(of) if own else friction.damping_ratio or 0.0
    rest = f"{ratio!r} {terms.coefficient!r}"
    if friction.model == NONE:
        return f"linear_nohistory {rest}"
    stiffness = terms.stiffness if friction.model == SPRING else terms.stiffness / math.sqrt(radius)
    return f"{HISTORIES[str(friction.model)]} {stiffness!r} {rest}"


def _damping(of: Any) -> float:
    """The factor of ξ^q dξ/dt in the normal force."""
    return float(of.coefficients[1])


def friction_of(law: Law) -> Friction | None:
    """The friction of a law; None if it has none that acts."""
    return law.friction if rubs(law) else None


def _own_damping(friction: Friction) -> float:
    """γ_t [kg/s] if it is given itself, 0 otherwise."""
    return friction.damping or 0.0


class Rotation(NamedTuple):
    """What the script must know of particles that rotate."""

    disc: str  #: follows ``nve/sphere``
    damped: bool  #: whether γ_t g is a part of the tangential force beside that of a spring


def rotation_of(system: ParticleSystem, law: Law) -> Rotation | None:
    """None without friction. Raises ValueError if LAMMPS does not have this friction."""
    friction = friction_of(law)
    if friction is None:
        return None
    refuse_fall_past_walls(system, True)
    if friction.coefficient == math.inf:
        raise ValueError("coefficient: got inf, must be finite for engine 'lammps'")
    if friction.limit != LIMITS[0] and friction.model != NONE:
        raise ValueError(f"limit: got {friction.limit!r}, must be {LIMITS[0]!r} for engine 'lammps'")
    if own := _own_damping(friction):
        _check_damping(law, own)
    words, factor = INERTIA[system.dimension], factor_of(system)
    if (other := ~np.isin(factor, list(words)) | (factor != factor[0])).any():
        wanted = listed([f"{q:g}" for q in words], "or")
        same = " for all particles" if len(words) > 1 else ""
        raise ValueError(
            f"inertia_factor: got {factor[int(np.argmax(other))]:.16g}, must be {wanted}{same} in "
            f"{system.dimension} dimensions for engine 'lammps'"
        )
    return Rotation(words[float(factor[0])], damped_springs(friction))


def _check_damping(law: Law, damping: float) -> None:
    """LAMMPS multiplies the damping of the normal force, also by its power of the compression."""
    if law.record["powers"][1] != 0 or _damping(contact(law, 1.0, 1.0)) == 0.0:
        raise ValueError(
            f"damping: got {damping:g} kg/s, must be damping_ratio for engine 'lammps', which multiplies the damping "
            f"of the normal force, that of {law!r}"
        )


def damped_springs(friction: Friction) -> bool:
    """Whether γ_t g is a part of the tangential force beside that of a spring."""
    return friction.model != NONE and bool(friction.damping or friction.damping_ratio)


def factor_of(system: ParticleSystem) -> Floats:
    """q of the moments of inertia q m R² (N,)."""
    return spins.solid(system.n, system.dimension) if system.inertia_factor is None else system.inertia_factor


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


def _powered(factor: float, power: int, compression: Floats) -> Floats:
    """factor · ξ^(power/4)."""
    powered: Floats = factor * np.maximum(compression, 0.0) ** (0.25 * power)
    return powered


class Pairs:
    """Forces and energies of our law for the contacts of a system."""

    def __init__(self, system: ParticleSystem, law: Law) -> None:
        self._system, self._law = system, law
        friction = friction_of(law)
        self.rubs = friction is not None
        self.damped = friction is not None and damped_springs(friction)

    def apart(self, first: Integers, second: Integers) -> Floats:
        """Distance of the centres at touch [m]; for a wall (``second`` < 0), the radius."""
        radius = self._system.radius
        return radius[first] + np.where(second < 0, 0.0, radius[np.maximum(second, 0)])

    def effective_mass(self, first: Integers, second: Integers) -> Floats:
        """Effective mass [kg]."""
        mass, other = self._system.mass[first], self._system.mass[np.maximum(second, 0)]
        return np.where(second < 0, mass, mass * other / (mass + other))

    def force(self, first: Integers, second: Integers, compression: Floats, rate: Floats) -> Floats:
        """Repulsive force [N]."""
        return self._each(first, second, lambda contact, at: contact.force(compression[at], rate[at]))

    def energy(self, first: Integers, second: Integers, compression: Floats) -> Floats:
        """Elastic energy [J]."""
        return self._each(first, second, lambda contact, at: contact.energy(compression[at]))

    def tangential_energy(
        self, first: Integers, second: Integers, compression: Floats, elastic: Floats
    ) -> Floats:
        """Energy of the tangential springs [J] from their forces, (N, 3); 0 without a spring."""
        square = (elastic * elastic).sum(axis=1)

        def energy(contact: Any, at: Integers) -> Floats:
            terms = FrictionTerms(*contact.friction_terms)
            stiffness = _powered(terms.stiffness, terms.stiffness_power, compression[at])
            stored: Floats = np.divide(
                0.5 * square[at], stiffness, out=np.zeros(len(at)), where=stiffness > 0.0
            )
            return stored

        return self._each(first, second, energy)

    def tangential_damping(self, first: Integers, second: Integers, compression: Floats) -> Floats:
        """γ_t [kg/s]."""

        def damping(contact: Any, at: Integers) -> Floats:
            terms = FrictionTerms(*contact.friction_terms)
            return _powered(terms.damping, terms.damping_power, compression[at])

        return self._each(first, second, damping)

    def _each(self, first: Integers, second: Integers, value: Callable[[Any, Integers], Floats]) -> Floats:
        """Evaluate a function of all contacts, with one call per kind of contact."""
        values = np.zeros(len(first))
        for rows, of_pair in of_pairs(self._system, self._law, first, second):
            values[rows] = value(of_pair, rows)
        return values
