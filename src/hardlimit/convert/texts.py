"""Write the numbers of contacts as the input of a code."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from decimal import ROUND_FLOOR, Context

from .codes import Code, Input, Model, Pair, TangentialInput
from .formulas import Numbers


def written(
    code: Code,
    model: Model,
    contacts: Sequence[tuple[Pair, Numbers]],
    attraction: bool,
    time_step: float,
    friction: TangentialInput | None = None,
) -> str:
    """Input lines ready to paste, without duplicates.

    If one set of numbers holds for all contacts but they need different ones, the text has a matrix over types, or
    comments out all numbers but those of the first contact. With friction, the contacts have its numbers too.
    """
    if friction is not None:
        model = replace(model, input=_rubbing(model.input, friction.words))
    texts = model.input
    keyword = f" {model.keyword}" if model.attracts == "unless" and not attraction else ""
    lines = [comment(code, f"{code.title} {code.version}: {model.title}")]
    for extra in texts.extra:
        values = [numbers[extra.number] for _, numbers in contacts]
        if max(values) > extra.above or min(values) < extra.below:
            lines.append(extra.line)
    lines += texts.head.splitlines()
    balls = [contact for contact in contacts if not contact[0].wall]
    walls = [contact for contact in contacts if contact[0].wall]
    for group in (balls, walls) if texts.apart else (contacts,):
        lines += _contacts(code, model, group, lines)
    lines += texts.foot.replace("{time_step}", rounded_down(time_step)).splitlines()
    return "\n".join(line.replace("{keyword}", keyword) for line in lines)


def _rubbing(texts: Input, words: Mapping[str, str]) -> Input:
    """The input with friction in place of the words for smooth bodies."""
    changed = {name: getattr(texts, name) for name in ("head", "pair", "wall", "matrix")}
    for smooth, rough in words.items():
        changed = {name: text.replace(smooth, rough) for name, text in changed.items()}
    return replace(texts, **changed)


def rounded_down(time_step: float) -> str:
    """The time step rounded down to four digits."""
    return f"{float(Context(prec=4, rounding=ROUND_FLOOR).create_decimal(time_step)):.4g}"


def _contacts(
    code: Code, model: Model, contacts: Sequence[tuple[Pair, Numbers]], before: Sequence[str]
) -> list[str]:
    """The lines of a group of contacts, except those in ``before``."""
    texts = model.input
    shared = texts.shared and not (texts.apart and all(pair.wall for pair, _ in contacts))
    places = [{name: f"{value:.12g}" for name, value in numbers.items()} for _, numbers in contacts]
    once = [
        {name: value for name, value in numbers.items() if shared or name in texts.once} for numbers in places
    ]
    choice = any(numbers != once[0] for numbers in once)
    if choice and (matrix := _matrix(model, contacts, places)):
        return [comment(code, matrix[0]), *matrix[1:]]
    lines = []
    if choice:
        lines.append(
            comment(code, "these numbers hold for all contacts: choose those of one, or different types")
        )
    bodies = max((pair.second for pair, _ in contacts), default=1)
    for k, (pair, _) in enumerate(contacts):
        new: list[str] = []
        for template in (texts.wall if pair.wall else texts.pair).splitlines():
            line = _filled(template, pair, bodies, places[k])
            # A line without numbers, such as the wall itself, is always needed.
            other = choice and k > 0 and any(f"{{{name}}}" in template for name in places[k])
            line = comment(code, line) if other else line
            if template and line not in (*before, *lines, *new):
                new.append(line)
        lines += [comment(code, pair.name), *new] if new else []
    return lines


def comment(code: Code, text: str) -> str:
    """A comment of the code's input."""
    return f"{code.comment} {text} {code.comment_end}".rstrip()


# --- filling in -----------------------------------------------------------------------------------------------


def _filled(text: str, pair: Pair, bodies: int, places: dict[str, str]) -> str:
    """Fill in the known placeholders of a text. Other braces are kept, because JSON contains braces."""
    first, second = sorted((pair.first, pair.second))
    # Index in the upper triangle of a matrix, row by row.
    entry = str((first - 1) * (2 * bodies - first) // 2 + second)
    for name, value in {"i": str(first), "j": str(second), "entry": entry, **places}.items():
        text = text.replace(f"{{{name}}}", value)
    return text


def _matrix(
    model: Model, contacts: Sequence[tuple[Pair, Numbers]], places: Sequence[dict[str, str]]
) -> list[str]:
    """Lines with a number for each pair of types, after a line that explains the types.

    Empty if the model has no such input, or if contacts differ in a number of which it has only one.
    """
    bodies = max(pair.second for pair, _ in contacts)
    walls = any(pair.wall for pair, _ in contacts)
    types = bodies + walls
    values: dict[tuple[int, int], dict[str, str]] = {}
    for (pair, _), numbers in zip(contacts, places, strict=True):
        first, second = pair.first, types if pair.wall else pair.second
        values[first, second] = values[second, first] = numbers
    if walls:
        values[types, types] = places[-1]  # needed for a full matrix; walls do not touch
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
        text = wide.replace(f"{{{name}}}", each[0])
    explained = f"types 1 to {bodies}: the balls in the order given" + (
        f", {types}: the wall" if walls else ""
    )
    return (
        [explained, *text.replace("{types}", str(types)).replace("{wall}", str(types)).split("\n")]
        if text
        else []
    )
