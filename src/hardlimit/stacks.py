"""``hl.stack``: find the masses with which a stack of balls throws its top ball fastest, under one of two models."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate, product
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
from .support.progress import Report, reporter

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

MAX_BALLS: Final = 20
MODELS: Final = {"newton": "Newton's equations", "independent": "independent collisions"}
# Candidates of starting points of the search:
SHAPES: Final = (-0.9, -0.5, 0.0, 0.5, 0.9)  #: slopes, and curvatures, of x_k as a function of k
MEANS: Final = 7  #: number of mean values of x_k if the top mass is free
SCATTERED: Final = (
    100  #: number of points spread evenly over the domain by multiples of square roots of primes
)
PRIMES: Final = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59, 61, 67)
PLATEAUS: Final = 9  #: number of masses of a row of equal balls
#: Number of starting points, and largest number of them times balls.
MAX_STARTS: Final = 24
MAX_STARTED_BALLS: Final = 160
SEARCH_TOLERANCE: Final = 1e-12  #: local error of the solver during the search
DIFFERENCE: Final = 1e-6  #: step of the difference quotients
#: End of a run, in units of the contact duration plus the flight times between balls.
END: Final = 1e4


@dataclass(frozen=True, eq=False)
class Stack:
    """Balls with the masses that make the top one fastest; made by :func:`hardlimit.stack`.

    Notes
    -----
    Independent collisions and simultaneous contacts: Eqs. 1–6 and Eq. 14 of the paper.

    Examples
    --------
    >>> law = hl.LinearDashpot(stiffness=1e6, restitution=0.9)
    >>> two = hl.stack(2, law, bottom_mass=0.6)
    >>> two.over_gaps([0.0, 1e-4, 1e-2]).newton.values.round(3)
    array([1.21 , 1.226, 1.375])
    """

    column: Column  #: the stack when its lowest ball touches the floor
    model: str  #: ``"newton"`` or ``"independent"``: the model for which the masses are optimal
    speed: float  #: final speed of the top ball over the impact speed

    @property
    def masses(self) -> Floats:
        """Masses [kg], bottom first."""
        return np.array([ball.mass for ball in self.column.balls])

    @property
    def ratios(self) -> Floats:
        """Mass of each ball over that of the ball below it."""
        return self.masses[1:] / self.masses[:-1]

    def speed_under(self, model: str, gaps: float | Sequence[float] | None = None) -> float:
        """Final speed of the top ball over the impact speed, for the same masses under a model and with other gaps.

        NaN if no last contact was found. The lowest ball may return to the floor before the top one is hit:
        ``hardlimit.newton(stack.column)`` ends there unless it is given ``until``.

        Parameters
        ----------
        model : {"newton", "independent"}
        gaps : float or sequence of float [m], optional
            Gaps between neighbours. Default: those of the stack.

        Raises
        ------
        ValueError
            If the model or a gap is outside its range.
        """
        validation.one_of("model", model, tuple(MODELS))
        column = self.column if gaps is None else self.column.replace(gaps=gaps)
        return _top_speed(_final_state(column, model))

    @property
    def contact_way(self) -> float:
        """V t_c [m]: impact speed times the contact duration of the lowest ball alone on the floor.

        Whether a gap is wide or narrow depends on its ratio to this length.
        """
        speed = self.column.impact_speed
        return speed * float(self.column.contacts[0].duration(speed))

    def over_gaps(self, gaps: ArrayLike) -> xr.Dataset:
        """Final speed of the top ball as a function of the gap between neighbours, under both models.

        Parameters
        ----------
        gaps : N numbers [m]
            Each is the gap between all neighbours.

        Returns
        -------
        xarray.Dataset
            ``newton`` and ``independent`` over ``gap``, in units of the impact speed.

        Raises
        ------
        ValueError
            If a gap is negative or not finite.
        """
        import xarray as xr

        at = np.atleast_1d(validation.array("gaps", gaps, lowest=0.0, lowest_allowed=True))
        speeds = {
            model: ("gap", [self.speed_under(model, float(g)) for g in at], {"units": "1", "long_name": name})
            for model, name in MODELS.items()
        }
        gap = ("gap", at, {"units": "m", "long_name": "gap between neighbours"})
        attrs = {
            "title": "Final speed of the top ball over the impact speed",
            "column": repr(self.column),
            "contact_way": self.contact_way,
        }
        return xr.Dataset(speeds, coords={"gap": gap}, attrs=attrs)

    def plot(self) -> Figure:
        """Plot the masses, and the speed of the top ball as a function of the gap."""
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
    """Find the masses with which a stack of balls, dropped on the floor, throws its top ball fastest.

    Parameters
    ----------
    n : int
        Number of balls, 2 to 20.
    law : Law, or one Law for each contact (floor first)
        For linear dashpots and touching balls only the ratios of the stiffnesses matter.
    bottom_mass : float [kg]
    top_mass : float, optional [kg]
        Optimized as well if not given.
    ratio_limits : two floats
        Smallest and largest mass of a ball over that of the ball below it. For collisions with one ε the smallest
        ratio is the best; for touching balls under Newton's equations there is an optimum.
    model : {"newton", "independent"}
        Newton's equations, or collisions one at a time.
    gaps : float or sequence of float [m]
        Gaps between neighbours when the lowest ball touches the floor; 0 for touching balls.
    density : float or sequence of float [kg/m³]
        Density of the balls. It gives the radii, which matter to Hertzian contacts.
    impact_speed : float [m/s]
        Speed V of all balls at impact. Gravity is neglected from then on.
    progress : bool or callable(done, total), optional
        True shows a bar. A function is called with the number of finished minimizations and their total. Ten balls take
        a second or two, twenty about ten seconds under the linear law and several times that under Hertzian laws.

    Raises
    ------
    ValueError
        If an argument is outside its range, a contact becomes too deep, or no masses within ``ratio_limits`` connect
        bottom and top; names the argument.

    Notes
    -----
    For collisions v_{k+1} + V = (v_k + V)(1 + ε)/(1 + m_{k+1}/m_k). Between given ends the optimal masses are a
    geometric progression of ratio r (the sum of ln(1 + e^x) over x = ln m_{k+1}/m_k is convex), and the top ball leaves
    with v/V = (1 + ε)^n/(1 + r)^(n−1) − 1. If r > ε it is so slow that it is hit again; the masses are then those for
    its first collision. If ε depends on speed, and under Newton's equations, the masses are found by sequential
    quadratic programming from several starting points (SLSQP: Kraft, ACM Trans. Math. Softw. 20, 262 (1994), in SciPy).
    This finds a local optimum.

    Examples
    --------
    >>> law = hl.LinearDashpot(stiffness=1e6, restitution=0.9)
    >>> hl.stack(2, law, bottom_mass=0.6)
    <Stack of 2, best under newton: 0.6, 0.3119 kg, top 1.20979 V>
    >>> rigid = hl.stack(3, law, bottom_mass=1.0, top_mass=0.01, model="independent")
    >>> rigid.masses.round(3)  # geometric
    array([1.  , 0.1 , 0.01])
    """
    count = validation.whole("n", n, 2, MAX_BALLS)
    bottom = validation.number("bottom_mass", bottom_mass, 0.0)
    top = None if top_mass is None else validation.number("top_mass", top_mass, 0.0)
    limits = _limits(ratio_limits)
    validation.one_of("model", model, tuple(MODELS))
    rho = validation.numbers("density", density, count, lowest=0.0)
    speed = validation.number("impact_speed", impact_speed, 0.0)
    total = None if top is None else math.log(top / bottom)
    search = _Search(
        n=count,
        law=law,
        bottom=bottom,
        limits=limits,
        model=model,
        gaps=gaps,
        density=rho,
        speed=speed,
        total=total,
    )
    with reporter(progress, "stack", "searches") as report:
        logarithms = search.best(report)
    column = search.column(logarithms)
    state = _final_state(column, model)
    if state._core.too_deep >= 0:
        raise ValueError(f"law: got {validation.shown(law)}, must be stiffer: {state.outcome}")
    compression.warn(state.largest_compression, stacklevel=3)
    return Stack(column, model, _top_speed(state))


def _limits(limits: Any) -> tuple[float, float]:
    low, high = validation.numbers("ratio_limits", limits, 2, lowest=0.0)
    if not low < high:
        raise ValueError(f"ratio_limits: got {low:g} and {high:g}, must be a smaller and a larger number")
    return low, high


def _final_state(column: Column, model: str, tolerance: float = TOLERANCE) -> Result:
    """The stack long after its last contact, without warnings of deep compression.

    The sequence of a drop ends when the lowest ball meets the floor again, which may be before the top one is hit.
    """
    speed = column.impact_speed
    contact = float(column.contacts[0].duration(speed))
    until = END * (contact + sum(column.gaps) / speed)
    if model == "independent":
        return independent(column, until)
    with warnings.catch_warnings(action="ignore", category=compression.CompressionWarning):
        return newton(column, until, tolerance=tolerance)


def _top_speed(result: Result) -> float:
    """Final speed of the top ball over the impact speed; NaN if a contact became too deep."""
    return float(result.final_velocities[-1]) / result.column.impact_speed


@dataclass(frozen=True)
class _Search:
    """Search for x_k = ln(m_{k+1}/m_k) between two bounds; with a given top mass their sum is fixed."""

    n: int
    law: Any
    bottom: float
    limits: tuple[float, float]  #: of the ratios
    model: str
    gaps: Any
    density: Sequence[float]
    speed: float
    total: float | None  #: sum of all x_k

    def __post_init__(self) -> None:
        if self.total is not None:
            least, most = (self.bottom * limit ** (self.n - 1) for limit in self.limits)
            top = self.bottom * math.exp(self.total)
            if not least * (1.0 - 1e-9) <= top <= most * (1.0 + 1e-9):
                need = f"must be in [{validation.at_least(least)}, {validation.at_most(most)}]"
                raise ValueError(f"top_mass: got {top:.6g}, {need}")
        self.column([self._mean] * (self.n - 1))  # raises if law and gaps do not fit a column

    @cached_property
    def bounds(self) -> tuple[float, float]:
        """Smallest and largest x_k."""
        return math.log(self.limits[0]), math.log(self.limits[1])

    @property
    def _mean(self) -> float:
        return sum(self.bounds) / 2.0 if self.total is None else self.total / (self.n - 1)

    def column(self, logarithms: Sequence[float]) -> Column:
        """The stack when its lowest ball touches the floor."""
        masses = [self.bottom * math.exp(x) for x in accumulate(logarithms, initial=0.0)]
        pairs = zip(masses, self.density, strict=True)
        balls = [Ball((0.75 * m / (math.pi * rho)) ** (1.0 / 3.0), mass=m) for m, rho in pairs]
        return Column(balls, self.gaps, balls[0].radius, self.law, velocities=-self.speed, gravity=0.0)

    def best(self, report: Report) -> list[float]:
        """The x_k with the fastest top ball."""
        steps = self.n - 1
        if self.total is not None and steps == 1:
            return [self.total]
        geometric = [self.bounds[0] if self.total is None else self.total / steps] * steps
        # Where a ball may be heavier than that below it, it may be hit several times.
        if self.model == "independent" and self.limits[1] <= 1.0 and not self._depends_on_speed(geometric):
            return geometric
        minima = []
        starts = self._starts()
        for done, start in enumerate(starts):
            report(done, len(starts))
            minima.append(self._minimize(start))
        best: list[float] = min(minima, key=lambda minimum: minimum[0])[1].tolist()
        if self.total is not None:
            best[-1] += self.total - math.fsum(best)  # rounding
        return best

    def _depends_on_speed(self, logarithms: Sequence[float]) -> bool:
        speeds = self.speed * np.array([0.5, 1.0, 5.0])
        restitutions = [contact.restitution(speeds) for contact in self.column(logarithms).contacts]
        return bool(np.ptp(np.array(restitutions)) > 1e-12)

    def _cost(self, logarithms: Any) -> float:
        """Minus the speed of the top ball."""
        speed = _top_speed(_final_state(self.column(logarithms), self.model, SEARCH_TOLERANCE))
        return -speed if math.isfinite(speed) else 1.0

    def _minimize(self, start: Floats) -> tuple[float, Floats]:
        """Lowest cost found by SLSQP, and its point. The cost may jump, so the last point need not be the lowest."""
        from scipy.optimize import approx_fprime, minimize

        best = self._cost(start), start

        def cost(at: Floats) -> float:
            nonlocal best
            value = self._cost(at)
            if value < best[0]:
                best = value, at.copy()
            return value

        constraint = {"type": "eq", "fun": lambda x: x.sum() - self.total, "jac": np.ones_like}
        minimize(
            cost,
            start,
            method="SLSQP",
            jac=lambda at: approx_fprime(at, self._cost, -DIFFERENCE),
            bounds=[self.bounds] * len(start),
            constraints=[constraint] if self.total is not None else [],
            options={"ftol": 1e-11},
        )
        return best

    # --- starting points ------------------------------------------------------------------------------------

    def _starts(self) -> list[Floats]:
        """The best of the regular candidates, and as many of the scattered ones."""
        count = max(4, min(MAX_STARTS, MAX_STARTED_BALLS // self.n)) // 2
        candidates = [*self._parabolas(), *self._plateaus()], self._scattered()
        allowed = ([self._nearest(x) for x in each] for each in candidates)
        return [start for each in allowed for start in sorted(each, key=self._cost)[:count]]

    def _nearest(self, masses: Floats) -> Floats:
        """A point of the domain: all x_k are shifted equally until their sum is right, but not beyond a bound."""
        if self.total is None:
            return np.clip(masses, *self.bounds)
        from scipy.optimize import brentq

        def moved(shift: float) -> Floats:
            return np.clip(masses + shift, *self.bounds)

        low, high = self.bounds[0] - float(masses.max()), self.bounds[1] - float(masses.min())
        total = min(max(self.total, moved(low).sum()), moved(high).sum())  # rounding
        return moved(brentq(lambda shift: moved(shift).sum() - total, low, high, xtol=1e-15))

    def _scattered(self) -> list[Floats]:
        """Points spread evenly over the domain, from multiples of irrational numbers modulo 1."""
        steps = self.n - 1
        irrational = np.sqrt(np.array(PRIMES[:steps])) % 1.0
        places = np.outer(np.arange(1, SCATTERED + 1), irrational) % 1.0
        low, high = self.bounds
        if high > 0.0:
            return list(low + (high - low) * places)
        parts = -np.log(1.0 - places)
        return list(self._mean * steps * parts / parts.sum(axis=1, keepdims=True))

    def _parabolas(self) -> Iterator[Floats]:
        """Parabolas of x_k over k."""
        steps = self.n - 1
        k = np.linspace(-1.0, 1.0, steps) if steps > 1 else np.zeros(1)
        low, high = self.bounds
        edge = 0.02 * (high - low)
        means = [self._mean] if self.total is not None else np.linspace(low + edge, high - edge, MEANS)
        curvatures, slopes = (SHAPES if steps > least else (0.0,) for least in (2, 1))
        # Where ratios above 1 are allowed, the mean may be 0.
        for mean, curvature, slope in product(means, curvatures, slopes):
            scale = 0.5 * (high - low) if high > 0.0 else mean
            yield mean + scale * (slope * k + curvature * (k**2 - np.mean(k**2)))

    def _plateaus(self) -> Iterator[Floats]:
        """Rows of equal balls between the ends; under Newton's equations the impulse travels along them as a pulse."""
        if self.n < 3:
            return
        last = self.total if self.total is not None else self.bounds[0]
        for level in np.linspace(0.0, last, PLATEAUS + 2)[1:-1]:
            steps = np.zeros(self.n - 1)
            steps[0] = level
            if self.total is not None:
                steps[-1] = self.total - level
            yield steps
