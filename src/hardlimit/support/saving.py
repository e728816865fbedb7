"""Write files completely or not at all, by one process at a time; an OSError names the file."""

from __future__ import annotations

import errno
import os
import secrets
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, Final

from .formatting import listed
from .validation import shown

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

if TYPE_CHECKING:
    import xarray as xr

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
    got = f"{name}: got {shown(str(path) if isinstance(path, os.PathLike) else path)}"
    if not isinstance(path, str | os.PathLike):
        raise ValueError(f"{got}, must be a path")
    target = Path(path)
    try:
        with suppress(FileNotFoundError, NotADirectoryError):
            target.stat()
        in_folder = target.parent.is_dir()
    except (OSError, ValueError) as error:  # too long, or with a null character
        reason = error.strerror if isinstance(error, OSError) else "embedded null character"
        raise ValueError(f"{got}, must be the name of a file: {reason}") from None
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
    target = Path(os.path.realpath(path))
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

    The one of a killed process has this name as well, and nobody locks it. A second process that writes ``target`` at
    the same time takes a random name.
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
    """Write Datasets as groups of one NetCDF file, by name such as ``newton/contacts``; ``/`` is the root."""
    import xarray as xr

    content = xr.DataTree.from_dict(dict(data)).to_netcdf(None, engine="h5netcdf")
    return _write_and_release(path, content)
