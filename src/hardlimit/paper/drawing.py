"""Drawing shared by several figures: sequences of contacts (Figs. 3, 7, 8) and ε_eff/ε with counts (Figs. 5, 6)."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ..plots.labels import QUANTITIES
from ..plots.style import PAGE_WIDTH, PALETTE
from .sampling import Array, Counts

MILLI, MICRO, KILO = 1e3, 1e6, 1e-3  #: factors from an SI unit to mm or ms, to µm or µs, and to kN

BLACK: Final = PALETTE["black"]
BLUE: Final = PALETTE["blue"]
RED: Final = PALETTE["vermillion"]
ROW: Final = "#4d4d4d"
TINT, EDGE = "#e6ecf5", "#5f7fa8"

TIME: Final = "time after the first floor touch"
FLOOR_END: Final = r"$t_{01}^{(e)}$, floor contact ends"


# --- sequences of contacts ----------------------------------------------------------------------------------


def draw_rows(ax: Axes, data: xr.Dataset, name: str, prefix: str, factor: float, **look: Any) -> None:
    """One horizontal line for each contact, at its value of the parameter."""
    begin, end = data[f"{prefix}begin"].values * factor, data[f"{prefix}end"].values * factor
    y = np.broadcast_to(data[name].values[:, None], begin.shape)
    end = np.where(np.isfinite(begin) & ~np.isfinite(end), ax.get_xlim()[1], end)
    keep = np.isfinite(begin)
    segments = np.stack(
        [np.column_stack([begin[keep], y[keep]]), np.column_stack([end[keep], y[keep]])], axis=1
    )
    ax.add_collection(LineCollection(list(segments), capstyle="butt", **look), autolim=False)


def draw_outlines(ax: Axes, data: xr.Dataset, name: str, prefix: str, factor: float) -> None:
    """Tint the regions in which the balls touch; a region ends where the number of contacts changes."""
    begin, end = data[f"{prefix}begin"].values * factor, data[f"{prefix}end"].values * factor
    y, count = data[name].values, data[f"{prefix}n_contacts"].values
    edges = [0, *(np.flatnonzero(np.diff(count)) + 1), count.size]
    for part in (slice(int(a), int(b)) for a, b in pairwise(edges)):
        for j in range(int(count[part.start])):
            ax.fill_betweenx(y[part], begin[part, j], end[part, j], color=TINT, lw=0, zorder=0)
            for border in (begin, end):
                ax.plot(border[part, j], y[part], color=EDGE, lw=0.6, zorder=0.5)


def draw_sequence(ax: Axes, data: xr.Dataset, name: str, prefix: str, width: float) -> None:
    """Figs. 7 and 8: rows, outlines, and the end of the floor contact; times in ms."""
    fine = f"{name}_outline"
    draw_outlines(ax, data, fine, f"{prefix}outline_", MILLI)
    draw_rows(ax, data, name, prefix, MILLI, colors=ROW, linewidths=width)
    floor_end = data[f"{prefix}outline_t_floor_end"].values * MILLI
    ax.plot(floor_end, data[fine].values, color=BLACK, lw=1.0)


def line(label: str, **look: Any) -> Line2D:
    """A line of a legend."""
    return Line2D([], [], label=label, **look)


def outline() -> Patch:
    """The entry of a legend for the tinted regions."""
    return Patch(facecolor=TINT, edgecolor=EDGE, lw=0.8, label="the same, between the lines")


def sequence_axes(data: xr.Dataset) -> tuple[Figure, Axes]:
    """A figure with the time axis of Figs. 7 and 8 [ms]."""
    figure = Figure(figsize=(PAGE_WIDTH * 0.85, 5.7))
    ax = figure.subplots()
    ax.set_xlim(0.0, round(2.2 * MILLI * float(data["outline_t_floor_end"].max())))
    ax.set_xlabel(f"{TIME} [ms]")
    return figure, ax


def sequence_legend() -> list[Any]:
    """Entries of the legend of Figs. 7 and 8."""
    return [line("ball–ball contacts", color=ROW, lw=1.6), outline(), line(FLOOR_END, color=BLACK, lw=1.0)]


# --- effective restitution with the number of contacts ------------------------------------------------------

RATIO: Final = r"$\varepsilon_\mathrm{eff}\,/\,\varepsilon_\mathrm{spec}$"
COUNTS: Final = "#9a6a00"  #: the orange of the counts, dark enough for type


def broken(x: Array, y: Array, counts: Counts) -> tuple[Array, Array]:
    """The curve with a break wherever the number of contacts changes."""
    at = np.flatnonzero(np.diff(counts)) + 1
    return np.insert(x, at, np.nan), np.insert(y, at, np.nan)


def ratio_and_counts(ax: Axes, x: Array, data: xr.Dataset) -> Axes:
    """Draw ε_eff/ε on the left axis and the number of contacts on the right axis, which is returned."""
    counts = data["n_contacts"].values
    right = ax.twinx()
    ax.set_zorder(right.get_zorder() + 1)
    ax.patch.set_visible(False)
    right.step(x, counts, where="mid", color=PALETTE["orange"], lw=1.0)
    ax.axhline(1.0, color="#888888", lw=0.6, zorder=0)
    ax.plot(*broken(x, data["restitution_ratio"].values, counts), color=BLUE, lw=1.4)
    ax.set_ylabel(f"{RATIO} at $t_f$", color=BLUE)
    right.set_ylabel(QUANTITIES["n_contacts"][0], color=COUNTS)
    ax.tick_params(axis="y", which="both", right=False, colors=BLUE)
    right.tick_params(axis="y", which="both", colors=COUNTS)
    return right


def count_ticks(right: Axes, most: int) -> None:
    """Ticks at the largest count and at every whole number below it, or every second, third, …."""
    step = math.ceil(most / 12)
    right.set_yticks(np.arange(most, -1, -step))
    right.set_yticks(np.arange(0, most + 1), minor=True)
