"""Gravity along periodic axes accelerates all particles alike: engines use a frame that falls with them."""

import numpy as np
import pytest

import hardlimit as hl
from box_engines import LAW, RUNS, run
from conftest import lattice
from hardlimit.boxes import hard_spheres, newton, rules
from hardlimit.boxes.engines import NewtonSettings
from hardlimit.boxes.run import Output
from hardlimit.boxes.system import described

G = np.array([0.3, -9.81, 2.0])
every_run = pytest.mark.parametrize("name", RUNS)


def grains(seed=1, boundary="periodic", gravity=0.0):
    return hl.ParticleSystem.random(
        12, packing_fraction=0.15, radius=(0.006, 0.01), density=2500.0, rms_speed=0.5, seed=seed,
        boundary=boundary, gravity=gravity,
    )  # fmt: skip


@pytest.mark.parametrize("boundary", ["periodic", ("wall", "periodic", "periodic")], ids=["free", "a wall"])
@every_run
def test_a_fall_changes_nothing_but_the_common_motion(name, boundary):
    """Gravity towards walls acts as usual; along periodic axes paths are those without gravity plus g t²/2."""
    still = G * [boundary != "periodic", 0.0, 0.0]
    system, free = grains(2, boundary, G), grains(2, boundary, still)
    fell, flew = (run(name, s, 0.5, samples=8, log=True) for s in (system, free))
    assert fell.outcome == flew.outcome == "ok" and len(fell.log[0]) > 20
    for a, b in zip(fell.log, flew.log, strict=True):
        assert np.array_equal(a, b, equal_nan=True)
    fall, mass = G - still, system.mass.sum()
    speed = fall * fell.time
    assert fell.system.velocities - flew.system.velocities == pytest.approx(
        np.broadcast_to(speed, (12, 3)), abs=1e-14
    )
    apart = (fell.system.positions - flew.system.positions - 0.5 * fell.time * speed) / system.box
    assert apart - np.round(apart) == pytest.approx(0.0, abs=1e-13)
    for key in ("granular_temperature", "dissipated_energy", "pressure"):
        assert np.array_equal(fell.series[key], flew.series[key], equal_nan=True)
    gained = fall * fell.series.time.values[:, None]
    momentum = (system.mass @ system.velocities)[None, :]
    kinetic = flew.series.kinetic_energy + (gained * momentum + 0.5 * mass * gained**2).sum(axis=1)
    assert fell.series.kinetic_energy.values == pytest.approx(kinetic.values, rel=1e-13)
    now = fell.system
    assert fell.series.kinetic_energy[-1] == pytest.approx(now.kinetic_energy, rel=1e-13)


def events_of(name, until):
    """Cost of a run: number of events, or of neighbour lists for the time-stepping engine."""
    system = grains(4, gravity=[0.0, 0.0, -9.81])
    if name in ("events", "steps"):
        step = RUNS[name][1].get("time_step")
        whole = newton.start(name, system, NewtonSettings(LAW), until, Output(1), step)
    else:
        arguments = dict.fromkeys(("law", "restitution", "rule", "contact_duration")) | RUNS[name][1]
        settings = rules.checked_settings(**arguments)
        whole = hard_spheres.start(system, settings, hard_spheres.End(until, None), Output(1))
    whole.run(lambda done, total: None)
    return whole.engine.compiled.statistics()["n_lists" if name == "steps" else "n_events"]


@pytest.mark.parametrize("name", ["elastic", "soft", "events", "steps"])
def test_the_cost_grows_as_the_time(name):
    """The cost is linear in time: the rate of cell crossings does not increase, and decreases if energy is lost."""
    short = 0.5 if name == "steps" else 20.0
    first, whole = (events_of(name, until) for until in (short, 8.0 * short))
    assert first > 5 and whole < 9.0 * first


@pytest.mark.parametrize(
    ("boundary", "gravity", "along"),
    [
        ("periodic", 9.81, "z"),
        ("periodic", [1.0, 0.0, -9.81], "x and z"),
        (["periodic", "periodic", "wall"], [1.0, 0.0, -9.81], "x"),
        (["periodic", "periodic", "wall"], 9.81, None),
        ("wall", 9.81, None),
        ("periodic", 0.0, None),
    ],
)
def test_a_fall_without_end_is_said(boundary, gravity, along):
    """By the system, the table of the command line and that of a notebook."""
    system = lattice(boundary=boundary, gravity=gravity)
    rows = dict(described(system))
    said = repr(system), system._repr_html_()
    if along is None:
        assert not any("free fall" in text for text in (*said, *rows))
    else:
        assert rows[f"free fall along {along}"] == "of all together, without end: no wall there"
        assert f"in free fall along {along}>" in said[0] and "free fall along" in said[1]
