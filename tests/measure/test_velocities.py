"""Velocities of states: totals of profiles, temperatures about a streaming velocity, the fourth cumulant."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hardlimit as hl
from conftest import draws, lattice, refusal, slow


@st.composite
def systems(draw):
    d, n = draw(st.sampled_from([2, 3])), draw(st.integers(1, 60))
    boundary = draw(st.lists(st.sampled_from(["periodic", "wall"]), min_size=d, max_size=d))
    arguments = {
        "seed": draw(st.integers(0, 99)),
        "spread": draw(st.sampled_from([1.0, 3.0])),
        "boundary": boundary,
    }
    system = lattice(n=n, dimension=d, **arguments)
    if draw(st.booleans()):  # across the periodic sides
        shift = draw(st.floats(-2e-3, 2e-3)) * (np.array(boundary) == "periodic")
        system = system.replace(positions=np.mod(system.positions + shift, system.box))
    return system


@draws(60)
@given(system=systems(), axis=st.sampled_from("xyz"), bins=st.integers(1, 50))
def test_profiles_sum_to_the_totals(system, axis, bins):
    """Number, mass, volume of the particles, momentum and energy, to rounding."""
    if axis == "z" and system.dimension == 2:
        message = refusal(lambda: hl.measure.profiles(system, axis))
        assert message.startswith("axis: got 'z', must be")
        return
    p = hl.measure.profiles(system, axis, bins=bins)
    volume = float(np.prod(system.box)) / bins
    mass = p.mass_density * volume
    assert float(p.number_density.sum()) * volume == pytest.approx(system.n, rel=1e-12)
    assert float(mass.sum()) == pytest.approx(system.mass.sum(), rel=1e-12)
    assert float(p.packing_fraction.mean()) == pytest.approx(system.packing_fraction, rel=1e-9)
    assert p.packing_fraction.min() >= -1e-12
    scale = float(system.mass @ np.linalg.norm(system.velocities, axis=1))
    momentum = (mass * p.mean_velocity).sum(axis)
    assert momentum.values == pytest.approx(system.momentum, abs=1e-12 * scale)
    energy = 0.5 * mass * ((p.mean_velocity**2).sum("axis") + system.dimension * p.granular_temperature)
    assert float(energy.sum()) == pytest.approx(system.kinetic_energy, rel=1e-12)
    assert p[axis].attrs["units"] == "m" and p.number_density.attrs["units"] == f"1/m{system.dimension}"
    inside = np.isfinite(p.granular_temperature)
    assert np.array_equal(inside, p.number_density > 0.0)


@draws(20)
@given(system=systems(), k=st.integers(0, 1), seed=st.integers(0, 99))
def test_packing_fraction_of_a_slab_against_random_points(system, k, seed):
    """The share of random points of each slab inside a particle: 5 binomial standard errors."""
    bins, n = 6, 4000
    phi = hl.measure.profiles(system, "xy"[k], bins=bins).packing_fraction.values
    rng = np.random.default_rng(seed)
    for b in range(bins):
        at = rng.random((n, system.dimension)) * system.box
        at[:, k] = (b + rng.random(n)) * system.box[k] / bins
        apart = at[:, None] - system.positions[None]
        periodic = np.array(system.boundary) == "periodic"
        apart -= np.where(periodic, system.box * np.round(apart / system.box), 0.0)
        inside = ((apart**2).sum(-1) < system.radius**2).any(axis=1).mean()
        assert abs(inside - phi[b]) < 5.0 * math.sqrt(max(phi[b], 1.0 / n) / n)


@draws(40)
@given(system=systems(), bins=st.integers(1, 20), flow=st.floats(-100.0, 100.0))
def test_the_streaming_velocity_is_removed(system, bins, flow):
    """The mean velocity, one linear in space, and steps from bin to bin change nothing; few particles, to rounding."""
    plain = hl.measure.granular_temperature(system)
    assert float(plain) == pytest.approx(system.granular_temperature, rel=1e-12, abs=1e-20)
    x = system.positions[:, 1]
    profile = flow * np.sin(np.floor(np.minimum(x / system.box[1] * bins, bins - 1)))
    shear = np.outer(flow * x / system.box[1], np.eye(system.dimension)[0])
    steps = np.outer(profile, np.eye(system.dimension)[0])
    for measure in (hl.measure.granular_temperature, hl.measure.a2):
        still = {"rel": 1e-6, "abs": 1e-9, "nan_ok": True}
        moved = system.replace(velocities=system.velocities + flow)
        assert float(measure(moved)) == pytest.approx(float(measure(system)), **still)
        sheared = system.replace(velocities=system.velocities + shear)
        back = measure(
            sheared, streaming=lambda at: np.outer(flow * at[:, 1] / system.box[1], np.eye(at.shape[1])[0])
        )
        zero = measure(system, streaming=lambda at: 0.0 * at)
        assert float(back) == pytest.approx(float(zero), **still)
        binned = {"streaming": "y", "bins": bins}
        stepped = system.replace(velocities=system.velocities + steps)
        assert float(measure(stepped, **binned)) == pytest.approx(float(measure(system, **binned)), **still)
    profile = hl.measure.profiles(system, "y", bins=bins)
    thermal = float((profile.mass_density * profile.granular_temperature).sum() / profile.mass_density.sum())
    assert float(hl.measure.granular_temperature(system, streaming="y", bins=bins)) == pytest.approx(
        thermal, rel=1e-9
    )


@pytest.mark.parametrize("d", [2, 3])
def test_a2_of_known_distributions(d):
    """Maxwell: 0 within 4 standard errors √(8/(d(d+2)N)), also of unequal masses; equal energies: d/(d + 2) − 1."""
    system = hl.ParticleSystem.random(20_000, 0.01, (0.5e-3, 1.5e-3), 2500.0, 1.0, dimension=d)
    cumulant = hl.measure.a2(system)
    assert abs(cumulant) < 4.0 * math.sqrt(8.0 / (d * (d + 2) * system.n)) and cumulant.attrs["units"] == "1"
    direction = system.velocities / np.linalg.norm(system.velocities, axis=1)[:, None]
    energy = system.replace(velocities=direction / np.sqrt(system.mass)[:, None])
    assert float(hl.measure.a2(energy, streaming=lambda at: 0.0 * at)) == pytest.approx(
        d / (d + 2) - 1.0, rel=1e-12
    )
    assert np.isnan(hl.measure.a2(system.replace(velocities=0.0 * direction)))


#: Homogeneous cooling state in 3-D: T. P. C. van Noije and M. H. Ernst, Granular Matter 1, 57 (1998).
FOURTH_CUMULANT = {0.7: 0.0013, 0.8: -0.0126, 0.9: -0.0146}


@pytest.mark.parametrize("restitution", [slow(0.7), 0.8, slow(0.9)])
def test_a2_of_a_cooling_gas(restitution):
    """4 standard errors and 4e-3, as their first order in a2 is worth; at 4 to 10 collisions per particle."""
    n = 10_000
    start = hl.ParticleSystem.random(n, 0.05, 1e-3, 2500.0, 1.0, seed=8)
    begun = hl.event_driven(start, restitution=restitution, max_collisions=2 * n).system
    seen = {"observe": {"a2": hl.measure.a2}, "samples": 12}
    run = hl.event_driven(begun, restitution=restitution, max_collisions=3 * n, **seen)
    steady = hl.measure.steady(run.series.a2)
    assert abs(steady.mean.value - FOURTH_CUMULANT[restitution]) < 4.0 * steady.mean.error + 4e-3
    assert steady.mean.error < 8e-3


def test_what_is_no_streaming_velocity_is_refused():
    system = lattice(dimension=2)
    temperature = hl.measure.granular_temperature
    assert refusal(lambda: temperature(system, streaming="z")).startswith("streaming: got 'z', must be")
    assert refusal(lambda: temperature(system, streaming=3)).startswith(
        "streaming: got 3, must be an axis or"
    )
    assert "streaming" in refusal(lambda: temperature(system, streaming=lambda at: at[:3]))
    assert "streaming" in refusal(lambda: temperature(system, streaming=lambda at: "a"))
    assert refusal(lambda: hl.measure.profiles(system, "x", bins=0)).startswith("bins: got 0")
