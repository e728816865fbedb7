"""Plot of a contact whose normal turns: forces, slip speed and spins over time, intervals of stick shaded."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ..contact.balls import Ball
from ..contact.oblique_impact import ObliqueImpact
from .impact import shade
from .labels import scaled
from .style import GREY, PAGE_WIDTH, PALETTE, style


def oblique_impact(result: ObliqueImpact) -> Figure:
    """Normal and tangential force with Coulomb's limit, slip speed and components of the spins over time."""
    motion = result.trajectory()
    factor, unit = scaled(result.duration, "s")
    time = motion["time"].values * factor
    with style():
        figure = Figure(figsize=(PAGE_WIDTH * 0.62, 5.4))
        forces, slip, spins = figure.subplots(3, 1, sharex=True, height_ratios=(1.5, 1.0, 1.0))
        _draw_forces(forces, result, motion, time)
        slip.plot(time, np.linalg.norm(motion["slip_velocity"].values, axis=1), color=PALETTE["vermillion"])
        slip.set_ylabel("slip speed [m/s]")
        _draw_spins(spins, result, motion["spin"].values, time)
        for ax in (forces, slip, spins):
            shade(ax, result.intervals, factor)
        figure.align_ylabels()
        spins.set_xlabel(f"time after touch [{unit}]")
        spins.set_xlim(0.0, result.duration * factor)
        title = rf"$\varepsilon = {result.restitution:.3g}$, turn {math.degrees(result.turn):.3g}°"
        forces.set_title(title.replace("-", "−"), fontsize="medium", pad=17.0)
    return figure


def _draw_forces(ax: Axes, result: ObliqueImpact, motion: Any, time: NDArray[np.float64]) -> None:
    normal = motion["normal_force"].values
    tangential = np.linalg.norm(motion["tangential_force"].values, axis=1)
    factor, unit = scaled(float(normal.max()), "N")
    ax.plot(time, normal * factor, color=PALETTE["black"], label="$F_n$")
    ax.plot(time, tangential * factor, color=PALETTE["blue"], label="$|F_t|$")
    friction = result.contact.law.friction
    if friction is not None and math.isfinite(friction.coefficient):
        limit = friction.coefficient * normal * factor
        ax.plot(time, limit, color=GREY, lw=0.8, ls=(0, (4, 3)), label=r"$\mu F_n$", zorder=1.5)
    ax.set_ylabel(f"force [{unit}]")
    ax.legend(loc="upper right")


def _draw_spins(
    ax: Axes, result: ObliqueImpact, spins: NDArray[np.float64], time: NDArray[np.float64]
) -> None:
    """The components of the spins, those of the second ball dashed."""
    for body, name in enumerate(("ball", "other")):
        if not isinstance(getattr(result.contact, name), Ball):
            continue
        for axis, colour in enumerate(("green", "purple", "orange")):
            label = "xyz"[axis] if body == 0 else None
            ax.plot(
                time, spins[:, body, axis], color=PALETTE[colour], ls="-" if body == 0 else "--", label=label
            )
    ax.axhline(0.0, color="black", lw=0.5)
    ax.set_ylabel("spin [rad/s]")
    ax.legend(loc="best", ncols=3)
