"""The time-stepping engine for Newton's equations: second order, no missed contact, bit-identical with any threads."""

import functools
import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hardlimit as hl
from box_engines import REFERENCE, core_contact, core_engine, reference_law, reference_system
from conftest import damped, draws, lattice, law_of, laws, log_floats, slow
from hardlimit import _core
from hardlimit.boxes import contacts, time_step
from hardlimit.boxes.falling_frame import system_at

molecular_dynamics = functools.partial(hl.molecular_dynamics, engine="steps")

BOXES = REFERENCE["newton"] + REFERENCE["dilute"]
GLASS = hl.LinearDashpot(stiffness=1e5, restitution=0.9)


ENERGIES = ("kinetic_energy", "potential_energy", "contact_energy", "dissipated_energy")


def shortest_contact(system, law, speed):
    return min(c.duration(np.array([speed]))[0] for c in contacts.of_kinds(system, law))


def by_steps(system, law, until, per_contact, samples=1, **options):
    """A run with this number of steps per contact, for the shortest contact at the largest expected speed."""
    step = shortest_contact(system, law, time_step.largest_speed(system)) / per_contact
    return molecular_dynamics(
        system, law=law, until=until, time_step=step, log=True, samples=samples, **options
    )


#: Steps per contact. The error depends on where between two steps a contact begins, which is random.
STEPS = (50, 58, 66, 76, 87, 100, 500, 580, 660, 760, 870, 1000)


def order_of(errors):
    """Order of convergence of the errors [step, quantity] at STEPS, averaged over the quantities."""
    return -np.polyfit(np.log(STEPS), np.log(errors).mean(axis=1), 1)[0]


def engine_of(system, law, step, log=True):
    return core_engine("newton_steps", system, law, time_step=step, log=log)


def everything(engine):
    """The complete observable state of an engine, as bytes."""
    arrays = [*engine.state(), *engine.take_log().values(), *engine.open_contacts().values()]
    seen = engine.observe()
    numbers = [seen[name] for name in sorted(seen) if name not in ("momentum", "kinetic_integral")]
    counts = (engine.n_contacts, engine.n_logged)
    return b"".join(a.tobytes() for a in arrays) + repr((numbers, counts, engine.time)).encode()


def displacement(end, start, system):
    """Minimum-image displacement of particles inside the box."""
    d = end - start
    for axis, side in enumerate(system.boundary):
        if side == "periodic":
            d[:, axis] -= system.box[axis] * np.round(d[:, axis] / system.box[axis])
    return d


# --- one contact --------------------------------------------------------------------------------------------


@draws(40)
@given(law=laws(), speed=log_floats(0.03, 30.0), error=log_floats(1e-6, 1e-2))
def test_the_longest_step_keeps_to_the_error(law, speed, error):
    contact = core_contact(law)
    step = _core.longest_step(contact, speed, error)
    assert max(_core.step_errors(contact, speed, step)) <= error
    assert step <= contact.duration(np.array([speed]))[0] / 10.0


@st.composite
def impacts(draw, law):
    """A pair, or a particle and a wall, just before touch: system, law, speed, gap, second body, and their contact."""
    chosen, speed, wall = draw(law), draw(log_floats(0.1, 3.0)), draw(st.booleans())
    first, second = (draw(log_floats(5e-4, 2e-3)) for _ in range(2))
    gap = 1e-4 * (1.0 + draw(st.floats(0.1, 0.9)))
    at = [[gap + first if wall else 0.01, 0.01, 0.01], [0.01 + first + second + gap, 0.01, 0.005]]
    if not wall:
        at[1][2] = 0.01
    velocities = [[-speed if wall else speed, 0.0, 0.0], [0.0, 0.0, 0.0]]
    sides = ("wall", "periodic", "periodic")
    system = hl.ParticleSystem(
        at, velocities, [first, second], density=2500.0, box=[0.02] * 3, boundary=sides
    )
    ball, other = (hl.Ball(r, density=2500.0) for r in (first, second))
    return system, chosen, speed, gap, -1 if wall else 1, chosen.between(ball, hl.FLOOR if wall else other)


@draws(40)
@given(impact=impacts(laws()))
def test_a_contact_in_the_box_keeps_to_the_error_of_the_restitution(impact):
    system, law, speed, gap, second, contact = impact
    until = gap / speed + 2.0 * contact.duration(speed)
    run = molecular_dynamics(system, law=law, until=until, restitution_error=1e-3, log=True, samples=3)
    logged = run.contacts.isel(contact=0)
    assert (logged["first"], logged["second"]) == (0, second)
    assert float(logged.separation_speed / logged.impact_speed) == pytest.approx(
        contact.restitution(speed), abs=1.05e-3
    )
    assert float(logged.impact_speed) == pytest.approx(speed, rel=1e-9)
    assert float(logged.begin) == pytest.approx(gap / speed, rel=1e-9)
    assert float(logged.end - logged.begin) == pytest.approx(contact.duration(speed), rel=0.1)


#: Down to nearly perfectly inelastic contacts.
strong = st.one_of(log_floats(0.01, 1.0), st.sampled_from([0.01, math.exp(-2.0), 0.999, 1.0]))


@draws(60)
@given(impact=impacts(laws(strong)))
def test_the_energy_of_a_contact_is_balanced_at_every_instant(impact):
    """With the default step, to 1e-3 of the impact energy at any instant during and after the contact."""
    system, law, speed, gap, _, contact = impact
    until = gap / speed + 3.0 * contact.duration(speed)
    series = molecular_dynamics(system, law=law, until=until, samples=80).series
    energy = 0.5 * contact.effective_mass * speed**2
    kinetic, stored, lost = (series[f"{kind}_energy"].values for kind in ("kinetic", "contact", "dissipated"))
    assert np.abs(kinetic + stored + lost - kinetic[0]).max() < 1.1e-3 * energy
    assert np.diff(lost).min() >= -1e-12 * energy
    wanted = (1.0 - contact.restitution(speed) ** 2) * energy
    assert lost[-1] + stored[-1] == pytest.approx(wanted, abs=3e-3 * energy)


@pytest.mark.parametrize(
    "law",
    [
        hl.Tsuji(youngs_modulus=1e8, poisson_ratio=0.3, restitution=0.01),
        hl.Viscoelastic(youngs_modulus=1e8, poisson_ratio=0.3, restitution=0.01, impact_speed=0.2),
        hl.LinearDashpot(stiffness=1e5, restitution=0.01),
    ],
    ids=lambda law: law.record["name"],
)
def test_a_pair_that_keeps_a_hundredth_of_its_speed_dissipates_its_energy(law):
    system = hl.ParticleSystem(
        [[0.04, 0.05], [0.062, 0.05]], [[0.1, 0.0], [-0.1, 0.0]], radius=0.01, density=2500.0, box=0.1
    )
    run = molecular_dynamics(system, law=law, until=0.05, samples=20)
    energy = run.series.kinetic_energy.values[0]
    assert run.series.dissipated_energy.values[-1] / energy == pytest.approx(1.0 - 0.01**2, abs=1e-3)
    assert run.energy_error < 1e-3


@pytest.mark.parametrize("name", sorted(hl.LAWS))
@pytest.mark.parametrize("restitution", [0.01, math.exp(-2.0), 0.3, 0.7, 0.9, 0.95])
def test_every_error_of_a_contact_is_of_second_order(name, restitution):
    contact = core_contact(law_of(name, restitution))
    duration = contact.duration(np.array([1.0]))[0]
    errors = [_core.step_errors(contact, 1.0, duration / n) for n in (50, 100, 200, 400, 800)]
    order = np.polyfit(np.log([1, 2, 4, 8, 16]), -np.log(errors), 1)[0]
    assert (order > 1.8).all() and max(errors[0]) < 1.1e-3
    assert restitution < 0.2 or (1.85 < order[0] < 2.4 and errors[0][0] < 1e-3)  # of ε


def close_packed(**values):
    """Spheres with twelve neighbours each, which overlap a little."""
    cell = 2e-3 * math.sqrt(2.0) * 0.9999
    corners = np.array([[0, 0, 0], [1, 1, 0], [1, 0, 1], [0, 1, 1]]) / 2.0
    at = np.concatenate([corners + shift for shift in np.ndindex(3, 3, 3)]) * cell + 0.25 * cell
    velocities = 0.1 * np.random.default_rng(0).normal(size=at.shape)
    values = {"density": 2500.0, "box": [3 * cell] * 3, "allowed_overlap": 0.01} | values
    return hl.ParticleSystem(at, velocities, 1e-3, **values)


def test_strongly_damped_contacts_of_a_dense_packing_are_stable():
    """Twelve neighbours each, with the longest allowed step: damping couples them within a step."""
    system = close_packed()
    for name, restitution in itertools.product(sorted(hl.LAWS), (0.01, 0.1, 0.5)):
        law = law_of(name, restitution, 0.2)
        step = time_step.chosen(system, law, time_step.LARGEST_ERROR, None)
        run = molecular_dynamics(system, law=law, until=300 * step, time_step=step, samples=10)
        assert run.outcome == "ok" and run.energy_error < 0.03
        kinetic = run.series.kinetic_energy.values
        assert kinetic[-1] < 0.01 * kinetic[0]  # except for the motion of the centre of mass


def test_steps_are_stable_with_damping_along_the_surfaces():
    """The longest allowed step is below that of the network of contacts, at most 97 % of it."""
    draw = np.random.default_rng(1)
    for _ in range(6):
        system = close_packed(inertia_factor=draw.uniform(0.1, 0.7))
        ratios = {
            "stiffness_ratio": 10.0 ** draw.uniform(-1, 0.3),
            "damping_ratio": 10.0 ** draw.uniform(-1, 1),
        }
        law = hl.LinearDashpot(
            stiffness=1e4, restitution=10.0 ** draw.uniform(-2, -0.02), friction=hl.Friction(0.5, **ratios)
        )
        step = time_step.chosen(system, law, time_step.LARGEST_ERROR, None)
        assert step < float(hl.measure.largest_stable_time_step(system, law).time_step)


def test_damping_along_the_surfaces_does_not_heat_grains():
    system = close_packed()
    friction = hl.Friction(5.0, stiffness_ratio=2.0 / 7.0, damping_ratio=1.0)
    law = hl.LinearDashpot(stiffness=1e4, restitution=0.3, friction=friction)
    step = time_step.chosen(system, law, time_step.LARGEST_ERROR, None)
    run = molecular_dynamics(system, law=law, until=400 * step, restitution_error=0.05, samples=4)
    kinetic = run.series.kinetic_energy.values + run.series.rotational_energy.values
    assert kinetic[-1] < 0.1 * kinetic[0] and run.energy_error < 0.03


# --- against independent solutions --------------------------------------------------------------------------


@pytest.mark.parametrize("case", range(len(BOXES)))
def test_reference_cases(case):
    case = BOXES[case]
    system, law = reference_system(case), reference_law(case)
    rms = math.sqrt((system.velocities**2).sum(axis=1).mean())
    errors = []
    for per_contact in STEPS:
        run = by_steps(system, law, case["until"], per_contact)
        contacts = run.contacts
        pairs = list(zip(contacts["first"].values.tolist(), contacts["second"].values.tolist(), strict=True))
        assert pairs == [(row[2], row[3]) for row in case["contacts"]]
        begin = np.abs(contacts.begin.values - [row[0] for row in case["contacts"]]).max()
        ends = np.array([math.nan if row[1] is None else row[1] for row in case["contacts"]])
        assert np.array_equal(np.isnan(ends), np.isnan(contacts.end.values))
        end = np.nanmax(np.abs(contacts.end.values - ends))
        moved = displacement(run.system.positions, np.array(case["end_positions"]), system)
        position = np.abs(moved).max() / system.radius.min()
        velocity = np.abs(run.system.velocities - case["end_velocities"]).max() / rms
        energy = (run.samples["kinetic_energy"] + run.samples["potential_energy"])[-1]
        energy = abs(energy / case["mechanical_energy"] - 1.0)
        errors.append([begin / case["until"], end / case["until"], position, velocity, energy])
    assert (np.array(errors)[-1] < 1e-4).all()
    assert order_of(errors) > 1.8


def column_in_a_box(column, top):
    """A column of balls as disks between a floor and a distant ceiling, without lateral motion."""
    radii = np.array([ball.radius for ball in column.balls])
    heights = column.height + np.append(0.0, np.cumsum(radii[:-1] + np.array(column.gaps) + radii[1:]))
    at = np.stack([np.full(len(radii), 2.0 * radii.max()), heights], axis=1)
    velocities = np.stack([np.zeros(len(radii)), np.array(column.velocities)], axis=1)
    mass = [ball.mass for ball in column.balls]
    shape = {"box": [4.0 * radii.max(), top], "boundary": ("periodic", "wall"), "gravity": column.gravity}
    return hl.ParticleSystem(at, velocities, radii, mass=mass, **shape)


@pytest.mark.parametrize("name", [name if name == "tsuji" else slow(name) for name in sorted(hl.LAWS)])
@pytest.mark.parametrize("gravity", [slow(0.0), 9.81])
def test_a_column_of_balls_in_a_box_is_that_of_newton(name, gravity):
    law = law_of(name, 0.8)
    balls = [hl.Ball(r, density=2500.0) for r in (0.012, 0.01, 0.007)]
    speed = 0.0 if gravity else -1.0
    column = hl.Column(balls, [2e-5, 4e-5], 0.013, law, velocities=speed, gravity=gravity)
    exact = hl.newton(column)
    touch = math.sqrt(2.0 * 1e-3 / gravity) if gravity else 1e-3
    wanted = exact.contacts.isel(contact=exact.contacts.end.notnull())
    m, until = len(wanted.end), touch + float(wanted.end.max()) * 1.05
    errors = []
    for per_contact in STEPS:
        run = by_steps(column_in_a_box(column, 0.2), law, until, per_contact)
        contacts = run.contacts.isel(contact=slice(m))
        pair = np.where(contacts["second"] < 0, 0, contacts["second"])  # pair j consists of balls j − 1 and j
        assert pair.tolist() == wanted["pair"].values.tolist()
        late = [contacts[name].values - touch - wanted[name].values for name in ("begin", "end")]
        errors.append([np.linalg.norm(late[0][1:]), np.linalg.norm(late[1])])
        assert np.abs(run.system.velocities[:, 0]).max() == 0.0
    duration = float((wanted.end - wanted.begin).min())
    assert (np.array(errors)[-1] < 1e-4 * duration).all()
    assert order_of(errors) > 1.5


def crowded(seed, dimension):
    """Particles that collide with several others, with periodic axes and walls, one of them a floor."""
    rng = np.random.default_rng(seed)
    points = np.stack(np.meshgrid(*[np.arange(3)] * dimension, indexing="ij"), -1).reshape(-1, dimension)
    at = (rng.permutation(points)[:9] + 0.5) * 2.15e-3
    at += rng.uniform(-0.07e-3, 0.07e-3, at.shape)
    velocities, radius = 0.3 * rng.normal(size=at.shape), 1e-3 * 1.3 ** -rng.random(len(at))
    box, gravity = [6.45e-3] * dimension, [9.81 * (seed & 1), *[0.0] * (dimension - 1)]
    sides = [("periodic", "wall")[seed >> axis & 1] for axis in range(dimension)]
    return hl.ParticleSystem(at, velocities, radius, 2500.0, box=box, boundary=sides, gravity=gravity)


@pytest.mark.parametrize("restitution", [math.exp(-2.0), *map(slow, (0.01, 0.3, 0.9))])
@pytest.mark.parametrize("name", [name if name == "linear" else slow(name) for name in sorted(hl.LAWS)])
def test_states_and_energies_agree_with_those_by_events(name, restitution):
    """With the default step to a few times its error, energies at every sample; with a finer step more accurately."""
    law = law_of(name, restitution, 0.3)
    errors = []
    for seed in range(4):
        system = crowded(seed, 2 + seed % 2)
        exact, default, fine = (
            hl.molecular_dynamics(system, law=law, until=2.5e-3, samples=25, **by)
            for by in ({}, {"engine": "steps"}, {"engine": "steps", "restitution_error": 5e-5})
        )
        assert exact.n_contacts > 3
        rms = math.sqrt((system.velocities**2).sum(axis=1).mean())
        for run in (default, fine):
            energy = max(abs(run.series[n] - exact.series[n]).max().item() for n in ENERGIES)
            energy /= exact.series.kinetic_energy.values[0]
            moved = np.abs(displacement(run.system.positions, exact.system.positions, system)).max()
            velocity = np.abs(run.system.velocities - exact.system.velocities).max()
            errors.append([moved / system.radius.min(), velocity / rms, energy, run.energy_error])
    default, fine = np.array(errors[::2]), np.array(errors[1::2])
    # At the start of a contact velocities and energies change quickly; the balance holds there as well.
    assert (np.median(default, axis=0) < 1e-3).all() and default[:, [0, 3]].max() < 1.5e-3
    assert (np.exp(np.log(default / fine).mean(axis=0)) > 5.0).all()


# --- properties of any system -------------------------------------------------------------------------------


@st.composite
def boxes(draw, most=40):
    """Random systems: flat and long boxes, walls, gravity, shear, mixed sizes, dense and dilute."""
    dimension, seed = draw(st.sampled_from([2, 3])), draw(st.integers(0, 2**31))
    cells = [draw(st.integers(1, 4)) for _ in range(dimension)]
    rng = np.random.default_rng(seed)
    spread = draw(st.sampled_from([1.0, 1.5, 4.0]))
    boundary = [draw(st.sampled_from(["periodic", "wall"])) for _ in range(dimension)]
    cells = [max(2, c) if side == "periodic" else c for c, side in zip(cells, boundary, strict=True)]
    edge = draw(st.sampled_from([2.02e-3, 2.5e-3]))
    gradient = draw(st.sampled_from(range(dimension)))  # 0: no shear
    shear_rate = draw(st.sampled_from([-3000.0, -200.0, 20.0, 500.0])) if gradient else 0.0
    if gradient:
        boundary[0], boundary[gradient] = "periodic", "lees-edwards"
        cells[0], cells[gradient] = max(2, cells[0]), max(math.ceil(5e-3 / edge), cells[gradient])
    points = np.stack(np.meshgrid(*map(np.arange, cells), indexing="ij"), -1).reshape(-1, dimension)
    points = rng.permutation(points)[: draw(st.integers(1, most))]
    free = 0.499 * edge - 1e-3
    at = (points + 0.5) * edge + rng.uniform(-free, free, points.shape)
    gravity = draw(st.sampled_from([0.0, 9.81])) * rng.normal(size=dimension)
    velocities, radius = rng.normal(size=points.shape), 1e-3 * spread ** -rng.random(len(points))
    box = [c * edge for c in cells]
    if gradient:
        velocities[:, 0] += shear_rate * (at[:, gradient] - 0.5 * box[gradient])
        gravity[[0, gradient]] = 0.0
    values = {"box": box, "boundary": boundary, "gravity": gravity, "shear_rate": shear_rate}
    return hl.ParticleSystem(at, velocities, radius, 2500.0, **values)


def overlaps(system):
    """All overlapping pairs, walls as negative numbers, found without neighbour lists."""
    pairs = set()
    shifts = [(0,) if side == "wall" else (-2, -1, 0, 1, 2) for side in system.boundary]
    sliding = [system.shear_displacement * (side == "lees-edwards") for side in system.boundary]
    i, j = np.triu_indices(system.n, 1)
    for shift in itertools.product(*shifts):
        d = system.positions[j] - system.positions[i] + np.array(shift) * system.box
        d[:, 0] += np.dot(shift, sliding)
        near = (d**2).sum(axis=1) < (system.radius[i] + system.radius[j]) ** 2
        pairs.update(zip(i[near].tolist(), j[near].tolist(), strict=True))
    for i, axis in itertools.product(range(system.n), range(system.dimension)):
        if system.boundary[axis] == "wall":
            if system.positions[i, axis] < system.radius[i]:
                pairs.add((i, -1 - 2 * axis))
            if system.box[axis] - system.positions[i, axis] < system.radius[i]:
                pairs.add((i, -2 - 2 * axis))
    return pairs


@draws(25)
@given(system=boxes(), name=st.sampled_from(sorted(hl.LAWS)), stiff=st.sampled_from([1.0, 30.0]))
def test_no_contact_is_missed(system, name, stiff):
    """Without damping a force acts between two particles if and only if they overlap."""
    elastic = damped(name, 0.0)
    law = elastic.replace(**{next(iter(elastic.parameters)): stiff * 1e4 * (1 if name == "linear" else 1e3)})
    step = time_step.chosen(system, law, 1e-2, None)
    engine = engine_of(system, law, step)
    for k in range(1, 8):
        engine.advance(k * 2e-4)
        open_now = engine.open_contacts()
        listed = set(zip(open_now["first"].tolist(), open_now["second"].tolist(), strict=True))
        now = system_at(system, engine.time, engine.state())
        assert listed == overlaps(now)
        assert engine.observe()["n_in_contact"] == len(listed)


@draws(15)
@given(system=boxes(), law=laws(), data=st.data())
def test_pauses_threads_and_saving_do_not_change_a_bit(system, law, data):
    step = time_step.chosen(system, law, 1e-2, None)
    whole, broken = engine_of(system, law, step), engine_of(system, law, step)
    for k in range(1, 4):
        until = k * 150.3 * step
        whole.advance(until)
        while broken.time < until or broken.paused:
            broken.advance(
                until, threads=data.draw(st.integers(1, 3)), max_work=data.draw(st.integers(1, 60))
            )
            if data.draw(st.booleans()):
                broken = _core.load_engine("newton_steps", broken.save())
    assert everything(whole) == everything(broken)


@pytest.mark.parametrize(
    ("boundary", "dimension"),
    [
        slow("periodic", 3),
        ("periodic", 2),
        ("wall", 3),
        slow("wall", 2),
        ("lees-edwards", 3),
        slow("lees-edwards", 2),
    ],
)
def test_the_same_bits_with_any_number_of_threads(dimension, boundary):
    options = {"boundary": boundary, "gravity": 9.81}
    if boundary == "lees-edwards":
        options = {"boundary": ["periodic", boundary, "periodic"][:dimension], "shear_rate": 100.0}
    system = lattice(1500, dimension, seed=4, spread=1.3, **options)
    states = set()
    for threads in (1, 2, 3, 8):
        engine = engine_of(system, GLASS, 2e-6)
        for k in (1, 2):
            engine.advance(k * 1e-3, threads=threads)
        states.add(everything(engine))
    assert len(states) == 1 and engine.n_contacts > 500 and engine.statistics()["n_lists"] > 5


#: What drives a box, or moves its images.
DRIVEN = {
    "kicks": {"thermostat": hl.RandomKicks(power=1e-5, interval=5e-4)},
    "shaken walls": {
        "boundary": "wall",
        "gravity": 9.81,
        "walls": {
            "z-": hl.MovingWall(3e-4, 40.0, "parabola"),
            "x+": hl.MovingWall(1e-4, 60.0, velocity=-0.1),
        },
    },
    "shear across y": {"boundary": ("periodic", "lees-edwards", "periodic"), "shear_rate": 300.0},
    "shear across z": {"boundary": ("periodic", "periodic", "lees-edwards"), "shear_rate": 300.0},
}


@pytest.mark.parametrize("drive", DRIVEN)
def test_threads_change_no_bit_of_a_driven_run(drive):
    system = hl.ParticleSystem.random(600, 0.4, (0.6e-3, 1.4e-3), 2500.0, 0.3, seed=6, **DRIVEN[drive])
    law = GLASS.replace(stiffness=2e3)
    single, *several = (
        molecular_dynamics(system, law=law, until=1.2e-3, threads=threads, samples=2) for threads in (1, 2, 3)
    )
    work = single.series[{"kicks": "heat", "shaken walls": "wall_work"}.get(drive, "shear_work")]
    assert work.values[-1] != 0.0 and single.n_contacts > 100
    for other in several:
        assert single.system == other.system and single.series.identical(other.series)


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_order_of_many_forces_on_a_body_does_not_depend_on_the_threads(dimension):
    """In a crystal whose particles all overlap: with three or more forces the order of a sum changes its bits."""
    rng = np.random.default_rng(dimension)
    along = math.ceil(1500 ** (1.0 / dimension))
    points = np.stack(np.meshgrid(*[np.arange(along)] * dimension, indexing="ij"), -1).reshape(-1, dimension)
    positions = 2e-3 * (points + 0.5 + rng.uniform(-0.05, 0.05, points.shape))
    box = {"box": [along * 2e-3] * dimension, "boundary": "periodic", "allowed_overlap": 0.5}
    system = hl.ParticleSystem(positions, 0.0 * positions, 1.1e-3, density=2500.0, **box)
    states = set()
    for threads in (1, 2, 3, 8):
        engine = engine_of(system, GLASS, 2e-6)
        engine.advance(1e-5, threads=threads)
        assert engine.outcome == "ok" and len(engine.open_contacts()["first"]) > 1.5 * system.n
        states.add(everything(engine))
    assert len(states) == 1


@pytest.mark.parametrize("stiffness", [1e5, 1e9])
@pytest.mark.parametrize("seed", range(4))
def test_who_becomes_fast_between_two_meetings_of_the_threads_changes_no_bit(seed, stiffness):
    """Overlapping particles released nearly at rest: speeds grow by a large factor within a few steps."""
    rng = np.random.default_rng(seed)
    dimension = 2 + seed % 2
    sides = {"boundary": ("periodic", "wall")[seed // 2], "gravity": 9.81 * (seed % 3)}
    calm = lattice(700, dimension, seed=seed, spread=1.3, **sides)
    large = np.where(rng.random(calm.n) < 0.03, (1.8, 1.7)[seed == 3], 1.0) * calm.radius
    slow, shape = (0.0, 1e-3)[seed // 2] * calm.velocities, {"box": calm.box, "allowed_overlap": 0.9}
    system = hl.ParticleSystem(calm.positions, slow, large, density=2500.0, **shape, **sides)
    step = 2e-6 * math.sqrt(1e5 / stiffness)
    states = set()
    for threads in (1, 2, 3, 8):
        engine = engine_of(system, hl.LinearDashpot(stiffness=stiffness, restitution=0.5), step)
        for k in (1, 2):
            while engine.time < k * 350.3 * step or engine.paused:
                engine.advance(k * 350.3 * step, 10**6 if threads == 2 else int(rng.integers(1, 90)), threads)
                if threads == 3 and engine.paused:
                    engine = _core.load_engine("newton_steps", engine.save())
                assert engine.outcome == "ok"
        states.add(everything(engine) + repr(engine.statistics()["n_lists"]).encode())
    assert len(states) == 1 and engine.n_logged > 10 and engine.statistics()["n_lists"] > 3


def test_overlapped_contacts_are_those_that_share_a_particle_while_they_last():
    law = GLASS.replace(stiffness=2e3)
    run = molecular_dynamics(lattice(60, seed=2), law=law, until=8e-3, log=True)
    log = {name: run.contacts[name].values for name in run.contacts}
    ends = np.where(np.isnan(log["end"]), math.inf, log["end"])
    rows = [{first, second} for first, second in zip(log["first"], log["second"], strict=True)]
    shared = np.zeros(len(rows), bool)
    for i, j in itertools.combinations(range(len(rows)), 2):
        if log["begin"][j] < ends[i] and any(body >= 0 for body in rows[i] & rows[j]):
            shared[[i, j]] = True
    assert np.array_equal(shared, log["overlapped"]) and 0.1 < shared.mean() < 0.9
    assert (np.diff(log["begin"]) >= 0.0).all()
    over = np.isfinite(ends)
    assert run.n_ended == over.sum() and run.n_overlapped == (log["overlapped"] & over).sum()


def test_mirror_images_move_as_mirror_images():
    system = lattice(60, seed=5, spread=2.0, boundary=("wall", "periodic", "periodic"))
    flip = np.array([-1.0, 1.0, 1.0])
    mirrored = system.replace(
        positions=system.positions * flip + np.array([system.box[0], 0.0, 0.0]),
        velocities=system.velocities * flip,
    )
    run, other = (by_steps(s, GLASS, 2e-3, 30) for s in (system, mirrored))
    assert np.allclose(other.system.velocities * flip, run.system.velocities, atol=1e-6)
    assert run.n_contacts == other.n_contacts > 30


@pytest.mark.slow
def test_a_heap_comes_to_rest_and_carries_its_weight():
    law = hl.LinearDashpot(stiffness=5e3, restitution=0.3)
    system = lattice(20, 2, seed=1, boundary=("wall", "wall"), gravity=9.81)
    run = molecular_dynamics(system, law=law, until=1.0, samples=10)
    # The static contacts remain; those at the floor carry the total weight.
    assert run.series.kinetic_energy[-1] < 1e-12 * run.series.kinetic_energy[0]
    now = run.system
    floor = law.between(hl.Ball(1e-3, density=2500.0)).stiffness
    force = floor * np.maximum(now.radius - now.positions[:, 1], 0.0).sum()
    assert force == pytest.approx(9.81 * now.mass.sum(), rel=1e-6)
    assert run.series.n_in_contact[-1] >= 20
    assert run.energy_error < 1e-2


def test_pressure_of_a_cold_crystal_is_that_of_its_springs():
    """A square lattice of disks at rest that overlap: p·V = Σ r·F/2 exactly."""
    n, width, overlap = 6, 2e-3, 2e-5
    edge = width - overlap
    grid = np.stack(np.meshgrid(np.arange(n), np.arange(n), indexing="ij"), -1).reshape(-1, 2)
    at = (grid + 0.5) * edge
    system = hl.ParticleSystem(
        at, np.zeros_like(at), width / 2, density=2500.0, box=n * edge, allowed_overlap=0.02
    )
    law = hl.LinearDashpot(stiffness=1e4, damping=0.0)
    run = molecular_dynamics(system, law=law, until=1e-3, samples=2)
    pressure = 2 * n * n * edge * 1e4 * overlap / 2.0 / (n * edge) ** 2
    assert run.series.pressure.values[1:] == pytest.approx([pressure] * 2, rel=1e-9)
    assert run.n_contacts == 2 * n * n and run.n_ended == 0


def test_a_law_by_the_material_for_each_of_many_kinds_of_particles():
    law = hl.Tsuji(youngs_modulus=1e7, poisson_ratio=0.3, restitution=0.8)
    system = lattice(100, seed=6, spread=2.0)
    assert len(np.unique(system.radius)) > 64
    run = by_steps(system, law, 3e-3, 200)
    alone = run.contacts.where(~run.contacts.overlapped & run.contacts.end.notnull(), drop=True)
    assert len(alone.begin) > 20
    ratio = alone.separation_speed / alone.impact_speed
    head_on = alone.impact_speed > 0.5
    assert np.abs(ratio[head_on] - 0.8).max() < 0.02


# --- the function -------------------------------------------------------------------------------------------


def test_series_and_repr():
    run = molecular_dynamics(lattice(64, seed=3), law=GLASS, until=4e-3, samples=8)
    series = run.series
    assert series.time.values == pytest.approx(np.arange(9) * 5e-4)
    energy = sum(series[f"{kind}_energy"] for kind in ("kinetic", "potential", "contact", "dissipated"))
    assert np.abs(energy - energy[0]).max() < 2e-3 * float(series.kinetic_energy[0])
    assert run.energy_error == pytest.approx(float(np.abs(energy - energy[0]).max() / energy[0]), rel=1e-9)
    assert int(series.n_contacts[-1]) == run.n_contacts > 10
    rate = 2.0 * run.n_pairs / (64 * run.time)
    assert float(series.collision_rate[1:].mean()) == pytest.approx(rate)
    assert "contacts in 0.004 s, ok" in repr(run) and "error of the energy balance" in run._repr_html_()
    with pytest.raises(ValueError, match="log: got False"):
        _ = run.contacts


def test_a_longer_run_has_more_samples_and_an_earlier_end_is_refused(tmp_path):
    path = tmp_path / "run.npz"
    molecular_dynamics(lattice(20, seed=7), law=GLASS, until=2e-3, samples=20, checkpoint=path)
    longer = hl.resume(path, until=3e-3)
    assert longer.time == 3e-3 and len(longer.series.time) == 31
    with pytest.raises(ValueError, match=r"until: got 0\.001, must be >= 0\.003"):
        hl.resume(path, until=1e-3)
    with pytest.raises(ValueError, match="max_collisions: got 3, must be left out"):
        hl.resume(path, max_collisions=3)


def test_a_state_that_is_damaged_is_refused():
    engine = engine_of(lattice(8), GLASS, 1e-6)
    state = engine.save()
    for bad in (b"", state[:-1], state + b"0", state[:100] + b"!" + state[101:]):
        with pytest.raises(ValueError, match="saved: got"):
            _core.load_engine("newton_steps", bad)


def test_the_step_is_found_for_the_system():
    system = lattice(27)
    coarse, fine = (
        molecular_dynamics(system, law=GLASS, until=0.0, restitution_error=e).time_step for e in (1e-2, 1e-4)
    )
    assert 4.0 < coarse / fine < 20.0
    stiff = molecular_dynamics(system, law=GLASS.replace(stiffness=4e5), until=0.0, restitution_error=1e-4)
    assert stiff.time_step == pytest.approx(fine / 2.0, rel=1e-12)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"time_step": 1e-3}, r"time_step: got 0\.001 s, must be <= .* s, the longest step"),
        ({"time_step": 0.0}, r"time_step: got 0, must be > 0"),
        ({"time_step": 1e-7, "restitution_error": 1e-3}, "restitution_error | time_step: got both"),
        ({"restitution_error": 0.2}, r"restitution_error: got 0\.2, must be in \[1e-09, 0\.05\]"),
        ({"engine": "leaps"}, "engine: got 'leaps', must be"),
        (
            {"engine": "events", "time_step": 1e-7},
            "time_step: got 1e-07, must be left out with engine 'events'; 'steps' or 'lammps' accepts it",
        ),
        ({"engine": "events", "restitution_error": 1e-3}, "restitution_error: got 0.001, must be left out"),
        ({"engine": "events", "threads": 2}, "threads: got 2, must be left out"),
        ({"until": -1.0}, "until: got -1"),
        ({"threads": 0}, "threads: got 0, must be"),
        ({"samples": 0}, "samples: got 0, must be"),
        ({"checkpoint_every": 0.0}, "checkpoint_every: got 0, must be"),
        ({"progress": 3}, "progress: got 3, must be"),
    ],
)
def test_bad_input_is_refused_in_one_line(changes, message):
    arguments = {"system": lattice(8), "law": GLASS, "until": 1e-3} | changes
    with pytest.raises(ValueError, match=message) as refused:
        molecular_dynamics(**arguments)
    assert "\n" not in str(refused.value)


def test_a_run_that_is_not_stable_ends_with_an_outcome():
    """The engine accepts any step; a particle that moves too far in one step ends the run."""
    system = lattice(125, seed=1)
    engine = engine_of(system, GLASS, 3e-4)
    assert engine.early_end is None
    engine.advance(1.0)
    assert engine.outcome == "unresolved" and engine.time < 1.0
    time, (fastest,), wall = engine.early_end
    speeds = np.linalg.norm(engine.state()[1], axis=1)
    assert time == engine.time and wall is None
    assert (
        speeds[fastest] * 3e-4 > 0.25 * 2.0 * system.radius.min()
    )  # the largest allowed displacement in a step
    again = _core.load_engine("newton_steps", engine.save())
    assert again.early_end == engine.early_end


@pytest.mark.parametrize("threads", [1, 2, 3])
@pytest.mark.parametrize("curvature", [300.0, 1000.0])
def test_a_leap_beyond_the_list_of_neighbours_ends_a_run_that_is_not_stable(threads, curvature):
    """A slow body is accelerated strongly in one step between two synchronizations of the threads, and might pass a
    neighbour unnoticed.
    """
    calm, step = lattice(125, seed=1), 1e-4
    system = calm.replace(velocities=1e-3 * calm.velocities)
    law = hl.LinearDashpot(stiffness=curvature * calm.mass[0] / step**2, damping=0.0)
    rng = np.random.default_rng(threads)
    whole, broken = engine_of(system, law, step), engine_of(system, law, step)
    whole.advance(1.0)
    while broken.outcome == "ok":
        broken.advance(1.0, int(rng.integers(1, 3)), threads)
        if broken.paused:
            broken = _core.load_engine("newton_steps", broken.save())
    assert whole.outcome == "unresolved" and everything(whole) == everything(broken)
    assert whole.early_end == broken.early_end
    speeds = np.linalg.norm(whole.state()[1], axis=1)
    assert whole.early_end[1] == [np.argmax(speeds)]
    assert speeds.max() * step < 0.25 * 2.0 * system.radius.min()  # no further than in a valid step


@pytest.mark.parametrize(
    "heat", [hl.Andersen(temperature=0.3, rate=2000.0), hl.RandomKicks(power=0.1, interval=1e-5)]
)
def test_the_step_suits_the_heat_to_come(heat):
    """The same step from cold and from warm grains, and energy is balanced."""
    law = hl.Viscoelastic(youngs_modulus=1e8, poisson_ratio=0.3, restitution=0.7, impact_speed=1.0)
    runs = [
        hl.molecular_dynamics(
            hl.ParticleSystem.random(60, 0.2, 1e-3, 2500.0, speed, seed=2, thermostat=heat),
            law=law, until=0.01, engine="steps",
        )
        for speed in (1e-4, 0.1)
    ]  # fmt: skip
    assert runs[0].time_step == runs[1].time_step
    assert max(run.energy_error for run in runs) < 3e-3


@pytest.mark.parametrize("frequency", [4e4, 3e5])
def test_the_step_resolves_the_oscillation_of_a_wall(frequency):
    system = hl.ParticleSystem.random(20, 0.2, 1e-3, 2500.0, 0.3, seed=2, boundary=("periodic", "periodic", "wall"),
                                      gravity=9.81, walls={"z-": hl.MovingWall(1e-6, frequency)})  # fmt: skip
    law = hl.LinearDashpot(stiffness=1e4, restitution=0.9)
    steps, events = (
        hl.molecular_dynamics(system, law=law, until=0.02, engine=name) for name in ("steps", "events")
    )
    assert steps.energy_error < 3e-3
    assert float(steps.series.wall_work[-1]) == pytest.approx(float(events.series.wall_work[-1]), rel=0.02)


@pytest.mark.parametrize(("dimension", "rate"), [(2, 50.0), (3, 5.0), slow(2, 5.0), slow(3, 50.0)])
def test_the_step_suits_the_heat_of_shear(dimension, rate):
    """From cold grains, whose speeds grow tenfold: the step has the accepted error at all impacts to come."""
    law = hl.Viscoelastic(youngs_modulus=1e7, poisson_ratio=0.3, restitution=0.9, impact_speed=0.3)
    system = hl.ParticleSystem.random(
        60, 0.2, 1e-3, 2500.0, 1e-4, dimension=dimension, seed=1, shear_rate=rate,
        boundary=["periodic", "lees-edwards", "periodic"][:dimension],
    )  # fmt: skip
    run = molecular_dynamics(system, law=law, until=40.0 / rate, log=True)
    (contact,) = contacts.of_kinds(system, law)
    fastest = float(run.contacts.impact_speed.max())
    assert fastest > 5.0 * time_step.largest_speed(system)
    assert run.time_step < 1.05 * _core.longest_step(contact, fastest, 1e-3)
    assert run.energy_error < 3e-3
