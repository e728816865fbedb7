"""Convert text such as ``1 mm`` or ``3.2e9Pa`` to numbers in SI units; a ValueError says what is accepted."""

from __future__ import annotations

import math
import re
from decimal import Decimal
from functools import cache
from typing import TYPE_CHECKING, Any, Final

from . import validation

if TYPE_CHECKING:
    from pint import UnitRegistry

#: Accepted units, in pint's syntax. With decimal factors, ``10 us`` is exactly the number 1e-5. Pint's own list takes
#: 0.3 s to load and has units that make no sense here (logarithmic ones, and ones with an offset).
DEFINITIONS: Final = (
    *("nano- = 1e-9 = n-", "micro- = 1e-6 = µ- = μ- = u-", "milli- = 1e-3 = m-", "centi- = 1e-2 = c-"),
    *("deci- = 1e-1 = d-", "hecto- = 1e2 = h-", "kilo- = 1e3 = k-", "mega- = 1e6 = M-", "giga- = 1e9 = G-"),
    *("meter = [length] = m = metre", "second = [time] = s = sec", "gram = [mass] = g"),
    *("inch = 0.0254 * meter = in", "foot = 0.3048 * meter = ft"),
    *("minute = 60 * second = min", "hour = 3600 * second = h = hr"),
    *("tonne = 1e6 * gram = t", "pound = 453.59237 * gram = lb", "liter = 1e-3 * meter ** 3 = l = L = litre"),
    *("newton = 1e3 * gram * meter / second ** 2 = N", "pascal = newton / meter ** 2 = Pa"),
    *("bar = 1e5 * pascal", "joule = newton * meter = J", "percent = 0.01 = %"),
    *("degree = [angle] = deg", "radian = 57.295779513082323 * degree = rad"),
    *("watt = joule / second = W", "hertz = 1 / second = Hz"),
)

#: The quantity that a unit measures, and an example for messages.
KINDS: Final = {
    "m": ("a length", "1 mm"),
    "kg": ("a mass", "50 g"),
    "s": ("a time", "10 us"),
    "kg/m3": ("a density", "7.8 g/cm^3"),
    "m/s": ("a velocity", "3 cm/s"),
    "m/s2": ("an acceleration", "1.62 m/s^2"),
    "N/m": ("a stiffness", "50 N/mm"),
    "N s/m": ("a damping", "3 N s/m"),
    "Pa": ("a pressure", "210 GPa"),
    "Hz": ("a frequency", "50 Hz"),
    "1/s": ("a rate", "100/s"),
    "rad/s": ("an angular velocity", "10 rad/s"),
    "W": ("a power", "1 mW"),
    "deg": ("an angle", "30 deg"),
    "1": ("without unit", "0.7"),
}

#: Units of mass [kg], length [m] and time [s] in LAMMPS and LIGGGHTS, by the word after ``units``.
SYSTEMS: Final = {
    "si": (1.0, 1.0, 1.0),
    "cgs": (1e-3, 1e-2, 1.0),
    "micro": (1e-15, 1e-6, 1e-6),
    "nano": (1e-21, 1e-9, 1e-9),
}

_NUMBER: Final = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,6})?"
_FACTOR: Final = r"[A-Za-zµμ%]{1,12}(?:(?:\^|\*\*)?-?\d(?:\.\d)?|[²³])?"
_QUANTITY: Final = re.compile(rf"({_NUMBER})\s*(/?{_FACTOR}(?:\s?[ */·]\s?{_FACTOR}){{0,5}})", re.ASCII)
_FRACTION: Final = re.compile(r"(\d{1,9})/0*([1-9]\d{0,8})", re.ASCII)
_POWER: Final = re.compile(r"([A-Za-zµμ%])(?:\^|\*\*)?(-?\d(?:\.\d)?)", re.ASCII)


def quantity(name: str, value: Any, unit: str) -> Any:
    """A number unchanged, or the value of text with a unit, converted to ``unit``."""
    if isinstance(value, str):
        return with_unit(name, value, unit)
    if not validation.is_number(value):
        raise ValueError(f"{name}: got {validation.shown(value)}, must be {_expected(unit)}")
    return value


def number(name: str, text: str, unit: str) -> float:
    """The number in ``text``, which is in ``unit`` unless the text names another one; ``infinite`` is one, too."""
    try:
        return math.inf if text == "infinite" else float(text)
    except ValueError:
        return with_unit(name, text, unit)


def with_unit(name: str, text: str, unit: str) -> float:
    """As :func:`number`, for text that must have a unit. A number without unit may be a fraction, such as 2/7."""
    if unit == "1" and (fraction := _FRACTION.fullmatch(text.strip())):
        return int(fraction[1]) / int(fraction[2])
    match = _QUANTITY.fullmatch(text.strip())
    value = None if match is None else _convert(match[1], match[2], unit)
    if value is None:
        raise ValueError(f"{name}: got {validation.shown(text)}, must be {_expected(unit)}")
    if not math.isfinite(value):
        raise ValueError(f"{name}: got {validation.shown(text)}, must be finite")
    return value


def _expected(unit: str) -> str:
    kind, example = KINDS.get(unit, (f"a quantity in {unit}", f"1 {unit}"))
    if unit == "1":
        return "a number without unit"
    return f"a number [{unit}] or {kind} with its unit, such as '{example}'"


def _convert(digits: str, unit_text: str, wanted: str) -> float | None:
    """The value in the wanted unit; None if the given unit is unknown or measures something else."""
    import pint

    registry = _registry()
    try:
        unit = registry.parse_units(_normal(unit_text))
        value = registry.Quantity(Decimal(digits), unit)
        return float(value.m_as("" if wanted == "1" else _normal(wanted)))
    except (pint.PintError, ArithmeticError, ValueError, AttributeError):
        return None


def _normal(unit: str) -> str:
    """The unit in pint's syntax: ``N s/m3`` as ``N*s/m**3``."""
    plain = unit.replace("²", "2").replace("³", "3").replace("·", "*").replace(" / ", "/").replace(" * ", "*")
    plain = f"1{plain}" if plain.startswith("/") else plain
    return _POWER.sub(r"\1**\2", plain).replace("/ ", "/").replace(" /", "/").replace(" ", "*")


@cache
def _registry() -> UnitRegistry[Any]:
    import pint

    registry: UnitRegistry[Any] = pint.UnitRegistry(None, non_int_type=Decimal)
    for definition in DEFINITIONS:
        registry.define(definition)
    return registry
