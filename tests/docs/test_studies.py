"""The studies: a corner of the grid, stopped and resumed, gives data and figures; figures agree with the docs."""

import dataclasses
import importlib
import itertools
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text
from PIL import Image

import hardlimit as hl
from hardlimit.boxes.lammps import program
from hardlimit.checking import at_rest
from hardlimit.plots.style import style
from legible import assert_legible, coloured

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def study(monkeypatch: pytest.MonkeyPatch):
    """Import a study by its name."""
    monkeypatch.syspath_prepend(ROOT / "studies")
    return importlib.import_module


def small(script: ModuleType, folder: Path, monkeypatch: pytest.MonkeyPatch, **constants: object) -> None:
    """A study with a smaller grid and its data elsewhere."""
    file = str(folder / f"{script.__name__}.py")
    for name, value in (constants | {"STUDY": dataclasses.replace(script.STUDY, file=file)}).items():
        monkeypatch.setattr(script, name, value)


def carried_out(
    script: ModuleType, driver: ModuleType, folder: Path, replicas: tuple[int, ...]
) -> xr.Dataset:
    """Measured in two parts and resumed, collected and drawn."""
    stores = [folder / f"{part}.jsonl" for part in (1, 2)]
    for count in replicas:
        for part, store in enumerate(stores, 1):
            driver.measure(script.STUDY, store, count, f"{part}/2")
    driver.collect(script.STUDY, stores)
    driver.draw(script.STUDY, folder)
    runs = driver.runs_of(stores)
    assert len({str((run["point"], run["replica"])) for run in runs}) == len(runs)
    return xr.load_dataset(script.STUDY.data)


@pytest.mark.slow
def test_a_small_grid_from_runs_to_figures(study, tmp_path, monkeypatch, capsys) -> None:
    script = study("cooling_gas")
    small(script, tmp_path, monkeypatch, TC_NU=(0.03, 0.1), PACKING_FRACTION=(0.2,), RESTITUTION=(0.9,),
          COLLISIONS=3, N=40, REPLICAS=3)  # fmt: skip
    ds = carried_out(script, study("driver"), tmp_path, (1,))
    assert np.isfinite(ds.cooling).all() and ds.sizes["replica"] == 3
    for quantity in ("cooling", "collision_rate", "pressure"):
        assert coloured(tmp_path / f"rules_{quantity}.png") > 1e-3
    assert_points_are_those_measured(script, ds)
    assert "| 0.2 | 0.9 |" in capsys.readouterr().out


@pytest.mark.parametrize(
    "name",
    [
        "heated_gas",
        "sheared_gas",
        "driven_friction",
        "flow_map",
        "shaken_column",
        "dense_flow",
        "lasting_contacts",
    ],
)
def test_a_run_is_collected_at_its_point(name: str, study, tmp_path, monkeypatch) -> None:
    """Each run gives its number; one that holds for all levels of an axis stands at each of them."""
    script, driver = study(name), study("driver")
    numbers = itertools.count()
    small(script, tmp_path, monkeypatch)
    made_up = dataclasses.replace(
        script.STUDY, run=lambda point, replica: dict.fromkeys(script.STUDY.values, next(numbers))
    )
    driver.measure(made_up, tmp_path / "runs.jsonl", 1)
    driver.collect(made_up, [tmp_path / "runs.jsonl"])
    ds, kept = xr.load_dataset(made_up.data), xr.load_dataset(ROOT / "studies" / f"{name}.nc")
    assert (
        ds.isel(replica=0, missing_dims="ignore").sizes == kept.isel(replica=0, missing_dims="ignore").sizes
    )
    for k, point in enumerate(script.STUDY.points(0)):
        here = ds.sel({axis: x for axis, x in zip(script.STUDY.axes(), point, strict=True) if x is not None})
        assert all((here[value].values == k).all() for value in script.STUDY.values)


def test_runs_of_packings_are_collected_at_their_points(study, tmp_path, monkeypatch) -> None:
    """Each run gives its number: once for a bed or a shear, at all levels of a compression."""
    script, driver = study("packings"), study("driver")
    numbers = itertools.count()
    small(script, tmp_path, monkeypatch)
    made_up = dataclasses.replace(
        script.STUDY, run=lambda point, replica: dict.fromkeys(script.STUDY.values, float(next(numbers)))
    )
    driver.measure(made_up, tmp_path / "runs.jsonl", 2)
    driver.collect(made_up, [tmp_path / "runs.jsonl"])
    ds, kept = xr.load_dataset(made_up.data), xr.load_dataset(ROOT / "studies" / "packings.nc")
    assert {dim: n for dim, n in ds.sizes.items() if dim != "replica"} == {
        dim: n for dim, n in kept.sizes.items() if dim != "replica"
    }
    names = {"settled": ("law", "friction", "kappa"), "compressed": (), "sheared": ("fraction",)}
    for run in driver.runs_of([tmp_path / "runs.jsonl"]):
        test, *place = run["point"]
        at = dict(zip(names[test], place, strict=False)) | {"replica": run["replica"]}
        here = ds[f"{test}_overlap"].sel(at)
        assert (here == run["values"]["overlap"]).all()


@pytest.mark.slow
def test_packings_from_runs_to_values(study, monkeypatch) -> None:
    """A small bed, a fast compression and shear: pressure by weight, overlaps by the virial, frequencies."""
    script = study("packings")
    monkeypatch.setattr(script, "WIDTH", 4.2)
    monkeypatch.setattr(script, "LAYERS", (1.0, 1.0))
    monkeypatch.setattr(script, "SQUEEZE_RATE", 2e-4)
    monkeypatch.setattr(script, "LEVELS", (1e2, 1e3))
    monkeypatch.setattr(script, "SHEARED", {0.62: 5e-3})
    monkeypatch.setattr(script, "SHEARED_N", 150)
    monkeypatch.setattr(script, "STRAINS", (0.5, 0.5))
    bed = script.run(("settled", "linear", 0.5, 1e3), 0)
    assert 0.6 < bed["pressure"] / bed["vertical"] < 1.0 and bed["energy"] < 1e-2
    squeezed = script.run(("compressed", 0.5), 0)
    np.testing.assert_allclose(squeezed["pressure"], [1e-2, 1e-3], rtol=1e-3)
    sheared = script.run(("sheared", 0.62, 0.5), 0)
    assert 0.2 < sheared["stress_ratio"] < 0.6
    for values, stiffness in (
        (bed, bed["pressure"] / (1e3 * script.settled_weight())),
        ({name: value[0] for name, value in squeezed.items()}, 1e-2),
        (sheared, sheared["pressure"]),
    ):
        assert values["overlap"] == pytest.approx(
            2.0 * np.pi / (values["packing_fraction"] * values["coordination"]) * stiffness, rel=0.12
        )
        assert (
            2.0
            < values["frequency_0"]
            < values["frequency_29"]
            < values["frequency_50"]
            < values["frequency_100"]
        )


def test_the_layer_of_a_drum_is_found(study) -> None:
    """Of made-up grains: a surface at 30° over a layer of four diameters in which the velocity falls to zero."""
    script, random = study("drums"), np.random.default_rng(8)
    drum = script.DRUMS[1]
    bottom, rate, angle = 4.0, 0.3, np.radians(30.0)
    across = random.uniform(-drum.radius, drum.radius, (40, 3000, 2))
    top = np.sqrt(drum.radius**2 - drum.half_surface**2)
    places = across[(drum.radius > np.hypot(*across.T).T) & (across[..., 1] < -top)]
    number = int(drum.filling * np.pi * drum.radius**2 * script.WIDTH * script.BULK * script.DENSITY)
    places = places[: 40 * number].reshape(40, number, 2)
    depth = -top - places[..., 1]
    speed = np.where(depth < bottom, rate * (bottom - depth), -0.1)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    states = np.zeros((40, number, 6))
    states[..., :2], states[..., 3:5] = places @ turn, speed[..., None] * turn[0]
    layer = script.layer(drum, states)
    pressure = 0.5 * bottom * script.BULK * script.DENSITY * np.cos(angle)
    assert layer["angle"] == pytest.approx(30.0, abs=0.5)
    assert layer["depth"] == pytest.approx(bottom, abs=0.3)
    assert layer["shear_rate"] == pytest.approx(rate, rel=0.05)
    assert layer["inertial_number"] == pytest.approx(rate * np.sqrt(script.DENSITY / pressure), rel=0.08)
    carried = 0.5 * drum.rate * drum.half_surface**2
    assert layer["flux"] == pytest.approx(0.5 * rate * bottom**2 / carried, rel=0.1)


@pytest.mark.parametrize(
    ("name", "power", "used"),
    [
        ("packing_fraction", 1.0, at_rest.EXCESS["settled", True][0]),
        ("coordination", 0.5, at_rest.EXCESS["settled", True][1]),
    ],
)
def test_check_has_the_softness_of_the_measured_beds(study, name: str, power: float, used: float) -> None:
    script = study("packings")
    beds = script.beds(xr.load_dataset(ROOT / "studies" / "packings.nc"))
    (limit, slope), (_, error) = script.trend(beds, name, power)
    assert abs(slope / limit - used) <= max(error / limit, 0.05)


def test_check_has_the_overlaps_and_steps_of_the_measured_mixtures(study) -> None:
    """Within 6 % up to uniform radii of 1:3 and two sizes of 1:2; steps are safe, but for 4 % of equal grains."""
    script = study("mixtures")
    ds = xr.load_dataset(script.STUDY.data)
    for kind, names in script.LAWS.items():
        for name in names:
            for _, overlap, steps in script.compared(ds, name, kind):
                assert overlap == pytest.approx(1.0, abs=0.16 if name == "1:3, 20 % large" else 0.061)
                assert all((0.96 if name == "equal" else 1.0) <= step < 1.135 for step in steps)


@pytest.mark.slow
def test_a_mixture_from_its_start_to_values(study, monkeypatch) -> None:
    """A few grains: they come to rest in contact, and the values are finite."""
    script = study("mixtures")
    for name, value in {"N": 120, "UNTIL": 4.0, "BELOW": 1.0, "ABOVE": 1.0}.items():
        monkeypatch.setattr(script, name, value)
    values = script.run(("1:2", "linear"), 0)
    assert set(values) == set(script.VALUES) and np.isfinite(list(values.values())).all()
    assert 0.5 < values["packing_fraction"] < 0.7 and 3.0 < values["coordination"] < 7.0


@pytest.mark.slow
def test_a_cell_is_pressed_to_the_pressures_of_its_levels(study, monkeypatch) -> None:
    """Few grains; the mean overlap is that of the mean force, more contacts carry more."""
    try:
        program.find(1)
    except ImportError as missing:
        pytest.skip(str(missing))
    script = study("pressed_cells")
    monkeypatch.setattr(script, "N", 60)
    monkeypatch.setattr(script, "LEVELS", (1e3, 1e2))
    monkeypatch.setattr(script, "SOFT", ())
    monkeypatch.setattr(script, "PREPARATIONS", {"tried": script.Preparation(0.5, 1e-3, spread=0.1)})
    values = {name: np.array(value) for name, value in script.pressed(0.5, "tried", 0).items()}
    assert values["pressure"] * [1e3, 1e2] == pytest.approx(1.0, abs=0.02)
    carrying = values["packing_fraction"] * values["coordination"]
    assert values["overlap"] == pytest.approx(2.0 * np.pi * values["pressure"] / carrying, rel=0.06)
    assert (values["energy"] < script.QUIET).all() and carrying[1] > 1.1 * carrying[0]


def test_a_piston_presses_to_the_stresses_of_its_levels(study, monkeypatch) -> None:
    """Few grains, fast and soft; the mean overlap is that of the mean force, and stresses across are smaller."""
    script = study("pistons")
    monkeypatch.setattr(script, "LEVELS", (100.0, 10**1.5))
    monkeypatch.setattr(script, "STRAIN", 0.25)
    monkeypatch.setitem(script.WAYS, "tried", script.Way(rate=1e-3, side=4.5))
    values = {name: np.array(value) for name, value in script.pressed(0.5, "tried", 0).items()}
    assert values["axial"] * [100.0, 10**1.5] == pytest.approx(1.0, rel=0.03)
    carrying = values["packing_fraction"] * values["coordination"]
    assert values["overlap"] == pytest.approx(2.0 * np.pi * values["pressure"] / carrying, rel=0.1)
    assert ((values["pressure"] / values["axial"] > 0.5) & (values["pressure"] < 0.9 * values["axial"])).all()


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        "heated_gas",
        "sheared_gas",
        "flow_map",
        "shaken_column",
        "packings",
        "pressed_cells",
        "pistons",
        "mixtures",
        "dense_flow",
        "lasting_contacts",
    ],
)
def test_the_figure_is_drawn_from_the_data(name: str, study) -> None:
    script = study(name)
    ds = xr.load_dataset(script.STUDY.data)
    (figure,) = script.draw(ds).values()
    assert len(figure.axes) > 1 and all(ax.has_data() for ax in figure.axes)
    assert script.STUDY.tables is None or script.STUDY.tables(ds).count("\n") > 8


def assert_points_are_those_measured(script: ModuleType, ds: xr.Dataset) -> None:
    """For each rule one point at each t_c ν, at the difference in per cent; what lies outside of the axes too."""
    (ax,) = script.differences(ds, "cooling").axes
    rings = [line for line in ax.lines if line.get_markerfacecolor() == "white"]
    assert len(rings) == len(script.RULES) > 1
    for line, rule in zip(rings, script.RULES, strict=True):
        size = 100.0 * np.abs(script.difference(ds, "cooling", rule).value[:, 0, 0])
        np.testing.assert_allclose(line.get_ydata(), size)
        np.testing.assert_allclose(line.get_xdata(), ds.tc_nu, rtol=0.13)


@pytest.mark.slow
def test_the_grid_can_be_drawn_again(study) -> None:
    """From the data beside the script: every difference has an error bar, unless the rule collapsed."""
    script = study("cooling_gas")
    ds = xr.load_dataset(script.STUDY.data)
    assert_legible(script.differences(ds, "cooling"))
    for rule in script.RULES:
        error = script.difference(ds, "cooling", rule)
        assert (np.isfinite(error.value) == np.isfinite(error.error)).all()


def test_a_limit_is_kept_surely_or_lost_surely(study) -> None:
    """Differences of 0.1, 0.9, 2 and 30 % with errors of 0.1 %: what is within 0.2 % of 1 % is neither."""
    script = study("cooling_gas")
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
        ends = script.trusted(ds, "cooling", "soft", limit)
        assert tuple(end.item() for end in ends) == expected


@pytest.mark.slow
def test_the_law_of_the_error_from_measurement_to_figures(study, tmp_path, monkeypatch, capsys) -> None:
    """One gas of spheres and one of disks."""
    script = study("error_law")
    small(script, tmp_path, monkeypatch, N=200, RELAXATION=5, TC_NU={3: {0.2: (0.1,)}, 2: {0.4: (0.1,)}},
          RESTITUTION={3: (0.9,), 2: (0.8,)}, VISCOELASTIC={3: {0.2: (0.1,)}, 2: {}},
          VISCOELASTIC_RESTITUTION=(0.8,))  # fmt: skip
    ds = carried_out(script, study("driver"), tmp_path, (3, 4, 4))
    assert ds.sizes == {"point": 3, "model": 4, "replica": 4}
    assert np.isfinite(ds.duration).all()
    assert "law: χ² = " in capsys.readouterr().out


@pytest.mark.slow
def test_the_law_of_the_error_agrees_with_its_data(study) -> None:
    """From the data beside the script: figures that can be read, and χ² of the law near the number of values."""
    script = study("error_law")
    ds = script.with_scatter(xr.load_dataset(script.STUDY.data))
    for figure in (script.of_packing(ds), script.of_rules(ds)):
        assert_legible(figure)
    for line in script.agreement(ds).splitlines():
        chi, count = map(float, line.split(" = ")[1].replace(" values", "").split(" of "))
        assert chi < 1.3 * count > 50.0


@pytest.mark.slow
def test_stacks_and_oblique_drops_are_drawn(study, capsys) -> None:
    """What the pictures of docs/stacks.md show, of fewer balls and points."""
    script = study("stacks")
    for figure, count in ((script.stacks([2, 3], 8), 4), (script.oblique(4), 2)):
        assert len(figure.axes) == count and all(ax.lines for ax in figure.axes)
        assert_legible(figure)
    assert "1 % of R1 gives 0.1029 m/s (estimate 0.1027)" in capsys.readouterr().out


@pytest.mark.slow
def test_the_fit_of_computed_bounces_finds_their_law(study) -> None:
    fitted = study("fits").impacts()
    assert fitted.trials[0].name == "viscoelastic" and fitted.probability > 0.01
    assert_legible(fitted.plot())


@pytest.mark.slow
def test_the_figures_of_the_validation_are_drawn(study, capsys) -> None:
    """Of fewer rows and spheres; contacts are counted as in the tables, deviations are printed."""
    for figure in study("validation").draw(40, 200).values():
        assert_legible(figure)
    said = capsys.readouterr().out
    worst = {
        line.partition(":")[0]: float(line.split()[-2]) for line in said.splitlines() if line.endswith(" V")
    }
    assert len(worst) == 3 and max(worst.values()) < 1e-10


@pytest.mark.slow
def test_fig3_of_the_documentation_has_no_caption_of_its_own(study) -> None:
    """The pages write one below it."""
    (figure,) = study("fig3").draw().values()
    shown = [text.get_text() for text in figure.findobj(Text)]
    assert any("coefficient of restitution" in text for text in shown)
    assert not figure.texts and not any("event-driven" in text or "Parameters" in text for text in shown)
    with Image.open(ROOT / "docs" / "images" / "fig3.png") as picture:
        assert picture.size == tuple(round(200 * inches) for inches in figure.get_size_inches())
        kept = np.asarray(picture.convert("RGB"), dtype=int)
    with style():
        figure.dpi = 200
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
    drawn = np.asarray(canvas.buffer_rgba())[..., :3].astype(int)
    assert (np.abs(kept - drawn) > 60).mean() < 0.02  # another release of matplotlib may move a letter


def test_the_relation_for_ice_is_told_from_the_law(study) -> None:
    """The numbers of docs/fit.md."""
    fitted = study("fits").ice()
    assert fitted.verdict.startswith("viscoelastic cannot describe the data")
    assert fitted.chi_square == pytest.approx(466.0, abs=0.5) and fitted.degrees == 29
    speed = np.array([0.02, 0.5, 1.0, 2.0, 4.0])
    relation = 0.32 * speed**-0.234
    above = fitted.contact.restitution(1e-2 * speed) - relation
    assert above[0] == pytest.approx(-0.19, abs=5e-3) and above[-1] == pytest.approx(0.073, abs=5e-3)
    np.testing.assert_allclose((speed / 0.0077) ** -0.234, relation, rtol=2e-3)
    fast = np.geomspace(0.5, 5.0, 13)
    relation = 0.32 * fast**-0.234
    above = hl.fit(hl.Impacts.of_restitution(1e-2 * fast, relation, 0.02), "viscoelastic")
    assert np.max(np.abs(above.contact.restitution(1e-2 * fast) - relation)) == pytest.approx(0.022, abs=1e-3)


@pytest.mark.slow
def test_driven_grains_that_rub_are_drawn_from_the_data(study) -> None:
    script = study("driven_friction")
    ds = xr.load_dataset(script.STUDY.data)
    (figure,) = script.draw(ds).values()
    assert_legible(figure)
    known = (
        ds["dissipation"].sel(drive="heated", case=list(script.HEATED))[..., :3],
        ds["dissipation"].sel(drive="sheared", case=list(script.SHEARED)),
    )
    assert all(np.isfinite(values).mean() > 0.98 for values in known)  # a run may end early


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "page"),
    [("driven_friction", "driven_gases"), ("mixtures", "hard_enough"), ("pressed_cells", "hard_enough")],
)
def test_the_docs_have_the_tables_of_the_study(name: str, page: str, study) -> None:
    script, shown = study(name), (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8").splitlines()
    lines = script.tables(xr.load_dataset(script.STUDY.data)).splitlines()
    rows = [line for line in lines if line.startswith("| ") and line.strip("| ")[0].isdigit()]
    rows += [line for line in lines if line.startswith(("| linear", "| hertz"))]
    assert len(rows) > 5 and [row for row in rows if row not in shown] == []
