"""Plot of collision rules against Newton's equations: differences with standard errors, contacts, trajectories."""

from __future__ import annotations

import math
from itertools import cycle
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from ..boxes.rules import RULES
from ..fidelity_study.contacts import EDGES
from ..fidelity_study.replica import NEWTON
from .gas import set_scale
from .labels import scaled
from .style import GREY, PAGE_WIDTH, PALETTE, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..fidelity_study import Fidelity

#: Colours and lines of the rules in turn; coinciding lines remain visible.
OF_RULES: Final = (
    ("vermillion", "-"),
    ("orange", (0, (4, 2.5))),
    ("green", (0, (6, 1.5, 1, 1.5))),
    ("blue", "-"),
    ("purple", (0, (2, 1.5))),
)
#: Colour and line of each model.
LOOKS: Final[dict[str, dict[str, Any]]] = {NEWTON: {"color": "black", "ls": "-"}} | {
    rule: {"color": PALETTE[colour], "ls": line}
    for rule, (colour, line) in zip(RULES, cycle(OF_RULES), strict=False)
}
#: Smaller distances of trajectories [radii] are drawn at the edge.
SMALLEST: Final = 1e-9


def fidelity(f: Fidelity) -> Figure:
    """Temperature, relative differences from Newton's equations in cooling, collision rate and pressure, distance of
    trajectories, and restitution of single contacts. Bands are standard errors; a dot marks the first significant
    difference."""
    factor, unit = scaled(float(f.plan.times[-1]), "s")
    with style():
        figure = Figure(figsize=(PAGE_WIDTH, 6.6))
        axes = figure.subplots(3, 2)
        _temperature(axes[0, 0], f, factor)
        cools = bool(np.isfinite(f.dataset["cooling"].values[0, -1, 0]))
        measure = ("cooling", "cooling") if cools else ("granular_temperature", "granular temperature")
        _difference(axes[0, 1], f, *measure, factor)
        _difference(axes[1, 0], f, "collision_rate", "collision rate", factor)
        _difference(axes[1, 1], f, "pressure", "pressure", factor)
        _paths(axes[2, 0], f, factor)
        _contacts(axes[2, 1], f)
        for ax in axes.flat[:-1]:
            ax.set_xlim(0.0, float(f.plan.times[-1]) * factor or 1.0)
        for ax in (axes[0, 0], axes[0, 1], axes[1, 0]):
            ax.tick_params(labelbottom=False)
        for ax in (axes[1, 1], axes[2, 0]):
            ax.set_xlabel(f"time [{unit}]")
        figure.align_ylabels(axes[:, 0])
        figure.align_ylabels(axes[:, 1])
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), title=_title(f))
    return figure


def _title(f: Fidelity) -> str:
    bars = "one replica, no error bars" if f.n_replicas == 1 else f"{f.n_replicas} replicas"
    number = rf"$t_c\nu$ = {f.tc_nu:.2g}, " if np.isfinite(f.tc_nu) else ""
    if np.isfinite(f.delta_over_d):
        number += rf"$\delta/d$ = {f.delta_over_d:.2g}, "
    return f"{number}{bars}"


def _band(ax: Axes, x: Any, mean: Any, error: Any, look: dict[str, Any], **more: Any) -> None:
    """A line with a band of ± 1 standard error."""
    ax.plot(x, mean, **look, **more)
    ax.fill_between(x, mean - error, mean + error, color=look["color"], alpha=0.18, lw=0.0)


def _temperature(ax: Axes, f: Fidelity, factor: float) -> None:
    values = f.dataset["granular_temperature"].values
    for model, mean in zip(f.models, values, strict=True):
        name = "Newton’s equations" if model == NEWTON else model
        _band(ax, f.plan.times * factor, mean[:, 0], mean[:, 1], LOOKS[model], label=name)
    if np.isfinite(f.steady.start):
        ax.axvline(f.steady.start * factor, color=GREY, lw=1.0, ls=":")
    set_scale(ax, values[..., 0].ravel(), [])
    ax.set_ylabel("granular temperature\n[m²/s²]")


def _difference(ax: Axes, f: Fidelity, name: str, label: str, factor: float) -> None:
    """Difference from Newton's equations in per cent."""
    ax.axhline(0.0, color="black", lw=1.0)
    for model in f.models[1:]:
        difference = f.difference(name, model)
        _band(ax, f.plan.times * factor, 100.0 * difference.value, 100.0 * difference.error, LOOKS[model])
        left = f.departure(name, model)
        if left is not None:
            dot = {"ms": 4.5, "mec": "white", "mew": 0.6, "c": LOOKS[model]["color"]}
            ax.plot(left.time * factor, 100.0 * left.size, "o", **dot)
    ax.set_ylabel(f"{label},\ndifference [%]")


def _paths(ax: Axes, f: Fidelity, factor: float) -> None:
    ax.axhline(1.0, color=GREY, lw=0.8, ls=(0, (2, 2)))
    seen = [1.0]
    for model, distance in zip(f.models[1:], f.dataset["divergence"].values[1:], strict=True):
        apart = np.where(distance[:, 0] > 0.0, np.maximum(distance[:, 0], SMALLEST), np.nan)
        seen += apart[np.isfinite(apart)].tolist()
        ax.plot(f.plan.times * factor, apart, **LOOKS[model])
    ax.set_yscale("log")
    low, high = math.floor(math.log10(min(seen))), math.ceil(math.log10(max(seen)))
    room = 0.12 * max(high - low, 1)  # avoids overlap with the labels of the other axis
    ax.set_ylim(10.0 ** (low - room), 10.0 ** (high + room))
    ax.yaxis.set_major_locator(LogLocator(numticks=6))
    ax.yaxis.set_minor_formatter(NullFormatter())
    ax.set_ylabel("distance of\ntrajectories [radii]")


def _contacts(ax: Axes, f: Fidelity) -> None:
    """Distribution of the restitution of the contacts."""
    shares = f.dataset["restitution_share"].values[..., 0]
    if np.isfinite(shares[0]).all():
        ax.stairs(shares[0], EDGES, fill=True, color="0.75")
    for model, share in zip(f.models, shares, strict=True):
        if np.isfinite(share).all():
            ax.stairs(share, EDGES, color=LOOKS[model]["color"], ls=LOOKS[model]["ls"], lw=1.0)
    ax.set_yscale("log")
    ax.set_ylim(1e-4, 2.0)
    ax.set_xlim(EDGES[0], EDGES[-1])
    ticks = np.linspace(EDGES[0], EDGES[-1], 7)
    ax.set_xticks(ticks, [f"{x:g}" for x in ticks[:-1]] + [f"≥ {ticks[-1]:g}"])
    ax.set_xlabel("separation speed / impact speed of a contact")
    ax.set_ylabel("share of the contacts")
