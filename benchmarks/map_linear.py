"""Fig. 4 (top) as a map: ε ∈ [0.3, 1] × Δh ∈ [1 µm, 1 cm], ours against peers at matched error 1e-7·V.

    python benchmarks/map_linear.py [--size 1000] [--write]

Ours computes the whole map, the peers the first of 4000 grid points drawn at random, all on one thread.
"""

from __future__ import annotations

import numpy as np
from harness import Method, accuracy, arguments, comparison, interleave, publish
from peers import linear_heyoka, linear_numba, linear_scipy, scaled

import hardlimit as hl

DRAWN = 4000
#: Steps and tolerances with which the p95 error is below 1e-7·V, found by trying;
#: heyoka's goes in jumps with its order.
PEERS = [
    ("numba RK4, events", "step 0.042/ω", lambda p: linear_numba.run(p, "RK4", 0.042), 4000),
    ("numba DOP853, events", "step 0.85/ω", lambda p: linear_numba.run(p, "DOP853", 0.85), 4000),
    ("heyoka.py scalar, events", "tol 1e-7", lambda p: linear_heyoka.run(p, "scalar", 1e-7), 2000),
    ("heyoka.py batch, events", "tol 1e-7", lambda p: linear_heyoka.run(p, "batch", 1e-7), 4000),
    ("SciPy DOP853, events", "tol 5e-9", lambda p: linear_scipy.run(p, 5e-9), 200),
]


def compare(ours: Method, ours_at_drawn, points: scaled.Points, repetitions: int) -> str:
    """The table of ours and all peers; ``ours_at_drawn()`` gives counts and v'_r of the drawn points."""
    exact = [hl.newton(scaled.column_linear(points, i)) for i in range(len(points))]
    n = np.array([r.n_contacts for r in exact])
    v = np.array([r.relative_velocity for r in exact])
    speed = scaled.impact_speed(points)
    peers = []
    for name, setting, run, count in PEERS:
        some = points.first(count)
        peers.append(Method(name, setting, lambda run=run, some=some: run(some), count))
    interleave([ours, *peers], repetitions)
    accuracies = [accuracy(*ours_at_drawn(), n, v, speed)]
    for peer in peers:
        r = peer.run()
        accuracies.append(accuracy(r.n_contacts, r.relative_velocity, n, v, speed))
    return comparison([ours, *peers], accuracies)


def main() -> None:
    a = arguments(__doc__, 1000)
    restitution, gap = np.linspace(0.3, 1.0, a.size), np.geomspace(1e-6, 1e-2, a.size)
    rng = np.random.default_rng(4)
    i, j = rng.integers(0, a.size, (2, DRAWN))
    full = np.ones(DRAWN)
    points = scaled.Points(restitution[i], gap[j], 0.1 * full, 0.01 * full, 5e7 * full)
    kept = {}

    def run() -> None:
        kept["ds"] = hl.sweep(
            hl.Column.paper(), threads=1, variables=scaled.RESULTS, restitution=restitution, gap=gap
        )

    def at_drawn():
        ds = kept["ds"]
        return ds.n_contacts.values[i, j], ds.relative_velocity.values[i, j]

    ours = Method("hardlimit", "exact", run, a.size**2)
    publish("map_linear", compare(ours, at_drawn, points, a.repetitions), a.write)


if __name__ == "__main__":
    main()
