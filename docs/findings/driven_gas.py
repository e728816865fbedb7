"""What the measurements of driven gases share: conditions, the store of runs, replicas as NetCDF, ratios of models."""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, Final

import numpy as np
import xarray as xr

import hardlimit as hl
from hardlimit.support import saving

RADIUS, DENSITY = 1e-3, 2500.0  #: [m], [kg/m³]
TEMPERATURE = 1.0  #: predicted by kinetic theory for hard spheres [m²/s²]
RESTITUTION = (0.9, 0.7)
BERZI_JENKINS: Final = 0.110  #: t over t_c of the linear law: (d/5)√(πρd/4k), Soft Matter 11, 4799 (2015)
Point = tuple[float, float, str, float]  # φ, ε, model, t_c ν
Grid = dict[float, tuple[float, ...]]  # t_c ν measured at each φ, by Enskog's theory at TEMPERATURE


def linear_law(epsilon: float, system: hl.ParticleSystem, duration: float) -> hl.LinearDashpot:
    """The linear law with this restitution and duration of a contact [s]."""
    ball = hl.Ball(RADIUS, mass=float(system.mass[0]))
    unit = hl.LinearDashpot(stiffness=1.0, restitution=epsilon).between(ball, ball).duration(1.0)
    return hl.LinearDashpot(stiffness=float(unit / duration) ** 2, restitution=epsilon)


# --- store ----------------------------------------------------------------------------------------------------


def lines_of(store: Path) -> list[dict[str, Any]]:
    """The runs in a store."""
    return [json.loads(line) for line in store.read_text().splitlines()] if store.exists() else []


def append(store: Path, line: dict[str, Any]) -> None:
    """Add a run to a store."""
    with store.open("a") as file:
        file.write(json.dumps(line) + "\n")


def measure(
    store: Path, wanted: Iterable[tuple[Point, int]], run: Callable[[Point, int], dict[str, float]]
) -> None:
    """Append the values of each point and replica that is not in the store."""
    known = {(tuple(one["point"]), one["replica"]) for one in lines_of(store)}
    for point, replica in wanted:
        if (point, replica) not in known:
            append(store, {"point": point, "replica": replica, "values": run(point, replica)})


def collect(
    store: Path, data: Path, values: dict[str, str], grid: Grid, models: tuple[str, ...], **about: Any
) -> None:
    """Write all replicas as NetCDF; NaN where a run is missing or ended early. ``values``: the meaning of each."""
    phis, rates, lines = sorted(grid), sorted({x for row in grid.values() for x in row}), lines_of(store)
    shape = (len(phis), len(RESTITUTION), len(models), len(rates), 1 + max(one["replica"] for one in lines))
    arrays = {name: np.full(shape, math.nan) for name in values}
    for line in lines:
        phi, epsilon, model, tc_nu = line["point"]
        at = slice(None) if model == "constant" else rates.index(tc_nu)
        where = phis.index(phi), RESTITUTION.index(epsilon), models.index(model), at, line["replica"]
        for name, value in line["values"].items():
            arrays[name][where] = value
    dims = ("packing_fraction", "restitution", "model", "tc_nu", "replica")
    found = xr.Dataset(
        {name: (dims, arrays[name], {"units": "1", "long_name": values[name]}) for name in values},
        {"packing_fraction": phis, "restitution": list(RESTITUTION), "model": list(models), "tc_nu": rates},
        {
            "source": f"hardlimit {hl.__version__}, docs/findings/{data.stem}.py",
            "tc_nu": "by Enskog's theory at the temperature that kinetic theory predicts for hard spheres",
            **about,
        },
    )
    saving.groups({"/": found}, data)


# --- results --------------------------------------------------------------------------------------------------


def mean(values: xr.DataArray) -> tuple[float, float]:
    """The mean over replicas with its standard error; NaN for fewer than two."""
    known = values.dropna("replica")
    n = known.sizes["replica"]
    if n < 2:
        return math.nan, math.nan
    return float(known.mean()), float(known.std(ddof=1)) / math.sqrt(n)


def ratio(one: xr.DataArray, other: xr.DataArray, power: float = 1.0) -> tuple[float, float]:
    """(⟨one⟩/⟨other⟩)^power − 1 with its standard error, over replicas."""
    (first, error), (second, other_error) = mean(one), mean(other)
    found = (first / second) ** power
    return found - 1.0, abs(power * found) * math.hypot(error / first, other_error / second)


def real_tc_nu(ds: xr.Dataset, tc_nu: float) -> float:
    """Enskog's t_c ν at the temperature under Newton's equations."""
    return tc_nu * math.sqrt(float(ds.temperature.sel(model="newton").mean()))


def percent(value: float, error: float, law: float, digits: int) -> str:
    """``measured ± error / law`` in per cent, for a table."""
    shown = "–" if math.isnan(value) else f"{100.0 * value:.{digits}f}±{100.0 * error:.{digits}f}"
    return f"{shown} / {100.0 * law:.{digits}f}".replace("-", "−")


def command_line(
    description: str | None,
    store: str,
    replicas: int,
    measure: Callable[[Path, int], None],
    collect: Callable[[Path], None],
    draw: Callable[[], None],
) -> None:
    """Run one of the three tasks of a measurement, as the command line says."""
    parser = argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("task", choices=("measure", "collect", "draw"))
    parser.add_argument("store", nargs="?", type=Path, default=Path(store))
    parser.add_argument("--replicas", type=int, default=replicas)
    given = parser.parse_args()
    if given.task == "measure":
        measure(given.store, given.replicas)
    elif given.task == "collect":
        collect(given.store)
    else:
        draw()
