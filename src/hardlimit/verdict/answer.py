"""The answer in one sentence: yes, no, or that it cannot be said, with the number that decides."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import ROUND_CEILING, Context

from ..support.formatting import digits, listed, percent, percent_with_error
from .contacts import CheckedContact
from .drive import Drive
from .error_law import MEASURED_TC_NU
from .expectation import ACCEPTED
from .result import Finding

#: Options that supply what is missing.
OPTIONS = {
    "speeds": "--speed",
    "packing": "--packing-fraction",
}


NAMES = {
    "stiffness": "a stiffness",
    "youngs_modulus": "a Young's modulus",
    "elastic_prefactor": "an elastic prefactor",
}


def answer(
    rows: Sequence[CheckedContact],
    invalidates: Sequence[Finding],
    unknown: Sequence[Finding],
    missing: Sequence[str],
    rubs: bool = False,
    dumped: bool = False,
    shaken: bool = False,
) -> tuple[bool | None, str]:
    """Whether event-driven simulation is admissible, and the sentence.

    ``rubs``: the script has friction, left out. ``dumped``: a dump was given. ``shaken``: walls move.
    """
    if invalidates:
        return False, _invalid(invalidates)
    if shaken:
        return (
            None,
            "Cannot be said: the law of the error is that of a homogeneous gas; walls drive this box: run both.",
        )
    known = [row for row in rows if row.rule in row.error]
    worst = max(known, key=lambda row: sum(_error(row)), default=None)
    if known and worst is not None:
        longest = max(known, key=lambda row: row.tc_nu or 0.0)
        surest = max(known, key=lambda row: _error(row)[0] - _error(row)[1])
        for row in (worst, longest):
            if (row.tc_nu or 0.0) > MEASURED_TC_NU:
                return False, f"No: {_far(row)}; {_needs(row)}."
        for row in (worst, surest):
            if _error(row)[0] - _error(row)[1] > ACCEPTED:
                return False, f"No: {_cools(row)}; {_needs(row)}."
    if unknown:
        return None, f"Cannot be said: this is not understood: {unknown[0].where or unknown[0].what}"
    pairs = [row for row in rows if row.types[1] != "wall"]
    if missing or len(known) < len(pairs) or worst is None:
        if not missing:
            return None, "Cannot be said: the error is not known for so dense a packing."
        are = "is" if list(missing) == ["packing"] else "are"
        return None, f"Cannot be said: {listed(missing)} {are} not known{given_by(missing, dumped)}."
    if sum(_error(worst)) > ACCEPTED:
        return None, f"Cannot be said: {_cools(worst)}, and {percent(ACCEPTED)} is within the error bar."
    condition = ", for grains without friction" if rubs else ""
    return True, f"Yes{condition}: {_cools(worst)}, less than {percent(ACCEPTED)}; {_may(worst)}."


def steady(rows: Sequence[CheckedContact], drive: Drive | None, plain: bool) -> str:
    """From where the speed of a driven gas comes, and the error of its steady state; rows in SI units."""
    pairs = [
        row for row in rows if row.types[1] != "wall" and row.speed is not None and row.rule in row.error
    ]
    if drive is None or not pairs:
        return ""
    worst = max(pairs, key=lambda row: abs(row.error[row.rule][0]))
    speed, x = worst.speed or 0.0, worst.tc_nu or 0.0
    shown = digits(speed, 2) if plain else f"{digits(speed, 2)} m/s"
    text = f" Impacts at {shown} are those of the steady state under {drive.words(plain)}"
    if drive.shear_rate is not None:
        return f"{text} (kinetic theory){_of_stress(worst)}."
    if drive.power is None or x > MEASURED_TC_NU or worst.heated_error is None:
        return f"{text}."
    how = "cold" if worst.heated_error < 0.0 else "hot"
    return f"{text}; event-driven is {percent(abs(worst.heated_error))} too {how} there."


def _of_stress(row: CheckedContact) -> str:
    """The error of the shear stress, if it is known."""
    if row.sheared_error is None or (row.tc_nu or 0.0) > MEASURED_TC_NU:
        return ""
    how = "high" if row.sheared_error > 0.0 else "low"
    return f"; there the shear stress of event-driven is {percent(abs(row.sheared_error))} too {how}"


def given_by(missing: Sequence[str], dumped: bool) -> str:
    """Which options give what is missing."""
    options = [OPTIONS[one] for one in missing if one in OPTIONS]
    if not options:
        return " (they are not in the script)"
    return (
        f" (not in the dump; give {listed(options)})" if dumped else f" (give --dump, or {listed(options)})"
    )


def _error(row: CheckedContact) -> tuple[float, float]:
    """The size of the error of cooling, and its error bar."""
    value, bar = row.error[row.rule]
    return abs(value), bar


def _invalid(invalidates: Sequence[Finding]) -> str:
    first = invalidates[0]
    kinds = tuple(dict.fromkeys(first.types or ()))
    where = f" of type{'s' * (len(kinds) > 1)} {listed(kinds)}" if kinds else ""
    others = f" and {len(invalidates) - 1} more" if len(invalidates) > 1 else ""
    return f"No: {first.what}{where}{others}, which no event-driven simulation can follow."


def _cools(row: CheckedContact) -> str:
    """How far the cooling is off, and where."""
    value, bar = row.error[row.rule]
    pair = "–".join(row.types)
    how = "too fast" if value > 0.0 else "too slowly"
    numbers = f"t_c ν = {digits(row.tc_nu or 0.0, 2)}, δ/d = {digits(row.delta_over_d or 0.0, 2)}"
    return (
        f"event-driven cools {percent_with_error(abs(value), bar)} {how} at {numbers} "
        f"(grains {pair}{'' if row.rule == 'constant' else f', rule {row.rule}'})"
    )


def _far(row: CheckedContact) -> str:
    """That contacts last too long for the law of the error."""
    return (
        f"t_c ν = {digits(row.tc_nu or 0.0, 2)} (grains {'–'.join(row.types)}) is above {MEASURED_TC_NU:g}, "
        f"where event-driven is off by far more than {percent(ACCEPTED)}"
    )


def _needs(row: CheckedContact) -> str:
    """The stiffness with which the error is 1 %, error bar included."""
    if row.spring is None:
        return f"{percent(ACCEPTED)} takes {_at_least(row.softening or 0.0)} times the stiffness"
    name, value, needed = row.spring
    return f"{percent(ACCEPTED)} takes {NAMES[name]} of {_at_least(needed)} instead of {digits(value, 3)}"


def _may(row: CheckedContact) -> str:
    """How soft the grains may be."""
    softer = row.softening or 1.0
    if row.spring is None or softer >= 1.0:
        return f"{percent(ACCEPTED)} allows {_at_least(softer)} times the stiffness"
    name, value, needed = row.spring
    return f"you may soften to {NAMES[name]} of {_at_least(needed)} from {digits(value, 3)}"


def _at_least(value: float) -> str:
    """Two digits, rounded up."""
    return digits(float(Context(2, ROUND_CEILING).create_decimal_from_float(value)), 2)
