"""A column of beads on a vibrated floor: height of the centre of mass by hard spheres and by Newton's
equations (see driver.py).

After Luding, Clément, Blumen, Rajchenbach & Duran, Phys. Rev. E 49, 1634 (1994): with few beads or little dissipation
the column is fluidised, otherwise it moves as one condensed block.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import driver
import numpy as np
import xarray as xr
from matplotlib.figure import Figure

import hardlimit as hl
from hardlimit.measure import steady
from hardlimit.plots.style import PAGE_WIDTH, PALETTE, style

N, RADIUS, DENSITY, GRAVITY = 10, 1e-3, 2500.0, 9.81
AMPLITUDE, FREQUENCY = 1e-3, 50.0  #: of the floor: Aω² = 10 g
LOSSES = (0.1, 0.2, 0.4, 0.7, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0)  #: N(1 − ε)
CYCLES = (1e-3, 4e-3, 1.6e-2)  #: t_c times the frequency, of a contact between two beads
UNTIL, WARM = 8.0, 0.8  #: [s]
SAMPLES = 7919  #: a prime number, so that samples are at all phases of the floor


def column() -> hl.ParticleSystem:
    """Disks above each other: all contacts are head-on, so that the motion is along the last axis."""
    heights = RADIUS * (1.0 + 2.2 * np.arange(N))
    positions = np.column_stack([np.full(N, 3.0 * RADIUS), heights + 2e-4])
    floor = hl.MovingWall(AMPLITUDE, FREQUENCY)
    return hl.ParticleSystem(
        positions, np.zeros((N, 2)), RADIUS, density=DENSITY, box=[6.0 * RADIUS, 0.4], gravity=GRAVITY,
        boundary=["periodic", "wall"], walls={"y-": floor},
    )  # fmt: skip


def points(_: int) -> Iterator[driver.Point]:
    """The rule of constant ε does not depend on t_c."""
    yield from (("constant", 0.0, loss) for loss in LOSSES)
    for cycles in reversed(CYCLES):
        yield from ((model, cycles, loss) for loss in LOSSES for model in ("tc", "newton"))


def run(point: driver.Point, _: int) -> dict[str, float]:
    """Mean height of the centre of mass above that of the column at rest [m], with its standard error."""
    model, cycles, loss = point
    restitution, duration = 1.0 - loss / N, cycles / FREQUENCY
    options: dict[str, Any] = {"until": UNTIL, "samples": SAMPLES}
    start = column()
    if model == "newton":
        law = driver.linear_law(restitution, hl.Ball(RADIUS, density=DENSITY), duration)
        result: Any = hl.molecular_dynamics(start, law=law, engine="steps", **options)
    else:
        more = {"contact_duration": duration} if model == "tc" else {}
        result = hl.event_driven(start, restitution=restitution, rule=model, **more, **options)
    if result.outcome != "ok":
        return {"time": float(result.time)}
    height = result.series.potential_energy / (float(start.mass.sum()) * GRAVITY) - N * RADIUS
    mean = steady(height.sel(time=slice(WARM, None))).mean
    return {"time": float(result.time), "height": mean.value, "error": mean.error}


def draw(ds: xr.Dataset) -> dict[str, Figure]:
    scale = (2.0 * math.pi * AMPLITUDE * FREQUENCY) ** 2 / GRAVITY
    with style():
        figure = Figure(figsize=(PAGE_WIDTH, 3.6), layout="constrained")
        for ax, cycle in zip(figure.subplots(1, len(CYCLES), sharey=True), CYCLES, strict=True):
            for model, at, look in (
                ("newton", cycle, {"color": "black", "marker": "o"}),
                ("tc", cycle, {"color": PALETTE["green"], "marker": "s", "mfc": "white"}),
                ("constant", 0.0, {"color": PALETTE["vermillion"], "marker": "^"}),
            ):
                here = ds.sel(model=model, tc_frequency=at)
                label = {"newton": "Newton’s equations", "tc": "rule tc", "constant": "constant ε"}[model]
                ax.errorbar(
                    ds.loss, here.height / scale, here.error / scale, ms=4.5, lw=0.9, label=label, **look
                )
            ax.set(xscale="log", yscale="log", xlabel="N(1 − ε)", title=f"$t_c f$ = {cycle:g}")
        first = figure.axes[0]
        first.set_ylabel("mean height of the centre of mass\n$h\\,g/(A\\omega)^2$")
        first.legend(loc="lower left", fontsize="small")
    return {"shaken_column.png": figure}


STUDY = driver.Study(
    file=__file__,
    points=points,
    run=run,
    values={
        "height": (
            "m",
            "mean height of the centre of mass above that of the column at rest; NaN after an early end",
        ),
        "error": ("m", "its standard error"),
        "time": ("s", "time that was reached"),
    },
    axes=lambda: {"model": ("constant", "tc", "newton"), "tc_frequency": (0.0, *CYCLES), "loss": LOSSES},
    gather=lambda runs: driver.gathered(STUDY, runs).isel(replica=0),
    about={"title": f"Column of {N} beads on a vibrated floor"},
    draw=draw,
    dpi=200,
)

if __name__ == "__main__":
    driver.main(STUDY, __doc__)
