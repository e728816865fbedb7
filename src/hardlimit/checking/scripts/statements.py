"""Statements of a script, split into words, and the message that refuses one."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

from ...support import validation
from .description import Quote, Setting, Settings

#: Longest quotation.
LONGEST: Final = 200
#: Most lines of a quoted text.
LONGEST_QUOTE: Final = 1000
QUOTES: Final = ('"""', '"', "'")
WORD: Final = re.compile(r'"""(.*?)"""(?!\S)|"([^"]*)"(?!\S)|\'([^\']*)\'(?!\S)|(\S+)', re.DOTALL)


class Refusal(ValueError):
    """What a script says is not understood, although contacts depend on it."""

    part = ""  #: the words that were not understood


@dataclass(frozen=True)
class Statement:
    """A command. The first word is its name."""

    line: int  #: first line, counted from 1
    words: tuple[str, ...]
    text: str
    file: str = ""
    branches: tuple[Branch, ...] = ()  #: of ``if`` whose condition only a run knows
    place: Place | None = None  #: of a label to which a branch leads

    @property
    def quote(self) -> Quote:
        """The statement as messages quote it."""
        return quoted(self.file, self.line, self.text)


class Undefined(Refusal):
    """Contacts depend on variables without a value in a statement."""

    def __init__(self, statement: Statement) -> None:
        super().__init__(str(refused(statement, "have values for its variables")))
        self.statement = statement


#: A file that is being read, by its number, and one of its lines.
Place = tuple[int, int]


@dataclass(frozen=True)
class Branch:
    """What may happen at ``if``: commands, and where the script then goes on."""

    statements: tuple[Statement, ...]
    place: Place | None = None  #: a later label; None for the next line
    ends: bool = False  #: whether the script ends


def quoted(file: str, line: int, text: str) -> Quote:
    """A quotation on one line of limited length."""
    plain = " ".join(text.split())
    return Quote(file, line, plain if len(plain) <= LONGEST else f"{plain[: LONGEST - 1]}…")


def refusal(line: int, text: str, must: str, file: str = "") -> ValueError:
    """The error for a part of an input, with its line and text."""
    part = " ".join(text.split())
    error = Refusal(
        f"{' '.join(file.split()) or 'input'}: line {line}: got {validation.shown(part)}, must {must}"
    )
    error.part = part
    return error


def refused(statement: Statement, must: str) -> ValueError:
    """The error for a statement."""
    return refusal(statement.line, statement.text, must, statement.file)


def same_word(word: str, other: str) -> bool:
    """Whether two words are equal, however their numbers are written."""
    try:
        return float(word) == float(other)
    except ValueError:
        return word == other


def settings(statement: Statement, words: Mapping[str, tuple[str, ...]]) -> Settings:
    """Settings that a statement makes."""
    return {name: Setting(words, statement.line, statement.text) for name, words in words.items()}


# --- words of LAMMPS and LIGGGHTS -------------------------------------------------------------------------------


def logical_lines(text: str) -> list[tuple[int, str]]:
    """Lines with their numbers, joined where ``&`` or an open triple quote continues them."""
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    logical, k = [], 0
    while k < len(lines):
        first, line = k + 1, lines[k]
        while k + 1 < len(lines):
            stripped = line.rstrip()
            if stripped.endswith("&"):
                line = stripped[:-1] + lines[k + 1]
            elif '"""' in line and open_quote(line) == '"""':
                if k - first > LONGEST_QUOTE:
                    raise refusal(first, lines[first - 1], 'close its quotes """')
                line += "\n" + lines[k + 1]
            else:
                break
            k += 1
        logical.append((first, line))
        k += 1
    return logical


@lru_cache(4096)
def scan(line: str) -> tuple[tuple[tuple[str, bool], ...], str]:
    """Pieces of a line up to # outside quotes, each with whether it is quoted; and the quote that is still open."""
    pieces: list[tuple[str, bool]] = []
    quote, i = "", 0
    while i < len(line):
        begun = next((q for q in QUOTES if line.startswith(q, i)), "")
        inside = bool(quote)
        if quote:
            step = quote if line.startswith(quote, i) else line[i]
            quote = "" if step == quote else quote
        elif begun:
            step = quote = begun
        elif line[i] == "#":
            break
        else:
            step = line[i]
        kind = inside or bool(begun)
        if pieces and pieces[-1][1] == kind:
            pieces[-1] = (pieces[-1][0] + step, kind)
        else:
            pieces.append((step, kind))
        i += len(step)
    return tuple(pieces), quote


def open_quote(line: str) -> str:
    """The quote that is open at the end of a line."""
    return scan(line)[1]


@lru_cache(4096)
def split(code: str) -> tuple[str, ...]:
    """Words of a command without its comment."""
    return tuple(next((g for g in match.groups() if g is not None), "") for match in WORD.finditer(code))
