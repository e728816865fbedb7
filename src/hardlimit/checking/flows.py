"""Flow down a slope and in a turning drum: what follows from a script alone.

**Slope.** In a deep layer on a plane at the angle θ the shear stress over the pressure is tan θ at every depth. It
flows with the inertial number I of homogeneous shear at this ratio (GDR MiDi, Eur. Phys. J. E 14, 341 (2004)), in the
form of Jop, Forterre & Pouliquen, Nature 441, 727 (2006): tan θ = s + (t − s)/(1 + I₀/I); below tan θ = s it comes to
rest. Numbers: spheres sheared by our own steps (studies/dense_flow.nc).

**Drum.** Fr = ω²R/g, with the usual borders of Mellmann, Powder Technol. 118, 251 (2001), which overlap there. What
turns about gravity throws grains from Fr = 1 on: blades in a run of LAMMPS at 1.1 left them 0.5 contacts each.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any, Final, NamedTuple

import numpy as np

from ..convert.force import AdhesiveForce
from .contacts import Case, restitution_of
from .scripts import Stage
from .scripts.description import WALL
from .scripts.motion import STEEP

#: s by the friction of the grains, between which it is interpolated, and by how much measured ratios with ε from 0.5 to
#: 0.9 differ from the formula.
SLOPES: Final = {
    0.1: (0.265, 0.03),
    0.2: (0.315, 0.025),
    0.3: (0.349, 0.025),
    0.5: (0.376, 0.025),
    0.7: (0.388, 0.025),
    1.0: (0.391, 0.04),
}
#: t − s and I₀, for all of these, and the I up to which they were measured; faster flows depend on ε.
RISE, SCALE, FASTEST = 0.65, 0.9, 0.4
#: Restitutions that are near enough to the measured ones.
RESTITUTIONS: Final = (0.4, 0.95)
#: Settings that resist rolling, or of a code of which that is not read here.
ROLLING: Final = {"rolling", "rolling_friction", "twisting", "physics"}
#: Froude numbers up to which a drum moves its grains in these ways; beyond, they centrifuge.
DRUMS: Final = {1e-4: "slumping", 1e-2: "rolling", 0.1: "cascading", 1.0: "cataracting"}


def of_stage(stage: Stage, cases: Sequence[Case], tilt: float, speed_unit: float) -> dict[str, Any]:
    """Values of a :class:`Load` under gravity at this angle [°] against the axes. ``speed_unit``: 1 m/s."""
    values: dict[str, Any] = {}
    friction, drum = friction_of(stage, cases, speed_unit), turning(stage)
    if friction is not None and (tilt >= STEEP or on_slope(tilt, friction)[1] > 0.0):
        values["slope_inertial_number"] = on_slope(tilt, friction)
        values["rest_angle"] = math.degrees(math.atan(rest_ratio(friction)))
    if drum is not None and stage.gravity:
        square, radius = drum
        border = stage.gravity / square
        values |= {"centrifuging_radius": border} if radius is None else {"froude_number": radius / border}
    if stage.gravity and (mixing := stirring(stage)) is not None:
        values["mixer_froude_number"] = mixing
    return values


def friction_of(stage: Stage, cases: Sequence[Case], speed_unit: float) -> float | None:
    """The one friction of spheres like the measured ones that move; None if they have another one or resist rolling."""
    pairs = [case for case in cases if case.second and not case.first.fixed and not case.second.fixed]
    rough = {case.friction.coefficient for case in pairs}
    resists = any(ROLLING & contact.settings.keys() for contact in stage.contacts)
    if (
        stage.dimension != 3
        or len(rough) != 1
        or resists
        or not all(_alike(case, speed_unit) for case in pairs)
    ):
        return None
    (coefficient,) = rough
    return coefficient if coefficient is not None and min(SLOPES) <= coefficient <= max(SLOPES) else None


def _alike(case: Case, speed: float) -> bool:
    """Whether a contact has a tangential spring and, at this speed, a restitution near the measured ones."""
    bodies = case.first.tried(0), None if case.second is None else case.second.tried(0)
    if (
        case.force is None
        or case.friction.terms is None
        or isinstance(case.force(*bodies, speed), AdhesiveForce)
    ):
        return False
    restitution = restitution_of(case, speed)
    return (
        case.friction.terms(*bodies, speed).stiffness > 0.0
        and RESTITUTIONS[0] <= restitution <= RESTITUTIONS[1]
    )


def rest_ratio(friction: float) -> float:
    """tan θ below which a deep layer comes to rest."""
    return float(np.interp(friction, list(SLOPES), [s for s, _ in SLOPES.values()]))


def stress_ratio(inertial: float, friction: float) -> float:
    """tan θ of a deep layer that flows with this I."""
    return rest_ratio(friction) + RISE / (1.0 + SCALE / inertial)


def on_slope(tilt: float, friction: float) -> tuple[float, float]:
    """Least and largest I of a deep layer on a rough plane at this angle [°]; 0: at rest, infinite: not measured."""
    error = float(np.interp(friction, list(SLOPES), [error for _, error in SLOPES.values()]))
    above = math.tan(math.radians(tilt)) - rest_ratio(friction)

    def inertial(at: float) -> float:
        value = SCALE * at / (RISE - at) if at < RISE else math.inf
        return max(value, 0.0) if value <= FASTEST else math.inf

    return inertial(above - error), inertial(above + error)


def way_of(froude: float) -> str:
    """How a drum with this Froude number moves its grains."""
    return next((name for border, name in DRUMS.items() if froude < border), "centrifuging")


def turning(stage: Stage) -> tuple[float, float | None] | None:
    """ω² of a drum that turns across gravity, and its radius if it is known; None without one."""
    drums = (wall for wall in _turning_walls(stage) if wall.along < 1e-6)
    return next(((drum.square, drum.radius) for drum in drums), None)


def stirring(stage: Stage) -> float | None:
    """ω²R/g of what turns about gravity, such as blades, at the side of the box; None without it, or of a cylinder."""
    down = stage.down or ()
    across = [edge for edge, part in zip(stage.edges, down, strict=False) if edge and abs(part) < 0.5]
    upright = [wall for wall in _turning_walls(stage) if wall.radius is None and wall.along > 1.0 - 1e-6]
    if not (upright and across and stage.gravity):
        return None
    return upright[0].square * 0.5 * max(across) / stage.gravity


class _Turning(NamedTuple):
    square: float  #: ω²
    radius: float | None  #: None if it is not known
    along: float  #: cosine between the axis and gravity, without its sign


def _turning_walls(stage: Stage) -> Iterator[_Turning]:
    """The walls that turn, where the direction of gravity is known."""
    for contact in stage.contacts:
        motion = contact.motion
        if contact.types[1] != WALL or motion is None or motion.turning is None or stage.down is None:
            continue
        rate = math.hypot(*motion.turning)
        if rate > 0.0:
            along = sum(a * b for a, b in zip(motion.turning, stage.down, strict=False))
            yield _Turning(rate**2, motion.radius, abs(along) / rate)
