"""Arrays with names, units and meanings, as all measurements return them."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from ..boxes.box import AXES, Floats
from ..boxes.system import ParticleSystem
from ..support import validation


def variable(dims: Any, values: Any, units: str, long_name: str) -> tuple[Any, Any, dict[str, str]]:
    """A variable of an xarray object."""
    return dims, values, {"units": units, "long_name": long_name}


def array(name: str, dims: Any, values: Any, units: str, long_name: str, **coordinates: Any) -> xr.DataArray:
    attrs = {"units": units, "long_name": long_name}
    return xr.DataArray(values, coordinates, dims, name, attrs)


def axes(system: ParticleSystem) -> list[str]:
    """Values of the coordinate ``axis``."""
    return list(AXES[: system.dimension])


def checked_axis(name: str, axis: Any, system: ParticleSystem) -> int:
    """The index of an axis given by its letter."""
    return AXES.index(validation.one_of(name, axis, axes(system)))


def regular(time: Floats) -> int:
    """Number of the first times that are at equal intervals: all, all but the last of a run that ended early, or 0."""
    if len(time) < 3:
        return len(time)
    spacing = float(time[1] - time[0])
    off = np.abs(time - time[0] - spacing * np.arange(len(time))) > 1e-6 * abs(spacing)
    if not off.any():
        return len(time)
    ended_early = not off[:-1].any() and abs(time[-1] - time[-2]) < abs(spacing)
    return len(time) - 1 if ended_early else 0


def checked_bins(bins: Any) -> int:
    return validation.whole("bins", bins, 1, 1_000_000)
