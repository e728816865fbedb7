"""The options of a check, and the run that stands for systems and balls without a script."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from ..boxes.time_step import DEFAULT_ERROR
from . import drive, loads
from .scripts import Quote, Stage
from .supplied import NOTHING, Supplied

NO_LOAD, NO_SUPPORT = loads.LoadOptions(), drive.Support(False, False)
#: Impact speeds [m/s] at which contacts are shown if no speed is given and they depend on it.
CHOSEN_SPEEDS: Final = (0.01, 0.1, 1.0)
NO_RUN: Final = Stage(
    quote=Quote("", 0, ""),
    time_step=None,
    time_step_given=False,
    steps=None,
    contacts=(),
    grains={},
    gravity=None,
    numerical_damping=None,
)


@dataclass(frozen=True)
class Options:
    """The options of a check, in SI units or in those of a script in ``lj`` units."""

    dump: Path | None
    speeds: tuple[float, ...]
    packing_fraction: float | None
    variables: Mapping[str, str]
    drive: drive.Drive | None = None
    restitution_error: float = DEFAULT_ERROR
    load: loads.LoadOptions = NO_LOAD
    supplied: Supplied = NOTHING
