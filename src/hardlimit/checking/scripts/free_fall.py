"""Grains of LAMMPS or LIGGGHTS that never meet: all have one velocity and one acceleration, and no wall is there.

So do those of a stream that leave a level face one after another: ``streams.py``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from . import census, gravity, streams

if TYPE_CHECKING:
    from .description import Stage
    from .state import Fix, State
    from .streams import Stream

#: Fixes that leave the relative motion of grains as it is. Meshes without ``fix wall/gran`` push nothing.
SAFE: Final = (
    *("gravity", "insert/pack", "insert/stream", "particletemplate/sphere", "particledistribution/discrete"),
    *("property/", "mesh/surface", "move/mesh", "ave/", "store/", "print", "check/timestep", "massflow/mesh"),
    *("balance", "diam/max", "contacthistory", "neigh_history", "heat/gran", "region/variable", "remove"),
    *("chem/shrink/core", "limit/property/atom"),
)
#: Overlap over the diameter that rounding makes of touching.
TOUCHING: Final = 1e-9
#: Integrators among them.
MOVING: Final = ("nve", "nve/sphere")


class Launch(NamedTuple):
    """Grains that are made with one velocity. A single grain has its place; others do not overlap."""

    velocity: tuple[float, ...] | None
    place: tuple[float, ...] | None = None
    spacing: float = math.inf  #: least distance of their centres if they are made whatever their size is
    alone: bool = False  #: whether they may meet others that have the same velocity


#: Grains of which not all of this is known.
UNKNOWN: Final = Launch(None)


def single(state: State, words: Sequence[str]) -> Launch:
    """A grain at rest, from the words of ``create_atoms`` after ``single``."""
    numbers = [state.coefficient(word) for word in words[:3]]
    cell = state.filling.lattice.edges if "box" not in words[3:] else (1.0, 1.0, 1.0)
    known = [number for number in numbers if number is not None]
    if len(known) < 3 or cell is None:
        return UNKNOWN
    return Launch((0.0, 0.0, 0.0), tuple(x * edge for x, edge in zip(known, cell, strict=True)))


def on_lattice(state: State) -> Launch:
    """Grains at rest on sites of the lattice; those of periodic boxes may be closer over its ends."""
    spacing = census.spacing(state.filling.lattice, state.dimension)
    if spacing is None or any(map(state.filling.periodic, range(state.dimension))):
        return UNKNOWN
    return Launch((0.0, 0.0, 0.0), spacing=spacing, alone=True)


def streaming(stream: Stream | None) -> Launch:
    """The grains of a stream, if none is released beside one that is not."""
    if stream is None or stream.along_face or not stream.apart:
        return UNKNOWN
    return Launch(stream.velocity, alone=True)


def inserted(fix: Fix, velocity: tuple[float, ...]) -> Launch:
    """The grains of ``insert/pack`` that inserts once. Those of streams start one after another, and may meet."""
    words = fix.words
    style = words[words.index("vel") + 1] if "vel" in words[:-1] else "constant"
    overlaps = "overlapcheck" in words[:-1] and words[words.index("overlapcheck") + 1] != "yes"
    if fix.style != "insert/pack" or "once" not in words or style != "constant" or overlaps:
        return UNKNOWN
    return Launch(velocity)


def never_meet(state: State, stage: Stage) -> bool:
    """Whether no grain meets another or a wall in a run, nor did so before."""
    launches = state.filling.launches
    before = [other for other in state.stages if other.system == stage.system]
    if (
        not launches
        or not undisturbed(state)
        or state.population.elsewhere
        or any(kind.frozen or kind.partly_frozen for kind in stage.grains.values())
        or any(contact.wall is not None for contact in stage.contacts)
        or not all(other.contents.never_meet for other in before)
    ):
        return False
    filling = state.filling
    if filling.census.count == 1.0:
        return True
    if UNKNOWN in launches:
        return False
    moved = filling.drifts or filling.heat or not filling.velocities_known
    if moved or len({launch.velocity for launch in launches}) > 1 or not _one_pull(state):
        return False
    if any(insertion.stream is not None for insertion in filling.insertions):
        return streams.only(state, stage) is not None
    places = [launch.place for launch in launches if launch.place is not None]
    mixed = (places and len(places) < len(launches)) or (
        len(launches) > 1 and any(each.alone for each in launches)
    )
    if mixed or not _fit(stage, min(launch.spacing for launch in launches)):
        return False
    return len(places) < 2 or _apart(state, stage, places)


def undisturbed(state: State) -> bool:
    """Whether nothing but contacts changes the relative motion of grains."""
    return not (state.unknown or state.invalidates) and all(_safe(state, fix) for fix in state.fixes.values())


def _safe(state: State, fix: Fix) -> bool:
    """Whether a fix leaves the relative motion of grains as it is."""
    if fix.style == "scale/diameter":
        return state.shrinks(fix)
    return fix.style in MOVING or (fix.style.startswith(SAFE) and not fix.style.endswith(("servo", "6dof")))


def _one_pull(state: State) -> bool:
    """Whether at most one gravity acts, on all grains, and is known."""
    pulls = [fix for fix in state.fixes.values() if fix.style == "gravity"]
    if not pulls:
        return True
    group = state.members(pulls[0].group)
    every = group.types is None and group.whole
    return (
        len(pulls) == 1 and every and gravity.strength(state) is not None and gravity.down(state) is not None
    )


def _fit(stage: Stage, spacing: float) -> bool:
    """Whether grains with this distance of their centres at most touch."""
    radii = [kind.radii[1] for kind in stage.grains.values() if kind.radii is not None]
    known = len(radii) == len(stage.grains)
    return spacing == math.inf or (known and 2.0 * max(radii, default=0.0) <= spacing * (1.0 + TOUCHING))


def _apart(state: State, stage: Stage, places: Sequence[tuple[float, ...]]) -> bool:
    """Whether single grains do not overlap, over periodic ends as well."""
    radii = [kind.radii[1] for kind in stage.grains.values() if kind.radii is not None]
    if len(radii) < len(stage.grains):
        return False
    points = np.array(places)
    steps = points[:, None] - points[None, :]
    for k, (low, high) in enumerate(state.filling.ends):
        if state.filling.periodic(k):
            steps[..., k] -= (high - low) * np.rint(steps[..., k] / (high - low))
    distances = np.sqrt((steps**2).sum(axis=-1))[np.triu_indices(len(points), 1)]
    return bool(np.isfinite(distances).all() and distances.min() >= 2.0 * max(radii))
