"""Oblique soft impact: the contact force, integrated in the plane by SciPy, rotates the contact normal as predicted."""

import csv
import math
from itertools import pairwise

import numpy as np
import pytest
import scipy
from hypothesis import example, given
from hypothesis import strategies as st

import hardlimit as hl
from conftest import DATA, draws, log_floats, refusal
from hardlimit import oblique

PATH = DATA / "oblique_rotation.csv"
ROWS = list(csv.DictReader(PATH.read_text(encoding="utf-8").splitlines()))


def contact_of(law: str, duration: float) -> hl.Contact:
    """Two spheres of diameter 1 and reduced mass 1 whose elastic head-on impact at speed 1 lasts ``duration``."""
    ball = hl.Ball(0.5, mass=2.0)
    if law == "linear":
        return hl.LinearDashpot(stiffness=(np.pi / duration) ** 2, restitution=1.0).between(ball, ball)
    poisson = 0.3
    prefactor = (3.218065459719 / duration) ** 2.5  # t_c = 3.218… k^(−2/5) v^(−1/5)
    modulus = prefactor * 3.0 * (1.0 - poisson**2) / (2.0 * np.sqrt(0.25))
    elastic = hl.Viscoelastic(youngs_modulus=modulus, poisson_ratio=poisson, dissipative_time=0.0)
    return elastic.between(ball, ball)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: "-".join(list(row.values())[:3]))
def test_normal_turns(row: dict[str, str]) -> None:
    law, duration, angle, rotation, length = row.values()
    duration, angle = float(duration), np.radians(float(angle))
    contact = contact_of(law, duration)
    np.testing.assert_allclose(contact.duration(1.0), duration, rtol=1e-11)

    def motion(t: float, y: np.ndarray) -> list[float]:
        distance = np.hypot(y[0], y[1])
        push = contact.force(1.0 - distance) / contact.effective_mass / distance
        return [y[2], y[3], push * y[0], push * y[1]]

    def apart(t: float, y: np.ndarray) -> float:
        return np.hypot(y[0], y[1]) - 1.0

    apart.terminal, apart.direction = True, 1.0
    start = [1.0, 0.0, -np.cos(angle), np.sin(angle)]
    within = {"rtol": 1e-12, "atol": 1e-15, "max_step": duration / 50}
    run = scipy.integrate.solve_ivp(motion, (0, 5 * duration), start, "DOP853", events=apart, **within)
    end = run.y_events[0][-1]
    np.testing.assert_allclose(np.degrees(np.arctan2(end[1], end[0])), float(rotation), rtol=1e-8)
    np.testing.assert_allclose(run.t_events[0][-1] / duration, float(length), rtol=1e-8)


# --- two balls dropped with an offset -----------------------------------------------------------------------


def columns(seed: int) -> hl.Column:
    """Random drops of two balls that separate."""
    rng = np.random.default_rng(seed)
    lower, upper = 0.1 * rng.uniform(0.3, 1.0), 0.1 * rng.uniform(0.1, 0.6)
    e = rng.uniform(0.8, 1.0)
    law = [
        hl.LinearDashpot(stiffness=5e7, restitution=e),
        hl.Viscoelastic(youngs_modulus=1e9, poisson_ratio=0.3, restitution=e, impact_speed=1.0),
        hl.Tsuji(elastic_prefactor=1e9, restitution=e),
    ][seed % 3]
    gap = float(rng.choice([0.0, 1e-4, 1e-3]))
    balls = [hl.Ball(lower, density=840.0), hl.Ball(upper, density=840.0)]
    return hl.Column(balls, gap, lower + rng.uniform(0.1, 0.8), law)


@pytest.mark.parametrize("seed", range(9))
def test_without_offset_it_is_the_column(seed: int) -> None:
    column = columns(seed)
    drop, straight = hl.oblique_drop(column, 0.0), hl.newton(column)
    scale = 1e-8 * column.impact_speed
    assert drop.sideways_velocity == 0.0 and drop.estimate == 0.0
    assert drop.separation_velocity == pytest.approx(straight.separation_velocity, abs=scale)


@example(1.0, 1e-4, 1.0)  # contacts after the separation, in another bounce
@example(0.8, 1e-3, 0.9)
@example(1.0, 1e-4, 0.5)  # the floor is met again before the balls separate
@example(0.3, 1e-5, 1.0)
@draws(300)
@given(log_floats(0.3, 10.0), log_floats(1e-6, 1e-2), st.floats(0.3, 1.0))
def test_without_offset_it_ends_as_the_column(ratio: float, gap: float, restitution: float) -> None:
    column = hl.Column.paper(radius_ratio=ratio, gap=gap, restitution=restitution)
    straight = hl.newton(column)
    if math.isnan(straight.separation_velocity):
        with pytest.raises(RuntimeError, match="before the lower one meets the floor again"):
            hl.oblique_drop(column, 0.0)
        return
    drop = hl.oblique_drop(column, 0.0)
    assert drop.n_contacts == straight.n_contacts
    assert drop.separation_velocity == pytest.approx(straight.separation_velocity, abs=1e-6)


def test_balls_of_equal_size_with_a_small_offset() -> None:
    """One contact turns them, as the estimate says; those of later bounces do not count."""
    drop = hl.oblique_drop(hl.Column.paper(radius_ratio=1.0, gap=1e-4, restitution=1.0), 1e-6)
    assert drop.sideways_velocity == pytest.approx(drop.estimate, rel=0.1)


def test_a_lower_ball_that_gravity_holds_on_the_floor_does_not_leave() -> None:
    """The force vanishes at an overlap and the gap grows, but both balls come to rest (``newton`` says so)."""
    law = hl.Tsuji(elastic_prefactor=2.2e8, restitution=0.08)
    balls = [hl.Ball(0.077, density=840.0), hl.Ball(0.05, density=350.0)]
    column = hl.Column(balls, 0.0, 0.0864, law)
    assert hl.newton(column).outcome.startswith("at rest")
    with pytest.raises(RuntimeError, match="do not separate"):
        hl.oblique_drop(column, 0.0)


@pytest.mark.parametrize("seed", range(6))
def test_offsets_are_mirrored_and_keep_momentum(seed: int) -> None:
    column = columns(seed)
    offset = 0.05 * column.balls[1].radius
    drop, other = hl.oblique_drop(column, offset), hl.oblique_drop(column, -offset)
    scale = column.impact_speed
    assert drop.sideways_velocity == pytest.approx(-other.sideways_velocity, abs=1e-9 * scale)
    assert drop.separation_velocity == pytest.approx(other.separation_velocity, abs=1e-9 * scale)
    masses = np.array([ball.mass for ball in column.balls])
    assert abs(masses @ drop.velocities[:, 0]) < 1e-9 * masses[0] * scale
    assert drop.run.energy_error < 1e-9
    assert drop.tilt == -other.tilt and drop.throw_angle > 0.0


def linear_response(column: hl.Column) -> float:
    """Sideways velocity per offset: x'' = F12(t) x/(μ s), with force and distance s of the drop without offset."""
    straight = hl.newton(column)
    lower, upper = column.balls
    reduced = lower.mass * upper.mass / (lower.mass + upper.mass)
    _, begin, end = straight.contact_times
    state, steps = np.array([1.0, 0.0]), 100
    for a, b in pairwise(np.unique(np.concatenate([[0.0], begin, end]))):
        margin = 1e-9 * (b - a)  # the force jumps at the ends
        at = straight.trajectory(np.clip(np.linspace(a, b, 2 * steps + 1), a + margin, b - margin))
        apart = (at.position.sel(ball=2) - at.position.sel(ball=1)).values
        rate, h = at.force.sel(pair=1).values / (reduced * apart), (b - a) / steps

        def change(y: np.ndarray, k: float) -> np.ndarray:
            return np.array([y[1], k * y[0]])

        for begin_rate, middle, end_rate in zip(rate[:-1:2], rate[1::2], rate[2::2], strict=True):
            k1 = change(state, begin_rate)
            k2 = change(state + 0.5 * h * k1, middle)
            k3 = change(state + 0.5 * h * k2, middle)
            state = state + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + change(state + h * k3, end_rate))
    return float(state[1]) * lower.mass / (lower.mass + upper.mass)


def test_small_offsets_follow_the_linear_response() -> None:
    """The sideways velocity is odd in the offset: its relative deviation from linearity falls with the square."""
    column = hl.Column.paper(restitution=0.9, gap=5e-4)
    response = linear_response(column)
    offsets = np.array([4e-3, 2e-3, 1e-3])
    errors = [abs(hl.oblique_drop(column, d).sideways_velocity / (d * response) - 1.0) for d in offsets]
    assert errors[-1] < 1e-4
    np.testing.assert_allclose(np.array(errors[:-1]) / errors[1:], 4.0, rtol=0.1)
    tiny = hl.oblique_drop(column, 1e-6)
    assert tiny.sideways_velocity == pytest.approx(1e-6 * response, rel=1e-6)
    assert tiny.estimate == pytest.approx(tiny.sideways_velocity, rel=0.05)


def test_collisions_far_apart_give_the_estimate_in_closed_form() -> None:
    """For a wide gap: (1 + ε)² V/(1 + m2/m1) along the line of centres, to second order in the tilt."""
    column = hl.Column.paper(restitution=0.9, gap=5e-3, stiffness=1e10, gravity=1e-9, height=0.11).replace(
        velocities=-3.0
    )
    drop = hl.oblique_drop(column, 1e-5)
    ratio = column.balls[1].mass / column.balls[0].mass
    closed = 1.9**2 * 3.0 / (1.0 + ratio) * drop.tilt
    assert drop.sideways_velocity == pytest.approx(closed, rel=1e-3)


TWO_LAWS = [hl.LinearDashpot(stiffness=k, restitution=0.9) for k in (1e6, 2e6)]


@pytest.mark.parametrize(
    ("column", "offset", "message"),
    [
        (3, 0.0, "column: got 3, must be a Column of two balls"),
        (hl.Column.paper(), 0.2, "offset: got 0.2, must be in [-0.1089, 0.1089]"),
        (hl.Column.paper(), np.nan, "offset: got nan"),
        (hl.Column.paper().replace(velocities=[-1.0, -2.0]), 0.0, "column: got two velocities"),
        (hl.Column.paper().replace(law=TWO_LAWS), 0.0, "column: got two laws"),
    ],
)
def test_bad_drops_are_refused(column: object, offset: float, message: str) -> None:
    assert refusal(lambda: hl.oblique_drop(column, offset)).startswith(message)


# --- with friction and spin ---------------------------------------------------------------------------------

ROUGH = hl.Friction(0.3, stiffness_ratio=0.8)


@pytest.mark.parametrize("seed", range(6))
def test_a_mirrored_drop_with_friction(seed: int) -> None:
    column, random = columns(seed), np.random.default_rng(seed)
    offset = random.uniform(0.02, 0.3) * column.balls[1].radius
    lower, upper = random.uniform(-30.0, 30.0, 2)
    drop = hl.oblique_drop(column, offset, friction=ROUGH, spins=(lower, upper))
    mirrored = hl.oblique_drop(column, -offset, friction=ROUGH, spins=(-lower, -upper))
    scale = column.impact_speed + max(abs(lower), abs(upper)) * column.balls[0].radius
    np.testing.assert_allclose(mirrored.velocities * [-1.0, 1.0], drop.velocities, atol=1e-7 * scale)
    radius = np.array([ball.radius for ball in column.balls])
    np.testing.assert_allclose(
        -mirrored.angular_velocities * radius, drop.angular_velocities * radius, atol=1e-7 * scale
    )


def test_without_friction_spins_do_not_matter() -> None:
    column = hl.Column.paper(gap=0.01)
    smooth, spinning = hl.oblique_drop(column, 1e-3), hl.oblique_drop(column, 1e-3, spins=(30.0, -20.0))
    assert (spinning.velocities == smooth.velocities).all()
    assert spinning.angular_velocities.tolist() == [30.0, -20.0]
    null = hl.oblique_drop(column, 1e-3, friction=hl.Friction(0.0))
    assert (null.velocities == smooth.velocities).all()


def test_a_spinning_ball_drives_sideways() -> None:
    """The upper ball slides throughout on the lower one: friction is μ times the normal impulse, so that both get the
    same momentum and the same spin momentum over the radius, and the floor is left before they meet."""
    column, mu = hl.Column.paper(gap=0.05), 0.01
    drop = hl.oblique_drop(column, 0.0, friction=hl.Friction(mu), spins=(0.0, 2000.0))
    lower, upper = column.balls
    normal = -upper.mass * (float(drop.straight.final_velocities[1]) + column.impact_speed)
    assert drop.velocities[1, 0] == pytest.approx(mu * normal / upper.mass, rel=0.02)
    assert drop.velocities[0, 0] == pytest.approx(-drop.velocities[1, 0] * upper.mass / lower.mass, rel=1e-9)
    inertia = [ball.inertia_factor * ball.mass * ball.radius for ball in column.balls]
    turned = (drop.angular_velocities - [0.0, 2000.0]) * inertia
    assert turned[0] == pytest.approx(turned[1], rel=1e-3)
    assert turned[1] == pytest.approx(drop.velocities[1, 0] * upper.mass, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_steps_converge_to_a_drop_with_friction(seed: int) -> None:
    column = columns(seed)
    offset, spins = 0.2 * column.balls[1].radius, (0.0, 20.0)
    drop = hl.oblique_drop(column, offset, friction=ROUGH, spins=spins)
    start = oblique._start(column, offset, np.array(spins))
    law = column.laws[0].replace(friction=ROUGH)
    errors = []
    for accepted in (1e-3, 1e-5):
        run = hl.molecular_dynamics(
            start, law=law, until=drop.run.time, engine="steps", restitution_error=accepted, samples=1
        )
        errors.append(np.abs(run.system.velocities - drop.velocities).max() / column.impact_speed)
    assert errors[1] < 1e-4 and errors[1] < 0.1 * errors[0]
