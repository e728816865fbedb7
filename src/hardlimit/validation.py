"""Bad input is refused here, once, in one line: parameter, value, accepted range."""

from __future__ import annotations

import math
from collections.abc import Iterable
from numbers import Real
from typing import Any


def describe_range(lowest: float, highest: float, lowest_allowed: bool, highest_allowed: bool) -> str:
    """The accepted range in words, such as ``in (0, 1]`` or ``> 0``."""
    if math.isinf(highest) and not math.isinf(lowest):
        return f"{'>=' if lowest_allowed else '>'} {lowest:g} and finite"
    if math.isinf(lowest) and math.isinf(highest):
        return "finite"
    return f"in {'[' if lowest_allowed else '('}{lowest:g}, {highest:g}{']' if highest_allowed else ')'}"


def shown(value: Any) -> str:
    """A refused value in one line, cut where it is long."""
    try:
        text = repr(value)
    except ValueError:  # a whole number of thousands of digits
        text = f"a {type(value).__name__}"
    text = " ".join(text.split())
    return text if len(text) <= 60 else f"{text[:45]}…{text[-10:]}"


def number(
    name: str,
    value: Any,
    lowest: float = -math.inf,
    highest: float = math.inf,
    *,
    lowest_allowed: bool = False,
    highest_allowed: bool = False,
) -> float:
    """``value`` as a finite float within the range, or a ValueError that names parameter, value and range."""
    accepted = describe_range(lowest, highest, lowest_allowed, highest_allowed)
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ValueError(f"{name}: got {value!r}, must be a number {accepted}")
    x = float(value)
    above = x >= lowest if lowest_allowed else x > lowest
    below = x <= highest if highest_allowed else x < highest
    if not (math.isfinite(x) and above and below):
        raise ValueError(f"{name}: got {x:.16g}, must be {accepted}")
    return x


def numbers(name: str, values: Any, count: int, **limits: Any) -> tuple[float, ...]:
    """A list of ``count`` numbers; a single number stands for all of them."""
    if isinstance(values, Real) and not isinstance(values, bool):
        return (number(name, values, **limits),) * count
    if isinstance(values, str) or not isinstance(values, Iterable):
        raise ValueError(f"{name}: got {values!r}, must be a number or a list of {count}")
    listed = list(values)
    if len(listed) != count:
        raise ValueError(f"{name}: got {len(listed)} values, must be {count}")
    return tuple(number(f"{name}[{i}]", v, **limits) for i, v in enumerate(listed))


def exactly_one(**given: Any) -> str:
    """Name of the one alternative that was given; neither and both are refused."""
    names = [name for name, value in given.items() if value is not None]
    if len(names) != 1:
        count = "neither" if not names else "both" if len(given) == 2 else f"{len(names)}"
        raise ValueError(f"{' | '.join(given)}: got {count}, must be exactly one of them")
    return names[0]
