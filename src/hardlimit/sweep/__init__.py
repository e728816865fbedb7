"""Maps of many columns at once: ``hl.sweep``."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Generator, Sequence
from contextlib import closing, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import validation
from ..column.scenario import Column
from ..progress import reporter
from .chunks import Tiles
from .engines import cuda
from .engines import dask as cluster
from .plan import VARIABLES, Chunk, Plan, make_plan
from .store import Store

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["ENGINES", "VARIABLES", "sweep"]

ENGINES = ("cpu", "cuda", "dask")

Report = Callable[[int], object]


def sweep(
    column: Column,
    model: str = "newton",
    engine: str = "cpu",
    threads: int | None = None,
    store: str | Path | None = None,
    progress: bool | Callable[[int, int], object] | None = None,
    variables: Sequence[str] | None = None,
    scheduler: Any = None,
    tolerance: float | None = None,
    **swept: Any,
) -> xr.Dataset:
    """Compute a map over any physical parameters of a two-ball column.

    Parameters
    ----------
    column : Column
        Two balls on a floor; gives every parameter that is not swept.
    model : {"newton", "adiabatic", "independent"}
    engine : {"cpu", "cuda", "dask"}
        ``"cuda"`` computes on a GPU (extra ``hardlimit[cuda]``; linear law, models newton and adiabatic),
        ``"dask"`` on a cluster (extra ``hardlimit[cluster]``). The bits are the same.
    threads : int, optional
        Defaults to the number of processors, with ``"dask"`` to one for each task. The result does not depend
        on it.
    store : path, optional
        A Zarr store to fill, tile by tile. The same call goes on with one that was left unfinished. The
        results need not fit in memory: the Dataset reads them from disk.
    progress : bool or callable(done, total), optional
        True shows a bar on stderr.
    variables : sequence of str, optional
        Which variables to compute and keep; all but ``t_floor_end`` by default.
    scheduler : str, distributed.Client or cluster object, optional
        Where ``"dask"`` computes: the address of a scheduler, or a connection; by default a cluster on this
        machine.
    tolerance : float, optional
        Local error of a step under the viscoelastic law (model newton), in units of the impact, 1e-13 to 1e-6;
        2.3e-10 by default. The velocities of most points come out with a smaller error than that (see the page on
        maps). Every other law and model is exact and takes none.
    **swept : array
        ``gap``, ``radius_ratio``, ``radius_1``, ``radius_2``, ``density``, ``mass_1``, …, ``height``,
        ``velocity``, ``gravity`` and the parameters of the law (``restitution``, ``stiffness``, …), each
        a number or a one-dimensional array. Every array opens a dimension; two DataArrays that share one make
        a list of points.

    Returns
    -------
    xarray.Dataset
        One dimension for each swept name, in the order given. ``outcome`` holds integer codes, 0 = ok.

    Raises
    ------
    ValueError
        For unknown names, values outside their range, a store that holds something else, and with ``"cuda"``
        if there is no driver or device.
    ImportError
        If the engine needs a package that is not installed.
    OSError
        If the store cannot be written. It stays valid and keeps what is finished.
    """
    plan = make_plan(column, model, variables, swept, tolerance)
    _check(engine, scheduler)
    workers = _threads(1 if threads is None and engine == "dask" else threads)
    started = time.perf_counter()
    tiles = Tiles.whole(plan) if store is None and engine != "dask" else Tiles.of(plan)
    bar = reporter(progress, "sweep", "points")
    opened = nullcontext(Memory(plan, tiles)) if store is None else Store(store, plan, tiles)
    with bar as tell, opened as results:
        missing = results.missing()
        done = plan.size - sum(tiles.span(tile)[1] for tile in missing)

        def report(more: int) -> None:
            tell(done + more, plan.size)

        report(0)
        if engine == "dask" and missing:
            computed = cluster.compute(plan, tiles, missing, workers, scheduler)
        elif engine == "cuda" and missing:
            computed = cuda.compute(plan, tiles, missing, workers, report)
        else:
            computed = _on_cpu(plan, tiles, missing, workers, report)
        with closing(computed):
            for tile, chunk in computed:
                results.write(tile, chunk)
                done += tiles.span(tile)[1]
                report(0)
        ds = results.dataset()
    return ds.assign_attrs(engine=engine, wall_time_s=time.perf_counter() - started)


def _check(engine: str, scheduler: Any) -> None:
    if engine not in ENGINES:
        raise ValueError(f"engine: got {engine!r}, must be one of {', '.join(ENGINES)}")
    if scheduler is not None and engine != "dask":
        raise ValueError(f"scheduler: got {scheduler!r}, must not be given unless engine is 'dask'")


def _on_cpu(
    plan: Plan, tiles: Tiles, wanted: Sequence[int], threads: int, report: Report
) -> Generator[tuple[int, Chunk], None, None]:
    for tile in wanted:
        yield tile, plan.compute(*tiles.span(tile), threads, report)


class Memory:
    """The results of a sweep in arrays; what Store is on disk."""

    def __init__(self, plan: Plan, tiles: Tiles) -> None:
        self.plan, self.tiles = plan, tiles
        self.flat: Chunk = {}

    def missing(self) -> list[int]:
        return list(range(len(self.tiles)))

    def write(self, tile: int, chunk: Chunk) -> None:
        first, count = self.tiles.span(tile)
        if count == self.plan.size:
            self.flat = chunk
            return
        for name, values in chunk.items():
            out = self.flat.get(name)
            if out is None:
                out = self.flat[name] = np.empty(self.plan.size, values.dtype)
            elif values.dtype.itemsize > out.dtype.itemsize:  # the first counts above 255
                out = self.flat[name] = out.astype(values.dtype)
            out[first : first + count] = values

    def dataset(self) -> xr.Dataset:
        return self.plan.dataset(self.flat, {})


def _threads(threads: int | None) -> int:
    if threads is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if isinstance(threads, bool) or not isinstance(threads, int | np.integer):
        raise ValueError(f"threads: got {threads!r}, must be a whole number in [1, 1024]")
    return int(validation.number("threads", int(threads), 1, 1024, lowest_allowed=True, highest_allowed=True))
