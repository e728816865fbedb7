"""Clumps in scripts of YADE: how much larger and heavier they are than their spheres.

``O.bodies.appendClumped``, ``clump``, ``addToClump``, ``replaceByClumps`` and ``SpherePack.makeClumpCloud`` of YADE
2023.02a. Without ``discretization`` a clump has the mass of all its spheres, also where they overlap.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, Final, NamedTuple

import numpy as np

from . import clumps
from .clumps import Spheres
from .python import Instance, flat
from .yade_container import Ends, is_number, vector
from .yade_extents import ends_of_space

#: Methods that tie spheres together, and those that leave clumps as they are or take spheres out of them.
TIED: Final = ("appendClumped", "clump", "addToClump")
LEFT: Final = ("clumpTemplate", "releaseFromClump", "updateClumpProperties")
#: Lattices, whose spheres do not overlap.
LATTICES: Final = ("regularHexa", "regularOrtho")


class Clumped(NamedTuple):
    """The largest of these numbers over all clumps."""

    concentration: float = (
        1.0  #: square of the radius of the sphere of its volume over that of its smallest sphere
    )
    heavier: float = 1.0  #: mass over that of its volume
    reach: float = 0.0  #: its extent over that radius
    unknown: bool = False  #: whether there is a clump whose numbers are not known

    def with_(self, other: Clumped) -> Clumped:
        """The larger numbers of both."""
        concentration, heavier, reach = (max(pair) for pair in zip(self[:3], other[:3], strict=True))
        return Clumped(concentration, heavier, reach, self.unknown or other.unknown)


def of_spheres(table: Spheres, discretized: bool) -> Clumped:
    """A clump of these spheres."""
    table = clumps.checked(table)
    if len(table) > clumps.MAX_SPHERES:
        raise ValueError("spheres")
    volume = clumps.volume(table)
    radius = (0.75 / math.pi * volume) ** (1.0 / 3.0)
    sum_of_all = float((table[:, 3] ** 3).sum()) / radius**3
    concentration = max((radius / float(table[:, 3].min())) ** 2, 1.0)
    return Clumped(
        concentration, 1.0 if discretized else max(sum_of_all, 1.0), 2.0 * clumps.half_extent(table) / radius
    )


def is_discretized(call: Instance) -> bool:
    """Whether a call makes the mass of a clump that of its volume."""
    value = call.attributes.get("discretization", 0)
    return is_number(value) and value > 0


def of_ends(ends: Iterable[Ends | None], discretized: bool) -> Clumped | None:
    """A clump of single spheres between these ends; None if they are not known."""
    known = list(ends)
    if not known or len(known) > clumps.MAX_SPHERES:
        return None
    rows = [
        [*(0.5 * (a + b) for a, b in zip(*end, strict=True)), 0.5 * (end[1][0] - end[0][0])]
        for end in known
        if end is not None
    ]
    if len(rows) < len(known):
        return None
    try:
        return of_spheres(np.array(rows), discretized)
    except ValueError:
        return None


def of_lattice(call: Instance) -> Clumped | None:
    """A clump of a lattice that fills a predicate, at most of the size of the box around it."""
    ends, radius = ends_of_space(call.argument(0, "predicate")), call.argument(1, "radius")
    gap = call.argument(2, "gap", 0.0)
    if call.name not in LATTICES or ends is None or not is_number(radius) or not is_number(gap) or gap < 0.0:
        return None
    edges = [b - a for a, b in zip(*ends, strict=True)]
    size = (0.75 / math.pi * math.prod(edges)) ** (1.0 / 3.0)
    known = 0.0 < radius <= size < math.inf
    return Clumped((size / radius) ** 2, 1.0, math.hypot(*edges) / size) if known else None


def of_templates(call: Instance) -> Clumped | None:
    """The clumps of ``replaceByClumps``, each of the volume of the sphere that it replaces."""
    result = None
    for template in flat([call.argument(0, "templateList")]):
        if not isinstance(template, Instance) or template.name != "clumpTemplate":
            return None
        radii, places = (template.argument(k, name) for k, name in enumerate(("relRadii", "relPositions")))
        own = of_table(places, radii, is_discretized(call))
        if own is None:
            return None
        result = own if result is None else result.with_(own)
    return result


def of_packs(packs: Any, discretized: bool) -> Clumped | None:
    """The clumps of ``makeClumpCloud``, each given as ``SpherePack([(centre, radius), …])``."""
    result = None
    for pack in flat([packs]):
        pairs = pack.argument(0, "list") if isinstance(pack, Instance) else None
        if not isinstance(pairs, list) or not all(isinstance(pair, tuple | list) for pair in pairs):
            return None
        own = of_table([pair[0] for pair in pairs], [pair[-1] for pair in pairs], discretized)
        if own is None:
            return None
        result = own if result is None else result.with_(own)
    return result


def of_table(places: Any, radii: Any, discretized: bool) -> Clumped | None:
    """A clump of spheres at these places; None if they are not known."""
    if not isinstance(places, list | tuple) or not isinstance(radii, list | tuple):
        return None
    centres = [vector(place) for place in places]
    if None in centres or len(centres) != len(radii) or not radii or not all(map(is_number, radii)):
        return None
    rows = [[*centre, radius] for centre, radius in zip(centres, radii, strict=True) if centre is not None]
    try:
        return of_spheres(np.array(rows, float), discretized)
    except ValueError:
        return None
