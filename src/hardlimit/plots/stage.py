"""A frame of the film of a drop: the balls of two models side by side, the clock, the forces."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Ellipse, Rectangle
from numpy.typing import NDArray

from ..column.models import MODELS
from ..column.result import Result
from .forces import draw_forces, pairs_of, window
from .labels import scaled
from .storyboard import Scene, gaps_at, round_up
from .style import ball_colour
from .video import Canvas, Frame

MAX_DEFORMATION: Final = 0.3  #: as drawn, in radii
MIN_RADIUS: Final = 0.28  #: as drawn in the close-up, relative to the largest


class _Stage(Canvas):
    """A figure with a background that is drawn once, and artists that move with each frame."""

    def __init__(self, result: Result, ghost: Result, scene: Scene, width: int) -> None:
        super().__init__(width)
        self.result, self.ghost, self.scene = result, ghost, scene
        self.states = [gaps_at(model, scene.times) for model in (result, ghost)]
        self.moving: list[Any] = []
        self.radii: NDArray[np.float64]
        self.axes = [self.figure.add_axes(box) for box in self.boxes()]
        self.set_up()
        names = (MODELS[model.model].label for model in (result, ghost))
        for ax, name in zip(self.axes, names, strict=True):
            ax.set_title(name, fontsize=10.5, pad=6)
        self.balls = [_make_balls(ax, list(self.radii), k == 1) for k, ax in enumerate(self.axes)]
        self.moving += [ball for balls in self.balls for ball in balls]
        self.add_forces()
        self.clock = self.figure.text(0.645, 0.925, "", fontsize=15, va="center")
        self.moving.append(self.clock)
        for artist in self.moving:
            artist.set_animated(True)
        self.canvas.draw()
        self.background = self.canvas.copy_from_bbox(self.figure.bbox)

    def boxes(self) -> tuple[tuple[float, float, float, float], ...]:
        """Axes of the two models: left, bottom, width, height."""
        if self.result.column.floor:
            return (0.065, 0.1, 0.25, 0.76), (0.34, 0.1, 0.25, 0.76)
        return (0.03, 0.5, 0.56, 0.34), (0.03, 0.1, 0.56, 0.34)

    def set_up(self) -> None:
        """Set limits, background and ``radii`` of the drawn balls."""
        raise NotImplementedError

    def move(self, i: int) -> None:
        """Move the balls to frame i."""
        raise NotImplementedError

    def picture(self, i: int) -> Frame:
        """The pixels of frame i."""
        t = float(self.scene.times[i])
        self.clock.set_text(_clock(t, self.scene.close_up))
        for cursor in self.cursors:
            cursor.set_xdata([t * self.time_factor] * 2)
        self.move(i)
        self.canvas.restore_region(self.background)
        for artist in self.moving:
            self.figure.draw_artist(artist)
        return self.pixels()

    def caption(self, text: str) -> None:
        """The speed of the film, and a text below it."""
        slowed = self.scene.slowed
        factor, unit = scaled(1.0 / slowed, "s")
        speed = "in real time"
        if slowed != 1.0:
            how = (
                f"slowed {_grouped(slowed)} times"
                if slowed > 1.0
                else f"{_grouped(1.0 / slowed)} times faster"
            )
            speed = f"{how}: 1 s of film is {_grouped(factor / slowed)} {unit}"
        self.figure.text(0.645, 0.875, f"{speed}\n{text}", fontsize=9, color="#333333", va="top")

    def add_forces(self) -> None:
        """Forces over time with a cursor, beside the balls."""
        n = len(pairs_of(self.result))
        height = 0.6 / n
        boxes = [(0.725, 0.12 + k * height, 0.25, height - 0.045) for k in reversed(range(n))]
        axes = [self.figure.add_axes(box) for box in boxes]
        draw_forces(axes, self.result, self.ghost)
        for ax in axes[:-1]:
            ax.tick_params(labelbottom=False)
            ax.set_xlim(axes[-1].get_xlim())
        start, stop = window([self.result, self.ghost])
        factor = scaled(stop, "s")[0]
        self.cursors = [ax.axvline(start * factor, color="#d00000", lw=1.4) for ax in axes]
        self.time_factor = factor
        self.moving += self.cursors


def _clock(t: float, close_up: bool) -> str:
    in_ms = f"{t * 1e3:.{3 if close_up else 1}f} ms"
    text = f"{t * 1e6:.1f} µs" if close_up and abs(t) < 0.01 else in_ms
    return f"t = {text}".replace("-", "−")


def _grouped(number: float) -> str:
    """A number with thin spaces between thousands."""
    return f"{number:,.6g}".replace(",", "\u202f") if number >= 1.0 else f"{number:g}"


def _contact_count(result: Result) -> str:
    """The number of ball–ball contacts; for a single ball, of its contacts with the floor."""
    alone = len(result.column.balls) == 1
    n = int(result.contacts.sizes["contact"]) if alone else result.n_contacts
    return f"{n} contact{'' if n == 1 else 's'} {'with the floor' if alone else 'of the balls'}"


class Wide(_Stage):
    """The whole fall and rebound, to scale."""

    def set_up(self) -> None:
        column = self.result.column
        # The same scale for fall and rebound.
        highest = max(self.scene.highest, *(float(z.max()) for z, _ in self.states))
        self.radii = np.array([ball.radius for ball in column.balls])
        top = 1.08 * (highest + float(self.radii.max()))
        for ax in self.axes:
            box = ax.get_window_extent()
            half = 0.5 * top * box.width / box.height
            ax.set_xlim(-half, half)
            ax.set_ylim(-0.04 * top, top)
            ax.set_xticks([])
            _draw_floor(ax)
            ax.axhline(float(column.initial_positions[-1]), color="#999999", lw=0.8, ls=":")
        self.axes[1].tick_params(labelleft=False)
        if self.scene.rebound:
            for ax, model in zip(self.axes, (self.result, self.ghost), strict=True):
                text = _contact_count(model)
                ax.text(0.5, 0.975, text, transform=ax.transAxes, ha="center", va="top", fontsize=9.5)
        self.axes[0].set_ylabel("height [m]")
        whose = "top ball" if len(column.balls) > 1 else "ball"
        self.caption(f"true sizes and heights\ndotted: release of the {whose}")

    def move(self, i: int) -> None:
        for balls, (z, _) in zip(self.balls, self.states, strict=True):
            for ball, height in zip(balls, z[i], strict=True):
                ball.set_center((0.0, height))


class CloseUp(_Stage):
    """Gaps and deformations enlarged more than the balls, by a stated factor for each contact."""

    def set_up(self) -> None:
        column = self.result.column
        true = np.array([ball.radius for ball in column.balls])
        largest = float(true.max())
        smallest = float(true.min()) / largest
        power = math.log(MIN_RADIUS) / math.log(smallest) if smallest < MIN_RADIUS else 1.0
        self.radii = (true / largest) ** power
        self.scales = [self._scale(pair, largest) for pair in range(len(true))]
        self.horizontal = not column.floor
        length = 2.5 * float(self.radii.sum())
        if not self.horizontal:  # wide enough for the largest ball when it is compressed
            box = self.axes[0].get_window_extent()
            length = max(length, 2.4 * box.height / box.width)
        for ax in self.axes:
            box = ax.get_window_extent()
            if self.horizontal:
                half = 0.5 * length * box.height / box.width
                ax.set_xlim(-0.1 * length, length)
                ax.set_ylim(-half, half)
            else:
                half = 0.5 * length * 1.06 * box.width / box.height
                ax.set_xlim(-half, half)
                ax.set_ylim(-0.06 * length, length)
                _draw_floor(ax)
            ax.set_xticks([])
            ax.set_yticks([])
        self.length = length
        self.caption(self._scale_text(power))
        at, ha, va = (0.985, 0.5), "right", "center"
        if not self.horizontal:
            at, ha, va = (0.5, 0.985), "center", "top"
        look: dict[str, Any] = {"ha": ha, "va": va, "fontsize": 8.5, "color": "#444444"}
        self.out_of_view = [ax.text(*at, "", transform=ax.transAxes, **look) for ax in self.axes]
        self.moving += self.out_of_view

    def _scale(self, pair: int, largest: float) -> float:
        """Drawn length for one metre of gap, such that the largest deformation is MAX_DEFORMATION."""
        deepest = -float(self.states[0][1][:, pair].min())
        if (pair == 0 and not self.result.column.floor) or not deepest > 0.0:
            return 1.0 / largest
        smaller = self.radii[pair] if pair == 0 else min(self.radii[pair - 1], self.radii[pair])
        factor = MAX_DEFORMATION * smaller * largest / deepest  # relative to the scale of the largest ball
        if factor <= 1.0:
            return 1.0 / largest
        return round_up(factor) / (2.0 if round_up(factor) > factor * 1.2 else 1.0) / largest

    def _scale_text(self, power: float) -> str:
        largest = max(ball.radius for ball in self.result.column.balls)
        parts = []
        for pair in pairs_of(self.result):
            where = "at the floor" if pair == 0 else f"balls {pair}–{pair + 1}"
            parts.append(f"{where} ×{_grouped(self.scales[pair] * largest)}")
        more, radii = ", …" * (len(parts) > 3), "\nradii not to scale" * (power < 1.0)
        return f"close-up, deformation and gaps enlarged:\n{', '.join(parts[:3])}{more}{radii}"

    def move(self, i: int) -> None:
        for k, (balls, (_, gaps)) in enumerate(zip(self.balls, self.states, strict=True)):
            self._draw(k, balls, gaps[i])

    def _draw(self, which: int, balls: list[Ellipse], gaps: NDArray[np.float64]) -> None:
        """Ellipses that touch while in contact; both bodies have half of the compression."""
        drawn = gaps * np.array(self.scales)
        if self.horizontal:
            drawn[0] = 0.0  # the first ball of a cradle does not move; only gaps are shown
        squeeze = np.maximum(-drawn, 0.0)
        bottom = 0.0
        missing = ""
        for b, ball in enumerate(balls):
            bottom += max(float(drawn[b]), 0.0)
            below = float(squeeze[b]) * (1.0 if b == 0 else 0.5)
            above = 0.5 * float(squeeze[b + 1]) if b + 1 < len(balls) else 0.0
            size = max(2.0 * self.radii[b] - below - above, 0.2 * self.radii[b])
            across = 2.0 * self.radii[b] * math.sqrt(2.0 * self.radii[b] / size)
            centre = bottom + 0.5 * size
            if self.horizontal:
                ball.set(center=(centre, 0.0), width=size, height=across)
            else:
                ball.set(center=(0.0, centre), width=across, height=size)
            if bottom > self.length and not missing:
                arrow = "▶" if self.horizontal else "▲"
                missing = f"{arrow} ball {b + 1} is {_distance(float(gaps[b]))} away"
            bottom += size
        self.out_of_view[which].set_text(missing)


def _distance(metres: float) -> str:
    return f"{metres * 1e6:.0f} µm" if metres < 1e-3 else f"{metres * 1e3:.1f} mm"


def _draw_floor(ax: Axes) -> None:
    low, high = ax.get_xlim()
    bottom = ax.get_ylim()[0]
    ground = Rectangle((low, bottom), high - low, -bottom, facecolor="#e4e4e4", lw=0, hatch="////")
    ground.set_edgecolor("#aaaaaa")
    ax.add_patch(ground)
    ax.axhline(0.0, color="black", lw=1.0)


def _make_balls(ax: Axes, radii: list[float], ghost: bool) -> list[Ellipse]:
    balls = []
    for i, radius in enumerate(radii):
        colour = ball_colour(i + 1)
        ball = Ellipse((0.0, 0.0), 2.0 * radius, 2.0 * radius, facecolor=colour, edgecolor="black", lw=0.8)
        if ghost:
            inch = radius * ax.get_window_extent().height / abs(np.diff(ax.get_ylim())[0]) / ax.figure.dpi
            ball.set(facecolor="white", edgecolor=colour, linewidth=1.6)
            if inch > 0.1:  # dashes would not be visible on a smaller ball
                ball.set_linestyle("--")
        ax.add_patch(ball)
        balls.append(ball)
    return balls
