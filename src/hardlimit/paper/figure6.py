"""Fig. 6: ε_eff/ε over R1/R2 at ε = 0.8, and the number of contacts."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..plots.labels import QUANTITIES
from ..plots.style import PAGE_WIDTH
from ..sweep import sweep
from . import figure4, figure5
from .drawing import BLUE, RATIO, broken, count_ticks, ratio_and_counts
from .sampling import counts_of, fraction, refine
from .setup import RADIUS_RATIO, Paper
from .statement import Outcome, Statements

TITLE: Final = "Effective restitution over the ratio of radii"
CHOICES: Final = "The range of R1/R2, 1 to 20, is chosen here."
WEIGHT: Final = 1.0
STATEMENTS: Final = Statements()

RESTITUTION: Final = 0.8
RATIOS: Final = (1.0, 20.0)


def parameters(paper: Paper) -> dict[str, str | float]:
    return paper.parameters(paper.linear(RESTITUTION), "radius_1_m")


def compute(paper: Paper) -> xr.Dataset:
    """One curve with dense points at every jump and in the range of the inset."""
    column = paper.linear(RESTITUTION)
    grid = np.concatenate([np.linspace(*RATIOS, 2000), np.linspace(1.0, 1.7, 701)])
    ratio = refine(counts_of(column, "radius_ratio"), grid)
    wanted = ["n_contacts", "relative_velocity", "restitution_ratio", "t_end"]
    data = sweep(column, radius_ratio=ratio, variables=wanted)
    data["n_contacts"] = data["n_contacts"].astype(np.int64)
    return data


def above_one(data: xr.Dataset) -> tuple[float, float, float, float]:
    """First and last R1/R2 with a ratio above 1, position and value of the maximum (NaN if never above 1)."""
    x, y = data["radius_ratio"].values, data["restitution_ratio"].values
    above = np.flatnonzero(y > 1.0)
    if above.size == 0:
        return (math.nan,) * 4
    i = int(np.nanargmax(y))
    return float(x[above[0]]), float(x[above[-1]]), float(x[i]), float(y[i])


def meaning(data: xr.Dataset) -> str:
    good = np.abs(data["restitution_ratio"].values - 1.0) <= 0.01
    first_bad = int(np.argmin(good)) if not good.all() else good.size - 1
    at_ten = float(np.interp(RADIUS_RATIO, data["radius_ratio"], data["restitution_ratio"]))
    return (
        f"Event-driven simulations are least accurate for unequal balls: at this gap they are right to one per cent "
        f"only up to R1/R2 = {float(data.radius_ratio[first_bad]):.2f}, and at R1/R2 = {RADIUS_RATIO:g} the effective "
        f"restitution is {at_ten:.2f} times the specified one."
    )


# --- drawing ------------------------------------------------------------------------------------------------


def draw(data: xr.Dataset) -> Figure:
    """The curve with its inset."""
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
    text = f"maximum {y[i]:.4f} at $R_1/R_2={x[i]:.2f}$"
    inset.text(0.04, 0.93, text, transform=inset.transAxes, va="top", fontsize=8.5)
    inset.set_xlabel("$R_1/R_2$", fontsize=8.5, labelpad=1)
    inset.set_ylabel(RATIO, fontsize=8.5, labelpad=2)


# --- statements ---------------------------------------------------------------------------------------------


@STATEMENTS.add("ε_eff/ε falls with growing R1/R2, as the contacts become more", "Sec. IV B, Fig. 6", 6)
def _falls_with_ratio(paper: Paper) -> Outcome:
    figure = paper.figure(6)
    ratio, counts = figure["restitution_ratio"].values, figure["n_contacts"].values
    peaks = [float(ratio[counts == n].max()) for n in np.unique(counts)]
    overall = bool(np.all(np.diff(peaks) < 0))
    monotone = bool(np.all(np.diff(ratio) <= 1e-9))
    shown = ", ".join(f"{p:.3f}" for p in peaks[:5])
    return (
        f"its maximum at 1, 2, 3, … contacts falls: {shown} …; "
        + ("it never rises" if monotone else "but it jumps to ≈ 0 at each new contact and rises from there"),
        overall,
        monotone,
    )


@STATEMENTS.add("For most parameters several contacts dissipate more: ε_eff/ε < 1", "Sec. IV B", 4, 5, 6)
def _most(paper: Paper) -> Outcome:
    maps, radii = paper.figure(4), paper.figure(6)
    fractions, highest = [], 0.0
    for name in ("gap", "radius_ratio"):
        several = maps[f"n_contacts_over_{name}"].values > 1
        fractions.append(fraction(several, *figure4.axes(maps, name)))
        ratio = maps[f"restitution_ratio_over_{name}"].values[several]
        highest = max(highest, float(np.nanmax(ratio, initial=0.0)))
    fractions.append(fraction(radii["n_contacts"].values > 1, (radii["radius_ratio"].values, False)))
    holds = [highest < 1.0, *(part > 0.5 for part in fractions)]
    upper, lower, radii_of_figure = (f"{100 * part:.0f} %" for part in fractions)
    return (
        f"several contacts on {upper} of the upper map of Fig. 4 (Δh logarithmic), {lower} of the lower one, and "
        f"{radii_of_figure} of the R1/R2 of Fig. 6; with several contacts ε_eff/ε is at most {highest:.3f} on the maps",
        *holds,
    )


@STATEMENTS.add(
    "Near R1 = R2 dissipation is reduced: a small interval with ε_eff/ε > 1", "Sec. IV B, Fig. 6", 6
)
def _reduced(paper: Paper) -> Outcome:
    low, high, at, top = above_one(paper.figure(6))
    interval = f"above 1 from R1/R2 = {low:.2f} to {high:.2f}, at most {top:.4f} at {at:.2f}"
    shown = f"ε = {RESTITUTION:g}: {interval}"
    return (shown if top > 1.0 else "nowhere above 1", top > 1.0, high - low < 1.0)


@STATEMENTS.add("Only in that interval near R1 = R2 is ε_eff > ε", "Sec. IV B", 4, 5, 6)
def _only_there(paper: Paper) -> Outcome:
    figure, maps = paper.figure(5), paper.figure(4)
    ratio, gap = figure["restitution_ratio"].values, figure["gap"].values
    above = gap[ratio > 1.0]
    radii = paper.figure(6)["restitution_ratio"].values
    one_interval = int(np.sum(np.diff((radii > 1.0).astype(int)) == 1)) <= 1
    elsewhere = "nowhere in Fig. 5"
    if above.size:
        elsewhere = f"also for every Δh above {above[0] * 1e3:.2f} mm in Fig. 5 (up to {ratio.max():.4f})"
    on_maps = []
    for name in ("gap", "radius_ratio"):
        values = maps[f"restitution_ratio_over_{name}"].values
        on_maps.append((fraction(values > 1.0, *figure4.axes(maps, name)), *figure4.highest(paper, name)))
    (upper, upper_top, _), (lower, lower_top, where) = on_maps
    return (
        f"{elsewhere}, on {100 * upper:.0f} % of the upper map of Fig. 4 (up to {upper_top:.4f}) and "
        f"{100 * lower:.0f} % of the lower one (up to {lower_top:.2f}, {where}); within Fig. 6, "
        + ("nowhere else" if one_interval else "also elsewhere"),
        one_interval,
        above.size == 0,
        upper == 0.0,
    )


@STATEMENTS.add("ε_eff/ε takes any value from almost 0 to slightly above 1", "Sec. V, Figs. 5–6", 4, 5, 6)
def _range(paper: Paper) -> Outcome:
    curves = [paper.figure(n)["restitution_ratio"].values for n in (5, 6)]
    both = np.sort(np.concatenate(curves))
    gap = int(np.argmax(np.diff(both)))
    (upper, _), (lower, where) = (figure4.highest(paper, name) for name in ("gap", "radius_ratio"))
    shown = "; ".join(
        f"Fig. {n} (ε = {epsilon:g}): {curve.min():.1e} to {curve.max():.4f}"
        for n, epsilon, curve in zip((5, 6), (figure5.RESTITUTION, RESTITUTION), curves, strict=True)
    )
    holds = (
        both[0] < 0.01,
        1.0 < both[-1] < 1.05,
        both[gap + 1] - both[gap] < 0.01,
        max(upper, lower) < 1.05,
    )
    return (
        f"{shown}; neither has a value between {both[gap]:.3f} and {both[gap + 1]:.3f}. Maps of Fig. 4: up to "
        f"{upper:.4f} on the upper and {lower:.2f} on the lower one ({where})",
        *map(bool, holds),
    )
