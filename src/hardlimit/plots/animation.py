"""A film of one drop: the fall, the contacts in slow motion, the rebound.

Beside the balls runs a second model as a ghost, usually the independent collisions. During the contacts
the film is a close-up in which gaps and deformations are drawn larger than the balls; scale and clock stand
on the picture.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from ..column.solvers import independent
from ..support import saving, validation
from . import video
from .stage import STYLE, CloseUp, Frame, Wide
from .storyboard import storyboard
from .style import style

if TYPE_CHECKING:
    from ..column.result import Result

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
    """Write a film of the drop as MP4 or GIF, by the ending of ``path``.

    Parameters
    ----------
    result : Result
    path : path
        A file is only there when it is complete.
    ghost : Result, optional
        A second model of the same column, shown beside; independent collisions by default.
    width : int, optional
        Of the picture in pixels, 160 to 3840, rounded down to a multiple of 32; 16:9. 1280 (MP4) or 640 (GIF)
        by default.
    frames_per_second : int, optional
        1 to 120; 30 (MP4) or 15 (GIF) by default.
    progress : callable(done, total), optional

    Raises
    ------
    ValueError
        If ``path`` is none or has an unknown ending, a number is outside its range, ``ghost`` is not of the same
        column, or MP4 is asked for without imageio-ffmpeg
        (``pip install 'hardlimit[film]'``); GIF needs nothing more.
    OSError
        If the file cannot be written; names it.
    """
    if not isinstance(path, str | os.PathLike):
        raise ValueError(f"path: got {validation.shown(path)}, must be a path")
    if progress is not None and not callable(progress):
        raise ValueError(f"progress: got {validation.shown(progress)}, must be callable with (done, total)")
    target = Path(path)
    film = target.suffix.lower() == ".mp4"
    if target.suffix.lower() not in ENDINGS:
        raise ValueError(f"path: got {str(path)!r}, must end in {' or '.join(ENDINGS)}")
    if not target.parent.is_dir() or not os.access(target.parent, os.W_OK) or target.is_dir():
        raise ValueError(f"path: got {str(path)!r}, must be in a folder that can be written")
    if film:
        video.require_ffmpeg()
    rate = _whole("frames_per_second", frames_per_second, 30 if film else 15, RATES)
    pixels = _whole("width", width, 1280 if film else 640, WIDTHS) // 32 * 32  # 16:9, and even
    other = independent(result.column, result.until) if ghost is None else _ghost(ghost, result)
    pictures = frames(result, other, pixels, rate, progress)
    with saving.whole(target) as unfinished:
        write = video.write_mp4 if film else video.write_gif
        write(unfinished, pictures, (pixels, pixels * 9 // 16), rate)
    return target


def _whole(name: str, value: int | None, default: int, limits: tuple[int, int]) -> int:
    """``value`` as an integer within the limits; ``default`` for None."""
    if value is None:
        return default
    return validation.whole(name, value, *limits)


def _ghost(ghost: Any, result: Result) -> Result:
    """A second model of the same column."""
    if not isinstance(ghost, type(result)) or ghost.column != result.column:
        raise ValueError(f"ghost: got {validation.shown(ghost)}, must be a result of the same column")
    return ghost


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
    with style(**STYLE):
        for scene in scenes:
            stage = (CloseUp if scene.close_up else Wide)(result, ghost, scene, width)
            for i in range(len(scene.times)):
                yield stage.picture(i)
                done += 1
                if progress is not None:
                    progress(done, total)
