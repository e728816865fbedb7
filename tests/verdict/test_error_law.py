"""The law of the error against measured values, its limits, and random settings."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

import hardlimit as hl
from hardlimit.boxes.rules import RULES
from hardlimit.verdict import error_law as module

VISCOELASTIC = hl.Viscoelastic(youngs_modulus=1e9, poisson_ratio=0.3, restitution=0.9, impact_speed=1.0)
TSUJI = hl.LAWS["tsuji"](elastic_prefactor=1e7, restitution=0.9)


def law(packing_fraction, restitution, **given):
    return hl.error_law(packing_fraction=packing_fraction, restitution=restitution, **given)


#: φ, and a measured at ε = 0.9999 and t_c ν = 0.1 with 20,000 spheres, with its standard error.
NEARLY_ELASTIC = {0.2: (0.690, 0.006), 0.35: (0.519, 0.006), 0.5: (0.435, 0.007)}


@pytest.mark.parametrize("phi", NEARLY_ELASTIC)
def test_nearly_elastic_spheres(phi):
    value, error = NEARLY_ELASTIC[phi]
    found = law(phi, 0.9999)
    assert abs(found.coefficient - value) < 2.0 * math.hypot(error, found.coefficient_error)
    assert found.source == "theory"


@pytest.mark.parametrize("phi, value", [(0.05, -0.64), (0.2, -1.35), (0.35, -1.50), (0.5, -1.60)])
def test_rule_tc_at_one_tenth(phi, value):
    assert law(phi, 1.0, rule="tc").error(0.1) / 0.1 == pytest.approx(value, abs=0.01)


def test_exponents_of_laws():
    assert module.exponents(VISCOELASTIC) == pytest.approx((2.5, 0.5))
    assert module.exponents(TSUJI) == pytest.approx((2.5, 0.25))
    assert module.exponents(VISCOELASTIC).mean_compression == pytest.approx(0.757, abs=5e-4)
    assert module.exponents(TSUJI).mean_compression == pytest.approx(0.680, abs=5e-4)
    assert module.LINEAR.mean_compression == pytest.approx(2.0 / math.pi)


def test_a_thin_gas_depends_on_the_compression_only():
    for phi in (1e-3, 1e-5):
        found = law(phi, 1.0)
        assert found.error(1e-6) == pytest.approx(4.0 / math.pi * found.delta_over_d(1e-6), rel=0.02)


@given(
    phi=st.floats(1e-6, 0.64),
    epsilon=st.floats(0.0, 1.0),
    dimension=st.sampled_from([2, 3]),
    rule=st.sampled_from(sorted(RULES)),
    contact=st.sampled_from([None, VISCOELASTIC, TSUJI]),
    tc_nu=st.floats(0.0, 1.0),
    error=st.floats(1e-6, 1.0),
)
def test_any_setting_gives_a_bounded_law(phi, epsilon, dimension, rule, contact, tc_nu, error):
    found = law(phi, epsilon, dimension=dimension, rule=rule, law=contact)
    assert found.error(0.0) == 0.0 == found.error_bar(0.0)
    assert math.isfinite(found.error(tc_nu)) and found.error(tc_nu) > -1.0
    assert 0.0 < found.coefficient_error < math.inf and found.error_bar(tc_nu) >= 0.0
    assert found.error_bar(tc_nu) >= found.error_bar(0.5 * tc_nu)
    limit = found.largest_tc_nu(error)
    assert 0.0 <= limit <= module.MEASURED_TC_NU and abs(found.error(limit)) <= error * (1 + 1e-9)
    assert found.largest_tc_nu(min(1.0, 2.0 * error)) >= limit
