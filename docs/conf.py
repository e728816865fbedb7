import importlib
import inspect
import re
import shutil
import sys
from importlib import metadata, resources
from pathlib import Path
from typing import Any

import click
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment

project = "hardlimit"
author = "The hardlimit authors"
project_copyright = author
release = metadata.version("hardlimit")

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "sphinx-mathjax-offline",  # MathJax and its fonts go into the site: no formula waits for another host
    "sphinx.ext.napoleon",
    "sphinx_click",
    "sphinx_gallery.gen_gallery",
]
myst_enable_extensions = ["dollarmath", "amsmath", "deflist", "colon_fence", "attrs_block"]
myst_heading_anchors = 3
mathjax3_config = {"options": {"enableMenu": False}}  # the menu would load more
exclude_patterns = ["_build", "generated", "gallery", "auto_gallery/**/*.ipynb"]
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented_params"
autodoc_type_aliases = {name: name for name in ("NDArray", "Floats", "Values", "Vector", "ArrayLike")}
# Every role such as :func: must resolve. Only our own classes must: types of parameters are written in words.
nitpicky = True
nitpick_ignore_regex = [
    ("py:class", r"(?!hardlimit\.).*|hardlimit\.support\.estimate\.T|hardlimit\.contact\.balls\.Floor"),
    (r"(?!py:).*", ".*"),
]
html_theme = "furo"
html_title = f"hardlimit {release}"
html_static_path = ["_static"]
html_css_files = ["site.css", "gallery.css"]
html_copy_source = False
html_favicon = "../web/src/icon.svg"

# Lessons (MyST-NB) and gallery are executed; an error ends the build. Neither loads anything from another site.
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 120  # seconds for a cell
nb_ipywidgets_js: dict[str, dict[str, str]] = {}
sys.path.insert(0, str(Path(__file__).parent))  # gallery_figures, generate
importlib.import_module("generate").write()
sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "auto_gallery",
    "subsection_order": [f"gallery/{section}" for section in ("two_balls", "contacts", "rows", "grains")],
    "within_subsection_order": "gallery_figures.Place",
    "image_scrapers": ("gallery_figures.scrape",),
    "capture_repr": (),
    "first_notebook_cell": "%matplotlib inline",
    "show_signature": False,
    "write_computation_times": False,  # its page loads scripts from elsewhere
    "min_reported_time": 1e6,
}

COLON = "\ue000"  # replaces colons while Napoleon parses a docstring


def copy_explorer(app: Sphinx, failed: Exception | None) -> None:
    """Copy the explorer's page into the site, which frames single panels of it."""
    if failed is None and app.builder.format == "html":
        with resources.as_file(resources.files("hardlimit.explorer") / "page") as page:
            shutil.copytree(page, Path(app.outdir) / "explorer-page", dirs_exist_ok=True)


def show_example(app: Sphinx, context: click.Context, lines: list[str]) -> None:
    """Show the example at the end of a command's help as code."""
    title, _, example = inspect.cleandoc((context.command.epilog or "").replace("\b", "")).partition(":\n")
    if example:
        code = inspect.cleandoc("\n" + example).splitlines()
        lines[:] = [f"**{title}**", "", ".. code-block:: sh", "", *(f"   {line}" for line in code), ""]


def mark_options(app: Sphinx, context: click.Context, lines: list[str]) -> None:
    """Mark names of options in text as code, so that two dashes stay two."""
    for i, line in enumerate(lines):
        if not line.lstrip().startswith(".. "):
            lines[i] = re.sub(r"(?<![\w`-])--[a-z][a-z-]*", r"``\g<0>``", line)


def read_lessons_first(app: Sphinx, env: BuildEnvironment, names: list[str]) -> None:
    """Read the list of lessons last: it links notebooks that are written when the lessons are read."""
    names.sort(key=lambda name: name == "notebooks/index")  # a stable sort


def hide_signature(app: Sphinx, what: str, name: str, item: Any, *_: Any) -> tuple[str, str] | None:
    """Hide the signature of a class that functions return, which has no Parameters section."""
    returned = what == "class" and "\nParameters\n---" not in (inspect.getdoc(item) or "")
    return ("", "") if returned else None


def hide_colons(app: Sphinx, what: str, name: str, item: Any, options: Any, lines: list[str]) -> None:
    """Hide colons in the first line of a property or field, where Napoleon would read a type before it."""
    if what in ("attribute", "data", "property"):
        lines[:1] = [line.replace(":", COLON) for line in lines[:1]]


def show_colons(app: Sphinx, what: str, name: str, item: Any, options: Any, lines: list[str]) -> None:
    lines[:] = [line.replace(COLON, ":") for line in lines]


def setup(app: Sphinx) -> None:
    for part in ("description", "options"):
        app.connect(f"sphinx-click-process-{part}", mark_options)
    app.connect("sphinx-click-process-epilog", show_example)
    app.connect("env-before-read-docs", read_lessons_first)
    app.connect("build-finished", copy_explorer)
    app.connect("autodoc-process-signature", hide_signature)
    app.connect("autodoc-process-docstring", hide_colons, priority=400)  # Napoleon's is 500
    app.connect("autodoc-process-docstring", show_colons, priority=600)
