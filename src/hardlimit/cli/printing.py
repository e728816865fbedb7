"""How results are printed: tables for people, JSON for machines."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table


def console(stderr: bool = False) -> Console:
    """Where to print: as wide as the terminal, 100 columns at most."""
    from rich.console import Console

    wide = Console(stderr=stderr, highlight=False)
    wide.width = min(wide.width, 100)
    return wide


def table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> Table:
    """A table with the first column to the left and numbers to the right."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    made = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False)
    for i, name in enumerate(columns):
        made.add_column(Text(name), justify="left" if i == 0 else "right", overflow="fold")
    for row in rows:
        made.add_row(*map(Text, row))
    return made


def show(out: Console, title: str, content: Table, below: str = "") -> None:
    """A table under its title, with a line below if given and a blank line after it."""
    from rich.text import Text

    out.print(Text(title, style="bold"))
    out.print(content)
    if below:
        out.print(Text(below))
    out.print()


def digits(value: float, significant: int = 6) -> str:
    """A number for a table; a dash where there is none."""
    if math.isnan(value):
        return "–"
    text = re.sub(r"e([+-])0*(\d+)$", lambda m: f"e{m[1].replace('+', '')}{m[2]}", f"{value:.{significant}g}")
    return f"−{text[1:]}" if text.startswith("-") else text


PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))


def quantity(value: float, unit: str, significant: int = 6) -> str:
    """A number with a prefixed unit, such as ``0.1 mm``; plain where no prefix fits."""
    if value == 0.0 or not math.isfinite(value):
        return f"{digits(value)} {unit}"
    for factor, prefix in PREFIXES:
        if abs(value) >= 0.9999999 * factor:
            return f"{digits(value / factor, significant)} {prefix}{unit}"
    return f"{digits(value, significant)} {unit}"


def length(metres: float) -> str:
    """A length in the unit people say: 60 cm, 1 cm, 0.1 mm, 3 µm."""
    for limit, factor, unit in ((1.0, 1.0, "m"), (5e-3, 1e-2, "cm"), (2e-5, 1e-3, "mm")):
        if abs(metres) >= limit:
            return f"{digits(metres / factor)} {unit}"
    return quantity(metres, "m") if metres else "0"


def print_json(content: Any) -> None:
    """JSON on stdout; what is not a finite number becomes null."""
    click.echo(json.dumps(plain(content), ensure_ascii=False, indent=2, allow_nan=False))


def plain(value: Any) -> Any:
    """Arrays as lists, NumPy scalars as numbers, NaN and infinity as None."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, dict):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return str(value) if isinstance(value, Path) else value
