"""Read and write boxes of grains; the ending of the file name determines the format."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from types import ModuleType
from typing import Any, Final

from ...support import saving, validation
from ...support.formatting import listed
from . import dump, extended_xyz, gsd_file, lammps_data
from .completion import OfTypes, Options, completed
from .frame import Append, Frame

__all__ = [
    "FORMATS",
    "OfTypes",
    "Options",
    "appender",
    "is_readable",
    "is_tilted",
    "read",
    "trajectory",
    "write",
]

FORMATS: Final[dict[str, ModuleType]] = {
    ".xyz": extended_xyz,
    ".extxyz": extended_xyz,
    ".gsd": gsd_file,
    ".data": lammps_data,
    ".lmp": lammps_data,
}
#: Names of files that are dumps if they exist.
LIKE_DUMPS: Final = re.compile(r"^dump|\.(gz|dump|lammpstrj|liggghts)$", re.IGNORECASE)


def format_of(path: str | Path) -> tuple[Path, Any]:
    """The path, and the module of the format that belongs to its ending."""
    target = validation.path("path", path)
    if target.suffix.lower() not in FORMATS:
        raise ValueError(f"path: got {validation.shown(str(path))}, must end in {listed([*FORMATS], 'or')}")
    return target, FORMATS[target.suffix.lower()]


def readable(path: str | Path) -> tuple[Path, Any]:
    """The path of a file that exists, and the module of its format. A dump is known by its beginning."""
    target = validation.path("path", path)
    suffix = target.suffix.lower()
    try:
        target.stat()
        if target.is_file() and dump.is_dump(target):
            return target, dump
    except OSError as error:
        if suffix in FORMATS or LIKE_DUMPS.search(target.name):
            raise validation.unreadable(path, error) from None
    if suffix not in FORMATS:
        endings = listed([*FORMATS], "or")
        raise ValueError(
            f"path: got {validation.shown(str(path))}, must end in {endings}, or be a text dump of LAMMPS or LIGGGHTS"
        )
    if not target.is_file():
        raise ValueError(f"{path}: cannot be read: not a file")
    return target, FORMATS[suffix]


def is_readable(path: str | Path) -> bool:
    """Whether a name is that of a box of grains, or the file is a dump."""
    target = validation.path("path", path)
    if target.suffix.lower() in FORMATS or LIKE_DUMPS.search(target.name):
        return True
    with suppress(OSError):
        return target.is_file() and dump.is_dump(target)
    return False


def read(path: str | Path, frame: int = -1, options: Options | None = None) -> tuple[dict[str, Any], float]:
    """Read one frame of a file: unchecked arguments of a system, and the rounding error of distances over the smallest
    radius."""
    target, kind = readable(path)
    which = validation.whole("frame", frame, -(2**31), 2**31 - 1)
    with _naming(path):
        return completed(kind.read(target, which), options or Options())


def frames(path: str | Path, options: Options) -> Iterator[tuple[dict[str, Any], float]]:
    """As :func:`read`, all frames of a file one after the other."""
    target, kind = readable(path)
    with _naming(path):
        for content in kind.frames(target):
            yield completed(content, options)


def is_tilted(path: str | Path) -> bool:
    """Whether the box of another program's file tilts, so that its flow has to be told."""
    target, kind = readable(path)
    with _naming(path):
        return bool(dump.is_tilted(target) if kind is dump else kind.read(target, 0).tilt is not None)


@contextmanager
def _naming(path: str | Path) -> Iterator[None]:
    """Errors of the block name the file."""
    try:
        yield
    except OSError as error:
        raise validation.unreadable(path, error) from None
    except MemoryError:
        raise ValueError(f"{path}: cannot be read: larger than the memory") from None
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


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
