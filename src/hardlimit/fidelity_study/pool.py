"""Replicas computed in this process, in several processes, or on a cluster."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import get_context, parent_process
from typing import Any, Final

from .. import _core
from ..support import cluster, machine
from .replica import Arrays, Call, Plan, compute
from .starts import Starts

#: Seconds between two polls of the other processes.
PAUSE: Final = 0.1

#: Called with the number of samples computed so far.
Tell = Callable[[int], object]
Found = Generator[tuple[int, Arrays], None, None]


def here(starts: Starts, plan: Plan, wanted: Sequence[int], tell: Tell) -> Found:
    """Compute one replica after the other in this process."""
    done = 0

    def sampled() -> None:
        nonlocal done
        done += 1
        tell(done)

    for replica in wanted:
        yield replica, _replica(starts, plan, replica, sampled, lambda: tell(done))


def _replica(starts: Starts, plan: Plan, replica: int, sampled: Call, alive: Call) -> Arrays:
    system = starts.start(replica, lambda done, total: alive())
    return compute(plan, system, sampled, alive)


# --- processes ----------------------------------------------------------------------------------------------


class Stopped(Exception):
    """Raised in a worker when the caller has stopped."""


_shared: dict[str, Any] = {}  #: in a worker: the number of samples of each replica, and whether to stop


def processes(starts: Starts, plan: Plan, wanted: Sequence[int], workers: int, tell: Tell) -> Found:
    """Compute each replica in one of ``workers`` processes; yields replicas as they finish.

    Raises RuntimeError if a process dies.
    """
    context = get_context("spawn")
    done, stop = context.Array("q", max(wanted) + 1), context.Event()
    pool = ProcessPoolExecutor(min(workers, len(wanted)), context, _begin, (done, stop))
    waiting: dict[Future[Arrays], int] = {}
    try:
        with signals_blocked():
            waiting.update((pool.submit(_task, starts, plan, k), k) for k in wanted)
        while waiting:
            finished, _ = wait(waiting, PAUSE, FIRST_COMPLETED)
            for future in finished:
                yield waiting.pop(future), future.result()
            tell(sum(done[:]))
    except BrokenProcessPool:
        raise RuntimeError(
            "workers: a process died; with a store, the same call continues with the other replicas. In a script, the "
            "call must be inside if __name__ == '__main__'"
        ) from None
    finally:
        stop.set()
        pool.shutdown(wait=True, cancel_futures=True)


@contextmanager
def signals_blocked() -> Iterator[None]:
    """Processes that start in the block inherit the signal mask: Ctrl-C and the end of a job, which a scheduler tells
    all processes, never end them before this process has saved its results.

    This process receives such a signal at the end of the block.
    """
    if sys.platform == "win32":
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, *machine.TERMINATING})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin(done: Any, stop: Any) -> None:
    """Initialize a worker: it ignores signals, which its parent handles, and ends with its parent."""
    for number in (signal.SIGINT, *machine.TERMINATING):
        signal.signal(number, signal.SIG_IGN)
    _shared.update(done=done, stop=stop)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _task(starts: Starts, plan: Plan, replica: int) -> Arrays:
    def alive() -> None:
        if _shared["stop"].is_set():
            raise Stopped

    def sampled() -> None:
        _shared["done"][replica] += 1
        alive()

    return _replica(starts, plan, replica, sampled, alive)


# --- cluster ------------------------------------------------------------------------------------------------


def on_cluster(starts: Starts, plan: Plan, wanted: Sequence[int], scheduler: Any) -> Found:
    """Compute each replica as a task of dask.distributed; yields replicas as they finish.

    Raises ImportError without dask.distributed, ValueError if no scheduler answers, and RuntimeError if the connection
    is lost.
    """
    with cluster.connection(scheduler, "scheduler: got one") as client:
        from distributed import as_completed

        futures = {client.submit(_remote, starts, plan, k, _core.version, pure=False): k for k in wanted}
        try:
            for future in as_completed(list(futures), loop=client.loop):
                yield futures[future], future.result()
        finally:
            cluster.cancel(client, list(futures))


def _remote(starts: Starts, plan: Plan, replica: int, version: str) -> Arrays:
    """Compute a replica on a worker."""
    stop_if_cancelled = cluster.on_worker(version)
    return _replica(starts, plan, replica, stop_if_cancelled, stop_if_cancelled)
