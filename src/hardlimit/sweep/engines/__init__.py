"""Engines of a sweep: processor, GPU, cluster. To add an engine, add a module and a line here."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import Any, Final

from ..computation import Values
from . import cpu, cuda, dask


@dataclass(frozen=True)
class Engine:
    """Properties of an engine."""

    #: Takes (computation, chunks, wanted chunks, threads, report, scheduler). Computes each wanted chunk once, in any
    #: order, and yields it when it is finished. Calls ``report`` with the number of finished points not yet yielded.
    compute: Callable[..., Generator[tuple[int, Values], None, None]]
    #: Raises ValueError for an unsupported computation.
    check: Callable[[Any], None] = lambda computation: None
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
