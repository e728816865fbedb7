"""The figures of Müller and Pöschel, Phys. Rev. E 83, 041304 (2011), and checks of the statements in its text.

``setup`` has the paper's columns. ``figure2`` … ``figure8`` each have the data, the drawing and the statements
of a figure. ``collisions``, ``density`` and ``misprints`` check the statements that belong to no figure.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Final

import xarray as xr
from matplotlib.figure import Figure

from ..column.scenario import PAPER_DENSITY
from ..plots.style import checked_resolution, save, style
from ..support import saving, validation
from . import density as inference
from .caption import write_caption
from .misprints import MISPRINTS
from .registry import FIGURES, STATEMENTS
from .report import Report, Row
from .setup import Paper

__all__ = ["FIGURES", "FORMATS", "Report", "Row", "draw", "run"]

FORMATS: Final = ("png", "pdf", "svg")


def run(
    out: str | Path = "hardlimit-paper",
    figures: Iterable[int | str] | str | None = None,
    density: float = PAPER_DENSITY,
    format: str = "png",
    infer_density: bool = False,
    progress: Callable[[float, str], object] | None = None,
    dpi: float | None = None,
) -> Report:
    """Compute the figures and the statements of the paper and write them to a folder.

    Parameters
    ----------
    out : path
        Folder, created if missing, for ``fig2.png``, ``fig2.nc``, … and ``report.md``.
    figures : list of int, or text such as "2,3,4", optional
        All by default. Statements that need an omitted figure are omitted as well.
    density : float [kg/m³]
        Density of both balls; the paper gives none.
    format : {"png", "pdf", "svg"}
    infer_density : bool
        Infer the density from the facts that the paper states, by a scan; writes ``density.png`` and ``density.nc``.
    progress : callable(part, text), optional
        ``part`` runs from 0 to 1.
    dpi : float, optional
        Resolution of the pictures [dots per inch], 20 to 2400; 200 by default. Journals ask for 300.

    Raises
    ------
    ValueError
        For an unknown figure or format, a density or a resolution outside its range, or a folder that cannot be
        written.
    """
    started = time.perf_counter()
    chosen = _figures(figures)
    weights = {f"Fig. {number}": FIGURES[number].WEIGHT for number in chosen}
    weights |= {"statements of the text": 2.0, "density": 4.0 * infer_density}
    track = _Track(weights, progress or (lambda part, text: None))
    paper = Paper(validation.number("density", density, 0.0), track.within, FIGURES)
    if format not in FORMATS:
        raise ValueError(f"format: got {format!r}, must be one of {', '.join(FORMATS)}")
    resolution = checked_resolution(dpi)
    folder = _writable(out)
    report = Report(folder, paper.density)

    def write(name: str, figure: Figure, data: xr.Dataset) -> None:
        picture = save(figure, folder / f"{name}.{format}", resolution)
        compressed = {"zlib": True, "complevel": 4, "shuffle": True}
        large = {key: compressed for key, values in data.variables.items() if values.size > 10_000}
        report.files += [picture, saving.dataset(data, folder / f"{name}.nc", large)]

    for number in chosen:
        track.begin(f"Fig. {number}")
        data = paper.figure(number)
        write(f"fig{number}", draw(number, data), data)
        report.meanings[number] = str(data.attrs["meaning"])
        report.choices[number] = str(data.attrs["choices"])
    track.begin("statements of the text")
    report.rows = STATEMENTS.rows(paper, chosen, progress=track.within)
    scan = None
    if infer_density:
        track.begin("density")
        scan = inference.infer(track.within)
        described = scan.assign_attrs(paper.attributes("Fig. 3 and text"))
        write("density", inference.draw(described), described)
    report.rows += [*inference.rows(paper, scan), *MISPRINTS.rows(paper)]
    report.wall_time = time.perf_counter() - started
    report.files.append(saving.write(folder / "report.md", report.to_markdown().encode()))
    if progress is not None:
        progress(1.0, "done")
    return report


def draw(number: int, data: xr.Dataset) -> Figure:
    """The picture of a figure, with a caption: the parameters, and a sentence for users of event-driven simulations."""
    with style():
        figure: Figure = FIGURES[number].draw(data)
        write_caption(figure, data)
    return figure


def _figures(figures: Iterable[int | str] | str | None) -> tuple[int, ...]:
    """The chosen figures in order, without repetitions."""
    if figures is None:
        return tuple(FIGURES)
    chosen = figures.split(",") if isinstance(figures, str) else figures
    names = [str(name).strip() for name in ([chosen] if isinstance(chosen, int) else chosen)]
    known = {str(number): number for number in FIGURES}
    for got in [name for name in names if name not in known] or ["none"] * (not names):
        shown = repr(got) if names else got
        raise ValueError(f"figures: got {shown}, must be among {', '.join(known)}")
    return tuple(sorted({known[name] for name in names}))


def _writable(out: str | Path) -> Path:
    """Create the folder and check that a file can be written to it."""
    folder = validation.path("out", out)
    probe = folder / ".hardlimit-write-test"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe.write_bytes(b"")
        probe.unlink()
    except OSError as error:
        reason = error.strerror or error
        raise ValueError(f"out: got {str(out)!r}, must be a folder that can be written: {reason}") from None
    return folder


class _Track:
    """Overall progress of steps whose durations are proportional to ``weights``."""

    def __init__(self, weights: dict[str, float], progress: Callable[[float, str], object]) -> None:
        self._weights, self._progress = weights, progress
        self._before, self._step = 0.0, ""

    def begin(self, step: str) -> None:
        """Start the next step."""
        self._before += self._weights.get(self._step, 0.0)
        self._step = step
        self.within(0.0)

    def within(self, part: float) -> None:
        """Report the finished fraction of the current step."""
        done = self._before + part * self._weights[self._step]
        self._progress(done / sum(self._weights.values()), self._step)
