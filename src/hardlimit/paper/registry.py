"""The figures of the paper, and all statements in the order of the report."""

from __future__ import annotations

from typing import Final, Protocol

import xarray as xr
from matplotlib.figure import Figure as Picture

from . import collisions, figure2, figure3, figure4, figure5, figure6, figure7, figure8
from .setup import Paper
from .statement import Statements


class Figure(Protocol):
    """Interface of the module of a figure: data, drawing and statements."""

    @property
    def TITLE(self) -> str: ...

    @property
    def CHOICES(self) -> str:
        """The choices that the paper leaves open, in one sentence."""

    @property
    def WEIGHT(self) -> float:
        """Approximate running time relative to Fig. 2, for the progress bar."""

    @property
    def STATEMENTS(self) -> Statements: ...

    def parameters(self, paper: Paper) -> dict[str, str | float]:
        """The parameters that the figure does not vary."""

    def compute(self, paper: Paper) -> xr.Dataset:
        """The data of the figure; ``attrs["choices"]`` replaces ``CHOICES``."""

    def meaning(self, data: xr.Dataset) -> str:
        """The meaning of the figure for event-driven simulations, in one sentence."""

    def draw(self, data: xr.Dataset) -> Picture:
        """The picture, without its caption."""


FIGURES: Final[dict[int, Figure]] = {
    2: figure2,
    3: figure3,
    4: figure4,
    5: figure5,
    6: figure6,
    7: figure7,
    8: figure8,
}

STATEMENTS: Final = Statements()
STATEMENTS.extend(collisions.STATEMENTS)
for _figure in FIGURES.values():
    STATEMENTS.extend(_figure.STATEMENTS)
