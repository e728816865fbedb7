"""What the documentation shows is true: sessions of Python and of the shell give the outputs that stand there.

```pycon blocks of a page are one doctest, ```console blocks are commands after ``$ `` with what they print. ``...``
stands for anything, and the end of a line for any blanks.
"""

import doctest
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import TWO_BALL_TABLES, columns_json, table

DOCS = Path(__file__).resolve().parents[1] / "docs"
OPTIONS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


def blocks(page: Path, kind: str) -> list[str]:
    return re.findall(
        rf"^```{kind}\n(.*?)^```$", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE
    )


def commands(session: str) -> list[tuple[str, str]]:
    """Pairs of a command, its continued lines joined, and what it prints."""
    parts = re.split(r"^\$ ", session.replace("\\\n", ""), flags=re.MULTILINE)
    assert parts[0] == "", "a console session begins with a command"
    return [(command, output) for command, _, output in (part.partition("\n") for part in parts[1:])]


def obtained(command: str, folder: Path) -> str:
    """What a ``hardlimit`` command prints on a screen of 80 columns; ``> FILE`` at its end is heeded."""
    words, _, target = command.partition(" > ")
    program, *arguments = shlex.split(words)
    assert program == "hardlimit", command
    ran = subprocess.run(
        [sys.executable, "-m", "hardlimit", *arguments],
        capture_output=True,
        cwd=folder,
        encoding="utf-8",
        env={**os.environ, "COLUMNS": "80", "PYTHONUTF8": "1"},
    )
    assert ran.returncode == 0, f"{command}: {ran.stderr}"
    if target:
        (folder / target).write_text(ran.stdout, encoding="utf-8")
        return ""
    return ran.stdout


def difference(wanted: str, got: str) -> str:
    """Empty if what was printed is what stands in the page."""
    example = doctest.Example("", wanted)
    checker = doctest.OutputChecker()
    if checker.check_output(wanted, got, OPTIONS):
        return ""
    return checker.output_difference(example, got, OPTIONS)


PAGES = [page for page in sorted(DOCS.glob("*.md")) if blocks(page, "pycon") or blocks(page, "console")]


def test_an_untrue_page_is_found(tmp_path: Path) -> None:
    assert difference("0.7182\n", "0.7183\n") and not difference("0.71...\n", "0.7183\n")
    assert commands("$ a b \\\n  c\n1\n$ d\n") == [("a b   c", "1\n"), ("d", "")]


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_sessions(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    name = f"docs/{page.name}"
    test = doctest.DocTestParser().get_doctest("\n".join(blocks(page, "pycon")), {}, name, name, 0)
    report: list[str] = []
    result = doctest.DocTestRunner(verbose=False, optionflags=OPTIONS).run(test, out=report.append)
    assert result.failed == 0, "".join(report)
    for session in blocks(page, "console"):
        for command, output in commands(session):
            found = difference(output, obtained(command, tmp_path))
            assert not found, f"{command}\n{found}"


def test_validation_names_tests_and_counts_rows_that_exist() -> None:
    text = (DOCS / "validation.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`(test_\w+\.py)`", text))
    assert len(named) > 20 and [name for name in named if not (DOCS.parent / "tests" / name).exists()] == []
    rows = {name: len(table(name)) for name in (*TWO_BALL_TABLES, "two_ball_viscoelastic", "cradle")}
    stacks = len(table("stack_two_ball_touching")) + len(table("stack_full_stop"))
    assert f"{sum(rows[name] for name in TWO_BALL_TABLES)} reference columns" in text
    assert f"{rows['two_ball_viscoelastic']} reference columns" in text
    assert f"{len(columns_json())} reference columns" in text
    assert f"{rows['cradle']} reference rows" in text and f"{stacks} reference rows" in text
    assert f"{len(table('code_restitution'))} runs are data" in text
