"""``hardlimit stack``: find the masses with which a stack throws its top ball fastest."""

from __future__ import annotations

from typing import Any

import click
import numpy as np

from ..contact.contact import Law
from ..stacks import MAX_BALLS, Stack
from ..stacks import stack as best
from ..support import validation
from ..support.formatting import digits, quantity
from .contact import law_from
from .options import (
    dpi_option,
    json_option,
    law_options,
    law_text,
    output_option,
    picture,
    quantity_option,
    quantity_options,
)
from .printing import console, print_json, show, table
from .program import Command

#: Gaps of the table in units of V t_c.
GAPS = (0.0, 0.01, 0.1, 0.3, 1.0, 3.0, 10.0)
MODELS = {"newton": "Newton's equations", "independent": "collisions"}


@click.command(
    cls=Command,
    epilog="\b\nExample:\n  hardlimit stack --balls 3 --bottom-mass 1kg --top-mass 10g --restitution 1",
)
@click.option(
    "--balls", "n", type=int, default=3, show_default=True, help=f"Number of balls, 2 to {MAX_BALLS}."
)
@quantity_options(
    ("--bottom-mass", "kg", "Mass of the lowest ball [kg].  [default: 1]"),
    ("--top-mass", "kg", "Mass of the top ball [kg].  [default: optimised as well]"),
    ("--least-ratio", "1", "Smallest ratio of a ball's mass to that of the ball below.  [default: 0.001]"),
    ("--largest-ratio", "1", "Largest ratio of a ball's mass to that of the ball below.  [default: 1]"),
    ("--density", "kg/m3", "Density of the balls [kg/m³].  [default: 1000]"),
    ("--speed", "m/s", "Impact speed [m/s].  [default: 1]"),
)
@quantity_option("--gap", "gaps", unit="m", help="Gap between neighbours at impact [m].  [default: 0]")
@law_options()
@output_option("--plot", "Picture of masses and top speed over the gap (png, pdf, svg, …).")
@dpi_option
@json_option()
def stack(n: int, as_json: bool, plot: str | None, **params: Any) -> None:
    """Find the masses with which a stack throws its top ball fastest.

    The masses are optimised under Newton's equations and for successive collisions. Balls that touch or nearly touch
    are in contact at the same time; the masses that are best for successive collisions are then far from optimal.
    Numbers may have a unit, such as 10g.
    """
    path = picture("plot", plot)
    law = law_from(params)
    stacks = computed(law, n, params)
    if path:
        from .. import plots

        plots.save(plots.stack(*stacks.values()), path, params["dpi"])
    if as_json:
        print_json(as_mapping(stacks, law))
    else:
        print_report(stacks, law)


def computed(law: Law, n: int, params: dict[str, Any]) -> dict[str, Stack]:
    """The optimal stack under each model."""
    for name in ("least_ratio", "largest_ratio", "speed"):  # hl.stack has other names for them
        if params[name] is not None:
            validation.number(name, params[name], 0.0)
    arguments = {"bottom_mass": 1.0, "impact_speed": params["speed"]}
    arguments |= {name: params[name] for name in ("bottom_mass", "top_mass", "gaps", "density")}
    arguments = {name: value for name, value in arguments.items() if value is not None}
    arguments.setdefault("bottom_mass", 1.0)
    low, high = params["least_ratio"], params["largest_ratio"]
    arguments["ratio_limits"] = (1e-3 if low is None else low, 1.0 if high is None else high)
    return {model: best(n, law, model=model, progress=True, **arguments) for model in MODELS}


def print_report(stacks: dict[str, Stack], law: Law) -> None:
    """Print the masses, and the top speed for several gaps."""
    out = console()
    n = stacks["newton"].masses.size
    rows = [
        [f"ball {i + 1}", *(quantity(float(stack.masses[i]) * 1e3, "g") for stack in stacks.values())]
        for i in reversed(range(n))
    ]
    for model, name in MODELS.items():
        rows.append(
            [f"top speed / V, {name}", *(digits(stack.speed_under(model)) for stack in stacks.values())]
        )
    columns = ["best masses for", *MODELS.values()]
    show(out, f"Stack of {n} balls", table(columns, rows), law_text(law))
    rows = []
    for gap in GAPS:
        speeds = [stack.speed_under("newton", gap * stack.contact_way) for stack in stacks.values()]
        rows.append([digits(gap), *map(digits, speeds)])
    way = quantity(stacks["newton"].contact_way, "m", 3)
    title = "Top speed / V under Newton's equations for other gaps"
    below = f"V t_c = {way}: impact speed times contact duration of the lowest ball alone on the floor."
    show(out, title, table(["gap / (V t_c)", *(f"best for {name}" for name in MODELS.values())], rows), below)


def as_mapping(stacks: dict[str, Stack], law: Law) -> dict[str, Any]:
    """The contents of the tables in SI units; speeds are relative to the impact speed."""
    content: dict[str, Any] = {"law": {"name": law.record["name"], **law.parameters}}
    for model, stack in stacks.items():
        gaps = np.array(GAPS) * stack.contact_way
        over = stack.over_gaps(gaps)
        content[f"best_under_{model}"] = {
            "masses": stack.masses,
            "top_speed": {name: stack.speed_under(name) for name in MODELS},
            "contact_way": stack.contact_way,
            "over_gaps": {"gap": gaps, **{name: over[name].values for name in MODELS}},
        }
    return content
