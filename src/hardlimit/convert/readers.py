"""Readers of the input of particle codes. The files in ``codes`` select a reader by name.

A reader returns the settings of each contact. In statements that affect a normal contact it either understands a word
or refuses it with a message that quotes it. It skips other statements.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

from ..checking.scripts import granular_words
from ..checking.scripts.commands import JUMP, NESTING, Commands
from ..checking.scripts.description import WALL, Quote, Setting, Settings
from ..checking.scripts.granular_words import NORMAL, PROPERTIES, ordered, unaccelerated
from ..checking.scripts.liggghts import Property
from ..checking.scripts.python import Instance, Unknown
from ..checking.scripts.statements import Statement, refusal, same_word, settings
from ..checking.scripts.yade import LAWS, NUMERICAL_DAMPING, Yade, entries
from ..support.units import SYSTEMS
from . import grammar


@dataclass(frozen=True)
class Contact:
    """The settings of a contact of two bodies: types, ranges of types such as ``1*3``, or names."""

    bodies: tuple[str, ...]
    settings: Settings
    wall: bool | None = None  #: whether it is a contact with a wall; None if the settings hold for both

    @property
    def name(self) -> str:
        """A name such as ``1-2``, or ``1-floor`` for a wall of that name."""
        return "-".join(self.bodies)

    @property
    def at_a_wall(self) -> Contact:
        """The same settings under a name such as ``1-wall``, whatever the name of the wall."""
        return replace(self, bodies=(*self.bodies[:-1], WALL)) if self.wall else self

    def covers(self, name: str) -> bool:
        """Whether these settings hold for a contact of this name, such as ``1-2``."""
        if name == self.name.replace(" ", ""):
            return True
        asked = name.split("-")
        return len(asked) == len(self.bodies) and any(
            all(_within(one, these) for one, these in zip(order, self.bodies, strict=True))
            for order in (asked, asked[::-1])
        )


@dataclass(frozen=True)
class Reading:
    """All contacts of an input, its units, and the damping of its integrator."""

    contacts: list[Contact]
    units: str = "si"
    numerical_damping: float | None = None  #: None if the input does not set it


@dataclass(frozen=True)
class Asked:
    """The information for the reader in the file of a code."""

    names: frozenset[str]  #: settings that its models read
    defaults: Mapping[str, str] = field(default_factory=dict)  #: settings if the input does not set them
    sticky: Sequence[str] = ()  #: settings that cause adhesion


def _within(one: str, these: str) -> bool:
    """Whether a type is within ``2``, ``*``, ``2*``, ``*3`` or ``1*3``."""
    low, star, high = these.partition("*")
    if not star or not one.isdigit():
        return one == these
    return int(low or 1) <= int(one) <= int(high or one)


# --- LAMMPS and LIGGGHTS --------------------------------------------------------------------------------------

#: Commands that may be hidden inside another command.
HIDDEN: Final = re.compile(r"\b(?:pair_style|pair_coeff|wall/gran|property/global)\b|^\s*(?:units|include)\b")


def _commands(text: str) -> Iterator[Statement]:
    """Commands of the text itself; those in include files and conditions, and those that a jump skips, are refused."""
    passed, ahead = set[str](), set[str]()  # labels, and those to which jumps lead
    for statement in Commands(text, flow=False):
        command, *words = statement.words
        if command == "label":
            passed.update(words[:1])
            ahead.difference_update(words[:1])
        elif command in ("jump", *NESTING):
            ahead |= {label for label in JUMP.findall(statement.text) if label} - passed
        elif ahead and HIDDEN.search(statement.text):
            raise refusal(statement.line, statement.text, "be a command that no jump skips")
        inner = command in NESTING and any(map(HIDDEN.search, words))
        if command == "include" or inner:
            raise refusal(statement.line, statement.text, "be commands of the text itself")
        yield statement


def _unit(statement: Statement) -> str:
    if len(statement.words) != 2 or statement.words[1] not in SYSTEMS:
        raise refusal(
            statement.line, statement.text, f"be units {', '.join(SYSTEMS)}, which can be converted to SI"
        )
    return statement.words[1]


def lammps(text: str, asked: Asked) -> Reading:
    """``pair_style``, ``pair_coeff`` and ``fix … wall/gran``; a line may also be a normal model alone."""
    pairs, walls = list[Contact](), dict[str, Contact]()
    units, style, types = "si", "", dict[str, str]()

    def made(
        bodies: tuple[str, ...], statement: Statement, found: granular_words.Words, wall: bool | None
    ) -> Contact:
        return Contact(bodies, settings(statement, found.settings), wall)

    for statement in _commands(text):
        command, *words = statement.words
        if command == "units":
            units = _unit(statement)
        elif command == "group" and words[1:2] == ["type"] and len(words) == 3:
            types[words[0]] = words[2].replace(":", "*")
        elif command == "pair_style":
            style = unaccelerated(words[0]) if words else ""
            if style.startswith("hybrid"):
                raise refusal(statement.line, statement.text, "be one style, granular or gran/…")
            pairs.clear()
            if style.startswith("gran/"):
                gran = granular_words.gran(statement, [style[5:], *words[1:]])
                pairs.append(made(("*", "*"), statement, gran, False))
        elif command == "pair_coeff" and style in ("", "granular"):
            if len(words) < 2:
                raise refusal(statement.line, statement.text, "name two types")
            found = granular_words.granular(statement, words[2:])
            pairs.append(made(ordered(words[0], words[1]), statement, found, False))
        elif command == "fix" and words[2:3] and words[2].startswith("wall/gran"):
            group = types.get(words[1], "*" if words[1] == "all" else words[1])
            walls[words[0]] = made(
                (group, words[0]), statement, granular_words.wall(statement, words[3:]), True
            )
        elif command == "unfix" and words:
            walls.pop(words[0], None)
        elif command in NORMAL:
            found = granular_words.granular(statement, statement.words, wall=True)
            pairs.append(made((f"line {statement.line}",), statement, found, None))
        elif command == "fix" and words[2:3] and words[2].startswith("damping/"):
            raise refusal(
                statement.line, statement.text, "be without this damping, which cannot be converted"
            )
    return Reading([*pairs, *walls.values()], units)


def liggghts(text: str, asked: Asked) -> Reading:
    """``pair_style gran``, ``fix … property/global`` and ``fix … wall/gran``."""
    units, pair = "si", None
    walls: dict[str, tuple[Sequence[tuple[str, str]], Settings]] = {}  # names and types of their surfaces
    meshes: dict[str, str] = {}
    properties: dict[str, Property] = {}

    def model(statement: Statement, words: Sequence[str]) -> Settings:
        return settings(statement, granular_words.gran_model(statement, words).settings)

    for statement in _commands(text):
        command, *words = statement.words
        style = words[2] if command == "fix" and len(words) > 2 else ""
        if command == "units":
            units = _unit(statement)
        elif command == "pair_style" and words and unaccelerated(words[0]) == "gran":
            pair = model(statement, words[1:])
        elif command == "pair_style":
            raise refusal(statement.line, statement.text, "be gran")
        elif style == "property/global" and len(words) > 4:
            if words[4] in PROPERTIES and words[3] in asked.names:
                properties[words[3]] = Property(statement, words[4], tuple(words[5:]))
        elif style.startswith("mesh/surface") and "type" in words:
            meshes |= dict(zip(words[:1], words[words.index("type") + 1 :], strict=False))
        elif style == "wall/gran":
            found = model(statement, words[3:])
            ends = words[words.index("type") + 1 : words.index("type") + 2] if "type" in words else []
            walls[words[0]] = (
                [(words[0], end) for end in ends] or [*meshes.items()] or [(words[0], "1")],
                found,
            )
        elif command == "unfix" and words:
            walls.pop(words[0], None)
            meshes.pop(words[0], None)
        elif command == "model":
            pair = model(statement, statement.words)
    count = max([1, *(one.types() for one in properties.values())])
    contacts = []
    for i in range(1, count + 1):
        for j in range(i, count + 1):
            values = _between(properties, i, j)
            if pair is not None and values is not None:
                contacts.append(Contact((str(i), str(j)), {**pair, **values}, False))
        for surfaces, found in walls.values():
            for name, end in surfaces:
                values = _between(properties, i, int(end)) if end.isdigit() else None
                if values is not None:
                    contacts.append(Contact((str(i), name), {**found, **values}, True))
    return Reading(contacts, units)


def _between(properties: Mapping[str, Property], i: int, j: int) -> Settings | None:
    """The settings of two types; None if a property per type differs between them or is missing."""
    found: Settings = {}
    for name, one in properties.items():
        pair = one.between(i, j)
        if pair is None or not same_word(*pair):
            return None
        found[name] = one.setting(pair[0])
    return found


# --- YADE -----------------------------------------------------------------------------------------------------

MATERIALS: Final = {
    "FrictMat": ("young", "poisson"),
    "ViscElMat": ("kn", "cn", "tc", "en", "young"),
}
PHYSICS: Final = {
    "MindlinPhys": ("en", "betan"),
    "FrictPhys": (),
    "ViscElPhys": ("tc", "en"),
}
#: Keywords that do not affect a normal contact.
HARMLESS: Final = (
    *("frictionAngle", "frictAngle", "density", "label", "id", "ks", "cs", "et", "es", "betas", "poisson"),
    *("mR", "mRtype", "krot", "eta", "ktwist", "calcEnergy", "neverErase", "preventGranularRatcheting"),
    "traceEnergy",
)


class _Lines(Yade):
    """Lines of a YADE script, which need not run."""

    def stage(self, quote: Quote, steps: int | None) -> None:
        """Runs do not matter."""


def yade(text: str, asked: Asked) -> Reading:
    """Materials, the ``Ip2_…`` functors that create contacts, and the damping of ``NewtonIntegrator``."""
    materials, physics, damping = list[tuple[str, Settings]](), None, None
    over: dict[str, dict[tuple[int, int], float]] = {}
    lines: dict[str, Instance] = {}
    common: Settings = {}
    script = _Lines(text)
    script.run()
    for change in script.assignments:
        if change.name in {*asked.names, "damping", "massMultiply", "gamma"}:
            raise refusal(change.line, change.text, "be given in the constructor")
    for call in script.instances:
        kind = call.name.rpartition("_")[2]
        if call.name == "NewtonIntegrator":
            damping = _number(call, "damping", NUMERICAL_DAMPING)
        elif call.name in MATERIALS:
            _refuse_words(call, MATERIALS[call.name])
            materials.append((call.name, _keywords(call, MATERIALS[call.name])))
        elif call.name.endswith("Mat") and call.name[:1].isupper() and call.attributes:
            raise refusal(call.line, call.text, f"be one of {', '.join(MATERIALS)}")
        elif call.name.startswith("Ip2_") or call.name in PHYSICS:
            if kind not in PHYSICS or (physics not in (None, kind)):
                raise refusal(call.line, call.text, f"be one of {', '.join(PHYSICS)}")
            _refuse_words(call, PHYSICS[kind])
            physics = kind
            for name, given in call.attributes.items():
                matches = _matches(given)
                if matches:
                    over[name], lines[name] = matches, call
            common = _keywords(call, PHYSICS[kind])
            if kind == "MindlinPhys" and not {"en", "betan"} & call.attributes.keys():
                common["betan"] = Setting(("0.0",), call.line, call.text)
            common["physics"] = Setting((kind,), call.line, call.text)
        elif call.name.startswith("Law2_") and (
            call.name not in LAWS or call.attributes.get("includeAdhesion") not in (None, False, 0)
        ):
            raise refusal(call.line, call.text, f"be one of {', '.join(LAWS)}")
    contacts = []
    paired = sorted({pair for matches in over.values() for pair in matches})
    for i, j in (paired or [(i, i) for i in range(len(materials))]) if materials else []:
        (kind, own), (_, other) = (materials[min(k, len(materials) - 1)] for k in (i, j))
        of_functor = common.keys() | {name for name, matches in over.items() if (i, j) in matches}
        if not _alike(own, other, of_functor):
            continue
        found = {**own, **common}
        if kind == "ViscElMat" and physics is None:
            found["physics"] = Setting(("ViscElPhys",), 0, "")
        for name, matches in over.items():
            if (i, j) in matches:
                found[name] = Setting((repr(matches[i, j]),), lines[name].line, lines[name].text)
        contacts.append(Contact((str(i + 1), str(j + 1)), found))
    if materials and not contacts:
        call = next(iter(lines.values()))
        raise refusal(call.line, call.text, "match materials with the same numbers")
    return Reading(contacts, numerical_damping=damping)


def _alike(one: Settings, other: Settings, but: set[str]) -> bool:
    """Whether two materials have the same settings, except those that a functor overrides."""
    one, other = ({name: x for name, x in each.items() if name not in but} for each in (one, other))
    return one.keys() == other.keys() and all(same(one[name], other[name]) for name in one)


def _matches(given: Any) -> dict[tuple[int, int], float]:
    """Numbers of MatchMaker(matches=[(id, id, number), …])."""
    if not isinstance(given, Instance) or given.name != "MatchMaker":
        return {}
    return {(min(i, j), max(i, j)): number for i, j, number in entries(given)}


def _word(given: Any) -> str:
    """A keyword's value as a word: a number, or what the script says."""
    if isinstance(given, bool | int | float):
        return repr(float(given))
    return given.text if isinstance(given, Unknown | Instance) else str(given)


def _refuse_words(call: Instance, known: Iterable[str]) -> None:
    for name, given in call.attributes.items():
        if name not in known and name not in HARMLESS:
            raise refusal(
                call.line,
                f"{name}={_word(given)}",
                f"be one of {', '.join(known) or 'no numbers'} in {call.name}",
            )


def _keywords(call: Instance, names: Iterable[str]) -> Settings:
    return {
        name: Setting((_word(given),), call.line, call.text)
        for name, given in call.attributes.items()
        if name in names and not _matches(given)
    }


def _number(call: Instance, name: str, default: float) -> float:
    given = call.attributes.get(name, default)
    if isinstance(given, bool) or not isinstance(given, int | float) or not 0.0 <= given < 1.0:
        raise refusal(call.line, call.text, f"have a number in [0, 1) for {name}")
    return float(given)


# --- lists of settings ----------------------------------------------------------------------------------------


def _flat(read: Callable[[str], Iterator[Statement]]) -> Callable[[str, Asked], Reading]:
    """A reader of settings that hold for all contacts, except those of owners that set the same as another owner."""

    def reader(text: str, asked: Asked) -> Reading:
        owned: dict[str, dict[str, Setting]] = {}
        for statement in read(text):
            name, *words = statement.words
            if name in asked.sticky and any(word not in ("0", "0.0") for word in words):
                raise refusal(statement.line, statement.text, "be without adhesion")
            if name not in asked.names:
                continue
            here = owned.setdefault(name, {})
            new = Setting(tuple(words), statement.line, statement.text)
            old = here.get(statement.owner)
            if old is not None and not same(old, new):
                raise refusal(new.line, new.text, f"be as on line {old.line}: {' '.join(old.text.split())}")
            here[statement.owner] = new
        common = {name: Setting((given,), 0, "") for name, given in asked.defaults.items()}
        owners = sorted({owner for by in owned.values() if len(by) > 1 for owner in by})
        for name, by in owned.items():
            (owner, setting), *others = by.items()
            if not others and owner not in owners:
                common[name] = setting
        if not owners:
            return Reading([Contact((), common)] if owned else [])
        return Reading(
            [
                Contact(
                    tuple(owner.split("-")),
                    {**common, **{name: by[owner] for name, by in owned.items() if owner in by}},
                )
                for owner in owners
            ]
        )

    return reader


def same(one: Setting, other: Setting) -> bool:
    """Whether two settings are equal, however their numbers are written."""
    pairs = zip(one.words, other.words, strict=False)
    return len(one.words) == len(other.words) and all(same_word(a, b) for a, b in pairs)


def mfix(text: str, asked: Asked) -> Reading:
    """Keywords with the index of a solid, or of a pair of solids in the upper triangle, row by row."""
    found: dict[tuple[str, int], Setting] = {}
    for statement in grammar.namelist(text):
        name, index, *words = statement.words
        if name in asked.sticky and any(word.upper() not in (".FALSE.", "F", "0", "0.0") for word in words):
            raise refusal(statement.line, statement.text, "be without adhesion")
        if name in asked.names:
            if not index.isdigit():
                raise refusal(statement.line, statement.text, "have one index")
            for k, word in enumerate(words):
                found[name, int(index) + k] = Setting((word.upper(),), statement.line, statement.text)
    entries = max([k for name, k in found if name == "DES_EN_INPUT"], default=1)
    solids = max([k for name, k in found if name in ("DES_EN_WALL_INPUT", "E_YOUNG", "V_POISSON")], default=1)
    while solids * (solids + 1) // 2 < entries:
        solids += 1
    common = {name: Setting((given,), 0, "") for name, given in asked.defaults.items()}
    contacts = []
    for i in range(1, solids + 1):
        for j in range(i, solids + 1):
            entry = (i - 1) * (2 * solids - i) // 2 + j
            if (one := _solids(found, i, j, entry)) is not None:
                contacts.append(Contact((str(i), str(j)), {**common, **one}, False))
        if (one := _solids(found, i, i, 0)) is not None:
            contacts.append(Contact((str(i), "wall"), {**common, **one}, True))
    return Reading(contacts)


def _solids(found: Mapping[tuple[str, int], Setting], i: int, j: int, entry: int) -> Settings | None:
    """The settings of two solids, or of a solid and a wall if ``entry`` is 0."""
    settings: Settings = {}
    for name, _ in found:
        if name == "DES_EN_INPUT":
            these = [(name, entry)]
        elif name in ("E_YOUNG", "V_POISSON"):
            these = [(name, i), (name, j)]
        else:
            these = [(name, i if name == "DES_EN_WALL_INPUT" else 1)]
        values = [found[one] for one in these if one in found]
        if len(values) == len(these) and all(same(values[0], one) for one in values):
            settings[name] = values[0]
    for name, of_wall in (("E_YOUNG", "EW_YOUNG"), ("V_POISSON", "VW_POISSON")):
        if entry == 0 and {name, of_wall} <= settings.keys() and not same(settings[name], settings[of_wall]):
            wall, ball = settings[of_wall], settings[name]
            raise refusal(
                wall.line,
                wall.text,
                f"be as on line {ball.line}: walls of another material are not supported",
            )
    needed = "DES_EN_WALL_INPUT" if entry == 0 else "DES_EN_INPUT"
    return settings if needed in settings else None


READERS: Final[dict[str, Callable[[str, Asked], Reading]]] = {
    "lammps": lammps,
    "liggghts": liggghts,
    "yade": yade,
    "c++": _flat(grammar.c_calls),
    "json": _flat(grammar.json_members),
    "xml": _flat(grammar.xml_attributes),
    "mfix": mfix,
}
