"""Walls with a constant velocity: exact collisions, Galilean invariance and the energy balance, in all engines."""

import itertools
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from hardlimit import _core

LINEAR = ("linear", 0, [1e6, 0.8], None)
VISCOELASTIC = ("viscoelastic", 1, [1e8, 0.3, 0.7, 1.0], None)

#: Arguments of each engine, and the relative error of its energies.
ENGINES: dict[str, tuple[dict[str, Any], float]] = {
    "constant": ({"kind": "hard_spheres", "rule": "constant", "restitution": 0.9}, 1e-12),
    "tc": ({"kind": "hard_spheres", "rule": "tc", "restitution": 0.9, "rule_parameters": [1e-4]}, 1e-12),
    "law": ({"kind": "hard_spheres", "rule": "law", "law": VISCOELASTIC}, 1e-12),
    "soft": ({"kind": "hard_spheres", "rule": "soft", "law": LINEAR}, 1e-12),
    "events, linear": ({"kind": "newton_events", "law": LINEAR}, 1e-10),
    "events, viscoelastic": ({"kind": "newton_events", "law": VISCOELASTIC}, 1e-10),
    "steps, linear": ({"kind": "newton_steps", "law": LINEAR, "time_step": 2e-6}, 1e-4),
    "steps, viscoelastic": ({"kind": "newton_steps", "law": VISCOELASTIC, "time_step": 2e-6}, 1e-4),
}
each_engine = pytest.mark.parametrize("name", ENGINES)


def engine(
    name: str,
    positions: ArrayLike,
    velocities: ArrayLike,
    edges: ArrayLike,
    walls: list[tuple[float, float]],
    *,
    gravity: list[float] | None = None,
    boundary: list[str] | None = None,
    radius: ArrayLike = 0.01,
    **changed: Any,
) -> _core.Engine:
    x, v = np.array(positions, float), np.array(velocities, float)
    n, d = x.shape
    settings = ENGINES[name][0] | changed
    kind = settings.pop("kind")
    moving = [
        (-1 - 2 * axis - upper, 0.0, speed, 0.0, 0.0, 0.0, "none")
        for axis, speeds in enumerate(walls)
        for upper, speed in enumerate(speeds)
        if speed
    ]
    box = _core.Box(list(map(float, np.broadcast_to(edges, d))), boundary or ["wall"] * d, gravity, moving)
    r = np.broadcast_to(radius, n).astype(float)
    return _core.make_engine(kind, box, x, v, r, 1e4 * r**3, log=True, **settings)


def energy(run: _core.Engine) -> float:
    """What the walls have done plus the initial energy: constant."""
    seen = run.observe()
    parts = ("kinetic_energy", "potential_energy", "contact_energy", "dissipated_energy")
    return float(sum(seen[part] for part in parts)) - float(seen["wall_work"])


def lattice(
    per_axis: int, d: int, spacing: float, seed: int, speed: float = 1.0
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Positions on a square lattice, a little displaced, in a box of per_axis spacings, and random velocities."""
    random = np.random.default_rng(seed)
    x = np.array(list(itertools.product(range(per_axis), repeat=d)), float)
    x = (x + 0.5 + 0.1 * random.uniform(-1.0, 1.0, x.shape)) * spacing
    return x, speed * random.standard_normal(x.shape)


@each_engine
@pytest.mark.parametrize("high", [False, True])
@pytest.mark.parametrize("speed", [0.5, -0.3])
def test_one_ball_and_a_piston(name: str, high: bool, speed: float) -> None:
    """v' − V = −ε(v − V); the wall does the work m(v' − v)V."""
    inward = -1.0 if high else 1.0
    walls = [(0.0, speed * inward) if high else (speed * inward, 0.0), (0.0, 0.0)]
    v = -2.0 * inward
    run = engine(name, [[0.5, 0.5]], [[v, 0.0]], 1.0, walls)
    run.advance(0.35)
    log = run.take_log()
    begin = float(log.get("begin", log.get("time"))[0])
    touch = (0.5 - 0.01) / (2.0 + speed)
    accuracy = ENGINES[name][1]
    assert len(log["first"]) == 1 and log["second"][0] == (-2 if high else -1)
    assert begin == pytest.approx(touch, rel=10 * accuracy)
    approach, separation = float(log["impact_speed"][0]), float(log["separation_speed"][0])
    assert approach == pytest.approx(2.0 + speed, rel=10 * accuracy)
    after = float(run.state()[1][0, 0])
    assert after == pytest.approx(inward * (separation + speed), rel=10 * accuracy)
    if name == "constant":
        assert separation == pytest.approx(0.9 * approach, rel=1e-14)
    mass = 1e4 * 0.01**3
    work = float(run.observe()["wall_work"])
    assert work == pytest.approx(mass * (after - v) * speed * inward, rel=10 * accuracy)
    assert energy(run) == pytest.approx(0.5 * mass * v * v, rel=accuracy)


@each_engine
@pytest.mark.parametrize("gravity", [0.0, -9.81])
def test_compression_and_expansion(name: str, gravity: float) -> None:
    """Pistons pass many cells inwards, and leave the first box outwards; the balance closes and no one escapes."""
    x, v = lattice(5, 2, 0.03, seed=3)
    walls = [(0.5, -0.8), (-0.6, 0.4)]
    finer: dict[str, Any] = {"time_step": 4e-7} if "steps" in name else {}
    run = engine(name, x, v, 0.15, walls, gravity=[0.0, gravity], radius=0.006, **finer)
    start = energy(run)
    for time in (0.01, 0.02, 0.03):
        run.advance(time)
        assert run.outcome == "ok"
        positions = run.state()[0]
        for axis, (low, high) in enumerate(walls):
            depth = 0.001 + (0.006 if name == "soft" else 0.0)  # compressed contacts; equivalent collisions
            assert (positions[:, axis] > low * time + 0.006 - depth).all()
            assert (positions[:, axis] < 0.15 + high * time - 0.006 + depth).all()
        scale = float(run.observe()["kinetic_energy"])
        assert energy(run) == pytest.approx(start, abs=ENGINES[name][1] * scale)
    assert run.observe()["wall_work"] != 0.0


@pytest.mark.parametrize("name", [name for name in ENGINES if "events" in name])
def test_a_chain_pressed_by_two_pistons(name: str) -> None:
    """A cluster touches two walls of different velocities, which both do work on it."""
    x = [[0.01 + 0.0200001 * k, 0.05] for k in range(4)]
    run = engine(name, x, np.zeros((4, 2)), [0.0800004, 0.1], [(0.1, -0.2), (0.0, 0.0)])
    for time in (1e-3, 2e-3, 4e-3):
        run.advance(time)
        assert run.outcome == "ok"
        seen = run.observe()
        total = sum(float(seen[part]) for part in ("kinetic_energy", "contact_energy", "dissipated_energy"))
        assert total == pytest.approx(float(seen["wall_work"]), rel=1e-9)
    assert seen["n_in_contact"] > 2


def test_a_ball_rests_on_a_piston_that_rises() -> None:
    """Weight times distance is the work of the piston."""
    run = engine(
        "events, linear", [[0.5, 0.0101]], [[0.0, 0.5]], 1.0, [(0.0, 0.0), (0.5, 0.0)], gravity=[0.0, -9.81]
    )
    run.advance(0.5)
    work = float(run.observe()["wall_work"])
    run.advance(0.7)
    assert run.observe()["n_in_contact"] == 1
    assert float(run.observe()["wall_work"]) - work == pytest.approx(0.01 * 9.81 * 0.5 * 0.2, rel=1e-6)


@pytest.mark.parametrize(
    ("motion", "message"),
    [
        ((-3, 0.0, 1.0, 0.0, 0.0, 0.0, "none"), "moving_walls: got the number -3, must be that of a wall"),
        ((-1, 0.0, 0.0, 1.0, 1.0, 0.0, "saw"), "moving_walls: got saw, must be a known word"),
    ],
)
def test_a_motion_of_no_wall_or_waveform_is_refused(motion: tuple[Any, ...], message: str) -> None:
    with pytest.raises(ValueError, match=f"^{message}$"):
        _core.Box([1.0, 1.0], ["wall", "periodic"], None, [motion])


@pytest.mark.parametrize("seed", [13, 14, 26])
def test_dissipation_does_not_depend_on_when_lists_are_rebuilt(seed: int) -> None:
    """A faster frame rebuilds neighbour lists more often, which may list the bodies of a contact in either order."""
    x, v = lattice(4, 3, 0.025, seed)
    radius = np.where(np.arange(64) % 3 == 0, 0.007, 0.01)
    dissipated = []
    for drift in (0.0, 1.3):
        periodic = ["periodic"] * 3
        run = engine("steps, viscoelastic", x, v + drift, 0.1, [], boundary=periodic, radius=radius)
        run.advance(0.006)
        dissipated.append(run.observe()["dissipated_energy"])
    assert dissipated[0] == pytest.approx(dissipated[1], rel=1e-9)
