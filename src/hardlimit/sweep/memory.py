"""Storage of a sweep in memory, with the interface of ``store.Store``, and the check of the size of the results."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from ..support import machine
from ..support.formatting import size
from .chunks import Chunks
from .computation import Computation, Values, dataset

if TYPE_CHECKING:
    import xarray as xr

#: Largest number of chunks of a store; each is a file for every variable.
MAX_CHUNKS: Final = 1 << 22


class Memory:
    """The chunks of one sweep."""

    def __init__(self, computation: Computation, chunks: Chunks) -> None:
        self.computation, self.chunks = computation, chunks
        self.values: Values = {}

    def missing(self) -> list[int]:
        """Missing chunks: all."""
        return list(range(len(self.chunks)))

    def write(self, chunk: int, values: Values) -> None:
        """Keep a chunk."""
        first, count = self.chunks.span(chunk)
        if count == self.computation.size:
            self.values = values
            return
        for name, some in values.items():
            whole = self.values.get(name)
            if whole is None:
                whole = np.empty((self.computation.size, *some.shape[1:]), some.dtype)
            elif some.dtype.itemsize > whole.dtype.itemsize:  # the first chunk with counts above 255
                whole = whole.astype(some.dtype)
            self.values[name] = whole
            whole[first : first + count] = some

    def dataset(self) -> xr.Dataset:
        """All results."""
        return dataset(self.computation, self.values)


def check_size(computation: Computation, chunks: Chunks, in_store: bool) -> None:
    """Refuse results that do not fit in memory, or too many chunks for a store.

    Raises a ValueError with the size of the results.
    """
    points = computation.size
    needed = points * sum(variable.bytes_of_point for variable in computation.results.values())
    got = f"points: got {points:.3g}, {size(needed)} of results"
    if in_store and chunks.number > MAX_CHUNKS:
        most = MAX_CHUNKS * (points // chunks.number or 1)
        raise ValueError(f"{got}, must be <= {most:.2g} in one store")
    if not in_store and needed > (free := machine.free_memory()):
        need = f"must fit in the {size(free)} of free memory"
        raise ValueError(f"{got}, {need}; store= keeps them on disk, variables= keeps fewer")
