"""The input of a code as text: written for the numbers of each contact, and read back."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from .. import validation
from .codes import Code, Model, Pair, pattern
from .springs import Numbers

#: Places that number a body or a contact.
PLACES: Final = ("i", "j", "entry")


def written(
    code: Code,
    model: Model,
    contacts: Sequence[tuple[Pair, Numbers]],
    attraction: bool,
    time_step: float,
) -> str:
    """Lines ready to paste; what several contacts share stands once.

    Where one set of numbers holds for all contacts, and they need different ones, all but the first are commented out.
    """
    texts = model.input
    keyword = f" {model.keyword}" if model.attracts == "unless" and not attraction else ""
    lines = [f"{code.comment} {code.title} {code.version}: {model.title}", *texts.head.splitlines()]
    places = [{name: f"{value:.12g}" for name, value in numbers.items()} for _, numbers in contacts]
    choice = texts.shared and any(one != places[0] for one in places)
    if choice:
        lines.append(
            f"{code.comment} these numbers hold for all contacts: choose those of one, or separate types"
        )
    for k, (pair, _) in enumerate(contacts):
        text = texts.wall if pair.wall else texts.pair
        new = [line for line in _filled(text, pair, places[k]).splitlines() if line and line not in lines]
        mark = f"{code.comment} " if choice and k > 0 else ""
        lines += [f"{code.comment} {pair.name}", *(mark + line for line in new)] if new else []
    lines += texts.foot.replace("{time_step}", f"{time_step:.4g}").splitlines()
    return "\n".join(line.replace("{keyword}", keyword) for line in lines)


def read(model: Model, text: str, wall: bool = False) -> tuple[Numbers, bool]:
    """The numbers in an input, and whether its force attracts.

    Raises
    ------
    ValueError
        If a part of the model is not found.
    """
    numbers: Numbers = {}
    for wanted in _reads(model, wall):
        found = pattern(wanted).search(text)
        if found is None:
            raise ValueError(f"input: got {validation.shown(text)}, must have '{wanted}' for {model.name}")
        for name, value in found.groupdict().items():
            numbers[name] = float(value.replace("d", "e").replace("D", "e"))
    attracts = model.attracts == "always" or (model.attracts == "unless" and model.keyword not in text)
    return {name: value for name, value in numbers.items() if name not in PLACES}, attracts


def matches(model: Model, text: str, wall: bool = False) -> bool:
    """Whether all words of a model are in an input."""
    return all(pattern(part).search(text) for part in _reads(model, wall))


def _reads(model: Model, wall: bool) -> list[str]:
    return model.input.reads_wall if wall and model.input.reads_wall else model.input.reads


def _filled(text: str, pair: Pair, places: dict[str, str]) -> str:
    """A text with its places filled; of numbers in braces, only known ones, for JSON has braces too."""
    first, second = sorted((pair.first, pair.second))
    entry = str(first * second if first == 1 else second + first)
    for name, value in {"i": str(first), "j": str(second), "entry": entry, **places}.items():
        text = text.replace(f"{{{name}}}", value)
    return text
