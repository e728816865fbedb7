"""The map of Fig. 4 (top), ε ∈ [0.3, 1] × Δh ∈ [1 µm, 1 cm]: ours and peers at an error of 1e-7·V.

    python benchmarks/map_linear.py [--size 1000] [--write]

Ours computes the whole map, the peers random points of its grid, all on one thread.
"""

from __future__ import annotations

import numpy as np
from harness import arguments, compare, publish, sweep_method
from peers import linear_heyoka, linear_numba, linear_scipy, scaled

import hardlimit as hl

DRAWN = 4000
#: Steps and tolerances, found by trial, with a p95 error below 1e-7·V; heyoka's error changes in jumps with its order.
PEERS = [
    ("numba RK4, events", "step 0.042/ω", lambda p: linear_numba.run(p, "RK4", 0.042), 4000),
    ("numba DOP853, events", "step 0.85/ω", lambda p: linear_numba.run(p, "DOP853", 0.85), 4000),
    ("heyoka.py scalar, events", "tol 1e-7", lambda p: linear_heyoka.run(p, "scalar", 1e-7), 2000),
    ("heyoka.py batch, events", "tol 1e-7", lambda p: linear_heyoka.run(p, "batch", 1e-7), 4000),
    ("SciPy DOP853, events", "tol 5e-9", lambda p: linear_scipy.run(p, 5e-9), 200),
]


def main() -> None:
    a = arguments(__doc__, 1000)
    restitution, gap = np.linspace(0.3, 1.0, a.size), np.geomspace(1e-6, 1e-2, a.size)
    rng = np.random.default_rng(4)
    i, j = rng.integers(0, a.size, (2, DRAWN))
    full = np.ones(DRAWN)
    points = scaled.Points(restitution[i], gap[j], 0.1 * full, 0.01 * full, 5e7 * full)
    axes = {"restitution": restitution, "gap": gap}
    ours = [sweep_method("exact", hl.Column.paper(), (i, j), a.size**2, **axes)]
    columns = [scaled.column_linear(points, k) for k in range(DRAWN)]
    publish("map_linear", compare(ours, PEERS, points, columns, a.repetitions), a.write)


if __name__ == "__main__":
    main()
