"""Laws with friction in the time-stepping engine: conservation, frames, the exact contact, and the log."""

import math
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

import hardlimit as hl
from box_engines import core_engine
from hardlimit import _core
from hardlimit.boxes.falling_frame import spin_arguments
from hardlimit.contact.friction import LIMITS, MODELS


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


def solve(
    system: hl.ParticleSystem,
    law: hl.Law,
    *,
    step: float,
    until: float,
    samples: int = 1,
    threads: int = 1,
    pause: int = 2**40,
) -> Run:
    """The run of these grains. With several threads it is saved and loaded at each sample."""
    engine = core_engine("newton_steps", system, law, **spin_arguments(system), time_step=step)
    states, sums = [], []
    for k in range(samples + 1):
        engine.advance(until * k / samples, pause, threads)
        while engine.paused:
            engine.advance(until * k / samples, pause, threads)
        assert engine.outcome == "ok"
        spins = engine.spins() if engine.rotates else np.zeros((system.n, 3))
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
    system = hl.ParticleSystem(
        place,
        random.normal(size=place.shape),
        0.01,
        mass=0.01,
        box=8 * 0.023,
        boundary=("periodic", "wall", "periodic"),
        gravity=(0.0, -9.81, 0.0),
        angular_velocities=np.zeros(place.shape),
    )
    how = {"step": 2e-6, "until": 0.01, "samples": 4}
    smooth = hl.LinearDashpot(stiffness=1e5, restitution=0.8)
    plain = solve(system, smooth, **how)
    slippery = smooth.replace(friction=hl.Friction(0.0, stiffness_ratio=0.8, damping_ratio=0.5))
    slides = solve(system, slippery, **how)
    assert plain.differences(slides) == 0 and (plain.dissipated == slides.dissipated).all()
    rough = smooth.replace(friction=hl.Friction(0.5, stiffness_ratio=0.8, damping_ratio=0.5))
    alone = solve(system, rough, **how)
    three = solve(system, rough, threads=3, pause=97, **how)
    assert alone.differences(three) == 0 and alone.differences(plain) > 2000


def pair(seed: int) -> hl.ParticleSystem:
    """Unequal grains that touch within 2e-5 s, obliquely, with spins; speeds are about 1 m/s."""
    random = np.random.default_rng(seed)
    radius = random.uniform(0.7e-3, 1.3e-3, 2)
    normal, other = random.normal(size=(2, 3))
    normal /= np.linalg.norm(normal)
    across = np.cross(normal, other)
    across *= random.uniform(0.0, 1.0) / np.linalg.norm(across)
    spins = random.normal(size=(2, 3)) * random.choice([0.0, 100.0, 500.0])
    apart = 0.5 * (radius.sum() + random.uniform(1e-5, 2e-5)) * normal
    sign = np.array([[1.0], [-1.0]])
    return hl.ParticleSystem(
        0.01 - sign * apart,
        sign * (0.5 * normal + across),
        radius,
        density=2500.0,
        box=0.02,
        angular_velocities=spins,
        inertia_factor=random.uniform(0.3, 0.8, 2),
    )


def linear(restitution: float, **friction: Any) -> hl.Law:
    rough = hl.Friction(**{"coefficient": 0.5, "stiffness_ratio": 0.8} | friction)
    return hl.LinearDashpot(stiffness=2000.0, restitution=restitution, friction=rough)


def viscoelastic(time: float, **friction: Any) -> hl.Law:
    rough = hl.Friction(0.5, **friction)
    return hl.Viscoelastic(youngs_modulus=1e7, poisson_ratio=0.3, dissipative_time=time, friction=rough)


#: Laws with each model of friction, damping beside it, both limits, and no slip.
LAWS: dict[str, hl.Law] = {
    f"linear {restitution} {limit} {damping}": linear(restitution, limit=limit, damping=damping)
    for restitution in (1.0, 0.9, 0.4)
    for limit in LIMITS
    for damping in (None, 0.02)
}
LAWS |= {
    "no spring": linear(0.9, stiffness_ratio=None, model="none", damping=0.02),
    "no slip": linear(0.9, coefficient=math.inf),
    "damped tsuji": hl.Tsuji(
        elastic_prefactor=1e5,
        restitution=0.7,
        friction=hl.Friction(0.5, model="mindlin_force", stiffness_ratio=0.8, damping_ratio=1.0),
    ),
    "damped viscoelastic": viscoelastic(1e-5, model="mindlin", stiffness_ratio=0.8, damping_ratio=1.0),
    "hertz with a constant spring": viscoelastic(0.0, model="spring", stiffness=100.0),
}
LAWS |= {
    f"{model} {time}": viscoelastic(time, model=model, stiffness_ratio=0.82)
    for model in MODELS
    if model.startswith("mindlin")
    for time in (0.0, 1e-5)
}
each_law = pytest.mark.parametrize("name", LAWS)
DURATION = 1.2e-4  # of a contact, about [s]


@pytest.mark.slow
@each_law
def test_momenta_and_energy_of_a_pair(name: str) -> None:
    """Both momenta to rounding; energy with rotation, springs and what is dissipated to second order in the step, also
    during the contact."""
    errors = []
    for seed in range(8):
        system = pair(seed)
        mass, inertia = system.mass, system.inertia
        for steps in (32, 128):
            run = solve(system, LAWS[name], step=DURATION / steps, until=3e-4, samples=10)
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


@each_law
def test_a_common_velocity_changes_nothing(name: str) -> None:
    """Galilean invariance. The grains cross cells, so that the contact is listed in both orders of its bodies."""
    common = np.array([40.0, -25.0, 30.0])
    for seed in range(3):
        system = pair(seed)
        moving = system.replace(velocities=system.velocities + common)
        rest, run = (solve(grains, LAWS[name], step=5e-7, until=3e-4) for grains in (system, moving))
        carried = run._replace(velocities=run.velocities - common)
        assert carried.error(rest, 1e-3) <= 1e-9


@pytest.mark.slow
@each_law
def test_halved_steps_converge_to_the_exact_contact_of_pairs(name: str) -> None:
    """Unequal grains with spins in three dimensions, whose normal turns; positions, velocities, and spins. To second
    order, also where slip begins or ends. A limit on the spring alone makes a damped force jump there: first order."""
    law, until, errors = LAWS[name], 3e-4, []
    for seed in range(16):
        system = pair(seed)
        x, v, spins = system.positions, system.velocities, system.angular_velocities
        apart, moving = x[1] - x[0], v[1] - v[0]
        gap = apart @ apart - system.radius.sum() ** 2
        towards, square = apart @ moving, moving @ moving
        touch = -(towards + math.sqrt(towards**2 - square * gap)) / square
        values = zip(system.radius, system.mass, system.inertia_factor, strict=True)
        balls = [hl.Ball(radius, mass=mass, inertia_factor=factor) for radius, mass, factor in values]
        impact = hl.oblique_impact(
            *balls, law, v[0], other_velocity=v[1], spins=spins, normal=apart + touch * moving
        )
        end = x + touch * v + impact.equivalent.displacements + (until - touch) * impact.velocities
        for steps in (32, 256):
            run = solve(system, law, step=DURATION / steps, until=until)
            faster, moved = run.velocities[-1] - impact.velocities, (run.positions[-1] - end) / DURATION
            differences = faster, 1e-3 * (run.spins[-1] - impact.spins), moved
            errors.append(max(np.abs(difference).max() for difference in differences))
    coarse, fine = np.reshape(errors, (-1, 2)).mean(axis=0)
    jumps = "spring 0.02" in name
    assert fine < (1e-3 if jumps else 2e-5)
    assert math.log(coarse / fine, 8.0) > (0.5 if jumps else 1.4)


def oblique_pair(speed: float, sliding: float) -> hl.ParticleSystem:
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
    system = oblique_pair(speed, speed * tangent)
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
