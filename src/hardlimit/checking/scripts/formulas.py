"""Formulas of LAMMPS' variables: operators, parentheses, functions and names.

Unary operators bind tighter than ``^``, and all operators associate to the left, as the command ``variable`` of LAMMPS
documents.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Mapping
from typing import Final

NUMBER: Final = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
TOKEN: Final = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|(?P<name>[A-Za-z_][\w.]*)"
    r"|(?P<sign>==|!=|<=|>=|&&|\|\||\|\^|[-+*/%^<>!(),]))",
    re.ASCII,
)
#: Binary operators from the loosest to the tightest.
LEVELS: Final[tuple[Mapping[str, Callable[[float, float], float]], ...]] = (
    {
        "||": lambda a, b: float(bool(a) or bool(b)),
        "|^": lambda a, b: float(bool(a) != bool(b)),
    },
    {"&&": lambda a, b: float(bool(a) and bool(b))},
    {"==": operator.eq, "!=": operator.ne},
    {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge},
    {"+": operator.add, "-": operator.sub},
    {"*": operator.mul, "/": operator.truediv, "%": math.fmod},
    {"^": math.pow},
)
FUNCTIONS: Final[dict[str, Callable[..., float]]] = {
    "sqrt": math.sqrt,
    "exp": math.exp,
    "ln": math.log,
    "log": math.log10,
    "abs": abs,
    "sign": lambda x: math.copysign(1.0, x),
    "sin": math.sin,
    "cos": math.cos,
    "tan": math.tan,
    "asin": math.asin,
    "acos": math.acos,
    "atan": math.atan,
    "atan2": math.atan2,
    "ceil": math.ceil,
    "floor": math.floor,
    "round": lambda x: math.floor(x + 0.5),
    "ternary": lambda condition, yes, no: yes if condition else no,
}
#: Deepest nesting of parentheses.
DEEPEST: Final = 100


def value(formula: str, names: Callable[[str], float | None]) -> float | None:
    """Value of a formula; None if it is not understood, not finite, or has a name without a value."""
    try:
        number = float(_Parser(formula, names).parsed())
        return number if math.isfinite(number) else None
    except (ValueError, TypeError, ZeroDivisionError, OverflowError):
        return None


class _Parser:
    """Recursive descent through the levels of operators."""

    def __init__(self, formula: str, names: Callable[[str], float | None]) -> None:
        self.names, self.depth, self.at = names, 0, 0
        self.tokens: list[tuple[str, str]] = []
        place, text = 0, formula.strip()
        while place < len(text):
            match = TOKEN.match(text, place)
            if match is None:
                raise ValueError
            self.tokens.append((str(match.lastgroup), match[0].strip()))
            place = match.end()

    def parsed(self) -> float:
        result = self.level(0)
        if self.at != len(self.tokens):
            raise ValueError
        return result

    def next(self) -> tuple[str, str]:
        return self.tokens[self.at] if self.at < len(self.tokens) else ("", "")

    def expect(self, sign: str) -> None:
        if self.next()[1] != sign:
            raise ValueError
        self.at += 1

    def level(self, k: int) -> float:
        if k == len(LEVELS):
            return self.unary()
        result, operators = self.level(k + 1), LEVELS[k]
        while (sign := self.next()[1]) in operators:
            self.at += 1
            result = operators[sign](result, self.level(k + 1))
        return result

    def unary(self) -> float:
        sign = self.next()[1]
        self.depth += 1
        if self.depth > DEEPEST:
            raise ValueError
        if sign in ("-", "+", "!"):
            self.at += 1
            operand = self.unary()
            result = -operand if sign == "-" else operand if sign == "+" else float(not operand)
        else:
            result = self.atom()
        self.depth -= 1
        return result

    def atom(self) -> float:
        kind, text = self.next()
        self.at += 1
        if kind == "number":
            return float(text)
        if text == "(":
            result = self.level(0)
            self.expect(")")
            return result
        if kind != "name":
            raise ValueError
        if self.next()[1] == "(":
            arguments: list[float] = []
            while not arguments or self.next()[1] == ",":
                self.at += 1
                arguments.append(self.level(0))
            self.expect(")")
            if text not in FUNCTIONS:
                raise ValueError
            return FUNCTIONS[text](*arguments)
        known = math.pi if text in ("PI", "pi") else self.names(text)
        if known is None:
            raise ValueError
        return known
