"""Measurement of beds of grains of unequal sizes: who touches whom, how forces are shared, mean overlap, highest
frequency; beside what ``hardlimit check`` expects (see driver.py).

500 spheres of one density and the mean mass 1 fall from φ = 0.42 onto a floor between periodic sides; μ = 0.5,
ε = 0.5, k_t = 2/7 k, no tangential dashpot. The stiffness number of the weight of half of the bed at the diameter of a
grain of the mean mass is 3000. Values are of the grains between three largest radii above the floor and two and a half
below the top. A run solves Newton's equations by steps.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, Final

import driver
import numpy as np
import xarray as xr
from driver import Point
from matplotlib.figure import Figure

import hardlimit as hl
from hardlimit.boxes.box import Floats
from hardlimit.checking import at_rest, cases, mixture
from hardlimit.measure import stability
from hardlimit.plots.style import PAGE_WIDTH, PALETTE, style

N, LOOSE, KAPPA, MU, RESTITUTION, POISSON = 500, 0.42, 3000.0, 0.5, 0.5, 0.3
DENSITY: Final = 6.0 / math.pi
WALLED: Final = ("periodic", "periodic", "wall")
UNTIL: Final = 12.0 + 300.0 / math.sqrt(KAPPA)  #: √(d/g)
BELOW, ABOVE = 3.0, 2.5  #: left out at the floor and at the top, in the largest radius
RATIOS: Final = (0.0, 2.0 / 7.0, 1.0)  #: k_t/k for which steps are computed
#: Share of small grains by number, and the radius of the large ones over theirs; 0: uniform between both.
SIZES: Final = {
    "equal": (1.0, 1.0),
    "uniform 0.9:1.1": (0.0, 1.1 / 0.9),
    "1:1.4": (0.5, 1.4),
    "1:2": (0.5, 2.0),
    "1:2, equal volumes": (8.0 / 9.0, 2.0),
    "uniform 1:3": (0.0, 3.0),
    "1:3, 20 % large": (0.8, 3.0),
}
LAWS: Final = {"linear": list(SIZES), "hertz": ["equal"]}
VALUES: Final = {
    "packing_fraction": ("1", "packing fraction"),
    "pressure": ("1", "mean pressure in m g/d²"),
    "weight": ("1", "weight of half of the bed over its area in m g/d²"),
    "vertical": ("1", "weight per area above the middle of the layer, in m g/d²"),
    "coordination": ("1", "mean number of contacts of a particle"),
    "width": ("1", "standard deviation of the radii over their mean"),
    "power": ("1", "power of the radius in the number of contacts of a particle"),
    "overlap": ("1", "mean overlap of contacts over the smaller radius"),
    "deepest": ("1", "99 % of the contacts have a force below this, over the mean force at their depth"),
    "step_0": ("1", "largest stable step in √(d/g), k_t = 0, no dashpots"),
    "step_29": ("1", "largest stable step in √(d/g), k_t = 2/7 k, no dashpots"),
    "step_100": ("1", "largest stable step in √(d/g), k_t = k, no dashpots"),
    "step": ("1", "largest stable step in √(d/g), k_t = 2/7 k, dashpots of ε = 0.5"),
}


def radii(sizes: str, seed: int) -> Floats:
    """Radii of grains of the mean volume of one of diameter 1."""
    small, ratio = SIZES[sizes]
    each = (
        np.linspace(1.0, ratio, N) if small == 0.0 else np.where(np.arange(N) < round(small * N), 1.0, ratio)
    )
    shuffled: Floats = np.random.default_rng(seed).permutation(each)
    return 0.5 * shuffled / np.cbrt((shuffled**3).mean())


def loose(sizes: str, seed: int) -> hl.ParticleSystem:
    """Two cubes of grains on each other."""
    radius = radii(sizes, seed)
    cubes = [
        hl.ParticleSystem.random(len(part), LOOSE, part, DENSITY, 0.0, seed=2 * seed + k, boundary=WALLED)
        for k, part in enumerate(np.array_split(radius, 2))
    ]
    low, high = (float(cube.box[2]) for cube in cubes)
    at = np.concatenate([cubes[0].positions, cubes[1].positions + np.array([0.0, 0.0, low])])
    side = max(low, high)
    return hl.ParticleSystem(
        at, 0.0 * at, radius, density=DENSITY, box=[side, side, low + high + 0.5], boundary=WALLED, gravity=1.0,
        allowed_overlap=1e-9,
    )  # fmt: skip


def law_of(kind: str, weight: float, **values: Any) -> hl.Law:
    """The law at a pressure."""
    if kind == "linear":
        numbers = {"restitution": RESTITUTION, "friction": hl.Friction(MU)} | values
        return hl.LinearDashpot(stiffness=KAPPA * weight, **numbers)
    youngs = 2.0 * (1.0 - POISSON**2) * weight * KAPPA**1.5
    return hl.Viscoelastic(
        youngs_modulus=youngs, poisson_ratio=POISSON, restitution=RESTITUTION, impact_speed=1.0,
        friction=hl.Friction(MU),
    )  # fmt: skip


def run(point: Point, replica: int) -> dict[str, float]:
    """The values of a bed; none if its run ended early."""
    sizes, kind = point
    start = loose(sizes, replica)
    weight = 0.5 * N / float(start.box[0]) ** 2
    settled = hl.molecular_dynamics(
        start,
        law=law_of(kind, weight),
        until=UNTIL,
        engine="steps",
        restitution_error=0.005,
        samples=1,
        threads=1,
    )
    return values_of(settled.system, kind, weight) if settled.outcome == "ok" else {}


# --- values of a state ----------------------------------------------------------------------------------------


def values_of(system: hl.ParticleSystem, kind: str, weight: float) -> dict[str, float]:
    """The values of a bed at rest."""
    law, z, radius = law_of(kind, weight), system.positions[:, 2], system.radius
    of = stability.network(system, 0.0)
    among = of.second >= 0
    i, j, overlap = of.first[among], of.second[among], of.overlap[among]
    low = BELOW * float(radius.max())
    high = float(np.sort(z)[-20:].mean()) - ABOVE * float(radius.max())
    inside = (z > low) & (z < high)
    share = 0.5 * (inside[i] + inside[j].astype(float))  # of each contact
    volume = float(system.box[0] * system.box[1]) * (high - low)
    filled = float((below(high - z, radius) - below(low - z, radius)).sum())
    force = forces(law, system, of, among)
    pressure = float((share * force * (radius[i] + radius[j] - overlap)).sum()) / (3.0 * volume)
    counts = of.counts(system.n)
    spread = radius[inside].std() > 0.0
    mean = float(share @ (overlap / np.minimum(radius[i], radius[j])) / share.sum())
    return {
        "packing_fraction": filled / volume,
        "pressure": pressure,
        "weight": weight,
        "vertical": float(system.mass @ ((z > high) + 0.5 * inside)) / float(np.prod(system.box[:2])),
        "coordination": 2.0 * float(share.sum()) / float(inside.sum()),
        "width": float(radius[inside].std() / radius[inside].mean()),
        "power": power_of(radius[inside], counts[inside]) if spread else math.nan,
        "overlap": mean,
        "deepest": deepest(force, 0.5 * (z[i] + z[j]), share),
        **steps_of(system, kind, weight),
    }


def below(height: Floats, radius: Floats) -> Floats:
    """Volume of grains below these heights over their centres."""
    t = np.clip(height, -radius, radius)
    volume: Floats = math.pi * (radius**2 * (t + radius) - (t**3 + radius**3) / 3.0)
    return volume


def forces(law: hl.Law, system: hl.ParticleSystem, of: Any, among: Any) -> Floats:
    """Static forces of the contacts between grains."""
    values = np.zeros(len(of.first))
    for rows, contact in stability.contacts.of_pairs(system, law, of.first, of.second):
        elastic, _ = contact.coefficients
        values[rows] = elastic * of.overlap[rows] ** (0.25 * law.record["powers"][0])
    chosen: Floats = values[among]
    return chosen


def power_of(radius: Floats, counts: Any) -> float:
    """Slope of ln z over ln R of the halves of the grains by size."""
    small = radius <= np.median(radius) if np.median(radius) < radius.max() else radius < radius.max()
    ends = [np.array([r.mean(), c.mean()]) for r, c in ((radius[s], counts[s]) for s in (small, ~small))]
    return float(np.diff(np.log([end[1] for end in ends]))[0] / np.diff(np.log([end[0] for end in ends]))[0])


def deepest(force: Floats, height: Floats, share: Floats) -> float:
    """Force below which 99 % of the contacts are, each over the mean of the tenth of all contacts around its height."""
    chosen = np.flatnonzero(share > 0.0)
    order = chosen[np.argsort(height[chosen])]
    parts = np.array_split(force[order], 10)
    return float(np.quantile(np.concatenate([part / part.mean() for part in parts]), 0.99))


def laws_of_steps(kind: str, weight: float) -> dict[str, hl.Law]:
    """The laws for which largest steps are computed: linear ones, whose steps do not depend on the pressure."""
    if kind != "linear":
        return {}
    frictions = {ratio: hl.Friction(MU, stiffness_ratio=ratio) if ratio else None for ratio in RATIOS}
    laws = {
        f"step_{100.0 * ratio:.0f}": law_of(kind, weight, restitution=1.0, friction=friction)
        for ratio, friction in frictions.items()
    }
    return laws | {"step": law_of(kind, weight)}


def steps_of(system: hl.ParticleSystem, kind: str, weight: float) -> dict[str, float]:
    """Largest stable steps of the network of contacts."""
    return {
        name: float(hl.measure.largest_stable_time_step(system, law, tolerance=0.0).time_step)
        for name, law in laws_of_steps(kind, weight).items()
    }


# --- what check expects ---------------------------------------------------------------------------------------


def state_of(radius: Floats, law: hl.Law, pressure: float) -> at_rest.GrainState:
    """What check says of grains of these sizes under a mean pressure."""
    ends = [hl.Ball(float(r), density=DENSITY) for r in dict.fromkeys((radius.min(), radius.max()))]
    kinds = mixture.of_grains(["1"] * len(radius), radius, np.full(len(radius), DENSITY))
    load = at_rest.Load("rest", pressure=pressure, packing=at_rest.settled(0.5), kinds=kinds)
    return at_rest.grain_state(cases.of_law(ends, law, False, None), load, None, 3)


def compared(ds: xr.Dataset, sizes: str, kind: str) -> Iterator[tuple[float, float, list[float]]]:
    """κ_p, overlap expected over measured, and largest steps over those of check, of each replica."""
    for replica in ds.replica.values:
        at = ds.sel(sizes=sizes, law=kind, replica=replica)
        if not math.isnan(at.overlap):
            radius, weight = radii(sizes, int(replica)), float(at.weight)
            state = state_of(radius, law_of(kind, weight), float(at.pressure))
            steps = [
                float(at[name]) / float(state_of(radius, law, weight).largest_stable_step or math.nan)
                for name, law in laws_of_steps(kind, weight).items()
            ]
            yield float(state.stiffness_number or 0.0), float(state.overlap or 0.0) / float(at.overlap), steps


# --- grid and results -----------------------------------------------------------------------------------------


def points(replica: int) -> Iterator[Point]:
    for kind, names in LAWS.items():
        if kind == "linear" or replica == 0:
            yield from ((name, kind) for name in names)


def axes() -> Mapping[str, list[str]]:
    return {"sizes": list(SIZES), "law": list(LAWS)}


def tables(ds: xr.Dataset) -> str:
    head = (
        "law | sizes | κ_p | φ | z | power of z | δ/R [%] | expected over it | p/σ | 99 % of forces | steps"
    )
    rows = []
    for kind, names in LAWS.items():
        for name in names:
            kappas, ratios, steps = zip(*compared(ds, name, kind), strict=True)
            mean, ends = ds.sel(sizes=name, law=kind).mean("replica"), [step for row in steps for step in row]
            rows.append(
                (kind, name, f"{np.mean(kappas):.0f}", f"{float(mean.packing_fraction):.3f}",
                 f"{float(mean.coordination):.2f}", "–" if math.isnan(mean.power) else f"{float(mean.power):.2f}",
                 f"{100.0 * float(mean.overlap):.4f}", ", ".join(f"{ratio:.2f}" for ratio in ratios),
                 f"{float(mean.pressure / mean.vertical):.2f}", f"{float(mean.deepest):.1f}",
                 f"{min(ends):.2f} to {max(ends):.2f}" if ends else "–")
            )  # fmt: skip
    return driver.table(head, rows)


def draw(ds: xr.Dataset) -> Mapping[str, Figure]:
    """Overlap and largest step, expected and measured, for each distribution."""
    with style():
        figure = Figure(figsize=(PAGE_WIDTH, 2.9), layout="constrained")
        overlap, step = figure.subplots(1, 2)
        for kind, color, marker in (("linear", "blue", "o"), ("hertz", "vermillion", "s")):
            rows = [
                (list(SIZES).index(name), ratio, steps)
                for name in LAWS[kind]
                for _, ratio, steps in compared(ds, name, kind)
            ]
            options = {"marker": marker, "ms": 4, "ls": "", "color": PALETTE[color]}
            overlap.plot(
                [x for x, *_ in rows],
                [ratio for _, ratio, _ in rows],
                label=kind.replace("hertz", "Hertz"),
                **options,
            )
            pairs = [(x, value) for x, _, steps in rows for value in steps]
            step.plot(*np.array(pairs).reshape(-1, 2).T, **options)
        overlap.axhspan(0.95, 1.05, color="0.9", zorder=0)
        overlap.set(ylabel="overlap expected / measured")
        step.set(ylabel="largest step measured / expected")
        step.axhline(1.0, color="k", lw=0.8)
        for ax in (overlap, step):
            labels = [name.replace(", ", "\n").replace("uniform ", "uniform\n") for name in SIZES]
            ax.set_xticks(range(len(SIZES)), labels, fontsize="x-small", rotation=60)
        overlap.legend(fontsize="small")
    return {"mixtures.png": figure}


STUDY = driver.Study(
    file=__file__, points=points, run=run, replicas=2, values=VALUES, axes=axes, draw=draw, tables=tables
)  # fmt: skip

if __name__ == "__main__":
    driver.main(STUDY, __doc__)
