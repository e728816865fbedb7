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
    known = [limits for limits in ranges if limits is not None]
    if not ranges or len(known) < len(ranges):
        return None
    return min(low for low, _ in known), max(high for _, high in known)


@dataclass
class Population:
    """All grains by type."""

    batches: dict[int, list[Batch]] = field(default_factory=dict)
    elsewhere: bool = False  #: whether grains of any type may come from a file that was not read
    unread: Batch = field(default_factory=Batch)  #: what later commands say of all of these

    def from_elsewhere(self) -> None:
        """Grains come from a file that is not read."""
        self.elsewhere, self.unread = True, Batch()

    def add(self, kind: int, batch: Batch) -> None:
        """Create grains."""
        batches = self.batches.setdefault(kind, [])
        if batch not in batches:
            batches.append(batch)

    def next_atom(self) -> int | None:
        """The number of the next grain; None if not all grains before it were created one by one."""
        batches = [batch for each in self.batches.values() for batch in each]
        known = (
            not self.elsewhere
            and len(batches) < MAX_ATOMS
            and all(batch.atom is not None for batch in batches)
        )
        return 1 + max([batch.atom or 0 for batch in batches], default=0) if known else None

    def split(
        self, kinds: Collection[int], whole: bool, atoms: range | None
    ) -> Iterator[tuple[int, list[Batch], list[Batch]]]:
        """For each type, the batches in which no grain is chosen, or not all, and those with chosen grains.

        Chosen are all grains of some types if ``whole`` is true, or those with the numbers ``atoms``, or unknown ones.
        """
        numbers = {batch.atom for each in self.batches.values() for batch in each} - {None}
        missing = atoms is not None and sum(k in atoms for k in numbers) < len(atoms)
        for kind in set(kinds) & self.batches.keys():
            batches = self.batches[kind]
            if atoms is None:
                yield kind, [] if whole else batches, batches
            else:
                chosen = [
                    batch for batch in batches if (missing if batch.atom is None else batch.atom in atoms)
                ]
                yield (
                    kind,
                    [batch for batch in batches if batch.atom is None or batch.atom not in atoms],
                    chosen,
                )

    def change(
        self,
        kinds: Collection[int],
        whole: bool,
        change: Callable[[Batch], Batch],
        atoms: range | None = None,
        unread: bool = False,
    ) -> None:
        """Change grains, which are chosen as in ``split``; ``unread``: and all those of files that were not read."""
        if unread:
            self.unread = change(self.unread)
        for kind, kept, chosen in list(self.split(kinds, whole, atoms)):
            self.batches[kind] = list(dict.fromkeys([*kept, *map(change, chosen)]))

    def convert(self, kinds: Collection[int], whole: bool, kind: int, atoms: range | None = None) -> None:
        """Give another type to grains, which are chosen as in ``split``."""
        parts = list(self.split(kinds, whole, atoms))
        for each, kept, _ in parts:
            self.batches[each] = kept
        for _, _, chosen in parts:
            for batch in chosen:
                self.add(kind, batch)
        self.batches = {each: batches for each, batches in self.batches.items() if batches}

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
        batches = [batch.with_mass_of(2) if disks else batch for batch in self.batches.get(kind, [])]
        if self.elsewhere:
            batches = [*batches, self.unread]
        densities = union([batch.densities for batch in batches])
        masses = None
        if densities is None:
            masses = union([batch.with_mass_of(3).masses for batch in batches])
        radii = union([batch.radii for batch in batches])
        pair = None
        if len(batches) == 2 and not partly_frozen and all(batch.atom is not None for batch in batches):
            first, second = (Grains(name, each.radii, each.densities, each.masses) for each in batches)
            pair = None if first == second else (first, second)
        return Grains(
            type=name,
            radii=radii,
            densities=densities,
            masses=masses,
            frozen=frozen,
            counted=counted,
            partly_frozen=partly_frozen,
            pair=pair,
        )


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


def merged(pairs: Iterator[tuple[int, Batch]]) -> dict[int, Batch]:
    """One batch for each type, from the smallest to the largest grain."""
    batches: dict[int, Batch] = {}
    for kind, batch in pairs:
        old = batches.get(kind)
        if old is None:
            batches[kind] = batch
        elif old != batch:
            dense = union([old.densities, batch.densities])
            masses = None if dense else union([old.with_mass_of(3).masses, batch.with_mass_of(3).masses])
            batches[kind] = Batch(union([old.radii, batch.radii]), dense, masses)
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
    grains = []
    for k in range(1, min(count, 100_000) + 1):
        radius = 0.5 * diameters.get(k, 1.0)
        mass = (masses[k], masses[k]) if k in masses else None
        grains.append((types.get(k, 1), Batch((radius, radius), None if mass else (1.0, 1.0), mass)))
    return grains
