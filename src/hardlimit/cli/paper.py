"""``hardlimit paper``: compute the figures of the paper and check its statements."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import click

from ..column.scenario import PAPER_DENSITY
from .options import dpi_option, json_option, quantity_option
from .printing import console, print_json
from .program import Command

if TYPE_CHECKING:
    from ..paper import Report, Row

MARKS = {"yes": ("✓", "green"), "partly": ("~", "yellow"), "no": ("✗", "red"), "misprint": ("≠", "magenta")}


@click.command(cls=Command, epilog="\b\nExample:\n  hardlimit paper --figures 2,3 --out figures --format pdf")
@click.option("--figures", metavar="LIST", help="Figures to compute, such as 2,3,4.  [default: all]")
@click.option(
    "--out",
    metavar="FOLDER",
    default="hardlimit-paper",
    show_default=True,
    help="Folder for pictures, data and report.",
)
@quantity_option(
    "--density",
    unit="kg/m3",
    default=PAPER_DENSITY,
    show_default=True,
    help="Density of the balls [kg/m³]; inferred, since the paper does not state it.",
)
@click.option(
    "--format", "picture", default="png", show_default=True, help="Format of the pictures: png, pdf or svg."
)
@dpi_option
@click.option("--infer-density", is_flag=True, help="Repeat the inference of the density.")
@click.option("--all", "everything", is_flag=True, help="Print all statements, including those that agree.")
@json_option()
def paper(
    figures: str | None,
    out: str,
    density: float,
    picture: str,
    dpi: float | None,
    infer_density: bool,
    everything: bool,
    as_json: bool,
) -> None:
    """Compute Figures 2–8 of the paper and check its statements.

    The paper is Müller and Pöschel, Phys. Rev. E 83, 041304 (2011). This writes each figure as a picture and as data
    (NetCDF), and report.md with every statement and its result. It prints the statements that do not agree, or agree
    only in part.
    """
    from ..paper import run

    with fraction_progress("paper") as report:
        found = run(out, figures, density, picture, infer_density, progress=report, dpi=dpi)
    if as_json:
        print_json(found.to_dict())
    else:
        print_report(found, everything)


@contextmanager
def fraction_progress(title: str) -> Iterator[Callable[[float, str], None]]:
    """A progress bar on stderr; the function that it yields takes the completed fraction and the current step."""
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


def print_report(found: Report, everything: bool = False) -> None:
    """Print the statements that do not agree (with ``everything`` all statements), and a summary."""
    from rich.text import Text

    out = console()
    out.print(legend())
    out.print()
    tables = [
        ("Statements that do not agree, or agree only in part", found.chosen("statement", "no", "partly"))
    ]
    if everything:
        tables.append(("Statements that agree", found.chosen("statement", "yes")))
    tables += [("Density", found.chosen("density")), ("Misprints", found.chosen("misprint"))]
    for title, rows in tables:
        if rows:
            out.print(Text(title, style="bold"))
            out.print(statement_table(rows))
            out.print()
    for number, sentence in found.meanings.items():
        out.print(Text.assemble((f"Fig. {number}  ", "bold"), sentence))
    out.print()
    out.print(Text(f"{found.summary()}.", style="bold"))
    rest = "" if everything else " (--all prints them)"
    out.print(Text(f"All statements: {found.out / 'report.md'}{rest}."))
    out.print(Text(f"{len(found.files)} files in {found.out}, {found.wall_time:.1f} s."))


def legend() -> Any:
    """The meaning of the marks in the tables."""
    from rich.text import Text

    from ..paper.report import VERDICTS

    parts = [(f"{MARKS[verdict][0]} {means}", MARKS[verdict][1]) for verdict, means in VERDICTS.items()]
    return Text("   ").join(Text(text, style=colour) for text, colour in parts)


def statement_table(rows: list[Row]) -> Any:
    """Statements with verdict, place in the paper and result."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    made = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, leading=1)
    made.add_column("verdict", width=8)
    made.add_column("statement", ratio=4)
    made.add_column("where", ratio=1, min_width=9)
    made.add_column("result", ratio=4)
    for row in rows:
        mark, colour = MARKS[row.agrees]
        verdict = Text(f"{mark} {row.agrees}" if row.agrees != "misprint" else mark, style=colour)
        made.add_row(verdict, Text(row.statement), Text(row.where), Text(row.result))
    return made
