"""Spins of states: cumulants and correlations of known distributions, profiles, the antisymmetric stress of runs."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hardlimit as hl
from conftest import draws, refusal

N = 20_000
ROUGH = hl.LinearDashpot(
    stiffness=1e4, restitution=0.8, friction=hl.Friction(coefficient=0.5, stiffness_ratio=0.8)
)


def gas(dimension: int, n: int = N, **more) -> hl.ParticleSystem:
    """Unequal grains, whose velocities and spins are Maxwell's and independent, with a mean rotation."""
    system = hl.ParticleSystem.random(n, 0.01, (0.5e-3, 1.5e-3), 2500.0, 1.0, dimension=dimension, **more)
    axes = (3,) if dimension == 3 else ()
    spins = np.random.default_rng(dimension).normal(size=(n, *axes))
    inertia = system.inertia.reshape(n, *(1 for _ in axes))
    return system.replace(angular_velocities=1e-3 * spins / np.sqrt(inertia) + 7.0)


@pytest.mark.parametrize("dimension", [2, 3])
def test_independent_spins_of_maxwell_have_no_cumulants(dimension: int) -> None:
    """0 and 1/3 within 4 of the standard errors that the docstrings give; a mean rotation changes nothing."""
    system, f = gas(dimension), 1 if dimension == 2 else 3
    assert abs(hl.measure.a02(system)) < 4.0 * math.sqrt(8.0 / (f * (f + 2) * N))
    assert abs(hl.measure.a11(system)) < 4.0 * 2.0 / math.sqrt(dimension * f * N)
    if dimension == 3:
        assert abs(hl.measure.alignment(system) - 1 / 3) < 4.0 * math.sqrt(4.0 / (45.0 * N))
    turned = system.replace(angular_velocities=system.angular_velocities - 30.0)
    for measure in (hl.measure.a02, hl.measure.a11):
        assert float(measure(turned)) == pytest.approx(float(measure(system)), rel=1e-6, abs=1e-9)
        assert measure(system).attrs["units"] == "1" and measure(system).name == measure.__name__


def test_standard_errors_are_those_of_the_docstrings() -> None:
    rng, n, values = np.random.default_rng(5), 200, []
    for _ in range(400):
        x = 1e-3 * np.indices((6, 6, 6)).reshape(3, -1).T[:n] + 1e-3
        spins, velocities = rng.normal(size=(2, n, 3))
        system = hl.ParticleSystem(
            x, velocities, 4e-4, mass=1.0, box=7e-3, boundary="wall", angular_velocities=spins
        )
        values.append([float(f(system)) for f in (hl.measure.a02, hl.measure.a11, hl.measure.alignment)])
    expected = [math.sqrt(8.0 / (15.0 * n)), 2.0 / (3.0 * math.sqrt(n)), math.sqrt(4.0 / (45.0 * n))]
    np.testing.assert_allclose(np.std(values, axis=0), expected, rtol=0.15)


@pytest.mark.parametrize("dimension", [2, 3])
def test_cumulants_of_known_distributions(dimension: int) -> None:
    """Equal rotational energies f/(f + 2) − 1; the fraction p that carries all energy, (f/(f + 2))/p − 1; one of spins
    and speeds that go together, ⟨x²⟩/⟨x⟩² − 1."""
    system, f = gas(dimension, 2000), 1 if dimension == 2 else 3
    spins = np.asarray(system.angular_velocities).reshape(system.n, -1)
    unit = spins / np.linalg.norm(spins, axis=1)[:, None] / np.sqrt(system.inertia)[:, None]
    paired = np.concatenate([unit[:1000], -unit[:1000]])  # no mean rotation
    pairs = system.replace(radius=1e-4, mass=1e-6)
    paired /= np.linalg.norm(paired, axis=1)[:, None]
    shape = pairs.angular_velocities.shape
    equal = pairs.replace(angular_velocities=paired.reshape(shape))
    assert float(hl.measure.a02(equal)) == pytest.approx(f / (f + 2) - 1.0, rel=1e-12)
    part = np.tile(np.arange(1000) % 4 == 0, 2)
    quarter = equal.replace(angular_velocities=(paired * part[:, None]).reshape(shape))
    assert float(hl.measure.a02(quarter)) == pytest.approx(4.0 * f / (f + 2) - 1.0, rel=1e-12)
    directions = np.random.default_rng(1).normal(size=(1000, dimension))
    directions = np.concatenate([directions, -directions])
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    both = quarter.replace(velocities=directions * part[:, None])
    assert float(hl.measure.a11(both)) == pytest.approx(4.0 - 1.0, rel=1e-12)
    other = quarter.replace(velocities=directions * ~part[:, None])
    assert float(hl.measure.a11(other)) == pytest.approx(-1.0, rel=1e-12)


def test_alignment_of_known_directions() -> None:
    """Bullets, sliced balls, and a share that does not spin and is left out."""
    system = gas(3, 1000)
    v = np.concatenate([system.velocities[:500], -system.velocities[:500]])  # no mean velocity
    system = system.replace(radius=1e-4, mass=1e-6, velocities=v)
    v, half = system.velocities, (np.arange(1000) % 500 < 250)[:, None]
    bullets = system.replace(angular_velocities=3.0 * v)
    assert float(hl.measure.alignment(bullets)) == pytest.approx(1.0, rel=1e-12)
    across = np.cross(v, [0.3, 0.4, 0.5])
    assert abs(hl.measure.alignment(system.replace(angular_velocities=across))) < 1e-25
    mixed = system.replace(angular_velocities=np.where(half, v, across))
    assert float(hl.measure.alignment(mixed)) == pytest.approx(0.5, rel=1e-12)
    some = system.replace(angular_velocities=np.where(half, v, 0.0))
    assert float(hl.measure.alignment(some)) == pytest.approx(1.0, rel=1e-12)


def test_without_spins_there_are_no_values() -> None:
    still = gas(3, 10).replace(angular_velocities=np.full((10, 3), 2.0))
    assert math.isnan(hl.measure.a02(still)) and math.isnan(hl.measure.a11(still))
    zero = still.replace(angular_velocities=np.zeros((10, 3)))
    assert all(math.isnan(f(zero)) for f in (hl.measure.a02, hl.measure.a11, hl.measure.alignment))
    smooth = hl.ParticleSystem.random(10, 0.1, 1e-3, 2500.0, 1.0)
    for measure in (hl.measure.a02, hl.measure.a11, hl.measure.alignment):
        assert "without angular velocities" in refusal(lambda f=measure: f(smooth))
        assert refusal(lambda f=measure: f(3)).startswith("system: got 3")
    assert "must be spheres" in refusal(lambda: hl.measure.alignment(gas(2, 10)))


@draws(30)
@given(dimension=st.sampled_from([2, 3]), bins=st.integers(1, 30), axis=st.sampled_from("xy"))
def test_profiles_of_spins_sum_to_the_totals(dimension: int, bins: int, axis: str) -> None:
    system = gas(dimension, 60)
    p = hl.measure.profiles(system, axis, bins=bins)
    mass = p.mass_density * float(np.prod(system.box)) / bins
    f = 1 if dimension == 2 else 3
    energy = 0.5 * f * float((mass * p.rotational_temperature).sum())
    assert energy == pytest.approx(system.rotational_energy, rel=1e-12)
    assert p.mean_angular_velocity.dims == ((axis, "axis") if dimension == 3 else (axis,))
    whole = hl.measure.profiles(system, axis, bins=1).mean_angular_velocity[0]
    spin = system.inertia @ system.angular_velocities
    np.testing.assert_allclose(whole * system.inertia.sum(), spin, rtol=1e-12)
    assert np.array_equal(np.isnan(p.rotational_temperature), p.number_density == 0.0)
    plain = hl.ParticleSystem.random(9, 0.1, 1e-3, 2500.0, 1.0, dimension=dimension)
    assert "rotational_temperature" not in hl.measure.profiles(plain, axis)


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_antisymmetric_stress_is_that_of_the_contact_forces(dimension: int) -> None:
    """One contact of two spinning grains across a periodic side: r × ∫F dt from their momentum, r as at touch."""
    rng, edge, largest = np.random.default_rng(dimension), 0.02, 0.0
    for _ in range(5):
        way = rng.normal(size=dimension)
        way /= np.linalg.norm(way)
        first = np.full(dimension, 1e-4)
        x = np.stack([first, np.mod(first + way * (2e-3 + 1e-9), edge)])
        v = np.stack([0.0 * way, -1e-2 * way + 2e-3 * rng.normal(size=dimension)])
        spins = 5.0 * rng.normal(size=(2, 3) if dimension == 3 else 2)
        system = hl.ParticleSystem(
            x, v, 1e-3, mass=[1e-5, 3e-5], box=edge, angular_velocities=spins, inertia_factor=0.5
        )
        run = hl.molecular_dynamics(system, law=ROUGH, until=1e-3, samples=1, engine="steps")
        stress = hl.measure.antisymmetric_stress(run)
        impulse = 3e-5 * (run.system.velocities[1] - v[1])
        torque = np.cross(
            np.append(way, [0.0] * (3 - dimension)), np.append(impulse, [0.0] * (3 - dimension))
        )
        expected = 2e-3 * (torque if dimension == 3 else torque[2]) / (1e-3 * edge**dimension)
        scale = 2e-3 * np.linalg.norm(impulse) / (1e-3 * edge**dimension)
        assert np.isnan(stress[0]).all() and stress.attrs["units"] == ("Pa" if dimension == 3 else "N/m")
        np.testing.assert_allclose(stress[1], expected, atol=2e-3 * scale)
        largest = max(largest, float(abs(stress[1]).max()) / scale)
    assert largest > 0.2 and hl.measure.plot(stress)


def test_the_antisymmetric_stress_is_refused_where_it_is_unknown() -> None:
    system = gas(3, 30, boundary=["periodic", "periodic", "wall"])
    run = hl.molecular_dynamics(system, law=ROUGH, until=1e-4, engine="steps")
    assert refusal(lambda: hl.measure.antisymmetric_stress(run)).startswith("run: got one with walls")
    kicks = hl.Andersen(temperature=1.0, rate=1e3, rotational=1.0)
    heated = gas(3, 30, thermostat=kicks)
    run = hl.molecular_dynamics(heated, law=ROUGH, until=1e-4, engine="steps")
    assert "must have no thermostat that changes spins" in refusal(
        lambda: hl.measure.antisymmetric_stress(run)
    )
    smooth = hl.event_driven(gas(3, 30), restitution=0.9, until=1e-4)
    assert "must have friction" in refusal(lambda: hl.measure.antisymmetric_stress(smooth))
    assert refusal(lambda: hl.measure.antisymmetric_stress(2)).startswith("run: got 2, must be a result")
