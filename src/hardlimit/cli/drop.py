"""``hardlimit drop``: solve one column under all models."""

from __future__ import annotations

import math
import tomllib
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from .. import __version__
from ..column import files
from ..column.comparison import Comparison, compare
from ..column.models import MODELS
from ..column.result import Result, quantities
from ..column.scenario import Column
from ..column.solvers import newton
from ..contact import compression
from ..support import saving
from ..support.formatting import digits, length, quantity
from ..support.progress import bar, waiting
from ..sweep.variables import OF_BALL, OF_POINT
from .options import (
    LAW_PARAMETERS,
    F,
    dpi_option,
    film,
    json_option,
    law_options,
    law_text,
    options,
    output_option,
    picture,
    quantity_option,
    quantity_options,
    take_law,
    writable,
)
from .printing import console, plain, print_json, sentence, show, table
from .program import Command

if TYPE_CHECKING:
    import xarray as xr
    from rich.table import Table

BALL_OPTIONS = ("radii", "radius_1", "radius_2", "radius_ratio", "densities", "masses")
MOTION_OPTIONS = ("gaps", "velocities", "height", "gravity")
#: The search for a sufficient stiffness ends after this many factors of 10.
MAX_DECADES = 30


def column_options(function: F) -> F:
    """The options that describe a column; :func:`column_from` reads them."""
    repeat, if_different = "repeat it for each ball", "repeat it for each ball if they differ"
    rows = (
        ("--gap", "m", "Gap Δh between neighbours [m]; repeat it for each gap, the lowest first.", "gaps"),
        ("--radius-ratio", "1", "R1/R2 of the two lowest balls; changes the lower radius."),
        ("--radius-1", "m", "Radius R1 of the lowest ball [m]."),
        ("--radius-2", "m", "Radius R2 of the ball above it [m]."),
        ("--radius", "m", f"Radius [m]; {repeat}, the lowest first, for any number of balls.", "radii"),
        ("--density", "kg/m3", f"Density [kg/m³]; {if_different}.", "densities"),
        ("--mass", "kg", f"Mass [kg] instead of the density; {repeat}.", "masses"),
        ("--height", "m", "Height of the centre of the lowest ball at release, z1(0) [m]."),
        ("--velocity", "m/s", f"Velocity at release [m/s], upwards; {if_different}.", "velocities"),
        ("--gravity", "m/s2", "Acceleration of gravity g [m/s²]."),
    )
    return options(quantity_options(*rows), law_options())(function)


def column_from(file: str | None, params: dict[str, Any]) -> Column:
    """The column of the file, or of Fig. 2 without a file, changed by the options, which are taken out."""
    base = files.read_with(file)[0] if file else files.of_column(Column.paper())
    law, parameters = take_law(params)
    if law is not None or parameters:
        base = files.with_law(base, law, parameters)
    base = files.with_balls(base, **{name: params.pop(name) for name in BALL_OPTIONS})
    return files.with_motion(base, **{name: params.pop(name) for name in MOTION_OPTIONS}).column()


output_options = options(
    output_option("--plot", "Forces and heights over time (png, pdf, svg, …)."),
    dpi_option,
    output_option("--animate", "Slow-motion film (gif; mp4 with the extra hardlimit[film])."),
    output_option("--save", "Trajectory and contacts of all models as NetCDF.", "FILE.nc"),
    output_option("--toml", "Column as a TOML file that this command can read.", "FILE.toml"),
    json_option(),
)


@click.command(
    cls=Command,
    aliases={"file": "FILE"},
    epilog="\b\nExample:\n  hardlimit drop --restitution 0.9 --gap 1mm --plot drop.png",
)
@click.argument("file", required=False, metavar="[FILE.toml]")
@column_options
@quantity_option("--until", unit="s", help="End [s] of the run after the first floor touch.")
@output_options
def drop(file: str | None, until: float | None, dpi: float | None, as_json: bool, **params: Any) -> None:
    """Drop a column of balls: Newton's equations and event-driven.

    Without a file, the column is that of Fig. 2 of the paper: radii 10 cm and 1 cm, density 840 kg/m³, gap
    0.1 mm, height 0.6 m, linear law with stiffness 5e7 N/m and restitution 0.7. Options override the file.
    Numbers may have a unit, such as 1mm or 7g/cm^3.
    """
    outputs = {
        "plot": picture("plot", params.pop("plot")),
        "animate": film("animate", params.pop("animate")),
        "save": writable("save", params.pop("save"), ".nc"),
        "toml": writable("toml", params.pop("toml"), ".toml"),
    }
    column = column_from(file, params)
    # The report has its own line for deep compressions.
    with (
        warnings.catch_warnings(action="ignore", category=compression.CompressionWarning),
        waiting("drop"),
    ):
        comparison = compare(column)
        shown = newton(column, until) if until is not None else comparison.newton
        # Solves what follows the sequence; results keep it for the report.
        content = as_mapping(comparison, shown)
    write_outputs(comparison, shown, outputs, dpi)
    if as_json:
        print_json(content)
    else:
        print_report(comparison, shown)


def write_outputs(
    comparison: Comparison, shown: Result, outputs: dict[str, Path | None], dpi: float | None
) -> None:
    """Write the requested files; ``shown`` is the result of Newton's equations up to ``--until``."""
    if outputs["toml"]:
        files.write(shown.column, outputs["toml"])
    if outputs["plot"]:
        from .. import plots

        plots.save(plots.drop(shown, comparison.independent, comparison.adiabatic), outputs["plot"], dpi)
    if outputs["animate"]:
        from ..plots.animation import animate

        with bar("film") as report:
            animate(shown, outputs["animate"], ghost=comparison.independent, progress=report)
    if outputs["save"]:
        save_results((shown, *comparison.results[1:]), outputs["save"])


# --- as a table ---------------------------------------------------------------------------------------------


def print_report(comparison: Comparison, shown: Result) -> None:
    """Print column, contacts, comparison and verdict."""
    out = console()
    column = comparison.newton.column
    since = "the first floor touch" if column.floor else "release"
    show(out, "Column", column_table(column), column_line(column))
    show(out, f"Contacts under Newton’s equations [µs after {since}]", contact_table(shown))
    show(out, "Newton’s equations and event-driven", comparison_table(comparison))
    if depth := depth_line(shown):
        out.print(depth, style="yellow")
    answer, verdict = comparison.verdict
    colour = {"yes": "green", "no": "red", "by luck": "yellow"}.get(answer, "default")
    out.print("[bold]Is an event-driven simulation good enough here?[/bold]")
    out.print(verdict, style=colour)


def depth_line(result: Result) -> str:
    """A sentence on contacts that are too deep for a contact law; empty if none is."""
    said = compression.too_soft(result.largest_compression)
    if said is None or result._core.too_deep < 0:
        return sentence(said) if said else ""
    return f"{sentence(result.outcome)}{stiff_enough(result)}"


def stiff_enough(result: Result) -> str:
    """A sentence with a stiffness for which contacts are not too deep; empty if none is found."""
    column = result.column
    law = column.laws[0]
    name = next(iter(law.parameters))  # the elastic constant
    unit = LAW_PARAMETERS[name][0]["unit"]
    for factor in (10.0**decade for decade in range(1, MAX_DECADES + 1)):
        stiffer = [each.replace(**{name: each.parameters[name] * factor}) for each in column.laws]
        with warnings.catch_warnings(action="ignore", category=compression.CompressionWarning):
            stiffer_result = newton(column.replace(law=stiffer), result.until)
        if stiffer_result._core.too_deep < 0:
            shared = len(set(column.laws)) == 1
            enough = (
                f"of {digits(law.parameters[name] * factor)} {unit}"
                if shared
                else f"{factor:g} times as large"
            )
            return f" With a {name.replace('_', ' ')} {enough}, contacts are not too deep."
    return ""


def column_table(column: Column) -> Table:
    n, shared = len(column.balls), len(set(column.laws)) == 1
    below = [length(column.drop_height) if column.floor else "", *map(length, column.gaps)]
    columns = {
        "": [f"ball {i + 1}" for i in range(n)],
        "radius": [length(ball.radius) for ball in column.balls],
        "mass": [quantity(ball.mass * 1e3, "g") for ball in column.balls],
        "gap below": below,
    }
    if any(column.velocities):
        columns["velocity [m/s]"] = [digits(v) for v in column.velocities]
    if not shared:
        columns["law below"] = [*([] if column.floor else [""]), *map(law_text, column.laws)]
    return table(list(columns), list(zip(*columns.values(), strict=True))[::-1])


def column_line(column: Column) -> str:
    """A line with the values that are common to all balls."""
    parts = [law_text(column.laws[0])] if len(set(column.laws)) == 1 else []
    if column.floor:
        speed = digits(column.impact_speed)
        parts.append(f"g {digits(column.gravity)} m/s²; speed at the floor V {speed} m/s")
    return "; ".join(parts)


def pair_name(pair: int) -> str:
    return "floor – ball 1" if pair == 0 else f"ball {pair} – ball {pair + 1}"


def microseconds(seconds: float) -> str:
    return f"{seconds * 1e6:.3f}" if abs(seconds) < 1e3 else digits(seconds * 1e6)


def contact_table(result: Result, most: int = 40) -> Table:
    """Begin, end and duration of the contacts; a long list is cut in the middle."""
    rows = [
        [pair_name(int(pair)), microseconds(begin), microseconds(end), microseconds(end - begin)]
        for pair, begin, end in zip(*result.contact_times, strict=True)
    ]
    if len(rows) > most:
        half = most // 2
        rows = [*rows[:half], [f"… {len(rows) - most} more", "", "", ""], *rows[-half:]]
    return table(["pair", "begin", "end", "duration"], rows)


def comparison_table(comparison: Comparison) -> Table:
    """A table of the results of all models; quantities that no model has are omitted."""
    results = comparison.results
    rows = []
    for row in zip(*map(quantities, results), strict=True):
        label, values = row[0][0], [value for _, value in row]
        if all(map(math.isnan, values)):
            continue
        if label.endswith("[s]"):
            rows.append([label.replace("[s]", "[µs]"), *map(microseconds, values)])
        else:
            rows.append([label, *map(digits, values)])
    rows.append(["outcome", *(r.outcome.split(":")[0] for r in results)])
    return table(["", *(MODELS[r.model].short for r in results)], rows)


# --- for machines -------------------------------------------------------------------------------------------


def as_mapping(comparison: Comparison, shown: Result) -> dict[str, Any]:
    """Everything the tables show, in SI units."""
    answer, verdict = comparison.verdict
    return {
        "column": tomllib.loads(files.dumps(comparison.newton.column)),
        "impact_speed": comparison.newton.column.impact_speed,
        "models": {
            r.model: result_mapping(shown if r is comparison.newton else r, r) for r in comparison.results
        },
        "verdict": {"event_driven": answer, "sentence": verdict},
    }


def result_mapping(shown: Result, result: Result) -> dict[str, Any]:
    """A result; contacts and final state up to ``--until`` are those of ``shown``."""
    names = (
        *("n_contacts", "t_end", "t_floor_end", "relative_velocity", "separation_velocity"),
        *("effective_restitution", "effective_restitution_at_separation", "restitution_ratio"),
        *("restitution_ratio_at_separation", "largest_compression", "outcome", "method", "rebound_heights"),
    )
    values = {name: getattr(result, name) for name in names}
    values |= {"positions": shown.positions, "velocities": shown.velocities}
    values["contacts"] = dict(zip(("pair", "begin", "end"), shown.contact_times, strict=True))
    mapping: dict[str, Any] = plain(values)
    return mapping


def save_results(results: tuple[Result, ...], path: Path) -> Path:
    """Save a table of the models at the root of a NetCDF file, and the trajectory and the contacts of each as groups,
    such as ``newton/trajectory``."""
    groups = {"/": saving.mark(model_table(results), "drop")}
    for result in results:
        facts = {"model": result.model, "method": result.method, "outcome": result.outcome}
        groups[f"{result.model}/trajectory"] = result.trajectory().assign_attrs(facts)
        groups[f"{result.model}/contacts"] = result.contacts.assign_attrs(facts)
    return saving.groups(groups, path)


def model_table(results: tuple[Result, ...]) -> xr.Dataset:
    """The variables of a sweep for one column, over ``model``."""
    import xarray as xr

    column = results[0].column
    data: dict[str, Any] = {
        name: ("model", [getattr(result, name) for result in results], variable.attributes())
        for name, variable in OF_POINT.items()
    }
    for name, plural in zip(OF_BALL, ("rebound_heights", "final_velocities"), strict=True):
        values = [getattr(result, plural) for result in results]
        data[name] = (("model", "ball"), values, OF_BALL[name].attributes())
    data["outcome"] = ("model", [result.outcome for result in results])
    coordinates = {"model": [result.model for result in results], "ball": range(1, len(column.balls) + 1)}
    about = {"title": "hardlimit drop", "source": f"hardlimit {__version__}", "column": repr(column)}
    return xr.Dataset(data, coordinates, about | {"toml": files.dumps(column)})
