"""What a statement of the paper is, and what the checks of several subjects share."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...column.scenario import Column
from ...sweep import sweep
from ..data import Data
from ..report import Agreement


class Finding(NamedTuple):
    """What came out, and whether it is what the paper states."""

    result: str
    agrees: Agreement


Check = Callable[[Data], Finding]


class Statement(NamedTuple):
    """A statement in our words, its place, the figures it belongs to, and how to check it."""

    text: str
    where: str
    figures: tuple[int, ...]  #: computed with any of these; empty: with every run
    check: Check


class Statements(list[Statement]):
    """The statements on one subject, in the order of the paper."""

    def add(self, text: str, where: str, *figures: int) -> Callable[[Check], Check]:
        """Make the function below the check of a statement."""

        def register(check: Check) -> Check:
            self.append(Statement(text, where, figures, check))
            return check

        return register


def verdict(*conditions: bool) -> Agreement:
    """Yes if all hold, no if none does, else partly."""
    return "yes" if all(conditions) else "partly" if any(conditions) else "no"


def near(value: float, wanted: float, within: float) -> bool:
    """Whether a value is what was wanted; NaN never is."""
    return math.isfinite(value) and abs(value - wanted) <= within


#: Rows across a map of Fig. 4 over which a share is a mean, and points along each, many because spikes are
#: narrow. With more of either the shares change by less than what :func:`about` rounds to.
ROWS: Final = 60
POINTS: Final = 3000


def about(part: float) -> str:
    """A share that is known to some per cent, rounded to 5 % but for 0 and 1."""
    rounded = min(max(5 * round(20 * part), 5), 95)
    return f"{100 * part:.0f} %" if part in (0.0, 1.0) else f"about {rounded} %"


def counts_over(column: Column, **axes: NDArray[np.float64]) -> NDArray[np.int64]:
    """The number of ball–ball contacts over two parameters."""
    swept: dict[str, Any] = dict(axes)
    return sweep(column, variables=["n_contacts"], **swept)["n_contacts"].values.astype(np.int64)
