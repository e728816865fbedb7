"""``hardlimit convert``: a restitution as the numbers of particle codes, and back."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import click

from ..column.files import prefixed
from ..contact.balls import FLOOR, Ball
from ..convert import convert as converted
from ..convert import convert_back
from ..convert.codes import code, names
from ..convert.conversion import ContactNumbers, Conversion, ModelConversion, ModelNumbers, Obtained
from ..convert.wanted import LAWS
from ..support import validation
from .options import options, quantity_option
from .printing import console, digits, length, print_json, quantity, show, table
from .program import Command

EXAMPLES = """\b
Example:
  hardlimit convert --restitution 0.7 --radius 0.5mm --density 7850 --youngs-modulus 210GPa \\
      --poisson-ratio 0.3 --code lammps
  hardlimit convert --restitution 0.7 --radius 0.5mm --radius 1mm --density 2500 --stiffness 1e5
  hardlimit convert --radius 0.5mm --density 2500 --code lammps \\
      --input 'hooke 1e5 0.7 damping coeff_restitution limit_damping'"""

USUAL = "Usual: the wanted ε itself, or the damping of the usual formula. Input to paste: --code NAME"
#: What the damping of each law is measured in.
DAMPING_UNITS = {"linear": "N s/m", "tsuji": "N s/m^1.25", "viscoelastic": "N s/m^1.5"}
#: Heads of columns.
SHORT = {
    "youngs_modulus": "Y [Pa]",
    "poisson_ratio": "ν",
    "characteristic_speed": "speed",
    "contact_time": "time [s]",
}
STIFFNESS_UNITS = {"linear": "N/m", "tsuji": "N/m^1.5", "viscoelastic": "N/m^1.5"}

bed = options(
    quantity_option(
        "--radius",
        "radii",
        unit="m",
        multiple=True,
        help="Radius of a ball [m]; repeat for each size of a bed.",
    ),
    quantity_option(
        "--density",
        "densities",
        unit="kg/m3",
        multiple=True,
        help="Density [kg/m³], of all balls; or repeated.",
    ),
    quantity_option("--mass", "masses", unit="kg", multiple=True, help="Mass [kg], instead of the density."),
    click.option("--wall/--no-wall", default=None, help="Contacts with a wall as well.  [default: yes]"),
)
contact_options = options(
    quantity_option("--restitution", unit="1", help="Restitution ε that is wanted."),
    quantity_option("--speed", unit="m/s", help="Speed of impact at which it is wanted [m/s].  [default: 1]"),
    quantity_option("--stiffness", unit="N/m", help="Stiffness of a linear spring [N/m]."),
    quantity_option(
        "--youngs-modulus", unit="Pa", help="Instead of it, Young's modulus of the material [Pa]."
    ),
    quantity_option("--poisson-ratio", unit="1", help="Poisson's ratio of the material, beside the modulus."),
    quantity_option("--duration", unit="s", help="Or the duration of each contact [s]."),
    quantity_option("--compression", unit="m", help="Or the greatest compression in each contact [m]."),
    click.option(
        "--law",
        type=click.Choice(list(LAWS)),
        help="Contact law: linear, or Hertz with one of two dampings.  [default: tsuji with a modulus, else linear]",
    ),
)


def models_of_code(context: click.Context, _: click.Parameter, begun: str) -> list[str]:
    """For the shell: the models of the code that stands before."""
    named = context.params.get("code")
    return [m.name for m in code(named).models if m.name.startswith(begun)] if named else []


code_options = options(
    click.option(
        "--code", type=click.Choice(names()), help="Code whose input is wanted.  [default: a table of all]"
    ),
    click.option(
        "--model", shell_complete=models_of_code, help="Model of the code.  [default: all of the law]"
    ),
    click.option(
        "--attraction",
        is_flag=True,
        help="Where a code leaves the choice, a force that attracts at the end of a contact.",
    ),
    click.option(
        "--input", "text", help="Lines of the code's input: what they really give. '-' reads standard input."
    ),
    click.option("--read", metavar="FILE", help="The same from a file."),
    click.option(
        "--contact",
        metavar="NAME",
        help="Contact of an input that has several, such as 1-2 or 1-wall.  [default: the only one]",
    ),
    quantity_option(
        "--restitution-error", unit="1", help="Error of ε that the time step may make.  [default: 0.001]"
    ),
    quantity_option(
        "--time-step", unit="s", help="Instead of that error, a time step [s] whose error is wanted."
    ),
)


@click.command(cls=Command, epilog=EXAMPLES)
@bed
@contact_options
@code_options
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def convert(
    radii: tuple[float, ...],
    densities: tuple[float, ...],
    masses: tuple[float, ...],
    wall: bool | None,
    text: str | None,
    read: str | None,
    as_json: bool,
    **given: Any,
) -> None:
    """A restitution as the input of particle codes, and back.

    Every code turns a restitution into a force in a way of its own, and some let the force attract where others cut it
    off, so that the same number gives another ε in each. This gives each code the number with which ε is the one that
    is wanted, says what the usual number would give, and how long a time step may be. With --input, it says what lines
    of input really give. Numbers may bear a unit, such as 0.5mm or 210GPa.
    """
    balls = bed_of(radii, densities, masses)
    if text is not None or read is not None:
        given_text = input_text(text, read)
        show_obtained(back(given_text, balls, wall, given), balls, given, as_json)
        return
    if given.pop("contact") is not None:
        raise ValueError("contact: must be given beside input, of which it is one")
    if given["restitution"] is None:
        raise ValueError("restitution: missing, must be given, or --input")
    given["speed"] = 1.0 if given["speed"] is None else given["speed"]
    found = converted(balls, wall=wall is not False, **given)
    if as_json:
        print_json(found.to_dict())
    else:
        print_conversion(found, balls, given["code"] is not None)


def bed_of(radii: tuple[float, ...], densities: tuple[float, ...], masses: tuple[float, ...]) -> list[Ball]:
    """The sizes of a bed; one density for all of them, or as many as radii."""
    if not radii:
        raise ValueError("radius: missing, must be given")
    validation.exactly_one(density=densities or None, mass=masses or None)
    name, values = ("density", densities) if densities else ("mass", masses)
    if len(values) not in (1, len(radii)):
        raise ValueError(f"{name}: got {len(values)} values, must be 1 or {len(radii)}, as of radius")
    each = values * len(radii) if len(values) == 1 else values
    which = ["" if len(radii) == 1 else f"ball {i + 1}: " for i in range(len(radii))]
    return [
        prefixed(w, lambda r=r, v=v: Ball(r, **{name: v}))  # type: ignore[misc]
        for w, r, v in zip(which, radii, each, strict=True)
    ]


def input_text(text: str | None, read: str | None) -> str:
    """Lines of input from the command line, a file or standard input."""
    if text is not None and read is not None:
        raise ValueError("input | read: got both, must be one of them")
    if text == "-":
        return sys.stdin.read()
    if text is not None:
        return text
    assert read is not None
    try:
        return Path(read).read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        because = getattr(error, "strerror", None) or error
        raise ValueError(f"read: got {validation.shown(read)}, cannot be read: {because}") from None


def back(text: str, balls: list[Ball], wall: bool | None, given: dict[str, Any]) -> Obtained:
    """What an input gives for one or two balls, or with ``--wall`` for one ball and a wall."""
    for name in (
        "restitution",
        "stiffness",
        "youngs_modulus",
        "poisson_ratio",
        "duration",
        "compression",
        "law",
    ):
        if given[name] is not None:
            raise ValueError(f"{name}: got {given[name]}, must not be given beside input, which says it")
    if given["code"] is None:
        raise ValueError(f"code: missing, must be one of {', '.join(names())} beside input")
    if len(balls) > (1 if wall else 2):
        raise ValueError(f"radius: got {len(balls)} values, must be {1 if wall else '1 or 2'} beside input")
    other = FLOOR if wall else balls[-1]
    speed = 1.0 if given["speed"] is None else given["speed"]
    options = {name: given[name] for name in ("code", "model", "restitution_error", "time_step", "contact")}
    return convert_back(text, balls[0], other, speed=speed, **options)


# --- what is printed ----------------------------------------------------------------------------------------


def print_conversion(found: Conversion, balls: list[Ball], one_code: bool) -> None:
    out = console()
    wanted = found.wanted
    sizes = ", ".join(
        f"{i + 1}: {length(b.radius)}, {quantity(b.mass * 1e3, 'g', 4)}" for i, b in enumerate(balls)
    )
    asked = f"ε = {digits(wanted.restitution)} at {digits(wanted.speed)} m/s, {wanted.law} law"
    units = f"Stiffness in {STIFFNESS_UNITS[wanted.law]}, damping in {DAMPING_UNITS[wanted.law]}."
    below = f"Balls (radius, mass): {sizes}. {units} {step_words(found.contacts)}"
    show(out, asked, contact_table(found), below)
    if one_code:
        for model in found.models:
            print_model(out, model)
    else:
        rows = [row for model in found.models for row in overview_rows(model)]
        head = ["code and model", "contact", "usual: ε", "give it", "then ε"]
        show(out, "What the codes make of it", table(head, rows), USUAL)


def contact_table(found: Conversion) -> Any:
    head = ["contact", "stiffness", "damping", "duration", "overlap", "force", "time step"]
    return table(head, [contact_row(contact) for contact in found.contacts])


def contact_row(contact: ContactNumbers) -> list[str]:
    return [
        contact.pair,
        digits(contact.stiffness, 5),
        digits(contact.damping, 5),
        quantity(contact.duration, "s", 4),
        quantity(contact.compression, "m", 4),
        quantity(contact.force, "N", 4),
        step_of(contact),
    ]


def step_of(row: ContactNumbers | ModelNumbers | Obtained) -> str:
    """A time step, or a dash where the bodies stay together."""
    return "–" if math.isnan(row.time_step) else quantity(row.time_step, "s", 4)


def step_words(rows: tuple[ContactNumbers, ...] | tuple[ModelNumbers, ...]) -> str:
    """What the time step does to ε."""
    errors = [row.restitution_error for row in rows if not math.isnan(row.restitution_error)]
    return f"With the time step, ε errs by {digits(max(errors), 2)} at most." if errors else ""


def overview_rows(model: ModelConversion) -> list[list[str]]:
    """Of one model: one line where all contacts agree, else one for each."""
    rows = [
        [
            row.pair,
            digits(row.usual_restitution, 4),
            main_number(model, row),
            digits(row.restitution, 5),
        ]
        for row in model.contacts
    ]
    if len({tuple(row[1:]) for row in rows}) == 1:
        rows = [["all", *rows[0][1:]]]
    return [[f"{model.code.name} {model.model.name}" if k == 0 else "", *row] for k, row in enumerate(rows)]


def main_number(model: ModelConversion, row: ModelNumbers) -> str:
    """The number that makes the damping, by its name."""
    if row.numbers is None:
        return "not to be had"
    name = model.model.damping.number
    if not name:
        return "no damping"
    return f"{name} {digits(row.numbers[name], 5)}"


def print_model(out: Any, model: ModelConversion) -> None:
    given = list(next((row.numbers for row in model.contacts if row.numbers is not None), {}))
    head = ["contact", *(SHORT.get(name, name) for name in given), "then ε", "usual: ε", "time step"]
    rows = []
    for row in model.contacts:
        values = ["–"] * len(given) if row.numbers is None else [digits(row.numbers[n], 6) for n in given]
        rows.append(
            [row.pair, *values, digits(row.restitution, 5), digits(row.usual_restitution, 4), step_of(row)]
        )
    end = "attracts at its end" if model.attraction else "never attracts"
    checked = (
        "by running it" if (model.model.checked or model.code.checked) == "run" else "against its source only"
    )
    if model.model.keyword:
        end += f" (with {model.model.keyword}; --attraction leaves it out)" if not model.attraction else ""
    note = model.model.note
    note = f"{note[0].upper()}{note[1:]}" if note[0].isascii() else note  # no capital ζ
    below = f"{note}. This force {end}. Mass at a wall: {model.code.walls}. Checked {checked}."
    show(out, f"{model.code.title} {model.model.name}: {model.model.title}", table(head, rows), below)
    if model.text:
        click.echo(model.text + "\n")


def show_obtained(found: Obtained, balls: list[Ball], given: dict[str, Any], as_json: bool) -> None:
    if as_json:
        print_json(found.to_dict())
        return
    rows = [[name.replace("_", " "), digits(value)] for name, value in found.numbers.items()]
    rows += [["restitution ε, really", digits(found.restitution)]]
    if found.numerical_damping:
        rows += [["numerical damping", digits(found.numerical_damping)]]
    else:
        rows += [["duration", quantity(found.duration, "s")]]
    rows += [["greatest compression", quantity(found.compression, "m")]]
    rows += [["greatest force", quantity(found.force, "N")], ["time step", step_of(found)]]
    end = "attracts at its end" if found.attraction else "never attracts"
    below = f"This force {end}. " + (
        f"With the time step, ε errs by {digits(found.restitution_error, 2)}."
        if found.restitution > 0.0
        else "The bodies stay together."
    )
    below = " ".join([below, *(f"{note[0].upper()}{note[1:]}." for note in found.notes)])
    speed = 1.0 if given["speed"] is None else given["speed"]
    title = f"{found.code.title} {found.model.name} at {digits(speed)} m/s"
    show(console(), title, table(["", "value"], rows), below)
