"""Sweeps under the viscoelastic law: the numbers of the general solver, the same bits on every machine."""

import numpy as np
import pytest
import test_linear_kernel
import xarray as xr
from numpy.typing import NDArray

import hardlimit as hl
from conftest import number, table
from hardlimit import _core

Results = dict[str, NDArray]


def compute(
    column: hl.Column, instruction_set: str, tolerance: float | None = None, **swept: NDArray | xr.DataArray
) -> Results:
    return test_linear_kernel.compute(swept, instruction_set, column=column, tolerance=tolerance)


def points(**values: NDArray) -> dict[str, xr.DataArray]:
    return {name: xr.DataArray(v, dims="point") for name, v in values.items()}


def soft(**damping: float) -> hl.Column:
    damping = damping or {"restitution": 0.7, "impact_speed": 3.0}
    return hl.Column.paper(law=hl.Viscoelastic(youngs_modulus=5e7, poisson_ratio=0.45, **damping))


def assert_agree(kernel: Results, general: Results, speed: float, within: float = 1e-8) -> None:
    for name in ("n_contacts", "outcome"):
        np.testing.assert_array_equal(kernel[name], general[name], err_msg=name)
    for name in ("relative_velocity", "separation_velocity"):
        np.testing.assert_allclose(kernel[name], general[name], rtol=0.0, atol=within * speed, err_msg=name)
    for name in ("t_end", "t_floor_end"):
        np.testing.assert_allclose(kernel[name], general[name], rtol=10.0 * within, err_msg=name)


# --- against the reference and the general solver -----------------------------------------------------------


@pytest.mark.parametrize("quantity", ["restitution", "dissipative_time"])
def test_reference(quantity: str) -> None:
    rows = [
        row
        for row in table("two_ball_viscoelastic")
        if row[f"{quantity}{'_s' * (quantity != 'restitution')}"]
    ]
    assert len(rows) > 10
    units = {"radius_1": "_m", "radius_2": "_m", "youngs_modulus": "_Pa", "density": "_kg_m3", "gap": "_m"}
    units |= {"poisson_ratio": "", quantity: "" if quantity == "restitution" else "_s"}
    values = {name: np.array([float(row[name + unit]) for row in rows]) for name, unit in units.items()}
    speed = np.array([float(row["impact_speed_m_s"]) for row in rows])
    values["height"] = values["radius_1"] + speed**2 / (2.0 * 9.81)
    if quantity == "restitution":
        values["impact_speed"] = np.full(len(rows), 3.0)
    column = soft() if quantity == "restitution" else soft(dissipative_time=0.0)
    values_of = compute(column, "auto", **points(**values))
    for i, row in enumerate(rows):
        assert values_of["n_contacts"][i] == int(row["n_contacts"]), i
        for name, at in (("relative_velocity", "end"), ("separation_velocity", "separation")):
            expected = number(row[f"relative_velocity_{at}_m_s"])
            assert values_of[name][i] == pytest.approx(expected, rel=0.0, abs=1e-8 * speed[i], nan_ok=True), (
                i,
                name,
            )
        assert values_of["t_end"][i] == pytest.approx(number(row["t_end_s"]), rel=1e-8, nan_ok=True)


N = 120
RNG = np.random.default_rng(20)


def uniform(low: float, high: float) -> NDArray:
    return RNG.uniform(low, high, N)


def spread(low: float, high: float) -> NDArray:
    return np.exp(RNG.uniform(np.log(low), np.log(high), N))


GAPS, LOWER = spread(1e-9, 1e-2), spread(0.003, 0.25)
LISTS = {
    "stiffness and size": (
        soft(),
        {"restitution": uniform(0.2, 1), "youngs_modulus": spread(1e6, 1e11), "gap": GAPS, "radius_1": LOWER},
    ),
    "released with velocities": (
        soft(),
        {
            "restitution": uniform(0.2, 1),
            "gap": GAPS,
            "velocity_1": uniform(-1, 2),
            "velocity_2": uniform(-1, 1),
        },
    ),
    "touching": (soft(), {"restitution": uniform(0.2, 1), "gap": np.zeros(N), "radius_1": LOWER}),
    "touching with velocity": (
        soft(),
        {"restitution": uniform(0.2, 1), "gap": np.zeros(N), "velocity_2": uniform(-0.1, 0.1)},
    ),
    "elastic by restitution": (soft(), {"restitution": np.ones(N), "gap": GAPS, "radius_1": LOWER}),
    "elastic by time": (soft(dissipative_time=0.0), {"gap": GAPS, "radius_1": LOWER}),
    "nearly elastic": (soft(), {"restitution": 1 - 10 ** uniform(-16, -2), "gap": GAPS, "radius_1": LOWER}),
    "hardly damped": (
        soft(dissipative_time=0.0),
        {"dissipative_time": spread(1e-22, 1e-6), "gap": GAPS, "radius_1": LOWER},
    ),
    "strongly damped, some at rest": (
        soft(),
        {"restitution": spread(0.01, 0.3), "gap": GAPS, "radius_1": LOWER},
    ),
    "sizes far apart": (
        soft(),
        {"restitution": uniform(0.3, 1), "gap": spread(1e-6, 1e-2), "radius_2": spread(4e-4, 2)},
    ),
    "gravity weak and strong": (
        soft(),
        {
            "restitution": uniform(0.2, 1),
            "gravity": RNG.choice([0.0, 1e-3, 1.0, 100.0], N),
            "velocity_1": uniform(-3, -0.1),
            "velocity_2": uniform(-3, -0.1),
        },
    ),
}


@pytest.mark.parametrize("name", LISTS)
def test_random_points(name: str) -> None:
    """Against the general solver; and every instruction set gives the same bits."""
    column, values = LISTS[name]
    swept = points(**values)
    kernel = compute(column, "auto", **swept)
    for instruction_set in _core.instruction_sets():
        other = compute(column, instruction_set, **swept)
        for variable, result in kernel.items():
            assert other[variable].tobytes() == result.tobytes(), (instruction_set, variable)
    assert_agree(kernel, compute(column, "scalar", **swept), column.impact_speed)


def test_error_follows_the_tolerance() -> None:
    """The error is below the tolerance at 95 % of the points and falls with it; the counts never change."""
    column, n = soft(), 300
    rng = np.random.default_rng(11)
    swept = points(restitution=rng.uniform(0.4, 0.999, n), gap=np.exp(rng.uniform(*np.log([1e-6, 1e-2]), n)))
    general = compute(column, "scalar", **swept)
    last = np.inf
    for tolerance in (1e-6, 1e-8, 1e-10, 1e-12):
        kernel = compute(column, "auto", tolerance, **swept)
        np.testing.assert_array_equal(kernel["n_contacts"], general["n_contacts"])
        away = np.abs(kernel["relative_velocity"] - general["relative_velocity"]) / column.impact_speed
        error = np.quantile(away[np.isfinite(away)], 0.95)
        assert error < min(tolerance, 0.1 * last)
        last = error
    assert last > 0.0


def test_stiff_points_are_left_to_the_general_solver() -> None:
    """Then with its bits, whatever came before."""
    swept = points(dissipative_time=np.array([1e-5, 0.03, 1e-4]), gap=np.array([1e-4, 1e-3, 1e-5]))
    kernel, general = (compute(soft(dissipative_time=0.0), how, **swept) for how in ("auto", "scalar"))
    assert_agree(kernel, general, soft().impact_speed)


# --- what has no contact, never lands, or is not a drop -----------------------------------------------------


def test_outcomes() -> None:
    swept = points(
        gravity=np.array([9.81, 9.81, 0.0, 0.0]),
        velocity_1=np.array([0.0, 0.0, 1.0, 0.0]),
        velocity_2=np.array([0.0, 9.0, 1.0, 0.0]),
    )
    kernel, general = (compute(soft(), how, **swept) for how in ("auto", "scalar"))
    assert len(set(kernel["outcome"])) == 4
    assert_agree(kernel, general, soft().impact_speed)


# --- the table that inverts ε -------------------------------------------------------------------------------


def test_restitution_is_that_of_the_contact() -> None:
    """The kernel's own inversion against that of a law, from nearly elastic to a hundredth."""
    restitution = np.concatenate([1 - np.geomspace(1e-12, 0.3, 25), np.geomspace(0.69, 0.01, 25)])
    values_of = compute(soft(), "auto", restitution=restitution)
    for i, e in enumerate(restitution):
        column = soft(restitution=e, impact_speed=3.0)
        general = hl.newton(column)
        assert values_of["n_contacts"][i] == general.n_contacts
        assert values_of["relative_velocity"][i] == pytest.approx(
            general.relative_velocity, rel=0.0, abs=1e-10 * column.impact_speed
        )
