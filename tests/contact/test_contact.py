"""Contact laws: each law against independent calculations, and properties of every registered law."""

import functools
import math
from functools import partial

import mpmath
import numpy as np
import pytest
import scipy
from hypothesis import given
from hypothesis import strategies as st

import hardlimit as hl
from conftest import (
    alternative,
    damped,
    damping_name,
    dimension,
    draws,
    law_of,
    output_of,
    refusal,
    slow,
    table,
    typical,
)
from hardlimit import _core

BALL = hl.Ball(0.1, density=840.0)
SMALL = hl.Ball(0.01, density=840.0)

#: From nearly 0 to the last double below 1, with critical damping, β = ω0/√2 and values on both sides of them.
RESTITUTIONS = [
    1e-12, 1e-9, 1e-6, 1e-3, 0.02, 0.1, 0.135, math.exp(-2.0), 0.1354, 0.2, math.exp(-math.pi / 2.0), 0.21,
    0.3, 0.499999, 0.5, 0.500001, 0.7, 0.9, 0.99, 0.999999, 1.0 - 1e-9, 1.0 - 1e-12, 1.0 - 1e-15, 1.0 - 1e-16,
    1.0,
]  # fmt: skip

SPEEDS = [1e-6, 1e-3, 0.3, 3.0, 100.0]


# ---- linear dashpot ----------------------------------------------------------------------------------------


def linear_collision(b) -> tuple[mpmath.mpf, mpmath.mpf]:
    """ω0 t_c and ε at β/ω0 = b, from the solution ξ(t) of the equation of motion: the first zero of ξ + 2b ξ̇.

    ξ = e^{−bt} sin(wt)/w, so the force vanishes where (1 − 2b²) sin(wt)/w + 2b cos(wt) = 0.
    """
    b = mpmath.mpf(b)
    if b == 0:
        return mpmath.pi, mpmath.mpf(1)
    if b == 1:
        return mpmath.mpf(2), mpmath.exp(-2)
    if b < 1:
        w = mpmath.sqrt((1 - b) * (1 + b))
        phase = mpmath.findroot(
            lambda p: (1 - 2 * b * b) * mpmath.sin(p) / w + 2 * b * mpmath.cos(p),
            (mpmath.mpf(10) ** -100, mpmath.pi),
            solver="anderson",
            tol=mpmath.mpf(10) ** -150,
            maxsteps=500,
        )
        rate = mpmath.exp(-b * phase / w) * (mpmath.cos(phase) - b * mpmath.sin(phase) / w)
    else:
        w = mpmath.sqrt((b - 1) * (b + 1))
        phase = mpmath.atanh(2 * b * w / (2 * b * b - 1))
        rate = mpmath.exp(-b * phase / w) * (mpmath.cosh(phase) - b * mpmath.sinh(phase) / w)
    return phase / w, -rate


def damping_ratios() -> np.ndarray:
    near_one = np.logspace(-15, -1, 29)
    return np.concatenate([np.logspace(-12, 6, 73), 1.0 + near_one, 1.0 - near_one, [math.sqrt(0.5)]])


def test_linear_table():
    for row in table("restitution_linear"):
        b, duration, restitution = (np.array([float(v)]) for v in row.values())
        assert _core.linear_duration(b) == pytest.approx(duration, rel=1e-15, abs=0.0)
        assert _core.linear_restitution(b) == pytest.approx(restitution, rel=1e-15, abs=0.0), b


@pytest.mark.slow
def test_linear_collision_in_high_precision():
    ratios = damping_ratios()
    pairs = zip(ratios, _core.linear_duration(ratios), _core.linear_restitution(ratios), strict=True)
    with mpmath.workdps(120):
        for b, duration, restitution in pairs:
            exact_duration, exact_restitution = linear_collision(b)
            # The restitution is exp(−b t_c): each unit of the exponent costs one rounding.
            exponent = float(b * exact_duration)
            assert abs(duration / exact_duration - 1) < 1e-15, b
            assert abs(restitution / exact_restitution - 1) < 1e-15 + 2.3e-16 * exponent, b


@pytest.mark.parametrize("restitution", RESTITUTIONS)
def test_linear_inverse_in_high_precision(restitution):
    """The damping computed for ε gives ε and 1 − ε to 1e-13 in 120-digit arithmetic."""
    contact = hl.LinearDashpot(stiffness=5e7, restitution=restitution).between(BALL)
    with mpmath.workdps(120):
        m, k = mpmath.mpf(contact.effective_mass), mpmath.mpf(5e7)
        _, epsilon = linear_collision(mpmath.mpf(contact.damping) / (2 * mpmath.sqrt(k * m)))
        assert abs(epsilon / mpmath.mpf(restitution) - 1) < 1e-13
        if restitution < 1.0:
            loss = 1 - mpmath.mpf(restitution)
            assert abs((1 - epsilon) / loss - 1) < 1e-13
        else:
            assert contact.damping == 0.0


@pytest.mark.parametrize("restitution", [*RESTITUTIONS, 1e-30, 1e-100])
@pytest.mark.parametrize("partner", [hl.FLOOR, SMALL, hl.Ball(1e-6, density=1e3), hl.Ball(50.0, density=1e4)])
@pytest.mark.parametrize("stiffness", [1e-3, 5e7, 1e15])
def test_linear_round_trip(restitution, partner, stiffness):
    contact = hl.LinearDashpot(stiffness=stiffness, restitution=restitution).between(BALL, partner)
    assert contact.restitution() == pytest.approx(restitution, rel=1e-13, abs=0.0)
    assert (contact.restitution(SPEEDS) == contact.restitution()).all()


@draws(100)
@given(st.floats(-300.0, 0.0).map(lambda e: 10.0**e))
def test_linear_round_trip_anywhere(restitution):
    contact = hl.LinearDashpot(stiffness=5e7, restitution=restitution).between(BALL)
    # Below 1e-30 the error is that of one rounding in the exponent −ln ε.
    tolerance = max(1e-13, -4e-16 * math.log(restitution))
    assert contact.restitution() == pytest.approx(restitution, rel=tolerance, abs=0.0)


def test_linear_named_values():
    """β = ω0/√2 gives e^{−π/2}, β = ω0 gives e^{−2}, β ≫ ω0 gives (ω0/2β)²; the elastic duration is π/ω0."""
    frequency = math.sqrt(5e7 / BALL.mass)

    def at(ratio):
        return hl.LinearDashpot(stiffness=5e7, damping=2.0 * ratio * frequency * BALL.mass).between(BALL)

    assert at(math.sqrt(0.5)).restitution() == pytest.approx(math.exp(-math.pi / 2.0), rel=1e-14)
    assert at(1.0).restitution() == pytest.approx(math.exp(-2.0), rel=1e-14)
    assert at(1.0).duration() == pytest.approx(2.0 / frequency, rel=1e-14)
    assert at(1e6).restitution() == pytest.approx((0.5e-6) ** 2, rel=1e-10)
    assert at(0.0).duration() == pytest.approx(math.pi / frequency, rel=1e-14)
    assert at(0.0).restitution() == 1.0


def test_the_usual_formula_gives_another_restitution():
    """ζ = −ln ε/√(π² + ln² ε) assumes that the contact ends at ξ = 0, after an attractive force."""
    log = np.log([0.9, 0.7, 0.5, 0.3, 0.1])
    restitution = _core.linear_restitution(-log / np.hypot(np.pi, log))
    assert restitution == pytest.approx([0.9020, 0.7182, 0.5503, 0.3971, 0.2527], abs=5e-5)


# ---- viscoelastic spheres ----------------------------------------------------------------------------------


def universal(x: float) -> tuple[float, float]:
    """ε and duration of X'' + X^{3/2} + x √X X' = 0 by SciPy, in X = s², dt = s dτ, where it is smooth."""

    def right(_, y):
        s, v, _ = y
        return [0.5 * v, -(s**4) - x * s * s * v, s]

    def end(_, y):
        return y[0] ** 2 + x * y[1] if y[1] < 0.0 or y[0] > 0.0 else 1.0

    end.terminal, end.direction = True, -1
    solution = scipy.integrate.solve_ivp(
        right, (0.0, 1e3), [0.0, 1.0, 0.0], "DOP853", events=end, rtol=3e-14, atol=1e-18, max_step=0.2
    )
    s, v, t = solution.y_events[0][0]
    assert s > 0.0
    return -v, t


def test_viscoelastic_table():
    for row in table("restitution_viscoelastic"):
        x = np.array([float(row["x"])])
        assert _core.viscoelastic_restitution(x) == pytest.approx(
            float(row["restitution"]), rel=1e-12, abs=0.0
        )
        assert _core.viscoelastic_duration(x) == pytest.approx(
            float(row["duration_scaled"]), rel=1e-12, abs=0.0
        )


@pytest.mark.parametrize("x", [1e-3, 0.02, 0.1, 0.3, 0.62, 0.999, 1.001, 1.7, 3.0, 8.0, 20.0])
def test_viscoelastic_collision_by_an_independent_integration(x):
    restitution, duration = universal(x)
    assert _core.viscoelastic_restitution(np.array([x]))[0] == pytest.approx(restitution, rel=2e-12, abs=0.0)
    assert _core.viscoelastic_duration(np.array([x]))[0] == pytest.approx(duration, rel=2e-12, abs=0.0)


def test_viscoelastic_limits():
    """Elastic duration 3.218065459719, the Hertz integral; ε → (3/2)^{2/3} x^{−5/3} for large x."""
    assert _core.viscoelastic_duration(np.zeros(1))[0] == pytest.approx(3.218065459719, rel=1e-12)
    with mpmath.workdps(30):  # t_c = 2 X_max ∫ dz/√(1 − z^{5/2}), X_max = (5/4)^{2/5}
        integral = mpmath.mpf(2) / 5 * mpmath.beta(mpmath.mpf(2) / 5, mpmath.mpf(1) / 2)
        hertz = float(2 * (mpmath.mpf(5) / 4) ** (mpmath.mpf(2) / 5) * integral)
    assert _core.viscoelastic_duration(np.zeros(1))[0] == pytest.approx(hertz, rel=1e-14)
    assert _core.viscoelastic_restitution(np.zeros(1))[0] == 1.0
    x = np.array([1e2, 1e3, 1e4, 1e5, 1e6, 1e7])
    deviation = 1.0 - _core.viscoelastic_restitution(x) / (1.5 ** (2.0 / 3.0) * x ** (-5.0 / 3.0))
    # The next term has the relative order x^{−5/3} ln x.
    assert (deviation > 0.0).all()
    assert (deviation < 3.0 * x ** (-5.0 / 3.0) * np.log(x) ** 1.0).all()
    far = np.array([1e10, 1e30, 1e100])
    assert _core.viscoelastic_restitution(far) == pytest.approx(
        1.5 ** (2.0 / 3.0) * far ** (-5.0 / 3.0), rel=1e-13
    )


SERIES = {2: -1.153448858095289, 4: 0.798266560944795, 5: 4.0 / 15.0, 6: -0.522882568088415,
          7: -0.461379543238116, 8: 0.348742675260386, 9: 0.45235105120205}  # fmt: skip


@pytest.mark.parametrize(
    ("k", "tolerance"),
    [(2, 1e-7), (3, 1e-7), (4, 1e-7), (5, 1e-7), (6, 1e-6), (7, 1e-5), (8, 1e-4), (9, 1e-3)],
)
def test_coefficients_of_the_series_follow_from_small_arguments(k, tolerance):
    """h_k of ε = Σ h_k x^{k/2} (B3) follows from ε near x = 0 minus the lower-order terms."""
    y = 0.10 + 0.25 * (1.0 - np.cos(np.pi * (np.arange(12) + 0.5) / 12)) / 2.0
    rest = _core.viscoelastic_restitution(y * y) - 1.0
    for j, h in SERIES.items():
        if j < k:
            rest = rest - h * y**j
    fit = np.polynomial.Polynomial.fit(y, rest / y**k, 9)
    assert fit(0.0) == pytest.approx(SERIES.get(k, 0.0), abs=tolerance)


def test_series_beside_the_exact_function():
    """Accurate below x = 0.1, useless above 0.6: there more terms increase the error, and ε leaves (0, 1]."""
    x = np.array([0.01, 0.1, 1.0, 2.0])
    exact = _core.viscoelastic_restitution(x)
    deviation = np.abs(hl.restitution_series(x) - exact)
    assert deviation[0] < 1e-9
    assert deviation[1] < 3e-6
    assert deviation[2] > 0.3
    shorter = np.abs(hl.restitution_series(x, 7) - exact)
    assert shorter[0] > deviation[0] and shorter[2] < deviation[2]
    assert not 0.0 < hl.restitution_series(2.0) <= 1.0


def test_terms_of_the_series():
    y = 0.7
    for terms in range(1, 11):
        wanted = 1.0 + sum(h * y**k for k, h in SERIES.items() if k < terms)
        assert hl.restitution_series(y * y, terms) == pytest.approx(wanted, rel=1e-14)


@pytest.mark.parametrize(("orders", "least", "most"), [((1, 4), 8.5e-3, 9e-3), ((3, 6), 6.6e-4, 7e-4)])
def test_pade_forms_err_as_published(orders, least, most):
    x = np.logspace(-3, 3, 2000)
    deviation = np.abs(hl.restitution_pade(x, *orders) - _core.viscoelastic_restitution(x))
    assert least < deviation.max() < most
    small = np.array([1e-3])  # p + q + 1 terms of the series are reproduced
    assert hl.restitution_pade(small, *orders) == pytest.approx(hl.restitution_series(small), abs=1e-8)


@pytest.mark.parametrize("restitution", [*RESTITUTIONS, 1e-30, 1e-100])
@pytest.mark.parametrize("partner", [hl.FLOOR, SMALL, hl.Ball(1e-6, density=1e3), hl.Ball(50.0, density=1e4)])
@pytest.mark.parametrize("speed", [1e-6, 3.0])
def test_viscoelastic_round_trip(restitution, partner, speed):
    for modulus in (1e-3, 5e7, 1e15):
        law = hl.Viscoelastic(
            youngs_modulus=modulus, poisson_ratio=0.45, restitution=restitution, impact_speed=speed
        )
        contact = law.between(BALL, partner)
        assert contact.restitution(speed) == pytest.approx(restitution, rel=1e-11, abs=0.0)


@pytest.mark.parametrize("loss", [1e-15, 1e-12, 1e-8, 1e-4, 0.1])
def test_viscoelastic_inverse_keeps_the_digits_of_a_small_loss(loss):
    """1 − ε = −h_2 x − h_4 x² − …, so A of a nearly elastic contact is accurate to all digits."""
    restitution = 1.0 - loss
    law = hl.Viscoelastic(youngs_modulus=1e9, poisson_ratio=0.3, restitution=restitution, impact_speed=2.0)
    contact = law.between(BALL)
    x = 1.5 * contact.dissipative_time * (contact.elastic_prefactor / BALL.mass) ** 0.4 * 2.0**0.2
    series = -sum(h * x ** (k / 2.0) for k, h in SERIES.items())
    assert series == pytest.approx(1.0 - restitution, rel=1e-12 + 50.0 * x**4)


def test_viscoelastic_depends_on_speed_through_one_number():
    law = hl.Viscoelastic(youngs_modulus=1e9, poisson_ratio=0.3, dissipative_time=1e-5)
    contact = law.between(BALL, SMALL)
    k = contact.elastic_prefactor / contact.effective_mass
    for v in SPEEDS:
        x = np.array([1.5e-5 * k**0.4 * v**0.2])
        assert contact.restitution(v) == pytest.approx(_core.viscoelastic_restitution(x)[0], rel=1e-13)
        duration = _core.viscoelastic_duration(x)[0] / (k**0.4 * v**0.2)
        assert contact.duration(v) == pytest.approx(duration, rel=1e-13)


def test_viscoelastic_prefactor():
    """ρ = 2Y√R_eff/(3(1 − ν²)), R_eff = R_i R_j/(R_i + R_j), or R_i at the floor."""
    law = hl.Viscoelastic(youngs_modulus=2e9, poisson_ratio=0.25, dissipative_time=0.0)
    floor, pair = law.between(BALL), law.between(BALL, SMALL)
    assert floor.effective_radius == 0.1
    assert floor.effective_mass == BALL.mass
    assert pair.effective_radius == pytest.approx(0.1 * 0.01 / 0.11, rel=1e-15)
    assert pair.effective_mass == pytest.approx(BALL.mass * SMALL.mass / (BALL.mass + SMALL.mass), rel=1e-15)
    for contact in (floor, pair):
        wanted = 2.0 * 2e9 * math.sqrt(contact.effective_radius) / (3.0 * (1.0 - 0.0625))
        assert contact.elastic_prefactor == pytest.approx(wanted, rel=1e-15)


# ---- Tsuji's law -------------------------------------------------------------------------------------------


def tsuji_collision(alpha: float, digits: int = 30) -> tuple[mpmath.mpf, mpmath.mpf]:
    """ε and duration for k = m = V = 1, from the equation of motion by Taylor series in 30-digit arithmetic.

    With ξ = s⁴ and dt = 4 s³ dσ it is polynomial: ds/dσ = v, dv/dσ = −4 s⁴ (s⁵ + α v); the force ends at s⁵ + α v = 0.
    The mapping to the linear dashpot is not used.
    """
    order = 40

    def product(a, b, k):
        return mpmath.fdot((a[i], b[k - i]) for i in range(k + 1))

    def expand(s, v):
        s, v, t = [s], [v], [mpmath.mpf(0)]
        s2, s4, w = [], [], []
        for k in range(order):
            s2.append(product(s, s, k))
            s4.append(product(s2, s2, k))
            w.append(product(s4, s, k) + alpha * v[k])
            s.append(v[k] / (k + 1))
            v.append(-4 * product(s4, w, k) / (k + 1))
            t.append(4 * product(s2, s, k) / (k + 1))
        return s, v, t

    def at(series, x):
        return functools.reduce(lambda total, c: total * x + c, reversed(series))

    with mpmath.workdps(digits + 5):
        alpha = mpmath.mpf(alpha)
        s, v, t, step = mpmath.mpf(0), mpmath.mpf(1), mpmath.mpf(0), mpmath.mpf(1) / 16
        while True:
            a, b, c = expand(s, v)

            def end(x, a=a, b=b):
                # Written to have a simple zero: s itself without damping.
                return at(a, x) ** 5 + alpha * at(b, x) if alpha > 0 else at(a, x)

            if end(step) <= 0 and at(b, step) < 0:
                x = mpmath.findroot(end, (step / 4, 3 * step / 4))
                return -at(b, x), t + at(c, x)
            s, v, t = at(a, step), at(b, step), t + at(c, step)


@pytest.mark.parametrize(
    "alpha", [0.0, slow(1e-3), slow(0.1), 0.5, slow(1.0), slow(2.0), slow(math.sqrt(5.0)), slow(3.0), 6.0]
)
def test_tsuji_collision_in_high_precision(alpha):
    restitution, duration = tsuji_collision(alpha)
    for mass, k, speed in ((1.0, 1.0, 1.0), (3e-4, 7.3e9, 0.02), (12.0, 2e6, 90.0)):
        law = hl.Tsuji(elastic_prefactor=k, damping_coefficient=alpha)
        contact = law.between(hl.Ball(0.1, mass=mass))
        unit = (mass / k) ** 0.4 * speed**-0.2
        assert abs(contact.restitution(speed) / restitution - 1) < 1e-15
        assert abs(contact.duration(speed) / (duration * unit) - 1) < 3e-15


@pytest.mark.slow
def test_tsuji_duration_over_all_damping():
    """From nearly elastic to overdamped, by adaptive quadrature of the linear solution."""
    for ratio in (1e-12, 1e-8, 1e-4, 0.3, 0.999, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 1.001, 4.0, 1e3, 1e6):
        contact = hl.Tsuji(elastic_prefactor=1.0, damping_coefficient=math.sqrt(5.0) * ratio).between(
            hl.Ball(1.0, mass=1.0)
        )
        with mpmath.workdps(40):
            b = mpmath.mpf(contact.damping_coefficient) / mpmath.sqrt(5)
            w = mpmath.sqrt(mpmath.mpc(1 - b * b))
            end = (2 * mpmath.acos(b) / w if b != 1 else mpmath.mpc(2)).real

            def compression(x, b=b, w=w):
                wave = mpmath.sin(w * x) / w if w != 0 else x
                return mpmath.exp(-b * x) * mpmath.re(wave)

            low = [end * mpmath.mpf(10) ** -n for n in (12, 9, 6, 4, 3, 2, 1)]
            points = [0, *low, end / 2, *(end - x for x in reversed(low)), end]
            integral = mpmath.quad(lambda x: compression(x) ** (-mpmath.mpf(1) / 5), points)
            frequency = mpmath.sqrt(mpmath.mpf(4) / 5)
            wanted = mpmath.mpf(4) / 5 / frequency * frequency ** (mpmath.mpf(1) / 5) * integral
            assert abs(contact.duration() / wanted - 1) < 2e-14, ratio


@pytest.mark.parametrize("restitution", [*RESTITUTIONS, 1e-30, 1e-100])
@pytest.mark.parametrize("partner", [hl.FLOOR, SMALL, hl.Ball(1e-6, density=1e3), hl.Ball(50.0, density=1e4)])
def test_tsuji_round_trip(restitution, partner):
    """The given ε results for any bodies and speed, and α = √5 β/ω0 of the linear dashpot with the same ε."""
    linear = hl.LinearDashpot(stiffness=1e6, restitution=restitution).between(BALL)
    ratio = linear.damping / (2.0 * math.sqrt(1e6 * linear.effective_mass))
    for law in (
        hl.Tsuji(elastic_prefactor=1e9, restitution=restitution),
        hl.Tsuji(youngs_modulus=1e7, poisson_ratio=0.4, restitution=restitution),
    ):
        contact = law.between(BALL, partner)
        assert contact.restitution() == pytest.approx(restitution, rel=1e-12, abs=0.0)
        assert (contact.restitution(SPEEDS) == contact.restitution()).all()
        assert contact.damping_coefficient == pytest.approx(math.sqrt(5.0) * ratio, rel=1e-14, abs=0.0)


def test_tsuji_of_a_material_is_hertz_when_undamped():
    """The same stiffness and the same collision as viscoelastic spheres with A = 0; k may be given instead."""
    material = {"youngs_modulus": 2e9, "poisson_ratio": 0.25}
    for other in (hl.FLOOR, SMALL):
        hertz = hl.Viscoelastic(**material, dissipative_time=0.0).between(BALL, other)
        tsuji = hl.Tsuji(**material, damping_coefficient=0.0).between(BALL, other)
        assert tsuji.elastic_prefactor == hertz.elastic_prefactor
        undamped = hl.Tsuji(elastic_prefactor=tsuji.elastic_prefactor, damping_coefficient=0.0)
        xi = np.logspace(-9, -3, 7)
        for contact in (tsuji, undamped.between(BALL, other)):
            assert contact.force(xi, 1.0) == pytest.approx(hertz.force(xi, 1.0), rel=1e-14)
            assert contact.energy(xi) == pytest.approx(hertz.energy(xi), rel=1e-14)
            assert contact.duration(SPEEDS) == pytest.approx(hertz.duration(SPEEDS), rel=1e-14)


def test_tsuji_force():
    """F = k ξ^{3/2} + α√(m_eff k) ξ^{1/4} ξ̇, cut off below zero."""
    contact = hl.Tsuji(elastic_prefactor=3e8, damping_coefficient=0.4).between(BALL, SMALL)
    xi = np.logspace(-8, -3, 11)[:, None]
    rate = np.linspace(-2.0, 2.0, 9)
    damping = 0.4 * math.sqrt(contact.effective_mass * 3e8)
    wanted = np.maximum(0.0, 3e8 * xi**1.5 + damping * xi**0.25 * rate)
    assert contact.force(xi, rate) == pytest.approx(wanted, rel=1e-12, abs=1e-12)


# ---- published approximations ------------------------------------------------------------------------------


def test_approximations_are_public():
    """Results have the shape of the argument, and the limits are exact."""
    x = np.array([[0.01, 0.1, 1.0]])
    assert hl.restitution_series(0.49, 5) == pytest.approx(1.0 + SERIES[2] * 0.49 + SERIES[4] * 0.49**2)
    assert hl.restitution_series(x).shape == hl.restitution_pade(x, 1, 4).shape == x.shape
    assert hl.restitution_series(0.0) == hl.restitution_pade(0.0) == 1.0
    damping = hl.usual_damping(0.5, 1e6, 0.1)
    law = hl.LinearDashpot(stiffness=1e6, damping=damping)
    assert law.between(hl.Ball(0.1, mass=0.1)).restitution() == pytest.approx(0.5503, abs=5e-5)
    assert hl.usual_damping(1.0, 1e6, 0.1) == 0.0


# ---- every registered law ----------------------------------------------------------------------------------

every_law = pytest.mark.parametrize("name", sorted(hl.LAWS))


def contacts_of(name: str) -> list[hl.Contact]:
    return [law_of(name, e).between(BALL, b) for e in (1.0, 0.9, 0.5, 0.05) for b in (hl.FLOOR, SMALL)]


def impact_depth(contact: hl.Contact, speed: float = 1.0) -> float:
    """Estimate of the largest compression in an impact."""
    return speed * contact.duration(speed) / 3.0


@every_law
def test_force_is_the_derivative_of_the_energy_when_undamped(name):
    contact = law_of(name, 1.0).between(BALL, SMALL)
    depth = impact_depth(contact) * np.array([1e-3, 0.1, 0.5, 1.0, 3.0])

    def slope(h):
        return (contact.energy(depth * (1 + h)) - contact.energy(depth * (1 - h))) / (2 * h * depth)

    extrapolated = (16 * (4 * slope(1e-3) - slope(2e-3)) - (4 * slope(2e-3) - slope(4e-3))) / 45
    assert contact.force(depth) == pytest.approx(extrapolated, rel=1e-10)
    # At any rate: the law has no damping.
    assert (contact.force(depth, -1.0) == contact.force(depth, 1.0)).all()
    assert contact.energy(0.0) == 0.0 == contact.energy(-1.0)


@every_law
def test_force_has_the_powers_of_the_record(name):
    """K ξ^p + C ξ^q dξ/dt at small compressions, and at all of them if the law states K and C."""
    p, q = (0.25 * power for power in hl.LAWS[name].record["powers"])
    for contact in contacts_of(name):
        xi = impact_depth(contact) * np.array([1e-9, 1e-8, 1e-3, 0.1, 1.0, 10.0])
        elastic = contact.force(xi)
        damping = contact.force(xi, 1.0) - elastic
        assert np.log10(elastic[1] / elastic[0]) == pytest.approx(p, abs=1e-6)
        assert damping[0] == 0.0 or np.log10(damping[1] / damping[0]) == pytest.approx(q, abs=1e-6)
        assert hl.LAWS[name].record["power_law"] == (contact.core.coefficients is not None)
        if contact.core.coefficients is not None:
            k, c = contact.core.coefficients
            assert contact.force(xi, 0.7) == pytest.approx(k * xi**p + c * xi**q * 0.7, rel=1e-12)


@every_law
def test_never_attractive_and_nothing_without_compression(name):
    for contact in contacts_of(name):
        xi = impact_depth(contact) * np.array([-1.0, 0.0, 1e-9, 1e-3, 1.0, 10.0])[:, None]
        force = contact.force(xi, np.linspace(-5.0, 5.0, 41))
        assert (force >= 0.0).all()
        assert (force[:2] == 0.0).all()
        assert (force[4:, 20:] > 0.0).all()


@every_law
def test_passive(name):
    """The force minus its elastic part does negative work: the law dissipates energy and never supplies it."""
    for contact in contacts_of(name):
        xi = impact_depth(contact) * np.array([1e-6, 1e-2, 0.3, 1.0])[:, None]
        rate = np.linspace(-5.0, 5.0, 41)
        assert ((contact.force(xi, rate) - contact.force(xi)) * rate >= 0.0).all()


@every_law
def test_restitution_in_range_and_falling_with_damping(name):
    damping = damping_name(name)
    for other in (hl.FLOOR, SMALL):
        reference = getattr(law_of(name, 0.5).between(BALL, other), damping)
        previous = None
        for factor in [0.0, 1e-6, 1e-3, 0.1, 0.5, 1.0, 2.0, 10.0, 1e3]:
            restitution = damped(name, factor * reference).between(BALL, other).restitution(SPEEDS)
            assert ((restitution > 0.0) & (restitution <= 1.0)).all()
            assert ((restitution == 1.0) == (factor == 0.0)).all()
            assert previous is None or (restitution < previous).all()
            previous = restitution


@every_law
def test_duration_is_positive_and_finite(name):
    for contact in contacts_of(name):
        duration = contact.duration(SPEEDS)
        assert (duration > 0.0).all() and np.isfinite(duration).all()


@every_law
def test_given_restitution_is_obtained_by_every_pair(name):
    for restitution in RESTITUTIONS:
        for other in (hl.FLOOR, SMALL, BALL):
            contact = law_of(name, restitution, speed=2.0).between(BALL, other)
            assert contact.restitution(2.0) == pytest.approx(restitution, rel=1e-11, abs=0.0)


@every_law
def test_isolated_collision_by_an_independent_integration(name):
    """Duration and restitution are those of m ξ̈ = −F(ξ, ξ̇), integrated to F = 0."""
    for restitution in (1.0, 0.8, 0.4, 0.1):
        contact = law_of(name, restitution).between(BALL, SMALL)
        m, t_c = contact.effective_mass, contact.duration(1.0)

        def right(_, y, contact=contact, m=m):
            return [y[1], -contact.force(y[0], y[1]) / m]

        # The force is smooth until just before the end; the integration stops a millionth of t_c earlier.
        within = {"rtol": 1e-12, "atol": 1e-16, "max_step": t_c / 200}
        solution = scipy.integrate.solve_ivp(
            right, (0.0, t_c * (1.0 - 1e-6)), [1e-300, 1.0], "DOP853", **within
        )
        xi, rate = solution.y[:, -1]
        assert -rate == pytest.approx(restitution, rel=2e-6)
        largest = np.max(contact.force(solution.y[0], solution.y[1]))
        assert 0.0 < contact.force(xi, rate) < 1e-4 * largest


@every_law
def test_scaling_with_the_units(name):
    """In other units of mass, length and time, restitution, durations and forces are the same."""
    mass, length, time = 3.7, 0.021, 190.0
    record = hl.LAWS[name].record

    def converted(parameters):
        units = {p["name"]: p["unit"] for group in (record["common"], *record["alternatives"]) for p in group}
        powers = {k: dimension(units[k]) for k in parameters}
        return {k: v * math.prod(np.power((mass, length, time), powers[k])) for k, v in parameters.items()}

    for restitution in (1.0, 0.7, 0.1):
        law = law_of(name, restitution, speed=1.3)
        balls = BALL, SMALL
        contact = law.between(*balls)
        scaled_balls = [hl.Ball(b.radius * length, mass=b.mass * mass) for b in balls]
        scaled = hl.LAWS[name](**converted(law.parameters)).between(*scaled_balls)
        v = 0.4
        u = v * length / time
        assert scaled.restitution(u) == pytest.approx(contact.restitution(v), rel=1e-12)
        assert scaled.duration(u) == pytest.approx(contact.duration(v) * time, rel=1e-12)
        xi = impact_depth(contact)
        newton = mass * length / time**2
        assert scaled.force(xi * length, u) == pytest.approx(contact.force(xi, v) * newton, rel=1e-12)
        assert scaled.energy(xi * length) == pytest.approx(contact.energy(xi) * newton * length, rel=1e-12)


# ---- bad input ---------------------------------------------------------------------------------------------


def refused(call, *words: str) -> None:
    """The message names the parameter, the value and the accepted range."""
    message = refusal(call)
    assert all(word in message for word in words), message


@every_law
def test_each_parameter_of_a_law_is_checked(name):
    law = hl.LAWS[name]
    for choice in law.record["alternatives"]:
        good = {p["name"]: typical(p) for p in [*law.record["common"], *choice]}
        law(**good)
        for p in [*law.record["common"], *choice]:
            bad = [math.nan, math.inf, -math.inf, "stiff", True]
            bad += [p["lowest"] - 1.0] + ([] if p["lowest_allowed"] else [p["lowest"]])
            if math.isfinite(p["highest"]):
                bad += [p["highest"] + 1.0] + ([] if p["highest_allowed"] else [p["highest"]])
            for value in bad:
                shown = repr(value) if isinstance(value, str | bool) else f"{value:.16g}"
                call = partial(law, **(good | {p["name"]: value}))
                refused(call, p["name"], shown, "must be")
            for value, allowed in ((p["lowest"], p["lowest_allowed"]), (p["highest"], p["highest_allowed"])):
                if allowed:
                    assert law(**(good | {p["name"]: value})).parameters[p["name"]] == value


@every_law
def test_exactly_one_alternative(name):
    law = hl.LAWS[name]
    common = {p["name"]: typical(p) for p in law.record["common"]}
    choices = [{p["name"]: typical(p) for p in choice} for choice in law.record["alternatives"]]
    every = {k: v for choice in choices for k, v in choice.items()}
    refused(lambda: law(**common), "restitution", damping_name(name), "got n", " or ")
    refused(lambda: law(**common, **every), "restitution", damping_name(name), " or ")
    for choice in choices:
        assert law(**common, **choice).parameters == common | choice
        refused(lambda choice=choice: law(**common, **choice, colour=1.0), "colour", "unknown")
        for missing in common:
            rest = {k: v for k, v in common.items() if k != missing}
            refused(lambda rest=rest, choice=choice: law(**rest, **choice), missing, "missing", "must be")


@every_law
def test_replace_selects_the_alternative(name):
    """A parameter of another alternative selects it: parameters not part of it are dropped, common ones kept."""
    record = hl.LAWS[name].record
    known = law_of(name, 0.5).replace(restitution=0.25)
    assert known.restitution == 0.25 and known.replace(restitution=0.5) == law_of(name, 0.5)
    law = known.replace(**{damping_name(name): 0.1})
    assert set(law.parameters) == {p["name"] for p in alternative(name, restitution=False)}
    shared = set(law.parameters) & set(known.parameters)
    assert all(law.parameters[k] == known.parameters[k] for k in shared)
    refused(lambda: law.replace(colour=1.0), "colour", "unknown")
    for choice in record["alternatives"]:
        wanted = {p["name"]: typical(p) for p in choice}
        assert known.replace(**wanted).parameters.items() >= wanted.items()


def test_restitution_given_at_a_speed_needs_both():
    refused(
        lambda: hl.Viscoelastic(youngs_modulus=1e9, poisson_ratio=0.3, restitution=0.5),
        "restitution + impact_speed",
    )


def contact():
    return law_of("linear", 0.5).between(BALL)


BAD = {
    "negative x": (lambda: hl.restitution_series(-1.0), ("x", "-1", "[0, 1e+60]")),
    "a power of x that overflows": (lambda: hl.restitution_series(1e68), ("x", "e+6", "[0, 1e+60]")),
    "text for x": (lambda: hl.restitution_pade("0.1"), ("x", "'0.1'", "number")),
    "no terms": (lambda: hl.restitution_series(0.1, 0), ("terms", "0", "[1, 10]")),
    "too many terms": (lambda: hl.restitution_series(0.1, 11), ("terms", "11", "[1, 10]")),
    "half a term": (lambda: hl.restitution_series(0.1, 2.5), ("terms", "2.5", "whole")),
    "too high a degree": (lambda: hl.restitution_pade(0.1, 5, 5), ("denominator", "5", "[0, 4]")),
    "negative degree": (lambda: hl.restitution_pade(0.1, -1, 2), ("numerator", "-1", "[0, 9]")),
    "no restitution": (lambda: hl.usual_damping(0.0, 1e6, 0.1), ("restitution", "0", "(0, 1]")),
    "no stiffness": (lambda: hl.usual_damping(0.5, 0.0, 0.1), ("stiffness", "0", "> 0")),
    "no effective mass": (lambda: hl.usual_damping(0.5, 1e6, -1.0), ("effective_mass", "-1", "> 0")),
    "negative radius": (lambda: hl.Ball(-0.1, density=1.0), ("radius", "-0.1", "> 0")),
    "zero radius": (lambda: hl.Ball(0.0, density=1.0), ("radius", "0", "> 0")),
    "NaN radius": (lambda: hl.Ball(math.nan, density=1.0), ("radius", "nan", "> 0")),
    "text for a radius": (lambda: hl.Ball("big", density=1.0), ("radius", "'big'", "number")),
    "zero density": (lambda: hl.Ball(0.1, density=0.0), ("density", "0", "> 0")),
    "negative mass": (lambda: hl.Ball(0.1, mass=-1.0), ("mass", "-1", "> 0")),
    "infinite mass": (lambda: hl.Ball(0.1, mass=math.inf), ("mass", "inf", "finite")),
    "neither density nor mass": (lambda: hl.Ball(0.1), ("density | mass", "neither")),
    "density and mass": (lambda: hl.Ball(0.1, density=1.0, mass=1.0), ("density | mass", "both")),
    "mass beyond numbers": (lambda: hl.Ball(1e80, density=1e3), ("radius", "1e+80", "must be")),
    "no body": (lambda: law_of("linear", 0.5).between(3.0), ("ball: got 3.0", "must be a Ball")),
    "zero speed": (lambda: contact().restitution(0.0), ("speed", "0", "> 0")),
    "one negative speed": (lambda: contact().duration([1.0, -2.0]), ("speed", "-2")),
    "NaN speed": (lambda: contact().duration(math.nan), ("speed", "nan", "finite")),
    "NaN compression": (lambda: contact().force(math.nan), ("compression", "nan")),
    "infinite rate": (lambda: contact().force(0.1, math.inf), ("rate", "inf")),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_refused(case):
    call, words = BAD[case]
    refused(call, *words)


def test_shapes_follow_the_input():
    contact = law_of("viscoelastic", 0.5).between(BALL)
    assert isinstance(contact.restitution(1.0), float)
    assert contact.restitution([[1.0, 2.0, 3.0]]).shape == (1, 3)
    assert contact.duration(np.ones((2, 2))).shape == (2, 2)
    assert contact.force(np.zeros((3, 1)), np.zeros(4)).shape == (3, 4)


# ---- laws declared linear --------------------------------------------------------------------------------------


@pytest.mark.slow
def test_laws_declared_linear_are_linear(tmp_path):
    """The registered linear laws are linear; a nonlinear law declared linear is detected."""
    printed = output_of("contact/linear_laws.cpp", tmp_path)
    departures = {name: float(value) for name, value in map(str.split, printed.splitlines())}
    assert departures.pop("liar") > 0.1
    assert "linear" in departures and max(departures.values()) < 1e-12
