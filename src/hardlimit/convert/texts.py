"""Write the numbers of contacts as the input of a code, and read them back."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import ROUND_FLOOR, Context

from ..checking.scripts.description import Setting, Settings
from ..checking.scripts.formulas import NUMBER
from ..checking.scripts.statements import refusal
from ..support import validation
from ..support.units import SYSTEMS
from .codes import Code, Model, Pair, listed
from .formulas import SPRINGS, Numbers
from .readers import READERS, Asked, Reading, same


def written(
    code: Code,
    model: Model,
    contacts: Sequence[tuple[Pair, Numbers]],
    attraction: bool,
    time_step: float,
) -> str:
    """Input lines ready to paste, without duplicates.

    If one set of numbers holds for all contacts but they need different ones, the text has a matrix over types, or
    comments out all numbers but those of the first contact.
    """
    texts = model.input
    keyword = f" {model.keyword}" if model.attracts == "unless" and not attraction else ""
    lines = [_comment(code, f"{code.title} {code.version}: {model.title}")]
    for extra in texts.extra:
        values = [numbers[extra.number] for _, numbers in contacts]
        if max(values) > extra.above or min(values) < extra.below:
            lines.append(extra.line)
    lines += texts.head.splitlines()
    balls = [one for one in contacts if not one[0].wall]
    walls = [one for one in contacts if one[0].wall]
    for group in (balls, walls) if texts.apart else (contacts,):
        lines += _contacts(code, model, group, lines)
    lines += texts.foot.replace("{time_step}", rounded_down(time_step)).splitlines()
    return "\n".join(line.replace("{keyword}", keyword) for line in lines)


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
    once = [{name: value for name, value in one.items() if shared or name in texts.once} for one in places]
    choice = any(one != once[0] for one in once)
    if choice and (matrix := _matrix(model, contacts, places)):
        return [_comment(code, matrix[0]), *matrix[1:]]
    lines = []
    if choice:
        lines.append(
            _comment(code, "these numbers hold for all contacts: choose those of one, or different types")
        )
    bodies = max((pair.second for pair, _ in contacts), default=1)
    for k, (pair, _) in enumerate(contacts):
        new: list[str] = []
        for template in (texts.wall if pair.wall else texts.pair).splitlines():
            line = _filled(template, pair, bodies, places[k])
            # A line without numbers, such as the wall itself, is always needed.
            other = choice and k > 0 and any(f"{{{name}}}" in template for name in places[k])
            line = _comment(code, line) if other else line
            if template and line not in (*before, *lines, *new):
                new.append(line)
        lines += [_comment(code, pair.name), *new] if new else []
    return lines


def _comment(code: Code, text: str) -> str:
    return f"{code.comment} {text} {code.comment_end}".rstrip()


# --- reading --------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Read:
    """One contact as read from an input."""

    model: Model
    numbers: Numbers  #: in SI units
    attracts: bool
    numerical_damping: float | None  #: None if the input does not set it


def read(
    code: Code, text: str, wall: bool = False, contact: str | None = None, model: str | None = None
) -> Read:
    """Read the model of an input, its numbers and whether its force attracts.

    Raises
    ------
    ValueError
        If a statement that affects a contact is not understood, there is no model or several, or contacts differ and
        none is selected.
    """
    models = [code.model(model)] if model is not None else code.models
    names = {name for one in models for reads in (one.input.reads, one.input.reads_wall) for name in reads}
    reading = READERS[code.reader](text, Asked(frozenset(names), code.defaults, code.sticky))
    settings = _contact(code, models, reading, wall, contact, names)
    return interpreted(code, models, settings, wall, reading.units, reading.numerical_damping)


def interpreted(
    code: Code,
    models: Sequence[Model],
    settings: Settings,
    wall: bool,
    units: str = "si",
    numerical_damping: float | None = None,
) -> Read:
    """The model that the settings of a contact select, and its numbers, converted from ``units`` to SI.

    Raises
    ------
    ValueError
        If there is no model or several, or a number is outside its range.
    """
    found = _only_model(code, models, settings, wall)
    numbers: Numbers = {}
    for name, words in _reads(found, wall).items():
        setting = settings[name]
        for word, place in zip(setting.words, words.split(), strict=True):
            if place.startswith("{"):
                kind, _, number = place[1:-1].rpartition(":")
                value = _number(number, word, setting)
                powers = zip(SYSTEMS[units], found.unit(number), strict=True)
                scale = math.prod(unit**power for unit, power in powers)
                numbers[number] = _checked(
                    found, number, scale * (abs(value) if kind == "negative" else value), setting
                )
    keyword, *on = found.keyword.split() or [""]
    limited = keyword in settings and list(settings[keyword].words) == on
    return Read(
        found,
        numbers,
        found.attracts == "always" or not (found.attracts == "never" or limited),
        numerical_damping,
    )


def _number(name: str, word: str, setting: Setting) -> float:
    if not NUMBER.fullmatch(word):
        raise refusal(setting.line, setting.text, f"have a number for {name}, not {word}")
    return float(word)


def _checked(model: Model, name: str, value: float, setting: Setting) -> float:
    """Check the range of a number."""
    try:
        if name == "restitution":
            return validation.number(name, value, 0.0, 1.0, highest_allowed=True)
        if name == "poisson_ratio":
            return validation.number(name, value, -1.0, 0.5, highest_allowed=True)
        undamped = name == model.damping.number and not SPRINGS[model.spring.given].damped
        return validation.number(name, value, 0.0, lowest_allowed=undamped)
    except ValueError as error:
        raise ValueError(f"input: line {setting.line}: {error}") from None


def _contact(
    code: Code, models: Sequence[Model], reading: Reading, wall: bool, wanted: str | None, names: set[str]
) -> Settings:
    """The settings of the selected contact, or of the only one. The last pair of types replaces those before it."""
    selected = None if wanted is None else wanted.replace("–", "-").replace(" ", "")
    fitting = [one for one in reading.contacts if one.wall in (None, wall)]
    if selected is not None:
        named = [one for one in fitting if one.covers(selected)]
        named = named or [one for one in fitting if one.at_a_wall.covers(selected)]
        if not named:
            choices = ", ".join(dict.fromkeys(one.name for one in fitting)) or "none"
            raise ValueError(f"contact: got {validation.shown(wanted)}, must be one of {choices}")
        fitting = named if named[-1].wall else named[-1:]
    if reading.contacts and not fitting:
        kind = "balls" if not wall else "a ball and a wall"
        raise ValueError(f"input: got no contact of {kind}, only {reading.contacts[0].name}")
    words = {name for one in models for name in one.keyword.split()[:1]} | names
    kept = [{name: one.settings[name] for name in words if name in one.settings} for one in fitting]
    if any(set(one) != set(kept[0]) or not all(same(one[n], kept[0][n]) for n in one) for one in kept):
        choices = ", ".join(dict.fromkeys(one.name for one in fitting))
        got = "missing" if wanted is None else f"got {validation.shown(wanted)}"
        raise ValueError(
            f"contact: {got}, must be one of {choices}, which have different numbers in the input"
        )
    return kept[0] if kept else {}


def _only_model(code: Code, models: Sequence[Model], settings: Settings, wall: bool) -> Model:
    matching = [one for one in models if not _missing(one, settings, wall)]
    if len(matching) == 1:
        return matching[0]
    strange = _unknown_word(models, settings, wall)
    if strange is not None:
        name, known = strange
        raise ValueError(f"input: {name} of {code.title} is not known, only {', '.join(known)}")
    names = listed([one.name for one in (matching or models)])
    if matching:
        raise ValueError(f"input: got several models of {code.title}, must be one of {names}")
    nearest = min(models, key=lambda one: len(_missing(one, settings, wall)) / len(_reads(one, wall)))
    missing = _missing(nearest, settings, wall)
    lacks = (
        f"; {nearest.name} lacks {', '.join(missing)}" if len(missing) < len(_reads(nearest, wall)) else ""
    )
    raise ValueError(f"input: got no model of {code.title}, must be one of {names}{lacks}")


def _unknown_word(
    models: Sequence[Model], settings: Settings, wall: bool
) -> tuple[str, tuple[str, ...]] | None:
    """A setting whose word belongs to no model, such as ``model jkr``, and the words of that setting; None without."""
    names = dict.fromkeys(name for one in models for name in _reads(one, wall))
    for name in names:
        firsts = dict.fromkeys(
            _reads(one, wall)[name].split()[0] for one in models if name in _reads(one, wall)
        )
        words = settings[name].words[:1] if name in settings else ()
        if words and not set(firsts) & set(words) and not any(first.startswith("{") for first in firsts):
            return f"{name} {words[0]}", tuple(firsts)
    return None


def _missing(model: Model, settings: Settings, wall: bool) -> list[str]:
    """Words of a model that are not set."""
    reads = _reads(model, wall)
    return [
        f"{name} {words}"
        for name, words in reads.items()
        if name not in settings or not _match(words, settings[name])
    ]


def _match(words: str, setting: Setting) -> bool:
    places = words.split()
    return len(places) == len(setting.words) and all(map(_fits, places, setting.words))


def _fits(place: str, word: str) -> bool:
    if not place.startswith("{"):
        return place == word
    kind = place[1:-1].rpartition(":")[0]
    if not kind:
        return True
    negative = word.startswith("-") or (NUMBER.fullmatch(word) is not None and float(word) == 0.0)
    return negative if kind == "negative" else not word.startswith("-")


def _reads(model: Model, wall: bool) -> dict[str, str]:
    return model.input.reads_wall if wall and model.input.reads_wall else model.input.reads


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
    for (pair, _), one in zip(contacts, places, strict=True):
        first, second = pair.first, types if pair.wall else pair.second
        values[first, second] = values[second, first] = one
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
        text = wide
    explained = f"types 1 to {bodies}: the balls in the order given" + (
        f", {types}: the wall" if walls else ""
    )
    return (
        [explained, *text.replace("{types}", str(types)).replace("{wall}", str(types)).split("\n")]
        if text
        else []
    )
