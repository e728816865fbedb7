import inspect
import re
import shutil
from importlib import metadata, resources
from pathlib import Path

import click
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
html_favicon = "../web/src/icon.svg"


def copy_explorer(app: Sphinx, failed: Exception | None) -> None:
    """Put the explorer's page beside the documentation, which frames single panels of it."""
    if failed is None and app.builder.format == "html":
        with resources.as_file(resources.files("hardlimit.explorer") / "page") as page:
            shutil.copytree(page, Path(app.outdir) / "explorer-page", dirs_exist_ok=True)


def show_example(app: Sphinx, context: click.Context, lines: list[str]) -> None:
    """The example at the foot of a command's help, as code instead of text."""
    title, _, example = inspect.cleandoc((context.command.epilog or "").replace("\b", "")).partition(":\n")
    if example:
        code = inspect.cleandoc("\n" + example).splitlines()
        lines[:] = [f"**{title}**", "", ".. code-block:: sh", "", *(f"   {line}" for line in code), ""]


def mark_options(app: Sphinx, context: click.Context, lines: list[str]) -> None:
    """Names of options in running text as code, in which two dashes stay two."""
    for i, line in enumerate(lines):
        if not line.lstrip().startswith(".. "):
            lines[i] = re.sub(r"(?<![\w`-])--[a-z][a-z-]*", r"``\g<0>``", line)


def setup(app: Sphinx) -> None:
    for part in ("description", "options"):
        app.connect(f"sphinx-click-process-{part}", mark_options)
    app.connect("sphinx-click-process-epilog", show_example)
    app.connect("build-finished", copy_explorer)
