"""``hl.compare``: comparison of event-driven collisions with Newton's equations for a column, with a verdict."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Final, Literal, NamedTuple, cast

from .. import _core
from ..support import html
from ..support.formatting import digits
from .models import ADIABATIC, MODELS
from .result import Result, quantities
from .scenario import Column
from .solvers import adiabatic, independent, newton

Answer = Literal["yes", "by luck", "no", "undecided"]
#: Largest relative difference of the velocities that counts as agreement.
TOLERANCE: Final = 0.01


class ColumnVerdict(NamedTuple):
    """Whether an event-driven simulation is good enough for a column; returned by :attr:`Comparison.verdict`."""

    answer: Answer  #: one word
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

    @cached_property
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


# --- the verdict --------------------------------------------------------------------------------------------

#: The reason of an answer that does not follow from the velocities, by its name in the core.
_REASONS: Final = {
    "newton_unclear": "No verdict: the outcome of Newton’s equations is “{newton}”.",
    "independent_unclear": "No verdict: the outcome of the event-driven model is “{independent}”.",
    "no_contact": "No verdict: the balls do not meet before the second floor contact.",
    "newton_at_rest": "No: under Newton’s equations a contact never ends, but event-driven collisions are "
    "instantaneous.",
    "collapse": "No: the event-driven sequence ends in an inelastic collapse, infinitely many collisions in a finite "
    "time; that of Newton’s equations does not.",
    "independent_at_rest": "No: the event-driven sequence comes to rest by infinitely many collisions in a finite "
    "time; that of Newton’s equations does not.",
    "only_newton_meets": "No: the balls meet under Newton’s equations but not in the event-driven model{before}.",
    "only_independent_meets": "No: the balls meet in the event-driven model but not under Newton’s equations{before}.",
}


def _verdict(c: Comparison) -> ColumnVerdict:
    comparison = _core.compare(c.newton._core, c.independent._core, TOLERANCE)
    answer = cast(Answer, comparison.answer)
    if comparison.ground not in _REASONS:
        return ColumnVerdict(answer, _by_numbers(c, comparison))
    outcomes = {r.model: r.outcome.split(":")[0] for r in (c.newton, c.independent)}
    before = " before the second floor contact" if c.newton.column.floor else ""
    return ColumnVerdict(answer, _REASONS[comparison.ground].format(before=before, **outcomes))


def _by_numbers(c: Comparison, comparison: _core.Comparison) -> str:
    """The sentence if both models reached the end of the sequence."""
    if len(c.newton.column.balls) == 1:
        contacts = "the only contact is that with the floor"
    else:
        contacts = _overlaps(comparison.overlapping, c.newton.n_contacts)
    if comparison.later:
        contacts += ", under one model the last one follows the second floor contact"
    clause = _clause(comparison)
    if comparison.answer == "no":
        return f"No: {contacts}{';' if comparison.overlapping else ', yet'} {clause}."
    return (
        f"Yes: {contacts}, and {clause}."
        if comparison.answer == "yes"
        else f"Only by luck: {contacts}, yet {clause}."
    )


def _clause(comparison: _core.Comparison) -> str:
    """Describes the error of the event-driven model."""
    if math.isnan(comparison.error):
        newton = comparison.ground == "newton_touches_again"
        model = "under Newton’s equations" if newton else "in the event-driven model"
        return f"{model} the second floor contact begins before the balls separate"
    what = "separation velocity" if comparison.ball < 0 else f"final velocity of ball {comparison.ball + 1}"
    if comparison.answer == "no":
        return f"the event-driven {what} is {_both(comparison.independent, comparison.newton)}"
    return f"the event-driven {what} is right to {_percent(comparison.error)}"


def _overlaps(overlap: int, n: int) -> str:
    """How many of the n contacts overlap another contact."""
    if not overlap:
        return "no contacts overlap in time"
    number = f"{overlap} of {n}" if overlap < n else {1: "the", 2: "both"}.get(n, f"all {n}")
    verb = "overlaps" if 1 in (overlap, n) else "overlap"
    return f"{number} ball–ball contact{'s' * (n > 1)} {verb} another contact in time"


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
