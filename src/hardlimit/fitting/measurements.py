"""Measurements: impacts of one ball (speed and coefficient of restitution), or drops of a column.

Heights and flight times are converted to speeds and coefficients of restitution by free fall. One reading then enters
several impacts, so that their errors are correlated; the covariance is propagated to first order.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Final

import numpy as np
from numpy.polynomial import Chebyshev
from numpy.typing import NDArray

from ..column.scenario import STANDARD_GRAVITY, Column
from ..column.solvers import independent, newton
from ..contact.contact import Law, Values
from ..support import validation
from .candidates import Candidate

Floats = NDArray[np.float64]

#: Largest relative error that is propagated to first order.
LARGEST_ERROR: Final = 0.3
#: Number of standard errors by which a value may exceed its limit.
MAX_DEVIATION: Final = 5.0
#: Limits of a standard error, for ``validation``.
ERRORS: Final[dict[str, Any]] = {"lowest": 0.0, "lowest_allowed": True}
#: Observables of a column in an experiment: description and unit.
OBSERVED: Final = {
    "separation_velocity": ("separation velocity of two balls", "m/s"),
    "top_velocity": ("velocity of the top ball after the last contact", "m/s"),
    "top_height": ("greatest height of the centre of the top ball", "m"),
}
#: Deviation, in standard errors, of a drop whose balls never separate under the law.
HOPELESS: Final = 1e4


@dataclass(frozen=True, eq=False)
class Block:
    """The impacts of one drop, whose errors are correlated (``chained``), or impacts with independent errors.

    The readings y of the instruments have errors σ. ``d_speed`` and ``d_restitution`` are derivatives with respect to
    y, of shape (n, m) for the m readings of a chain, and otherwise of shape (n, q) for q readings per impact.
    """

    speed: Floats  #: impact speeds [m/s]
    restitution: Floats
    d_speed: Floats
    d_restitution: Floats
    sigma: Floats  #: errors of the readings, (m,) for a chain, (n, q) otherwise
    chained: bool


class Measured:
    """Measurements; made by the class methods of :class:`Impacts` and :class:`Rebounds`."""

    what: ClassVar[str]  #: what was measured
    kind: ClassVar[str]  #: "impacts" or "rebounds"

    @property
    def n(self) -> int:
        """Number of values."""
        raise NotImplementedError

    @property
    def has_errors(self) -> bool:
        """Whether each value has an error."""
        raise NotImplementedError

    @property
    def reference_speed(self) -> float:
        """A typical impact speed [m/s] of the data."""
        raise NotImplementedError

    def deviations(self, candidate: Candidate, law: Law, scatter: float) -> tuple[Floats, float]:
        """Deviations from the law, decorrelated and in standard errors, and ln det of their covariance.

        :meta private:
        """
        raise NotImplementedError

    def spread(self) -> float:
        """First guess of the scatter of the values.

        :meta private:
        """
        raise NotImplementedError


@dataclass(frozen=True, eq=False)
class Impacts(Measured):
    """Impacts of one ball on a floor or on another ball; made by its class methods.

    Notes
    -----
    Heights, times and speeds are related by free fall without air drag: Bernstein, Am. J. Phys. 45, 41 (1977). Errors
    are propagated to first order, with the covariances of values that share a reading.

    Examples
    --------
    >>> heard = hl.Impacts.of_times([[0.0, 0.5, 0.9, 1.22]], time_error=0.001)
    >>> heard.restitution.round(3)
    array([0.8, 0.8])
    """

    kind: ClassVar[str] = "impacts"  #: kind of data
    what: ClassVar[str] = "ε over the speed of impact"  #: what was measured

    blocks: tuple[Block, ...]  #: impacts with correlated errors
    origin: str  #: the quantity that the instruments measured

    @classmethod
    def of_restitution(
        cls,
        speed: Values,
        restitution: Values,
        restitution_error: float | Values = 0.0,
        speed_error: float | Values = 0.0,
    ) -> Impacts:
        """Coefficients of restitution ε measured at given impact speeds.

        Parameters
        ----------
        speed : N numbers [m/s]
        restitution : N numbers
            In (0, 1], or above by at most five errors.
        restitution_error, speed_error : number or N numbers
            Standard errors, that of ε at most 1. Without errors of ε its scatter must be fitted
            (``fit(…, scatter=True)``).

        Raises
        ------
        ValueError
            If a value is outside its range, or the lengths differ; names the position.
        """
        count = _count("speed", speed)
        v = validation.each("speed", speed, count, lowest=0.0)
        e = validation.each("restitution", restitution, count, lowest=0.0)
        limits = ERRORS | {"highest": 1.0, "highest_allowed": True}
        of_restitution = validation.each("restitution_error", restitution_error, count, **limits)
        of_speed = validation.each("speed_error", speed_error, count, **ERRORS)
        _refuse_coarse("speed_error", of_speed, v)
        for i in np.flatnonzero(e > 1.0 + MAX_DEVIATION * of_restitution):
            need = f"must be in (0, 1], or above by at most {MAX_DEVIATION:g} errors"
            raise ValueError(f"restitution[{i}]: got {e[i]:.6g}, {need}")
        d_speed, d_restitution = np.tile([0.0, 1.0], (count, 1)), np.tile([1.0, 0.0], (count, 1))
        sigma = np.column_stack([of_restitution, of_speed])
        return cls((Block(v, e, d_speed, d_restitution, sigma, False),), "ε and speed of each impact")

    @classmethod
    def of_rebound_heights(
        cls,
        drop_height: Values,
        rebound_height: Values,
        rebound_height_error: float | Values = 0.0,
        drop_height_error: float | Values = 0.0,
        gravity: float = STANDARD_GRAVITY,
    ) -> Impacts:
        """Single bounces: drop and rebound height of the lowest point of the ball; ε = √(h'/h), v = √(2 g h).

        Parameters
        ----------
        drop_height : N numbers [m]
            Height at release.
        rebound_height : N numbers [m]
            Maximum height after the impact; above the drop height by at most five errors.
        rebound_height_error, drop_height_error : number or N numbers [m]
            Standard errors.
        gravity : float [m/s²]

        Raises
        ------
        ValueError
            If a value is outside its range, or the lengths differ; names the position.
        """
        count = _count("drop_height", drop_height)
        g = validation.number("gravity", gravity, 0.0)
        before = validation.each("drop_height", drop_height, count, lowest=0.0)
        after = validation.each("rebound_height", rebound_height, count, lowest=0.0)
        of_drop = validation.each("drop_height_error", drop_height_error, count, **ERRORS)
        of_rebound = validation.each("rebound_height_error", rebound_height_error, count, **ERRORS)
        _refuse_coarse("drop_height_error", of_drop, before)
        _refuse_coarse("rebound_height_error", of_rebound, after)
        _refuse_higher("rebound_height", before, after, np.hypot(of_drop, of_rebound), 0)
        v, e = np.sqrt(2.0 * g * before), np.sqrt(after / before)
        d_speed = np.column_stack([v / (2.0 * before), np.zeros(count)])
        d_restitution = np.column_stack([-e / (2.0 * before), e / (2.0 * after)])
        sigma = np.column_stack([of_drop, of_rebound])
        return cls((Block(v, e, d_speed, d_restitution, sigma, False),), "drop and rebound heights")

    @classmethod
    def of_heights(
        cls,
        heights: Sequence[Values],
        height_error: float | Sequence[Any] = 0.0,
        gravity: float = STANDARD_GRAVITY,
    ) -> Impacts:
        """Peak heights of a ball that bounces repeatedly.

        Parameters
        ----------
        heights : sequence of sequences [m]
            For each drop, heights of the lowest point of the ball, the release first; none above the one before by more
            than five errors.
        height_error : number, or sequence of the shape of ``heights`` [m]
        gravity : float [m/s²]

        Raises
        ------
        ValueError
            If a value is outside its range, or a drop has fewer than two heights; names the position.
        """
        g = validation.number("gravity", gravity, 0.0)
        drops = _drops("heights", heights, 2, lowest=0.0)
        errors = _errors("height_error", height_error, drops)
        for i, (sigma, height) in enumerate(zip(errors, drops, strict=True)):
            _refuse_coarse(f"height_error[{i}]", sigma, height)
            _refuse_higher(f"heights[{i}]", height[:-1], height[1:], np.hypot(sigma[:-1], sigma[1:]), 1)
        blocks = tuple(_from_heights(h, s, g) for h, s in zip(drops, errors, strict=True))
        return cls(blocks, "heights of the bounces")

    @classmethod
    def of_times(
        cls,
        times: Sequence[Values],
        time_error: float | Sequence[Any] = 0.0,
        gravity: float = STANDARD_GRAVITY,
    ) -> Impacts:
        """Times of the impacts of a ball that bounces repeatedly, as recorded by a microphone.

        A flight of duration T begins and ends with the speed g T/2, so that ε = T'/T for consecutive flights. The
        contact durations, which T includes, are neglected.

        Parameters
        ----------
        times : sequence of sequences [s]
            For each drop, the times of three or more consecutive impacts; no flight longer than the one before by more
            than five errors.
        time_error : number, or sequence of the shape of ``times`` [s]
        gravity : float [m/s²]

        Raises
        ------
        ValueError
            If the times of a drop do not increase, are fewer than three, or miss a bounce; names the position.
        """
        g = validation.number("gravity", gravity, 0.0)
        drops = _drops("times", times, 3)
        errors = _errors("time_error", time_error, drops)
        blocks = []
        for i, (t, sigma) in enumerate(zip(drops, errors, strict=True)):
            _refuse_gaps(f"times[{i}]", t, sigma)
            _refuse_coarse(f"time_error[{i}]", sigma[1:], np.diff(t))
            blocks.append(_from_times(t, sigma, g))
        return cls(tuple(blocks), "instants of the impacts")

    def __repr__(self) -> str:
        slowest, fastest = self.speeds
        return f"<Impacts: {self.n} from {slowest:.4g} to {fastest:.4g} m/s>"

    @property
    def speed(self) -> Floats:
        """Impact speeds (N,) [m/s]."""
        return np.concatenate([block.speed for block in self.blocks])

    @cached_property
    def speeds(self) -> tuple[float, float]:
        """Smallest and largest impact speed [m/s]."""
        return float(self.speed.min()), float(self.speed.max())

    @property
    def restitution(self) -> Floats:
        """Coefficients of restitution (N,)."""
        return np.concatenate([block.restitution for block in self.blocks])

    @property
    def restitution_error(self) -> Floats:
        """Standard errors of ε (N,), for plots; fits use the covariances."""
        errors = [np.linalg.norm(b.d_restitution * b.sigma, axis=1) for b in self.blocks]
        return np.concatenate(errors)

    @property
    def n(self) -> int:
        return sum(block.speed.size for block in self.blocks)

    @property
    def has_errors(self) -> bool:
        # The impacts of a chain share their measured values: as many of these must have errors.
        enough = all(
            np.count_nonzero(block.sigma) >= block.speed.size for block in self.blocks if block.chained
        )
        return enough and bool((self.restitution_error > 0.0).all())

    @property
    def reference_speed(self) -> float:
        return float(f"{math.exp(float(np.log(self.speed).mean())):.2g}")

    def spread(self) -> float:
        return max(float(self.restitution.std()), 1e-4)

    def deviations(self, candidate: Candidate, law: Law, scatter: float) -> tuple[Floats, float]:
        curve = candidate.curve(law, *self.speeds)
        parts = [_block_deviations(block, curve, scatter) for block in self.blocks]
        return np.concatenate([white for white, _ in parts]), sum(logarithm for _, logarithm in parts)


def _block_deviations(block: Block, curve: Chebyshev, scatter: float) -> tuple[Floats, float]:
    v = block.speed
    deviation = block.restitution - curve(np.log(v))
    slope = curve.deriv()(np.log(v)) / v
    jacobian = (block.d_restitution - slope[:, None] * block.d_speed) * block.sigma
    if not block.chained:
        variance = (jacobian**2).sum(axis=1) + scatter**2
        return deviation / np.sqrt(variance), float(np.log(variance).sum())
    covariance = jacobian @ jacobian.T
    covariance[np.diag_indices(v.size)] += scatter**2
    lower = np.linalg.cholesky(covariance)
    return np.linalg.solve(lower, deviation), 2.0 * float(np.log(np.diag(lower)).sum())


@dataclass(frozen=True, eq=False)
class Rebounds(Measured):
    """Drops of a column, with one measured value each; made by :meth:`of_column`."""

    kind: ClassVar[str] = "rebounds"  #: kind of data
    what: ClassVar[str] = "rebounds of a column"  #: what was measured

    columns: tuple[Column, ...]  #: the columns; a fit replaces their law
    observable: str  #: a key of ``OBSERVED``
    values: Floats  #: measured values (N,) [m/s] or [m]
    error: Floats  #: standard errors (N,)
    varied: dict[str, Floats]  #: gap or height of each drop

    @classmethod
    def of_column(
        cls,
        column: Column,
        observable: str,
        values: Values,
        error: float | Values = 0.0,
        *,
        gap: Values | None = None,
        height: Values | None = None,
    ) -> Rebounds:
        """Drops of a column of two or more balls, with one measured value each.

        Parameters
        ----------
        column : Column
            Balls, gaps and height; a fit replaces its law.
        observable : {"separation_velocity", "top_velocity", "top_height"}
            ``Result.separation_velocity``, or the last value of ``Result.final_velocities`` or
            ``Result.rebound_heights``.
        values : N numbers [m/s] or [m]
        error : number or N numbers
            Standard errors.
        gap, height : N numbers [m], optional
            For each drop, if different from the column; the gap between all neighbours.

        Raises
        ------
        ValueError
            If a value is outside its range, or the lengths differ; names the position.
        """
        if not isinstance(column, Column) or not column.floor or len(column.balls) < 2:
            need = "must be a Column of two or more balls above a floor"
            raise ValueError(f"column: got {validation.shown(column)}, {need}")
        validation.one_of("observable", observable, tuple(OBSERVED))
        if observable == "separation_velocity" and len(column.balls) != 2:
            need = "must be top_velocity or top_height for more than two balls"
            raise ValueError(f"observable: got 'separation_velocity', {need}")
        count = _count("values", values)
        measured = validation.each("values", values, count)
        sigma = validation.each("error", error, count, **ERRORS)
        axes = {"gap": gap, "height": height}
        varied = {name: validation.each(name, v, count) for name, v in axes.items() if v is not None}
        columns = []
        for i in range(count):
            changes = {("gaps" if k == "gap" else k): float(v[i]) for k, v in varied.items()}
            try:
                columns.append(column.replace(**changes))  # type: ignore[arg-type]
            except ValueError as error_of_row:
                raise ValueError(f"column[{i}]: {error_of_row}") from None
        return cls(tuple(columns), observable, measured, sigma, varied)

    def __repr__(self) -> str:
        return f"<Rebounds: {self.n} of {OBSERVED[self.observable][0]}>"

    @property
    def n(self) -> int:
        return self.values.size

    @property
    def has_errors(self) -> bool:
        return bool((self.error > 0.0).all())

    @property
    def reference_speed(self) -> float:
        return float(f"{np.mean([column.impact_speed for column in self.columns]):.2g}")

    def spread(self) -> float:
        return max(float(self.values.std()), 1e-4 * float(np.abs(self.values).max()), 1e-300)

    def deviations(self, candidate: Candidate, law: Law, scatter: float) -> tuple[Floats, float]:
        variance = self.error**2 + scatter**2
        predicted = self.predicted(candidate, law)
        deviation = (self.values - predicted) / np.sqrt(variance)
        white = np.where(np.isfinite(predicted), deviation, HOPELESS * self.n)
        return white, float(np.log(variance).sum())

    def predicted(self, candidate: Candidate, law: Law) -> Floats:
        """Prediction of the law for each drop; NaN if the balls do not separate.

        :meta private:
        """
        solve = newton if candidate.model == "newton" else independent
        return np.array([_observed(solve(c.replace(law=law)), self.observable) for c in self.columns])


def _observed(result: Any, observable: str) -> float:
    if observable == "separation_velocity":
        return float(result.separation_velocity)
    values = result.final_velocities if observable == "top_velocity" else result.rebound_heights
    return float(values[-1])


def _banded(sigma: Floats, *bands: Floats) -> Floats:
    """The matrix with these bands, the main diagonal first; one column for each reading."""
    matrix = np.zeros((bands[0].size, sigma.size))
    for k, band in enumerate(bands):
        matrix += band[:, None] * np.eye(*matrix.shape, k)
    return matrix


def _from_heights(h: Floats, sigma: Floats, g: float) -> Block:
    before, after = h[:-1], h[1:]
    v, e = np.sqrt(2.0 * g * before), np.sqrt(after / before)
    d_restitution = _banded(sigma, -e / (2.0 * before), e / (2.0 * after))
    return Block(v, e, _banded(sigma, v / (2.0 * before)), d_restitution, sigma, True)


def _from_times(t: Floats, sigma: Floats, g: float) -> Block:
    flight = np.diff(t)
    before, after = flight[:-1], flight[1:]
    v, e = 0.5 * g * before, after / before
    slope = np.full(before.size, 0.5 * g)
    d_restitution = _banded(sigma, e / before, -(1.0 + e) / before, 1.0 / before)
    return Block(v, e, _banded(sigma, -slope, slope), d_restitution, sigma, True)


# --- checks -------------------------------------------------------------------------------------------------


def _count(name: str, values: Any) -> int:
    return int(validation.array(name, values).size)


def _drops(name: str, lists: Any, least: int, **limits: float) -> list[Floats]:
    if not isinstance(lists, Sequence) or isinstance(lists, str | bytes) or not len(lists):
        need = "must be a list of drops, each a list of numbers"
        raise ValueError(f"{name}: got {validation.shown(lists)}, {need}")
    drops = []
    for i, drop in enumerate(lists):
        values = np.atleast_1d(validation.array(f"{name}[{i}]", drop, **limits))  # type: ignore[arg-type]
        if values.size < least:
            raise ValueError(f"{name}[{i}]: got {values.size} values, must be {least} or more")
        drops.append(values)
    return drops


def _errors(name: str, values: Any, drops: Sequence[Floats]) -> list[Floats]:
    if isinstance(values, Sequence) and not isinstance(values, str | bytes):
        if len(values) != len(drops):
            raise ValueError(f"{name}: got {len(values)} drops, must be {len(drops)}")
        pairs = enumerate(zip(values, drops, strict=True))
        return [validation.each(f"{name}[{i}]", sigma, drop.size, **ERRORS) for i, (sigma, drop) in pairs]
    return [np.full(drop.size, validation.number(name, values, **ERRORS)) for drop in drops]


def _refuse_coarse(name: str, error: Floats, value: Floats) -> None:
    """Refuse errors too large for propagation to first order."""
    for i in np.flatnonzero(error > LARGEST_ERROR * np.abs(value)):
        got = f"got {error[i]:.6g} for a value of {value[i]:.6g}"
        raise ValueError(f"{name}[{i}]: {got}, must be at most {LARGEST_ERROR:g} times the value")


def _refuse_higher(name: str, before: Floats, after: Floats, sigma: Floats, shift: int) -> None:
    """Refuse a rebound above the drop height by more than the errors of both."""
    for i in np.flatnonzero(after > before + MAX_DEVIATION * sigma):
        got = f"got a rebound of {after[i]:.6g} m after a fall from {before[i]:.6g} m"
        raise ValueError(
            f"{name}[{i + shift}]: {got}, must not be higher by more than {MAX_DEVIATION:g} errors"
        )


def _refuse_gaps(name: str, t: Floats, sigma: Floats) -> None:
    flight = np.diff(t)
    for i in np.flatnonzero(flight <= 0.0):
        raise ValueError(f"{name}[{i + 1}]: got {t[i + 1]:.9g} s after {t[i]:.9g} s, must be later")
    tolerance = MAX_DEVIATION * np.sqrt(sigma[:-2] ** 2 + 4.0 * sigma[1:-1] ** 2 + sigma[2:] ** 2)
    for i in np.flatnonzero(flight[1:] > flight[:-1] + tolerance):
        got = f"got a flight of {flight[i + 1]:.6g} s after one of {flight[i]:.6g} s"
        need = "must be shorter: an impact is missing, or a time is not that of an impact"
        raise ValueError(f"{name}[{i + 2}]: {got}, {need}")
