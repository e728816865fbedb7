"""One contact with friction and a fixed normal: what remains of an oblique collision in the hard limit."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..support import validation
from .balls import Ball, Floor
from .friction import FrictionTerms

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

#: Friction of smooth surfaces.
SMOOTH: Final = FrictionTerms(0.0)
#: The energies that the core adds up, by the names of its ledger.
LEDGER: Final = ("normal_spring", "tangential_spring", "normal_damping", "tangential_damping", "friction")
#: Kinetic energies [J] before a contact whose parts keep their digits.
LEAST_ENERGY: Final = 1e-290
LARGEST_ENERGY: Final = 1e300
#: Times of a trajectory by default, beside those at which stick and slip begin.
SAMPLES: Final = 401
#: Unit and meaning of what a trajectory holds.
TRAJECTORY: Final = {
    "compression": ("m", "compression"),
    "rate": ("m/s", "rate of compression"),
    "normal_force": ("N", "normal force, repulsive if positive"),
    "tangential_force": ("N", "tangential force on the other body along t"),
    "spring_force": ("N", "tangential force of the spring"),
    "slip_velocity": ("m/s", "velocity of the surface of the ball relative to the other along t"),
}
#: Those along t.
TANGENTIAL: Final = ("tangential_force", "spring_force", "slip_velocity")


class FrictionalContact(NamedTuple):
    """The numbers of a contact in the order of the core."""

    powers: tuple[int, int, bool]  #: 4p, 4q, and whether the normal force may attract
    coefficients: tuple[float, float]  #: K [N/m^p] and C [N s/m^(1 + q)]
    effective_mass: float  #: [kg]
    tangential_mass: float  #: [kg]
    terms: FrictionTerms


def tangential_restitution(
    powers: tuple[int, int, bool],
    stiffness: float,
    damping: float,
    effective_mass: float,
    terms: FrictionTerms,
    tangential_mass: float,
    speed: float,
    tangential_speed: ArrayLike,
) -> Floats:
    """Coefficients of tangential restitution β of a contact under F = K ξ^p + C ξ^q dξ/dt with a fixed normal.

    Parameters
    ----------
    powers : (int, int, bool)
        4p, 4q, and whether the normal force may attract; otherwise it is cut off at zero. |F| limits friction.
    stiffness, damping : float
        K > 0 [N/m^p] and C ≥ 0 [N s/m^(1 + q)].
    effective_mass, tangential_mass : float [kg]
        m_n and m_t.
    terms : FrictionTerms
    speed : float [m/s]
        Normal impact speed, > 0.
    tangential_speed : array [m/s]
        Slip velocities at touch; at 0 the limit of small ones.

    Returns
    -------
    array
        g_t' = −β g_t, same shape as ``tangential_speed``. NaN where the contact has too many changes of stick and slip.
    """
    slip = np.asarray(tangential_speed, np.float64)
    contact = FrictionalContact(powers, (stiffness, damping), effective_mass, tangential_mass, terms)
    return _core.tangential_restitution(*contact, speed, slip.ravel()).reshape(slip.shape)


class Interval(NamedTuple):
    """A part of a contact in which the surfaces stick, or slip; one of those returned by ``Impact.intervals``."""

    state: str  #: "stick" or "slip"
    begin: float  #: after touch [s]
    end: float  #: [s]


@validation.sealed("make impacts with Contact.impact")
@dataclass(frozen=True, eq=False)
class Impact:
    """A contact of two bodies with a fixed normal; made by :meth:`Contact.impact`.

    The frame is that in which ``other`` rests before. The normal n points from ``ball`` to ``other``, t is the
    tangential direction. Spins turn about the axis b with b × n = t: the contact point of a ball with spin ω > 0 moves
    by R ω along t, and a ball that rolls along t on a wall has ω = −v/R. In arrays the first row is the ball, the
    second the other body; a floor keeps its velocity and has no spin.

    Notes
    -----
    Exact at a wall; of two balls it is the limit of a short contact, in which the normal does not turn. Conventions:
    Foerster et al., Phys. Fluids 6, 1108 (1994).

    Examples
    --------
    >>> law = hl.LinearDashpot(
    ...     stiffness=1e6, restitution=0.9, friction=hl.Friction(0.5)
    ... )
    >>> impact = law.between(hl.Ball(0.01, density=2500.0)).impact(1.0, 0.5)
    >>> impact
    <Impact: ε = 0.9, β = 0.996742, stick–slip>
    >>> impact.spins.round(2)
    array([-71.31,   0.  ])
    """

    ball: Ball  #: the first body
    other: Ball | Floor  #: the second body, which rests before
    speed: float  #: velocity of the ball along n before [m/s]
    tangential_speed: float  #: velocity of its centre along t before [m/s]
    initial_spins: tuple[float, float]  #: before [rad/s]
    restitution: float  #: ε, that of the contact without friction
    tangential_restitution: float  #: β, by −β the slip velocity is multiplied; its limit if there is none
    duration: float  #: [s]
    intervals: tuple[Interval, ...]  #: in order; without a spring, stick is below Coulomb's limit
    ledger: Mapping[str, float] = field(repr=False)  #: in springs and lost [J], see :attr:`energies`
    numbers: FrictionalContact = field(repr=False)  #: :meta private:

    @property
    def slip_velocity(self) -> float:
        """Velocity [m/s] along t of the surface of the ball relative to that of the other body, before the contact."""
        return slip_velocity(self.ball, self.other, self.tangential_speed, *self.initial_spins)

    @property
    def normal_impulse(self) -> float:
        """m_n (1 + ε) v [N s]: on the other body along n, on the ball against it."""
        return self.numbers.effective_mass * (1.0 + self.restitution) * self.speed

    @property
    def tangential_impulse(self) -> float:
        """m_t (1 + β) times the slip velocity [N s]: on the other body along t, on the ball against it."""
        return self.numbers.tangential_mass * (1.0 + self.tangential_restitution) * self.slip_velocity

    @property
    def impulse_ratio(self) -> float:
        """Tangential over normal impulse; of a contact that slips throughout in one direction ±μ."""
        return self.tangential_impulse / self.normal_impulse

    @property
    def transitions(self) -> int:
        """How often the surfaces change between stick and slip."""
        return len(self.intervals) - 1

    @property
    def velocities(self) -> Floats:
        """Velocities after the contact (2, 2) [m/s]: rows are the ball and the other body, columns n and t."""
        impulse = np.array([self.normal_impulse, self.tangential_impulse])
        before = np.array([self.speed, self.tangential_speed])
        return np.array([before - impulse / self.ball.mass, impulse / self.other.mass])

    @property
    def spins(self) -> Floats:
        """Spins after the contact (2,) [rad/s]."""
        return self._spins(np.array(self.tangential_impulse))

    def _spins(self, impulse: Floats) -> Floats:
        """Spins after a tangential impulse, along a last axis."""
        lever = np.array([arm(body) / _inertia(body) for body in (self.ball, self.other)])
        spins: Floats = np.array(self.initial_spins) - impulse[..., None] * lever
        return spins

    @property
    def initial_energy(self) -> float:
        """Kinetic energy [J] before the contact."""
        return _kinetic(self.ball, self.other, (self.speed, self.tangential_speed, *self.initial_spins))

    @property
    def energies(self) -> dict[str, float]:
        """Where the energy is after the contact [J]; the values add up to :attr:`initial_energy`.

        ``translational`` and ``rotational`` are of the bodies. ``normal_spring``: of the compression with which a
        dissipative contact ends. ``tangential_spring``: k_t s²/2 at the end. ``normal_damping``: lost by the damping of
        the normal force. ``tangential_damping``: lost by γ_t g while the surfaces stick. ``friction``: the rest of the
        work of the tangential force, heat of slip. It may be negative with γ_t > 0 and the limit "total", which sets
        the spring against the slip, and with Mindlin's models: their spring has no energy of its own, and what it does
        not give back, or gives beyond what it got, is in ``friction``.
        """
        bodies, after = (self.ball, self.other), self.velocities
        moving = sum(_translational(body, *v) for body, v in zip(bodies, after.tolist(), strict=True))
        turning = sum(_rotational(body, w) for body, w in zip(bodies, self.spins.tolist(), strict=True))
        return {"translational": moving, "rotational": turning, **self.ledger}

    def __repr__(self) -> str:
        states = "–".join(interval.state for interval in self.intervals)
        return f"<Impact: ε = {self.restitution:.6g}, β = {self.tangential_restitution:.6g}, {states}>"

    def default_times(self) -> Floats:
        """Times [s] at which a trajectory is known by default: equally spaced, and where stick and slip begin."""
        borders = [interval.begin for interval in self.intervals]
        return np.unique([*np.linspace(0.0, self.duration, SAMPLES), *borders])

    def trajectory(self, times: ArrayLike | None = None) -> xr.Dataset:
        """Compression, forces, slip velocity and spins over time.

        Parameters
        ----------
        times : number or N numbers [s], optional
            From 0, the touch, to the duration of the contact, in any order. By default :meth:`default_times`.

        Returns
        -------
        xarray.Dataset
            Over ``time``: ``compression`` [m], ``rate`` [m/s], ``normal_force`` [N], ``tangential_force`` [N] on the
            other body along t, the part ``spring_force`` [N] of the spring, ``slip_velocity`` [m/s], ``sticks``;
            ``spin`` [rad/s] over ``time`` and ``body`` ("ball", "other").

        Raises
        ------
        ValueError
            If ``times`` is not a number or an array of numbers within the contact.
        """
        import xarray as xr

        limits: dict[str, Any] = {"lowest": 0.0, "highest": self.duration}
        limits |= {"lowest_allowed": True, "highest_allowed": True}
        at = (
            self.default_times()
            if times is None
            else np.atleast_1d(validation.array("times", times, **limits))
        )
        order = np.argsort(at, kind="stable")
        slip, back = self.slip_velocity, np.argsort(order, kind="stable")
        motion = _core.frictional_impact(*self.numbers, self.speed, abs(slip), at[order])
        sign = dict.fromkeys(TANGENTIAL, math.copysign(1.0, slip))
        values = {name: np.asarray(motion[name])[back] * sign.get(name, 1.0) for name in TRAJECTORY}
        data: dict[str, Any] = {
            name: ("time", values[name], {"units": unit, "long_name": meaning})
            for name, (unit, meaning) in TRAJECTORY.items()
        }
        impulse = self.numbers.tangential_mass * (slip - values["slip_velocity"])
        data["spin"] = (("time", "body"), self._spins(impulse), {"units": "rad/s", "long_name": "spin"})
        begins = np.array([interval.begin for interval in self.intervals])
        sticks = np.array([interval.state == "stick" for interval in self.intervals])
        data["sticks"] = ("time", sticks[np.searchsorted(begins, at, side="right") - 1])
        coords = {"time": ("time", at, {"units": "s", "long_name": "time after touch"})}
        return xr.Dataset(data, {**coords, "body": ["ball", "other"]})

    def plot(self) -> Figure:
        """Forces, slip velocity and spins over time; intervals of stick are shaded."""
        from .. import plots

        return plots.impact(self)


def arm(body: Ball | Floor) -> float:
    """Distance [m] of the contact point from the axis of a body; 0 for a floor, which does not turn."""
    return body.radius if isinstance(body, Ball) else 0.0


def slip_velocity(
    ball: Ball, other: Ball | Floor, tangential_speed: float, spin: float, other_spin: float
) -> float:
    """Velocity [m/s] of the surface of a ball relative to that of the other body, which rests."""
    return tangential_speed + arm(ball) * spin + arm(other) * other_spin


def _inertia(body: Ball | Floor) -> float:
    return body.moment_of_inertia if isinstance(body, Ball) else math.inf


def _translational(body: Ball | Floor, along: float, aside: float) -> float:
    return 0.5 * (body.mass * along * along + body.mass * aside * aside) if isinstance(body, Ball) else 0.0


def _rotational(body: Ball | Floor, spin: float) -> float:
    return 0.5 * body.moment_of_inertia * spin * spin if isinstance(body, Ball) else 0.0


def _kinetic(ball: Ball, other: Ball | Floor, motion: Sequence[float]) -> float:
    """Kinetic energy [J] of a ball with this normal and tangential velocity and of the spins of both bodies."""
    along, aside, *spins = motion
    bodies = zip((ball, other), spins, strict=True)
    return _translational(ball, along, aside) + sum(_rotational(body, spin) for body, spin in bodies)


def check_energy(arguments: str, energy: float) -> None:
    """Refuse a contact whose energies overflow or lose their digits."""
    if not LEAST_ENERGY <= energy <= LARGEST_ENERGY:
        raise ValueError(
            f"{arguments}: got a kinetic energy of {energy:g} J, "
            f"must be in [{LEAST_ENERGY:g}, {LARGEST_ENERGY:g}]"
        )


def impact_of(
    bodies: tuple[Ball, Ball | Floor],
    numbers: FrictionalContact,
    smooth: tuple[float, float],
    motion: tuple[float, float, float, float],
) -> Impact:
    """The impact with these numbers.

    Parameters
    ----------
    bodies : ball and other body
    numbers : FrictionalContact
    smooth : (float, float)
        ε and duration [s] of the contact without friction.
    motion : four floats
        Normal and tangential speed [m/s], spins [rad/s].
    """
    check_energy("speed | tangential_speed | spin", _kinetic(*bodies, motion))
    (ball, other), (speed, tangential_speed, *spins) = bodies, motion
    slip = slip_velocity(ball, other, tangential_speed, spins[0], spins[1])
    solved = _core.frictional_impact(*numbers, speed, abs(slip), np.empty(0))
    if not solved["solved"]:
        raise RuntimeError("impact: not resolved: too many steps or changes between stick and slip")
    restitution, duration = smooth
    rows = list(zip(solved["slips"].tolist(), solved["begin"].tolist(), solved["end"].tolist(), strict=True))
    intervals = [Interval("slip" if slips else "stick", begin, end) for slips, begin, end in rows]
    intervals[-1] = intervals[-1]._replace(end=duration)
    return Impact(
        ball=ball,
        other=other,
        speed=speed,
        tangential_speed=tangential_speed,
        initial_spins=(spins[0], spins[1]),
        restitution=restitution,
        tangential_restitution=solved["tangential_restitution"],
        duration=duration,
        intervals=tuple(intervals),
        ledger=MappingProxyType({name: solved[name] for name in LEDGER}),
        numbers=numbers,
    )
