"""A local name is a noun of the thing."""

import ast
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
ROOMS = ("src", "tests", "tools", "docs", "benchmarks", "studies", "examples")
EMPTY = {"found", "one", "given", "made", "held", "asked"}  # they leave unsaid what each is
#: Where such a name may be bound: after these and before those. Few files have any, and only they are parsed.
BOUND = re.compile(
    r"(?:^[ \t]*|[-,(\[{*=:;+]\s*|\b(?:for|as|lambda|case)\s+)"
    rf"(?:{'|'.join(EMPTY)})\b\s*(?:[^\w\s.(\"'`;]|in\b)",
    re.MULTILINE,
)


def empty_names(path: Path) -> set[str]:
    """Variables and parameters of a file with such a name; a field of a class is read behind the name of its object."""
    text = path.read_text(encoding="utf-8")
    nodes = list(ast.walk(ast.parse(text))) if BOUND.search(text) else []
    fields = {
        id(n.target)
        for c in nodes
        if isinstance(c, ast.ClassDef)
        for n in c.body
        if isinstance(n, ast.AnnAssign)
    }
    variables = {
        n.id
        for n in nodes
        if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store) and id(n) not in fields
    }
    return EMPTY & (variables | {n.arg for n in nodes if isinstance(n, ast.arg)})


def test_no_variable_or_parameter_has_an_empty_name() -> None:
    files = [path for room in ROOMS for path in (ROOT / room).rglob("*.py")]
    assert len(files) > 300
    assert not {str(path.relative_to(ROOT)): names for path in files if (names := empty_names(path))}
