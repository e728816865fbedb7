"""Measurement of the steady state of a sheared gas: hard spheres beside Newton's equations at equal shear rate
(see driver.py).

A run starts from an elastic equilibrium at the temperature that kinetic theory predicts, with the mean flow of the
shear. It is sheared for 60 collisions per particle and then measured for 1000. In this time the work of the shear
stress equals the dissipation, whose mean fluctuates less; the viscosity is that dissipation over the square of the
shear rate.
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
from driver import Point
from matplotlib.figure import Figure

import hardlimit as hl
from hardlimit.boxes import theory
from hardlimit.fidelity_study.starts import equilibrated
from hardlimit.plots.style import PAGE_WIDTH, PALETTE, style

N = 500
#: t_c ν by Enskog's theory at this temperature. Softer particles would be compressed too much.
TC_NU = {0.1: (0.03, 0.1), 0.3: (0.03, 0.1, 0.3), 0.45: (0.03, 0.1, 0.3)}
SHEARED, MEASURED = 60, 1000  #: collisions per particle before and in the window
LAYERS = 6  #: across the gradient, for the profile of the flow
#: Values of a run: meaning.
VALUES = {
    "temperature": "mean temperature over that of kinetic theory (Lun et al. 1984)",
    "dissipation": "dissipation over T^(3/2), over that of Enskog's theory",
    "viscosity": "dissipation over the square of the shear rate and √T, over that of Lun et al. (1984)",
    "balance": "work of the shear stress over the dissipation",
    "shear_stress": "−P_xy over p",
    "first_normal": "(P_xx − P_yy) over p",
    "second_normal": "(P_yy − P_zz) over p",
    "pressure": "pressure over nmT",
    "collision_rate": "collision rate over √T, over Enskog's",
    "profile": "variance of the mean velocity in layers about the linear profile, over that of thermal noise",
    "largest_compression": "largest compression of a contact over the radius",
}
SIDES = ("periodic", "lees-edwards", "periodic")


def points(_: int) -> Iterator[Point]:
    """Hard spheres with a constant ε do not depend on t_c ν."""
    for phi, values in TC_NU.items():
        for epsilon in RESTITUTION:
            yield phi, epsilon, "constant", None
            for tc_nu in values:
                yield phi, epsilon, "newton", tc_nu


def run(point: Point, replica: int) -> dict[str, float]:
    """The values of one run; none if it ended early."""
    phi, epsilon, model, tc_nu = point
    start = hl.ParticleSystem.random(
        N, phi, RADIUS, DENSITY, math.sqrt(3.0 * TEMPERATURE), seed=replica, boundary=SIDES
    )
    gas = theory.Gas(N, RADIUS, float(start.mass[0]), start.domain.volume, 3)
    enskog = float(gas.collision_rate(TEMPERATURE))
    rate = math.sqrt(TEMPERATURE / gas.sheared_temperature(1.0, epsilon))
    start = equilibrated(start.replace(shear_rate=rate), 1000 + replica, collisions=100)
    total = SHEARED + MEASURED
    options: dict[str, Any] = {"until": total / enskog, "samples": 4 * total}
    if model == "newton":
        law = driven_gas.law(epsilon, start, tc_nu / enskog)
        result: Any = hl.molecular_dynamics(start, law=law, engine="events", **options)
    else:
        result = hl.event_driven(start, restitution=epsilon, **options)
    if result.outcome != "ok":
        return {}
    series = result.series.isel(time=slice(4 * SHEARED, None))
    t = series.granular_temperature.values
    duration = float(series.time[-1] - series.time[0])
    lost, work = (
        float(series[name][-1] - series[name][0]) / duration for name in ("dissipated_energy", "shear_work")
    )
    tensor = series.pressure_tensor[1:].mean("time")
    xx, yy, zz, xy = (float(tensor.sel(component=name)) for name in ("xx", "yy", "zz", "xy"))
    pressure = float(series.pressure[1:].mean())
    by_theory = 0.5 * (1.0 - epsilon**2) * enskog * float(start.mass.sum()) * TEMPERATURE
    roots = float(np.mean(np.sqrt(t / TEMPERATURE)))
    return {
        "temperature": float(t.mean()) / TEMPERATURE,
        "dissipation": lost / float(np.mean((t / TEMPERATURE) ** 1.5)) / by_theory,
        "viscosity": lost / roots / by_theory,
        "balance": work / lost,
        "shear_stress": -xy / pressure,
        "first_normal": (xx - yy) / pressure,
        "second_normal": (yy - zz) / pressure,
        "pressure": pressure / (gas.n * gas.mass / gas.volume * float(t.mean())),
        "collision_rate": float(series.collision_rate[1:].mean()) / (enskog * roots),
        "profile": profile(result.system),
        "largest_compression": float(getattr(result, "largest_compression", 0.0) or 0.0),
    }


def profile(system: hl.ParticleSystem) -> float:
    """Variance of the mean velocities in layers about the linear profile, over that of independent particles."""
    axis = system.domain.gradient
    assert axis is not None
    flow = (system.velocities - system.domain.mean_flow(system.positions))[:, 0]
    layer = np.minimum((system.positions[:, axis] / system.box[axis] * LAYERS).astype(int), LAYERS - 1)
    count = np.bincount(layer, minlength=LAYERS)
    mean = np.bincount(layer, flow, LAYERS) / np.maximum(count, 1)
    return float(np.sum(count * mean**2)) / ((LAYERS - 1) * float(flow.var()))


# --- results --------------------------------------------------------------------------------------------------


def ratio(ds: xr.Dataset, name: str) -> tuple[float, float]:
    """Hard spheres over Newton's equations, less 1, with its standard error over replicas."""
    return driver.ratio(ds[name].sel(model="constant"), ds[name].sel(model="newton"))


def stress_error(ds: xr.Dataset) -> tuple[float, float]:
    """Error of the shear stress, which is that of the dissipation: viscosity times √T."""
    stress = ds.viscosity * np.sqrt(ds.temperature)
    return ratio(ds.assign(stress=stress), "stress")


def tables(ds: xr.Dataset) -> str:
    errors, normal = [], []
    for phi, epsilon, tc_nu, here in driven_gas.cases(TC_NU, ds):
        x = real_tc_nu(here, tc_nu)
        law = hl.error_law(packing_fraction=phi, restitution=epsilon)
        predicted, dissipation = law.sheared_errors(x), (1.0 + law.heated_error(x)) ** -1.5
        cells = [
            _cell(*ratio(here, "temperature"), predicted.temperature),
            _cell(*stress_error(here), predicted.stress),
            f"{100.0 * BERZI_JENKINS * x:.1f}",
            _cell(*ratio(here, "viscosity"), (1.0 + predicted.temperature) * dissipation - 1.0),
            _cell(*ratio(here, "dissipation"), dissipation - 1.0),
        ]
        errors.append((phi, epsilon, tc_nu, *cells))
        if tc_nu == TC_NU[phi][-1]:
            cells = [
                ", ".join(_value(here[name].sel(model=model)) for model in ("constant", "newton"))
                for name in ("first_normal", "second_normal")
            ]
            normal.append((phi, epsilon, tc_nu, *cells))
    head = "temperature | stress | Berzi & Jenkins | viscosity at equal T | dissipation at equal T"
    steady = driver.table(f"φ | ε | t_c ν | {head}", errors)
    head = "(P_xx − P_yy)/p: hard, Newton | (P_yy − P_zz)/p: hard, Newton"
    return f"{steady}\n\n{driver.table(f'φ | ε | t_c ν | {head}', normal)}"


def _value(values: xr.DataArray) -> str:
    return "{:.3f}±{:.3f}".format(*driver.mean(values))


def _cell(value: float, error: float, law: float) -> str:
    return driven_gas.percent(value, error, law, 1)


def draw(ds: xr.Dataset) -> dict[str, Figure]:
    colors = {0.9: PALETTE["blue"], 0.7: PALETTE["vermillion"]}
    with style():
        figure = Figure(figsize=(PAGE_WIDTH, 5.2), layout="constrained")
        axes = figure.subplots(2, 3, sharex="col", sharey="row")
        for column, (phi, values) in enumerate(TC_NU.items()):
            top, below = axes[:, column]
            x = np.linspace(0.0, 1.15 * values[-1], 60)
            for epsilon, color in colors.items():
                law = hl.error_law(packing_fraction=phi, restitution=epsilon)
                top.plot(x, [100.0 * law.sheared_errors(at).temperature for at in x], color=color)
                below.plot(x, [100.0 * law.sheared_errors(at).stress for at in x], color=color)
                for tc_nu in values:
                    here = ds.sel(packing_fraction=phi, restitution=epsilon, tc_nu=tc_nu)
                    at = real_tc_nu(here, tc_nu)
                    label = f"ε = {epsilon:g}" if tc_nu == values[0] else None
                    for ax, (value, error) in (
                        (top, ratio(here, "temperature")),
                        (below, stress_error(here)),
                    ):
                        ax.errorbar(at, 100.0 * value, 100.0 * error, fmt="o", ms=4, color=color, label=label)
            top.axhline(0.0, color="k", ls="--", lw=1.0)
            below.plot(x, 100.0 * BERZI_JENKINS * x, "k--", lw=1.0, label="Berzi & Jenkins (2015)")
            top.set_title(f"φ = {phi:g}")
            below.set_xlabel(r"$t_c\nu$")
            below.set_xlim(0.0, x[-1])
        axes[0, 0].set(ylabel="error of the temperature [%]")
        axes[1, 0].set(ylabel="error of the shear stress [%]")
        axes[1, 1].legend(loc="upper left", fontsize="small")
    return {"sheared_gas.png": figure}


STUDY = driven_gas.study(
    VALUES,
    {"title": "Steady states of a sheared gas of hard spheres and of soft ones", "n": N},
    file=__file__,
    points=points,
    run=run,
    replicas=6,
    axes=lambda: driven_gas.axes(TC_NU, ("newton", "constant")),
    draw=draw,
    tables=tables,
)

if __name__ == "__main__":
    driver.main(STUDY, __doc__)
