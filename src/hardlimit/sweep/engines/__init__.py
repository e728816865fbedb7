"""Engines of a sweep: processor, GPU, cluster. To add an engine, add a module and a line here."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable
from dataclasses import dataclass
from typing import Any, Final, Protocol

from ..chunks import Chunks
from ..computation import Computation, Report, Values
from . import cpu, cuda, dask


class Compute(Protocol):
    """Compute each wanted chunk once, in any order, and yield it when it is finished.

    ``report`` may be called with the number of finished points of chunks that have not been yielded.
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
    """Accept every computation."""


@dataclass(frozen=True)
class Engine:
    """Properties of an engine."""

    compute: Compute
    #: Raises ValueError for an unsupported computation.
    check: Callable[[Any], None] = any_computation
    #: Whether it computes a grid as one chunk if there is no store.
    whole: bool = True
    #: Whether ``threads`` is per task (default 1) rather than for this machine (default: all).
    many_tasks: bool = False
    #: Whether it has a ``scheduler``.
    scheduled: bool = False


ENGINES: Final = {
    "cpu": Engine(cpu.compute),
    "cuda": Engine(cuda.compute, cuda.check),
    "dask": Engine(dask.compute, whole=False, many_tasks=True, scheduled=True),
}
