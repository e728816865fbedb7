"""Numbers of one contact with friction: where it sticks and slides, and which constant rule stands for it in a gas.

The normal direction is fixed, as in the hard limit. γ is the angle of impact, tan γ = tangential over normal speed of
the surfaces, and β = −(tangential speed after)/(before).
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np

from .. import _core
from . import impact, maxwellian
from .friction import LIMITS, FrictionTerms
from .impact import FrictionalContact

Floats = np.typing.NDArray[np.float64]

#: Angles [rad] at which β is tabulated; the first stands for the limit of head-on impacts.
ANGLES: Final = tuple(math.radians(angle) for angle in range(0, 90, 5))
#: tan γ/μ of this limit. A slip at the end of the contact changes β in proportion to it.
HEAD_ON: Final = 1e-6
#: Steps of a contact by which the angles are located, to about 2e-4.
STEPS: Final = 128
#: Share of the largest normal force below which sticking at the end is of no account.
NEGLIGIBLE: Final = 0.01
#: Range in which tan γ/μ is searched, the factor of the search, and the relative precision.
SMALLEST: Final = 1e-6
LARGEST: Final = 1e4
FARTHER: Final = 1.5
PRECISION: Final = 1e-5
#: Stiffest tangential spring whose changes of stick and slip are computed: half periods in a contact.
MOST_HALF_PERIODS: Final = 100.0
#: tan γ of a grazing impact.
GRAZING: Final = 1e5
#: Points of the quadrature over angles, in each of the three ranges of sticking, mixed and sliding contacts.
POINTS: Final = 16
#: More than the error of β0 by this quadrature. Superballs have 1, and no passive contact more.
QUADRATURE: Final = 1e-4
#: Digits to which contacts count as equal, so that they are computed once.
DIGITS: Final = 10


def in_own_units(contact: FrictionalContact, speed: float) -> FrictionalContact:
    """The contact in units in which K, the effective mass and the impact speed are 1, rounded."""
    (elastic, damped, _), (stiffness, damping) = contact.powers, contact.coefficients
    p, q, mass, terms = 0.25 * elastic, 0.25 * damped, contact.effective_mass, contact.terms
    length = (mass / stiffness * speed * speed) ** (1.0 / (p + 1.0))
    time = length / speed
    unit = time / mass  # of a damping
    spring = terms.stiffness * time * unit * length ** (0.25 * terms.stiffness_power)
    dashpot = terms.damping * unit * length ** (0.25 * terms.damping_power)
    return FrictionalContact(
        contact.powers,
        (1.0, _rounded(damping * unit * length**q)),
        1.0,
        _rounded(contact.tangential_mass / mass),
        terms._replace(stiffness=_rounded(spring), damping=_rounded(dashpot)),
    )


def borders(contact: FrictionalContact, speed: float) -> Borders:
    """The angles [rad] below which the contact sticks and beyond which it slides."""
    return _borders(in_own_units(contact, speed))


def tangential_restitution(contact: FrictionalContact, speed: float, angles: Floats) -> Floats:
    """β at each angle of impact [rad], 0 for the limit of head-on impacts."""
    smallest = HEAD_ON * min(contact.terms.coefficient, 1.0)
    return _restitution(contact, speed, np.maximum(np.tan(angles), smallest))


def of_tangents(own: FrictionalContact, tangents: Floats) -> Floats:
    """β at each tan γ > 0 of a contact in its own units; NaN where it is not resolved."""
    return _restitution(own, 1.0, tangents)


def table(contact: FrictionalContact, speed: float) -> tuple[tuple[float, float], ...]:
    """β at each of :data:`ANGLES`; empty if the bodies stay together."""
    return _table(in_own_units(contact, speed))


def effective_restitution(contact: FrictionalContact, speed: float, dimension: int) -> float:
    """β0 of the constant rule with the same ε and μ that stands for this contact in a gas; NaN if none does."""
    beta0 = _effective(in_own_units(contact, speed), dimension)
    return 1.0 if 1.0 < beta0 < 1.0 + QUADRATURE else beta0


def half_period(contact: FrictionalContact, speed: float) -> float:
    """Half period of the tangential spring at the deepest compression, over the duration; infinite without one."""
    own = in_own_units(contact, speed)
    _, duration, deepest, _ = _collision(own)
    stiffness = own.terms.stiffness * deepest ** (0.25 * own.terms.stiffness_power)
    return math.pi * math.sqrt(own.tangential_mass / stiffness) / duration if stiffness else math.inf


def is_too_stiff(own: FrictionalContact) -> bool:
    """Whether the tangential spring swings too often in a contact for where it sticks and slides to be computed."""
    return half_period(own, 1.0) * MOST_HALF_PERIODS < 1.0


class Borders(NamedTuple):
    """Angles of impact [rad]; NaN without a spring, with a far too stiff one, or if the bodies stay together."""

    sticks_below: float  #: below it, the surfaces do not slip while the bodies approach
    slides_beyond: float  #: beyond it, they do not stick while the bodies separate


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")


@lru_cache(maxsize=1024)
def _collision(own: FrictionalContact) -> tuple[float, float, float, float]:
    """ε, duration, largest compression and largest force."""
    return _core.power_collision(*own.powers, own.coefficients[1])


def _restitution(contact: FrictionalContact, speed: float, tangents: Floats) -> Floats:
    powers, coefficients, mass, tangential_mass, terms = contact
    return impact.tangential_restitution(
        powers, *coefficients, mass, terms, tangential_mass, speed, speed * tangents
    )


@lru_cache(maxsize=1024)
def _table(own: FrictionalContact) -> tuple[tuple[float, float], ...]:
    if not _collision(own)[0] > 0.0:
        return ()
    return tuple(zip(ANGLES, tangential_restitution(own, 1.0, np.array(ANGLES)).tolist(), strict=True))


# --- where it sticks and slides -------------------------------------------------------------------------------


class Motion(NamedTuple):
    """The normal motion of a contact in steps, shorter at both ends, and what it does to tangential forces."""

    steps: list[float]
    force: list[float]  #: F_n at each step
    limit: list[float]  #: |F_n|
    damping: list[float]  #: γ_t at each step
    kept: list[float]  #: what a step multiplies the elastic force by
    grown: list[float]  #: what a step adds to it at a unit slip rate
    deepest: int  #: number of the step
    negligible: float  #: F_n below which sticking is of no account


@lru_cache(maxsize=1024)
def _borders(own: FrictionalContact) -> Borders:
    """Both angles.

    Without slip the tangential force is in proportion to tan γ, so that it first reaches its limit at the smallest
    ratio of the two. For undamped linear contacts with ρ = k_t m_n/(k_n m_t) >= 1, that is tan γ = μ k_n/k_t, below
    which they stick first; the other angle is tan γ = μ (m_n/m_t) (2 − 1/ρ), beyond which they slip throughout. With
    damping the normal force jumps at touch, so that each contact sticks first; hence the whole approach is asked. For
    ρ < 1 both angles are at tan γ = μ (m_n/m_t)/(√ρ sin(π√ρ/2)).
    """
    mu = own.terms.coefficient
    if not (own.terms.stiffness > 0.0 and _collision(own)[0] > 0.0) or is_too_stiff(own):
        return Borders(math.nan, math.nan)
    if mu == 0.0 or mu == math.inf:
        return Borders(math.atan(mu), math.atan(mu))
    motion = _motion(own)
    sticks = _largest_sticking(own, motion)
    low = max(sticks, SMALLEST)
    high = low
    while _sticks_at_end(own, motion, high):
        low, high = high, FARTHER * high
        if high > LARGEST:
            return Borders(math.atan(mu * sticks), 0.5 * math.pi)
    while high > (1.0 + PRECISION) * low:
        middle = math.sqrt(low * high)
        low, high = (middle, high) if _sticks_at_end(own, motion, middle) else (low, middle)
    return Borders(math.atan(mu * sticks), math.atan(mu * high))


def _motion(own: FrictionalContact) -> Motion:
    _, duration, _, _ = _collision(own)
    elastic, damped, attracts = own.powers
    p, q, c, terms = 0.25 * elastic, 0.25 * damped, own.coefficients[1], own.terms
    share = np.arange(STEPS + 1) / STEPS
    steps = duration * np.diff(share * share * (3.0 - 2.0 * share))

    def force(x: float, v: float) -> float:
        depth = max(x, 0.0)
        push: float = depth**p + c * depth**q * v
        return push if attracts else max(push, 0.0)

    x, v = 0.0, 1.0
    depths, forces = [x], [force(x, v)]
    for h in np.repeat(0.5 * steps, 2).tolist():  # Runge & Kutta, at order 4
        a1 = force(x, v)
        a2 = force(x + 0.5 * h * v, v - 0.5 * h * a1)
        a3 = force(x + 0.5 * h * (v - 0.5 * h * a1), v - 0.5 * h * a2)
        a4 = force(x + h * (v - 0.5 * h * a2), v - h * a3)
        x += h * v - h * h / 6.0 * (a1 + a2 + a3)
        v -= h / 6.0 * (a1 + 2.0 * (a2 + a3) + a4)
        depths.append(max(x, 0.0))
        forces.append(force(x, v))
    kept, grown, damping = _changes(terms, np.array(depths), steps)
    return Motion(
        steps.tolist(),
        forces[::2],
        np.abs(forces[::2]).tolist(),
        damping.tolist(),
        kept.tolist(),
        grown.tolist(),
        int(np.argmax(depths[::2])),
        NEGLIGIBLE * max(forces),
    )


def _changes(terms: FrictionTerms, depths: Floats, steps: Floats) -> tuple[Floats, Floats, Floats]:
    """What each step multiplies the elastic force by, what it adds at a unit slip rate, and the damping."""
    before, middle, after = depths[:-2:2], depths[1:-1:2], depths[2::2]
    power = 0.5 * np.where(after > before, terms.loading, terms.unloading)
    with np.errstate(divide="ignore", invalid="ignore"):
        kept = np.where(before > 0.0, (after / before) ** power, 0.0)
        stiffness = terms.stiffness * middle ** (0.25 * terms.stiffness_power)
        grown = np.where(middle > 0.0, stiffness * steps * (after / middle) ** power, 0.0)
        damping = terms.damping * depths[::2] ** (0.25 * terms.damping_power)
    return kept, grown, np.where(np.isfinite(damping), damping, 0.0)


def _largest_sticking(own: FrictionalContact, motion: Motion) -> float:
    """tan γ/μ up to which the surfaces do not slip while the bodies approach, touch included."""
    total, over_mass = LIMITS[own.terms.limit] == "total", 0.5 / own.tangential_mass
    elastic, rate, ratio = 0.0, 1.0, math.inf
    for n in range(motion.deepest + 1):
        half = over_mass * motion.steps[n]
        limited = abs(elastic + motion.damping[n] * rate if total else elastic)
        if limited > 0.0:
            ratio = min(ratio, motion.limit[n] / limited)
        between = rate - half * (elastic + motion.damping[n] * rate)
        elastic = elastic * motion.kept[n] + motion.grown[n] * between
        rate = (between - half * elastic) / (1.0 + half * motion.damping[n + 1])
    return ratio


def _sticks_at_end(own: FrictionalContact, motion: Motion, tangent: float) -> bool:
    """Whether the surfaces stick at a time when the bodies separate, at tan γ = μ ``tangent``."""
    total, over_mass = LIMITS[own.terms.limit] == "total", 0.5 / own.tangential_mass
    elastic, rate = 0.0, tangent
    force = min(motion.damping[0] * rate, motion.limit[0])
    for n in range(STEPS):
        half = over_mass * motion.steps[n]
        between = rate - half * force
        elastic = elastic * motion.kept[n] + motion.grown[n] * between
        damped, limit = motion.damping[n + 1] * between, motion.limit[n + 1]
        force = elastic + damped
        limited = force if total else elastic
        if abs(limited) > limit:
            force = math.copysign(limit, limited)
            elastic = force - damped if total else force
        elif n >= motion.deepest and motion.force[n + 1] >= motion.negligible:
            return True
        rate = between - half * force
    return False


# --- in a gas -------------------------------------------------------------------------------------------------


@lru_cache(maxsize=1024)
def _effective(own: FrictionalContact, dimension: int) -> float:
    """β0 with which the constant rule changes the spins of an equilibrium as this contact does.

    Both normal and tangential velocities of the surfaces are those of equipartition, so that tan γ = √(κu/(1 − u)),
    κ = m_n/m_t, and g_t² u has the density 2u for spheres and 3√u/2 for disks. Equal is the mean of (1 + β) g_t², the
    angular momentum that is exchanged. Walton's rule slides beyond tan γ = K/(1 + β0), K = κμ(1 + ε). K is taken from
    the contact, (1 + β) tan γ of a grazing impact: the end of a force that attracts adds to it.
    """
    mu = own.terms.coefficient
    if not (_collision(own)[0] > 0.0 and mu > 0.0) or is_too_stiff(own):
        return math.nan
    kappa = 1.0 / own.tangential_mass
    u, weights = _shares(own, dimension)
    u = np.maximum(u, np.finfo(float).tiny)
    tangents = np.sqrt(kappa * u / np.maximum(1.0 - u, np.finfo(float).eps))
    if mu == math.inf:
        return float(weights @ _restitution(own, 1.0, tangents))
    grazing = GRAZING * max(mu, 1.0)
    if np.isnan(_restitution(own, 1.0, tangents[:1])).any():
        return math.nan  # at once, for each of the others would take all its steps
    *beta, last = _restitution(own, 1.0, np.append(tangents, grazing)).tolist()
    sliding = (1.0 + last) * grazing
    less = float(weights @ (sliding / tangents - 1.0 - np.array(beta)))  # than if all were sliding

    def excess(logarithm: float) -> float:
        return _less_than_sliding(math.exp(logarithm), sliding, kappa, dimension) - less

    from scipy import optimize  # which a drop must not wait for

    low, high = math.log(1e-9), math.log(1e3)
    if not (excess(low) > 0.0 > excess(high)):
        return math.nan
    return math.exp(optimize.brentq(excess, low, high, xtol=1e-10)) - 1.0


def _shares(own: FrictionalContact, dimension: int) -> tuple[Floats, Floats]:
    """Points u and their weights of a Gauss quadrature, split where contacts begin to slip and where they slide."""
    borders, root = _borders(own), math.sqrt(1.0 / own.tangential_mass)
    ends = [math.atan(math.tan(border) / root) for border in borders if 0.0 < border < 0.5 * math.pi]
    if not ends and own.terms.coefficient < math.inf:
        ends = [math.atan(2.0 * own.terms.coefficient * root)]
    edges = np.array([0.0, *ends, 0.5 * math.pi])
    nodes, weights = np.polynomial.legendre.leggauss(POINTS)
    half = 0.5 * np.diff(edges)[:, None]
    alpha = (half * (1.0 + nodes) + edges[:-1, None]).ravel()
    u = np.sin(alpha) ** 2
    return u, maxwellian.density(u, dimension) * np.sin(2.0 * alpha) * (half * weights).ravel()


def _less_than_sliding(one_plus_beta: float, sliding: float, kappa: float, dimension: int) -> float:
    """Mean of (1 + β) g_t² by which Walton's rule is below that of contacts that all slide."""
    stuck, slid = maxwellian.sticking_parts((sliding / one_plus_beta) ** 2 / kappa, dimension)
    return sliding / math.sqrt(kappa) * slid - one_plus_beta * stuck
