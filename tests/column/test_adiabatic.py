"""Adiabatic model (Appendix A): the upper ball does not act on the lower one. The error is of first order in m2/m1."""

import itertools
import math

import numpy as np
import pytest
import scipy

import hardlimit as hl

G = 9.81


def column_of_mass_ratio(mu: float, restitution: float = 0.7, stiffer: float = 20.0) -> hl.Column:
    """m2 = μ m1 at fixed contact times: 0.7 ms at the floor, shorter for the pair."""
    m2 = 0.01
    m1 = m2 / mu
    floor = hl.LinearDashpot(stiffness=2e7 * m1, restitution=restitution)
    pair = hl.LinearDashpot(stiffness=2e7 * m2 * stiffer, restitution=restitution)
    return hl.Column([hl.Ball(0.1, mass=m1), hl.Ball(0.01, mass=m2)], [1e-4], 0.6, [floor, pair])


@pytest.mark.parametrize("restitution", [1.0, 0.7, 0.4])
@pytest.mark.parametrize("stiffer", [1.0, 20.0])
def test_error_is_of_first_order_in_the_mass_ratio(restitution, stiffer):
    ratios = 10.0 ** -np.arange(3.0, 7.0)
    errors = []
    for mu in ratios:
        column = column_of_mass_ratio(float(mu), restitution, stiffer)
        approximate, full = hl.adiabatic(column), hl.newton(column)
        assert approximate.n_contacts == full.n_contacts
        errors.append(abs(approximate.relative_velocity - full.relative_velocity) / column.impact_speed)
    order = np.polyfit(np.log(ratios), np.log(errors), 1)[0]
    assert order == pytest.approx(1.0, abs=0.02)
    assert errors[0] > 1e-5  # the models do differ


def test_error_falls_with_the_radius_ratio():
    """At equal density the mass ratio is (R2/R1)³: ten times the radius gives a thousandth of the error."""
    errors = []
    for ratio in (2.0, 20.0):
        column = hl.Column.paper(0.8, gap=0.02, radius_ratio=ratio)
        approximate, full = hl.adiabatic(column), hl.newton(column)
        errors.append(abs(approximate.relative_velocity - full.relative_velocity) / column.impact_speed)
    assert math.log10(errors[0] / errors[1]) == pytest.approx(3.0, abs=0.35)


def test_sequences_agree_at_the_ratio_of_figure_3():
    """R1/R2 = 10: the same number of contacts at nearly every ε, at nearly the same times.

    A barely occurring last contact may be late: contacts after the floor contact are not compared.
    """
    same = 0
    restitutions = np.arange(0.5, 1.0, 0.005)
    for restitution in restitutions:
        column = hl.Column.paper(float(restitution))
        approximate, full = hl.adiabatic(column), hl.newton(column)
        if approximate.n_contacts != full.n_contacts:
            continue
        same += 1
        early = full.contacts.begin.values < 0.9 * full.t_floor_end
        begins = approximate.contacts.begin.values[early]
        assert begins == pytest.approx(full.contacts.begin.values[early], rel=0.03)
    assert same > 0.85 * len(restitutions)


def test_lower_ball_moves_as_if_alone():
    """t01 and the motion of the lower ball do not depend on the upper ball."""
    histories = []
    for radius in (0.001, 0.01, 0.05):
        column = hl.Column.paper(0.7, radius_1=0.1, radius_2=radius)
        result = hl.adiabatic(column)
        times = np.linspace(0.0, 1e-3, 50)
        histories.append((result.t_floor_end, result.trajectory(times).velocity.values[:, 0]))
    for t_floor_end, velocity in histories[1:]:
        assert t_floor_end == pytest.approx(histories[0][0], rel=1e-12)
        assert velocity == pytest.approx(histories[0][1], abs=1e-12)


@pytest.mark.parametrize("restitution", [1.0, 0.7, 0.3])
def test_four_motions_by_an_independent_integration(restitution):
    """m1 z̈1 = −m1 g + F01 and m2 z̈2 = −m2 g + F12, integrated by SciPy between all events found."""
    column = hl.Column.paper(restitution, gap=5e-5)
    result = hl.adiabatic(column)
    floor, pair = column.contacts
    m1, m2 = (b.mass for b in column.balls)
    contacts = result.contacts
    marks = np.unique(np.concatenate([[0.0], contacts.begin.values, contacts.end.values]))
    marks = marks[np.isfinite(marks)]
    y = np.array([0.0, -column.impact_speed, 5e-5, 0.0])  # u, u̇, w, ẇ
    for start, stop in itertools.pairwise(marks):
        middle = 0.5 * (start + stop)
        acts = [
            bool(((contacts.pair == j) & (contacts.begin <= middle) & (contacts.end > middle)).any())
            for j in (0, 1)
        ]

        def right(_, y, acts=acts):
            u, du, w, dw = y
            f01 = -floor.stiffness * u - floor.damping * du if acts[0] else 0.0
            f12 = -pair.stiffness * w - pair.damping * dw if acts[1] else 0.0
            a1 = f01 / m1 - G
            return [du, a1, dw, f12 / m2 - G - a1]

        y = scipy.integrate.solve_ivp(right, (start, stop), y, "DOP853", rtol=1e-12, atol=1e-15).y[:, -1]
        # At the end of a contact the force is zero; at the beginning of one after flight the gap is zero.
        for j, gap, rate, contact in ((0, y[0], y[1], floor), (1, y[2], y[3], pair)):
            if (contacts.end.values[contacts.pair.values == j] == stop).any():
                force = -contact.stiffness * gap - contact.damping * rate
                assert abs(force) < 1e-7 * contact.stiffness * 1e-3
        state = result.trajectory([stop])
        assert state.velocity.values[0] == pytest.approx([y[1], y[1] + y[3]], abs=1e-9)
        assert state.position.values[0, 0] - 0.1 == pytest.approx(y[0], abs=1e-13)


def test_start_at_the_equilibrium_of_the_floor_contact():
    """The phase in Eq. A4 is 0/0 at z = z_inh; without gravity every floor contact begins there."""
    law = hl.LinearDashpot(stiffness=5e7, restitution=0.6)
    balls = [hl.Ball(0.1, density=840.0), hl.Ball(0.01, density=840.0)]
    column = hl.Column(balls, [1e-4], 0.1, law, velocities=-3.0, gravity=0.0)
    result = hl.adiabatic(column)
    assert result.t_floor_end == pytest.approx(column.contacts[0].duration(), rel=1e-13)
    bounced = result.trajectory([result.t_floor_end]).velocity.values[0, 0]
    assert bounced == pytest.approx(0.6 * 3.0, rel=1e-13)
    assert math.isfinite(result.relative_velocity)


def test_only_two_balls_on_a_floor_under_the_linear_law():
    ball, law = hl.Ball(0.01, mass=0.1), hl.LinearDashpot(stiffness=1e6, restitution=0.9)
    soft = hl.Viscoelastic(youngs_modulus=1e9, poisson_ratio=0.3, dissipative_time=0.0)
    for column in (
        hl.Column([ball] * 3, 0.0, 0.1, law),
        hl.Column.cradle([ball, ball], [1.0, 0.0], law),
        hl.Column([ball] * 2, 0.0, 0.1, soft),
    ):
        with pytest.raises(ValueError, match="two balls on a floor under the linear law"):
            hl.adiabatic(column)


@pytest.mark.slow
def test_absurd_damping_ends():
    """Rounding leaves nothing of the motion; a contact of the pair that lasts 1e20 pieces is one step."""
    result = hl.adiabatic(hl.Column.paper(law=hl.LinearDashpot(stiffness=5e7, damping=1e30)))
    assert result.outcome.startswith("not resolved") and np.isfinite(result.positions).all()
