"""Steady states: equilibration, statistical inefficiency and error bars on series with known answers."""

import math

import numpy as np
import pytest
import scipy
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import hardlimit as hl
from conftest import draws, refusal, slow
from hardlimit.measure.steadiness import inefficiency


def ar1(rng, n, phi, mean=0.0):
    """x_k = φ x_(k−1) + noise, stationary from the start, with variance 1: its g is (1 + φ)/(1 − φ)."""
    noise = rng.normal(size=n) * math.sqrt(1.0 - phi * phi)
    noise[0] = rng.normal()
    return mean + scipy.signal.lfilter([1.0], [1.0, -phi], noise)


def blocked(x):
    """Standard error of the mean by blocking: the largest with at least 16 blocks (Flyvbjerg & Petersen 1989)."""
    errors = []
    while len(x) >= 16:
        errors.append(math.sqrt(x.var() / (len(x) - 1)))
        x = 0.5 * (x[: len(x) // 2 * 2 : 2] + x[1::2])
    return max(errors)


@draws(30)
@given(phi=st.floats(0.0, 0.95), seed=st.integers(0, 10**6))
def test_the_inefficiency_of_a_known_series(phi, seed):
    """AR(1) of 400 g values; the spread of the estimate of g is some 15 %."""
    exact = (1.0 + phi) / (1.0 - phi)
    x = ar1(np.random.default_rng(seed), int(400 * exact), phi)
    assert inefficiency(x) == pytest.approx(exact, rel=0.6)
    found = hl.measure.steady(x)
    assert found.inefficiency >= 1.0 and found.n_independent <= len(x)


@pytest.mark.parametrize(
    "phi, transient",
    [(0.0, 5.0), slow(0.0, 0.0), slow(0.5, 0.0), slow(0.5, 5.0), slow(0.9, 0.0), slow(0.9, 5.0)],
)
def test_error_bars_cover_the_mean(phi, transient):
    """Series of 60 independent values: the 95 % interval contains the mean in 89 to 95 % of them, the standard error in
    60 to 67 %. (The choice of the start and the noise of g cost some per cent. Binomial error: 1.5 and 3.3 %.)"""
    rng = np.random.default_rng(7)
    g, n = (1.0 + phi) / (1.0 - phi), 200
    decay = transient * np.exp(-np.arange(int(60 * g)) / (2.0 * g))
    found = [hl.measure.steady(ar1(rng, len(decay), phi, 3.0) + decay).mean for _ in range(n)]
    assert 0.86 <= sum(one.lower <= 3.0 <= one.upper for one in found) / n <= 0.99
    assert 0.55 <= sum(abs(one.value - 3.0) <= one.error for one in found) / n <= 0.78


@pytest.mark.slow
def test_the_error_is_that_of_blocking():
    """Mean ratio of both errors over 20 series, within 10 %."""
    ratios = []
    for seed in range(20):
        x = ar1(np.random.default_rng(seed), 2**13, 0.9)
        ratios.append(hl.measure.steady(x).mean.error / blocked(x))
    assert 0.85 < np.mean(ratios) < 1.1


def test_the_transient_is_found_and_said():
    rng = np.random.default_rng(3)
    time = xr.Variable("time", np.arange(1000) * 1e-3, {"units": "s"})
    x = 5.0 + 4.0 * np.exp(-np.arange(1000) / 30.0) + 0.1 * rng.normal(size=1000)
    series = xr.DataArray(
        np.concatenate([[np.nan], x[1:]]), {"time": time}, "time", "pressure", {"units": "Pa"}
    )
    found = hl.measure.steady(series)
    assert 0.07 < found.start < 0.25 and found.n_discarded == round(found.start * 1000) - 1
    assert abs(found.mean.value - 5.0) < 4.0 * found.mean.error
    assert f"Pa, steady from time {found.start:.6g} s on, statistical inefficiency 1" in str(found)
    constant = hl.measure.steady(np.full(10, 2.0))
    assert constant.mean == (2.0, 0.0, 2.0, 2.0) and constant.n_independent == 10


def test_what_is_no_series_is_refused():
    for bad in (
        np.zeros(3),
        np.array([1.0, 2.0, np.nan, 3.0, 4.0]),
        xr.DataArray(np.zeros((5, 2))),
        "abcdef",
        [None],
    ):
        assert refusal(lambda bad=bad: hl.measure.steady(bad)).startswith("series: got ")


def test_a_short_last_interval_does_not_count() -> None:
    """A run that max_collisions stops ends at a collision: its last interval may be arbitrarily short."""
    gas = hl.ParticleSystem.random(200, 0.2, 1e-3, 2500.0, rms_speed=0.5, seed=1)
    whole = hl.event_driven(gas, restitution=1.0, until=0.1, samples=50, log=True)
    time, width = whole.collisions.time.values, 0.002
    late = time - width * np.floor(time / width)
    last = int(np.argmin(np.where(time > 0.05, late, np.inf)))  # just after a sample
    run = hl.event_driven(gas, restitution=1.0, max_collisions=last + 1, until=0.1, samples=50)
    assert np.diff(run.series.time.values)[-1] < 1e-2 * width
    until = float(run.series.time[-2])
    before = hl.event_driven(gas, restitution=1.0, until=until, samples=round(until / width))
    for measure in (lambda r: hl.measure.steady(r.series.pressure), hl.measure.contact_value):
        assert measure(run).mean.value == pytest.approx(measure(before).mean.value, rel=1e-9)
    tensors = [hl.measure.pressure_tensor(r).pressure_tensor.values for r in (run, before)]
    assert tensors[0] == pytest.approx(tensors[1], rel=1e-6, abs=1e-6)


def test_numbers_may_begin_with_nan() -> None:
    assert hl.measure.steady([math.nan, 1.0, 2.0, 1.0, 2.0, 1.0]).series.size == 5
    with pytest.raises(ValueError, match=r"series: got .* must be numbers over one dimension"):
        hl.measure.steady("four")


def test_a_given_start_leaves_out_what_is_before() -> None:
    gas = hl.ParticleSystem.random(40, 0.2, 1e-3, 2500.0, rms_speed=0.2, seed=3)
    run = hl.event_driven(gas, restitution=0.9, until=0.5, samples=5)
    found = hl.measure.pressure_tensor(run, start=0.1)
    expected = run.series.pressure_tensor.sel(component="xx").values[2:].mean()
    assert float(found.pressure_tensor[0, 0]) == pytest.approx(float(expected), rel=1e-12)
    assert found.attrs["start"] == pytest.approx(0.1)
