"""Measurement of the steady state of a heated gas: hard spheres beside Newton's equations at equal power
(see driver.py).

A run starts from an elastic equilibrium at the temperature that kinetic theory predicts, is heated by random kicks for
25 collisions per particle, and is then measured for 120. Temperature and power fluctuate together. Measured are
therefore the dissipation over T^(3/2), the pressure over T and the collision rate over √T, whose means fluctuate
little. At equal power, the ratio of temperatures is that of the dissipations over T^(3/2) to the power −2/3.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import driven_gas
import driver
import numpy as np
import xarray as xr
from driven_gas import BERZI_JENKINS, DENSITY, RADIUS, RESTITUTION, TEMPERATURE, real_tc_nu
from driver import Point, ratio
from matplotlib.figure import Figure

import hardlimit as hl
from hardlimit.boxes import theory
from hardlimit.boxes.error_law import fluid
from hardlimit.fidelity_study.starts import equilibrated
from hardlimit.plots.style import PAGE_WIDTH, PALETTE, style

N = 1000
#: t_c ν by Enskog's theory at this temperature. Softer particles would be compressed too much.
TC_NU = {0.1: (0.01, 0.03, 0.1), 0.3: (0.01, 0.03, 0.1, 0.3), 0.5: (0.01, 0.03, 0.1, 0.3)}
HEATED, MEASURED = 25, 120  #: collisions per particle before and in the window
KICKS = 0.1 * math.sqrt(1.1)  #: interval over the mean free time; samples are at other phases
SAMPLES_PER_COLLISION = 3
FEWER = 3  #: replicas of the rules tc and soft
#: Values of a run: meaning.
VALUES = {
    "dissipation": "dissipation over T^(3/2), over that of Enskog's theory",
    "pressure": "pressure over nmT",
    "collision_rate": "collision rate over √T, over Enskog's",
    "temperature": "mean temperature over that of kinetic theory",
    "power": "dissipation over the power of the kicks",
    "largest_compression": "largest compression of a contact over the radius",
}


def points(replica: int) -> Iterator[Point]:
    """Hard spheres with a constant ε do not depend on t_c ν."""
    for phi, values in TC_NU.items():
        for epsilon in RESTITUTION:
            yield phi, epsilon, "constant", None
            for tc_nu in values:
                for model in ("newton", "tc", "soft")[: 3 if replica < FEWER else 1]:
                    yield phi, epsilon, model, tc_nu


def run(point: Point, replica: int) -> dict[str, float]:
    """The values of one run."""
    phi, epsilon, model, tc_nu = point
    start = hl.ParticleSystem.random(N, phi, RADIUS, DENSITY, math.sqrt(3.0 * TEMPERATURE), seed=replica)
    gas = theory.gas(start.replace(gravity=0.0)) if phi < 0.49 else _dense(start)
    rate = float(gas.collision_rate(TEMPERATURE))
    unit_power = gas.heated_temperature(1.0, epsilon)
    power = (TEMPERATURE / unit_power) ** 1.5
    start = equilibrated(start, 1000 + replica, collisions=200 if phi > 0.4 else 30)
    seed = 10_000 * replica + round(1e3 * (tc_nu or 0.0)) + 17 * len(model)
    start = start.replace(thermostat=hl.RandomKicks(power, KICKS / rate, seed=seed))
    law = driven_gas.law(epsilon, start, tc_nu / rate) if tc_nu else None
    total = HEATED + MEASURED
    options: dict[str, Any] = {"until": total / rate, "samples": total * SAMPLES_PER_COLLISION}
    if model == "newton":
        result: Any = hl.molecular_dynamics(start, law=law, engine="auto", **options)
    elif model == "soft":
        result = hl.event_driven(start, law=law, rule="soft", **options)
    else:
        more = {"rule": "tc", "contact_duration": tc_nu / rate} if model == "tc" else {}
        result = hl.event_driven(start, restitution=epsilon, **more, **options)
    if result.outcome != "ok":
        return {}
    series = result.series.isel(time=slice(HEATED * SAMPLES_PER_COLLISION, None))
    t = series.granular_temperature.values
    lost = series.dissipated_energy.values
    duration = float(series.time[-1] - series.time[0])
    dissipation = (lost[-1] - lost[0]) / duration
    enskog = 0.5 * (1.0 - epsilon**2) * rate * float(start.mass.sum()) * TEMPERATURE
    ideal = gas.n * gas.mass / gas.volume
    return {
        "dissipation": dissipation / float(np.mean(t**1.5)) * TEMPERATURE**1.5 / enskog,
        "pressure": float(series.pressure[1:].mean()) / (ideal * float(t.mean())),
        "collision_rate": float(series.collision_rate[1:].mean())
        / (rate * float(np.mean(np.sqrt(t / TEMPERATURE)))),
        "temperature": float(t.mean()) / TEMPERATURE,
        "power": dissipation / power,
        "largest_compression": float(getattr(result, "largest_compression", 0.0) or 0.0),
    }


def _dense(system: hl.ParticleSystem) -> theory.Gas:
    """The gas of a packing fraction at which spheres may freeze; random ones stay fluid in such a time."""
    return theory.Gas(system.n, RADIUS, float(system.mass[0]), system.domain.volume, 3)


# --- results --------------------------------------------------------------------------------------------------


def temperature_error(ds: xr.Dataset, model: str) -> tuple[float, float]:
    """Error of the temperature of a rule at equal power; ``ds`` at one φ, ε and t_c ν."""
    return ratio(ds.dissipation.sel(model=model), ds.dissipation.sel(model="newton"), -2.0 / 3.0)


def at_equal_temperature(phi: float, epsilon: float) -> dict[str, float]:
    """Errors over t_c ν of pressure and collision rate at equal kinetic temperature, theory for ε → 1."""
    gas = fluid(3, phi)
    chi_slope = gas.growth * gas.contact_value / (3.0 * phi)  # dχ/dφ
    collisional = 2.0 * (1.0 + epsilon)
    z = 1.0 + collisional * phi * gas.contact_value
    return {
        "pressure": collisional * (gas.contact_value + phi * chi_slope) / (8.0 * gas.contact_value * z),
        "collision_rate": (gas.slope + gas.growth) / gas.density,
    }


def tables(ds: xr.Dataset) -> str:
    errors, equal = [], []
    for phi, epsilon, tc_nu, here in driven_gas.cases(TC_NU, ds):
        x, cells = real_tc_nu(here, tc_nu), []
        for rule in ("constant", "tc", "soft"):
            law = hl.error_law(packing_fraction=phi, restitution=epsilon, rule=rule).heated_error(x)
            cells.append(driven_gas.percent(*temperature_error(here, rule), law, 2))
        cells.insert(1, f"{100.0 * (1.0 + BERZI_JENKINS * x) ** (-2.0 / 3.0) - 100.0:.2f}")
        errors.append((phi, epsilon, tc_nu, *cells))
        if tc_nu == TC_NU[phi][-1]:
            cells = []
            for name, slope in at_equal_temperature(phi, epsilon).items():
                value, error = ratio(here[name].sel(model="constant"), here[name].sel(model="newton"))
                cells.append(f"{value / x:.3f}±{error / x:.3f} / {slope:.3f}")
            equal.append((phi, epsilon, *cells))
    head = "constant: measured / law | Berzi & Jenkins | tc: measured / law | soft: measured / law"
    temperatures = driver.table(f"φ | ε | t_c ν | {head}", errors)
    head = "pressure: measured / theory | collision rate: measured / theory"
    return f"{temperatures}\n\n{driver.table(f'φ | ε | {head}', equal)}"


def draw(ds: xr.Dataset) -> dict[str, Figure]:
    colors = {0.9: PALETTE["blue"], 0.7: PALETTE["vermillion"]}
    with style():
        figure = Figure(figsize=(PAGE_WIDTH, 5.2), layout="constrained")
        axes = figure.subplots(2, 3, sharex="col", sharey="row")
        for column, (phi, values) in enumerate(TC_NU.items()):
            top, below = axes[:, column]
            x = np.geomspace(0.008, 1.3 * values[-1], 60)
            for epsilon, color in colors.items():
                law = hl.error_law(packing_fraction=phi, restitution=epsilon)
                top.loglog(x, [-100.0 * law.heated_error(at) for at in x], color=color)
                below.loglog(x, 100.0 * at_equal_temperature(phi, epsilon)["pressure"] * x, color=color)
                for tc_nu in values:
                    here = ds.sel(packing_fraction=phi, restitution=epsilon, tc_nu=tc_nu)
                    at = real_tc_nu(here, tc_nu) * (1.05 if epsilon == 0.9 else 0.95)
                    pressure = here.pressure.sel(model="constant"), here.pressure.sel(model="newton")
                    label = f"ε = {epsilon:g}" if tc_nu == values[0] else None
                    for ax, sign, (value, error) in (
                        (top, -100.0, temperature_error(here, "constant")),
                        (below, 100.0, ratio(*pressure)),
                    ):
                        ax.errorbar(at, sign * value, 100.0 * error, fmt="o", ms=4, color=color, label=label)
            top.loglog(x, 100.0 * (1.0 - (1.0 + BERZI_JENKINS * x) ** (-2.0 / 3.0)), "k--", lw=1.0)
            below.loglog(x, 100.0 * BERZI_JENKINS * x, "k--", lw=1.0, label="Berzi & Jenkins (2015)")
            top.set_title(f"φ = {phi:g}")
            below.set_xlabel(r"$t_c\nu$")
        axes[0, 0].set(ylim=(0.03, 12.0), ylabel="too cold by [%]")
        axes[1, 0].set(ylim=(0.03, 12.0), ylabel="pressure too high\nat equal temperature [%]")
        axes[1, 0].legend(loc="upper left", fontsize="small")
    return {"heated_gas.png": figure}


STUDY = driven_gas.study(
    VALUES,
    {"title": "Steady states of a heated gas of hard spheres and of soft ones", "n": N},
    file=__file__,
    points=points,
    run=run,
    replicas=8,
    axes=lambda: driven_gas.axes(TC_NU, ("newton", "constant", "tc", "soft")),
    draw=draw,
    tables=tables,
)

if __name__ == "__main__":
    driver.main(STUDY, __doc__)
