"""What a restart file holds, from the script in the same folder that writes it; the file itself is not read."""

from __future__ import annotations

import copy
import os
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Final

from . import free_fall, streams
from .commands import SILENT, Commands, Variables, text_of
from .filling import Filling
from .population import Population

if TYPE_CHECKING:
    from .groups import Group
    from .state import State

#: Most files of a folder in which the script is looked for, their largest size in bytes, the most commands of one that
#: are read, and the most scripts of which each reads what the one before writes.
MOST_FILES: Final = 1000
LARGEST: Final = 200_000
MOST_COMMANDS: Final = 10_000
DEEPEST: Final = 3


@dataclass
class Restart:
    """The grains and the box when a restart file is written."""

    units: str
    dimension: int
    types: int
    groups: dict[str, Group]
    edges: dict[str, float]
    population: Population
    filling: Filling


@dataclass
class Wanted:
    """A restart file that is looked for, and what was in it when it was last written."""

    path: str
    depth: int = 1
    contents: Restart | None = None
    understood: bool = True


def path_of(folder: Path | None, name: str) -> str:
    """The whole path of a file that a script names."""
    return os.path.normpath(os.path.join(folder or "", name))


def written(state: State, name: str) -> None:
    """Keep the grains and the box if this is the file that is looked for, and all of them are understood."""
    wanted = state.wanted
    if wanted is None or path_of(state.folder, name) != wanted.path:
        return
    tied = any(note.what.startswith(("clumps", "bonds")) for note in state.invalidates)
    wanted.understood = not (state.unknown or tied)
    filling = copy.deepcopy(state.filling)
    if not state.stages or any(streams.only(state, stage) is None for stage in state.stages):
        filling.insertions, filling.launches = [], [free_fall.UNKNOWN]
        filling.heat, filling.drifts, filling.velocities_known = [], {}, False
    wanted.contents = Restart(
        state.units,
        state.dimension,
        state.types,
        dict(state.groups),
        dict(state.edges),
        copy.deepcopy(state.population),
        filling,
    )


def files_in(folder: Path) -> list[Path]:
    """The small files of a folder; none if it cannot be read."""
    try:
        with os.scandir(folder) as entries:
            small = [entry.path for entry in entries if entry.is_file() and entry.stat().st_size <= LARGEST]
    except OSError:
        return []
    return [Path(path) for path in sorted(small)[:MOST_FILES]]


def find(state: State, name: str) -> tuple[str, Restart] | None:
    """The name of the only script in the folder that writes this file, and what the file holds; None without one."""
    depth = 1 if state.wanted is None else state.wanted.depth + 1
    if state.folder is None or "*" in name or depth > DEEPEST:
        return None
    writers = []
    for file in files_in(state.folder):
        text = text_of(file) or ""
        writes = [line for line in text.splitlines() if line.split()[:1] == ["write_restart"]]
        if not any("$" in line or os.path.basename(name) in line for line in writes):
            continue
        wanted = Wanted(path_of(state.folder, name), depth)
        other = type(state)(Variables(), state.folder, state.version, state.code, wanted=wanted)
        script = Commands(text, file.name, state.folder, Variables(), SILENT - {"write_restart"})
        commands = islice(script, MOST_COMMANDS)
        try:
            other.read(commands)
        except ValueError:  # not a script, or one of which not all is known
            continue
        if wanted.contents is not None:
            writers.append((file.name, wanted))
    if len(writers) != 1 or not writers[0][1].understood or writers[0][1].contents is None:
        return None
    return writers[0][0], writers[0][1].contents
