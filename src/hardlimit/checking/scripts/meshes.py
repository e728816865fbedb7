"""Meshes in files of the STL format, ASCII or binary: their corners and area."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

Triangles = NDArray[np.float64]  #: (n, 3, 3): corner and axis

LARGEST: Final = 20_000_000  #: bytes of a file
FLAT: Final = 1e-5  #: height of a mesh over its size up to which it is plane
MERGED: Final = 1e-6  #: distance over the size of a mesh up to which corners are one
HEADER: Final = 84  #: bytes before the triangles of a binary file
BINARY: Final = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
VERTEX: Final = re.compile(rb"vertex\s+(\S+)\s+(\S+)\s+(\S+)")


def read(path: Path) -> Triangles | None:
    """The triangles of a file as they stand in it; None if it cannot be read."""
    try:
        if not path.is_file() or path.stat().st_size > LARGEST:
            return None
        content = path.read_bytes()
        count = int.from_bytes(content[80:HEADER], "little")
        if count and len(content) >= HEADER + count * BINARY.itemsize and not VERTEX.search(content):
            corners = np.frombuffer(content, BINARY, count, HEADER)["corners"].astype(float)
        else:
            corners = np.array(VERTEX.findall(content)).astype(float).reshape(-1, 3, 3)
    except (OSError, ValueError):
        return None
    return corners if len(corners) and np.isfinite(corners).all() else None


def area_across(corners: Triangles, along: int) -> float:
    """Area of a mesh as seen along an axis: of its triangles that face one way, the larger one of both."""
    normals = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, along]
    return float(max(normals[normals > 0.0].sum(), -normals[normals < 0.0].sum()))


def plane(corners: Triangles) -> tuple[tuple[float, ...], float] | None:
    """The unit normal and the area of a mesh in one plane; None for other meshes."""
    normals = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    normals = normals[areas > 0.0] / areas[areas > 0.0, None]
    if not len(normals):
        return None
    heights = (corners.reshape(-1, 3) - corners[0, 0]) @ normals[0]
    flat = np.ptp(heights) <= FLAT * np.ptp(corners.reshape(-1, 3), axis=0).max()
    return (tuple(map(float, normals[0])), float(areas.sum())) if flat else None


def sheds(
    corners: Triangles, down: Sequence[float], slope: float, top: float = math.inf, opening: float = 0.0
) -> bool:
    """Whether what slides down all slopes above this angle [°] leaves a mesh: no face, valley or hollow holds it.

    ``top``: the height of the highest grains, against ``down``, above which a mesh holds none. ``opening``: the least
    width of one through which they leave.
    """
    size = float(np.ptp(corners.reshape(-1, 3), axis=0).max()) or 1.0
    points, top, opening = corners.reshape(-1, 3) / size, top / size, opening / size
    least = math.sin(math.radians(slope))
    _, first, ends = np.unique(np.round(points / MERGED), axis=0, return_index=True, return_inverse=True)
    ends = ends.reshape(-1, 3)
    ends = ends[(ends != np.roll(ends, 1, axis=1)).all(axis=1)]  # without triangles of no area
    ends = ends[np.unique(np.sort(ends, axis=1), axis=0, return_index=True)[1]]  # each once
    if not len(ends):
        return False
    places, heights = points[first], -points[first] @ np.asarray(down, float)
    normals = np.cross(places[ends[:, 1]] - places[ends[:, 0]], places[ends[:, 2]] - places[ends[:, 0]])
    flat = np.linalg.norm(np.cross(normals, down), axis=1) < least * np.linalg.norm(normals, axis=1)
    sides = np.sort(ends[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
    edges, of_edge, count = np.unique(sides, axis=0, return_inverse=True, return_counts=True)
    opposite = np.full(len(edges), np.inf)
    np.minimum.at(opposite, of_edge.reshape(-1), heights[ends[:, [2, 0, 1]]].reshape(-1))
    rise = heights[edges[:, 1]] - heights[edges[:, 0]]
    steep = np.abs(rise) >= least * np.linalg.norm(places[edges[:, 1]] - places[edges[:, 0]], axis=1)
    valley = ~steep & (count > 1) & (opposite >= heights[edges].max(axis=1) - MERGED)
    leaves = heights >= top  # a corner: too high, down a steep edge, or over the border of the mesh
    leaves[np.where(rise > 0.0, edges[:, 1], edges[:, 0])[steep]] = True
    leaves[wide(places, edges[count == 1], opening)] = True
    holds = [flat & (heights[ends].min(axis=1) < top), valley & (heights[edges].min(axis=1) < top), ~leaves]
    return not any(map(np.any, holds))


def wide(places: NDArray[np.float64], border: NDArray[np.int64], least: float) -> NDArray[np.int64]:
    """The corners on the rims of a mesh, which these edges form, of at least this width."""
    from scipy.sparse import coo_array  # which other uses must not wait for
    from scipy.sparse.csgraph import connected_components

    links = coo_array((np.ones(len(border)), border.T), shape=(len(places),) * 2)
    rims, corners = connected_components(links, directed=False)[1], np.unique(border)
    chosen = [np.empty(0, np.int64)]
    for rim in np.unique(rims[corners]):
        members = corners[rims[corners] == rim]
        around = places[members] - places[members].mean(axis=0)
        extents = np.ptp(around @ np.linalg.svd(around, full_matrices=False)[2].T, axis=0)
        if np.sort(extents)[-2] >= least:
            chosen.append(members)
    return np.concatenate(chosen)


def rotated(corners: Triangles, axis: Sequence[float], degrees: float) -> Triangles:
    """Triangles turned about an axis through the origin."""
    from scipy.spatial.transform import Rotation  # which other uses must not wait for

    turn = Rotation.from_rotvec(np.array(axis) * (math.radians(degrees) / math.hypot(*axis)))
    turned: Triangles = corners @ turn.as_matrix().T
    return turned
