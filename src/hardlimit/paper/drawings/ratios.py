"""Figs. 5 and 6: effective restitution and number of contacts over one parameter."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter

from ...plots.labels import QUANTITIES
from ...plots.style import PAGE_WIDTH, PALETTE

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

BLUE: Final = PALETTE["blue"]
ORANGE: Final = PALETTE["orange"]
COUNTS: Final = "#9a6a00"  #: the same hue, dark enough for type
RATIO: Final = r"$\varepsilon_\mathrm{eff}\,/\,\varepsilon_\mathrm{spec}$"
NARROWEST: Final = 0.012  #: branch of a curve that is drawn, in widths of the axes

MILLI, MICRO = 1e3, 1e6


def broken(x: NDArray[np.float64], y: NDArray[np.float64], counts: NDArray[Any]) -> tuple[Any, Any]:
    """The curve with a break wherever the number of contacts changes."""
    at = np.flatnonzero(np.diff(counts)) + 1
    return np.insert(x, at, np.nan), np.insert(y, at, np.nan)


def ratio_and_counts(ax: Axes, x: NDArray[np.float64], data: xr.Dataset) -> Axes:
    """ε_eff/ε on the left axis; the number of contacts, a staircase, on the right one, which is returned."""
    counts = data["n_contacts"].values
    right = ax.twinx()
    ax.set_zorder(right.get_zorder() + 1)
    ax.patch.set_visible(False)
    right.step(x, counts, where="mid", color=ORANGE, lw=1.0)
    ax.axhline(1.0, color="#888888", lw=0.6, zorder=0)
    ax.plot(*broken(x, data["restitution_ratio"].values, counts), color=BLUE, lw=1.4)
    ax.set_ylabel(f"{RATIO} at $t_f$", color=BLUE)
    right.set_ylabel(QUANTITIES["n_contacts"][0], color=COUNTS)
    ax.tick_params(axis="y", which="both", right=False, colors=BLUE)
    right.tick_params(axis="y", which="both", colors=COUNTS)
    return right


def count_ticks(right: Axes, most: int) -> None:
    """Ticks at whole numbers up to the largest, which always has one: all of them, or every second, …."""
    step = math.ceil(most / 12)
    right.set_yticks(np.arange(most, -1, -step))
    right.set_yticks(np.arange(0, most + 1), minor=True)


def ratio_over_gap(data: xr.Dataset) -> Figure:
    """Fig. 5: the whole range above, small gaps magnified below."""
    figure = Figure(figsize=(PAGE_WIDTH * 0.85, 6.6))
    top, bottom = figure.subplots(2, 1)
    most = int(data["n_contacts"].max())
    longest = float(data["gap"][-1])
    wide = data.sel(gap=slice(_first_wide(data, NARROWEST * longest), None))
    right = ratio_and_counts(top, wide["gap"].values * MILLI, wide)
    top.set_xlim(0.0, longest * MILLI)
    top.set_ylim(0.0, 1.08)
    small = data.sel(gap=slice(None, float(data["magnified_gap"]) * (1 + 1e-12)))
    right.axvspan(0.0, float(small["gap"][-1]) * MILLI, color="#ececec", lw=0, zorder=-1)
    lower = ratio_and_counts(bottom, small["gap"].values * MICRO, small)
    bottom.set_xscale("log")
    bottom.xaxis.set_major_formatter(FormatStrFormatter("%g"))
    bottom.set_xlim(float(small["gap"][0]) * MICRO, float(small["gap"][-1]) * MICRO)
    bottom.set_ylim(0.0, float(small["restitution_ratio"].max()) * 1.08)
    for axes in (right, lower):
        axes.set_ylim(0.0, most * 1.08)
        count_ticks(axes, most)
    top.set_xlabel(rf"{QUANTITIES['gap'][0]} [mm]")
    bottom.set_xlabel(rf"{QUANTITIES['gap'][0]} [µm]")
    dense = (
        f"; not drawn below {float(wide['gap'][0]) * MILLI:.2g} mm"
        if wide.sizes["gap"] < data.sizes["gap"]
        else ""
    )
    top.set_title(f"(a)  shaded: the range of (b){dense}", loc="left", pad=4)
    bottom.set_title("(b)  small gaps, on a logarithmic axis", loc="left", pad=4)
    return figure


def _first_wide(data: xr.Dataset, width: float) -> float:
    """The Δh [m] from which on every stretch of equal counts is at least ``width`` wide."""
    gap = data["gap"].values
    jumps = gap[np.flatnonzero(np.diff(data["n_contacts"].values)) + 1]
    narrow = np.flatnonzero(np.diff(np.append(jumps, gap[-1])) < width)
    return float(jumps[narrow[-1] + 1]) if narrow.size and narrow[-1] + 1 < jumps.size else float(gap[0])


def ratio_over_radii(data: xr.Dataset) -> Figure:
    """Fig. 6 with its inset."""
    figure = Figure(figsize=(PAGE_WIDTH * 0.85, 4.8))
    ax = figure.subplots()
    x = data["radius_ratio"].values
    right = ratio_and_counts(ax, x, data)
    ax.set_xlim(x[0], x[-1])
    ax.set_xticks([1, 5, 10, 15, 20])
    ax.set_ylim(0.0, 1.08)
    most = int(data["n_contacts"].max())
    right.set_ylim(0.0, max(10.0, 2.2 * most))
    count_ticks(right, most)
    ax.set_xlabel(QUANTITIES["radius_ratio"][0])
    _draw_inset(ax, data)
    return figure


def _draw_inset(ax: Axes, data: xr.Dataset) -> None:
    """The ratios above 1, with their maximum."""
    inset = ax.inset_axes((0.46, 0.56, 0.5, 0.36))
    near = data.sel(radius_ratio=slice(1.0, 1.62))
    x, y = near["radius_ratio"].values, near["restitution_ratio"].values
    inset.axhline(1.0, color="#888888", lw=0.6)
    inset.plot(*broken(x, y, near["n_contacts"].values), color=BLUE, lw=1.3)
    inset.fill_between(x, 1.0, np.maximum(y, 1.0), color=BLUE, alpha=0.15, lw=0)
    i = int(np.nanargmax(y))
    inset.plot(x[i], y[i], "o", color=BLUE, ms=3.5)
    inset.set_xlim(1.0, 1.6)
    inset.set_ylim(0.9985, 1.0 + 1.75 * max(float(y[i]) - 1.0, 0.0005))
    inset.ticklabel_format(axis="y", useOffset=False)
    inset.tick_params(labelsize=8)
    inset.text(
        0.04,
        0.93,
        f"maximum {y[i]:.4f} at $R_1/R_2={x[i]:.2f}$",
        transform=inset.transAxes,
        va="top",
        fontsize=8.5,
    )
    inset.set_xlabel("$R_1/R_2$", fontsize=8.5, labelpad=1)
    inset.set_ylabel(RATIO, fontsize=8.5, labelpad=2)
