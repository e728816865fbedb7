"""Sizes and masses of the grains of each type, from the commands that create and change them."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, field, replace
from typing import Final

from .description import Grains, Range

#: Most grains whose numbers are kept.
MAX_ATOMS: Final = 1000


@dataclass(frozen=True)
class Batch:
    """Grains created by one command. Their mass follows from the density, or is given."""

    radii: Range | None = None
    densities: Range | None = None
    masses: Range | None = None
    atom: int | None = None  #: its number if it is one grain; None if that is not known

    def with_radius(self, radius: float | None) -> Batch:
        """Another radius and the same density, or the same given mass."""
        return replace(self, radii=None if radius is None else (radius, radius))

    def with_mass_of(self, dimension: int) -> Batch:
        """The present mass instead of the density. In two dimensions, the density is that of disks."""
        if self.densities is None:
            return self
        masses = None
        if self.radii is not None:
            low, high = (
                (math.pi * r**2 if dimension == 2 else 4.0 / 3.0 * math.pi * r**3) * density
                for r, density in zip(self.radii, self.densities, strict=True)
            )
            masses = (low, high)
        return replace(self, densities=None, masses=masses)


def union(ranges: Collection[Range | None]) -> Range | None:
    """From the smallest to the largest; None if one of them is not known."""
    known = [one for one in ranges if one is not None]
    if not ranges or len(known) < len(ranges):
        return None
    return min(low for low, _ in known), max(high for _, high in known)


@dataclass
class Population:
    """All grains by type."""

    batches: dict[int, list[Batch]] = field(default_factory=dict)
    elsewhere: bool = False  #: whether grains of any type may come from a file that was not read

    def add(self, kind: int, batch: Batch) -> None:
        """Create grains."""
        held = self.batches.setdefault(kind, [])
        if batch not in held:
            held.append(batch)

    def next_atom(self) -> int | None:
        """The number of the next grain; None if not all grains before it were created one by one."""
        held = [one for each in self.batches.values() for one in each]
        known = not self.elsewhere and len(held) < MAX_ATOMS and all(one.atom is not None for one in held)
        return 1 + max([one.atom or 0 for one in held], default=0) if known else None

    def split(
        self, kinds: Collection[int], whole: bool, atoms: range | None
    ) -> Iterator[tuple[int, list[Batch], list[Batch]]]:
        """For each type, the batches in which no grain is chosen, or not all, and those with chosen grains.

        Chosen are all grains of some types if ``whole`` is true, or those with the numbers ``atoms``, or unknown ones.
        """
        numbers = {one.atom for each in self.batches.values() for one in each} - {None}
        missing = atoms is not None and sum(k in atoms for k in numbers) < len(atoms)
        for kind in set(kinds) & self.batches.keys():
            held = self.batches[kind]
            if atoms is None:
                yield kind, [] if whole else held, held
            else:
                chosen = [one for one in held if (missing if one.atom is None else one.atom in atoms)]
                yield kind, [one for one in held if one.atom is None or one.atom not in atoms], chosen

    def change(
        self,
        kinds: Collection[int],
        whole: bool,
        change: Callable[[Batch], Batch],
        atoms: range | None = None,
    ) -> None:
        """Change grains, which are chosen as in ``split``."""
        for kind, kept, chosen in list(self.split(kinds, whole, atoms)):
            self.batches[kind] = list(dict.fromkeys([*kept, *map(change, chosen)]))

    def convert(self, kinds: Collection[int], whole: bool, kind: int, atoms: range | None = None) -> None:
        """Give another type to grains, which are chosen as in ``split``."""
        parts = list(self.split(kinds, whole, atoms))
        for each, kept, _ in parts:
            self.batches[each] = kept
        for _, _, chosen in parts:
            for one in chosen:
                self.add(kind, one)
        self.batches = {each: held for each, held in self.batches.items() if held}

    def grains(
        self,
        kind: int,
        name: str,
        frozen: bool,
        counted: bool = False,
        disks: bool = False,
        partly_frozen: bool = False,
    ) -> Grains:
        """The grains of one type, whose densities may be those of disks."""
        held = [one.with_mass_of(2) if disks else one for one in self.batches.get(kind, [])]
        if self.elsewhere:
            held = [*held, Batch()]
        densities = union([one.densities for one in held])
        masses = None
        if densities is None:
            masses = union([one.with_mass_of(3).masses for one in held])
        radii = union([one.radii for one in held])
        return Grains(name, radii, densities, masses, frozen, counted, partly_frozen)


def atoms(text: str, style: str) -> Iterator[tuple[int, Batch]]:
    """Types and sizes of the grains of a data file for ``read_data``; a ValueError if its columns are not known."""
    lines = iter(text.splitlines())
    next(lines, None)  # a comment
    for line in lines:
        code, _, hint = line.partition("#")
        if code.strip() == "Atoms":
            kind = hint.strip() or style
            break
    else:
        return
    if kind not in ("sphere", "granular"):
        raise ValueError(f"atom style {kind}")
    for line in lines:
        words = line.partition("#")[0].split()
        if not words:
            continue
        if not words[0].isdigit():
            return
        diameter, density = float(words[2]), float(words[3])
        if not (diameter >= 0.0 and density > 0.0 and math.isfinite(diameter * density)):
            raise ValueError("its diameters and densities")
        radius = 0.5 * diameter
        if radius == 0.0:
            yield int(words[1]), Batch((0.0, 0.0), None, (density, density))
        else:
            yield int(words[1]), Batch((radius, radius), (density, density))


def merged(found: Iterator[tuple[int, Batch]]) -> dict[int, Batch]:
    """One batch for each type, from the smallest to the largest grain."""
    batches: dict[int, Batch] = {}
    for kind, one in found:
        old = batches.get(kind)
        if old is None:
            batches[kind] = one
        elif old != one:
            dense = union([old.densities, one.densities])
            masses = None if dense else union([old.with_mass_of(3).masses, one.with_mass_of(3).masses])
            batches[kind] = Batch(union([old.radii, one.radii]), dense, masses)
    return batches


def header(text: str, what: str) -> int:
    """A number of the header of a data file, such as that before ``atom types``."""
    for line in text.splitlines()[1:60]:
        words = line.partition("#")[0].split()
        if words[1:] == what.split() and words[0].isdigit():
            return int(words[0])
    return 0


def molecule(text: str) -> list[tuple[int, Batch]]:
    """Types (offsets) and sizes of the atoms of a molecule file; the default diameter is 1."""
    section, types, diameters, masses, count = "", dict[int, int](), dict[int, float](), dict[int, float](), 0
    for line in text.splitlines()[1:]:
        words = line.partition("#")[0].split()
        if not words:
            continue
        if words[0].isalpha():
            section = words[0]
        elif not section and words[1:] == ["atoms"]:
            count = int(words[0])
        elif len(words) >= 2 and words[0].isdigit():
            if section == "Types":
                types[int(words[0])] = int(words[1])
            elif section == "Diameters":
                diameters[int(words[0])] = float(words[1])
            elif section == "Masses":
                masses[int(words[0])] = float(words[1])
    found = []
    for k in range(1, min(count, 100_000) + 1):
        radius = 0.5 * diameters.get(k, 1.0)
        mass = (masses[k], masses[k]) if k in masses else None
        found.append((types.get(k, 1), Batch((radius, radius), None if mass else (1.0, 1.0), mass)))
    return found
