"""The paper's figures as pictures. Only drawing: every number comes from the Dataset of the figure."""

from __future__ import annotations

import textwrap
from collections.abc import Callable
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter, MaxNLocator

from ..pictures import plots

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

BLACK: Final = plots.PALETTE["black"]
GREY: Final = "#a3a3a3"
TINT: Final = "#e6ecf5"
EDGE: Final = "#8fa6c4"
RED: Final = plots.PALETTE["vermillion"]
BLUE: Final = plots.PALETTE["blue"]

MILLI, MICRO = 1e3, 1e6
EPSILON: Final = r"coefficient of restitution $\varepsilon$"
RATIO: Final = r"$\varepsilon_\mathrm{eff}\,/\,\varepsilon_\mathrm{spec}$"


def draw(number: int, data: xr.Dataset) -> Figure:
    """The picture of one figure, with its sentence for users of event-driven simulations below."""
    with plots.style():
        figure = DRAWINGS[number](data)
        _sentence(figure, str(data.attrs.get("meaning", "")))
    return figure


def _sentence(figure: Figure, text: str) -> None:
    """Write the sentence below the axes, in space taken from them."""
    width, height = figure.get_size_inches()
    lines = textwrap.wrap(text, int(17.3 * width))
    share = (0.155 * len(lines) + 0.15) / height
    engine: Any = figure.get_layout_engine()
    engine.set(rect=(0.0, share, 1.0, 1.0 - share))
    for i, line in enumerate(reversed(lines)):
        typeset = line.replace("R1/R2", "$R_1/R_2$").replace("ε", r"$\varepsilon$")
        y = (0.07 + 0.155 * i) / height
        figure.text(0.02, y, typeset, ha="left", va="baseline", fontsize=8.5, color="#333333")


# --- Fig. 2 -------------------------------------------------------------------------------------------------


def forces(data: xr.Dataset) -> Figure:
    """F01 and F12 over time in two panels with one time axis; the marked instants run through both."""
    figure = Figure(figsize=(plots.PAGE_WIDTH * 0.85, 4.5))
    lower_first = figure.subplots(2, 1, sharex=True)
    t = data["time"].values * MICRO
    names = (("force_floor", "$F_{01}$ [kN]", 1e-3, RED), ("force_balls", "$F_{12}$ [N]", 1.0, BLUE))
    for ax, (name, label, factor, colour) in zip(lower_first, names, strict=True):
        ax.plot(t, data[name].values * factor, color=colour)
        ax.fill_between(t, data[name].values * factor, color=colour, alpha=0.12, lw=0)
        ax.set_ylabel(label)
        ax.set_ylim(0.0, float(data[name].max()) * factor * 1.12)
    ends = data["end"].values
    first, last = float(data["begin"][0]), float(np.nanmax(ends)) if np.isfinite(ends).any() else np.nan
    t_f = float(data["t_end"])
    same = "{}= t_f" if last == t_f else ""
    marks = [
        (float(data["t_floor_begin"]), "$t_{01}^{(b)}$", "center"),
        (first, "$t_{12}^{(b)}$", "center"),
        (last, f"$t_{{12}}^{{(e)}}{same}$", "right" if last < float(data["t_floor_end"]) else "left"),
        (
            float(data["t_floor_end"]),
            "$t_{01}^{(e)}$",
            "left" if last < float(data["t_floor_end"]) else "right",
        ),
    ]
    for at, label, side in marks:
        if not np.isfinite(at):
            continue
        for ax in lower_first:
            ax.axvline(at * MICRO, color="#555555", lw=0.7, ls=(0, (4, 3)), zorder=0)
        lower_first[0].annotate(
            label,
            (at * MICRO, 1.0),
            (8 if side == "right" else -8 if side == "left" else 0, 3),
            xycoords=("data", "axes fraction"),
            textcoords="offset points",
            ha=side,
            va="bottom",
        )
    for i, (a, b) in enumerate(zip(data["begin"].values, ends, strict=True)):
        inside = (data["time"].values >= a) & (data["time"].values <= b)
        top = float(data["force_balls"].values[inside].max())
        lower_first[1].annotate(
            str(i + 1),
            (0.5 * (a + b) * MICRO, top),
            (0, 2),
            textcoords="offset points",
            ha="center",
            fontsize=9,
        )
    lower_first[0].annotate(
        r"jump to $\gamma_{01}V$",
        (0.0, float(data["force_floor"].sel(time=slice(0.0, None))[1]) * 1e-3),
        (14, -12),
        textcoords="offset points",
        fontsize=8.5,
        arrowprops={"arrowstyle": "-", "lw": 0.6, "color": "#555555"},
    )
    lower_first[0].set_xlim(t[0], t[-1])
    lower_first[-1].set_xlabel("time after the first floor touch [µs]")
    return figure


# --- Figs. 3, 7 and 8: sequences ----------------------------------------------------------------------------


def rows(ax: Axes, data: xr.Dataset, name: str, prefix: str, factor: float, **look: Any) -> None:
    """One horizontal line for every contact, at the height of the parameter."""
    begin, end = data[f"{prefix}begin"].values * factor, data[f"{prefix}end"].values * factor
    y = np.broadcast_to(data[name].values[:, None], begin.shape)
    end = np.where(np.isfinite(begin) & ~np.isfinite(end), ax.get_xlim()[1], end)
    keep = np.isfinite(begin)
    segments = np.stack(
        [np.column_stack([begin[keep], y[keep]]), np.column_stack([end[keep], y[keep]])], axis=1
    )
    ax.add_collection(LineCollection(list(segments), capstyle="butt", **look), autolim=False)


def outlines(ax: Axes, data: xr.Dataset, name: str, prefix: str, factor: float) -> None:
    """The regions in which the balls touch, tinted; a region ends where the number of contacts changes."""
    begin, end = data[f"{prefix}begin"].values * factor, data[f"{prefix}end"].values * factor
    y, count = data[name].values, data[f"{prefix}n_contacts"].values
    for part in runs(count):
        for j in range(int(count[part.start])):
            ax.fill_betweenx(y[part], begin[part, j], end[part, j], color=TINT, lw=0, zorder=0)
            for border in (begin, end):
                ax.plot(border[part, j], y[part], color=EDGE, lw=0.5, zorder=0.5)


def runs(counts: NDArray[Any]) -> list[slice]:
    """Stretches of equal counts."""
    edges = [0, *(np.flatnonzero(np.diff(counts)) + 1), counts.size]
    return [slice(int(a), int(b)) for a, b in pairwise(edges)]


def contacts_over_restitution(data: xr.Dataset) -> Figure:
    """Fig. 3."""
    figure = Figure(figsize=(plots.PAGE_WIDTH * 0.85, 5.6))
    ax = figure.subplots()
    floor_end = float(data["outline_t_floor_end"].max()) * MICRO
    ax.set_xlim(0.0, round(1.45 * floor_end, -2))
    ax.set_ylim(float(data["restitution"].min()) - 0.012, 1.012)
    outlines(ax, data, "restitution_outline", "outline_", MICRO)
    rows(ax, data, "restitution_adiabatic", "adiabatic_", MICRO, colors=GREY, linewidths=0.85)
    rows(ax, data, "restitution", "", MICRO, colors=BLACK, linewidths=0.85)
    thick = data.isel(
        restitution=[int(np.argmin(np.abs(data["restitution"].values - float(data["marked_restitution"]))))]
    )
    rows(ax, thick, "restitution", "", MICRO, colors=BLACK, linewidths=3.4)
    ax.plot(
        data["outline_t_floor_end"].values * MICRO,
        data["restitution_outline"].values,
        color=RED,
        ls=(0, (5, 2.5)),
        lw=1.4,
    )
    _label_spikes(ax, data["spike"].values)
    handles: list[Any] = [
        ax.plot([], [], color=BLACK, lw=1.2, label="Newton’s equations")[0],
        ax.plot([], [], color=GREY, lw=1.2, label="adiabatic (App. A)")[0],
        ax.plot(
            [],
            [],
            color=BLACK,
            lw=3.4,
            label=rf"$\varepsilon={float(data['marked_restitution']):g}$ (Fig. 2)",
        )[0],
        ax.plot([], [], color=RED, lw=1.4, ls=(0, (5, 2.5)), label=r"$t_{01}^{(e)}$, floor contact ends")[0],
    ]
    ax.legend(handles=handles, loc="lower right", title="ball–ball contacts", alignment="left")
    ax.set_xlabel("time after the first floor touch [µs]")
    ax.set_ylabel(EPSILON)
    return figure


def _label_spikes(ax: Axes, tips: NDArray[np.float64]) -> None:
    """The ε of the two uppermost spikes, written above their tips at the right border."""
    right = ax.get_xlim()[1]
    for tip in tips[:2]:
        ax.annotate(
            rf"spike, $\varepsilon<{tip:.3f}$",
            (right, tip),
            (-4, 3),
            textcoords="offset points",
            ha="right",
            va="bottom",
            fontsize=9,
        )


def viscoelastic(data: xr.Dataset) -> Figure:
    """Fig. 7 with its inset."""
    figure = Figure(figsize=(plots.PAGE_WIDTH * 0.85, 5.4))
    ax = figure.subplots()
    floor_end = float(data["outline_t_floor_end"].max()) * MILLI
    ax.set_xlim(0.0, round(2.2 * floor_end))
    ax.set_ylim(float(data["restitution"].min()) - 0.012, 1.012)
    _sequence(ax, data, "restitution", "restitution_outline", "", "outline_", MILLI, 1.3)
    ax.set_xlabel("time after the first floor touch [ms]")
    ax.set_ylabel(rf"{EPSILON} at {float(data['input_speed']):g} m/s")
    inset = ax.inset_axes((0.6, 0.1, 0.375, 0.43))
    floor_end = float(data["inset_outline_t_floor_end"].max()) * MILLI
    inset.set_xlim(0.0, 2.0 * floor_end)
    inset.set_ylim(ax.get_ylim())
    _sequence(
        inset, data, "restitution_inset", "restitution_inset_outline", "inset_", "inset_outline_", MILLI, 0.9
    )
    inset.set_title("geometry of Fig. 3, $Y = 6\\times 10^{9}$ N/m²", fontsize=8.5, pad=3)
    inset.set_xlabel("time [ms]", fontsize=8.5, labelpad=1)
    inset.set_ylabel(r"$\varepsilon$", fontsize=8.5, labelpad=1)
    inset.tick_params(labelsize=8)
    _sequence_legend(ax, "upper right", (1.0, 0.705))
    return figure


def _sequence(
    ax: Axes,
    data: xr.Dataset,
    name: str,
    fine: str,
    prefix: str,
    fine_prefix: str,
    factor: float,
    width: float,
) -> None:
    outlines(ax, data, fine, fine_prefix, factor)
    rows(ax, data, name, prefix, factor, colors="#4d4d4d", linewidths=width)
    ax.plot(data[f"{fine_prefix}t_floor_end"].values * factor, data[fine].values, color=BLACK, lw=1.0)


def _sequence_legend(
    ax: Axes, place: Literal["upper right", "lower right"], corner: tuple[float, float] | None = None
) -> None:
    handles: list[Any] = [
        ax.plot([], [], color="#4d4d4d", lw=1.6, label="ball–ball contacts")[0],
        ax.plot([], [], color=BLACK, lw=1.0, label=r"$t_{01}^{(e)}$, floor contact ends")[0],
    ]
    ax.legend(handles=handles, loc=place, bbox_to_anchor=corner)


def same_material(data: xr.Dataset) -> Figure:
    """Fig. 8, with the restitution of the ball–ball contact on the right axis."""
    figure = Figure(figsize=(plots.PAGE_WIDTH * 0.85, 5.4))
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
    _sequence(ax, scaled, "dissipative_time", "dissipative_time_outline", "", "outline_", MILLI, 1.3)
    ax.set_xlabel("time after the first floor touch [ms]")
    ax.set_ylabel("dissipative time $A$ [µs]")
    ax.tick_params(axis="y", which="both", right=False)
    right = ax.twinx()
    right.set_yscale("log")
    right.set_ylim(ax.get_ylim())
    epsilon = data["restitution_balls"].values
    ticks = [e for e in (0.99, 0.95, 0.9, 0.8, 0.7, 0.5, 0.3, 0.2) if epsilon.min() < e < epsilon.max()]
    right.set_yticks(np.exp(np.interp(ticks, epsilon[::-1], np.log(a[::-1]))), [f"{e:g}" for e in ticks])
    right.minorticks_off()
    right.set_ylabel(r"$\varepsilon_{12}$ at 3 m/s")
    _sequence_legend(ax, "lower right")
    return figure


# --- Fig. 4 -------------------------------------------------------------------------------------------------


def count_maps(data: xr.Dataset) -> Figure:
    """Fig. 4: both maps, one colour for each count."""
    figure = Figure(figsize=(plots.PAGE_WIDTH * 0.8, 7.6))
    top, bottom = figure.subplots(2, 1)
    epsilon = data["restitution"].values
    counts = [data[f"n_contacts_over_{name}"].values.astype(int) for name in ("gap", "radius_ratio")]
    highest = max(int(c.max()) for c in counts)
    cmap, norm = plots.count_colours(max(2, highest))
    panels = (
        (top, data["gap"].values * MILLI, counts[0], float(data["marked_gap"]) * MILLI, "log"),
        (bottom, data["radius_ratio"].values, counts[1], float(data["marked_radius_ratio"]), "linear"),
    )
    for ax, y, n, marked, scale in panels:
        ax.set_yscale(scale)
        mesh = ax.pcolormesh(epsilon, y, n.T, cmap=cmap, norm=norm, shading="nearest", rasterized=True)
        _label_counts(ax, epsilon, y, n, marked)
        ax.axhline(marked, color=BLACK, lw=1.0, ls=(0, (5, 3)))
        for colour, width in (("white", 3.6), (BLACK, 1.8)):
            ax.plot(
                float(data["marked_restitution"]), marked, "+", color=colour, ms=10 + width / 2, mew=width
            )
        ax.set_xlim(epsilon[0], epsilon[-1])
        ax.set_ylim(y[0], y[-1])
        ax.set_xlabel(EPSILON)
        ax.tick_params(which="both", direction="out", top=False, right=False)
    top.set_ylabel(r"initial gap $\Delta h$ [mm]")
    bottom.set_ylabel(r"ratio of radii $R_1/R_2$")
    bottom.axhline(1.0, color=BLACK, lw=1.0)
    bottom.set_yticks([1, 5, 10, 15, 20])
    shown = min(highest, 15)
    bar = figure.colorbar(
        mesh,
        ax=[top, bottom],
        ticks=np.arange(1, shown + 1),
        extend="max" if highest > 15 else "neither",
        aspect=40,
    )
    bar.ax.set_ylim(0.5, shown + 0.5)
    bar.ax.minorticks_off()
    bar.set_label("ball–ball contacts")
    return figure


def _label_counts(ax: Axes, x: NDArray[Any], y: NDArray[Any], counts: NDArray[Any], marked: float) -> None:
    """The counts as numbers in their regions, away from the frame and from the dashed line."""
    away = len(y) // 25
    line = int(np.argmin(np.abs(y - marked)))
    hidden = counts.copy()
    hidden[:, line - away : line + away] = -1 - np.arange(len(x))[:, None]  # too narrow, each, for a label
    inner = slice(away, -away)
    plots.label_regions(ax, x[inner], y[inner], hidden[inner, inner], smallest=0.025)


# --- Figs. 5 and 6: effective restitution -------------------------------------------------------------------


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
    right.step(x, counts, where="mid", color=plots.PALETTE["orange"], lw=1.0)
    ax.axhline(1.0, color="#888888", lw=0.6, zorder=0)
    ax.plot(*broken(x, data["restitution_ratio"].values, counts), color=BLUE, lw=1.4)
    ax.set_ylabel(RATIO, color=BLUE)
    right.set_ylabel("ball–ball contacts", color="#9a6a00")
    ax.tick_params(axis="y", which="both", right=False, colors=BLUE)
    right.tick_params(axis="y", which="both", colors="#9a6a00")
    right.yaxis.set_major_locator(MaxNLocator(integer=True))
    right.yaxis.set_minor_locator(MaxNLocator(1))
    return right


def ratio_over_gap(data: xr.Dataset) -> Figure:
    """Fig. 5: the whole range above, small gaps magnified below."""
    figure = Figure(figsize=(plots.PAGE_WIDTH * 0.85, 6.2))
    top, bottom = figure.subplots(2, 1)
    x = data["gap"].values
    right = ratio_and_counts(top, x * MILLI, data)
    top.set_xlim(0.0, x[-1] * MILLI)
    top.set_ylim(0.0, 1.08)
    most = int(data["n_contacts"].max())
    right.set_ylim(0.0, most * 1.08)
    small = data.sel(gap=slice(None, float(data["magnified_gap"]) * (1 + 1e-12)))
    right = ratio_and_counts(bottom, small["gap"].values * MICRO, small)
    bottom.set_xscale("log")
    bottom.xaxis.set_major_formatter(FormatStrFormatter("%g"))
    bottom.set_xlim(float(small["gap"][0]) * MICRO, float(small["gap"][-1]) * MICRO)
    bottom.set_ylim(0.0, float(small["restitution_ratio"].max()) * 1.08)
    right.set_ylim(0.0, most * 1.08)
    top.set_xlabel(r"initial gap $\Delta h$ [mm]")
    bottom.set_xlabel(r"initial gap $\Delta h$ [µm]")
    return figure


def ratio_over_radii(data: xr.Dataset) -> Figure:
    """Fig. 6 with its inset."""
    figure = Figure(figsize=(plots.PAGE_WIDTH * 0.85, 4.4))
    ax = figure.subplots()
    x = data["radius_ratio"].values
    right = ratio_and_counts(ax, x, data)
    ax.set_xlim(x[0], x[-1])
    ax.set_xticks([1, 5, 10, 15, 20])
    ax.set_ylim(0.0, 1.08)
    most = int(data["n_contacts"].max())
    right.set_ylim(0.0, max(10.0, 2.2 * most))
    right.set_yticks(np.arange(0, most + 1, 2))
    right.set_yticks(np.arange(1, most + 1, 2), minor=True)
    ax.set_xlabel(r"ratio of radii $R_1/R_2$")
    inset = ax.inset_axes((0.44, 0.56, 0.5, 0.36))
    near = data.sel(radius_ratio=slice(1.0, 1.62))
    y = near["restitution_ratio"].values
    inset.axhline(1.0, color="#888888", lw=0.6)
    inset.plot(*broken(near["radius_ratio"].values, y, near["n_contacts"].values), color=BLUE, lw=1.3)
    inset.fill_between(near["radius_ratio"].values, 1.0, np.maximum(y, 1.0), color=BLUE, alpha=0.15, lw=0)
    inset.set_xlim(1.0, 1.6)
    inset.set_ylim(0.9985, 1.0025)
    inset.ticklabel_format(axis="y", useOffset=False)
    inset.tick_params(labelsize=8)
    i = int(np.nanargmax(y))
    inset.annotate(
        f"{y[i]:.4f} at {float(near['radius_ratio'][i]):.2f}",
        (float(near["radius_ratio"][i]), y[i]),
        (-26, 1),
        textcoords="offset points",
        ha="right",
        va="center",
        fontsize=8.5,
    )
    inset.set_xlabel(r"$R_1/R_2$", fontsize=8.5, labelpad=1)
    return figure


# --- density ------------------------------------------------------------------------------------------------


def density(scan: xr.Dataset) -> Figure:
    """The tips of the two uppermost spikes over the density, what the paper prints, and where both agree."""
    with plots.style():
        figure = Figure(figsize=(plots.PAGE_WIDTH * 0.7, 3.4))
        ax = figure.subplots()
        x, holds = scan["density"].values, scan["holds"].values == 1
        near = x[holds] if holds.any() else x
        shown = (x > near[0] - 150.0) & (x < near[-1] + 150.0)
        half = float(scan.attrs["half_digit"])
        for i, (printed, colour) in enumerate(zip(scan["printed"].values, (BLUE, RED), strict=True)):
            ax.axhspan(printed - half, printed + half, color=colour, alpha=0.18, lw=0)
            label = rf"spike at $\varepsilon\approx{printed:g}$ in the paper"
            ax.plot(x[shown], scan["spike"].values[shown, i], color=colour, label=label)
        if holds.any():
            ax.axvspan(near[0], near[-1], color="#888888", alpha=0.25, lw=0)
            ax.annotate(
                f"{0.5 * (near[0] + near[-1]):.0f} ± {0.5 * (near[-1] - near[0]):.0f} kg/m³",
                (near[-1], 0.5),
                (6, 0),
                xycoords=("data", "axes fraction"),
                textcoords="offset points",
                va="center",
            )
        ax.set_xlim(x[shown][0], x[shown][-1])
        ax.set_xlabel("density [kg/m³]")
        ax.set_ylabel(r"$\varepsilon$ at the tip of the spike")
        ax.legend(loc="upper left")
    return figure


DRAWINGS: Final[dict[int, Callable[[Any], Figure]]] = {
    2: forces,
    3: contacts_over_restitution,
    4: count_maps,
    5: ratio_over_gap,
    6: ratio_over_radii,
    7: viscoelastic,
    8: same_material,
}
