"""Stacks of balls that throw the top one highest: their masses under Newton's equations and under collisions."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .column.result import Result
from .column.scenario import Column
from .column.solvers import TOLERANCE, independent, newton
from .contact import compression
from .contact.balls import Ball
from .contact.contact import Law
from .support import validation
from .support.descent import Domain, descend
from .support.progress import Report, reporter

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

MOST_BALLS: Final = 20
MODELS: Final = ("newton", "independent")
#: Shapes of ln(mass) over the number of the ball among which the search begins: bend and slant of its steps.
BENDS: Final = (-0.9, -0.5, 0.0, 0.5, 0.9)
#: Steps of ln(ratio) among which the search begins where the top mass is free.
FIRST_RATIOS: Final = 7
#: Points spread over all masses among which it begins as well, and what spreads them.
SPREAD: Final = 100
PRIMES: Final = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59, 61, 67)
#: Masses between those of the ends, equal to each other, among which it begins as well.
PLATEAUS: Final = 9
MOST_STARTS: Final = 24  #: so many of all these are followed, the best; fewer of more balls
BALLS_STARTED: Final = 160
SEARCHED: Final = 1e-12  #: local error while masses are searched
#: When the top ball is looked at, in units of the time of a contact and the flights between balls.
LATER: Final = 1e4


@dataclass(frozen=True, eq=False)
class Stack:
    """Balls whose masses make the top one as fast as it can be; made by :func:`hardlimit.stack`.

    Notes
    -----
    Collisions one after the other and contacts at once: Eqs. 1–6 and Eq. 14 of the paper.

    Examples
    --------
    >>> law = hl.LinearDashpot(stiffness=1e6, restitution=0.9)
    >>> two = hl.stack(2, law, bottom_mass=0.6)
    >>> two.ratios.round(4), round(two.speed, 3)
    (array([0.5199]), 1.21)
    """

    column: Column  #: on the floor, at the instant of its impact
    model: str  #: ``"newton"`` or ``"independent"``, under which the masses are best
    speed: float  #: of the top ball after the last contact, in units of the speed of impact

    @property
    def masses(self) -> Floats:
        """[kg], bottom first."""
        return np.array([ball.mass for ball in self.column.balls])

    @property
    def ratios(self) -> Floats:
        """Mass of each ball over that of the one below it."""
        return self.masses[1:] / self.masses[:-1]

    def speed_under(self, model: str, gaps: float | Sequence[float] | None = None) -> float:
        """Speed of the top ball over that of the impact, for the same masses under a model and with other gaps.

        NaN where no last contact was found. The lowest ball may come back to the floor before the push has reached the
        top: ``hardlimit.newton(stack.column)`` then ends there, and needs ``until`` to go on.

        Parameters
        ----------
        model : {"newton", "independent"}
        gaps : float or sequence of float [m], optional
            Between neighbours; those of the stack by default.

        Raises
        ------
        ValueError
            If the model or a gap is outside its range.

        Examples
        --------
        >>> law = hl.LinearDashpot(stiffness=1e6, restitution=0.9)
        >>> two = hl.stack(2, law, bottom_mass=0.6)
        >>> [
        ...     round(two.speed_under(model, gaps=0.01), 3)
        ...     for model in ("newton", "independent")
        ... ]
        [1.375, 1.375]
        """
        validation.one_of("model", model, MODELS)
        return _top(self.column if gaps is None else self.column.replace(gaps=gaps), model)

    @property
    def contact_way(self) -> float:
        """Way [m] of a ball at the speed of impact while the lowest one alone touches the floor: V t_c.

        It is the length with which gaps are to be compared.
        """
        speed = self.column.impact_speed
        return speed * float(self.column.contacts[0].duration(speed))

    def over_gaps(self, gaps: ArrayLike) -> xr.Dataset:
        """Speed of the top ball over the gap between neighbours, under both models.

        Parameters
        ----------
        gaps : N numbers [m]
            Each that of all neighbours.

        Returns
        -------
        xarray.Dataset
            ``newton`` and ``independent`` over ``gap``, in units of the speed of impact.

        Raises
        ------
        ValueError
            If a gap is negative or not finite.

        Examples
        --------
        >>> law = hl.LinearDashpot(stiffness=1e6, restitution=0.9)
        >>> two = hl.stack(2, law, bottom_mass=0.6)
        >>> two.over_gaps([0.0, 1e-4, 1e-2]).newton.values.round(3)
        array([1.21 , 1.226, 1.375])
        """
        import xarray as xr

        at = np.atleast_1d(validation.array("gaps", gaps, lowest=0.0, lowest_allowed=True))
        names = {"newton": "Newton's equations", "independent": "independent collisions"}
        found = {
            model: ("gap", [self.speed_under(model, float(g)) for g in at], {"units": "1", "long_name": name})
            for model, name in names.items()
        }
        gap = ("gap", at, {"units": "m", "long_name": "gap between neighbours"})
        attrs = {
            "title": "Speed of the top ball over that of the impact",
            "column": repr(self.column),
            "contact_way": self.contact_way,
        }
        return xr.Dataset(found, coords={"gap": gap}, attrs=attrs)

    def plot(self) -> Figure:
        """Masses, and the speed of the top ball over the gap.

        Returns
        -------
        matplotlib.figure.Figure

        Examples
        --------
        >>> law = hl.LinearDashpot(stiffness=1e6, restitution=0.9)
        >>> two = hl.stack(2, law, bottom_mass=0.6)
        >>> two.plot().savefig("stack.svg")
        """
        from . import plots

        return plots.stack(self)

    def __repr__(self) -> str:
        masses = ", ".join(f"{m:.4g}" for m in self.masses)
        return f"<Stack of {len(self.column.balls)}, best under {self.model}: {masses} kg, top {self.speed:.6g} V>"


def stack(
    n: int,
    law: Law | Sequence[Law],
    *,
    bottom_mass: float,
    top_mass: float | None = None,
    ratio_limits: Sequence[float] = (1e-3, 1.0),
    model: str = "newton",
    gaps: float | Sequence[float] = 0.0,
    density: float | Sequence[float] = 1000.0,
    impact_speed: float = 1.0,
    progress: bool | Report | None = None,
) -> Stack:
    """The masses with which a stack that falls on the floor throws its top ball fastest.

    Parameters
    ----------
    n : int
        Balls, 2 to 20.
    law : Law, or one Law for each contact (floor first)
        Of a linear dashpot only the ratios of the stiffnesses matter where the balls touch.
    bottom_mass : float [kg]
    top_mass : float, optional [kg]
        Without it, it is free as well.
    ratio_limits : two floats
        Smallest and largest mass of a ball over that of the one below it. Collisions with one ε want the smallest that
        is allowed; balls that touch have a best ratio under Newton's equations.
    model : {"newton", "independent"}
        Newton's equations, or collisions one at a time.
    gaps : float or sequence of float [m]
        Between neighbours when the lowest ball touches the floor; 0 lets them touch.
    density : float or sequence of float [kg/m³]
        Of the balls, whose radii follow from their masses; radii matter to Hertz contacts.
    impact_speed : float [m/s]
        V, of all balls; there is no gravity while they are in contact.
    progress : bool or callable(done, total), optional
        True shows a bar. A function is told how many searches are done, and of how many. Ten balls take a second or
        two, twenty under the linear law about ten; under Hertz' law they take several times as long.

    Returns
    -------
    Stack

    Raises
    ------
    ValueError
        If an argument is outside its range, a contact becomes too deep, or the masses do not fit between the ends with
        such ratios; names it.

    Notes
    -----
    Of collisions, v_{k+1} + V = (v_k + V)(1 + ε)/(1 + m_{k+1}/m_k): between fixed ends the masses are in geometric
    progression of ratio r (the sum of ln(1 + e^x) over x = ln m_{k+1}/m_k is convex), and the top ball leaves with
    v/V = (1 + ε)^n/(1 + r)^(n−1) − 1. With r > ε it leaves so slowly that it is hit again; the masses are those for its
    first collision nevertheless. Where ε depends on the speed, and under Newton's equations, the masses are searched,
    by sequential quadratic programming from several starts (SLSQP: Kraft, ACM Trans. Math. Softw. 20, 262 (1994), in
    NLopt); the search ends in masses of which no neighbour is better.

    Examples
    --------
    >>> law = hl.LinearDashpot(stiffness=1e6, restitution=0.9)
    >>> hl.stack(2, law, bottom_mass=0.6)
    <Stack of 2, best under newton: 0.6, 0.3119 kg, top 1.20979 V>
    >>> rigid = hl.stack(3, law, bottom_mass=1.0, top_mass=0.01, model="independent")
    >>> rigid.masses.round(3)  # geometric
    array([1.  , 0.1 , 0.01])
    """
    count = validation.whole("n", n, 2, MOST_BALLS)
    search = _Search(
        count,
        law,
        validation.number("bottom_mass", bottom_mass, 0.0),
        None if top_mass is None else validation.number("top_mass", top_mass, 0.0),
        _limits(ratio_limits),
        validation.one_of("model", model, MODELS),
        gaps,
        validation.numbers("density", density, count, lowest=0.0),
        validation.number("impact_speed", impact_speed, 0.0),
    )
    with reporter(progress, "stack", "searches") as report:
        logarithms = search.best(report)
    column = search.column(logarithms)
    found = _long_after(column, model)
    if found._core.too_deep >= 0:
        raise ValueError(f"law: got {validation.shown(law)}, must be stiffer: {found.outcome}")
    compression.warn(found.largest_compression, stacklevel=3)
    return Stack(column, model, _speed_of_top(found))


def _limits(given: Any) -> tuple[float, float]:
    low, high = validation.numbers("ratio_limits", given, 2, lowest=0.0)
    if not low < high:
        raise ValueError(f"ratio_limits: got {low:g} and {high:g}, must be a smaller and a larger number")
    return low, high


def _long_after(column: Column, model: str, tolerance: float = TOLERANCE) -> Result:
    """The stack long after all that happens; in silence, since the stack that is found has told of its compression.

    A sequence would end when the floor is met again, which may be before the push has come to the top.
    """
    speed = column.impact_speed
    contact = float(column.contacts[0].duration(speed))
    until = LATER * (contact + sum(column.gaps) / speed)
    if model == "independent":
        return independent(column, until)
    with warnings.catch_warnings(action="ignore", category=compression.CompressionWarning):
        return newton(column, until, tolerance=tolerance)


def _speed_of_top(result: Result) -> float:
    """Over that of the impact; NaN where a contact became too deep."""
    return float(result.final_velocities[-1]) / result.column.impact_speed


def _top(column: Column, model: str, tolerance: float = TOLERANCE) -> float:
    return _speed_of_top(_long_after(column, model, tolerance))


class _Search:
    """Search for ln(m_{k+1}/m_k), whose sum a given top mass fixes."""

    def __init__(
        self,
        n: int,
        law: Any,
        bottom: float,
        top: float | None,
        limits: tuple[float, float],
        model: str,
        gaps: Any,
        density: Sequence[float],
        speed: float,
    ) -> None:
        self.n, self.law, self.bottom, self.model = n, law, bottom, model
        self.gaps, self.density, self.speed = gaps, density, speed
        self.lowest, self.highest = (math.log(limit) for limit in limits)
        self.total = None if top is None else math.log(top / bottom)
        middle = 0.5 * (self.lowest + self.highest)
        if self.total is not None:
            least, most = (bottom * limit ** (n - 1) for limit in limits)
            if not least * (1.0 - 1e-9) <= bottom * math.exp(self.total) <= most * (1.0 + 1e-9):
                raise ValueError(
                    f"top_mass: got {top:.6g}, must be in [{validation.at_least(least)}, {validation.at_most(most)}]"
                )
            middle = self.total / (n - 1)
        self.domain = Domain(self.lowest, self.highest, self.total is not None)
        self.column([middle] * (n - 1))  # refuses a law or gaps that fit no column

    def column(self, logarithms: Sequence[float]) -> Column:
        """The stack at the instant when its lowest ball touches the floor."""
        masses = [self.bottom * math.exp(x) for x in accumulate(logarithms, initial=0.0)]
        radii = [
            (0.75 * m / (math.pi * rho)) ** (1.0 / 3.0) for m, rho in zip(masses, self.density, strict=True)
        ]
        balls = [Ball(r, mass=m) for r, m in zip(radii, masses, strict=True)]
        return Column(balls, self.gaps, radii[0], self.law, velocities=-self.speed, gravity=0.0)

    def cost(self, logarithms: Any) -> float:
        """Minus the speed of the top ball."""
        found = _top(self.column(logarithms), self.model, SEARCHED)
        return -found if math.isfinite(found) else 1.0

    def starts(self) -> list[Floats]:
        """The best ones of regular shapes, and as many of points spread over all that is allowed."""
        count = max(4, min(MOST_STARTS, BALLS_STARTED // self.n)) // 2
        shapes = [*self._bent(), *self._plateaus()], self._spread()
        allowed = ([self.domain.nearest(x, self.total) for x in each] for each in shapes)
        return [start for each in allowed for start in sorted(each, key=self.cost)[:count]]

    def _spread(self) -> list[Floats]:
        """Shares of the whole way that are spread evenly: multiples of irrational numbers, modulo 1."""
        steps = self.n - 1
        irrational = np.sqrt(np.array(PRIMES[:steps])) % 1.0
        parts = -np.log(1.0 - np.outer(np.arange(1, SPREAD + 1), irrational) % 1.0)
        shares = parts / parts.sum(axis=1, keepdims=True)
        whole = self.total if self.total is not None else 0.5 * steps * (self.lowest + self.highest)
        return list(whole * shares)

    def _bent(self) -> Iterator[Floats]:
        steps = self.n - 1
        place = np.linspace(-1.0, 1.0, steps) if steps > 1 else np.zeros(1)
        bends = BENDS if steps > 2 else (0.0,)
        for mean in [self.total / steps] if self.total is not None else self._first_means():
            for bend in bends:
                for slant in BENDS if steps > 1 else (0.0,):
                    yield mean * (1.0 + slant * place + bend * (place**2 - np.mean(place**2)))

    def _plateaus(self) -> Iterator[Floats]:
        """Under Newton's equations a row of equal balls carries the push as a pulse."""
        if self.n < 3:
            return
        last = self.total if self.total is not None else self.lowest
        for level in np.linspace(0.0, last, PLATEAUS + 2)[1:-1]:
            steps = np.zeros(self.n - 1)
            steps[0] = level
            if self.total is not None:
                steps[-1] = self.total - level
            yield steps

    def _first_means(self) -> list[float]:
        width = self.highest - self.lowest
        means: list[float] = np.linspace(
            self.lowest + 0.02 * width, self.highest - 0.02 * width, FIRST_RATIOS
        ).tolist()
        return means

    def best(self, report: Report) -> list[float]:
        """ln(m_{k+1}/m_k) of the fastest top ball."""
        steps = self.n - 1
        if self.total is not None and steps == 1:
            return [self.total]
        geometric = [self.lowest if self.total is None else self.total / steps] * steps
        if self.model == "independent" and not self._depends_on_speed(geometric):
            return geometric
        found = []
        starts = self.starts()
        for done, start in enumerate(starts):
            report(done, len(starts))
            found.append(descend(self.cost, start, self.domain))
        best: list[float] = min(found, key=lambda one: one[1])[0].tolist()
        if self.total is not None:
            best[-1] += self.total - math.fsum(best)  # rounding
        return best

    def _depends_on_speed(self, logarithms: Sequence[float]) -> bool:
        speeds = self.speed * np.array([0.5, 1.0, 5.0])
        found = [contact.restitution(speeds) for contact in self.column(logarithms).contacts]
        return bool(np.ptp(np.array(found)) > 1e-12)
