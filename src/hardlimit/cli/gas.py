"""``hardlimit gas``: a box of grains as hard spheres, or under Newton's equations."""

from __future__ import annotations

import difflib
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import click
from click.shell_completion import CompletionItem

from ..boxes import files
from ..boxes.files.frame import Append
from ..boxes.hard_spheres import RULES
from ..boxes.result import ParticleResult
from ..boxes.run import Course
from ..boxes.system import BOUNDARIES, ParticleSystem
from ..support.progress import Report, bar
from .gas_compare import make_command
from .gas_contacts import engine_options, refuse_without_engine, run_contacts
from .gas_job import make_job
from .gas_report import as_mapping, print_report, save
from .options import dpi_option, law_options, options, output_option, quantity_option
from .printing import print_json
from .program import Command, no_such_command

start_options = options(
    click.option("--n", type=int, help="Number of particles.  [default: 1000]"),
    quantity_option("--packing-fraction", unit="1", help="Share of the box that they fill.  [default: 0.3]"),
    quantity_option(
        "--radius", unit="m", multiple=True, help="Radius [m]; twice: smallest and largest.  [default: 0.001]"
    ),
    quantity_option("--density", unit="kg/m3", help="Density [kg/m³].  [default: 2500]"),
    quantity_option(
        "--rms-speed", unit="m/s", help="Root mean square of the speeds at the start [m/s].  [default: 1]"
    ),
    click.option("--dimension", type=int, help="Dimension, 3 for spheres and 2 for disks.  [default: 3]"),
    click.option(
        "--seed", type=int, help="Seed of the random start; the same one gives the same start.  [default: 0]"
    ),
    click.option(
        "--boundary",
        multiple=True,
        help=f"Sides of the box: {' | '.join(BOUNDARIES)}; repeat it for each axis.  [default: periodic]",
    ),
    quantity_option(
        "--gravity",
        unit="m/s2",
        multiple=True,
        help="Gravity [m/s²], down the last axis; or repeated, one for each axis.  [default: 0]",
    ),
)
run_options = options(
    click.option(
        "--rule",
        help=f"Rule of collision: {' | '.join(sorted({r for rules in RULES.values() for r in rules}))}.",
    ),
    quantity_option("--contact-duration", unit="s", help="Contact duration of the rule tc [s]."),
    quantity_option(
        "--until", unit="s", help="End of the run [s].  [default: some 20 collisions per particle]"
    ),
    click.option("--max-collisions", type=int, help="End of the run, at this collision."),
    click.option(
        "--samples", type=int, help="Equal spacings in time of series, trajectory and film.  [default: 100]"
    ),
    output_option("--checkpoint", "File from which --resume goes on, written every minute and at Ctrl-C."),
    quantity_option(
        "--checkpoint-every", unit="s", help="Time between checkpoints, by the clock [s].  [default: 60]"
    ),
    output_option("--resume", "Checkpoint to go on from."),
)
file_options = options(
    output_option("--out", "Trajectory (xyz; gsd with the extra hardlimit[files])."),
    output_option("--save", "Series, collisions and final state as NetCDF.", "FILE.nc"),
    output_option("--plot", "Temperature, rate and pressure over time, with theory (png, pdf, …)."),
    dpi_option,
    output_option("--animate", "Film (gif; mp4 with the extra hardlimit[film]), of spheres in a slice."),
    click.option("--json", "as_json", is_flag=True, help="Print JSON."),
)


class WithCompare(Command):
    """``gas FILE`` runs, ``gas compare FILE`` is another command."""

    def make_context(
        self, info_name: str | None, args: list[str], parent: click.Context | None = None, **extra: Any
    ) -> click.Context:
        if args and args[0] == COMPARE:
            return compare.make_context(f"{info_name} {args[0]}", args[1:], parent, **extra)
        return super().make_context(info_name, args, parent, **extra)

    def invoke(self, ctx: click.Context) -> Any:
        file = ctx.params["file"]
        if file and not Path(file).suffix and difflib.get_close_matches(file, [COMPARE]):
            raise no_such_command(ctx, file, [COMPARE])
        return super().invoke(ctx)

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        super().format_options(ctx, formatter)
        with formatter.section("Commands"):
            formatter.write_dl([(COMPARE, compare.get_short_help_str(formatter.width))])


compare = make_command(start_options)
COMPARE = compare.name or ""


def completions(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """What may stand first: a file, or ``compare``."""
    files = CompletionItem(incomplete, type="file")
    return [CompletionItem(COMPARE), files] if COMPARE.startswith(incomplete) else [files]


@click.command(
    cls=WithCompare,
    epilog="\b\nExample:\n  hardlimit gas --n 2000 --packing-fraction 0.2 --restitution 0.8 --until 0.2 --plot gas.png",
)
@click.argument("file", required=False, metavar="[FILE]", shell_complete=completions)
@start_options
@law_options()
@run_options
@engine_options
@file_options
def gas(file: str | None, resume: str | None, dpi: float | None, as_json: bool, **given: Any) -> None:
    """Let grains collide in a box as hard spheres, beside theory.

    FILE is a job (.toml), or particles to start from (.xyz, .gsd, .data). Without one: 1000 spheres of radius
    1 mm and density 2500 kg/m³ in a periodic box, filled to 0.3, with restitution 0.9. A restitution alone is that
    of all collisions; with other parameters of a law it depends on pair and speed. Numbers may bear a unit.
    With --engine the contacts of that law last. Another command, hardlimit gas compare, sets the rules for hard
    spheres beside Newton's equations.
    """
    if given["engine"] is not None:
        return run_contacts(file, resume, as_json, given)
    refuse_without_engine(given)
    job = make_job(file, resume, given)
    start = job.course.current()
    result = carry_out(job.course, job.outputs)
    written = [path for path in (job.outputs["out"], job.outputs["animate"]) if path]
    if job.outputs["save"]:
        how = {"rule": result.settings.words()}
        written.append(save(result, job.outputs["save"], how, "collisions"))
    if job.outputs["plot"]:
        from .. import plots

        written.append(plots.save(plots.gas(result), job.outputs["plot"], dpi))
    if as_json:
        print_json(as_mapping(start, result, written))
    else:
        print_report(start, result, written)


def carry_out(course: Course, outputs: dict[str, Path | None]) -> ParticleResult:
    """The run, with a frame for the trajectory and the film at every sample."""
    with ExitStack() as open_files:
        report = open_files.enter_context(bar("event-driven", "collisions"))
        append = open_files.enter_context(files.appender(outputs["out"])) if outputs["out"] else None
        if append is None and not outputs["animate"]:
            return course.run(report)
        instants = frames(course, report, append)
        if outputs["animate"]:
            from ..plots.grain_film import film

            film(outputs["animate"], instants, course.target.span)
        for _ in instants:
            pass
    return course.result()


def frames(
    course: Course, report: Report, append: Append | None
) -> Iterator[tuple[float, ParticleSystem, int]]:
    """Time, state and number of collisions at every sample, each written to the trajectory."""
    for time in course.steps(report):
        system = course.current()
        if append is not None:
            append(system.as_frame(time))
        yield time, system, course.engine.n_contacts
