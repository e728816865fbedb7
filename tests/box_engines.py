"""Helpers for tests of boxes: engines from plain numbers or systems, independent reference cases, interrupts."""

import json
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike

import hardlimit as hl
from conftest import DATA
from hardlimit import _core
from hardlimit.boxes import contacts
from hardlimit.boxes.contacts import law_arguments
from hardlimit.boxes.falling_frame import engine_arguments
from hardlimit.boxes.lammps import program
from hardlimit.boxes.theory import Gas

#: Independent solutions of small boxes, by kind.
REFERENCE = json.loads((DATA / "grains.json").read_text(encoding="utf-8"))
#: Laws of soft grains of about a millimetre.
LAWS = [
    hl.LinearDashpot(stiffness=2000.0, restitution=0.8),
    hl.LinearDashpot(stiffness=2000.0, restitution=1.0),
    hl.LinearDashpot(stiffness=2000.0, damping=0.05),
    hl.Viscoelastic(youngs_modulus=1e7, poisson_ratio=0.3, dissipative_time=1e-5),
    hl.Tsuji(elastic_prefactor=1e5, restitution=0.7),
]


def reference_system(case: dict[str, Any]) -> hl.ParticleSystem:
    """The initial state of a reference case."""
    names = ("positions", "velocities", "radius", "mass", "box", "boundary", "gravity")
    return hl.ParticleSystem(**{name: case[name] for name in names})


def reference_law(case: dict[str, Any]) -> hl.Law | None:
    """The contact law of a reference case, if it has one."""
    if "youngs_modulus" in case:
        names = ("youngs_modulus", "poisson_ratio", "dissipative_time")
        return hl.Viscoelastic(**{name: case[name] for name in names})
    if "stiffness" in case:
        return hl.LinearDashpot(stiffness=case["stiffness"], restitution=case["restitution"])
    return None


def core_engine(kind: str, system: hl.ParticleSystem, law: hl.Law, **options: Any) -> _core.Engine:
    """An engine of the core for a system."""
    return _core.make_engine(kind, *engine_arguments(system), law=law_arguments(law), **options)


def core_contact(law: hl.Law, mass: float = 1e-5, radius: float = 1e-3) -> _core.Contact:
    """A contact with this effective mass and radius."""
    return contacts.contact(law, mass, radius)


def mean_free_time(system: hl.ParticleSystem) -> float:
    """Enskog's time between two collisions of a particle of mean size [s]."""
    radius, mass = float(system.radius.mean()), float(system.mass.mean())
    gas = Gas(system.n, radius, mass, float(np.prod(system.box)), system.dimension)
    return 1.0 / float(gas.collision_rate(system.granular_temperature))


def linear_law(system: hl.ParticleSystem, duration: float, restitution: float) -> hl.LinearDashpot:
    """The linear law under which a contact of two mean particles lasts this long [s]."""
    soft = hl.LinearDashpot(stiffness=1.0, restitution=restitution)
    ball = hl.Ball(float(system.radius.mean()), mass=float(system.mass.mean()))
    return soft.replace(stiffness=(soft.between(ball, ball).duration() / duration) ** 2)


#: Each rule of hard spheres and each engine of ours: the function and its arguments.
LAW = hl.LinearDashpot(stiffness=1e4, restitution=0.8)
RUNS: dict[str, tuple[Any, dict[str, Any]]] = {
    "elastic": (hl.event_driven, {"restitution": 1.0}),
    "constant": (hl.event_driven, {"restitution": 0.9}),
    "tc": (hl.event_driven, {"restitution": 0.6, "rule": "tc", "contact_duration": 1e-3}),
    "law": (hl.event_driven, {"law": LAW}),
    "soft": (hl.event_driven, {"law": LAW, "rule": "soft"}),
    "events": (hl.molecular_dynamics, {"law": LAW, "engine": "events"}),
    "steps": (hl.molecular_dynamics, {"law": LAW, "engine": "steps", "time_step": 5e-5}),
}


def run(name: str, system: hl.ParticleSystem, until: float = 0.2, **options: Any) -> Any:
    """The result of one of ``RUNS``."""
    function, settings = RUNS[name]
    return function(system, until=until, **settings, **options)


#: Rules and engines of ours, with a law, for grains of about a millimetre: arguments of ``solved``.
LINEAR = hl.LinearDashpot(stiffness=1e4, restitution=0.8)
VISCOELASTIC = hl.Viscoelastic(youngs_modulus=1e8, poisson_ratio=0.3, restitution=0.8, impact_speed=0.3)
RULES: dict[str, dict[str, Any]] = {
    "constant": {"restitution": 0.9},
    "tc": {"restitution": 0.9, "rule": "tc", "contact_duration": 1e-5},
    "law": {"law": VISCOELASTIC},
    "soft": {"law": LINEAR, "rule": "soft"},
}
NEWTON: dict[str, dict[str, Any]] = {
    f"{engine}, {name}": {"engine": engine, "law": law}
    for engine in ("events", "steps")
    for name, law in (("linear", LINEAR), ("viscoelastic", VISCOELASTIC))
}
SOLVERS = [*RULES, *NEWTON]


def solved(name: str, system: hl.ParticleSystem, until: float, **options: Any) -> Any:
    """The result by one of ``SOLVERS``; of ten samples unless ``options`` say otherwise."""
    options = {"samples": 10} | options
    if name in RULES:
        return hl.event_driven(system, until=until, **RULES[name], **options)
    return hl.molecular_dynamics(system, until=until, **NEWTON[name], **options)


def energies(run: Any) -> np.ndarray[Any, Any]:
    """The energies at each sample [J], work and heat with a minus sign: their sum is constant."""
    gained = (
        "kinetic_energy",
        "rotational_energy",
        "potential_energy",
        "contact_energy",
        "dissipated_energy",
    )
    parts = [run.series[name].values for name in gained if name in run.series]
    return np.array(parts + [-run.series[name].values for name in ("wall_work", "shear_work", "heat")])


def energy_error(run: Any) -> float:
    """Largest change of the sum of energies, over the largest one."""
    total = energies(run).sum(axis=0)
    return float(np.abs(total - total[0]).max() / np.abs(energies(run)).max())


def interrupt_at(call: int) -> Callable[[int, int], None]:
    """A progress function that raises KeyboardInterrupt at this call, as Ctrl-C does."""
    left = iter(range(1, call))

    def progress(done: int, total: int) -> None:
        assert 0 <= done <= total
        if next(left, None) is None:
            raise KeyboardInterrupt

    return progress


def box_of(edges: ArrayLike, periodic: ArrayLike, gravity: ArrayLike = 0.0, dimension: int = 0) -> _core.Box:
    """A box; scalars are repeated for each axis."""
    d = dimension or len(np.atleast_1d(edges))
    sides = ["periodic" if wraps else "wall" for wraps in np.broadcast_to(periodic, d)]
    return _core.Box(
        np.broadcast_to(edges, d).astype(float).tolist(),
        sides,
        np.broadcast_to(gravity, d).astype(float).tolist(),
    )


def hard_spheres(
    position: ArrayLike,
    velocity: ArrayLike,
    *,
    box: ArrayLike,
    radius: ArrayLike = 0.5,
    mass: ArrayLike = 1.0,
    periodic: ArrayLike = True,
    gravity: ArrayLike = 0.0,
    rule: str = "constant",
    restitution: float = 1.0,
    law: Any = None,
    contact_duration: float = math.nan,
    log: bool = True,
) -> _core.Engine:
    """A hard-sphere engine; scalars are repeated for each particle and axis."""
    position = np.array(position, dtype=float)
    n, d = position.shape
    return _core.make_engine(
        "hard_spheres",
        box_of(box, periodic, gravity, d),
        position,
        np.array(velocity, dtype=float),
        np.broadcast_to(radius, n).astype(float),
        np.broadcast_to(mass, n).astype(float),
        law=law,
        rule=rule,
        restitution=restitution,
        rule_parameters=[contact_duration] if rule == "tc" else [],
        log=log,
    )


def grow_packing(
    radius: ArrayLike, box: Sequence[float], periodic: Sequence[bool], seed: int
) -> np.ndarray[Any, Any]:
    """Random positions without overlap."""
    return np.asarray(_core.grow_packing(box_of(box, periodic), np.asarray(radius, dtype=float), seed))


def logged(engine: _core.Engine) -> tuple[Any, ...]:
    """The columns of the contact log."""
    return tuple(engine.take_log().values())


def _why_no_lammps() -> str:
    try:
        program.find(1)
    except ImportError as error:
        return str(error)
    return ""


WITHOUT_LAMMPS = _why_no_lammps()
needs_lammps = pytest.mark.skipif(bool(WITHOUT_LAMMPS), reason=WITHOUT_LAMMPS)
