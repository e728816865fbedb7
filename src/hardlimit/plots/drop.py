"""One drop at a glance: contact forces and heights."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure

from .forces import draw_forces, pairs_of, unresolved
from .heights import add_legend, draw_heights
from .style import PAGE_WIDTH, style

if TYPE_CHECKING:
    from ..column.result import Result

NOTE = "Grey arrows: instants of the independent-collisions model."


def drop(newton: Result, independent: Result, adiabatic: Result | None = None) -> Figure:
    """Forces through the contacts, and heights from release to the tops of the flights.

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
            left.supxlabel(NOTE, fontsize=8.5, color="#555555")
        ax = right.subplots()
        draw_heights(ax, results, None)
        add_legend(right, ax, 1)
        if note := unresolved(results):
            figure.suptitle(note, fontsize="medium")
    return figure
