"""Steady simple shear of hard spheres by the balance of all second moments of their velocities, for any β(tan γ).

Velocities are Gaussian with any second moments ⟨c c⟩, spins with one temperature about a mean along the vorticity, and
pairs that touch are uncorrelated but for Enskog's χ; their relative velocity is also that of the flow across a
diameter. Nothing is expanded in the shear rate. Shear stress, normal stresses, dissipation, spins and temperature are
those at which collisions keep ⟨c c⟩, the mean spin and the rotational energy as they are. Jenkins & Richman,
J. Fluid Mech. 192, 313 (1988), have this theory for smooth disks; here are spheres.

Units: diameter, mass and shear rate 1; the flow is y along x.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np

from .box import Floats

#: Nodes of the quadratures: heights and angles of the normal, approach speeds, sizes and angles of the tangential part.
#: More of them change T by less than 0.3 % and θ by less than 0.002.
HEIGHTS, ANGLES, SPEEDS, SIZES, DIRECTIONS = 4, 6, 12, 8, 6
FASTEST: Final = 6.0  #: approach speed, in standard deviations above the mean
PRECISION: Final = 1e-9
FAR: Final = 1e3  #: what the balance of impossible velocities counts as
#: n d³ χ below which T goes as 1/n² and all ratios keep still, to this order; the mean spin is lost in rounding there.
THIN: Final = 2e-5
GRADIENT: Final = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])  #: u = GRADIENT · r


class Rule(NamedTuple):
    """Hard spheres."""

    restitution: float
    grip: Callable[[Floats], Floats]  #: 1 + β at each tan γ
    inertia_factor: float


class State(NamedTuple):
    """The steady state."""

    temperature: float
    temperature_ratio: float  #: NaN for smooth spheres
    spin: float  #: mean of ω_z; −1/2 turns with the flow
    pressure: Floats  #: pressure tensor over the number density


class Moments(NamedTuple):
    """Moments of velocities and spins."""

    velocity: Floats  #: ⟨c c⟩
    rotation: float  #: T_r
    spin: float

    @property
    def temperature(self) -> float:
        return float(np.trace(self.velocity)) / 3.0


class Rates(NamedTuple):
    """What collisions do to a grain in unit time."""

    velocity: Floats  #: change of ⟨c c⟩
    rotation: float  #: change of I ⟨(ω − ω̄)²⟩/m
    rotation_gain: float  #: the part of it that does not depend on ω − ω̄
    spin: float  #: change of the spin
    virial: Floats  #: half of Σ J d, the pressure tensor of collisions over the number density
    grip: float  #: half of Σ (1 + β)


class Touching(NamedTuple):
    """Pairs that touch, over the nodes of the normal, the speed of approach and the tangential velocity."""

    weight: Floats
    speed: Floats  #: of approach
    surface: Floats  #: tangential velocity of the surfaces
    velocity: Floats  #: mean relative peculiar velocity at this surface: along the normal and both tangents
    spins: Floats  #: mean part of the fluctuations of the spins in this surface


def steady(density: float, rule: Rule, loss: float, theta: float) -> State:
    """The state. ``density``: n d³ χ. ``loss``: of a collision in m T, ``theta``: near that of the state; for a start.

    Raises ArithmeticError if none is found.
    """
    from scipy import optimize

    if density < THIN:
        state, thinner = steady(THIN, rule, loss, theta), THIN / density
        hotter = thinner * thinner
        return state._replace(temperature=hotter * state.temperature, pressure=hotter * state.pressure)
    # Work 2 η of a thin and of a dense gas, ν of rest; less where the flow across a diameter makes impacts faster.
    slow = (0.09 / density**2 + 0.3) / loss
    near = slow**2 / (slow + 0.5)
    at_start = collisions(density, rule, Moments(near * np.eye(3), theta * near, -0.5))
    rubbing = at_start.grip > 0.0

    def moments_of(values: Floats) -> Moments:
        x, y, shear = values[1:4].tolist()
        t = math.exp(values[0])
        velocity = t * np.array([[1.0 + x, -shear, 0.0], [-shear, 1.0 + y, 0.0], [0.0, 0.0, 1.0 - x - y]])
        return Moments(velocity, *((t * math.exp(values[4]), float(values[5])) if rubbing else (0.0, -0.5)))

    def balance(values: Floats) -> Floats:
        try:
            moments = moments_of(values)
            np.linalg.cholesky(moments.velocity)
            rates = collisions(density, rule, moments, rubbing)
            spins = (rates.rotation / rates.rotation_gain, rates.spin / rates.grip) if rubbing else ()
        except (np.linalg.LinAlgError, ArithmeticError):  # no such velocities
            return np.full(len(values), FAR)
        t, flow = moments.temperature, GRADIENT @ moments.velocity
        change = (rates.velocity - flow - flow.T) / (density * t**1.5)
        return np.array([change[0, 0], change[1, 1], change[2, 2], change[0, 1], *spins])

    start = np.array([math.log(near), 0.1, -0.05, 0.3, *((math.log(theta), -0.5) if rubbing else ())])
    root = optimize.root(balance, start, method="hybr", options={"xtol": PRECISION})
    if not root.success:
        raise ArithmeticError("no steady state was found")
    moments = moments_of(root.x)
    t = moments.temperature
    pressure = moments.velocity + collisions(density, rule, moments, rubbing).virial
    return State(t, float(moments.rotation / t) if rubbing else math.nan, moments.spin, pressure)


def collisions(density: float, rule: Rule, moments: Moments, rubbing: bool = True) -> Rates:
    """By product quadratures over the normal, the speed of approach and the tangential velocity of the surfaces.

    An impulse depends on no more than these, so that velocities and spins enter by their means at given ones.
    """
    frames, _ = _normals()
    pairs, q = _touching(moments, rule.inertia_factor, rubbing), rule.inertia_factor
    grip = rule.grip(np.linalg.norm(pairs.surface, axis=3) / pairs.speed[:, :, None])
    impulse = np.empty((*grip.shape, 3))  # on the second grain, over its mass
    impulse[..., 0] = 0.5 * (1.0 + rule.restitution) * pairs.speed[:, :, None]
    impulse[..., 1:] = (-0.5 / (1.0 + 1.0 / q) * grip)[..., None] * pairs.surface

    def total(values: Floats) -> float:
        return 2.0 * math.pi * density * float(np.sum(pairs.weight * values))

    def tensor(of_frames: Floats) -> Floats:
        """Of the means in each frame; the mirror image of the flow cancels components with one z."""
        whole: Floats = 2.0 * math.pi * density * np.einsum("kai,kab,kbj->ij", frames, of_frames, frames)
        whole[2, :2] = whole[:2, 2] = 0.0
        return whole

    weighted = pairs.weight[..., None] * impulse
    first = np.einsum("kgza,kgzb->kab", weighted, pairs.velocity)
    second = np.einsum("kgza,kgzb->kab", weighted, impulse)
    mean = weighted.sum(axis=(1, 2))
    transferred = np.zeros_like(first)
    transferred[:, :, 0] = mean  # times the normal
    gain = 2.0 / q * total(np.sum(impulse[..., 1:] ** 2, axis=3))
    by_spins = total(np.einsum("kgza,kza->kgz", impulse[..., 1:], pairs.spins))
    torque = np.cross(frames[:, 0], np.einsum("ka,kai->ki", mean[:, 1:], frames[:, 1:]))[:, 2]
    # Both grains change by as much; of their velocities only the relative one does, by twice the impulse.
    return Rates(
        velocity=tensor(first + first.transpose(0, 2, 1) + 2.0 * second),
        rotation=2.0 * by_spins + gain,
        rotation_gain=gain,
        spin=-4.0 / q * 2.0 * math.pi * density * float(torque.sum()),
        virial=tensor(transferred),
        grip=total(grip),
    )


def _touching(moments: Moments, q: float, rubbing: bool) -> Touching:
    frames, share = _normals()  # normal, two tangents
    nodes, speed_weights, turned, turned_weights = _motions(rubbing)
    covariance = 2.0 * frames @ moments.velocity @ frames.transpose(0, 2, 1)  # of the relative velocity c
    flow = np.einsum("kai,ij,kj->ka", frames, GRADIENT, frames[:, 0])
    turning = moments.spin * np.cross(np.array([0.0, 0.0, 1.0]), frames[:, 0])
    drift = flow[:, 1:] - np.einsum("kai,ki->ka", frames[:, 1:], turning)  # of the surfaces

    deviation = np.sqrt(covariance[:, 0, 0])
    fastest = np.maximum(FASTEST * deviation - flow[:, 0], FASTEST * deviation)
    speed = fastest[:, None] * nodes
    along = -speed - flow[:, :1]  # c along the normal
    gauss = np.exp(-0.5 * (along / deviation[:, None]) ** 2) / (math.sqrt(2.0 * math.pi) * deviation[:, None])
    weight = (share[:, None] * fastest[:, None] * speed_weights * speed * gauss)[:, :, None] * turned_weights

    slope = covariance[:, 1:, 0] / covariance[:, :1, 0]
    rest = covariance[:, 1:, 1:] - slope[:, :, None] * covariance[:, None, 0, 1:]  # of c at this speed
    of_spins = 2.0 * moments.rotation / q
    both = rest + of_spins * np.eye(2)
    further = np.einsum("kab,zb->kza", np.linalg.cholesky(both), turned)  # by chance
    spins = of_spins * np.einsum(
        "kab,kzb->kza", np.linalg.inv(both), further
    )  # not by a difference: θ may be tiny
    carried = slope[:, None, :] * along[:, :, None]
    velocity = np.empty((*weight.shape, 3))
    velocity[..., 0] = along[:, :, None]
    velocity[..., 1:] = carried[:, :, None, :] + (further - spins)[:, None]
    surface = (drift[:, None, :] + carried)[:, :, None, :] + further[:, None]
    return Touching(weight, speed, surface, velocity, spins)


@lru_cache(maxsize=1)
def _normals() -> tuple[Floats, Floats]:
    """Frames of normal and tangents over a quarter of the sphere, of which the others are images, and their shares."""
    height, of_height = np.polynomial.legendre.leggauss(HEIGHTS)
    z = np.repeat(0.5 + 0.5 * height, ANGLES)
    angle = np.tile(math.pi * (np.arange(ANGLES) + 0.5) / ANGLES, HEIGHTS)
    flat, cos, sin = np.sqrt(1.0 - z * z), np.cos(angle), np.sin(angle)
    rows = [[flat * cos, flat * sin, z], [z * cos, z * sin, -flat], [-sin, cos, np.zeros_like(z)]]
    return np.array(rows).transpose(2, 0, 1), np.repeat(0.5 * of_height / ANGLES, ANGLES)


@lru_cache(maxsize=2)
def _motions(rubbing: bool) -> tuple[Floats, Floats, Floats, Floats]:
    """Nodes in [0, 1] for the speed and their weights; pairs of standard normal numbers and their weights.

    Impulses of smooth spheres are along the normal, so that the mean of the tangential part is enough.
    """
    node, of_node = np.polynomial.legendre.leggauss(SPEEDS)
    if not rubbing:
        return 0.5 + 0.5 * node, 0.5 * of_node, np.zeros((1, 2)), np.ones(1)
    half_square, of_square = np.polynomial.laguerre.laggauss(SIZES)
    angle = 2.0 * math.pi * np.arange(DIRECTIONS) / DIRECTIONS
    size = np.repeat(np.sqrt(2.0 * half_square), DIRECTIONS)
    angles = np.tile(angle, SIZES)
    numbers = np.stack([size * np.cos(angles), size * np.sin(angles)], axis=1)
    return 0.5 + 0.5 * node, 0.5 * of_node, numbers, np.repeat(of_square / DIRECTIONS, DIRECTIONS)
