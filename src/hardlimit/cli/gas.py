"""``hardlimit gas``: simulate a box of grains as hard spheres or under Newton's equations."""

from __future__ import annotations

import difflib
import math
import shlex
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

import click
import numpy as np
from click.shell_completion import CompletionItem

import hardlimit as hl

from ..boxes import files as box_files
from ..boxes import theory
from ..boxes.error_law import softness
from ..boxes.hard_spheres import NAME as HARD_SPHERES
from ..boxes.hard_spheres import checked_end
from ..boxes.newton import NAMES as ENGINES
from ..boxes.result import at_the_end
from ..boxes.rules import PARAMETERS, checked_settings
from ..boxes.run import load
from ..boxes.system import described
from ..boxes.thermostats import as_entry
from ..support import saving, validation
from ..support.formatting import digits, listed
from .compare import compare
from .gas_job import ALIASES, OUTPUT, RUN, START, GasJob, checked_outputs, default_end, make_job
from .job import Entry, entry_options
from .options import (
    dpi_option,
    friction_options,
    json_option,
    law_mapping,
    law_options,
    law_text,
    options,
    output_option,
    spelled,
)
from .printing import console, plain, print_json, print_outcome, sentence, show, table
from .program import Command, in_options, no_such_command, notes, raise_all, write_files

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
HARD_SPHERES_ONLY = ("rule", *PARAMETERS, "tangential_restitution", "max_collisions")
#: Arguments that make a rule.
RULE_ARGUMENTS = ("law", "restitution", "rule", *PARAMETERS, "friction", "tangential_restitution")
FRAMES = ("out", "animate")
ENDS = ("until", "max_collisions")
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
@friction_options()
@entry_options(RUN)
@output_option("--resume", "Checkpoint of a run to continue.")
@newton_options
@entry_options(OUTPUT)
@dpi_option
@json_option()
def gas(file: str | None, resume: str | None, dpi: float | None, as_json: bool, **params: Any) -> None:
    """Simulate a box of grains as hard spheres.

    FILE is a job (.toml) or a state to start from (.xyz, .gsd, .data, or a text dump of LAMMPS or LIGGGHTS); --density
    and --radius fill what it lacks, and --boundary puts walls around it. Without a file, 1000 spheres of radius 1 mm
    and density 2500 kg/m³ start at random in a periodic box with a packing fraction of 0.3 and a restitution of 0.9.
    With --restitution alone, all collisions have this ε; with the parameters of a contact law, ε depends on the pair
    and the impact speed. With --engine, Newton's equations are solved for this law instead. With --friction, grains rub
    and spin: collisions that do not slide have the --tangential-restitution, or what the contact law gives. Results of
    equal spheres come with the predictions of kinetic theory. Numbers may have a unit, such as 1mm or 2/7.

    hardlimit gas compare solves each start under Newton's equations and each collision rule.
    """
    run = new_run(file, params) if resume is None else resumed(file, resume, params)
    if run is None:
        return
    outputs, frames = run.outputs, Frames(run)
    with what_is_kept(run, frames, {"dpi": dpi, "json": as_json}):
        result = frames.of(run.solve)
    with what_is_kept_at_the_end(run, frames):
        written, failures = write_files(
            (outputs["out"], frames.check),
            (outputs["animate"], partial(frames.film, result)),
            (outputs["save"], partial(save, result)),
            (outputs["plot"], partial(draw, result, dpi)),
        )
        if as_json:
            print_json(as_mapping(result, written))
        else:
            print_report(run.start, result, written)
    raise_all(failures)


# --- runs ---------------------------------------------------------------------------------------------------

#: Call of a solver, whose keyword is ``observe``.
Solve = Callable[..., Any]


class GasRun(NamedTuple):
    """A run that is ready to begin or to go on."""

    start: hl.ParticleSystem | None  #: None if it goes on
    solve: Solve
    outputs: dict[str, Path | None]
    checkpoint: Any
    end: Mapping[str, Any] = {}  #: new end of a run that goes on
    before: Sequence[float] = ()  #: times of its samples so far [s]


def new_run(file: str | None, params: dict[str, Any]) -> GasRun | None:
    """The run of a job file and options; None if only the input of LAMMPS is written."""
    newton = {name: params.pop(name) for name in ("engine", "write_input", *(e.name for e in SOLVER))}
    job = make_job(file, params)
    if newton["write_input"] is not None and newton["engine"] is not None:
        click.echo(f"written to {write_lammps_input(job, newton)}")
        return None
    if newton["engine"] is None:
        refuse(newton, "without --engine")
    start, solve = run_hard_spheres(job) if newton["engine"] is None else run_newton(job, newton)
    return GasRun(start, solve, job.outputs, job.run.get("checkpoint"))


def run_hard_spheres(job: GasJob) -> tuple[hl.ParticleSystem, Solve]:
    """Start and call of :func:`hardlimit.event_driven`."""
    rule = job.rule()
    if "max_collisions" in job.run:
        refuse_frames_without_end(job.outputs, job.run.get("until"))
    # Arguments are checked before the start is made, which takes minutes for a million particles.
    settings = rule | job.run
    checked_settings(**{name: settings.get(name) for name in RULE_ARGUMENTS})
    checked_end(settings.get("until"), settings.get("max_collisions"))
    start = job.start()
    if "max_collisions" not in job.run:
        job.run.setdefault("until", default_end(start))
    arguments = {**rule, **job.run, "log": job.outputs["save"] is not None, "progress": True}
    return start, partial(hl.event_driven, start, **arguments)


def resumed(file: str | None, checkpoint: str, params: dict[str, Any]) -> GasRun:
    """The rest of a run from its checkpoint, to a new end if one is given."""
    outputs = checked_outputs({entry.name: params[entry.name] for entry in OUTPUT})
    end = {name: params[name] for name in ENDS}
    rest = {name: value for name, value in params.items() if name not in (*outputs, *end)}
    refuse({"FILE": file, **rest}, "with --resume: the checkpoint holds it")
    before = check_resumed(checkpoint, end, outputs)
    return GasRun(
        None, partial(hl.resume, checkpoint, **end, progress=True), outputs, checkpoint, end, before
    )


def check_resumed(checkpoint: str, end: dict[str, Any], outputs: dict[str, Path | None]) -> list[float]:
    """Refuse outputs that the rest of a run cannot give, before it goes on. Returns the times of its samples."""
    run = load(validation.path("resume", checkpoint))
    if outputs["plot"] is not None and run.engine.record.name != HARD_SPHERES:
        raise ValueError("--plot: must be left out for a run under Newton's equations")
    until = end["until"] if any(value is not None for value in end.values()) else run.schedule.until
    refuse_frames_without_end(outputs, until)
    for name in FRAMES:
        if outputs[name] is not None and until is not None and not run.takes_samples(until):
            raise ValueError(
                f"--{name}: must be left out: {checkpoint} is at the end of its run, no frame follows; "
                "--until gives it another end"
            )
    return run.sampled_times


def refuse_frames_without_end(outputs: dict[str, Path | None], until: float | None) -> None:
    for name in FRAMES:
        if outputs[name] is not None and until is None:
            raise ValueError(f"--{name}: requires --until, because frames are at equal times")


class Frames:
    """The frames of a run, one at each sample: those of the trajectory, which are in its file at once, and those of the
    film, which is written at the end."""

    def __init__(self, run: GasRun) -> None:
        self._path, self._film = run.outputs["out"], run.outputs["animate"]
        self._goes_on, self._before = run.checkpoint is not None, run.before
        self._append: Callable[[Any], None] | None = None
        self._snapshots: list[Any] = []
        self._directions: Any = None  # of the marks in the film
        self._open = ExitStack()
        self.begun = bool(run.before)  #: whether the trajectory has frames
        self.failure: OSError | None = None  #: why the trajectory ends early

    def of(self, solve: Solve) -> Any:
        """The result of ``solve``, whose samples become frames."""
        if self._path is None and self._film is None:
            return solve()
        with self._open:
            if self._path is not None and self._before:
                self._append = self._open.enter_context(box_files.trajectory(self._path, self._before))
            return solve(observe=self._observe)

    def _observe(self, time: float, system: hl.ParticleSystem) -> dict[str, float]:
        if self._path is not None and self.failure is None:
            try:
                with saving.naming(self._path):
                    if self._append is None:  # the former file stays until there is a frame
                        self._append = self._open.enter_context(box_files.trajectory(self._path))
                    self._append(system.as_frame(time))
                self.begun = True
            except OSError as error:
                if self._goes_on:  # from the checkpoint, with this frame
                    raise
                self.failure = error
        if self._film is not None:
            from ..plots import grain_film

            self._directions = self._directions or grain_film.Directions()
            directions = self._directions.at(time, system)
            self._snapshots.append(grain_film.Snapshot.of(time, system, directions))
        return {}

    def check(self, _: Path) -> None:
        """Raise the error that ended the trajectory early."""
        if self.failure is not None:
            raise self.failure

    def film(self, result: Any, path: Path) -> None:
        from ..plots import grain_film

        series = result.series
        at = np.searchsorted(series["time"].values, [snapshot.time for snapshot in self._snapshots])
        counts = series["n_contacts" if isinstance(result, hl.ContactResult) else "n_collisions"].values[at]
        frames = zip(self._snapshots, counts.tolist(), strict=True)
        grain_film.film(path, result.system, frames, result.time)


@contextmanager
def what_is_kept(run: GasRun, frames: Frames, more: dict[str, Any]) -> Iterator[None]:
    """An error or Ctrl-C during a run says what is kept and which command goes on, with the options ``more``."""
    outputs = {name: path for name, path in run.outputs.items() if name != "animate"}
    try:
        yield
    except (KeyboardInterrupt, OSError, RuntimeError, MemoryError) as error:
        if frames.begun and outputs["out"]:
            error.add_note(f"kept {outputs['out']}")
        if run.checkpoint is not None and any("; kept " in note for note in notes(error)):
            values = {"resume": run.checkpoint, **run.end, **outputs, **more}
            typed = [(name, value) for name, value in values.items() if value]
            words = chain(
                *((spelled(name), *([] if value is True else [str(value)])) for name, value in typed)
            )
            error.add_note(f"go on with: {shlex.join(['hardlimit', 'gas', *words])}")
        elif run.checkpoint is None and notes(error):
            error.add_note("a run goes on only from a --checkpoint")
        raise


@contextmanager
def what_is_kept_at_the_end(run: GasRun, frames: Frames) -> Iterator[None]:
    """Ctrl-C while the results of a run that is over are written says what is kept."""
    try:
        yield
    except KeyboardInterrupt as error:
        error.add_note("after the end of the run")
        if run.checkpoint is not None:
            summary = shlex.join(["hardlimit", "gas", "--resume", str(run.checkpoint)])
            error.add_note(f"kept {run.checkpoint}, whose summary is printed by: {summary}")
        if frames.begun and run.outputs["out"]:
            error.add_note(f"kept {run.outputs['out']}")
        raise


def run_newton(job: GasJob, newton: dict[str, Any]) -> tuple[hl.ParticleSystem, Solve]:
    """Start and call of :func:`hardlimit.molecular_dynamics`."""
    refuse({name: job.run.get(name) for name in HARD_SPHERES_ONLY}, "with --engine")
    refuse({name: job.outputs[name] for name in PICTURES}, "with --engine")
    start, arguments = newton_arguments(job, newton, ("engine", *(e.name for e in SOLVER)))
    arguments |= {"log": job.outputs["save"] is not None, "progress": True}
    return start, partial(hl.molecular_dynamics, start, **arguments)


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


def refuse(values: dict[str, Any], why: str) -> None:
    """Refuse options that are given."""
    for name, value in values.items():
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
    show(out, f"Hard spheres, rule {result.settings.report(law_text)}", table(names, rows), note(result))


def softness_numbers(result: Any) -> dict[str, float]:
    """t_c ν and δ/d of a run with a contact law, means of the run; none without."""
    series = result.series
    law = result.law if isinstance(result, hl.ContactResult) else result.settings.law
    if law is None or not result.time > 0.0:
        return {}
    softness_of_run = softness(law, result.system, series["granular_temperature"].values)
    rate = series["collision_rate"].values[1:]
    mean = float(np.average(rate, weights=np.diff(series["time"].values)))
    return {"tc_nu": softness_of_run.duration * mean, "delta_over_d": softness_of_run.delta_over_d}


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
    values = {"mean collision rate [1/s]": _mean(gas.collision_rate(temperature), time)}
    e = result.settings.restitution
    if e is not None:
        unit = "N/m" if system.dimension == 2 else "Pa"
        values[f"mean pressure [{unit}]"] = _mean(gas.pressure(temperature, e), time)
        cooling = result.cooling_of_theory()
        values |= {at_the_end(name): float(expected[-1]) for name, expected in cooling.items()}
    return values


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
        names.append(f"{authors}’s pressure")
        if result.settings.has_friction:
            names.append("the cooling of grains that rub (Herbst, Huthmann & Zippelius 2000)")
        elif e < 1.0:
            names.append("Haff’s law")
    return (
        f"Theory: {listed(names)}, with the measured temperatures in rate and pressure. A random start is not in "
        f"equilibrium: expect differences during the first {theory.RELAXED} collisions per particle."
    )


def as_mapping(result: Any, files: list[Path]) -> dict[str, Any]:
    """The numbers of the tables and the series, in SI units."""
    system, series = result.system, result.series
    facts = ("n", "dimension", "box", "boundary", "gravity", "packing_fraction")
    content: dict[str, Any] = {"system": {name: getattr(system, name) for name in facts}}
    if system.walls:
        content["system"]["walls"] = {name: vars(wall) for name, wall in system.walls.items()}
    if system.domain.gradient is not None:
        content["system"] |= {name: getattr(system, name) for name in ("shear_rate", "shear_displacement")}
    if system.thermostat is not None:
        content["system"]["thermostat"] = as_entry(system.thermostat)
    if isinstance(result, hl.ContactResult):
        law, names = result.law, NEWTON_NUMBERS
    else:
        settings, law, names = result.settings, result.settings.law, HARD_SPHERES_NUMBERS
        rule = settings.entry()
        content |= {name: rule[name] for name in RULE_ARGUMENTS[1:]}
    content |= {"law": None if law is None else law_mapping(law)}
    content |= {key: getattr(result, name) for key, name in names.items()} | softness_numbers(result)
    if not isinstance(result, hl.ContactResult):
        content["theory"] = predictions(result)
    content |= {
        "outcome": {"name": result.outcome_name, "message": in_options(result.outcome)},
        "early_end": None if result.early_end is None else result.early_end._asdict(),
        "time": result.time,
        "series": {"time": series["time"].values, **{k: v.values for k, v in series.data_vars.items()}},
        "files": files,
    }
    mapping: dict[str, Any] = plain(content)
    return mapping


def draw(result: Any, dpi: float | None, path: Path) -> None:
    from .. import plots

    plots.save(plots.gas(result), path, dpi)


def save(result: Any, path: Path) -> Path:
    """Save the series, the log if there is one, and the final state as NetCDF."""
    saved: Path = result.save(path)
    return saved
