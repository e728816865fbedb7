"""Plot of a contact whose normal turns: forces, slip speed and spins over time, intervals of stick shaded."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..contact.balls import Ball
from ..contact.oblique_impact import ObliqueImpact
from .impact import Times, panels
from .labels import scaled
from .style import GREY, PALETTE


def oblique_impact(result: ObliqueImpact) -> Figure:
    """Normal and tangential force with Coulomb's limit, slip speed and components of the spins over time."""
    title = rf"$\varepsilon = {result.restitution:.3g}$, turn {math.degrees(result.turn):.3g}°"
    return panels(result, title, _draw_forces, _draw_slip, _draw_spins)


def _draw_slip(ax: Axes, _: ObliqueImpact, motion: xr.Dataset, time: Times) -> None:
    ax.plot(time, np.linalg.norm(motion["slip_velocity"].values, axis=1), color=PALETTE["vermillion"])
    ax.set_ylabel("slip speed [m/s]")


def _draw_forces(ax: Axes, result: ObliqueImpact, motion: xr.Dataset, time: Times) -> None:
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


def _draw_spins(ax: Axes, result: ObliqueImpact, motion: xr.Dataset, time: Times) -> None:
    """The components of the spins, those of the second ball dashed."""
    spins = motion["spin"].values
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
