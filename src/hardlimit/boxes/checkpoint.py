"""Checkpoint files, from which a run can continue; each one replaces the previous one as a whole.

A checkpoint is an uncompressed ZIP of NumPy arrays (``numpy.load`` opens it). Its checksums reveal damage.
"""

from __future__ import annotations

import io
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..support import saving, validation

FORMAT: Final = 9  #: version of the file format; files of another version are refused
HEADER: Final = "header"


class CheckpointWarning(UserWarning):
    """The last checkpoint of a run cannot be written; the result is complete, and the previous checkpoint stays."""


def checked_path(path: Any, parameter: str = "checkpoint") -> Path:
    """The path of a checkpoint, checked to be a file that can be written."""
    target = validation.path(parameter, path)
    try:
        good = bool(target.name) and not target.is_dir() and os.access(target.resolve().parent, os.W_OK)
    except OSError:  # the name is too long
        good = False
    if not good:
        shown = validation.shown(str(path))
        raise ValueError(f"{parameter}: got {shown}, must be a file in a folder that can be written")
    return target


def write(path: Path, header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> None:
    facts = {"format": FORMAT, "hardlimit_version": _core.version, "arrays": sorted(arrays), **header}
    content: dict[str, Any] = {HEADER: np.frombuffer(json.dumps(facts).encode(), np.uint8), **arrays}
    archive = io.BytesIO()  # stays open, so that an archive that Ctrl-C interrupts can end itself
    np.savez(archive, **content)
    with saving.whole(path) as unfinished, open(unfinished, "wb") as file:
        file.write(archive.getbuffer())
        file.flush()
        os.fsync(file.fileno())  # before the file replaces the previous checkpoint


def read(path: Any) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    source = validation.path("path", path)
    try:
        with open(source, "rb") as file, np.load(file, allow_pickle=False) as content:
            arrays = {name: content[name] for name in content.files}
        header = json.loads(bytes(arrays.pop(HEADER)))
        written = header["format"], header["hardlimit_version"]
        complete = header.pop("arrays", None) == sorted(arrays)
    except OSError as error:
        raise validation.unreadable(path, error) from None
    except Exception:  # zipfile and NumPy raise many kinds of exceptions for a damaged file
        raise ValueError(f"{path}: not a checkpoint, or damaged") from None
    if written != (FORMAT, _core.version):
        raise ValueError(
            f"{path}: got a checkpoint of hardlimit {validation.shown(written[1])[1:-1]}, must be one of "
            f"{_core.version}: another version may give other bits"
        )
    if not complete:
        raise ValueError(f"{path}: not a checkpoint, or damaged")
    return header, arrays
