"""Read TOML files and check their tables; messages name the key, its value and what is accepted.

All functions raise a ValueError with a one-line message for invalid content.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final, TypeVar

from . import units, validation

T = TypeVar("T")
#: A check of one entry: takes the name for messages and the value, and returns the value to use.
Kind = Callable[[str, Any], Any]

#: A larger file is not read.
MAX_BYTES: Final = 10_000_000


def read(path: str | Path) -> dict[str, Any]:
    """The content of a TOML file."""
    try:
        with open(validation.path("file", path), "rb") as file:
            content = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise validation.unreadable(path, error) from None
    if len(content) > MAX_BYTES:
        raise ValueError(f"{path}: not valid TOML: more than {MAX_BYTES // 1_000_000} MB")
    try:
        return parse(content.decode("utf-8-sig"))
    except UnicodeDecodeError:
        raise ValueError(f"{path}: not valid TOML: not UTF-8 text") from None
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def parse(text: str) -> dict[str, Any]:
    """The content of TOML text."""
    try:
        return tomllib.loads(text)
    except ValueError as error:
        raise ValueError(f"not valid TOML: {error}") from None
    except RecursionError:
        raise ValueError("not valid TOML: nested too deeply") from None


def convert(content: Mapping[str, Any], kind: type[T], where: str = "") -> T:
    """``content`` as a dataclass, for files that come with the package; messages are those of msgspec."""
    import msgspec

    try:
        return msgspec.convert(dict(content), kind)
    except msgspec.ValidationError as error:
        raise ValueError(f"{where}{error}") from None


# --- tables of a user's file --------------------------------------------------------------------------------


def table(name: str, content: Any, kinds: Mapping[str, Kind]) -> dict[str, Any]:
    """Check the entries of a table, each by the check of its key; the ``name`` of the top level of a file is empty."""
    if not isinstance(content, dict):
        raise ValueError(f"{name}: got {validation.shown(content)}, must be a table")
    names = {key: f"{name}.{key}" if name else key for key in content}
    for key in content:
        if key not in kinds:
            shown = names[key] if key.isidentifier() else f"{name or 'key'} {validation.shown(key)}"
            raise ValueError(f"{shown}: unknown, must be one of {', '.join(kinds)}")
    return {key: kinds[key](names[key], value) for key, value in content.items()}


def text(name: str, value: Any) -> str:
    """Check that a value is text."""
    if not isinstance(value, str):
        raise ValueError(f"{name}: got {validation.shown(value)}, must be text")
    return value


def whole(name: str, value: Any) -> int:
    """Check that a value is a whole number; its range is checked where it is used."""
    return validation.whole(name, value, -(2**63), 2**63 - 1)


def quantity(unit: str) -> Kind:
    """A check for a number in an SI unit, or for text with a unit; the range is checked where it is used."""
    return lambda name, value: units.quantity(name, value, unit)


def list_of(kind: Kind) -> Kind:
    """A check for a list, each member of which is checked by ``kind``."""

    def check(name: str, value: Any) -> list[Any]:
        if not isinstance(value, list):
            raise ValueError(f"{name}: got {validation.shown(value)}, must be a list")
        return [kind(f"{name}[{i}]", member) for i, member in enumerate(value)]

    return check


def one_or_list_of(kind: Kind) -> Kind:
    """A check for a value that ``kind`` accepts, or for a list of such values."""

    def check(name: str, value: Any) -> Any:
        if isinstance(value, list):
            return list_of(kind)(name, value)
        try:
            return kind(name, value)
        except ValueError as error:
            raise ValueError(f"{error}, or a list of them") from None

    return check
