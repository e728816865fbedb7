"""Müller and Pöschel, Phys. Rev. E 83, 041304 (2011), end to end: every figure, and what the text states.

``setup`` holds the paper's columns, ``figure2`` … ``figure8`` compute the data of one figure each,
``drawings`` draws them, ``statements``, ``misprints`` and ``density`` compare with the text.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from ..column.scenario import PAPER_DENSITY
from ..support import saving, validation
from . import density as inference
from . import misprints, statements
from .data import FIGURES, Data
from .report import Report, Row
from .setup import Setup

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["FIGURES", "FORMATS", "Report", "Row", "run"]

FORMATS: Final = ("png", "pdf", "svg")

#: Called with the part done, 0 to 1, and what is being done.
Progress = Callable[[float, str], object]

#: Rough shares of the running time.
_WEIGHTS: Final = {2: 1.0, 3: 1.5, 4: 20.0, 5: 1.0, 6: 1.0, 7: 3.0, 8: 2.5, "statements": 2.0, "density": 4.0}


def run(
    out: str | Path = "hardlimit-paper",
    figures: Iterable[int | str] | str | None = None,
    density: float = PAPER_DENSITY,
    format: str = "png",
    infer_density: bool = False,
    progress: Progress | None = None,
    dpi: float | None = None,
) -> Report:
    """Compute the figures and the statements of the paper and write them to a folder.

    Parameters
    ----------
    out : path
        Folder, made if it is missing; holds ``fig2.png``, ``fig2.nc``, … and ``report.md``.
    figures : list of int, or text such as "2,3,4", optional
        All by default. Statements that need an omitted figure are omitted as well.
    density : float [kg/m³]
        Of both balls; the paper prints none.
    format : {"png", "pdf", "svg"}
    infer_density : bool
        Scan the density for the facts that the paper states; also writes ``density.png`` and ``density.nc``.
    progress : callable(part, text), optional
        ``part`` runs from 0 to 1.
    dpi : float, optional
        Resolution of the pictures [dots per inch], 20 to 2400; 200 by default, 300 is what journals ask for.

    Raises
    ------
    ValueError
        For an unknown figure or format, a density or a resolution outside its range, or a folder that cannot be
        written.
    """
    started = time.perf_counter()
    chosen = _figures(figures)
    setup = Setup(validation.number("density", density, 0.0))
    if format not in FORMATS:
        raise ValueError(f"format: got {format!r}, must be one of {', '.join(FORMATS)}")
    look = _Look(format, _resolution(dpi))
    folder = _writable(out)
    steps: list[Any] = [*chosen, "statements", *(["density"] if infer_density else [])]
    track = _Track(steps, progress)

    report = Report(folder, setup.density)
    data = Data(setup, track.within)
    for number in chosen:
        track.begin(number, f"Fig. {number}")
        report.files += _write_figure(folder, number, data, look)
        report.meanings[number] = str(data.figure(number).attrs["meaning"])
        report.choices[number] = str(data.figure(number).attrs["choices"])
    track.begin("statements", "statements of the text")
    report.rows = statements.rows(data, chosen, track.within)
    scan = None
    if infer_density:
        track.begin("density", "density")
        scan = inference.infer(track.within)
        report.files += _write_density(folder, scan.assign_attrs(data.attributes("Fig. 3 and text")), look)
    report.rows += [*inference.rows(setup, scan), *misprints.rows(setup)]
    report.wall_time = time.perf_counter() - started
    page = folder / "report.md"
    saving.write(page, report.to_markdown().encode())
    report.files.append(page)
    track.end()
    return report


def _resolution(dpi: float | None) -> float:
    from ..plots.style import checked_resolution  # drawing is imported when something is drawn

    return checked_resolution(dpi)


def _figures(figures: Iterable[int | str] | str | None) -> tuple[int, ...]:
    """The figures asked for, in order and once each."""
    if figures is None:
        return tuple(FIGURES)
    if isinstance(figures, int):
        figures = [figures]
    names = figures.split(",") if isinstance(figures, str) else list(figures)
    known = {str(number): number for number in FIGURES}
    chosen = set()
    for name in names:
        text = str(name).strip()
        if isinstance(name, bool) or text not in known:
            raise ValueError(f"figures: got {text!r}, must be among {', '.join(known)}")
        chosen.add(known[text])
    if not chosen:
        raise ValueError(f"figures: got none, must be among {', '.join(known)}")
    return tuple(sorted(chosen))


def _writable(out: str | Path) -> Path:
    """The folder, made, and seen to take a file."""
    folder = Path(out)
    probe = folder / ".hardlimit-write-test"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe.write_bytes(b"")
        probe.unlink()
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise ValueError(f"out: got {str(out)!r}, must be a folder that can be written: {reason}") from None
    return folder


class _Look(NamedTuple):
    """How the pictures are written."""

    format: str
    dpi: float


def _write_figure(folder: Path, number: int, data: Data, look: _Look) -> list[Path]:
    from . import drawings

    return _write(
        folder / f"fig{number}", drawings.draw(number, data.figure(number)), data.figure(number), look
    )


def _write_density(folder: Path, scan: xr.Dataset, look: _Look) -> list[Path]:
    from . import drawings

    return _write(folder / "density", drawings.density(scan), scan, look)


def _write(stem: Path, figure: Figure, data: xr.Dataset, look: _Look) -> list[Path]:
    """One figure as a picture and as data."""
    from ..plots.style import save

    picture = save(figure, stem.with_name(f"{stem.name}.{look.format}"), look.dpi)
    return [picture, _write_data(data, stem.with_name(f"{stem.name}.nc"))]


def _write_data(data: xr.Dataset, path: Path) -> Path:
    large = {
        name: {"zlib": True, "complevel": 4, "shuffle": True}
        for name, v in data.variables.items()
        if v.size > 10_000
    }
    return saving.dataset(data, path, large)


class _Track:
    """Turns the progress of single steps into the part of the whole."""

    def __init__(self, steps: list[Any], progress: Progress | None) -> None:
        self._steps = steps
        self._progress = progress
        self._total = sum(_WEIGHTS[step] for step in steps)
        self._before = 0.0
        self._step: Any = None
        self._text = ""

    def begin(self, step: Any, text: str) -> None:
        """The next step starts."""
        done = self._steps[: self._steps.index(step)]
        self._before, self._step, self._text = sum(_WEIGHTS[s] for s in done), step, text
        self.within(0.0)

    def within(self, part: float) -> None:
        """Part of the present step that is done."""
        if self._progress is not None and self._step is not None:
            self._progress((self._before + part * _WEIGHTS[self._step]) / self._total, self._text)

    def end(self) -> None:
        """All steps are done."""
        if self._progress is not None:
            self._progress(1.0, "done")
