"""Interface of a computation on a labelled grid of points, for stores, chunks and engines.

Stores, chunks and engines know nothing about columns of balls. ``plan.Plan`` is a computation; any other computation
can be stored, divided into chunks and sent to a cluster in the same way.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, Self

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import xarray as xr

#: Results of consecutive points by variable; points along the first dimension.
Values = dict[str, NDArray[Any]]

#: Called with the number of finished points.
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
    #: Names of its integer codes 0, 1, … (CF flags).
    flags: tuple[str, ...] = ()
    #: Type in a store (default: ``dtype``), and the value there before a point is computed.
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
        """Memory of one point [bytes]."""
        return np.dtype(self.dtype).itemsize * int(np.prod(self.shape, dtype=np.int64))


@dataclass(frozen=True)
class Coordinate:
    """Coordinate along one dimension, or a scalar coordinate (``dim`` None, one value)."""

    name: str
    dim: str | None
    values: NDArray[Any]
    unit: str
    meaning: str

    def as_variable(self) -> tuple[Any, Any, dict[str, Any]]:
        """Dimensions, values and attributes for xarray."""
        known = {"units": self.unit, "long_name": self.meaning}
        attributes = {name: text for name, text in known.items() if text}
        if self.dim is None:
            return (), self.values[0], attributes
        return self.dim, self.values, attributes


class Computation(Protocol):
    """A grid of points that can be computed range by range, in any process; picklable."""

    @property
    def dims(self) -> tuple[str, ...]:
        """Dimensions of the grid."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of points along each dimension."""

    @property
    def size(self) -> int:
        """Number of points; they are numbered in C order."""

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Coordinates of the grid and of further dimensions of the variables."""

    @property
    def results(self) -> Mapping[str, Variable]:
        """The variables in order."""

    @property
    def integrated(self) -> bool:
        """Whether points are integrated numerically, which takes about 100 µs rather than 1 µs."""

    def attributes(self) -> dict[str, Any]:
        """Attributes of the Dataset."""

    def fingerprint(self) -> str:
        """Hash of everything that results, coordinates and layout depend on."""

    def part(self, box: tuple[slice, ...]) -> Self:
        """A computation of some of the points, with only the data that they need."""

    def compute(self, first: int, count: int, threads: int, progress: Report | None = None) -> Values:
        """Points ``first`` … ``first + count − 1``; the bits do not depend on the range or the threads."""


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
    """The coordinates for xarray."""
    return {c.name: c.as_variable() for c in computation.coordinates}
