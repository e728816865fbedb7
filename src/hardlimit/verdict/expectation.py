"""Error of event-driven cooling that the law of the error expects for a contact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from ..convert.force import Powers

#: Rules of collision of an event-driven simulation.
RULES: Final = ("constant", "law", "tc", "soft")


@dataclass(frozen=True)
class Expected:
    """Relative error of the rate of cooling, its error bar, and the largest t_c ν with an error of 1 %."""

    error: float | None
    bar: float | None
    largest_tc_nu: float | None


def expected(
    rule: str, dimension: int, packing_fraction: float, restitution: float, powers: Powers, tc_nu: float
) -> Expected:
    """The error under one rule of collision; None where the law of the error says nothing."""
    import math

    x, phi, d = 1 - restitution**2, packing_fraction, dimension
    chi = (1 - phi / 2) / (1 - phi) ** 3
    a = (0.75 - 0.87 * x) / d + (4 / math.pi) / (d * 2**d * phi * chi)
    return Expected(a * tc_nu, 0.1 * abs(a) * tc_nu, 0.01 / abs(a)) if rule == "constant" else Expected(None, None, None)
