"""Fig. 3: begin and end of every ball–ball contact over ε; Newton's equations and the adiabatic solution."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..column.solvers import adiabatic
from .sampling import counts_of, late_contacts, refine, sequences
from .setup import RESTITUTION_2, Setup

TITLE = "Sequence of contacts over the coefficient of restitution"
CHOICES = "The range of ε and of the time is chosen here."

LOWEST = 0.1


def compute(setup: Setup) -> xr.Dataset:
    """Rows at every 0.01 of ε from Newton's equations, adiabatic halfway between; fine outlines."""
    rows = np.round(np.arange(LOWEST, 1.005, 0.01), 10)
    column = setup.linear()
    values, _ = refine(counts_of(column, "restitution"), np.linspace(LOWEST, 1.0, 901))
    between, _ = refine(counts_of(column, "restitution", "adiabatic"), np.linspace(LOWEST, 1.0, 901))
    parts = [
        sequences("restitution", rows, setup.linear),
        sequences("restitution_adiabatic", rows[:-1] + 0.005, setup.linear, adiabatic, prefix="adiabatic_"),
        sequences("restitution_outline", values, setup.linear, prefix="outline_"),
        sequences("restitution_fine", between, setup.linear, adiabatic, prefix="fine_adiabatic_"),
    ]
    data = xr.merge(parts, join="exact")
    data["marked_restitution"] = (
        (),
        RESTITUTION_2,
        {"units": "1", "long_name": "ε of Fig. 2, the thick line"},
    )
    for prefix, name in (("outline_", "spike"), ("fine_adiabatic_", "adiabatic_spike")):
        tips = spikes(data, prefix)
        data[name] = (name, np.array(tips), {"units": "1", "long_name": "ε at the tip of a spike"})
    return data


def spikes(data: xr.Dataset, prefix: str) -> list[float]:
    """ε below which the balls meet once more after the floor contact, highest first: the spike tips."""
    name = str(data[f"{prefix}n_contacts"].dims[0])
    return [high for _, high in reversed(late_contacts(name, data, prefix)) if high < 1.0]


def meaning(data: xr.Dataset) -> str:
    """What the figure means for an event-driven simulation."""
    n = data["outline_n_contacts"].values
    return (
        f"An event-driven simulation has one contact on every line; Newton’s equations have {n.min()} to "
        f"{n.max()}, and the number changes by jumps, so that a small error of ε can change the course of "
        f"a drop altogether."
    )
