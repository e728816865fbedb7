import shutil
import sys
from importlib import metadata, resources
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment

project = "hardlimit"
author = "The hardlimit authors"
project_copyright = author
release = metadata.version("hardlimit")

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.mathjax", "sphinx.ext.napoleon"]
myst_enable_extensions = ["dollarmath", "amsmath", "deflist"]
exclude_patterns = ["_build", "generated", "gallery", "auto_gallery/**/*.ipynb"]
autodoc_member_order = "bysource"
autodoc_typehints = "description"
html_theme = "furo"
html_title = f"hardlimit {release}"

# Lessons (MyST-NB) and gallery are executed; an error ends the build. Neither asks for anything from another site.
extensions.append("sphinx_gallery.gen_gallery")
html_static_path = ["_static"]
html_css_files = ["gallery.css"]
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 120  # seconds for a cell
nb_ipywidgets_js: dict[str, dict[str, str]] = {}
sys.path.insert(0, str(Path(__file__).parent))  # gallery_figures
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


def copy_explorer(app: Sphinx, failed: Exception | None) -> None:
    """Put the explorer's page beside the documentation, which frames single panels of it."""
    if failed is None and app.builder.format == "html":
        with resources.as_file(resources.files("hardlimit.explorer") / "page") as page:
            shutil.copytree(page, Path(app.outdir) / "explorer-page", dirs_exist_ok=True)


def read_lessons_first(app: Sphinx, env: BuildEnvironment, names: list[str]) -> None:
    """The list of lessons offers notebooks for download, which are written when the lessons are read."""
    names.sort(key=lambda name: name == "notebooks/index")  # a stable sort


def setup(app: Sphinx) -> None:
    app.connect("env-before-read-docs", read_lessons_first)
    app.connect("build-finished", copy_explorer)
