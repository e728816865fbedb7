"""A statement of the paper: its text, its place, and the function that checks it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import NamedTuple

from .report import Agreement, Kind, Row
from .setup import Paper


class Finding(NamedTuple):
    """The result of a check and its verdict."""

    result: str
    agrees: Agreement


Check = Callable[[Paper], Finding]


class Statement(NamedTuple):
    """A statement in our words, its place in the paper, the figures whose data it needs, and its check."""

    text: str
    where: str
    figures: tuple[int, ...]  #: checked if all of these are computed; empty: in every run
    check: Check


class Statements(list[Statement]):
    """The statements of one figure or section, in the order of the paper."""

    def add(self, text: str, where: str, *figures: int) -> Callable[[Check], Check]:
        """Decorator: the function checks this statement."""

        def register(check: Check) -> Check:
            self.append(Statement(text, where, figures, check))
            return check

        return register

    def rows(
        self,
        paper: Paper,
        figures: Iterable[int] = (),
        kind: Kind = "statement",
        progress: Callable[[float], object] = lambda part: None,
    ) -> list[Row]:
        """The rows of the statements that need no other than these figures."""
        chosen = [s for s in self if set(s.figures) <= set(figures)]
        table = []
        for i, s in enumerate(chosen):
            table.append(Row(s.text, s.where, *s.check(paper), kind))
            progress((i + 1) / len(chosen))
        return table


def verdict(*conditions: bool) -> Agreement:
    """``yes`` if all conditions hold, ``no`` if none does, else ``partly``."""
    return "yes" if all(conditions) else "partly" if any(conditions) else "no"


def near(value: float, wanted: float, within: float) -> bool:
    """Whether ``value`` is ``wanted`` ± ``within``; False for NaN."""
    return math.isfinite(value) and abs(value - wanted) <= within


def about(share: float) -> str:
    """A share that is known to a few per cent, rounded to 5 %, except exactly 0 and 1."""
    rounded = min(max(5 * round(20 * share), 5), 95)
    return f"{100 * share:.0f} %" if share in (0.0, 1.0) else f"about {rounded} %"
