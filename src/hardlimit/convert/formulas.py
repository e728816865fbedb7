"""Formulas by which particle codes convert the numbers of their input to stiffness and damping.

The files in ``codes`` select a spring and a formula by name. A spring gives K of F = K ξ^p + … from the numbers of an
input, and the numbers from K. A damping formula gives a damping ratio from a number of the input. None of these
formulas is used for our own contacts.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

from .. import _core
from .force import Powers

# --- springs ------------------------------------------------------------------------------------------------

DEFAULT_POISSON_RATIO: Final = 0.3


@dataclass(frozen=True)
class Where:
    """Quantities on which a spring may depend besides its numbers."""

    mass: float  #: effective mass in the code's formula [kg]
    radius: float  #: effective radius [m]
    speed: float  #: impact speed [m/s]
    number: float | None  #: the number that gives the damping, such as a restitution
    poisson_ratio: float


Numbers = dict[str, float]


@dataclass(frozen=True)
class Spring:
    """One way to specify a stiffness."""

    value: Callable[[Mapping[str, float], Where], float]
    numbers: Callable[[float, Where], Numbers | None]  #: None if no numbers give this stiffness
    damped: bool = False  #: whether it requires damping


def modulus(youngs_modulus: float, poisson_ratio: float) -> float:
    """The effective modulus [Pa] of two bodies of one material: Y/(2 (1 − ν²))."""
    return 0.5 * youngs_modulus / ((1.0 - poisson_ratio) * (1.0 + poisson_ratio))


def impact_stiffness(effective_modulus: float, where: Where) -> float:
    """Stiffness [N/m] of the linear spring that an undamped impact compresses as far as a Hertz contact."""
    hertz = 16.0 / 15.0 * math.sqrt(where.radius) * effective_modulus
    return float(hertz * (where.mass * where.speed**2 / hertz) ** 0.2)


def _of_modulus(effective_modulus: float, where: Where) -> Numbers:
    nu = where.poisson_ratio
    return {"youngs_modulus": 2.0 * (1.0 - nu) * (1.0 + nu) * effective_modulus, "poisson_ratio": nu}


def _modulus_of(numbers: Mapping[str, float], where: Where) -> float:
    return modulus(numbers["youngs_modulus"], numbers["poisson_ratio"])


def _linear_modulus_of(numbers: Mapping[str, float], where: Where) -> float:
    """Y/(2 (1 − ν)), without a square."""
    return 0.5 * numbers["youngs_modulus"] / (1.0 - numbers["poisson_ratio"])


def _impact(numbers: Mapping[str, float], where: Where) -> float:
    moved = Where(where.mass, where.radius, numbers["characteristic_speed"], None, where.poisson_ratio)
    return impact_stiffness(_modulus_of(numbers, where), moved)


def _impact_numbers(stiffness: float, where: Where) -> Numbers:
    energy = where.mass * where.speed**2
    hertz = (stiffness**5 / energy) ** 0.25
    young = _of_modulus(15.0 / 16.0 * hertz / math.sqrt(where.radius), where)
    return {**young, "characteristic_speed": where.speed}


def _decay(where: Where) -> float:
    assert where.number is not None
    return where.mass * (math.pi**2 + math.log(where.number) ** 2)


def _relaxation(stiffness: float, where: Where) -> Numbers | None:
    """τ of K = m/(τζ)²; None without damping."""
    return {"timeconst": math.sqrt(where.mass / stiffness) / where.number} if where.number else None


SPRINGS: Final[dict[str, Spring]] = {
    "stiffness": Spring(lambda n, _: n["stiffness"], lambda value, _: {"stiffness": value}),
    "modulus": Spring(_modulus_of, _of_modulus),
    "linear_modulus": Spring(
        _linear_modulus_of,
        lambda value, where: {
            "youngs_modulus": 2.0 * (1.0 - where.poisson_ratio) * value,
            "poisson_ratio": where.poisson_ratio,
        },
    ),
    "young": Spring(lambda n, _: n["youngs_modulus"], lambda value, _: {"youngs_modulus": value}),
    "impact": Spring(_impact, _impact_numbers),
    "contact_time": Spring(
        lambda n, where: _decay(where) / n["contact_time"] ** 2,
        lambda value, where: {"contact_time": math.sqrt(_decay(where) / value)},
    ),
    "stiffness_by_mass": Spring(
        lambda n, where: n["stiffness"] * where.mass, lambda value, where: {"stiffness": value / where.mass}
    ),
    "relaxation": Spring(
        lambda n, where: where.mass / (n["timeconst"] * n["dampratio"]) ** 2, _relaxation, damped=True
    ),
}


# --- damping ------------------------------------------------------------------------------------------------

SMALLEST: Final = 1e-12  #: smallest number that ``inverse`` tries
CLIPPED: Final = Powers(4, 0)


def given(number: float) -> float:
    """The number itself."""
    return number


def none(number: float) -> float:
    """No damping, whatever the number."""
    return 0.0


def usual(restitution: float) -> float:
    """ζ = −ln ε/√(π² + ln² ε), for a linear contact that attracts at its end."""
    logarithm = abs(math.log(restitution))
    return logarithm / math.hypot(math.pi, logarithm)


def tsuji_polynomial(restitution: float) -> float:
    """LAMMPS' fit to Fig. 3 of Tsuji, Tanaka & Ishida, Powder Technology 71, 239 (1992)."""
    return _polynomial(restitution, 1.2728, -4.2783, 11.087, -22.348, 27.467, -18.022, 4.8218)


def thornton(restitution: float) -> float:
    """The fit of Thornton, Cummins & Cleary, Powder Technology 233, 30 (2013), Eq. B7 and Table 2, as in YADE.

    It is above 0.0045 for all ε < 1.
    """
    if restitution == 1.0:
        return 0.0
    h = (-6.918798, -16.41105, 146.8049, -796.4559, 2928.711, -7206.864, 11494.29, -11342.18, 6276.757)
    alpha = _polynomial(restitution, 0.0, *h, -1489.915)
    return math.sqrt(1.0 / (1.0 - (1.0 + restitution) ** 2 * math.exp(alpha)) - 1.0)


def thornton_limited(restitution: float) -> float:
    """The same fit as in Kratos: constant below 0.001, and no damping above 0.999."""
    return 0.0 if restitution > 0.999 else thornton(max(restitution, 0.001))


def bisection(restitution: float) -> float:
    """Kratos' solution for a linear force that is never attractive: bisection in [0, 16] to 1e-4."""
    e = max(restitution, 0.001)
    if e > 0.999:
        return 0.0
    low, high = 0.0, 16.0
    while high - low > 1e-4:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _linear_restitution(middle) > e else (low, middle)
    return 0.5 * (low + high)


def newton(restitution: float) -> float:
    """YADE's solution for a linear force that is never attractive: Newton's method from 0 until ε is within 1 %."""
    ratio, obtained, small = 0.0, 1.0, 1e-7
    for _ in range(15):
        if abs(obtained - restitution) <= 1e-2 * restitution:
            break
        above, below = (_linear_restitution(max(ratio + d, 0.0)) for d in (small, -small))
        slope = (above - below) / (small + min(small, ratio))
        ratio -= (obtained - restitution) / slope
        obtained = _linear_restitution(ratio)
    return ratio


def _polynomial(x: float, *coefficients: float) -> float:
    value = 0.0
    for coefficient in reversed(coefficients):
        value = value * x + coefficient
    return value


@lru_cache(maxsize=4096)  # searches ask for the same ratios again
def _linear_restitution(ratio: float) -> float:
    return float(_core.power_collision(*CLIPPED.arguments, 2.0 * ratio)[0])


FORMULAS: Final[dict[str, Callable[[float], float]]] = {
    function.__name__: function
    for function in (given, none, usual, tsuji_polynomial, thornton, thornton_limited, bisection, newton)
}


def inverse(name: str, ratio: float) -> float | None:
    """The number for which a formula gives this ratio, or the nearest one; None if all ratios are smaller.

    A formula may jump, so that no number gives exactly this ratio.
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
