"""Options that several commands share: quantities with units, the column, its law, files to write."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

from ..column import files
from ..column.scenario import Column
from ..contact.contact import Law, law_parameters
from ..contact.laws import LAWS
from ..support import units, validation

F = TypeVar("F", bound=Callable[..., Any])

BALL_OPTIONS = ("radii", "radius_1", "radius_2", "radius_ratio", "densities", "masses")
MOTION_OPTIONS = ("gaps", "velocities", "height", "gravity")


class Quantity(click.ParamType[float]):
    """A number in the SI unit of the option, or one with a unit such as ``1mm``.

    Its range is checked where its meaning is known.
    """

    name = "number"

    def __init__(self, unit: str = "1") -> None:
        self.unit = unit

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        if isinstance(value, float):
            return value
        try:
            return units.number(option_name(param), str(value), self.unit)
        except ValueError as error:
            raise click.UsageError(str(error), ctx) from None


def option_name(param: click.Parameter | None) -> str:
    """The option as it is typed."""
    return param.opts[0] if param is not None else "number"


def options(*made: Callable[[Any], Any]) -> Callable[[F], F]:
    """Several options as one decorator, in the order in which help shows them."""

    def decorate(function: F) -> F:
        for option in reversed(made):
            function = option(function)
        return function

    return decorate


def quantity_option(option: str, *names: str, unit: str, help: str, **more: Any) -> Callable[[F], F]:
    """An option that takes a :class:`Quantity`."""
    return click.option(option, *names, type=Quantity(unit), help=help, **more)


# --- the law ------------------------------------------------------------------------------------------------


def all_law_parameters() -> dict[str, list[tuple[type[Law], dict[str, Any]]]]:
    """Every parameter of a registered law, with the laws that know it."""
    found: dict[str, list[tuple[type[Law], dict[str, Any]]]] = {}
    for law in LAWS.values():
        for name, record in law_parameters(law).items():
            found.setdefault(name, []).append((law, record))
    return found


def law_options(
    kind: Callable[[str], click.ParamType[Any]] = Quantity, law: str = "Law of every contact."
) -> Callable[[F], F]:
    """``--law`` and one option for each parameter of a registered law; ``kind`` makes its type from the unit."""
    made = [click.option("--law", type=click.Choice(list(LAWS)), help=law)]
    for name, uses in all_law_parameters().items():
        record = uses[0][1]
        laws = ", ".join(known.record["name"] for known, _ in uses)
        unit = f" [{record['unit']}]" if record["unit"] != "1" else ""
        meaning = record["meaning"].split(";")[0].split(",")[0]
        made.append(
            click.option(
                f"--{name.replace('_', '-')}",
                name,
                type=kind(record["unit"]),
                help=f"{meaning[0].upper()}{meaning[1:]}{unit} ({laws}).",
            )
        )
    return options(*made)


def given_law_parameters(given: dict[str, Any]) -> dict[str, Any]:
    """Takes the parameters of laws out of the options; those that were given."""
    taken = {name: given.pop(name) for name in all_law_parameters()}
    return {name: value for name, value in taken.items() if value is not None}


# --- the column ---------------------------------------------------------------------------------------------


def column_options(function: F) -> F:
    """The options that describe a column; :func:`column_from` reads them."""
    decorate = options(
        quantity_option(
            "--gap",
            "gaps",
            unit="m",
            multiple=True,
            help="Gap Δh between neighbours [m], of all; or repeated, the lowest first.",
        ),
        quantity_option("--radius-ratio", unit="1", help="R1/R2 of two balls; changes the lower radius."),
        quantity_option("--radius-1", unit="m", help="Radius R1 of the lowest ball [m]."),
        quantity_option("--radius-2", unit="m", help="Radius R2 of the next one [m]."),
        quantity_option(
            "--radius",
            "radii",
            unit="m",
            multiple=True,
            help="Radius [m], repeated for each ball of a column of any number, the lowest first.",
        ),
        quantity_option(
            "--density",
            "densities",
            unit="kg/m3",
            multiple=True,
            help="Density [kg/m³], of all balls; or repeated.",
        ),
        quantity_option(
            "--mass",
            "masses",
            unit="kg",
            multiple=True,
            help="Mass [kg], instead of the density; repeated for each ball.",
        ),
        quantity_option(
            "--height", unit="m", help="Height of the centre of the lowest ball at release, z1(0) [m]."
        ),
        quantity_option(
            "--velocity",
            "velocities",
            unit="m/s",
            multiple=True,
            help="Velocity at release, upwards [m/s], of all balls; or repeated.",
        ),
        quantity_option("--gravity", unit="m/s2", help="Acceleration of gravity g [m/s²]."),
        law_options(),
    )
    return decorate(function)


def column_from(file: str | None, given: dict[str, Any]) -> Column:
    """The column of the file, or that of Fig. 2 without one, changed by the options, which are taken out."""
    base = files.read_with(file)[0] if file else files.of_column(Column.paper())
    law = given.pop("law")
    parameters = given_law_parameters(given)
    if law is not None or parameters:
        base = files.with_law(base, law, parameters)
    base = files.with_balls(base, **{name: given.pop(name) for name in BALL_OPTIONS})
    return files.with_motion(base, **{name: given.pop(name) for name in MOTION_OPTIONS}).column()


# --- files to write -----------------------------------------------------------------------------------------


def output_option(option: str, help: str, metavar: str = "FILE") -> Callable[[F], F]:
    """An option that names a file to write."""
    return click.option(option, metavar=metavar, help=help)


def writable(option: str, path: str | None, *endings: str) -> Path | None:
    """The path, if a file can be written there; checked before anything is computed.

    Raises
    ------
    ValueError
        If its folder does not exist, it cannot be written, or a file has another ending than these.
    """
    if path is None:
        return None
    target = file_name(option, path)
    special = target.exists() and not target.is_file()  # a device is written as it is, a file replaced
    if not special and target.suffix.lower() not in endings:
        raise ValueError(
            f"--{option}: got {validation.shown(path)}, must end in {validation.any_of(endings)}"
        )
    if target.is_dir() or not os.access(target if special else target.parent, os.W_OK):
        raise ValueError(f"--{option}: got {path!r}, must be writable")
    return target


def picture(option: str, path: str | None) -> Path | None:
    """The path, if a picture can be written there.

    Raises
    ------
    ValueError
        As :func:`writable`, with the endings that matplotlib knows.
    """
    if path is None:
        return None
    from ..plots.style import endings

    return writable(option, path, *endings())


def film(option: str, path: str | None) -> Path | None:
    """The path, if a film can be written there.

    Raises
    ------
    ValueError
        As :func:`writable`; if nothing that writes MP4 is installed.
    """
    target = writable(option, path, ".mp4", ".gif")
    if target is not None and target.suffix.lower() == ".mp4":
        from ..plots.video import require_ffmpeg

        require_ffmpeg()
    return target


def dpi_option(function: F) -> F:
    """``--dpi`` of the pictures a command writes; None takes the usual resolution."""
    option = click.option(
        "--dpi",
        type=Quantity(),
        callback=_resolution,
        help="Resolution of the pictures, dots per inch.  [default: 200]",
    )
    return option(function)


def _resolution(ctx: click.Context, param: click.Parameter, value: float | None) -> float | None:
    """Refused before anything is computed."""
    if value is None:
        return None
    from ..plots.style import RESOLUTIONS

    try:
        return validation.number("--dpi", value, *RESOLUTIONS, lowest_allowed=True, highest_allowed=True)
    except ValueError as error:
        raise click.UsageError(str(error), ctx) from None


def file_name(option: str, path: str) -> Path:
    """The path, if the system takes the name and its folder exists.

    Raises
    ------
    ValueError
        If not.
    """
    shown = validation.shown(path)
    target = Path(path)
    try:
        with contextlib.suppress(FileNotFoundError, NotADirectoryError):
            target.stat()
        if target.name and target.parent.is_dir():
            return target
    except (OSError, ValueError) as error:  # too long, or with a null character
        because = error.strerror if isinstance(error, OSError) else "embedded null character"
        raise ValueError(f"--{option}: got {shown}, must be the name of a file: {because}") from None
    if not target.name:
        raise ValueError(f"--{option}: got {shown}, must be the name of a file")
    raise ValueError(f"--{option}: got {shown}, must be in an existing folder")
