"""Run LAMMPS as a child process: progress, dumps through pipes, termination, and error messages in one line."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Final

#: Time that LAMMPS has to end after a signal [s].
TIMEOUT: Final = 2.0


class Pipe:
    """A named pipe: LAMMPS writes to it, a thread reads it."""

    def __init__(self, path: Path, read: Callable[[Iterable[str]], None]) -> None:
        self._path, self._read = path, read
        self._error: Exception | None = None
        os.mkfifo(path)
        self._thread = threading.Thread(target=self._follow, daemon=True)
        self._thread.start()

    def _follow(self) -> None:
        with open(self._path, encoding="utf-8", errors="replace") as lines:
            try:
                self._read(lines)
            except Exception as error:  # raised again by close()
                self._error = error
                for _ in lines:  # reads on, so that LAMMPS does not block
                    pass

    def close(self) -> None:
        """Wait until all output is read. Raises the exception of the reader, if there was one."""
        with contextlib.suppress(OSError):  # LAMMPS may never have opened it
            os.close(os.open(self._path, os.O_WRONLY | os.O_NONBLOCK))
        self._thread.join()
        if self._error is not None:
            raise self._error


def run(
    command: list[str],
    folder: Path,
    environment: Mapping[str, str],
    readers: Mapping[str, Callable[[Iterable[str]], None]],
    on_line: Callable[[str], object],
) -> None:
    """Run LAMMPS in a folder. ``readers`` get the dumps of these names, ``on_line`` every line of its output.

    Raises RuntimeError with the error message if LAMMPS fails, and KeyboardInterrupt at Ctrl-C after LAMMPS has ended.
    """
    pipes = [Pipe(folder / name, read) for name, read in readers.items()]
    failed = True
    try:
        with _started(command, folder, environment) as child:
            lines: deque[str] = deque(maxlen=31)  # the last lines have the error message, if there is one
            for line in child.stdout or ():
                lines.append(line)
                on_line(line)
            code = child.wait()
        if code != 0:
            raise RuntimeError(f"engine: LAMMPS failed: {_reason(lines, code)}")
        failed = False
    finally:
        ignored = [Exception] if failed else []  # after a failure the dump is incomplete
        for pipe in pipes:
            with contextlib.suppress(*ignored):
                pipe.close()


def _reason(lines: Iterable[str], code: int) -> str:
    """The error line of LAMMPS without its source location."""
    errors = [line for line in lines if "ERROR" in line] or [line for line in lines if line.strip()]
    if not errors:
        return f"exit code {code} without a message"
    return re.sub(r"\s*\(src/\S+\)|^ERROR( on proc \d+)?:\s*", "", errors[0].strip())


@contextlib.contextmanager
def _started(
    command: list[str], folder: Path, environment: Mapping[str, str]
) -> Iterator[subprocess.Popen[str]]:
    """Start the process in its own process group, so that Ctrl-C reaches only Python, which then ends all ranks."""
    child = subprocess.Popen(
        command,
        cwd=folder,
        env=dict(environment),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        start_new_session=True,
    )
    try:
        with child:
            try:
                yield child
            except BaseException:
                _end(child)
                raise
    finally:
        if child.poll() is None:
            _end(child)


def _end(child: subprocess.Popen[str]) -> None:
    """End the process and its ranks, to which mpiexec forwards SIGTERM."""
    for number in (signal.SIGTERM, signal.SIGKILL):
        with contextlib.suppress(ProcessLookupError):
            os.killpg(child.pid, number)
        with contextlib.suppress(subprocess.TimeoutExpired):
            child.wait(TIMEOUT)
            return
