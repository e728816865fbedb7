"""What the logs say of single contacts: restitution, and whether another contact of a partner overlaps in time."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..boxes.box import Floats
from ..boxes.falling_frame import law_arguments
from ..boxes.result import ContactResult, ParticleResult
from ..boxes.system import ParticleSystem
from ..contact.contact import Law

Flags = NDArray[np.bool_]

#: Edges of the histogram of restitutions; whatever lies beyond the last one counts in the last bin.
EDGES: Final = np.linspace(0.0, 1.2, 61)


class Encounters(NamedTuple):
    """The contacts, or collisions, of a run in the order of their begins."""

    restitution: Floats  #: separation speed over impact speed
    overlapped: Flags  #: shared a particle with another one while it lasted

    @property
    def overlapped_share(self) -> float:
        """NaN without contacts."""
        return float(self.overlapped.mean()) if len(self.overlapped) else math.nan

    @property
    def median(self) -> float:
        """Of the restitutions; NaN without contacts."""
        return float(np.median(self.restitution)) if len(self.restitution) else math.nan

    @property
    def histogram(self) -> Floats:
        """Share of the contacts in each bin; NaN without contacts."""
        counts, _ = np.histogram(np.minimum(self.restitution, EDGES[-1]), EDGES)
        with np.errstate(invalid="ignore"):
            return counts / np.float64(len(self.restitution))


def of_newton(result: ContactResult) -> Encounters:
    """Contacts that ended, whose bodies approached when they began; a force that sets in again while bodies part has
    no restitution."""
    assert result.log is not None
    _, end, _, _, impact, separation, overlapped = result.log
    good = np.isfinite(end) & (impact > 0.0)
    return Encounters(separation[good] / impact[good], overlapped[good])


def of_hard_spheres(system: ParticleSystem, law: Law, result: ParticleResult) -> Encounters:
    """Collisions with the restitution that the rule gave them; they overlap if under ``law`` each would last until one
    of its partners has met someone else, which is what a run of hard spheres can say by itself. (For the rule soft the
    turn of the normal is left out.)"""
    assert result.log is not None
    time, first, second, speed = result.log
    by_law, duration = of_law(system, law, first, second, speed)
    before, after = neighbours(time, first, second)
    settings = result.settings
    given = by_law if settings.restitution is None else np.full(len(time), settings.restitution)
    if settings.contact_duration is not None:
        recent = _since(time, before) < settings.contact_duration
        given = np.where(recent, 1.0, given)
    end = time + duration
    latest = np.where(before < 0, -math.inf, end[before]).max(axis=1, initial=-math.inf)
    soonest = np.where(after < 0, math.inf, time[after]).min(axis=1, initial=math.inf)
    return Encounters(given, (latest > time) | (soonest < end))


def neighbours(
    time: Floats, first: NDArray[np.int64], second: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows (n, 2) of the collision before and after of either partner, −1 where there is none or it is a wall."""
    n = len(time)
    who, row = np.concatenate([first, second]), np.tile(np.arange(n), 2)
    order = np.lexsort((row, who))
    same = (who[order][1:] == who[order][:-1]) & (who[order][1:] >= 0)
    before, after = np.full(2 * n, -1), np.full(2 * n, -1)
    before[order[1:][same]] = row[order[:-1][same]]
    after[order[:-1][same]] = row[order[1:][same]]
    return before.reshape(2, n).T, after.reshape(2, n).T


def _since(time: Floats, before: NDArray[np.int64]) -> Floats:
    """Time [s] since the last collision of either partner."""
    last = np.where(before < 0, -math.inf, time[before])
    found: Floats = time - last.max(axis=1, initial=-math.inf)
    return found


def of_law(
    system: ParticleSystem, law: Law, first: NDArray[np.int64], second: NDArray[np.int64], speed: Floats
) -> tuple[Floats, Floats]:
    """Restitution and duration [s] of isolated contacts of these pairs at these speeds [m/s]; a negative second is a
    wall."""
    restitution, duration = np.empty(len(first)), np.empty(len(first))
    for rows, contact in _kinds(system, law, first, second):
        at = np.ascontiguousarray(speed[rows])
        restitution[rows], duration[rows] = contact.restitution(at), contact.duration(at)
    return restitution, duration


def _kinds(
    system: ParticleSystem, law: Law, first: NDArray[np.int64], second: NDArray[np.int64]
) -> Iterator[tuple[NDArray[np.int64], _core.Contact]]:
    """Rows of pairs with the same effective mass and radius, and their contact."""
    wall = second < 0
    mass, radius = (
        np.where(wall, values[first], values[first] * values[second] / (values[first] + values[second]))
        for values in (system.mass, system.radius)
    )
    kinds, kind = np.unique(np.stack([mass, radius], axis=1), axis=0, return_inverse=True)
    order = np.argsort(kind.ravel(), kind="stable")
    ends = np.cumsum(np.bincount(kind.ravel(), minlength=len(kinds)))
    for (m, r), rows in zip(kinds.tolist(), np.split(order, ends[:-1]), strict=False):
        if len(rows):
            yield rows, _core.make_contact(*law_arguments(law), m, r)
