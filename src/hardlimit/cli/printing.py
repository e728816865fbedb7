"""Output of results: tables for people, JSON for machines."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from .program import in_options

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table


def console(stderr: bool = False) -> Console:
    """A console as wide as the terminal, 100 columns at most."""
    from rich.console import Console

    output = Console(stderr=stderr, highlight=False)
    output.width = min(output.width, 100)
    return output


def table(columns: Sequence[str], rows: Iterable[Sequence[str]], left: int = 1) -> Table:
    """A table whose first columns are left-aligned, ``left`` of them, and the others right-aligned."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    sheet = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, show_header=any(columns))
    for i, name in enumerate(columns):
        sheet.add_column(Text(name), justify="left" if i < left else "right", overflow="fold")
    for row in rows:
        sheet.add_row(*map(Text, row))
    return sheet


def show(out: Console, title: str, content: Table, below: str = "") -> None:
    """Print a table with a title above it, a line below it if given, and an empty line at the end."""
    from rich.text import Text

    out.print(Text(title, style="bold"))
    out.print(content)
    if below:
        out.print(Text(below))
    out.print()


def sentence(text: str) -> str:
    """The text with a capital letter and a full stop."""
    return f"{text[0].upper() if text[0].isascii() else text[0]}{text[1:]}{'' if text.endswith('.') else '.'}"


def print_outcome(out: Console, outcome: str, files: Iterable[Path] = ()) -> None:
    """Print the outcome of a run, with options in place of what it has of Python, and the files that were written."""
    out.print(
        f"outcome: {in_options(outcome)}", style="default" if outcome == "ok" else "yellow", markup=False
    )
    print_files(out, files)


def print_files(out: Console, files: Iterable[Path | str]) -> None:
    """Print the files that were written, one line each."""
    for path in files:
        out.print(f"written to {path}", markup=False)


def print_warnings(command: str, warnings: Iterable[Any]) -> None:
    """Print recorded warnings on stderr, one line each."""
    for warning in warnings:
        console(stderr=True).print(f"hardlimit {command}: {warning.message}", markup=False, soft_wrap=True)


def print_json(content: Any) -> None:
    """Print JSON on stdout; NaN and infinity become null."""
    click.echo(json.dumps(plain(content), ensure_ascii=False, indent=2, allow_nan=False))


def plain(value: Any) -> Any:
    """The same value for JSON: arrays as lists, NumPy scalars as numbers, NaN and infinity as None."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, dict):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return str(value) if isinstance(value, Path) else value
