"""HARDLIMIT_LANES chooses the vector kernels of boxes and maps; all give the same bits."""

import numpy as np
import pytest

import box_engines
import hardlimit as hl
from command_line import refused
from hardlimit import _core


def bits(dimension: int) -> dict[str, bytes]:
    """Final states of boxes of unequal grains under each rule and engine, and the variables of a map."""
    system = hl.ParticleSystem.random(
        80, 0.3, radius=(0.5, 1.6), density=1.0, rms_speed=1.0, dimension=dimension, seed=1
    )
    bits_of = {"start": system.positions.tobytes()}
    for name in box_engines.RUNS:
        end = box_engines.run(name, system, until=2.0).system
        bits_of[name] = end.positions.tobytes() + end.velocities.tobytes()
    for law in (
        hl.LinearDashpot(stiffness=1e6, restitution=0.8),
        hl.Viscoelastic(youngs_modulus=1e7, poisson_ratio=0.3, dissipative_time=1e-4),
    ):
        swept = hl.sweep(column=hl.Column.paper(law=law), gap=np.geomspace(1e-6, 1e-2, 100))
        bits_of[type(law).__name__] = b"".join(
            swept[name].to_numpy().tobytes() for name in sorted(swept.data_vars)
        )
    return bits_of


@pytest.mark.parametrize("dimension", [2, 3])
def test_all_instruction_sets_give_the_same_bits(monkeypatch: pytest.MonkeyPatch, dimension: int) -> None:
    widest, *others = _core.instruction_sets()
    expected = bits(dimension)
    for name in others:
        monkeypatch.setenv("HARDLIMIT_LANES", name)
        assert _core.instruction_sets()[0] == name != widest
        bits_of = bits(dimension)
        assert [kind for kind in expected if bits_of[kind] != expected[kind]] == []


def test_an_unknown_instruction_set_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HARDLIMIT_LANES", "mmx")
    message = "HARDLIMIT_LANES: got mmx, this processor has base"
    with pytest.raises(ValueError, match=message):
        hl.sweep(hl.Column.paper(), gap=[1e-3])
    with pytest.raises(ValueError, match=message):
        hl.ParticleSystem.random(10, 0.1, radius=1.0, density=1.0, rms_speed=1.0)
    assert message in refused("--version", "--verbose")
