"""Fig. 3: begin and end of every ball–ball contact over ε; Newton's equations and the adiabatic solution."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..column.solvers import adiabatic, newton
from ..plots.labels import QUANTITIES
from ..plots.style import PAGE_WIDTH
from . import figure4
from .drawing import BLACK, FLOOR_END, MICRO, RED, TIME, draw_outlines, draw_rows, line, outline
from .sampling import (
    Array,
    ball_contacts,
    counts_of,
    counts_over,
    fraction,
    late_contacts,
    maxima,
    middles,
    refine,
    sequences,
    successive,
    variable,
)
from .setup import RESTITUTION, Paper
from .statement import Outcome, Statements, about, near

TITLE: Final = "Sequence of contacts over the coefficient of restitution"
CHOICES: Final = "The range of ε and of the time is chosen here."
WEIGHT: Final = 1.5
STATEMENTS: Final = Statements()

LOWEST: Final = 0.1


def parameters(paper: Paper) -> dict[str, str | float]:
    return paper.parameters(paper.linear(), "restitution")


def compute(paper: Paper) -> xr.Dataset:
    """Newton's equations at every 0.01 of ε, the adiabatic solution halfway between; fine outlines of both."""
    rows = np.round(np.arange(LOWEST, 1.005, 0.01), 10)
    column = paper.linear()
    fine = np.linspace(LOWEST, 1.0, 901)
    outline = refine(counts_of(column, "restitution"), fine)
    fine_adiabatic = refine(counts_of(column, "restitution", "adiabatic"), fine)
    parts = [
        sequences("restitution", rows, paper.linear),
        sequences("restitution_adiabatic", rows[:-1] + 0.005, paper.linear, adiabatic, prefix="adiabatic_"),
        sequences("restitution_outline", outline, paper.linear, prefix="outline_"),
        sequences("restitution_fine", fine_adiabatic, paper.linear, adiabatic, prefix="fine_adiabatic_"),
    ]
    data = xr.merge(parts, join="exact")
    data["marked_restitution"] = variable((), RESTITUTION, "1", "ε of Fig. 2, the thick line")
    for prefix, name in (("outline_", "spike"), ("fine_adiabatic_", "adiabatic_spike")):
        data[name] = variable(name, np.array(_tips(data, prefix)), "1", "ε at the tip of a spike")
    return data


def _tips(data: xr.Dataset, prefix: str) -> list[float]:
    """The spike tips: ε below which the balls meet once more after the floor contact, highest first."""
    name = str(data[f"{prefix}n_contacts"].dims[0])
    return [high for _, high in reversed(late_contacts(name, data, prefix)) if high < 1.0]


def meaning(data: xr.Dataset) -> str:
    n = data["outline_n_contacts"].values
    return (
        f"An event-driven simulation has one contact on every line. Newton’s equations have {n.min()} to {n.max()}; "
        f"the number changes in jumps, so a small error of ε can change the whole motion."
    )


# --- drawing ------------------------------------------------------------------------------------------------

HEIGHT: Final = 5.9  #: [inch]
GREY: Final = "#a3a3a3"
DASHES: Final = (0, (5, 2.5))


def draw(data: xr.Dataset) -> Figure:
    figure = Figure(figsize=(PAGE_WIDTH * 0.85, HEIGHT))
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
        line("Newton’s equations, every 0.01 of $\\varepsilon$", color=BLACK, lw=1.2),
        outline(),
        line("adiabatic (App. A), in between", color=GREY, lw=1.2),
        line(rf"$\varepsilon={marked:g}$ (Fig. 2)", color=BLACK, lw=3.4),
        line(FLOOR_END, color=RED, lw=1.4, ls=DASHES),
    ]
    ax.legend(handles=handles, loc="lower right", title="ball–ball contacts", alignment="left")
    ax.set_xlabel(f"{TIME} [µs]")
    ax.set_ylabel(QUANTITIES["restitution"][0])
    return figure


def _label_spikes(ax: Axes, tips: Array) -> None:
    """The ε of the spike tips at the right border; tips too close for two lines share a label."""
    inches = 0.75 * HEIGHT  # approximate height of the axes
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
            (-14, -4 if several else 3),  # clear of the ticks; a common label is below the lowest
            textcoords="offset points",
            ha="right",
            va="top" if several else "bottom",
            fontsize=9,
        )


# --- statements ---------------------------------------------------------------------------------------------


@STATEMENTS.add("The last contact may end before or after the floor contact", "Sec. IV A, Fig. 3", 3)
def _either_order(paper: Paper) -> Outcome:
    figure = paper.figure(3)
    epsilon = figure["restitution_outline"].values
    late = figure["outline_t_end"].values > figure["outline_t_floor_end"].values
    after = fraction(late, (epsilon, False))
    text = f"after it for {100 * after:.1f} % of the ε from {epsilon[0]:g} to {epsilon[-1]:g}"
    return text, 0.0 < after < 1.0


@STATEMENTS.add("3 contacts at ε = 1", "Sec. IV A, Fig. 3")
def _elastic(paper: Paper) -> Outcome:
    n = newton(paper.linear(1.0)).n_contacts
    return (f"{n} contacts", n == 3)


@STATEMENTS.add("At a large gap one contact remains", "Sec. IV A")
def _large_gap(paper: Paper) -> Outcome:
    counts = {gap: newton(paper.linear(1.0, gap=gap)).n_contacts for gap in (1e-4, 1e-3, 1e-2)}
    shown = ", ".join(f"{n} at {gap * 1e3:g} mm" for gap, n in counts.items())
    return (f"ε = 1: {shown}", counts[1e-2] == 1)


@STATEMENTS.add(
    "From ε = 1 downwards the number of contacts first grows, then falls: one maximum", "Sec. IV A, Fig. 3", 3
)
def _one_maximum(paper: Paper) -> Outcome:
    counts = paper.figure(3)["outline_n_contacts"].values
    path = successive(counts[::-1])
    return (f"{', '.join(map(str, path))} contacts as ε falls from 1 to 0.1", maxima(counts) == 1)


@STATEMENTS.add(
    "The same for every set of parameters: the number over ε has a single maximum", "Sec. IV A", 7
)
def _one_maximum_everywhere(paper: Paper) -> Outcome:
    linear = paper.linear()
    gaps = middles(*figure4.GAPS, figure4.ROWS, logarithmic=True)
    ratios = middles(*figure4.RATIOS, figure4.ROWS)
    epsilon = np.linspace(*figure4.RESTITUTIONS, figure4.FINE)
    by_gap = np.array([maxima(row) for row in counts_over(linear, gap=gaps, restitution=epsilon)])
    by_ratio = np.array(
        [maxima(row) for row in counts_over(linear, radius_ratio=ratios, restitution=epsilon)]
    )
    single = float(np.mean(by_gap == 1)), float(np.mean(by_ratio == 1))
    most = f"{by_gap.max()} maxima at Δh = {gaps[int(np.argmax(by_gap))] * 1e6:.2f} µm"
    hertz = maxima(paper.figure(7)["outline_n_contacts"].values)
    text = (
        f"linear: one maximum for {about(single[0])} of the Δh (logarithmic) and {about(single[1])} "
        f"of the R1/R2 of Fig. 4; {most}; viscoelastic (Fig. 7): {hertz} maxima"
    )
    return text, min(single) == 1.0 and hertz == 1, min(single) > 0.5


@STATEMENTS.add("The duration of a contact depends only weakly on ε", "Sec. IV A")
def _weakly(paper: Paper) -> Outcome:
    def duration(epsilon: float) -> float:
        return float(paper.linear(epsilon).contacts[1].duration())

    changes = {epsilon: 1.0 - duration(epsilon) / duration(1.0) for epsilon in (0.9, 0.7, 0.5, 0.3)}
    shown = ", ".join(f"{100 * change:.0f} % at {epsilon:g}" for epsilon, change in changes.items())
    return (f"shorter than at ε = 1 by {shown}", changes[0.7] < 0.1, changes[0.5] < 0.1, changes[0.3] < 0.1)


@STATEMENTS.add(
    "The adiabatic solution agrees perfectly with the numerical one at R1/R2 = 10", "Sec. IV A, Fig. 3", 3
)
def _adiabatic(paper: Paper) -> Outcome:
    grid = np.linspace(0.1, 1.0, 1801)
    both = [counts_over(paper.linear(), model, restitution=grid) for model in ("newton", "adiabatic")]
    same = float(np.mean(both[0] == both[1]))
    worst = 0.0
    for epsilon in grid[both[0] == both[1]][::20]:
        column = paper.linear(float(epsilon))
        exact = newton(column)
        spans = ball_contacts(exact)
        early = spans[0] < exact.t_floor_end  # later contacts differ without limit near the tip of a spike
        for mine, other in zip(spans, ball_contacts(adiabatic(column)), strict=True):
            deviation = np.abs(mine - other)[early]
            worst = max(worst, float(deviation.max(initial=0.0)) / exact.t_floor_end)
    tips = paper.figure(3)
    both_tips = tips["spike"].values[:1], tips["adiabatic_spike"].values[:1]
    shift = float(np.abs(both_tips[0] - both_tips[1]).max(initial=0.0))
    text = (
        f"equal counts for {100 * same:.1f} % of the ε from 0.1 to 1; contacts that begin during the floor "
        f"contact within {100 * worst:.2f} % of its duration; first spike shifted by {shift:.4f} in ε"
    )
    return text, worst < 0.01, same > 0.999


@STATEMENTS.add("The adiabatic solution becomes exact for R1 ≫ R2", "App. A")
def _order(paper: Paper) -> Outcome:
    errors, masses = [], []
    for upper in (0.01, 0.005, 0.0025):
        column = paper.linear(0.7, radius_2=upper)
        parted = []
        for solve in (newton, adiabatic):
            result = solve(column)
            after = result.trajectory(result.contacts["end"].values[1])["velocity"].values[0]
            parted.append(after[1] - after[0])
        errors.append(abs(parted[0] - parted[1]) / column.impact_speed)
        masses.append(column.balls[1].mass / column.balls[0].mass)
    order = math.log(errors[0] / errors[-1]) / math.log(masses[0] / masses[-1])
    return (
        f"v2 − v1 after the first contact off by {errors[0]:.1e}, {errors[1]:.1e}, {errors[2]:.1e} V at "
        f"R1/R2 = 10, 20, 40: ∝ (m2/m1)^{order:.2f}",
        errors[0] > errors[1] > errors[2],
    )


@STATEMENTS.add(
    "Spikes at ε ≈ 0.78 and 0.67, where the balls meet once more after the floor contact",
    "Sec. IV A, Fig. 3",
    3,
)
def _spikes(paper: Paper) -> Outcome:
    tips = paper.figure(3)["spike"].values
    shown = ", ".join(f"{tip:.4f}" for tip in tips)
    text = f"tips at {shown or 'no ε'}"
    return text, tips.size > 0 and near(tips[0], 0.78, 0.005), tips.size > 1 and near(tips[1], 0.67, 0.005)
