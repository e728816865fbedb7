"""Fig. 2: the forces on the floor and between the balls over time, at ε = 0.7."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..column.solvers import independent, newton
from .setup import Setup

TITLE = "Forces during one drop"
CHOICES = ""


def compute(setup: Setup) -> xr.Dataset:
    """F01 and F12 over time, every switch from both sides, and the five marked instants."""
    column = setup.linear()
    result = newton(column)
    table = result.contacts
    ball_ball = table["pair"].values == 1
    marks = np.concatenate([table["begin"].values, table["end"].values])
    span = float(np.nanmax(marks))
    apart = 1e-9 * span  # the force jumps at a first touch: one sample just before, one just after
    grid = np.linspace(-0.05 * span, 1.06 * span, 1600)
    times = np.unique(np.concatenate([grid, marks, marks - apart, marks + apart]))
    force = result.trajectory(times)["force"]
    seconds = {"units": "s"}
    newtons = {"units": "N"}
    return xr.Dataset(
        {
            "force_floor": (
                "time",
                force.sel(pair=0).values,
                newtons | {"long_name": "F01, floor on lower ball"},
            ),
            "force_balls": (
                "time",
                force.sel(pair=1).values,
                newtons | {"long_name": "F12, between the balls"},
            ),
            "begin": (
                "contact",
                table["begin"].values[ball_ball],
                seconds | {"long_name": "begin of a ball–ball contact"},
            ),
            "end": (
                "contact",
                table["end"].values[ball_ball],
                seconds | {"long_name": "end of a ball–ball contact"},
            ),
            "t_floor_begin": ((), 0.0, seconds | {"long_name": "t01(b), first floor touch"}),
            "t_floor_end": (
                (),
                result.t_floor_end,
                seconds | {"long_name": "t01(e), end of the floor contact"},
            ),
            "t_end": ((), result.t_end, seconds | {"long_name": "t_f, end of the sequence"}),
            "relative_velocity": (
                (),
                result.relative_velocity,
                {"units": "m/s", "long_name": "v2 − v1 at t_f"},
            ),
            "separation_velocity": (
                (),
                result.separation_velocity,
                {"units": "m/s", "long_name": "v2 − v1 once no force acts"},
            ),
            "relative_velocity_independent": (
                (),
                independent(column).relative_velocity,
                {"units": "m/s", "long_name": "v2 − v1 of the independent-collisions model"},
            ),
        },
        coords={"time": ("time", times, seconds | {"long_name": "time after the first floor touch"})},
    )


def meaning(data: xr.Dataset) -> str:
    """What the figure means for an event-driven simulation."""
    n = data.sizes["contact"]
    return (
        f"An event-driven simulation makes one ball–ball collision of this drop and parts the balls at "
        f"{float(data.relative_velocity_independent):.2f} m/s; Newton’s equations have {n} contacts, and a "
        f"relative velocity of {float(data.relative_velocity):.2f} m/s after the last."
    )
