"""Publications to cite for models, laws, rules, engines and figures, as BibTeX."""

from __future__ import annotations

import tomllib
from functools import cache
from importlib.resources import files
from types import MappingProxyType
from typing import Any, Final

from .. import _core
from .formatting import listed

#: Fields of an entry in order; an article has a journal, a book a publisher.
_FIELDS: Final = ("journal", "volume", "pages", "publisher", "edition", "year", "doi")


@cache
def _references() -> dict[str, Any]:
    return tomllib.loads(files(__package__).joinpath("references.toml").read_text("utf-8"))


def topics() -> MappingProxyType[str, tuple[str, ...]]:
    """Topics with publications, by kind."""
    return MappingProxyType({kind: tuple(names) for kind, names in _references()["topics"].items()})


def publications(*names: str) -> tuple[str, ...]:
    """Keys of the publications for these topics, without repetition.

    Raises a ValueError if a name is not a topic.
    """
    known = {name: keys for kind in _references()["topics"].values() for name, keys in kind.items()}
    for name in names:
        if name not in known:
            raise ValueError(f"topic: got {name!r}, must be one of {', '.join(known)}")
    return tuple(dict.fromkeys(key for name in names for key in known[name]))


def in_words(key: str) -> str:
    """A publication in one line: authors, journal or publisher, year."""
    entry = _references()["publications"][key]
    family = [author.split(",")[0] for author in entry["authors"]]
    authors = f"{family[0]} et al." if len(family) > 3 else listed(family, "&")
    if "journal" not in entry:
        return f"{authors}, {entry['title']}, {entry['publisher']} ({entry['year']})"
    first_page = entry["pages"].split("--")[0]
    return f"{authors}, {entry['journal']} {entry['volume']}, {first_page} ({entry['year']})"


def bibtex(*names: str) -> str:
    """BibTeX of this package and of the publications for these topics, in UTF-8.

    Raises a ValueError if a name is not a topic.
    """
    return "\n".join([_software(), *map(_entry, publications(*names))])


def _entry(key: str) -> str:
    entry = _references()["publications"][key]
    lines = [f"@{'article' if 'journal' in entry else 'book'}{{{key},"]
    lines.append(f"  author = {{{' and '.join(entry['authors'])}}},")
    lines.append(f"  title = {{{{{entry['title']}}}}},")
    lines += [f"  {field} = {{{entry[field]}}}," for field in _FIELDS if field in entry]
    return "\n".join([*lines, "}", ""])


def _software() -> str:
    return (
        "@software{hardlimit,\n"
        "  author = {{The hardlimit authors}},\n"
        "  title = {{hardlimit: hard-sphere collisions and Newton's equations, side by side}},\n"
        f"  version = {{{_core.version}}},\n"
        "}\n"
    )
