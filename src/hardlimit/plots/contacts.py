"""Plots of a contact: restitution and duration over the impact speed, obtained over requested restitution."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ..contact.contact import Contact
from .labels import scaled
from .style import COLUMN_WIDTH, PAGE_WIDTH, PALETTE, style

#: Smallest span of an axis of ε, so that a constant ε appears as a straight line.
LEAST_SPAN: Final = 0.1


def restitution_over_speed(contact: Contact, speeds: NDArray[np.float64]) -> Figure:
    """Coefficient of restitution and duration of one isolated contact over the impact speed [m/s]."""
    with style():
        figure = Figure(figsize=(PAGE_WIDTH * 0.6, 4.0))
        upper, lower = figure.subplots(2, 1, sharex=True)
        restitution = np.asarray(contact.restitution(speeds))
        upper.plot(speeds, restitution, color=PALETTE["blue"])
        upper.set_ylabel(r"coefficient of restitution $\varepsilon$")
        low, high = float(restitution.min()), float(restitution.max())
        margin = max(0.1 * (high - low), 0.5 * (LEAST_SPAN - (high - low)))
        upper.set_ylim(max(low - margin, 0.0), high + margin)
        duration = np.asarray(contact.duration(speeds))
        factor, unit = scaled(float(duration.max()), "s")
        lower.plot(speeds, duration * factor, color=PALETTE["vermillion"])
        lower.set_ylabel(f"duration [{unit}]")
        lower.set_ylim(0.0, 1.1 * float(duration.max()) * factor)
        lower.set_xscale("log")
        lower.set_xlim(speeds[0], speeds[-1])
        lower.set_xlabel("speed of impact [m/s]")
    return figure


def restitution_obtained(requested: NDArray[np.float64], curves: dict[str, NDArray[np.float64]]) -> Figure:
    """Obtained over requested restitution, one curve for each way to choose the damping."""
    with style():
        figure = Figure(figsize=(COLUMN_WIDTH * 1.15, COLUMN_WIDTH * 1.05))
        ax = figure.subplots()
        for (name, obtained), line in zip(curves.items(), ("-", (0, (5, 2)), (0, (1, 1.2))), strict=False):
            ax.plot(requested, obtained, ls=line, label=name)
        ax.set_xlabel(r"$\varepsilon$ requested")
        ax.set_ylabel(r"$\varepsilon$ obtained")
        ax.set_xlim(0.0, 1.0)
        ax.set_ylim(0.0, 1.02)
        ax.legend(loc="lower right")
    return figure
