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
ROUGH = hl.LinearDashpot(stiffness=1e4, restitution=0.8, friction=hl.Friction(coefficient=0.5))
ROUNDING = 1e-12  #: tolerance for sums that must not decrease
EXACT = 1e-12  #: largest relative error of sums over all particles


def spinning(system, size, seed=1):
    """The system with random angular velocities of this size [rad/s]."""
    axes = (3,) if system.dimension == 3 else ()
    spins = size * np.random.default_rng(seed).normal(size=(system.n, *axes))
    return system.replace(angular_velocities=spins)


@functools.cache
def result_of(engine, dimension, friction=False):
    system = hl.ParticleSystem.random(
        24, 0.2, (0.008, 0.01), 2500.0, 0.5, dimension=dimension, boundary="wall", gravity=2.0
    )
    if friction:
        system = spinning(system, 30.0)
    if engine == "hard_spheres":
        rough = {"friction": 0.5, "tangential_restitution": 0.4} if friction else {}
        return hl.event_driven(system, restitution=0.9, until=0.1, samples=10, **rough)
    law = ROUGH if friction else LAW
    return hl.molecular_dynamics(system, law=law, until=0.1, samples=10, engine=engine)


IN_PROCESS = [name for name, record in ENGINES.items() if record.kind]
#: Engines in this process that run friction: all of them.
ROTATING = ["hard_spheres", "events", "steps"]
EVERY_RESULT = [
    *itertools.product(IN_PROCESS, (2, 3), (False,)),
    *itertools.product(ROTATING, (2, 3), (True,)),
]
every_result = pytest.mark.parametrize(
    "at", EVERY_RESULT, ids=lambda at: f"{at[0]} {at[1]}-D{' friction' * at[2]}"
)


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


@pytest.mark.parametrize("name", OBSERVABLES)
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
    expected = [record.name for record in provided(ENGINES[at[0]].records) if at[2] or not record.of_friction]
    assert list(series) == expected and at[2] == ("spin" in series)
    assert "momentum" in series and series.axis.values.tolist() == ["x", "y", "z"][: at[1]]


@every_result
def test_values_are_as_the_record_says(at):
    for name in OBSERVABLES:
        check_values(name, *at)


def check_values(name, engine, dimension, friction):
    record, run = OBSERVABLES[name], result_of(engine, dimension, friction)
    if not set(record.needs) <= set(ENGINES[engine].records) or (record.of_friction and not friction):
        assert name not in run.series
        return
    values = run.series[name]
    assert values.dims == record.dims(dimension), name
    assert values.attrs["units"] == record.unit_in(dimension)
    sizes = {"scalar": (), "vector": (dimension,), "tensor": (len(components(dimension)),)}
    sizes |= {"walls": (2 * dimension,), "axial": (3,) if dimension == 3 else ()}
    assert values.shape == (11, *sizes[record.shape]), name
    assert np.isnan(values.values[0]).all() == (record.kind == "rate"), name
    assert np.isfinite(values.values[1:].astype(float)).all(), name
    if record.kind == "sum":
        assert (values[0] == 0).all()
    if record.never_falls and not (friction and name == "dissipated_energy"):
        assert (np.diff(values.values) >= -ROUNDING * abs(values.values).max()).all()


@every_result
def test_values_of_the_last_sample_are_those_of_the_system(at):
    """With the time-stepping engine to the error of a step; positions and velocities refer to the same instant."""
    run = result_of(*at)
    of_rotation = ("rotational_energy", "rotational_temperature") if at[2] else ()
    for name in ("kinetic_energy", "momentum", "granular_temperature", *of_rotation):
        last, scale = run.series[name].values[-1], abs(run.series[name].values).max()
        assert last == pytest.approx(getattr(run.system, name), rel=1e-9, abs=1e-12 * scale)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("engine", ROTATING)
def test_rotation_in_the_series_and_in_the_table(engine, dimension):
    """Spins, temperatures and losses follow from the state and from the sums; the table has the first and last ones."""
    run = result_of(engine, dimension, friction=True)
    series, system = run.series, run.system
    spins = system.inertia @ system.angular_velocities
    assert series.spin.values[-1] == pytest.approx(spins, rel=1e-9, abs=1e-15)
    axes = 1 if dimension == 2 else 3
    twice = 2.0 * series.rotational_energy.values / (axes * system.mass.sum())
    assert series.rotational_temperature.values == pytest.approx(twice, rel=1e-14)
    ratio = twice / series.granular_temperature.values
    assert series.temperature_ratio.values == pytest.approx(ratio, rel=1e-14)
    both = series.friction_loss + series.damping_loss
    assert both.values == pytest.approx(series.dissipated_energy.values, rel=1e-12)
    assert series.friction_loss[-1] > 0.0 and series.damping_loss[-1] > 0.0
    rates = (series.friction_loss_rate + series.damping_loss_rate)[1:]
    assert rates.values == pytest.approx(series.dissipation_rate.values[1:], rel=1e-9)
    if "tangential_energy" in series:
        assert (series.tangential_energy <= series.contact_energy * (1.0 + 1e-12)).all()
        assert series.tangential_energy.max() > 0.0
    table = dict(run.quantities())
    assert table["rotational temperature at the start [m²/s²]"] == twice[0]
    assert table["rotational temperature at the end [m²/s²]"] == twice[-1]
    assert table["temperature ratio θ = T_r/T at the end"] == ratio[-1]
    assert table["energy lost by friction [J]"] == series.friction_loss[-1]
    assert "energy lost by friction" in run._repr_html_()
    columns = run.to_dataframe().columns
    assert ("spin" in columns) == (dimension == 2) == ("spin_z" not in columns)


def test_without_friction_no_rotation_is_shown():
    system = spinning(hl.ParticleSystem.random(20, 0.1, 0.01, 2500.0, 0.5), 30.0)
    run = hl.event_driven(system, restitution=0.9, until=0.05, samples=2)
    assert "spin" not in run.series and not any("rotation" in label for label, _ in run.quantities())


def test_the_ratio_of_temperatures_is_unknown_where_nothing_moves():
    """Spinning spheres at rest; those at T > 0 have T_r/T."""
    run = result_of("hard_spheres", 3)
    records = {"rotational_energy": np.array([1.0, 1.0]), "granular_temperature": np.array([0.0, 0.5])}
    ratio = OBSERVABLES["temperature_ratio"].values(Samples(run.system, records | {"time": np.arange(2.0)}))
    expected = 2.0 / (3.0 * run.system.mass.sum()) / 0.5
    assert math.isnan(ratio[0]) and ratio[1] == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("friction", [False, True])
def test_bytes_of_a_row_of_the_log(friction):
    """As the docstrings of the two functions say."""
    system = spinning(hl.ParticleSystem.random(20, 0.2, 0.01, 2500.0, 0.5), 30.0)
    law = ROUGH if friction else LAW
    run = hl.molecular_dynamics(system, law=law, until=0.02, engine="steps", log=True)
    assert sum(column.itemsize for column in run.log) == (66 if friction else 49)
    assert ("slid" in run.contacts) == friction
    doc = "".join(f.__doc__ for f in (hl.event_driven, hl.molecular_dynamics))
    assert "40 bytes each, 57 with friction" in doc and "49 bytes each, 66 with friction" in doc


def test_components_are_in_the_order_of_lammps():
    assert components(3) == ["xx", "yy", "zz", "xy", "xz", "yz"] and components(2) == ["xx", "yy", "xy"]


RULES = (
    {"restitution": 1.0},
    {"restitution": 0.9},
    {"restitution": 0.3, "rule": "tc", "rule_parameters": [1e-6]},
    {"rule": "law", "law": ("viscoelastic", 1, [1e8, 0.3, 0.7, 1.0], None)},
    {"rule": "soft", "law": ("linear", 0, [1e7, 0.8], None)},
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


@draws(100, deadline=None)
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
