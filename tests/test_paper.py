"""The paper's figures and statements: anchor values, verdicts, files and refusals."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import hardlimit as hl
from hardlimit import paper
from hardlimit.paper import density, drawing, figure4, figure5, figure6, misprints, sampling, statements
from hardlimit.paper.data import Data
from hardlimit.paper.setup import Setup

#: Statements that do not hold to the letter, by their beginning; all others do.
PARTLY = (
    "The same for every set of parameters",
    "The duration of a contact depends only weakly",
    "The adiabatic solution agrees perfectly",
    "The number of contacts grows with R1/R2",
    "ε_eff/ε falls with growing R1/R2",
    "For most parameters",
    "Only in that interval",
    "Viscoelastic spheres show the same structure",
)

POINTS_DRAWN = figure4.POINTS


@pytest.fixture(scope="module")
def data():
    """The figures at the paper's density, the maps of Fig. 4 coarser than the command draws them."""
    before, figure4.POINTS = figure4.POINTS, 120
    found = Data(Setup())
    for number in paper.FIGURES:
        found.figure(number)
    yield found
    figure4.POINTS = before


@pytest.fixture(scope="module")
def rows(data):
    return {row.statement: row for row in statements.rows(data, tuple(paper.FIGURES))}


def test_fig2_contact_times(data):
    fig = data.figure(2)
    begin = np.array([194.415, 387.902, 539.693, 695.097]) * 1e-6
    end = np.array([220.195, 414.417, 566.545, 721.035]) * 1e-6
    np.testing.assert_allclose(fig.begin, begin, rtol=0, atol=1e-9)
    np.testing.assert_allclose(fig.end, end, rtol=0, atol=1e-9)
    assert float(fig.t_floor_end) == pytest.approx(775.172e-6, abs=1e-9)
    assert float(fig.t_end) == pytest.approx(721.035e-6, abs=1e-9)
    assert float(fig.relative_velocity) == pytest.approx(0.171710897878, abs=1e-9)
    assert float(fig.separation_velocity) == pytest.approx(0.125464928, abs=1e-9)


def test_fig2_forces_repel_and_act_only_in_contact(data):
    fig = data.figure(2)
    t = fig.time.values
    assert (fig.force_floor >= 0).all() and (fig.force_balls >= 0).all()
    pairs = zip(fig.begin.values, fig.end.values, strict=True)
    touching = np.any([(t >= b) & (t <= e) for b, e in pairs], axis=0)
    assert np.all(fig.force_balls.values[~touching] == 0.0)
    assert np.all(fig.force_floor.values[t < 0.0] == 0.0)
    at_touch = float(fig.force_floor.sel(time=0.0, method="bfill"))
    assert at_touch > 5e3  # the dashpot force jumps


def test_fig3_spikes_and_rows(data):
    fig = data.figure(3)
    np.testing.assert_allclose(fig.spike.values[:2], [0.782, 0.667], atol=5e-4)
    assert int(fig.n_contacts.sel(restitution=1.0)) == 3
    assert int(fig.n_contacts.sel(restitution=0.7)) == 4
    between = 0.5 * (fig.restitution.values[1:] + fig.restitution.values[:-1])
    np.testing.assert_allclose(fig.restitution_adiabatic.values, between, atol=1e-12)
    i = int(np.argmin(np.abs(fig.restitution_outline.values - 0.7)))
    column = hl.Column.paper(restitution=float(fig.restitution_outline[i]))
    assert float(fig.outline_t_floor_end[i]) == hl.newton(column).t_floor_end


def test_fig3_jumps_are_located(data):
    fig = data.figure(3)
    counts = fig.outline_n_contacts.values
    x = fig.restitution_outline.values
    at = np.flatnonzero(np.diff(counts))
    assert at.size == 10
    assert np.all(np.diff(x)[at] <= 1e-9 * x[at + 1])
    assert np.all(np.abs(np.diff(counts)[at]) == 1)


def test_fig4_counts_are_those_of_single_drops(data):
    fig = data.figure(4)
    rng = np.random.default_rng(1)
    for i, j in rng.integers(0, fig.sizes["restitution"], (20, 2)):
        e, gap, ratio = float(fig.restitution[i]), float(fig.gap[j]), float(fig.radius_ratio[j])
        assert int(fig.n_contacts_over_gap[i, j]) == hl.newton(hl.Column.paper(e, gap=gap)).n_contacts
        column = hl.Column.paper(e, radius_ratio=ratio)
        assert int(fig.n_contacts_over_radius_ratio[i, j]) == hl.newton(column).n_contacts
    assert float(fig.marked_gap) == 1e-4 and float(fig.marked_radius_ratio) == 10.0
    assert fig.radius_ratio.min() < 1.0 < fig.radius_ratio.max()


def test_fig4_is_fine_enough_as_drawn():
    assert POINTS_DRAWN >= 400


def test_fig5_anchors(data):
    fig = data.figure(5)
    at = float(fig.restitution_ratio.interp(gap=5e-4))
    assert at == pytest.approx(0.641, abs=1e-3)
    assert float(fig.restitution_ratio[-1]) == pytest.approx(1.0009, abs=5e-5)
    assert int(fig.n_contacts.max()) == 12
    assert 1e-3 < figure5.safe_gap(fig) < 2.504e-3
    x, counts = fig.gap.values, fig.n_contacts.values
    jumps = np.flatnonzero(np.diff(counts))
    assert np.all(np.diff(x)[jumps] <= 1e-9 * x[jumps + 1])


def test_fig6_anchors(data):
    low, high, at, top = figure6.above_one(data.figure(6))
    assert low == 1.0
    assert high == pytest.approx(1.51, abs=0.005)
    assert at == pytest.approx(1.42, abs=0.006)
    assert top == pytest.approx(1.0020, abs=5e-5)


def test_fig7_and_fig8(data):
    fig = data.figure(7)
    assert int(fig.n_contacts.sel(restitution=1.0)) == 7
    assert int(fig.inset_n_contacts.sel(restitution_inset=1.0)) == 2
    assert float(fig.input_speed) == 3.0
    assert float(fig.impact_speed) == pytest.approx(math.sqrt(2 * 9.81 * 0.5), rel=1e-12)
    contact = Setup().viscoelastic(0.6).contacts[1]
    assert contact.restitution(3.0) == pytest.approx(0.6, abs=1e-11)
    assert int(data.figure(8).n_contacts[0]) == 7  # almost elastic: as Fig. 7 at ε = 1
    both = Setup().same_material(1e-5).contacts
    assert both[0].dissipative_time == both[1].dissipative_time == 1e-5


def test_refine_finds_several_jumps_between_two_points():
    edges = np.array([0.31, 0.3102, 0.77])
    count = lambda x: np.searchsorted(edges, x).astype(np.int64)  # noqa: E731
    x, n = sampling.refine(count, np.linspace(0.1, 1.0, 4))
    found = sampling.jumps(x, n)
    np.testing.assert_allclose([at for at, _, _ in found], edges, rtol=1e-8)


def test_maxima():
    assert sampling.maxima(np.array([1, 2, 2, 3, 2, 1])) == 1
    assert sampling.maxima(np.array([1, 2, 1, 1, 3, 3])) == 2
    assert sampling.maxima(np.array([1, 1])) == 1


def test_curves_break_where_the_count_changes():
    x, y = drawing.broken(np.array([1.0, 2.0, 3.0]), np.array([0.0, 5.0, 6.0]), np.array([2, 1, 1]))
    assert np.isnan(x[1]) and np.isnan(y[1]) and x.size == 4


def test_statements_at_the_papers_density(rows):
    assert len(rows) == len(statements.STATEMENTS)
    not_yes = {text: row.agrees for text, row in rows.items() if row.agrees != "yes"}
    assert all(agrees == "partly" for agrees in not_yes.values()), not_yes
    # How often the maximum over Δh is one interval depends on the grid of Fig. 4.
    ours = {text for text in not_yes if not text.startswith("For each ε")}
    assert len(ours) == len(PARTLY)
    assert all(text.startswith(PARTLY) for text in ours)


def test_statements_name_their_numbers(rows):
    numbers = {
        "3 contacts at": "3 contacts",
        "Spikes at": "0.7822, 0.6671",
        "One contact is necessary": "0.641",
        "Near R1 = R2": "1.0020 at 1.42",
        "At a large gap the floor": "2.504 mm",
        "From ε = 1 downwards": "3, 4, 5, 6, 7, 6, 5, 4, 3, 2, 1",
    }
    for beginning, number in numbers.items():
        (row,) = (row for text, row in rows.items() if text.startswith(beginning))
        assert number in row.result


def test_verdicts_follow_the_numbers():
    """With another density the stated facts fail, and the table says so."""
    other = Data(Setup(1140.0))
    table = {row.statement: row for row in statements.rows(other, (3, 6))}
    (spikes,) = (row for text, row in table.items() if text.startswith("Spikes"))
    assert spikes.agrees == "no" and "0.852" in spikes.result
    (single,) = (row for text, row in table.items() if text.startswith("From ε = 1"))
    assert single.agrees == "no"
    assert density.rows(Setup(1140.0), None)[0].agrees == "no"


def test_misprints_do_not_hold():
    found = misprints.rows(Setup())
    assert [row.agrees for row in found] == ["no"] * 5
    assert {row.kind for row in found} == {"misprint"}
    assert "2.9960 V; Eq. 5 says 2.9960 V" in found[0].result


def test_density_inference(monkeypatch):
    monkeypatch.setattr(density, "RANGE", (700.0, 1200.0))
    monkeypatch.setattr(density, "COARSE", 50.0)
    monkeypatch.setattr(density, "FINE", 5.0)
    scan = density.infer()
    held = scan.density.values[scan.holds.values == 1]
    assert (held[0], held[-1]) == (830.0, 850.0)
    found = density.rows(Setup(), scan)
    assert [row.agrees for row in found] == ["yes", "yes"]
    assert "840 ± 10" in found[1].result


def test_run_writes_what_it_says(tmp_path: Path, monkeypatch):
    monkeypatch.setattr(figure4, "POINTS", 24)
    seen: list[float] = []
    report = paper.run(tmp_path / "new" / "folder", progress=lambda part, text: seen.append(part))
    assert seen[0] == 0.0 and seen[-1] == 1.0 and seen == sorted(seen)
    assert {path.name for path in report.files} == {
        *(f"fig{n}.{ending}" for n in range(2, 9) for ending in ("png", "nc")),
        "report.md",
    }
    for number in range(2, 9):
        picture = (report.out / f"fig{number}.png").read_bytes()
        assert picture.startswith(b"\x89PNG") and len(picture) > 20_000
        with xr.open_dataset(report.out / f"fig{number}.nc", engine="h5netcdf") as ds:
            assert f"Fig. {number}" in ds.attrs["source_figure"]
            assert ds.attrs["hardlimit_version"] == hl.__version__
            assert json.loads(ds.attrs["parameters"])["density_kg_m3"] == 840.0
            assert ds.attrs["meaning"] == report.meanings[number]
            for variable in ds.variables.values():
                assert "units" in variable.attrs, variable.name
    page = (report.out / "report.md").read_text(encoding="utf-8")
    assert all(row.statement in page for row in report.rows)
    assert json.loads(json.dumps(report.to_dict()))["density"] == 840.0


def test_run_with_some_figures(tmp_path: Path):
    report = paper.run(tmp_path, figures="3, 2", format="svg", density=1000)
    names = {path.name for path in report.files}
    assert names == {"fig2.svg", "fig2.nc", "fig3.svg", "fig3.nc", "report.md"}
    assert not any("Fig. 5" in row.where for row in report.rows)
    assert report.density == 1000.0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"figures": "9"}, "figures: got '9', must be among 2, 3, 4, 5, 6, 7, 8"),
        ({"figures": "2,three"}, "figures: got 'three'"),
        ({"figures": [1]}, "figures: got '1'"),
        ({"figures": []}, "figures: got none"),
        ({"format": "bmp"}, "format: got 'bmp', must be one of png, pdf, svg"),
        ({"density": -1.0}, "density: got -1, must be > 0"),
        ({"density": math.nan}, "density: got nan"),
    ],
)
def test_bad_input_is_refused_in_one_line(tmp_path: Path, options, message):
    with pytest.raises(ValueError) as caught:
        paper.run(tmp_path / "out", **options)
    assert str(caught.value).startswith(message)
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "out").exists()


def test_a_path_that_cannot_be_written_is_refused(tmp_path: Path):
    file = tmp_path / "file"
    file.write_text("in the way")
    with pytest.raises(ValueError, match=r"^out: got '.*', must be a folder"):
        paper.run(file / "below")
