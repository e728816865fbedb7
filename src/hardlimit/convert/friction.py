"""Friction for a wanted tangential restitution: the numbers of a code with which a gas of grains has it.

The tangential restitution of a spring is the β0 of Walton's grains that stand for it in a gas
(``frictional_contact.effective_restitution``).
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np
import scipy

from ..contact import frictional_contact
from ..contact.balls import SOLID_SPHERE
from ..contact.friction import LIMITS, LINEAR, RESCALED, SPRING, FrictionTerms
from ..contact.impact import FrictionalContact
from .codes import Code, Model, TangentialInput, Written
from .force import Force
from .formulas import Numbers
from .tangential import NormalContact, TangentialModel, models_of

#: m_eff/m_t of solid spheres, of which all codes consist.
KAPPA: Final = 1.0 + 1.0 / SOLID_SPHERE
DIMENSION: Final = 3
#: Squared ratios of the contact's duration to the half period of the tangential spring. A stiffer spring would need
#: shorter time steps than the normal force.
STIFFEST: Final = 4.0
SOFTEST: Final = 1e-6
#: A model without a free number has the wanted β0 if it is within this.
NEAR: Final = 5e-4


@dataclass(frozen=True)
class FrictionNumbers:
    """The friction of one contact in a model of a code; returned by :func:`hardlimit.convert`."""

    model: str  #: tangential model of the code; empty if none has this tangential restitution
    numbers: Numbers | None  #: for the input of the code; None if it cannot have this tangential restitution
    tangential_restitution: float  #: β0 that they give a gas; NaN without numbers
    reachable: tuple[tuple[float, float], ...]  #: ranges of β0 over the free numbers of the code
    usual_tangential_restitution: float  #: β0 by the defaults of the code; NaN without defaults


class Walton(NamedTuple):
    """The friction of Walton's grains."""

    coefficient: float  #: μ
    tangential_restitution: float  #: β0


def contact_of(force: Force, terms: FrictionTerms) -> FrictionalContact:
    """A contact of solid spheres with this force and friction."""
    mass = force.effective_mass
    coefficients = force.stiffness, force.damping
    return FrictionalContact(force.powers.arguments, coefficients, mass, mass / KAPPA, terms)


def restitution_of(force: Force, terms: FrictionTerms, speed: float) -> float:
    """β0 of a gas of grains with this force and friction, whose normal speed at impact is ``speed`` [m/s]."""
    return frictional_contact.effective_restitution(contact_of(force, terms), speed, DIMENSION)


# --- one unknown --------------------------------------------------------------------------------------------

#: β0 of a number; NaN where no β0 stands for it.
Curve = Callable[[float], float]


class Solution(NamedTuple):
    """The value of a free number."""

    value: float | None  #: None if no value has the wanted β0
    lowest: float  #: smallest and largest β0 that it can give; NaN if there is none
    highest: float


def solve_ratio(curve: Curve, wanted: float) -> Solution:
    """The squared ratio ρ of the contact's duration to the half period of the tangential spring.

    β0 is −1 without a spring, largest near ρ = 1, and smaller again up to ρ = 4. Of two solutions it is the stiffer
    one, with which sticking contacts turn back; the softer one, if β0 is smaller than at ρ = 4.
    """

    def height(ratio: float) -> float:
        return -math.inf if math.isnan(value := curve(ratio)) else value

    grid = np.geomspace(0.25, STIFFEST, 9).tolist()
    peak = max(range(len(grid)), key=lambda k: height(grid[k]))
    around = grid[max(peak - 1, 0)], grid[min(peak + 1, len(grid) - 1)]
    best = scipy.optimize.minimize_scalar(lambda x: -height(x), bounds=around, options={"xatol": 1e-4})
    top = max(float(best.x), grid[peak], key=height)
    value = _crossing(curve, wanted, [top, *(x for x in grid if x > top)])
    if value is None:
        value = _crossing(curve, wanted, [top, *np.geomspace(top, SOFTEST, 13)[1:].tolist()])
    return Solution(value, -1.0, curve(top))


def solve_range(curve: Curve, wanted: float, lowest: float, highest: float) -> Solution:
    """The value within a range."""
    grid = np.linspace(lowest, highest, 9).tolist()
    values = [value for x in grid if not math.isnan(value := curve(x))]
    ends = (min(values), max(values)) if values else (math.nan, math.nan)
    return Solution(_crossing(curve, wanted, grid), *ends)


def _crossing(curve: Curve, wanted: float, grid: list[float]) -> float | None:
    """The first place along the grid where the curve has the wanted value."""
    for first, second in pairwise(grid):
        left, right = curve(first) - wanted, curve(second) - wanted
        if left == 0.0:
            return first
        if left * right <= 0.0:
            tight = {"xtol": 1e-300, "rtol": 1e-10}
            return float(scipy.optimize.brentq(lambda x: curve(x) - wanted, first, second, **tight))
    return None


# --- the numbers of a code ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class FrictionWay:
    """A contact in a model of a code that gets friction in one way."""

    way: TangentialInput
    model: TangentialModel
    written: Written
    stiffness: float  #: K of the normal force [N/m^p]
    restitution: float
    coefficient: float

    def solution(self, wanted: float) -> Solution:
        """The value of the free number for a β0."""
        if not self.way.free:
            only = self.tangential_restitution(0.0)
            return Solution(0.0 if abs(only - wanted) <= NEAR else None, only, only)
        if self.way.highest > self.way.lowest:
            number = solve_range(self.tangential_restitution, wanted, self.way.lowest, self.way.highest)
            return number._replace(value=None if number.value is None else as_written(number.value))
        unit = ratio_of(*self._force(1.0), self.written.speed)
        ratio = solve_ratio(lambda x: self.tangential_restitution(x / unit), wanted)
        return ratio._replace(value=None if ratio.value is None else as_written(ratio.value / unit))

    def tangential_restitution(self, value: float | None) -> float:
        """β0 with this value of the free number, or with the defaults of the code."""
        return restitution_of(*self._force(value), self.written.speed)

    def numbers(self, value: float | None) -> tuple[Numbers, dict[str, float | None]]:
        """The numbers of the normal and of the tangential model; with None, the defaults of the code."""
        written = self.written
        tangential: dict[str, float | None] = dict.fromkeys(self.model.numbers)
        if value is not None:
            tangential |= self.way.numbers
            if self.way.free == POISSON:
                written = replace(written, poisson_ratio=value)
            elif self.way.free:
                tangential[self.way.free] = value
        if self.way.free == POISSON and "poisson" in tangential:  # YADE's word
            tangential["poisson"] = written.poisson_ratio
        if "friction_angle" in tangential:
            tangential["friction_angle"] = math.atan(self.coefficient)
        else:
            tangential["coefficient"] = self.coefficient
        return self._normal if written is self.written else self._normal_numbers(written), tangential

    @cached_property
    def _normal(self) -> Numbers:
        return self._normal_numbers(self.written)

    def _normal_numbers(self, written: Written) -> Numbers:
        normal = written.numbers(self.stiffness, self.restitution)
        assert normal is not None  # as for the contact without friction
        return normal

    def _force(self, value: float | None) -> tuple[Force, FrictionTerms]:
        normal, tangential = self.numbers(value)
        force = self.written.force(normal)
        return force, self.model.terms(tangential, NormalContact(self.written, normal, force))


def as_written(value: float) -> float:
    """The free number with so few digits that contacts which differ by rounding have the same one."""
    return float(f"{value:.9g}")


#: The free number that belongs to the normal model.
POISSON: Final = "poisson_ratio"


def ratio_of(force: Force, terms: FrictionTerms, speed: float) -> float:
    """The squared ratio of a contact's duration to the half period of its tangential spring.

    The tangential stiffness is in proportion to that of the normal force; without damping the ratio is that of both,
    times m_eff/m_t.
    """
    undamped = replace(force, damping=0.0)
    shorter = force.collision(speed).duration / undamped.collision(speed).duration
    return KAPPA * terms.stiffness / (0.25 * force.powers.elastic * force.stiffness) * shorter**2


class FrictionOfModel(NamedTuple):
    """The friction of contacts in a model of a code."""

    way: TangentialInput | None  #: how the input gets it; None if no way has the wanted β0 in all contacts
    rows: list[FrictionNumbers]
    normal: list[Numbers | None]  #: numbers of the normal model; None if there is no way


def friction_of_model(
    source: Code, model: Model, contacts: Sequence[tuple[Written, float]], restitution: float, walton: Walton
) -> FrictionOfModel:
    """The numbers with which contacts, each with its K [N/m^p], have the wanted friction."""
    forms = models_of(source.name)
    ways = [
        way for name in model.friction for way in source.friction if way.name == name and way.model in forms
    ]
    of_ways = [
        [
            FrictionWay(way, forms[way.model], *contact, restitution, walton.coefficient)
            for contact in contacts
        ]
        for way in ways
    ]
    solutions = [[contact.solution(walton.tangential_restitution) for contact in each] for each in of_ways]
    fitting = [k for k, each in enumerate(solutions) if all(s.value is not None for s in each)]
    best = fitting[0] if fitting else None
    usual = next((each for each in of_ways if each[0].way.usual), None)
    rows, normal = [], []
    for i, _ in enumerate(contacts):
        chosen = None if best is None else (of_ways[best][i], solutions[best][i].value)
        numbers, row = _row([each[i] for each in solutions], chosen, None if usual is None else usual[i])
        normal.append(numbers)
        rows.append(row)
    return FrictionOfModel(None if best is None else ways[best], rows, normal)


def _row(
    solutions: Sequence[Solution], chosen: tuple[FrictionWay, float | None] | None, usual: FrictionWay | None
) -> tuple[Numbers | None, FrictionNumbers]:
    """The numbers of one contact in the normal model, and those of its friction."""
    reachable = merged(sorted((s.lowest, s.highest) for s in solutions if not math.isnan(s.highest)))
    usually = math.nan
    if usual is not None:
        with contextlib.suppress(ValueError):  # the code has no default for this normal model
            usually = usual.tangential_restitution(None)
    if chosen is None:
        return None, FrictionNumbers("", None, math.nan, reachable, usually)
    way, value = chosen
    normal, tangential = way.numbers(value)
    numbers = {name: number for name, number in tangential.items() if number is not None}
    obtained = way.tangential_restitution(value)
    return normal, FrictionNumbers(way.way.model, numbers, obtained, reachable, usually)


def merged(ranges: Sequence[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    """Sorted ranges without overlap."""
    result: list[tuple[float, float]] = []
    for low, high in ranges:
        if result and low <= result[-1][1]:
            result[-1] = result[-1][0], max(high, result[-1][1])
        else:
            result.append((low, high))
    return tuple(result)


# --- our own laws -------------------------------------------------------------------------------------------


def stiffness_ratio(force: Force, speed: float, walton: Walton) -> float:
    """k_t over the stiffness of the normal force under our own law; NaN if no spring has the wanted β0."""
    elastic = force.powers.elastic

    def terms(ratio: float) -> FrictionTerms:
        return FrictionTerms.of_model(
            SPRING if elastic == LINEAR else RESCALED,
            LIMITS[0],
            coefficient=walton.coefficient,
            stiffness=ratio * 0.25 * elastic * force.stiffness,
            stiffness_power=elastic - LINEAR,
        )

    unit = ratio_of(force, terms(1.0), speed)
    solution = solve_ratio(
        lambda x: restitution_of(force, terms(x / unit), speed), walton.tangential_restitution
    )
    return math.nan if solution.value is None else solution.value / unit
