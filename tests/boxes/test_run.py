"""Runs of particle systems: series, logs, ends, checkpoints that survive a killed process, theory."""

import json
import math
import pickle
import random
import signal
import subprocess
import sys
import zipfile
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import hardlimit as hl
from box_engines import interrupt_at
from conftest import lattice, slow, wait_until
from hardlimit.boxes import theory
from hardlimit.boxes.box import wall_name
from hardlimit.boxes.result import EarlyEnd
from same_samples import same_samples

LAW = hl.LinearDashpot(stiffness=1e5, restitution=0.8)
RULES = {
    "constant": {"restitution": 0.9},
    "elastic": {"restitution": 1.0},
    "tc": {"restitution": 0.6, "rule": "tc", "contact_duration": 1e-5},
    "law": {"law": hl.Viscoelastic(youngs_modulus=1e8, poisson_ratio=0.3, restitution=0.8, impact_speed=1.0)},
    "tc with a law": {"law": LAW, "rule": "tc", "contact_duration": 1e-5},
}
every_rule = pytest.mark.parametrize("rule", RULES)
BOXES = {
    "periodic": {"n": 64},
    "walls and gravity": {"n": 27, "boundary": "wall", "gravity": [1.0, -2.0, -9.81]},
    "disks": {"n": 49, "dimension": 2, "boundary": ["periodic", "wall"], "gravity": 9.81},
    "sizes": {"n": 64, "spread": 3.0},
}


def same(left, other):
    """Whether two runs are bit-identical, including series and log."""
    assert left.system == other.system and left.time == other.time and left.outcome == other.outcome
    assert same_samples(left, other)
    assert (left.log is None) == (other.log is None)
    for a, b in zip(left.log or (), other.log or (), strict=True):
        assert np.array_equal(a, b)
    counts = ("n_collisions", "n_pairs", "n_walls", "n_elastic_by_tc", "n_soft", "n_soft_third_body")
    assert [getattr(left, name) for name in counts] == [getattr(other, name) for name in counts]
    return True


# --- results ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("box", BOXES)
@every_rule
def test_series_and_log_belong_together(box, rule):
    system = lattice(**BOXES[box])
    run = hl.event_driven(system, until=0.02, samples=20, log=True, **RULES[rule])
    assert run.outcome == "ok" and run.outcome_code == 0 and run.time == 0.02
    series, log = run.series, run.collisions
    assert series.sizes["time"] == 21 and series.time.values == pytest.approx(np.linspace(0.0, 0.02, 21))
    assert log.sizes["collision"] == run.n_collisions == series.n_collisions.values[-1] > 20
    t, first, second = (log[name].values for name in ("time", "first", "second"))
    assert np.all(np.diff(t) >= 0.0) and np.all((first < second) | (second < 0)) and np.all(first >= 0)
    assert run.n_walls == np.sum(second < 0) and run.n_pairs == np.sum(second >= 0)
    inside = np.searchsorted(t, series.time.values, side="right")
    assert series.n_collisions.values.tolist() == inside.tolist()
    pairs = np.cumsum(second >= 0)
    rate = 2.0 * np.diff(np.concatenate([[0], pairs])[inside]) / (system.n * 0.001)
    assert series.collision_rate.values[1:] == pytest.approx(rate, rel=1e-9)
    assert math.isnan(series.collision_rate.values[0]) and math.isnan(series.pressure.values[0])
    energy = series.kinetic_energy + series.potential_energy + series.dissipated_energy
    assert energy.values == pytest.approx(energy.values[0], rel=1e-10)
    assert series.granular_temperature.values[0] == pytest.approx(system.granular_temperature, rel=1e-12)
    assert series.granular_temperature.values[-1] == pytest.approx(run.system.granular_temperature, rel=1e-9)
    assert series.kinetic_energy.values[-1] == pytest.approx(run.system.kinetic_energy, rel=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_pressure_from_the_log(dimension):
    """Σ r·Δp over the logged collisions, plus the kinetic part, which is constant."""
    system = lattice(36, dimension, spread=2.0)
    run = hl.event_driven(system, restitution=1.0, until=0.05, samples=5, log=True)
    _, first, second, speed, _ = run.log
    m, radius = np.asarray(system.mass), np.asarray(system.radius)
    reduced = m[first] * m[second] / (m[first] + m[second])
    virial = np.sum((radius[first] + radius[second]) * 2.0 * reduced * speed)
    kinetic = system.granular_temperature * dimension * m.sum()
    expected = (kinetic + virial / 0.05) / (dimension * np.prod(system.box))
    assert run.series.pressure.values[1:].mean() == pytest.approx(expected, rel=1e-9)
    assert run.series.pressure.attrs["units"] == ("N/m" if dimension == 2 else "Pa")


def test_the_final_state_is_a_system():
    for box in BOXES.values():
        system = lattice(**box)
        run = hl.event_driven(system, restitution=0.9, until=0.03)
        end = run.system
        assert end == end.replace(positions=end.positions)  # through every check, inside the box
        assert end.mass.tolist() == system.mass.tolist() and end.boundary == system.boundary
        again = hl.event_driven(end, restitution=0.9, max_collisions=50)
        assert again.n_collisions == 50


def test_a_result_is_a_value():
    run = hl.event_driven(lattice(8), restitution=0.9, until=0.01, log=True)
    assert same(pickle.loads(pickle.dumps(run)), run)
    assert "8 particles" in repr(run) and "collisions per particle" in run._repr_html_()
    with pytest.raises(ValueError, match="read-only"):
        run.series["pressure"][:] = 0.0
    with pytest.raises(ValueError, match="read-only"):
        run.collisions["time"][:] = 0.0
    with pytest.raises(ValueError, match=r"^log: got False, must be True"):
        _ = hl.event_driven(lattice(8), restitution=0.9, until=0.01).collisions


# --- end of a run, and its samples --------------------------------------------------------------------------


def test_samples_change_nothing():
    runs = [
        hl.event_driven(lattice(64), restitution=0.8, until=0.02, samples=s, log=True) for s in (1, 7, 300)
    ]
    assert [run.series.sizes["time"] for run in runs] == [2, 8, 301]
    assert runs[0].system == runs[1].system == runs[2].system
    assert all(np.array_equal(runs[0].log[0], run.log[0]) for run in runs)


def test_a_run_ends_at_its_last_collision():
    system = lattice(64)
    whole = hl.event_driven(system, restitution=0.9, until=0.02, log=True)
    for most in (1, 2, 100):
        run = hl.event_driven(system, restitution=0.9, until=0.02, max_collisions=most, log=True)
        assert run.n_collisions == most and run.time == whole.log[0][most - 1] == run.series.time[-1]
        assert np.array_equal(run.log[1], whole.log[1][:most])
        alone = hl.event_driven(system, restitution=0.9, max_collisions=most)
        assert alone.system == run.system and alone.time == run.time
    none = hl.event_driven(system, restitution=0.9, max_collisions=0)
    assert (none.n_collisions, none.time, none.series.sizes["time"]) == (0, 0.0, 1)
    still = hl.event_driven(system, restitution=0.9, until=0.0)
    assert still.system == system and still.series.sizes["time"] == 1


@pytest.mark.parametrize("samples", [1, 10, 100])
@pytest.mark.parametrize("most", [30, 3000])
def test_samples_without_an_end_in_time_find_their_spacing(samples, most):
    run = hl.event_driven(lattice(64), restitution=0.8, max_collisions=most, samples=samples)
    t = run.series.time.values
    assert len(t) <= 2 * samples + 2 and len(t) >= min(samples, most) // 2
    assert np.diff(t[:-1]) == pytest.approx(t[1] - t[0], rel=1e-9)
    assert t[-1] == run.time and run.n_collisions == most


def test_where_nothing_collides_a_run_ends():
    at, v = [[0.01, 0.01], [0.03, 0.03]], [[1e-3, 0.0], [1e-3, 0.0]]
    for speeds in (v, np.zeros((2, 2))):
        run = hl.event_driven(
            hl.ParticleSystem(at, speeds, 1e-3, mass=1.0, box=0.05), restitution=1.0, max_collisions=5
        )
        assert run.outcome == "no further collisions" and run.n_collisions == 0
        assert hl.OUTCOMES[run.outcome_code] == "no_contact"
        assert run.system.velocities.tolist() == np.asarray(speeds).tolist()


def test_an_inelastic_collapse_is_an_outcome():
    heap = lattice(27, boundary="wall", gravity=9.81)
    run = hl.event_driven(heap, restitution=0.3, until=10.0, log=True)
    assert hl.OUTCOMES[run.outcome_code] == "collapse" and 0.0 < run.time < 10.0
    end = run.early_end
    assert isinstance(end, EarlyEnd) and end.time == run.time
    assert all(0 <= i < 27 for i in end.particles) and len(end.particles) == (2 if end.wall is None else 1)
    assert end.position == tuple(run.system.positions[end.particles[0]])
    assert "inelastic collapse: particle" in run.outcome and "\n" not in run.outcome
    second = end.particles[1] if end.wall is None else end.wall
    last = np.flatnonzero((run.log[1] == end.particles[0]) & (run.log[2] == second))
    assert len(last) > 5  # they collide repeatedly


def test_what_is_thrown_falls_back():
    """Disks that bounce separately, through many cells up and down."""
    n, g = 16, 9.81
    speed = np.linspace(0.1, 1.0, n)
    at = np.stack([0.01 * np.arange(n) + 0.005, np.full(n, 0.02)], axis=1)
    up = np.stack([np.zeros(n), speed], axis=1)
    system = hl.ParticleSystem(at, up, 1e-3, mass=1.0, box=[0.16, 0.2], boundary="wall", gravity=g)
    run = hl.event_driven(system, restitution=1.0, until=2.0, log=True)
    fast = np.sqrt(speed**2 + 2.0 * g * 0.019)
    expected = sorted(
        t
        for v, w in zip(speed, fast, strict=True)
        for k in range(99)
        if (t := (v + w * (1 + 2 * k)) / g) < 2.0
    )
    assert run.log[0] == pytest.approx(expected, rel=1e-12) and set(run.log[2]) == {-3}


def test_names_of_walls():
    assert [wall_name(number) for number in (-1, -2, -3, -4, -5, -6)] == [
        "x = 0", "x = L", "y = 0", "y = L", "z = 0", "z = L",
    ]  # fmt: skip


def test_the_share_that_tc_makes_elastic():
    system = lattice(64)
    run = hl.event_driven(system, until=0.05, **RULES["tc"])
    assert 0.0 < run.elastic_share == run.n_elastic_by_tc / run.n_collisions < 0.5
    never = hl.event_driven(system, restitution=0.6, rule="tc", contact_duration=0.0, until=0.05)
    assert never.elastic_share == 0.0
    assert never.system == hl.event_driven(system, restitution=0.6, until=0.05).system
    assert math.isnan(hl.event_driven(system, restitution=0.6, until=0.01).elastic_share)


# --- bad input ----------------------------------------------------------------------------------------------

BAD = {
    "no rule": ({"restitution": None}, "law | restitution: got neither, must be exactly one of them"),
    "both": ({"law": LAW}, "law | restitution: got both, must be exactly one of them"),
    "too elastic": ({"restitution": 1.1}, "restitution: got 1.1, must be in [0, 1]"),
    "no end": ({"until": None}, "until | max_collisions: got neither, must be at least one of them"),
    "before the start": ({"until": -1.0}, "until: got -1, must be >= 0 and finite"),
    "collisions": ({"max_collisions": -1}, "max_collisions: got -1, must be a whole number"),
    "another rule": ({"rule": "hard"}, "rule: got 'hard', must be one of constant, law, soft, tc"),
    "law without a law": ({"rule": "law"}, "rule: got 'law', must be one of constant, tc with restitution"),
    "soft without a law": ({"rule": "soft"}, "rule: got 'soft', must be one of constant, tc with restitution"),
    "tc without": ({"rule": "tc"}, "contact_duration: missing, must be >= 0 for the rule tc"),
    "tc negative": ({"rule": "tc", "contact_duration": -1.0}, "contact_duration: got -1, must be >= 0"),
    "duration of another": ({"contact_duration": 1.0}, "contact_duration: got 1.0, must be left out"),
    "no samples": ({"samples": 0}, "samples: got 0, must be a whole number"),
    "progress": ({"progress": 1}, "progress: got 1, must be True, False or callable"),
    "checkpoint nowhere": ({"checkpoint": "/none/x"}, "checkpoint: got '/none/x', must be a file in a folder"),
    "checkpoint folder": ({"checkpoint": "/"}, "checkpoint: got '/', must be a file in a folder"),
    "checkpoint name": ({"checkpoint": "\0"}, "checkpoint: got "),
    "never": ({"checkpoint_every": 0.0}, "checkpoint_every: got 0, must be > 0 and finite"),
}  # fmt: skip


@pytest.mark.parametrize("which", BAD)
def test_bad_arguments_are_refused_in_one_line(which):
    changed, message = BAD[which]
    arguments = {"system": lattice(8), "restitution": 0.9, "until": 0.01} | changed
    with pytest.raises(ValueError) as refusal:
        hl.event_driven(arguments.pop("system"), **arguments)
    assert str(refusal.value).startswith(message) and "\n" not in str(refusal.value)


@pytest.mark.parametrize("misspelled", ["restitutoin", "contact_durtion"])
def test_a_misspelled_argument_is_named(misspelled):
    """Also where nothing else is given."""
    with pytest.raises(TypeError, match=f"got an unexpected keyword argument '{misspelled}'"):
        hl.event_driven(lattice(8), until=1e-3, **{misspelled: 0.9})


def test_progress_counts_collisions():
    told = []
    run = hl.event_driven(lattice(64), restitution=0.9, until=0.05, progress=lambda *seen: told.append(seen))
    assert told[-1] == (run.n_collisions, run.n_collisions)
    assert all(0 <= done <= total for done, total in told)
    told.clear()
    hl.event_driven(
        lattice(64), restitution=0.9, max_collisions=500, progress=lambda *seen: told.append(seen)
    )
    assert told[-1] == (500, 500) and all(total == 500 for _, total in told)


# --- checkpoints --------------------------------------------------------------------------------------------


@every_rule
@pytest.mark.parametrize("box", BOXES)
def test_a_resumed_run_has_the_bits_of_one_that_was_not_stopped(tmp_path, box, rule):
    system, path = lattice(**BOXES[box]), tmp_path / "run.checkpoint"
    whole = hl.event_driven(system, until=0.02, samples=20, log=True, **RULES[rule])
    part = hl.event_driven(system, until=0.01, samples=10, log=True, checkpoint=path, **RULES[rule])
    assert part.time == 0.01
    assert same(hl.resume(path, until=0.02), whole)
    assert same(hl.resume(path), whole)  # it has reached its end time
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


def test_soft_contacts_are_counted():
    law = hl.LinearDashpot(stiffness=2e4, restitution=0.8)
    whole = hl.event_driven(lattice(64), law=law, rule="soft", until=0.02)
    assert 0 < whole.n_soft <= whole.n_collisions and 0.0 < whole.third_body_share < 1.0
    assert math.isnan(whole.elastic_share) and whole.settings.rule == "soft"


@pytest.mark.parametrize("speed", [1e-3, 0.0045, 0.02, 0.1])
@pytest.mark.parametrize("away", [0, 1])
def test_a_body_that_just_reaches_a_ceiling(speed, away):
    """The equivalent collision puts it on a parabola inside the wall; it must not hit the wall again before t_c."""
    radius, law = 1e-4, hl.LinearDashpot(stiffness=1e8, damping=100.0)
    height, down = 8e-4, 3.5 * (1 if away else -1)
    start = radius if away else height - radius  # gravity leads away from the wall that it touches
    velocities, shape = [[0.0, -speed if away else speed]], {"box": [8e-4, height], "gravity": (0.0, down)}
    system = hl.ParticleSystem(
        [[4e-4, start]], velocities, radius, mass=1.0, boundary=("periodic", "wall"), **shape
    )
    g = abs(down)
    until = 0.8 * (math.sqrt(2.0 * (height - 2.0 * radius) / g + (speed / g) ** 2) - speed / g)
    soft = hl.event_driven(system, law=law, rule="soft", until=until, log=True)
    newton = hl.molecular_dynamics(system, law=law, engine="events", until=until, log=True)
    assert soft.outcome_name == "ok" and soft.n_collisions == newton.n_contacts == 1
    assert not math.isnan(float(newton.contacts.end[0])) and float(newton.contacts.end[0]) < until
    assert soft.system.positions == pytest.approx(newton.system.positions, abs=1e-9 * height)
    assert soft.system.velocities == pytest.approx(newton.system.velocities, abs=1e-9)
    lost = system.kinetic_energy - soft.system.kinetic_energy
    lost += down * float(soft.system.positions[0, 1] - start)
    assert float(soft.series.dissipated_energy[-1]) == pytest.approx(lost, abs=1e-12)


def test_what_the_soft_rule_cannot_describe_ends_the_run():
    """A contact beyond the range of any law ends the run."""
    radius, law = 1e-3, hl.LinearDashpot(stiffness=1.4e11, damping=10.0)
    heavy = hl.ParticleSystem(
        positions=[[0.005, 0.01], [0.01, 0.01]],
        velocities=[[10.0, 0.0], [0.0, 0.0]],
        radius=radius,
        mass=1e3,
        box=[0.02] * 2,
    )
    through = hl.event_driven(heavy, law=law, rule="soft", until=1.0, log=True)
    assert through.outcome_name == "too_deep" and "half of the smaller radius" in through.outcome
    assert through.largest_compression == pytest.approx(0.6, rel=0.01) and len(through.collisions.time) == 1
    assert through.early_end == EarlyEnd(through.time, tuple(through.system.positions[0]), (0, 1), None)
    assert "of particles 0 and 1 at 0.0003 s, near (0.008, 0.01) m" in through.outcome
    assert np.isfinite(through.system.positions).all() and through.time == pytest.approx(0.003 / 10.0)


@pytest.mark.parametrize(
    ("height", "damping", "name", "said"),
    [
        (1e-3, 0.1, "at_rest", "at rest: gravity holds particle 1 and the wall y = 0 together at 0 s"),
        (1.5e-3, 10.0, "at_rest", "gravity holds particle 1 and the wall y = 0 together at 0.0100964 s"),
        (
            1.5e-3,
            1e4,
            "unresolved",
            "a contact of particle 1 and the wall y = 0 takes too many steps, at 0.0100964 s",
        ),
    ],
    ids=["lies", "creeps to rest", "too many steps"],
)
def test_every_early_end_says_when_where_and_with_whom(tmp_path, height, damping, name, said):
    """A body at rest, and two that come to rest; also stored in the checkpoint."""
    path, law = tmp_path / "run.checkpoint", hl.LinearDashpot(stiffness=1e3, damping=damping)
    system = hl.ParticleSystem(
        positions=[[0.005, 0.015], [0.01, height]], velocities=np.zeros((2, 2)), radius=1e-3, mass=1e-3,
        box=[0.02] * 2, boundary=("periodic", "wall"), gravity=(0.0, -9.81),
    )  # fmt: skip
    run = hl.event_driven(system, law=law, rule="soft", until=1.0, checkpoint=path)
    fall = math.sqrt(2.0 * (height - 1e-3) / 9.81)
    assert run.outcome_name == name and said in run.outcome and "near (0.01, 0.001) m" in run.outcome
    assert run.early_end == EarlyEnd(run.time, (0.01, 1e-3), (1,), -3)
    assert run.early_end.time == pytest.approx(fall)
    again = hl.resume(path, until=2.0)
    assert (again.outcome, again.early_end) == (run.outcome, run.early_end)


#: Rules for a body without free space, with the contact law for Newton's equations.
NOWHERE = {
    "elastic": {"restitution": 1.0},
    "constant": {"restitution": 0.5},
    "nearly elastic": {"restitution": 0.999},
    "tc": {"restitution": 0.5, "rule": "tc", "contact_duration": 1e-3},
    "law": {"law": LAW},
    **{
        f"soft, {type(law).__name__}": {"law": law, "rule": "soft"}
        for law in (
            hl.LinearDashpot(stiffness=3.8e6, restitution=0.5),
            hl.Tsuji(elastic_prefactor=1e6, restitution=0.5),
            hl.Viscoelastic(youngs_modulus=1e8, poisson_ratio=0.3, restitution=0.5, impact_speed=1.0),
        )
    },
}
MOST_AT_ONCE = 13_000


@pytest.mark.parametrize("rule", NOWHERE)
@pytest.mark.parametrize(
    ("fitting", "speed", "gravity"),
    [(1, 1.0, 0.0), (1, 1e-165, 9.81), (2, 0.0, 9.81), (2, 1e-165, 0.0), (3, 1e-320, 9.81), (3, 1.0, 0.0)],
)
def test_bodies_that_fit_exactly_between_walls_end_or_go_on(rule, fitting, speed, gravity):
    """A chain without gaps between two walls, whose first ball moves: a named outcome and bounded values."""
    radius, settings = 0.25, NOWHERE[rule]
    system = hl.ParticleSystem(
        [[3.0, radius * (2 * k + 1)] for k in range(fitting)], [[0.5, speed]] + [[0.5, 0.0]] * (fitting - 1),
        radius, mass=1.0, box=[6.0, 2.0 * radius * fitting], boundary="wall", gravity=gravity,
    )  # fmt: skip
    run = hl.event_driven(system, until=5.0, log=True, **settings)
    assert run.outcome_name in ("ok", "collapse", "at_rest") and run.n_collisions <= MOST_AT_ONCE
    assert len(run.collisions.time) == run.n_collisions and np.isfinite(run.system.velocities).all()
    if run.outcome_name != "ok":
        assert run.early_end.wall in (-3, -4) or len(run.early_end.particles) == 2
        assert "use molecular_dynamics" in run.outcome and run.early_end.who() in run.outcome
        assert rule in ("constant", "nearly elastic", "law") or "the rule tc" not in run.outcome
    if gravity and speed == 0.0:
        assert run.outcome_name == "at_rest" and run.early_end == EarlyEnd(0.0, (3.0, radius), (0,), -3)


@pytest.mark.parametrize("engine", ["events", "steps"])
@pytest.mark.parametrize("speed", [0.0, 1e-320, 1e-165, 1.0])
def test_newton_goes_on_where_there_is_no_room(engine, speed):
    """The advice of the error message works. Regression: the contact table crashed with a NaN index."""
    system = hl.ParticleSystem(
        [[1.0, 3.0]], [[speed, 1.0]], 1.0, mass=1.0, box=[2.0, 6.0], boundary="wall", gravity=[0.0, -0.1]
    )
    law = NOWHERE["soft, LinearDashpot"]["law"]
    run = hl.molecular_dynamics(system, law=law, until=0.5, engine=engine)
    assert run.outcome == "ok" and run.time == 0.5 and np.isfinite(run.system.positions).all()
    assert abs(run.system.velocities[0, 0]) <= speed and run.system.velocities[0, 1] == pytest.approx(0.95)


@pytest.mark.parametrize("rule", [name for name in NOWHERE if name.startswith("soft")])
@pytest.mark.parametrize(("speed", "gravity"), [(0.0, -4e-313), (1e-165, 0.0), (1e-320, 1e-313)])
def test_a_cluster_whose_energy_is_no_number(rule, speed, gravity):
    """Regression: its unit of speed was zero, which gave NaN with the outcome ok."""
    system = hl.ParticleSystem(
        [[1.0, 1.0]], [[speed, 0.0]], 1.0, mass=1.0, box=[2.0, 2.0], boundary="wall", gravity=[gravity, 0.0]
    )
    run = hl.molecular_dynamics(system, law=NOWHERE[rule]["law"], until=0.01)
    assert np.isfinite(run.system.positions).all() and np.isfinite(run.system.velocities).all()
    assert abs(run.system.velocities).max() <= 2.0 * speed + 1e-300


def test_a_ceiling_reached_without_speed_holds_nobody():
    """Gravity points away from the ceiling: the collision at zero speed does not bring the ball to rest."""
    system = hl.ParticleSystem(
        [[1.0, 1.0]], [[0.0, 1.0]], 0.5, mass=1.0, box=[2.0, 2.0], boundary="wall", gravity=1.0
    )
    for settings in (NOWHERE["elastic"], NOWHERE["constant"], NOWHERE["soft, LinearDashpot"]):
        run = hl.event_driven(system, until=1.5, log=True, **settings)
        assert run.outcome == "ok" and run.n_collisions == 1 and run.collisions.impact_speed.values == 0.0
        assert run.system.positions[0, 1] == 1.375 and run.system.velocities[0, 1] == -0.5


def test_who_ends_early_in_words():
    def who(*particles, wall=None):
        return EarlyEnd(0.0, (0.0, 0.0), particles, wall).who()

    assert who(4) == "particle 4" and who(4, wall=-6) == "particle 4 and the wall z = L"
    assert who(4, 5) == "particles 4 and 5" and who(4, 5, 7) == "particles 4, 5 and 7"
    assert who(*range(2, 42)) == "40 particles (2, 3, 4, …)"


def test_a_run_may_be_resumed_anywhere(tmp_path):
    """At end times between two samples, or after a number of collisions; the sample times do not change."""
    system, path = lattice(64), tmp_path / "run.checkpoint"
    whole = hl.event_driven(system, restitution=0.9, until=0.02, samples=8, log=True)
    hl.event_driven(
        system, restitution=0.9, until=0.02, samples=8, log=True, checkpoint=path, max_collisions=7
    )
    for end in (0.0031, 0.0075, 0.0099):
        hl.resume(path, until=end)
    hl.resume(path, max_collisions=whole.n_collisions - 3)
    assert same(hl.resume(path, until=0.02), whole)


def test_an_open_ended_run_is_resumed(tmp_path):
    system, path = lattice(64), tmp_path / "run.checkpoint"
    whole = hl.event_driven(system, restitution=0.9, max_collisions=5000, log=True)
    with pytest.raises(KeyboardInterrupt):
        hl.event_driven(
            system, restitution=0.9, max_collisions=5000, log=True, checkpoint=path, progress=interrupt_at(12)
        )
    assert same(hl.resume(path), whole)


def test_a_collapse_stays_one(tmp_path):
    heap, path = lattice(27, boundary="wall", gravity=9.81), tmp_path / "run.checkpoint"
    run = hl.event_driven(heap, restitution=0.3, until=10.0, log=True, checkpoint=path)
    assert same(hl.resume(path, until=20.0), run)


def test_the_end_must_not_lie_before_the_checkpoint(tmp_path):
    path = tmp_path / "run.checkpoint"
    run = hl.event_driven(lattice(8), restitution=0.9, until=0.01, checkpoint=path)
    with pytest.raises(ValueError, match=r"^until: got 0.005, must be >= 0.01, the time of the checkpoint$"):
        hl.resume(path, until=0.005)
    with pytest.raises(ValueError, match=r"^max_collisions: got 0, must be a whole number >= 46"):
        hl.resume(path, max_collisions=0)
    assert same(hl.resume(path), run)


def test_what_is_no_checkpoint_is_refused(tmp_path):
    path = tmp_path / "run.checkpoint"
    hl.event_driven(lattice(8), restitution=0.9, until=0.01, checkpoint=path, log=True)
    good = path.read_bytes()
    chance = random.Random(1)
    for trial in range(150):
        content = bytearray(good)
        if trial % 2:
            del content[chance.randrange(len(content)) :]
        else:
            at = chance.randrange(len(content))
            content[at] ^= chance.randrange(1, 256)
        path.write_bytes(content)
        try:
            run = hl.resume(path)
        except ValueError as error:
            assert "\n" not in str(error) and path.name in str(error)
        else:
            assert run.time == 0.01  # a byte without meaning, such as a date
        path.write_bytes(content)
    with pytest.raises(ValueError, match="cannot be read"):
        hl.resume(tmp_path)
    with pytest.raises(ValueError, match=r"^path: got 3, must be a path"):
        hl.resume(3)


def test_a_checkpoint_of_another_version_is_refused(tmp_path):
    path = tmp_path / "run.checkpoint"
    hl.event_driven(lattice(8), restitution=0.9, until=0.01, checkpoint=path)
    with np.load(path) as content:
        arrays = dict(content)
    header = json.loads(bytes(arrays["header"]))
    for key, value in (("hardlimit_version", "0.0.1"), ("format", 1)):
        text = np.frombuffer(json.dumps(header | {key: value}).encode(), np.uint8)
        with open(path, "wb") as file:
            np.savez(file, **(arrays | {"header": text}))
        with pytest.raises(ValueError, match=r"a checkpoint of hardlimit .*, must be one of"):
            hl.resume(path)
    assert zipfile.is_zipfile(path)


RUN = """
import pickle
function, system, settings = pickle.loads({start!r})
function(system, checkpoint={path!r}, checkpoint_every={every}, **settings)
"""


def started(path, every, function, system, **settings):
    """Starts a run with a checkpoint in another process."""
    source = RUN.format(start=pickle.dumps((function, system, settings)), path=str(path), every=every)
    return subprocess.Popen([sys.executable, "-c", source], stderr=subprocess.PIPE, text=True)


LONG = {"restitution": 0.95, "until": 2.0, "samples": 50, "log": True}


@pytest.fixture(scope="module")
def uninterrupted():
    return hl.event_driven(lattice(125), **LONG)


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
@pytest.mark.parametrize("trial", [0, *map(slow, range(1, 8))])
def test_killed_at_any_moment(tmp_path, uninterrupted, trial):
    """kill -9 after or during the writing of a checkpoint: the resumed run is bit-identical."""
    path = tmp_path / "run.checkpoint"
    chance = random.Random(trial)
    for _ in range(3):
        process = (
            resumed(path) if path.exists() else started(path, 1e-9, hl.event_driven, lattice(125), **LONG)
        )
        stamps = set()
        many = chance.randrange(1, 12)

        def seen(stamps=stamps, many=many, process=process):
            if path.exists():
                stamps.add(path.stat().st_mtime_ns)
            return len(stamps) > many or process.poll() is not None

        wait_until(seen)
        process.kill()
        process.communicate()
    assert len(list(tmp_path.iterdir())) <= 2  # one that is not finished
    assert same(hl.resume(path), uninterrupted)
    assert list(tmp_path.iterdir()) == [path]


#: A resumed run has to know the phases of walls, the displacement of images and the number of kicks.
DRIVES = {
    "shear and kicks": {
        "boundary": ("periodic", "lees-edwards", "periodic"), "shear_rate": 40.0,
        "thermostat": hl.RandomKicks(power=1e-4, interval=1e-3, seed=2),
    },
    "shaken floor": {
        "boundary": ("periodic", "periodic", "wall"), "gravity": 9.81,
        "walls": {"z-": hl.MovingWall(amplitude=5e-4, frequency=50.0)},
    },
}  # fmt: skip
SOLVERS = {
    "constant": (hl.event_driven, {"restitution": 0.9}),
    "soft": (hl.event_driven, {"law": LAW, "rule": "soft"}),
    "events": (hl.molecular_dynamics, {"law": LAW, "engine": "events"}),
    "steps": (hl.molecular_dynamics, {"law": LAW, "engine": "steps"}),
}


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals")
@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("drive", DRIVES)
def test_a_killed_run_of_a_driven_box_goes_on_with_the_same_bits(tmp_path, drive, solver):
    system = hl.ParticleSystem.random(
        100, 0.3, radius=(0.8e-3, 1.2e-3), density=2500.0, rms_speed=0.2, seed=5, **DRIVES[drive]
    )
    function, settings = SOLVERS[solver]
    settings = settings | {"until": 0.1, "samples": 50}
    path = tmp_path / "run.checkpoint"
    process = started(path, 1e-9, function, system, **settings)
    stamps = set()

    def seen():
        if path.exists():
            stamps.add(path.stat().st_mtime_ns)
        return len(stamps) > 3 or process.poll() is not None

    wait_until(seen)
    process.kill()
    _, errors = process.communicate()
    assert process.returncode == -signal.SIGKILL, errors
    whole, resumed = function(system, **settings), hl.resume(path)
    assert resumed.system == whole.system and resumed.series.identical(whole.series)


def resumed(path):
    source = f"import hardlimit as hl; hl.resume({str(path)!r})"
    return subprocess.Popen([sys.executable, "-c", source], stderr=subprocess.PIPE, text=True)


def test_control_c_leaves_a_last_checkpoint(tmp_path):
    path = tmp_path / "run.checkpoint"
    with started(
        path, 1e9, hl.event_driven, lattice(125), **LONG | {"until": 1e9}
    ) as process:  # only the first and the last checkpoint
        try:
            wait_until(path.exists)
            first = path.stat().st_mtime_ns
            process.send_signal(signal.SIGINT)
            _, errors = process.communicate(timeout=60)
        finally:
            process.kill()
    assert "KeyboardInterrupt" in errors and process.returncode
    assert path.stat().st_mtime_ns > first
    then = hl.resume(path, max_collisions=10**9, until=reached(path))
    whole = hl.event_driven(lattice(125), restitution=0.95, until=then.time, log=True)
    assert then.system == whole.system and all(map(np.array_equal, then.log, whole.log))


def reached(path):
    """A time slightly after a checkpoint: 1.1 times that of the last collision in its log."""
    with np.load(path) as content:
        times = content["log_0"]
    return 1.1 * float(times[-1]) if len(times) else 0.01


def test_runs_in_threads_are_those_of_one():
    system = lattice(64)
    alone = hl.event_driven(system, restitution=0.9, until=0.05, log=True)
    with ThreadPoolExecutor(4) as pool:
        runs = pool.map(lambda _: hl.event_driven(system, restitution=0.9, until=0.05, log=True), range(4))
        assert all(same(run, alone) for run in runs)


# --- theory -------------------------------------------------------------------------------------------------


def gas(packing_fraction, dimension=3, n=1000):
    """A gas of unit spheres or disks at this packing fraction."""
    ball = math.pi * 0.25 if dimension == 2 else math.pi / 6.0
    return theory.Gas(n, 0.5, 1.0, n * ball / packing_fraction, dimension)


def test_theory_is_that_of_the_literature():
    assert gas(0.3).pressure(1.0) * gas(0.3).volume / 1000 == pytest.approx(
        3.9738, abs=5e-5
    )  # Carnahan & Starling
    simulated = {0.1: 1.5217, 0.2: 2.4094, 0.3: 3.9838, 0.4: 6.9429, 0.45: 9.3993}  # Kolafa et al. 2004
    for phi, z in simulated.items():
        assert gas(phi).pressure(1.0) * gas(phi).volume / 1000 == pytest.approx(z, rel=3e-3)
    henderson = (1.0 + 0.5**2 / 8.0) / (1.0 - 0.5) ** 2
    assert gas(0.5, 2).pressure(1.0) * gas(0.5, 2).volume / 1000 == pytest.approx(henderson)
    half = gas(0.5 * math.pi / 6.0)  # n (2R)³ = 0.5
    assert 1.0 / half.collision_rate(1.0) == pytest.approx(0.1303, rel=5e-3)  # Lue 2005, in 2R/√T
    dilute = gas(1e-6)
    assert dilute.mean_free_path == pytest.approx(
        1.0 / (math.sqrt(2.0) * math.pi * 1000 / dilute.volume), rel=1e-5
    )


def test_a_temperature_beyond_all_scales_is_refused():
    with pytest.raises(ValueError, match=r"\Atemperature: got 1e\+306, must be in \[0, 1e\+201\]"):
        gas(0.3).pressure(1e306)


@pytest.mark.parametrize("dimension", [2, 3])
def test_cooling_obeys_its_equation(dimension):
    theory_of = gas(0.2, dimension)
    t, e, step = np.linspace(1e-4, 50.0, 7), 0.8, 1e-4
    temperature = theory_of.cooling(t, 2.0, e)
    slope = (theory_of.cooling(t + step, 2.0, e) - theory_of.cooling(t - step, 2.0, e)) / (2.0 * step)
    assert slope == pytest.approx(
        -(1.0 - e**2) * theory_of.collision_rate(temperature) * temperature / dimension, rel=1e-6
    )
    assert theory_of.pressure(1.0, 0.0) < theory_of.pressure(1.0, 1.0)


@pytest.mark.parametrize("dimension, packing", [(2, 3.5e-3), (3, 3.2e-3)])
def test_a_gas_does_what_theory_says(dimension, packing):
    """About 1000 particles: collision rate and pressure to about 1 %, cooling to a few per cent."""
    dense = lattice(1000, dimension)
    box = np.asarray(dense.box) * packing / 3e-3
    system = dense.replace(positions=dense.positions * (packing / 3e-3), box=box)
    relaxed = hl.event_driven(system, restitution=1.0, max_collisions=20_000).system
    theory_of = theory.gas(relaxed)
    run = hl.event_driven(relaxed, restitution=1.0, max_collisions=60_000)
    temperature = relaxed.granular_temperature
    ds, weight = run.series, np.diff(run.series.time)
    rate = np.average(ds.collision_rate.values[1:], weights=weight)
    pressure = np.average(ds.pressure.values[1:], weights=weight)
    assert rate == pytest.approx(float(theory_of.collision_rate(temperature)), rel=0.02)
    assert pressure == pytest.approx(float(theory_of.pressure(temperature)), rel=0.02)
    cooled = hl.event_driven(relaxed, restitution=0.95, max_collisions=5_000)
    expected = theory_of.cooling(np.array(cooled.time), temperature, 0.95)
    assert float(expected) < 0.75 * temperature
    assert cooled.system.granular_temperature == pytest.approx(float(expected), rel=0.03)


def test_theory_says_where_it_does_not_hold():
    for changed, reason in (
        ({"boundary": "wall"}, "it has walls"),
        ({"gravity": 1.0}, "it has gravity"),
        ({"spread": 2.0}, "its particles differ"),
    ):
        with pytest.raises(ValueError, match=f"^system: {reason}, must be a gas of equal particles"):
            theory.gas(lattice(8, **changed))
    assert theory.why_not(3) == "got 3"
    hexatic = lattice(9, 2).replace(
        radius=1.3e-3, positions=(np.indices((3, 3)).reshape(2, -1).T + 0.5) * 3e-3
    )
    squeezed = hexatic.replace(box=7.95e-3, positions=hexatic.positions * (7.95 / 9.0))
    assert "above 0.7" in str(theory.why_not(squeezed))


@pytest.mark.parametrize("newton", [False, True])
def test_a_run_that_goes_on_for_too_many_samples_is_refused(newton: bool, tmp_path) -> None:
    """The sample spacing is fixed, so a much later end time would need too many samples."""
    system = hl.ParticleSystem([[0.02, 0.05]], [[1.0, 0.0]], 0.01, density=2500.0, box=0.1, boundary="wall")
    path, law = tmp_path / "run", hl.LinearDashpot(stiffness=1e7, restitution=0.9)
    if newton:
        hl.molecular_dynamics(system, law=law, until=1e-9, samples=100, checkpoint=path)
    else:
        hl.event_driven(system, restitution=1.0, until=1e-9, samples=100, checkpoint=path)
    with pytest.raises(
        ValueError, match=r"^until: got 1, must be <= 0.0001: the interval between samples is fixed"
    ):
        hl.resume(path, until=1.0)
    assert hl.resume(path, until=2e-9).time == 2e-9
