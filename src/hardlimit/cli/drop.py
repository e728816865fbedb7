"""``hardlimit drop``: one column under all models."""

from __future__ import annotations

import math
import tomllib
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..column import files
from ..column.comparison import Comparison, compare, final_velocities, rebound_heights
from ..column.result import Result
from ..column.scenario import Column
from ..column.solvers import newton
from ..contact import Law
from .common import (
    NUMBER,
    Command,
    Number,
    console,
    digits,
    given_law_parameters,
    law_options,
    length,
    plain,
    print_json,
    progress,
    quantity,
    show,
    table,
    writable,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from rich.table import Table

MODEL_NAMES = {"newton": "Newton", "adiabatic": "adiabatic", "independent": "independent"}


BALL_OPTIONS = ("radii", "radius_1", "radius_2", "radius_ratio", "densities", "masses")
MOTION_OPTIONS = ("gaps", "velocities", "height", "gravity")


def column_options(number: Number = NUMBER) -> Callable[[Any], Any]:
    """The options that describe a column; :func:`column_from` reads them."""

    def decorate(function: Any) -> Any:
        for option in reversed(
            (
                click.option(
                    "--gap", "gaps", type=number, multiple=True, help="Δh [m]; repeat for more balls."
                ),
                click.option("--radius-ratio", type=number, help="R1/R2; changes the lower radius."),
                click.option("--radius-1", type=number, help="R1 [m], the lowest ball."),
                click.option("--radius-2", type=number, help="R2 [m], the next ball."),
                click.option(
                    "--radius", "radii", type=number, multiple=True, help="[m], repeated, bottom first."
                ),
                click.option(
                    "--density", "densities", type=number, multiple=True, help="[kg/m³], of all or each."
                ),
                click.option("--mass", "masses", type=number, multiple=True, help="[kg], of each ball."),
                click.option(
                    "--height", type=number, help="z1(0) [m], centre of the lowest ball at release."
                ),
                click.option("--velocity", "velocities", type=number, multiple=True, help="[m/s], upwards."),
                click.option("--gravity", type=number, help="g [m/s²]."),
                law_options(number),
            )
        ):
            function = option(function)
        return function

    return decorate


def column_from(base: files.Scenario, options: dict[str, Any]) -> Column:
    """The column of the file or the preset, changed by the options, which are taken out."""
    law = options.pop("law")
    parameters = given_law_parameters(options)
    if law is not None or parameters:
        base = files.with_law(base, law, parameters)
    base = files.with_balls(base, **{name: options.pop(name) for name in BALL_OPTIONS})
    return files.with_motion(base, **{name: options.pop(name) for name in MOTION_OPTIONS}).column()


@click.command(
    cls=Command,
    epilog="\b\nExample:\n  hardlimit drop --restitution 0.9 --gap 1e-3 --plot drop.png",
)
@click.argument("file", required=False, metavar="[FILE.toml]")
@column_options()
@click.option(
    "--until", type=NUMBER, help="Follow the contacts to this time [s] after the first floor touch."
)
@click.option("--plot", metavar="FILE", help="Forces and heights over time (png, pdf, svg, …).")
@click.option("--dpi", type=NUMBER, help="Resolution of --plot.  [default: 200]")
@click.option("--animate", metavar="FILE", help="Slow-motion film (mp4, gif).")
@click.option("--save", metavar="FILE.nc", help="Trajectory and contacts of all models as NetCDF.")
@click.option("--toml", metavar="FILE", help="The column as a TOML file that this command reads.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def drop(
    file: str | None,
    until: float | None,
    plot: str | None,
    dpi: float | None,
    animate: str | None,
    save: str | None,
    toml: str | None,
    as_json: bool,
    **options: Any,
) -> None:
    """Drop a column of balls: contacts, and Newton beside event-driven.

    Without a file, the column is that of Fig. 2 of the paper: radii 10 cm and 1 cm, density 840 kg/m³, gap
    0.1 mm, height 0.6 m, linear law with stiffness 5e7 N/m and restitution 0.7. Options override the file.
    """
    base = files.read_with(file)[0] if file else files.of_column(Column.paper())
    column = column_from(base, options)
    outputs = {name: writable(name, p) for name, p in (("plot", plot), ("save", save), ("toml", toml))}
    film = writable("animate", animate)
    found = compare(column)
    shown = newton(column, until) if until is not None else found.newton
    if toml:
        files.write(column, toml)
    if outputs["plot"]:
        from ..pictures import plots

        picture = found if until is None else compare(column)
        plots.save(plots.drop(shown, picture.independent, picture.adiabatic), outputs["plot"], dpi)
    if film:
        from ..pictures.animation import animate as write_film

        with progress("film") as report:
            write_film(shown, film, ghost=found.independent, progress=report)
    if outputs["save"]:
        save_results((shown, *found.results[1:]), outputs["save"])
    if as_json:
        print_json(as_mapping(found, shown))
    else:
        print_report(found, shown)


# --- as a table ---------------------------------------------------------------------------------------------


def print_report(found: Comparison, shown: Result) -> None:
    out = console()
    column = found.newton.column
    since = "the first floor touch" if column.floor else "release"
    show(out, "Column", column_table(column), column_line(column))
    show(out, f"Contacts under Newton’s equations [µs after {since}]", contact_table(shown))
    show(out, "Newton’s equations and event-driven", comparison_table(found))
    answer, sentence = found.verdict
    colour = {"yes": "green", "no": "red", "by luck": "yellow"}.get(answer, "default")
    out.print("[bold]May you use event-driven here?[/bold]")
    out.print(sentence, style=colour)


def column_table(column: Column) -> Table:
    rows = []
    moving = any(column.velocities)
    for i in reversed(range(len(column.balls))):
        ball = column.balls[i]
        gap = column.gaps[i - 1] if i else column.drop_height
        where = f"{length(gap)}" if i or column.floor else ""
        row = [f"ball {i + 1}", length(ball.radius), quantity(ball.mass * 1e3, "g"), where]
        if moving:
            row.append(digits(column.velocities[i]))
        if len(set(column.laws)) > 1:
            law = i if column.floor else i - 1
            row.append(law_text(column.laws[law]) if law >= 0 else "")
        rows.append(row)
    names = ["", "radius", "mass", "gap below"]
    names += ["velocity [m/s]"] if moving else []
    return table(names + (["law below"] if len(set(column.laws)) > 1 else []), rows)


def column_line(column: Column) -> str:
    """What holds for the whole column."""
    parts = []
    if len(set(column.laws)) == 1:
        law = column.laws[0]
        parts.append(f"{law.record['name']} law: {law_text(law)}")
    if column.floor:
        parts += [
            f"g {digits(column.gravity)} m/s²",
            f"speed at the floor V {digits(column.impact_speed)} m/s",
        ]
    return "; ".join(parts)


def law_text(law: Law) -> str:
    """The law's parameters as the user gave them."""
    short = {
        "restitution": "ε",
        "stiffness": "k",
        "damping": "γ",
        "youngs_modulus": "Y",
        "poisson_ratio": "ν",
    }
    short |= {"dissipative_time": "A", "impact_speed": "v"}
    record = files.law_parameters(type(law))
    parts = []
    for name, value in law.parameters.items():
        unit = record[name]["unit"]
        parts.append(f"{short.get(name, name)} {digits(value)}{'' if unit == '1' else ' ' + unit}")
    return ", ".join(parts)


def pair_name(pair: int) -> str:
    return "floor – ball 1" if pair == 0 else f"ball {pair} – ball {pair + 1}"


def microseconds(seconds: float) -> str:
    return f"{seconds * 1e6:.3f}" if abs(seconds) < 1e3 else digits(seconds * 1e6)


def contact_table(result: Result, most: int = 40) -> Table:
    """Begin, end and duration of the contacts; a long list is cut in the middle."""
    found = result.contacts
    rows = [
        [pair_name(int(pair)), microseconds(begin), microseconds(end), microseconds(end - begin)]
        for pair, begin, end in zip(
            found["pair"].values, found["begin"].values, found["end"].values, strict=True
        )
    ]
    if len(rows) > most:
        half = most // 2
        rows = [*rows[:half], [f"… {len(rows) - most} more", "", "", ""], *rows[-half:]]
    return table(["pair", "begin", "end", "duration"], rows)


def comparison_table(found: Comparison) -> Table:
    results = found.results
    names = ["", *(MODEL_NAMES[r.model] for r in results)]
    rows = [[label, *(text(r) for r in results)] for label, text in comparison_rows(found.newton.column)]
    rows.append(["outcome", *(r.outcome.split(":")[0] for r in results)])
    return table(names, rows)


def comparison_rows(column: Column) -> list[tuple[str, Callable[[Result], str]]]:
    two = len(column.balls) == 2 and column.floor
    rows: list[tuple[str, Callable[[Result], str]]] = [
        ("ball–ball contacts", lambda r: str(r.n_contacts)),
        ("end of the sequence t_f [µs]", lambda r: microseconds(r.t_end)),
    ]
    if column.floor:
        rows.append(("end of the floor contact [µs]", lambda r: microseconds(r.t_floor_end)))
    if two:
        rows += [
            ("relative velocity v'r at t_f [m/s]", lambda r: digits(r.relative_velocity)),
            ("separation velocity [m/s]", lambda r: digits(r.separation_velocity)),
            ("effective ε at t_f", lambda r: digits(r.effective_restitution)),
            ("effective ε at separation", lambda r: digits(r.effective_restitution_at_separation)),
        ]
        if not math.isnan(column.specified_restitution):
            rows += [
                ("effective ε / ε at t_f", lambda r: digits(r.restitution_ratio)),
                ("effective ε / ε at separation", lambda r: digits(r.restitution_ratio_at_separation)),
            ]
    for i in reversed(range(len(column.balls))):
        rows.append((f"final velocity of ball {i + 1} [m/s]", partial(_of_ball, final_velocities, i)))
    for i in reversed(range(len(column.balls) if column.gravity else 0)):
        rows.append((f"rebound height of ball {i + 1} [m]", partial(_of_ball, rebound_heights, i)))
    return rows


def _of_ball(values: Callable[[Result], Any], i: int, result: Result) -> str:
    return digits(float(values(result)[i]))


# --- for machines -------------------------------------------------------------------------------------------


def as_mapping(found: Comparison, shown: Result) -> dict[str, Any]:
    """Everything the tables show, in SI units."""
    answer, sentence = found.verdict
    return {
        "column": tomllib.loads(files.dumps(found.newton.column)),
        "impact_speed": found.newton.column.impact_speed,
        "models": {r.model: result_mapping(shown if r is found.newton else r, r) for r in found.results},
        "verdict": {"event_driven": answer, "sentence": sentence},
    }


def result_mapping(shown: Result, result: Result) -> dict[str, Any]:
    """One result; contacts and final state of ``shown``, the rest of ``result``."""
    names = (
        "n_contacts",
        "t_end",
        "t_floor_end",
        "relative_velocity",
        "separation_velocity",
        "effective_restitution",
        "effective_restitution_at_separation",
        "restitution_ratio",
        "restitution_ratio_at_separation",
        "outcome",
        "method",
    )
    values = {name: getattr(result, name) for name in names}
    contacts = {str(name): shown.contacts[name].values for name in shown.contacts.data_vars}
    state = {"positions": shown.positions, "velocities": shown.velocities}
    heights = {"rebound_heights": rebound_heights(result)}
    mapping: dict[str, Any] = plain({**values, **state, **heights, "contacts": contacts})
    return mapping


def save_results(results: tuple[Result, ...], path: Path) -> Path:
    """Trajectory and contacts of each model as groups of one NetCDF file: ``newton/trajectory``, ….

    Raises
    ------
    ValueError
        If the file cannot be written.
    """
    import xarray as xr

    column = results[0].column
    try:
        about = {"title": "hardlimit drop", "column": repr(column), "toml": files.dumps(column)}
        xr.Dataset(attrs=about).to_netcdf(path, mode="w", engine="h5netcdf")
        for result in results:
            facts = {"model": result.model, "method": result.method, "outcome": result.outcome}
            for name, data in (("trajectory", result.trajectory()), ("contacts", result.contacts)):
                data.assign_attrs(facts).to_netcdf(
                    path, mode="a", engine="h5netcdf", group=f"{result.model}/{name}"
                )
    except OSError as error:
        raise ValueError(f"--save: got {str(path)!r}, must be writable: {error}") from None
    return path
