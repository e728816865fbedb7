"""Checks of input. They raise a ValueError in one line with the parameter, its value and the accepted values.

A *number* is an int, a float, a Fraction, a Decimal, a real NumPy scalar, or an array without dimensions that contains
one of these. Bools, text, dates, complex numbers and quantities with a unit are refused although some of them convert
to a float, because that is rarely what the user meant.
"""

from __future__ import annotations

import errno
import math
import operator
import os
import re
from collections.abc import Callable, Sequence
from contextlib import suppress
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from numbers import Real
from pathlib import Path
from typing import Any, Final, TypeVar

import numpy as np
from numpy.typing import NDArray

T = TypeVar("T")

MAX_CHARACTERS: Final = 60  #: of a value in a message
#: Messages name larger bounds of whole numbers, which are technical, only if they are exceeded.
TECHNICAL: Final = 2**31 - 1


def shown(value: Any) -> str:
    """A value for a message: one line of limited length, even if its ``repr`` fails."""
    try:
        text = " ".join(repr(value).split())
    except Exception:  # any class may have a failing repr; ints may have too many digits
        text = f"a {type(value).__name__}"
    return text if len(text) <= MAX_CHARACTERS else f"{text[: MAX_CHARACTERS - 1]}…"


def at_least(bound: float) -> str:
    """A lower bound for a message: six digits, rounded up so that the number shown is accepted."""
    return _rounded(bound, ROUND_CEILING)


def at_most(bound: float) -> str:
    """An upper bound for a message: six digits, rounded down."""
    return _rounded(bound, ROUND_FLOOR)


def _rounded(bound: float, direction: str) -> str:
    return f"{float(Context(prec=6, rounding=direction).create_decimal(repr(bound))):g}"


def describe_range(lowest: float, highest: float, lowest_allowed: bool, highest_allowed: bool) -> str:
    """The accepted range in words, such as ``in (0, 1]`` or ``> 0 and finite``."""
    if math.isinf(lowest) and math.isinf(highest):
        return "finite"
    if math.isinf(highest):
        end = "" if highest_allowed else " and finite"
        return f"{'>=' if lowest_allowed else '>'} {at_least(lowest)}{end}"
    if math.isinf(lowest):
        return f"{'<=' if highest_allowed else '<'} {at_most(highest)} and finite"
    bounds = f"{at_least(lowest)}, {at_most(highest)}"
    return f"in {'[' if lowest_allowed else '('}{bounds}{']' if highest_allowed else ')'}"


# --- numbers ------------------------------------------------------------------------------------------------


def number(
    name: str,
    value: Any,
    lowest: float = -math.inf,
    highest: float = math.inf,
    *,
    lowest_allowed: bool = False,
    highest_allowed: bool = False,
) -> float:
    """``value`` as a finite float within the range."""
    x = value if type(value) is float else _as_float(value)  # floats first: a solver takes microseconds
    if x is not None and math.isfinite(x):
        above = x >= lowest if lowest_allowed else x > lowest
        below = x <= highest if highest_allowed else x < highest
        if above and below:
            return x
    accepted = describe_range(lowest, highest, lowest_allowed, highest_allowed)
    if x is None:
        what = "a number" if accepted == "finite" else f"a number {accepted}"
        raise ValueError(f"{name}: got {shown(value)}, must be {what}")
    text = shown(value) if math.isinf(x) else f"{x:.16g}"
    raise ValueError(f"{name}: got {text}, must be {accepted}")


def whole(name: str, value: Any, lowest: int, highest: int) -> int:
    """``value`` as an int in [lowest, highest]; floats are refused, including 2.0."""
    is_whole = isinstance(value, int | np.integer) and not isinstance(value, bool | np.timedelta64)
    if not is_whole or not lowest <= value <= highest:
        accepted = _describe_whole(value if is_whole else None, lowest, highest)
        raise ValueError(f"{name}: got {shown(value)}, must be a whole number{accepted}")
    return int(value)


def _describe_whole(value: int | None, lowest: int, highest: int) -> str:
    """The end of a message about a whole number, with its range."""
    if value is not None and value > highest >= TECHNICAL:
        return f" <= {at_most(highest)}"
    if value is not None and value < lowest <= -TECHNICAL:
        return f" >= {at_least(lowest)}"
    if highest < TECHNICAL:
        return f" in [{lowest}, {highest}]"
    return f" >= {lowest}" if lowest > -TECHNICAL else ""


def numbers(name: str, values: Any, count: int, **limits: Any) -> tuple[float, ...]:
    """``count`` numbers within the range, from a sequence or a one-dimensional array; a single number is repeated."""
    if _as_float(values) is not None:
        return (number(name, values, **limits),) * count
    listed = _as_list(values)
    if listed is None:
        raise ValueError(f"{name}: got {shown(values)}, must be a number or a list of {count}")
    if len(listed) != count:
        raise ValueError(f"{name}: got {len(listed)} values, must be {count}")
    return tuple(number(f"{name}[{i}]", v, **limits) for i, v in enumerate(listed))


def array(
    name: str,
    values: Any,
    *,
    lowest: float = -math.inf,
    highest: float = math.inf,
    lowest_allowed: bool = False,
    highest_allowed: bool = False,
    ndim: int | None = 1,
    empty_allowed: bool = False,
) -> NDArray[np.float64]:
    """``values`` as a C-contiguous array of finite floats within the range, which may share memory with ``values``.

    Accepts a number, which becomes an array without dimensions, a nested sequence of numbers, and any object that
    converts to a NumPy array of a real type (xarray, pandas, …). ``ndim`` is the largest number of dimensions, None
    means any.
    """
    wanted = f"a number or {'a one-dimensional' if ndim == 1 else 'an'} array of numbers"
    converted = as_array(values)
    if converted is None:
        raise ValueError(f"{name}: got {shown(values)}, must be {wanted}")
    if ndim is not None and converted.ndim > ndim:
        raise ValueError(f"{name}: got {converted.ndim} dimensions, must be {wanted}")
    if converted.size == 0 and not empty_allowed:
        raise ValueError(f"{name}: got an empty array, must hold at least one value")
    above = converted >= lowest if lowest_allowed else converted > lowest
    below = converted <= highest if highest_allowed else converted < highest
    good = np.isfinite(converted) & above & below
    if not good.all():
        accepted = describe_range(lowest, highest, lowest_allowed, highest_allowed)
        raise ValueError(f"{name}: got {converted[~good].flat[0]:.16g}, must be {accepted}")
    return converted


def each(name: str, values: Any, count: int, **limits: Any) -> NDArray[np.float64]:
    """``count`` numbers within the range as a read-only array; a single number is broadcast, not copied."""
    if _as_float(values) is not None:
        return np.broadcast_to(np.float64(number(name, values, **limits)), count)
    converted = as_array(values)
    if converted is None or converted.ndim != 1:
        raise ValueError(f"{name}: got {shown(values)}, must be a number or {count} numbers")
    if len(converted) != count:
        raise ValueError(f"{name}: got {len(converted)} values, must be {count}")
    try:
        array(name, converted, empty_allowed=True, **limits)
    except ValueError:
        for i, value in enumerate(converted):  # raises at the first bad value, with its index
            number(f"{name}[{i}]", value, **limits)
        raise
    return _read_only(converted, values)


def rows(name: str, values: Any, widths: Sequence[int]) -> NDArray[np.float64]:
    """Finite numbers in one or more rows of one of these widths, as a read-only array."""
    shapes = " or ".join(f"(N, {width})" for width in widths)
    converted = as_array(values)
    if converted is None:
        raise ValueError(f"{name}: got {shown(values)}, must be numbers of shape {shapes}")
    if converted.ndim != 2 or converted.shape[1] not in widths or len(converted) == 0:
        raise ValueError(f"{name}: got shape {converted.shape}, must be {shapes} with N >= 1")
    good = np.isfinite(converted)
    if not good.all():
        bad = int(np.argmin(good.all(axis=1)))
        raise ValueError(f"{name}[{bad}]: got {converted[bad].tolist()}, must be finite")
    return _read_only(converted, values)


def _read_only(converted: NDArray[np.float64], original: Any) -> NDArray[np.float64]:
    """The array, read-only, and copied if ``given`` shares its memory."""
    kept = converted.copy() if hasattr(original, "__array__") else converted
    kept.flags.writeable = False
    return kept


def is_number(value: Any) -> bool:
    """Whether :func:`number` accepts the value if it is within the range."""
    return _as_float(value) is not None


def _as_float(value: Any) -> float | None:
    """A number as a float, infinite if it is too large; None if it is not a number."""
    if isinstance(value, bool | np.timedelta64):  # both are ints to Python or NumPy
        return None
    if isinstance(value, Real | Decimal):
        try:
            return float(value)
        except OverflowError:
            return -math.inf if operator.lt(value, 0) else math.inf
        except Exception:  # a signalling NaN, or a class with a failing conversion
            return None
    if hasattr(value, "__array__"):
        converted = _converted(value)
        return float(converted) if converted is not None and converted.ndim == 0 else None
    return None


def as_array(values: Any, deepest: int = 32) -> NDArray[np.float64] | None:
    """Numbers as a C-contiguous array of floats; None if one is not a number or rows differ in length."""
    if hasattr(values, "__array__"):
        return _converted(values)
    single = _as_float(values)
    if single is not None:
        return np.array(single)
    if not _is_list(values) or deepest == 0:  # a list may contain itself
        return None
    if {float, int}.issuperset(map(type, values)):  # the common case, fast
        with suppress(OverflowError):
            return np.array(values, dtype=np.float64)
    rows: list[NDArray[np.float64]] = []
    for value in values:
        row = as_array(value, deepest - 1)
        if row is None or row.shape != (rows[0] if rows else row).shape:
            return None
        rows.append(row)
    return np.array(rows)


def _converted(value: Any) -> NDArray[np.float64] | None:
    """An array, or an object that converts to one, as floats; None if its entries are not real numbers."""
    if hasattr(type(value), "unit") or hasattr(type(value), "units"):  # the conversion would drop the unit
        return None
    try:
        converted = np.ma.asarray(value) if np.ma.isMaskedArray(value) else np.asarray(value)
    except Exception:  # the conversion of any class may raise anything
        return None
    if converted.dtype.kind not in "iuf" or np.ma.is_masked(converted):
        return None
    with np.errstate(over="ignore"):  # a long double beyond the range of a double becomes infinity
        return np.asarray(converted, dtype=np.float64, order="C")


def _as_list(values: Any) -> list[Any] | None:
    """The entries of a sequence or a one-dimensional array of numbers; None if it is neither."""
    if hasattr(values, "__array__"):
        converted = _converted(values)
        return converted.tolist() if converted is not None and converted.ndim == 1 else None
    return list(values) if _is_list(values) else None


def _is_list(values: Any) -> bool:
    return isinstance(values, Sequence) and not isinstance(values, str | bytes | bytearray | memoryview)


# --- everything else ----------------------------------------------------------------------------------------


def one_of(name: str, value: Any, choices: Sequence[str]) -> str:
    """``value``, if it is one of the choices."""
    if not isinstance(value, str) or value not in choices:
        raise ValueError(f"{name}: got {shown(value)}, must be one of {', '.join(choices)}")
    return str(value)


def path(name: str, value: Any) -> Path:
    """``value`` as a path.

    Raises
    ------
    ValueError
        If it is neither a text nor a path, or has a control character such as a line break.
    """
    text = os.fspath(value) if isinstance(value, str | os.PathLike) else None
    if not isinstance(text, str):
        raise ValueError(f"{name}: got {shown(value)}, must be a path")
    if re.search(r"[\x00-\x1f\x7f]", text):
        raise ValueError(f"{name}: got {shown(text)}, must be a path without control characters")
    return Path(text)


def unreadable(file: Any, error: OSError, parameter: str = "") -> OSError | ValueError:
    """The error of one line for a file that cannot be read: a FileNotFoundError if there is none."""
    subject = f"{parameter}: {file}" if parameter else file
    if not isinstance(error, FileNotFoundError | NotADirectoryError):
        return ValueError(f"{subject}: cannot be read: {error.strerror or error}")
    missing = FileNotFoundError(f"{subject}: no such file")
    missing.errno = errno.ENOENT
    return missing


def flag(name: str, value: Any) -> bool:
    """``value``, if it is True or False; 1 and "yes" are refused."""
    if not isinstance(value, bool):
        raise ValueError(f"{name}: got {shown(value)}, must be True or False")
    return value


def instances(name: str, values: Any, kind: type[T], what: str) -> tuple[T, ...]:
    """The members of a sequence, which must be instances of ``kind``; ``what`` is its name in messages."""
    if not _is_list(values):
        raise ValueError(f"{name}: got {shown(values)}, must be a list of {what}")
    for i, member in enumerate(values):
        if not isinstance(member, kind):
            raise ValueError(f"{name}[{i}]: got {shown(member)}, must be a {what}")
    return tuple(values)


def sealed(instead: str) -> Callable[[type[T]], type[T]]:
    """A decorator of a class whose values the core and files read: they would ignore the methods of a subclass.

    The definition of a subclass raises a TypeError that says what to do ``instead``.
    """

    def refuse(cls: type[Any], /, **keywords: Any) -> None:
        raise TypeError(
            f"{cls.__name__}: got a subclass of {cls.__mro__[1].__name__}, whose methods are ignored; {instead}"
        )

    def decorate(base: type[T]) -> type[T]:
        base.__init_subclass__ = classmethod(refuse)  # type: ignore[assignment]
        return base

    return decorate


def exactly_one(**values: Any) -> str:
    """The name of the only alternative that is given (not None)."""
    names = [name for name, value in values.items() if value is not None]
    if len(names) != 1:
        got = " and ".join(names) or "none"
        if len(values) == 2:
            got = "both" if names else "neither"
        raise ValueError(f"{' | '.join(values)}: got {got}, must be exactly one of them")
    return names[0]
