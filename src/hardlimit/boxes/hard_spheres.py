"""Hard spheres by events: the rules of collision, a run from a system or from a checkpoint."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

from ..contact.contact import Law
from ..support import validation
from ..support.progress import Report, reporter
from .engines import checked_keeping, checked_samples, later_time
from .result import ParticleResult, Settings
from .run import Course, Target, engine_of, load
from .softness import refuse_too_soft
from .system import ParticleSystem
from .theory import Gas

#: Rules with a constant restitution, and those with a contact law.
RULES: Final = {"restitution": ("constant", "tc"), "law": ("law", "tc", "soft")}
MOST_COLLISIONS: Final = 2**62
#: How much finer than expected the samples of an open-ended run are at first.
FINER: Final = 64


def event_driven(
    system: ParticleSystem,
    *,
    law: Law | None = None,
    restitution: float | None = None,
    until: float | None = None,
    max_collisions: int | None = None,
    rule: str | None = None,
    contact_duration: float | None = None,
    samples: int = 100,
    log: bool = False,
    checkpoint: str | Path | None = None,
    checkpoint_every: float = 60.0,
    progress: bool | Report | None = None,
) -> ParticleResult:
    """Let the particles of a box collide as hard spheres: every collision is an instant.

    Parameters
    ----------
    system : ParticleSystem
    law : Law
        Contact law, whose restitution depends on the pair and the speed of impact; or
    restitution : float
        ε of all collisions, in [0, 1]. Give exactly one of the two.
    until : float [s]
    max_collisions : int
        Stop at the instant of this collision; those with walls count. Give one of the two, or both.
    rule : {"constant", "law", "tc", "soft"}
        ``"constant"``: ε (default with ``restitution``). ``"law"``: ε(v) of the law (default with ``law``). ``"tc"``:
        elastic where a partner has collided less than ``contact_duration`` ago, with anything (Luding & McNamara 1998).
        ``"soft"``: a contact takes time and turns the normal, as the law says (Müller & Pöschel 2013).
    contact_duration : float [s]
        Of the rule tc.
    samples : int
        Spacings of the series. With ``max_collisions`` alone, at least half as many and at most twice.
    log : bool
        Keep every collision; 28 bytes each.
    checkpoint : path, optional
        A file from which :func:`resume` goes on: written at the start, every ``checkpoint_every`` seconds, at Ctrl-C
        and at the end.
    checkpoint_every : float [s]
        By the clock on the wall.
    progress : bool or callable(done, total), optional
        True shows a bar. A function is told the collisions so far, and how many to expect at this rate.

    Returns
    -------
    ParticleResult
        An inelastic collapse is an outcome, no error.

    Raises
    ------
    ValueError
        If an argument is outside its range, or two do not go together.
    OSError
        If a checkpoint cannot be written; names it.

    Notes
    -----
    Sources: Luding & McNamara, Granular Matter 1, 113 (1998); Müller & Pöschel, Phys. Rev. E 87, 033301 (2013).

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
    if not isinstance(system, ParticleSystem):
        raise ValueError(f"system: got {validation.shown(system)}, must be a ParticleSystem")
    settings = checked_settings(law, restitution, rule, contact_duration)
    end = checked_end(until, max_collisions, samples)
    if until is None and max_collisions is None:
        raise ValueError("until | max_collisions: got neither, must be at least one of them")
    _, keep, path, every = checked_keeping(samples, log, checkpoint, checkpoint_every)
    with reporter(progress, "event-driven", "collisions") as report:
        return start(system, settings, end.target(system), keep, path, every).run(report)


def start(
    system: ParticleSystem,
    settings: Settings,
    target: Target,
    log: bool = False,
    path: Path | None = None,
    every: float = math.inf,
) -> Course:
    """A run at its beginning; the other arguments are checked.

    Raises
    ------
    ValueError
        If contacts under the law would be too deep.
    """
    refuse_too_soft(system, settings.law)
    empty = (np.empty(0), np.empty(0, np.int64), np.empty(0, np.int64), np.empty(0))
    engine = engine_of(system, settings, log)
    return Course(system, settings, engine, target, log=empty if log else None, path=path, every=every)


def resume(
    path: str | Path,
    *,
    until: float | None = None,
    max_collisions: int | None = None,
    progress: bool | Report | None = None,
) -> ParticleResult:
    """Go on with a run from its checkpoint, with the bits of a run that was not stopped; checkpoints go on as well.

    Parameters
    ----------
    path : path
        The checkpoint.
    until : float [s], optional
    max_collisions : int, optional
        Counted from the start of the run. Without both, the end that the run was given. The samples keep their spacing.
    progress
        As for :func:`event_driven`.

    Raises
    ------
    ValueError
        If the file is no checkpoint, is damaged or of another version, or the new end lies before its state.
    OSError
        If a checkpoint cannot be written; names it.
    """
    course = load(path)
    if until is not None or max_collisions is not None:
        course.set_end(*later_end(course, until, max_collisions))
    with reporter(progress, "event-driven", "collisions") as report:
        return course.run(report)


def later_end(course: Course, until: Any, max_collisions: Any) -> tuple[float | None, int | None]:
    """The end of a run that goes on, checked.

    Raises
    ------
    ValueError
        If it lies before the state of the checkpoint, or takes too many samples.
    """
    end = None if until is None else later_time(course, until)
    most = None
    if max_collisions is not None:
        most = validation.whole("max_collisions", max_collisions, course.engine.n_contacts, MOST_COLLISIONS)
    return end, most


# --- checks of the input ------------------------------------------------------------------------------------


def checked_settings(law: Any, restitution: Any, rule: Any, contact_duration: Any) -> Settings:
    """What the collisions obey.

    Raises
    ------
    ValueError
        If a value is outside its range, or two do not go together.
    """
    given = validation.exactly_one(law=law, restitution=restitution)
    if given == "law" and not isinstance(law, Law):
        raise ValueError(f"law: got {validation.shown(law)}, must be a contact law such as LinearDashpot")
    chosen = RULES[given][0]
    if rule is not None:
        known = sorted({name for names in RULES.values() for name in names})
        chosen = validation.one_of("rule", rule, known)
        if chosen not in RULES[given]:
            raise ValueError(f"rule: got {rule!r} with {given}, must be one of {', '.join(RULES[given])}")
    if given == "restitution":
        limits = {"lowest_allowed": True, "highest_allowed": True}
        restitution = validation.number("restitution", restitution, 0.0, 1.0, **limits)
    if chosen != "tc":
        if contact_duration is not None:
            shown = validation.shown(contact_duration)
            raise ValueError(f"contact_duration: got {shown}, must be left out unless the rule is tc")
        return Settings(chosen, restitution, law, None)
    if contact_duration is None:
        raise ValueError("contact_duration: missing, must be given for the rule tc")
    duration = validation.number("contact_duration", contact_duration, 0.0, lowest_allowed=True)
    return Settings(chosen, restitution, law, duration)


class End(NamedTuple):
    """Where a run shall end, and how many samples it shall have."""

    until: float | None  #: [s]
    max_collisions: int | None
    samples: int

    def target(self, system: ParticleSystem) -> Target:
        """The same with a first spacing of the samples."""
        if self.until is not None:
            return Target(self.until, self.max_collisions, self.until, self.samples)
        assert self.max_collisions is not None
        return Target(
            None, self.max_collisions, expected_duration(system, self.max_collisions) / FINER, self.samples
        )


def checked_end(until: Any, max_collisions: Any, samples: Any) -> End:
    """The end of a run.

    Raises
    ------
    ValueError
        If a value is outside its range.
    """
    end = None if until is None else validation.number("until", until, 0.0, lowest_allowed=True)
    most = None
    if max_collisions is not None:
        most = validation.whole("max_collisions", max_collisions, 0, MOST_COLLISIONS)
    return End(end, most, checked_samples(samples))


def expected_duration(system: ParticleSystem, collisions: int) -> float:
    """A rough guess of the time [s] that so many collisions take: Enskog's, or of falling; never 0."""
    volume, mean = float(np.prod(system.box)), float(system.radius.mean())
    temperature = system.granular_temperature
    g = float(np.linalg.norm(system.gravity))
    fallen = g * float(system.box.max())
    scale = max(temperature, fallen)
    if not scale > 0.0:
        return 1.0
    dense = Gas(system.n, mean, 1.0, volume, system.dimension)
    rate = float(dense.collision_rate(scale))
    found = 2.0 * max(collisions, 1) / (system.n * rate) if rate > 0.0 else 1.0
    return found if 0.0 < found < math.inf else 1.0
