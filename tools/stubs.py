"""Write the type stubs: _core.pyi from the compiled module (nanobind), laws.pyi from the records of the laws, and
__init__.pyi from __init__.py. Type checkers cannot see the laws, which are made at run time.

The stubs are committed, so that type checkers work from the source tree. After a change of bindings or laws:

    pip install . && python tools/stubs.py

With --check nothing is written; the exit code is 1 if a committed stub is out of date.
"""

import argparse
import ast
import difflib
import subprocess
import sys
import tempfile
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1] / "src" / "hardlimit"


def core_stub() -> str:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "_core.pyi"
        # Run in another folder, so that the installed package is imported and not the source tree.
        subprocess.run(
            [sys.executable, "-m", "nanobind.stubgen", "-q", "-m", "hardlimit._core", "-o", str(path)],
            check=True,
            cwd=folder,
        )
        return path.read_text(encoding="utf-8")


def laws_stub() -> str:
    from hardlimit import _core

    records = _core.law_records()
    names = ["LAWS", *(record["class_name"] for record in records)]
    lines = ["# Written by tools/stubs.py from the laws' records.", "", "from .contact import Law"]
    lines += ["from .friction import Friction", ""]
    lines += [f"__all__ = {names!r}".replace("'", '"'), "", "LAWS: dict[str, type[Law]]", ""]
    for record in records:
        common = [p["name"] for p in record["common"]]
        chosen = list(dict.fromkeys(p["name"] for c in record["alternatives"] for p in c))
        arguments = [
            "self",
            "*",
            *(f"{n}: float" for n in common),
            *(f"{n}: float | None = None" for n in chosen),
            "friction: Friction | None = None",
        ]
        lines += [f"class {record['class_name']}(Law):"]
        lines += ["    def __init__(", *(f"        {a}," for a in arguments), "    ) -> None: ..."]
        lines += [f"    {name}: float" for name in [*common, *chosen]]
        lines += [""]
    return "\n".join(lines)


def package_stub() -> str:
    """Every public name with its type: the immediate and lazy imports of __init__.py, and the laws by name."""
    from hardlimit import _core

    source = ast.parse((PACKAGE / "__init__.py").read_text(encoding="utf-8"))
    laws = ["LAWS", *(record["class_name"] for record in _core.law_records())]
    lines = ["# Written by tools/stubs.py from __init__.py and the laws' records.", ""]
    for node in source.body:
        if isinstance(node, ast.ImportFrom) and node.level and node.module:
            names = [alias.name for alias in node.names if not (alias.asname or alias.name).startswith("_")]
            names = [name for name in laws if name not in names] if names == ["*"] else names
            lines += [f"from .{node.module} import {name} as {name}" for name in names]
        elif isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "_LATER":
            later = ast.literal_eval(node.value)
            lines += [f"from .{module} import {name} as {name}" for module in later for name in later[module]]
        elif isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "_MODULES":
            modules = ast.literal_eval(node.value)
            lines += [f"from .{modules[name].rstrip('.')} import {name} as {name}" for name in modules]
        elif isinstance(node, ast.AnnAssign):
            lines.append(f"{ast.unparse(node.target)}: {ast.unparse(node.annotation)}")
    return "\n".join(dict.fromkeys(lines)) + "\n"


STUBS = {"_core.pyi": core_stub, "contact/laws.pyi": laws_stub, "__init__.pyi": package_stub}


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--check", action="store_true", help="compare, write nothing")
    check = parser.parse_args().check
    stale = False
    for name, make in STUBS.items():
        path, new = PACKAGE / name, make()
        if not check:
            path.write_text(new, encoding="utf-8")
            continue
        old = path.read_text(encoding="utf-8") if path.exists() else ""
        labels = (f"committed {name}", f"generated {name}")
        difference = list(difflib.unified_diff(old.splitlines(), new.splitlines(), *labels, lineterm=""))
        if difference:
            print(*difference, "A committed stub is out of date: run python tools/stubs.py", sep="\n")
            stale = True
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main())
