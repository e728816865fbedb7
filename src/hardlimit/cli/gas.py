"""``hardlimit gas``: simulate a box of grains as hard spheres or under Newton's equations."""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import click
import numpy as np
from click.shell_completion import CompletionItem

import hardlimit as hl

from ..boxes import files as box_files
from ..boxes import theory
from ..boxes.hard_spheres import NAME as HARD_SPHERES
from ..boxes.hard_spheres import checked_end
from ..boxes.newton import NAMES as ENGINES
from ..boxes.rules import checked_settings
from ..boxes.run import load
from ..boxes.system import described
from ..boxes.thermostats import as_entry
from ..support import validation
from ..support.formatting import digits, listed
from ..verdict.error_law import softness
from .compare import compare
from .gas_job import ALIASES, OUTPUT, RUN, START, GasJob, checked_outputs, default_end, make_job
from .job import Entry, entry_options
from .options import dpi_option, json_option, law_options, law_text, options, output_option, spelled
from .printing import console, plain, print_json, print_outcome, sentence, show, table
from .program import Command, in_options, no_such_command

#: Options of Newton's equations that are arguments of ``hl.molecular_dynamics``.
SOLVER = (
    Entry(
        "restitution_error",
        "Error of ε that the time step may cause (steps, lammps); with steps also that of energies and positions.  "
        "[default: 0.001]",
        unit="1",
    ),
    Entry("time_step", "Longest time step [s] (steps, lammps), instead of --restitution-error.", unit="s"),
    Entry(
        "threads",
        "Number of threads (steps).  [default: one for each 1000 particles, at most all processors]",
        kind=int,
    ),
    Entry("ranks", "Number of MPI processes (lammps).  [default: 1]", kind=int),
)
newton_options = options(
    click.option(
        "--engine",
        type=click.Choice(ENGINES),
        help="Solve Newton's equations, with a --law; auto: events or steps, whichever is estimated to be faster.",
    ),
    entry_options(SOLVER),
    output_option(
        "--write-input", "Write the input of LAMMPS to a folder and run nothing (lammps).", "FOLDER"
    ),
)
#: Options that have no meaning for Newton's equations.
HARD_SPHERES_ONLY = ("rule", "contact_duration", "max_collisions")
FRAMES = ("out", "animate")
PICTURES = ("plot", *FRAMES)
#: Numbers in the JSON output, with the attributes of the result.
_NAMES = ("n_collisions", "n_elastic_by_tc", "n_soft", "n_soft_third_body")
HARD_SPHERES_NUMBERS = {name: name for name in _NAMES}
HARD_SPHERES_NUMBERS |= {"n_pair_collisions": "n_pairs", "n_wall_collisions": "n_walls"}
_CONTACTS = ("n_contacts", "n_pairs", "n_ended", "n_overlapped", "overlapped_share", "energy_error")
_ENGINE = ("engine", "engine_reason", "time_step", "n_steps", "largest_cluster", "cluster_share")
NEWTON_NUMBERS = {name: name for name in (*_ENGINE, *_CONTACTS)}


class WithCompare(Command):
    """The command ``gas FILE``, with ``gas compare FILE`` as a command of its own."""

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


COMPARE = compare.name or ""


def completions(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Completions of the first argument: a file or ``compare``."""
    files = CompletionItem(incomplete, type="file")
    return [CompletionItem(COMPARE), files] if COMPARE.startswith(incomplete) else [files]


@click.command(
    cls=WithCompare,
    aliases=ALIASES,
    epilog="\b\nExample:\n  hardlimit gas --n 2000 --packing-fraction 0.2 --restitution 0.8 --until 0.2 --plot gas.png",
)
@click.argument("file", required=False, metavar="[FILE]", shell_complete=completions)
@entry_options(START)
@law_options()
@entry_options(RUN)
@output_option("--resume", "Checkpoint of a run to continue.")
@newton_options
@entry_options(OUTPUT)
@dpi_option
@json_option()
def gas(file: str | None, resume: str | None, dpi: float | None, as_json: bool, **given: Any) -> None:
    """Simulate a box of grains as hard spheres.

    FILE is a job (.toml) or a state to start from (.xyz, .gsd, .data). Without a file, 1000 spheres of radius 1 mm and
    density 2500 kg/m³ start at random in a periodic box with a packing fraction of 0.3 and a restitution of 0.9. With
    --restitution alone, all collisions have this ε; with the parameters of a contact law, ε depends on the pair and
    the impact speed. With --engine, Newton's equations are solved for this law instead. Results of equal spheres come
    with the predictions of kinetic theory. Numbers may have a unit, such as 1mm.

    hardlimit gas compare solves one start under Newton's equations and each collision rule.
    """
    if resume is not None:
        start, (result, outputs) = None, resumed(file, resume, given)
    else:
        newton = {name: given.pop(name) for name in ("engine", "write_input", *(e.name for e in SOLVER))}
        job = make_job(file, given)
        outputs = job.outputs
        if newton["write_input"] is not None and newton["engine"] is not None:
            click.echo(f"written to {write_lammps_input(job, newton)}")
            return
        if newton["engine"] is None:
            refuse(newton, "without --engine")
        start, result = run_hard_spheres(job) if newton["engine"] is None else run_newton(job, newton)
    written = [path for path in (outputs["out"], outputs["animate"]) if path]
    if outputs["save"]:
        written.append(save(result, outputs["save"]))
    if outputs["plot"]:
        from .. import plots

        written.append(plots.save(plots.gas(result), outputs["plot"], dpi))
    if as_json:
        print_json(as_mapping(result, written))
    else:
        print_report(start, result, written)


# --- runs ---------------------------------------------------------------------------------------------------


def run_hard_spheres(job: GasJob) -> tuple[hl.ParticleSystem, Any]:
    """Start and result of :func:`hardlimit.event_driven`."""
    rule = job.rule()
    if "max_collisions" in job.run:
        refuse_frames_without_end(job.outputs, job.run.get("until"))
    # Arguments are checked before the start is made, which takes minutes for a million particles.
    given = rule | job.run
    checked_settings(*(given.get(name) for name in ("law", "restitution", "rule", "contact_duration")))
    checked_end(given.get("until"), given.get("max_collisions"))
    start = job.start()
    if "max_collisions" not in job.run:
        job.run.setdefault("until", default_end(start))
    arguments = {**rule, **job.run, "log": job.outputs["save"] is not None, "progress": True}
    return start, with_frames(lambda **observe: hl.event_driven(start, **arguments, **observe), job.outputs)


def resumed(file: str | None, checkpoint: str, given: dict[str, Any]) -> tuple[Any, dict[str, Path | None]]:
    """Continue a run from its checkpoint, to a new end if one is given; returns the result and the files to write."""
    outputs = checked_outputs({entry.name: given.pop(entry.name) for entry in OUTPUT})
    end = {name: given.pop(name) for name in ("until", "max_collisions")}
    refuse({"FILE": file, **given}, "with --resume: the checkpoint holds it")
    check_resumed(checkpoint, end, outputs)
    return with_frames(lambda **more: hl.resume(checkpoint, **end, **more, progress=True), outputs), outputs


def check_resumed(checkpoint: str, end: dict[str, Any], outputs: dict[str, Path | None]) -> None:
    """Refuse outputs that the rest of a run cannot give, before it goes on."""
    run = load(validation.path("resume", checkpoint))
    if outputs["plot"] is not None and run.engine.record.name != HARD_SPHERES:
        raise ValueError("--plot: must be left out for a run under Newton's equations")
    until = end["until"] if any(value is not None for value in end.values()) else run.schedule.until
    refuse_frames_without_end(outputs, until)
    for name in FRAMES:
        if outputs[name] is not None and until is not None and not run.takes_samples(until):
            raise ValueError(
                f"--{name}: must be left out: {checkpoint} is at the end of its run, no frame follows"
            )


def refuse_frames_without_end(outputs: dict[str, Path | None], until: float | None) -> None:
    for name in FRAMES:
        if outputs[name] is not None and until is None:
            raise ValueError(f"--{name}: requires --until, because frames are at equal times")


def with_frames(solve: Callable[..., Any], outputs: dict[str, Path | None]) -> Any:
    """The result of ``solve``, with a frame of the trajectory and of the film at each sample.

    Ctrl-C keeps the trajectory so far.
    """
    snapshots: list[Any] = []  # of the film, which is written at the end
    if outputs["animate"] is not None:
        from ..plots import grain_film
    with ExitStack() as open_files:
        path = outputs["out"]
        append = None if path is None else open_files.enter_context(box_files.appender(path))

        def observe(time: float, system: hl.ParticleSystem) -> dict[str, float]:
            if append is not None:
                append(system.as_frame(time))
            if outputs["animate"] is not None:
                snapshots.append(grain_film.Snapshot.of(time, system))
            return {}

        wanted = append is not None or outputs["animate"] is not None
        try:
            result = solve(**({"observe": observe} if wanted else {}))
        except KeyboardInterrupt:
            open_files.close()
            raise
    if outputs["animate"] is not None:
        series = result.series
        at = np.searchsorted(series["time"].values, [one.time for one in snapshots])
        counts = series["n_contacts" if isinstance(result, hl.ContactResult) else "n_collisions"].values[at]
        frames = zip(snapshots, counts.tolist(), strict=True)
        grain_film.film(outputs["animate"], result.system, frames, result.time)
    return result


def run_newton(job: GasJob, newton: dict[str, Any]) -> tuple[hl.ParticleSystem, Any]:
    """Start and result of :func:`hardlimit.molecular_dynamics`."""
    refuse({name: job.run.get(name) for name in HARD_SPHERES_ONLY}, "with --engine")
    refuse({name: job.outputs[name] for name in PICTURES}, "with --engine")
    start, arguments = newton_arguments(job, newton, ("engine", *(e.name for e in SOLVER)))
    return start, hl.molecular_dynamics(
        start, **arguments, log=job.outputs["save"] is not None, progress=True
    )


def newton_arguments(
    job: GasJob, newton: dict[str, Any], names: Iterable[str]
) -> tuple[hl.ParticleSystem, dict[str, Any]]:
    """Start and arguments of a run under Newton's equations; those with these names are from the options."""
    law = job.contact_law()
    if law is None:
        raise ValueError("--law: missing, must be given with its parameters for --engine")
    start = job.start()
    job.run.setdefault("until", default_end(start))
    return start, {
        "law": law,
        **job.run,
        **{name: newton[name] for name in names if newton[name] is not None},
    }


def write_lammps_input(job: GasJob, newton: dict[str, Any]) -> Path:
    if newton["engine"] != "lammps":
        raise ValueError(f"--write-input: must be left out with --engine {newton['engine']}")
    run_only = {"save": job.outputs["save"], **{name: newton[name] for name in ("threads", "ranks")}}
    run_only |= {name: job.run.get(name) for name in ("checkpoint", "checkpoint_every")}
    refuse(run_only, "with --write-input")
    start, arguments = newton_arguments(job, newton, ("restitution_error", "time_step"))
    folder: Path = hl.lammps_input(start, newton["write_input"], **arguments)
    return folder


def refuse(given: dict[str, Any], why: str) -> None:
    """Refuse options that are given."""
    for name, value in given.items():
        if value not in (None, ()):
            raise ValueError(f"{name if name == 'FILE' else spelled(name)}: must be left out {why}")


# --- output -------------------------------------------------------------------------------------------------


def print_report(start: hl.ParticleSystem | None, result: Any, files: list[Path]) -> None:
    """Print the system at the start (for a resumed run, at the end), the results with theory, and the outcome."""
    out = console()
    shown = result.system if start is None else start
    title = shown.count()
    show(out, title if start else f"{title}, final state", table(["", ""], described(shown)))
    if isinstance(result, hl.ContactResult):
        print_newton(out, result)
    else:
        print_hard_spheres(out, result)
    print_outcome(out, result.outcome, files)


def print_newton(out: Any, result: hl.ContactResult) -> None:
    """The numbers of a run under Newton's equations."""
    rows = [[label, digits(value)] for label, value in (*result.quantities(), *softness_rows(result))]
    title = f"Newton's equations, {law_text(result.law)}"
    reason = sentence(result.choice()) if result.engine_reason else ""
    show(out, title, table(["", result.engine], rows), reason)


def print_hard_spheres(out: Any, result: hl.ParticleResult) -> None:
    """The numbers of a run of hard spheres with those of theory."""
    rows = [[label, digits(value)] for label, value in (*result.quantities(), *softness_rows(result))]
    names = ["", "event-driven"]
    if theories := predictions(result):
        names.append("theory")
        rows = [[*row, digits(theories.get(row[0], math.nan))] for row in rows]
    show(out, f"Hard spheres, rule {result.settings.report()}", table(names, rows), note(result))


def softness_numbers(result: Any) -> dict[str, float]:
    """t_c ν and δ/d of a run with a contact law, means of the run; none without."""
    series = result.series
    law = result.law if isinstance(result, hl.ContactResult) else result.settings.law
    if law is None or not result.time > 0.0:
        return {}
    found = softness(law, result.system, series["granular_temperature"].values)
    rate = series["collision_rate"].values[1:]
    mean = float(np.average(rate, weights=np.diff(series["time"].values)))
    return {"tc_nu": found.duration * mean, "delta_over_d": found.delta_over_d}


def softness_rows(result: Any) -> list[tuple[str, float]]:
    """Rows of t_c ν and δ/d."""
    numbers = softness_numbers(result)
    labels = {
        "tc_nu": "t_c ν, mean of the run",
        "delta_over_d": "δ/d, mean greatest compression",
    }
    return [(labels[name], value) for name, value in numbers.items()]


def predictions(result: hl.ParticleResult) -> dict[str, float]:
    """The predictions of theory for quantities of a result, by label; none if theory does not apply."""
    series, system = result.series, result.system
    time, temperature = series["time"].values, series["granular_temperature"].values
    if theory.why_not(system) is not None or not time[-1] > time[0]:
        return {}
    gas = theory.gas(system)
    found = {"mean collision rate [1/s]": _mean(gas.collision_rate(temperature), time)}
    e = result.settings.restitution
    if e is not None:
        unit = "N/m" if system.dimension == 2 else "Pa"
        found[f"mean pressure [{unit}]"] = _mean(gas.pressure(temperature, e), time)
        cooled = float(gas.cooling(np.array(result.time), float(temperature[0]), e))
        found["granular temperature at the end [m²/s²]"] = cooled
    return found


def _mean(values: Any, time: Any) -> float:
    """Mean over time by the trapezoidal rule."""
    return float(np.average(0.5 * (values[1:] + values[:-1]), weights=np.diff(time)))


def note(result: hl.ParticleResult) -> str:
    """The sources of the theory in the table, or the reason why there is none."""
    reason = theory.why_not(result.system)
    if reason is not None:
        return f"No theory: {reason}."
    e = result.settings.restitution
    names = ["Enskog’s rate"]
    if e is not None:
        authors = "Carnahan and Starling" if result.system.dimension == 3 else "Henderson"
        names += [f"{authors}’s pressure", *(["Haff’s law"] if e < 1.0 else [])]
    return (
        f"Theory: {listed(names)}, with the measured temperatures in rate and pressure. A random start is not in "
        f"equilibrium: expect differences during the first {theory.RELAXED} collisions per particle."
    )


def as_mapping(result: Any, files: list[Path]) -> dict[str, Any]:
    """The numbers of the tables and the series, in SI units."""
    system, series = result.system, result.series
    facts = ("n", "dimension", "box", "boundary", "gravity", "packing_fraction")
    found: dict[str, Any] = {"system": {name: getattr(system, name) for name in facts}}
    if system.walls:
        found["system"]["walls"] = {name: vars(wall) for name, wall in system.walls.items()}
    if system.domain.gradient is not None:
        found["system"] |= {name: getattr(system, name) for name in ("shear_rate", "shear_displacement")}
    if system.thermostat is not None:
        found["system"]["thermostat"] = as_entry(system.thermostat)
    if isinstance(result, hl.ContactResult):
        law, names = result.law, NEWTON_NUMBERS
    else:
        settings, law, names = result.settings, result.settings.law, HARD_SPHERES_NUMBERS
        found |= {name: getattr(settings, name) for name in ("rule", "restitution", "contact_duration")}
    found |= {"law": None if law is None else {"name": law.record["name"], **law.parameters}}
    found |= {key: getattr(result, name) for key, name in names.items()} | softness_numbers(result)
    if not isinstance(result, hl.ContactResult):
        found["theory"] = predictions(result)
    found |= {
        "outcome": {"name": result.outcome_name, "message": in_options(result.outcome)},
        "early_end": None if result.early_end is None else result.early_end._asdict(),
        "time": result.time,
        "series": {"time": series["time"].values, **{k: v.values for k, v in series.data_vars.items()}},
        "files": files,
    }
    mapping: dict[str, Any] = plain(found)
    return mapping


def save(result: Any, path: Path) -> Path:
    """Save the series, the log if there is one, and the final state as NetCDF."""
    saved: Path = result.save(path)
    return saved
