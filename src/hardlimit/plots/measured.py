"""Plots of measurements in boxes of grains: lines over a coordinate, maps over time, steady states."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ..boxes.box import component_axes
from ..measure.steadiness import Steady
from ..support import validation
from .labels import axis_label, axis_scale
from .style import COLUMN_WIDTH, GREY, PALETTE, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PANEL_HEIGHT: Final = 1.5  #: [inch] of a variable of a Dataset
LABELLED: Final = ("axis", "component", "wall")  #: dimensions with a line for each of their names


def measured(measurement: Any) -> Figure:
    """A picture of a measurement: :func:`hardlimit.measure.plot`."""
    with style():
        if isinstance(measurement, Steady):
            figure, (ax,) = _panels(1)
            _steady(ax, measurement)
        elif isinstance(measurement, xr.Dataset) and "rattler" in measurement:
            figure, (ax,) = _panels(1)
            _contacts(ax, measurement)
        elif isinstance(measurement, xr.Dataset) and "collisional" in measurement:
            figure, (ax,) = _panels(1)
            _stress(ax, measurement)
        elif isinstance(measurement, xr.Dataset):
            shown = [v for v in measurement.data_vars.values() if _kind(v)]
            figure, axes = _panels(_some(measurement, len(shown)), PANEL_HEIGHT)
            for ax, variable in zip(axes, shown, strict=True):
                _draw(figure, ax, variable)
                ax.set_ylabel(ax.get_ylabel().replace(" [", "\n["))
                ax.label_outer()
            figure.align_ylabels(axes)
        else:
            _some(measurement, isinstance(measurement, xr.DataArray) and bool(_kind(measurement)))
            figure, (ax,) = _panels(1)
            _draw(figure, ax, measurement)
    return figure


def _panels(n: int, height: float = 2.5) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=(1.25 * COLUMN_WIDTH, 0.5 + height * n))
    return figure, list(figure.subplots(n, 1, sharex=True, squeeze=False)[:, 0])


def _some(measurement: Any, count: int) -> int:
    if not count:
        need = "must be a measurement over a coordinate, or over time and another"
        raise ValueError(f"measured: got {validation.shown(measurement)}, {need}")
    return count


def _kind(measurement: xr.DataArray) -> str:
    """``"line"``, ``"lines"`` (one for each label), ``"map"``, or empty if there is no picture of it."""
    along = [dim for dim in measurement.dims if dim not in LABELLED]
    numeric = all(dim in measurement.coords and measurement[dim].dtype.kind in "iuf" for dim in along)
    if not numeric or measurement.size == 0 or len(along) not in (1, 2):
        return ""
    if len(along) == 2:
        return "map" if along[0] == "time" and measurement.ndim == 2 else ""
    return {1: "line", 2: "lines"}.get(measurement.ndim, "")


def _scale(measurement: xr.DataArray) -> tuple[float, str]:
    """Factor that gives the unit a prefix, and a label."""
    finite = np.abs(measurement.values[np.isfinite(measurement.values)])
    largest = float(finite.max()) if finite.size else 0.0
    name, attrs = str(measurement.name), dict(measurement.attrs)
    label = axis_label(name, attrs, largest).replace("m2/s²", "m²/s²")
    return axis_scale(name, attrs, largest)[0], label


def _scaled(measurement: xr.DataArray) -> tuple[Any, str]:
    """Values with a prefix of their unit, and a label."""
    factor, label = _scale(measurement)
    return measurement.values * factor, label


def _draw(figure: Figure, ax: Axes, measurement: xr.DataArray) -> None:
    if _kind(measurement) == "map":
        (time, when), (at, where) = (_scaled(measurement[dim]) for dim in measurement.dims)
        values, label = _scaled(measurement)
        image = ax.pcolormesh(time, at, values.T, shading="nearest", rasterized=True)
        figure.colorbar(image, ax=ax, label=label)
        ax.set_xlabel(when)
        ax.set_ylabel(where)
        return
    (along,) = (dim for dim in measurement.dims if dim not in LABELLED)
    if along == "lag":  # over decades, from ballistic flight to diffusion
        measurement = measurement[measurement["lag"] > 0.0]
        if (measurement > 0.0).any():
            ax.loglog()
    at, where = _scaled(measurement[along])
    values, label = _scaled(measurement.transpose(along, ...))
    if measurement.name == "rdf":
        ax.axhline(1.0, color=GREY, lw=0.8)
    ax.plot(at, values)
    for dim in set(LABELLED).intersection(measurement.dims):
        ax.legend(ax.lines, measurement[dim].values.tolist(), ncols=3)
    ax.set_xlabel(where)
    ax.set_ylabel(label)


def _steady(ax: Axes, result: Steady) -> None:
    """The series, what is left out, and the mean with its 95 % confidence interval."""
    along = str(result.series.dims[0])
    at, where = _scaled(result.series[along])
    factor, label = _scale(result.series)
    ax.plot(at, result.series.values * factor, color=PALETTE["sky"], lw=0.9)
    if result.n_discarded:
        ax.axvspan(at[0], at[result.n_discarded], color="0.9", lw=0.0, label="equilibration")
    steady = at[result.n_discarded :]
    ax.plot(steady, np.full(len(steady), factor * result.mean.value), color="black", label="mean, 95 %")
    ax.fill_between(
        steady, factor * result.mean.lower, factor * result.mean.upper, color="black", alpha=0.25, lw=0.0
    )
    ax.set_xlim(at[0], at[-1])
    ax.set_xlabel(where)
    ax.set_ylabel(label)
    ax.legend()


def _stress(ax: Axes, measurement: xr.Dataset) -> None:
    """Bars of both parts of each component of a pressure tensor, with the standard errors."""
    names = measurement["row"].values.tolist()
    first, second = component_axes(len(names))
    factor, label = _scale(measurement["pressure_tensor"])
    places = np.arange(len(first))
    for shift, name in ((-0.2, "kinetic"), (0.2, "collisional")):
        values, errors = (
            factor * measurement[part].values[first, second] for part in (name, f"{name}_error")
        )
        colour = PALETTE["blue" if shift < 0.0 else "orange"]
        ax.bar(places + shift, values, 0.4, yerr=errors, color=colour, label=name)
    ax.axhline(0.0, color=GREY, lw=0.8)
    ax.set_xticks(places, [names[i] + names[j] for i, j in zip(first, second, strict=True)])
    ax.set_xlabel("component")
    ax.set_ylabel(label)
    ax.legend()


def _contacts(ax: Axes, measurement: xr.Dataset) -> None:
    """Share of the particles over the number of contacts, with the rattlers."""
    contacts, rattler = measurement["contacts"].values, measurement["rattler"].values
    bins = np.arange(int(contacts.max()) + 2)
    counts = np.stack([np.bincount(contacts[kept], minlength=len(bins) - 1) for kept in (~rattler, rattler)])
    kept, loose = counts / len(contacts)
    ax.bar(bins[:-1], kept, color=PALETTE["blue"], label="backbone")
    ax.bar(bins[:-1], loose, bottom=kept, color=PALETTE["orange"], label="rattlers")
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.xaxis.set_minor_locator(MaxNLocator(integer=True, nbins=1))
    ax.set_xlabel("contacts of a particle")
    ax.set_ylabel("fraction of the particles")
    ax.legend()
