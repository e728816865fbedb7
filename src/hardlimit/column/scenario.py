"""``Column``: balls on a vertical line above a floor, or a cradle without floor and gravity."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from itertools import pairwise
from typing import Any, Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..contact.balls import FLOOR, Ball, Floor
from ..contact.contact import Contact, Law, checked_law
from ..contact.laws import LinearDashpot
from ..support import html, validation

#: Density that reproduces the facts stated in the paper [kg/m³]. It is inferred; the paper states none.
PAPER_DENSITY: Final = 840.0

STANDARD_GRAVITY: Final = 9.81

#: Largest length, speed and acceleration; the squares of larger values could overflow.
LARGEST: Final = 1e100

T = TypeVar("T")


@validation.sealed("write a function of a Column")
@dataclass(frozen=True, init=False, repr=False)
class Column:
    """Balls with their centres on a vertical line, released above a floor.

    A column is immutable; :meth:`replace` returns a changed copy. Two columns are equal if all their values are.

    Parameters
    ----------
    balls : sequence of Ball, bottom first
        One or more.
    gaps : sequence of float [m]
        Between neighbouring balls, bottom first; ``len(balls) - 1`` values or one for all.
    height : float [m]
        Centre of the lowest ball at release, z1(0); at least its radius.
    law : Law, or one Law for each contact (floor first)
    velocities : float or sequence of float [m/s]
        At release, positive upwards; one value for all balls or one for each.
    gravity : float [m/s²]

    Raises
    ------
    ValueError
        If a value is outside its range (lengths, speeds and accelerations up to 1e100), or no ball would ever move.

    Notes
    -----
    The symbols are those of Müller & Pöschel, Phys. Rev. E 83, 041304 (2011), "the paper".

    Examples
    --------
    >>> basketball = hl.Ball(0.1217, mass=0.609)
    >>> tennis_ball = hl.Ball(0.0335, mass=0.0577)
    >>> floor = hl.LinearDashpot(stiffness=4.2e4, restitution=0.76)
    >>> between = hl.LinearDashpot(stiffness=1.36e4, restitution=0.76)
    >>> balls = [basketball, tennis_ball]
    >>> drop = hl.Column(balls, gaps=0.0, height=0.4217, law=[floor, between])
    >>> moon = drop.replace(gravity=1.62)
    >>> f"{drop.impact_speed:.2f} m/s, on the Moon {moon.impact_speed:.2f} m/s"
    '2.43 m/s, on the Moon 0.99 m/s'
    """

    balls: tuple[Ball, ...]  #: bottom first
    gaps: tuple[float, ...]  #: between neighbours, bottom first [m]
    height: float  #: of the centre of the lowest ball at release [m]
    laws: tuple[Law, ...]  #: one for each contact, the floor's first (a cradle has no floor contact)
    velocities: tuple[float, ...]  #: at release, upwards, bottom first [m/s]
    gravity: float  #: [m/s²]
    floor: bool  #: False for a cradle

    def __init__(
        self,
        balls: Sequence[Ball],
        gaps: float | Sequence[float],
        height: float,
        law: Law | Sequence[Law],
        velocities: float | Sequence[float] = 0.0,
        gravity: float = STANDARD_GRAVITY,
    ) -> None:
        self._set(floor=True, **_checked_balls(balls, gaps, velocities, least=1))
        self._set(gravity=validation.number("gravity", gravity, 0.0, lowest_allowed=True))
        self._set(height=validation.number("height", height))
        _refuse_too_large(height=self.height, gravity=self.gravity)
        lowest = validation.at_least(self.balls[0].radius)
        got = f"height: got {self.height:.16g}"
        if not self.drop_height >= 0.0:
            raise ValueError(f"{got}, must be >= {lowest}, the radius of the lowest ball")
        self._set(laws=_checked_laws(law, len(self.balls)))
        v = self.velocities[0]
        if not self.impact_speed > 0.0:
            if self.gravity == 0.0:
                raise ValueError("gravity | velocities: got 0 and 0, must not both be 0: nothing would move")
            raise ValueError(f"{got}, must be > {lowest} unless velocities are given: nothing would move")
        if math.isnan(_core.fall_time(self.drop_height, v, self.gravity)):
            raise ValueError(f"velocities[0]: got {v:.16g}, must be < 0 without gravity, or nothing lands")

    def _set(self, **values: Any) -> None:
        for name, value in values.items():
            object.__setattr__(self, name, value)

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
        law: Law | Sequence[Law] | None = None,
    ) -> Column:
        """The drop of Fig. 2: R1 = 10 cm, R2 = 1 cm, Δh = 0.1 mm, z1(0) = 0.6 m, k = 5e7 N/m, ε = 0.7.

        Parameters
        ----------
        restitution : float
            ε of both contacts.
        gap : float [m]
            Δh.
        radius_ratio : float
            R1/R2; changes the lower radius.
        radius_1, radius_2 : float [m]
        density : float [kg/m³]
            840 is inferred from the facts stated in the paper, which states none.
        stiffness : float [N/m]
        height : float [m]
            z1(0).
        gravity : float [m/s²]
        law : Law, or one Law for each contact
            Instead of the linear dashpot with ``stiffness`` and ``restitution``.

        Raises
        ------
        ValueError
            If a value is outside its range, or a radius or the law is given twice.
        """
        if radius_1 is not None and radius_ratio is not None:
            raise ValueError("radius_ratio | radius_1: got both, must be at most one of them")
        upper = validation.number("radius_2", radius_2, 0.0)
        ratio = validation.number("radius_ratio", 10.0 if radius_ratio is None else radius_ratio, 0.0)
        lower = 0.1 if radius_ratio is None else ratio * upper
        if radius_1 is not None:
            lower = validation.number("radius_1", radius_1, 0.0)
        if law is not None and (restitution is not None or stiffness is not None):
            raise ValueError("law | restitution, stiffness: got both, must be at most one of them")
        if law is None:
            law = LinearDashpot(
                stiffness=5e7 if stiffness is None else stiffness,
                restitution=0.7 if restitution is None else restitution,
            )
        balls = [Ball(lower, density=density), Ball(upper, density=density)]
        between = validation.number("gap", gap, 0.0, lowest_allowed=True)
        return cls(balls, [between], height, law, gravity=gravity)

    @classmethod
    def cradle(
        cls,
        balls: Sequence[Ball],
        velocities: float | Sequence[float],
        law: Law | Sequence[Law],
        gaps: float | Sequence[float] = 0.0,
    ) -> Column:
        """Newton's cradle: balls in a row without floor and gravity. Time zero is the release.

        Parameters
        ----------
        balls : sequence of Ball, two or more
        velocities : sequence of float [m/s]
            At release, positive towards the next ball.
        law : Law, or one Law for each ball–ball contact
        gaps : float or sequence of float [m]

        Raises
        ------
        ValueError
            If a value is outside its range, or no two neighbours approach each other.

        Examples
        --------
        >>> balls = [hl.Ball(0.02, mass=0.1)] * 3
        >>> steel = hl.LinearDashpot(stiffness=1e6, restitution=1.0)
        >>> cradle = hl.Column.cradle(balls, [1, 0, 0], steel)
        >>> hl.independent(cradle).final_velocities.round(3) + 0.0
        array([0., 0., 1.])
        >>> hl.newton(cradle).final_velocities.round(3)  # they touch
        array([-0.13,  0.15,  0.98])
        """
        self = cls.__new__(cls)
        self._set(floor=False, **_checked_balls(balls, gaps, velocities, least=2))
        if not any(b < a for a, b in pairwise(self.velocities)):
            raise ValueError(
                f"velocities: got {validation.shown(list(self.velocities))}, must let some neighbours approach"
            )
        self._set(gravity=0.0, height=self.balls[0].radius)
        self._set(laws=_checked_laws(law, len(self.balls) - 1))
        return self

    def replace(
        self,
        *,
        balls: Sequence[Ball] | None = None,
        gaps: float | Sequence[float] | None = None,
        height: float | None = None,
        law: Law | Sequence[Law] | None = None,
        velocities: float | Sequence[float] | None = None,
        gravity: float | None = None,
    ) -> Column:
        """A column with the given parameters changed.

        If the number of balls changes, a law, gap or velocity that is the same for all is kept for all.

        Raises
        ------
        ValueError
            If a value is outside its range, or a kept value does not fit the number of balls. A cradle has neither
            height nor gravity.
        """
        kept = self.balls if balls is None else balls
        law = _shared(self.laws) if law is None else law
        gaps = _shared(self.gaps) if gaps is None else gaps
        velocities = _shared(self.velocities) if velocities is None else velocities
        if self.floor:
            height = self.height if height is None else height
            return Column(kept, gaps, height, law, velocities, self.gravity if gravity is None else gravity)
        for name, value in (("height", height), ("gravity", gravity)):
            if value is not None:
                raise ValueError(f"{name}: got {validation.shown(value)}, must be left out for a cradle")
        return Column.cradle(kept, velocities, law, gaps)

    def __repr__(self) -> str:
        law = self.laws[0] if len(set(self.laws)) == 1 else list(self.laws)
        values = (
            f"balls={list(self.balls)}, gaps={list(self.gaps)}, law={law}, velocities={list(self.velocities)}"
        )
        if not self.floor:
            return f"Column.cradle({values})"
        return f"Column({values}, height={self.height!r}, gravity={self.gravity!r})"

    def _repr_html_(self) -> str:
        rows = []
        below = (self.drop_height, *self.gaps)
        for i, (ball, gap, v) in enumerate(zip(self.balls, below, self.velocities, strict=True)):
            where = f"{gap:.6g}" if i or self.floor else ""
            rows.append([f"ball {i + 1}", f"{ball.radius:.6g}", f"{ball.mass:.6g}", where, f"{v:.6g}"])
        kind = f"Column of {len(self.balls)}" if self.floor else f"Cradle of {len(self.balls)}"
        fall = f"; g {self.gravity:.6g} m/s², V {self.impact_speed:.6g} m/s" if self.floor else ""
        laws = "; ".join(dict.fromkeys(map(repr, self.laws)))
        head = ["", "radius [m]", "mass [kg]", "gap below [m]", "velocity [m/s]"]
        return html.table(f"{kind}: {laws}{fall}", head, rows[::-1])

    def __getstate__(self) -> dict[str, Any]:
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @property
    def drop_height(self) -> float:
        """H = z1(0) − R1 [m]."""
        return self.height - self.balls[0].radius

    @property
    def impact_speed(self) -> float:
        """V [m/s]: speed of the lowest ball at the floor, √(v1² + 2 g H), if no balls meet before; for a cradle, the
        largest speed."""
        if not self.floor:
            return max(abs(v) for v in self.velocities)
        return _core.impact_speed(self.drop_height, self.velocities[0], self.gravity)

    @property
    def release_time(self) -> float:
        """Time of the release [s], relative to the first floor touch at 0, if no balls meet before.

        If they do, it depends on the model; ``until`` and ``times`` are checked against that of the model.
        """
        if not self.floor:
            return 0.0
        return -_core.fall_time(self.drop_height, self.velocities[0], self.gravity)

    @property
    def specified_restitution(self) -> float:
        """ε if one value was given for all contacts, else NaN."""
        values = {law.specified_restitution for law in self.laws}
        return values.pop() if len(values) == 1 else math.nan

    @cached_property
    def solvable_exactly(self) -> bool:
        """Whether Newton's equations have a piecewise closed form: two balls on a floor under the linear law.

        :meta private:
        """
        if not self.floor or len(self.balls) != 2:
            return False
        floor, pair = self.laws
        return floor.record is pair.record and _core.has_exact_solver(floor.record["name"])

    @cached_property
    def contacts(self) -> tuple[Contact, ...]:
        """All contacts, the floor's first (a cradle has no floor contact)."""
        lower: list[Ball | Floor] = [FLOOR, *self.balls[:-1]] if self.floor else list(self.balls[:-1])
        upper = self.balls if self.floor else self.balls[1:]
        return tuple(law.between(b, a) for law, a, b in zip(self.laws, lower, upper, strict=True))

    @cached_property
    def core(self) -> _core.Column:
        """The column in the core's representation.

        :meta private:
        """
        contacts = [c.core for c in self.contacts]
        if not self.floor:
            contacts.insert(0, contacts[0])  # pair 0 of the core, which never closes in a cradle
        masses, radii = [b.mass for b in self.balls], [b.radius for b in self.balls]
        gaps, velocities = [self.drop_height, *self.gaps], list(self.velocities)
        return _core.make_column(
            floor=self.floor,
            gravity=self.gravity,
            mass=masses,
            radius=radii,
            contacts=contacts,
            gaps=gaps,
            velocity=velocities,
        )

    @property
    def initial_positions(self) -> NDArray[np.float64]:
        """Centres at release [m], bottom first."""
        z = [self.height]
        for (a, b), gap in zip(pairwise(self.balls), self.gaps, strict=True):
            z.append(z[-1] + a.radius + gap + b.radius)
        return np.array(z)


def _checked_balls(balls: Any, gaps: Any, velocities: Any, least: int) -> dict[str, tuple[Any, ...]]:
    checked = validation.instances("balls", balls, Ball, "Ball")
    if len(checked) < least:
        raise ValueError(f"balls: got {len(checked)}, must be {'one' if least == 1 else 'two'} or more")
    n = len(checked)
    between = validation.numbers("gaps", gaps, n - 1, lowest=0.0, lowest_allowed=True)
    speeds = validation.numbers("velocities", velocities, n)
    _refuse_too_large(**{f"gaps[{i}]": gap for i, gap in enumerate(between)})
    _refuse_too_large(**{f"velocities[{i}]": v for i, v in enumerate(speeds)})
    return {"balls": checked, "gaps": between, "velocities": speeds}


def _refuse_too_large(**values: float) -> None:
    for name, value in values.items():
        if abs(value) > LARGEST:
            raise ValueError(f"{name}: got {value:.16g}, must be in [-{LARGEST:g}, {LARGEST:g}]")


def _checked_laws(law: Any, contacts: int) -> tuple[Law, ...]:
    laws = (law,) * contacts if isinstance(law, Law) else law
    listed = laws if isinstance(laws, Sequence) and not isinstance(laws, str) else [laws]
    for item in listed:
        checked_law(item, "balls of a column")
    if len(laws) != contacts:
        raise ValueError(f"law: got {len(laws)} laws, must be one or {contacts}, one for each contact")
    if len({type(item) for item in laws}) > 1:
        raise ValueError("law: got laws of different kinds, must be of one kind")
    return tuple(laws)


def _shared(values: tuple[T, ...]) -> T | tuple[T, ...]:
    """The common value of all, else all values."""
    return values[0] if len(set(values)) == 1 else values
