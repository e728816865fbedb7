"""Where replicas are computed: in this process, in several, or on a cluster."""

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
from ..support import cluster
from . import replica as lockstep
from .replica import Arrays, Plan
from .starts import Starts

#: Seconds [wall clock] between two looks at what the others have done.
PAUSE: Final = 0.1

#: Told how many samples have been computed of the replicas that are wanted.
Tell = Callable[[int], object]
Found = Generator[tuple[int, Arrays], None, None]


def here(starts: Starts, plan: Plan, wanted: Sequence[int], tell: Tell) -> Found:
    """One replica after the other."""
    for place, replica in enumerate(wanted):
        done = [place * plan.steps]

        def alive(done: list[int] = done) -> None:
            tell(done[0])

        def sampled(done: list[int] = done, alive: Callable[[], None] = alive) -> None:
            done[0] += 1
            alive()

        yield replica, _replica(starts, plan, replica, sampled, alive)


def _replica(
    starts: Starts,
    plan: Plan,
    replica: int,
    sampled: Callable[[], object],
    alive: Callable[[], object],
) -> Arrays:
    system = starts.start(replica, lambda done, total: alive())
    return lockstep.compute(plan, system, sampled, alive)


# --- processes ----------------------------------------------------------------------------------------------


class Stopped(Exception):
    """The caller wants no more."""


_shared: dict[str, Any] = {}  #: of a worker: the samples of each replica, and whether to stop


def processes(starts: Starts, plan: Plan, wanted: Sequence[int], workers: int, tell: Tell) -> Found:
    """Each replica in one of so many processes, in the order in which they are finished.

    Raises
    ------
    RuntimeError
        If a process dies.
    """
    context = get_context("spawn")
    done, stop = context.Array("q", max(wanted) + 1), context.Event()
    pool = ProcessPoolExecutor(min(workers, len(wanted)), context, _begin, (done, stop))
    waiting: dict[Future[Arrays], int] = {}
    try:
        with _born_deaf():
            waiting.update((pool.submit(_task, starts, plan, k), k) for k in wanted)
        while waiting:
            finished, _ = wait(waiting, PAUSE, FIRST_COMPLETED)
            for future in finished:
                yield waiting.pop(future), future.result()
            tell(sum(done[:]))
    except BrokenProcessPool:
        raise RuntimeError(
            "workers: a process died; what is in a store is kept. In a script, the call must stand below "
            "if __name__ == '__main__'"
        ) from None
    finally:
        stop.set()
        pool.shutdown(wait=True, cancel_futures=True)


@contextmanager
def _born_deaf() -> Iterator[None]:
    """Processes started meanwhile never hear Ctrl-C, not even while they import what could ignore it.

    They inherit what this thread blocks, and keep it; here it is heard at the end.
    """
    if sys.platform == "win32":
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin(done: Any, stop: Any) -> None:
    """Of a worker: Ctrl-C is for the one that started it, and whoever loses that one ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
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


def on_cluster(starts: Starts, plan: Plan, wanted: Sequence[int], scheduler: Any, tell: Tell) -> Found:
    """Each replica as a task of dask.distributed, in the order in which they are finished.

    Raises
    ------
    ImportError
        If it is not installed.
    ValueError
        If no scheduler answers.
    RuntimeError
        If the scheduler goes away.
    """
    for place, found in enumerate(_gathered(starts, plan, wanted, scheduler)):
        yield found
        tell((place + 1) * plan.steps)


def _gathered(starts: Starts, plan: Plan, wanted: Sequence[int], scheduler: Any) -> Found:
    with cluster.connection(scheduler, "scheduler: got one") as client:
        from distributed import as_completed

        futures = {client.submit(_remote, starts, plan, k, _core.version, pure=False): k for k in wanted}
        try:
            for future in as_completed(list(futures), loop=client.loop):
                yield futures[future], future.result()
        finally:
            cluster.cancel(client, list(futures))


def _remote(starts: Starts, plan: Plan, replica: int, version: str) -> Arrays:
    """A replica, on a worker."""
    if _core.version != version:
        raise RuntimeError(f"a worker has hardlimit {_core.version}, must be {version} as here")
    from distributed import get_worker
    from distributed.worker import thread_state

    tasks, key = get_worker().state.tasks, thread_state.key

    def stop_if_cancelled() -> None:
        if key not in tasks or tasks[key].state == "cancelled":
            raise RuntimeError("cancelled")

    return _replica(starts, plan, replica, stop_if_cancelled, stop_if_cancelled)
