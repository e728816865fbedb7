"""Plot of a contact with friction: forces, slip velocity and spins over time, intervals of stick shaded."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ..contact.balls import Ball
from ..contact.impact import Impact, Interval
from .labels import scaled
from .style import GREY, PAGE_WIDTH, PALETTE, style

#: Head room above a curve, of the range of its values.
HEAD_ROOM: Final = 0.12
Times = NDArray[np.float64]


def impact(result: Impact) -> Figure:
    """Forces with Coulomb's limit, slip velocity and spins of a contact over time; intervals of stick are shaded."""
    title = rf"$\varepsilon = {result.restitution:.3g}$, $\beta = {result.tangential_restitution:.3g}$"
    return panels(result, title, _draw_forces, _draw_slip, _draw_spins)


def panels(result: Any, title: str, *draw: Callable[[Axes, Any, xr.Dataset, Times], None]) -> Figure:
    """Three quantities of a contact over time, one below the other."""
    motion = result.trajectory()
    factor, unit = scaled(result.duration, "s")
    time = motion["time"].values * factor
    with style():
        figure = Figure(figsize=(PAGE_WIDTH * 0.62, 5.4))
        axes = figure.subplots(3, 1, sharex=True, height_ratios=(1.5, 1.0, 1.0))
        for ax, function in zip(axes, draw, strict=True):
            function(ax, result, motion, time)
        for ax in axes:
            shade(ax, result.intervals, factor)
        figure.align_ylabels()
        axes[-1].set_xlabel(f"time after touch [{unit}]")
        axes[-1].set_xlim(0.0, result.duration * factor)
        axes[0].set_title(title.replace("-", "−"), fontsize="medium", pad=17.0)
    return figure


def _draw_forces(ax: Axes, result: Impact, motion: xr.Dataset, time: Times) -> None:
    """Normal and tangential force; of the limit, what the tangential force may reach at most."""
    normal, tangential = motion["normal_force"].values, motion["tangential_force"].values
    limit = result.numbers.terms.coefficient * np.abs(normal)
    factor, unit = scaled(float(np.abs(normal).max()), "N")
    ax.plot(time, normal * factor, color=PALETTE["black"], label="$F_n$")
    ax.plot(time, tangential * factor, color=PALETTE["blue"], label="$F_t$")
    if np.isfinite(limit).all() and limit.any():
        for side in (1.0, -1.0):
            label = r"$\pm\mu F_n$" if side > 0.0 else None
            ax.plot(time, side * limit * factor, color=GREY, lw=0.8, ls=(0, (4, 3)), label=label, zorder=1.5)
    ax.set_ylabel(f"force [{unit}]")
    ax.legend(loc="upper right")


def _draw_slip(ax: Axes, _: Impact, motion: xr.Dataset, time: Times) -> None:
    values = motion["slip_velocity"].values
    factor, unit = scaled(float(np.abs(values).max()), "m/s")
    ax.plot(time, values * factor, color=PALETTE["vermillion"])
    ax.set_ylabel(f"slip velocity [{unit}]")
    _with_zero(ax)


def _draw_spins(ax: Axes, result: Impact, motion: xr.Dataset, time: Times) -> None:
    """The spins of the bodies that can turn."""
    turning = [body for body in ("ball", "other") if isinstance(getattr(result, body), Ball)]
    for body, colour in zip(turning, ("green", "purple"), strict=False):
        ax.plot(time, motion["spin"].sel(body=body).values, color=PALETTE[colour], label=body)
    ax.set_ylabel("spin [rad/s]")
    _with_zero(ax)
    if len(turning) > 1:
        ax.legend(loc="best")


def _with_zero(ax: Axes) -> None:
    """The curves with head room, and a thin line at zero."""
    low, high = min(ax.dataLim.ymin, 0.0), max(ax.dataLim.ymax, 0.0)
    room = HEAD_ROOM * ((high - low) or 1.0)
    ax.set_ylim(low - room, high + room)
    ax.axhline(0.0, color="black", lw=0.5)


def shade(ax: Axes, intervals: tuple[Interval, ...], factor: float) -> None:
    """Shade the intervals of stick, and name those that are wide enough in the upper panel."""
    duration = intervals[-1].end
    for state, begin, end in intervals:
        if state == "stick":
            ax.axvspan(begin * factor, end * factor, color=PALETTE["sky"], alpha=0.22, lw=0, zorder=0)
        if ax.get_subplotspec().is_first_row() and end - begin > 0.08 * duration:  # type: ignore[union-attr]
            place, where = (0.5 * (begin + end) * factor, 1.0), ("data", "axes fraction")
            ax.annotate(
                state,
                place,
                (0, 2),
                xycoords=where,
                textcoords="offset points",
                ha="center",
                va="bottom",
                fontsize="small",
            )
