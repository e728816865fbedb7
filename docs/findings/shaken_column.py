"""A column of beads on a vibrated floor: height of the centre of mass by hard spheres and by Newton's equations.

    python docs/findings/shaken_column.py measure STORE
    python docs/findings/shaken_column.py draw STORE

After Luding, Clément, Blumen, Rajchenbach & Duran, Phys. Rev. E 49, 1634 (1994): with few beads or little dissipation
the column is fluidised, otherwise it moves as one condensed block. ``draw`` writes shaken_column.nc beside this file
and the figure of docs/shaken_column.md.
"""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

import hardlimit as hl
from hardlimit import plots
from hardlimit.measure import steady
from hardlimit.plots.style import PAGE_WIDTH, PALETTE, style
from hardlimit.support import saving

HERE = Path(__file__).parent
DATA = HERE / "shaken_column.nc"
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


def law(restitution: float, duration: float) -> hl.LinearDashpot:
    """The linear law with this duration of the contact of two beads [s]."""
    bead = hl.Ball(RADIUS, density=DENSITY)
    unit = hl.LinearDashpot(stiffness=1.0, restitution=restitution).between(bead, bead).duration(1.0)
    return hl.LinearDashpot(stiffness=float(unit / duration) ** 2, restitution=restitution)


def run(model: str, losses: float, cycles: float) -> dict[str, Any]:
    """Mean height of the centre of mass above that of the column at rest [m], with its standard error."""
    restitution, duration = 1.0 - losses / N, cycles / FREQUENCY
    options: dict[str, Any] = {"until": UNTIL, "samples": SAMPLES}
    start = column()
    if model == "newton":
        done: Any = hl.molecular_dynamics(start, law=law(restitution, duration), engine="steps", **options)
    else:
        more = {"contact_duration": duration} if model == "tc" else {}
        done = hl.event_driven(start, restitution=restitution, rule=model, **more, **options)
    series = done.series
    height = series.potential_energy / (float(start.mass.sum()) * GRAVITY) - N * RADIUS
    found = {"outcome": done.outcome, "time": float(done.time)}
    if done.outcome == "ok":
        mean = steady(height.sel(time=slice(WARM, None))).mean
        found |= {"height": mean.value, "error": mean.error}
    return found


def measure(store: Path) -> None:
    known = {tuple(one["point"]) for one in lines(store)}
    points = [("constant", x, 0.0) for x in LOSSES]
    points += [(model, x, c) for c in reversed(CYCLES) for x in LOSSES for model in ("tc", "newton")]
    for point in points:
        if point not in known:
            with store.open("a") as file:
                file.write(json.dumps({"point": point, **run(*point)}) + "\n")


def lines(store: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in store.read_text().splitlines()] if store.exists() else []


def draw(store: Path) -> None:
    """The data file and the figure."""
    found = lines(store)
    keys = ("height", "error", "time")
    dims = ("model", "tc_frequency", "loss")
    models, cycles = ("constant", "tc", "newton"), (0.0, *CYCLES)
    data = {name: np.full((len(models), len(cycles), len(LOSSES)), np.nan) for name in keys}
    for one in found:
        model, loss, cycle = one["point"]
        for name in keys:
            data[name][models.index(model), cycles.index(cycle), LOSSES.index(loss)] = one.get(name, np.nan)
    says = {
        "height": (
            "m",
            "mean height of the centre of mass above that of the column at rest; NaN after an early end",
        ),
        "error": ("m", "its standard error"),
        "time": ("s", "time that was reached"),
    }
    ds = xr.Dataset(
        {name: (dims, data[name], {"units": unit, "long_name": text}) for name, (unit, text) in says.items()},
        {"model": list(models), "tc_frequency": list(cycles), "loss": list(LOSSES)},
        {"title": f"Column of {N} beads on a vibrated floor", "source": f"hardlimit {hl.__version__}"},
    )
    saving.groups({"/": ds}, DATA)
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
        plots.save(figure, HERE.parent / "images/shaken_column.png")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("task", choices=("measure", "draw"))
    parser.add_argument("store", type=Path)
    given = parser.parse_args()
    if given.task == "measure":
        measure(given.store)
    else:
        draw(given.store)
