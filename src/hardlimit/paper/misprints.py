"""Misprints of the paper: each equation is evaluated as printed and as corrected."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from ..column.scenario import Column
from ..column.solvers import adiabatic, newton
from ..contact.laws import LAWS
from .sampling import bisect
from .setup import Paper
from .statement import Outcome, Statements

MISPRINTS: Final = Statements("misprint")


@MISPRINTS.add("Printed: v12 = −g t12 + v'10. Should be v12 = v'10 − g (t12 − t10)", "Sec. II A")
def _velocity_at_meeting(paper: Paper) -> Outcome:
    """ε = 1, Δh → 0, where Eq. 5 is known."""
    column = paper.linear(1.0, gap=0.0)
    speed, mu = column.impact_speed, column.balls[1].mass / column.balls[0].mass
    t10 = speed / column.gravity
    upper = -column.gravity * t10

    def final(lower: float) -> float:
        """Eq. 2 at ε = 1."""
        return (mu * upper + lower + (lower - upper)) / (1 + mu)

    printed = final(-column.gravity * t10 + speed) / speed
    corrected = final(speed) / speed
    wanted = (3 - mu) / (1 + mu)
    return (
        f"ε = 1, Δh → 0: as printed v2 = {printed:.4f} V, corrected {corrected:.4f} V; Eq. 5 says "
        f"{wanted:.4f} V",
        abs(printed - wanted) < 1e-6,
    )


@MISPRINTS.add(
    "Printed: the collision is complete when ξ̇ = 0. Should be ξ̈ = 0, where the force has fallen to zero",
    "Sec. II B",
)
def _end_of_contact(paper: Paper) -> Outcome:
    """The floor contact of a lower ball whose partner is far away."""
    column = paper.linear(0.7, gap=0.5)
    result = newton(column)
    end = result.t_floor_end

    def falling(t: float) -> bool:
        return bool(result.trajectory(t)["velocity"].values[0, 0] < 0.0)

    low, _ = bisect(0.0, end, falling, 1e-15)
    at_turn = result.trajectory(low)
    rebound = float(result.trajectory(end)["velocity"].values[0, 0]) / column.impact_speed
    force = float(at_turn["force"].sel(pair=0)[0])
    return (
        f"ε = 0.7: ξ̇ = 0 at {low * 1e6:.1f} µs, where F = {force / 1e3:.1f} kN and Eq. 10 would give ε = "
        f"0; ξ̈ = 0 at {end * 1e6:.1f} µs, −ξ̇/v = {rebound:.4f}",
        force < 1.0,
    )


@MISPRINTS.add(
    "Printed: Eq. 7 makes repulsion negative (F ≤ 0), but Eq. 14 and App. A need it positive", "Eqs. 7, 14"
)
def _sign(paper: Paper) -> Outcome:
    """The acceleration that Eq. 14 gives with the force of Eq. 7."""
    column = paper.linear(0.7)
    result = newton(column)
    at = 0.25 * result.t_floor_end
    forces = result.trajectory(at)["force"].values[0]
    mass = column.balls[0].mass
    printed = (-forces[0] + forces[1]) / mass - column.gravity
    meant = (forces[0] - forces[1]) / mass - column.gravity
    step = 1e-7
    v = result.trajectory([at - step, at + step])["velocity"].values[:, 0]
    measured = (v[1] - v[0]) / (2 * step)
    return (
        f"lower ball on the floor at {at * 1e6:.0f} µs: as printed it is pulled down with {-printed:.0f} "
        f"m/s², with F ≥ 0 pushed up with {meant:.0f}; its velocity changes by {measured:.0f} m/s²",
        bool(abs(printed - measured) < 0.01 * abs(measured)),
    )


@MISPRINTS.add("Printed: Eq. 9 writes F(ξ̇, ξ), Eq. 7 defines F(ξ, ξ̇)", "Eqs. 7, 9")
def _arguments(paper: Paper) -> Outcome:
    """F(ξ, ξ̇) against F(ξ̇, ξ)."""
    contact = paper.linear(0.7).contacts[0]
    compression, rate = 1e-4, 1.0
    right, swapped = contact.force(compression, rate), contact.force(rate, compression)
    return (
        f"ξ = 0.1 mm, ξ̇ = 1 m/s: F = {right / 1e3:.2f} kN, with the arguments swapped {swapped / 1e3:.0f} kN",
        abs(right - swapped) < 1e-6 * right,
    )


@MISPRINTS.add(
    "Printed: A = (z1 − z_inh)/cos p with p = arctan(…/(z_inh − z1)), which is 0/0 where z1 = z_inh", "Eq. A4"
)
def _amplitude(paper: Paper) -> Outcome:
    """Eq. A4 where the floor contact begins at z1,inh: without gravity that is the first touch itself."""
    drop = paper.linear(0.7)
    law = LAWS["linear"](stiffness=5e7, restitution=0.7)
    speed = drop.impact_speed
    column = Column(drop.balls, drop.gaps, drop.height, law, velocities=-speed, gravity=0.0)
    floor = column.contacts[0]
    decay = floor.damping / (2 * floor.effective_mass)
    omega = math.sqrt(floor.stiffness / floor.effective_mass - decay**2)
    offset = 0.0  # z1 − z1,inh at the first touch
    with np.errstate(divide="ignore"):
        phase = float(np.arctan(np.float64(decay * offset - speed) / np.float64(-offset * omega)))
    amplitude = offset / math.cos(phase)
    result = adiabatic(column)
    deepest = drop.balls[0].radius - float(
        result.trajectory(result.default_times())["position"].values[:, 0].min()
    )
    return (
        f"no gravity, at the first touch: as printed A = {abs(amplitude):g}, the ball would stand still; "
        f"with amplitudes of cos and sin it is compressed by {deepest * 1e3:.3f} mm",
        abs(amplitude) > 0.1 * deepest,
    )
