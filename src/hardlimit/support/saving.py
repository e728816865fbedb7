"""Writes a file whole or not at all: a full disk leaves nothing half-written behind."""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr


@contextmanager
def whole(path: str | Path) -> Iterator[Path]:
    """A file with the same ending to write into, which takes the name ``path`` once the block is left.

    If the block fails, it is removed and whatever bore the name before stays. A device or a pipe is written as
    it is.

    Raises
    ------
    OSError
        If it cannot be written; names ``path``.
    """
    target = Path(os.path.realpath(path))
    special = target.exists() and not target.is_file()
    temporary = target if special else target.with_name(f".{secrets.token_hex(4)}-unfinished{target.suffix}")
    try:
        yield temporary
        if not special:
            if target.exists():
                shutil.copymode(target, temporary)
            temporary.replace(target)
    except OSError as error:
        raise OSError(f"{path}: cannot be written: {error.strerror or error}") from error
    finally:
        if not special:
            temporary.unlink(missing_ok=True)


def write(path: str | Path, content: bytes | bytearray | memoryview) -> Path:
    """Write a file.

    Raises
    ------
    OSError
        If it cannot be written; names it.
    """
    with memoryview(content) as view, whole(path) as temporary, open(temporary, "wb", buffering=0) as file:
        done = 0
        while done < len(view):
            done += file.write(view[done:])
    return Path(path)


def _write_and_release(path: str | Path, content: Any) -> Path:
    """The same; after an error as well nothing looks into what xarray has made in memory, which could not be freed."""
    try:
        return write(path, content)
    finally:
        if isinstance(content, memoryview):
            content.release()


def dataset(
    data: xr.Dataset, path: str | Path, encoding: Mapping[Any, Mapping[str, Any]] | None = None
) -> Path:
    """Write a Dataset as NetCDF; ``encoding`` is that of ``xarray.Dataset.to_netcdf``.

    The file is made in memory: HDF5 crashes Python when a disk fills up under an open file.

    Raises
    ------
    OSError
        If it cannot be written; names it.
    """
    content = data.to_netcdf(None, engine="h5netcdf", encoding=encoding)
    return _write_and_release(path, content)


def groups(data: Mapping[str, xr.Dataset], path: str | Path) -> Path:
    """Write Datasets as groups of one NetCDF file, by name such as ``newton/contacts``; ``/`` is the file itself.

    Raises
    ------
    OSError
        If it cannot be written; names it.
    """
    import xarray as xr

    content = xr.DataTree.from_dict(dict(data)).to_netcdf(None, engine="h5netcdf")
    return _write_and_release(path, content)
