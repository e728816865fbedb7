"""Compressions in particle simulations: their largest value, and runs that end beyond the range of the law."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hardlimit as hl
from conftest import draws
from hardlimit.contact import compression

ENGINES = ["events", "steps"]
LAWS = [
    hl.LinearDashpot(stiffness=1.0, restitution=0.8),
    hl.LinearDashpot(stiffness=1.0, restitution=0.05),
    hl.Viscoelastic(youngs_modulus=1.0, poisson_ratio=0.3, dissipative_time=0.0),
    hl.Viscoelastic(youngs_modulus=1.0, poisson_ratio=0.3, restitution=0.5, impact_speed=1.0),
    hl.Tsuji(elastic_prefactor=1.0, restitution=0.4),
]


def stiffer(law: hl.Law, factor: float) -> hl.Law:
    name = next(n for n in ("stiffness", "youngs_modulus", "elastic_prefactor") if n in law.parameters)
    return law.replace(**{name: factor * law.parameters[name]})


def pair(
    radii: tuple[float, float] = (0.1, 0.1), speed: float = 1.0, dimension: int = 2
) -> hl.ParticleSystem:
    """Two balls, with 1 kg per 0.1 m of radius, that approach head-on at this relative speed."""
    middle = [0.5] * (dimension - 1)
    still = [0.0] * (dimension - 1)
    gap = 0.05
    return hl.ParticleSystem(
        [[0.5 - radii[0] - gap, *middle], [0.5 + radii[1] + gap, *middle]],
        [[0.5 * speed, *still], [-0.5 * speed, *still]],
        radii, mass=[10.0 * r for r in radii], box=1.0,
    )  # fmt: skip


def ball_at_wall(radius: float = 0.1, speed: float = 1.0) -> hl.ParticleSystem:
    return hl.ParticleSystem(
        [[1.05 * radius + 0.05, 0.5]], [[-speed, 0.0]], radius, mass=10.0 * radius, box=1.0, boundary="wall"
    )


def law_for(law: hl.Law, contact_of: Any, part: float, radius: float, speed: float = 1.0) -> hl.Law:
    """The law whose stiffness gives this compression, relative to the radius, at this impact speed; by bisection."""
    low, high = -20.0, 60.0
    for _ in range(100):
        middle = 0.5 * (low + high)
        deep = float(contact_of(stiffer(law, math.exp(middle))).compression(speed)) > part * radius
        low, high = (middle, high) if deep else (low, middle)
    return stiffer(law, math.exp(high))


@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_compression_of_an_isolated_contact(law: hl.Law) -> None:
    """The largest compression agrees with a numerical integration of the force and with undamped closed forms."""
    contact = stiffer(law, 1e6).between(hl.Ball(0.1, mass=1.0))
    h, x, v, deepest = contact.duration(1.0) / 2_000, 0.0, 1.0, 0.0
    while v > 0.0:
        a = -float(contact.force(x + 1e-300, v)) / contact.effective_mass
        middle = v + 0.5 * h * a
        a = -float(contact.force(x + 0.5 * h * v, middle)) / contact.effective_mass
        x, v = x + h * middle, v + h * a
        deepest = max(deepest, x)
    assert contact.compression(1.0) == pytest.approx(deepest, rel=2e-4)


def test_closed_forms_of_the_compression() -> None:
    ball, speeds = hl.Ball(0.1, mass=1.0), np.geomspace(1e-6, 1e3, 20)
    linear = hl.LinearDashpot(stiffness=5e4, restitution=1.0).between(ball)
    assert linear.compression(speeds) == pytest.approx(speeds * math.sqrt(1.0 / 5e4), rel=1e-12)
    hertz = hl.Viscoelastic(youngs_modulus=1e7, poisson_ratio=0.3, dissipative_time=0.0).between(ball)
    rho = float(hertz.force(1.0))
    assert hertz.compression(speeds) == pytest.approx((1.25 * speeds**2 / rho) ** 0.4, rel=1e-12)


@draws(12)
@given(
    law=st.sampled_from(LAWS), sizes=st.tuples(st.floats(0.02, 0.1), st.floats(0.02, 0.1)),
    part=st.floats(0.01, 0.49), wall=st.booleans(), dimension=st.sampled_from([2, 3]),
)  # fmt: skip
def test_the_largest_compression_is_that_of_the_isolated_contact(
    law: hl.Law, sizes: tuple[float, float], part: float, wall: bool, dimension: int
) -> None:
    """The largest compression is that of the isolated contact, in every engine and rule with a law."""
    system = ball_at_wall(sizes[0]) if wall else pair(sizes, dimension=dimension)
    small = sizes[0] if wall else min(sizes)
    balls = [hl.Ball(r, mass=10.0 * r) for r in sizes]

    def contact_of(law: hl.Law) -> hl.Contact:
        return law.between(balls[0]) if wall else law.between(*balls)

    fitting = law_for(law, contact_of, part, small)
    until = 0.1 + 2.0 * float(contact_of(fitting).duration(1.0))
    exact = hl.molecular_dynamics(system, engine="events", law=fitting, until=until, samples=2)
    assert exact.outcome == "ok" and exact.largest_compression == pytest.approx(part, rel=1e-7)
    steps = hl.molecular_dynamics(system, law=fitting, until=until, samples=2, engine="steps")
    assert steps.outcome == "ok" and steps.largest_compression == pytest.approx(part, rel=0.02)
    for rule in ("law", "soft"):
        run = hl.event_driven(system, law=fitting, rule=rule, until=until)
        assert run.outcome == "ok" and run.largest_compression == pytest.approx(part, rel=1e-7)
    assert hl.event_driven(system, restitution=0.5, until=until).largest_compression is None


@pytest.mark.parametrize("law", LAWS, ids=repr)
@pytest.mark.parametrize("wall", [False, True])
def test_the_limit_is_sharp(law: hl.Law, wall: bool) -> None:
    """Just below the limit a run continues, just above it ends: at the limit (events) or at the begin (rules)."""
    system, ball = ball_at_wall() if wall else pair(), hl.Ball(0.1, mass=1.0)

    def contact_of(law: hl.Law) -> hl.Contact:
        return law.between(ball) if wall else law.between(ball, ball)

    below, above = (law_for(law, contact_of, 0.5 * part, 0.1) for part in (1.0 - 1e-6, 1.0 + 1e-6))
    until = 0.1 + 2.0 * float(contact_of(below).duration(1.0))
    for rule in ("law", "soft"):
        assert hl.event_driven(system, law=below, rule=rule, until=until).outcome_name == "ok"
        run = hl.event_driven(system, law=above, rule=rule, until=until)
        assert run.outcome_name == "too_deep" and run.time < 0.11
    assert hl.molecular_dynamics(system, engine="events", law=below, until=until).outcome_name == "ok"
    run = hl.molecular_dynamics(system, engine="events", law=above, until=until)
    assert run.outcome_name == "too_deep" and run.largest_compression == pytest.approx(0.5, abs=1e-9)
    end = run.early_end
    assert end is not None and end.time == run.time
    assert (end.particles, end.wall) == (((0,), -1) if wall else ((0, 1), None))
    x = run.system.positions
    deep = 0.1 - x[0, 0] if wall else 0.2 - (x[1, 0] - x[0, 0])
    assert deep == pytest.approx(0.05, rel=1e-9)
    assert run.energy_error < 1e-9
    again = hl.molecular_dynamics(run.system, engine="events", law=above, until=until)
    assert again.outcome_name == "too_deep" and again.time < 1e-9


@pytest.mark.parametrize("engine", ENGINES)
def test_balls_do_not_pass_through_each_other(engine: str) -> None:
    """The run ends before the centres meet, with the state of Newton's equations at that instant."""
    system, law = pair(), hl.LinearDashpot(stiffness=100.0, restitution=0.9)
    run = hl.molecular_dynamics(system, law=law, until=6.0, engine=engine, log=True)
    assert run.outcome_name == "too_deep" and "particles 0 and 1" in run.outcome
    assert 0.5 <= run.largest_compression + 1e-9 < 0.6
    assert run.energy_error < 2e-3 and run.n_contacts == 1 and math.isnan(run.contacts.end[0])
    assert run.series.time.values[-1] == run.time < 6.0


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_a_ball_between_two_others_is_pressed_too_deep(law: hl.Law, engine: str) -> None:
    """Two contacts overlap in time; each alone would stay below the limit."""
    system = hl.ParticleSystem(
        [[0.29, 0.5], [0.5, 0.5], [0.71, 0.5]], [[0.5, 0.0], [0.0, 0.0], [-0.5, 0.0]], 0.1, mass=1.0, box=1.0
    )
    ball = hl.Ball(0.1, mass=1.0)
    alone = law_for(law, lambda law: law.between(ball, ball), 0.45, 0.1, 0.5)
    run = hl.molecular_dynamics(system, law=alone, until=2.0, engine=engine)
    assert (
        run.outcome_name == "too_deep" and 1 in run.early_end.particles and len(run.early_end.particles) == 2
    )
    if engine == "events":
        assert run.largest_compression == pytest.approx(0.5, abs=1e-9) and run.energy_error < 1e-9


@pytest.mark.parametrize("engine", ENGINES)
def test_weight_alone_presses_too_deep(engine: str) -> None:
    """A body released in touch with the floor sinks by twice its static compression."""
    system = hl.ParticleSystem(
        [[0.5, 0.1]], [[0.0, 0.0]], 0.1, mass=1.0, box=1.0, boundary="wall", gravity=9.81
    )
    for law, ends in [(LAWS[0], True), (stiffer(LAWS[0], 3.0), False)]:
        law = stiffer(law, 2.0 * 9.81 / 0.05 * 0.5)
        run = hl.molecular_dynamics(system, law=law, until=0.5, engine=engine)
        assert (run.outcome_name == "too_deep") == ends
        assert not ends or (run.early_end.particles, run.early_end.wall) == ((0,), -3)


@draws(10, few=2)
@given(seed=st.integers(0, 10_000), law=st.sampled_from(LAWS), walls=st.booleans())
def test_both_engines_find_the_same_largest_compression(seed: int, law: hl.Law, walls: bool) -> None:
    """Dense boxes, in which most contacts overlap another one."""
    gas = hl.ParticleSystem.random(
        60, packing_fraction=0.45, radius=(0.8e-3, 1.4e-3), density=2500.0, rms_speed=1.0, dimension=2, seed=seed,
        boundary="wall" if walls else "periodic", gravity=9.81 if walls else 0.0,
    )  # fmt: skip
    ball = hl.Ball(1e-3, density=2500.0)
    fitting = law_for(law, lambda law: law.between(ball, ball), 0.08, 1e-3)
    exact, near = (
        hl.molecular_dynamics(gas, law=fitting, until=1.5e-3, engine=engine, samples=2) for engine in ENGINES
    )
    assert exact.outcome == near.outcome == "ok" and exact.cluster_share > 0.01
    assert exact.largest_compression == pytest.approx(near.largest_compression, rel=0.05)


def test_what_must_be_too_deep_is_refused() -> None:
    law = hl.LinearDashpot(stiffness=5.0, restitution=0.9)
    said = r"^law: got LinearDashpot.*stiffness=5.0.*, must be stiffer: at the mean impact speed .* hold below 0.5$"
    for run in (
        lambda: hl.molecular_dynamics(pair(speed=2.0), engine="events", law=law, until=1.0),
        lambda: hl.event_driven(pair(speed=2.0), law=law, rule="soft", until=1.0),
        lambda: hl.event_driven(pair(speed=2.0), law=law, until=1.0),
        lambda: hl.fidelity(pair(speed=2.0), law=law, until=1.0),
        lambda: hl.molecular_dynamics(ball_at_wall(), law=law, until=1.0, engine="steps"),
    ):
        with pytest.raises(ValueError, match=said):
            run()
    drifting = pair().replace(velocities=[[5.0, 0.0], [5.0, 0.0]])  # equal velocities: no collision
    assert hl.molecular_dynamics(drifting, engine="events", law=law, until=1.0).outcome == "ok"


def test_deep_contacts_come_with_a_warning() -> None:
    ball = hl.Ball(0.1, mass=1.0)
    for part in (0.049, 0.051):
        law = law_for(LAWS[0], lambda law: law.between(ball, ball), part, 0.1)
        for run in (
            lambda law=law: hl.molecular_dynamics(pair(), engine="events", law=law, until=0.3),
            lambda law=law: hl.event_driven(pair(), law=law, rule="soft", until=0.3),
        ):
            if part < compression.DEEP:
                run()
                continue
            with pytest.warns(
                hl.CompressionWarning, match=r"^contacts were compressed by more than 5 % of the"
            ):
                run()


def test_fidelity_says_how_deep_contacts_were() -> None:
    """Largest compression in every model with a law; if Newton's equations end too deep, the sentence says so."""
    gas = hl.ParticleSystem.random(30, 0.3, radius=1e-3, density=2500.0, rms_speed=1.0)
    law = hl.LinearDashpot(stiffness=2e3, restitution=0.8)
    with pytest.warns(hl.CompressionWarning, match="contacts were compressed by more than"):
        fidelity = hl.fidelity(gas, law=law, until=5e-4, replicas=2, samples=2)
    run = hl.molecular_dynamics(gas, law=law, until=5e-4, samples=2, engine="events")
    assert fidelity.largest_compression > 0.999 * run.largest_compression > 0.05
    deepest = fidelity.dataset.largest_compression.sel(statistic="mean")
    assert np.isnan(deepest.sel(model=["constant", "tc"])).all()
    assert (deepest.sel(model=["law", "soft"]) > 0.05).all()
    soft = law.replace(stiffness=40.0)
    fidelity = hl.fidelity(gas, law=soft, until=2e-3, replicas=2, samples=2, models=["newton", "law"])
    assert "contact too deep for its law" in str(fidelity)
