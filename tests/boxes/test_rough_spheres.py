"""Hard spheres with spins: rules with friction, against independent runs, conservation laws and limits."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hardlimit as hl
from conftest import DATA, output_of

CASES = json.loads((DATA / "friction.json").read_text(encoding="utf-8"))["event_driven"]
LINEAR = hl.LinearDashpot(
    stiffness=2000.0, restitution=0.8, friction=hl.Friction(0.4, stiffness_ratio=0.9, damping_ratio=0.3)
)
SLOW_IMPACT = hl.Viscoelastic(
    youngs_modulus=1e7,
    poisson_ratio=0.3,
    dissipative_time=1e-5,
    friction=hl.Friction(0.3, model="mindlin_rescale", stiffness_ratio=0.8),
)
RULES: dict[str, dict[str, Any]] = {
    "rough": {"restitution": 0.9, "friction": math.inf, "tangential_restitution": 0.4},
    "Walton": {"restitution": 0.8, "friction": 0.3, "tangential_restitution": 0.5},
    "tc": {
        "restitution": 0.8,
        "friction": 0.3,
        "tangential_restitution": 0.5,
        "rule": "tc",
        "contact_duration": 1e-3,
    },
    "linear law": {"law": LINEAR},
    "viscoelastic law": {"law": SLOW_IMPACT},
    "soft": {"law": LINEAR, "rule": "soft"},
}
BOXES: dict[str, dict[str, Any]] = {
    "periodic": {},
    "disks": {"dimension": 2},
    "sizes": {"radius": (0.5e-3, 1.5e-3), "inertia_factor": np.linspace(0.2, 0.6, 60)},
    "walls": {"boundary": "wall"},
    "gravity": {"boundary": ("periodic", "wall", "wall"), "gravity": (0.0, 0.0, -9.81)},
    "shaken": {"boundary": "wall", "walls": {"z-": hl.MovingWall(amplitude=0.3e-3, frequency=60.0)}},
    "sheared": {"boundary": ("periodic", "lees-edwards", "periodic"), "shear_rate": 50.0},
    "sheared disks": {"dimension": 2, "boundary": ("periodic", "lees-edwards"), "shear_rate": 50.0},
}


def start(n: int = 60, fraction: float = 0.15, **settings: Any) -> hl.ParticleSystem:
    base = {"radius": 1e-3, "density": 2500.0, "rms_speed": 0.1, "rms_spin": 100.0, "seed": 3}
    return hl.ParticleSystem.random(n, fraction, **(base | settings))


def energies(run: hl.ParticleResult) -> np.ndarray:
    """Kinetic and rotational energy, and what was lost, less the work done [J]."""
    series = run.series
    total = series.kinetic_energy + series.rotational_energy + series.dissipated_energy
    return np.asarray(total + series.potential_energy - series.wall_work - series.shear_work)


def spins(run: hl.ParticleResult | hl.ContactResult) -> np.ndarray:
    return np.asarray(run.system.angular_velocities)


def reference_start(case: dict[str, Any]) -> hl.ParticleSystem:
    names = (
        "positions",
        "velocities",
        "radius",
        "mass",
        "box",
        "gravity",
        "angular_velocities",
        "inertia_factor",
    )
    boundary, sheared = case["boundary"], "shear_rate" in case
    if sheared:
        boundary = ["periodic", "lees-edwards"]
    rate = {"shear_rate": case["shear_rate"]} if sheared else {}
    return hl.ParticleSystem(**{name: case[name] for name in names}, boundary=boundary, **rate)


@pytest.mark.parametrize("case", CASES, ids=[f"{k}-{c['kind']}" for k, c in enumerate(CASES)])
def test_independent_run(case: dict[str, Any]) -> None:
    """Collisions and final state of a brute-force program in quadruple precision."""
    mu = math.inf if case["friction"] is None else case["friction"]
    run = hl.event_driven(
        reference_start(case),
        restitution=case["restitution"],
        friction=mu,
        tangential_restitution=case["tangential_restitution"],
        max_collisions=len(case["log"]),
        log=True,
    )
    rows = np.array(case["log"])
    ours, tolerance = run.collisions, 10.0 * case["tolerance"]
    assert len(ours.time) == len(rows)
    for k, name in ((1, "first"), (2, "second"), (5, "slid")):
        assert np.array_equal(ours[name], rows[:, k])
    for k, name in ((0, "time"), (3, "impact_speed"), (4, "tangential_speed")):
        assert np.abs(ours[name].to_numpy() - rows[:, k]).max() < tolerance * np.abs(rows[:, k]).max()
    system = run.system
    assert system.angular_velocities is not None
    for name in ("velocities", "angular_velocities"):
        expected = np.array(case[f"end_{name}"])
        assert np.abs(getattr(system, name) - expected).max() < tolerance * np.abs(expected).max()
    last = run.series.isel(time=-1)
    for name, known in (("kinetic", "translational"), ("rotational", "rotational")):
        assert float(last[f"{name}_energy"]) == pytest.approx(case[f"{known}_energy"], rel=tolerance)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("box", BOXES)
def test_energy_balance(box: str, rule: str) -> None:
    """Kinetic, rotational and lost energy add up to the work; friction never gains energy."""
    run = hl.event_driven(start(**BOXES[box]), **RULES[rule], max_collisions=600, samples=5)
    total = energies(run)
    assert np.abs(total - total[0]).max() < 2e-13 * np.abs(total).max() + 1e-14 * abs(total[0])
    assert float(run.series.friction_loss[-1]) > 0.0
    assert np.all(np.diff(run.series.dissipated_energy) >= 0.0)


@pytest.mark.parametrize("rule", RULES)
def test_momentum(rule: str) -> None:
    """Linear momentum, and without boundaries angular momentum."""
    cluster = start(30, 0.2, seed=5)
    middle = 0.5 * np.asarray(cluster.box)
    system = hl.ParticleSystem(
        cluster.positions + 1.0 - middle,
        -30.0 * (cluster.positions - middle) + cluster.velocities,
        cluster.radius,
        mass=cluster.mass,
        box=2.0,
        angular_velocities=cluster.angular_velocities,
        inertia_factor=cluster.inertia_factor,
    )

    def angular_momentum(s: hl.ParticleSystem) -> np.ndarray:
        assert s.angular_velocities is not None and s.inertia_factor is not None
        inertia = s.inertia_factor * s.mass * s.radius**2
        orbital = np.cross(s.positions - 1.0, s.mass[:, None] * s.velocities)
        return np.asarray((orbital + inertia[:, None] * s.angular_velocities).sum(axis=0))

    def momentum(s: hl.ParticleSystem) -> np.ndarray:
        return np.asarray((s.mass[:, None] * s.velocities).sum(axis=0))

    run = hl.event_driven(system, **RULES[rule], until=0.02)
    assert run.n_collisions > 20
    scale = float(np.sum(system.mass * np.linalg.norm(system.velocities, axis=1)))
    assert np.abs(momentum(run.system) - momentum(system)).max() < 1e-14 * scale
    error = 1e-13 if rule != "soft" else 1e-11  # that of the contact's integration
    assert np.abs(angular_momentum(run.system) - angular_momentum(system)).max() < error * scale * middle[0]


@pytest.mark.parametrize("beta0", [-1.0, 0.3])
def test_one_collision(beta0: float) -> None:
    """Both speeds after a collision, and the loss of its tangential part, for unequal bodies."""
    rng = np.random.default_rng(1)
    for mu in (0.05, 0.5, math.inf):
        r, m, q = rng.uniform(1e-3, 2e-3, 2), rng.uniform(1e-5, 2e-5, 2), rng.uniform(0.2, 0.7, 2)
        n = rng.standard_normal(3)
        n /= np.linalg.norm(n)
        x = np.array([[0.05] * 3, 0.05 + 1.001 * (r[0] + r[1]) * n])
        v = np.array([0.2 * n, -0.1 * n]) + 1e-3 * rng.standard_normal((2, 3))
        w = 100.0 * rng.standard_normal((2, 3))
        before = hl.ParticleSystem(x, v, r, mass=m, box=0.1, angular_velocities=w, inertia_factor=q)
        run = hl.event_driven(
            before, restitution=0.8, friction=mu, tangential_restitution=beta0, max_collisions=1, log=True
        )
        after, row = run.system, run.collisions
        assert after.angular_velocities is not None
        n = after.positions[1] - after.positions[0]
        n /= np.linalg.norm(n)

        def surface(velocities: Any, spins: Any, n: Any = n, r: Any = r) -> Any:
            return velocities[1] - velocities[0] - np.cross(r[0] * spins[0] + r[1] * spins[1], n)

        g, gone = surface(v, w), surface(after.velocities, after.angular_velocities)
        normal, slip = -float(g @ n), g - (g @ n) * n
        m_n = m[0] * m[1] / (m[0] + m[1])
        ratio = 1.0 + m_n * float(np.sum(1.0 / (q * m)))
        beta = min(beta0, -1.0 + ratio * mu * 1.8 * normal / float(np.linalg.norm(slip)))
        assert float(gone @ n) == pytest.approx(0.8 * normal, rel=1e-12)
        assert gone - (gone @ n) * n == pytest.approx(-beta * slip, abs=1e-12)
        assert float(row.tangential_restitution[0]) == pytest.approx(beta, abs=1e-13)
        assert bool(row.slid[0]) == (beta < beta0)
        loss = float(run.series.friction_loss[-1])
        assert loss == pytest.approx(0.5 * m_n / ratio * (1 - beta**2) * float(slip @ slip), rel=1e-12)


@pytest.mark.parametrize("box", BOXES)
@pytest.mark.parametrize("rule", ["constant", "tc"])
def test_smooth_limit(box: str, rule: str) -> None:
    """β0 = −1 gives the bits of smooth spheres, and the spins stay."""
    system = start(**BOXES[box])
    settings: dict[str, Any] = {"restitution": 0.9, "max_collisions": 500, "log": True, "rule": rule}
    if rule == "tc":
        settings["contact_duration"] = 1e-3
    smooth = hl.event_driven(system, **settings)
    rough = hl.event_driven(system, **settings, friction=0.5, tangential_restitution=-1.0)
    assert np.array_equal(smooth.system.velocities, rough.system.velocities)
    assert np.array_equal(smooth.system.positions, rough.system.positions)
    assert np.array_equal(smooth.collisions.time, rough.collisions.time)
    assert np.array_equal(spins(rough), np.asarray(system.angular_velocities))
    for name in ("kinetic_energy", "dissipated_energy", "virial_tensor"):
        if name in smooth.series:
            assert np.array_equal(smooth.series[name], rough.series[name])


@pytest.mark.parametrize("mu", [-1.0, math.nan, "a"])
def test_bad_friction_does_not_say_that_it_must_be_finite(mu: Any) -> None:
    """Rough spheres have an infinite one."""
    with pytest.raises(ValueError, match=r"friction: got .*, must be (a number )?>= 0$"):
        hl.event_driven(start(), restitution=0.9, friction=mu, tangential_restitution=0.5, max_collisions=1)


@pytest.mark.parametrize("rule", ["linear law", "viscoelastic law", "soft"])
def test_small_friction(rule: str) -> None:
    """A law with μ = 1e-14 collides as without friction."""
    law = RULES[rule]["law"]
    tiny = law.replace(friction=hl.Friction(1e-14, stiffness_ratio=0.9))
    settings = {**RULES[rule], "max_collisions": 100}
    system = start(40)
    rough = hl.event_driven(system, **{**settings, "law": tiny}).system
    smooth = hl.event_driven(system, **{**settings, "law": law.replace(friction=None)}).system
    assert rough.velocities == pytest.approx(smooth.velocities, abs=1e-9)


@pytest.mark.parametrize("name", ["linear law", "viscoelastic law"])
def test_restitution_of_the_contact(name: str) -> None:
    """β of each collision is that of the exact contact at its speed and angle."""
    law = RULES[name]["law"]
    system = start(60, boundary=("periodic", "periodic", "wall"))
    run = hl.event_driven(system, law=law, max_collisions=150, log=True)
    ball = hl.Ball(float(system.radius[0]), mass=float(system.mass[0]))
    for row in range(0, 150, 5):
        wall = int(run.collisions.second[row]) < 0
        contact = law.between(ball, hl.FLOOR if wall else ball)
        speed, slip = (float(run.collisions[c][row]) for c in ("impact_speed", "tangential_speed"))
        expected = contact.impact(speed, slip).tangential_restitution
        assert float(run.collisions.tangential_restitution[row]) == pytest.approx(expected, abs=1e-10)


def test_elastic_grains_that_rub_may_collapse_for_the_rule() -> None:
    """Then the advice is another rule; without friction there is no room at ε = 1."""
    rough = {"friction": 0.5, "tangential_restitution": 0.3}
    for surfaces, key in (({}, "no_room"), (rough, "collapse")):
        run = hl.event_driven(start(), restitution=1.0, max_collisions=3, **surfaces)
        object.__setattr__(run, "outcome_name", "collapse")
        assert run.outcome == run.outcomes[key]


@pytest.mark.slow
def test_tables_in_two_numbers(tmp_path: Path) -> None:
    """Hertz contacts: the error is 5e-8; without tables it would be 0."""
    lines = output_of("boxes/tangential_surface.cpp", tmp_path).splitlines()
    assert len(lines) == 6
    for contacts, worst, other_slip in (map(float, line.split()) for line in lines):
        assert contacts == 1000 and 0.0 < worst < 1e-7 and other_slip == 0


@pytest.mark.slow
def test_a_long_run_uses_tables_and_resumes(tmp_path: Path) -> None:
    """From 30000 collisions on. More than 16 sizes, which share a table."""
    system = start(2000, 0.3, radius=(0.8e-3, 1.2e-3), rms_speed=1.0)
    settings = {"law": SLOW_IMPACT, "log": True}
    whole = hl.event_driven(system, **settings, max_collisions=31_500)
    hl.event_driven(system, **settings, max_collisions=31_000, checkpoint=tmp_path / "run")
    resumed = hl.resume(tmp_path / "run", max_collisions=31_500)
    assert np.array_equal(whole.system.velocities, resumed.system.velocities)
    log = whole.collisions.isel(collision=slice(-60, None))
    errors = []
    for row in range(60):
        bodies = [int(log[side][row]) for side in ("first", "second")]
        balls = [hl.Ball(float(system.radius[i]), mass=float(system.mass[i])) for i in bodies]
        impact = SLOW_IMPACT.between(*balls).impact(
            float(log.impact_speed[row]), float(log.tangential_speed[row])
        )
        errors.append(abs(float(log.tangential_restitution[row]) - impact.tangential_restitution))
    assert max(errors) < 1e-7 and np.median(errors) > 1e-14
