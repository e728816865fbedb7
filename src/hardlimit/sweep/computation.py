"""What stores, chunks and engines know of the thing they compute: a labelled grid of points, each with results.

Nothing here or in them is about columns of balls. ``plan.Plan`` is such a computation; anything else that can say what
is below can be kept in a store, cut into chunks and sent to a cluster in the same way.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, Self

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import xarray as xr

#: Results of consecutive points by the name of the variable, the points along the first dimension.
Values = dict[str, NDArray[Any]]

#: Called with the number of points done so far.
Report = Callable[[int], object]


@dataclass(frozen=True)
class Variable:
    """One result of every point."""

    dtype: str
    unit: str
    meaning: str
    #: Dimensions of the result at one point, after those of the grid; usually none.
    dims: tuple[str, ...] = ()
    shape: tuple[int, ...] = ()
    #: Names of the integer codes that it holds (CF flags), from 0 on.
    flags: tuple[str, ...] = ()
    #: Type in a store, which is settled before the first point is computed, and what stands there until then.
    stored: str = ""
    not_computed: float = np.nan

    def attributes(self) -> dict[str, Any]:
        """CF attributes."""
        attributes: dict[str, Any] = {"units": self.unit, "long_name": self.meaning}
        if self.flags:
            attributes["flag_values"] = np.arange(len(self.flags), dtype=self.dtype)
            attributes["flag_meanings"] = " ".join(self.flags)
        return attributes

    @property
    def bytes_of_point(self) -> int:
        """Room for one point in memory."""
        return np.dtype(self.dtype).itemsize * int(np.prod(self.shape, dtype=np.int64))


@dataclass(frozen=True)
class Coordinate:
    """Labels along one dimension, or a single label of everything (``dim`` None, one value)."""

    name: str
    dim: str | None
    values: NDArray[Any]
    unit: str
    meaning: str

    def as_variable(self) -> tuple[Any, Any, dict[str, Any]]:
        """Dimensions, values and attributes as xarray takes them."""
        known = {"units": self.unit, "long_name": self.meaning}
        attributes = {name: text for name, text in known.items() if text}
        if self.dim is None:
            return (), self.values[0], attributes
        return self.dim, self.values, attributes


class Computation(Protocol):
    """A grid of points that can be computed one range after another, anywhere; it pickles."""

    @property
    def dims(self) -> tuple[str, ...]:
        """Dimensions of the grid."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of points along each of them."""

    @property
    def size(self) -> int:
        """Number of points; they are counted in C order."""

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Labels of the grid and of what the variables add to it."""

    @property
    def results(self) -> Mapping[str, Variable]:
        """What is computed, in the order in which it is shown."""

    @property
    def integrated(self) -> bool:
        """Whether a point takes some 100 µs of numerical integration rather than 1 µs."""

    def attributes(self) -> dict[str, Any]:
        """What is computed, in words; attributes of the Dataset."""

    def fingerprint(self) -> str:
        """The same for two computations only if they have the same results, labels and layout."""

    def part(self, box: tuple[slice, ...]) -> Self:
        """Some of the points, a computation of its own that carries no more than it needs."""

    def compute(self, first: int, count: int, threads: int, progress: Report | None = None) -> Values:
        """Points ``first`` … ``first + count − 1``; the same bits whoever computes them and with what neighbours."""


def dataset(computation: Computation, values: Values) -> xr.Dataset:
    """The results of all points as a labelled Dataset."""
    import xarray as xr

    data = {
        name: (
            (*computation.dims, *variable.dims),
            values[name].reshape((*computation.shape, *variable.shape)),
            variable.attributes(),
        )
        for name, variable in computation.results.items()
    }
    return xr.Dataset(data, labels(computation), computation.attributes())


def labels(computation: Computation) -> dict[str, tuple[Any, Any, dict[str, Any]]]:
    """The coordinates in the form that xarray takes."""
    return {c.name: c.as_variable() for c in computation.coordinates}
