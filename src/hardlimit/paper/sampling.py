"""Sampling over one parameter: contacts of many drops, points gathered where their number jumps."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..column.result import Result
from ..column.scenario import Column
from ..column.solvers import newton
from ..sweep import sweep

Array = NDArray[np.float64]
Counts = NDArray[np.int64]

SECONDS: Final = {"units": "s", "long_name": "time after the first floor touch"}


def refine(
    count: Callable[[Array], Counts], values: Array, tolerance: float = 1e-9, logarithmic: bool = False
) -> tuple[Array, Counts]:
    """Halve every interval over which the count changes until it is narrower than ``tolerance`` (relative).

    Returns all values at which the count was taken, ascending, and the counts: between two neighbours that
    differ lies a jump, known to ``tolerance``, and the halving leaves points that crowd towards it.
    """
    x = np.unique(np.asarray(values, dtype=np.float64))
    n = count(x)
    for _ in range(200):
        wide = np.diff(x) > tolerance * np.abs(x[1:])
        at = np.flatnonzero((np.diff(n) != 0) & wide)
        if at.size == 0:
            break
        middle = np.sqrt(x[at] * x[at + 1]) if logarithmic else 0.5 * (x[at] + x[at + 1])
        x, n = np.insert(x, at + 1, middle), np.insert(n, at + 1, count(middle))
    return x, n


def jumps(values: Array, counts: Counts) -> list[tuple[float, int, int]]:
    """(position, count below, count above) of every jump of a refined sampling."""
    at = np.flatnonzero(np.diff(counts))
    return [(float(0.5 * (values[i] + values[i + 1])), int(counts[i]), int(counts[i + 1])) for i in at]


def counts_of(column: Column, name: str, model: str = "newton", **fixed: float) -> Callable[[Array], Counts]:
    """The number of ball–ball contacts as a function of an array of values of one parameter."""

    def count(values: Array) -> Counts:
        swept: dict[str, Any] = {name: values, **fixed}
        found = sweep(column, model=model, variables=["n_contacts"], **swept)
        return found["n_contacts"].values.astype(np.int64)

    return count


def sequences(
    name: str,
    values: Array,
    column: Callable[[float], Column],
    solve: Callable[[Column], Result] = newton,
    prefix: str = "",
) -> xr.Dataset:
    """Begin and end of every ball–ball contact, for each value; shorter sequences are filled up with NaN."""
    begins, ends, floors, finals = [], [], [], []
    for value in values:
        result = solve(column(float(value)))
        table = result.contacts
        ball_ball = table["pair"].values == 1
        begins.append(table["begin"].values[ball_ball])
        ends.append(table["end"].values[ball_ball])
        floors.append(result.t_floor_end)
        finals.append(result.t_end)
    rows = (name, f"{prefix}contact")
    return xr.Dataset(
        {
            f"{prefix}begin": (rows, _padded(begins), SECONDS),
            f"{prefix}end": (rows, _padded(ends), SECONDS),
            f"{prefix}n_contacts": (name, np.array([b.size for b in begins]), {"units": "1"}),
            f"{prefix}t_floor_end": (
                name,
                np.array(floors),
                SECONDS | {"long_name": "end of the floor contact"},
            ),
            f"{prefix}t_end": (name, np.array(finals), SECONDS | {"long_name": "end of the sequence, t_f"}),
        },
        coords={name: (name, np.asarray(values), {"units": "1", "long_name": "coefficient of restitution"})},
    )


def _padded(rows: list[Array]) -> Array:
    table = np.full((len(rows), max(1, *(r.size for r in rows))), np.nan)
    for i, row in enumerate(rows):
        table[i, : row.size] = row
    return table


def late_contacts(name: str, data: xr.Dataset, prefix: str = "") -> list[tuple[float, float]]:
    """Intervals of the parameter in which the last contact begins after the floor contact (the spikes)."""
    last = data[f"{prefix}begin"].max(f"{prefix}contact")
    late = (last > data[f"{prefix}t_floor_end"]).values
    x: Any = data[name].values
    edges = np.flatnonzero(np.diff(np.concatenate([[False], late, [False]]).astype(int)))
    return [(float(x[i]), float(x[j - 1])) for i, j in zip(edges[::2], edges[1::2], strict=True)]


def maxima(counts: Counts) -> int:
    """Number of separate local maxima of a sequence of counts (a plateau is one)."""
    runs = counts[np.flatnonzero(np.diff(counts, prepend=counts[0] - 1))]
    padded = np.concatenate([[-1], runs, [-1]])
    return int(np.sum((padded[1:-1] > padded[:-2]) & (padded[1:-1] > padded[2:])))


#: One axis of a share: the points, and whether equal factors count alike rather than equal differences.
Axis = tuple[Array, bool]


def share(holds: NDArray[np.bool_], *axes: Axis) -> float:
    """Part of a line, or of the area of a map, on which a condition holds; one axis for each dimension.

    Each point stands for the stretch of its axis that is nearest to it, so that the share does not depend on
    where the points crowd.
    """
    weights = np.ones(())
    for points, logarithmic in axes:
        weights = np.multiply.outer(weights, _stretches(np.log(points) if logarithmic else points))
    return float(np.sum(weights[holds]) / np.sum(weights))


def _stretches(x: Array) -> Array:
    """The length nearest to each of the ascending points, between the first and the last."""
    borders = np.concatenate([x[:1], 0.5 * (x[1:] + x[:-1]), x[-1:]])
    return np.diff(borders)


def middles(low: float, high: float, number: int, logarithmic: bool = False) -> Array:
    """The middles of ``number`` equal parts of an axis: the mean over them is a mean over the axis."""
    if logarithmic:
        return np.exp(middles(math.log(low), math.log(high), number))
    return low + (high - low) * (np.arange(number) + 0.5) / number
