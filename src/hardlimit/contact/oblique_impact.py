"""``hl.oblique_impact``: one contact with friction whose normal turns, in three dimensions."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..support import validation
from .balls import FLOOR, Ball, Floor
from .contact import Contact, Law
from .impact import LEDGER, SAMPLES, Interval, arm, check_energy

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]
Vector = Sequence[float] | Floats

AXES: Final = ["x", "y", "z"]
BODIES: Final = ["ball", "other"]
#: Columns of the path of the core: vectors by their first column, numbers.
VECTORS: Final = {"shift": 0, "velocity": 3, "spin": 6, "normal": 9, "tangential_force": 13}
NORMAL_FORCE, SLIPS = 12, 16


class EquivalentCollision(NamedTuple):
    """The instantaneous collision at touch with the same path after it; returned by ``ObliqueImpact.equivalent``.

    In arrays the first row is the ball, the second the other body.
    """

    displacements: Floats  #: (2, 3) [m], by which the centres jump
    velocities: Floats  #: (2, 3) [m/s] after
    spins: Floats  #: (2, 3) [rad/s] after


class Approach(NamedTuple):
    """A contact in the numbers of the core: the motion of the other body relative to the ball."""

    contact: _core.Contact
    distance: float  #: of the centres [m]; infinite at a wall
    arm: float  #: [m]
    rotational_ratio: float
    normal: Floats
    velocity: Floats
    spin: Floats


@validation.sealed("make impacts with hl.oblique_impact")
@dataclass(frozen=True, eq=False)
class ObliqueImpact:
    """A contact of two bodies with friction whose normal turns; made by :func:`hardlimit.oblique_impact`.

    In arrays the first row is the ball, the second the other body. Vectors are in space. Spins are angular velocities
    ω: the surface of a ball moves at v + ω × (point − centre). A wall keeps its velocity and has no spin.
    """

    contact: Contact  #: ball, other body and law
    initial_velocities: Floats  #: (2, 3) [m/s]
    initial_spins: Floats  #: (2, 3) [rad/s]
    initial_normal: Floats  #: unit vector from the ball to the other body at touch
    velocities: Floats  #: after the contact (2, 3) [m/s]
    spins: Floats  #: after the contact (2, 3) [rad/s]
    displacements: Floats  #: of the centres during the contact (2, 3) [m]
    normal: Floats  #: unit vector from the ball to the other body at the end
    duration: float  #: from touch to the end of the normal force [s]
    compression: float  #: with which a dissipative contact ends [m]
    intervals: tuple[Interval, ...]  #: in order; without a spring, stick is below Coulomb's limit
    ledger: Mapping[str, float] = field(repr=False)  #: energies in springs and lost [J], see :attr:`energies`
    approach: Approach = field(repr=False)  #: :meta private:

    @property
    def turn(self) -> float:
        """Angle [rad] by which the normal has turned."""
        chord = float(np.linalg.norm(self.normal - self.initial_normal))
        return 2.0 * math.asin(min(0.5 * chord, 1.0))

    @property
    def impulse(self) -> Floats:
        """Impulse on the other body (3,) [N s]; on the ball against it."""
        change: Floats = np.diff(self.velocities - self.initial_velocities, axis=0)[0]
        return self.contact.effective_mass * change

    @property
    def angular_impulse(self) -> Floats:
        """∫ n × F_t dt of the tangential force on the other body (3,) [N s].

        At a wall. For a pair it is weighted with the distance of the centres over that at touch.
        """
        change: Floats = self.spins[0] - self.initial_spins[0]
        ball = self.contact.ball
        return -ball.moment_of_inertia / ball.radius * change

    @property
    def initial_slip_velocity(self) -> Floats:
        """Tangential velocity [m/s] of the surface of the other body relative to that of the ball, at touch (3,)."""
        relative = np.diff(self.initial_velocities, axis=0)[0]
        return self._slip(self.initial_normal, relative, self.initial_spins, 1.0)

    @property
    def slip_velocity(self) -> Floats:
        """The same at the end of the contact (3,) [m/s]."""
        relative = np.diff(self.velocities, axis=0)[0]
        distance = self.approach.distance
        closer = 1.0 if distance == math.inf else (distance - self.compression) / distance
        return self._slip(self.normal, relative, self.spins, closer)

    def _slip(self, normal: Floats, relative: Floats, spins: Floats, closer: float) -> Floats:
        roll = closer * (self.contact.ball.radius * spins[0] + arm(self.contact.other) * spins[1])
        g: Floats = relative - np.cross(roll, normal)
        return g - (g @ normal) * normal

    @property
    def restitution(self) -> float:
        """Speed of separation along the normal at the end over speed of approach along that at touch."""
        before = np.diff(self.initial_velocities, axis=0)[0] @ self.initial_normal
        return float(-(np.diff(self.velocities, axis=0)[0] @ self.normal) / before)

    @property
    def tangential_restitution(self) -> float:
        """β: slip velocity at the end against its direction at touch, which turns with the normal, over that at touch.

        The part of the slip velocity across this direction is not in β. NaN if there is no slip velocity at touch.

        Notes
        -----
        Foerster et al., Phys. Fluids 6, 1108 (1994), for a fixed normal.
        """
        g = self.initial_slip_velocity
        square = float(g @ g)
        if square == 0.0:
            return math.nan
        axis = np.cross(self.initial_normal, self.normal)
        cosine = float(self.initial_normal @ self.normal)
        turned = cosine * g + np.cross(axis, g) + axis * float(axis @ g) / (1.0 + cosine)
        return float(-(self.slip_velocity @ turned) / square)

    @property
    def transitions(self) -> int:
        """How often the surfaces change between stick and slip."""
        return len(self.intervals) - 1

    @property
    def initial_energy(self) -> float:
        """Kinetic energy [J] before the contact, in the frame of the centre of mass; at a wall in that of the wall."""
        return sum(_kinetic(self.contact, self.initial_velocities, self.initial_spins))

    @property
    def energies(self) -> dict[str, float]:
        """Where the energy is after the contact [J]; the values add up to :attr:`initial_energy`.

        ``translational`` and ``rotational`` are of the bodies, in the frame of the centre of mass or the wall. The
        others are those of :attr:`Impact.energies`.
        """
        moving, turning = _kinetic(self.contact, self.velocities, self.spins)
        return {"translational": moving, "rotational": turning, **self.ledger}

    @property
    def equivalent(self) -> EquivalentCollision:
        """The equivalent instantaneous collision.

        Notes
        -----
        Free flight with the velocities after it, drawn back to the instant of touch (Müller & Pöschel, Phys. Rev. E 87,
        033301 (2013), with rotation).
        """
        back = self.displacements - self.duration * self.velocities
        return EquivalentCollision(back, self.velocities, self.spins)

    def default_times(self) -> Floats:
        """Times [s] of a trajectory by default: equally spaced, and where stick and slip begin."""
        borders = [interval.begin for interval in self.intervals]
        return np.unique([*np.linspace(0.0, self.duration, SAMPLES), *borders])

    def trajectory(self, times: ArrayLike | None = None) -> xr.Dataset:
        """Positions, velocities, spins and forces over time.

        Parameters
        ----------
        times : N numbers [s], optional
            From 0, the touch, to the duration of the contact, in any order. By default :meth:`default_times`.

        Returns
        -------
        xarray.Dataset
            Over ``time`` and ``axis`` ("x", "y", "z"): ``normal``, ``tangential_force`` [N] on the other body,
            ``slip_velocity`` [m/s]; also over ``body`` ("ball", "other"): ``displacement`` [m] since touch,
            ``velocity`` [m/s], ``spin`` [rad/s]; over ``time``: ``compression`` [m], ``normal_force`` [N], ``sticks``.

        Raises
        ------
        ValueError
            If ``times`` is not an array of numbers within the contact.
        """
        import xarray as xr

        limits: dict[str, Any] = {"lowest": 0.0, "highest": self.duration}
        limits |= {"lowest_allowed": True, "highest_allowed": True}
        at = self.default_times() if times is None else validation.array("times", times, **limits)
        order = np.argsort(at, kind="stable")
        path = np.empty((len(at), SLIPS + 1))
        path[order] = _core.turning_path(*self.approach, at[order])
        motion = {name: path[:, k : k + 3] for name, k in VECTORS.items()}
        velocities, displacements = _of_bodies(
            self.contact, self.initial_velocities, motion["velocity"], motion["shift"], at
        )
        shares = _spin_shares(self.contact)
        spins = self.initial_spins + (motion["spin"] - self.approach.spin)[:, None, :] * shares[:, None]
        vector, of_bodies = ("time", "axis"), ("time", "body", "axis")
        data: dict[str, Any] = {
            "displacement": (of_bodies, displacements, {"units": "m"}),
            "velocity": (of_bodies, velocities, {"units": "m/s"}),
            "spin": (of_bodies, spins, {"units": "rad/s"}),
            "normal": (vector, motion["normal"]),
            "tangential_force": (vector, motion["tangential_force"], {"units": "N"}),
            "normal_force": ("time", path[:, NORMAL_FORCE], {"units": "N"}),
            "sticks": ("time", path[:, SLIPS] == 0.0),
            **self._surfaces(motion, spins),
        }
        coords = {"time": ("time", at, {"units": "s", "long_name": "time after touch"})}
        return xr.Dataset(data, {**coords, "body": BODIES, "axis": AXES})

    def _surfaces(self, motion: dict[str, Floats], spins: Floats) -> dict[str, Any]:
        """Compression and slip velocity over time."""
        distance, normals = self.approach.distance, motion["normal"]
        if distance == math.inf:
            compression, closer = -(motion["shift"] * normals).sum(axis=1), np.ones(len(spins))
        else:
            apart = np.linalg.norm(distance * self.initial_normal + motion["shift"], axis=1)
            compression, closer = distance - apart, apart / distance
        states = zip(normals, motion["velocity"], spins, closer, strict=True)
        slip = np.reshape([self._slip(*state) for state in states], (-1, 3))
        return {
            "slip_velocity": (("time", "axis"), slip, {"units": "m/s"}),
            "compression": ("time", compression, {"units": "m"}),
        }

    def plot(self) -> Figure:
        """Forces, slip speed and spins over time; intervals of stick are shaded."""
        from ..plots.oblique_impact import oblique_impact as figure

        return figure(self)

    def __repr__(self) -> str:
        states = "–".join(interval.state for interval in self.intervals)
        return (
            f"<ObliqueImpact: ε = {self.restitution:.6g}, β = {self.tangential_restitution:.6g}, "
            f"turn {math.degrees(self.turn):.4g}°, {states}>"
        )


def oblique_impact(
    ball: Ball,
    other: Ball | Floor,
    law: Law,
    velocity: Vector,
    *,
    other_velocity: Vector = (0.0, 0.0, 0.0),
    spins: Vector | Sequence[Vector] = (0.0, 0.0, 0.0),
    normal: Vector = (0.0, 0.0, -1.0),
) -> ObliqueImpact:
    """One contact of a ball with another one or a wall under a law with friction, from touch to separation.

    The contact has a finite duration: the line of centres turns, and surfaces stick and slip in three dimensions.

    Parameters
    ----------
    ball : Ball
    other : Ball or FLOOR
        A wall is ``hl.FLOOR`` with a ``normal`` of any direction.
    law : Law
        With friction, or without.
    velocity : (3,) [m/s]
        Of the ball.
    other_velocity : (3,) [m/s], default 0
        Of the other body; a wall keeps it.
    spins : (3,) or (2, 3) [rad/s], default 0
        Angular velocity of the ball, or of both balls.
    normal : (3,), default (0, 0, −1)
        Direction from the ball to the other body at touch, of any length: by default the other body is below.

    Raises
    ------
    ValueError
        If an argument is outside its range, the kinetic energy is outside [1e-290, 1e300] J, or the bodies do not
        approach each other.
    RuntimeError
        If the contact becomes too deep, or is not resolved.

    Notes
    -----
    The friction is a spring with a dashpot and Coulomb's limit (Cundall & Strack, Géotechnique 29, 47 (1979)). The
    lever arms are R_i r/(R_i + R_j): both momenta are conserved, and energy without slip and damping. Integration of
    order 8 with located changes of stick and slip. :meth:`Contact.impact` is the limit of a short contact.

    Examples
    --------
    >>> law = hl.LinearDashpot(
    ...     stiffness=1e4, restitution=0.9, friction=hl.Friction(0.5)
    ... )
    >>> ball = hl.Ball(0.01, density=2500.0)
    >>> hl.oblique_impact(ball, ball, law, velocity=(1.0, 0.0, -1.0))
    <ObliqueImpact: ε = 0.879438, β = 1.02969, turn 4.738°, stick–slip>
    """
    contact = _checked_contact(ball, other, law)
    moves = np.array([_vector("velocity", velocity), _vector("other_velocity", other_velocity)])
    turns = _checked_spins(spins, other)
    n = _vector("normal", normal)
    length = float(np.linalg.norm(n))
    if length == 0.0:
        raise ValueError("normal: got a vector of length 0, must be a direction")
    n = n / length
    if not (moves[0] - moves[1]) @ n > 0.0:
        raise ValueError(
            "velocity | other_velocity | normal: the bodies must approach each other along the normal"
        )
    check_energy("velocity | other_velocity | spins", sum(_kinetic(contact, moves, turns)))
    return _solved(contact, moves, turns, n)


def _kinetic(contact: Contact, velocities: Floats, spins: Floats) -> tuple[float, float]:
    """Energies [J] of the relative motion of the centres and of the spins; overflow gives infinity."""
    with np.errstate(over="ignore", under="ignore"):
        relative = np.diff(velocities, axis=0)[0]
        rotational = sum(
            0.5 * body.moment_of_inertia * float(spin @ spin)
            for body, spin in zip((contact.ball, contact.other), spins, strict=True)
            if isinstance(body, Ball)
        )
        return 0.5 * contact.effective_mass * float(relative @ relative), rotational


def _checked_contact(ball: Any, other: Any, law: Any) -> Contact:
    if not isinstance(law, Law):
        raise ValueError(f"law: got {validation.shown(law)}, must be a Law")
    contact = law.between(ball, other)
    friction = law.friction
    if friction is not None and friction.damping and friction.model not in ("spring", "none"):
        raise ValueError(
            f"damping: got it with the model {friction.model}, must be damping_ratio; "
            "else the spring is singular at touch"
        )
    return contact


def _vector(name: str, value: Any) -> Floats:
    vector = validation.array(name, value)
    if vector.shape != (3,):
        raise ValueError(f"{name}: got shape {vector.shape}, must be (3,)")
    return vector


def _checked_spins(spins: Any, other: Ball | Floor) -> Floats:
    """Spins (2, 3) of both bodies."""
    values = validation.array("spins", spins, ndim=2)
    if values.shape == (3,):
        return np.array([values, np.zeros(3)])
    if values.shape != (2, 3):
        raise ValueError(f"spins: got shape {values.shape}, must be (3,) or (2, 3)")
    if other is FLOOR and values[1].any():
        raise ValueError("spins: got a spin of the floor, must be 0")
    return values


def _spin_shares(contact: Contact) -> Floats:
    """Δω of both bodies over ΔΩ of the spin (R_i ω_i + R_j ω_j)/l, at a wall ω."""
    if not isinstance(contact.other, Ball):
        return np.array([1.0, 0.0])
    bodies = (contact.ball, contact.other)
    levers = np.array([body.radius / body.moment_of_inertia for body in bodies])
    radii = np.array([body.radius for body in bodies])
    shares: Floats = levers * (radii.sum() / (levers @ radii))
    return shares


def _of_bodies(
    contact: Contact, before: Floats, velocity: Floats, shift: Floats, time: Floats
) -> tuple[Floats, Floats]:
    """Velocities and displacements (…, 2, 3) of both bodies from those of the other relative to the ball."""
    masses = np.array([contact.ball.mass, contact.other.mass])
    shares = np.array([-1.0, 0.0])
    mean = before[1]
    if isinstance(contact.other, Ball):
        shares = np.array([-masses[1], masses[0]]) / masses.sum()
        mean = masses @ before / masses.sum()
    velocities = mean + velocity[..., None, :] * shares[:, None]
    displacements = np.asarray(time)[..., None, None] * mean + shift[..., None, :] * shares[:, None]
    return velocities, displacements


def _approach(contact: Contact, moves: Floats, turns: Floats, normal: Floats) -> Approach:
    ball, other = contact.ball, contact.other
    ratio = contact.effective_mass / contact.tangential_mass - 1.0
    relative = moves[1] - moves[0]
    if not isinstance(other, Ball):
        return Approach(contact.core, math.inf, ball.radius, ratio, normal, relative, turns[0])
    distance = ball.radius + other.radius
    spin = (ball.radius * turns[0] + other.radius * turns[1]) / distance
    return Approach(contact.core, distance, distance, ratio, normal, relative, spin)


def _solved(contact: Contact, moves: Floats, turns: Floats, normal: Floats) -> ObliqueImpact:
    approach = _approach(contact, moves, turns, normal)
    end = _core.turning_contact(*approach)
    if end["outcome"] != "ok":
        reasons = dict(zip(_core.outcome_names, _core.outcome_messages, strict=True))
        raise RuntimeError(f"oblique impact: {reasons[end['outcome']]}")
    velocity, shift, spin = (np.array(end[name]) for name in ("velocity", "shift", "spin"))
    velocities, displacements = _of_bodies(contact, moves, velocity, shift, end["duration"])
    return ObliqueImpact(
        contact=contact,
        initial_velocities=moves,
        initial_spins=turns,
        initial_normal=normal,
        velocities=velocities,
        spins=turns + np.outer(_spin_shares(contact), spin - approach.spin),
        displacements=displacements,
        normal=np.array(end["normal"]),
        duration=end["duration"],
        compression=end["compression"],
        intervals=_intervals(end),
        ledger=MappingProxyType({name: end[name] for name in LEDGER}),
        approach=approach,
    )


def _intervals(end: dict[str, Any]) -> tuple[Interval, ...]:
    """The intervals of stick and slip; of very many changes the first."""
    borders = [0.0, *end["change_times"], end["duration"]]
    states = ("slip", "stick") if end["slips_first"] else ("stick", "slip")
    return tuple(Interval(states[i % 2], begin, stop) for i, (begin, stop) in enumerate(pairwise(borders)))
