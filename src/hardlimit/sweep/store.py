"""A computation on disk: a Zarr store that fills chunk by chunk and can be resumed after any interruption.

The store lacks nothing but chunks from the moment its folder appears (it is prepared under another name), and a file
is whole from the moment it appears (likewise). Every file that is not text ends with a checksum (Zarr's ``crc32c``).
A chunk is there when all its files are and agree with their checksums: what was lost or damaged is computed anew. So
whatever ends a run, what is on disk is valid; and as nothing in it tells when or where it was computed, its bytes
depend on the call alone. What is not the store's own is not touched.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import warnings
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from ..support import locking, validation
from .chunks import Chunks
from .computation import Computation, Coordinate, Values, Variable, labels

if TYPE_CHECKING:
    import xarray as xr
    import zarr

#: Values of a coordinate in one file.
LABELS_OF_FILE: Final = 1 << 20

#: What Zarr calls a file while it writes it.
HALF_WRITTEN: Final = re.compile(r".+\.[0-9a-f]{32}\.partial")

GROUP: Final = "zarr.json"

#: What Zarr raises for a chunk whose bytes are not those that were written.
DAMAGED: Final = (ValueError, TypeError, RuntimeError, KeyError, IndexError, EOFError)


class Store:
    """The chunks of one sweep in the folder ``path``."""

    def __init__(self, path: str | Path, computation: Computation, chunks: Chunks) -> None:
        self.path = _local(path)
        _require_zarr(self.path)
        self.computation, self.chunks = computation, chunks
        self._missing: list[int] = []
        self._arrays: dict[str, zarr.Array[Any]] = {}
        self._lock = ExitStack()

    def __enter__(self) -> Store:
        with ExitStack() as lock:  # let go of if anything below fails
            while _is_new(self.path):
                if self._create(lock):
                    self._missing = list(range(len(self.chunks)))
                    break
            else:
                self._resume(lock)
            self._lock = lock.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self._lock.close()

    def missing(self) -> list[int]:
        """Chunks that are not there yet, as found when the store was opened."""
        return self._missing

    def write(self, chunk: int, values: Values) -> None:
        """Keep a chunk."""
        box = self.chunks.box(chunk)
        with _one_line(self.path):
            for name in sorted(values, key="outcome".__eq__):  # the outcome last: it vouches for the rest
                self._arrays[name][box] = values[name].reshape(_shape(box, self.computation.results[name]))

    def dataset(self) -> xr.Dataset:
        """The store as a Dataset that reads from disk what is used."""
        import xarray as xr

        names = list(self.computation.results)
        ds: xr.Dataset = xr.open_zarr(self.path, chunks=None, consolidated=True)[names]
        for name, variable in self.computation.results.items():
            ds[name].attrs.update(variable.attributes())
        return ds

    # --- a new one ------------------------------------------------------------------------------------------

    def _create(self, lock: ExitStack) -> bool:
        """Make the folder; false if another process was faster."""
        unfinished = self.path.with_name(f".{self.path.name}.unfinished")
        with _one_line(self.path):
            unfinished.mkdir(parents=True, exist_ok=True)
        with ExitStack() as attempt:
            if not attempt.enter_context(locking.locked(unfinished, self.path)):
                return False
            with _one_line(self.path):
                try:
                    if not _is_new(self.path):
                        shutil.rmtree(unfinished)
                        return False
                    _empty(unfinished)
                    _write_labels(unfinished, self.computation, self.chunks)
                    unfinished.rename(self.path)
                except BaseException:
                    shutil.rmtree(unfinished, ignore_errors=True)
                    raise
            lock.push(attempt.pop_all())  # the lock stays with the folder, whatever its name
        self._arrays = _arrays(self.path, self.computation)
        return True

    # --- one that was begun ---------------------------------------------------------------------------------

    def _resume(self, lock: ExitStack) -> None:
        """Go on: find what is missing, mend what is damaged. A complete store is only read."""
        expected = _metadata(self.computation, self.chunks)
        _insist_on_the_same(self.path, self.computation, expected)
        metadata = [name for name, content in expected.items() if _json(self.path / name) != content]
        read_only = not metadata and all(map(self._is_there, range(len(self.chunks))))
        if not read_only:
            self._begin_writing(lock)
        for name in metadata:
            with _one_line(self.path):
                _replace(self.path / name, json.dumps(expected[name], indent=2).encode())
        coordinates = [c for c in self.computation.coordinates if not _agrees(self.path / c.name, c)]
        damaged = self._find_missing()
        if read_only and (coordinates or damaged):
            self._begin_writing(lock)
        for coordinate in coordinates:
            with _one_line(self.path):
                _write_coordinate(self.path / coordinate.name, coordinate)
        if metadata or coordinates or damaged:
            found = [f"{name} was damaged and is written anew" for name in metadata]
            found += [f"coordinate {c.name} was damaged and is written anew" for c in coordinates]
            found += [f"{damaged} of {len(self.chunks)} chunks are damaged and computed anew"] * (damaged > 0)
            warnings.warn(f"store: {self.path}: {'; '.join(found)}", stacklevel=4)

    def _begin_writing(self, lock: ExitStack) -> None:
        lock.enter_context(locking.locked(self.path, self.path))
        names = [*self.computation.results, *(c.name for c in self.computation.coordinates)]
        with _one_line(self.path):
            _tidy(self.path, names)

    def _find_missing(self) -> int:
        """Read every chunk once; those that are not there or not whole are missing. How many are damaged."""
        self._arrays = _arrays(self.path, self.computation)
        damaged = 0
        for chunk in range(len(self.chunks)):
            there = self._is_there(chunk)
            whole = there and all(_reads(array, self.chunks.box(chunk)) for array in self._arrays.values())
            if not whole:
                self._missing.append(chunk)
                damaged += there
        return damaged

    def _is_there(self, chunk: int) -> bool:
        """Whether a chunk has all its files."""
        at = self.chunks.position(chunk)
        own = {name: (0,) * len(variable.shape) for name, variable in self.computation.results.items()}
        return all(_is_there(self.path.joinpath(name, "c", *map(str, (*at, *own[name])))) for name in own)


# --- what is in a store -------------------------------------------------------------------------------------


def _require_zarr(path: Path) -> None:
    try:
        import zarr  # noqa: F401
    except ImportError:
        raise ValueError(
            f"store: got {str(path)!r}, must have Zarr: pip install 'hardlimit[store]'"
        ) from None


def _attributes(computation: Computation, chunks: Chunks) -> dict[str, Any]:
    """Attributes of the whole store; ``fingerprint`` covers all that a result depends on."""
    digest = hashlib.sha256(repr((computation.fingerprint(), chunks)).encode())
    attributes = {**computation.attributes(), "Conventions": "CF-1.11", "fingerprint": digest.hexdigest()}
    others = [c.name for c in computation.coordinates if c.name != c.dim]
    return {**attributes, "coordinates": " ".join(others)} if others else attributes


def _make_arrays(store: Any, computation: Computation, chunks: Chunks) -> None:
    """All of a store but values: its group and its arrays, without consolidated metadata."""
    import zarr

    group = zarr.create_group(store, attributes=_attributes(computation, chunks))
    for name, (dims, values, attributes) in labels(computation).items():
        shape = np.shape(values)
        dims = (dims,) if isinstance(dims, str) else dims
        files = tuple(min(n, LABELS_OF_FILE) for n in shape)
        _make_array(group, name, dims, shape, files, str(np.asarray(values).dtype), 0, attributes)
    for name, variable in computation.results.items():
        attributes = variable.attributes()
        if variable.flags:
            attributes["flag_values"] = [*attributes["flag_values"].tolist(), int(variable.not_computed)]
            attributes["flag_meanings"] += " not_computed"
        dims, shape = (*computation.dims, *variable.dims), (*computation.shape, *variable.shape)
        box, dtype = (*chunks.box_shape, *variable.shape), variable.stored or variable.dtype
        _make_array(group, name, dims, shape, box, dtype, variable.not_computed, attributes)


def _make_array(
    group: zarr.Group,
    name: str,
    dims: tuple[str, ...],
    shape: tuple[int, ...],
    files: tuple[int, ...],
    dtype: str,
    fill: float,
    attributes: dict[str, Any],
) -> None:
    """A new array. Counts and codes shrink a hundredfold; the last bits of a velocity are noise."""
    from zarr.codecs import Crc32cCodec, ZstdCodec

    packed = [] if dtype in ("float64", "int64") else [ZstdCodec(level=1)]
    group.create_array(
        name,
        shape=shape,
        chunks=files,
        dtype=dtype,
        fill_value=fill,
        compressors=[*packed, Crc32cCodec()],
        dimension_names=dims,
        attributes=attributes,
    )


def _write_labels(folder: Path, computation: Computation, chunks: Chunks) -> None:
    """All of a store but its chunks."""
    _make_arrays(folder, computation, chunks)
    for coordinate in computation.coordinates:
        _write_coordinate(folder / coordinate.name, coordinate)
    _consolidate(folder)


def _metadata(computation: Computation, chunks: Chunks) -> dict[str, Any]:
    """The metadata files of a store by name, parsed."""
    from zarr.storage import MemoryStore

    files: dict[str, Any] = {}
    store = MemoryStore(files)
    _make_arrays(store, computation, chunks)
    _consolidate(store)
    return {name: json.loads(content.to_bytes()) for name, content in files.items()}


def _consolidate(store: Any) -> None:
    import zarr

    with warnings.catch_warnings():  # not yet part of Zarr's format 3; xarray warns of a store without
        warnings.simplefilter("ignore")
        zarr.consolidate_metadata(store)


def _arrays(path: Path, computation: Computation) -> dict[str, zarr.Array[Any]]:
    """The arrays of the variables; a chunk is written even if it holds nothing but fill values."""
    import zarr

    with zarr.config.set({"array.write_empty_chunks": True}):
        return {name: zarr.open_array(path / name, mode="r+") for name in computation.results}


def _write_coordinate(folder: Path, coordinate: Coordinate) -> None:
    import zarr

    zarr.open_array(folder, mode="r+")[...] = _values(coordinate)


def _values(coordinate: Coordinate) -> Any:
    return coordinate.values[0] if coordinate.dim is None else coordinate.values


def _shape(box: tuple[slice, ...], variable: Variable) -> tuple[int, ...]:
    return (*(s.stop - s.start for s in box), *variable.shape)


# --- whether it is what it must be --------------------------------------------------------------------------


def _local(path: str | Path) -> Path:
    if not isinstance(path, str | os.PathLike) or "://" in str(path) or not Path(path).name:
        raise ValueError(f"store: got {validation.shown(path)}, must be the path of a local folder")
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


def _insist_on_the_same(path: Path, computation: Computation, expected: dict[str, Any]) -> None:
    """Refuse a store of anything but this computation."""
    attributes = _as_dict(_as_dict(_json(path / GROUP)).get("attributes"))
    if "fingerprint" not in attributes:
        if _holds_labels_only(path, computation, expected):
            return
        need = f"must be a store of hl.sweep with its {GROUP}, empty or missing"
        raise ValueError(f"store: {path} holds something else, {need}")
    wanted = expected[GROUP]["attributes"]
    if wanted["fingerprint"] == attributes["fingerprint"]:
        return
    made = "other values of what is swept"
    variables = _variables_of(_as_dict(_json(path / GROUP)))
    if variables != set(computation.results):
        made = f"variables {', '.join(sorted(variables))}"
    for name in computation.attributes():  # the last one, the version, says most
        if attributes.get(name) != wanted.get(name):
            made = f"{name.replace('hardlimit_', '')} {attributes.get(name)}, not {wanted.get(name)}"
    raise ValueError(f"store: {path} was made with {made}; repeat that call or take another path")


def _variables_of(group: dict[str, Any]) -> set[str]:
    """Names of the arrays of a store that are not coordinates."""
    arrays = _as_dict(_as_dict(group.get("consolidated_metadata")).get("metadata"))
    others = str(_as_dict(group.get("attributes")).get("coordinates", "")).split()
    return {name for name, array in arrays.items() if _as_dict(array).get("dimension_names") != [name]} - set(
        others
    )


def _holds_labels_only(path: Path, computation: Computation, expected: dict[str, Any]) -> bool:
    """Whether this is a store of ours without its group's file and without a chunk, as a power cut can leave it."""
    found = {file.relative_to(path).as_posix(): file for file in path.rglob("*") if file.is_file()}
    if GROUP in found and found.pop(GROUP).stat().st_size > 0:
        return False
    labelled = tuple(f"{c.name}/c" for c in computation.coordinates)
    ours = [name for name in found if name in expected and _json(found[name]) == expected[name]]
    return bool(ours) and all(name in expected or name.startswith(labelled) for name in found)


def _as_dict(json: Any) -> dict[str, Any]:
    return json if isinstance(json, dict) else {}


def _json(file: Path) -> Any:
    """The content of a metadata file; None if it cannot be read."""
    try:
        return json.loads(file.read_bytes())
    except (FileNotFoundError, NotADirectoryError, IsADirectoryError, ValueError, RecursionError):
        return None
    except OSError as error:
        raise _failure(file, error, "read") from None


def _is_there(file: Path) -> bool:
    """Whether a chunk was written; an empty file is what a power cut can leave of one."""
    with suppress(FileNotFoundError, NotADirectoryError):
        return file.stat().st_size > 0
    return False


def _reads(array: zarr.Array[Any], box: tuple[slice, ...]) -> bool:
    """Whether a chunk agrees with its checksum."""
    try:
        array[box]
    except DAMAGED:
        return False
    except OSError as error:
        raise _failure(Path(str(array.store_path)), error, "read") from None
    return True


def _agrees(folder: Path, coordinate: Coordinate) -> bool:
    """Whether the files of a coordinate are all there and hold its values."""
    import zarr

    array = zarr.open_array(folder, mode="r")
    wanted = np.asarray(_values(coordinate))
    if wanted.ndim == 0:
        return _is_there(folder / "c") and _equal(array, (), wanted)
    for i, first in enumerate(range(0, len(wanted), LABELS_OF_FILE)):
        box = (slice(first, min(first + LABELS_OF_FILE, len(wanted))),)
        if not (_is_there(folder / "c" / str(i)) and _equal(array, box, wanted[box])):
            return False
    return True


def _equal(array: zarr.Array[Any], box: tuple[slice, ...], wanted: Any) -> bool:
    try:
        return bool(np.array_equal(np.asarray(array[box]), wanted))
    except DAMAGED:
        return False


# --- files --------------------------------------------------------------------------------------------------


def _replace(file: Path, content: bytes) -> None:
    """Write a file such that it is whole or not there."""
    file.parent.mkdir(parents=True, exist_ok=True)
    half = file.with_suffix(f".{os.urandom(16).hex()}.partial")
    half.write_bytes(content)
    half.replace(file)


def _empty(folder: Path) -> None:
    """Remove what a run left that was killed before the store got its name."""
    for left in list(folder.iterdir()):
        shutil.rmtree(left) if left.is_dir() else left.unlink()


def _tidy(path: Path, names: list[str]) -> None:
    """Remove what a killed run left half written in the folders of these arrays."""
    inside = [file for name in names for file in (path / name).rglob("*.partial")]
    for file in (*path.glob("zarr.*.partial"), *inside):
        if HALF_WRITTEN.fullmatch(file.name):
            file.unlink()


@contextmanager
def _one_line(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise _failure(path, error) from None


def _failure(path: Path, error: OSError, what: str = "write") -> OSError:
    """The same error with what it means here: disk full, read-only folder."""
    told = OSError(f"store: cannot {what} {path}: {error.strerror or error}; what is finished is kept")
    told.errno = error.errno
    return told
