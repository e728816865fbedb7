"""Type stub of the compiled module: src/hardlimit/_core.pyi, written by nanobind from the installed package.

The stub is committed so that type checkers work from the source tree. After a change of the bindings:

    pip install . && python tools/stubs.py

With --check nothing is written; the exit code is 1 if the committed stub differs from what would be written.
"""

import argparse
import difflib
import subprocess
import sys
import tempfile
from pathlib import Path

STUB = Path(__file__).resolve().parents[1] / "src" / "hardlimit" / "_core.pyi"


def generated() -> str:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "_core.pyi"
        # Run elsewhere: the source tree must not be imported in place of the installed package.
        subprocess.run(
            [sys.executable, "-m", "nanobind.stubgen", "-q", "-m", "hardlimit._core", "-o", str(path)],
            check=True,
            cwd=folder,
        )
        return path.read_text(encoding="utf-8")


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--check", action="store_true", help="compare, write nothing")
    check = parser.parse_args().check
    new = generated()
    if not check:
        STUB.write_text(new, encoding="utf-8")
        return 0
    old = STUB.read_text(encoding="utf-8") if STUB.exists() else ""
    difference = list(
        difflib.unified_diff(old.splitlines(), new.splitlines(), "committed", "generated", lineterm="")
    )
    if difference:
        print(*difference, "The committed stub is out of date: run python tools/stubs.py", sep="\n")
    return 1 if difference else 0


if __name__ == "__main__":
    sys.exit(main())
