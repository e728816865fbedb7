"""Flow map of sheared grains: where hard spheres hold, where contacts overlap in time, where the flow stops.

    python docs/findings/flow_map.py measure STORE [--replicas 2]
    python docs/findings/flow_map.py collect STORE
    python docs/findings/flow_map.py draw

The axes are those of Campbell, J. Fluid Mech. 465, 261 (2002): stiffness k/(ρ d³ γ̇²) over packing fraction. ρ is the
density of the solid and d the mean diameter. Grains are smooth spheres of ± 15 % in radius, so that they do not
crystallize, with linear springs; Campbell's had friction. ``measure`` appends one line for each run to the file STORE
and skips runs that are in it. ``collect`` gathers them in flow_map.nc beside this file; ``draw`` makes the figure and
the table of docs/sheared_gas.md from it.

Hard spheres are sheared from a random start. Newton's runs start from their last state.
"""

from __future__ import annotations

import math
import warnings
from pathlib import Path
from typing import Any, Final

import numpy as np
import xarray as xr
from driven_gas import append, command_line, lines_of
from matplotlib.figure import Figure

import hardlimit as hl
from hardlimit import plots
from hardlimit.boxes.theory import Gas
from hardlimit.fidelity_study.starts import equilibrated
from hardlimit.plots.style import PAGE_WIDTH, style
from hardlimit.support import saving

HERE = Path(__file__).parent
DATA = HERE / "flow_map.nc"
IMAGES = HERE.parent / "images"

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


def hard(phi: float, replica: int) -> tuple[dict[str, float], hl.ParticleSystem]:
    """Values of hard spheres, and their last state; above the densest random start none, and that start compressed."""
    sides = ("periodic", "lees-edwards", "periodic")
    loose = min(phi, LOOSE)
    start = hl.ParticleSystem.random(N, loose, RADII, DENSITY, DIAMETER * RATE, seed=replica, boundary=sides)
    start = equilibrated(start.replace(shear_rate=RATE), 100 + replica, collisions=1 if phi > LOOSE else 20)
    if phi > LOOSE:
        return {}, compressed(start, (loose / phi) ** (1.0 / 3.0))
    run = hl.event_driven(start, restitution=RESTITUTION, **window(phi))
    if run.outcome != "ok":
        return {}, start
    return averages(run.series), run.system


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
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hl.CompressionWarning)
        run = hl.molecular_dynamics(start, law=law, engine=engine, log=True, **window(phi))
    if run.outcome != "ok":
        return {}
    contacts = run.contacts
    mass = start.mass[contacts.first.values], start.mass[contacts.second.values]
    reduced = mass[0] * mass[1] / (mass[0] + mass[1])
    ball = hl.Ball(1e-3, mass=2.0)  # two of them have a reduced mass of 1 kg
    alone = float(law.between(ball, ball).duration(1.0)) * np.sqrt(reduced)
    ratio = (contacts.end.values - contacts.begin.values) / alone
    late = (contacts.begin.values > SHEARED / RATE) & np.isfinite(ratio)
    found = averages(run.series)
    return found | {
        "overlapped": float(contacts.overlapped.values[late].mean()),
        "duration": float(ratio[late].mean()),
        "tc_nu": found["collision_rate"] * RATE * float(alone[late].mean()),
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


# --- store ----------------------------------------------------------------------------------------------------


def measure(store: Path, replicas: int) -> None:
    known = {(one["phi"], one["stiffness"], one["replica"]) for one in lines_of(store)}
    for replica in range(replicas):
        for phi in PACKING:
            wanted = [k for k in (math.inf, *STIFFNESS) if (phi, k, replica) not in known]
            if not wanted:
                continue
            values, start = hard(phi, replica)
            for k in sorted(wanted, reverse=True):
                line = {"phi": phi, "stiffness": k, "replica": replica}
                line["values"] = values if math.isinf(k) else soft(start, phi, k)
                append(store, line)


def collect(store: Path) -> None:
    """All replicas as NetCDF; an infinite stiffness is that of hard spheres. NaN where a run ended early."""
    lines, levels = lines_of(store), [*STIFFNESS, math.inf]
    data = {
        name: np.full((len(PACKING), len(levels), 1 + max(one["replica"] for one in lines)), math.nan)
        for name in VALUES
    }
    for line in lines:
        where = PACKING.index(line["phi"]), levels.index(line["stiffness"]), line["replica"]
        for name, value in line["values"].items():
            data[name][where] = value
    dims = ("packing_fraction", "stiffness", "replica")
    found = xr.Dataset(
        {name: (dims, data[name], {"units": "1", "long_name": VALUES[name]}) for name in VALUES},
        {"packing_fraction": list(PACKING), "stiffness": ("stiffness", levels, {"long_name": "k/(ρ d³ γ̇²)"})},
        {
            "title": "Flow map of sheared smooth spheres",
            "source": f"hardlimit {hl.__version__}, docs/findings/flow_map.py",
            "n": N,
            "restitution": RESTITUTION,
        },
    )
    saving.groups({"/": found}, DATA)


# --- results --------------------------------------------------------------------------------------------------


def draw() -> None:
    with xr.open_dataset(DATA) as file:
        ds = file.load().mean("replica")
    _figure(ds)
    print("| φ | k/(ρd³γ̇²) | t_c ν | overlapping | duration | stress: Newton | error of hard spheres |")
    print("|---|---|---|---|---|---|---|")
    for phi in PACKING:
        for k in STIFFNESS:
            here = ds.sel(packing_fraction=phi, stiffness=k)
            if math.isnan(float(here.overlapped)):
                continue
            error = stress_error(ds, phi, k)
            shown = "no flow" if math.isnan(error) else f"{100.0 * error:+.0f} %".replace("-", "−")
            print(
                f"| {phi:g} | 10^{round(math.log10(k))} | {float(here.tc_nu):.2g} | "
                f"{100.0 * float(here.overlapped):.0f} % | "
                f"{float(here.duration):.2f} | {float(here.stress):.3g} | {shown} |"
            )


def stress_error(ds: xr.Dataset, phi: float, k: float) -> float:
    """Error of the shear stress of hard spheres; NaN where they do not flow."""
    hard, soft = (float(ds.stress.sel(packing_fraction=phi, stiffness=one)) for one in (math.inf, k))
    return hard / soft - 1.0


def _figure(ds: xr.Dataset) -> None:
    fraction = np.linspace(0.15, 0.49, 50)
    with style():
        figure = Figure(figsize=(PAGE_WIDTH, 3.9), layout="constrained")
        ax = figure.subplots()
        for phi in PACKING:
            for k in STIFFNESS:
                here, error = ds.sel(packing_fraction=phi, stiffness=k), stress_error(ds, phi, k)
                if math.isnan(float(here.overlapped)):
                    continue
                good = abs(error) <= TOLERANCE
                marker = "X" if math.isnan(error) else "o" if good else "s"
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
        plots.save(figure, IMAGES / "flow_map.png")


def stiffness_of(phi: float, tc_nu: float) -> float:
    """k/(ρ d³ γ̇²) at this t_c ν, by kinetic theory of hard spheres."""
    gas = Gas(1, 0.5, math.pi / 6.0, math.pi / 6.0 / phi, 3)  # units of ρ, d and γ̇
    nu = float(gas.collision_rate(gas.sheared_temperature(1.0, RESTITUTION)))
    ball = hl.Ball(0.5, mass=gas.mass)
    unit = hl.LinearDashpot(stiffness=1.0, restitution=RESTITUTION).between(ball, ball).duration(1.0)
    return float(unit * nu / tc_nu) ** 2


if __name__ == "__main__":
    command_line(__doc__, "flow_map.jsonl", 2, measure, collect, draw)
