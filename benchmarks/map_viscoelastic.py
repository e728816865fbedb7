"""A map of viscoelastic balls: ours, heyoka.py and numba at an error of 1e-8·V, and ours with the default tolerance.

    python benchmarks/map_viscoelastic.py [--size 1000] [--write]

Spheres of Fig. 7 (R2 = 0.25 cm, Y = 5e7 N/m², ν = 0.45, restitution at 3 m/s): ε ∈ [0.4, 1) × Δh ∈ [1 µm, 1 cm]. The
peers are given ρ and A of each contact; ours computes A from the restitution. Errors are relative to hl.newton.
"""

from __future__ import annotations

import numpy as np
from harness import arguments, compare, publish, sweep_method
from peers import scaled, viscoelastic_heyoka, viscoelastic_numba

import hardlimit as hl

DRAWN = 1000
#: At the error of the peers, and with the default tolerance.
OURS = [("tol 7e-9", 7e-9), ("tol 2.3e-10", None)]
#: Steps and tolerances, found by trial, with a p95 error just below 1e-8·V.
PEERS = [
    ("numba RK4, events", "step 0.025", lambda p: viscoelastic_numba.run(p, "RK4", 0.025), 200),
    ("numba DOP853, events", "step 0.38", lambda p: viscoelastic_numba.run(p, "DOP853", 0.38), 1000),
    ("heyoka.py scalar, events", "tol 1e-8", lambda p: viscoelastic_heyoka.run(p, "scalar", 1e-8), 1000),
    ("heyoka.py batch, events", "tol 1e-8", lambda p: viscoelastic_heyoka.run(p, "batch", 1e-8), 1000),
]


def column(restitution: float, gap: float) -> hl.Column:
    law = hl.Viscoelastic(youngs_modulus=5e7, poisson_ratio=0.45, restitution=restitution, impact_speed=3.0)
    return hl.Column.paper(gap=gap, radius_2=0.0025, law=law)


def main() -> None:
    a = arguments(__doc__, 1000, 3)
    restitution, gap = np.linspace(0.4, 0.999, a.size), np.geomspace(1e-6, 1e-2, a.size)
    rng = np.random.default_rng(8)
    i, j = rng.integers(0, a.size, (2, DRAWN))
    columns = [column(e, h) for e, h in zip(restitution[i], gap[j], strict=True)]
    points = scaled.Points(
        restitution[i],
        gap[j],
        np.full(DRAWN, 0.1),
        np.full(DRAWN, 0.0025),
        elastic=np.array([[c.elastic_prefactor for c in col.contacts] for col in columns]),
        dissipative_time=np.array([[c.dissipative_time for c in col.contacts] for col in columns]),
    )
    axes = {"restitution": restitution, "gap": gap}
    ours = [
        sweep_method(setting, column(0.7, 1e-4), (i, j), a.size**2, tolerance=tolerance, **axes)
        for setting, tolerance in OURS
    ]
    publish("map_viscoelastic", compare(ours, PEERS, points, columns, a.repetitions), a.write)


if __name__ == "__main__":
    main()
