"""``event_driven``: event-driven simulation of hard spheres under a collision rule."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

from ..contact.contact import Law
from ..support import validation
from ..support.progress import Report, reporter
from .contacts import checked_system, refuse_fall_past_walls, refuse_too_soft
from .engines import ENGINES, Engine
from .observe import Observe
from .result import ParticleResult
from .rules import Settings, checked_settings
from .run import Output, Run, Schedule, checked_output, checked_until
from .system import ParticleSystem
from .theory import Gas

NAME: Final = "hard_spheres"
MAX_COLLISIONS: Final = 2**62
#: In a run without ``until``, the first sampling interval is this many times shorter than the expected final one.
FIRST_SUBDIVISION: Final = 4


def event_driven(
    system: ParticleSystem,
    *,
    law: Law | None = None,
    restitution: float | None = None,
    until: float | None = None,
    max_collisions: int | None = None,
    rule: str | None = None,
    contact_duration: float | None = None,
    friction: float | None = None,
    tangential_restitution: float | None = None,
    samples: int = 100,
    log: bool = False,
    observe: Observe | None = None,
    checkpoint: str | Path | None = None,
    checkpoint_every: float = 60.0,
    progress: bool | Report | None = None,
    **parameters: float | None,
) -> ParticleResult:
    """Simulate a box of grains as hard spheres, whose collisions are instantaneous.

    Parameters
    ----------
    system : ParticleSystem
    law : Law
        Contact law that gives the restitution of each pair at each impact speed. Give exactly one of ``law`` and
        ``restitution``.
    restitution : float
        ε of all collisions, in [0, 1].
    until : float [s]
        End of the run. Give at least one of ``until`` and ``max_collisions``.
    max_collisions : int
        Number of collisions, including those with walls, after which the run ends.
    rule : {"constant", "law", "tc", "soft"}
        ``"constant"``: one ε (default with ``restitution``). ``"law"``: ε(v) of the law (default with ``law``).
        ``"tc"``: a collision is elastic if one of its partners had any collision less than ``contact_duration`` ago
        (Luding & McNamara 1998). ``"soft"``: a contact has the duration of the law, and its normal turns (Müller &
        Pöschel 2013). A law with friction gives β under ``"law"``, of its contact with a fixed normal at this speed
        and angle (Schwager, Becker & Pöschel 2008), and under ``"soft"`` the whole motion, with the spins; at walls
        that neglects tangential terms of order g t_c/v. ``"tc"``: without friction in elastic collisions.
    contact_duration : float [s]
        t_c of the rule tc.
    friction : float, optional
        Coefficient of friction μ, with ``restitution``: a collision slides if μ limits its tangential impulse
        (Walton 1993): β = min{β0, −1 + (m_n/m_t) μ (1 + ε)/tan γ} at the angle of impact γ. ``math.inf``: rough
        particles, which never slide. A law gives its own friction.
    tangential_restitution : float, optional
        β0, that of collisions that do not slide, in [−1, 1]; required with ``friction``. −1: the surfaces keep their
        tangential velocity; 0: they stop; 1: they reverse it.
    samples : int
        Number of intervals between samples of the series. With ``max_collisions`` alone, half to twice as many.
    log : bool
        Keep every collision; 40 bytes each, 57 with friction.
    observe : callable, mapping of names to callables, or a sequence of these, optional
        A function is called at each sample, including the start, with the time [s] and the current
        :class:`ParticleSystem`. It returns a mapping of names to numbers, arrays or DataArrays, which become variables
        of ``series``. A function in a mapping is called with the system only and returns the value of that name:
        ``observe={"rdf": hl.measure.rdf}``. DataArrays keep dimensions, coordinates and attributes; the variables of a
        Dataset get the prefix ``name_``. Names, shapes and coordinates must be the same at all samples. An exception
        ends the run after the checkpoint is written.
    checkpoint : path, optional
        File from which :func:`resume` continues. It is written at the start, every ``checkpoint_every`` seconds, at
        Ctrl-C and at the end.
    checkpoint_every : float [s]
        Interval between checkpoints, in wall-clock time.
    progress : bool or callable(done, total), optional
        True shows a bar. A function is called with the number of collisions so far and their expected total.
    **parameters : float
        Parameters of rules that were added to the core, by the names in their records.

    Raises
    ------
    ValueError
        If an argument is outside its range, two arguments exclude each other, or ``observe`` does not return numbers by
        name. An inelastic collapse is an outcome, not an error.
    OSError
        If a checkpoint cannot be written; names it. That of the end only warns (``CheckpointWarning``).

    Notes
    -----
    Sources: Luding & McNamara, Granular Matter 1, 113 (1998); Müller & Pöschel, Phys. Rev. E 87, 033301 (2013); with
    friction Walton, in Particulate Two-Phase Flow, ed. Roco, 884 (1993); Schwager, Becker & Pöschel, Eur. Phys. J. E
    27, 107 (2008).

    Particles that overlap at the start collide at once if they approach each other; if not, they fly apart without a
    collision (:doc:`/grains`).

    β of a law that has no scale of speed (linear, or Tsuji with Mindlin's friction) is tabulated by angle for each pair
    of kinds of particles, to 1e-10, if there are at most 16 kinds; other contacts are solved in each collision (2 to
    20 µs for the linear law, more for others), as are those of ``"soft"``. In the log ``slid`` says with ``friction``
    that μ limited the impulse, with a law that the surfaces slipped during the contact.

    Examples
    --------
    >>> gas = hl.ParticleSystem.random(
    ...     100, packing_fraction=0.1, radius=1e-3, density=2500.0, rms_speed=0.1
    ... )
    >>> run = hl.event_driven(gas, restitution=0.9, max_collisions=1000)
    >>> run
    <ParticleResult of 100 particles (constant, restitution 0.9): 1000 collisions in
    0.547465 s, ok>
    >>> round(run.system.granular_temperature / gas.granular_temperature, 3)
    0.296
    """
    checked_system(system)
    parameters |= {"contact_duration": contact_duration}
    settings = checked_settings(law, restitution, rule, friction, tangential_restitution, **parameters)
    end = checked_end(until, max_collisions)
    if until is None and max_collisions is None:
        raise ValueError("until | max_collisions: got neither, must be at least one of them")
    output = checked_output(samples, log, checkpoint, checkpoint_every, observe)
    with reporter(progress, ENGINES[NAME].task, ENGINES[NAME].counts) as report:
        result = start(system, settings, end, output).run(report)
    assert isinstance(result, ParticleResult)
    return result


class End(NamedTuple):
    """The end of a run: a time, a number of collisions, or whichever comes first."""

    until: float | None  #: [s]
    max_collisions: int | None


def checked_end(until: Any, max_collisions: Any, run: Run | None = None) -> End:
    """Check the end of a new run, or the new end of a ``run`` that is continued."""
    end = most = None
    if until is not None:
        end = (
            checked_until(run, until) if run else validation.number("until", until, 0.0, lowest_allowed=True)
        )
    if max_collisions is not None:
        done = run.engine.n_contacts if run else 0
        most = validation.whole("max_collisions", max_collisions, done, MAX_COLLISIONS)
    return End(end, most)


def start(system: ParticleSystem, settings: Settings, end: End, output: Output) -> Run:
    """Make a run that is not yet advanced, from checked arguments."""
    refuse_fall_past_walls(system, settings.has_friction)
    refuse_too_soft(system, settings.law)
    span = end.until
    if span is None:
        assert end.max_collisions is not None
        span = expected_duration(system, end.max_collisions) / FIRST_SUBDIVISION
    engine = Engine.make(NAME, system, settings, output.log)
    return Run(engine, Schedule(*end, span, output.samples), output)


def expected_duration(system: ParticleSystem, collisions: int) -> float:
    """Rough duration [s] of this number of collisions, from Enskog's rate at the larger of T and g L; never 0."""
    temperature = system.granular_temperature
    g = float(np.linalg.norm(system.gravity))
    scale = max(temperature, g * float(system.box.max()))
    gas = Gas(system.n, float(system.radius.mean()), 1.0, system.domain.volume, system.dimension)
    rate = float(gas.collision_rate(scale)) if scale > 0.0 else 0.0
    duration = 2.0 * max(collisions, 1) / (system.n * rate) if rate > 0.0 else 1.0
    return duration if 0.0 < duration < math.inf else 1.0
