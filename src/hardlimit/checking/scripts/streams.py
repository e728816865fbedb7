"""A stream of grains that LIGGGHTS' ``fix insert/stream`` releases into open space.

Grains are made behind a plane face and move along its normal until they pass it; only from then on gravity and contacts
act on them, and they have their velocity along the face. Through a level face they leave with one velocity: who comes
earlier is ahead and faster, so that no grain catches up with another one. Velocities along the face let grains that are
released touch those beside them that are not, with this velocity, and with up to twice as much where they bounced off
one before; the packing fraction is at most that behind the face. Source: LIGGGHTS' documentation of this fix, and
``fix_insert_stream.cpp``.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, NamedTuple

from . import meshes, motion
from .description import Speed

if TYPE_CHECKING:
    from .description import Stage
    from .state import Fix, State

#: Cosine of the angle up to which a face is level, and the share of a velocity along the face that counts as none.
LEVEL, ALONG = 1.0 - 1e-6, 1e-6
#: Largest packing fraction of spheres that are placed at random without overlap.
DENSEST: Final = 0.5
SOURCE: Final = (
    "the velocity along its face with which the stream is released; grains that bounced meet faster"
)


class Stream(NamedTuple):
    """Grains that leave a face with one velocity."""

    velocity: tuple[float, ...]
    normal: tuple[float, ...]  #: of the face, a unit vector along the velocity
    packing_fraction: float | None  #: behind the face
    apart: bool  #: whether grains are made without overlap

    @property
    def along_face(self) -> float:
        """The part of the velocity along the face."""
        forward = sum(v * n for v, n in zip(self.velocity, self.normal, strict=True))
        across = math.hypot(*(v - forward * n for v, n in zip(self.velocity, self.normal, strict=True)))
        return across if across > ALONG * forward else 0.0

    def opens(self, state: State, stage: Stage) -> bool:
        """Whether it falls through open space, straight or not at all."""
        down = stage.down
        level = down is None or sum(n * d for n, d in zip(self.normal, down, strict=True)) > LEVEL
        endless = any(
            state.filling.periodic(k) and (self.normal[k] or self.velocity[k]) for k in range(state.dimension)
        )
        walls = any(contact.wall is not None for contact in stage.contacts)
        fixed = any(kind.frozen or kind.partly_frozen for kind in stage.grains.values())
        return level and (down is not None or not stage.gravity) and not (endless or walls or fixed)


def read(state: State, fix: Fix, velocity: tuple[float, ...], volume_rate: float | None) -> Stream | None:
    """The stream of ``fix insert/stream``; None if its face or its velocity is not known.

    ``volume_rate``: volume of the grains per time.
    """

    def word(name: str) -> str:
        return fix.words[fix.words.index(name) + 1] if name in fix.words[:-1] else ""

    face = state.fixes.get(word("insertion_face"))
    corners = None if face is None else motion.corners_of_mesh(state, face.words)
    flat = None if corners is None else meshes.plane(corners)
    if flat is None or word("vel") not in ("", "constant"):
        return None
    normal, area = flat
    forward = sum(v * n for v, n in zip(velocity, normal, strict=True))
    if not forward:
        return None
    phi = None if volume_rate is None else volume_rate / (area * abs(forward))
    return Stream(
        velocity,
        tuple(math.copysign(1.0, forward) * part for part in normal),
        phi if phi is not None and 0.0 < phi <= DENSEST else None,
        word("overlapcheck") in ("", "yes"),
    )


def only(state: State, stage: Stage) -> Stream | None:
    """The stream of a run in which nothing else is, and no velocity is changed; None without one."""
    filling = state.filling
    if state.population.elsewhere or filling.heat or filling.drifts or not filling.velocities_known:
        return None
    insertions = filling.insertions
    streams = {insertion.stream for insertion in insertions}
    stream = streams.pop() if len(streams) == 1 and len(insertions) == len(filling.launches) else None
    return stream if stream is not None and stream.opens(state, stage) else None


def speed(stream: Stream) -> Speed:
    """The largest relative speed of its grains."""
    return Speed(stream.along_face, SOURCE)
