"""Clumps of LIGGGHTS: the volume of overlapping spheres, of which ``particletemplate/multisphere`` makes one body.

Format: LIGGGHTS' fix_particletemplate_multisphere. The code finds the volume with random points (``ntry``).
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from .commands import text_of

#: The style of the fix, and lines across a clump along each axis, on which the lengths within its spheres are summed.
STYLE: Final = "particletemplate/multisphere"
LINES: Final = 200
#: What the code prints of a template, within how many lines below it, and the word before it in a statement.
PRINTED: Final = re.compile(r"radius of bounding sphere = (\d\S*), radius of equivalent sphere = (\d\S*)")
PRINTED_WITHIN: Final = 8
PRINTED_RADII: Final = "(printed_radii)"
#: Half the extent of a clump over the radius of the sphere of its volume, up to which it counts as round.
ROUND: Final = 1.3
MAX_SPHERES: Final = 2000

Spheres = NDArray[np.float64]  #: (n, 4): x, y, z, radius


def spheres(words: Sequence[str], folder: Path | None) -> Spheres:
    """The spheres of a template, from its words or from the file that it names; a ValueError if they are not known.

    ``nspheres N … spheres x1 y1 z1 r1 …``, or ``spheres file NAME scale S``.
    """
    words = [*words, "", "", "", "", ""]
    count = words[words.index("nspheres") + 1] if "nspheres" in words else ""
    number = int(count) if count.isdecimal() and len(count) < 5 else 0
    if "spheres" not in words or not 0 < number <= MAX_SPHERES:
        raise ValueError("spheres")
    at = words.index("spheres") + 1
    if words[at] != "file":
        return checked(np.array(words[at : at + 4 * number], float).reshape(number, 4))
    scale = float(words[at + 3]) if words[at + 2] == "scale" else 1.0
    text = None if folder is None else text_of(folder / words[at + 1])
    if text is None or not scale > 0.0:
        raise ValueError("file")
    rows = [line.partition("#")[0].split() for line in text.splitlines()]
    table = np.array([row[:4] for row in rows if row][:number], float)
    if table.shape != (number, 4):
        raise ValueError("rows")
    return checked(scale * table)


def checked(table: Spheres) -> Spheres:
    """The same spheres if all are finite and have a radius."""
    if not np.isfinite(table).all() or not (table[:, 3] > 0.0).all():
        raise ValueError("spheres")
    return table


def volume(table: Spheres) -> float:
    """Volume of the union of spheres: exact along lines, which stand at the middles of a grid."""
    low = (table[:, :3] - table[:, 3:]).min(axis=0)
    high = (table[:, :3] + table[:, 3:]).max(axis=0)
    steps = (high - low)[1:] / LINES
    y, z = (low[k + 1] + steps[k] * (np.arange(LINES) + 0.5) for k in range(2))
    total = 0.0
    for line in y:
        squares = table[:, 3] ** 2 - (line - table[:, 1]) ** 2
        halves = np.sqrt(np.maximum(squares[:, None] - (z - table[:, 2][:, None]) ** 2, 0.0))
        starts = table[:, 0][:, None] - halves
        order = np.argsort(starts, axis=0)
        starts, ends = (np.take_along_axis(x, order, 0) for x in (starts, starts + 2.0 * halves))
        before = np.maximum.accumulate(ends, axis=0)[:-1]
        starts[1:] = np.maximum(starts[1:], before)
        total += float(np.maximum(ends - starts, 0.0).sum())
    return total * float(math.prod(steps))


def radii(words: Sequence[str], folder: Path | None) -> tuple[float, float]:
    """Radius of the sphere of the volume of a template, and half its extent; a log has them after ``PRINTED_RADII``."""
    if PRINTED_RADII in words[:-2]:
        at = [*words].index(PRINTED_RADII) + 1
        return float(words[at]), float(words[at + 1])
    table = spheres(words, folder)
    return (0.75 / math.pi * volume(table)) ** (1.0 / 3.0), half_extent(table)


def radii_in_log(words: Sequence[str], log: Path) -> tuple[float, float]:
    """The same radii as the log of an earlier run of this script prints them; a ValueError if it does not."""
    lines = (text_of(log) or "").splitlines()
    for k, line in enumerate(lines):
        if STYLE in line and tuple(line.partition("#")[0].split()) == tuple(words):
            return radii(with_printed(tuple(words), lines[k + 1 : k + 1 + PRINTED_WITHIN]), None)
    raise ValueError("log")


def half_extent(table: Spheres) -> float:
    """Half the largest distance between two points of a clump."""
    ends = [np.linalg.norm(table[:, :3] - sphere[:3], axis=1) + table[:, 3] + sphere[3] for sphere in table]
    return 0.5 * float(np.max(ends))


def with_printed(words: tuple[str, ...], lines: Sequence[str]) -> tuple[str, ...]:
    """The words of a statement, with the radii that the code prints below a template of clumps."""
    matches = [match for line in lines if (match := PRINTED.search(line))] if STYLE in words else []
    return (*words, PRINTED_RADII, matches[0][2], matches[0][1]) if matches else words
