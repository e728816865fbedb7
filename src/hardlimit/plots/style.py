"""Style of all pictures: palette, fonts, colours of pairs and of contact counts; function to save a figure."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from cycler import cycler
from matplotlib.backend_bases import FigureCanvasBase
from matplotlib.colors import BoundaryNorm, Colormap, ListedColormap
from matplotlib.figure import Figure

from ..support import saving, validation

#: Palette of Okabe and Ito (2008), for colour-blind readers.
PALETTE: Final = {
    "black": "#000000",
    "blue": "#0072b2",
    "vermillion": "#d55e00",
    "green": "#009e73",
    "purple": "#cc79a7",
    "orange": "#e69f00",
    "sky": "#56b4e9",
    "yellow": "#f0e442",
}
GREY: Final = "#8c8c8c"
MISSING: Final = "#808080"  #: missing values on a map

RESOLUTIONS: Final = (20.0, 2400.0)  #: smallest and largest ``dpi``
COLUMN_WIDTH: Final = 3.4  #: [inch] width of one column of a journal page
PAGE_WIDTH: Final = 7.0  #: [inch] width of both columns

STYLE: Final[dict[str, Any]] = {
    "font.family": "STIXGeneral",  # comes with matplotlib: the same picture on every system
    "mathtext.fontset": "stix",
    "font.size": 10.0,
    "axes.labelsize": 10.0,
    "axes.titlesize": 10.0,
    "xtick.labelsize": 9.0,
    "ytick.labelsize": 9.0,
    "legend.fontsize": 9.0,
    "legend.frameon": False,
    "legend.handlelength": 1.8,
    "axes.linewidth": 0.7,
    "axes.prop_cycle": cycler(
        color=[PALETTE[c] for c in ("blue", "vermillion", "green", "purple", "orange", "sky", "black")]
    ),
    "lines.linewidth": 1.2,
    "patch.linewidth": 0.7,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.top": True,
    "ytick.right": True,
    "xtick.major.pad": 5.0,  # avoids overlap with the lowest label of the other axis
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
    "xtick.minor.visible": True,
    "ytick.minor.visible": True,
    "figure.constrained_layout.use": True,
    "figure.dpi": 200.0,
    "savefig.dpi": 200.0,
    "savefig.bbox": "standard",
    "image.interpolation": "nearest",
    "pdf.fonttype": 42,
    "svg.fonttype": "path",
}


@contextmanager
def style(**changes: Any) -> Iterator[None]:
    """Context with the shared style: ``with style(): figure = Figure(…)``; ``changes`` override rcParams."""
    settings: Any = STYLE | {key.replace("__", "."): value for key, value in changes.items()}
    with mpl.rc_context(settings):
        yield


def save(figure: Figure, path: str | Path, dpi: float | None = None) -> Path:
    """Write the figure; the ending of ``path`` (png, pdf, svg, …) gives the format.

    Parameters
    ----------
    figure : Figure
    path : path
    dpi : float, optional
        Resolution [dots per inch] of pixels, including those inside a PDF or SVG; 200 by default. Journals ask
        for 300.

    Raises
    ------
    ValueError
        If the ending is unknown, the folder does not exist, or the resolution is outside [20, 2400].
    OSError
        If the file cannot be written; names it.
    """
    target = saving.checked("plot", path, endings())
    resolution = checked_resolution(dpi)
    with style(), saving.whole(target) as unfinished:
        figure.savefig(unfinished, dpi=resolution, format=target.suffix.lower().removeprefix("."))
    return target


def endings() -> list[str]:
    """File endings that a picture can have."""
    return [f".{name}" for name in sorted(FigureCanvasBase.get_supported_filetypes())]


def checked_resolution(dpi: float | None) -> float:
    """``dpi`` [dots per inch], 200 for None; ValueError outside [20, 2400]."""
    if dpi is None:
        return float(STYLE["savefig.dpi"])
    return validation.number("dpi", dpi, *RESOLUTIONS, lowest_allowed=True, highest_allowed=True)


def pair_label(pair: int) -> str:
    """F01 for the floor and the lowest ball, F12 for the next pair, … as mathematical text."""
    return f"$F_{{{pair}{pair + 1}}}$" if pair < 9 else f"$F_{{{pair},{pair + 1}}}$"


def pair_colour(pair: int) -> str:
    """The colour of a pair in all pictures."""
    names = ("vermillion", "blue", "green", "purple", "orange", "sky", "black")
    return PALETTE[names[pair % len(names)]]


def ball_colour(ball: int) -> str:
    """The colour of ball 1, 2, … in all pictures: that of the pair below it."""
    return pair_colour(ball - 1)


# --- contact counts -----------------------------------------------------------------------------------------


#: Colours of 0, 1, 2, … contacts in all pictures; web/src/style/theme.ts has the formula of these colours. They grow lighter
#: with the count, from purple through orange to straw, so that the order remains visible in grey and to colour-blind
#: readers. No contact is dark grey.
COUNT_COLOURS: Final = (
    *("#2c2e32", "#373a5a", "#5a437a", "#7a478a", "#994a8f", "#b64e8c", "#d05484", "#e55e78"),
    *("#f66c6a", "#ff7d5d", "#ff9153", "#ffa552", "#ffba5c", "#ffce6f", "#ffe088", "#fdf1a4"),
)


MAX_COUNTED: Final = len(COUNT_COLOURS) - 1  #: higher counts share one colour


def count_colours(highest: int, lowest: int = 0) -> tuple[Colormap, BoundaryNorm]:
    """Colour map and norm for counts ``lowest`` … ``highest``; a count always has the same colour.

    Counts above 15 are white; missing values are grey.
    """
    last = min(max(int(highest), 1), MAX_COUNTED)
    first = min(max(int(lowest), 0), last)
    cmap = ListedColormap(COUNT_COLOURS[first : last + 1], "contacts").with_extremes(
        over="white", bad=MISSING
    )
    return cmap, BoundaryNorm(np.arange(first - 0.5, last + 1.0), last - first + 1)
