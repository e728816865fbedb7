"""What all compiled engines of boxes of grains take and give, and what is kept of their runs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import validation
from ..contact import Law
from ..laws import LAWS
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


# --- in and out ---------------------------------------------------------------------------------------------


def scene(
    system: ParticleSystem,
) -> tuple[Floats, Floats, Floats, Floats, list[float], list[bool], list[float]]:
    """A system as the engines take it."""
    return (
        system.positions,
        system.velocities,
        np.ascontiguousarray(system.radius),
        np.ascontiguousarray(system.mass),
        system.box.tolist(),
        [side == "periodic" for side in system.boundary],
        system.gravity.tolist(),
    )


def choice(law: Law) -> tuple[str, int, list[float]]:
    """A law as the engines take it."""
    return law.record["name"], law.alternative, list(law.parameters.values())


def present(system: ParticleSystem, engine: Any) -> ParticleSystem:
    """The system now, inside the box."""
    positions, velocities = engine.state()
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
    positions, velocities = engine.state()
    fixed = {name: arrays[name] for name in FIXED}
    return ParticleSystem._of(
        positions=positions, velocities=velocities, boundary=tuple(header["boundary"]), **fixed
    )


def log_in(arrays: Mapping[str, NDArray[Any]], columns: int) -> Log | None:
    """The log of a checkpoint, if it has one."""
    return tuple(arrays[f"log_{i}"] for i in range(columns)) if "log_0" in arrays else None
