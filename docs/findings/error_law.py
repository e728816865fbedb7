"""Measurement of the law of the error: the error of each hard-sphere rule in a cooling gas, divided by t_c ν.

    python docs/findings/error_law.py measure STORE [--replicas 32]
    python docs/findings/error_law.py collect STORE
    python docs/findings/error_law.py draw

``measure`` appends one line for each run to the file STORE and skips runs that are in it. ``collect`` gathers them in
error_law.nc beside this file. ``draw`` makes the figures and tables of error_law.md from that file.

Every replica starts from an elastic equilibrium of equal spheres or disks in a periodic box. A run is measured while
its energy E falls from y = 3 to 9 collisions per particle by Haff's law, y = √(E(0)/E) = exp((1 − ε²) n/(2D)). E is the
energy not yet dissipated, kinetic and stored in contacts. All models are therefore compared at the same energies, after
the transient of the start.
"""

from __future__ import annotations

import argparse
import json
import math
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import hardlimit as hl
from hardlimit.boxes import theory
from hardlimit.fidelity_study.starts import equilibrated

N = 8000
RADIUS, DENSITY, RMS_SPEED = 1e-3, 2500.0, 1.0  #: [m], [kg/m³], [m/s]
WINDOW = (3.0, 9.0)  #: collisions per particle by Haff's law
SAMPLES = 120
#: Replicas that are computed at all points before any point gets more.
PASS = 4
#: Initial t_c ν by dimension and packing fraction. Softer particles would be compressed beyond the laws' range.
TC_NU = {
    3: {0.02: (0.02,), 0.05: (0.03, 0.06), 0.1: (0.1,), 0.2: (0.1, 0.3), 0.35: (0.1, 0.3), 0.5: (0.1, 0.3)},
    2: {0.05: (0.02,), 0.2: (0.1,), 0.4: (0.1, 0.3), 0.6: (0.1,), 0.7: (0.3,)},
}
RESTITUTION = {3: (0.99, 0.9, 0.8, 0.6, 0.4), 2: (0.99, 0.8, 0.6, 0.4)}
#: The same for the viscoelastic law.
VISCOELASTIC = {3: {0.05: (0.03,), 0.2: (0.1,), 0.5: (0.3,)}, 2: {0.4: (0.1,)}}
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
    law = hl.Viscoelastic(
        youngs_modulus=1e7, poisson_ratio=0.3, restitution=point.restitution, impact_speed=speed
    )
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
        for model in models(point, before is None or before[:4] != point[:4]):
            for k in replicas:
                if (*point, model, k) in done:
                    continue
                if k not in starts:
                    starts[k] = equilibrated(random, k)
                found = solve(point, model, starts[k])
                out.write(json.dumps({"point": point, "model": model, "replica": k} | found) + "\n")
        before = point
    print("replicas", replicas, flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description="Measure the law of the error.")
    commands = parser.add_subparsers(required=True)
    command = commands.add_parser("measure")
    command.set_defaults(run=measure)
    command.add_argument("store", type=Path, help="file of the finished runs")
    command.add_argument("--replicas", type=int, default=32, help="[32]")
    arguments = parser.parse_args()
    arguments.run(arguments)


if __name__ == "__main__":
    main()
