"""The vector kernel of the linear law: the same bits for every instruction set, and the scalar solver's results."""

import hashlib
import math

import numpy as np
import pytest
import xarray as xr

import hardlimit as hl
from conftest import slow
from hardlimit import _core
from hardlimit.sweep.plan import MODELS, make_plan
from hardlimit.sweep.variables import OF_POINT

Results = dict[str, np.ndarray]


def random_list(n: int, seed: int) -> dict[str, xr.DataArray]:
    """Independent points: from overdamped to nearly elastic, R1/R2 from 0.3 to 30, k over four decades."""
    random = np.random.default_rng(seed)
    values = {
        "restitution": random.uniform(0.05, 1.0, n),
        "radius_ratio": 0.3 * 100.0 ** random.random(n),
        "gap": 1e-8 * 1e7 ** random.random(n),
        "stiffness": 5e5 * 1e4 ** random.random(n),
    }
    return {name: xr.DataArray(value, dims="point") for name, value in values.items()}


def compute(
    swept: dict[str, xr.DataArray],
    instruction_set: str,
    threads: int = 1,
    model: str = "newton",
    column: hl.Column | None = None,
    tolerance: float | None = None,
) -> Results:
    """All variables of a sweep; ``"scalar"`` solves each point by the solver of single columns."""
    plan = make_plan(column or hl.Column.paper(), model, list(OF_POINT), swept, tolerance)
    out: Results = {name: np.empty(plan.size, OF_POINT[name].dtype) for name in plan.variables}
    where = (*plan.densities, plan.restitution_at, list(plan.values), list(plan.strides))
    how = (0, plan.size, threads, plan.tolerance or math.nan, out, None, instruction_set)
    assert not _core.run_map(plan.law, MODELS.index(model), plan.alternative, *where, *how)
    return out


def digest(results: Results) -> str:
    return hashlib.sha256(b"".join(results[name].tobytes() for name in OF_POINT)).hexdigest()


@pytest.mark.parametrize(
    ("model", "points"),
    [("newton", 5_000), ("adiabatic", 5_000), slow("newton", 30_000), slow("adiabatic", 10_000)],
)
def test_same_bits_for_every_instruction_set_and_number_of_threads(model: str, points: int) -> None:
    swept = random_list(points, 1)
    sets = _core.instruction_sets()
    expected = digest(compute(swept, sets[0], model=model))
    for instruction_set in sets[1:]:
        assert digest(compute(swept, instruction_set, model=model)) == expected, instruction_set
    some = {name: values[:10_000] for name, values in swept.items()}  # some ten batches for each thread
    expected = digest(compute(some, sets[0], model=model))
    for threads in (2, 3):
        assert digest(compute(some, sets[0], threads, model)) == expected, threads


def test_points_of_a_list_may_come_in_any_order() -> None:
    """Those with monotonic parameters are solved as they come, others in an order of their own."""
    n = 20_000  # two orders
    line = {"restitution": np.linspace(0.3, 1.0, n), "gap": np.geomspace(1e-6, 1e-2, n)}
    shuffled = np.random.default_rng(5).permutation(n)
    as_it_is, mixed = (
        compute({name: xr.DataArray(v[at], dims="point") for name, v in line.items()}, "auto")
        for at in (np.arange(n), shuffled)
    )
    for name in OF_POINT:
        assert as_it_is[name][shuffled].tobytes() == mixed[name].tobytes(), name


def check_against_scalar(
    swept: dict[str, xr.DataArray], model: str = "newton", column: hl.Column | None = None
) -> None:
    kernel, scalar = (compute(swept, kind, 2, model, column) for kind in ("auto", "scalar"))
    np.testing.assert_array_equal(kernel["n_contacts"], scalar["n_contacts"])
    np.testing.assert_array_equal(kernel["outcome"], scalar["outcome"])
    ratio = swept.get("radius_ratio")
    speed = column.impact_speed if ratio is None else np.sqrt(2 * 9.81 * (0.6 - 0.01 * ratio.values))
    for name in ("relative_velocity", "separation_velocity"):
        assert (np.isnan(kernel[name]) == np.isnan(scalar[name])).all(), name
        error = np.abs(kernel[name] - scalar[name]) / speed
        assert not np.nanmax(error, initial=0.0) > 1e-10, name
    np.testing.assert_allclose(kernel["t_end"], scalar["t_end"], rtol=1e-6)


@pytest.mark.parametrize("model", ["newton", "adiabatic"])
@pytest.mark.parametrize("seed", [*range(8), *(slow(seed) for seed in range(8, 30))])
def test_any_masses_and_stiffnesses(model: str, seed: int) -> None:
    """Either contact may be the stiffer one, and either ball the heavier, by many orders of magnitude."""
    random = np.random.default_rng(seed)
    balls = [hl.Ball(0.01, mass=10.0 ** random.uniform(-6, 1)) for _ in range(2)]
    laws = [hl.LinearDashpot(stiffness=10.0 ** random.uniform(4, 8), restitution=0.7) for _ in range(2)]
    column = hl.Column(balls, gaps=1e-4, height=0.6, law=laws)
    values = {"restitution": random.uniform(0.3, 1.0, 150), "gap": 10.0 ** random.uniform(-7, -2, 150)}
    check_against_scalar({k: xr.DataArray(v, dims="point") for k, v in values.items()}, model, column)


def test_results_are_those_of_the_scalar_solver() -> None:
    check_against_scalar(random_list(20_000, 2))


@pytest.mark.slow
def test_a_million_results_are_those_of_the_scalar_solver() -> None:
    check_against_scalar(random_list(1_000_000, 3))
