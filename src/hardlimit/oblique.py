"""``hl.oblique_drop``: a drop of two balls whose centres are not on one vertical line."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from .boxes.newton import molecular_dynamics
from .boxes.result import ContactResult
from .boxes.system import ParticleSystem
from .column.result import Result
from .column.scenario import Column
from .column.solvers import newton
from .contact.contact import Law
from .contact.friction import Friction
from .support import validation

Floats = NDArray[np.float64]

#: Edge of the box over the distance of the centres at the first floor contact. No ball reaches a side wall.
EDGE: Final = 20.0
#: Duration of the first run over that of the sequence without offset. It is doubled until the balls have separated.
FIRST_RUN: Final = 1.5
MAX_DOUBLINGS: Final = 12
#: Time from the end of a contact to the state after it, relative to the time of the end.
INSTANT: Final = 1e-12
#: Largest offset over the sum of the radii; beyond it the balls miss each other.
LARGEST_OFFSET: Final = 0.99


@dataclass(frozen=True, eq=False)
class ObliqueDrop:
    """Result of a drop of two balls with a horizontal offset; made by :func:`hardlimit.oblique_drop`.

    Velocities [m/s] are those after the last contact of the sequence. Horizontal velocities are positive in the
    direction from the lower to the upper ball.

    Notes
    -----
    Newton's equations (Eq. 14 of the paper) in the plane; each normal force acts along the line of centres.

    """

    column: Column  #: the same drop without offset
    offset: float  #: horizontal distance of the centres at the first floor contact [m]
    run: ContactResult  #: simulation in the plane, from the first floor contact to the separation
    friction: Friction | None = None  #: between the balls and with the floor; None: smooth

    @property
    def tilt(self) -> float:
        """Angle [rad] between the line of centres and the vertical when the balls touch, sin θ = offset/(R1 + R2)."""
        return math.asin(self.offset / sum(ball.radius for ball in self.column.balls))

    @property
    def velocities(self) -> Floats:
        """Velocities (2, 2) [m/s]: rows are the lower and the upper ball, columns horizontal and vertical."""
        return self.run.system.velocities

    @property
    def angular_velocities(self) -> Floats:
        """Spins (2,) [rad/s] of the lower and the upper ball in the plane, positive from horizontal to vertical."""
        spins = self.run.system.angular_velocities
        return np.zeros(2) if spins is None else spins

    @property
    def sideways_velocity(self) -> float:
        """Horizontal velocity [m/s] of the upper ball; without friction, that of the lower one is −m2/m1 times this."""
        return float(self.velocities[1, 0])

    @property
    def separation_velocity(self) -> float:
        """Difference of the vertical velocities [m/s]; without offset, this is ``Result.separation_velocity``."""
        return float(self.velocities[1, 1] - self.velocities[0, 1])

    @property
    def throw_angle(self) -> float:
        """Angle [rad] between the final velocity of the upper ball and the vertical."""
        return math.atan2(self.sideways_velocity, float(self.velocities[1, 1]))

    @property
    def n_contacts(self) -> int:
        """Number of ball–ball contacts."""
        return int(self.run.n_pairs or 0)

    @cached_property
    def straight(self) -> Result:
        """The drop without offset under Newton's equations."""
        return newton(self.column)

    @property
    def estimate(self) -> float:
        """Horizontal velocity of the upper ball [m/s] without friction to leading order: tilt × (v2 + V).

        The impulse on the upper ball acts along the line of centres and changes its velocity from −V to v2, as without
        offset. The rotation of that line during the contact, by about V t_c/(R1 + R2) of the tilt, is neglected.
        """
        upwards = float(self.straight.final_velocities[1])
        return self.tilt * (upwards + self.column.impact_speed)

    def __repr__(self) -> str:
        return (
            f"<ObliqueDrop by {self.offset:.4g} m: {self.sideways_velocity:.6g} m/s sideways, "
            f"{math.degrees(self.throw_angle):.4g}°, ball–ball contacts: {self.n_contacts}>"
        )


def oblique_drop(
    column: Column,
    offset: float,
    *,
    friction: Friction | None = None,
    spins: Sequence[float] = (0.0, 0.0),
) -> ObliqueDrop:
    """Drop two balls with a horizontal offset of their centres, under Newton's equations in the plane.

    Parameters
    ----------
    column : Column
        Two balls above a floor, with one law and one velocity. The gap is the distance between the surfaces at the
        first floor contact, along the line of centres.
    offset : float [m]
        Horizontal distance of the centres, less than the sum of the radii.
    friction : Friction, optional
        Friction of the balls with each other and with the floor, beside the law of the column.
    spins : two numbers [rad/s]
        Angular velocities of the lower and the upper ball before the drop, in the plane, positive from horizontal to
        vertical. They matter with friction only.

    Raises
    ------
    ValueError
        If an argument is outside its range, or the column does not have two balls above a floor.
    RuntimeError
        If a contact becomes too deep, or the balls do not separate before the lower one meets the floor again.

    Notes
    -----
    ``molecular_dynamics(engine="events")`` solves Newton's equations (Eq. 14 of the paper) in the plane, to 1e-9. One
    contact with friction in space is :func:`oblique_impact`.

    Examples
    --------
    >>> drop = hl.oblique_drop(hl.Column.paper(gap=0.01), offset=1e-4)
    >>> f"{drop.sideways_velocity * 1e3:.2f} mm/s, estimate {drop.estimate * 1e3:.2f}"
    '8.24 mm/s, estimate 8.21'
    >>> rough = hl.oblique_drop(
    ...     hl.Column.paper(gap=0.01), offset=1e-4, friction=hl.Friction(0.3)
    ... )
    >>> f"{rough.sideways_velocity * 1e3:.2f} mm/s, {rough.angular_velocities[1]:.3f} rad/s"
    '5.50 mm/s, -0.683 rad/s'
    """
    if not isinstance(column, Column) or not column.floor or len(column.balls) != 2:
        raise ValueError(
            f"column: got {validation.shown(column)}, must be a Column of two balls above a floor"
        )
    if len(set(column.laws)) != 1:
        raise ValueError("column: got two laws, must have one law for floor and pair")
    if len(set(column.velocities)) != 1:
        raise ValueError("column: got two velocities, must have one velocity for both balls")
    limit = LARGEST_OFFSET * sum(ball.radius for ball in column.balls)
    aside = validation.number("offset", offset, -limit, limit, lowest_allowed=True, highest_allowed=True)
    turning = np.array(validation.numbers("spins", spins, 2))
    law = column.laws[0] if friction is None else column.laws[0].replace(friction=friction)
    return ObliqueDrop(column, aside, _until_separated(column, law, _start(column, aside, turning)), friction)


def _start(column: Column, offset: float, spins: Floats) -> ParticleSystem:
    """Both balls at the first floor contact, in a box whose side walls they do not reach."""
    lower, upper = column.balls
    distance = lower.radius + column.gaps[0] + upper.radius  # of the centres
    edge, speed = EDGE * distance, column.impact_speed
    rise = math.sqrt((distance - offset) * (distance + offset))
    return ParticleSystem(
        [[0.5 * edge, lower.radius], [0.5 * edge + offset, lower.radius + rise]],
        [[0.0, -speed], [0.0, -speed]],
        [lower.radius, upper.radius],
        mass=[lower.mass, upper.mass],
        box=[edge, edge],
        boundary="wall",
        gravity=column.gravity,
        angular_velocities=spins,
        inertia_factor=[ball.inertia_factor for ball in column.balls],
    )


def _until_separated(column: Column, law: Law, system: ParticleSystem) -> ContactResult:
    """Simulate to the first instant at which the balls have met, no contact is open and the gap grows."""

    def simulate(until: float) -> ContactResult:
        return molecular_dynamics(system, law=law, until=until, engine="events", samples=1, log=True)

    until = FIRST_RUN * _sequence(column)
    for _ in range(MAX_DOUBLINGS):
        run = simulate(until)
        again = _second_floor_contact(run)
        log: Any = run.log
        ends = np.sort(log[1][log[1] < again])
        # Balls with an offset may miss each other: then the gap grows without a contact that ends.
        for t in [*(ends * (1.0 + INSTANT)), min(until, again * (1.0 - INSTANT))]:
            early = simulate(float(t))
            if _are_separated(early):
                return early
        if run.outcome_name != "ok":
            raise RuntimeError(f"oblique drop: {run.outcome}")
        if math.isfinite(again):
            break
        until *= 2.0
    raise RuntimeError("oblique drop: the balls do not separate before the lower one meets the floor again")


def _sequence(column: Column) -> float:
    """Duration [s] of the sequence without offset, at least that of a contact."""
    result = newton(column)
    if result._core.too_deep >= 0:
        raise RuntimeError(f"oblique drop: {result.outcome}")
    known = [t for t in (result.t_end, result.t_floor_end) if math.isfinite(t) and t > 0.0]
    contact = float(column.contacts[0].duration(column.impact_speed))
    return max([contact, *known])


def _are_separated(run: ContactResult) -> bool:
    """Whether the balls have met, no contact is open or too deep, the gap grows, and the lower ball leaves the floor.

    The force may vanish while the ball still overlaps the floor; then gravity must not hold it there.
    """
    if run.outcome_name != "ok" or not run.n_pairs or run.n_ended != run.n_contacts:
        return False
    system = run.system
    (lower, upper), (v_lower, v_upper) = system.positions, system.velocities
    overlap, rising = system.radius[0] - lower[1], max(v_lower[1], 0.0)
    leaves = rising**2 >= -2.0 * system.gravity[1] * overlap
    return bool(leaves and (upper - lower) @ (v_upper - v_lower) > 0.0)


def _second_floor_contact(run: ContactResult) -> float:
    """Begin [s] of the first floor contact after the gap at the floor had opened; infinite if there is none.

    A force that merely switches on again does so while the surfaces recede.
    """
    log: Any = run.log
    begin, _, _, second, approach = log[:5]
    return float(begin[(second < 0) & (begin > 0.0) & (approach > 0.0)].min(initial=math.inf))
