"""What engines make of particles that overlap at the start, as the states of soft contacts do."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hardlimit as hl
from conftest import draws, refusal

LAW = hl.LinearDashpot(stiffness=1e3, restitution=0.8)
RULES = {
    "constant": {"restitution": 0.8},
    "law": {"law": LAW},
    "tc": {"restitution": 0.8, "rule": "tc", "contact_duration": 1e-4},
    "soft": {"law": LAW, "rule": "soft"},
}
RADIUS, DEPTH = 5e-3, 2e-4


def pair(approach, **changes):
    """Two spheres that overlap by DEPTH and approach each other at a speed."""
    at = [[0.02, 0.05, 0.05], [0.02 + 2 * RADIUS - DEPTH, 0.05, 0.05]]
    speeds = [[0.5 * approach, 0.01, 0.0], [-0.5 * approach, 0.0, 0.0]]
    return hl.ParticleSystem(at, speeds, RADIUS, 2500.0, box=0.1, allowed_overlap=0.05, **changes)


def approaches(system):
    return float(system.velocities[0, 0] - system.velocities[1, 0])


@pytest.mark.parametrize("rule", RULES)
def test_a_pair_that_approaches_collides_at_once(rule):
    run = hl.event_driven(pair(0.3), until=2e-3, log=True, **RULES[rule])
    assert run.outcome == "ok" and run.collisions.time.values.tolist() == [0.0]
    assert approaches(run.system) == pytest.approx(-0.8 * 0.3, rel=1e-3)
    assert run.system.momentum == pytest.approx(np.asarray(pair(0.3).momentum), rel=1e-12)


@pytest.mark.parametrize("rule", RULES)
def test_a_pair_that_separates_flies_apart(rule):
    run = hl.event_driven(pair(-0.3), until=2e-3, **RULES[rule])
    assert run.n_collisions == 0 and run.system.velocities.tolist() == pair(-0.3).velocities.tolist()


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("speed", [0.3, -0.3])
def test_a_wall(rule, speed):
    """Of a particle that is in it by DEPTH."""
    at = [[0.05, 0.05, RADIUS - DEPTH]]
    ball = hl.ParticleSystem(
        at, [[0.0, 0.0, -speed]], RADIUS, 2500.0, box=0.1, boundary="wall", allowed_overlap=0.05
    )
    run = hl.event_driven(ball, until=2e-3, log=True, **RULES[rule])
    assert run.n_collisions == (1 if speed > 0 else 0)
    assert run.system.velocities[0, 2] == pytest.approx(0.8 * speed if speed > 0 else -speed, rel=1e-3)


@pytest.mark.parametrize("engine", ["events", "steps"])
@pytest.mark.parametrize("speed", [0.3, -0.3])
def test_newtons_equations_begin_within_the_contact(engine, speed):
    """With the energy of the spring, k DEPTH²/2, which hard spheres do not have; no more energy comes out."""
    run = hl.molecular_dynamics(pair(speed), law=LAW, until=5e-3, engine=engine)
    stored = 0.5 * 1e3 * DEPTH**2
    assert run.series.contact_energy.values[0] == pytest.approx(stored, rel=1e-12)
    total = (run.series.kinetic_energy + run.series.contact_energy).values
    assert (np.diff(total) <= 1e-6 * total[0]).all() and approaches(run.system) < 0.0


@draws(12)
@given(st.integers(0, 2**32), st.sampled_from([2, 3]), st.sampled_from([*RULES]), st.floats(0.05, 0.4))
def test_a_soft_gas(seed, dimension, rule, packing):
    """Energy never grows, momentum stays, and where no contact takes time the overlaps are gone in the end."""
    gas = hl.ParticleSystem.random(
        60, packing, RADIUS, 2500.0, 1.0, dimension=dimension, seed=seed % 100, boundary="periodic"
    )
    soft = hl.molecular_dynamics(gas, law=LAW, until=2e-2, engine="events").system
    run = hl.event_driven(soft, until=0.3, samples=30, **RULES[rule])
    if run.outcome == "ok":
        energy = run.series.kinetic_energy.values
        assert (np.diff(energy) <= 1e-12 * energy[0]).all()
        assert run.system.momentum == pytest.approx(
            np.asarray(soft.momentum), abs=1e-12 * float(gas.mass.sum())
        )
        assert rule == "soft" or run.system.largest_overlap < 1e-8


def test_a_comparison_begins_with_overlaps():
    """Its replicas too, which begin with elastic collisions."""
    gas = hl.ParticleSystem.random(40, 0.3, RADIUS, 2500.0, 1.0, dimension=2, seed=2)
    soft = hl.molecular_dynamics(gas, law=LAW, until=5e-2).system
    assert soft.largest_overlap > 1e-4
    f = hl.fidelity(soft, law=LAW, until=1e-2, replicas=2, samples=3, models=["newton", "law"])
    assert f.outcomes("law") == ("ok", "ok") or list(f.outcomes("law")) == ["ok", "ok"]


def test_a_changed_copy_has_the_overlaps_that_are_allowed():
    sheared = {"boundary": ["periodic", "lees-edwards", "periodic"], "shear_rate": 1.0}
    assert "allowed_overlap= accepts more, 0.02" in refusal(lambda: pair(0.3).replace(**sheared))
    assert pair(0.3).replace(**sheared, allowed_overlap=0.05).shear_rate == 1.0
    assert pair(0.3).replace(velocities=np.zeros((2, 3))).largest_overlap == pytest.approx(DEPTH / 2 / RADIUS)
