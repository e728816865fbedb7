"""``hardlimit fit``: fit the parameters of a contact law to measurements."""

from __future__ import annotations

import math
import warnings
from typing import Any

import click
import numpy as np

from ..column import files
from ..column.scenario import STANDARD_GRAVITY
from ..contact.balls import FLOOR, Ball
from ..contact.contact import law_parameters
from ..contact.laws import LAWS
from ..fitting import fit as fitted
from ..fitting.files import error_column, read_measurements
from ..fitting.measurements import Measured
from ..fitting.result import Fit, as_mapping
from ..support.estimate import Estimate
from ..support.formatting import digits
from .contact import body_options, make_ball, other_ball
from .options import dpi_option, json_option, law_options, output_option, picture, quantity_option, take_law
from .printing import console, print_json, print_warnings, sentence, show, table
from .program import Command

#: The law of the example file, and the error of its values.
EXAMPLE = {"youngs_modulus": 1e9, "poisson_ratio": 0.3, "restitution": 0.8, "impact_speed": 1.0}
EXAMPLE_ERROR = 0.005


@click.command(
    cls=Command,
    aliases={
        "path": "FILE",
        "file": "FILE",
        "data": "FILE",
        "ball": "--radius",
        "fixed": "options of the law",
    },
    epilog="\b\nExample:\n  hardlimit fit --example > impacts.csv\n  hardlimit fit impacts.csv --plot fit.png",
)
@click.argument("file", required=False, metavar="[FILE.csv]")
@law_options(law="Law to fit.  [default: viscoelastic for impacts, linear for a column]")
@click.option(
    "--free", multiple=True, metavar="NAME", help="Parameter to fit, such as stiffness; repeat it for more."
)
@click.option("--scatter", is_flag=True, help="Fit the scatter of ε beyond the errors of the measurement.")
@quantity_option(
    "--confidence",
    unit="1",
    help="Confidence level of the intervals, from 0.001 to 0.999999.  [default: 0.68]",
)
@click.option("--compare/--no-compare", default=True, help="Fit the other laws as well.")
@body_options("; needed if more than ε is fitted.", ".")
@quantity_option("--gravity", unit="m/s2", help="Gravity [m/s²], for heights and times.  [default: 9.81]")
@click.option("--column", metavar="FILE.toml", help="Column whose rebounds were measured.")
@output_option("--plot", "Picture of data, laws and residuals (png, pdf, svg, …).")
@dpi_option
@click.option("--example", is_flag=True, help="Print an example file with impacts computed from a law.")
@json_option()
def fit(file: str | None, example: bool, as_json: bool, **params: Any) -> None:
    """Fit a contact law to measurements and test whether it holds.

    The header of the file says what was measured: speed and restitution; drop_height and rebound_height; height (peaks
    of a bouncing ball, the release first); time (its impacts); or separation_velocity, top_velocity or top_height of a
    column. Cells are separated by commas, semicolons or tabs. A column may have a unit, such as height [cm], and a
    column of errors, such as height_error; unknown columns are ignored with a warning. Parameters of the law that are
    given as options are not fitted. The output has the fitted parameters with their intervals, χ² with its
    probability, and a verdict. Numbers of options may have a unit, such as 5mm.
    """
    if example:
        if file is not None:
            raise ValueError("FILE: must be left out with --example")
        click.echo(example_file(), nl=False)
        return
    if file is None:
        raise ValueError("FILE: missing, must be a CSV file; --example prints one")
    plot = picture("plot", params["plot"])
    law, fixed = take_law(params)
    gravity = STANDARD_GRAVITY if params["gravity"] is None else params["gravity"]
    column = files.read(params["column"]) if params["column"] else None
    with warnings.catch_warnings(record=True) as ignored:
        warnings.simplefilter("always", UserWarning)
        data = read_measurements(file, column=column, gravity=gravity)
    print_warnings("fit", ignored)
    if not (params["scatter"] or data.has_errors):
        raise ValueError(
            f"{file}: values without errors, or with 0: add a column {error_column(file)}, or --scatter"
        )
    result = computed(data, law, fixed, params)
    if plot:
        from .. import plots

        plots.save(plots.fit(result), plot, params["dpi"])
    if as_json:
        print_json(as_mapping(result))
    else:
        print_report(result)


def computed(data: Measured, law: str | None, fixed: dict[str, float], params: dict[str, Any]) -> Fit:
    """The fit of the requested law, or of the default law for data of this kind."""
    ball, other = bodies(params)
    return fitted(
        data,
        law or ("viscoelastic" if data.kind == "impacts" else "linear"),
        fixed=fixed,
        free=[name.lstrip("-").replace("-", "_") for name in params["free"]] or None,
        ball=ball,
        other=other,
        scatter=params["scatter"],
        confidence=0.68 if params["confidence"] is None else params["confidence"],
        compare=params["compare"],
        progress=True,
    )


def bodies(params: dict[str, Any]) -> tuple[Ball | None, Any]:
    """The ball, or None if it is not described, and its partner."""
    names = ("radius", "density", "mass")
    if all(params[which + name] is None for which in ("", "other_") for name in names):
        return None, FLOOR
    if params["radius"] is None or (params["density"] is None) == (params["mass"] is None):
        raise ValueError("--radius: missing, must be given with --density or --mass to describe the ball")
    ball = make_ball("", params, math.nan, math.nan)
    return ball, other_ball(ball, params)


def example_file() -> str:
    """A file of measurements: impacts computed from a law with normal noise."""
    law = LAWS["viscoelastic"](**EXAMPLE)
    speeds = np.geomspace(0.1, 3.0, 16)
    noise = np.random.default_rng(12).normal(0.0, EXAMPLE_ERROR, speeds.size)
    values = law.between(Ball(0.01, density=1000.0)).restitution(speeds) + noise
    rows = [f"{v:.4f},{e:.4f},{EXAMPLE_ERROR}" for v, e in zip(speeds, values, strict=True)]
    head = ["# Computed, not measured: viscoelastic spheres, 0.8 at 1 m/s, with normal noise."]
    return "\n".join([*head, "speed [m/s],restitution,restitution_error", *rows, ""])


# --- report -------------------------------------------------------------------------------------------------


def print_report(result: Fit) -> None:
    """Print the parameters, the other laws and the verdict."""
    out = console()
    percent = f"{100.0 * result.confidence:g} %"
    records = law_parameters(type(result.law))
    rows = [row(name.replace("_", " "), e, records[name]["unit"]) for name, e in result.parameters.items()]
    if result.scatter is not None:
        rows.append(row("scatter", result.scatter, "1"))
    if result.dissipation is not None:
        rows.append(row("A (ρ/m_eff)^(2/5)", result.dissipation, "(s/m)^(1/5)"))
    title = f"{result.name} fitted to {result.data.n} values: {result.data.what}"
    columns = ["", "value", "standard error", f"{percent} interval", "unit"]
    show(out, title, table(columns, rows), "; ".join(result.notes))
    if result.others:
        best = result.trials[0].aic
        trials = [
            [
                t.name,
                digits(t.chi_square, 4),
                str(t.degrees),
                digits(t.probability, 2),
                digits(t.aic - best, 3),
            ]
            for t in result.trials
        ]
        show(out, "All laws", table(["", "χ²", "degrees of freedom", "p", "AIC − best"], trials))
    out.print(sentence(result.verdict), markup=False)


def row(name: str, e: Estimate[float], unit: str) -> list[str]:
    """A row of the table of parameters."""
    interval = f"{digits(e.lower)} … {digits(e.upper)}"
    return [name, digits(e.value), digits(e.error, 2), interval, "" if unit == "1" else unit]
