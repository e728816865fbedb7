"""Measurement of dense flow: stress ratio and packing fraction of sheared grains with friction over the inertial
number I = γ̇ d √(ρ/p) (see driver.py).

300 spheres of diameter 1 and mass 1, k_t = 2/7 k, under Lees–Edwards shear at constant volume, at two stiffnesses. Down
a rough plane at the angle θ a deep layer flows with the I at which the stress ratio is tan θ.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from typing import Any, Final

import driver
import numpy as np
import xarray as xr
from driver import Point
from matplotlib.figure import Figure

import hardlimit as hl
from hardlimit.checking import flows
from hardlimit.plots.style import PAGE_WIDTH, PALETTE, style

DENSITY: Final = 6.0 / math.pi  #: a grain has the mass 1
N: Final = 300
#: Packing fraction in slow flow by μ, roughly, and how much looser the boxes are.
SLOW: Final = {0.0: 0.64, 0.05: 0.63, 0.1: 0.62, 0.2: 0.61, 0.3: 0.602, 0.5: 0.589, 0.7: 0.583, 1.0: 0.577}
LOOSER: Final = (0.1, 0.06, 0.035, 0.02, 0.01, 0.005)
RATE_OF: Final = 0.3  #: fall of the packing fraction over I, roughly
RESTITUTIONS: Final = (0.5, 0.9)
STIFFNESSES: Final = (1e3, 1e4)  #: stiffness numbers of flows, roughly
#: The slowest flows that are run, by restitution and stiffness in each replica.
SLOWEST: Final = (
    {(0.5, 1e3): 0.005, (0.9, 1e3): 0.01, (0.5, 1e4): 0.02, (0.9, 1e4): 0.02},
    {(0.5, 1e3): 0.01, (0.9, 1e3): 0.02},
)
SMOOTHER: Final = (0.0, 0.05)  #: at these μ, for which check has no number, only faster flows, once
STRAINS, EVERY = (1.5, 5.0), 0.1
VALUES: Final = {
    "packing_fraction": ("1", "packing fraction"),
    "inertial_number": ("1", "inertial number"),
    "stress_ratio": ("1", "shear stress over pressure"),
    "stress_error": ("1", "standard error of the stress ratio, from four parts of the strain"),
    "kappa": ("1", "stiffness number"),
}


def points(replica: int) -> Iterator[Point]:
    for looser in LOOSER:
        for mu in SLOW:
            for (restitution, stiffness), slowest in SLOWEST[replica].items():
                if looser >= (max(slowest, 0.02 + replica) if mu in SMOOTHER else slowest):
                    yield mu, restitution, stiffness, looser


def run(point: Point, replica: int) -> dict[str, Any]:
    """Means over the strain in steady shear; nothing if the run ended early."""
    mu, restitution, stiffness, looser = point
    phi = SLOW[mu] - looser
    rate = looser / RATE_OF * math.sqrt(1.0 / (stiffness * DENSITY))
    start = hl.ParticleSystem.random(
        N, phi, 0.5, DENSITY, 0.0, seed=replica,
        boundary=("periodic", "lees-edwards", "periodic"), shear_rate=rate,
    )  # fmt: skip
    law = hl.LinearDashpot(stiffness=1.0, restitution=restitution, friction=hl.Friction(mu))
    flow = hl.molecular_dynamics(
        start, law=law, until=sum(STRAINS) / rate, samples=round(sum(STRAINS) / EVERY),
        engine="steps", restitution_error=0.05, threads=1,
    )  # fmt: skip
    if flow.outcome != "ok":
        return {}
    first = round(STRAINS[0] / EVERY) + 1
    pressure = flow.series.pressure.values[first:]
    stress = flow.series.shear_stress.values[first:]
    quarters = zip(np.array_split(stress, 4), np.array_split(pressure, 4), strict=True)
    parts = [np.mean(shear) / np.mean(normal) for shear, normal in quarters]
    mean = float(pressure.mean())
    return {
        "packing_fraction": phi,
        "inertial_number": rate * math.sqrt(DENSITY / mean),
        "stress_ratio": float(stress.mean()) / mean,
        "stress_error": float(np.std(parts, ddof=1)) / 2.0,
        "kappa": 1.0 / mean,
    }


def draw(data: xr.Dataset) -> Mapping[str, Figure]:
    """The stress ratio over I, beside that by which check judges slopes, with its band."""
    speeds = np.geomspace(0.006, flows.FASTEST, 100)
    with style():
        figure = Figure(figsize=(PAGE_WIDTH, 4.2), layout="constrained")
        panels = figure.subplots(2, 3, sharex=True, sharey=True)
        for axes, mu in zip(panels.flat, flows.SLOPES, strict=True):
            line = np.array([flows.stress_ratio(speed, mu) for speed in speeds])
            error = flows.SLOPES[mu][1]
            axes.fill_between(speeds, line - error, line + error, color="0.9")
            axes.plot(speeds, line, color="k", lw=0.8)
            for colour, stiffness in zip(PALETTE.values(), STIFFNESSES, strict=False):
                for restitution, marker in zip(RESTITUTIONS, "os", strict=True):
                    rows = data.sel(friction=mu, restitution=restitution, stiffness=stiffness)
                    kappa = f"10^{round(math.log10(stiffness))}"
                    axes.errorbar(
                        rows.inertial_number.values.ravel(), rows.stress_ratio.values.ravel(),
                        rows.stress_error.values.ravel(), fmt=marker, ms=3, lw=0.8, color=colour,
                        mfc="white" if marker == "s" else None,
                        label=rf"ε = {restitution:g}, $\kappa_p \approx {kappa}$",
                    )  # fmt: skip
            axes.set(xscale="log", title=f"μ = {mu:g}")
        panels[0, 0].legend()
        figure.supxlabel("inertial number $I$")
        figure.supylabel("shear stress/pressure = tan θ")
    return {"dense_flow.png": figure}


def tables(data: xr.Dataset) -> str:
    """One row a setting: means over the replicas."""
    mean = data.mean("replica")
    rows = []
    for mu in mean.friction.values:
        for restitution in mean.restitution.values:
            for stiffness, looser in itertools.product(mean.stiffness.values, mean.looser.values[::-1]):
                at = mean.sel(friction=mu, restitution=restitution, stiffness=stiffness, looser=looser)
                if np.isfinite(at.inertial_number):
                    values = [
                        f"{float(at[name]):.3f}"
                        for name in ("packing_fraction", "inertial_number", "stress_ratio")
                    ]
                    rows.append([mu, restitution, *values, f"{float(at.kappa):.0f}"])
    return driver.table("μ | ε | φ | I | stress/p | κ_p", rows)


STUDY: Final = driver.Study(
    file=__file__,
    points=points,
    run=run,
    replicas=2,
    values=VALUES,
    draw=draw,
    tables=tables,
    axes=lambda: {
        "friction": list(SLOW),
        "restitution": list(RESTITUTIONS),
        "stiffness": list(STIFFNESSES),
        "looser": list(LOOSER),
    },
)

if __name__ == "__main__":
    driver.main(STUDY, __doc__)
