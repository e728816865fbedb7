"""Pictures of results: forces, heights, maps. Only drawing; every number comes from a result.

All pictures share one style (:func:`style`), one palette that colour-blind readers can tell apart, and one
colour for each number of contacts (:func:`count_colours`), so that pictures can be compared with each other.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import matplotlib as mpl
import numpy as np
from cycler import cycler
from matplotlib.colors import BoundaryNorm, Colormap, ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from ..models import MODELS

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from ..column.result import Result
    from ..contact import Contact

#: Okabe and Ito's palette (2008), by name.
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

COLUMN_WIDTH: Final = 3.4  #: [inch] one column of a journal page
PAGE_WIDTH: Final = 7.0  #: [inch] both columns

STYLE: Final[dict[str, Any]] = {
    "font.family": "STIXGeneral",  # these fonts come with matplotlib: the same picture everywhere
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

# Contact counts: 0 white, 1 to 15 Paul Tol's discrete rainbow (2021), whose hue changes every third count so
# that a count can be read from its colour; darker still beyond. Missing values are grey.
# fmt: off
COUNT_COLOURS: Final = (
    "#ffffff",
    "#d1bbd7", "#ae76a3", "#882e72",
    "#1965b0", "#5289c7", "#7bafde",
    "#4eb265", "#90c987", "#cae0ab",
    "#f7f056", "#f6c141", "#f1932d",
    "#e8601c", "#dc050c", "#72190e",
)
# fmt: on
MOST_CELLS: Final = 2000  #: of a map along one side; more cannot be seen
MORE_CONTACTS: Final = "#1a1a1a"
MISSING: Final = "#777777"

# Label and unit of what can be swept or mapped; a variable's own attributes come first.
QUANTITIES: Final = {
    "restitution": (r"coefficient of restitution $\varepsilon$", ""),
    "gap": (r"initial gap $\Delta h$", "m"),
    "radius_ratio": (r"ratio of radii $R_1/R_2$", ""),
    "radius_1": (r"radius of the lower ball $R_1$", "m"),
    "radius_2": (r"radius of the upper ball $R_2$", "m"),
    "density": (r"density $\rho$", "kg/m³"),
    "stiffness": (r"stiffness $k$", "N/m"),
    "damping": (r"damping $\gamma$", "N s/m"),
    "height": (r"release height $z_1^{(0)}$", "m"),
    "gravity": (r"gravity $g$", "m/s²"),
    "youngs_modulus": (r"Young’s modulus $Y$", "Pa"),
    "poisson_ratio": (r"Poisson’s ratio $\nu$", ""),
    "dissipative_time": (r"dissipative time $A$", "s"),
    "impact_speed": (r"speed of impact", "m/s"),
    "n_contacts": ("ball–ball contacts", ""),
    "relative_velocity": (r"relative velocity $v'_r$ at $t_f$", "m/s"),
    "separation_velocity": ("separation velocity", "m/s"),
    "effective_restitution": (r"effective restitution $\varepsilon_\mathrm{eff}$", ""),
    "restitution_ratio": (r"$\varepsilon_\mathrm{eff}/\varepsilon$", ""),
    "effective_restitution_at_separation": (r"$\varepsilon_\mathrm{eff}$ at separation", ""),
    "restitution_ratio_at_separation": (r"$\varepsilon_\mathrm{eff}/\varepsilon$ at separation", ""),
    "t_end": (r"end of the sequence $t_f$", "s"),
    "t_floor_end": ("end of the floor contact", "s"),
}
RATIOS: Final = ("restitution_ratio", "restitution_ratio_at_separation")


@contextmanager
def style(**changes: Any) -> Iterator[None]:
    """The shared look as a context: ``with style(): figure = Figure(…)``; ``changes`` override rcParams."""
    settings: Any = STYLE | {key.replace("__", "."): value for key, value in changes.items()}
    with mpl.rc_context(settings):
        yield


def save(figure: Figure, path: str | Path) -> Path:
    """Write the figure by the ending of ``path`` (png, pdf, svg, …).

    Raises
    ------
    ValueError
        If the ending is unknown or the file cannot be written.
    """
    target = Path(path)
    known = figure.canvas.get_supported_filetypes()
    ending = target.suffix.lstrip(".").lower()
    if ending not in known:
        raise ValueError(f"plot: got {str(path)!r}, must end in one of .{' .'.join(sorted(known))}")
    try:
        with style():
            figure.savefig(target)
    except OSError as error:
        raise ValueError(f"plot: got {str(path)!r}, must be writable: {error.strerror or error}") from None
    return target


def pair_label(pair: int) -> str:
    """F01 for the floor and the lowest ball, F12 for the next pair, …, as mathematical text."""
    return f"$F_{{{pair}{pair + 1}}}$" if pair < 9 else f"$F_{{{pair},{pair + 1}}}$"


def pair_colour(pair: int) -> str:
    """The colour that a pair has in every picture."""
    names = ("vermillion", "blue", "green", "purple", "orange", "sky", "black")
    return PALETTE[names[pair % len(names)]]


def ball_colour(ball: int) -> str:
    """The colour that ball 1, 2, … has in every picture: that of the contact below it."""
    return pair_colour(ball - 1)


def count_colours(highest: int) -> tuple[Colormap, BoundaryNorm]:
    """Colour map and norm for counts 0 … ``highest``; a count has the same colour whatever ``highest`` is.

    Above 15 everything shares one dark colour; missing values are grey.
    """
    shown = min(max(int(highest), 1), len(COUNT_COLOURS) - 1)
    colours = COUNT_COLOURS[: shown + 1]
    cmap = ListedColormap(colours, "contacts").with_extremes(over=MORE_CONTACTS, bad=MISSING)
    return cmap, BoundaryNorm(np.arange(-0.5, shown + 1.0), shown + 1)


def scaled(largest: float, unit: str) -> tuple[float, str]:
    """Factor and prefixed unit that bring ``largest`` between 1 and 1000: ``(1e-3, "kN")``."""
    if not (math.isfinite(largest) and largest > 0.0):
        return 1.0, unit
    exponent = min(max(3 * math.floor(math.log10(largest * 1.0000001) / 3), -12), 9)
    prefix = {-12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}[exponent]
    return 10.0**-exponent, prefix + unit


# --- forces -------------------------------------------------------------------------------------------------


def force_curve(
    result: Result, pair: int, stop: float, samples: int = 200
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Times [s] and forces [N] of one pair as a line: each contact from begin to end, zero in between."""
    begin, end = _contacts_of(result, pair)
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


def _contacts_of(result: Result, pair: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    table = result.contacts
    mine = table["pair"].values == pair
    return table["begin"].values[mine], table["end"].values[mine]


def pairs_of(result: Result) -> list[int]:
    return list(range(0 if result.column.floor else 1, len(result.column.balls)))


def window(results: Iterable[Result]) -> tuple[float, float]:
    """The time span in which the contacts lie, with a margin."""
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
        figure = Figure(figsize=(PAGE_WIDTH * 0.72, 1.0 + 1.25 * len(pairs)))
        axes = figure.subplots(len(pairs), 1, sharex=True, squeeze=False)[:, 0]
        draw_forces(list(axes), result, None)
    return figure


def draw_forces(axes: list[Axes], result: Result, ghost: Result | None) -> None:
    """Forces of ``result``, one panel for each pair, top pair first; instants of ``ghost`` as arrows."""
    start, stop = window([result] if ghost is None else [result, ghost])
    factor, unit = scaled(stop, "s")
    for ax, pair in zip(axes, reversed(pairs_of(result)), strict=True):
        if result.model == "independent":
            _draw_instants(ax, _contacts_of(result, pair)[0] * factor, pair_colour(pair))
            ax.set_yticks([])
            ax.set_ylim(0.0, 1.35)
            ax.set_ylabel(f"{pair_label(pair)}\n(impulses)")
        else:
            _draw_force(ax, result, pair, (start, stop), factor)
            if ghost is not None:
                _draw_instants(ax, _contacts_of(ghost, pair)[0] * factor, GREY)
        if math.isfinite(result.t_end):
            ax.axvline(result.t_end * factor, color="black", lw=0.8, ls=(0, (4, 3)))
    if math.isfinite(result.t_end):
        axes[0].annotate(
            "$t_f$",
            (result.t_end * factor, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(0, 3),
            textcoords="offset points",
            ha="center",
            va="bottom",
        )
    axes[-1].set_xlim(start * factor, stop * factor)
    since = "the first floor touch" if result.column.floor else "release"
    axes[-1].set_xlabel(f"time after {since} [{unit}]")


def _draw_force(ax: Axes, result: Result, pair: int, window: tuple[float, float], time_factor: float) -> None:
    times, values = force_curve(result, pair, window[1])
    factor, unit = scaled(float(values.max(initial=0.0)), "N")
    colour = pair_colour(pair)
    t = np.concatenate([[window[0]], times, [window[1]]]) * time_factor
    f = np.concatenate([[0.0], values, [values[-1] if _never_ends(result, pair) else 0.0]]) * factor
    ax.plot(t, f, color=colour)
    ax.fill_between(t, f, color=colour, alpha=0.15, lw=0)
    ax.set_ylabel(f"{pair_label(pair)} [{unit}]")
    ax.set_ylim(0.0, 1.3 * float(f.max(initial=0.0)) or 1.0)
    n = len(_contacts_of(result, pair)[0])
    with_whom = "floor" if pair == 0 else f"balls {pair}–{pair + 1}"
    count = "no contact" if n == 0 else "1 contact" if n == 1 else f"{n} contacts"
    label = ax.text(0.988, 0.93, f"{with_whom}: {count}", transform=ax.transAxes, ha="right", va="top")
    label.set_path_effects([withStroke(linewidth=3.0, foreground="white")])
    label.set_zorder(5)


def _never_ends(result: Result, pair: int) -> bool:
    end = _contacts_of(result, pair)[1]
    return bool(len(end)) and math.isnan(end[-1])


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


# --- heights ------------------------------------------------------------------------------------------------

_LINE_OF_MODEL: Final = {"newton": "-", "independent": (0, (5, 2)), "adiabatic": (0, (1, 1.2))}


def heights(*results: Result, until: float | None = None) -> Figure:
    """Heights of the centres over time, from release on; full lines Newton, dashed independent collisions.

    ``until`` [s] defaults to somewhat after the time it takes to fall again from the height reached.
    """
    with style():
        figure = Figure(figsize=(PAGE_WIDTH * 0.72, 3.2))
        _draw_heights(figure.subplots(), results, until)
    return figure


def release_time(result: Result) -> float:
    """When the column was released [s], on the clock of the result: negative, or 0 for a cradle."""
    return float(result._core.t_first)


def _heights_until(results: Iterable[Result]) -> float:
    """``until`` if given, else a third longer after the first floor touch than the fall before it took."""
    span = 0.0
    for result in results:
        release = -release_time(result) if result.column.floor else 0.0
        sequence = window([result])[1]
        span = max(span, result.until if result.until is not None else max(1.3 * release, 3.0 * sequence))
    return span


def _draw_heights(ax: Axes, results: tuple[Result, ...], until: float | None) -> None:
    stop = _heights_until(results) if until is None else until
    start = min(min(release_time(r) for r in results), 0.0)
    factor, unit = scaled(max(stop, -start), "s")
    for result in results:
        marks = result.contacts["begin"].values
        marks = marks[(marks > start) & (marks < stop)]
        times = np.unique(np.concatenate([np.linspace(start, stop, 600), marks]))
        z = result.trajectory(times)["position"].values
        if not result.column.floor:
            z = (z - result.column.initial_positions) * 1e3
        for i in range(z.shape[1]):
            colour = ball_colour(i + 1)
            ax.plot(times * factor, z[:, i], color=colour, ls=_LINE_OF_MODEL[result.model])
    if len(results[0].column.balls) <= 5:
        for ball in range(len(results[0].column.balls), 0, -1):
            ax.plot([], [], color=ball_colour(ball), label=f"ball {ball}")
    for result in results:
        name, line = MODELS[result.model].label, _LINE_OF_MODEL[result.model]
        ax.plot([], [], color="black", ls=line, label=name)
    ax.set_xlim(start * factor, stop * factor)
    if results[0].column.floor:
        ax.set_ylim(bottom=0.0)
        ax.set_ylabel("height of the centre [m]")
        ax.set_xlabel(f"time after the first floor touch [{unit}]")
    else:
        ax.set_ylabel("displacement [mm]")
        ax.set_xlabel(f"time after release [{unit}]")
    ax.legend(loc="best")


def drop(newton: Result, independent: Result, adiabatic: Result | None = None) -> Figure:
    """One drop at a glance: forces through the contacts, and heights over the whole fall and rebound.

    Grey arrows are the instants of the independent-collisions model.
    """
    results = tuple(r for r in (newton, independent, adiabatic) if r is not None)
    with style():
        pairs = pairs_of(newton)
        figure = Figure(figsize=(PAGE_WIDTH, max(3.2, 1.0 + 1.15 * len(pairs))))
        parts: Any = figure.subfigures(1, 2, width_ratios=(1.15, 1.0))
        left, right = parts
        axes = left.subplots(len(pairs), 1, sharex=True, squeeze=False)[:, 0]
        draw_forces(list(axes), newton, independent)
        axes[0].set_title("contact forces", loc="left", fontsize=10)
        if len(independent.contacts["pair"]):
            note = "grey arrows: instants of the independent-collisions model"
            left.supxlabel(note, fontsize=8.5, color="#555555")
        ax = right.subplots()
        _draw_heights(ax, results, None)
        ax.set_title("heights" if newton.column.floor else "displacements", loc="left", fontsize=10)
    return figure


# --- one contact --------------------------------------------------------------------------------------------


def restitution_over_speed(contact: Contact, speeds: NDArray[np.float64]) -> Figure:
    """Coefficient of restitution and duration of one isolated contact over the speed of impact [m/s]."""
    with style():
        figure = Figure(figsize=(PAGE_WIDTH * 0.6, 4.0))
        upper, lower = figure.subplots(2, 1, sharex=True)
        upper.plot(speeds, contact.restitution(speeds), color=PALETTE["blue"])
        upper.set_ylabel(r"coefficient of restitution $\varepsilon$")
        upper.set_ylim(0.0, 1.05)
        duration = np.asarray(contact.duration(speeds))
        factor, unit = scaled(float(duration.max()), "s")
        lower.plot(speeds, duration * factor, color=PALETTE["vermillion"])
        lower.set_ylabel(f"duration [{unit}]")
        lower.set_ylim(0.0, 1.1 * float(duration.max()) * factor)
        lower.set_xscale("log")
        lower.set_xlim(speeds[0], speeds[-1])
        lower.set_xlabel("speed of impact [m/s]")
    return figure


def restitution_obtained(asked: NDArray[np.float64], curves: dict[str, NDArray[np.float64]]) -> Figure:
    """Restitution obtained over restitution asked for; one curve for each way to choose the damping."""
    with style():
        figure = Figure(figsize=(COLUMN_WIDTH * 1.15, COLUMN_WIDTH * 1.05))
        ax = figure.subplots()
        for (name, obtained), line in zip(curves.items(), ("-", (0, (5, 2)), (0, (1, 1.2))), strict=False):
            ax.plot(asked, obtained, ls=line, label=name)
        ax.set_xlabel(r"$\varepsilon$ asked for")
        ax.set_ylabel(r"$\varepsilon$ obtained")
        ax.set_xlim(0.0, 1.0)
        ax.set_ylim(0.0, 1.02)
        ax.legend(loc="lower right")
    return figure


# --- maps ---------------------------------------------------------------------------------------------------


def axis_label(name: str, attrs: dict[str, Any] | None = None) -> str:
    """Label of a parameter or a variable with its unit, such as ``initial gap Δh [m]``."""
    label, unit = QUANTITIES.get(name, (str((attrs or {}).get("long_name", name)), ""))
    unit = str((attrs or {}).get("units", unit))
    unit = re.sub(r"(?<=[a-z])([23])$", lambda m: {"2": "²", "3": "³"}[m[1]], unit)
    return label if unit in ("", "1") else f"{label} [{unit}]"


def count_map(ds: xr.Dataset, variable: str = "n_contacts") -> Figure:
    """Map of one variable of a two-dimensional sweep; the first dimension runs to the right.

    Contact counts have the colours of :func:`count_colours` and are written into their regions; ratios are
    centred at 1.

    Raises
    ------
    ValueError
        If the variable is missing or does not have two dimensions.
    """
    array = _plane(ds, variable)
    values = array.values
    label = axis_label(variable, dict(ds[variable].attrs))
    if variable == "n_contacts":
        return _draw_counts(array, values, label)
    if variable in RATIOS:
        top = max(float(np.nanmax(values, initial=1.0)), 1.1)
        return _draw_plane(array, values, label, _white_at(0.0, 1.0, top), Normalize(0.0, top))
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    norm = Normalize(low, high if high > low else low + 1.0)
    return _draw_plane(array, values, label, "cividis", norm)


def difference_map(
    newton: xr.Dataset, independent: xr.Dataset, variable: str = "relative_velocity"
) -> Figure:
    """Map of newton − independent of one variable of two sweeps over the same two axes; white is agreement.

    Raises
    ------
    ValueError
        If the variable is missing in one, or the axes differ.
    """
    first, second = _plane(newton, variable), _plane(independent, variable)
    if first.dims != second.dims or any(not np.array_equal(first[d], second[d]) for d in first.dims):
        raise ValueError("independent: its axes differ from those of newton, must be the same")
    difference = first.values.astype(float) - second.values.astype(float)
    low = min(float(np.nanmin(difference, initial=0.0)), 0.0)
    high = max(float(np.nanmax(difference, initial=0.0)), 0.0, 1e-3 * abs(low)) or 1.0
    name = axis_label(variable, dict(newton[variable].attrs))
    label = f"{name}: Newton − independent"
    return _draw_plane(first, difference, label, _white_at(low, 0.0, high), Normalize(low, high))


def _plane(ds: xr.Dataset, variable: str) -> xr.DataArray:
    """The variable of a map, thinned out to what a picture can show."""
    if variable not in ds:
        raise ValueError(f"variable: got {variable!r}, must be one of {', '.join(map(str, ds.data_vars))}")
    if ds[variable].ndim != 2:
        raise ValueError(f"{variable}: got {ds[variable].ndim} dimensions, a map must have 2")
    step = [slice(None, None, math.ceil(n / MOST_CELLS)) for n in ds[variable].shape]
    return ds[variable][step[0], step[1]].load()


def _white_at(low: float, middle: float, high: float) -> Colormap:
    """Blue below ``middle``, white there, orange above; equal distances are equally strong on both sides."""
    distance = np.linspace(low, high, 512) - middle
    strength = distance / max(middle - low, high - middle)
    below = mpl.colormaps["Blues"](np.clip(-strength, 0.0, 1.0))
    above = mpl.colormaps["Oranges"](np.clip(strength, 0.0, 1.0))
    colours = np.where((distance < 0.0)[:, None], below, above)
    faint = np.clip(np.abs(strength) / 0.02, 0.0, 1.0)[:, None]  # both maps start off white
    return ListedColormap(1.0 - faint * (1.0 - colours)).with_extremes(bad=MISSING)


def is_logarithmic(values: NDArray[Any]) -> bool:
    """Whether points on an axis are spread by factors rather than by differences."""
    v = np.asarray(values, dtype=float)
    if v.size < 3 or not np.all(v > 0.0) or v.max() < 20.0 * v.min():
        return False
    factors, differences = np.diff(np.log(v)), np.diff(v)
    return bool(np.std(factors) / abs(np.mean(factors)) < np.std(differences) / abs(np.mean(differences)))


def _edges(values: NDArray[Any]) -> tuple[NDArray[np.float64], bool]:
    """Borders of the cells around points, halfway in the scale of the axis, and whether that is log."""
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
    with style(xtick__direction="out", ytick__direction="out", xtick__top=False, ytick__right=False):
        figure = Figure(figsize=(PAGE_WIDTH * 0.68, PAGE_WIDTH * 0.5))
        ax = figure.subplots()
        scales = []
        edges = []
        for dim in array.dims:
            borders, logarithmic = _edges(array[dim].values)
            edges.append(borders)
            scales.append("log" if logarithmic else "linear")
        mesh = ax.pcolormesh(
            edges[0], edges[1], np.ma.masked_invalid(values.T), cmap=cmap, norm=norm, rasterized=True
        )
        mesh.set_antialiased(False)
        ax.set_facecolor(MISSING)
        ax.set_xscale(scales[0])
        ax.set_yscale(scales[1])
        ax.set_xlim(edges[0][0], edges[0][-1])
        ax.set_ylim(edges[1][0], edges[1][-1])
        ax.set_xlabel(axis_label(str(array.dims[0]), dict(array[array.dims[0]].attrs)))
        ax.set_ylabel(axis_label(str(array.dims[1]), dict(array[array.dims[1]].attrs)))
        colorbar = figure.colorbar(mesh, ax=ax, pad=0.02, **bar)
        colorbar.set_label(label)
        colorbar.ax.minorticks_off()
    return figure


def _draw_counts(array: xr.DataArray, values: NDArray[Any], label: str) -> Figure:
    highest = int(values.max(initial=1))
    cmap, norm = count_colours(highest)
    shown = min(max(highest, 1), len(COUNT_COLOURS) - 1)
    figure = _draw_plane(
        array,
        values,
        label,
        cmap,
        norm,
        extend="max" if highest > shown else "neither",
        ticks=np.arange(shown + 1),
    )
    with style():
        label_regions(figure.axes[0], array[array.dims[0]].values, array[array.dims[1]].values, values)
    return figure


def label_regions(
    ax: Axes, x: NDArray[Any], y: NDArray[Any], counts: NDArray[Any], smallest: float = 0.022
) -> None:
    """Write each count into the widest part of its region of a map ``counts[i, j]`` at ``x[i]``, ``y[j]``.

    Regions that are narrower than ``smallest`` of the map stay without a label.
    """
    step = tuple(max(1, n // 250) for n in counts.shape)
    coarse = counts[:: step[0], :: step[1]]
    for count in np.unique(coarse):
        inside = np.pad(coarse == count, 1)
        depth = 0
        while True:  # peel the region until nothing is left: what goes last lies deepest
            peeled = inside & np.roll(inside, 1, 0) & np.roll(inside, -1, 0)
            peeled &= np.roll(inside, 1, 1) & np.roll(inside, -1, 1)
            depth += 1
            if not peeled.any():
                break
            inside = peeled
        if depth < smallest * min(coarse.shape):
            continue
        where = np.argwhere(inside) - 1
        i, j = where[len(where) // 2]
        text = ax.text(
            x[:: step[0]][i],
            y[:: step[1]][j],
            str(count),
            ha="center",
            va="center",
            fontsize=9,
            color="black",
            clip_on=True,
        )
        text.set_path_effects([withStroke(linewidth=1.8, foreground="white")])


def sweep_map(ds: xr.Dataset, variable: str = "n_contacts") -> Figure:
    """One variable of a sweep over one or two parameters: a line or a map.

    Raises
    ------
    ValueError
        If the variable is missing or has more than two dimensions.
    """
    if variable not in ds or ds[variable].ndim != 1:
        return count_map(ds, variable)
    dim = str(ds[variable].dims[0])
    x = ds[dim].values if dim in ds.coords else np.arange(ds.sizes[dim])
    with style():
        figure = Figure(figsize=(PAGE_WIDTH * 0.62, 3.2))
        ax = figure.subplots()
        if variable == "n_contacts":
            ax.step(x, ds[variable].values, where="mid", color=PALETTE["blue"])
        else:
            ax.plot(x, ds[variable].values, color=PALETTE["blue"])
        if is_logarithmic(x):
            ax.set_xscale("log")
        ax.set_xlim(x.min(), x.max())
        ax.set_xlabel(axis_label(dim, dict(ds[dim].attrs)))
        ax.set_ylabel(axis_label(variable, dict(ds[variable].attrs)))
    return figure
