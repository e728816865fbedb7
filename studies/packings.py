"""Measurement of packings of soft grains with friction: packing fraction, coordination, overlap, stress, and the
largest stable time step, over the stiffness number κ = k/(p d) (see driver.py).

Spheres of diameter 1 and mass 1, ε = 0.5, k_t = 2/7 k. ``settled``: 524 grains fall from φ = 0.5 onto a floor between
periodic sides. ``compressed``: 454 grains between two walls, one of which moves inwards. ``sheared``: 300 grains under
Lees–Edwards shear at constant volume. A run solves Newton's equations by steps of about t_c/13.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

import driver
import numpy as np
import xarray as xr
from driver import Point, Run
from matplotlib.figure import Figure

import hardlimit as hl
from hardlimit.boxes.box import Floats
from hardlimit.measure import stability
from hardlimit.plots.style import PAGE_WIDTH, PALETTE, style

RESTITUTION, POISSON = 0.5, 0.3
DENSITY: Final = 6.0 / math.pi  #: a grain has the mass 1
BALL: Final = hl.Ball(0.5, mass=1.0)
ERRORS: Final = {True: 0.05, False: 0.01}  #: accepted errors of ε and β, with and without friction
RATIOS: Final = (0.0, 2.0 / 7.0, 0.5, 1.0)  #: k_t/k for which frequencies are computed
WALLED: Final = ("periodic", "periodic", "wall")
#: Values of a run: unit, meaning. Lengths in d, masses in m, stresses in m g/d² or k/d.
VALUES: Final = {
    "packing_fraction": ("1", "packing fraction"),
    "pressure": ("1", "mean pressure"),
    "vertical": ("1", "weight per area above the middle of the layer"),
    "coordination": ("1", "mean number of contacts of a particle"),
    "mechanical": ("1", "mean number of contacts of particles with at least two"),
    "rattlers": ("1", "fraction of particles with fewer than two contacts"),
    "overlap": ("1", "mean overlap of contacts over the radius"),
    "overlap_rms": ("1", "root mean square overlap over the radius"),
    "deepest": ("1", "largest overlap over the radius"),
    "largest_coordination": ("1", "largest number of contacts of a particle"),
    "frequency": ("1", "highest angular frequency"),
    "frequency_0": ("1", "highest angular frequency over √(k/m), k_t = 0"),
    "frequency_29": ("1", "highest angular frequency over √(k/m), k_t = 2/7 k"),
    "frequency_50": ("1", "highest angular frequency over √(k/m), k_t = k/2"),
    "frequency_100": ("1", "highest angular frequency over √(k/m), k_t = k"),
    "step": ("1", "largest stable time step with dashpots over t_c = π√(m/2k)"),
    "energy": ("1", "kinetic energy at the end over N σ²d/k"),
    "stress_ratio": ("1", "shear stress over pressure"),
    "inertial_number": ("1", "inertial number"),
}
#: Replicas of each κ = k/(σ d) of the beds, σ their weight per area above half of the grains; by law and μ.
SETTLED: Final = {
    ("linear", 0.5): {1e2: 6, 10**2.5: 6, 1e3: 6, 10**3.5: 6, 1e4: 5, 1e5: 3, 1e6: 1},
    ("hertz", 0.5): {1e2: 3, 1e3: 3, 1e4: 3},
    ("linear", 0.0): {1e2: 2, 1e3: 2},
    ("linear", 0.1): {1e2: 2, 1e3: 3, 10**3.5: 3},
    ("linear", 0.2): {10**3.5: 3},
    ("linear", 0.3): {1e2: 2, 1e3: 3, 10**3.5: 3},
    ("linear", 1.0): {1e2: 2, 1e3: 3, 10**3.5: 3},
}
WIDTH, BLOCKS, LOOSE = 6.5, 2, 0.5  #: a bed starts as two cubes on each other
SETTLING: Final = (12.0, 300.0)  #: time in √(d/g) for hard grains, and the addition for soft ones times √κ
SMOOTH: Final = 4.0  #: smooth grains take this factor of time to come to rest
LAYERS: Final = (2.5, 2.0)  #: left out at the floor and at the top, in d
#: Compression at this rate of strain [√(k/m)] by this strain, and the κ at which values are interpolated.
SQUEEZED: Final = 3  #: replicas
SQUEEZE_RATE, SQUEEZE, SIDE = 5e-6, 0.108, 6.0
LEVELS: Final = (1e2, 10**2.5, 1e3, 10**3.5, 1e4)
#: Rate of shear [√(k/m)] by packing fraction.
SHEARED: Final = {0.64: 1e-3, 0.62: 7e-4, 0.605: 4e-4, 0.59: 2.7e-4, 0.584: 1.7e-4}
SHEARED_REPLICAS, SHEARED_N, STRAINS, EVERY = 2, 300, (1.0, 3.0), 0.1


def law(kind: str, mu: float, kappa: float, pressure: float) -> hl.Law:
    """The law with this stiffness number."""
    friction = hl.Friction(mu) if mu > 0.0 else None
    if kind == "linear":
        return hl.LinearDashpot(stiffness=kappa * pressure, restitution=RESTITUTION, friction=friction)
    youngs = 2.0 * (1.0 - POISSON**2) * pressure * kappa**1.5  # E* = E/(2(1 − ν²))
    return hl.Viscoelastic(
        youngs_modulus=youngs,
        poisson_ratio=POISSON,
        restitution=RESTITUTION,
        impact_speed=1.0,
        friction=friction,
    )


def blocks(count: int, side: float, fraction: float, seed: int) -> Floats:
    """Positions in cubes on each other."""
    n = round(fraction * side**3 * DENSITY)
    cubes = [
        hl.ParticleSystem.random(
            n, n / DENSITY / side**3, 0.5, DENSITY, 0.0, seed=count * seed + k, boundary=WALLED
        )
        for k in range(count)
    ]
    return np.concatenate([cube.positions + np.array([0.0, 0.0, k * side]) for k, cube in enumerate(cubes)])


def solved(
    start: hl.ParticleSystem, force: hl.Law, mu: float, until: float, samples: int
) -> tuple[Any, list[hl.ParticleSystem]]:
    """A run by steps with its states at the samples."""
    states: list[hl.ParticleSystem] = []

    def keep(_: float, system: hl.ParticleSystem) -> dict[str, float]:
        states.append(system)
        return {}

    options: Any = {"engine": "steps", "restitution_error": ERRORS[mu > 0.0], "threads": 1}
    run = hl.molecular_dynamics(start, law=force, until=until, samples=samples, observe=keep, **options)
    return run, states


# --- runs ---------------------------------------------------------------------------------------------------


def settled_weight() -> float:
    """Weight per area above half of the grains of a bed."""
    return BLOCKS * round(LOOSE * WIDTH**3 * DENSITY) / (2.0 * WIDTH**2)


def settled(kind: str, mu: float, kappa: float, replica: int) -> dict[str, Any]:
    """A bed that has come to rest under its weight."""
    at = blocks(BLOCKS, WIDTH, LOOSE, replica)
    box = [WIDTH, WIDTH, (BLOCKS + 0.1) * WIDTH]
    start = hl.ParticleSystem(at, 0.0 * at, 0.5, mass=1.0, box=box, boundary=WALLED, gravity=1.0)
    weight = settled_weight()
    force = law(kind, mu, kappa, weight)
    until = (SETTLING[0] + SETTLING[1] / math.sqrt(kappa)) * (1.0 if mu > 0.0 else SMOOTH)
    run, _ = solved(start, force, mu, until, samples=1)
    if run.outcome != "ok":
        return {}
    height = run.system.positions[:, 2]
    low, high = LAYERS[0], float(np.sort(height)[-20:].mean()) - LAYERS[1]
    above = float((height > high).sum() + 0.5 * ((height > low) & (height <= high)).sum())
    scale = start.n * weight**2 / (kappa * weight)
    return {
        **bulk(run.system, force, low, high),
        **frequencies(run.system, force),
        "vertical": above / WIDTH**2,
        "energy": float(run.series.kinetic_energy[-1]) / scale,
    }


def compressed(mu: float, replica: int) -> dict[str, list[float]]:
    """Values at each of the levels of κ while a wall moves inwards."""
    at = blocks(2, SIDE, 0.55, replica)
    height = 2.0 * SIDE
    speed = SQUEEZE_RATE * height
    flow = np.zeros_like(at)
    flow[:, 2] = -SQUEEZE_RATE * at[:, 2]
    start = hl.ParticleSystem(
        at, flow, 0.5, mass=1.0, box=[SIDE, SIDE, height], boundary=WALLED,
        walls={"z+": hl.MovingWall(velocity=-speed)},
    )  # fmt: skip
    force = law("linear", mu, 1.0, 1.0)
    run, states = solved(start, force, mu, SQUEEZE / SQUEEZE_RATE, samples=400)
    if run.outcome != "ok":
        return {}
    rows = []
    for time, state in zip(run.series.time.values, states, strict=True):
        top = height - speed * float(time)
        rows.append(bulk(state, force, 2.0, top - 2.0))
    return at_levels(rows, states, force)


def at_levels(
    rows: list[dict[str, float]], states: list[hl.ParticleSystem], force: hl.Law
) -> dict[str, list[float]]:
    """Values where κ falls below each level for the last time."""
    with np.errstate(divide="ignore"):
        stiffness = -np.log10([row["pressure"] for row in rows])
    values: dict[str, list[float]] = {}
    for level in np.log10(LEVELS):
        before = int(np.flatnonzero(stiffness >= level)[-1])
        known = before + 1 < len(rows)
        if known:
            share = (stiffness[before] - level) / (stiffness[before] - stiffness[before + 1])
        for name in rows[0]:
            pair = (rows[before][name], rows[before + 1][name]) if known else (math.nan,) * 2
            values.setdefault(name, []).append(pair[0] + share * (pair[1] - pair[0]) if known else math.nan)
        for name, value in (frequencies(states[before], force) if known else {}).items():
            values.setdefault(name, []).append(value)
    return values


def sheared(phi: float, mu: float, replica: int) -> dict[str, float]:
    """Means over the strain in steady shear."""
    rate = SHEARED[phi]
    start = hl.ParticleSystem.random(
        SHEARED_N, phi if phi < 0.6 else 0.6, 0.5, DENSITY, 0.0, seed=replica,
        boundary=("periodic", "lees-edwards", "periodic"), shear_rate=rate,
    )  # fmt: skip
    shrunk = (SHEARED_N / DENSITY / phi) ** (1.0 / 3.0) / float(start.box[0])
    start = hl.ParticleSystem(
        shrunk * start.positions, shrunk * start.velocities, 0.5, mass=1.0, box=shrunk * start.box,
        boundary=start.boundary, shear_rate=rate, allowed_overlap=0.1,
    )  # fmt: skip
    force = law("linear", mu, 1.0, 1.0)
    run, states = solved(start, force, mu, sum(STRAINS) / rate, samples=round(sum(STRAINS) / EVERY))
    if run.outcome != "ok":
        return {}
    first = round(STRAINS[0] / EVERY) + 1
    rows = [bulk(state, force) for state in states[first:]]
    means = {name: float(np.mean([row[name] for row in rows])) for name in rows[0]}
    pressure = float(run.series.pressure[first:].mean())
    return {
        **means,
        **frequencies(states[-1], force),
        "pressure": pressure,
        "stress_ratio": float(run.series.shear_stress[first:].mean()) / pressure,
        "inertial_number": rate * math.sqrt(DENSITY / pressure),
    }


# --- values of a state ----------------------------------------------------------------------------------------


def bulk(
    system: hl.ParticleSystem, force: hl.Law, low: float = -math.inf, high: float = math.inf
) -> dict[str, float]:
    """Values of the grains whose centres are between two heights; of all in a periodic box."""
    of = stability.network(system, 0.0)
    normal = np.asarray(force.between(BALL, BALL).force(of.overlap, np.zeros(len(of.overlap))))
    own = np.concatenate([np.arange(len(of.first)), np.flatnonzero(of.second >= 0)])
    ends = np.concatenate([of.first, of.second[of.second >= 0]])
    z = system.positions[:, 2]
    inside = (z >= low) & (z < high)
    volume, filled = float(np.prod(system.box)), system.n / DENSITY
    if math.isfinite(low):
        volume = float(system.box[0] * system.box[1]) * (high - low)
        filled = float(part_of_grain(high - z).sum() - part_of_grain(low - z).sum())
    at = own[inside[ends]]
    virial = 0.5 * float(((1.0 - of.overlap) * normal)[at].sum()) / volume
    counts = of.counts(system.n)[inside]
    deep = of.overlap[at] if len(at) else np.zeros(1)
    return {
        "packing_fraction": filled / volume,
        "pressure": virial / 3.0,
        "coordination": float(counts.mean()),
        "mechanical": float(counts[counts >= 2].mean()) if (counts >= 2).any() else math.nan,
        "rattlers": float((counts < 2).mean()),
        "overlap": 2.0 * float(deep.mean()),
        "overlap_rms": 2.0 * float(np.sqrt(np.mean(deep**2))),
        "deepest": 2.0 * float(deep.max()),
    }


def part_of_grain(height: Floats) -> Floats:
    """Volume of a grain at 0 below a height."""
    t = np.clip(height, -0.5, 0.5)
    volume: Floats = math.pi * (0.25 * (t + 0.5) - (t**3 + 0.125) / 3.0)
    return volume


def frequencies(system: hl.ParticleSystem, force: hl.Law) -> dict[str, float]:
    """Highest frequencies over √(k/m) for some k_t/k, and the largest stable step with dashpots over t_c."""
    own = hl.measure.largest_stable_time_step(system, force, tolerance=0.0)
    values = {name: float(own[name]) for name in ("frequency", "largest_coordination")}
    if not isinstance(force, hl.LinearDashpot):
        return values
    k = float(force.parameters["stiffness"])
    for ratio in RATIOS:
        friction = hl.Friction(0.5, stiffness_ratio=ratio) if ratio else None
        smooth = hl.LinearDashpot(stiffness=k, damping=0.0, friction=friction)
        here = hl.measure.largest_stable_time_step(system, smooth, tolerance=0.0)
        values[f"frequency_{100.0 * ratio:.0f}"] = float(here.frequency) / math.sqrt(k)
    return values | {"step": float(own.time_step) * math.sqrt(2.0 * k) / math.pi}


# --- grid -----------------------------------------------------------------------------------------------------


def points(replica: int) -> Iterator[Point]:
    if replica < SQUEEZED:
        yield "compressed", 0.5
    for (kind, mu), levels in SETTLED.items():
        for kappa, replicas in levels.items():
            if replica < replicas:
                yield "settled", kind, mu, kappa
    for phi in SHEARED if replica < SHEARED_REPLICAS else ():
        yield "sheared", phi, 0.5


def run(point: Point, replica: int) -> dict[str, Any]:
    """The values of one run; none if it ended early."""
    test: Any = {"settled": settled, "compressed": compressed, "sheared": sheared}[point[0]]
    values: dict[str, Any] = test(*point[1:], replica)
    return values


def axes() -> dict[str, dict[str, Sequence[Any]]]:
    """The axes of each test."""
    levels = sorted({level for levels in SETTLED.values() for level in levels})
    return {
        "settled": {
            "law": ["linear", "hertz"],
            "friction": sorted({mu for _, mu in SETTLED}),
            "kappa": levels,
        },
        "compressed": {"level": list(LEVELS)},
        "sheared": {"fraction": sorted(SHEARED)},
    }


def gather(runs: list[Run]) -> xr.Dataset:
    """The values of each test over its axes and the replicas; names begin with the test."""
    places: dict[str, Any] = {
        "settled": lambda kind, mu, kappa: (kind, mu, kappa),
        "compressed": lambda mu: (None,),  # a run has the values at all levels
        "sheared": lambda phi, mu: (phi,),
    }
    tests = []
    for test, levels in axes().items():
        own = [run | {"point": places[test](*run["point"][1:])} for run in runs if run["point"][0] == test]
        if own:
            part = driver.gathered(dataclasses.replace(STUDY, axes=lambda levels=levels: levels), own)
            known = [name for name in part.data_vars if part[name].notnull().any()]
            part = part[known].assign_coords(replica=range(part.sizes["replica"]))
            tests.append(part.rename({name: f"{test}_{name}" for name in known}))
    return xr.merge(tests, join="outer")


# --- results --------------------------------------------------------------------------------------------------

#: ω²m/k of a packing as the larger of two lines in k_t/k: intercept, slope.
BRANCHES: Final = ((5.7, 4.5), (0.0, 23.0))


def of_test(ds: xr.Dataset, test: str, **place: Any) -> xr.Dataset:
    """The values of one test, with κ_p = k/(p d) at the pressure of each state, or (E*/p)^(2/3)."""
    names = {name: str(name).removeprefix(f"{test}_") for name in ds.data_vars if str(name).startswith(test)}
    here = ds[list(names)].rename(names).sel(place)
    power = 2.0 / 3.0 if place.get("law") == "hertz" else 1.0
    softest = here.kappa * settled_weight() ** power if test == "settled" else 1.0
    return here.assign(stiffness=softest / here.pressure**power)


def beds(ds: xr.Dataset, law: str = "linear", friction: float = 0.5) -> xr.Dataset:
    here = of_test(ds, "settled", law=law, friction=friction)
    return here.dropna("kappa", how="all", subset=["pressure"])


def trend(here: xr.Dataset, name: str, power: float) -> tuple[Floats, Floats]:
    """Limit of hard grains and slope over κ_p^−power of a value, with their standard errors; over all runs.

    The levels of a compression are the same sample: each replica is fitted, and the error is that of their mean.
    """
    samples = (
        [here.isel(replica=[k]) for k in range(here.sizes["replica"])] if "level" in here.dims else [here]
    )
    fits = []
    for sample in samples:
        x, y = sample.stiffness.values.ravel() ** -power, sample[name].values.ravel()
        known = np.isfinite(x) & np.isfinite(y)
        if known.sum() > 2:
            fits.append(np.polynomial.polynomial.polyfit(x[known], y[known], 1, full=False))
            design = np.stack([np.ones(known.sum()), x[known]], axis=1)
            residual = y[known] - design @ fits[-1]
            covariance = np.linalg.inv(design.T @ design) * float(residual @ residual) / (known.sum() - 2)
    best = np.mean(fits, axis=0)
    if len(samples) == 1:
        return best, np.sqrt(np.diag(covariance))
    return best, np.std(fits, axis=0, ddof=1) / math.sqrt(len(fits)) if len(fits) > 1 else np.full(
        2, math.nan
    )


def tables(ds: xr.Dataset) -> str:
    parts = (of_settled, of_compressed, of_sheared, of_steps, of_frequencies, of_trends)
    return "\n\n".join(part(ds) for part in parts)


def shown(values: xr.DataArray, digits: int, scale: float = 1.0) -> str:
    """Mean ± error over the replicas; of one replica its value."""
    known = scale * values.dropna("replica")
    if not known.size:
        return "–"
    value, error = float(known.mean()), driver.mean(known)[1]
    return f"{value:.{digits}f}" + ("" if math.isnan(error) else f"±{error:.{digits}f}")


def rounded(stiffness: xr.DataArray) -> str:
    """The mean with three digits."""
    mean = float(stiffness.mean())
    return "–" if math.isnan(mean) else f"{float(f'{mean:.3g}'):.0f}"


def of_equal_forces(at: xr.Dataset, law: str = "linear") -> xr.DataArray:
    """κ_p δ/R if all contacts of a packing bore the mean force πpd²/(φz)."""
    force = math.pi / (at.packing_fraction * at.coordination)
    return 2.0 * force if law == "linear" else 2.0 * (1.5 * force) ** (2.0 / 3.0)


def of_settled(ds: xr.Dataset) -> str:
    rows = []
    for kind, mu in SETTLED:
        here = beds(ds, kind, mu)
        for kappa in here.kappa.values:
            at = here.sel(kappa=kappa)
            rows.append(
                (kind, mu, rounded(at.stiffness), shown(at.packing_fraction, 4),
                 shown(at.coordination, 2), shown(at.overlap, 4, 100.0), shown(at.overlap * at.stiffness, 2),
                 shown(of_equal_forces(at, kind), 2), shown(at.deepest / at.overlap, 1),
                 shown(at.pressure / at.vertical, 2))
            )  # fmt: skip
    head = "law | μ | κ_p | φ | z | δ/R [%] | κ_p δ/R | of equal forces | deepest/mean | p/σ"
    return driver.table(head, rows)


def of_compressed(ds: xr.Dataset) -> str:
    here = of_test(ds, "compressed")
    rows = [
        (rounded(at.stiffness), shown(at.packing_fraction, 4), shown(at.coordination, 2), shown(at.mechanical, 2),
         shown(at.rattlers, 1, 100.0), shown(at.overlap, 3, 100.0), shown(at.overlap * at.stiffness, 2),
         shown(of_equal_forces(at), 2), shown(at.deepest / at.overlap, 1))
        for level in here.level.values for at in [here.sel(level=level)]
    ]  # fmt: skip
    head = (
        "κ_p | φ | z | z without rattlers | rattlers [%] | δ/R [%] | κ_p δ/R | of equal forces | deepest/mean"
    )
    return driver.table(head, rows)


def of_sheared(ds: xr.Dataset) -> str:
    here = of_test(ds, "sheared")
    rows = [
        (phi, rounded(at.stiffness), shown(at.inertial_number, 4), shown(at.coordination, 2),
         shown(at.mechanical, 2), shown(at.rattlers, 1, 100.0), shown(at.overlap, 3, 100.0),
         shown(at.overlap * at.stiffness, 2), shown(at.stress_ratio, 3))
        for phi in here.fraction.values for at in [here.sel(fraction=phi)]
    ]  # fmt: skip
    head = "φ | κ_p | I | z | z without rattlers | rattlers [%] | δ/R [%] | κ_p δ/R | stress/p"
    return driver.table(head, rows)


def spread(values: xr.DataArray, digits: int) -> str:
    known = values.values[np.isfinite(values.values)]
    if not known.size:
        return "–"
    return f"{known.mean():.{digits}f} ({known.min():.{digits}f} to {known.max():.{digits}f})"


def of_steps(ds: xr.Dataset) -> str:
    rows = []
    tests = (
        ("settled", beds(ds)),
        ("settled, μ = 0", beds(ds, friction=0.0)),
        ("compressed", of_test(ds, "compressed")),
        ("sheared", of_test(ds, "sheared")),
    )
    for name, here in tests:
        rows.append(
            (name, spread(here.coordination, 1), spread(here.largest_coordination, 0),
             *(spread(here[f"frequency_{100.0 * ratio:.0f}"], 2) for ratio in RATIOS), spread(here.step, 3))
        )  # fmt: skip
    head = "test | z | largest z | " + " | ".join(f"k_t = {ratio:.2g} k" for ratio in RATIOS) + " | step/t_c"
    hertz = beds(ds, "hertz")
    youngs = 2.0 * (1.0 - POISSON**2) * settled_weight() * hertz.kappa**1.5
    rayleigh = math.pi * 0.5 * np.sqrt(DENSITY * 2.0 * (1.0 + POISSON) / youngs) / (0.1631 * POISSON + 0.8766)
    steps = 2.0 / hertz.frequency / rayleigh
    lines = [
        (rounded(hertz.stiffness.sel(kappa=kappa)), spread(steps.sel(kappa=kappa), 3),
         spread((steps / hertz.stiffness**0.25).sel(kappa=kappa), 4))
        for kappa in hertz.kappa.values
    ]  # fmt: skip
    return driver.table(head, rows) + "\n\n" + driver.table("κ_p | step/Rayleigh | over κ_p^(1/4)", lines)


def of_frequencies(ds: xr.Dataset) -> str:
    """Lines through ω² over the coordination number, of all tests."""
    tests = (beds(ds), beds(ds, friction=0.0), of_test(ds, "compressed"), of_test(ds, "sheared"))
    lines = []
    for ratio, of in ((0.0, "k/m"), (2.0 / 7.0, "k/m"), (1.0, "k_t/m, k_t ≥ k/2")):
        z, square = (
            np.concatenate([test[name].values.ravel() for test in tests])
            for name in ("coordination", f"frequency_{100.0 * ratio:.0f}")
        )
        known = np.isfinite(z) & np.isfinite(square)
        z, square = z[known], square[known] ** 2
        slope, limit = np.polyfit(z, square, 1)
        scatter = float(np.std(square / (limit + slope * z)))
        lines.append(
            f"ω² = ({limit:.2f} + {slope:.2f} z) {of} at k_t = {ratio:.2g} k, ± {100.0 * scatter:.1f} %"
        )
    return "\n".join(lines)


def of_trends(ds: xr.Dataset) -> str:
    lines = []
    for name, here in (
        ("settled", beds(ds)),
        ("settled, Hertz", beds(ds, "hertz")),
        ("compressed", of_test(ds, "compressed")),
    ):
        for value, power in (("packing_fraction", 1.0), ("mechanical", 0.5)):
            (limit, slope), (limit_error, slope_error) = trend(here, value, power)
            share, share_error = slope / limit, abs(slope_error / limit)
            lines.append(
                f"{name}: {value} {limit:.4f}±{limit_error:.4f}, relative change ({share:.2f}±{share_error:.2f}) "
                f"κ_p^−{power:g}, 1 % at κ_p = {(abs(share) / 0.01) ** (1.0 / power):.3g}"
            )
    return "\n".join(lines)


#: Name, law, μ, colour and marker of the beds.
BEDS: Final = (
    ("bed", "linear", 0.5, "blue", "o"),
    ("bed, Hertz", "hertz", 0.5, "vermillion", "s"),
    ("bed, μ = 0", "linear", 0.0, "green", "^"),
)


def draw(ds: xr.Dataset) -> Mapping[str, Figure]:
    """Overlap, packing fraction and coordination over κ_p, and the largest stable time step over k_t/k."""
    tests = [(name, beds(ds, kind, mu), "kappa", color, marker) for name, kind, mu, color, marker in BEDS]
    tests.append(("compressed", of_test(ds, "compressed"), "level", "purple", "D"))
    tests.append(("sheared", of_test(ds, "sheared"), "fraction", "orange", "v"))
    with style():
        figure = Figure(figsize=(PAGE_WIDTH, 5.4), layout="constrained")
        (overlap, packing), (contacts, step) = figure.subplots(2, 2)
        for ax, value, scale in ((overlap, "overlap", 100.0), (packing, "packing_fraction", 1.0)):
            points_of(ax, tests, value, scale)
        points_of(contacts, tests, "mechanical", 1.0)
        limits_of(ds, packing, contacts)
        steps_of(ds, step)
        kappa = np.geomspace(30.0, 2e6, 50)
        overlap.plot(kappa, 230.0 / kappa, "k--", lw=0.8, zorder=0)
        overlap.set(yscale="log", ylabel=r"mean overlap $\delta/R$ [%]")
        packing.set(ylabel="packing fraction $\\phi$")
        contacts.set(ylabel="coordination number $z$")
        for ax in (overlap, packing, contacts):
            ax.set(xscale="log", xlabel=r"$\kappa_p$", xlim=(25.0, 2.5e6))
        packing.legend(fontsize="small")
    return {"packings.png": figure}


def points_of(ax: Any, tests: list[Any], value: str, scale: float) -> None:
    """The means of each test with their errors."""
    for name, here, dim, color, marker in tests:
        rows = []
        for level in here[dim].values:
            x, y = (here[which].sel({dim: level}) for which in ("stiffness", value))
            error = driver.mean(y)[1]
            rows.append(
                (float(x.mean()), scale * float(y.mean()), 0.0 if math.isnan(error) else scale * error)
            )
        x, y, error = np.array(rows).T
        ax.errorbar(x, y, error, fmt=marker, ms=4, color=PALETTE[color], label=name)


def limits_of(ds: xr.Dataset, packing: Any, contacts: Any) -> None:
    """The trends of the beds and of the compression."""
    kappa = np.geomspace(100.0, 2e6, 80)
    for here, color in ((beds(ds), "blue"), (of_test(ds, "compressed"), "purple")):
        for ax, value, power in ((packing, "packing_fraction", 1.0), (contacts, "mechanical", 0.5)):
            (limit, slope), _ = trend(here, value, power)
            ax.plot(kappa, limit + slope * kappa**-power, color=PALETTE[color], lw=0.8, zorder=0)


def steps_of(ds: xr.Dataset, ax: Any) -> None:
    """The largest stable steps without dashpots over k_t/k."""
    for name, kind, mu, color, marker in BEDS:
        if kind == "linear":
            here = beds(ds, kind, mu)
            steps = [
                2.0 / here[f"frequency_{100.0 * r:.0f}"].values.ravel() * math.sqrt(2.0) / math.pi
                for r in RATIOS
            ]
            middle = np.array([np.nanmean(step) for step in steps])
            ends = [
                middle - [np.nanmin(step) for step in steps],
                [np.nanmax(step) for step in steps] - middle,
            ]
            ax.errorbar(RATIOS, middle, ends, fmt=marker, ms=4, color=PALETTE[color], label=name)
    ratio = np.linspace(0.0, 1.05, 200)
    highest = np.sqrt(np.maximum(*(part[0] + part[1] * ratio for part in BRANCHES)))
    ax.plot(ratio, 2.0 / highest * math.sqrt(2.0) / math.pi, "k--", lw=0.8, zorder=0, label="rule")
    alone = np.sqrt(np.maximum(2.0, 7.0 * ratio))
    ax.plot(ratio, 2.0 / alone * math.sqrt(2.0) / math.pi, "k:", lw=0.8, zorder=0, label="one contact")
    ax.axhline(0.02, color="k", lw=0.8)
    ax.annotate("$t_c/50$", (0.02, 0.035))
    ax.set(xlabel="$k_t/k$", ylabel=r"largest stable $\Delta t/t_c$", ylim=(0.0, 0.7), xlim=(-0.05, 1.05))
    ax.legend(fontsize="small")


STUDY = driver.Study(
    file=__file__, points=points, run=run, replicas=6, values=VALUES, gather=gather, draw=draw, tables=tables
)

if __name__ == "__main__":
    driver.main(STUDY, __doc__)
