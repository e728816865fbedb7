"""Conditions that only a run knows: in what two states of a script differ, and a stage without what may be either."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import fields, is_dataclass, replace
from typing import Any, Final

from .description import Grains, Quote, Setting, Stage
from .statements import Statement

#: A part of a stage, such as ("contacts", ("1", "1"), None).
Part = tuple[object, ...]
NOWHERE: Final = Quote("", 0, "")
STEP: Final[Part] = ("the time step",)
GRAVITY: Final[Part] = ("gravity",)
CONTACTS: Final = "contacts"
GRAINS: Final = "grains"


def plain(value: Any) -> Any:
    """A value without the places in the script from which it comes."""
    if isinstance(value, Statement | Setting):
        return value.words
    if isinstance(value, Quote):
        return None
    if isinstance(value, dict):
        return {key: plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return tuple(map(plain, value))
    if is_dataclass(value):
        return type(value).__name__, *(plain(getattr(value, one.name)) for one in fields(value))
    return value


def settings_of(stage: Stage) -> Any:
    """What decides on the contacts of a stage."""
    return plain(replace(stage, quote=NOWHERE, steps=None, time_step_given=True, units_given=True))


def differences(one: Stage, other: Stage) -> Iterator[Part]:
    """The parts in which two stages differ."""
    if one.time_step != other.time_step:
        yield STEP
    if (one.gravity, one.down) != (other.gravity, other.down):
        yield GRAVITY
    both = [{(each.types, each.wall): plain(each) for each in stage.contacts} for stage in (one, other)]
    for key in dict.fromkeys([*both[0], *both[1]]):
        if both[0].get(key) != both[1].get(key):
            yield CONTACTS, *key
    for kind in dict.fromkeys([*one.grains, *other.grains]):
        if one.grains.get(kind) != other.grains.get(kind):
            yield GRAINS, kind


def without(stage: Stage, parts: Collection[Part]) -> Stage:
    """A stage in which these parts are not known."""
    if not parts:
        return stage
    return replace(
        stage,
        time_step=None if STEP in parts else stage.time_step,
        gravity=None if GRAVITY in parts else stage.gravity,
        down=None if GRAVITY in parts else stage.down,
        contacts=tuple(one for one in stage.contacts if (CONTACTS, one.types, one.wall) not in parts),
        grains={kind: Grains(kind) if (GRAINS, kind) in parts else one for kind, one in stage.grains.items()},
    )
