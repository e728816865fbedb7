"""The log of contacts, assembled from the begins and ends of their forces."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..box import Floats
from .forces import Integers
from .overlaps import Change


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
    pairs = np.concatenate([np.stack([change.first, change.second], axis=1) for change in (begun, ended)])
    _, numbers = np.unique(pairs, axis=0, return_inverse=True)
    pair, pair_of_end = np.split(numbers.ravel(), [n])
    earlier = np.arange(n) - np.searchsorted(pair, pair)  # number of earlier contacts of the pair
    closed = earlier < np.bincount(pair_of_end, minlength=pair.max(initial=-1) + 1)[pair]
    end, separation = np.full(n, np.nan), np.full(n, np.nan)
    end[closed], separation[closed] = ended.time, ended.speed
    order = np.lexsort((begun.second, begun.first, begun.time))
    columns: tuple[Any, ...] = begun.time, end, begun.first, begun.second, begun.speed, separation
    begin, end, first, second, impact, separation = (column[order] for column in columns)
    return Contacts(
        begin=begin,
        end=end,
        first=first,
        second=second,
        impact_speed=impact,
        separation_speed=separation,
        overlapped=overlapped(begin, end, first, second),
    )


def _sorted(parts: Sequence[Change]) -> Change:
    """Concatenate the parts, sorted by pair and then by time."""
    first, second, time, speed = (np.concatenate(column) for column in zip(*parts, strict=True))
    order = np.lexsort((time, second, first))
    return Change(first[order], second[order], time[order], speed[order])


def overlapped(begin: Floats, end: Floats, first: Integers, second: Integers) -> NDArray[np.bool_]:
    """Whether each contact shared a particle with another contact while both lasted."""
    particles = second >= 0
    contact = np.concatenate([np.arange(len(begin)), np.flatnonzero(particles)])
    particle = np.concatenate([first, second[particles]])
    order = np.lexsort((begin[contact], particle))
    contact, particle = contact[order], particle[order]
    starts, stops = begin[contact], np.where(np.isnan(end), np.inf, end)[contact]
    # The latest end among the contacts of a particle so far, by an accumulated maximum of (particle, rank of the end).
    times, rank = np.unique(stops, return_inverse=True)
    latest = times[np.maximum.accumulate(particle * len(times) + rank) - particle * len(times)]
    same = particle[1:] == particle[:-1]
    overlaps = np.zeros(len(begin), bool)
    overlaps[contact[1:][same & (starts[1:] < latest[:-1])]] = True
    overlaps[contact[:-1][same & (starts[1:] < stops[:-1])]] = True
    return overlaps
