"""A film of a box of grains: disks, or the cross sections of spheres in the middle plane.

The plane is that of x and the last axis; in a sheared box that of flow and gradient. Particles with angular velocities
have a mark that turns with them: disks a spoke, spheres the line where a plane that halves them meets the cut.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.colors import Normalize
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from ..boxes import spins
from ..boxes.box import AXES
from . import video
from .labels import scaled
from .style import style
from .video import STYLE, Canvas, Frame

if TYPE_CHECKING:
    from ..boxes.system import ParticleSystem

Floats = NDArray[np.float64]
COLOURS = "viridis"
#: Line of each kind of side.
LINES = {
    "wall": {"lw": 2.0, "ls": "-"},
    "periodic": {"lw": 0.9, "ls": (0, (4, 3))},
    "lees-edwards": {"lw": 0.9, "ls": (0, (6, 2, 1, 2))},
}
FASTEST = 2.0  #: end of the colour bar, in units of the root mean square speed; few particles are faster


DARK = 0.45  #: marks on colours below this part of the colour bar are white


class Circles(NamedTuple):
    """The circles of a frame, including periodic images at the edges."""

    centres: Floats  #: (n, 2) [m]
    radii: Floats  #: (n,) [m]
    speeds: Floats  #: (n,) [m/s]
    particles: NDArray[np.int64]  #: index of the particle of each (n,)
    heights: Floats  #: of the cut of a sphere above its centre (n,) [m]; 0 for disks


@dataclass(frozen=True)
class Snapshot:
    """The part of a state that a frame shows. For many spheres it takes far less memory than the state."""

    time: float  #: [s]
    circles: Circles
    rms_speed: float  #: of all particles [m/s]
    granular_temperature: float  #: [m²/s²]
    marks: Floats | None = (
        None  #: ends of the mark of each circle (n, 2, 2) [m], NaN where the cut meets none
    )
    rotational_temperature: float = 0.0  #: [m²/s²]

    @classmethod
    def of(cls, time: float, system: ParticleSystem, directions: Floats | None = None) -> Snapshot:
        """The snapshot of a state; ``directions`` are those of :class:`Directions`, if marks are to be drawn."""
        circles = shown(system)
        marks = None if directions is None else _marks(circles, directions, plane(system), system.dimension)
        temperatures = system.granular_temperature, system.rotational_temperature
        return cls(time, circles, root_mean_square(system), temperatures[0], marks, temperatures[1])


class Directions:
    """A direction in each particle, which turns with it: along the spoke of a disk, across the plane of a sphere.

    From one state to the next a particle turns by the mean of its spins at both. That is exact if they are equal;
    spins in between are not known.
    """

    def __init__(self) -> None:
        self._last: tuple[float, Floats, Floats] | None = None  # time [s], spins [rad/s], directions

    def at(self, time: float, system: ParticleSystem) -> Floats | None:
        """Unit vectors (N, 3) at the next state, at first along x; None without angular velocities."""
        if system.angular_velocities is None:
            return None
        spin = spins.for_core(system.angular_velocities)
        if self._last is None:
            directions = np.tile(np.eye(3)[0], (system.n, 1))
        else:
            before, earlier, directions = self._last
            directions = turned(directions, 0.5 * (earlier + spin) * (time - before))
        self._last = time, spin, directions
        return directions


def turned(vectors: Floats, angles: Floats) -> Floats:
    """Vectors (N, 3) after rotations by these angles about these axes (N, 3) [rad]: Rodrigues' formula."""
    size = np.linalg.norm(angles, axis=1)[:, None]
    across = np.cross(angles, vectors)
    # sin(x)/x and (1 − cos x)/x², without a division by zero
    first, second = np.sinc(size / np.pi), 0.5 * np.sinc(0.5 * size / np.pi) ** 2
    rotated: Floats = vectors + first * across + second * np.cross(angles, across)
    return rotated


def _marks(circles: Circles, directions: Floats, axes: tuple[int, int], dimension: int) -> Floats:
    """Ends of the mark in each circle (n, 2, 2) [m]."""
    direction = directions[circles.particles]
    in_plane, radii = direction[:, axes], circles.radii[:, None]
    if dimension == 2:
        return np.stack([circles.centres, circles.centres + radii * in_plane], axis=1)
    # Points x of the cut, from the centre of the sphere, with x·m = 0: a line, whose point ``nearest`` is the nearest.
    (normal,) = {0, 1, 2} - set(axes)
    with np.errstate(invalid="ignore", divide="ignore"):
        size = np.linalg.norm(in_plane, axis=1)[:, None]
        nearest = -in_plane * (direction[:, [normal]] * circles.heights[:, None] / size**2)
        half = np.sqrt(radii**2 - (nearest * nearest).sum(axis=1, keepdims=True))
        along = half * np.stack([-in_plane[:, 1], in_plane[:, 0]], axis=1) / size
    middle = circles.centres + nearest
    return np.stack([middle - along, middle + along], axis=1)


def film(
    path: Path,
    system: ParticleSystem,
    frames: Iterable[tuple[Snapshot, int]],
    end: float,
    *,
    width: int = 640,
    rate: int = 15,
) -> Path:
    """Write a picture of each snapshot as MP4 or GIF, by the ending of ``path``.

    ``frames`` has each snapshot with the number of collisions so far, and is consumed while the film is written. The
    ``end`` of the run [s] sets the unit of the clock. ``width`` is in pixels, a multiple of 32; ``rate``
    in pictures per second.
    """
    return video.write(path, pictures(system, frames, end, width), width, rate)


def pictures(
    system: ParticleSystem, frames: Iterable[tuple[Snapshot, int]], end: float, width: int
) -> Iterator[Frame]:
    with style(**STYLE):
        stage = Stage(system, end, width)
        for snapshot, collisions in frames:
            yield stage.picture(snapshot, collisions)


class Stage(Canvas):
    """The box on the left; clock and colour bar on the right.

    Colours show speeds relative to their present root mean square, so that a cooled gas keeps its colours.
    """

    def __init__(self, system: ParticleSystem, end: float, width: int) -> None:
        self.unit = scaled(end, "s")
        self.plane = plane(system)  # x to the right, the other axis upwards
        super().__init__(width)
        self.ax = self.figure.add_axes((0.03, 0.07, 0.52, 0.86))
        self._draw_box(system)
        scale = Normalize(0.0, FASTEST)
        self.bodies = EllipseCollection(
            [], [], [], units="xy", offsets=np.empty((0, 2)), transOffset=self.ax.transData,
            cmap=COLOURS, norm=scale, edgecolors="black", linewidths=0.3,
        )  # fmt: skip
        self.ax.add_collection(self.bodies)
        self.bodies.set_clip_path(self.inside)
        self.marks = LineCollection([], linewidths=1.2, capstyle="butt")
        self.ax.add_collection(self.marks, autolim=False)
        self.marks.set_clip_path(self.inside)
        self.clock = self.figure.text(0.60, 0.86, "", fontsize=15)
        self.facts = self.figure.text(0.60, 0.80, "", fontsize=10, va="top", linespacing=1.6)
        bar = self.figure.add_axes((0.60, 0.2, 0.34, 0.03))
        self.figure.colorbar(ScalarMappable(scale, COLOURS), cax=bar, orientation="horizontal", extend="max")
        bar.set_xlabel("speed / root mean square at this instant")
        self.title = self.figure.text(0.60, 0.03, caption(system), fontsize=9, color="#333333")

    def _draw_box(self, system: ParticleSystem) -> None:
        across, up = (float(system.box[axis]) for axis in self.plane)
        margin = 0.01 * max(across, up)
        self.ax.set_xlim(-margin, across + margin)
        self.ax.set_ylim(-margin, up + margin)
        self.ax.set_aspect("equal")
        self.ax.set_axis_off()
        self.inside = Rectangle((0.0, 0.0), across, up, transform=self.ax.transData)
        corners = np.array([[0, 0], [across, 0], [across, up], [0, up], [0, 0]])
        sides = [system.boundary[axis] for axis in (self.plane[1], self.plane[0])]
        for i, (a, b) in enumerate(itertools.pairwise(corners)):
            line: dict[str, Any] = LINES[sides[i % 2]]
            self.ax.plot([a[0], b[0]], [a[1], b[1]], color="black", zorder=3, clip_on=False, **line)

    def picture(self, snapshot: Snapshot, collisions: int) -> Frame:
        at, radius, speed, *_ = snapshot.circles
        size, rms = 2.0 * radius, snapshot.rms_speed
        relative = speed / (rms or 1.0)
        self.bodies.set(offsets=at, widths=size, heights=size, angles=np.zeros(len(size)), array=relative)
        spinning = ""
        if snapshot.marks is not None:
            dark = relative < DARK * FASTEST
            self.marks.set(segments=snapshot.marks, color=np.where(dark, "white", "black").tolist())
            spinning = f"\nrotational temperature {snapshot.rotational_temperature:.3g} m²/s²"
        factor, unit = self.unit
        self.clock.set_text(f"t = {snapshot.time * factor:.3f} {unit}")
        grouped = f"{collisions:,}".replace(",", "\u202f")
        self.facts.set_text(
            f"{grouped} collisions\ngranular temperature {snapshot.granular_temperature:.3g} m²/s²{spinning}\n"
            f"root mean square of the speeds {rms:.3g} m/s"
        )
        self.canvas.draw()
        return self.pixels()


def root_mean_square(system: ParticleSystem) -> float:
    """Root mean square of the speeds of all particles [m/s]."""
    return float(np.linalg.norm(system.velocities)) / math.sqrt(system.n)


def plane(system: ParticleSystem) -> tuple[int, int]:
    """The two axes that a frame shows."""
    return 0, system.domain.gradient or system.dimension - 1


def caption(system: ParticleSystem) -> str:
    """The caption of the film: the number of particles, for spheres the plane of the cross section, and the sides."""
    marked = system.angular_velocities is not None
    what = f"{system.n} disks{', spokes turn with them' if marked else ''}"
    if system.dimension == 3:
        (cut,) = {0, 1, 2} - set(plane(system))
        what = f"{system.n} spheres, cut by the plane {AXES[cut]} = L/2"
        what += "\nlines: planes that halve the spheres and turn with them" if marked else ""
    shown = [system.boundary[axis] for axis in plane(system)]
    if "lees-edwards" in shown:
        return f"{what}\ndashed sides: periodic; dash-dotted: images slide"
    return f"{what}\ndashed sides are periodic" if "periodic" in shown else what


def shown(system: ParticleSystem) -> Circles:
    """The circles of the particles, including periodic images at the edges."""
    across, up = plane(system)
    at, particles = system.positions[:, [across, up]], np.arange(system.n)
    circles = Circles(
        at, system.radius, np.linalg.norm(system.velocities, axis=1), particles, np.zeros(system.n)
    )
    if system.dimension == 3:
        (normal,) = {0, 1, 2} - {across, up}
        heights = 0.5 * system.box[normal] - system.positions[:, normal]
        cut = np.abs(heights) < system.radius
        circles = Circles(*(values[cut] for values in circles))
        heights = heights[cut]
        circles = circles._replace(radii=np.sqrt(circles.radii**2 - heights**2), heights=heights)
    for column, axis in ((1, up), (0, across)):
        if system.boundary[axis] != "wall":
            at, radius, edge = circles.centres, circles.radii, float(system.box[axis])
            low, high = at[:, column] < radius, at[:, column] > edge - radius
            shift = edge * np.eye(2)[column]
            if axis == system.domain.gradient:
                shift[0] = system.shear_displacement
            beyond = np.concatenate([at[low] + shift, at[high] - shift])
            if axis == system.domain.gradient:
                beyond[:, 0] %= float(system.box[0])
            images = Circles(*(np.concatenate([values[low], values[high]]) for values in circles))
            images = images._replace(centres=beyond)
            circles = Circles(*(np.concatenate(pair) for pair in zip(circles, images, strict=True)))
    return circles
