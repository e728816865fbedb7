"""Error handling of commands: one line on stderr and an exit code, never a traceback."""

from __future__ import annotations

import contextlib
import difflib
import io
import math
import os
import re
import signal
import sys
import threading
import time as clock
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from types import FrameType
from typing import Any, TextIO

import click
from click.core import ParameterSource

from ..contact.laws import LAWS
from ..support import machine

#: A parameter in a message, such as ``gaps[1]``, and the one or more parameters with which a message begins.
PARAMETER = re.compile(r"(\w+)((?:\[\d+\])*)")
SUBJECT = re.compile(rf"{PARAMETER.pattern}(?:(?: \||,) {PARAMETER.pattern})*")
QUOTE = "'"
#: What a message may have of Python: an object, a keyword argument, and parameters by their names.
PYTHON = re.compile(
    r"(?P<object>[A-Z]\w*)\((?P<values>\w+=[^()]*)\)"
    r"|\b(?P<name>[a-z]\w*)=(?P<value>'[^']*'|[\w.+-]+)?"
    r"|'[^']*'"
    r"|\b(?P<words>[a-z]\w*(?: \+ [a-z]\w*)+|[a-z]+(?:_[a-z0-9]+)+)\b"
)
#: Names of the laws on the command line by their classes.
LAW_NAMES = {law.__name__: name for name, law in LAWS.items()}

FAILURE = 1
#: Schedulers may send a signal to all processes and through their parents: time in which it counts as one [s].
REPEATED = 1.0
#: Time after which a signal is tried again that comes while a destructor runs [s].
LATER = 0.01


class Program(click.Group):
    """A group whose commands end with exit code 2 for bad input, 1 for other errors, and 128 more than the number of a
    signal: 130 for Ctrl-C, 143 for SIGTERM."""

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
                stream.reconfigure(errors="replace")  # a terminal may lack Greek letters
        with own_warnings_in_one_line(), terminating_signals():
            code = exit_code(run)
        for stream in (sys.stdout, sys.stderr):
            discard_if_full(stream)
        sys.exit(code)


class Command(click.Command):
    """A command that reports bad input, missing extras and full disks in one line.

    ``aliases`` has what stands for a parameter of Python that is no option, such as ``{"path": "FILE"}``.
    """

    def __init__(self, *args: Any, aliases: Mapping[str, str] | None = None, **more: Any) -> None:
        super().__init__(*args, **more)
        self.aliases = dict(aliases or {})

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except (BrokenPipeError, click.exceptions.Exit, click.Abort):  # the last two are RuntimeErrors
            raise
        except (ValueError, ImportError, OSError, RuntimeError, MemoryError) as error:
            missing = isinstance(error, FileNotFoundError) and error.filename is None  # a file of the user
            if isinstance(error, ValueError) or missing:
                raise click.UsageError(with_options(ctx, str(error)), ctx) from error
            failure = click.ClickException(with_options(ctx, "; ".join([reason(error), *notes(error)])))
            failure.ctx = ctx  # type: ignore[attr-defined]
            raise failure from error


def with_options(ctx: click.Context, message: str) -> str:
    """The message in the words of the command line: ``--balls: got 1`` for ``n: got 1``.

    The parameters at its beginning and what the rest has of Python become options. If the command reads a job, only
    options that were typed are named. A hint about an argument that the command lacks is left out.
    """
    subject, colon, rest = message.partition(": ")
    if not SUBJECT.fullmatch(subject):
        subject, rest = (subject + colon, rest) if colon else ("", subject)
        return subject + in_words(rest, {} if colon and subject.endswith(".toml: ") else options_of(ctx))
    known = options_of(ctx)
    about = [known[name] for name, _ in PARAMETER.findall(subject) if name in known]
    sources = [ctx.get_parameter_source(p.name or "") for p in about if isinstance(p, click.Option)]
    typed = ParameterSource.COMMANDLINE in sources
    if str(ctx.params.get("file") or "").endswith(".toml") and not typed:
        known = {name: option for name, option in known.items() if isinstance(option, str)}

    def option(match: re.Match[str]) -> str:
        name, place = match.groups()
        if name not in known:
            return match[0]
        if isinstance(param := known[name], str):
            return param
        value = ctx.params.get(param.name or "")
        return param.opts[0] + (place if isinstance(value, tuple) and len(value) > 1 else "")

    options = " | ".join(dict.fromkeys(PARAMETER.sub(option, subject).split(" | ")))
    return options + colon + in_words(rest, known)


def in_options(text: str) -> str:
    """An outcome or a summary with options of the command in place of what it has of Python."""
    return in_words(text, options_of(click.get_current_context()))


def options_of(ctx: click.Context) -> dict[str, click.Option | str]:
    """The options of a command by the parameters of Python to which they belong, and its aliases."""
    known: dict[str, click.Option | str] = {}
    for param in ctx.command.params:
        if isinstance(param, click.Option):
            known |= dict.fromkeys((param.name or "", param.opts[0].lstrip("-").replace("-", "_")), param)
    return known | getattr(ctx.command, "aliases", {})


def in_words(text: str, known: Mapping[str, click.Option | str]) -> str:
    """The text with options in place of keyword arguments and objects of Python; what is in quotes stays."""

    def option(name: str, value: str | None = None) -> str:
        param = known.get(name)
        word = name if param is None else param if isinstance(param, str) else param.opts[0]
        flag = isinstance(param, click.Option) and param.is_flag
        return word if flag or not value else f"{word} {value.strip(QUOTE)}"

    def of_object(name: str, values: str) -> str:
        if name in LAW_NAMES:
            return " ".join([LAW_NAMES[name], *(option(*pair.split("=", 1)) for pair in values.split(", "))])
        return f"{name}: {values.replace('=', ' ')}"

    def replaced(match: re.Match[str]) -> str:
        if match["object"]:
            return of_object(match["object"], match["values"])
        if match["name"]:
            return option(match["name"], match["value"])
        if match["words"]:
            return " + ".join(option(name) for name in match["words"].split(" + "))
        return match[0]

    def is_missing(clause: str) -> bool:
        return any(m["name"] and m["name"] not in known for m in PYTHON.finditer(clause))

    first, *clauses = text.split("; ")
    kept = [first, *(clause for clause in clauses if not is_missing(clause))]
    return PYTHON.sub(replaced, "; ".join(kept))


def no_such_command(ctx: click.Context, name: str, commands: Iterable[str]) -> click.UsageError:
    """The error for an unknown command, with the most similar command if there is one."""
    near = difflib.get_close_matches(name, commands, 1)
    suggestion = f" Did you mean {near[0]!r}?" if near else ""
    return click.UsageError(f"No such command {name!r}.{suggestion}", ctx)


def reason(error: Exception) -> str:
    """The message of an error, without the number that the system gives it."""
    if isinstance(error, OSError) and error.strerror and error.filename is None:
        return f"output: cannot be written: {error.strerror}"  # standard output has no name
    if isinstance(error, OSError) and error.strerror and isinstance(error.filename, str):
        return f"{error.filename}: {error.strerror}"
    return str(error) or type(error).__name__


def write_files(
    *files: tuple[Path | None, Callable[[Path], object]],
) -> tuple[list[Path], list[Exception]]:
    """Write the files that are wanted at the end of a long computation; returns those that are written, and why others
    are not. The caller prints what it has computed, then raises the errors."""
    written, failures = list[Path](), list[Exception]()
    for path, write in files:
        if path is not None:
            try:
                write(path)
                written.append(path)
            except (OSError, RuntimeError, MemoryError) as error:
                failures.append(error)
    return written, failures


def raise_all(failures: Sequence[Exception]) -> None:
    """Raise errors as one."""
    if failures:
        raise OSError("; ".join(map(reason, failures)))


def exit_code(run: Callable[[], Any]) -> int:
    """The exit code of a run, whose error is printed on stderr."""
    try:
        code = run()
        if sys.stdout is not None:
            sys.stdout.flush()
    except click.Abort as abort:
        number = getattr(abort.__cause__, "number", signal.SIGINT)
        by = "" if number == signal.SIGINT else f" by {signal.Signals(number).name}"
        print_error(f"interrupted{by} {'; '.join(notes(abort.__cause__))}")
        return 128 + number
    except click.ClickException as error:
        context = getattr(error, "ctx", None)
        print_error(f"{context.command_path if context else 'hardlimit'}: {error.format_message()}")
        return error.exit_code
    except OSError as error:
        print_error(f"hardlimit: {reason(error)}")
        return FAILURE
    return code if isinstance(code, int) else 0


def notes(error: BaseException | None) -> list[str]:
    """What an error says in addition to its message: where a run stopped, what is kept, how it goes on."""
    return list(getattr(error, "__notes__", []))


@contextlib.contextmanager
def goes_on_from(store: Any, parts: str, command: str = "the same command") -> Iterator[None]:
    """Ctrl-C in the block says that the finished parts are in the store, if there is one."""
    try:
        yield
    except KeyboardInterrupt as error:
        if store is not None:
            error.add_note(f"({parts} that are finished are in {store}; {command} goes on)")
        raise


class Terminated(KeyboardInterrupt):
    """A signal that ends a job."""

    def __init__(self, number: int) -> None:
        super().__init__()
        self.number = number


@contextlib.contextmanager
def terminating_signals() -> Iterator[None]:
    """Raise :class:`Terminated` at the signals that end a job, unless they are ignored, as under nohup.

    These and Ctrl-C wait for destructors: Python drops what is raised in one.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    last = -math.inf

    def terminate(number: int, frame: FrameType | None) -> None:
        nonlocal last
        if _destroys(frame):
            threading.Timer(LATER, _signal_again, [number]).start()
            return
        if number == signal.SIGINT:
            raise KeyboardInterrupt
        before, last = last, clock.monotonic()
        if last - before > REPEATED:
            raise Terminated(number)

    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, *machine.TERMINATING)}
    default = {signal.SIGINT: signal.default_int_handler}
    replaced = {
        number: handler
        for number, handler in handlers.items()
        if handler == default.get(number, signal.SIG_DFL)
    }
    for number in replaced:
        signal.signal(number, terminate)
    try:
        yield
    finally:
        for number, handler in replaced.items():
            signal.signal(number, handler)


def _signal_again(number: int) -> None:
    if sys.platform == "win32":
        signal.raise_signal(number)
    else:  # the main thread, which may be waiting
        signal.pthread_kill(threading.main_thread().ident or 0, number)


def _destroys(frame: FrameType | None) -> bool:
    """Whether a destructor runs."""
    while frame is not None:
        if frame.f_code.co_name == "__del__":
            return True
        frame = frame.f_back
    return False


@contextlib.contextmanager
def own_warnings_in_one_line() -> Iterator[None]:
    """Print our warnings as one line on stderr, without the line of code."""
    default = warnings.showwarning

    def show(
        message: Warning | str, category: type[Warning], filename: str, lineno: int, *rest: Any, **more: Any
    ) -> None:
        if category.__module__.startswith(f"{__name__.partition('.')[0]}."):
            print_error(f"warning: {message}")
        else:
            default(message, category, filename, lineno, *rest, **more)

    with warnings.catch_warnings():
        warnings.showwarning = show
        yield


def print_error(message: str) -> None:
    """Print one line on stderr if that is possible."""
    with contextlib.suppress(OSError):
        click.echo(" ".join(message.split()), err=True)


def discard_if_full(stream: TextIO | None) -> None:
    """Discard output that a full device does not take; Python would try again at exit and print a traceback."""
    if stream is None:
        return
    try:
        stream.flush()
    except OSError:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
