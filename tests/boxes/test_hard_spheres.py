"""The hard-sphere engine: reference logs, conservation laws, symmetries, early ends and invalid input."""

import math
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

import hardlimit as hl
from box_engines import REFERENCE, box_of, grow_packing, logged, reference_law
from box_engines import hard_spheres as engine
from conftest import output_of, slow
from hardlimit import _core
from hardlimit.boxes.contacts import law_arguments
from slow_hard_spheres import Rule, SlowHardSpheres


def edge_of(n: int, fraction: float, dimension: int = 3) -> float:
    """Edge of a box that ``n`` particles of radius 0.5 fill to this fraction."""
    volume = math.pi / 6.0 if dimension == 3 else math.pi / 4.0
    return float((n * volume / fraction) ** (1.0 / dimension))


def packed(n: int, fraction: float, dimension: int = 3, seed: int = 1, periodic: bool = True):
    """Positions, velocities with zero total momentum, and the edge of the box."""
    edge = edge_of(n, fraction, dimension)
    position = grow_packing(np.full(n, 0.5), [edge] * dimension, [periodic] * dimension, seed)
    velocity = np.random.default_rng(seed).standard_normal((n, dimension))
    return position, velocity - velocity.mean(axis=0), edge


def same_state(a, b) -> bool:
    return all(np.array_equal(x, y) for x, y in zip(a.state(), b.state(), strict=True))


class Solved(NamedTuple):
    """A run of a reference case: its engine, rows (time, first, second, speed) of its log, and its final state."""

    engine: Any
    log: np.ndarray
    position: np.ndarray
    velocity: np.ndarray


def solved(which: str, case: dict, rule: str, law: hl.Law | None) -> Solved:
    """The case, solved with this rule by the engine or by the slow engine of the tests."""
    until, most = case.get("until", math.inf), case.get("collisions", 0)
    restitution, duration = case.get("restitution", math.nan), case.get("contact_duration", math.nan)
    if which == "slow":
        arrays = (np.array(case[name]) for name in ("positions", "velocities", "radius", "mass", "box"))
        settings = Rule(rule, restitution, law, duration)
        slow = SlowHardSpheres(*arrays, tuple(case["boundary"]), np.array(case["gravity"]), settings)
        slow.advance(until, most)
        return Solved(slow, np.array(slow.log), slow.position, slow.velocity)
    names = ("radius", "mass", "box", "gravity")
    run = engine(
        case["positions"], case["velocities"], **{name: case[name] for name in names}, rule=rule,
        periodic=[side == "periodic" for side in case["boundary"]], contact_duration=duration,
        law=None if law is None else law_arguments(law), restitution=restitution if law is None else math.nan,
    )  # fmt: skip
    run.advance(until, *([most] if most else []))
    return Solved(run, np.column_stack(logged(run)[:4]), *run.state())


def assert_end_of_reference(case: dict, run: Solved) -> None:
    rms = math.sqrt(np.mean(np.sum(np.square(case["velocities"]), axis=1)))
    assert np.abs(run.position - case["end_positions"]).max() <= case["tolerance"] * min(case["radius"])
    assert np.abs(run.velocity - case["end_velocities"]).max() <= case["tolerance"] * rms


both = pytest.mark.parametrize("which", ["engine", "slow"])


@both
@pytest.mark.parametrize("case", REFERENCE["event_driven"], ids=lambda c: f"{c['rule']}-{len(c['radius'])}")
def test_reference_log(which: str, case: dict) -> None:
    run = solved(which, case, case["rule"], reference_law(case))
    known = np.array(case["log"])
    rms = math.sqrt(np.mean(np.sum(np.square(case["velocities"]), axis=1)))
    assert np.array_equal(run.log[:, 1:3], known[:, 1:3])
    np.testing.assert_allclose(run.log[:, 0], known[:, 0], rtol=case["tolerance"])
    np.testing.assert_allclose(run.log[:, 3], known[:, 3], atol=case["tolerance"] * rms)
    assert_end_of_reference(case, run)


@both
@pytest.mark.parametrize("case", REFERENCE["dilute"], ids=lambda c: f"{c['law']}-{c['dimension']}")
def test_soft_rule_is_newtons_equations_where_contacts_are_isolated(which: str, case: dict) -> None:
    run = solved(which, case, "soft", reference_law(case))
    known = np.array(sorted((begin, first, second) for begin, _, first, second in case["contacts"]))
    assert np.array_equal(run.log[:, 1:3], known[:, 1:])
    np.testing.assert_allclose(run.log[:, 0], known[:, 0], rtol=case["tolerance"])
    if which == "engine":
        statistics = run.engine.statistics()
        assert (statistics["n_soft"], statistics["n_soft_third_body"]) == (len(known), 0)
    assert_end_of_reference(case, run)


def test_soft_rule_becomes_that_of_hard_spheres_with_order_one_in_the_duration() -> None:
    """Four times the stiffness halves the contact duration and the deviation from the hard-sphere path."""
    case = REFERENCE["dilute"][0] | {"collisions": 5}
    case |= {
        "until": solved("slow", case | {"until": math.inf}, "constant", None).log[4][0] + 1e-4,
        "collisions": 0,
    }
    hard, off = solved("slow", case, "constant", None), []
    for factor in (1e3, 4e3, 16e3, 64e3):
        soft = solved("slow", case, "soft", reference_law(case | {"stiffness": factor * case["stiffness"]}))
        assert np.array_equal(soft.log[:, 1:3], hard.log[:, 1:3])
        off.append(np.abs(soft.position - hard.position).max())
    np.testing.assert_allclose(np.log2(np.array(off[:-1]) / off[1:]), 1.0, atol=0.05)


@pytest.mark.parametrize("rows", [100_000, pytest.param(10_000_000, marks=pytest.mark.slow)])
def test_energy_and_momentum_of_elastic_collisions(rows: int) -> None:
    position, velocity, edge = packed(500, 0.4)
    run = engine(position, velocity, box=edge, log=False)
    before = run.observe()
    run.advance(math.inf, rows)
    after = run.observe()
    assert run.n_contacts == rows
    assert abs(after["kinetic_energy"] / before["kinetic_energy"] - 1.0) < 1e-12
    assert np.abs(after["momentum"]).max() < 1e-9
    assert after["dissipated_energy"] == 0.0
    expected = 2.0 * before["kinetic_energy"] * run.time
    assert after["kinetic_integral"] == pytest.approx(expected, rel=1e-12)


def test_integral_of_kinetic_energy_is_that_of_many_observations() -> None:
    position, velocity, edge = packed(40, 0.2, periodic=False)
    run = engine(position, velocity, box=edge, periodic=False, gravity=[0.0, 0.0, -1.0], restitution=0.8)
    times = np.linspace(0.0, 2.0, 4001)
    thermal = []
    for time in times:
        run.advance(float(time))
        seen = run.observe()
        thermal.append(2.0 * seen["kinetic_energy"] - np.sum(seen["momentum"] ** 2) / 40.0)
    integral = np.sum(0.5 * (np.array(thermal)[1:] + np.array(thermal)[:-1]) * np.diff(times))
    assert run.observe()["kinetic_integral"] == pytest.approx(integral, rel=2e-3)


def test_time_reversal() -> None:
    position, velocity, edge = packed(100, 0.3)
    there = engine(position, velocity, box=edge)
    there.advance(math.inf, 300)
    end, speeds = there.state()
    back = engine(np.mod(end, edge), -speeds, box=edge)
    back.advance(there.time)
    returned, final = back.state()
    assert back.n_contacts == there.n_contacts
    apart = returned - position
    assert np.abs(apart - edge * np.round(apart / edge)).max() < 1e-6
    assert np.abs(final + velocity).max() < 1e-6


@pytest.mark.parametrize("kind", ["permuted", "shifted", "mirrored"])
def test_symmetries_change_nothing_but_rounding(kind: str) -> None:
    position, velocity, edge = packed(80, 0.35, dimension=2)
    rng = np.random.default_rng(8)
    order = rng.permutation(80) if kind == "permuted" else np.arange(80)
    moved, speeds = position[order], velocity[order].copy()
    if kind == "shifted":
        moved = np.mod(moved + rng.random(2) * edge, edge)
    if kind == "mirrored":
        moved = np.column_stack([np.mod(edge - moved[:, 0], edge), moved[:, 1]])
        speeds[:, 0] *= -1.0
    logs = []
    for start in ((position, velocity), (moved, speeds)):
        run = engine(*start, box=edge, restitution=0.9)
        run.advance(math.inf, 240)
        logs.append(logged(run))
    pairs = [np.sort(np.column_stack(log[1:3]), axis=1) for log in logs]
    pairs[1] = np.sort(order[pairs[1]], axis=1)
    assert np.array_equal(pairs[0], pairs[1])
    np.testing.assert_allclose(logs[0][0], logs[1][0], rtol=1e-7)


def test_saved_runs_and_pieces_of_time_give_the_same_bits() -> None:
    rng = np.random.default_rng(4)
    radius = rng.uniform(0.2, 0.5, 50)
    position = grow_packing(radius, [5.0] * 3, [True, False, True], 2)
    velocity = rng.standard_normal((50, 3))
    law = ("viscoelastic", 0, [1e4, 0.3, 1e-3], None)
    for options in (
        {"restitution": 0.95},
        {"rule": "tc", "restitution": 0.6, "contact_duration": 0.01},
        {"rule": "law", "law": law, "restitution": math.nan},
        {"rule": "soft", "law": law, "restitution": math.nan},
    ):
        system = {"radius": radius, "box": 5.0, "periodic": [True, False, True], "gravity": [0.0, -0.2, 0.0]}
        whole = engine(position, velocity, **system, **options)
        whole.advance(1.5)
        parts = engine(position, velocity, **system, **options)
        for time in np.sort(rng.uniform(0.0, 1.5, 12)):
            parts.advance(float(time))
            parts = _core.load_engine("hard_spheres", parts.save())
        parts.advance(1.5)
        assert whole.n_contacts > 50
        assert same_state(whole, parts)
        assert np.array_equal(whole.observe()["virial_tensor"], parts.observe()["virial_tensor"])
        for a, b in zip(logged(whole), logged(parts), strict=True):
            assert np.array_equal(a, b)
        counts = ("n_pairs", "n_walls", "n_elastic_by_tc", "n_soft", "n_soft_third_body")
        assert [whole.statistics()[c] for c in counts] == [parts.statistics()[c] for c in counts]
        assert whole.outcome == parts.outcome


def test_order_in_memory_changes_nothing() -> None:
    """A large system is sorted by cells from time to time; a loaded one at other times than the saved one."""
    n = 5000
    position, velocity, edge = packed(n, 0.3)
    order = np.random.default_rng(1).permutation(n)
    position, velocity = position[order], velocity[order]
    whole = engine(position, velocity, box=edge, restitution=0.95)
    whole.advance(math.inf, 25 * n)
    parts = engine(position, velocity, box=edge, restitution=0.95)
    for rows in (3 * n, 11 * n, 25 * n):
        parts = _core.load_engine("hard_spheres", parts.save())
        parts.advance(math.inf, rows - parts.n_contacts)
    assert same_state(whole, parts)
    for a, b in zip(logged(whole), logged(parts), strict=True):
        assert np.array_equal(a, b)


def test_damaged_bytes_are_refused() -> None:
    saved = engine([[1.0, 1.0]], [[1.0, 0.0]], box=3.0).save()
    flipped = bytearray(saved)
    flipped[len(saved) // 2] ^= 1
    for bad in (b"", b"hardlimit", saved[:-1], saved[: len(saved) // 2], bytes(flipped)):
        with pytest.raises(ValueError, match="saved: got"):
            _core.load_engine("hard_spheres", bad)


@pytest.mark.parametrize("restitution", [1e-3, 0.01, 0.05, 0.07])
@pytest.mark.parametrize("drift", [0.0, 0.3])
def test_collapse_of_three_in_line(restitution: float, drift: float) -> None:
    """Below ε = 7 − 4√3 three balls in line collapse (McNamara & Young 1992)."""
    position = [[1.0, 5.0, 5.0], [3.5, 5.0, 5.0], [5.5, 5.0, 5.0]]
    velocity = [[1.0 + drift, 0.0, 0.0], [drift, 0.0, 0.0], [drift - 1.0, 0.0, 0.0]]
    run = engine(position, velocity, radius=1.0, box=20.0, restitution=restitution)
    run.advance(10.0)
    assert run.outcome == "collapse"
    time, (first, second), wall = run.early_end
    assert wall is None and 0.1 < time < 1.0 and run.time == time
    assert (first, second) in {(0, 1), (1, 2)}
    run.advance(20.0)
    assert run.time == time


def test_above_the_critical_restitution_three_in_line_part() -> None:
    position = [[1.0, 5.0], [3.5, 5.0], [5.5, 5.0]]
    run = engine(position, [[1.0, 0.0], [0.0, 0.0], [-1.0, 0.0]], radius=1.0, box=20.0, restitution=0.15)
    run.advance(5.0)
    assert run.outcome == "ok" and run.time == 5.0


@pytest.mark.parametrize("restitution", [0.3, 0.9, 0.99])
def test_collapse_of_a_ball_on_a_floor(restitution: float) -> None:
    options = {"periodic": False, "gravity": [0.0, -9.81], "restitution": restitution}
    run = engine([[1.0, 2.0]], [[0.0, 0.0]], box=[2.0, 9.0], **options)
    run.advance(1e3)
    fall = math.sqrt(2.0 * 1.5 / 9.81)
    assert run.outcome == "collapse"
    assert run.early_end[1:] == ([0], -3)
    assert run.time == pytest.approx(fall * (1.0 + 2.0 * restitution / (1.0 - restitution)), rel=1e-6)


def test_a_cluster_under_gravity_collapses_or_goes_on_with_tc() -> None:
    position, velocity, edge = packed(60, 0.3, dimension=2, periodic=False)
    system = {"box": edge, "periodic": False, "gravity": [0.0, -5.0], "log": False}
    collapsing = engine(position, velocity, restitution=0.3, **system)
    collapsing.advance(100.0)
    assert collapsing.outcome == "collapse"
    running = engine(position, velocity, rule="tc", restitution=0.5, contact_duration=5e-3, **system)
    running.advance(2.0)
    assert running.outcome == "ok" and running.time == 2.0
    assert running.statistics()["n_elastic_by_tc"] > running.n_contacts // 2


def test_what_does_not_move_ends_in_time() -> None:
    still = engine([[1.0, 1.0], [3.0, 1.0]], np.zeros((2, 2)), box=5.0)
    still.advance(7.0)
    assert (still.time, still.n_contacts, still.outcome) == (7.0, 0, "ok")
    alone = engine([[0.5, 2.5]], [[1.0, -0.5]], box=5.0)
    alone.advance(1e3)
    assert alone.n_contacts == 0
    np.testing.assert_allclose(alone.state()[0], [[1000.5, -497.5]], rtol=1e-13)


def test_touching_particles_at_the_start() -> None:
    run = engine([[1.0, 1.0], [2.0, 1.0]], [[1.0, 0.0], [-1.0, 0.0]], box=9.0)
    run.advance(1.0)
    time, first, second, speed, _ = logged(run)
    assert (time[0], first[0], second[0], speed[0]) == (0.0, 0, 1, 2.0)
    assert run.n_contacts == 1
    apart = engine([[1.0, 1.0], [2.0, 1.0]], [[-1.0, 0.0], [1.0, 0.0]], box=9.0)
    apart.advance(1.0)
    assert apart.n_contacts == 0


@pytest.mark.parametrize("edge", [1.05, 1.7, 2.01, 2.6, 3.3, 4.2])
def test_boxes_of_a_few_diameters(edge: float) -> None:
    """Two particles collide repeatedly across periodic boundaries, as in the slow engine."""
    position = np.array([[0.1 * edge, 0.2 * edge, 1.0], [0.6 * edge, 0.7 * edge, 3.0]])
    velocity = np.array([[0.3, -0.2, 0.9], [-0.5, 0.4, -0.8]])
    box = np.array([edge, edge, 6.0])
    run = engine(position, velocity, box=box)
    run.advance(math.inf, 4)
    particles = position, velocity, np.full(2, 0.5), np.ones(2), box
    slow = SlowHardSpheres(*particles, ("periodic",) * 3, np.zeros(3), Rule("constant", 1.0))
    slow.advance(math.inf, 4)
    np.testing.assert_allclose(logged(run)[0], [row[0] for row in slow.log], rtol=1e-7)


@pytest.mark.slow
def test_size_ratio_of_a_hundred() -> None:
    rng = np.random.default_rng(2)
    radius = np.concatenate([[1.0, 0.3], np.full(30, 0.03), np.full(60, 0.01)])
    box = [3.0] * 3
    position = grow_packing(radius, box, [True] * 3, 3)
    velocity = rng.standard_normal((len(radius), 3)) * 5.0
    velocity[:2] *= 4.0
    mass = (radius / 0.3) ** 3
    run = engine(position, velocity, radius=radius, mass=mass, box=box)
    run.advance(math.inf, 80)
    slow = SlowHardSpheres(
        position, velocity, radius, mass, np.array(box), ("periodic",) * 3, np.zeros(3), Rule("constant", 1.0)
    )
    slow.advance(math.inf, 80)
    _, first, second, *_ = logged(run)
    assert list(zip(first, second, strict=True)) == [row[1:3] for row in slow.log]


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("periodic", [True, False])
def test_no_overlap_among_two_very_unequal_sizes(dimension: int, periodic: bool) -> None:
    """Searches for small particles around large ones leave out none, in rows of cells of any length."""
    radius = np.concatenate([np.full(60, 0.1), np.full(500, 0.02)])
    box = [{2: 2.8, 3: 1.3}[dimension]] * dimension
    kinds = [periodic, *[True] * (dimension - 1)]
    position = grow_packing(radius, box, kinds, 4)
    velocity = np.random.default_rng(5).standard_normal(position.shape)
    # Equal masses: a collision with a small one turns a large one.
    run = engine(position, velocity, radius=radius, mass=np.ones(len(radius)), box=box, periodic=kinds)
    for _ in range(50):
        run.advance(math.inf, 300)
        apart = (x := run.state()[0])[:60, None] - x
        apart -= np.where(kinds, np.round(apart / box) * box, 0.0)
        distance = np.linalg.norm(apart, axis=-1) + np.eye(60, len(radius))
        assert np.min(distance / (radius[:60, None] + radius)) > 1.0 - 1e-9


@pytest.mark.parametrize(
    "law",
    [
        ("viscoelastic", 0, [1e6, 0.3, 1e-4], None),
        ("tsuji", 0, [1e5, 0.7], None),
        ("linear", 0, [1e4, 0.6], None),
    ],
)
def test_restitution_follows_the_law(law: tuple) -> None:
    contact = _core.make_contact(*law[:3], 0.5, 0.25)
    speeds = np.geomspace(1e-6, 1e3, 60)
    speeds = speeds[contact.compression(speeds) < 0.2]  # within the range of the law
    assert len(speeds) > 40
    for speed in speeds:
        run = engine([[1.0, 1.0], [3.0, 1.0]], [[speed, 0.0], [0.0, 0.0]], box=9.0, rule="law", law=law)
        run.advance(math.inf, 1)
        after = run.state()[1][:, 0]
        restitution = (after[1] - after[0]) / speed
        assert restitution == pytest.approx(contact.restitution(np.array([speed]))[0], rel=1e-13)


@pytest.mark.parametrize(
    ("n", "dimension", "fraction", "spread", "periodic"),
    [
        (1, 3, 0.1, 1.0, True),
        (2, 2, 0.3, 1.0, False),
        (300, 3, 0.15, 1.0, True),
        (100, 3, 0.62, 1.0, True),
        (150, 2, 0.82, 1.0, True),
        (80, 3, 0.45, 1.0, False),
        (80, 3, 0.58, 3.0, True),
    ],
)
def test_random_packings_do_not_overlap(
    n: int, dimension: int, fraction: float, spread: float, periodic: bool
) -> None:
    radius = 0.01 * np.random.default_rng(n).uniform(1.0, spread, n)
    volume = np.sum(4.0 / 3.0 * math.pi * radius**3 if dimension == 3 else math.pi * radius**2)
    edge = float((volume / fraction) ** (1.0 / dimension))
    sides, kinds = [edge] * dimension, [periodic] * dimension
    position = grow_packing(radius, sides, kinds, 11)
    assert np.array_equal(position, grow_packing(radius, sides, kinds, 11))
    assert position.min() >= 0.0
    assert position.max() <= edge
    apart = position[:, None] - position[None]
    if periodic:
        apart -= edge * np.round(apart / edge)
    else:
        assert np.all(position >= radius[:, None])
        assert np.all(position <= edge - radius[:, None])
    gap = np.linalg.norm(apart, axis=-1) - radius[:, None] - radius[None]
    assert np.all(gap[~np.eye(n, dtype=bool)] >= 0.0)
    if n > 2:
        assert not np.array_equal(position, grow_packing(radius, sides, kinds, 12))


def test_packings_that_cannot_be_are_refused() -> None:
    with pytest.raises(ValueError, match="packing_fraction: got"):
        grow_packing(np.full(40, 0.5), [2.0] * 3, [True] * 3, 1)
    with pytest.raises(ValueError, match="system: got"):
        grow_packing(np.full(1, 0.5), [2.0, 2.0, 0.9], [True] * 3, 1)


GOOD = {"position": [[1.0, 1.0], [3.0, 1.0]], "velocity": [[1.0, 0.0], [0.0, 0.0]], "box": 5.0}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"position": [[1.0, 1.0], [5.1, 1.0]]}, "system: got values of particle 1"),
        ({"position": [[1.0, 1.0], [math.nan, 1.0]]}, "system: got values of particle 1"),
        ({"velocity": [[1.0, math.inf], [0.0, 0.0]]}, "system: got values of particle 0"),
        ({"radius": 0.0}, "system: got values of particle 0"),
        ({"mass": -1.0}, "system: got values of particle 0"),
        ({"box": [0.9, 5.0], "position": [[0.5, 1.0], [0.5, 3.0]]}, "system: got values of particle 0"),
        ({"rule": "law"}, "law: got None"),
        ({"rule": "bounce"}, "rule: got bounce"),
        ({"rule": "law", "law": ("rubber", 0, [1.0], None)}, "law: got rubber"),
    ],
)
def test_bad_systems_are_refused_in_one_line(change: dict, message: str) -> None:
    with pytest.raises(ValueError, match=message) as refusal:
        engine(**(GOOD | change))
    assert "\n" not in str(refusal.value)


@contextmanager
def interrupted_after(seconds: float) -> Iterator[None]:
    """The block must end by the KeyboardInterrupt of a timer, as by that of Ctrl-C."""
    previous = signal.signal(signal.SIGALRM, signal.default_int_handler)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        with pytest.raises(KeyboardInterrupt):
            yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, previous)


@pytest.mark.parametrize(("n", "fraction", "dimension"), [(30_000, 0.61, 3), (30_000, 0.82, 2)])
@pytest.mark.parametrize("seconds", [0.08, *map(slow, (0.15, 0.3, 0.5, 0.8))])
def test_ctrl_c_ends_a_random_start(n: int, fraction: float, dimension: int, seconds: float) -> None:
    """No progress is reported while the exception is pending: Python would turn it into a SystemError."""
    box = box_of([edge_of(n, fraction, dimension)] * dimension, True)
    with interrupted_after(seconds):
        _core.grow_packing(box, np.full(n, 0.5), 1, lambda share, collisions: None)


def test_interrupted_runs_go_on_with_the_same_bits() -> None:
    position, velocity, edge = packed(200, 0.4)
    run = engine(position, velocity, box=edge, log=False)
    with interrupted_after(0.3):
        run.advance(1e9)
    assert run.n_contacts > 0
    rows = run.n_contacts + 1000
    run.advance(math.inf, 1000)
    whole = engine(position, velocity, box=edge, log=False)
    whole.advance(math.inf, rows)
    assert same_state(run, whole)


def test_progress_of_a_packing_is_told_and_its_exceptions_end_the_call() -> None:
    told: list[tuple[float, int]] = []

    def progress(share: float, collisions: int) -> None:
        told.append((share, collisions))
        if len(told) == 2:
            raise RuntimeError("enough")

    bounds = box_of([6.0] * 3, True)
    with pytest.raises(RuntimeError, match="enough"):
        _core.grow_packing(bounds, np.full(200, 0.5), 1, progress)
    assert told == sorted(told) and told[-1][1] > 0


def test_a_box_names_its_walls() -> None:
    bounds = box_of([2.0, 3.0, 4.0], [False, True, False], [0.0, 0.0, -9.81])
    assert bounds.boundary == ("wall", "periodic", "wall")
    assert bounds.walls() == [(-1, 0.0, 0.0), (-2, 2.0, 0.0), (-5, 0.0, 0.0), (-6, 4.0, 0.0)]
    assert (bounds.edges, bounds.gravity) == ([2.0, 3.0, 4.0], [0.0, 0.0, -9.81])
    for edges, sides, message in (
        ([1.0], ["wall"], "box: got 1 edges"),
        ([1.0, 1.0], ["wall"], "boundary: got 1 values, must be 2"),
        ([1.0, 1.0], ["wall", "open"], "boundary: got open, must be a known word"),
    ):
        with pytest.raises(ValueError, match=message):
            _core.Box(edges, sides)


@pytest.mark.slow
def test_cells_of_particles_that_jump_in_a_sheared_box(tmp_path: Path) -> None:
    """The part alone: each particle is in its cell, and the boundary does the work of the crossings."""
    printed = output_of("boxes/cell_assignment.cpp", tmp_path).split()
    jumps, crossings, wrong = map(int, printed[:3])
    assert jumps > 20_000 and crossings > 3_000 and wrong == 0
    assert all(abs(float(error)) < 1e-12 for error in printed[3:])
