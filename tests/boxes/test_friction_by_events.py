"""Laws with friction in the event-driven engine for Newton's equations."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import hardlimit as hl
from box_engines import core_engine
from conftest import DATA, output_of
from hardlimit import _core
from hardlimit.boxes.contacts import law_arguments
from hardlimit.boxes.falling_frame import spin_arguments
from hardlimit.contact.friction import MODELS

#: Solved in quadruple precision, by RK4 with located events (tests/data/README.md).
CASES = json.loads((DATA / "friction.json").read_text(encoding="utf-8"))["newton"]
SPRING = hl.Friction(0.3, stiffness_ratio=0.9)
Floats = NDArray[np.float64]


def linear(friction: hl.Friction, restitution: float = 0.9, stiffness: float = 1e5) -> hl.LinearDashpot:
    return hl.LinearDashpot(stiffness=stiffness, restitution=restitution, friction=friction)


def engine(system: hl.ParticleSystem, law: hl.Law, **options: Any) -> _core.Engine:
    engine: _core.Engine = core_engine("newton_events", system, law, **spin_arguments(system), **options)
    return engine


def by_events(system: hl.ParticleSystem, law: hl.Law, until: float, **options: Any) -> hl.ContactResult:
    return hl.molecular_dynamics(system, law=law, until=until, engine="events", **options)


def cluster(dimension: int = 3) -> hl.ParticleSystem:
    """Five bodies that meet in the middle of a box and spin."""
    rng = np.random.default_rng(5)
    d = dimension
    directions = np.concatenate([np.zeros((1, d)), np.eye(d), -np.eye(d)])[:5]
    positions = 0.1 + 0.0205 * directions + 1e-4 * rng.uniform(-1.0, 1.0, directions.shape)
    velocities = -1.5 * directions + 0.3 * rng.standard_normal(directions.shape)
    spins = 100.0 * rng.standard_normal((5, 3))
    return hl.ParticleSystem(
        positions=positions,
        velocities=velocities,
        radius=0.01 * rng.uniform(0.8, 1.0, 5),
        mass=0.01 * rng.uniform(0.5, 1.0, 5),
        box=[0.2] * d,
        angular_velocities=spins if d == 3 else spins[:, 2],
    )


def gas(*, n: int = 40, dimension: int = 3, boundary: str = "periodic", seed: int = 2) -> hl.ParticleSystem:
    system = hl.ParticleSystem.random(
        n=n, packing_fraction=0.3, radius=(0.7e-3, 1e-3), density=2500.0, rms_speed=1.0, dimension=dimension,
        boundary=boundary, gravity=9.81 if boundary == "wall" else 0.0, seed=seed,
    )  # fmt: skip
    spins = 1e3 * np.random.default_rng(seed).standard_normal((n, 3))
    return spinning(system, spins if dimension == 3 else spins[:, 2])


def spinning(system: hl.ParticleSystem, spins: Floats) -> hl.ParticleSystem:
    names = ("positions", "velocities", "radius", "mass", "box", "boundary", "gravity")
    return hl.ParticleSystem(**{name: getattr(system, name) for name in names}, angular_velocities=spins)


def spins_of(system: hl.ParticleSystem) -> Floats:
    assert system.angular_velocities is not None
    return system.angular_velocities


def total_energy(seen: dict[str, Any]) -> float:
    parts = ("kinetic", "potential", "rotational", "contact", "dissipated")
    return float(sum(seen[f"{part}_energy"] for part in parts) - seen["wall_work"] - seen["shear_work"])


def angular_momentum(run: Any, system: hl.ParticleSystem) -> Floats:
    """Σ m x×v + I ω (3,)."""
    positions, velocities = (np.pad(a, ((0, 0), (0, 3 - a.shape[1]))) for a in run.state())
    orbital = np.cross(positions, system.mass[:, None] * velocities)
    return np.asarray((orbital + system.inertia[:, None] * run.spins()).sum(axis=0))


def engine_of(case: dict[str, Any], law: hl.Law) -> _core.Engine:
    """An engine from plain numbers: bodies may overlap with walls."""
    box = _core.Box(*(case[name] for name in ("box", "boundary", "gravity")))
    arrays = [np.array(case[name], float) for name in ("positions", "velocities", "radius", "mass")]
    spins = np.array(case["angular_velocities"], float).reshape(len(arrays[0]), -1)
    if spins.shape[1] == 1:
        spins = np.pad(spins, ((0, 0), (2, 0)))
    factors = np.full(len(spins), float(case["inertia_factor"]))
    arguments: dict[str, Any] = {
        "spins": spins,
        "inertia_factor": factors,
        "law": law_arguments(law),
        "log": True,
    }
    return _core.make_engine("newton_events", box, *arrays, **arguments)


def law_of(case: dict[str, Any]) -> hl.Law:
    friction = hl.Friction(
        math.inf if case["friction"] is None else case["friction"],
        stiffness=case["tangential_stiffness"],
        damping=case["tangential_damping"],
    )
    return linear(friction, case["restitution"], case["stiffness"])


@pytest.mark.parametrize("case", CASES, ids=[case["kind"] for case in CASES])
def test_reference_boxes(case: dict[str, Any]) -> None:
    """Every contact of the reference, and the state and energies at its end."""
    run = engine_of(case, law_of(case))
    run.advance(case["until"])
    log, still_open = run.take_log(), run.open_contacts()
    contacts = sorted(
        row for part in (log, still_open) for row in zip(*(part[k].tolist() for k in ROW), strict=True)
    )
    wanted = sorted(row[:4] for row in case["contacts"])
    assert [row[2:] for row in contacts] == [tuple(row[2:]) for row in wanted]
    for row, other in zip(contacts, wanted, strict=True):
        assert row[0] == pytest.approx(other[0], abs=1e-9 * case["until"])
        if other[1] is not None and other[1] <= case["until"]:
            assert row[1] == pytest.approx(other[1], abs=1e-8 * case["until"])
    positions, velocities = run.state()
    spins = run.spins() if case["dimension"] == 3 else run.spins()[:, 2]
    smallest, scale = min(case["radius"]), case["speed_scale"]
    tolerance = min(case["tolerance"], 2e-9)
    assert np.abs(positions - case["end_positions"]).max() < tolerance * smallest
    assert np.abs(velocities - case["end_velocities"]).max() < tolerance * scale
    assert np.abs(spins - case["end_angular_velocities"]).max() * smallest < tolerance * scale
    seen = run.observe()
    for name in ("kinetic_energy", "rotational_energy", "tangential_energy"):
        assert seen[name] == pytest.approx(case[name], rel=1e-8, abs=1e-9 * case["kinetic_energy"])
    normal = seen["contact_energy"] - seen["tangential_energy"]
    assert normal == pytest.approx(case["normal_energy"], rel=1e-8, abs=1e-9 * case["kinetic_energy"])


ROW = ("begin", "end", "first", "second")


def alone(row: list[Any], rows: list[list[Any]]) -> bool:
    """Whether no body of this contact is in another one meanwhile."""
    begin, end, *bodies = row[:4]
    return not any(
        other is not row
        and other[0] < end
        and (other[1] or math.inf) > begin
        and {body for body in bodies if body >= 0} & set(other[2:4])
        for other in rows
    )


@pytest.mark.parametrize("kind", ["oblique 2-D", "oblique 3-D", "superball", "gas"])
def test_reference_counts_of_stick_and_slip(kind: str) -> None:
    """How often the surfaces change between stick and slip in isolated contacts; 3 at most."""
    compared = 0
    for case in (case for case in CASES if case["kind"] == kind):
        law = law_of(case)
        run, space = engine_of(case, law), ((0, 0), (0, 3 - case["dimension"]))
        balls = [
            hl.Ball(radius, mass=mass, inertia_factor=case["inertia_factor"])
            for radius, mass in zip(case["radius"], case["mass"], strict=True)
        ]
        rows = sorted(case["contacts"])
        for row in rows:
            begin, end, i, j, changes = row
            if end is None or not alone(row, rows):
                continue
            run.advance(begin * (1.0 - 1e-12))
            (x, v), spins = (np.pad(a, space) for a in run.state()), run.spins()
            if j < 0:
                normal = np.eye(3)[(-j - 1) // 2] * (1.0 if j % 2 == 0 else -1.0)
                other = {"other": hl.FLOOR, "spins": spins[i]}
            else:
                box = np.pad(case["box"], space[1], constant_values=math.inf)
                normal = x[j] - x[i] - np.round((x[j] - x[i]) / box) * np.where(np.isfinite(box), box, 0.0)
                other = {"other": balls[j], "other_velocity": v[j], "spins": spins[[i, j]]}
            impact = hl.oblique_impact(balls[i], law=law, velocity=v[i], normal=normal, **other)
            assert impact.transitions == changes
            compared += 1
    assert compared == {"oblique 2-D": 1, "oblique 3-D": 1, "superball": 7, "gas": 9}[kind]


@pytest.mark.parametrize("kind", ["dense", "floor", "three bodies"])
@pytest.mark.slow
def test_reference_counts_of_stick_and_slip_in_clusters(kind: str, tmp_path: Path) -> None:
    """The same in contacts that overlap, also where the last digits of the moments of inertia differ.

    On the floor only until the sphere rolls, at 2u/(7μg) = 2.91 ms. The spring, which is not damped, then swings
    between its limits and just regains them each half period, from 3.05 ms on: rounding decides whether it slips there.
    """
    (case,) = (case for case in CASES if case["kind"] == kind)
    until, wanted = case["until"], sorted((row[0], *row[2:]) for row in case["contacts"])
    if kind == "floor":
        until, wanted = 2.97e-3, [(0.0, 0, -3, 2)]
    sides = zip(case["box"], case["boundary"], strict=True)
    numbers = [edge if boundary == "wall" else 0.0 for edge, boundary in sides]
    numbers += [case["gravity"][1], until, case["stiffness"], case["restitution"]]
    numbers += [case["tangential_stiffness"], case["tangential_damping"], case["friction"], len(case["mass"])]
    names = ("radius", "mass", "positions", "velocities", "angular_velocities")
    for last_digits in range(8):
        bodies = list[float]()
        for radius, mass, x, v, spin in zip(*(case[name] for name in names), strict=True):
            inertia = (1.0 + 2.3e-16 * last_digits) * case["inertia_factor"] * mass * radius**2
            bodies += [radius, mass, inertia, *x, *v, spin]
        stdin = " ".join(map(repr, numbers + bodies))
        rows = output_of("boxes/cluster_changes.cpp", tmp_path, "-O0", stdin=stdin).splitlines()
        contacts = sorted((float(row.split()[0]), *map(int, row.split()[1:])) for row in rows)
        assert [row[1:] for row in contacts] == [row[1:] for row in wanted]
        assert [row[0] for row in contacts] == pytest.approx([row[0] for row in wanted], abs=1e-9 * until)


@pytest.mark.parametrize("damping_ratio", [0.0, 0.5])
@pytest.mark.parametrize("coefficient", [0.05, 0.5, math.inf])
def test_conservation(coefficient: float, damping_ratio: float) -> None:
    """Momentum, angular momentum and energy over a cluster of five bodies, and at an instant within it."""
    system = cluster()
    law = linear(hl.Friction(coefficient, stiffness_ratio=0.9, damping_ratio=damping_ratio))
    run = engine(system, law, log=True)
    energy, turning, moving = (
        total_energy(run.observe()),
        angular_momentum(run, system),
        system.mass @ system.velocities,
    )
    size = float(system.mass @ np.linalg.norm(system.velocities, axis=1))
    for time in (0.0012, 0.01):
        run.advance(time)
        seen = run.observe()
        assert total_energy(seen) == pytest.approx(energy, rel=1e-10)
        assert seen["momentum"] == pytest.approx(moving, abs=1e-13 * size)
        assert angular_momentum(run, system) == pytest.approx(turning, abs=2e-12 * size * 0.1)
    assert run.statistics()["largest_cluster"] >= 3
    assert run.take_log()["overlapped"].any()


def meeting(seed: int, wall: bool) -> tuple[hl.ParticleSystem, Floats, Floats]:
    """Two balls, or a ball and the floor, that touch after 0.1 s; their places at touch, and the normal there."""
    r, n, size = np.random.default_rng(seed), 1 if wall else 2, 10.0
    radius, mass, factor = r.uniform(0.5, 1.0, (3, n))
    spins = 2.0 * r.normal(size=(n, 3))
    normal = np.array([0.0, 0.0, -1.0]) if wall else r.normal(size=3)
    normal /= np.linalg.norm(normal)
    velocities = 0.2 * r.normal(size=(n, 3))
    velocities[0] += (1.0 - velocities[0] @ normal) * normal + np.cross(normal, r.normal(size=3))
    touch = np.full((n, 3), 0.5 * size)
    if wall:
        touch[0, 2] = radius[0]
    else:
        touch[1] += radius.sum() * normal
        velocities[1] -= (0.3 + velocities[1] @ normal) * normal
    system = hl.ParticleSystem(
        positions=touch - 0.1 * velocities, velocities=velocities, radius=radius, mass=mass, box=size,
        boundary=["periodic", "periodic", "wall" if wall else "periodic"], angular_velocities=spins,
        inertia_factor=factor,
    )  # fmt: skip
    return system, touch, normal


def impact_of(system: hl.ParticleSystem, normal: Floats, law: hl.Law) -> Any:
    """The exact contact of the two balls, or of the ball with the floor."""
    balls = [
        hl.Ball(float(radius), mass=float(mass), inertia_factor=float(factor))
        for radius, mass, factor in zip(system.radius, system.mass, system.inertia_factor, strict=True)
    ]
    other = [hl.FLOOR] if system.n == 1 else []
    return hl.oblique_impact(
        *balls,
        *other,
        law,
        system.velocities[0],
        other_velocity=np.zeros(3) if other else system.velocities[1],
        spins=np.concatenate([spins_of(system), np.zeros((len(other), 3))]),
        normal=normal,
    )


#: Linear laws in whose contacts the surfaces change between stick and slip, slip only, are damped, or never slip.
SURFACES = [
    linear(hl.Friction(0.5, stiffness_ratio=2 / 7), 0.9, 1e4),
    linear(hl.Friction(0.1, stiffness_ratio=0.9), 1.0, 1e4),
    linear(hl.Friction(0.4, stiffness_ratio=0.5, damping_ratio=1.0), 0.6, 3e3),
    linear(hl.Friction(math.inf, stiffness_ratio=0.8), 0.9, 1e4),
]


def frictional_laws() -> list[hl.Law]:
    """All laws and models."""
    laws: list[hl.Law] = []
    for model in MODELS:
        for limit in ("total", "spring"):
            none, rubs = model == "none", limit == "total"
            options: dict[str, Any] = {"model": model, "limit": limit}
            options["damping_ratio"] = 0.4 if none else 0.3 * rubs
            if model in ("spring", "none"):
                laws.append(linear(hl.Friction(0.3, **options), 0.8))
            if model == "spring":
                options["stiffness"] = 3e4
            friction = hl.Friction(0.3, **options)
            hertz: dict[str, Any] = {"youngs_modulus": 1e7, "poisson_ratio": 0.3, "friction": friction}
            laws += [hl.Tsuji(restitution=0.8, **hertz), hl.Viscoelastic(dissipative_time=2e-5, **hertz)]
    return laws


@pytest.mark.parametrize("wall", [False, True], ids=["pair", "wall"])
@pytest.mark.parametrize(
    "law", [*SURFACES, *frictional_laws()], ids=lambda law: f"{type(law).__name__}-{law.friction.model}"
)
def test_single_contacts(law: hl.Law, wall: bool) -> None:
    """Velocities, spins, places, losses and energies after the contact, and the state in the middle of it."""
    within = 3e-11 if law in SURFACES else 3e-9
    for seed in range(5 if law in SURFACES else 2):
        system, touch, normal = meeting(seed, wall)
        impact, run, n = impact_of(system, normal, law), engine(system, law), system.n
        before = total_energy(run.observe())
        for time in (0.37 * impact.duration, 0.8 * impact.duration):
            run.advance(0.1 + time)
            path = impact.trajectory([time])
            assert run.state()[1] == pytest.approx(path["velocity"].values[0][:n], abs=within)
            assert run.spins() == pytest.approx(path["spin"].values[0][:n], abs=4.0 * within)
            assert total_energy(run.observe()) == pytest.approx(before, rel=within)
        run.advance(0.1 + impact.duration + 0.05)
        positions, velocities = run.state()
        places = touch + impact.displacements[:n] + 0.05 * impact.velocities[:n]
        assert velocities == pytest.approx(impact.velocities[:n], abs=within)
        assert run.spins() == pytest.approx(impact.spins[:n], abs=4.0 * within)
        assert positions == pytest.approx(places, abs=within)
        seen = run.observe()
        rubbed = sum(
            impact.energies[kind] for kind in ("tangential_spring", "tangential_damping", "friction")
        )
        assert seen["friction_loss"] == pytest.approx(rubbed, abs=within * before)
        assert total_energy(seen) == pytest.approx(before, rel=within) and seen["contact_energy"] == 0.0


def test_symmetries() -> None:
    """A box turned by a right angle, mirrored, or with its bodies in another order."""
    system, law = cluster(), linear(SPRING)
    end = by_events(system, law, 0.01).system

    def of(
        positions: Floats, velocities: Floats, spins: Floats, order: Any = slice(None)
    ) -> hl.ParticleSystem:
        return hl.ParticleSystem(
            positions=positions[order], velocities=velocities[order], radius=system.radius[order],
            mass=system.mass[order], box=system.box, angular_velocities=spins[order],
        )  # fmt: skip

    def agree(first: hl.ParticleSystem, other: hl.ParticleSystem) -> None:
        assert first.velocities == pytest.approx(other.velocities, abs=1e-9)
        assert spins_of(first) == pytest.approx(spins_of(other), abs=1e-7)

    def state(s: hl.ParticleSystem) -> tuple[Floats, Floats, Floats]:
        return s.positions, s.velocities, spins_of(s)

    turned = by_events(of(*(x[:, [1, 2, 0]] for x in state(system))), law, 0.01).system
    agree(turned, of(*(x[:, [1, 2, 0]] for x in state(end))))
    order = [3, 1, 4, 0, 2]
    agree(by_events(of(*state(system), order), law, 0.01).system, of(*state(end), order))
    flip, axial = np.array([-1.0, 1.0, 1.0]), np.array([1.0, -1.0, -1.0])
    shift = np.array([0.2, 0.0, 0.0])

    def mirror(s: hl.ParticleSystem) -> hl.ParticleSystem:
        return of(s.positions * flip + shift, s.velocities * flip, spins_of(s) * axial)

    agree(by_events(mirror(system), law, 0.01).system, mirror(end))


@pytest.mark.parametrize("boundary", ["periodic", "wall"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_energy_of_gases(dimension: int, boundary: str) -> None:
    """Many contacts, also at walls; no body leaves the region that others keep clear of."""
    system = gas(dimension=dimension, boundary=boundary)
    run = engine(system, linear(SPRING, 0.9, 2e3), log=True)
    energy, used = total_energy(run.observe()), 0.0
    for time in np.linspace(0.0, 4e-3, 9)[1:]:
        run.advance(float(time))
        used = max(used, run.largest_safety_use(8))
        seen = run.observe()
        assert total_energy(seen) == pytest.approx(energy, abs=1e-10 * energy)
        assert 0.0 <= seen["friction_loss"] <= seen["dissipated_energy"]
    assert run.outcome == "ok"
    assert used <= 1.0
    log = run.take_log()
    assert len(log["slid"]) > 30
    assert 0.0 < log["slid"].mean() <= 1.0
    assert np.abs(log["tangential_restitution"]).max() < 30.0


def test_kicks_with_spins() -> None:
    """Velocities and spins change within contacts, which go on: energy jumps by what the kick adds."""
    system, law = gas(), linear(hl.Friction(0.3, stiffness_ratio=0.9, damping_ratio=0.5), 0.9, 2e3)
    run = engine(system, law)
    rng = np.random.default_rng(1)
    for time in (1e-3, 2e-3, 3e-3):
        run.advance(time)
        before = run.observe()
        assert before["n_in_contact"] > 0
        run.kick(run.state()[1] + 0.2 * rng.standard_normal((system.n, 3)), 0.0, 1.1 * run.spins())
        after = run.observe()
        assert after["n_contacts"] == before["n_contacts"]
        assert after["rotational_energy"] == pytest.approx(1.21 * before["rotational_energy"], rel=1e-12)
        assert after["contact_energy"] == pytest.approx(before["contact_energy"], rel=1e-2)
        energy = total_energy(after)
        run.advance(time + 5e-4)
        assert total_energy(run.observe()) == pytest.approx(energy, rel=1e-9)


@pytest.mark.parametrize("friction", [hl.Friction(0.0), hl.Friction(0.0, limit="spring", damping_ratio=0.5)])
def test_without_friction_nothing_changes(friction: hl.Friction) -> None:
    """μ = 0 gives the bits of smooth grains, also with forces that are refused where they act."""
    system = gas()
    smooth = by_events(system, linear(friction, 0.9, 2e3), 2e-3).system
    plain = by_events(system, hl.LinearDashpot(stiffness=2e3, restitution=0.9), 2e-3).system
    assert (smooth.velocities == plain.velocities).all()


@pytest.mark.parametrize(
    ("friction", "message"),
    [
        (hl.Friction(0.3, limit="spring", damping_ratio=0.5), "limit: got 'spring' with tangential damping"),
        (hl.Friction(0.3, model="mindlin", damping=0.5), "damping: got it with the model mindlin"),
    ],
)
def test_refused_friction(friction: hl.Friction, message: str) -> None:
    law = hl.Viscoelastic(youngs_modulus=1e7, poisson_ratio=0.3, dissipative_time=1e-5, friction=friction)
    with pytest.raises(ValueError, match=message):
        by_events(cluster(), law, 1e-3)


@pytest.mark.parametrize(
    "friction",
    [
        hl.Friction(0.5, model="mindlin", stiffness_ratio=0.5, damping_ratio=1.0),
        hl.Friction(0.5, model="mindlin_rescale_force", stiffness_ratio=0.5, damping_ratio=0.1),
        hl.Friction(1.5, model="mindlin_rescale", stiffness_ratio=0.5, limit="spring"),
    ],
)
def test_a_sphere_thrown_into_a_corner_that_it_touches(friction: hl.Friction) -> None:
    """Two or three contacts begin at one instant, in a box that fits exactly."""
    radius = 1e-3
    law = hl.Tsuji(youngs_modulus=1e7, poisson_ratio=0.3, restitution=0.9, friction=friction)
    for height, low in ((4.0, 0.0034), (1.0, 0.0034), (1.0, -0.0034)):
        system = hl.ParticleSystem(
            [[radius, height * radius, radius]], [[0.02, -0.027, low]], radius, mass=1e-5,
            box=[2.0 * radius, 8.0 * radius, 2.0 * radius], boundary="wall", angular_velocities=np.zeros((1, 3)),
        )  # fmt: skip
        run = by_events(system, law, 1e-4)
        steps = hl.molecular_dynamics(system, law=law, until=1e-4, engine="steps", time_step=1.5e-9)
        assert run.outcome_name == "ok"
        assert run.energy_error < 1e-10
        np.testing.assert_allclose(run.system.velocities, steps.system.velocities, atol=1e-4 * 0.03)
        np.testing.assert_allclose(spins_of(run.system), spins_of(steps.system), atol=1e-4 * 30.0)


@pytest.mark.parametrize("seed", range(3))
def test_a_lattice_that_touches_everywhere_ends(seed: int) -> None:
    """All contacts begin at one instant, with forces that vanish there: the run says so instead of lasting for ever."""
    random = np.random.default_rng(seed)
    x = (np.indices((3, 3, 3)).reshape(3, -1).T + 0.5) * 0.02
    v, spins = 7e-3 * random.choice([-1.0, 0.0, 1.0], (27, 3)), 0.7 * random.choice([-1.0, 0.0, 1.0], (27, 3))
    system = hl.ParticleSystem(
        x, v, 0.01, mass=0.01, box=0.06, boundary=["wall", "periodic", "wall"], angular_velocities=spins
    )
    friction = hl.Friction(1.0, model="mindlin", damping_ratio=1.0)
    law = hl.Tsuji(youngs_modulus=1e7, poisson_ratio=0.3, restitution=0.6, friction=friction)
    run = by_events(system, law, 0.01)
    assert run.outcome_name in ("ok", "unresolved")
    assert np.isfinite(run.system.velocities).all() and np.isfinite(run.system.positions).all()
    assert run.energy_error < 1e-9
