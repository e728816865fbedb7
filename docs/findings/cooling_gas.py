"""Error of each hard-sphere rule in a cooling gas over t_c ν, packing fraction and restitution.

    python docs/findings/cooling_gas.py compute STORES [--workers 4] [--scheduler ADDRESS] [--part 1/8]
    python docs/findings/cooling_gas.py collect STORES
    python docs/findings/cooling_gas.py draw

``compute`` fills a folder with one store of ``hl.fidelity`` for each point of the grid and resumes where it was
stopped. ``--part 1/8`` computes every eighth point, for eight parallel jobs. ``collect`` gathers the complete points in
cooling_gas.nc beside this file. ``draw`` makes the figures of docs/cooling_gas.md from that file.

Every run starts from a periodic box of equal spheres in an elastic equilibrium. t_c ν is its initial value: Enskog's
rate times the contact duration of the linear dashpot, whose stiffness is chosen for this value. A run ends when Haff's
law predicts 10 collisions per particle.
"""

from __future__ import annotations

import argparse
import itertools
import math
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import hardlimit as hl
from hardlimit import plots
from hardlimit.boxes import theory
from hardlimit.fidelity_study import MODELS, statistics
from hardlimit.fidelity_study.replica import QUANTITIES
from hardlimit.fidelity_study.result import TOTALS
from hardlimit.fidelity_study.starts import equilibrated
from hardlimit.plots.fidelity import LOOKS
from hardlimit.plots.style import GREY, PAGE_WIDTH, style
from hardlimit.support import saving
from hardlimit.support.estimate import Estimate
from hardlimit.support.progress import bar

HERE = Path(__file__).parent
DATA = HERE / "cooling_gas.nc"
IMAGES = HERE.parent / "images"

TC_NU = (1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3)
PACKING_FRACTION = (0.05, 0.2, 0.35, 0.5)
RESTITUTION = (0.7, 0.9, 0.99)
COLLISIONS = 10  #: per particle
SAMPLES = 10
#: From this t_c ν on Newton's equations are solved by steps, because contacts form large clusters.
LONG = 0.1
RADIUS, DENSITY, RMS_SPEED = 1e-3, 2500.0, 1.0  #: [m], [kg/m³], [m/s]


class Point(NamedTuple):
    """A point of the grid."""

    tc_nu: float
    packing_fraction: float
    restitution: float

    @property
    def name(self) -> str:
        return f"tc_nu_{self.tc_nu:g}_phi_{self.packing_fraction:g}_restitution_{self.restitution:g}.replicas"


def points() -> Iterator[Point]:
    """All points of the grid, in an order in which the first part is a coarser grid."""
    every = list(itertools.product(TC_NU, PACKING_FRACTION, RESTITUTION))
    for first in range(5):
        yield from itertools.starmap(Point, every[first::5])


def start(packing_fraction: float, n: int) -> hl.ParticleSystem:
    """An elastic gas in equilibrium. The replicas of ``hl.fidelity`` are other states of this gas."""
    system = hl.ParticleSystem.random(n, packing_fraction, RADIUS, DENSITY, RMS_SPEED)
    return equilibrated(system, 0)


def law_and_end(point: Point, system: hl.ParticleSystem) -> tuple[hl.LinearDashpot, float]:
    """The law with this initial t_c ν, and the time [s] of ``COLLISIONS`` by Haff's law."""
    gas = theory.Gas(system.n, RADIUS, float(system.mass[0]), float(np.prod(system.box)), 3)
    rate = float(gas.collision_rate(system.granular_temperature))
    ball = hl.Ball(RADIUS, density=DENSITY)
    unit = hl.LinearDashpot(stiffness=1.0, restitution=point.restitution)
    wanted = point.tc_nu / rate
    law = unit.replace(stiffness=(unit.between(ball, ball).duration() / wanted) ** 2)
    cooling = rate * (1.0 - point.restitution**2) / 6.0
    return law, math.expm1(COLLISIONS * cooling / rate) / cooling


def solve(point: Point, folder: Path, n: int, replicas: int, **where: object) -> hl.Fidelity:
    """Compute one point, except the replicas that are in its store."""
    system = start(point.packing_fraction, n)
    law, until = law_and_end(point, system)
    settings = {
        "samples": SAMPLES,
        "replicas": replicas,
        "engine": "steps" if point.tc_nu >= LONG else "events",
        "store": folder / point.name,
    }
    return hl.fidelity(system, law=law, until=until, **settings, **where)


def compute(arguments: argparse.Namespace) -> None:
    arguments.stores.mkdir(parents=True, exist_ok=True)
    part, parts = map(int, arguments.part.split("/"))
    chosen = [point for i, point in enumerate(points()) if i % parts == part - 1]
    where = {"scheduler": arguments.scheduler, "workers": arguments.workers}
    with bar("cooling gas", "points") as report:
        for done, point in enumerate(chosen):
            report(done, len(chosen))
            print(
                point.name,
                solve(point, arguments.stores, arguments.n, arguments.replicas, **where),
                flush=True,
            )


# --- results ------------------------------------------------------------------------------------------------


def collect(arguments: argparse.Namespace) -> None:
    """Store every replica of the complete points; NaN for other points and for models that ended early."""
    shape = (len(TC_NU), len(PACKING_FRACTION), len(RESTITUTION), len(MODELS), arguments.replicas)
    found = {name: np.full(shape, math.nan) for name in (*QUANTITIES, "overlapped_share", "n_contacts")}
    for point in points():
        if not (arguments.stores / point.name).exists():
            continue
        axes = zip((TC_NU, PACKING_FRACTION, RESTITUTION), point, strict=True)
        at = tuple(axis.index(value) for axis, value in axes)
        values = late(solve(point, arguments.stores, arguments.n, arguments.replicas).replicas)
        for name in found:
            found[name][at] = values[name]
    dims = ("tc_nu", "packing_fraction", "restitution", "model", "replica")
    meanings = {name: (one.unit, one.meaning) for name, one in QUANTITIES.items()}
    meanings |= {name: TOTALS[name] for name in ("overlapped_share", "n_contacts")}
    coordinates = {
        "tc_nu": TC_NU,
        "packing_fraction": PACKING_FRACTION,
        "restitution": RESTITUTION,
        "model": MODELS,
    }
    data = {
        name: (
            dims,
            values,
            {"units": meanings[name][0], "long_name": meanings[name][1].replace("since the start", "")},
        )
        for name, values in found.items()
    }
    about = {
        "title": "Hard-sphere rules and Newton’s equations in a cooling gas: every replica, means after the "
        "first fifth of the run",
        "source": f"hardlimit {hl.__version__}, docs/findings/cooling_gas.py",
        "law": "LinearDashpot",
        "n": arguments.n,
        "collisions_per_particle": COLLISIONS,
    }
    saving.dataset(
        xr.Dataset(data, {name: list(values) for name, values in coordinates.items()}, about), DATA
    )


def late(ds: xr.Dataset) -> dict[str, np.ndarray]:
    """Quantities (model, replica) after the first fifth of the run, when the number of open contacts is stationary.

    Growth of the cooling; time averages of rates and pressure; means of temperature and structure over the samples.
    """
    first = SAMPLES // 5
    time = ds["time"].values
    found = {name: ds[name].values for name in ("overlapped_share", "n_contacts")}
    for name in QUANTITIES:
        values = ds[name].values
        if name == "cooling":
            found[name] = values[..., -1] - values[..., first]
        elif name in ("dissipation_rate", "collision_rate", "pressure"):
            so_far = values[..., [first, -1]] * time[[first, -1]]
            found[name] = (so_far[..., 1] - so_far[..., 0]) / (time[-1] - time[first])
        else:
            found[name] = values[..., first:].mean(axis=-1)
    return found


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
    found = difference(ds, quantity, rule)
    known = np.isfinite(ds[quantity].sel(model="newton")).any("replica").values
    below = np.abs(found.value) + 2.0 * found.error <= limit
    above = known & ~(np.abs(found.value) - 2.0 * found.error <= limit)
    at = ds["tc_nu"].values[:, None, None]
    held = np.where(below & (np.cumsum(above, axis=0) == 0), at, 0.0).max(axis=0)
    rest = np.cumsum((known & ~above)[::-1], axis=0)[::-1] == 0
    return held, np.where(above & rest, at, math.inf).min(axis=0)


# --- pictures and tables ------------------------------------------------------------------------------------


def draw(_: argparse.Namespace) -> None:
    ds = xr.open_dataset(DATA)
    for quantity in ("cooling", "collision_rate", "pressure"):
        figure = differences(ds, quantity)
        print(plots.save(figure, IMAGES / f"rules_{quantity}.png", 150))
        print(
            f"\n{LABELS[quantity]}: t_c ν up to which a rule holds … from which it does not, to 1 %; to 10 %\n"
        )
        print(table(ds, quantity))


LABELS = {"cooling": "cooling", "collision_rate": "collision rate", "pressure": "pressure"}
RULES = {"constant": "constant and law", "tc": "tc", "soft": "soft"}


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
                found = difference(ds, quantity, rule)
                at = np.s_[:, column, row]
                _points(ax, Estimate(*(part[at] for part in found)), ds.sizes["replica"], rule, shift)
            if row == 0:
                ax.set_title(rf"$\phi$ = {phi:g}")
            if column == 0:
                ax.set_ylabel(rf"$\varepsilon$ = {epsilon:g}" + "\n|difference| [%]")
            ax.set_xscale("log")
            ax.set_yscale("log")
            ax.set_xticks([1e-3, 1e-2, 0.1], ["0.001", "0.01", "0.1"])
            ax.set_xticks([x for x in TC_NU if x not in (1e-3, 1e-2, 0.1)], minor=True, labels=[])
            ax.set_xlim(5e-4, 0.6)
            ax.set_ylim(0.05, 200.0)
        for ax in axes[-1]:
            ax.set_xlabel(r"$t_c\nu$ of the start")
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=3, title=f"{LABELS[quantity]}: rule")
    return figure


def _points(ax: Axes, found: Estimate, replicas: int, rule: str, shift: int) -> None:
    """Draw the points of a rule beside those of the others, so that error bars do not overlap."""
    colour = LOOKS[rule]["color"]
    x = np.array(TC_NU) * 1.12 ** (shift - 1)
    size, error = 100.0 * np.abs(found.value), 100.0 * found.error
    apart = statistics.significant(found, replicas)
    ax.errorbar(x, size, error, fmt="none", ecolor=colour, elinewidth=0.9)
    ax.plot(x, size, "o", ms=4.0, c="white", mec=colour, mew=0.9)
    ax.plot(x[apart], size[apart], "o", ms=4.0, c=colour, mec=colour, label=RULES[rule])


def table(ds: xr.Dataset, quantity: str) -> str:
    """Where each rule holds, as Markdown."""
    head = "| φ | ε | " + " | ".join(RULES.values()) + " |"
    lines = [head, "|" + "---|" * (2 + len(RULES))]
    limits = {rule: [trusted(ds, quantity, rule, limit) for limit in (0.01, 0.1)] for rule in RULES}
    for (i, phi), (j, epsilon) in itertools.product(enumerate(PACKING_FRACTION), enumerate(RESTITUTION)):
        cells = ["; ".join(_span(held[i, j], lost[i, j]) for held, lost in limits[rule]) for rule in RULES]
        lines.append(f"| {phi:g} | {epsilon:g} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _span(held: float, lost: float) -> str:
    return f"{_number(held)} … {_number(lost)}"


def _number(value: float) -> str:
    return f"{value:g}" if 0.0 < value < math.inf else "–"


def main() -> None:
    parser = argparse.ArgumentParser(description="How far each rule holds in a cooling gas.")
    commands = parser.add_subparsers(required=True)
    for name, function in (("compute", compute), ("collect", collect)):
        command = commands.add_parser(name)
        command.set_defaults(run=function)
        command.add_argument("stores", type=Path, help="folder of the stores")
        command.add_argument("--n", type=int, default=1000, help="particles [1000]")
        command.add_argument("--replicas", type=int, default=8, help="[8]")
        if name == "compute":
            command.add_argument("--workers", type=int, default=1, help="processes [1]")
            command.add_argument(
                "--scheduler", help="address of a dask.distributed scheduler, instead of processes"
            )
            command.add_argument("--part", default="1/1", help="K/N: every Nth point")
    commands.add_parser("draw").set_defaults(run=draw)
    arguments = parser.parse_args()
    arguments.run(arguments)


if __name__ == "__main__":
    main()
