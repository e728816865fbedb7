"""What the paper states, each computed and judged from the numbers; no verdict is written down beforehand.

A module for each subject; ``statement`` says what a statement is.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from ..data import Data
from ..report import Row
from . import adiabatic, collisions, counts, dissipation, gaps, materials, sequence
from .statement import Statement

__all__ = ["STATEMENTS", "rows"]

#: In the order of the paper.
STATEMENTS: Final[tuple[Statement, ...]] = (
    *collisions.STATEMENTS,
    *sequence.STATEMENTS,
    *adiabatic.STATEMENTS,
    *counts.STATEMENTS,
    *gaps.STATEMENTS,
    *dissipation.STATEMENTS,
    *materials.STATEMENTS,
)


def rows(
    data: Data, figures: tuple[int, ...], progress: Callable[[float], object] = lambda part: None
) -> list[Row]:
    """The rows of all statements that belong to ``figures``, in the order of the paper."""
    chosen = [s for s in STATEMENTS if set(s.figures) <= set(figures)]
    table = []
    for i, s in enumerate(chosen):
        table.append(Row(s.text, s.where, *s.check(data)))
        progress((i + 1) / len(chosen))
    return table
