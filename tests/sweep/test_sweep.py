"""hl.sweep: axes, variables, codes, and the same numbers as the models of one column."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import hardlimit as hl
from conftest import draws, refusal
from hardlimit.contact.contact import Law
from hardlimit.sweep.chunks import Chunks
from hardlimit.sweep.plan import Plan, make_plan
from hardlimit.sweep.variables import OF_POINT, default_variables

PAPER = hl.Column.paper()
SOFT = hl.Column.paper(law=hl.Viscoelastic(youngs_modulus=1e8, poisson_ratio=0.3, dissipative_time=1e-5))
#: Comes to rest after a long time: a slow kind of point, about 0.4 ms.
SLOW = hl.Column.paper(law=hl.Viscoelastic(youngs_modulus=1e8, poisson_ratio=0.3, dissipative_time=0.007))
GRID = {"restitution": np.linspace(0.3, 1.0, 7), "gap": np.geomspace(1e-6, 1e-2, 5)}


def same_bits(a: xr.Dataset, b: xr.Dataset) -> bool:
    seen = [{name: (v.dims, v.values.tobytes()) for name, v in ds.items()} for ds in (a, b)]
    return seen[0] == seen[1]


def scalar(column: hl.Column, model: str) -> dict[str, float]:
    result = getattr(hl, model)(column)
    return {name: getattr(result, name) for name in OF_POINT if name != "outcome"}


# --- against the models of one column -----------------------------------------------------------------------


#: Masses and radii are powers of two: an effective mass then has the same bits in either order.
BALLS = [hl.Ball(0.125, mass=8.0), hl.Ball(0.0078125, mass=0.0078125)]


@pytest.mark.parametrize("model", ["newton", "independent"])
def test_viscoelastic_points_are_those_of_one_column(model: str) -> None:
    gaps, heights = np.array([0.0, 1e-5, 1e-3]), np.array([0.3, 0.6])
    column = hl.Column(BALLS, 0.0, 0.6, SOFT.laws[0])
    ds = hl.sweep(column, model=model, variables=list(OF_POINT), gap=gaps, height=heights)
    for gap in gaps:
        for height in heights:
            point = ds.sel(gap=gap, height=height)
            tolerance = 1e-8 if model == "newton" else 0.0  # a kernel of its own
            for name, value in scalar(hl.Column(BALLS, gap, height, SOFT.laws[0]), model).items():
                np.testing.assert_allclose(point[name], value, rtol=tolerance, err_msg=name)


@pytest.mark.parametrize("model", ["newton", "adiabatic", "independent"])
def test_linear_points_are_those_of_one_column(model: str) -> None:
    column = hl.Column(BALLS, 0.0, 0.6, PAPER.laws[0])
    ds = hl.sweep(column, model=model, variables=list(OF_POINT), **GRID)
    for restitution in GRID["restitution"]:
        law = hl.LinearDashpot(stiffness=5e7, restitution=restitution)
        for gap in GRID["gap"]:
            point = ds.sel(gap=gap, restitution=restitution)
            for name, value in scalar(hl.Column(BALLS, gap, 0.6, law), model).items():
                if model == "independent" or name == "n_contacts":
                    np.testing.assert_array_equal(point[name], value, err_msg=name)
                else:  # the vector kernel orders its operations differently
                    np.testing.assert_allclose(point[name], value, rtol=1e-9, atol=1e-11, err_msg=name)


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
    "mass": ([0.001, 0.1], lambda v: with_balls({"mass": v}, {"mass": v})),
    "radius": ([0.05, 0.2], lambda v: hl.Column.paper(radius_1=v, radius_2=v)),
    "restitution_floor": ([0.2, 0.9], lambda v: with_laws({"restitution": v})),
    "restitution_pair_1": ([0.2, 0.9], lambda v: with_laws(pair={"restitution": v})),
    "stiffness_floor": ([1e5, 1e9], lambda v: with_laws({"stiffness": v})),
    "stiffness_pair_1": ([1e5, 1e9], lambda v: with_laws(pair={"stiffness": v})),
}


def with_balls(
    lower: dict | None = None, upper: dict | None = None, velocities: list[float] | float = 0.0
) -> hl.Column:
    """Fig. 2's column with other masses or velocities."""
    balls = [hl.Ball(0.1, **(lower or {"density": 840.0})), hl.Ball(0.01, **(upper or {"density": 840.0}))]
    return hl.Column(balls, 1e-4, 0.6, PAPER.laws[0], velocities)


def with_laws(floor: dict | None = None, pair: dict | None = None) -> hl.Column:
    """Fig. 2's column with a different law for one contact."""
    laws = [PAPER.laws[0].replace(**changes) for changes in (floor or {}, pair or {})]
    return hl.Column(PAPER.balls, 1e-4, 0.6, laws)


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
    assert list(hl.sweep(PAPER, gap=[1e-4])) == [name for name in OF_POINT if name != "t_floor_end"]


def test_types_and_units() -> None:
    ds = hl.sweep(PAPER, variables=list(OF_POINT), gap=[1e-4])
    for name, variable in OF_POINT.items():
        assert ds[name].dtype == variable.dtype
        assert ds[name].attrs["units"] == variable.unit
    assert ds.attrs["model"] == "newton" and ds.attrs["engine"] == "cpu"
    assert ds.attrs["hardlimit_version"] and ds.attrs["wall_time_s"] >= 0.0
    assert "0.6" in ds.attrs["column"]


def test_outcomes_are_flags_of_cf() -> None:
    """An invalid point is a value, not an exception; its neighbours are computed."""
    ds = hl.sweep(PAPER, height=[0.05, 0.6], velocity=[0.0, 1.0], gravity=[0.0, 9.81])
    names = dict(zip(ds.outcome.flag_values.tolist(), ds.outcome.flag_meanings.split(), strict=True))
    assert names[0] == "ok"
    outcomes = {names[code] for code in ds.outcome.values.ravel().tolist()}
    assert outcomes == {"ok", "invalid", "never_lands"}
    assert bool((ds.outcome == 0).sel(height=0.6, gravity=9.81).all())
    assert bool(ds.relative_velocity.isnull().where(ds.outcome != 0, True).all())
    assert ds.outcome.sel(height=0.6, velocity=1.0, gravity=0.0) == list(names.values()).index("never_lands")


def test_counts_above_a_byte_widen_their_variable() -> None:
    """A tiny elastic ball close above a large one hits it hundreds of times while it reverses."""
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
def test_results_do_not_depend_on_threads(column: hl.Column, threads: int) -> None:
    swept = {"gap": np.geomspace(1e-6, 1e-2, 37), "height": np.linspace(0.3, 0.7, 11)}
    assert same_bits(hl.sweep(column, threads=threads, **swept), hl.sweep(column, threads=1, **swept))


@pytest.mark.parametrize("column, more", [(PAPER, {}), (SOFT, {"impact_speed": 3.0})])
def test_results_do_not_depend_on_the_order_of_the_axes(column: hl.Column, more: dict[str, float]) -> None:
    """The damping of a point comes from its row, from a table of its axis, or is computed."""
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


@pytest.mark.slow
def test_progress_ends_with_all_points() -> None:
    told: list[tuple[int, int]] = []
    hl.sweep(SLOW, progress=lambda *args: told.append(args), gap=np.geomspace(1e-6, 1e-2, 1500))
    assert told[-1] == (1500, 1500)
    assert len(told) > 2 and told == sorted(told)
    assert {total for _, total in told} == {1500}


def test_an_error_in_progress_ends_the_sweep() -> None:
    def fail(done: int, total: int) -> None:
        if done:
            raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        hl.sweep(SLOW, progress=fail, gap=np.geomspace(1e-6, 1e-2, 1500))


# --- chunks -------------------------------------------------------------------------------------------------


def plan_of_shape(shape: tuple[int, ...]) -> Plan:
    starts = {"gap": 1e-5, "restitution": 0.4, "height": 0.5, "gravity": 5.0}
    sizes = zip(starts.items(), shape, strict=False)
    swept = {name: start * np.linspace(1, 2, n) for (name, start), n in sizes}
    return make_plan(PAPER, "independent", None, swept)


@draws(100)
@given(st.lists(st.integers(1, 6), max_size=4).map(tuple), st.integers(1, 40))
def test_chunks_cover_a_map_once_and_in_order(shape: tuple[int, ...], most: int) -> None:
    chunks = Chunks.within(shape, most)
    assert math.prod(chunks.box_shape) <= most
    spans = [chunks.span(chunk) for chunk in range(len(chunks))]
    assert [first for first, _ in spans] == [sum(n for _, n in spans[:i]) for i in range(len(spans))]
    assert sum(n for _, n in spans) == math.prod(shape)
    points = np.arange(math.prod(shape)).reshape(shape)
    for chunk, (first, count) in enumerate(spans):
        np.testing.assert_array_equal(points[chunks.box(chunk)].ravel(), np.arange(first, first + count))


@pytest.mark.parametrize("shape", [(), (7,), (1, 7), (7, 1), (3, 4), (4, 4), (2, 1, 3, 1), (3, 3, 3)])
def test_a_part_of_a_plan_computes_the_same(shape: tuple[int, ...]) -> None:
    plan = plan_of_shape(shape)
    chunks = Chunks.within(shape, 4)
    for chunk in range(len(chunks)):
        part = plan.part(chunks.box(chunk))
        assert all(len(v) <= 4 for v in part.values)
        there, here = part.compute(0, part.size, 1), plan.compute(*chunks.span(chunk), 1)
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
    "tolerance: got 1e-09, must not be given unless the model is newton": {"tolerance": 1e-9},
    "gap: got dimension 'n_contacts'": {"gap": xr.DataArray([1e-4, 1e-3], dims="n_contacts")},
    "restitution: got dimension 'gap'": {
        "restitution": xr.DataArray([0.5, 0.6], dims="gap"),
        "gap": xr.DataArray([1e-4] * 2, dims="restitution"),
    },
}


@pytest.mark.parametrize("message", BAD)
def test_bad_input_is_one_clear_line(message: str) -> None:
    assert refusal(lambda: hl.sweep(PAPER, **BAD[message])).startswith(message)


@pytest.mark.parametrize(
    "column", [None, hl.Column.cradle([hl.Ball(0.1, mass=1.0)] * 2, [1.0, 0.0], PAPER.laws[0])]
)
def test_only_columns_on_a_floor(column: object) -> None:
    with pytest.raises(ValueError, match=r"column: got .*, must be a column of balls on a floor"):
        hl.sweep(column, gap=[1e-4])


@pytest.mark.parametrize("tolerance", [1e-14, 1e-5, math.nan, True, "fine"])
def test_tolerance_has_a_range(tolerance: object) -> None:
    refused = refusal(lambda: hl.sweep(SOFT, tolerance=tolerance, gap=[1e-4]))
    assert re.match(r"tolerance: got .*, must be", refused)


def test_models_that_do_not_fit() -> None:
    refused = refusal(lambda: hl.sweep(SOFT, model="independent", tolerance=1e-9, gap=[1e-4]))
    assert refused.startswith("tolerance: got 1e-09, must not be given")
    assert refusal(lambda: hl.sweep(SOFT, "adiabatic", gap=[1e-4])).startswith("model: got 'adiabatic'")


# --- any number of balls, values of each ball ---------------------------------------------------------------


def random_law(random: np.random.Generator, kind: str) -> Law:
    restitution = float(random.uniform(0.3, 1.0))
    if kind == "linear":
        return hl.LinearDashpot(stiffness=float(10 ** random.uniform(6, 8)), restitution=restitution)
    if kind == "tsuji":
        return hl.Tsuji(elastic_prefactor=float(10 ** random.uniform(7, 9)), restitution=restitution)
    modulus, time = float(10 ** random.uniform(7, 9)), float(10 ** random.uniform(-7, -4))
    return hl.Viscoelastic(youngs_modulus=modulus, poisson_ratio=0.3, dissipative_time=time)


def random_column(random: np.random.Generator, balls: int, kind: str) -> hl.Column:
    """From touching to far apart, at rest or thrown, with a different law for each contact."""
    solids = []
    for _ in range(balls):
        radius = float(10 ** random.uniform(-2.3, -1))
        matter = (
            {"density": float(random.uniform(300, 8000))} if random.random() < 0.5 else {"mass": radius**2}
        )
        solids.append(hl.Ball(radius, **matter))
    gaps = [float(random.choice([0.0, 10 ** random.uniform(-6, -2)])) for _ in range(balls - 1)]
    thrown = [float(v) for v in random.uniform(-0.5, 0.2, balls)] if random.random() < 0.5 else 0.0
    laws = [random_law(random, kind) for _ in range(balls)]
    return hl.Column(solids, gaps, solids[0].radius + float(random.uniform(0.05, 0.5)), laws, thrown)


def same_numbers(point: xr.Dataset, result: hl.Result) -> None:
    """A point of a sweep has the bits of the solver of one column."""
    assert point.outcome == result.outcome_code
    assert point.n_contacts == result.n_contacts
    np.testing.assert_array_equal(point.t_end, result.t_end)
    np.testing.assert_array_equal(point.t_floor_end, result.t_floor_end)
    np.testing.assert_array_equal(point.rebound_height, result.rebound_heights)
    np.testing.assert_array_equal(point.final_velocity, result.final_velocities)


OF_ANY_COLUMN = ["n_contacts", "t_end", "t_floor_end", "outcome", "rebound_height", "final_velocity"]


@pytest.mark.parametrize("model", ["newton", "independent"])
@pytest.mark.parametrize("kind", ["linear", "viscoelastic", "tsuji"])
@pytest.mark.parametrize("balls", [1, 3, 4])
def test_a_point_of_any_column_is_that_column(balls: int, kind: str, model: str) -> None:
    random = np.random.default_rng([balls, len(kind), len(model)])
    for _ in range(6):
        column = random_column(random, balls, kind)
        ds = hl.sweep(column, model=model, variables=OF_ANY_COLUMN)
        assert ds.rebound_height.dims == ("ball",)
        same_numbers(ds, getattr(hl, model)(column))


@pytest.mark.parametrize(
    "kind, model",
    [
        *(("linear", model) for model in ("newton", "adiabatic", "independent")),
        *(("viscoelastic", model) for model in ("newton", "independent")),
        ("tsuji", "newton"),
    ],
)
def test_the_values_of_each_of_two_balls_are_those_of_the_column(kind: str, model: str) -> None:
    random = np.random.default_rng([2, len(kind), len(model)])
    for _ in range(10):
        column = random_column(random, 2, kind)
        ds = hl.sweep(column, model=model, variables=["rebound_height", "final_velocity"])
        result = getattr(hl, model)(column)
        np.testing.assert_array_equal(ds.rebound_height, result.rebound_heights)
        np.testing.assert_array_equal(ds.final_velocity, result.final_velocities)


def three_balls(**changes: float) -> hl.Column:
    """A column of three balls with any of its numbers changed."""
    value = {"gap_1": 1e-4, "gap_2": 2e-4, "height": 0.4, "gravity": 9.81} | changes
    balls = []
    for i, radius in enumerate((0.05, 0.03, 0.01), 1):
        size = value.get(f"radius_{i}", value.get("radius", radius))
        mass = value.get(f"mass_{i}", value.get("mass"))
        density = value.get(f"density_{i}", value.get("density", 840.0))
        balls.append(hl.Ball(size, mass=mass) if mass is not None else hl.Ball(size, density=density))
    velocities = [value.get(f"velocity_{i}", value.get("velocity", 0.0)) for i in (1, 2, 3)]
    gaps = [value.get("gap", value[f"gap_{i}"]) for i in (1, 2)]
    laws = [
        hl.LinearDashpot(
            stiffness=value.get(f"stiffness_{at}", value.get("stiffness", 1e6)),
            restitution=value.get(f"restitution_{at}", value.get("restitution", 0.8)),
        )
        for at in ("floor", "pair_1", "pair_2")
    ]
    return hl.Column(balls, gaps, value["height"], laws, velocities, value["gravity"])


OF_THREE_BALLS = {
    "gap": 1e-3,
    "radius": 0.02,
    "density": 2000.0,
    "mass": 0.1,
    "velocity": -0.3,
    "height": 0.2,
    "gravity": 1.62,
    "stiffness": 1e7,
    "restitution": 0.5,
    **{f"gap_{i}": 1e-3 for i in (1, 2)},
    **{
        f"{name}_{i}": v for i in (1, 2, 3) for name, v in (("radius", 0.02), ("density", 2e3), ("mass", 0.1))
    },
    **{f"velocity_{i}": -0.3 for i in (1, 2, 3)},
    **{f"stiffness_{at}": 1e7 for at in ("floor", "pair_1", "pair_2")},
    **{f"restitution_{at}": 0.5 for at in ("floor", "pair_1", "pair_2")},
}


@pytest.mark.parametrize("model", ["newton", "independent"])
@pytest.mark.parametrize("name", OF_THREE_BALLS)
def test_every_parameter_of_three_balls_can_be_swept(name: str, model: str) -> None:
    value = OF_THREE_BALLS[name]
    ds = hl.sweep(three_balls(), model=model, variables=OF_ANY_COLUMN, **{name: [value, 2 * value]})
    for i, v in enumerate([value, 2 * value]):
        same_numbers(ds.isel({name: i}), getattr(hl, model)(three_balls(**{name: v})))


def test_every_parameter_of_three_balls_is_tried_above() -> None:
    with pytest.raises(ValueError, match="a sweep takes") as refused:
        hl.sweep(three_balls(), radius_ratio=[10.0])
    assert set(re.sub(r".*takes ", "", str(refused.value)).split(", ")) == OF_THREE_BALLS.keys()


def test_other_columns_than_two_balls_have_variables_of_their_own() -> None:
    ds = hl.sweep(three_balls(), height=[0.3, 0.4], gap_2=[1e-4, 1e-3, 1e-2])
    assert tuple(ds) == default_variables(3) and "rebound_height" in ds and "separation_velocity" not in ds
    assert ds.rebound_height.dims == ("height", "gap_2", "ball")
    assert ds.ball.values.tolist() == [1, 2, 3]
    assert bool((ds.outcome == 0).all())
    refused = refusal(lambda: hl.sweep(three_balls(), variables=["relative_velocity"]))
    assert refused.startswith("variables: got 'relative_velocity' for 3 balls, must be among n_contacts, ")
    refused = refusal(lambda: hl.sweep(three_balls(), model="adiabatic"))
    assert refused.startswith("model: got 'adiabatic', must be newton or independent unless")


def test_more_variables_do_not_change_the_others() -> None:
    alone = hl.sweep(PAPER, **GRID)
    more = hl.sweep(PAPER, variables=[*alone, "rebound_height"], **GRID)
    assert same_bits(alone, more[list(alone)])
    assert bool((more.rebound_height.sel(ball=2) > more.rebound_height.sel(ball=1)).all())


@pytest.mark.parametrize("threads", [1, 3])
def test_many_columns_do_not_depend_on_threads_or_range(threads: int) -> None:
    plan = make_plan(three_balls(), "newton", OF_ANY_COLUMN, {"gap_2": np.geomspace(1e-6, 1e-2, 70)})
    whole, part = plan.compute(0, 70, threads), plan.compute(11, 40, 1)
    for name in whole:
        assert whole[name][11:51].tobytes() == part[name].tobytes()


# --- tolerance ----------------------------------------------------------------------------------------------


def test_the_general_solver_takes_a_tolerance() -> None:
    fine, coarse = (hl.sweep(three_balls(), tolerance=t).rebound_height for t in (None, 1e-4))
    np.testing.assert_array_equal(fine, hl.newton(three_balls()).rebound_heights)
    np.testing.assert_array_equal(coarse, hl.newton(three_balls(), tolerance=1e-4).rebound_heights)
    assert 1e-9 < float(abs(coarse - fine).max()) < 1e-3


def test_a_law_without_a_kernel_takes_a_tolerance() -> None:
    column = hl.Column.paper(law=hl.Tsuji(elastic_prefactor=1e8, restitution=0.7))
    fine, coarse = (hl.sweep(column, tolerance=t).relative_velocity for t in (None, 1e-4))
    assert fine == hl.newton(column).relative_velocity
    assert coarse == hl.newton(column, tolerance=1e-4).relative_velocity
    assert 1e-12 < abs(float(coarse - fine)) < 1e-3


# --- labels -------------------------------------------------------------------------------------------------


def labelled(values: list[float], labels: list[float] | None) -> xr.DataArray:
    return xr.DataArray(values, dims="p", coords=None if labels is None else {"p": labels})


def test_arrays_that_share_a_dimension_must_have_the_same_labels() -> None:
    gap, restitution = labelled([1e-4, 1e-3], [1.0, 2.0]), labelled([0.5, 0.6], [2.0, 1.0])
    refused = refusal(lambda: hl.sweep(PAPER, gap=gap, restitution=restitution))
    assert refused.startswith("restitution: got other coordinates, must have the coordinates of gap")
    for other in (labelled([0.5, 0.6], [1.0, 2.0]), labelled([0.5, 0.6], None)):
        ds = hl.sweep(PAPER, gap=gap, restitution=other)
        assert ds.p.values.tolist() == [1.0, 2.0]


@pytest.mark.parametrize(
    "axis",
    ["0.5", ["0.5"], [True], np.array([True]), np.array(["2020-01-01"], "M8[D]"), [1e-4 + 0j], [None],
     np.ma.masked_array([1e-4, 1e-3], [False, True])],
)  # fmt: skip
def test_an_axis_is_numbers(axis: object) -> None:
    with pytest.raises(
        ValueError, match=r"gap: got .*, must be a number or a one-dimensional array of numbers"
    ):
        hl.sweep(PAPER, gap=axis)


# --- what a GPU does not compute ----------------------------------------------------------------------------

NOT_FOR_A_GPU = {
    "unless two balls are swept": (three_balls(), {}),
    "for the law viscoelastic and the model newton": (SOFT, {}),
    "for the law linear and the model independent": (PAPER, {"model": "independent"}),
    "for rebound_height, final_velocity": (PAPER, {"variables": ["n_contacts", "rebound_height"]}),
}


@pytest.mark.parametrize("message", NOT_FOR_A_GPU)
def test_a_gpu_refuses_before_anything_is_written(tmp_path: Path, message: str) -> None:
    column, options = NOT_FOR_A_GPU[message]
    with pytest.raises(ValueError, match=f"engine: got 'cuda', must be 'cpu' or 'dask' {message}"):
        hl.sweep(column, engine="cuda", store=tmp_path / "map.zarr", gap=[1e-4], **options)
    assert list(tmp_path.iterdir()) == []


# --- too much -----------------------------------------------------------------------------------------------


def test_more_points_than_there_is_room_for_are_refused_at_once(tmp_path: Path) -> None:
    """1e16 points, without allocating an array."""
    axis = np.geomspace(1e-6, 1e-2, 10_000)
    swept = {"gap": axis, "height": 0.5 + axis, "gravity": 9.0 + axis, "velocity_2": axis}
    with pytest.raises(ValueError, match=r"points: got 1e\+16, 420 PB of results") as no:
        hl.sweep(PAPER, **swept)
    assert "must fit in the" in str(no.value) and "\n" not in str(no.value)
    with pytest.raises(
        ValueError, match=r"points: got 1e\+16, .* of results, must be <= 2\.\de\+12 in one store"
    ):
        hl.sweep(PAPER, store=tmp_path / "map.zarr", **swept)
    assert list(tmp_path.iterdir()) == []
