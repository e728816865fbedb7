"""The model of a code that the settings of a contact select, and its numbers in SI units."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ..convert.codes import Code, Model, listed
from ..convert.formulas import SPRINGS, Numbers
from ..support import validation
from ..support.units import SYSTEMS
from .scripts import Setting, Settings
from .scripts.formulas import NUMBER
from .scripts.statements import refusal


@dataclass(frozen=True)
class Selected:
    """The model of a contact with its numbers."""

    model: Model
    numbers: Numbers
    attracts: bool  #: whether the force attracts at the end of a contact


def selected(code: Code, models: Sequence[Model], settings: Settings, units: str = "si") -> Selected:
    """The model that the settings of a contact select, and its numbers, converted from ``units`` to SI.

    Raises
    ------
    ValueError
        If there is no model or several, or a number is outside its range.
    """
    model = _only_model(code, models, settings)
    numbers: Numbers = {}
    for name, words in model.input.reads.items():
        setting = settings[name]
        for word, place in zip(setting.words, words.split(), strict=True):
            if place.startswith("{"):
                number = place[1:-1]
                powers = zip(SYSTEMS[units], model.unit(number), strict=True)
                scale = math.prod(unit**power for unit, power in powers)
                numbers[number] = _checked(model, number, scale * _number(number, word, setting), setting)
    keyword, *on = model.keyword.split() or [""]
    limited = keyword in settings and list(settings[keyword].words) == on
    attracts = model.attracts == "always" or not (model.attracts == "never" or limited)
    return Selected(model, numbers, attracts)


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


def _only_model(code: Code, models: Sequence[Model], settings: Settings) -> Model:
    matching = [model for model in models if not _missing(model, settings)]
    if len(matching) == 1:
        return matching[0]
    _refuse_unknown_word(code, models, settings)
    names = listed([model.name for model in (matching or models)])
    if matching:
        raise ValueError(f"input: got several models of {code.title}, must be one of {names}")
    nearest = min(models, key=lambda model: len(_missing(model, settings)) / len(model.input.reads))
    missing = _missing(nearest, settings)
    lacks = f"; {nearest.name} lacks {', '.join(missing)}" if len(missing) < len(nearest.input.reads) else ""
    raise ValueError(f"input: got no model of {code.title}, must be one of {names}{lacks}")


def _refuse_unknown_word(code: Code, models: Sequence[Model], settings: Settings) -> None:
    """Refuse a setting whose word belongs to no model, such as ``model jkr``."""
    for name in dict.fromkeys(name for model in models for name in model.input.reads):
        reads = [model.input.reads[name] for model in models if name in model.input.reads]
        known = dict.fromkeys(words.split()[0] for words in reads)
        words = settings[name].words[:1] if name in settings else ()
        if words and words[0] not in known and not any(word.startswith("{") for word in known):
            raise ValueError(
                f"input: {name} {words[0]} of {code.title} is not known, only {', '.join(known)}"
            )


def _missing(model: Model, settings: Settings) -> list[str]:
    """Words of a model that are not set."""
    return [
        f"{name} {words}"
        for name, words in model.input.reads.items()
        if name not in settings or not _match(words.split(), settings[name].words)
    ]


def _match(places: Sequence[str], words: Sequence[str]) -> bool:
    """Whether words are those of a model, which has placeholders such as {stiffness}."""
    return len(places) == len(words) and all(
        place.startswith("{") or place == word for place, word in zip(places, words, strict=True)
    )
