"""Plot of a fit: data and laws, and the deviations in units of the standard errors."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import cycle
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from ..fitting.measurements import OBSERVED, Impacts, Rebounds
from ..fitting.result import Fit, Trial
from .labels import scaled
from .style import GREY, PAGE_WIDTH, PALETTE, style

#: Colour and line of the chosen law, then of the others in order.
LOOKS: Final[tuple[dict[str, Any], ...]] = (
    {"color": PALETTE["vermillion"], "ls": "-", "lw": 1.6},
    {"color": PALETTE["blue"], "ls": (0, (5, 2))},
    {"color": PALETTE["green"], "ls": (0, (1, 1.2))},
    {"color": PALETTE["purple"], "ls": (0, (6, 1.5, 1, 1.5))},
)
#: More points than this are drawn without error bars.
MAX_BARS: Final = 300
DOTS: Final[dict[str, Any]] = {"fmt": "o", "ms": 3.2, "color": "black", "elinewidth": 0.8, "zorder": 3}


def fit(fit: Fit) -> Figure:
    """Above, data with error bars and the laws; below, deviations of the chosen law in standard errors."""
    with style():
        figure = Figure(figsize=(PAGE_WIDTH * 0.75, 5.0))
        upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(2.2, 1.0))
        if isinstance(fit.data, Impacts):
            x = _impacts(upper, fit, fit.data)
            lower.set_xlabel("speed of impact [m/s]")
        elif isinstance(fit.data, Rebounds):
            x = _rebounds(upper, lower, fit, fit.data)
        _deviations(lower, x, fit.deviations)
        upper.legend(loc="best")
        figure.align_ylabels((upper, lower))
    return figure


def _impacts(ax: Axes, fit: Fit, data: Impacts) -> Any:
    speed = data.speed
    if data.n > MAX_BARS:
        ax.plot(speed, data.restitution, ".", ms=2.0, color=GREY, zorder=0, rasterized=True)
    else:
        ax.errorbar(speed, data.restitution, yerr=data.restitution_error, **DOTS)
    margin = 1.15 if speed.max() > 1.02 * speed.min() else 2.0
    v = np.geomspace(speed.min() / margin, speed.max() * margin, 300)
    for trial, look in _looks(fit):
        curve = np.asarray(trial.contact.restitution(v))
        ax.plot(v, curve, label=trial.name, **look)
        if trial is fit and fit.scatter is not None:
            s = fit.scatter.value
            ax.fill_between(v, curve - s, curve + s, color=look["color"], alpha=0.15, lw=0.0)
    _logarithmic(ax)
    ax.set_xlim(v[0], v[-1])
    ax.set_ylabel(r"coefficient of restitution $\varepsilon$")
    return speed


def _rebounds(upper: Axes, lower: Axes, fit: Fit, data: Rebounds) -> Any:
    """Rebounds over the varied quantity, or over the number of the drop if nothing is varied."""
    x, label = np.arange(1.0, data.n + 1.0), "drop"
    if data.varied:
        name, values = next(iter(data.varied.items()))
        factor, unit = scaled(float(values.max()), "m")
        x, label = values * factor, f"{name} [{unit}]"
        if values.min() > 0.0 and values.max() > 20.0 * values.min():
            _logarithmic(upper)
    upper.errorbar(x, data.values, yerr=data.error, **DOTS)
    order = np.argsort(x, kind="stable")
    for trial, look in _looks(fit):
        predicted = data.predicted(trial.candidate, trial.law)
        upper.plot(x[order], predicted[order], label=trial.name, **look)
    words, unit = OBSERVED[data.observable]
    upper.set_ylabel(f"{words}\n[{unit}]")
    lower.set_xlabel(label)
    return x


def _logarithmic(ax: Axes) -> None:
    """A logarithmic axis with labels at 1, 2 and 5 of each decade."""
    ax.set_xscale("log")
    ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    ax.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    ax.xaxis.set_minor_formatter(NullFormatter())


def _looks(fit: Fit) -> Iterator[tuple[Trial, dict[str, Any]]]:
    return zip((fit, *fit.others), cycle(LOOKS), strict=False)


def _deviations(ax: Axes, x: Any, deviations: Any) -> None:
    ax.axhspan(-1.0, 1.0, color=GREY, alpha=0.2, lw=0.0)
    ax.axhline(0.0, color=PALETTE["vermillion"], lw=1.2)
    ax.plot(x, deviations, "o", ms=3.2 if len(deviations) <= MAX_BARS else 1.0, color="black")
    largest = max(2.5, 1.15 * float(np.abs(deviations).max()))
    ax.set_ylim(-largest, largest)
    ax.set_ylabel("deviation\n[errors]")
