"""Gravity in a script of LAMMPS or LIGGGHTS: all ``fix gravity`` that hold."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from .commands import is_variable
from .description import Direction

if TYPE_CHECKING:
    from .state import Fix, State

DIRECTIONS: Final = (("chute",), ("spherical",), ("vector",))


def strength(state: State) -> float | None:
    """The magnitude of gravity."""
    pull = _pulls(state)
    if len(pull) > 1:
        total = _total(state, pull)
        return None if total is None else math.hypot(*total) or None
    return _strength(state, pull[0]) if pull else None


def down(state: State) -> Direction | None:
    """The direction of gravity."""
    pull = _pulls(state)
    if len(pull) != 1:
        total = _total(state, pull)
        size = math.hypot(*total or (0.0,))
        return tuple(part / size for part in total) if total and size > 0.0 else None
    return _direction(state, pull[0])


def _pulls(state: State) -> list[Fix]:
    """The fixes of gravity that act together. Grains of other groups may have equal ones."""
    fixes = [fix for fix in state.fixes.values() if fix.style == "gravity" and fix.words]
    if len({fix.group for fix in fixes}) < 2:
        for fix in fixes:
            pulled = state.members(fix.group).types
            moving = {kind for kind in state.present() if not state.frozen(kind)}
            if pulled is not None and not moving <= pulled:
                state.quote_with(fix.statement, "other grains have no gravity")
                return []
        return fixes
    groups = [state.members(fix.group).types for fix in fixes]
    known = [group for group in groups if group is not None]
    apart = len(known) == len(fixes) and sum(map(len, known)) == len(frozenset().union(*known))
    if not apart or len({fix.words for fix in fixes}) > 1:
        state.unknown |= {fix.statement.quote: None for fix in fixes[1:]}
    return fixes[:1]


def _total(state: State, pulls: Sequence[Fix]) -> Direction | None:
    """The sum of several fixes of gravity; None if one is not known, which is quoted."""
    total = [0.0, 0.0, 0.0]
    for fix in pulls:
        size, direction = _strength(state, fix), _direction(state, fix)
        if size is None or direction is None:
            state.unknown[fix.statement.quote] = None
            return None
        total = [before + size * part for before, part in zip(total, direction, strict=True)]
    return tuple(total)


def _strength(state: State, fix: Fix) -> float | None:
    """The magnitude of ``fix gravity``."""
    word = fix.words[0]
    if word.startswith("v_") and state.variables.of(word[2:]) is None:
        state.unknown[fix.statement.quote] = None  # it changes in time
        return None
    return state.number(fix.statement, word)


def _direction(state: State, fix: Fix) -> Direction | None:
    """The direction of ``fix gravity``, as in LAMMPS' ``FixGravity``."""
    if len(fix.words) < 3:
        return None
    _, style, *rest = fix.words
    words = rest[: {"chute": 1, "spherical": 2, "vector": state.dimension}.get(style, 0)]
    if not words or any(is_variable(word) and state.variables.of(word[2:]) is None for word in words):
        return None
    numbers = [state.number(fix.statement, word) for word in words]
    if style == "vector":
        size = math.hypot(*numbers)
        return (*(x / size for x in numbers), *(0.0,) * (3 - len(numbers))) if size > 0.0 else None
    azimuth, polar = map(math.radians, numbers if style == "spherical" else (0.0, 180.0 - numbers[0]))
    if state.dimension == 2:
        return math.sin(polar), math.cos(polar), 0.0
    return math.sin(polar) * math.cos(azimuth), math.sin(polar) * math.sin(azimuth), math.cos(polar)
