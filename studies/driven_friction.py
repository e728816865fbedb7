"""Measurement of heated and sheared gases of grains that rub: hard spheres beside Newton's equations with the same
friction (see driver.py).

Heated: as heated_gas.py, at equal power, for 25 collisions of each particle before and 120 in the window. Sheared: as
sheared_gas.py, at equal shear rate, for 60 collisions before and 600 in the window. Kicks act on velocities only; the
spins start with the temperature that the theory of the rotating gas predicts for the heated one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import Any, Final, NamedTuple

import driven_gas
import driver
import numpy as np
import xarray as xr
from driven_gas import DENSITY, RADIUS, TEMPERATURE
from heated_gas import KICKS
from matplotlib.figure import Figure
from sheared_gas import SIDES

import hardlimit as hl
from hardlimit.boxes import theory
from hardlimit.checking.expectation import SHEAR_BAR
from hardlimit.fidelity_study.starts import equilibrated
from hardlimit.plots.style import PAGE_WIDTH, PALETTE, style

KAPPA: Final = 3.5  #: m_n/m_t of solid spheres


class Case(NamedTuple):
    """A gas and its friction; t_c ν by Enskog's theory at the temperature that theory predicts."""

    packing_fraction: float
    mu: float
    rho: float  #: κ k_t/k_n
    tc_nu: float
    restitution: float = 0.9
    damping: float = 0.0  #: γ_t/γ_n


CASES: Final = {
    "thin": Case(0.1, 0.5, 1.0, 0.1),
    "dense": Case(0.3, 0.5, 1.0, 0.3),
    "stiff": Case(0.3, 0.5, 2.88, 0.3),
}
#: Heated gases that were run after the theory of heated gases with friction was written down.
TESTS: Final = {
    "smoother": Case(0.3, 0.1, 1.0, 0.3),
    "rougher": Case(0.3, 1.0, 1.0, 0.3),
    "denser": Case(0.5, 0.5, 1.0, 0.3),
    "inelastic": Case(0.3, 0.5, 1.0, 0.3, 0.7),
    "thin rougher": Case(0.1, 1.0, 1.0, 0.1),
}
#: Heated only, with tangential damping. They were run after ``hardlimit check`` used the theory.
DAMPED: Final = {
    "damped": Case(0.2, 0.5, 1.0, 0.2, 0.9, 0.5),
    "thin damped": Case(0.1, 0.3, 2.88, 0.1, 0.8, 0.5),
    "dense damped": Case(0.4, 1.0, 1.0, 0.2, 0.9, 0.5),
}
#: Sheared only.
FURTHER: Final = {
    "medium": Case(0.2, 0.5, 1.0, 0.1),
    "hard": Case(0.3, 0.5, 1.0, 0.1),
    "thin hard": Case(0.1, 0.5, 1.0, 0.03),
    "thin stiff": Case(0.1, 0.5, 2.88, 0.1),
    "dense sheared": Case(0.45, 0.5, 1.0, 0.3),
    "elastic": Case(0.3, 0.5, 1.0, 0.3, 0.97),
    "thin elastic": Case(0.1, 0.5, 1.0, 0.1, 0.97),
}
HEATED: Final = CASES | TESTS | DAMPED
SHEARED: Final = (
    CASES
    | {name: TESTS[name] for name in ("smoother", "rougher", "inelastic", "thin rougher")}
    | {name: DAMPED[name] for name in ("damped", "thin damped")}
    | FURTHER
)
ALL: Final = HEATED | FURTHER
#: Number of particles, collisions per particle before and in the window, and replicas.
DRIVES: Final = {"heated": (1000, 25, 120, 3), "sheared": (500, 60, 600, 8)}
SAMPLES: Final = 3  #: for each collision of a particle
VALUES: Final = {
    "temperature": "mean temperature over that of theory",
    "temperature_ratio": "mean T_r/T",
    "dissipation": "dissipation over T^(3/2), over ν N m T/2 by Enskog's theory",
    "pressure": "pressure over nmT",
    "supplied": "power of the kicks or of the shear stress over the dissipation",
    "stress": "dissipation over that of theory: shear stress at a given shear rate",
    "largest_compression": "largest compression of a contact over the radius",
}


def points(replica: int) -> Iterator[driver.Point]:
    for drive, (*_, replicas) in DRIVES.items():
        for case in SHEARED if drive == "sheared" else HEATED:
            if replica < replicas:
                yield drive, case, "law"
                yield drive, case, "newton"


def friction_of(case: Case) -> hl.Friction:
    return hl.Friction(case.mu, stiffness_ratio=case.rho / KAPPA, damping_ratio=case.damping)


def rotating(gas: theory.Gas, case: Case) -> theory.RotatingGas:
    law = hl.LinearDashpot(stiffness=1.0, restitution=case.restitution, friction=friction_of(case))
    return gas.rotating(law=law)


def run(point: driver.Point, replica: int) -> dict[str, float]:
    """The values of one run; none if it ended early."""
    drive, name, model = point
    case, (n, before, window, _) = ALL[name], DRIVES[drive]
    sides = SIDES if drive == "sheared" else "periodic"
    speed = math.sqrt(3.0 * TEMPERATURE)
    start = hl.ParticleSystem.random(
        n, case.packing_fraction, RADIUS, DENSITY, speed, seed=replica, boundary=sides, rms_spin="equal"
    )
    gas = theory.Gas(n, RADIUS, float(start.mass[0]), start.domain.volume, 3)
    spinning, nu = rotating(gas, case), float(gas.collision_rate(TEMPERATURE))
    theta = spinning.heated_temperature_ratio()
    unit = 0.5 * nu * float(start.mass.sum()) * TEMPERATURE
    power = -spinning.mean_collision(theta).energy_change * unit
    if drive == "sheared":  # smooth spheres that dissipate as much
        rate = math.sqrt(TEMPERATURE / gas.sheared_temperature(1.0, as_smooth(power / unit)))
        start = start.replace(shear_rate=rate)
    start = equilibrated(start, 1000 + replica, collisions=30)
    assert start.angular_velocities is not None
    start = start.replace(angular_velocities=math.sqrt(theta) * start.angular_velocities)
    if drive == "heated":
        start = start.replace(
            thermostat=hl.RandomKicks(power, KICKS / nu, seed=10_000 * replica + 7 * len(model))
        )
    law = driven_gas.law(case.restitution, start, case.tc_nu / nu).replace(friction=friction_of(case))
    options: dict[str, Any] = {"until": (before + window) / nu, "samples": SAMPLES * (before + window)}
    if model == "newton":
        result: Any = hl.molecular_dynamics(
            start, law=law, engine="steps", restitution_error=1e-3, threads=1, **options
        )
    else:
        result = hl.event_driven(start, law=law, **options)
    if result.outcome != "ok":
        return {}
    return measured(result, drive, before, gas, unit, power)


def measured(
    result: Any, drive: str, before: int, gas: theory.Gas, unit: float, power: float
) -> dict[str, float]:
    """Means over the window."""
    series = result.series.isel(time=slice(SAMPLES * before, None))
    t = series.granular_temperature.values / TEMPERATURE
    duration = float(series.time[-1] - series.time[0])
    lost = float(series.dissipated_energy[-1] - series.dissipated_energy[0]) / duration
    supplied = power
    if drive == "sheared":
        supplied = float(series.shear_work[-1] - series.shear_work[0]) / duration
    ideal = gas.n * gas.mass / gas.volume * TEMPERATURE
    return {
        "temperature": float(t.mean()),
        "temperature_ratio": float(
            np.mean(series.rotational_temperature.values / series.granular_temperature.values)
        ),
        "dissipation": lost / float(np.mean(t**1.5)) / unit,
        "pressure": float(series.pressure[1:].mean()) / (ideal * float(t.mean())),
        "supplied": supplied / lost,
        "stress": lost / power,
        "largest_compression": float(getattr(result, "largest_compression", 0.0) or 0.0),
    }


# --- results ------------------------------------------------------------------------------------------------


def scatter(ds: xr.Dataset, drive: str, name: str) -> float:
    """Relative standard deviation between replicas, of all points of a drive together: each has few."""
    rows = ds[name].sel(drive=drive).values.reshape(-1, ds.sizes["replica"])
    rows = [row[np.isfinite(row)] for row in rows]
    squares = sum(float(np.sum((row / row.mean() - 1.0) ** 2)) for row in rows if len(row) > 1)
    return math.sqrt(squares / sum(len(row) - 1 for row in rows if len(row) > 1))


def error(ds: xr.Dataset, drive: str, case: str, name: str, power: float = 1.0) -> tuple[float, float]:
    """(Hard spheres over Newton's equations)^power, less 1, with its standard error."""
    at = ds[name].sel(drive=drive, case=case)
    hard, newton = (at.sel(model=model).dropna("replica").values for model in ("law", "newton"))
    value = float(hard.mean() / newton.mean()) ** power
    return value - 1.0, abs(power * value) * scatter(ds, drive, name) * math.hypot(
        len(hard) ** -0.5, len(newton) ** -0.5
    )


def errors(ds: xr.Dataset, case: str) -> dict[str, tuple[float, float]]:
    """Heated: temperature at equal power, pressure at equal temperature. Sheared: temperature and stress, dissipation
    and viscosity at equal temperature."""
    values = {}
    if case in HEATED:
        values["heated: temperature"] = error(ds, "heated", case, "dissipation", -2.0 / 3.0)
        values["heated: pressure at equal T"] = error(ds, "heated", case, "pressure")
    if case in SHEARED:
        flowing = ds.assign(viscosity=ds.stress / np.sqrt(ds.temperature))
        values["sheared: temperature"] = error(ds, "sheared", case, "temperature")
        values["sheared: stress"] = error(ds, "sheared", case, "stress")
        values["sheared: dissipation at equal T"] = error(ds, "sheared", case, "dissipation")
        values["sheared: viscosity at equal T"] = error(flowing, "sheared", case, "viscosity")
    return values


def tc_nu(ds: xr.Dataset, drive: str, case: str) -> float:
    """By Enskog's theory at the temperature under Newton's equations."""
    temperature = float(ds.temperature.sel(drive=drive, case=case, model="newton").mean())
    return ALL[case].tc_nu * math.sqrt(temperature)


def law_of(case: Case) -> hl.ErrorLaw:
    """The law of the error with friction."""
    return hl.error_law(
        packing_fraction=case.packing_fraction,
        restitution=case.restitution,
        rule="law",
        friction=friction_of(case),
    )


def heated(ds: xr.Dataset, case: str) -> tuple[float, float]:
    """The law's error of the temperature with friction, and its standard error."""
    law, x = law_of(ALL[case]), tc_nu(ds, "heated", case)
    value = law.heated_error(x)
    return value, 2.0 / 3.0 * (1.0 + value) * law.error_bar(x)


def sheared(ds: xr.Dataset, case: str) -> dict[str, tuple[float, float]]:
    """The law's errors of temperature and stress with friction, and their standard errors."""
    law, x = law_of(ALL[case]), tc_nu(ds, "sheared", case)
    temperature, stress = law.sheared_errors(x)
    bar, left = law.error_bar(x), SHEAR_BAR * x
    return {
        "sheared: temperature": (temperature, (1.0 + temperature) * math.hypot(bar, left)),
        "sheared: stress": (stress, (1.0 + stress) * math.hypot(0.5 * bar, left)),
    }


def smooth(ds: xr.Dataset, case: str) -> dict[str, float]:
    """The law of smooth grains at the t_c ν of the same temperatures."""
    known = ALL[case]
    law = hl.error_law(packing_fraction=known.packing_fraction, restitution=known.restitution)
    values = {}
    if case in HEATED:
        values["heated: temperature"] = law.heated_error(tc_nu(ds, "heated", case))
    if case in SHEARED:
        x = tc_nu(ds, "sheared", case)
        steady, dissipation = law.sheared_errors(x), (1.0 + law.heated_error(x)) ** -1.5 - 1.0
        values |= {
            "sheared: temperature": steady.temperature,
            "sheared: stress": steady.stress,
            "sheared: dissipation at equal T": dissipation,
            "sheared: viscosity at equal T": (1.0 + steady.temperature) * (1.0 + dissipation) - 1.0,
        }
    return values


#: Columns of both tables.
SETTING: Final = "φ | μ | ρ | t_c ν | ε | γ_t/γ_n"


def tables(ds: xr.Dataset) -> str:
    head = "temperature | law | smooth | T/T₀: hard, Newton | θ₀ | θ: hard, Newton"
    of_heated = driver.table(f"{SETTING} | {head}", (heated_row(ds, name) for name in HEATED))
    head = "temperature | stress | dissipation | viscosity | T/T₀ | θ₀ | θ: hard, Newton"
    of_sheared = driver.table(f"{SETTING} | {head}", (sheared_row(ds, name) for name in SHEARED))
    return f"{of_heated}\n\n{of_sheared}"


def heated_row(ds: xr.Dataset, name: str) -> list[str]:
    return [
        *(f"{value:g}" for value in ALL[name]),
        in_percent(*error(ds, "heated", name, "dissipation", -2.0 / 3.0)),
        in_percent(*heated(ds, name)),
        f"{100.0 * smooth(ds, name)['heated: temperature']:.1f}",
        pair(ds.temperature, "heated", name),
        f"{predicted_ratio(ALL[name]):.3f}",
        pair(ds.temperature_ratio, "heated", name),
    ]


def sheared_row(ds: xr.Dataset, name: str) -> list[str]:
    measured, law, without = errors(ds, name), sheared(ds, name), smooth(ds, name)
    of_theory, theta = predicted(SHEARED[name])
    temperature = float(ds.temperature.sel(drive="sheared", case=name, model="law").mean())
    setting = SHEARED[name]._replace(tc_nu=float(f"{tc_nu(ds, 'sheared', name):.2g}"))
    return [
        *(f"{value:g}" for value in setting),
        *(f"{in_percent(*measured[k])} / {in_percent(*law[k])} / {100.0 * without[k]:.1f}" for k in law),
        *(in_percent(*measured[f"sheared: {k} at equal T"]) for k in ("dissipation", "viscosity")),
        f"{temperature / of_theory:.3f}",
        f"{theta:.3f}",
        pair(ds.temperature_ratio, "sheared", name),
    ]


def in_percent(value: float, error: float) -> str:
    return f"{100.0 * value:.1f}±{100.0 * error:.1f}".replace("-", "−")


@lru_cache
def predicted(case: Case) -> tuple[float, float]:
    """T of the sheared gas by kinetic theory with friction, over that of the study, and its θ."""
    gas = theory.Gas(1, RADIUS, 1.0, 4.0 / 3.0 * math.pi * RADIUS**3 / case.packing_fraction, 3)
    spinning = rotating(gas, case)
    loss = -spinning.mean_collision(spinning.heated_temperature_ratio()).energy_change
    state = spinning.sheared_state(1.0)
    return state.temperature / gas.sheared_temperature(1.0, as_smooth(loss)), state.temperature_ratio


def as_smooth(loss: float) -> float:
    """ε of smooth spheres with this loss of a collision in m T, at least 0.5."""
    return math.sqrt(max(1.0 - loss, 0.25))


def pair(values: xr.DataArray, drive: str, case: str) -> str:
    """The means of hard spheres and under Newton's equations."""
    of_models = (values.sel(drive=drive, case=case, model=model) for model in ("law", "newton"))
    return ", ".join(f"{float(value.mean()):.3f}" for value in of_models)


def predicted_ratio(case: Case) -> float:
    """θ of the heated gas by kinetic theory."""
    return rotating(theory.Gas(1, RADIUS, 1.0, 1.0, 3), case).heated_temperature_ratio()


def draw(ds: xr.Dataset) -> Mapping[str, Figure]:
    colors = dict(zip(CASES, ("blue", "vermillion", "green"), strict=True))
    with style():
        figure = Figure(figsize=(PAGE_WIDTH, 3.4), layout="constrained")
        ax = figure.subplots()
        names = list(errors(ds, "dense"))
        for k, (case, values) in enumerate(CASES.items()):
            measured, without = errors(ds, case), smooth(ds, case)
            place = -np.arange(len(names)) - 0.22 * (k - 1)
            value, bar = 100.0 * np.array([measured[name] for name in names]).T
            label = rf"φ = {values.packing_fraction:g}, ρ = {values.rho:g}, $t_c\nu$ = {values.tc_nu:g}"
            color = PALETTE[colors[case]]
            ax.errorbar(value, place, xerr=bar, fmt="o", ms=4, color=color, label=label)
            law = {"heated: temperature": heated(ds, case), **sheared(ds, case)}
            known = [100.0 * without.get(name, math.nan) for name in names]
            ax.plot(known, place, "o", ms=5, mfc="none", color=color)
            known = [100.0 * law.get(name, (math.nan, math.nan))[0] for name in names]
            ax.plot(known, place, "x", ms=5, color=color)
        ax.axvline(0.0, color="k", lw=0.6)
        ax.set_yticks(-np.arange(len(names)), names)
        ax.set(xlabel="error of hard spheres [%]")
        ax.legend(loc="upper right")
    return {"driven_friction.png": figure}


STUDY = driven_gas.study(
    VALUES,
    {
        "title": "Steady states of heated and sheared gases of grains with friction, hard and soft",
    },
    file=__file__,
    points=points,
    run=run,
    replicas=max(replicas for *_, replicas in DRIVES.values()),
    axes=lambda: {"drive": list(DRIVES), "case": list(ALL), "model": ["law", "newton"]},
    draw=draw,
    tables=tables,
)

if __name__ == "__main__":
    driver.main(STUDY, __doc__)
