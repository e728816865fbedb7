"""Fig. 2: the forces on the floor and between the balls over time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter

from ...plots.style import PAGE_WIDTH, pair_colour, pair_label

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

MICRO, KILO = 1e6, 1e-3


def forces(data: xr.Dataset) -> Figure:
    """F01 and F12 over time in two panels with one time axis and one unit; marked instants run through both."""
    figure = Figure(figsize=(PAGE_WIDTH * 0.85, 4.7))
    floor, balls = figure.subplots(2, 1, sharex=True)
    t = data["time"].values * MICRO
    for pair, (ax, name) in enumerate(((floor, "force_floor"), (balls, "force_balls"))):
        force = data[name].values * KILO
        ax.plot(t, force, color=pair_colour(pair))
        ax.fill_between(t, force, color=pair_colour(pair), alpha=0.12, lw=0)
        ax.set_ylabel(f"{pair_label(pair)} [kN]")
        ax.set_ylim(0.0, float(force.max()) * 1.14)
        ax.yaxis.set_major_formatter(FormatStrFormatter("%g"))
    _mark_instants(floor, balls, data)
    _number_contacts(balls, data)
    floor.annotate(
        r"jump to $\gamma_{01}V$",
        (0.0, float(data["force_floor"].sel(time=slice(0.0, None))[1]) * KILO),
        (14, -12),
        textcoords="offset points",
        fontsize=8.5,
        arrowprops={"arrowstyle": "-", "lw": 0.6, "color": "#555555"},
    )
    floor.set_xlim(t[0], t[-1])
    balls.set_xlabel("time after the first floor touch [µs]")
    return figure


def _mark_instants(floor: Axes, balls: Axes, data: xr.Dataset) -> None:
    """Begin and end of the floor contact and of the sequence, as dashed lines with their names above."""
    ends = data["end"].values
    first, last = float(data["begin"][0]), float(np.nanmax(ends)) if np.isfinite(ends).any() else np.nan
    floor_end = float(data["t_floor_end"])
    same = "{}= t_f" if last == float(data["t_end"]) else ""
    # The two ends lie close together: their names stand on the sides that are turned away from each other.
    sides = ("right", "left") if last < floor_end else ("left", "right")
    marks = [
        (float(data["t_floor_begin"]), "$t_{01}^{(b)}$", "center"),
        (first, "$t_{12}^{(b)}$", "center"),
        (last, f"$t_{{12}}^{{(e)}}{same}$", sides[0]),
        (floor_end, "$t_{01}^{(e)}$", sides[1]),
    ]
    for at, label, side in marks:
        if not np.isfinite(at):
            continue
        for ax in (floor, balls):
            ax.axvline(at * MICRO, color="#555555", lw=0.7, ls=(0, (4, 3)), zorder=0)
        shift = {"right": -2, "left": 2}.get(side, 0)
        floor.annotate(
            label,
            (at * MICRO, 1.0),
            (shift, 3),
            xycoords=("data", "axes fraction"),
            textcoords="offset points",
            ha="right" if side == "right" else "left" if side == "left" else "center",
            va="bottom",
        )


def _number_contacts(ax: Axes, data: xr.Dataset) -> None:
    """1, 2, 3, … above the contacts of the balls."""
    time, force = data["time"].values, data["force_balls"].values
    for i, (begin, end) in enumerate(zip(data["begin"].values, data["end"].values, strict=True)):
        during = (time >= begin) & (time <= end)
        ax.annotate(
            str(i + 1),
            (0.5 * (begin + end) * MICRO, float(force[during].max(initial=0.0)) * KILO),
            (0, 2),
            textcoords="offset points",
            ha="center",
            fontsize=9,
        )
