"""Elementary functions of the core against 40-digit arithmetic: the error bounds stated in core/base/math.hpp."""

import math

import mpmath
import numpy as np
import pytest

from hardlimit import _core

rng = np.random.default_rng(20110411)
signs = rng.choice([-1.0, 1.0], 2000)


def error(got, x, exact) -> tuple[float, float]:
    """Largest error in units in the last place of the exact value, and its argument."""
    worst = (0.0, math.nan)
    with mpmath.workdps(40):
        for value, at in zip(got, x, strict=True):
            wanted = exact(mpmath.mpf(float(at)))
            difference = float(abs(mpmath.mpf(float(value)) - wanted) / mpmath.mpf(math.ulp(float(wanted))))
            if not difference <= worst[0]:
                worst = (difference, float(at))
    return worst


def multiples_of_half_pi() -> np.ndarray:
    """The doubles nearest to kπ/2, where cancellation in the argument reduction is largest."""
    k = np.concatenate([np.arange(1, 200), rng.integers(200, 2**20, 1000)])
    with mpmath.workdps(40):
        return np.array([float(int(i) * mpmath.pi / 2) for i in k])


CASES = {
    "exp over its range": ("exp", mpmath.exp, rng.uniform(-745.1, 709.7, 2000), 2.0),
    "exp near 0": ("exp", mpmath.exp, signs * 10.0 ** rng.uniform(-20, 0, 2000), 2.0),
    "log over its range": ("log", mpmath.log, 10.0 ** rng.uniform(-307.6, 308.2, 2000), 2.0),
    "log of denormals": ("log", mpmath.log, 10.0 ** rng.uniform(-323, -307.7, 500), 2.0),
    "log near 1": ("log", mpmath.log, 1.0 + signs * 10.0 ** rng.uniform(-15.6, -0.4, 2000), 2.0),
    "log1p of small numbers": ("log1p", mpmath.log1p, signs * 10.0 ** rng.uniform(-300, -3, 2000), 2.0),
    "log1p around its branches": ("log1p", mpmath.log1p, rng.uniform(-0.6, 0.9, 2000), 2.0),
    "log1p near -1": ("log1p", mpmath.log1p, -1.0 + 10.0 ** rng.uniform(-15, -0.1, 2000), 2.0),
    "log1p of large numbers": ("log1p", mpmath.log1p, 10.0 ** rng.uniform(-0.5, 308, 2000), 2.0),
    "sin": ("sin", mpmath.sin, rng.uniform(-20, 20, 2000), 3.0),
    "sin of small numbers": ("sin", mpmath.sin, signs * 10.0 ** rng.uniform(-300, 0, 2000), 3.0),
    "sin of large numbers": ("sin", mpmath.sin, rng.uniform(-1.6e6, 1.6e6, 2000), 3.0),
    "sin at its zeros": ("sin", mpmath.sin, multiples_of_half_pi(), 3.0),
    "cos": ("cos", mpmath.cos, rng.uniform(-20, 20, 2000), 3.0),
    "cos of small numbers": ("cos", mpmath.cos, signs * 10.0 ** rng.uniform(-300, 0, 2000), 3.0),
    "cos of large numbers": ("cos", mpmath.cos, rng.uniform(-1.6e6, 1.6e6, 2000), 3.0),
    "cos at its zeros": ("cos", mpmath.cos, multiples_of_half_pi(), 3.0),
}


@pytest.mark.parametrize("case", CASES)
def test_error_stays_below_the_stated_bound(case):
    name, exact, x, bound = CASES[case]
    worst, where = error(_core.math(name, x), x, exact)
    assert worst < bound, f"{name}({where!r}): {worst:.2f} ulp"


@pytest.mark.parametrize("decades", [1, 3, 300])
def test_atan2_upper(decades):
    y = 10.0 ** rng.uniform(-decades, decades, 3000)
    x = rng.choice([-1.0, 1.0], 3000) * 10.0 ** rng.uniform(-decades, decades, 3000)
    for b, a in zip(y, x, strict=True):
        with mpmath.workdps(40):
            wanted = mpmath.atan2(mpmath.mpf(b), mpmath.mpf(a))
            got = mpmath.mpf(_core.atan2_upper(b, a))
            assert abs(got - wanted) < 6 * math.ulp(float(wanted)), (b, a)


def test_exact_points():
    def value(name, x):
        return _core.math(name, np.array([x]))[0]

    assert value("exp", 0.0) == 1.0
    assert value("log", 1.0) == 0.0
    assert value("log1p", 0.0) == 0.0
    assert value("sin", 0.0) == 0.0
    assert value("cos", 0.0) == 1.0
    assert _core.atan2_upper(0.0, 1.0) == 0.0
    assert _core.atan2_upper(0.0, -1.0) == math.pi
    assert _core.atan2_upper(1.0, 1.0) == math.pi / 4
    assert _core.atan2_upper(0.0, 0.0) == 0.0


def test_overflow_and_underflow_of_exp():
    x = np.array([709.782712893384, 709.782712893385, 1e308, -745.13, -745.14, -1e308])
    value = _core.math("exp", x)
    assert 1.797e308 < value[0] < np.inf
    assert value[1] == value[2] == np.inf
    assert value[3] == 5e-324
    assert value[4] == value[5] == 0.0


def test_outside_the_domain():
    value = _core.math("log", np.array([0.0, -1.0, -1e-320, np.inf, np.nan]))
    assert value[0] == -np.inf and value[3] == np.inf
    assert np.isnan(value[[1, 2, 4]]).all()
    assert np.isnan(_core.math("exp", np.array([np.nan]))).all()
    assert np.isnan(_core.math("log1p", np.array([-2.0]))).all()


def test_monotone_where_it_is_used():
    """exp does not decrease between neighbouring doubles where its power of two changes."""
    edges = (np.arange(-1000, 1000) + 0.5) * math.log(2.0)
    x = np.unique(np.concatenate([edges, np.nextafter(edges, np.inf), np.nextafter(edges, -np.inf)]))
    assert (np.diff(_core.math("exp", np.sort(x))) >= 0.0).all()
