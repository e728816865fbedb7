"""Measurement of grains that a piston presses along one axis, by coefficient of friction: share of its stress σ
that the mean of the normal stresses has, packing fraction and coordination (see driver.py).

Spheres of diameter 1 and mass 1, k = 1, ε = 0.5, k_t = 2/7 k between two walls, beside periodic sides; one wall moves
inwards from φ = 0.5. Values are those of the grains more than two diameters from both walls, where the piston has the
stresses σ of the levels κ = k/(σ d), and (E*/σ)^(2/3) of Hertz' contacts. A run solves Newton's equations by steps.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, Final, NamedTuple

import driver
import numpy as np
import xarray as xr
from driver import Point
from matplotlib.figure import Figure
from packings import VALUES, WALLED, blocks, bulk, law, shown, solved

import hardlimit as hl
from hardlimit.boxes import contacts
from hardlimit.checking import at_rest
from hardlimit.measure import stability
from hardlimit.plots.style import PAGE_WIDTH, PALETTE, style

LEVELS: Final = (1e3, 10**2.5, 1e2, 10**1.5, 10**1.25)
FRICTIONS: Final = (0.1, 0.3, 0.5, 1.0)
START, FROM_WALLS, SAMPLES = 0.5, 2.0, 400
STRAIN: Final = 0.29
OTHERS: Final = 3  #: replicas of the other ways
KEPT: Final = ("packing_fraction", "pressure", "coordination", "mechanical", "overlap", "deepest")


class Way(NamedTuple):
    """How the grains are pressed."""

    law: str = "linear"
    rate: float = 5e-5  #: of strain [√(k/m)]
    side: float = 5.0  #: of the cell; it is twice as high at the start


WAYS: Final = {
    "as it is": Way(),
    "slow": Way(rate=1e-5),
    "fast": Way(rate=2e-4),
    "large": Way(side=7.0),
    "Hertz": Way(law="hertz", rate=2e-5),
}


def pressed(mu: float, name: str, replica: int) -> dict[str, list[float]]:
    """Values at each level while the wall moves inwards."""
    way = WAYS[name]
    at, height = blocks(2, way.side, START, replica), 2.0 * way.side
    speed, flow = way.rate * height, np.zeros_like(at)
    flow[:, 2] = -way.rate * at[:, 2]
    start = hl.ParticleSystem(
        at, flow, 0.5, mass=1.0, box=[way.side, way.side, height], boundary=WALLED,
        walls={"z+": hl.MovingWall(velocity=-speed)},
    )  # fmt: skip
    force = law(way.law, mu, 1.0, 1.0)
    run, states = solved(start, force, mu, STRAIN / way.rate, SAMPLES)
    if run.outcome != "ok":
        return {}
    power = power_of(way.law)
    rows = []
    for time, state in zip(run.series.time.values, states, strict=True):
        top = height - speed * float(time)
        of = bulk(state, force, FROM_WALLS, top - FROM_WALLS)
        rows.append({name: of[name] for name in KEPT} | {"axial": on_walls(state, force)})
    with np.errstate(divide="ignore"):
        stiffness = -power * np.log10([row["axial"] for row in rows])
    values: dict[str, list[float]] = {name: [] for name in rows[0]}
    for level in np.log10(LEVELS):
        before = int(np.flatnonzero(stiffness >= level)[-1])
        known = before + 1 < len(rows)
        share = (
            (stiffness[before] - level) / (stiffness[before] - stiffness[before + 1]) if known else math.nan
        )
        for name, column in values.items():
            pair = (rows[before][name], rows[before + 1][name]) if known else (math.nan,) * 2
            column.append(float(pair[0] + share * (pair[1] - pair[0])))
    return values


def power_of(kind: str) -> float:
    """Of the pressure in 1/κ."""
    return 2.0 / 3.0 if kind == "hertz" else 1.0


def on_walls(system: hl.ParticleSystem, force: hl.Law) -> float:
    """Mean force of both walls over their area."""
    of = stability.network(system, 0.0)
    power = 0.25 * force.record["powers"][0]
    total = 0.0
    for rows, contact in contacts.of_pairs(system, force, of.first, of.second):
        at = rows[of.second[rows] < 0]
        total += contact.coefficients[0] * float((of.overlap[at] ** power).sum())
    return 0.5 * total / float(system.box[0] * system.box[1])


# --- grid -----------------------------------------------------------------------------------------------------


def points(replica: int) -> Iterator[Point]:
    """A run has the values at all levels."""
    for mu in FRICTIONS:
        yield mu, "as it is", None
    for way in WAYS if replica < OTHERS else ():
        if way != "as it is":
            yield 0.5, way, None


def run(point: Point, replica: int) -> dict[str, list[float]]:
    mu, way, _ = point
    return pressed(mu, way, replica)


def axes() -> Mapping[str, Any]:
    return {"friction": list(FRICTIONS), "way": list(WAYS), "level": list(LEVELS)}


# --- results --------------------------------------------------------------------------------------------------


def share(ds: xr.Dataset) -> xr.DataArray:
    """Mean of the normal stresses over that of the piston."""
    return ds.pressure / ds.axial


def stiffness(ds: xr.Dataset, way: str) -> xr.DataArray:
    """κ_p under the mean of the normal stresses."""
    return ds.pressure ** -power_of(WAYS[way].law)


def places() -> list[tuple[float, str]]:
    return [(mu, way) for mu, way, _ in points(0)]


def tables(ds: xr.Dataset) -> str:
    rows = []
    for mu, way in places():
        here = ds.sel(friction=mu, way=way)
        for level in LEVELS:
            at, packing = here.sel(level=level), at_rest.pressed(mu)
            kappa = float(stiffness(at, way).mean())
            over = share(at) / at_rest.under_piston(mu, level)
            carrying = at.packing_fraction * at.coordination / packing.carrying(kappa, 3)
            rows.append(
                (mu, way, f"{level:.3g}", f"{kappa:.3g}", shown(share(at), 3), shown(over, 2),
                 shown(at.packing_fraction, 3), shown(at.coordination, 2), shown(carrying, 2),
                 shown(at.overlap, 2, 100.0), shown(at.deepest, 0, 100.0))
            )  # fmt: skip
    head = "μ | pressed | κ of the piston | κ_p | p/σ | over check's | φ | z | φz over check's | δ/R [%] | deepest [%]"
    return driver.table(head, rows)


def draw(ds: xr.Dataset) -> Mapping[str, Figure]:
    """Share of the mean stress, and φ z, over the stiffness number."""
    with style():
        figure = Figure(figsize=(PAGE_WIDTH, 2.9), layout="constrained")
        stress, contacts = figure.subplots(1, 2)
        colors, kappa = list(PALETTE.values()), np.geomspace(15.0, 2e3, 80)
        markers = dict(zip(WAYS, "osv^D", strict=True))
        for mu, way in places():
            here, color = ds.sel(friction=mu, way=way), colors[FRICTIONS.index(mu)]
            label = f"μ = {mu:g}" if way == "as it is" else way
            look: Any = {"fmt": markers[way], "ms": 3.5, "color": color, "label": label}
            if way != "as it is":
                look |= {"mfc": "white"}
            mean, error = of_levels(share(here))
            stress.errorbar(LEVELS, mean, error, **look)
            mean, error = of_levels(here.packing_fraction * here.coordination)
            contacts.errorbar(stiffness(here, way).mean("replica"), mean, error, **look)
            if way == "as it is":
                stress.plot(
                    kappa, [at_rest.under_piston(mu, k) for k in kappa], color=color, lw=0.8, zorder=0
                )
                line = [at_rest.pressed(mu).carrying(k, 3) for k in kappa]
                contacts.plot(kappa, line, color=color, lw=0.8, zorder=0)
        stress.set(xlabel=r"$k/(\sigma d)$", ylabel=r"$p/\sigma$", xscale="log")
        contacts.set(xlabel=r"$\kappa_p$", ylabel=r"$\phi z$", xscale="log")
        contacts.legend(fontsize="x-small", ncols=2)
    return {"pistons.png": figure}


def of_levels(values: xr.DataArray) -> tuple[list[float], list[float]]:
    """Mean and standard error at each level."""
    pairs = [driver.mean(values.sel(level=level)) for level in LEVELS]
    return [mean for mean, _ in pairs], [error for _, error in pairs]


STUDY = driver.Study(
    file=__file__,
    points=points,
    run=run,
    replicas=6,
    values={name: VALUES[name] for name in KEPT} | {"axial": ("1", "stress of the piston")},
    axes=axes,
    draw=draw,
    tables=tables,
)

if __name__ == "__main__":
    driver.main(STUDY, __doc__)
