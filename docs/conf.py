import inspect
import shutil
from importlib import metadata, resources
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

project = "hardlimit"
author = "The hardlimit authors"
project_copyright = author
release = metadata.version("hardlimit")

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.mathjax", "sphinx.ext.napoleon"]
myst_enable_extensions = ["dollarmath", "amsmath", "deflist"]
exclude_patterns = ["_build", "generated"]
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented_params"
autodoc_type_aliases = {name: name for name in ("NDArray", "Floats", "Values", "Vector", "ArrayLike")}
# Roles such as :func: must lead somewhere, classes if they are ours: the types of parameters are in words.
nitpicky = True
nitpick_ignore_regex = [("py:class", r"(?!hardlimit\.).*"), (r"(?!py:).*", ".*")]
html_theme = "furo"
html_title = f"hardlimit {release}"

COLON = "\ue000"  # stands for a colon while Napoleon reads


def copy_explorer(app: Sphinx, failed: Exception | None) -> None:
    """Put the explorer's page beside the documentation, which frames single panels of it."""
    if failed is None and app.builder.format == "html":
        with resources.as_file(resources.files("hardlimit.explorer") / "page") as page:
            shutil.copytree(page, Path(app.outdir) / "explorer-page", dirs_exist_ok=True)


def hide_signature(app: Sphinx, what: str, name: str, item: Any, *given: Any) -> tuple[str, str] | None:
    """No signature for a class that functions make: one without a section Parameters in its docstring."""
    made = what == "class" and "\nParameters\n---" not in (inspect.getdoc(item) or "")
    return ("", "") if made else None


def hide_colons(app: Sphinx, what: str, name: str, item: Any, options: Any, lines: list[str]) -> None:
    """Napoleon takes what stands before a colon in the first line of a property or a field for its type."""
    if what in ("attribute", "data", "property"):
        lines[:1] = [line.replace(":", COLON) for line in lines[:1]]


def show_colons(app: Sphinx, what: str, name: str, item: Any, options: Any, lines: list[str]) -> None:
    lines[:] = [line.replace(COLON, ":") for line in lines]


def setup(app: Sphinx) -> None:
    app.connect("build-finished", copy_explorer)
    app.connect("autodoc-process-signature", hide_signature)
    app.connect("autodoc-process-docstring", hide_colons, priority=400)  # Napoleon's is 500
    app.connect("autodoc-process-docstring", show_colons, priority=600)
