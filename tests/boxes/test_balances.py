"""Balances of energy and momentum under every rule, engine and law, in boxes of any boundary and drive."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import hardlimit as hl
from box_engines import LAWS, core_engine, energies, energy_error
from conftest import draws
from hardlimit import _core
from hardlimit.boxes import time_step
from same_samples import same_samples
from sheared_boxes import displaced

WAVEFORMS = ("none", "sine", "triangle", "parabola")
#: Each rule, under a restitution or a law, and each engine of ours: arguments, which a drawn law completes.
SOLVERS: dict[str, dict[str, Any]] = {
    f"{rule['name']}, {quantity}": {"rule": rule["name"], quantity: 0.9}
    | {parameter["name"]: 1e-5 for parameter in rule["parameters"]}
    for rule in _core.rules
    for quantity in ("restitution", "law")
    if rule[quantity]
} | {"events": {"engine": "events"}, "steps": {"engine": "steps", "restitution_error": 1e-4}}
each_solver = pytest.mark.parametrize("name", SOLVERS)
#: Error of the energies over the largest one; 1e-11 of rules. That of equal steps is of second order in the step.
ENERGY = {"events": 1e-9, "steps": 5e-3}


def moving_wall(random: np.random.Generator) -> hl.MovingWall:
    waveform, drift = random.choice(WAVEFORMS), random.choice([0.0, -0.02, 0.02])
    if waveform == "none":
        return hl.MovingWall(velocity=drift)
    frequency = random.uniform(15.0, 100.0)
    amplitude = min(3e-4, random.uniform(0.5, 8.0) * 9.81 / (2.0 * math.pi * frequency) ** 2)
    return hl.MovingWall(amplitude, frequency, str(waveform), random.uniform(-3.0, 3.0), velocity=drift)


def box_of(seed: int, rubs: bool = False) -> hl.ParticleSystem:
    """Periodic, walled and sheared axes; walls at rest and moving; gravity; heat; particles of like and unlike size and
    mass, or a single one. If grains rub: with spins, and heat of the spins."""
    random = np.random.default_rng(seed)
    d, n = int(random.integers(2, 4)), int(random.choice([1, 20, 30, 60], p=[0.1, 0.3, 0.3, 0.3]))
    walled, gradient = random.random(d) < 0.5, int(random.integers(1, 2 * d))  # no shear from d on
    sheared = gradient < d
    if sheared:
        walled[[0, gradient]] = False
    boundary = np.where(walled, "wall", "periodic").tolist()
    gravity = random.uniform(-9.81, 9.81, d) * (random.random() < 0.5)
    drive: dict[str, Any] = {}
    if sheared:
        boundary[gradient] = "lees-edwards"
        gravity[[0, gradient]] = 0.0
        drive["shear_rate"] = random.choice([-300.0, -20.0, 5.0, 40.0, 300.0])
    names = [f"{'xyz'[axis]}{end}" for axis in np.flatnonzero(walled) for end in "-+"]
    drive["walls"] = {name: moving_wall(random) for name in names if random.random() < 0.5}
    heat, interval = (
        random.choice(["", "", "kicks", "kicks" if sheared else "bath"]),
        random.choice([3e-4, 1e-3]),
    )
    spinning = {"rotational": random.choice([5e-4, 3e-3])} if rubs and seed % 2 else {}
    if n > 1 and heat == "kicks":
        drive["thermostat"] = hl.RandomKicks(power=1e-3, interval=interval, seed=seed, **spinning)
    elif n > 1 and heat == "bath":
        gravity[~walled] = 0.0  # a bath at rest is refused where all fall
        drive["thermostat"] = hl.Andersen(
            temperature=0.03, rate=200.0, interval=interval, seed=seed, **spinning
        )
    if rubs and walled.any():
        gravity[~walled] = 0.0  # as are walls that rub
    radius = [1e-3, (0.7e-3, 1.4e-3), (0.5e-3, 1e-3)][random.integers(3)]
    filled = random.uniform(0.05, 0.22 if n < 60 else 0.4) if n > 1 else 0.01
    system = hl.ParticleSystem.random(
        n,
        filled,
        radius,
        2500.0,
        0.3 * (n > 1),
        dimension=d,
        boundary=boundary,
        gravity=gravity,
        seed=seed,
        rms_spin=200.0 if rubs else None,
        **drive,
    )
    if sheared:
        smooth = system.replace(thermostat=None) if rubs else system  # heat of spins needs friction
        system = displaced(smooth, random.random()).replace(thermostat=system.thermostat)
    if n == 1:
        system = system.replace(velocities=random.normal(0.0, 0.3, (1, d)))
    return system.replace(mass=system.mass * 10.0 ** (random.choice([0.0, 0.0, 2.0]) * random.random(n)))


def run_of(name: str, system: hl.ParticleSystem, law: hl.Law, until: float, **options: Any) -> Any:
    settings = SOLVERS[name] | ({} if "restitution" in SOLVERS[name] else {"law": law})
    if "engine" in settings:
        return hl.molecular_dynamics(system, until=until, **settings, **options)
    return hl.event_driven(system, until=until, max_collisions=200 * system.n, **settings, **options)


@each_solver
@example(seed=50, law=LAWS[0])  # a wall that comes near between two instants
@example(seed=257989, law=LAWS[4])  # a kick of a body beyond a sheared side
@draws(60)
@given(seed=st.integers(0, 2**20), law=st.sampled_from(LAWS))
def test_energy_and_momentum(name: str, seed: int, law: hl.Law) -> None:
    """The energies change by the work of walls and shear and by the heat, the momentum by what gravity, walls and
    crossings of the sheared side give. Nothing is dissipated backwards, and particles stay between the walls."""
    system = box_of(seed)
    run = run_of(name, system, law, 0.02, samples=6, log=True)
    if run.outcome_name != "ok":
        assert run.outcome_name in ("too_deep", "collapse", "at_rest")
        return
    series, now = run.series, run.system
    scale = np.abs(energies(run)).max()
    assert energy_error(run) <= ENERGY.get(name, 1e-11)
    # A particle that is too slow to climb back to a wall after a soft contact was cut short there is lifted.
    lifted = name.startswith("soft") and system.gravity.any() and run.n_soft_third_body > 0
    backwards = 1e-4 if lifted else 1e-12
    assert np.diff(series.dissipated_energy).min() >= -backwards * scale
    if system.n == 1 and "wall_energy" in series:  # it loses energy only at walls
        lost = series.dissipated_energy - series.wall_work
        assert np.abs(series.wall_energy.sum("wall") - lost).max() <= 1e-10 * scale
    check_momentum(run, system)
    if name == "events":
        check_contacts(run.contacts, driven=bool(system.walls) or system.thermostat is not None)
    for axis in (axis for axis, side in enumerate(system.boundary) if side == "wall"):
        low, high = now.domain.limits(axis)
        inside = -system.radius if name.startswith("soft") else 0.5 * system.radius
        assert (now.positions[:, axis] > low + inside).all() and (
            now.positions[:, axis] < high - inside
        ).all()


#: Solvers of grains that rub: arguments, which a drawn law completes.
RUBBING: dict[str, dict[str, Any]] = {
    "constant, restitution": {"friction": 0.4, "tangential_restitution": 0.5},
    "tc, restitution": {"friction": 0.4, "tangential_restitution": 0.5},
    "law, law": {},
    "soft, law": {},
    "events": {},
    "steps": {},
}


@pytest.mark.parametrize("name", RUBBING)
@draws(12, few=3)
@given(seed=st.integers(0, 2**20), law=st.sampled_from(LAWS))
def test_energy_of_grains_that_rub(name: str, seed: int, law: hl.Law) -> None:
    rough = law.replace(friction=hl.Friction(0.5, stiffness_ratio=0.8))
    run = run_of(name, box_of(seed, rubs=True), rough, 0.01, samples=4, **RUBBING[name])
    if run.outcome_name != "ok":
        # By events, clusters that rub for very long end the run: docs/limits.md.
        ends = ("too_deep", "collapse", "at_rest") + ("unresolved",) * (name == "events")
        assert run.outcome_name in ends
        return
    assert run.series.rotational_energy.min() > 0.0
    assert energy_error(run) <= ENERGY.get(name, 1e-11)
    lost = np.diff(run.series.dissipated_energy)
    assert name.startswith("soft") or lost.min() >= -1e-12 * np.abs(energies(run)).max()


def test_a_wall_contact_that_is_cut_short_keeps_the_energy() -> None:
    """Rule soft: the particle goes back to the wall along its parabola."""
    run = run_of("soft, law", box_of(593), LAWS[1], 0.02, samples=6)  # without damping
    assert run.n_soft_third_body > 0
    assert np.abs(run.series.dissipated_energy).max() <= 1e-13 * np.abs(energies(run)).max()


def check_momentum(run: Any, system: hl.ParticleSystem) -> None:
    if isinstance(system.thermostat, hl.Andersen):
        return
    gained = system.mass.sum() * system.gravity * run.time
    scale = system.mass @ np.abs(np.concatenate([system.velocities, run.system.velocities], axis=1)).max(
        axis=1
    )
    scale = np.full(system.dimension, scale) + np.abs(gained)
    if (sheared := system.domain.gradient) is not None:
        edge = system.box[sheared]
        crossed = np.floor(run.system.unfolded_positions[:, sheared] / edge)
        gained[0] -= system.shear_rate * edge * (system.mass @ crossed)
        scale[0] += abs(system.shear_rate) * edge * (system.mass @ np.abs(crossed))
    for axis, side in enumerate(system.boundary):
        if side == "wall":
            low, high = (float(run.series.wall_impulse.sel(wall="xyz"[axis] + end)[-1]) for end in "-+")
            assert low >= 0.0 and high >= 0.0
            gained[axis] += low - high
            scale[axis] += low + high
    for momentum in (run.system.momentum, run.series.momentum.values[-1]):
        assert (np.abs(momentum - system.momentum - gained) <= 1e-11 * scale).all()


def check_contacts(contacts: Any, driven: bool) -> None:
    begins, ends = contacts.begin.values, contacts.end.values
    assert np.all(np.diff(begins) >= 0.0) and np.all(ends[~np.isnan(ends)] > begins[~np.isnan(ends)])
    # Only an overlapping pair that others, a wall that turns or a kick press together engages while it separates.
    assert driven or np.all(contacts.overlapped.values[contacts.impact_speed.values <= 0.0])


@pytest.mark.parametrize("kind", ["newton_events", "newton_steps"])
@draws(60)
@given(seed=st.integers(0, 2**20), law=st.sampled_from(LAWS))
def test_no_path_leaves_its_safety_radius(kind: str, seed: int, law: hl.Law) -> None:
    system = box_of(seed)
    own = {"time_step": time_step.chosen(system, law, None, None)} if kind == "newton_steps" else {}
    engine = core_engine(kind, system, law, **own)
    for k in range(1, 9):
        engine.advance(3e-4 * k)
        assert engine.largest_safety_use(5) <= 1.0


#: Counts of both kinds of results.
COUNTS = (
    "n_pairs",
    "n_walls",
    "n_elastic_by_tc",
    "n_soft",
    "n_soft_third_body",
    "n_ended",
    "largest_compression",
)


@pytest.mark.parametrize(
    ("name", "rubs"), [*((name, False) for name in SOLVERS), *((name, True) for name in RUBBING)]
)
@draws(30, few=3)
@given(seed=st.integers(0, 2**20), law=st.sampled_from(LAWS), at=st.sampled_from([1, 2, 5]))
def test_a_resumed_run_has_the_same_bits(
    tmp_path_factory: pytest.TempPathFactory, name: str, rubs: bool, seed: int, law: hl.Law, at: int
) -> None:
    """Samples, log, counts and state of a run that was stopped after a sample, at which particles may be in contact."""
    system, path = box_of(seed, rubs), tmp_path_factory.getbasetemp() / "balances.checkpoint"
    options: dict[str, Any] = {"samples": 6, "log": True} | (RUBBING[name] if rubs else {})
    if rubs:
        law = law.replace(friction=hl.Friction(0.5, stiffness_ratio=0.8))

    def stop(time: float, _: hl.ParticleSystem) -> dict[str, float]:
        if time >= 0.01 * (at - 0.5) / 6:
            raise KeyboardInterrupt
        return {"time_again": time}

    def go_on(time: float, _: hl.ParticleSystem) -> dict[str, float]:
        return {"time_again": time}

    whole = run_of(name, system, law, 0.01, observe=go_on, **options)
    if whole.outcome_name != "ok":
        return
    with pytest.raises(KeyboardInterrupt):
        run_of(name, system, law, 0.01, observe=stop, checkpoint=path, **options)
    resumed = hl.resume(path, observe=go_on)
    assert resumed.system == whole.system and same_samples(resumed, whole)
    assert all(np.array_equal(a, b, equal_nan=True) for a, b in zip(resumed.log, whole.log, strict=True))
    for count in COUNTS:
        assert getattr(resumed, count, None) == getattr(whole, count, None), count
