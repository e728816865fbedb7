"""What the studies of driven gases share: conditions, axes, the temperature that is reached."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

import xarray as xr
from driver import Study, linear_law

import hardlimit as hl

RADIUS, DENSITY = 1e-3, 2500.0  #: [m], [kg/m³]
TEMPERATURE = 1.0  #: predicted by kinetic theory for hard spheres [m²/s²]
RESTITUTION = (0.9, 0.7)
BERZI_JENKINS: Final = 0.110  #: t over t_c of the linear law: (d/5)√(πρd/4k), Soft Matter 11, 4799 (2015)
ABOUT = {"tc_nu": "by Enskog's theory at the temperature that kinetic theory predicts for hard spheres"}
Grid = dict[float, tuple[float, ...]]  # t_c ν measured at each φ, by Enskog's theory at TEMPERATURE


def axes(grid: Grid, models: Sequence[str]) -> dict[str, Sequence[Any]]:
    rates = sorted({tc_nu for row in grid.values() for tc_nu in row})
    return {"packing_fraction": sorted(grid), "restitution": RESTITUTION, "model": models, "tc_nu": rates}


def study(values: Mapping[str, str], about: Mapping[str, Any], **parts: Any) -> Study:
    """A study of a driven gas with the meanings of its values, which have no unit."""
    meanings = {name: ("1", text) for name, text in values.items()}
    return Study(values=meanings, about={**about, **ABOUT}, dpi=200, **parts)


def law(restitution: float, system: hl.ParticleSystem, duration: float) -> hl.LinearDashpot:
    return linear_law(restitution, hl.Ball(RADIUS, mass=float(system.mass[0])), duration)


def cases(grid: Grid, ds: xr.Dataset) -> Iterator[tuple[float, float, float, xr.Dataset]]:
    """φ, ε, t_c ν and the values there."""
    for phi, values in grid.items():
        for epsilon in RESTITUTION:
            for tc_nu in values:
                yield phi, epsilon, tc_nu, ds.sel(packing_fraction=phi, restitution=epsilon, tc_nu=tc_nu)


def real_tc_nu(ds: xr.Dataset, tc_nu: float) -> float:
    """Enskog's t_c ν at the temperature under Newton's equations."""
    return tc_nu * math.sqrt(float(ds.temperature.sel(model="newton").mean()))


def percent(value: float, error: float, theory: float, digits: int) -> str:
    """``measured ± error / theory`` in per cent, for a table."""
    shown = "–" if math.isnan(value) else f"{100.0 * value:.{digits}f}±{100.0 * error:.{digits}f}"
    return f"{shown} / {100.0 * theory:.{digits}f}"
