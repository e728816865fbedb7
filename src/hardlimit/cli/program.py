"""How a command ends: one line on stderr and an exit code, never a traceback."""

from __future__ import annotations

import contextlib
import difflib
import io
import os
import re
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from typing import Any, TextIO

import click
from click.core import ParameterSource

from ..contact.compression import CompressionWarning

#: What a message is about: a parameter, its place in a list, or several.
PARAMETER = re.compile(r"(\w+)((?:\[\d+\])*)")
SUBJECT = re.compile(rf"{PARAMETER.pattern}(?: \| {PARAMETER.pattern})*")

FAILURE = 1
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
        for stream in (sys.stdout, sys.stderr):
            if isinstance(stream, io.TextIOWrapper):
                stream.reconfigure(errors="replace")  # Greek letters and signs on a terminal without them
        with compression_told():
            code = ended(run)
        for stream in (sys.stdout, sys.stderr):
            give_up_if_full(stream)
        sys.exit(code)


class Command(click.Command):
    """A command whose bad input, missing extras and failing disks end in one line, not in a traceback."""

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except BrokenPipeError:
            raise
        except ValueError as error:
            raise click.UsageError(with_options(ctx, str(error)), ctx) from error
        except (ImportError, OSError, RuntimeError, MemoryError) as error:
            failure = click.ClickException(reason(error))
            failure.ctx = ctx  # type: ignore[attr-defined]
            raise failure from error


def with_options(ctx: click.Context, message: str) -> str:
    """The message with the options of the command in place of the parameters that it is about.

    ``n: got 1`` is then ``--balls: got 1``. What may stand in a file keeps its name there unless it was typed.
    """
    subject, colon, rest = message.partition(": ")
    if not SUBJECT.fullmatch(subject):
        return message
    known: dict[str, click.Parameter] = {}
    for param in ctx.command.params:
        if isinstance(param, click.Option):
            known |= dict.fromkeys((param.name or "", param.opts[0].lstrip("-").replace("-", "_")), param)
    about = [known[name] for name, _ in PARAMETER.findall(subject) if name in known]
    typed = any(ctx.get_parameter_source(p.name or "") is ParameterSource.COMMANDLINE for p in about)
    if ctx.params.get("file") is not None and not typed:
        return message

    def option(found: re.Match[str]) -> str:
        name, place = found.groups()
        if name not in known:
            return found[0]
        given = ctx.params.get(known[name].name or "")
        return known[name].opts[0] + (place if isinstance(given, tuple) and len(given) > 1 else "")

    return PARAMETER.sub(option, subject) + colon + rest


def no_such_command(ctx: click.Context, name: str, commands: Iterable[str]) -> click.UsageError:
    """What is said of a command that there is not, with the nearest one."""
    near = difflib.get_close_matches(name, commands, 1)
    suggestion = f" Did you mean {near[0]!r}?" if near else ""
    return click.UsageError(f"No such command {name!r}.{suggestion}", ctx)


def reason(error: Exception) -> str:
    """What went wrong, in words without numbers; the system names no file if it was standard output."""
    if isinstance(error, OSError) and error.strerror and error.filename is None:
        return f"output: cannot be written: {error.strerror}"
    if isinstance(error, OSError) and error.strerror and isinstance(error.filename, str):
        return f"{error.filename}: {error.strerror}"
    return str(error) or type(error).__name__


def ended(run: Callable[[], Any]) -> int:
    """The exit code of a run; what went wrong is said on stderr."""
    try:
        code = run()
        if sys.stdout is not None:
            sys.stdout.flush()
    except click.Abort:
        complain("interrupted")
        return INTERRUPTED
    except click.ClickException as error:
        context = getattr(error, "ctx", None)
        complain(f"{context.command_path if context else 'hardlimit'}: {error.format_message()}")
        return error.exit_code
    except OSError as error:
        complain(f"hardlimit: {reason(error)}")
        return FAILURE
    return code if isinstance(code, int) else 0


@contextlib.contextmanager
def compression_told() -> Iterator[None]:
    """Contacts that are deep are told in one line on stderr, without a place in the code."""
    usual = warnings.showwarning

    def show(
        message: Warning | str, category: type[Warning], filename: str, lineno: int, *rest: Any, **more: Any
    ) -> None:
        if issubclass(category, CompressionWarning):
            complain(f"warning: {message}")
        else:
            usual(message, category, filename, lineno, *rest, **more)

    with warnings.catch_warnings():
        warnings.showwarning = show
        yield


def complain(message: str) -> None:
    """One line on stderr, if that can be written."""
    with contextlib.suppress(OSError):
        click.echo(" ".join(message.split()), err=True)


def give_up_if_full(stream: TextIO | None) -> None:
    """What is left for a full device goes nowhere: Python would try again at its end, and complain."""
    if stream is None:
        return
    try:
        stream.flush()
    except OSError:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
