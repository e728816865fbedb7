"""Maps of many columns at once: ``hl.sweep``."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import validation
from ..column import Column
from .plan import VARIABLES, make_plan

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["ENGINES", "VARIABLES", "sweep"]

ENGINES = ("cpu",)


def sweep(
    column: Column,
    model: str = "newton",
    engine: str = "cpu",
    threads: int | None = None,
    store: str | Path | None = None,
    progress: Callable[[int, int], object] | None = None,
    variables: Sequence[str] | None = None,
    **swept: Any,
) -> xr.Dataset:
    """Compute a map over any physical parameters of a two-ball column.

    Parameters
    ----------
    column : Column
        Two balls on a floor; gives every parameter that is not swept.
    model : {"newton", "adiabatic", "independent"}
    engine : {"cpu"}
    threads : int, optional
        Defaults to the number of processors. The result does not depend on it.
    progress : callable(done, total), optional
    variables : sequence of str, optional
        Which variables to compute and keep; all but ``t_floor_end`` by default.
    **swept : array
        ``gap``, ``radius_ratio``, ``radius_1``, ``radius_2``, ``density``, ``mass_1``, …, ``height``, ``velocity``,
        ``gravity`` and the parameters of the law (``restitution``, ``stiffness``, …), each a number or a
        one-dimensional array. Every array opens a dimension; two DataArrays that share one make a list of points.

    Returns
    -------
    xarray.Dataset
        One dimension for each swept name, in the order given. ``outcome`` holds integer codes, 0 = ok.

    Raises
    ------
    ValueError
        For unknown names and values outside their range.
    """
    plan = make_plan(column, model, variables, swept)
    if engine not in ENGINES:
        raise ValueError(f"engine: got {engine!r}, must be one of {', '.join(ENGINES)}")
    workers = _threads(threads)
    started = time.perf_counter()
    report = None if progress is None else (lambda done: progress(done, plan.size))
    flat = plan.compute(0, plan.size, workers, report)
    if progress is not None:
        progress(plan.size, plan.size)
    return plan.dataset(flat, {"engine": engine, "wall_time_s": time.perf_counter() - started})


def _threads(threads: int | None) -> int:
    if threads is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if isinstance(threads, bool) or not isinstance(threads, int | np.integer):
        raise ValueError(f"threads: got {threads!r}, must be a whole number in [1, 1024]")
    return int(validation.number("threads", int(threads), 1, 1024, lowest_allowed=True, highest_allowed=True))
