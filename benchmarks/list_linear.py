"""A list of independent points, ours and the peers of map_linear.py.

    python benchmarks/list_linear.py [--size 1000000] [--write]

ε ∈ [0.3, 1] and R1/R2 ∈ [1, 25] uniform, Δh ∈ [1 µm, 1 cm] and k ∈ [1e6, 1e9] N/m log-uniform. The peers compute the
first points of the list.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from harness import arguments, compare, publish, sweep_method
from map_linear import DRAWN, PEERS
from peers import scaled

import hardlimit as hl


def main() -> None:
    a = arguments(__doc__, 1_000_000)
    n = max(a.size, DRAWN)
    rng = np.random.default_rng(7)
    restitution, ratio = rng.uniform(0.3, 1.0, n), rng.uniform(1.0, 25.0, n)
    gap, stiffness = 10.0 ** rng.uniform(-6.0, -2.0, n), 10.0 ** rng.uniform(6.0, 9.0, n)
    points = scaled.Points(restitution, gap, 0.01 * ratio, np.full(n, 0.01), stiffness).first(DRAWN)
    swept = {"restitution": restitution, "gap": gap, "radius_ratio": ratio, "stiffness": stiffness}
    arrays = {name: xr.DataArray(values, dims="point") for name, values in swept.items()}
    ours = [sweep_method("exact", hl.Column.paper(), slice(DRAWN), n, **arrays)]
    columns = [scaled.column_linear(points, k) for k in range(DRAWN)]
    publish("list_linear", compare(ours, PEERS, points, columns, a.repetitions), a.write)


if __name__ == "__main__":
    main()
