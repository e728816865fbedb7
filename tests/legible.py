"""Whether a picture can be read: no text runs into another one or off the picture."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from hardlimit.pictures.style import style


def along(axis: Axis, values: Any) -> Any:
    """Where values lie along an axis, which may be logarithmic."""
    return axis.get_transform().transform(np.asarray(values, dtype=float))


def boxes(figure: Figure) -> list[tuple[str, Bbox]]:
    """Every text that is seen, with the rectangle that it takes [pixels]; ticks outside the axes are not."""
    FigureCanvasAgg(figure).draw()
    axes = [*figure.axes, *(child for ax in figure.axes for child in ax.child_axes)]
    ticks = {
        label: axis.get_visible() and low - 1e-9 * (high - low) <= at <= high + 1e-9 * (high - low)
        for ax in axes
        for i, axis in enumerate((ax.xaxis, ax.yaxis))
        for low, high in [sorted(along(axis, axis.get_view_interval()))]
        for label in axis.get_ticklabels(which="both")
        for at in along(axis, [label.get_position()[i]])
    }
    found = []
    for text in figure.findobj(Text):
        if text.get_text().strip() and text.get_visible() and ticks.get(text, True):
            # A text box holds the room of ascenders and descenders: what overlaps by less is no overlap.
            found.append((text.get_text(), text.get_window_extent().padded(-1.0)))
    return found


def assert_legible(figure: Figure, **look: Any) -> None:
    """``look`` is what the picture changes of the shared style."""
    page = figure.bbox.padded(2.0)
    with style(**look):
        shown = boxes(figure)
    for text, box in shown:
        assert page.x0 <= box.x0 and box.x1 <= page.x1, f"{text!r} runs off the picture"
        assert page.y0 <= box.y0 and box.y1 <= page.y1, f"{text!r} runs off the picture"
    for (one, first), (other, second) in combinations(shown, 2):
        assert not first.overlaps(second), f"{one!r} and {other!r} overlap"
