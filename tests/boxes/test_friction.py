"""Laws with friction in the time-stepping engine."""

import json
import math
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

import hardlimit as hl
from conftest import DATA
from hardlimit import _core
from hardlimit.boxes.contacts import law_arguments
from hardlimit.contact.friction import LIMITS, MODELS

CASES = json.loads((DATA / "friction.json").read_text(encoding="utf-8"))["newton"]
LINEAR, VISCOELASTIC, TSUJI = range(3)
SPHERE = 2 / 5


class Grain(NamedTuple):
    """A body; angular velocities are vectors also in two dimensions."""

    radius: float
    mass: float
    position: ArrayLike
    velocity: ArrayLike
    spin: ArrayLike = (0.0, 0.0, 0.0)
    inertia_factor: float = SPHERE


class Box(NamedTuple):
    edge: tuple[float, ...]
    boundary: tuple[str, ...] = ("periodic",) * 3
    gravity: tuple[float, ...] = (0.0,) * 3


class Run(NamedTuple):
    """Samples: arrays [sample, body, component]; energies [sample] in J."""

    positions: NDArray[np.float64]
    velocities: NDArray[np.float64]
    spins: NDArray[np.float64]
    energy: NDArray[np.float64]
    dissipated: NDArray[np.float64]

    def differences(self, other: "Run") -> int:
        """Number of coordinates, velocities and spins that differ."""
        return sum(int((a != b).sum()) for a, b in zip(self[:3], other[:3], strict=True))

    def error(self, other: "Run", radius: float) -> float:
        """Largest difference of the last velocities, of centres and surfaces [m/s]."""
        linear = np.abs(self.velocities[-1] - other.velocities[-1]).max()
        return float(max(linear, radius * np.abs(self.spins[-1] - other.spins[-1]).max()))


LAWS: dict[int, tuple[type[hl.Law], tuple[str, ...]]] = {
    LINEAR: (hl.LinearDashpot, ("stiffness", "restitution")),
    VISCOELASTIC: (hl.Viscoelastic, ("youngs_modulus", "poisson_ratio", "dissipative_time")),
    TSUJI: (hl.Tsuji, ("elastic_prefactor", "restitution")),
}


def law_with(law: tuple[float, ...], friction: dict[str, Any]) -> hl.Law:
    """``friction`` has the parameters of ``hl.Friction``; without them nothing is rough."""
    kind, *values = law
    law_class, names = LAWS[int(kind)]
    parameters: dict[str, Any] = dict(zip(names, values, strict=True))
    if friction:
        numbers = {key: value for key, value in friction.items() if value or key != "damping"}
        parameters["friction"] = hl.Friction(**numbers)
    return law_class(**parameters)


def solve(
    law: tuple[float, ...],
    friction: dict[str, Any],
    box: Box,
    grains: list[Grain],
    *,
    step: float,
    until: float,
    samples: int = 1,
    threads: int = 1,
    pause: int = 2**40,
) -> Run:
    """The run of these grains. With several threads it is saved and loaded at each sample."""
    positions, velocities = (
        np.array([getattr(g, name) for g in grains], float) for name in ("position", "velocity")
    )
    radius, mass, factor = (
        np.array([getattr(g, name) for g in grains]) for name in ("radius", "mass", "inertia_factor")
    )
    d = len(box.edge)
    engine = _core.make_engine(
        "newton_steps",
        _core.Box(list(box.edge), list(box.boundary[:d]), list(box.gravity[:d])),
        positions,
        velocities,
        radius,
        mass,
        spins=np.array([g.spin for g in grains], float),
        inertia_factor=factor,
        law=law_arguments(law_with(law, friction)),
        time_step=step,
    )
    states, sums = [], []
    for k in range(samples + 1):
        engine.advance(until * k / samples, pause, threads)
        while engine.paused:
            engine.advance(until * k / samples, pause, threads)
        assert engine.outcome == "ok"
        spins = engine.spins() if engine.rotates else np.zeros((len(grains), 3))
        states.append((*engine.state(), spins))
        sums.append(engine.observe())
        if threads > 1:
            engine = _core.load_engine("newton_steps", engine.save())
    kinds = ("kinetic_energy", "potential_energy", "contact_energy", "rotational_energy")
    energy = np.array([sum(now.get(kind, 0.0) for kind in kinds) for now in sums])
    dissipated = np.array([now["dissipated_energy"] for now in sums])
    return Run(*(np.array(values) for values in zip(*states, strict=True)), energy, dissipated)


def test_a_coefficient_of_zero_threads_and_checkpoints_change_no_bit() -> None:
    random = np.random.default_rng(1)
    place = (np.indices((8, 8, 8)).reshape(3, -1).T + 0.5) * 0.023
    grains = [Grain(0.01, 0.01, x, random.normal(size=3)) for x in place]
    box = Box((8 * 0.023,) * 3, ("periodic", "wall", "periodic"), (0.0, -9.81, 0.0))
    how = {"step": 2e-6, "until": 0.01, "samples": 4}
    plain = solve((LINEAR, 1e5, 0.8), {}, box, grains, **how)
    rough = {"coefficient": 0.0, "stiffness_ratio": 0.8, "damping_ratio": 0.5}
    smooth = solve((LINEAR, 1e5, 0.8), rough, box, grains, **how)
    assert plain.differences(smooth) == 0 and (plain.dissipated == smooth.dissipated).all()
    rough["coefficient"] = 0.5
    alone = solve((LINEAR, 1e5, 0.8), rough, box, grains, **how)
    three = solve((LINEAR, 1e5, 0.8), rough, box, grains, threads=3, pause=97, **how)
    assert alone.differences(three) == 0 and alone.differences(plain) > 2000


@pytest.mark.parametrize("inertia_factor", [SPHERE, 2 / 3])
def test_a_sliding_sphere_begins_to_roll(inertia_factor: float) -> None:
    """It slides with u0 − μ g t and rolls with u0/(1 + q), for a sphere 5/7 u0, from t = q u0/((1 + q) μ g) on."""
    radius, mass, g, mu, u0, stiffness = 0.01, 0.01, 9.81, 0.3, 0.5, 1e5
    sunk = mass * g / stiffness
    grains = [Grain(radius, mass, (0.5, radius - sunk, 0.05), (u0, 0.0, 0.0), inertia_factor=inertia_factor)]
    box = Box((1.0, 0.1, 0.1), ("periodic", "wall", "periodic"), (0.0, -g, 0.0))
    rolls = inertia_factor * u0 / ((1 + inertia_factor) * mu * g)
    friction = {"coefficient": mu, "stiffness_ratio": 2 / 7, "damping_ratio": 0.3}
    run = solve((LINEAR, stiffness, 0.3), friction, box, grains, step=2e-6, until=2 * rolls, samples=20)
    times = np.linspace(0.0, 2 * rolls, 21)
    u, surface = run.velocities[:, 0, 0], run.velocities[:, 0, 0] + radius * run.spins[:, 0, 2]
    assert np.abs(u[:10] - (u0 - mu * g * times[:10])).max() <= 1e-10 * u0
    assert np.abs(u[11:] - u0 / (1 + inertia_factor)).max() <= 1e-3 * u0  # the spring oscillates
    assert abs(u[-1] * (1 + inertia_factor) / u0 - 1.0) <= 1e-10 and abs(surface[-1]) <= 1e-10 * u0
    lost = 0.5 * mass * u0**2 * inertia_factor / (1 + inertia_factor)
    assert run.dissipated[-1] == pytest.approx(lost, rel=1e-8)
    assert np.ptp(run.energy + run.dissipated) <= 1e-8 * run.energy[0]


def test_grains_that_roll_on_each_other_feel_no_friction() -> None:
    """Chung & Ooi 2011, test 8: an equal pair with opposite spins."""
    spin = np.array([0.0, 300.0, -500.0])
    grains = [
        Grain(1e-3, 1e-5, (9e-3 - 1e-5, 0.01, 0.01), (0.3, 0.0, 0.0), spin),
        Grain(1e-3, 1e-5, (11e-3 + 1e-5, 0.01, 0.01), (-0.3, 0.0, 0.0), -spin),
    ]
    how = {"step": 1e-6, "until": 6e-4}
    rough = {"coefficient": 0.5, "stiffness_ratio": 0.8, "damping_ratio": 1.0}
    run = solve((LINEAR, 2000.0, 0.8), rough, Box((0.02,) * 3), grains, **how)
    plain = solve((LINEAR, 2000.0, 0.8), {}, Box((0.02,) * 3), grains, **how)
    assert (run.velocities[-1] == plain.velocities[-1]).all()
    assert (run.spins[-1] == [spin, -spin]).all()


def pair(seed: int) -> list[Grain]:
    """Unequal grains that touch within 2e-5 s, obliquely, with spins; speeds are about 1 m/s."""
    random = np.random.default_rng(seed)
    radius = random.uniform(0.7e-3, 1.3e-3, 2)
    normal, other = random.normal(size=(2, 3))
    normal /= np.linalg.norm(normal)
    across = np.cross(normal, other)
    across *= random.uniform(0.0, 1.0) / np.linalg.norm(across)
    spins = random.normal(size=(2, 3)) * random.choice([0.0, 100.0, 500.0])
    apart = 0.5 * (radius.sum() + random.uniform(1e-5, 2e-5)) * normal
    return [
        Grain(
            radius[k],
            2500.0 * 4 / 3 * math.pi * radius[k] ** 3,
            0.01 - sign * apart,
            sign * (0.5 * normal + across),
            spins[k],
            random.uniform(0.3, 0.8),
        )
        for k, sign in enumerate((1, -1))
    ]


LINEAR_LAWS = [(LINEAR, 2000.0, restitution) for restitution in (1.0, 0.9, 0.4)]
#: Law and friction: each model, damping beside it, both limits, and no slip.
SETTINGS: dict[str, tuple[tuple[float, ...], dict[str, Any]]] = {
    f"linear {law[2]} {limit} {damping}": (
        law,
        {"coefficient": 0.5, "limit": limit, "stiffness_ratio": 0.8, "damping": damping},
    )
    for law in LINEAR_LAWS
    for limit in LIMITS
    for damping in (0.0, 0.02)
}
SETTINGS |= {
    "no spring": (LINEAR_LAWS[1], {"coefficient": 0.5, "model": "none", "damping": 0.02}),
    "no slip": (LINEAR_LAWS[1], {"coefficient": math.inf, "stiffness_ratio": 0.8}),
    "damped tsuji": (
        (TSUJI, 1e5, 0.7),
        {"coefficient": 0.5, "model": "mindlin_force", "stiffness_ratio": 0.8, "damping_ratio": 1.0},
    ),
    "damped viscoelastic": (
        (VISCOELASTIC, 1e7, 0.3, 1e-5),
        {"coefficient": 0.5, "model": "mindlin", "stiffness_ratio": 0.8, "damping_ratio": 1.0},
    ),
    "hertz with a constant spring": (
        (VISCOELASTIC, 1e7, 0.3, 0.0),
        {"coefficient": 0.5, "model": "spring", "stiffness": 100.0},
    ),
}
SETTINGS |= {
    f"{model} {time}": (
        (VISCOELASTIC, 1e7, 0.3, time),
        {"coefficient": 0.5, "model": model, "stiffness_ratio": 0.82},
    )
    for model in MODELS
    if model.startswith("mindlin")
    for time in (0.0, 1e-5)
}
each_setting = pytest.mark.parametrize("name", SETTINGS)
DURATION = 1.2e-4  # of a contact, about [s]


@pytest.mark.slow
@each_setting
def test_momenta_and_energy_of_a_pair(name: str) -> None:
    """Both momenta to rounding; energy with rotation, springs and what is dissipated to second order in the step, also
    during the contact."""
    errors = []
    for seed in range(8):
        grains = pair(seed)
        mass = np.array([g.mass for g in grains])
        inertia = mass * [g.inertia_factor * g.radius**2 for g in grains]
        for steps in (32, 128):
            how = {"step": DURATION / steps, "until": 3e-4, "samples": 10}
            run = solve(*SETTINGS[name], Box((0.02,) * 3), grains, **how)
            momentum = np.tensordot(run.velocities, mass, (1, 0))
            centre = np.tensordot(run.positions, mass, (1, 0))[:, None] / mass.sum()
            turning = np.cross(run.positions - centre, run.velocities)
            angular = np.tensordot(turning, mass, (1, 0)) + np.tensordot(run.spins, inertia, (1, 0))
            assert np.abs(momentum - momentum[0]).max() <= 1e-13 * mass.max()
            assert np.abs(angular - angular[0]).max() <= 1e-13 * mass.max() * 1e-3
            balance = run.energy + run.dissipated
            errors.append(np.abs(balance / balance[0] - 1.0).max())
            assert np.ptp(run.spins[:, 0], axis=0).max() > 1.0
    coarse, fine = np.reshape(errors, (-1, 2)).mean(axis=0)
    assert coarse < 2e-3 and fine < 0.12 * coarse


@each_setting
def test_a_common_velocity_changes_nothing(name: str) -> None:
    """Galilean invariance. The grains cross cells, so that the contact is listed in both orders of its bodies."""
    common = np.array([40.0, -25.0, 30.0])
    for seed in range(3):
        grains = pair(seed)
        how = {"step": 5e-7, "until": 3e-4}
        moving = [grain._replace(velocity=grain.velocity + common) for grain in grains]
        rest, run = (solve(*SETTINGS[name], Box((0.02,) * 3), pair_, **how) for pair_ in (grains, moving))
        carried = run._replace(velocities=run.velocities - common)
        assert carried.error(rest, 1e-3) <= 1e-9


@pytest.mark.slow
@each_setting
def test_order_of_convergence(name: str) -> None:
    """Second order, also where slip begins or ends. A limit on the spring alone makes a damped force jump there: first
    order."""
    errors = []
    for seed in range(16):
        grains = pair(seed)
        coarse, fine, finest = (
            solve(*SETTINGS[name], Box((0.02,) * 3), grains, step=DURATION / steps, until=3e-4)
            for steps in (32, 256, 4096)
        )
        errors.append([coarse.error(finest, 1e-3), fine.error(finest, 1e-3)])
    coarser, finer = np.mean(errors, axis=0)
    jumps = "spring 0.02" in name
    assert finer < (1e-3 if jumps else 2e-5)
    assert math.log(coarser / finer, 8.0) > (0.5 if jumps else 1.4)


def vectors(angular_velocities: list[Any]) -> NDArray[np.float64]:
    """[body, 3]; in two dimensions the axis is the third."""
    values = np.array(angular_velocities)
    return values if values.ndim == 2 else np.pad(values[:, None], ((0, 0), (2, 0)))


def case_run(case: dict[str, Any], steps: int) -> Run:
    """A reference case with this number of steps per contact."""
    rows = zip(
        case["radius"],
        case["mass"],
        case["positions"],
        case["velocities"],
        vectors(case["angular_velocities"]),
        strict=True,
    )
    grains = [Grain(*row, case["inertia_factor"]) for row in rows]
    friction = {"coefficient": math.inf if case["friction"] is None else case["friction"]}
    friction |= {"stiffness": case["tangential_stiffness"], "damping": case["tangential_damping"]}
    box = Box(tuple(case["box"]), tuple(case["boundary"]), tuple(case["gravity"]))
    duration = math.pi * math.sqrt(0.5 * min(case["mass"]) / case["stiffness"])
    law = (LINEAR, case["stiffness"], case["restitution"])
    return solve(law, friction, box, grains, step=duration / steps, until=case["until"])


@pytest.mark.slow
@pytest.mark.parametrize("number", range(len(CASES)), ids=[case["kind"] for case in CASES])
def test_halved_steps_converge_to_an_independent_solution(number: int) -> None:
    case = CASES[number]
    end, errors = vectors(case["end_angular_velocities"]), []
    for steps in (50, 400):
        run = case_run(case, steps)
        surface = np.array(case["radius"])[:, None] * (run.spins[-1] - end)
        moved = np.abs(run.positions[-1] - case["end_positions"]).max() / min(case["radius"])
        slower = np.abs(run.velocities[-1] - case["end_velocities"]).max()
        errors.append(max(slower, np.abs(surface).max()) / case["speed_scale"] + moved)
    assert errors[1] < 8e-5 and errors[1] < 0.12 * errors[0]


@pytest.mark.parametrize(
    ("law", "friction", "restitution"),
    [
        ((LINEAR, 2000.0, 0.8), {"model": "none", "damping": 10.0}, 0.8),
        ((VISCOELASTIC, 1e7, 0.3, 0.0), {"model": "mindlin_rescale", "stiffness_ratio": 0.82}, 1.0),
    ],
    ids=["no spring", "mindlin"],
)
def test_a_sphere_that_slides_throughout(
    law: tuple[float, ...], friction: dict[str, Any], restitution: float
) -> None:
    """LAMMPS' own test of an oblique impact: v_x − μ (1 + e) v_z, spin (5/2) μ (1 + e) v_z/R."""
    radius, mu, v_x, v_z = 1e-3, 0.3, 2.0, 0.5
    grains = [Grain(radius, 1e-5, (0.01, 0.01, radius + 1e-5), (v_x, 0.0, -v_z))]
    box = Box((0.02,) * 3, ("periodic", "periodic", "wall"))
    run = solve(law, {"coefficient": mu} | friction, box, grains, step=1e-6, until=1e-3)
    slowed = mu * (1 + restitution) * v_z
    assert run.velocities[-1, 0] == pytest.approx([v_x - slowed, 0.0, restitution * v_z], abs=2e-5)
    assert radius * run.spins[-1, 0] == pytest.approx([0.0, 2.5 * slowed, 0.0], abs=5e-5)
    lost = (v_x - run.velocities[-1, 0, 0]) / (restitution * v_z + v_z)
    assert radius * run.spins[-1, 0, 1] == pytest.approx(2.5 * (v_x - run.velocities[-1, 0, 0]), rel=1e-12)
    assert lost == pytest.approx(mu, rel=1e-4)


def law_of(name: str) -> hl.Law:
    return law_with(*SETTINGS[name])


def exact(name: str, ball: hl.Ball, speed: float, sliding: ArrayLike) -> NDArray[np.float64]:
    """β of a contact at a wall, from the exact contact with a fixed normal."""
    return law_of(name).between(ball).tangential_restitution(np.arctan(np.asarray(sliding) / speed), speed)


@pytest.mark.slow
@each_setting
def test_halved_steps_converge_to_the_exact_contact_at_a_wall(name: str) -> None:
    """A wall does not turn: β over the angle of impact."""
    ball, speed = hl.Ball(1e-3, mass=1e-5, inertia_factor=0.5), 0.5
    sliding = speed * np.tan(np.radians([5.0, 20.0, 40.0, 55.0, 65.0, 80.0]))
    expected = exact(name, ball, speed, sliding)
    box, errors = Box((0.05,) * 3, ("periodic", "periodic", "wall")), []
    for steps in (32, 256):
        slower = []
        for g, depth in zip(sliding, np.linspace(1e-5, 2e-5, 6), strict=True):
            grain = Grain(
                1e-3, 1e-5, (0.02, 0.02, 1e-3 + depth), (0.4 * g, 0.0, -speed), (0.0, -600.0 * g, 0.0), 0.5
            )
            run = solve(*SETTINGS[name], box, [grain], step=2.2e-4 / steps, until=8e-4)
            slower.append((run.velocities[-1, 0, 0] - 1e-3 * run.spins[-1, 0, 1]) / -g)
        errors.append(np.abs(slower - expected) * sliding)
    coarse, fine = np.mean(errors, axis=1)
    jumps = "spring 0.02" in name
    assert fine < (2e-3 if jumps else 5e-5) and fine < (0.5 if jumps else 0.12) * coarse


@pytest.mark.slow
@each_setting
def test_halved_steps_converge_to_the_exact_contact_of_pairs(name: str) -> None:
    """Unequal grains with spins in three dimensions, whose normal turns; positions, velocities, and spins."""
    law, until, errors = law_of(name), 3e-4, []
    for seed in range(3):
        grains = pair(seed)
        x, v, spins = (
            np.array([getattr(g, what) for g in grains]) for what in ("position", "velocity", "spin")
        )
        (apart,), (moving,) = np.diff(x, axis=0), np.diff(v, axis=0)
        gap = apart @ apart - sum(g.radius for g in grains) ** 2
        towards, square = apart @ moving, moving @ moving
        touch = -(towards + math.sqrt(towards**2 - square * gap)) / square
        balls = [hl.Ball(g.radius, mass=g.mass, inertia_factor=g.inertia_factor) for g in grains]
        impact = hl.oblique_impact(
            *balls, law, v[0], other_velocity=v[1], spins=spins, normal=apart + touch * moving
        )
        end = x + touch * v + impact.equivalent.displacements + (until - touch) * impact.velocities
        for steps in (32, 256):
            how = {"step": DURATION / steps, "until": until}
            run = solve(*SETTINGS[name], Box((0.02,) * 3), grains, **how)
            faster, moved = run.velocities[-1] - impact.velocities, (run.positions[-1] - end) / DURATION
            differences = faster, 1e-3 * (run.spins[-1] - impact.spins), moved
            errors.append(max(np.abs(difference).max() for difference in differences))
    coarse, fine = np.reshape(errors, (-1, 2)).mean(axis=0)
    jumps = "spring 0.02" in name
    assert fine < (3e-3 if jumps else 5e-5) and fine < (0.4 if jumps else 0.12) * coarse


def oblique_pair(law: hl.Law, speed: float, sliding: float) -> hl.ParticleSystem:
    """Two equal spheres that touch soon, head-on; only their spins make the surfaces slide."""
    x = np.array([[10e-3, 10e-3, 10e-3], [12e-3 + 2e-10, 10e-3, 10e-3]])
    v, spins = [[0.0, 0.0, 0.0], [-speed, 0.0, 0.0]], np.full((2, 3), [0.0, 0.0, 0.5 * sliding / 1e-3])
    return hl.ParticleSystem(x, v, 1e-3, mass=1e-5, box=0.02, angular_velocities=spins)


def random_contact(random: np.random.Generator) -> tuple[hl.Law, float]:
    """A law with friction, and tan γ of an impact."""
    restitution, friction = random.uniform(0.3, 1.0), {"coefficient": 10.0 ** random.uniform(-1.3, 0.5)}
    tangent = math.tan(random.uniform(0.02, 1.5))
    if random.random() < 0.5:
        ratio = 10.0 ** random.uniform(-1.0, 1.0)
        return hl.LinearDashpot(
            stiffness=1e5, restitution=restitution, friction=hl.Friction(**friction, stiffness_ratio=ratio)
        ), tangent
    return hl.Tsuji(
        youngs_modulus=1e8, poisson_ratio=0.3, restitution=restitution, friction=hl.Friction(**friction)
    ), tangent


def logged_restitution(
    law: hl.Law, tangent: float, how: dict[str, float]
) -> tuple[float, float, hl.ContactResult]:
    """β in the log of a run with this time step or error, that of the exact contact, and the run."""
    speed, ball = 1e-3, hl.Ball(1e-3, mass=1e-5)
    contact = law.between(ball, ball)
    exact = float(contact.tangential_restitution(math.atan(tangent), speed))
    system = oblique_pair(law, speed, speed * tangent)
    run = hl.molecular_dynamics(
        system, law=law, until=3.0 * float(contact.duration(speed)), engine="steps", log=True, **how
    )
    return float(run.contacts.tangential_restitution[0]), exact, run


def test_the_log_has_the_tangential_restitution() -> None:
    random = np.random.default_rng(3)
    for _ in range(12):
        law, tangent = random_contact(random)
        ball = hl.Ball(1e-3, mass=1e-5)
        step = float(law.between(ball, ball).duration(1e-3)) / 300
        logged, exact, run = logged_restitution(law, tangent, {"time_step": step})
        assert logged == pytest.approx(exact, abs=5e-4)
        row = run.contacts.isel(contact=0)
        assert float(row.tangential_speed) == pytest.approx(1e-3 * tangent, rel=1e-6) and bool(row.slid)
        series = run.series
        lost = 0.5 * 1e-5 / 7.0 * (1e-3 * tangent) ** 2 * (1.0 - logged**2)  # m_t = m_n/κ
        assert run.samples["friction_loss"][-1] == pytest.approx(lost, rel=1e-3)
        assert (run.samples["friction_loss"] <= series["dissipated_energy"] * (1 + 1e-12) + 1e-25).all()
        assert run.samples["tangential_energy"][0] == run.samples["tangential_energy"][-1] == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("error", [1e-3, 1e-4])
def test_the_step_suits_the_tangential_spring(error: float) -> None:
    """Where slip ends or begins the error of β may be several times that of ε."""
    random = np.random.default_rng(4)
    errors = []
    for _ in range(60):
        law, tangent = random_contact(random)
        logged, exact, _ = logged_restitution(law, tangent, {"restitution_error": error})
        errors.append(abs(logged - exact))
    assert max(errors) < 10.0 * error and np.mean(errors) < error
