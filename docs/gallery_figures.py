"""What sphinx-gallery asks of the gallery: the order of its pictures, and the figures that a script shows."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.figure import Figure
from PIL import Image
from sphinx_gallery.scrapers import figure_rst

from hardlimit import plots

#: Sections, and in each the scripts from the first question to the last.
ORDER = {
    "two_balls": "heights forces effective_restitution gap contact_count radius_ratio energy adiabatic oblique",
    "contacts": "laws duration force_loops usual_damping series superballs oblique_impacts codes time_step check "
    "bouncing_ball fit",
    "rows": "cradle light_ball best_masses astro_blaster beads",
    "grains": "maxwell pressure atmosphere cooling two_fates heated heated_rotation sheared shaken rolling "
    "overlaps rules",
}
SCRIPTS = [f"plot_{name}.py" for names in ORDER.values() for name in names.split()]
DPI = 100  #: of the pictures in the page; screens of high resolution get twice as much


class Place:
    """Sort key of the scripts of a section, which sphinx-gallery makes with the folder of the section."""

    def __init__(self, folder: str) -> None:
        self.folder = folder

    def __call__(self, filename: str) -> int:
        """
        Raises
        ------
        ValueError
            If the script has no place in ``ORDER``.
        """
        return SCRIPTS.index(filename)


def scrape(block: Any, variables: dict[str, Any], settings: dict[str, Any]) -> str:
    """Save the figures of a block of code as pictures: pyplot's, and the one that its last line is.

    ``plot()`` of a result returns a figure that pyplot does not know, which sphinx-gallery's own scraper would miss.
    """
    names = variables["example_globals"]
    figures = [plt.figure(number) for number in plt.get_fignums()]
    if isinstance(names.get("___"), Figure):  # the name that sphinx-gallery gives to the value of a last line
        figures.append(names["___"])
        names["___"] = None
    title = _title(Path(variables["src_file"]))
    return "".join(
        _saved(figure, Path(path), title, settings["src_dir"])
        for figure, path in zip(figures, variables["image_path_iterator"], strict=False)
    )


def _title(script: Path) -> str:
    """The first line of its docstring."""
    return (ast.get_docstring(ast.parse(script.read_text("utf-8"))) or "").partition("\n")[0]


def _saved(figure: Figure, path: Path, title: str, source: str) -> str:
    """A picture in two resolutions, as reStructuredText with the title of its page as alternative text."""
    double = path.with_stem(f"{path.stem}_2x")
    plots.save(figure, double, 2 * DPI)
    with Image.open(double) as picture:
        picture.reduce(2).save(path)  # sooner than drawing it again
    plt.close(figure)
    return figure_rst([path], source, title, [{0: path, 2.0: double}])
