"""Going on with a run of a box of grains from its checkpoint."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from ..support.progress import Report
from . import (
    checkpoint,
)
from . import (
    contact_run as contact_course,
)
from . import (
    hard_spheres as event_driven,
)
from . import (
    newton as molecular_dynamics,
)
from .contact_result import ContactResult
from .result import ParticleResult
from .system import ParticleSystem


def resume(
    path: str | Path,
    *,
    until: float | None = None,
    max_collisions: int | None = None,
    observe: Callable[[float, ParticleSystem], Mapping[str, Any]] | None = None,
    progress: bool | Report | None = None,
) -> ParticleResult | ContactResult:
    """Go on with a run from its checkpoint, with the bits of a run that was not stopped; checkpoints go on as well.

    Parameters
    ----------
    path : path
        The checkpoint.
    until : float [s], optional
    max_collisions : int, optional
        Of hard spheres; counted from the start of the run. Without both, the end that the run was given. The samples
        keep their spacing.
    observe : callable(t, system), optional
        Of hard spheres; called with time [s] and state at each sample.
    progress : bool or callable(done, total), optional
        As for the function that began the run.

    Returns
    -------
    ParticleResult or ContactResult
        As of the function that began the run.

    Raises
    ------
    ValueError
        If the file is no checkpoint, is damaged or of another version, or the new end lies before its state.
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
    header, _ = checkpoint.read(path)
    if header.get("kind") == contact_course.KIND:
        return molecular_dynamics.resumed(path, until, max_collisions, progress)
    return event_driven.resume(
        path, until=until, max_collisions=max_collisions, observe=observe, progress=progress
    )
