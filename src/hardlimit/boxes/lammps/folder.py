"""``lammps_input`` and ``lammps_result``: write the folder of a run for another machine, and read its results."""

from __future__ import annotations

import math
import os
import stat
from pathlib import Path
from typing import Any

from ...contact.contact import Law
from ...support import validation
from .. import time_step as steps
from ..result import ContactResult
from ..run import checked_keeping
from ..softness import refuse_too_soft
from ..system import ParticleSystem
from . import half_steps, running
from . import job as jobs
from .forces import types_of
from .job import Job
from .script import Plan


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

    Parameters
    ----------
    system : ParticleSystem
    folder : path
        Created if it does not exist. Existing files of the same names are replaced.
    law : Law
    until : float [s]
        This and the other parameters are those of :func:`molecular_dynamics`.
    restitution_error : float, optional
    time_step : float [s], optional
    samples : int
        Number of intervals between samples of the series.
    log : bool
        Keep every contact. LAMMPS then writes all overlaps at every step, about 70 bytes each and 200 bytes per step.

    Returns
    -------
    Path
        Path of the input script ``in.hardlimit``. The folder also gets ``start.data`` and ``hardlimit.json``.

    Raises
    ------
    ValueError
        As for :func:`molecular_dynamics`.
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
    if not isinstance(system, ParticleSystem):
        raise ValueError(f"system: got {validation.shown(system)}, must be a ParticleSystem")
    if not isinstance(law, Law):
        raise ValueError(f"law: got {validation.shown(law)}, must be a contact law such as LinearDashpot")
    end = validation.number("until", until, 0.0, lowest_allowed=True)
    job = make_job(system, law, end, restitution_error, time_step, samples, log)
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

    Returns
    -------
    ContactResult

    Raises
    ------
    ValueError
        If the folder has no such run, or the run has not ended; names the file.

    Examples
    --------
    >>> gas = hl.ParticleSystem.random(
    ...     100, packing_fraction=0.1, radius=1e-3, density=2500.0, rms_speed=0.1
    ... )
    >>> law = hl.LinearDashpot(stiffness=1e4, restitution=0.8)
    >>> path = hl.lammps_input(gas, "cluster", law=law, until=0.01)
    >>> hl.lammps_result("cluster")  # before LAMMPS has run there
    Traceback (most recent call last):
    ValueError: cluster/pairs.dump: cannot be read: No such file or directory
    """
    target = _checked_folder(folder)
    job = jobs.read(target)
    readers = running.dump_readers(job)
    try:
        for name, reader in readers.items():
            with open(target / name, encoding="utf-8", errors="replace") as lines:
                reader.follow(lines)
        return running.result(job, target, list(readers.values()))
    except OSError as error:
        raise ValueError(f"{error.filename}: cannot be read: {error.strerror or error}") from None
    except (KeyError, ValueError) as error:
        raise ValueError(f"{folder}: not the output of a run that ended: {error}") from None


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
    count, keep, *_ = checked_keeping(samples, log, None, 60.0)
    refuse_too_soft(system, law)
    types_of(system, law)
    longest = steps.chosen(system, law, restitution_error, time_step, half_steps.longest_step)
    per_sample = max(1, math.ceil(until / (count * longest)))
    step = until / (count * per_sample) if until > 0.0 else min(longest, 1.0)
    return Job(system, law, Plan(until, count, per_sample, step, keep))


def _checked_folder(folder: Any) -> Path:
    if not isinstance(folder, str | os.PathLike):
        raise ValueError(f"folder: got {validation.shown(folder)}, must be a path")
    target = Path(folder)
    try:
        good = stat.S_ISDIR(target.stat().st_mode)
    except FileNotFoundError:
        good = True
    except (OSError, ValueError):  # the name is too long or has a null character
        good = False
    if not good or not str(folder):
        raise ValueError(f"folder: got {validation.shown(str(folder))}, must be a folder")
    return target
