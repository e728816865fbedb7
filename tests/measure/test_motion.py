"""Unfolded paths, mean square displacement and diffusion; measurements in the series of a run; their pictures."""

import math
from functools import partial

import numpy as np
import pytest
import xarray as xr

import hardlimit as hl
from box_engines import run
from conftest import lattice, refusal, slow
from hardlimit.boxes import theory
from legible import assert_legible

PATHS = {"paths": hl.measure.paths}


def ballistic(dimension=3, boundary="periodic"):
    """Particles of a lattice with one common velocity: no collisions in a periodic box."""
    system = lattice(
        n=8, dimension=dimension, boundary=boundary, density=2.5e8
    )  # heavy: for the step of `run`
    return system.replace(velocities=np.tile([0.3, -0.4, 0.8][:dimension], (system.n, 1)))


@pytest.mark.parametrize("name", ["constant", "soft", "events", "steps"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_msd_of_ballistic_flight(name, dimension):
    """v²t², exactly, although a particle crosses the box several times between samples."""
    system = ballistic(dimension)
    run_of = run(name, system, until=1.0, samples=10, observe=PATHS)
    msd = hl.measure.msd(run_of.series.paths)
    speed = {2: 0.25, 3: 0.25 + 0.64}[dimension]
    assert msd.dims == ("lag",) and msd.values == pytest.approx(
        speed * msd.lag.values**2, rel=1e-10, abs=1e-20
    )
    assert msd.attrs["units"] == "m2" and msd.lag.attrs["units"] == "s"
    along = hl.measure.msd(run_of.series.paths.sel(axis=["y"]))
    assert along.values == pytest.approx(0.16 * msd.lag.values**2, rel=1e-10, abs=1e-20)
    assert "grows as lag^2.00, must be a range of diffusion" in refusal(
        lambda: hl.measure.diffusion(run_of.series.paths, start=0.2, stop=0.4)
    )


def test_gravity_along_a_periodic_axis_is_in_the_path():
    system = ballistic(2).replace(velocities=np.zeros((8, 2)), gravity=[2.0, 0.0])
    paths = run("events", system, until=1.0, samples=4, observe=PATHS).series.paths
    fallen = paths - paths.isel(time=0)
    assert fallen.sel(axis="x").values == pytest.approx(np.outer(paths.time.values**2, np.ones(8)), rel=1e-12)
    assert hl.measure.msd(paths - paths.mean("particle")).values == pytest.approx(0.0, abs=1e-24)


def test_unfolded_positions_fold_into_the_box(tmp_path):
    system = lattice(n=20, boundary=["periodic", "wall", "periodic"])
    path = tmp_path / "run.checkpoint"
    whole = run("elastic", system, until=0.4, samples=8, observe=PATHS)
    run("elastic", system, until=0.2, samples=4, observe=PATHS, checkpoint=path)
    resumed = hl.resume(path, until=0.4, observe=PATHS)
    assert resumed.series.paths.identical(whole.series.paths)
    at = whole.system.unfolded_positions
    assert np.array_equal(at, whole.series.paths.values[-1])
    apart = (at - whole.system.positions) / system.box
    assert (
        apart == pytest.approx(np.round(apart), abs=1e-12)
        and np.abs(apart).max() > 1.0 > np.abs(apart[:, 1]).max()
    )
    assert np.array_equal(system.unfolded_positions, system.positions)


def test_msd_is_that_of_all_pairs_of_samples():
    """Against a double loop."""
    paths = run("constant", lattice(), until=0.02, samples=7, observe=PATHS).series.paths
    x = paths.values
    direct = [
        np.mean([((x[b] - x[a]) ** 2).sum(-1) for a in range(8) for b in range(8) if b - a == k])
        for k in range(8)
    ]
    assert hl.measure.msd(paths).values == pytest.approx(direct, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("density", [0.04, 0.5])
def test_diffusion_of_an_elastic_gas(density):
    """In units of 2R and √T: dilute, Enskog's D = 1.019·(3/8)/(√π n χ) (Chapman & Cowling 1970); at n (2R)³ = 0.5,
    D = 0.247 (L. Lue, J. Chem. Phys. 122, 044513 (2005)), which this periodic box lowers by 3 to 4 %. Tolerance: 4
    standard errors and 2 %."""
    start = hl.ParticleSystem.random(2000, density * math.pi / 6.0, 1e-3, 2500.0, 1.0, seed=5)
    gas, temperature = theory.gas(start), start.granular_temperature
    enskog = 1.019 * 0.375 / (math.sqrt(math.pi) * density * gas.contact_value)
    expected = enskog if density < 0.1 else 0.247 * 0.965
    time = 1.0 / float(gas.collision_rate(temperature))
    run_of = hl.event_driven(start, restitution=1.0, until=150.0 * time, samples=150, observe=PATHS)
    d = hl.measure.diffusion(run_of.series.paths)
    unit = 2e-3 * math.sqrt(temperature)
    assert abs(d.value / unit - expected) < 4.0 * d.error / unit + 0.02 * expected
    assert d.error / unit < 0.03 * expected and d.lower < d.value < d.upper


@pytest.mark.slow
def test_the_error_of_the_diffusion_coefficient():
    """Spread of D of 30 replicas over the mean error: 0.75 to 1.35 (the spread of 30 values is known to 13 %)."""
    coefficients = []
    for seed in range(30):
        start = hl.ParticleSystem.random(300, 0.2, 1e-3, 2500.0, 1.0, seed=seed)
        time = 1.0 / float(theory.gas(start).collision_rate(start.granular_temperature))
        run_of = hl.event_driven(start, restitution=1.0, until=100.0 * time, observe=PATHS)
        coefficients.append(hl.measure.diffusion(run_of.series.paths))
    ratio = np.std([coefficient.value for coefficient in coefficients], ddof=1) / np.mean(
        [coefficient.error for coefficient in coefficients]
    )
    assert 0.75 < ratio < 1.35


def test_paths_that_do_not_do_are_refused():
    paths = run("constant", lattice(), until=0.02, samples=10, observe=PATHS).series.paths
    for bad in (3, paths.values, paths.isel(axis=0), paths.drop_vars("time")):
        assert refusal(lambda bad=bad: hl.measure.msd(bad)).startswith("paths: got ")
    uneven = paths.assign_coords(time=paths.time**2)
    assert "must be two or more at equal intervals" in refusal(lambda: hl.measure.msd(uneven))
    assert "must be two or more" in refusal(lambda: hl.measure.msd(paths.isel(time=[0])))
    assert "take more samples" in refusal(lambda: hl.measure.diffusion(paths, stop=0.003))
    assert refusal(lambda: hl.measure.diffusion(paths, start=-1.0)).startswith("start: got -1")
    stopped = paths.assign_coords(time=np.append(paths.time.values[:-1], 0.0187))
    assert hl.measure.msd(stopped).sizes["lag"] == 10 and hl.measure.msd(paths).sizes["lag"] == 11


EVERYTHING = {
    "rdf": partial(hl.measure.rdf, bins=7),
    "a2": hl.measure.a2,
    "temperature": partial(hl.measure.granular_temperature, streaming="y"),
    "profile": partial(hl.measure.profiles, axis="y", bins=5),
    "contacts": partial(hl.measure.coordination, tolerance=0.5),
    **PATHS,
}


@pytest.mark.parametrize("name", ["constant", "soft", "events", "steps"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_every_measurement_is_a_variable_of_the_series(name, dimension, tmp_path):
    """Each with the labels of its function; a checkpoint keeps them."""
    system = hl.ParticleSystem.random(20, 0.1, (0.006, 0.01), 2500.0, 0.5, dimension=dimension)
    path = tmp_path / "run.checkpoint"
    run_of = run(name, system, until=0.2, samples=4, observe=EVERYTHING)
    series, last = run_of.series, run_of.system
    assert series.rdf.dims == ("time", "bin_centers") and series.a2.dims == ("time",)
    assert series.paths.dims == ("time", "particle", "axis")
    assert series.profile_mean_velocity.dims == ("time", "y", "axis")
    for variable, values in {
        "rdf": hl.measure.rdf(last, bins=7),
        "a2": hl.measure.a2(last),
        **{f"profile_{k}": v for k, v in hl.measure.profiles(last, "y", bins=5).items()},
        **{f"contacts_{k}": v for k, v in hl.measure.coordination(last, tolerance=0.5).items()},
    }.items():
        xr.testing.assert_identical(
            series[variable].isel(time=-1).drop_vars("time").rename(values.name), values
        )
    run(name, system, until=0.1, samples=2, observe=EVERYTHING, checkpoint=path)
    assert hl.resume(path, until=0.2, observe=EVERYTHING).series.identical(series)


@pytest.fixture(scope="module")
def measured():
    """A measurement of each kind."""
    box = hl.ParticleSystem.random(
        100, 0.3, (0.8e-3, 1.2e-3), 2500.0, 1.0, boundary=["periodic"] * 2 + ["wall"]
    )
    run_of = hl.event_driven(box, restitution=0.9, until=0.05, samples=50, observe=EVERYTHING)
    return {
        "rdf": hl.measure.rdf(box),
        "rdf over time": run_of.series.rdf,
        "a2 over time": run_of.series.a2,
        "an observable": run_of.series.pressure,
        "msd": hl.measure.msd(run_of.series.paths),
        "profiles": hl.measure.profiles(box, "z"),
        "profiles of spins": hl.measure.profiles(box.replace(angular_velocities=1e3 * box.velocities), "z"),
        "mean velocity": hl.measure.profiles(box, "z").mean_velocity,
        "coordination": hl.measure.coordination(box, tolerance=0.3),
        "steady": hl.measure.steady(run_of.series.pressure),
        "steady numbers": hl.measure.steady(np.arange(50.0) % 7),
        "steady of a transient": hl.measure.steady(
            5.0 * np.exp(-np.arange(500.0) / 20.0) + np.arange(500) % 3
        ),
    }


@pytest.mark.parametrize(
    "kind",
    ["profiles of spins", "steady", *map(slow, (
     "rdf", "profiles", "rdf over time", "a2 over time", "an observable", "msd", "mean velocity",
     "coordination", "steady numbers", "steady of a transient"))],
)  # fmt: skip
def test_each_has_a_picture(kind, measured):
    figure = measured[kind].plot() if kind == "steady" else hl.measure.plot(measured[kind])
    assert_legible(figure)
    assert figure.axes[0].get_ylabel() and any(ax.get_xlabel() for ax in figure.axes)


def test_what_has_no_picture_is_refused(measured):
    for bad in (
        3,
        measured["rdf over time"].isel(bin_centers=0, time=0),
        xr.Dataset(),
        hl.measure.paths(lattice()),
    ):
        assert refusal(lambda bad=bad: hl.measure.plot(bad)).startswith("measured: got ")
