"""CPU time per contact by events and by steps, beside the estimate of ``engine="auto"``: the table of docs/engines.md.

    python benchmarks/engine_choice.py [N …]

Equal spheres, φ = 0.3, ε = 0.9, from equilibrium, for three collisions of each particle at the initial rate.
"""

import sys
import time

from grains import RADIUS, by_events, by_steps, gas, law_of, rate_of
from harness import table

from hardlimit.boxes import time_step
from hardlimit.boxes.engine_choice import BY_EVENTS, BY_STEPS

TOUCHES = (0.01, 0.03, 0.1, 0.2, 0.3, 0.5, 1.0)
COLLISIONS = 3.0


def cost(engine, until: float) -> float:
    begun = time.process_time()
    engine.advance(until)
    return time.process_time() - begun


def row(n: int, touch: float) -> list[str]:
    system = gas(n)
    rate = rate_of(system)
    law = law_of(touch / rate)
    step = time_step.chosen(system, law, None, None)
    events, steps = by_events(system, law), by_steps(system, law, step)
    times = [cost(engine, COLLISIONS / rate) for engine in (events, steps)]
    estimates = BY_EVENTS[0] + BY_EVENTS[1] * touch, BY_STEPS[0] + BY_STEPS[1] / (rate * step)
    per_contact = [1e6 * took / max(events.n_contacts, 1) for took in times]
    shown = [f"{value:.3g}" for pair in zip(per_contact, estimates, strict=True) for value in pair]
    return [f"{n}", f"{touch:g}", *shown]


def main() -> None:
    sizes = [int(n) for n in sys.argv[1:]] or [1000, 4000]
    print(f"radius {RADIUS:g} m, µs per contact")
    head = ["N", "t_c ν", "events", "formula", "steps", "formula"]
    print(table(head, [row(n, touch) for n in sizes for touch in TOUCHES]))


if __name__ == "__main__":
    main()
