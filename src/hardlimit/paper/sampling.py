"""Sampling over one parameter or two: contacts of many drops, refinement at jumps, fractions of an axis or a map."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..column.result import Result
from ..column.scenario import Column
from ..column.solvers import newton
from ..sweep import sweep

Array = NDArray[np.float64]
Counts = NDArray[np.int64]


def variable(
    dims: str | tuple[str, ...], values: Any, units: str, long_name: str = "time after the first floor touch"
) -> tuple[Any, ...]:
    """A variable of a Dataset with its unit and meaning."""
    return dims, values, {"units": units, "long_name": long_name}


def refine(
    count: Callable[[Array], Counts], values: Array, tolerance: float = 1e-9, logarithmic: bool = False
) -> Array:
    """Halve every interval over which the count changes until it is narrower than ``tolerance`` (relative).

    Returns all sampled values in ascending order. Each jump is bracketed to ``tolerance``, and the points become denser
    towards it.
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
    return x


def counts_over(column: Column, model: str = "newton", **swept: Array) -> Counts:
    """The number of ball–ball contacts over one or two parameters."""
    axes: dict[str, Any] = dict(swept)
    return sweep(column, model=model, variables=["n_contacts"], **axes)["n_contacts"].values.astype(np.int64)


def counts_of(column: Column, name: str, model: str = "newton") -> Callable[[Array], Counts]:
    """The number of ball–ball contacts as a function of an array of values of one parameter."""
    return lambda values: counts_over(column, model, **{name: values})


def sequences(
    name: str,
    values: Array,
    column: Callable[[float], Column],
    solve: Callable[[Column], Result] = newton,
    prefix: str = "",
) -> xr.Dataset:
    """Begin and end of every ball–ball contact for each value; shorter sequences are padded with NaN."""
    results = [solve(column(float(value))) for value in values]
    spans = [ball_contacts(result) for result in results]
    rows = (name, f"{prefix}contact")
    floor_ends, ends = ([getattr(r, what) for r in results] for what in ("t_floor_end", "t_end"))
    return xr.Dataset(
        {
            f"{prefix}begin": variable(rows, _padded([begin for begin, _ in spans]), "s"),
            f"{prefix}end": variable(rows, _padded([end for _, end in spans]), "s"),
            f"{prefix}n_contacts": (name, np.array([begin.size for begin, _ in spans]), {"units": "1"}),
            f"{prefix}t_floor_end": variable(name, np.array(floor_ends), "s", "end of the floor contact"),
            f"{prefix}t_end": variable(name, np.array(ends), "s", "end of the sequence, t_f"),
        },
        coords={name: variable(name, np.asarray(values), "1", "coefficient of restitution")},
    )


def ball_contacts(result: Result) -> tuple[Array, Array]:
    """Begin and end [s] of every ball–ball contact of a drop."""
    table = result.contacts
    ball_ball = table["pair"].values == 1
    return table["begin"].values[ball_ball], table["end"].values[ball_ball]


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


def successive(counts: Counts) -> Counts:
    """The counts without consecutive repetitions."""
    return counts[np.flatnonzero(np.diff(counts, prepend=counts[0] - 1))]


def maxima(counts: Counts) -> int:
    """Number of separate local maxima of a sequence of counts; a plateau is one."""
    padded = np.concatenate([[-1], successive(counts), [-1]])
    return int(np.sum((padded[1:-1] > padded[:-2]) & (padded[1:-1] > padded[2:])))


#: One axis: its points, and whether it is logarithmic.
Axis = tuple[Array, bool]


def fraction(holds: NDArray[np.bool_], *axes: Axis) -> float:
    """Fraction of an axis, or of the area of a map, on which a condition holds.

    Each point is weighted by the part of the axis that is nearest to it, so that the fraction does not depend on the
    density of points.
    """
    weights = np.ones(())
    for points, logarithmic in axes:
        x = np.log(points) if logarithmic else points
        borders = np.concatenate([x[:1], 0.5 * (x[1:] + x[:-1]), x[-1:]])
        weights = np.multiply.outer(weights, np.diff(borders))
    return float(np.sum(weights[holds]) / np.sum(weights))


def middles(low: float, high: float, number: int, logarithmic: bool = False) -> Array:
    """The middles of ``number`` equal parts of an axis. A mean over them is a mean over the axis."""
    if logarithmic:
        return np.exp(middles(math.log(low), math.log(high), number))
    return low + (high - low) * (np.arange(number) + 0.5) / number


def bisect(
    low: float, high: float, belongs_low: Callable[[float], bool], width: float
) -> tuple[float, float]:
    """Halve [low, high] until it is narrower than ``width``; ``belongs_low`` changes from true to false in it."""
    while high - low > width:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if belongs_low(middle) else (low, middle)
    return low, high
