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
    output_option,
    picture,
    quantity_options,
    take_law,
)
from .printing import console, print_json, sentence, show, table
from .program import PARAMETER, Command

#: Impact speeds of the table [m/s], if the contact depends on the speed.
SPEEDS = (0.01, 0.1, 1.0, 10.0)


def body_options(radius: str, density: str) -> Callable[[F], F]:
    """The options of two bodies in contact; the arguments end the help of ``--radius`` and ``--density``."""
    return quantity_options(
        ("--radius", "m", f"Radius of the ball [m]{radius}"),
        ("--density", "kg/m3", f"Density of the ball [kg/m³]{density}"),
        ("--mass", "kg", "Mass of the ball [kg] instead of the density."),
        ("--other-radius", "m", "Radius of a second ball [m].  [default: contact with the floor]"),
        ("--other-density", "kg/m3", "Density of the second ball [kg/m³].  [default: that of the first]"),
        ("--other-mass", "kg", "Mass of the second ball [kg] instead of the density."),
    )


@click.command(
    cls=Command, epilog="\b\nExample:\n  hardlimit contact --restitution 0.5 --radius 1cm --density 2500"
)
@body_options(".  [default: 0.01]", ".  [default: 840]")
@law_options()
@quantity_options(("--speed", "m/s", "Impact speed [m/s]; repeat it for a table.", "speeds"))
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
    ball = make_ball("", given, 0.01, 840.0)
    partner = other_ball(ball, given)
    made = rule.between(ball, partner)
    given_speeds = [validation.number(f"speeds[{i}]", s, 0.0) for i, s in enumerate(speeds)]
    default = {*SPEEDS, made.law.parameters.get("impact_speed", 1.0)} if depends_on_speed(made) else {1.0}
    v = np.array(given_speeds or sorted(default))
    usual = usual_formula(made)
    if path:
        draw(made, path, dpi)
    depth = made.compression(v) / min(ball.radius, partner.radius)
    if as_json:
        print_json(as_mapping(made, v, depth, usual))
    else:
        print_report(made, ball, partner, v, depth, usual)


def law_from(given: dict[str, Any]) -> Law:
    """The law of Fig. 2 changed by the options, which are taken out."""
    return files.changed_law(Column.paper().laws[0], *take_law(given))


def make_ball(which: str, given: dict[str, Any], radius: float, density: float) -> Ball:
    """A ball from the options with the prefix ``which``; radius and density are defaults."""
    size, rho, mass = (given[which + name] for name in ("radius", "density", "mass"))
    rho = density if rho is None and mass is None else rho
    try:
        return Ball(radius if size is None else size, rho, mass)
    except ValueError as error:
        subject, colon, rest = str(error).partition(": ")
        raise ValueError(PARAMETER.sub(rf"{which}\g<0>", subject) + colon + rest) from None


def other_ball(ball: Ball, given: dict[str, Any]) -> Any:
    """The second ball, or the floor if none of its options is given."""
    if all(given[f"other_{name}"] is None for name in ("radius", "density", "mass")):
        return FLOOR
    return make_ball("other_", given, ball.radius, ball.density)


def depends_on_speed(made: Contact) -> bool:
    """Whether restitution or duration depends on the impact speed."""
    slow, fast = SPEEDS[0], SPEEDS[-1]
    return not (
        math.isclose(made.restitution(slow), made.restitution(fast), rel_tol=1e-12)
        and math.isclose(made.duration(slow), made.duration(fast), rel_tol=1e-12)
    )


def is_spring_and_dashpot(law: Law) -> bool:
    """Whether the law is a linear spring and dashpot, as the usual formula for the damping assumes."""
    units = {name: p["unit"] for name, p in law_parameters(type(law)).items()}
    return units.get("stiffness") == "N/m" and units.get("damping") == "N s/m"


def usual_formula(made: Contact) -> dict[str, float] | None:
    """The result of the usual formula; None unless a spring and dashpot were given by ε."""
    asked = made.law.specified_restitution
    applies = is_spring_and_dashpot(made.law) and not math.isnan(asked)
    return {"asked": asked, **obtained(made, asked)} if applies else None


def obtained(made: Contact, asked: float) -> dict[str, float]:
    """Damping by the usual formula, and the restitution that it gives."""
    damping = usual_damping(asked, made.stiffness, made.effective_mass)
    law = type(made.law)(stiffness=made.stiffness, damping=damping)
    ball = Ball(radius=made.effective_radius, mass=made.effective_mass)
    return {"damping": damping, "restitution": float(law.between(ball).restitution())}


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
    rows = [
        ["effective mass", quantity(made.effective_mass * 1e3, "g")],
        ["effective radius", length(made.effective_radius)],
    ]
    for constant in made.law.record["constants"]:
        unit = "" if constant["unit"] == "1" else f" {constant['unit']}"
        rows.append([constant["name"].replace("_", " "), f"{digits(getattr(made, constant['name']))}{unit}"])
    show(out, f"Contact of {bodies}", table(["", made.law.record["name"]], rows), law_text(made.law))
    by_speed = [
        [digits(v), digits(made.restitution(v)), quantity(made.duration(v), "s"), digits(d)]
        for v, d in zip(speeds, depth, strict=True)
    ]
    several, any_speed = "At several impact speeds", "At any impact speed (the compression at this speed)"
    names = ["impact speed [m/s]", "restitution ε", "duration", "compression [smaller radius]"]
    show(out, several if depends_on_speed(made) else any_speed, table(names, by_speed))
    if said := compression.too_soft(float(depth.max())):
        out.print(sentence(said), style="yellow")
    if usual:
        print_usual(out, made, usual)


def print_usual(out: Any, made: Contact, usual: dict[str, float]) -> None:
    """Print the damping of this package and that of the usual formula."""
    rows = [
        ["hardlimit, for a force that never attracts", digits(made.damping), digits(made.restitution())],
        ["usual formula, ζ = −ln ε/√(π² + ln² ε)", digits(usual["damping"]), digits(usual["restitution"])],
    ]
    asked = digits(usual["asked"])
    show(out, f"Requested ε = {asked}", table(["damping chosen by", "γ [N s/m]", "resulting ε"], rows))
    out.print(
        f"With the usual formula, a request for ε = {asked} results in {usual['restitution']:.4f}: "
        "the formula assumes a force that attracts at the end of the contact."
    )


def as_mapping(made: Contact, speeds: Any, depth: Any, usual: dict[str, float] | None) -> dict[str, Any]:
    """Everything the tables show, in SI units."""
    return {
        "law": {"name": made.law.record["name"], **made.law.parameters},
        "effective_mass": made.effective_mass,
        "effective_radius": made.effective_radius,
        **{c["name"]: float(getattr(made, c["name"])) for c in made.law.record["constants"]},
        "speed": speeds,
        "restitution": made.restitution(speeds),
        "duration": made.duration(speeds),
        "largest_compression": depth,
        "usual_formula": usual,
    }


def draw(made: Contact, path: Path, dpi: float | None) -> None:
    """Draw restitution over speed, or, for a spring and dashpot, the resulting over the requested restitution."""
    from .. import plots

    if not is_spring_and_dashpot(made.law):
        middle = made.law.parameters.get("impact_speed", 1.0)
        plots.save(plots.restitution_over_speed(made, np.geomspace(1e-3, 1e1, 200) * middle), path, dpi)
        return
    asked = np.linspace(0.01, 1.0, 100)
    usual = np.array([obtained(made, float(e))["restitution"] for e in asked])
    curves = {"this force, never attractive": asked, "usual DEM formula": usual}
    plots.save(plots.restitution_obtained(asked, curves), path, dpi)
