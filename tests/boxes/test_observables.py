"""The registry of observables: every record is valid for every engine, in two and three dimensions."""

import functools
import itertools
import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hardlimit as hl
from conftest import draws
from hardlimit import _core
from hardlimit.boxes.box import component_axes
from hardlimit.boxes.engines import ENGINES
from hardlimit.boxes.falling_frame import engine_arguments
from hardlimit.boxes.observables import OBSERVABLES, RESERVED, Samples, components, provided

LAW = hl.LinearDashpot(stiffness=1e4, restitution=0.8)
ROUNDING = 1e-12  #: tolerance for sums that must not decrease
EXACT = 1e-12  #: largest relative error of sums over all particles


@functools.cache
def result_of(engine, dimension):
    system = hl.ParticleSystem.random(
        24, 0.2, (0.008, 0.01), 2500.0, 0.5, dimension=dimension, boundary="wall", gravity=2.0
    )
    if engine == "hard_spheres":
        return hl.event_driven(system, restitution=0.9, until=0.1, samples=10)
    return hl.molecular_dynamics(system, law=LAW, until=0.1, samples=10, engine=engine)


IN_PROCESS = [name for name, record in ENGINES.items() if record.kind]
EVERY_RESULT = list(itertools.product(IN_PROCESS, (2, 3)))
every_result = pytest.mark.parametrize("at", EVERY_RESULT, ids=lambda at: f"{at[0]} {at[1]}-D")
every_observable = pytest.mark.parametrize("name", OBSERVABLES)


@pytest.fixture(scope="module")
def units():
    from pint import UnitRegistry

    return UnitRegistry()


def test_units_are_those_of_the_table_of_the_core():
    """A record of the core that is an observable itself has the same unit; each is sampled by an engine or none."""
    table = {field["name"]: field for field in _core.observed_fields}
    assert len(table) == len(_core.observed_fields)
    assert {field["engines"] for field in table.values()} == {"all", "collisions", "contacts", ""}
    for name in table.keys() & OBSERVABLES.keys():
        assert OBSERVABLES[name].unit == table[name]["unit"], name
    recorded = {name for engine in ENGINES.values() for name in engine.records}
    assert all(need in recorded for record in OBSERVABLES.values() for need in record.needs)


@every_observable
def test_a_record_is_whole(name, units):
    record = OBSERVABLES[name]
    assert record.name == name and name not in RESERVED and record.meaning and record.needs
    for dimension in (2, 3):
        unit = re.sub(r"(?<=[a-z])(\d)", r"**\1", record.unit_in(dimension)).replace(" ", " * ")
        units.parse_units(unit)
    assert (record.kind in ("value", "sum", "rate") and record.kind == "sum") or not record.never_falls


@every_result
def test_a_series_has_what_its_engine_provides(at):
    series = result_of(*at).series
    assert list(series) == [record.name for record in provided(ENGINES[at[0]].records)]
    assert "momentum" in series and series.axis.values.tolist() == ["x", "y", "z"][: at[1]]


@every_observable
@every_result
def test_values_are_as_the_record_says(at, name):
    engine, dimension = at
    record, run = OBSERVABLES[name], result_of(*at)
    if not set(record.needs) <= set(ENGINES[engine].records):
        assert name not in run.series
        return
    values = run.series[name]
    assert values.dims == record.dims() and values.attrs["units"] == record.unit_in(dimension)
    sizes = {"scalar": (), "vector": (dimension,), "tensor": (len(components(dimension)),)}
    sizes["walls"] = (2 * dimension,)
    assert values.shape == (11, *sizes[record.shape])
    assert np.isnan(values.values[0]).all() == (record.kind == "rate")
    assert np.isfinite(values.values[1:].astype(float)).all()
    if record.kind == "sum":
        assert (values[0] == 0).all()
    if record.never_falls:
        assert (np.diff(values.values) >= -ROUNDING * abs(values.values).max()).all()


@every_result
def test_values_of_the_last_sample_are_those_of_the_system(at):
    """With the time-stepping engine to the error of a step; positions and velocities refer to the same instant."""
    run = result_of(*at)
    for name in ("kinetic_energy", "momentum", "granular_temperature"):
        last, scale = run.series[name].values[-1], abs(run.series[name].values).max()
        assert last == pytest.approx(getattr(run.system, name), rel=1e-9, abs=1e-12 * scale)


def test_components_are_in_the_order_of_lammps():
    assert components(3) == ["xx", "yy", "zz", "xy", "xz", "yz"] and components(2) == ["xx", "yy", "xy"]


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_trace_of_the_pressure_tensor_is_the_pressure(dimension):
    """With synthetic records, with and without the exact integral of the thermal energy."""
    rng, n = np.random.default_rng(dimension), len(components(dimension))
    run = result_of("hard_spheres", dimension)
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
    run = result_of("hard_spheres", 3)
    samples = Samples(run.system, run.samples)
    lasted = np.diff(run.series.time)
    assert (samples.rate("n_pairs") * lasted).sum() == pytest.approx(run.n_pairs)
    assert samples.rate("momentum").shape == (10, 3)


RULES = (
    {"restitution": 1.0},
    {"restitution": 0.9},
    {"restitution": 0.3, "rule": "tc", "rule_parameters": [1e-6]},
    {"rule": "law", "law": ("viscoelastic", 1, [1e8, 0.3, 0.7, 1.0])},
    {"rule": "soft", "law": ("linear", 0, [1e7, 0.8])},
)


@st.composite
def boxes_of_the_core(draw):
    """A random box with random boundaries, gravity, moving walls and unequal masses, and a rule."""
    d, n = draw(st.integers(2, 3)), draw(st.integers(10, 40))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    boundary = draw(st.lists(st.sampled_from(["periodic", "wall"]), min_size=d, max_size=d))
    gravity = rng.normal(size=d) * [
        draw(st.sampled_from([0.0, 1.0])) if b == "wall" else 0.0 for b in boundary
    ]
    speed = draw(st.sampled_from([0.0, 0.3]))
    walls = [
        (-1 - 2 * axis - end, 0.0, speed * rng.uniform(-1, 1), 0.0, 0.0, 0.0, "none")
        for axis, side in enumerate(boundary)
        for end in (0, 1)
        if side == "wall"
    ]
    radii = draw(st.sampled_from([0.01, (0.004, 0.01)]))
    phi = draw(st.floats(0.02, 0.2))
    gas = hl.ParticleSystem.random(n, phi, radii, 2500.0, 1.0, dimension=d, boundary=boundary, seed=1)
    drift = draw(st.sampled_from([0.0, 1.0])) * rng.normal(size=d)
    mass = np.array(gas.mass)
    if radii != 0.01:
        mass *= 10.0 ** rng.uniform(-2, 2, n)
    box = _core.Box(gas.box.tolist(), boundary, gravity.tolist(), walls)
    velocities = gas.velocities * 10.0 ** rng.uniform(-3, 0, (n, 1)) + drift
    options = draw(st.sampled_from(RULES))
    state = gas.positions, velocities, np.array(gas.radius), mass
    return _core.make_engine("hard_spheres", box, *state, **options), mass, gravity


def check_sums(engine, mass, gravity=0.0):
    """The sums are those of the particles, each axis to the digits of its own values; returns the energy [J]."""
    seen, (x, v) = engine.observe(), engine.state()
    first, second = component_axes(v.shape[1])
    tensor, axes = mass @ (v[:, first] * v[:, second]), np.sqrt(mass @ (v * v))
    energy, height = 0.5 * (axes**2).sum(), x * gravity
    assert seen["kinetic_energy"] == pytest.approx(energy, rel=EXACT)
    assert (abs(seen["momentum"] - mass @ v) <= EXACT * math.sqrt(mass.sum()) * axes).all()
    assert (abs(seen["kinetic_tensor"] - tensor) <= EXACT * axes[first] * axes[second]).all()
    assert abs(seen["potential_energy"] + (mass @ height).sum()) <= EXACT * (mass @ abs(height)).sum()
    return energy


@draws(300, deadline=None)
@given(boxes_of_the_core())
def test_sums_of_hard_spheres_are_those_of_the_velocities(system):
    """The engine updates them at each collision."""
    engine, mass, gravity = system
    for _ in range(40):
        engine.advance(engine.time + 10.0, 200)
        check_sums(engine, mass, gravity)


def test_sums_of_hard_spheres_keep_their_digits_while_the_gas_cools():
    gas = hl.ParticleSystem.random(50, 0.1, (0.008, 0.01), 2500.0, 1.0, seed=3)
    mass = np.array(gas.mass)
    settings = {"restitution": 0.3, "rule": "tc", "rule_parameters": [1e-6]}
    engine = _core.make_engine("hard_spheres", *engine_arguments(gas), **settings)
    energies = []
    for _ in range(40):
        engine.advance(math.inf, 100)
        energies.append(check_sums(engine, mass))
    assert energies[-1] < 1e-8 * energies[0]


def test_sums_of_hard_spheres_keep_their_digits_when_walls_stop_all_particles():
    """The energy falls by four decades within few collisions of each particle, before any full sum is due."""
    gas = hl.ParticleSystem.random(50, 1e-3, 0.01, 2500.0, 1e-3, boundary="wall", seed=3)
    gas = gas.replace(velocities=gas.velocities + np.array([0.0, 0.0, -1e3]))
    mass = np.array(gas.mass)
    engine = _core.make_engine(
        "hard_spheres", *engine_arguments(gas), restitution=1e-6, rule="tc", rule_parameters=[1e-9]
    )
    energies = []
    for _ in range(100):
        engine.advance(math.inf, 1)
        energies.append(check_sums(engine, mass))
    assert energies[-1] < 1e-4 * energies[0]
