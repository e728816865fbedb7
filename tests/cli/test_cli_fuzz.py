"""Any file and any command line ends with exit code 0, or with 2 and one line on stderr, never with a traceback."""

import contextlib
import copy
import json
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from unittest import mock

import click
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

import hardlimit as hl
import hardlimit.cli.compare
import hardlimit.cli.gas_job  # reads the signatures of solvers, which the tests replace
from bad_values import TYPED, keys, tables, texts
from command_line import assert_words_of_the_command_line
from conftest import columns, draws, free_columns
from hardlimit.cli import COMMANDS, main
from hardlimit.column import files

EXAMPLES = sorted((Path(__file__).resolve().parents[2] / "examples").glob("*.toml"))


class Accepted(Exception):
    """Raised in place of the solvers: the input has passed every check."""


@contextlib.contextmanager
def without_solvers() -> Iterator[None]:
    refuse = mock.Mock(side_effect=Accepted)
    with (
        mock.patch("hardlimit.cli.drop.compare", refuse),
        mock.patch("hardlimit.cli.sweep.compute", refuse),
        mock.patch("hardlimit.explorer.server.serve", refuse),
        mock.patch("hardlimit.paper.run", refuse),
        mock.patch("hardlimit.cli.contact.draw", refuse),
        mock.patch("hardlimit.boxes.starts.positions", refuse),
        mock.patch("hardlimit.event_driven", refuse),
        mock.patch("hardlimit.molecular_dynamics", refuse),
        mock.patch("hardlimit.fidelity", refuse),
        mock.patch("hardlimit.cli.fit.fitted", refuse),
        mock.patch("hardlimit.cli.stack.best", refuse),
    ):
        yield


def one_line_or_success(*args: str) -> bool:
    """Whether it was accepted; a traceback, a second line or another exit code fails."""
    result = CliRunner().invoke(main, list(args), prog_name="hardlimit")
    if isinstance(result.exception, Accepted):
        return True
    if result.exit_code == 0:
        assert result.stderr == ""
        return True
    if not isinstance(result.exception, SystemExit):
        raise AssertionError(args) from result.exception
    assert result.exit_code == 2, result.stderr
    assert result.stdout == "" and len(result.stderr.splitlines()) == 1, result.stderr
    assert len(result.stderr) < 1000
    assert_words_of_the_command_line(result.stderr)
    return False


# --- files --------------------------------------------------------------------------------------------------


def places(content: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Every place in nested tables and lists."""
    inner = enumerate(content) if isinstance(content, list) else getattr(content, "items", tuple)()
    return [path, *(place for key, value in inner for place in places(value, (*path, key)))]


@st.composite
def spoiled(draw: st.DrawFn) -> dict[str, Any]:
    """An example with one to three things changed, left out, added or put elsewhere."""
    content = tomllib.loads(draw(st.sampled_from(EXAMPLES)).read_text(encoding="utf-8"))
    for _ in range(draw(st.integers(1, 3))):
        inner = [place for place in places(content) if place]
        if not inner:
            break
        *parents, last = draw(st.sampled_from(inner))
        at: Any = content
        for key in parents:
            at = at[key]
        change = draw(st.sampled_from(["replace", "remove", "add", "rename", "repeat"]))
        if change == "replace":
            at[last] = draw(tables)
        elif change == "remove":
            del at[last]
        elif isinstance(at, list):
            new = copy.deepcopy(at[last]) if change == "repeat" else draw(tables)
            at.insert(draw(st.integers(0, len(at))), new)
        elif change == "rename":
            at[draw(keys)] = at.pop(last)
        else:
            at[draw(keys)] = draw(tables)
    return content


files_of = st.sampled_from(["drop", "sweep", "gas"])


def of_examples(some: int, full: int) -> pytest.MarkDecorator:
    """Some examples with every test run, and with the slow ones all of them."""
    return pytest.mark.parametrize("examples", [some, pytest.param(full, marks=pytest.mark.slow)])


def check_tables(examples: int, tables: st.SearchStrategy[dict[str, Any]]) -> None:
    @settings(max_examples=examples)
    @given(tables, files_of)
    def check(content: dict[str, Any], command: str) -> None:
        with mock.patch("hardlimit.support.toml.read", lambda path: copy.deepcopy(content)):
            one_line_or_success(command, "file.toml")

    with without_solvers():
        check()


@of_examples(25, 400)
def test_spoiled_tables(examples: int) -> None:
    check_tables(examples, spoiled())


@of_examples(25, 150)
def test_arbitrary_tables(examples: int) -> None:
    check_tables(examples, st.dictionaries(keys, tables, max_size=6))


@of_examples(30, 300)
def test_spoiled_text(tmp_path: Path, examples: int) -> None:
    """Bytes of an example removed, repeated or replaced."""

    @settings(max_examples=examples)
    @given(st.data(), st.sampled_from(EXAMPLES), files_of)
    def check(data: st.DataObject, example: Path, command: str) -> None:
        content = example.read_bytes()
        for _ in range(data.draw(st.integers(1, 3))):
            first = data.draw(st.integers(0, len(content)))
            last = data.draw(st.integers(first, min(len(content), first + 40)))
            encoded = texts.map(lambda text: text.encode(errors="replace"))
            new = data.draw(st.one_of(st.binary(max_size=10), encoded))
            content = content[:first] + new + content[last:]
        path = tmp_path / "spoiled.toml"
        path.write_bytes(content)
        one_line_or_success(command, str(path))

    with without_solvers():
        check()


@draws(50)
@given(st.one_of(columns(), free_columns()))
def test_columns_are_accepted(tmp_path_factory: pytest.TempPathFactory, column: hl.Column) -> None:
    path = tmp_path_factory.getbasetemp() / "column.toml"
    files.write(column, path)
    with without_solvers():
        assert one_line_or_success("drop", str(path))


# --- command lines ------------------------------------------------------------------------------------------

#: Options that would write, or show help, whatever else is wrong.
SKIPPED = {"resume", "help", "open_browser"}


SPRING = ["--stiffness", "1e5", "--restitution", "0.5"]
GRAIN = ["--radius", "1mm", "--density", "2500"]
#: Beginnings with which a line passes the first checks.
BEGINNINGS = {
    "gas": [
        ["--stiffness", "1e-5", "--restitution", "0.9"],
        ["--engine", "steps", *SPRING],
        ["--law", "viscoelastic"],
        ["--shake", "1mm:9Hz"],
        ["--friction", "0.5", "--tangential-restitution", "0.3"],
        ["--friction", "0.5", *SPRING],
    ],
    "gas compare": [
        SPRING,
        ["--law", "tsuji"],
        [*SPRING, "--friction", "0.5"],
        ["--shake", "1mm:9Hz", "--boundary", "periodic"],
    ],
    "contact": [["--law", "tsuji"], ["--other-radius", "1mm"]],
    "convert": [[*GRAIN, "--restitution", "0.9"], [*GRAIN, *SPRING], [*GRAIN, "--code", "yade"]],
    "check": [
        [*GRAIN, *SPRING],
        [*GRAIN, "--law", "viscoelastic"],
        [*GRAIN, *SPRING, "--friction", "0.5"],
    ],
    "drop": [["--law", "viscoelastic"], ["--radius", "1"]],
    "sweep": [["--gap", "1um,2um"], ["--law", "viscoelastic", "--gap", "1um,2um"], ["--gap", "1:2:1000000"]],
}


@st.composite
def command_lines(draw: st.DrawFn) -> list[str]:
    name = draw(st.sampled_from([*COMMANDS, "gas compare"]))
    command = main.get_command(click.Context(main), name) or hardlimit.cli.compare.compare
    options = [p for p in command.params if isinstance(p, click.Option) and p.name not in SKIPPED]
    line = [*name.split(), *draw(st.sampled_from([[], *BEGINNINGS.get(name, [])]))]
    for _ in range(draw(st.integers(0, 6 if options else 0))):
        option = draw(st.sampled_from(options))
        line.append(option.opts[0])
        if not option.is_flag:
            line.append(draw(st.one_of(st.sampled_from(TYPED), texts, st.floats().map(repr))))
    if draw(st.booleans()):
        line += draw(st.lists(st.sampled_from([*map(str, EXAMPLES), *TYPED]), max_size=2))
    return line


@of_examples(60, 600)
def test_command_lines(tmp_path: Path, examples: int) -> None:
    @settings(max_examples=examples)
    @given(command_lines())
    def check(line: list[str]) -> None:
        one_line_or_success(*line)
        assert list(tmp_path.iterdir()) == []

    with contextlib.chdir(tmp_path), without_solvers():
        check()


def parsed(text: str) -> Any:
    """Strict JSON: NaN and Infinity are none."""
    return json.loads(text, parse_constant=pytest.fail)


@draws(30)
@given(st.one_of(columns(most=4), free_columns(most=4)))
def test_json_of_any_column(tmp_path_factory: pytest.TempPathFactory, column: hl.Column) -> None:
    path = tmp_path_factory.getbasetemp() / "column.toml"
    files.write(column, path)
    result = CliRunner().invoke(main, ["drop", str(path), "--json"])
    assert result.exit_code == 0, result.stderr
    output = parsed(result.stdout)
    assert len(output["models"]["newton"]["positions"]) == len(column.balls)
    table = CliRunner().invoke(main, ["drop", str(path)])
    assert table.exit_code == 0 and max(map(len, table.stdout.splitlines())) <= 100
