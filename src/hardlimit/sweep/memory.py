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
MOST_CHUNKS: Final = 1 << 22


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


def insist_on_room(computation: Computation, chunks: Chunks, in_store: bool) -> None:
    """Refuse results that do not fit in memory, or too many chunks for a store.

    Raises a ValueError with the size of the results.
    """
    each = sum(variable.bytes_of_point for variable in computation.results.values())
    points, taken = computation.size, f"{size(computation.size * each)} of results"
    if in_store:
        most = MOST_CHUNKS * (points // chunks.number or 1)
        if chunks.number > MOST_CHUNKS:
            raise ValueError(f"points: got {points:.3g}, {taken}, must be <= {most:.2g} in one store")
        return
    room = machine.free_memory()
    if points * each > room:
        need = (
            f"must fit in the {size(room)} of free memory; store= keeps them on disk, variables= keeps fewer"
        )
        raise ValueError(f"points: got {points:.3g}, {taken}, {need}")
