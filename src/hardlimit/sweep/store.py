"""Results of a sweep in a Zarr store, which is filled chunk by chunk and can be resumed after any interruption.

The folder is created complete (by renaming), with all metadata and coordinates and without chunks. Every file is
complete when it appears under its name, and every chunk ends with a checksum (Zarr's ``crc32c``). A chunk counts as
computed if all its files exist and match their checksums; otherwise it is computed again. The bytes of a store depend
only on the arguments of the call, not on time, place or interruptions. Other files in the folder are left alone.
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

from ..support import saving, validation
from .chunks import Chunks
from .computation import Computation, Values, labels

if TYPE_CHECKING:
    import xarray as xr
    import zarr

#: Coordinate values per file.
LABELS_OF_FILE: Final = 1 << 20

#: Temporary name of a file that Zarr (or ``_replace``) is writing.
HALF_WRITTEN: Final = re.compile(r".+\.[0-9a-f]{32}\.partial")

GROUP: Final = "zarr.json"

#: Exceptions of Zarr for a chunk whose bytes have changed.
DAMAGED: Final = (ValueError, TypeError, RuntimeError, KeyError, IndexError, EOFError)


class Store:
    """The chunks of one sweep in the folder ``path``."""

    def __init__(self, path: str | Path, computation: Computation, chunks: Chunks) -> None:
        self.path = _local(path)
        _require_zarr(self.path)
        self.computation, self.chunks = computation, chunks
        self._missing = list(range(len(chunks)))
        self._arrays: dict[str, zarr.Array[Any]] = {}
        self._lock = ExitStack()
        self._writing = False

    def __enter__(self) -> Store:
        try:
            files = label_files(self.computation, self.chunks)
            if _is_new(self.path):
                self._begin_writing()
            if _is_new(self.path):  # checked again with the lock, in case another process has created it
                self._create(files)
                self._arrays = _open_arrays(self.path, self.computation)
            else:
                self._resume(files)
        except BaseException:
            self._lock.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._lock.close()

    def missing(self) -> list[int]:
        """Chunks that were missing when the store was opened."""
        return self._missing

    def write(self, chunk: int, values: Values) -> None:
        """Write a chunk."""
        box = self.chunks.box(chunk)
        with _one_line(self.path):
            # The outcome is written last, because it marks a point as computed.
            for name in sorted(values, key="outcome".__eq__):
                shape = *(s.stop - s.start for s in box), *self.computation.results[name].shape
                self._arrays[name][box] = values[name].reshape(shape)

    def dataset(self) -> xr.Dataset:
        """The store as a Dataset that reads from disk when values are used."""
        import xarray as xr

        names = list(self.computation.results)
        ds: xr.Dataset = xr.open_zarr(self.path, chunks=None, consolidated=True)[names]
        for name, variable in self.computation.results.items():
            ds[name].attrs.update(variable.attributes())
        return ds

    # --- opening --------------------------------------------------------------------------------------------

    def _begin_writing(self) -> None:
        """Lock the store, and remove files that a killed process left incomplete."""
        if self._writing:
            return
        with _one_line(self.path):
            self.path.parent.mkdir(parents=True, exist_ok=True)
        self._lock.enter_context(saving.locked(self.path))
        self._writing = True
        with _one_line(self.path):
            for file in self.path.rglob("*.partial"):
                if HALF_WRITTEN.fullmatch(file.name):
                    file.unlink()

    def _create(self, files: dict[str, bytes]) -> None:
        unfinished = self.path.with_name(f".{self.path.name}.unfinished")
        with _one_line(self.path):
            try:
                shutil.rmtree(unfinished, ignore_errors=True)
                for name, content in files.items():
                    _replace(unfinished / name, content)
                unfinished.rename(self.path)
            except BaseException:
                shutil.rmtree(unfinished, ignore_errors=True)
                raise

    def _resume(self, files: dict[str, bytes]) -> None:
        """Find the missing chunks; restore damaged metadata and coordinates. A complete store is only read."""
        _require_same(self.path, self.computation, json.loads(files[GROUP]))
        restored = [name for name, content in files.items() if _content(self.path / name) != content]
        if restored or not all(map(self._exists, range(len(self.chunks)))):
            self._begin_writing()
        for name in restored:
            with _one_line(self.path):
                _replace(self.path / name, files[name])
        self._arrays = _open_arrays(self.path, self.computation)
        intact = [self._is_intact(chunk) for chunk in range(len(self.chunks))]
        self._missing = [chunk for chunk, good in enumerate(intact) if not good]
        damaged = sum(map(self._exists, self._missing))
        if self._missing:
            self._begin_writing()
        if restored or damaged:
            said = [f"{name} was damaged and has been restored" for name in restored]
            if damaged:
                said.append(f"{damaged} of {len(self.chunks)} chunks are damaged and will be recomputed")
            warnings.warn(f"store: {self.path}: {'; '.join(said)}", stacklevel=4)

    def _exists(self, chunk: int) -> bool:
        """Whether a chunk has all its files. A power failure can leave empty ones, which do not count."""
        at = self.chunks.position(chunk)
        for name, variable in self.computation.results.items():
            file = self.path.joinpath(name, "c", *map(str, (*at, *(0 for _ in variable.shape))))
            with suppress(FileNotFoundError, NotADirectoryError):
                if file.stat().st_size > 0:
                    continue
            return False
        return True

    def _is_intact(self, chunk: int) -> bool:
        """Whether a chunk exists and matches its checksums."""
        if not self._exists(chunk):
            return False
        try:
            for array in self._arrays.values():
                array[self.chunks.box(chunk)]
        except DAMAGED:
            return False
        except OSError as error:
            raise saving.store_failure(self.path, error, "read") from None
        return True


# --- metadata and coordinates -------------------------------------------------------------------------------


def label_files(computation: Computation, chunks: Chunks) -> dict[str, bytes]:
    """All files of a store except its chunks (metadata and coordinates): contents by relative path."""
    from zarr.storage import MemoryStore

    files: dict[str, Any] = {}
    _make_arrays(MemoryStore(files), computation, chunks)
    return {name: content.to_bytes() for name, content in files.items()}


def _make_arrays(store: Any, computation: Computation, chunks: Chunks) -> None:
    import zarr

    group = zarr.create_group(store, attributes=_attributes(computation, chunks))
    for name, (dims, values, attributes) in labels(computation).items():
        values = np.asarray(values)
        dims = (dims,) if isinstance(dims, str) else dims
        files = tuple(min(n, LABELS_OF_FILE) for n in values.shape)
        array = group.create_array(
            name,
            shape=values.shape,
            chunks=files,
            dtype=str(values.dtype),
            fill_value=0,
            compressors=_compressors(str(values.dtype)),
            dimension_names=dims,
            attributes=attributes,
        )
        array[...] = values
    for name, variable in computation.results.items():
        attributes = variable.attributes()
        if variable.flags:
            attributes["flag_values"] = [*attributes["flag_values"].tolist(), int(variable.not_computed)]
            attributes["flag_meanings"] += " not_computed"
        dims, shape = (*computation.dims, *variable.dims), (*computation.shape, *variable.shape)
        box, dtype = (*chunks.box_shape, *variable.shape), variable.stored or variable.dtype
        group.create_array(
            name,
            shape=shape,
            chunks=box,
            dtype=dtype,
            fill_value=variable.not_computed,
            compressors=_compressors(dtype),
            dimension_names=dims,
            attributes=attributes,
        )
    with warnings.catch_warnings():  # xarray needs consolidated metadata, for which Zarr's format 3 warns
        warnings.simplefilter("ignore")
        zarr.consolidate_metadata(store)


def _compressors(dtype: str) -> list[Any]:
    """Counts and codes compress a hundredfold; the last bits of a velocity are noise."""
    from zarr.codecs import Crc32cCodec, ZstdCodec

    packed = [] if dtype in ("float64", "int64") else [ZstdCodec(level=1)]
    return [*packed, Crc32cCodec()]


def _attributes(computation: Computation, chunks: Chunks) -> dict[str, Any]:
    """Attributes of the store. ``fingerprint`` is a hash of everything that a result depends on."""
    digest = hashlib.sha256(repr((computation.fingerprint(), chunks)).encode())
    attributes = {
        **computation.attributes(),
        "Conventions": "CF-1.11",
        "variables": ", ".join(sorted(computation.results)),
        "fingerprint": digest.hexdigest(),
    }
    others = [c.name for c in computation.coordinates if c.name != c.dim]
    return {**attributes, "coordinates": " ".join(others)} if others else attributes


def _open_arrays(path: Path, computation: Computation) -> dict[str, zarr.Array[Any]]:
    """The arrays of the variables. A chunk is written even if all its values are fill values."""
    import zarr

    with zarr.config.set({"array.write_empty_chunks": True}):
        return {name: zarr.open_array(path / name, mode="r+") for name in computation.results}


# --- checks -------------------------------------------------------------------------------------------------


def _require_zarr(path: Path) -> None:
    try:
        import zarr  # noqa: F401
    except ImportError:
        raise ValueError(f"store: got {str(path)!r}, needs Zarr: pip install 'hardlimit[store]'") from None


def _local(path: str | Path) -> Path:
    target = validation.path("store", path)
    if "://" in str(path) or not target.name:
        raise ValueError(f"store: got {validation.shown(path)}, must be the path of a local folder")
    return target.absolute()


def _is_new(path: Path) -> bool:
    """Whether ``path`` does not exist or is an empty folder."""
    try:
        return next(path.iterdir(), None) is None
    except FileNotFoundError:
        return True
    except NotADirectoryError:
        raise ValueError(f"store: {path} is a file, must be a folder or missing") from None
    except OSError as error:
        raise saving.store_failure(path, error) from None


def _require_same(path: Path, computation: Computation, expected: dict[str, Any]) -> None:
    """Refuse a store of any other computation, and say what differs."""
    wanted, stored = expected["attributes"], _attributes_on_disk(path)
    if "fingerprint" not in stored:
        need = f"must be the store of a sweep with its {GROUP}, an empty folder, or missing"
        raise ValueError(f"store: {path} has other contents, {need}")
    if stored["fingerprint"] == wanted["fingerprint"]:
        return
    difference = "other values of the swept parameters"
    for name in ("variables", *computation.attributes()):  # the message names the last one that differs
        if stored.get(name) != wanted.get(name):
            difference = f"{name.replace('hardlimit_', '')} {stored.get(name)}, not {wanted.get(name)}"
    raise ValueError(f"store: {path} was made with {difference}; repeat that call or choose another path")


def _attributes_on_disk(path: Path) -> dict[str, Any]:
    """Attributes of the group; empty if they cannot be read."""
    try:
        attributes = json.loads(_content(path / GROUP) or b"")["attributes"]
    except (ValueError, TypeError, KeyError, RecursionError):
        return {}
    return attributes if isinstance(attributes, dict) else {}


# --- files --------------------------------------------------------------------------------------------------


def _content(file: Path) -> bytes | None:
    """None if there is no such file."""
    try:
        return file.read_bytes()
    except (FileNotFoundError, NotADirectoryError, IsADirectoryError):
        return None
    except OSError as error:
        raise saving.store_failure(file, error, "read") from None


def _replace(file: Path, content: bytes) -> None:
    """Write a file completely or not at all."""
    file.parent.mkdir(parents=True, exist_ok=True)
    half = file.with_name(f"{file.name}.{os.urandom(16).hex()}.partial")
    half.write_bytes(content)
    half.replace(file)


@contextmanager
def _one_line(path: Path) -> Iterator[None]:
    """Errors of the file system as one line that names the store."""
    try:
        yield
    except OSError as error:
        raise saving.store_failure(path, error) from None
