"""Read measurements from CSV files: a header with names and units, and one row for each impact, height, time or drop.

Lines that begin with ``#`` are comments. A unit follows a name, ``speed [cm/s]``; the default is SI. Cells are
separated by commas, semicolons or tabs. Unknown columns are ignored with a warning.
"""

from __future__ import annotations

import csv
import math
import re
import warnings
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from ..column.scenario import STANDARD_GRAVITY, Column
from ..support import units, validation
from .measurements import OBSERVED, Impacts, Measured, Rebounds

#: Unit of each known column.
MEASURED: Final = {
    "speed": "m/s",
    "restitution": "1",
    "height": "m",
    "drop_height": "m",
    "rebound_height": "m",
    "time": "s",
    **{name: unit for name, (_, unit) in OBSERVED.items()},
}
UNITS: Final = (
    MEASURED | {f"{name}_error": unit for name, unit in MEASURED.items()} | {"drop": "1", "gap": "m"}
)
LARGEST_FILE: Final = 100_000_000  #: bytes
SEPARATORS: Final = ",;\t"
SNIFFED: Final = 20  #: lines from which the separator is inferred

_HEADER: Final = re.compile(r"(\w+)(?:\s*\[([^\]]*)\])?", re.ASCII)


@dataclass(frozen=True)
class Table:
    """Columns of a file in SI units, and the line number of each row."""

    columns: dict[str, list[float]]
    lines: list[int]
    header: int  #: line number of the header
    known: tuple[str, ...]  #: columns that are read
    ignored: tuple[str, ...]  #: other columns of the file

    def groups(self) -> list[list[int]]:
        """Rows of each drop in the order of the file; a single drop without the column ``drop``."""
        numbers = self.columns.get("drop", [0.0] * len(self.lines))
        rows_of: dict[float, list[int]] = {}
        for row, number in enumerate(numbers):
            rows_of.setdefault(number, []).append(row)
        return list(rows_of.values())

    def grouped(self, name: str) -> list[list[float]]:
        """A column by drops; empty if the file does not have it."""
        if name not in self.columns:
            return []
        return [[self.columns[name][row] for row in rows] for rows in self.groups()]


def read_measurements(
    path: str | Path, *, column: Column | None = None, gravity: float = STANDARD_GRAVITY
) -> Measured:
    """Read measurements from a CSV file; the names of its columns determine the kind of measurement.

    ======================================  =========================================================
    header                                  one row is
    ======================================  =========================================================
    ``speed, restitution``                  an impact
    ``drop_height, rebound_height``         an impact after a fall from rest
    ``height``                              a peak of a bouncing ball; the release first
    ``time``                                an impact of a bouncing ball
    ``separation_velocity``,                a drop of ``column``; with ``gap`` and ``height`` where they
    ``top_velocity`` or ``top_height``      differ from drop to drop
    ======================================  =========================================================

    Columns ``…_error`` have standard errors. The column ``drop`` gives the number of the drop to which a peak or time
    belongs. Cells are separated by commas, semicolons or tabs. Other columns are ignored with a warning.

    Parameters
    ----------
    path : path
    column : Column, optional
        The column that was dropped, for measurements of its rebounds.
    gravity : float [m/s²]
        Gravity, for measurements of heights and times.

    Raises
    ------
    ValueError
        If the file cannot be read or is not such a table (names line and column), or another argument is outside its
        range.
    FileNotFoundError
        If there is no such file.
    """
    if column is not None and not isinstance(column, Column):
        raise ValueError(f"column: got {validation.shown(column)}, must be a Column")
    validation.number("gravity", gravity, 0.0)
    table, build = _read(path)
    if table.ignored:
        ignored, known = ", ".join(map(validation.shown, table.ignored)), ", ".join(table.known)
        what = f"column {ignored} is ignored: it is not one of {known}"
        warnings.warn(f"{path}: line {table.header}: {what}", stacklevel=2)
    try:
        return build(table, column, gravity)
    except ValueError as error:
        raise ValueError(f"{path}: {_with_line(str(error), table)}") from None


def error_column(path: str | Path) -> str:
    """The column with the errors of the values in such a file."""
    return next(name for name in _read(path)[0].known if name.endswith("_error"))


def _impacts(table: Table, column: Column | None, gravity: float) -> Measured:
    return Impacts.of_restitution(**table.columns)


def _rebound_heights(table: Table, column: Column | None, gravity: float) -> Measured:
    return Impacts.of_rebound_heights(**table.columns, gravity=gravity)


def _heights(table: Table, column: Column | None, gravity: float) -> Measured:
    return Impacts.of_heights(table.grouped("height"), table.grouped("height_error") or 0.0, gravity)


def _times(table: Table, column: Column | None, gravity: float) -> Measured:
    return Impacts.of_times(table.grouped("time"), table.grouped("time_error") or 0.0, gravity)


def _rebounds(table: Table, column: Column | None, gravity: float) -> Measured:
    name = next(name for name in OBSERVED if name in table.columns)
    if column is None:
        raise ValueError(f"column: missing, must be the Column whose {name} was measured")
    got = table.columns
    error = got.get(f"{name}_error", 0.0)
    return Rebounds.of_column(column, name, got[name], error, gap=got.get("gap"), height=got.get("height"))


Build = Callable[[Table, Column | None, float], Measured]
#: By required columns: how the file is read, and its optional columns.
KINDS: Final[dict[tuple[str, ...], tuple[Build, tuple[str, ...]]]] = {
    ("speed", "restitution"): (_impacts, ("restitution_error", "speed_error")),
    ("drop_height", "rebound_height"): (_rebound_heights, ("rebound_height_error", "drop_height_error")),
    ("time",): (_times, ("time_error", "drop")),
    **{(name,): (_rebounds, (f"{name}_error", "gap", "height")) for name in OBSERVED},
    ("height",): (_heights, ("height_error", "drop")),
}


def _kind(where: str, columns: Sequence[str]) -> tuple[Build, tuple[str, ...]]:
    """How a file with these columns is read, and the columns it may have."""
    for names, (build, allowed) in KINDS.items():
        if set(names) <= set(columns):
            return build, (*names, *allowed)
    need = " | ".join(", ".join(names) for names in KINDS)
    got = validation.shown(", ".join(columns))
    raise ValueError(
        f"{where}: got columns {got}, must hold {need}, with comma, semicolon or tab between cells"
    )


def _with_line(message: str, table: Table) -> str:
    """The message with a line number instead of an index such as ``times[1][3]`` or ``speed[4]``."""
    match = re.match(r"(\w+)\[(\d+)\](?:\[(\d+)\])?: (.*)", message, re.ASCII | re.DOTALL)
    if match is None:
        return message
    name = {"times": "time", "heights": "height"}.get(match[1], match[1])
    rows = list(range(len(table.lines)))
    if name in ("time", "height", "time_error", "height_error") and "gap" not in table.columns:
        rows = table.groups()[int(match[2])]
        if match[3] is None:
            return f"lines {table.lines[rows[0]]} to {table.lines[rows[-1]]}, column {name}: {match[4]}"
        return f"line {table.lines[rows[int(match[3])]]}, column {name}: {match[4]}"
    where = f"line {table.lines[rows[int(match[2])]]}"
    return f"{where}: {match[4]}" if name == "column" else f"{where}, column {name}: {match[4]}"


# --- the table ----------------------------------------------------------------------------------------------


def _read(path: str | Path) -> tuple[Table, Build]:
    """The table of the file, with all values in their range, and the function that makes measurements of it."""
    source = validation.path("path", path)
    try:
        size = source.stat().st_size
        if size > LARGEST_FILE:
            raise ValueError(f"{path}: got {size} bytes, must be at most {LARGEST_FILE}")
        text = source.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise validation.unreadable(path, error) from None
    except UnicodeDecodeError as error:
        raise ValueError(f"{path}: got bytes that are not UTF-8 at {error.start}, must be text") from None
    numbered = [(i + 1, line) for i, line in enumerate(text.splitlines())]
    kept = [(i, line) for i, line in numbered if line.strip() and not line.lstrip().startswith("#")]
    if len(kept) < 2:
        raise ValueError(f"{path}: got {len(kept)} lines besides comments, must be a header and rows")
    (first, header), *body = kept
    where = f"{path}: line {first}"
    separator = _separator([line for _, line in kept])
    factors = _header(where, _cells(header, separator))
    build, known = _kind(where, [name for name, _ in factors])
    columns: dict[str, list[float]] = {name: [] for name, _ in factors if name in known}
    for number, line in body:
        cells = _cells(line, separator)
        if len(cells) != len(factors):
            raise ValueError(f"{path}: line {number}: got {len(cells)} cells, must be {len(factors)}")
        for (name, factor), cell in zip(factors, cells, strict=True):
            if name in known:
                columns[name].append(_number(f"{path}: line {number}, column {name}", name, cell, factor))
    ignored = tuple(name for name, _ in factors if name not in known)
    return Table(columns, [number for number, _ in body], first, known, ignored), build


def _separator(lines: Sequence[str]) -> str:
    """Comma, semicolon or tab; a comma if each line is one cell."""
    try:
        return csv.Sniffer().sniff("\n".join(lines[:SNIFFED]), SEPARATORS).delimiter
    except csv.Error:
        return ","


def _cells(line: str, separator: str) -> list[str]:
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator))]


def _header(where: str, cells: Sequence[str]) -> list[tuple[str, float]]:
    """Names, and the factor that converts each column to SI units."""
    columns: list[tuple[str, float]] = []
    for cell in cells:
        match = _HEADER.fullmatch(cell)
        name = match[1] if match else cell
        if match is None or name not in UNITS:
            columns.append((cell, math.nan))
            continue
        if name in dict(columns):
            raise ValueError(f"{where}: got column {name} twice, must appear once")
        try:
            columns.append((name, units.number(name, f"1 {match[2]}", UNITS[name]) if match[2] else 1.0))
        except ValueError as error:
            raise ValueError(f"{where}: {error}") from None
    return columns


def _number(where: str, name: str, cell: str, factor: float) -> float:
    value: float | str = cell
    with suppress(ValueError):
        value = float(cell) * factor
    lowest = -math.inf if name in ("time", "drop", "gap", *OBSERVED) else 0.0
    return validation.number(where, value, lowest, lowest_allowed=name.endswith("_error"))
