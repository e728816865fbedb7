"""Text dumps of LAMMPS and LIGGGHTS: what they say about the gas: packing, temperature, contacts."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..boxes.box import UNIT_BALL
from ..boxes.files import dump
from ..support import validation
from . import mixture

Floats = NDArray[np.float64]

#: Largest number of frames that are analysed, equally spaced over the file.
MAX_FRAMES: Final = 20
#: Shares of impacts with lower speeds, at which speeds are given.
QUANTILES: Final = (0.1, 0.5, 0.9)
#: Least width of the column of grains that is weighed between walls, in mean diameters and over that of the bed.
COLUMN, COLUMN_SHARE = 4.0, 1.0 / 3.0

Frame = dump.DumpFrame


@dataclass(frozen=True)
class State:
    """State of the grains in a frame of a dump; returned by :func:`hardlimit.check`.

    Impacts of equal grains with Maxwellian velocities have normal speeds g of the density ∝ g exp(−g²/4T): Chapman &
    Cowling, The Mathematical Theory of Non-uniform Gases (1970).
    """

    step: int  #: time step of the frame
    grains: int  #: number of grains
    packing_fraction: float | None  #: None without radii
    temperature: float | None  #: mean square of a velocity component about the mean; None without velocities
    mean_diameter: float | None  #: None without radii
    largest_overlap: float | None  #: over the smaller radius; None without positions or radii
    coordination: float | None  #: mean number of contacts of a grain
    in_several_contacts: float | None  #: share of grains with two contacts or more

    @property
    def mean_speed(self) -> float | None:
        """Mean normal impact speed of equal grains, √(πT)."""
        return None if self.temperature is None else math.sqrt(math.pi * self.temperature)

    @property
    def speeds(self) -> tuple[float, ...]:
        """Normal impact speeds below which 10, 50 and 90 % of the impacts are; empty without temperature."""
        t = self.temperature
        return () if not t else tuple(math.sqrt(-4.0 * t * math.log1p(-share)) for share in QUANTILES)


def read(path: str | Path) -> list[Frame]:
    """The frames of a dump, at most ``MAX_FRAMES``.

    Raises
    ------
    ValueError
        If it is no text dump, is cut off or triclinic.
    """
    name = validation.shown(str(path))
    try:
        count = sum(1 for _ in dump.blocks(path))
        chosen = {round(k) for k in np.linspace(0, count - 1, min(count, MAX_FRAMES))}
        frames = [dump.parsed(block) for k, block in enumerate(dump.blocks(path)) if k in chosen]
    except FileNotFoundError as error:
        raise validation.unreadable(path, error, "dump") from None
    except OSError as error:
        raise ValueError(f"dump: got {name}, cannot be read: {error.strerror or error}") from None
    except ValueError as error:
        raise ValueError(f"dump: got {name}, {error}") from None
    if any(frame.tilt is not None for frame in frames):
        raise ValueError(f"dump: got {name}, must have an orthogonal box, not a triclinic one")
    return frames


# --- the state ------------------------------------------------------------------------------------------------


def state(
    frame: Frame, radii: Mapping[str, float], dimension: int, densities: Mapping[str, float] = {}
) -> State:
    """The state of a frame.

    ``radii`` and ``densities`` have those of each type with one size and with one density, for dumps without them.
    Without masses and densities, temperature and mean velocity are those of grains of equal density.
    """
    radius, place = _radius(frame, radii), frame.positions(dimension)
    at = None if place is None else place[0]
    edges, periodic = (frame.high - frame.low)[:dimension], np.array(frame.periodic[:dimension])
    overlap = coordination = several = packing = temperature = None
    if radius is not None:
        volume = math.pi * radius**2 if dimension == 2 else 4.0 / 3.0 * math.pi * radius**3
        filled = edges
        if at is not None:
            # Along an axis with ends, the volume is that between the outermost grains.
            reach = (at + radius[:, None]).max(axis=0) - (at - radius[:, None]).min(axis=0)
            filled = np.where(periodic, edges, np.minimum(reach, edges))
            overlap, coordination, several = contacts(at, radius, edges, periodic)
        packing = float(volume.sum() / np.prod(filled))
    names = ("vx", "vy", "vz")[:dimension]
    if all(name in frame.columns for name in names) and frame.count > 1:
        velocity = np.stack([frame.columns[name] for name in names], axis=1)
        mass = _masses(frame, radius, densities)
        about = velocity - np.average(velocity, axis=0, weights=mass)
        temperature = float(np.average((about**2).sum(axis=1), weights=mass) / dimension)
    diameter = None if radius is None else 2.0 * float(radius.mean())
    return State(
        step=frame.step,
        grains=frame.count,
        packing_fraction=packing,
        temperature=temperature,
        mean_diameter=diameter,
        largest_overlap=overlap,
        coordination=coordination,
        in_several_contacts=several,
    )


class Bed(NamedTuple):
    """A bed of grains under gravity."""

    height: float
    mass: float  #: over the area below it
    walled: bool = False  #: whether side walls, which may carry a part of the weight, are around it


def bed(
    frame: Frame,
    radii: Mapping[str, float],
    densities: Mapping[str, float],
    down: Sequence[float],
    dimension: int,
    fixed: Collection[str] = (),
) -> Bed | None:
    """The bed of a frame; None if it is not known.

    ``down``: direction of gravity, which must be along an axis. ``fixed``: types that do not weigh on others. Along an
    axis with ends, a column above the deepest grains is weighed, since a cone or a cylinder does not fill its corners.
    """
    axes = [k for k in range(dimension) if abs(down[k]) > 1.0 - 1e-9]
    radius, place = _radius(frame, radii), frame.positions(dimension)
    kinds = np.array(frame.types or [""] * frame.count)
    moving = ~np.isin(kinds, list(fixed))
    if len(axes) != 1 or radius is None or place is None or not moving.any():
        return None
    mass = frame.columns.get("mass")
    if mass is None:
        density = frame.columns.get("density", np.array([densities.get(name, 0.0) for name in kinds]))
        mass = 4.0 / 3.0 * math.pi * radius**3 * density
    mass, radius, at = mass[moving], radius[moving], place[0][moving]
    edges, diameter = (frame.high - frame.low)[:dimension], 2.0 * float(radius.mean())
    low, high = (at - radius[:, None]).min(axis=0), (at + radius[:, None]).max(axis=0)
    across = np.delete(np.arange(dimension), axes[0])
    ends = across[~np.array(frame.periodic[:dimension])[across]]
    depth = at[:, axes[0]] * down[axes[0]]
    width = np.minimum(np.maximum(COLUMN * diameter, COLUMN_SHARE * (high - low)), high - low)
    middle = at[depth > depth.max() - diameter].mean(axis=0)
    middle = np.clip(middle, low + 0.5 * width, high - 0.5 * width)
    inside = (np.abs(at - middle) <= 0.5 * width)[:, ends].all(axis=1)
    area = float(np.prod(np.where(np.isin(across, ends), width[across], edges[across])))
    if not (mass > 0.0).all() or not area > 0.0:
        return None
    height = float((high - low)[axes[0]])
    return Bed(height, float(mass[inside].sum()) / area, len(ends) > 0)


def kinds(frame: Frame, radii: Mapping[str, float], fixed: Collection[str] = ()) -> tuple[mixture.Kind, ...]:
    """The kinds of the grains that move; empty if they are not known or all equal. ``fixed``: types that do not."""
    radius = _radius(frame, radii)
    if radius is None or frame.types is None:
        return ()
    moving = ~np.isin(frame.types, list(fixed))
    types = np.array(frame.types)[moving].tolist()
    mass, own = frame.columns.get("mass"), frame.columns.get("density")
    if mass is not None:
        own = mass / (UNIT_BALL[3] * radius**3)
    return mixture.of_grains(types, radius[moving], None if own is None else own[moving]) if types else ()


def sizes(frames: Sequence[Frame]) -> dict[str, tuple[tuple[float, float], tuple[float, float] | None]]:
    """Radii, and masses if the dump has them, of the smallest and the largest grain of each type.

    Without a column ``type``, the type is an empty text.
    """
    ranges: dict[str, tuple[tuple[float, float], tuple[float, float] | None]] = {}
    for frame in frames:
        radius = _radius(frame, {})
        if radius is None:
            continue
        mass = frame.columns.get("mass")
        if mass is None and "density" in frame.columns:
            mass = 4.0 / 3.0 * math.pi * radius**3 * frame.columns["density"]
        types = np.array(frame.types or [""] * frame.count)
        for name in dict.fromkeys(types.tolist()):
            chosen = types == name
            each = radius[chosen]
            pairs = list(zip(each, each if mass is None else mass[chosen], strict=True))
            if name in ranges:
                radii, masses = ranges[name]
                pairs += list(zip(radii, masses or radii, strict=True))
            (r, m), (r_last, m_last) = min(pairs), max(pairs)
            masses = None if mass is None or m <= 0.0 else (float(m), float(m_last))
            ranges[name] = (float(r), float(r_last)), masses
    return ranges


def largest_type(frames: Sequence[Frame]) -> int:
    """The largest type of a grain; 0 without numbered types."""
    return max(
        (int(kind) for frame in frames for kind in set(frame.types or ()) if kind.isdecimal()), default=0
    )


def _radius(frame: Frame, radii: Mapping[str, float]) -> Floats | None:
    """Radii of all grains; None if one is not known or not positive."""
    columns = frame.columns
    if "radius" in columns:
        sizes = columns["radius"]
    elif "diameter" in columns:
        sizes = 0.5 * columns["diameter"]
    else:
        sizes = np.array([radii.get(name, 0.0) for name in frame.types or [""]])
    return sizes if (sizes > 0.0).all() else None


def _masses(frame: Frame, radius: Floats | None, densities: Mapping[str, float]) -> Floats:
    """Masses of all grains, up to a common factor."""
    if "mass" in frame.columns:
        return frame.columns["mass"]
    if radius is None:
        return np.ones(frame.count)
    density = frame.columns.get(
        "density", np.array([densities.get(name, 0.0) for name in frame.types or [""]])
    )
    return radius**3 * density if (density > 0.0).all() else radius**3


def contacts(
    at: Floats, radius: Floats, edges: Floats, periodic: NDArray[np.bool_]
) -> tuple[float, float, float]:
    """Largest overlap over the smaller radius, mean number of contacts, share of grains with several."""
    from scipy.spatial import cKDTree

    inside = at - at.min(axis=0)
    inside = np.where(periodic, np.mod(inside, edges), inside)
    inside[:, periodic] = np.where(inside < edges, inside, 0.0)[:, periodic]  # rounding of mod
    tree = cKDTree(inside, boxsize=np.where(periodic, edges, 0.0))
    i, j = tree.query_pairs(2.0 * float(radius.max()), output_type="ndarray").T
    apart = inside[i] - inside[j]
    apart -= np.where(periodic, edges * np.round(apart / edges), 0.0)
    overlap = radius[i] + radius[j] - np.sqrt((apart**2).sum(axis=1))
    touching = overlap > 0.0
    i, j, overlap = i[touching], j[touching], overlap[touching]
    each = np.bincount(np.concatenate([i, j]), minlength=len(radius))
    deepest = float((overlap / np.minimum(radius[i], radius[j])).max(initial=0.0))
    return deepest, float(each.mean()), float((each > 1).mean())
