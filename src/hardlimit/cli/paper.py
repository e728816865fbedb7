"""``hardlimit paper``: compute the figures of the paper and check its statements."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from ..column.scenario import PAPER_DENSITY
from ..support.progress import bar
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
    help=f"Density of the balls [kg/m³]; the paper states none.  [default: {PAPER_DENSITY:g}, inferred]",
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
    density: float | None,
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

    density = PAPER_DENSITY if density is None else density
    with bar("paper") as report:

        def tell(part: float, step: str) -> None:
            report.note = step
            report(round(1000.0 * part), 1000)

        result = run(out, figures, density, picture, infer_density, progress=tell, dpi=dpi)
    if as_json:
        print_json(result.to_dict())
    else:
        print_report(result, everything)


def print_report(report: Report, everything: bool = False) -> None:
    """Print the statements that do not agree (all statements if ``everything``), and a summary."""
    from rich.text import Text

    from ..paper.report import AGREE

    out = console()
    out.print(legend())
    out.print()
    for title, rows in report.tables():
        if rows and (everything or title != AGREE):
            out.print(Text(title, style="bold"))
            out.print(statement_table(rows))
            out.print()
    for number, sentence in report.meanings.items():
        out.print(Text.assemble((f"Fig. {number}  ", "bold"), sentence))
    out.print()
    out.print(Text(f"{report.summary()}.", style="bold"))
    rest = "" if everything else " (--all prints them)"
    out.print(Text(f"All statements: {report.out / 'report.md'}{rest}."))
    out.print(Text(f"{len(report.files)} files in {report.out}, {report.wall_time:.1f} s."))


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

    sheet = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, leading=1)
    sheet.add_column("verdict", width=8)
    sheet.add_column("statement", ratio=4)
    sheet.add_column("where", ratio=1, min_width=9)
    sheet.add_column("result", ratio=4)
    for row in rows:
        mark, colour = MARKS[row.agrees]
        verdict = Text(f"{mark} {row.agrees}" if row.agrees != "misprint" else mark, style=colour)
        sheet.add_row(verdict, Text(row.statement), Text(row.where), Text(row.result))
    return sheet
