"""Progress of a long computation: a bar on stderr, lines in a log, or calls of the user's function."""

from __future__ import annotations

import threading
import time as clock
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import TYPE_CHECKING, Any

from . import formatting
from .validation import shown

if TYPE_CHECKING:
    from rich.console import Console

#: Time until the first line in a log, and longest time between two lines [s].
FIRST_INTERVAL, LONGEST_INTERVAL = 10.0, 600.0
#: Time until a computation without reports is shown, and between two changes of what is shown [s].
SILENT, SHOWN_EVERY = 1.0, 0.2

Report = Callable[[int, int], object]  #: called with (done, total)


def reporter(progress: bool | Report | None, title: str, rate: str) -> AbstractContextManager[Report]:
    """The function that takes reports, for the argument ``progress``: a bar for True, none for False and None.

    Raises a ValueError if ``progress`` is neither of these nor callable.
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


class Shown:
    """A ``Report`` that also shows a line of text, ``note``."""

    def __init__(self, tell: Callable[[int, int, str], object]) -> None:
        self.note = ""
        self._tell = tell

    def __call__(self, done: int, total: int) -> None:
        self._tell(done, total, self.note)


@contextmanager
def bar(title: str, rate: str | None = None, console: Console | None = None) -> Iterator[Shown]:
    """A progress bar on stderr, removed at the end; lines of a log if stderr is neither a terminal nor a notebook.

    ``rate`` is the unit that is counted; its number per second is shown beside the bar.
    """
    from rich import progress as rich
    from rich.console import Console, RenderableType
    from rich.text import Text

    out = Console(stderr=True, highlight=False) if console is None else console
    if not (out.is_terminal or out.is_jupyter):
        yield Shown(Lines(title, rate, out))
        return

    class Rate(rich.ProgressColumn):
        def render(self, task: Any) -> Text:
            speed = task.finished_speed or task.speed
            return Text(formatting.rate(speed, rate) if speed and rate else "", style="cyan")

    class WithNote(rich.Progress):
        note = ""

        def get_renderables(self) -> Iterator[RenderableType]:
            yield from super().get_renderables()
            if self.note:
                yield Text(self.note, style="cyan")

    columns: list[Any] = [rich.TextColumn("{task.description}"), rich.BarColumn(), rich.TaskProgressColumn()]
    columns += [*([Rate()] if rate else []), rich.TimeRemainingColumn()]
    with WithNote(*columns, console=out, transient=True) as shown_bar:
        task = shown_bar.add_task(title, total=None)

        def tell(done: int, total: int, note: str) -> None:
            shown_bar.note = note
            shown_bar.update(task, completed=done, total=total or None)

        yield Shown(tell)


@contextmanager
def waiting(title: str, console: Console | None = None) -> Iterator[None]:
    """Show from the second second on that a computation without reports is under way, and since when.

    A thread shows it; the computation must release the interpreter lock.
    """
    ended, begun = threading.Event(), clock.monotonic()

    def show() -> None:
        if ended.wait(SILENT):
            return
        with bar(title, console=console) as report:
            while not ended.wait(SHOWN_EVERY):
                report.note = f"{formatting.duration(clock.monotonic() - begun)}; Ctrl-C stops it"
                report(0, 0)

    thread = threading.Thread(target=show, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


class Lines:
    """Progress in a log: a line after ``FIRST_INTERVAL``, then at doubling intervals up to ``LONGEST_INTERVAL``."""

    def __init__(self, title: str, rate: str | None, out: Console) -> None:
        self._title, self._rate, self._out = title, rate, out
        self._start = clock.monotonic()
        self._last, self._next = (self._start, 0), FIRST_INTERVAL

    def __call__(self, done: int, total: int, note: str) -> None:
        now = clock.monotonic()
        elapsed = now - self._start
        if elapsed < self._next:
            return
        last_time, last_done = self._last
        parts = [f"{done / total:.0%}"] if total else []
        parts.append(f"after {formatting.duration(elapsed)}")
        if self._rate and now > last_time:
            parts.append(formatting.rate((done - last_done) / (now - last_time), self._rate))
        line = f"{self._title}: {', '.join(parts)}{f'; {note}' if note else ''}"
        self._out.print(line, soft_wrap=True, markup=False)
        self._last, self._next = (now, done), elapsed + min(elapsed, LONGEST_INTERVAL)
