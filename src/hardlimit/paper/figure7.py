"""Fig. 7: begin and end of every contact over ε, viscoelastic spheres; inset with the geometry of Fig. 3."""

from __future__ import annotations

import numpy as np
import xarray as xr

from .sampling import counts_of, refine, sequences
from .setup import INPUT_SPEED, YOUNGS_MODULUS_INSET, Setup

TITLE = "Sequence of contacts, viscoelastic spheres"
CHOICES = (
    "ε sets A of each contact at v_in = 3 m/s, as in the paper. The ranges of ε and time are chosen here."
)

LOWEST = 0.1


def compute(setup: Setup) -> xr.Dataset:
    """Rows at every 0.01 of ε, outlines sampled finely; ``inset_`` variables belong to the inset."""
    rows = np.round(np.arange(LOWEST, 1.005, 0.01), 10)
    rows_inset = np.round(np.arange(LOWEST, 1.005, 0.02), 10)
    values, _ = refine(counts_of(setup.viscoelastic(0.7), "restitution"), np.linspace(LOWEST, 1.0, 361), 1e-7)
    inset, _ = refine(
        counts_of(setup.viscoelastic_inset(0.7), "restitution"), np.linspace(LOWEST, 1.0, 181), 1e-7
    )
    parts = [
        sequences("restitution", rows, setup.viscoelastic),
        sequences("restitution_outline", values, setup.viscoelastic, prefix="outline_"),
        sequences("restitution_inset", rows_inset, setup.viscoelastic_inset, prefix="inset_"),
        sequences("restitution_inset_outline", inset, setup.viscoelastic_inset, prefix="inset_outline_"),
    ]
    data = xr.merge(parts, join="exact")
    data["input_speed"] = ((), INPUT_SPEED, {"units": "m/s", "long_name": "speed at which ε sets A"})
    geometry = setup.viscoelastic_inset(0.7)
    length = {"units": "m", "long_name": "radius of the upper ball in the inset"}
    data["inset_radius_2"] = ((), geometry.balls[1].radius, length)
    modulus = {"units": "N/m2", "long_name": "Young's modulus in the inset"}
    data["inset_youngs_modulus"] = ((), YOUNGS_MODULUS_INSET, modulus)
    speed = setup.viscoelastic(0.7).impact_speed
    data["impact_speed"] = ((), speed, {"units": "m/s", "long_name": "speed at the floor in the drop"})
    data.attrs["choices"] = f"{CHOICES} The drop itself meets the floor at {speed:.2f} m/s."
    return data


def meaning(data: xr.Dataset) -> str:
    """What the figure means for an event-driven simulation."""
    n = int(data["outline_n_contacts"].max())
    return (
        f"A more realistic contact force does not rescue the event-driven picture: viscoelastic spheres "
        f"have up to {n} contacts in one drop, where it has one."
    )
