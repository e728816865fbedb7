"""``hl.sweep``: solve columns over a grid or list of parameters."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, closing, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..column.scenario import Column
from ..support import machine, validation
from ..support.progress import reporter
from .chunks import Chunks
from .engines import ENGINES, Engine
from .memory import Memory, check_size
from .plan import make_plan
from .variables import VARIABLES

if TYPE_CHECKING:
    import xarray as xr

    from .store import Store

__all__ = ["ENGINES", "VARIABLES", "sweep"]


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
    """Solve a column at every point of a grid, or list, of parameters.

    Parameters
    ----------
    column : Column
        Balls on a floor, with the values of all parameters that are not swept.
    model : {"newton", "adiabatic", "independent"}
        ``"adiabatic"`` is for two balls under the linear law.
    engine : {"cpu", "cuda", "dask"}
        ``"cuda"`` computes on a GPU (extra ``hardlimit[cuda]``; two balls, linear law, models newton and
        adiabatic), ``"dask"`` on a cluster (extra ``hardlimit[cluster]``). All give the same bits.
    threads : int, optional
        Default: the number of processors; for ``"dask"`` one per task. The result does not depend on it.
    store : path, optional
        Zarr store that is filled chunk by chunk. The same call resumes an unfinished store, and recomputes damaged
        chunks with a warning. The results need not fit in memory: the Dataset reads them from disk.
    progress : bool or callable(done, total), optional
        True shows a bar. A function is called with the number of finished points and their total.
    variables : sequence of str, optional
        Variables to compute. Default for two balls: all but ``t_floor_end``, ``rebound_height`` and
        ``final_velocity``; for other columns: ``n_contacts``, ``rebound_height``, ``final_velocity``, ``t_end`` and
        ``outcome``.
    scheduler : str, distributed.Client or cluster object, optional
        Scheduler for ``"dask"``, as an address or a client. Default: a cluster on this machine.
    tolerance : float, optional
        Local error of a step, in units of the impact, where points are integrated (model newton, except two balls under
        the linear law). Two balls under the viscoelastic law: 1e-13 to 1e-6, default 2.3e-10; the velocities of most
        points have smaller errors. All others: 1e-15 to 1e-2, default 1e-14 as for ``hl.newton``.
    **swept : array
        ``gap``, ``radius``, ``density``, ``mass`` and ``velocity`` of all balls, or of one, numbered from the bottom:
        ``radius_1``, ``mass_2``, ``gap_2``, …; ``height`` and ``gravity``; for two balls ``radius_ratio``; and the
        parameters of the law (``restitution``, ``stiffness``, …) of all contacts or of one: ``restitution_floor``,
        ``restitution_pair_1``, …. Each is a number or a one-dimensional array. Each array adds a dimension;
        DataArrays with the same dimension make a list of points.

    Returns
    -------
    xarray.Dataset
        One dimension for each swept name, in the order given, and ``ball`` for variables with a value per ball.
        ``outcome`` holds integer codes, 0 = ok: a point that cannot be computed is a value, not an exception.

    Raises
    ------
    ValueError
        For unknown names, values outside their range, more points than memory or a store can hold, a store of another
        sweep, and with ``"cuda"`` for unsupported sweeps or without driver or device.
    ImportError
        If the engine needs a package that is not installed.
    RuntimeError
        If the connection to the scheduler of ``"dask"`` is lost, or several workers die at the same chunk.
    OSError
        If the store cannot be read or written. It stays valid and keeps all finished chunks.

    Notes
    -----
    Points are solved as by :func:`newton`, :func:`adiabatic` or :func:`independent`; vector kernels solve two balls.
    Figs. 4 to 8 of the paper are such sweeps.

    Examples
    --------
    >>> grid = hl.sweep(
    ...     hl.Column.paper(),
    ...     restitution=[0.5, 0.7, 0.9],
    ...     gap=np.geomspace(1e-6, 1e-3, 4),
    ... )
    >>> grid.n_contacts.values
    array([[ 1,  2,  4,  1],
           [ 2,  3,  4,  1],
           [ 2, 12,  3,  1]], dtype=uint8)
    """
    plan = make_plan(column, model, variables, swept, tolerance)
    chosen = _engine(engine, scheduler)
    chosen.check(plan)
    workers = _threads(threads, chosen)
    started = time.perf_counter()
    chunks = Chunks.whole(plan) if store is None and chosen.whole else Chunks.of(plan)
    check_size(plan, chunks, in_store=store is not None)
    bar = reporter(progress, "sweep", "points")
    if store is None:
        opened: AbstractContextManager[Memory | Store] = nullcontext(Memory(plan, chunks))
    else:
        from .store import Store

        opened = Store(store, plan, chunks)
    with bar as tell, opened as results:
        missing = results.missing()
        done = plan.size - sum(chunks.span(chunk)[1] for chunk in missing)

        def report(more: int) -> None:
            tell(done + more, plan.size)

        report(0)
        if missing:
            with closing(chosen.compute(plan, chunks, missing, workers, report, scheduler)) as computed:
                for chunk, values in computed:
                    results.write(chunk, values)
                    done += chunks.span(chunk)[1]
                    report(0)
        ds = results.dataset()
    return ds.assign_attrs(engine=engine, wall_time_s=time.perf_counter() - started)


def _engine(name: Any, scheduler: Any) -> Engine:
    engine = ENGINES[validation.one_of("engine", name, list(ENGINES))]
    if scheduler is not None and not engine.scheduled:
        got = f"scheduler: got {validation.shown(scheduler)}"
        raise ValueError(f"{got}, must not be given unless engine is 'dask'")
    return engine


def _threads(threads: Any, engine: Engine) -> int:
    if threads is not None:
        return validation.whole("threads", threads, 1, 1024)
    return 1 if engine.many_tasks else machine.processors()
