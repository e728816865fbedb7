"""``lammps_input`` and ``lammps_result``: write the folder of a run for another machine, and read its results."""

from __future__ import annotations

import math
import stat
from pathlib import Path
from typing import Any

from ...contact.contact import Law
from ...support import validation
from .. import time_step as steps
from ..contacts import checked_law, checked_system, refuse_fall_past_walls, refuse_too_soft, rubs
from ..result import ContactResult
from ..run import checked_output
from ..system import ParticleSystem
from . import engine, integration_error
from . import job as jobs
from .forces import factor_of, rotation_of, types_of
from .job import Job
from .script import Plan

MOST_STEPS = 2**31 - 1  # between outputs: LAMMPS reads the number into an int


def lammps_input(
    system: ParticleSystem,
    folder: str | Path,
    *,
    law: Law,
    until: float,
    restitution_error: float | None = None,
    time_step: float | None = None,
    samples: int = 100,
    log: bool = False,
) -> Path:
    """Write the input of LAMMPS for a run on another machine, such as a cluster.

    Start the run with ``mpiexec -n 64 lmp -in in.hardlimit`` in the folder, as the first lines of the input say.
    :func:`lammps_result` reads the results. ``molecular_dynamics(engine="lammps")`` runs the same input.

    Returns the path of the input script. Other parameters and errors are those of :func:`event_driven` and
    :func:`molecular_dynamics`.

    Parameters
    ----------
    folder : path
        Created if it does not exist. Existing files of the same names are replaced.
    log : bool
        Keep every contact. LAMMPS then writes all overlaps at every step, about 70 bytes each and 200 bytes per step.

    Raises
    ------
    OSError
        If a file cannot be written; names it.

    Examples
    --------
    >>> gas = hl.ParticleSystem.random(
    ...     100, packing_fraction=0.1, radius=1e-3, density=2500.0, rms_speed=0.1
    ... )
    >>> law = hl.LinearDashpot(stiffness=1e4, restitution=0.8)
    >>> path = hl.lammps_input(gas, "cluster", law=law, until=0.01)
    >>> sorted(file.name for file in path.parent.iterdir())
    ['hardlimit.json', 'in.hardlimit', 'start.data']
    """
    target = _checked_folder(folder)
    end = validation.number("until", until, 0.0, lowest_allowed=True)
    job = make_job(
        system=checked_system(system),
        law=checked_law(law),
        until=end,
        restitution_error=restitution_error,
        time_step=time_step,
        samples=samples,
        log=log,
    )
    try:
        target.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OSError(f"{folder}: cannot be written: {error.strerror or error}") from error
    return jobs.write(job, target)


def lammps_result(folder: str | Path) -> ContactResult:
    """Read the result of a run of LAMMPS in a folder written by :func:`lammps_input`.

    Masses are computed from the densities in the file and have rounding errors.

    Parameters
    ----------
    folder : path

    Raises
    ------
    ValueError
        If the folder has no such run, or the run has not ended; names the file.
    FileNotFoundError
        If there is no such file.
    """
    target = _checked_folder(folder)
    job = jobs.read(target)
    readers = engine.dump_readers(job)
    try:
        for name, reader in readers.items():
            with open(target / name, encoding="utf-8", errors="replace") as lines:
                reader.read(lines)
        return engine.result(job, target, list(readers.values()))
    except OSError as error:
        raise validation.unreadable(error.filename, error) from None
    except (KeyError, ValueError) as error:
        raise ValueError(f"{folder}: must contain the output of a run that ended: {error}") from None


def make_job(
    system: ParticleSystem,
    law: Law,
    until: float,
    restitution_error: Any,
    time_step: Any,
    samples: Any,
    log: Any,
) -> Job:
    """Check the arguments and make the job for LAMMPS."""
    if system.walls:
        raise ValueError(f"walls: got {', '.join(system.walls)}, must be none that move for engine 'lammps'")
    if system.thermostat is not None:
        raise ValueError(f"thermostat: got {system.thermostat.report()}, must be none for engine 'lammps'")
    count, keep, *_ = checked_output(samples, log, None, 60.0)
    refuse_fall_past_walls(system, rubs(law))
    refuse_too_soft(system, law)
    rotation_of(system, law)
    types_of(system, law)
    longest = steps.chosen(system, law, restitution_error, time_step, _longest_step(system, law))
    fewest = until / (count * longest)  # may be infinite
    if fewest > MOST_STEPS:
        raise ValueError(
            f"time_step: got {longest:g} s, must be >= {until / count / MOST_STEPS:.3g} s: LAMMPS takes at most "
            f"{MOST_STEPS} steps between samples"
        )
    per_sample = max(1, math.ceil(fewest))
    step = until / (count * per_sample) if until > 0.0 else min(longest, 1.0)
    return Job(system, law, Plan(until, count, per_sample, step, keep))


def _longest_step(system: ParticleSystem, law: Law) -> steps.LongestStep:
    """The longest step of LAMMPS for a contact of the system."""
    if not rubs(law):
        return integration_error.longest_step
    elastic, inelastic = law.record["powers"]
    factor = float(factor_of(system)[0])
    return integration_error.LongestStep((elastic, inelastic), factor)


def _checked_folder(folder: Any) -> Path:
    target = validation.path("folder", folder)
    try:
        good = stat.S_ISDIR(target.stat().st_mode)
    except FileNotFoundError:
        good = True
    except OSError:  # the name is too long
        good = False
    if not good or not str(folder):
        raise ValueError(f"folder: got {validation.shown(str(folder))}, must be a folder")
    return target
