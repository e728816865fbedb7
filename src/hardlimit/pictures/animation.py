"""A film of one drop: the fall, the contacts in slow motion, the rebound. Only drawing.

Beside the balls runs a second model as a ghost, usually the independent collisions. During the contacts
the film is a close-up in which gaps and deformations are drawn larger than the balls; scale and clock stand
on the picture.
"""

from __future__ import annotations

import contextlib
import math
import os
import subprocess
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, cast

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, Rectangle

from ..column.solvers import independent
from ..models import MODELS
from . import plots

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from ..column.result import Result

Frame = Any  # NDArray[np.uint8], height × width × 3

ENDINGS: Final = (".mp4", ".gif")
SECONDS_OF_CONTACTS: Final = 8.0  #: of film, about; the factor of slow motion is a round number
SQUEEZE: Final = 0.3  #: largest drawn deformation, in radii
SMALLEST_DRAWN: Final = 0.28  #: smallest drawn radius in the close-up, in largest radii

STYLE: Final = {
    "font__family": "DejaVu Sans",
    "mathtext__fontset": "dejavusans",
    "figure__constrained_layout__use": False,
    "font__size": 9.0,
    "axes__labelsize": 9.0,
    "xtick__labelsize": 8.0,
    "ytick__labelsize": 8.0,
}


@dataclass(frozen=True)
class Scene:
    """A stretch of the film: instants of the drop shown one after the other, at one speed."""

    times: NDArray[np.float64]  #: [s] on the clock of the result, one for each frame
    slowed: float  #: seconds of film for one second of the drop
    close_up: bool
    highest: float = 0.0  #: [m] highest centre that scenes of the same scale show
    rebound: bool = False


def animate(
    result: Result,
    path: str | Path,
    *,
    ghost: Result | None = None,
    width: int | None = None,
    frames_per_second: int | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> Path:
    """Write a film of the drop as MP4 or GIF, by the ending of ``path``.

    Parameters
    ----------
    result : Result
    path : path
        A file is only there when it is complete.
    ghost : Result, optional
        A second model of the same column, shown beside; independent collisions by default.
    width : int, optional
        Of the picture in pixels, 16:9; 1280 (MP4) or 640 (GIF) by default.
    frames_per_second : int, optional
        30 (MP4) or 15 (GIF) by default.
    progress : callable(done, total), optional

    Raises
    ------
    ValueError
        If the ending is unknown or the file cannot be written.
    """
    target = Path(path)
    film = target.suffix.lower() == ".mp4"
    if target.suffix.lower() not in ENDINGS:
        raise ValueError(f"animate: got {str(path)!r}, must end in {' or '.join(ENDINGS)}")
    if not target.parent.is_dir() or not os.access(target.parent, os.W_OK) or target.is_dir():
        raise ValueError(f"animate: got {str(path)!r}, must be in a folder that can be written")
    rate = frames_per_second or (30 if film else 15)
    pixels = (width or (1280 if film else 640)) // 16 * 16
    other = independent(result.column, result.until) if ghost is None else ghost
    pictures = frames(result, other, pixels, rate, progress)
    draft = target.with_name(f".{target.stem}.part{target.suffix}")
    try:
        (_write_mp4 if film else _write_gif)(draft, pictures, (pixels, pixels * 9 // 16), rate)
        draft.replace(target)
    except OSError as error:
        raise ValueError(f"animate: {str(path)!r} cannot be written: {error.strerror or error}") from None
    finally:
        draft.unlink(missing_ok=True)
    return target


def frames(
    result: Result,
    ghost: Result,
    width: int,
    rate: int,
    progress: Callable[[int, int], object] | None = None,
) -> Iterator[Frame]:
    """The pictures of the film one after the other."""
    scenes = storyboard(result, ghost, rate)
    total = sum(len(scene.times) for scene in scenes)
    done = 0
    with plots.style(**STYLE):
        for scene in scenes:
            stage = (_CloseUp if scene.close_up else _Wide)(result, ghost, scene, width)
            for i in range(len(scene.times)):
                yield stage.picture(i)
                done += 1
                if progress is not None:
                    progress(done, total)


# --- which instants -----------------------------------------------------------------------------------------


def round_up(value: float) -> float:
    """The next of 1, 2, 5, 10, …: factors that can be said aloud."""
    exponent = math.floor(math.log10(value))
    for digit in (1.0, 2.0, 5.0, 10.0):
        if digit * 10.0**exponent >= value * (1.0 - 1e-9):
            return digit * 10.0**exponent
    return 10.0 ** (exponent + 1)


def storyboard(result: Result, ghost: Result, rate: int) -> list[Scene]:
    """Fall, contacts, rebound; a cradle shows its contacts only."""
    start, stop = _sequence(result, ghost)
    slowed = round_up(SECONDS_OF_CONTACTS / (stop - start))
    contacts = Scene(_instants(start, stop, slowed, rate), slowed, True)
    if not result.column.floor:
        return [contacts]
    release = plots.release_time(result)
    end = result.until if result.until is not None else stop + max(-release, 3.0 * (stop - start))
    wide = []
    if release < start:
        slowed = round_up(2.0 / (start - release))
        wide.append(Scene(_instants(release, start, slowed, rate), slowed, False))
    if end > stop:
        slowed = round_up(3.0 / (end - stop))
        times = _instants(stop, end, slowed, rate)
        times = np.concatenate([times, np.full(rate, times[-1])])  # a still second at the end
        wide.append(Scene(times, slowed, False, rebound=True))
    highest = max((float(_gaps(m, s.times)[0].max()) for s in wide for m in (result, ghost)), default=0.0)
    wide = [replace(scene, highest=highest) for scene in wide]
    return [*(s for s in wide if not s.rebound), contacts, *(s for s in wide if s.rebound)]


def _sequence(result: Result, ghost: Result) -> tuple[float, float]:
    """Begin and end of the contacts of both models, with a margin."""
    marks = [0.0]
    for model in (result, ghost):
        for name in ("begin", "end"):
            values = model.contacts[name].values
            marks += [float(t) for t in values[np.isfinite(values)]]
    start, stop = min(marks), max(marks)
    margin = 0.06 * (stop - start) or 1e-6
    return max(start - margin, plots.release_time(result)), stop + margin


def _instants(start: float, stop: float, slowed: float, rate: int) -> NDArray[np.float64]:
    count = max(2, round((stop - start) * slowed * rate))
    return np.linspace(start, stop, count)


# --- the picture --------------------------------------------------------------------------------------------


class _Stage:
    """A figure of which the fixed part is drawn once and the moving part for each frame."""

    def __init__(self, result: Result, ghost: Result, scene: Scene, width: int) -> None:
        self.result, self.ghost, self.scene = result, ghost, scene
        self.figure = Figure(figsize=(9.6, 5.4), dpi=width / 9.6)
        self.canvas = cast(Any, FigureCanvasAgg(self.figure))
        self.states = [_gaps(model, scene.times) for model in (result, ghost)]
        self.moving: list[Any] = []
        self.axes = [self.figure.add_axes(box) for box in self.boxes()]
        self.set_up()
        self.clock = self.figure.text(0.645, 0.925, "", fontsize=15, va="center")
        self.moving.append(self.clock)
        for artist in self.moving:
            artist.set_animated(True)
        self.canvas.draw()
        self.background = self.canvas.copy_from_bbox(self.figure.bbox)

    def boxes(self) -> tuple[tuple[float, float, float, float], ...]:
        """Where the two models stand."""
        if self.result.column.floor:
            return (0.065, 0.1, 0.25, 0.76), (0.34, 0.1, 0.25, 0.76)
        return (0.03, 0.5, 0.56, 0.34), (0.03, 0.1, 0.56, 0.34)

    def set_up(self) -> None:
        raise NotImplementedError

    def move(self, i: int) -> None:
        raise NotImplementedError

    def picture(self, i: int) -> Frame:
        """Frame i as an array."""
        self.clock.set_text(_clock(float(self.scene.times[i]), self.scene.close_up))
        self.move(i)
        self.canvas.restore_region(self.background)
        for artist in self.moving:
            self.figure.draw_artist(artist)
        return np.asarray(self.canvas.buffer_rgba())[:, :, :3].copy()

    def caption(self, text: str) -> None:
        slowed = self.scene.slowed
        factor, unit = plots.scaled(1.0 / slowed, "s")
        how = f"slowed {_grouped(slowed)} times" if slowed > 1.0 else "in real time"
        how = f"{_grouped(1.0 / slowed)} times faster" if slowed < 1.0 else how
        speed = f"{how}: 1 s of film is {_grouped(factor / slowed)} {unit}" if slowed != 1.0 else how
        self.figure.text(0.645, 0.875, f"{speed}\n{text}", fontsize=9, color="#333333", va="top")

    def title_models(self) -> None:
        names = (MODELS[self.result.model].label, MODELS[self.ghost.model].label)
        for ax, name in zip(self.axes, names, strict=True):
            ax.set_title(name, fontsize=10.5, pad=6)

    def add_forces(self) -> None:
        """Forces over time with a cursor, beside the balls."""
        pairs = plots.pairs_of(self.result)
        height = 0.6 / len(pairs)
        axes = []
        for k in range(len(pairs)):
            box = (0.7, 0.12 + (len(pairs) - 1 - k) * height, 0.275, height - 0.045)
            axes.append(self.figure.add_axes(box))
        plots.draw_forces(axes, self.result, self.ghost)
        for ax in axes[:-1]:
            ax.tick_params(labelbottom=False)
            ax.set_xlim(axes[-1].get_xlim())
        start, stop = plots.window([self.result, self.ghost])
        factor = plots.scaled(stop, "s")[0]
        self.cursors = [ax.axvline(start * factor, color="#d00000", lw=1.4) for ax in axes]
        self.time_factor = factor
        self.moving += self.cursors


def _gaps(result: Result, times: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Centres and gaps [m] at the times; gap 0 is that above the floor."""
    z = result.trajectory(times)["position"].values
    radii = np.array([ball.radius for ball in result.column.balls])
    between = np.diff(z, axis=1) - radii[1:] - radii[:-1]
    return z, np.column_stack([z[:, 0] - radii[0], between])


def _clock(t: float, close_up: bool) -> str:
    if close_up and abs(t) < 0.01:
        text = f"t = {t * 1e6:.1f} µs"
    else:
        text = f"t = {t * 1e3:.{3 if close_up else 1}f} ms"
    return text.replace("-", "−")


def _grouped(number: float) -> str:
    return f"{number:,.6g}".replace(",", "\u202f") if number >= 1.0 else f"{number:g}"


class _Wide(_Stage):
    """True positions and sizes, the whole fall and rebound."""

    def set_up(self) -> None:
        column = self.result.column
        # The same scale for fall and rebound: as high as either gets.
        highest = max(float(z.max()) for z, _ in self.states)
        highest = max(highest, self.scene.highest)
        largest = max(ball.radius for ball in column.balls)
        top = 1.08 * (highest + largest)
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
                n = model.n_contacts
                text = f"{n} contact{'' if n == 1 else 's'} of the balls"
                ax.text(0.5, 0.975, text, transform=ax.transAxes, ha="center", va="top", fontsize=9.5)
        self.axes[0].set_ylabel("height [m]")
        self.title_models()
        self.caption("true sizes and heights; dotted: release of the top ball")
        self.balls = [
            _make_balls(ax, [b.radius for b in column.balls], k == 1) for k, ax in enumerate(self.axes)
        ]
        self.moving += [ball for balls in self.balls for ball in balls]
        self.add_forces()

    def move(self, i: int) -> None:
        for balls, (z, _) in zip(self.balls, self.states, strict=True):
            for ball, height in zip(balls, z[i], strict=True):
                ball.set_center((0.0, height))
        for cursor in self.cursors:
            t = float(self.scene.times[i]) * self.time_factor
            cursor.set_xdata([t, t])


class _CloseUp(_Stage):
    """Gaps and deformations drawn larger than the balls, each contact on its own stated scale."""

    def set_up(self) -> None:
        column = self.result.column
        true = np.array([ball.radius for ball in column.balls])
        largest = float(true.max())
        shrink = math.log(SMALLEST_DRAWN) / math.log(true.min() / largest) if true.min() < largest else 1.0
        power = min(1.0, shrink) if true.min() / largest < SMALLEST_DRAWN else 1.0
        self.radii = (true / largest) ** power
        self.scales = [self._scale(pair, largest) for pair in range(len(true))]
        self.horizontal = not column.floor
        length = 2.5 * float(self.radii.sum())
        if not self.horizontal:  # wide enough for the largest ball, squeezed
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
        self.title_models()
        self.caption(self._scale_text(power))
        self.balls = [_make_balls(ax, list(self.radii), k == 1) for k, ax in enumerate(self.axes)]
        self.moving += [ball for balls in self.balls for ball in balls]
        self.gone = [
            ax.text(
                *((0.985, 0.5) if self.horizontal else (0.5, 0.985)),
                "",
                transform=ax.transAxes,
                ha="right" if self.horizontal else "center",
                va="center" if self.horizontal else "top",
                fontsize=8.5,
                color="#444444",
            )
            for ax in self.axes
        ]
        self.moving += self.gone
        self.add_forces()

    def _scale(self, pair: int, largest: float) -> float:
        """Drawn length for one metre of gap: so that the deepest deformation is clear but not grotesque."""
        deepest = -float(self.states[0][1][:, pair].min())
        if (pair == 0 and not self.result.column.floor) or not deepest > 0.0:
            return 1.0 / largest
        smaller = self.radii[pair] if pair == 0 else min(self.radii[pair - 1], self.radii[pair])
        factor = SQUEEZE * smaller * largest / deepest  # compared with true scale of the largest ball
        if factor <= 1.0:
            return 1.0 / largest
        return round_up(factor) / (2.0 if round_up(factor) > factor * 1.2 else 1.0) / largest

    def _scale_text(self, power: float) -> str:
        largest = max(ball.radius for ball in self.result.column.balls)
        parts = []
        for pair in plots.pairs_of(self.result):
            where = "at the floor" if pair == 0 else f"balls {pair}–{pair + 1}"
            parts.append(f"{where} ×{_grouped(self.scales[pair] * largest)}")
        text = "close-up, deformation and gaps enlarged:\n" + ", ".join(parts[:3])
        if len(parts) > 3:
            text += ", …"
        return text + ("\nradii not to scale" if power < 1.0 else "")

    def move(self, i: int) -> None:
        for k, (balls, (_, gaps)) in enumerate(zip(self.balls, self.states, strict=True)):
            self._place(k, balls, gaps[i])
        for cursor in self.cursors:
            t = float(self.scene.times[i]) * self.time_factor
            cursor.set_xdata([t, t])

    def _place(self, which: int, balls: list[Ellipse], gaps: NDArray[np.float64]) -> None:
        """Ellipses that touch while in contact: a compression takes length from the bodies that share it."""
        drawn = gaps * np.array(self.scales)
        if self.horizontal:
            drawn[0] = 0.0  # the first ball of a cradle stays where it is; only gaps are shown
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
                away = float(gaps[b])
                missing = f"▲ ball {b + 1} is {_distance(away)} away"
                missing = missing.replace("▲", "▶") if self.horizontal else missing
            bottom += size
        self.gone[which].set_text(missing)


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
        colour = plots.ball_colour(i + 1)
        ball = Ellipse((0.0, 0.0), 2.0 * radius, 2.0 * radius, facecolor=colour, edgecolor="black", lw=0.8)
        if ghost:
            inch = radius * ax.get_window_extent().height / abs(np.diff(ax.get_ylim())[0]) / ax.figure.dpi
            ball.set(facecolor="white", edgecolor=colour, linewidth=1.6)
            if inch > 0.1:  # dashes need room
                ball.set_linestyle("--")
        ax.add_patch(ball)
        balls.append(ball)
    return balls


# --- files --------------------------------------------------------------------------------------------------


def _write_mp4(path: Path, pictures: Iterator[Frame], size: tuple[int, int], rate: int) -> None:
    """Raw frames piped into the ffmpeg that imageio-ffmpeg brings."""
    import imageio_ffmpeg

    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-y", "-loglevel", "error"]
    command += [
        "-f",
        "rawvideo",
        "-pix_fmt",
        "rgb24",
        "-s",
        f"{size[0]}x{size[1]}",
        "-r",
        str(rate),
        "-i",
        "-",
    ]
    command += ["-an", "-c:v", "libx264", "-preset", "medium", "-crf", "23", "-tune", "animation"]
    command += ["-pix_fmt", "yuv420p", "-movflags", "+faststart", str(path.resolve())]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    ) as process:
        assert process.stdin is not None and process.stderr is not None
        try:
            for picture in pictures:
                process.stdin.write(picture.tobytes())
        except BrokenPipeError:
            pass  # ffmpeg says why below
        except BaseException:
            process.kill()
            raise
        with contextlib.suppress(BrokenPipeError):
            process.stdin.close()
        message = process.stderr.read().decode(errors="replace").strip()
        if process.wait() != 0:
            raise OSError(f"ffmpeg: {message.splitlines()[-1] if message else 'failed'}")


def _write_gif(path: Path, pictures: Iterator[Frame], size: tuple[int, int], rate: int) -> None:
    """All frames on one palette of 64 colours: few colours are used, and a common palette compresses."""
    from PIL import Image

    palette: Image.Image | None = None
    images = []
    for picture in pictures:
        image = Image.fromarray(picture)
        if palette is None:
            palette = image.quantize(64)
        images.append(image.quantize(palette=palette, dither=Image.Dither.NONE))
    images[0].save(
        path,
        save_all=True,
        append_images=images[1:],
        duration=round(1000 / rate),
        loop=0,
        optimize=False,
        disposal=1,
    )
