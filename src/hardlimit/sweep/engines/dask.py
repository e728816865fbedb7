"""Sweep on a cluster: each chunk is a task of dask.distributed."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator
from typing import TYPE_CHECKING, Any

from ... import _core
from ...support import cluster
from ..chunks import Chunks
from ..computation import Computation, Report, Values

if TYPE_CHECKING:
    from distributed import Client


def compute(
    computation: Computation,
    chunks: Chunks,
    wanted: Iterable[int],
    threads: int,
    report: Report | None = None,
    scheduler: Any = None,
) -> Generator[tuple[int, Values], None, None]:
    """Yield each wanted chunk once, as it finishes.

    A task carries all its data. If a worker dies, the scheduler gives its chunks to another. Only a few chunks per
    worker are submitted at a time, so that results do not accumulate.
    """
    with cluster.connection(scheduler, "engine: got 'dask'") as client:
        yield from _stream(client, computation, chunks, iter(wanted), threads)


def _stream(
    client: Client, computation: Computation, chunks: Chunks, waiting: Iterator[int], threads: int
) -> Generator[tuple[int, Values], None, None]:
    import dask
    from distributed import as_completed

    finished = as_completed(loop=client.loop)
    under_way: dict[Any, tuple[Any, int]] = {}

    def submit() -> None:
        most = 2 * sum(client.nthreads().values()) + 2
        while len(under_way) < most and (chunk := next(waiting, None)) is not None:
            part = computation.part(chunks.box(chunk))
            with dask.config.set({"distributed.admin.large-graph-warning-threshold": "1 GiB"}):
                future = client.submit(_run, part, threads, _core.version, pure=False)
            under_way[future.key] = future, chunk
            finished.add(future)

    try:
        submit()
        for future in finished:
            values = _result(future)
            future.release()
            yield under_way.pop(future.key)[1], values
            submit()
    finally:
        cluster.cancel(client, [future for future, _ in under_way.values()])


def _run(part: Computation, threads: int, version: str) -> Values:
    """Compute a chunk on a worker."""
    stop_if_cancelled = cluster.on_worker(version)
    return part.compute(0, part.size, threads, lambda _: stop_if_cancelled())


def _result(future: Any) -> Values:
    """The values of a task; an error as one line."""
    from distributed import KilledWorker

    try:
        values: Values = future.result()
    except KilledWorker:
        raise RuntimeError("scheduler: four workers died, one after another, at the same chunk") from None
    return values
