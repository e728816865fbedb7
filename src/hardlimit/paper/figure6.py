"""Fig. 6: ε_eff/ε over R1/R2 at ε = 0.8, and the number of contacts."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..sweep import sweep
from .sampling import counts_of, refine
from .setup import RADIUS_RATIO, RESTITUTION_6, Setup

TITLE = "Effective restitution over the ratio of radii"
CHOICES = "The range of R1/R2, 1 to 20, is chosen here."

RATIOS = (1.0, 20.0)


def compute(setup: Setup) -> xr.Dataset:
    """One curve, crowded towards every jump and fine where the inset magnifies it."""
    column = setup.linear(RESTITUTION_6)
    grid = np.concatenate([np.linspace(*RATIOS, 2000), np.linspace(1.0, 1.7, 701)])
    ratio, _ = refine(counts_of(column, "radius_ratio"), grid)
    data = sweep(
        column,
        radius_ratio=ratio,
        variables=["n_contacts", "relative_velocity", "restitution_ratio", "t_end"],
    )
    data["n_contacts"] = data["n_contacts"].astype(np.int64)
    return data


def above_one(data: xr.Dataset) -> tuple[float, float, float, float]:
    """Where the ratio exceeds 1: from, to, and the place and height of its maximum (NaN: nowhere)."""
    x, y = data["radius_ratio"].values, data["restitution_ratio"].values
    above = np.flatnonzero(y > 1.0)
    if above.size == 0:
        return (float("nan"),) * 4
    i = int(np.nanargmax(y))
    return float(x[above[0]]), float(x[above[-1]]), float(x[i]), float(y[i])


def meaning(data: xr.Dataset) -> str:
    """What the figure means for an event-driven simulation."""
    good = np.abs(data["restitution_ratio"].values - 1.0) <= 0.01
    first_bad = int(np.argmin(good)) if not good.all() else good.size - 1
    at_ten = float(np.interp(RADIUS_RATIO, data["radius_ratio"], data["restitution_ratio"]))
    return (
        f"Event-driven simulations of unequal balls go wrong first: at this gap they are right to one per "
        f"cent only up to R1/R2 = {float(data.radius_ratio[first_bad]):.2f}, and at R1/R2 = "
        f"{RADIUS_RATIO:g} the balls part as if ε were {at_ten:.2f} of what was specified."
    )
