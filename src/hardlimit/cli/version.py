"""``hardlimit --version --verbose``: what an installation is made of, for a report of a fault."""

from __future__ import annotations

import platform
import re
from collections.abc import Iterator
from importlib import metadata

from .. import __version__, _core

#: Extras for those who change or document the package itself.
FOR_DEVELOPERS = ("dev", "docs", "test")


def brief() -> str:
    """The one line of ``--version``."""
    return f"hardlimit, version {__version__}"


def verbose() -> str:
    """The version, how it was compiled, what it runs on, and which extras are there."""
    widest, *others = _core.instruction_sets()
    lines = [
        brief(),
        f"compiled by:      {_core.compiler()}",
        f"instruction set:  {widest} (also available: {', '.join(others) or 'none'})",
        f"Python:           {platform.python_version()}, {platform.system()} {platform.machine()}",
        *_aligned(("numpy", "xarray", "matplotlib")),
        "extras:",
    ]
    for extra, packages in extras().items():
        missing = [name for name in packages if version_of(name) is None]
        found = ", ".join(f"{name} {version_of(name)}" for name in packages if name not in missing)
        lines.append(f"  {extra + ':':<15} {found if not missing else missing_extra(extra, missing)}")
    return "\n".join(lines)


def _aligned(packages: tuple[str, ...]) -> Iterator[str]:
    for name in packages:
        yield f"{name + ':':<17} {version_of(name) or 'not found'}"


def missing_extra(extra: str, packages: list[str]) -> str:
    """How to get an extra of which packages are missing."""
    return f"{', '.join(packages)} not found: pip install 'hardlimit[{extra}]'"


def extras() -> dict[str, list[str]]:
    """The packages of each extra, for those who use the package."""
    found: dict[str, list[str]] = {}
    for requirement in metadata.requires("hardlimit") or ():
        name = re.match(r"[\w.-]+", requirement)
        extra = re.search(r"""extra == ["'](\w+)["']""", requirement)
        if name and extra and extra[1] not in FOR_DEVELOPERS:
            found.setdefault(extra[1], []).append(name[0])
    return found


def version_of(package: str) -> str | None:
    """The version of an installed package, or None."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None
