"""Parse the output of LAMMPS: dumps, which may still be written, the log and the final state."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np

from ..box import Floats
from ..observables import components
from ..system import ParticleSystem

#: Columns of the log of LAMMPS, which has one row for each sample.
THERMO: Final = (
    *("step", "kinetic_energy", "px", "py", "pz"),
    *(f"kinetic_{component}" for component in components(3)),
    *("flow_momentum", "kinetic_across", "potential_energy"),
    *(f"virial_{component}" for component in components(3)),
    *("rotational_energy", "spin_x", "spin_y", "spin_z", "torque_x", "torque_y", "torque_z"),
    "power_on_flow",
)


class Snapshot(NamedTuple):
    """One step of a dump."""

    step: int
    rows: list[str]


def snapshots(lines: Iterable[str]) -> Iterator[Snapshot]:
    """The steps of a dump in order."""
    source = iter(lines)
    for line in source:
        if not line.startswith("ITEM: TIMESTEP"):
            raise ValueError(f"an incomplete dump: {line.strip()!r}")
        try:
            step = int(next(source))
            next(source)
            n = int(next(source))
            for _ in range(5):  # the box and the names of the columns
                next(source)
            rows = [next(source) for _ in range(n)]
        except (StopIteration, ValueError):
            raise ValueError("an incomplete dump") from None
        yield Snapshot(step, rows)


def table(rows: list[str], width: int) -> Floats:
    """Convert rows of numbers to an array."""
    numbers = np.array(" ".join(rows).split(), dtype=np.float64)
    if numbers.size != len(rows) * width:
        raise ValueError("an incomplete dump")
    return numbers.reshape(len(rows), width)


def thermo(path: Path) -> Floats:
    """The rows of the log with the columns ``THERMO``."""
    with open(path, encoding="utf-8", errors="replace") as file:
        rows = [row for row in map(row_of, file) if row is not None]
    return np.array(rows).reshape(-1, len(THERMO))


_ROW: Final = re.compile(rf"\s*\d+(\s+[-+.\deEnaif]+){{{len(THERMO) - 1}}}\s*")


def row_of(line: str) -> list[float] | None:
    """The numbers of a sample, or None if the line is not a sample."""
    return [float(word) for word in line.split()] if _ROW.fullmatch(line) else None


def state(path: Path, system: ParticleSystem, rotates: bool) -> tuple[Floats, Floats, Floats | None]:
    """Positions and velocities of the unfolded paths, (N, d) each, and angular velocities (N, 3) if they change."""
    with open(path, encoding="utf-8") as file:
        (last,) = snapshots(file)
    columns, d = table(last.rows, 11 if rotates else 8), system.dimension
    positions, velocities = columns[:, 1 : 1 + d], columns[:, 4 : 4 + d]
    if system.domain.gradient is not None:
        velocities[:, 0] += columns[:, 7] * (system.shear_rate * float(system.box[system.domain.gradient]))
    spin = np.ascontiguousarray(columns[:, 8:]) if rotates else None
    return np.ascontiguousarray(positions), np.ascontiguousarray(velocities), spin
