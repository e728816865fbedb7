"""Read and write boxes of grains; the ending of the file name determines the format."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any, Final

from ...support import saving, validation
from ...support.formatting import listed
from . import extended_xyz, gsd_file, lammps_data
from .frame import Append, Found, Frame

FORMATS: Final[dict[str, ModuleType]] = {
    ".xyz": extended_xyz,
    ".extxyz": extended_xyz,
    ".gsd": gsd_file,
    ".data": lammps_data,
    ".lmp": lammps_data,
}


def format_of(path: str | Path) -> tuple[Path, Any]:
    """The path, and the module of the format that belongs to its ending."""
    target = validation.path("path", path)
    if target.suffix.lower() not in FORMATS:
        raise ValueError(f"path: got {validation.shown(str(path))}, must end in {listed([*FORMATS], 'or')}")
    return target, FORMATS[target.suffix.lower()]


def read(path: str | Path, frame: int = -1) -> Found:
    """Read one frame of a file."""
    target, kind = format_of(path)
    which = validation.whole("frame", frame, -(2**31), 2**31 - 1)
    try:
        target.stat()
        if not target.is_file():
            raise ValueError("cannot be read: not a file")
        found: Found = kind.read(target, which)
    except OSError as error:
        raise validation.unreadable(path, error) from None
    except MemoryError:
        raise ValueError(f"{path}: cannot be read: larger than the memory") from None
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    return found


def write(path: str | Path, frames: Iterable[Frame]) -> Path:
    """Write frames to a file, which appears under its name when it is complete."""
    with appender(path) as append:
        for frame in frames:
            append(frame)
    return Path(path)


@contextmanager
def appender(path: str | Path) -> Iterator[Append]:
    """Open a file to which frames can be appended; it appears under its name at the end of the block."""
    _, kind = format_of(path)
    with saving.whole(path) as unfinished, kind.appender(unfinished) as append:
        yield append
