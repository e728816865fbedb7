"""The figures of the paper, and all statements in the order of the report."""

from __future__ import annotations

from types import ModuleType
from typing import Final

from . import collisions, figure2, figure3, figure4, figure5, figure6, figure7, figure8
from .statement import Statements

#: The module of each figure has ``TITLE``; ``CHOICES``, which the paper leaves open, in one sentence; ``WEIGHT``, the
#: running time relative to Fig. 2; ``STATEMENTS``; ``parameters(paper)``, those that the figure does not vary;
#: ``compute(paper)``, its data; ``meaning(data)`` for event-driven simulations, in one sentence; and ``draw(data)``.
FIGURES: Final[dict[int, ModuleType]] = dict(
    enumerate((figure2, figure3, figure4, figure5, figure6, figure7, figure8), start=2)
)

STATEMENTS: Final = Statements()
STATEMENTS.extend(collisions.STATEMENTS)
for _figure in FIGURES.values():
    STATEMENTS.extend(_figure.STATEMENTS)
