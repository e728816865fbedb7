"""hl.fidelity for driven boxes: where the steady state begins, averages over it and their errors."""

import math
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

import hardlimit as hl
from conftest import refusal
from hardlimit.fidelity_study import report, steady
from hardlimit.fidelity_study.starts import Starts
from hardlimit.measure.steadiness import inefficiency

LAW = hl.LinearDashpot(stiffness=3e5, restitution=0.8)
EXAMINED = steady.EXAMINED


def heated(seed: int = 0, n: int = 40, phi: float = 0.15, dimension: int = 3) -> hl.ParticleSystem:
    return hl.ParticleSystem.random(
        n, phi, 1e-3, 2500.0, 1.0, seed=seed, dimension=dimension,
        thermostat=hl.RandomKicks(4e-3 * n, 1.3e-4, seed=7),
    )  # fmt: skip


def bathed(seed: int = 0, n: int = 40) -> hl.ParticleSystem:
    bath = hl.Andersen(temperature=0.3, rate=300.0, seed=3)
    return hl.ParticleSystem.random(n, 0.2, 1e-3, 2500.0, 1.0, seed=seed, dimension=2, thermostat=bath)


def shaken(seed: int = 0, n: int = 30) -> hl.ParticleSystem:
    walls = {"x-": hl.MovingWall(2e-4, 800.0), "x+": hl.MovingWall(2e-4, 800.0, phase=math.pi)}
    return hl.ParticleSystem.random(
        n, 0.1, 1e-3, 2500.0, 0.5, seed=seed, boundary=["wall", "periodic", "periodic"], walls=walls
    )


def study(system: object, replicas: int = 2, until: float = 0.03, **more: object) -> hl.Fidelity:
    options = {"samples": 60, "models": ("newton", "constant")} | more
    return hl.fidelity(system, law=LAW, until=until, replicas=replicas, **options)


# --- where the steady state begins ----------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(8))
def test_a_transient_is_cut_and_a_drift_refused(seed: int) -> None:
    """First-order autoregressive noise about 1, with a transient of a tenth of the series or a drift over all of it."""
    rng = np.random.default_rng(seed)
    n, replicas, memory = 1000, int(rng.integers(1, 6)), float(rng.uniform(0.0, 0.9))
    noise = np.zeros((replicas, n))
    for k in range(1, n):
        noise[:, k] = memory * noise[:, k - 1] + 0.02 * rng.standard_normal(replicas)
    at = np.arange(n) / n
    times = np.linspace(0.0, 1.0, n + 1)
    good = steady.detected({("a", "b"): 1.0 + noise + 3.0 * np.exp(-at / 0.02)}, times)
    assert good.reason == "" and 0.03 < good.start <= 0.5 and good.start == times[good.first]
    bad = steady.detected({("T", "of x"): 1.0 + noise + 3.0 * at}, times)
    assert math.isnan(bad.start) and bad.reason.startswith("the T of x ")


@pytest.mark.parametrize("seed", range(4))
def test_a_drift_within_the_noise_is_refused(seed: int) -> None:
    """1.5 times the noise over a series of 1000 independent samples: it is not taken for a correlation."""
    noise = 1.0 + 0.02 * np.random.default_rng(seed).standard_normal((1, 1000))
    drift = np.linspace(0.0, 0.03, 1000)
    found = steady.detected({("T", "of x"): noise + drift}, np.arange(1001.0))
    assert math.isnan(found.start) and "still changes by" in found.reason
    assert steady.detected({("T", "of x"): noise}, np.arange(1001.0)).reason == ""


def test_stationary_series_are_rarely_refused() -> None:
    """0.1 % of 100 sets of two correlated series; the inefficiency of short series is a little too small."""
    rng = np.random.default_rng(5)
    refused = 0
    for _ in range(100):
        noise = rng.standard_normal((2, 1, 200))
        noise[..., 1:] += 0.6 * noise[..., :-1]
        series = {(str(k), ""): 1.0 + 0.1 * one for k, one in enumerate(noise)}
        refused += steady.detected(series, np.arange(201.0)).reason != ""
    assert refused <= 2


def test_a_run_that_is_too_short_says_so() -> None:
    f = study(heated(), until=1e-3)
    assert (
        str(f).startswith("No verdict: not steady by 0.001 s, the ") and "%" not in str(f).split("changes")[0]
    )
    for name in EXAMINED:
        assert math.isnan(f.final_difference(name, "constant").value)
        assert math.isnan(f.steady_mean(name, "newton").value)
    assert math.isnan(f.tc_nu) and math.isnan(f.steady.start) and f.dataset.steady_difference.isnull().all()
    assert "fewer than" in study(heated(), until=1e-3, samples=4).steady.reason


def test_a_piston_has_no_steady_state() -> None:
    """A wall that moves in with a constant speed heats the gas for ever."""
    box = hl.ParticleSystem.random(30, 0.02, 1e-3, 2500.0, 1.0, boundary="wall")
    moving = box.replace(walls={"x-": hl.MovingWall(velocity=0.2)})
    f = study(moving, replicas=1, until=0.2 * box.box[0] / 0.2)
    assert f.driven and f.steady.reason and "not steady" in str(f)


def test_a_collapse_is_not_averaged() -> None:
    law = hl.LinearDashpot(stiffness=1e6, restitution=0.1)
    dense = partial(heated, n=40, phi=0.7, dimension=2)
    f = hl.fidelity(dense, law=law, until=2e-3, models=("newton", "constant"), replicas=2, samples=40)
    assert f.outcomes("constant") == ["collapse"] * 2
    assert (
        "The rule constant ended with inelastic collapse in 2 of 2 replicas and cannot be averaged." in str(f)
    )
    assert math.isnan(f.final_difference("pressure", "constant").value)


# --- averages -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("make", [heated, bathed, shaken])
def test_the_raw_series_are_those_of_the_runs(make: object) -> None:
    system = make()
    f = study(system, replicas=1, until=2e-3, samples=10)
    runs = {
        "newton": hl.molecular_dynamics(system, law=LAW, until=2e-3, samples=10, engine="events"),
        "constant": hl.event_driven(system, restitution=0.8, until=2e-3, samples=10),
    }
    for model, run in runs.items():
        series, dt = run.series, np.diff(run.series.time)
        expected = {
            "granular_temperature": series.granular_temperature[1:],
            "pressure": series.pressure[1:],
            "collision_rate": series.collision_rate[1:],
            "dissipation_rate": np.diff(series.dissipated_energy) / dt,
        }
        for name, values in expected.items():
            np.testing.assert_allclose(f.series(name, model)[0], values, rtol=1e-12)
        raw = f.replicas.sel(model=model, replica=0)
        driving = sum(np.diff(series[one]) / dt for one in ("wall_work", "heat") if one in series)
        np.testing.assert_allclose(raw.interval_driving_power, driving, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(raw.interval_pressure_tensor, series.pressure_tensor[1:], rtol=1e-12)


@pytest.mark.parametrize(("make", "replicas"), [(heated, 1), (heated, 3), (bathed, 2), (shaken, 2)])
def test_the_report_has_the_numbers_of_the_raw_series(make: object, replicas: int) -> None:
    source = make if make is shaken else make()
    rule = "tc" if make is shaken else "constant"  # others would end at a wall
    f = study(source, replicas, until=0.3 if make is shaken else 0.06, samples=180, models=("newton", rule))
    assert f.steady.reason == "", f.steady
    k = int(np.searchsorted(f.plan.times, f.steady.start))
    assert f.steady.first == k and f"Steady from {f.steady.start:.3g} s on" in str(f)
    raw = f.replicas.isel(interval=slice(k, None), time=slice(k + 1, None))
    for name in EXAMINED:
        both = raw[name if name == "granular_temperature" else f"interval_{name}"]
        newton, ruled = (both.sel(model=one).values for one in f.models)
        means = [one.mean(axis=1) for one in (newton, ruled)]
        value = means[1].mean() / means[0].mean() - 1.0
        found = f.final_difference(name, rule)
        if replicas > 1:
            residual = (means[1] - means[1].mean() / means[0].mean() * means[0]) / means[0].mean()
            error, freedom = residual.std(ddof=1) / math.sqrt(replicas), replicas - 1
        else:
            sizes = [one.shape[1] / inefficiency(one[0]) for one in (newton, ruled)]
            bars = [
                one.std(ddof=1) / math.sqrt(n) / one.mean()
                for one, n in zip((newton, ruled), sizes, strict=True)
            ]
            error = (1.0 + value) * math.hypot(bars[0], bars[1])
            freedom = int(min(sizes)) - 1
        assert found.value == pytest.approx(value, abs=1e-12) and found.error == pytest.approx(
            error, rel=1e-9
        )
        assert found.upper - found.value == pytest.approx(stats.t.ppf(0.995, freedom) * error, rel=1e-9)
        assert f.dataset.steady_difference.sel(quantity=name, model=rule).values.tolist() == list(found[:2])
        mean = f.steady_mean(name, "newton")
        assert mean.value == pytest.approx(means[0].mean(), rel=1e-12)
        assert f.dataset[f"steady_{name}"].sel(model="newton").values.tolist() == list(mean[:2])
        size = report.percent_with_error(found.value, found.error)
        assert f"{report.NAMES[name]} {size}" in str(f)
    rate = f.steady_mean("collision_rate", "newton").value
    assert f.tc_nu == pytest.approx(rate * f.contact_duration)


def test_energy_is_balanced_in_the_steady_state() -> None:
    """Dissipation equals the power of the kicks, within 4 standard errors; errors below 3 %."""
    f = study(heated(), 4, until=0.08, samples=200)
    for model in f.models:
        lost = f.steady_mean("dissipation_rate", model)
        power = f.start.thermostat.power
        assert abs(lost.value - power) < 4.0 * lost.error + 0.01 * power and lost.error < 0.05 * power


# --- replicas and stores --------------------------------------------------------------------------------------


def test_each_replica_has_its_own_kicks() -> None:
    seeds = [Starts(heated(), 5).start(k, lambda done, total: None).thermostat.seed for k in range(3)]
    assert len(set(seeds)) == 3 and seeds[0] == heated().thermostat.seed
    f = study(heated(), 3, until=2e-3, samples=10)
    power = f.replicas.interval_driving_power.sel(model="newton").values
    assert len({tuple(one) for one in power}) == 3
    again = study(heated, 3, until=2e-3, samples=10)
    assert len({tuple(one) for one in again.replicas.interval_driving_power.sel(model="newton").values}) == 3


def test_moving_walls_need_a_function() -> None:
    assert "moving walls" in refusal(lambda: study(shaken(), 2))


def test_a_box_that_is_not_driven_has_no_steady_state() -> None:
    f = study(heated().replace(thermostat=None), 1, until=1e-4, samples=2)
    assert not f.driven and "not driven" in f.steady.reason
    assert "not driven" in refusal(lambda: f.series("pressure", "newton"))
    assert not [name for name in f.replicas if name.startswith("interval_")]


def test_a_store_and_workers_give_the_same_bits(tmp_path: Path) -> None:
    few = partial(study, heated(), until=3e-3, samples=12)
    whole = few(replicas=3)
    store = tmp_path / "kept"
    few(replicas=1, store=store)
    again = few(replicas=3, store=store)
    assert again.replicas.equals(whole.replicas) and again.dataset.equals(whole.dataset)
    assert few(replicas=3, store=store).replicas.equals(whole.replicas)


@pytest.mark.slow
def test_workers_give_the_same_bits() -> None:
    few = partial(study, heated(), until=3e-3, samples=12, replicas=3)
    assert few(workers=2).replicas.equals(few().replicas)


def test_it_is_saved(tmp_path: Path) -> None:
    import xarray as xr

    f = study(bathed(), 2, until=2e-3, samples=10)
    with xr.open_datatree(f.save(tmp_path / "f.nc")) as tree:
        assert tree["replicas"].to_dataset().equals(f.replicas) and "steady_from" in tree.attrs
    for ds in (f.dataset, f.replicas):
        for name, variable in ds.data_vars.items():
            assert name == "outcome" or {"units", "long_name"} <= set(variable.attrs), name
    assert f.plot() is not None
