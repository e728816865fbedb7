"""Optimal stacks: closed forms of collisions, grids under Newton's equations, optimality conditions."""

import math

import numpy as np
import pytest

import hardlimit as hl
from command_line import printed, refused, run
from conftest import refusal, slow
from hardlimit import plots
from legible import assert_legible

ELASTIC = hl.LinearDashpot(stiffness=1e7, restitution=1.0)


def top_speed(masses: list[float], law: object, gaps: float = 0.0, model: object = hl.newton) -> float:
    """Top speed of a column, independent of the search."""
    balls = [hl.Ball(0.01, mass=m) for m in masses]
    column = hl.Column(balls, gaps, 0.01, law, velocities=-1.0, gravity=0.0)
    return float(model(column).final_velocities[-1])


@pytest.mark.parametrize("seed", range(6))
def test_the_best_masses_for_collisions_are_a_geometric_progression(seed: int) -> None:
    """The top speed is that of the closed form, and no other masses between the same ends are better."""
    rng = np.random.default_rng(seed)
    n, e, ratio = int(rng.integers(2, 21)), rng.uniform(0.7, 1.0), rng.uniform(0.05, 0.6)
    law = hl.LinearDashpot(stiffness=1e7, restitution=e)
    top = 2.0 * ratio ** (n - 1)
    best = hl.stack(n, law, bottom_mass=2.0, top_mass=top, model="independent")
    np.testing.assert_allclose(best.masses, np.geomspace(2.0, top, n), rtol=1e-12)
    assert best.speed == pytest.approx((1 + e) ** n / (1 + ratio) ** (n - 1) - 1, rel=1e-11)
    for _ in range(5):
        inner = np.exp(rng.normal(0.0, 0.1, n - 2)) * best.masses[1:-1]
        masses = [2.0, *inner, top]
        assert top_speed(masses, law, model=hl.independent) <= best.speed * (1 + 1e-12)


def test_the_lightest_balls_are_best_for_collisions() -> None:
    best = hl.stack(3, ELASTIC, bottom_mass=1.0, model="independent", ratio_limits=(0.02, 1.0))
    np.testing.assert_allclose(best.ratios, 0.02)


def test_collisions_with_a_restitution_that_depends_on_speed_are_searched() -> None:
    law = hl.Viscoelastic(youngs_modulus=1e9, poisson_ratio=0.3, restitution=0.6, impact_speed=1.0)
    best = hl.stack(3, law, bottom_mass=1.0, top_mass=0.01, model="independent")
    column = best.column
    for middle in np.geomspace(0.011, 0.99, 60):
        radius = (0.75 * middle / (math.pi * 1000.0)) ** (1 / 3)
        balls = [column.balls[0], hl.Ball(radius, mass=middle), column.balls[2]]
        assert hl.independent(column.replace(balls=balls)).final_velocities[-1] <= best.speed + 1e-9
    assert abs(best.masses[1] - 0.1) > 1e-3  # not the geometric mean


@pytest.mark.parametrize("stiffness_ratio", [0.2, 1.0, 5.0])
def test_two_balls_against_a_grid(stiffness_ratio: float) -> None:
    laws = [ELASTIC, ELASTIC.replace(stiffness=1e7 * stiffness_ratio)]
    best = hl.stack(2, laws, bottom_mass=1.0)
    grid = np.geomspace(1e-3, 1.0, 1500)
    speeds = [top_speed([1.0, m], laws) for m in grid]
    assert best.speed >= max(speeds) - 1e-9
    assert best.speed < max(speeds) + 1e-4
    assert best.masses[1] == pytest.approx(grid[np.argmax(speeds)], rel=0.02)


def test_three_balls_against_a_grid() -> None:
    best = hl.stack(3, ELASTIC, bottom_mass=1.0, top_mass=0.01)
    grid = np.geomspace(0.0101, 0.999, 400)
    speeds = [top_speed([1.0, m, 0.01], ELASTIC) for m in grid]
    assert max(speeds) - 1e-9 <= best.speed < max(speeds) + 1e-3
    collisions = hl.stack(3, ELASTIC, bottom_mass=1.0, top_mass=0.01, model="independent")
    assert best.speed > collisions.speed_under("newton") + 0.2
    assert best.speed_under("independent") < collisions.speed


@pytest.mark.slow
def test_three_free_balls_against_a_grid() -> None:
    law = hl.LinearDashpot(stiffness=1e7, restitution=0.9)
    for gaps in (0.0, 1e-4):
        best = hl.stack(3, law, bottom_mass=1.0, gaps=gaps)
        grid = np.geomspace(1e-3, 1.0, 60)
        speeds = [top_speed([1.0, a, a * b], law, gaps) for a in grid for b in grid]
        assert max(speeds) - 1e-9 <= best.speed < max(speeds) + 0.05


@pytest.mark.parametrize("n", [4, slow(6)])
@pytest.mark.parametrize("top", [None, 0.01])
def test_optimality_conditions(n: int, top: float | None) -> None:
    """Slopes of the top speed over x_k = ln(m_{k+1}/m_k) are equal (0 without a given top mass) where x_k is between
    its limits, at least as large at the upper limit, at most as large at the lower one (Karush, Kuhn & Tucker)."""
    law, (low, high) = hl.LinearDashpot(stiffness=1e7, restitution=0.9), np.log([1e-2, 1.0])
    best = hl.stack(n, law, bottom_mass=1.0, top_mass=top, ratio_limits=(1e-2, 1.0))

    def speed(x: np.ndarray) -> float:
        return top_speed(list(np.exp(np.concatenate([[0.0], np.cumsum(x)]))), law)

    x, step = np.log(best.ratios), 1e-5 * np.eye(n - 1)
    slope = np.array([(speed(x + e) - speed(x - e)) / 2e-5 for e in step])
    at_high, at_low = x > high - 1e-6, x < low + 1e-6
    free = ~(at_high | at_low)
    level = 0.0 if top is None else slope[free].mean()
    np.testing.assert_allclose(slope[free], level, atol=2e-3)
    assert np.all(slope[at_high] >= level - 2e-3) and np.all(slope[at_low] <= level + 2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_no_neighbour_is_better(seed: int) -> None:
    """Random laws, gaps and ends: no small change of the masses makes the top ball faster."""
    rng = np.random.default_rng(seed)
    n = 3 if seed % 2 else 4
    law = [
        hl.LinearDashpot(stiffness=1e7, restitution=rng.uniform(0.7, 1.0)),
        hl.Tsuji(elastic_prefactor=1e10, restitution=rng.uniform(0.7, 1.0)),
    ][seed % 2]
    gap = float(rng.choice([0.0, 1e-5, 1e-4]))
    best = hl.stack(n, law, bottom_mass=1.0, top_mass=float(rng.uniform(0.003, 0.1)), gaps=gap)
    for size in (1e-4, 1e-2):
        for _ in range(30):
            factors = np.exp(rng.normal(0.0, size, n - 2))
            masses = [best.masses[0], *(best.masses[1:-1] * factors), best.masses[-1]]
            if np.max(np.array(masses[1:]) / masses[:-1]) > 1.0:
                continue
            balls = [
                hl.Ball(b.radius * (m / b.mass) ** (1 / 3), mass=m)
                for b, m in zip(best.column.balls, masses, strict=True)
            ]
            column = best.column.replace(balls=balls, height=balls[0].radius)
            assert hl.newton(column).final_velocities[-1] <= best.speed + 1e-5


@pytest.mark.slow
def test_many_balls() -> None:
    """No exchange between two mass ratios, within the limits, makes the top ball faster. Exchanges with the ratio that
    is farthest from its limit suffice: the speed then grows equally with all ratios that may be larger."""
    n = 12
    best = hl.stack(n, ELASTIC, bottom_mass=1.0, top_mass=0.01)
    collisions = hl.stack(n, ELASTIC, bottom_mass=1.0, top_mass=0.01, model="independent")
    assert best.masses.size == n and best.speed > collisions.speed_under("newton") + 0.2
    inner = int(np.argmin(best.ratios))
    for other in set(range(n - 1)) - {inner}:
        for change in (0.01, -0.01):
            steps = np.log(best.ratios)
            steps[[inner, other]] += change, -change
            if np.max(steps) > 1e-12:
                continue
            masses = np.exp(np.concatenate([[0.0], np.cumsum(steps)]))
            assert top_speed(list(masses), ELASTIC) <= best.speed + 1e-6


def test_twenty_balls_of_collisions_under_newton() -> None:
    best = hl.stack(20, ELASTIC, bottom_mass=1.0, top_mass=0.01, model="independent")
    assert 3.0 < best.speed_under("newton") < 0.25 * best.speed


def test_wide_gaps_make_both_models_one() -> None:
    best = hl.stack(3, ELASTIC, bottom_mass=1.0, top_mass=0.01, model="independent")
    over = best.over_gaps(np.array([0.0, 20.0]) * best.contact_way)
    assert over.newton[1] == pytest.approx(float(over.independent[1]), rel=1e-9)
    assert float(over.newton[0]) < 0.3 * float(over.independent[0])


@pytest.mark.parametrize("n", [slow(8), 12, 20])
def test_a_push_that_is_slower_than_the_lowest_ball_arrives(n: int) -> None:
    """With wide gaps the lowest ball returns to the floor long before the top one is hit."""
    best = hl.stack(n, ELASTIC, bottom_mass=1.0, top_mass=0.01, model="independent")
    expected = 2.0**n / (1.0 + 0.01 ** (1.0 / (n - 1))) ** (n - 1) - 1.0
    for gap in (1.0, 3.0, 10.0):
        for model in ("newton", "independent"):
            assert best.speed_under(model, gap * best.contact_way) == pytest.approx(expected, rel=1e-9)
    # Each ball of the best masses is touched by one neighbour at a time: they are those of collisions.
    if n == 8:
        wide = hl.stack(n, ELASTIC, bottom_mass=1.0, top_mass=0.01, gaps=3.0 * best.contact_way)
        assert wide.speed == pytest.approx(expected, rel=1e-9)
        np.testing.assert_allclose(wide.masses, best.masses, rtol=1e-3)


def test_only_ratios_of_stiffnesses_masses_and_no_speed_matter_where_balls_touch() -> None:
    first = hl.stack(2, ELASTIC, bottom_mass=1.0)
    other = hl.stack(2, ELASTIC.replace(stiffness=3e4), bottom_mass=0.02, impact_speed=7.0, density=300.0)
    assert other.speed == pytest.approx(first.speed, rel=1e-6)
    assert other.ratios[0] == pytest.approx(first.ratios[0], rel=1e-3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"n": 1}, "n: got 1, must be a whole number in [2, 20]"),
        ({"n": 21}, "n: got 21, must be"),
        ({"bottom_mass": 0.0}, "bottom_mass: got 0, must be > 0"),
        ({"top_mass": 2.0}, "top_mass: got 2, must be in [1e-06, 1]"),
        ({"top_mass": 1e-7}, "top_mass: got 1e-07, must be in"),
        ({"ratio_limits": (0.5, 0.1)}, "ratio_limits: got 0.5 and 0.1, must be a smaller and a larger"),
        ({"ratio_limits": 0.1}, "ratio_limits: got 0.1 and 0.1"),
        ({"model": "adiabatic"}, "model: got 'adiabatic', must be one of newton, independent"),
        ({"gaps": -1.0}, "gaps: got -1"),
        ({"law": 3}, "law: got 3, must be a contact law"),
        ({"law": [ELASTIC]}, "law: got 1 laws, must be one or 3"),
        ({"density": 0.0}, "density: got 0"),
        ({"impact_speed": math.inf}, "impact_speed: got inf"),
    ],
)
def test_bad_input_is_refused(arguments: dict, message: str) -> None:
    changed = {"n": 3, "law": ELASTIC, "bottom_mass": 1.0} | arguments
    assert refusal(lambda: hl.stack(changed.pop("n"), changed.pop("law"), **changed)).startswith(message)


@pytest.mark.slow
def test_the_command_and_its_picture() -> None:
    words = ["stack", "--balls", 3, "--top-mass", "10g", "--stiffness", 1e7, "--restitution", 1]
    output = printed(*words)
    direct = hl.stack(3, ELASTIC, bottom_mass=1.0, top_mass=0.01)
    np.testing.assert_allclose(output["best_under_newton"]["masses"], direct.masses, rtol=1e-12)
    text = run(*words).stdout
    assert "1.34087" in text and "5.61157" in text
    assert_legible(plots.stack(direct))
    assert "--balls: got 30" in refused("stack", "--balls", 30)


@pytest.mark.parametrize(
    ("n", "top", "gap", "model", "fastest"),  # of a grid, or of a random search with four balls
    [
        (3, 1.0, 1e-3, "newton", 1.40076),
        (3, 0.9, 1e-3, "newton", 1.4108),
        (3, 1.0, 0.0, "newton", 1.3423),
        (4, 1.0, 1e-3, "newton", 1.989),
        (3, 0.5, 1e-3, "independent", 2.5650),
        (3, 1.0, 1e-4, "independent", 2.648),
    ],
)
def test_balls_that_may_be_heavier_than_those_below(
    n: int, top: float, gap: float, model: str, fastest: float
) -> None:
    """Their masses need not fall, and a ball may be hit several times."""
    law = hl.LinearDashpot(stiffness=1e6, restitution=1.0)
    best = hl.stack(n, law, bottom_mass=1.0, top_mass=top, ratio_limits=(0.1, 10.0), gaps=gap, model=model)
    assert best.speed > fastest * (1.0 - 1e-4)
