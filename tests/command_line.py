"""The command line called from tests: what it prints, and the line with which it refuses bad input."""

import json

from click.testing import CliRunner, Result

from hardlimit.cli import main


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
    return lines[0]


def printed(*args: object) -> dict:
    return json.loads(run(*args, "--json").stdout)
