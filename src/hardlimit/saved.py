"""``hl.load``: read a result that was saved, whichever function or command has written it."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Final

from .boxes.result import ContactResult, ParticleResult
from .fidelity_study.result import Fidelity
from .support import saving, validation

if TYPE_CHECKING:
    import xarray as xr

Result = ParticleResult | ContactResult | Fidelity
#: How each kind of result is made again from its saved parts.
KINDS: Final[Mapping[str, Callable[[saving.Saved], Result]]] = {
    kind.__name__: kind._loaded for kind in (ParticleResult, ContactResult, Fidelity)
}


def load(path: str | Path) -> Result | xr.Dataset | xr.DataTree:
    """Read a saved result: of ``save``, of ``hardlimit gas`` and ``gas compare``, ``sweep``, ``drop`` or ``paper``.

    Parameters
    ----------
    path : path
        NetCDF file (.nc) or Zarr store.

    Returns
    -------
    ParticleResult, ContactResult, Fidelity, xarray.Dataset or xarray.DataTree
        The result of a box of grains or of :func:`fidelity` as it was saved, to the last bit. A sweep or a figure of
        the paper is a Dataset; a Zarr store is read from disk when values are used. A drop is a tree: a table of the
        models, and for each model ``trajectory`` and ``contacts``.

    Raises
    ------
    ValueError
        If it is no such file, is damaged or was written by another version.
    FileNotFoundError
        If there is no such file.
    ImportError
        If a Zarr store is read without the extra ``hardlimit[store]``.

    Notes
    -----
    A file of a run has the series at its root, so that other programs find it, and all else in groups (:doc:`grains`).

    Examples
    --------
    >>> pair = hl.ParticleSystem(
    ...     [[0.02, 0.05], [0.04, 0.05]],
    ...     [[0.1, 0.0], [-0.1, 0.0]],
    ...     radius=0.005,
    ...     density=2500.0,
    ...     box=0.1,
    ... )
    >>> run = hl.event_driven(pair, restitution=0.5, until=0.2)
    >>> hl.load(run.save("run.nc"))
    <ParticleResult of 2 particles (constant, restitution 0.5): 1 collisions in 0.2 s, ok>
    """
    target = validation.path("path", path)
    if target.is_dir():
        return _store(target)
    content = saving.read(target)
    if content.kind in KINDS:
        try:
            return KINDS[content.kind](content)
        except (KeyError, TypeError, ValueError, IndexError) as error:
            raise ValueError(f"{path}: damaged: {validation.shown(str(error))}") from None
    return content.tree() if content.kind else content.root()


def _store(path: Path) -> xr.Dataset:
    """The Dataset of the store of a sweep."""
    try:
        attributes = json.loads((path / "zarr.json").read_bytes())["attributes"]
    except (OSError, ValueError, KeyError):
        attributes = {}
    if "fingerprint" not in attributes:
        raise ValueError(f"{path}: must be a NetCDF file or the Zarr store of a sweep")
    import xarray as xr

    dataset: xr.Dataset = xr.open_zarr(path, chunks=None, consolidated=True)
    return dataset
