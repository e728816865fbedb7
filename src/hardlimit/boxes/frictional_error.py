"""Theory of the law of the error with friction: what friction adds to the coefficient a of smooth particles.

Both gases, of hard spheres and under Newton's equations, are followed by the balance of the energies of translation and
rotation, from equal spins to the end of the measured window. Under Newton's equations four things differ, to first
order in t_c ν: contacts store energy in both springs, they turn while they last, neighbours press them together, and
the temperature ratio θ = T_r/T follows its own path. Turn and pressure are quadratures over isolated contacts.
docs/error_law.md compares with measurements.

Units: radii 1, speeds √T(0), ν(0) = 1 for the balance.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache, partial
from itertools import pairwise
from types import MappingProxyType
from typing import Any, Final, NamedTuple

import numpy as np

from .. import _core
from ..contact.balls import Ball
from ..contact.contact import Contact, Law
from ..contact.friction import LIMITS, SPRING, Friction, FrictionTerms
from ..contact.laws import LinearDashpot, Tsuji, Viscoelastic
from ..support import validation
from ..support.formatting import listed
from .box import Floats
from .theory import Gas, RotatingGas
from .transport import impacts

#: Mean impact speed at T = 1.
IMPACT_SPEED: Final = math.sqrt(math.pi)
#: Collisions per particle between which the law was measured.
WINDOW: Final = (3.0, 9.0)
#: Size of a contact over the diameter, w/d = ⟨t_c⟩√(T/π)/d, at which turning contacts are compared with those of a
#: fixed normal, whose diameter is larger by the factor FLAT.
SIZE: Final = 1e-3
FLAT: Final = 1e7
#: Contacts of the quadrature over the turn, and over the energy in springs, of linear and of other laws, which take
#: longer; times in each of the latter.
TURNING: Final = MappingProxyType({True: 2048, False: 512})
STORING: Final = MappingProxyType({True: 256, False: 64})
INSTANTS: Final = 16
#: Contacts of the quadrature over those that neighbours press together, steps in each, and s w/d in it.
PRESSED: Final = 512
PRESSED_STEPS: Final = 200
PRESSURE: Final = 0.01
#: Temperature ratios at which the exchange of energy is tabulated.
RATIOS: Final = np.array([0.0, 0.1, 0.25, 0.5, 0.8, 1.2, 1.8, 2.7, 4.0, 7.0, 12.0])
#: Smallest distance of the temperature ratios between which a line is drawn.
APART: Final = 0.2
#: Steps in each part of the balance, and t_c ν at the start for its derivative.
STEPS: Final = 40
SMALL: Final = 1e-4
#: Change of θ for the slopes of the exchange of energy.
SLOPE: Final = 1e-3


#: Powers of the linear force, and the laws by their powers.
LINEAR: Final = (4, 0)
MATERIAL: Final[Mapping[str, Any]] = MappingProxyType({"youngs_modulus": 1.0, "poisson_ratio": 0.3})
LAWS: Final[Mapping[tuple[int, int], Callable[..., Law]]] = MappingProxyType(
    {
        LINEAR: partial(LinearDashpot, stiffness=1.0),
        (6, 1): partial(Tsuji, **MATERIAL),
        (6, 2): partial(Viscoelastic, **MATERIAL, impact_speed=IMPACT_SPEED),
    }
)
#: By dimension − 2: coefficients b0 and b1 of the effect of third particles, (b0 + b1 φ) S, where S is the mean energy
#: in the tangential spring over the loss of a collision. A fit to the measurement.
THIRD: Final = ((1.0, 0.65), (0.78, 0.37))
#: Standard error of a by friction: constant, in proportion to 1 − ε², and shares of turn, pressure and third particles.
BAR: Final = (0.02, 0.04, 0.05, 0.1, 0.1)
#: Ranges in which the law was measured.
MEASURED: Final = MappingProxyType(
    {
        "μ": (0.0, 1.0),
        "(m_n/m_t) k_t/k_n": (1.0, 3.5),
        "γ_t/γ_n": (0.0, 1.0),
        "ε": (0.7, 0.99),
    }
)
#: The same for heated gases, by studies/driven_friction.py. For μ → 0 the law is that of smooth grains.
MEASURED_HEATED: Final = MappingProxyType(
    {
        "μ": (0.0, 1.0),
        "(m_n/m_t) k_t/k_n": (1.0, 2.88),
        "γ_t/γ_n": (0.0, 0.5),
        "ε": (0.7, 0.9),
        "φ": (0.1, 0.5),
    }
)
#: The same for sheared gases.
MEASURED_SHEARED: Final = MappingProxyType(
    {
        "μ": (0.0, 1.0),
        "(m_n/m_t) k_t/k_n": (1.0, 2.88),
        "γ_t/γ_n": (0.0, 0.5),
        "ε": (0.7, 0.97),
        "φ": (0.1, 0.45),
    }
)
#: Relative distance from these ranges that counts as none; of ε, in 1 − ε.
NEAR: Final = 0.05
ANGLES: Final = 1000  #: angles of impact in a table of β, which changes a by less than 1e-8
#: Factors by which values may be outside these ranges; beyond, nothing is known.
BEYOND: Final = 2.0


class Setting(NamedTuple):
    """Grains with friction."""

    dimension: int
    restitution: float
    friction: Friction
    theta: float  #: T_r/T at the start
    inertia_factor: float
    powers: tuple[int, int] = LINEAR  #: four times p and q of the normal force K ξ^p + C ξ^q dξ/dt

    def values(self) -> dict[str, float]:
        """Those of :data:`MEASURED`."""
        ratio = (1.0 + 1.0 / self.inertia_factor) * (self.friction.stiffness_ratio or math.nan)
        damping = self.friction.damping_ratio or 0.0
        return dict(zip(MEASURED, (self.friction.coefficient, ratio, damping, self.restitution), strict=True))

    def not_known(self) -> str:
        """Why nothing is known of them, in words; empty if it is."""
        model, linear = self.friction.model or "", self.powers == LINEAR
        if (model != SPRING) if linear else not model.startswith("mindlin"):
            return f"got the model {model}, must be {SPRING if linear else 'one of Mindlin’s'}"
        if self.powers not in LAWS:
            return (
                "got it with another normal force, must be that of linear, Tsuji’s or viscoelastic contacts"
            )
        for name, value in self.values().items():
            low, high = MEASURED[name]
            least, most = low / BEYOND, min(high * BEYOND, 1.0) if name == "ε" else high * BEYOND
            if name == "ε":
                least = 1.0 - BEYOND * (1.0 - low)
            if not least <= value <= most:
                return (
                    f"got {name} = {value:.3g}, must be in [{least:g}, {most:g}], near which it was measured"
                )
        return ""

    def beyond(self) -> dict[str, tuple[float, float, float]]:
        """The values outside the range of the measurements by their names, and its ends."""
        return _beyond(self.values(), MEASURED)

    def outside(self) -> list[str]:
        """Which values are outside the range of the measurements, in words."""
        ranges = [
            f"{name} = {value:.3g} is outside the measured range {low:g} to {high:g}"
            for name, (value, low, high) in self.beyond().items()
        ]
        return ["Hertz' laws with friction were measured at three points only"] * (
            self.powers != LINEAR
        ) + ranges

    def distance(self) -> float:
        """How far outside, for the error bar: 0 inside, 2 where a value is twice as large, 1 for Hertz' laws."""
        far = sum(
            abs(math.log2(value / min(max(value, low), high))) for value, low, high in self.beyond().values()
        )
        return 2.0 * far + (self.powers != LINEAR)

    def outside_driven(self, phi: float, sheared: bool) -> str:
        """As :meth:`outside`, of the measurements of sheared or heated gases."""
        measured = MEASURED_SHEARED if sheared else MEASURED_HEATED
        outside = _beyond({**self.values(), "φ": phi}, measured)
        if not outside:
            return ""
        ranges = listed([f"{low:g} ≤ {name} ≤ {high:g}" for name, (_, low, high) in outside.items()])
        values = listed([f"{value:.3g}" for value, *_ in outside.values()])
        return f"{'sheared' if sheared else 'heated'} gases were measured at {ranges}, not at {values}"

    def contact(self) -> Contact:
        """Two equal grains with a stiffness or a modulus of 1; ε at the mean impact speed."""
        law = LAWS[self.powers](restitution=self.restitution, friction=self.friction)
        ball = Ball(1.0, mass=2.0, inertia_factor=self.inertia_factor)
        return law.between(ball, ball)


def _beyond(
    values: Mapping[str, float], measured: Mapping[str, tuple[float, float]]
) -> dict[str, tuple[float, float, float]]:
    """The values outside the measured range by their names, and its ends."""

    def inside(name: str, value: float, low: float, high: float) -> bool:
        if name == "ε":
            value, low, high = 1.0 - value, 1.0 - high, 1.0 - low
        return low * (1.0 - NEAR) <= value <= high * (1.0 + NEAR)

    ends = {name: (value, *measured[name]) for name, value in values.items()}
    return {name: beyond for name, beyond in ends.items() if not inside(name, *beyond)}


def friction_of(law: Law | None, friction: Friction | None) -> Friction | None:
    """The friction of a law, or the given one as that of a linear dashpot, with ratios in place of N/m."""
    if friction is not None and not isinstance(friction, Friction):
        raise ValueError(f"friction: got {validation.shown(friction)}, must be a Friction")
    if friction is None:
        own = None if law is None else law.friction
    elif law is not None and law.friction is not None:
        raise ValueError("law | friction: got both with friction, must be one of them")
    else:
        bare = LinearDashpot(stiffness=1.0, restitution=1.0) if law is None else law
        own = bare.replace(friction=friction).friction
    if own is None or own.coefficient == 0.0:
        return None
    if own.stiffness is not None:
        if law is None or "stiffness" not in law.parameters:
            raise ValueError("friction: got stiffness, must be stiffness_ratio")
        ratio = own.stiffness / law.parameters["stiffness"]
        own = replace(own, stiffness=None, stiffness_ratio=ratio)
    if own.damping:
        raise ValueError("friction: got damping, must be damping_ratio")
    return replace(own, damping=None)


def third_particles(dimension: int, phi: float, spring: float) -> float:
    """By how much third particles reduce a: they release tangential springs before these give their energy back."""
    b0, b1 = THIRD[dimension - 2]
    return (b0 + b1 * phi) * spring


def bar(x: float, turn: float, pressure: float, third: float) -> float:
    """Standard error of the change of a by friction, from the residuals of the measurement; x = 1 − ε²."""
    constant, growing, *shares = BAR
    parts = zip(shares, (turn, pressure, third), strict=True)
    return math.hypot(constant + growing * x, *(share * part for share, part in parts))


class Turned(NamedTuple):
    """Changes of a collision by its turn over w/d and the loss: of the loss, and minus that of the gain of rotation.

    By pressure of the neighbours: the same over s w/d.
    """

    loss: float = 0.0
    exchange: float = 0.0

    def between(self, other: Turned, x: float) -> Turned:
        """This at x = 0, the other at 1."""
        return Turned(*(a + x * (b - a) for a, b in zip(self, other, strict=True)))


class Stored(NamedTuple):
    """Mean energy over a contact in m T."""

    normal: float  #: in the normal spring
    tangential: float  #: in the tangential one
    rotation: float  #: that rotation still gains until the end


def axes_of_rotation(dimension: int) -> int:
    return 3 if dimension == 3 else 1


def is_linear(contact: Contact) -> bool:
    return tuple(contact.law.record["powers"]) == LINEAR


def mean_duration(contact: Contact) -> float:
    """Mean duration of the collisions at T = 1."""
    u = (np.arange(64) + 0.5) / 64.0
    return float(contact.duration(2.0 * np.sqrt(-np.log1p(-u))).mean())


def turned_at(contact: Contact, theta: float, dimension: int) -> Turned:
    """Quadrature over isolated contacts of two equal particles at T = 1, turning and with a fixed normal."""
    q, mass = contact.ball.inertia_factor, contact.ball.mass
    velocities, spins = impacts(TURNING[is_linear(contact)], theta, q, dimension)
    normal, ratio = np.array([0.0, 0.0, 1.0]), contact.effective_mass / contact.tangential_mass - 1.0
    diameter = mean_duration(contact) / (math.sqrt(math.pi) * SIZE)
    changes = np.zeros((2, 2))  # turning and flat; of all energy and of rotation
    for row, d in zip(changes, (diameter, FLAT * diameter), strict=True):
        inertia = 0.25 * q * mass * d * d
        for v, s in zip(velocities, spins / d, strict=True):
            end = _core.turning_contact(contact.core, d, d, ratio, normal, v, s)
            after, spin = np.array(end["velocity"]), np.array(end["spin"])
            spun = inertia * float(spin @ spin - s @ s)
            row += (0.25 * mass * float(after @ after - v @ v) + spun, spun)
    by_turn = (changes[0] - changes[1]) / (SIZE * changes[1, 0])
    return Turned(*by_turn.tolist())


def pressed_at(contact: Contact, theta: float, dimension: int) -> Turned:
    """Quadrature of contacts of a fixed normal at T = 1 that neighbours press together, by the mean force m T s/d."""
    velocities, spins = impacts(PRESSED, theta, contact.ball.inertia_factor, dimension)
    spinning = np.stack([-spins[:, 1], spins[:, 0]], axis=1)
    surface = velocities[:, :2] + spinning
    slide = np.linalg.norm(surface, axis=1)
    along = np.sum(spinning * surface, axis=1) / slide
    mass, tangential = contact.effective_mass, contact.tangential_mass
    push = PRESSURE * contact.ball.mass / mass * math.sqrt(math.pi) / mean_duration(contact)
    losses = []  # of all energy and of rotation
    for acceleration in (0.0, push):
        normal, end = pressed_contacts(contact, -velocities[:, 2], slide, acceleration)
        impulse = tangential * (slide - end)
        rotation = impulse * along - 0.5 * impulse**2 * (1.0 / tangential - 1.0 / mass)
        losses.append([np.mean(normal + 0.5 * tangential * (slide**2 - end**2)), rotation.mean()])
    before, after = np.array(losses)
    return Turned(*((after - before) / (PRESSURE * before[0])).tolist())


def pressed_contacts(contact: Contact, speed: Floats, slide: Floats, push: float) -> tuple[Floats, Floats]:
    """Energy that contacts lose by normal damping, and tangential velocity at their end.

    ``speed``, ``slide``: normal and tangential velocity at touch. ``push``: acceleration by neighbours. Steps are those
    of the midpoint rule, halved where they pass the end; tangential forces are taken in their middle.
    """
    friction = contact.friction_terms
    assert friction is not None
    mass, step = contact.effective_mass, contact.duration(speed) / PRESSED_STEPS
    still = np.zeros_like(speed)
    depth, rate, lost, elastic = 1e-9 * step * speed, speed, still, still
    of_law = contact.core.force  # no value needs a check
    first = of_law(depth, rate)
    for _ in range(PRESSED_STEPS + PRESSED_STEPS // 4):  # pressed contacts last longer
        half = rate + 0.5 * step * (push - first / mass)
        middle = np.maximum(depth + 0.5 * step * rate, 0.0)
        force = of_law(middle, half)
        further, slower = np.maximum(depth + step * half, 0.0), rate + step * (push - force / mass)
        last = of_law(further, slower)
        lasts = last > 0.0
        move, step = np.where(lasts, step, 0.0), np.where(lasts, step, 0.5 * step)
        lost = lost + move * half * (force - of_law(middle, still))
        shrinking = np.where(rate > 0.0, friction.loading, friction.unloading)
        shrunk = np.where(lasts, further / depth, 1.0) ** (0.5 * shrinking)
        depth, rate, first = (
            np.where(lasts, new, old) for new, old in ((further, depth), (slower, rate), (last, first))
        )
        stiffness = friction.stiffness * middle ** (0.25 * friction.stiffness_power)
        damping = friction.damping * middle ** (0.25 * friction.damping_power)
        trial = elastic * shrunk + stiffness * move * slide
        slide, spring = _rubbed(friction, force, trial, damping, slide, move / contact.tangential_mass)
        elastic = np.where(lasts, spring, elastic)
    return lost + contact.energy(depth), slide


def _rubbed(
    friction: FrictionTerms, force: Floats, elastic: Floats, damping: Floats, slide: Floats, step: Floats
) -> tuple[Floats, Floats]:
    """Tangential velocity and elastic force after a step within Coulomb's limit; ``step``: over the tangential mass."""
    limit, total = friction.coefficient * force, elastic + damping * slide
    if LIMITS[friction.limit] == "total":
        inside = np.clip(total, -limit, limit)
        return slide - step * inside, np.where(np.abs(total) > limit, inside - damping * slide, elastic)
    inside = np.clip(elastic, -limit, limit)
    return slide - step * np.where(np.abs(elastic) > limit, inside, total), inside


def stored(contact: Contact, theta: float, dimension: int) -> Stored:
    """Mean energy in the springs of a contact with a fixed normal at T = 1, weighted by durations."""
    q, mass, friction = contact.ball.inertia_factor, contact.ball.mass, contact.friction_terms
    assert friction is not None
    velocities, spins = impacts(STORING[is_linear(contact)], theta, q, dimension)
    normal, ratio = np.array([0.0, 0.0, 1.0]), contact.effective_mass / contact.tangential_mass - 1.0
    d = FLAT * mean_duration(contact)
    inertia = 0.25 * q * mass * d * d
    energies, total = np.zeros(3), 0.0
    for v, s in zip(velocities, spins / d, strict=True):
        duration = float(contact.duration(-v[2]))
        times = (np.arange(INSTANTS) + 0.5) / INSTANTS * duration
        path = _core.turning_path(contact.core, d, d, ratio, normal, v, s, times)
        spin = np.array(_core.turning_contact(contact.core, d, d, ratio, normal, v, s)["spin"])
        compression = np.maximum(-path[:, 2], 0.0)
        stiffness = friction.stiffness * compression ** (0.25 * friction.stiffness_power)
        force = np.sum(path[:, 13:16] ** 2, axis=1)
        spring = np.divide(force, 2.0 * stiffness, out=np.zeros(INSTANTS), where=stiffness > 0.0)
        gained = inertia * float(spin @ spin - np.sum(path[:, 6:9] ** 2, axis=1).mean())
        energies += duration * np.array([contact.energy(compression).mean(), spring.mean(), gained])
        total += duration
    return Stored(*(energies / (total * mass)).tolist())


class Changes(NamedTuple):
    """What Newton's equations change, to first order in t_c ν: relative changes of the temperatures by the energy in
    contacts, and the changes of a collision by its turn, over t_c ν."""

    translation: float = 0.0
    rotation: float = 0.0
    ratios: tuple[float, float] = (0.0, 1.0)  #: two temperature ratios
    turned: tuple[Turned, Turned] = (Turned(), Turned())  #: at these, and by a line between and beyond them

    def turn(self, theta: float) -> Turned:
        first, second = self.ratios
        return self.turned[0].between(self.turned[1], (theta - first) / (second - first))


class Path(NamedTuple):
    """A gas between the energies of the window."""

    duration: float
    root: float  #: mean √(T/T(0))
    ratio: float  #: mean θ


#: Hard spheres.
HARD: Final = Changes()


class Balance:
    """The path of a cooling gas. E is the energy of translation and rotation that is not yet dissipated."""

    def __init__(self, gas: RotatingGas, exponent: float) -> None:
        """``exponent``: 1 + (c + 1)/q, with which the loss grows with the temperature under Newton's equations."""
        from scipy.interpolate import CubicSpline

        self.dimension, self.exponent = gas.gas.dimension, exponent
        self.axes = axes_of_rotation(self.dimension)
        means = [gas.mean_collision(theta) for theta in RATIOS.tolist()]
        table = np.array([[mean.energy_change, mean.rotational_energy_change] for mean in means])
        self._spline = CubicSpline(RATIOS / (1.0 + RATIOS), table / (1.0 + RATIOS)[:, None])

    def collision(self, theta: float) -> Floats:
        """Changes of the energy and of that of rotation, in m T."""
        changes: Floats = self._spline(theta / (1.0 + theta)) * (1.0 + theta)
        return changes

    def rates(self, theta: float, tc_nu: float = 0.0, changes: Changes = HARD) -> tuple[float, float]:
        """d ln E and dθ for a collision of each particle."""
        seen = theta * (1.0 + (changes.rotation - changes.translation) * tc_nu)
        loss, gain = self.collision(max(seen, 0.0)).tolist()
        factor = 1.0 + self.exponent * changes.translation * tc_nu
        turn = changes.turn(theta)
        gain = gain * factor + loss * turn.exchange * tc_nu
        loss *= factor + turn.loss * tc_nu
        translation, rotation = (loss - gain) / self.dimension, gain / self.axes
        return loss / (self.dimension + self.axes * theta), rotation - theta * translation

    def energies(self, theta: float) -> tuple[float, float]:
        """ln E of hard spheres at the ends of the window; E(0) = 1."""
        state, ends = np.array([0.0, theta]), []
        for first, last in pairwise((0.0, *WINDOW)):
            for _ in range(STEPS):
                state = _step(lambda _, y: np.array(self.rates(y[1])), 0.0, state, (last - first) / STEPS)
            ends.append(float(state[0]))
        return ends[0], ends[1]

    def through(self, theta: float, energies: tuple[float, float], tc_nu: float, changes: Changes) -> Path:
        """From the start to the end of the window."""
        begin = self.dimension + self.axes * theta

        def derivatives(energy: float, y: Floats) -> Floats:
            root = math.sqrt(math.exp(energy) * begin / (self.dimension + self.axes * y[0]))  # √(T/T(0))
            cooling, turning = self.rates(y[0], tc_nu * root, changes)
            time = 1.0 / (cooling * root)
            return np.array([turning / cooling, time, root * time, y[0] * time])

        state = np.array([theta, 0.0, 0.0, 0.0])
        for first, last in pairwise((0.0, *energies)):
            state[1:] = 0.0
            step = (last - first) / STEPS
            for i in range(STEPS):
                state = _step(derivatives, first + i * step, state, step)
        return Path(float(state[1]), float(state[2] / state[1]), float(state[3] / state[1]))


def _step(derivatives: Callable[[float, Floats], Floats], x: float, y: Floats, step: float) -> Floats:
    """One step of the method of Runge and Kutta."""
    first = derivatives(x, y)
    second = derivatives(x + 0.5 * step, y + 0.5 * step * first)
    third = derivatives(x + 0.5 * step, y + 0.5 * step * second)
    fourth = derivatives(x + step, y + step * third)
    return y + step / 6.0 * (first + 2.0 * second + 2.0 * third + fourth)


class CoefficientTerms(NamedTuple):
    """What friction makes of the coefficient a; made by :func:`terms`."""

    energy: float  #: a by the energy in contacts and their delay
    turn: float  #: a D 2^D φ χ by the turn of contacts
    pressure: float  #: a D 2^D φ χ/s by the pressure of neighbours
    spring: float  #: mean energy in tangential springs over the loss of a collision
    temperature_ratio: float  #: mean θ in the window
    offset: float  #: error of the rule constant with β0 of the law that does not vanish with t_c ν; NaN if it has no β0
    smooth_error: float  #: that of hard spheres without friction, by the cooling of translation


@lru_cache(maxsize=64)
def _balance(setting: Setting, exponent: float) -> tuple[Gas, Balance]:
    """The gas and the balance of its hard spheres, which do not depend on θ at the start."""
    from scipy.interpolate import PchipInterpolator

    contact = setting.contact()
    ball = contact.ball
    gas = Gas(1, ball.radius, ball.mass, 1e3 * ball.radius**3, setting.dimension, ball.inertia_factor)
    # β from a table: the averages at each θ take thousands of contacts.
    angles = (np.arange(ANGLES) + 0.5) / ANGLES * 0.5 * math.pi
    beta = PchipInterpolator(angles, contact.tangential_restitution(angles, IMPACT_SPEED), extrapolate=True)
    rotating = gas.rotating(
        float(contact.restitution(IMPACT_SPEED)),
        tangential_restitution=lambda tangents: np.asarray(beta(np.arctan(tangents))),
    )
    return gas, Balance(rotating, exponent)


@lru_cache(maxsize=512)
def terms(setting: Setting, q: float, c: float, delayed: float) -> CoefficientTerms:
    """The terms of equal grains with friction.

    ``q``, ``c``: exponents of the law. ``delayed``: b in the term −b (1 − ε²)/D of smooth particles, by which contacts
    in progress and third particles reduce a.
    """
    contact, dimension, theta = setting.contact(), setting.dimension, setting.theta
    ball, axes = contact.ball, axes_of_rotation(dimension)
    exponent = 1.0 + (c + 1.0) / q
    gas, balance = _balance(setting._replace(theta=0.0), exponent)
    energies = balance.energies(theta)
    hard = balance.through(theta, energies, 0.0, HARD)
    mean = hard.ratio
    loss, gain = balance.collision(mean).tolist()
    springs, ratios = stored(contact, mean, dimension), (theta, mean)
    if abs(mean - theta) < APART:
        ratios = theta, theta + APART
    turned = turned_at(contact, ratios[0], dimension), turned_at(contact, ratios[1], dimension)
    pressed = pressed_at(contact, ratios[0], dimension), pressed_at(contact, ratios[1], dimension)
    # The energy in tangential springs comes from both motions, in proportion to their shares of g_t².
    share = mean / (ball.inertia_factor + mean)
    tangential = springs.tangential / (springs.normal * q)
    late = delayed / exponent
    translation = (1.0 / q + (1.0 - share) * tangential + late * (loss - gain)) / dimension
    rotation = share * tangential / (axes * mean) if mean > 0.0 else 0.0

    def slower(changes: Changes) -> float:
        duration = balance.through(theta, energies, SMALL, changes).duration
        return (duration / hard.duration - 1.0) / (SMALL * hard.root)

    epsilon = float(contact.restitution(IMPACT_SPEED))
    offset, beta = math.nan, contact.effective_tangential_restitution(IMPACT_SPEED, dimension=dimension)
    if beta <= 1.0:  # not NaN, nor that of contacts that gain energy
        rule = Balance(gas.rotating(epsilon, setting.friction.coefficient, beta), exponent)
        offset = hard.duration / rule.through(theta, energies, 0.0, HARD).duration - 1.0
    return CoefficientTerms(
        energy=slower(Changes(translation=-translation, rotation=-rotation)),
        turn=slower(Changes(ratios=ratios, turned=turned)),
        pressure=slower(Changes(ratios=ratios, turned=pressed)),
        spring=springs.tangential / -loss,
        temperature_ratio=mean,
        offset=offset,
        smooth_error=(1.0 - epsilon**2) / (gain - loss) - 1.0,
    )


class HeatedTerms(NamedTuple):
    """What friction makes of the temperature of a gas heated by white noise on its velocities; made by
    :func:`heated_terms`. Relative changes of the loss under Newton's equations, with those by the ratio θ that rotation
    then takes."""

    turn: float  #: by the turn of contacts, in w/d
    pressure: float  #: by the pressure of neighbours, in s w/d
    spring: float  #: by third particles, in t_c ν and their share of springs
    energy: float  #: change of ln(T of hard spheres/T) by the energy in contacts, in t_c ν


def heated_state(setting: Setting, exponent: float) -> tuple[Balance, float] | None:
    """The balance of a gas heated by white noise on its velocities, arguments as for :class:`Balance`, and its θ; None
    if rotation has no steady state."""
    from scipy.optimize import brentq

    _, balance = _balance(setting._replace(theta=0.0), exponent)

    def gain(theta: float) -> float:
        return float(balance.collision(theta)[1])

    if not gain(RATIOS[0]) > 0.0 > gain(RATIOS[-1]):
        return None
    return balance, float(brentq(gain, RATIOS[0], RATIOS[-1], xtol=1e-12))


@lru_cache(maxsize=512)
def heated_terms(setting: Setting, q: float, c: float, delayed: float) -> HeatedTerms | None:
    """The terms of equal grains with friction, arguments as for :func:`terms`; None if rotation has no steady state.

    Rotation gains in collisions as much as it loses, so that θ follows each change of the gain. A third particle that
    ends a contact takes from rotation what it would still have gained on average.
    """
    contact, dimension = setting.contact(), setting.dimension
    exponent = 1.0 + (c + 1.0) / q
    state = heated_state(setting, exponent)
    if state is None:
        return None
    balance, theta = state
    loss = -float(balance.collision(theta)[0])
    slopes = balance.collision(theta + SLOPE) - balance.collision(theta)
    # Where the gain falls by a share of the loss, θ falls, and the loss changes by this times the share.
    moved = -float(slopes[0] / slopes[1])
    turned, pressed = turned_at(contact, theta, dimension), pressed_at(contact, theta, dimension)
    springs = stored(contact, theta, dimension)
    ratio = contact.ball.inertia_factor
    tangential = springs.tangential / (springs.normal * q) * ratio / (ratio + theta)
    x = 1.0 - float(contact.restitution(IMPACT_SPEED)) ** 2
    # Stored: (1 − x/2)(1/q + tangential)/D, of which the loss at equal T has (1/q + tangential − b loss/exponent)/D.
    kept = (delayed / exponent - 0.5) * loss - 0.5 * x * (1.0 / q + tangential)
    return HeatedTerms(
        turn=turned.loss + moved * turned.exchange,
        pressure=pressed.loss + moved * pressed.exchange,
        spring=(springs.tangential + moved * springs.rotation) / loss,
        energy=kept / dimension,
    )
