"""Cost of a collision in a sheared and in a shaken box, over that in a periodic box, with all three engines.

    python benchmarks/driven.py --write

All boxes have φ = 0.3 and ε = 0.9. The shear rate is that at which spheres of the initial temperature are in a steady
state. The periodic box in motion has the mean square velocity of that flow, the same for all particles: cells are at
rest, so that fast particles cross more of them. The shaken box has walls along z and no gravity; the floor moves as a
sine with half the thermal speed and an amplitude of half a radius. Boxes run in turn in each repetition, each time from
the same start; ratios are medians over the repetitions.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from grains import (
    DENSITY,
    RADIUS,
    RESTITUTION,
    by_events,
    by_steps,
    equilibrium,
    hard_spheres,
    law_of,
    rate_of,
)
from harness import publish, table

import hardlimit as hl
from hardlimit.boxes.theory import Gas

#: Duration of a contact times the collision rate.
SOFTNESS = 0.003
#: Collisions of a particle before a measurement and in one. With more the periodic box cools too far.
WARM, MEASURED = 1, 4


def boxes(n: int) -> dict[str, hl.ParticleSystem]:
    """Starts of one temperature."""
    periodic = equilibrium(hl.ParticleSystem.random(n, 0.3, RADIUS, DENSITY, rms_speed=1.0))
    heat = periodic.granular_temperature
    theory = Gas(n, RADIUS, float(periodic.mass[0]), periodic.domain.volume, 3)
    rate = math.sqrt(heat / theory.sheared_temperature(1.0, RESTITUTION))
    sheared = periodic.replace(boundary=("periodic", "lees-edwards", "periodic"), shear_rate=rate)
    sheared = sheared.replace(velocities=sheared.velocities + sheared.domain.mean_flow(sheared.positions))
    speed = rate * float(sheared.box[1]) / math.sqrt(12.0)
    moving = periodic.replace(velocities=periodic.velocities + np.array([speed, 0.0, 0.0]))
    amplitude = 0.5 * RADIUS
    floor = hl.MovingWall(amplitude, 0.5 * math.sqrt(heat) / (2.0 * math.pi * amplitude))
    sides = ("periodic", "periodic", "wall")
    walled = {"packing_fraction": 0.3, "radius": RADIUS, "density": DENSITY, "rms_speed": 1.0}
    shaken = hl.ParticleSystem.random(n, boundary=sides, walls={"z-": floor}, **walled)
    return {"periodic": periodic, "periodic, in motion": moving, "sheared": sheared, "shaken": shaken}


def of_hard_spheres(system: hl.ParticleSystem) -> float:
    """CPU time of a collision [s]."""
    run = hard_spheres(system, "constant", RESTITUTION)
    run.advance(math.inf, WARM * system.n // 2)
    begin, before = time.process_time(), run.n_contacts
    run.advance(math.inf, MEASURED * system.n // 2)
    return (time.process_time() - begin) / (run.n_contacts - before)


def of_newton(system: hl.ParticleSystem, make: Callable[..., Any], *step: float) -> float:
    """CPU time of a contact [s]. step: that of the engine, in units of the duration of a contact."""
    rate = rate_of(system)
    run = make(system, law_of(SOFTNESS / rate), *(factor * SOFTNESS / rate for factor in step))
    run.advance(WARM / rate)
    begin, before = time.process_time(), run.n_contacts
    run.advance(run.time + MEASURED / rate)
    return (time.process_time() - begin) / (run.n_contacts - before)


ENGINES: dict[str, Callable[[hl.ParticleSystem], float]] = {
    "hard spheres": of_hard_spheres,
    "Newton by events": lambda system: of_newton(system, by_events),
    "Newton by steps": lambda system: of_newton(system, by_steps, 0.02),
}


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--n", type=int, nargs="+", default=[4000, 32_000])
    parser.add_argument("--repetitions", type=int, default=9)
    parser.add_argument("--write", action="store_true", help="write the table into README.md")
    arguments = parser.parse_args()
    rows = []
    for n in arguments.n:
        starts = boxes(n)
        for name, engine in ENGINES.items():
            measured = np.array(
                [[engine(system) for system in starts.values()] for _ in range(arguments.repetitions)]
            )
            ratios = np.median(measured / measured[:, :1], axis=0)
            for box, seconds, ratio in zip(starts, np.median(measured, axis=0), ratios, strict=True):
                rows.append([name, f"{n:g}", box, f"{1e6 * seconds:.2f}", f"{ratio:.2f}"])
    head = ["engine", "spheres", "box", "collision [µs]", "over periodic"]
    publish("driven", table(head, rows), write=arguments.write)


if __name__ == "__main__":
    main()
