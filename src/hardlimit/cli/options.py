"""Options that several commands share: quantities with units, the contact law, files to write."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import click

from ..contact.contact import Law, law_parameters
from ..contact.friction import LIMITS, MODELS, PARAMETERS, Friction
from ..contact.laws import LAWS
from ..support import saving, units, validation
from ..support.formatting import digits

F = TypeVar("F", bound=Callable[..., Any])


class Quantity(click.ParamType[Any]):
    """A number in the SI unit of the option, or a number with a unit such as ``1mm``.

    Its range is checked by the function that gets it. A ``word`` may stand for the number.
    """

    name = "number"

    def __init__(self, unit: str = "1", word: str = "") -> None:
        self.unit, self.word = unit, word

    def read(self, option: str, text: str) -> Any:
        """The value of the text that the user typed after ``option``."""
        if self.word and text == self.word:
            return text
        try:
            return units.number(option, text, self.unit)
        except ValueError as error:
            raise ValueError(f"{error}, or {self.word}" if self.word else str(error)) from None

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        try:
            return self.read(param.opts[0] if param else "number", str(value))
        except ValueError as error:
            raise click.UsageError(str(error), ctx) from None


def spelled(name: str) -> str:
    """The option of a parameter: ``--time-step`` for ``time_step``."""
    return f"--{name.replace('_', '-')}"


def options(*decorators: Callable[[Any], Any]) -> Callable[[F], F]:
    """Several options as one decorator, in the order in which help shows them."""

    def decorate(function: F) -> F:
        for option in reversed(decorators):
            function = option(function)
        return function

    return decorate


def quantity_option(
    option: str, *names: str, unit: str, help: str, multiple: bool = False
) -> Callable[[F], F]:
    """An option that takes a :class:`Quantity`."""
    return click.option(option, *names, type=Quantity(unit), help=help, multiple=multiple)


def quantity_options(*rows: tuple[str, str, str] | tuple[str, str, str, str]) -> Callable[[F], F]:
    """Options that take a :class:`Quantity`: option, unit and help, and a name for one that may be repeated."""
    decorators = [
        quantity_option(option, *name, unit=unit, help=help, multiple=bool(name))
        for option, unit, help, *name in rows
    ]
    return options(*decorators)


def json_option(help: str = "Print JSON.") -> Callable[[F], F]:
    """``--json``."""
    return click.option("--json", "as_json", is_flag=True, help=help)


# --- the law ------------------------------------------------------------------------------------------------


def _all_law_parameters() -> dict[str, tuple[dict[str, Any], list[str]]]:
    """The record of each parameter of a registered law, and the names of the laws that have it."""
    parameters: dict[str, tuple[dict[str, Any], list[str]]] = {}
    for law in LAWS.values():
        for name, record in law_parameters(law).items():
            parameters.setdefault(name, (record, []))[1].append(law.record["name"])
    return parameters


#: All parameters of contact laws. Options and the law parameters that can be swept are made from this table.
LAW_PARAMETERS = _all_law_parameters()


def law_options(
    kind: Callable[[str], click.ParamType[Any]] = Quantity, law: str = "Law of every contact."
) -> Callable[[F], F]:
    """``--law`` and an option for each parameter of a law; ``kind`` makes its type from the unit."""
    decorators = [click.option("--law", type=click.Choice(list(LAWS)), help=law)]
    for name, (record, laws) in LAW_PARAMETERS.items():
        unit = f" [{record['unit']}]" if record["unit"] != "1" else ""
        meaning = record["meaning"].split(";")[0].split(",")[0]
        text = f"{meaning[0].upper()}{meaning[1:]}{unit} ({', '.join(laws)})."
        decorators.append(click.option(spelled(name), name, type=kind(record["unit"]), help=text))
    return options(*decorators)


def take_law(params: dict[str, Any]) -> tuple[str | None, dict[str, Any]]:
    """Take the options of the law out of all options: its name, and the parameters that were given."""
    taken = {name: params.pop(name) for name in LAW_PARAMETERS}
    return params.pop("law"), {name: value for name, value in taken.items() if value is not None}


#: Symbols of law parameters; others are written out.
SYMBOLS = {
    "restitution": "ε",
    "stiffness": "k",
    "damping": "γ",
    "youngs_modulus": "Y",
    "poisson_ratio": "ν",
    "dissipative_time": "A",
    "impact_speed": "v",
}


#: Symbols of the arguments of friction.
FRICTION_SYMBOLS = {
    "coefficient": "μ",
    "stiffness_ratio": "k_t/k_n",
    "stiffness": "k_t",
    "damping_ratio": "γ_t/γ_n",
    "damping": "γ_t",
}


def law_text(law: Law) -> str:
    """A law with its parameters as the user gave them: ``linear law: k 5e7 N/m, ε 0.7``."""
    parts = []
    for name, value in law.parameters.items():
        unit = LAW_PARAMETERS[name][0]["unit"]
        parts.append(f"{SYMBOLS.get(name, name)} {digits(value)}{'' if unit == '1' else f' {unit}'}")
    return f"{law.record['name']} law: {', '.join([*parts, *_friction_parts(law)])}"


def law_mapping(law: Law) -> dict[str, Any]:
    """A law as a mapping for JSON: name, parameters, and its friction if it has one."""
    friction = {} if law.friction is None else {"friction": law.friction.to_dict()}
    return {"name": law.record["name"], **law.parameters, **friction}


def _friction_parts(law: Law) -> list[str]:
    """The friction of a law in symbols."""
    if law.friction is None:
        return []
    values = law.friction.to_dict()
    parts = [
        f"{symbol} {digits(float(values[name]))}"
        for name, symbol in FRICTION_SYMBOLS.items()
        if name in values
    ]
    return [*parts, f"{values['model']}, {values['limit']} limit"]


# --- friction -----------------------------------------------------------------------------------------------

#: Options of the arguments of :class:`Friction`, as parameters of a command.
FRICTION_OPTIONS = {
    "coefficient": "friction",
    **{name: f"tangential_{name}" if name in LAW_PARAMETERS else name for name in list(PARAMETERS)[1:]},
    "model": "friction_model",
    "limit": "limit",
}
#: Units of these options by name; None for words.
FRICTION_UNITS = {
    option: PARAMETERS[name]["unit"] if name in PARAMETERS else None
    for name, option in FRICTION_OPTIONS.items()
}
#: What help says of their defaults.
FRICTION_DEFAULTS = {
    "coefficient": "",
    "stiffness_ratio": "  [default: 2/7 for a spring, that of Mindlin for Hertz laws]",
    "stiffness": "",
    "damping_ratio": "  [default: 0]",
    "damping": "",
    "model": "  [default: spring; mindlin_rescale for Hertz laws]",
    "limit": "  [default: total]",
}
#: Arguments of which only one is given.
FRICTION_ALTERNATIVES = (("stiffness_ratio", "stiffness"), ("damping_ratio", "damping"))


def friction_options() -> Callable[[F], F]:
    """``--friction`` μ, and an option for each other argument of :class:`Friction`."""
    decorators = []
    for name, record in PARAMETERS.items():
        unit = f" [{record['unit']}]" if record["unit"] != "1" else ""
        option = FRICTION_OPTIONS[name]
        text = f"{option.replace('_', ' ').capitalize()}: {record['meaning']}{unit}.{FRICTION_DEFAULTS[name]}"
        decorators.append(click.option(spelled(option), option, type=Quantity(record["unit"]), help=text))
    words = {
        "model": (MODELS, "Tangential model."),
        "limit": (LIMITS, "What μ limits: the whole tangential force, or that of the spring."),
    }
    for name, (choices, text) in words.items():
        option = FRICTION_OPTIONS[name]
        text += FRICTION_DEFAULTS[name]
        decorators.append(click.option(spelled(option), option, type=click.Choice(list(choices)), help=text))
    return options(*decorators)


def take_friction_values(params: dict[str, Any]) -> dict[str, Any]:
    """Take the options of friction out of all options: those that were given."""
    taken = {option: params.pop(option) for option in FRICTION_OPTIONS.values()}
    return {option: value for option, value in taken.items() if value is not None}


def take_friction(law: Law, params: dict[str, Any]) -> Law:
    """The law with the options of friction, which are taken out of all options."""
    return with_friction(law, take_friction_values(params))


def with_friction(law: Law, options: Mapping[str, Any]) -> Law:
    """The law with friction from the values of :data:`FRICTION_OPTIONS`, which change the friction that it has; without
    values the same law."""
    if not options:
        return law
    values = {name: options[option] for name, option in FRICTION_OPTIONS.items() if option in options}
    present = {} if law.friction is None else law.friction.to_dict()
    for first, second in FRICTION_ALTERNATIVES:
        for name, other in ((first, second), (second, first)):
            if name in values and other not in values:
                present.pop(other, None)
    try:
        friction = Friction(**({"coefficient": 1.0} | present | values))
        if "coefficient" not in present | values:
            option = spelled(FRICTION_OPTIONS[next(iter(values))])
            raise ValueError(f"coefficient: missing, must be given beside {option}")
        return law.replace(friction=friction)
    except ValueError as error:
        subject, colon, rest = str(error).partition(": ")
        subject = re.sub(r"\w+", lambda match: FRICTION_OPTIONS.get(match[0], match[0]), subject)
        raise ValueError(
            subject + colon + re.sub(r"(?<![\w-])model\b", FRICTION_OPTIONS["model"], rest)
        ) from None


# --- files to write -----------------------------------------------------------------------------------------


def output_option(option: str, help: str, metavar: str = "FILE") -> Callable[[F], F]:
    """An option that names a file to write."""
    return click.option(option, metavar=metavar, help=help)


def writable(option: str, path: str | None, *endings: str) -> Path | None:
    """The path, if it can be written and ends in one of ``endings``."""
    return None if path is None else saving.checked(f"--{option}", path, endings)


def picture(option: str, path: str | None) -> Path | None:
    """The path of a picture, with the endings that matplotlib knows."""
    if path is None:
        return None
    from ..plots.style import endings

    return writable(option, path, *endings())


def film(option: str, path: str | None) -> Path | None:
    """The path of a film; MP4 needs ffmpeg."""
    target = writable(option, path, ".mp4", ".gif")
    if target is not None and target.suffix.lower() == ".mp4":
        from ..plots.video import require_ffmpeg

        require_ffmpeg()
    return target


def dpi_option(function: F) -> F:
    """``--dpi`` of the pictures that a command writes; None means the default resolution."""
    help = "Resolution of the pictures [dots per inch].  [default: 200]"
    return click.option("--dpi", type=Quantity(), callback=_resolution, help=help)(function)


def _resolution(ctx: click.Context, param: click.Parameter, value: float | None) -> float | None:
    """Refuse a bad resolution before anything is computed."""
    if value is None:
        return None
    from ..plots.style import RESOLUTIONS

    try:
        return validation.number("--dpi", value, *RESOLUTIONS, lowest_allowed=True, highest_allowed=True)
    except ValueError as error:
        raise click.UsageError(str(error), ctx) from None
