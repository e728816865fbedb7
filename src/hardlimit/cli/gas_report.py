"""What ``hardlimit gas`` prints and saves."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from ..boxes import theory
from ..boxes.result import ContactResult, ParticleResult
from ..boxes.system import ParticleSystem, described
from ..support import saving
from .printing import console, digits, plain, show, table


def expected(result: ParticleResult) -> dict[str, float]:
    """What theory says of the quantities of a result, by their label; nothing where it does not apply."""
    system = result.system
    time, temperature = result.samples["time"], result.samples["granular_temperature"]
    if theory.why_not(system) is not None or not time[-1] > time[0]:
        return {}
    gas = theory.gas(system)
    rate = _mean(gas.collision_rate(temperature), time)
    found = {"mean collision rate [1/s]": rate}
    e = result.settings.restitution
    if e is not None:
        unit = "N/m" if system.dimension == 2 else "Pa"
        pressure = _mean(gas.pressure(temperature, e), time)
        found[f"mean pressure [{unit}]"] = pressure
        cooled = float(gas.cooling(np.array(result.time), float(temperature[0]), e))
        found["granular temperature at the end [m²/s²]"] = cooled
    return found


def _mean(values: Any, time: Any) -> float:
    """Mean over time by the trapezoidal rule."""
    return float(np.average(0.5 * (values[1:] + values[:-1]), weights=np.diff(time)))


def print_report(start: ParticleSystem, result: ParticleResult, files: list[Path]) -> None:
    """The system, what came out with theory beside it, where the rule may be wrong."""
    out = console()
    what = "spheres" if start.dimension == 3 else "disks"
    show(out, f"{start.n} {what}", table(["", ""], [[label, text] for label, text in described(start)]))
    theories = expected(result)
    rows = [
        [label, digits(value), digits(theories.get(label, math.nan))] for label, value in result.quantities()
    ]
    if not theories:
        rows = [row[:2] for row in rows]
    names = ["", "event-driven"] + (["theory"] if theories else [])
    show(out, f"Hard spheres, rule {result.settings.report()}", table(names, rows), note(start, result))
    out.print(
        f"outcome: {result.outcome}", style="default" if result.outcome_code == 0 else "yellow", markup=False
    )
    for path in files:
        out.print(f"written to {path}", markup=False)


def note(start: ParticleSystem, result: ParticleResult) -> str:
    """Which theory stands in the table, or why there is none."""
    reason = theory.why_not(start)
    if reason is not None:
        return f"No theory beside it: {reason}."
    names = ["Enskog’s rate"]
    if result.settings.restitution is not None:
        names += ["Carnahan and Starling’s pressure" if start.dimension == 3 else "Henderson’s pressure"]
        names += ["Haff’s law"] if result.settings.restitution < 1.0 else []
    return (
        f"Theory: {', '.join(names)}; rate and pressure at the temperatures measured. They differ from theory in the "
        f"first {theory.RELAXED} collisions per particle: a random start is no equilibrium."
    )


def as_mapping(start: ParticleSystem, result: ParticleResult, files: list[Path]) -> dict[str, Any]:
    """Everything the tables show and the series, in SI units."""
    settings = result.settings
    law = settings.law
    return mapping(
        start,
        result,
        files,
        {
            "rule": settings.rule,
            "restitution": settings.restitution,
            "law": None if law is None else {"name": law.record["name"], **law.parameters},
            "contact_duration": settings.contact_duration,
            "n_collisions": result.n_collisions,
            "n_pair_collisions": result.n_pairs,
            "n_wall_collisions": result.n_walls,
            "n_elastic_by_tc": result.n_elastic_by_tc,
            "n_soft": result.n_soft,
            "n_soft_third_body": result.n_soft_third_body,
            "theory": expected(result),
        },
    )


def mapping(
    start: ParticleSystem, result: ParticleResult | ContactResult, files: list[Path], own: dict[str, Any]
) -> dict[str, Any]:
    """What every run of a box tells, around what only this kind does."""
    series = result.series
    told: dict[str, Any] = plain(
        {
            "system": {
                "n": start.n,
                "dimension": start.dimension,
                "box": start.box,
                "boundary": start.boundary,
                "gravity": start.gravity,
                "packing_fraction": start.packing_fraction,
            },
            **own,
            "outcome": {"name": result.outcome_name, "message": result.outcome},
            "early_end": None if result.early_end is None else result.early_end._asdict(),
            "time": result.time,
            "series": {
                "time": series["time"].values,
                **{name: v.values for name, v in series.data_vars.items()},
            },
            "files": files,
        }
    )
    return told


def save(result: ParticleResult | ContactResult, path: Path, how: dict[str, str], log: str) -> Path:
    """Series, the log of that name if there is one, and the final state as groups of one NetCDF file.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    import xarray as xr

    about = {"title": "hardlimit gas", **how, "outcome": result.outcome}
    groups = {"/": xr.Dataset(attrs=about), "series": result.series, "final": result.system.dataset}
    if result.log is not None:
        groups[log] = getattr(result, log)
    return saving.groups(groups, path)
