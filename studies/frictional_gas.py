"""Measurement of the law of the error with friction: the error of hard spheres with the same friction in a cooling gas,
divided by t_c ν (see driver.py).

Every replica starts from an elastic equilibrium with Maxwellian spins. A run is measured while its energy E falls from
that after 3 to that after 9 collisions per particle in the theory of the rotating gas (``theory.Gas.rotating``). E is
the energy not yet dissipated: of translation, of rotation, and stored in springs. Hard spheres are cheap, so that each
replica under Newton's equations has three of them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import cache, lru_cache
from typing import Any, NamedTuple

import driver
import error_law as smooth
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy import integrate

import hardlimit as hl
from hardlimit.boxes import theory
from hardlimit.fidelity_study.starts import equilibrated
from hardlimit.plots.style import GREY, PAGE_WIDTH, PALETTE, style
from hardlimit.support.estimate import Estimate

MODELS = ("newton", "law", "constant")
#: What is measured in the window: unit and meaning.
MEASURED = {
    "duration": ("s", "time from the first energy of the window to the last"),
    "collisions": ("1", "collisions per particle in this time"),
    "mean_tc_nu": ("1", "t_c ν with Enskog’s rate at the granular temperature, mean over this time"),
    "temperature_ratio": ("1", "T_r/T, mean over this time"),
    "largest_compression": ("1", "largest compression of a contact over the radius"),
}
N = 4000
WINDOW = (3.0, 9.0)  #: collisions per particle in theory
SAMPLES = 120
#: Accuracy of ε that sets the time step; the dissipated energy is then too small by a share of 4e-4 to 1.2e-3.
RESTITUTION_ERROR = 1e-3
#: Newton's equations are solved by events up to this t_c ν, where these cost less than steps.
BY_EVENTS = 0.03
#: Hard-sphere replicas for each one under Newton's equations.
HARD = 3
#: Hard-sphere replicas of a point, and of points of which more was to be known.
REPLICAS, MORE_REPLICAS = 16, 24
#: Initial t_c ν by dimension and packing fraction.
TC_NU = {3: {0.02: 0.02, 0.05: 0.06, 0.2: 0.3, 0.35: 0.3, 0.5: 0.3}, 2: {0.2: 0.1, 0.6: 0.3}}
#: m_n/m_t of solid spheres and disks.
KAPPA = {3: 3.5, 2: 3.0}
#: μ and ρ = κ k_t/k_n by packing fraction and restitution.
FEW, MORE = ((0.5, 1.0), (0.5, 2.88)), ((0.1, 1.0), (0.1, 2.88))
FRICTION = {
    0.05: {0.9: (*FEW, (0.1, 1.0), (1.0, 1.0)), 0.7: FEW},
    0.2: {0.9: (*FEW, *MORE, (1.0, 1.0), (0.5, 3.5), (0.3, 1.0)), 0.7: (*FEW, *MORE, (1.0, 1.0))},
    0.35: {0.9: (*FEW, *MORE, (1.0, 1.0)), 0.7: FEW},
    0.5: {0.9: (*FEW, *MORE, (1.0, 1.0), (0.5, 3.5)), 0.7: (*FEW, *MORE)},
}


class Point(NamedTuple):
    """A gas and its contact law. t_c ν is that at the start, at the mean impact speed."""

    dimension: int
    packing_fraction: float
    law: str
    restitution: float
    tc_nu: float
    friction: float  #: μ
    rho: float  #: ρ = κ k_t/k_n
    damping: float  #: γ_t/γ_n
    start: float  #: T_r/T


def _point(phi: float, epsilon: float, mu: float, rho: float, dimension: int = 3, **changes: Any) -> Point:
    usual = Point(dimension, phi, "linear", epsilon, TC_NU[dimension][phi], mu, rho, 0.0, 1.0)
    return usual._replace(**changes)


def gases() -> Iterator[Point]:
    for phi, grid in FRICTION.items():
        for epsilon, pairs in grid.items():
            for mu, rho in pairs:
                yield _point(phi, epsilon, mu, rho)
    yield _point(0.2, 0.9, 0.0, 1.0)  # no friction
    # the usual damping of LAMMPS and LIGGGHTS, nearly elastic spheres, no spin at the start, smaller t_c ν
    yield _point(0.2, 0.7, 0.3, 1.0, damping=0.5)
    yield _point(0.2, 0.7, 0.5, 2.88, damping=1.0)
    yield _point(0.2, 0.95, 0.5, 1.0)
    yield _point(0.2, 0.95, 0.5, 2.88)
    yield _point(0.2, 0.9, 0.5, 1.0, start=0.0)
    yield _point(0.2, 0.9, 0.1, 2.88, start=0.0)
    yield _point(0.2, 0.9, 0.5, 1.0, tc_nu=0.1)
    yield _point(0.2, 0.9, 0.5, 2.88, tc_nu=0.1)
    for phi in TC_NU[2]:
        for mu, rho in ((0.5, 1.0), (0.5, 3.0), (1.0, 1.0)):
            yield _point(phi, 0.9, mu, rho, dimension=2)
    yield _point(0.2, 0.9, 0.5, 2.88, law="viscoelastic")
    yield from predicted()


def predicted() -> Iterator[Point]:
    """Gases that the fit of third particles does not know: a test of the law."""
    yield _point(0.2, 0.99, 0.5, 1.0)
    yield _point(0.5, 0.99, 0.5, 1.0)
    yield _point(0.2, 0.9, 0.5, 1.0, tc_nu=0.03)
    yield _point(0.02, 0.9, 0.5, 1.0)
    for phi in (0.05, 0.5):
        yield _point(phi, 0.9, 0.5, 1.0, law="viscoelastic")
    # k_t/k_n = 0.9, also with 0.3 of the critical damping of the tangential spring
    yield _point(0.2, 0.9, 0.5, 3.15)
    yield _point(0.5, 0.9, 0.5, 3.15)
    yield _point(0.2, 0.7, 0.5, 3.15, damping=1.35)


def replicas(point: Point) -> int:
    """Number of hard-sphere replicas."""
    again = [_point(0.2, 0.9, 0.5, 1.0, tc_nu=tc_nu) for tc_nu in (0.1, 0.3)]
    again += [_point(phi, 0.7, mu, 1.0) for phi in (0.2, 0.5) for mu in (0.1, 0.5)]
    return MORE_REPLICAS if point in (*again, *predicted()) else REPLICAS


def points(replica: int) -> Iterator[driver.Point]:
    """Newton's equations in every third replica, in thin gases in two of three."""
    for point in sorted(gases(), key=lambda point: point[:2]):  # the start is that of the gas
        if replica >= replicas(point):
            continue
        if replica % HARD == 0 or (replica % HARD == 1 and point.packing_fraction == 0.05):
            yield *point, "newton"
        yield *point, "law"
        yield *point, "constant"


# --- runs ---------------------------------------------------------------------------------------------------


def law_of(point: Point, system: hl.ParticleSystem) -> hl.Law:
    """The law with this ε and t_c ν at the mean impact speed of the start, and friction unless μ = 0."""
    law = smooth.law_of(smooth.Point(*point[:5]), system)
    if point.friction == 0.0:
        return law
    ratio = point.rho / KAPPA[point.dimension]
    model = "mindlin_rescale" if point.law == "viscoelastic" else "spring"
    friction = hl.Friction(point.friction, stiffness_ratio=ratio, damping_ratio=point.damping, model=model)
    return law.replace(friction=friction)


@cache
def relaxed(dimension: int, phi: float) -> hl.ParticleSystem:
    random = hl.ParticleSystem.random(
        N, phi, smooth.RADIUS, smooth.DENSITY, smooth.RMS_SPEED, dimension=dimension, rms_spin="equal"
    )
    return equilibrated(random, 0, collisions=smooth.RELAXATION)


@lru_cache(maxsize=1)
def equilibrium(dimension: int, phi: float, replica: int) -> hl.ParticleSystem:
    return equilibrated(relaxed(dimension, phi), replica)


def start(point: Point, replica: int) -> hl.ParticleSystem:
    system = equilibrium(point.dimension, point.packing_fraction, replica)
    assert system.angular_velocities is not None
    return system.replace(angular_velocities=math.sqrt(point.start) * system.angular_velocities)


def gas_of(system: hl.ParticleSystem) -> theory.Gas:
    """The gas of a system; of spheres, also above the freezing point."""
    volume = float(np.prod(system.box))
    return theory.Gas(system.n, smooth.RADIUS, float(system.mass[0]), volume, system.dimension)


class Window(NamedTuple):
    """By theory, with E(0) = 1 and the initial ν = 1."""

    energies: tuple[float, float]  #: at the ends of the window
    end: float  #: time


@lru_cache(maxsize=256)
def window(point: Point) -> Window:
    """Energies that the theory of the rotating gas reaches after 3 and 9 collisions per particle."""
    axes = 3 if point.dimension == 3 else 1
    system = start(point, 0)
    law = law_of(point, system)
    gas = gas_of(system)
    if point.friction == 0.0:
        first, last = smooth.Point(*point[:5]).energies
        lost = (1.0 - point.restitution**2) / (2.0 * point.dimension)
        return Window((first**-2, last**-2), (last - 1.0) / lost)
    speed = math.sqrt(math.pi * system.granular_temperature)
    rotating = gas.rotating(law=law, speed=speed)

    def derivative(_: float, state: Any) -> Any:
        logarithm, theta, _ = state
        translation, rotation = rotating.rates(max(theta, 0.0))
        return [translation, rotation - theta * translation, math.exp(-0.5 * logarithm)]

    states = integrate.solve_ivp(
        derivative, (0.0, WINDOW[1]), [0.0, point.start, 0.0], t_eval=WINDOW, rtol=1e-6
    )
    logarithm, theta, time = states.y
    share = axes / point.dimension
    energy = np.exp(logarithm) * (1.0 + share * theta) / (1.0 + share * point.start)
    return Window((float(energy[0]), float(energy[1])), float(time[1]))


def measured(point: Point, system: hl.ParticleSystem, law: hl.Law, result: Any) -> dict[str, float]:
    """Time, collisions and means over the window; empty if the run ended before."""
    series, energies = result.series, window(point).energies
    total = system.kinetic_energy + (system.rotational_energy if point.friction else 0.0)
    y = (1.0 - series["dissipated_energy"].values / total) ** -0.5
    first, last = (energy**-0.5 for energy in energies)
    if not y[-1] >= last:
        return {}
    inside, common = smooth.within(series, y, (first, last))

    def mean(values: Any) -> float:
        return float(np.average(0.5 * (values[1:] + values[:-1]), weights=inside))

    temperature = series["granular_temperature"].values
    gas = gas_of(system)
    ball = hl.Ball(smooth.RADIUS, density=smooth.DENSITY)
    duration = law.between(ball, ball).duration(np.sqrt(math.pi * temperature))
    spinning = series["rotational_temperature"].values if point.friction else np.zeros_like(temperature)
    return {
        **common,
        "mean_tc_nu": mean(duration * gas.collision_rate(temperature)),
        "temperature_ratio": mean(spinning / temperature),
        "largest_compression": result.largest_compression,
    }


def run(of: driver.Point, replica: int) -> dict[str, Any]:
    """One run, longer if the window has not ended."""
    point, model = Point(*of[:-1]), of[-1]
    system = start(point, replica)
    law = law_of(point, system)
    for slower in (1.2, 1.7, 3.0):
        end = slower * window(point).end / smooth.enskog(system)
        common: dict[str, Any] = {"until": end, "samples": round(SAMPLES * slower)}
        if model == "newton":
            steps = {"engine": "steps", "restitution_error": RESTITUTION_ERROR, "threads": 1}
            engine: dict[str, Any] = {"engine": "events"} if point.tc_nu <= BY_EVENTS else steps
            result: Any = hl.molecular_dynamics(system, law=law, **engine, **common)
        elif model == "law" or point.friction == 0.0:
            result = hl.event_driven(system, law=law, **common)
        else:
            result = hl.event_driven(system, **constant(point, law), **common)
        values = measured(point, system, law, result)
        if values or result.outcome_name != "ok":
            break
    return values


def constant(point: Point, law: hl.Law) -> dict[str, float]:
    """The rule constant that stands for a law in a gas."""
    ball = hl.Ball(smooth.RADIUS, density=smooth.DENSITY)
    contact = law.between(ball, ball)
    speed = math.sqrt(math.pi * smooth.RMS_SPEED**2 / point.dimension)
    beta = contact.effective_tangential_restitution(speed, dimension=point.dimension)
    return {"restitution": point.restitution, "friction": point.friction, "tangential_restitution": beta}


# --- results ------------------------------------------------------------------------------------------------


def gather(runs: list[driver.Run]) -> xr.Dataset:
    """Every replica of every point; NaN where a run was not made or ended early."""
    known = list(dict.fromkeys(Point(*run["point"][:-1]) for run in runs))
    known.sort(
        key=lambda point: (-point.dimension, point.law, point.packing_fraction, -point.restitution, point.rho)
    )
    return driver.listed(runs, known, MODELS, MEASURED)


def all_points(ds: xr.Dataset) -> list[Point]:
    return driver.points_of(ds, Point)


class Control(NamedTuple):
    """How durations under Newton's equations follow those of hard spheres from the same start."""

    slope: float
    scatter: float  #: relative standard deviation of what remains


def kind(point: Point) -> tuple[Any, ...]:
    """Points in which the start matters as much: little friction keeps its fluctuations for longer."""
    return point.dimension, point.packing_fraction, min(point.friction, 0.2)


def by_start(ds: xr.Dataset, i: int) -> tuple[Any, Any]:
    """Durations of each replica under Newton's equations, and those of hard spheres over their mean (both rules)."""
    at = ds["duration"].isel(point=i).sel(model=["newton", "law", "constant"]).values.astype(float)
    hard = at[1:][np.isfinite(at[1:]).any(axis=1)]
    return at[0], np.mean(hard / np.nanmean(hard, axis=1, keepdims=True), axis=0)


def controls(ds: xr.Dataset) -> dict[tuple[Any, ...], Control]:
    """By regression over the replicas of all points of a kind."""
    sums: dict[tuple[Any, ...], Any] = {}
    for i, point in enumerate(all_points(ds)):
        newton, hard = by_start(ds, i)
        both = np.isfinite(newton) & np.isfinite(hard)
        if both.sum() > 1:
            x, y = hard[both] - hard[both].mean(), newton[both] / newton[both].mean() - 1.0
            row = np.array([x @ x, x @ y, y @ y, both.sum() - 1])
            sums[kind(point)] = sums.get(kind(point), 0.0) + row
    return {
        name: Control(xy / xx, math.sqrt((yy - xy**2 / xx) / (freedom - 1)))
        for name, (xx, xy, yy, freedom) in sums.items()
    }


def coefficient(ds: xr.Dataset, i: int, known: Mapping[tuple[Any, ...], Control]) -> Estimate[float]:
    """a of the rule law: the ratio of the mean times for the same loss of energy, less 1, over t_c ν.

    Hard spheres have more replicas: what they tell of the starts of Newton's equations is corrected (``known``).
    """
    at, (newton, hard) = ds.isel(point=i), by_start(ds, i)
    control = known[kind(all_points(ds)[i])]
    both = np.isfinite(newton) & np.isfinite(hard)
    times = at["duration"].sel(model="law").dropna("replica").values.astype(float)
    start = control.slope * (hard[both].mean() - np.nanmean(hard))
    ratio = float(newton[both].mean() / times.mean()) * (1.0 - start)
    tc_nu = float(at["mean_tc_nu"].sel(model="law").mean())
    rest = (1.0 - control.slope) * float(np.nanstd(hard, ddof=1)) / math.sqrt(len(times))
    error = ratio * math.hypot(control.scatter / math.sqrt(both.sum()), rest)
    return Estimate((ratio - 1.0) / tc_nu, error / tc_nu, math.nan, math.nan)


def theory_of(point: Point, phi: float | None = None) -> hl.ErrorLaw:
    """The law of the error of a point, also at another packing fraction."""
    ratio, linear = point.rho / KAPPA[point.dimension], point.law == "linear"
    model = "spring" if linear else "mindlin_rescale"
    friction = hl.Friction(point.friction, stiffness_ratio=ratio, damping_ratio=point.damping, model=model)
    return hl.error_law(
        packing_fraction=phi or point.packing_fraction,
        restitution=point.restitution,
        dimension=point.dimension,
        rule="law",
        law=None if linear else smooth.viscoelastic(point.restitution, 1.0),
        friction=friction,
        temperature_ratio=point.start,
    )


# --- pictures and tables ------------------------------------------------------------------------------------

#: Colours and markers by μ and ρ.
LOOKS = {
    (0.0, 1.0): ("black", "o"),
    (0.1, 1.0): ("blue", "s"),
    (0.5, 2.88): ("green", "D"),
    (0.5, 1.0): ("vermillion", "^"),
    (1.0, 1.0): ("purple", "v"),
}


def draw(ds: xr.Dataset) -> Mapping[str, Figure]:
    with style():
        figure = Figure(figsize=(PAGE_WIDTH, 3.6))
        left, right = figure.subplots(1, 2)
        _over_packing(ds, left)
        _agreement(ds, right)
    return {"frictional_gas.png": figure}


def _over_packing(ds: xr.Dataset, ax: Axes) -> None:
    """a over φ for spheres of ε = 0.9."""
    known = controls(ds)
    for (mu, rho), (name, marker) in LOOKS.items():
        point = _point(0.2, 0.9, mu, rho)
        phi = np.geomspace(0.018 if (mu, rho) == (0.5, 1.0) else 0.045, 0.53, 60)
        ax.plot(phi, [theory_of(point, float(x)).coefficient for x in phi], color=PALETTE[name], lw=1.0)
        for i, at in enumerate(all_points(ds)):
            if at == point._replace(
                packing_fraction=at.packing_fraction, tc_nu=TC_NU[3].get(at.packing_fraction)
            ):
                a = coefficient(ds, i, known)
                ax.errorbar(
                    at.packing_fraction, a.value, a.error, color=PALETTE[name], marker=marker, ms=4, lw=0.8
                )
        label = f"μ = {mu:g}, ρ = {rho:g}" if mu else "smooth"
        ax.plot([], [], color=PALETTE[name], marker=marker, ms=4, label=label)
    ax.axhline(0.0, color=GREY, lw=0.6)
    ax.set(
        xscale="log",
        xlabel="packing fraction φ",
        ylabel="a = error of the cooling/(t$_c$ ν)",
        ylim=(-3.3, 3.0),
    )
    ax.set_xticks([0.02, 0.05, 0.1, 0.2, 0.5], ["0.02", "0.05", "0.1", "0.2", "0.5"])
    ax.minorticks_off()
    ax.legend()


def _agreement(ds: xr.Dataset, ax: Axes) -> None:
    """Measured over predicted a, all points but those of thin gases, whose scale is another."""
    known = controls(ds)
    for i, point in enumerate(all_points(ds)):
        if point.packing_fraction < 0.1 or point.tc_nu < 0.1:
            continue
        law = theory_of(point)
        a, disks = coefficient(ds, i, known), point.dimension == 2
        colour = PALETTE["vermillion" if disks else "blue" if point.restitution > 0.8 else "green"]
        ax.errorbar(
            law.coefficient, a.value, a.error, law.coefficient_error, color=colour, marker="o", ms=3, lw=0.6
        )
    ends = -0.75, 1.1
    ax.plot(ends, ends, color=GREY, lw=0.8)
    for name, text in (
        ("blue", "spheres, ε ≥ 0.9"),
        ("green", "spheres, ε = 0.7"),
        ("vermillion", "disks, ε = 0.9"),
    ):
        ax.plot([], [], color=PALETTE[name], marker="o", ms=3, label=text)
    ax.set(xlabel="a by the law", ylabel="a measured", xlim=ends, ylim=ends)
    ax.legend(loc="upper left")


def tables(ds: xr.Dataset) -> str:
    known, rows, deviations = controls(ds), [], {}
    for i, point in enumerate(all_points(ds)):
        a, law = coefficient(ds, i, known), theory_of(point)
        count = int(np.isfinite(ds["duration"].isel(point=i).sel(model="newton")).sum())
        constant = ds["duration"].isel(point=i).sel(model=["law", "constant"]).mean("replica").values
        deviations[point] = (a.value - law.coefficient) / math.hypot(a.error, law.coefficient_error)
        gas = " | ".join(f"{value:g}" for value in (*point[:2], point.restitution, *point[5:], point.tc_nu))
        values = f"{a.value:.2f}±{a.error:.2f}", f"{law.coefficient:.2f}±{law.coefficient_error:.2f}"
        offset = f"{100.0 * (constant[0] / constant[1] - 1.0):.1f}"
        rows.append((gas + (", Hertz" if point.law != "linear" else ""), count, *values, offset))
    head = "D | φ | ε | μ | ρ | γ_t/γ_n | θ(0) | t_c ν | runs | a | law | constant [%]"
    new = [deviations[point] for point in predicted() if point in deviations]
    chi = [f"χ² = {np.square(z).sum():.1f} of {len(z)} values" for z in (list(deviations.values()), new)]
    return f"{driver.table(head, rows)}\n\n{chi[0]}; of the predicted ones {chi[1]}"


STUDY = driver.Study(
    file=__file__,
    points=points,
    run=run,
    replicas=MORE_REPLICAS,
    values=MEASURED,
    gather=gather,
    about={
        "title": "Cooling of grains with friction at given energy, hard spheres and Newton’s equations",
        "n": N,
        "window": WINDOW,
    },
    draw=draw,
    tables=tables,
)

if __name__ == "__main__":
    driver.main(STUDY, __doc__)
