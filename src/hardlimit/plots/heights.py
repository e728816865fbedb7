"""Heights of the balls over time, from release to the tops of their flights."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from ..column.models import MODELS
from ..column.solvers import adiabatic, newton
from ..contact.compression import CompressionWarning
from .forces import spread, unresolved, window
from .labels import LOOKS, scaled
from .style import PAGE_WIDTH, ball_colour, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import FigureBase
    from numpy.typing import NDArray

    from ..column.result import Result

MOST_NAMED = 6  #: balls that the legend lists


def heights(*results: Result, until: float | None = None) -> Figure:
    """Heights of the centres over time, from release on; full lines Newton, dashed independent collisions.

    ``until`` [s] defaults to somewhat after all balls have reached the top of their flights under every model.
    """
    with style():
        figure = Figure(figsize=(PAGE_WIDTH * 0.72, 3.9))
        ax = figure.subplots()
        draw_heights(ax, results, until)
        add_legend(figure, ax, 2)
        if note := unresolved(results):
            figure.suptitle(note, fontsize="medium")
    return figure


def release_time(result: Result) -> float:
    """When the column was released [s], on the clock of the result: negative, or 0 for a cradle."""
    return float(result._core.t_first)


def tops(result: Result) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """When [s] and how high [m] each ball's flight after the contacts found has its top, bottom ball first.

    NaN for a ball that does not rise, without gravity, and where a contact became too deep. A ball that is hit again
    on its way up keeps the top that its flight would have had. If a contact has no end, the flights are those after
    the last instant solved.
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
    """The last begin or end of a contact [s]; where one has no end, the last instant solved; NaN: no contact."""
    begin, end = result.contacts["begin"].values, result.contacts["end"].values
    if begin.size == 0:
        return math.nan
    last = float(np.nanmax(np.concatenate([begin, end])))
    return max(last, float(result._core.t_last)) if np.isnan(end).any() else last


def time_shown(results: Sequence[Result]) -> float:
    """When a picture of the whole motion ends [s]: after the apex of every ball under every model.

    At the least, a third longer after the first floor touch than the fall before it took.
    """
    span = 0.0
    for result in results:
        release = -release_time(result) if result.column.floor else 0.0
        usual = max(1.3 * release, 3.0 * window([result])[1])
        asked = usual if result.until is None else result.until
        span = max(span, asked, 1.06 * float(np.nanmax(tops(result)[0], initial=0.0)))
    return span


def draw_heights(ax: Axes, results: Sequence[Result], until: float | None) -> None:
    """One line for each ball and model; dots mark the tops of the flights."""
    end = time_shown(results) if until is None else until
    stops = [min(end, _known_until(r, end)) for r in results]
    start = min(min(release_time(r) for r in results), 0.0)
    factor, unit = scaled(max(*stops, -start), "s")
    floor = results[0].column.floor
    shown = [_sample(result, start, stop) for result, stop in zip(results, stops, strict=True)]
    largest = max(float(np.abs(z).max()) for _, z in shown)
    length, metres = (1.0, "m") if floor else scaled(largest, "m")
    for result, (times, z) in zip(results, shown, strict=True):
        for i in range(z.shape[1]):
            ax.plot(times * factor, z[:, i] * length, color=ball_colour(i + 1), **LOOKS[result.model])
        if floor:
            _mark_tops(ax, result, float(times[-1]), factor)
    ax.set_xlim(start * factor, max(stops) * factor)
    if floor:
        lowest = min(
            float(z.min()) for _, z in shown
        )  # below the floor only if a ball is flattened to nothing
        ax.set_ylim(min(0.0, 1.06 * lowest), 1.06 * largest)
        ax.set_ylabel(f"height of the centre [{metres}]")
        ax.set_xlabel(f"time after the first floor touch [{unit}]")
    else:
        ax.set_ylabel(f"displacement [{metres}]")
        ax.set_xlabel(f"time after release [{unit}]")
    _name_lines(ax, results)


def _known_until(result: Result, end: float) -> float:
    """Up to when the motion can be drawn [s]: after the sequence, too, a contact may become too deep."""
    if result.model == "independent" or result.until is not None or math.isfinite(result.known_until):
        return result.known_until
    solve = newton if result.model == "newton" else adiabatic
    with warnings.catch_warnings(action="ignore", category=CompressionWarning):
        return solve(result.column, end).known_until


def _mark_tops(ax: Axes, result: Result, stop: float, factor: float) -> None:
    """A dot where a flight has its top, unless the ball is hit again before."""
    for i, (t, z) in enumerate(zip(*tops(result), strict=True)):
        if t <= stop and math.isclose(float(result.trajectory(t)["position"][0, i]), z, rel_tol=1e-6):
            ax.plot(t * factor, z, "o", color=ball_colour(i + 1), ms=3.0)


def _sample(result: Result, start: float, stop: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Times [s], and heights of the centres [m]; a cradle's balls are counted from where they began."""
    begin = result.contacts["begin"].values
    marks = np.append(begin[spread(np.arange(len(begin)))], tops(result)[0])
    marks = marks[(marks > start) & (marks < stop)]
    times = np.unique(np.concatenate([np.linspace(start, stop, 600), marks]))
    z = result.trajectory(times)["position"].values
    return times, z if result.column.floor else z - result.column.initial_positions


def _name_lines(ax: Axes, results: Sequence[Result]) -> None:
    """Entries of the legend: the models by line, with the height of the top ball, and the balls by colour."""
    who = "top ball rebounds" if len(results[0].column.balls) > 1 else "rebound"
    for result in results:
        highest = float(tops(result)[1][-1])
        name = MODELS[result.model].label
        label = name if math.isnan(highest) else f"{name}, {who} to {highest:.3g} m"
        ax.plot([], [], color="black", label=label, **LOOKS[result.model])
    if 1 < len(results[0].column.balls) <= MOST_NAMED:
        for ball in range(len(results[0].column.balls), 0, -1):
            ax.plot([], [], color=ball_colour(ball), label=f"ball {ball}")


def add_legend(figure: FigureBase, ax: Axes, columns: int) -> None:
    """The legend below the axes, where it hides no line."""
    handles, labels = ax.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=columns)
