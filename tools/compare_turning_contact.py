"""Compare the turning contact with friction with SciPy's integration over many random contacts.

    python tools/compare_turning_contact.py 2000 [FIRST SEED]

Draws are those of tests/boxes/test_turning_contact.py: law, model and limit of friction, restitution, damping, inertia,
radii, masses, v t_c/d, spins and velocities in space. A line of JSON each goes to standard output, a table of the worst
of each model to standard error. A draw takes 0.1 to 1 s; one that would take many seconds is left out.
"""

import collections
import json
import sys
from pathlib import Path

TESTS = Path(__file__).parents[1] / "tests"
sys.path[:0] = [str(TESTS), str(TESTS / "boxes")]
from test_turning_contact import deviations, drawn  # noqa: E402

from frictional_motion import TooCostlyError  # noqa: E402


def main(first: int, number: int) -> None:
    worst: dict[str, list[float]] = collections.defaultdict(list)
    left_out: collections.Counter[str] = collections.Counter()
    for seed in range(first, first + number):
        draw = drawn(seed)
        friction = draw.law.friction
        if friction is None or friction.coefficient == 0.0:
            continue
        law = f"{type(draw.law).__name__}, {friction.model}"
        try:
            sizes = deviations(draw)
        except TooCostlyError:
            left_out[law] += 1
            continue
        print(json.dumps({"seed": seed, "law": law, "limit": friction.limit, **sizes}), flush=True)
        worst[law].append(max(sizes.values()))
    for law, values in sorted(worst.items()):
        print(
            f"{law:38} {len(values):5} draws, largest deviation {max(values):.1e}, {left_out[law]} left out",
            file=sys.stderr,
        )


if __name__ == "__main__":
    main(int(sys.argv[2]) if len(sys.argv) > 2 else 0, int(sys.argv[1]))
