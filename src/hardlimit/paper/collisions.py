"""Secs. II and III: statements on independent collisions, and on one ε for two contacts."""

from __future__ import annotations

from typing import Final

import numpy as np

from ..column.solvers import independent
from .setup import Paper
from .statement import Outcome, Statements, near

STATEMENTS: Final = Statements()


@STATEMENTS.add(
    "Elastic, vanishing gap: v2 and v1 after both collisions are V (3 − μ)/(1 + μ) and V (1 − 3μ)/(1 + μ)",
    "Eqs. 5–6",
)
def _limit(paper: Paper) -> Outcome:
    error = 0.0
    masses = (1e-6, 0.001, 0.1, 1 / 3, 0.9)
    for mu in masses:
        column = paper.mass_ratio(mu)
        v1, v2 = independent(column).velocities / column.impact_speed
        error = max(error, abs(v2 - (3 - mu) / (1 + mu)), abs(v1 - (1 - 3 * mu) / (1 + mu)))
    return (f"largest deviation {error:.1e} V for {len(masses)} mass ratios μ = m2/m1", error < 1e-9)


@STATEMENTS.add("μ = 1/3 stops the lower ball, and the upper one leaves at twice its speed", "Sec. II A")
def _third(paper: Paper) -> Outcome:
    column = paper.mass_ratio(1 / 3)
    v1, v2 = independent(column).velocities / column.impact_speed
    return (f"v1 = {abs(v1):.1e} V, v2 = {v2:.9f} V", near(v1, 0.0, 1e-9), near(v2, 2.0, 1e-9))


@STATEMENTS.add("μ → 0: the upper ball leaves at 3V and rises to 9 z2(0) − 8 (2R1 + R2)", "Sec. II A")
def _nine_times(paper: Paper) -> Outcome:
    column = paper.mass_ratio(1e-12)
    result = independent(column)
    speed = result.velocities[1]
    top = result.positions[1] + speed**2 / (2 * column.gravity)
    z0, (lower, upper) = column.initial_positions[1], (ball.radius for ball in column.balls)
    wanted = 9 * z0 - 8 * (2 * lower + upper)
    text = f"v2 = {speed / column.impact_speed:.9f} V; height {top:.9f} m, formula {wanted:.9f} m"
    return text, near(speed / column.impact_speed, 3.0, 1e-9), near(top, wanted, 1e-8)


@STATEMENTS.add(
    "The sequence of two collisions fails if the lower ball is the lighter one, even elastically", "Sec. II A"
)
def _lighter_below(paper: Paper) -> Outcome:
    def collisions(mu: float) -> int:
        column = paper.mass_ratio(mu, gap=1e-9)
        again = independent(column, until=0.1).contacts["pair"].values
        return int(np.sum(again == 1))

    counts = {mu: collisions(mu) for mu in (0.5, 0.9, 0.999, 1.001, 1.1, 2.0)}
    once = all(n == 1 for mu, n in counts.items() if mu < 1)
    more = all(n > 1 for mu, n in counts.items() if mu > 1)
    shown = ", ".join(f"{n} at μ = {mu:g}" for mu, n in counts.items())
    return (f"ball–ball collisions of the hard spheres, ε = 1: {shown}", once, more)


@STATEMENTS.add("One ε for both contacts makes γ01 larger than γ12", "Sec. III B")
def _two_dampings(paper: Paper) -> Outcome:
    floor, pair = (c.damping for c in paper.linear().contacts)
    return (f"ε = 0.7: γ01 = {floor:.4g}, γ12 = {pair:.4g} N s/m", floor > pair)
