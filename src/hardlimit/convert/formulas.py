"""The formulas by which particle codes turn a coefficient of restitution into damping, each under a name that the
files in ``codes`` select. None of them is used for our own numbers.

Each gives a damping ratio, as a function of the number that the code is given.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

from .. import _core
from .force import Powers

SMALLEST: Final = 1e-12  #: of the numbers that are tried
CLIPPED: Final = Powers(4, 0)


def given(number: float) -> float:
    """The number itself."""
    return number


def none(number: float) -> float:
    """No damping, whatever the number."""
    return 0.0


def usual(restitution: float) -> float:
    """ζ = −ln ε/√(π² + ln² ε): a linear contact that attracts at its end."""
    logarithm = abs(math.log(restitution))
    return logarithm / math.hypot(math.pi, logarithm)


def tsuji_polynomial(restitution: float) -> float:
    """LAMMPS' fit to Fig. 3 of Tsuji, Tanaka & Ishida, Powder Technology 71, 239 (1992)."""
    return _polynomial(restitution, 1.2728, -4.2783, 11.087, -22.348, 27.467, -18.022, 4.8218)


def thornton(restitution: float) -> float:
    """The fit of Thornton, Cummins & Cleary, Powder Technology 233, 30 (2013), Eq. B7 and Table 2, as YADE has it.

    It stays above 0.0045 up to ε = 1.
    """
    if restitution == 1.0:
        return 0.0
    h = (-6.918798, -16.41105, 146.8049, -796.4559, 2928.711, -7206.864, 11494.29, -11342.18, 6276.757)
    alpha = _polynomial(restitution, 0.0, *h, -1489.915)
    return math.sqrt(1.0 / (1.0 - (1.0 + restitution) ** 2 * math.exp(alpha)) - 1.0)


def thornton_limited(restitution: float) -> float:
    """The same fit as Kratos has it: as at 0.001 below that, and no damping above 0.999."""
    return 0.0 if restitution > 0.999 else thornton(max(restitution, 0.001))


def bisection(restitution: float) -> float:
    """Kratos' solution for a linear force that is never attractive: bisection of [0, 16] down to 1e-4."""
    e = max(restitution, 0.001)
    if e > 0.999:
        return 0.0
    low, high = 0.0, 16.0
    while high - low > 1e-4:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _linear_restitution(middle) > e else (low, middle)
    return 0.5 * (low + high)


def newton(restitution: float) -> float:
    """YADE's solution for a linear force that is never attractive: Newton's method from 0, until ε is within 1 %."""
    ratio, found, small = 0.0, 1.0, 1e-7
    for _ in range(15):
        if abs(found - restitution) <= 1e-2 * restitution:
            break
        above, below = (_linear_restitution(max(ratio + d, 0.0)) for d in (small, -small))
        slope = (above - below) / (small + min(small, ratio))
        ratio -= (found - restitution) / slope
        found = _linear_restitution(ratio)
    return ratio


def _polynomial(x: float, *coefficients: float) -> float:
    value = 0.0
    for coefficient in reversed(coefficients):
        value = value * x + coefficient
    return value


def _linear_restitution(ratio: float) -> float:
    return float(_core.power_collision(*CLIPPED.arguments, 2.0 * ratio)[0])


FORMULAS: Final[dict[str, Callable[[float], float]]] = {
    function.__name__: function
    for function in (given, none, usual, tsuji_polynomial, thornton, thornton_limited, bisection, newton)
}


def inverse(name: str, ratio: float) -> float | None:
    """The number for which the formula gives this ratio, or the nearest that it can; None if it never gives so much.

    A formula of a code may jump: it may give no number the very ratio.
    """
    formula = FORMULAS[name]
    if formula is given:
        return ratio
    if formula is none:
        return 0.0 if ratio == 0.0 else None
    if ratio <= 0.0:
        return 1.0
    low, high = SMALLEST, 1.0
    if formula(low) < ratio:
        return None
    for _ in range(80):
        middle = 0.5 * (low + high) if low > 1e-3 else math.sqrt(low * high)
        low, high = (middle, high) if formula(middle) > ratio else (low, middle)
        if high - low <= 1e-16 * high:
            break
    return min((low, high), key=lambda number: abs(formula(number) - ratio))
