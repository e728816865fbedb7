"""The registry of observables: every record is valid for every engine, in two and three dimensions."""

import itertools
import re

import numpy as np
import pytest
from pint import UnitRegistry

import hardlimit as hl
from hardlimit.boxes.engines import ENGINES
from hardlimit.boxes.observables import OBSERVABLES, RESERVED, Samples, components, provided

LAW = hl.LinearDashpot(stiffness=1e4, restitution=0.8)
ROUNDING = 1e-12  #: tolerance for sums that must not decrease


def result_of(engine, dimension):
    system = hl.ParticleSystem.random(
        24, 0.2, (0.008, 0.01), 2500.0, 0.5, dimension=dimension, boundary="wall", gravity=2.0
    )
    if engine == "hard_spheres":
        return hl.event_driven(system, restitution=0.9, until=0.1, samples=10)
    return hl.molecular_dynamics(system, law=LAW, until=0.1, samples=10, engine=engine)


IN_PROCESS = [name for name, record in ENGINES.items() if record.kind]
RESULTS = {at: result_of(*at) for at in itertools.product(IN_PROCESS, (2, 3))}
every_result = pytest.mark.parametrize("at", RESULTS, ids=lambda at: f"{at[0]} {at[1]}-D")
every_observable = pytest.mark.parametrize("name", OBSERVABLES)


@every_observable
def test_a_record_is_whole(name):
    one = OBSERVABLES[name]
    assert one.name == name and name not in RESERVED and one.meaning and one.needs
    for dimension in (2, 3):
        unit = re.sub(r"(?<=[a-z])(\d)", r"**\1", one.unit_in(dimension)).replace(" ", " * ")
        UnitRegistry().parse_units(unit)
    assert (one.kind in ("value", "sum", "rate") and one.kind == "sum") or not one.never_falls


@every_result
def test_a_series_has_what_its_engine_provides(at):
    series = RESULTS[at].series
    assert list(series) == [one.name for one in provided(ENGINES[at[0]].records)]
    assert "momentum" in series and series.axis.values.tolist() == ["x", "y", "z"][: at[1]]


@every_observable
@every_result
def test_values_are_as_the_record_says(at, name):
    engine, dimension = at
    one, run = OBSERVABLES[name], RESULTS[at]
    if not set(one.needs) <= set(ENGINES[engine].records):
        assert name not in run.series
        return
    found = run.series[name]
    assert found.dims == one.dims() and found.attrs["units"] == one.unit_in(dimension)
    sizes = {"scalar": (), "vector": (dimension,), "tensor": (len(components(dimension)),)}
    assert found.shape == (11, *sizes[one.shape])
    assert np.isnan(found.values[0]).all() == (one.kind == "rate")
    assert np.isfinite(found.values[1:].astype(float)).all()
    if one.kind == "sum":
        assert (found[0] == 0).all()
    if one.never_falls:
        assert (np.diff(found.values) >= -ROUNDING * abs(found.values).max()).all()


@every_result
def test_values_of_the_last_sample_are_those_of_the_system(at):
    """With the time-stepping engine to the error of a step; positions and velocities refer to the same instant."""
    run = RESULTS[at]
    for name in ("kinetic_energy", "momentum", "granular_temperature"):
        found, scale = run.series[name].values[-1], abs(run.series[name].values).max()
        assert found == pytest.approx(getattr(run.system, name), rel=1e-9, abs=1e-12 * scale)


def test_components_are_in_the_order_of_lammps():
    assert components(3) == ["xx", "yy", "zz", "xy", "xz", "yz"] and components(2) == ["xx", "yy", "xy"]


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_trace_of_the_pressure_tensor_is_the_pressure(dimension):
    """With synthetic records, with and without the exact integral of the thermal energy."""
    rng, n = np.random.default_rng(dimension), len(components(dimension))
    run = RESULTS["hard_spheres", dimension]
    system, time = run.system, run.samples["time"]
    virial, kinetic = rng.random((2, len(time), n)).cumsum(axis=1)
    total = system.dimension * system.mass.sum()
    records = {
        "time": time,
        "virial_tensor": virial,
        "kinetic_tensor": kinetic,
        "granular_temperature": kinetic[:, :dimension].sum(axis=1) / total,
    }
    for integral in ({}, {"kinetic_integral": rng.random(len(time)).cumsum()}):
        samples = Samples(system, records | integral)
        tensor = OBSERVABLES["pressure_tensor"].values(samples)
        assert tensor.shape == (len(time), n) and np.isnan(tensor[0]).all()
        pressure = OBSERVABLES["pressure"].values(samples)[1:]
        assert tensor[1:, :dimension].mean(axis=1) == pytest.approx(pressure, rel=1e-12)


def test_a_rate_is_the_growth_of_its_sum():
    run = RESULTS["hard_spheres", 3]
    samples = Samples(run.system, run.samples)
    lasted = np.diff(run.series.time)
    assert (samples.rate("n_pairs") * lasted).sum() == pytest.approx(run.n_pairs)
    assert samples.rate("momentum").shape == (10, 3)


@pytest.mark.parametrize("boundary", ["periodic", "wall"])
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("restitution", [1.0, 0.5])
def test_running_sums_of_hard_spheres_are_those_of_the_velocities(dimension, boundary, restitution):
    """The engine updates them at each collision; the energy of the dissipative gas falls by many decades."""
    gas = hl.ParticleSystem.random(
        50, 0.2, (0.01, 0.015), 2500.0, 1.0, dimension=dimension, boundary=boundary, seed=3
    )

    def sums(time, system):
        m, v = system.mass, system.velocities
        return {"energy": 0.5 * m @ (v * v).sum(axis=1), "drift": m @ v, "scale": m @ np.abs(v)}

    run = hl.event_driven(
        gas, restitution=restitution, rule="tc", contact_duration=1e-6, max_collisions=4000, observe=sums
    )
    seen = run.series
    assert seen.kinetic_energy.values == pytest.approx(seen.energy.values, rel=1e-13)
    assert (np.abs(seen.momentum.values - seen.drift.values) <= 1e-13 * seen.scale.values).all()
    fallen = seen.kinetic_energy.values[-1] / seen.kinetic_energy.values[0]
    assert fallen == pytest.approx(1.0) if restitution == 1.0 else fallen < 1e-3
