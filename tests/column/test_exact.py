"""Exact solver for two balls under the linear law: reference values of the paper, definitions and corner cases."""

import itertools
import math

import mpmath
import numpy as np
import pytest
import scipy
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import hardlimit as hl
from conftest import columns, draws, falling, law_of, slow

G = 9.81


def ball_contacts(result: hl.Result) -> np.ndarray:
    """Begin and end of the ball–ball contacts [s]."""
    c = result.contacts
    pairs = c.pair.values > 0
    return np.stack([c.begin.values[pairs], c.end.values[pairs]], axis=1)


# ---- reference values of the paper -------------------------------------------------------------------------


def test_figure_2():
    result = hl.newton(hl.Column.paper(0.7))
    micro = 1e6 * ball_contacts(result)
    wanted = [[194.415, 220.195], [387.902, 414.417], [539.693, 566.545], [695.097, 721.035]]
    assert np.abs(micro - wanted).max() < 5e-4
    assert abs(1e6 * result.t_floor_end - 775.172) < 5e-4
    # From 40-digit matrix exponentials and bisection for the events.
    assert abs(result.relative_velocity - 0.1717108979777039) < 1e-14
    assert abs(result.separation_velocity - 0.1254649281164159) < 1e-14
    assert result.n_contacts == 4
    assert result.t_end == ball_contacts(result)[-1, 1]
    assert result.outcome == "ok"


def test_velocity_at_the_end_jumps_where_the_count_changes():
    before = hl.newton(hl.Column.paper(0.8526, density=1140.0))
    after = hl.newton(hl.Column.paper(0.8527, density=1140.0))
    assert before.n_contacts == after.n_contacts + 1
    assert before.relative_velocity < 3e-4
    assert after.relative_velocity == pytest.approx(0.602, abs=1e-3)
    # The separation velocity is continuous.
    assert after.separation_velocity == pytest.approx(before.separation_velocity, abs=3e-5)


@pytest.mark.parametrize(("density", "spikes"), [(840.0, (0.782, 0.667)), (1140.0, (0.853, 0.718))])
def test_the_density_determines_the_spikes(density, spikes):
    """As ε increases, the last contact moves beyond the end of the floor contact and vanishes at the spike."""
    for count, at in zip((3, 4), spikes, strict=True):
        above = hl.newton(hl.Column.paper(at + 1.1e-3, density=density))
        below = hl.newton(hl.Column.paper(at - 1.1e-3, density=density))
        assert above.n_contacts == count
        assert below.n_contacts == count + 1
        assert ball_contacts(below)[-1, 0] > below.t_floor_end
    assert hl.newton(hl.Column.paper(1.0, density=density)).n_contacts == 3


def test_one_contact_does_not_mean_independent_collisions():
    result = hl.newton(hl.Column.paper(0.9, gap=5e-4))
    assert result.n_contacts == 1
    assert result.restitution_ratio == pytest.approx(0.641, abs=5e-4)
    assert result.restitution_ratio_at_separation == pytest.approx(0.112, abs=5e-4)


def test_figure_5_levels_off_where_the_floor_contact_is_over_first():
    """Δh > V (t_c − 2βε/ω0²) = 2.504 mm; then ε_eff/ε = 1.0009, because gravity acts during the contact."""
    column = hl.Column.paper(0.9)
    floor = column.contacts[0]
    beta = 0.5 * floor.damping / floor.effective_mass
    frequency2 = floor.stiffness / floor.effective_mass
    needed = column.impact_speed * (floor.duration() - 2.0 * beta * 0.9 / frequency2)
    assert needed == pytest.approx(2.504e-3, abs=5e-7)
    below = hl.newton(hl.Column.paper(0.9, gap=needed - 1e-5))
    above = [hl.newton(hl.Column.paper(0.9, gap=g)) for g in (needed + 1e-5, 5e-3, 1e-2)]
    assert ball_contacts(below)[0, 0] < below.t_floor_end
    for result in above:
        assert ball_contacts(result)[0, 0] > result.t_floor_end
        assert result.restitution_ratio == pytest.approx(1.0009, abs=5e-5)
    assert below.restitution_ratio < above[0].restitution_ratio


def test_figure_6_exceeds_one_up_to_a_ratio_of_1_51():
    ratios = np.arange(1.0, 2.0, 0.01)
    columns = [hl.Column.paper(0.8, radius_ratio=float(r)) for r in ratios]
    values = np.array([hl.newton(column).restitution_ratio for column in columns])
    assert values.max() == pytest.approx(1.0020, abs=5e-5)
    assert ratios[values.argmax()] == pytest.approx(1.42, abs=0.011)
    assert ratios[values > 1.0].max() == pytest.approx(1.505, abs=0.006)
    assert (values[ratios < 1.5] > 1.0).all()
    assert (values[ratios > 1.515] < 1.0).all()


def test_number_of_contacts():
    """It has one maximum as a function of ε, increases to a maximum as Δh decreases, and increases with R1/R2."""

    def count(*values, **options):
        return hl.newton(hl.Column.paper(*values, **options)).n_contacts

    over_restitution = np.array([count(float(e)) for e in np.arange(0.3, 1.0, 0.002)])
    top = over_restitution.argmax()
    assert (np.diff(over_restitution[: top + 1]) >= -1).all()
    assert (np.diff(over_restitution[top:]) <= 0).all()
    assert over_restitution[0] < over_restitution[top] > over_restitution[-1]
    over_gap = [count(0.7, float(g)) for g in np.logspace(-4.0, -2.3, 30)]
    assert (np.diff(over_gap) <= 0).all() and over_gap[0] > over_gap[-1] == 1
    over_ratio = [count(0.7, radius_ratio=float(r)) for r in (2, 5, 10, 15, 20, 25, 30)]
    assert (np.diff(over_ratio) >= 0).all() and over_ratio[-1] > over_ratio[0]


def test_floor_contact_lasts_longer_than_a_pair_contact_the_more_the_masses_differ():
    lengths = []
    for ratio in (1.0, 2.0, 5.0, 10.0, 20.0):
        floor, pair = hl.Column.paper(0.7, radius_ratio=ratio).contacts
        lengths.append(floor.duration() / pair.duration())
    assert (np.diff(lengths) > 0.0).all()
    # t_c grows as √m_eff: m_1 = m_2 gives √2.
    assert lengths[0] == pytest.approx(math.sqrt(2.0), rel=1e-14)


def test_times_count_from_the_first_floor_touch():
    column = hl.Column.paper(0.7)
    result = hl.newton(column)
    fall = math.sqrt(2.0 * 0.5 / G)
    assert float(result.contacts.begin[0]) == 0.0 and int(result.contacts.pair[0]) == 0
    assert column.impact_speed == pytest.approx(math.sqrt(2.0 * G * 0.5), rel=1e-15)
    at_release = result.trajectory([-fall * (1.0 - 1e-15)])
    assert at_release.position.values[0] == pytest.approx(column.initial_positions, rel=1e-15)
    assert np.abs(at_release.velocity.values).max() < 1e-13


# ---- closed form -------------------------------------------------------------------------------------------


def both_closed(result: hl.Result) -> tuple[float, float]:
    """Two times within one interval of motion C (both contacts closed)."""
    begin, end = ball_contacts(result)[0]
    assert 0.0 < begin < end < result.t_floor_end
    return begin + 0.01 * (end - begin), end - 0.01 * (end - begin)


def motion_c(column: hl.Column) -> mpmath.matrix:
    """Matrix M of motion C for the state (u, u̇, w, ẇ, 1)."""
    floor, pair = column.contacts
    m1, m2 = (b.mass for b in column.balls)
    k1, g1, k2, g2 = floor.stiffness, floor.damping, pair.stiffness, pair.damping
    return mpmath.matrix(
        [
            [0, 1, 0, 0, 0],
            [-k1 / m1, -g1 / m1, k2 / m1, g2 / m1, -G],
            [0, 0, 0, 1, 0],
            [k1 / m1, g1 / m1, -k2 * (1 / m1 + 1 / m2), -g2 * (1 / m1 + 1 / m2), 0],
            [0, 0, 0, 0, 0],
        ]
    )


def gaps_and_rates(column: hl.Column, samples: xr.Dataset) -> np.ndarray:
    """Rows (u, u̇, w, ẇ)."""
    r1, r2 = (b.radius for b in column.balls)
    z, v = samples.position.values, samples.velocity.values
    return np.stack([z[:, 0] - r1, v[:, 0], z[:, 1] - z[:, 0] - r1 - r2, v[:, 1] - v[:, 0]], axis=1)


@pytest.mark.parametrize("restitution", [1.0, 0.7, 0.3, math.exp(-2.0), 0.1])
@pytest.mark.parametrize("ratio", [2.0, 10.0])
def test_motion_with_both_contacts_is_the_matrix_exponential(restitution, ratio):
    """(u, u̇, w, ẇ, 1)' = M (u, u̇, w, ẇ, 1), propagated with 40 digits."""
    column = hl.Column.paper(restitution, gap=1e-4, radius_ratio=ratio)
    result = hl.newton(column)
    times = both_closed(result)
    samples = result.trajectory(times)
    assert (samples.force.values > 0.0).all()
    gaps = gaps_and_rates(column, samples)
    with mpmath.workdps(40):
        start = mpmath.matrix([*map(float, gaps[0]), 1])
        exact = mpmath.expm(motion_c(column) * mpmath.mpf(times[1] - times[0])) * start
        for i, scale in ((1, column.impact_speed), (3, column.impact_speed)):
            # Gaps computed from positions have an error of 1e-16 m, which ω = 1e5/s turns into 1e-12 m/s.
            assert abs(float(exact[i]) - gaps[1, i]) < 2e-11 * scale


def test_lower_ball_alone_bounces_with_the_given_restitution():
    """With the upper ball far above and no gravity: ε and t_c of one isolated collision."""
    for restitution in (1.0, 0.9, 0.5, math.exp(-2.0), 0.05):
        law = hl.LinearDashpot(stiffness=5e7, restitution=restitution)
        balls = [hl.Ball(0.1, density=840.0), hl.Ball(0.01, density=840.0)]
        column = hl.Column(balls, [1.0], 0.1, law, velocities=-2.0, gravity=0.0)
        result = hl.newton(column)
        assert result.t_floor_end == pytest.approx(column.contacts[0].duration(), rel=1e-13)
        velocity = result.trajectory([result.t_floor_end]).velocity.values[0, 0]
        assert velocity == pytest.approx(2.0 * restitution, rel=1e-13)


@draws(150)
@given(columns(law=st.floats(0.03, 1.0).map(lambda e: law_of("linear", e)), most=2))
def test_exact_and_general_solver_agree(column):
    exact = hl.newton(column, method="exact")
    general = hl.newton(column, method="general")
    assert exact.outcome == general.outcome
    if exact.n_contacts != general.n_contacts:  # a last contact without force may depend on rounding
        shortest = min(np.nanmin(np.diff(ball_contacts(r))) for r in (exact, general))
        assert shortest < 1e-6 * column.contacts[1].duration()
        return
    close = {"abs": 1e-9 * column.impact_speed, "nan_ok": True}
    assert exact.relative_velocity == pytest.approx(general.relative_velocity, **close)
    assert exact.separation_velocity == pytest.approx(general.separation_velocity, **close)
    assert exact.t_floor_end == pytest.approx(general.t_floor_end, rel=1e-9, nan_ok=True)


# ---- corner cases ------------------------------------------------------------------------------------------

DEFINED = ["relative_velocity", "t_end", "effective_restitution", "restitution_ratio"]


def check_outcome(result: hl.Result) -> None:
    """Each outcome determines which numbers are NaN."""
    values = {name: getattr(result, name) for name in DEFINED}
    if result.outcome == "ok":
        assert all(math.isfinite(v) for v in values.values()), values
        assert math.isfinite(result.t_floor_end)
        assert result.n_contacts > 0
    elif result.outcome.startswith("no ball–ball contact"):
        assert result.n_contacts == 0
        assert all(math.isnan(v) for v in values.values()), values
        assert math.isnan(result.separation_velocity)
    elif result.outcome.startswith("at rest"):
        assert math.isnan(result.t_end) or math.isnan(result.t_floor_end)
        if math.isnan(result.t_end):
            assert result.relative_velocity == result.separation_velocity == 0.0
    elif result.outcome.startswith("too deep"):
        assert all(math.isnan(v) for v in values.values()), values
        assert math.isnan(result.separation_velocity) and result.largest_compression == 0.5
    else:
        pytest.fail(f"{result.column}: {result.outcome}")


NASTY_RESTITUTIONS = [1.0, 1.0 - 1e-16, 1.0 - 1e-9, 0.9, 0.5, math.exp(-math.pi / 2.0), math.exp(-2.0), 1e-3]


@pytest.mark.parametrize("restitution", NASTY_RESTITUTIONS)
def test_any_gap_ratio_and_stiffness_has_an_answer_or_says_why_not(restitution):
    gaps, ratios, stiffnesses = [0.0, 1e-15, 1e-6, 1.0], [0.3, 1.0, 7.0, 30.0, 300.0], [1e3, 1e7, 1e11, 1e15]
    for gap, ratio, stiffness in itertools.product(gaps, ratios, stiffnesses):
        if restitution == 1e-3 and ratio > 10.0:
            continue  # above 100 the motion creeps for 1e5 relaxation times; the solver stops after a second
        column = hl.Column.paper(restitution, gap, ratio, stiffness=stiffness, height=4.0)
        result = hl.newton(column)
        check_outcome(result)


@pytest.mark.parametrize("restitution", [1.0, 0.9, 0.7, 0.4, math.exp(-2.0), 0.05])
@pytest.mark.parametrize("ratio", [0.5, 1.0, 3.0, 10.0])
def test_touching_is_the_limit_of_a_vanishing_gap(restitution, ratio):
    touching = hl.newton(hl.Column.paper(restitution, 0.0, ratio))
    close = hl.newton(hl.Column.paper(restitution, 1e-15, ratio))
    v = touching.column.impact_speed
    assert touching.n_contacts == close.n_contacts
    assert touching.outcome == close.outcome
    assert abs(touching.relative_velocity - close.relative_velocity) < 1e-9 * v
    assert ball_contacts(touching)[0, 0] == 0.0  # from the instant the pair begins to close
    assert 0.0 < ball_contacts(close)[0, 0] < 1e-6


def test_continuity_at_elastic_and_critical_damping():
    """The result is continuous at ε = 1 and ε = e^{−2}, where the formulas change form."""
    for restitution in (1.0 - 1e-12, math.exp(-2.0)):
        values = [
            hl.newton(hl.Column.paper(e, 1e-4)).relative_velocity
            for e in (restitution * (1.0 - 1e-13), restitution, restitution * (1.0 + 1e-13))
        ]
        assert np.ptp(values) < 1e-10
    elastic, nearly = (hl.newton(hl.Column.paper(e)).relative_velocity for e in (1.0, 1.0 - 1e-16))
    assert elastic == pytest.approx(nearly, abs=1e-12)


def test_at_rest():
    """ε V ω0 is too small compared with g: floor and pair stay closed forever."""
    result = hl.newton(hl.Column.paper(1e-3))
    assert result.outcome_code == hl.OUTCOMES.index("at_rest")
    assert result.relative_velocity == result.separation_velocity == 0.0
    assert math.isnan(result.t_end) and math.isnan(result.t_floor_end)
    assert np.isnan(result.contacts.end.values[-2:]).all()
    # At rest the contact forces carry the weights.
    late = result.trajectory([0.1])
    m1, m2 = (b.mass for b in result.column.balls)
    assert late.force.values[0] == pytest.approx([(m1 + m2) * G, m2 * G], rel=1e-6)
    assert np.abs(late.velocity.values).max() < 1e-7
    general = hl.newton(result.column, method="general")
    assert general.outcome == result.outcome


def test_no_contact_before_the_floor_is_met_again():
    result = hl.newton(hl.Column.paper(0.05, gap=1.0))
    assert result.outcome_code == hl.OUTCOMES.index("no_contact")
    assert result.n_contacts == 0
    assert math.isfinite(result.t_floor_end)
    check_outcome(result)
    assert hl.newton(result.column, method="general").outcome == result.outcome


@pytest.mark.slow
def test_reengagement_is_a_contact_of_its_own():
    """The clipped force sets in again while the balls still overlap."""
    reengagements = 0
    for restitution in np.arange(0.3, 0.9, 0.02):
        for gap in np.logspace(-6, -4, 15):
            result = hl.newton(hl.Column.paper(float(restitution), float(gap)))
            if result.n_contacts < 2:
                continue
            begins = ball_contacts(result)[1:, 0]
            state = result.trajectory(begins)
            distance = np.diff(state.position.values, axis=1)[:, 0] - 0.11
            closed = distance < -1e-12
            if not closed.any():
                continue
            reengagements += 1
            # The force then starts from zero, as it ended, instead of jumping to γ ξ̇.
            assert state.force.values[closed, 1].max() < 1e-6 * result.trajectory().force.values[:, 1].max()
    assert 5 < reengagements < 200


def test_pair_meets_before_the_floor():
    """The upper ball is thrown down: the first contact occurs in flight, at a negative time."""
    law = hl.LinearDashpot(stiffness=5e7, restitution=0.8)
    balls = [hl.Ball(0.05, density=840.0), hl.Ball(0.03, density=840.0)]
    column = hl.Column(balls, [1e-3], 0.6, law, velocities=[0.0, -1.0])
    exact, general = hl.newton(column, method="exact"), hl.newton(column, method="general")
    assert ball_contacts(exact)[0, 0] < -0.1
    assert exact.n_contacts == general.n_contacts
    assert ball_contacts(exact) == pytest.approx(ball_contacts(general), rel=1e-9)
    v = column.impact_speed
    assert abs(exact.relative_velocity - general.relative_velocity) < 1e-9 * v
    assert abs(exact.separation_velocity - general.separation_velocity) < 1e-9 * v
    first = exact.contacts.isel(contact=0)
    assert int(first.pair) == 1
    duration = column.contacts[1].duration()
    assert float(first.end - first.begin) == pytest.approx(duration, rel=1e-9)
    # Time zero is the first floor touch, which is earlier than without the collision.
    floor = exact.contacts.begin.values[exact.contacts.pair.values == 0]
    assert floor[0] == 0.0
    assert -exact.trajectory().time.values[0] < math.sqrt(2.0 * 0.55 / G)


@pytest.mark.parametrize("velocities", [[-1.0, -1.0], [1.5, 0.3], [-0.5, 2.0], [2.0, -3.0]])
def test_released_with_velocities(velocities):
    """V = √(v_lower² + 2g(height − R1)); both solvers agree."""
    law = hl.LinearDashpot(stiffness=5e7, restitution=0.85)
    balls = [hl.Ball(0.05, density=840.0), hl.Ball(0.03, density=840.0)]
    column = hl.Column(balls, [5e-3], 0.1, law, velocities=velocities)
    assert column.impact_speed == pytest.approx(math.sqrt(velocities[0] ** 2 + 2.0 * G * 0.05), rel=1e-15)
    exact, general = hl.newton(column), hl.newton(column, method="general")
    assert exact.n_contacts == general.n_contacts
    assert ball_contacts(exact) == pytest.approx(ball_contacts(general), rel=1e-8, abs=1e-12)
    assert exact.relative_velocity == pytest.approx(general.relative_velocity, rel=1e-8, nan_ok=True)


@pytest.mark.parametrize("gap", [1e-15, slow(1e-13), 1e-11])
@pytest.mark.parametrize("speed", [1e-5, slow(2e-4), slow(1e-2)])
def test_a_gap_that_closes_as_the_third_power_of_time(gap, speed):
    """Both balls fall together, and the pair closes only because the floor stops the lower ball.

    Closed form with 40 digits: the lower ball oscillates on the floor, the upper one falls freely.
    """
    law = hl.LinearDashpot(stiffness=3e4, restitution=1.0)
    column = falling([0.3, 2e-3], [gap], law, speed=speed, gravity=9.81)
    with mpmath.workdps(40):
        m, k, v, g = (mpmath.mpf(x) for x in (column.balls[0].mass, 3e4, speed, 9.81))
        omega = mpmath.sqrt(k / m)

        def closing(t):
            swing = -g / omega**2 * (1 - mpmath.cos(omega * t)) - v / omega * mpmath.sin(omega * t)
            return gap - v * t - g * t**2 / 2 - swing

        late = 2 * mpmath.cbrt(6 * gap / (omega**2 * v))
        assert closing(late) < 0.0 < closing(0)
        touch = mpmath.findroot(closing, (0, late), solver="bisect", maxsteps=150, verify=False)
    assert ball_contacts(hl.newton(column, method="exact"))[0][0] == pytest.approx(float(touch), rel=1e-10)


@pytest.mark.parametrize("gap", [1e-15, 1e-12, 1e-9])
@pytest.mark.parametrize("mass_ratio", [10.0, 1e5])
def test_a_ball_thrown_up_from_close_to_the_floor_falls_back_in_time(gap, mass_ratio):
    """The upper ball pushes it down meanwhile; the energy balance checks the time of the floor contact."""
    balls = [hl.Ball(1e-3, mass=0.7 * mass_ratio), hl.Ball(1e-4, mass=0.7)]
    law = hl.LinearDashpot(stiffness=1e15, restitution=1.0)
    column = hl.Column(balls, 0.0, 1e-3 + gap, law, velocities=[30.0, -30.0], gravity=1000.0)
    results = {method: hl.newton(column, method=method, until=0.01) for method in ("exact", "general")}
    begin = {method: float(result.contacts.begin.min()) for method, result in results.items()}
    assert begin["exact"] == pytest.approx(begin["general"], rel=1e-12)
    t = results["exact"].trajectory(np.array([begin["exact"], 0.0, 0.01]))
    total = t.kinetic_energy + t.potential_energy + t.contact_energy + t.dissipated_energy
    assert total.values == pytest.approx(np.full(3, total.values[0]), rel=1e-12)


@pytest.mark.parametrize("method", ["exact", "general"])
def test_until_continues_the_run_and_changes_nothing_before(method):
    column = hl.Column.paper(0.7)
    plain = hl.newton(column, method=method)
    for until in (3e-4, 6e-4, 2e-3, 0.5, 3.0):
        longer = hl.newton(column, until=until, method=method)
        assert longer.n_contacts == plain.n_contacts == 4
        assert longer.relative_velocity == pytest.approx(plain.relative_velocity, rel=1e-12)
        assert (longer.contacts.begin.values <= until).all()
        both = min(len(longer.contacts.begin), int((plain.contacts.begin <= until).sum()))
        begins = plain.contacts.begin.values[:both]
        assert longer.contacts.begin.values[:both] == pytest.approx(begins, rel=1e-11)
        sample = longer.trajectory([until])
        assert longer.positions == pytest.approx(sample.position.values[0], rel=1e-14)
        assert longer.velocities == pytest.approx(sample.velocity.values[0], rel=1e-12)
    # The balls continue to bounce: more floor contacts, all in order of time.
    begins = hl.newton(column, until=3.0, method=method).contacts.begin.values
    assert len(begins) > 20
    assert (np.diff(begins) >= 0.0).all()


def test_until_of_both_solvers_agree_through_many_bounces():
    column = hl.Column.paper(0.9, gap=1e-3, radius_ratio=2.0)
    exact = hl.newton(column, until=0.7, method="exact")
    general = hl.newton(column, until=0.7, method="general")
    assert len(exact.contacts.begin) == len(general.contacts.begin) > 3
    assert exact.velocities == pytest.approx(general.velocities, abs=1e-8)
    assert exact.positions == pytest.approx(general.positions, abs=1e-9)


@pytest.mark.parametrize("method", ["exact", "general"])
@pytest.mark.parametrize("restitution", [1.0, 0.7, math.exp(-2.0), 0.05])
def test_energy_balance(method, restitution):
    """Kinetic + potential + contact energy + dissipated = initial, to 1e-10."""
    column = hl.Column.paper(restitution, gap=3e-5)
    result = hl.newton(column, method=method)
    energy = result.trajectory()
    total = energy.kinetic_energy + energy.potential_energy + energy.contact_energy + energy.dissipated_energy
    m1, m2 = (b.mass for b in column.balls)
    initial = G * ((m1 + m2) * column.drop_height + m2 * 3e-5)
    assert np.abs(total.values / initial - 1.0).max() < 1e-10
    assert (np.diff(energy.dissipated_energy.values) >= -1e-12 * initial).all()
    if restitution == 1.0:
        assert np.abs(energy.dissipated_energy.values).max() < 1e-12 * initial
    else:
        assert energy.dissipated_energy.values[-1] > 1e-3 * initial


def test_one_damping_constant_for_all_contacts():
    """Appendix C: γ is a material constant; then ε01 ≠ ε12, and no single ε exists to compare with."""
    law = hl.LinearDashpot(stiffness=5e7, damping=2000.0)
    column = hl.Column.paper(law=law)
    floor, pair = column.contacts
    assert floor.damping == pair.damping == 2000.0
    assert floor.restitution() > pair.restitution()
    result = hl.newton(column)
    assert math.isnan(result.restitution_ratio) and math.isfinite(result.effective_restitution)
    general = hl.newton(column, method="general")
    assert result.n_contacts == general.n_contacts
    assert result.relative_velocity == pytest.approx(general.relative_velocity, abs=1e-9)
    # With one ε each contact gets its own γ.
    floor, pair = hl.Column.paper(0.7).contacts
    ratio = math.sqrt(floor.effective_mass / pair.effective_mass)
    assert floor.damping / pair.damping == pytest.approx(ratio, rel=1e-14)


# ---- light lower balls, creep, long flights and very long contacts ---------------------------------------------


def relative_velocity_to_40_digits(column: hl.Column) -> float:
    """v'_r of a touching elastic pair whose contacts are both closed from the first touch on, from exp(M t).

    The pair separates at the first zero of w after the floor touch, bracketed with the double-precision solution.
    """
    floor, pair = column.contacts
    end = float(ball_contacts(hl.newton(column))[0, 1])
    with mpmath.workdps(40):
        m1, m2 = (mpmath.mpf(b.mass) for b in column.balls)
        k1, k2 = mpmath.mpf(floor.stiffness), mpmath.mpf(pair.stiffness)
        a, b, c, d = k1 / m1, k2 / m1, k1 / m1, k2 / m1 + k2 / m2
        root = mpmath.sqrt((a + d) ** 2 / 4 - (a * d - b * c))
        squares = [(a + d) / 2 + root, (a + d) / 2 - root]
        g = mpmath.mpf(G)
        w0 = -g * m2 / k2
        u0 = -g * (m1 + m2) / k1
        speed = -mpmath.sqrt(2 * g * (mpmath.mpf(column.height) - mpmath.mpf(column.balls[0].radius)))
        # Modes (u, w) = (b, a − ω²): starts at (−u0, −w0) with rates (speed, 0).
        shapes = [(b, a - s) for s in squares]
        solve = mpmath.matrix([[shapes[0][0], shapes[1][0]], [shapes[0][1], shapes[1][1]]])
        cosine = mpmath.lu_solve(solve, mpmath.matrix([-u0, -w0]))
        sine = mpmath.lu_solve(solve, mpmath.matrix([speed, 0]))
        omega = [mpmath.sqrt(s) for s in squares]

        def gap(t: mpmath.mpf) -> mpmath.mpf:
            modes = zip(shapes, omega, cosine, sine, strict=True)
            return w0 + sum(
                s * (a * mpmath.cos(w * t) + b / w * mpmath.sin(w * t)) for (_, s), w, a, b in modes
            )

        return float(mpmath.diff(gap, mpmath.findroot(gap, end)))


@pytest.mark.parametrize("ratio", [0.2, 0.05, 0.03, 0.01, 0.005])
def test_a_light_lower_ball_keeps_the_digits(ratio):
    """Computing 1 − a2 = m1/(m1 + m2) by subtraction caused an error of 1e-7 V at R1/R2 = 0.01. The condition number of
    the problem grows with the number of oscillations of the light ball, (R2/R1)^{3/2}."""
    column = hl.Column.paper(1.0, gap=0.0, radius_ratio=ratio)
    exact = hl.newton(column)
    assert float(exact.contacts.begin[1]) == 0.0
    assert exact.t_floor_end > float(ball_contacts(exact)[0, 1])  # motion C throughout
    within = (5e-12 + 2e-17 / ratio**3) * column.impact_speed
    expected = relative_velocity_to_40_digits(column)
    assert abs(exact.relative_velocity - expected) < within
    swept = hl.sweep(column, gap=[0.0])
    assert abs(float(swept.relative_velocity[0]) - expected) < within


CREEPS = [(10.0, 1e-5), (10.0, 1e-8), (10.0, 1e-12), (10.0, 1e-30), (100.0, 1e-3), (100.0, 1e-2), (1.0, 1e-8)]


@pytest.mark.parametrize("model", ["newton", "adiabatic"])
@pytest.mark.parametrize(("ratio", "restitution"), CREEPS)
@pytest.mark.parametrize("gap", [0.0, 1e-4])
def test_creep_ends_at_rest(ratio, restitution, gap, model):
    """A relaxation of up to 1e60 pieces ends at rest as soon as no ball can accelerate as in free fall."""
    column = hl.Column.paper(restitution, gap, ratio, height=max(0.6, 0.02 * ratio))
    result = getattr(hl, model)(column)
    assert result.outcome_code == hl.OUTCOMES.index("at_rest")
    assert result.n_contacts == 1


@pytest.mark.parametrize("n", [60, slow(400)])
def test_strongly_damped_random_columns_are_resolved(n):
    rng = np.random.default_rng(4)
    swept = {
        "restitution": 10.0 ** rng.uniform(-12, 0, n),
        "radius_ratio": 10.0 ** rng.uniform(-2, 3, n),
        "gap": 10.0 ** rng.uniform(-12, -1, n),
        "stiffness": 10.0 ** rng.uniform(3, 12, n),
    }
    points = {name: xr.DataArray(v, dims="point") for name, v in swept.items()}
    for model in ("newton", "adiabatic"):
        outcome = hl.sweep(hl.Column.paper(height=11.0), model, **points).outcome.values
        assert not (outcome == hl.OUTCOMES.index("unresolved")).any()


@pytest.mark.parametrize("until", [0.035, 0.05, 0.07])
def test_velocities_of_a_relaxation_keep_their_digits(until):
    """Overdamped balls on the floor, 0.1 to 1e-16 m/s: small velocities are not differences of large numbers."""
    column = hl.Column.paper(0.05)
    result = hl.newton(column, until=until)
    begin = float(result.contacts.begin.values[-1]) + 1e-6
    samples = result.trajectory([begin, until])
    assert (samples.force.values > 0.0).all()
    gaps = gaps_and_rates(column, samples)
    with mpmath.workdps(40):
        start = mpmath.matrix([*map(float, gaps[0]), 1])
        exact = mpmath.expm(motion_c(column) * (mpmath.mpf(until) - mpmath.mpf(begin))) * start
    assert gaps[1, 1] == pytest.approx(float(exact[1]), rel=1e-9)
    assert float(samples.velocity[1, 1]) == pytest.approx(float(exact[1] + exact[3]), rel=1e-9)


@pytest.mark.parametrize("model", ["newton", "adiabatic"])
def test_dissipated_energy_of_a_relaxation_is_the_work_of_the_dashpots(model):
    """∫ γ u̇² dt of both contacts from a Lyapunov equation, over hundreds of pieces."""
    column = hl.Column.paper(0.05)
    result = getattr(hl, model)(column, until=0.05)
    times = [float(result.contacts.begin.values[-1]) + 1e-6, 0.05]
    samples = result.trajectory(times)
    floor, pair = column.contacts
    rates = np.array(motion_c(column).tolist(), dtype=float)[:4, :4]
    if model == "adiabatic":
        rates[1, 2:] = 0.0
        rates[3, 2:] = -pair.stiffness / column.balls[1].mass, -pair.damping / column.balls[1].mass
    # Lengths in units of 1e-5 s times a velocity make the equation well scaled.
    omega = np.diag([1e5, 1.0, 1e5, 1.0])
    scaled = omega @ rates @ np.linalg.inv(omega)
    work = scipy.linalg.solve_continuous_lyapunov(scaled.T, -np.diag([0.0, floor.damping, 0.0, pair.damping]))
    w0 = -column.balls[1].mass * G / pair.stiffness
    above = 0.0 if model == "adiabatic" else column.balls[1].mass
    u0 = -(column.balls[0].mass + above) * G / floor.stiffness
    x = (gaps_and_rates(column, samples) - [u0, 0.0, w0, 0.0]) @ omega
    expected = x[0] @ work @ x[0] - x[1] @ work @ x[1]
    dissipated = samples.dissipated_energy.values
    assert expected > 1e-3
    assert dissipated[1] - dissipated[0] == pytest.approx(expected, rel=1e-7)


def random_column(rng: np.random.Generator) -> hl.Column:
    """Any setting of the explorer, including elastic balls."""
    radii = np.exp(rng.uniform(math.log(1e-3), math.log(0.5), 2))
    stiffness = 5e7 if rng.random() < 0.5 else 10.0 ** rng.uniform(3, 9)
    restitution = 1.0 if rng.random() < 0.1 else rng.uniform(0.02, 1.0)
    law = hl.LinearDashpot(stiffness=stiffness, restitution=restitution)
    balls = [hl.Ball(r, density=840.0) for r in radii]
    return hl.Column(balls, [10.0 ** rng.uniform(-8, 0)], radii[0] + 10.0 ** rng.uniform(-3, 1), law)


@pytest.mark.parametrize("model", ["newton", "adiabatic"])
def test_the_number_of_pieces_follows_the_contacts_and_not_the_duration(model):
    """A ball that rests or oscillates on another one has up to 1e6 periods in a second."""
    rng = np.random.default_rng(8)
    law = hl.LinearDashpot(stiffness=5e7, restitution=0.7)
    cases = [
        (hl.Column([hl.Ball(r1, density=840.0), hl.Ball(r2, density=840.0)], [1e-4], r1 + fall, law), until)
        for r1, r2, fall, until in [(0.5, 1e-3, 1.6e-3, 0.5), (0.5, 1e-3, 0.1, 3.0), (1e-3, 0.5, 9e-3, 3.0)]
    ]
    cases += [(random_column(rng), rng.uniform(0.1, 3.0)) for _ in range(150)]
    for column, until in cases:
        sequence = getattr(hl, model)(column)
        result = getattr(hl, model)(column, until=until)
        contacts = len(result.contacts.begin)
        assert result.outcome_code != hl.OUTCOMES.index("unresolved")
        assert result._core.steps < sequence._core.steps + 50 + 20 * contacts


@pytest.mark.parametrize("restitution", [1e-2, 3e-2])
@pytest.mark.parametrize("ratio", [1.0, 10.0])
def test_strong_damping_agrees_with_the_general_solver(restitution, ratio):
    for gap in (0.0, 1e-3):
        column = hl.Column.paper(restitution, gap, ratio)
        exact, general = hl.newton(column, method="exact"), hl.newton(column, method="general")
        assert exact.outcome == general.outcome
        assert exact.n_contacts == general.n_contacts
        assert exact.relative_velocity == pytest.approx(general.relative_velocity, abs=1e-9, nan_ok=True)


def test_times_after_a_long_flight_keep_their_digits():
    """10 µm grains, the lower one thrown up at 20 m/s towards the upper: a flight of 4 s before contacts of 10 ns."""
    law = hl.LinearDashpot(stiffness=1e4, restitution=0.9)
    balls = [hl.Ball(1e-5, density=2500.0), hl.Ball(1e-5, density=2500.0)]
    column = hl.Column(balls, [1e-6], 2e-5, law, velocities=[20.0, 10.0])
    result = hl.newton(column)
    assert float(result.contacts.begin[0]) < -1.0  # the pair meets in flight
    floor = result.contacts.where(result.contacts.pair == 0, drop=True)
    assert floor.begin[0] == 0.0
    assert float(floor.end[0]) == pytest.approx(column.contacts[0].duration(), rel=1e-13)


@pytest.mark.parametrize("stiffness", [5e-324, 1e-310, 1e-300])
def test_contacts_without_measure_end(stiffness):
    result = hl.newton(hl.Column.paper(stiffness=stiffness))
    assert result.outcome_code == hl.OUTCOMES.index("too_deep")


def ringing_column(rng: np.random.Generator, restitution: float) -> hl.Column:
    """A light ball on the floor and a heavy ball that touches it, with separate spring constants."""
    ratio = 10.0 ** rng.uniform(5.0, 12.0)
    stiffness = 10.0 ** rng.uniform(4.0, 8.0, 2)
    laws = [hl.LinearDashpot(stiffness=float(k), restitution=restitution) for k in stiffness]
    balls = [hl.Ball(1.0, mass=1.0 / ratio), hl.Ball(1.0, mass=1.0)]
    return hl.Column(balls, [0.0], 1.0 + 10.0 ** rng.uniform(-4.0, 0.0), laws)


def undamped_gap(column: hl.Column, t: float) -> tuple[float, float]:
    """Gap of the pair and its largest value so far, with both contacts closed since t = 0, to 30 digits."""
    m1, m2 = (mpmath.mpf(ball.mass) for ball in column.balls)
    k1, k2 = (mpmath.mpf(contact.stiffness) for contact in column.contacts)
    g, v = mpmath.mpf(column.gravity), mpmath.mpf(column.impact_speed)
    a, b, c, d = (k1 + k2) / m1, -k2 / m1, -k2 / m2, k2 / m2
    fast = (a + d + mpmath.sqrt((a - d) ** 2 + 4 * b * c)) / 2
    slow = (a * d - b * c) / fast
    still = (-(m1 + m2) * g / k1, -(m1 + m2) * g / k1 - m2 * g / k2)

    def modes(u: mpmath.mpf, s: mpmath.mpf) -> tuple[mpmath.mpf, mpmath.mpf]:
        along = (u - (slow - d) * s / c) / (fast - slow)
        return along, s / c - along

    heights, rates = modes(-still[0], -still[1]), modes(-v, -v)
    gap, scale = still[1] - still[0], mpmath.mpf(0)
    for square, height, rate in zip((fast, slow), heights, rates, strict=True):
        w = mpmath.sqrt(square)
        share = c - (square - d)
        gap += share * (height * mpmath.cos(w * t) + rate / w * mpmath.sin(w * t))
        scale += abs(share) * mpmath.sqrt(height**2 + (rate / w) ** 2)
    return float(gap), float(scale)


def test_undamped_oscillations_of_a_light_ball_need_few_steps():
    """Up to 1e6 oscillations need few pieces, and the pair contact ends at the zero of the closed form."""
    rng = np.random.default_rng(5)
    compared = 0
    for _ in range(60):
        column = ringing_column(rng, 1.0)
        result = hl.newton(column)
        assert result.outcome == "ok" and result._core.steps < 100_000
        if result.n_contacts > 1 or result.t_floor_end < result.t_end:
            continue  # the contacts were not both closed all the time
        with mpmath.workdps(30):
            gap, scale = undamped_gap(column, result.t_end)
        assert abs(gap) <= 1e-10 * scale
        compared += 1
    assert compared >= 15


@pytest.mark.parametrize("loss", [1e-9, 1e-6, 1e-4])
def test_weakly_damped_oscillations_of_a_light_ball_need_few_steps(loss):
    """With weak damping, which couples the modes, energy is conserved; the balance does not use the modes."""
    rng = np.random.default_rng(6)
    for _ in range(12):
        column = ringing_column(rng, 1.0 - loss)
        result = hl.newton(column)
        assert result.outcome == "ok" and result._core.steps < 100_000
        end = result.trajectory([0.0, result.t_end])
        energy = end.kinetic_energy + end.potential_energy + end.contact_energy + end.dissipated_energy
        assert float(abs(energy[1] - energy[0])) <= 1e-8 * float(energy[0])
