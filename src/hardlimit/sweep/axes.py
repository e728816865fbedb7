"""Axes of a sweep: values, dimensions and coordinates of the swept parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..support import validation
from .computation import Coordinate
from .parameters import Parameter
from .variables import BALL, VARIABLES


class Axes:
    """The swept parameters in the order given.

    Attributes
    ----------
    sizes : dict
        Number of points along each dimension.
    coordinates : list of Coordinate
        One for each swept name, and the coordinates of DataArrays.
    """

    def __init__(self, swept: Mapping[str, Any], known: Mapping[str, Parameter]) -> None:
        self.sizes: dict[str, int] = {}
        self.coordinates: list[Coordinate] = []
        #: Coordinates of each dimension, and the parameter that has them.
        self._labels: dict[str, tuple[str, NDArray[Any]]] = {}
        for name, values in swept.items():
            if name not in known:
                raise ValueError(f"{name}: unknown, a sweep takes {', '.join(known)}")
            self._add(known[name], values)
        self._check_names()
        self._keep_labels()

    def strides(self) -> dict[str, int]:
        """Number of points between neighbours along each dimension."""
        sizes = list(self.sizes.values())
        return {dim: math.prod(sizes[i + 1 :]) for i, dim in enumerate(self.sizes)}

    def _add(self, parameter: Parameter, labelled: Any) -> None:
        name = parameter.name
        values = validation.array(name, labelled, **parameter.limits)
        dim = _dimension(name, labelled) if values.ndim else None
        if dim is not None:
            size = self.sizes.setdefault(dim, len(values))
            if size != len(values):
                raise ValueError(f"{name}: got {len(values)} values, must be {size} like dimension {dim!r}")
            self._compare_labels(name, dim, labelled)
        values = np.atleast_1d(values)
        self.coordinates.append(Coordinate(name, dim, values, parameter.unit, parameter.meaning))

    def _compare_labels(self, name: str, dim: str, values: Any) -> None:
        """Refuse different coordinates along a shared dimension: points are paired by position."""
        coords = getattr(values, "coords", {})
        if dim not in coords:
            return
        labels = np.asarray(coords[dim].values)
        first, known = self._labels.setdefault(dim, (name, labels))
        if not np.array_equal(labels, known):
            need = f"must have the coordinates of {first} along dimension {dim!r}, or none"
            raise ValueError(f"{name}: got other coordinates, {need}")

    def _check_names(self) -> None:
        """Refuse a dimension with the name of anything in the Dataset but the parameter swept along it."""
        dim_of = {c.name: c.dim for c in self.coordinates if c.dim is not None}
        single = {c.name for c in self.coordinates if c.dim is None}
        for name, dim in dim_of.items():
            if dim in VARIABLES or dim == BALL or dim in single or dim_of.get(dim, dim) != dim:
                raise ValueError(f"{name}: got dimension {dim!r}, must differ from other names in the result")

    def _keep_labels(self) -> None:
        swept = {c.name for c in self.coordinates}
        for dim, (_, labels) in self._labels.items():
            if dim not in swept and labels.dtype.kind in "iuf":
                self.coordinates.append(Coordinate(dim, dim, labels, "", ""))


def _dimension(name: str, values: Any) -> str:
    """The dimension of a DataArray; otherwise the name of the parameter."""
    dims = getattr(values, "dims", None)
    return name if dims is None else str(dims[0])
