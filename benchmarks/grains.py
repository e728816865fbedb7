"""Boxes of equal grains for the benchmarks of Newton's equations, and runs that are timed step by step."""

from __future__ import annotations

import numpy as np

import hardlimit as hl
from hardlimit import _core
from hardlimit.boxes.contacts import law_arguments
from hardlimit.boxes.falling_frame import engine_arguments
from hardlimit.boxes.theory import Gas

RADIUS, DENSITY, RESTITUTION = 1e-3, 2500.0, 0.9


def equilibrium(system: hl.ParticleSystem) -> hl.ParticleSystem:
    """The system after two elastic collisions of each particle."""
    return hl.event_driven(system, restitution=1.0, max_collisions=system.n, samples=1).system


def gas(n: int, rms_spin: str | None = None) -> hl.ParticleSystem:
    """Spheres at φ = 0.3 in equilibrium."""
    return equilibrium(hl.ParticleSystem.random(n, 0.3, RADIUS, DENSITY, rms_speed=1.0, rms_spin=rms_spin))


def rate_of(system: hl.ParticleSystem) -> float:
    """Collisions of a particle per second."""
    theory = Gas(system.n, RADIUS, float(system.mass[0]), float(np.prod(system.box)), 3)
    return float(theory.collision_rate(system.granular_temperature))


def law_of(duration: float, friction: hl.Friction | None = None) -> hl.LinearDashpot:
    """The law with this duration of a contact [s]."""
    ball = hl.Ball(RADIUS, density=DENSITY)
    soft = hl.LinearDashpot(stiffness=1.0, restitution=RESTITUTION)
    return soft.replace(stiffness=(soft.between(ball, ball).duration() / duration) ** 2, friction=friction)


def by_events(system: hl.ParticleSystem, law: hl.LinearDashpot):
    return _core.make_engine("newton_events", *engine_arguments(system), law=law_arguments(law))


def by_steps(system: hl.ParticleSystem, law: hl.LinearDashpot, step: float):
    return _core.make_engine(
        "newton_steps", *engine_arguments(system), law=law_arguments(law), time_step=step
    )


def hard_spheres(
    system: hl.ParticleSystem, rule: str, restitution=np.nan, law=None, duration=np.nan, **friction
):
    return _core.make_engine(
        "hard_spheres",
        *engine_arguments(system),
        law=law,
        rule=rule,
        restitution=restitution,
        rule_parameters=[duration] if rule == "tc" else [],
        **friction,
    )


class Run:
    """Advances an engine by the same time at every call."""

    def __init__(self, engine, span: float, threads: int = 1):
        self.engine, self.span, self.threads = engine, span, threads

    def __call__(self) -> None:
        self.engine.advance(self.engine.time + self.span, threads=self.threads)


def lammps_box(system: hl.ParticleSystem, law: hl.LinearDashpot, step: float, skin: float):
    """The same box in LAMMPS, with the same law."""
    from peers.newton_lammps import Box

    ball = hl.Ball(RADIUS, density=DENSITY)
    force = law.between(ball, ball)
    return Box(system, force.stiffness, force.damping, step, skin, law.friction)
