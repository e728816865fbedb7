"""``hardlimit contact``: one contact of two bodies under a law."""

from __future__ import annotations

import math
from typing import Any

import click
import numpy as np

from .. import validation
from ..approximations import usual_damping
from ..bodies import FLOOR, Ball
from ..column import files
from ..column.scenario import Column
from ..contact import Contact
from ..laws import LAWS
from .common import (
    NUMBER,
    Command,
    console,
    digits,
    given_law_parameters,
    law_options,
    length,
    print_json,
    quantity,
    show,
    table,
    writable,
)
from .drop import law_text

SPEEDS = (0.01, 0.1, 1.0, 10.0)


@click.command(
    cls=Command, epilog="\b\nExample:\n  hardlimit contact --restitution 0.5 --radius 0.01 --density 2500"
)
@click.option("--radius", type=NUMBER, help="Of the ball [m].  [default: 0.01]")
@click.option("--density", type=NUMBER, help="[kg/m³].  [default: 840]")
@click.option("--mass", type=NUMBER, help="[kg], instead of the density.")
@click.option(
    "--other-radius", type=NUMBER, help="Of a second ball [m]; without it, the ball meets the floor."
)
@click.option("--other-density", type=NUMBER, help="[kg/m³].  [default: as the ball's]")
@click.option("--other-mass", type=NUMBER, help="[kg], instead of the density.")
@law_options()
@click.option("--speed", "speeds", type=NUMBER, multiple=True, help="Of impact [m/s]; repeat for a table.")
@click.option("--plot", metavar="FILE", help="Restitution as a picture (png, pdf, svg, …).")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def contact(
    radius: float | None,
    density: float | None,
    mass: float | None,
    other_radius: float | None,
    other_density: float | None,
    other_mass: float | None,
    law: str | None,
    speeds: tuple[float, ...],
    plot: str | None,
    as_json: bool,
    **options: Any,
) -> None:
    """One contact: duration, restitution, damping, and what the usual damping formula would give.

    Without options: a ball of radius 1 cm and density 840 kg/m³ meets the floor, linear law with stiffness
    5e7 N/m and restitution 0.7.
    """
    base = files.of_column(Column.paper())
    parameters = given_law_parameters(options)
    rule = files.with_law(base, law, parameters).laws[0] if law or parameters else base.laws[0]
    ball = make_ball("", radius, density, mass, 0.01, 840.0)
    partner = other_ball(ball, other_radius, other_density, other_mass)
    picture = writable("plot", plot)
    made = rule.between(ball, partner)
    v = np.array([validation.number("speed", s, 0.0) for s in speeds] or default_speeds(made))
    usual = usual_formula(made)
    if picture:
        draw(made, picture)
    if as_json:
        print_json(as_mapping(made, v, usual))
    else:
        print_report(made, ball, partner, v, usual)


def make_ball(
    which: str,
    radius: float | None,
    density: float | None,
    mass: float | None,
    default_radius: float,
    default_density: float,
) -> Ball:
    size = default_radius if radius is None else radius
    if density is None and mass is None:
        density = default_density
    return files.prefixed(which, lambda: Ball(size, density, mass))


def other_ball(ball: Ball, radius: float | None, density: float | None, mass: float | None) -> Any:
    """The second ball; the floor if nothing of it is given."""
    if radius is None and density is None and mass is None:
        return FLOOR
    return make_ball("other_", radius, density, mass, ball.radius, ball.density)


def default_speeds(made: Contact) -> list[float]:
    """One speed where neither restitution nor duration depends on it, else some decades and the one given."""
    slow, fast = SPEEDS[0], SPEEDS[-1]
    if all(math.isclose(of(slow), of(fast), rel_tol=1e-12) for of in (made.restitution, made.duration)):
        return [1.0]
    return sorted({*SPEEDS, made.law.parameters.get("impact_speed", 1.0)})


def usual_formula(made: Contact) -> dict[str, float] | None:
    """What the usual formula's damping gives; only where one ε was asked of a linear law."""
    asked = made.law.specified_restitution
    if made.law.record["name"] != "linear" or math.isnan(asked):
        return None
    return {"asked": asked, **obtained(made, asked)}


def obtained(made: Contact, asked: float) -> dict[str, float]:
    """Damping by the usual formula and the restitution it leads to, for a contact of a linear law."""
    damping = usual_damping(asked, made.stiffness, made.effective_mass)
    law = LAWS["linear"](stiffness=made.stiffness, damping=damping)
    ball = Ball(radius=made.effective_radius, mass=made.effective_mass)
    return {"damping": damping, "restitution": float(law.between(ball).restitution())}


def constants(made: Contact) -> dict[str, float]:
    """The constants of the law in this contact."""
    return {c["name"]: float(getattr(made, c["name"])) for c in made.law.record["constants"]}


def print_report(
    made: Contact, ball: Ball, partner: Any, speeds: Any, usual: dict[str, float] | None
) -> None:
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
    name = made.law.record["name"]
    show(out, f"Contact of {bodies}", table(["", name], rows), f"{name} law: {law_text(made.law)}")
    by_speed = [[digits(v), digits(made.restitution(v)), quantity(made.duration(v), "s")] for v in speeds]
    independent = usual is not None or (len(speeds) == 1 and made.law.record["name"] == "linear")
    title = "At any speed" if independent else "Over the speed of impact"
    show(out, title, table(["speed [m/s]", "restitution ε", "duration"], by_speed))
    if usual:
        print_usual(out, made, usual)


def print_usual(out: Any, made: Contact, usual: dict[str, float]) -> None:
    formula = "ζ = −ln ε/√(π² + ln² ε), the usual formula"
    rows = [
        ["this force, never attractive", digits(made.damping), digits(made.restitution())],
        [formula, digits(usual["damping"]), digits(usual["restitution"])],
    ]
    asked = digits(usual["asked"])
    show(out, f"Asked for ε = {asked}", table(["damping chosen by", "γ [N s/m]", "ε obtained"], rows))
    sentence = f"Asked for {asked}, the usual DEM formula gives {usual['restitution']:.4f}"
    out.print(f"{sentence}: it assumes a contact that ends in attraction.")


def as_mapping(made: Contact, speeds: Any, usual: dict[str, float] | None) -> dict[str, Any]:
    """Everything the tables show, in SI units."""
    return {
        "law": {"name": made.law.record["name"], **made.law.parameters},
        "effective_mass": made.effective_mass,
        "effective_radius": made.effective_radius,
        **constants(made),
        "speed": speeds,
        "restitution": made.restitution(speeds),
        "duration": made.duration(speeds),
        "usual_formula": usual,
    }


def draw(made: Contact, path: Any) -> None:
    """Restitution over speed, or, for a linear law, obtained over asked."""
    from ..pictures import plots

    if made.law.record["name"] != "linear":
        middle = made.law.parameters.get("impact_speed", 1.0)
        plots.save(plots.restitution_over_speed(made, np.geomspace(1e-3, 1e1, 200) * middle), path)
        return
    asked = np.linspace(0.01, 1.0, 100)
    usual = np.array([obtained(made, float(e))["restitution"] for e in asked])
    curves = {"this force, never attractive": asked, "usual DEM formula": usual}
    plots.save(plots.restitution_obtained(asked, curves), path)
