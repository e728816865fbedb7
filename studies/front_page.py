"""The film of the front page of the documentation, small enough for a page: python studies/front_page.py

Two balls at ε = 0.9 by Newton's equations and by independent collisions, every third frame in 16 colours.
"""

import tempfile
from pathlib import Path

from driver import IMAGES
from PIL import Image, ImageSequence

import hardlimit as hl

STRIDE, COLOURS, WIDTH, RATE = 3, 16, 640, 15


def main():
    drop = hl.newton(hl.Column.paper(restitution=0.9, gap=1e-4))
    with tempfile.TemporaryDirectory() as folder:
        film = drop.animate(Path(folder) / "drop.gif", width=WIDTH, frames_per_second=RATE)
        frames = [frame.convert("RGB") for frame in ImageSequence.Iterator(Image.open(film))][::STRIDE]
    palette = frames[len(frames) // 3].quantize(COLOURS)
    small = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    durations = [1000 * STRIDE // RATE] * (len(small) - 1) + [3000]  # the end stands still
    small[0].save(
        IMAGES / "two_balls.gif",
        save_all=True,
        append_images=small[1:],
        duration=durations,
        loop=0,
        optimize=True,
    )


if __name__ == "__main__":
    main()
