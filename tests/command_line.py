"""The command line called from tests: what it prints, and the line with which it refuses bad input."""

import json
import re

import click
from click.testing import CliRunner, Result

from hardlimit.cli import main
from hardlimit.cli.compare import compare


def run(*args: object, code: int = 0) -> Result:
    result = CliRunner().invoke(main, [str(arg) for arg in args], prog_name="hardlimit")
    assert result.exit_code == code, result.output
    return result


def refused(*args: object) -> str:
    """The one line on stderr with which bad input ends."""
    result = run(*args, code=2)
    assert result.stdout == ""
    lines = result.stderr.splitlines()
    assert len(lines) == 1 and "Traceback" not in lines[0], result.stderr
    assert_words_of_the_command_line(lines[0])
    return lines[0]


#: What belongs to Python: a keyword argument, a module, a function that the command line calls otherwise.
OF_PYTHON = re.compile(r"(?<![\w-])[a-z]\w*=(?!=)|\bhl\.|molecular_dynamics")


def options_as_names(param: click.Parameter) -> list[str]:
    return [option.lstrip("-").replace("-", "_") for option in param.opts]


def assert_words_of_the_command_line(message: str) -> None:
    """No words of Python, and no options but those of the command's own ``--help``; what is in quotes was typed."""
    where, _, said = message.partition(": ")
    command: click.Command = main
    for name in where.split()[1:]:
        command = (
            command.get_command(click.Context(main), name) if isinstance(command, click.Group) else compare
        )
    known = {word for param in command.params for word in (*param.opts, *param.secondary_opts)} | {"--help"}
    said = re.sub(r"'[^']*'|\"[^\"]*\"", "", said)
    assert not OF_PYTHON.search(said), message
    names = {
        word for param in command.params for word in (param.name, *options_as_names(param)) if "_" in word
    }
    assert ".toml: " in message or names.isdisjoint(re.findall(r"\w+", said)), message  # a job has such keys
    assert known.issuperset(re.findall(r"(?<![\w-])--[a-z][a-z0-9-]*", said)), message


def printed(*args: object) -> dict:
    return json.loads(run(*args, "--json").stdout)
