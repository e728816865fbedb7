"""Sweep on the processors of this machine, with threads of the core."""

from __future__ import annotations

from collections.abc import Generator, Iterable
from typing import Any

from ..chunks import Chunks
from ..computation import Computation, Report, Values


def compute(
    computation: Computation,
    chunks: Chunks,
    wanted: Iterable[int],
    threads: int,
    report: Report,
    scheduler: Any = None,
) -> Generator[tuple[int, Values], None, None]:
    """Yield each wanted chunk, one after the other."""
    for chunk in wanted:
        yield chunk, computation.compute(*chunks.span(chunk), threads, report)
