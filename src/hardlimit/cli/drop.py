"""``hardlimit drop``: one column under all models."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import click

from ..column import files
from ..column.comparison import Comparison, compare
from ..column.result import Result
from ..column.solvers import newton
from ..contact.compression import CompressionWarning
from ..support.progress import bar
from .drop_report import as_mapping, print_report, save_results
from .options import (
    column_from,
    column_options,
    dpi_option,
    film,
    options,
    output_option,
    picture,
    quantity_option,
    writable,
)
from .printing import print_json
from .program import Command

output_options = options(
    output_option("--plot", "Forces and heights over time (png, pdf, svg, …)."),
    dpi_option,
    output_option("--animate", "Slow-motion film (gif; mp4 with the extra hardlimit[film])."),
    output_option("--save", "Trajectory and contacts of all models as NetCDF.", "FILE.nc"),
    output_option("--toml", "The column as a TOML file that this command reads.", "FILE.toml"),
    click.option("--json", "as_json", is_flag=True, help="Print JSON."),
)


@click.command(
    cls=Command,
    epilog="\b\nExample:\n  hardlimit drop --restitution 0.9 --gap 1mm --plot drop.png",
)
@click.argument("file", required=False, metavar="[FILE.toml]")
@column_options
@quantity_option(
    "--until", unit="s", help="Follow the contacts to this time [s] after the first floor touch."
)
@output_options
def drop(file: str | None, until: float | None, dpi: float | None, as_json: bool, **given: Any) -> None:
    """Drop a column of balls: Newton beside event-driven.

    Without a file, the column is that of Fig. 2 of the paper: radii 10 cm and 1 cm, density 840 kg/m³, gap
    0.1 mm, height 0.6 m, linear law with stiffness 5e7 N/m and restitution 0.7. Options override the file.
    A number may bear a unit, such as 1mm or 7g/cm^3.
    """
    outputs = {
        "plot": picture("plot", given.pop("plot")),
        "animate": film("animate", given.pop("animate")),
        "save": writable("save", given.pop("save"), ".nc"),
        "toml": writable("toml", given.pop("toml"), ".toml"),
    }
    column = column_from(file, given)
    with warnings.catch_warnings(action="ignore", category=CompressionWarning):  # the report says so
        found = compare(column)
        shown = newton(column, until) if until is not None else found.newton
    write_outputs(found, shown, outputs, dpi)
    if as_json:
        print_json(as_mapping(found, shown))
    else:
        print_report(found, shown)


def write_outputs(
    found: Comparison, shown: Result, outputs: dict[str, Path | None], dpi: float | None
) -> None:
    """The files asked for; ``shown`` is Newton's result, to the time asked for."""
    if outputs["toml"]:
        files.write(shown.column, outputs["toml"])
    if outputs["plot"]:
        from .. import plots

        plots.save(plots.drop(shown, found.independent, found.adiabatic), outputs["plot"], dpi)
    if outputs["animate"]:
        from ..plots.animation import animate

        with bar("film") as report:
            animate(shown, outputs["animate"], ghost=found.independent, progress=report)
    if outputs["save"]:
        save_results((shown, *found.results[1:]), outputs["save"])
