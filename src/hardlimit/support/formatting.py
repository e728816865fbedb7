"""Numbers and lists as text: significant digits, prefixed units, errors, percentages, sizes, durations."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Final

PREFIXES: Final = (
    *((1e15, "P"), (1e12, "T"), (1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, "")),
    *((1e-3, "m"), (1e-6, "µ"), (1e-9, "n")),
)
#: Smaller percentages are shown as "less than" this.
SMALLEST_PERCENTAGE: Final = 0.001


def digits(value: float, significant: int = 6) -> str:
    """A number with ``significant`` digits; a dash for NaN."""
    if math.isnan(value):
        return "–"
    text = f"{value:.{significant}g}"
    return _with_minus_sign(re.sub(r"e([+-])0*(\d+)$", lambda m: f"e{m[1].replace('+', '')}{m[2]}", text))


def quantity(value: float, unit: str, significant: int = 6) -> str:
    """A number with a prefixed unit, such as ``0.1 mm``; without a prefix if none fits."""
    if value != 0.0 and math.isfinite(value):
        for factor, prefix in PREFIXES:
            if abs(value) >= 0.9999999 * factor:
                rounded = float(f"{value / factor:.{significant}g}")
                return f"{digits(rounded, max(significant, 4))} {prefix}{unit}"  # 750 µs, not 7.5e2 µs
    return f"{digits(value, significant)} {unit}"


def length(metres: float) -> str:
    """A length in a common unit: 60 cm, 1 cm, 0.1 mm, 3 µm."""
    for limit, factor, unit in ((1.0, 1.0, "m"), (5e-3, 1e-2, "cm"), (1e-4, 1e-3, "mm")):
        if abs(metres) >= limit:
            return f"{digits(metres / factor)} {unit}"
    return quantity(metres, "m") if metres else "0"


def size(count: float) -> str:
    """A number of bytes."""
    return quantity(count, "B", 3)


def rate(per_second: float, what: str) -> str:
    """A rate of counted things, such as ``1.2 Mpoints/s``."""
    if per_second < 1.0:
        return f"{digits(per_second, 3)} {what}/s"
    return quantity(per_second, f"{what}/s", 3)


def duration(seconds: float) -> str:
    """A remaining time in whole days, hours, minutes or seconds."""
    if not seconds < 1e9:
        return "decades"
    for name, unit in (("days", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2.0 * unit:
            return f"{seconds / unit:.0f} {name}"
    return f"{seconds:.0f} s" if seconds >= 1.0 else "less than a second"


def listed(names: Sequence[str], last: str = "and") -> str:
    """``a``, ``a and b``, ``a, b and c``; empty without names."""
    *first, end = names or [""]
    return f"{', '.join(first)} {last} {end}" if first else end


# --- percentages and errors ---------------------------------------------------------------------------------


def percent(fraction: float) -> str:
    """A percentage with two digits (three from 100 % on), without exponent up to a million; a dash for NaN."""
    value = 100.0 * fraction
    if math.isnan(value):
        return "–"
    if 0.0 < abs(value) < SMALLEST_PERCENTAGE:
        return f"less than {SMALLEST_PERCENTAGE} %"
    if abs(value) > 1e6:
        return f"{digits(value, 3)} %"
    text = _rounded(value, (2 if abs(value) >= 99.5 else 1) - _exponent(value))
    return f"{text.rstrip('0').rstrip('.') if '.' in text else text} %"


def percent_with_error(fraction: float, error: float) -> str:
    """A percentage and its standard error, ``4.1 ± 0.3 %``.

    The error has one digit, or two if the first is 1. The value has as many decimals, but at most three digits.
    """
    value, error = 100.0 * fraction, 100.0 * error
    if math.isnan(value) or math.isnan(error):
        return percent(fraction)
    if max(abs(value), error) < SMALLEST_PERCENTAGE:
        return f"less than {SMALLEST_PERCENTAGE} %"
    decimals = min(_decimals(error), 2 - _exponent(value) if value else 3, 3)
    unit = 10.0**-decimals
    bar = _rounded(error, decimals) if error >= 0.5 * unit else f"<{_rounded(unit, decimals)}"
    return f"{_rounded(value, decimals)} ± {bar} %"


def at_least_two_digits(count: float) -> str:
    """A whole number rounded up to two digits."""
    unit = 10 ** max(_exponent(count) - 1, 0)
    return f"{math.ceil(count / unit) * unit:d}"


def _exponent(value: float) -> int:
    """Decimal exponent of the first digit."""
    return int(f"{value:e}".split("e")[1])


def _rounded(value: float, decimals: int) -> str:
    """A number rounded to ``decimals``; to tens or hundreds if negative."""
    return _with_minus_sign(f"{round(value, decimals):.{max(decimals, 0)}f}")


def _decimals(error: float) -> int:
    """Number of decimals with which an error is written."""
    if error == 0.0:
        return 3
    extra = 1 if f"{error:.1e}"[0] == "1" else 0
    return extra - int(f"{error:.{extra}e}".split("e")[1])


def _with_minus_sign(text: str) -> str:
    """Replace a leading hyphen by a minus sign, and remove it before a zero."""
    if not text.startswith("-"):
        return text
    return text[1:] if re.fullmatch(r"-[0.]+", text) else f"−{text[1:]}"
