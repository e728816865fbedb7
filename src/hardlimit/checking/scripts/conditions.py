"""Conditions that only a run knows: in what two states of a script differ, and a stage without what may be either."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import fields, is_dataclass, replace
from typing import Any, Final

from .description import NOTHING, Grains, Quote, Setting, Stage
from .statements import Statement

#: A part of a stage, such as ("contacts", ("1", "1"), None).
Part = tuple[object, ...]
NOWHERE: Final = Quote("", 0, "")
#: Fields of a stage, in words, and those whose value is empty if it is not known.
FIELDS: Final = {
    **{"time_step": "the time step", "gravity": "gravity", "down": "gravity", "pressed": "pressure"},
    "pressure": "pressure",
    **dict.fromkeys(("driven", "shear_rate", "bath"), "what drives the grains"),
}
LISTS: Final = ("pressed", "driven")
CONTACTS: Final = "contacts"
GRAINS: Final = "grains"


def plain(value: Any) -> Any:
    """A value without the places in the script from which it comes."""
    if isinstance(value, Statement | Setting):
        return value.words
    if isinstance(value, Quote):
        return None
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return tuple(map(plain, value))
    if is_dataclass(value):
        return type(value).__name__, *(plain(getattr(value, part.name)) for part in fields(value))
    return value


def settings_of(stage: Stage) -> Any:
    """What decides on the contacts of a stage."""
    same: dict[str, Any] = {
        "quote": NOWHERE,
        "steps": None,
        "time_step_given": True,
        "units_given": True,
        "system": 0,
        "edges": (),
    }
    return plain(replace(stage, **same, contents=NOTHING))


def differences(first: Stage, other: Stage) -> Iterator[Part]:
    """The parts in which two stages differ."""
    for name, words in FIELDS.items():
        if plain(getattr(first, name)) != plain(getattr(other, name)):
            yield words, name
    both = [{(each.types, each.wall): plain(each) for each in stage.contacts} for stage in (first, other)]
    for key in dict.fromkeys([*both[0], *both[1]]):
        if both[0].get(key) != both[1].get(key):
            yield CONTACTS, *key
    for kind in dict.fromkeys([*first.grains, *other.grains]):
        if first.grains.get(kind) != other.grains.get(kind):
            yield GRAINS, kind


def without(stage: Stage, parts: Collection[Part]) -> Stage:
    """A stage in which these parts are not known."""
    if not parts:
        return stage
    missing: dict[str, Any] = {
        name: () if name in LISTS else None for name, words in FIELDS.items() if (words, name) in parts
    }
    return replace(
        stage,
        **missing,
        contacts=tuple(
            contact for contact in stage.contacts if (CONTACTS, contact.types, contact.wall) not in parts
        ),
        grains={
            kind: Grains(kind) if (GRAINS, kind) in parts else grains for kind, grains in stage.grains.items()
        },
    )
