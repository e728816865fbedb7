"""``hl.fidelity``: comparison of collision rules for hard spheres with Newton's equations."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from ..boxes import engine_choice
from ..boxes.contacts import checked_law, mean_contact, mean_grain, rubs
from ..boxes.rules import RULES
from ..boxes.run import checked_samples
from ..boxes.system import ParticleSystem
from ..boxes.thermostats import refuse_rotational
from ..contact import compression
from ..contact.contact import Law
from ..support import validation
from ..support.progress import Report, reporter
from . import statistics
from .replica import NEWTON, RESTITUTION_ERROR, Plan, digest
from .result import RESOLUTION, Fidelity
from .starts import Starts, box_of, checked_starts
from .store import Store, facts_of

__all__ = ["MODELS", "Fidelity", "fidelity"]

#: A comparison gives a rule no parameter but the duration of a contact.
MODELS: Final = (
    NEWTON,
    *(name for name, rule in RULES.items() if {*rule.parameters} <= {"contact_duration"}),
)
ENGINES: Final = ("auto", "events", "steps")
LEAST_RESOLUTION: Final = 1e-5


def fidelity(
    system: ParticleSystem | Callable[[int], ParticleSystem],
    *,
    law: Law,
    until: float,
    models: Sequence[str] = MODELS,
    replicas: int = 1,
    samples: int = 100,
    restitution: float | None = None,
    contact_duration: float | None = None,
    tangential_restitution: float | None = None,
    resolution: float = RESOLUTION,
    engine: str = "auto",
    seed: int = 0,
    workers: int = 1,
    scheduler: Any = None,
    store: str | Path | None = None,
    progress: bool | Report | None = None,
) -> Fidelity:
    """Compare rules for hard spheres with Newton's equations, for one initial state and over replicas.

    All models of a replica start from the same state. Differences between models therefore scatter less than the values
    themselves. Errors are standard errors over replicas; a single replica gives no errors and no verdict.

    With moving walls, a thermostat or shear, averages over the steady state are compared; under shear also the shear
    stress and the first normal stress difference, unless there are shear bands. If no steady state is found by
    ``until``, the summary says so and nothing is averaged (:attr:`Fidelity.steady`). A single replica then has the
    errors of its correlated samples.

    Parameters
    ----------
    system : ParticleSystem or callable(seed)
        Initial state of replica 0. Replica k > 0 starts from another equilibrium state of the same particles: new
        velocities (Maxwell, seed ``seed`` + k), about 20 elastic collisions per particle, then a shift and a scaling
        of the velocities to the mean velocity and granular temperature of ``system``, and its mean flow if it is
        sheared. States out of equilibrium or
        under gravity or with moving walls need a function instead, which is called with ``seed`` + k and returns the
        initial state of replica k, in a box of the same dimension, boundary, gravity and kind of driving. Each replica
        gets another seed of its thermostat. Particles may overlap (``allowed_overlap``): hard spheres then begin
        without the energy of the overlaps (:doc:`/grains`).
    law : Law
        Contact law of Newton's equations and of the rules law and soft. With friction, all models have it, and the law
        of the error predicts the rules law and constant.
    until : float [s]
    models : sequence of {"newton", "constant", "law", "tc", "soft"}
        Must include ``"newton"``. :func:`event_driven` describes the rules (Luding & McNamara 1998, Müller & Pöschel
        2013).
    replicas : int
        Number of initial states.
    samples : int
        Number of sampling intervals.
    restitution : float, optional
        ε of the rules constant and tc. Default: that of the law for two particles of mean mass and radius at the mean
        impact speed of the initial state, √(πT); if the law was given by a restitution, this restitution.
    contact_duration : float [s], optional
        t_c of the rule tc and of t_c ν. Default: that of the law for the same impact.
    tangential_restitution : float, optional
        β of the rules constant and tc without sliding, for a law with friction, whose μ they have. Default: the one
        that stands for the law in a gas (:meth:`Contact.effective_tangential_restitution`).
    resolution : float
        Relative difference that must be resolved, 1e-5 to 1. A rule agrees with Newton's equations only if the
        half-width of the 99 % confidence interval (Student's distribution) is at most this. Otherwise it is not
        resolved, and the summary says how many replicas would be needed.
    engine : {"auto", "events", "steps"}
        Engine for Newton's equations: see :func:`molecular_dynamics`. ``"auto"`` chooses for the initial state of
        replica 0, and keeps the choice. ``"steps"`` suits long contacts (t_c ν above about 0.1, with large clusters)
        and heaps; it changes ε by at most 1e-4.
    seed : int
        The same seed gives the same initial states.
    workers : int
        Number of processes; 1 computes in the calling process. The result does not depend on it.
    scheduler : str, distributed.Client or cluster object, optional
        Scheduler of a dask.distributed cluster on which to compute instead (extra ``hardlimit[cluster]``).
    store : path, optional
        File that keeps the finished replicas. The same call computes only missing ones; a call with more ``replicas``
        adds to them.
    progress : bool or callable(done, total), optional
        True shows a bar. A function is called with the number of samples so far and in total, over all models and
        replicas.

    Raises
    ------
    ValueError
        If an argument is outside its range, two arguments exclude each other, two replicas start from the same state,
        or the store was made with other arguments. An inelastic collapse is an outcome, not an error.
    OSError
        If the store cannot be written; names it.
    ImportError
        If ``scheduler`` is given without dask.distributed.
    RuntimeError
        If a process dies or the connection to the scheduler is lost.

    Examples
    --------
    >>> disks = hl.ParticleSystem.random(
    ...     16, 0.3, radius=1e-3, density=2500.0, rms_speed=0.1, dimension=2
    ... )
    >>> law = hl.LinearDashpot(stiffness=1e3, restitution=0.8)
    >>> found = hl.fidelity(
    ...     disks, law=law, until=0.02, models=["newton", "law"], replicas=4, samples=4
    ... )
    >>> print(found)
    At t_c ν = 0.014 (δ/d = 0.0038) the rule law is not resolved by cooling: ± 5.6 %
    with 4 replicas (99 % confidence); for ± 1 % about 29 replicas would be needed.
    The law of the error predicts 1.9 ± 0.4 % for law.
    """
    checked_law(law)
    count = validation.whole("replicas", replicas, 1, statistics.MAX_REPLICAS)
    many = validation.whole("workers", workers, 1, 1024)
    if scheduler is not None and many > 1:
        raise ValueError(f"scheduler | workers: got both ({many} workers), must be at most one of them")
    chosen = _checked_models(models)
    end = validation.number("until", until, 0.0, lowest_allowed=True)
    spacings = checked_samples(samples)
    limits = {"lowest_allowed": True, "highest_allowed": True}
    resolved = validation.number("resolution", resolution, LEAST_RESOLUTION, 1.0, **limits)
    solver = validation.one_of("engine", engine, ENGINES)
    if solver == "events":
        engine_choice.check_friction(law)
    elsewhere = scheduler is not None or (many > 1 and count > 1)
    starts = checked_starts(system, seed, count, elsewhere, solver)
    with reporter(progress, "fidelity", "samples") as report:
        first = starts.start(0, lambda done, total: None)
        if not rubs(law):
            refuse_rotational(first.thermostat)
        if solver == "auto":
            solver = engine_choice.estimated(first, law, end, RESTITUTION_ERROR).engine
        beta = _tangential(first, law, tangential_restitution)
        starts = replace(starts, engine=solver, box=box_of(first))
        plan = Plan(
            law, chosen, end, spacings, *_impact(first, law, restitution, contact_duration), solver, beta
        )
        _refuse_endless_heating(first, plan.restitution, law)
        kept = Store(store, facts_of(plan, digest(first).tobytes().hex(), starts.seed))
        wanted = [k for k in range(count) if k not in kept.replicas]
        _compute(
            starts=starts,
            plan=plan,
            kept=kept,
            wanted=wanted,
            count=count,
            workers=many if elsewhere else 1,
            scheduler=scheduler,
            report=report,
        )
    _refuse_equal_starts(kept, count)
    result = Fidelity(
        plan=plan,
        start=first,
        dimension=first.dimension,
        arrays=tuple(kept.replicas[k] for k in range(count)),
        resolution=resolved,
    )
    compression.warn(result.largest_compression, stacklevel=3)
    return result


def _compute(
    starts: Starts,
    plan: Plan,
    kept: Store,
    wanted: Sequence[int],
    count: int,
    workers: int,
    scheduler: Any,
    report: Report,
) -> None:
    """Compute the missing replicas and add each to the store as it finishes."""
    finished = (count - len(wanted)) * plan.steps

    def tell(done: int) -> None:
        report(finished + done, count * plan.steps)

    tell(0)
    if not wanted:
        return
    from . import pool  # multiprocessing takes 0.1 s to import

    if scheduler is not None:
        computed = pool.on_cluster(starts, plan, wanted, scheduler)
    elif workers > 1 and len(wanted) > 1:
        computed = pool.processes(starts, plan, wanted, workers, tell)
    else:
        computed = pool.here(starts, plan, wanted, tell)
    with closing(computed):
        for n_done, (replica, arrays) in enumerate(computed, 1):
            kept.add(replica, arrays)
            if scheduler is not None:
                tell(n_done * plan.steps)
    tell(len(wanted) * plan.steps)


# --- checks of the input ------------------------------------------------------------------------------------


def _checked_models(models: Any) -> tuple[str, ...]:
    """Newton's equations first, then the rules in the given order."""
    names = validation.instances("models", models, str, "name")
    for i, name in enumerate(names):
        validation.one_of(f"models[{i}]", name, MODELS)
    if len(set(names)) < len(names):
        raise ValueError(f"models: got {', '.join(names)}, must contain each model once")
    if NEWTON not in names:
        raise ValueError(f"models: got {', '.join(names) or 'none'}, must include {NEWTON}, the reference")
    return (NEWTON, *(name for name in names if name != NEWTON))


def _impact(system: ParticleSystem, law: Law, restitution: Any, contact_duration: Any) -> tuple[float, float]:
    """ε and t_c [s] of the rules constant and tc: as given, or those of a typical impact."""
    typical, speed = mean_contact(system, law), np.array([typical_speed(system)])
    epsilon = law.specified_restitution
    if restitution is not None:
        limits = {"lowest_allowed": True, "highest_allowed": True}
        epsilon = validation.number("restitution", restitution, 0.0, 1.0, **limits)
    elif not math.isfinite(epsilon):
        epsilon = float(typical.restitution(speed)[0])
    if contact_duration is None:
        return epsilon, float(typical.duration(speed)[0])
    return epsilon, validation.number("contact_duration", contact_duration, 0.0, lowest_allowed=True)


def _tangential(system: ParticleSystem, law: Law, tangential_restitution: Any) -> float | None:
    """β0 of the rules constant and tc, as given or that of a typical impact; None without friction, also for μ = 0."""
    own: float | None = None
    if tangential_restitution is not None:
        if law.friction is None:
            shown = validation.shown(tangential_restitution)
            raise ValueError(
                f"tangential_restitution: got {shown}, must be left out for a law without friction"
            )
        limits = {"lowest_allowed": True, "highest_allowed": True}
        own = validation.number("tangential_restitution", tangential_restitution, -1.0, 1.0, **limits)
    if not rubs(law):
        return None
    if own is not None:
        return own
    grain = mean_grain(system)
    beta = law.between(grain, grain).effective_tangential_restitution(typical_speed(system), system.dimension)
    if not beta <= 1.0:  # NaN, or grains that gain energy by Mindlin's springs
        raise ValueError(
            "tangential_restitution: missing, must be given: no constant one stands for this law in a gas"
        )
    return beta


def _refuse_endless_heating(system: ParticleSystem, restitution: float, law: Law) -> None:
    """Refuse elastic grains without friction in a sheared box, which have no steady state."""
    if system.shear_rate == 0.0 or rubs(law):
        return
    for name, value in (("law", law.specified_restitution), ("restitution", restitution)):
        if value == 1.0:
            raise ValueError(
                f"{name}: got ε = 1 in a sheared box, must be < 1: elastic grains only heat and reach no steady state"
            )


def typical_speed(system: ParticleSystem) -> float:
    """Mean impact speed √(πT) [m/s] in a gas of this granular temperature; of a single particle its speed.

    For particles at rest, the speed after a fall through the height of the box, or 1 m/s without gravity.
    """
    alone = float(np.linalg.norm(system.velocities)) if system.n == 1 else None
    thermal = math.sqrt(math.pi * system.granular_temperature) if alone is None else alone
    fall = math.sqrt(2.0 * float(np.abs(system.gravity) @ system.box))
    return thermal or fall or 1.0


def _refuse_equal_starts(kept: Store, count: int) -> None:
    seen: dict[bytes, int] = {}
    for k in range(count):
        start = kept.replicas[k]["start"].tobytes()
        if start in seen:
            raise ValueError(
                f"system: got the same start for replicas {seen[start]} and {k}, must be different ones"
            )
        seen[start] = k
