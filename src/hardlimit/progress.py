"""How far a long computation has come: a bar on stderr, in a terminal or a notebook, or what the caller wants."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import TYPE_CHECKING, Any

from .validation import shown

if TYPE_CHECKING:
    from rich.console import Console

Report = Callable[[int, int], object]  #: called with (done, total)


def reporter(progress: bool | Report | None, title: str, rate: str) -> AbstractContextManager[Report]:
    """What to report to for the argument ``progress`` of a function: a bar for True, nothing for False and None.

    Raises
    ------
    ValueError
        If ``progress`` is neither of these nor callable.
    """
    if progress is None or progress is False:
        return nullcontext(lambda done, total: None)
    if progress is True:
        return bar(title, rate)
    if not callable(progress) or isinstance(progress, type):
        raise ValueError(
            f"progress: got {shown(progress)}, must be True, False or callable with (done, total)"
        )
    return nullcontext(progress)


@contextmanager
def bar(title: str, rate: str | None = None, console: Console | None = None) -> Iterator[Report]:
    """A progress bar on stderr that goes away at its end; nothing where stderr is neither terminal nor notebook.

    ``rate`` names what is counted: so many of them per second stand beside the bar.
    """
    from rich.console import Console
    from rich.filesize import pick_unit_and_suffix
    from rich.progress import (
        BarColumn,
        Progress,
        ProgressColumn,
        TaskProgressColumn,
        TextColumn,
        TimeRemainingColumn,
    )
    from rich.text import Text

    class Rate(ProgressColumn):
        def render(self, task: Any) -> Text:
            speed = task.finished_speed or task.speed
            unit, prefix = pick_unit_and_suffix(int(speed or 1), ["", "k", "M", "G"], 1000)
            return Text(f"{speed / unit:.3g} {prefix}{rate}/s" if speed else "", style="cyan")

    out = Console(stderr=True, highlight=False) if console is None else console
    columns: list[Any] = [TextColumn("{task.description}"), BarColumn(), TaskProgressColumn()]
    columns += [Rate()] if rate else []
    columns += [TimeRemainingColumn()]
    shows = out.is_terminal or out.is_jupyter
    with Progress(*columns, console=out, transient=True, disable=not shows) as shown_bar:
        task = shown_bar.add_task(title, total=None)
        yield lambda done, total: shown_bar.update(task, completed=done, total=total)
