"""Parsers that split the input of particle codes into words, as each code does. Nothing in it is executed.

LAMMPS and LIGGGHTS: continuation lines with ``&``, comments, quotes, variables (docs.lammps.org/Commands_parse.html).
YADE: literals, arithmetic and names with one value, in Python. C++, Fortran namelists, JSON and XML: calls,
assignments, members and attributes.
"""

from __future__ import annotations

import ast
import math
import operator
import re
import textwrap
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from ..support import validation

NUMBER: Final = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")


@dataclass(frozen=True)
class Statement:
    """A command, a call or an assignment. The first word is its name."""

    line: int  #: first line, counted from 1
    words: tuple[str, ...]
    text: str
    owner: str = ""  #: object of a call or bodies of an element


def refusal(line: int, text: str, must: str) -> ValueError:
    """The error for a part of an input, with its line and text."""
    shown = validation.shown(" ".join(text.split()))
    return ValueError(f"input: line {line}: got {shown}, must {must}")


# --- arithmetic -----------------------------------------------------------------------------------------------

Names = Mapping[str, float]
OPERATORS: Final[dict[type, Callable[[float, float], float]]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: math.pow,
}
FUNCTIONS: Final[dict[str, Callable[[float], float]]] = {
    "sqrt": math.sqrt,
    "exp": math.exp,
    "ln": math.log,
    "abs": abs,
    "float": float,
}


def value(formula: str, names: Names) -> float | None:
    """Value of a formula with numbers, names, + − * / ** and parentheses; None for anything else."""
    try:
        return value_of(ast.parse(formula.strip(), mode="eval").body, names)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None


def value_of(tree: ast.AST, names: Names) -> float | None:
    """The same for parsed Python. Powers of powers and of −x are None: codes differ in their precedence."""
    try:
        found = _value(tree, names)
    except (ValueError, TypeError, KeyError, ZeroDivisionError, OverflowError, RecursionError):
        return None
    return found if math.isfinite(found) else None


def _value(tree: ast.AST, names: Names) -> float:
    match tree:
        case ast.Constant(int() | float() as number) if not isinstance(number, bool):
            return float(number)
        case ast.Name(name):
            return names[name]
        case ast.Attribute(_, "pi"):
            return math.pi
        case ast.UnaryOp(ast.USub(), operand) if not _is_power(operand):
            return -_value(operand, names)
        case ast.UnaryOp(ast.UAdd(), operand):
            return _value(operand, names)
        case ast.BinOp(left, sign, right) if not (_is_power(tree) and (_is_power(left) or _is_power(right))):
            return OPERATORS[type(sign)](_value(left, names), _value(right, names))
        case ast.Call(ast.Name(function) | ast.Attribute(_, function), [argument], []):
            return FUNCTIONS[function](_value(argument, names))
    raise ValueError


def _is_power(tree: ast.AST) -> bool:
    return isinstance(tree, ast.BinOp) and isinstance(tree.op, ast.Pow)


# --- LAMMPS and LIGGGHTS --------------------------------------------------------------------------------------

QUOTES: Final = ('"""', '"', "'")
WORD: Final = re.compile(r'"""(.*?)"""(?!\S)|"([^"]*)"(?!\S)|\'([^\']*)\'(?!\S)|(\S+)', re.DOTALL)
VARIABLE: Final = re.compile(r"\$(?:\{(\w+)\}|(\w)|\(([^()]*(?:\([^()]*\)[^()]*)*)\))", re.ASCII)
#: Styles that do not redefine an existing variable.
KEPT: Final = ("index", "loop", "world", "universe", "uloop", "file", "getenv")


def script(text: str) -> Iterator[Statement]:
    """Commands of LAMMPS and LIGGGHTS; variables are replaced by their values if these are known."""
    variables: dict[str, tuple[str, str]] = {}
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    stepped = {name for line in lines if line.split()[:1] == ["next"] for name in line.split()[1:]}
    k = 0
    while k < len(lines):
        first, line = k + 1, lines[k]
        while (at := line.rstrip()).endswith("&") and k + 1 < len(lines):
            k += 1
            line = at[:-1] + lines[k]
        code, quote = _without_comment(line, variables)
        while quote == '"""' and k + 1 < len(lines):
            k += 1
            line += "\n" + lines[k]
            code, quote = _without_comment(line, variables)
        if quote:
            raise refusal(first, line, f"close its quotes {quote}")
        k += 1
        words = tuple(next((g for g in found.groups() if g is not None), "") for found in WORD.finditer(code))
        if words[:1] == ("variable",):
            _define(words[1:], variables, stepped)
        elif words:
            yield Statement(first, words, code)


def _without_comment(line: str, variables: Mapping[str, tuple[str, str]]) -> tuple[str, str]:
    """A line up to # outside quotes, with variables outside quotes replaced; and the quote that is still open."""
    done, quote, i = "", "", 0
    while i < len(line):
        begun = next((q for q in QUOTES if line.startswith(q, i)), "")
        if quote:
            step = quote if line.startswith(quote, i) else line[i]
            quote = "" if step == quote else quote
        elif begun:
            step = quote = begun
        elif line[i] == "#":
            break
        elif found := VARIABLE.match(line, i):
            done += _replaced(found, variables)
            i = found.end()
            continue
        else:
            step = line[i]
        done += step
        i += len(step)
    return done, quote


def _replaced(found: re.Match[str], variables: Mapping[str, tuple[str, str]]) -> str:
    """The text that replaces a variable; the variable itself if its value is unknown."""
    if found[3] is not None:
        formula, _, form = found[3].partition(":")
        number = _formula(formula, variables)
        if form and number is not None:
            return form % number if re.fullmatch(r"%[-+ 0#]*\d*(?:\.\d+)?[aefgAEFG]", form) else found[0]
        return found[0] if number is None else repr(number)
    style, text = variables.get(found[1] or found[2], ("", ""))
    if style == "equal":
        number = _formula(text, variables)
        return found[0] if number is None else f"{number:.15g}"
    return text if style in ("index", "string") else found[0]


def _formula(formula: str, variables: Mapping[str, tuple[str, str]], depth: int = 0) -> float | None:
    names: dict[str, float] = {"PI": math.pi}
    for name in re.findall(r"\bv_(\w+)", formula, re.ASCII):
        style, text = variables.get(name, ("", ""))
        if style and depth < 20:
            found = _formula(text, variables, depth + 1)
            if found is not None:
                names[f"v_{name}"] = found
    return value(formula.replace("^", "**"), names)


def _define(words: Sequence[str], variables: dict[str, tuple[str, str]], stepped: Collection[str]) -> None:
    """Define a variable. If ``next`` steps through its values, it has no known value."""
    if len(words) < 2:
        return
    name, style, *values = words
    if style == "delete":
        variables.pop(name, None)
    elif style not in KEPT or name not in variables:
        text = " ".join(values) if style == "equal" else values[0] if values else ""
        known = {"internal": "equal"}.get(style, style)
        variables[name] = ("stepped" if name in stepped else known, text)


# --- Python ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Call:
    """A Python call with its keyword arguments: a number, numbers of pairs, or source text."""

    line: int
    name: str
    keywords: Mapping[str, float | dict[tuple[int, int], float] | str]
    text: str


def python_calls(text: str) -> list[Call]:
    """All calls in order. An assignment to an attribute counts as a call of ``=`` with one keyword."""
    try:
        tree = ast.parse(textwrap.dedent(text))
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        line = getattr(error, "lineno", None) or 1
        lines = text.splitlines() or [""]
        raise refusal(line, lines[min(line, len(lines)) - 1], "be Python") from None
    visitor = _Calls(text)
    try:
        visitor.visit(tree)
    except RecursionError:
        raise refusal(1, text[:80], "be nested less deeply") from None
    return visitor.found


class _Calls(ast.NodeVisitor):
    def __init__(self, text: str) -> None:
        self.text, self.found, self.depth = text, [], 0
        self.names: dict[str, float] = {"pi": math.pi}

    found: list[Call]

    def visit_Assign(self, node: ast.Assign) -> None:
        self.visit(node.value)
        number = value_of(node.value, self.names) if self.depth == 0 else None
        for target in node.targets:
            self._assign(target, node.value, number)

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            self.visit(node.value)
            number = value_of(node.value, self.names) if self.depth == 0 else None
            self._assign(node.target, node.value, number)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        self.visit(node.value)
        self._assign(node.target, node.value, None)

    def _assign(self, target: ast.AST, given: ast.expr, number: float | None) -> None:
        if isinstance(target, ast.Name):
            self.names.pop(target.id, None)
            if number is not None:
                self.names[target.id] = number
        elif isinstance(target, ast.Attribute):
            self._add("=", target, {target.attr: self._keyword(given)})
        elif isinstance(target, ast.Tuple | ast.List) and isinstance(given, ast.Tuple | ast.List):
            for each, its in zip(target.elts, given.elts, strict=False):
                self._assign(each, its, value_of(its, self.names) if self.depth == 0 else None)
        else:
            for one in ast.walk(target):
                if isinstance(one, ast.Name):
                    self.names.pop(one.id, None)

    def _nested(self, node: ast.AST) -> None:
        """Code that may run any number of times. Names that it assigns have no known value, before or after."""
        for one in ast.walk(node):
            if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Store):
                self.names.pop(one.id, None)
        self.depth += 1
        self.generic_visit(node)
        self.depth -= 1

    visit_For = visit_While = visit_If = visit_FunctionDef = visit_Try = visit_With = visit_Lambda = _nested
    visit_ListComp = visit_GeneratorExp = visit_ClassDef = visit_Match = _nested

    def visit_Call(self, node: ast.Call) -> None:
        self.generic_visit(node)
        name = getattr(node.func, "attr", getattr(node.func, "id", ""))
        self._add(name, node, {word.arg or "**": self._keyword(word.value) for word in node.keywords})

    def _keyword(self, node: ast.expr) -> float | dict[tuple[int, int], float] | str:
        number = value_of(node, self.names)
        if number is not None:
            return number
        if isinstance(node, ast.Constant) and isinstance(node.value, bool):
            return float(node.value)
        return self._matches(node) or ast.unparse(node)

    def _matches(self, node: ast.expr) -> dict[tuple[int, int], float] | None:
        """Numbers of MatchMaker(matches=[(id, id, number), …])."""
        match node:
            case ast.Call(
                ast.Name("MatchMaker"), [], [ast.keyword("matches", ast.List(entries) | ast.Tuple(entries))]
            ):
                found = {}
                for entry in entries:
                    three = [value_of(one, self.names) for one in getattr(entry, "elts", [])]
                    if len(three) != 3 or None in three:
                        return None
                    i, j, number = three
                    found[int(min(i, j)), int(max(i, j))] = number  # type: ignore[type-var, arg-type]
                return found  # type: ignore[return-value]
        return None

    def _add(
        self, name: str, node: ast.AST, keywords: dict[str, float | dict[tuple[int, int], float] | str]
    ) -> None:
        self.found.append(Call(node.lineno, name, keywords, ast.unparse(node)))  # type: ignore[attr-defined]


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


def c_calls(text: str) -> Iterator[Statement]:
    """Calls ``object->name(number, …)``, with variables that were assigned a number replaced by it."""
    pieces, names = tokens(text), dict[str, float]()
    for k, piece in enumerate(pieces):
        after = pieces[k + 1].text if k + 1 < len(pieces) else ""
        if piece.kind != "name" or after not in ("(", "="):
            continue
        ends = (";",) if after == "=" else (")",)
        arguments, line = _arguments(pieces, k + 2, ends), piece.line
        if after == "=":
            number = value(_plain(arguments[0]), names) if len(arguments) == 1 else None
            names.pop(piece.text, None)
            if number is not None:
                names[piece.text] = number
            continue
        words = []
        for argument in arguments:
            number = value(_plain(argument), names)
            written = "".join(one.text for one in argument)
            words.append(re.split(r"::|\.", written)[-1] if number is None else repr(number))
        owner = pieces[k - 2].text if k >= 2 and pieces[k - 1].text in ("->", ".") else ""
        said = f"{piece.text}({', '.join(''.join(t.text for t in a) for a in arguments)})"
        yield Statement(line, (piece.text, *words), said, owner)


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
    """A formula in Python: numbers without suffixes such as f."""
    return "".join(one.text.rstrip("fFlL") if one.kind == "number" else one.text for one in pieces)


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
