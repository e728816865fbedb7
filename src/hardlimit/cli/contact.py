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
from ..contact.contact import Contact, Floats, Law, law_parameters
from ..support import validation
from ..support.formatting import digits, length, quantity
from .options import (
    F,
    Quantity,
    dpi_option,
    friction_options,
    json_option,
    law_mapping,
    law_options,
    law_text,
    output_option,
    picture,
    quantity_options,
    take_friction,
    take_law,
)
from .printing import console, print_json, sentence, show, table
from .program import PARAMETER, Command

#: Impact speeds of the table [m/s], if the contact depends on the speed.
SPEEDS = (0.01, 0.1, 1.0, 10.0)
#: Steps between round angles [deg], and the largest number of these.
STEPS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
MAX_ANGLES = 20
#: Largest angle by default [deg].
LAST_ANGLE = 85.0
#: Beyond this angle [rad] of sticking, surfaces count as never slipping.
STEEPEST = math.radians(89.95)
#: Largest number of angles in a table.
MOST_ANGLES = 10_000
#: Angles [rad] at which speeds are compared.
TESTED = np.radians([5.0, 20.0, 45.0, 70.0])


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


class Angles(Quantity):
    """Angles: a number, a list ``10,20``, ``start:stop``, or ``start:stop:count``."""

    name = "angles"

    def read(self, option: str, text: str) -> Any:
        from .sweep import axis

        if text.count(":") != 1:
            count = text.split(":")[2:3]
            if count and count[0].isdigit() and int(count[0]) > MOST_ANGLES:
                raise ValueError(
                    f"{option}: got {validation.shown(int(count[0]))} angles, must be in [1, {MOST_ANGLES}]"
                )
            return np.atleast_1d(axis(option, text, self.unit))
        first, last = (super(Angles, self).read(option, part) for part in text.split(":"))
        return round_angles(first, last) if 0.0 <= first < last < 90.0 else np.array([first, last])


def round_angles(first: float, last: float) -> Floats:
    """Both angles [deg] and the round ones between them, about twenty in all."""
    step = next(step for step in STEPS if (last - first) / step <= MAX_ANGLES)
    between = step * np.arange(math.floor(first / step) + 1, math.ceil(last / step))
    return np.array([first, *between, last])


EXAMPLES = """\b
Example:
  hardlimit contact --restitution 0.5 --radius 1cm --density 2500
  hardlimit contact --restitution 0.9 --friction 0.5 --stiffness-ratio 0.9 \\
      --angle 0deg:89deg --plot beta.png"""


@click.command(cls=Command, epilog=EXAMPLES)
@body_options(".  [default: 0.01]", ".  [default: 840]")
@law_options()
@friction_options()
@quantity_options(
    ("--inertia-factor", "1", "Moment of inertia of balls over m R².  [default: 0.4, solid spheres]"),
    ("--speed", "m/s", "Impact speed [m/s]; repeat it for a table.", "speeds"),
)
@click.option(
    "--angle",
    "angles",
    type=Angles("deg"),
    help="Angles of impact [deg] with --friction: a number, a list a,b,… or start:stop[:count].  [default: 0:85]",
)
@output_option("--plot", "Plot of the restitution, with --friction of the tangential one (png, pdf, …).")
@dpi_option
@json_option()
def contact(
    speeds: tuple[float, ...],
    angles: Floats | None,
    plot: str | None,
    dpi: float | None,
    as_json: bool,
    **params: Any,
) -> None:
    """Compute duration, restitution and damping of one contact.

    The output also has the restitution that the usual formula for the damping would give. With --friction, it has the
    tangential restitution β over the angle of impact, in the limit of a fixed normal: the surfaces leave with −β times
    their tangential velocity. Without options, a ball of radius 1 cm and density 840 kg/m³ meets the floor under the
    linear law with stiffness 5e7 N/m and restitution 0.7. Numbers may have a unit, such as 1cm.
    """
    path = picture("plot", plot)
    rule = take_friction(law_from(params), params)
    gamma = impact_angles(angles, rule)
    ball = make_ball("", params, 0.01, 840.0)
    partner = other_ball(ball, params)
    pair = rule.between(ball, partner)
    given_speeds = [validation.number(f"speeds[{i}]", s, 0.0) for i, s in enumerate(speeds)]
    default = {*SPEEDS, pair.law.parameters.get("impact_speed", 1.0)} if depends_on_speed(pair) else {1.0}
    v = np.array(given_speeds or sorted(default))
    usual = usual_formula(pair)
    if path and gamma is not None:
        draw_friction(pair, gamma, v, path, dpi)
    elif path:
        draw(pair, path, dpi)
    depth = pair.compression(v) / min(ball.radius, partner.radius)
    frictions = (
        []
        if gamma is None
        else [friction_at(pair, gamma, float(speed)) for speed in friction_speeds(pair, v)]
    )
    if as_json:
        print_json(as_mapping(pair, v, depth, usual) | ({"friction": frictions} if frictions else {}))
    else:
        print_report(pair, ball, partner, v, depth, usual)
        if frictions:
            print_friction(frictions)


def impact_angles(angles: Floats | None, law: Law) -> Floats | None:
    """The angles of impact [rad]; None for a law without friction."""
    if law.friction is None:
        if angles is not None:
            raise ValueError(f"angles: got {digits(angles[0])}, must be left out without friction")
        return None
    degrees = round_angles(0.0, LAST_ANGLE) if angles is None else angles
    for i, angle in enumerate(degrees.tolist()):
        validation.number(f"angles[{i}]", angle, 0.0, 90.0, lowest_allowed=True)
    return np.radians(degrees)


def law_from(params: dict[str, Any]) -> Law:
    """The law of Fig. 2 changed by the options, which are taken out."""
    return files.changed_law(Column.paper().laws[0], *take_law(params))


def make_ball(which: str, params: dict[str, Any], radius: float, density: float) -> Ball:
    """A ball from the options with the prefix ``which``; radius and density are defaults."""
    size, rho, mass = (params[which + name] for name in ("radius", "density", "mass"))
    q = params.get("inertia_factor")
    rho = density if rho is None and mass is None else rho
    try:
        return Ball(
            radius if size is None else size, rho, mass, **({} if q is None else {"inertia_factor": q})
        )
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
        "law": law_mapping(pair.law),
        "effective_mass": pair.effective_mass,
        "effective_radius": pair.effective_radius,
        **{c["name"]: float(getattr(pair, c["name"])) for c in pair.law.record["constants"]},
        "speed": speeds,
        "restitution": pair.restitution(speeds),
        "duration": pair.duration(speeds),
        "largest_compression": depth,
        "usual_formula": usual,
    }


# --- friction -----------------------------------------------------------------------------------------------


def friction_speeds(pair: Contact, speeds: Floats) -> Floats:
    """The speeds at which friction is shown: only one if it does not depend on the speed."""
    slow, fast = (pair.tangential_restitution(TESTED, float(speed)) for speed in (speeds.min(), speeds.max()))
    return speeds[:1] if np.allclose(slow, fast, rtol=0.0, atol=1e-9, equal_nan=True) else speeds


def friction_at(pair: Contact, angles: Floats, speed: float) -> dict[str, Any]:
    """What friction does at one speed, in SI units: β and the ratio of the impulses over the angle."""
    beta = pair.tangential_restitution(angles, speed)
    share = pair.tangential_mass / pair.effective_mass / (1.0 + pair.restitution(speed))
    return {
        "speed": speed,
        "angle": angles,
        "tangential_restitution": beta,
        "impulse_ratio": share * (1.0 + beta) * np.tan(angles),
        "has_spring": pair.friction_terms is not None and pair.friction_terms.stiffness > 0.0,
        "sticks_below": pair.sticks_below(speed),
        "slides_beyond": pair.slides_beyond(speed),
        "effective_tangential_restitution": pair.effective_tangential_restitution(speed),
    }


def print_friction(frictions: list[dict[str, Any]]) -> None:
    """Print β over the angle of impact, and what it means."""
    several = len(frictions) > 1
    at = [f" at {digits(friction['speed'])} m/s" if several else "" for friction in frictions]
    names = [
        "angle",
        *(f"{name}{v}" for v in at for name in (("β",) if several else ("β", "J_t/J_n", "surfaces"))),
    ]
    rows = []
    for i, angle in enumerate(frictions[0]["angle"].tolist()):
        row = [f"{digits(math.degrees(angle), 4)}°"]
        for friction in frictions:
            row.append(f"{friction['tangential_restitution'][i]:+.4f}".replace("-", "−"))
            if not several:
                row += [f"{friction['impulse_ratio'][i]:.4f}", motion(friction, angle)]
        rows.append(row)
    below = " ".join(
        friction_sentence(friction, where) for friction, where in zip(frictions, at, strict=True)
    )
    show(console(), "Tangential restitution β over the angle of impact", table(names, rows), below)


def motion(friction: dict[str, Any], angle: float) -> str:
    """What the surfaces do in a contact at this angle."""
    if math.isnan(friction["sticks_below"]) and friction["has_spring"]:
        return "–"
    if angle < friction["sticks_below"]:
        return "stick"
    return "both" if 0.0 < angle <= friction["slides_beyond"] else "slide"


def friction_sentence(friction: dict[str, Any], where: str) -> str:
    """Where the surfaces stick and slide, and which constant rule acts alike in a gas."""
    sticks, slides, beta = (
        friction[name] for name in ("sticks_below", "slides_beyond", "effective_tangential_restitution")
    )
    text = f"{where.strip().capitalize()}, they" if where else "The surfaces"
    if math.isnan(sticks):
        swings = (
            " stick and slip in turn: the tangential spring swings more than a hundred times in a contact."
        )
        text += swings if friction["has_spring"] else " never stick."
    elif slides == 0.0:
        text += " always slide."
    elif sticks > STEEPEST:
        text += " never slip."
    else:
        text += f" do not slip while the bodies approach below {math.degrees(sticks):.1f}°, "
        text += f"and do not stick while they separate beyond {math.degrees(slides):.1f}°."
    if math.isnan(beta):
        return text
    return f"{text} In a gas they act as with a constant β0 = {digits(beta, 3)}."


def draw_friction(pair: Contact, angles: Floats, speeds: Floats, path: Path, dpi: float | None) -> None:
    """Draw β over the angle."""
    from .. import plots

    dense = (
        np.linspace(angles.min(), angles.max(), 300)
        if len(angles) > 1
        else np.linspace(0.0, math.radians(LAST_ANGLE), 300)
    )
    plots.save(plots.tangential_restitution(pair, dense, friction_speeds(pair, speeds)), path, dpi)


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
