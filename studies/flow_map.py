"""Flow map of sheared grains: where hard spheres hold, where contacts overlap in time, where the flow
stops (see driver.py).

The axes are those of Campbell, J. Fluid Mech. 465, 261 (2002): stiffness k/(ρ d³ γ̇²) over packing fraction. ρ is the
density of the solid and d the mean diameter. Grains are smooth spheres of ± 15 % in radius, so that they do not
crystallize, with linear springs; Campbell's had friction.

Hard spheres are sheared from a random start. Newton's runs start from their last state.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from typing import Any, Final

import driver
import numpy as np
import xarray as xr
from matplotlib.figure import Figure

import hardlimit as hl
from hardlimit.boxes.theory import Gas
from hardlimit.fidelity_study.starts import equilibrated
from hardlimit.plots.style import PAGE_WIDTH, style

N = 300
RADII, DENSITY = (0.85e-3, 1.15e-3), 2500.0  #: [m], [kg/m³]
DIAMETER = 2e-3  #: mean [m]
RATE = 100.0  #: γ̇ [1/s]
RESTITUTION = 0.7
LOOSE = 0.62  #: densest random start; denser ones are compressed and have no hard spheres
CROWDED = 0.57  #: above it contacts last, and Newton's equations are solved by steps
STIFFNESS = (1e3, 1e4, 1e5, 1e6)  #: k/(ρ d³ γ̇²)
SHEARED = 4.0  #: strain before the window
#: Strain in the window. Thin gases collide less often in a strain and fluctuate more.
MEASURED = {0.2: 200.0, 0.35: 100.0, 0.5: 40.0, 0.55: 12.0, 0.6: 12.0, 0.66: 12.0}
PACKING = tuple(MEASURED)
TOLERANCE: Final = 0.05  #: of the shear stress
#: Values of a run: meaning.
VALUES = {
    "stress": "−P_xy over ρ d² γ̇²",
    "pressure": "p over ρ d² γ̇²",
    "temperature": "T over d² γ̇²",
    "collision_rate": "collisions of one particle per strain",
    "overlapped": "share of the contacts during which another contact of a partner existed",
    "duration": "mean duration of a contact over that of two grains alone",
    "tc_nu": "t_c ν, duration of the contact of two grains times the collision rate",
}


def points(_: int) -> Iterator[driver.Point]:
    """An infinite stiffness is that of hard spheres."""
    for phi in PACKING:
        for stiffness in (math.inf, *reversed(STIFFNESS)):
            yield phi, stiffness


def run(point: driver.Point, replica: int) -> dict[str, float]:
    phi, stiffness = point
    values, start = hard(phi, replica)
    return values if math.isinf(stiffness) else soft(start, phi, stiffness)


@lru_cache(maxsize=1)
def hard(phi: float, replica: int) -> tuple[dict[str, float], hl.ParticleSystem]:
    """Values of hard spheres, and their last state; above the densest random start none, and that start compressed."""
    sides = ("periodic", "lees-edwards", "periodic")
    loose = min(phi, LOOSE)
    start = hl.ParticleSystem.random(N, loose, RADII, DENSITY, DIAMETER * RATE, seed=replica, boundary=sides)
    start = equilibrated(start.replace(shear_rate=RATE), 100 + replica, collisions=1 if phi > LOOSE else 20)
    if phi > LOOSE:
        return {}, compressed(start, (loose / phi) ** (1.0 / 3.0))
    result = hl.event_driven(start, restitution=RESTITUTION, **window(phi))
    if result.outcome != "ok":
        return {}, start
    return averages(result.series), result.system


def window(phi: float) -> dict[str, Any]:
    """End and number of samples of a run."""
    strain = SHEARED + MEASURED[phi]
    return {"until": strain / RATE, "samples": round(40 * strain)}


def compressed(system: hl.ParticleSystem, scale: float) -> hl.ParticleSystem:
    """The system in a box smaller by this factor, in which the spheres overlap."""
    return hl.ParticleSystem(
        system.positions * scale,
        system.velocities,
        system.radius,
        mass=system.mass,
        box=system.box * scale,
        boundary=system.boundary,
        shear_rate=system.shear_rate,
        shear_displacement=system.shear_displacement * scale,
        allowed_overlap=0.1,
    )


def soft(start: hl.ParticleSystem, phi: float, stiffness: float) -> dict[str, float]:
    """Values under Newton's equations."""
    k = stiffness * DENSITY * DIAMETER**3 * RATE**2
    law = hl.LinearDashpot(stiffness=k, restitution=RESTITUTION)
    engine = "steps" if phi > CROWDED else "auto"
    result = hl.molecular_dynamics(start, law=law, engine=engine, log=True, **window(phi))
    if result.outcome != "ok":
        return {}
    contacts = result.contacts
    mass = start.mass[contacts.first.values], start.mass[contacts.second.values]
    reduced = mass[0] * mass[1] / (mass[0] + mass[1])
    ball = hl.Ball(1e-3, mass=2.0)  # two of them have a reduced mass of 1 kg
    alone = float(law.between(ball, ball).duration(1.0)) * np.sqrt(reduced)
    ratio = (contacts.end.values - contacts.begin.values) / alone
    late = (contacts.begin.values > SHEARED / RATE) & np.isfinite(ratio)
    means = averages(result.series)
    return means | {
        "overlapped": float(contacts.overlapped.values[late].mean()),
        "duration": float(ratio[late].mean()),
        "tc_nu": means["collision_rate"] * RATE * float(alone[late].mean()),
    }


def averages(series: xr.Dataset) -> dict[str, float]:
    """Means over the window, in units of ρ, d and γ̇."""
    late = series.isel(time=slice(round(40 * SHEARED) + 1, None)).mean("time")
    unit = DENSITY * DIAMETER**2 * RATE**2
    return {
        "stress": -float(late.pressure_tensor.sel(component="xy")) / unit,
        "pressure": float(late.pressure) / unit,
        "temperature": float(late.granular_temperature) / (DIAMETER * RATE) ** 2,
        "collision_rate": float(late.collision_rate) / RATE,
    }


# --- results --------------------------------------------------------------------------------------------------


def tables(ds: xr.Dataset) -> str:
    rows, means = [], ds.mean("replica")
    for phi, k, here in cases(means):
        error = stress_error(means, phi, k)
        rows.append(
            (
                f"{phi:g}",
                f"10^{round(math.log10(k))}",
                f"{float(here.tc_nu):.2g}",
                f"{100.0 * float(here.overlapped):.0f} %",
                f"{float(here.duration):.2f}",
                f"{float(here.stress):.3g}",
                "no flow" if math.isnan(error) else f"{100.0 * error:+.0f} %",
            )
        )
    head = "φ | k/(ρd³γ̇²) | t_c ν | overlapping | duration | stress: Newton | error of hard spheres"
    return driver.table(head, rows)


def cases(means: xr.Dataset) -> Iterator[tuple[float, float, xr.Dataset]]:
    """φ, stiffness and the values there, where Newton's run did not end early."""
    for phi in PACKING:
        for k in STIFFNESS:
            here = means.sel(packing_fraction=phi, stiffness=k)
            if not math.isnan(float(here.overlapped)):
                yield phi, k, here


def stress_error(ds: xr.Dataset, phi: float, k: float) -> float:
    """Error of the shear stress of hard spheres; NaN where they do not flow."""
    stress = ds.stress.sel(packing_fraction=phi)
    return float(stress.sel(stiffness=math.inf) / stress.sel(stiffness=k)) - 1.0


def draw(ds: xr.Dataset) -> dict[str, Figure]:
    fraction, means = np.linspace(0.15, 0.49, 50), ds.mean("replica")
    with style():
        figure = Figure(figsize=(PAGE_WIDTH, 3.9), layout="constrained")
        ax = figure.subplots()
        for phi, k, here in cases(means):
            error = stress_error(means, phi, k)
            marker = "X" if math.isnan(error) else "o" if abs(error) <= TOLERANCE else "s"
            shade = ax.scatter(
                phi, k, c=float(here.overlapped), vmin=0.0, vmax=1.0, cmap="viridis", marker=marker, s=90,
                edgecolors="k", linewidths=0.6,
            )  # fmt: skip
            text = "" if math.isnan(error) else f"{100.0 * error:+.0f} %".replace("-", "−")
            ax.annotate(text, (phi, k), (8, 5), textcoords="offset points", fontsize=7)
        for tc_nu in (0.01, 0.1):
            ax.plot(fraction, [stiffness_of(phi, tc_nu) for phi in fraction], "k:", lw=1.0)
            ax.annotate(rf"$t_c\nu$ = {tc_nu:g}", (0.16, 1.5 * stiffness_of(0.16, tc_nu)), fontsize=7)
        ax.axvspan(0.64, 0.7, color="0.88", zorder=0)
        ax.annotate("hard spheres\ncannot flow", (0.67, 3e5), ha="center", va="center", fontsize=7)
        ax.set(
            xlabel="packing fraction φ",
            ylabel=r"$k/(\rho d^3\dot\gamma^2)$",
            yscale="log",
            xlim=(0.15, 0.7),
            ylim=(5e2, 3e6),
        )
        figure.colorbar(shade, ax=ax, label="share of contacts that overlap another one")
    return {"flow_map.png": figure}


def stiffness_of(phi: float, tc_nu: float) -> float:
    """k/(ρ d³ γ̇²) at this t_c ν, by kinetic theory of hard spheres."""
    gas = Gas(1, 0.5, math.pi / 6.0, math.pi / 6.0 / phi, 3)  # units of ρ, d and γ̇
    nu = float(gas.collision_rate(gas.sheared_temperature(1.0, RESTITUTION)))
    ball = hl.Ball(0.5, mass=gas.mass)
    unit = hl.LinearDashpot(stiffness=1.0, restitution=RESTITUTION).between(ball, ball).duration(1.0)
    return float(unit * nu / tc_nu) ** 2


STUDY = driver.Study(
    file=__file__,
    points=points,
    run=run,
    replicas=2,
    values={name: ("1", text) for name, text in VALUES.items()},
    axes=lambda: {"packing_fraction": PACKING, "stiffness": (*STIFFNESS, math.inf)},
    about={"title": "Flow map of sheared smooth spheres", "n": N, "restitution": RESTITUTION},
    draw=draw,
    tables=tables,
    dpi=200,
)

if __name__ == "__main__":
    driver.main(STUDY, __doc__)
