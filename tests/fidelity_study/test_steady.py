"""hl.fidelity for driven boxes: where the steady state begins, averages over it and their errors."""

import math
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import scipy

import hardlimit as hl
from conftest import refusal, slow
from hardlimit.fidelity_study import report, steady
from hardlimit.fidelity_study.observables import NEAR, Observer
from hardlimit.fidelity_study.starts import Starts
from hardlimit.measure.pairs import near
from hardlimit.measure.steadiness import DECAYS, half_widths

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
    detected = steady.detected({("T", "of x"): noise + drift}, np.arange(1001.0))
    assert math.isnan(detected.start) and "still changes by" in detected.reason
    assert steady.detected({("T", "of x"): noise}, np.arange(1001.0)).reason == ""


@pytest.mark.parametrize("sets", [20, slow(100)])
def test_stationary_series_are_rarely_refused(sets: int) -> None:
    """0.1 % of the sets of two correlated series; the inefficiency of short series is a little too small."""
    rng = np.random.default_rng(5)
    refused = 0
    for _ in range(sets):
        noise = rng.standard_normal((2, 1, 200))
        noise[..., 1:] += 0.6 * noise[..., :-1]
        series = {(str(k), ""): 1.0 + 0.1 * row for k, row in enumerate(noise)}
        refused += steady.detected(series, np.arange(201.0)).reason != ""
    assert refused <= max(1, sets // 50)


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
        driving = sum(np.diff(series[name]) / dt for name in ("wall_work", "heat") if name in series)
        np.testing.assert_allclose(raw.interval_driving_power, driving, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(raw.interval_pressure_tensor, series.pressure_tensor[1:], rtol=1e-12)


@pytest.mark.parametrize(
    ("make", "replicas"), [slow(heated, 1), slow(heated, 3), (bathed, 2), slow(shaken, 2)]
)
def test_the_report_has_the_numbers_of_the_raw_series(make: object, replicas: int) -> None:
    source = make if make is shaken else make()
    rule = "tc" if make is shaken else "constant"  # others would end at a wall
    until = 0.1 if make is bathed else 0.3
    f = study(source, replicas, until=until, samples=180, models=("newton", rule))
    assert f.steady.reason == "", f.steady
    k = int(np.searchsorted(f.plan.times, f.steady.start))
    assert f.steady.first == k and f"Steady from {f.steady.start:.3g} s on" in str(f)
    raw = f.replicas.isel(interval=slice(k, None), time=slice(k + 1, None))
    for name in EXAMINED:
        both = raw[name if name == "granular_temperature" else f"interval_{name}"]
        newton, ruled = (both.sel(model=model).values for model in f.models)
        means = [values.mean(axis=1) for values in (newton, ruled)]
        value = means[1].mean() / means[0].mean() - 1.0
        difference = f.final_difference(name, rule)
        if replicas > 1:
            residual = (means[1] - means[1].mean() / means[0].mean() * means[0]) / means[0].mean()
            error, freedom = residual.std(ddof=1) / math.sqrt(replicas), replicas - 1
        else:
            widths = [half_widths(row[0], (0.6827, 0.99), DECAYS) for row in (newton, ruled)]
            scales = (1.0 + value) / newton.mean(), 1.0 / newton.mean()
            error, half = np.linalg.norm(np.array(widths) * np.array(scales)[:, None], axis=0)
        assert difference.value == pytest.approx(value, abs=1e-12)
        assert difference.error == pytest.approx(error, rel=1e-9)
        if replicas > 1:
            half = scipy.stats.t.ppf(0.995, freedom) * error
        assert difference.upper - difference.value == pytest.approx(half, rel=1e-9)
        assert f.dataset.steady_difference.sel(quantity=name, model=rule).values.tolist() == list(
            difference[:2]
        )
        mean = f.steady_mean(name, "newton")
        assert mean.value == pytest.approx(means[0].mean(), rel=1e-12)
        assert f.dataset[f"steady_{name}"].sel(model="newton").values.tolist() == list(mean[:2])
        size = report.percent_with_error(difference.value, difference.error)
        assert f"{report.NAMES[name]} {size}" in str(f)
    rate = f.steady_mean("collision_rate", "newton").value
    assert f.tc_nu == pytest.approx(rate * f.contact_duration)


@pytest.mark.slow
def test_one_replica_differs_from_its_like_as_often_as_its_bars_say() -> None:
    """Heated hard spheres with other kicks are the same model: about 1 % are outside the 99 % bars (here 0 to 4 %)."""
    series = {name: [] for name in ("granular_temperature", "pressure", "collision_rate")}
    for seed in range(120):
        gas = heated(seed).replace(thermostat=hl.RandomKicks(0.16, 1.3e-4, seed=seed))
        run = hl.event_driven(gas, restitution=0.8, until=0.13, samples=100).series
        for name, values in series.items():
            values.append(run[name].values[1:])
    state = steady.SteadyState(30, 0.04)
    pairs = [
        steady.difference(np.array(values[k : k + 1]), np.array(values[k + 1 : k + 2]), state)
        for values in series.values()
        for k in range(0, 120, 2)
    ]
    assert np.mean([not pair.lower <= 0.0 <= pair.upper for pair in pairs]) <= 0.04


@pytest.mark.slow
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
    assert len({tuple(powers) for powers in power}) == 3
    again = study(heated, 3, until=2e-3, samples=10)
    assert (
        len({tuple(powers) for powers in again.replicas.interval_driving_power.sel(model="newton").values})
        == 3
    )


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
    with xr.open_dataset(f.save(tmp_path / "f.nc"), group="replicas") as replicas:
        assert replicas.equals(f.replicas) and "steady_from" in f.dataset.attrs
    assert hl.load(tmp_path / "f.nc").summary() == f.summary()
    for ds in (f.dataset, f.replicas):
        for name, variable in ds.data_vars.items():
            assert name == "outcome" or {"units", "long_name"} <= set(variable.attrs), name


# --- sheared boxes ----------------------------------------------------------------------------------------------


def sheared(
    seed: int = 0, n: int = 60, rate: float = 250.0, phi: float = 0.3, **more: object
) -> hl.ParticleSystem:
    sides = ("periodic", "lees-edwards", "periodic")
    options = {"seed": seed, "boundary": sides, "shear_rate": rate} | more
    return hl.ParticleSystem.random(n, phi, 1e-3, 2500.0, 1.0, **options)


def test_a_sheared_box_is_driven() -> None:
    assert sheared().driven and not sheared(rate=0.0).driven
    f = study(sheared(rate=0.0), 1, until=1e-4, samples=2)
    assert not f.driven and "shear_stress" not in f.quantities


@pytest.mark.parametrize(
    ("rate", "sides"),
    [
        (250.0, ("periodic", "lees-edwards", "periodic")),
        (-250.0, ("periodic", "periodic", "lees-edwards")),
        slow(-250.0, ("periodic", "lees-edwards", "periodic")),
        slow(250.0, ("periodic", "periodic", "lees-edwards")),
    ],
)
def test_stresses_of_a_sheared_box_are_those_of_its_runs(rate: float, sides: tuple[str, ...]) -> None:
    """Each interval, and the mean since the start; the shear stress has the sign of the rate."""
    system = sheared(n=40, rate=rate, boundary=sides)
    f = study(system, replicas=1, until=0.01, samples=10, engine="events")
    runs = {
        "newton": hl.molecular_dynamics(system, law=LAW, until=0.01, samples=10, engine="events"),
        "constant": hl.event_driven(system, restitution=0.8, until=0.01, samples=10),
    }
    gradient = "y" if sides[1] == "lees-edwards" else "z"
    for model, run in runs.items():
        tensor, dt = run.series.pressure_tensor[1:], np.diff(run.series.time)
        stress = -tensor.sel(component="x" + gradient).values
        normal = (tensor.sel(component=2 * gradient) - tensor.sel(component="xx")).values
        np.testing.assert_allclose(f.series("shear_stress", model)[0], stress, rtol=1e-12)
        np.testing.assert_allclose(f.series("first_normal_stress_difference", model)[0], normal, rtol=1e-12)
        means = f.replicas.shear_stress.sel(model=model, replica=0).values[1:]
        np.testing.assert_allclose(means, np.cumsum(stress * dt) / np.cumsum(dt), rtol=1e-12)
        assert rate * stress.mean() > 0.0
        work = np.diff(run.series.shear_work) / dt
        np.testing.assert_allclose(f.replicas.interval_driving_power.sel(model=model)[0], work, rtol=1e-9)


@pytest.mark.slow
def test_stress_times_rate_is_the_dissipation() -> None:
    """In the steady state, within 4 standard errors of both; the summary names what it compares."""
    rate = 250.0
    f = study(sheared(rate=rate), 4, until=0.2, samples=400, engine="events")
    assert f.steady.reason == "", f.steady
    for model in f.models:
        lost, stress = f.steady_mean("dissipation_rate", model), f.steady_mean("shear_stress", model)
        work = stress.value * rate * f.start.domain.volume
        error = math.hypot(lost.error, stress.error / stress.value * work)
        assert abs(lost.value - work) < 4.0 * error + 0.01 * work and error < 0.1 * work
        assert abs(f.nonlinear_flow(model)) < report.BANDED
    assert (
        f"shear stress {report.percent_with_error(*f.final_difference('shear_stress', 'constant')[:2])}"
        in str(f)
    )
    assert "The law of the error predicts, in temperature," in str(f)
    assert {"steady_shear_stress", "nonlinear_flow"} <= set(f.dataset)


def test_replicas_of_a_sheared_box_keep_flow_and_temperature() -> None:
    system = sheared(n=200)
    other = Starts(system, 5).start(1, lambda done, total: None)
    assert other.shear_rate == system.shear_rate and not np.array_equal(other.positions, system.positions)
    assert other.granular_temperature == pytest.approx(system.granular_temperature, rel=1e-12)
    slope = np.polyfit(other.positions[:, 1], other.velocities[:, 0], 1)[0]
    noise = math.sqrt(system.granular_temperature / 200.0) / other.positions[:, 1].std()
    assert abs(slope - 250.0) < 4.0 * noise < 125.0


@pytest.mark.parametrize("seed", range(3))
def test_a_flow_in_layers_is_noticed(seed: int) -> None:
    """0 on average for thermal motion, near 1 for two plugs; also for unfolded paths at a later time."""
    system = sheared(seed, n=400)
    observer = Observer(system)
    shares = []
    rng = np.random.default_rng(seed)
    for _ in range(20):
        thermal = rng.standard_normal((400, 3)) + system.domain.mean_flow(system.positions)
        shares.append(observer.nonlinear_flow(system.positions, thermal))
    assert abs(np.mean(shares)) < 0.01
    height = system.positions[:, 1] / system.box[1]
    plugs = system.domain.mean_flow(system.positions)
    plugs[:, 0] += np.where(height < 0.5, 30.0, -30.0) + 3.0 * rng.standard_normal(400)
    assert observer.nonlinear_flow(system.positions, plugs) > 0.95
    time, turns = 0.013, rng.integers(-3, 4, 400)
    away, moving = system.positions.copy(), plugs.copy()
    away[:, 1] += turns * system.box[1]
    away[:, 0] += turns * (system.shear_displacement + system.shear_rate * system.box[1] * time)
    moving[:, 0] += turns * system.shear_rate * system.box[1]
    here = observer.nonlinear_flow(system.positions, plugs, time)
    assert observer.nonlinear_flow(away, moving, time) == pytest.approx(here, rel=1e-9)
    assert observer.pair_correlation(away, time) == observer.pair_correlation(system.positions, time)


def test_pairs_across_a_sheared_side_are_found() -> None:
    """All pairs of a sheared box at a time, against nearest images one by one."""
    system, time = sheared(3, n=150, phi=0.4), 0.0171
    shift = system.domain.displacement_after(time)
    assert 0.0 < shift < system.box[0]
    count = 0
    for i in range(150):
        r = system.positions[i + 1 :] - system.positions[i]
        turn = np.round(r[:, 1] / system.box[1])
        r[:, 1] -= turn * system.box[1]
        r[:, 0] -= turn * shift
        r[:, [0, 2]] -= system.box[[0, 2]] * np.round(r[:, [0, 2]] / system.box[[0, 2]])
        count += int(np.count_nonzero(np.linalg.norm(r, axis=1) < 1.1 * 2e-3))
    counts = [len(near(system, system.positions, NEAR, t)[0]) for t in (time, 0.0)]
    assert counts[0] == count > counts[1] - 30


def test_shear_bands_and_elastic_grains_are_refused() -> None:
    system = sheared()
    f = study(system, 2, until=0.03, samples=60, engine="events")
    banded = [arrays | {"nonlinear_flow": np.full_like(arrays["nonlinear_flow"], 0.6)} for arrays in f.arrays]
    g = replace(f, arrays=tuple(banded))
    object.__setattr__(g, "steady", steady.SteadyState(20, 0.01))  # the run is too short to find it
    assert g.nonlinear_flow("constant") == pytest.approx(0.6)
    assert str(g).startswith(
        "No verdict: shear bands under Newton’s equations and the rule constant, 60 % of"
    )
    elastic = hl.LinearDashpot(stiffness=3e5, restitution=1.0)
    for text, more in (("law", {"law": elastic}), ("restitution", {"law": LAW, "restitution": 1.0})):
        refused = refusal(lambda more=more: hl.fidelity(system, until=1e-3, replicas=2, **more))
        assert refused.startswith(f"{text}: got ε = 1 in a sheared box, must be < 1")
