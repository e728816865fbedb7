"""Sec. IV B: effective restitution over the gap (Fig. 5)."""

from __future__ import annotations

from typing import Final

import numpy as np

from ...column.solvers import newton
from ..data import Data
from ..sampling import jumps
from ..setup import RESTITUTION_5
from .statement import Finding, Statements, near, verdict

STATEMENTS: Final = Statements()


@STATEMENTS.add("ε_eff/ε → 1 with growing Δh, where one contact is left", "Sec. IV B, Fig. 5", 5)
def _levels_off(data: Data) -> Finding:
    figure = data.figure(5)
    last = float(figure["restitution_ratio"][-1])
    single = int(figure["n_contacts"][-1]) == 1
    return Finding(
        f"{last:.4f} at {float(figure.gap[-1]) * 1e3:g} mm, with {int(figure.n_contacts[-1])} contact; it "
        f"levels off slightly above 1 because gravity acts during the contact",
        verdict(near(last, 1.0, 0.01), single),
    )


@STATEMENTS.add(
    "At a large gap the floor contact is over when the balls meet, and the collisions are independent",
    "Sec. IV B, Fig. 5",
    5,
)
def _independent_beyond(data: Data) -> Finding:
    column = data.setup.linear(RESTITUTION_5)
    floor = column.contacts[0]
    beta, omega2 = floor.damping / (2 * floor.effective_mass), floor.stiffness / floor.effective_mass
    formula = column.impact_speed * (floor.duration() - 2 * beta * RESTITUTION_5 / omega2)
    low, high = 1e-4, 1e-2
    while high - low > 1e-9:
        middle = 0.5 * (low + high)
        result = newton(data.setup.linear(RESTITUTION_5, gap=middle))
        pair = result.contacts["pair"].values == 1
        if float(result.contacts["begin"].values[pair][0]) < result.t_floor_end:
            low = middle
        else:
            high = middle
    ratio = newton(data.setup.linear(RESTITUTION_5, gap=high * 1.01)).restitution_ratio
    return Finding(
        f"from Δh = {high * 1e3:.3f} mm on (without gravity {formula * 1e3:.3f} mm); ε_eff/ε = {ratio:.4f} "
        f"there",
        verdict(near(ratio, 1.0, 0.01)),
    )


@STATEMENTS.add(
    "One contact is necessary but not sufficient for independent collisions", "Sec. IV B, Fig. 5", 5
)
def _not_sufficient(data: Data) -> Finding:
    result = newton(data.setup.linear(RESTITUTION_5, gap=5e-4))
    figure = data.figure(5)
    good = np.abs(figure["restitution_ratio"].values - 1.0) < 0.01
    necessary = bool(np.all(figure["n_contacts"].values[good] == 1))
    return Finding(
        f"ε = 0.9, Δh = 0.5 mm: {result.n_contacts} contact, ε_eff/ε = {result.restitution_ratio:.3f} at "
        f"t_f ({result.restitution_ratio_at_separation:.3f} at separation)",
        verdict(necessary, result.n_contacts == 1 and result.restitution_ratio < 0.95),
    )


@STATEMENTS.add("The number of contacts over Δh has a maximum", "Sec. IV B, Fig. 5", 5)
def _peak(data: Data) -> Finding:
    figure = data.figure(5)
    counts = figure["n_contacts"].values
    at = figure["gap"].values[counts == counts.max()]
    inside = 0 < int(np.argmax(counts)) < counts.size - 1
    return Finding(
        f"{counts.max()} contacts from {at[0] * 1e6:.2f} to {at[-1] * 1e6:.2f} µm", verdict(inside)
    )


@STATEMENTS.add(
    "At very small Δh the number oscillates, because of contacts after the floor contact",
    "Sec. IV B, Fig. 5",
    5,
)
def _oscillates(data: Data) -> Finding:
    figure = data.figure(5)
    found = jumps(figure["gap"].values, figure["n_contacts"].values)
    peak = float(figure["gap"].values[int(np.argmax(figure["n_contacts"].values))])
    falls = [at for at, below, above in found if at < peak and above < below]
    late = 0
    for at in falls:
        result = newton(data.setup.linear(RESTITUTION_5, gap=at * (1 - 1e-7)))
        begin = result.contacts["begin"].values[result.contacts["pair"].values == 1]
        late += int(begin[-1] > result.t_floor_end)
    return Finding(
        f"below {peak * 1e6:.1f} µm it falls {len(falls)} times as Δh grows; in {late} of them the contact "
        f"that is lost began after the floor contact",
        verdict(bool(falls), late == len(falls)),
    )
