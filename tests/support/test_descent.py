"""The search in a box with a given sum, against the conditions of an optimum."""

import numpy as np
import pytest

from hardlimit.support.descent import Domain, descend


def banana(x):
    """Rosenbrock's function of any number of arguments."""
    return float(np.sum(100.0 * (x[1:] - x[:-1] ** 2) ** 2 + (1.0 - x[:-1]) ** 2))


def banana_slope(x):
    slope = np.zeros_like(x)
    slope[1:] += 200.0 * (x[1:] - x[:-1] ** 2)
    slope[:-1] -= 400.0 * x[:-1] * (x[1:] - x[:-1] ** 2) + 2.0 * (1.0 - x[:-1])
    return slope


@pytest.mark.parametrize("bounds", [(-5.0, 5.0), (-5.0, 0.8), (-5.0, 0.3)])
@pytest.mark.parametrize("total", [None, 2.0])
def test_a_curved_valley_is_followed_to_its_end(bounds, total):
    n = 9
    domain = Domain(*bounds, total is not None)
    start = domain.nearest(np.full(n, 0.2), total)
    at, value = descend(banana, start, domain)
    assert value == banana(at) < banana(start)
    slope = banana_slope(at)
    free = (at > bounds[0] + 1e-9) & (at < bounds[1] - 1e-9)
    level = slope[free].mean() if total is not None else 0.0
    np.testing.assert_allclose(slope[free], level, atol=5e-3)  # what difference quotients leave
    assert np.all(slope[at >= bounds[1] - 1e-9] <= level + 5e-3)
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


@pytest.mark.parametrize("error", [KeyboardInterrupt, ZeroDivisionError])
def test_what_a_function_raises_ends_the_search(error):
    calls = []

    def stops(x):
        calls.append(1)
        if len(calls) == 7:
            raise error
        return banana(x)

    with pytest.raises(error):
        descend(stops, np.full(4, 0.2), Domain(-1.0, 1.0, True))
    assert len(calls) == 7
