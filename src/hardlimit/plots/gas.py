"""Plot of a box of grains over time: temperatures, collision rate and pressure, with kinetic theory."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter

from ..boxes import theory
from .labels import scaled
from .style import GREY, PAGE_WIDTH, PALETTE, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..boxes.result import ParticleResult

#: Name of a theory, and its values at the samples, by the variable that it predicts.
Theories = dict[str, tuple[str, Any]]

#: Panels from top to bottom: variable, label, colour.
PANELS = (
    ("granular_temperature", "granular temperature", "blue"),
    ("collision_rate", "collision rate", "vermillion"),
    ("pressure", "pressure", "green"),
)
#: Second line of a panel, with its colour, and the labels of both lines, in a run with friction.
BESIDE = {
    "granular_temperature": (
        "rotational_temperature",
        "orange",
        ("translation, $T$", r"rotation, $T_\mathrm{r}$"),
    )
}
#: Values that change by more than this factor are drawn on a logarithmic axis.
WIDE = 5.0
TRANSIENT = f"initial transient: {theory.RELAXED} collisions per particle"


def gas(run: ParticleResult) -> Figure:
    """Granular temperature, collision rate and pressure over time; dashed: theory where it applies. With friction the
    rotational temperature is beside the granular one."""
    time = run.series["time"].values
    factor, unit = scaled(float(time[-1]), "s")
    theories = expectations(run)
    with style():
        figure = Figure(figsize=(PAGE_WIDTH * 0.72, 5.6))
        axes = figure.subplots(len(PANELS), 1, sharex=True)
        for ax, (name, label, colour) in zip(axes, PANELS, strict=True):
            _panel(ax, run, name, label, colour, factor, theories)
        axes[-1].set_xlim(0.0, float(time[-1]) * factor or 1.0)
        axes[-1].set_xlabel(f"time [{unit}]")
        figure.align_ylabels(axes)
        if not theories:
            reason = f"no theory: {theory.why_not(run.system)}"
            axes[0].set_title(reason, fontsize="small", color=GREY, loc="right")
    return figure


def _panel(
    ax: Axes, run: ParticleResult, name: str, label: str, colour: str, factor: float, theories: Theories
) -> None:
    """Draw a variable, with friction the one beside it, and what theory expects; ``factor`` gives times a prefix."""
    ds = run.series
    beside, second, texts = BESIDE.get(name, ("", "", ()))
    both = beside in ds
    names = (name, beside) if both else (name,)
    time, drawn = ds["time"].values, []
    # Rate and pressure are means since the previous sample, drawn at the middle of that interval.
    at = time if name == "granular_temperature" else time - 0.5 * np.diff(time, prepend=time[0])
    many: dict[str, Any] = {"marker": ".", "ms": 4.0} if len(time) <= 40 else {}
    lines = zip(names, (colour, second), texts if both else ("event-driven",), strict=False)
    for variable, shade, text in lines:
        values = ds[variable].values
        ax.plot(at * factor, values, color=PALETTE[shade], label=text, **many)
        drawn.append(values if variable == name else values[values > 0.0])
    if name in theories and name != "granular_temperature":
        ax.axvspan(0.0, transient(run) * factor, color="0.9", lw=0.0, label=TRANSIENT)
    for text, expected in (theories[variable] for variable in names if variable in theories):
        ax.plot(at * factor, expected, color="black", lw=0.9, ls=(0, (4, 3)), label=text)
        drawn.append(expected[expected > 0.0])
    if len(drawn) > 1:
        labelled = dict(zip(*reversed(ax.get_legend_handles_labels()), strict=True))
        ax.legend(labelled.values(), labelled.keys(), loc="best")
    units = str(ds[name].attrs["units"]).replace("m2/s2", "m²/s²")
    ax.set_ylabel(f"{'temperatures' if both else label}\n[{units}]")
    set_scale(ax, drawn[0], drawn[1:])


def transient(run: ParticleResult) -> float:
    """End of the transient of rate and pressure [s]; the time of the last sample if it lasts longer."""
    time, pairs = run.samples["time"], run.samples["n_pairs"]
    forgotten = 2.0 * pairs >= theory.RELAXED * run.system.n
    return float(time[forgotten][0] if forgotten.any() else time[-1])


def set_scale(ax: Axes, values: Any, others: list[Any]) -> None:
    """An axis from zero, or a logarithmic one if the values span more than a factor ``WIDE``."""
    good = np.concatenate([np.asarray(v)[np.isfinite(v)] for v in (values, *others)])
    positive = good[good > 0.0]
    if len(positive) == len(good) > 0 and positive.max() > WIDE * positive.min():
        ax.set_yscale("log")
        decades = float(np.log10(positive.max() / positive.min()))
        ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if decades < 3.0 else (1.0,)))
        ax.yaxis.set_major_formatter(FormatStrFormatter("%g"))
        ax.yaxis.set_minor_formatter(NullFormatter())
    elif len(good) and good.min() >= 0.0:
        ax.set_ylim(0.0, 1.15 * float(good.max()) or 1.0)


def expectations(run: ParticleResult) -> Theories:
    """Name of the theory and its values at the times of the panels, for each variable that it predicts."""
    if theory.why_not(run.system) is not None:
        return {}
    gas_of = theory.gas(run.system)
    temperature = run.series["granular_temperature"].values
    between = 0.5 * (temperature + np.concatenate([temperature[:1], temperature[:-1]]))
    curves = {"collision_rate": ("Enskog, at the temperature measured", gas_of.collision_rate(between))}
    e = run.settings.restitution
    if e is not None:
        name = "Carnahan–Starling" if run.system.dimension == 3 else "Henderson"
        curves["pressure"] = (f"{name}, at the temperature measured", gas_of.pressure(between, e))
        curves |= _cooling(run, e)
    return curves


def _cooling(run: ParticleResult, e: float) -> Theories:
    """The temperatures of a homogeneous gas with this ε."""
    rubs = run.settings.has_friction
    if e == 1.0 and not rubs:
        return {}
    name = "homogeneous gas with friction" if rubs else "Haff’s law"
    return {
        key: (name, values) for key, values in run.cooling_of_theory().items() if key != "temperature_ratio"
    }
