"""``hardlimit sweep``: maps over any parameters of a column of balls."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any

import click

from ..column.models import MODELS
from ..support.progress import bar
from ..sweep import ENGINES, VARIABLES
from ..sweep import sweep as compute
from .axes import Axis, geometry_options
from .job import Job, make_job
from .options import dpi_option, law_options, options, output_option
from .printing import console, print_json
from .program import Command
from .sweep_report import print_summary, save, summarise

if TYPE_CHECKING:
    import xarray as xr

settings_options = options(
    click.option("--model", help=f"Model: {' | '.join(MODELS)}.  [default: newton]"),
    click.option("--engine", help=f"Where it is computed: {' | '.join(ENGINES)}.  [default: cpu]"),
    click.option("--threads", type=int, help="Threads.  [default: all processors; 1 with the engine dask]"),
    click.option(
        "--scheduler", help="Address of the scheduler for the engine dask.  [default: this machine]"
    ),
    click.option(
        "--tolerance",
        type=float,
        help="Local error of a step in units of the impact, where points are integrated.  "
        "[default: 2.3e-10 or 1e-14]",
    ),
    click.option(
        "--variable",
        "variables",
        multiple=True,
        help=f"Variable to keep; repeat for more: {', '.join(VARIABLES)}.",
    ),
    output_option("--out", "NetCDF file (.nc) or Zarr store (.zarr, written chunk by chunk)."),
    click.option("--resume", is_flag=True, help="Go on with the Zarr store of an interrupted sweep."),
    output_option("--plot", "Map of the first variable, contacts by default (png, pdf, …)."),
    output_option(
        "--difference", "Map of the difference in v'r, Newton − independent collisions (png, pdf, …)."
    ),
    dpi_option,
    click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON."),
)


@click.command(
    cls=Command,
    epilog="\b\nExample:\n  hardlimit sweep --restitution 0.4:1:400 --gap 1um:1cm:400:log --plot map.png",
)
@click.argument("file", required=False, metavar="[JOB.toml]")
@geometry_options
@law_options(Axis)
@settings_options
def sweep(file: str | None, resume: bool, dpi: float | None, as_json: bool, **given: Any) -> None:
    """Compute a map over any parameters of a column of balls.

    The column is that of JOB.toml, or two balls. A parameter is a number, a list 0.5,0.7,0.9, or start:stop:count,
    with :log for equal factors; numbers may bear a unit, such as 1um. What is not given is that of JOB.toml or of
    Fig. 2 of the paper. A job file is that of `hardlimit drop` with a table [sweep] (model, engine, threads,
    scheduler, tolerance, variables, out, plot, difference) and [sweep.axes].
    """
    job = make_job(file, resume, given)
    import xarray  # noqa: F401  # here, so that loading it does not count as time of the sweep

    store = job.out if job.out is not None and job.out.suffix == ".zarr" else None
    with bar("sweep", "points") as report, warnings.catch_warnings(record=True) as mended:
        warnings.simplefilter("always", UserWarning)
        ds = compute(job.column, store=store, progress=report, **job.run, **job.axes)
    for warning in mended:
        console(stderr=True).print(f"hardlimit sweep: {warning.message}", markup=False, soft_wrap=True)
    if job.out is not None and store is None:
        save(ds, job.out)
    draw(ds, job, dpi)
    summary = summarise(ds, job.out)
    if as_json:
        print_json(summary)
    else:
        print_summary(ds, summary)


def draw(ds: xr.Dataset, job: Job, dpi: float | None) -> None:
    """The pictures asked for; the difference needs the other model as well."""
    if not any(job.pictures.values()):
        return
    from .. import plots

    if job.pictures["plot"]:
        variable = job.run["variables"][0] if job.run["variables"] else "n_contacts"
        plots.save(plots.sweep_map(ds, variable), job.pictures["plot"], dpi)
    if job.pictures["difference"]:
        # A tolerance is that of the map there is: the other model takes none.
        needed = {**job.run, "tolerance": None, "variables": ("relative_velocity",)}
        newton, independent = (
            ds if model == job.run["model"] else compute(job.column, **{**needed, "model": model}, **job.axes)
            for model in ("newton", "independent")
        )
        plots.save(plots.difference_map(newton, independent), job.pictures["difference"], dpi)
