"""Progress bars on stderr, for anything that takes longer than a second."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from .printing import console, quantity


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


@contextmanager
def progress(title: str, rate: str | None = None) -> Iterator[Callable[[int, int], None]]:
    """A progress bar on stderr, fed with (done, total); nothing where stderr is not a terminal."""
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
            return Text(f"{quantity(speed, rate or '', 3)}/s" if speed else "", style="cyan")

    out = console(stderr=True)
    columns: list[Any] = [TextColumn("{task.description}"), BarColumn(), TaskProgressColumn()]
    columns += [Rate()] if rate else []
    columns += [TimeRemainingColumn()]
    with Progress(*columns, console=out, transient=True, disable=not out.is_terminal) as bar:
        task = bar.add_task(title, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)
