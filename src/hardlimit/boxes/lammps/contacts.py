"""The log of contacts, assembled from the begins and ends of their forces."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..box import Floats
from .forces import Integers
from .touching import Change


class Contacts(NamedTuple):
    """The columns of the log of a result, ordered by ``begin``."""

    begin: Floats
    end: Floats  #: NaN: still open
    first: Integers
    second: Integers
    impact_speed: Floats
    separation_speed: Floats
    overlapped: NDArray[np.bool_]


def contacts(begins: Sequence[Change], ends: Sequence[Change]) -> Contacts:
    """Match begins and ends. Those of a pair alternate, and its last end may be missing."""
    begun, ended = _sorted(begins), _sorted(ends)
    n = len(begun.first)
    closed = _ordinal(begun) < _count_of(begun, ended)
    end, separation = np.full(n, np.nan), np.full(n, np.nan)
    end[closed], separation[closed] = ended.time, ended.speed
    order = np.lexsort((begun.second, begun.first, begun.time))
    columns: tuple[Any, ...] = (begun.time, end, begun.first, begun.second, begun.speed, separation)
    columns = tuple(column[order] for column in columns)
    return Contacts._make([*columns, overlapped(*columns[:4])])


def _sorted(parts: Sequence[Change]) -> Change:
    """Concatenate the parts, sorted by pair and then by time."""
    first, second, time, speed = (np.concatenate(column) for column in zip(*parts, strict=True))
    order = np.lexsort((time, second, first))
    return Change(first[order], second[order], time[order], speed[order])


def _ordinal(one: Change) -> Integers:
    """For each entry, the number of earlier entries of its pair."""
    starts = np.flatnonzero(_changes(one))
    before: Integers = starts[np.cumsum(_changes(one)) - 1]
    return np.arange(len(one.first)) - before


def _count_of(one: Change, other: Change) -> Integers:
    """For each entry of ``one``, the number of entries that its pair has in ``other``."""
    starts = np.flatnonzero(_changes(other))
    sizes = np.diff(np.append(starts, len(other.first))).tolist()
    keys = zip(other.first[starts].tolist(), other.second[starts].tolist(), strict=True)
    found = dict(zip(keys, sizes, strict=True))
    pairs = zip(one.first.tolist(), one.second.tolist(), strict=True)
    return np.array([found.get(pair, 0) for pair in pairs], np.int64)


def _changes(one: Change) -> NDArray[np.bool_]:
    """True at the first entry of each pair."""
    different = (np.diff(one.first) != 0) | (np.diff(one.second) != 0)
    return np.concatenate([[True], different]) if len(one.first) else np.zeros(0, bool)


def overlapped(begin: Floats, end: Floats, first: Integers, second: Integers) -> NDArray[np.bool_]:
    """Whether each contact shared a particle with another contact while both lasted."""
    n = len(begin)
    particles = second >= 0
    contact = np.concatenate([np.arange(n), np.flatnonzero(particles)])
    body = np.concatenate([first, second[particles]])
    order = np.lexsort((begin[contact], body))
    contact, body = contact[order], body[order]
    starts, stops = begin[contact], np.where(np.isnan(end), np.inf, end)[contact]
    found = np.zeros(n, bool)
    latest, owner, last = -np.inf, -1, -1  # latest end of the particle's contacts, its row, the particle
    for k, (b, start, stop) in enumerate(zip(body.tolist(), starts.tolist(), stops.tolist(), strict=True)):
        if b != last:
            latest, last = -np.inf, b
        if start < latest:
            found[contact[k]] = found[owner] = True
        if stop > latest:
            latest, owner = stop, contact[k]
    return found
