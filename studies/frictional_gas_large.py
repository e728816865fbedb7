"""A test of the law of the error with friction: the gases of frictional_gas.py, five times as many particles in a box,
from the same starts under Newton's equations and as hard spheres under the rule law (see driver.py). Nothing of the
law was fitted to these runs.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import driver
import frictional_gas as gas
import numpy as np
import xarray as xr

from hardlimit.support.estimate import Estimate

gas.N = 20_000  # of all starts, which are made later
#: Starts of a gas: more where t_c ν is small, and with it the error.
REPLICAS, MORE_REPLICAS = 16, 28


def points(replica: int) -> Iterator[driver.Point]:
    for point in sorted(set(gas.gases())):  # the start is that of the gas
        if replica < (REPLICAS if point.dimension == 3 and point.tc_nu == 0.3 else MORE_REPLICAS):
            yield *point, "newton"
            yield *point, "law"


def coefficient(ds: xr.Dataset, i: int) -> Estimate[float]:
    """a: the ratio of the times for the same loss of energy, less 1, over t_c ν."""
    at = ds.isel(point=i)
    longer = driver.paired(*(at["duration"].sel(model=name).values for name in ("newton", "law")))
    tc_nu = float(at["mean_tc_nu"].sel(model="law").mean())
    return longer._replace(value=longer.value / tc_nu, error=longer.error / tc_nu)


def tables(ds: xr.Dataset) -> str:
    rows, squares = [], []
    for i, point in enumerate(gas.all_points(ds)):
        a, law = coefficient(ds, i), gas.theory_of(point)
        of_gas = [f"{x:g}" for x in (point.packing_fraction, *point[3:])]
        of_gas[0] = f"{'disks' if point.dimension == 2 else 'spheres'} {of_gas[0]}"
        of_gas[-1] += ", Hertz" * (point.law != "linear")
        rows.append(
            (*of_gas, f"{a.value:.3f}±{a.error:.3f}", f"{law.coefficient:.3f}±{law.coefficient_error:.3f}")
        )
        squares.append(((a.value - law.coefficient) / math.hypot(a.error, law.coefficient_error)) ** 2)
    head = "φ | ε | t_c ν | μ | ρ | γ_t/γ_n | θ(0) | a | law"
    return f"{driver.table(head, rows)}\n\nχ² = {np.sum(squares):.1f} of {len(rows)} values"


STUDY = driver.Study(
    file=__file__,
    points=points,
    run=gas.run,
    replicas=MORE_REPLICAS,
    values=gas.MEASURED,
    gather=gas.gather,
    about={"title": "Cooling of 20,000 particles with friction", "n": gas.N, "window": gas.WINDOW},
    draw=lambda ds: {},
    tables=tables,
)

if __name__ == "__main__":
    driver.main(STUDY, __doc__)
