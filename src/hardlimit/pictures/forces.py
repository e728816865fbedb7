"""Contact forces over time, one panel for each pair of neighbours."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter

from .labels import scaled
from .style import GREY, PAGE_WIDTH, pair_colour, pair_label, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from ..column.result import Result

Curve = tuple["NDArray[np.float64]", "NDArray[np.float64]"]


def force_curve(result: Result, pair: int, stop: float, samples: int = 200) -> Curve:
    """Times [s] and forces [N] of one pair as a line: each contact from begin to end, zero in between."""
    begin, end = contacts_of(result, pair)
    times, forces = [np.empty(0)], [np.empty(0)]
    for a, b in zip(begin, np.where(np.isnan(end), stop, end), strict=True):
        b = min(b, stop)
        if not b > a:
            continue
        # Just inside the contact: the force jumps at its begin.
        inside = a + (b - a) * np.concatenate([[1e-6], np.linspace(0.0, 1.0, samples)[1:-1], [1 - 1e-6]])
        force = result.trajectory(inside)["force"].sel(pair=pair).values
        times.append(np.concatenate([[a], inside, [b]]))
        forces.append(np.concatenate([[0.0], force, [0.0]]))
    return np.concatenate(times), np.concatenate(forces)


def contacts_of(result: Result, pair: int) -> Curve:
    """Begin and end [s] of the contacts of one pair."""
    table = result.contacts
    mine = table["pair"].values == pair
    return table["begin"].values[mine], table["end"].values[mine]


def pairs_of(result: Result) -> list[int]:
    """The pairs of a column, bottom first: 0 is the floor and the lowest ball; a cradle begins with 1."""
    return list(range(0 if result.column.floor else 1, len(result.column.balls)))


def window(results: Iterable[Result]) -> tuple[float, float]:
    """The time span [s] in which the contacts lie, with a margin."""
    marks: list[float] = [0.0]
    for result in results:
        if result.until is not None:
            marks.append(result.until)
        for name in ("begin", "end"):
            values = result.contacts[name].values
            marks += [float(v) for v in values[np.isfinite(values)]]
        if math.isfinite(result.t_end):
            marks.append(result.t_end)
    start, stop = min(marks), max(marks)
    margin = 0.05 * (stop - start) or 1e-6
    return start - margin, stop + margin


def forces(result: Result) -> Figure:
    """Contact forces over time, one panel for each pair, the floor's below (Fig. 2 of the paper).

    Instantaneous collisions are drawn as arrows. A dashed line marks t_f.
    """
    with style():
        pairs = pairs_of(result)
        figure = Figure(figsize=(PAGE_WIDTH * 0.72, 1.0 + 1.35 * len(pairs)))
        axes = figure.subplots(len(pairs), 1, sharex=True, squeeze=False)[:, 0]
        draw_forces(list(axes), result, None)
    return figure


def draw_forces(axes: list[Axes], result: Result, ghost: Result | None, named: bool = True) -> None:
    """Forces of ``result``, one panel for each pair, top pair first; instants of ``ghost`` as arrows.

    All panels share one unit of force. ``named`` writes the bodies above each panel, not only the number of
    their contacts.
    """
    span = window([result] if ghost is None else [result, ghost])
    pairs = pairs_of(result)[::-1]
    factor, unit = scaled(span[1], "s")
    if result.model == "independent":
        for ax, pair in zip(axes, pairs, strict=True):
            _draw_impulses(ax, result, pair, factor)
    else:
        _draw_curves(axes, result, pairs, span, factor)
    for ax, pair in zip(axes, pairs, strict=True):
        if ghost is not None and result.model != "independent":
            _draw_instants(ax, contacts_of(ghost, pair)[0] * factor, GREY)
    end = result.t_end if len(result.column.balls) > 1 else math.nan
    _mark_end(axes, end, span, factor)
    # The label stands on the side where t_f is not.
    side = "right" if end < 0.5 * (span[0] + span[1]) else "left"
    for ax, pair in zip(axes, pairs, strict=True):
        text = _bodies_and_contacts(result, pair) if named else _contacts(result, pair)
        ax.set_title(text, loc="right" if side == "right" else "left", fontsize="medium", pad=3.0)
    axes[-1].set_xlim(span[0] * factor, span[1] * factor)
    since = "the first floor touch" if result.column.floor else "release"
    axes[-1].set_xlabel(f"time after {since} [{unit}]")


def _bodies_and_contacts(result: Result, pair: int) -> str:
    return f"{'floor' if pair == 0 else f'balls {pair}–{pair + 1}'}: {_contacts(result, pair)}"


def _contacts(result: Result, pair: int) -> str:
    n = len(contacts_of(result, pair)[0])
    return "no contact" if n == 0 else "1 contact" if n == 1 else f"{n} contacts"


def _mark_end(axes: list[Axes], end: float, span: tuple[float, float], factor: float) -> None:
    """A dashed line at t_f through all panels, labelled above the uppermost."""
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
    """Each force in the unit that suits the largest of them."""
    curves = [force_curve(result, pair, span[1]) for pair in pairs]
    factor, unit = scaled(max(float(values.max(initial=0.0)) for _, values in curves), "N")
    for ax, pair, (times, values) in zip(axes, pairs, curves, strict=True):
        colour = pair_colour(pair)
        last = values[-1] if _never_ends(result, pair) else 0.0
        t = np.concatenate([[span[0]], times, [span[1]]]) * time_factor
        f = np.concatenate([[0.0], values, [last]]) * factor
        ax.plot(t, f, color=colour)
        ax.fill_between(t, f, color=colour, alpha=0.15, lw=0)
        ax.set_ylabel(f"{pair_label(pair)} [{unit}]")
        ax.set_ylim(0.0, 1.12 * float(f.max(initial=0.0)) or 1.0)
        ax.yaxis.set_major_formatter(FormatStrFormatter("%.4g"))


def _never_ends(result: Result, pair: int) -> bool:
    end = contacts_of(result, pair)[1]
    return bool(len(end)) and math.isnan(end[-1])


def _draw_impulses(ax: Axes, result: Result, pair: int, time_factor: float) -> None:
    """Contacts without duration: there is no force to draw."""
    _draw_instants(ax, contacts_of(result, pair)[0] * time_factor, pair_colour(pair))
    ax.set_yticks([])
    ax.set_ylim(0.0, 1.0)
    ax.set_ylabel(f"{pair_label(pair)}\n(impulses)")


def _draw_instants(ax: Axes, instants: NDArray[np.float64], colour: str) -> None:
    """Instantaneous collisions as arrows that stand on the axis."""
    for t in instants:
        ax.annotate(
            "",
            (t, 0.8),
            (t, 0.0),
            xycoords=("data", "axes fraction"),
            textcoords=("data", "axes fraction"),
            arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.1, "shrinkA": 0, "shrinkB": 0},
        )
