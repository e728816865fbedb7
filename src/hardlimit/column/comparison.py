"""``hl.compare``: comparison of event-driven collisions with Newton's equations for a column, with a verdict."""

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

#: Largest relative difference of the velocities that counts as agreement.
TOLERANCE: Final = 0.01


class ColumnVerdict(NamedTuple):
    """Whether an event-driven simulation is good enough for a column; returned by :attr:`Comparison.verdict`."""

    answer: Literal["yes", "by luck", "no", "undecided"]  #: one word
    sentence: str  #: the reason, with numbers


@dataclass(frozen=True)
class Comparison:
    """One column under all models that apply to it; returned by :func:`compare`."""

    newton: Result  #: Newton's equations
    independent: Result  #: instantaneous collisions
    adiabatic: Result | None  #: Appendix A; None if it does not apply

    @property
    def results(self) -> tuple[Result, ...]:
        """The results in the order in which they are shown."""
        return tuple(r for r in (self.newton, self.adiabatic, self.independent) if r is not None)

    @property
    def verdict(self) -> ColumnVerdict:
        """Whether independent collisions are good enough for this column, in one sentence."""
        return _verdict(self)

    def _repr_html_(self) -> str:
        columns = [quantities(result) for result in self.results]
        rows = [[row[0][0], *(digits(value) for _, value in row)] for row in zip(*columns, strict=True)]
        rows.append(["outcome", *(result.outcome.split(":")[0] for result in self.results)])
        head = ["", *(MODELS[result.model].short for result in self.results)]
        return html.table("Newton’s equations and event-driven", head, rows, self.verdict.sentence)


def compare(column: Column) -> Comparison:
    """Solve the column under Newton's equations, as independent collisions and, where it applies, by Appendix A.

    For two balls on a floor, the verdict compares the separation velocity. Otherwise it compares the velocities of the
    balls after their last contacts before the second floor contact (see :doc:`/definitions`).

    Parameters
    ----------
    column : Column

    Raises
    ------
    ValueError
        If ``column`` is not a Column.

    Examples
    --------
    >>> print(hl.compare(hl.Column.paper()).verdict.sentence)
    No: all 4 ball–ball contacts overlap another contact in time; the event-driven
    separation velocity is 3.73 m/s instead of 0.125 m/s.
    """
    fast, hard = newton(column), independent(column)
    return Comparison(fast, hard, adiabatic(column) if ADIABATIC.applies(column) else None)


def overlapping_contacts(result: Result) -> int:
    """Number of ball–ball contacts of the sequence that overlap another contact in time."""
    pair, begin, end = result.contact_times
    end = np.where(np.isnan(end), math.inf, end)
    return sum(
        bool(np.any((np.arange(len(pair)) != i) & (begin < end[i]) & (begin[i] < end)))
        for i in _of_balls(result)
    )


def _of_balls(result: Result) -> NDArray[np.int64]:
    """Indices of the ball–ball contacts of the sequence, in order of time."""
    return np.flatnonzero(result.contact_times[0])[: result.n_contacts]


# --- the verdict --------------------------------------------------------------------------------------------

#: Outcomes that are failures of the event-driven model.
_FAILURES: Final = {
    "collapse": "ends in an inelastic collapse, infinitely many collisions in a finite time",
    "at_rest": "comes to rest by infinitely many collisions in a finite time",
}


def _verdict(c: Comparison) -> ColumnVerdict:
    true, hard = (_core.outcome_names[r.outcome_code] for r in (c.newton, c.independent))
    unclear = _unclear(c, true, hard)
    if unclear is not None:
        return ColumnVerdict("undecided", f"No verdict: {unclear}.")
    if true == "at_rest":
        reason = (
            "under Newton’s equations a contact never ends, but event-driven collisions are instantaneous"
        )
        return ColumnVerdict("no", f"No: {reason}.")
    if hard in _FAILURES:
        reason = f"the event-driven sequence {_FAILURES[hard]}; that of Newton’s equations does not"
        return ColumnVerdict("no", f"No: {reason}.")
    found = _difference(c)
    counts = [r.n_contacts for r in (c.newton, c.independent)]
    if 0 in counts and any(counts) and not found.error <= TOLERANCE:
        models = ["under Newton’s equations", "in the event-driven model"]
        met, missed = models if counts[0] else models[::-1]
        before = " before the second floor contact" if c.newton.column.floor else ""
        return ColumnVerdict("no", f"No: the balls meet {met} but not {missed}{before}.")
    return _by_numbers(c, found)


def _unclear(c: Comparison, true: str, hard: str) -> str | None:
    """The reason why the models cannot be compared; None if they can."""
    models = (("Newton’s equations", true, c.newton), ("the event-driven model", hard, c.independent))
    for model, name, result in models:
        if name in ("invalid", "unresolved", "never_lands", "too_deep"):
            return f"the outcome of {model} is “{result.outcome.split(':')[0]}”"
    if true == hard == "no_contact" and len(c.newton.column.balls) > 1:
        return "the balls do not meet before the second floor contact"
    return None


class _Difference(NamedTuple):
    error: float  #: relative error of the event-driven model; NaN if a model has no such value
    clause: str  #: describes the error in a sentence
    later: bool = False  #: whether contacts of the upper balls after the second floor contact count


def _by_numbers(c: Comparison, found: _Difference) -> ColumnVerdict:
    """The verdict if both models reached the end of the sequence."""
    overlap = overlapping_contacts(c.newton)
    if len(c.newton.column.balls) == 1:
        contacts = "the only contact is that with the floor"
    else:
        contacts = _overlaps(overlap, c.newton.n_contacts)
    if found.later:
        contacts += ", under one model the last one follows the second floor contact"
    if found.error <= TOLERANCE:
        if overlap:
            return ColumnVerdict("by luck", f"Only by luck: {contacts}, yet {found.clause}.")
        return ColumnVerdict("yes", f"Yes: {contacts}, and {found.clause}.")
    return ColumnVerdict("no", f"No: {contacts}{';' if overlap else ', yet'} {found.clause}.")


def _overlaps(overlap: int, n: int) -> str:
    """How many of the n contacts overlap another contact."""
    if not overlap:
        return "no contacts overlap in time"
    number = f"{overlap} of {n}" if overlap < n else {1: "the", 2: "both"}.get(n, f"all {n}")
    verb = "overlaps" if 1 in (overlap, n) else "overlap"
    return f"{number} ball–ball contact{'s' * (n > 1)} {verb} another contact in time"


def _difference(c: Comparison) -> _Difference:
    """Difference of the velocities at the end of the sequence."""
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
        model = "under Newton’s equations" if math.isnan(true) else "in the event-driven model"
        return _Difference(math.nan, f"{model} the second floor contact begins before the balls separate")
    return _stated("separation velocity", hard, true, abs(true))


def _of_velocities(c: Comparison, counts: Sequence[NDArray[np.int64]] = ()) -> _Difference:
    """Difference for the ball whose velocities differ most.

    The velocity of each ball after its last contact is compared in the freely falling frame, so that the change of
    velocity by gravity between the ends of this contact under both models does not count (there is none for a ball
    without contacts under one model). ``counts`` are the numbers of contacts of the upper pairs under both models. If
    they are given, the upper balls continue after the second floor contact until they have met as often as under the
    other model.
    """
    missing = [(counts[1 - i] - counts[i]).clip(0).tolist() for i in range(len(counts))] or [[], []]
    (moves, since), (hard, hard_since) = (
        r._core.parting(m) for r, m in zip((c.newton, c.independent), missing, strict=True)
    )
    delay = np.nan_to_num(hard_since - since)
    apart = hard - moves - c.newton.column.gravity * delay
    worst = int(np.argmax(np.abs(apart)))
    true = float(c.newton.final_velocities[worst])
    what = f"final velocity of ball {worst + 1}"
    return _stated(what, true + float(apart[worst]), true, _speed(c.newton.column), later=bool(counts))


def _upper_contacts(result: Result) -> NDArray[np.int64]:
    """Number of contacts of the sequence for each pair above the lowest ball."""
    pair = result.contact_times[0][_of_balls(result)]
    return np.bincount(pair, minlength=len(result.column.balls))[2:]


def _stated(what: str, hard: float, true: float, scale: float, later: bool = False) -> _Difference:
    error = 0.0 if hard == true else abs(hard - true) / scale if scale > 0.0 else math.inf
    if error <= TOLERANCE:
        return _Difference(error, f"the event-driven {what} is right to {_percent(error)}", later)
    return _Difference(error, f"the event-driven {what} is {_both(hard, true)}", later)


def _speed(column: Column) -> float:
    """Reference speed [m/s] of errors: the impact speed, for a cradle the largest difference of velocities."""
    return column.impact_speed if column.floor else max(column.velocities) - min(column.velocities)


def _both(hard: float, true: float) -> str:
    """Two velocities with as many digits as needed to differ."""
    for significant in range(3, 18):
        texts = [f"{value:.{significant}g}".replace("-", "−") for value in (hard, true)]
        if texts[0] != texts[1]:
            break
    return f"{texts[0]} m/s instead of {texts[1]} m/s"


def _percent(error: float) -> str:
    """An error in per cent with one digit, rounded up."""
    percent = 100.0 * error
    if percent <= 0.001:
        return "0.001 %"
    unit = 10.0 ** math.floor(math.log10(percent))
    return f"{math.ceil(percent / unit * (1.0 - 1e-12)) * unit:.1g} %"
