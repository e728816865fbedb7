"""``hardlimit sweep``: compute maps over any parameters of a column of balls."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np
from numpy.typing import NDArray

from ..column import files
from ..column.models import MODELS
from ..column.scenario import Column
from ..support import saving, toml, units, validation
from ..support.formatting import digits, quantity
from ..support.progress import bar
from ..sweep import ENGINES, VARIABLES
from ..sweep import sweep as compute
from ..sweep.parameters import contact_name, geometry
from ..sweep.variables import BALL, OF_BALL
from .job import Entry, changed, entry_options, table_of
from .options import (
    LAW_PARAMETERS,
    F,
    Quantity,
    dpi_option,
    json_option,
    law_options,
    options,
    picture,
    spelled,
    writable,
)
from .printing import console, plain, print_files, print_json, print_warnings, show, table
from .program import Command, goes_on_from

if TYPE_CHECKING:
    import xarray as xr

MAX_POINTS = 10**8
EXPECTED = "must be a number, a list a,b,… or start:stop:count[:log]"

#: The table [sweep] of a job file, without its axes.
SETTINGS = (
    Entry("model", f"Model: {' | '.join(MODELS)}.  [default: newton]"),
    Entry("engine", f"Where the map is computed: {' | '.join(ENGINES)}.  [default: cpu]"),
    Entry("threads", "Number of threads.  [default: all processors; 1 with the engine dask]", kind=int),
    Entry("scheduler", "Address of the scheduler for the engine dask.  [default: this machine]"),
    Entry(
        "tolerance",
        "Local error of an integration step, relative to the impact.  [default: 2.3e-10 or 1e-14]",
        unit="1",
    ),
    Entry(
        "variables",
        f"Variable to compute; repeat for more: {', '.join(VARIABLES)}.",
        many=True,
        option="--variable",
    ),
    Entry("out", "NetCDF file (.nc) or Zarr store (.zarr, written chunk by chunk).", metavar="FILE"),
    Entry("plot", "Map of the first variable, by default the contacts (png, pdf, …).", metavar="FILE"),
    Entry(
        "ball",
        "Ball of the plotted variable, 1 for the lowest, if it has one value per ball.  [default: the highest]",
        kind=int,
    ),
    Entry(
        "difference",
        "Map of the difference in v'r, Newton − independent collisions (png, pdf, …).",
        metavar="FILE",
    ),
)


# --- axes ---------------------------------------------------------------------------------------------------


class Axis(Quantity):
    """A number, a list ``0.5,0.7,0.9``, or ``start:stop:count``, with ``:log`` for equal factors."""

    name = "axis"

    def read(self, option: str, text: str) -> Any:
        return axis(option, text, self.unit)


def axis(name: str, value: Any, unit: str = "1") -> float | NDArray[np.float64]:
    """A number or an array from an option's text or from a value in a TOML file."""
    if isinstance(value, list):
        if not value:
            raise ValueError(f"{name}: got an empty list, must hold at least one number")
        return np.array([_number(f"{name}[{i}]", entry, unit) for i, entry in enumerate(value)])
    if not isinstance(value, str):
        if not validation.is_number(value):
            raise ValueError(f"{name}: got {validation.shown(value)}, {EXPECTED}")
        return _number(name, value, unit)
    if ":" in value:
        return _range(name, value, unit)
    numbers = [_number(name, part, unit) for part in value.split(",")]
    return numbers[0] if len(numbers) == 1 else np.array(numbers)


def _number(name: str, value: Any, unit: str) -> float:
    read = units.number if isinstance(value, str) else units.quantity
    return validation.number(name, read(name, value, unit))


def _range(name: str, text: str, unit: str) -> NDArray[np.float64]:
    """The values of ``start:stop:count`` or ``start:stop:count:log``."""
    shown = validation.shown(text)
    start_text, _, rest = text.partition(":")
    stop_text, *others = rest.split(":")
    if len(others) not in (1, 2) or others[1:] not in ([], ["log"], ["lin"]):
        raise ValueError(f"{name}: got {shown}, {EXPECTED}")
    start, stop = (_number(name, part, unit) for part in (start_text, stop_text))
    try:
        count = int(others[0])
    except ValueError:
        raise ValueError(f"{name}: got {shown}, {EXPECTED}") from None
    if not 1 <= count <= MAX_POINTS:
        raise ValueError(f"{name}: got {validation.shown(count)} points, must be in [1, {MAX_POINTS:.0e}]")
    if others[1:] == ["log"]:
        if not (start > 0.0 and stop > 0.0):
            raise ValueError(f"{name}: got {shown}, must have a start and a stop > 0 for equal factors")
        return np.geomspace(start, stop, count)
    if not math.isfinite(stop - start):
        raise ValueError(f"{name}: got {shown}, must span a finite range")
    return np.linspace(start, stop, count)


def units_of(balls: int) -> dict[str, str]:
    """The unit of each parameter that can be swept in a column with this number of balls."""
    contacts = ["", *(f"_{contact_name(i)}" for i in range(balls))]
    of_laws = {f"{name}{c}": record["unit"] for name, (record, _) in LAW_PARAMETERS.items() for c in contacts}
    return {name: p.unit for name, p in geometry(balls).items()} | of_laws


def geometry_options(function: F) -> F:
    """An option for each parameter of two balls that can be swept, apart from those of the law."""
    decorators = []
    for name, p in geometry(2).items():
        text = f"{p.meaning[0].upper()}{p.meaning[1:]}{'' if p.unit == '1' else f' [{p.unit}]'}."
        decorators.append(click.option(spelled(name), name, type=Axis(p.unit), help=text))
    return options(*decorators)(function)


# --- the command --------------------------------------------------------------------------------------------


@click.command(
    cls=Command,
    aliases={"file": "FILE", "store": "--out FILE.zarr"},
    epilog="\b\nExample:\n  hardlimit sweep --restitution 0.4:1:400 --gap 1um:1cm:400:log --plot map.png",
)
@click.argument("file", required=False, metavar="[JOB.toml]")
@geometry_options
@law_options(Axis)
@entry_options(SETTINGS)
@click.option("--resume", is_flag=True, help="Continue the Zarr store of an interrupted sweep.")
@dpi_option
@json_option("Print the summary as JSON.")
def sweep(file: str | None, resume: bool, dpi: float | None, as_json: bool, **params: Any) -> None:
    """Compute a map over any parameters of a column of balls.

    A parameter is a number, a list 0.5,0.7,0.9, or start:stop:count, with :log for equal factors; numbers may have a
    unit, such as 1um. All other parameters are those of the column in JOB.toml, or of the two balls of Fig. 2 of the
    paper. A job file is a file of `hardlimit drop` with a table [sweep] (model, engine, threads, scheduler, tolerance,
    variables, out, plot, ball, difference) and a table [sweep.axes].
    """
    job = make_job(file, resume, params)
    import xarray  # noqa: F401  # before the sweep, which measures its time

    store = job.out if job.out is not None and job.out.suffix == ".zarr" else None
    with bar("sweep", "points") as report, warnings.catch_warnings(record=True) as repairs:
        warnings.simplefilter("always", UserWarning)
        with goes_on_from(store, "chunks", "the same command with --resume"):
            ds = compute(job.column, store=store, progress=report, **job.run, **job.axes)
    print_warnings("sweep", repairs)
    if job.out is not None and store is None:
        packed = {str(name): {"zlib": True, "complevel": 1} for name in ds.data_vars}
        saving.dataset(ds, job.out, packed)
    draw(ds, job, dpi)
    summary = summarise(ds, job.out)
    if as_json:
        print_json(summary)
    else:
        print_summary(ds, summary)


@dataclass(frozen=True)
class Job:
    """A sweep and its output files."""

    column: Column
    axes: dict[str, Any]  #: a number or an array for each swept parameter
    run: dict[str, Any]  #: arguments of ``hardlimit.sweep``
    out: Path | None
    pictures: dict[str, Path | None]  #: "plot" and "difference"
    ball: int | None  #: ball of the plotted variable; None if it has one value for all balls


def make_job(file: str | None, resume: bool, params: dict[str, Any]) -> Job:
    """The job of a file, or of Fig. 2 without a file, changed by the options."""
    base = files.of_column(Column.paper())
    content: dict[str, Any] = {}
    if file is not None:
        base, extra = files.read_with(file, "sweep")
        check = table_of(SETTINGS, {"axes": lambda name, value: _axes(name, value, len(base.balls))})
        content = files.prefixed(f"{file}: ", lambda: check("sweep", extra.get("sweep", {})))
    axes = content.pop("axes", {})
    settings = changed(content, SETTINGS, params)
    column, swept = column_and_axes(base, params, axes)
    if not swept:
        raise ValueError("axes: got none, must be at least one, such as --restitution 0.4:1:100")
    pictures = {name: picture(name, settings.pop(name, None)) for name in ("plot", "difference")}
    dimensions = sum(1 for value in swept.values() if np.ndim(value))
    out = checked_output(settings.pop("out", None), resume)
    if "variables" in settings:
        wanted = settings["variables"]
        wanted = (wanted,) if isinstance(wanted, str) else tuple(wanted)
        settings["variables"] = (*wanted, "relative_velocity") if pictures["difference"] else wanted
    check_pictures(pictures, dimensions, len(column.balls))
    variable = settings.get("variables", ("n_contacts",))[0]
    ball = plotted_ball(settings.pop("ball", None), variable, len(column.balls))
    return Job(column, swept, settings, out, pictures, ball)


def plotted_ball(ball: int | None, variable: str, balls: int) -> int | None:
    """The ball of a variable with one value per ball, the highest one if none is given; None for other variables."""
    if variable in OF_BALL:
        return balls if ball is None else validation.whole("ball", ball, 1, balls)
    if ball is not None:
        shown = ", ".join(OF_BALL)
        raise ValueError(
            f"ball: got {ball}, must be left out for {variable}; {shown} have one value per ball"
        )
    return None


def check_pictures(pictures: dict[str, Path | None], dimensions: int, balls: int) -> None:
    """Refuse pictures that cannot be drawn, before the map is computed."""
    got = f"got {dimensions} swept parameter{'s' * (dimensions != 1)}"
    if pictures["plot"] and dimensions > 2:
        raise ValueError(f"--plot: {got}, must be one or two to be drawn")
    if pictures["difference"]:
        if dimensions != 2:
            raise ValueError(f"--difference: {got}, must be two for a map")
        if balls != 2:
            raise ValueError(
                f"--difference: got {balls} balls, must be 2: it is that of their relative velocity"
            )


def _axes(name: str, content: Any, balls: int) -> dict[str, Any]:
    """Check the table [sweep.axes]; the order of its keys is that of the dimensions."""
    kinds = {key: lambda n, value, unit=unit: axis(n, value, unit) for key, unit in units_of(balls).items()}
    return toml.table(name, content, kinds)


def column_and_axes(
    base: files.Scenario, options: dict[str, Any], axes: dict[str, Any]
) -> tuple[Column, dict[str, Any]]:
    """The column, and the swept parameters of the file and then of the options."""
    name = options.pop("law")
    values = {key: value for key, value in options.items() if value is not None}
    values = {key: value for key, value in axes.items() if key not in values} | values
    of_law = {key: values[key] for key in LAW_PARAMETERS if key in values}
    if name is not None or of_law:
        first = {key: float(np.ravel(value)[0]) for key, value in of_law.items()}
        base = files.with_law(base, name, first)
    swept = {key: value for key, value in values.items() if np.ndim(value) or key not in of_law}
    if not any(np.ndim(value) for value in swept.values()):
        swept = {}
    return base.column(), swept


def checked_output(out: str | None, resume: bool) -> Path | None:
    """The path of the map; an existing store is only changed to resume it."""
    if out is None:
        if resume:
            raise ValueError("--resume: must be given with --out, the Zarr store to continue")
        return None
    path = saving.checked("--out", out)
    if path.suffix == ".nc":
        if resume:
            raise ValueError(f"--resume: got --out {out!r}, must be a Zarr store (.zarr)")
        return writable("out", out, ".nc")
    if path.suffix != ".zarr":
        raise ValueError(f"--out: got {out!r}, must end in .nc or .zarr")
    if path.exists() and not resume:
        raise ValueError(f"--out: got {out!r}, must not exist unless --resume is given to continue it")
    return path


def draw(ds: xr.Dataset, job: Job, dpi: float | None) -> None:
    """Draw the requested pictures; the difference requires a second sweep with the other model."""
    if not any(job.pictures.values()):
        return
    from .. import plots

    if job.pictures["plot"]:
        variable = job.run.get("variables", ("n_contacts",))[0]
        shown = ds if job.ball is None else ds.sel({BALL: job.ball})
        plots.save(plots.sweep_map(shown, variable), job.pictures["plot"], dpi)
    if job.pictures["difference"]:
        # A tolerance belongs to the first model; the other one may not accept it.
        needed = {**job.run, "variables": ("relative_velocity",)}
        needed.pop("tolerance", None)
        newton, independent = [
            ds
            if model == ds.attrs["model"]
            else compute(job.column, **(needed | {"model": model}), **job.axes)
            for model in ("newton", "independent")
        ]
        plots.save(plots.difference_map(newton, independent), job.pictures["difference"], dpi)


# --- the summary --------------------------------------------------------------------------------------------


def blocks(ds: xr.Dataset, points: int = 2_000_000) -> Iterator[xr.Dataset]:
    """The map in parts that fit in memory; a store may be larger than memory."""
    dim = max(ds.sizes, key=lambda name: ds.sizes[name])
    step = max(1, points * ds.sizes[dim] // math.prod(ds.sizes.values()))
    for first in range(0, ds.sizes[dim], step):
        yield ds.isel({dim: slice(first, first + step)})


def summarise(ds: xr.Dataset, out: Path | None) -> dict[str, Any]:
    """Size, time, ranges of the variables and outcomes of a map."""
    sizes = {str(name): int(size) for name, size in ds.sizes.items() if name != BALL}
    outcomes: dict[str, int] = {}
    ranges: dict[str, list[float]] = {}
    for block in blocks(ds):
        for name in block.data_vars:
            values = block[name].values
            if name == "outcome":
                codes, counts = np.unique(values, return_counts=True)
                meanings = block[name].attrs["flag_meanings"].split()
                for code, n in zip(codes, counts, strict=True):
                    outcomes[meanings[code]] = outcomes.get(meanings[code], 0) + int(n)
                continue
            for label, part in of_balls(str(name), block[name]):
                if np.isfinite(part).any():
                    low, high = ranges.get(label, [math.inf, -math.inf])
                    ranges[label] = [min(low, float(np.nanmin(part))), max(high, float(np.nanmax(part)))]
    summary: dict[str, Any] = plain(
        {
            "points": math.prod(sizes.values()),
            "sizes": sizes,
            "seconds": float(ds.attrs.get("wall_time_s", math.nan)),
            "out": out,
            **{name: ds.attrs.get(name) for name in ("column", "model", "engine")},
            "outcomes": outcomes,
            "ranges": ranges,
        }
    )
    return summary


def of_balls(name: str, variable: xr.DataArray) -> Iterator[tuple[str, Any]]:
    """Label and values of a variable, for each ball if it has one value per ball."""
    if BALL not in variable.dims:
        yield name, variable.values
        return
    for ball in variable[BALL].values:
        yield f"{name} of ball {ball}", variable.sel({BALL: ball}).values


def print_summary(ds: xr.Dataset, summary: dict[str, Any]) -> None:
    """Print the summary as a table."""
    out = console()
    sizes = " × ".join(f"{size} {name}" for name, size in summary["sizes"].items())
    seconds = summary["seconds"] or math.nan
    speed = quantity(summary["points"] / seconds, "points/s", 3)
    rows = []
    for name, (low, high) in summary["ranges"].items():
        unit = ds[name.partition(" of ball ")[0]].attrs.get("units", "1")
        rows.append([name + ("" if unit == "1" else f" [{unit}]"), digits(low), digits(high)])
    below = ", ".join(f"{count} {name}" for name, count in summary["outcomes"].items())
    title = f"{summary['model']}, {sizes}: {summary['points']} points in {seconds:.3g} s, {speed}"
    show(out, title, table(["", "smallest", "largest"], rows), f"outcomes: {below}" if below else "")
    print_files(out, [summary["out"]] if summary["out"] else [])
