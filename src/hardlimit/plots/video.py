"""Files of frames: MP4 by the ffmpeg that imageio-ffmpeg brings, GIF by Pillow."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

Frame = Any  #: NDArray[np.uint8], height × width × 3


def require_ffmpeg() -> Any:
    """The module imageio_ffmpeg.

    Raises
    ------
    ValueError
        If it is not installed.
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
    """Write the frames, width × height even, as H.264.

    Raises
    ------
    OSError
        If ffmpeg does not write all of them.
    """
    ffmpeg = require_ffmpeg()
    options = ["-preset", "medium", "-crf", "23", "-tune", "animation", "-movflags", "+faststart"]
    writer = ffmpeg.write_frames(
        str(path.resolve()),
        size,
        fps=rate,
        codec="libx264",
        quality=None,  # that of -crf
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
    # The writer does not say whether ffmpeg could finish the file: a disk may be full.
    if not path.is_file() or ffmpeg.count_frames_and_secs(path)[0] != sent:
        raise OSError("ffmpeg did not finish the file")


def write_gif(path: Path, pictures: Iterator[Frame], size: tuple[int, int], rate: int) -> None:
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
