"""Sec. IV A: where contacts are added over ε, gap and ratio of radii (Figs. 3 and 4)."""

from __future__ import annotations

from typing import Final

import numpy as np

from .. import figure4
from ..data import Data
from ..sampling import middles
from .statement import POINTS, ROWS, Finding, Statements, about, counts_over, near, verdict

STATEMENTS: Final = Statements()


@STATEMENTS.add(
    "Spikes at ε ≈ 0.78 and 0.67, where the balls meet once more after the floor contact",
    "Sec. IV A, Fig. 3",
    3,
)
def _spikes(data: Data) -> Finding:
    tips = data.figure(3)["spike"].values
    shown = ", ".join(f"{tip:.4f}" for tip in tips)
    return Finding(
        f"tips at {shown or 'no ε'}",
        verdict(tips.size > 0 and near(tips[0], 0.78, 0.005), tips.size > 1 and near(tips[1], 0.67, 0.005)),
    )


@STATEMENTS.add(
    "For each ε some interval of Δh gives the most contacts; the number grows as Δh falls, up to a maximum",
    "Sec. IV A, Fig. 4",
    4,
)
def _maximum_over_gap(data: Data) -> Finding:
    epsilon = middles(*figure4.RESTITUTION, ROWS)
    gaps = np.geomspace(*figure4.GAPS, POINTS)
    counts = counts_over(data.setup.linear(), restitution=epsilon, gap=gaps)
    grows, single = [], []
    for column in counts:
        at_most = np.flatnonzero(column == column.max())
        grows.append(bool(np.all(np.diff(column[at_most[-1] :]) <= 0)))
        single.append(bool(at_most[-1] - at_most[0] + 1 == at_most.size))
    i, j = np.unravel_index(int(np.argmax(counts)), counts.shape)
    return Finding(
        f"growing from 10 mm down to the maximum for {about(float(np.mean(grows)))} of the ε of Fig. 4, the "
        f"maximum in one interval of Δh for {about(float(np.mean(single)))}; most contacts: {counts.max()}, at ε = "
        f"{epsilon[i]:.3f}, Δh = {gaps[j] * 1e6:.1f} µm",
        verdict(all(grows), all(single)),
    )


@STATEMENTS.add("t_c,01/t_c,12 grows with m1/m2", "Sec. IV A")
def _durations(data: Data) -> Finding:
    ratios = []
    for radii in (1.0, 2.0, 5.0, 10.0, 20.0):
        floor, pair = data.setup.linear(0.7, radius_ratio=radii).contacts
        ratios.append(floor.duration() / pair.duration())
    shown = ", ".join(f"{ratio:.2f}" for ratio in ratios)
    return Finding(f"{shown} at R1/R2 = 1, 2, 5, 10, 20", verdict(bool(np.all(np.diff(ratios) > 0))))


@STATEMENTS.add(
    "The number of contacts grows with R1/R2, as the dominating of two effects", "Sec. IV A, Fig. 4", 4
)
def _grows_with_ratio(data: Data) -> Finding:
    epsilon = middles(*figure4.RESTITUTION, ROWS)
    ratios = np.linspace(*figure4.RATIOS, POINTS)
    counts = counts_over(data.setup.linear(), restitution=epsilon, radius_ratio=ratios)
    never_falls = float(np.mean(np.all(np.diff(counts, axis=1) >= 0, axis=1)))
    ends_higher = float(np.mean(counts[:, -1] > counts[:, 0]))
    return Finding(
        f"higher at {ratios[-1]:g} than at {ratios[0]:g} for {about(ends_higher)} of the ε of Fig. 4; "
        f"without falling in between for {about(never_falls)}",
        verdict(ends_higher > 0.9, never_falls > 0.5),
    )
