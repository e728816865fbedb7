"""``hardlimit paper``: every figure and statement of the paper."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import click

from ..column.scenario import PAPER_DENSITY
from .options import quantity_option
from .printing import console, print_json
from .program import Command

if TYPE_CHECKING:
    from ..paper import Report

MARKS = {"yes": ("✓", "green"), "partly": ("~", "yellow"), "no": ("✗", "red")}
TITLES = {"statement": "What the paper states", "density": "Density", "misprint": "Misprints"}


@click.command(cls=Command, epilog="\b\nExample:\n  hardlimit paper --figures 2,3 --out figures --format pdf")
@click.option("--figures", metavar="LIST", help="Such as 2,3,4.  [default: all]")
@click.option("--out", metavar="FOLDER", default="hardlimit-paper", show_default=True)
@quantity_option(
    "--density", unit="kg/m3", default=PAPER_DENSITY, show_default=True, help="[kg/m³], inferred."
)
@click.option("--format", "picture", default="png", show_default=True, help="png, pdf or svg.")
@click.option("--infer-density", is_flag=True, help="Repeat the inference of the density.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def paper(
    figures: str | None, out: str, density: float, picture: str, infer_density: bool, as_json: bool
) -> None:
    """Compute Figures 2–8 of the paper and check what its text states.

    Müller and Pöschel, Phys. Rev. E 83, 041304 (2011). Writes every figure as a picture and as data (NetCDF),
    and prints each statement with what comes out.
    """
    from ..paper import run

    with fraction_progress("paper") as report:
        found = run(out, figures, density, picture, infer_density, progress=report)
    if as_json:
        print_json(found.to_dict())
    else:
        print_report(found)


@contextmanager
def fraction_progress(title: str) -> Iterator[Callable[[float, str], None]]:
    """A progress bar on stderr, fed with (part from 0 to 1, what is being done)."""
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    out = console(stderr=True)
    columns = (
        TextColumn("{task.description:24.24}"),
        BarColumn(),
        TaskProgressColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=out, transient=True, disable=not out.is_terminal) as bar:
        task = bar.add_task(title, total=1.0)
        yield lambda part, text: bar.update(task, completed=part, description=text)


def print_report(found: Report) -> None:
    from rich.text import Text

    out = console()
    for kind, title in TITLES.items():
        rows = [row for row in found.rows if row.kind == kind]
        if rows:
            out.print(Text(title, style="bold"))
            out.print(statement_table(rows))
            out.print()
    for number, sentence in found.meanings.items():
        out.print(Text.assemble((f"Fig. {number}  ", "bold"), sentence))
    stated = [row.agrees for row in found.rows if row.kind == "statement"]
    summary = f"{stated.count('yes')} of {len(stated)} statements agree"
    if stated.count("partly"):
        summary += f", {stated.count('partly')} in part"
    if stated.count("no"):
        summary += f", {stated.count('no')} not"
    out.print()
    out.print(
        Text(f"{summary}. {len(found.files)} files in {found.out}, {found.wall_time:.1f} s", style="bold")
    )


def statement_table(rows: list[Any]) -> Any:
    """Statement, place in the paper, result and agreement, as wide as the terminal allows."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    made = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, leading=1)
    made.add_column("statement", ratio=5)
    made.add_column("where", ratio=2)
    made.add_column("what comes out", ratio=4)
    made.add_column("", width=1)
    for row in rows:
        mark, colour = MARKS[row.agrees]
        made.add_row(Text(row.statement), Text(row.where), Text(row.result), Text(mark, style=colour))
    return made
