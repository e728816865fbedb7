"""Fig. 8: begin and end of every contact over the dissipative time A, the same material for both contacts."""

from __future__ import annotations

import numpy as np
import xarray as xr

from .sampling import counts_of, refine, sequences
from .setup import INPUT_SPEED, Setup

TITLE = "Sequence of contacts, one material"
CHOICES = "The range of A, 0.1 to 100 µs (logarithmic, upside down as in Fig. 7), is chosen here."

TIMES = (1e-7, 1e-4)


def compute(setup: Setup) -> xr.Dataset:
    """Rows at equal factors of A, fine outlines; the ε of both contacts at 3 m/s for orientation."""
    rows = np.geomspace(*TIMES, 91)
    values, _ = refine(
        counts_of(setup.same_material(1e-6), "dissipative_time"),
        np.geomspace(*TIMES, 361),
        1e-7,
        logarithmic=True,
    )
    data = xr.merge(
        [
            sequences("dissipative_time", rows, setup.same_material),
            sequences("dissipative_time_outline", values, setup.same_material, prefix="outline_"),
        ],
        join="exact",
    )
    contacts = [setup.same_material(float(a)).contacts for a in rows]
    for i, name in enumerate(("floor", "balls")):
        epsilon = np.array([pair[i].restitution(INPUT_SPEED) for pair in contacts])
        text = {"units": "1", "long_name": f"restitution of the {name} contact at {INPUT_SPEED:g} m/s"}
        data[f"restitution_{name}"] = ("dissipative_time", epsilon, text)
    data["input_speed"] = ((), INPUT_SPEED, {"units": "m/s", "long_name": "speed to which the ε belong"})
    for name in ("dissipative_time", "dissipative_time_outline"):
        data[name].attrs.update(units="s", long_name="dissipative time A")
    return data


def meaning(data: xr.Dataset) -> str:
    """What the figure means for an event-driven simulation."""
    n = int(data["outline_n_contacts"].max())
    return (
        f"Giving both contacts one material instead of one ε changes little: up to {n} contacts in one "
        f"drop, so the failure of the event-driven picture does not hinge on how dissipation is specified."
    )
