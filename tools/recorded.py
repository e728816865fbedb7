"""A file of what codes do with scripts: the command line of the tools that write it, and its rows."""

import argparse
import csv
from collections.abc import Iterable, Sequence
from pathlib import Path


def arguments(meaning: str | None) -> argparse.Namespace:
    """``file``, and ``only``: a part of the names of the scripts that run."""
    parser = argparse.ArgumentParser(
        description=meaning, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("file", type=Path)
    parser.add_argument("--only", default="", help="only scripts whose name contains this")
    return parser.parse_args()


def rows_of(path: Path) -> dict[str, dict[str, object]]:
    """The rows that the file has, by script."""
    if not path.exists():
        return {}
    with path.open(encoding="utf-8") as file:
        return {row["script"]: dict(row) for row in csv.DictReader(file)}


def write(path: Path, columns: Sequence[str], rows: Iterable[dict[str, object]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, columns, lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
