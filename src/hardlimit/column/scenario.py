"""The scenario: balls on one vertical line above a floor, or a cradle without floor and gravity."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from functools import cached_property
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from .. import _core, validation
from ..bodies import FLOOR, Ball, Floor
from ..contact import Contact, Law
from ..laws import LinearDashpot

#: Density with which the paper's stated facts come out [kg/m³]; inferred, the paper prints none.
PAPER_DENSITY: Final = 840.0

STANDARD_GRAVITY: Final = 9.81


class Column:
    """Balls with their centres on one vertical line, released above a floor.

    Parameters
    ----------
    balls : sequence of Ball, bottom first
    gaps : sequence of float [m]
        Between neighbouring balls, bottom first; ``len(balls) - 1`` values or one for all.
    height : float [m]
        Centre of the lowest ball at release, z1(0); at least its radius.
    law : Law, or one Law for each contact (floor first)
    velocities : float or sequence of float [m/s]
        At release, upwards.
    gravity : float [m/s²]

    Raises
    ------
    ValueError
        If a value is outside its range, or nothing would ever move.
    """

    def __init__(
        self,
        balls: Sequence[Ball],
        gaps: float | Sequence[float],
        height: float,
        law: Law | Sequence[Law],
        velocities: float | Sequence[float] = 0.0,
        gravity: float = STANDARD_GRAVITY,
    ) -> None:
        self._set_balls(balls, gaps, velocities)
        self.gravity = validation.number("gravity", gravity, 0.0, lowest_allowed=True)
        self.height = validation.number("height", height)
        lowest = self.balls[0].radius
        if not self.height >= lowest:
            raise ValueError(
                f"height: got {self.height:.16g}, must be >= {lowest:.16g}, the radius of the lowest ball"
            )
        self.floor = True
        self._set_laws(law, len(self.balls))
        v = self.velocities[0]
        if not self.impact_speed > 0.0:
            raise ValueError(
                f"height: got {self.height:.16g}, nothing moves: must be > {lowest:.16g} or velocities not 0"
            )
        if math.isnan(_core.fall_time(self.drop_height, v, self.gravity)):
            raise ValueError(
                f"velocities[0]: got {v:.16g}, must be < 0: without gravity the column never lands"
            )

    def _set_balls(self, balls: Sequence[Ball], gaps: Any, velocities: Any) -> None:
        if isinstance(balls, Ball) or not isinstance(balls, Iterable):
            raise ValueError(f"balls: got {balls!r}, must be a list of two or more Ball")
        self.balls = tuple(balls)
        if len(self.balls) < 2:
            raise ValueError(f"balls: got {len(self.balls)}, must be two or more")
        for i, ball in enumerate(self.balls):
            if not isinstance(ball, Ball):
                raise ValueError(f"balls[{i}]: got {ball!r}, must be a Ball")
        n = len(self.balls)
        self.gaps = validation.numbers("gaps", gaps, n - 1, lowest=0.0, lowest_allowed=True)
        self.velocities = validation.numbers("velocities", velocities, n)

    def _set_laws(self, law: Law | Sequence[Law], contacts: int) -> None:
        laws = (
            (law,) * contacts if isinstance(law, Law) else tuple(law) if isinstance(law, Iterable) else (law,)
        )
        for one in laws:
            if not isinstance(one, Law):
                raise ValueError(f"law: got {one!r}, must be a contact law such as LinearDashpot")
        if len(laws) != contacts:
            raise ValueError(f"law: got {len(laws)} laws, must be one or {contacts}, one for each contact")
        if len({type(one) for one in laws}) > 1:
            raise ValueError("law: got laws of different kinds, must be of one kind")
        self.laws = laws

    @classmethod
    def paper(
        cls,
        restitution: float | None = None,
        gap: float = 1e-4,
        radius_ratio: float | None = None,
        *,
        radius_1: float | None = None,
        radius_2: float = 0.01,
        density: float = PAPER_DENSITY,
        stiffness: float | None = None,
        height: float = 0.6,
        gravity: float = STANDARD_GRAVITY,
        law: Law | None = None,
    ) -> Column:
        """The drop of Fig. 2: R1 = 10 cm, R2 = 1 cm, Δh = 0.1 mm, z1(0) = 0.6 m, k = 5e7 N/m, ε = 0.7.

        ``density`` is 840 kg/m³: inferred from the paper's stated facts, since it prints none. ``radius_ratio``
        R1/R2 changes the lower radius. ``law`` replaces the linear dashpot with ``stiffness`` and
        ``restitution``.
        """
        if radius_1 is not None and radius_ratio is not None:
            raise ValueError("radius_ratio | radius_1: got both, must be at most one of them")
        upper = validation.number("radius_2", radius_2, 0.0)
        ratio = validation.number("radius_ratio", 10.0 if radius_ratio is None else radius_ratio, 0.0)
        lower = (0.1 if radius_ratio is None else ratio * upper) if radius_1 is None else radius_1
        if law is not None and (restitution is not None or stiffness is not None):
            raise ValueError("law | restitution, stiffness: got both, must be at most one of them")
        if law is None:
            law = LinearDashpot(
                stiffness=5e7 if stiffness is None else stiffness,
                restitution=0.7 if restitution is None else restitution,
            )
        balls = [Ball(lower, density=density), Ball(upper, density=density)]
        return cls(balls, [gap], height, law, gravity=gravity)

    @classmethod
    def cradle(
        cls,
        balls: Sequence[Ball],
        velocities: Sequence[float],
        law: Law | Sequence[Law],
        gaps: float | Sequence[float] = 0.0,
    ) -> Column:
        """Balls in a row without floor and gravity (Newton's cradle); time zero is release.

        ``law`` is one law, or one for each ball–ball contact.
        """
        self = cls.__new__(cls)
        self._set_balls(balls, gaps, velocities)
        if not any(b < a for a, b in zip(self.velocities, self.velocities[1:], strict=False)):
            raise ValueError(f"velocities: got {list(self.velocities)}, must let some neighbours approach")
        self.gravity, self.height, self.floor = 0.0, self.balls[0].radius, False
        self._set_laws(law, len(self.balls) - 1)
        return self

    def __repr__(self) -> str:
        law = self.laws[0] if len(set(self.laws)) == 1 else list(self.laws)
        inner = (
            f"balls={list(self.balls)}, gaps={list(self.gaps)}, law={law}, velocities={list(self.velocities)}"
        )
        if not self.floor:
            return f"Column.cradle({inner})"
        return f"Column({inner}, height={self.height!r}, gravity={self.gravity!r})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Column) and repr(self) == repr(other)

    def __hash__(self) -> int:
        return hash(repr(self))

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuild, (
            self.floor,
            self.balls,
            self.gaps,
            self.height,
            self.laws,
            self.velocities,
            self.gravity,
        )

    @property
    def drop_height(self) -> float:
        """H = z1(0) − R1 [m]."""
        return self.height - self.balls[0].radius

    @property
    def impact_speed(self) -> float:
        """V [m/s]: speed of the lowest ball at the floor, √(v1² + 2 g H); of a cradle, the largest speed."""
        if not self.floor:
            return max(abs(v) for v in self.velocities)
        return _core.impact_speed(self.drop_height, self.velocities[0], self.gravity)

    @property
    def specified_restitution(self) -> float:
        """The one ε given for all contacts, else NaN."""
        values = {law.specified_restitution for law in self.laws}
        return values.pop() if len(values) == 1 else math.nan

    @cached_property
    def contacts(self) -> tuple[Contact, ...]:
        """All contacts, the floor's first (a cradle has none with a floor)."""
        lower: list[Ball | Floor] = [FLOOR, *self.balls[:-1]] if self.floor else list(self.balls[:-1])
        upper = self.balls if self.floor else self.balls[1:]
        return tuple(law.between(b, a) for law, a, b in zip(self.laws, lower, upper, strict=True))

    @cached_property
    def core(self) -> _core.Column:
        """The column as the core sees it."""
        contacts = [c.core for c in self.contacts]
        if not self.floor:
            contacts.insert(0, contacts[0])  # pair 0 exists in the core and never closes
        return _core.make_column(
            self.floor,
            self.gravity,
            [b.mass for b in self.balls],
            [b.radius for b in self.balls],
            contacts,
            [self.drop_height, *self.gaps],
            list(self.velocities),
        )

    @property
    def initial_positions(self) -> NDArray[np.float64]:
        """Centres at release [m], bottom first."""
        z = [self.height]
        for a, b, gap in zip(self.balls, self.balls[1:], self.gaps, strict=False):
            z.append(z[-1] + a.radius + gap + b.radius)
        return np.array(z)


def _rebuild(
    floor: bool,
    balls: Sequence[Ball],
    gaps: Sequence[float],
    height: float,
    laws: Sequence[Law],
    velocities: Sequence[float],
    gravity: float,
) -> Column:
    if floor:
        return Column(balls, gaps, height, laws, velocities, gravity)
    return Column.cradle(balls, velocities, laws, gaps)
