"""Entries of job files for ``gas`` and ``sweep``; each entry of a table is also a command-line option."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import click

from ..support import toml
from .options import F, Quantity, options, spelled


@dataclass(frozen=True)
class Entry:
    """An entry of a table, and the option that overrides it."""

    name: str  #: in the table
    help: str  #: of the option
    unit: str | None = None  #: SI unit of a quantity
    kind: type = str  #: str or int, unless it is a quantity
    many: bool = False  #: a list in the table, or an option that may be repeated
    option: str = ""  #: the option, if it has another name than the entry
    metavar: str | None = None  #: of the option in its help
    word: str = ""  #: accepted in place of a quantity

    def as_option(self) -> Callable[[F], F]:
        """The option."""
        kind = self.kind if self.unit is None else Quantity(self.unit, self.word)
        option = self.option or spelled(self.name)
        return click.option(
            option, self.name, type=kind, multiple=self.many, help=self.help, metavar=self.metavar
        )

    def check(self, name: str, value: Any) -> Any:
        """Check the entry in a table."""
        kind: toml.Kind = toml.whole if self.kind is int else toml.text
        if self.unit is not None:
            kind = toml.quantity(self.unit)
        if self.word:
            kind = _or_word(kind, self.word)
        return toml.one_or_list_of(kind)(name, value) if self.many else kind(name, value)


def _or_word(kind: toml.Kind, word: str) -> toml.Kind:
    """A check that accepts a word, too."""

    def check(name: str, value: Any) -> Any:
        if value == word:
            return value
        try:
            return kind(name, value)
        except ValueError as error:
            raise ValueError(f"{error}, or {word!r}") from None

    return check


def entry_options(entries: Iterable[Entry]) -> Callable[[F], F]:
    """The options of entries as one decorator."""
    return options(*(entry.as_option() for entry in entries))


def table_of(entries: Iterable[Entry], more: Mapping[str, toml.Kind] | None = None) -> toml.Kind:
    """A check for a table with these entries and with ``more``."""
    kinds = {entry.name: entry.check for entry in entries} | dict(more or {})
    return lambda name, value: toml.table(name, value, kinds)


def changed(table: Mapping[str, Any], entries: Iterable[Entry], params: dict[str, Any]) -> dict[str, Any]:
    """The table of a job with the options that were given, which are taken out of ``given``."""
    taken = {entry.name: params.pop(entry.name, None) for entry in entries}
    return {**table, **{name: value for name, value in taken.items() if value not in (None, ())}}
