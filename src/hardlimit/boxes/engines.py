"""What all compiled engines of boxes of grains take and give, and what is kept of their runs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..contact.contact import Law
from ..contact.laws import LAWS
from ..support import validation
from . import checkpoint as checkpoints
from .system import Floats, ParticleSystem

#: Seconds [wall clock] for which an engine runs at a time, between looks at the checkpoint and the progress.
PORTION: Final = 0.2
MOST_SAMPLES: Final = 10_000_000
#: What a checkpoint holds of a system as arrays, beside its state.
FIXED: Final = ("radius", "mass", "box", "gravity")

Log = tuple[NDArray[Any], ...]


class Keeping(NamedTuple):
    """What a run keeps."""

    samples: int
    log: bool
    path: Path | None  #: of the checkpoint
    every: float  #: seconds between two checkpoints [wall clock]


def checked_keeping(samples: Any, log: Any, checkpoint: Any, checkpoint_every: Any) -> Keeping:
    """What a run shall keep.

    Raises
    ------
    ValueError
        If a value is outside its range.
    """
    return Keeping(
        checked_samples(samples),
        validation.flag("log", log),
        None if checkpoint is None else checkpoints.checked_path(checkpoint),
        validation.number("checkpoint_every", checkpoint_every, 0.0),
    )


def checked_samples(samples: Any) -> int:
    """Spacings of the series.

    Raises
    ------
    ValueError
        If it is no such number.
    """
    return validation.whole("samples", samples, 1, MOST_SAMPLES)


def later_time(course: Any, until: Any) -> float:
    """The time [s] at which a run that goes on shall end.

    Raises
    ------
    ValueError
        If it lies before the state of the checkpoint, or takes too many samples at their spacing.
    """
    end, target = validation.number("until", until), course.target
    if end < course.engine.time:
        raise ValueError(
            f"until: got {end:.16g}, must be >= {validation.at_least(course.engine.time)}, the time of the checkpoint"
        )
    most = target.span / target.samples * MOST_SAMPLES
    if 0.0 < most < end:
        raise ValueError(
            f"until: got {end:.16g}, must be <= {validation.at_most(most)}, up to which the samples, "
            f"whose spacing stays, are {MOST_SAMPLES:.0e}"
        )
    return end


# --- in and out ---------------------------------------------------------------------------------------------


def common_fall(system: ParticleSystem) -> Floats:
    """Gravity along the periodic axes [m/s²], (d,); 0 along others.

    It accelerates all particles alike, and no wall stops them. Engines work in a frame that falls with it, at rest at
    the start of the run: there speeds do not grow, and neither does the rate at which particles cross cells.
    """
    periodic = [side == "periodic" for side in system.boundary]
    return np.where(periodic, system.gravity, 0.0)


def box_of(system: ParticleSystem, gravity: Floats | None = None) -> _core.Box:
    """The box of a system as the core takes it, with this gravity [m/s²] instead of its own."""
    g = system.gravity if gravity is None else gravity
    return _core.Box(system.box.tolist(), list(system.boundary), g.tolist())


def engine_arguments(system: ParticleSystem) -> tuple[_core.Box, Floats, Floats, Floats, Floats]:
    """Box, positions, velocities, radius and mass as engines take them: without the common fall."""
    return (
        box_of(system, system.gravity - common_fall(system)),
        system.positions,
        system.velocities,
        np.ascontiguousarray(system.radius),
        np.ascontiguousarray(system.mass),
    )


def choice(law: Law) -> tuple[str, int, list[float]]:
    """A law as the engines take it."""
    return law.record["name"], law.alternative, list(law.parameters.values())


def state(system: ParticleSystem, engine: Any) -> tuple[Floats, Floats]:
    """Positions along unfolded paths [m] and velocities [m/s] now, (N, d) each, the common fall included."""
    positions, velocities = engine.state()
    gained = engine.time * common_fall(system)
    if gained.any():
        positions += 0.5 * engine.time * gained
        velocities += gained
    return positions, velocities


def observed(system: ParticleSystem, engine: Any) -> dict[str, Any]:
    """The sums that an engine knows, those over the common fall included, and the granular temperature."""
    seen, fall = dict(engine.observe()), common_fall(system)
    if fall.any():
        seen["potential_energy"] -= float(system.mass @ (engine.state()[0] @ fall))
    return with_fall(system, engine.time, seen)


def with_fall(system: ParticleSystem, time: Any, seen: dict[str, Any]) -> dict[str, Any]:
    """Sums of the laboratory from those of the falling frame, whose potential is that of all gravity; each a number or
    one for each ``time`` [s]. With the granular temperature, which is the same in both but loses its digits where the
    fall is fast.
    """
    mass, kinetic, momentum = float(system.mass.sum()), seen["kinetic_energy"], np.asarray(seen["momentum"])
    drift = (momentum * momentum).sum(axis=-1)
    temperature = np.maximum(2.0 * kinetic - drift / mass, 0.0) / (system.dimension * mass)
    gained = np.multiply.outer(time, common_fall(system))
    fallen = 0.5 * mass * (gained * gained).sum(axis=-1)
    return seen | {
        "kinetic_energy": kinetic + (gained * momentum).sum(axis=-1) + fallen,
        "potential_energy": seen["potential_energy"] - fallen,
        "momentum": momentum + mass * gained,
        "granular_temperature": temperature,
    }


def present(system: ParticleSystem, engine: Any) -> ParticleSystem:
    """The system now, inside the box."""
    positions, velocities = state(system, engine)
    for axis, side in enumerate(system.boundary):
        edge = system.box[axis]
        if side == "periodic":
            positions[:, axis] -= edge * np.floor(positions[:, axis] / edge)
        np.clip(positions[:, axis], 0.0, edge, out=positions[:, axis])
    fixed = {name: getattr(system, name) for name in (*FIXED, "boundary")}
    return ParticleSystem._of(positions=positions, velocities=velocities, **fixed)


def pace(portion: int, took: float) -> int:
    """How much an engine is asked for next, so that it answers after about the same time [wall clock]."""
    if took < 0.5 * PORTION:
        return min(2 * portion, 2**40)
    return max(portion // 2, 1) if took > 2.0 * PORTION else portion


def joined(parts: list[Log]) -> Log:
    """Logs that follow each other as one."""
    return tuple(np.concatenate(columns) for columns in zip(*parts, strict=True))


# --- checkpoints --------------------------------------------------------------------------------------------


def law_entry(law: Law | None) -> list[Any] | None:
    """A law in the header of a checkpoint."""
    return None if law is None else [law.record["name"], dict(law.parameters)]


def law_of(entry: list[Any]) -> Law:
    """The law that the header of a checkpoint names."""
    return LAWS[entry[0]](**entry[1])


def kept(system: ParticleSystem, engine: Any, rows: Floats, log: Log | None) -> dict[str, NDArray[Any]]:
    """The arrays of a checkpoint."""
    arrays: dict[str, NDArray[Any]] = {name: np.asarray(getattr(system, name)) for name in FIXED}
    arrays |= {"engine": np.frombuffer(engine.save(), np.uint8), "rows": rows}
    return arrays | {f"log_{i}": part for i, part in enumerate(log or ())}


def system_in(header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]], engine: Any) -> ParticleSystem:
    """The system of a checkpoint, its paths unfolded."""
    fixed = {name: arrays[name] for name in FIXED} | {"boundary": tuple(header["boundary"])}
    positions, velocities = engine.state()
    falling = ParticleSystem._of(positions=positions, velocities=velocities, **fixed)
    positions, velocities = state(falling, engine)
    return ParticleSystem._of(positions=positions, velocities=velocities, **fixed)


def log_in(arrays: Mapping[str, NDArray[Any]], columns: int) -> Log | None:
    """The log of a checkpoint, if it has one."""
    return tuple(arrays[f"log_{i}"] for i in range(columns)) if "log_0" in arrays else None
