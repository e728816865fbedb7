"""How time and memory of each engine of boxes grow: over N, the packing fraction, unequal sizes and t_c ν.

    python benchmarks/growth.py [--size 10000000] [--write]

Spheres in a periodic box from equilibrium; φ = 0.3, N = 1e4 and t_c ν = 0.01 unless varied. CPU time per collision of
elastic hard spheres, and per contact of Newton's equations (ε = 0.9, about one contact of each particle), on one
thread; steps of t_c/50. All points of a panel are measured in turn, ``--repetitions`` times; a value is the median.
LAMMPS takes part where ``lammps[mpi]`` is installed. ``--write`` puts the table into README.md and the figure into
docs/images/growth.png.
"""

from __future__ import annotations

import importlib.util
import math
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NamedTuple

import matplotlib.pyplot as plt
import numpy as np
from grains import (
    DENSITY,
    RADIUS,
    by_events,
    by_steps,
    equilibrium,
    hard_spheres,
    lammps_box,
    law_of,
    rate_of,
)
from harness import arguments, publish, table

import hardlimit as hl
from hardlimit.boxes.engine_choice import BY_EVENTS, BY_STEPS

FIGURE = Path(__file__).parents[1] / "docs" / "images" / "growth.png"
STEPS_PER_CONTACT, WARM = 50, 4.0
SECONDS = 0.3  # CPU time of one measurement, at least
#: Largest N of each engine: memory allows more, patience does not.
MOST = {"hard spheres": 10_000_000, "events": 1_000_000, "steps": 1_000_000, "LAMMPS": 100_000}
#: Microseconds per collision of the best public engine for hard spheres (EDMD, its best variant at φ = 0.3; the table
#: of README.md), and the time of the arithmetic alone and of the cache lines of a collision.
PEER = {1e4: 1.84, 1e6: 6.7}
FLOOR = {1e4: 0.575, 1e6: 0.9}
STYLE = {
    "hard spheres": ("#0072b2", "o"),
    "events": ("#d55e00", "s"),
    "steps": ("#009e73", "^"),
    "LAMMPS": ("#7f7f7f", "x"),
}


class Point(NamedTuple):
    """One measurement: ``begin()`` makes an engine and returns what advances it and what counts its collisions."""

    panel: str
    engine: str
    at: float
    begin: Callable[[], tuple[Callable[[], object], Callable[[], float]]]
    bytes: float  # per particle


def spheres(n: int, fraction: float = 0.3, radius=RADIUS) -> hl.ParticleSystem:
    return equilibrium(hl.ParticleSystem.random(n, fraction, radius, DENSITY, rms_speed=1.0))


def sizes(ratio: float, n: int = 10_000) -> np.ndarray:
    """One particle in a hundred is ``ratio`` times as large as the others."""
    radius = np.full(n, RADIUS)
    radius[: n // 100] *= ratio
    return radius


def of_hard_spheres(panel: str, at: float, system: hl.ParticleSystem) -> Point:
    engine = hard_spheres(system, "constant", 1.0)
    engine.advance(math.inf, int(0.5 * WARM * system.n))
    some = max(system.n // 2, 10_000)
    begun = (lambda: engine.advance(math.inf, some), lambda: engine.n_contacts)
    return Point(panel, "hard spheres", at, lambda: begun, engine.memory / system.n)


def of_newton(
    panel: str, at: float, system: hl.ParticleSystem, tc_nu: float, engines: Iterable[str]
) -> list[Point]:
    """The gas cools, so that t_c ν falls: each measurement begins with the system."""
    rate = rate_of(system)
    law = law_of(tc_nu / rate)
    step = tc_nu / rate / STEPS_PER_CONTACT
    steps = max(20, min(math.ceil(1.0 / (rate * step)), 20_000_000 // system.n))

    def by(name: str) -> tuple[Callable[[], object], Callable[[], float]]:
        if name == "LAMMPS":  # it counts no contacts: those of the gas at its initial rate
            box = lammps_box(system, law, step, 0.02 * 2.0 * RADIUS)
            box.run(20)
            done = [0]
            return lambda: (
                box.run(steps),
                done.append(steps),
            ), lambda: 0.5 * system.n * rate * step * sum(done)
        engine = by_events(system, law) if name == "events" else by_steps(system, law, step)
        engine.advance((0.2 if name == "events" else 20 * step * rate) / rate)
        span = 1.0 / rate if name == "events" else steps * step
        return lambda: engine.advance(engine.time + span), lambda: engine.n_contacts

    memory = {"events": by_events, "steps": lambda s, w: by_steps(s, w, step)}
    return [
        Point(
            panel, name, at, lambda name=name: by(name),
            memory[name](system, law).memory / system.n if name in memory else math.nan,
        )
        for name in engines
        if system.n <= MOST[name] and (name != "LAMMPS" or importlib.util.find_spec("lammps"))
    ]  # fmt: skip


def cost(point: Point) -> float:
    """Microseconds of CPU time per collision."""
    took, collisions = 0.0, 0.0
    while took < SECONDS or not collisions:
        advance, count = point.begin()
        before, begun = count(), time.process_time()
        advance()
        took += time.process_time() - begun
        collisions += count() - before
    return 1e6 * took / collisions


def over_n(most: int) -> Iterable[list[Point]]:
    for n in (10**k for k in range(3, 8) if 10**k <= most):
        system = spheres(n)
        yield [
            of_hard_spheres("N", n, system),
            *of_newton("N", n, system, 0.01, ("events", "steps", "LAMMPS")),
        ]


def over_fraction(_: int) -> Iterable[list[Point]]:
    for fraction in (0.01, 0.03, 0.1, 0.2, 0.3, 0.4, 0.5):
        system = spheres(10_000, fraction)
        yield [
            of_hard_spheres("φ", fraction, system),
            *of_newton("φ", fraction, system, 0.01, ("events", "steps")),
        ]


def over_ratio(_: int) -> Iterable[list[Point]]:
    for ratio in (1.0, 2.0, 5.0, 10.0, 20.0, 50.0):
        yield [of_hard_spheres("size ratio", ratio, spheres(10_000, 0.3, sizes(ratio)))]


def over_tc_nu(_: int) -> Iterable[list[Point]]:
    system = spheres(10_000)
    for tc_nu in (1e-4, 1e-3, 0.01, 0.03, 0.1, 0.3, 1.0):
        yield of_newton("t_c ν", tc_nu, system, tc_nu, ("events", "steps"))


def draw(panels: dict[tuple[str, str], list[tuple[float, float]]]) -> plt.Figure:
    figure, axes = plt.subplots(1, 4, figsize=(13, 3.6), sharey=True, layout="constrained")
    labels = {
        "N": "number of particles N",
        "φ": "packing fraction φ",
        "size ratio": "size ratio (1 % large)",
        "t_c ν": r"$t_c\nu$",
    }
    for ax, panel in zip(axes, labels, strict=True):
        for (of, engine), points in panels.items():
            if of == panel:
                colour, marker = STYLE[engine]
                ax.loglog(*zip(*sorted(points), strict=True), color=colour, marker=marker, label=engine)
        ax.set(xlabel=labels[panel])
        ax.grid(alpha=0.3)
    axes[0].plot(*zip(*PEER.items(), strict=True), "D:", color="black", ms=4, label="EDMD")
    axes[0].plot(
        *zip(*FLOOR.items(), strict=True), "--", color="#0072b2", lw=1, label="floor of hard spheres"
    )
    x = np.geomspace(1e-4, 1.0, 50)
    axes[3].plot(
        x, BY_EVENTS[0] + BY_EVENTS[1] * x, ":", color=STYLE["events"][0], label="formula of engine='auto'"
    )
    axes[3].plot(x, BY_STEPS[0] + BY_STEPS[1] * STEPS_PER_CONTACT / x, ":", color=STYLE["steps"][0])
    axes[0].set_ylabel("CPU time per collision [µs]")
    for ax in (axes[0], axes[3]):
        ax.legend(fontsize=7)
    return figure


def main() -> None:
    a = arguments(__doc__, 10_000_000, 3)
    times: dict[tuple[str, str], list[tuple[float, float]]] = {}
    rows = []
    for panel in (over_n, over_fraction, over_ratio, over_tc_nu):
        for points in panel(a.size):
            costs = np.median([[cost(p) for p in points] for _ in range(a.repetitions)], axis=0)
            for p, microseconds in zip(points, costs, strict=True):
                times.setdefault((p.panel, p.engine), []).append((p.at, float(microseconds)))
                memory = f"{p.bytes:.0f}" if math.isfinite(p.bytes) else "–"
                rows.append([p.panel, f"{p.at:g}", p.engine, f"{microseconds:.3g}", memory])
                print(*rows[-1], flush=True)
    head = ["varied", "value", "engine", "µs per collision (CPU)", "bytes/particle"]
    publish("growth", table(head, rows), a.write)
    if a.write:
        draw(times).savefig(FIGURE, dpi=150)


if __name__ == "__main__":
    main()
