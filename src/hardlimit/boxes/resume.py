"""``resume``: continue a run of a box of grains from its checkpoint."""

from __future__ import annotations

from pathlib import Path

from ..support import validation
from ..support.progress import Report, reporter
from .hard_spheres import NAME, later_end
from .observe import Observe
from .result import ContactResult, ParticleResult
from .run import checked_until, load


def resume(
    path: str | Path,
    *,
    until: float | None = None,
    max_collisions: int | None = None,
    observe: Observe | None = None,
    progress: bool | Report | None = None,
) -> ParticleResult | ContactResult:
    """Continue a run from its checkpoint, with the same bits as an uninterrupted run.

    The run continues to write checkpoints to this file.

    Parameters
    ----------
    path : path
        The checkpoint.
    until : float [s], optional
        New end of the run. Without ``until`` and ``max_collisions``, the end is that of the checkpoint. The interval
        between samples is unchanged.
    max_collisions : int, optional
        New limit on the number of collisions, counted from the start of the run. For hard spheres only.
    observe : callable, optional
        Required if the run was started with one: a checkpoint has the values of the function, not the function.
    progress : bool or callable(done, total), optional
        As for the function that started the run.

    Returns
    -------
    ParticleResult or ContactResult
        As from the function that started the run.

    Raises
    ------
    ValueError
        If the file is not a checkpoint, is damaged or was written by another version, the new end is before the time of
        the checkpoint, or ``observe`` is missing or returns other names than before.
    OSError
        If a checkpoint cannot be written; names it.

    Examples
    --------
    >>> gas = hl.ParticleSystem.random(
    ...     100, packing_fraction=0.1, radius=1e-3, density=2500.0, rms_speed=0.1
    ... )
    >>> first = hl.event_driven(
    ...     gas, restitution=0.9, max_collisions=500, checkpoint="run.checkpoint"
    ... )
    >>> hl.resume("run.checkpoint", max_collisions=1000).n_collisions
    1000
    """
    run = load(path)
    record = run.engine.record
    run.set_observe(observe)
    if record.name != NAME and max_collisions is not None:
        shown = validation.shown(max_collisions)
        raise ValueError(f"max_collisions: got {shown}, must be left out: this run ends at a time")
    if record.name != NAME and until is not None:
        run.set_end(checked_until(run, until))
    elif until is not None or max_collisions is not None:
        run.set_end(*later_end(run, until, max_collisions))
    with reporter(progress, record.task, record.counts) as report:
        return run.run(report)
