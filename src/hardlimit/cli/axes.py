"""The axes of a sweep, from options and from a job file."""

from __future__ import annotations

import math
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

from ..contact.contact import law_parameters
from ..contact.laws import LAWS
from ..support import units, validation
from ..sweep.parameters import contact_name, geometry
from .options import F, option_name, options

MOST_POINTS = 10**8

EXPECTED = "must be a number, a list a,b,… or start:stop:count[:log]"


class Axis(click.ParamType[Any]):
    """A number, a list ``0.5,0.7,0.9``, or ``start:stop:count`` with ``:log`` for equal factors."""

    name = "axis"

    def __init__(self, unit: str = "1") -> None:
        self.unit = unit

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        try:
            return axis(option_name(param), value, self.unit)
        except ValueError as error:
            raise click.UsageError(str(error), ctx) from None


def axis(name: str, value: Any, unit: str = "1") -> float | NDArray[np.float64]:
    """A number or an array from its text, or as it stands in a TOML file.

    Raises
    ------
    ValueError
        If it is neither a number, nor a list, nor ``start:stop:count`` or ``start:stop:count:log``.
    """
    if isinstance(value, list):
        if not value:
            raise ValueError(f"{name}: got an empty list, must hold at least one number")
        return np.array([_number(f"{name}[{i}]", one, unit) for i, one in enumerate(value)])
    if not isinstance(value, str):
        return _number(name, value, unit)
    if ":" in value:
        return _between(name, value, unit)
    numbers = [_number(name, part, unit) for part in value.split(",")]
    return numbers[0] if len(numbers) == 1 else np.array(numbers)


def _number(name: str, value: float | str, unit: str) -> float:
    return validation.number(name, units.number(name, value, unit) if isinstance(value, str) else value)


def _between(name: str, text: str, unit: str) -> NDArray[np.float64]:
    """``start:stop:count``, and ``:log`` for equal factors."""
    refusal = ValueError(f"{name}: got {validation.shown(text)}, {EXPECTED}")
    start_text, _, rest = text.partition(":")
    stop_text, *others = rest.split(":")
    if len(others) not in (1, 2) or others[1:] not in ([], ["log"], ["lin"]):
        raise refusal
    start, stop = (_number(name, part, unit) for part in (start_text, stop_text))
    try:
        count = int(others[0])
    except ValueError:
        raise refusal from None
    if not 1 <= count <= MOST_POINTS:
        raise ValueError(f"{name}: got {validation.shown(count)} points, must be in [1, {MOST_POINTS:.0e}]")
    if others[1:] == ["log"]:
        if not (start > 0.0 and stop > 0.0):
            shown = validation.shown(text)
            raise ValueError(f"{name}: got {shown}, must have a start and a stop > 0 for equal factors")
        return np.geomspace(start, stop, count)
    if not math.isfinite(stop - start):
        raise ValueError(f"{name}: got {validation.shown(text)}, must span a finite range")
    return np.linspace(start, stop, count)


def units_of(balls: int) -> dict[str, str]:
    """Unit of everything that can be swept of a column of so many balls."""
    found = {name: p.unit for name, p in geometry(balls).items()}
    contacts = ["", *(f"_{contact_name(i)}" for i in range(balls))]
    for law in LAWS.values():
        for name, record in law_parameters(law).items():
            found |= {f"{name}{contact}": record["unit"] for contact in contacts}
    return found


def geometry_options(function: F) -> F:
    """One option for each parameter of the column that can be swept."""
    made = []
    for name, p in geometry(2).items():
        text = f"{p.meaning[0].upper()}{p.meaning[1:]}{'' if p.unit == '1' else f' [{p.unit}]'}."
        made.append(click.option(f"--{name.replace('_', '-')}", name, type=Axis(p.unit), help=text))
    return options(*made)(function)
