"""The independent-collisions model: Eqs. 1–6 with the corrected v12, cascades, event-driven sequence."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import hardlimit as hl
from conftest import columns, law_of

G = 9.81


def two_balls(mu: float, restitution: float, gap: float = 1e-3, fall: float = 0.5) -> hl.Column:
    """m2 = μ m1 above a floor."""
    law = hl.LinearDashpot(stiffness=1e9, restitution=restitution)
    balls = [hl.Ball(0.1, mass=1.0), hl.Ball(0.01, mass=mu)]
    return hl.Column(balls, [gap], 0.1 + fall, law)


@pytest.mark.parametrize("mu", [1e-6, 0.1, 1.0 / 3.0, 1.0, 30.0])
@pytest.mark.parametrize("restitution", [1.0, 0.9, 0.5, 0.1])
@pytest.mark.parametrize("gap", [0.0, 1e-15, 1e-3, 0.05])
def test_relative_velocity_depends_on_the_restitution_alone(mu, restitution, gap):
    """v'_r = ε (1 + ε) V whatever the masses and the gap: v12 − v21 = (1 + ε) V."""
    column = two_balls(mu, restitution, gap)
    if gap / ((1.0 + restitution) * column.impact_speed) > 2.0 * restitution * column.impact_speed / G:
        return  # the lower ball is back on the floor first
    result = hl.independent(column)
    wanted = restitution * (1.0 + restitution) * column.impact_speed
    assert result.relative_velocity == pytest.approx(wanted, rel=1e-12)
    assert result.separation_velocity == result.relative_velocity
    assert result.effective_restitution == pytest.approx(restitution, rel=1e-12)
    assert result.restitution_ratio == pytest.approx(1.0, rel=1e-12)
    assert result.n_contacts == 1


@pytest.mark.parametrize("gap", [1e-4, 0.02])
def test_equations_1_to_4(gap):
    """Times, positions and velocities of the two collisions; v12 = v'10 − g (t12 − t10), not v'10 − g t12."""
    mu, e = 0.2, 0.8
    column = two_balls(mu, e, gap)
    result = hl.independent(column)
    v = column.impact_speed
    t12 = gap / ((1.0 + e) * v)
    assert result.contacts.pair.values.tolist()[:2] == [0, 1]
    assert result.contacts.begin.values[:2] == pytest.approx([0.0, t12], rel=1e-12, abs=1e-15)
    assert (result.contacts.begin == result.contacts.end).all()
    before, after = result.trajectory([t12 * (1.0 - 1e-9)]), result.trajectory([t12 * (1.0 + 1e-9)])
    v12, v21 = e * v - G * t12, -v - G * t12
    assert before.velocity.values[0] == pytest.approx([v12, v21], rel=1e-9)
    effective = mu / (1.0 + mu)
    v1 = v12 - (1.0 + e) * effective * (v12 - v21)
    v2 = v21 + (1.0 + e) * effective / mu * (v12 - v21)
    assert after.velocity.values[0] == pytest.approx([v1, v2], rel=1e-9)
    z1 = 0.1 + e * v * t12 - 0.5 * G * t12**2
    assert after.position.values[0] == pytest.approx([z1, z1 + 0.11], rel=1e-9)
    # As printed (the fall before the floor subtracted too), ε = 1 and Δh → 0 would contradict Eq. 5.
    fall = math.sqrt(2.0 * 0.5 / G)
    assert abs(v12 - (e * v - G * (t12 + fall))) > 1.0


def test_equation_5_and_6():
    """ε = 1, Δh → 0: v1 = (1 − 3μ)/(1 + μ) V, v2 = (3 − μ)/(1 + μ) V; μ → 0: 3V, nine times the height."""
    for mu in (1e-9, 0.01, 0.2, 1.0 / 3.0, 0.7, 1.0):
        column = two_balls(mu, 1.0, 0.0)
        v = column.impact_speed
        result = hl.independent(column)
        velocity = result.trajectory([result.t_end]).velocity.values[0] / v
        assert velocity == pytest.approx([(1.0 - 3.0 * mu) / (1.0 + mu), (3.0 - mu) / (1.0 + mu)], abs=1e-13)
    column = two_balls(1e-12, 1.0, 0.0)
    result = hl.independent(column)
    top = 3.0 * column.impact_speed
    highest = result.trajectory([top / G]).position.values[0, 1]
    assert highest == pytest.approx(9.0 * column.initial_positions[1] - 8.0 * 0.21, rel=1e-10)


def test_lower_ball_stops_at_a_third():
    column = two_balls(1.0 / 3.0, 1.0, 0.0)
    result = hl.independent(column)
    velocity = result.trajectory([result.t_end]).velocity.values[0]
    assert abs(velocity[0]) < 1e-14 * column.impact_speed
    assert velocity[1] == pytest.approx(2.0 * column.impact_speed, rel=1e-14)


def column_in_line(masses, law, gap=1e-9) -> hl.Column:
    """Falling together at unit speed, the lowest one at the floor, all but touching."""
    balls = [hl.Ball(0.01, mass=m) for m in masses]
    return hl.Column(balls, gap, 0.01, law, velocities=-1.0, gravity=0.0)


@pytest.mark.parametrize("restitution", [1.0, 0.9, 0.6])
@pytest.mark.parametrize("ratios", [[0.1, 0.1, 0.1], [0.5, 0.2, 0.9, 0.3]])
def test_upward_cascade(restitution, ratios):
    """v_{k+1} + V = (v_k + V)(1 + ε)/(1 + μ_k), each ball being hit once from below."""
    masses = [1.0]
    for mu in ratios:
        masses.append(masses[-1] * mu)
    result = hl.independent(column_in_line(masses, law_of("linear", restitution)), until=1e-7)
    v, pairs, begins = restitution, result.contacts.pair.values, result.contacts.begin.values
    for k, mu in enumerate(ratios, start=1):
        first = int(np.flatnonzero(pairs == k)[0])
        v = (v + 1.0) * (1.0 + restitution) / (1.0 + mu) - 1.0
        hit = result.trajectory([begins[first]]).velocity.values[0, k]
        assert hit == pytest.approx(v, rel=1e-9)


@pytest.mark.parametrize("n", [2, 3, 5, 8])
@pytest.mark.parametrize("restitution", [1.0, 0.8])
def test_light_balls_above_heavy_ones(n, restitution):
    """μ → 0: the top ball leaves with ((1 + ε)^n − 1) V, 2^n − 1 for ε = 1."""
    masses = [1e-9**k for k in range(n)]
    result = hl.independent(column_in_line(masses, law_of("linear", restitution)))
    assert result.velocities[-1] == pytest.approx((1.0 + restitution) ** n - 1.0, rel=1e-6)


@pytest.mark.parametrize("n", [2, 3, 6, 10])
def test_full_stop(n):
    """m_k ∝ 2/(k(k + 1)), μ_k = k/(k + 2): all but the top ball stop, and it leaves with n V."""
    masses = [2.0 / (k * (k + 1)) for k in range(1, n + 1)]
    assert masses[1] / masses[0] == pytest.approx(1.0 / 3.0)
    column = column_in_line(masses, law_of("linear", 1.0))
    begins = hl.independent(column).contacts.begin.values
    result = hl.independent(column, until=float(begins[n - 1]) * (1.0 + 1e-9))
    assert result.velocities[-1] == pytest.approx(n, rel=1e-7)
    assert np.abs(result.velocities[:-1]).max() < 1e-7 * n


def test_sequence_goes_on_after_the_cascade():
    """Equal elastic balls exchange velocities: the top one leaves with V, then the next, and so on."""
    column = column_in_line([1.0, 1.0, 1.0], law_of("linear", 1.0), gap=[0.1, 0.15])
    result = hl.independent(column, until=10.0)
    assert result.contacts.pair.values.tolist() == [0, 1, 0, 2, 1, 0]
    assert result.velocities == pytest.approx([1.0, 1.0, 1.0], rel=1e-12)
    # Without `until` the run is over when the floor is met again.
    assert hl.independent(column).contacts.pair.values.tolist() == [0, 1, 0]


def test_viscoelastic_collisions_take_the_restitution_at_their_speed():
    law = hl.Viscoelastic(youngs_modulus=1e8, poisson_ratio=0.4, dissipative_time=2e-4)
    balls = [hl.Ball(0.05, density=840.0), hl.Ball(0.02, density=840.0)]
    column = hl.Column(balls, [1e-3], 0.5, law)
    result = hl.independent(column)
    v = column.impact_speed
    floor, pair = column.contacts
    e01 = floor.restitution(v)
    approach = (1.0 + e01) * v
    wanted = pair.restitution(approach) * approach
    assert pair.restitution(approach) != pytest.approx(pair.restitution(v), rel=1e-3)
    assert result.relative_velocity == pytest.approx(wanted, rel=1e-12)


def test_inverse_of_equation_4():
    """ε_eff = (√(1 + 4 v'_r/V) − 1)/2, also where this form would lose its digits."""
    from hardlimit import _core

    for e in (1e-12, 1e-6, 0.1, 0.5, 0.9, 1.0, 1.2):
        assert _core.effective_restitution(e * (1.0 + e) * 3.0, 3.0) == pytest.approx(e, rel=1e-14)
    assert math.isnan(_core.effective_restitution(math.nan, 3.0))


def test_no_contact():
    """The second floor contact comes first."""
    result = hl.independent(two_balls(0.1, 0.05, gap=1.0))
    assert result.outcome_code == hl.OUTCOMES.index("no_contact")
    assert result.n_contacts == 0 and math.isnan(result.relative_velocity)


def test_floor_is_met_again_after_each_bounce():
    """Bounces of the lower ball alone: 2 ε^k V/g apart."""
    column = two_balls(0.1, 0.5, gap=3.0)
    result = hl.independent(column, until=0.5)
    begins = result.contacts.begin.values[result.contacts.pair.values == 0]
    flights = [2.0 * 0.5**k * column.impact_speed / G for k in (1, 2, 3)]
    assert np.diff(begins)[:2] == pytest.approx(flights[:2], rel=1e-12)


@pytest.mark.parametrize("model", [hl.independent, hl.newton, hl.adiabatic])
def test_thrown_up_from_the_floor(model):
    """A release from the floor upwards is no impact: the first touch comes after the flight, 2v/g."""
    law = hl.LinearDashpot(stiffness=5e7, restitution=0.8)
    balls = [hl.Ball(0.05, density=840.0), hl.Ball(0.03, density=840.0)]
    result = model(hl.Column(balls, [5.0], 0.05, law, velocities=[1.0, 1.0]))
    assert result._core.t_first == pytest.approx(-2.0 / G, rel=1e-9)
    assert result.trajectory([-1.0 / G]).position.values[0, 0] == pytest.approx(0.05 + 0.5 / G, rel=1e-9)


def test_inelastic_collapse_has_an_outcome():
    """Three balls with ε below 7 − 4√3 collide infinitely often in a finite time."""
    law = law_of("linear", 0.05)
    column = hl.Column.cradle([hl.Ball(0.01, mass=1.0)] * 3, [1.0, 0.0, -1.0], law, gaps=[0.1, 0.15])
    result = hl.independent(column)
    assert result.outcome_code in (hl.OUTCOMES.index("collapse"), hl.OUTCOMES.index("ok"))
    assert np.isfinite(result.velocities).all()


@settings(max_examples=80)
@given(columns(law=st.floats(0.3, 1.0).map(lambda e: law_of("linear", e)), most=4, gravity=0.0))
def test_collisions_keep_momentum_and_never_gain_energy(column):
    result = hl.independent(column, until=0.5)
    masses = np.array([b.mass for b in column.balls])
    t = result.trajectory(np.unique(result.contacts.begin.values))
    kinetic = 0.5 * (t.velocity.values**2 @ masses)
    assert (np.diff(kinetic) <= 1e-12 * kinetic[0]).all()
    momentum = t.velocity.values @ masses
    floor = set(result.contacts.begin.values[result.contacts.pair.values == 0])
    kept = np.array([at not in floor for at in t.time.values[1:]], dtype=bool)
    scale = masses.sum() * np.abs(column.velocities).max()
    assert np.abs(np.diff(momentum)[kept]).max(initial=0.0) < 1e-12 * scale
