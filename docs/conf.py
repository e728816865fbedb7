import shutil
from importlib import metadata, resources
from pathlib import Path

from sphinx.application import Sphinx

project = "hardlimit"
author = "The hardlimit authors"
project_copyright = author
release = metadata.version("hardlimit")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "sphinx-mathjax-offline",  # MathJax and its fonts go into the site: no formula waits for another host
    "sphinx.ext.napoleon",
    "sphinx_click",
]
myst_enable_extensions = ["dollarmath", "amsmath", "deflist", "colon_fence", "attrs_block"]
myst_heading_anchors = 3
mathjax3_config = {"options": {"enableMenu": False}}  # the menu would load more
exclude_patterns = ["_build", "generated", "findings"]
autodoc_member_order = "bysource"
autodoc_typehints = "description"
html_theme = "furo"
html_title = f"hardlimit {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False


def copy_explorer(app: Sphinx, failed: Exception | None) -> None:
    """Put the explorer's page beside the documentation, which frames single panels of it."""
    if failed is None and app.builder.format == "html":
        with resources.as_file(resources.files("hardlimit.explorer") / "page") as page:
            shutil.copytree(page, Path(app.outdir) / "explorer-page", dirs_exist_ok=True)


def setup(app: Sphinx) -> None:
    app.connect("build-finished", copy_explorer)
