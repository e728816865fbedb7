"""A local name is a noun of the thing."""

import ast
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
ROOMS = ("src", "tests", "tools", "docs", "benchmarks", "studies", "examples")
EMPTY = {"found", "one", "given", "made", "held", "asked"}  # they leave unsaid what each is


def empty_names(path: Path) -> set[str]:
    """Variables and parameters of a file with such a name; a field of a class is read behind the name of its object."""
    nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
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
