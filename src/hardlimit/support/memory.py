"""How much memory there is, and sizes in words."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from typing import Final

#: Where Linux says how much a process may still take, and the limit of its container.
AVAILABLE: Final = Path("/proc/meminfo")
CONTAINER: Final = Path("/sys/fs/cgroup/memory.max")


def available_memory() -> int:
    """Bytes that this process may still take; all there is where the system does not tell."""
    known = []
    with suppress(OSError, ValueError, StopIteration):
        lines = AVAILABLE.read_text().splitlines()
        known.append(1024 * int(next(line for line in lines if line.startswith("MemAvailable")).split()[1]))
    with suppress(OSError, ValueError):  # "max": none
        known.append(int(CONTAINER.read_text()))
    if not known and hasattr(os, "sysconf"):
        with suppress(OSError, ValueError):
            known.append(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    return min(known, default=1 << 47)  # the address space of a process


def shown_bytes(count: float) -> str:
    """A number of bytes with a prefixed unit."""
    for unit in ("B", "kB", "MB", "GB", "TB"):
        if count < 1000.0:
            return f"{count:.3g} {unit}"
        count /= 1000.0
    return f"{count:.3g} PB"
