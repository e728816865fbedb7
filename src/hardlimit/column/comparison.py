"""One column as instantaneous collisions and under Newton's equations: what differs, does it matter?"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, Literal, NamedTuple

import numpy as np

from .. import html
from ..models import ADIABATIC, MODELS
from .result import Result, quantities
from .scenario import Column
from .solvers import adiabatic, independent, newton

#: Differences of the final velocities up to this, relative, are taken as agreement.
TOLERANCE: Final = 0.01


class Verdict(NamedTuple):
    """May this drop be simulated event-driven?"""

    answer: Literal["yes", "by luck", "no", "undecided"]
    sentence: str


@dataclass(frozen=True)
class Comparison:
    """One column under all models that apply to it; ``adiabatic`` is None where it does not."""

    newton: Result
    independent: Result
    adiabatic: Result | None

    @property
    def results(self) -> tuple[Result, ...]:
        """The models in the order in which they are shown."""
        return tuple(r for r in (self.newton, self.adiabatic, self.independent) if r is not None)

    @property
    def verdict(self) -> Verdict:
        """Whether independent collisions do for this column, in one sentence."""
        return _verdict(self)

    def _repr_html_(self) -> str:
        columns = [quantities(result) for result in self.results]
        rows = [[row[0][0], *(html.number(value) for _, value in row)] for row in zip(*columns, strict=True)]
        rows.append(["outcome", *(result.outcome.split(":")[0] for result in self.results)])
        head = ["", *(MODELS[result.model].short for result in self.results)]
        return html.table("Newton’s equations and event-driven", head, rows, self.verdict.sentence)


def compare(column: Column) -> Comparison:
    """Solve the column under Newton's equations, independent collisions and, where it applies, Appendix A.

    Raises
    ------
    ValueError
        If ``column`` is not a Column.
    """
    fast, hard = newton(column), independent(column)
    return Comparison(fast, hard, adiabatic(column) if ADIABATIC.applies(column) else None)


def overlapping_contacts(result: Result) -> int:
    """Ball–ball contacts during which another contact lasts as well."""
    table = result.contacts
    pair, begin = table["pair"].values, table["begin"].values
    end = np.where(np.isnan(table["end"].values), math.inf, table["end"].values)
    return sum(
        bool(np.any((np.arange(len(pair)) != i) & (begin < end[i]) & (begin[i] < end)))
        for i in range(len(pair))
        if pair[i] > 0
    )


def _verdict(c: Comparison) -> Verdict:
    for name, result in (("Newton’s equations", c.newton), ("the event-driven model", c.independent)):
        if result.outcome != "ok":
            if name == "the event-driven model" and c.newton.outcome == "ok":
                return Verdict(
                    "no",
                    f"No: event-driven ends in “{result.outcome.split(':')[0]}”, Newton’s equations do not.",
                )
            return Verdict("undecided", f"No verdict: {name} ended in “{result.outcome.split(':')[0]}”.")
    error, difference = _difference(c)
    overlap, n = overlapping_contacts(c.newton), c.newton.n_contacts
    which = (
        "the contact"
        if n == 1
        else f"{'both' if n == 2 else f'all {n}'} contacts"
        if overlap == n
        else f"{overlap} of {n} contacts"
    )
    together = (
        f"{which} of the balls happen{'s' if n == 1 or overlap == 1 else ''} while another contact lasts"
    )
    if not error <= TOLERANCE:
        if overlap:
            return Verdict("no", f"No: {together}; {difference}.")
        return Verdict("no", f"No: one contact follows the other, and yet {difference}.")
    if overlap:
        return Verdict("by luck", f"Only by luck: {together}, and yet {difference}.")
    return Verdict("yes", f"Yes: one contact follows the other, and {difference}.")


def _difference(c: Comparison) -> tuple[float, str]:
    """The relative error of the event-driven model, and a clause that states it."""
    if len(c.newton.column.balls) == 2 and c.newton.column.floor:
        true, hard = c.newton.separation_velocity, c.independent.separation_velocity
        error = abs(hard - true) / abs(true) if true != 0.0 else math.inf
        numbers = f"{_short(hard)} m/s instead of {_short(true)} m/s"
        what = "the separation velocity"
    else:
        true_all, hard_all = c.newton.final_velocities, c.independent.final_velocities
        worst = int(np.argmax(np.abs(hard_all - true_all)))
        error = float(abs(hard_all[worst] - true_all[worst])) / c.newton.column.impact_speed
        numbers = f"{_short(hard_all[worst])} m/s instead of {_short(true_all[worst])} m/s"
        what = f"the final velocity of ball {worst + 1}"
    if error <= TOLERANCE:
        return error, f"event-driven gets {what} right to {_percent(error)}"
    return error, f"for {what} event-driven gives {numbers}"


def _short(value: float) -> str:
    return f"{value:.3g}".replace("-", "−")


def _percent(error: float) -> str:
    percent = 100.0 * error
    return "0.001 %" if percent < 0.001 else f"{percent:.1g} %"


def usual_damping(restitution: float, stiffness: float, effective_mass: float) -> float:
    """Damping γ [N s/m] by the formula in common use, ζ = −ln ε/√(π² + ln² ε), γ = 2 ζ √(k m_eff).

    It follows from a contact that ends when the bodies part, after a phase of attraction. A force that is
    never attractive lets go earlier, and the restitution comes out larger than asked for: that of
    ``LinearDashpot(stiffness=…, damping=usual_damping(…))`` is 0.5503 where 0.5 was asked for.
    """
    logarithm = abs(math.log(restitution))
    return 2.0 * logarithm / math.hypot(math.pi, logarithm) * math.sqrt(stiffness * effective_mass)
