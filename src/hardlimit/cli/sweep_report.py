"""What ``hardlimit sweep`` draws, prints and saves."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..support import saving
from ..sweep.variables import BALL
from .printing import console, digits, plain, quantity, show, table

if TYPE_CHECKING:
    import xarray as xr


def save(ds: xr.Dataset, path: Path) -> None:
    """Write the map as compressed NetCDF.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    packed = {str(name): {"zlib": True, "complevel": 1} for name in ds.data_vars}
    saving.dataset(ds, path, packed)


def blocks(ds: xr.Dataset, points: int = 2_000_000) -> Iterator[xr.Dataset]:
    """The map in parts that fit in memory: a store may be larger."""
    dim = max(ds.sizes, key=lambda name: ds.sizes[name])
    step = max(1, points * ds.sizes[dim] // math.prod(ds.sizes.values()))
    for first in range(0, ds.sizes[dim], step):
        yield ds.isel({dim: slice(first, first + step)})


def summarise(ds: xr.Dataset, out: Path | None) -> dict[str, Any]:
    """Size, time and how the points ended."""
    sizes = {str(name): int(size) for name, size in ds.sizes.items() if name != BALL}
    summary: dict[str, Any] = {
        "points": math.prod(sizes.values()),
        "sizes": sizes,
        "seconds": float(ds.attrs.get("wall_time_s", math.nan)),
        "out": None if out is None else str(out),
        "column": ds.attrs.get("column"),
        "model": ds.attrs.get("model"),
        "engine": ds.attrs.get("engine"),
    }
    outcomes: dict[str, int] = {}
    ranges: dict[str, list[float]] = {}
    for block in blocks(ds):
        for name in block.data_vars:
            values = block[name].values
            if name == "outcome":
                codes, counts = np.unique(values, return_counts=True)
                words = block[name].attrs["flag_meanings"].split()
                for code, n in zip(codes, counts, strict=True):
                    outcomes[words[code]] = outcomes.get(words[code], 0) + int(n)
            elif np.isfinite(values).any():
                low, high = ranges.get(str(name), [math.inf, -math.inf])
                ranges[str(name)] = [min(low, float(np.nanmin(values))), max(high, float(np.nanmax(values)))]
    summary |= {"outcomes": outcomes, "ranges": ranges}
    result: dict[str, Any] = plain(summary)
    return result


def print_summary(ds: xr.Dataset, summary: dict[str, Any]) -> None:
    out = console()
    sizes = " × ".join(f"{size} {name}" for name, size in summary["sizes"].items())
    seconds = summary["seconds"] or math.nan
    rate = quantity(summary["points"] / seconds, "points/s", 3)
    rows = []
    for name, (low, high) in summary["ranges"].items():
        unit = ds[name].attrs.get("units", "1")
        label = name + ("" if unit == "1" else f" [{unit}]")
        rows.append([label, digits(low), digits(high)])
    below = ", ".join(f"{name} {count}" for name, count in summary.get("outcomes", {}).items())
    title = f"{summary['model']}, {sizes}: {summary['points']} points in {seconds:.3g} s, {rate}"
    show(out, title, table(["", "smallest", "largest"], rows), f"outcomes: {below}" if below else "")
    if summary["out"]:
        out.print(f"written to {summary['out']}", markup=False)
