"""``hardlimit contact``: compute a contact of two bodies under a law."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
import numpy as np

from ..column import files
from ..column.scenario import Column
from ..contact import compression
from ..contact.approximations import usual_damping
from ..contact.balls import FLOOR, Ball
from ..contact.contact import Contact, Law, law_parameters
from ..support import validation
from ..support.formatting import digits, length, quantity
from .options import (
    F,
    dpi_option,
    json_option,
    law_options,
    law_text,
    options,
    output_option,
    picture,
    quantity_option,
    take_law,
)
from .printing import console, print_json, sentence, show, table
from .program import Command

#: Impact speeds of the table [m/s], if the contact depends on the speed.
SPEEDS = (0.01, 0.1, 1.0, 10.0)


def body_options(radius: str, density: str) -> Callable[[F], F]:
    """The options of two bodies in contact; the arguments end the help of ``--radius`` and ``--density``."""
    return options(
        quantity_option("--radius", unit="m", help=f"Radius of the ball [m]{radius}"),
        quantity_option("--density", unit="kg/m3", help=f"Density of the ball [kg/m³]{density}"),
        quantity_option("--mass", unit="kg", help="Mass of the ball [kg] instead of the density."),
        quantity_option(
            "--other-radius",
            unit="m",
            help="Radius of a second ball [m]; without a second ball, the first one meets the floor.",
        ),
        quantity_option(
            "--other-density",
            unit="kg/m3",
            help="Density of the second ball [kg/m³].  [default: that of the first]",
        ),
        quantity_option(
            "--other-mass", unit="kg", help="Mass of the second ball [kg] instead of the density."
        ),
    )


@click.command(
    cls=Command, epilog="\b\nExample:\n  hardlimit contact --restitution 0.5 --radius 1cm --density 2500"
)
@body_options(".  [default: 0.01]", ".  [default: 840]")
@law_options()
@quantity_option(
    "--speed", "speeds", unit="m/s", multiple=True, help="Impact speed [m/s]; repeat it for a table."
)
@output_option("--plot", "Plot of the restitution (png, pdf, svg, …).")
@dpi_option
@json_option()
def contact(
    speeds: tuple[float, ...], plot: str | None, dpi: float | None, as_json: bool, **given: Any
) -> None:
    """Compute duration, restitution and damping of one contact.

    The output also has the restitution that the usual formula for the damping would give. Without options, a ball of
    radius 1 cm and density 840 kg/m³ meets the floor under the linear law with stiffness 5e7 N/m and restitution 0.7.
    Numbers may have a unit, such as 1cm.
    """
    path = picture("plot", plot)
    rule = law_from(given)
    ball = make_ball("", given["radius"], given["density"], given["mass"], 0.01, 840.0)
    partner = other_ball(ball, given["other_radius"], given["other_density"], given["other_mass"])
    made = rule.between(ball, partner)
    given_speeds = [validation.number(f"speeds[{i}]", s, 0.0) for i, s in enumerate(speeds)]
    v = np.array(given_speeds or default_speeds(made))
    usual = usual_formula(made)
    if path:
        draw(made, path, dpi)
    depth = compressions(made, ball, partner, v)
    if as_json:
        print_json(as_mapping(made, v, depth, usual))
    else:
        print_report(made, ball, partner, v, depth, usual)


def law_from(given: dict[str, Any]) -> Law:
    """The law of Fig. 2 changed by the options, which are taken out."""
    return files.changed_law(Column.paper().laws[0], *take_law(given))


def make_ball(
    which: str,
    radius: float | None,
    density: float | None,
    mass: float | None,
    default_radius: float,
    default_density: float,
) -> Ball:
    """A ball with default values for options that are not given; ``which`` is the prefix of its options."""
    size = default_radius if radius is None else radius
    if density is None and mass is None:
        density = default_density
    return files.prefixed(which, lambda: Ball(size, density, mass))


def other_ball(ball: Ball, radius: float | None, density: float | None, mass: float | None) -> Any:
    """The second ball, or the floor if none of its options is given."""
    if radius is None and density is None and mass is None:
        return FLOOR
    return make_ball("other_", radius, density, mass, ball.radius, ball.density)


def depends_on_speed(made: Contact) -> bool:
    """Whether restitution or duration depends on the impact speed."""
    slow, fast = SPEEDS[0], SPEEDS[-1]
    return not (
        math.isclose(made.restitution(slow), made.restitution(fast), rel_tol=1e-12)
        and math.isclose(made.duration(slow), made.duration(fast), rel_tol=1e-12)
    )


def default_speeds(made: Contact) -> list[float]:
    """One speed if nothing depends on it, else several decades and the law's own impact speed."""
    if not depends_on_speed(made):
        return [1.0]
    return sorted({*SPEEDS, made.law.parameters.get("impact_speed", 1.0)})


def compressions(made: Contact, ball: Ball, partner: Any, speeds: Any) -> Any:
    """Largest compression over the smaller radius at each impact speed."""
    radius = min(ball.radius, partner.radius)
    return made.compression(speeds) / radius


def takes_usual_formula(law: Law) -> bool:
    """Whether the law is a linear spring and dashpot, as the usual formula for the damping assumes."""
    units = {name: p["unit"] for name, p in law_parameters(type(law)).items()}
    return units.get("stiffness") == "N/m" and units.get("damping") == "N s/m"


def usual_formula(made: Contact) -> dict[str, float] | None:
    """The result of the usual formula; None unless a spring and dashpot were given by ε."""
    asked = made.law.specified_restitution
    if not takes_usual_formula(made.law) or math.isnan(asked):
        return None
    return {"asked": asked, **obtained(made, asked)}


def obtained(made: Contact, asked: float) -> dict[str, float]:
    """Damping by the usual formula, and the restitution that it gives."""
    damping = usual_damping(asked, made.stiffness, made.effective_mass)
    law = type(made.law)(stiffness=made.stiffness, damping=damping)
    ball = Ball(radius=made.effective_radius, mass=made.effective_mass)
    return {"damping": damping, "restitution": float(law.between(ball).restitution())}


def constants(made: Contact) -> dict[str, float]:
    """The constants of the law in this contact."""
    return {c["name"]: float(getattr(made, c["name"])) for c in made.law.record["constants"]}


def print_report(
    made: Contact, ball: Ball, partner: Any, speeds: Any, depth: Any, usual: dict[str, float] | None
) -> None:
    """Print the contact, a table over the impact speed, and the result of the usual formula."""
    out = console()
    bodies = f"ball of radius {length(ball.radius)}, {quantity(ball.mass * 1e3, 'g')}, and "
    if isinstance(partner, Ball):
        bodies += f"ball of radius {length(partner.radius)}, {quantity(partner.mass * 1e3, 'g')}"
    else:
        bodies += "floor"
    rows = [["effective mass", quantity(made.effective_mass * 1e3, "g")]]
    rows.append(["effective radius", length(made.effective_radius)])
    for constant in made.law.record["constants"]:
        unit = "" if constant["unit"] == "1" else constant["unit"]
        value = f"{digits(getattr(made, constant['name']))} {unit}".strip()
        rows.append([constant["name"].replace("_", " "), value])
    show(out, f"Contact of {bodies}", table(["", made.law.record["name"]], rows), law_text(made.law))
    by_speed = [
        [digits(v), digits(made.restitution(v)), quantity(made.duration(v), "s"), digits(d)]
        for v, d in zip(speeds, depth, strict=True)
    ]
    title = "At several impact speeds"
    if not depends_on_speed(made):
        title = "At any impact speed (the compression at this speed)"
    names = ["impact speed [m/s]", "restitution ε", "duration", "compression [smaller radius]"]
    show(out, title, table(names, by_speed))
    if said := compression.too_soft(float(depth.max())):
        out.print(sentence(said), style="yellow")
    if usual:
        print_usual(out, made, usual)


def print_usual(out: Any, made: Contact, usual: dict[str, float]) -> None:
    """Print the damping of this package and that of the usual formula."""
    formula = "ζ = −ln ε/√(π² + ln² ε), the usual formula"
    rows = [
        ["hardlimit, for a force that never attracts", digits(made.damping), digits(made.restitution())],
        [formula, digits(usual["damping"]), digits(usual["restitution"])],
    ]
    asked = digits(usual["asked"])
    show(out, f"Asked for ε = {asked}", table(["damping chosen by", "γ [N s/m]", "resulting ε"], rows))
    result = f"Asked for {asked}, the usual DEM formula gives {usual['restitution']:.4f}"
    out.print(f"{result}: it assumes a force that attracts at the end of the contact.")


def as_mapping(made: Contact, speeds: Any, depth: Any, usual: dict[str, float] | None) -> dict[str, Any]:
    """Everything the tables show, in SI units."""
    return {
        "law": {"name": made.law.record["name"], **made.law.parameters},
        "effective_mass": made.effective_mass,
        "effective_radius": made.effective_radius,
        **constants(made),
        "speed": speeds,
        "restitution": made.restitution(speeds),
        "duration": made.duration(speeds),
        "largest_compression": depth,
        "usual_formula": usual,
    }


def draw(made: Contact, path: Path, dpi: float | None) -> None:
    """Draw restitution over speed, or, for a spring and dashpot, the resulting over the requested restitution."""
    from .. import plots

    if not takes_usual_formula(made.law):
        middle = made.law.parameters.get("impact_speed", 1.0)
        plots.save(plots.restitution_over_speed(made, np.geomspace(1e-3, 1e1, 200) * middle), path, dpi)
        return
    asked = np.linspace(0.01, 1.0, 100)
    usual = np.array([obtained(made, float(e))["restitution"] for e in asked])
    curves = {"this force, never attractive": asked, "usual DEM formula": usual}
    plots.save(plots.restitution_obtained(asked, curves), path, dpi)
