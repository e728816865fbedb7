"""Walls that oscillate: exact collisions, the bouncing ball's map, energy, frames, files, and all engines alike."""

import math
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hardlimit as hl
from box_engines import LINEAR, RULES, SOLVERS, solved
from conftest import draws, refusal, slow
from hardlimit.boxes.walls import least_widening

WAVEFORMS = ("sine", "triangle", "parabola")
each_waveform = pytest.mark.parametrize("waveform", WAVEFORMS)
G, R = 9.81, 0.01


def wave(waveform: str, cycles: Any) -> Any:
    """w(2π cycles), by other formulas than the core's, at the precision of mpmath."""
    c = cycles - mpmath.floor(cycles)
    if waveform == "sine":
        return mpmath.sin(2 * mpmath.pi * c)
    if waveform == "triangle":
        return 2 / mpmath.pi * mpmath.asin(mpmath.sin(2 * mpmath.pi * c))
    return 4 * (2 * c) * (1 - 2 * c) if c < 0.5 else -4 * (2 * c - 1) * (2 - 2 * c)


def waves(waveform: str, cycles: Any) -> Any:
    """The same in double precision, for arrays."""
    c = cycles % 1.0
    if waveform == "sine":
        return np.sin(2.0 * np.pi * c)
    if waveform == "triangle":
        return 1.0 - 4.0 * np.abs((c + 0.25) % 1.0 - 0.5)
    return np.where(c < 0.5, 8.0 * c * (1.0 - 2.0 * c), -16.0 * (c - 0.5) * (1.0 - c))


def ball(wall: hl.MovingWall, x: float, v: float, gravity: float = G) -> hl.ParticleSystem:
    """One ball above a floor that moves."""
    return hl.ParticleSystem(
        [[0.5, x]],
        [[0.0, v]],
        R,
        mass=0.01,
        box=1.0,
        boundary="wall",
        gravity=gravity,
        walls={"y-": wall},
    )


def walls_of(random: np.random.Generator, waveform: str, g: float = G) -> hl.MovingWall:
    """A wall with an acceleration of 0.5 to 8 g at 15 to 60 Hz."""
    frequency = random.uniform(15.0, 60.0)
    amplitude = random.uniform(0.5, 8.0) * g / (2.0 * math.pi * frequency) ** 2
    return hl.MovingWall(amplitude, frequency, waveform, random.uniform(-3.0, 3.0))


@each_waveform
@pytest.mark.parametrize("gravity", [G, 0.0])
def test_each_collision_is_the_first_zero_of_the_gap(waveform: str, gravity: float) -> None:
    """Each flight, started from the state after a logged collision, against the gap at 40 digits: the gap is zero to
    the rounding of positions at the next collision and positive before, on 400 points. Velocities: Newton's rule."""
    random = np.random.default_rng(len(waveform))
    mpmath.mp.dps = 40
    flights = 0
    for _ in range(6):
        wall, e = walls_of(random, waveform), random.uniform(0.5, 0.95)
        system = ball(wall, 0.05, random.uniform(-0.5, 0.2) if gravity else -0.3, gravity)
        run = hl.event_driven(system, restitution=e, until=1.0, max_collisions=40, log=True)
        f, shift = mpmath.mpf(wall.frequency), mpmath.mpf(wall.phase) / (2 * mpmath.pi)

        def place(t: Any, wall: hl.MovingWall = wall, f: Any = f, shift: Any = shift) -> Any:
            return wall.amplitude * wave(wall.waveform, f * t + shift)

        t, x, v = mpmath.mpf(0), mpmath.mpf(0.05), mpmath.mpf(float(system.velocities[0, 1]))
        rows = run.collisions
        for at, number, impact in zip(
            rows.time.values, rows.second.values, rows.impact_speed.values, strict=True
        ):
            if number != -3:  # the ceiling, without gravity
                break

            def gap(s: Any, t: Any = t, x: Any = x, v: Any = v) -> Any:
                return x + v * s - gravity * s * s / 2 - place(t + s) - R

            s = mpmath.mpf(float(at)) - t
            assert abs(gap(s)) < 1e-16 * (1.0 + float(impact) * (1.0 + float(t)) * 10.0)
            # In double precision, and at 40 digits where that is not enough.
            part = np.arange(1, 400) / 400
            ahead = float(s) * part
            rough = float(x) + float(v) * ahead - 0.5 * gravity * ahead**2 - R
            rough -= wall.amplitude * waves(waveform, float(f * t + shift) + wall.frequency * ahead)
            near = part[rough < 1e-12] if s > 1e-9 else []
            assert all(gap(s * float(k)) > -1e-16 for k in near)
            moving = mpmath.diff(place, t + s, h=mpmath.mpf(10) ** -18)
            arriving = v - gravity * s
            assert float(impact) == pytest.approx(float(moving - arriving), rel=1e-9, abs=1e-12)
            t, x, v = t + s, place(t + s) + R, moving + e * (moving - arriving)
            flights += 1
    assert flights > (100 if gravity else 5)


@each_waveform
@pytest.mark.parametrize("beyond", [1e-10, -1e-10])
def test_a_grazing_flight(waveform: str, beyond: float) -> None:
    """A ball without gravity moves so that the least gap in two periods is `beyond` amplitudes."""
    wall = hl.MovingWall(1e-3, 40.0, waveform, phase=0.3)
    quarters = (0.25 * np.arange(1, 8) - wall.phase / (2.0 * math.pi)) / wall.frequency
    v = 0.02

    def gaps(times: Any) -> Any:
        return v * times - wall.amplitude * waves(
            waveform, wall.frequency * times + wall.phase / (2.0 * math.pi)
        )

    times = np.sort([*np.linspace(0.0, 0.05, 2001), *quarters[(quarters > 0.0) & (quarters < 0.05)]])
    nearest = times[gaps(times).argmin()] + np.linspace(-2.5e-5, 2.5e-5, 20_001)
    least = float(min(gaps(times).min(), gaps(nearest[nearest > 0.0]).min()))
    x = R - least + beyond * wall.amplitude
    run = hl.event_driven(
        ball(wall, x, v, gravity=0.0), restitution=0.9, until=0.05, max_collisions=1, log=True
    )
    assert run.n_collisions == (1 if beyond < 0.0 else 0)


@pytest.mark.parametrize("cycles", [0.1, 0.2, 0.25, 0.3, 0.35])
@pytest.mark.parametrize("waveform", ["sine", "parabola"])
def test_a_ball_that_a_wall_lets_go_flies_until_it_comes_back(waveform: str, cycles: float) -> None:
    """It starts on the wall with its velocity, while the wall is slowed by more than g."""
    wall = hl.MovingWall(3e-3, 20.0, waveform, phase=2.0 * math.pi * cycles)

    def place(t: Any) -> Any:
        return wall.amplitude * waves(waveform, wall.frequency * t + cycles)

    step = 1e-6
    v = float(place(step) - place(-step)) / (2.0 * step)
    if waveform == "sine":
        v = 2.0 * math.pi * wall.frequency * wall.amplitude * math.cos(wall.phase)
    times = np.arange(1e-4, 0.1, 1e-5)
    gap = v * times - 0.5 * G * times**2 - (place(times) - place(0.0))
    run = hl.event_driven(
        ball(wall, R + place(0.0), v), restitution=0.5, until=0.1, max_collisions=3, log=True
    )
    hits = run.collisions.time.values[run.collisions.impact_speed.values > 1e-9]
    assert len(hits) >= run.n_collisions - 1  # one may be due to rounding at the start
    assert hits[0] == pytest.approx(times[np.argmax(gap < 0.0)], abs=1e-5)


def stationary(gamma: float, e: float, f: float = 30.0) -> tuple[hl.MovingWall, float]:
    """A wall of the acceleration gamma·g and the velocity after impact of the ball that bounces once in each period.

    It flies for T, so that v' = gT/2 and v = −gT/2; Newton's rule gives the velocity of the wall W at impact."""
    omega, v = 2.0 * math.pi * f, 0.5 * G / f
    amplitude = gamma * G / omega**2
    moving = v * (1.0 - e) / (1.0 + e)
    return hl.MovingWall(amplitude, f, phase=math.acos(moving / (amplitude * omega))), v


@pytest.mark.parametrize("e", [0.3, 0.6, 0.85])
def test_the_bouncing_ball_doubles_its_period(e: float) -> None:
    """The solution of one bounce per period is stable for π(1−ε)/(1+ε) < Γ < √(π²(1−ε)²/(1+ε)² + 4(1+ε²)²/(1+ε)⁴)
    (J. M. Luck and A. Mehta, Phys. Rev. E 48, 3988 (1993)): a perturbation of 1e-3 decays 3 % below the upper bound;
    5 % above, the phases of even and odd bounces differ."""
    lower = math.pi * (1.0 - e) / (1.0 + e)
    upper = math.sqrt(lower**2 + 4.0 * (1.0 + e * e) ** 2 / (1.0 + e) ** 4)
    for gamma, doubled in ((lower + 0.97 * (upper - lower), False), (lower + 1.05 * (upper - lower), True)):
        wall, v = stationary(gamma, e)
        start = ball(wall, wall.displacement() + R, v * 1.001)
        run = hl.event_driven(start, restitution=e, until=60.0, max_collisions=1500, log=True)
        phases = (run.collisions.time.values * wall.frequency) % 1.0
        difference = abs(math.remainder(phases[-1] - phases[-2], 1.0))
        assert run.outcome == "ok"
        assert (difference > 1e-3) == doubled, (gamma, difference)
        assert doubled or difference < 1e-6
    wall, v = stationary(0.5 * (lower + upper), e)
    run = hl.event_driven(
        ball(wall, wall.displacement() + R, v), restitution=e, until=60.0, max_collisions=200, log=True
    )
    np.testing.assert_allclose(np.diff(run.collisions.time.values), 1.0 / wall.frequency, rtol=1e-9)


@pytest.mark.parametrize("waveform", ["sine", "parabola"])
def test_below_g_a_ball_comes_to_rest_on_the_floor(waveform: str) -> None:
    """Γ < 1 and < π(1−ε)/(1+ε), above which the ball may go on bouncing: chatter is a collapse at the
    wall, tc bounces on, and under Newton's equations the ball stays on the wall."""
    frequency = 30.0
    amplitude = 0.8 * G / (2.0 * math.pi * frequency) ** 2 * (1.0 if waveform == "sine" else 0.5)
    wall = hl.MovingWall(amplitude, frequency, waveform)
    start = ball(wall, 0.02, 0.0)
    run = hl.event_driven(start, restitution=0.4, until=3.0)
    assert run.outcome_name == "collapse"
    assert run.early_end is not None
    assert run.early_end.wall == -3
    assert (
        hl.event_driven(start, restitution=0.4, rule="tc", contact_duration=1e-4, until=1.0).outcome == "ok"
    )
    law = hl.LinearDashpot(stiffness=1e4, restitution=0.4)
    soft = hl.molecular_dynamics(start, law=law, until=1.0, engine="events")
    assert soft.outcome == "ok"
    assert (soft.series.n_in_contact.values[60:] == 1).all()
    height = soft.system.positions[0, 1] - soft.system.domain.limits(1)[0]
    assert height == pytest.approx(R, abs=5.0 * 0.01 * G / 1e4)
    assert soft.energy_error < 1e-10


@each_waveform
def test_newtons_equations_converge_to_the_hard_sphere(waveform: str) -> None:
    """Times of the first three bounces: the difference is of the order of the contact's duration, ∝ 1/√stiffness."""
    wall = hl.MovingWall(1e-3, 25.0, waveform, phase=0.7)
    start = ball(wall, 0.05, 0.1)
    hard = hl.event_driven(start, restitution=0.8, until=0.4, log=True).collisions.time.values[:3]
    error = []
    for stiffness in (1e6, 1e8, 1e10):
        law = hl.LinearDashpot(stiffness=stiffness, restitution=0.8)
        soft = hl.molecular_dynamics(start, law=law, until=0.4, engine="events", log=True)
        error.append(np.abs(soft.contacts.begin.values[:3] - hard).max())
    assert error[1] == pytest.approx(error[0] / 10.0, rel=0.5)
    assert error[2] == pytest.approx(error[1] / 10.0, rel=0.5)


def shaken(seed: int, n: int = 60) -> hl.ParticleSystem:
    """A random box: dimension, gravity, waveforms, walls, radii."""
    random = np.random.default_rng(seed)
    d = int(random.integers(2, 4))
    low, high = "xyz"[d - 1] + "-", "xyz"[d - 1] + "+"
    walls = {
        name: walls_of(random, str(random.choice(WAVEFORMS))) for name in (low, high, "x+")[: 1 + seed % 3]
    }
    if seed % 4 == 0:
        fast = walls[low]
        walls[low] = hl.MovingWall(fast.amplitude, fast.frequency, fast.waveform, fast.phase, velocity=0.2)
    gravity = float(random.choice([0.0, G])) if seed % 2 else G
    radius = (1e-3, 1.4e-3) if seed % 3 else 1.2e-3
    return hl.ParticleSystem.random(
        n, 0.15, radius, 2500.0, 0.3, dimension=d, boundary="wall", gravity=gravity, walls=walls, seed=seed
    )


@pytest.mark.parametrize("speed_of_floor", [0.05, 0.7, 4.0])
@pytest.mark.parametrize("e", [1.0, 0.8, 0.2])
def test_a_contact_with_a_sine_is_that_of_the_forced_oscillator(speed_of_floor: float, e: float) -> None:
    """m ξ̈ = −k ξ − γ ξ̇ + m (g + Ẅ) at 25 digits. ``speed_of_floor``: angular frequency of the floor over that of the
    contact. The force is positive until the logged end, and zero there; the ball separates at −ξ̇."""
    random = np.random.default_rng(7)
    mpmath.mp.dps = 25
    law, m = LINEAR.replace(restitution=e), mpmath.mpf(0.01)
    force = law.between(hl.Ball(R, mass=0.01), hl.FLOOR)
    k, b = mpmath.mpf(force.stiffness), mpmath.mpf(force.damping) / (2 * m)
    squared = k / m
    swing = mpmath.sqrt(mpmath.mpc(squared - b * b))
    frequency = speed_of_floor * float(mpmath.sqrt(squared)) / (2.0 * math.pi)
    for _ in range(2):
        wall = hl.MovingWall(
            random.uniform(0.05, 0.3) / (2.0 * math.pi * frequency),
            frequency,
            phase=random.uniform(-3.0, 3.0),
        )
        row = hl.molecular_dynamics(
            ball(wall, 0.02, random.uniform(-2.0, -0.7)),
            law=law,
            until=0.05,
            engine="events",
            samples=1,
            log=True,
        ).contacts.isel(contact=0)
        rate = 2 * mpmath.pi * mpmath.mpf(wall.frequency)
        begin, end, impact = (mpmath.mpf(float(row[name])) for name in ("begin", "end", "impact_speed"))
        answer = -wall.amplitude * rate**2 / (squared - rate**2 + 2j * b * rate)

        def forced(t: Any, n: int, rate: Any = rate, wall: Any = wall, answer: Any = answer) -> Any:
            turned = mpmath.expj(rate * t + mpmath.mpf(wall.phase)) * (1j * rate) ** n
            return mpmath.im(answer * turned) + (m * G / k if n == 0 else 0)

        start, slope = -forced(begin, 0), impact - forced(begin, 1)

        def depth(
            t: Any, start: Any = start, slope: Any = slope, begin: Any = begin, forced: Any = forced
        ) -> Any:
            free = start * mpmath.cos(swing * (t - begin))
            free += (slope + b * start) / swing * mpmath.sin(swing * (t - begin))
            return mpmath.re(mpmath.exp(-b * (t - begin)) * free) + forced(t, 0)

        def push(t: Any, depth: Any = depth) -> Any:
            return k * depth(t) + 2 * b * m * mpmath.diff(depth, t)

        root = mpmath.findroot(push, end)
        span = end - begin
        assert all(push(begin + j * span / 20) > 0 for j in range(1, 20))
        assert abs(root - end) < 1e-10 * span
        assert abs(mpmath.diff(depth, root) + mpmath.mpf(float(row["separation_speed"]))) < 1e-10 * impact


@pytest.mark.parametrize("name", SOLVERS)
@pytest.mark.parametrize(("d", "shaken"), [(2, True), (3, False)])
def test_a_box_that_drifts(name: str, d: int, shaken: bool) -> None:
    """All walls drift alike, beside their oscillation if they are shaken: the Galilean transform of the box that does
    not. Losses and virial are the same; walls at rest do no work."""
    moving = {"y-": hl.MovingWall(4e-4, 60.0, "sine", 0.4), "x+": hl.MovingWall(3e-4, 45.0, "parabola", -0.9)}
    rest = hl.ParticleSystem.random(
        30, 0.1, (0.7e-3, 1e-3), 2500.0, 0.3, dimension=d, boundary="wall", gravity=G, seed=5,
        walls=moving if shaken else {},
    )  # fmt: skip
    drift, until = np.array([0.3, -0.2, 0.4][:d]), 0.01
    walls = {}
    for axis, letter in enumerate("xyz"[:d]):
        for end in "-+":
            old = rest.walls.get(letter + end, hl.MovingWall())
            walls[letter + end] = hl.MovingWall(
                old.amplitude, old.frequency, old.waveform, old.phase, velocity=drift[axis]
            )
    step = {"time_step": 2e-6} if "steps" in name else {}
    still = solved(name, rest, until, **step)
    moved = solved(name, rest.replace(velocities=rest.velocities + drift, walls=walls), until, **step)
    atol = 1e-9 if "steps" in name else 1e-11
    np.testing.assert_allclose(moved.system.positions - drift * until, still.system.positions, atol=atol)
    np.testing.assert_allclose(moved.system.velocities - drift, still.system.velocities, atol=1e3 * atol)
    energy = float(still.series.kinetic_energy[0])
    for quantity in ("dissipated_energy", "virial_tensor"):
        np.testing.assert_allclose(
            moved.samples[quantity], still.samples[quantity], atol=1e3 * atol * energy, err_msg=quantity
        )
    assert (still.samples["wall_work"] == 0.0).all() == (not shaken)
    assert moved.samples["wall_work"][-1] != 0.0


def test_beads_on_a_shaken_floor_condense_or_fluidise() -> None:
    """A column of N = 10 beads at Γ = 5.6: for N(1 − ε) = 0.3 it is fluidised, for 4 it moves as one block (S. Luding,
    H. J. Herrmann and A. Blumen, Phys. Rev. E 50, 3100 (1994)). Qualitative: mean expansion of the column."""
    n, radius = 10, 1e-3
    expansion = []
    for e in (0.97, 0.6):
        wall = hl.MovingWall(1.4e-3, 31.5)
        positions = np.column_stack([np.full(n, 0.005), radius * (1.0 + 2.02 * np.arange(n))])
        column = hl.ParticleSystem(
            positions, np.zeros((n, 2)), radius, density=2500.0, box=[0.01, 1.0], boundary="wall", gravity=G,
            walls={"y-": wall},
        )  # fmt: skip
        law = hl.LinearDashpot(stiffness=1e5, restitution=e)
        run = hl.molecular_dynamics(
            column, law=law, until=1.0, engine="events", observe=lambda _, now: {"y": now.positions[:, 1]}
        )
        y = run.series.y.values[40:]
        expansion.append(float((y[:, -1] - y[:, 0]).mean()) / (2.0 * radius * (n - 1)))
    assert expansion[0] > 2.5
    assert expansion[1] < 1.5


def test_a_violent_wall_compresses_too_deep() -> None:
    """The limit on the compression holds at accelerated walls."""
    start = ball(hl.MovingWall(20e-3, 100.0), 0.02, -1.0)
    soft = hl.LinearDashpot(stiffness=1e3, restitution=0.9)
    for engine in ("events", "steps"):
        run = hl.molecular_dynamics(start, law=soft, until=0.05, engine=engine)
        assert run.outcome_name == "too_deep"


# --- MovingWall, systems and files ------------------------------------------------------------------------------------


@each_waveform
def test_the_displacement_is_that_of_the_core(waveform: str) -> None:
    wall = hl.MovingWall(2e-3, 13.0, waveform, 0.9, velocity=0.3, offset=-1e-3)
    system = hl.ParticleSystem(
        [[0.5] * 3], [[0.0] * 3], R, mass=1.0, box=1.0, boundary="wall", walls={"x+": wall}
    )
    for time in np.linspace(0.0, 0.3, 101):
        rows = {number: (at, speed) for number, at, speed in system.domain.of_core().walls(time)}
        assert rows[-2][0] == pytest.approx(1.0 + wall.displacement(time), abs=1e-15)
        assert abs(rows[-2][1]) <= wall.fastest * (1.0 + 1e-14)
        later = wall.after(time)
        assert later.displacement(0.01) == pytest.approx(wall.displacement(time + 0.01), abs=1e-15)


def test_what_cannot_hold_moving_walls_refuses_them(tmp_path: Path) -> None:
    system = shaken(1)
    assert "moving walls" in refusal(lambda: system.write(tmp_path / "box.data"))
    assert refusal(lambda: hl.molecular_dynamics(system, law=LINEAR, until=0.1, engine="lammps")).startswith(
        "walls: "
    )


def test_results_continue_the_motion() -> None:
    """Two runs of half the time end as one of the whole time does, though their clocks start again."""
    system = shaken(2)
    half = hl.event_driven(system, restitution=0.9, until=0.01)
    again = hl.event_driven(half.system, restitution=0.9, until=0.01)
    whole = hl.event_driven(system, restitution=0.9, until=0.02)
    np.testing.assert_allclose(again.system.positions, whole.system.positions, atol=1e-9)
    for name, wall in whole.system.walls.items():
        assert again.system.walls[name].displacement() == pytest.approx(wall.displacement(), abs=1e-15)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"amplitude": -1.0, "frequency": 1.0}, "amplitude: got -1"),
        ({"amplitude": 1.0}, "amplitude | frequency: got 1 and 0, must both be > 0, or neither be given"),
        ({"waveform": "saw"}, "waveform: got 'saw', must be one of"),
        ({"amplitude": 1e20, "frequency": 1e20}, "frequency: got 1e+20, must be lower"),
        ({"amplitude": 1e31, "frequency": 1.0}, "amplitude: got 1e+31, must be in [0, 1e+30)"),
    ],
)
def test_a_bad_wall_is_refused(arguments: dict[str, Any], message: str) -> None:
    assert refusal(lambda: hl.MovingWall(**arguments)).startswith(message)


@pytest.mark.parametrize(
    ("walls", "message"),
    [
        ([hl.MovingWall()], "walls: got "),
        ({"w-": hl.MovingWall(velocity=1.0)}, "walls: got 'w-', must be one of"),
        ({"y-": 3.0}, "walls['y-']: got 3.0, must be a MovingWall"),
        ({"x-": hl.MovingWall(velocity=1.0)}, "walls: got 'x-', must be on an axis whose boundary is 'wall'"),
        ({"y-": hl.MovingWall(amplitude=0.99, frequency=1.0)}, "walls: got a distance of 0.01 m along y"),
        (
            {"y-": hl.MovingWall(0.495, 1.0), "y+": hl.MovingWall(0.495, 1.0, phase=math.pi)},
            "walls: got a distance of 0.01 m along y where they are closest, must be >= 0.02",
        ),
        (
            {"y-": hl.MovingWall(0.4, 1.0, offset=0.45), "y+": hl.MovingWall(0.14, 1.3)},
            "walls: got a distance of 0.01 m along y",
        ),
    ],
)
def test_bad_walls_are_refused(walls: Any, message: str) -> None:
    assert refusal(
        lambda: hl.ParticleSystem(
            [[0.5, 0.5]], [[0.0, 0.0]], R, mass=1.0, box=1.0, boundary=["periodic", "wall"], walls=walls
        )
    ).startswith(message)


@each_waveform
def test_a_box_that_is_shaken_as_a_whole_keeps_its_distance(waveform: str) -> None:
    """By more than its length; with a phase between its walls it is refused."""
    wall = hl.MovingWall(0.3, 2.0, waveform, 0.7)
    at, walls = 0.1 + wall.displacement(), {"y-": wall, "y+": wall}
    system = hl.ParticleSystem(
        [[0.5, at]], [[0.0, 0.0]], R, mass=1.0, box=[1.0, 0.2], boundary="wall", walls=walls
    )
    low, high = system.domain.limits(1, 0.1)
    assert high - low == pytest.approx(0.2)
    run = hl.event_driven(system, restitution=0.9, until=1.0)
    assert run.n_collisions > 3
    assert run.outcome == "ok"
    with pytest.raises(ValueError, match="walls: got a distance of"):
        system.replace(walls={"y-": wall, "y+": hl.MovingWall(0.3, 2.0, waveform, 1.7)})


@draws(60)
@given(
    waveforms=st.tuples(st.sampled_from(WAVEFORMS), st.sampled_from(WAVEFORMS)),
    amplitudes=st.tuples(st.floats(0.1, 1.0), st.floats(0.1, 1.0)),
    phases=st.tuples(st.floats(-7.0, 7.0), st.floats(-7.0, 7.0)),
    offset=st.floats(-1.0, 1.0),
    ratio=st.sampled_from([1.0, 2.0, 0.5, 0.75, 1.25]),
)
def test_the_least_distance_of_two_walls(
    waveforms: Any, amplitudes: Any, phases: Any, offset: float, ratio: float
) -> None:
    """Against the distance at many times."""
    low = hl.MovingWall(amplitudes[0], 4.0, waveforms[0], phases[0], offset=offset)
    high = hl.MovingWall(amplitudes[1], 4.0 * ratio, waveforms[1], phases[1])
    t = np.linspace(0.0, 1.0, 40_001)
    places = [
        wall.offset + wall.amplitude * waves(wall.waveform, wall.frequency * t + wall.phase / (2.0 * math.pi))
        for wall in (low, high)
    ]
    least, sampled = least_widening(low, high), float((places[1] - places[0]).min())
    assert sampled - 1e-3 < least < sampled + 1e-12


@pytest.mark.parametrize("every", [3, slow(1)])
def test_a_wall_that_turns_round_meets_a_ball_that_has_just_let_go(every: int) -> None:
    """Its force has ended before the overlap. If the wall jumps in between, a force acts again while they separate."""
    law = hl.LinearDashpot(stiffness=1e4, restitution=0.1)
    wall = hl.MovingWall(5e-6, 1000.0, "triangle", math.pi)
    again = 0
    for height in np.linspace(1.1e-3, 1.25e-3, 16)[::every]:
        system = hl.ParticleSystem(
            [[0.01, height]], [[0.0, -1.0]], 1e-3, 2500.0, box=0.02, boundary="wall", walls={"y-": wall}
        )
        events, steps = (
            hl.molecular_dynamics(system, law=law, until=6e-4, engine=engine, log=True, **more)
            for engine, more in (("events", {}), ("steps", {"restitution_error": 1e-8}))
        )
        assert events.system.velocities[0, 1] == pytest.approx(steps.system.velocities[0, 1], abs=3e-6)
        assert len(events.contacts.contact) == len(steps.contacts.contact)
        again += bool((events.contacts.impact_speed < 0.0).any())
    assert again > 2 / every


# --- slow drifts, late times, large phases ----------------------------------------------------------------------------


def drifting(seed: int) -> hl.ParticleSystem:
    """Round numbers, and speeds that rounding makes, above walls with any waveform, frequency and phase."""
    random = np.random.default_rng(seed)

    def speed() -> float:
        any_size = random.choice([-1.0, 1.0]) * 10.0 ** random.uniform(-300.0, 0.0)
        return float(random.choice([0.0, 1e-17, -1e-17, -0.33, any_size]))

    shift = float(random.choice([0.0, 1e-17, 10.0 ** random.uniform(-300.0, -4.0)]))
    wall = hl.MovingWall(velocity=-shift)
    if seed % 4:
        frequency = float(random.choice([1.0, 10.0, 50.0, 10.0 ** random.uniform(-3.0, 4.0)]))
        phase = float(random.choice([0.0, 1e16, 1e17, -1e300, 10.0 ** random.uniform(-300.0, 300.0)]))
        amplitude = float(random.choice([1e-3, 5e-4, 1e-9]))
        wall = hl.MovingWall(amplitude, frequency, WAVEFORMS[seed % 4 - 1], phase, velocity=-shift)
    n = seed % 3 + 1
    return hl.ParticleSystem(
        [[0.05, 0.02], [0.05, 0.044], [0.02, 0.06]][:n],
        [[0.0, speed()], [speed(), speed()], [speed(), speed()]][:n],
        R, 2500.0, box=[0.1, 0.08], boundary=["periodic", "wall"], walls={"y-": wall},
        gravity=float(random.choice([0.0, 0.0, G, 1e-17])),
    )  # fmt: skip


@pytest.mark.parametrize("name", SOLVERS)
@pytest.mark.parametrize("seed", [*range(8), *map(slow, range(8, 64))])
def test_slow_drifts_to_oscillating_walls_end(name: str, seed: int) -> None:
    """Regression: 4·frequency·(time of arrival) > 2^53 was an endless loop, deaf to Ctrl-C."""
    until = 0.02 if "steps" in name else 0.5
    own: dict[str, Any] = {"time_step": 1e-5} if "steps" in name else {}
    if name in RULES:  # a ball that comes to rest bounces very often where ε rises to 1
        own["max_collisions"] = 20_000
    run = solved(name, drifting(seed), until, **own)
    assert run.outcome_name in ("ok", "at_rest", "collapse", "too_deep")
    assert np.isfinite(run.system.positions).all()
    assert run.outcome_name != "ok" or run.time == until or run.n_collisions == 20_000


@pytest.mark.parametrize("engine", ["hard", "events", "steps"])
@pytest.mark.parametrize("speed", [-1e-17, -1e-300])
def test_a_drift_that_takes_longer_than_any_run(engine: str, speed: float) -> None:
    """And the two disks of the report, of which the upper one leaves the lower one a speed of rounding errors."""
    system = hl.ParticleSystem(
        [[0.05, 0.015]], [[0.0, speed]], R, 2500.0, box=0.1, boundary=["periodic", "wall"],
        walls={"y-": hl.MovingWall(1e-3, 50.0)},
    )  # fmt: skip
    disks = hl.ParticleSystem(
        [[0.05, 0.02], [0.05, 0.044]], [[0.0, 0.0], [0.0, -0.33]], R, 2500.0, box=[0.1, 0.08],
        boundary=["periodic", "wall"], walls=system.walls,
    )  # fmt: skip
    for start in (system, disks):
        if engine == "hard":
            run: Any = hl.event_driven(start, restitution=1.0, until=1.0)
        else:
            law = LINEAR.replace(restitution=1.0, stiffness=1e6)
            run = hl.molecular_dynamics(start, law=law, until=0.1, engine=engine)
        assert run.outcome == "ok"
    assert hl.event_driven(system, restitution=1.0, until=1.0).system.velocities[0, 1] == speed


def test_a_run_ends_where_its_time_no_longer_resolves_a_wall() -> None:
    system = hl.ParticleSystem(
        [[0.5, 0.5]], [[0.0, -1e-13]], R, mass=1.0, box=1.0, boundary=["periodic", "wall"],
        walls={"y-": hl.MovingWall(1e-3, 50.0)},
    )  # fmt: skip
    run = hl.event_driven(system, restitution=0.9, until=1e12)
    assert run.outcome_name == "unresolved"
    assert "do not resolve the phase of walls" in run.outcome
    assert run.time == system.domain.resolved_until == 2.0**40 / 50.0
    still = system.replace(walls={}, velocities=[[0.0, -1e-70]])
    assert hl.event_driven(still, restitution=0.9, until=1e65).time == 1e60
    sheared = hl.ParticleSystem.random(
        5, 0.01, 1e-3, 2500.0, 0.0, boundary=["periodic", "lees-edwards", "periodic"], shear_rate=10.0
    )
    assert sheared.domain.resolved_until == pytest.approx(2.0**40 / 10.0)


@pytest.mark.parametrize("phase", [7.0, -7.0, 1e6, 1e16, 1e17, -1e22, 1e100, 1e300, 1.7e308])
def test_a_large_phase_is_reduced_exactly(phase: float) -> None:
    mpmath.mp.dps = 350
    wall = hl.MovingWall(1e-3, 50.0, phase=phase)
    assert 0.0 <= wall.phase <= 2.0 * math.pi
    assert wall.phase == pytest.approx(float(mpmath.fmod(mpmath.mpf(phase), 2 * mpmath.pi) % (2 * mpmath.pi)))
    assert wall.displacement() == pytest.approx(1e-3 * float(mpmath.sin(mpmath.mpf(phase))), abs=1e-18)
    assert hl.MovingWall(1e-3, 50.0, phase=-2.0 * math.pi).phase == -2.0 * math.pi


# --- time stepping and the rule soft at walls that jump ---------------------------------------------------------------


@pytest.mark.parametrize("phase", np.linspace(0.0, 2.0, 4))
def test_steps_are_of_second_order_where_a_wall_jumps(phase: float) -> None:
    """A triangle wave changes its velocity during the contact. The energy was of first order in the step."""
    system = hl.ParticleSystem(
        [[0.02, 4.2e-3]], [[0.0, -0.5]], 1e-3, 2500.0, box=0.04, boundary="wall",
        walls={"y-": hl.MovingWall(3e-3, 1500.0, "triangle", phase)},
    )  # fmt: skip
    law = hl.LinearDashpot(stiffness=2e5, restitution=0.7)
    exact = hl.molecular_dynamics(system, law=law, until=1e-3, engine="events")
    speed, energy = [], []
    for step in 4e-7 / 2.0 ** np.arange(6):
        run = hl.molecular_dynamics(system, law=law, until=1e-3, engine="steps", time_step=step)
        speed.append(float(np.abs(run.system.velocities - exact.system.velocities).max()))
        energy.append(run.energy_error)
    for error in (speed, energy):
        assert max(error[3:]) < 0.15 * max(error[:3])
    assert max(speed[:3]) < 0.01 * float(np.abs(exact.system.velocities).max())
    assert max(energy[:3]) < 0.01


@pytest.mark.parametrize("waveform", WAVEFORMS)
@pytest.mark.parametrize("periods", [0.5, 3.0, slow(30.0)])
def test_the_step_suits_a_wall_that_oscillates_during_a_contact(waveform: str, periods: float) -> None:
    """``periods`` of the wall in the duration of a contact. Its work is the difference of large gains and losses."""
    frequency = periods / 1.66e-4
    system = hl.ParticleSystem(
        [[0.02, 1.01e-3 + 1.0 / frequency]], [[0.0, 0.0]], 1e-3, 2500.0, box=0.04, boundary="wall", gravity=G,
        walls={"y-": hl.MovingWall(1.0 / frequency, frequency, waveform)},
    )  # fmt: skip
    law = hl.LinearDashpot(stiffness=4e3, restitution=0.9)
    run = hl.molecular_dynamics(system, law=law, until=0.01, engine="steps")
    assert run.outcome == "ok"
    assert run.energy_error < 3e-3


@pytest.mark.parametrize(
    ("at", "moving"), [((1.81e-3, 1.54e-3), (-0.05, -0.05)), ((2.34e-3, 1.64e-3), (-0.25, -0.65))]
)
def test_a_corner_of_shaken_walls_is_no_collapse(at: Any, moving: Any) -> None:
    """Rule soft: a contact with one wall does not cut that with another one short. Regression: both met the particle
    again and again at the same instant."""
    walls = {
        "x-": hl.MovingWall(2.6e-5, 5700.0, "triangle"),
        "y-": hl.MovingWall(4.5e-6, 11000.0, "triangle"),
    }
    system = hl.ParticleSystem(
        [at], [moving], 1e-3, 2500.0, box=0.012, boundary="wall", gravity=[-9.81 * 8, -9.81 * 8], walls=walls
    )
    law = hl.LinearDashpot(stiffness=4e5, restitution=0.8)
    run = hl.event_driven(system, law=law, rule="soft", until=0.04)
    assert run.outcome == "ok"
    assert run.n_collisions < 1000


def test_what_holds_a_ball_without_gravity() -> None:
    system = hl.ParticleSystem(
        [[0.006, 0.006]], [[0.0, -0.5]], 1e-3, 2500.0, box=0.012, boundary="wall",
        walls={"y-": hl.MovingWall(1e-3, 250.0, "parabola", phase=6.0 / 11.0)},
    )  # fmt: skip
    run = hl.event_driven(
        system, law=hl.LinearDashpot(stiffness=1e3, restitution=0.5), rule="soft", until=1.0
    )
    assert run.outcome_name == "at_rest"
    assert run.outcome.startswith("at rest: the acceleration of the wall holds particle 0 and the wall")
