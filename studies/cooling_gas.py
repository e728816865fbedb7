"""Error of each hard-sphere rule in a cooling gas over t_c ν, packing fraction and restitution (see driver.py).

Every run starts from a periodic box of equal spheres in an elastic equilibrium. t_c ν is its initial value: Enskog's
rate times the contact duration of the linear dashpot, whose stiffness is chosen for this value. A run ends when Haff's
law predicts 10 collisions per particle.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping

import driver
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import hardlimit as hl
from hardlimit.boxes import theory
from hardlimit.fidelity_study import MODELS, statistics
from hardlimit.fidelity_study.replica import QUANTITIES
from hardlimit.fidelity_study.result import TOTALS
from hardlimit.fidelity_study.starts import equilibrated
from hardlimit.plots.fidelity import LOOKS
from hardlimit.plots.style import GREY, PAGE_WIDTH, style
from hardlimit.support.estimate import Estimate

TC_NU = (1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3)
PACKING_FRACTION = (0.05, 0.2, 0.35, 0.5)
RESTITUTION = (0.7, 0.9, 0.99)
N, REPLICAS = 1000, 32
COLLISIONS = 10  #: per particle
SAMPLES = 10
#: From this t_c ν on Newton's equations are solved by steps, because contacts form large clusters.
LONG = 0.1
RADIUS, DENSITY, RMS_SPEED = 1e-3, 2500.0, 1.0  #: [m], [kg/m³], [m/s]
VALUES = {
    **{
        name: (record.unit, record.meaning.replace("since the start", ""))
        for name, record in QUANTITIES.items()
    },
    **{name: TOTALS[name] for name in ("overlapped_share", "n_contacts")},
}


def points(_: int) -> Iterator[driver.Point]:
    return itertools.product(TC_NU, PACKING_FRACTION, RESTITUTION)


def law_and_end(point: driver.Point, system: hl.ParticleSystem) -> tuple[hl.LinearDashpot, float]:
    """The law with this initial t_c ν, and the time [s] of ``COLLISIONS`` by Haff's law."""
    tc_nu, _, restitution = point
    gas = theory.Gas(system.n, RADIUS, float(system.mass[0]), float(np.prod(system.box)), 3)
    rate = float(gas.collision_rate(system.granular_temperature))
    cooling = rate * (1.0 - restitution**2) / 6.0
    law = driver.linear_law(restitution, hl.Ball(RADIUS, density=DENSITY), tc_nu / rate)
    return law, math.expm1(COLLISIONS * cooling / rate) / cooling


def run(point: driver.Point, _: int) -> dict[str, list[list[float]]]:
    """The values (model, replica) of ``REPLICAS`` states of one gas."""
    system = equilibrated(hl.ParticleSystem.random(N, point[1], RADIUS, DENSITY, RMS_SPEED), 0)
    law, until = law_and_end(point, system)
    engine = "steps" if point[0] >= LONG else "events"
    result = hl.fidelity(system, law=law, until=until, samples=SAMPLES, replicas=REPLICAS, engine=engine)
    return {name: values.tolist() for name, values in late(result.replicas).items()}


def late(ds: xr.Dataset) -> dict[str, np.ndarray]:
    """Quantities (model, replica) after the first fifth of the run, when the number of open contacts is stationary.

    Growth of the cooling; time averages of rates and pressure; means of temperature and structure over the samples.
    """
    first = SAMPLES // 5
    time = ds["time"].values
    values = {name: ds[name].values for name in VALUES}
    for name in QUANTITIES:
        series = values[name]
        if name == "cooling":
            values[name] = series[..., -1] - series[..., first]
        elif name in ("dissipation_rate", "collision_rate", "pressure"):
            so_far = series[..., [first, -1]] * time[[first, -1]]
            values[name] = (so_far[..., 1] - so_far[..., 0]) / (time[-1] - time[first])
        else:
            values[name] = series[..., first:].mean(axis=-1)
    return values


def gather(runs: list[driver.Run]) -> xr.Dataset:
    """Each model and replica of each run is a point of its own."""
    return driver.gathered(
        STUDY,
        [
            {
                "point": [*run["point"], model],
                "replica": k,
                "values": {name: v[i][k] for name, v in values.items()},
            }
            for run in runs
            for values in [run["values"]]
            for i, model in enumerate(MODELS)
            for k in range(len(values["cooling"][i]))
        ],
    )


def difference(ds: xr.Dataset, quantity: str, rule: str) -> Estimate:
    """(rule − Newton)/Newton with its standard error over (t_c ν, φ, ε), paired by replicas."""
    values = ds[quantity].transpose("replica", ...)
    of_rule, of_newton = (values.sel(model=model).values for model in (rule, "newton"))
    return statistics.relative_difference(of_rule, of_newton)


def trusted(ds: xr.Dataset, quantity: str, rule: str, limit: float) -> tuple[np.ndarray, np.ndarray]:
    """Range of t_c ν, over (φ, ε), in which a rule is trusted.

    First the largest t_c ν of the grid at which the difference is below ``limit`` by two standard errors, with no
    smaller t_c ν above it; 0 if there is none. Then the smallest t_c ν from which on all differences are above
    ``limit`` by two standard errors; infinity if there is none. A rule that ends early, as in a collapse, counts as
    above.
    """
    error = difference(ds, quantity, rule)
    known = np.isfinite(ds[quantity].sel(model="newton")).any("replica").values
    below = np.abs(error.value) + 2.0 * error.error <= limit
    above = known & ~(np.abs(error.value) - 2.0 * error.error <= limit)
    at = ds["tc_nu"].values[:, None, None]
    largest = np.where(below & (np.cumsum(above, axis=0) == 0), at, 0.0).max(axis=0)
    rest = np.cumsum((known & ~above)[::-1], axis=0)[::-1] == 0
    return largest, np.where(above & rest, at, math.inf).min(axis=0)


# --- pictures and tables ------------------------------------------------------------------------------------

LABELS = {"cooling": "cooling", "collision_rate": "collision rate", "pressure": "pressure"}
RULES = {"constant": "constant and law", "tc": "tc", "soft": "soft"}


def draw(ds: xr.Dataset) -> Mapping[str, Figure]:
    return {f"rules_{quantity}.png": differences(ds, quantity) for quantity in LABELS}


def differences(ds: xr.Dataset, quantity: str) -> Figure:
    """|difference| over t_c ν, one panel for each φ and ε. Filled symbols are significant differences."""
    with style():
        figure = Figure(figsize=(PAGE_WIDTH, 5.4))
        axes = figure.subplots(
            len(RESTITUTION), len(PACKING_FRACTION), sharex=True, sharey=True, squeeze=False
        )
        for (row, epsilon), (column, phi) in itertools.product(
            enumerate(RESTITUTION), enumerate(PACKING_FRACTION)
        ):
            ax = axes[row, column]
            for limit in (1.0, 10.0):
                ax.axhline(limit, color=GREY, lw=0.8, ls=(0, (2, 2)))
            for shift, rule in enumerate(RULES):
                panel = (part[:, column, row] for part in difference(ds, quantity, rule))
                _points(ax, Estimate(*panel), ds.sizes["replica"], rule, shift)
            if row == 0:
                ax.set_title(rf"$\phi$ = {phi:g}")
            if column == 0:
                ax.set_ylabel(rf"$\varepsilon$ = {epsilon:g}" + "\n|difference| [%]")
            ax.set(xscale="log", yscale="log", xlim=(5e-4, 0.6), ylim=(0.05, 200.0))
            ax.set_xticks([1e-3, 1e-2, 0.1], ["0.001", "0.01", "0.1"])
            ax.set_xticks([x for x in TC_NU if x not in (1e-3, 1e-2, 0.1)], minor=True, labels=[])
        for ax in axes[-1]:
            ax.set_xlabel(r"$t_c\nu$ of the start")
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=3, title=f"{LABELS[quantity]}: rule")
    return figure


def _points(ax: Axes, error: Estimate, replicas: int, rule: str, shift: int) -> None:
    """Draw the points of a rule beside those of the others, so that error bars do not overlap."""
    colour = LOOKS[rule]["color"]
    x = np.array(TC_NU) * 1.12 ** (shift - 1)
    size = 100.0 * np.abs(error.value)
    apart = statistics.significant(error, replicas)
    ax.errorbar(x, size, 100.0 * error.error, fmt="none", ecolor=colour, elinewidth=0.9)
    ax.plot(x, size, "o", ms=4.0, c="white", mec=colour, mew=0.9)
    ax.plot(x[apart], size[apart], "o", ms=4.0, c=colour, mec=colour, label=RULES[rule])


def tables(ds: xr.Dataset) -> str:
    return "\n\n".join(
        f"{LABELS[quantity]}: t_c ν up to which a rule holds … from which it does not, to 1 %; to 10 %\n\n"
        + table(ds, quantity)
        for quantity in LABELS
    )


def table(ds: xr.Dataset, quantity: str) -> str:
    """Where each rule holds."""
    limits = {rule: [trusted(ds, quantity, rule, limit) for limit in (0.01, 0.1)] for rule in RULES}
    rows = [
        (
            phi,
            epsilon,
            *("; ".join(_span(*(end[i, j] for end in ends)) for ends in limits[rule]) for rule in RULES),
        )
        for (i, phi), (j, epsilon) in itertools.product(enumerate(PACKING_FRACTION), enumerate(RESTITUTION))
    ]
    return driver.table("φ | ε | " + " | ".join(RULES.values()), rows)


def _span(*ends: float) -> str:
    return " … ".join(f"{end:g}" if 0.0 < end < math.inf else "–" for end in ends)


STUDY = driver.Study(
    file=__file__,
    points=points,
    run=run,
    values=VALUES,
    axes=lambda: {
        "tc_nu": TC_NU,
        "packing_fraction": PACKING_FRACTION,
        "restitution": RESTITUTION,
        "model": MODELS,
    },
    gather=gather,
    about={
        "title": "Hard-sphere rules and Newton’s equations in a cooling gas: every replica, means after the "
        "first fifth of the run",
        "law": "LinearDashpot",
        "n": N,
        "collisions_per_particle": COLLISIONS,
    },
    draw=draw,
    tables=tables,
)

if __name__ == "__main__":
    driver.main(STUDY, __doc__)
