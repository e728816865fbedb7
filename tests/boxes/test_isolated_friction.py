"""Isolated contacts with friction in the engine by events: solved as a whole, as the contact of two balls is."""

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import hardlimit as hl
from hardlimit import _core
from hardlimit.boxes.contacts import law_arguments

SIZE = 10.0
Floats = NDArray[np.float64]
LAWS = {
    "one change": hl.LinearDashpot(
        stiffness=1e4, restitution=0.9, friction=hl.Friction(0.5, stiffness_ratio=2 / 7)
    ),
    "slip": hl.LinearDashpot(stiffness=1e4, restitution=1.0, friction=hl.Friction(0.1, stiffness_ratio=0.9)),
    "damped": hl.LinearDashpot(
        stiffness=3e3, restitution=0.6, friction=hl.Friction(0.4, stiffness_ratio=0.5, damping_ratio=1.0)
    ),
    "rough": hl.LinearDashpot(
        stiffness=1e4, restitution=0.9, friction=hl.Friction(math.inf, stiffness_ratio=0.8)
    ),
}
each_law = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)


class Meeting:
    """Two balls, or a ball and the floor, that touch after 0.1 s."""

    def __init__(self, seed: int, wall: bool) -> None:
        r = np.random.default_rng(seed)
        n = 1 if wall else 2
        self.wall = wall
        self.radius, self.mass, self.factor = r.uniform(0.5, 1.0, (3, n))
        self.spins = 2.0 * r.normal(size=(n, 3))
        rows = zip(self.radius, self.mass, self.factor, strict=True)
        self.balls = [hl.Ball(radius, mass=mass, inertia_factor=q) for radius, mass, q in rows]
        self.normal = np.array([0.0, 0.0, -1.0]) if wall else r.normal(size=3)
        self.normal /= np.linalg.norm(self.normal)
        aside = np.cross(self.normal, r.normal(size=3))
        self.velocities = 0.2 * r.normal(size=(n, 3))
        self.velocities[0] += (1.0 - self.velocities[0] @ self.normal) * self.normal + aside
        touch = np.full((n, 3), 0.5 * SIZE)
        if wall:
            touch[0, 2] = self.radius[0]
        else:
            touch[1] += self.radius.sum() * self.normal
            self.velocities[1] -= (0.3 + self.velocities[1] @ self.normal) * self.normal
        self.touch, self.positions = touch, touch - 0.1 * self.velocities

    def engine(self, law: hl.Law) -> _core.Engine:
        sides = ["periodic", "periodic", "wall" if self.wall else "periodic"]
        return _core.make_engine(
            "newton_events",
            _core.Box([SIZE] * 3, sides, [0.0] * 3),
            self.positions,
            self.velocities,
            self.radius,
            self.mass,
            spins=self.spins,
            inertia_factor=self.factor,
            law=law_arguments(law),
            log=True,
        )

    def impact(self, law: hl.Law) -> Any:
        second = hl.FLOOR if self.wall else self.balls[1]
        n = len(self.balls)
        spins = np.zeros((2, 3))
        spins[:n] = self.spins
        other = np.zeros(3) if self.wall else self.velocities[1]
        return hl.oblique_impact(
            self.balls[0],
            second,
            law,
            self.velocities[0],
            other_velocity=other,
            spins=spins,
            normal=self.normal,
        )


def total(o: dict[str, Any]) -> float:
    kinds = ("kinetic_energy", "rotational_energy", "contact_energy", "dissipated_energy")
    return sum(float(o[kind]) for kind in kinds)


@each_law
@pytest.mark.parametrize("wall", [False, True], ids=["pair", "wall"])
def test_it_is_the_contact_of_two_balls(law: hl.LinearDashpot, wall: bool) -> None:
    """Velocities, spins, places, losses and energies after the contact, and the state in the middle of it."""
    for seed in range(5):
        meeting = Meeting(seed, wall)
        impact, engine, n = meeting.impact(law), meeting.engine(law), len(meeting.radius)
        before = total(engine.observe())
        for time in (0.37 * impact.duration, 0.8 * impact.duration):
            engine.advance(0.1 + time, 2**40, 1)
            path, (_, velocities) = impact.trajectory([time]), engine.state()
            np.testing.assert_allclose(velocities, path["velocity"].values[0][:n], atol=3e-11, rtol=0)
            np.testing.assert_allclose(engine.spins(), path["spin"].values[0][:n], atol=1e-10, rtol=0)
            assert total(engine.observe()) == pytest.approx(before, rel=1e-11)
        engine.advance(0.1 + impact.duration + 0.05, 2**40, 1)
        positions, velocities = engine.state()
        places = meeting.touch + impact.displacements[:n] + 0.05 * impact.velocities[:n]
        np.testing.assert_allclose(velocities, impact.velocities[:n], atol=3e-11, rtol=0)
        np.testing.assert_allclose(engine.spins(), impact.spins[:n], atol=1e-10, rtol=0)
        np.testing.assert_allclose(positions, places, atol=1e-11, rtol=0)
        o = engine.observe()
        rubbed = sum(
            impact.energies[kind] for kind in ("tangential_spring", "tangential_damping", "friction")
        )
        assert o["friction_loss"] == pytest.approx(rubbed, abs=1e-11 * before)
        assert total(o) == pytest.approx(before, rel=1e-12) and o["contact_energy"] == 0.0


@each_law
def test_a_saved_contact_goes_on_with_the_same_bits(law: hl.LinearDashpot) -> None:
    meeting = Meeting(7, False)
    whole, engine = meeting.engine(law), meeting.engine(law)
    duration = meeting.impact(law).duration
    engine.advance(0.1 + 0.5 * duration, 2**40, 1)
    engine = _core.load_engine("newton_events", engine.save())
    for run in (whole, engine):
        run.advance(1.0, 2**40, 1)
    assert (engine.spins() == whole.spins()).all()
    for resumed, straight in zip(engine.state(), whole.state(), strict=True):
        assert (resumed == straight).all()
    seen = engine.observe()
    for kind, value in whole.observe().items():
        np.testing.assert_allclose(seen[kind], value, rtol=1e-14, atol=0)
