"""One column as instantaneous collisions and under Newton's equations: what differs, does it matter?"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..support import html
from ..support.formatting import digits
from .models import ADIABATIC, MODELS
from .result import Result, quantities
from .scenario import Column
from .solvers import adiabatic, independent, newton

#: Differences of the final velocities up to this, relative, are taken as agreement.
TOLERANCE: Final = 0.01


class Verdict(NamedTuple):
    """May this drop be simulated event-driven? Returned by :attr:`Comparison.verdict`.

    Examples
    --------
    >>> answer, sentence = hl.compare(hl.Column.paper(gap=0.01)).verdict
    >>> answer
    'yes'
    >>> print(sentence)
    Yes: one contact follows the other, and event-driven gets the separation velocity
    right to 0.2 %.
    """

    answer: Literal["yes", "by luck", "no", "undecided"]  #: in a word
    sentence: str  #: what happens, and what event-driven makes of it


@dataclass(frozen=True)
class Comparison:
    """One column under all models that apply to it; made by :func:`compare`.

    Examples
    --------
    >>> both = hl.compare(hl.Column.paper(gap=1e-3))
    >>> [round(result.separation_velocity, 2) for result in both.results]
    [2.13, 2.14, 3.73]
    """

    newton: Result  #: Newton's equations
    independent: Result  #: instantaneous collisions
    adiabatic: Result | None  #: Appendix A; None where it does not apply

    @property
    def results(self) -> tuple[Result, ...]:
        """The models in the order in which they are shown."""
        return tuple(r for r in (self.newton, self.adiabatic, self.independent) if r is not None)

    @property
    def verdict(self) -> Verdict:
        """Whether independent collisions suffice for this column, in one sentence."""
        return _verdict(self)

    def _repr_html_(self) -> str:
        columns = [quantities(result) for result in self.results]
        rows = [[row[0][0], *(digits(value) for _, value in row)] for row in zip(*columns, strict=True)]
        rows.append(["outcome", *(result.outcome.split(":")[0] for result in self.results)])
        head = ["", *(MODELS[result.model].short for result in self.results)]
        return html.table("Newton’s equations and event-driven", head, rows, self.verdict.sentence)


def compare(column: Column) -> Comparison:
    """Solve the column under Newton's equations, independent collisions and, where it applies, Appendix A.

    The verdict compares the separation velocity of two balls on a floor, and else the velocities with which the balls
    leave their last contacts of the sequence, before the floor is met again (see :doc:`/definitions`).

    Parameters
    ----------
    column : Column

    Returns
    -------
    Comparison

    Raises
    ------
    ValueError
        If ``column`` is not a Column.

    Examples
    --------
    >>> print(hl.compare(hl.Column.paper()).verdict.sentence)
    No: all 4 contacts of the balls happen while another contact lasts; for the
    separation velocity event-driven gives 3.73 m/s instead of 0.125 m/s.
    """
    fast, hard = newton(column), independent(column)
    return Comparison(fast, hard, adiabatic(column) if ADIABATIC.applies(column) else None)


def overlapping_contacts(result: Result) -> int:
    """Ball–ball contacts of the sequence during which another contact lasts as well."""
    pair, begin, end = result.contact_times
    end = np.where(np.isnan(end), math.inf, end)
    return sum(
        bool(np.any((np.arange(len(pair)) != i) & (begin < end[i]) & (begin[i] < end)))
        for i in _of_balls(result)
    )


def _of_balls(result: Result) -> NDArray[np.int64]:
    """Indices of the ball–ball contacts of the sequence: the first ones, in the order of their begins."""
    return np.flatnonzero(result.contact_times[0])[: result.n_contacts]


# --- the verdict --------------------------------------------------------------------------------------------

#: Outcomes of event-driven that are its failure, in words.
_FAILURES: Final = {
    "collapse": "ends in an inelastic collapse, infinitely many collisions in a finite time",
    "at_rest": "comes to rest by infinitely many collisions in a finite time",
}


def _verdict(c: Comparison) -> Verdict:
    true, hard = (_core.outcome_names[r.outcome_code] for r in (c.newton, c.independent))
    unclear = _unclear(c, true, hard)
    if unclear is not None:
        return Verdict("undecided", f"No verdict: {unclear}.")
    if true == "at_rest":
        return Verdict(
            "no", "No: under Newton’s equations a contact never ends, and event-driven has none that last."
        )
    if hard in _FAILURES:
        return Verdict("no", f"No: event-driven {_FAILURES[hard]}, Newton’s equations do not.")
    found = _difference(c)
    meetings = [r.n_contacts for r in (c.newton, c.independent)]
    if 0 in meetings and any(meetings) and not found.error <= TOLERANCE:
        met, missed = (
            ("Newton’s equations", "event-driven") if meetings[0] else ("event-driven", "Newton’s equations")
        )
        before = " before the floor is met again" if c.newton.column.floor else ""
        return Verdict("no", f"No: the balls meet under {met} but not under {missed}{before}.")
    return _by_numbers(c, found)


def _unclear(c: Comparison, true: str, hard: str) -> str | None:
    """Why there is nothing to compare, if so."""
    for who, name, result in (("Newton’s equations", true, c.newton), ("event-driven", hard, c.independent)):
        if name in ("invalid", "unresolved", "never_lands", "too_deep"):
            return f"{who} ended in “{result.outcome.split(':')[0]}”"
    if true == hard == "no_contact" and len(c.newton.column.balls) > 1:
        return "the balls do not meet before the floor is met again"
    return None


class _Difference(NamedTuple):
    error: float  #: of the event-driven model, relative; NaN if a model has no such value
    clause: str  #: that states it
    later: bool = False  #: whether contacts of the upper balls after the second floor contact count


def _by_numbers(c: Comparison, found: _Difference) -> Verdict:
    """The verdict where both models have followed the sequence to its end."""
    overlap, n = overlapping_contacts(c.newton), c.newton.n_contacts
    if len(c.newton.column.balls) == 1:
        course = "there is no contact but that with the floor"
    elif overlap:
        verb = "happens" if 1 in (overlap, n) else "happen"
        course = f"{_share(overlap, n)} of the balls {verb} while another contact lasts"
    else:
        course = "one contact follows the other"
    if found.later:
        course += ", under one of the two a last one after the floor is met again"
    if found.error <= TOLERANCE:
        if overlap:
            return Verdict("by luck", f"Only by luck: {course}, and yet {found.clause}.")
        return Verdict("yes", f"Yes: {course}, and {found.clause}.")
    return Verdict("no", f"No: {course}{';' if overlap else ', and yet'} {found.clause}.")


def _share(overlap: int, n: int) -> str:
    if overlap < n:
        return f"{overlap} of {n} contacts"
    return "the contact" if n == 1 else "both contacts" if n == 2 else f"all {n} contacts"


def _difference(c: Comparison) -> _Difference:
    """What event-driven makes of the velocities at the end of the sequence."""
    if len(c.newton.column.balls) == 2 and c.newton.column.floor:
        return _of_separation(c)
    found = _of_velocities(c)
    counts = [_upper_contacts(result) for result in (c.newton, c.independent)]
    if found.error <= TOLERANCE or (counts[0] == counts[1]).all():
        return found
    later = _of_velocities(c, counts)
    return later if later.error <= TOLERANCE else found


def _of_separation(c: Comparison) -> _Difference:
    true, hard = c.newton.separation_velocity, c.independent.separation_velocity
    if math.isnan(true) or math.isnan(hard):
        who = "under Newton’s equations" if math.isnan(true) else "event-driven"
        return _Difference(math.nan, f"{who} the floor is met again before the balls part")
    return _stated("the separation velocity", hard, true, abs(true))


def _of_velocities(c: Comparison, counts: Sequence[NDArray[np.int64]] = ()) -> _Difference:
    """By the ball whose velocities differ most.

    Each is that with which the ball leaves its last contact, when that may be. A ball that one of the models leaves
    without any falls in the other, too, up to it. With ``counts``, the contacts of the upper pairs under both, the
    upper balls go on after the second floor contact until they have met as often as under the other model.
    """
    missing = [(counts[1 - i] - counts[i]).clip(0).tolist() for i in range(len(counts))] or [[], []]
    (moves, since), (hard, hard_since) = (
        r._core.parting(m) for r, m in zip((c.newton, c.independent), missing, strict=True)
    )
    delay = np.nan_to_num(hard_since - since)
    apart = hard - moves - c.newton.column.gravity * delay
    worst = int(np.argmax(np.abs(apart)))
    true = float(c.newton.final_velocities[worst])
    what = f"the final velocity of ball {worst + 1}"
    return _stated(what, true + float(apart[worst]), true, _speed(c.newton.column), later=bool(counts))


def _upper_contacts(result: Result) -> NDArray[np.int64]:
    """Contacts of the sequence between the balls above the lowest one, of each pair."""
    pair = result.contact_times[0][_of_balls(result)]
    return np.bincount(pair, minlength=len(result.column.balls))[2:]


def _stated(what: str, hard: float, true: float, scale: float, later: bool = False) -> _Difference:
    error = 0.0 if hard == true else abs(hard - true) / scale if scale > 0.0 else math.inf
    if error <= TOLERANCE:
        return _Difference(error, f"event-driven gets {what} right to {_percent(error)}", later)
    return _Difference(error, f"for {what} event-driven gives {_both(hard, true)}", later)


def _speed(column: Column) -> float:
    """The speed [m/s] that velocities are measured by: that of the impact, of a cradle the largest approach."""
    return column.impact_speed if column.floor else max(column.velocities) - min(column.velocities)


def _both(hard: float, true: float) -> str:
    """Two velocities with as many digits as needed to tell them apart."""
    for significant in range(3, 18):
        texts = [f"{value:.{significant}g}".replace("-", "−") for value in (hard, true)]
        if texts[0] != texts[1]:
            break
    return f"{texts[0]} m/s instead of {texts[1]} m/s"


def _percent(error: float) -> str:
    """An error in per cent with one digit, rounded up, so that it is never made smaller than it is."""
    percent = 100.0 * error
    if percent <= 0.001:
        return "0.001 %"
    unit = 10.0 ** math.floor(math.log10(percent))
    return f"{math.ceil(percent / unit * (1.0 - 1e-12)) * unit:.1g} %"
