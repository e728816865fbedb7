"""Write files completely or not at all, by one process at a time; an OSError names the file."""

from __future__ import annotations

import errno
import io
import json
import os
import secrets
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import validation
from .formatting import listed

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

if TYPE_CHECKING:
    import xarray as xr

#: Attribute at the root of a saved result: its kind and the version of the format. Files of another one are refused.
RESULT: Final = "hardlimit_result"
FORMAT: Final = 1
#: Group from which :func:`hardlimit.load` makes the result, and the array in it with what JSON can hold.
STATE, HEADER = "state", "header"
#: Time to wait for a lock [s]; the process that holds it may just have been killed.
PATIENCE: Final = 2.0


@contextmanager
def locked(path: Path, patience: float = PATIENCE) -> Iterator[None]:
    """Keep other processes from writing the store ``path``; meanwhile ``.NAME.lock`` is beside it.

    Raises a ValueError if another process holds the lock for longer than ``patience`` [s].
    """
    from filelock import FileLock, Timeout

    file = path.with_name(f".{path.name}.lock")
    lock = FileLock(file, timeout=patience, poll_interval=0.02)
    try:
        lock.acquire()
    except Timeout:
        raise ValueError(f"store: {path} is being written by another process") from None
    except OSError as error:
        raise store_failure(path, error) from None
    try:
        yield
    finally:
        with suppress(OSError):  # who waits for the lock notices that its file is gone
            file.unlink()
        lock.release()


def store_failure(path: Path, error: OSError, what: str = "write") -> OSError:
    """The same error with a message for the user, such as for a full disk or a read-only folder."""
    told = OSError(f"store: cannot {what} {path}: {error.strerror or error}; finished chunks are kept")
    told.errno = error.errno
    return told


def checked(name: str, path: Any, endings: Sequence[str] = ()) -> Path:
    """The path of a file to write; call it before computing.

    Raises a ValueError unless the system accepts the name, its folder exists, the file can be written, and it ends in
    one of ``endings`` if given. A device is written in place and may have any name.
    """
    target = validation.path(name, path)
    got = f"{name}: got {validation.shown(os.fspath(path))}"
    try:
        with suppress(FileNotFoundError, NotADirectoryError):
            target.stat()
        in_folder = target.parent.is_dir()
    except OSError as error:  # too long
        raise ValueError(f"{got}, must be the name of a file: {error.strerror}") from None
    if not target.name:
        raise ValueError(f"{got}, must be the name of a file")
    if not in_folder:
        raise ValueError(f"{got}, must be in an existing folder")
    special = target.exists() and not target.is_file()
    if endings and not special and target.suffix.lower() not in endings:
        raise ValueError(f"{got}, must end in {listed(endings, 'or')}")
    if endings and (target.is_dir() or not os.access(target if special else target.parent, os.W_OK)):
        raise ValueError(f"{got}, must be writable")
    return target


@contextmanager
def whole(path: str | Path) -> Iterator[Path]:
    """A temporary file, with the same suffix, that replaces ``path`` at the end of the block.

    If the block fails, the temporary file is removed and ``path`` stays as it was. If the process is killed, the next
    one that writes ``path`` takes over its temporary file. Devices and pipes are written directly.
    """
    target = Path(os.path.realpath(validation.path("path", path)))
    with naming(path):
        if target.exists() and not target.is_file():
            yield target
            return
        temporary, lock = _temporary(target)
        try:
            yield temporary
            if target.exists():
                shutil.copymode(target, temporary)
            temporary.replace(target)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise
        finally:
            os.close(lock)


def _temporary(target: Path) -> tuple[Path, int]:
    """A temporary file beside ``target``, and a descriptor that is open, and locked if possible, while it is written.

    Its name follows from that of ``target``, so that the next process finds and reuses the file of a killed one, which
    is not locked. If another process holds the lock, the name is random.
    """
    temporary = target.with_name(f".{target.stem[:40]}-unfinished{target.suffix[-16:]}")
    with suppress(OSError):
        descriptor = os.open(temporary, os.O_WRONLY | os.O_CREAT, 0o666)
        try:
            _lock(descriptor)
            if os.path.samestat(os.fstat(descriptor), temporary.stat()):
                os.truncate(descriptor, 0)
                return temporary, descriptor
            raise FileNotFoundError  # another process has just finished it
        except BaseException:
            os.close(descriptor)
            raise
    temporary = target.with_name(f".{secrets.token_hex(4)}-unfinished{target.suffix}")
    return temporary, os.open(temporary, os.O_WRONLY | os.O_CREAT, 0o666)


def _lock(descriptor: int) -> None:
    """Lock a file against other processes until it is closed.

    Raises BlockingIOError if another one has locked it, and OSError where files cannot be locked.
    """
    if fcntl is None:
        raise OSError(errno.ENOTSUP, os.strerror(errno.ENOTSUP))
    fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)


@contextmanager
def naming(path: str | Path) -> Iterator[None]:
    """An OSError in the block names the file."""
    try:
        yield
    except OSError as error:
        raise OSError(f"{path}: cannot be written: {error.strerror or error}") from error


@contextmanager
def exclusive(path: Path) -> Iterator[None]:
    """Keep other processes from writing a file in place. Raises a ValueError if one does."""
    if path.exists() and not path.is_file():
        yield
        return
    with open(path, "ab") as file:
        try:
            _lock(file.fileno())
        except BlockingIOError:
            raise ValueError(f"{path} is being written by another process") from None
        except OSError:  # a file system without locks
            pass
        yield


def write_all(file: BinaryIO, content: bytes | bytearray | memoryview) -> None:
    """Write all bytes to a file without a buffer, which may take fewer at a time."""
    with memoryview(content) as view:
        done = 0
        while done < len(view):
            done += file.write(view[done:])


def write(path: str | Path, content: bytes | bytearray | memoryview) -> Path:
    """Write a file."""
    with whole(path) as temporary, open(temporary, "wb", buffering=0) as file:
        write_all(file, content)
    return Path(path)


def _write_and_release(path: str | Path, content: Any) -> Path:
    """``write``, then release the buffer, also after an error; xarray could not free it otherwise."""
    try:
        return write(path, content)
    finally:
        if isinstance(content, memoryview):
            content.release()


def dataset(
    data: xr.Dataset, path: str | Path, encoding: Mapping[Any, Mapping[str, Any]] | None = None
) -> Path:
    """Write a Dataset as NetCDF; ``encoding`` is that of ``xarray.Dataset.to_netcdf``.

    The file is built in memory: HDF5 crashes Python if the disk fills up while a file is open.
    """
    content = data.to_netcdf(None, engine="h5netcdf", encoding=encoding)
    return _write_and_release(path, content)


def groups(data: Mapping[str, xr.Dataset], path: str | Path) -> Path:
    """Write Datasets as groups of one NetCDF file, by name such as ``newton/contacts``; ``/`` is the root.

    A DataTree would leave out the coordinates that a group shares with the root, and with them the ``time`` of a log.
    """
    content = io.BytesIO()
    for name in sorted(data):  # the root first
        data[name].to_netcdf(content, "a" if content.tell() else "w", group=name, engine="h5netcdf")
        content.seek(0, io.SEEK_END)
    return write(path, content.getbuffer())


# --- results ------------------------------------------------------------------------------------------------


def result(
    path: Any,
    kind: str,
    datasets: Mapping[str, xr.Dataset],
    header: Mapping[str, Any],
    arrays: Mapping[str, NDArray[Any]],
) -> Path:
    """Write a result, which :func:`read` reads: its Datasets as in :func:`groups`, and its state.

    The state is ``header``, which JSON can hold, and ``arrays``.
    """
    import xarray as xr

    target = checked("path", path, [".nc"])
    text = json.dumps(header, default=lambda value: value.item()).encode()
    parts = {**arrays, HEADER: np.frombuffer(text, np.uint8)}
    state = xr.Dataset({name: (_dims(np.shape(array)), np.asarray(array)) for name, array in parts.items()})
    return groups({**datasets, "/": mark(datasets["/"], kind), STATE: state}, target)


def _dims(shape: tuple[int, ...]) -> list[str]:
    """Names of dimensions: those of the same length are shared, since each takes time to write and to read."""
    return [f"size_{n}" + f"_{shape[:i].count(n)}" * (n in shape[:i]) for i, n in enumerate(shape)]


def mark(root: xr.Dataset, kind: str) -> xr.Dataset:
    """The root of a file with the kind of the result."""
    return root.assign_attrs({RESULT: f"{kind} {FORMAT}"})


class Saved(NamedTuple):
    """A NetCDF file of this package."""

    path: Path
    kind: str  #: of a result; empty if the file is a Dataset

    def root(self, group: str | None = None) -> xr.Dataset:
        """The Dataset at the root or in a group, in memory."""
        import xarray as xr

        with xr.open_dataset(self.path, engine="h5netcdf", group=group) as file:
            return file.load()

    def tree(self) -> xr.DataTree:
        """All groups, in memory."""
        import xarray as xr

        with xr.open_datatree(self.path, engine="h5netcdf") as file:
            return file.load()

    def state(self) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
        """The header and the arrays of the state."""
        arrays = {str(name): variable.values for name, variable in self.root(STATE).data_vars.items()}
        header: dict[str, Any] = json.loads(arrays.pop(HEADER).tobytes())
        return header, arrays


def read(path: Path) -> Saved:
    """A file of this package.

    Raises a ValueError in one line for any other file, and a FileNotFoundError if there is none.
    """
    import h5netcdf
    import xarray as xr

    try:
        os.stat(path)
        with h5netcdf.File(path, decode_vlen_strings=True) as file:
            attributes = dict(file.attrs)
        kind, _, version = attributes.pop(RESULT, f" {FORMAT}").partition(" ")
        if not kind:
            with xr.open_dataset(path, engine="h5netcdf") as root:
                empty = not root.data_vars
    except OSError as error:
        if error.strerror and error.errno:
            raise validation.unreadable(path, error) from None
        raise ValueError(f"{path}: not a NetCDF file, or damaged") from None
    except Exception:  # h5py and xarray raise many kinds of exceptions for a damaged file
        raise ValueError(f"{path}: not a NetCDF file of hardlimit, or damaged") from None
    if version != str(FORMAT):
        raise ValueError(
            f"{path}: got format {version}, must be {FORMAT}; xarray can read its root and its groups"
        )
    if not kind and empty:  # of a run of a version before this format, for example
        raise ValueError(f"{path}: has no data at its root; xarray.open_groups reads its groups")
    if not kind and not any("hardlimit" in name for name in (*attributes, *map(str, attributes.values()))):
        raise ValueError(f"{path}: must be a file of hardlimit: its attributes do not name it")
    return Saved(path, kind)
