"""Where replicas start: a system, other equilibrium states of it, or what a function makes of a seed."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any, Final

import numpy as np

from ..boxes.box import Floats
from ..boxes.engine_choice import check_box
from ..boxes.hard_spheres import event_driven
from ..boxes.system import ParticleSystem
from ..support import validation
from ..support.progress import Report

#: Elastic collisions per particle between the given start and that of another replica.
COLLISIONS: Final = 20


@dataclass(frozen=True)
class Starts:
    """The start of each replica."""

    source: ParticleSystem | Callable[[int], ParticleSystem]
    seed: int
    engine: str = "events"  #: that solves Newton's equations for them

    def start(self, replica: int, report: Report) -> ParticleSystem:
        """Of one replica.

        Raises
        ------
        ValueError
            If the function made no system that Newton's equations can be solved for.
        """
        if isinstance(self.source, ParticleSystem):
            return self.source if replica == 0 else equilibrated(self.source, self.seed + replica, report)
        made = self.source(self.seed + replica)
        if not isinstance(made, ParticleSystem):
            raise ValueError(
                f"system: the function made {validation.shown(made)}, must make a ParticleSystem"
            )
        if self.engine == "events":
            check_box(made)
        return made


def checked_starts(source: Any, seed: Any, replicas: int, elsewhere: bool, engine: str) -> Starts:
    """The starts of ``replicas`` replicas; ``elsewhere``: other processes make them.

    Raises
    ------
    ValueError
        If there is no way to so many starts.
    """
    if isinstance(source, ParticleSystem):
        source = _written_out(source)
    found = Starts(source, validation.whole("seed", seed, 0, 2**62), engine)
    if isinstance(source, ParticleSystem):
        if engine == "events":
            check_box(source)
        if replicas > 1:
            _check_redraw(source, replicas)
    elif not callable(source) or isinstance(source, type):
        shown = validation.shown(source)
        raise ValueError(
            f"system: got {shown}, must be a ParticleSystem or a function of a seed that makes one"
        )
    elif elsewhere:
        _check_importable(source)
    return found


def _written_out(system: ParticleSystem) -> ParticleSystem:
    """The same with an entry for each particle, as other processes get it: sums over equal masses that share one
    place in memory are rounded in another way."""
    values = {field.name: getattr(system, field.name) for field in fields(system)}
    for name in ("radius", "mass"):
        values[name] = np.ascontiguousarray(values[name])
    return ParticleSystem._of(**values)


def _check_redraw(system: ParticleSystem, replicas: int) -> None:
    reason = None
    if system.gravity.any():
        reason = "under gravity"
    elif system.n < 2 or system.granular_temperature == 0.0:
        reason = "without motion of particles against each other"
    if reason is not None:
        raise ValueError(
            f"system | replicas: got one start {reason} and {replicas} replicas, must be a function of a seed that "
            "makes each start: such a start cannot be drawn anew"
        )


def _check_importable(source: Any) -> None:
    try:
        pickle.dumps(source)
    except Exception:  # pickle raises many kinds
        raise ValueError(
            f"system: got {validation.shown(source)}, must be a function that other processes can import, "
            "or workers=1"
        ) from None


def equilibrated(
    system: ParticleSystem, seed: int, report: Report | None = None, collisions: int = COLLISIONS
) -> ParticleSystem:
    """Another state of the same particles with the same energy: new velocities of an equilibrium (Maxwell), then
    ``collisions`` elastic collisions per particle as hard spheres, then the velocities shifted and scaled to the mean
    velocity and the granular temperature of ``system``, both exactly but for rounding."""
    chance = np.random.default_rng(np.random.SeedSequence([seed, system.n]))
    drawn = (
        chance.standard_normal((system.n, system.dimension))
        / np.sqrt(system.mass / system.mass.max())[:, None]
    )
    fresh = system.replace(velocities=_as_in(system, drawn))
    most = max(1, collisions * system.n // 2)
    run = event_driven(fresh, restitution=1.0, max_collisions=most, samples=1, progress=report)
    return run.system.replace(velocities=_as_in(system, run.system.velocities))


def _as_in(system: ParticleSystem, velocities: Floats) -> Floats:
    """Velocities with the mean and the granular temperature of ``system``."""
    relative = velocities - np.average(velocities, axis=0, weights=system.mass)
    total = float(system.mass.sum())
    temperature = float(np.einsum("i,ij,ij->", system.mass, relative, relative)) / (system.dimension * total)
    found: Floats = relative * np.sqrt(system.granular_temperature / temperature) + system.momentum / total
    return found
