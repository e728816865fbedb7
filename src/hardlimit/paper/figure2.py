"""Fig. 2: the forces on the floor and between the balls over time, at ε = 0.7."""

from __future__ import annotations

from typing import Final

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter

from ..column.solvers import independent, newton
from ..plots.style import PAGE_WIDTH, pair_colour, pair_label
from .drawing import KILO, MICRO
from .sampling import ball_contacts, variable
from .setup import Paper
from .statement import Outcome, Statements, near

TITLE: Final = "Forces during one drop"
CHOICES: Final = ""
WEIGHT: Final = 1.0
STATEMENTS: Final = Statements()


def parameters(paper: Paper) -> dict[str, str | float]:
    return paper.parameters(paper.linear())


def compute(paper: Paper) -> xr.Dataset:
    """F01 and F12 over time, sampled on both sides of every jump, and the five marked instants."""
    column = paper.linear()
    result = newton(column)
    begin, end = ball_contacts(result)
    marks = np.concatenate([result.contacts["begin"].values, result.contacts["end"].values])
    span = float(np.nanmax(marks))
    apart = 1e-9 * span  # the force jumps at a first touch: one sample just before, one just after
    grid = np.linspace(-0.05 * span, 1.06 * span, 1600)
    times = np.unique(np.concatenate([grid, marks, marks - apart, marks + apart]))
    force = result.trajectory(times)["force"]
    single = independent(column).relative_velocity
    return xr.Dataset(
        {
            "force_floor": variable("time", force.sel(pair=0).values, "N", "F01, floor on lower ball"),
            "force_balls": variable("time", force.sel(pair=1).values, "N", "F12, between the balls"),
            "begin": variable("contact", begin, "s", "begin of a ball–ball contact"),
            "end": variable("contact", end, "s", "end of a ball–ball contact"),
            "t_floor_begin": variable((), 0.0, "s", "t01(b), first floor touch"),
            "t_floor_end": variable((), result.t_floor_end, "s", "t01(e), end of the floor contact"),
            "t_end": variable((), result.t_end, "s", "t_f, end of the sequence"),
            "relative_velocity": variable((), result.relative_velocity, "m/s", "v2 − v1 at t_f"),
            "separation_velocity": variable(
                (), result.separation_velocity, "m/s", "v2 − v1 once no force acts"
            ),
            "relative_velocity_independent": variable(
                (), single, "m/s", "v2 − v1 of the independent-collisions model"
            ),
        },
        coords={"time": variable("time", times, "s")},
    )


def meaning(data: xr.Dataset) -> str:
    n = data.sizes["contact"]
    return (
        f"An event-driven simulation makes one ball–ball collision of this drop and separates the balls at "
        f"{float(data.relative_velocity_independent):.2f} m/s; Newton’s equations have {n} contacts, and a "
        f"relative velocity of {float(data.relative_velocity):.2f} m/s after the last."
    )


# --- drawing ------------------------------------------------------------------------------------------------


def draw(data: xr.Dataset) -> Figure:
    """F01 and F12 in two panels with a common time axis; the marked instants run through both."""
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
    """Begin and end of the floor contact and of the sequence, as dashed lines with names above."""
    ends = data["end"].values
    first, last = float(data["begin"][0]), float(np.nanmax(ends)) if np.isfinite(ends).any() else np.nan
    floor_end = float(data["t_floor_end"])
    same = "{}= t_f" if last == float(data["t_end"]) else ""
    # The two ends lie close together: the earlier name is set to the left, the later one to the right.
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
        floor.annotate(
            label,
            (at * MICRO, 1.0),
            ({"right": -2, "left": 2}.get(side, 0), 3),
            xycoords=("data", "axes fraction"),
            textcoords="offset points",
            ha=side,
            va="bottom",
        )


def _number_contacts(ax: Axes, data: xr.Dataset) -> None:
    """1, 2, 3, … above the ball–ball contacts."""
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


# --- statements ---------------------------------------------------------------------------------------------


@STATEMENTS.add("F01 jumps to a finite value at the first touch", "Sec. IV A, Fig. 2", 2)
def _jump(paper: Paper) -> Outcome:
    force = paper.figure(2)["force_floor"]
    at = float(force.sel(time=slice(0.0, None))[1])
    before = float(force.sel(time=slice(None, -1e-15))[-1])
    column = paper.linear()
    damping = column.contacts[0].damping * column.impact_speed
    text = f"from {before:g} to {at / 1e3:.3f} kN; γ01 V = {damping / 1e3:.3f} kN"
    return text, near(at, damping, 1e-3 * damping)


@STATEMENTS.add("The balls touch several times during one floor contact", "Sec. IV A, Fig. 2", 2)
def _several(paper: Paper) -> Outcome:
    figure = paper.figure(2)
    inside = int(np.sum(figure["end"].values < float(figure["t_floor_end"])))
    return (
        f"{figure.sizes['contact']} contacts, {inside} of them within the floor contact; the last ends at "
        f"{float(figure.t_end) * 1e6:.3f} µs, the floor contact at {float(figure.t_floor_end) * 1e6:.3f} µs",
        inside > 1,
    )
