"""Rebound heights: agreement with closed forms and trajectories, and cases without a rebound."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from numpy.typing import NDArray

import hardlimit as hl
from conftest import draws

G = 9.81
MODELS: dict[str, Callable[..., hl.Result]] = {
    "newton": hl.newton,
    "general": lambda column, until=None: hl.newton(column, until, method="general"),
    "adiabatic": hl.adiabatic,
    "independent": hl.independent,
}


def heights(result: hl.Result) -> NDArray[np.float64]:
    return np.array(result._core.rebound_heights())


def linear(restitution: float) -> hl.LinearDashpot:
    return hl.LinearDashpot(stiffness=1e6, restitution=restitution)


def soft(restitution: float) -> hl.Viscoelastic:
    return hl.Viscoelastic(youngs_modulus=1e8, poisson_ratio=0.3, restitution=restitution, impact_speed=3.0)


@draws(100)
@given(
    restitution=st.floats(0.3, 1.0),
    mass=st.floats(1e-9, 0.2),
    height=st.floats(0.1, 5.0),
    gap=st.floats(1e-9, 1e-2),
)
def test_two_instantaneous_collisions(restitution: float, mass: float, height: float, gap: float) -> None:
    """A floor collision, then a ball–ball collision at gap/approach speed; after it both balls fly freely."""
    balls = [hl.Ball(0.05, mass=1.0), hl.Ball(0.01, mass=mass)]
    column = hl.Column(balls, [gap], height + 0.05, linear(restitution))
    speed = math.sqrt(2.0 * G * height)
    meeting = gap / ((1.0 + restitution) * speed)
    met_at = 0.05 + meeting * (restitution * speed - 0.5 * G * meeting)
    lower, upper = restitution * speed - G * meeting, -speed - G * meeting
    impulse = (1.0 + restitution) * mass / (1.0 + mass) * (lower - upper)
    lower, upper = lower - impulse, upper + impulse / mass
    result = hl.independent(column)
    assume(result.n_contacts == 1)
    expected = [met_at + max(lower, 0.0) ** 2 / (2.0 * G), met_at + 0.06 + max(upper, 0.0) ** 2 / (2.0 * G)]
    assert heights(result) == pytest.approx(expected, rel=1e-11)


@pytest.mark.parametrize("model", MODELS)
def test_nine_times_the_height(model: str) -> None:
    """A light ball on a heavy one, elastic, in the limit of stiff balls and zero gap (Eq. 6)."""
    balls = [hl.Ball(0.1, mass=1.0), hl.Ball(0.01, mass=1e-9)]
    law = [
        hl.LinearDashpot(stiffness=1e12, restitution=1.0),
        hl.LinearDashpot(stiffness=1e9, restitution=1.0),
    ]
    column = hl.Column(balls, [1e-4], 0.6, law)
    highest = 9.0 * (column.initial_positions[1] - 1e-4) - 8.0 * 0.21
    assert heights(MODELS[model](column))[1] == pytest.approx(highest, rel=1e-3)


@st.composite
def columns(draw: st.DrawFn) -> hl.Column:
    n = draw(st.integers(2, 4))
    sizes = st.floats(0.01, 0.05)
    balls = [hl.Ball(draw(sizes), density=1000.0) for _ in range(n)]
    gaps = [draw(st.one_of(st.just(0.0), st.floats(1e-6, 0.3))) for _ in range(n - 1)]
    law = draw(st.sampled_from([linear, soft]))(draw(st.floats(0.2, 1.0)))
    return hl.Column(balls, gaps, balls[0].radius + draw(st.floats(0.05, 0.5)), law)


def model_of(column: hl.Column, model: str) -> Callable[..., hl.Result]:
    exact = len(column.balls) == 2 and isinstance(column.laws[0], hl.LinearDashpot)
    assume(model != "adiabatic" or exact)
    return MODELS[model]


def bounces(result: hl.Result) -> NDArray[np.float64]:
    """End of each ball's first contact with the ball or floor below; infinity if there is none."""
    n = len(result.column.balls)
    pair, _, end = result._core.contacts()
    first = [end[pair == j][:1] for j in range(n)]
    return np.array([max(e[0], 0.0) if e.size and not math.isnan(e[0]) else math.inf for e in first])


@draws(40)
@given(columns(), st.sampled_from(sorted(MODELS)))
def test_up_to_a_time_it_is_the_highest_point_of_the_trajectory(column: hl.Column, model: str) -> None:
    until = 2.5 * column.impact_speed / G
    result = model_of(column, model)(column, until=until)
    assume(result.outcome_code in (0, 1))
    times = np.linspace(0.0, until, 1001)
    position = result.trajectory(times).position.values
    for ball, (since, height) in enumerate(zip(bounces(result), heights(result), strict=True)):
        seen = position[times >= since, ball]
        if not seen.size:
            assert math.isnan(height) or since <= until
            continue
        # Between two samples a ball at 5 m/s and under 9.81 m/s² rises by at most this, except in a collision.
        assert seen.max() - 1e-12 <= height <= seen.max() + 6.0 * (times[1] - times[0])


@draws(40)
@given(columns(), st.sampled_from(sorted(MODELS)))
def test_two_balls_fly_to_the_top_from_the_end_of_the_sequence(column: hl.Column, model: str) -> None:
    assume(len(column.balls) == 2)
    solve = model_of(column, model)
    result = solve(column)
    assume(result.outcome_code == 0)
    z, v = result.positions[1], result.velocities[1]
    assume(v > 0.0)
    assert heights(result)[1] == pytest.approx(z + v * v / (2.0 * G), rel=1e-11)


@pytest.mark.parametrize("model", MODELS)
def test_the_lowest_ball_until_it_meets_the_floor_again(model: str) -> None:
    column = hl.Column.paper(restitution=0.7)
    pair, begin, _ = MODELS[model](column, until=1.0)._core.contacts()
    second = begin[(pair == 0) & (begin > 0.0)][0]
    result = MODELS[model](column)
    times = np.linspace(bounces(result)[0], second, 20001)
    seen = result.trajectory(times).position.values[:, 0].max()
    assert heights(result)[0] == pytest.approx(seen, rel=1e-8)


@pytest.mark.parametrize("model", ["newton", "independent"])
def test_collisions_of_the_upper_balls_after_the_second_floor_contact_count(model: str) -> None:
    """The lowest ball stops (mass ratio 1/3) and returns to the floor at once; the second ball hits the third later."""
    balls = [hl.Ball(0.01, mass=3.0), hl.Ball(0.01, mass=1.0), hl.Ball(0.01, mass=1e-6)]
    law = hl.LinearDashpot(stiffness=1e11, restitution=1.0)
    column = hl.Column(balls, [2e-4, 0.4], 0.51, law)
    result = MODELS[model](column)
    speed = math.sqrt(2.0 * G * 0.5)
    # The second ball leaves with 2V; the third, still falling with V, is reflected with 2·2V + V − 2gt.
    meeting = 0.4 / (3.0 * speed)
    z2 = 0.03 + meeting * (2.0 * speed - 0.5 * G * meeting)
    v2, v3 = 2.0 * speed - G * meeting, -speed - G * meeting
    top = z2 + 0.02 + (2.0 * v2 - v3) ** 2 / (2.0 * G)
    assert bounces(result)[2] == math.inf  # the sequence ends earlier
    rebounds = heights(result)
    assert rebounds[1] == pytest.approx(z2 + v2**2 / (2.0 * G), rel=1e-3)
    assert rebounds[2] == pytest.approx(top, rel=1e-3)


@pytest.mark.parametrize("model", ["newton", "adiabatic", "general"])
def test_a_column_at_rest_has_its_resting_heights(model: str) -> None:
    column = hl.Column.paper(restitution=1e-3)
    lower, upper = (b.mass * G for b in column.balls)
    z1 = 0.1 - (lower + (0.0 if model == "adiabatic" else upper)) / 5e7
    result = MODELS[model](column)
    assert result.outcome.startswith("at rest")
    assert heights(result) == pytest.approx([z1, z1 + 0.11 - upper / 5e7], rel=1e-12)


def test_no_bounce_no_height() -> None:
    cradle = hl.Column.cradle([hl.Ball(0.02, mass=0.1)] * 3, [1.0, 0.0, 0.0], linear(0.9))
    assert np.isnan(heights(hl.newton(cradle))).all()
    assert np.isnan(heights(hl.independent(cradle))).all()
    # The upper ball is far away when the lower one returns to the floor.
    far = hl.Column([hl.Ball(0.02, mass=0.1)] * 2, [5.0], 0.1, linear(0.5))
    for model in MODELS.values():
        lower, upper = heights(model(far))
        assert lower == pytest.approx(0.02 + 0.25 * 0.08, rel=1e-2)
        assert math.isnan(upper)
    early = heights(hl.newton(far, until=-0.01))
    assert np.isnan(early).all()


@draws(100)
@given(
    masses=st.lists(st.floats(1e-3, 1.0), min_size=3, max_size=5),
    gaps=st.lists(st.floats(0.0, 0.1), min_size=4, max_size=4),
    restitution=st.floats(0.3, 1.0),
)
@example(masses=[1e-3, 0.1, 0.1], gaps=[0.0, 0.05, 0.0, 0.0], restitution=0.7)
def test_no_ball_bounces_below_the_floor(masses: list[float], gaps: list[float], restitution: float) -> None:
    """Heavy balls whose first collision occurs long after the light ball below them has returned to the floor."""
    balls = [hl.Ball(0.1, mass=mass) for mass in masses]
    column = hl.Column(balls, gaps[: len(balls) - 1], 0.7, linear(restitution))
    for solve in (hl.newton, hl.independent):
        z = heights(solve(column))[1:]
        assert np.all(np.isnan(z) | (z >= 0.1))
