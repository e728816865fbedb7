"""Pictures of every kind of result and what they must show; films that are written and show motion."""

import gc
import math
import re
import sys
from dataclasses import replace
from importlib import import_module
from itertools import cycle, pairwise, product
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.mathtext import MathTextParser
from PIL import Image
from scipy.spatial.transform import Rotation

import hardlimit as hl
from conftest import law_of, roomy, slow, too_deep_later
from hardlimit import plots
from hardlimit.column.comparison import compare
from hardlimit.plots import animation, grain_film, labels, maps, stage, storyboard, video
from legible import assert_legible, assert_moves, boxes, coloured

# Modules with a function of the same name in plots.
forces, gas, heights, style = (
    import_module(f"hardlimit.plots.{name}") for name in ("forces", "gas", "heights", "style")
)

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


def random_column(seed: int) -> hl.Column:
    """2 to 6 balls under either law, every fifth a cradle; ε = 1 and touching balls among them."""
    rng = np.random.default_rng(seed)
    n = int(rng.choice([2, 2, 2, 3, 3, 4, 6]))
    radii = 10 ** rng.uniform(-3, -0.7, n)
    if seed % 2:
        radii = np.sort(radii)[::-1]  # a light ball on top rises higher than it fell
    balls = [hl.Ball(radius, density=10 ** rng.uniform(2, 4)) for radius in radii]
    gaps = [0.0 if rng.random() < 0.2 else 10 ** rng.uniform(-6, -2) for _ in range(n - 1)]
    epsilon = 1.0 if rng.random() < 0.2 else rng.uniform(0.5, 0.99)
    if rng.random() < 0.5:
        law = hl.LinearDashpot(stiffness=10 ** rng.uniform(4, 8), restitution=epsilon)
    else:
        law = hl.Viscoelastic(
            youngs_modulus=10 ** rng.uniform(7, 10), poisson_ratio=0.3, restitution=epsilon, impact_speed=2.0
        )
    if seed % 5 == 4:
        return hl.Column.cradle(balls, [1.0] + [0.0] * (n - 1), law, gaps)
    return hl.Column(balls, gaps, balls[0].radius + rng.uniform(0.05, 2.0), law)


#: A fall and a cradle with every run, the others with the slow ones.
SEEDS = [seed if seed == 1 else slow(seed) for seed in range(10)]


def texts(figure) -> str:
    return "\n".join(t.get_text() for t in figure.findobj(mpl.text.Text))


@pytest.mark.parametrize("name", [name if name == "cradle" else slow(name) for name in drops()])
def test_every_result_can_be_drawn(name: str, tmp_path: Path) -> None:
    comparison = compare(drops()[name])
    both = (
        plots.drop(comparison.newton, comparison.independent, comparison.adiabatic)
        if name != "at rest"
        else None
    )
    # Sampling a column at rest is slow: only its forces are drawn; the last contact does not end.
    for figure in (both or plots.forces(comparison.newton), plots.forces(comparison.independent)):
        figure.savefig(tmp_path / "picture.png", dpi=40)
        assert coloured(tmp_path / "picture.png") > 1e-3


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
        "balls 2–3: ",
        "first floor touch [ms]",
    ):
        assert part in shown


def test_heights() -> None:
    column = hl.Column.paper()
    shown = texts(plots.heights(hl.newton(column), hl.independent(column)))
    models = ("Newton’s equations", "independent collisions")
    for part in ("height of the centre [m]", "ball 1", "ball 2", *models):
        assert part in shown


def test_force_curve_has_the_jump_and_returns_to_zero() -> None:
    result = hl.newton(hl.Column.paper())
    times, force = forces.force_curve(result, 0, 1e-3)
    assert force[0] == 0.0 and force[1] > 0.2 * force.max()  # the dashpot's jump at first touch
    assert force[-1] == 0.0 and times[-1] == result.contacts["end"].values[0]
    assert force.min() >= 0.0 and np.all(np.diff(times) >= 0.0)


# --- properties of all columns ------------------------------------------------------------------------------


def seconds_per_unit(label: str) -> float:
    return {"[s]": 1.0, "[ms]": 1e-3, "[µs]": 1e-6}[label.split()[-1]]


@pytest.mark.parametrize("seed", SEEDS)
def test_every_apex_is_in_view(seed: int) -> None:
    """The top of every flight lies within the axes, and each line continues beyond it."""
    column = random_column(seed)
    results = [hl.newton(column)]
    if len(column.balls) == 2 and column.floor:  # more hard spheres may collapse, which is slow to sample
        results.append(hl.independent(column))
    for result in results:
        assert_tops_are_in_view(result)


def assert_tops_are_in_view(result: hl.Result) -> None:
    column = result.column
    ax = plots.heights(result).axes[0]
    unit = seconds_per_unit(ax.get_xlabel())
    marks = np.concatenate([result.contacts[name].values for name in ("begin", "end")])
    after = float(np.nanmax(marks))
    state = result.trajectory(after)
    balls = [line for line in ax.lines if len(line.get_xdata()) > 100]
    assert len(balls) == len(column.balls)
    reached = 0
    for i, line in enumerate(balls):
        t, height = (np.asarray(values) for values in line.get_data())
        assert ax.get_ylim()[0] <= height.min() and height.max() < ax.get_ylim()[1]
        v, z = float(state["velocity"][0, i]), float(state["position"][0, i])
        if column.gravity == 0.0 or v <= 0.0:
            continue
        top, highest = after + v / column.gravity, z + v**2 / (2 * column.gravity)
        assert ax.get_xlim()[0] < top / unit < ax.get_xlim()[1]
        not_hit_before = pytest.approx(highest, rel=1e-6)
        if float(result.trajectory(top)["position"][0, i]) == not_hit_before:
            assert highest < ax.get_ylim()[1]
            assert np.any(np.diff(height[t * unit >= after]) < 0.0)  # it falls again
            reached += 1
    assert reached or column.gravity == 0.0 or np.isnan(marks).any()


@pytest.mark.parametrize("seed", SEEDS)
def test_forces_of_every_column_share_one_unit_and_can_be_read(seed: int) -> None:
    figure = plots.forces(hl.newton(random_column(seed)))
    units = {ax.get_ylabel().split()[-1] for ax in figure.axes}
    assert len(units) == 1
    assert_legible(figure)


@pytest.mark.parametrize("seed", [slow(0), slow(4), slow(7)])
def test_drops_can_be_read(seed: int) -> None:
    """Contacts are elastic, so that hard spheres do not collapse."""
    column = random_column(seed)
    law = hl.LinearDashpot(stiffness=1e6, restitution=1.0)
    if column.floor:
        column = hl.Column(column.balls, column.gaps, column.height, law)
    else:
        column = hl.Column.cradle(column.balls, column.velocities, law, column.gaps)
    assert_legible(plots.drop(hl.newton(column), hl.independent(column)))


@pytest.mark.slow
def test_the_papers_drop_can_be_read_and_says_how_high() -> None:
    comparison = compare(hl.Column.paper())
    figure = plots.drop(comparison.newton, comparison.independent, comparison.adiabatic)
    assert_legible(figure)
    top, highest = (values[-1] for values in heights.tops(comparison.independent))
    ax = next(ax for ax in figure.axes if ax.get_ylabel() == "height of the centre [m]")
    assert (top, highest) == (pytest.approx(0.6025, abs=1e-3), pytest.approx(1.99, abs=0.01))
    assert top / seconds_per_unit(ax.get_xlabel()) < ax.get_xlim()[1] and highest < ax.get_ylim()[1]
    shown = texts(figure)
    assert "Newton’s equations, top ball rebounds to 0.484 m" in shown
    assert "independent collisions, top ball rebounds to 1.99 m" in shown


@pytest.mark.parametrize("seed", SEEDS)
def test_a_film_shows_the_whole_rebound(seed: int) -> None:
    column = random_column(seed)
    newton = hl.newton(column)
    scenes = storyboard.storyboard(newton, newton, 2)
    assert all(np.all(np.diff(scene.times) >= 0.0) for scene in scenes)
    for top in heights.tops(newton)[0]:
        if not math.isnan(top):
            assert top <= scenes[-1].times[-1] and scenes[-1].rebound
    last = scenes[-1]
    assert not last.rebound or np.nanmax(newton.trajectory(last.times)["position"]) <= last.highest


@pytest.mark.parametrize("name", [slow("paper"), slow("three viscoelastic"), "cradle"])
def test_frames_can_be_read(name: str) -> None:
    newton = hl.newton(drops()[name])
    for scene in storyboard.storyboard(newton, newton, 2):
        kind = stage.CloseUp if scene.close_up else stage.Wide
        with style.style(**video.STYLE):
            figure = kind(newton, newton, scene, 1280).figure
        assert_legible(figure, **video.STYLE)


@pytest.mark.slow
@pytest.mark.parametrize("law", hl.LAWS)
def test_a_ball_alone_can_be_drawn(law: str) -> None:
    """The text mentions no other balls, and there is no t_f."""
    column = hl.Column([hl.Ball(0.1, density=840.0)], gaps=[], height=0.6, law=law_of(law, 0.7))
    newton, independent = hl.newton(column), hl.independent(column)
    figure = plots.drop(newton, independent)
    assert_legible(figure)
    shown = texts(figure)
    assert "$F_{01}$" in shown and "$t_f$" not in shown and "top" not in shown and "ball 1" not in shown
    for result, name in ((newton, "Newton’s equations"), (independent, "independent collisions")):
        assert f"{name}, rebound to {result.rebound_heights[0]:.3g} m" in shown
    for scene in storyboard.storyboard(newton, independent, 2):
        with style.style(**video.STYLE):
            figure = (stage.CloseUp if scene.close_up else stage.Wide)(newton, independent, scene, 640).figure
        assert "top ball" not in texts(figure)
    pictures = list(animation.frames(newton, independent, 320, 1))
    assert any(np.any(a != b) for a, b in pairwise(pictures))


FRICTION = {
    "smooth": None,
    "rough": hl.Friction(math.inf),
    "none": hl.Friction(0.4, model="none", damping=20.0),
    "spring": hl.Friction(0.4),
}


@pytest.mark.parametrize(
    ("friction", "tan"),
    [
        impact if impact == ("spring", 0.4) else slow(*impact)
        for impact in product(FRICTION, (0.0, 0.4, -2.0, 8.0))
    ],
)
def test_impacts_can_be_read(friction: str, tan: float) -> None:
    law = hl.LinearDashpot(stiffness=1e6, restitution=0.8, friction=FRICTION[friction])
    ball = hl.Ball(0.01, density=2500.0)
    other = ball if tan < 1.0 else hl.FLOOR
    result = law.between(ball, other).impact(1.0, tan, spin=20.0)
    figure = result.plot()
    assert_legible(figure)
    shaded = sum(interval.state == "stick" for interval in result.intervals)
    assert [len(ax.patches) for ax in figure.axes] == 3 * [shaded]
    assert len(figure.axes[2].lines) == (3 if tan < 1.0 else 2)  # spins, and zero


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
    assert plots.count_colours(6, 3)[0].N == 4


def lightness(colour: str) -> float:
    """CIE L* of an sRGB colour, 0 black to 100 white."""
    rgb = mpl.colors.to_rgb(colour)
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in rgb]
    y = 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
    return 116 * y ** (1 / 3) - 16 if y > 216 / 24389 else 24389 / 27 * y


def test_the_more_contacts_the_lighter() -> None:
    """The order of the counts remains visible in grey; neighbours differ by more than the visible threshold."""
    assert np.all(np.diff([lightness(colour) for colour in style.COUNT_COLOURS]) > 2.5)


def sweep_of(values: np.ndarray, name: str) -> xr.Dataset:
    coords = {
        "restitution": np.linspace(0.4, 1.0, values.shape[0]),
        "gap": np.geomspace(1e-6, 1e-2, values.shape[1]),
    }
    return xr.Dataset({name: (("restitution", "gap"), values)}, coords)


AXES = {"restitution": np.linspace(0.4, 1.0, 12), "gap": np.geomspace(1e-6, 1e-2, 10)}


def test_maps() -> None:
    newton = hl.sweep(hl.Column.paper(), **AXES)
    collisions = hl.sweep(hl.Column.paper(), model="independent", **AXES)
    counts = plots.count_map(newton)
    assert counts.axes[0].get_yscale() == "log" and counts.axes[0].get_xscale() == "linear"
    assert r"initial gap $\Delta h$ [mm]" in texts(counts) and "ball–ball contacts" in texts(counts)
    assert r"\varepsilon_\mathrm{eff}" in texts(plots.count_map(newton, "restitution_ratio"))
    assert "[m/s]: Newton − independent" in texts(plots.difference_map(newton, collisions))
    assert "$t_f$ [ms]" in texts(plots.count_map(newton, "t_end"))
    shown = counts.axes[1].get_yticks()
    assert shown.min() == newton.n_contacts.min() == 1 and shown.max() == newton.n_contacts.max()
    line = plots.sweep_map(newton.isel(restitution=0))
    assert line.axes[0].get_xscale() == "log"


@pytest.mark.slow
@pytest.mark.parametrize("swept", [{}, {"gap": [1e-5, 1e-4, 1e-3]}])
def test_a_map_of_one_ball_names_it(swept: dict[str, list[float]]) -> None:
    ds = hl.sweep(hl.Column.paper(), variables=["rebound_height"], restitution=[0.5, 0.7, 0.9], **swept)
    for ball in (1, 2):
        figure = plots.sweep_map(ds.sel(ball=ball), "rebound_height")
        assert figure.axes[0].get_title() == f"ball {ball}"
        assert_legible(figure)


def test_maps_are_legible() -> None:
    newton, collisions = (
        hl.sweep(hl.Column.paper(), model=model, **AXES) for model in ("newton", "independent")
    )
    for figure in (
        plots.count_map(newton),
        plots.count_map(newton, "t_end"),
        plots.difference_map(newton, collisions),
    ):
        assert_legible(figure)


def test_counts_are_written_into_their_regions() -> None:
    values = np.repeat(np.arange(16), 8)[:, None] * np.ones((1, 64), dtype=int)
    figure = plots.count_map(sweep_of(values, "n_contacts"))
    labels = {t.get_text() for t in figure.axes[0].texts}
    assert labels == {str(n) for n in range(16)}


def test_large_map_is_thinned_out() -> None:
    figure = plots.count_map(sweep_of(np.ones((5001, 3)), "t_end"), "t_end")
    mesh = figure.axes[0].collections[0]
    assert mesh.get_array().size <= 3 * maps.MAX_CELLS


@pytest.mark.slow
def test_missing_values_and_constant_maps_are_drawn() -> None:
    nothing = plots.count_map(sweep_of(np.full((4, 5), np.nan), "restitution_ratio"), "restitution_ratio")
    same = plots.count_map(sweep_of(np.zeros((4, 5)), "t_end"), "t_end")
    for figure, masked in ((nothing, 20), (same, 0)):
        assert_legible(figure)
        assert np.ma.count_masked(figure.axes[0].collections[0].get_array()) == masked


def test_bad_maps_are_refused() -> None:
    ds = sweep_of(np.ones((3, 3)), "t_end")
    with pytest.raises(ValueError, match="must be one of t_end"):
        plots.count_map(ds, "n_contacts")
    with pytest.raises(ValueError, match="must have 2"):
        plots.count_map(ds.isel(gap=0), "t_end")
    with pytest.raises(ValueError, match="must have those of newton"):
        plots.difference_map(ds, ds.assign_coords(gap=ds.gap * 2.0), "t_end")


@pytest.mark.slow
def test_resolution_and_pdf(tmp_path: Path) -> None:
    figure = plots.forces(hl.newton(hl.Column.paper()))
    for dpi in (40, 80):
        with Image.open(plots.save(figure, tmp_path / "picture.png", dpi)) as picture:
            width = figure.get_size_inches()[0]
            assert picture.size[0] == pytest.approx(dpi * width, abs=1)
            assert picture.info["dpi"][0] == pytest.approx(dpi, rel=1e-3)
    assert plots.save(figure, tmp_path / "picture.pdf", 300).read_bytes().startswith(b"%PDF")


@pytest.mark.parametrize("dpi", [0, -1, 19.9, 2401, math.nan, math.inf, "300", True])
def test_bad_resolutions_are_refused(dpi, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"^dpi: got .*, must be .*20.*2400") as refused:
        plots.save(plots.forces(hl.newton(hl.Column.paper())), tmp_path / "picture.png", dpi)
    assert "\n" not in str(refused.value) and not any(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["picture.xyz", "picture", "no folder/picture.png"])
def test_unwritable_pictures_are_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="plot: got") as refused:
        plots.save(plots.forces(hl.newton(hl.Column.paper())), tmp_path / name)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("value", "expected"), [(0.0, "N"), (35e3, "kN"), (1e-3, "mN"), (999.9, "N"), (1e3, "kN")]
)
def test_prefixes(value: float, expected: str) -> None:
    assert labels.scaled(value, "N")[1] == expected


# --- legibility ---------------------------------------------------------------------------------------------


def drawn(figure: Figure) -> np.ndarray:
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].astype(int)


@pytest.mark.slow
@pytest.mark.parametrize("gap", [1e-5, 1e-4, 1e-3, 5e-3])
def test_every_model_of_a_drop_is_seen(gap: float) -> None:
    """The picture of heights changes if the lines of any model are removed, even if two models coincide."""
    comparison = compare(hl.Column.paper(gap=gap))
    figure = plots.heights(*comparison.results)
    ax = figure.axes[0]
    whole = drawn(figure)
    lines = [line for line in ax.lines if len(line.get_xdata()) > 100]
    assert len(lines) == 2 * len(comparison.results)
    for k in range(len(comparison.results)):
        mine = lines[2 * k : 2 * k + 2]
        for line in mine:
            line.set_visible(False)
        changed = np.any(np.abs(whole - drawn(figure)) > 20, axis=2)
        for line in mine:
            line.set_visible(True)
        # In each pixel column this is more than the antialiased edge of another line.
        assert changed.sum() > 1.6 * ax.get_window_extent().width, comparison.results[k].model


@pytest.mark.parametrize("seed", SEEDS)
def test_all_lines_of_a_drop_go_to_the_same_end(seed: int) -> None:
    balls = random_column(seed).balls[:2]
    law = hl.LinearDashpot(stiffness=1e6, restitution=1.0)  # hard spheres do not collapse
    results = compare(roomy(hl.Column(balls, 1e-4, balls[0].radius + 0.3, law))).results
    ax = plots.heights(*results).axes[0]
    ends = [line.get_xdata()[-1] for line in ax.lines if len(line.get_xdata()) > 100]
    assert len(ends) == 2 * len(results)
    assert ends == pytest.approx([ax.get_xlim()[1]] * len(ends))


@pytest.mark.parametrize(
    ("epsilon", "law"),
    [pair if pair[0] == 0.99 else slow(*pair) for pair in zip([0.02, 0.5, 0.8, 0.99, 1.0], cycle(hl.LAWS))],
)
def test_a_restitution_fills_its_axis(law: str, epsilon: float) -> None:
    contact = law_of(law, epsilon).between(STEEL)
    speeds = np.geomspace(1e-3, 10.0, 50)
    values = np.asarray(contact.restitution(speeds))
    figure = plots.restitution_over_speed(contact, speeds)
    low, high = figure.axes[0].get_ylim()
    assert 0.0 <= low < values.min() and values.max() < high
    assert np.ptp(values) > 0.6 * (high - low) or high - low <= 0.1 * (1.0 + 1e-9)
    assert_legible(figure)


def test_all_counts_of_a_map_are_named() -> None:
    """Labels stand in the regions or at the edge beside them, also two-digit numbers and thin regions."""
    x, y = np.linspace(0.4, 1.0, 200), np.geomspace(1e-6, 1e-2, 200)
    ds = hl.sweep(hl.Column.paper(), restitution=x, gap=y)
    counts = ds.n_contacts.values
    figure = plots.count_map(ds)
    assert_legible(figure)
    ax = figure.axes[0]
    named = {text.get_text(): text for text in ax.texts}
    assert set(named) == {str(n) for n in np.unique(counts)} and counts.max() >= 12
    for count, text in named.items():
        if hasattr(text, "xy"):
            assert counts[-1, np.abs(np.log(y * 1e3 / text.xy[1])).argmin()] == int(count)
            continue
        box = text.get_window_extent().transformed(ax.transData.inverted())
        inside = counts[np.ix_((x > box.x0) & (x < box.x1), (y > box.y0 * 1e-3) & (y < box.y1 * 1e-3))]
        assert (inside == int(count)).mean() > 0.7, count


@pytest.mark.parametrize("shape", [(3, 700), *map(slow, ((1, 1), (40, 1), (1, 40), (2, 2), (700, 3)))])
def test_counts_of_a_small_map_are_named_where_they_are(shape: tuple[int, int]) -> None:
    values = np.random.default_rng(1).integers(0, 20, shape)
    figure = plots.count_map(sweep_of(np.sort(values, axis=1), "n_contacts"))
    assert {text.get_text() for text in figure.axes[0].texts} <= {str(n) for n in np.unique(values)}
    figure.savefig("/dev/null", format="png")


@pytest.mark.parametrize("name", labels.QUANTITIES)
def test_a_prime_stands_above_its_index(name: str) -> None:
    text = labels.QUANTITIES[name][0]
    for part in re.findall(r"\$[^$]*\$", text):
        with style.style():
            glyphs = MathTextParser("path").parse(part).glyphs
        characters = "".join(chr(glyph[2]) for glyph in glyphs)
        if "′" in characters:
            prime, index = (glyphs[characters.index(c)][3] for c in ("′", "r"))
            assert index < prime
    assert ("′" in text or "prime" in text) == (name == "relative_velocity")


@pytest.mark.parametrize(("slower", "dimension"), [(1e-9, 3), *map(slow, (0.0, 1.0, 1e-3), (2, 2, 3))])
def test_a_cooled_gas_keeps_its_colours(slower: float, dimension: int) -> None:
    system = hl.ParticleSystem.random(200, 0.2, 1e-3, 2500.0, 1.0, dimension=dimension)
    with style.style(**video.STYLE):
        film = grain_film.Stage(system, 1.0, 320)
        film.picture(grain_film.Snapshot.of(0.0, system), 0)
        before = film.bodies.get_array().copy()
        cooled = system.replace(velocities=slower * system.velocities)
        film.picture(grain_film.Snapshot.of(1.0, cooled), 10)
        figure = film.figure
    after = film.bodies.get_array()
    assert film.bodies.norm.vmin == 0.0 and film.bodies.norm.vmax == 2.0
    np.testing.assert_allclose(after, before if slower else 0.0 * before, rtol=1e-6)
    assert np.ptp(before) > 1.0  # more than half of the colours are in use
    assert "root mean square at this instant" in texts(figure)
    assert_legible(figure, **video.STYLE)


@pytest.mark.parametrize("gradient", [1, slow(2)])
def test_film_of_a_sheared_box(gradient: int) -> None:
    """The plane of flow and gradient; the image of a sphere at a sheared side is where the images have moved to."""
    sides = tuple("lees-edwards" if axis == gradient else "periodic" for axis in range(3))
    at = [[8e-3, 5e-3, 5e-3]]
    at[0][gradient] = 0.4e-3
    box = {"radius": 1e-3, "density": 2500.0, "box": 1e-2, "boundary": sides, "shear_displacement": 3e-3}
    system = hl.ParticleSystem(at, [[0.0] * 3], **box)
    centres, radii, *_ = grain_film.shown(system)
    expected = [[1e-3, 10.4e-3], [8e-3, 0.4e-3]]
    np.testing.assert_allclose(sorted(centres.tolist())[: len(expected)], expected, atol=1e-12)
    assert np.all(radii == 1e-3)
    with style.style(**video.STYLE):
        film = grain_film.Stage(system, 1.0, 640)
        film.picture(grain_film.Snapshot.of(0.0, system), 0)
    assert "dash-dotted: images slide" in texts(film.figure)
    assert_legible(film.figure, **video.STYLE)


def spinning(dimension: int, size: float = 300.0, **more) -> hl.ParticleSystem:
    system = hl.ParticleSystem.random(80, 0.2, (0.5e-3, 1e-3), 2500.0, 1.0, dimension=dimension, **more)
    shape = (80, 3) if dimension == 3 else (80,)
    return system.replace(angular_velocities=size * np.random.default_rng(1).normal(size=shape))


@pytest.mark.parametrize("dimension", [2, 3])
def test_marks_turn_with_the_particles(dimension: int) -> None:
    """Equal spins at both ends turn exactly, also about an axis that is not that of the mark; unequal ones by their
    mean. Reference: rotation vectors of scipy."""
    start, directions = spinning(dimension), grain_film.Directions()
    axes = (0, 0, 1) if dimension == 2 else (1, 1, 1)
    spins = np.asarray(start.angular_velocities).reshape(80, -1) * np.array(axes) * np.ones(3)
    assert np.array_equal(directions.at(0.0, start), np.tile([1.0, 0.0, 0.0], (80, 1)))
    for time in np.linspace(0.001, 0.02, 9):
        now = directions.at(float(time), start)
    expected = Rotation.from_rotvec(0.02 * spins).apply([1.0, 0.0, 0.0])
    np.testing.assert_allclose(now, expected, atol=1e-12)
    slower = start.replace(angular_velocities=0.5 * start.angular_velocities)
    turned = Rotation.from_rotvec(0.75 * 0.003 * spins).apply(expected)
    np.testing.assert_allclose(directions.at(0.023, slower), turned, atol=1e-12)
    assert grain_film.Directions().at(0.0, hl.ParticleSystem.random(9, 0.1, 1e-3, 2500.0, 1.0)) is None


@pytest.mark.parametrize("sheared", [False, slow(True)])
def test_marks_are_where_the_bodies_are_cut(sheared: bool) -> None:
    """The ends of a line lie on the sphere, in the plane of the cut and in the plane that turns; images have the same
    line. The spoke of a disk is a radius."""
    rng = np.random.default_rng(4)
    more = {"boundary": ("periodic", "lees-edwards", "periodic"), "shear_rate": 1.0} if sheared else {}
    system = spinning(3, **more)
    directions = rng.normal(size=(80, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    snapshot, axes = grain_film.Snapshot.of(0.0, system, directions), list(grain_film.plane(system))
    (normal,) = {0, 1, 2} - set(axes)
    circles, marks, drawn = snapshot.circles, snapshot.marks, 0
    for centre, ends, i, height in zip(
        circles.centres, marks, circles.particles, circles.heights, strict=True
    ):
        drawn += np.isfinite(ends).all()
        for end in ends[np.isfinite(ends).all(axis=1)]:
            point = np.empty(3)
            point[axes], point[normal] = end - centre, height
            assert abs(point @ directions[i]) < 1e-12
            assert np.linalg.norm(point) == pytest.approx(system.radius[i], rel=1e-9)
            assert height + system.positions[i, normal] == pytest.approx(0.5 * system.box[normal])
    assert drawn > 10 and len(circles.particles) > len(set(circles.particles.tolist()))
    disks = spinning(2)
    flat = np.concatenate([directions[:, :2], np.zeros((80, 1))], axis=1)
    flat /= np.linalg.norm(flat, axis=1)[:, None]
    shot = grain_film.Snapshot.of(0.0, disks, flat)
    spokes = shot.marks[:, 1] - shot.marks[:, 0]
    particles = shot.circles.particles
    np.testing.assert_allclose(spokes, disks.radius[particles, None] * flat[particles, :2], atol=1e-15)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_film_of_spinning_grains_shows_marks(dimension: int) -> None:
    """Light on dark colours and dark on light ones; they turn from frame to frame. Grains without spins have none."""
    system, directions = spinning(dimension), grain_film.Directions()
    with style.style(**video.STYLE):
        film = grain_film.Stage(system, 1.0, 640)
        frames = [
            film.picture(grain_film.Snapshot.of(time, system, directions.at(time, system)), 0)
            for time in (0.0, 2e-3)
        ]
        assert_legible(film.figure, **video.STYLE)
    assert np.any(frames[0] != frames[1])
    colours = film.marks.get_colors()[:, :3].sum(axis=1)
    bodies = film.bodies.get_array()
    assert set(colours.tolist()) == {0.0, 3.0} and (colours[bodies < 0.5] == 3.0).all()
    assert (colours[bodies > 1.5] == 0.0).all()
    assert "turn with them" in texts(film.figure) and "rotational temperature" in texts(film.figure)
    smooth = hl.ParticleSystem.random(20, 0.1, 1e-3, 2500.0, 1.0, dimension=dimension)
    with style.style(**video.STYLE):
        plain = grain_film.Stage(smooth, 1.0, 320)
        plain.picture(grain_film.Snapshot.of(0.0, smooth), 0)
    assert not plain.marks.get_segments() and "turn" not in texts(plain.figure)


@pytest.mark.parametrize(("samples", "until"), [(100, 0.02), slow(400, 0.02), slow(20, 1e-4)])
def test_the_transient_of_the_start_is_marked(samples: int, until: float) -> None:
    """After the transient the rate is Enskog's; within it is much higher. A run may be shorter than the transient."""
    system = hl.ParticleSystem.random(1000, 0.3, 1e-3, 2500.0, 1.0)
    run = hl.event_driven(system, restitution=0.9, until=until, samples=samples)
    end = gas.transient(run)
    time, rate = run.series["time"].values, run.series["collision_rate"].values
    over = rate / gas.expectations(run)["collision_rate"][1]
    assert over[1] > 1.5
    if until == 1e-4:
        assert end == until
    else:
        assert np.mean(over[time > end][: samples // 10]) < 1.1
    figure = plots.gas(run)
    shaded = [patch for ax in figure.axes[1:] for patch in ax.patches]
    assert len(shaded) == 2 and gas.TRANSIENT in texts(figure)
    assert_legible(figure)


@pytest.mark.parametrize("start", [0.0, slow(0.3), slow(5.0)])
def test_both_temperatures_of_a_gas_with_friction_are_drawn(start: float) -> None:
    """Beside the theory of the gas with friction, not Haff's law; grains that do not spin at first have T_r = 0."""
    system = hl.ParticleSystem.random(300, 0.1, 1e-3, 2500.0, 1.0)
    rough = {"friction": 0.5, "tangential_restitution": 0.4}
    run = hl.event_driven(system, restitution=0.9, until=0.05, samples=30, **rough)
    time, temperature = run.series["time"].values, float(run.series["granular_temperature"][0])
    theory = hl.boxes.theory.gas(system).rotating(0.9, 0.5, 0.4)
    cooling, rotation = theory.cooling(time, temperature, start * temperature)
    energy = 1.5 * system.mass.sum() * rotation
    cooled = run.samples | {"rotational_energy": energy, "granular_temperature": cooling}
    figure = plots.gas(replace(run, samples=cooled))
    lines = {line.get_color(): line.get_ydata() for line in figure.axes[0].lines}
    np.testing.assert_allclose(lines[style.PALETTE["blue"]], cooling)
    np.testing.assert_allclose(lines[style.PALETTE["orange"]], rotation, atol=1e-15)
    dashed = [line.get_ydata() for line in figure.axes[0].lines if line.get_color() == "black"]
    np.testing.assert_allclose(dashed, [cooling, rotation], rtol=1e-6, atol=1e-15)
    assert all(text in texts(figure) for text in ("temperatures", "translation", "rotation", "with friction"))
    assert "Haff" not in texts(figure)
    assert_legible(figure)


# --- films --------------------------------------------------------------------------------------------------


def test_storyboard() -> None:
    newton, hard = hl.newton(hl.Column.paper()), hl.independent(hl.Column.paper())
    fall, contacts, rebound = storyboard.storyboard(newton, hard, 30)
    assert [s.close_up for s in (fall, contacts, rebound)] == [False, True, False]
    assert fall.times[0] < -0.3 and fall.times[-1] == contacts.times[0]
    assert contacts.times[-1] == rebound.times[0]
    assert contacts.times[0] < 0.0 and contacts.times[-1] > newton.t_floor_end
    assert contacts.slowed == 10_000.0
    cradle = drops()["cradle"]
    assert len(storyboard.storyboard(hl.newton(cradle), hl.independent(cradle), 30)) == 1


@pytest.mark.parametrize("ending", [slow(".mp4"), slow(".gif")])
def test_film(ending: str, tmp_path: Path) -> None:
    calls: list[tuple[int, int]] = []
    options = {"width": 320, "frames_per_second": 3, "progress": lambda *told: calls.append(told)}
    path = hl.newton(hl.Column.paper()).animate(tmp_path / f"film{ending}", **options)
    assert_moves(path, 320, calls[-1][1])
    assert list(tmp_path.iterdir()) == [path]  # no temporary file is left
    assert calls[-1][0] == calls[-1][1] == len(calls)


@pytest.mark.parametrize(
    "name", [slow("three viscoelastic"), "cradle", slow("no contact"), slow("moving without gravity")]
)
def test_frames_move(name: str) -> None:
    column = drops()[name]
    pictures = list(animation.frames(hl.newton(column), hl.independent(column), 320, 1))
    assert pictures[0].shape == (180, 320, 3)
    assert any(np.any(a != b) for a, b in pairwise(pictures))


@pytest.mark.slow
def test_interrupted_film_leaves_nothing(tmp_path: Path) -> None:
    def interrupt(done: int, total: int) -> None:
        if any(tmp_path.iterdir()):  # writing has started
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        hl.newton(hl.Column.paper()).animate(tmp_path / "film.mp4", width=320, progress=interrupt)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_mp4_without_ffmpeg_names_the_extra_and_gif_needs_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    result = hl.newton(hl.Column.paper())
    with pytest.raises(ValueError, match=r"pip install 'hardlimit\[film\]'") as refused:
        result.animate(tmp_path / "film.mp4", width=320, frames_per_second=2)
    assert "\n" not in str(refused.value) and not any(tmp_path.iterdir())
    assert_moves(result.animate(tmp_path / "film.gif", width=160, frames_per_second=1), 160)


@pytest.mark.slow
# imageio-ffmpeg leaves its pipe to the garbage collector.
@pytest.mark.filterwarnings("ignore::ResourceWarning")
def test_ffmpeg_that_fails_is_reported_in_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", "/bin/false")
    with pytest.raises((ValueError, OSError), match=r"film\.mp4.* cannot be written: ffmpeg") as refused:
        hl.newton(hl.Column.paper()).animate(tmp_path / "film.mp4", width=320, frames_per_second=2)
    assert "\n" not in str(refused.value) and not any(tmp_path.iterdir())
    del refused


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="limits of a process")
@pytest.mark.filterwarnings("ignore::ResourceWarning")
def test_a_film_for_which_there_is_no_space_is_reported_in_one_line(tmp_path: Path) -> None:
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (3000, hard))  # ffmpeg inherits it
    try:
        with pytest.raises(
            OSError, match=r"film\.mp4: cannot be written: ffmpeg did not finish the file; .*B are free"
        ):
            hl.newton(hl.Column.paper()).animate(tmp_path / "film.mp4", width=320, frames_per_second=2)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert not any(tmp_path.iterdir())
    gc.collect()


@pytest.mark.parametrize(
    ("options", "message"),
    [({"width": 0}, "width: got 0"), ({"width": 5000}, "width: got 5000")]
    + [({"frames_per_second": n}, "frames_per_second: got") for n in (0, -5, 1000, math.nan)]
    + [({"progress": True}, "progress: got True, must be callable with")]
    + [
        (
            {"ghost": hl.newton(hl.Column.paper(gap=1e-3))},
            "ghost: got .*, must be a result of the same column",
        )
    ],
)
def test_impossible_films_are_refused(options, message, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=message):
        hl.newton(hl.Column.paper()).animate(tmp_path / "film.gif", **options)


@pytest.mark.parametrize("width", [slow(160), slow(350), slow(337)])
def test_films_of_any_width(width: int, tmp_path: Path) -> None:
    path = hl.newton(hl.Column.paper()).animate(tmp_path / "film.mp4", width=width, frames_per_second=1)
    assert_moves(path, width // 32 * 32)


@pytest.mark.parametrize("name", ["film.avi", "film", "no folder/film.mp4"])
def test_unwritable_films_are_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="path: got") as refused:
        hl.newton(hl.Column.paper()).animate(tmp_path / name)
    assert "\n" not in str(refused.value)


def test_a_run_that_was_not_resolved_is_drawn_as_far_as_it_is_known() -> None:
    """The model stops after a million bounces. Some are drawn, and the title gives the end of the known motion."""
    ball = hl.Column([STEEL], [], 0.1, hl.LinearDashpot(stiffness=1e6, restitution=1.0))
    result = hl.independent(ball, until=1e7)
    known = result.known_until
    assert "not resolved" in result.outcome and 0.0 < known < 1e7
    assert result.default_times()[-1] == known
    trajectory = result.trajectory([0.0, known])
    assert trajectory.attrs["known_until"] == known
    assert np.isfinite(trajectory.position.values).all()
    assert result.plot().get_suptitle().startswith("not resolved: known up to ")
    with pytest.raises(ValueError, match=r"times: got .*, where the solution ends: not resolved"):
        result.trajectory([1.01 * known])


def test_heights_say_where_the_motion_after_the_sequence_ends() -> None:
    balls = [hl.Ball(0.0013, density=124.0), hl.Ball(0.0016, density=2310.0), hl.Ball(0.061, density=205.0)]
    law = hl.LinearDashpot(stiffness=3.42e5, restitution=0.2376)
    column = hl.Column(balls, gaps=[0.00114, 2.96e-6], height=0.654, law=law)
    results = hl.newton(column), hl.independent(column)
    assert {result.outcome for result in results} == {"ok"}
    for figure in (plots.heights(*results), plots.drop(*results)):
        [title] = [ax.get_title() for ax in figure.axes if "after" in ax.get_title()]
        newton, independent = title.split("\n")
        assert newton.startswith("Newton’s equations: too deep after ")
        assert independent.startswith("independent collisions: not resolved after ")
    whole = plots.heights(hl.newton(hl.Column.paper()))
    assert whole.axes[0].get_title() == ""


def test_a_drop_is_drawn_as_far_as_both_models_know_it() -> None:
    """A contact becomes too deep just after the sequence, and the models have different times of release."""
    newton, hard = hl.newton(too_deep_later()), hl.independent(too_deep_later())
    assert newton.outcome == "ok" and newton._core.t_first != hard._core.t_first
    known = newton._known_up_to(1.0)
    assert 0.0 < known < 1.0
    assert newton.plot().axes
    (ax,) = heights.heights(newton, hard).axes
    assert ax.lines
    scenes = storyboard.storyboard(newton, hard, 15)
    assert max(scene.times[-1] for scene in scenes) <= known
    for model in (newton, hard):
        for scene in scenes:
            z, _ = storyboard.gaps_at(model, scene.times)
            assert np.isfinite(z).all()


def test_of_very_many_contacts_some_are_drawn() -> None:
    ball = hl.Column([STEEL], [], 0.1, hl.LinearDashpot(stiffness=1e6, restitution=1.0))
    result = hl.newton(ball, until=500.0)
    assert len(result.contacts.pair) > forces.MAX_DRAWN
    assert f"{forces.MAX_DRAWN} of them drawn" in texts(result.plot())
    times, values = forces.force_curve(result, 0, 500.0)
    assert len(times) <= 202 * forces.MAX_DRAWN and values.max() > 0.0
    assert times[0] == 0.0 and times[-1] > 499.0


def test_the_end_of_one_ball_is_that_of_its_first_bounce() -> None:
    ball = hl.Column([STEEL], [], 0.1, hl.LinearDashpot(stiffness=1e6, restitution=0.7))
    result = hl.newton(ball, until=1.0)
    assert len(result.contacts.pair) > 1
    assert result.t_end == result.t_floor_end == result.contacts.end.values[0]


def test_a_tick_outside_a_log_axis_is_not_seen() -> None:
    """Test of the helper for legibility: such a tick is not drawn, however close it is to the end of the axis."""
    figure = Figure()
    ax = figure.add_subplot(xscale="log")
    ax.set_xticks([1e-13, 1e-12, 1.0], ["outside", "first", "last"])
    ax.set_xlim(1e-12, 1.0)
    seen = [text for text, _ in boxes(figure)]
    assert "first" in seen and "last" in seen and "outside" not in seen
