"""Where a contact with friction sticks and slides, and the constant rule that stands for it in a gas."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hardlimit as hl
from conftest import draws, refusal
from hardlimit import _core
from hardlimit.contact.friction import LIMITS, FrictionTerms
from hardlimit.contact.frictional_contact import (
    ANGLES,
    borders,
    effective_restitution,
    half_period,
    in_own_units,
    table,
    tangential_restitution,
)
from hardlimit.contact.impact import FrictionalContact
from hardlimit.convert.force import Powers, damping_for


def linear(
    rho: float, restitution: float, mu: float, q: float = 0.4, damping_ratio: float = 0.0
) -> FrictionalContact:
    """A linear contact with unit stiffness and mass, ρ = k_t m_n/(k_n m_t)."""
    kappa, damping = 1.0 + 1.0 / q, damping_for(Powers(4, 0), restitution)
    terms = FrictionTerms(mu, rho / kappa, 0, damping_ratio * damping, 0)
    return FrictionalContact((4, 0, False), (1.0, damping), 1.0, 1.0 / kappa, terms)


def psi(angle: float, contact: FrictionalContact) -> float:
    return math.tan(angle) * contact.tangential_mass / contact.terms.coefficient


@pytest.mark.parametrize("rho", [1.0, 1.3, 2.0, 2.8824, 3.15, 3.5, 4.0, 6.5, 12.0])
@pytest.mark.parametrize(("mu", "q"), [(0.5, 0.4), (0.07, 2 / 3), (1.3, 0.5)])
def test_elastic_contacts_stick_and_slide_as_in_theory(rho: float, mu: float, q: float) -> None:
    """Slips first if and only if ψ > 1/ρ, throughout if and only if ψ > 2 − 1/ρ (Maw, Barber & Fawcett 1976)."""
    contact = linear(rho, 1.0, mu, q)
    sticks, slides = (psi(angle, contact) for angle in borders(contact, 1.0))
    assert sticks == pytest.approx(1.0 / rho, rel=1e-3 * rho / 4.0)
    assert slides == pytest.approx(2.0 - 1.0 / rho, rel=5e-4)


@pytest.mark.parametrize("rho", [0.1, 0.5, 0.875, 0.99])
def test_soft_tangential_springs_have_one_angle(rho: float) -> None:
    contact = linear(rho, 1.0, 0.5)
    expected = 1.0 / (math.sqrt(rho) * math.sin(0.5 * math.pi * math.sqrt(rho)))
    assert [psi(angle, contact) for angle in borders(contact, 1.0)] == pytest.approx([expected] * 2, rel=4e-4)


def surfaces(contact: FrictionalContact, tangent: float, steps: int = 20_000) -> tuple[bool, bool]:
    """Whether the surfaces slip while the bodies approach, and whether they stick while they separate.

    Steps with the return mapping of the codes, shorter at touch and at the end, in units in which K, the mass and the
    speed are 1.
    """
    own = in_own_units(contact, 1.0)
    terms = own.terms
    p, q, total = 0.25 * own.powers[0], 0.25 * own.powers[1], LIMITS[terms.limit] == "total"
    x, v, g, spring, before = 0.0, 1.0, tangent, 0.0, 0.0
    slips = sticks = False
    negligible = 0.01 * _core.power_collision(*own.powers, own.coefficients[1])[3]
    while True:
        dt = 10.0 / steps * min(1.0, 1e-3 + 10.0 * x)
        x += dt * v
        force = x**p + own.coefficients[1] * x**q * v if x > 0.0 else 0.0
        if force <= 0.0:
            return slips, sticks
        m = terms.loading if x > before else terms.unloading
        spring = spring * (x / before) ** (0.5 * m) if before else 0.0
        spring += terms.stiffness * x ** (0.25 * terms.stiffness_power) * g * dt
        damped = terms.damping * x ** (0.25 * terms.damping_power) * g
        limit, limited = terms.coefficient * force, spring + damped if total else spring
        if abs(limited) > limit:
            slips = slips or v > 0.0
            spring = math.copysign(limit, limited) - (damped if total else 0.0)
            pull = math.copysign(limit, limited)
        else:
            sticks = sticks or (v < 0.0 and force > negligible)
            pull = spring + damped
        g -= pull * dt / own.tangential_mass
        v -= force * dt
        before = x


def drawn(seed: int) -> FrictionalContact:
    """A damped contact, linear or Hertzian, with any model of the tangential force."""
    rng = np.random.default_rng(seed)
    powers = [(4, 0), (6, 1), (6, 2)][rng.integers(3)]
    hertz = powers[0] == 6
    name = ["mindlin", "mindlin_force", "mindlin_rescale", "mindlin_rescale_force"][rng.integers(4)]
    damping = damping_for(Powers(*powers), rng.uniform(0.4, 0.99))
    terms = FrictionTerms.of_model(
        name if hertz else "spring",
        LIMITS[rng.integers(2)],
        coefficient=10 ** rng.uniform(-1.5, 0.3),
        stiffness=rng.uniform(0.15, 1.3),
        stiffness_power=2 if hertz else 0,
        damping=rng.choice([0.0, 0.3, 1.0]) * damping,
        damping_power=powers[1],
    )
    return FrictionalContact((*powers, False), (1.0, damping), 1.0, rng.uniform(0.2, 0.5), terms)


@draws(150, 8, deadline=None)
@given(st.integers(0, 2**31))
def test_angles_separate_sticking_and_sliding_contacts(seed: int) -> None:
    contact = drawn(seed)
    sticks, slides = (math.tan(angle) for angle in borders(contact, 1.0))
    if sticks > 0.0:
        assert not surfaces(contact, 0.98 * sticks)[0]
    assert surfaces(contact, 1.02 * max(sticks, 1e-3))[0]
    if slides < 1e6:
        assert not surfaces(contact, 1.05 * slides)[1]
        assert slides < 1.1 * sticks or surfaces(contact, 0.9 * slides)[1]


# From theory, in which β0 and ε fix the energy that a collision dissipates; to the digits shown, the first row by an
# independent quadrature of 20,000 points.
EFFECTIVE = {
    (0.9, 0.5): {1.0: 0.959, 2.8824: 0.380, 3.15: 0.327, 3.5: 0.268},
    (0.9, 0.1): {1.0: 0.839, 2.8824: 0.379, 3.15: 0.340, 3.5: 0.298},
    (0.7, 0.5): {1.0: 0.687, 2.8824: 0.408, 3.15: 0.355, 3.5: 0.296},
}


@pytest.mark.parametrize(("restitution", "mu"), EFFECTIVE)
def test_effective_restitution(restitution: float, mu: float) -> None:
    for rho, expected in EFFECTIVE[restitution, mu].items():
        assert effective_restitution(linear(rho, restitution, mu), 1.0, 3) == pytest.approx(
            expected, abs=6e-4
        )


@pytest.mark.parametrize(("dimension", "q"), [(3, 0.4), (3, 2 / 3), (2, 0.5)])
@pytest.mark.parametrize("mu", [0.05, 0.6])
def test_the_rule_exchanges_what_the_contact_does(dimension: int, q: float, mu: float) -> None:
    """The mean of (1 + β) g_t² over random velocities of equipartition is that of the constant rule."""
    contact = linear(2.5, 0.85, mu, q)
    kappa, n = 1.0 / contact.tangential_mass, 4_000
    # g_n² is exponential by the flux; g_t²/κ as well in three dimensions, and χ² with one degree of freedom in two.
    share = (np.arange(n) + 0.5) / n
    u = share ** (0.5 if dimension == 3 else 2.0 / 3.0)  # with the density of g_t² u
    tangent = np.sqrt(kappa * u / (1.0 - u))
    beta = tangential_restitution(contact, 1.0, np.arctan(tangent))
    beta0 = effective_restitution(contact, 1.0, dimension)
    rule = np.minimum(beta0, -1.0 + kappa * mu * 1.85 / tangent)
    assert beta.mean() == pytest.approx(rule.mean(), abs=1e-4)


@pytest.mark.parametrize("mu", [0.03, 0.5, 4.0, math.inf])
@pytest.mark.parametrize("dimension", [2, 3])
def test_the_superball_is_the_rule(mu: float, dimension: int) -> None:
    """ρ = 1 without damping: exactly β0 = 1 for every μ."""
    assert effective_restitution(linear(1.0, 1.0, mu), 1.0, dimension) == pytest.approx(1.0, abs=1e-3)


def test_units_do_not_matter() -> None:
    """Nor does the speed of a linear contact."""
    here = linear(2.2, 0.8, 0.4, damping_ratio=0.5)
    m, k = 3e-7, 5e4
    terms = here.terms._replace(
        stiffness=here.terms.stiffness * k, damping=here.terms.damping * math.sqrt(k * m)
    )
    there = FrictionalContact(
        (4, 0, False), (k, here.coefficients[1] * math.sqrt(k * m)), m, here.tangential_mass * m, terms
    )
    assert borders(there, 0.03) == pytest.approx(borders(here, 1.0), rel=1e-6)
    assert effective_restitution(there, 0.03, 3) == pytest.approx(
        effective_restitution(here, 1.0, 3), rel=1e-6
    )
    assert half_period(there, 0.03) == pytest.approx(half_period(here, 7.0), rel=1e-9)
    assert dict(table(there, 0.03)) == pytest.approx(dict(table(here, 1.0)), rel=1e-6)


def test_half_period_and_table() -> None:
    contact = linear(3.15, 1.0, 0.5)
    assert half_period(contact, 1.0) == pytest.approx(1.0 / math.sqrt(3.15), rel=1e-9)
    beta = dict(table(contact, 1.0))
    assert list(beta) == list(ANGLES)
    assert beta[0.0] == pytest.approx(-math.cos(math.pi * math.sqrt(3.15)), abs=1e-4)
    assert beta[ANGLES[12]] == pytest.approx(0.415, abs=1e-3)  # 60°, ψ = 0.99


def contact_with(friction: hl.Friction | None, **law: float) -> hl.contact.contact.Contact:
    return hl.LinearDashpot(**({"stiffness": 1e6, "restitution": 0.9} | law), friction=friction).between(
        hl.Ball(0.01, density=2500.0), hl.Ball(0.004, density=900.0)
    )


def test_a_contact_says_where_it_sticks() -> None:
    contact = contact_with(hl.Friction(0.5, stiffness_ratio=0.9), restitution=1.0)
    assert math.tan(contact.sticks_below()) == pytest.approx(0.5 / 0.9, rel=1e-3)
    assert math.tan(contact.slides_beyond(0.1)) == pytest.approx(1.75 * (2.0 - 1.0 / 3.15), rel=1e-3)
    assert contact.effective_tangential_restitution(dimension=2) == pytest.approx(
        effective_restitution(linear(3.15, 1.0, 0.5), 1.0, 2), rel=1e-6
    )


def test_special_contacts() -> None:
    never = contact_with(hl.Friction(math.inf))
    assert never.sticks_below() == never.slides_beyond() == 0.5 * math.pi
    together = hl.LinearDashpot(stiffness=1.0, damping=1e6, friction=hl.Friction(0.5)).between(
        hl.Ball(0.01, density=1.0)
    )
    assert math.isnan(together.sticks_below()) and math.isnan(together.effective_tangential_restitution())
    springless = contact_with(hl.Friction(0.3, model="none", damping_ratio=0.5))
    assert math.isnan(springless.slides_beyond()) and springless.effective_tangential_restitution() < 0.0
    assert math.isnan(contact_with(hl.Friction(0.0)).effective_tangential_restitution())


def test_what_is_refused() -> None:
    contact = contact_with(hl.Friction(0.5))
    assert "friction: missing" in refusal(lambda: contact_with(None).sticks_below())
    assert "speed: got -1" in refusal(lambda: contact.slides_beyond(-1.0))
    assert "dimension: got 4" in refusal(lambda: contact.effective_tangential_restitution(dimension=4))


@pytest.mark.parametrize("stiffness_ratio", [1e3, 1e6, 1e12])
def test_angles_near_zero_raise_no_warning(stiffness_ratio: float) -> None:
    """Borders of sticking so close to zero that the square of their sine underflows."""
    friction = hl.Friction(1e-300, stiffness_ratio=stiffness_ratio)
    contact = hl.LinearDashpot(stiffness=1e6, restitution=0.5, friction=friction).between(
        hl.Ball(0.01, 2500.0)
    )
    with np.errstate(all="raise", under="ignore"):
        assert not contact.effective_tangential_restitution() > 1.0
