"""Fig. 4: the number of ball–ball contacts over ε and Δh, and over ε and R1/R2."""

from __future__ import annotations

import json
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FormatStrFormatter

from ..plots.labels import QUANTITIES
from ..plots.maps import label_regions
from ..plots.style import MAX_COUNTED, PAGE_WIDTH, count_colours
from ..sweep import sweep
from .caption import quantity, typeset
from .drawing import MILLI
from .sampling import Array, Axis, Counts, counts_over, fraction, middles, variable
from .setup import GAP, RADIUS_RATIO, RESTITUTION, Paper
from .statement import Outcome, Statements, about

TITLE: Final = "Number of ball–ball contacts"
CHOICES: Final = (
    "The axes are chosen here: ε from 0.05 to 1, Δh from 0.1 µm to 10 mm (logarithmic), R1/R2 from 0.2 to 20."
)
WEIGHT: Final = 20.0
STATEMENTS: Final = Statements()

POINTS = 600
RESTITUTIONS: Final = (0.05, 1.0)
GAPS: Final = (1e-7, 1e-2)
RATIOS: Final = (0.2, 20.0)
VARIABLES: Final = ("n_contacts", "relative_velocity", "restitution_ratio", "outcome")

#: A statement on the maps is a mean over ROWS rows with FINE points each: spikes are narrow. With more of
#: either, the fractions change by less than the rounding of :func:`about`.
ROWS: Final = 60
FINE: Final = 3000


def parameters(paper: Paper) -> dict[str, str | float]:
    return paper.parameters(paper.linear(), "restitution", "gap_m", "radius_1_m")


def compute(paper: Paper) -> xr.Dataset:
    """Both maps, ``POINTS`` × ``POINTS``."""
    axes = {"gap": np.geomspace(*GAPS, POINTS), "radius_ratio": np.linspace(*RATIOS, POINTS)}
    maps = []
    for i, (name, values) in enumerate(axes.items()):
        swept: dict[str, Any] = {"restitution": np.linspace(*RESTITUTIONS, POINTS), name: values}

        def report(done: int, total: int, half: int = i) -> None:
            paper.progress(0.5 * (half + done / total))

        dataset = sweep(paper.linear(), variables=VARIABLES, progress=report, **swept)
        maps.append(dataset.rename({key: f"{key}_over_{name}" for key in VARIABLES}))
    data = xr.merge(maps, combine_attrs="override")
    data["marked_restitution"] = variable((), RESTITUTION, "1", "ε of Fig. 2, the +")
    data["marked_gap"] = variable((), GAP, "m", "Δh of Figs. 2 and 3, dashed")
    data["marked_radius_ratio"] = variable((), RADIUS_RATIO, "1", "R1/R2 of Figs. 2 and 3, dashed")
    return data


def axes(data: xr.Dataset, name: str) -> tuple[Axis, Axis]:
    """ε and the other axis of a map; the gap is logarithmic, as drawn."""
    return (data["restitution"].values, False), (data[name].values, name == "gap")


def meaning(data: xr.Dataset) -> str:
    single = data["n_contacts_over_gap"].values == 1
    close = np.abs(data["restitution_ratio_over_gap"].values - 1.0) < 0.05
    right = 100.0 * fraction(single & close, *axes(data, "gap")) / fraction(single, *axes(data, "gap"))
    return (
        f"Where the count is not 1, an event-driven simulation has the wrong sequence of contacts. Where it is 1, the "
        f"result may be wrong as well: in the upper map, the effective restitution is right to 5 % in only {right:.0f} "
        f"% of the area with one contact."
    )


def highest(paper: Paper, name: str) -> tuple[float, str]:
    """The largest ε_eff/ε on a map, and its position.

    The map gives ε of the maximum. The ridge is narrower than a cell, so this ε is sampled again with finer steps.
    """
    maps = paper.figure(4)
    values = maps[f"restitution_ratio_over_{name}"].values
    epsilon = float(maps["restitution"].values[np.nanargmax(np.nanmax(values, axis=1))])
    fine = np.geomspace(*GAPS, FINE) if name == "gap" else np.linspace(*RATIOS, FINE)
    swept: dict[str, Any] = {name: fine}
    dataset = sweep(paper.linear(epsilon), variables=["restitution_ratio"], **swept)
    row = dataset["restitution_ratio"].values
    i = int(np.nanargmax(row))
    where = f"Δh = {fine[i] * 1e3:.2f} mm" if name == "gap" else f"R1/R2 = {fine[i]:.2f}"
    return float(row[i]), f"at ε = {epsilon:.2f}, {where}"


# --- drawing ------------------------------------------------------------------------------------------------


STROKE: Final = [withStroke(linewidth=2.2, foreground="white")]


def draw(data: xr.Dataset) -> Figure:
    """Both maps, one colour for each count; the drops of Figs. 2 and 3 are marked."""
    figure = Figure(figsize=(PAGE_WIDTH * 0.8, 8.0))
    top, bottom = figure.subplots(2, 1)
    counts = [data[f"n_contacts_over_{name}"].values.astype(int) for name in ("gap", "radius_ratio")]
    lowest, highest = min(int(c.min()) for c in counts), max(int(c.max()) for c in counts)
    cmap, norm = count_colours(highest, lowest)
    gap, ratio = float(data["marked_gap"]), float(data["marked_radius_ratio"])
    top.set_yscale("log")
    mesh = _draw_map(top, data, data["gap"].values * MILLI, counts[0], gap * MILLI, cmap=cmap, norm=norm)
    _draw_map(bottom, data, data["radius_ratio"].values, counts[1], ratio, cmap=cmap, norm=norm)
    top.yaxis.set_major_formatter(FormatStrFormatter("%g"))
    top.set_ylabel(rf"{QUANTITIES['gap'][0]} [mm]")
    bottom.set_ylabel(QUANTITIES["radius_ratio"][0])
    bottom.set_yticks([1, 5, 10, 15, 20])
    bottom.axhline(1.0, color="black", lw=1.0, path_effects=STROKE)
    upper = float(json.loads(data.attrs["parameters"])["radius_2_m"])
    top.set_title(typeset(f"(a)  R1 = {quantity(ratio * upper, 'm')}"), loc="left", pad=4)
    bottom.set_title(typeset(f"(b)  Δh = {quantity(gap, 'm')}"), loc="left", pad=4)
    _name_line(top, gap * MILLI, "Δh of Fig. 3")
    _name_line(bottom, ratio, "R1/R2 of Fig. 3")
    _name_line(bottom, 1.0, "R1 = R2")
    shown = np.arange(lowest, min(highest, MAX_COUNTED) + 1)
    extend = "max" if highest > MAX_COUNTED else "neither"
    bar = figure.colorbar(mesh, ax=[top, bottom], ticks=shown, extend=extend, aspect=40)
    bar.ax.minorticks_off()
    bar.set_label(QUANTITIES["n_contacts"][0])
    return figure


def _draw_map(ax: Axes, data: xr.Dataset, y: Array, counts: Counts, marked: float, **colours: Any) -> Any:
    """One map with the dashed line of Fig. 3 and the + of Fig. 2; returns the mesh for the colour bar."""
    epsilon, drop = data["restitution"].values, float(data["marked_restitution"])
    mesh = ax.pcolormesh(epsilon, y, counts.T, shading="nearest", rasterized=True, **colours)
    ax.axhline(marked, color="black", lw=1.0, ls=(0, (5, 3)), path_effects=STROKE)
    for colour, width in (("white", 3.6), ("black", 1.8)):
        ax.plot(drop, marked, "+", color=colour, ms=10 + width / 2, mew=width)
    ax.annotate("Fig. 2", (drop, marked), (7, 7), textcoords="offset points", fontsize=9, path_effects=STROKE)
    ax.set_xlim(epsilon[0], epsilon[-1])
    ax.set_ylim(y[0], y[-1])
    ax.set_xlabel(QUANTITIES["restitution"][0])
    ax.tick_params(which="both", direction="out", top=False, right=False)
    _label_counts(ax, epsilon, y, counts, marked)
    return mesh


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


def _label_counts(ax: Axes, x: Array, y: Array, counts: Counts, marked: float) -> None:
    """The counts as numbers in their regions, away from the frame and from lines and their names."""
    away = len(y) // 25
    hidden = counts.copy()
    for line in (marked, 1.0) if ax.get_yscale() == "linear" else (marked,):
        at = int(np.argmin(np.abs(y - line)))
        hidden[:, max(at - away, 0) : at + 2 * away] = -1
    for frame in (hidden[:away], hidden[-away:], hidden[:, :away], hidden[:, -away:]):
        frame[:] = -1
    label_regions(ax, x, y, hidden)


# --- statements ---------------------------------------------------------------------------------------------


@STATEMENTS.add(
    "For each ε some interval of Δh gives the most contacts; the number grows as Δh falls, up to a maximum",
    "Sec. IV A, Fig. 4",
    4,
)
def _maximum_over_gap(paper: Paper) -> Outcome:
    epsilon = middles(*RESTITUTIONS, ROWS)
    gaps = np.geomspace(*GAPS, FINE)
    counts = counts_over(paper.linear(), restitution=epsilon, gap=gaps)
    grows, single = [], []
    for column in counts:
        at_most = np.flatnonzero(column == column.max())
        grows.append(bool(np.all(np.diff(column[at_most[-1] :]) <= 0)))
        single.append(bool(at_most[-1] - at_most[0] + 1 == at_most.size))
    i, j = np.unravel_index(int(np.argmax(counts)), counts.shape)
    text = (
        f"growing from 10 mm down to the maximum for {about(float(np.mean(grows)))} of the ε of Fig. 4, the "
        f"maximum in one interval of Δh for {about(float(np.mean(single)))}; most contacts: {counts.max()}, at ε = "
        f"{epsilon[i]:.3f}, Δh = {gaps[j] * 1e6:.1f} µm"
    )
    return text, all(grows), all(single)


@STATEMENTS.add("t_c,01/t_c,12 grows with m1/m2", "Sec. IV A")
def _durations(paper: Paper) -> Outcome:
    ratios = []
    for radii in (1.0, 2.0, 5.0, 10.0, 20.0):
        floor, pair = paper.linear(0.7, radius_ratio=radii).contacts
        ratios.append(floor.duration() / pair.duration())
    shown = ", ".join(f"{ratio:.2f}" for ratio in ratios)
    return (f"{shown} at R1/R2 = 1, 2, 5, 10, 20", bool(np.all(np.diff(ratios) > 0)))


@STATEMENTS.add(
    "The number of contacts grows with R1/R2, the dominant of two effects", "Sec. IV A, Fig. 4", 4
)
def _grows_with_ratio(paper: Paper) -> Outcome:
    epsilon = middles(*RESTITUTIONS, ROWS)
    ratios = np.linspace(*RATIOS, FINE)
    counts = counts_over(paper.linear(), restitution=epsilon, radius_ratio=ratios)
    never_falls = float(np.mean(np.all(np.diff(counts, axis=1) >= 0, axis=1)))
    ends_higher = float(np.mean(counts[:, -1] > counts[:, 0]))
    text = (
        f"higher at {ratios[-1]:g} than at {ratios[0]:g} for {about(ends_higher)} of the ε of Fig. 4; "
        f"without falling in between for {about(never_falls)}"
    )
    return text, ends_higher > 0.9, never_falls > 0.5
