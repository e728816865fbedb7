"""Read scripts and logs of LAMMPS, LIGGGHTS and YADE. Nothing in them is executed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from .description import ContactSettings, Description, Grains, Note, Quote, Setting, Settings, Stage

__all__ = [
    "ContactSettings",
    "Description",
    "Grains",
    "Note",
    "Quote",
    "Setting",
    "Settings",
    "Stage",
    "read",
]


def read(source: str | Path, *, code: str | None = None, variables: Mapping[str, str] = {}) -> Description:
    """Read a script or a log.

    Parameters
    ----------
    source : str or Path
        Path of a file, or the text itself.
    code : str, optional
        "lammps", "liggghts" or "yade"; found in the text by default.
    variables : mapping of str to str
        Values of variables, as given on the code's command line.

    Raises
    ------
    ValueError
        If the script has no granular contacts or cannot be resolved.
    """
    raise ValueError("script: not read yet")
