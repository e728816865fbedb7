"""``resume``: continue a run of a box of grains from its checkpoint."""

from __future__ import annotations

from pathlib import Path

from ..support import validation
from ..support.progress import Report, reporter
from .hard_spheres import NAME, checked_end
from .observe import Observe
from .result import ContactResult, ParticleResult
from .run import load


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
        between samples is unchanged: bits are those of a run to the new end with samples at the same times.
    max_collisions : int, optional
        New limit on the number of collisions, counted from the start of the run. For hard spheres only.
    observe : callable, optional
        Required if the run was started with one: a checkpoint has the values of the function, not the function.
        ``observe`` and ``progress`` are described in :func:`event_driven`.

    Raises
    ------
    ValueError
        If the file is not a checkpoint, is damaged or was written by another version, the new end is before the time of
        the checkpoint, or ``observe`` is missing or returns other names than before.
    FileNotFoundError
        If there is no such file.
    OSError
        As for :func:`event_driven`.
    """
    run = load(path)
    record = run.engine.record
    run.set_observe(observe)
    if record.name != NAME and max_collisions is not None:
        shown = validation.shown(max_collisions)
        raise ValueError(f"max_collisions: got {shown}, must be left out for a run under Newton's equations")
    if until is not None or max_collisions is not None:
        run.set_end(*checked_end(until, max_collisions, run))
    with reporter(progress, record.task, record.counts) as report:
        return run.run(report)
