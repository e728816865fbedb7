"""Progress: a bar on stderr for True, the caller's own function, or nothing."""

import io

import pytest
from rich.console import Console

import hardlimit as hl
from hardlimit.progress import bar, reporter

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


def test_nothing_where_nobody_looks():
    out = io.StringIO()
    with bar("sweep", "points", Console(file=out)) as report:
        report(1, 1)
    assert out.getvalue() == ""


@pytest.mark.parametrize("given", [None, False, True])
def test_a_sweep_takes_it(given, capfd):
    """stderr is no terminal here, and stdout is never written to."""
    found = hl.sweep(PAPER, gap=[1e-4, 1e-3], progress=given)
    assert found.sizes == {"gap": 2}
    written = capfd.readouterr()
    assert written.out == written.err == ""


def test_a_function_of_the_caller():
    told = []
    hl.sweep(PAPER, gap=[1e-4, 1e-3], progress=lambda done, total: told.append((done, total)))
    assert told[0] == (0, 2) and told[-1] == (2, 2)
    with reporter(print, "sweep", "points") as report:
        assert report is print


@pytest.mark.parametrize("given", [0, 1, 3.5, "yes", [], print.__class__])
def test_everything_else_is_refused(given):
    with pytest.raises(ValueError, match=r"progress: got .*, must be True, False or callable with"):
        hl.sweep(PAPER, gap=[1e-4], progress=given)
