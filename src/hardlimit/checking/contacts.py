"""Compute one contact at one impact speed: restitution, duration, steps, overlap, error of event-driven cooling.

A radius, a mass or a speed may be unknown. A result is then computed for several trial values, and kept if all agree.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any, Final, NamedTuple

import scipy

from ..boxes.error_law import KNOWN_RULES, MEASURED_TC_NU
from ..boxes.rules import DEFAULTS, RULES
from ..boxes.theory import Gas
from ..boxes.time_step import DEFAULT_ERROR
from ..contact import frictional_contact
from ..convert.force import AdhesiveForce, Collision, Force, Powers
from . import friction
from .expectation import (
    ACCEPTED,
    Expected,
    expected,
    expected_rubbing,
    extrapolated,
    knows_driven,
    rubbing,
    smooth_error,
)
from .friction import SMOOTH, SMOOTH_LAW, SPHERE, CheckedFriction, FrictionLaw

#: Values tried for an unknown radius, mass and speed, far apart: a contact may be overdamped at two of them only.
TRIALS: Final = {
    "radius": (1e-3, 3e-3, 1.0, 1e-6),
    "mass": (1e-6, 5e-6, 1e30, 1e-30),
    "speed": (1.0, 0.3, 30.0, 1e-4),
}
FIXED_POINT_STEPS: Final = 20  #: of the largest t_c ν
COMPRESSED: Final = 0.05  #: largest overlap over the radius that contact laws describe
AGREEMENT: Final = 1e-6  #: relative difference of results that count as equal
SHOWN: Final = 0.02  #: difference of β in other versions that counts as none


@dataclass(frozen=True)
class Body:
    """A grain in a contact. Its mass is infinite if it does not move; radius and mass are None if unknown."""

    radius: float | None
    mass: float | None
    density: float | None = None
    fixed: bool = False  #: whether it does not move although its mass is finite in the code's formulas
    inertia_factor: float = SPHERE  #: q of the moment of inertia q m R²; infinite if it does not spin

    def tried(self, k: int) -> KnownBody:
        """The body, with trial values in place of unknown ones."""
        radius = TRIALS["radius"][k] if self.radius is None else self.radius
        mass = TRIALS["mass"][k] if self.mass is None else self.mass
        moved, counted = (math.inf, mass) if self.fixed else (mass, None)
        return KnownBody(radius, moved, counted, self.inertia_factor)


class KnownBody(NamedTuple):
    """Radius and mass of a body, known or tried."""

    radius: float
    mass: float
    formula_mass: float | None = None  #: in the code's formulas, if it is another one
    inertia_factor: float = SPHERE


@dataclass(frozen=True)
class Surroundings:
    """What is known of the gas in which the contacts take place."""

    dimension: int = 3
    packing_fraction: float | None = None
    #: Mean impact speed √(πT) and mean diameter, if measured in a dump; else those of each contact.
    mean_speed: float | None = None
    diameter: float | None = None
    quantity: str = "cooling"  #: that the gas is judged by: a field of ``Expected``
    #: Error of the temperature over that at equal heating power, at a mean impact speed; None: no bath.
    heat_share: Callable[[float], float] | None = None
    #: Error of the temperature of a heated gas, or of the stress of a sheared one, by leaving friction out, at a mean
    #: impact speed; None: not driven.
    without_friction: Callable[[float], float | None] | None = None
    heats_spins: bool = False  #: whether a thermostat acts on spins, too
    restitution_error: float = DEFAULT_ERROR  #: that a time step may cause
    frictions: tuple[float | None, ...] = (
        0.0,
    )  #: coefficients of friction between its grains; None: not known
    inertia_factors: tuple[float, ...] = ()  #: of its grains

    def collision_rate(self, speed: float, diameter: float) -> float:
        """Enskog's collision rate of one grain, where ``speed`` is the mean impact speed √(πT)."""
        assert self.packing_fraction is not None
        radius = 0.5 * diameter
        ball = math.pi * radius**2 if self.dimension == 2 else 4.0 / 3.0 * math.pi * radius**3
        gas = Gas(1, radius, 1.0, ball / self.packing_fraction, self.dimension)
        return float(gas.collision_rate(speed * speed / math.pi))


#: The force between two bodies, the second of which is None at a wall, at an impact speed.
MakeForce = Callable[[KnownBody, KnownBody | None, float], Force]
#: Two bodies, the second None at a wall, and a speed [m/s].
Trial = tuple[KnownBody, KnownBody | None, float]


@dataclass(frozen=True)
class Case:
    """The contacts of two types of grains, or of a type and a wall, at one end of their sizes."""

    types: tuple[str, str]
    stage: int
    wall: str | None  #: name of the wall
    first: Body
    second: Body | None  #: None at a wall
    force: MakeForce | None  #: None if no model of normal contacts describes it
    model: str | None = None
    restitution_asked: float | None = None
    clipped: bool | None = None
    time_step: float | None = None
    numerical_damping: float | None = None
    #: Young's modulus and Poisson's ratio of each body.
    materials: tuple[tuple[float, float] | None, ...] = (None, None)
    #: Number that sets the stiffness, its value in the units of the script, and the power with which it does.
    spring: tuple[str, float, float] | None = None
    #: The force before versions of the code that changed it.
    others: tuple[tuple[str, MakeForce], ...] = ()
    friction: FrictionLaw = SMOOTH_LAW
    #: Powers of mass, length and time in the unit of the number that sets the stiffness.
    spring_powers: tuple[float, float, float] | None = None
    repulsion: MakeForce | None = None  #: the force of an adhesive contact without its adhesion


class OtherVersion(NamedTuple):
    """A contact in older versions of its code; returned by :func:`hardlimit.check`. None: not known."""

    before: str  #: the version that changed the force
    restitution: float | None  #: ε before it
    duration: float | None  #: [s]


#: The error of cooling and its error bar, by rule of collision.
Errors = Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class CheckedContact:
    """A contact at one impact speed; returned by :func:`hardlimit.check`. None stands for what is not known."""

    types: tuple[str, str]  #: the second is ``"wall"`` at a wall
    stage: int  #: number of the run in the script, from 1
    wall: str | None  #: name of the wall
    model: str | None  #: as in :func:`hardlimit.convert`
    radius: float | None  #: [m]
    other_radius: float | None  #: [m]; None at a wall
    density: float | None  #: of the first body [kg/m³]
    restitution_asked: float | None  #: ε in the script
    clipped: bool | None  #: whether the force never attracts
    speed: float | None  #: impact speed [m/s]
    adhesive: bool = False  #: whether the bodies attract each other beside the damping
    restitution: float | None = None  #: ε that the code really gives
    duration: float | None = None  #: [s]
    steps_per_contact: int | None = None  #: whole time steps in a contact
    restitution_error_of_step: float | None = None  #: error of ε by the time step
    time_step: float | None = None  #: [s], with the error of ε that is accepted, by default 0.001
    rayleigh_time: float | None = None  #: πR√(ρ/G)/(0.1631 ν + 0.8766) [s], G = Y/(2 + 2ν); the shorter
    p_wave_time: float | None = None  #: R√(ρ/Y) [s]; the shorter of both grains
    largest_overlap: float | None = None  #: over the smaller radius
    tc_nu: float | None = None  #: duration times collision rate of a grain
    delta_over_d: float | None = None  #: greatest overlap at the mean impact speed, over the diameter
    error: Errors = field(default_factory=dict)  #: of event-driven cooling
    rule: str = "constant"  #: of the event-driven grains: "law" with friction or if ε depends on the speed
    heated_error: float | None = None  #: of the temperature of an event-driven gas at equal heating
    heated_error_bar: float | None = None  #: its standard error
    sheared_error: float | None = None  #: of the shear stress of event-driven spheres at equal shear rate
    sheared_error_bar: float | None = None  #: its standard error
    friction: CheckedFriction = SMOOTH  #: that of the event-driven grains, too
    frictionless_error: float | None = None  #: of the quantity asked for, of grains without friction
    smooth_error: float | None = None  #: of the quantity asked for without the friction, in theory
    temperature_ratio: float | None = None  #: T_r/T of a heated gas with friction, in theory
    extrapolated: str = ""  #: how the friction is outside what was measured for the error, in words
    softening: float | None = None  #: factor of the stiffness at an error of 1 %, with its bar
    softened_overlap: float | None = None  #: largest overlap over the smaller radius after this change
    spring: tuple[str, float, float] | None = None  #: name of the stiffness, value, value after this change
    other_versions: tuple[OtherVersion, ...] = ()  #: of the code, if the script does not state its version
    stiffness_unit: str = ""  #: in which these values are; empty in lj units


def examine(case: Case, speeds: Sequence[float | None], gas: Surroundings) -> list[CheckedContact]:
    """The contact at each speed, None if no speed is known; one without a speed if nothing depends on it."""
    rows = [_at(case, speed, gas) for speed in speeds]
    if rows[0].largest_overlap is None and list(speeds) != [None]:  # known, it depends on the speed
        anywhere = _at(case, None, gas)
        if all(replace(row, speed=None) == anywhere for row in rows):
            return [anywhere]
    return rows


def _at(case: Case, speed: float | None, gas: Surroundings) -> CheckedContact:
    row = CheckedContact(
        types=case.types,
        stage=case.stage,
        wall=case.wall,
        model=case.model,
        radius=case.first.radius,
        other_radius=None if case.second is None else case.second.radius,
        density=case.first.density,
        restitution_asked=case.restitution_asked,
        clipped=case.clipped,
        speed=speed,
        friction=friction.friction_of(case.friction, {}),
    )
    if case.force is None:
        return row
    tried = _trials(case, speed)
    results = [_results(case, *trial, gas) for trial in tried]
    kept: dict[str, Any] = {name: _agreed([result.get(name) for result in results]) for name in results[0]}
    errors = {str(rule): (kept.pop(rule), kept.pop(f"{rule}±")) for rule in KNOWN_RULES if rule in kept}
    if (steps := kept.get("steps_per_contact")) is not None:
        kept["steps_per_contact"] = math.floor(steps)
    if kept["largest_overlap"] is None:
        kept["softened_overlap"] = None
    if case.spring is not None and kept.get("softening") is not None:
        name, value, power = case.spring
        kept["spring"] = name, value, value * kept["softening"] ** (1.0 / power)
    rubbing = [_friction(case, *trial, gas.dimension) for trial in tried]
    kept["friction"] = friction.friction_of(
        case.friction,
        {
            name: _agreed(
                [result.get(name) for result in rubbing], SHOWN if name.startswith("other") else 0.0
            )
            for name in rubbing[0]
        },
    )
    kept["other_versions"] = tuple(_other_version(case, *version, tried) for version in case.others)
    return replace(row, **kept, error={rule: pair for rule, pair in errors.items() if None not in pair})


def _trials(case: Case, speed: float | None) -> list[Trial]:
    """Bodies and speed; several where something of them is not known."""
    bodies = (case.first, case.second or case.first)
    known = speed is not None and all(body.radius is not None and body.mass is not None for body in bodies)
    return [
        (
            case.first.tried(k),
            None if case.second is None else case.second.tried(k),
            TRIALS["speed"][k] if speed is None else speed,
        )
        for k in range(1 if known else len(TRIALS["speed"]))
    ]


def restitution(case: Case, speed: float | None) -> float | None:
    """ε at this speed; None if it depends on something that is not known."""
    force, damping = case.force, case.numerical_damping
    if force is None:
        return None
    epsilon: float | None = _agreed(
        [collision_of(force(*trial), trial[2], damping).restitution for trial in _trials(case, speed)]
    )
    return epsilon


def _friction(
    case: Case, first: KnownBody, second: KnownBody | None, speed: float, dimension: int
) -> dict[str, Any]:
    """All results of the friction of known bodies at a known speed."""
    assert case.force is not None
    force, law = case.force(first, second, speed), case.friction
    if law.coefficient == 0.0 or isinstance(force, AdhesiveForce):
        return {}
    results: dict[str, Any] = {f"other {when}": beta(first, second, speed) for when, beta in law.others}
    if law.terms is not None:
        contact = friction.contact_of(law.terms, force, (first, second), speed)
        results |= friction.numbers(contact, force, speed, case.time_step, dimension)
    return results


def _other_version(case: Case, before: str, make: MakeForce, tried: Sequence[Trial]) -> OtherVersion:
    collisions = [collision_of(make(*trial), trial[2], case.numerical_damping) for trial in tried]
    return OtherVersion(
        before, _agreed([c.restitution for c in collisions]), _agreed([c.duration for c in collisions])
    )


def _agreed(values: Sequence[Any], tolerance: float = 0.0) -> Any:
    """The common value; None if the values differ or one of them is missing or infinite."""
    if isinstance(values[0], str):
        return values[0]
    known = [value for value in values if value is not None and math.isfinite(value)]
    if len(known) < len(values):
        return None
    absolute = max(tolerance, 1e-12)
    close = all(math.isclose(value, known[0], rel_tol=AGREEMENT, abs_tol=absolute) for value in known)
    return known[0] if close else None


def _results(
    case: Case, first: KnownBody, second: KnownBody | None, speed: float, gas: Surroundings
) -> dict[str, Any]:
    """All results for known bodies and a known speed."""
    assert case.force is not None
    force = case.force(first, second, speed)
    collision = collision_of(force, speed, case.numerical_damping)
    smaller = first.radius if second is None else min(first.radius, second.radius)
    results: dict[str, Any] = {
        "rule": usual_rule(force),
        "adhesive": isinstance(force, AdhesiveForce),
        "restitution": collision.restitution,
        "duration": collision.duration,
        "time_step": force.longest_step(speed, gas.restitution_error),
        "largest_overlap": collision.compression / smaller,
    }
    waves = [
        _wave_times(body, material)
        for body, material in zip((first, second), case.materials, strict=True)
        if body is not None and material is not None and math.isfinite(body.mass)
    ]
    if waves:
        results["p_wave_time"], results["rayleigh_time"] = map(min, zip(*waves, strict=True))
    if case.time_step is not None:
        results["steps_per_contact"] = (
            collision.duration / case.time_step if math.isfinite(collision.duration) else None
        )
        results["restitution_error_of_step"] = force.error_of_step(speed, case.time_step)
    results |= _in_gas(
        case=case, force=force, first=first, second=second, speed=speed, gas=gas, collision=collision
    )
    if softening := results.get("softening"):  # at one speed, overlaps are in proportion to durations
        power = 1.0 / (0.25 * force.powers.elastic + 1.0)
        results["softened_overlap"] = results["largest_overlap"] * softening**-power
    return results


def _wave_times(body: KnownBody, material: tuple[float, float]) -> tuple[float, float]:
    """Times of the P wave and of the Rayleigh wave in a grain of this Young's modulus and Poisson's ratio."""
    modulus, nu = material
    wave = body.radius * math.sqrt(body.mass / (4.0 / 3.0 * math.pi * body.radius**3) / modulus)
    return wave, math.pi * wave * math.sqrt(2.0 + 2.0 * nu) / (0.1631 * nu + 0.8766)


def _in_gas(
    case: Case,
    force: Force,
    first: KnownBody,
    second: KnownBody | None,
    speed: float,
    gas: Surroundings,
    collision: Collision,
) -> dict[str, Any]:
    """δ/d, t_c ν and the error of event-driven cooling."""
    diameter = first.radius + (first.radius if second is None else second.radius)
    mean = collision
    if gas.mean_speed is not None:
        force = case.force(first, second, gas.mean_speed) if case.force else force
        mean = collision_of(force, gas.mean_speed, case.numerical_damping)
    numbers: dict[str, Any] = {"delta_over_d": mean.compression / diameter}
    if gas.packing_fraction is None or not math.isfinite(mean.duration):
        return numbers
    rate = gas.collision_rate(gas.mean_speed or speed, gas.diameter or diameter)
    tc_nu = numbers["tc_nu"] = mean.duration * rate
    if second is None or isinstance(force, AdhesiveForce):
        return numbers
    exponent = 0.25 * force.powers.elastic + 1.0
    clipped = replace(force, powers=replace(force.powers, attracts=False))
    prolonged = 1.0 - clipped.collision(gas.mean_speed or speed).duration / mean.duration
    # It is the law of equal grains: others have another collision rate, by about the ratio of their radii.
    radii = first.radius, second.radius
    unequal = min(max(radii) / min(radii) - 1.0, 1.0)
    wider = math.hypot(prolonged, unequal)

    def with_bar(rule: str, tc_nu: float) -> Expected | None:
        assert gas.packing_fraction is not None
        prediction = expected(
            rule, gas.dimension, gas.packing_fraction, mean.restitution, force.powers, tc_nu
        )
        # Measured for forces that never attract; attraction prolongs the contact.
        return prediction and _in_bath(prediction, gas, speed).wider(wider)

    usual = usual_rule(force)
    known = with_bar(usual, tc_nu)
    if case.friction.coefficient != 0.0 or any(mu != 0.0 for mu in gas.frictions):
        decisive = None if known is None else getattr(known, gas.quantity)
        numbers["frictionless_error"] = None if decisive is None else decisive[0]
        return numbers | _with_friction(case, force, (first, second), speed, gas, mean, tc_nu, wider)
    for rule in KNOWN_RULES:
        if RULES[rule].has_constant_restitution and usual == DEFAULTS["law"]:
            continue  # its error has another cause as well, the ε that depends on the speed
        if (value := with_bar(rule, tc_nu)) is not None:
            numbers[rule], numbers[f"{rule}±"] = value.cooling
    if known is not None:
        numbers["heated_error"], numbers["heated_error_bar"] = known.temperature or (None, None)
        numbers["sheared_error"], numbers["sheared_error_bar"] = known.stress or (None, None)
        largest = _largest_tc_nu(lambda x: getattr(with_bar(usual, x), gas.quantity))
        numbers["softening"] = None if largest is None else (tc_nu / largest) ** exponent
    return numbers


def _in_bath(prediction: Expected, gas: Surroundings, speed: float) -> Expected:
    """With the error of a temperature that a bath restores."""
    if prediction.temperature is None or gas.heat_share is None:
        return prediction
    share, (value, bar) = gas.heat_share(gas.mean_speed or speed), prediction.temperature
    return prediction._replace(temperature=(share * value, share * bar))


def _with_friction(
    case: Case,
    force: Force,
    bodies: tuple[KnownBody, KnownBody],
    speed: float,
    gas: Surroundings,
    mean: Collision,
    tc_nu: float,
    wider: float,
) -> dict[str, Any]:
    """The errors of event-driven simulation with the friction of the grains, if it and their inertia factors are the
    same; empty if not known.

    ``wider``: a further relative error.
    """
    law, phi, at = case.friction, gas.packing_fraction, gas.mean_speed or speed
    if not law.coefficient or law.terms is None or phi is None:
        return {}
    driven = gas.quantity != "cooling"
    if driven and (gas.heats_spins or not knows_driven(gas.dimension, force.powers)):
        return {}
    if len(gas.frictions) > 1 or len(gas.inertia_factors) > 1:  # not known of mixtures
        return {}
    own = frictional_contact.in_own_units(friction.contact_of(law.terms, force, bodies, at), at)
    depth = Force(force.powers, 1.0, own.coefficients[1], 1.0).collision(1.0).compression
    grains = rubbing(own.terms, friction.ratios(own, depth), bodies[0].inertia_factor)
    if grains is None:
        return {}
    state = gas.dimension, phi, mean.restitution, force.powers, grains

    def error(rule: str, x: float) -> Expected | None:
        prediction = expected_rubbing(rule, *state, x, sheared=gas.quantity == "stress")
        return prediction and _in_bath(prediction, gas, speed).wider(wider)

    known = error("law", tc_nu)
    if known is None:
        return {}
    numbers: dict[str, Any] = {}
    for rule in ("constant", "law") if usual_rule(force) == "constant" and not driven else ("law",):
        if (value := error(rule, tc_nu)) is not None:
            numbers[rule], numbers[f"{rule}±"] = value.cooling
    numbers["heated_error"], numbers["heated_error_bar"] = known.temperature or (None, None)
    numbers["sheared_error"], numbers["sheared_error_bar"] = known.stress or (None, None)
    largest = _largest_tc_nu(lambda x: getattr(error("law", x), gas.quantity, None))
    exponent = 0.25 * force.powers.elastic + 1.0
    softening = None if largest is None else (tc_nu / largest) ** exponent
    without = gas.without_friction(at) if gas.without_friction else None if driven else smooth_error(*state)
    said = {"smooth_error": without, "extrapolated": extrapolated(*state, gas.quantity)}
    return numbers | said | {"rule": "law", "softening": softening}


def _largest_tc_nu(error: Callable[[float], tuple[float, float] | None]) -> float | None:
    """t_c ν at which error and bar make 1 %, at most the largest measured; None if the error is not known.

    Both are nearly in proportion to t_c ν, so that a few steps of a fixed point suffice, unless the error changes its
    sign.
    """
    x = MEASURED_TC_NU
    for _ in range(FIXED_POINT_STEPS):
        if (value := error(x)) is None:
            return None
        size, before = abs(value[0]) + value[1], x
        x = MEASURED_TC_NU if size == 0.0 else min(x * ACCEPTED / size, MEASURED_TC_NU)
        if math.isclose(x, before, rel_tol=1e-12):
            return x
    low, high = 0.0, MEASURED_TC_NU
    while not math.isclose(low, high, rel_tol=1e-12):
        middle = 0.5 * (low + high)
        if not low < middle < high or (value := error(middle)) is None:
            break
        low, high = (middle, high) if abs(value[0]) + value[1] <= ACCEPTED else (low, middle)
    return low


def restitution_of(case: Case, speed: float) -> float:
    """ε of a contact whose bodies are known, at an impact speed."""
    assert case.force is not None
    second = None if case.second is None else case.second.tried(0)
    return collision_of(
        case.force(case.first.tried(0), second, speed), speed, case.numerical_damping
    ).restitution


def usual_rule(force: Force) -> str:
    """The rule for this force in an event-driven simulation: "law" if ε depends on the speed, else "constant"."""
    constant = 2 * force.powers.damping == force.powers.elastic - 4 and not isinstance(force, AdhesiveForce)
    return DEFAULTS["restitution" if constant else "law"]


def collision_of(force: Force, speed: float, damping: float | None) -> Collision:
    """The collision, with the numerical damping of the integrator if there is one."""
    if not damping:
        return force.collision(speed)
    collision = force.numerically_damped(speed, damping)
    lasts = collision.restitution == 0.0
    return replace(collision, duration=math.inf if lasts else _duration(force, damping, speed))


def _duration(force: Force, damping: float, speed: float) -> float:
    """Duration [s] with a numerical damping."""
    return force.scales(speed)[1] * _own_duration(force.powers, force.relative_damping(speed), damping)


@lru_cache(maxsize=1024)
def _own_duration(powers: Powers, c: float, damping: float) -> float:
    """Duration in units of the contact with a numerical damping d: the force counts 1 + d times while it decelerates,
    then 1 − d times."""
    p, q = 0.25 * powers.elastic, 0.25 * powers.damping

    def push(x: float, v: float) -> float:
        return float(max(x, 0.0) ** p + c * max(x, 0.0) ** q * v)

    def rates(_: float, y: Sequence[float]) -> list[float]:
        a = push(*y)
        return [y[1], -a * (1.0 + damping * math.copysign(1.0, a * y[1]))]

    def end(_: float, y: Sequence[float]) -> float:
        return float(y[0] if powers.attracts or y[1] > 0.0 else min(push(*y), y[0]))

    end.terminal, end.direction = True, -1.0  # type: ignore[attr-defined]
    done = scipy.integrate.solve_ivp(rates, (0.0, 1e4), [0.0, 1.0], events=end, rtol=1e-9, atol=1e-12)
    return float(done.t[-1]) if done.status == 1 else math.inf
