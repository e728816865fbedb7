"""``hardlimit convert``: convert a restitution to the input of particle codes, and back."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from typing import Any

import click

from ..checking.friction_words import words
from ..checking.reading_back import Obtained, convert_back
from ..checking.scripts import CODES
from ..column.files import prefixed
from ..contact.balls import FLOOR, Ball
from ..convert import convert as converted
from ..convert.codes import code, names
from ..convert.conversion import ContactNumbers, Conversion, ModelConversion, ModelNumbers
from ..convert.wanted import LAWS
from ..support import validation
from ..support.formatting import digits, length, listed, quantity
from .options import json_option, options, quantity_options
from .printing import console, print_json, sentence, show, table
from .program import Command

EXAMPLES = """\b
Example:
  hardlimit convert --restitution 0.7 --radius 0.5mm --density 7850 \\
      --youngs-modulus 210GPa --poisson-ratio 0.3 --code lammps
  hardlimit convert --restitution 0.7 --radius 0.5mm --radius 1mm --density 2500 \\
      --stiffness 1e5
  hardlimit convert --restitution 0.7 --radius 0.5mm --density 2500 --stiffness 1e5 \\
      --friction 0.5 --tangential-restitution 0.33 --code lammps
  hardlimit convert --radius 0.5mm --density 2500 --code lammps \\
      --input 'hooke 1e5 0.7 damping coeff_restitution limit_damping'"""

USUAL = (
    "Usual ε: that of the usual input, which is the desired ε itself or the damping of the usual formula. Input: that "
    "for the desired ε; --code NAME prints it to paste."
)
FRICTION = (
    "β0: that of grains with a constant β0 of sticking contacts and as much exchange of energy between translation and "
    "rotation, in a gas at equal temperatures of both. Default: by the code's own k_t and damping."
)
ERROR_OF_STEP = " Δβ: largest error of β by the time step."
INPUTS = "LAMMPS, LIGGGHTS or YADE"
#: Short names of numbers in the heads of columns.
SHORT = {
    "youngs_modulus": "Y [Pa]",
    "poisson_ratio": "ν",
    "characteristic_speed": "speed",
    "contact_time": "time [s]",
}

#: Short names of the numbers of friction.
TANGENTIAL = {
    **SHORT,
    "coefficient": "μ",
    "stiffness": "k_t",
    "damping": "γ_t",
    "damping_ratio": "x_γt",
}

#: Angles of impact [deg] of which β is shown; multiples of 5.
ANGLES = (0, 30, 45, 60, 80)

bed = options(
    quantity_options(
        ("--radius", "m", "Radius of a ball [m]; repeat it for each size of a bed.", "radii"),
        ("--density", "kg/m3", "Density [kg/m³]; repeat it for each size if they differ.", "densities"),
        ("--mass", "kg", "Mass [kg] instead of the density.", "masses"),
    ),
    click.option("--wall/--no-wall", default=None, help="Include contacts with a wall.  [default: yes]"),
)
contact_options = options(
    quantity_options(
        ("--restitution", "1", "Desired restitution ε."),
        ("--friction", "1", "Coefficient of friction μ.  [default: smooth grains]"),
        ("--tangential-restitution", "1", "Desired tangential restitution β0 in a gas, with --friction."),
        ("--speed", "m/s", "Impact speed at which ε is desired [m/s].  [default: 1]"),
        ("--stiffness", "N/m", "Stiffness of a linear spring [N/m]."),
        ("--youngs-modulus", "Pa", "Young's modulus of the material [Pa], instead of the stiffness."),
        ("--poisson-ratio", "1", "Poisson's ratio of the material, together with the modulus."),
        ("--duration", "s", "Duration of each contact [s], instead of the stiffness."),
        ("--compression", "m", "Largest compression in a contact [m], instead of the stiffness."),
    ),
    click.option(
        "--law",
        type=click.Choice(list(LAWS)),
        help="Contact law: linear, or Hertz with either damping.  [default: tsuji with a modulus, else linear]",
    ),
)
#: Options that an input sets.
SET_BY_INPUT = (
    *("restitution", "stiffness", "youngs_modulus", "poisson_ratio", "duration", "compression", "law"),
    *("friction", "tangential_restitution"),
)


def models_of_code(context: click.Context, _: click.Parameter, begun: str) -> list[str]:
    """Shell completion: the models of the code given before."""
    named = context.params.get("code")
    return [m.name for m in code(named).models if m.name.startswith(begun)] if named else []


code_options = options(
    click.option(
        "--code", type=click.Choice(names()), help="Code to write input for.  [default: a table of all codes]"
    ),
    click.option(
        "--model",
        shell_complete=models_of_code,
        help="Contact model of the code.  [default: all models of the law]",
    ),
    click.option(
        "--attraction",
        is_flag=True,
        help="Let the force attract at the end of a contact, if this is an option of the code.",
    ),
    click.option(
        "--input", "text", help=f"Lines of input of {INPUTS} to evaluate; '-' reads standard input."
    ),
    click.option("--read", metavar="FILE", help=f"File with input of {INPUTS} to evaluate."),
    click.option(
        "--contact",
        metavar="NAME",
        help="Contact to evaluate if the input has several, such as 1-2 or 1-wall.",
    ),
    quantity_options(
        ("--restitution-error", "1", "Error of ε that the time step may cause.  [default: 0.001]"),
        ("--time-step", "s", "Time step [s] for which to compute the error of ε."),
    ),
)


@click.command(cls=Command, epilog=EXAMPLES)
@bed
@contact_options
@code_options
@json_option()
def convert(
    radii: tuple[float, ...],
    densities: tuple[float, ...],
    masses: tuple[float, ...],
    wall: bool | None,
    text: str | None,
    read: str | None,
    as_json: bool,
    **params: Any,
) -> None:
    """Convert a restitution to input of particle codes, and back.

    Particle codes convert a restitution to a damping force by different formulas, and some let the force attract at
    the end of a contact. The same input therefore gives different restitutions. This command finds the input with
    which each code has the desired ε, the ε that the usual input would give, and the longest time step. With --friction
    and --tangential-restitution, the input has the friction with which a gas of these grains has that β0. With --input,
    it computes the ε and β that lines of a code's input produce. Numbers may have a unit, such as 0.5mm or 210GPa.
    """
    balls = bed_of(radii, densities, masses)
    if text is not None or read is not None:
        given_text = input_text(text, read)
        show_obtained(back(given_text, balls, wall, params), params, as_json)
        return
    if params.pop("contact") is not None:
        raise ValueError("contact: must be left out without input")
    if params["restitution"] is None:
        raise ValueError("restitution: missing, must be given unless there is an input")
    params["speed"] = 1.0 if params["speed"] is None else params["speed"]
    conversion = converted(balls, wall=wall is not False, **params)
    if as_json:
        print_json(conversion.to_dict())
    else:
        print_conversion(conversion, balls, params["code"] is not None)


def bed_of(radii: tuple[float, ...], densities: tuple[float, ...], masses: tuple[float, ...]) -> list[Ball]:
    """A ball for each size of a bed, with one density for all or one for each."""
    if not radii:
        raise ValueError("radius: missing, must be given")
    validation.exactly_one(density=densities or None, mass=masses or None)
    name, values = ("density", densities) if densities else ("mass", masses)
    if len(values) not in (1, len(radii)):
        raise ValueError(f"{name}: got {len(values)} values, must be 1 or {len(radii)}, one for each radius")
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
        return validation.path("read", read).read_text(encoding="utf-8")
    except OSError as error:
        raise validation.unreadable(read, error, "read") from None
    except UnicodeDecodeError as error:
        raise ValueError(f"read: {read}: cannot be read: {error}") from None


def back(text: str, balls: list[Ball], wall: bool | None, params: dict[str, Any]) -> Obtained:
    """The contact that an input gives for one or two balls, or with ``--wall`` for a ball and a wall."""
    for name in SET_BY_INPUT:
        if params[name] is not None:
            raise ValueError(f"{name}: got {params[name]}, must be left out with input, which sets it")
    if params["code"] is None:
        raise ValueError(f"code: missing, must be one of {', '.join(CODES)} with input")
    if len(balls) > (1 if wall else 2):
        raise ValueError(f"radius: got {len(balls)} values, must be {1 if wall else '1 or 2'} with input")
    other = FLOOR if wall else balls[-1]
    speed = 1.0 if params["speed"] is None else params["speed"]
    options = {name: params[name] for name in ("code", "model", "restitution_error", "time_step", "contact")}
    return convert_back(text, balls[0], other, speed=speed, **options)


# --- output -------------------------------------------------------------------------------------------------


def print_conversion(conversion: Conversion, balls: list[Ball], one_code: bool) -> None:
    """The contacts, and the input of one code or a table of all codes."""
    out = console()
    wanted = conversion.wanted
    sizes = ", ".join(
        f"{i + 1}: {length(b.radius)}, {quantity(b.mass * 1e3, 'g', 4)}" for i, b in enumerate(balls)
    )
    request = f"ε = {digits(wanted.restitution)} at {digits(wanted.speed)} m/s, {wanted.law} law"
    if wanted.walton is not None:
        request += (
            f", μ = {digits(wanted.walton.coefficient)}, β0 = {digits(wanted.walton.tangential_restitution)}"
        )
    stiffness, damping = LAWS[wanted.law].units
    units = f"Stiffness in {stiffness}, damping in {damping}."
    below = f"Balls (radius, mass): {sizes}. {units} {step_sentence(conversion.contacts)}"
    below += ratio_sentence(conversion)
    show(out, request, contact_table(conversion), below)
    if one_code:
        for model in conversion.models:
            print_model(out, model)
        if wanted.walton is not None:
            out.print(FRICTION + ERROR_OF_STEP + not_known(conversion))
    elif conversion.models:
        rows = [row for model in conversion.models for row in overview_rows(model)]
        head = ["code and model", "contact", "usual ε", "input", "ε"]
        show(out, "Input of the codes", table(head, rows), USUAL)
        if wanted.walton is not None:
            rows = [row for model in conversion.models for row in friction_rows(model)]
            head = ["code and model", "contact", "default β0", "input", "β0"]
            show(out, "Friction of the codes", table(head, rows), FRICTION + not_known(conversion))


def contact_table(conversion: Conversion) -> Any:
    head = ["contact", "stiffness", "damping", "duration", "overlap", "force", "time step"]
    return table(head, [contact_row(contact) for contact in conversion.contacts])


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
    """A time step, or a dash if the bodies do not separate."""
    return "–" if math.isnan(row.time_step) else quantity(row.time_step, "s", 4)


def step_sentence(rows: tuple[ContactNumbers, ...] | tuple[ModelNumbers, ...]) -> str:
    """A sentence on the error of ε that the time step causes."""
    errors = [row.restitution_error for row in rows if not math.isnan(row.restitution_error)]
    return f"With this time step the error of ε is at most {digits(max(errors), 2)}." if errors else ""


def ratio_sentence(conversion: Conversion) -> str:
    """A sentence on the tangential stiffness of our own law."""
    if conversion.wanted.walton is None:
        return ""
    ratios = [contact.stiffness_ratio or math.nan for contact in conversion.contacts]
    if any(map(math.isnan, ratios)):
        return " No tangential spring of this law has this β0."
    return f" This law has this β0 with k_t/k_n = {range_of(min(ratios), max(ratios), 4)}, without damping."


def overview_rows(model: ModelConversion) -> list[list[str]]:
    """The rows of a model: one if all contacts agree, else one for each contact."""
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


def not_known(conversion: Conversion) -> str:
    """A sentence on the codes whose friction is not known."""
    titles = dict.fromkeys(model.code.title for model in conversion.models if not model.model.friction)
    verb = "computes" if len(titles) == 1 else "compute"
    return f" How {listed(list(titles))} {verb} friction is not known here." if titles else ""


def friction_rows(model: ModelConversion) -> list[list[str]]:
    """The rows of the friction of a model: one if all contacts agree, else one for each contact."""
    rows = [
        [
            row.pair,
            digits(row.friction.usual_tangential_restitution, 3),
            free_number(model, row),
            digits(row.friction.tangential_restitution, 4),
        ]
        for row in model.contacts
        if row.friction is not None
    ]
    if len({tuple(row[1:]) for row in rows}) == 1:
        rows = [["all", *rows[0][1:]]]
    name = f"{model.code.name} {model.model.name}"
    return [[name if k == 0 else "", *row] for k, row in enumerate(rows)]


def free_number(model: ModelConversion, row: ModelNumbers) -> str:
    """The number that sets the tangential restitution, with its name."""
    if row.friction is None or row.friction.numbers is None or model.friction is None:
        return "impossible"
    name = model.friction.free
    numbers = {**(row.numbers or {}), **row.friction.numbers}
    return f"{TANGENTIAL.get(name, name)} {digits(numbers[name], 5)}" if name else "–"


def main_number(model: ModelConversion, row: ModelNumbers) -> str:
    """The number that sets the damping, with its name."""
    if row.numbers is None:
        return "impossible"
    name = model.model.damping.number
    if not name:
        return "no damping"
    return f"{name} {digits(row.numbers[name], 5)}"


def print_model(out: Any, model: ModelConversion) -> None:
    """The numbers of a model for each contact, and its input to paste."""
    names = list(next((row.numbers for row in model.contacts if row.numbers is not None), {}))
    head = ["contact", *(SHORT.get(name, name) for name in names), "ε", "usual ε", "time step"]
    rows = []
    for row in model.contacts:
        values = ["–"] * len(names) if row.numbers is None else [digits(row.numbers[n], 6) for n in names]
        rows.append(
            [row.pair, *values, digits(row.restitution, 5), digits(row.usual_restitution, 4), step_of(row)]
        )
    friction = friction_table(model)
    end = "attracts at its end" if model.attraction else "never attracts"
    checked = (
        "by running it" if (model.model.checked or model.code.checked) == "run" else "against its source only"
    )
    if model.model.keyword:
        end += f" (with {model.model.keyword}; --attraction leaves it out)" if not model.attraction else ""
    note = model.model.note
    below = f"{sentence(note)} The force {end}. Mass at a wall: {model.code.walls}. Checked {checked}."
    show(out, f"{model.code.title} {model.model.name}: {model.model.title}", table(head, rows), below)
    if friction is not None:
        title = f"Friction: {model.friction.model}" if model.friction else "Friction: no numbers have this β0"
        show(out, title, friction)
    if model.text:
        click.echo(model.text + "\n")


def friction_values(obtained: Obtained) -> list[list[str]]:
    """β at some angles, and in a gas, if they are known."""
    beta = {round(math.degrees(angle)): beta for angle, beta in obtained.friction.tangential_restitution}
    rows = [
        [f"β at {angle}°" if angle else "β near head-on", digits(beta[angle], 4)] for angle in ANGLES if beta
    ]
    in_gas = obtained.friction.effective_tangential_restitution
    return rows if in_gas is None else [*rows, ["β0 in a gas", digits(in_gas, 4)]]


def friction_table(model: ModelConversion) -> Any:
    """The numbers of the friction of each contact; None without friction."""
    frictions = [(row.pair, row.friction) for row in model.contacts if row.friction is not None]
    if not frictions:
        return None
    names = list(next((f.numbers for _, f in frictions if f.numbers is not None), {}))
    rows = []
    for pair, friction in frictions:
        values = (
            ["–"] * len(names)
            if friction.numbers is None
            else [digits(friction.numbers[name], 6) for name in names]
        )
        possible = ", ".join(range_of(*limits) for limits in friction.reachable)
        obtained, default = friction.tangential_restitution, friction.usual_tangential_restitution
        ends = [digits(obtained, 4), digits(friction.error_of_step, 2), digits(default, 3), possible]
        rows.append([pair, *values, *ends])
    names = [TANGENTIAL.get(name, name.replace("_", " ")) for name in names]
    return table(["contact", *names, "β0", "Δβ", "default β0", "possible β0"], rows)


def range_of(lowest: float, highest: float, significant: int = 3) -> str:
    """A range of numbers."""
    ends = dict.fromkeys(digits(end, significant) for end in (lowest, highest))
    return " to ".join(ends)


def show_obtained(obtained: Obtained, params: dict[str, Any], as_json: bool) -> None:
    """The contact that an input gives."""
    if as_json:
        print_json(obtained.to_dict())
        return
    rows = [[name.replace("_", " "), digits(value)] for name, value in obtained.numbers.items()]
    rows += [["restitution ε", digits(obtained.restitution)]]
    if obtained.numerical_damping:
        rows += [["numerical damping", digits(obtained.numerical_damping)]]
    rows += [["duration", quantity(obtained.duration, "s")]]
    rows += [["largest compression", quantity(obtained.compression, "m")]]
    rows += [["largest force", quantity(obtained.force, "N")], ["time step", step_of(obtained)]]
    rows += friction_values(obtained)
    end = "attracts at its end" if obtained.attraction else "never attracts"
    below = f"The force {end}. " + (
        f"With this time step the error of ε is {digits(obtained.restitution_error, 2)}."
        if obtained.restitution > 0.0
        else "The bodies do not separate."
    )
    but_for_table = replace(obtained.friction, tangential_restitution=())
    friction = [f"friction: {said}"] if (said := words([but_for_table])) else []
    below = " ".join([below, *map(sentence, [*friction, *obtained.notes])])
    speed = 1.0 if params["speed"] is None else params["speed"]
    title = f"{obtained.code.title} {obtained.model.name} at {digits(speed)} m/s"
    show(console(), title, table(["", "value"], rows), below)
