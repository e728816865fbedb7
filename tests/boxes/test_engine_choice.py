"""``engine="auto"``: choice between the two engines for Newton's equations, and its report to the user."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import hardlimit as hl
from box_engines import interrupt_at, linear_law, mean_free_time
from command_line import printed, run
from conftest import draws, lattice
from hardlimit.boxes import engine_choice, time_step
from same_samples import same_samples

LAW = hl.LinearDashpot(stiffness=1e5, restitution=0.9)
GRAIN = hl.Ball(1e-3, density=2500.0)


def gas(n: int = 300, phi: float = 0.3, **options: Any) -> hl.ParticleSystem:
    return hl.ParticleSystem.random(
        **({"n": n, "packing_fraction": phi, "radius": 1e-3, "density": 2500.0, "rms_speed": 1.0} | options)
    )


def bed(**options: Any) -> hl.ParticleSystem:
    """A bed of settling disks: the first system of the issue."""
    return gas(dimension=2, rms_speed=0.1, boundary=["periodic", "wall"], gravity=9.81, **options)


def softened(system: hl.ParticleSystem, tc_nu: float, restitution: float = 0.9) -> hl.LinearDashpot:
    """The law softened to this initial t_c ν."""
    return linear_law(system, tc_nu * mean_free_time(system), restitution)


# --- choices ------------------------------------------------------------------------------------------------


def test_settling_disks_take_steps() -> None:
    """Regression: the event-driven engine took 405 s without a message."""
    law = hl.LinearDashpot(stiffness=1e4, restitution=0.7)
    engine, reason = engine_choice.estimated(bed(), law, 0.5)
    assert engine == "steps" and reason == (
        "contacts last, t_c ν = inf in a bed that is at rest after about 0.084 s"
    )
    assert engine_choice.estimated(bed(), law, 0.02).engine == "events"  # while they fall


@pytest.mark.slow
def test_settling_disks_come_to_rest() -> None:
    run = hl.molecular_dynamics(
        bed(n=100), law=hl.LinearDashpot(stiffness=1e4, restitution=0.7), until=0.25, samples=5
    )
    assert run.engine == "steps" and run.outcome == "ok" and run.energy_error < 1e-2
    assert run.series.kinetic_energy.values[-1] < 1e-3 * run.series.kinetic_energy.values[0]
    assert 2.0 < engine_choice.open_contacts(run.system) < 6.0
    again = engine_choice.estimated(run.system, run.law, 1e-9)
    assert again.engine == "steps" and again.reason.startswith("contacts last, t_c ν = ")


def test_contacts_softer_than_a_gas_take_steps() -> None:
    """Regression: ``gas --n 300 --law linear --stiffness 1e-3`` took over 100 s with the event-driven engine."""
    law = hl.LinearDashpot(stiffness=1e-3, restitution=0.9)
    assert engine_choice.estimated(gas(), law, 0.02).engine == "steps"


@pytest.mark.parametrize("restitution", [0.7, 0.9, 0.99])
@pytest.mark.parametrize(("dimension", "phi"), [(3, 0.1), (3, 0.3), (3, 0.45), (2, 0.3), (2, 0.6)])
def test_a_gas_takes_events_up_to_where_both_cost_the_same(
    dimension: int, phi: float, restitution: float
) -> None:
    """Both engines cost the same at t_c ν between 0.1 and 0.2, by measurement (docs/engines.md)."""
    system = gas(phi=phi, dimension=dimension)
    engines = {}
    for tc_nu in (1e-4, 0.01, 0.1, 0.3, 3.0):
        law = softened(system, tc_nu, restitution)
        engine, reason = engine_choice.estimated(system, law, 1.0)
        engines[tc_nu] = engine
        # Each particle has n − 1 possible partners.
        said = float(reason.split("t_c ν = ")[1].split()[0])
        assert said == pytest.approx(tc_nu * 299 / 300, rel=0.06) and "at the start a contact costs" in reason
    assert engines == {1e-4: "events", 0.01: "events", 0.1: "events", 0.3: "steps", 3.0: "steps"}


def test_the_costs_that_are_said_are_those_of_the_formula() -> None:
    system = gas()
    law = softened(system, 0.25)
    step = time_step.chosen(system, law, None, None)
    duration, _, temperature = engine_choice.typical_contact(system, law)
    rate = engine_choice._collision_rate(system, temperature)
    events, steps = 1.6 + 35.0 * rate * duration, 9.0 + 4.5e-3 / (rate * step)
    assert duration == pytest.approx(law.between(GRAIN, GRAIN).duration())
    assert (
        f"{events:.2g} µs by events, {steps:.2g} µs by steps"
        in engine_choice.estimated(system, law, 1.0).reason
    )
    assert "more than 9 µs by steps" in engine_choice.estimated(system, softened(system, 0.1), 1.0).reason
    # A smaller error needs more steps.
    finer = engine_choice.estimated(system, law, 1.0, 1e-6).reason
    assert float(finer.split("events, ")[1].split()[0]) > steps


def test_contacts_of_the_start_count_as_those_of_a_gas() -> None:
    """In a gas, t_c ν is the mean number of contacts of a particle at any instant; counted in a run."""
    start = gas(n=1000)
    law = softened(start, 0.2, 0.99)
    run = hl.molecular_dynamics(start, law=law, until=0.002, samples=1, engine="steps")
    touching = engine_choice.open_contacts(run.system)
    assert touching == 2.0 * int(run.series.n_in_contact[-1]) / 1000
    assert touching == pytest.approx(0.2, rel=0.3)
    assert engine_choice.open_contacts(start) == 0.0


def test_overlaps_at_the_start_take_steps() -> None:
    x, y = np.meshgrid(np.arange(10) * 1.9e-3 + 2e-3, np.arange(10) * 1.9e-3 + 2e-3)
    pile = hl.ParticleSystem(
        np.column_stack([x.ravel(), y.ravel()]), np.zeros((100, 2)), 1e-3, density=2500.0, box=0.1,
        allowed_overlap=0.1,
    )  # fmt: skip
    assert engine_choice.open_contacts(pile) == pytest.approx(2 * 180 / 100)
    engine, reason = engine_choice.estimated(pile, LAW, 1e-3)
    assert engine == "steps" and "t_c ν = 3.6 by the contacts that are open at the start" in reason


@pytest.mark.parametrize("restitution", [0.3, 0.9])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_ball_bounces_as_long_as_is_said(restitution: float, dimension: int) -> None:
    """A ball dropped on a floor comes to rest after √(2h/g) (1 + ε)/(1 − ε); the estimate adds 2 for the start."""
    height, g = 0.05, 9.81
    box = [1e3] * (dimension - 1) + [1.0]
    at = [5e2] * (dimension - 1) + [1e-3 + height]
    ball = hl.ParticleSystem(
        [at], np.zeros((1, dimension)), 1e-3, 2500.0, box=box, boundary="wall", gravity=g
    )
    law = hl.LinearDashpot(stiffness=1e6, restitution=restitution)
    fall = math.sqrt(2.0 * height / g)
    rests = fall * (1.0 + 2.0 / (1.0 - restitution))
    assert fall * (1.0 + restitution) / (1.0 - restitution) <= rests
    assert engine_choice.estimated(ball, law, 0.999 * rests).reason.startswith("at t_c ν")
    engine, reason = engine_choice.estimated(ball, law, 1.001 * rests)
    assert engine == "steps" and f"at rest after about {rests:.2g} s" in reason


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_bed_is_the_same_along_any_axis(axis: int, sign: float) -> None:
    """Mirrored and rotated systems get the same estimate except for rounding."""
    down = bed(n=50)
    places, speeds = down.positions.copy(), down.velocities.copy()
    if sign > 0.0:
        places[:, 1] = down.box[1] - places[:, 1]
    order = [1, 0] if axis == 0 else [0, 1]
    pull = np.zeros(2)
    pull[axis] = sign * 9.81
    turned = hl.ParticleSystem(
        places[:, order], speeds[:, order], down.radius, mass=down.mass, box=down.box[order], gravity=pull,
        boundary=[down.boundary[k] for k in order],
    )  # fmt: skip
    for until in (0.02, 0.05, 0.5):
        assert engine_choice.estimated(turned, LAW, until) == engine_choice.estimated(down, LAW, until)


def test_gravity_along_a_periodic_axis_does_nothing() -> None:
    still, falling = gas(), gas(gravity=9.81)
    assert engine_choice.estimated(falling, LAW, 1.0) == engine_choice.estimated(still, LAW, 1.0)


def test_elastic_balls_never_settle_and_one_at_rest_on_the_floor_does() -> None:
    elastic = hl.LinearDashpot(stiffness=1e6, restitution=1.0)
    assert engine_choice.estimated(bed(), elastic, 1e3).engine == "events"
    lying = hl.ParticleSystem(
        [[0.05, 1e-3]], [[0.0, 0.0]], 1e-3, 2500.0, box=0.1, boundary="wall", gravity=9.81
    )
    assert engine_choice.estimated(lying, elastic, 1e-3).engine == "steps"


def test_what_one_engine_alone_can_do_decides() -> None:
    narrow = hl.ParticleSystem([[1e-3, 1e-3]], [[1.0, 0.0]], 1e-3, 2500.0, box=[4.1e-3, 0.1])
    run = hl.molecular_dynamics(narrow, law=LAW, until=1e-3)
    assert run.engine == "steps" and run.engine_reason == (
        "box: got 0.0041 m along x (periodic), must be >= 0.00420001 m for engine 'events', "
        "4.2 times the largest radius"
    )
    for name, value in {"time_step": 1e-7, "restitution_error": 1e-2, "threads": 2}.items():
        run = hl.molecular_dynamics(lattice(27), law=LAW, until=1e-4, **{name: value})
        assert run.engine == "steps" and run.engine_reason == f"only engine steps accepts {name}"
    with pytest.raises(
        ValueError, match="ranks: got 2, must be left out with engine 'steps'; 'lammps' accepts it"
    ):
        hl.molecular_dynamics(lattice(27), law=LAW, until=1e-4, ranks=2)


# --- over random boxes --------------------------------------------------------------------------------------

LAWS = st.one_of(
    st.builds(
        hl.LinearDashpot, stiffness=st.floats(1e-6, 1e12), restitution=st.sampled_from([1e-3, 0.5, 0.99, 1.0])
    ),
    st.builds(hl.LinearDashpot, stiffness=st.floats(1e-3, 1e9), damping=st.sampled_from([0.0, 1e-3, 1e3])),
    st.builds(
        hl.Viscoelastic,
        youngs_modulus=st.floats(1e2, 1e12),
        poisson_ratio=st.just(0.3),
        dissipative_time=st.sampled_from([0.0, 1e-6, 1.0]),
    ),
    st.builds(
        hl.Tsuji, elastic_prefactor=st.floats(1e2, 1e12), damping_coefficient=st.sampled_from([0.0, 0.2, 9.0])
    ),
)


@st.composite
def boxes(draw: st.DrawFn, fastest: float, weakest: float) -> hl.ParticleSystem:
    """Particles on a lattice, separate, touching or overlapping, at any speed, with walls and gravity."""
    d = draw(st.sampled_from([2, 3]))
    n = draw(st.integers(1, 12))
    boundary = draw(st.lists(st.sampled_from(["periodic", "wall"]), min_size=d, max_size=d))
    spacing = draw(st.sampled_from([1.8e-3, 2e-3, 2.5e-3, 1e-2]))
    along = math.ceil(n ** (1.0 / d))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    points = np.stack(np.meshgrid(*[np.arange(along)] * d, indexing="ij"), -1).reshape(-1, d)[:n]
    speed = draw(st.sampled_from([0.0, 5e-324, 1e-160, 1e-9, 1e-3, 1.0, fastest]))
    radius = 1e-3 if draw(st.booleans()) else 1e-3 * rng.uniform(0.5, 1.0, n)
    return hl.ParticleSystem(
        1e-3 + points * spacing,
        speed * rng.uniform(-1.0, 1.0, (n, d)),
        radius,
        draw(st.sampled_from([1e-3, 2500.0])),
        box=np.maximum((along - 1) * spacing + 2e-3, draw(st.sampled_from([4e-3, 4.2e-3, 1e-1]))),
        boundary=boundary,
        gravity=(rng.uniform(-1.0, 1.0, d) * draw(st.sampled_from([0.0, weakest, 9.81, 1e6]))).tolist(),
        allowed_overlap=0.2,
    )


def outcome(system: hl.ParticleSystem, **options: Any) -> Any:
    try:
        return hl.molecular_dynamics(system, **options)
    except ValueError as error:
        return str(error)


@draws(400)
@given(boxes(1e30, 1e-300), LAWS, st.sampled_from([0.0, 1e-3, 1e3]))
def test_an_engine_is_chosen_for_any_box(system: hl.ParticleSystem, law: hl.Law, until: float) -> None:
    """For any system the choice is one of the two engines, with a one-line reason, and reproducible."""
    engine, reason = engine_choice.estimated(system, law, until)
    assert engine in ("events", "steps") and reason and "\n" not in reason and "nan" not in reason
    assert engine_choice.estimated(system.replace(), law, until) == (engine, reason)


@draws(100, few=2)
@given(boxes(1e3, 1e-6), LAWS)
def test_auto_runs_as_the_engine_that_it_says(system: hl.ParticleSystem, law: hl.Law) -> None:
    """auto runs whenever one of the two engines does, with results bit-identical to those of the engine it names."""
    # For contacts with tiny restitution the step takes long to compute; few steps are enough here.
    assume(engine_choice.typical_contact(system, law)[1] > 1e-6)
    speed = time_step.largest_speed(system)
    until = min(1e-4, 1e-3 / speed if speed > 0.0 else 1.0, 20.0 * time_step.chosen(system, law, None, None))
    options = {"law": law, "until": until, "samples": 2, "log": True}
    chosen = outcome(system, **options)
    each = {name: outcome(system, engine=name, **options) for name in ("events", "steps")}
    if isinstance(chosen, str):
        assert all(isinstance(result, str) for result in each.values()), (chosen, each)
        return
    same = each[chosen.engine]
    assert (
        chosen.engine_reason and same.engine_reason == "" and repr(same) in repr(chosen).replace(";", ">", 1)
    )
    assert same_samples(chosen, same)
    assert np.array_equal(chosen.system.positions, same.system.positions)
    assert all(np.array_equal(a, b, equal_nan=True) for a, b in zip(chosen.log, same.log, strict=True))


# --- reporting ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("stiffness", "engine"), [(1e6, "events"), (150.0, "steps")])
def test_the_result_says_which_and_why(stiffness: float, engine: str, tmp_path: Any) -> None:
    system, law = lattice(64), hl.LinearDashpot(stiffness=stiffness, restitution=0.9)
    run_ = hl.molecular_dynamics(system, law=law, until=1e-3, log=True)
    assert run_.engine == engine and run_.engine_reason.startswith("at t_c ν = ")
    said = f"chose {engine}: {run_.engine_reason}"
    assert said in repr(run_) and said in run_._repr_html_()
    for data in (run_.series, run_.contacts):
        assert data.attrs["engine"] == engine and data.attrs["engine_reason"] == run_.engine_reason
    named = hl.molecular_dynamics(system, law=law, until=1e-3, engine=engine)
    assert "chose" not in repr(named) + named._repr_html_() and "engine_reason" not in named.series.attrs


def test_a_checkpoint_goes_on_with_the_same_engine(tmp_path: Any) -> None:
    """A resumed run keeps its engine even if its current state would choose the other one; also after Ctrl-C."""
    start, law, path = bed(n=100), hl.LinearDashpot(stiffness=1e4, restitution=0.7), tmp_path / "run"
    whole = hl.molecular_dynamics(start, law=law, until=0.1, samples=10)
    with pytest.raises(KeyboardInterrupt):
        hl.molecular_dynamics(
            start, law=law, until=0.1, samples=10, checkpoint=path, progress=interrupt_at(3)
        )
    resumed = hl.resume(path)
    assert resumed.engine == whole.engine == "steps" and resumed.engine_reason == whole.engine_reason
    assert same_samples(resumed, whole)
    first = hl.molecular_dynamics(start, law=law, until=1e-3, samples=10, checkpoint=path)
    later = hl.resume(path, until=2e-3)
    assert first.engine == later.engine == "events" and later.engine_reason == first.engine_reason != ""


def test_the_command_line_says_it(tmp_path: Any) -> None:
    start = lattice(27, seed=1).write(tmp_path / "start.xyz")
    options = ["gas", start, "--law", "linear", "--stiffness", "1e6", "--restitution", 0.9, "--until", "2ms"]
    output = printed(*options, "--engine", "auto")
    assert output["engine"] == "events" and output["engine_reason"].startswith("at t_c ν = ")
    text = " ".join(run(*options, "--engine", "auto", "--save", tmp_path / "run.nc").stdout.split())
    assert f"Chose events: {output['engine_reason']}." in text
    assert "Chose" not in run(*options, "--engine", "events").stdout
    assert printed(*options, "--engine", "auto", "--time-step", "0.1us")["engine"] == "steps"


def test_fidelity_chooses_once_for_all_replicas(tmp_path: Any) -> None:
    """The first initial state determines the engine, at the study's step; a store treats auto as that engine."""
    system = gas(n=30)
    for tc_nu, engine in ((0.01, "events"), (1.0, "steps")):
        law = softened(system, tc_nu)
        options = {"law": law, "until": 1e-4, "samples": 2, "models": ["newton"], "replicas": 2}
        store = tmp_path / engine
        fidelity = hl.fidelity(system, **options, store=store)
        assert fidelity.dataset.attrs["engine"] == engine
        told: list[tuple[int, int]] = []
        again = hl.fidelity(
            system, **options, engine=engine, store=store, progress=lambda *seen, told=told: told.append(seen)
        )
        assert again.dataset.identical(fidelity.dataset) and told[0][0] == told[-1][1]


# --- friction -----------------------------------------------------------------------------------------------


def test_friction_has_costs_of_its_own() -> None:
    """Short contacts under a linear law with a spring go by events; all others by steps."""
    system, rubbing = gas(), hl.Friction(0.5)
    for tc_nu, engine in ((1e-4, "events"), (0.1, "steps")):
        law = softened(system, tc_nu).replace(friction=rubbing)
        chosen, reason = engine_choice.estimated(system, law, 1.0)
        assert chosen == engine and f"at t_c ν = {tc_nu:.2g} at the start a contact costs about " in reason
    stiff = softened(system, 1e-4)
    damped = hl.Friction(0.5, damping_ratio=1.0, limit="spring")
    assert (
        "limit: got 'spring'" in engine_choice.estimated(system, stiff.replace(friction=damped), 1.0).reason
    )
    hertz = hl.Viscoelastic(youngs_modulus=1e10, poisson_ratio=0.3, dissipative_time=1e-8, friction=rubbing)
    assert engine_choice.estimated(system, hertz, 1.0) == (
        "steps",
        "with friction only contacts under linear laws with a spring are fast by events",
    )
    smooth = stiff.replace(friction=hl.Friction(0.0))
    assert engine_choice.estimated(system, smooth, 1.0) == engine_choice.estimated(system, stiff, 1.0)
