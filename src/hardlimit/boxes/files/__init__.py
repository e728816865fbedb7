"""Read and write boxes of grains; the ending of the file name determines the format."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
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
        arguments: Found = kind.read(target, which)
    except OSError as error:
        raise validation.unreadable(path, error) from None
    except MemoryError:
        raise ValueError(f"{path}: cannot be read: larger than the memory") from None
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    return arguments


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


@contextmanager
def trajectory(path: str | Path, before: Sequence[float] = ()) -> Iterator[Append]:
    """Open the file of a run, to which frames can be appended; each is complete in it when the call returns.

    ``before`` are the times [s] of the samples of a run that is continued: the frames of these times stay, and later
    ones, which come again, are removed.

    Raises a ValueError if the file has frames of another run, or lacks some of this one, or is being written.
    """
    target, kind = format_of(path)
    with saving.exclusive(target):
        keep = _kept_frames(target, kind, before)
        if keep:
            kind.cut(target, keep)
    with saving.exclusive(target), kind.appender(target, keep > 0) as append:
        yield append


def _kept_frames(target: Path, kind: Any, before: Sequence[float]) -> int:
    """The number of frames in a file that belong to the samples ``before``."""
    if not (before and target.is_file() and target.stat().st_size):
        return 0
    times = kind.times(target)
    first = before.index(times[0]) if times and times[0] in before else None
    if first is None or times[: len(before) - first] != list(before[first : first + len(times)]):
        raise ValueError(
            f"out: got {target}, must be the trajectory of this run, or a new file: it has other frames"
        )
    if len(before) - first > len(times):
        raise ValueError(
            f"out: got {target}, must be the trajectory of this run, or a new file: it ends at {times[-1]:.6g} s, the "
            f"checkpoint at {before[-1]:.6g} s"
        )
    return len(before) - first
