"""Render film frames and write them to files: MP4 with ffmpeg from imageio-ffmpeg, GIF with Pillow."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final, cast

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from ..support import formatting, saving

Frame = Any  #: NDArray[np.uint8], height × width × 3

#: Changes of the shared style for films.
STYLE: Final = {
    "font__family": "DejaVu Sans",
    "mathtext__fontset": "dejavusans",
    "figure__constrained_layout__use": False,
    "font__size": 9.0,
    "axes__labelsize": 9.0,
    "xtick__labelsize": 8.0,
    "ytick__labelsize": 8.0,
}


class Canvas:
    """A figure, 16:9, whose pixels are the frames; ``width`` in pixels."""

    def __init__(self, width: int) -> None:
        self.figure = Figure(figsize=(9.6, 5.4), dpi=width / 9.6)
        self.canvas = cast(Any, FigureCanvasAgg(self.figure))

    def pixels(self) -> Frame:
        """A copy of the pixels of the figure."""
        return np.asarray(self.canvas.buffer_rgba())[:, :, :3].copy()


def write(path: Path, pictures: Iterator[Frame], width: int, rate: int) -> Path:
    """Write frames of ``width`` pixels, a multiple of 32, as MP4 or GIF, by the ending of ``path``.

    The file appears only when it is complete.

    Raises an OSError if the file cannot be written; names it.
    """
    with saving.whole(path) as unfinished:
        if path.suffix.lower() == ".mp4":
            write_mp4(unfinished, pictures, (width, width * 9 // 16), rate)
        else:
            write_gif(unfinished, pictures, rate)
    return path


def require_ffmpeg() -> Any:
    """Import imageio_ffmpeg.

    Raises a ValueError if it is not installed.
    """
    try:
        import imageio_ffmpeg
    except ImportError:
        raise ValueError(
            "path: got one that ends in .mp4, must end in .gif unless imageio-ffmpeg is installed: "
            "pip install 'hardlimit[film]'"
        ) from None
    return imageio_ffmpeg


def write_mp4(path: Path, pictures: Iterator[Frame], size: tuple[int, int], rate: int) -> None:
    """Write the frames as H.264; width and height are even.

    Raises an OSError if ffmpeg does not write all frames.
    """
    ffmpeg = require_ffmpeg()
    options = ["-preset", "medium", "-crf", "23", "-tune", "animation", "-movflags", "+faststart"]
    writer = ffmpeg.write_frames(
        str(path.resolve()),
        size,
        fps=rate,
        codec="libx264",
        quality=None,  # set by -crf
        macro_block_size=2,
        ffmpeg_log_level="quiet",
        output_params=options,
    )
    writer.send(None)  # starts ffmpeg
    sent = 0
    try:
        for picture in pictures:
            writer.send(picture.tobytes())
            sent += 1
    except OSError:
        raise OSError(f"ffmpeg stopped after {sent} frames") from None
    finally:
        writer.close()
    # The writer does not report whether ffmpeg finished the file.
    try:
        finished = path.is_file() and ffmpeg.count_frames_and_secs(path)[0] == sent
    except RuntimeError:  # the file is damaged
        finished = False
    if not finished:
        raise OSError(
            f"ffmpeg did not finish the file; {formatting.size(shutil.disk_usage(path.parent).free)} are free"
        )


def write_gif(path: Path, pictures: Iterator[Frame], rate: int) -> None:
    """Write the frames with a common palette of 64 colours. Films have few colours, and one palette compresses best."""
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
