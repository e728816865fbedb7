"""The event-driven engine for Newton's equations: reference systems, columns, balances, saved states, clusters."""

import itertools
import math
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.integrate
from hypothesis import given
from hypothesis import strategies as st

import hardlimit as hl
from box_engines import (
    LAWS,
    REFERENCE,
    core_engine,
    linear_law,
    mean_free_time,
    reference_law,
    reference_system,
)
from conftest import draws, output_of, slow
from hardlimit import _core
from hardlimit.boxes.contacts import law_arguments
from hardlimit.boxes.falling_frame import engine_arguments

CASES = [(kind, k) for kind in ("newton", "dilute") for k in range(len(REFERENCE[kind]))]


def by_events(*system: hl.ParticleSystem, **options: Any) -> hl.ContactResult:
    return hl.molecular_dynamics(*system, **({"engine": "events"} | options))


def by_small_steps(system: hl.ParticleSystem, **options: Any) -> hl.ContactResult:
    """The same by small steps on one thread."""
    usual = {"engine": "steps", "log": True, "samples": 1, "threads": 1}
    return hl.molecular_dynamics(system, **(usual | options))


def rows(run: Any) -> list[tuple[Any, ...]]:
    """Contacts sorted by begin."""
    names = ("begin", "end", "first", "second")
    return list(zip(*(run.contacts[name].values.tolist() for name in names), strict=True))


def random_system(seed: int, *, n: int, phi: float, d: int, boundary: Any, mixed: bool) -> hl.ParticleSystem:
    radius = (0.6e-3, 1.4e-3) if mixed else 1e-3
    gravity = 9.81 if "wall" in boundary else 0.0
    return hl.ParticleSystem.random(
        n=n, packing_fraction=phi, radius=radius, density=2500.0, rms_speed=1.0, dimension=d, seed=seed,
        boundary=boundary, gravity=gravity,
    )  # fmt: skip


@pytest.mark.parametrize(("kind", "k"), CASES)
def test_reference_boxes(kind: str, k: int) -> None:
    """Every contact of the reference, and the state at its end."""
    case = REFERENCE[kind][k]
    run = by_events(reference_system(case), law=reference_law(case), until=case["until"], log=True, samples=7)
    assert run.outcome == "ok"
    wanted = sorted(map(tuple, case["contacts"]))
    contacts = rows(run)
    assert [row[2:] for row in contacts] == [row[2:] for row in wanted]
    scale = max(1e-9, 10.0 * case["tolerance"]) * case["until"]
    for row, other in zip(contacts, wanted, strict=True):
        assert row[0] == pytest.approx(other[0], abs=scale)
        if other[1] is None or not other[1] <= case["until"]:
            assert math.isnan(row[1])
        else:
            assert row[1] == pytest.approx(other[1], abs=scale)
    smallest, box = min(case["radius"]), np.array(case["box"])
    walls = np.array([side == "wall" for side in case["boundary"]])
    away = run.system.positions - np.array(case["end_positions"])
    away -= np.where(walls, 0.0, box * np.round(away / box))
    rms = math.sqrt(np.mean(np.sum(np.square(case["velocities"]), axis=1)))
    assert np.abs(away).max() < case["tolerance"] * smallest
    assert np.abs(run.system.velocities - case["end_velocities"]).max() < case["tolerance"] * rms
    assert run.energy_error < 1e-11


@pytest.mark.parametrize("law", LAWS, ids=repr)
@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_a_column_in_a_box_is_that_of_the_column_solver(law: hl.Law, count: int) -> None:
    """Balls above each other, without sideways motion: the contacts of ``hl.newton``."""
    balls = [hl.Ball(1e-3 * r, density=2500.0) for r in (1.0, 0.7, 0.8, 0.5)[:count]]
    gaps, height = [2e-5, 1e-4, 5e-5][: count - 1], 5e-3
    column = hl.Column(balls, gaps, height, law)
    wanted = hl.newton(column, until=0.03)
    at = [height]
    for k, gap in enumerate(gaps):
        at.append(at[-1] + balls[k].radius + gap + balls[k + 1].radius)
    system = hl.ParticleSystem(
        positions=[[0.05, y] for y in at], velocities=np.zeros((count, 2)), radius=[b.radius for b in balls],
        mass=[b.mass for b in balls], box=[0.1, 0.1], boundary="wall", gravity=9.81,
    )  # fmt: skip
    fall = math.sqrt(2.0 * (height - balls[0].radius) / 9.81)
    run = by_events(system, law=law, until=fall + 0.03, log=True, samples=3)
    assert run.outcome == "ok"
    contacts = [(-1 if j < 0 else i, begin - fall, end - fall) for begin, end, i, j in rows(run)]
    pairs = wanted.contacts.pair.values
    other = [
        (int(p) - 1, float(b), float(e))
        for p, b, e in zip(pairs, wanted.contacts.begin.values, wanted.contacts.end.values, strict=True)
    ]
    assert [row[0] for row in contacts] == [row[0] for row in other]
    for row, solved in zip(contacts, other, strict=True):
        assert row[1:] == pytest.approx(solved[1:], abs=1e-8 * 0.03, nan_ok=True)


def frequent(seed: int) -> tuple[hl.ParticleSystem, hl.Law, float, float]:
    """A random system, its law, the time between contacts of a body, and the contact duration: 0.01 to 0.3 of that
    time, limited so that fast impacts stay within the range of the law."""
    random = np.random.default_rng(seed)
    d, wall, mixed, linear = int(random.integers(2, 4)), *random.integers(2, size=3).astype(bool)
    system = hl.ParticleSystem.random(
        n=25, packing_fraction=random.uniform(0.05, 0.4), radius=(0.7e-3, 1.4e-3) if mixed else 1e-3,
        density=2500.0, rms_speed=1.0, dimension=d, seed=seed, boundary="wall" if wall else "periodic",
        gravity=9.81 if wall else 0.0,
    )  # fmt: skip
    radius, mass, wait = float(system.radius.mean()), float(system.mass.mean()), mean_free_time(system)
    duration, ball = wait * 10.0 ** random.uniform(-2.0, math.log10(0.3)), hl.Ball(radius, mass=mass)
    duration = min(duration, 0.25 * radius)  # at 1 m/s
    if linear:
        return system, linear_law(system, duration, random.uniform(0.6, 1.0)), wait, duration
    elastic = hl.Viscoelastic(youngs_modulus=1e7, poisson_ratio=0.3, dissipative_time=0.0)
    modulus = 1e7 * (elastic.between(ball, ball).duration(1.0) / duration) ** 2.5
    return system, elastic.replace(youngs_modulus=modulus, dissipative_time=0.05 * duration), wait, duration


def begins(run: Any) -> dict[tuple[int, int], list[float]]:
    """Begin times of the contacts of each pair."""
    times_of: dict[tuple[int, int], list[float]] = defaultdict(list)
    for begin, _, first, second in rows(run):
        times_of[first, second].append(begin)
    return times_of


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100))
def test_no_contact_is_missed(seed: int) -> None:
    """Small steps find the same contacts, however many overlap: a missed third body would have its contact late or
    never."""
    system, law, wait, duration = frequent(seed)
    exact = begins(by_events(system, law=law, until=1.5 * wait, log=True, samples=1))
    near = begins(by_small_steps(system, law=law, until=1.5 * wait, restitution_error=1e-5))
    assert {pair: len(times) for pair, times in exact.items()} == {pair: len(t) for pair, t in near.items()}
    # Errors grow with each contact.
    worst = max(
        (abs(a - b) for pair in exact for a, b in zip(exact[pair], near[pair], strict=True)), default=0.0
    )
    assert worst < 0.1 * duration


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS, ids=repr)
@pytest.mark.parametrize("boundary", ["periodic", "wall"])
def test_no_path_leaves_its_safety_radius(law: hl.Law, boundary: str) -> None:
    """The true path of a body in contact stays within its safety radius, which is not wasteful."""
    used = []
    for seed in range(6):
        system = random_system(seed, n=60, phi=0.35, d=2 + seed % 2, boundary=boundary, mixed=seed > 2)
        run = core_engine("newton_events", system, law)
        for k in range(1, 40):
            run.advance(4e-5 * k)
            used.append(run.largest_safety_use(29))
    assert 0.9 < max(used) <= 1.0


@pytest.mark.parametrize("law", LAWS, ids=repr)
@pytest.mark.parametrize("speed", [1e-20, 1e-60, 1e-90])
def test_safety_radii_of_impacts_below_rounding(law: hl.Law, speed: float) -> None:
    """Two spheres overlap by the rounding of their positions. Under Hertz' law so slow an impact lasts so long that the
    speed from this overlap moves them by metres meanwhile."""
    left = 1.0 / 3.0 - 0.09
    system = hl.ParticleSystem(
        [[left, 0.3, 0.3], [left + 0.02, 0.3, 0.3]], [[speed, 0.0, 0.0], [-speed, 0.0, 0.0]],
        radius=0.01, density=2500.0, box=1.0,
    )  # fmt: skip
    run = core_engine("newton_events", system, law)
    run.advance(1e-3)
    assert run.n_contacts == 1
    assert run.largest_safety_use(5) <= 1.0


@pytest.mark.slow
@pytest.mark.parametrize("phi", [0.1, 0.3, 0.5])
def test_energy_over_many_contacts(phi: float) -> None:
    """The energy balance holds over many contacts."""
    system = hl.ParticleSystem.random(
        n=1000, packing_fraction=phi, radius=1e-3, density=2500.0, rms_speed=1.0, seed=1
    )
    wait = mean_free_time(system)
    law = linear_law(system, 0.03 * wait, 0.99)
    run = by_events(system, law=law, until=300.0 * wait, samples=20)
    assert run.outcome == "ok" and run.n_contacts > 80_000
    assert run.energy_error < 1e-10


@pytest.mark.slow
def test_touch_times_of_the_kernels(tmp_path: Path) -> None:
    """Times of the kernels for a radius that is enlarged for a limited time, against distances at many times."""
    touches, in_space, later, wrong, unlike = output_of("boxes/touch_kernel.cpp", tmp_path).split()
    assert int(touches) > 50_000 and int(in_space) > 10_000 and int(later) > 5000
    assert float(wrong) < 1e-13 and int(unlike) == 0


@pytest.mark.slow
def test_the_queue_of_contact_ends(tmp_path: Path) -> None:
    """The queue agrees with a sorted set: equal and unequal durations, ties, disturbed contacts."""
    ended, simultaneous, disturbed, wrong = map(
        int, output_of("boxes/contact_end_queue.cpp", tmp_path).split()
    )
    assert ended > 100_000 and simultaneous > 10_000 and disturbed > 10_000
    assert wrong == 0


@pytest.mark.slow
def test_parts_of_the_engine_alone(tmp_path: Path) -> None:
    """Bodies that fly through the cells of a sheared box follow straight lines, and gain what the boundary works.
    Pairs split bodies into the parts that a slow search finds."""
    crossings, off, unbalanced, parts, wrong = output_of("boxes/newton_parts.cpp", tmp_path).split()
    assert int(crossings) > 500 and int(parts) > 1000
    assert float(off) < 1e-12 and float(unbalanced) < 1e-12
    assert int(wrong) == 0


@pytest.mark.slow
def test_parts_of_a_cluster(tmp_path: Path) -> None:
    """Its equations create neither momentum nor energy; no two components of its state share a place."""
    momentum, energy, components, misplaced, changed, gap = output_of(
        "boxes/cluster_parts.cpp", tmp_path
    ).split()
    assert float(momentum) < 1e-13 and float(energy) < 1e-13
    assert int(components) > 5000 and int(misplaced) == 0
    assert int(changed) == 0
    assert float(gap) < 1e-12


@pytest.mark.slow
def test_distance_from_a_triangle(tmp_path: Path) -> None:
    """The distance of a triangle from the origin is that of the nearest of many of its points."""
    compared, nearer, farther = output_of("boxes/triangle.cpp", tmp_path).split()
    assert int(compared) == 2000
    assert float(nearer) < 1e-12 and float(farther) < 0.01


@pytest.mark.parametrize("seed", [*range(6), *map(slow, range(6, 60))])
def test_no_wall_is_missed(seed: int) -> None:
    """Bodies in slow contact that fly or fall together meet a wall that is far compared with their relative motion."""
    rng = np.random.default_rng(seed)
    dimension, count, radius = 2 + seed % 2, int(rng.integers(2, 5)), 1e-3
    law, axis, high = LAWS[seed % len(LAWS)], int(rng.integers(dimension)), bool(rng.integers(2))
    slow, ball = 10.0 ** rng.uniform(-3.0, 0.0), hl.Ball(radius, density=2500.0)
    duration = float(law.between(ball, ball).duration(slow))
    gap = rng.uniform(0.05, 2.0) * radius
    fast = gap / duration * 10.0 ** rng.uniform(-0.5, 0.5)
    while (
        float(law.between(ball).compression(fast)) > 0.25 * radius
    ):  # within the range of the law, with two balls behind
        gap, fast = 0.8 * gap, 0.8 * fast
    gravity = np.zeros(dimension)
    if seed % 3 == 0:
        fast, gravity[axis] = 0.0, fast / duration
    row = (axis + 1) % dimension
    positions = rng.uniform(-0.1, 0.1, (count, dimension)) * radius + 0.05
    positions[:, row] = 0.05 + radius * (2.003 * np.arange(count) + rng.uniform(-1e-3, 1e-3, count))
    velocities = rng.uniform(-slow, slow, (count, dimension))
    velocities[:, row] += np.linspace(3.0 * slow, -3.0 * slow, count)
    positions[:, axis] += radius + gap - np.min(positions[:, axis])
    velocities[:, axis] -= fast
    edge = 0.1
    if high:
        positions[:, axis], velocities[:, axis] = edge - positions[:, axis], -velocities[:, axis]
    system = hl.ParticleSystem(
        positions=positions, velocities=velocities, radius=radius, density=2500.0, box=np.full(dimension, edge),
        boundary="wall", gravity=gravity if high else -gravity,
    )  # fmt: skip
    until = 3e-3 * radius / slow + 2.0 * duration
    run = by_events(system, law=law, until=until, log=True, samples=1)
    near = by_small_steps(system, law=law, until=until, restitution_error=1e-6)
    assert run.outcome == "ok" and run.energy_error < 1e-9
    times_of, expected = begins(run), begins(near)
    assert {pair: len(times) for pair, times in times_of.items()} == {p: len(t) for p, t in expected.items()}
    for pair, times in expected.items():
        assert times_of[pair] == pytest.approx(times, abs=1e-2 * duration)


@pytest.mark.parametrize(
    "law",
    [
        hl.LinearDashpot(stiffness=5e5, restitution=0.8),
        slow(hl.Viscoelastic(youngs_modulus=1e10, poisson_ratio=0.3, dissipative_time=1e-7)),
    ],
    ids=repr,
)
@pytest.mark.parametrize(("axis", "high"), [(0, True), slow(1, False)])
def test_a_wall_beside_a_contact(law: hl.Law, axis: int, high: bool) -> None:
    """A ball pushed towards a wall touches it during or after the contact; small steps find the same. Only in the first
    case both contacts form a cluster."""
    radius, speed, edge = 1e-3, 1.0, 0.1
    ball = hl.Ball(radius, density=2500.0)
    duration = float(law.between(ball, ball).duration(speed))
    clustered = []
    for gap in (0.01, 0.1, 0.3, 0.9, 3.0):  # in units of the pair's motion during the contact
        positions, velocities = np.full((2, 2), 0.5 * edge), np.zeros((2, 2))
        positions[:, axis] = radius + gap * 0.5 * speed * duration
        positions[1, axis] += 2.0 * radius + 1e-6
        velocities[1, axis] = -speed
        if high:
            positions[:, axis], velocities[:, axis] = edge - positions[:, axis], -velocities[:, axis]
        system = hl.ParticleSystem(
            positions=positions, velocities=velocities, radius=radius, density=2500.0, box=[edge, edge],
            boundary="wall",
        )  # fmt: skip
        run = by_events(system, law=law, until=4.0 * duration, log=True, samples=1)
        near = by_small_steps(system, law=law, until=4.0 * duration, restitution_error=1e-6)
        assert [row[2:] for row in rows(run)] == [row[2:] for row in rows(near)]
        assert rows(run)[1][3] == -1 - 2 * axis - high
        for row, other in zip(rows(run), rows(near), strict=True):
            assert row[:2] == pytest.approx(other[:2], abs=2e-4 * duration, nan_ok=True)
        assert run.energy_error < 1e-11
        engine = core_engine("newton_events", system, law)
        engine.advance(4.0 * duration)
        clustered.append(engine.statistics()["cluster_share"] > 0.0)
    assert clustered == [True, True, True, True, False]


@pytest.mark.parametrize(("n", "mixed"), [(60, True), (80, True), (60, False), slow(21_000, False)])
def test_a_saved_run_goes_on_with_the_same_bits(tmp_path: Any, n: int, mixed: bool) -> None:
    """Stopped, saved and resumed often, also during contacts: equal bodies, kinds with a table of laws, more kinds than
    the table holds (64), and a box large enough for prefetching."""
    system = random_system(5, n=n, phi=0.3, d=3, boundary="periodic", mixed=mixed)
    law = LAWS[3] if n < 1000 else hl.LinearDashpot(stiffness=2e6, restitution=0.8)
    whole = by_events(system, law=law, until=2e-3, log=True, samples=8)
    path = tmp_path / "run"
    by_events(system, law=law, until=0.3e-3, log=True, samples=8, checkpoint=path)
    # The samples of the first run are finer; what counts is the state and the log.
    for until in (0.31e-3, 0.9e-3, 1.4e-3, 2e-3):
        resumed = hl.resume(path, until=until)
    assert whole.outcome == resumed.outcome == "ok"
    assert np.array_equal(whole.system.positions, resumed.system.positions)
    assert np.array_equal(whole.system.velocities, resumed.system.velocities)
    assert whole.contacts.equals(resumed.contacts)


def test_the_order_within_cells_does_not_matter() -> None:
    """A cell lists bodies by arrival, after loading by index. In this box several bodies come near a group at the same
    instant."""
    system = random_system(5, n=3000, phi=0.3, d=3, boundary="periodic", mixed=False)
    whole, saved = (core_engine("newton_events", system, LAWS[0]) for _ in range(2))
    for k in range(1, 7):
        for run in (whole, saved):
            run.advance(0.25e-3 * k)
        assert whole.outcome == "ok"
        for left, other in zip(whole.state(), saved.state(), strict=True):
            assert np.array_equal(left, other)
        saved = _core.load_engine("newton_events", saved.save())


@pytest.mark.parametrize("law", LAWS, ids=repr)
@pytest.mark.parametrize("boundary", [("periodic", "wall", "wall"), ("periodic", "lees-edwards", "periodic")])
def test_a_start_in_contact_goes_on_as_if_it_had_not_stopped(law: hl.Law, boundary: tuple[str, ...]) -> None:
    """The final state of a run, with contacts in progress, and images that are displaced in a sheared box, starts
    another run."""
    sheared = "lees-edwards" in boundary
    system = random_system(8, n=60, phi=0.35, d=3, boundary=boundary, mixed=True)
    if sheared:
        flow = system.replace(shear_rate=200.0)
        system = flow.replace(velocities=system.velocities + flow.domain.mean_flow(system.positions))
    whole = by_events(system, law=law, until=1e-3, samples=1)
    first = by_events(system, law=law, until=0.6e-3, samples=1)
    assert first.series.n_in_contact.values[-1] > 0
    assert (first.system.shear_displacement != 0.0) == sheared
    second = by_events(first.system, law=law, until=whole.time - first.time, samples=1, log=True)
    assert second.energy_error < 1e-9 and (second.contacts.begin.values == 0.0).any()
    away = second.system.positions - whole.system.positions
    away -= np.where(system.domain.wraps, system.box * np.round(away / system.box), 0.0)
    middle = np.abs(whole.system.positions[:, 1] / system.box[1] - 0.5) < (0.49 if sheared else 1.0)
    assert np.abs(away[middle]).max() < 1e-7 * system.radius.min()  # the others may differ by an image
    turned = np.abs(second.system.velocities - whole.system.velocities)[middle]
    assert turned.max() < (1e-6 if sheared else 1e-7)


UNIT = 2.0**-10  # [m]: positions at multiples of it touch exactly


@pytest.mark.parametrize("law", LAWS, ids=repr)
@pytest.mark.parametrize(("count", "moving"), [(2, 1), (3, 1), (3, 2), (5, 1)])
def test_a_cradle_of_touching_balls(law: hl.Law, count: int, moving: int) -> None:
    """Gaps exactly 0: velocities and number of contacts of ``hl.newton``."""
    speeds = [0.5 if i < moving else 0.0 for i in range(count)]
    balls = [hl.Ball(UNIT, density=2500.0)] * count
    wanted = hl.newton(hl.Column.cradle(balls, [-v for v in speeds[::-1]], law), until=0.01)
    system = hl.ParticleSystem(
        positions=[[(5 + 2 * i) * UNIT, 8 * UNIT, 8 * UNIT] for i in range(count)],
        velocities=[[v, 0.0, 0.0] for v in speeds], radius=UNIT, density=2500.0, box=[40 * UNIT, 16 * UNIT, 16 * UNIT],
    )  # fmt: skip
    run = by_events(system, law=law, until=0.01, samples=1)
    assert run.outcome == "ok"
    velocities = run.system.velocities[:, 0]
    assert velocities == pytest.approx(-wanted.velocities[::-1], abs=1e-8)
    assert np.abs(run.system.velocities[:, 1:]).max() == 0.0


@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_simultaneous_contacts(law: hl.Law) -> None:
    """A ball hit from four sides at one instant stays, and the four fly apart symmetrically."""
    middle = 16 * UNIT
    around = [(4, 0), (-4, 0), (0, 4), (0, -4)]
    system = hl.ParticleSystem(
        positions=[[middle, middle], *([middle + x * UNIT, middle + y * UNIT] for x, y in around)],
        velocities=[[0.0, 0.0], *([-0.125 * x, -0.125 * y] for x, y in around)],
        radius=UNIT, density=2500.0, box=[32 * UNIT] * 2,
    )  # fmt: skip
    run = by_events(system, law=law, until=0.012, samples=1)
    assert run.n_contacts == 4 and run.n_ended == 4 and run.largest_cluster == 5
    velocities = run.system.velocities
    assert np.abs(velocities[0]).max() < 1e-12
    outward = [velocities[1 + k] @ np.array(way) / 4.0 for k, way in enumerate(around)]
    assert outward == pytest.approx([outward[0]] * 4, rel=1e-10) and outward[0] > 0.0


@draws(25)
@given(
    seed=st.integers(0, 10_000), law=st.sampled_from(LAWS), heavy=st.floats(0.0, 6.0), slow=st.floats(-6.0, 0.0),
)  # fmt: skip
def test_masses_and_speeds_far_apart(seed: int, law: hl.Law, heavy: float, slow: float) -> None:
    """Energy and momentum with mass ratios up to a million; some grains rest or are slow. All are slow enough that the
    heaviest ones do not compress others too far."""
    base = random_system(seed, n=20, phi=0.2, d=3, boundary="periodic", mixed=True)
    rng = np.random.default_rng(seed)
    mass = base.mass * 10.0 ** (heavy * rng.random(base.n))
    unit = 10.0 ** (-0.5 * heavy)
    speed = rng.choice([0.0, 1.0, 10.0**slow], base.n) * unit
    system = base.replace(mass=mass, velocities=base.velocities * speed[:, None])
    run = by_events(system, law=law, until=2e-3 / unit, samples=3)
    assert run.outcome == "ok" and run.energy_error < 1e-8
    scale = float((mass * np.linalg.norm(system.velocities, axis=1)).sum())
    assert np.abs(run.system.momentum - system.momentum).max() <= 1e-11 * max(scale, 1e-300)


def stored(system: hl.ParticleSystem, law: hl.Law) -> float:
    """Σ E(ξ) over all overlapping pairs [J], without the engine."""
    balls = [hl.Ball(r, mass=m) for r, m in zip(system.radius.tolist(), system.mass.tolist(), strict=True)]
    walled = np.array([side == "wall" for side in system.boundary])
    total = 0.0
    for i in range(system.n):
        for j in range(i):
            d = system.positions[i] - system.positions[j]
            d -= np.where(walled, 0.0, system.box * np.round(d / system.box))
            depth = balls[i].radius + balls[j].radius - math.sqrt(d @ d)
            if depth > 0.0:
                total += law.between(balls[i], balls[j]).energy(depth)
        for x in (system.positions[i], system.box - system.positions[i]):
            for depth in (balls[i].radius - x)[walled & (x < balls[i].radius)].tolist():
                total += law.between(balls[i]).energy(depth)
    return total


def strongly_damped(name: str, restitution: float) -> hl.Law:
    if name == "linear":
        return hl.LinearDashpot(stiffness=3000.0, restitution=restitution)
    if name == "tsuji":
        return hl.Tsuji(youngs_modulus=1e7, poisson_ratio=0.3, restitution=restitution)
    return hl.Viscoelastic(youngs_modulus=1e7, poisson_ratio=0.3, restitution=restitution, impact_speed=0.3)


@pytest.mark.parametrize("restitution", [0.01, slow(0.2), slow(0.9)])
@pytest.mark.parametrize("name", sorted(hl.LAWS))
def test_contact_energy_is_that_of_all_overlaps(name: str, restitution: float) -> None:
    """Also for slack pairs, whose force has ended: their energy is dissipated gradually until the gap opens, and the
    total energy is conserved at every sample."""
    law, without_force = strongly_damped(name, restitution), 0
    for seed in range(4):
        d, walls = 2 + seed % 2, seed < 2
        system = hl.ParticleSystem.random(
            n=12, packing_fraction=0.3, radius=(0.7e-3, 1.1e-3), density=2500.0, rms_speed=0.3, dimension=d, seed=seed,
            boundary="wall" if walls else "periodic", gravity=9.81 if walls else 0.0,
        )  # fmt: skip
        for until in (1e-3, 2.3e-3):
            run = by_events(system, law=law, until=until, samples=100)
            lost, stored_energy = run.series.dissipated_energy.values, run.series.contact_energy.values
            scale = float(run.series.kinetic_energy.values[0])
            assert run.energy_error < 1e-9
            assert np.diff(lost).min() >= -1e-11 * scale and lost[0] == 0.0
            assert stored_energy[-1] == pytest.approx(stored(run.system, law), rel=1e-6, abs=1e-10 * scale)
            without_force += np.sum((stored_energy > 0.0) & (run.series.n_in_contact.values == 0))
    assert without_force > 0


@pytest.mark.parametrize(("d", "count"), [(2, 100), (3, 100), slow(2, 400), slow(3, 400)])
def test_pairs_in_contact_at_the_start(d: int, count: int) -> None:
    """A pair that overlaps by more than 1e-9 of its distance, whatever its sizes, place and velocity. One that nearly
    touches is in contact once its gap is closed."""
    random = np.random.default_rng(d)
    law = hl.LinearDashpot(stiffness=1e6, restitution=1.0)
    for digits in np.append(random.uniform(-11.0, -2.0, count), random.uniform(-9.1, -8.6, count)):
        radius = 1e-3 * np.array([1.0, 10.0 ** random.uniform(-1.7, 0.0)])
        sign, edge, speed = (
            random.choice([-1.0, 1.0]),
            1e-3 * random.uniform(4.3, 40.0),
            random.uniform(-1.0, 1.0),
        )
        towards = random.normal(size=d)
        towards /= np.linalg.norm(towards)
        distance = radius.sum() * (1.0 + sign * 10.0**digits)
        first = random.uniform(0.0, edge, d)
        system = hl.ParticleSystem(
            [first, (first + distance * towards) % edge], [[0.0] * d, -speed * towards], radius, density=2500.0,
            box=[edge] * d, allowed_overlap=0.1,
        )  # fmt: skip
        run = core_engine("newton_events", system, law)
        if abs(10.0**digits - 1e-9) > 1e-11:
            assert run.n_contacts == (sign < 0.0 and 10.0**digits > 1e-9)
        if sign > 0.0 and speed > 1e-3 and distance + radius.sum() < 2.0 * edge:
            touch = radius.sum() * 10.0**digits / speed
            run.advance(0.999 * touch - 1e-15)
            assert run.n_contacts == 0
            run.advance(1.001 * touch + 1e-15)
            assert run.n_contacts == 1


@pytest.mark.parametrize("name", sorted(hl.LAWS))
def test_overlap_without_force_at_the_start_holds_energy(name: str) -> None:
    """Both engines report it, and dissipate it as the gap opens."""
    law = strongly_damped(name, 0.05)
    system = hl.ParticleSystem(
        positions=[[4e-3, 5e-3], [5.99e-3, 5e-3]], velocities=[[-0.5, 0.0], [0.5, 0.0]], radius=1e-3, density=2500.0,
        box=[0.01, 0.01], allowed_overlap=0.01,
    )  # fmt: skip
    events, steps = (
        by_events(system, law=law, until=2e-5, samples=20, **by)
        for by in ({}, {"engine": "steps", "restitution_error": 1e-4})
    )
    before = stored(system, law)
    for run in (events, steps):
        stored_energy, lost = run.series.contact_energy.values, run.series.dissipated_energy.values
        assert run.n_contacts == 0 and stored_energy[0] == pytest.approx(before, rel=1e-9) and lost[0] == 0.0
        assert stored_energy[-1] == 0.0 and lost[-1] == pytest.approx(before, rel=5e-3)
        assert (np.diff(stored_energy) <= 0.0).all() and (np.diff(lost) >= 0.0).all()
    assert steps.series.contact_energy.values == pytest.approx(
        events.series.contact_energy.values, abs=1e-9 * before
    )


def test_observing_changes_nothing() -> None:
    system = random_system(6, n=60, phi=0.3, d=2, boundary="periodic", mixed=False)
    often, seldom = (by_events(system, law=LAWS[0], until=2e-3, log=True, samples=k) for k in (200, 1))
    assert np.array_equal(often.system.positions, seldom.system.positions)
    assert often.contacts.equals(seldom.contacts)


@pytest.mark.parametrize("restitution", [1.0, 0.9, 0.5, 0.2])
def test_samples_of_a_contact_follow_the_equation_of_motion(restitution: float) -> None:
    """Of an oblique contact beyond a side of the box, under gravity: forward from touch and back from the end of the
    force, then while the surfaces still overlap without force."""
    law, pull = hl.LinearDashpot(stiffness=2e4, restitution=restitution), np.array([0.0, 0.0, -9.81])
    system = hl.ParticleSystem(
        positions=[[0.0992, 0.05, 0.05], [0.0012, 0.0507, 0.0503]], radius=[1e-3, 0.8e-3], density=2500.0,
        box=[0.1] * 3, velocities=[[0.7, 0.2, -0.1], [-0.8, -0.1, 0.2]],
        boundary=["periodic", "periodic", "wall"], gravity=pull,
    )  # fmt: skip
    (a, b), (m_a, m_b), length = system.velocities, system.mass, float(system.radius.sum())
    mass = m_a * m_b / (m_a + m_b)
    contact = law.between(*(hl.Ball(float(r), density=2500.0) for r in system.radius))
    r, v = system.positions[1] + [0.1, 0.0, 0.0] - system.positions[0], b - a
    along = r @ v
    touch = (-along - math.sqrt(along**2 - (v @ v) * (r @ r - length**2))) / (v @ v)

    def motion(time: float, y: Any) -> Any:
        r, v = y[:3], y[3:6]
        d = np.linalg.norm(r)
        rate = -(r @ v) / d
        force = contact.stiffness * (length - d) + contact.damping * rate
        lost = contact.damping * rate**2 if force > 0.0 else -contact.stiffness * (length - d) * rate
        pressing = max(force, 0.0) / d
        return [*v, *(pressing / mass * r), lost, *np.outer(r, pressing * r)[np.triu_indices(3)]]

    def force_ends(time: float, y: Any) -> Any:
        d = np.linalg.norm(y[:3])
        return (
            contact.stiffness * (length - d) - contact.damping * (y[:3] @ y[3:6]) / d if time > 0.0 else 1.0
        )

    force_ends.direction, force_ends.terminal = -1.0, True  # type: ignore[attr-defined]
    start, within = [*(r + touch * v), *v, *np.zeros(7)], {"method": "DOP853", "rtol": 1e-13, "atol": 1e-16}
    whole = scipy.integrate.solve_ivp(motion, (0.0, 1.0), start, events=force_ends, **within)
    duration, at_end = whole.t[-1], whole.y[:, -1]
    engine = core_engine("newton_events", system, law)
    energy = 0.5 * mass * (v @ v)
    for part in (1e-6, 0.1, 0.3, 0.49, 0.51, 0.7, 0.9, 0.999, 1.0005):
        engine.advance(touch + part * duration)
        if part < 1.0:
            y = scipy.integrate.solve_ivp(motion, (0.0, part * duration), start, **within).y[:, -1]
        else:
            y = at_end.copy()
            y[:3] += (part - 1.0) * duration * at_end[3:6]
        seen, depth = engine.observe(), length - np.linalg.norm(y[:3])
        stored = 0.5 * contact.stiffness * max(depth, 0.0) ** 2
        if part > 1.0:
            y[6] += 0.5 * contact.stiffness * (length - np.linalg.norm(at_end[:3])) ** 2 - stored
        assert seen["contact_energy"] == pytest.approx(stored, abs=1e-11 * energy)
        assert seen["dissipated_energy"] == pytest.approx(y[6], abs=1e-11 * energy)
        assert seen["virial_tensor"][[0, 3, 4, 1, 5, 2]] == pytest.approx(y[7:], abs=1e-11 * mass * length)
        assert seen["n_in_contact"] == (part < 1.0) and seen["n_ended"] == (part > 1.0)
        positions, velocities = map(np.asarray, engine.state())
        time = engine.time
        mean = (m_a * a + m_b * b) / (m_a + m_b) + time * pull
        for k, share in enumerate((-m_b, m_a)):
            assert velocities[k] == pytest.approx(mean + share / (m_a + m_b) * y[3:6], abs=1e-11)
        expected = system.positions[0] + touch * a
        expected += part * duration * (mean - time * pull) + 0.5 * time**2 * pull
        expected -= m_b / (m_a + m_b) * (y[:3] - start[:3])
        assert positions[0] == pytest.approx(expected, abs=1e-13)


def test_contacts_with_walls_add_no_virial() -> None:
    x = np.array(list(itertools.product(range(3), repeat=3)), float) * 0.03 + 0.015
    v = np.random.default_rng(7).standard_normal(x.shape)
    radius = np.full(27, 0.01)
    law, virial = ("linear", 0, [1e6, 0.8], None), []
    for kind in ("newton_events", "newton_steps"):
        box = _core.Box([0.09] * 3, ["wall"] * 3)
        run = _core.make_engine(kind, box, x, v, radius, 1e4 * radius**3, law=law, time_step=2e-6)
        run.advance(0.02)
        seen = run.observe()
        assert 10 < seen["n_pairs"] < seen["n_contacts"] - 10
        virial.append(seen["virial_tensor"][:3].sum())
    assert virial[0] == pytest.approx(virial[1], rel=1e-3)


@pytest.mark.slow
def test_the_virial_of_two_bodies_is_that_of_their_motion() -> None:
    """Σ m x·v changes by ∫ (Σ m v² + r·F) dt during an oblique contact."""
    for law in LAWS:
        system = hl.ParticleSystem(
            positions=[[0.03, 0.05, 0.05], [0.0325, 0.0508, 0.05]], radius=1e-3, density=2500.0, box=[0.1] * 3,
            velocities=[[1.0, 0.0, 0.0], [-1.0, 0.2, 0.1]],
        )  # fmt: skip
        run = by_events(system, law=law, until=4e-3, samples=4000)
        assert run.n_ended == 1
        m, kinetic = float(system.mass[0]), run.series.kinetic_energy.values
        moved = sum(
            m * (np.sum(s.positions * s.velocities)) * sign for s, sign in ((run.system, 1.0), (system, -1.0))
        )
        work = moved - 2.0 * np.trapezoid(kinetic, run.series.time.values)
        volume = 3.0 * 1e-3
        pressure = run.series.pressure.values[1:]
        thermal = 3.0 * 2.0 * m * run.series.granular_temperature.values
        mean = np.sum(0.5 * (thermal[1:] + thermal[:-1]) * np.diff(run.series.time.values))
        virial = np.sum(pressure * np.diff(run.series.time.values)) * volume - mean
        assert virial == pytest.approx(work, rel=1e-4)


def test_a_cluster_loses_separated_bodies() -> None:
    """Separated bodies leave while others join; otherwise a cluster of a dense gas would grow without bound."""
    system = hl.ParticleSystem.random(
        n=4000, packing_fraction=0.3, radius=1e-3, density=2500.0, rms_speed=1.0, seed=1
    )
    wait = mean_free_time(system)
    law = linear_law(system, 0.4 * wait, 0.95)
    run = by_events(system, law=law, until=2.0 * wait, samples=2)
    assert run.outcome == "ok" and run.energy_error < 1e-11
    assert run.largest_cluster is not None and run.largest_cluster < 60


@pytest.mark.parametrize(
    ("count", "gap", "coarse"),
    [(80, 1e-3, 0.02), slow(320, 1e-3, 0.04), slow(320, 0.0, 0.04), slow(320, 1e-2, 0.04)],
)
def test_a_long_row_meets_a_wall(count: int, gap: float, coarse: float) -> None:
    """All balls are in contact at once and separate; some creep. Momentum and energy agree with small steps,
    extrapolated to zero."""
    law, ball = hl.LinearDashpot(stiffness=2000.0, restitution=0.9), hl.Ball(UNIT, density=2500.0)
    duration = float(law.between(ball, ball).duration(1.0))
    system = hl.ParticleSystem(
        positions=[[8.0 * UNIT, (1.5 + 2.0 * i * (1.0 + gap)) * UNIT] for i in range(count)],
        velocities=[[0.0, -1.0]] * count, radius=UNIT, density=2500.0,
        box=[16.0 * UNIT, (2.0 * count * (1.0 + gap) + 60.0) * UNIT], boundary="wall",
    )  # fmt: skip
    until = (0.5 + 2.0 * count * gap) * UNIT + 1.2 * count * duration
    run = by_events(system, law=law, until=until, samples=10)
    assert run.outcome == "ok" and run.largest_cluster == count
    assert run.energy_error < 1e-11
    assert run.series.n_in_contact.values.max() > 0.9 * count
    rough, fine = (
        by_small_steps(system, law=law, until=until, time_step=step * duration, samples=10)
        for step in (coarse, 0.5 * coarse)
    )
    # Steps are of second order, with errors up to 1e-4 for the coarse ones.
    momentum = (4.0 * fine.system.momentum - rough.system.momentum) / 3.0
    kinetic = (4.0 * fine.series.kinetic_energy.values - rough.series.kinetic_energy.values) / 3.0
    assert run.system.momentum == pytest.approx(momentum, rel=1e-6, abs=1e-12)
    assert run.series.kinetic_energy.values == pytest.approx(kinetic, abs=1e-6 * float(kinetic[0]))


def test_time_advances_where_a_contact_ends_within_rounding() -> None:
    """Balls as wide as the box touch both walls; some contacts begin and end within the rounding of positions."""
    radius = 0.0009481194856766419
    system = hl.ParticleSystem(
        positions=[[radius, 0.0010330632239960414], [radius, 0.0028443584570299256], [radius, 0.0047405974283832092]],
        velocities=[[-1.0453255335638387e-09, 5.5152248532813395e-10], [1.2503359814355363e-09, 2.324044029270864e-09],
                    [0.0, 2.324044029270864e-09]],
        radius=[8.1038129133080387e-05, radius, radius], mass=[135.8323837896213, 0.041683428479314291, 1.0],
        box=[2.0 * radius, 6.0 * radius], boundary=("wall", "periodic"), gravity=[0.0, 8.0473244778132623e-17],
    )  # fmt: skip
    law = hl.Viscoelastic(youngs_modulus=2.8484635977241168e11, poisson_ratio=0.0204, dissipative_time=0.0)
    run = by_events(system, law=law, until=0.2556, samples=4, log=True)
    assert run.outcome == "ok" and run.energy_error < 1e-10
    lasted = run.contacts.end.values - run.contacts.begin.values
    assert np.all(lasted[~np.isnan(lasted)] >= 0.0)


@pytest.mark.parametrize(
    "law",
    [
        hl.Viscoelastic(youngs_modulus=1e7, poisson_ratio=0.3, dissipative_time=0.0),
        hl.Tsuji(elastic_prefactor=1e6, restitution=1.0),
        *LAWS,
    ],
    ids=repr,
)
def test_a_contact_is_not_over_before_its_end(law: hl.Law) -> None:
    """Observed shortly before its end, where a step past touch would make time run backwards."""
    system = hl.ParticleSystem(
        positions=[[0.01, 0.01], [0.013, 0.0105]], velocities=[[0.5, 0.0], [-0.5, 0.0]], radius=1e-3,
        density=2500.0, box=[0.03] * 2,
    )  # fmt: skip
    contacts = by_events(system, law=law, until=0.02, log=True).contacts
    begin, end = float(contacts.begin[0]), float(contacts.end[0])
    run = core_engine("newton_events", system, law)
    run.advance(end)
    place, velocity = run.state()
    run = core_engine("newton_events", system, law)
    for left in np.geomspace(0.1, 1e-5, 200) * (end - begin):
        run.advance(end - left)
        off = np.abs(run.state()[0] - (place - left * velocity)).max()
        assert run.observe()["n_in_contact"] == 1, left
        assert off < 0.1 * left * np.abs(velocity).max(), left


@pytest.mark.parametrize("fall", [0.0, 0.0098, -0.003])
@pytest.mark.parametrize("radius", [1.0e-4, 3.0e-3])
def test_a_body_that_fits_between_two_walls_swings(radius: float, fall: float) -> None:
    """Like on one spring: it leaves one wall as it touches the other. Where an observation ends the integration,
    rounding decides which event comes first; a body free of both contacts must not stop."""
    law, speed = hl.LinearDashpot(stiffness=1e4, restitution=1.0), 0.01
    system = hl.ParticleSystem(
        positions=[[2.0 * radius, radius]], velocities=[[0.0, speed]], radius=radius, density=2500.0,
        box=[4.2 * radius, 2.0 * radius], boundary=("periodic", "wall"),
    )  # fmt: skip
    frequency = math.sqrt(1e4 / float(system.mass[0]))
    _, *particles = engine_arguments(system)
    bounds = _core.Box(system.box.tolist(), list(system.boundary), [0.0, fall * speed * frequency])
    run = _core.make_engine("newton_events", bounds, *particles, law=law_arguments(law))
    for k in range(1, 80):
        angle = 0.37 * math.pi * k
        run.advance(angle / frequency)
        place = (run.state()[0][0, 1] - radius) * frequency / speed
        assert place == pytest.approx(math.sin(angle) + fall * (1.0 - math.cos(angle)), abs=1e-8), k
        assert run.largest_safety_use(20) <= 1.0, k


@pytest.mark.parametrize("radius", [1.0e-4, 3.0e-3])
def test_a_swinging_body_is_hit(radius: float) -> None:
    """Another body hits the swinging one: the group, integrated again up to then, must have the true position. Small
    steps find the same; energy alone would not show a body left behind."""
    law, speed = hl.LinearDashpot(stiffness=1e4, restitution=1.0), 0.01
    frequency = math.sqrt(1e4 / float(hl.Ball(radius, density=2500.0).mass))
    for k in range(40):
        gap = (2.0 + 0.37 * math.pi * k) * speed / frequency
        system = hl.ParticleSystem(
            positions=[[2.0 * radius, radius], [3.5 * radius + gap, radius]],
            velocities=[[0.0, speed], [-speed, 0.0]],
            radius=[radius, 0.5 * radius], density=2500.0, box=[8.4 * radius, 2.0 * radius],
            boundary=("periodic", "wall"),
        )  # fmt: skip
        until = gap / speed + 7.3 / frequency
        run = by_events(system, law=law, until=until, samples=2)
        near = by_small_steps(system, law=law, until=until, samples=2, time_step=0.002 / frequency)
        off = np.abs(run.system.positions - near.system.positions).max() * frequency / speed
        assert run.n_contacts == near.n_contacts and off < 1e-3, k


def test_a_force_that_falls_by_less_than_rounding_goes_on() -> None:
    """Three balls in exact touch between two walls. Gravity lowers the last one's wall force by 1e-38 of its value
    before the others press it on: this is not an end of the contact, nor ten million of them."""
    radius, v = 0.00056616259905373527, 3.2687412896877242e-09
    system = hl.ParticleSystem(
        positions=[[radius, 0.00056616259905373527], [radius, 0.0016984877971612058], [radius, 0.0028308129952686763]],
        velocities=[[2.3213621427983933e-09, 0.0], [-v, v], [0.0, 0.0]], radius=radius, mass=1.0,
        box=[0.0033969755943224116] * 2, boundary=("periodic", "wall"), gravity=(0.0, -2.4792741267302667e-18),
    )  # fmt: skip
    law = hl.LinearDashpot(stiffness=100.0, restitution=1.0)
    run = by_events(system, law=law, until=0.2, samples=4, log=True)
    assert run.outcome == "ok" and run.energy_error < 1e-9
    assert run.n_contacts == 3 and run.n_ended == 0


# Bodies that fit between walls or touch exactly, found by the fuzz target: what was wrong, law, system, until [s].
STIFF = hl.Tsuji(elastic_prefactor=999.99999999999977, restitution=1.0)
FOUND = {
    "speeds without squares": (
        hl.LinearDashpot(stiffness=367.03364966696256, restitution=0.5),
        dict(
            radius=0.0013335214293036552, mass=999.99999678332483, box=[0.0026670428586073104] * 3,
            positions=[[0.0013335214293036552] * 3],
            velocities=[[0.0, -1.2731941241556014e-08, 1.2731941235627242e-08]],
        ),
        1000.0,
    ),
    "heavy bodies as inexact as light ones": (
        STIFF,
        dict(
            radius=0.00010746107780113776, mass=[999.99999678332483, 0.0010000000000000002],
            box=[0.00064476647035334369, 0.0004513472728725587, 0.00021492215678444788],
            boundary=("wall", "periodic", "wall"), gravity=(1.4853031061020701e-25, 0.0, 4.4559093183062108e-25),
            positions=[
                [0.00010746107839222394, 0.00010746107839222394, 0.00010746107898331012],
                [0.00032238323569387228, 0.00010746107898331012, 0.0001074610778011558],
            ],
            velocities=[[0.0, 0.0, 3.0946302536495983e-13], [3.0946302536495983e-13, 3.0946302536495983e-13, 0.0]],
        ),
        102.20523002309031,
    ),
    "three contacts end at one instant": (
        hl.Tsuji(youngs_modulus=11547.819797367163, poisson_ratio=-0.58390426635742188, damping_coefficient=0.0),
        dict(
            radius=0.99999999678332507, mass=999.99999678332483, box=[7.9999999523595875] * 3,
            positions=[[6.9999999541792786] * 3], velocities=[[0.011162401324461241] * 3],
            gravity=[1.5574900490994021e-05] * 3,
        ),
        10.0,
    ),
    "a series with terms for steps far shorter than its unit": (
        hl.LinearDashpot(stiffness=209491.63521310722, restitution=0.001596158860251249),
        dict(
            radius=0.00072965313916826093, mass=1.0, box=[0.0014691772375373063, 0.0029383544750746127],
            gravity=(0.0, 1.8777082642029719e-06),
            positions=[
                [0.00073458861876865317, 0.00073768584745443613],
                [0.00073458861876865317, 0.002205325232658404],
            ],
            velocities=[
                [-0.0018771786865882897, 0.0019792970526633126],
                [0.0017389939346369179, 0.0019792970526633126],
            ],
        ),
        0.11744857322718324,
    ),
    "the clock of a contact that hardly moves": (
        STIFF,
        dict(
            radius=0.0067010809286149418,
            mass=[0.0077743755399407172, 0.19518696592466683, 2.240750286367545, 1.0],
            box=[0.040206485571689654, 0.026804323714459767],
            gravity=(-1.0202073160342435e-20, -1.3483698928945487e-20),
            positions=[
                [0.0067010809286149418, 0.0067010809286149418], [0.0067010809286149418, 0.020103242785844827],
                [0.020103242785844827, 0.0067010809286149418], [0.020103242785844827, 0.020103242785844827],
            ],
            velocities=[
                [0.0, 6.5342791776305394e-10], [3.1930942742514619e-10, 6.3385396437999765e-10],
                [-5.7666140374696779e-10, 1.1620846223714014e-10], [3.9569691810986156e-10, -4.5326085987610235e-10],
            ],
        ),
        0.199904027011162,
    ),
    "contacts of less than rounding": (
        hl.LinearDashpot(stiffness=8792719028.3521175, restitution=0.099428555439226338),
        dict(
            radius=0.0027073555891891808, mass=[1.5448873520047606, 233.3865423385065],
            box=[0.0054147111783783616, 0.010829422356756723], gravity=(0.0, -1.9088664241596179e-07),
            positions=[
                [0.0027073555891891808, 0.0027073555891891808], [0.0027073555891891808, 0.0081220667675675415],
            ],
            velocities=[
                [-0.00015420499760642923, -2.8006949767771221e-05], [-0.00033546393193042778, 0.00012606831469764201],
            ],
        ),
        0.01,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FOUND)
def test_bodies_that_fit_exactly(name: str) -> None:
    law, arguments, until = FOUND[name]
    run = hl.molecular_dynamics(
        hl.ParticleSystem(**({"boundary": "wall"} | arguments)),
        law=law,
        until=until,
        samples=4,
        engine="events",
    )
    assert run.outcome == "ok" and run.time == until
    assert run.n_contacts < 300
    assert run.energy_error < 1e-9


def test_no_cluster_lasts_thousands_of_contacts() -> None:
    """A slow body in slack contact with walls separates soon, however long it would take to travel far."""
    radius, v = 0.0001000000000000001, 2.3332128102661892e-11
    system = hl.ParticleSystem(
        positions=[[radius] * 2], velocities=[[v] * 2], radius=radius, mass=999.99999678332483,
        box=[0.0002000000000000002] * 2, boundary="wall", gravity=(-8.0963466838794627e-21, 1.7645883785135896e-20),
    )  # fmt: skip
    law = hl.Viscoelastic(
        youngs_modulus=1461187.2764150028, poisson_ratio=-0.42205882357666269,
        restitution=0.0012087957959949248, impact_speed=0.012087957959949241,
    )  # fmt: skip
    run = core_engine("newton_events", system, law, log=True)
    run.advance(6e4)
    assert run.outcome == "ok" and run.n_logged > 50
    assert len(run.open_contacts()["begin"]) < 20  # of the cluster that still lasts


@pytest.mark.parametrize("bodies", [1, 2])
@pytest.mark.parametrize("restitution", [1.0, 0.9])
def test_a_contact_continues_where_positions_round(bodies: int, restitution: float) -> None:
    """Observed midway, with a compression of 1e-6 radii in a box of 100 radii. Without damping the force begins at
    zero, and rounding of positions near the edge of the box must not count as its end."""
    edge, radius, mass, speed = 2.0000010936695341e-4, 1.8147790907712649e-6, 1000.0, 4.0579694070446531e-9
    law = hl.LinearDashpot(stiffness=9999999957.1110401, restitution=restitution)
    at = 1.9818533023046106e-4
    places = [[0.5 * edge, at, at], [at, at, 0.5 * edge]][:bodies]
    moving = [[0.0, 0.0, speed], [speed, 0.0, 0.0]][:bodies]
    box, sides = [edge, 2.1 * edge, edge], ["wall", "periodic", "wall"]
    start = hl.ParticleSystem(places, moving, radius, mass=mass, box=box, boundary=sides)
    duration = law.between(hl.Ball(radius, mass=mass), hl.FLOOR).duration()
    gap = edge - radius - at
    for share in (0.01, 0.3, 0.5, 0.9, 1.5):
        run = by_events(start, law=law, until=gap / speed + share * duration, log=True)
        assert run.outcome == "ok" and run.n_contacts == bodies
        ends = run.contacts["end"].values
        assert np.isnan(ends).all() if share < 1.0 else np.isfinite(ends).all()
        if restitution == 1.0 and share < 1.0:
            assert run.system.velocities[0, 2] == pytest.approx(
                speed * math.cos(math.pi * share), abs=1e-6 * speed
            )


@pytest.mark.slow
def test_a_heap_ends_as_unresolved() -> None:
    """Where contacts last and none begins, the run ends with an outcome instead of hours of work."""
    x, y = np.meshgrid(np.arange(30) * 2.00002e-3 + 1.1e-3, np.arange(11) * 2.00002e-3 + 1.00002e-3)
    system = hl.ParticleSystem(
        positions=np.column_stack([x.ravel(), y.ravel()]), velocities=np.zeros((330, 2)), radius=1e-3,
        density=2500.0, box=[0.0622, 0.1], boundary="wall", gravity=9.81,
    )  # fmt: skip
    run = by_events(system, law=hl.LinearDashpot(stiffness=500.0, restitution=0.3), until=0.2, samples=4)
    end = run.early_end
    assert end is not None and end.time == run.time and end.wall is None
    assert len(end.particles) > 200 and set(end.particles) <= set(range(330))
    assert list(end.particles) == sorted(set(end.particles))
    assert end.position == tuple(run.system.positions[end.particles[0]])
    assert run.outcome.startswith(f"not resolved: the contacts of {len(end.particles)} particles (")
    assert "too long" in run.outcome and f"at {run.time:.6g} s, near (" in run.outcome
    assert run.largest_cluster is not None and run.largest_cluster > 300
    assert run.time < 0.2


def test_a_ball_that_comes_to_rest_on_the_floor_stays_there() -> None:
    law = hl.LinearDashpot(stiffness=2000.0, restitution=0.3)
    system = hl.ParticleSystem(
        positions=[[0.01, 1.5e-3]], velocities=[[0.0, 0.0]], radius=1e-3, density=2500.0, box=[0.02, 0.02],
        boundary="wall", gravity=9.81,
    )  # fmt: skip
    run = by_events(system, law=law, until=0.5, samples=5, log=True)
    depth = float(system.mass[0]) * 9.81 / 2000.0
    assert run.outcome == "ok"
    assert run.system.positions[0, 1] == pytest.approx(1e-3 - depth, abs=1e-3 * depth)
    assert math.isnan(run.contacts.end.values[-1])


def test_a_box_where_images_meet_is_refused() -> None:
    system = hl.ParticleSystem([[1e-3, 1e-3]], [[1.0, 0.0]], radius=1e-3, density=2500.0, box=[4.1e-3, 0.1])
    with pytest.raises(ValueError, match=r"box: got 0\.0041 m along x \(periodic\), must be >= 0\.0042"):
        by_events(system, law=LAWS[0], until=1e-3)


def test_a_sphere_in_hardly_any_gravity_does_not_touch_the_floor() -> None:
    """2 g h underflows, the time of the fall does not."""
    system = hl.ParticleSystem(
        [[0.5, 0.5, 0.1 * (1.0 + 1e-8)]], [[0.0, 0.0, 0.0]], 0.1, mass=1.0, box=1.0,
        boundary=["periodic", "periodic", "wall"], gravity=[0.0, 0.0, -1e-316],
    )  # fmt: skip
    law = hl.LinearDashpot(stiffness=100.0, restitution=0.9)
    run = hl.molecular_dynamics(system, law=law, until=1.0, engine="events")
    assert (run.outcome_name, run.n_contacts) == ("ok", 0)
    np.testing.assert_array_equal(run.system.positions, system.positions)
