"""Read text dumps of LAMMPS and LIGGGHTS, and compute what they say about the gas: packing, temperature, contacts."""

from __future__ import annotations

import gzip
import io
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TextIO

import numpy as np
from numpy.typing import NDArray

from ..support import validation

if TYPE_CHECKING:
    import pandas as pd

Floats = NDArray[np.float64]

#: Largest number of frames that are analysed, equally spaced over the file.
MOST_FRAMES: Final = 20
#: Shares of impacts with lower speeds, at which speeds are given.
QUANTILES: Final = (0.1, 0.5, 0.9)


@dataclass(frozen=True)
class Frame:
    """One frame of a dump, in its own units."""

    step: int
    low: Floats  #: (3,)
    high: Floats  #: (3,)
    periodic: tuple[bool, ...]
    grains: pd.DataFrame  #: one row for each grain


@dataclass(frozen=True)
class State:
    """State of the grains in a frame, in the units of the dump; part of :func:`hardlimit.check`'s result."""

    step: int
    grains: int
    packing_fraction: float | None  #: None without radii
    temperature: (
        float | None
    )  #: mean square of a velocity component about the mean velocity; None without velocities
    mean_diameter: float | None
    largest_overlap: float | None  #: over the smaller radius; None without positions or radii
    coordination: float | None  #: mean number of contacts of a grain
    in_several_contacts: float | None  #: share of grains with two contacts or more

    @property
    def mean_speed(self) -> float | None:
        """Mean normal impact speed of equal grains, √(πT)."""
        return None if self.temperature is None else math.sqrt(math.pi * self.temperature)

    @property
    def speeds(self) -> tuple[float, ...]:
        """Normal impact speeds below which 10, 50 and 90 % of the impacts are.

        Impacts of equal Maxwellian grains have normal speeds of the density ∝ g exp(−g²/4T).
        """
        t = self.temperature
        return () if not t else tuple(math.sqrt(-4.0 * t * math.log1p(-share)) for share in QUANTILES)


def read(path: str | Path) -> list[Frame]:
    """The frames of a dump, at most ``MOST_FRAMES``.

    Raises
    ------
    ValueError
        If it is no text dump, is cut off or triclinic.
    """
    name = str(path)
    try:
        with _opened(path) as lines:
            count = sum(1 for _ in _frames(lines, name, lambda k: False))
        chosen = {round(k) for k in np.linspace(0, count - 1, min(count, MOST_FRAMES))}
        with _opened(path) as lines:
            return [one for one in _frames(lines, name, chosen.__contains__) if one is not None]
    except (OSError, EOFError, UnicodeDecodeError) as error:
        because = getattr(error, "strerror", None) or str(error)
        raise ValueError(f"dump: got {validation.shown(name)}, cannot be read: {because}") from None


def _opened(path: str | Path) -> TextIO:
    if str(path).endswith(".gz"):
        return gzip.open(path, "rt", encoding="utf-8")
    return open(path, encoding="utf-8")


def _frames(lines: TextIO, name: str, wanted: Any) -> Iterator[Frame | None]:
    """Each frame of an open dump, None in place of those that are not wanted."""
    k = 0
    items: dict[str, tuple[list[str], list[str]]] = {}
    for line in lines:
        title = line.strip()
        if not title:
            continue
        if not title.startswith("ITEM:"):
            raise ValueError(
                f"dump: got {validation.shown(name)} with a line {validation.shown(title)}, "
                "must be a text dump of LAMMPS or LIGGGHTS"
            )
        kind = next(
            (one for one in ("BOX BOUNDS", "NUMBER OF ATOMS", "ATOMS") if title[5:].strip().startswith(one)),
            title[5:].strip(),
        )
        words = title[5:].strip()[len(kind) :].split()
        count = {"BOX BOUNDS": 3, "ATOMS": 0}.get(kind, 1)
        items[kind] = words, list(islice(lines, count))
        if kind == "ATOMS":
            yield _frame(items, words, lines, name) if wanted(k) else _skip(items, lines, name)
            items, k = {}, k + 1
    if k == 0:
        raise ValueError(f"dump: got {validation.shown(name)}, must have a frame with ITEM: ATOMS")


def _count(items: Mapping[str, tuple[list[str], list[str]]], name: str) -> int:
    try:
        return int(items["NUMBER OF ATOMS"][1][0])
    except (KeyError, IndexError, ValueError):
        raise ValueError(
            f"dump: got {validation.shown(name)}, must have ITEM: NUMBER OF ATOMS before the grains"
        ) from None


def _skip(items: Mapping[str, tuple[list[str], list[str]]], lines: TextIO, name: str) -> None:
    for _ in islice(lines, _count(items, name)):
        pass


def _frame(
    items: Mapping[str, tuple[list[str], list[str]]], columns: Sequence[str], lines: TextIO, name: str
) -> Frame:
    import pandas as pd

    count = _count(items, name)
    rows = list(islice(lines, count))
    sides, bounds = items.get("BOX BOUNDS", ([], []))
    if len(sides) > 3 or any(len(line.split()) > 2 for line in bounds):
        raise ValueError(f"dump: got {validation.shown(name)} of a triclinic box, must be an orthogonal box")
    try:
        limits = np.array([[float(word) for word in line.split()] for line in bounds])
        step = int(items.get("TIMESTEP", ([], ["0"]))[1][0])
        low, high = limits.reshape(3, 2).T
        grains = pd.read_csv(
            io.StringIO("".join(rows)), sep=r"\s+", header=None, names=list(columns), index_col=False
        )
    except (ValueError, IndexError) as error:
        raise ValueError(
            f"dump: got {validation.shown(name)}, cannot be read: {' '.join(str(error).split())[:100]}"
        ) from None
    numeric = grains[[c for c in grains if c in NUMERIC]].apply(pd.to_numeric, errors="coerce")
    if (
        len(grains) != count
        or count == 0
        or not np.isfinite(numeric.to_numpy()).all()
        or not (high > low).all()
    ):
        raise ValueError(
            f"dump: got {validation.shown(name)}, whose frame at step {step} is cut off or has no numbers"
        )
    grains[numeric.columns] = numeric
    periodic = tuple(side.startswith("p") for side in sides) if len(sides) == 3 else (True,) * 3
    return Frame(step, low, high, periodic, grains)


#: Columns that are used.
NUMERIC: Final = (
    *("x", "y", "z", "xs", "ys", "zs", "xu", "yu", "zu", "xsu", "ysu", "zsu"),
    *("vx", "vy", "vz", "radius", "diameter", "mass", "density"),
)


# --- the state ------------------------------------------------------------------------------------------------


def state(frame: Frame, radii: Mapping[str, float], dimension: int) -> State:
    """The state of a frame. ``radii`` has the radius of each type with one size, for dumps without radii."""
    grains = frame.grains
    radius = _radius(grains, radii)
    at = _positions(frame)[:, :dimension] if _positions(frame) is not None else None
    overlap = coordination = several = packing = None
    edges = (frame.high - frame.low)[:dimension]
    if radius is not None and (radius > 0.0).all():
        volume = math.pi * radius**2 if dimension == 2 else 4.0 / 3.0 * math.pi * radius**3
        packing = float(volume.sum() / np.prod(_extent(frame, at, radius, edges)))
        if at is not None:
            overlap, coordination, several = _contacts(at, radius, edges, frame.periodic[:dimension])
    temperature = None
    if {"vx", "vy", "vz"} <= set(grains) and len(grains) > 1:
        velocity = grains[["vx", "vy", "vz"]].to_numpy(float)[:, :dimension]
        mass = _mass(grains, radius)
        about = velocity - np.average(velocity, axis=0, weights=mass)
        temperature = float(np.average((about**2).sum(axis=1), weights=mass) / dimension)
    diameter = None if radius is None else 2.0 * float(radius.mean())
    return State(frame.step, len(grains), packing, temperature, diameter, overlap, coordination, several)


def _radius(grains: pd.DataFrame, radii: Mapping[str, float]) -> Floats | None:
    if "radius" in grains:
        return grains["radius"].to_numpy(float)
    if "diameter" in grains:
        return 0.5 * grains["diameter"].to_numpy(float)
    if "type" in grains and radii and (found := grains["type"].astype(str).map(dict(radii))).notna().all():
        return found.to_numpy(float)
    return None


def _mass(grains: pd.DataFrame, radius: Floats | None) -> Floats | None:
    """Masses as weights; those of one density if the dump has none."""
    found = grains["mass"].to_numpy(float) if "mass" in grains else None if radius is None else radius**3
    return found if found is not None and (found > 0.0).all() else None


def _positions(frame: Frame) -> Floats | None:
    """Positions, from scaled ones if the dump has no others."""
    for end in ("", "u"):
        plain, scaled = [c + end for c in "xyz"], [c + "s" + end for c in "xyz"]
        if set(plain) <= set(frame.grains):
            return frame.grains[plain].to_numpy(float)
        if set(scaled) <= set(frame.grains):
            return frame.low + frame.grains[scaled].to_numpy(float) * (frame.high - frame.low)
    return None


def _extent(frame: Frame, at: Floats | None, radius: Floats, edges: Floats) -> Floats:
    """Edges of the volume that the grains fill: the box, but between the outermost grains along axes with ends."""
    if at is None:
        return edges
    filled = (at + radius[:, None]).max(axis=0) - (at - radius[:, None]).min(axis=0)
    return np.where(frame.periodic[: len(edges)], edges, np.minimum(filled, edges))


def _contacts(
    at: Floats, radius: Floats, edges: Floats, periodic: Sequence[bool]
) -> tuple[float, float, float]:
    """Largest overlap over the smaller radius, mean number of contacts, share of grains with several."""
    from scipy.spatial import cKDTree

    box = np.where(periodic, edges, 0.0)
    inside = at - at.min(axis=0)
    inside = np.where(periodic, np.mod(inside, edges), inside)
    inside = (
        np.where(inside >= edges, 0.0, inside)
        if all(periodic)
        else np.where(np.logical_and(periodic, inside >= edges), 0.0, inside)
    )
    pairs = cKDTree(inside, boxsize=box).query_pairs(2.0 * float(radius.max()), output_type="ndarray")
    i, j = pairs.T
    apart = inside[i] - inside[j]
    apart = np.where(periodic, apart - edges * np.round(apart / edges), apart)
    overlap = radius[i] + radius[j] - np.sqrt((apart**2).sum(axis=1))
    i, j, overlap = i[overlap > 0.0], j[overlap > 0.0], overlap[overlap > 0.0]
    each = np.bincount(np.concatenate([i, j]), minlength=len(radius))
    deepest = float((overlap / np.minimum(radius[i], radius[j])).max(initial=0.0))
    return deepest, float(each.mean()), float((each > 1).mean())
