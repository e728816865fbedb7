"""A film of a drop: the fall, the contacts in slow motion, the rebound.

A second model, usually independent collisions, runs beside it ("ghost"). The contacts are shown as a close-up
in which gaps and deformations are enlarged more than the balls; the frames state scale and time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final

from ..column.result import Result
from ..column.solvers import independent
from ..support import saving, validation
from . import video
from .stage import CloseUp, Wide
from .storyboard import storyboard
from .style import style
from .video import STYLE, Frame

ENDINGS: Final = (".mp4", ".gif")
WIDTHS: Final = (160, 3840)  #: [pixels]
RATES: Final = (1, 120)  #: frames per second


def animate(
    result: Result,
    path: str | Path,
    *,
    ghost: Result | None = None,
    width: int | None = None,
    frames_per_second: int | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> Path:
    """Write a film of the drop; parameters and errors as for ``Result.animate``."""
    target = saving.checked("path", path, ENDINGS)
    if progress is not None and not callable(progress):
        raise ValueError(f"progress: got {validation.shown(progress)}, must be callable with (done, total)")
    mp4 = target.suffix.lower() == ".mp4"
    if mp4:
        video.require_ffmpeg()
    default_rate, default_width = (30, 1280) if mp4 else (15, 640)
    given_rate = default_rate if frames_per_second is None else frames_per_second
    rate = validation.whole("frames_per_second", given_rate, *RATES)
    given_width = default_width if width is None else width
    pixels = validation.whole("width", given_width, *WIDTHS) // 32 * 32  # 16:9, and even
    if ghost is None:
        ghost = independent(result.column, result.until)
    elif not isinstance(ghost, type(result)) or ghost.column != result.column:
        raise ValueError(f"ghost: got {validation.shown(ghost)}, must be a result of the same column")
    return video.write(target, frames(result, ghost, pixels, rate, progress), pixels, rate)


def frames(
    result: Result, ghost: Result, width: int, rate: int, progress: Callable[[int, int], object] | None = None
) -> Iterator[Frame]:
    """The frames in order."""
    scenes = storyboard(result, ghost, rate)
    total = sum(len(scene.times) for scene in scenes)
    done = 0
    with style(**STYLE):
        for scene in scenes:
            stage = (CloseUp if scene.close_up else Wide)(result, ghost, scene, width)
            for i in range(len(scene.times)):
                yield stage.picture(i)
                done += 1
                if progress is not None:
                    progress(done, total)
