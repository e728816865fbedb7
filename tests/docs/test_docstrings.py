"""Rules for the docstrings of the public interface, and a test that their examples are true.

Public is what ``docs/api`` shows: every name in ``hardlimit.__all__`` and the classes that these return, with all
their methods and properties except those marked ``:meta private:``. The rules, with no exceptions by name:

* Everything has a summary: one sentence at the start.
* A function, a method or a class that the user constructs describes its parameters under Parameters, in order and with
  their types. A parameter is described once: it may be left out if the method's class describes a parameter of that
  name, or if the docstring links to a function or class that does (``Other parameters as for :func:`newton```).
* A class that the user does not construct says which function returns it.
* A function with parameters, and a property that raises, says under Raises which errors the caller may see. It may
  leave this out if all its parameters are described elsewhere.
* A function that computes, and every docstring with a formula, cites an equation or a publication; a class may do so
  for its members. A function that takes a path reads or writes and computes nothing.
* The functions and classes in ``ENTRY_POINTS`` have an example. Others have one only where it teaches something.

A field is described beside it or under Parameters.
"""

import ast
import doctest
import inspect
import re
from collections.abc import Iterator
from dataclasses import dataclass, is_dataclass
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hardlimit as hl

PAGES = sorted((Path(__file__).resolve().parents[2] / "docs" / "api").glob("*.md"))
API = "\n".join(page.read_text(encoding="utf-8") for page in PAGES)
SECTIONS = ["Parameters", "Returns", "Raises", "Notes", "Examples"]
CITED = re.compile(r"\bEqs?\. ?[A-Z]?\d|\bFigs?\. ?\d|\bAppendix [A-Z]\b|\b(1[89]|20)\d\d\b")
FORMULA = re.compile(r"\S = \S|[√Σ∝]|\w²/")
FILES = {"path", "folder"}
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE | doctest.DONT_ACCEPT_TRUE_FOR_1
DRAWS = re.compile(r"\.(plot|animate)\(")
LINK = re.compile(r":(?:func|class|meth):`~?(?:hardlimit\.)?([\w.]+)`")
#: Where a reader starts. Each has an example.
ENTRY_POINTS = {
    *("Column", "newton", "compare", "sweep", "fit", "convert", "stack"),
    *("ParticleSystem", "event_driven", "molecular_dynamics", "fidelity"),
    *(law.__name__ for law in hl.LAWS.values()),
}


@dataclass
class Documented:
    """A public object, and the class it belongs to."""

    name: str
    item: Any
    owner: Any = None

    @cached_property
    def text(self) -> str:
        return inspect.getdoc(self.item) or ""

    @cached_property
    def sections(self) -> dict[str, str]:
        """Sections of the docstring by title; the first has the title ``""``."""
        parts = re.split(r"^(\w+)\n-{3,}\n", self.text, flags=re.M)
        return {"": parts[0], **dict(zip(parts[1::2], parts[2::2], strict=True))}

    @property
    def is_property(self) -> bool:
        return isinstance(self.item, property | cached_property)

    @property
    def source(self) -> str:
        function = (
            self.item.fget if isinstance(self.item, property) else getattr(self.item, "func", self.item)
        )
        return inspect.getsource(function)

    @property
    def parameters(self) -> list[str]:
        """Parameters of a function, a method, or a class that the user constructs."""
        if self.is_property or (isinstance(self.item, type) and "Parameters" not in self.sections):
            return []
        names = [] if inspect.ismodule(self.item) else inspect.signature(self.item).parameters
        return [name for name in names if name not in ("self", "cls")]

    @property
    def examples(self) -> list[doctest.Example]:
        return doctest.DocTestParser().get_examples(self.text)


def shown(name: str) -> Any:
    module, _, last = name.rpartition(".")
    return getattr(import_module(module), last) if module else getattr(hl, last)


def members(name: str, owner: type) -> Iterator[Documented]:
    """Public methods and properties, including those inherited from a class that is not shown itself."""
    bases = [
        b for b in owner.__mro__ if (b.__module__.startswith("hardlimit") and b not in SHOWN) or b is owner
    ]
    attributes: dict[str, Any] = {}
    for base in reversed(bases):
        attributes |= vars(base)
    for member, item in attributes.items():
        if member.startswith("_") or not (
            inspect.isroutine(item) or isinstance(item, property | cached_property)
        ):
            continue
        described = getattr(owner, member) if inspect.isroutine(item) else item
        documented = Documented(f"{name}.{member}", described, owner)
        if documented.is_property and not documented.text:
            inherited = [vars(base)[member] for base in owner.__mro__ if member in vars(base)]
            documented.text = next(filter(None, map(inspect.getdoc, inherited)), "")
        if ":meta private:" not in documented.text:
            yield documented


NAMES = re.findall(r"^\.\. auto(?:class|function):: ([\w.]+)", API, flags=re.M)
SHOWN = [shown(name) for name in NAMES]
TOP = [Documented("hardlimit", hl), *map(Documented, NAMES, SHOWN)]
MEMBERS = [
    member
    for documented in TOP
    if isinstance(documented.item, type)
    for member in members(documented.name, documented.item)
]
EVERY = [*TOP, *MEMBERS]


def test_all_names_are_shown():
    text = API
    assert [
        name for name in hl.__all__ if not re.search(rf"^\.\. (auto\w+|py:data):: {name}$", text, re.M)
    ] == []
    assert len(set(NAMES)) == len(NAMES) and len(MEMBERS) > 100


def test_summary():
    def bad() -> Iterator[str]:
        for documented in EVERY:
            summary = documented.text.split("\n\n")[0]
            if not re.match(r"\S.*[.?]$", summary, re.S):
                yield f"{documented.name}: {summary!r}"
            unknown = [title for title in documented.sections if title and title not in SECTIONS]
            order = [SECTIONS.index(title) for title in documented.sections if title in SECTIONS]
            if unknown or order != sorted(order):
                yield f"{documented.name}: sections {list(documented.sections)}"

    assert not (faults := list(bad())), "\n".join(faults)


def heads(documented: Documented) -> list[str]:
    """Lines such as ``radius : float [m]`` under Parameters."""
    return re.findall(r"^(\S.*)$", documented.sections.get("Parameters", ""), re.M)


def described(documented: Documented) -> list[str]:
    return [
        name.strip().lstrip("*") for head in heads(documented) for name in head.partition(" : ")[0].split(",")
    ]


def described_elsewhere(documented: Documented) -> set[str]:
    """Parameters that the class of a method, or what a docstring links to, describes."""
    by_name = {other.name: other for other in EVERY}
    links = [prefix + name for name in LINK.findall(documented.text) for prefix in ("", "hardlimit.")]
    linked = [by_name[name] for name in links if name in by_name]
    owner = [Documented("", documented.owner)] if documented.owner else []
    return {name for other in [*owner, *linked] for name in described(other)}


def test_parameters():
    def bad() -> Iterator[str]:
        for documented in EVERY:
            listed, left_out = described(documented), described_elsewhere(documented)
            if listed != [name for name in documented.parameters if name in listed or name not in left_out]:
                yield f"{documented.name}: takes {documented.parameters}, lists {listed}"
            for head in heads(documented):
                names, _, kind = head.partition(" : ")
                if not (kind or head.startswith("**")) or ("," in names and kind.count("[") > 1):
                    yield f"{documented.name}: {head}"

    assert not (faults := list(bad())), "\n".join(faults)


def test_makers():
    """A class that the user does not construct says which function returns it."""

    def bad() -> Iterator[str]:
        for documented in TOP:
            returned = isinstance(documented.item, type) and not documented.parameters
            if returned and not re.search(r"\b(made|returned)\s+by\b", documented.text, re.I):
                yield documented.name

    assert not (faults := list(bad())), "\n".join(faults)


def comments(owner: type) -> dict[str, str | None]:
    """Comment ``#:`` of each field of a class, as Sphinx reads it."""
    source = inspect.getsource(owner)
    lines = source.splitlines()
    comment_of = {}
    for node in ast.parse(source).body[0].body:
        if isinstance(node, ast.AnnAssign) and "ClassVar" not in ast.unparse(node.annotation):
            comment = re.search("#: (.*)", lines[node.end_lineno - 1])
            comment_of[node.target.id] = comment[1] if comment else None
    return comment_of


def test_fields():
    def bad() -> Iterator[str]:
        for documented in TOP:
            if not (is_dataclass(documented.item) or hasattr(documented.item, "_fields")):
                continue
            listed = documented.sections.get("Parameters", "")
            for name, comment in comments(documented.item).items():
                if comment is None and not re.search(rf"^[\w, ]*\b{name}\b", listed, re.M):
                    yield f"{documented.name}.{name}"

    assert not (faults := list(bad())), "\n".join(faults)


def test_raises():
    def bad() -> Iterator[str]:
        for documented in EVERY:
            raises = documented.is_property and re.search(r"raise (?!NotImplementedError)", documented.source)
            own = set(documented.parameters) - described_elsewhere(documented)
            if (own or raises) and "Raises" not in documented.sections:
                yield documented.name

    assert not (faults := list(bad())), "\n".join(faults)


def test_sources():
    def bad() -> Iterator[str]:
        for documented in EVERY:
            computes = (
                inspect.isfunction(documented.item)
                and not documented.owner
                and not FILES & set(documented.parameters)
            )
            prose = "\n".join(text for title, text in documented.sections.items() if title != "Examples")
            owners = inspect.getdoc(documented.owner) or "" if documented.owner else ""
            if (computes or FORMULA.search(prose)) and not CITED.search(prose + owners):
                yield documented.name

    assert not (faults := list(bad())), "\n".join(faults)


def test_entry_points_have_examples():
    assert [
        documented.name for documented in TOP if documented.name in ENTRY_POINTS and not documented.examples
    ] == []
    assert {documented.name for documented in TOP} >= ENTRY_POINTS


def cases() -> Iterator[Any]:
    """All docstrings with examples; those that draw take a second each and run with the slow tests."""
    for documented in EVERY:
        if documented.examples:
            draws = any(DRAWS.search(example.source) for example in documented.examples)
            yield pytest.param(documented, id=documented.name, marks=[pytest.mark.slow] if draws else [])


@pytest.mark.parametrize("documented", list(cases()))
def test_examples_are_true(documented, tmp_path, monkeypatch):
    """Each runs by itself in an empty folder, after ``import hardlimit as hl`` and ``import numpy as np``."""
    monkeypatch.chdir(tmp_path)
    report: list[str] = []
    test = doctest.DocTest(
        documented.examples, {"hl": hl, "np": np}, documented.name, documented.name, 0, documented.text
    )
    runner = doctest.DocTestRunner(optionflags=FLAGS)
    assert runner.run(test, out=report.append).failed == 0, "".join(report)
