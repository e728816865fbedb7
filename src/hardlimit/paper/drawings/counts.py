"""Fig. 4: maps of the number of ball–ball contacts."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FormatStrFormatter

from ...plots.labels import QUANTITIES
from ...plots.maps import label_regions
from ...plots.style import MOST_COUNTED, PAGE_WIDTH, count_colours
from .caption import quantity, typeset

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

MILLI: Final = 1e3
STROKE: Final = [withStroke(linewidth=2.2, foreground="white")]


def count_maps(data: xr.Dataset) -> Figure:
    """Fig. 4: both maps, one colour for each count, with the drops of Figs. 2 and 3 marked."""
    figure = Figure(figsize=(PAGE_WIDTH * 0.8, 8.0))
    top, bottom = figure.subplots(2, 1)
    counts = [data[f"n_contacts_over_{name}"].values.astype(int) for name in ("gap", "radius_ratio")]
    lowest, highest = min(int(c.min()) for c in counts), max(int(c.max()) for c in counts)
    cmap, norm = count_colours(highest, lowest)
    gap, ratio = float(data["marked_gap"]), float(data["marked_radius_ratio"])
    top.set_yscale("log")
    mesh = _draw_map(top, data, data["gap"].values * MILLI, counts[0], gap * MILLI, cmap, norm)
    _draw_map(bottom, data, data["radius_ratio"].values, counts[1], ratio, cmap, norm)
    top.yaxis.set_major_formatter(FormatStrFormatter("%g"))
    top.set_ylabel(rf"{QUANTITIES['gap'][0]} [mm]")
    bottom.set_ylabel(QUANTITIES["radius_ratio"][0])
    bottom.set_yticks([1, 5, 10, 15, 20])
    bottom.axhline(1.0, color="black", lw=1.0, path_effects=STROKE)
    upper = float(json.loads(data.attrs["parameters"])["radius_2_m"])
    _title(top, f"(a)  R1 = {quantity(ratio * upper, 'm')}")
    _title(bottom, f"(b)  Δh = {quantity(gap, 'm')}")
    _name_line(top, gap * MILLI, "Δh of Fig. 3")
    _name_line(bottom, ratio, "R1/R2 of Fig. 3")
    _name_line(bottom, 1.0, "R1 = R2")
    shown = np.arange(lowest, min(highest, MOST_COUNTED) + 1)
    extend = "max" if highest > MOST_COUNTED else "neither"
    bar = figure.colorbar(mesh, ax=[top, bottom], ticks=shown, extend=extend, aspect=40)
    bar.ax.minorticks_off()
    bar.set_label(QUANTITIES["n_contacts"][0])
    return figure


def _draw_map(
    ax: Axes,
    data: xr.Dataset,
    y: NDArray[np.float64],
    counts: NDArray[np.int64],
    marked: float,
    cmap: Any,
    norm: Any,
) -> Any:
    """One map with the dashed line of Fig. 3 and the + of Fig. 2; returned is what the colour bar needs."""
    epsilon, drop = data["restitution"].values, float(data["marked_restitution"])
    mesh = ax.pcolormesh(epsilon, y, counts.T, cmap=cmap, norm=norm, shading="nearest", rasterized=True)
    ax.axhline(marked, color="black", lw=1.0, ls=(0, (5, 3)), path_effects=STROKE)
    for colour, width in (("white", 3.6), ("black", 1.8)):
        ax.plot(drop, marked, "+", color=colour, ms=10 + width / 2, mew=width)
    ax.annotate("Fig. 2", (drop, marked), (7, 7), textcoords="offset points", fontsize=9, path_effects=STROKE)
    ax.set_xlim(epsilon[0], epsilon[-1])
    ax.set_ylim(y[0], y[-1])
    ax.set_xlabel(QUANTITIES["restitution"][0])
    ax.tick_params(which="both", direction="out", top=False, right=False)
    _label_counts(ax, epsilon, y, counts, (marked,))
    return mesh


def _title(ax: Axes, text: str) -> None:
    ax.set_title(typeset(text), loc="left", pad=4)


def _name_line(ax: Axes, y: float, text: str) -> None:
    """The name of a horizontal line, above its left end."""
    ax.annotate(
        typeset(text),
        (0.0, y),
        (5, 3),
        xycoords=("axes fraction", "data"),
        textcoords="offset points",
        fontsize=9,
        path_effects=STROKE,
    )


def _label_counts(
    ax: Axes, x: NDArray[Any], y: NDArray[Any], counts: NDArray[Any], lines: tuple[float, ...]
) -> None:
    """The counts as numbers in their regions, away from the frame and from lines and their names."""
    away = len(y) // 25
    hidden = counts.copy()
    for line in (*lines, 1.0) if ax.get_yscale() == "linear" else lines:
        at = int(np.argmin(np.abs(y - line)))
        hidden[:, max(at - away, 0) : at + 2 * away] = -1
    for frame in (hidden[:away], hidden[-away:], hidden[:, :away], hidden[:, -away:]):
        frame[:] = -1
    label_regions(ax, x, y, hidden)
