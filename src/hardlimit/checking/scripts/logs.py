"""Logs of LAMMPS and LIGGGHTS: the commands that they repeat, with variables replaced and loops unrolled.

A log repeats each command as it is read, and once more after each replacement of a variable.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final

from . import clumps
from .commands import UNRESOLVED, Variables
from .state import HARMLESS, State
from .statements import LONGEST_QUOTE, Statement, scan, split

HEADER: Final = re.compile(r"\s*(LAMMPS|LIGGGHTS) \((?:Version )?((?:[^()]|\([^()]*\))*)\)?", re.ASCII)
#: What the codes print during a run.
OUTPUT: Final = re.compile(
    r"^(?:Loop time of \S+ on \d+ procs|Per MPI rank memory allocation|Memory usage per processor"
    r"|Created orthogonal box =|Setting up (?:run|minimization)\b|\s+\d+ by \d+ by \d+ MPI processor grid)",
    re.MULTILINE,
)
#: Lines before the header, such as messages of MPI or a shell.
MAX_BEFORE: Final = 50
FLOW: Final = frozenset(("variable", "include", "if", "jump", "next", "label", "quit"))


def header(text: str) -> tuple[str, str] | None:
    """Code and version if a text is a log; both are empty in a log that begins after them.

    That is one which the command ``log`` begins. A capture of the screen may have other lines before.
    """
    lines = text.splitlines()
    printed = OUTPUT.search(text) is not None
    for line in lines if printed else lines[:MAX_BEFORE]:
        match = HEADER.match(line)
        if match:
            return match[1].lower(), match[2].strip()
    return ("", "") if printed else None


def commands(text: str, file: str, variables: Variables, state: type[State]) -> Iterator[Statement]:
    """The commands of a log in the order in which they ran."""
    known = HARMLESS | {name[8:] for name in dir(state) if name.startswith("command_")} | FLOW
    lines = text.split("\n")
    k = 0
    while k < len(lines):
        first = k + 1
        words = lines[k].split(maxsplit=1)
        k += 1
        # LAMMPS reports the time of some commands: "  create_atoms CPU = 0.001 seconds".
        if not words or words[0] not in known or (words[1:] and words[1].startswith("CPU = ")):
            continue
        pieces, quote = scan(lines[k - 1])
        code = "".join(piece for piece, _ in pieces)
        while quote == '"""' and k < min(len(lines), first + LONGEST_QUOTE):
            code, k = f"{code}\n{lines[k]}", k + 1
            pieces, quote = scan(code)
        # The same command follows once more after each replacement.
        while UNRESOLVED.search("".join(piece for piece, quoted in pieces if not quoted)) and k < len(lines):
            again, _ = scan(lines[k])
            replaced = "".join(piece for piece, _ in again)
            if replaced.split(maxsplit=1)[:1] != words[:1]:
                break
            pieces, code, k = again, replaced, k + 1
        command = split(code)
        if command[0] == "print" and len(command) > 1:
            for line in command[1].split("\n"):  # what it prints follows
                k += k < len(lines) and lines[k].startswith(line.partition("$")[0])
        if command[0] == "variable":
            variables.define(command[1:])
        elif command[0] == "next":
            variables.step(command[1:])
        elif command[0] not in ("include", "if", "jump", "label", "quit", "log"):
            command = clumps.with_printed(command, lines[k : k + clumps.PRINTED_WITHIN])
            yield Statement(first, command, code, file=file)
