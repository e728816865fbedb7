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

    Where one set of numbers holds for all contacts, and they need different ones, these are a matrix over types, or all
    but the first are commented out.
    """
    texts = model.input
    keyword = f" {model.keyword}" if model.attracts == "unless" and not attraction else ""
    lines = [_comment(code, f"{code.title} {code.version}: {model.title}"), *texts.head.splitlines()]
    places = [{name: f"{value:.12g}" for name, value in numbers.items()} for _, numbers in contacts]
    choice = texts.shared and any(one != places[0] for one in places)
    matrix = _matrix(model, contacts, places) if choice else []
    if matrix:
        lines += [_comment(code, matrix[0]), *matrix[1:]]
        contacts = []
    elif choice:
        lines.append(
            _comment(code, "these numbers hold for all contacts: choose those of one, or separate types")
        )
    bodies = max((pair.second for pair, _ in contacts), default=1)
    for k, (pair, _) in enumerate(contacts):
        text = texts.wall if pair.wall else texts.pair
        new = [
            line for line in _filled(text, pair, bodies, places[k]).splitlines() if line and line not in lines
        ]
        if choice and k > 0:
            new = [_comment(code, line) for line in new]
        lines += [_comment(code, pair.name), *new] if new else []
    lines += texts.foot.replace("{time_step}", f"{time_step:.4g}").splitlines()
    return "\n".join(line.replace("{keyword}", keyword) for line in lines)


def _comment(code: Code, text: str) -> str:
    return f"{code.comment} {text} {code.comment_end}".rstrip()


def read(model: Model, text: str, wall: bool = False) -> tuple[Numbers, bool]:
    """The numbers in an input, and whether its force attracts.

    Raises
    ------
    ValueError
        If a part of the model is not found, or is found with different numbers.
    """
    numbers: Numbers = {}
    for wanted in _reads(model, wall):
        every = [found.groupdict() for found in pattern(wanted).finditer(text)]
        if not every:
            raise ValueError(f"input: got {validation.shown(text)}, must have '{wanted}' for {model.name}")
        for name in every[0]:
            words = [word for found in every for word in found[name].split()]
            values = [float(word.replace("d", "e").replace("D", "e")) for word in words]
            if name not in PLACES and min(values) != max(values):
                raise ValueError(
                    f"{name}: got {len(set(values))} values in the input, must be that of one contact"
                )
            numbers[name] = values[0]
    attracts = model.attracts == "always" or (model.attracts == "unless" and model.keyword not in text)
    return {name: value for name, value in numbers.items() if name not in PLACES}, attracts


def matches(model: Model, text: str, wall: bool = False) -> bool:
    """Whether all words of a model are in an input."""
    return all(pattern(part).search(text) for part in _reads(model, wall))


def _reads(model: Model, wall: bool) -> list[str]:
    return model.input.reads_wall if wall and model.input.reads_wall else model.input.reads


def _filled(text: str, pair: Pair, bodies: int, places: dict[str, str]) -> str:
    """A text with its places filled; of numbers in braces, only known ones, for JSON has braces too."""
    first, second = sorted((pair.first, pair.second))
    # Of the upper triangle of a matrix, row by row.
    entry = str((first - 1) * (2 * bodies - first) // 2 + second)
    for name, value in {"i": str(first), "j": str(second), "entry": entry, **places}.items():
        text = text.replace(f"{{{name}}}", value)
    return text


def _matrix(
    model: Model, contacts: Sequence[tuple[Pair, Numbers]], places: Sequence[dict[str, str]]
) -> list[str]:
    """Lines with a number for each two types, and before them which type is what.

    None if the model has no such input, or if contacts differ in a number that it has only one of.
    """
    bodies = max(pair.second for pair, _ in contacts)
    walls = any(pair.wall for pair, _ in contacts)
    types = bodies + walls
    values: dict[tuple[int, int], dict[str, str]] = {}
    for (pair, _), one in zip(contacts, places, strict=True):
        first, second = pair.first, types if pair.wall else pair.second
        values[first, second] = values[second, first] = one
    if walls:
        values[types, types] = places[-1]  # walls do not meet
    ends = [(i + 1, j + 1) for i in range(types) for j in range(types)]
    if not all(pair in values for pair in ends):
        return []
    text = "\n".join(line for line in model.input.matrix.splitlines() if walls or "{wall}" not in line)
    for name in places[0]:
        each = [values[pair][name] for pair in ends]
        matches = ", ".join(f"({i - 1}, {j - 1}, {values[i, j][name]})" for i, j in ends if i <= j)
        wide = text.replace(f"{{matrix:{name}}}", f"{types} {' '.join(each)}")
        wide = wide.replace(f"{{matches:{name}}}", f"[{matches}]")
        if wide == text and len(set(each)) > 1:
            return []
        text = wide
    who = f"types 1 to {bodies}: the balls in the order given" + (f", {types}: the wall" if walls else "")
    return (
        [who, *text.replace("{types}", str(types)).replace("{wall}", str(types)).split("\n")] if text else []
    )
