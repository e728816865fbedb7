"""Packing fraction and impact speed that follow from what a script says, each with where it comes from."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Final

from ..boxes.error_law import DENSEST
from ..support.formatting import digits, length
from .result import Inferred
from .scripts import Stage
from .scripts.description import Speed
from .supplied import SCALES

#: Fewest grains whose packing is taken as that of a gas.
FEWEST: Final = 20
#: Where a speed comes from that is only usual for what rests.
SUPPOSED: Final = "√(g d) of grains at rest"


def packing_fraction(stage: Stage) -> Inferred | None:
    """φ of the grains in the box of a run; None if it is not stated, or under gravity or pressure."""
    contents = stage.contents
    if stage.gravity or stage.pressed or contents.filled is None or not contents.volume:
        return None
    count, phi = contents.count, contents.filled / contents.volume
    if (count is not None and count < FEWEST) or not 0.0 < phi <= DENSEST[stage.dimension]:
        return None
    source = "the volume fraction that is inserted" if count is None else f"{count:.0f} grains in the box"
    return Inferred("packing fraction", phi, "", source, True)


def speed(stages: Sequence[Stage]) -> Inferred | None:
    """The largest impact speed that the runs of a system state, in the units of the script.

    It decides on the answer if it is that of a gas: grains under gravity dissipate what they gain by falling.
    """
    last = stages[-1]
    speeds = [speed for stage in stages for speed in (*stage.contents.speeds, *moving(stage))]
    own = max(speeds, key=lambda each: (each.value, each.decides), default=None)
    own = own or next(resting(last), None)
    if own is None or not 0.0 < own.value < math.inf:
        return None
    _, metre, _ = SCALES[last.units]
    plain = last.units == "lj"
    height = own.height and (digits(own.height, 3) if plain else length(float(f"{own.height * metre:.3g}")))
    source = own.source.format(height=height)
    return Inferred("speed", own.value, "" if plain else "m/s", source, own.decides and not last.gravity)


def moving(stage: Stage) -> Iterator[Speed]:
    """Speeds of walls, and of grains that follow no force."""
    for motion in (contact.motion for contact in stage.contacts if contact.motion is not None):
        if motion.velocity:
            yield Speed(motion.velocity, "that of what moves")
        elif motion.amplitude is not None and motion.frequency:
            size = math.hypot(*motion.amplitude) * motion.frequency
            yield Speed(size, "A ω of what shakes")


def resting(stage: Stage) -> Iterator[Speed]:
    """The speed of grains that are close to rest under gravity: they fall by about a diameter."""
    radii = [kind.radii[1] for kind in stage.grains.values() if kind.radii is not None and not kind.frozen]
    if (
        stage.gravity
        and stage.gravity > 0.0
        and radii
        and len(radii) == sum(not kind.frozen for kind in stage.grains.values())
    ):
        yield Speed(math.sqrt(2.0 * max(radii) * stage.gravity), SUPPOSED)
