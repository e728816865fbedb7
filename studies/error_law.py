"""Measurement of the law of the error: the error of each hard-sphere rule in a cooling gas, divided by t_c ν
(see driver.py).

Every replica starts from an elastic equilibrium of equal spheres or disks in a periodic box. A run is measured while
its energy E falls from y = 3 to 9 collisions per particle by Haff's law, y = √(E(0)/E) = exp((1 − ε²) n/(2D)). E is the
energy not yet dissipated, kinetic and stored in contacts. All models are therefore compared at the same energies, after
the transient of the start.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping
from functools import cache, lru_cache
from typing import Any, NamedTuple

import driver
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import hardlimit as hl
from hardlimit.boxes import error_law, theory
from hardlimit.fidelity_study.starts import equilibrated
from hardlimit.plots.style import GREY, PAGE_WIDTH, PALETTE, style
from hardlimit.support.estimate import Estimate

MODELS = ("newton", "law", "tc", "soft")
#: What is measured in the window: unit and meaning.
MEASURED = {
    "duration": ("s", "time from the first energy of the window to the last"),
    "collisions": ("1", "collisions per particle in this time"),
    "collision_rate": ("1/s", "collision rate times √(E(0)/E), mean over time"),
    "pressure": ("1", "pressure over n m T(0), times E(0)/E, mean over time"),
    "temperature": ("1", "kinetic temperature over T(0), times E(0)/E, mean over time"),
    "largest_compression": ("1", "largest compression of a contact over the radius"),
}
N = 8000
RADIUS, DENSITY, RMS_SPEED = 1e-3, 2500.0, 1.0  #: [m], [kg/m³], [m/s]
WINDOW = (3.0, 9.0)  #: collisions per particle by Haff's law
SAMPLES = 120
#: Elastic collisions per particle after the random start, before the 20 of each replica. At φ = 0.5 a random start
#: relaxes slowly: after 20 collisions it still cools 3 % faster than Enskog's theory.
RELAXATION = 400
#: Initial t_c ν by dimension and packing fraction. Softer particles would be compressed beyond the laws' range.
TC_NU = {
    3: {
        0.02: (0.01, 0.02),
        0.05: (0.03, 0.06),
        0.1: (0.03, 0.1),
        0.2: (0.03, 0.1, 0.3),
        0.35: (0.1, 0.3),
        0.5: (0.3,),
    },
    2: {0.05: (0.02,), 0.2: (0.1,), 0.4: (0.3,), 0.6: (0.3,), 0.7: (0.3,)},
}
RESTITUTION = {3: (0.99, 0.9, 0.8, 0.6, 0.4), 2: (0.99, 0.8, 0.6, 0.4)}
#: The same for the viscoelastic law.
VISCOELASTIC = {3: {0.05: (0.03,), 0.2: (0.1,), 0.5: (0.3,)}, 2: {0.4: (0.3,)}}
VISCOELASTIC_RESTITUTION = (0.95, 0.8, 0.6)


class Point(NamedTuple):
    """A gas and its contact law. t_c ν and ε are those at the start, t_c and ε at the mean impact speed."""

    dimension: int
    packing_fraction: float
    law: str
    restitution: float
    tc_nu: float

    @property
    def energies(self) -> tuple[float, float]:
        """√(E(0)/E) at the ends of the window."""
        lost = (1.0 - self.restitution**2) / (2.0 * self.dimension)
        return math.exp(lost * WINDOW[0]), math.exp(lost * WINDOW[1])


def gases() -> Iterator[Point]:
    for dimension, grid in TC_NU.items():
        for phi, values in grid.items():
            for epsilon in RESTITUTION[dimension]:
                for tc_nu in values:
                    yield Point(dimension, phi, "linear", epsilon, tc_nu)
            for epsilon in VISCOELASTIC_RESTITUTION:
                for tc_nu in VISCOELASTIC[dimension].get(phi, ()):
                    yield Point(dimension, phi, "viscoelastic", epsilon, tc_nu)


def points(_: int) -> Iterator[driver.Point]:
    """The rules constant and law do not depend on t_c ν: they run at the first one only."""
    for _, group in itertools.groupby(gases(), lambda point: point[:4]):
        for k, point in enumerate(group):
            if k == 0:
                yield *point, "constant" if point.law == "linear" else "law"
            for model in ("newton", "tc", "soft"):
                yield *point, model


# --- runs ---------------------------------------------------------------------------------------------------


def enskog(system: hl.ParticleSystem) -> float:
    """Enskog's collision rate [1/s] of the start."""
    gas = theory.Gas(system.n, RADIUS, float(system.mass[0]), float(np.prod(system.box)), system.dimension)
    return float(gas.collision_rate(system.granular_temperature))


def law_of(point: Point, system: hl.ParticleSystem) -> hl.Law:
    """The law with this ε and t_c ν at the mean impact speed of the start."""
    wanted = point.tc_nu / enskog(system)
    speed = math.sqrt(math.pi * system.granular_temperature)
    ball = hl.Ball(RADIUS, density=DENSITY)
    if point.law == "linear":
        return driver.linear_law(point.restitution, ball, wanted)
    law = viscoelastic(point.restitution, speed)
    return law.replace(youngs_modulus=1e7 * (law.between(ball, ball).duration(speed) / wanted) ** 2.5)


def viscoelastic(restitution: float, speed: float) -> hl.Viscoelastic:
    return hl.Viscoelastic(youngs_modulus=1e7, poisson_ratio=0.3, restitution=restitution, impact_speed=speed)


def until(point: Point, system: hl.ParticleSystem, slower: float) -> float:
    """Time [s] at which Haff's law reaches the end of the window, times a factor."""
    rate = enskog(system) * (1.0 - point.restitution**2) / (2.0 * point.dimension)
    return slower * (point.energies[1] - 1.0) / rate


def measured(point: Point, system: hl.ParticleSystem, result: Any) -> dict[str, Any]:
    """Time, collisions and means over the window; empty if the run ended before."""
    series, begin = result.series, system.granular_temperature
    total = 0.5 * point.dimension * float(system.mass.sum()) * begin
    y = np.sqrt(total / (total - series["dissipated_energy"].values))
    if not y[-1] >= point.energies[1]:
        return {}
    inside, common = within(series, y, point.energies)
    middle = np.sqrt(y[1:] * y[:-1])

    def mean(values: Any) -> float:
        return float(np.average(values, weights=inside))

    rate, pressure = (series[name].values[1:] for name in ("collision_rate", "pressure"))
    temperature = series["granular_temperature"].values
    ideal = float(system.mass.sum()) / float(np.prod(system.box)) * begin
    return {
        **common,
        "collision_rate": mean(rate * middle),  # at E(0)
        "pressure": mean(pressure * middle**2) / ideal,
        "temperature": mean(0.5 * (temperature[1:] + temperature[:-1]) * middle**2) / begin,
        "largest_compression": result.largest_compression,
    }


def within(series: xr.Dataset, y: Any, ends: tuple[float, float]) -> tuple[Any, dict[str, float]]:
    """The time of each sample inside the window, and duration and collisions between two values of y."""
    time = series["time"].values
    began, ended = np.interp(ends, y, time)
    inside = np.clip(np.minimum(time[1:], ended) - np.maximum(time[:-1], began), 0.0, None)
    hits = np.concatenate([[0.0], np.cumsum(series["collision_rate"].values[1:] * np.diff(time))])
    collisions = float(np.diff(np.interp([began, ended], time, hits))[0])
    return inside, {"duration": float(ended - began), "collisions": collisions}


@cache
def relaxed(dimension: int, phi: float) -> hl.ParticleSystem:
    random = hl.ParticleSystem.random(N, phi, RADIUS, DENSITY, RMS_SPEED, dimension=dimension)
    return equilibrated(random, 0, collisions=RELAXATION)


@lru_cache(maxsize=1)
def start(dimension: int, phi: float, replica: int) -> hl.ParticleSystem:
    return equilibrated(relaxed(dimension, phi), replica)


def run(of: driver.Point, replica: int) -> dict[str, Any]:
    """One run, longer if the window has not ended."""
    point, model = Point(*of[:-1]), of[-1]
    system = start(point.dimension, point.packing_fraction, replica)
    law = law_of(point, system)
    for slower in (1.12, 1.5, 2.5):
        end = until(point, system, slower)
        if model == "newton":
            result: Any = hl.molecular_dynamics(system, law=law, until=end, engine="events", samples=SAMPLES)
        else:
            rule: dict[str, Any] = {"law": law, "rule": model}
            if point.law == "linear" and model in ("constant", "tc"):
                rule = {"restitution": point.restitution, "rule": model}
            if model == "tc":
                rule["contact_duration"] = point.tc_nu / enskog(system)
            result = hl.event_driven(system, until=end, samples=SAMPLES, **rule)
        values = measured(point, system, result)
        if values or result.outcome_name != "ok":
            break
    return values


# --- results ------------------------------------------------------------------------------------------------


def gather(runs: list[driver.Run]) -> xr.Dataset:
    """Every replica of every point, NaN where a run ended early.

    The runs of the rules constant and law, which do not depend on t_c ν, are those of the rule law at each t_c ν.
    """
    known = sorted({Point(*run["point"][:-1]) for run in runs if run["point"][-1] == "newton"})
    placed = []
    for run in runs:
        *of, model = run["point"]
        common = model in ("constant", "law")
        for point in known:
            if point[:4] == tuple(of[:4]) and (common or point.tc_nu == of[4]):
                placed.append(run | {"point": (*point, "law" if common else model)})
    return driver.listed(placed, known, MODELS, MEASURED)


def mean_tc_nu(point: Point) -> float:
    """t_c ν, mean over time in the window: it falls as 1/y, for Hertz' law as y^(−4/5), and y grows linearly."""
    first, last = point.energies
    if point.law == "linear":
        return point.tc_nu * math.log(last / first) / (last - first)
    return point.tc_nu * (last**0.2 - first**0.2) / (0.2 * (last - first))


def all_points(ds: xr.Dataset) -> list[Point]:
    return driver.points_of(ds, Point)


def ratio(ds: xr.Dataset, i: int, name: str, above: str, below: str) -> Estimate[float]:
    """Relative difference of two models at a point."""
    values = ds[name].isel(point=i)
    return driver.paired(values.sel(model=above), values.sel(model=below))


def error_of_cooling(ds: xr.Dataset, i: int, rule: str) -> Estimate[float]:
    """(rate of the rule)/(rate of Newton's equations) − 1: the ratio of the times for the same loss of energy."""
    difference = ratio(ds, i, "duration", "newton", rule)
    both = np.isfinite(ds["duration"].isel(point=i).sel(model=["newton", rule]).values).all(axis=0).sum()
    error = ds.attrs[f"scatter_{int(ds['dimension'][i])}_{rule}"] / math.sqrt(max(both, 1))
    return difference._replace(error=error if math.isfinite(difference.value) else math.nan)


# --- pictures and tables ------------------------------------------------------------------------------------

LOOKS = {
    0.99: ("black", "o"),
    0.9: ("blue", "s"),
    0.8: ("green", "D"),
    0.6: ("vermillion", "^"),
    0.4: ("purple", "v"),
}
#: Largest relative standard error of the points that are drawn.
LARGEST = 0.4
#: Contact duration of Berzi & Jenkins, Soft Matter 11, 4799 (2015), (d/5)√(πρd/4k), over that of the linear spring.
BERZI_JENKINS = math.sqrt(3.0) / (5.0 * math.pi)


def luding_goldshtein(tc_nu: Any) -> Any:
    """Cooling under the rule tc over that of constant ε; Granular Matter 5, 159 (2003), X = √π t_c ν."""
    x = math.sqrt(math.pi) * tc_nu
    return np.exp(-1.268 * x + 0.01682 * x**2 - 0.0005783 * x**3 + 6.48e-6 * x**4)


def with_scatter(ds: xr.Dataset) -> xr.Dataset:
    """The data, with the :func:`scatter` of each dimension and rule as attributes."""
    every = itertools.product((2, 3), MODELS[1:])
    return ds.assign_attrs(
        {f"scatter_{dimension}_{rule}": scatter(ds, dimension, rule) for dimension, rule in every}
    )


def scatter(ds: xr.Dataset, dimension: int, rule: str) -> float:
    """Standard deviation of the error of the cooling between replicas, pooled over all points.

    It is nearly the same everywhere, because it is that of the losses in 24,000 collisions. A point has too few
    replicas for a standard error of its own.
    """
    models, squares, freedom = list(MODELS), 0.0, 0
    for values in ds["duration"].values[ds["dimension"].values == dimension].astype(float):
        pair = values[[models.index("newton"), models.index(rule)]]
        pair = pair[:, np.isfinite(pair).all(axis=0)]
        if pair.shape[1] >= 3:
            residual = (pair[0] - pair[0].mean() / pair[1].mean() * pair[1]) / pair[1].mean()
            squares, freedom = squares + float(residual @ residual), freedom + pair.shape[1] - 1
    return math.sqrt(squares / freedom) if freedom else math.nan


def coefficients(ds: xr.Dataset, rule: str) -> dict[tuple[int, str, float, float], Estimate[float]]:
    """a over (dimension, law, φ, ε): mean of all t_c ν, weighted by the inverse squares of the errors."""
    slopes: dict[tuple[int, str, float, float], list[tuple[float, float]]] = {}
    for i, point in enumerate(all_points(ds)):
        error, tc_nu = error_of_cooling(ds, i, rule), mean_tc_nu(point)
        if error.error > 0.0:
            key = (point.dimension, point.law, point.packing_fraction, point.restitution)
            slopes.setdefault(key, []).append((error.value / tc_nu, error.error / tc_nu))
    means = {}
    for key, values in slopes.items():
        a, sigmas = np.array(values).T
        weight = sigmas**-2.0
        sigma = float(weight.sum() ** -0.5)
        means[key] = Estimate(float((a * weight).sum() / weight.sum()), sigma, math.nan, math.nan)
    return means


def draw(ds: xr.Dataset) -> Mapping[str, Figure]:
    ds = with_scatter(ds)
    return {"error_law.png": of_packing(ds), "error_law_rules.png": of_rules(ds)}


def tables(ds: xr.Dataset) -> str:
    ds = with_scatter(ds)
    return "\n\n".join((table(ds), beside(ds), other_rules(ds), agreement(ds)))


def of_packing(ds: xr.Dataset) -> Figure:
    """a over φ for spheres and disks under the linear law: points and theory."""
    measured = coefficients(ds, "law")
    with style():
        figure = Figure(figsize=(PAGE_WIDTH, 3.6))
        for dimension, ax in zip((3, 2), figure.subplots(1, 2), strict=True):
            thin, dense = error_law.MEASURED_PACKING[dimension]
            phi = np.geomspace(0.85 * thin, 1.06 * dense, 80)
            for shift, (epsilon, (name, marker)) in enumerate(LOOKS.items()):
                if epsilon < error_law.MEASURED_RESTITUTION[dimension]:
                    continue
                colour = PALETTE[name]
                law = [
                    hl.error_law(packing_fraction=float(x), restitution=epsilon, dimension=dimension)
                    for x in phi
                ]
                ax.plot(phi, [gas.coefficient for gas in law], c=colour, lw=1.0)
                at = [key for key in measured if (key[0], key[1], key[3]) == (dimension, "linear", epsilon)]
                x = np.array([key[2] for key in at]) * 1.025 ** (shift - 2)
                y, error = np.reshape([measured[key][:2] for key in at], (-1, 2)).T
                known = error < LARGEST * y
                x, y, error = x[known], y[known], error[known]
                ax.errorbar(x, y, error, fmt=marker, ms=3.5, c=colour, elinewidth=0.9, label=f"{epsilon:g}")
            if dimension == 3:
                level = BERZI_JENKINS + 0.75 / dimension
                ax.axhline(level, color=GREY, lw=1.0, ls=(0, (4, 2)))
                ax.text(0.018, 1.04 * level, "Berzi & Jenkins", color=GREY, va="bottom", fontsize=9)
            ax.set_xscale("log")
            ax.set_yscale("log")
            ax.set_xlim(0.8 * thin, 1.12 * dense)
            ticks = [0.02, 0.05, 0.1, 0.2, 0.5] if dimension == 3 else [0.05, 0.1, 0.2, 0.4, 0.7]
            ax.set_xticks(ticks, [f"{x:g}" for x in ticks])
            ax.set_xticks([], minor=True)
            ax.set_yticks([0.2, 0.5, 1.0, 2.0], ["0.2", "0.5", "1", "2"])
            ax.set_yticks([], minor=True)
            ax.set_ylim(0.1, 5.0)
            ax.set_xlabel(r"packing fraction $\phi$")
            ax.set_title("spheres" if dimension == 3 else "disks")
            if dimension == 3:
                ax.set_ylabel(r"$a$ = error of the cooling / $t_c\nu$")
                ax.legend(title=r"$\varepsilon$")
    return figure


RULE_LOOKS = {
    "law": ("blue", "o", "constant, law"),
    "tc": ("vermillion", "s", "tc"),
    "soft": ("green", "^", "soft"),
}
#: The gas of the first panel of :func:`of_rules`.
SHOWN = (3, 0.2, "linear", 0.9)
DOTS: dict[str, Any] = {"ms": 4, "elinewidth": 0.9}


def over_tc_nu(ds: xr.Dataset, gas: tuple[Any, ...], of: Callable[[int], Estimate[float]]) -> Any:
    """t_c ν of the points of a gas, and a value of each with its standard error."""
    rows = [(mean_tc_nu(point), *of(i)[:2]) for i, point in enumerate(all_points(ds)) if point[:4] == gas]
    return np.reshape(rows, (-1, 3)).T


def of_rules(ds: xr.Dataset) -> Figure:
    """Error of each rule over t_c ν in one gas, and the cooling under tc beside the published formula."""
    with style():
        figure = Figure(figsize=(PAGE_WIDTH, 3.4))
        left, right = figure.subplots(1, 2)
        _rules_of_one_gas(left, ds)
        _cooling_under_tc(right, ds)
    return figure


def _rules_of_one_gas(ax: Axes, ds: xr.Dataset) -> None:
    at = np.geomspace(4e-3, 0.4, 100)
    dimension, phi, _, epsilon = SHOWN
    for rule, (name, marker, label) in RULE_LOOKS.items():
        law = hl.error_law(packing_fraction=phi, restitution=epsilon, dimension=dimension, rule=rule)
        ax.plot(at, [100.0 * abs(law.error(float(x))) for x in at], c=PALETTE[name], lw=1.0)
        x, value, error = over_tc_nu(ds, SHOWN, lambda i, rule=rule: error_of_cooling(ds, i, rule))
        ax.errorbar(x, 100 * np.abs(value), 100 * error, fmt=marker, c=PALETTE[name], label=label, **DOTS)
    ax.plot(
        at,
        100.0 * (BERZI_JENKINS + 0.75 / dimension) * at,
        c=GREY,
        lw=1.0,
        ls=(0, (4, 2)),
        label="Berzi & Jenkins",
    )
    ax.axhline(1.0, color=GREY, lw=0.7, ls=":")
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_xlim(at[0], at[-1])
    ax.set_ylim(0.03, 60.0)
    ax.set_xticks([0.01, 0.1], ["0.01", "0.1"])
    ax.set_yticks([0.1, 1.0, 10.0], ["0.1", "1", "10"])
    ax.set_xlabel(r"$t_c\nu$")
    ax.set_ylabel("|error of the cooling| [%]")
    ax.set_title(rf"spheres, $\phi$ = {phi:g}, $\varepsilon$ = {epsilon:g}")
    ax.legend()


def _cooling_under_tc(ax: Axes, ds: xr.Dataset) -> None:
    at = np.linspace(0.0, 0.33, 100)
    ax.plot(at, luding_goldshtein(at), c="black", lw=1.0, ls=(0, (4, 2)), label="Luding & Goldshtein (2003)")
    looks = zip((0.05, 0.2, 0.5), ("green", "blue", "vermillion"), ("v", "o", "s"), strict=True)
    for phi, name, marker in looks:
        decay = hl.error_law(packing_fraction=phi, restitution=0.99, rule="tc").decay
        ax.plot(at, np.exp(-decay * at), c=PALETTE[name], lw=1.0)
        gas = (3, phi, "linear", 0.99)
        x, value, error = over_tc_nu(ds, gas, lambda i: ratio(ds, i, "duration", "law", "tc"))
        label = rf"$\phi$ = {phi:g}"
        ax.errorbar(x, 1.0 + value, error, fmt=marker, c=PALETTE[name], label=label, **DOTS)
    ax.set_xlim(0.0, 0.33)
    ax.set_ylim(0.4, 1.02)
    ax.set_xlabel(r"$t_c\nu$")
    ax.set_ylabel("cooling, tc / constant")
    ax.set_title(r"rule tc, spheres, $\varepsilon$ = 0.99")
    ax.legend()


def by_law(point: Point, rule: str) -> hl.ErrorLaw:
    return hl.error_law(
        packing_fraction=point.packing_fraction,
        restitution=point.restitution,
        dimension=point.dimension,
        rule=rule,
        law=None if point.law == "linear" else viscoelastic(0.9, 1.0),  # only its exponents matter
    )


def agreement(ds: xr.Dataset) -> str:
    """χ² of the law for each rule, with the errors of both, and the number of measured values."""
    lines = []
    for rule in MODELS[1:]:
        deviations = []
        for i, point in enumerate(all_points(ds)):
            error, law, at = error_of_cooling(ds, i, rule), by_law(point, rule), mean_tc_nu(point)
            if error.error > 0.0:
                deviations.append((error.value - law.error(at)) / math.hypot(error.error, law.error_bar(at)))
        lines.append(f"{rule}: χ² = {np.square(deviations).sum():.0f} of {len(deviations)} values")
    return "\n".join(lines)


def _cell(error: Estimate[float], law: float, scale: float = 1.0) -> str:
    if not math.isfinite(error.value):
        return "–"
    return f"{error.value / scale:.3f}±{error.error / scale:.3f} / {law:.3f}"


def table(ds: xr.Dataset) -> str:
    """a measured / by the law over φ and ε, as Markdown: spheres, disks, and the viscoelastic law."""
    measured, parts = coefficients(ds, "law"), []
    for dimension, law_name in ((3, "linear"), (2, "linear"), (3, "viscoelastic"), (2, "viscoelastic")):
        keys = [key for key in measured if key[:2] == (dimension, law_name)]
        every = sorted({key[3] for key in keys}, reverse=True)
        rows = []
        for phi in sorted({key[2] for key in keys}):
            cells = []
            for e in every:
                law = by_law(Point(dimension, phi, law_name, e, 0.0), "law")
                a = measured.get((dimension, law_name, phi, e), driver.UNKNOWN)
                cells.append(_cell(a, law.coefficient))
            rows.append((f"{phi:g}", *cells))
        what = f"{'spheres' if dimension == 3 else 'disks'}, {law_name}: φ"
        parts.append(driver.table(" | ".join([what, *(f"ε = {e:g}" for e in every)]), rows))
    return "\n\n".join(parts)


def beside(ds: xr.Dataset) -> str:
    """Collision rate, pressure and temperature at given energy, per t_c ν: measured / theory for ε → 1."""
    rows = []
    for i, point in enumerate(all_points(ds)):
        tc_nu, gas = mean_tc_nu(point), error_law.fluid(point.dimension, point.packing_fraction)
        known = ratio(ds, i, "collision_rate", "law", "newton").error < 0.05 * tc_nu
        if point.law != "linear" or point.restitution < 0.99 or not known:
            continue
        cells = []
        for name, theory_of in BESIDE.items():
            pair = ("newton", "law") if name == "temperature" else ("law", "newton")
            cells.append(_cell(ratio(ds, i, name, *pair), theory_of(gas), tc_nu))
        rows.append((*_gas(point), f"{point.restitution:g}", f"{tc_nu:.3f}", *cells))
    return driver.table("D | φ | ε | t_c ν | collision rate | pressure | temperature", rows)


def _gas(point: Point) -> tuple[str, str]:
    return str(point.dimension), f"{point.packing_fraction:g}"


def _excess_pressure(gas: error_law.Fluid) -> float:
    """1/(2D) + (dZ/dφ)/(2^D χ Z), Z = 1 + 2^(D−1) φ χ."""
    collisional = 2 ** (gas.dimension - 1) * gas.packing_fraction * gas.contact_value
    grows = 2 ** (gas.dimension - 1) * gas.contact_value * (1.0 + gas.growth / gas.dimension)
    return 0.5 / gas.dimension + grows / (2**gas.dimension * gas.contact_value * (1.0 + collisional))


#: For ε → 1 and the linear law, per t_c ν: excess of the hard spheres' rate and pressure, deficit of Newton's T.
BESIDE = {
    "collision_rate": lambda gas: 0.25 / gas.dimension + (gas.slope + gas.growth) / gas.density,
    "pressure": _excess_pressure,
    "temperature": lambda gas: -0.5 / gas.dimension,
}


def other_rules(ds: xr.Dataset) -> str:
    """Error per t_c ν of the rules tc and soft: measured / by the law, as Markdown."""
    rows = []
    for i, point in enumerate(all_points(ds)):
        tc_nu = mean_tc_nu(point)
        errors = {rule: error_of_cooling(ds, i, rule) for rule in ("tc", "soft")}
        if errors["tc"].error < 0.1 * tc_nu:
            cells = [
                _cell(error, by_law(point, rule).error(tc_nu) / tc_nu, tc_nu)
                for rule, error in errors.items()
            ]
            rows.append((*_gas(point), point.law, f"{point.restitution:g}", f"{tc_nu:.3f}", *cells))
    return driver.table("D | φ | law | ε | t_c ν | tc | soft", rows)


STUDY = driver.Study(
    file=__file__,
    points=points,
    run=run,
    replicas=32,
    values=MEASURED,
    gather=gather,
    about={
        "title": "Cooling, collision rate, pressure and temperature at given energy, hard-sphere rules and "
        "Newton’s equations",
        "n": N,
        "window": WINDOW,
    },
    draw=draw,
    tables=tables,
)

if __name__ == "__main__":
    driver.main(STUDY, __doc__)
