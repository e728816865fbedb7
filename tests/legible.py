"""Whether a picture can be read: no text runs into another one or off the picture."""

from __future__ import annotations

import subprocess
from itertools import combinations
from pathlib import Path
from typing import Any

import imageio_ffmpeg
import numpy as np
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox
from PIL import Image, ImageSequence

from hardlimit.plots.style import style


def along(axis: Axis, values: Any) -> Any:
    """Where values lie along an axis, which may be logarithmic."""
    return axis.get_transform().transform(np.asarray(values, dtype=float))


def boxes(figure: Figure) -> list[tuple[str, Bbox]]:
    """Every text that is seen, with the rectangle that it takes [pixels]; ticks outside the axes are not."""
    FigureCanvasAgg(figure)
    figure.draw_without_rendering()
    axes = [*figure.axes, *(child for ax in figure.axes for child in ax.child_axes)]
    ticks = {
        label: axis.get_visible() and low - 1e-9 * (high - low) <= at <= high + 1e-9 * (high - low)
        for ax in axes
        for i, axis in enumerate((ax.xaxis, ax.yaxis))
        for low, high in [sorted(along(axis, axis.get_view_interval()))]
        for label in axis.get_ticklabels(which="both")
        for at in along(axis, [label.get_position()[i]])
    }
    shown = []
    for text in figure.findobj(Text):
        if text.get_text().strip() and text.get_visible() and ticks.get(text, True):
            # A text box holds the room of ascenders and descenders: what overlaps by less is no overlap.
            shown.append((text.get_text(), text.get_window_extent().padded(-1.0)))
    return shown


def assert_legible(figure: Figure, **look: Any) -> None:
    """``look`` is what the picture changes of the shared style."""
    page = figure.bbox.padded(2.0)
    with style(**look):
        shown = boxes(figure)
    for text, box in shown:
        assert page.x0 <= box.x0 and box.x1 <= page.x1, f"{text!r} runs off the picture"
        assert page.y0 <= box.y0 and box.y1 <= page.y1, f"{text!r} runs off the picture"
    for (label, first), (other, second) in combinations(shown, 2):
        assert not first.overlaps(second), f"{label!r} and {other!r} overlap"


def coloured(picture: Path | np.ndarray) -> float:
    """Share of the pixels of a picture that have a colour: those of data, for axes and words are black and grey."""
    if not isinstance(picture, np.ndarray):
        with Image.open(picture) as opened:
            picture = np.asarray(opened.convert("RGB"))
    return float((np.ptp(picture.astype(int), axis=-1) > 40).mean())


def frames_of(film: Path, shape: tuple[int, int]) -> list[np.ndarray]:
    """The pictures, so high and so wide, of a GIF, which leaves out repetitions, or an MP4."""
    if film.suffix == ".gif":
        with Image.open(film) as opened:
            return [np.asarray(frame.convert("RGB")) for frame in ImageSequence.Iterator(opened)]
    read = [
        imageio_ffmpeg.get_ffmpeg_exe(),
        "-v",
        "error",
        "-i",
        film,
        "-f",
        "rawvideo",
        "-pix_fmt",
        "rgb24",
        "-",
    ]
    raw = subprocess.run(read, capture_output=True, check=True).stdout
    return list(np.frombuffer(raw, np.uint8).reshape(-1, *shape, 3))


def assert_moves(film: Path, width: int, count: int = 10**9) -> None:
    """A film of pictures of this width, that many of them at most, which differ and show something."""
    shape = width * 9 // 16, width
    frames = frames_of(film, shape)
    assert 1 < len(frames) <= count
    assert all(frame.shape == (*shape, 3) and coloured(frame) > 3e-3 for frame in frames)
    assert any(np.any(frame != frames[0]) for frame in frames)
