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
    steady = hl.measure.steady(x)
    assert steady.inefficiency >= 1.0 and steady.n_independent <= len(x)


@pytest.mark.parametrize(
    "time, n, transient, count",
    [
        (10, 100, 0.0, 40),
        *(slow(time, n, 0.0, 150) for time in (0, 5, 30) for n in (50, 300, 10_000)),
        *(slow(time, n, size, 150) for time in (0, 10) for n in (100, 1000) for size in (3.0, 30.0)),
    ],
)
def test_error_bars_cover_the_mean(time, n, transient, count):
    """The 95 % interval contains the mean of at least 93 % of the series, less two binomial errors; the
    standard error covers 60 to 85 %. Series of fewer than six independent values are not resolved, but for a few."""
    rng = np.random.default_rng(n + time)
    phi = math.exp(-1.0 / time) if time else 0.0
    independent = n * (1.0 - phi) / (1.0 + phi)
    if transient and independent < 10.0:
        pytest.skip("a transient is not told from a correlation of the same duration")
    decay = 3.0 + transient * np.exp(-np.arange(n) / (0.04 * n))
    steady_states = [hl.measure.steady(ar1(rng, n, phi) + decay) for _ in range(count)]
    covered = np.mean([steady.mean.lower <= 3.0 <= steady.mean.upper for steady in steady_states])
    least = 0.93 - 2.0 * math.sqrt(0.93 * 0.07 / count)
    assert covered >= least or independent < 1.0  # 0.8 where the correlation is longer than the series
    resolved = np.mean([steady.resolved for steady in steady_states])
    if independent < 6.0:
        assert resolved < 0.15
    else:
        assert (
            0.55
            < np.mean([abs(steady.mean.value - 3.0) <= steady.mean.error for steady in steady_states])
            < 0.9
        )
    assert resolved > 0.9 or independent < 25.0


@pytest.mark.parametrize("noise", [0.5, slow(0.9)])
def test_a_slow_part_below_fast_noise_counts(noise):
    """The pressure of a gas: most of its variance is not correlated, most of the error of its mean is. The first
    negative correlation comes long before the correlation ends."""
    rng, n, count = np.random.default_rng(5), 400, 60
    hits = 0
    for _ in range(count):
        x = math.sqrt(noise) * rng.normal(size=n) + math.sqrt(1.0 - noise) * ar1(rng, n, math.exp(-0.1))
        mean = hl.measure.steady(x).mean
        hits += mean.lower <= 0.0 <= mean.upper
    assert hits >= 0.88 * count


@pytest.mark.slow
@pytest.mark.parametrize("sheared", [False, True])
def test_one_short_run_agrees_with_many(sheared):
    """Heated and sheared gases from a start out of the steady state, 100 samples: their mean is that of all runs, whose
    last halves are steady."""
    options = (
        {"boundary": ("periodic", "lees-edwards", "periodic"), "shear_rate": 250.0}
        if sheared
        else {"thermostat": hl.RandomKicks(0.24, 1.3e-4, seed=1)}
    )
    runs = []
    for seed in range(60):
        gas = hl.ParticleSystem.random(60, 0.3 if sheared else 0.15, 1e-3, 2500.0, 1.0, seed=seed, **options)
        if not sheared:
            gas = gas.replace(thermostat=hl.RandomKicks(0.24, 1.3e-4, seed=seed))
        runs.append(hl.event_driven(gas, restitution=0.8, until=0.2 if sheared else 0.13, samples=100).series)
    for name in ("pressure", "granular_temperature", "collision_rate"):
        true = np.mean([run[name].values[51:].mean() for run in runs])
        means = [hl.measure.steady(run[name]).mean for run in runs]
        assert np.mean([mean.lower <= true <= mean.upper for mean in means]) >= 0.88, name


def test_few_independent_samples_are_not_resolved():
    rng = np.random.default_rng(2)
    steady = hl.measure.steady(ar1(rng, 100, math.exp(-1.0 / 30.0)))
    assert not steady.resolved and str(steady).endswith("independent samples: not resolved, fewer than 10")
    assert hl.measure.steady(rng.normal(size=100)).resolved


@pytest.mark.slow
def test_the_error_is_that_of_blocking():
    """Mean ratio of both errors over 20 series: the possible rest of a transient adds some 10 %."""
    ratios = []
    for seed in range(20):
        x = ar1(np.random.default_rng(seed), 2**13, 0.9)
        ratios.append(hl.measure.steady(x).mean.error / blocked(x))
    assert 0.9 < np.mean(ratios) < 1.25


def test_the_transient_is_found_and_said():
    rng = np.random.default_rng(3)
    time = xr.Variable("time", np.arange(1000) * 1e-3, {"units": "s"})
    x = 5.0 + 4.0 * np.exp(-np.arange(1000) / 30.0) + 0.1 * rng.normal(size=1000)
    series = xr.DataArray(
        np.concatenate([[np.nan], x[1:]]), {"time": time}, "time", "pressure", {"units": "Pa"}
    )
    steady = hl.measure.steady(series)
    assert 0.07 < steady.start < 0.5 and steady.n_discarded == round(steady.start * 1000) - 1
    assert abs(steady.mean.value - 5.0) < 4.0 * steady.mean.error
    assert f"Pa, steady from time {steady.start:.6g} s on, statistical inefficiency 1" in str(steady)
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
    stress = hl.measure.pressure_tensor(run, start=0.1)
    expected = run.series.pressure_tensor.sel(component="xx").values[2:].mean()
    assert float(stress.pressure_tensor[0, 0]) == pytest.approx(float(expected), rel=1e-12)
    assert stress.attrs["start"] == pytest.approx(0.1)
