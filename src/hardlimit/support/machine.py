"""Processors and free memory that are available to this process, and the signals that end it."""

import os
import signal
from contextlib import suppress
from pathlib import Path
from typing import Final

#: Memory limit of a container (control groups, version 2), which psutil does not read.
CONTAINER_LIMIT: Final = Path("/sys/fs/cgroup/memory.max")
#: Signals that end a job, such as SIGTERM at a cluster's time limit.
TERMINATING: Final = [
    getattr(signal, name) for name in ("SIGTERM", "SIGHUP", "SIGXCPU") if hasattr(signal, name)
]


def processors() -> int:
    """Number of processors that this process may run on."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def free_memory() -> int:
    """Bytes of memory that this process may still allocate."""
    import psutil

    free = int(psutil.virtual_memory().available)
    with suppress(OSError, ValueError):  # no such file; "max" means no limit
        free = min(free, int(CONTAINER_LIMIT.read_text()))
    return free
