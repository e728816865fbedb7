"""The job of a sweep: the table ``[sweep]`` of a file, changed by the options."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..column import files
from ..column.scenario import Column
from ..support import toml
from .axes import axis, units_of
from .options import all_law_parameters, file_name, given_law_parameters, picture, writable

#: What a job may set; None where it does not.
SETTINGS = {
    "model": str | None,
    "engine": str | None,
    "threads": int | None,
    "scheduler": str | None,
    "tolerance": float | None,
    "variables": str | list[str] | None,
    "out": str | None,
    "plot": str | None,
    "difference": str | None,
}


@dataclass(frozen=True)
class Job:
    """One sweep: what is computed, and where it goes."""

    column: Column
    axes: dict[str, Any]  #: swept names with a number or an array each, in order
    run: dict[str, Any]  #: model, engine, … as hardlimit.sweep takes them
    out: Path | None
    pictures: dict[str, Path | None]  #: "plot" and "difference"


def make_job(file: str | None, resume: bool, given: dict[str, Any]) -> Job:
    """The job of a file, or of Fig. 2 without one, changed by the options.

    Raises
    ------
    ValueError
        For anything that no sweep can be made of.
    """
    base, table, axes = read(file)
    options = {name: given.pop(name) for name in SETTINGS}
    settings = {name: table[name] if value in (None, ()) else value for name, value in options.items()}
    column, swept = column_and_axes(base, given, axes)
    if not swept:
        raise ValueError("axes: got none, must be at least one, such as --restitution 0.4:1:100")
    pictures = {name: picture(name, settings.pop(name)) for name in ("plot", "difference")}
    check_drawable(pictures, swept)
    out = checked_output(settings.pop("out"), resume)
    settings["model"] = settings["model"] or "newton"
    settings["engine"] = settings["engine"] or "cpu"
    settings["variables"] = wanted_variables(settings["variables"], pictures)
    return Job(column, swept, settings, out, pictures)


def read(file: str | None) -> tuple[files.Scenario, dict[str, Any], dict[str, Any]]:
    """The column, the settings and the axes of a job file; the preset and nothing without one."""
    if file is None:
        return files.of_column(Column.paper()), dict.fromkeys(SETTINGS), {}
    from msgspec import structs

    base, extra = files.read_with(file, "sweep")
    whole = files.prefixed(f"{file}: ", lambda: toml.convert(extra, _schema(len(base.balls))))
    if whole.sweep is None:
        return base, dict.fromkeys(SETTINGS), {}
    table = structs.asdict(whole.sweep)
    axes = table.pop("axes")
    # In the order of the file, which is that of the dimensions.
    order = extra["sweep"].get("axes", {})
    return base, table, {name: getattr(axes, name) for name in order}


def _schema(balls: int) -> Any:
    """The structure of the table ``[sweep]``."""
    from msgspec import UNSET, UnsetType, defstruct, field

    values = float | str | list[float | str] | UnsetType
    axes = defstruct(
        "AxesTable",
        [(name, values, UNSET) for name in units_of(balls)],
        kw_only=True,
        forbid_unknown_fields=True,
    )
    settings: list[Any] = [(name, kind, None) for name, kind in SETTINGS.items()]
    settings.append(("axes", axes, field(default_factory=axes)))
    sweep = defstruct("SweepTable", settings, forbid_unknown_fields=True)
    return defstruct("JobTable", [("sweep", sweep | None, None)])


def column_and_axes(
    base: files.Scenario, options: dict[str, Any], axes: dict[str, Any]
) -> tuple[Column, dict[str, Any]]:
    """The column, and what of the options and the file's axes is swept, in the order of the options."""
    law = options.pop("law")
    asked = {name: value for name, value in options.items() if value is not None}
    units = units_of(len(base.balls))
    of_file = {name: axis(name, value, units[name]) for name, value in axes.items() if name not in asked}
    asked = of_file | asked
    of_law = given_law_parameters({name: asked.get(name) for name in all_law_parameters()})
    if law is not None or of_law:
        first = {name: float(np.ravel(value)[0]) for name, value in of_law.items()}
        base = files.with_law(base, law, first)
    swept = {name: value for name, value in asked.items() if np.ndim(value) or name not in of_law}
    if not any(np.ndim(value) for value in swept.values()):
        swept = {}
    return base.column(), swept


def checked_output(out: str | None, resume: bool) -> Path | None:
    """Where the map goes; an existing store is only touched to resume it."""
    if out is None:
        if resume:
            raise ValueError("--resume: needs --out, must name the Zarr store to go on with")
        return None
    path = file_name("out", out)
    if path.suffix == ".nc":
        if resume:
            raise ValueError(f"--resume: got --out {out!r}, must be a Zarr store (.zarr)")
        return writable("out", out, ".nc")
    if path.suffix != ".zarr":
        raise ValueError(f"--out: got {out!r}, must end in .nc or .zarr")
    if path.exists() and not resume:
        raise ValueError(f"--out: got {out!r}, which exists: --resume goes on with it")
    return path


def wanted_variables(named: Any, pictures: dict[str, Path | None]) -> tuple[str, ...] | None:
    """The variables asked for, and those the pictures need; None for the usual ones."""
    if not named:
        return None
    wanted = (named,) if isinstance(named, str) else tuple(named)
    return (*wanted, "relative_velocity") if pictures["difference"] else wanted


def check_drawable(pictures: dict[str, Path | None], swept: dict[str, Any]) -> None:
    dimensions = sum(1 for value in swept.values() if np.ndim(value))
    if any(pictures.values()) and dimensions > 2:
        raise ValueError(f"--plot: got {dimensions} swept parameters, must be one or two to be drawn")
