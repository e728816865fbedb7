"""A law with friction and a history for each contact (tests/boxes/friction.cpp) in the time-stepping engine."""

import subprocess

import pytest

from box_engines import compiled


@pytest.fixture(scope="module")
def ask(tmp_path_factory):
    program = compiled("friction", tmp_path_factory.mktemp("friction"))

    def ask(word):
        done = subprocess.check_output([program, word], text=True, timeout=120)
        return [float(number) for number in done.split()]

    return ask


@pytest.mark.slow
def test_without_friction_the_bits_are_those_of_the_law_without_it(ask):
    without, threads, friction = ask("frictionless")
    assert without == threads == 0 and friction > 5000


@pytest.mark.slow
def test_a_sliding_sphere_rolls_at_five_sevenths_of_its_speed(ask):
    speed, surface, dissipated = ask("rolling")
    assert speed == pytest.approx(5 / 7, abs=2e-3)  # the undamped tangential spring oscillates
    assert abs(surface) < 5e-3
    assert dissipated == pytest.approx(2 / 7, abs=2e-4)


@pytest.mark.slow
def test_an_oblique_collision_keeps_both_momenta_and_coulomb_s_bound(ask):
    momentum, angular_momentum, turned, ratio = ask("oblique")
    assert momentum < 1e-14 and angular_momentum < 1e-9
    assert turned > 10.0  # rad/s
    assert ratio <= 0.2 * (1 + 1e-12)


@pytest.mark.slow
def test_energy_is_dissipated_by_friction_or_kept(ask):
    """To second order in the time step, also during the contact; the energy of rotation is counted."""
    change, friction, change_of_half, friction_of_half = ask("energy")
    assert change < 1e-4 and change_of_half < 0.3 * change
    assert friction_of_half > 0.1 and friction == pytest.approx(friction_of_half, abs=1e-4)
