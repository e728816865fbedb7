"""The fast event-driven engine against the slow, obvious one, event by event, on random small systems of every kind."""

import itertools
import math

import numpy as np
import pytest

import hardlimit as hl
from conftest import law_of
from hardlimit import _core
from slow_hard_spheres import Rule, SlowHardSpheres

#: Events that are compared. Rounding grows tenfold from one collision of a particle to its next, or faster.
ROWS_PER_PARTICLE = 3


def placed(
    rng: np.random.Generator, radius: np.ndarray, box: np.ndarray, periodic: np.ndarray
) -> np.ndarray | None:
    """Places without overlap, one after the other; None where no room is left."""
    places: list[np.ndarray] = []
    for i, r in enumerate(radius):
        for _ in range(2000):
            x = np.where(periodic, rng.random(len(box)) * box, r + rng.random(len(box)) * (box - 2.0 * r))
            if all(distance(x - y, box, periodic) > r + radius[j] for j, y in enumerate(places)):
                places.append(x)
                break
        if len(places) == i:
            return None
    return np.array(places)


def distance(r: np.ndarray, box: np.ndarray, periodic: np.ndarray) -> float:
    return float(np.linalg.norm(r - np.where(periodic, box * np.round(r / box), 0.0)))


def random_rule(rng: np.random.Generator, name: str, speed: float, radius: float) -> Rule:
    restitution = float(rng.choice([1.0, rng.uniform(0.6, 1.0)]))
    if name == "constant":
        return Rule(name, restitution)
    if name == "tc":
        return Rule(name, restitution, contact_duration=float(rng.uniform(0.0, 2.0)) * radius / speed)
    return Rule(name, law=law_of(str(rng.choice(sorted(hl.LAWS))), restitution, speed))


def random_system(seed: int, rule: str) -> SlowHardSpheres:
    rng = np.random.default_rng(seed)
    while True:
        dimension, n = int(rng.integers(2, 4)), int(rng.integers(2, 15))
        periodic = rng.random(dimension) < 0.6
        spread = float(rng.choice([1.0, rng.uniform(1.0, 4.0)]))
        radius = 1e-3 * rng.uniform(1.0, spread, n)
        volume = np.sum(radius**dimension) * (math.pi if dimension == 2 else 4.0 / 3.0 * math.pi)
        edge = (volume / rng.uniform(0.02, 0.25)) ** (1.0 / dimension)
        box = np.maximum(edge * rng.uniform(0.7, 1.4, dimension), 2.3 * radius.max())
        position = placed(rng, radius, box, periodic)
        if position is not None:
            break
    mass = 1e-5 * (radius / 1e-3) ** 3 * rng.uniform(1.0, float(rng.choice([1.0, 5.0])), n)
    speed = 0.3
    velocity = speed * rng.standard_normal((n, dimension))
    gravity = np.zeros(dimension)
    if rng.random() < 0.5:
        gravity = rng.choice([0.0, 1.0], dimension) * 9.81 * rng.standard_normal(dimension)
    boundary = tuple("periodic" if p else "wall" for p in periodic)
    chosen = random_rule(rng, rule, speed, 1e-3)
    return SlowHardSpheres(position, velocity, radius, mass, box, boundary, gravity, chosen)


def fast(system: SlowHardSpheres) -> _core.HardSpheres:
    rule = system.rule
    law = rule.law
    return _core.HardSpheres(
        system.position,
        system.velocity,
        system.radius,
        system.mass,
        system.box,
        [b == "periodic" for b in system.boundary],
        system.gravity,
        rule.name,
        rule.restitution if law is None else math.nan,
        None if law is None else (law.record["name"], law.alternative, list(law.parameters.values())),
        rule.contact_duration,
        True,
    )


def assert_same_events(seed: int, name: str) -> None:
    system = random_system(seed, name)
    engine = fast(system)
    rows = ROWS_PER_PARTICLE * system.n
    limit = 20.0 * system.box.max() / 0.3
    system.advance(limit, rows)
    engine.advance(limit, rows)
    times, first, second, speeds = engine.take_log()
    found, expected = list(zip(first, second, strict=True)), [row[1:3] for row in system.log]
    assert found == expected, seed
    assert len(found) > 0, seed
    np.testing.assert_allclose(times, [row[0] for row in system.log], rtol=1e-7, err_msg=str(seed))
    np.testing.assert_allclose(
        speeds, [row[3] for row in system.log], rtol=1e-5, atol=1e-8, err_msg=str(seed)
    )
    position, velocity = engine.state()
    np.testing.assert_allclose(position, system.position, atol=1e-5 * 1e-3, err_msg=str(seed))
    np.testing.assert_allclose(velocity, system.velocity, atol=1e-5, err_msg=str(seed))


RULES = ["constant", "tc", "law", "soft"]


@pytest.mark.parametrize("rule", RULES)
def test_same_events(rule: str) -> None:
    for seed in range(25):
        assert_same_events(seed, rule)


@pytest.mark.slow
@pytest.mark.parametrize(("rule", "block"), list(itertools.product(RULES, range(4))))
def test_same_events_in_many_systems(rule: str, block: int) -> None:
    for seed in range(1000 + 50 * block, 1050 + 50 * block):
        assert_same_events(seed, rule)
