"""The friction of one contact of a check: its numbers, and the words for them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from .. import _core
from ..boxes.lammps import integration_error
from ..contact import frictional_contact
from ..contact.friction import LIMITS, FrictionTerms
from ..contact.frictional_contact import ANGLES
from ..contact.impact import FrictionalContact
from ..convert.force import Force, Powers
from ..support.formatting import digits

if TYPE_CHECKING:
    from .contacts import CheckedContact, KnownBody

#: Solid spheres: I = q m R².
SPHERE: Final = 2.0 / 5.0
#: The angle [rad] at which other versions of a code are compared.
OBLIQUE: Final = np.array(ANGLES[9:10])
#: Impacts at which the error of a time step is computed: tan γ over κμ, κ = m_n/m_t.
TESTED: Final = np.array([0.1, 0.5, 1.0, 1.5])
#: Stiffest tangential spring that is computed: half periods in a contact.
MOST_HALF_PERIODS: Final = 100.0
#: β near head-on above and below which sticking grains count as superballs and as smooth.
REVERSED, KEPT = 0.9, -0.9
#: Gain of tangential speed without slip that is told.
GAIN: Final = 1e-3
#: Difference [rad] below which two angles are one.
ONE_ANGLE: Final = math.radians(0.5)
#: Difference of β that makes another angle worth telling.
HIGHER: Final = 0.05


#: The terms of two bodies, the second of which is None at a wall, at a speed; and β at :data:`OBLIQUE`.
MakeTerms = Callable[[Any, Any, float], FrictionTerms]
MakeRestitution = Callable[[Any, Any, float], float]


class FrictionLaw(NamedTuple):
    """The friction of the contacts of two types."""

    coefficient: float | None = 0.0  #: of sliding friction; None if not known
    model: str | None = None  #: tangential model, as the script or our laws name it
    terms: MakeTerms | None = None  #: None if they are not known
    not_known: str | None = None  #: why
    others: tuple[tuple[str, MakeRestitution], ...] = ()  #: in other versions of the code


@dataclass(frozen=True)
class CheckedFriction:
    """The friction of a contact; returned by :func:`hardlimit.check`. None stands for what is not known."""

    coefficient: float | None = 0.0  #: μ of sliding friction; 0 for smooth grains
    model: str | None = None  #: tangential model, by its name in the script or in :class:`Friction`
    stiffness_ratio: float | None = (
        None  #: tangential over normal stiffness dF/dξ, at the largest compression
    )
    damping_ratio: float | None = None  #: tangential over normal damping, there
    limit: str | None = None  #: what μ F_n limits: "total" or "spring"
    sticks_below: float | None = None  #: angle of impact [rad] below which they do not slip on approach
    slides_beyond: float | None = None  #: angle [rad] beyond which they do not stick on separation
    tangential_restitution: tuple[tuple[float, float], ...] = ()  #: angle [rad] and β; 0 is the limit
    effective_tangential_restitution: float | None = None  #: β0 of the constant rule in a gas
    half_period: float | None = None  #: of the tangential spring, over the duration of the contact
    steps_per_half_period: int | None = None  #: whole time steps
    tangential_restitution_error_of_step: float | None = None  #: error of β by the time step
    not_known: str | None = None  #: why numbers are not known
    #: β at 45° in other versions of the code, after the words for these.
    other_versions: tuple[tuple[str, float], ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """As plain values.

        :meta private:
        """
        named = {name: getattr(self, name) for name in self.__dataclass_fields__}
        pairs = {
            name: [list(pair) for pair in named[name]]
            for name in ("tangential_restitution", "other_versions")
        }
        return {**named, **pairs}


#: Contacts without friction.
SMOOTH_LAW, SMOOTH = FrictionLaw(), CheckedFriction()
#: Names of the numbers of a contact that are results, but the table of β.
RESULTS: Final = (
    *("stiffness_ratio", "damping_ratio", "sticks_below", "slides_beyond"),
    *("effective_tangential_restitution", "half_period", "steps_per_half_period"),
    "tangential_restitution_error_of_step",
)


def contact_of(
    make: MakeTerms, force: Force, bodies: tuple[KnownBody, KnownBody | None], speed: float
) -> FrictionalContact:
    """The contact of two bodies, the second of which is None at a wall."""
    first, second = bodies
    inverse = _core.inverse_tangential_mass(
        first.mass,
        first.inertia_factor,
        math.inf if second is None else second.mass,
        SPHERE if second is None else second.inertia_factor,
    )
    coefficients, terms = (force.stiffness, force.damping), make(first, second, speed)
    return FrictionalContact(force.powers.arguments, coefficients, force.effective_mass, 1.0 / inverse, terms)


def numbers(
    contact: FrictionalContact, force: Force, speed: float, time_step: float | None, dimension: int
) -> dict[str, Any]:
    """All results, and β by the number of its angle."""
    own = frictional_contact.in_own_units(contact, speed)
    scaled = Force(force.powers, 1.0, own.coefficients[1], 1.0)
    collision = scaled.collision(1.0)
    results, half_period = _ratios(own, collision.compression), frictional_contact.half_period(own, 1.0)
    if not collision.restitution > 0.0:
        return results
    results["half_period"] = half_period
    if half_period * MOST_HALF_PERIODS < 1.0:
        return results
    results["sticks_below"], results["slides_beyond"] = frictional_contact.borders(own, 1.0)
    results |= {f"β {k}": beta for k, (_, beta) in enumerate(frictional_contact.table(own, 1.0))}
    results["effective_tangential_restitution"] = frictional_contact.effective_restitution(
        own, 1.0, dimension
    )
    if time_step is not None:
        step = time_step / force.scales(speed)[1]
        results["steps_per_half_period"] = half_period * collision.duration / step
        error = _error_of_step(own, float(f"{step:.10g}"))
        results["tangential_restitution_error_of_step"] = error
    return results


def _ratios(own: FrictionalContact, compression: float) -> dict[str, Any]:
    """Tangential over normal stiffness and damping at a compression."""
    terms, (elastic, damped, _) = own.terms, own.powers
    p, q = 0.25 * elastic, 0.25 * damped
    stiffness = terms.stiffness * compression ** (0.25 * terms.stiffness_power)
    damping = terms.damping * compression ** (0.25 * terms.damping_power)
    normal = own.coefficients[1] * compression**q
    return {
        "limit": LIMITS[terms.limit],
        "stiffness_ratio": stiffness / (p * compression ** (p - 1.0)),
        "damping_ratio": damping / normal if normal > 0.0 else 0.0 if damping == 0.0 else None,
    }


@lru_cache(maxsize=1024)
def _error_of_step(own: FrictionalContact, time_step: float) -> float:
    """The largest error of β at :data:`TESTED` impacts; infinite if the contact does not end with this step.

    Beyond the largest number of steps that is tried, the error is taken as proportional to the step.
    """
    scaled = Force(Powers(*own.powers), 1.0, own.coefficients[1], 1.0)
    tried = max(time_step, scaled.collision(1.0).duration / integration_error.MAX_FRICTION_STEPS)
    tangents = TESTED * min(own.terms.coefficient, 1.0) / own.tangential_mass
    exact = frictional_contact.tangential_restitution(own, 1.0, np.arctan(tangents))
    with np.errstate(over="ignore", invalid="ignore"):  # a contact that gains energy without end
        beta = integration_error.tangential_restitution(
            scaled, own.terms, own.tangential_mass, 1.0, tangents, tried
        )
        error = math.inf if beta is None else float(np.abs(beta - exact).max())
    return error * time_step / tried


def friction_of(law: FrictionLaw, results: Mapping[str, Any]) -> CheckedFriction:
    """The friction of a contact from those of its results that are known."""
    steps = results.get("steps_per_half_period")
    known: dict[str, Any] = {name: results.get(name) for name in (*RESULTS, "limit")}
    known["steps_per_half_period"] = None if steps is None else math.floor(steps)
    table = [(angle, results.get(f"β {k}")) for k, angle in enumerate(ANGLES)]
    others = [(when, results.get(f"other {when}")) for when, _ in law.others]
    return CheckedFriction(
        coefficient=law.coefficient,
        model=law.model,
        not_known=law.not_known,
        tangential_restitution=tuple((angle, beta) for angle, beta in table if beta is not None),
        other_versions=tuple((when, beta) for when, beta in others if beta is not None),
        **known,
    )


# --- in words -------------------------------------------------------------------------------------------------


def words(frictions: Sequence[CheckedFriction]) -> str:
    """One line about the friction of contacts that differ in the number of steps only; empty without friction."""
    friction = frictions[0]
    if friction.coefficient == 0.0:
        return ""
    if friction.coefficient is None:
        return "μ is not known"
    parts = [_angles(friction), _restitution(friction), _period(frictions)]
    unknown = "tangential model not understood" if friction.model is None else "depends on what is not known"
    known = "; ".join(filter(None, parts)) or friction.not_known or unknown
    return f"μ {digits(friction.coefficient, 3)}: {known}"


def but_for_steps(friction: CheckedFriction) -> str:
    """The line, without what depends on the time step."""
    return words([replace(friction, steps_per_half_period=None)])


def _angles(friction: CheckedFriction) -> str:
    """Where it sticks and slides."""
    sticks, slides = friction.sticks_below, friction.slides_beyond
    if friction.stiffness_ratio == 0.0:
        return "no static friction"
    if sticks is None or slides is None:
        return ""
    if friction.coefficient == math.inf:
        return "never slips"
    below = f"sticks below {_degrees(sticks)}" if sticks > ONE_ANGLE else "slips first at every angle"
    if slides - sticks < ONE_ANGLE:
        return f"{below}, slides beyond"
    return f"{below}, slides beyond {_degrees(slides)}" if slides < math.radians(89.5) else below


def _restitution(friction: CheckedFriction) -> str:
    """β near head-on, where it is largest (at 45° if that is there), and in a gas."""
    table = dict(friction.tangential_restitution)
    if len(table) < len(ANGLES):
        return ""
    head_on = table[ANGLES[0]]
    largest = max(table, key=lambda angle: table[angle])
    angle = largest if table[largest] > head_on + HIGHER else ANGLES[len(ANGLES) // 2]
    gas = friction.effective_tangential_restitution
    parts = [f"{_signed(head_on)} near head-on", f"{_signed(table[angle])} at {_degrees(angle)}"]
    return f"β {', '.join(parts)}{'' if gas is None else f', {gas:.2f} in a gas'.replace('-', '−')}"


def _period(frictions: Sequence[CheckedFriction]) -> str:
    period = frictions[0].half_period
    if period is None:
        return ""
    steps = [friction.steps_per_half_period for friction in frictions]
    known = [count for count in steps if count is not None]
    ends = "–".join(dict.fromkeys(str(count) for count in (min(known), max(known)))) if known else ""
    shown = digits(period, 2) if period < 10.0 else f"{period:.0f}"
    return f"tangential half period {shown} t_c{f', {ends} steps' if ends else ''}"


def _degrees(angle: float) -> str:
    return f"{math.degrees(angle):.0f}°"


def _signed(beta: float) -> str:
    return f"{beta:+.2f}".replace("-", "−")


#: Words of traps of which readers of scripts tell as well, by the words of the script.
OF_READERS: Final = ("no static friction", "attracts")


def versions(row: CheckedContact) -> str:
    """β of a contact in other versions of its code; empty if it is the same in all."""
    beta = dict(row.friction.tangential_restitution).get(float(OBLIQUE[0]))
    others = [f"{_signed(other)} {when}" for when, other in row.friction.other_versions]
    if not others:
        return ""
    return f"β at 45° is {', and '.join(([] if beta is None else [_signed(beta)]) + others)}"


def _head_on(row: CheckedContact) -> float:
    return next((beta for _, beta in row.friction.tangential_restitution), math.nan)


def _superball(row: CheckedContact) -> str:
    beta, ratio = _head_on(row), row.friction.stiffness_ratio
    if not beta > REVERSED:
        return ""
    return (
        f"superballs: where they stick, the spin is reversed (β = {_signed(beta)} near head-on), "
        f"with k_t/k_n = {digits(ratio or 0.0, 2)}"
    )


def _smooth(row: CheckedContact) -> str:
    beta = _head_on(row)
    if not beta < KEPT or row.friction.stiffness_ratio == 0.0:
        return ""
    return (
        f"where they stick, grains leave as smooth ones do (β = {_signed(beta)} near head-on): the tangential spring "
        f"takes {digits(row.friction.half_period or 0.0, 2)} t_c for half an oscillation"
    )


def _no_static_friction(row: CheckedContact) -> str:
    if row.friction.stiffness_ratio != 0.0:
        return ""
    return "there is no static friction, and β is never above 0: the tangential model has no spring"


def _gain(row: CheckedContact) -> str:
    largest = max((abs(beta) for _, beta in row.friction.tangential_restitution), default=0.0)
    if not largest > 1.0 + GAIN:
        return ""
    return f"friction adds energy: |β| reaches {largest:.2f} ({row.friction.model})"


def _attractive(row: CheckedContact) -> str:
    if row.clipped is not False or row.restitution in (None, 1.0) or row.friction.limit is None:
        return ""
    return "friction acts at the end of contacts too, where the normal force attracts: μ |F_n| is the limit"


#: What friction does that is rarely meant: words about a contact, empty if it does not.
TRAPS: Final = (_superball, _smooth, _no_static_friction, _gain, _attractive)
