"""Fig. 5: ε_eff/ε over Δh at ε = 0.9, and the number of contacts."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..sweep import sweep
from .sampling import counts_of, refine
from .setup import RESTITUTION_5, Setup

TITLE = "Effective restitution over the initial gap"
CHOICES = "The ranges are chosen here: Δh up to 4 mm, and from 0.3 µm to 0.44 mm on a logarithmic axis."

SMALL = (3e-7, 4.4e-4)
LARGE = (4.4e-4, 4e-3)


def compute(setup: Setup) -> xr.Dataset:
    """One curve from 0.3 µm to 4 mm, crowded towards every jump; both panels are cut from it."""
    column = setup.linear(RESTITUTION_5)
    grid = np.concatenate([np.geomspace(*SMALL, 2400), np.linspace(*LARGE, 600)])
    gap, _ = refine(counts_of(column, "gap"), grid, logarithmic=True)
    data = sweep(
        column,
        gap=gap,
        variables=["n_contacts", "relative_velocity", "restitution_ratio", "t_floor_end", "t_end"],
    )
    data["n_contacts"] = data["n_contacts"].astype(np.int64)
    data["magnified_gap"] = ((), SMALL[1], {"units": "m", "long_name": "largest Δh of the magnification"})
    return data


def safe_gap(data: xr.Dataset, within: float = 0.01) -> float:
    """Smallest Δh from which on the ratio stays within ``within`` of 1 [m]; NaN if none does."""
    good = np.abs(data["restitution_ratio"].values - 1.0) <= within
    bad = np.flatnonzero(~good)
    first = 0 if bad.size == 0 else bad[-1] + 1
    return float(data["gap"].values[first]) if first < good.size else float("nan")


def meaning(data: xr.Dataset) -> str:
    """What the figure means for an event-driven simulation."""
    return (
        f"With ε = {RESTITUTION_5} an event-driven simulation has the right relative velocity, to one per "
        f"cent of ε, only where the gap is larger than {safe_gap(data) * 1e3:.1f} mm; at smaller gaps the "
        f"effective restitution varies by jumps, down to almost nothing."
    )
