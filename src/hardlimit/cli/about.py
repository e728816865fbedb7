"""Small commands and ``--version``: citations, shell completion, the explorer page, installed packages."""

from __future__ import annotations

import platform
import re
from importlib import metadata

import click
from click.shell_completion import get_completion_class

from .. import __version__, _core
from ..support import citations
from .printing import console, show, table
from .program import Command

# --- hardlimit cite -----------------------------------------------------------------------------------------


@click.command(
    cls=Command,
    aliases={"topic": "TOPIC"},
    epilog="\b\nExample:\n  hardlimit cite newton viscoelastic > references.bib",
)
@click.argument("topics", nargs=-1, metavar="[TOPIC]...")
def cite(topics: tuple[str, ...]) -> None:
    """Print BibTeX entries for the package and the methods you used.

    A TOPIC is a model, contact law, collision rule, engine, kind of box, tool or figure. Without one, this prints a
    table of all topics.
    """
    if topics:
        return click.echo(citations.bibtex(*topics), nl=False)
    rows = []
    for kind, names in citations.topics().items():
        for name in names:
            works = "; ".join(map(citations.in_words, citations.publications(name)))
            rows.append([kind if name == names[0] else "", name, works])
    content = table(["", "topic", "publications"], rows, left=3)
    show(console(), "Publications to cite", content, "BibTeX: hardlimit cite TOPIC")


# --- hardlimit completion -----------------------------------------------------------------------------------

#: How to install the script in each shell.
INSTALL = {
    "bash": "hardlimit completion bash >> ~/.bashrc",
    "zsh": "hardlimit completion zsh >> ~/.zshrc",
    "fish": "hardlimit completion fish > ~/.config/fish/completions/hardlimit.fish",
}


@click.command(cls=Command, epilog="\b\nExample:\n  " + "\n  ".join(INSTALL.values()))
@click.argument("shell", type=click.Choice(list(INSTALL)))
def completion(shell: str) -> None:
    """Print a script that completes commands in your shell.

    Install the script as in the example and open a new shell.
    """
    shell_class = get_completion_class(shell)
    if shell_class is None:
        raise RuntimeError(f"completion: click does not support {shell}")
    from . import main

    script = shell_class(main, {}, "hardlimit", "_HARDLIMIT_COMPLETE")
    click.echo(f"# Install with: {INSTALL[shell]}")
    click.echo(script.source_template % script.source_vars())


# --- hardlimit explore --------------------------------------------------------------------------------------


@click.command(cls=Command, epilog="\b\nExample:\n  hardlimit explore --gas --port 8765")
@click.option(
    "--port",
    type=click.IntRange(0, 65535),
    default=8000,
    show_default=True,
    help="Port of the page; 0 takes any free port.",
)
@click.option("--browser/--no-browser", "open_browser", default=True, help="Open the page in a browser.")
@click.option(
    "--gas", is_flag=True, help="Open the page of a gas of disks, event-driven beside Newton's equations."
)
def explore(port: int, open_browser: bool, gas: bool) -> None:
    """Serve the interactive page on 127.0.0.1 until Ctrl-C."""
    from ..explorer import server

    server.serve(port, open_browser, "gas.html" if gas else "")


# --- hardlimit --version ------------------------------------------------------------------------------------

#: Extras for developers of the package.
FOR_DEVELOPERS = ("dev", "docs", "test")


def brief() -> str:
    """The line of ``--version``."""
    return f"hardlimit, version {__version__}"


def verbose() -> str:
    """Version, compiler, platform and installed extras, as bug reports need them."""
    widest, *others = _core.instruction_sets()
    facts = {
        "compiled by": _core.compiler(),
        "instruction set": f"{widest} (also available: {', '.join(others) or 'none'})",
        "Python": f"{platform.python_version()}, {platform.system()} {platform.machine()}",
        **{name: version_of(name) or "not found" for name in ("numpy", "xarray", "matplotlib")},
    }
    lines = [brief(), *(f"{name + ':':<17} {fact}" for name, fact in facts.items()), "extras:"]
    for extra, packages in extras().items():
        missing = ", ".join(name for name in packages if version_of(name) is None)
        versions = ", ".join(f"{name} {version_of(name)}" for name in packages)
        status = f"{missing} not found: pip install 'hardlimit[{extra}]'" if missing else versions
        lines.append(f"  {extra + ':':<15} {status}")
    return "\n".join(lines)


def extras() -> dict[str, list[str]]:
    """The packages of each extra for users."""
    requirements: dict[str, list[str]] = {}
    for requirement in metadata.requires("hardlimit") or ():
        name = re.match(r"[\w.-]+", requirement)
        extra = re.search(r"""extra == ["'](\w+)["']""", requirement)
        if name and extra and extra[1] not in FOR_DEVELOPERS:
            requirements.setdefault(extra[1], []).append(name[0])
    return requirements


def version_of(package: str) -> str | None:
    """The version of a package, or None if it is not installed."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None
