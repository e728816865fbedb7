"""Parsers that split the input of particle codes in C++, Fortran namelists, JSON and XML into statements.

They find calls, assignments, members and attributes. Nothing is executed. The package ``scripts`` reads LAMMPS,
LIGGGHTS and YADE.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from ..checking.scripts import formulas
from ..checking.scripts.statements import Statement

# --- C++, namelists, JSON, XML --------------------------------------------------------------------------------

C_TOKEN: Final = re.compile(
    r'(?P<comment>//[^\n]*|/\*.*?\*/)|(?P<string>"(?:\\.|[^"\\\n])*")|(?P<space>\s+)'
    r"|(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?[fFlL]?)|(?P<name>[A-Za-z_][\w:]*)|(?P<sign>->|.)",
    re.DOTALL,
)


@dataclass(frozen=True)
class Token:
    """A token of C++ or JSON."""

    kind: str
    text: str
    line: int


def tokens(text: str) -> list[Token]:
    """Tokens of C++ or JSON without blanks and comments."""
    found, line = [], 1
    for one in C_TOKEN.finditer(text):
        kind = str(one.lastgroup)
        if kind not in ("comment", "space"):
            found.append(Token(kind, one[0], line))
        line += one[0].count("\n")
    return found


INTEGERS: Final = ("int", "unsigned", "long", "short", "size_t", "std::size_t")
REALS: Final = ("double", "float", "Mdouble", "real")
#: Operators after a name that change its value.
CHANGED: Final = re.compile(r"(?:[-+*/%&|^]|<<|>>)=|\+\+|--")


def c_calls(text: str) -> Iterator[Statement]:
    """Calls ``object->name(number, …)``, with variables that have exactly one value replaced by it."""
    pieces, names = tokens(text), dict[str, float]()
    types, constants = _declared(pieces)

    def value(argument: Sequence[Token]) -> float | None:
        return formulas.value(_plain(argument), names.get, formulas.C)

    for k, piece in enumerate(pieces):
        after = pieces[k + 1].text if k + 1 < len(pieces) else ""
        if piece.kind != "name" or after not in ("(", "="):
            continue
        arguments, line = _arguments(pieces, k + 2, (";", ")")), piece.line
        owner = pieces[k - 2].text if k >= 2 and pieces[k - 1].text in ("->", ".") else ""
        if after == "=":
            own = piece.text in constants and owner in ("", "this")
            number = value(arguments[0]) if arguments and own else None
            if number is not None:
                kind = types.get(piece.text)
                names[piece.text] = (
                    int(number) if kind in INTEGERS else float(number) if kind in REALS else number
                )
            continue
        words = []
        for argument in arguments:
            number = value(argument)
            written = "".join(one.text for one in argument)
            words.append(re.split(r"::|\.", written)[-1] if number is None else repr(float(number)))
        said = f"{piece.text}({', '.join(''.join(t.text for t in a) for a in arguments)})"
        yield Statement(line, (piece.text, *words), said, owner)


def _declared(pieces: Sequence[Token]) -> tuple[dict[str, str], set[str]]:
    """Types of names, and the names that are assigned one formula and are not changed in another way."""
    types, given, depth = dict[str, str](), dict[str, set[str]](), 0
    for k, piece in enumerate(pieces):
        depth += {"(": 1, ")": -1}.get(piece.text, 0)
        if piece.kind != "name":
            continue
        before = [one.text for one in pieces[max(k - 2, 0) : k]]
        after = [one.text for one in pieces[k + 1 : k + 4]]
        declared = k > 0 and pieces[k - 1].kind == "name"
        if declared:
            types[piece.text] = before[-1]
        assigned = after[:1] == ["="] and after[1:2] != ["="]
        referred = before[-1:] == ["&"] and before != ["&", "&"]
        if (
            CHANGED.match("".join(after))
            or "".join(before) in ("++", "--", ">>")
            or (declared and after[:1] in (["("], ["{"]))
            or ((declared or assigned) and depth > 0)  # such as a parameter
            or referred
        ):
            given.setdefault(piece.text, set()).add("")
        elif assigned:
            formula = "".join(one.text for one in next(iter(_arguments(pieces, k + 2, (";",))), []))
            if formula != piece.text:  # a member of an object that takes the value of the name
                given.setdefault(piece.text, set()).add(formula)
    return types, {name for name, texts in given.items() if len(texts) == 1 and "" not in texts}


def _arguments(pieces: Sequence[Token], k: int, ends: Sequence[str]) -> list[list[Token]]:
    """Arguments between commas, up to the end."""
    found: list[list[Token]] = [[]]
    depth = 0
    for piece in pieces[k:]:
        if depth == 0 and piece.text in ends:
            break
        depth += {"(": 1, "[": 1, "{": 1, ")": -1, "]": -1, "}": -1}.get(piece.text, 0)
        if piece.text == "," and depth == 0:
            found.append([])
        else:
            found[-1].append(piece)
    return [one for one in found if one]


def _plain(pieces: Sequence[Token]) -> str:
    """A formula without suffixes of numbers such as f, and without ``this->``."""
    plain = "".join(one.text.rstrip("fFlL") if one.kind == "number" else one.text for one in pieces)
    return plain.replace("this->", "")


def json_members(text: str) -> Iterator[Statement]:
    """Members ``"name": value`` with a number or a string, at any depth."""
    pieces = tokens(text)
    for k, piece in enumerate(pieces):
        if piece.kind == "string" and [one.text for one in pieces[k + 1 : k + 2]] == [":"]:
            given = pieces[k + 2 : k + 4]
            signed = len(given) == 2 and given[0].text == "-"
            written = "".join(one.text for one in given[: 2 if signed else 1])
            yield Statement(
                piece.line, (piece.text.strip('"'), written.strip('"')), f"{piece.text}: {written}"
            )


QUOTED: Final = r"""(?:"[^"]*"|'[^']*')"""
ELEMENT: Final = re.compile(rf"<(\w+)((?:\s+[\w:]+\s*=\s*{QUOTED})*)\s*/?>|(\bsolref\s*=\s*{QUOTED})")
ATTRIBUTE: Final = re.compile(r"([\w:]+)\s*=\s*(?:\"([^\"]*)\"|'([^']*)')")


def xml_attributes(text: str) -> Iterator[Statement]:
    """Attributes of elements with their values split at blanks. The owner is the pair of geoms."""
    plain = re.sub(r"<!--.*?-->", lambda found: "\n" * found[0].count("\n"), text, flags=re.DOTALL)
    for element in ELEMENT.finditer(plain):
        listed = [
            (a[1], a[2] if a[2] is not None else a[3])
            for a in ATTRIBUTE.finditer(element[2] or element[3] or "")
        ]
        geoms = [given for name, given in listed if name in ("geom1", "geom2")]
        line = plain[: element.start()].count("\n") + 1
        for name, given in listed:
            yield Statement(line, (name, *given.split()), f'{name}="{given}"', "-".join(geoms))


NAMELIST: Final = re.compile(r"\s*(\w+)\s*(?:\(\s*([\d\s,]+)\s*\))?\s*=\s*(.*?)\s*", re.ASCII)


def namelist(text: str) -> Iterator[Statement]:
    """Assignments ``NAME(index) = value …`` in upper case. The second word is the index, by default 1."""
    for number, line in enumerate(text.replace("\r\n", "\n").split("\n"), 1):
        code = re.split(r"[!#](?=(?:[^']*'[^']*')*[^']*$)", line)[0]
        found = NAMELIST.fullmatch(code)
        if found:
            values = []
            for word in re.findall(r"'[^']*'|\"[^\"]*\"|[^\s,]+", found[3]):
                count, star, one = word.partition("*")
                one = word if not (star and count.isdigit()) else one
                double = re.fullmatch(r"([+-]?[\d.]+)[dD]([+-]?\d+)", one)
                one = f"{double[1]}e{double[2]}" if double else one.strip("'\"")
                values += [one] * (min(int(count), 1000) if star and count.isdigit() else 1)
            yield Statement(number, (found[1].upper(), (found[2] or "1").strip(), *values), code)
