"""Connection to a dask.distributed cluster, which is given or started here, and checks on its workers."""

from __future__ import annotations

import gc
import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from .. import _core

if TYPE_CHECKING:
    from distributed import Client, Future

TIMEOUT = "10s"  #: of the connection to a scheduler


@contextmanager
def connection(scheduler: Any, purpose: str) -> Iterator[Client]:
    """Connect to the scheduler at an address; use an open client; or start a cluster on this machine.

    Raises an ImportError if dask.distributed is not installed; the message begins with ``asked``, such as ``engine: got
    'dask'``. Raises a RuntimeError if the connection to the scheduler is lost.
    """
    try:
        from distributed import CancelledError
    except ImportError:
        raise ImportError(
            f"{purpose}, needs the package distributed: pip install 'hardlimit[cluster]'"
        ) from None
    with _quiet(), _connected(scheduler) as client:
        try:
            yield client
        except Exception as gone:
            # An OSError if the scheduler has gone, CancelledError if this process closed the client.
            if not isinstance(gone, CancelledError | OSError) and _is_open(client):
                raise
            why = str(gone).splitlines()[:1] if isinstance(gone, OSError) else []
            lost = f"scheduler: connection lost{''.join(f' ({line})' for line in why)}"
            raise RuntimeError(f"{lost}; a store keeps what is finished, repeat the call") from None


def cancel(client: Client, futures: list[Future]) -> None:
    """Cancel these futures, unless the client is closed."""
    if futures and _is_open(client):
        client.cancel(futures, force=True)


def on_worker(version: str) -> Callable[[], None]:
    """Check the version of hardlimit on a worker; returns a function that raises if its task has been cancelled."""
    if _core.version != version:
        raise RuntimeError(f"a worker has hardlimit {_core.version}, must be {version} as here")
    from distributed import get_worker
    from distributed.worker import thread_state

    tasks, key = get_worker().state.tasks, thread_state.key

    def stop_if_cancelled() -> None:
        if key not in tasks or tasks[key].state == "cancelled":
            raise RuntimeError("cancelled")

    return stop_if_cancelled


def _is_open(client: Client) -> bool:
    """Whether the client can still reach a scheduler; a cluster in this process closes it."""
    return client.status not in ("closing", "closed")


@contextmanager
def _quiet() -> Iterator[None]:
    """Suppress the NameError that dask logs if Ctrl-C arrives at the beginning of one of its calls."""

    def wanted(record: logging.LogRecord) -> bool:
        return not (record.exc_info and isinstance(record.exc_info[1], NameError))

    log = logging.getLogger("tornado.application")
    log.addFilter(wanted)
    try:
        yield
    finally:
        log.removeFilter(wanted)


@contextmanager
def _connected(scheduler: Any) -> Iterator[Client]:
    from distributed import Client, LocalCluster

    if isinstance(scheduler, Client):
        yield scheduler
    elif scheduler is None:
        # Threads: the core releases the interpreter lock, and a script needs no `if __name__ == "__main__"`.
        here = {"dashboard_address": "127.0.0.1:0", "worker_dashboard_address": "127.0.0.1:0"}
        with (
            LocalCluster(processes=False, silence_logs=logging.ERROR, **here) as cluster,
            Client(cluster, set_as_default=False) as client,
        ):
            yield client
    else:
        fault = None
        try:
            client = Client(scheduler, timeout=TIMEOUT, set_as_default=False)
        except (OSError, ValueError, TypeError) as error:
            fault = str(error)
        if fault is not None:
            # A client without connection closes itself when it is garbage-collected. Force that here, because it
            # deadlocks in a thread that is just starting.
            gc.collect()
            need = "must be the address of a scheduler that answers"
            raise ValueError(f"scheduler: got {scheduler!r}, {need} ({fault})")
        with client:
            yield client
