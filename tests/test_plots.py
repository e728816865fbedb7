"""Pictures: drawn for every kind of result, with what they must show; films are written and show motion."""

from itertools import pairwise
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr

import hardlimit as hl
from hardlimit.column.comparison import compare
from hardlimit.pictures import animation, plots

VISCOELASTIC = hl.Viscoelastic(youngs_modulus=5e7, poisson_ratio=0.45, restitution=0.7, impact_speed=3.0)
STEEL = hl.Ball(0.02, density=7800.0)


def drops() -> dict[str, hl.Column]:
    three = [hl.Ball(r, density=840.0) for r in (0.1, 0.03, 0.01)]
    linear = hl.LinearDashpot(stiffness=1e7, restitution=0.95)
    return {
        "paper": hl.Column.paper(),
        "three viscoelastic": hl.Column(three, 1e-4, 0.6, VISCOELASTIC),
        "cradle": hl.Column.cradle([STEEL] * 3, [1.0, 0.0, 0.0], linear),
        "at rest": hl.Column.paper(restitution=0.003),
        "no contact": hl.Column.paper(gap=10.0),
        "touching": hl.Column.paper(gap=0.0),
        "moving without gravity": hl.Column([STEEL] * 2, 1e-3, 0.1, linear, -1.0, 0.0),
    }


def texts(figure) -> str:
    return "\n".join(t.get_text() for t in figure.findobj(mpl.text.Text))


@pytest.mark.parametrize("name", drops())
def test_every_result_can_be_drawn(name: str, tmp_path: Path) -> None:
    found = compare(drops()[name])
    both = plots.drop(found.newton, found.independent, found.adiabatic) if name != "at rest" else None
    # A column at rest is sampled slowly: only its forces, whose last contact does not end.
    for figure in (both or plots.forces(found.newton), plots.forces(found.independent)):
        figure.savefig(tmp_path / "picture.png", dpi=40)
        assert (tmp_path / "picture.png").stat().st_size > 2000


def test_forces_name_all_pairs_and_the_end() -> None:
    figure = plots.forces(hl.newton(drops()["three viscoelastic"]))
    assert len(figure.axes) == 3
    shown = texts(figure)
    for part in (
        "$F_{01}$",
        "$F_{12}$",
        "$F_{23}$",
        "$t_f$",
        "[kN]",
        "time after the first floor touch [ms]",
    ):
        assert part in shown


def test_heights() -> None:
    column = hl.Column.paper()
    shown = texts(plots.heights(hl.newton(column), hl.independent(column)))
    for part in (
        "height of the centre [m]",
        "ball 1",
        "ball 2",
        "Newton’s equations",
        "independent collisions",
    ):
        assert part in shown


def test_force_curve_has_the_jump_and_returns_to_zero() -> None:
    result = hl.newton(hl.Column.paper())
    times, forces = plots.force_curve(result, 0, 1e-3)
    assert forces[0] == 0.0 and forces[1] > 0.2 * forces.max()  # the dashpot's jump at first touch
    assert forces[-1] == 0.0 and times[-1] == result.contacts["end"].values[0]
    assert forces.min() >= 0.0 and np.all(np.diff(times) >= 0.0)


def test_result_plot_is_the_forces() -> None:
    assert "contacts" in texts(hl.newton(hl.Column.paper()).plot())


def test_style_is_left_behind() -> None:
    before = mpl.rcParams["font.family"]
    with plots.style(font__size=7.0):
        assert mpl.rcParams["font.size"] == 7.0
    assert mpl.rcParams["font.family"] == before


def test_a_count_has_one_colour() -> None:
    few, many = plots.count_colours(4), plots.count_colours(15)
    for count in range(5):
        assert few[0](few[1](count)) == many[0](many[1](count))
    colours = {many[0](many[1](count)) for count in range(16)}
    assert len(colours) == 16
    assert plots.count_colours(40)[0].N == 16


def sweep_of(values: np.ndarray, name: str) -> xr.Dataset:
    coords = {
        "restitution": np.linspace(0.4, 1.0, values.shape[0]),
        "gap": np.geomspace(1e-6, 1e-2, values.shape[1]),
    }
    return xr.Dataset({name: (("restitution", "gap"), values)}, coords)


def test_maps() -> None:
    axes = {"restitution": np.linspace(0.4, 1.0, 12), "gap": np.geomspace(1e-6, 1e-2, 10)}
    newton = hl.sweep(hl.Column.paper(), **axes)
    collisions = hl.sweep(hl.Column.paper(), model="independent", **axes)
    counts = plots.count_map(newton)
    assert counts.axes[0].get_yscale() == "log" and counts.axes[0].get_xscale() == "linear"
    assert r"initial gap $\Delta h$ [m]" in texts(counts) and "ball–ball contacts" in texts(counts)
    assert r"\varepsilon_\mathrm{eff}" in texts(plots.count_map(newton, "restitution_ratio"))
    assert "[m/s]: Newton − independent" in texts(plots.difference_map(newton, collisions))
    plots.count_map(newton, "t_end").savefig("/dev/null", format="png")
    line = plots.sweep_map(newton.isel(restitution=0))
    assert line.axes[0].get_xscale() == "log"


def test_counts_are_written_into_their_regions() -> None:
    values = np.repeat(np.arange(16), 8)[:, None] * np.ones((1, 64), dtype=int)
    figure = plots.count_map(sweep_of(values, "n_contacts"))
    labels = {t.get_text() for t in figure.axes[0].texts}
    assert labels == {str(n) for n in range(16)}


def test_large_map_is_thinned_out() -> None:
    figure = plots.count_map(sweep_of(np.ones((5001, 3)), "t_end"), "t_end")
    mesh = figure.axes[0].collections[0]
    assert mesh.get_array().size <= 3 * plots.MOST_CELLS


def test_missing_values_and_constant_maps_are_drawn() -> None:
    values = np.full((4, 5), np.nan)
    plots.count_map(sweep_of(values, "restitution_ratio"), "restitution_ratio").savefig(
        "/dev/null", format="png"
    )
    plots.count_map(sweep_of(np.zeros((4, 5)), "t_end"), "t_end").savefig("/dev/null", format="png")


def test_bad_maps_are_refused() -> None:
    ds = sweep_of(np.ones((3, 3)), "t_end")
    with pytest.raises(ValueError, match="must be one of t_end"):
        plots.count_map(ds, "n_contacts")
    with pytest.raises(ValueError, match="must have 2"):
        plots.count_map(ds.isel(gap=0), "t_end")
    with pytest.raises(ValueError, match="must be the same"):
        plots.difference_map(ds, ds.assign_coords(gap=ds.gap * 2.0), "t_end")


@pytest.mark.parametrize("name", ["picture.xyz", "picture", "no folder/picture.png"])
def test_unwritable_pictures_are_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="plot: got") as refused:
        plots.save(plots.forces(hl.newton(hl.Column.paper())), tmp_path / name)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("value", "expected"), [(0.0, "N"), (35e3, "kN"), (1e-3, "mN"), (999.9, "N"), (1e3, "kN")]
)
def test_prefixes(value: float, expected: str) -> None:
    assert plots.scaled(value, "N")[1] == expected


# --- films --------------------------------------------------------------------------------------------------


def test_storyboard() -> None:
    newton, hard = hl.newton(hl.Column.paper()), hl.independent(hl.Column.paper())
    fall, contacts, rebound = animation.storyboard(newton, hard, 30)
    assert [s.close_up for s in (fall, contacts, rebound)] == [False, True, False]
    assert (
        fall.times[0] < -0.3
        and fall.times[-1] == contacts.times[0]
        and contacts.times[-1] == rebound.times[0]
    )
    assert contacts.times[0] < 0.0 and contacts.times[-1] > newton.t_floor_end
    assert contacts.slowed == 10_000.0
    cradle = drops()["cradle"]
    assert len(animation.storyboard(hl.newton(cradle), hl.independent(cradle), 30)) == 1


@pytest.mark.parametrize("ending", [".mp4", ".gif"])
def test_film(ending: str, tmp_path: Path) -> None:
    calls: list[tuple[int, int]] = []
    path = hl.newton(hl.Column.paper()).animate(
        tmp_path / f"film{ending}",
        width=320,
        frames_per_second=3,
        progress=lambda done, total: calls.append((done, total)),
    )
    assert path.stat().st_size > 10_000
    assert list(tmp_path.iterdir()) == [path]  # no draft is left
    assert calls[-1][0] == calls[-1][1] == len(calls)


@pytest.mark.parametrize("name", ["three viscoelastic", "cradle", "no contact", "moving without gravity"])
def test_frames_move(name: str) -> None:
    column = drops()[name]
    pictures = list(animation.frames(hl.newton(column), hl.independent(column), 320, 1))
    assert pictures[0].shape == (180, 320, 3)
    assert any(np.any(a != b) for a, b in pairwise(pictures))


def test_interrupted_film_leaves_nothing(tmp_path: Path) -> None:
    def interrupt(done: int, total: int) -> None:
        if any(tmp_path.iterdir()):  # the draft has been begun
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        hl.newton(hl.Column.paper()).animate(tmp_path / "film.mp4", width=320, progress=interrupt)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["film.avi", "film", "no folder/film.mp4"])
def test_unwritable_films_are_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="animate: got") as refused:
        hl.newton(hl.Column.paper()).animate(tmp_path / name)
    assert "\n" not in str(refused.value)
