"""Progress: a bar on stderr or lines in a log for True, a function of the caller, or nothing."""

import io
import math
import re
import threading

import pytest
from rich.console import Console

import hardlimit as hl
from hardlimit.boxes import pace, time_step
from hardlimit.support import formatting, progress
from hardlimit.support.progress import bar, reporter, waiting
from same_samples import same_samples

PAPER = hl.Column.paper()


def test_a_bar_in_a_terminal():
    out = io.StringIO()
    terminal = Console(file=out, force_terminal=True, width=100, color_system=None)
    with bar("sweep", "points", terminal) as report:
        report(0, 2_000_000)
        report(1_000_000, 2_000_000)
        report(2_000_000, 2_000_000)
    text = out.getvalue()
    assert "sweep" in text and "100%" in text and "points/s" in text


def test_no_bar_without_a_terminal():
    out = io.StringIO()
    with bar("sweep", "points", Console(file=out)) as report:
        report(1, 1)
    assert out.getvalue() == ""


@pytest.mark.parametrize("report", [None, False, True])
def test_progress_of_a_sweep(report, capfd):
    """stderr is not a terminal here, and nothing is written to stdout."""
    ds = hl.sweep(PAPER, gap=[1e-4, 1e-3], progress=report)
    assert ds.sizes == {"gap": 2}
    written = capfd.readouterr()
    assert written.out == written.err == ""


def test_a_function_of_the_caller():
    told = []
    hl.sweep(PAPER, gap=[1e-4, 1e-3], progress=lambda done, total: told.append((done, total)))
    assert told[0] == (0, 2) and told[-1] == (2, 2)
    with reporter(print, "sweep", "points") as report:
        assert report is print


@pytest.mark.parametrize("report", [0, 1, 3.5, "yes", [], print.__class__])
def test_other_arguments_are_refused(report):
    with pytest.raises(ValueError, match=r"progress: got .*, must be True, False or callable with"):
        hl.sweep(PAPER, gap=[1e-4], progress=report)


class Clock:
    """A clock that advances only when it is read, or on request."""

    def __init__(self, step: float = 0.0) -> None:
        self.now, self.step = 1000.0, step

    def monotonic(self) -> float:
        self.now += self.step
        return self.now


def test_lines_in_a_log(monkeypatch):
    """The first line after 10 s, then at growing intervals; rates are since the line before."""
    clock, out = Clock(), io.StringIO()
    monkeypatch.setattr(progress, "clock", clock)
    with bar("run", "contacts", Console(file=out, width=40)) as report:
        for second in range(100):
            report.note = f"note [{second}]"
            report(1000 * second, 200_000)
            clock.now += 1.0
    assert out.getvalue().splitlines() == [
        "run: 5%, after 10 s, 1 kcontacts/s; note [10]",
        "run: 10%, after 20 s, 1 kcontacts/s; note [20]",
        "run: 20%, after 40 s, 1 kcontacts/s; note [40]",
        "run: 40%, after 80 s, 1 kcontacts/s; note [80]",
    ]


def test_lines_without_a_rate_or_a_total(monkeypatch):
    clock, out = Clock(), io.StringIO()
    monkeypatch.setattr(progress, "clock", clock)
    with bar("film", console=Console(file=out)) as report:
        clock.now += 5000.0
        report(0, 0)
        report(1, 2)  # at once: the next one is due after ten minutes
        clock.now += 601.0
        report(1, 2)
    assert out.getvalue() == "film: after 83 min\nfilm: 50%, after 93 min\n"


def test_durations():
    texts = {
        0.0: "less than a second",
        1.4: "1 s",
        119.0: "119 s",
        120.0: "2 min",
        9000.0: "2 h",
        3e5: "3 days",
    }
    texts |= dict.fromkeys((1e300, math.inf, math.nan), "decades")
    assert {seconds: formatting.duration(seconds) for seconds in texts} == texts


def test_a_note_below_the_bar():
    out = io.StringIO()
    terminal = Console(file=out, force_terminal=True, width=100, color_system=None)
    with bar("run", "contacts", terminal) as report:
        report.note = "half of the time in clusters"
        report(1, 2)
    assert "half of the time in clusters" in out.getvalue()


def test_a_computation_without_reports_is_shown_after_a_second(monkeypatch):
    """And nothing is shown of a shorter one, nor after its end."""
    out = io.StringIO()
    terminal = Console(file=out, force_terminal=True, width=100, color_system=None)
    with waiting("drop", terminal):
        pass
    assert out.getvalue() == "" and progress.SILENT == 1.0
    monkeypatch.setattr(progress, "SILENT", 0.0)
    monkeypatch.setattr(progress, "SHOWN_EVERY", 1e-3)
    with pytest.raises(KeyboardInterrupt), waiting("drop", terminal):
        while "Ctrl-C stops it" not in out.getvalue():
            pass
        raise KeyboardInterrupt
    assert "drop" in out.getvalue() and "drop" not in [thread.name for thread in threading.enumerate()]


# --- of a run by events -------------------------------------------------------------------------------------

DISKS = hl.ParticleSystem.random(
    60, 0.3, 1e-3, 2500.0, rms_speed=0.1, dimension=2, boundary=["periodic", "wall"], gravity=9.81
)


def settle(engine, **options):
    law = hl.LinearDashpot(stiffness=1e4, restitution=0.5)
    return hl.molecular_dynamics(DISKS, law=law, until=0.05, engine=engine, samples=40, **options)


def test_a_run_by_events_logs_the_time_that_steps_would_take(monkeypatch, capfd):
    """300 settling disks once ran for 405 s without a message."""
    monkeypatch.setattr(progress, "clock", Clock(step=3.0))
    monkeypatch.setattr(pace, "clock", Clock(step=3.0))
    run = settle("events", progress=True)
    lines = capfd.readouterr().err.splitlines()
    form = (
        r"molecular dynamics: \d+%, after \S+ \S+, \S+ k?contacts/s; \d+% of the time in clusters; the rest "
        r"takes about [^,]+, the whole run by the engine steps about [^,]+( \(recommended\))?"
    )
    assert len(lines) >= 2 and all(re.fullmatch(form, line) for line in lines), lines
    assert same_samples(run, settle("events"))  # it changes no bit
    settle("steps", progress=True)
    lines = capfd.readouterr().err.splitlines()
    assert lines and all(
        re.fullmatch(r"molecular dynamics: \d+%, after \S+ \S+, \S+ k?steps/s", line) for line in lines
    )


def test_a_function_gets_only_numbers(monkeypatch):
    """And the engine of steps is not tried."""
    monkeypatch.setattr(pace, "seconds_by_steps", None)
    told = []
    run = settle("events", progress=lambda *seen: told.append(seen))
    assert told[-1][0] <= run.n_contacts and all(len(seen) == 2 and seen[0] <= seen[1] for seen in told)


class Run:
    """An engine at a time [s], of which bodies have spent this share in clusters."""

    def __init__(self) -> None:
        self.time, self.cluster_share = 0.0, 0.0


def test_the_note_is_about_the_last_seconds(monkeypatch):
    """Share in clusters and pace since the note before; steps are tried after 2, 2, 4, 8 … s."""
    clock, run, tried = Clock(), Run(), []
    monkeypatch.setattr(pace, "clock", clock)
    monkeypatch.setattr(pace, "seconds_by_steps", lambda *arguments: tried.append(clock.now) or 100.0)
    said = pace.ProgressNote()

    def note() -> str:
        return said.note(run.time, run.cluster_share, None, lambda: None, 10.0)

    assert note() == ""
    clock.now, run.time, run.cluster_share = clock.now + 2.0, 1.0, 0.5
    first = note()
    assert (
        first
        == "50% of the time in clusters; the rest takes about 18 s, the whole run by the engine steps about 100 s"
    )
    clock.now, run.time = clock.now + 1.0, 1.5
    assert note() == first  # not yet
    clock.now, run.time, run.cluster_share = clock.now + 9.0, 2.0, 0.75
    assert note() == (
        "100% of the time in clusters; the rest takes about 80 s, the whole run by the engine steps about 100 s"
    )
    clock.now, run.time = clock.now + 1000.0, 3.0
    assert "the rest takes about 117 min, " in note() and note().endswith("about 100 s (recommended)")
    clock.now += 2.0  # it hangs
    assert note().startswith("75% of the time in clusters; the rest takes about decades, ")
    assert [at - 1000.0 for at in tried] == [2.0, 12.0, 1012.0]


def test_the_time_that_steps_would_take_is_measured(monkeypatch):
    """Steps of the present state, so many that they are a small matter; the time for each of them is what counts."""
    clock = Clock(step=1.0)
    monkeypatch.setattr(pace, "clock", clock)
    law = hl.LinearDashpot(stiffness=1e4, restitution=0.5)
    step = time_step.chosen(DISKS, law, None, None)
    seconds = pace.seconds_by_steps(DISKS, law, 2.0)  # the trial takes one second on this clock
    assert seconds == pytest.approx(2.0 / step / pace.MAX_STEPS, rel=2e-3)
