"""A map on disk: a Zarr store that fills tile by tile and can be gone on with after anything.

The store lacks nothing but tiles from the moment its folder appears (it is prepared under another name), and
a chunk file is whole from the moment it appears (likewise). A tile is there when all its files are. So
whatever ends a run, what is on disk is valid; and as nothing in it tells when or where it was computed, its
bytes depend on the call alone.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import sys
import warnings
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from .chunks import Tiles
from .plan import VARIABLES, Chunk, Plan, variable_attributes

if TYPE_CHECKING:
    import xarray as xr
    import zarr

if sys.platform != "win32":
    import fcntl

#: What stands where nothing has been computed yet.
NOT_COMPUTED: Final[dict[str, Any]] = {"n_contacts": 2**32 - 1, "outcome": 255}

#: The type of a count is settled before the first point is computed; a byte may turn out too small.
STORED_TYPES: Final = {"n_contacts": "uint32"}


class Store:
    """The tiles of one sweep in the folder ``path``."""

    def __init__(self, path: str | Path, plan: Plan, tiles: Tiles) -> None:
        self.path = _local(path)
        self.plan, self.tiles = plan, tiles
        self._arrays: dict[str, zarr.Array[Any]] = {}
        self._lock = ExitStack()

    def __enter__(self) -> Store:
        with ExitStack() as lock:  # let go of if anything below fails
            if _is_new(self.path):
                self._create(lock)
            else:
                self._resume(lock)
            self._lock = lock.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self._lock.close()

    def _create(self, lock: ExitStack) -> None:
        unfinished = self.path.with_name(f".{self.path.name}.unfinished")
        with _one_line(self.path):
            unfinished.mkdir(parents=True, exist_ok=True)
        lock.enter_context(_locked(unfinished, self.path))  # stays with the folder when it is renamed
        with _one_line(self.path):
            try:
                _write_metadata(unfinished, self.plan, self.tiles)
                unfinished.rename(self.path)
            except BaseException:
                shutil.rmtree(unfinished, ignore_errors=True)
                raise
        self._arrays = _arrays(self.path, self.plan)

    def _resume(self, lock: ExitStack) -> None:
        _insist_on_the_same(self.path, self.plan, self.tiles)
        if self.missing():  # a complete store is only read
            lock.enter_context(_locked(self.path, self.path))
            with _one_line(self.path):
                _tidy(self.path)
            self._arrays = _arrays(self.path, self.plan)

    def missing(self) -> list[int]:
        """Tiles that are not there yet."""
        chunks = [self.path / name / "c" for name in self.plan.variables]
        positions = map(self.tiles.position, range(len(self.tiles)))
        return [tile for tile, at in enumerate(positions) if not all(_there(c, at) for c in chunks)]

    def write(self, tile: int, chunk: Chunk) -> None:
        """Keep a tile."""
        box, shape = self.tiles.box(tile), self.tiles.box_shape(tile)
        with _one_line(self.path):
            for name in sorted(
                chunk, key="outcome".__eq__
            ):  # the outcome last, so that it vouches for the rest
                self._arrays[name][box] = chunk[name].reshape(shape)

    def dataset(self) -> xr.Dataset:
        """The store as a Dataset that reads from disk what is used."""
        import xarray as xr

        ds: xr.Dataset = xr.open_zarr(self.path, chunks=None, consolidated=True)[list(self.plan.variables)]
        for name in self.plan.variables:
            ds[name].attrs.update(variable_attributes(name))
        return ds


def _local(path: str | Path) -> Path:
    if not isinstance(path, str | os.PathLike) or "://" in str(path) or not Path(path).name:
        raise ValueError(f"store: got {path!r}, must be the path of a local folder")
    return Path(path).absolute()


def _is_new(path: Path) -> bool:
    """Whether there is nothing at ``path``, or an empty folder."""
    try:
        return next(path.iterdir(), None) is None
    except FileNotFoundError:
        return True
    except NotADirectoryError:
        raise ValueError(f"store: {path} is a file, must be a folder or missing") from None
    except OSError as error:
        raise _failure(path, error) from None


def _insist_on_the_same(path: Path, plan: Plan, tiles: Tiles) -> None:
    """Refuse a store of anything but this sweep."""
    import zarr

    try:
        group = zarr.open_group(path, mode="r")
        attributes = dict(group.attrs)
        names = {name for name in VARIABLES if name in group}
    except (OSError, ValueError, KeyError):
        attributes, names = {}, set()
    if "fingerprint" not in attributes:
        raise ValueError(f"store: {path} holds something else, must be a store of hl.sweep, empty or missing")
    wanted = _attributes(plan, tiles)
    if wanted["fingerprint"] == attributes["fingerprint"]:
        return
    made = "other values of what is swept"
    for name in ("hardlimit_version", "model", "column", "tolerance"):
        if attributes.get(name) != wanted.get(name):
            made = f"{name.replace('hardlimit_', '')} {attributes.get(name)}, not {wanted.get(name)}"
            break
    else:
        if names != set(plan.variables):
            made = f"variables {', '.join(sorted(names))}"
    raise ValueError(f"store: {path} was made with {made}; repeat that call or take another path")


def _attributes(plan: Plan, tiles: Tiles) -> dict[str, Any]:
    """Attributes of the whole store; ``fingerprint`` covers all that a result depends on."""
    digest = hashlib.sha256(repr((plan.attributes(), plan.law, plan.alternative, plan.density_1)).encode())
    names = [(name, dim) for name, dim, *_ in plan.coordinates]
    layout = (plan.density_2, plan.restitution_at, plan.strides, plan.dims, plan.variables, names, tiles)
    digest.update(repr(layout).encode())
    for values in (*plan.values, *(c[2] for c in plan.coordinates)):
        digest.update(values.size.to_bytes(8, "little"))
        digest.update(values.astype("<f8", copy=False).tobytes())
    labels = [name for name, dim in names if name != dim]
    attributes = {**plan.attributes(), "Conventions": "CF-1.11", "fingerprint": digest.hexdigest()}
    return {**attributes, "coordinates": " ".join(labels)} if labels else attributes


def _write_metadata(folder: Path, plan: Plan, tiles: Tiles) -> None:
    """All of a store but its tiles."""
    import zarr

    for left in folder.iterdir():  # by a run that was killed here
        shutil.rmtree(left) if left.is_dir() else left.unlink()
    group = zarr.create_group(folder, attributes=_attributes(plan, tiles))
    for name, (dims, values, attributes) in plan.labels().items():
        blocks = tuple(min(n, 1 << 20) for n in np.shape(values))
        array = _array(group, name, dims, np.shape(values), blocks, "float64", 0.0, attributes)
        array[...] = values
    for name in plan.variables:
        attributes = {**variable_attributes(name)}
        if name == "outcome":
            attributes["flag_values"] = [*attributes["flag_values"].tolist(), NOT_COMPUTED[name]]
            attributes["flag_meanings"] += " not_computed"
        dtype = STORED_TYPES.get(name, VARIABLES[name][0])
        fill = NOT_COMPUTED.get(name, np.nan)
        _array(group, name, plan.dims, plan.shape, tiles.block, dtype, fill, attributes)
    with warnings.catch_warnings():  # not yet part of Zarr's format 3; xarray warns of a store without
        warnings.simplefilter("ignore")
        zarr.consolidate_metadata(folder)


def _array(
    group: zarr.Group,
    name: str,
    dims: Any,
    shape: tuple[int, ...],
    blocks: tuple[int, ...],
    dtype: str,
    fill: float,
    attributes: Mapping[str, Any],
) -> zarr.Array[Any]:
    """A new array. Counts and codes shrink a hundredfold; the last bits of a velocity are noise."""
    from zarr.codecs import ZstdCodec

    return group.create_array(
        name,
        shape=shape,
        chunks=blocks,
        dtype=dtype,
        fill_value=fill,
        compressors=None if dtype == "float64" else ZstdCodec(level=1),
        dimension_names=(dims,) if isinstance(dims, str) else tuple(dims),
        attributes=dict(attributes),
    )


def _arrays(path: Path, plan: Plan) -> dict[str, zarr.Array[Any]]:
    """The variables, to be written to; a chunk is written even if it holds nothing but the fill value."""
    import zarr

    with zarr.config.set({"array.write_empty_chunks": True}):
        return {name: zarr.open_array(path / name, mode="r+") for name in plan.variables}


def _there(folder: Path, position: tuple[int, ...]) -> bool:
    """Whether a chunk was written; an empty file is what a power cut can leave of one."""
    try:
        return folder.joinpath(*map(str, position)).stat().st_size > 0
    except FileNotFoundError:
        return False


def _tidy(path: Path) -> None:
    """Remove what a killed run left half written."""
    for folder, _, files in os.walk(path):
        for file in files:
            half = Path(folder, file)
            if file.endswith(".partial") or half.stat().st_size == 0:
                half.unlink()


@contextmanager
def _locked(folder: Path, path: Path) -> Iterator[None]:
    """Keep other processes from writing; ends with this process, however it ends, and leaves no file."""
    if sys.platform == "win32":
        yield
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        with suppress(OSError):  # some network file systems have no locks: then nothing is kept from anything
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise ValueError(f"store: {path} is being written by another process") from None
        yield
    finally:
        os.close(handle)


@contextmanager
def _one_line(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise _failure(path, error) from None


def _failure(path: Path, error: OSError) -> OSError:
    """The same error with what it means here: disk full, read-only folder."""
    told = OSError(f"store: cannot write {path}: {error.strerror or error}; what is finished is kept")
    told.errno = error.errno
    return told
