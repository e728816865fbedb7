"""A map on a cluster: tiles as tasks of dask.distributed."""

from __future__ import annotations

import gc
import logging
from collections.abc import Generator, Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from ... import _core
from ..chunks import Tiles
from ..plan import Chunk, Plan

if TYPE_CHECKING:
    from distributed import Client

#: How long a scheduler may take to answer.
PATIENCE = "10s"


def compute(
    plan: Plan, tiles: Tiles, wanted: Iterable[int], threads: int, scheduler: Any
) -> Generator[tuple[int, Chunk], None, None]:
    """Each wanted tile once, as it is finished.

    A task carries all it needs, so the death of a worker costs the tiles it was at, and the scheduler gives
    them to another. Only a few tiles for each worker are under way: results pile up neither there nor here.
    """
    try:
        from distributed import CancelledError
        from distributed.comm import CommClosedError
    except ImportError:
        need = "engine: got 'dask', must have the package distributed: pip install 'hardlimit[cluster]'"
        raise ImportError(need) from None
    try:
        with _client(scheduler) as client:
            yield from _stream(client, plan, tiles, iter(wanted), threads)
    except (CancelledError, CommClosedError):
        raise RuntimeError("scheduler: went away; what is in a store is kept, repeat the call") from None


def _stream(
    client: Client, plan: Plan, tiles: Tiles, waiting: Iterator[int], threads: int
) -> Generator[tuple[int, Chunk], None, None]:
    import dask
    from distributed import as_completed

    finished = as_completed(loop=client.loop)
    under_way: dict[Any, tuple[Any, int]] = {}

    def submit() -> None:
        most = 2 * sum(client.nthreads().values()) + 2
        while len(under_way) < most and (tile := next(waiting, None)) is not None:
            with dask.config.set({"distributed.admin.large-graph-warning-threshold": "1 GiB"}):
                future = client.submit(_run, tiles.cut(plan, tile), threads, _core.version, pure=False)
            under_way[future.key] = future, tile
            finished.add(future)

    try:
        submit()
        for future in finished:
            chunk = _result(future)
            future.release()
            yield under_way.pop(future.key)[1], chunk
            submit()
    finally:
        if under_way:
            client.cancel([future for future, _ in under_way.values()], force=True)


def _run(plan: Plan, threads: int, version: str) -> Chunk:
    """A tile, on a worker."""
    if _core.version != version:
        raise RuntimeError(f"a worker has hardlimit {_core.version}, must be {version} as here")
    from distributed import get_worker
    from distributed.worker import thread_state

    tasks, key = get_worker().state.tasks, thread_state.key

    def stop_if_cancelled(_: int) -> None:
        if key not in tasks or tasks[key].state == "cancelled":
            raise RuntimeError("cancelled")

    return plan.compute(0, plan.size, threads, stop_if_cancelled)


def _result(future: Any) -> Chunk:
    """What a task returned, or one line on what became of it."""
    from distributed import KilledWorker

    try:
        chunk: Chunk = future.result()
    except KilledWorker:
        raise RuntimeError("scheduler: four workers died, one after another, at the same tile") from None
    return chunk


@contextmanager
def _client(scheduler: Any) -> Iterator[Client]:
    """A connection to the scheduler at an address, an open one as it is, or a cluster on this machine."""
    from distributed import Client, LocalCluster

    if isinstance(scheduler, Client):
        yield scheduler
    elif scheduler is None:
        # Threads rather than processes: the kernel does not hold the interpreter lock, and a script needs no
        # `if __name__ == "__main__"`.
        here = {"dashboard_address": "127.0.0.1:0", "worker_dashboard_address": "127.0.0.1:0"}
        with (
            LocalCluster(processes=False, silence_logs=logging.ERROR, **here) as cluster,
            Client(cluster, set_as_default=False) as client,
        ):
            yield client
    else:
        fault = None
        try:
            client = Client(scheduler, timeout=PATIENCE, set_as_default=False)
        except (OSError, ValueError, TypeError) as error:
            fault = str(error)
        if fault is not None:
            # A client that could not connect closes itself when it is collected. Let that be now: in a thread that
            # is just being started it would wait for ever.
            gc.collect()
            need = f"scheduler: got {scheduler!r}, must be the address of a scheduler that answers"
            raise ValueError(f"{need} ({fault})")
        with client:
            yield client
