"""How many grains a script of LAMMPS or LIGGGHTS makes and what they fill, as far as it says so.

Lattices and regions: docs.lammps.org, pages lattice, region and create_atoms.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from .description import Lot as Lot
from .description import Range

#: Cartesian sites of the unit cell of each lattice, and its edges over the first one.
SQUARE: Final = (1.0, 1.0, 1.0)
LATTICES: Final[dict[str, tuple[tuple[tuple[float, float, float], ...], tuple[float, float, float]]]] = {
    "none": ((), SQUARE),
    "sc": (((0.0, 0.0, 0.0),), SQUARE),
    "sq": (((0.0, 0.0, 0.0),), SQUARE),
    "bcc": (((0.0, 0.0, 0.0), (0.5, 0.5, 0.5)), SQUARE),
    "fcc": (((0.0, 0.0, 0.0), (0.5, 0.5, 0.0), (0.5, 0.0, 0.5), (0.0, 0.5, 0.5)), SQUARE),
    "sq2": (((0.0, 0.0, 0.0), (0.5, 0.5, 0.0)), SQUARE),
    "hex": (((0.0, 0.0, 0.0), (0.5, 0.5, 0.0)), (1.0, math.sqrt(3.0), 1.0)),
}
#: Most sites of a lattice that are counted one by one.
MAX_SITES: Final = 1_000_000
#: Share of the edge of a box at its upper end where ``create_atoms`` leaves out the sites of a periodic lattice.
END: Final = 2e-6
ROUNDING: Final = 1e-9


@dataclass(frozen=True)
class Lattice:
    """A lattice. Its ``sites`` are None if it is not understood."""

    sites: tuple[tuple[float, float, float], ...] | None = ()
    edges: tuple[float, float, float] | None = (
        SQUARE  #: of its unit cell, the units of regions; None if not known
    )
    origin: tuple[float, ...] = (0.0, 0.0, 0.0)


def lattice(style: str, scale: float, dimension: int, reduced: bool) -> Lattice:
    """A lattice of a style; in ``lj`` units, ``scale`` is a reduced density."""
    if style not in LATTICES or not 0.0 < scale < math.inf:
        return Lattice(None, None)
    sites, shape = LATTICES[style]
    if reduced and style != "none":
        scale = (len(sites) / math.prod(shape[:dimension]) / scale) ** (1.0 / dimension)
    return Lattice(sites, (scale * shape[0], scale * shape[1], scale * shape[2]))


def spacing(cell: Lattice, dimension: int) -> float | None:
    """Least distance of the sites of a lattice; None if it is not understood."""
    if not cell.sites or cell.edges is None:
        return None
    steps = np.array([*itertools.product((-1.0, 0.0, 1.0), repeat=dimension)])
    sites = np.array(cell.sites)[:, :dimension]
    distances = (sites[:, None, None] - sites[None, :, None] + steps) * np.array(cell.edges[:dimension])
    lengths = np.linalg.norm(distances, axis=-1)
    return float(lengths[lengths > 0.0].min())


@dataclass
class Census:
    """All grains that a script makes."""

    lots: list[Lot] = field(default_factory=list)
    complete: bool = True  #: whether the number of none of them depends on what only a run knows

    def add(self, lot: Lot) -> None:
        """Grains of one command."""
        self.lots.append(lot)

    def change(self, kinds: Collection[int], whole: bool, radius: float | None) -> None:
        """Another radius for all grains of some types, or for an unknown part of them."""
        changed = [
            lot.of_radius(radius if whole else None) if lot.kind in kinds else lot for lot in self.lots
        ]
        self.lots = changed

    def convert(self, kinds: Collection[int], kind: int, share: float | None) -> None:
        """Another type for a share of the grains of some types."""
        known = 1.0 if share is None else share
        chosen = [lot for lot in self.lots if lot.kind in kinds]
        kept = [lot.times(1.0 - known) if lot.kind in kinds else lot for lot in self.lots]
        self.lots = [*kept, *(lot.times(known)._replace(kind=kind) for lot in chosen)]
        self.complete = self.complete and share is not None

    def remove(self, kinds: Collection[int]) -> None:
        """Delete all grains of some types."""
        self.lots = [lot for lot in self.lots if lot.kind not in kinds]

    def repeat(self, times: int) -> None:
        """Copies of all grains."""
        self.lots = [lot.times(times) for lot in self.lots]

    @property
    def count(self) -> float | None:
        """Number of all grains; None if it is not known."""
        counts = [lot.number for lot in self.lots]
        known = [count for count in counts if count is not None]
        return math.fsum(known) if self.complete and known and len(known) == len(counts) else None

    @property
    def known(self) -> tuple[Lot, ...]:
        """The lots if their numbers are known, else none."""
        return () if self.count is None else tuple(self.lots)

    def filled(self, dimension: int) -> float | None:
        """Total volume of all grains, in two dimensions their area; None if it is not known."""
        sums = [lot.squares if dimension == 2 else lot.cubes for lot in self.lots]
        known = [value for value in sums if value is not None]
        if not self.complete or not known or len(known) < len(sums):
            return None
        return (math.pi if dimension == 2 else 4.0 / 3.0 * math.pi) * math.fsum(known)


# --- sites of a lattice within a region -------------------------------------------------------------------------


def sites_in(
    cell: Lattice, region: Sequence[object], box: Sequence[Range], periodic: Sequence[bool], dimension: int
) -> int | None:
    """Number of sites of a lattice in a region of known numbers within the box; None if it is not known.

    ``region``: its style and its numbers in absolute units; empty for the whole box.
    """
    if not cell.sites or cell.edges is None:
        return None
    limits = extents(region, box) if region else list(box)
    if limits is None:
        return None
    if any((high - low) / edge > MAX_SITES for (low, high), edge in zip(box, cell.edges, strict=True)):
        return None
    axes = [
        [axis_sites(cell, k, site, limits[k], box[k], periodic[k]) for k in range(dimension)]
        for site in cell.sites
    ]
    numbers = [math.prod(len(axis) for axis in each) for each in axes]
    if not region or region[0] == "block":
        return sum(numbers)
    if sum(numbers) > MAX_SITES:
        return None
    return sum(_inside(region, each) for each in axes)


def axis_sites(
    cell: Lattice, k: int, site: Sequence[float], limits: Range, ends: Range, periodic: bool
) -> NDArray[np.float64]:
    """Coordinates of a site in all cells along an axis, within closed limits and the half-open box."""
    assert cell.edges is not None
    edge, start = cell.edges[k], (site[k] + cell.origin[k]) * cell.edges[k]
    small = ROUNDING * edge
    last = ends[1] - (END * (ends[1] - ends[0]) if periodic else small)
    low, high = max(limits[0], ends[0]) - small, min(limits[1] + small, last)
    first, final = math.ceil((low - start) / edge), math.floor((high - start) / edge)
    cells = np.arange(first, min(final, first + MAX_SITES) + 1, dtype=float)
    sites: NDArray[np.float64] = start + edge * cells
    return sites


def _inside(region: Sequence[object], axes: Sequence[NDArray[np.float64]]) -> int:
    """Number of points of a grid in a sphere or in a cylinder."""
    style, *words = region
    numbers = [word for word in words if isinstance(word, float)]
    if style == "sphere":
        centre, radius, across = numbers[:3], numbers[3], [*range(len(axes))]
    else:
        k = "xyz".index(str(words[0]))
        across = [axis for axis in range(3) if axis != k]
        centre = [numbers[across.index(axis)] if axis in across else 0.0 for axis in range(3)]
        radius = numbers[2]
    parts = np.meshgrid(*axes, indexing="ij", sparse=True)
    squares = sum((parts[axis] - centre[axis]) ** 2 for axis in across if axis < len(axes))
    return int(
        np.count_nonzero(
            np.broadcast_to(squares, [len(axis) for axis in axes]) <= radius**2 * (1.0 + ROUNDING)
        )
    )


def extents(region: Sequence[object], box: Sequence[Range]) -> list[Range] | None:
    """Lowest and highest coordinate of a region along each axis; None if it is not understood."""
    style, *words = region
    numbers = [word for word in words if isinstance(word, float)]
    if style == "block" and len(numbers) == 6:
        pairs = list(zip(numbers[::2], numbers[1::2], strict=True))
    elif style == "sphere" and len(numbers) == 4:
        pairs = [(x - numbers[3], x + numbers[3]) for x in numbers[:3]]
    elif style == "cylinder" and len(numbers) == 5 and words[0] in ("x", "y", "z"):
        pairs = [(x - numbers[2], x + numbers[2]) for x in numbers[:2]]
        pairs.insert("xyz".index(str(words[0])), (numbers[3], numbers[4]))
    else:
        return None
    limits = [(max(low, end[0]), min(high, end[1])) for (low, high), end in zip(pairs, box, strict=True)]
    return limits if all(low <= high for low, high in limits) else None


def volume(region: Sequence[object], box: Sequence[Range]) -> float | None:
    """Volume of a region; None if it is not understood."""
    limits = extents(region, box)
    if limits is None:
        return None
    edges = [high - low for low, high in limits]
    numbers = [word for word in region if isinstance(word, float)]
    if region[0] == "block":
        return math.prod(edges)
    radius = numbers[3] if region[0] == "sphere" else numbers[2]
    if region[0] == "sphere":
        return 4.0 / 3.0 * math.pi * radius**3
    return math.pi * radius**2 * edges["xyz".index(str(region[1]))]


def moments(radii: Range, weights: Sequence[tuple[float, float]] = ()) -> tuple[float, float]:
    """Means of r² and r³ of uniform radii, or of radii with their ``weights``."""
    if weights:
        total = math.fsum(weight for _, weight in weights)
        square, cube = (math.fsum(w * math.prod([r] * p) for r, w in weights) / total for p in (2, 3))
        return square, cube
    low, high = radii
    square = (high * high + high * low + low * low) / 3.0
    return square, (high + low) * (high * high + low * low) / 4.0


def lot(kind: int, count: float | None, means: tuple[float, float] | None) -> Lot:
    """Grains whose radii have these means of r² and r³."""
    if count is None or means is None:
        return Lot(kind, count)
    return Lot(kind, count, count * means[0], count * means[1])


def of_volume(kind: int, volume: float, means: tuple[float, float] | None) -> Lot:
    """Grains of this total volume. Their number, which LIGGGHTS rounds at random, is the larger one."""
    cubes = 0.75 / math.pi * volume
    number = None if means is None else math.ceil(cubes / means[1] * (1.0 - ROUNDING))
    return Lot(kind, number, cubes=cubes)
