"""Boxes with friction by our steps and by LAMMPS: closed forms, published figures, and each other."""

import json
import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import hardlimit as hl
from box_engines import needs_lammps
from conftest import DATA, slow

STEPS, LAMMPS, EVENTS = "steps", "lammps", "events"
BY_STEPS = [STEPS, pytest.param(LAMMPS, marks=needs_lammps)]
each_engine = pytest.mark.parametrize("engine", [*BY_STEPS, EVENTS])
ON_FLOOR = ("periodic", "periodic", "wall")
Rows = NDArray[np.float64]


def solved(
    engine: str, system: hl.ParticleSystem, law: hl.Law, until: float, step: float, samples: int = 1
) -> hl.ContactResult:
    return hl.molecular_dynamics(
        system,
        law=law,
        until=until,
        engine=engine,
        time_step=None if engine == EVENTS else step,
        samples=samples,
        log=True,
    )


def spins(run: hl.ContactResult) -> Rows:
    assert run.system.angular_velocities is not None
    return run.system.angular_velocities


# --- one grain at a wall ------------------------------------------------------------------------------------


@each_engine
@pytest.mark.parametrize(
    ("law", "restitution"),
    [
        (
            hl.LinearDashpot(
                stiffness=2000.0, restitution=0.8, friction=hl.Friction(0.3, damping=10.0, model="none")
            ),
            0.8,
        ),
        (
            hl.Viscoelastic(
                youngs_modulus=1e7, poisson_ratio=0.3, dissipative_time=0.0, friction=hl.Friction(0.3)
            ),
            1.0,
        ),
    ],
    ids=["no spring", "mindlin"],
)
def test_a_sphere_slides_throughout(engine: str, law: hl.Law, restitution: float) -> None:
    """LAMMPS' own test of an oblique impact: v_x − μ (1 + e) v_z, spin (5/2) μ (1 + e) v_z/R."""
    radius, mu, v_x, v_z = 1e-3, 0.3, 2.0, 0.5
    at, moving = [[0.01, 0.01, radius + 1e-5]], [[v_x, 0.0, -v_z]]
    start = hl.ParticleSystem(at, moving, radius, mass=1e-5, box=0.02, boundary=ON_FLOOR)
    run = solved(engine, start, law, 1e-3, 5e-7)
    slowed, within = mu * (1 + restitution) * v_z, 2e-3 if engine == LAMMPS else 2e-5
    assert run.system.velocities[0] == pytest.approx([v_x - slowed, 0.0, restitution * v_z], abs=within)
    assert radius * spins(run)[0] == pytest.approx([0.0, 2.5 * slowed, 0.0], abs=2.5 * within)
    turned = 2.5 * (v_x - run.system.velocities[0, 0])
    assert radius * spins(run)[0, 1] == pytest.approx(turned, rel=1e-10)


@each_engine
def test_a_sphere_that_sticks(engine: str) -> None:
    """LAMMPS' own test of a contact by Mindlin's model, 5 mm, 70 GPa; its γ_t is half of γ_n."""
    rough = hl.Friction(0.092, model="mindlin", damping_ratio=0.5)
    law = hl.Tsuji(youngs_modulus=70e9, poisson_ratio=0.33, restitution=0.98, friction=rough)
    at, moving = [[0.01, 0.01, 2.501e-3]], [[0.5, 0.0, -2.9876]]
    start = hl.ParticleSystem(at, moving, 2.5e-3, density=2700.0, box=0.02, boundary=ON_FLOOR)
    run = solved(engine, start, law, 4e-5, 4e-9)
    assert run.system.velocities[0] == pytest.approx([0.344379, 0.0, 2.927842], abs=1e-5)
    assert spins(run)[0] == pytest.approx([0.0, 155.6211, 0.0], abs=0.007)


@each_engine
@pytest.mark.parametrize("inertia_factor", [0.4, pytest.param(0.5, id="disk")])
def test_a_sliding_sphere_begins_to_roll(engine: str, inertia_factor: float) -> None:
    """u0 − μ g t, and from t = q u0/((1 + q) μ g) on u0/(1 + q): for a sphere 5/7 u0 from 2 u0/(7 μ g) on."""
    radius, mass, g, mu, u0, stiffness, d = 0.01, 0.01, 9.81, 0.3, 0.5, 1e5, 3 if inertia_factor == 0.4 else 2
    law = hl.LinearDashpot(stiffness=stiffness, restitution=0.3, friction=hl.Friction(mu, damping_ratio=0.3))
    box: dict[str, Any] = {"boundary": ("periodic",) * (d - 1) + ("wall",), "box": [1.0, 0.1, 0.1][:d]}
    rest = [0.5] + [0.05] * (d - 2) + [radius]
    start = hl.ParticleSystem(
        [rest], [[u0] + [0.0] * (d - 1)], radius, mass=mass, gravity=g, inertia_factor=inertia_factor, **box
    )
    settled = solved(engine, start.replace(velocities=np.zeros((1, d))), law, 0.05, 1e-5).system
    rolls = inertia_factor * u0 / ((1 + inertia_factor) * mu * g)
    sliding = settled.replace(velocities=start.velocities)
    run = solved(engine, sliding, law, 2 * rolls, 1e-5, samples=20)
    times, u = run.series.time.values, run.samples["momentum"][:, 0] / mass
    within = 1e-4 if engine == LAMMPS else 1e-6  # half a step of the force
    assert u[:10] == pytest.approx(u0 - mu * g * times[:10], rel=within)
    assert u[11:] == pytest.approx(u0 / (1 + inertia_factor), rel=1e-3)  # the spring oscillates
    assert u[-1] == pytest.approx(u0 / (1 + inertia_factor), rel=1e-7)
    assert radius * np.abs(spins(run)).max() == pytest.approx(u[-1], rel=1e-6)
    lost = 0.5 * mass * u0**2 * inertia_factor / (1 + inertia_factor)
    assert run.samples["dissipated_energy"][-1] == pytest.approx(lost, rel=1e-5)


@each_engine
def test_a_sphere_rolls_down_a_slope(engine: str) -> None:
    """(5/7) g sin θ, without rolling resistance."""
    radius, g, angle, until = 0.01, 9.81, math.radians(20.0), 0.1
    law = hl.LinearDashpot(stiffness=1e5, restitution=0.3, friction=hl.Friction(0.5, damping_ratio=0.3))
    start = hl.ParticleSystem(
        [[0.2, 0.05, radius]],
        np.zeros((1, 3)),
        radius,
        mass=0.01,
        box=(1.0, 0.1, 0.1),
        boundary=("wall", "periodic", "wall"),
        gravity=(g * math.sin(angle), 0.0, -g * math.cos(angle)),
    )
    run = solved(engine, start, law, until, 2e-5)
    rolled = 5.0 / 7.0 * g * math.sin(angle) * until
    assert run.system.velocities[0] == pytest.approx([rolled, 0.0, 0.0], abs=1e-6 * rolled)
    assert radius * spins(run)[0] == pytest.approx([0.0, rolled, 0.0], abs=1e-6 * rolled)


MATERIAL = {"youngs_modulus": 3e7, "poisson_ratio": 0.3}


def linear(restitution: float, **friction: Any) -> hl.Law:
    rough = hl.Friction(**{"coefficient": 0.5, **friction})
    return hl.LinearDashpot(stiffness=1e4, restitution=restitution, friction=rough)


def hertz(model: str, time: float = 1e-5, **friction: Any) -> hl.Law:
    rough = hl.Friction(0.5, model=model, **friction)
    return hl.Viscoelastic(**MATERIAL, dissipative_time=time, friction=rough)


LAWS = {
    "spring": linear(0.8),
    "spring, elastic": linear(1.0, stiffness_ratio=0.9),
    "spring, damped": linear(0.8, damping_ratio=0.6),
    "spring, one γ_t": linear(0.8, damping=0.02, stiffness=8e3),
    "no spring": linear(0.8, model="none", damping_ratio=0.6),
    "spring of a Hertz law": hertz("spring", stiffness=1e4, damping_ratio=0.5),
    "mindlin, damped": hertz("mindlin", damping_ratio=0.7),
    "mindlin_force": hertz("mindlin_force"),
    "mindlin_rescale, damped": hertz("mindlin_rescale", damping_ratio=0.7),
    "mindlin_rescale_force, elastic": hertz("mindlin_rescale_force", 0.0),
    "tsuji": hl.Tsuji(**MATERIAL, restitution=0.7, friction=hl.Friction(0.5)),
    "tsuji, one k": hl.Tsuji(
        elastic_prefactor=1e7, restitution=0.7, friction=hl.Friction(0.5, stiffness_ratio=0.8)
    ),
}
SHORT = ("spring, one γ_t", "mindlin_rescale, damped", "tsuji, one k")
each_law = pytest.mark.parametrize("name", [*SHORT, *(slow(name) for name in LAWS if name not in SHORT)])
TANGENTS = np.tan(np.radians([3.0, 10.0, 20.0, 35.0, 50.0, 65.0, 80.0]))


def at_wall(law: hl.Law, engine: str, steps: int) -> float:
    """Mean error of the slip velocity after a contact, of grains that hit one wall at these angles, over theirs."""
    radius, speed, n = 1e-3, 0.5, len(TANGENTS)
    ball = hl.Ball(radius, density=2500.0)
    contact = law.between(ball)
    duration = contact.duration(speed)
    height = radius + speed * duration * (
        0.3 + 0.5 * (0.618034 * np.arange(n) % 1.0)
    )  # other phases of the steps
    at = np.stack([0.004 * np.arange(1.0, n + 1.0), np.full(n, 0.01), height], axis=1)
    sliding = speed * TANGENTS
    moving = np.stack([np.zeros(n), 0.4 * sliding, np.full(n, -speed)], axis=1)
    turning = np.stack([0.6 * sliding / radius, np.zeros(n), np.full(n, 50.0)], axis=1)
    start = hl.ParticleSystem(
        at, moving, radius, density=2500.0, box=0.04, boundary=ON_FLOOR, angular_velocities=turning
    )
    run = solved(engine, start, law, 2.5 * duration, duration / steps)
    assert run.n_contacts == run.n_ended == n
    exact = contact.tangential_restitution(np.arctan(sliding / speed), speed)
    slip = run.system.velocities[:, 1] + radius * spins(run)[:, 0]
    assert spins(run)[:, 2] == pytest.approx(50.0)  # does not turn about the normal
    return float(np.abs((slip + exact * sliding) / speed).mean())


@each_law
@pytest.mark.parametrize("engine", BY_STEPS)
def test_halved_steps_converge_to_the_exact_contact_at_a_wall(engine: str, name: str) -> None:
    """To second order; LAMMPS, whose arms at walls are ours, to first order."""
    coarse, fine = (at_wall(LAWS[name], engine, steps) for steps in (300, 2400))
    assert (
        (fine < 1e-6 and fine < 0.05 * coarse) if engine == STEPS else (fine < 1e-3 and fine < 0.25 * coarse)
    )


# --- pairs --------------------------------------------------------------------------------------------------


@each_engine
def test_grains_that_roll_on_each_other_feel_no_friction(engine: str) -> None:
    """Chung & Ooi 2011, test 8: an equal pair with opposite spins."""
    turning = np.array([[0.0, 300.0, -500.0], [0.0, -300.0, 500.0]])
    at, moving = [[8.99e-3, 0.01, 0.01], [11.01e-3, 0.01, 0.01]], [[0.3, 0.0, 0.0], [-0.3, 0.0, 0.0]]
    start = hl.ParticleSystem(
        at, moving, 1e-3, mass=1e-5, box=0.02, boundary="periodic", angular_velocities=turning
    )
    law = linear(0.8, damping_ratio=1.0)
    run = solved(engine, start, law, 5e-4, 5e-7)
    plain = solved(engine, start, law.replace(friction=None), 5e-4, 5e-7)
    assert run.n_ended == 1
    assert run.system.velocities == pytest.approx(plain.system.velocities, abs=1e-14)
    assert spins(run) == pytest.approx(turning, abs=1e-10)
    assert plain.system.angular_velocities is not None
    assert (plain.system.angular_velocities == turning).all()


def pairs(stiffness: float) -> tuple[hl.ParticleSystem, hl.Law, float]:
    """Unequal pairs that touch at once, far from each other, and the duration of their contacts."""
    random = np.random.default_rng(5)
    at, moving, radius = [], [], []
    law = linear(0.8).replace(stiffness=stiffness)
    for k in range(8):
        sizes = random.uniform(0.7e-3, 1.3e-3, 2)
        normal, other = random.normal(size=(2, 3))
        normal /= np.linalg.norm(normal)
        across = np.cross(normal, other)
        across *= random.uniform(0.2, 1.0) / np.linalg.norm(across)
        centre = 0.005 + 0.01 * np.array([k % 2, k // 2 % 2, k // 4])
        gap = random.uniform(0.3, 0.5) * math.pi * math.sqrt(5e-6 / stiffness)
        for sign in (-1.0, 1.0):
            at.append(centre + sign * 0.5 * (sizes.sum() + gap) * normal)
            moving.append(-sign * 0.5 * normal + sign * across)
        radius += sizes.tolist()
    system = hl.ParticleSystem(
        at, moving, radius, density=2500.0, box=0.02, angular_velocities=random.normal(size=(16, 3)) * 300.0
    )
    return system, law, math.pi * math.sqrt(0.5 * float(system.mass.mean()) / stiffness)


def surface_error(run: hl.ContactResult, other: hl.ContactResult) -> float:
    """Root mean square difference of velocities, of centres and of surfaces [m/s]."""
    radius = run.system.radius.reshape(-1, *[1] * (spins(run).ndim - 1))
    parts = (run.system.velocities - other.system.velocities, radius * (spins(run) - spins(other)))
    return math.sqrt(sum(float((part**2).mean()) for part in parts))


@needs_lammps
def test_lammps_agrees_with_our_events_in_the_limit_of_short_contacts_and_steps() -> None:
    """Its arms, R in the velocity and R − δ/2 in the torque, differ from ours by the compression δ ~ k^(−1/2)."""
    steps, errors = np.array([100, 200, 400, 800]), []
    for n in steps:
        start, law, duration = pairs(1e4 * (n / 100) ** 2)
        run, exact = (solved(engine, start, law, 3.0 * duration, duration / n) for engine in (LAMMPS, EVENTS))
        assert run.n_ended == exact.n_ended == 8
        errors.append(surface_error(run, exact))
    assert errors[-1] < 2e-3
    assert -np.polyfit(np.log(steps), np.log(errors), 1)[0] == pytest.approx(1.0, abs=0.25)


@each_engine
def test_a_small_grain_on_large_ones_is_not_trapped(engine: str) -> None:
    """Ten times smaller grains bounce between large ones; energy never grows, and each contact ends in its time."""
    random, large, small, n = np.random.default_rng(3), 4e-3, 4e-4, 40
    large_at = [[0.005, 0.005, 0.005], [0.0135, 0.005, 0.005]]
    at = [*large_at]
    while len(at) < 2 + n:
        x = random.uniform(0.0, 0.018, 3)
        apart = np.array(at) - x
        apart -= 0.018 * np.rint(apart / 0.018)
        if (
            np.linalg.norm(apart, axis=1) > [1.05 * (large + small)] * 2 + [2.1 * small] * (len(at) - 2)
        ).all():
            at.append(x)
    moving = random.normal(size=(2 + n, 3)) * np.array([0.02] * 2 + [1.0] * n)[:, None]
    start = hl.ParticleSystem(
        at, moving, [large] * 2 + [small] * n, density=2500.0, box=0.018, 
        angular_velocities=random.normal(size=(2 + n, 3)) * 100.0,
    )  # fmt: skip
    law = linear(0.9).replace(stiffness=2e3)
    duration = law.between(hl.Ball(small, density=2500.0), hl.Ball(large, density=2500.0)).duration(1.0)
    run = solved(engine, start, law, 0.02, duration / 50, 40)
    kinds = ("kinetic", "rotational", "contact")
    energy = np.sum([run.samples[f"{kind}_energy"] for kind in kinds], axis=0)
    with_large = (run.contacts["first"] < 2) & (run.contacts["second"] >= 2)
    assert int(with_large.sum()) > 15
    assert np.diff(energy).max() <= 1e-9 * energy[0] and energy[-1] < 0.97 * energy[0]
    lasted = (run.contacts.end - run.contacts.begin).values[
        with_large.values & ~run.contacts.overlapped.values
    ]
    assert np.nanmax(lasted) < 1.2 * duration


# --- boxes --------------------------------------------------------------------------------------------------

CASES = {
    case["kind"] + f" {case['inertia_factor']:.2g}": case
    for case in json.loads((DATA / "friction.json").read_text(encoding="utf-8"))["newton"]
}


def of_case(case: dict[str, Any], engine: str, steps: int) -> tuple[float, hl.ContactResult]:
    """Error of a reference case with this number of steps per contact, in units of its speed."""
    start = hl.ParticleSystem(
        case["positions"],
        case["velocities"],
        case["radius"],
        mass=case["mass"],
        box=case["box"],
        boundary=case["boundary"],
        gravity=case["gravity"],
        angular_velocities=case["angular_velocities"],
        inertia_factor=case["inertia_factor"],
        allowed_overlap=0.1,
    )
    rough = hl.Friction(
        math.inf if case["friction"] is None else case["friction"],
        stiffness=case["tangential_stiffness"],
        damping=case["tangential_damping"],
    )
    law = hl.LinearDashpot(stiffness=case["stiffness"], restitution=case["restitution"], friction=rough)
    duration = math.pi * math.sqrt(0.5 * min(case["mass"]) / case["stiffness"])
    run = solved(engine, start, law, case["until"], duration / steps)
    radius = np.array(case["radius"]).reshape(-1, *[1] * (spins(run).ndim - 1))
    parts = (
        run.system.velocities - case["end_velocities"],
        radius * (spins(run) - case["end_angular_velocities"]),
    )
    return max(float(np.abs(part).max()) for part in parts) / case["speed_scale"], run


@pytest.mark.parametrize("name", [slow(name) if name == "superball 0.4" else name for name in CASES])
def test_our_steps_converge_to_the_reference_boxes(name: str) -> None:
    coarse, fine = (of_case(CASES[name], STEPS, steps)[0] for steps in (50, 400))
    assert fine < 2e-5 and fine < 0.12 * coarse


#: Differences by the arms of LAMMPS, which grow with the compression; at walls they are ours.
BY_ARMS = {
    "oblique 2-D 0.4": 5e-5,
    "floor 0.4": 1e-3,
    "three bodies 0.5": 2e-3,
    "gas 0.5": 0.02,
    "dense 0.5": 0.025,
}


@needs_lammps
@pytest.mark.parametrize("name", CASES)
def test_the_reference_boxes_in_lammps(name: str) -> None:
    if name not in BY_ARMS:
        with pytest.raises(
            ValueError, match=r"\A(inertia_factor|coefficient): got [^\n]* for engine 'lammps'\Z"
        ):
            of_case(CASES[name], LAMMPS, 200)
        return
    error, run = of_case(CASES[name], LAMMPS, 200)
    assert error < BY_ARMS[name] and run.n_contacts == len(CASES[name]["contacts"])


GASES: dict[str, tuple[int, Any, Any, dict[str, Any]]] = {
    "spheres, walls across gravity": (3, ("wall", "periodic", "wall"), [20.0, 0.0, -50.0], {}),
    "spheres, periodic, falling": (3, "periodic", 9.81, {}),
    "disks, walls": (2, "wall", 30.0, {}),
    "disks as spheres": (2, ("periodic", "wall"), 0.0, {"inertia_factor": 0.4}),
    "sheared": (3, ("periodic", "lees-edwards", "wall"), [0.0, 0.0, -20.0], {"shear_rate": 500.0}),
    "sheared disks": (2, ("periodic", "lees-edwards"), 0.0, {"shear_rate": -500.0}),
}


def gas(name: str) -> hl.ParticleSystem:
    dimension, boundary, gravity, others = GASES[name]
    others = dict(others)
    factor, n = others.pop("inertia_factor", None), 80
    box = {"boundary": boundary, "gravity": gravity, **others}
    start = hl.ParticleSystem.random(
        n=n,
        packing_fraction=0.3,
        dimension=dimension,
        seed=4,
        radius=1e-3,
        density=2500.0,
        rms_speed=1.0,
        **box,
    )
    turning = np.random.default_rng(4).normal(size=(n, 3) if dimension == 3 else n) * 500.0
    sizes = start.radius * np.array([1.0, 0.9, 0.7])[np.arange(n) % 3]
    return start.replace(radius=sizes, density=2500.0, angular_velocities=turning, inertia_factor=factor)


@needs_lammps
@pytest.mark.parametrize("law", ["spring, damped", "spring", "no spring"])
@pytest.mark.parametrize("name", GASES)
@pytest.mark.slow
def test_gases_in_lammps_agree_with_our_events_in_the_limit_of_short_contacts_and_steps(
    name: str, law: str
) -> None:
    """To first order: velocities, spins, and what is sampled."""
    start, errors, steps = gas(name), [], np.array([80, 160, 320])
    until = 4e-4 if start.dimension == 3 else 8e-4
    for n in steps:
        soft = LAWS[law]
        stiff = soft.replace(stiffness=1e4 * (n / 80) ** 2)
        duration = math.pi * math.sqrt(0.5 * float(start.mass.min()) / stiff.parameters["stiffness"])
        run, exact = (solved(engine, start, stiff, until, duration / n, 3) for engine in (LAMMPS, EVENTS))
        assert run.n_contacts == exact.n_contacts > 8
        stored, wanted = (result.samples["tangential_energy"] for result in (run, exact))
        if n == steps[0]:  # contacts are open at the samples
            assert np.abs(stored - wanted).max() <= 0.1 * wanted.max()
        errors.append([surface_error(run, exact), *sample_errors(run, exact).values()])
    orders = np.log2(np.array(errors)[:-1] / np.array(errors)[1:]).mean(axis=0)
    assert (
        max(errors[-1]) < 2e-3 and orders[0] > 0.6
    )  # at one instant of a contact, errors change with its phase


@needs_lammps
@pytest.mark.parametrize("rate", [100.0, -60.0])
@pytest.mark.parametrize("axis", [1, 2])
def test_damped_springs_between_images_of_a_sheared_box(axis: int, rate: float) -> None:
    """Images move, and LAMMPS does not write their velocities."""
    radius, edge = 1e-3, 0.02
    at, moving = np.full((2, 3), 0.01), np.zeros((2, 3))
    at[:, axis], moving[:, axis] = [0.5 * radius, edge - 1.51 * radius], [-0.25, 0.25]
    moving[:, 0] = rate * (at[:, axis] - 0.5 * edge) + [0.1, 0.0]
    boundary = ["periodic"] * 3
    boundary[axis] = "lees-edwards"
    start = hl.ParticleSystem(
        at, moving, radius, density=2500.0, box=edge, boundary=boundary, shear_rate=rate
    )
    runs = [
        solved(engine, start, linear(0.8, damping_ratio=0.6), 1e-4, 2e-7, 5) for engine in (LAMMPS, STEPS)
    ]
    stored, wanted = (run.samples["tangential_energy"] for run in runs)
    assert stored == pytest.approx(wanted, abs=0.02 * wanted.max())


def sample_errors(run: hl.ContactResult, exact: hl.ContactResult) -> dict[str, float]:
    """Largest differences of samples, in units of the energy, the spin, … of the box."""
    mean = float(exact.samples["kinetic_energy"].mean())
    size = math.sqrt(2.0 * mean * float(exact.system.mass.sum())) * float(exact.system.radius.mean())
    scales = {
        **dict.fromkeys(("kinetic_energy", "rotational_energy", "dissipated_energy", "contact_energy"), mean),
        **dict.fromkeys(("tangential_energy", "shear_work"), mean),
        "spin": size,
        "virial_tensor": float(np.abs(exact.samples["virial_tensor"]).max()),
    }
    return {
        name: float(np.abs(run.samples[name] - exact.samples[name]).max()) / scale + 1e-9
        for name, scale in scales.items()
    }
