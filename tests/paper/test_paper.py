"""Figures and statements of the paper: reference values, verdicts, files and refused input."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from PIL import Image

import hardlimit as hl
from conftest import refusal, slow
from hardlimit import paper
from hardlimit.paper import caption, density, drawing, figure4, figure5, figure6, sampling
from hardlimit.paper.misprints import MISPRINTS
from hardlimit.paper.registry import STATEMENTS
from hardlimit.paper.setup import Paper
from legible import assert_legible

#: Statements that do not hold to the letter, by their beginning; all others do.
PARTLY = (
    "The same for every set of parameters",
    "The duration of a contact depends only weakly",
    "The adiabatic solution agrees perfectly",
    "For each ε some interval",
    "The number of contacts grows with R1/R2",
    "ε_eff/ε falls with growing R1/R2",
    "For most parameters",
    "Only in that interval",
    "ε_eff/ε takes any value",
    "Viscoelastic spheres show the same structure",
)

POINTS_DRAWN = figure4.POINTS


@pytest.fixture(scope="module")
def data():
    """The figures at the paper's density, with coarser maps of Fig. 4 than those of the command. Figs. 2, 4, 5 and 6
    take little time; tests of the others and of all statements are slow."""
    before, figure4.POINTS = figure4.POINTS, 120
    yield Paper(modules=paper.FIGURES)  # computes a figure at its first use
    figure4.POINTS = before


@pytest.fixture(scope="module")
def rows(data):
    return {row.statement: row for row in STATEMENTS.rows(data, paper.FIGURES)}


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


@pytest.mark.slow
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


@pytest.mark.slow
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


@pytest.mark.slow
def test_fig7_and_fig8(data):
    fig = data.figure(7)
    assert int(fig.n_contacts.sel(restitution=1.0)) == 7
    assert int(fig.inset_n_contacts.sel(restitution_inset=1.0)) == 2
    assert float(fig.input_speed) == 3.0
    assert float(fig.impact_speed) == pytest.approx(math.sqrt(2 * 9.81 * 0.5), rel=1e-12)
    contact = Paper().viscoelastic(0.6).contacts[1]
    assert contact.restitution(3.0) == pytest.approx(0.6, abs=1e-11)
    assert int(data.figure(8).n_contacts[0]) == 7  # almost elastic: as Fig. 7 at ε = 1
    both = Paper().same_material(1e-5).contacts
    assert both[0].dissipative_time == both[1].dissipative_time == 1e-5


def test_refine_finds_several_jumps_between_two_points():
    edges = np.array([0.31, 0.3102, 0.77])
    count = lambda x: np.searchsorted(edges, x).astype(np.int64)  # noqa: E731
    x = sampling.refine(count, np.linspace(0.1, 1.0, 4))
    np.testing.assert_allclose(x[np.flatnonzero(np.diff(count(x)))], edges, rtol=1e-8)


def test_maxima():
    sequences = {(1, 2, 2, 3, 2, 1): 1, (1, 2, 1, 1, 3, 3): 2, (1, 1): 1}
    assert {counts: sampling.maxima(np.array(counts)) for counts in sequences} == sequences


def test_curves_break_where_the_count_changes():
    x, y = drawing.broken(np.array([1.0, 2.0, 3.0]), np.array([0.0, 5.0, 6.0]), np.array([2, 1, 1]))
    assert np.isnan(x[1]) and np.isnan(y[1]) and x.size == 4


@pytest.mark.slow
def test_statements_at_the_papers_density(rows):
    assert len(rows) == len(STATEMENTS)
    not_yes = {text: row.agrees for text, row in rows.items() if row.agrees != "yes"}
    assert all(agrees == "partly" for agrees in not_yes.values()), not_yes
    assert len(not_yes) == len(PARTLY)
    assert all(text.startswith(PARTLY) for text in not_yes)


@pytest.mark.slow
def test_statements_name_their_numbers(rows):
    numbers = {
        "3 contacts at": "3 contacts",
        "Spikes at": "0.7822, 0.6671",
        "One contact is necessary": "0.641",
        "Near R1 = R2": "ε = 0.8: above 1 from R1/R2 = 1.00 to 1.51, at most 1.0020 at 1.42",
        "The last contact may": "after it for 13.8 % of the ε from 0.1 to 1",
        "At a large gap the floor": "2.504 mm",
        "From ε = 1 downwards": "3, 4, 5, 6, 7, 6, 5, 4, 3, 2, 1",
    }
    for beginning, number in numbers.items():
        (row,) = (row for text, row in rows.items() if text.startswith(beginning))
        assert number in row.result


@pytest.mark.slow
def test_verdicts_follow_the_numbers():
    """With another density the stated facts do not hold, and the verdicts are ``no``."""
    other = Paper(1140.0, modules=paper.FIGURES)
    table = {row.statement: row for row in STATEMENTS.rows(other, (3, 6))}
    (spikes,) = (row for text, row in table.items() if text.startswith("Spikes"))
    assert spikes.agrees == "no" and "0.852" in spikes.result
    (single,) = (row for text, row in table.items() if text.startswith("From ε = 1"))
    assert single.agrees == "no"
    assert density.rows(Paper(1140.0), None)[0].agrees == "no"


def result_of(rows, beginning: str) -> str:
    (row,) = (row for text, row in rows.items() if text.startswith(beginning))
    return row.result


@pytest.mark.slow
def test_ranges_are_stated_where_they_were_taken(data, rows):
    """The table states that the range on the maps of Fig. 4 is much larger than in Figs. 5 and 6."""
    shown = result_of(rows, "ε_eff/ε takes any value")
    for n in (5, 6):
        values = data.figure(n)["restitution_ratio"].values
        assert f"Fig. {n} (ε = 0.{'98'[n - 5]}): {values.min():.1e} to {values.max():.4f}" in shown
    match = re.search(
        r"up to (\S+) on the upper and (\S+) on the lower one \(at ε = 0.05, R1/R2 = 0.23", shown
    )
    upper, lower = map(float, match.groups())
    assert lower > 5.0 > 1.05 > upper > 1.0
    # The ridge is narrower than the cells, so that the maximum on the map is lower.
    assert upper >= float(data.figure(4)["restitution_ratio_over_gap"].max()) - 1e-4
    assert lower >= float(data.figure(4)["restitution_ratio_over_radius_ratio"].max())
    assert hl.newton(hl.Column.paper(restitution=0.05, radius_ratio=1.05)).restitution_ratio > 1.16
    assert f"{lower:.2f}, at ε = 0.05" in result_of(rows, "Only in that interval")


# --- shares -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(30))
def test_a_fraction_does_not_depend_on_the_density_of_points(seed):
    rng = np.random.default_rng(seed)
    logarithmic = bool(seed % 2)
    low, high = (1e-7, 1e-2) if logarithmic else (-3.0, 5.0)
    spaced = np.geomspace if logarithmic else np.linspace
    a, b = np.sort(rng.uniform(0.0, 1.0, 2))
    start, stop = (low * (high / low) ** p if logarithmic else low + (high - low) * p for p in (a, b))
    crowd = rng.uniform(*sorted(rng.choice(spaced(low, high, 50), 2, replace=False)), 3000)
    for x in (spaced(low, high, 2001), np.unique(np.concatenate([spaced(low, high, 2001), crowd]))):
        fraction = sampling.fraction((x >= start) & (x <= stop), (x, logarithmic))
        assert fraction == pytest.approx(b - a, abs=1e-3)


def test_a_fraction_of_a_map_is_an_area():
    x, y = np.linspace(0.0, 1.0, 401) ** 3, np.geomspace(1.0, 100.0, 301)
    inside = (x[:, None] <= 0.5) & (y[None, :] <= 10.0)
    assert sampling.fraction(inside, (x, False), (y, True)) == pytest.approx(0.25, abs=0.01)
    assert np.mean(inside) > 0.35  # the share of points is different


def percents(text: str) -> list[float]:
    return [float(number) for number in re.findall(r"([\d.]+) %", text)]


class Crowded(Paper):
    """The figures with repeated points where the number of contacts does not change."""

    def __init__(self, other: Paper) -> None:
        super().__init__(other.density)
        for number in paper.FIGURES:
            self._figures[number] = self._crowd(other.figure(number))

    @staticmethod
    def _crowd(figure: xr.Dataset) -> xr.Dataset:
        for name in ("restitution", "restitution_outline", "gap", "radius_ratio"):
            if name in figure.indexes and figure.sizes[name] > 100:
                x = figure[name].values
                cell = len(x) // 3
                more = np.linspace(x[cell], 0.5 * (x[cell] + x[cell + 1]), 500, endpoint=False)[1:]
                figure = figure.reindex({name: np.sort(np.concatenate([x, more]))}, method="nearest")
        return figure


@pytest.mark.slow
def test_shares_of_all_statements_stay_when_points_are_added_elsewhere(data, rows):
    crowded = Crowded(data)
    compared = 0
    for statement in STATEMENTS:
        expected = percents(rows[statement.text].result)
        if not expected or not statement.figures:
            continue
        row = statement.row(crowded)
        assert percents(row.result) == pytest.approx(expected, abs=0.51), statement.text
        assert row.agrees == rows[statement.text].agrees
        compared += len(expected)
    assert compared >= 12
    row, expected = (percents(figure4.meaning(figures.figure(4))) for figures in (crowded, data))
    assert row == pytest.approx(expected, abs=0.51)


@pytest.mark.slow
def test_late_sequences_are_counted_as_on_a_uniform_grid(rows):
    epsilon = np.linspace(0.1, 1.0, 1801)
    sequence = sampling.sequences("x", epsilon, Paper().linear)
    late = float(np.mean(sequence["t_end"].values > sequence["t_floor_end"].values))
    assert percents(result_of(rows, "The last contact may")) == [pytest.approx(100 * late, abs=0.2)]


def test_middles_are_a_fair_sample():
    x = sampling.middles(2.0, 10.0, 8)
    np.testing.assert_allclose(x, np.arange(2.5, 10.0))
    y = sampling.middles(1.0, 1e4, 4, logarithmic=True)
    np.testing.assert_allclose(y, 10.0 ** np.arange(0.5, 4.0))


# --- pictures and report ------------------------------------------------------------------------------------


@pytest.mark.parametrize("number", [n if n == 2 else slow(n) for n in paper.FIGURES])
def test_figures_can_be_read(data, number):
    assert_legible(paper.draw(number, data.figure(number)))


@pytest.mark.parametrize(
    ("number", "named", "varied"),
    [
        (2, ("ε = 0.7", "Δh = 0.1 mm", "R1 = 10 cm", "R2 = 1 cm"), ()),
        slow(3, ("Δh = 0.1 mm", "R1 = 10 cm", "R2 = 1 cm"), ("ε",)),
        (4, ("R2 = 1 cm",), ("ε", "Δh", "R1")),
        (5, ("ε = 0.9", "R1 = 10 cm", "R2 = 1 cm"), ("Δh",)),
        (6, ("ε = 0.8", "Δh = 0.1 mm", "R2 = 1 cm"), ("R1",)),
        slow(7, ("v_in = 3 m/s", "Δh = 0.1 mm", "R2 = 2.5 mm", "Y = 5×10^7 N/m²", "ν = 0.45"), ("ε",)),
        slow(8, ("Δh = 0.1 mm", "R2 = 2.5 mm", "Y = 5×10^7 N/m²", "ν = 0.45"), ("A", "v_in")),
    ],
)
def test_figures_name_their_parameters(data, number, named, varied):
    line = caption.parameter_line(json.loads(data.figure(number).attrs["parameters"])).replace("\xa0", " ")
    stiffness = () if number > 6 else ("k = 5×10^7 N/m",)
    for part in (*named, *stiffness, "ρ = 840 kg/m³", "z1(0) = 0.6 m"):
        assert part in line
    assert not any(f"{name} =" in line for name in varied)
    first = caption.typeset(line).split(",")[0]
    figure = paper.draw(number, data.figure(number))
    assert any(first in text.get_text().replace("\xa0", " ") for text in figure.texts)


@pytest.mark.slow
def test_every_spike_of_fig3_is_named(data):
    figure = paper.draw(3, data.figure(3))
    shown = "".join(text.get_text() for text in figure.axes[0].texts)
    assert all(f"{tip:.3f}" in shown for tip in data.figure(3)["spike"].values)


@pytest.mark.slow
def test_the_report_lists_deviations_first(data, rows, tmp_path):
    report = paper.Report(tmp_path, 840.0, rows=[*rows.values(), *MISPRINTS.rows(Paper())])
    page = report.to_markdown()
    assert page.index("## Statements that do not agree") < page.index("## Statements that agree")
    assert page.index("| partly |") < page.index("| yes |") < page.index("| misprint |")
    assert "| verdict | statement | place in the paper | result |" in page
    assert "**partly**: agrees in part" in page
    assert report.summary() == "25 of 35 statements agree, 10 in part, 0 not; 5 misprints"


def test_misprints_do_not_hold():
    misprints = MISPRINTS.rows(Paper())
    assert [row.agrees for row in misprints] == ["misprint"] * 5
    assert {row.kind for row in misprints} == {"misprint"}
    assert "2.9960 V; Eq. 5 says 2.9960 V" in misprints[0].result


def test_density_inference(monkeypatch):
    monkeypatch.setattr(density, "RANGE", (700.0, 1200.0))
    monkeypatch.setattr(density, "COARSE", 50.0)
    monkeypatch.setattr(density, "FINE", 5.0)
    scan = density.infer()
    densities = scan.density.values[scan.holds.values == 1]
    assert (densities[0], densities[-1]) == (830.0, 850.0)
    facts = density.rows(Paper(), scan)
    assert [row.agrees for row in facts] == ["yes", "yes"]
    assert "840 ± 10" in facts[1].result


@pytest.mark.slow
def test_run_writes_what_it_says(tmp_path: Path, monkeypatch):
    monkeypatch.setattr(figure4, "POINTS", 24)
    seen: list[float] = []
    report = paper.run(tmp_path / "new" / "folder", dpi=80, progress=lambda part, text: seen.append(part))
    assert seen[0] == 0.0 and seen[-1] == 1.0 and seen == sorted(seen)
    assert {path.name for path in report.files} == {
        *(f"fig{n}.{ending}" for n in range(2, 9) for ending in ("png", "nc")),
        "report.md",
    }
    for number in range(2, 9):
        picture = (report.out / f"fig{number}.png").read_bytes()
        assert picture.startswith(b"\x89PNG") and len(picture) > 10_000
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


@pytest.mark.slow
def test_run_writes_pdf_and_any_resolution(tmp_path: Path):
    report = paper.run(tmp_path, figures="2", format="pdf", dpi=300)
    assert (report.out / "fig2.pdf").read_bytes().startswith(b"%PDF")
    wide = paper.run(tmp_path, figures="2", dpi=300)
    with Image.open(wide.out / "fig2.png") as picture:
        assert picture.info["dpi"][0] == pytest.approx(300, rel=1e-3)


@pytest.mark.slow
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
        ({"dpi": 5}, "dpi: got 5, must be"),
        ({"density": -1.0}, "density: got -1, must be > 0"),
        ({"density": math.nan}, "density: got nan"),
    ],
)
def test_bad_input_is_refused_in_one_line(tmp_path: Path, options, message):
    assert refusal(lambda: paper.run(tmp_path / "out", **options)).startswith(message)
    assert not (tmp_path / "out").exists()


def test_a_path_that_cannot_be_written_is_refused(tmp_path: Path):
    file = tmp_path / "file"
    file.write_text("in the way")
    with pytest.raises(ValueError, match=r"^out: got '.*', must be a folder"):
        paper.run(file / "below")
