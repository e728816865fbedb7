"""How deep contacts are pressed: where contact laws end, and the warning before that."""

from __future__ import annotations

import warnings
from typing import Final

from .. import _core

#: Greatest compression for which a law is meant, over the smaller radius; a run that reaches it ends as too_deep.
DEEPEST: Final = _core.deepest_compression
#: From here on results come with a warning.
DEEP: Final = 0.05
#: Without the number, so that Python shows it once for many results of one line.
WARNING: Final = (
    f"contacts were compressed by more than {100.0 * DEEP:g} % of the smaller radius, by how much largest_compression "
    f"says; contact laws describe a few per cent, and none more than {100.0 * DEEPEST:g} %"
)


class CompressionWarning(UserWarning):
    """Contacts were compressed by more than a twentieth of the smaller radius, where contact laws begin to be wrong.

    Examples
    --------
    >>> import warnings
    >>> warnings.simplefilter("ignore", hl.CompressionWarning)
    """


def too_soft(largest: float | None) -> str | None:
    """What there is to say of the largest compression of a run, over the smaller radius; None where it is small."""
    if largest is None or not largest >= DEEP:
        return None
    digits = 0 if largest >= 0.1 else 1
    return (
        f"contacts were compressed by up to {100.0 * largest:.{digits}f} % of the smaller radius; contact laws "
        f"describe a few per cent, and none more than {100.0 * DEEPEST:g} %"
    )


def rows(largest: float | None) -> list[tuple[str, float]]:
    """Of a table of results: the largest compression, if it is known."""
    return [] if largest is None else [("largest compression [smaller radius]", largest)]


def warn(largest: float | None, stacklevel: int = 4) -> None:
    """Warn if contacts were deep; ``stacklevel`` is that of :func:`warnings.warn`, 4 for who called a solver's run."""
    if largest is not None and largest >= DEEP:
        warnings.warn(WARNING, CompressionWarning, stacklevel=stacklevel)
