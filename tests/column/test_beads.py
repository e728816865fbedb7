"""The statements of the figure in docs/beads.md, checked at a few points."""

import runpy
from pathlib import Path

import numpy as np
import pytest

import hardlimit as hl


@pytest.fixture(scope="module")
def beads():
    folder = Path(__file__).resolve().parents[2] / "studies"
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(folder)  # for driver
        return runpy.run_path(str(folder / "beads.py"))


@pytest.mark.parametrize("n", [2, 5, 10])
def test_collisions_collapse_where_theory_says(n, beads):
    critical = beads["critical"](n)
    bounces = [
        beads["bounce"](hl.independent(beads["column"](n, 1.0 - share * critical / n, 1.0), until=1e4))
        for share in (0.95, 1.05)
    ]
    assert bounces[0][0] > 0.0 and bounces[1] == (0.0, 0.0)


def test_beads_detach_where_collisions_collapse(beads):
    """At gaps of V t_c a third of the speed is returned, and the column expands."""
    for n in (5, 10):
        speed, expansion = beads["bounce"](hl.newton(beads["column"](n, 1.0 - 3.0 / n, 1.0), until=1e4))
        assert 0.25 < speed < 0.4 and expansion > 0.1
    few = [
        beads["bounce"](model(beads["column"](10, 0.97, 10.0), until=1e4))
        for model in (hl.newton, hl.independent)
    ]
    assert few[0] == pytest.approx(few[1], abs=0.01)


def test_the_figure_is_drawn(beads):
    (figure,) = beads["draw"]([2, 3], 4).values()
    drawn = [line for axes in figure.axes for line in axes.lines]
    assert len(figure.axes) == 4 and all(np.isfinite(line.get_ydata()).all() for line in drawn)
