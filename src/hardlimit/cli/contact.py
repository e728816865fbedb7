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
    speeds: tuple[float, ...], plot: str | None, dpi: float | None, as_json: bool, **params: Any
) -> None:
    """Compute duration, restitution and damping of one contact.

    The output also has the restitution that the usual formula for the damping would give. Without options, a ball of
    radius 1 cm and density 840 kg/m³ meets the floor under the linear law with stiffness 5e7 N/m and restitution 0.7.
    Numbers may have a unit, such as 1cm.
    """
    path = picture("plot", plot)
    rule = law_from(params)
    ball = make_ball("", params, 0.01, 840.0)
    partner = other_ball(ball, params)
    pair = rule.between(ball, partner)
    given_speeds = [validation.number(f"speeds[{i}]", s, 0.0) for i, s in enumerate(speeds)]
    default = {*SPEEDS, pair.law.parameters.get("impact_speed", 1.0)} if depends_on_speed(pair) else {1.0}
    v = np.array(given_speeds or sorted(default))
    usual = usual_formula(pair)
    if path:
        draw(pair, path, dpi)
    depth = pair.compression(v) / min(ball.radius, partner.radius)
    if as_json:
        print_json(as_mapping(pair, v, depth, usual))
    else:
        print_report(pair, ball, partner, v, depth, usual)


def law_from(params: dict[str, Any]) -> Law:
    """The law of Fig. 2 changed by the options, which are taken out."""
    return files.changed_law(Column.paper().laws[0], *take_law(params))


def make_ball(which: str, params: dict[str, Any], radius: float, density: float) -> Ball:
    """A ball from the options with the prefix ``which``; radius and density are defaults."""
    size, rho, mass = (params[which + name] for name in ("radius", "density", "mass"))
    rho = density if rho is None and mass is None else rho
    try:
        return Ball(radius if size is None else size, rho, mass)
    except ValueError as error:
        subject, colon, rest = str(error).partition(": ")
        raise ValueError(PARAMETER.sub(rf"{which}\g<0>", subject) + colon + rest) from None


def other_ball(ball: Ball, params: dict[str, Any]) -> Any:
    """The second ball, or the floor if none of its options is given."""
    if all(params[f"other_{name}"] is None for name in ("radius", "density", "mass")):
        return FLOOR
    return make_ball("other_", params, ball.radius, ball.density)


def depends_on_speed(pair: Contact) -> bool:
    """Whether restitution or duration depends on the impact speed."""
    slow, fast = SPEEDS[0], SPEEDS[-1]
    return not (
        math.isclose(pair.restitution(slow), pair.restitution(fast), rel_tol=1e-12)
        and math.isclose(pair.duration(slow), pair.duration(fast), rel_tol=1e-12)
    )


def is_spring_and_dashpot(law: Law) -> bool:
    """Whether the law is a linear spring and dashpot, as the usual formula for the damping assumes."""
    units = {name: p["unit"] for name, p in law_parameters(type(law)).items()}
    return units.get("stiffness") == "N/m" and units.get("damping") == "N s/m"


def usual_formula(pair: Contact) -> dict[str, float] | None:
    """The result of the usual formula; None unless a spring and dashpot were given by ε."""
    requested = pair.law.specified_restitution
    applies = is_spring_and_dashpot(pair.law) and not math.isnan(requested)
    return {"asked": requested, **obtained(pair, requested)} if applies else None


def obtained(pair: Contact, requested: float) -> dict[str, float]:
    """Damping by the usual formula, and the restitution that it gives."""
    damping = usual_damping(requested, pair.stiffness, pair.effective_mass)
    law = type(pair.law)(stiffness=pair.stiffness, damping=damping)
    ball = Ball(radius=pair.effective_radius, mass=pair.effective_mass)
    return {"damping": damping, "restitution": float(law.between(ball).restitution())}


def print_report(
    pair: Contact, ball: Ball, partner: Any, speeds: Any, depth: Any, usual: dict[str, float] | None
) -> None:
    """Print the contact, a table over the impact speed, and the result of the usual formula."""
    out = console()
    bodies = f"ball of radius {length(ball.radius)}, {quantity(ball.mass * 1e3, 'g')}, and "
    if isinstance(partner, Ball):
        bodies += f"ball of radius {length(partner.radius)}, {quantity(partner.mass * 1e3, 'g')}"
    else:
        bodies += "floor"
    rows = [
        ["effective mass", quantity(pair.effective_mass * 1e3, "g")],
        ["effective radius", length(pair.effective_radius)],
    ]
    for constant in pair.law.record["constants"]:
        unit = "" if constant["unit"] == "1" else f" {constant['unit']}"
        rows.append([constant["name"].replace("_", " "), f"{digits(getattr(pair, constant['name']))}{unit}"])
    show(out, f"Contact of {bodies}", table(["", pair.law.record["name"]], rows), law_text(pair.law))
    by_speed = [
        [digits(v), digits(pair.restitution(v)), quantity(pair.duration(v), "s"), digits(d)]
        for v, d in zip(speeds, depth, strict=True)
    ]
    several, any_speed = "At several impact speeds", "At any impact speed (the compression at this speed)"
    names = ["impact speed [m/s]", "restitution ε", "duration", "compression [smaller radius]"]
    show(out, several if depends_on_speed(pair) else any_speed, table(names, by_speed))
    if said := compression.too_soft(float(depth.max())):
        out.print(sentence(said), style="yellow")
    if usual:
        print_usual(out, pair, usual)


def print_usual(out: Any, pair: Contact, usual: dict[str, float]) -> None:
    """Print the damping of this package and that of the usual formula."""
    rows = [
        ["hardlimit, for a force that never attracts", digits(pair.damping), digits(pair.restitution())],
        ["usual formula, ζ = −ln ε/√(π² + ln² ε)", digits(usual["damping"]), digits(usual["restitution"])],
    ]
    requested = digits(usual["asked"])
    show(out, f"Requested ε = {requested}", table(["damping chosen by", "γ [N s/m]", "resulting ε"], rows))
    out.print(
        f"With the usual formula, a request for ε = {requested} results in {usual['restitution']:.4f}: "
        "the formula assumes a force that attracts at the end of the contact."
    )


def as_mapping(pair: Contact, speeds: Any, depth: Any, usual: dict[str, float] | None) -> dict[str, Any]:
    """Everything the tables show, in SI units."""
    return {
        "law": {"name": pair.law.record["name"], **pair.law.parameters},
        "effective_mass": pair.effective_mass,
        "effective_radius": pair.effective_radius,
        **{c["name"]: float(getattr(pair, c["name"])) for c in pair.law.record["constants"]},
        "speed": speeds,
        "restitution": pair.restitution(speeds),
        "duration": pair.duration(speeds),
        "largest_compression": depth,
        "usual_formula": usual,
    }


def draw(pair: Contact, path: Path, dpi: float | None) -> None:
    """Draw restitution over speed, or, for a spring and dashpot, the resulting over the requested restitution."""
    from .. import plots

    if not is_spring_and_dashpot(pair.law):
        middle = pair.law.parameters.get("impact_speed", 1.0)
        plots.save(plots.restitution_over_speed(pair, np.geomspace(1e-3, 1e1, 200) * middle), path, dpi)
        return
    requested = np.linspace(0.01, 1.0, 100)
    usual = np.array([obtained(pair, float(e))["restitution"] for e in requested])
    curves = {"this force, never attractive": requested, "usual DEM formula": usual}
    plots.save(plots.restitution_obtained(requested, curves), path, dpi)
