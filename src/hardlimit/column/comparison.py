"""One column as instantaneous collisions and under Newton's equations: what differs, does it matter?"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .result import Result
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


def compare(column: Column) -> Comparison:
    """Solve the column under Newton's equations, independent collisions and, where it applies, Appendix A."""
    linear = all(law.record["name"] == "linear" for law in column.laws)
    applies = column.floor and len(column.balls) == 2 and linear
    return Comparison(newton(column), independent(column), adiabatic(column) if applies else None)


def time_after_contacts(result: Result) -> float:
    """The first instant [s] after the last contact found; NaN if a contact never ends or nothing happened."""
    end = result.contacts["end"].values
    return float(end.max()) if end.size else math.nan


def final_velocities(result: Result) -> NDArray[np.float64]:
    """Velocities [m/s] after the last contact, bottom first; NaN if a contact never ends."""
    after = time_after_contacts(result)
    if math.isnan(after):
        return np.full(len(result.column.balls), math.nan)
    return np.asarray(result.trajectory([after])["velocity"].values[0])


def rebound_heights(result: Result) -> NDArray[np.float64]:
    """Height of each centre [m] at the top of its flight after the last contact, if nothing gets in its way.

    NaN for a ball that does not rise then, and without gravity.
    """
    after, g = time_after_contacts(result), result.column.gravity
    if math.isnan(after) or not g > 0.0:
        return np.full(len(result.column.balls), math.nan)
    state = result.trajectory([after])
    z, v = state["position"].values[0], state["velocity"].values[0]
    return np.where(v > 0.0, z + v**2 / (2.0 * g), math.nan)


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
        true_all, hard_all = final_velocities(c.newton), final_velocities(c.independent)
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
