"""The results of a sweep in arrays; what ``store.Store`` is on disk. And how much fits."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from .chunks import Chunks
from .computation import Computation, Values, dataset

if TYPE_CHECKING:
    import xarray as xr

#: Chunks of a store at most: each is a file of every variable.
MOST_CHUNKS: Final = 1 << 22

#: Where Linux says how much a process may still take, and the limit of its container.
AVAILABLE: Final = Path("/proc/meminfo")
CONTAINER: Final = Path("/sys/fs/cgroup/memory.max")


class Memory:
    """The chunks of one sweep."""

    def __init__(self, computation: Computation, chunks: Chunks) -> None:
        self.computation, self.chunks = computation, chunks
        self.values: Values = {}

    def missing(self) -> list[int]:
        """Chunks that are not there yet: all."""
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
            elif some.dtype.itemsize > whole.dtype.itemsize:  # the first counts above 255
                whole = whole.astype(some.dtype)
            self.values[name] = whole
            whole[first : first + count] = some

    def dataset(self) -> xr.Dataset:
        """All results."""
        return dataset(self.computation, self.values)


def insist_on_room(computation: Computation, chunks: Chunks, in_store: bool) -> None:
    """Refuse at once what could not end: results that do not fit in memory, or chunks without number.

    Raises
    ------
    ValueError
        With the room that the results would take.
    """
    each = sum(variable.bytes_of_point for variable in computation.results.values())
    points, taken = computation.size, f"{_shown_bytes(computation.size * each)} of results"
    if in_store:
        most = MOST_CHUNKS * (points // chunks.number or 1)
        if chunks.number > MOST_CHUNKS:
            raise ValueError(f"points: got {points:.3g}, {taken}, must be <= {most:.2g} in one store")
        return
    room = available_memory()
    if points * each > room:
        need = f"must fit in the {_shown_bytes(room)} of free memory; store= keeps them on disk, variables= keeps fewer"
        raise ValueError(f"points: got {points:.3g}, {taken}, {need}")


def available_memory() -> int:
    """Bytes that this process may still take; all there is where the system does not tell."""
    known = []
    with suppress(OSError, ValueError, StopIteration):
        lines = AVAILABLE.read_text().splitlines()
        known.append(1024 * int(next(line for line in lines if line.startswith("MemAvailable")).split()[1]))
    with suppress(OSError, ValueError):  # "max": none
        known.append(int(CONTAINER.read_text()))
    if not known and hasattr(os, "sysconf"):
        with suppress(OSError, ValueError):
            known.append(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    return min(known, default=1 << 47)  # the address space of a process


def _shown_bytes(count: float) -> str:
    for unit in ("B", "kB", "MB", "GB", "TB"):
        if count < 1000.0:
            return f"{count:.3g} {unit}"
        count /= 1000.0
    return f"{count:.3g} PB"
