"""A statement of the paper: its text, its place, and the function that checks it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import NamedTuple

from .report import Agreement, Kind, Row
from .setup import Paper

#: The result of a check in words, and the conditions that must hold if the paper is right.
Outcome = tuple[str, *tuple[bool, ...]]
Check = Callable[[Paper], Outcome]


class Statement(NamedTuple):
    """A summary of a statement, its place in the paper, the figures whose data it needs, and its check."""

    text: str
    where: str
    figures: tuple[int, ...]  #: checked if all of these are computed; empty: in every run
    check: Check
    kind: Kind

    def row(self, paper: Paper) -> Row:
        """Check the statement."""
        result, *holds = self.check(paper)
        some: Agreement = "partly" if any(holds) else "misprint" if self.kind == "misprint" else "no"
        return Row(self.text, self.where, result, "yes" if all(holds) else some, self.kind)


class Statements(list[Statement]):
    """The statements of one figure or section, in the order of the paper."""

    def __init__(self, kind: Kind = "statement") -> None:
        self.kind = kind

    def add(self, text: str, where: str, *figures: int) -> Callable[[Check], Check]:
        """Decorator: the function checks this statement."""

        def register(check: Check) -> Check:
            self.append(Statement(text, where, figures, check, self.kind))
            return check

        return register

    def rows(
        self,
        paper: Paper,
        figures: Iterable[int] = (),
        progress: Callable[[float], object] = lambda part: None,
    ) -> list[Row]:
        """The rows of the statements that need at most these figures."""
        chosen = [s for s in self if set(s.figures) <= set(figures)]
        table = []
        for i, statement in enumerate(chosen):
            table.append(statement.row(paper))
            progress((i + 1) / len(chosen))
        return table


def near(value: float, wanted: float, within: float) -> bool:
    """Whether ``value`` is ``wanted`` ± ``within``; False for NaN."""
    return math.isfinite(value) and abs(value - wanted) <= within


def about(fraction: float) -> str:
    """A fraction that is known to a few per cent, rounded to 5 %, except exactly 0 and 1."""
    rounded = min(max(5 * round(20 * fraction), 5), 95)
    return f"{100 * fraction:.0f} %" if fraction in (0.0, 1.0) else f"about {rounded} %"
