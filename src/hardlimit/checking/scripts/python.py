"""A small evaluator of Python scripts: assignments, arithmetic, short loops, functions, classes, and what calls create.

Only arithmetic is computed. A call of anything else makes an :class:`Instance` with its arguments. What is not
understood is :class:`Unknown`. Arguments of the command line have their defaults.
"""

from __future__ import annotations

import ast
import itertools
import math
import operator
import re
import textwrap
import warnings
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, Final

from .description import WANTED
from .statements import Refusal, quoted, refusal

#: A print statement of Python 2.
PRINT: Final = re.compile(r"(^[ \t]*|[:;][ \t]*)print\b(?![ \t]*\()([^\n]*)", re.MULTILINE)
#: A name, perhaps of a member of modules or objects.
DOTTED: Final = re.compile(r"[A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*")
MAX_STEPS: Final = 200_000
MAX_ITEMS: Final = 20_000  #: of a list
DEEPEST: Final = 8  #: nesting of calls of the script's own functions

Operator = Callable[[Any, Any], Any]
OPERATORS: Final[dict[type, Operator]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
}
COMPARISONS: Final[dict[type, Operator]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.In: lambda a, b: a in b,
    ast.NotIn: lambda a, b: a not in b,
    ast.Is: operator.is_,
    ast.IsNot: operator.is_not,
}
MATH: Final = """
sqrt exp log log10 log2 sin cos tan asin acos atan atan2 sinh cosh tanh radians degrees pow hypot floor ceil fabs
"""
FUNCTIONS: Final[dict[str, Callable[..., Any]]] = {
    **{name: getattr(math, name) for name in MATH.split()},
    "linspace": lambda first, last, n=50: Vector(
        first + (last - first) * k / max(int(n) - 1, 1) for k in range(min(int(n), MAX_ITEMS))
    ),
    "arange": lambda *ends: Vector(spaced(*((0, *ends) if len(ends) == 1 else ends))),
    "array": lambda values: Vector(values),
    "arcsin": math.asin,
    "arccos": math.acos,
    "arctan": math.atan,
    **{function.__name__: function for function in (abs, min, max, round, float, int, sum, len)},
    "Real": float,
    "toHP1": float,
    "radiansHP1": math.radians,
    "degreesHP1": math.degrees,
}
#: Those that take texts.
OF_TEXTS: Final = ("float", "int", "Real", "toHP1", "len")
#: Functions of lists, whose elements may be anything.
LISTS: Final[dict[str, Callable[..., Any]]] = {
    "enumerate": lambda *values: list(enumerate(*values)),
    "zip": lambda *values: list(zip(*values, strict=False)),
    "reversed": lambda values: list(reversed(values)),
    "list": lambda values=(): list(values),
    "tuple": lambda values=(): tuple(values),
}
#: Modules whose members are those functions and constants.
MODULES: Final = ("math", "np", "numpy", "utils", "yade.utils", "yade.math")
CONSTANTS: Final = {"pi": math.pi, "e": math.e, "inf": math.inf}


@dataclass(frozen=True)
class Unknown:
    """A value that is not known, with its source text."""

    text: str


class Vector(tuple[Any, ...]):
    """Components of a vector, with the arithmetic of vectors."""

    def _each(self, other: Any, of: Operator) -> Vector:
        if isinstance(other, tuple) and len(other) == len(self):
            return Vector(of(a, b) for a, b in zip(self, other, strict=True))
        if isinstance(other, int | float):
            return Vector(of(a, other) for a in self)
        raise TypeError

    def __add__(self, other: Any) -> Vector:
        return self._each(other, operator.add)

    def __sub__(self, other: Any) -> Vector:
        return self._each(other, operator.sub)

    def __mul__(self, other: Any) -> Vector:
        return self._each(other, operator.mul)

    def __truediv__(self, other: Any) -> Vector:
        return self._each(other, operator.truediv)

    __rmul__ = __mul__


@dataclass(eq=False)
class Instance:
    """What a call creates: its name, positional arguments and attributes."""

    name: str
    arguments: tuple[Any, ...]
    attributes: dict[str, Any]
    line: int
    text: str
    made: list[Any] = field(default_factory=list)  #: what its methods added

    def argument(self, place: int, name: str, default: Any = None) -> Any:
        """An argument by its name or place."""
        if name in self.attributes:
            return self.attributes[name]
        return self.arguments[place] if 0 <= place < len(self.arguments) else default


#: In place of the value of a call that is no arithmetic.
NOT_COMPUTED: Final = Unknown("")


class Return(Exception):  # not an error
    """The end of one of the script's own functions."""


class Missing(Exception):  # not an error
    """An argument of the command line that is not given, inside ``try``."""


class Arguments(list[Any]):
    """``sys.argv`` of a script that is started without arguments."""


@dataclass
class Evaluator:
    """Runs the statements of a script as far as they are understood."""

    text: str
    file: str = ""
    names: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.lines = self.text.splitlines()
        self.instances: list[Instance] = []
        self.functions: dict[str, ast.FunctionDef] = {}
        self.defaults: dict[ast.AST, dict[str, Any]] = {}  #: of the arguments of functions
        self.classes: dict[str, dict[str, ast.FunctionDef]] = {}  #: methods by name
        self.sources: dict[ast.AST, str] = {}
        self.executed: set[ast.AST] = set()  #: functions that were called
        self.entered: set[ast.AST] = set()  #: those among them whose statements were run here
        self.modules = set(MODULES)
        self.count = self.depth = 0
        self.repeats = 0  #: depth of statements that may run any number of times
        self.trials = 0  #: depth of ``try``

    def source(self, node: ast.AST) -> str:
        """The text of a part of the script."""
        if node not in self.sources:
            self.sources[node] = ast.unparse(node)
        return self.sources[node]

    def run(self) -> None:
        """Run the script. A ValueError if it is not Python."""
        self.tree = self.parsed()
        try:
            self.block(self.tree.body)
        except Return:
            pass
        except RecursionError:
            raise refusal(1, self.text[:80], "be nested less deeply", self.file) from None

    def parsed(self) -> ast.Module:
        """The script as a tree. Of print statements of Python 2 what they print is kept, or they are skipped."""
        text = textwrap.dedent(self.text)
        for attempt in (text, *(PRINT.sub(new, text.expandtabs()) for new in (r"\1(\2)", r"\1pass"))):
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")  # those about the script's own text
                    return ast.parse(attempt)
            except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
                line = getattr(error, "lineno", None) or 1
        lines = self.text.splitlines() or [""]
        raise refusal(line, lines[min(line, len(lines)) - 1], "be Python", self.file)

    # --- what a subclass may know -------------------------------------------------------------------------------

    def called(self, name: str, owner: Any, instance: Instance) -> Any:
        """The value of a call. ``owner`` is what stands before the dot, evaluated, or its name."""
        self.instances.append(instance)
        return instance

    def assigned(self, owner: Any, name: str, value: Any, node: ast.AST) -> None:
        """An assignment to an attribute."""
        if isinstance(owner, Instance):
            owner.attributes[name] = value

    def member(self, owner: Any, name: str, node: ast.Attribute) -> Any:
        """The value of an attribute."""
        if isinstance(owner, Instance) and name in owner.attributes:
            return owner.attributes[name]
        if name in CONSTANTS and isinstance(owner, str) and owner in self.modules:
            return CONSTANTS[name]
        if name == "argv" and owner == "sys":
            return Arguments([self.file or "script.py"])
        return Unknown(f"{owner}.{name}" if isinstance(owner, str) else self.source(node))

    def imported(self, node: ast.Import | ast.ImportFrom) -> None:
        """An import. Other names of modules and of their members stand for these."""
        for alias in node.names:
            if isinstance(node, ast.Import) and alias.asname:
                self.names[alias.asname] = Unknown(alias.name)
                if alias.name in MODULES:
                    self.modules |= {alias.asname}
            elif isinstance(node, ast.ImportFrom) and alias.asname:
                self.names[alias.asname] = Unknown(alias.name)
            elif isinstance(node, ast.ImportFrom) and alias.name == "argv":
                self.names["argv"] = Arguments([self.file or "script.py"])

    # --- statements ---------------------------------------------------------------------------------------------

    def step(self, node: ast.AST) -> None:
        self.count += 1
        if self.count > MAX_STEPS:
            line = getattr(node, "lineno", 1)
            raise refusal(line, self.source(node)[:200], "be part of shorter loops", self.file)

    def block(self, body: Iterable[ast.stmt]) -> None:
        """Statements in order."""
        for node in body:
            self.step(node)
            self.statement(node)

    def statement(self, node: ast.stmt) -> None:
        """One statement."""
        match node:
            case ast.Expr(value):
                self.value(value)
            case ast.Assign(targets, value):
                result = self.value(value)
                for target in targets:
                    self.assign(target, result, node)
            case ast.AnnAssign(target, _, ast.expr() as value):
                self.assign(target, self.value(value), node)
            case ast.AugAssign(target, sign, value):
                load = ast.parse(self.source(target), mode="eval").body
                ast.copy_location(load, target)
                whole = ast.copy_location(ast.BinOp(load, sign, value), node)
                self.assign(target, self.value(whole), node)
            case ast.For(target, iterable, body, other):
                self.loop(target, iterable, body)
                self.block(other)
            case ast.While():
                self.uncertain(node, [node.body])
            case ast.If(test, body, other):
                holds = self.value(test)
                if isinstance(holds, Unknown | Instance):
                    self.uncertain(node, [body, other])
                else:
                    self.block(body if holds else other)
            case ast.FunctionDef(name, given):
                self.functions[name] = node
                self.defaults[node] = self.default_values(given)
                self.names.pop(name, None)
            case ast.Import() | ast.ImportFrom():
                self.imported(node)
            case ast.ClassDef(name, body=body):
                self.classes[name] = {
                    method.name: method for method in body if isinstance(method, ast.FunctionDef)
                }
                for method in self.classes[name].values():
                    self.defaults[method] = self.default_values(method.args)
                self.names[name] = self.namespace(name, body, node)
            case ast.Return(value):
                raise Return(None if value is None else self.value(value))
            case ast.With(_, body):
                self.block(body)
            case ast.Try() | ast.TryStar():
                self.tried(node)
            case ast.Match(_, cases):
                self.uncertain(node, [case.body for case in cases])
            case ast.Delete(targets):
                for target in targets:
                    self.forget(target)

    def tried(self, node: ast.Try | ast.TryStar) -> None:
        """``try``: its body, and what handles an argument of the command line that is not given."""
        self.trials += 1
        try:
            self.block(node.body)
            self.block(node.orelse)
        except Missing:
            for handler in node.handlers[:1]:
                self.block(handler.body)
        finally:
            self.trials -= 1
        self.block(node.finalbody)

    def namespace(self, name: str, body: list[ast.stmt], node: ast.stmt) -> Instance:
        """The values that a class assigns, as its attributes; its methods are not run."""
        outside = dict(self.names)
        self.block(statement for statement in body if isinstance(statement, ast.Assign | ast.AnnAssign))
        members = {
            key: value for key, value in self.names.items() if key not in outside or outside[key] is not value
        }
        self.names = outside
        return Instance(name, (), members, node.lineno, name)

    def loop(self, target: ast.expr, iterable: ast.expr, body: list[ast.stmt]) -> None:
        """A loop over known values; if it is too long or ends early, its body once, with names of unknown value."""
        items = self.items(iterable)
        jumps = any(isinstance(node, ast.Break | ast.Continue) for part in body for node in ast.walk(part))
        long = (
            sum(1 for part in body for _ in ast.walk(part)) * len(items or ()) > MAX_STEPS // 2 - self.count
        )
        if items is None or jumps or long:
            self.uncertain(target, [body], also=target, items=items)
            return
        for item in items:
            self.assign(target, item, target)
            self.block(body)

    def items(self, node: ast.expr) -> list[Any] | None:
        """What an iteration runs over; None if it is not known or too long."""
        iterable = self.value(node)
        if isinstance(iterable, range | list | tuple | str) and len(iterable) <= MAX_ITEMS:
            return list(iterable)
        return None

    def one_of(self, items: list[Any], text: str) -> Any:
        """What stands for any of these values."""
        return Unknown(text)

    def uncertain(
        self,
        node: ast.AST,
        bodies: list[list[ast.stmt]],
        also: ast.AST | None = None,
        items: list[Any] | None = None,
    ) -> None:
        """Statements that may run any number of times. Names that they assign have no known value afterwards.

        ``also``: the target of a loop over these ``items``.
        """
        changed = [part for body in bodies for part in body] + ([also] if also is not None else [])
        for part in changed:
            self.forget(part)
        self.repeats += 1
        if isinstance(also, ast.Name) and items:
            self.names[also.id] = self.one_of(items, also.id)
        for body in bodies:
            with suppress(Return, Missing):
                self.block(body)
        self.repeats -= 1
        for part in changed:
            self.forget(part)

    def forget(self, node: ast.AST) -> None:
        """Names that a part of the script assigns are no longer known."""
        for inner in ast.walk(node):
            if isinstance(inner, ast.Name) and isinstance(inner.ctx, ast.Store | ast.Del):
                self.names.pop(inner.id, None)

    def assign(self, target: ast.expr, value: Any, node: ast.AST) -> None:
        """Assign to a name, an attribute, or several of them."""
        match target:
            case ast.Name(name):
                self.names[name] = value
            case ast.Attribute(owner, name):
                self.assigned(self.owner(owner), name, value, node)
            case ast.Tuple(parts) | ast.List(parts):
                known = list(value) if isinstance(value, tuple | list) and len(value) == len(parts) else None
                for k, part in enumerate(parts):
                    self.assign(part, known[k] if known else Unknown(self.source(part)), node)
            case ast.Subscript(owner, place):
                container, key = self.value(owner), self.value(place)
                with suppress(TypeError, IndexError, KeyError):
                    if isinstance(container, list | dict):
                        container[key] = value
            case ast.Starred():
                self.forget(target)

    # --- values -------------------------------------------------------------------------------------------------

    def owner(self, node: ast.expr) -> Any:
        """What stands before a dot: its value, or its source text if that is not known."""
        value = self.value(node)
        return value.text if isinstance(value, Unknown) else value

    def value(self, node: ast.expr) -> Any:
        """The value of an expression."""
        self.step(node)
        try:
            value = self._value(node)
        except (Refusal, Missing):
            raise
        except (ValueError, TypeError, KeyError, IndexError, ArithmeticError, AttributeError):
            return Unknown(self.source(node))
        if (
            isinstance(value, float)
            and not math.isfinite(value)
            and not isinstance(node, ast.Name | ast.Attribute)
        ):
            return Unknown(self.source(node))
        return value

    def _value(self, node: ast.expr) -> Any:
        match node:
            case ast.Constant(value):
                return value
            case ast.Name(name):
                if name in self.names:
                    return self.names[name]
                return CONSTANTS["pi"] if name == "pi" else Unknown(name)
            case ast.Tuple(parts):
                return tuple(self.value(part) for part in parts)
            case ast.List(parts):
                return [self.value(part) for part in parts]
            case ast.Dict(keys, values):
                named = [
                    (None if key is None else self.value(key), self.value(v))
                    for key, v in zip(keys, values, strict=True)
                ]
                return {key: value for key, value in named if isinstance(key, str | int | float)}
            case ast.UnaryOp(sign, operand):
                return self.unary(sign, self.value(operand), node)
            case ast.BinOp(left, sign, right):
                return self.binary(self.value(left), sign, self.value(right), node)
            case ast.BoolOp(sign, parts):
                return self.boolean(isinstance(sign, ast.And), [self.value(part) for part in parts], node)
            case ast.Compare(left, signs, others):
                values = [self.value(operand) for operand in (left, *others)]
                if any(isinstance(value, Unknown | Instance) for value in values):
                    return self.compared(node, values)
                pairs = zip(signs, values, values[1:], strict=False)
                return all(COMPARISONS[type(sign)](value, next_one) for sign, value, next_one in pairs)
            case ast.IfExp(test, body, other):
                holds = self.value(test)
                if not isinstance(holds, Unknown | Instance):
                    return self.value(body if holds else other)
                ends = self.value(body), self.value(other)
                if [] in ends and all(isinstance(end, list) for end in ends):
                    return ends[0] or ends[1]  # what may be there counts as there
                return ends[0] if ends[0] == ends[1] else Unknown(self.source(node))
            case ast.Call():
                return self.call(node)
            case ast.Attribute(owner, name):
                return self.member(self.owner(owner), name, node)
            case ast.Subscript(owner, place):
                return self.item(self.value(owner), place, node)
            case ast.ListComp(element, generators) | ast.GeneratorExp(element, generators):
                before, items = dict(self.names), list[Any]()
                self.comprehension(element, generators, items)
                self.names = before
                return items
            case ast.JoinedStr(parts):
                texts = [self.formatted(part) for part in parts]
                return Unknown(self.source(node)) if None in texts else "".join(map(str, texts))
        return Unknown(self.source(node))

    def compared(self, node: ast.Compare, values: list[Any]) -> Any:
        """A comparison with a value that is not known."""
        return Unknown(self.source(node))

    def formatted(self, part: ast.expr) -> str | None:
        """A part of an f-string; None if it is not known."""
        if not isinstance(part, ast.FormattedValue):
            return str(self.value(part))
        value = self.value(part.value)
        form = "" if part.format_spec is None else self.value(part.format_spec)
        if isinstance(value, Unknown | Instance) or not isinstance(form, str) or len(form) > 5:
            return None
        return format(value, form)

    def unary(self, sign: ast.unaryop, value: Any, node: ast.expr) -> Any:
        if isinstance(value, Unknown | Instance | str):
            return Unknown(self.source(node))
        if isinstance(sign, ast.Not):
            return not value
        if isinstance(value, tuple):
            return Vector(-x for x in value) if isinstance(sign, ast.USub) else value
        return -value if isinstance(sign, ast.USub) else +value

    def binary(self, left: Any, sign: ast.operator, right: Any, node: ast.AST) -> Any:
        several = [isinstance(operand, Instance | list) for operand in (left, right)]
        if (
            all(several)
            and isinstance(sign, ast.Add)
            and not (isinstance(left, list) and isinstance(right, list))
        ):
            return flat([left, right])  # such as engines of motion, or facets and spheres
        if isinstance(left, Unknown | Instance) or isinstance(right, Unknown | Instance):
            return Unknown(self.source(node))
        if isinstance(sign, ast.Pow):
            return math.pow(left, right)
        sizes = [len(operand) for operand in (left, right) if isinstance(operand, str | list | tuple)]
        numbers = [
            operand for operand in (left, right) if isinstance(operand, int) and not isinstance(operand, bool)
        ]
        if sizes and isinstance(sign, ast.Mult) and numbers and max(sizes) * max(numbers) > MAX_ITEMS:
            return Unknown(self.source(node))
        if any(abs(number) > 1e100 for number in numbers) or (
            isinstance(left, str) and isinstance(sign, ast.Mod)
        ):
            return Unknown(self.source(node))
        return OPERATORS[type(sign)](left, right)

    def boolean(self, every: bool, values: list[Any], node: ast.expr) -> Any:
        for value in values:
            if isinstance(value, Unknown | Instance):
                return Unknown(self.source(node))
            if bool(value) != every:
                return value
        return values[-1]

    def item(self, container: Any, place: ast.expr, node: ast.expr) -> Any:
        if not isinstance(container, list | tuple | dict):
            return Unknown(self.source(node))
        if isinstance(place, ast.Slice):
            ends = [
                None if end is None else self.value(end) for end in (place.lower, place.upper, place.step)
            ]
            return container[slice(*ends)]
        key = self.value(place)
        if (
            isinstance(container, Arguments)
            and self.trials
            and isinstance(key, int)
            and key >= len(container)
        ):
            raise Missing
        return container[key]

    def comprehension(
        self, element: ast.expr, generators: list[ast.comprehension], values: list[Any]
    ) -> None:
        """Add the values of a comprehension. Over values or under conditions that are not known, its element once."""
        if not generators:
            values.append(self.value(element))
            return
        (generator, *inner), chosen = generators, list[Any]()
        items = self.items(generator.iter)
        if self.count > MAX_STEPS // 2:
            items = None  # such as a large lattice, whose other spheres are like those before
        self.repeats += items is None
        for item in [Unknown(self.source(generator.iter))] if items is None else items:
            self.assign(generator.target, item, generator.target)
            holds = [self.value(condition) for condition in generator.ifs]
            if any(isinstance(value, Unknown | Instance) for value in holds):
                chosen = [Unknown(self.source(generator.iter))]
                break
            chosen += [item] * all(holds)
        for item in chosen:
            self.assign(generator.target, item, generator.target)
            self.comprehension(element, inner, values)
        self.repeats -= items is None

    def call(self, node: ast.Call) -> Any:
        """A call: arithmetic, one of the script's own functions, or an instance."""
        owner, name = self.callee(node.func)
        if not name:
            return Unknown(self.source(node))
        arguments, keywords = self.arguments(node)
        if name in self.functions and owner is None:
            return self.inside(self.functions[name], arguments, keywords, node)
        if name in self.classes and owner is None:
            return self.constructed(name, arguments, keywords, node)
        if isinstance(owner, Instance) and name in (methods := self.classes.get(owner.name, {})):
            return self.inside(methods[name], [owner, *arguments], keywords, node)
        known = self.computed(name, owner, arguments, keywords, node)
        if known is not NOT_COMPUTED:
            return known
        if name == "setattr" and owner is None and len(arguments) == 3 and isinstance(arguments[1], str):
            changed, attribute, value = arguments
            self.assigned(changed.text if isinstance(changed, Unknown) else changed, attribute, value, node)
            return None
        text = self.commented(node)
        instance = Instance(name, tuple(arguments), keywords, node.lineno, text)
        if isinstance(owner, Instance) and owner.name == "ArgumentParser":
            return parsed_argument(name, owner, instance)
        return self.called(name, owner, instance)

    def commented(self, node: ast.Call) -> str:
        """The text of a call, with the comment behind it that says for which ε it was corrected."""
        text = quoted("", node.lineno, self.source(node)).text
        end = node.end_lineno or 0
        wanted = WANTED.search(self.lines[end - 1]) if 0 < end <= len(self.lines) else None
        return text if wanted is None else f"{text}  {wanted[0].rstrip()}"

    def callee(self, node: ast.expr) -> tuple[Any, str]:
        """What stands before the dot of a function, and the function's name; empty if it has none."""
        match node:
            case ast.Name(name):
                alias = self.names.get(name)
                if not isinstance(alias, Unknown) or not DOTTED.fullmatch(alias.text):
                    return None, name
                owner, _, name = alias.text.rpartition(".")
                return owner or None, name
            case ast.Attribute(before, name):
                return self.owner(before), name
        self.value(node)
        return None, ""

    def arguments(self, node: ast.Call) -> tuple[list[Any], dict[str, Any]]:
        """The values of the arguments of a call; ``**`` stands for keywords that are not known."""
        arguments: list[Any] = []
        for part in node.args:
            value = self.value(part.value if isinstance(part, ast.Starred) else part)
            arguments += (
                list(value) if isinstance(part, ast.Starred) and isinstance(value, list | tuple) else [value]
            )
        keywords: dict[str, Any] = {}
        for word in node.keywords:
            value = self.value(word.value)
            if word.arg is not None:
                keywords[word.arg] = value
            elif isinstance(value, dict):
                keywords |= {str(key): item for key, item in value.items()}
            else:
                keywords["**"] = value
        return arguments, keywords

    def computed(
        self, name: str, owner: Any, arguments: list[Any], keywords: dict[str, Any], node: ast.Call
    ) -> Any:
        """The value of a function of numbers, lists or dictionaries; ``NOT_COMPUTED`` if it is none."""
        arithmetic = owner is None or (isinstance(owner, str) and owner in self.modules)
        if name in ("Vector3", "Vector2", "Vector6") and len(arguments) > 1:
            return Vector(arguments)
        if name == "Vector3" and len(arguments) == 1 and isinstance(arguments[0], list | tuple):
            return Vector(arguments[0])
        if (
            name in ("range", "xrange")
            and arithmetic
            and all(isinstance(argument, int) for argument in arguments)
        ):
            return range(*arguments)
        if name in LISTS and owner is None and not keywords and name not in self.names:
            short = all(
                isinstance(argument, list | tuple | range | str | int) and count(argument) <= MAX_ITEMS
                for argument in arguments
            )
            return LISTS[name](*arguments) if short else Unknown(self.source(node))
        if (
            name == "product"
            and (owner == "itertools" or (owner is None and len(arguments) > 1))
            and not keywords
        ):
            known = all(isinstance(argument, list | tuple | range | str) for argument in arguments)
            short = known and math.prod(map(count, arguments)) <= MAX_ITEMS
            return list(itertools.product(*arguments)) if short else Unknown(self.source(node))
        if name == "dict" and owner is None and not arguments and "**" not in keywords:
            return keywords
        if isinstance(owner, dict) and name in ("items", "keys", "values", "get"):
            result = getattr(owner, name)(*arguments)
            return result if name == "get" else list(result)
        if name == "linspace" and arithmetic and keywords.keys() <= {"num", "endpoint"}:
            arguments, keywords = (
                [*arguments, *[keywords[key] for key in ("num",) if key in keywords]],
                {
                    key: value
                    for key, value in keywords.items()
                    if key == "endpoint" and value not in (True, 1)
                },
            )
        if name in FUNCTIONS and arithmetic and not keywords and name not in self.names:
            kinds = (Unknown, Instance) if name in OF_TEXTS else (Unknown, Instance, str)
            unknown = any(isinstance(argument, kinds) for argument in flat(arguments))
            return Unknown(self.source(node)) if unknown else FUNCTIONS[name](*arguments)
        return NOT_COMPUTED

    def constructed(
        self, name: str, arguments: list[Any], keywords: Mapping[str, Any], node: ast.Call
    ) -> Instance:
        """An object of one of the script's own classes."""
        common = self.names.get(name)
        attributes = dict(common.attributes) if isinstance(common, Instance) else {}
        instance = Instance(name, tuple(arguments), attributes, node.lineno, self.source(node))
        if "__init__" in self.classes[name]:
            self.inside(self.classes[name]["__init__"], [instance, *arguments], keywords, node)
        return instance

    def default_values(self, parameters: ast.arguments) -> dict[str, Any]:
        """The values of the arguments that a function has by default, when it is defined."""
        places = [*parameters.posonlyargs, *parameters.args]
        pairs = [
            *zip(places[len(places) - len(parameters.defaults) :], parameters.defaults, strict=True),
            *zip(parameters.kwonlyargs, parameters.kw_defaults, strict=True),
        ]
        return {argument.arg: self.value(value) for argument, value in pairs if value is not None}

    def inside(
        self, function: ast.FunctionDef, arguments: list[Any], keywords: Mapping[str, Any], node: ast.Call
    ) -> Any:
        """Run one of the script's own functions."""
        if self.depth >= DEEPEST:
            return Unknown(self.source(node))
        parameters = function.args
        places = [parameter.arg for parameter in [*parameters.posonlyargs, *parameters.args]]
        local = {
            name: Unknown(name) for name in [*places, *(parameter.arg for parameter in parameters.kwonlyargs)]
        }
        local |= self.defaults[function]
        self.executed.add(function)
        self.entered.add(function)
        local |= dict(zip(places, arguments, strict=False)) | dict(keywords)
        outside, self.depth = self.names, self.depth + 1
        changed = {name for node in ast.walk(function) if isinstance(node, ast.Global) for name in node.names}
        self.names = {**outside, **local}
        try:
            self.block(function.body)
            result = None
        except Return as ended:
            result = ended.args[0]
        finally:
            inside, self.names, self.depth = self.names, outside, self.depth - 1
        self.names |= {name: inside[name] for name in changed if name in inside}
        return result


def parsed_argument(name: str, parser: Instance, instance: Instance) -> Any:
    """A method of ``argparse.ArgumentParser``: arguments have their defaults."""
    if name == "add_argument":
        flags = [argument for argument in instance.arguments if isinstance(argument, str)]
        long = next((flag for flag in flags if flag.startswith("--")), flags[0] if flags else "")
        target = instance.attributes.get("dest", long.lstrip("-").replace("-", "_"))
        default = False if instance.attributes.get("action") == "store_true" else Unknown(instance.text)
        parser.made.append((target, instance.attributes.get("default", default)))
    elif name == "parse_args":
        return Instance("Namespace", (), dict(parser.made), instance.line, instance.text)
    return Unknown(instance.text)


def count(value: Any) -> int:
    """The length of a list, or 0."""
    return 0 if isinstance(value, int) else len(value)


def spaced(first: float, last: float, step: float = 1) -> list[float]:
    """Numbers of ``numpy.arange``, at most ``MAX_ITEMS``."""
    number = math.ceil((last - first) / step)
    if number > MAX_ITEMS:
        raise ValueError
    return [first + k * step for k in range(number)]


def flat(values: Iterable[Any]) -> list[Any]:
    """Values of nested lists."""
    return [
        item for value in values for item in (flat(value) if isinstance(value, list | tuple) else [value])
    ]
