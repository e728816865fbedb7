"""Comparisons of grains that rub: what is compared, what the rules get, and from which states replicas start."""

import math
from pathlib import Path

import numpy as np
import pytest

import hardlimit as hl
from conftest import refusal
from hardlimit.fidelity_study.starts import equilibrated

LAW = hl.LinearDashpot(stiffness=1e5, restitution=0.9, friction=hl.Friction(0.5, stiffness_ratio=0.9))


def box(dimension: int = 3, **more: object) -> hl.ParticleSystem:
    grains = {"radius": 1e-3, "density": 2500.0, "rms_speed": 1.0, "rms_spin": "equal"}
    return hl.ParticleSystem.random(20, 0.2, dimension=dimension, **(grains | more))


@pytest.mark.parametrize("dimension", [2, 3])
def test_other_spins_have_the_same_mean_and_energy(dimension: int) -> None:
    system = box(dimension, radius=(1e-3, 2e-3), inertia_factor=0.5)
    system = system.replace(angular_velocities=system.angular_velocities + 300.0)
    other = equilibrated(system, seed=1)
    assert other.rotational_energy == pytest.approx(system.rotational_energy, rel=1e-12)
    means = [np.average(s.angular_velocities, axis=0, weights=s.inertia) for s in (system, other)]
    assert means[1] == pytest.approx(means[0], rel=1e-12)
    assert not np.isclose(other.angular_velocities, system.angular_velocities).any()


def test_grains_at_rest_stay_so_in_other_states() -> None:
    system = box(rms_spin=None, inertia_factor=0.4)
    assert not equilibrated(system, seed=1).angular_velocities.any()
    assert equilibrated(box(rms_spin=None), seed=1).angular_velocities is None


def test_cooling_counts_the_energy_of_rotation() -> None:
    system = box()
    comparison = hl.fidelity(system, law=LAW, until=2e-3, models=["newton"], engine="steps", samples=2)
    run = hl.molecular_dynamics(
        system, law=LAW, until=2e-3, engine="steps", samples=2, restitution_error=1e-4
    )
    energy = [
        1.5 * float(s.mass.sum()) * s.granular_temperature + s.rotational_energy for s in (system, run.system)
    ]
    lost = float(run.series.dissipated_energy[-1])
    expected = math.sqrt(energy[0] / (energy[0] - lost)) - 1.0
    cooling = comparison.dataset["cooling"].sel(statistic="mean", model="newton").values
    assert cooling[-1] == pytest.approx(expected, rel=1e-12)
    temperature = comparison.dataset["rotational_temperature"].sel(statistic="mean", model="newton").values
    assert temperature == pytest.approx(run.series.rotational_temperature.values, rel=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_constant_rule_has_the_tangential_restitution_of_a_gas(dimension: int) -> None:
    """Of the inertia of these grains, and of their dimension."""
    comparison = hl.fidelity(
        box(dimension, inertia_factor=0.6), law=LAW, until=1e-4, models=["newton", "constant"], samples=1
    )
    ball = hl.Ball(1e-3, density=2500.0, inertia_factor=0.6)
    expected = LAW.between(ball, ball).effective_tangential_restitution(dimension=dimension)
    assert comparison.plan.tangential_restitution == pytest.approx(expected, rel=1e-9)


def test_elastic_grains_that_rub_may_be_sheared() -> None:
    """They dissipate; smooth ones only heat."""
    system = box(boundary=("periodic", "lees-edwards", "periodic"), shear_rate=50.0)
    elastic = hl.LinearDashpot(stiffness=1e5, restitution=1.0)
    options = {"until": 1e-4, "models": ["newton"], "samples": 1}
    assert "elastic grains only heat" in refusal(lambda: hl.fidelity(system, law=elastic, **options))
    hl.fidelity(system, law=elastic.replace(friction=hl.Friction(0.5)), **options)


def test_a_saved_comparison_keeps_spins(tmp_path: Path) -> None:
    comparison = hl.fidelity(box(), law=LAW, until=1e-4, models=["newton", "law"], samples=1)
    loaded = hl.load(comparison.save(tmp_path / "found.nc"))
    assert loaded.start == comparison.start and loaded.plan == comparison.plan
    assert loaded.dataset.equals(comparison.dataset)
