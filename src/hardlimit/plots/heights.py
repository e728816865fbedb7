"""Plots of a drop: heights of the balls from release to the tops of their flights, and the contact forces."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, FigureBase
from numpy.typing import NDArray

from ..column.models import MODELS
from ..column.result import Result
from .forces import draw_forces, pairs_of, spread, unresolved, window
from .labels import LOOKS, scaled
from .style import PAGE_WIDTH, ball_colour, style

MAX_NAMED = 6  #: the legend lists the balls of columns up to this number


def heights(*results: Result, until: float | None = None) -> Figure:
    """Heights of the centres over time; full lines Newton, dashed independent collisions.

    ``until`` [s] defaults to a little after the last ball has reached the top of its flight under every model.
    """
    with style():
        figure = Figure(figsize=(PAGE_WIDTH * 0.72, 3.9))
        ax = figure.subplots()
        draw_heights(ax, results, until)
        add_legend(figure, ax, 2)
        if note := unresolved(results):
            figure.suptitle(note, fontsize="medium")
    return figure


def drop(newton: Result, independent: Result, adiabatic: Result | None = None) -> Figure:
    """Forces during the contacts, and heights from release to the tops of the flights.

    Grey arrows are the instants of the independent-collisions model.
    """
    results = tuple(r for r in (newton, independent, adiabatic) if r is not None)
    with style():
        pairs = pairs_of(newton)
        figure = Figure(figsize=(PAGE_WIDTH, max(4.1, 1.2 + 1.3 * len(pairs))))
        parts: Any = figure.subfigures(1, 2, width_ratios=(1.0, 1.0), wspace=0.04)
        left, right = parts
        axes = left.subplots(len(pairs), 1, sharex=True, squeeze=False)[:, 0]
        draw_forces(list(axes), newton, independent)
        if len(independent.contacts["pair"]):
            note = "Grey arrows: instants of the independent-collisions model."
            left.supxlabel(note, fontsize=8.5, color="#555555")
        ax = right.subplots()
        draw_heights(ax, results, None)
        add_legend(right, ax, 1)
        if note := unresolved(results):
            figure.suptitle(note, fontsize="medium")
    return figure


def release_time(result: Result) -> float:
    """Time of release [s], relative to the first floor touch: negative, or 0 for a cradle."""
    return float(result._core.t_first)


def tops(result: Result) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Time [s] and height [m] of the top of each ball's flight after the last contact, bottom ball first.

    NaN for a ball that does not rise, without gravity, and where a contact became too deep. Later contacts are ignored.
    If a contact has no end, the flights begin at the last instant solved.
    """
    gravity, n = result.column.gravity, len(result.column.balls)
    after = min(_end_of_contacts(result), result.known_until)
    if not gravity > 0.0 or math.isnan(after) or result._core.too_deep >= 0:
        return np.full(n, math.nan), np.full(n, math.nan)
    state = result.trajectory(after)
    z, v = state["position"].values[0], state["velocity"].values[0]
    rising = np.where(v > 0.0, v, math.nan)
    return after + rising / gravity, z + rising**2 / (2.0 * gravity)


def _end_of_contacts(result: Result) -> float:
    """The last begin or end of a contact [s], the last instant solved if a contact has no end, NaN without contacts."""
    begin, end = result.contacts["begin"].values, result.contacts["end"].values
    if begin.size == 0:
        return math.nan
    last = float(np.nanmax(np.concatenate([begin, end])))
    return max(last, float(result._core.t_last)) if np.isnan(end).any() else last


def time_shown(results: Sequence[Result]) -> float:
    """End of a picture of the whole motion [s]: after the top of every flight under every model.

    At least 1.3 times the duration of the fall.
    """
    span = 0.0
    for result in results:
        default = max(-1.3 * release_time(result), 3.0 * window([result])[1])
        end = default if result.until is None else result.until
        span = max(span, end, 1.06 * float(np.nanmax(tops(result)[0], initial=0.0)))
    return span


def draw_heights(ax: Axes, results: Sequence[Result], until: float | None) -> None:
    """One line for each ball and model, with dots at the tops of the flights."""
    end = time_shown(results) if until is None else until
    stops = [r._known_up_to(end) for r in results]
    limited = [(r, stop) for r, stop in zip(results, stops, strict=True) if stop < end]
    notes = [_cut_short(r, stop, end) for r, stop in limited if math.isinf(r.known_until)]
    ax.set_title("\n".join(notes), fontsize="small")
    start = min(min(release_time(r) for r in results), 0.0)
    factor, unit = scaled(max(*stops, -start), "s")
    floor = results[0].column.floor
    shown = [_sample(result, stop) for result, stop in zip(results, stops, strict=True)]
    largest = max(float(np.abs(z).max()) for _, z in shown)
    length, metres = (1.0, "m") if floor else scaled(largest, "m")
    for result, (times, z) in zip(results, shown, strict=True):
        for i in range(z.shape[1]):
            ax.plot(times * factor, z[:, i] * length, color=ball_colour(i + 1), **LOOKS[result.model])
        if floor:
            _mark_tops(ax, result, float(times[-1]), factor)
    ax.set_xlim(start * factor, max(stops) * factor)
    if floor:
        lowest = min(float(z.min()) for _, z in shown)  # negative only if a ball is compressed by its radius
        ax.set_ylim(min(0.0, 1.06 * lowest), 1.06 * largest)
        ax.set_ylabel(f"height of the centre [{metres}]")
        ax.set_xlabel(f"time after the first floor touch [{unit}]")
    else:
        ax.set_ylabel(f"displacement [{metres}]")
        ax.set_xlabel(f"time after release [{unit}]")
    _name_lines(ax, results)


def _cut_short(result: Result, stop: float, end: float) -> str:
    """The time up to which the motion after the sequence is known, if not up to ``end``, and why."""
    factor, unit = scaled(stop, "s")
    why = "too deep" if result._continued(end).too_deep >= 0 else "not resolved"
    return f"{MODELS[result.model].label}: {why} after {stop * factor:.3g} {unit}"


def _mark_tops(ax: Axes, result: Result, stop: float, factor: float) -> None:
    """A dot at the top of each flight, unless the ball is hit again before."""
    for i, (t, z) in enumerate(zip(*tops(result), strict=True)):
        if t <= stop and math.isclose(float(result.trajectory(t)["position"][0, i]), z, rel_tol=1e-6):
            ax.plot(t * factor, z, "o", color=ball_colour(i + 1), ms=3.0)


def _sample(result: Result, stop: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Times [s] from the release and heights of the centres [m]; for a cradle, displacements."""
    start = min(release_time(result), 0.0)
    begin = result.contacts["begin"].values
    marks = np.append(begin[spread(np.arange(len(begin)))], tops(result)[0])
    marks = marks[(marks > start) & (marks < stop)]
    times = np.unique(np.concatenate([np.linspace(start, stop, 600), marks]))
    z = result.trajectory(times)["position"].values
    return times, z if result.column.floor else z - result.column.initial_positions


def _name_lines(ax: Axes, results: Sequence[Result]) -> None:
    """Legend entries: the models with the height of the top ball, and the balls."""
    what = "top ball rebounds" if len(results[0].column.balls) > 1 else "rebound"
    for result in results:
        highest = float(tops(result)[1][-1])
        rebound = "" if math.isnan(highest) else f", {what} to {highest:.3g} m"
        label = MODELS[result.model].label + rebound
        ax.plot([], [], color="black", label=label, **LOOKS[result.model])
    if 1 < len(results[0].column.balls) <= MAX_NAMED:
        for ball in range(len(results[0].column.balls), 0, -1):
            ax.plot([], [], color=ball_colour(ball), label=f"ball {ball}")


def add_legend(figure: FigureBase, ax: Axes, columns: int) -> None:
    """A legend below the axes."""
    handles, labels = ax.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=columns)
