"""The search in a box with a given sum, against scipy's and against the conditions of an optimum."""

import numpy as np
import pytest
from scipy.optimize import minimize

from hardlimit.descent import Domain, descend


def banana(x):
    """Rosenbrock's function of any number of arguments."""
    return float(np.sum(100.0 * (x[1:] - x[:-1] ** 2) ** 2 + (1.0 - x[:-1]) ** 2))


@pytest.mark.parametrize("seed", range(12))
def test_a_step_is_the_minimum_of_its_model(seed):
    """Against scipy, for random convex models, bounds that bind, and points on bounds."""
    rng = np.random.default_rng(seed)
    n, summed = int(rng.integers(1, 12)), bool(seed % 2)
    domain = Domain(-1.0, 0.5, summed)
    root = rng.normal(size=(n, n))
    curvature, gradient = root @ root.T + 0.1 * np.eye(n), 3.0 * rng.normal(size=n)
    at = np.clip(rng.uniform(-1.5, 1.0, n), -1.0, 0.5)
    step = domain.step(at, gradient, curvature)

    def model(d):
        return float(gradient @ d + 0.5 * d @ curvature @ d)

    same = [{"type": "eq", "fun": np.sum, "jac": np.ones_like}] if summed else []
    bounds = [(-1.0 - x, 0.5 - x) for x in at]
    found = minimize(model, np.zeros(n), jac=lambda d: gradient + curvature @ d, bounds=bounds, constraints=same,
                     method="SLSQP", options={"ftol": 1e-15, "maxiter": 500})  # fmt: skip
    assert np.all(at + step >= -1.0 - 1e-12) and np.all(at + step <= 0.5 + 1e-12)
    assert not summed or abs(step.sum()) < 1e-12
    assert model(step) <= found.fun + 1e-10
    np.testing.assert_allclose(step, found.x, atol=1e-5)


@pytest.mark.parametrize("bounds", [(-5.0, 5.0), (-5.0, 0.8), (-5.0, 0.3)])
@pytest.mark.parametrize("total", [None, 2.0])
def test_a_curved_valley_is_followed_to_its_end(bounds, total):
    n = 9
    domain = Domain(*bounds, total is not None)
    start = domain.nearest(np.full(n, 0.2), total)
    at, value = descend(banana, start, domain)
    same = [{"type": "eq", "fun": lambda x: np.sum(x) - total}] if total is not None else []
    found = minimize(banana, start, bounds=[bounds] * n, constraints=same, method="SLSQP",
                     options={"ftol": 1e-14, "maxiter": 2000})  # fmt: skip
    assert value <= found.fun + 1e-6  # what difference quotients leave
    assert total is None or at.sum() == pytest.approx(total, abs=1e-10)
    assert np.all((at >= bounds[0]) & (at <= bounds[1]))


@pytest.mark.parametrize("seed", range(4))
def test_the_nearest_point_keeps_sum_and_bounds(seed):
    rng = np.random.default_rng(seed)
    given, total = rng.normal(-2.0, 3.0, 6), -7.5
    found = Domain(-4.0, 0.0, True).nearest(given, total)
    assert found.sum() == pytest.approx(total, abs=1e-12)
    assert np.all((found >= -4.0) & (found <= 0.0))
    inside = (found > -4.0) & (found < 0.0)
    assert np.ptp((found - given)[inside]) < 1e-12


def test_a_kink_ends_the_search_where_no_step_leads_down():
    at, value = descend(lambda x: float(np.abs(x).sum()), np.array([0.7, -0.4]), Domain(-1.0, 1.0, False))
    assert value < 1e-5 and np.all(np.abs(at) < 1e-5)


@pytest.mark.parametrize("seed", range(8))
def test_jumps_do_no_harm(seed):
    """A function that is not continuous has no curvature to learn; the search still goes down and stays inside."""
    rng = np.random.default_rng(seed)
    domain = Domain(-3.0, 0.0, bool(seed % 2))
    start = domain.nearest(rng.uniform(-3.0, 0.0, 7), -9.0 if domain.summed else None)

    def stairs(x):
        return float(np.sum((x + 1.1) ** 2) + 0.3 * np.sum(np.floor(7.0 * x)) - 1e3 * (x[0] > -1e-3))

    at, value = descend(stairs, start, domain)
    assert value <= stairs(start) and np.all((at >= -3.0) & (at <= 0.0))
