"""Particle-steps per second of ``molecular_dynamics(engine="steps")``, beside LAMMPS with the same law, step and skin.

    python benchmarks/newton_steps.py [--size 100000] [--write]

Equal spheres, periodic, ε = 0.9, t_c ν = 0.01, 50 steps per contact: N = 1e4 … ``--size`` at φ = 0.3 (a fluid) and 0.6
(a crystal, the equilibrium there), after two collisions of each particle as hard spheres.
"""

from __future__ import annotations

import math

import numpy as np
from grains import DENSITY, RADIUS, Run, by_steps, equilibrium, lammps_box, law_of, rate_of
from harness import Method, arguments, interleave, publish, table

import hardlimit as hl

STIFFNESS_OF_TOUCH, STEPS_PER_CONTACT = 0.01, 50
FRACTIONS, SIZES = (0.3, 0.6), (10_000, 100_000, 1_000_000)


def crystal(n: int, fraction: float) -> hl.ParticleSystem:
    """About n spheres on a face-centred cubic lattice, with random velocities of temperature 1 m²/s²."""
    along = max(2, round((n / 4) ** (1 / 3)))
    edge = (4 * 4 / 3 * math.pi * RADIUS**3 / fraction) ** (1 / 3)
    corner = np.stack(np.meshgrid(*[np.arange(along)] * 3, indexing="ij"), -1).reshape(-1, 1, 3)
    basis = np.array([[0, 0, 0], [0, 0.5, 0.5], [0.5, 0, 0.5], [0.5, 0.5, 0]]) + 0.25
    at = (corner + basis).reshape(-1, 3) * edge
    velocities = np.random.default_rng(0).normal(size=at.shape)
    return hl.ParticleSystem(at, velocities, RADIUS, density=DENSITY, box=along * edge)


def rows_of(n: int, fraction: float, repetitions: int) -> list[list[str]]:
    system = equilibrium(crystal(n, fraction))
    duration = STIFFNESS_OF_TOUCH / rate_of(system)
    law, step = law_of(duration), duration / STEPS_PER_CONTACT
    steps = max(20, 20_000_000 // system.n)
    single, two = (Run(by_steps(system, law, step), steps * step, threads) for threads in (1, 2))
    single()  # chooses its skin
    skin = single.engine.statistics()["skin"]
    lammps = lammps_box(system, law, step, skin)
    lammps.run(steps)
    check_energy(single, system, lammps)
    count = system.n * steps
    methods = [
        Method("hardlimit", "1 thread", single, count),
        Method("hardlimit", "2 threads", two, count),
        Method("LAMMPS", "same skin", lambda: lammps.run(steps // 4), count // 4),
    ]
    interleave(methods, repetitions)
    return [row(system, fraction, m, methods[0], skin) for m in methods]


def check_energy(single: Run, system: hl.ParticleSystem, lammps) -> None:
    """Check that both have lost about the same energy: the same physics is timed."""
    kinetic = [single.engine.observe()["kinetic_energy"], lammps.kinetic_energy()]
    lost = 1.0 - np.array(kinetic) / system.kinetic_energy
    if not np.ptp(lost) < 0.1 * lost[0] + 3e-3:
        raise RuntimeError(f"energies lost differ: {lost}")


def row(system: hl.ParticleSystem, fraction: float, m: Method, ours: Method, skin: float) -> list[str]:
    cpu, wall = np.array(m.cpu), np.array(m.wall)
    ratio, speed_up = np.median(cpu / np.array(ours.cpu)), np.median(np.array(ours.wall) / wall)
    paces = [f"{1e-6 / np.median(times):.1f}" for times in (cpu, wall)]
    left = [f"{system.n}", f"{fraction}", m.name, m.setting, f"{0.5 * skin / RADIUS:.3f}"]
    return [*left, *paces, f"{ratio:.2f}", f"{speed_up:.2f}"]


def main() -> None:
    a = arguments(__doc__, SIZES[-1])
    cases = [(n, fraction) for fraction in FRACTIONS for n in SIZES if n <= a.size]
    rows = [row for case in cases for row in rows_of(*case, a.repetitions)]
    head = ["N", "φ", "engine", "setting", "skin/diameter", "10⁶ particle-steps/s (CPU)", "(wall)"]
    head += ["CPU time, ours = 1", "speed-up (wall)"]
    publish("newton_steps", table(head, rows), a.write)


if __name__ == "__main__":
    main()
