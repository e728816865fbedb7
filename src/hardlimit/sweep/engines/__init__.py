"""Where a sweep computes: this processor, a GPU, a cluster. A new engine is one file and one line here."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable
from dataclasses import dataclass
from typing import Any, Final, Protocol

from ..chunks import Chunks
from ..computation import Computation, Report, Values
from . import cpu, cuda, dask


class Compute(Protocol):
    """Computes each of the wanted chunks once, in any order, and hands it over when it is finished.

    ``report`` takes the points done of the chunks not yet handed over; to call it is optional.
    """

    def __call__(
        self,
        computation: Any,
        chunks: Chunks,
        wanted: Iterable[int],
        threads: int,
        report: Report,
        scheduler: Any,
    ) -> Generator[tuple[int, Values], None, None]: ...


def any_computation(_: Computation) -> None:
    """An engine that takes whatever can be computed."""


@dataclass(frozen=True)
class Engine:
    """What ``hl.sweep`` knows of an engine."""

    compute: Compute
    #: Raises ValueError for a computation that the engine does not take.
    check: Callable[[Any], None] = any_computation
    #: Whether it takes whole grids: the others get them in chunks, also without a store.
    whole: bool = True
    #: Whether ``threads`` are those of a task (one unless given) rather than of this machine (all unless given).
    many_tasks: bool = False
    #: Whether it takes a ``scheduler``.
    scheduled: bool = False


ENGINES: Final = {
    "cpu": Engine(cpu.compute),
    "cuda": Engine(cuda.compute, cuda.check),
    "dask": Engine(dask.compute, whole=False, many_tasks=True, scheduled=True),
}
