"""The scripts of docs/findings: a corner of the grid, stopped and gone on with, gives data and figures."""

import argparse
import importlib.util
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text
from PIL import Image

import hardlimit as hl
from hardlimit.plots.style import style
from legible import assert_legible, coloured

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "findings"


def script(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, FOLDER / f"{name}.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def grid(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """Two points, written elsewhere."""
    found = script("cooling_gas")
    small = {"TC_NU": (0.03, 0.1), "PACKING_FRACTION": (0.2,), "RESTITUTION": (0.9,), "COLLISIONS": 3}
    for name, value in (small | {"DATA": tmp_path / "data.nc", "IMAGES": tmp_path}).items():
        monkeypatch.setattr(found, name, value)
    return found


@pytest.mark.slow
def test_a_small_grid_from_compute_to_figures(
    grid: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = {"stores": tmp_path / "stores", "n": 40, "replicas": 3, "workers": 1, "scheduler": None}
    for part in ("1/2", "2/2"):
        grid.compute(argparse.Namespace(**given, part=part))
    grid.collect(argparse.Namespace(**given))
    grid.draw(argparse.Namespace())
    ds = xr.open_dataset(grid.DATA)
    assert np.isfinite(ds.cooling).all() and ds.attrs["n"] == 40
    for quantity in ("cooling", "collision_rate", "pressure"):
        assert coloured(tmp_path / f"rules_{quantity}.png") > 1e-3
    assert_points_are_those_found(grid, ds)
    assert "| 0.2 | 0.9 |" in capsys.readouterr().out


def assert_points_are_those_found(findings: ModuleType, ds: xr.Dataset) -> None:
    """For each rule one point at each t_c ν, at the difference in per cent; what lies outside of the axes too."""
    (ax,) = findings.differences(ds, "cooling").axes
    rings = [line for line in ax.lines if line.get_markerfacecolor() == "white"]
    assert len(rings) == len(findings.RULES) > 1
    for line, rule in zip(rings, findings.RULES, strict=True):
        size = 100.0 * np.abs(findings.difference(ds, "cooling", rule).value[:, 0, 0])
        np.testing.assert_allclose(line.get_ydata(), size)
        np.testing.assert_allclose(line.get_xdata(), ds.tc_nu, rtol=0.13)


@pytest.mark.slow
def test_what_was_found_can_be_drawn_again() -> None:
    """From the data beside the script: every difference has an error bar, unless the rule collapsed."""
    findings = script("cooling_gas")
    ds = xr.open_dataset(findings.DATA)
    assert_legible(findings.differences(ds, "cooling"))
    for rule in findings.RULES:
        found = findings.difference(ds, "cooling", rule)
        assert (np.isfinite(found.value) == np.isfinite(found.error)).all()


def test_a_limit_is_kept_surely_or_lost_surely() -> None:
    """Differences of 0.1, 0.9, 2 and 30 % with errors of 0.1 %: what is within 0.2 % of 1 % is neither."""
    findings = script("cooling_gas")
    noise = np.array([-1.0, 1.0]) * 1e-3
    values = np.array([1.001, 1.009, 1.02, 1.3])[:, None] + noise
    both = np.stack([np.ones_like(values), values], axis=1)[:, None, None]
    ds = xr.Dataset(
        {"cooling": (("tc_nu", "packing_fraction", "restitution", "model", "replica"), both)},
        {"tc_nu": [0.001, 0.01, 0.1, 0.3], "model": ["newton", "soft"]},
    )
    for limit, expected in (
        (0.01, (0.001, 0.1)),
        (0.1, (0.1, 0.3)),
        (1e-5, (0.0, 0.01)),
        (1.0, (0.3, np.inf)),
    ):
        held, lost = findings.trusted(ds, "cooling", "soft", limit)
        assert (held.item(), lost.item()) == expected


@pytest.fixture
def small_law(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The script of the law of the error with one gas of spheres and one of disks, written elsewhere."""
    found = script("error_law")
    small = {
        "N": 200,
        "RELAXATION": 5,
        "TC_NU": {3: {0.2: (0.1,)}, 2: {0.4: (0.1,)}},
        "RESTITUTION": {3: (0.9,), 2: (0.8,)},
        "VISCOELASTIC": {3: {0.2: (0.1,)}, 2: {}},
        "VISCOELASTIC_RESTITUTION": (0.8,),
    }
    for name, value in (small | {"DATA": tmp_path / "data.nc", "IMAGES": tmp_path}).items():
        monkeypatch.setattr(found, name, value)
    return found


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::hardlimit.CompressionWarning")
def test_the_law_of_the_error_from_measurement_to_figures(
    small_law: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    store = tmp_path / "runs.jsonl"
    for replicas in (3, 4, 4):  # stopped and resumed
        small_law.measure(argparse.Namespace(store=store, replicas=replicas))
    assert len(store.read_text().splitlines()) == 3 * 4 * 4
    small_law.collect(argparse.Namespace(store=store))
    small_law.draw(argparse.Namespace())
    ds = small_law.opened()
    assert ds.sizes == {"point": 3, "model": 4, "replica": 4}
    assert np.isfinite(ds.duration.sel(model="newton")).all()
    assert "law: χ² = " in capsys.readouterr().out


@pytest.mark.slow
def test_the_law_of_the_error_agrees_with_its_data() -> None:
    """From the data beside the script: figures that can be read, and χ² of the law near the number of values."""
    found = script("error_law")
    ds = found.opened()
    for figure in (found.of_packing(ds), found.of_rules(ds)):
        assert_legible(figure)
    for line in found.agreement(ds).splitlines():
        chi, count = map(float, line.split(" = ")[1].replace(" values", "").split(" of "))
        assert chi < 1.3 * count > 50.0


@pytest.mark.slow
def test_stacks_and_oblique_drops_are_drawn(capsys: pytest.CaptureFixture[str]) -> None:
    """What the pictures of docs/stacks.md show, of fewer balls and points."""
    found = script("stacks")
    for figure, count in ((found.stacks([2, 3], 8), 4), (found.oblique(4), 2)):
        assert len(figure.axes) == count and all(ax.lines for ax in figure.axes)
        assert_legible(figure)
    assert "1 % of R1 gives 0.1029 m/s (estimate 0.1027)" in capsys.readouterr().out


@pytest.mark.slow
def test_the_fit_of_computed_bounces_finds_their_law() -> None:
    fitted = script("fits").impacts()
    assert fitted.trials[0].name == "viscoelastic" and fitted.probability > 0.01
    assert_legible(fitted.plot())


@pytest.mark.slow
def test_the_figures_of_the_validation_are_drawn(capsys: pytest.CaptureFixture[str]) -> None:
    """Of fewer rows and spheres; contacts are counted as in the tables, deviations are printed."""
    found = script("validation")
    for figure in (found.columns(40), found.contacts(20), found.grains(200)):
        assert_legible(figure)
    said = capsys.readouterr().out
    worst = {
        line.partition(":")[0]: float(line.split()[-2]) for line in said.splitlines() if line.endswith(" V")
    }
    assert len(worst) == 3 and max(worst.values()) < 1e-10


@pytest.mark.slow
def test_fig3_of_the_documentation_has_no_caption_of_its_own() -> None:
    """The pages write one below it."""
    figure = script("validation").fig3()
    shown = [text.get_text() for text in figure.findobj(Text)]
    assert any("coefficient of restitution" in text for text in shown)
    assert not figure.texts and not any("event-driven" in text or "Parameters" in text for text in shown)
    with Image.open(FOLDER.parent / "images" / "fig3.png") as picture:
        assert picture.size == tuple(round(200 * inches) for inches in figure.get_size_inches())
        kept = np.asarray(picture.convert("RGB"), dtype=int)
    with style():
        figure.dpi = 200
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
    drawn = np.asarray(canvas.buffer_rgba())[..., :3].astype(int)
    assert (np.abs(kept - drawn) > 60).mean() < 0.02  # another release of matplotlib may move a letter


def test_the_relation_for_ice_is_told_from_the_law() -> None:
    """The numbers of docs/fit.md."""
    found = script("fits").ice()
    assert found.verdict.startswith("viscoelastic cannot describe the data")
    assert found.chi_square == pytest.approx(466.0, abs=0.5) and found.degrees == 29
    speed = np.array([0.02, 0.5, 1.0, 2.0, 4.0])
    relation = 0.32 * speed**-0.234
    above = found.contact.restitution(1e-2 * speed) - relation
    assert above[0] == pytest.approx(-0.19, abs=5e-3) and above[-1] == pytest.approx(0.073, abs=5e-3)
    np.testing.assert_allclose((speed / 0.0077) ** -0.234, relation, rtol=2e-3)
    fast = np.geomspace(0.5, 5.0, 13)
    relation = 0.32 * fast**-0.234
    above = hl.fit(hl.Impacts.of_restitution(1e-2 * fast, relation, 0.02), "viscoelastic")
    assert np.max(np.abs(above.contact.restitution(1e-2 * fast) - relation)) == pytest.approx(0.022, abs=1e-3)
