"""What ``hardlimit drop`` prints and saves."""

from __future__ import annotations

import math
import tomllib
import warnings
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..column import files
from ..column.comparison import Comparison
from ..column.models import MODELS
from ..column.result import Result
from ..column.scenario import Column
from ..column.solvers import newton
from ..contact import compression
from ..contact.contact import Law, law_parameters
from ..support import saving
from .printing import console, digits, length, plain, quantity, show, table

if TYPE_CHECKING:
    from rich.table import Table

#: Letters for the parameters of laws; others are written out.
SYMBOLS = {
    "restitution": "ε",
    "stiffness": "k",
    "damping": "γ",
    "youngs_modulus": "Y",
    "poisson_ratio": "ν",
    "dissipative_time": "A",
    "impact_speed": "v",
}

#: A stiffness that is high enough is looked for in steps of ten, so many at most.
MOST_DECADES = 30

# --- as a table ---------------------------------------------------------------------------------------------


def print_report(found: Comparison, shown: Result) -> None:
    out = console()
    column = found.newton.column
    since = "the first floor touch" if column.floor else "release"
    show(out, "Column", column_table(column), column_line(column))
    show(out, f"Contacts under Newton’s equations [µs after {since}]", contact_table(shown))
    show(out, "Newton’s equations and event-driven", comparison_table(found))
    if depth := depth_line(shown):
        out.print(depth, style="yellow")
    answer, sentence = found.verdict
    colour = {"yes": "green", "no": "red", "by luck": "yellow"}.get(answer, "default")
    out.print("[bold]May you use event-driven here?[/bold]")
    out.print(sentence, style=colour)


def depth_line(result: Result) -> str:
    """What is to be said of the greatest compression; nothing where it is small."""
    said = compression.too_soft(result.largest_compression)
    if said is None:
        return ""
    if result._core.too_deep < 0:
        return f"{said[0].upper()}{said[1:]}."
    return f"{result.outcome[0].upper()}{result.outcome[1:]}.{stiff_enough(result)}"


def stiff_enough(result: Result) -> str:
    """A sentence with a stiffness under which the column does not become too deep."""
    column = result.column
    law = column.laws[0]
    name = next(iter(law.parameters))  # the elastic constant
    with warnings.catch_warnings(action="ignore", category=compression.CompressionWarning):
        for decade in range(1, MOST_DECADES + 1):
            stiffer = [each.replace(**{name: each.parameters[name] * 10.0**decade}) for each in column.laws]
            if newton(column.replace(law=stiffer), result.until)._core.too_deep < 0:
                break
        else:
            return ""
    unit = law_parameters(type(law))[name]["unit"]
    value = law.parameters[name] * 10.0**decade
    enough = f"{digits(value)} {unit}" if len(set(column.laws)) == 1 else f"{10.0**decade:g} times as much"
    return f" With {name.replace('_', ' ')} {enough} it does not come to that."


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
    record = law_parameters(type(law))
    parts = []
    for name, value in law.parameters.items():
        unit = record[name]["unit"]
        parts.append(f"{SYMBOLS.get(name, name)} {digits(value)}{'' if unit == '1' else ' ' + unit}")
    return ", ".join(parts)


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


def comparison_table(found: Comparison) -> Table:
    results = found.results
    names = ["", *(MODELS[r.model].short for r in results)]
    rows = [[label, *(text(r) for r in results)] for label, text in comparison_rows(found.newton.column)]
    rows.append(["outcome", *(r.outcome.split(":")[0] for r in results)])
    return table(names, rows)


def comparison_rows(column: Column) -> list[tuple[str, Callable[[Result], str]]]:
    two = len(column.balls) == 2 and column.floor
    rows: list[tuple[str, Callable[[Result], str]]] = [("ball–ball contacts", lambda r: str(r.n_contacts))]
    if len(column.balls) > 1:
        rows.append(("end of the sequence t_f [µs]", lambda r: microseconds(r.t_end)))
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
    rows.append(("largest compression [smaller radius]", lambda r: digits(r.largest_compression)))
    for i in reversed(range(len(column.balls))):
        rows.append((f"final velocity of ball {i + 1} [m/s]", partial(_of_ball, "final_velocities", i)))
    for i in reversed(range(len(column.balls) if column.gravity else 0)):
        rows.append((f"rebound height of ball {i + 1} [m]", partial(_of_ball, "rebound_heights", i)))
    return rows


def _of_ball(name: str, i: int, result: Result) -> str:
    return digits(float(getattr(result, name)[i]))


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
        "largest_compression",
        "outcome",
        "method",
    )
    values = {name: getattr(result, name) for name in names}
    contacts = dict(zip(("pair", "begin", "end"), shown.contact_times, strict=True))
    state = {"positions": shown.positions, "velocities": shown.velocities}
    heights = {"rebound_heights": result.rebound_heights}
    mapping: dict[str, Any] = plain({**values, **state, **heights, "contacts": contacts})
    return mapping


def save_results(results: tuple[Result, ...], path: Path) -> Path:
    """Trajectory and contacts of each model as groups of one NetCDF file: ``newton/trajectory``, ….

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    import xarray as xr

    column = results[0].column
    about = {"title": "hardlimit drop", "column": repr(column), "toml": files.dumps(column)}
    groups: dict[str, xr.Dataset] = {"/": xr.Dataset(attrs=about)}
    for result in results:
        facts = {"model": result.model, "method": result.method, "outcome": result.outcome}
        groups[f"{result.model}/trajectory"] = result.trajectory().assign_attrs(facts)
        groups[f"{result.model}/contacts"] = result.contacts.assign_attrs(facts)
    return saving.groups(groups, path)
