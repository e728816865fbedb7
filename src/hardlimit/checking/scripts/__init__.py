"""Read scripts and logs of LAMMPS, LIGGGHTS and YADE. Nothing in them is executed."""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Final

from ...support import validation
from .commands import Commands, given, text_of
from .description import (
    Bath,
    ContactSettings,
    Description,
    Grains,
    Note,
    Quote,
    Setting,
    Settings,
    Stage,
    date,
)
from .statements import quoted

__all__ = [
    "CODES",
    "Bath",
    "ContactSettings",
    "Description",
    "Grains",
    "Note",
    "Quote",
    "Setting",
    "Settings",
    "Stage",
    "read",
    "read_text",
]


CODES: Final = ("lammps", "liggghts", "yade")
#: An example of a version of each code.
VERSIONS: Final = {"lammps": "22Jul2025", "liggghts": "3.8.0", "yade": "2023.02a"}
#: Longest text that may be a path.
LONGEST_PATH: Final = 1000
#: Most include files that tell the code.
MAX_INCLUDED: Final = 20
#: What tells the codes apart, outside comments.
SIGNS: Final = {
    "yade": re.compile(
        r"^[^#\n]*(?:\bO\.(?:engines|materials|bodies)\b|\bOmega\(\)|\bIp2_\w+\s*\(|\b(?:from|import)\s+yade\b|NewtonIntegrator\s*\()",
        re.MULTILINE,
    ),
    "liggghts": re.compile(
        r"^[^#\n]*(?:\bpair_style\s+gran(?:/omp)?\s|\bproperty/global\b|\bparticletemplate/|\bmesh/surface\b)",
        re.MULTILINE,
    ),
    "lammps": re.compile(
        r"^[^#\n]*\b(?:pair_style|pair_coeff|wall/gran)\b|^[ \t]*(?:atom_style|create_box|read_data)[ \t]",
        re.MULTILINE,
    ),
}


def read(
    source: str | Path,
    *,
    code: str | None = None,
    version: str | None = None,
    variables: Mapping[str, str] = {},
    types_seen: int = 0,
) -> Description:
    """Read a script or a log: the path of a file, or the text itself. The other arguments are those of `read_text`."""
    text, file, folder = _opened(source)
    if code is not None:
        validation.one_of("code", code, CODES)
    return read_text(
        text, file, folder, code=code, version=version, variables=variables, types_seen=types_seen
    )


def read_text(
    text: str,
    file: str = "",
    folder: Path | None = None,
    *,
    code: str | None = None,
    version: str | None = None,
    variables: Mapping[str, str] = {},
    types_seen: int = 0,
    part: bool = False,
) -> Description:
    """Read the text of a script or a log, or a part of one.

    Parameters
    ----------
    text : str
    file : str
        Name of its file.
    folder : Path, optional
        Folder of include files.
    code : str, optional
        "lammps", "liggghts" or "yade"; found in the text by default.
    version : str, optional
        Version of the code, which comes before that of a log.
    variables : mapping of str to str
        Values of variables, as given on the code's command line.
    types_seen : int
        Largest type of grains in a dump, for scripts that read their grains from files.
    part : bool
        Whether it is a part of a script: its end is a run, and settings for balls and walls alike need no wall.

    Raises
    ------
    ValueError
        If the script has no granular contacts or cannot be resolved, or if the version is none of the code.
    """
    from . import logs
    from .lammps import Lammps
    from .liggghts import Liggghts

    log = logs.header(text)
    name = code or (log[0] if log else "") or _code_of(text, folder)
    stated = None if version is None else _version(version, name)
    if name == "yade":
        from . import yade

        read = yade.read(text, file, variables, part, folder)
        return replace(read, version=stated, warnings=(*read.warnings, *_unused(variables, text)))
    kind = Liggghts if name == "liggghts" else Lammps
    known = given(variables)
    state = kind(known, folder, stated or (log[1] if log else "") or None, name, types_seen, part)
    if log:
        read = state.read(logs.commands(text, file, known, kind))
        late = [quoted(file, 1, "units: the log begins after them")] * (
            not log[0] and not read.stages[0].units_given
        )
        return replace(read, unknown=(*read.unknown, *late))
    read = state.read(iter(Commands(text, file, folder, known)))
    return replace(read, warnings=(*read.warnings, *_unused(variables, text, known.used)))


def _unused(variables: Iterable[str], text: str, used: Collection[str] = ()) -> Iterator[Note]:
    """Warnings of variables that were given, but are neither in the script nor ``used`` by what it includes."""
    for name in variables:
        if name not in used and not re.search(rf"(?<!\w){re.escape(name)}(?!\w)", text):
            yield Note(f"the script has no variable {name}, which was given")


def _opened(source: str | Path) -> tuple[str, str, Path | None]:
    """Text, name and folder of a source."""
    if not isinstance(source, str | Path):
        raise ValueError(f"script: got {validation.shown(source)}, must be a path or a text")
    if isinstance(source, str) and ("\n" in source or len(source) > LONGEST_PATH):
        return source.removeprefix("\ufeff"), "", None
    path = validation.path("script", source)
    text = text_of(path)
    if text is not None:
        return text.removeprefix("\ufeff"), path.name, path.parent
    if isinstance(source, str) and len(source.split()) > 1:
        return source, "", None
    if not os.path.exists(path):
        raise validation.unreadable(path, FileNotFoundError())
    raise ValueError(f"{path}: cannot be read: must be a text file of at most 200 MB")


def _version(text: object, code: str) -> str:
    """A version of a code in the form in which its log states it: a date of LAMMPS may lack its blanks."""
    spaced = re.sub(r"(\d{1,2})[ _-]?([A-Z][a-z]{2})[ _-]?(\d{4})", r"\1 \2 \3", str(text))
    known = date(spaced)
    if known is None or (len(known) == 3 and known[0] > 1000) != (code == "lammps"):
        raise ValueError(f"version: got {validation.shown(text)}, must be one such as {VERSIONS[code]}")
    return re.sub(r"[ _-]*[Uu]pdate[ _-]?(\d+)", r" - Update \1", spaced)


def _code_of(text: str, folder: Path | None) -> str:
    """The code that a script or one of its include files is written for."""
    names = re.findall(r"^[ \t]*include[ \t]+(\S+)", text, re.MULTILINE) if folder else []
    included = [text_of(folder / name) or "" for name in names[:MAX_INCLUDED] if folder]
    for code, sign in SIGNS.items():
        if any(sign.search(content) for content in (text, *included)):
            return code
    raise ValueError(f"script: has no granular contacts of {', '.join(CODES)}")
