"""``hardlimit gas --engine``: the same boxes under Newton's equations."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import click

from ..boxes.lammps.folder import lammps_input
from ..boxes.newton import NAMES, molecular_dynamics
from ..boxes.result import ContactResult
from ..boxes.system import ParticleSystem, described
from .gas_job import ContactJob, make_contact_job
from .gas_report import mapping, save
from .options import options, output_option, quantity_option
from .printing import console, digits, print_json, show, table

engine_options = options(
    click.option(
        "--engine",
        type=click.Choice(NAMES),
        help="Solve Newton's equations instead, with a --law; auto: events or steps, whichever costs less.",
    ),
    quantity_option(
        "--restitution-error",
        unit="1",
        help="Error of ε that the time step may make (steps, lammps), by steps of energies and positions as well.  "
        "[default: 0.001]",
    ),
    quantity_option(
        "--time-step", unit="s", help="Instead of that error, the longest step [s] (steps, lammps)."
    ),
    click.option(
        "--threads",
        type=int,
        help="Threads (steps).  [default: one for each 1000 particles, at most all processors]",
    ),
    click.option("--ranks", type=int, help="Number of MPI processes (lammps).  [default: 1]"),
    output_option("--write-input", "Write the input of LAMMPS there, run nothing (lammps).", "FOLDER"),
)
OWN: Final = ("restitution_error", "time_step", "threads", "ranks")


def run_contacts(file: str | None, resume: str | None, as_json: bool, given: dict[str, Any]) -> None:
    """What the command does where an engine is given.

    Raises
    ------
    ValueError
        For anything that no run can be made of.
    """
    if resume is not None:
        raise ValueError("--resume: must be left out with --engine")
    engine, folder = given.pop("engine"), given.pop("write_input")
    own = {name: given.pop(name) for name in OWN}
    job = make_contact_job(file, given)
    if folder is not None:
        click.echo(f"written to {written_input(job, engine, folder, own)}")
        return
    result = molecular_dynamics(
        job.system,
        law=job.law,
        until=job.until,
        engine=engine,
        log=job.save is not None,
        progress=True,
        **own,
        **job.options,
    )
    how = {name: getattr(result, name) for name in ("engine", "engine_reason")}
    files = [] if job.save is None else [save(result, job.save, how, "contacts")]
    if as_json:
        print_json(as_mapping(job.system, result, files))
    else:
        print_report(job.system, result, files)


def refuse_without_engine(given: dict[str, Any]) -> None:
    """Take what belongs to an engine out of the options of hard spheres.

    Raises
    ------
    ValueError
        If one of them is given.
    """
    for name in ("engine", "write_input", *OWN):
        if given.pop(name) is not None:
            raise ValueError(f"--{name.replace('_', '-')}: must be left out without --engine")


def written_input(job: ContactJob, engine: str, folder: str, own: dict[str, Any]) -> Path:
    """The input of LAMMPS.

    Raises
    ------
    ValueError
        If another engine, or what has a meaning only in a run, is given.
    """
    if engine != "lammps":
        raise ValueError(f"--write-input: must be left out with --engine {engine}")
    for name in ("threads", "ranks"):
        if own[name] is not None:
            raise ValueError(f"--{name}: must be left out with --write-input")
    for name in ("checkpoint", "checkpoint_every"):
        if name in job.options:
            raise ValueError(f"--{name.replace('_', '-')}: must be left out with --write-input")
    steps = {name: own[name] for name in ("restitution_error", "time_step")}
    if job.save is not None:
        raise ValueError("--save: must be left out with --write-input")
    return lammps_input(job.system, folder, law=job.law, until=job.until, **steps, **job.options)


def print_report(start: ParticleSystem, result: ContactResult, files: list[Path]) -> None:
    """The system, what came out, how it ended."""
    out = console()
    what = "spheres" if start.dimension == 3 else "disks"
    show(out, f"{start.n} {what}", table(["", ""], [[label, text] for label, text in described(start)]))
    rows = [[label, digits(value)] for label, value in result.quantities()]
    show(out, f"Newton's equations, {result.law!r}", table(["", result.engine], rows))
    if result.engine_reason:
        out.print(result.choice(), markup=False)
    style = "default" if result.outcome_code == 0 else "yellow"
    out.print(f"outcome: {result.outcome}", style=style, markup=False)
    for path in files:
        out.print(f"written to {path}", markup=False)


def as_mapping(start: ParticleSystem, result: ContactResult, files: list[Path]) -> dict[str, Any]:
    """Everything the tables show and the series, in SI units."""
    law = result.law
    names = ("n_contacts", "n_pairs", "n_ended", "n_overlapped", "overlapped_share", "energy_error")
    return mapping(
        start,
        result,
        files,
        {
            "engine": result.engine,
            "engine_reason": result.engine_reason,
            "law": {"name": law.record["name"], **law.parameters},
            **{name: getattr(result, name) for name in names},
            "time_step": result.time_step,
            "n_steps": result.n_steps,
            "largest_cluster": result.largest_cluster,
            "cluster_share": result.cluster_share,
        },
    )
