"""One process at a time writes a store: a lock that ends with its process and leaves no file."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final

if sys.platform != "win32":
    import fcntl

#: How long another process may take to let go of a store: one that was killed a moment ago has not yet ended.
PATIENCE: Final = 2.0  # s


@contextmanager
def locked(place: Path, path: Path, patience: float | None = None) -> Iterator[bool]:
    """Keep other processes from writing the store ``path``, of which ``place`` is a folder or a file.

    Gives false if that is no longer there under this name: another process was at it. Without locks (Windows, some
    network file systems) nothing is kept from anything. Another process may take ``patience`` seconds, by default
    ``PATIENCE``, to let go.

    Raises
    ------
    ValueError
        If another process has it and keeps it.
    OSError
        If it cannot be opened; names it.
    """
    if sys.platform == "win32":
        yield True
        return
    try:
        handle = os.open(place, os.O_RDONLY)
    except FileNotFoundError:
        yield False
        return
    except OSError as error:
        told = OSError(f"store: cannot open {path}: {error.strerror or error}; what is finished is kept")
        told.errno = error.errno
        raise told from None
    try:
        with suppress(OSError):  # no locks
            _wait_for_lock(handle, path, PATIENCE if patience is None else patience)
        yield _is_still(handle, place)
    finally:
        os.close(handle)


def _is_still(handle: int, place: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(handle), place.stat())
    except FileNotFoundError:
        return False


def _wait_for_lock(handle: int, path: Path, patience: float) -> None:
    deadline = time.monotonic() + patience
    while True:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return
        except BlockingIOError:
            if time.monotonic() > deadline:
                raise ValueError(f"store: {path} is being written by another process") from None
        time.sleep(0.02)
