"""The way to a cluster: a scheduler of dask.distributed, given or started here."""

from __future__ import annotations

import gc
import logging
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from distributed import Client, Future

#: How long a scheduler may take to answer.
PATIENCE = "10s"


@contextmanager
def connection(scheduler: Any, asked: str) -> Iterator[Client]:
    """A connection to the scheduler at an address, an open one as it is, or a cluster on this machine.

    Raises
    ------
    ImportError
        If dask.distributed is not installed; ``asked`` is what needs it, such as ``engine: got 'dask'``.
    ValueError
        If no scheduler answers.
    RuntimeError
        If the scheduler goes away.
    """
    try:
        from distributed import CancelledError
    except ImportError:
        raise ImportError(
            f"{asked}, must have the package distributed: pip install 'hardlimit[cluster]'"
        ) from None
    with _quiet(), _connected(scheduler) as client:
        try:
            yield client
        except Exception as gone:
            # OSError where it is asked something once it has gone, one of dask's own where this process closed it.
            if not isinstance(gone, CancelledError | OSError) and _is_open(client):
                raise
            why = str(gone).splitlines()[:1] if isinstance(gone, OSError) else []
            raise RuntimeError(
                f"scheduler: went away{''.join(f' ({line})' for line in why)}; "
                "what is in a store is kept, repeat the call"
            ) from None


def cancel(client: Client, futures: list[Future]) -> None:
    """Stop the work on these, unless the client is closed, and it with it."""
    if futures and _is_open(client):
        client.cancel(futures, force=True)


def _is_open(client: Client) -> bool:
    """Whether a scheduler can still be asked: a client is closed with a cluster in its process."""
    return client.status not in ("closing", "closed")


@contextmanager
def _quiet() -> Iterator[None]:
    log = logging.getLogger("tornado.application")
    log.addFilter(_told)
    try:
        yield
    finally:
        log.removeFilter(_told)


def _told(record: logging.LogRecord) -> bool:
    """Whether a user is told. Where Ctrl-C comes as a call of dask begins, there is nothing to cancel yet, which is
    logged as an error of a name without a value."""
    return not (record.exc_info and isinstance(record.exc_info[1], NameError))


@contextmanager
def _connected(scheduler: Any) -> Iterator[Client]:
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
