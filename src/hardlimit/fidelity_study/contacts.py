"""Statistics of single contacts from the logs: restitution, and whether contacts of a particle overlap in time."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..boxes.box import Floats
from ..boxes.contacts import Indices, of_pairs
from ..boxes.result import ContactResult, ParticleResult
from ..boxes.system import ParticleSystem
from ..contact.contact import Law

#: Edges of the histogram of restitutions; the last bin includes all larger values.
EDGES: Final = np.linspace(0.0, 1.2, 61)
#: Restitutions are rounded to this number of decimals, about the accuracy of the engines, so that a value at the edge
#: of a bin always falls into the same bin.
DECIMALS: Final = 8


class Contacts(NamedTuple):
    """The contacts, or collisions, of a run in the order of their beginning."""

    restitution: Floats  #: separation speed over impact speed
    overlapped: NDArray[np.bool_]  #: whether another contact of a partner overlapped in time

    @property
    def overlapped_share(self) -> float:
        """Fraction of the contacts that overlapped; NaN without contacts."""
        return float(self.overlapped.mean()) if len(self.overlapped) else math.nan

    @property
    def median(self) -> float:
        """Median restitution; NaN without contacts."""
        return float(np.median(self.restitution)) if len(self.restitution) else math.nan

    @property
    def histogram(self) -> Floats:
        """Fraction of the contacts in each bin; NaN without contacts."""
        counts, _ = np.histogram(np.minimum(self.restitution, EDGES[-1]), EDGES)
        with np.errstate(invalid="ignore"):
            return counts / np.float64(len(self.restitution))


def of_newton(result: ContactResult) -> Contacts:
    """The contacts that have ended and began with an approach. (A force that switches on again may begin without.)"""
    assert result.log is not None
    _, end, _, _, impact, separation, overlapped, *_ = result.log
    good = np.isfinite(end) & (impact > 0.0)
    return Contacts(np.round(separation[good] / impact[good], DECIMALS), overlapped[good])


def of_hard_spheres(system: ParticleSystem, law: Law, result: ParticleResult) -> Contacts:
    """The collisions with a finite restitution. A collision counts as overlapped if a contact under ``law`` at its
    impact speed would still last at the next collision of either partner."""
    assert result.log is not None
    time, first, second, impact, separation, *_ = result.log
    end = time + durations(system, law, first, second, impact)
    before, after = neighbours(time, first, second)
    latest = np.where(before < 0, -math.inf, end[before]).max(axis=1, initial=-math.inf)
    soonest = np.where(after < 0, math.inf, time[after]).min(axis=1, initial=math.inf)
    good = (impact > 0.0) & np.isfinite(separation)
    overlapped = (latest > time) | (soonest < end)
    return Contacts(np.round(separation[good] / impact[good], DECIMALS), overlapped[good])


def neighbours(time: Floats, first: Indices, second: Indices) -> tuple[Indices, Indices]:
    """Rows (n, 2) of the previous and the next collision of either partner; −1 if there is none, or for a wall."""
    n = len(time)
    who, row = np.concatenate([first, second]), np.tile(np.arange(n), 2)
    order = np.lexsort((row, who))
    same = (who[order][1:] == who[order][:-1]) & (who[order][1:] >= 0)
    before, after = np.full(2 * n, -1), np.full(2 * n, -1)
    before[order[1:][same]] = row[order[:-1][same]]
    after[order[:-1][same]] = row[order[1:][same]]
    return before.reshape(2, n).T, after.reshape(2, n).T


def durations(system: ParticleSystem, law: Law, first: Indices, second: Indices, speed: Floats) -> Floats:
    """Durations [s] of isolated contacts at these impact speeds [m/s]; a negative ``second`` is a wall."""
    lengths = np.empty(len(first))
    for rows, contact in of_pairs(system, law, first, second):
        lengths[rows] = contact.duration(np.ascontiguousarray(speed[rows]))
    return lengths
