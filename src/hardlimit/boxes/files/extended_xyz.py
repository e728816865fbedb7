"""Extended XYZ files: text with one line for each particle, which OVITO and ASE can read.

We do not write with ASE: its eight decimals keep only five digits of the position of a grain of 1 mm.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import islice, repeat
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np

from ...support import validation
from ...support.saving import write_all
from .. import spins
from ..thermostats import as_entry, from_entry
from ..walls import as_entries, from_entries
from .frame import (
    Append,
    Floats,
    Found,
    Frame,
    boundary_of,
    check_frame,
    read_table,
    rounding_of,
    sorted_by_id,
    spins_of,
    three,
    write_rows,
)

COLUMNS: Final = "species:S:1:pos:R:3:velo:R:3:radius:R:1:mass:R:1"
#: Further columns of particles with spins.
SPINS: Final = ":angular_velocity:R:3:inertia_factor:R:1"
NAMES: Final = {
    "pos": "positions",
    "velo": "velocities",
    "vel": "velocities",
    "radius": "radius",
    "mass": "mass",
    "masses": "mass",
    "density": "density",
    "Density": "density",
    "angular_velocity": "angular_velocities",
    "omega": "angular_velocities",
    "angular_momentum": "angular_momenta",
    "inertia_factor": "inertia_factor",
}
#: Number of columns of each property.
WIDTHS: Final = {
    "positions": 3,
    "velocities": 3,
    "radius": 1,
    "mass": 1,
    "density": 1,
    "angular_velocities": 3,
    "angular_momenta": 3,
    "inertia_factor": 1,
}
_ENTRY: Final = re.compile(r'([^\s="]+)=(?:"([^"]*)"|(\S+))')


@contextmanager
def appender(path: Path, more: bool = False) -> Iterator[Append]:
    """Frames of a new file, or ``more`` of an existing one. A frame is in the file as a whole or not at all."""
    with open(path, "ab" if more else "wb", buffering=0) as file:

        def append(frame: Frame) -> None:
            start = file.tell() if file.seekable() else None
            try:
                _append(file, frame)
            except BaseException:
                if start is not None:
                    file.truncate(start)
                    file.seek(start)
                raise

        yield append


def times(path: Path) -> list[float]:
    """Times of all complete frames [s]."""
    return [time for time, _ in _complete(path)]


def cut(path: Path, keep: int) -> None:
    """Remove all but the first frames."""
    os.truncate(path, list(_complete(path))[keep - 1][1])


def _complete(path: Path) -> Iterator[tuple[float, int]]:
    """Time [s] and end of each frame, up to the first one that is incomplete or of another program."""
    with open(path, "rb") as file, suppress(ValueError):
        for start in _frames(file):
            end = file.tell()
            file.seek(end - 1)
            if file.read(1) != b"\n":
                return
            file.seek(start)
            file.readline()
            yield float(_entries(_text(file.readline())).get("Time", "")), end
            file.seek(end)


def _append(file: BinaryIO, frame: Frame) -> None:
    write_all(file, f"{len(frame.positions)}\n{_comment(frame)}\n".encode())
    columns = [three(frame.positions), three(frame.velocities), frame.radius, frame.mass]
    if frame.angular_velocities is not None and frame.inertia_factor is not None:
        columns += [spins.for_core(frame.angular_velocities), frame.inertia_factor]
    write_rows(file, repeat("X"), *columns)


def _comment(frame: Frame) -> str:
    """The comment line of a frame: cell, columns, periodicity, time, gravity and moving walls."""
    d = len(frame.box)
    edges = three(frame.box, 2.0 * float(frame.radius.max()))
    wraps, shear = frame.sides
    flags = ["T" if flag else "F" for flag in wraps] + ["F"] * (3 - d)
    gravity = " ".join(map(repr, three(frame.gravity).tolist()))
    lattice = " ".join(map(repr, np.diag(edges).ravel().tolist()))
    columns = COLUMNS + ("" if frame.angular_velocities is None else SPINS)
    walls = "; ".join(" ".join(map(str, entry)) for entry in as_entries(frame.walls))
    walls = f' moving_walls="{walls}"' if walls else ""
    if frame.thermostat is not None:
        entry = as_entry(frame.thermostat) or {}
        walls += f' thermostat="{" ".join(f"{name}:{value}" for name, value in entry.items())}"'
    if shear:
        walls += f' shear="{" ".join(map(repr, shear))}"'
    return (
        f'Lattice="{lattice}" Properties={columns} pbc="{" ".join(flags)}" '
        f'Time={frame.time!r} gravity="{gravity}" dimension={d}{walls}'
    )


def read(path: Path, frame: int) -> Found:
    with open(path, "rb") as file:
        starts = list(_frames(file))
        check_frame(frame, len(starts))
        return _read_at(file, starts[frame])


def frames(path: Path) -> Iterator[Found]:
    """All frames, one after the other."""
    with open(path, "rb") as file:
        starts = list(_frames(file))
        check_frame(0, len(starts))
        yield from (_read_at(file, start) for start in starts)


def _read_at(file: BinaryIO, start: int) -> Found:
    file.seek(start)
    n = int(file.readline())
    entries = _entries(_text(file.readline()))
    return _found(list(islice(file, n)), entries)


def _frames(file: BinaryIO) -> Iterator[int]:
    """Byte offset of each frame."""
    while True:
        start = file.tell()
        first = file.readline()
        if not first.strip():
            if not first:
                return
            continue
        if not re.fullmatch(rb"\s*\d{1,12}\s*", first):
            shown = validation.shown(_text(first).strip())
            raise ValueError(f"number of particles: got {shown}, must be a whole number")
        n = int(first)
        lines = sum(1 for _ in islice(file, n + 1))
        if n == 0 or lines != n + 1:
            raise ValueError(
                f"number of particles: got {n}, must be >= 1 and the number of its lines, {max(lines - 1, 0)}"
            )
        yield start


def _text(line: bytes) -> str:
    try:
        return line.decode()
    except UnicodeDecodeError:
        raise ValueError("not UTF-8 text") from None


def _entries(comment: str) -> dict[str, str]:
    return {key: quoted or plain for key, quoted, plain in _ENTRY.findall(comment)}


def _columns(entries: dict[str, str]) -> tuple[list[int], dict[str, slice], dict[str, int]]:
    """The columns that are read; which of these belong to each property; the columns of types and of ids."""
    parts = entries.get("Properties", "").split(":")
    used: list[int] = []
    where: dict[str, slice] = {}
    labels: dict[str, int] = {}
    column = 0
    for name, kind, width in zip(parts[::3], parts[1::3], parts[2::3], strict=False):
        if not width.isdigit():
            raise ValueError(
                f"Properties: got {validation.shown(entries['Properties'])}, must be name:kind:width:…"
            )
        count = int(width)
        if name in NAMES and kind in "RI" and NAMES[name] not in where and count <= 3:
            where[NAMES[name]] = slice(len(used), len(used) + count)
            used += range(column, column + count)
        if name in ("species", "id") and count == 1:
            labels.setdefault(name, column)
        column += count
    widths = {name: place.stop - place.start for name, place in where.items()}
    if "positions" not in widths or any(width != WIDTHS[name] for name, width in widths.items()):
        raise ValueError(
            "Properties: must contain pos:R:3, and may contain velo:R:3, radius:R:1, mass:R:1, density:R:1, "
            "angular_velocity:R:3, angular_momentum:R:3 and inertia_factor:R:1"
        )
    if "mass" in where:
        where.pop("density", None)
    if "angular_velocities" in where:
        where.pop("angular_momenta", None)
    return used, where, labels


def _found(lines: list[bytes], entries: dict[str, str]) -> Found:
    used, where, labels = _columns(entries)
    table = read_table("particles", lines, used)
    d = {"2": 2, "3": 3}.get(entries.get("dimension", "3"))
    if d is None:
        raise ValueError(f"dimension: got {validation.shown(entries['dimension'])}, must be 2 or 3")
    arguments: dict[str, Any] = {}
    for name in ("positions", "velocities"):
        if name in where:
            vectors = table[:, where[name]]
            if np.any(vectors[:, d:]):
                raise ValueError("dimension: got 2, must be 3 for particles with z ≠ 0")
            arguments[name] = vectors[:, :d]
    for name in ("angular_velocities", "angular_momenta"):
        if name in where:
            arguments[name] = spins_of(table[:, where[name]], d)
    for name in ("radius", "mass", "density", "inertia_factor"):
        if name in where:
            arguments[name] = table[:, where[name]][:, 0]
    cell = _vector(entries, "Lattice", 9).reshape(3, 3)
    flags = entries.get("pbc", "T T T").split()
    if len(flags) != 3 or not {*flags} <= {"T", "F", "1", "0"}:
        raise ValueError(f"pbc: got {validation.shown(entries['pbc'])}, must be T or F for each axis")
    wraps = [flag in "T1" for flag in flags[:d]]
    if "dimension" in entries:  # this package wrote it
        return Found(arguments | _own(cell, wraps, entries, d), units="si")
    return _of_another_program(arguments, cell, wraps, entries, _labels(lines, labels))


def _labels(lines: list[bytes], columns: dict[str, int]) -> dict[str, list[str]]:
    """The words of some columns."""
    words = [_text(line).split() for line in lines] if columns else []
    return {name: [row[column] for row in words] for name, column in columns.items()}


def _of_another_program(
    arguments: dict[str, Any],
    cell: Floats,
    wraps: list[bool],
    entries: dict[str, str],
    labels: dict[str, list[str]],
) -> Found:
    """A frame of OVITO or ASE: its box may begin elsewhere and may be tilted along x, positions may be unfolded."""
    if np.any(np.triu(cell, 1)) or not (np.diag(cell) > 0.0).all():
        raise ValueError("Lattice: must be a box along the axes, or one tilted along x")
    written = [arguments["positions"].ravel()]
    arguments["positions"] = arguments["positions"] - _vector(entries, "Origin", 3, 0.0)
    tilt = np.array([cell[1, 0], cell[2, 0], cell[2, 1]])
    arguments |= {"box": np.diag(cell).copy(), **boundary_of(wraps)}
    types = labels.get("species")
    if "id" in labels:
        order = sorted_by_id(read_table("id", labels["id"])[:, 0])
        arguments |= {name: arguments[name][order] for name in arguments.keys() & WIDTHS.keys()}
        types = [types[k] for k in order] if types else None
    return Found(
        arguments,
        rounding=rounding_of(written),
        types=types,
        tilt=tilt if tilt.any() else None,
        is_folded=False,
    )


def _own(cell: Floats, wraps: list[bool], entries: dict[str, str], d: int) -> dict[str, Any]:
    """Box and driving of a frame that this package wrote."""
    if np.any(cell != np.diag(np.diag(cell))) or np.any(_vector(entries, "Origin", 3, 0.0) != 0.0):
        raise ValueError("Lattice | Origin: must be a box along the axes with a corner at the origin")
    shear = _vector(entries, "shear", 3) if "shear" in entries else None
    return {
        "box": np.diag(cell)[:d],
        **boundary_of(wraps, shear),
        "gravity": _vector(entries, "gravity", 3, 0.0)[:d],
        "walls": from_entries(
            wall.split() for wall in entries.get("moving_walls", "").split(";") if wall.strip()
        ),
        "thermostat": _thermostat(entries.get("thermostat")),
    }


def _thermostat(words: str | None) -> Any:
    """The thermostat from name:value for each of its values."""
    if words is None:
        return None
    values: dict[str, Any] = dict(word.partition(":")[::2] for word in words.split())
    for name in values.keys() - {"kind"}:
        try:
            values[name] = int(values[name]) if name in ("seed", "kicks") else float(values[name])
        except ValueError:
            raise ValueError(f"thermostat: got {validation.shown(words)}, must be name:value …") from None
    return from_entry(values)


def _vector(entries: dict[str, str], name: str, count: int, default: float | None = None) -> Floats:
    """An entry of the comment line with ``count`` numbers."""
    if name not in entries and default is not None:
        return np.full(count, default)
    try:
        vector = np.array([float(word) for word in entries.get(name, "").split()])
    except ValueError:
        vector = np.empty(0)
    if vector.shape != (count,) or not np.isfinite(vector).all():
        got = validation.shown(entries[name]) if name in entries else "nothing"
        raise ValueError(f"{name}: got {got}, must be {count} numbers")
    return vector
