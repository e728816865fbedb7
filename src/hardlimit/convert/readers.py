"""Readers of the input of particle codes. The files in ``codes`` select a reader by name.

A reader returns the settings of each contact. In statements that affect a normal contact it either understands a word
or refuses it with a message that quotes it. It skips other statements.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from . import grammar
from .grammar import Call, Statement, refusal


@dataclass(frozen=True)
class Setting:
    """A setting and its place in the input."""

    words: tuple[str, ...]
    line: int
    text: str


Settings = dict[str, Setting]


@dataclass(frozen=True)
class Contact:
    """The settings of a contact of two bodies: types, ranges of types such as ``1*3``, or names."""

    bodies: tuple[str, ...]
    settings: Settings
    wall: bool | None = None  #: whether it is a contact with a wall; None if the settings hold for both

    @property
    def name(self) -> str:
        """A name such as ``1-2`` or ``1-wall``."""
        return "-".join(self.bodies)

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


# --- LAMMPS ---------------------------------------------------------------------------------------------------

#: Normal models of ``pair_style granular`` and their number of parameters.
NORMAL: Final = {"hooke": 2, "hertz": 2, "hertz/material": 3}
DAMPING: Final = ("velocity", "mass_velocity", "viscoelastic", "tsuji", "coeff_restitution")
TANGENTIAL: Final = {
    "linear_nohistory": 2,
    "none": 0,
    **dict.fromkeys(
        ("linear_history", "linear_history_classic", "mindlin_classic", "mindlin", "mindlin/force"), 3
    ),
    **dict.fromkeys(("mindlin_rescale", "mindlin_rescale/force"), 3),
}
BESIDE: Final = {
    "tangential": TANGENTIAL,
    "rolling": {"none": 0, "sds": 3},
    "twisting": {"none": 0, "marshall": 0, "sds": 3},
    "heat": {"none": 0, "radius": 1, "area": 1},
}
GRAN: Final = ("hooke", "hooke/history", "hertz/history")
WALLS: Final = ("xplane", "yplane", "zplane", "zcylinder", "region")
#: Commands that may be hidden inside another command.
HIDDEN: Final = re.compile(r"\b(?:pair_style|pair_coeff|wall/gran|property/global)\b|^\s*units\b")


def lammps(text: str, asked: Asked) -> Reading:
    """``pair_style``, ``pair_coeff`` and ``fix … wall/gran``; a line may also be a normal model alone."""
    contacts, units, style, types = list[Contact](), "si", "", dict[str, str]()
    for statement in grammar.script(text):
        command, *words = statement.words
        _refuse_hidden(statement)
        if command == "units":
            units = _unit(statement)
        elif command == "group" and words[1:2] == ["type"] and len(words) == 3:
            types[words[0]] = words[2].replace(":", "*")
        elif command == "pair_style":
            style = _unaccelerated(words[0]) if words else ""
            if style.startswith("hybrid"):
                raise refusal(statement.line, statement.text, "be one style, granular or gran/…")
            contacts = [one for one in contacts if one.wall]
            if style.startswith("gran/"):
                contacts += [Contact(("*", "*"), _gran(statement, [style[5:], *words[1:]], ()), False)]
        elif command == "pair_coeff" and style in ("", "granular"):
            if len(words) < 2:
                raise refusal(statement.line, statement.text, "name two types")
            contacts.append(Contact(_ordered(words[0], words[1]), _granular(statement, words[2:], ()), False))
        elif command == "fix" and words[2:3] and words[2].startswith("wall/gran"):
            group = types.get(words[1], "*" if words[1] == "all" else words[1])
            rest = words[3:]
            read = _granular if rest[:1] == ["granular"] else _gran
            found = read(statement, rest[1:] if read is _granular else rest, WALLS)
            end = next((k for k, word in enumerate(rest) if word in WALLS), len(rest))
            if "limit_damping" in rest[end:]:
                raise refusal(statement.line, statement.text, f"have limit_damping before {rest[end]}")
            contacts.append(Contact((group, "wall"), found, True))
        elif command in NORMAL:
            contacts.append(
                Contact((f"line {statement.line}",), _granular(statement, statement.words, WALLS))
            )
        elif command == "fix" and words[2:3] and words[2].startswith("damping/"):
            raise refusal(
                statement.line, statement.text, "be without this damping, which cannot be converted"
            )
    return Reading(contacts, units)


def _refuse_hidden(statement: Statement) -> None:
    command, *words = statement.words
    inner = command in ("if", "run", "python") and any(map(HIDDEN.search, words))
    if command == "include" or inner:
        raise refusal(statement.line, statement.text, "be commands of the text itself")


def _unit(statement: Statement) -> str:
    if len(statement.words) != 2 or statement.words[1] not in UNITS:
        raise refusal(
            statement.line, statement.text, f"be units {', '.join(UNITS)}, which can be converted to SI"
        )
    return statement.words[1]


#: Units of mass [kg], length [m] and time [s] by name.
UNITS: Final = {
    "si": (1.0, 1.0, 1.0),
    "cgs": (1e-3, 1e-2, 1.0),
    "micro": (1e-15, 1e-6, 1e-6),
    "nano": (1e-21, 1e-9, 1e-9),
}


def _unaccelerated(style: str) -> str:
    return re.sub(r"/(omp|kk|kk/host|kk/device|gpu|intel|opt)$", "", style)


def _ordered(first: str, second: str) -> tuple[str, str]:
    both_numbers = first.isdigit() and second.isdigit()
    return (second, first) if both_numbers and int(second) < int(first) else (first, second)


def _gran(statement: Statement, words: Sequence[str], ends: Sequence[str]) -> Settings:
    """``STYLE Kn Kt gamma_n gamma_t xmu dampflag [limit_damping]``, and for walls their shape."""
    if not words or words[0] not in GRAN or len(words) < 7:
        raise refusal(statement.line, statement.text, f"be {', '.join(GRAN)} with six numbers")
    name = "gran/hertz" if words[0] == "hertz/history" else "gran/hooke"
    found: dict[str, tuple[str, ...]] = {"normal": (name, words[1], words[3])}
    rest = list(words[7:])
    if rest[:1] == ["limit_damping"]:
        found["limit_damping"] = ()
        rest = rest[1:]
    if rest[:1] and rest[0] not in ends:
        raise refusal(
            statement.line, rest[0], f"be limit_damping or the end in '{' '.join(statement.words)}'"
        )
    return _settings(statement, found)


def _granular(statement: Statement, words: Sequence[str], ends: Sequence[str]) -> Settings:
    """``MODEL numbers [damping …] [tangential …] … [limit_damping]``, up to the shape of a wall."""
    found: dict[str, tuple[str, ...]] = {"damping": ("viscoelastic",)}
    k = 0
    while k < len(words) and words[k] not in ends:
        word, after = words[k], words[k + 1 : k + 2]
        if word in NORMAL:
            step = 1 + NORMAL[word]
            found["normal"] = tuple(words[k : k + step])
        elif word == "damping" and after and after[0] in DAMPING:
            step = 2
            found["damping"] = (after[0],)
        elif word in BESIDE and after and after[0] in BESIDE[word]:
            step = 2 + BESIDE[word][after[0]]
        elif word in ("limit_damping", "cutoff"):
            step = 1 if word == "limit_damping" else 2
            found[word] = ()
        else:
            raise refusal(
                statement.line,
                " ".join([word, *after]),
                f"be words of pair granular without adhesion: {', '.join(NORMAL)}, damping, tangential, …",
            )
        if k + step > len(words):
            raise refusal(statement.line, statement.text, f"have {step - 1} words after {word}")
        k += step
    return _settings(statement, found)


def _settings(statement: Statement, found: Mapping[str, tuple[str, ...]]) -> Settings:
    return {name: Setting(words, statement.line, statement.text) for name, words in found.items()}


# --- LIGGGHTS -------------------------------------------------------------------------------------------------

#: Words of ``pair_style gran`` and ``fix … wall/gran`` with their allowed values; None allows any value.
LIGGGHTS: Final[dict[str, tuple[str, ...] | None]] = {
    "tangential": None,
    "rolling_friction": None,
    "cohesion": ("off",),
    "surface": ("default",),
    "limitForce": ("on", "off"),
    "tangential_damping": None,
    "ktToKnUser": None,
    "torsionTorque": None,
    "viscous": ("off",),
    "absolute_damping": ("off",),
    "computeElasticPotential": None,
    "computeDissipatedEnergy": None,
    "computeDissipation": None,
}
PROPERTIES: Final = {"peratomtype": 1, "peratomtypepair": 2, "scalar": 0}


def liggghts(text: str, asked: Asked) -> Reading:
    """``pair_style gran``, ``fix … property/global`` and ``fix … wall/gran``."""
    units, pair, walls, meshes = "si", None, list[tuple[str, Settings]](), list[str]()
    properties: dict[str, tuple[Statement, str, list[str]]] = {}
    for statement in grammar.script(text):
        command, *words = statement.words
        _refuse_hidden(statement)
        style = words[2] if command == "fix" and len(words) > 2 else ""
        if command == "units":
            units = _unit(statement)
        elif command == "pair_style" and words[:1] == ["gran"]:
            pair = _gran_model(statement, words[1:])
        elif command == "pair_style":
            raise refusal(statement.line, statement.text, "be gran")
        elif style == "property/global" and len(words) > 4:
            if words[4] in PROPERTIES:
                properties[words[3]] = (statement, words[4], words[5:])
        elif style.startswith("mesh/surface") and "type" in words:
            meshes += words[words.index("type") + 1 : words.index("type") + 2]
        elif style == "wall/gran":
            found = _gran_model(statement, words[3:])
            ends = words[words.index("type") + 1 : words.index("type") + 2] if "type" in words else []
            walls += [(end, found) for end in ends or meshes or ["1"]]
        elif command == "model":
            pair = _gran_model(statement, statement.words)
    wanted = {name: given for name, given in properties.items() if name in asked.names}
    count = max([1, *(_types(*given) for given in wanted.values())])
    contacts = []
    for i in range(1, count + 1):
        for j in range(i, count + 1):
            values = _between(wanted, i, j)
            if pair is not None and values is not None:
                contacts.append(Contact((str(i), str(j)), {**pair, **values}, False))
        for end, found in walls:
            values = _between(wanted, i, int(end)) if end.isdigit() else None
            if values is not None:
                contacts.append(Contact((str(i), "wall"), {**found, **values}, True))
    return Reading(contacts, units)


def _gran_model(statement: Statement, words: Sequence[str]) -> Settings:
    """``model NAME word value …``, up to the shape of a wall."""
    if len(words) < 2 or words[0] != "model":
        raise refusal(statement.line, statement.text, "begin with model NAME")
    found: dict[str, tuple[str, ...]] = {"model": (words[1],)}
    k, wall = 2, False
    while k < len(words):
        word, after = words[k], words[k + 1 : k + 2]
        wall = wall or word in ("primitive", "mesh")
        if wall and word not in LIGGGHTS:  # shape of the wall
            k += 1
            continue
        if word not in LIGGGHTS or not after or after[0] not in (LIGGGHTS[word] or after):
            known = LIGGGHTS.get(word)
            must = f"be {word} {' or '.join(known)}" if known else f"be a setting of model {words[1]}"
            raise refusal(statement.line, " ".join([word, *after]), f"{must}: nothing else is supported")
        found[word] = (after[0],)
        k += 2
    return _settings(statement, found)


def _types(statement: Statement, kind: str, given: Sequence[str]) -> int:
    """Number of types for which a property is given."""
    if kind == "peratomtypepair":
        count = int(given[0]) if given and given[0].isdigit() else 0
        if count < 1 or len(given) != 1 + count * count:
            raise refusal(
                statement.line, statement.text, "be a number of types and one number for each pair of types"
            )
        return count
    if not given or (kind == "scalar" and len(given) != 1):
        raise refusal(statement.line, statement.text, "have its numbers")
    return 1 if kind == "scalar" else len(given)


def _between(properties: Mapping[str, tuple[Statement, str, list[str]]], i: int, j: int) -> Settings | None:
    """The settings of two types; None if a property per type differs between them or is missing."""
    found: Settings = {}
    for name, (statement, kind, given) in properties.items():
        if kind == "peratomtypepair":
            count = int(given[0])
            if max(i, j) > count:
                return None
            words = [given[1 + count * (a - 1) + b - 1] for a, b in ((i, j), (j, i))]
            if _canonical(words[0]) != _canonical(words[1]):
                raise refusal(statement.line, statement.text, f"have one number for {i}-{j} and {j}-{i}")
        else:
            if kind == "peratomtype" and max(i, j) > len(given):
                return None
            words = [given[0], given[0]] if kind == "scalar" else [given[i - 1], given[j - 1]]
            if _canonical(words[0]) != _canonical(words[1]):
                return None
        found[name] = Setting((words[0],), statement.line, statement.text)
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
LAWS: Final = (
    "Law2_ScGeom_MindlinPhys_Mindlin",
    "Law2_ScGeom_FrictPhys_CundallStrack",
    "Law2_ScGeom_ViscElPhys_Basic",
)
#: Keywords that do not affect a normal contact.
HARMLESS: Final = (
    *("frictionAngle", "frictAngle", "density", "label", "id", "ks", "cs", "et", "es", "betas", "poisson"),
    *("mR", "mRtype", "krot", "eta", "ktwist", "calcEnergy", "neverErase", "preventGranularRatcheting"),
    "traceEnergy",
)
NUMERICAL_DAMPING: Final = 0.2  #: NewtonIntegrator's default


def yade(text: str, asked: Asked) -> Reading:
    """Materials, the ``Ip2_…`` functors that create contacts, and the damping of ``NewtonIntegrator``."""
    materials, physics, damping = list[tuple[str, Settings]](), None, None
    over: dict[str, dict[tuple[int, int], float]] = {}
    lines: dict[str, Call] = {}
    common: Settings = {}
    for call in grammar.python_calls(text):
        kind = call.name.rpartition("_")[2]
        if call.name == "NewtonIntegrator":
            damping = _number(call, "damping", NUMERICAL_DAMPING)
        elif call.name == "=" and set(call.keywords) & {*asked.names, "damping", "massMultiply", "gamma"}:
            raise refusal(call.line, call.text, "be given in the constructor")
        elif call.name in MATERIALS:
            _refuse_words(call, MATERIALS[call.name])
            materials.append((call.name, _keywords(call, MATERIALS[call.name])))
        elif call.name.endswith("Mat") and call.name[:1].isupper() and call.keywords:
            raise refusal(call.line, call.text, f"be one of {', '.join(MATERIALS)}")
        elif call.name.startswith("Ip2_") or call.name in PHYSICS:
            if kind not in PHYSICS or (physics not in (None, kind)):
                raise refusal(call.line, call.text, f"be one of {', '.join(PHYSICS)}")
            _refuse_words(call, PHYSICS[kind])
            physics = kind
            for name, given in call.keywords.items():
                if isinstance(given, dict):
                    over[name], lines[name] = given, call
            common = _keywords(call, PHYSICS[kind])
            if kind == "MindlinPhys" and not {"en", "betan"} & call.keywords.keys():
                common["betan"] = Setting(("0.0",), call.line, call.text)
            common["physics"] = Setting((kind,), call.line, call.text)
        elif call.name.startswith("Law2_") and (
            call.name not in LAWS or call.keywords.get("includeAdhesion", 0.0) != 0.0
        ):
            raise refusal(call.line, call.text, f"be one of {', '.join(LAWS)}")
    contacts = []
    paired = sorted({pair for matches in over.values() for pair in matches})
    for i, j in (paired or [(i, i) for i in range(len(materials))]) if materials else []:
        kind, settings = materials[min(i, len(materials) - 1)]  # a loop creates several from one line
        found = {**settings, **common}
        if kind == "ViscElMat" and physics is None:
            found["physics"] = Setting(("ViscElPhys",), 0, "")
        for name, matches in over.items():
            if (i, j) in matches:
                found[name] = Setting((repr(matches[i, j]),), lines[name].line, lines[name].text)
        contacts.append(Contact((str(i + 1), str(j + 1)), found))
    return Reading(contacts, numerical_damping=damping)


def _refuse_words(call: Call, known: Iterable[str]) -> None:
    for name, given in call.keywords.items():
        if name not in known and name not in HARMLESS:
            raise refusal(
                call.line, f"{name}={given}", f"be one of {', '.join(known) or 'no numbers'} in {call.name}"
            )


def _keywords(call: Call, names: Iterable[str]) -> Settings:
    return {
        name: Setting((repr(given) if isinstance(given, float) else str(given),), call.line, call.text)
        for name, given in call.keywords.items()
        if name in names and not isinstance(given, dict)
    }


def _number(call: Call, name: str, default: float) -> float:
    given = call.keywords.get(name, default)
    if not isinstance(given, float) or not 0.0 <= given < 1.0:
        raise refusal(call.line, call.text, f"have a number in [0, 1) for {name}")
    return given


# --- lists of settings ----------------------------------------------------------------------------------------


def _flat(read: Callable[[str], Iterator[Statement]]) -> Callable[[str, Asked], Reading]:
    """A reader of settings that hold for all contacts, except those that are set for several owners."""

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
        common |= {name: next(iter(by.values())) for name, by in owned.items() if len(by) == 1}
        owners = sorted({owner for by in owned.values() if len(by) > 1 for owner in by})
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
    return len(one.words) == len(other.words) and all(_canonical(a) == _canonical(b) for a, b in pairs)


def _canonical(word: str) -> str | float:
    return float(word) if grammar.NUMBER.fullmatch(word) else word


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
