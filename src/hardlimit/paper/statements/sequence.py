"""Sec. IV A: the sequence of contacts in one drop, and their number over ε (Figs. 2, 3 and 7)."""

from __future__ import annotations

from typing import Final

import numpy as np

from ...column.solvers import newton
from .. import figure4
from ..data import Data
from ..sampling import maxima, middles, share
from .statement import POINTS, ROWS, Finding, Statements, about, counts_over, near, verdict

STATEMENTS: Final = Statements()


@STATEMENTS.add("F01 jumps to a finite value at the first touch", "Sec. IV A, Fig. 2", 2)
def _jump(data: Data) -> Finding:
    force = data.figure(2)["force_floor"]
    at = float(force.sel(time=slice(0.0, None))[1])
    before = float(force.sel(time=slice(None, -1e-15))[-1])
    column = data.setup.linear()
    damping = column.contacts[0].damping * column.impact_speed
    return Finding(
        f"from {before:g} to {at / 1e3:.3f} kN; γ01 V = {damping / 1e3:.3f} kN",
        verdict(near(at, damping, 1e-3 * damping)),
    )


@STATEMENTS.add("The balls touch several times during one floor contact", "Sec. IV A, Fig. 2", 2)
def _several(data: Data) -> Finding:
    figure = data.figure(2)
    inside = int(np.sum(figure["end"].values < float(figure["t_floor_end"])))
    return Finding(
        f"{figure.sizes['contact']} contacts, {inside} of them within the floor contact; the last ends at "
        f"{float(figure.t_end) * 1e6:.3f} µs, the floor contact at {float(figure.t_floor_end) * 1e6:.3f} µs",
        verdict(inside > 1),
    )


@STATEMENTS.add("The last contact may end before or after the floor contact", "Sec. IV A, Fig. 3", 3)
def _either_order(data: Data) -> Finding:
    figure = data.figure(3)
    epsilon = figure["restitution_outline"].values
    late = figure["outline_t_end"].values > figure["outline_t_floor_end"].values
    after = share(late, (epsilon, False))
    return Finding(
        f"after it for {100 * after:.1f} % of the ε from {epsilon[0]:g} to {epsilon[-1]:g}",
        verdict(0.0 < after < 1.0),
    )


@STATEMENTS.add("3 contacts at ε = 1", "Sec. IV A, Fig. 3")
def _elastic(data: Data) -> Finding:
    n = newton(data.setup.linear(1.0)).n_contacts
    return Finding(f"{n} contacts", verdict(n == 3))


@STATEMENTS.add("At a large gap one contact remains", "Sec. IV A")
def _large_gap(data: Data) -> Finding:
    counts = {gap: newton(data.setup.linear(1.0, gap=gap)).n_contacts for gap in (1e-4, 1e-3, 1e-2)}
    shown = ", ".join(f"{n} at {gap * 1e3:g} mm" for gap, n in counts.items())
    return Finding(f"ε = 1: {shown}", verdict(counts[1e-2] == 1))


@STATEMENTS.add(
    "From ε = 1 downwards the number of contacts first grows, then falls: one maximum", "Sec. IV A, Fig. 3", 3
)
def _one_maximum(data: Data) -> Finding:
    counts = data.figure(3)["outline_n_contacts"].values
    path = counts[::-1]
    path = path[np.flatnonzero(np.diff(path, prepend=-1))]
    return Finding(
        f"{', '.join(map(str, path))} contacts as ε falls from 1 to 0.1", verdict(maxima(counts) == 1)
    )


@STATEMENTS.add(
    "The same for every set of parameters: the number over ε has a single maximum", "Sec. IV A", 7
)
def _one_maximum_everywhere(data: Data) -> Finding:
    linear = data.setup.linear()
    gaps = middles(*figure4.GAPS, ROWS, logarithmic=True)
    ratios = middles(*figure4.RATIOS, ROWS)
    epsilon = np.linspace(*figure4.RESTITUTION, POINTS)
    by_gap = np.array([maxima(row) for row in counts_over(linear, gap=gaps, restitution=epsilon)])
    by_ratio = np.array(
        [maxima(row) for row in counts_over(linear, radius_ratio=ratios, restitution=epsilon)]
    )
    single = float(np.mean(by_gap == 1)), float(np.mean(by_ratio == 1))
    most = f"{by_gap.max()} maxima at Δh = {gaps[int(np.argmax(by_gap))] * 1e6:.2f} µm"
    hertz = maxima(data.figure(7)["outline_n_contacts"].values)
    return Finding(
        f"linear: one maximum for {about(single[0])} of the Δh (logarithmic) and {about(single[1])} "
        f"of the R1/R2 of Fig. 4; {most}; viscoelastic (Fig. 7): {hertz} maxima",
        verdict(min(single) == 1.0 and hertz == 1, min(single) > 0.5),
    )


@STATEMENTS.add("The duration of a contact depends only weakly on ε", "Sec. IV A")
def _weakly(data: Data) -> Finding:
    def duration(epsilon: float) -> float:
        return float(data.setup.linear(epsilon).contacts[1].duration())

    changes = {epsilon: 1.0 - duration(epsilon) / duration(1.0) for epsilon in (0.9, 0.7, 0.5, 0.3)}
    shown = ", ".join(f"{100 * change:.0f} % at {epsilon:g}" for epsilon, change in changes.items())
    return Finding(
        f"shorter than at ε = 1 by {shown}",
        verdict(changes[0.7] < 0.1, changes[0.5] < 0.1, changes[0.3] < 0.1),
    )
