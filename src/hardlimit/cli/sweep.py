"""``hardlimit sweep``: maps over any parameters of a two-ball column."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from .. import validation
from ..column import files
from ..column.scenario import Column
from ..sweep import ENGINES, VARIABLES
from ..sweep import sweep as compute
from ..sweep.plan import MODELS, SWEEPABLE
from .common import (
    Command,
    all_law_parameters,
    console,
    digits,
    given_law_parameters,
    law_options,
    plain,
    print_json,
    progress,
    quantity,
    show,
    table,
    writable,
)

if TYPE_CHECKING:
    import xarray as xr

JOB_KEYS = (
    "model",
    "engine",
    "threads",
    "scheduler",
    "tolerance",
    "variables",
    "out",
    "plot",
    "difference",
    "axes",
)
MOST_POINTS = 10**9


class Axis(click.ParamType[Any]):
    """A number, a list ``0.5,0.7,0.9``, or ``start:stop:count`` with ``:log`` for equal factors."""

    name = "axis"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        try:
            return axis(param.name if param is not None and param.name else "axis", value)
        except ValueError as error:
            raise click.UsageError(str(error), ctx) from None


def axis(name: str, value: Any) -> Any:
    """A number or an array from its text, or as it stands in a TOML file.

    Raises
    ------
    ValueError
        If it is neither a number, nor a list, nor ``start:stop:count`` or ``start:stop:count:log``.
    """
    if isinstance(value, list):
        return np.array(validation.numbers(name, value, len(value)))
    if not isinstance(value, str):
        return validation.number(name, value)
    expected = "must be a number, a list a,b,… or start:stop:count[:log]"
    parts = value.split(":")
    try:
        if len(parts) == 1:
            numbers = [float(part) for part in value.split(",")]
            return numbers[0] if len(numbers) == 1 else np.array(numbers)
        start, stop, count = float(parts[0]), float(parts[1]), int(parts[2])
    except (ValueError, IndexError):
        raise ValueError(f"{name}: got {value!r}, {expected}") from None
    if len(parts) > 4 or parts[3:] not in ([], ["log"], ["lin"]):
        raise ValueError(f"{name}: got {value!r}, {expected}")
    if not 1 <= count <= MOST_POINTS:
        raise ValueError(f"{name}: got {count} points, must be in [1, 1e9]")
    if parts[3:] != ["log"]:
        return np.linspace(start, stop, count)
    if not (start > 0.0 and stop > 0.0):
        raise ValueError(f"{name}: got {value!r}, must have a start and a stop > 0 for equal factors")
    return np.geomspace(start, stop, count)


def geometry_options(function: Callable[..., None]) -> Callable[..., None]:
    """One option for each parameter of the column that can be swept."""
    for name, (_, unit, meaning, _) in reversed(SWEEPABLE.items()):
        text = f"{meaning}{'' if unit == '1' else f' [{unit}]'}"
        function = click.option(f"--{name.replace('_', '-')}", name, type=Axis(), help=text)(function)
    return function


@click.command(
    cls=Command,
    epilog="\b\nExample:\n  hardlimit sweep --restitution 0.4:1:400 --gap 1e-6:1e-2:400:log --plot map.png",
)
@click.argument("file", required=False, metavar="[JOB.toml]")
@geometry_options
@law_options(Axis())
@click.option("--model", help=f"{' | '.join(MODELS)}  [default: newton]")
@click.option("--engine", help=f"{' | '.join(ENGINES)}  [default: cpu]")
@click.option("--threads", type=int, help="[default: all processors]")
@click.option("--scheduler", help="Address of the scheduler for the engine dask.  [default: this machine]")
@click.option(
    "--tolerance", type=float, help="Of a step, viscoelastic law, 1e-13 to 1e-6.  [default: 2.3e-10]"
)
@click.option("--variable", "variables", multiple=True, help=f"To keep, repeated: {', '.join(VARIABLES)}.")
@click.option(
    "--out", metavar="FILE", help="NetCDF file (.nc) or Zarr store (.zarr, written chunk by chunk)."
)
@click.option("--resume", is_flag=True, help="Go on with the Zarr store of an interrupted sweep.")
@click.option("--plot", metavar="FILE", help="Map of the first variable, contacts by default (png, pdf, …).")
@click.option("--difference", metavar="FILE", help="Map of v'r, Newton − independent collisions.")
@click.option("--dpi", type=float, help="Resolution of the maps.  [default: 200]")
@click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON.")
def sweep(file: str | None, resume: bool, dpi: float | None, as_json: bool, **options: Any) -> None:
    """Compute a map over any parameters of two balls.

    A parameter is a number, a list 0.5,0.7,0.9, or start:stop:count, with :log for equal factors. What is not
    given is that of FILE.toml or of Fig. 2 of the paper. A job file is that of `hardlimit drop` with a table
    [sweep] (model, engine, threads, scheduler, tolerance, variables, out, plot, difference) and [sweep.axes].
    """
    base, job = read_job(file)
    given = {name: options.pop(name) for name in JOB_KEYS if name != "axes"}
    settings = {name: job.get(name) if value in (None, ()) else value for name, value in given.items()}
    column, swept = column_and_axes(base, options, job.get("axes", {}))
    if not swept:
        raise ValueError("axes: got none, must be at least one, such as --restitution 0.4:1:100")
    out = checked_output(settings["out"], resume)
    pictures = {name: writable(name, settings[name]) for name in ("plot", "difference")}
    check_drawable(pictures, swept)
    run: dict[str, Any] = {
        "model": settings["model"] or "newton",
        "engine": settings["engine"] or "cpu",
        "threads": settings["threads"],
        "scheduler": settings["scheduler"],
        "tolerance": settings["tolerance"],
        "variables": wanted_variables(settings["variables"], pictures),
    }
    import xarray  # noqa: F401  # here, so that loading it does not count as time of the sweep

    with progress("sweep", "points") as report:
        store = out if out is not None and out.suffix == ".zarr" else None
        ds = compute(column, store=store, progress=report, **run, **swept)
    if out is not None and store is None:
        save(ds, out)
    draw(ds, column, run, swept, pictures, dpi)
    summary = summarise(ds, out)
    if as_json:
        print_json(summary)
    else:
        print_summary(ds, summary)


# --- the job ------------------------------------------------------------------------------------------------


def read_job(file: str | None) -> tuple[files.Scenario, dict[str, Any]]:
    """The column and the [sweep] table of a job file; the preset and nothing without one."""
    if file is None:
        return files.of_column(Column.paper()), {}
    base, extra = files.read_with(file, "sweep")
    job = extra.get("sweep", {})
    if not isinstance(job, dict) or not isinstance(job.get("axes", {}), dict):
        raise ValueError(f"{file}: sweep: must be a [sweep] table with a table [sweep.axes]")
    for key in job:
        if key not in JOB_KEYS:
            raise ValueError(f"{file}: sweep.{key}: unknown, must be one of {', '.join(JOB_KEYS)}")
    for key in job.get("axes", {}):
        known = [*SWEEPABLE, *all_law_parameters()]
        if key not in known:
            raise ValueError(f"{file}: sweep.axes.{key}: unknown, must be one of {', '.join(known)}")
    return base, job


def column_and_axes(
    base: files.Scenario, options: dict[str, Any], axes: dict[str, Any]
) -> tuple[Column, dict[str, Any]]:
    """The column, and what of the options and the file's axes is swept, in the order of the options."""
    law = options.pop("law")
    asked = {name: value for name, value in options.items() if value is not None}
    asked = {name: axis(name, value) for name, value in axes.items() if name not in asked} | asked
    of_law = given_law_parameters({name: asked.get(name) for name in all_law_parameters()})
    if law is not None or of_law:
        first = {name: float(np.ravel(value)[0]) for name, value in of_law.items()}
        base = files.with_law(base, law, first)
    swept = {name: value for name, value in asked.items() if np.ndim(value) or name not in of_law}
    if not any(np.ndim(value) for value in swept.values()):
        swept = {}
    return base.column(), swept


def checked_output(out: str | None, resume: bool) -> Path | None:
    """Where the map goes; an existing store is only touched to resume it."""
    if out is None:
        if resume:
            raise ValueError("--resume: needs --out, must name the Zarr store to go on with")
        return None
    path = Path(out)
    if path.suffix == ".nc":
        if resume:
            raise ValueError(f"--resume: got --out {out!r}, must be a Zarr store (.zarr)")
        return writable("out", out)
    if path.suffix != ".zarr":
        raise ValueError(f"--out: got {out!r}, must end in .nc or .zarr")
    if path.exists() and not resume:
        raise ValueError(f"--out: got {out!r}, which exists: --resume goes on with it")
    if not path.parent.is_dir():
        raise ValueError(f"--out: got {out!r}, must be in an existing folder")
    return path


def wanted_variables(named: Any, pictures: dict[str, Path | None]) -> tuple[str, ...] | None:
    """The variables asked for, and those the pictures need; None for the usual ones."""
    if not named:
        return None
    wanted = (named,) if isinstance(named, str) else tuple(named)
    return (*wanted, "relative_velocity") if pictures["difference"] else wanted


def check_drawable(pictures: dict[str, Path | None], swept: dict[str, Any]) -> None:
    dimensions = sum(1 for value in swept.values() if np.ndim(value))
    if any(pictures.values()) and dimensions > 2:
        raise ValueError(f"--plot: got {dimensions} swept parameters, must be one or two to be drawn")


# --- what comes out -----------------------------------------------------------------------------------------


def save(ds: xr.Dataset, path: Path) -> None:
    """Write the map as compressed NetCDF.

    Raises
    ------
    ValueError
        If the file cannot be written.
    """
    packed = {str(name): {"zlib": True, "complevel": 1} for name in ds.data_vars}
    try:
        ds.to_netcdf(path, engine="h5netcdf", encoding=packed)
    except OSError as error:
        raise ValueError(f"--out: got {str(path)!r}, must be writable: {error}") from None


def draw(
    ds: xr.Dataset,
    column: Column,
    run: dict[str, Any],
    swept: dict[str, Any],
    pictures: dict[str, Path | None],
    dpi: float | None,
) -> None:
    """The pictures asked for; the difference needs the other model as well."""
    if not any(pictures.values()):
        return
    from ..pictures import plots

    if pictures["plot"]:
        variable = run["variables"][0] if run["variables"] else "n_contacts"
        plots.save(plots.sweep_map(ds, variable), pictures["plot"], dpi)
    if pictures["difference"]:
        # A tolerance is that of the map there is: the other model takes none.
        needed = {**run, "tolerance": None, "variables": ("relative_velocity",)}
        models = {
            model: ds if model == run["model"] else compute(column, **{**needed, "model": model}, **swept)
            for model in ("newton", "independent")
        }
        figure = plots.difference_map(models["newton"], models["independent"])
        plots.save(figure, pictures["difference"], dpi)


def blocks(ds: xr.Dataset, points: int = 2_000_000) -> Iterator[xr.Dataset]:
    """The map in parts that fit in memory: a store may be larger."""
    dim = max(ds.sizes, key=lambda name: ds.sizes[name])
    step = max(1, points * ds.sizes[dim] // math.prod(ds.sizes.values()))
    for first in range(0, ds.sizes[dim], step):
        yield ds.isel({dim: slice(first, first + step)})


def summarise(ds: xr.Dataset, out: Path | None) -> dict[str, Any]:
    """Size, time and how the points ended."""
    summary: dict[str, Any] = {
        "points": int(np.prod(list(ds.sizes.values()))),
        "sizes": {str(name): int(size) for name, size in ds.sizes.items()},
        "seconds": float(ds.attrs.get("wall_time_s", math.nan)),
        "out": None if out is None else str(out),
        "column": ds.attrs.get("column"),
        "model": ds.attrs.get("model"),
        "engine": ds.attrs.get("engine"),
    }
    outcomes: dict[str, int] = {}
    ranges: dict[str, list[float]] = {}
    for block in blocks(ds):
        for name in block.data_vars:
            values = block[name].values
            if name == "outcome":
                codes, counts = np.unique(values, return_counts=True)
                words = block[name].attrs["flag_meanings"].split()
                for code, n in zip(codes, counts, strict=True):
                    outcomes[words[code]] = outcomes.get(words[code], 0) + int(n)
            elif np.isfinite(values).any():
                low, high = ranges.get(str(name), [math.inf, -math.inf])
                ranges[str(name)] = [min(low, float(np.nanmin(values))), max(high, float(np.nanmax(values)))]
    summary |= {"outcomes": outcomes, "ranges": ranges}
    result: dict[str, Any] = plain(summary)
    return result


def print_summary(ds: xr.Dataset, summary: dict[str, Any]) -> None:
    out = console()
    sizes = " × ".join(f"{size} {name}" for name, size in summary["sizes"].items())
    seconds = summary["seconds"] or math.nan
    rate = quantity(summary["points"] / seconds, "points/s", 3)
    rows = []
    for name, (low, high) in summary["ranges"].items():
        unit = ds[name].attrs.get("units", "1")
        label = name + ("" if unit == "1" else f" [{unit}]")
        rows.append([label, digits(low), digits(high)])
    below = ", ".join(f"{name} {count}" for name, count in summary.get("outcomes", {}).items())
    title = f"{summary['model']}, {sizes}: {summary['points']} points in {seconds:.3g} s, {rate}"
    show(out, title, table(["", "smallest", "largest"], rows), f"outcomes: {below}" if below else "")
    if summary["out"]:
        out.print(f"written to {summary['out']}", markup=False)
