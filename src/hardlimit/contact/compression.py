"""Limits of the compression: the one above which there is a warning, and the largest that contact laws describe."""

from __future__ import annotations

import warnings
from typing import Final

from .. import _core

#: Largest compression that laws describe, divided by the smaller radius. A run that reaches it ends as too_deep.
DEEPEST: Final = _core.deepest_compression
#: Compressions above this cause a warning.
DEEP: Final = 0.05
VALIDITY: Final = f"contact laws describe a few per cent, and none more than {100.0 * DEEPEST:g} %"
#: The message contains no number of the run, so that Python shows it only once for many results of one line of code.
WARNING: Final = (
    f"contacts were compressed by more than {100.0 * DEEP:g} % of the smaller radius (see the largest compression); "
    f"{VALIDITY}"
)


class CompressionWarning(UserWarning):
    """Contacts were compressed by more than 5 % of the smaller radius, where contact laws become inaccurate.

    ``warnings.simplefilter("ignore", hl.CompressionWarning)`` turns it off.
    """


def too_soft(largest: float | None) -> str | None:
    """A message if the largest compression of a run, divided by the smaller radius, is large; else None."""
    if largest is None or not largest >= DEEP:
        return None
    percent = f"{100.0 * largest:.{0 if largest >= 0.1 else 1}f} %"
    return f"contacts were compressed by up to {percent} of the smaller radius; {VALIDITY}"


def rows(largest: float | None) -> list[tuple[str, float]]:
    """The row of the largest compression in a table of results, if it is known."""
    return [] if largest is None else [("largest compression [smaller radius]", largest)]


def warn(largest: float | None, stacklevel: int = 4) -> None:
    """Warn if contacts were deep. ``stacklevel`` as in :func:`warnings.warn`; 4 is the caller of a solver."""
    if largest is not None and largest >= DEEP:
        warnings.warn(WARNING, CompressionWarning, stacklevel=stacklevel)
