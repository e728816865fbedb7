"""Initial states of the replicas: a system and other equilibrium states of it, or a function of a seed."""

from __future__ import annotations

import math
import pickle
from collections.abc import Callable
from dataclasses import dataclass, replace
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
    box: str = ""  #: :func:`box_of` replica 0; not compared if empty

    def start(self, replica: int, report: Report) -> ParticleSystem:
        if isinstance(self.source, ParticleSystem):
            system = self.source if replica == 0 else equilibrated(self.source, self.seed + replica, report)
            return _with_own_kicks(system, replica)
        system = self.source(self.seed + replica)
        if not isinstance(system, ParticleSystem):
            raise ValueError(
                f"system: got {validation.shown(system)} from the function, must be a ParticleSystem"
            )
        if self.box and box_of(system) != self.box:
            other = f"{box_of(system)} from the function for replica {replica}"
            raise ValueError(f"system: got {other}, must be {self.box} as for replica 0")
        if self.engine == "events":
            check_box(system)
        return _with_own_kicks(system, replica)


def box_of(system: ParticleSystem) -> str:
    """What all replicas must share, in words: dimension, boundary, gravity and kind of driving."""
    parts = [f"a box of dimension {system.dimension}, {', '.join(system.boundary)}"]
    if system.gravity.any():
        parts.append(f"gravity {system.gravity.tolist()}")
    if system.walls:
        parts.append(f"moving walls {', '.join(sorted(system.walls))}")
    if system.thermostat is not None:
        parts.append(type(system.thermostat).__name__)
    if system.shear_rate:
        parts.append(f"shear rate {system.shear_rate:g}")
    return ", ".join(parts)


def _with_own_kicks(system: ParticleSystem, replica: int) -> ParticleSystem:
    """The system with another seed of its thermostat for each replica."""
    thermostat = system.thermostat
    if thermostat is None or replica == 0:
        return system
    return system.replace(thermostat=replace(thermostat, seed=(thermostat.seed + replica) % 2**63))


def checked_starts(source: Any, seed: Any, replicas: int, elsewhere: bool, engine: str) -> Starts:
    """Check the argument ``system``; ``elsewhere`` is true if other processes make the initial states."""
    number = validation.whole("seed", seed, 0, 2**62)
    if isinstance(source, ParticleSystem):
        # Arrays of full length, as in other processes: the sum of a broadcast array is rounded differently.
        full = {name: np.ascontiguousarray(getattr(source, name)) for name in ("radius", "mass")}
        source = ParticleSystem._of(**source._values() | full)
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
        try:
            pickle.dumps(source)
        except Exception:  # pickle raises many kinds
            shown = validation.shown(source)
            raise ValueError(
                f"system: got {shown}, must be a function that other processes can import"
            ) from None
    return Starts(source, number, engine)


def is_redrawn(system: ParticleSystem) -> bool:
    """Whether a system is a gas, so that replicas can start from other equilibrium states of it."""
    return not _reason_against_redrawing(system)


def _reason_against_redrawing(system: ParticleSystem) -> str:
    """Why there is no equilibrium state from which a replica could start; empty for a gas."""
    if system.gravity.any():
        return "under gravity"
    if system.walls:
        return "with moving walls"
    if system.n < 2 or system.granular_temperature == 0.0:
        return "without relative motion of its particles"
    return ""


def _check_redraw(system: ParticleSystem, replicas: int) -> None:
    reason = _reason_against_redrawing(system)
    if reason:
        raise ValueError(
            f"system | replicas: got a system {reason} and {replicas} replicas, must be a function of a seed that "
            "returns the start of each replica, or a gas without gravity and moving walls"
        )


def equilibrated(
    system: ParticleSystem, seed: int, report: Report | None = None, collisions: int = COLLISIONS
) -> ParticleSystem:
    """Another equilibrium state of the same particles with the same energy.

    Velocities and spins are drawn from Maxwell distributions, each particle undergoes ``collisions`` elastic
    collisions as a hard sphere, and the velocities are shifted and scaled to the mean velocity and granular temperature
    of ``system``.
    The collisions of a sheared box are without shear, and its mean flow is added at the end.
    """
    rng = np.random.default_rng(np.random.SeedSequence([seed, system.n]))
    drawn = (
        rng.standard_normal((system.n, system.dimension)) / np.sqrt(system.mass / system.mass.max())[:, None]
    )
    drift = (system.momentum - system.mass @ system.domain.mean_flow(system.positions)) / system.mass.sum()
    start = system.replace(velocities=_rescaled(drawn, system, drift), thermostat=None, shear_rate=0.0)
    n_collisions = max(1, collisions * system.n // 2)
    run = event_driven(start, restitution=1.0, max_collisions=n_collisions, samples=1, progress=report)
    at, velocities = run.system.positions, _rescaled(run.system.velocities, system, drift)
    return run.system.replace(
        velocities=velocities + system.domain.mean_flow(at),
        thermostat=system.thermostat,
        shear_rate=system.shear_rate,
        angular_velocities=_other_spins(system, rng),
    )


def _other_spins(system: ParticleSystem, rng: np.random.Generator) -> Floats | None:
    """Maxwellian angular velocities with the mean and the energy relative to it of those of ``system``."""
    if system.angular_velocities is None:
        return None
    spin, inertia = system.angular_velocities.reshape(system.n, -1), system.inertia
    mean = np.average(spin, axis=0, weights=inertia)
    drawn = rng.standard_normal(spin.shape) / np.sqrt(inertia / inertia.max())[:, None]
    drawn -= np.average(drawn, axis=0, weights=inertia)
    wanted, energy = (float(np.einsum("i,ij,ij->", inertia, x, x)) for x in (spin - mean, drawn))
    scaled: Floats = mean + drawn * math.sqrt(wanted / energy if energy > 0.0 else 0.0)
    return scaled.reshape(system.angular_velocities.shape)


def _rescaled(velocities: Floats, system: ParticleSystem, drift: Floats) -> Floats:
    """Velocities, shifted and scaled to the mean velocity ``drift`` and the granular temperature of ``system``."""
    relative = velocities - np.average(velocities, axis=0, weights=system.mass)
    total = float(system.mass.sum())
    temperature = float(np.einsum("i,ij,ij->", system.mass, relative, relative)) / (system.dimension * total)
    rescaled: Floats = relative * np.sqrt(system.granular_temperature / temperature) + drift
    return rescaled
