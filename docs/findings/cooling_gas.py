"""How far each rule for hard spheres holds in a cooling gas, over t_c ν, packing fraction and restitution.

    python docs/findings/cooling_gas.py compute STORES [--workers 4] [--scheduler ADDRESS] [--part 1/8]
    python docs/findings/cooling_gas.py collect STORES
    python docs/findings/cooling_gas.py draw

``compute`` fills a folder with one store of ``hl.fidelity`` for each point of the grid and goes on where it was stopped:
whatever is finished is kept. ``--part 1/8`` does every eighth point, for eight jobs side by side. ``collect`` gathers what
is complete in cooling_gas.nc beside this file, ``draw`` makes the figures of docs/grains.md from that.

Every start is a periodic box of equal spheres in an elastic equilibrium. t_c ν is that of the start: Enskog's rate times
the contact duration of the linear dashpot, whose stiffness is chosen for it. A run ends when Haff's law expects 10
collisions of each particle.
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

import hardlimit as hl
from hardlimit import saving
from hardlimit.particles import theory
from hardlimit.particles.fidelity import MODELS
from hardlimit.particles.fidelity.lockstep import QUANTITIES
from hardlimit.particles.fidelity.starts import equilibrated
from hardlimit.progress import bar

HERE = Path(__file__).parent
DATA = HERE / "cooling_gas.nc"
IMAGES = HERE.parent / "images"

TC_NU = (1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3)
PACKING_FRACTION = (0.05, 0.2, 0.35, 0.5)
RESTITUTION = (0.7, 0.9, 0.99)
COLLISIONS = 10  #: of each particle
SAMPLES = 10
LONG = 0.1  #: t_c ν from which on Newton's equations are solved by steps: contacts hang together in large groups
RADIUS, DENSITY, RMS_SPEED = 1e-3, 2500.0, 1.0  #: [m], [kg/m³], [m/s]


class Point(NamedTuple):
    """One of the grid."""

    tc_nu: float
    packing_fraction: float
    restitution: float

    @property
    def name(self) -> str:
        return f"tc_nu_{self.tc_nu:g}_phi_{self.packing_fraction:g}_restitution_{self.restitution:g}.replicas"


def points() -> Iterator[Point]:
    """All of the grid, neighbours far apart, so that a part of it is a coarser grid."""
    every = list(itertools.product(TC_NU, PACKING_FRACTION, RESTITUTION))
    for first in range(5):
        yield from itertools.starmap(Point, every[first::5])


def start(packing_fraction: float, n: int) -> hl.ParticleSystem:
    """An elastic gas in equilibrium; the replicas of ``hl.fidelity`` are other states of it."""
    system = hl.ParticleSystem.random(n, packing_fraction, RADIUS, DENSITY, RMS_SPEED)
    return equilibrated(system, 0)


def law_and_end(point: Point, system: hl.ParticleSystem) -> tuple[hl.LinearDashpot, float]:
    """The law with this t_c ν at the start, and the time [s] of so many collisions by Haff's law."""
    gas = theory.Gas(system.n, RADIUS, float(system.mass[0]), float(np.prod(system.box)), 3)
    rate = float(gas.collision_rate(system.granular_temperature))
    ball = hl.Ball(RADIUS, density=DENSITY)
    unit = hl.LinearDashpot(stiffness=1.0, restitution=point.restitution)
    wanted = point.tc_nu / rate
    law = unit.replace(stiffness=(unit.between(ball, ball).duration() / wanted) ** 2)
    cooling = rate * (1.0 - point.restitution**2) / 6.0
    return law, math.expm1(COLLISIONS * cooling / rate) / cooling


def solve(point: Point, folder: Path, n: int, replicas: int, **where: object) -> hl.Fidelity:
    """One point; what its store holds is not computed again."""
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
            print(point.name, solve(point, arguments.stores, arguments.n, arguments.replicas, **where), flush=True)


def collect(arguments: argparse.Namespace) -> None:
    """The end of every replica of the points that are complete; NaN for the others."""
    shape = (len(TC_NU), len(PACKING_FRACTION), len(RESTITUTION), len(MODELS), arguments.replicas)
    found = {name: np.full(shape, math.nan) for name in (*QUANTITIES, "overlapped_share", "n_contacts", "end_time")}
    for point in points():
        if not (arguments.stores / point.name).exists():
            continue
        ds = solve(point, arguments.stores, arguments.n, arguments.replicas).replicas.isel(time=-1)
        at = TC_NU.index(point.tc_nu), PACKING_FRACTION.index(point.packing_fraction)
        for name, values in found.items():
            values[*at, RESTITUTION.index(point.restitution)] = ds[name].values
    dims = ("tc_nu", "packing_fraction", "restitution", "model", "replica")
    attributes = {name: ds[name].attrs for name in found}
    saving.dataset(
        xr.Dataset(
            {name: (dims, values, attributes[name]) for name, values in found.items()},
            {"tc_nu": list(TC_NU), "packing_fraction": list(PACKING_FRACTION), "restitution": list(RESTITUTION),
             "model": list(MODELS)},
            {"title": "Rules for hard spheres against Newton’s equations in a cooling gas, at the end of each replica",
             "source": f"hardlimit {hl.__version__}, docs/findings/cooling_gas.py", "n": arguments.n,
             "collisions_per_particle": COLLISIONS, "law": "LinearDashpot", "n_replicas": arguments.replicas},
        ),
        DATA,
    )  # fmt: skip


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
            command.add_argument("--scheduler", help="address of a scheduler of dask.distributed, instead")
            command.add_argument("--part", default="1/1", help="K/N: every Nth point")
    arguments = parser.parse_args()
    arguments.run(arguments)


if __name__ == "__main__":
    main()
