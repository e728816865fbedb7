"""Text dumps of LAMMPS and LIGGGHTS, also compressed (.gz): frames with any columns, in the units of their script.

A box that tilts has its limits as those of the smallest box along the axes around it, and its tilts xy, xz, yz
(LAMMPS' manual, ``dump``). The file may name its units (``dump_modify units yes``), once, at its beginning.
"""

from __future__ import annotations

import gzip
import io
import zlib
from collections.abc import Generator, Iterable, Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import BinaryIO, Final

import numpy as np

from .frame import Floats, Found, check_frame, rounding_of, sorted_by_id, wraps_of

START: Final = b"ITEM:"
#: Ends of the columns of positions, the first of which a frame has are read; "s" is scaled, "u" unwrapped.
POSITIONS: Final = ("", "u", "s", "su")
#: Columns that are used, beside ``type``.
COLUMNS: Final[tuple[str, ...]] = (
    *(axis + end for end in POSITIONS for axis in "xyz"),
    *(name + axis for name in ("v", "omega", "angmom", "i") for axis in "xyz"),
    *("id", "radius", "diameter", "mass", "density", "inertia_factor"),
)
#: Columns of superquadrics in LIGGGHTS.
SHAPES: Final = ("shapex", "shapey", "shapez", "blockiness1", "blockiness2")
#: Items of a frame with their numbers of lines; other items have one.
ITEMS: Final = {"BOX BOUNDS": 3, "NUMBER OF ATOMS": 1, "ATOMS": 0}
#: A grain this far from the plane z = 0, over the thickness of the box, is in it.
IN_PLANE: Final = 1e-6

#: Each item of a frame: the words of its title, and its lines.
Items = dict[str, tuple[list[str], list[str]]]
#: The items of a frame, the lines of its grains, and the units that the file has named.
Block = tuple[Items, list[str], str | None]


@dataclass(frozen=True)
class DumpFrame:
    """One frame of a dump, in its own units."""

    step: int
    low: Floats  #: (3,)
    high: Floats  #: (3,)
    sides: tuple[str, ...]  #: both ends of each axis, such as "pp" or "fs"
    tilt: Floats | None  #: xy, xz and yz of a box that may tilt; None for one along the axes
    columns: Mapping[str, Floats]
    types: list[str] | None
    count: int  #: number of grains
    units: str | None  #: that the file names
    shaped: str | None  #: a column that only grains have which are no spheres

    @property
    def periodic(self) -> tuple[bool, ...]:
        return tuple(wraps_of(self.sides))

    def vectors(self, names: list[str]) -> Floats | None:
        """Columns as vectors (N, len(names)); None if one is missing."""
        if not all(name in self.columns for name in names):
            return None
        return np.stack([self.columns[name] for name in names], axis=1)

    def positions(self, dimension: int) -> tuple[Floats, str] | None:
        """Positions in a box along the axes, from scaled ones if the dump has no others, and the end of their names."""
        low, high = self.low[:dimension], self.high[:dimension]
        for end in POSITIONS:
            vectors = self.vectors([axis + end for axis in "xyz"[:dimension]])
            if vectors is not None:
                return (low + vectors * (high - low) if "s" in end else vectors), end
        return None


def is_dump(path: Path) -> bool:
    """Whether a file begins as a dump does, compressed or not."""
    try:
        with _opened(path) as file:
            return file.read(len(START)) == START
    except (EOFError, zlib.error, gzip.BadGzipFile):
        return False


def is_tilted(path: Path) -> bool:
    """Whether the box of the first frame may tilt."""
    with closing(blocks(path)) as first:
        return _parsed_box(next(first)[0])[2] is not None


def _opened(path: str | Path) -> BinaryIO | gzip.GzipFile:
    """A file, which may be compressed."""
    with open(path, "rb") as file:
        compressed = file.read(2) == b"\x1f\x8b"
    return gzip.open(path) if compressed else open(path, "rb")


def blocks(path: str | Path) -> Generator[Block]:
    """The frames of a dump that have grains, one after the other, not parsed.

    Raises
    ------
    ValueError
        If it is no text dump, or is cut off. The caller names the file.
    OSError
        If it cannot be read.
    """
    try:
        with _opened(path) as file, io.TextIOWrapper(file, encoding="utf-8") as lines:
            yield from _blocks(lines)
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise ValueError(f"cannot be read: {error}") from None
    except UnicodeDecodeError:
        raise ValueError("must be a text dump of LAMMPS or LIGGGHTS") from None


def _blocks(lines: Iterable[str]) -> Iterator[Block]:
    lines = iter(lines)
    items: Items = {}
    count, units = 0, None
    for line in filter(str.strip, lines):
        head, _, title = line.strip().partition(" ")
        if head != "ITEM:":
            raise ValueError("must be a text dump of LAMMPS or LIGGGHTS")
        kind = next((item for item in ITEMS if title.startswith(item)), title)
        items[kind] = title[len(kind) :].split(), list(islice(lines, ITEMS.get(kind, 1)))
        if kind == "UNITS":
            units = "".join(items[kind][1]).strip()
        if kind == "ATOMS":
            words = "".join(items.get("NUMBER OF ATOMS", ([], []))[1]).split()
            n = int(words[0]) if words and words[0].isdecimal() else -1
            rows = list(islice(lines, max(n, 0)))
            if n < 0 or len(rows) < n:
                raise ValueError(f"its frame {count + 1} is cut off")
            if rows:
                yield items, rows, units
                count += 1
            items = {}
    if count == 0:
        raise ValueError("must have a frame with ITEM: ATOMS and grains")


def parsed(block: Block) -> DumpFrame:
    """The numbers of a frame. Raises a ValueError if there are others."""
    import pandas as pd

    items, rows, units = block
    names = items["ATOMS"][0]
    low, high, tilt, sides = _parsed_box(items)
    if len(set(names)) < len(names) or len(rows[0].split()) != len(names):
        raise ValueError(f"has {len(rows[0].split())} columns for the names {' '.join(names)[:100]}")
    try:
        step = int("".join(items["TIMESTEP"][1]))
        table = pd.read_csv(io.StringIO("".join(rows)), sep=r"\s+", header=None, names=names, index_col=False)
        columns = {name: table[name].to_numpy(float) for name in COLUMNS if name in names}
    except (ValueError, TypeError, OverflowError, KeyError):
        raise ValueError("has a frame that is not numbers") from None
    numbers = [low, high, *([] if tilt is None else [tilt]), *columns.values()]
    if not (high > low).all() or not all(np.isfinite(values).all() for values in numbers):
        raise ValueError(f"has missing numbers in the frame of step {step}")
    shaped = next((name for name in names if name in SHAPES), None)
    types = table["type"].astype(str).tolist() if "type" in names else None
    return DumpFrame(step, low, high, sides, tilt, columns, types, len(rows), units, shaped)


def _parsed_box(items: Items) -> tuple[Floats, Floats, Floats | None, tuple[str, ...]]:
    """Limits, tilts and sides of the box."""
    words, lines = items.get("BOX BOUNDS", ([], []))
    if words[:2] == ["abc", "origin"]:
        raise ValueError("must have a box along the axes, or one tilted along x, not a general triclinic one")
    tilts = words[:3] == ["xy", "xz", "yz"]
    sides = tuple(words[3:] if tilts else words) or ("pp",) * 3
    if len(sides) != 3:
        raise ValueError(f"must have the sides of three axes, such as pp ff pp, not {' '.join(sides)[:40]}")
    try:
        limits = np.array([line.split() for line in lines], float).reshape(3, 3 if tilts else 2)
    except ValueError:
        raise ValueError("has limits of its box that are not numbers") from None
    low, high = limits[:, 0].copy(), limits[:, 1].copy()
    if not tilts:
        return low, high, None, sides
    xy, xz, yz = tilt = limits[:, 2].copy()
    for k, ends in enumerate(([0.0, xy, xz, xy + xz], [0.0, yz])):
        low[k] -= min(ends)
        high[k] -= max(ends)
    return low, high, tilt, sides


# --- as arguments of a system -----------------------------------------------------------------------------------


def read(path: Path, frame: int) -> Found:
    if frame < -1:  # count first: the frames may be larger than the memory
        count = sum(1 for _ in blocks(path))
        check_frame(frame, count)
        frame += count
    count = 0
    for count, block in enumerate(blocks(path), 1):
        if frame in (count - 1, -1):
            last = block
        if count == frame + 1:
            break
    check_frame(frame, count)
    return as_found(parsed(last))


def frames(path: Path) -> Iterator[Found]:
    """All frames, one after the other."""
    return (as_found(parsed(block)) for block in blocks(path))


def as_found(frame: DumpFrame) -> Found:
    """The arguments of a system. Grains are in the order of their ids."""
    if frame.shaped:
        raise ValueError(f"ITEM: ATOMS: got the column {frame.shaped}, must be of spheres")
    d = 2 if _is_plane(frame) else 3
    positions, end = _placed(frame, d)
    arguments = {"positions": positions} | _bodies(frame, d)
    for name, values in (
        ("velocities", frame.vectors(["vx", "vy", "vz"][:d])),
        ("unfolded", _unfolded(frame, d)),
    ):
        if values is not None:
            arguments[name] = values
    ids = frame.columns.get("id")
    order = np.arange(frame.count) if ids is None else sorted_by_id(ids)
    arguments = {name: values[order] for name, values in arguments.items()}
    edges = (frame.high - frame.low)[:d]
    scale = float(edges.max()) if "s" in end else 1.0
    rounding = rounding_of(frame.columns[axis + end] for axis in "xyz"[:d]) * scale
    if "radius" in arguments:
        rounding += rounding_of([arguments["radius"]])
    return Found(
        arguments | {"box": edges},
        rounding=rounding,
        units=frame.units,
        types=None if frame.types is None else [frame.types[k] for k in order],
        sides=frame.sides[:d],
        tilt=frame.tilt,
        is_folded=False,
    )


def _placed(frame: DumpFrame, d: int) -> tuple[Floats, str]:
    """Positions from the lower corner of the box, and the end of the names of their columns."""
    place = frame.positions(d)
    if place is None:
        raise ValueError("ITEM: ATOMS: must have the columns x y z, xs ys zs, xu yu zu or xsu ysu zsu")
    positions, end = place[0] - frame.low[:d], place[1]
    if frame.tilt is None:
        return positions, end
    if "u" in end:
        raise ValueError("ITEM: ATOMS: must have the columns x y z or xs ys zs in a tilted box, not xu yu zu")
    if end:  # along the edges of the tilted box
        shares = positions / (frame.high - frame.low)[:d]
        positions[:, 0] += shares[:, 1:] @ frame.tilt[: d - 1]
        if d == 3:
            positions[:, 1] += shares[:, 2] * frame.tilt[2]
    return positions, end


def _unfolded(frame: DumpFrame, d: int) -> Floats | None:
    """Positions along unfolded paths, in the coordinates of the dump; None if the frame does not have them."""
    low, edges = frame.low[:d], (frame.high - frame.low)[:d]
    if frame.tilt is not None:
        return None
    for end, scale, origin in (("u", np.ones(d), np.zeros(d)), ("su", edges, low)):
        vectors = frame.vectors([axis + end for axis in "xyz"[:d]])
        if vectors is not None:
            return origin + vectors * scale
    images = frame.vectors([f"i{axis}" for axis in "xyz"[:d]])
    return None if images is None else low + _placed(frame, d)[0] + images * edges


def _bodies(frame: DumpFrame, d: int) -> dict[str, Floats]:
    """Sizes, masses and spins, as far as the frame has them."""
    columns = frame.columns
    bodies = {name: columns[name] for name in ("radius", "inertia_factor") if name in columns}
    if "radius" not in columns and "diameter" in columns:
        bodies["radius"] = 0.5 * columns["diameter"]
    kind = next((name for name in ("mass", "density") if name in columns), None)
    if kind:
        bodies[kind] = columns[kind]
    for name, argument in (("omega", "angular_velocities"), ("angmom", "angular_momenta")):
        needed = [name + axis for axis in ("xyz" if d == 3 else "z")]
        present = [name + axis for axis in "xyz" if name + axis in columns]
        if not present:
            continue
        if not set(needed) <= set(present):
            raise ValueError(
                f"ITEM: ATOMS: got {' '.join(present)}, must have {' '.join(needed)} or none of them"
            )
        vectors = frame.vectors(needed)
        assert vectors is not None
        return bodies | {argument: vectors if d == 3 else vectors[:, 0]}
    return bodies


def _is_plane(frame: DumpFrame) -> bool:
    """Whether the grains are disks: without z, or at rest in the plane z = 0 of a periodic box, as LAMMPS has them."""
    place = frame.positions(3)
    if place is None:
        return frame.positions(2) is not None
    thick = float(frame.high[2] - frame.low[2])
    out = ("vz", "omegax", "omegay", "angmomx", "angmomy")
    still = all(not frame.columns[name].any() for name in out if name in frame.columns)
    return bool(frame.periodic[2] and still and (np.abs(place[0][:, 2]) <= IN_PLANE * thick).all())
