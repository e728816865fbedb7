"""Tests of virial and pressure tensor of the engines of boxes."""

import itertools

import numpy as np
import pytest
import scipy

import hardlimit as hl
from conftest import slow
from hardlimit.boxes.box import component_axes

LAWS = {
    "linear": hl.LinearDashpot(stiffness=1e5, restitution=0.8),
    "viscoelastic": hl.Viscoelastic(youngs_modulus=1e8, poisson_ratio=0.3, restitution=0.7, impact_speed=1.0),
    "tsuji": hl.Tsuji(elastic_prefactor=1e6, restitution=0.6),
}
RADIUS = 1e-3
BALL = hl.Ball(RADIUS, density=2500.0)
RULES = {
    "constant": {"restitution": 0.8},
    "law": {"law": LAWS["viscoelastic"]},
    "soft": {"law": LAWS["linear"]},
}
#: Positions in units of the radius, and velocities [m/s]. In "three" the two contacts overlap in time.
STARTS = {
    "pair": ([[0, 0, 0], [1.9, 0.65, 0.2]], [[1.0, 0.3, 0.0], [-0.8, -0.2, 0.1]]),
    "grazing": ([[0, 0, 0], [0.4, 2.0, 0.2]], [[1.0, 0.3, 0.0], [-0.8, -0.2, 0.1]]),
    "three": (
        [[0, 0, 0], [1.9, 0.65, 0.2], [2.6, 2.536, 0.2]],
        [[1.0, 0.3, 0.0], [-0.8, -0.2, 0.1], [0.1, -0.9, 0.2]],
    ),
}


def system_of(start, turn=None, edge=0.1):
    turn = scipy.spatial.transform.Rotation.identity() if turn is None else turn
    places, velocities = (np.array(part, float) for part in STARTS[start])
    places = edge / 2 + RADIUS * turn.apply(places)
    return hl.ParticleSystem(places, turn.apply(velocities), RADIUS, density=2500.0, box=edge)


def matrix(components):
    """The symmetric matrix with these components."""
    dimension = {3: 2, 6: 3}[len(components)]
    first, second = component_axes(dimension)
    tensor = np.zeros((dimension, dimension))
    tensor[first, second] = tensor[second, first] = components
    return tensor


def virial(run):
    """The virial of the whole run [J s]."""
    return matrix(run.samples["virial_tensor"][-1])


def run_of(engine, system, law, until, **options):
    if engine in RULES:
        return hl.event_driven(system, rule=engine, until=until, **RULES[engine], **options)
    if engine == "steps":
        options["time_step"] = law.between(BALL, BALL).duration(1.0) / 1000
    return hl.molecular_dynamics(system, law=law, engine=engine, until=until, **options)


def integrated(system, law, until):
    """∫ Σ r⊗F dt of the pairs by direct integration of Newton's equations."""
    contact = law.between(BALL, BALL)
    n, mass = system.n, float(system.mass[0])

    def rates(_, y):
        x, v = y[: 3 * n].reshape(n, 3), y[3 * n : 6 * n].reshape(n, 3)
        force, pressing = np.zeros((n, 3)), np.zeros((3, 3))
        for i, j in itertools.combinations(range(n), 2):
            r, u = x[j] - x[i], v[j] - v[i]
            distance = np.sqrt(r @ r)
            if distance < 2 * RADIUS:
                f = float(contact.force(2 * RADIUS - distance, -(r @ u) / distance)) * r / distance
                force[j] += f
                force[i] -= f
                pressing += np.outer(r, f)
        return np.concatenate([y[3 * n : 6 * n], (force / mass).ravel(), pressing.ravel()])

    start = np.concatenate([system.positions.ravel(), system.velocities.ravel(), np.zeros(9)])
    step = contact.duration(1.0) / 10
    solution = scipy.integrate.solve_ivp(
        rates, (0.0, until), start, "DOP853", rtol=1e-11, atol=1e-16, max_step=step
    )
    return solution.y[6 * n :, -1].reshape(3, 3)


@pytest.mark.parametrize(
    ("start", "law"),
    [
        (start, law) if k == m else slow(start, law)
        for k, start in enumerate(STARTS)
        for m, law in enumerate(LAWS)
    ],
)
def test_the_virial_is_that_of_direct_integration(start, law):
    system, until = system_of(start), 1.5e-3
    expected = integrated(system, LAWS[law], until)
    size = abs(expected).max()
    for engine, error in (("events", 1e-7), ("steps", 1e-4)):
        run = run_of(engine, system, LAWS[law], until, samples=1)
        assert run.n_contacts == system.n - 1
        assert virial(run) == pytest.approx(expected, abs=error * size)


@pytest.mark.parametrize("at", [0.6, slow(0.3), slow(0.9)])
def test_a_virial_during_a_contact_is_that_so_far(at):
    """A sample may lie within an isolated contact or a cluster."""
    for start in ("pair", "three"):
        system, law = system_of(start), LAWS["viscoelastic"]
        whole = run_of("events", system, law, 1.5e-3, samples=1, log=True)
        begin, end = float(whole.contacts.begin[0]), float(whole.contacts.end[-1])
        until = begin + at * (end - begin)
        expected = integrated(system, law, until)
        run = run_of("events", system, law, until, samples=1)
        assert virial(run) == pytest.approx(expected, abs=1e-7 * abs(expected).max())


@pytest.mark.parametrize("engine", [*RULES, "events", "steps"])
def test_a_head_on_collision_along_an_axis_has_this_component_only(engine):
    for dimension, axis in ((2, 0), (2, 1), (3, 0), (3, 1), (3, 2)):
        along = np.eye(dimension)[axis]
        system = hl.ParticleSystem(
            [0.05 - 1.5 * RADIUS * along, 0.05 + 1.5 * RADIUS * along],
            [along, -along],
            RADIUS,
            density=2500.0,
            box=0.1,
        )
        run = run_of(engine, system, LAWS["linear"], 2e-3, samples=1)
        sums = virial(run)
        assert sums[axis, axis] > 0.0
        sums[axis, axis] = 0.0
        assert (sums == 0.0).all()
        tensor = matrix(run.series.pressure_tensor.values[-1])
        tensor[axis, axis] = 0.0
        assert abs(tensor - np.diag(np.diag(tensor))).max() == 0.0


@pytest.mark.parametrize("engine", [*RULES, "events", "steps"])
@pytest.mark.parametrize("start", STARTS)
def test_the_virial_turns_with_the_system(engine, start):
    turn = scipy.spatial.transform.Rotation.from_euler("xyz", [0.4, -1.1, 2.3])
    plain, turned = (
        virial(run_of(engine, system_of(start, by), LAWS["linear"], 1.5e-3, samples=1))
        for by in (scipy.spatial.transform.Rotation.identity(), turn)
    )
    r = turn.as_matrix()
    assert turned == pytest.approx(r @ plain @ r.T, abs=1e-8 * abs(plain).max())


@pytest.mark.parametrize("engine", RULES)
@pytest.mark.parametrize("start", ["pair", "grazing"])
def test_the_virial_of_a_rule_is_that_of_its_paths(engine, start):
    """d/dt Σ m x⊗v = Σ m v⊗v + virial, along straight paths up to the collision and from it on.

    Under the soft rule the paths after the contact are exact, and so is the sum over the whole contact.
    """
    system, until = system_of(start), 1e-3
    run = run_of(engine, system, None, until, samples=1, log=True)
    at, mass = float(run.collisions.time[0]), np.asarray(system.mass)[:, None]
    before, after = (s.velocities.T @ (mass * s.velocities) for s in (system, run.system))
    moved = run.system.positions.T @ (mass * run.system.velocities) - system.positions.T @ (
        mass * system.velocities
    )
    expected = moved - at * before - (until - at) * after
    assert run.n_collisions == 1
    assert virial(run) == pytest.approx(expected, abs=1e-9 * abs(expected).max())


def test_the_engines_agree_on_a_stiff_system():
    stiff = hl.LinearDashpot(stiffness=1e8, restitution=0.8)
    system = hl.ParticleSystem.random(60, 0.3, RADIUS, 2500.0, 1.0, seed=3)
    until = 1.2e-3
    duration = stiff.between(BALL, BALL).duration(1.0)
    events = hl.molecular_dynamics(system, law=stiff, engine="events", until=until, samples=1)
    steps = hl.molecular_dynamics(
        system, law=stiff, engine="steps", until=until, samples=1, time_step=duration / 60
    )
    hard = hl.event_driven(system, restitution=0.8, until=until, samples=1)
    soft = hl.event_driven(system, law=stiff, rule="soft", until=until, samples=1)
    assert hard.n_collisions == events.n_contacts > 60
    expected = virial(events)
    for run, error in ((steps, 5e-3), (hard, 3e-2), (soft, 5e-3)):
        assert virial(run) == pytest.approx(expected, abs=error * np.trace(expected) / 3)
