"""``hardlimit fit``: parameters of a contact law from what was measured."""

from __future__ import annotations

import math
import warnings
from typing import Any

import click
import numpy as np

from ..column import files
from ..column.scenario import STANDARD_GRAVITY
from ..contact.balls import FLOOR, Ball
from ..contact.contact import Law, law_parameters
from ..contact.laws import LAWS
from ..fitting import fit as fitted
from ..fitting.files import read_measurements
from ..fitting.measurements import Measured
from ..fitting.result import Fit, as_mapping
from ..support.estimate import Estimate
from .contact import body_options, make_ball, other_ball
from .options import (
    dpi_option,
    given_law_parameters,
    law_options,
    output_option,
    picture,
    quantity_option,
)
from .printing import console, digits, print_json, show, table
from .program import Command

#: The law of the example, and the error of its values.
EXAMPLE = {"youngs_modulus": 1e9, "poisson_ratio": 0.3, "restitution": 0.8, "impact_speed": 1.0}
EXAMPLE_ERROR = 0.005


@click.command(
    cls=Command,
    epilog="\b\nExample:\n  hardlimit fit --example > impacts.csv\n  hardlimit fit impacts.csv --plot fit.png",
)
@click.argument("file", required=False, metavar="[FILE.csv]")
@law_options(law="Law to fit.  [default: viscoelastic for impacts, linear for a column]")
@click.option("--free", multiple=True, metavar="NAME", help="Parameter to fit; repeat for more.")
@click.option("--scatter", is_flag=True, help="Fit how much ε varies beyond the errors of the measurement.")
@quantity_option(
    "--confidence", unit="1", help="Confidence of the intervals, between 0 and 1.  [default: 0.68]"
)
@click.option("--compare/--no-compare", default=True, help="Try the other laws too.")
@body_options("; only where more than ε is fitted.", ".")
@quantity_option(
    "--gravity", unit="m/s2", help="Acceleration of gravity, for heights and times [m/s²].  [default: 9.81]"
)
@click.option("--column", metavar="FILE.toml", help="The column whose rebounds were measured.")
@output_option("--plot", "Data, laws and deviations as a picture (png, pdf, svg, …).")
@dpi_option
@click.option("--example", is_flag=True, help="Print a file of impacts, computed from a law with noise.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def fit(file: str | None, law: str | None, example: bool, as_json: bool, **given: Any) -> None:
    """Fit a contact law to measurements, and say whether it holds.

    The header of the file tells what was measured: speed and restitution; drop_height and rebound_height;
    height (peaks of a ball that bounces on, the release first); time (its impacts); or separation_velocity,
    top_velocity or top_height of a column. Cells are separated by commas, semicolons or tabs; other columns are
    ignored, which is said. Each may have a column of errors, such as height_error, and a unit,
    such as height [cm]. Parameters of the law that are given are held. Printed are the fitted ones with their
    intervals, χ² with its probability, and a verdict. Numbers of options may bear a unit, such as 5mm.
    """
    if example:
        if file is not None:
            raise ValueError("FILE: must be left out with --example")
        click.echo(example_file(), nl=False)
        return
    if file is None:
        raise ValueError("FILE: missing, must be a CSV file; --example prints one")
    plot = picture("plot", given["plot"])
    fixed = given_law_parameters(given)
    gravity = STANDARD_GRAVITY if given["gravity"] is None else given["gravity"]
    column = files.read(given["column"]) if given["column"] else None
    with warnings.catch_warnings(record=True) as ignored:
        warnings.simplefilter("always", UserWarning)
        data = read_measurements(file, column=column, gravity=gravity)
    for warning in ignored:
        console(stderr=True).print(f"hardlimit fit: {warning.message}", markup=False, soft_wrap=True)
    found = computed(data, law, fixed, given)
    if plot:
        from .. import plots

        plots.save(plots.fit(found), plot, given["dpi"])
    if as_json:
        print_json(as_mapping(found))
    else:
        print_report(found)


def computed(data: Measured, law: str | None, fixed: dict[str, float], given: dict[str, Any]) -> Fit:
    """The fit, of the law that suits the kind of the data unless one was given."""
    ball, other = bodies(given)
    return fitted(
        data,
        law or ("viscoelastic" if data.kind == "impacts" else "linear"),
        fixed=fixed,
        free=given["free"] or None,
        ball=ball,
        other=other,
        scatter=given["scatter"],
        confidence=0.68 if given["confidence"] is None else given["confidence"],
        compare=given["compare"],
        progress=True,
    )


def bodies(given: dict[str, Any]) -> tuple[Ball | None, Any]:
    """The ball, if anything of it is given, and what it meets."""
    names = ("radius", "density", "mass")
    radius, density, mass = (given[name] for name in names)
    others = [given[f"other_{name}"] for name in names]
    if radius is density is mass is None and others == [None] * 3:
        return None, FLOOR
    if radius is None or (density is None) == (mass is None):
        raise ValueError("--radius: must be given, with --density or --mass, to describe the ball")
    ball = make_ball("", radius, density, mass, radius, math.nan)
    return ball, other_ball(ball, others[0], others[1], others[2])


def example_file() -> str:
    """Impacts computed from a law with normal noise: what a file looks like."""
    law = LAWS["viscoelastic"](**EXAMPLE)
    speeds = np.geomspace(0.1, 3.0, 16)
    noise = np.random.default_rng(12).normal(0.0, EXAMPLE_ERROR, speeds.size)
    values = law.between(Ball(0.01, density=1000.0)).restitution(speeds) + noise
    rows = [f"{v:.4f},{e:.4f},{EXAMPLE_ERROR}" for v, e in zip(speeds, values, strict=True)]
    head = ["# Computed, not measured: viscoelastic spheres, 0.8 at 1 m/s, with normal noise."]
    return "\n".join([*head, "speed [m/s],restitution,restitution_error", *rows, ""])


# --- report -------------------------------------------------------------------------------------------------


def print_report(found: Fit) -> None:
    out = console()
    percent = f"{100.0 * found.confidence:g} %"
    rows = [
        row(name.replace("_", " "), e, unit_of(type(found.law), name)) for name, e in found.parameters.items()
    ]
    if found.scatter is not None:
        rows.append(row("scatter", found.scatter, ""))
    if found.dissipation is not None:
        rows.append(row("A (ρ/m_eff)^(2/5)", found.dissipation, "(s/m)^(1/5)"))
    title = f"{found.chosen.name} fitted to {found.data.n} values: {found.data.what}"
    columns = ["", "value", "standard error", f"{percent} interval", "unit"]
    show(out, title, table(columns, rows), "; ".join(found.notes))
    if found.others:
        trials = [
            [
                trial.name,
                digits(trial.chi_square, 4),
                str(trial.degrees),
                digits(trial.probability, 2),
                digits(trial.aic - found.trials[0].aic, 3),
            ]
            for trial in found.trials
        ]
        show(out, "All laws", table(["", "χ²", "degrees of freedom", "p", "AIC − best"], trials))
    out.print(found.verdict[0].upper() + found.verdict[1:] + ".", markup=False)


def unit_of(law: type[Law], name: str) -> str:
    unit = str(law_parameters(law)[name]["unit"])
    return "" if unit == "1" else unit


def row(name: str, e: Estimate[float], unit: str) -> list[str]:
    interval = f"{digits(e.lower)} … {digits(e.upper)}"
    return [name, digits(e.value), digits(e.error, 2), interval, unit]
