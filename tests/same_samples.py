"""Bit-for-bit comparison of the samples of two runs."""

from typing import Any

import numpy as np


def same_samples(left: Any, other: Any) -> bool:
    """Whether records and observed values of two results are bit-identical."""
    return all(
        mine.keys() == theirs.keys()
        and all(np.array_equal(mine[name], theirs[name], equal_nan=True) for name in mine)
        for mine, theirs in ((left.samples, other.samples), (_observed(left), _observed(other)))
    )


def _observed(run: Any) -> dict[str, Any]:
    """Values and coordinates of ``observe``."""
    return {name: each.values for part in run.observed for name, each in part.items()}
