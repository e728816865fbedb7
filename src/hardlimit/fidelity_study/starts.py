"""Initial states of the replicas: a system and other equilibrium states of it, or a function of a seed."""

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

#: Elastic collisions per particle between the given state and that of another replica.
COLLISIONS: Final = 20


@dataclass(frozen=True)
class Starts:
    """The initial state of each replica."""

    source: ParticleSystem | Callable[[int], ParticleSystem]
    seed: int
    engine: str = "events"  #: engine for Newton's equations

    def start(self, replica: int, report: Report) -> ParticleSystem:
        """The initial state of one replica.

        Raises
        ------
        ValueError
            If the function returned no system, or one that the engine cannot simulate.
        """
        if isinstance(self.source, ParticleSystem):
            return self.source if replica == 0 else equilibrated(self.source, self.seed + replica, report)
        made = self.source(self.seed + replica)
        if not isinstance(made, ParticleSystem):
            raise ValueError(
                f"system: the function returned {validation.shown(made)}, must return a ParticleSystem"
            )
        if self.engine == "events":
            check_box(made)
        return made


def checked_starts(source: Any, seed: Any, replicas: int, elsewhere: bool, engine: str) -> Starts:
    """Check the argument ``system``; ``elsewhere`` is true if other processes make the initial states.

    Raises
    ------
    ValueError
        If this number of initial states cannot be made.
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
            f"system: got {shown}, must be a ParticleSystem or a function of a seed that returns one"
        )
    elif elsewhere:
        _check_importable(source)
    return found


def _written_out(system: ParticleSystem) -> ParticleSystem:
    """The same system with arrays of full length, as in other processes. (A sum over a broadcast array is rounded
    differently.)"""
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
            "returns each start: other equilibrium states exist only for a gas without gravity"
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
    """Another equilibrium state of the same particles with the same energy.

    Velocities are drawn from a Maxwell distribution, each particle undergoes ``collisions`` elastic collisions as a
    hard sphere, and the velocities are shifted and scaled to the mean velocity and granular temperature of ``system``.
    """
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
