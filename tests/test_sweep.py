"""hl.sweep as its user sees it: axes, variables, codes, and the same numbers as the models of one column."""

import math
import re

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import hardlimit as hl
from hardlimit.sweep import VARIABLES
from hardlimit.sweep import chunks as tiling
from hardlimit.sweep.chunks import Tiles
from hardlimit.sweep.plan import Plan, make_plan

PAPER = hl.Column.paper()
SOFT = hl.Column.paper(law=hl.Viscoelastic(youngs_modulus=1e8, poisson_ratio=0.3, dissipative_time=1e-5))
#: Comes to rest after a long time: the slowest kind of point, some 0.1 ms.
SLOW = hl.Column.paper(law=hl.Viscoelastic(youngs_modulus=1e8, poisson_ratio=0.3, dissipative_time=0.015))
GRID = {"restitution": np.linspace(0.3, 1.0, 7), "gap": np.geomspace(1e-6, 1e-2, 5)}


def same_bits(a: xr.Dataset, b: xr.Dataset) -> bool:
    seen = [{name: (v.dims, v.values.tobytes()) for name, v in ds.items()} for ds in (a, b)]
    return seen[0] == seen[1]


def scalar(column: hl.Column, model: str) -> dict[str, float]:
    result = getattr(hl, model)(column)
    return {name: getattr(result, name) for name in VARIABLES if name != "outcome"}


# --- against the models of one column -----------------------------------------------------------------------


#: Masses and radii are powers of two: an effective mass then has the same bits in either order.
BALLS = [hl.Ball(0.125, mass=8.0), hl.Ball(0.0078125, mass=0.0078125)]


@pytest.mark.parametrize("model", ["newton", "independent"])
def test_viscoelastic_points_are_those_of_one_column(model: str) -> None:
    gaps, heights = np.array([0.0, 1e-5, 1e-3]), np.array([0.3, 0.6])
    column = hl.Column(BALLS, 0.0, 0.6, SOFT.laws[0])
    ds = hl.sweep(column, model=model, variables=list(VARIABLES), gap=gaps, height=heights)
    for gap in gaps:
        for height in heights:
            point = ds.sel(gap=gap, height=height)
            tolerance = 1e-8 if model == "newton" else 0.0  # a kernel of its own
            for name, value in scalar(hl.Column(BALLS, gap, height, SOFT.laws[0]), model).items():
                np.testing.assert_allclose(point[name], value, rtol=tolerance, err_msg=name)


@pytest.mark.parametrize("model", ["adiabatic", "independent"])
def test_linear_points_are_those_of_one_column(model: str) -> None:
    column = hl.Column(BALLS, 0.0, 0.6, PAPER.laws[0])
    ds = hl.sweep(column, model=model, variables=list(VARIABLES), **GRID)
    for restitution in GRID["restitution"]:
        law = hl.LinearDashpot(stiffness=5e7, restitution=restitution)
        for gap in GRID["gap"]:
            point = ds.sel(gap=gap, restitution=restitution)
            for name, value in scalar(hl.Column(BALLS, gap, 0.6, law), model).items():
                if model == "independent" or name == "n_contacts":
                    np.testing.assert_array_equal(point[name], value, err_msg=name)
                else:  # another kernel, see below
                    np.testing.assert_allclose(point[name], value, rtol=1e-9, atol=1e-11, err_msg=name)


def test_newton_agrees_with_one_column() -> None:
    """The kernel for maps orders its operations otherwise than the solver that records everything."""
    ds = hl.sweep(PAPER, **GRID)
    for restitution in GRID["restitution"]:
        for gap in GRID["gap"]:
            point = ds.sel(gap=gap, restitution=restitution)
            result = hl.newton(hl.Column.paper(restitution=restitution, gap=gap))
            assert point.n_contacts == result.n_contacts
            error = abs(point.relative_velocity - result.relative_velocity)
            assert error <= 1e-10 * PAPER.impact_speed
            assert abs(point.t_end - result.t_end) <= 1e-10 * result.t_end


# --- axes ---------------------------------------------------------------------------------------------------

SWEPT_ALONE = {
    "gap": ([1e-5, 1e-3], lambda v: hl.Column.paper(gap=v)),
    "radius_ratio": ([2.0, 30.0], lambda v: hl.Column.paper(radius_ratio=v)),
    "radius_1": ([0.05, 0.2], lambda v: hl.Column.paper(radius_1=v)),
    "radius_2": ([0.005, 0.03], lambda v: hl.Column.paper(radius_1=0.1, radius_2=v)),
    "density": ([500.0, 8000.0], lambda v: hl.Column.paper(density=v)),
    "height": ([0.2, 3.0], lambda v: hl.Column.paper(height=v)),
    "gravity": ([1.6, 25.0], lambda v: hl.Column.paper(gravity=v)),
    "stiffness": ([1e5, 1e9], lambda v: hl.Column.paper(stiffness=v)),
    "restitution": ([0.2, 0.9], lambda v: hl.Column.paper(restitution=v)),
    "damping": ([5.0, 200.0], lambda v: hl.Column.paper(law=hl.LinearDashpot(stiffness=5e7, damping=v))),
    "velocity": ([-1.0, 0.5], lambda v: with_balls(velocities=[v, v])),
    "velocity_1": ([-1.0, 0.5], lambda v: with_balls(velocities=[v, 0.0])),
    "velocity_2": ([-1.0, 0.5], lambda v: with_balls(velocities=[0.0, v])),
    "density_1": ([500.0, 8000.0], lambda v: with_balls({"density": v})),
    "density_2": ([500.0, 8000.0], lambda v: with_balls(upper={"density": v})),
    "mass_1": ([0.5, 50.0], lambda v: with_balls({"mass": v})),
    "mass_2": ([0.001, 0.1], lambda v: with_balls(upper={"mass": v})),
}


def with_balls(
    lower: dict | None = None, upper: dict | None = None, velocities: list[float] | float = 0.0
) -> hl.Column:
    """Fig. 2's column with other matter or velocities."""
    balls = [hl.Ball(0.1, **(lower or {"density": 840.0})), hl.Ball(0.01, **(upper or {"density": 840.0}))]
    return hl.Column(balls, 1e-4, 0.6, PAPER.laws[0], velocities)


@pytest.mark.parametrize("name", SWEPT_ALONE)
def test_every_parameter_can_be_swept(name: str) -> None:
    values, column = SWEPT_ALONE[name]
    ds = hl.sweep(PAPER, model="independent", **{name: values})
    assert ds[name].attrs["units"] and ds[name].attrs["long_name"]
    for i, value in enumerate(values):
        expected = hl.independent(column(value))
        assert ds.n_contacts[i] == expected.n_contacts
        assert float(ds.relative_velocity[i]) == expected.relative_velocity


def test_every_parameter_of_the_column_is_tried_above() -> None:
    with pytest.raises(ValueError, match="a sweep takes") as refused:
        hl.sweep(PAPER, colour=[1.0])
    offered = re.sub(r".*takes ", "", str(refused.value)).split(", ")
    assert set(offered) == SWEPT_ALONE.keys() - {"damping"}  # taken when it is named


def test_dimensions_are_in_the_order_given() -> None:
    ds = hl.sweep(PAPER, gap=[1e-4, 1e-3, 1e-2], height=0.5, restitution=[0.5, 0.6], gravity=[9.81])
    assert ds.n_contacts.dims == ("gap", "restitution", "gravity")
    assert ds.n_contacts.shape == (3, 2, 1)
    assert float(ds.height) == 0.5
    np.testing.assert_array_equal(ds.gap, [1e-4, 1e-3, 1e-2])


def test_nothing_swept_is_one_point() -> None:
    ds = hl.sweep(PAPER)
    assert ds.n_contacts.dims == ()
    assert int(ds.n_contacts) == hl.newton(PAPER).n_contacts


def test_names_that_share_a_dimension_make_a_list_of_points() -> None:
    restitution, gap = (xr.DataArray(GRID[n][:5], dims="point") for n in ("restitution", "gap"))
    points = hl.sweep(PAPER, restitution=restitution, gap=gap)
    grid = hl.sweep(PAPER, **GRID)
    assert points.n_contacts.dims == ("point",)
    assert set(points.coords) == {"restitution", "gap"}
    assert same_bits(points, grid.sel(restitution=restitution, gap=gap).transpose("point"))


def test_a_list_of_points_crosses_an_axis() -> None:
    restitution, gap = (xr.DataArray(GRID[n][:5], dims="point") for n in ("restitution", "gap"))
    crossed = hl.sweep(PAPER, restitution=restitution, height=[0.4, 0.6], gap=gap)
    assert crossed.n_contacts.dims == ("point", "height")
    alone = hl.sweep(PAPER, restitution=restitution, gap=gap)
    assert same_bits(crossed.sel(height=0.6), alone)


# --- variables and codes ------------------------------------------------------------------------------------


def test_only_the_variables_asked_for() -> None:
    ds = hl.sweep(PAPER, variables=["t_floor_end", "n_contacts"], **GRID)
    assert list(ds) == ["t_floor_end", "n_contacts"]
    assert same_bits(ds[["n_contacts"]], hl.sweep(PAPER, **GRID)[["n_contacts"]])
    assert list(hl.sweep(PAPER, gap=[1e-4])) == [name for name in VARIABLES if name != "t_floor_end"]


def test_types_and_units() -> None:
    ds = hl.sweep(PAPER, variables=list(VARIABLES), gap=[1e-4])
    for name, (dtype, unit, _) in VARIABLES.items():
        assert ds[name].dtype == dtype
        assert ds[name].attrs["units"] == unit
    assert ds.attrs["model"] == "newton" and ds.attrs["engine"] == "cpu"
    assert ds.attrs["hardlimit_version"] and ds.attrs["wall_time_s"] >= 0.0
    assert "0.6" in ds.attrs["column"]


def test_outcomes_are_flags_of_cf() -> None:
    """A point that cannot be is a value, not an exception: its neighbours are computed all the same."""
    ds = hl.sweep(PAPER, height=[0.05, 0.6], velocity=[0.0, 1.0], gravity=[0.0, 9.81])
    names = dict(zip(ds.outcome.flag_values.tolist(), ds.outcome.flag_meanings.split(), strict=True))
    assert names[0] == "ok"
    found = {names[code] for code in ds.outcome.values.ravel().tolist()}
    assert found == {"ok", "invalid", "never_lands"}
    assert bool((ds.outcome == 0).sel(height=0.6, gravity=9.81).all())
    assert bool(ds.relative_velocity.isnull().where(ds.outcome != 0, True).all())
    assert ds.outcome.sel(height=0.6, velocity=1.0, gravity=0.0) == list(names.values()).index("never_lands")


def test_counts_above_a_byte_widen_their_variable() -> None:
    """A tiny elastic ball close above a large one hits it hundreds of times while that one turns."""
    column = hl.Column.paper(restitution=1.0, radius_2=1e-4, radius_1=0.1, height=4.0)
    small = hl.sweep(column, gap=[1e-6])
    large = hl.sweep(column, gap=[1e-6, 1e-10])
    assert small.n_contacts.dtype == np.uint8
    assert large.n_contacts.dtype == np.uint32
    columns = [hl.Column(column.balls, gap, 4.0, column.laws[0]) for gap in (1e-6, 1e-10)]
    expected = [hl.newton(c).n_contacts for c in columns]
    assert large.n_contacts.values.tolist() == expected
    assert expected[0] == small.n_contacts[0] <= 255 < expected[1]


# --- the same bits, progress --------------------------------------------------------------------------------


@pytest.mark.parametrize("column", [PAPER, SOFT], ids=["linear", "viscoelastic"])
@pytest.mark.parametrize("threads", [1, 2, 3])
def test_threads_do_not_matter(column: hl.Column, threads: int) -> None:
    swept = {"gap": np.geomspace(1e-6, 1e-2, 37), "height": np.linspace(0.3, 0.7, 11)}
    assert same_bits(hl.sweep(column, threads=threads, **swept), hl.sweep(column, threads=1, **swept))


@pytest.mark.parametrize("column, more", [(PAPER, {}), (SOFT, {"impact_speed": 3.0})])
def test_the_order_of_the_axes_does_not_matter(column: hl.Column, more: dict[str, float]) -> None:
    """However the damping comes to a point: of its row, from a table of its axis, or one by one."""
    restitution, gap = np.linspace(0.3, 1, 61), np.geomspace(1e-6, 1e-2, 41)
    rows = hl.sweep(column, restitution=restitution, gap=gap, **more)
    assert same_bits(rows, hl.sweep(column, gap=gap, restitution=restitution, **more).transpose(*rows.dims))
    for j, h in enumerate(gap):
        assert same_bits(rows.isel(gap=j), hl.sweep(column, restitution=restitution, gap=h, **more))


@pytest.mark.parametrize("first, count", [(0, 35), (1, 34), (17, 3), (34, 1)])
def test_a_range_of_points_is_part_of_the_map(first: int, count: int) -> None:
    plan = make_plan(PAPER, "newton", None, GRID)
    whole, part = plan.compute(0, plan.size, 2), plan.compute(first, count, 1)
    for name in whole:
        assert whole[name][first : first + count].tobytes() == part[name].tobytes()


def test_progress_ends_with_all_points() -> None:
    told: list[tuple[int, int]] = []
    hl.sweep(
        SLOW, progress=lambda done, total: told.append((done, total)), gap=np.geomspace(1e-6, 1e-2, 3000)
    )
    assert told[-1] == (3000, 3000)
    assert len(told) > 2 and told == sorted(told)
    assert {total for _, total in told} == {3000}


def test_an_error_in_progress_ends_the_sweep() -> None:
    def fail(done: int, total: int) -> None:
        if done:
            raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        hl.sweep(SLOW, progress=fail, gap=np.geomspace(1e-6, 1e-2, 3000))


# --- tiles --------------------------------------------------------------------------------------------------


def plan_of_shape(shape: tuple[int, ...]) -> Plan:
    starts = {"gap": 1e-5, "restitution": 0.4, "height": 0.5, "gravity": 5.0}
    swept = {
        name: start * np.linspace(1, 2, n) for (name, start), n in zip(starts.items(), shape, strict=False)
    }
    return make_plan(PAPER, "independent", None, swept)


@given(st.lists(st.integers(1, 6), max_size=4).map(tuple), st.integers(1, 40))
def test_tiles_cover_a_map_once_and_in_order(shape: tuple[int, ...], most: int) -> None:
    tiles = Tiles(shape, tiling._block(shape, most))
    assert math.prod(tiles.block) <= most
    spans = [tiles.span(tile) for tile in range(len(tiles))]
    assert [first for first, _ in spans] == [sum(n for _, n in spans[:i]) for i in range(len(spans))]
    assert sum(n for _, n in spans) == math.prod(shape)
    points = np.arange(math.prod(shape)).reshape(shape)
    for tile, (first, count) in enumerate(spans):
        np.testing.assert_array_equal(points[tiles.box(tile)].ravel(), np.arange(first, first + count))


@pytest.mark.parametrize("shape", [(), (7,), (1, 7), (7, 1), (3, 4), (4, 4), (2, 1, 3, 1), (3, 3, 3)])
def test_a_tile_cut_out_is_the_same_tile(shape: tuple[int, ...]) -> None:
    plan = plan_of_shape(shape)
    tiles = Tiles(shape, tiling._block(shape, 4))
    for tile in range(len(tiles)):
        cut = tiles.cut(plan, tile)
        assert all(len(v) <= 4 for v in cut.values)
        there, here = cut.compute(0, cut.size, 1), plan.compute(*tiles.span(tile), 1)
        assert all(there[name].tobytes() == here[name].tobytes() for name in here)


# --- bad input ----------------------------------------------------------------------------------------------

BAD = {
    "model: got 'kepler'": {"model": "kepler"},
    "engine: got 'gpu'": {"engine": "gpu"},
    "scheduler: got 'tcp://a:1', must not be given": {"scheduler": "tcp://a:1"},
    "threads: got 0": {"threads": 0},
    "threads: got 1.5": {"threads": 1.5},
    "progress: got 3": {"progress": 3},
    "variables: got 'colour'": {"variables": ["colour"]},
    "variables: got none": {"variables": []},
    "colour: unknown": {"colour": [1.0]},
    "gap: got -1, must be >= 0": {"gap": [1e-3, -1.0]},
    "gap: got nan": {"gap": [1e-3, math.nan]},
    "gap: got an empty array": {"gap": []},
    "gap: got 2 dimensions": {"gap": np.ones((2, 2))},
    "gap: got 'wide'": {"gap": "wide"},
    "restitution: got 0, must be in (0, 1]": {"restitution": [0.0, 0.5]},
    "radius_ratio | radius_1: got both": {"radius_1": [0.1], "radius_ratio": [10.0]},
    "density | mass_1: got both": {"mass_1": [1.0], "density": [840.0]},
    "damping: unknown": {"damping": [1.0], "restitution": [0.5]},
    "gap: got 3 values, must be 2 like dimension 'p'": {
        "restitution": xr.DataArray([0.5, 0.6], dims="p"),
        "gap": xr.DataArray([1e-4] * 3, dims="p"),
    },
    "tolerance: got 1e-09, must not be given unless the law is viscoelastic": {"tolerance": 1e-9},
    "gap: got dimension 'n_contacts'": {"gap": xr.DataArray([1e-4, 1e-3], dims="n_contacts")},
    "restitution: got dimension 'gap'": {
        "restitution": xr.DataArray([0.5, 0.6], dims="gap"),
        "gap": xr.DataArray([1e-4] * 2, dims="restitution"),
    },
}


@pytest.mark.parametrize("message", BAD)
def test_bad_input_is_one_clear_line(message: str) -> None:
    with pytest.raises(ValueError) as refused:
        hl.sweep(PAPER, **BAD[message])
    assert str(refused.value).startswith(message)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    "column", [None, hl.Column.cradle([hl.Ball(0.1, mass=1.0)] * 2, [1.0, 0.0], PAPER.laws[0])]
)
def test_only_two_balls_on_a_floor(column: object) -> None:
    with pytest.raises(ValueError, match="column: must be two balls on a floor"):
        hl.sweep(column, gap=[1e-4])


@pytest.mark.parametrize("tolerance", [1e-14, 1e-5, math.nan, True, "fine"])
def test_tolerance_has_a_range(tolerance: object) -> None:
    with pytest.raises(ValueError, match=r"tolerance: got .*, must be") as refused:
        hl.sweep(SOFT, tolerance=tolerance, gap=[1e-4])
    assert "\n" not in str(refused.value)


def test_the_independent_model_takes_no_tolerance() -> None:
    with pytest.raises(ValueError, match="tolerance: got 1e-09, must not be given"):
        hl.sweep(SOFT, model="independent", tolerance=1e-9, gap=[1e-4])


def test_the_adiabatic_model_needs_the_linear_law() -> None:
    with pytest.raises(ValueError, match="model: got 'adiabatic'"):
        hl.sweep(SOFT, model="adiabatic", gap=[1e-4])
