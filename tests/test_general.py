"""The integrating solver: measured order, energy balance, agreement with closed forms, any law and number."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import hardlimit as hl
from conftest import columns, falling, law_of, laws

every_law = pytest.mark.parametrize("name", sorted(hl.LAWS))


def measured_order(column: hl.Column, until: float) -> float:
    """−d ln(error)/d ln(steps) over four decades of the tolerance, down to rounding.

    Above 1e-10 the first steps of a contact under Tsuji's law, where s = ξ^{1/4} grows from zero, have the length
    with which they are begun and not one that the tolerance decides.
    """
    reference = hl.newton(column, until=until, tolerance=1e-15, method="general")
    steps, errors = [], []
    for tolerance in 10.0 ** -np.arange(10.0, 14.5, 0.5):
        result = hl.newton(column, until=until, tolerance=float(tolerance), method="general")
        error = np.abs(result.velocities - reference.velocities).max()
        if error > 1e-15:
            steps.append(result._core.steps)
            errors.append(error)
    assert len(errors) > 5
    return -np.polyfit(np.log(steps), np.log(errors), 1)[0]


@every_law
@pytest.mark.parametrize("restitution", [0.98, 0.9])
def test_order_is_eight(name, restitution):
    """Three balls that swing on the floor for long: many steps and switches.

    A switch that is not located would show as an order of 1. What the start of a Hertz contact costs is seen
    in the next test, for steps that grow from zero hide it here. Orders above 8 come from the steps that
    switches cost whatever the tolerance.
    """
    law = law_of(name, restitution, speed=0.01)
    balls = [hl.Ball(r, density=2000.0) for r in (0.03, 0.02, 0.012)]
    column = hl.Column(balls, [1e-6, 1e-6], 0.03, law, velocities=-0.01)
    until = 40.0 * column.contacts[0].duration(0.01)
    assert 7.5 < measured_order(column, until) < 15.0


@every_law
@pytest.mark.parametrize("restitution", [1.0, 0.7, 0.3, 0.05])
def test_one_collision_is_that_of_the_law(name, restitution):
    """Two balls meet once: restitution and duration of the contact itself.

    In few steps: with ξ instead of its root as the coordinate of a Hertz contact there are twice as many as with
    the root (60), and the sharpest tolerance does not reach rounding.
    """
    law = law_of(name, restitution, speed=1.5)
    balls = [hl.Ball(0.02, mass=0.1), hl.Ball(0.01, mass=0.03)]
    column = hl.Column.cradle(balls, [1.0, -0.5], law, gaps=[1e-3])
    result = hl.newton(column)
    assert result.n_contacts == 1
    assert result.velocities[1] - result.velocities[0] == pytest.approx(1.5 * restitution, rel=2e-12)
    contact = result.contacts.isel(contact=0)
    assert float(contact.begin) == pytest.approx(1e-3 / 1.5, rel=1e-14)
    assert float(contact.end - contact.begin) == pytest.approx(column.contacts[0].duration(1.5), rel=1e-9)
    momentum = 0.1 * result.velocities[0] + 0.03 * result.velocities[1]
    assert momentum == pytest.approx(0.1 - 0.015, rel=1e-12)
    assert result._core.steps < 100
    sharp = hl.newton(column, tolerance=1e-15)
    assert sharp.velocities[1] - sharp.velocities[0] == pytest.approx(1.5 * restitution, rel=1e-14)


@every_law
def test_tolerance_is_what_it_says(name):
    """A coarser tolerance takes fewer steps and stays in proportion."""
    column = falling([0.2, 0.05, 0.02], [1e-5, 2e-5], law_of(name, 0.8))
    until = 3.0 * column.contacts[0].duration()
    best = hl.newton(column, until=until, tolerance=1e-15, method="general")
    for tolerance in (1e-6, 1e-8, 1e-10, 1e-12):
        result = hl.newton(column, until=until, tolerance=tolerance, method="general")
        assert np.abs(result.velocities - best.velocities).max() < 300.0 * tolerance
        assert result._core.steps < best._core.steps


@settings(max_examples=60)
@given(columns())
def test_energy_is_accounted_for(column):
    """Kinetic + potential + contact energy + dissipated = initial, to 1e-10, for every law and any column."""
    result = hl.newton(column, until=0.02, method="general")
    assert result.energy_error < 1e-10
    t = result.trajectory()
    total = t.kinetic_energy + t.potential_energy + t.contact_energy + t.dissipated_energy
    release = result.trajectory([result._core.t_first])
    initial = float(release.kinetic_energy[0] + release.potential_energy[0])
    assert np.abs(total.values / initial - 1.0).max() < 1e-10


@settings(max_examples=60)
@given(columns(law=laws(restitution=st.floats(0.3, 1.0)), most=3))
def test_a_sharper_tolerance_changes_nothing(column):
    usual = hl.newton(column, until=5e-3, method="general")
    sharp = hl.newton(column, until=5e-3, tolerance=1e-15, method="general")
    assert np.abs(usual.velocities - sharp.velocities).max() < 1e-8 * column.impact_speed


@every_law
@pytest.mark.parametrize("restitution", [1.0, 1.0 - 1e-16, math.exp(-2.0), 1e-3])
@pytest.mark.parametrize("gap", [0.0, 1e-15, 1e-4])
def test_corner_cases_end_with_an_outcome(name, restitution, gap):
    balls = [hl.Ball(r, density=1000.0) for r in (0.05, 0.03, 0.01)]
    column = hl.Column(balls, gap, 0.3, law_of(name, restitution))
    result = hl.newton(column)
    assert result.outcome_code in (hl.OUTCOMES.index("ok"), hl.OUTCOMES.index("at_rest"))
    assert np.isfinite(result.velocities).all() and np.isfinite(result.positions).all()
    assert result.n_contacts >= 2
    if result.outcome == "ok":
        assert math.isfinite(result.t_end)
    # Not defined for three balls.
    assert math.isnan(result.relative_velocity) and math.isnan(result.separation_velocity)
    assert math.isnan(result.effective_restitution)


@every_law
@pytest.mark.parametrize("restitution", [1.0, 0.7, 0.2])
def test_touching_is_the_limit_of_a_vanishing_gap(name, restitution):
    balls = [hl.Ball(r, density=1000.0) for r in (0.05, 0.03, 0.01)]
    law = law_of(name, restitution)
    until = 3.0 * law.between(balls[0]).duration(2.0)
    touching = hl.newton(hl.Column(balls, 0.0, 0.3, law), until=until)
    close = hl.newton(hl.Column(balls, 1e-15, 0.3, law), until=until)
    assert touching.n_contacts == close.n_contacts
    assert np.abs(touching.velocities - close.velocities).max() < 1e-8


@every_law
def test_at_rest(name):
    """Everything damped away: the column lies on the floor and carries its weight."""
    balls = [hl.Ball(r, density=2000.0) for r in (0.03, 0.02)]
    column = hl.Column(balls, [0.0], 0.031, law_of(name, 0.02))
    result = hl.newton(column, method="general")
    assert result.outcome_code == hl.OUTCOMES.index("at_rest")
    assert result.relative_velocity == result.separation_velocity == 0.0
    assert math.isnan(result.t_end)
    pair, end = result.contacts.pair.values, result.contacts.end.values
    assert math.isnan(end[pair == 0][-1]) and math.isnan(end[pair == 1][-1])


@every_law
def test_no_contact(name):
    """The lower ball is back on the floor before the upper one has come down."""
    balls = [hl.Ball(0.03, density=2000.0), hl.Ball(0.02, density=2000.0)]
    result = hl.newton(hl.Column(balls, [1.0], 0.05, law_of(name, 0.3)), method="general")
    assert result.outcome_code == hl.OUTCOMES.index("no_contact")
    assert result.n_contacts == 0
    for value in (
        result.t_end,
        result.relative_velocity,
        result.separation_velocity,
        result.effective_restitution,
    ):
        assert math.isnan(value)
    assert math.isfinite(result.t_floor_end)


@every_law
def test_until_holds_every_contact_up_to_it(name):
    balls = [hl.Ball(r, density=1000.0) for r in (0.05, 0.03, 0.01)]
    column = hl.Column(balls, [1e-4, 1e-4], 0.3, law_of(name, 0.8))
    long = hl.newton(column, until=0.3)
    for until in (1e-4, 1e-3, 0.05, 0.2):
        result = hl.newton(column, until=until)
        kept = int((long.contacts.begin <= until).sum())
        assert len(result.contacts.begin) == kept
        assert result.contacts.pair.values.tolist() == long.contacts.pair.values[:kept].tolist()
        assert result.contacts.begin.values == pytest.approx(long.contacts.begin.values[:kept], rel=1e-8)
        later = long.trajectory([until])
        assert result.velocities == pytest.approx(later.velocity.values[0], abs=1e-8)
        assert result.positions == pytest.approx(later.position.values[0], abs=1e-9)


def test_column_on_a_floor_stops_when_the_floor_is_met_again():
    column = hl.Column(
        [hl.Ball(r, density=1000.0) for r in (0.05, 0.03, 0.01)], 1e-3, 0.3, law_of("linear", 0.8)
    )
    result = hl.newton(column)
    floor = result.contacts.pair.values == 0
    assert floor.sum() in (1, 2)
    longer = hl.newton(column, until=2.0)
    assert (longer.contacts.pair.values == 0).sum() > 2
    assert result.t_end <= np.nanmax(longer.contacts.end.values)


def test_cradle_has_no_floor():
    law = law_of("linear", 1.0)
    result = hl.newton(hl.Column.cradle([hl.Ball(0.01, mass=0.1)] * 3, [1.0, 0.0, 0.0], law))
    assert math.isnan(result.t_floor_end)
    assert 0 not in result.contacts.pair.values
    assert result.contacts.begin.values.min() == 0.0
    assert result.velocities[2] == pytest.approx(0.98003213, abs=1e-8)


def test_material_constant_instead_of_a_restitution():
    """Appendix C: one A for all contacts; ε01 ≠ ε12."""
    law = hl.Viscoelastic(youngs_modulus=1e8, poisson_ratio=0.4, dissipative_time=1e-4)
    balls = [hl.Ball(0.05, density=840.0), hl.Ball(0.01, density=840.0)]
    column = hl.Column(balls, [1e-4], 0.5, law)
    floor, pair = column.contacts
    assert floor.dissipative_time == pair.dissipative_time == 1e-4
    assert floor.restitution(3.0) > pair.restitution(3.0)
    result = hl.newton(column)
    assert result.outcome == "ok" and math.isnan(result.restitution_ratio)
    assert math.isfinite(result.effective_restitution)
