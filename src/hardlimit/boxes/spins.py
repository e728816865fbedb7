"""Spins of grains: their checks, default moments of inertia, and the arrays of the core."""

from __future__ import annotations

from types import MappingProxyType
from typing import Any, Final

import numpy as np

from ..support import validation
from .box import LARGEST, Floats

#: Number of axes about which particles rotate, by dimension.
AXES_OF_ROTATION: Final = {2: 1, 3: 3}
#: q of the moment of inertia q m R² of a solid disk and a solid sphere.
SOLID: Final = {2: 0.5, 3: 0.4}
#: Range of q.
SMALLEST, HIGHEST = 1e-6, 1.0
#: The fields of a system without spins.
NONE: Final = MappingProxyType({"angular_velocities": None, "inertia_factor": None})


def solid(n: int, dimension: int) -> Floats:
    """q of n solid bodies."""
    return np.full(n, SOLID[dimension])


def checked_factor(inertia_factor: Any, n: int, d: int) -> Floats:
    """q of n particles; that of solid bodies if it is None."""
    if inertia_factor is None:
        return solid(n, d)
    limits = {"lowest": SMALLEST, "highest": HIGHEST, "lowest_allowed": True, "highest_allowed": True}
    return validation.each("inertia_factor", inertia_factor, n, **limits)


def checked(angular_velocities: Any, inertia_factor: Any, n: int, d: int) -> dict[str, Floats | None]:
    """The fields of a system: both arrays, or None twice if neither is given."""
    if angular_velocities is None and inertia_factor is None:
        return dict(NONE)
    factor = checked_factor(inertia_factor, n, d)
    shape = (n, 3) if d == 3 else (n,)
    if angular_velocities is None:
        return {"angular_velocities": np.zeros(shape), "inertia_factor": factor}
    spin = validation.as_array(angular_velocities)
    if spin is None:
        shown = validation.shown(angular_velocities)
        raise ValueError(f"angular_velocities: got {shown}, must be numbers of shape {shape}")
    if spin.shape != shape:
        raise ValueError(f"angular_velocities: got shape {spin.shape}, must be {shape}")
    good = np.abs(spin) <= LARGEST  # not for NaN
    if not good.all():
        bad = int(np.argmin(good.reshape(n, -1).all(axis=1)))
        raise ValueError(
            f"angular_velocities[{bad}]: got {spin[bad].tolist()}, must be in [{-LARGEST:g}, {LARGEST:g}]"
        )
    if hasattr(angular_velocities, "__array__"):  # it may share the memory
        spin = spin.copy()
    return {"angular_velocities": spin, "inertia_factor": factor}


def energy(angular_velocities: Floats | None, inertia: Floats) -> float:
    """Rotational energy Σ I ω²/2 [J]."""
    if angular_velocities is None:
        return 0.0
    rows = angular_velocities.reshape(len(inertia), -1)
    return 0.5 * float(np.einsum("i,ij,ij->", inertia, rows, rows))


def for_core(angular_velocities: Floats) -> Floats:
    """Angular velocities as the core takes them, (N, 3) also in two dimensions."""
    if angular_velocities.ndim == 2:
        return np.ascontiguousarray(angular_velocities)
    rows = np.zeros((len(angular_velocities), 3))
    rows[:, 2] = angular_velocities
    return rows


def from_core(rows: Floats, dimension: int) -> Floats:
    """The reverse of :func:`for_core`."""
    return rows if dimension == 3 else rows[:, 2].copy()
