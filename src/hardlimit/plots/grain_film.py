"""A film of a box of grains: disks, or the cross sections of spheres in the middle plane.

The plane is that of x and the last axis; in a sheared box that of flow and gradient.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection
from matplotlib.colors import Normalize
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

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


@dataclass(frozen=True)
class Snapshot:
    """The part of a state that a frame shows. For many spheres it takes far less memory than the state."""

    time: float  #: [s]
    circles: tuple[Floats, Floats, Floats]  #: of :func:`shown`
    rms_speed: float  #: of all particles [m/s]
    granular_temperature: float  #: [m²/s²]

    @classmethod
    def of(cls, time: float, system: ParticleSystem) -> Snapshot:
        return cls(time, shown(system), root_mean_square(system), system.granular_temperature)


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
        self.clock = self.figure.text(0.60, 0.86, "", fontsize=15)
        self.facts = self.figure.text(0.60, 0.80, "", fontsize=10, va="top", linespacing=1.6)
        bar = self.figure.add_axes((0.60, 0.2, 0.34, 0.03))
        self.figure.colorbar(ScalarMappable(scale, COLOURS), cax=bar, orientation="horizontal", extend="max")
        bar.set_xlabel("speed / root mean square at this instant")
        self.title = self.figure.text(0.60, 0.06, caption(system), fontsize=9, color="#333333")

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
        at, radius, speed = snapshot.circles
        size, rms = 2.0 * radius, snapshot.rms_speed
        relative = speed / (rms or 1.0)
        self.bodies.set(offsets=at, widths=size, heights=size, angles=np.zeros(len(size)), array=relative)
        factor, unit = self.unit
        self.clock.set_text(f"t = {snapshot.time * factor:.3f} {unit}")
        grouped = f"{collisions:,}".replace(",", "\u202f")
        self.facts.set_text(
            f"{grouped} collisions\ngranular temperature {snapshot.granular_temperature:.3g} m²/s²\n"
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
    what = f"{system.n} disks"
    if system.dimension == 3:
        (cut,) = {0, 1, 2} - set(plane(system))
        what = f"{system.n} spheres, cut by the plane {AXES[cut]} = L/2"
    shown = [system.boundary[axis] for axis in plane(system)]
    if "lees-edwards" in shown:
        return f"{what}\ndashed sides: periodic; dash-dotted: images slide"
    return f"{what}\ndashed sides are periodic" if "periodic" in shown else what


def shown(system: ParticleSystem) -> tuple[Floats, Floats, Floats]:
    """Centres (n, 2), radii (n,) and speeds (n,) of the circles, including periodic images at the edges."""
    radius = np.asarray(system.radius)
    at, speed = system.positions, np.linalg.norm(system.velocities, axis=1)
    across, up = plane(system)
    if system.dimension == 3:
        (normal,) = {0, 1, 2} - {across, up}
        off = np.abs(at[:, normal] - 0.5 * system.box[normal])
        cut = off < radius
        at, radius, off = at[cut], radius[cut], off[cut]
        radius = np.sqrt(radius**2 - off**2)
        speed = speed[cut]
    at = at[:, [across, up]]
    for column, axis in ((1, up), (0, across)):
        if system.boundary[axis] != "wall":
            edge = float(system.box[axis])
            low, high = at[:, column] < radius, at[:, column] > edge - radius
            shift = edge * np.eye(2)[column]
            if axis == system.domain.gradient:
                shift[0] = system.shear_displacement
            beyond = np.concatenate([at[low] + shift, at[high] - shift])
            if axis == system.domain.gradient:
                beyond[:, 0] %= float(system.box[0])
            at = np.concatenate([at, beyond])
            radius, speed = (
                np.concatenate([values, values[low], values[high]]) for values in (radius, speed)
            )
    return at, radius, speed
