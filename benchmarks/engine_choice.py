"""What a contact costs by events and by steps, beside what ``engine="auto"`` estimates: the table of docs/grains.md.

    python benchmarks/engine_choice.py [N …]

Equal spheres, φ = 0.3, ε = 0.9, from equilibrium, for three collisions of each at the rate of the start, in CPU time.
"""

import sys
import time

from harness import table
from newton_events import RADIUS, law_of, rate_of, start

from hardlimit import _core
from hardlimit.boxes import time_step
from hardlimit.boxes.engine_choice import BY_EVENTS, BY_STEPS
from hardlimit.boxes.engines import choice, engine_arguments

TOUCHES = (0.01, 0.03, 0.1, 0.2, 0.3, 0.5, 1.0)
COLLISIONS = 3.0


def cost(engine, until: float) -> float:
    begun = time.process_time()
    engine.advance(until)
    return time.process_time() - begun


def row(n: int, touch: float) -> list[str]:
    system = start(n)
    rate = rate_of(system)
    law = law_of(system, touch / rate)
    step = time_step.chosen(system, law, None, None)
    given, laws = engine_arguments(system), {"law": choice(law)}
    events = _core.make_engine("newton_events", *given, **laws)
    steps = _core.make_engine("newton_steps", *given, **laws, time_step=step)
    times = [cost(engine, COLLISIONS / rate) for engine in (events, steps)]
    said = BY_EVENTS[0] + BY_EVENTS[1] * touch, BY_STEPS[0] + BY_STEPS[1] / (rate * step)
    of_each = [1e6 * took / max(events.n_contacts, 1) for took in times]
    shown = [f"{value:.3g}" for pair in zip(of_each, said, strict=True) for value in pair]
    return [f"{n}", f"{touch:g}", *shown]


def main() -> None:
    sizes = [int(n) for n in sys.argv[1:]] or [1000, 4000]
    print(f"radius {RADIUS:g} m, µs for each contact")
    head = ["N", "t_c ν", "events", "formula", "steps", "formula"]
    print(table(head, [row(n, touch) for n in sizes for touch in TOUCHES]))


if __name__ == "__main__":
    main()
