"""The answer in one sentence: yes, no, or that it cannot be said, with the number that decides."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import ROUND_CEILING, Context
from typing import Final

from ..boxes.error_law import MEASURED_TC_NU
from ..support.formatting import digits, listed, percent, percent_with_error
from .contacts import COMPRESSED, CheckedContact
from .drive import Drive
from .expectation import ACCEPTED
from .result import Finding

#: Options that supply what is missing.
OPTIONS = {
    "speeds": "--speed",
    "packing": "--packing-fraction",
    "sizes": "--radius",
    "masses": "--density",
}


#: The error of each quantity, how event-driven simulations are off, and the words for too large and too small.
ERROR_OF = {
    "cooling": "the error of the cooling",
    "temperature": "the error of the temperature",
    "stress": "the error of the shear stress",
}
VERBS = {
    "cooling": "event-driven cools",
    "temperature": "event-driven is",
    "stress": "the shear stress of event-driven is",
}
WAYS = {
    "cooling": ("too fast", "too slowly"),
    "temperature": ("too hot", "too cold"),
    "stress": ("too high", "too low"),
}
#: Smallest error that the rule constant adds to that of the rule law which is said.
SMALLEST_ADDED = 0.001
#: Share of a stiffness from which on less is no advice.
HARDLY_SOFTER = 0.9
HOMOGENEOUS = "the law of the error is that of a homogeneous gas"


#: What is said of grains in free fall, or at rest without gravity.
NEVER_MEET: Final = (
    "no grain meets another or a wall (t_c ν = 0): all start with one velocity, or side by side along gravity, which "
    "acts on all alike, and no wall is in their way"
)

OF_MANY: Final = "the law of the error is that of a gas of many grains"
BOUNCE: Final = "elastic grains bounce for ever under gravity"


@dataclass(frozen=True)
class Question:
    """What is asked of the contacts."""

    quantity: str = "cooling"  #: "temperature" of a heated gas, "stress" of a sheared one
    dumped: bool = False  #: whether a dump was given
    driven: str = ""  #: what drives the box so that no law of the error holds, in words
    option: str = ""  #: of ``hardlimit gas compare``, which drives a box in the same way
    purpose: Drive | None = None  #: what the box is run for, if not to cool
    heats_spins: bool = False  #: whether a thermostat acts on spins, too
    may_be_dense: bool = False  #: whether it is a shear flow whose pressure is not known
    drive_option: str = ""  #: the one that states what drives it, which excludes a speed
    never_meet: bool = False  #: whether no grain meets another or a wall
    few: bool = False  #: whether there are one or two grains, or those that meet walls only


def answer(
    rows: Sequence[CheckedContact],
    invalidates: Sequence[Finding],
    unknown: Sequence[Finding],
    missing: Sequence[str],
    question: Question = Question(),
) -> tuple[bool | None, str]:
    """Whether event-driven simulation is admissible, and the sentence."""
    if invalidates:
        return False, _invalid(invalidates)
    if question.never_meet:
        return None, f"Cannot be said: {NEVER_MEET}."
    if question.driven:
        return None, f"Cannot be said: {_driven(rows, question)}."
    pairs = [row for row in rows if row.types[1] != "wall"]
    known = [row for row in pairs if judged(row, question) is not None and "speeds" not in missing]
    if wrong := _too_wrong(pairs, known, missing, question):
        return False, f"No: {wrong}.{_with_friction(known, question)}"
    if unknown:
        return None, f"Cannot be said: this is not understood: {unknown[0].where or unknown[0].what}."
    rubbing = [row for row in pairs if row.friction.coefficient != 0.0]
    unclear = any(row.friction.coefficient is None for row in rubbing)
    if rubbing and len(known) < len(pairs) and (unclear or not missing):
        return None, f"Cannot be said: {_rubs(rubbing, question)}."
    if question.few:
        return None, f"Cannot be said: {OF_MANY}."
    if missing or len(known) < len(pairs) or not known:
        return None, f"Cannot be said: {_not_known(missing, question)}."
    worst = max(known, key=lambda row: sum(_error(row, question)))
    if sum(_error(worst, question)) > ACCEPTED:
        return (
            None,
            f"Cannot be said: {_off(worst, question)}, and {percent(ACCEPTED)} is within the error bar."
            f"{_with_friction(known, question)}",
        )
    small = f"{_off(worst, question)}, less than {percent(ACCEPTED)}"
    if any(row.friction.coefficient != 0.0 and row.types[1] == "wall" for row in rows):
        return None, f"Cannot be said: {small}, but walls rub, which the law of the error leaves out."
    return True, f"Yes: {small}; {_may(worst)}.{_with_friction(known, question)}"


def judged(row: CheckedContact, question: Question) -> tuple[float, float] | None:
    """The error that decides, and its error bar; None if it is not known."""
    value, bar = {
        "cooling": row.error.get(row.rule, (None, None)),
        "temperature": (row.heated_error, row.heated_error_bar),
        "stress": (row.sheared_error, row.sheared_error_bar),
    }[question.quantity]
    return None if value is None or bar is None else (value, bar)


def _too_wrong(
    pairs: Sequence[CheckedContact],
    known: Sequence[CheckedContact],
    missing: Sequence[str],
    question: Question,
) -> str:
    """Why the answer is no: contacts last too long, or an error is surely too large; empty if there is no reason."""
    longest = max(pairs, key=lambda row: row.tc_nu or 0.0, default=None)
    if longest is not None and (longest.tc_nu or 0.0) > MEASURED_TC_NU and "speeds" not in missing:
        return f"{_far(longest, question)}{_needs(longest)}"
    by_size = sorted(known, key=lambda row: sum(_error(row, question)), reverse=True)
    surest = max(known, key=lambda row: _error(row, question)[0] - _error(row, question)[1], default=None)
    for row in (*by_size[:1], *([surest] if surest else [])):
        value, bar = _error(row, question)
        if value - bar > ACCEPTED:
            return f"{_off(row, question)}{_needs(row)}"
    return ""


def _driven(rows: Sequence[CheckedContact], question: Question) -> str:
    """What drives the box, and what to do."""
    rubbing = [row for row in rows if row.friction.coefficient != 0.0]
    also = f", grains rub ({_friction(rubbing)})" if rubbing else ""
    frictions = {row.friction.coefficient for row in rubbing}
    options = [question.option, *(f"--friction {digits(mu, 4)}" for mu in frictions if mu is not None)]
    known = question.option and len(frictions) < 2 and None not in frictions
    how = f" (hardlimit gas compare {' '.join(options)})" if known else ""
    return f"{question.driven}{also}, and {HOMOGENEOUS}: run both{how}"


def _friction(rows: Sequence[CheckedContact]) -> str:
    """The coefficient of friction, or the smallest and the largest."""
    values = [mu for row in rows if (mu := row.friction.coefficient) is not None]
    if len(values) < len(rows):
        return "μ is not known"
    return f"μ = {'–'.join(dict.fromkeys(digits(value, 3) for value in (min(values), max(values))))}"


def _rubs(rows: Sequence[CheckedContact], question: Question) -> str:
    """That grains rub, and the error that they would have without friction."""
    pairs = listed(list(dict.fromkeys("–".join(row.types) for row in rows)))
    error = ERROR_OF[question.quantity]
    text = f"grains {pairs} rub ({_friction(rows)}), and {error} is {_known_only(question)}"
    smooth = [row for row in rows if row.frictionless_error is not None]
    if not smooth:
        return text
    worst = max(smooth, key=lambda row: abs(row.frictionless_error or 0.0))
    value = worst.frictionless_error or 0.0
    way = WAYS[question.quantity][value < 0.0]
    without = "; without it, it" if question.quantity == "cooling" else "; without friction, it"
    return f"{text}{without} is {_about(value)} ({way}) at {_numbers(worst)}"


def _about(error: float) -> str:
    """A relative error of which only the size counts."""
    size = percent(abs(error))
    return size if size.startswith("less") else f"about {size}" if error < 9.0 else "more than ten times"


def _known_only(question: Question) -> str:
    """For which friction the error is known."""
    if question.heats_spins:
        return "known only where no thermostat acts on spins"
    of_driven = " (it is for spheres of one μ with linear springs, normal and tangential)"
    return f"not known with this friction{of_driven * (question.quantity != 'cooling')}"


def _with_friction(known: Sequence[CheckedContact], question: Question) -> str:
    """Which friction event-driven grains must have, and what leaving it out would do; empty for smooth ones."""
    rubbing = [row for row in known if row.friction.coefficient != 0.0]
    if not rubbing:
        return ""
    row = max(rubbing, key=lambda row: abs(row.smooth_error or 0.0))
    value, beta = row.smooth_error, row.friction.effective_tangential_restitution
    constant = ""
    cools = question.quantity == "cooling"
    if cools and beta is not None and {"constant", "law"} <= set(row.error):
        added = row.error["constant"][0] - row.error["law"][0]
        constant = (
            f" or constant with μ {digits(row.friction.coefficient or 0.0, 3)} and β0 {digits(beta, 2)}"
        )
        if abs(added) >= SMALLEST_ADDED:
            constant += f", which cools {percent(abs(added))} {'faster' if added > 0.0 else 'more slowly'}"
    without = ""
    if value is not None:
        way = WAYS[question.quantity][value < 0.0]
        without = f"; without, it {'cools' if cools else 'is'} {_about(value)} {way}"
    beyond = next(
        (f" Less is known of these grains: {row.extrapolated}." for row in known if row.extrapolated), ""
    )
    return f" Event-driven must have the same friction (rule law{constant}){without}.{beyond}"


def _not_known(missing: Sequence[str], question: Question) -> str:
    """What is missing for an answer."""
    if missing:
        are = "is" if list(missing) == ["packing"] else "are"
        pressure = "; --pressure gives the inertial number" * question.may_be_dense
        return f"{listed(missing)} {are} not known{given_by(missing, question.dumped, question.drive_option)}{pressure}"
    if question.quantity == "cooling":
        return "the error is not known for so dense a packing"
    return f"{ERROR_OF[question.quantity]} is not known for these grains and this packing"


def steady(rows: Sequence[CheckedContact], drive: Drive | None, plain: bool) -> str:
    """From where the speed of a driven gas comes; rows in SI units."""
    pairs = [row for row in rows if row.types[1] != "wall"]
    if drive is None or not pairs or any(row.speed is None or row.tc_nu is None for row in pairs):
        return ""
    worst = max(pairs, key=lambda row: row.tc_nu or 0.0)
    speed = worst.speed or 0.0
    shown = digits(speed, 2) if plain else f"{digits(speed, 2)} m/s"
    text = f" Impacts at {shown} are those of the steady state under {drive.words(plain)}"
    theory = ["kinetic theory"] * (drive.shear_rate is not None)
    if worst.temperature_ratio is not None:
        theory = [f"kinetic theory with friction, T_r/T = {digits(worst.temperature_ratio, 2)}"]
    elif any(row.friction.coefficient != 0.0 for row in pairs):
        theory.append("of grains without friction")
    return f"{text} ({' '.join(theory)})." if theory else f"{text}."


def given_by(missing: Sequence[str], dumped: bool, drive_option: str = "") -> str:
    """Which options give what is missing, a speed in place of ``drive_option``."""
    options = [OPTIONS[what] for what in missing if what in OPTIONS]
    if not options:
        return " (they are not in the script)"
    if drive_option and "speeds" in missing:
        return f" (no steady state is known; give {listed(options)} instead of {drive_option})"
    return (
        f" (not in the dump; give {listed(options)})" if dumped else f" (give --dump, or {listed(options)})"
    )


def _error(row: CheckedContact, question: Question) -> tuple[float, float]:
    """The size of the error that decides, and its error bar."""
    value, bar = judged(row, question) or (0.0, 0.0)
    return abs(value), bar


def _invalid(invalidates: Sequence[Finding]) -> str:
    first = invalidates[0]
    kinds = tuple(dict.fromkeys(first.types or ()))
    where = f" of type{'s' * (len(kinds) > 1)} {listed(kinds)}" if kinds else ""
    more = len({finding.what for finding in invalidates} - {first.what})
    others = f" (and {more} other reason{'s' * (more > 1)})" if more else ""
    return f"No: {first.what}{where}, which no event-driven simulation can follow{others}."


def _off(row: CheckedContact, question: Question) -> str:
    """How far the quantity is off, and where."""
    value, bar = judged(row, question) or (0.0, 0.0)
    pair = "–".join(row.types)
    rule = "" if row.rule == "constant" or row.friction.coefficient else f", rule {row.rule}"
    size = f"{percent_with_error(abs(value), bar)} {WAYS[question.quantity][value < 0.0]}"
    return f"{VERBS[question.quantity]} {size} at {_numbers(row)} (grains {pair}{rule})"


def _numbers(row: CheckedContact) -> str:
    return f"t_c ν = {digits(row.tc_nu or 0.0, 2)}, δ/d = {digits(row.delta_over_d or 0.0, 2)}"


def _far(row: CheckedContact, question: Question) -> str:
    """That contacts last too long for the law of the error."""
    smooth = question.quantity == "cooling" and row.friction.coefficient == 0.0
    off = (
        f"event-driven is off by far more than {percent(ACCEPTED)}" if smooth else "contacts overlap in time"
    )
    return (
        f"t_c ν = {digits(row.tc_nu or 0.0, 2)} (grains {'–'.join(row.types)}) is above {MEASURED_TC_NU:g}, "
        f"where {off}"
    )


def _needs(row: CheckedContact) -> str:
    """The stiffness with which the error is 1 %, error bar included; empty if it is not known."""
    if row.spring is None or row.softening is None:
        return (
            ""
            if row.softening is None
            else f"; {percent(ACCEPTED)} takes {_at_least(row.softening)} times the stiffness"
        )
    name, value, needed = row.spring
    text = f"{stiffness(name)} of {_with_unit(row, needed)} instead of {digits(value, 3)}"
    return f"; {percent(ACCEPTED)} takes {text}{_kept(row)}"


def _may(row: CheckedContact) -> str:
    """How soft the grains may be."""
    softer = row.softening or 1.0
    if row.spring is None or softer >= 1.0:
        return f"{percent(ACCEPTED)} allows {_at_least(softer)} times the stiffness"
    name, value, needed = row.spring
    if needed > HARDLY_SOFTER * value:
        return f"{percent(ACCEPTED)} takes nearly this stiffness"
    text = f"you may soften to {stiffness(name)} of {_with_unit(row, needed)} from {digits(value, 3)}"
    text += _kept(row)
    overlap = row.softened_overlap or 0.0
    if overlap <= COMPRESSED:
        return text
    return f"{text}, but overlaps are then {percent(overlap)} of R, and contact laws hold up to {percent(COMPRESSED)}"


def stiffness(name: str) -> str:
    """The parameter that sets the stiffness, in words."""
    words = name.replace("_", " ").replace("youngs", "Young's")
    return f"{'an' if words[0] in 'aeiou' else 'a'} {words}"


def _kept(row: CheckedContact) -> str:
    """What must not change with the stiffness, unless the script keeps it by itself."""
    spring = row.spring is not None and row.spring[0] == "stiffness"
    kept = ["ε"] * (row.restitution_asked is None) + ["k_t/k_n"] * bool(spring and row.friction.coefficient)
    return f", with the same {listed(kept)}" if kept else ""


def _with_unit(row: CheckedContact, value: float) -> str:
    return f"{_at_least(value)} {row.stiffness_unit}".rstrip()


def _at_least(value: float) -> str:
    """Two digits, rounded up."""
    return digits(float(Context(2, ROUND_CEILING).create_decimal_from_float(value)), 2)
