"""Plot of the contact forces over time, with a panel for each pair of neighbours."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter
from numpy.typing import NDArray

from ..column.result import Result
from .labels import scaled
from .style import GREY, PAGE_WIDTH, pair_colour, pair_label, style

Curve = tuple["NDArray[np.float64]", "NDArray[np.float64]"]

MAX_DRAWN = 400  #: contacts of a pair that are drawn, evenly chosen from more


def force_curve(result: Result, pair: int, stop: float) -> Curve:
    """Times [s] and forces [N] of a pair: each contact from begin to end, zero in between.

    At most ``MAX_DRAWN`` contacts are included.
    """
    begin, end = contacts_of(result, pair)
    end = np.minimum(np.where(np.isnan(end), stop, end), stop)
    chosen = spread(np.flatnonzero(end > begin))
    begin, end = begin[chosen, None], end[chosen, None]
    # Samples lie just inside the contact, because the force jumps at its begin.
    fraction = np.concatenate([[1e-6], np.linspace(0.0, 1.0, 200)[1:-1], [1 - 1e-6]])
    inside = begin + (end - begin) * fraction
    force = result.trajectory(inside.ravel())["force"].sel(pair=pair).values.reshape(inside.shape)
    outside = np.zeros_like(begin)
    times, forces = np.hstack([begin, inside, end]), np.hstack([outside, force, outside])
    return times.ravel(), forces.ravel()


def spread(indices: NDArray[np.int64], most: int = MAX_DRAWN) -> NDArray[np.int64]:
    """All indices, or ``most`` of them, evenly spread from the first to the last."""
    if len(indices) <= most:
        return indices
    chosen: NDArray[np.int64] = indices[np.linspace(0, len(indices) - 1, most).astype(int)]
    return chosen


def contacts_of(result: Result, pair: int) -> Curve:
    """Begin and end [s] of the contacts of a pair."""
    table = result.contacts
    mine = table["pair"].values == pair
    return table["begin"].values[mine], table["end"].values[mine]


def pairs_of(result: Result) -> list[int]:
    """The pairs of a column, bottom first. Pair 0 is the floor and the lowest ball; a cradle starts with pair 1."""
    return list(range(0 if result.column.floor else 1, len(result.column.balls)))


def window(results: Iterable[Result]) -> tuple[float, float]:
    """The time span [s] of the contacts with a margin, limited to the motion that all results know."""
    marks: list[float] = [0.0]
    results = list(results)
    for result in results:
        if result.until is not None:
            marks.append(result.until)
        for name in ("begin", "end"):
            values = result.contacts[name].values
            values = values[np.isfinite(values)]
            marks += [float(values.min()), float(values.max())] if len(values) else []
        if math.isfinite(result.t_end):
            marks.append(result.t_end)
    start, stop = min(marks), max(marks)
    margin = 0.05 * (stop - start) or 1e-6
    # A force is drawn beyond the solution only if its contact is still open there.
    ends = [
        result._padded(stop, margin) if result.contacts["end"].isnull().any() else result.known_until
        for result in results
    ]
    return start - margin, min(stop + margin, *ends)


def unresolved(results: Iterable[Result]) -> str:
    """A title with the time up to which the motion is known; empty if it is known to the end."""
    first = min(results, key=lambda result: result.known_until)
    known = first.known_until
    if math.isinf(known):
        return ""
    factor, unit = scaled(known, "s")
    return f"{first.outcome.split(':')[0]}: known up to {known * factor:.4g} {unit}"


def forces(result: Result) -> Figure:
    """Contact forces over time, one panel for each pair, the floor at the bottom (Fig. 2 of the paper).

    Instantaneous collisions are drawn as arrows. A dashed line marks t_f.
    """
    with style():
        pairs = pairs_of(result)
        figure = Figure(figsize=(PAGE_WIDTH * 0.72, 1.0 + 1.35 * len(pairs)))
        axes = figure.subplots(len(pairs), 1, sharex=True, squeeze=False)[:, 0]
        draw_forces(list(axes), result, None)
        if note := unresolved([result]):
            figure.suptitle(note, fontsize="medium")
    return figure


def draw_forces(axes: list[Axes], result: Result, ghost: Result | None) -> None:
    """Draw forces of ``result``, one panel for each pair, top pair first, and collisions of ``ghost`` as arrows.

    All panels have the same unit of force.
    """
    span = window([result] if ghost is None else [result, ghost])
    pairs = pairs_of(result)[::-1]
    factor, unit = scaled(span[1], "s")
    if result.model == "independent":
        for ax, pair in zip(axes, pairs, strict=True):
            _draw_impulses(ax, result, pair, factor)
    else:
        _draw_curves(axes, result, pairs, span, factor)
        if ghost is not None:
            for ax, pair in zip(axes, pairs, strict=True):
                _draw_instants(ax, contacts_of(ghost, pair)[0] * factor, GREY)
    end = result.t_end if len(result.column.balls) > 1 else math.nan
    _mark_end(axes, end, span, factor)
    # The title must not overlap the label of t_f.
    side: Any = "right" if end < 0.5 * (span[0] + span[1]) else "left"
    for ax, pair in zip(axes, pairs, strict=True):
        ax.set_title(_bodies_and_contacts(result, pair), loc=side, fontsize="medium", pad=3.0)
    axes[-1].set_xlim(span[0] * factor, span[1] * factor)
    since = "the first floor touch" if result.column.floor else "release"
    axes[-1].set_xlabel(f"time after {since} [{unit}]")


def _bodies_and_contacts(result: Result, pair: int) -> str:
    n = len(contacts_of(result, pair)[0])
    some = f", {MAX_DRAWN} of them drawn" if n > MAX_DRAWN else ""
    contacts = "no contact" if n == 0 else "1 contact" if n == 1 else f"{n} contacts{some}"
    return f"{'floor' if pair == 0 else f'balls {pair}–{pair + 1}'}: {contacts}"


def _mark_end(axes: list[Axes], end: float, span: tuple[float, float], factor: float) -> None:
    """A dashed line at t_f through all panels, labelled above the top panel."""
    if not span[0] <= end <= span[1]:
        return
    for ax in axes:
        ax.axvline(end * factor, color="black", lw=0.8, ls=(0, (4, 3)))
    axes[0].annotate(
        "$t_f$",
        (end * factor, 1.0),
        xycoords=("data", "axes fraction"),
        xytext=(0, 3),
        textcoords="offset points",
        ha="center",
        va="bottom",
    )


def _draw_curves(
    axes: list[Axes], result: Result, pairs: list[int], span: tuple[float, float], time_factor: float
) -> None:
    """The forces, all in the unit that suits the largest."""
    curves = [force_curve(result, pair, span[1]) for pair in pairs]
    factor, unit = scaled(max(float(values.max(initial=0.0)) for _, values in curves), "N")
    for ax, pair, (times, values) in zip(axes, pairs, curves, strict=True):
        colour = pair_colour(pair)
        never_ends = bool(np.isnan(contacts_of(result, pair)[1][-1:]).any())
        last = values[-1] if never_ends else 0.0
        t = np.concatenate([[span[0]], times, [span[1]]]) * time_factor
        f = np.concatenate([[0.0], values, [last]]) * factor
        ax.plot(t, f, color=colour)
        ax.fill_between(t, f, color=colour, alpha=0.15, lw=0)
        ax.set_ylabel(f"{pair_label(pair)} [{unit}]")
        ax.set_ylim(0.0, 1.12 * float(f.max(initial=0.0)) or 1.0)
        ax.yaxis.set_major_formatter(FormatStrFormatter("%.4g"))


def _draw_impulses(ax: Axes, result: Result, pair: int, time_factor: float) -> None:
    """Collisions as arrows; an instantaneous contact has no force."""
    _draw_instants(ax, contacts_of(result, pair)[0] * time_factor, pair_colour(pair))
    ax.set_yticks([])
    ax.set_ylim(0.0, 1.0)
    ax.set_ylabel(f"{pair_label(pair)}\n(impulses)")


def _draw_instants(ax: Axes, instants: NDArray[np.float64], colour: str) -> None:
    """At most ``MAX_DRAWN`` instants as arrows on the time axis."""
    for t in instants[spread(np.arange(len(instants)))]:
        ax.annotate(
            "",
            (t, 0.8),
            (t, 0.0),
            xycoords=("data", "axes fraction"),
            textcoords=("data", "axes fraction"),
            arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.1, "shrinkA": 0, "shrinkB": 0},
        )
