"""LAMMPS data files with ``atom_style sphere``. No library reads or writes this style.

Numbers are in SI units, unless the first line names others, as that of LAMMPS' ``write_data`` does. The format has
diameters and densities. Walls, gravity and shear belong to the input script of LAMMPS; we write them in the first line,
which LAMMPS skips. A sheared box is tilted by the displacement of its images.

LAMMPS' spheres have the moment of inertia 2/5 m R², and 1/2 m R² in two dimensions with the word ``disc`` of
``fix nve/sphere``; the format has no other ones.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from ...contact.balls import ball_masses
from ...support import validation
from .. import spins
from .frame import Append, Floats, Found, Frame, boundary_of, read_table, spins_of, three, write_rows

_MARK: Final = re.compile(
    r"LAMMPS data file by hardlimit, SI units, dimension ([23]), boundary ([pfl ]+), gravity ([^,]+)"
    r"(?:, shear rate ([^,]+), displacement ([^,]+))?(, spins)?"
)


@contextmanager
def appender(path: Path) -> Iterator[Append]:
    """Create a file for one frame; a second frame is refused because the format has no trajectories."""
    with open(path, "wb") as file:

        def append(frame: Frame) -> None:
            if file.tell():
                raise ValueError("got a second frame, must be one in LAMMPS data; .gsd and .xyz hold more")
            _write(file, frame, np.ones(len(frame.radius), np.int64))

        yield append


def write(path: Path, frame: Frame, types: NDArray[np.int64]) -> None:
    """Write particles with their types, which are numbered from 1."""
    with open(path, "wb") as file:
        _write(file, frame, types)


def _write(file: BinaryIO, frame: Frame, types: NDArray[np.int64]) -> None:
    if frame.walls:
        raise ValueError("walls: got moving walls, must be none in LAMMPS data; .xyz and .gsd hold them")
    if frame.thermostat is not None:
        raise ValueError("thermostat: got one, must be none in LAMMPS data; .xyz and .gsd hold it")
    turning = _spins(frame)
    file.write(_header(frame, int(types.max())).encode())
    density, n = densities(frame.mass, frame.radius), len(frame.mass)
    numbers = [f"{i} {kind}" for i, kind in enumerate(types.tolist(), 1)]
    file.write(b"\nAtoms # sphere\n\n")
    write_rows(file, numbers, 2.0 * frame.radius, density, three(frame.positions))
    file.write(b"\nVelocities\n\n")
    write_rows(file, map(str, range(1, n + 1)), three(frame.velocities), turning)


def _spins(frame: Frame) -> Floats:
    """Angular velocities (N, 3), of particles whose moment of inertia the format has."""
    n, d = frame.positions.shape
    if frame.angular_velocities is None or frame.inertia_factor is None:
        return np.zeros((n, 3))
    other = frame.inertia_factor != spins.SOLID[d]
    if other.any():
        raise ValueError(
            f"inertia_factor: got {frame.inertia_factor[int(np.argmax(other))]:.16g}, must be {spins.SOLID[d]:g} in "
            f"{d} dimensions in LAMMPS data; .xyz and .gsd hold others"
        )
    return spins.for_core(frame.angular_velocities)


def _header(frame: Frame, types: int) -> str:
    d = len(frame.box)
    wraps, shear = frame.sides
    sides = ["p" if flag else "f" for flag in wraps]
    gravity, flow = " ".join(map(repr, frame.gravity.tolist())), ""
    if shear:
        axis, rate, shift = shear
        sides[axis], flow = "l", f", shear rate {rate!r}, displacement {shift!r}"
    lines = [
        f"LAMMPS data file by hardlimit, SI units, dimension {d}, boundary {' '.join(sides)}, gravity {gravity}{flow}"
        + ("" if frame.angular_velocities is None else ", spins"),
        "",
        f"{len(frame.positions)} atoms",
        f"{types} atom types",
        "",
    ]
    half = float(frame.radius.max())
    limits = [(0.0, float(edge)) for edge in frame.box] + [(-half, half)] * (3 - d)
    lines += [f"{low!r} {high!r} {axis}lo {axis}hi" for axis, (low, high) in zip("xyz", limits, strict=True)]
    if shear:
        tilt, edge = [0.0] * 3, float(frame.box[0])
        tilt[axis - 1] = shift - (edge if shift > 0.5 * edge else 0.0)
        lines.append(f"{' '.join(map(repr, tilt))} xy xz yz")
    return "\n".join(lines) + "\n"


def densities(mass: Floats, radius: Floats) -> Floats:
    """Densities [kg/m³] that give these masses, to the last bit if such a density exists."""
    rho = mass / (4.0 / 3.0 * math.pi * radius**3)
    best = rho.copy()
    exact = ball_masses(rho, radius) == mass
    for direction in (-math.inf, math.inf):
        near = rho
        for _ in range(4):
            near = np.nextafter(near, direction)
            hit = ~exact & (ball_masses(near, radius) == mass)
            best[hit] = near[hit]
            exact |= hit
    return best


def read(path: Path, frame: int) -> Found:
    if frame not in (0, -1):
        raise ValueError(f"frame: got {frame}, must be 0 or -1, because the format holds one frame")
    try:
        lines = path.read_bytes().decode().splitlines()
    except UnicodeDecodeError:
        raise ValueError("not UTF-8 text") from None
    header, sections = _parts(lines)
    mark = _MARK.match(lines[0]) if lines else None
    d = int(mark[1]) if mark else 3
    n = _count(header)
    limits = _limits(header)
    atoms = _table("Atoms", sections, n, (7, 10))
    speeds = _table("Velocities", sections, n, (7, 4))
    if np.any(atoms[:, 4 + d : 7]) or np.any(speeds[:, 1 + d : 4]):
        raise ValueError("dimension: got 2, must be 3 for particles with z ≠ 0")
    arguments = {
        "positions": atoms[:, 4 : 4 + d] - limits[:d, 0],
        "velocities": speeds[:, 1 : 1 + d],
        "radius": 0.5 * atoms[:, 2],
        "density": atoms[:, 3],
        "box": limits[:d, 1] - limits[:d, 0],
    }
    turning = speeds[:, 4:7]
    if bool(mark and mark[6]) or np.any(turning):
        if turning.shape[1] == 0:
            raise ValueError("Velocities: got 4 columns, must be 7 for particles with spins")
        arguments["angular_velocities"] = spins_of(turning, d)
    tilt = _tilt(header)
    if mark:
        if tilt is not None and not mark[4]:
            raise ValueError("header: got a tilted box, must be a box along the axes without shear")
        return Found(arguments | _from_mark(mark, d), units="si")
    types = [f"{kind:.16g}" for kind in atoms[:, 1].tolist()]
    named = re.search(r"\bunits = (\w+)", lines[0] if lines else "")
    units = named[1] if named else None
    return Found(arguments, units=units, types=types, tilt=tilt, is_folded=False)


def frames(path: Path) -> Iterator[Found]:
    """The only frame."""
    yield read(path, 0)


def _parts(lines: list[str]) -> tuple[list[str], dict[str, tuple[str, list[str]]]]:
    """The header, and for each section the comment after its title and its lines."""
    header: list[str] = []
    sections: dict[str, tuple[str, list[str]]] = {}
    here = header
    for line in lines[1:]:
        text, _, comment = line.partition("#")
        if re.match(r"[A-Z]", text):
            title = text.strip()
            if title in sections:
                raise ValueError(f"{title}: got two sections, must be one")
            here = []
            sections[title] = (comment.strip(), here)
        elif text.strip():
            here.append(text)
    return header, sections


def _count(header: Iterable[str]) -> int:
    counts = [match[1] for line in header if (match := re.fullmatch(r"\s*(\d{1,12})\s+atoms\s*", line))]
    if len(counts) != 1 or int(counts[0]) == 0:
        raise ValueError("header: must contain the number of atoms once, such as '1000 atoms'")
    return int(counts[0])


def _tilt(header: Iterable[str]) -> Floats | None:
    """Tilts xy, xz and yz of the box, or None."""
    for line in header:
        if re.search(r"\b(avec|bvec|cvec)\b", line):
            raise ValueError(
                "header: got a general triclinic box, must be a box along the axes, or tilted along x"
            )
        match = re.fullmatch(r"\s*(\S+)\s+(\S+)\s+(\S+)\s+xy\s+xz\s+yz\s*", line)
        if match:
            return np.array([_float("xy xz yz", word) for word in match.groups()])
    return None


def _limits(header: Iterable[str]) -> Floats:
    """Lower and upper limits (3, 2) of the box."""
    limits: dict[str, list[float]] = {}
    for line in header:
        match = re.fullmatch(r"\s*(\S+)\s+(\S+)\s+([xyz])lo\s+\3hi\s*", line)
        if match:
            limits[match[3]] = [_float(f"{match[3]}lo {match[3]}hi", word) for word in match.groups()[:2]]
    missing = [axis for axis in "xyz" if axis not in limits]
    if missing:
        raise ValueError(f"header: must contain a line such as '0 1 {missing[0]}lo {missing[0]}hi'")
    return np.array([limits[axis] for axis in "xyz"])


def _float(name: str, word: str) -> float:
    try:
        return validation.number(name, float(word))
    except ValueError:
        raise ValueError(f"{name}: got {validation.shown(word)}, must be a finite number") from None


def _table(title: str, sections: dict[str, tuple[str, list[str]]], n: int, widths: tuple[int, ...]) -> Floats:
    """The rows of a section, sorted by the number of the atom."""
    if title not in sections:
        raise ValueError(f"{title}: missing, must hold one line for each atom")
    style, lines = sections[title]
    if style and title == "Atoms" and style != "sphere":
        raise ValueError(f"Atoms: got the style {validation.shown(style)}, must be sphere")
    if len(lines) != n:
        raise ValueError(f"{title}: got {len(lines)} lines, must be {n}, one for each atom")
    rows = read_table(title, lines)
    if rows.shape[1] not in widths:
        raise ValueError(
            f"{title}: got {rows.shape[1]} columns, must be {widths[0]}, as in atom_style sphere"
        )
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    if not np.all(np.diff(rows[:, 0]) > 0.0):
        raise ValueError(f"{title}: got an atom twice, must have a number of its own for each atom")
    return rows


def _from_mark(mark: re.Match[str], d: int) -> dict[str, Any]:
    """Walls, gravity and shear from the first line, which this package wrote."""
    sides, gravity = mark[2].split(), mark[3].split()
    if len(sides) != d or len(gravity) != d:
        raise ValueError("first line: must contain a boundary and a gravity for each axis")
    if sides.count("l") != (mark[4] is not None):
        raise ValueError(
            "first line: must contain a shear rate and a displacement for one boundary l, or no l"
        )
    shear = (
        (sides.index("l"), _float("shear rate", mark[4]), _float("displacement", mark[5]))
        if mark[4]
        else None
    )
    return {
        **boundary_of((side == "p" for side in sides), shear),
        "gravity": [_float("gravity", word) for word in gravity],
    }
