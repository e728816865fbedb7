"""The isolated contact in the plane of approach, for every law: its end, its path, and the equivalent collision."""

import csv
import math
from pathlib import Path

import mpmath
import numpy as np
import pytest
import scipy
from hypothesis import assume, given
from hypothesis import strategies as st

import hardlimit as hl
from conftest import DATA, draws, law_of, laws, log_floats, output_of, slow
from hardlimit import _core

PATH = DATA / "oblique_rotation.csv"
ROWS = list(csv.DictReader(PATH.read_text(encoding="utf-8").splitlines()))


def core_contact(law: hl.Law, mass: float = 1.0, radius: float = 0.25) -> _core.Contact:
    """The contact of two equal balls of this reduced mass and effective radius."""
    ball = hl.Ball(2.0 * radius, mass=2.0 * mass)
    return law.between(ball, ball).core


def linear(stiffness: float, restitution: float = 1.0, mass: float = 1.0) -> _core.Contact:
    return core_contact(hl.LinearDashpot(stiffness=stiffness, restitution=restitution), mass)


def softened(law: hl.Law, speed: float, depth: float) -> tuple[_core.Contact, float]:
    """A contact of the law, and the distance of centres such that an elastic impact reaches ``depth`` times it."""
    contact = core_contact(law)
    low, high = 1e-30, 1e30
    for _ in range(300):
        middle = math.sqrt(low * high)
        energy = contact.energy(np.array([middle]))[0]
        low, high = (middle, high) if energy < 0.5 * contact.effective_mass * speed**2 else (low, middle)
    return contact, high / depth


@pytest.mark.parametrize("row", ROWS, ids=lambda row: "-".join(list(row.values())[:3]))
def test_normal_turns_as_known(row: dict[str, str]) -> None:
    name, duration, angle, rotation, length = row.values()
    duration, angle = float(duration), math.radians(float(angle))
    if name == "linear":
        contact = linear((math.pi / duration) ** 2)
    else:
        prefactor = (3.218065459719 / duration) ** 2.5
        modulus = prefactor * 3.0 * (1.0 - 0.3**2) / (2.0 * math.sqrt(0.25))
        law = hl.Viscoelastic(youngs_modulus=modulus, poisson_ratio=0.3, dissipative_time=0.0)
        contact = core_contact(law)
    end = _core.planar_contact(contact, 1.0, math.cos(angle), math.sin(angle))
    assert math.degrees(end["turn"]) == pytest.approx(float(rotation), rel=1e-9)
    assert end["duration"] / duration == pytest.approx(float(length), rel=1e-9)


@draws(100)
@given(laws(), log_floats(1e-3, 1e2), log_floats(1e-9, 1e3))
def test_head_on_it_is_the_collision_of_the_law(law: hl.Law, speed: float, distance: float) -> None:
    contact = core_contact(law)
    end = _core.planar_contact(contact, distance, speed, 0.0)
    assume(end["outcome"] == "ok")
    restitution, duration = (f(np.array([speed]))[0] for f in (contact.restitution, contact.duration))
    assert end["radial_speed"] == pytest.approx(restitution * speed, rel=1e-13)
    assert end["duration"] == pytest.approx(duration, rel=3e-13)
    assert end["turn"] == 0.0 and end["tangential_speed"] == 0.0 and end["tangential_shift"] == 0.0
    assert end["normal_shift"] == pytest.approx(
        -end["compression"] - duration * restitution * speed, rel=1e-12
    )


def cartesian(contact: _core.Contact, distance: float, normal: float, tangential: float) -> np.ndarray:
    """Time, position and velocity at the end of the contact, by SciPy in Cartesian coordinates."""

    def motion(_: float, y: np.ndarray) -> list[float]:
        r = math.hypot(y[0], y[1])
        rate = -(y[0] * y[2] + y[1] * y[3]) / r
        push = contact.force(np.array([distance - r]), np.array([rate]))[0]
        push /= contact.effective_mass * r
        return [y[2], y[3], push * y[0], push * y[1]]

    duration = contact.duration(np.array([normal]))[0]
    end = _core.planar_contact(contact, distance, normal, tangential)["duration"]
    start = [distance, 0.0, -normal, tangential]
    run = scipy.integrate.solve_ivp(
        motion, (0, end), start, "DOP853", rtol=1e-12, atol=1e-15, max_step=min(duration, end) / 30
    )
    return run.y[:, -1]


@draws(40)
@given(st.sampled_from(sorted(hl.LAWS)), st.floats(0.1, 1.0), log_floats(1e-4, 0.3), st.floats(0.0, 1.5))
def test_end_of_an_oblique_contact(name: str, restitution: float, depth: float, angle: float) -> None:
    """The final state is that of an independent integration in Cartesian coordinates, and the force is zero there."""
    normal, tangential = math.cos(angle), math.sin(angle)
    contact, distance = softened(law_of(name, restitution), normal, depth)
    end = _core.planar_contact(contact, distance, normal, tangential)
    assert end["outcome"] == "ok"
    y = cartesian(contact, distance, normal, tangential)
    turned, r = math.atan2(y[1], y[0]), math.hypot(y[0], y[1])
    assert turned == pytest.approx(end["turn"], rel=1e-8, abs=1e-10 * depth)
    assert (distance - r) / distance == pytest.approx(end["compression"] / distance, abs=1e-9 * depth)
    assert np.dot(y[:2], y[2:]) / r == pytest.approx(end["radial_speed"], abs=1e-9)
    assert end["tangential_speed"] * (distance - end["compression"]) == pytest.approx(distance * tangential)
    # The force falls through zero there: it is still positive just before the end.
    before, after = _core.planar_path(
        contact, distance, normal, tangential, end["duration"] * np.array([1.0 - 1e-4, 1.0])
    )
    force = contact.force(np.array([before[0], after[0]]), np.array([before[1], after[1]]))
    largest = contact.effective_mass * normal / end["duration"]
    assert force[0] > 0.0 and abs(force[1]) < 1e-10 * largest
    # The free path after the equivalent collision passes through the end of the contact.
    x = distance + end["normal_shift"] + end["duration"] * end["normal_velocity"]
    z = end["tangential_shift"] + end["duration"] * end["tangential_velocity"]
    assert math.hypot(x, z) == pytest.approx(distance - end["compression"], rel=1e-14)
    assert math.atan2(z, x) == pytest.approx(end["turn"], rel=1e-11, abs=1e-15)


@pytest.mark.parametrize(
    ("stiffness", "restitution", "normal", "tangential"),
    [(4e3, 0.8, 1.0, 2.0), (4e2, 0.3, 1.0, 0.5), (1e16, 0.6, 1.0, 3.0), (4e3, 0.95, 1e-3, 1.0)],
)
def test_linear_law_in_high_precision(
    stiffness: float, restitution: float, normal: float, tangential: float
) -> None:
    """Taylor series of 30 digits; also where the compression is 1e-8 of the distance, and for a grazing impact."""
    contact = linear(stiffness, restitution)
    k, gamma = (mpmath.mpf(v) for v in contact.values())
    end = _core.planar_contact(contact, 1.0, normal, tangential)
    with mpmath.workdps(30):
        h, v = mpmath.mpf(tangential), mpmath.mpf(normal)
        unit = 1 / mpmath.sqrt(k)

        def motion(_, y):  # compression in v·unit, its rate in v, rotation angle; time in units of 1/ω
            xi, rate, _ = y
            r = 1 - unit * v * xi
            pull = unit * gamma * rate
            return [rate, -xi - pull - unit * h * h / (v * r**3), unit * h / r**2]

        solution = mpmath.odefun(
            motion, 0, [mpmath.mpf(0), mpmath.mpf(1), mpmath.mpf(0)], tol=mpmath.mpf(10) ** -26
        )
        tau = mpmath.findroot(
            lambda t: solution(t)[0] + unit * gamma * solution(t)[1],
            mpmath.mpf(end["duration"]) / unit,
            tol=1e-40,
        )
        xi, rate, turn = solution(tau)
        assert abs(end["duration"] / (tau * unit) - 1) < 1e-13
        assert abs(end["turn"] / turn - 1) < 1e-13
        assert abs(end["compression"] / (xi * unit * v) - 1) < 1e-12
        assert abs(end["radial_speed"] / (-rate * v) - 1) < 1e-13
        # The displacement is a difference of lengths that are 1e8 times as large.
        r = 1 - unit * v * xi
        sine, cosine = mpmath.sin(turn), mpmath.cos(turn)
        radial, across = -rate * v, h / r
        along = r * cosine - 1 - tau * unit * (radial * cosine - across * sine)
        aside = r * sine - tau * unit * (radial * sine + across * cosine)
        scale = tau * unit * (v + h)
        assert abs(end["normal_shift"] - along) < 1e-13 * scale
        assert abs(end["tangential_shift"] - aside) < 1e-13 * scale


@draws(100)
@given(st.sampled_from(sorted(hl.LAWS)), log_floats(1e-9, 0.4), st.floats(0.0, 1.57))
def test_undamped_contact_loses_nothing(name: str, depth: float, angle: float) -> None:
    """Energy is conserved along the path, and approach and separation are symmetric."""
    normal, tangential = math.cos(angle), math.sin(angle)
    contact, distance = softened(law_of(name, 1.0), normal, depth)
    end = _core.planar_contact(contact, distance, normal, tangential)
    assert end["outcome"] == "ok" and end["compression"] == pytest.approx(0.0, abs=1e-15 * distance * depth)
    assert end["radial_speed"] == pytest.approx(normal, rel=1e-15)
    path = _core.planar_path(
        contact, distance, normal, tangential, end["duration"] * np.linspace(0.0, 1.0, 21)
    )
    across = tangential * distance / (distance - path[:, 0])
    kinetic = 0.5 * contact.effective_mass * (path[:, 1] ** 2 + (across - tangential) * (across + tangential))
    stored = contact.energy(np.maximum(path[:, 0], 0.0))
    energy = 0.5 * contact.effective_mass * normal**2
    rounding = 1e-15 * contact.effective_mass * tangential**2
    assert kinetic + stored == pytest.approx(energy, rel=2e-13, abs=rounding)
    largest = path[:, 0].max()
    assert path[:, 0] == pytest.approx(path[::-1, 0], abs=1e-12 * largest)
    assert path[:, 2] + path[::-1, 2] == pytest.approx(end["turn"], rel=1e-13)


@draws(100)
@given(laws(), log_floats(1e-6, 0.3), st.floats(0.0, 1.5707))
def test_energy_lost_is_the_work_of_the_damping(law: hl.Law, depth: float, angle: float) -> None:
    """Work of the force by quadrature along the path; energy still stored when the force ends is lost."""
    normal, tangential = math.cos(angle), math.sin(angle)
    contact, distance = softened(law, normal, depth)
    end = _core.planar_contact(contact, distance, normal, tangential)
    assert end["outcome"] == "ok"
    # Time as x²(3 − 2x), which removes the square-root singularities at both ends of the path.
    nodes, weights = np.polynomial.legendre.leggauss(60)
    x = 0.5 * (nodes + 1.0)
    path = _core.planar_path(contact, distance, normal, tangential, end["duration"] * x * x * (3.0 - 2.0 * x))
    steps = 0.5 * weights * end["duration"] * 6.0 * x * (1.0 - x)
    pushed = contact.force(path[:, 0], path[:, 1])
    mass = contact.effective_mass
    work = -np.sum(steps * pushed * path[:, 1])
    gained = end["radial_speed"] ** 2 + end["tangential_speed"] ** 2 - normal**2 - tangential**2
    assert 0.5 * mass * gained == pytest.approx(work, abs=1e-7 * mass * normal**2 + 1e-14 * mass)


def test_grazing_impact_is_over_before_a_force_acts() -> None:
    """Tangential over normal speed up to 1e6: undamped, the straight chord through the distance l."""
    contact, distance = linear(1e2), 1.0
    for ratio in (1e3, 1e4, 1e5, 1e6):
        normal, tangential = 1.0 / ratio, 1.0
        end = _core.planar_contact(contact, distance, normal, tangential)
        chord = 2.0 * normal / (normal**2 + tangential**2)
        bent = 0.5 * 1e2 * chord**2 / 3.0
        assert end["duration"] == pytest.approx(chord, rel=2.0 * bent + 1e-14)
        assert end["turn"] == pytest.approx(2.0 * math.atan2(normal, tangential), rel=2.0 * bent + 1e-14)
        assert end["radial_speed"] == normal


def test_after_the_contact_the_pair_flies_straight() -> None:
    contact, distance = softened(law_of("viscoelastic", 0.6), 0.7, 0.1)
    end = _core.planar_contact(contact, distance, 0.7, 1.1)
    times = end["duration"] * np.array([0.0, 1.0, 1.5, 40.0])
    touch, over, *later = _core.planar_path(contact, distance, 0.7, 1.1, times)
    assert touch == pytest.approx([0.0, 0.7, 0.0], abs=0.0)
    assert over == pytest.approx([end["compression"], -end["radial_speed"], end["turn"]], rel=1e-12)
    for t, (compression, rate, turn) in zip(times[2:], later, strict=True):
        x = distance + end["normal_shift"] + t * end["normal_velocity"]
        z = end["tangential_shift"] + t * end["tangential_velocity"]
        r = math.hypot(x, z)
        assert distance - compression == pytest.approx(r, rel=1e-14)
        assert turn == pytest.approx(math.atan2(z, x), rel=1e-13)
        speed = (x * end["normal_velocity"] + z * end["tangential_velocity"]) / r
        assert -rate == pytest.approx(speed, rel=1e-13)


@pytest.mark.parametrize("speed", [3.0, 0.3, 0.2])
@pytest.mark.parametrize("gravity", [9.81, -9.81])
def test_wall_across_gravity(speed: float, gravity: float) -> None:
    """The linear law has a closed form: ξ = g/ω² + a decaying oscillation."""
    contact = linear(5e3, 0.8)
    end = _core.planar_contact(contact, math.inf, speed, 0.4, gravity)
    k, gamma = (mpmath.mpf(v) for v in contact.values())
    beta = gamma / 2
    omega = mpmath.sqrt(k - beta**2)
    still = gravity / k

    def compression(t):
        a, b = -still, (speed - beta * still) / omega
        return still + mpmath.exp(-beta * t) * (a * mpmath.cos(omega * t) + b * mpmath.sin(omega * t))

    def rate(t):
        return mpmath.diff(compression, t)

    with mpmath.workdps(30):
        t = mpmath.findroot(lambda t: k * compression(t) + gamma * rate(t), end["duration"])
        assert end["duration"] == pytest.approx(float(t), rel=1e-13)
        assert end["compression"] == pytest.approx(float(compression(t)), rel=1e-12)
        assert end["radial_speed"] == pytest.approx(float(-rate(t)), rel=1e-13)
    assert end["turn"] == 0.0 and end["tangential_velocity"] == 0.4 and end["tangential_shift"] == 0.0
    # The parabola of the equivalent collision passes through the end of the contact with its velocity.
    t = end["duration"]
    assert end["normal_velocity"] - gravity * t == pytest.approx(end["radial_speed"], rel=1e-13)
    place = end["normal_shift"] + t * end["normal_velocity"] - 0.5 * gravity * t * t
    assert place == pytest.approx(-end["compression"], rel=1e-10)


@pytest.mark.parametrize("damping", [3.0, 10.0, 30.0, 100.0])
def test_a_strongly_damped_body_creeps_to_rest(damping: float) -> None:
    """Force and weight balance to rounding, which must not count as an error of a step."""
    contact = core_contact(hl.LinearDashpot(stiffness=1e3, damping=damping), mass=1e-3)
    end = _core.planar_contact(contact, math.inf, 0.1, 0.0, 9.81)
    assert end["outcome"] == "at_rest" and end["duration"] == math.inf


@pytest.mark.parametrize("name", sorted(hl.LAWS))
def test_gravity_holds_a_slow_body_on_the_wall(name: str) -> None:
    """Above some speed the contact ends, below it never does; without damping it ends at any speed."""
    contact = core_contact(law_of(name, 0.5))
    speeds = np.logspace(1, -9, 81)
    outcomes = [_core.planar_contact(contact, math.inf, v, 0.0, 9.81)["outcome"] for v in speeds]
    first = outcomes.index("at_rest")
    assert first > 20
    assert set(outcomes[:first]) == {"ok"} and set(outcomes[first:]) == {"at_rest"}
    elastic = core_contact(law_of(name, 1.0))
    for v in speeds[:60]:
        end = _core.planar_contact(elastic, math.inf, v, 0.0, 9.81)
        assert end["outcome"] == "ok" and end["radial_speed"] == pytest.approx(v, rel=1e-9)


def test_what_is_refused() -> None:
    """Invalid: no approach, NaN, and an impact that would bring the centres closer than half their distance."""
    contact = linear(16.0)
    for normal, tangential in [(0.0, 1.0), (-1.0, 0.0), (math.nan, 1.0), (1.0, math.nan), (math.inf, 0.0)]:
        end = _core.planar_contact(contact, 1.0, normal, tangential)
        assert end["outcome"] == "invalid" and math.isnan(end["duration"]) and math.isnan(end["normal_shift"])
    assert _core.planar_contact(contact, 1.0, 2.0 * (1.0 + 1e-12), 0.0)["outcome"] == "too_deep"
    end = _core.planar_contact(contact, 1.0, 2.0 * (1.0 - 1e-12), 0.0)
    assert end["outcome"] == "ok" and end["duration"] == pytest.approx(math.pi / 4.0, rel=1e-14)


# ---- polynomials -------------------------------------------------------------------------------------------

COLUMNS = ["duration", "turn", "compression", "radial_speed", "tangential_speed"]


def read_and_solved(
    own: _core.Contact,
    own_distance: float,
    varies: bool,
    contact: _core.Contact,
    distance: float,
    speeds: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Contacts from the polynomials of an event-driven run, and from the solver."""
    normal, tangential = np.ascontiguousarray(speeds.T)
    read = _core.soft_contacts(own, own_distance, varies, contact, distance, normal, tangential)
    ends = (_core.planar_contact(contact, distance, *pair) for pair in speeds)
    return read, np.array([[end[name] for name in COLUMNS] for end in ends])


def assert_as_accurate_as_stated(read: np.ndarray, solved: np.ndarray, normal: np.ndarray) -> None:
    assert np.array_equal(np.isnan(read), np.isnan(solved))
    allowed = 1e-10
    for column in (0, 1, 4):
        np.testing.assert_allclose(read[:, column], solved[:, column], rtol=allowed, atol=0.0)
    left, right = read[:, 2] / (normal * solved[:, 0]), solved[:, 2] / (normal * solved[:, 0])
    np.testing.assert_allclose(left, right, rtol=0.0, atol=allowed)
    np.testing.assert_allclose(read[:, 3] / normal, solved[:, 3] / normal, rtol=0.0, atol=allowed)


def thermal_speeds(rng: np.random.Generator, n: int, scale: float) -> np.ndarray:
    """Normal and tangential speeds of collisions in a gas, and of grazing collisions."""
    speeds = scale * np.sqrt(-2.0 * np.log(rng.random((n, 2))))
    speeds[::10, 0] *= 10.0 ** -rng.uniform(0.0, 6.0, len(speeds[::10]))
    speeds[3::10, 1] *= 10.0 ** -rng.uniform(0.0, 6.0, len(speeds[3::10]))
    speeds[5, 1] = 0.0
    return speeds


@pytest.mark.parametrize("restitution", [1.0, 0.9, slow(0.5), 0.1])
@pytest.mark.parametrize("name", sorted(hl.LAWS))
@pytest.mark.parametrize("depth", [slow(1e-6), 0.05])
def test_polynomials_are_as_accurate_as_stated(name: str, restitution: float, depth: float) -> None:
    rng = np.random.default_rng(1)
    contact, distance = softened(law_of(name, restitution), 1.0, depth)
    speeds = thermal_speeds(rng, 200, 1.0)
    read, solved = read_and_solved(contact, distance, False, contact, distance, speeds)
    assert_as_accurate_as_stated(read, solved, speeds[:, 0])
    # Nearly all thermal collisions use the polynomials instead of the solver.
    assert np.mean(np.any(read != solved, axis=1)[speeds[:, 0] > 0.1]) > 0.5 or restitution == 1.0
    if restitution == 1.0:
        assert np.array_equal(read[:, 3], speeds[:, 0])  # no loss, bit for bit
        assert np.array_equal(read[:, 4], speeds[:, 1])
    # A body at a wall: other effective mass and radius, and infinite distance.
    ball = hl.Ball(0.5, mass=2.0)
    wall = law_of(name, restitution).between(ball, hl.FLOOR).core
    read, solved = read_and_solved(contact, distance, False, wall, math.inf, speeds[:50])
    assert_as_accurate_as_stated(read, solved, speeds[:50, 0])


@pytest.mark.parametrize("name", sorted(hl.LAWS))
def test_one_set_of_polynomials_serves_all_pairs(name: str) -> None:
    """Bodies of different sizes, masses and stiffness under a law with one restitution or one material constant."""
    rng = np.random.default_rng(2)
    own, distance = softened(law_of(name, 0.8), 1.0, 0.02)
    for varies in (False, True):
        for mass, radius in [(0.3, 0.25), (5.0, 0.1), (40.0, 2.0)]:
            other = core_contact(law_of(name, 0.8, 2.0 if varies else 1.0), mass, radius)
            speeds = thermal_speeds(rng, 60, 1.0)
            read, solved = read_and_solved(own, distance, varies, other, 1.7 * distance, speeds)
            assert_as_accurate_as_stated(read, solved, speeds[:, 0])


def test_what_is_read_does_not_depend_on_the_calls_before() -> None:
    contact, distance = softened(law_of("viscoelastic", 0.7), 1.0, 0.02)
    speeds = thermal_speeds(np.random.default_rng(3), 300, 1.0)
    for varies in (False, True):
        forth, _ = read_and_solved(contact, distance, varies, contact, distance, speeds)
        back, _ = read_and_solved(contact, distance, varies, contact, distance, speeds[::-1])
        assert np.array_equal(forth, back[::-1])


@pytest.mark.parametrize("gravity", [-9.81, -1e-300, 0.0, 1e-300, 9.81])
@pytest.mark.parametrize("name", ["linear", "tsuji", "viscoelastic"])
def test_a_touch_however_slow_has_an_end(name: str, gravity: float) -> None:
    """Down to speeds whose squares underflow; at rest only if a weight presses."""
    law = {
        "linear": hl.LinearDashpot(stiffness=1e6, restitution=0.5),
        "tsuji": hl.Tsuji(elastic_prefactor=1e6, restitution=0.5),
        "viscoelastic": hl.Viscoelastic(
            youngs_modulus=1e8, poisson_ratio=0.3, restitution=0.5, impact_speed=1.0
        ),
    }[name]
    contact = core_contact(law)
    for speed in (1e-10, 1e-20, 1e-50, 1e-99, 1e-101, 1e-160, 1e-250, 5e-324):
        end = _core.planar_contact(contact, math.inf, speed, 0.0, gravity)
        if gravity == 9.81:
            assert end["outcome"] == "at_rest"
            continue
        assert end["outcome"] == "ok" and end["duration"] > 0.0 and end["compression"] >= 0.0
        if name == "linear" and gravity > -1.0 and speed > 1e-300:  # of a scale of its own, without gravity
            still = _core.planar_contact(contact, math.inf, 1.0, 0.0)
            rate = end["radial_speed"] / speed
            assert rate == pytest.approx(0.5, rel=1e-3 if speed < 1e-200 else 1e-9)
            assert end["duration"] == pytest.approx(still["duration"], rel=1e-2)


@pytest.mark.slow
def test_a_law_without_stated_coefficients_has_a_table_for_one_kind_of_pair(tmp_path: Path) -> None:
    own, lighter = map(float, output_of("boxes/tabulated_contact.cpp", tmp_path).split())
    assert 0.0 < own < 1e-9 and lighter == 0.0
