"""Run a job with LAMMPS on this machine, and build the result from its output."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any, Final

import numpy as np

from ...support import validation
from ...support.progress import Report
from ..box import AXES, Floats
from ..contacts import rubs
from ..engines import ENGINES
from ..falling_frame import laboratory_sums, system_at
from ..observables import components
from ..result import ContactResult
from ..system import ParticleSystem
from . import job as jobs
from . import output, process
from .contact_log import Contacts, contacts
from .forces import Pairs
from .job import Job
from .overlaps import DumpReader, Finder, PairDump, SpringReader, WallDump
from .program import find

MAX_RANKS: Final = 1_000_000
#: Numbers of contacts, which need a log.
COUNTS: Final = ("n_contacts", "n_pairs", "n_ended", "n_overlapped")
Reader = DumpReader | SpringReader


def checked_ranks(ranks: Any) -> int:
    return 1 if ranks is None else validation.whole("ranks", ranks, 1, MAX_RANKS)


def run(job: Job, ranks: int, report: Report) -> ContactResult:
    """Run LAMMPS in a temporary folder. Raises ImportError without a suitable LAMMPS, RuntimeError if it fails."""
    program = find(ranks)
    with tempfile.TemporaryDirectory(prefix="hardlimit-lammps-", ignore_cleanup_errors=True) as name:
        folder = Path(name)
        jobs.write(job, folder)
        readers = dump_readers(job)

        def on_line(line: str) -> None:
            row = output.row_of(line)
            if row is not None:
                report(int(row[0]), job.plan.n_steps)

        command = program.command(ranks, "-in", jobs.INPUT, "-log", jobs.LOG)
        dumps = {name: reader.read for name, reader in readers.items()}
        process.run(command, folder, program.environment(), dumps, on_line)
        return result(job, folder, list(readers.values()))


def dump_readers(job: Job) -> dict[str, Reader]:
    pairs, plan = Pairs(job.system, job.law), job.plan

    def reader(dump: PairDump | WallDump, springs: SpringReader | None = None) -> DumpReader:
        finder = Finder(pairs, plan.time_step, plan.n_steps) if plan.log else None
        return DumpReader(dump, pairs, plan.per_sample, finder, springs)

    springs = SpringReader(pairs, job.system) if pairs.damped else None
    readers: dict[str, Reader] = {jobs.PAIRS: reader(PairDump(pairs), springs)}
    if "wall" in job.system.boundary:
        readers[jobs.WALLS] = reader(WallDump(pairs, job.system))
    if springs is not None:
        readers[jobs.MOTION] = springs
    return readers


def result(job: Job, folder: Path, readers: list[Reader]) -> ContactResult:
    """Build the result from the files that LAMMPS wrote to the folder."""
    plan = job.plan
    *falling, spin = output.state(folder / jobs.END, job.system, rubs(job.law))
    log = _contacts(readers) if plan.log else None
    kept = _samples(job, output.thermo(folder / jobs.LOG), readers, log)
    counts: dict[str, Any] = {name: None if log is None else int(kept[name][-1]) for name in COUNTS}
    return ContactResult(
        system=system_at(job.system, plan.until, (falling[0], falling[1]), spin),
        time=plan.until,
        law=job.law,
        engine="lammps",
        outcome_name="ok",
        samples=kept,
        log=None if log is None else tuple(log),
        time_step=plan.time_step,
        n_steps=plan.n_steps,
        **counts,
    )


def _contacts(readers: list[Reader]) -> Contacts:
    finders = [reader.finder for reader in readers if reader.finder is not None]
    begins = [change for finder in finders for change in finder.begins]
    ends = [change for finder in finders for change in finder.ends]
    return contacts(begins, ends)


def _samples(job: Job, thermo: Floats, readers: list[Reader], log: Contacts | None) -> dict[str, Floats]:
    """The quantities recorded at the samples."""
    plan, system = job.plan, job.system
    seen = dict(zip(output.THERMO, thermo.T, strict=True))
    expected = (plan.samples if plan.n_steps else 0) + 1
    if len(thermo) != expected or seen["step"][-1] != plan.n_steps:
        raise ValueError(
            f"{jobs.LOG}: got {len(thermo)} samples, must be {expected}, the last at step {plan.n_steps}"
        )
    time = plan.until * (np.arange(len(thermo)) / plan.samples)
    seen["momentum"] = np.stack([seen[name] for name in ("px", "py", "pz")[: system.dimension]], axis=1)
    kinetic_tensor, virial = (
        np.stack([seen[f"{name}_{component}"] for component in components(system.dimension)], axis=1)
        for name in ("kinetic", "virial")
    )
    seen["kinetic_tensor"] = kinetic_tensor
    lasted = np.diff(time, prepend=0.0)
    turned = _turned(seen, lasted)
    shear_work = _shear_work(system, seen, lasted, turned)
    seen = laboratory_sums(system, time, seen)
    kinetic, potential, rotational = (
        seen[f"{kind}_energy"] for kind in ("kinetic", "potential", "rotational")
    )
    sums = np.array([[reader.sums[int(step)] for step in seen["step"]] for reader in readers]).sum(axis=0)
    stored, tangential, in_contact = sums.T
    # Tangential springs are relaxed at the start, also where the damping alone exceeds the limit.
    stored[0], tangential[0] = stored[0] - tangential[0], 0.0
    total = kinetic + potential + rotational + stored - shear_work
    virial = virial * system.domain.volume * lasted[:, None] + _symmetric(system.dimension, turned)
    columns = {
        "time": time,
        "kinetic_energy": kinetic,
        "potential_energy": potential,
        "contact_energy": stored,
        "dissipated_energy": total[0] - total,
        "granular_temperature": seen["granular_temperature"],
        "momentum": seen["momentum"],
        "n_in_contact": in_contact.astype(np.int64),
        "kinetic_tensor": seen["kinetic_tensor"],
        "virial_tensor": np.cumsum(virial, axis=0),
        "flow_momentum": seen["flow_momentum"],
        "shear_work": shear_work,
        **_counts(time, log),
    }
    if rubs(job.law):
        columns |= {
            "rotational_energy": rotational,
            "tangential_energy": tangential,
            "spin": seen["spin"] if system.dimension == 3 else seen["spin"][:, 2],
        }
    return {name: columns[name] for name in ENGINES["lammps"].records if name in columns}


def _turned(seen: dict[str, Floats], lasted: Floats) -> Floats:
    """Angular impulse (samples, 3) of pairs on the spins since the previous sample: −Σ ∫ r × F dt [kg m²/s]."""
    spin, torque = (
        np.stack([seen[f"{name}_{axis}"] for axis in AXES], axis=1) for name in ("spin", "torque")
    )
    seen["spin"] = spin
    by_pairs: Floats = np.diff(spin, axis=0, prepend=spin[:1]) - torque * lasted[:, None]
    return by_pairs


def _symmetric(dimension: int, turned: Floats) -> Floats:
    """What makes the virials r_x F_y, r_x F_z and r_y F_z of LAMMPS symmetric, from the impulses of :func:`_turned`."""
    half = 0.5 * turned
    off = [half[:, 2]] if dimension == 2 else [half[:, 2], -half[:, 1], half[:, 0]]
    return np.stack([*[np.zeros(len(half))] * dimension, *off], axis=1)


def _shear_work(system: ParticleSystem, seen: dict[str, Floats], lasted: Floats, turned: Floats) -> Floats:
    """Work of a Lees–Edwards boundary up to each sample [J]; 0 without one.

    The energy relative to the mean flow u gains −γ̇ V P_yx per time, with the virial r_y F_x, and −F·u from friction at
    walls. The rest is the change of what the mean flow adds to the kinetic energy.
    """
    axis = system.domain.gradient
    if axis is None:
        return np.zeros(len(lasted))
    of_flow = seen["kinetic_energy"] - 0.5 * seen["kinetic_tensor"][:, : system.dimension].sum(axis=1)
    across = seen["kinetic_across"] + seen[f"virial_x{AXES[axis]}"] * system.domain.volume
    other = turned[:, 2] if axis == 1 else -turned[:, 1]  # r_y F_x − r_x F_y
    relative = -system.shear_rate * (across * lasted + other) - seen["power_on_flow"] * lasted
    work: Floats = of_flow - of_flow[0] + np.cumsum(relative)
    return work


def _counts(time: Floats, log: Contacts | None) -> dict[str, Floats]:
    """Number of contacts up to each sample; NaN without a log."""
    if log is None:
        return dict.fromkeys(COUNTS, np.full(len(time), np.nan))
    ended = ~np.isnan(log.end)
    of = {
        "n_contacts": log.begin,
        "n_pairs": log.begin[log.second >= 0],
        "n_ended": np.sort(log.end[ended]),
        "n_overlapped": np.sort(log.end[ended & log.overlapped]),
    }
    return {name: np.searchsorted(when, time, side="right").astype(float) for name, when in of.items()}
