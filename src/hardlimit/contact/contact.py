"""The base class of contact laws, and the contact of two bodies.

The laws are C++ headers (``core/contact``). This module makes Python classes from their records; all computation is
done in the core.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from inspect import Parameter, Signature
from types import MappingProxyType
from typing import Any, ClassVar, Final, Self, overload

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..support import validation
from . import frictional_contact
from .balls import FLOOR, Ball, Floor
from .friction import Friction, FrictionTerms, checked_friction
from .impact import SMOOTH, FrictionalContact, Impact, impact_of

RESTITUTION: Final = "restitution"

#: Values in the examples of laws by unit, for a stiff grain.
TYPICAL: Final = {"N/m": 1e6, "N/m^1.5": 1e9, "Pa": 7e10, "s": 1e-6}

#: Numbers that give an array of the same shape; a single float gives a float.
Values = NDArray[Any] | Sequence[float] | Sequence[Sequence[float]]
Floats = NDArray[np.float64]


@validation.sealed("make contacts with Law.between")
class Contact:
    """A contact of two bodies under a law; returned by :meth:`Law.between`.

    ``law`` is the law. The constants of the contact are attributes, such as ``stiffness`` and ``damping`` under
    :class:`LinearDashpot`; the documentation of each law lists them.

    Examples
    --------
    >>> law = hl.LinearDashpot(stiffness=1e6, restitution=0.5)
    >>> contact = law.between(hl.Ball(0.01, density=2500.0))  # with the floor
    >>> contact
    Contact(stiffness=1e+06, damping=52.2461, effective_mass=0.010472)
    >>> f"{contact.duration() * 1e3:.3f} ms"
    '0.278 ms'
    """

    law: Law
    ball: Ball
    other: Ball | Floor
    core: _core.Contact
    _constants: dict[str, float]

    def __init__(self, law: Law, ball: Ball, other: Ball | Floor) -> None:
        mass, radius = _core.effective(ball.mass, other.mass), _core.effective(ball.radius, other.radius)
        friction = None if law.friction is None else law.friction.core
        parameters = list(law.parameters.values())
        core = _core.make_contact(law.record["name"], law.alternative, parameters, mass, radius, friction)
        names = [constant["name"] for constant in law.record["constants"]]
        constants = dict(zip(names, core.values(), strict=True))
        self.__dict__.update(law=law, ball=ball, other=other, core=core, _constants=constants)

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"{name}: a contact is immutable, change its law or its bodies")

    def __getattr__(self, name: str) -> float:
        constants = self.__dict__.get("_constants", {})
        if name in constants:
            return float(constants[name])
        raise AttributeError(f"Contact of a {type(self.law).__name__} has no attribute {name!r}")

    def __repr__(self) -> str:
        inner = ", ".join(f"{k}={v:.6g}" for k, v in self._constants.items())
        return f"Contact({inner}, effective_mass={self.effective_mass:.6g})"

    def __reduce__(self) -> tuple[Any, ...]:
        return Contact, (self.law, self.ball, self.other)

    @property
    def effective_mass(self) -> float:
        """m_i m_j/(m_i + m_j) [kg]."""
        return self.core.effective_mass

    @property
    def effective_radius(self) -> float:
        """R_i R_j/(R_i + R_j) [m]."""
        return self.core.effective_radius

    @property
    def tangential_mass(self) -> float:
        """m_t [kg], the mass of the tangential motion of the surfaces.

        Notes
        -----
        1/m_t = 1/m_eff + R_i²/I_i + R_j²/I_j (Foerster et al., Phys. Fluids 6, 1108 (1994)).
        """
        bodies = (self.ball.mass, self.ball.inertia_factor, self.other.mass, self.other.inertia_factor)
        return 1.0 / _core.inverse_tangential_mass(*bodies)

    @property
    def friction_terms(self) -> FrictionTerms | None:
        """The friction of this contact in numbers; None without friction.

        :meta private:
        """
        return None if self.law.friction is None else FrictionTerms(*self.core.friction_terms)

    def _numbers(self) -> FrictionalContact:
        """The contact for the core, which takes forces K ξ^p + C ξ^q dξ/dt only."""
        coefficients = self.core.coefficients
        if coefficients is None:
            raise ValueError(
                f"law: got {type(self.law).__name__}, must have a force K ξ^p + C ξ^q dξ/dt for an oblique impact"
            )
        powers = (*self.law.record["powers"], False)
        terms = self.friction_terms or SMOOTH
        return FrictionalContact(powers, coefficients, self.effective_mass, self.tangential_mass, terms)

    def impact(
        self, speed: float, tangential_speed: float = 0.0, spin: float = 0.0, other_spin: float = 0.0
    ) -> Impact:
        """An oblique collision with a fixed normal: the hard limit of the contact, exact at a wall.

        The other body rests before; velocities of two balls are relative to it. Directions and the sign of spins are
        those of :class:`Impact`.

        Parameters
        ----------
        speed : float [m/s]
            Speed of approach along the normal, > 0.
        tangential_speed : float, default 0 [m/s]
            Velocity of the centre of the ball along t.
        spin, other_spin : float, default 0 [rad/s]
            Spins before; with ω > 0 the contact point of the ball moves along t.

        Raises
        ------
        ValueError
            If a value is outside its range, the kinetic energy is outside [1e-290, 1e300] J, the floor is to spin, or
            the force of the law is not K ξ^p + C ξ^q dξ/dt.
        RuntimeError
            If 100000 steps or changes between stick and slip do not suffice, as where k_t or γ_t is very much larger
            than the stiffness or damping of the normal force.

        Notes
        -----
        The linear law with a spring is solved in closed form, piece by piece; the others by integration at order 8 to
        about 1e-12. All changes between stick and slip are located. Becker, Schwager & Pöschel, Phys. Rev. E 77, 011304
        (2008); Schwager, Becker & Pöschel, Eur. Phys. J. E 27, 107 (2008).

        Examples
        --------
        >>> law = hl.LinearDashpot(stiffness=1e6, damping=0.0, friction=hl.Friction(0.5))
        >>> superball = law.between(hl.Ball(0.01, density=2500.0))
        >>> superball.impact(1.0, 1.0, spin=-20.0).velocities[0].round(
        ...     3
        ... )  # normal, tangential
        array([-1.   ,  0.543])
        """
        motion = (
            validation.number("speed", speed, 0.0),
            validation.number("tangential_speed", tangential_speed),
            validation.number("spin", spin),
            validation.number("other_spin", other_spin),
        )
        if motion[3] != 0.0 and not isinstance(self.other, Ball):
            raise ValueError(f"other_spin: got {motion[3]:g}, must be 0 for the floor")
        smooth = (self.restitution(motion[0]), self.duration(motion[0]))
        return impact_of((self.ball, self.other), self._numbers(), smooth, motion)

    @overload
    def tangential_restitution(self, angle: float, speed: float = ...) -> float: ...
    @overload
    def tangential_restitution(self, angle: Values, speed: float = ...) -> Floats: ...
    def tangential_restitution(self, angle: float | Values, speed: float = 1.0) -> float | Floats:
        """Coefficient of tangential restitution β over the angle of impact, in the limit of a fixed normal.

        Parameters
        ----------
        angle : number or array [rad]
            γ in [0, π/2): tan γ is the slip velocity over ``speed``. At 0 the limit of small ones.
        speed : number, default 1 [m/s]
            Normal speed of approach, > 0.

        Returns
        -------
        float or array
            β, same shape as ``angle``: the slip velocity is multiplied by −β. −1 without friction. NaN if the contact
            is not resolved: see the error of :meth:`impact`.

        Raises
        ------
        ValueError
            If a value is outside its range, or the force of the law is not K ξ^p + C ξ^q dξ/dt.

        Notes
        -----
        As for :meth:`impact`.

        Examples
        --------
        >>> law = hl.LinearDashpot(stiffness=1e6, damping=0.0, friction=hl.Friction(0.5))
        >>> grain = law.between(hl.Ball(0.01, density=2500.0))
        >>> grain.tangential_restitution(np.deg2rad([10.0, 45.0, 80.0])).round(3)
        array([ 1.   ,  1.   , -0.383])
        """
        normal = validation.number("speed", speed, 0.0)
        angles = _numbers("angle", angle, lowest=0.0, highest=0.5 * math.pi, lowest_allowed=True)
        flat = _core.tangential_restitution(*self._numbers(), normal, normal * np.tan(angles.ravel()))
        return shaped(flat, angles.shape)

    def sticks_below(self, speed: float = 1.0) -> float:
        """Angle of impact [rad] below which the surfaces do not slip while the bodies approach.

        The angle γ is that between the velocity of the surfaces and the normal, which is fixed as in the hard limit.
        Close to the end of a contact the normal force vanishes and all surfaces slip.

        Parameters
        ----------
        speed : float [m/s]
            Normal impact speed, > 0.

        Returns
        -------
        float
            π/2 if they never slip; NaN without a tangential spring, with one that swings more than a hundred times in
            a contact, and if the bodies stay together.

        Raises
        ------
        ValueError
            If the law has no friction, or the speed is not positive and finite.

        Notes
        -----
        tan γ = μ k_n/k_t for undamped linear contacts with ρ = m_n k_t/(m_t k_n) ≥ 1: Maw, Barber & Fawcett, Wear 38,
        101 (1976). For ρ < 1 it is tan γ = μ (m_n/m_t)/(√ρ sin(π√ρ/2)). Located by 128 steps, to 2e-4.

        Examples
        --------
        >>> law = hl.LinearDashpot(
        ...     stiffness=1e6,
        ...     restitution=1.0,
        ...     friction=hl.Friction(0.5, stiffness_ratio=0.9),
        ... )
        >>> contact = law.between(hl.Ball(0.01, density=2500.0))
        >>> [
        ...     f"{angle / np.pi * 180:.0f}°"
        ...     for angle in (contact.sticks_below(), contact.slides_beyond())
        ... ]
        ['29°', '71°']
        """
        return frictional_contact.borders(self._rubbing(), _impact_speed(speed)).sticks_below

    def slides_beyond(self, speed: float = 1.0) -> float:
        """Angle of impact [rad] beyond which the surfaces do not stick while the bodies separate.

        Beyond it β = −1 + (m_n/m_t) μ (1 + ε)/tan γ, but for the short time in which the surfaces of damped contacts
        stick at touch. Argument, result and errors as for :meth:`Contact.sticks_below`.

        Notes
        -----
        tan γ = μ (m_n/m_t)(2 − 1/ρ) for undamped linear contacts with ρ = m_n k_t/(m_t k_n) ≥ 1: Maw, Barber & Fawcett,
        Wear 38, 101 (1976). For ρ < 1 this angle is :meth:`Contact.sticks_below`: the surfaces stick at most until the
        largest compression, and not at all beyond tan γ = μ k_n/k_t. Sticking with a normal force below 1 % of its
        largest value does not count.
        """
        return frictional_contact.borders(self._rubbing(), _impact_speed(speed)).slides_beyond

    def effective_tangential_restitution(self, speed: float = 1.0, dimension: int = 3) -> float:
        """β0 of the constant rule β = min(β0, −1 + (m_n/m_t) μ (1 + ε)/tan γ) that stands for this contact in a gas.

        With the same ε and μ, both exchange the same angular momentum on average over the collisions of a gas in which
        translation and rotation have the same temperature.

        Parameters
        ----------
        speed : float [m/s]
            Normal impact speed, > 0, at which β is taken for all angles.
        dimension : int
            3 for spheres, 2 for disks.

        Returns
        -------
        float
            NaN if the bodies stay together, if no β0 does this, or if a contact is not resolved: see the error of
            :meth:`impact`.

        Raises
        ------
        ValueError
            If the law has no friction, or an argument is outside its range.

        Notes
        -----
        Rule: Walton, in Particulate Two-Phase Flow (1993), p. 884. The mean of (1 + β) g_t² is that over
        tan γ = √((m_n/m_t) u/(1 − u)) with the weight 2u for spheres, 3√u/2 for disks. Where damping exceeds Coulomb's
        limit (``limit="spring"``), the sliding impulse is that of the contact in place of μ(1 + ε).

        Examples
        --------
        >>> law = hl.LinearDashpot(
        ...     stiffness=1e6,
        ...     restitution=0.9,
        ...     friction=hl.Friction(0.5, stiffness_ratio=0.9),
        ... )
        >>> contact = law.between(hl.Ball(0.01, density=2500.0))
        >>> round(contact.effective_tangential_restitution(), 3)
        0.327
        """
        kind = validation.whole("dimension", dimension, 2, 3)
        return frictional_contact.effective_restitution(self._rubbing(), _impact_speed(speed), kind)

    def _rubbing(self) -> FrictionalContact:
        """The same, of a law with friction."""
        if self.law.friction is None:
            raise ValueError("friction: missing, must be given to the law")
        return self._numbers()

    @overload
    def restitution(self, speed: float = ...) -> float: ...
    @overload
    def restitution(self, speed: Values) -> Floats: ...
    def restitution(self, speed: float | Values = 1.0) -> float | Floats:
        """Coefficient of restitution of an isolated head-on collision (Eqs. 13, B3).

        Parameters
        ----------
        speed : number or array [m/s]
            Impact speed, > 0.

        Returns
        -------
        float or array
            Same shape as ``speed``.

        Raises
        ------
        ValueError
            If a speed is not positive and finite.

        Examples
        --------
        >>> law = hl.Viscoelastic(
        ...     youngs_modulus=7e10, poisson_ratio=0.3, restitution=0.8, impact_speed=1.0
        ... )
        >>> contact = law.between(hl.Ball(0.01, density=2500.0))
        >>> contact.restitution([0.01, 1.0, 10.0]).round(3)
        array([0.913, 0.8  , 0.709])
        """
        return _over_speeds(self.core.restitution, speed)

    @overload
    def duration(self, speed: float = ...) -> float: ...
    @overload
    def duration(self, speed: Values) -> Floats: ...
    def duration(self, speed: float | Values = 1.0) -> float | Floats:
        """Duration [s] of an isolated collision, from first touch to zero force (Eq. 11).

        Argument, shape and errors as for :meth:`Contact.restitution`.
        """
        return _over_speeds(self.core.duration, speed)

    @overload
    def compression(self, speed: float = ...) -> float: ...
    @overload
    def compression(self, speed: Values) -> Floats: ...
    def compression(self, speed: float | Values = 1.0) -> float | Floats:
        """Largest compression [m] of an isolated head-on collision.

        Argument, shape and errors as for :meth:`Contact.restitution`.

        Notes
        -----
        By integration of m_eff d²ξ/dt² = −F to dξ/dt = 0 (Eq. 8). Without damping it is v √(m_eff/k) under the linear
        law and (5 m_eff v²/(4 ρ))^(2/5) under Hertz' law. Laws describe small compressions (:doc:`/limits`).
        """
        return _over_speeds(self.core.compression, speed)

    @overload
    def force(self, compression: float, rate: float = ...) -> float: ...
    @overload
    def force(self, compression: Values, rate: float | Values = ...) -> Floats: ...
    @overload
    def force(self, compression: float, rate: Values) -> Floats: ...
    def force(self, compression: float | Values, rate: float | Values = 0.0) -> float | Floats:
        """Repulsive force [N], never below zero (Eqs. 7, B1). Arrays are broadcast against each other.

        Parameters
        ----------
        compression : number or array [m]
            ξ; the force is zero for ξ ≤ 0.
        rate : number or array [m/s]
            dξ/dt, positive on approach.

        Raises
        ------
        ValueError
            If a value is not finite, or the shapes cannot be broadcast.

        Examples
        --------
        >>> law = hl.LinearDashpot(stiffness=1e6, restitution=0.5)
        >>> contact = law.between(hl.Ball(0.01, density=2500.0))
        >>> contact.force(1e-5, [1.0, 0.0, -1.0]).round(1)  # never attracts
        array([62.2, 10. ,  0. ])
        """
        depth, closing = _numbers("compression", compression), _numbers("rate", rate)
        try:
            depth, closing = np.broadcast_arrays(depth, closing)
        except ValueError:
            shapes = f"shapes {depth.shape} and {closing.shape}"
            raise ValueError(f"compression | rate: got {shapes}, must be broadcastable") from None
        flat = self.core.force(np.ascontiguousarray(depth.ravel()), np.ascontiguousarray(closing.ravel()))
        return shaped(flat, depth.shape)

    @overload
    def energy(self, compression: float) -> float: ...
    @overload
    def energy(self, compression: Values) -> Floats: ...
    def energy(self, compression: float | Values) -> float | Floats:
        """Elastic energy [J] at a compression; zero for ξ ≤ 0. Argument as for :meth:`Contact.force`."""
        depth = _numbers("compression", compression)
        return shaped(self.core.energy(depth.ravel()), depth.shape)


def _impact_speed(speed: Any) -> float:
    return validation.number("speed", speed, 0.0)


def _numbers(name: str, values: float | Values, **limits: float) -> Floats:
    return validation.array(name, values, ndim=None, empty_allowed=True, **limits)  # type: ignore[arg-type]


def shaped(flat: Floats, shape: tuple[int, ...]) -> float | Floats:
    """The values in this shape; a float if the shape is that of a number."""
    return float(flat[0]) if shape == () else flat.reshape(shape)


def _over_speeds(function: Callable[[Floats], Floats], speed: float | Values) -> float | Floats:
    array = _numbers("speed", speed, lowest=0.0)
    return shaped(function(array.ravel()), array.shape)


class Law:
    """A contact law with its parameters: the base of the classes in :data:`LAWS`.

    The classes are made by the package from records of the compiled core. A law is immutable. Laws of the same class
    with the same parameters are equal. Parameters are attributes.
    """

    record: ClassVar[dict[str, Any]]
    parameters: Mapping[str, float]  #: as given, in the record's order
    alternative: int  #: which set of alternatives was given
    friction: Friction | None  #: with the defaults of this law; None: smooth surfaces

    def __init__(self, **parameters: Any) -> None:
        friction = checked_friction(parameters.pop("friction", None))
        record = self.record
        common = record["common"]
        choices = record["alternatives"]
        named = {k: v for k, v in parameters.items() if v is not None}
        known = law_parameters(type(self))
        for name in named:
            if name not in known:
                raise ValueError(f"{name}: unknown, {type(self).__name__} takes {', '.join(known)}")
        for p in common:
            if p["name"] not in named:
                raise ValueError(f"{p['name']}: missing, must be {_range_of(p)}")
        rest = set(named) - {p["name"] for p in common}
        matching = [i for i, choice in enumerate(choices) if {p["name"] for p in choice} == rest]
        if len(matching) != 1:
            raise ValueError(_refused_choice(choices, rest))
        checked = {p["name"]: check_parameter(p, named[p["name"]]) for p in [*common, *choices[matching[0]]]}
        self.__dict__.update(alternative=matching[0], parameters=MappingProxyType(checked))
        self.__dict__.update(friction=self._completed(friction))

    def _completed(self, friction: Friction | None) -> Friction | None:
        """The friction with the defaults of this law."""
        if friction is None:
            return None
        if not self.record["power_law"]:
            raise ValueError(
                f"friction: got it with {type(self).__name__}, whose stiffness is not a power of ξ"
            )
        return friction.completed(self.record["powers"][0], self.parameters.get("poisson_ratio"))

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"{name}: a law is immutable, use replace({name}=…)")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"{name}: a law is immutable")

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(type(self), **{**self.parameters, **self._friction()}), ()

    def _friction(self) -> dict[str, Any]:
        """The argument of the friction if there is one."""
        return {} if self.friction is None else {"friction": self.friction}

    def __getattr__(self, name: str) -> float:
        parameters = self.__dict__.get("parameters", {})
        if name in parameters:
            return float(parameters[name])
        raise AttributeError(f"{type(self).__name__} has no parameter {name!r}")

    def __repr__(self) -> str:
        values = {**self.parameters, **self._friction()}
        return f"{type(self).__name__}({', '.join(f'{k}={v!r}' for k, v in values.items())})"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Law) or type(self) is not type(other):
            return False
        return self.parameters == other.parameters and self.friction == other.friction

    def __hash__(self) -> int:
        return hash((type(self).__name__, tuple(self.parameters.items()), self.friction))

    def replace(self, **changes: Any) -> Self:
        """A law with some parameters changed.

        A parameter of another alternative selects this alternative. Parameters that it does not use are dropped.

        Parameters
        ----------
        **changes : float
            New values of parameters by name; ``friction``: a :class:`Friction`, or None for none.

        Raises
        ------
        ValueError
            As for the law.

        Examples
        --------
        >>> hl.LinearDashpot(stiffness=1e6, restitution=0.5).replace(damping=3.0)
        LinearDashpot(stiffness=1000000.0, damping=3.0)
        """
        chosen = self._alternative_for(set(changes) - {"friction"})
        names = {p["name"] for group in (self.record["common"], chosen) for p in group}
        kept = {name: value for name, value in self.parameters.items() if name in names}
        return type(self)(**(kept | self._friction() | changes))

    def _alternative_for(self, changed: set[str]) -> list[dict[str, Any]]:
        """The alternative for which the changed and the present parameters are complete, or else the present one."""
        choices: list[list[dict[str, Any]]] = self.record["alternatives"]
        present = choices[self.alternative]
        common = {p["name"] for p in self.record["common"]}
        for choice in (present, *choices):
            names = {p["name"] for p in choice}
            if changed - common <= names <= changed | set(self.parameters):
                return choice
        knowing = [c for c in choices if changed - common <= {p["name"] for p in c}]
        return present if present in knowing or not knowing else knowing[0]

    @property
    def specified_restitution(self) -> float:
        """ε if it was given for all contacts, NaN if the law was given by material constants."""
        return self.parameters.get(RESTITUTION, math.nan)

    def between(self, ball: Ball, other: Ball | Floor = FLOOR) -> Contact:
        """The contact of two bodies.

        Parameters
        ----------
        ball : Ball
        other : Ball or FLOOR

        Raises
        ------
        ValueError
            If an argument is not such a body.

        Examples
        --------
        >>> law = hl.LinearDashpot(stiffness=1e6, restitution=0.5)
        >>> big, small = hl.Ball(0.02, density=2500.0), hl.Ball(0.01, density=2500.0)
        >>> round(law.between(small, big).damping, 2)  # each contact has its own damping
        49.26
        >>> round(law.between(small, hl.FLOOR).damping, 2)
        52.25
        """
        if not isinstance(ball, Ball):
            raise ValueError(f"ball: got {validation.shown(ball)}, must be a Ball")
        if not isinstance(other, Ball | Floor):
            raise ValueError(f"other: got {validation.shown(other)}, must be a Ball or FLOOR")
        return Contact(self, ball, other)


def checked_law(law: Any, smooth: str = "") -> Law:
    """``law``, if it is one; ``smooth`` names what has no rotation and refuses a law with friction."""
    if not isinstance(law, Law):
        raise ValueError(f"law: got {validation.shown(law)}, must be a contact law such as LinearDashpot")
    if smooth and law.friction is not None:
        raise ValueError(f"law: got one with friction, must be without: {smooth} do not rotate")
    return law


def check_parameter(record: Mapping[str, Any], value: Any) -> float:
    """A parameter of a law, if it is within the range in its record."""
    limits = {name: record[name] for name in ("lowest", "highest", "lowest_allowed", "highest_allowed")}
    return validation.number(record["name"], value, **limits)


def law_parameters(law: type[Law]) -> dict[str, dict[str, Any]]:
    """The records of all parameters that a law knows, by name."""
    choices = law.record["alternatives"]
    return {p["name"]: p for p in [*law.record["common"], *(p for choice in choices for p in choice)]}


def _refused_choice(choices: Sequence[Sequence[Mapping[str, Any]]], names_of_values: set[str]) -> str:
    """The message for a wrong set of parameters. It lists the sets that contain the given ones, or else all sets."""
    sets = [[str(p["name"]) for p in choice] for choice in choices]
    fitting = [names for names in sets if names_of_values <= set(names)] or sets
    names = dict.fromkeys(name for choice in fitting for name in choice)
    got = " and ".join(name for name in names if name in names_of_values)
    nothing = "neither" if len(names) == 2 else "none of them"
    wanted = " or ".join(" + ".join(choice) for choice in fitting)
    return f"{' | '.join(names)}: got {got or nothing}, must be {wanted}"


def _range_of(parameter: dict[str, Any]) -> str:
    return validation.describe_range(
        parameter["lowest"], parameter["highest"], parameter["lowest_allowed"], parameter["highest_allowed"]
    )


def make_law(record: dict[str, Any]) -> type[Law]:
    """Make the Python class of a registered law."""
    law = type(record["class_name"], (Law,), {"record": record, "__module__": "hardlimit"})
    law.__signature__ = _signature(record)  # type: ignore[attr-defined]
    law.__doc__ = _documentation(law)
    return law


def _signature(record: dict[str, Any]) -> Signature:
    """Keyword-only parameters: required ones, then the optional ones of the alternatives."""
    only = Parameter.KEYWORD_ONLY
    chosen = dict.fromkeys(p["name"] for choice in record["alternatives"] for p in choice)
    required = [Parameter(p["name"], only, annotation=float) for p in record["common"]]
    optional = [Parameter(name, only, default=None, annotation=float | None) for name in chosen]
    friction = Parameter("friction", only, default=None, annotation=Friction | None)
    return Signature([*required, *optional, friction])


def _documentation(law: type[Law]) -> str:
    record = law.record
    choices = record["alternatives"]
    common = ", ".join(f"``{p['name']}``" for p in record["common"])
    give = f"Besides {common}, give" if common else "Give"
    lines = [record["summary"], "", f"{give} exactly one of these sets:", ""]
    lines += ["* " + ", ".join(f"``{p['name']}``" for p in choice) for choice in choices]
    lines += ["", "A contact has the attributes:", ""]
    lines += [f"* ``{c['name']}``, {c['meaning']}{_unit(c)}" for c in record["constants"]]
    lines += ["", "Parameters", "----------"]
    for name, p in law_parameters(law).items():
        meaning = f"{p['meaning'][0].upper()}{p['meaning'][1:]}"
        lines += [f"{name} : float{_unit(p)}", f"    {meaning}; {_range_of(p)}."]
    lines += ["friction : Friction, optional", "    Tangential forces; None for smooth surfaces."]
    lines += ["", "Raises", "------", "ValueError"]
    lines += ["    If a value is outside its range or not exactly one of the sets is given."]
    lines += ["", "Notes", "-----", f"Source: {record['source']}."]
    return "\n".join([*lines, "", "Examples", "--------", *_example(law)])


def _unit(parameter: dict[str, Any]) -> str:
    return "" if parameter["unit"] == "1" else f" [{parameter['unit']}]"


def _example(law: type[Law]) -> list[str]:
    """An example with a ball on the floor and the parameters of the first alternative."""
    parameters = [*law.record["common"], *law.record["alternatives"][0]]
    values: dict[str, Any] = {p["name"]: _typical(p) for p in parameters}
    contact = law(**values).between(Ball(0.01, density=2500.0))
    return [
        f">>> law = hl.{law.__name__}({', '.join(f'{name}={_short(value)}' for name, value in values.items())})",
        ">>> contact = law.between(hl.Ball(0.01, density=2500.0))  # with the floor",
        '>>> f"ε {contact.restitution(1.0):.3f}, {contact.duration(1.0) * 1e6:.1f} µs"',
        repr(f"ε {contact.restitution(1.0):.3f}, {contact.duration(1.0) * 1e6:.1f} µs"),
    ]


def _short(value: float) -> str:
    return f"{value:g}".replace("e+0", "e").replace("e+", "e").replace("e-0", "e-")


def _typical(parameter: dict[str, Any]) -> float:
    """Half of the upper limit if there is one, else the value for a stiff grain."""
    if math.isfinite(parameter["highest"]):
        return float(0.5 * parameter["highest"])
    return TYPICAL.get(parameter["unit"], 1.0)
