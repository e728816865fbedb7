"""Plots of a variable of a sweep: a map over two parameters, or a line over one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator, NullLocator
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_cdt, minimum_filter

from .labels import axis_label, axis_scale
from .style import MAX_COUNTED, MISSING, PAGE_WIDTH, PALETTE, count_colours, style

if TYPE_CHECKING:
    import xarray as xr

MAX_CELLS: Final = 2000  #: along a side of a map; larger maps are thinned
LABEL_SIZES: Final = (9.0, 7.5, 6.0)  #: [points] font sizes of the counts on a map
STROKE_WIDTH: Final = 1.8  #: [points] white outline of the counts
RATIOS: Final = ("restitution_ratio", "restitution_ratio_at_separation")


def count_map(ds: xr.Dataset, variable: str = "n_contacts") -> Figure:
    """Map of a variable of a two-dimensional sweep; the first dimension is the x axis.

    Contact counts have the colours of :func:`count_colours` and are written into their regions; the colours of
    ratios are centred at 1.

    Raises a ValueError if the variable is missing or does not have two dimensions.
    """
    array = _plane(ds, variable)
    if variable == "n_contacts":
        return _draw_counts(array)
    finite = array.values[np.isfinite(array.values)]
    factor, label = _scaled_label(variable, array.attrs, finite)
    values, finite = array.values * factor, finite * factor
    if variable in RATIOS:
        top = max(float(finite.max(initial=1.0)), 1.1)
        return _draw_plane(array, values, label, _white_at(0.0, 1.0, top), Normalize(0.0, top))
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    norm = Normalize(low, high if high > low else low + 1.0)
    return _draw_plane(array, values, label, "cividis", norm)


def _scaled_label(name: str, attrs: dict[str, Any], values: NDArray[Any]) -> tuple[float, str]:
    """Factor for the values, and the label with the resulting unit."""
    largest = float(np.abs(np.asarray(values, dtype=float)).max(initial=0.0))
    return axis_scale(name, attrs, largest)[0], axis_label(name, attrs, largest)


def difference_map(
    newton: xr.Dataset, independent: xr.Dataset, variable: str = "relative_velocity"
) -> Figure:
    """Map of newton − independent for a variable of two sweeps over the same axes; white is agreement.

    Raises a ValueError if the variable is missing in one, or the axes differ.
    """
    first, second = _plane(newton, variable), _plane(independent, variable)
    if first.dims != second.dims or any(not np.array_equal(first[d], second[d]) for d in first.dims):
        raise ValueError("independent: got other axes, must have those of newton")
    difference = first.values.astype(float) - second.values.astype(float)
    finite = difference[np.isfinite(difference)]
    factor, name = _scaled_label(variable, dict(newton[variable].attrs), finite)
    difference, finite = difference * factor, finite * factor
    low = float(finite.min(initial=0.0))
    high = max(float(finite.max(initial=0.0)), 1e-3 * abs(low)) or 1.0
    label = f"{name}: Newton − independent"
    return _draw_plane(first, difference, label, _white_at(low, 0.0, high), Normalize(low, high))


def _plane(ds: xr.Dataset, variable: str) -> xr.DataArray:
    """The variable of a map, thinned to the resolution of a picture."""
    if variable not in ds:
        raise ValueError(f"variable: got {variable!r}, must be one of {', '.join(map(str, ds.data_vars))}")
    if ds[variable].ndim != 2:
        raise ValueError(f"{variable}: got {ds[variable].ndim} dimensions, must have 2 for a map")
    step = [slice(None, None, math.ceil(n / MAX_CELLS)) for n in ds[variable].shape]
    return ds[variable][step[0], step[1]].load()


def _white_at(low: float, middle: float, high: float) -> Colormap:
    """Colours from blue over white at ``middle`` to orange; equal distances from it are equally strong."""
    distance = np.linspace(low, high, 512) - middle
    strength = distance / max(middle - low, high - middle)
    below = mpl.colormaps["Blues"](np.clip(-strength, 0.0, 1.0))
    above = mpl.colormaps["Oranges"](np.clip(strength, 0.0, 1.0))
    colours = np.where((distance < 0.0)[:, None], below, above)
    faint = np.clip(np.abs(strength) / 0.02, 0.0, 1.0)[:, None]  # both maps start slightly off white
    return ListedColormap(1.0 - faint * (1.0 - colours)).with_extremes(bad=MISSING)


def is_logarithmic(values: NDArray[Any]) -> bool:
    """Whether the points on an axis are spaced by nearly equal ratios rather than by nearly equal differences."""
    v = np.asarray(values, dtype=float)
    if v.size < 3 or not np.all(v > 0.0) or v.max() < 20.0 * v.min():
        return False
    factors, differences = np.diff(np.log(v)), np.diff(v)
    return bool(np.std(factors) / abs(np.mean(factors)) < np.std(differences) / abs(np.mean(differences)))


def _edges(values: NDArray[Any]) -> tuple[NDArray[np.float64], bool]:
    """Borders of the cells, halfway between points on the scale of the axis, and whether it is logarithmic."""
    logarithmic = is_logarithmic(values)
    v = np.log(values) if logarithmic else np.asarray(values, dtype=float)
    if v.size == 1:
        edges = np.array([v[0] - 0.5, v[0] + 0.5])
    else:
        middle = 0.5 * (v[1:] + v[:-1])
        edges = np.concatenate([[2 * v[0] - middle[0]], middle, [2 * v[-1] - middle[-1]]])
    return (np.exp(edges) if logarithmic else edges), logarithmic


def _draw_plane(
    array: xr.DataArray, values: NDArray[Any], label: str, cmap: Any, norm: Normalize, **bar: Any
) -> Figure:
    """A map with its colour bar."""
    with style(xtick__direction="out", ytick__direction="out", xtick__top=False, ytick__right=False):
        figure = Figure(figsize=(PAGE_WIDTH * 0.68, PAGE_WIDTH * 0.5))
        ax = figure.subplots()
        axes = [_axis(array, str(dim)) for dim in array.dims]
        edges = [_edges(points) for points, _ in axes]
        cells = np.ma.masked_invalid(values.T)
        mesh = ax.pcolormesh(*(e for e, _ in edges), cells, cmap=cmap, norm=norm, rasterized=True)
        mesh.set_antialiased(False)
        ax.set_facecolor(MISSING)
        ax.set_xscale("log" if edges[0][1] else "linear")
        ax.set_yscale("log" if edges[1][1] else "linear")
        ax.set_xlim(edges[0][0][0], edges[0][0][-1])
        ax.set_ylim(edges[1][0][0], edges[1][0][-1])
        ax.set_xlabel(axes[0][1])
        ax.set_ylabel(axes[1][1])
        colorbar = figure.colorbar(mesh, ax=ax, pad=0.035, **bar)
        colorbar.set_label(label)
        colorbar.ax.minorticks_off()
    return figure


def _axis(array: xr.DataArray | xr.Dataset, dim: str) -> tuple[NDArray[np.float64], str]:
    """The points of an axis in the unit of its label, and the label; indices for a dimension without coordinates."""
    points = np.asarray(array[dim].values, dtype=float)
    factor, label = _scaled_label(dim, dict(array[dim].attrs), points)
    return points * factor, label


def _draw_counts(array: xr.DataArray) -> Figure:
    """A map of counts; the colour bar runs from the lowest to the highest."""
    counts = array.values
    lowest, highest = (int(counts.min()), int(counts.max())) if counts.size else (0, 1)
    cmap, norm = count_colours(highest, lowest)
    shown = np.arange(max(min(lowest, MAX_COUNTED), 0), min(max(highest, 1), MAX_COUNTED) + 1)
    label = axis_label("n_contacts", dict(array.attrs))
    beyond = "max" if highest > MAX_COUNTED else "neither"
    figure = _draw_plane(array, counts, label, cmap, norm, extend=beyond, ticks=shown)
    with style():
        x, y = (_axis(array, str(dim))[0] for dim in array.dims)
        label_regions(figure.axes[0], x, y, counts)
    return figure


def label_regions(ax: Axes, x: NDArray[Any], y: NDArray[Any], counts: NDArray[Any]) -> None:
    """Write each count of a map ``counts[i, j]`` at ``x[i]``, ``y[j]`` into the widest part of its region.

    Uses the largest font size that fits. The count of a region that is too narrow stands outside the map, where the
    region reaches the right or the upper edge. Negative counts, and regions too narrow there as well, get no label.
    """
    step = [max(1, n // 250) for n in counts.shape]
    x, y, coarse = x[:: step[0]], y[:: step[1]], counts[:: step[0], :: step[1]]
    corners = ax.transData.transform([(x[0], y[0]), (x[-1], y[-1])])
    between = np.array(coarse.shape) - 1
    across = np.abs(corners[1] - corners[0]) / np.maximum(between, 1)
    cell = np.where(between > 0, across, ax.get_window_extent().size) * 72.0 / ax.figure.dpi  # [points]
    for count in np.unique(coarse[coarse >= 0]):
        for size in LABEL_SIZES:
            box = np.ceil((_size(count, size) + 2.0 * STROKE_WIDTH) / cell).astype(int)
            fits = minimum_filter(coarse == count, tuple(box), mode="constant")  # centres of labels
            if fits.any():
                i, j = _deepest(fits)
                label = ax.text(x[i], y[j], str(count), ha="center", va="center_baseline", fontsize=size)
                label.set_path_effects([withStroke(linewidth=STROKE_WIDTH, foreground="white")])
                break
        else:
            _label_at_edge(ax, count, (x, y), coarse, cell)


def _size(count: int, size: float) -> NDArray[np.float64]:
    """Approximate width and height of a number [points]."""
    return np.array([0.5 * len(str(count)), 0.66]) * size


def _label_at_edge(
    ax: Axes, count: int, points: Sequence[NDArray[Any]], counts: NDArray[Any], cell: NDArray[np.float64]
) -> None:
    """Write the count outside the map at the longest part of the right or the upper edge, if it fits."""
    for axis, edge in ((1, counts[-1]), (0, counts[:, -1])):
        bounds = np.flatnonzero(np.diff(np.pad(edge == count, 1).astype(int)))
        first, last = max(
            zip(bounds[::2], bounds[1::2], strict=True), key=lambda b: b[1] - b[0], default=(0, 0)
        )
        if (last - first) * cell[axis] > _size(count, LABEL_SIZES[-1])[axis] + 1.0:
            at = points[axis][(first + last) // 2]
            right: dict[str, Any] = {"xycoords": ("axes fraction", "data"), "va": "center_baseline"}
            upper: dict[str, Any] = {"xycoords": ("data", "axes fraction"), "ha": "center"}
            look, where, offset = (right, (1.0, at), (2.0, 0.0)) if axis else (upper, (at, 1.0), (0.0, 2.0))
            ax.annotate(
                str(count), where, offset, textcoords="offset points", fontsize=LABEL_SIZES[-1], **look
            )
            return


def _deepest(inside: NDArray[np.bool_]) -> NDArray[np.int64]:
    """The cell farthest from the border of the region."""
    distance = distance_transform_cdt(np.pad(inside, 1), "taxicab")
    where = np.argwhere(distance == distance.max()) - 1
    deepest: NDArray[np.int64] = where[len(where) // 2]
    return deepest


def sweep_map(ds: xr.Dataset, variable: str = "n_contacts") -> Figure:
    """A variable of a sweep over one or two parameters as a line or a map.

    For a variable with one value per ball, select the ball: ``sweep_map(ds.sel(ball=2), "rebound_height")``. The title
    names it.

    Raises a ValueError if the variable is missing or has more than two dimensions.
    """
    alone = variable in ds and ds[variable].ndim == 1
    figure = _line(ds, variable) if alone else count_map(ds, variable)
    if "ball" in ds[variable].coords:
        figure.axes[0].set_title(f"ball {int(ds['ball'])}")
    return figure


def _line(ds: xr.Dataset, variable: str) -> Figure:
    """A variable over one parameter."""
    dim = str(ds[variable].dims[0])
    x, x_label = _axis(ds, dim)
    values = ds[variable].values
    factor, y_label = _scaled_label(variable, dict(ds[variable].attrs), values[np.isfinite(values)])
    with style():
        figure = Figure(figsize=(PAGE_WIDTH * 0.62, 3.2))
        ax = figure.subplots()
        if variable == "n_contacts":
            ax.step(x, values, where="mid", color=PALETTE["blue"])
            ax.yaxis.set_major_locator(MaxNLocator(integer=True))
            ax.yaxis.set_minor_locator(NullLocator())
        else:
            ax.plot(x, values * factor, color=PALETTE["blue"])
        if is_logarithmic(x):
            ax.set_xscale("log")
        if x.size > 1:
            ax.set_xlim(x.min(), x.max())
        ax.set_xlabel(x_label)
        ax.set_ylabel(y_label)
    return figure
