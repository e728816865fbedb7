"""One contact with friction whose normal turns: an independent integration, conservation laws, symmetries, limits."""

import json
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, reject
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import hardlimit as hl
from conftest import DATA, draws, output_of, refusal
from frictional_motion import Motion, Pair, TooCostlyError, integrate
from hardlimit import _core

NEWTON = json.loads((DATA / "friction.json").read_text(encoding="utf-8"))["newton"]
CASES = [case for case in NEWTON if case["kind"].startswith("oblique")]
UP, SEEDS = np.array([0.0, 0.0, 1.0]), st.integers(0, 2**32 - 1)
MINDLIN = ("mindlin", "mindlin_force", "mindlin_rescale", "mindlin_rescale_force")


@dataclass(frozen=True)
class Draw:
    """Arguments of an impact, in units in which the first ball and the normal speed are 1."""

    ball: hl.Ball
    other: Any
    law: hl.Law
    velocities: np.ndarray
    spins: np.ndarray
    normal: np.ndarray
    duration: float  # about that of the contact

    def impact(self) -> Any:
        return hl.oblique_impact(
            self.ball,
            self.other,
            self.law,
            self.velocities[0],
            other_velocity=self.velocities[1],
            spins=self.spins,
            normal=self.normal,
        )

    @property
    def speed(self) -> float:
        return float(np.linalg.norm(self.velocities[1] - self.velocities[0]) + np.linalg.norm(self.spins[0]))


def friction(r: np.random.Generator, linear: bool, kappa: float, undamped: bool) -> hl.Friction:
    mu = float(r.choice([0.0, 0.05, 0.2, 0.5, 1.5, math.inf], p=[0.03, 0.17, 0.25, 0.3, 0.15, 0.1]))
    limit = str(r.choice(["total", "spring"]))
    if r.random() < 0.12 and not undamped:
        return hl.Friction(mu, damping_ratio=float(r.uniform(0.3, 2.0)), model="none", limit=limit)
    return hl.Friction(
        mu,
        stiffness_ratio=float(r.uniform(0.5, 4.0)) / kappa,
        damping_ratio=0.0 if undamped else float(r.choice([0.0, 0.5, 1.0])),
        model="spring" if linear else str(r.choice(MINDLIN)),
        limit=limit,
    )


def law_of(
    r: np.random.Generator,
    masses: tuple[float, float],
    radii: tuple[float, float],
    kappa: float,
    duration: float,
    undamped: bool,
    name: str,
) -> hl.Law:
    """A law whose elastic head-on contact at speed 1 has this duration."""
    mass, radius = (_core.effective(*pair) for pair in (masses, radii))
    surface = friction(r, name == "linear", kappa, undamped)
    restitution = 1.0 if undamped else float(r.choice([1.0, 0.9, 0.6, 0.3]))
    if surface.model == "none":
        restitution = min(restitution, 0.9)
    if name == "linear":
        stiffness = (math.pi / duration) ** 2 * mass
        return hl.LinearDashpot(stiffness=stiffness, restitution=restitution, friction=surface)
    prefactor = (3.218065459719 / duration) ** 2.5 * mass
    if name == "tsuji":
        return hl.Tsuji(elastic_prefactor=prefactor, restitution=restitution, friction=surface)
    return hl.Viscoelastic(
        youngs_modulus=prefactor * 3.0 * (1.0 - 0.3**2) / (2.0 * math.sqrt(radius)),
        poisson_ratio=0.3,
        restitution=restitution,
        impact_speed=1.0,
        friction=surface,
    )


def drawn(seed: int, wall: bool | None = None, undamped: bool = False, name: str | None = None) -> Draw:
    r = np.random.default_rng(seed)
    wall = bool(r.random() < 0.25) if wall is None else wall
    radii = (1.0, math.inf if wall else float(np.exp(r.uniform(-1.2, 1.2))))
    masses = (1.0, math.inf if wall else float(np.exp(r.uniform(-1.5, 1.5))))
    q = r.uniform(0.15, 1.0, 2)
    ball = hl.Ball(1.0, mass=1.0, inertia_factor=q[0])
    other = hl.FLOOR if wall else hl.Ball(radii[1], mass=masses[1], inertia_factor=q[1])
    duration = float(np.exp(r.uniform(math.log(1e-3), math.log(0.3)))) * (2.0 if wall else sum(radii))
    kappa = 1.0 + 1.0 / q[0]
    name = name or str(r.choice(["linear", "viscoelastic", "tsuji"]))
    law = law_of(r, masses, radii, kappa, duration, undamped, name)
    normal = r.normal(size=3)
    normal /= np.linalg.norm(normal)
    aside = np.cross(normal, r.normal(size=3))
    aside /= np.linalg.norm(aside)
    assert law.friction is not None
    size = (
        math.exp(r.uniform(math.log(0.05), math.log(4.0)))
        * kappa
        * max(min(law.friction.coefficient, 1.0), 0.05)
    )
    spins = np.array([r.normal(size=3) * size * r.random() / radii[0], r.normal(size=3) * size / radii[1]])
    if r.random() < 0.2:  # in a plane
        across = np.cross(normal, aside)
        spins = np.outer(spins @ across, across)
    frame = 0.1 * r.normal(size=3)
    velocities = np.array([frame, frame - normal + size * r.random() * aside])
    return Draw(ball, other, law, velocities, spins, normal, duration)


def at_touch(draw: Draw) -> tuple[Pair, np.ndarray]:
    """The bodies, and their displacements, velocities and spins at touch, for the independent integration."""
    wall = draw.other is hl.FLOOR
    contact = draw.law.between(draw.ball, draw.other)
    second = (np.inf, 1.0, 1.0) if wall else (draw.other.mass, draw.other.radius, draw.other.inertia_factor)
    first = (draw.ball.mass, draw.ball.radius, draw.ball.inertia_factor)
    mass, radius, q = zip(first, second, strict=True)
    powers = tuple(0.25 * x for x in draw.law.record["powers"])
    pair = Pair(mass, radius, q, powers, contact.core.coefficients, contact.friction_terms)
    return pair, np.concatenate([np.zeros(6), *draw.velocities, *draw.spins])


def independent(draw: Draw) -> tuple[np.ndarray, float, list[tuple[float, bool]]]:
    """The same contact by SciPy."""
    return integrate(*at_touch(draw), draw.normal, draw.duration)


def deviations(draw: Draw) -> dict[str, float]:
    """Largest differences from SciPy's integration, in units of the duration and the speeds."""
    impact = draw.impact()
    end, duration, _ = independent(draw)
    differences = {
        "velocity": impact.velocities - end[6:12].reshape(2, 3),
        "spin": impact.spins - end[12:18].reshape(2, 3),
        "displacement": (impact.displacements - end[:6].reshape(2, 3)) / draw.duration,
    }
    sizes = {name: float(np.abs(value).max()) / draw.speed for name, value in differences.items()}
    return {"duration": abs(impact.duration - duration) / draw.duration, **sizes}


@draws(50, few=5)
@given(SEEDS)
def test_against_an_independent_integration(seed: int) -> None:
    """``tools/compare_turning_contact.py`` does this for thousands of draws."""
    draw = drawn(seed)
    assume(draw.law.friction.coefficient > 0.0)
    try:
        sizes = deviations(draw)
    except TooCostlyError:
        reject()
    assert max(sizes.values()) < 1e-9


@pytest.mark.slow
def test_series_against_the_general_method(tmp_path: Path) -> None:
    """Under a linear law: largest differences of 3000 contacts, relative to the speeds; both methods err by 1e-11."""
    words = output_of("boxes/turning_series.cpp", tmp_path).split()
    compared, left, duration, motion, balance, many, near_the_end = map(float, words)
    assert compared > 2900 and left < 100
    assert duration < 3e-12 and motion < 2e-10 and balance < 2e-12 and many < 30
    assert near_the_end < 1e-8


@pytest.mark.slow
def test_clusters_of_two_spheres(tmp_path: Path) -> None:
    """400 contacts of a viscoelastic law with all models of Mindlin: those that slip and stick again at once too.

    1000 of a linear law, by series that begin within the contact.
    """
    words = list(map(float, output_of("boxes/turning_cluster.cpp", tmp_path).split()))
    for (compared, unresolved, largest, unbalanced, turned), least, most in zip(
        (words[:5], words[5:]), (390, 990), (1e-9, 2e-10), strict=True
    ):
        assert compared > least and unresolved == 0
        assert largest < most and unbalanced < 1e-10 and turned < 2e-12


class Driven(Motion):
    """Surfaces that a history, which grows with the contact radius, drives along their velocity with μ F_n."""

    def pieces(self, y: np.ndarray) -> dict[str, Any]:
        at = super().pieces(y)
        force = -self.pair.terms.coefficient * at["normal"] * at["g"] / np.linalg.norm(at["g"])
        return at | {"force": force, "elastic": force - at["damping"] * at["g"]}


def test_surfaces_that_are_driven_from_touch_on() -> None:
    """In a plane the force is known until they stick. With a history that is integrated SciPy errs here by 1e-7."""
    draw = drawn(277)
    impact = draw.impact()
    pair, y = at_touch(draw)
    motion = Driven(pair, draw.normal, draw.duration)
    motion.slips, early = True, 1e-11 * draw.duration
    y[:6] += early * y[6:12]

    def slipping(_: float, y: np.ndarray) -> float:
        at = motion.pieces(y)
        return motion.drive(at, *motion.accelerations(at))[1]

    slipping.terminal, slipping.direction = True, -1.0  # type: ignore[attr-defined]

    how = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-16, "first_step": 0.1 * early}
    run = solve_ivp(
        lambda t, y: np.append(motion.rates(y)[:18], [0.0] * 3),
        (early, draw.duration),
        np.append(y, [0.0] * 3),
        events=slipping,
        **how,
    )
    first, sticks = impact.intervals[:2]
    assert (first.state, sticks.state) == ("slip", "stick")
    assert first.end == pytest.approx(run.t_events[0][0], abs=1e-13 * draw.duration)
    state, end = impact.trajectory([first.end]), run.y_events[0][0]
    np.testing.assert_allclose(state["velocity"].values.ravel(), end[6:12], atol=2e-13 * draw.speed, rtol=0)
    np.testing.assert_allclose(state["spin"].values.ravel(), end[12:18], atol=2e-13 * draw.speed, rtol=0)


@draws(400)
@given(SEEDS)
def test_momenta_and_the_balance_of_energy(seed: int) -> None:
    draw = drawn(seed)
    impact = draw.impact()
    assert sum(impact.energies.values()) == pytest.approx(impact.initial_energy, rel=5e-13)
    if draw.other is hl.FLOOR:
        assert (impact.velocities[1] == draw.velocities[1]).all() and not impact.spins[1].any()
        return
    bodies = (draw.ball, draw.other)
    masses = np.array([body.mass for body in bodies])
    inertia = np.array([body.moment_of_inertia for body in bodies])
    np.testing.assert_allclose(
        masses @ impact.velocities, masses @ draw.velocities, atol=1e-13 * draw.speed * masses.sum()
    )
    mean = masses @ draw.velocities / masses.sum()
    start = np.array([np.zeros(3), (bodies[0].radius + bodies[1].radius) * draw.normal])

    def angular(positions: np.ndarray, velocities: np.ndarray, spins: np.ndarray) -> np.ndarray:
        return np.cross(positions, masses[:, None] * (velocities - mean)).sum(axis=0) + inertia @ spins

    before = angular(start, draw.velocities, draw.spins)
    after = angular(start + impact.displacements - impact.duration * mean, impact.velocities, impact.spins)
    scale = masses.sum() * draw.speed + inertia @ np.abs(draw.spins).sum(axis=1)
    np.testing.assert_allclose(after, before, atol=1e-13 * scale, rtol=0)


@draws(300)
@given(SEEDS)
def test_energy_without_slip_and_damping(seed: int) -> None:
    """What is left in the spring at the end is lost; nothing else is, and with a spring nothing is gained."""
    draw = drawn(seed, undamped=True, name="linear")
    impact = replace(draw, law=draw.law.replace(friction=hl.Friction(math.inf, stiffness_ratio=0.8))).impact()
    contact = impact.contact
    path = impact.trajectory([impact.duration])
    force = np.linalg.norm(path["tangential_force"].values)
    left = 0.5 * force**2 / contact.friction_terms.stiffness
    assert impact.energies["tangential_spring"] == pytest.approx(left, abs=1e-13 * impact.initial_energy)
    assert abs(impact.energies["friction"]) < 1e-13 * impact.initial_energy
    assert impact.energies["normal_damping"] == 0.0 and impact.transitions == 0


def rotation(r: np.random.Generator) -> np.ndarray:
    q, upper = np.linalg.qr(r.normal(size=(3, 3)))
    q *= np.sign(np.diag(upper))
    return q if np.linalg.det(q) > 0.0 else -q


@draws(200)
@given(SEEDS)
def test_rotated_mirrored_and_moving(seed: int) -> None:
    draw = drawn(seed)
    impact, r = draw.impact(), np.random.default_rng(seed)
    turn, frame = rotation(r), r.normal(size=3)
    scale = {"rtol": 0, "atol": 3e-11 * draw.speed}
    for mirrored in (1.0, -1.0):  # spins are axial vectors
        moved = replace(
            draw,
            velocities=mirrored * draw.velocities @ turn.T + frame,
            spins=draw.spins @ turn.T,
            normal=mirrored * turn @ draw.normal,
        ).impact()
        np.testing.assert_allclose(moved.velocities - frame, mirrored * impact.velocities @ turn.T, **scale)
        np.testing.assert_allclose(moved.spins, impact.spins @ turn.T, **scale)
        assert moved.transitions == impact.transitions
        assert moved.duration == pytest.approx(impact.duration, rel=1e-11)


@draws(100)
@given(SEEDS)
def test_either_body_may_be_the_first(seed: int) -> None:
    draw = drawn(seed, wall=False)
    impact = draw.impact()
    swapped = replace(
        draw,
        ball=draw.other,
        other=draw.ball,
        velocities=draw.velocities[::-1],
        spins=draw.spins[::-1],
        normal=-draw.normal,
    ).impact()
    scale = {"rtol": 0, "atol": 3e-11 * draw.speed}
    np.testing.assert_allclose(swapped.velocities[::-1], impact.velocities, **scale)
    np.testing.assert_allclose(swapped.spins[::-1], impact.spins, **scale)


@draws(100)
@given(SEEDS)
def test_without_friction_it_is_the_smooth_contact(seed: int) -> None:
    draw = drawn(seed)
    smooth = replace(draw, law=draw.law.replace(friction=None)).impact()
    along = smooth.contact.core, math.inf if draw.other is hl.FLOOR else draw.ball.radius + draw.other.radius
    flat = replace(draw, law=draw.law.replace(friction=None), normal=-UP, spins=np.zeros((2, 3)))
    flat = replace(flat, velocities=np.array([[draw.speed, 0.0, -1.0], np.zeros(3)])).impact()
    planar = _core.planar_contact(*along, 1.0, draw.speed)
    assert flat.duration == planar["duration"] and flat.compression == planar["compression"]
    assert flat.turn == pytest.approx(planar["turn"], rel=1e-13, abs=1e-15)
    assert (smooth.spins == draw.spins).all()
    scale = {"rtol": 0, "atol": 1e-11 * draw.speed}
    if draw.law.friction.model == "none":
        return
    faint = replace(
        draw, law=draw.law.replace(friction=replace(draw.law.friction, coefficient=1e-13))
    ).impact()
    np.testing.assert_allclose(faint.velocities, smooth.velocities, **scale)
    np.testing.assert_allclose(faint.spins, smooth.spins, **scale)


@draws(200)
@given(SEEDS)
def test_at_a_wall_it_is_the_contact_with_a_fixed_normal(seed: int) -> None:
    draw = drawn(seed, wall=True)
    impact = draw.impact()
    relative = draw.velocities[0] - draw.velocities[1]
    slip = relative - (relative @ draw.normal) * draw.normal + np.cross(draw.spins[0], draw.normal)
    flat = impact.contact.impact(1.0, float(np.linalg.norm(slip)))
    assert impact.restitution == pytest.approx(flat.restitution, abs=1e-12)
    assert impact.tangential_restitution == pytest.approx(flat.tangential_restitution, abs=1e-10)
    assert impact.duration == pytest.approx(flat.duration, rel=1e-12)


def test_a_slip_just_before_the_end_is_found() -> None:
    """An elastic contact, whose spring and limit both end at zero."""
    draw = drawn(12354, wall=True)
    impact = draw.impact()
    flat = impact.contact.impact(1.0, float(np.linalg.norm(impact.initial_slip_velocity)))
    assert impact.transitions == 1 and impact.intervals[1].begin > 0.997 * impact.duration
    assert impact.tangential_restitution == pytest.approx(flat.tangential_restitution, abs=1e-12)


@draws(60)
@given(SEEDS)
def test_a_short_contact_of_two_balls_has_a_fixed_normal(seed: int) -> None:
    """The difference falls in proportion to the duration."""
    draw = drawn(seed, wall=False, name="linear")
    errors = []
    for part in (1e-3, 1e-4):
        short = draw.law.replace(stiffness=draw.law.stiffness * (draw.duration / part) ** 2)
        impact = replace(draw, law=short).impact()
        slip = np.linalg.norm(impact.initial_slip_velocity)
        flat = impact.contact.impact(1.0, float(slip))
        errors.append(abs(impact.tangential_restitution - flat.tangential_restitution))
    size = 1.0 + draw.speed / slip
    assert errors[1] < 1e-2 * size and (errors[1] < 0.5 * errors[0] or errors[1] < 1e-4 * size)


@pytest.mark.parametrize("case", CASES, ids=range(len(CASES)))
def test_reference_values(case: dict[str, Any]) -> None:
    def in_space(rows: Any) -> np.ndarray:
        rows = np.array(rows)
        return rows if rows.shape[1] == 3 else np.column_stack([rows, np.zeros(2)])

    def spins(rows: Any) -> np.ndarray:
        rows = np.array(rows)
        return rows if rows.ndim == 2 else np.outer(rows, UP)

    balls = [
        hl.Ball(radius, mass=mass, inertia_factor=case["inertia_factor"])
        for radius, mass in zip(case["radius"], case["mass"], strict=True)
    ]
    surface = hl.Friction(
        case["friction"], stiffness=case["tangential_stiffness"], damping=case["tangential_damping"] or None
    )
    law = hl.LinearDashpot(stiffness=case["stiffness"], restitution=case["restitution"], friction=surface)
    begin, end, *_ = case["contacts"][0]
    x, v = in_space(case["positions"]), in_space(case["velocities"])
    touch = x + begin * v
    impact = hl.oblique_impact(
        *balls,
        law,
        v[0],
        other_velocity=v[1],
        spins=spins(case["angular_velocities"]),
        normal=touch[1] - touch[0],
    )
    assert impact.transitions >= case["changes"]
    until = case["until"] - begin
    if end is None:  # stopped during the contact
        state = impact.trajectory([until])
        positions = touch + state["displacement"].values[0]
        velocities, turned = state["velocity"].values[0], state["spin"].values[0]
    else:
        assert impact.duration == pytest.approx(end - begin, rel=1e-7)
        positions = touch + impact.equivalent.displacements + until * impact.velocities
        velocities, turned = impact.velocities, impact.spins
    tolerance, speed = case["tolerance"], case["speed_scale"]
    np.testing.assert_allclose(velocities, in_space(case["end_velocities"]), atol=tolerance * speed, rtol=0)
    np.testing.assert_allclose(
        turned, spins(case["end_angular_velocities"]), atol=tolerance * speed / 1e-3, rtol=0
    )
    np.testing.assert_allclose(positions, in_space(case["end_positions"]), atol=tolerance * 1e-3, rtol=0)


LAW = hl.LinearDashpot(stiffness=1e4, restitution=0.9, friction=hl.Friction(0.5, damping_ratio=0.5))
BALL = hl.Ball(0.01, density=2500.0)


def test_balls_that_roll_on_each_other_feel_no_friction() -> None:
    spin = np.array([0.0, 40.0, 0.0])
    still = hl.oblique_impact(BALL, BALL, LAW, (0.0, 0.0, -1.0))
    rolling = hl.oblique_impact(BALL, BALL, LAW, (0.0, 0.0, -1.0), spins=[spin, -spin])
    assert not rolling.initial_slip_velocity.any()
    assert (rolling.velocities == still.velocities).all()
    assert (rolling.spins == [spin, -spin]).all() and math.isnan(rolling.tangential_restitution)


def test_head_on_nothing_turns() -> None:
    """Zero tangential velocity; also with a spin along the normal, which no force changes."""
    for spin in (0.0, 300.0):
        impact = hl.oblique_impact(BALL, BALL, LAW, (0.0, 0.0, -1.0), spins=(0.0, 0.0, spin))
        assert impact.turn == 0.0 and (impact.spins[0] == [0.0, 0.0, spin]).all()
        assert impact.restitution == pytest.approx(0.9, rel=1e-13)
        assert not impact.impulse[:2].any()


def test_velocity_along_the_spin() -> None:
    """The slip is oblique to both, and turns. The mirror image of the spin mirrors the result."""
    impacts = [
        hl.oblique_impact(BALL, BALL, LAW, (0.5, 0.0, -1.0), spins=[(w, 0.0, 0.0), (w, 0.0, 0.0)])
        for w in (30.0, -30.0)
    ]
    assert abs(impacts[0].velocities[0, 1]) > 1e-3
    np.testing.assert_allclose(impacts[1].velocities, impacts[0].velocities * [1.0, -1.0, 1.0], atol=1e-14)


def test_a_moving_wall_and_a_vertical_one() -> None:
    still = hl.oblique_impact(BALL, hl.FLOOR, LAW, (1.0, 0.5, -1.0), spins=(3.0, -20.0, 7.0))
    moving = hl.oblique_impact(
        BALL, hl.FLOOR, LAW, (1.25, 0.5, -0.5), other_velocity=(0.25, 0.0, 0.5), spins=(3.0, -20.0, 7.0)
    )
    np.testing.assert_allclose(moving.velocities, still.velocities + np.array([0.25, 0.0, 0.5]), atol=1e-14)
    np.testing.assert_allclose(moving.spins, still.spins, atol=1e-11)
    aside = hl.oblique_impact(BALL, hl.FLOOR, LAW, (1.0, 0.0, 0.5), normal=(2.0, 0.0, 0.0))
    assert aside.velocities[0, 0] == pytest.approx(-0.9) and aside.turn == 0.0


@draws(40)
@given(SEEDS)
def test_the_trajectory_ends_where_the_impact_does(seed: int) -> None:
    draw = drawn(seed)
    impact = draw.impact()
    path = impact.trajectory()
    last = path.isel(time=-1)
    scale = {"rtol": 0, "atol": 1e-11 * draw.speed}
    np.testing.assert_allclose(last["velocity"], impact.velocities, **scale)
    np.testing.assert_allclose(last["spin"], impact.spins, **scale)
    np.testing.assert_allclose(last["displacement"], impact.displacements, **scale)
    assert path["displacement"].isel(time=0).values == pytest.approx(0.0, abs=1e-300)
    force = np.linalg.norm(path["tangential_force"], axis=1)
    mu = draw.law.friction.coefficient
    limited = (
        draw.law.friction.limit == "total"
        or draw.law.friction.model == "none"
        or not draw.law.friction.damping_ratio
    )
    if mu < math.inf and limited:
        assert (force <= mu * path["normal_force"].values * (1 + 1e-9) + 1e-9 * force.max()).all()
    # The force is the rate of the momentum.
    momentum = impact.contact.effective_mass * np.diff(path["velocity"].values, axis=1)[:, 0]
    total = path["normal_force"].values[:, None] * path["normal"].values + path["tangential_force"].values
    gained = np.concatenate(
        [
            [np.zeros(3)],
            np.cumsum(0.5 * (total[1:] + total[:-1]) * np.diff(path["time"].values)[:, None], axis=0),
        ]
    )
    np.testing.assert_allclose(momentum - momentum[0], gained, atol=2e-3 * np.abs(momentum).max())


def test_equivalent_collision_leads_to_the_same_path() -> None:
    impact = hl.oblique_impact(BALL, BALL, LAW, (1.0, 0.3, -1.0), spins=(5.0, 3.0, 2.0))
    equivalent, t = impact.equivalent, impact.duration
    np.testing.assert_allclose(
        equivalent.displacements + t * equivalent.velocities, impact.displacements, atol=1e-17
    )


def test_too_deep() -> None:
    with pytest.raises(RuntimeError, match="too deep"):
        hl.oblique_impact(BALL, BALL, LAW.replace(stiffness=10.0), (0.0, 0.0, -1.0))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"velocity": (0.0, 0.0, 1.0)}, "approach"),
        ({"velocity": (0.0, 1.0)}, "velocity: got shape"),
        ({"normal": (0.0, 0.0, 0.0)}, "normal: got a vector of length 0"),
        ({"spins": (1.0, 2.0)}, "spins: got shape"),
        ({"other": hl.FLOOR, "spins": [(0.0, 0.0, 1.0)] * 2}, "spin of the floor"),
        ({"law": 3}, "law: got 3"),
        (
            {
                "law": hl.Tsuji(
                    elastic_prefactor=1e9,
                    restitution=0.9,
                    friction=hl.Friction(0.5, stiffness_ratio=0.8, damping=1.0),
                )
            },
            "damping: got it with the model",
        ),
        (
            {"velocity": (0.0, 0.0, -1e160)},
            "spins: got a kinetic energy of inf J, must be in [1e-290, 1e+300]",
        ),
        ({"velocity": (0.0, 0.0, -1e-160)}, "J, must be in [1e-290, 1e+300]"),
    ],
)
def test_refusals(arguments: dict[str, Any], words: str) -> None:
    values: dict[str, Any] = {
        "ball": BALL,
        "other": BALL,
        "law": LAW,
        "velocity": (0.0, 0.0, -1.0),
    } | arguments
    assert words in refusal(lambda: hl.oblique_impact(**values))


def test_plot_and_text() -> None:
    impact = hl.oblique_impact(BALL, BALL, LAW, (1.0, 0.0, -1.0))
    assert len(impact.plot().axes) == 3 and repr(impact).startswith("<ObliqueImpact: ε = ")
