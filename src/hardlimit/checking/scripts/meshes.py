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
SAME: Final = 1e-6  #: distance of corners that are one over the size of a mesh
LEVEL: Final = math.cos(math.radians(30.0))  #: cosine of the tilt up to which a bed with friction stays on a triangle
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


def catches(corners: Triangles, along: int, up: float, top: float) -> bool:
    """Whether a mesh holds grains: it has a part that is hardly tilted, or a lowest point with triangles all around.

    ``up``: the sign of the axis ``along`` that is up. ``top``: the highest place of grains along it, above which the
    mesh holds none. Corners within :data:`SAME` of the mesh's size are one.
    """
    from scipy import sparse  # which other uses must not wait for
    from scipy.sparse.csgraph import connected_components

    points = corners.reshape(-1, 3)
    size = float(np.ptp(points, axis=0).max()) or 1.0
    _, first, merged = np.unique(
        np.rint((points - points.min(axis=0)) / (SAME * size)), axis=0, return_index=True, return_inverse=True
    )
    heights, triangles = up * points[first, along], merged.reshape(-1, 3)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    gentle = np.abs(normals[:, along]) > LEVEL * np.linalg.norm(normals, axis=1)
    if (gentle & (heights[triangles].max(axis=1) < top)).any():
        return True
    triangles = np.unique(np.sort(triangles, axis=1), axis=0)  # each once
    sides = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    edges, used = np.unique(sides[sides[:, 0] != sides[:, 1]], axis=0, return_counts=True)
    low, high = np.sort(heights[edges], axis=1).T
    flat = high - low <= SAME * size
    links = sparse.coo_array((np.ones(flat.sum()), edges[flat].T), (len(heights),) * 2)
    parts, part = connected_components(links, directed=False)
    upper = np.take_along_axis(edges, np.argmax(heights[edges], axis=1)[:, None], axis=1)[:, 0]
    lowest = np.zeros(parts, bool)
    lowest[part[heights < top]] = True
    lowest[part[upper[~flat]]] = False  # something beside it is lower
    rim = np.zeros(len(heights), bool)
    rim[edges[used == 1].ravel()] = True
    inner = np.zeros(parts, bool)
    inner[part[~rim]] = True
    inner[part[edges[flat & (used > 1), 0]]] = True
    return bool((lowest & inner).any())


def rotated(corners: Triangles, axis: Sequence[float], degrees: float) -> Triangles:
    """Triangles turned about an axis through the origin."""
    from scipy.spatial.transform import Rotation  # which other uses must not wait for

    turn = Rotation.from_rotvec(np.array(axis) * (math.radians(degrees) / math.hypot(*axis)))
    turned: Triangles = corners @ turn.as_matrix().T
    return turned
