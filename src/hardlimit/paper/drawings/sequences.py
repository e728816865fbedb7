"""Figs. 3, 7 and 8: begin and end of every ball–ball contact over one parameter."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FormatStrFormatter

from ...plots.labels import QUANTITIES
from ...plots.style import PAGE_WIDTH, PALETTE
from .caption import quantity, typeset

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

BLACK: Final = PALETTE["black"]
RED: Final = PALETTE["vermillion"]
GREY: Final = "#a3a3a3"
ROW: Final = "#4d4d4d"
TINT: Final = "#e6ecf5"
EDGE: Final = "#5f7fa8"
DASHES: Final = (0, (5, 2.5))

FIGURE_3: Final = (PAGE_WIDTH * 0.85, 5.9)  #: [inch]

MILLI, MICRO = 1e3, 1e6
EPSILON: Final = QUANTITIES["restitution"][0]
TIME: Final = "time after the first floor touch"
FLOOR_END: Final = r"$t_{01}^{(e)}$, floor contact ends"


def draw_rows(ax: Axes, data: xr.Dataset, name: str, prefix: str, factor: float, **look: Any) -> None:
    """One horizontal line for every contact, at the height of the parameter."""
    begin, end = data[f"{prefix}begin"].values * factor, data[f"{prefix}end"].values * factor
    y = np.broadcast_to(data[name].values[:, None], begin.shape)
    end = np.where(np.isfinite(begin) & ~np.isfinite(end), ax.get_xlim()[1], end)
    keep = np.isfinite(begin)
    segments = np.stack(
        [np.column_stack([begin[keep], y[keep]]), np.column_stack([end[keep], y[keep]])], axis=1
    )
    ax.add_collection(LineCollection(list(segments), capstyle="butt", **look), autolim=False)


def draw_outlines(ax: Axes, data: xr.Dataset, name: str, prefix: str, factor: float) -> None:
    """The regions in which the balls touch, tinted; a region ends where the number of contacts changes."""
    begin, end = data[f"{prefix}begin"].values * factor, data[f"{prefix}end"].values * factor
    y, count = data[name].values, data[f"{prefix}n_contacts"].values
    for part in _runs(count):
        for j in range(int(count[part.start])):
            ax.fill_betweenx(y[part], begin[part, j], end[part, j], color=TINT, lw=0, zorder=0)
            for border in (begin, end):
                ax.plot(border[part, j], y[part], color=EDGE, lw=0.6, zorder=0.5)


def _runs(counts: NDArray[Any]) -> list[slice]:
    """Stretches of equal counts."""
    edges = [0, *(np.flatnonzero(np.diff(counts)) + 1), counts.size]
    return [slice(int(a), int(b)) for a, b in pairwise(edges)]


def _line(label: str, **look: Any) -> Line2D:
    return Line2D([], [], label=label, **look)


def _outline(label: str) -> Patch:
    """The entry of a legend for the tinted regions."""
    return Patch(facecolor=TINT, edgecolor=EDGE, lw=0.8, label=label)


def contacts_over_restitution(data: xr.Dataset) -> Figure:
    """Fig. 3."""
    figure = Figure(figsize=FIGURE_3)
    ax = figure.subplots()
    floor_end = float(data["outline_t_floor_end"].max()) * MICRO
    ax.set_xlim(0.0, round(1.45 * floor_end, -2))
    ax.set_ylim(float(data["restitution"].min()) - 0.012, 1.012)
    draw_outlines(ax, data, "restitution_outline", "outline_", MICRO)
    draw_rows(ax, data, "restitution_adiabatic", "adiabatic_", MICRO, colors=GREY, linewidths=0.85)
    draw_rows(ax, data, "restitution", "", MICRO, colors=BLACK, linewidths=0.85)
    marked = float(data["marked_restitution"])
    nearest = int(np.argmin(np.abs(data["restitution"].values - marked)))
    thick = data.isel(restitution=[nearest])
    draw_rows(ax, thick, "restitution", "", MICRO, colors=BLACK, linewidths=3.4)
    ends = data["outline_t_floor_end"].values * MICRO
    ax.plot(ends, data["restitution_outline"].values, color=RED, ls=DASHES, lw=1.4)
    _label_spikes(ax, data["spike"].values)
    handles = [
        _line("Newton’s equations, every 0.01 of $\\varepsilon$", color=BLACK, lw=1.2),
        _outline("the same, between the lines"),
        _line("adiabatic (App. A), in between", color=GREY, lw=1.2),
        _line(rf"$\varepsilon={marked:g}$ (Fig. 2)", color=BLACK, lw=3.4),
        _line(FLOOR_END, color=RED, lw=1.4, ls=DASHES),
    ]
    ax.legend(handles=handles, loc="lower right", title="ball–ball contacts", alignment="left")
    ax.set_xlabel(f"{TIME} [µs]")
    ax.set_ylabel(EPSILON)
    return figure


def _label_spikes(ax: Axes, tips: NDArray[np.float64]) -> None:
    """The ε of the tips of the spikes at the right border; tips too close for two lines share a label."""
    inches = 0.75 * FIGURE_3[1]  # of the axes, about
    height = 13.0 / 72.0 / inches * abs(float(np.diff(ax.get_ylim())[0]))
    groups: list[list[float]] = []
    for tip in sorted((float(t) for t in tips), reverse=True):
        if groups and groups[-1][-1] - tip < height:
            groups[-1].append(tip)
        else:
            groups.append([tip])
    right = ax.get_xlim()[1]
    for group in groups:
        names = r"$, $".join(f"{tip:.3f}" for tip in group)
        several = len(group) > 1
        ax.annotate(
            rf"{'spikes' if several else 'spike'}, $\varepsilon<{names}$",
            (right, group[-1] if several else group[0]),
            (-14, -4 if several else 3),  # clear of the ticks; several: below the lowest
            textcoords="offset points",
            ha="right",
            va="top" if several else "bottom",
            fontsize=9,
        )


def viscoelastic(data: xr.Dataset) -> Figure:
    """Fig. 7 with its inset."""
    figure = Figure(figsize=(PAGE_WIDTH * 0.85, 5.7))
    ax = figure.subplots()
    floor_end = float(data["outline_t_floor_end"].max()) * MILLI
    ax.set_xlim(0.0, round(2.2 * floor_end))
    ax.set_ylim(float(data["restitution"].min()) - 0.012, 1.012)
    _draw_sequence(ax, data, "restitution", "restitution_outline", "", "outline_", 1.3)
    ax.set_xlabel(f"{TIME} [ms]")
    ax.set_ylabel(rf"{EPSILON} at {float(data['input_speed']):g} m/s")
    _draw_inset(ax, data)
    ax.legend(handles=_handles(), loc="upper right", bbox_to_anchor=(1.0, 0.72))
    return figure


def _draw_inset(ax: Axes, data: xr.Dataset) -> None:
    inset = ax.inset_axes((0.62, 0.1, 0.355, 0.38))
    floor_end = float(data["inset_outline_t_floor_end"].max()) * MILLI
    inset.set_xlim(0.0, 2.0 * floor_end)
    inset.set_ylim(ax.get_ylim())
    _draw_sequence(
        inset, data, "restitution_inset", "restitution_inset_outline", "inset_", "inset_outline_", 0.9
    )
    radius, modulus = float(data["inset_radius_2"]), float(data["inset_youngs_modulus"])
    title = typeset(f"R2 = {quantity(radius, 'm')}, Y = {quantity(modulus, 'N/m²')}")
    inset.set_title(title, fontsize=8.5, pad=3)
    inset.set_xlabel("time [ms]", fontsize=8.5, labelpad=1)
    inset.set_ylabel(r"$\varepsilon$", fontsize=8.5, labelpad=1)
    inset.tick_params(labelsize=8)


def same_material(data: xr.Dataset) -> Figure:
    """Fig. 8, with the restitution of the ball–ball contact on the right axis."""
    figure = Figure(figsize=(PAGE_WIDTH * 0.85, 5.7))
    ax = figure.subplots()
    floor_end = float(data["outline_t_floor_end"].max()) * MILLI
    ax.set_xlim(0.0, round(2.2 * floor_end))
    ax.set_yscale("log")
    a = data["dissipative_time"].values * MICRO
    scaled = data.assign_coords(
        dissipative_time=a, dissipative_time_outline=data["dissipative_time_outline"].values * MICRO
    )
    margin = (a[-1] / a[0]) ** 0.012
    ax.set_ylim(a[-1] * margin, a[0] / margin)
    ax.yaxis.set_major_formatter(FormatStrFormatter("%g"))
    _draw_sequence(ax, scaled, "dissipative_time", "dissipative_time_outline", "", "outline_", 1.3)
    ax.set_xlabel(f"{TIME} [ms]")
    ax.set_ylabel("dissipative time $A$ [µs]")
    ax.tick_params(axis="y", which="both", right=False)
    _add_restitution(ax, a, data)
    ax.legend(handles=_handles(), loc="lower right", bbox_to_anchor=(0.97, 0.0))
    return figure


def _add_restitution(ax: Axes, a: NDArray[np.float64], data: xr.Dataset) -> None:
    """A right axis with the ε of the ball–ball contact that belongs to A [µs]."""
    right = ax.twinx()
    right.set_yscale("log")
    right.set_ylim(ax.get_ylim())
    epsilon = data["restitution_balls"].values
    ticks = [e for e in (0.99, 0.95, 0.9, 0.8, 0.7, 0.5, 0.3, 0.2) if epsilon.min() < e < epsilon.max()]
    right.set_yticks(np.exp(np.interp(ticks, epsilon[::-1], np.log(a[::-1]))), [f"{e:g}" for e in ticks])
    right.minorticks_off()
    right.set_ylabel(rf"$\varepsilon_{{12}}$ at {float(data['input_speed']):g} m/s")


def _draw_sequence(
    ax: Axes, data: xr.Dataset, name: str, fine: str, prefix: str, fine_prefix: str, width: float
) -> None:
    """Rows, outlines, and the end of the floor contact; times in ms."""
    draw_outlines(ax, data, fine, fine_prefix, MILLI)
    draw_rows(ax, data, name, prefix, MILLI, colors=ROW, linewidths=width)
    ax.plot(data[f"{fine_prefix}t_floor_end"].values * MILLI, data[fine].values, color=BLACK, lw=1.0)


def _handles() -> list[Any]:
    return [
        _line("ball–ball contacts", color=ROW, lw=1.6),
        _outline("the same, between the lines"),
        _line(FLOOR_END, color=BLACK, lw=1.0),
    ]
