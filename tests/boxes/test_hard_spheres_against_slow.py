"""The hard-sphere engine against a simple slow one, event by event, for random small systems."""

import itertools
import math

import numpy as np
import pytest

import hardlimit as hl
from box_engines import hard_spheres, logged
from conftest import law_of
from hardlimit import _core
from hardlimit.boxes.contacts import law_arguments
from slow_hard_spheres import Rule, SlowHardSpheres

SPEED = 0.3  # rms of one component [m/s]
ROWS_PER_PARTICLE = 6
#: Displacement of the twin of a system, relative to the smallest radius: several thousand times the rounding error, and
#: more than the effect on the next collision of a relative error of 1e-10 in the speeds of a soft contact.
DISPLACED = {"constant": 1e-12, "tc": 1e-12, "law": 1e-12, "soft": 1e-8}


def placed(
    rng: np.random.Generator, radius: np.ndarray, box: np.ndarray, periodic: np.ndarray
) -> np.ndarray | None:
    """Positions without overlap, by random sequential insertion; None if there is no space left."""
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
    if name == "law":
        return Rule(name, law=law_of(str(rng.choice(sorted(hl.LAWS))), restitution, speed))
    return Rule(name, law=soft_law(rng, restitution, speed, radius))


def soft_law(rng: np.random.Generator, restitution: float, speed: float, radius: float) -> hl.Law:
    """A law whose impacts reach compressions of 1e-4 to 1e-2 radii."""
    depth, mass = 10.0 ** rng.uniform(-4.0, -2.0) * radius, 1e-5
    prefactor = 1.25 * mass * speed**2 / depth**2.5
    modulus = 1.365 * prefactor / math.sqrt(0.5 * radius)
    return [
        hl.LinearDashpot(stiffness=mass * speed**2 / depth**2, restitution=restitution),
        hl.Tsuji(elastic_prefactor=prefactor, restitution=restitution),
        hl.Viscoelastic(
            youngs_modulus=modulus, poisson_ratio=0.3, restitution=restitution, impact_speed=speed
        ),
    ][rng.integers(3)]


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
    velocity = SPEED * rng.standard_normal((n, dimension))
    gravity = np.zeros(dimension)
    if rng.random() < 0.5:
        gravity = rng.choice([0.0, 1.0], dimension) * 9.81 * rng.standard_normal(dimension)
    boundary = tuple("periodic" if p else "wall" for p in periodic)
    chosen = random_rule(rng, rule, SPEED, 1e-3)
    return SlowHardSpheres(position, velocity, radius, mass, box, boundary, gravity, chosen)


def fast(system: SlowHardSpheres) -> _core.Engine:
    rule = system.rule
    law = rule.law
    return hard_spheres(
        system.position,
        system.velocity,
        radius=system.radius,
        mass=system.mass,
        box=system.box,
        periodic=[b == "periodic" for b in system.boundary],
        gravity=system.gravity,
        rule=rule.name,
        restitution=rule.restitution if law is None else math.nan,
        law=None if law is None else law_arguments(law),
        contact_duration=rule.contact_duration,
    )


def assert_same_events(seed: int, name: str) -> None:
    """Rounding errors grow with every collision. A twin, the slow engine with displaced positions, shows how fast.

    Events are compared while those of the twin agree, and must differ by less than the twin does.
    """
    system, twin = random_system(seed, name), random_system(seed, name)
    twin.position += (
        DISPLACED[name]
        * twin.radius.min()
        * np.cos(np.arange(twin.position.size)).reshape(twin.position.shape)
    )
    twin.look_again()
    engine = fast(system)
    rows, limit = ROWS_PER_PARTICLE * system.n, 20.0 * system.box.max() / SPEED
    for each in (system, twin, engine):
        each.advance(limit, rows)
    times, first, second, speeds, _ = logged(engine)
    expected, off = np.array(system.log).reshape(-1, 4), np.array(twin.log).reshape(-1, 4)
    n = min(len(expected), len(off))
    same = np.all(expected[:n, 1:3] == off[:n, 1:3], axis=1)
    near = np.abs(expected[:n, 0] - off[:n, 0]) < 1e-4 * system.radius.min() / SPEED
    n = n if np.all(same & near) else int(np.argmin(same & near))
    assert n >= min(system.n // 2, len(expected)), seed
    assert np.array_equal(np.stack([first, second], axis=1)[:n], expected[:n, 1:3]), seed
    # One collision may by chance differ little, so the largest difference so far is used.
    allowed = np.maximum.accumulate(np.abs(expected[:n] - off[:n]), axis=0)
    assert np.all(np.abs(times[:n] - expected[:n, 0]) <= allowed[:, 0] + 1e-12 * limit), seed
    assert np.all(np.abs(speeds[:n] - expected[:n, 3]) <= allowed[:, 3] + 1e-10 * SPEED), seed
    if n == len(expected) == len(times):
        assert_same_state(engine, system, twin)


def assert_same_state(engine: _core.Engine, system: SlowHardSpheres, twin: SlowHardSpheres) -> None:
    position, velocity = engine.state()
    least = system.radius.min()
    assert engine.time == pytest.approx(system.time, abs=1e-4 * least / SPEED)
    off = (
        np.abs(twin.position - system.position).max()
        + np.abs(twin.velocity - system.velocity).max() * least / SPEED
    )
    assert np.abs(position - system.position).max() <= 10.0 * off + 1e-9 * least
    assert np.abs(velocity - system.velocity).max() <= 10.0 * off / least * SPEED + 1e-9 * SPEED


RULES = ["constant", "tc", "law", "soft"]


@pytest.mark.parametrize("rule", RULES)
def test_same_events(rule: str) -> None:
    for seed in range(3):
        assert_same_events(seed, rule)


def test_same_events_where_a_soft_contact_at_a_wall_ends_within_it() -> None:
    for seed in (1063, 1157):
        assert_same_events(seed, "soft")


@pytest.mark.slow
@pytest.mark.parametrize(("rule", "block"), list(itertools.product(RULES, range(2))))
def test_same_events_in_many_systems(rule: str, block: int) -> None:
    for seed in (*range(6 * block + 3, 6 * block + 9), *range(1000 + 30 * block, 1030 + 30 * block)):
        assert_same_events(seed, rule)
