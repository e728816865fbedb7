"""Grains of several sizes and materials that rest on each other: which of them touch, and how they share the load.

Beds of spheres (studies/mixtures.nc): a grain has contacts in proportion to its radius, :data:`NEIGHBOURS`; whom it
touches is chance; and forces between grains of the radii a and b are in proportion to (a b)^:data:`SHARED`. The mean
of force times distance of the centres is 8π p ⟨R³⟩/(φ z), from Love's and Weber's stress.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .scripts.description import Lot

Floats = NDArray[np.float64]

#: Powers of the radius in the number of contacts of a grain, and of both radii in a force.
NEIGHBOURS, SHARED = 1.0, 4.0 / 3.0
#: Increase of φ z over the standard deviation of the radii, in units of their mean.
WIDER: Final = 0.14
#: Most kinds of a type, and of all types.
MOST_OF_TYPE, MOST_KINDS = 8, 24
#: Relative difference of radii that count as equal.
ROUNDING: Final = 1e-6
#: Ratio of radii up to which a distribution was measured.
WIDEST: Final = 3.0


class Kind(NamedTuple):
    """Grains of one type and nearly one size."""

    type: str
    radius: float
    share: float  #: of the number of all grains
    density: float | None = None  #: None: that of the grains of its type


class Pairs(NamedTuple):
    """How contacts and forces are shared between kinds."""

    contacts: Floats  #: share of all contacts between each two kinds; their sum is 1
    forces: Floats  #: mean force of these contacts over the mean force of all
    neighbours: Floats  #: contacts of a grain of each kind over the mean number
    width: float  #: standard deviation of the radii over their mean


def pairs(kinds: Sequence[Kind]) -> Pairs:
    """The shares in a packing of these kinds."""
    radius, share = np.array([[kind.radius, kind.share] for kind in kinds]).T
    share = share / share.sum()
    neighbours = radius**NEIGHBOURS / (share @ radius**NEIGHBOURS)
    ends = share * neighbours
    contacts, forces = np.outer(ends, ends), np.outer(radius, radius) ** SHARED
    mean = float(share @ radius)
    width = math.sqrt(float(share @ (radius - mean) ** 2)) / mean
    return Pairs(contacts, forces / (contacts * forces).sum(), neighbours, width)


def mean_force(kinds: Sequence[Kind], pressure: float, carrying: float) -> float:
    """Mean force [N] of all contacts under a pressure [Pa]. ``carrying``: φ z."""
    radius, share = np.array([[kind.radius, kind.share] for kind in kinds]).T
    cubes = float(share @ radius**3 / share.sum())
    of = pairs(kinds)
    distance = float((of.contacts * of.forces * np.add.outer(radius, radius)).sum())
    return 8.0 * math.pi * pressure * cubes / (carrying * distance)


# --- the kinds of a state or of a script ----------------------------------------------------------------------


def of_grains(types: Sequence[str], radii: Floats, densities: Floats | None = None) -> tuple[Kind, ...]:
    """The kinds of grains, each type by its radii, or in parts of equal number if they are many."""
    kinds: list[Kind] = []
    names = np.array(types)
    for name in dict.fromkeys(types):
        chosen = np.flatnonzero(names == name)
        chosen = chosen[np.argsort(radii[chosen], kind="stable")]
        steps = 1 + np.flatnonzero(np.diff(radii[chosen]) > ROUNDING * radii[chosen[-1]])
        parts = np.split(chosen, steps)
        if len(parts) > MOST_OF_TYPE:
            parts = np.array_split(chosen, MOST_OF_TYPE)
        for part in parts:
            density = None if densities is None else float(densities[part].mean())
            radius = float(np.mean(radii[part] ** 3) ** (1.0 / 3.0))
            kinds.append(Kind(str(name), radius, len(part) / len(radii), density))
    return checked(kinds)


def of_lots(lots: Sequence[Lot], names: Collection[str]) -> tuple[Kind, ...]:
    """The kinds of what a script makes, for the types of these names; empty if they are not known."""
    kinds: list[Kind] = []
    for lot in lots:
        name = next(iter(names)) if len(names) == 1 and lot.kind == 0 else str(lot.kind)
        if name not in names:
            continue
        radii = [*_radii(lot)]
        if not radii or not lot.number:
            return ()
        kinds += [Kind(name, radius, lot.number / len(radii)) for radius in radii]
    return checked(kinds)


def _radii(lot: Lot) -> Iterator[float]:
    """Radii of equal shares of a uniform distribution with the mean square and the mean cube of the lot.

    With the mean m and half the width w they are m² + w²/3 and m³ + m w².
    """
    if not lot.number or not lot.squares or not lot.cubes:
        return
    square, cube = lot.squares / lot.number, lot.cubes / lot.number
    root = math.sqrt(square)
    if cube <= root**3 * (1.0 + 1e-9):
        yield root
        return
    real = [float(m.real) for m in np.roots([2.0, 0.0, -3.0 * square, cube]) if abs(m.imag) < 1e-9 * root]
    mean = max(real, default=0.0)
    half = math.sqrt(max(3.0 * (square - mean**2), 0.0))
    if mean + half <= WIDEST * (1.0 + 1e-9) * (mean - half):
        yield from _between(mean - half, mean + half)


def _between(low: float, high: float) -> Iterator[float]:
    """The middles of equal parts."""
    for k in range(MOST_OF_TYPE):
        yield low + (high - low) * (k + 0.5) / MOST_OF_TYPE


def uniform(name: str, radii: tuple[float, float]) -> tuple[Kind, ...]:
    """The kinds of one type whose radii are uniform between these."""
    return checked([Kind(name, radius, 1.0) for radius in _between(*radii)])


def checked(kinds: Sequence[Kind]) -> tuple[Kind, ...]:
    """The kinds, equal ones together; empty if they are too many or too different, or all grains are equal."""
    shares: dict[tuple[str, float, float | None], float] = {}
    for kind in kinds:
        key = kind.type, float(f"{kind.radius:.6g}"), kind.density
        shares[key] = shares.get(key, 0.0) + kind.share
    radii = [radius for _, radius, _ in shares]
    if not 1 < len(shares) <= MOST_KINDS or max(radii) > WIDEST * (1.0 + 1e-3) * min(radii):
        return ()
    return tuple(Kind(name, radius, share, density) for (name, radius, density), share in shares.items())
