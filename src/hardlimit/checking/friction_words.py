"""What check says of friction: a line for each contact, and traps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from ..contact.frictional_contact import ANGLES
from ..support.formatting import digits
from .contacts import CheckedContact
from .friction import OBLIQUE, CheckedFriction

#: β near head-on above and below which sticking grains count as superballs and as smooth.
REVERSED, KEPT = 0.9, -0.9
#: Smallest gain of tangential speed without slip that gives a warning.
GAIN: Final = 1e-3
#: Difference [rad] below which two angles are one.
ONE_ANGLE: Final = math.radians(0.5)
#: Angle [rad] beyond which there are no impacts to speak of.
GRAZING: Final = math.radians(89.5)
#: Difference of β in versions of a code that is not worth telling.
EQUAL: Final = 0.02
#: Difference of β that makes another angle worth telling.
HIGHER: Final = 0.05


def words(frictions: Sequence[CheckedFriction]) -> str:
    """One line about the friction of contacts that differ in the number of steps only; empty without friction."""
    friction = frictions[0]
    if friction.coefficient == 0.0:
        return ""
    if friction.coefficient is None:
        return "μ is not known"
    parts = [_angles(friction), _restitution(friction), _period(frictions)]
    unknown = "tangential model not understood" if friction.model is None else "β is not known"
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
    if sticks > GRAZING:
        return "sticks at all angles"
    if slides < ONE_ANGLE:
        return "slides at every angle"
    below = f"sticks below {_degrees(sticks)}" if sticks > ONE_ANGLE else "slips first at every angle"
    if slides - sticks < ONE_ANGLE:
        return f"{below}, slides beyond"
    return f"{below}, slides beyond {_degrees(slides)}" if slides < GRAZING else below


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
    count = f", {ends} step{'s' * (ends != '1')}" if ends else ""
    return f"tangential half period {shown} t_c{count}"


def _degrees(angle: float) -> str:
    return f"{math.degrees(angle):.0f}°"


def _signed(beta: float) -> str:
    return f"{beta:+.2f}".replace("-", "−")


#: Words of traps of which readers of scripts tell as well, by the words of the script.
OF_READERS: Final = ("no static friction", "attracts")
#: Words of readers about conventions, and the number that tells how much these change β.
CONVENTIONS: Final = {
    "the normal force attracts at the end": "changed_by_attraction",
    "limits the spring alone": "changed_by_limit",
}


def is_minor(what: str, rows: Sequence[CheckedContact]) -> bool:
    """Whether a warning is of a convention that hardly changes β in any contact."""
    fields = [field for words, field in CONVENTIONS.items() if words in what]
    changes = [
        getattr(row.friction, field) for row in rows if row.friction.coefficient != 0.0 for field in fields
    ]
    return bool(changes) and all(change is not None and change < EQUAL for change in changes)


def versions(row: CheckedContact) -> str:
    """β of a contact in other versions of its code; empty if it is the same in all."""
    beta = dict(row.friction.tangential_restitution).get(float(OBLIQUE[0]))
    versions = row.friction.other_versions
    others = [f"{_signed(other)} {when}" for when, other in versions]
    if not others or (beta is not None and all(abs(other - beta) < EQUAL for _, other in versions)):
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
    change = row.friction.changed_by_attraction
    hardly = row.restitution in (None, 1.0) or (change is not None and change < EQUAL)
    if row.clipped is not False or hardly or row.friction.limit is None:
        return ""
    return "friction acts at the end of contacts too, where the normal force attracts: μ |F_n| is the limit"


#: What friction does that is rarely meant: words about a contact, empty if it does not.
TRAPS: Final = (_superball, _smooth, _no_static_friction, _gain, _attractive)
