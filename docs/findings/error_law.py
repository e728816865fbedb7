"""Measurement of the law of the error: the error of each hard-sphere rule in a cooling gas, divided by t_c ν.

    python docs/findings/error_law.py measure STORE [--replicas 32]
    python docs/findings/error_law.py collect STORE
    python docs/findings/error_law.py draw

``measure`` appends one line for each run to the file STORE and skips runs that are in it. ``collect`` gathers them in
error_law.nc beside this file. ``draw`` makes the figures and tables of docs/error_law.md from that file.

Every replica starts from an elastic equilibrium of equal spheres or disks in a periodic box. A run is measured while
its energy E falls from y = 3 to 9 collisions per particle by Haff's law, y = √(E(0)/E) = exp((1 − ε²) n/(2D)). E is the
energy not yet dissipated, kinetic and stored in contacts. All models are therefore compared at the same energies, after
the transient of the start.
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import hardlimit as hl
from hardlimit import plots
from hardlimit.boxes import error_law, theory
from hardlimit.fidelity_study import statistics
from hardlimit.fidelity_study.starts import equilibrated
from hardlimit.plots.style import GREY, PAGE_WIDTH, PALETTE, style
from hardlimit.support import saving
from hardlimit.support.estimate import Estimate

HERE = Path(__file__).parent
DATA = HERE / "error_law.nc"
IMAGES = HERE.parent / "images"

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
#: Replicas that are computed at all points before any point gets more.
PASS = 4
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
#: The same for the viscoelastic law. For Tsuji's law, docs/error_law.md has means only.
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


def points() -> Iterator[Point]:
    for dimension, grid in TC_NU.items():
        for phi, values in grid.items():
            for epsilon in RESTITUTION[dimension]:
                for tc_nu in values:
                    yield Point(dimension, phi, "linear", epsilon, tc_nu)
            for epsilon in VISCOELASTIC_RESTITUTION:
                for tc_nu in VISCOELASTIC[dimension].get(phi, ()):
                    yield Point(dimension, phi, "viscoelastic", epsilon, tc_nu)


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
        law = hl.LinearDashpot(stiffness=1.0, restitution=point.restitution)
        return law.replace(stiffness=(law.between(ball, ball).duration() / wanted) ** 2)
    material = {"youngs_modulus": 1e7, "poisson_ratio": 0.3, "restitution": point.restitution}
    tsuji = point.law == "tsuji"
    law = hl.Tsuji(**material) if tsuji else hl.Viscoelastic(**material, impact_speed=speed)
    return law.replace(youngs_modulus=1e7 * (law.between(ball, ball).duration(speed) / wanted) ** 2.5)


def until(point: Point, system: hl.ParticleSystem, slower: float) -> float:
    """Time [s] at which Haff's law reaches the end of the window, times a factor."""
    rate = enskog(system) * (1.0 - point.restitution**2) / (2.0 * point.dimension)
    return slower * (point.energies[1] - 1.0) / rate


def measured(point: Point, system: hl.ParticleSystem, run: Any) -> dict[str, Any]:
    """Time, collisions and means over the window; empty if the run ended before."""
    series, start = run.series, system.granular_temperature
    time = series["time"].values
    total = 0.5 * point.dimension * float(system.mass.sum()) * start
    y = np.sqrt(total / (total - series["dissipated_energy"].values))
    if not y[-1] >= point.energies[1]:
        return {}
    began, ended = np.interp(point.energies, y, time)
    middle, lasted = np.sqrt(y[1:] * y[:-1]), np.diff(time)
    inside = np.clip(np.minimum(time[1:], ended) - np.maximum(time[:-1], began), 0.0, None)

    def mean(values: Any) -> float:
        return float(np.average(values, weights=inside))

    rate, pressure = (series[name].values[1:] for name in ("collision_rate", "pressure"))
    temperature = series["granular_temperature"].values
    ideal = float(system.mass.sum()) / float(np.prod(system.box)) * start
    hits = np.concatenate([[0.0], np.cumsum(rate * lasted)])
    return {
        "duration": float(ended - began),
        "collisions": float(np.diff(np.interp([began, ended], time, hits))[0]),
        "collision_rate": mean(rate * middle),  # at E(0)
        "pressure": mean(pressure * middle**2) / ideal,
        "temperature": mean(0.5 * (temperature[1:] + temperature[:-1]) * middle**2) / start,
        "largest_compression": run.largest_compression,
        "share": run.overlapped_share if isinstance(run, hl.ContactResult) else None,
    }


def solve(point: Point, model: str, system: hl.ParticleSystem) -> dict[str, Any]:
    """One run, longer if the window has not ended."""
    law = law_of(point, system)
    for slower in (1.12, 1.5, 2.5):
        end = until(point, system, slower)
        if model == "newton":
            run: Any = hl.molecular_dynamics(system, law=law, until=end, engine="events", samples=SAMPLES)
        else:
            rule: dict[str, Any] = {"law": law, "rule": model}
            if point.law == "linear" and model in ("constant", "tc"):
                rule = {"restitution": point.restitution, "rule": model}
            if model == "tc":
                rule["contact_duration"] = point.tc_nu / enskog(system)
            run = hl.event_driven(system, until=end, samples=SAMPLES, **rule)
        found = measured(point, system, run)
        if found or run.outcome_name != "ok":
            break
    return found | {"outcome": run.outcome_name}


def models(point: Point, first: bool) -> Iterator[str]:
    """The models of a point. The rules constant and law do not depend on t_c ν: they run at the first one only."""
    if first:
        yield "constant" if point.law == "linear" else "law"
    yield from ("newton", "tc", "soft")


def measure(arguments: argparse.Namespace) -> None:
    warnings.simplefilter("ignore", hl.CompressionWarning)
    done = set()
    if arguments.store.exists():
        for line in arguments.store.read_text().splitlines():
            one = json.loads(line)
            done.add((*one["point"], one["model"], one["replica"]))
    with arguments.store.open("a", buffering=1) as out:
        for first in range(0, arguments.replicas, PASS):
            of_pass(range(first, min(first + PASS, arguments.replicas)), done, out)


def of_pass(replicas: range, done: set[Any], out: Any) -> None:
    gas, starts, before = None, {}, None
    for point in points():
        if gas != point[:2]:
            gas, starts = point[:2], {}
            random = hl.ParticleSystem.random(
                N, point.packing_fraction, RADIUS, DENSITY, RMS_SPEED, dimension=point.dimension
            )
            relaxed = equilibrated(random, 0, collisions=RELAXATION)
        for model in models(point, before is None or before[:4] != point[:4]):
            for k in replicas:
                if (*point, model, k) in done:
                    continue
                if k not in starts:
                    starts[k] = equilibrated(relaxed, k)
                found = solve(point, model, starts[k])
                out.write(json.dumps({"point": point, "model": model, "replica": k} | found) + "\n")
        before = point
    print("replicas", replicas, flush=True)


# --- results ------------------------------------------------------------------------------------------------


def collect(arguments: argparse.Namespace) -> None:
    """Store every replica of every point, NaN where a run ended early.

    The rules constant and law do not depend on t_c ν; their runs, of a point's rule law, are repeated at each t_c ν.
    """
    runs: dict[tuple[Point, str], dict[int, dict[str, Any]]] = {}
    for line in arguments.store.read_text().splitlines():
        one = json.loads(line)
        runs.setdefault((Point(*one["point"]), one["model"]), {})[one["replica"]] = one
    found = sorted({point for point, model in runs if model == "newton"})
    for point in found:
        for other, model in list(runs):
            if model in ("constant", "law") and other[:4] == point[:4]:
                runs[point, "law"] = runs[other, model]
    replicas = 1 + max(k for of_point in runs.values() for k in of_point)
    shape = (len(found), len(MODELS), replicas)
    data = {name: np.full(shape, math.nan, np.float32) for name in MEASURED}
    for (i, point), (j, model) in itertools.product(enumerate(found), enumerate(MODELS)):
        for k, one in runs.get((point, model), {}).items():
            for name in MEASURED:
                value = one.get(name)
                data[name][i, j, k] = math.nan if value is None else value
    coordinates: dict[str, Any] = {
        name: ("point", [getattr(point, name) for point in found]) for name in Point._fields
    }
    ds = xr.Dataset(
        {
            name: (("point", "model", "replica"), values, {"units": unit, "long_name": meaning})
            for (name, values), (unit, meaning) in zip(data.items(), MEASURED.values(), strict=True)
        },
        coordinates | {"model": list(MODELS)},
        {
            "title": "Cooling, collision rate, pressure and temperature at given energy, hard-sphere rules and "
            "Newton’s equations",
            "source": f"hardlimit {hl.__version__}, docs/findings/error_law.py",
            "n": N,
            "window": WINDOW,
        },
    )
    saving.dataset(ds, DATA)


def mean_tc_nu(point: Point) -> float:
    """t_c ν, mean over time in the window: it falls as 1/y, for Hertz' law as y^(−4/5), and y grows linearly."""
    first, last = point.energies
    if point.law == "linear":
        return point.tc_nu * math.log(last / first) / (last - first)
    return point.tc_nu * (last**0.2 - first**0.2) / (0.2 * (last - first))


def all_points(ds: xr.Dataset) -> list[Point]:
    columns = [ds[name].values.tolist() for name in Point._fields]
    return [Point(*row) for row in zip(*columns, strict=True)]


def ratio(ds: xr.Dataset, i: int, name: str, above: str, below: str) -> Estimate[float]:
    """Relative difference of two models at a point, paired by replica; NaN with fewer than three replicas."""
    values = ds[name].isel(point=i)
    pair = np.array([values.sel(model=model).values for model in (above, below)], float)
    pair = pair[:, np.isfinite(pair).all(axis=0)]
    if pair.shape[1] < 3:
        return Estimate(*(math.nan,) * 4)
    return Estimate(*(float(part) for part in statistics.relative_difference(*pair)))


def error_of_cooling(ds: xr.Dataset, i: int, rule: str) -> Estimate[float]:
    """(rate of the rule)/(rate of Newton's equations) − 1: the ratio of the times for the same loss of energy."""
    found = ratio(ds, i, "duration", "newton", rule)
    both = np.isfinite(ds["duration"].isel(point=i).sel(model=["newton", rule]).values).all(axis=0).sum()
    error = ds.attrs[f"scatter_{int(ds['dimension'][i])}_{rule}"] / math.sqrt(max(both, 1))
    return found._replace(error=error if math.isfinite(found.value) else math.nan)


def hard_over_enskog(ds: xr.Dataset, i: int, point: Point) -> Estimate[float]:
    """h: cooling of hard spheres over Enskog's, both over the window."""
    taken = ds["duration"].isel(point=i).sel(model="law").values
    taken = taken[np.isfinite(taken)].astype(float)
    if len(taken) < 3:
        return Estimate(*(math.nan,) * 4)
    first, last = point.energies
    lost = (1.0 - point.restitution**2) / (2.0 * point.dimension)
    expected = (last - first) / (lost * rate_of(point))
    value, error = expected / taken.mean(), taken.std(ddof=1) / math.sqrt(len(taken)) / taken.mean()
    return Estimate(value, error * value, math.nan, math.nan)


def rate_of(point: Point) -> float:
    """Enskog's rate of the start [1/s]; ⟨v²⟩ = D T is RMS_SPEED²."""
    gas = error_law.fluid(point.dimension, point.packing_fraction)
    temperature = RMS_SPEED**2 / point.dimension
    return gas.density * math.sqrt(temperature / math.pi) / (2.0 * RADIUS)


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


def opened() -> xr.Dataset:
    """The data, with the :func:`scatter` of each dimension and rule as attributes."""
    ds = xr.open_dataset(DATA).load()
    for dimension, rule in itertools.product((2, 3), MODELS[1:]):
        ds.attrs[f"scatter_{dimension}_{rule}"] = scatter(ds, dimension, rule)
    return ds


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
    found: dict[tuple[int, str, float, float], list[tuple[float, float]]] = {}
    for i, point in enumerate(all_points(ds)):
        one, tc_nu = error_of_cooling(ds, i, rule), mean_tc_nu(point)
        if one.error > 0.0:
            key = (point.dimension, point.law, point.packing_fraction, point.restitution)
            found.setdefault(key, []).append((one.value / tc_nu, one.error / tc_nu))
    means = {}
    for key, values in found.items():
        a, error = np.array(values).T
        weight = error**-2.0
        sigma = float(weight.sum() ** -0.5)
        means[key] = Estimate(float((a * weight).sum() / weight.sum()), sigma, math.nan, math.nan)
    return means


def draw(_: argparse.Namespace) -> None:
    ds = opened()
    print(plots.save(of_packing(ds), IMAGES / "error_law.png", 150))
    print(plots.save(of_rules(ds), IMAGES / "error_law_rules.png", 150))
    for text in (table(ds), beside(ds), other_rules(ds), agreement(ds)):
        print(f"\n{text}")


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
                ax.plot(phi, [one.coefficient for one in law], c=colour, lw=1.0)
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
        points = [
            (mean_tc_nu(point), *error_of_cooling(ds, i, rule)[:2])
            for i, point in enumerate(all_points(ds))
            if point[:4] == SHOWN
        ]
        x, value, error = np.reshape(points, (-1, 3)).T
        ax.errorbar(
            x,
            100 * np.abs(value),
            100 * error,
            fmt=marker,
            ms=4,
            c=PALETTE[name],
            elinewidth=0.9,
            label=label,
        )
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
        points = [
            (mean_tc_nu(point), *ratio(ds, i, "duration", "law", "tc")[:2])
            for i, point in enumerate(all_points(ds))
            if point[:4] == (3, phi, "linear", 0.99)
        ]
        x, value, error = np.reshape(points, (-1, 3)).T
        ax.errorbar(
            x,
            1.0 + value,
            error,
            fmt=marker,
            ms=4,
            c=PALETTE[name],
            elinewidth=0.9,
            label=rf"$\phi$ = {phi:g}",
        )
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
        law=law_object(point.law),
    )


def agreement(ds: xr.Dataset) -> str:
    """χ² of the law for each rule, with the errors of both, and the number of measured values."""
    lines = []
    for rule in MODELS[1:]:
        deviations = []
        for i, point in enumerate(all_points(ds)):
            found, law, at = error_of_cooling(ds, i, rule), by_law(point, rule), mean_tc_nu(point)
            if found.error > 0.0:
                deviations.append((found.value - law.error(at)) / math.hypot(found.error, law.error_bar(at)))
        lines.append(f"{rule}: χ² = {np.square(deviations).sum():.0f} of {len(deviations)} values")
    return "\n".join(lines)


def _cell(found: Estimate[float] | None, law: float) -> str:
    if found is None or not math.isfinite(found.value):
        return "–"
    return f"{found.value:.3f}±{found.error:.3f} / {law:.3f}".replace("-", "−")


def table(ds: xr.Dataset) -> str:
    """a measured / by the law over φ and ε, as Markdown: spheres, disks, and the viscoelastic law."""
    measured, lines = coefficients(ds, "law"), []
    for dimension, law_name in ((3, "linear"), (2, "linear"), (3, "viscoelastic"), (2, "viscoelastic")):
        keys = [key for key in measured if key[:2] == (dimension, law_name)]
        every = sorted({key[3] for key in keys}, reverse=True)
        what = f"{'spheres' if dimension == 3 else 'disks'}, {law_name}"
        lines += [
            f"| {what}: φ | " + " | ".join(f"ε = {e:g}" for e in every) + " |",
            "|" + "---|" * (1 + len(every)),
        ]
        for phi in sorted({key[2] for key in keys}):
            cells = []
            for e in every:
                law = law_object(law_name)
                expected = hl.error_law(
                    packing_fraction=phi, restitution=e, dimension=dimension, rule="law", law=law
                )
                cells.append(_cell(measured.get((dimension, law_name, phi, e)), expected.coefficient))
            lines.append(f"| {phi:g} | " + " | ".join(cells) + " |")
        lines.append("")
    return "\n".join(lines)


def law_object(name: str) -> hl.Law | None:
    """A law with the exponents of this one."""
    if name == "linear":
        return None
    material = {"youngs_modulus": 1e7, "poisson_ratio": 0.3, "restitution": 0.9}
    return hl.Tsuji(**material) if name == "tsuji" else hl.Viscoelastic(**material, impact_speed=1.0)


def beside(ds: xr.Dataset) -> str:
    """Collision rate, pressure and temperature at given energy, per t_c ν: measured / theory for ε → 1."""
    lines = [
        "| D | φ | ε | t_c ν | collision rate | pressure | temperature |",
        "|---|---|---|---|---|---|---|",
    ]
    for i, point in enumerate(all_points(ds)):
        found = ratio(ds, i, "collision_rate", "law", "newton")
        known = found.error < 0.05 * mean_tc_nu(point)
        if point.law != "linear" or point.restitution < 0.99 or not known:
            continue
        tc_nu, gas = mean_tc_nu(point), error_law.fluid(point.dimension, point.packing_fraction)
        pairs = {
            "collision_rate": ("law", "newton"),
            "pressure": ("law", "newton"),
            "temperature": ("newton", "law"),
        }
        cells = []
        for name, theory_of in BESIDE.items():
            found = ratio(ds, i, name, *pairs[name])
            scaled = Estimate(found.value / tc_nu, found.error / tc_nu, math.nan, math.nan)
            cells.append(_cell(scaled, theory_of(gas)))
        lines.append(
            f"| {point.dimension} | {point.packing_fraction:g} | {point.restitution:g} | {tc_nu:.3f} | "
            + " | ".join(cells)
            + " |"
        )
    return "\n".join(lines)


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
    lines = ["| D | φ | law | ε | t_c ν | tc | soft |", "|---|---|---|---|---|---|---|"]
    for i, point in enumerate(all_points(ds)):
        tc_nu, cells = mean_tc_nu(point), []
        for rule in ("tc", "soft"):
            found = error_of_cooling(ds, i, rule)
            law = by_law(point, rule)
            scaled = Estimate(found.value / tc_nu, found.error / tc_nu, math.nan, math.nan)
            cells.append(_cell(scaled, law.error(tc_nu) / tc_nu))
        if not error_of_cooling(ds, i, "tc").error < 0.1 * tc_nu:
            continue
        gas = f"| {point.dimension} | {point.packing_fraction:g} | {point.law} | {point.restitution:g}"
        lines.append(f"{gas} | {tc_nu:.3f} | {cells[0]} | {cells[1]} |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description="Measure the law of the error.")
    commands = parser.add_subparsers(required=True)
    command = commands.add_parser("measure")
    command.set_defaults(run=measure)
    command.add_argument("store", type=Path, help="file of the finished runs")
    command.add_argument("--replicas", type=int, default=32, help="[32]")
    command = commands.add_parser("collect")
    command.set_defaults(run=collect)
    command.add_argument("store", type=Path)
    commands.add_parser("draw").set_defaults(run=draw)
    arguments = parser.parse_args()
    arguments.run(arguments)


if __name__ == "__main__":
    main()
