"""TOML files read through a schema (msgspec): strict types, unknown keys refused, one line that names the key."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, TypeVar

from . import validation

T = TypeVar("T")

#: A file larger than this is no column and no job.
MOST_BYTES: Final = 10_000_000

#: Types of TOML in the words of its users, by msgspec's.
_WORDS: Final = {
    "float": "a number",
    "int": "a whole number",
    "str": "a text",
    "bool": "true or false",
    "array": "a list",
    "object": "a table",
}


def read(path: str | Path) -> dict[str, Any]:
    """The content of a TOML file.

    Raises
    ------
    ValueError
        If it cannot be read or is not TOML; names the file.
    """
    try:
        with open(path, "rb") as file:
            content = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise ValueError(f"{path}: cannot be read: {error.strerror or error}") from None
    except ValueError as error:  # a null character in the name
        raise ValueError(f"{validation.shown(str(path))}: cannot be read: {error}") from None
    if len(content) > MOST_BYTES:
        raise ValueError(f"{path}: not valid TOML: more than {MOST_BYTES // 1_000_000} MB")
    try:
        return parse(content.decode("utf-8-sig"))
    except UnicodeDecodeError:
        raise ValueError(f"{path}: not valid TOML: not a text in UTF-8") from None
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def parse(text: str) -> dict[str, Any]:
    """The content of a text in TOML.

    Raises
    ------
    ValueError
        If it is not TOML.
    """
    try:
        return tomllib.loads(text)
    except ValueError as error:
        raise ValueError(f"not valid TOML: {error}") from None
    except RecursionError:
        raise ValueError("not valid TOML: nested too deeply") from None


def convert(content: Mapping[str, Any], kind: type[T], where: str = "") -> T:
    """``content`` as a structure of msgspec.

    Raises
    ------
    ValueError
        For an unknown or missing key and a value of another type, as ``where.key: got …, must be …``.
    """
    import msgspec

    try:
        return msgspec.convert(dict(content), kind)
    except msgspec.ValidationError as error:
        raise ValueError(where + _in_words(str(error), content, kind)) from None


def _in_words(message: str, content: Any, kind: type) -> str:
    """One line about what msgspec found, with the value that it leaves out."""
    from msgspec import inspect

    parted = re.fullmatch(r"(.*?)(?: - at `\$([\w.\[\]]*)`)?", message, re.DOTALL)
    what, path = parted.groups() if parted else (message, "")
    name, value, at = "", content, inspect.type_info(kind)
    for field, index in re.findall(r"\.(\w+)|\[(\d+)\]", path or ""):
        at = _inside(at, field, value)
        value = value[int(index) if index else field]
        name += f"[{index}]" if index else f".{field}" if name else field
    missing = re.match(r"Object missing required field `(.*)`", what)
    if missing:
        return f"{_join(name, missing[1])}: missing, must be given"
    unknown = re.match(r"Object contains unknown field `(.*)`", what, re.DOTALL)
    if unknown:
        known = ", ".join(_keys(_structure(at, value)))
        return f"{_join(name, validation.shown(unknown[1])[1:-1])}: unknown, must be one of {known}"
    return f"{name or 'file'}: got {validation.shown(value)}, must be {_wanted(what, at)}"


def _join(where: str, key: str) -> str:
    return f"{where}.{key}" if where else key


def _wanted(what: str, at: Any) -> str:
    """What was expected, such as ``a number or a list``."""
    if what.startswith("Invalid value"):
        return f"one of {', '.join(str(one.tag) for one in _structures(at))}"
    expected = re.match(r"Expected `([^`]*)`", what)
    if expected is None:
        return "within the range of floating-point numbers"
    return " or ".join(_WORDS.get(word, word) for word in expected[1].split(" | ") if word != "null")


def _inside(at: Any, field: str, value: Any) -> Any:
    """The type of a field of a structure, or of the elements of a list."""
    if not field:
        return next(kind.item_type for kind in _kinds(at) if hasattr(kind, "item_type"))
    structure = _structure(at, value)
    if field == structure.tag_field:
        return at
    return next(one.type for one in structure.fields if one.encode_name == field)


def _kinds(at: Any) -> tuple[Any, ...]:
    return getattr(at, "types", (at,))


def _structures(at: Any) -> list[Any]:
    return [kind for kind in _kinds(at) if hasattr(kind, "fields")]


def _structure(at: Any, value: Any) -> Any:
    """The structure that a table describes; where there are several, its tag says which."""
    structures = _structures(at)
    return next((one for one in structures if value.get(one.tag_field) == one.tag), structures[0])


def _keys(structure: Any) -> list[str]:
    tag = [structure.tag_field] if structure.tag_field else []
    return tag + [field.encode_name for field in structure.fields]
