"""``hardlimit gas compare``: simulate a box under Newton's equations and under each rule for hard spheres."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, Final

import click

import hardlimit as hl

from ..boxes.system import ROUNDING, described
from ..column import files
from ..fidelity_study import ENGINES, MODELS
from ..fidelity_study import report as texts
from ..fidelity_study.starts import is_redrawn
from ..support import machine, validation
from ..support.formatting import digits
from .gas_job import (
    ALIASES,
    FRICTION,
    RESTITUTION,
    SAMPLES,
    START,
    UNTIL,
    GasJob,
    default_end,
    entry_of,
    make_job,
)
from .job import Entry, entry_options
from .options import (
    dpi_option,
    friction_options,
    json_option,
    law_options,
    law_text,
    output_option,
    picture,
    with_friction,
    writable,
)
from .printing import console, plain, print_files, print_json, show, table
from .program import Command, goes_on_from, in_options, raise_all, write_files

#: Default stiffness [N/m] for the default glass beads. It is lower than that of glass; t_c ν is about 0.02.
STIFFNESS: Final = 1e6
REPLICAS: Final = 8

#: Arguments of ``hl.fidelity``.
ARGUMENTS: Final = (
    Entry(
        "models",
        f"Model: {' | '.join(MODELS)}; may be repeated, always with newton.  [default: all]",
        many=True,
    ),
    Entry("contact_duration", "Contact duration of the rule tc [s].  [default: that of the law]", unit="s"),
    Entry(
        "tangential_restitution",
        "Tangential restitution β of the rules constant and tc without sliding.  [default: the one that stands for the "
        "law in a gas]",
        unit="1",
    ),
    UNTIL,
    SAMPLES,
    Entry("engine", f"Engine for Newton’s equations: {' | '.join(ENGINES)}.  [default: auto]"),
    Entry("replicas", f"Number of initial states, for the error bars.  [default: {REPLICAS}]", kind=int),
    entry_of(
        hl.fidelity,
        "resolution",
        "Relative difference to resolve; the output says how many replicas it needs.",
        "1",
    ),
    Entry("workers", "Number of processes.  [default: one for each processor]", kind=int),
    Entry("scheduler", "Address of a dask.distributed scheduler, instead of processes on this machine."),
    Entry("store", "File of finished replicas, from which the same command continues.", metavar="FILE"),
)
#: Entries of a job's table [event_driven] that this command uses.
OF_A_JOB: Final = ("until", "samples", "contact_duration", "tangential_restitution")


@click.command(
    cls=Command,
    aliases=ALIASES,
    epilog="\b\nExample:\n  hardlimit gas compare --n 500 --stiffness 2e5 --restitution 0.9 --plot compare.png",
)
@click.argument("file", required=False, metavar="[FILE]")
@entry_options(START)
@law_options()
@friction_options()
@entry_options(ARGUMENTS)
@output_option("--out", "Means and replicas as NetCDF.", "FILE.nc")
@output_option("--plot", "Differences over time (png, pdf, …).")
@dpi_option
@json_option()
def compare(
    file: str | None, out: str | None, plot: str | None, dpi: float | None, as_json: bool, **params: Any
) -> None:
    """Compare each rule for hard spheres with Newton's equations.

    FILE and the options of start and law are those of hardlimit gas. The default law is linear with a stiffness of 1e6
    N/m and a restitution of 0.9. Each replica starts from another random state, or, if FILE has particles, from another
    equilibrium state of these particles; under gravity or with moving walls there is one replica. Hard spheres that
    overlap at the start collide at once if they approach, and fly apart if not. From a job file, this command uses
    start, law, until, samples, restitution and contact duration.
    """
    saved, picture_file = writable("out", out, ".nc"), picture("plot", plot)
    arguments = {entry.name: params.pop(entry.name) for entry in ARGUMENTS}
    job = make_job(file, params)
    law = contact_law(job)
    start, fidelity = compared(job, law, {name: v for name, v in arguments.items() if v not in (None, ())})
    written, failures = write_files((saved, fidelity.save), (picture_file, partial(draw, fidelity, dpi)))
    if as_json:
        overlaps = {
            "largest_overlap": start.largest_overlap,
            "energy_of_overlaps": energy_of_overlaps(start, law),
        }
        print_json(as_mapping(fidelity, written) | overlaps)
    else:
        print_report(start, law, fidelity, written)
    raise_all(failures)


def draw(fidelity: hl.Fidelity, dpi: float | None, path: Path) -> None:
    from .. import plots

    plots.save(fidelity.plot(), path, dpi)


def random_start(job: GasJob, seed: int) -> hl.ParticleSystem:
    """The random start of a job with another seed."""
    return job.start(seed=seed)


def compared(job: GasJob, law: hl.Law, arguments: dict[str, Any]) -> tuple[hl.ParticleSystem, hl.Fidelity]:
    """The start of replica 0, and the comparison."""
    run = {name: job.run[name] for name in OF_A_JOB if name in job.run} | arguments
    if "models" in run:
        run["models"] = tuple(dict.fromkeys(("newton", *run["models"])))
    system: hl.ParticleSystem | Callable[[int], hl.ParticleSystem]
    if job.file is None:
        run["seed"] = validation.whole("seed", job.random.get("seed", 0), 0, 2**62)
        system = partial(random_start, job)
        start = system(run["seed"])
    else:
        system = start = job.start()
    run.setdefault("until", default_end(start))
    run.setdefault("replicas", REPLICAS if job.file is None or is_redrawn(start) else 1)
    if "scheduler" not in run:
        run.setdefault("workers", machine.processors())
    with goes_on_from(run.get("store"), "replicas"):
        return start, hl.fidelity(system, law=law, **run, progress=True)


def energy_of_overlaps(start: hl.ParticleSystem, law: hl.Law) -> float:
    """Elastic energy of the contacts at the start over its kinetic energy; hard spheres do not have it."""
    if start.largest_overlap <= ROUNDING or start.kinetic_energy == 0.0:
        return 0.0
    stored = hl.molecular_dynamics(start, law=law, until=0.0).series.contact_energy
    return float(stored.values[0]) / start.kinetic_energy


def contact_law(job: GasJob) -> hl.Law:
    """The law of job and options; linear with default values if neither names a law."""
    name, parameters = job.law_option
    friction = job.friction
    if job.law is None:
        parameters = {key: x for key, x in job.constant.items() if key != FRICTION} | parameters
        friction = {key: x for key, x in job.constant.items() if key == FRICTION} | friction
    elif FRICTION in job.constant:
        raise ValueError(f"law | event_driven.{FRICTION}: got both, must be exactly one of them")
    return with_friction(_smooth_law(job.law, name, parameters), friction)


def _smooth_law(present: hl.Law | None, name: str | None, parameters: dict[str, Any]) -> hl.Law:
    defaults = {"stiffness": STIFFNESS, "restitution": RESTITUTION}
    linear = name in (None, hl.LinearDashpot.record["name"])
    if present is None and linear and parameters.keys() <= defaults.keys():
        return hl.LinearDashpot(**(defaults | parameters))
    return files.changed_law(present, name, parameters)


# --- output -------------------------------------------------------------------------------------------------


def print_report(start: hl.ParticleSystem, law: hl.Law, fidelity: hl.Fidelity, written: list[Path]) -> None:
    """Print the system, the differences, the first significant differences, the contacts, and a summary."""
    out = console()
    rows = [
        *described(start),
        *overlap_rows(start, law),
        ("contact duration t_c [s]", digits(fidelity.contact_duration, 4)),
        ("t_c ν, mean of the run", digits(fidelity.tc_nu, 3)),
        ("δ/d, mean greatest compression", digits(fidelity.delta_over_d, 3)),
        ("replicas", str(fidelity.n_replicas)),
    ]
    show(out, start.count(), table(["", ""], rows), law_text(law))
    if len(fidelity.models) > 1:
        below = texts.legend(fidelity) if fidelity.n_replicas > 1 or fidelity.driven else "no error bars"
        show(
            out,
            f"Difference from Newton’s equations {texts.when(fidelity)} [%]",
            table(*texts.table(fidelity)),
            below,
        )
        head, left = texts.table(fidelity)[0], texts.departures(fidelity)
        if left:
            show(out, "First significant difference after [t_c], by [%]", table(head, left))
    show(out, "Contacts", table(*texts.contacts(fidelity)))
    out.print(in_options(fidelity.summary()), markup=False)
    print_files(out, written)


def overlap_rows(start: hl.ParticleSystem, law: hl.Law) -> list[tuple[str, str]]:
    """What overlaps at the start mean, if there are any."""
    energy = energy_of_overlaps(start, law)
    return [("energy of the overlaps / kinetic, not in hard spheres", digits(energy, 3))] if energy else []


def as_mapping(fidelity: hl.Fidelity, files: list[Path]) -> dict[str, Any]:
    """The summary, and means and differences with their errors, in SI units."""
    ds = fidelity.dataset
    content: dict[str, Any] = plain(
        {
            **{name: value for name, value in ds.attrs.items() if name not in ("title", "source")},
            "models": fidelity.models,
            "coordinates": {name: ds[name].values for name in ds.coords},
            "variables": {
                name: {"dims": v.dims, "units": v.attrs["units"], "values": v.values}
                for name, v in ds.data_vars.items()
            },
            f"predicted_{'temperature' if fidelity.driven else 'cooling'}": {
                model: fidelity.predicted(model)._asdict() for model in fidelity.models[1:]
            },
            "outcomes": {model: fidelity.outcomes(model) for model in fidelity.models},
            "files": files,
        }
    )
    return content
