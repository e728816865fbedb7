"""What the commands share: how they fail, how they print, how they show progress."""

from __future__ import annotations

import json
import math
import os
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from ..column.files import law_parameters
from ..contact import Law
from ..laws import LAWS

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

F = TypeVar("F", bound=Callable[..., Any])

BAD_INPUT = 2
INTERRUPTED = 130


class Program(click.Group):
    """Ends with one line on stderr: exit code 2 for bad input, 130 for Ctrl-C, 1 for everything else."""

    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = None,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        **extra: Any,
    ) -> Any:
        run = partial(super().main, args, prog_name, complete_var, standalone_mode=False, **extra)
        if not standalone_mode:
            return run()
        try:
            code: Any = run()
        except click.Abort:
            click.echo("interrupted", err=True)
            sys.exit(INTERRUPTED)
        except click.ClickException as error:
            context = getattr(error, "ctx", None)
            complain(context.command_path if context else "hardlimit", error.format_message())
            sys.exit(error.exit_code)
        sys.exit(code if isinstance(code, int) else 0)


class Command(click.Command):
    """A command whose bad input, missing extras and failing disks end in one line, not in a traceback."""

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except BrokenPipeError:
            raise
        except ValueError as error:
            raise click.UsageError(str(error), ctx) from error
        except (ImportError, OSError, RuntimeError, MemoryError) as error:
            failure = click.ClickException(str(error) or type(error).__name__)
            failure.ctx = ctx  # type: ignore[attr-defined]
            raise failure from error


def complain(who: str, message: str) -> None:
    """One line on stderr."""
    click.echo(f"{who}: {' '.join(message.split())}", err=True)


class Number(click.ParamType[float]):
    """A number; its range is checked where its meaning is known."""

    name = "number"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        try:
            return float(value)
        except ValueError:
            self.fail(f"got {value!r}, must be a number", param, ctx)


NUMBER = Number()


def writable(option: str, path: str | None) -> Path | None:
    """The path, if a file can be written there; checked before anything is computed."""
    if path is None:
        return None
    target = Path(path)
    folder = target.parent
    if not folder.is_dir():
        raise ValueError(f"--{option}: got {path!r}, must be in an existing folder")
    if target.is_dir() or not os.access(target if target.exists() else folder, os.W_OK):
        raise ValueError(f"--{option}: got {path!r}, must be writable")
    return target


# --- laws as options ----------------------------------------------------------------------------------------


def all_law_parameters() -> dict[str, list[tuple[type[Law], dict[str, Any]]]]:
    """Every parameter of a registered law, with the laws that know it."""
    found: dict[str, list[tuple[type[Law], dict[str, Any]]]] = {}
    for law in LAWS.values():
        for name, record in law_parameters(law).items():
            found.setdefault(name, []).append((law, record))
    return found


def law_options(number: click.ParamType[Any] = NUMBER) -> Callable[[F], F]:
    """``--law`` and one option for each parameter of a registered law."""

    def decorate(function: F) -> F:
        for name, uses in reversed(list(all_law_parameters().items())):
            record = uses[0][1]
            laws = ", ".join(law.record["name"] for law, _ in uses)
            unit = f" [{record['unit']}]" if record["unit"] != "1" else ""
            meaning = record["meaning"].split(";")[0].split(",")[0]
            option = click.option(
                f"--{name.replace('_', '-')}", name, type=number, help=f"{meaning}{unit} ({laws})"
            )
            function = option(function)
        return click.option("--law", type=click.Choice(list(LAWS)), help="Contact law.")(function)

    return decorate


def given_law_parameters(options: dict[str, Any]) -> dict[str, Any]:
    """Takes the parameters of laws out of the options; those that were given."""
    taken = {name: options.pop(name) for name in all_law_parameters()}
    return {name: value for name, value in taken.items() if value is not None}


# --- printing -----------------------------------------------------------------------------------------------


def console(stderr: bool = False) -> Console:
    """Where to print: as wide as the terminal, 100 columns at most."""
    from rich.console import Console

    wide = Console(stderr=stderr, highlight=False)
    wide.width = min(wide.width, 100)
    return wide


def table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> Table:
    """A table with the first column to the left and numbers to the right."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    made = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False)
    for i, name in enumerate(columns):
        made.add_column(Text(name), justify="left" if i == 0 else "right", overflow="fold")
    for row in rows:
        made.add_row(*map(Text, row))
    return made


def show(out: Console, title: str, content: Table, below: str = "") -> None:
    """A table under its title, with a line below if given and a blank line after it."""
    from rich.text import Text

    out.print(Text(title, style="bold"))
    out.print(content)
    if below:
        out.print(Text(below))
    out.print()


def digits(value: float, significant: int = 6) -> str:
    """A number for a table; a dash where there is none."""
    if math.isnan(value):
        return "–"
    text = re.sub(r"e([+-])0*(\d+)$", lambda m: f"e{m[1].replace('+', '')}{m[2]}", f"{value:.{significant}g}")
    return f"−{text[1:]}" if text.startswith("-") else text


PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))


def quantity(value: float, unit: str, significant: int = 6) -> str:
    """A number with a prefixed unit, such as ``0.1 mm``; plain where no prefix fits."""
    if value == 0.0 or not math.isfinite(value):
        return f"{digits(value)} {unit}"
    for factor, prefix in PREFIXES:
        if abs(value) >= 0.9999999 * factor:
            return f"{digits(value / factor, significant)} {prefix}{unit}"
    return f"{digits(value, significant)} {unit}"


def length(metres: float) -> str:
    """A length in the unit people say: 60 cm, 1 cm, 0.1 mm, 3 µm."""
    for limit, factor, unit in ((1.0, 1.0, "m"), (5e-3, 1e-2, "cm"), (2e-5, 1e-3, "mm")):
        if abs(metres) >= limit:
            return f"{digits(metres / factor)} {unit}"
    return quantity(metres, "m") if metres else "0"


def print_json(content: Any) -> None:
    """JSON on stdout; what is not a finite number becomes null."""
    click.echo(json.dumps(plain(content), ensure_ascii=False, indent=2))


def plain(value: Any) -> Any:
    """Arrays as lists, NumPy scalars as numbers, NaN and infinity as None."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, dict):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return str(value) if isinstance(value, Path) else value


# --- progress -----------------------------------------------------------------------------------------------


@contextmanager
def fraction_progress(title: str) -> Iterator[Callable[[float, str], None]]:
    """A progress bar on stderr, fed with (part from 0 to 1, what is being done)."""
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    out = console(stderr=True)
    columns = (
        TextColumn("{task.description:24.24}"),
        BarColumn(),
        TaskProgressColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=out, transient=True, disable=not out.is_terminal) as bar:
        task = bar.add_task(title, total=1.0)
        yield lambda part, text: bar.update(task, completed=part, description=text)
