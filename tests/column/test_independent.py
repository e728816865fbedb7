"""The independent-collisions model: Eqs. 1–6 with the corrected v12, cascades, event-driven sequence."""

import math
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hardlimit as hl
from conftest import columns, draws, law_of
from hardlimit import _core

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


def column_in_line(masses, law, gap=1e-9) -> hl.Column:
    """A column that falls at unit speed, with the lowest ball at the floor and almost closed gaps."""
    balls = [hl.Ball(0.01, mass=m) for m in masses]
    return hl.Column(balls, gap, 0.01, law, velocities=-1.0, gravity=0.0)


@pytest.mark.parametrize("restitution", [1.0, 0.9, 0.6])
@pytest.mark.parametrize("ratios", [[0.1, 0.1, 0.1], [0.5, 0.2, 0.9, 0.3]])
def test_upward_cascade(restitution, ratios):
    """v_{k+1} + V = (v_k + V)(1 + ε)/(1 + μ_k); each ball is hit once from below."""
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
    # Without `until` the run ends at the second floor contact.
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
    """ε_eff = (√(1 + 4 v'_r/V) − 1)/2, also where this form suffers from cancellation."""
    for e in (1e-12, 1e-6, 0.1, 0.5, 0.9, 1.0, 1.2):
        assert _core.effective_restitution(e * (1.0 + e) * 3.0, 3.0) == pytest.approx(e, rel=1e-14)
    assert math.isnan(_core.effective_restitution(math.nan, 3.0))


def test_no_contact():
    """The second floor contact comes first."""
    result = hl.independent(two_balls(0.1, 0.05, gap=1.0))
    assert result.outcome_code == hl.OUTCOMES.index("no_contact")
    assert result.n_contacts == 0 and math.isnan(result.relative_velocity)


@pytest.mark.parametrize("model", [hl.independent, hl.newton, hl.adiabatic])
def test_thrown_up_from_the_floor(model):
    """A ball released upwards from the floor has its first floor touch after the flight, at 2v/g."""
    law = hl.LinearDashpot(stiffness=5e7, restitution=0.8)
    balls = [hl.Ball(0.05, density=840.0), hl.Ball(0.03, density=840.0)]
    result = model(hl.Column(balls, [5.0], 0.05, law, velocities=[1.0, 1.0]))
    assert result._core.t_first == pytest.approx(-2.0 / G, rel=1e-9)
    assert result.trajectory([-1.0 / G]).position.values[0, 0] == pytest.approx(0.05 + 0.5 / G, rel=1e-9)


COLLAPSE = hl.OUTCOMES.index("collapse")


@pytest.mark.parametrize("restitution", [0.2, 0.5, 0.9])
def test_a_bouncing_ball_comes_to_rest(restitution):
    """Its bounces take 2 ε^k V/g each, 2 ε V/(g (1 − ε)) in total; then it rests on the floor."""
    column = two_balls(0.1, restitution, gap=1e5)
    rest = 2.0 * restitution * column.impact_speed / (G * (1.0 - restitution))
    result = hl.independent(column, until=rest + 1.0)
    assert result.outcome_code == COLLAPSE
    assert result.contacts.begin.values[-1] == pytest.approx(rest, rel=1e-7)
    late = result.trajectory(np.linspace(rest * (1.0 + 1e-7), 10.0 * rest, 50))
    assert (late.position.values[:, 0] == 0.1).all() and (late.velocity.values[:, 0] == 0.0).all()
    shortly = hl.independent(column, until=0.9 * rest)
    assert shortly.outcome_code != COLLAPSE


@pytest.mark.parametrize(("restitution", "until"), [(0.5, 1.0), (0.5, 100.0), (0.9, 10.0), (0.9, 300.0)])
def test_the_papers_drop_never_falls_through_the_floor(restitution, until):
    result = hl.independent(hl.Column.paper(restitution=restitution), until=until)
    assert result.outcome_code == COLLAPSE
    assert result.positions[0] == 0.1 and result.velocities[0] == 0.0
    assert result.positions[1] >= 0.21
    if until > 99.0:
        assert result.positions == pytest.approx([0.1, 0.21], abs=1e-12)


def test_a_ball_under_a_law_that_is_elastic_at_small_speed_comes_to_rest():
    """Viscoelastic: 1 − ε ~ v^(1/5), so the flights shrink as 1/n⁵, infinitely many in a finite time."""
    law = hl.Viscoelastic(youngs_modulus=1e8, poisson_ratio=0.3, restitution=0.4, impact_speed=3.0)
    balls = [hl.Ball(0.05, density=840.0), hl.Ball(0.02, density=840.0)]
    column = hl.Column(balls, [1e4], 0.5, law)
    floor = column.contacts[0]
    v, rest = column.impact_speed, 0.0
    while v > 1e-8 * column.impact_speed:
        v *= floor.restitution(v)
        rest += 2.0 * v / G
    result = hl.independent(column, until=2.0 * rest)
    assert result.outcome_code == COLLAPSE
    assert result.contacts.begin.values[-1] == pytest.approx(rest, rel=1e-9)
    assert result.positions[0] == 0.05 and result.velocities[0] == 0.0


@pytest.mark.parametrize("restitution", [0.05, 0.07])
def test_balls_that_collapse_in_flight_go_on_together(restitution):
    """Three equal balls with ε below 7 − 4√3 = 0.0718 collide infinitely often in a finite time."""
    law = law_of("linear", restitution)
    column = hl.Column.cradle([hl.Ball(0.01, mass=1.0)] * 3, [1.0, 0.0, -0.9], law, gaps=[0.1, 0.15])
    result = hl.independent(column)
    assert result.outcome_code == COLLAPSE
    assert result.velocities == pytest.approx([0.1 / 3.0] * 3, rel=1e-12)  # that of the centre of mass
    at = result.trajectory([result.t_end, 10.0, 1e4])
    assert np.diff(at.position.values, axis=1) == pytest.approx(np.full((3, 2), 0.02), abs=1e-12)
    assert (np.diff(at.velocity.values) == 0.0).all()


def test_of_simultaneous_collisions_the_upper_one_comes_first():
    """Three equal balls with ε = 1/2, by hand calculation; a slightly smaller upper gap gives the same."""
    balls, law = [hl.Ball(0.01, mass=1.0)] * 3, law_of("linear", 0.5)
    tie = hl.independent(hl.Column.cradle(balls, [1.0, 0.0, -1.0], law, gaps=[0.125, 0.125]))
    nearly = hl.independent(hl.Column.cradle(balls, [1.0, 0.0, -1.0], law, gaps=[0.125, 0.125 - 1e-9]))
    assert tie.contacts.pair.values.tolist() == nearly.contacts.pair.values.tolist() == [2, 1, 2]
    assert tie.velocities == pytest.approx([-0.3125, -0.046875, 0.359375], rel=1e-14)


@pytest.mark.parametrize("restitution", [0.08, 0.2])
def test_balls_above_the_threshold_part(restitution):
    law = law_of("linear", restitution)
    column = hl.Column.cradle([hl.Ball(0.01, mass=1.0)] * 3, [1.0, 0.0, -1.0], law, gaps=[0.1, 0.1])
    result = hl.independent(column)
    assert result.outcome == "ok"
    assert (np.diff(result.velocities) > 0.0).all()


def test_elastic_balls_do_not_collapse():
    """At μ = 1/3 the lower ball stops except for rounding; its residual motion is not a collapse."""
    result = hl.independent(two_balls(1.0 / 3.0, 1.0, 0.0), until=0.5)
    assert result.outcome == "ok"
    assert result.positions[0] == pytest.approx(0.1, abs=1e-14)


@pytest.mark.slow
def test_beyond_the_limit_of_collisions_nothing_is_known():
    """An elastic ball bounces forever: times beyond the computed ones are refused."""
    column = two_balls(0.1, 1.0, gap=1e-3, fall=1e-3)
    result = hl.independent(column, until=1e6)
    assert result.outcome_code == hl.OUTCOMES.index("unresolved")
    assert np.isnan(result.positions).all() and np.isnan(result.velocities).all()
    with pytest.raises(ValueError, match="where the solution ends"):
        result.trajectory([1e6])
    shown = result.trajectory()
    assert shown.time.values[-1] == result._core.t_last and np.isfinite(shown.to_array()).all()
    known = result.trajectory(np.linspace(0.0, result._core.t_last * (1.0 - 1e-9), 100))
    assert known.position.values[:, 0].min() >= 0.1 - 1e-9


@pytest.mark.slow
def test_three_hundred_collapsing_balls_need_little_memory():
    """Only some states are stored; the others are recomputed."""
    code = """if True:
        import resource, hardlimit as hl
        column = hl.Column([hl.Ball(0.01, density=1000.0)] * 300, 1e-3, 0.5,
                           hl.LinearDashpot(stiffness=1e7, restitution=0.5))
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        result = hl.independent(column, until=0.1)
        after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        print(result._core.steps, (after - before) / 1024)
    """
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    collisions, megabytes = done.stdout.split()
    assert int(collisions) > 30_000
    assert float(megabytes) < 60.0


@draws(40)
@given(columns(law=st.floats(0.3, 0.95).map(lambda e: law_of("linear", e)), most=4), st.randoms())
def test_states_are_the_same_in_any_order(column, random):
    result = hl.independent(column, until=0.5)
    times = np.linspace(result._core.t_first, 0.5, 60)
    order = list(range(len(times)))
    random.shuffle(order)
    ascending, shuffled = result.trajectory(times), result.trajectory(times[order])
    assert (ascending.position.values[order] == shuffled.position.values).all()
    assert (ascending.velocity.values[order] == shuffled.velocity.values).all()


@st.composite
def piles(draw) -> hl.Column:
    """Columns that collapse: zero gaps and speeds, release from the floor, any restitution."""
    n = draw(st.integers(2, 4))
    balls = [hl.Ball(draw(st.sampled_from([0.01, 0.02, 0.03])), density=2000.0) for _ in range(n)]
    gaps = [draw(st.sampled_from([0.0, 1e-6, 1e-3, 0.05])) for _ in range(n - 1)]
    velocities = [draw(st.sampled_from([-1.0, 0.0, 0.0, 0.5, 1.0])) for _ in range(n)]
    height = balls[0].radius + draw(st.sampled_from([0.0, 1e-3, 0.1]))
    gravity = draw(st.sampled_from([9.81, 9.81, 0.0]))
    if height == balls[0].radius or gravity == 0.0:
        velocities[0] = -0.5
    law = law_of("linear", draw(st.one_of(st.floats(0.1, 0.9), st.sampled_from([1.0, 0.01, 0.5]))))
    return hl.Column(balls, gaps, height, law, velocities=velocities, gravity=gravity)


@draws(150)
@given(piles(), st.sampled_from([0.02, 0.5, 3.0]))
def test_no_ball_is_ever_inside_another_and_energy_never_rises(column, until):
    result = hl.independent(column, until=until)
    first, last = result._core.t_first, min(until, result._core.t_last)
    times = np.unique(np.concatenate([np.linspace(first, last, 300), result.contacts.begin.values[:300]]))
    t = result.trajectory(times[times <= last])
    radii = np.array([b.radius for b in column.balls])
    position = t.position.values
    assert np.isfinite(position).all()
    assert position[:, 0].min() >= radii[0] - 1e-12
    assert (np.diff(position, axis=1) - (radii[1:] + radii[:-1])).min() >= -1e-9
    energy = (t.kinetic_energy + t.potential_energy).values
    assert np.diff(energy).max() <= 1e-12 * max(1e-3, np.abs(energy).max())
    if result.outcome_code == COLLAPSE:  # whatever happens later
        late = result.trajectory([last, 2.0 * last, 10.0])
        assert late.position.values[:, 0].min() >= radii[0] - 1e-12


def one_ball(restitution: float, fall: float, velocity: float = 0.0, gravity: float = G):
    contact = law_of("linear", restitution).between(hl.Ball(0.02, mass=0.1))
    return _core.make_column(True, gravity, [0.1], [0.02], [contact.core], [fall], [velocity])


def test_one_ball():
    """The sequence of a single ball is its first collision with the floor; later it bounces until it rests."""
    v = math.sqrt(2.0 * G * 0.3)
    once = _core.independent(one_ball(0.8, 0.3), math.nan)
    assert _core.outcome_names[once.outcome] == "ok"
    assert once.n_contacts == 0 and once.t_end == once.t_floor_end == 0.0
    assert once.contacts()[0].tolist() == [0]
    assert once.sample(np.array([0.0]))[1][0, 0] == pytest.approx(0.8 * v, rel=1e-14)
    rest = 2.0 * 0.8 * v / (G * 0.2)
    result = _core.independent(one_ball(0.8, 0.3), 10.0)
    assert _core.outcome_names[result.outcome] == "collapse"
    assert result.contacts()[1][-1] == pytest.approx(rest, rel=1e-7)
    position, velocity, *_ = result.sample(np.array([1.001 * rest, 10.0]))
    assert (position == 0.02).all() and (velocity == 0.0).all()
    gone = _core.independent(one_ball(0.8, 0.3, -1.0, 0.0), math.nan)
    assert _core.outcome_names[gone.outcome] == "ok" and gone.t_end == 0.0


@draws(30)
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
    # The last of ever slower collisions joins a ball to balls at rest on the floor, which takes up its momentum.
    slow = np.where(t.velocity.values[1:, 0] == 0.0, 1e-7, 1e-12)
    assert (np.abs(np.diff(momentum)) < slow * scale)[kept].all()
