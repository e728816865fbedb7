"""Types and groups of grains in a script of LAMMPS or LIGGGHTS (docs.lammps.org/group.html)."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import Final

from .population import Population
from .reader import Reader, names
from .statements import Statement

MAX_TYPES: Final = 100
#: Styles of ``group``.
GROUP_STYLES: Final = names("""
type id molecule region union subtract intersect empty include variable clear delete dynamic static initialize
""")
#: Logical operators of ``group … type``.
COMPARISONS: Final[dict[str, Callable[[int, int, int], bool]]] = {
    "<": lambda k, a, _: k < a,
    ">": lambda k, a, _: k > a,
    "<=": lambda k, a, _: k <= a,
    ">=": lambda k, a, _: k >= a,
    "==": lambda k, a, _: k == a,
    "!=": lambda k, a, _: k != a,
    "<>": lambda k, a, b: a <= k <= b,
}


@dataclass(frozen=True)
class Group:
    """The types of a group's grains; None for any type."""

    types: frozenset[int] | None
    whole: bool  #: whether all grains of these types belong to it


class Groups(Reader):
    """The types of grains, by number or label, and groups of them."""

    types_seen: int  #: largest type in a dump
    population: Population

    def forget_groups(self) -> None:
        """No types and labels, and the group of all grains."""
        self.groups = {"all": Group(None, True)}
        self.labels: dict[str, int] = {}
        self.types = 0

    def type_of(self, word: str) -> int:
        """A type by its number or label; 0 if it is neither."""
        if word.isdecimal() and len(word) < 7:
            return int(word)
        return self.labels.get(word, 0)

    def types_of(self, word: str) -> range:
        """Types within ``2``, ``*``, ``2*``, ``*3`` or ``1*3``, also those that only a later command makes known."""
        low, star, high = word.partition("*")
        if not star:
            kind = self.type_of(word)
            return range(kind, kind + 1) if kind else range(0)
        first = self.type_of(low) if low else 1
        last = self.type_of(high) if high else MAX_TYPES
        return range(first, min(last, MAX_TYPES) + 1)

    def count(self) -> int:
        """Number of types, as far as it is known."""
        return min(max([self.types, self.types_seen, *self.population.batches, 1]), MAX_TYPES)

    def present(self) -> list[int]:
        """Types of which there are grains, or all if these are not known."""
        if self.population.batches and not self.population.elsewhere:
            return sorted(self.population.batches)
        return list(range(1, self.count() + 1))

    def members(self, group: str) -> Group:
        """A group; any part of the grains if it is not known."""
        return self.groups.get(group, Group(None, False))

    def within(self, group: Group) -> Collection[int]:
        """The types of a group among those present."""
        return [kind for kind in self.present() if group.types is None or kind in group.types]

    def command_group(self, statement: Statement) -> None:
        name, style, *words = (*statement.words[1:], "", "")
        words = [word for word in words if word]
        if style not in GROUP_STYLES:
            self.unknown[statement.quote] = None
        old = self.groups.get(name)
        if style in ("delete", "clear"):
            self.groups.pop(name, None)
        elif name != "all":
            if style == "type":
                new = self.group_of_types(words)
            else:
                new = self.group_of_atoms(words) if style == "id" else self.combined(style, words)
            if old is not None and old.types is not None and new.types is not None:
                new = Group(old.types | new.types, old.whole and new.whole)  # a second command adds grains
            self.groups[name] = new

    def group_of_types(self, words: Sequence[str]) -> Group:
        """Grains of types such as ``1 3``, ``1:3``, ``> 2`` or ``<> 2 4``."""
        if words[:1] and words[0] in COMPARISONS:
            limits = [int(word) for word in words[1:] if word.isdecimal()]
            within = COMPARISONS[words[0]]
            every = range(1, self.count() + 1) if limits else ()
            return Group(frozenset(k for k in every if within(k, limits[0], limits[-1])), True)
        kinds: set[int] = set()
        for word in words:
            first, _, last = word.partition(":")
            last = last.partition(":")[0]
            if not self.population.batches:  # a part of a script, whose types are those that it names
                self.types = max(self.types, min(self.type_of(last or first), MAX_TYPES))
            kinds |= set(self.types_of(f"{first}*{last}" if last else first))
        return Group(frozenset(kinds), True)

    def group_of_atoms(self, words: Sequence[str]) -> Group:
        """Grains with numbers such as ``1 3``, ``1:3`` or ``> 2``; any part of them if their types are not known."""
        if words[:1] and words[0] in COMPARISONS:
            return self.group_of_numbers(words)
        ends = [word.partition(":") for word in words]
        if self.population.elsewhere or not all(
            word.isdecimal() and len(word) < 10 for first, _, last in ends for word in (first, last or first)
        ):
            return Group(None, False)
        ranges = [range(int(first), int(last or first) + 1) for first, _, last in ends]
        return self.group_where(lambda number: any(number in each for each in ranges))

    def group_of_numbers(self, words: Sequence[str]) -> Group:
        """Grains whose numbers, from 1 on, compare so."""
        within, limits = COMPARISONS[words[0]], [int(word) for word in words[1:] if word.isdecimal()]
        if len(limits) != (2 if words[0] == "<>" else 1):
            return Group(None, False)
        if words[0] in (">", ">=") and within(1, limits[0], limits[0]):
            return Group(None, True)
        if self.population.elsewhere:
            return Group(None, False)
        return self.group_where(lambda number: within(number, limits[0], limits[-1]))

    def group_where(self, belongs: Callable[[int], bool]) -> Group:
        """Grains by their numbers; any part of them if not all numbers are known."""
        chosen = {
            kind: [batch.atom is not None and belongs(batch.atom) for batch in batches]
            for kind, batches in self.population.batches.items()
        }
        if any(batch.atom is None for batches in self.population.batches.values() for batch in batches):
            return Group(None, False)
        chosen = {kind: each for kind, each in chosen.items() if any(each)}
        return Group(frozenset(chosen), all(map(all, chosen.values())))

    def combined(self, style: str, names: Sequence[str]) -> Group:
        """A union, difference or intersection of groups; any part of the grains for other styles, such as region."""
        parts = [self.members(name) for name in names]
        known = [part.types for part in parts if part.types is not None]
        whole = all(part.whole for part in parts)
        if style == "empty":
            return Group(frozenset(), True)
        if style == "union" and len(known) == len(parts):
            return Group(frozenset().union(*known), whole)
        if style == "union" and any(part.types is None and part.whole for part in parts):
            return Group(None, True)
        if style == "intersect" and parts:
            return Group(frozenset.intersection(*known) if known else None, whole)
        if style == "subtract" and parts:
            first, *others = parts
            types = first.types
            if types is None and first.whole:
                types = frozenset(range(1, self.count() + 1))
            minus = frozenset().union(
                *(part.types for part in others if part.types is not None and part.whole)
            )
            exact = whole and all(part.types is not None for part in others)
            return Group(None if types is None else types - minus, exact)
        return Group(None, False)

    def command_labelmap(self, statement: Statement) -> None:
        if statement.words[1:2] == ("atom",):
            words = statement.words[2:]
            for number, label in zip(words[::2], words[1::2], strict=False):
                if number.isdecimal():
                    self.labels[label] = int(number)
