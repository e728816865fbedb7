"""Particle systems: immutable values, input checks, and random initial states."""

import copy
import itertools
import math
import pickle

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import hardlimit as hl
from box_engines import box_of
from conftest import draws, lattice, refusal
from hardlimit import _core


def pair(gap=1e-3, **changed):
    """Two spheres at rest on the x axis of a box of 2 cm."""
    at = np.array([[5e-3, 0.01, 0.01], [5e-3 + 2e-3 + gap, 0.01, 0.01]])
    values = {"positions": at, "velocities": np.zeros((2, 3)), "radius": 1e-3, "mass": 1.0, "box": 0.02}
    return hl.ParticleSystem(**(values | changed))


# --- values -------------------------------------------------------------------------------------------------


def test_it_never_changes():
    at = np.array([[0.01, 0.01], [0.03, 0.03]])
    system = hl.ParticleSystem(at, np.ones((2, 2)), np.array([1e-3, 2e-3]), mass=1.0, box=[0.05, 0.04])
    at[:] = 7.0
    assert system.positions.tolist() == [[0.01, 0.01], [0.03, 0.03]]
    for name in ("positions", "velocities", "radius", "mass", "box", "gravity"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(system, name)[0] = 1.0
    with pytest.raises(AttributeError):
        system.radius = np.ones(2)
    assert (system.n, system.dimension, system.boundary) == (2, 2, ("periodic", "periodic"))


def test_equal_values_are_equal_systems():
    left, other = lattice(seed=1), lattice(seed=1)
    assert left == other and hash(left) == hash(other) and left != lattice(seed=2)
    for copied in (pickle.loads(pickle.dumps(left)), copy.copy(left), copy.deepcopy(left)):
        assert copied == left and hash(copied) == hash(left)
        assert not copied.positions.flags.writeable
    assert left != left.replace(gravity=9.81) and left != left.replace(
        boundary=("wall", "periodic", "periodic")
    )
    assert left != 3 and len({left, other}) == 1
    minus = pair(velocities=-np.zeros((2, 3)))
    assert minus == pair() and hash(minus) == hash(pair())


def test_quantities():
    system = lattice(30, seed=3, spread=2.0)
    m, v = np.asarray(system.mass), np.asarray(system.velocities)
    assert system.kinetic_energy == pytest.approx(0.5 * sum(a * b @ b for a, b in zip(m, v, strict=True)))
    assert system.momentum == pytest.approx(sum(a * b for a, b in zip(m, v, strict=True)))
    mean = system.momentum / m.sum()
    by_hand = sum(a * (b - mean) @ (b - mean) for a, b in zip(m, v, strict=True)) / (3 * m.sum())
    assert system.granular_temperature == pytest.approx(by_hand)
    volumes = 4 / 3 * math.pi * system.radius**3
    assert system.packing_fraction == pytest.approx(volumes.sum() / system.box.prod())
    assert system.density == pytest.approx(m / volumes)
    moving = system.replace(velocities=v + 100.0)
    assert moving.granular_temperature == pytest.approx(system.granular_temperature, rel=1e-9)


def test_disks_with_a_density_have_the_mass_of_spheres():
    system = hl.ParticleSystem([[0.01, 0.01]], [[0.0, 0.0]], 1e-3, density=2500.0, box=0.05)
    assert system.mass[0] == hl.Ball(1e-3, density=2500.0).mass
    assert system.packing_fraction == pytest.approx(math.pi * 1e-6 / 0.05**2)


@pytest.mark.parametrize("radius", [1e-3, [1e-3, 2e-3]])
def test_masses_are_those_of_balls(radius):
    system = pair(gap=5e-3, radius=radius, mass=None, density=[2500.0, 1000.0])
    radii = np.broadcast_to(radius, 2)
    balls = [hl.Ball(r, density=d) for r, d in zip(radii, (2500.0, 1000.0), strict=True)]
    assert system.mass.tolist() == [ball.mass for ball in balls]


def test_gravity_and_sides():
    assert pair(gravity=9.81).gravity.tolist() == [0.0, 0.0, -9.81]
    assert pair(gravity=[1.0, 2.0, 3.0]).gravity.tolist() == [1.0, 2.0, 3.0]
    assert pair(boundary="wall").boundary == ("wall",) * 3
    assert pair(boundary=["wall", "periodic", "wall"]).boundary == ("wall", "periodic", "wall")


def test_dataset_and_table():
    system = lattice(8)
    ds = system.dataset
    assert ds.sizes == {"particle": 8, "axis": 3} and ds.position.attrs["units"] == "m"
    assert ds.velocity.sel(axis="y").values.tolist() == system.velocities[:, 1].tolist()
    text = system.replace(gravity=9.81)._repr_html_()
    assert "8 spheres" in text and "gravity" in text and "packing fraction" in repr(system)


def test_replace():
    system = lattice(8)
    assert system.replace() == system
    faster = system.replace(velocities=2.0 * system.velocities)
    assert faster.kinetic_energy == pytest.approx(4.0 * system.kinetic_energy)
    smaller = system.replace(radius=0.5e-3)
    assert smaller.mass.tolist() == system.mass.tolist()
    lighter = system.replace(radius=0.5e-3, density=2500.0)
    assert lighter.mass == pytest.approx(system.mass / 8.0)
    with pytest.raises(ValueError, match=r"^density \| mass: got both, must be at most one of them$"):
        system.replace(density=1.0, mass=1.0)
    with pytest.raises(ValueError, match=r"^box: got 0\.003 along x \(periodic\), must be >= 0\.004"):
        system.replace(box=0.003)


# --- checks -------------------------------------------------------------------------------------------------

BAD = {
    "NaN": ({"positions": [[0.01, math.nan, 0.0]]}, r"positions\[0\]: got \[0.01, nan, 0.0\], must be finite"),
    "infinite": ({"velocities": [[0.0, 0.0, 0.0], [0.0, math.inf, 0.0]]}, r"velocities\[1\]: got .*, must be finite"),
    "one dimension": ({"positions": [0.01, 0.01]}, r"positions: got shape \(2,\), must be \(N, 2\) or \(N, 3\)"),
    "four columns": ({"positions": np.ones((2, 4))}, r"positions: got shape \(2, 4\)"),
    "none": ({"positions": np.ones((0, 3))}, r"positions: got shape \(0, 3\), must be .* with N >= 1"),
    "text": ({"positions": "abc"}, r"positions: got 'abc', must be numbers of shape"),
    "velocities of a plane": ({"velocities": np.zeros((2, 2))}, r"velocities: got shape \(2, 2\), must be \(N, 3\)"),
    "one velocity": ({"velocities": np.zeros((1, 3))}, r"velocities: got shape \(1, 3\), must be \(2, 3\)"),
    "fast": ({"velocities": np.full((2, 3), 1e31)}, r"velocities: got 1e\+31, must be at most 1e\+30"),
    "three radii": ({"radius": [1e-3] * 3}, r"radius: got 3 values, must be 2"),
    "negative radius": ({"radius": [1e-3, -1.0]}, r"radius\[1\]: got -1, must be in \[1e-30, 1e\+30\]"),
    "tiny radius": ({"radius": 1e-31}, r"radius: got 1e-31, must be in \[1e-30, 1e\+30\]"),
    "huge box": ({"box": 1e31}, r"box: got .*1e\+31, must be in \[1e-30, 1e\+30\]"),
    "no radius": ({"radius": 0.0}, r"radius: got 0, must be"),
    "no mass": ({"mass": None}, r"density \| mass: got neither, must be exactly one of them"),
    "both": ({"density": 1.0}, r"density \| mass: got both, must be exactly one of them"),
    "massless": ({"mass": [1.0, 0.0]}, r"mass\[1\]: got 0, must be > 0"),
    "too light": ({"mass": 1e-200}, r"radius \| mass: got 0.001 and 1e-200 for particle 0, a mass of 1e-200 kg"),
    "too heavy": ({"mass": None, "density": 1e300}, r"radius \| density: got .*, must be in \[1e-100, 1e\+100\]"),
    "flat box": ({"box": [0.02, 0.02]}, r"box: got 2 values, must be 3"),
    "negative box": ({"box": [0.02, 0.02, -1.0]}, r"box\[2\]: got -1, must be"),
    "small box": ({"radius": 6e-3}, r"box: got 0.02 along x \(periodic\), must be >= 0.024, 4 times the largest"),
    "small walls": ({"radius": 0.011, "boundary": "wall"}, r"box: .* \(wall\), must be >= 0.022, 2 times the largest"),
    "outside": ({"box": [0.02, 0.009, 0.02]}, r"positions\[0\]: got y = 0.01, must be in \[0, 0.009\], in the box"),
    "in the wall": (
        {"boundary": "wall", "positions": [[0.0005, 0.01, 0.01], [0.01, 0.01, 0.01]]},
        r"positions\[0\]: got x = 0.0005, must be in \[0.001, 0.019\], with its whole radius between the walls",
    ),
    "other sides": ({"boundary": "open"}, r"boundary: got 'open', must be one of periodic, wall"),
    "two sides": ({"boundary": ["wall", "wall"]}, r"boundary: got 2 words, must be 1, or 3"),
    "a side of number": ({"boundary": [1, 2, 3]}, r"boundary\[0\]: got 1, must be a word"),
    "gravity of a plane": ({"gravity": [0.0, 9.81]}, r"gravity: got 2 values, must be 3"),
    "NaN gravity": ({"gravity": math.nan}, r"gravity: got nan, must be"),
    "negative allowance": ({"allowed_overlap": -0.1}, r"allowed_overlap: got -0.1, must be in \[0, 1\)"),
}  # fmt: skip


@pytest.mark.parametrize("which", BAD)
def test_bad_input_is_refused_in_one_line(which):
    changed, message = BAD[which]
    with pytest.raises(ValueError, match=f"^{message}") as refusal:
        pair(**changed)
    assert "\n" not in str(refusal.value) and len(str(refusal.value)) < 300


def test_an_overlap_names_the_particles():
    with pytest.raises(
        ValueError, match=r"^positions: particles 0 and 1 overlap, gap -0.0001 m, must be >= -"
    ):
        pair(gap=-1e-4)
    assert pair(gap=-1e-4, allowed_overlap=0.06).n == 2
    assert pair(gap=0.0).n == 2
    across = {"positions": [[1e-4, 0.01, 0.01], [0.0199, 0.01, 0.01]]}
    with pytest.raises(ValueError, match=r"particles 0 and 1 overlap, gap -0\.0018"):
        pair(**across)
    with pytest.raises(ValueError, match="must be in"):
        pair(**across, boundary=["wall", "periodic", "periodic"])


def test_a_system_that_overlaps_can_still_be_changed():
    """The final state of a soft run may have a pair in contact and a particle in a wall."""
    at = [[0.9e-3, 0.01, 0.01], [2.8e-3, 0.01, 0.01]]
    soft = pair(positions=at, boundary="wall", allowed_overlap=0.2)
    faster = soft.replace(velocities=np.ones((2, 3)), gravity=1.0)
    assert faster.positions.tolist() == at
    with pytest.raises(ValueError, match="must be in"):
        soft.replace(box=0.03)


def slowest(at, radius, box, periodic):
    """The deepest overlap, by a search over all pairs and all images."""
    best = (-1, -1, 0.0, 0.0)
    for i, j in itertools.combinations(range(len(at)), 2):
        d = at[i] - at[j]
        shifts = itertools.product(*[(-1, 0, 1) if wrapped else (0,) for wrapped in periodic])
        nearest = min(math.dist(d + np.array(shift) * box, np.zeros(len(d))) for shift in shifts)
        gap, apart = nearest - radius[i] - radius[j], radius[i] + radius[j]
        if gap < 0.0 and gap / apart < best[3]:
            best = (i, j, gap, gap / apart)
    return best[:3]


@draws(150)
@given(st.data())
def test_overlaps_are_those_of_all_pairs(data):
    """Random systems of any size ratio, dense and dilute, with one or many particles per cell."""
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32)))
    d, n = data.draw(st.integers(2, 3)), data.draw(st.integers(1, 40))
    ratio = 10.0 ** data.draw(st.floats(0.0, 3.0))
    radius = ratio ** rng.uniform(-1.0, 0.0, n)
    box = 4.0 * radius.max() * rng.uniform(1.0, data.draw(st.floats(1.0, 30.0)), d)
    periodic = [bool(flag) for flag in rng.integers(0, 2, d)]
    at = rng.uniform(0.0, box, (n, d))
    at[rng.random((n, d)) < 0.1] = 0.0  # on a side
    first, second, gap = _core.deepest_overlap(box_of(box, periodic), at, radius)
    assert (first, second, gap) == pytest.approx(slowest(at, radius, box, periodic), rel=1e-9)


def test_the_core_refuses_what_no_system_says():
    at, radius, bounds = np.ones((2, 3)), np.ones(2), box_of(np.full(3, 5.0), True)
    for wrong in ({"positions": np.ones((2, 4))}, {"radius": np.ones(3)}):
        arguments = {"box": bounds, "positions": at, "radius": radius} | wrong
        with pytest.raises(ValueError, match=f"^{next(iter(wrong))}"):
            _core.deepest_overlap(**arguments)
    outside = np.array([[-1e300, np.nan, 1e300], [1.0, 1.0, 1.0]])
    assert _core.deepest_overlap(box_of(np.full(3, 5.0), False), outside, radius)[0] == -1


# --- random initial states --------------------------------------------------------------------------------------

USUAL = {"n": 200, "packing_fraction": 0.3, "radius": 1e-3, "density": 2500.0, "rms_speed": 0.5}


def rms(system):
    return math.sqrt(float(np.mean(np.sum(np.asarray(system.velocities) ** 2, axis=1))))


@pytest.mark.parametrize("changed", [
    {}, {"packing_fraction": 0.01}, {"packing_fraction": 0.55}, {"dimension": 2, "packing_fraction": 0.75},
    {"boundary": "wall", "packing_fraction": 0.4}, {"boundary": ["wall", "periodic", "periodic"]},
    {"radius": (0.5e-3, 2e-3)}, {"n": 2, "packing_fraction": 0.05},
    {"n": 1, "rms_speed": 0.0, "packing_fraction": 0.01},
])  # fmt: skip
def test_random_systems_are_what_was_asked_for(changed):
    arguments = USUAL | changed
    system = hl.ParticleSystem.random(**arguments)
    assert system.n == arguments["n"] and system.dimension == arguments.get("dimension", 3)
    assert system.packing_fraction == pytest.approx(arguments["packing_fraction"], rel=1e-12)
    assert rms(system) == pytest.approx(arguments["rms_speed"], rel=1e-12)
    again = system.replace(positions=system.positions)  # passes every check
    assert again == system
    scale = float(system.mass.sum()) * (arguments["rms_speed"] or 1.0)
    for axis, side in enumerate(system.boundary):
        if side == "periodic":
            assert abs(system.momentum[axis]) < 1e-13 * scale


def test_the_seed_gives_the_bits():
    assert hl.ParticleSystem.random(**USUAL) == hl.ParticleSystem.random(**USUAL, seed=0)
    assert hl.ParticleSystem.random(**USUAL) != hl.ParticleSystem.random(**USUAL, seed=1)
    left, other = (hl.ParticleSystem.random(**(USUAL | {"radius": (1e-3, 2e-3)}), seed=s) for s in (1, 1))
    assert left == other and left.radius.min() >= 1e-3 and left.radius.max() <= 2e-3


def test_velocities_are_maxwell_with_one_temperature_for_all_masses():
    radii = np.repeat([1e-3, 2e-3], 1000)
    system = hl.ParticleSystem.random(2000, 0.1, radii, 2500.0, 1.0, seed=5)
    energy = np.asarray(system.mass)[:, None] * np.asarray(system.velocities) ** 2
    light, heavy = energy[:1000].mean(), energy[1000:].mean()
    assert light == pytest.approx(heavy, rel=0.15)  # 3 000 values each: 2.6 % standard error
    v = np.asarray(system.velocities)[:1000].ravel()
    assert np.mean(v**4) / np.mean(v**2) ** 2 == pytest.approx(3.0, abs=0.4)


@pytest.mark.parametrize("changed, message", [
    ({"n": 0}, r"n: got 0, must be a whole number >= 1"),
    ({"n": 2.0}, r"n: got 2.0, must be a whole number"),
    ({"packing_fraction": 0.63}, r"packing_fraction: got 0.63, must be in \(0, 0.62\]"),
    ({"packing_fraction": 0.83, "dimension": 2}, r"packing_fraction: got 0.83, must be in \(0, 0.82\]"),
    ({"dimension": 4}, r"dimension: got 4, must be a whole number in \[2, 3\]"),
    ({"n": 3}, r"n \| packing_fraction: got 3 particles, must be more at this packing fraction: box: got"),
    ({"n": 1, "packing_fraction": 0.01}, r"rms_speed: got 0.5, must be 0 for a single particle"),
    ({"radius": (2e-3, 1e-3)}, r"radius: got 0.002 and 0.001, the first must not be the larger one"),
    ({"radius": [1e-3] * 3}, r"radius: got 3 values, must be 200"),
    ({"radius": "1"}, r"radius: got '1', must be a number or 200 numbers"),
    ({"seed": -1}, r"seed: got -1, must be a whole number"),
    ({"rms_speed": -1.0}, r"rms_speed: got -1, must be in \[0, 1e\+30\]"),
    ({"boundary": "open"}, r"boundary: got 'open'"),
])  # fmt: skip
def test_what_cannot_start_is_refused(changed, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        hl.ParticleSystem.random(**(USUAL | changed))


@pytest.mark.parametrize("name", ["shear_rate", "shear_displacement", "thermostat"])
@pytest.mark.parametrize(
    "value", [np.ones(2), np.ones((2, 2)), xr.DataArray([1.0, 2.0]), pd.Series([1.0, 2.0])], ids=repr
)
def test_an_array_in_place_of_one_value_is_refused(name, value):
    """Also with a boundary that drops the shear."""
    sheared = lattice(boundary=["periodic", "lees-edwards", "periodic"], shear_rate=1.0)
    for more in ({}, {"boundary": "periodic"}):
        assert refusal(lambda more=more: sheared.replace(**{name: value}, **more)).startswith(f"{name}: got ")


# --- the ends of the accepted ranges --------------------------------------------------------------------------------


def scaled(engine, length, speed, mass, boundary):
    """Positions and velocities of a run in these units, and its number of contacts."""
    at = np.array([[2.0, 2.0, 2.0], [5.0, 2.3, 2.1], [7.0, 7.0, 7.0]])
    moving = np.array([[1.0, 0.1, 0.0], [-1.0, 0.0, 0.05], [0.3, -0.4, 1.0]])
    system = hl.ParticleSystem(
        length * at, speed * moving, length * np.array([1.0, 1.2, 1.0]), mass=mass, box=10.0 * length,
        boundary=boundary,
    )  # fmt: skip
    law = hl.LinearDashpot(stiffness=1e3 * mass * (speed / length) ** 2, restitution=0.8)
    until = 20.0 * length / speed
    if engine in ("constant", "soft"):
        rule = {"restitution": 0.8} if engine == "constant" else {"law": law, "rule": "soft"}
        run = hl.event_driven(system, until=until, **rule)
        count = run.n_collisions
    else:
        own = {"time_step": 1e-3 * length / speed} if engine == "steps" else {}
        run = hl.molecular_dynamics(system, law=law, until=until, engine=engine, **own)
        count = run.n_contacts
    assert run.outcome == "ok"
    return run.system.positions / length, run.system.velocities / speed, count


@pytest.mark.parametrize("boundary", ["periodic", "wall"])
@pytest.mark.parametrize("engine", ["constant", "soft", "events", "steps"])
def test_units_do_not_matter_up_to_the_ends_of_the_ranges(engine, boundary):
    """Regression: at 1e80 m and 1e80 m/s products of four numbers overflowed, and balls passed through each other."""
    at, moving, count = scaled(engine, 1.0, 1.0, 1.0, boundary)
    assert count > 2
    units = itertools.product((1.001e-30, 9.99e28), (1e-28, 1e-10, 9e29), (1e-100, 1.0, 1e100))
    for length, speed, mass in units:
        if engine != "constant" and not 1e-30 < 10.0 * mass * (speed / length) < 1e98:
            continue  # refused: see below
        scaled_run = scaled(engine, length, speed, mass, boundary)
        np.testing.assert_allclose(scaled_run[0], at, atol=1e-3)
        np.testing.assert_allclose(scaled_run[1], moving, atol=1e-3)
        assert scaled_run[2] == count


@pytest.mark.parametrize("engine", ["soft", "events", "steps"])
@pytest.mark.parametrize("stiffness", [1e-70, 1e230])
def test_forces_whose_squares_underflow_or_overflow_are_refused(engine, stiffness):
    law = hl.LinearDashpot(stiffness=stiffness, restitution=0.8)
    with pytest.raises(ValueError, match=r"law \| mass: got .*, must be in \[1e-30, 1e\+100\]"):
        if engine == "soft":
            hl.event_driven(pair(), law=law, rule="soft", until=1.0)
        else:
            hl.molecular_dynamics(pair(), law=law, until=1.0, engine=engine)
