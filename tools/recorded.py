"""A file of what codes do: the command line of the tools that write it, and its rows."""

import argparse
import csv
from collections.abc import Iterable, Sequence
from pathlib import Path


def command_line(meaning: str | None) -> argparse.ArgumentParser:
    """A parser of ``file``."""
    parser = argparse.ArgumentParser(
        description=meaning, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("file", type=Path)
    return parser


def arguments(meaning: str | None) -> argparse.Namespace:
    """``file``, and ``only``: a part of the names of the scripts that run."""
    parser = command_line(meaning)
    parser.add_argument("--only", default="", help="only scripts whose name contains this")
    return parser.parse_args()


def all_rows_of(path: Path, key: str = "script") -> dict[str, list[dict[str, object]]]:
    """The rows that the file has, by script."""
    rows: dict[str, list[dict[str, object]]] = {}
    if path.exists():
        with path.open(encoding="utf-8") as file:
            for row in csv.DictReader(file):
                rows.setdefault(row[key], []).append(dict(row))
    return rows


def rows_of(path: Path) -> dict[str, dict[str, object]]:
    """The row that the file has of each script."""
    return {script: rows[-1] for script, rows in all_rows_of(path).items()}


def write(path: Path, columns: Sequence[str], rows: Iterable[dict[str, object]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, columns, lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


def floor(side: float, centre: float = 0.0) -> str:
    """STL file of a square in the plane z = 0, whose centre is at this x and y."""
    a, b = centre - side / 2, centre + side / 2
    lines = ["solid floor"]
    for corners in (((a, a), (b, a), (b, b)), ((a, a), (b, b), (a, b))):
        vertices = [f"vertex {x:g} {y:g} 0" for x, y in corners]
        lines += ["facet normal 0 0 1", "outer loop", *vertices, "endloop", "endfacet"]
    return "\n".join([*lines, "endsolid floor", ""])
