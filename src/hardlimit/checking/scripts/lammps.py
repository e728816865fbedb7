"""Contacts and insertions of LAMMPS: ``pair_style granular`` and ``gran/…``, ``fix wall/gran`` and ``fix pour``."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Final

from ...convert.tangential import Tangential
from . import census, filling, granular_words, lammps_friction, motion
from .description import WALL, ContactSettings, Quote, Setting, Settings
from .formulas import NUMBER
from .granular_words import ADHESIVE, NORMAL, PLASTIC, WALLS, Words, is_zero, ordered, unaccelerated
from .groups import MAX_TYPES
from .population import Batch
from .state import CREATED, DISK, SPHERE, Fix, State
from .statements import Statement, refused, settings

#: Words after the shape of a wall with their number of values.
WALL_OPTIONS: Final = {"wiggle": 3, "shear": 2, "contacts": 0, "temperature": 1}
CURVED: Final = ("cylinder", "sphere", "cone", "ellipsoid")
#: First versions that mix the numbers of two types without their own pair_coeff as they do today.
MIXED_SINCE: Final = {
    **dict.fromkeys(("hooke", "hertz"), "28 Mar 2023"),
    **dict.fromkeys(("hertz/material", *ADHESIVE), "15 Jun 2023"),  # whose moduli were mixed twice
}
#: Settings whose numbers need not be known.
OPTIONAL: Final = ("dampflag", "rolling", "twisting", lammps_friction.UNUSED)
#: Fixes that integrate velocities but no spins.
SPINLESS: Final = ("nve", "nvt", "npt", "nph", "nve/limit", "nve/noforce", "move", "brownian")
#: Fixes with their own walls.
GRANULAR_WALLS: Final = ("wall/gran", "wall/gran/region")


@dataclass(frozen=True)
class Coefficients:
    """What ``pair_coeff`` sets for two types."""

    style: str  #: of a hybrid style
    settings: Settings
    quote: Quote
    words: Words = granular_words.NONE


class Lammps(State):
    """A script or log of LAMMPS."""

    def reset(self) -> None:
        """As the command ``clear``."""
        super().reset()
        self.style, self.hybrid = "", False
        self.everywhere: dict[str, Coefficients] = {}  #: of gran/… styles, by style
        self.alone: Statement | None = None  #: the model of a text without pair_style and pair_coeff
        self.pairs: dict[tuple[int, int], list[Coefficients]] = {}

    def statement(self, statement: Statement) -> None:
        """Read one statement. A part of a script may be a normal model alone, for all pairs and a wall."""
        if self.style or statement.words[0] not in {**NORMAL, **ADHESIVE, **PLASTIC}:
            super().statement(statement)
            return
        self.changed_since = True
        if self.alone and self.alone.line != statement.line and self.alone.words != statement.words:
            raise refused(statement, f"be the model on line {self.alone.line}, or part of a pair_coeff")
        self.alone = statement
        super().statement(replace(statement, words=("pair_coeff", "*", "*", *statement.words)))

    # --- pair styles --------------------------------------------------------------------------------------------

    def command_pair_style(self, statement: Statement) -> None:
        self.last = statement
        words = list(statement.words[1:]) or ["none"]
        self.style = unaccelerated(words[0])
        self.hybrid = self.style.startswith("hybrid")
        self.everywhere, self.pairs = {}, {}
        for style, *rest in self.parts(words[1:]) if self.hybrid else [words]:
            name = unaccelerated(style)
            self.granular = self.granular or name.startswith("gran")
            if name.startswith("gran/"):
                self.understood(statement, partial(self.gran, statement, name, rest))
            elif name not in ("granular", "none", "zero"):
                what = (
                    "bonds between grains" if name.startswith("bpm") else f"forces beside contacts ({name})"
                )
                self.invalidate(what, statement)

    def parts(self, words: Sequence[str]) -> list[list[str]]:
        """The styles of a hybrid style with their words."""
        styles: list[list[str]] = []
        for word in words:
            name = unaccelerated(word)
            options = ("limit_damping", "NULL", "scaled")
            if not styles or (name not in options and not word.startswith("v_") and word[:1].isalpha()):
                styles.append([word])
            else:
                styles[-1].append(word)
        return styles

    def gran(self, statement: Statement, name: str, words: Sequence[str]) -> None:
        """A style gran/…, whose numbers hold for all pairs."""
        parsed = granular_words.gran(statement, [name[5:], *words])
        self.everywhere[name] = self.coefficients(statement, name, parsed)

    def coefficients(self, statement: Statement, style: str, parsed: Words) -> Coefficients:
        """Settings whose numbers are known."""
        for what in parsed.beside:
            self.ignore(what, statement)
        return Coefficients(style, self.known_settings(statement, parsed), statement.quote, parsed)

    def known_settings(self, statement: Statement, parsed: Words) -> Settings:
        """Settings whose numbers are known; a tangential force with other numbers is quoted."""
        own = lammps_friction.marked(settings(statement, parsed.settings), parsed)
        self.resolve(statement, {name: each for name, each in own.items() if name not in OPTIONAL})
        friction = self.coefficient(parsed.friction)
        if parsed.tangential and friction != 0.0 and self.tangential(parsed) is None:
            self.quote_with(statement, "the numbers of its tangential force are not known")
        return own

    def tangential(self, words: Words) -> Tangential | None:
        """The tangential force of a pair style or a wall."""
        return lammps_friction.tangential(words, self.coefficient)

    def command_pair_coeff(self, statement: Statement) -> None:
        self.understood(statement, lambda: self.pair_coeff(statement))
        self.last = statement

    def pair_coeff(self, statement: Statement) -> None:
        """Settings of pairs of types; a later line overrides an earlier one."""
        words = list(statement.words[1:])
        if len(words) < 2:
            raise refused(statement, "name two types")
        first, second = ordered(*(str(self.labels.get(word, word)) for word in words[:2]))
        rest, style = words[2:], self.style
        if self.hybrid:
            style = unaccelerated(rest[0]) if rest else "none"
            rest = rest[1:]
            if rest and rest[0].isdecimal() and style == "granular":
                rest = rest[1:]
        if style in ("granular", ""):
            self.granular = True
            parsed = granular_words.granular(statement, rest, adhesion=True)
            new = self.coefficients(statement, "granular", parsed)
        elif style in self.everywhere:
            new = self.everywhere[style]
        else:
            new = Coefficients(style, {}, statement.quote)
        pairs = [(i, j) for i in self.types_of(first) for j in self.types_of(second) if i <= j]
        if not pairs:
            raise refused(statement, "name types, the smaller first")
        self.types = max(self.types, *(int(word) for word in (first, second) if word.isdecimal()), 0)
        for pair in pairs:
            if self.style == "hybrid/overlay":
                others = [entry for entry in self.pairs.get(pair, []) if entry.style != new.style]
                self.pairs[pair] = [*others, new]
            else:
                self.pairs[pair] = [new]

    def contacts(self) -> Iterator[ContactSettings]:
        """Pairs of types, then walls; adhesion whose constant is 0 is left out."""
        for contact in self.all_contacts():
            settings, adhesion = sticky(contact.settings)
            damped = lammps_friction.ELASTIC in settings and not lammps_friction.undamped(settings)
            if damped or adhesion:
                contact = replace(contact, tangential=None, other_tangential=())
            yield replace(contact, settings=settings, adhesion=adhesion)

    def all_contacts(self) -> Iterator[ContactSettings]:
        """The contacts with their settings as given."""
        kinds = self.present()
        for i in kinds:
            for j in kinds[kinds.index(i) :]:
                contact = self.between(i, j)
                if contact is not None:
                    moving = motion.strongest([motion.of_grains(self, k) for k in (i, j)])
                    yield replace(contact, motion=moving)
        for name, fix in self.fixes.items():
            if fix.style in GRANULAR_WALLS:
                parsed = self.wall(fix)
                if parsed is not None:
                    words = self.words_of(fix)
                    force = self.at_wall(words, parsed)
                    shape, *ends = words.rest
                    friction = self.coefficient(words.friction)
                    pushes = granular_words.pushes(shape, *(end != "NULL" for end in ends[: WALLS[shape]]))
                    moves = motion.of_wall(self, words.rest, WALLS[shape], friction != 0.0)
                    quotes = (fix.statement.quote,)
                    for kind in self.walls_of(fix.group):
                        contact = self.wall_contact(
                            kind, name, parsed, quotes=quotes, pushes=pushes, friction=friction, motion=moves
                        )
                        yield with_force(contact, force)
        for kind in kinds if self.part and self.alone else ():
            for model in self.pairs.get((kind, kind), [])[-1:]:
                friction = self.coefficient(model.words.friction)
                contact = self.wall_contact(
                    kind,
                    WALL,
                    model.settings,
                    quotes=(model.quote,),
                    pushes=None,
                    friction=friction,
                    motion=None,
                )
                yield with_force(contact, self.at_wall(model.words, model.settings))

    def at_wall(self, words: Words, known: Settings) -> lammps_friction.Versions:
        """The tangential force of a wall in this version, and in others."""
        if self.version is not None and lammps_friction.divides_by_zero(known, self.version):
            return lammps_friction.Versions(None)
        return self.in_versions(self.tangential(words), words, wall=True)

    def in_versions(
        self, force: Tangential | None, words: Words, wall: bool = False
    ) -> lammps_friction.Versions:
        """A tangential force in this version, and in others."""
        return lammps_friction.in_versions(force, words, wall, self.version, self.coefficient)

    def between(self, i: int, j: int) -> ContactSettings | None:
        """Settings of two types: those given, those of a gran/… style, or the mixed ones."""
        types = (str(i), str(j))
        entries = [entry for entry in self.pairs.get((i, j), []) if "normal" in entry.settings]
        if entries:
            return self.of_pair(types, entries[-1])
        if (i, j) in self.pairs and self.hybrid:
            return None
        if self.everywhere and not self.hybrid:
            return self.of_pair(types, next(iter(self.everywhere.values())))
        ends = [self.pairs.get((k, k), []) for k in (i, j)]
        alone = [end[-1] for end in ends if end and "normal" in end[-1].settings]
        if len(alone) < 2 or i == j:
            return None
        mixture = mixed(*(entry.settings for entry in alone))
        if len({entry.words.tangential for entry in alone} - {""}) > 1:  # LAMMPS stops
            mixture = None
        quotes = tuple(dict.fromkeys(entry.quote for entry in alone))
        if mixture is None:
            self.unknown.update(dict.fromkeys(quotes))
            return None
        coefficients = [self.coefficient(entry.words.friction) for entry in alone]
        known = [coefficient for coefficient in coefficients if coefficient is not None]
        friction = math.sqrt(math.prod(known)) if len(known) == 2 and min(known) >= 0.0 else None
        forces = [self.tangential(entry.words) for entry in alone]
        force = lammps_friction.mixed(forces, [entry.settings for entry in alone], mixture)
        if any(each is not None and each.numbers.get("stiffness", 0.0) is None for each in forces):
            mixture[lammps_friction.MIXED] = replace(mixture["normal"], words=())
        since = mixed_since(alone[0].settings)
        contact = ContactSettings(types, None, mixture, quotes, since=since, friction=friction)
        return with_force(contact, self.in_versions(force, alone[0].words))

    def of_pair(self, types: tuple[str, str], entry: Coefficients) -> ContactSettings:
        """Settings of two types for which coefficients are given."""
        friction = self.coefficient(entry.words.friction)
        contact = ContactSettings(types, None, entry.settings, (entry.quote,), friction=friction)
        return with_force(contact, self.in_versions(self.tangential(entry.words), entry.words))

    def note_friction(self, contacts: Sequence[ContactSettings]) -> None:
        """Note what the friction of the contacts really does, errors of a version first."""
        grains = {str(kind): self.grains(kind) for kind in self.present()}
        said = [(contact, contact.differs) for contact in contacts if contact.differs]
        said += [
            (contact, what)
            for contact in contacts
            for what in lammps_friction.remarks(contact, self.version, grains, self.dimension)
        ]
        for contact, what in said:
            self.warn(what, contact)

    def inertia_factor(self, kind: int) -> float:
        """As for all codes; the fixes that integrate spins take grains as disks if they have the word ``disc``."""
        own = self.integrators_of(kind)
        spinning = [fix for fix in own if fix.style not in SPINLESS]
        if spinning or not own:
            return DISK if spinning and all("disc" in fix.words for fix in spinning) else SPHERE
        return math.inf

    # --- walls and insertions -----------------------------------------------------------------------------------

    def own_fix(self, fix: Fix) -> bool:
        """Walls and pouring."""
        if fix.style in GRANULAR_WALLS:
            self.last, self.granular = fix.statement, True
            if not self.understood(fix.statement, lambda: self.read_wall(fix)):
                self.fixes = {name: other for name, other in self.fixes.items() if other is not fix}
            return True
        if fix.style in ("pour", "deposit"):
            if not self.understood(fix.statement, lambda: self.insert(fix), contacts=False):
                self.population.from_elsewhere()
            return True
        return False

    def words_of(self, fix: Fix) -> Words:
        """The words of a wall. Before 2017, walls had the style of the pairs."""
        old = bool(fix.words and NUMBER.fullmatch(fix.words[0]) and self.style.startswith("gran/"))
        words = [self.style[5:], *fix.words] if old else fix.words
        return granular_words.wall(fix.statement, words, adhesion=True)

    def wall(self, fix: Fix) -> Settings | None:
        """The settings of a wall that was understood."""
        try:
            words = self.words_of(fix)
            return lammps_friction.marked(settings(fix.statement, words.settings), words)
        except ValueError:
            return None

    def read_wall(self, fix: Fix) -> None:
        """Check a wall, and note what is special about it."""
        statement = fix.statement
        parsed = self.words_of(fix)
        self.known_settings(statement, parsed)
        if "normal" not in parsed.settings:
            raise refused(statement, "have a normal model")
        rest = list(parsed.rest)
        if not rest or len(rest) <= WALLS[rest[0]]:
            raise refused(statement, f"have a wall: {', '.join(WALLS)}")
        regions = self.parts_of(rest[1]).values() if rest[0] == "region" else ()
        if rest[0] == "zcylinder" or any(words[:1] and words[0] in CURVED for words in regions):
            self.ignore("curvature of a wall, which is taken as a plane", statement)
        if any(word in ("move", "rotate") or self.varies(word) for words in regions for word in words):
            self.ignore("a moving wall (region)", statement)
        k = 1 + WALLS[rest[0]]
        if any(map(self.varies, rest[1:k])):
            self.ignore(f"a moving wall ({rest[0]})", statement)
        while k < len(rest):
            if rest[k] not in WALL_OPTIONS:
                raise refused(statement, f"have {', '.join(WALL_OPTIONS)} after the wall, not {rest[k]}")
            if rest[k] in ("wiggle", "shear"):
                self.ignore(f"a moving wall ({rest[k]})", statement)
            k += 1 + WALL_OPTIONS[rest[k]]
        for what in parsed.beside:
            self.ignore(what, statement)

    def varies(self, word: str) -> bool:
        """Whether a word is a variable that only a run knows, such as a position that changes in time."""
        return word.startswith("v_") and self.variables.of(word[2:]) is None

    def insert(self, fix: Fix) -> None:
        """``fix pour`` and ``fix deposit``: smallest and largest diameter and density."""
        statement, words = fix.statement, list(fix.words)
        kind = self.type_of((*words, "", "")[1])
        if "mol" in words[:-1]:
            self.add_molecule(statement, words[words.index("mol") + 1], kind)
            return
        if not 1 <= kind <= MAX_TYPES:
            raise refused(statement, "have a type")
        if fix.style == "deposit":
            self.population.add(kind, CREATED)
            filling.poured(self, fix, kind, None, None)
            return
        radii, densities = (0.5, 0.5), (1.0, 1.0)
        for k, word in enumerate(words):
            if word == "diam":
                radii = self.diameters(statement, words[k + 1 :])
            elif word == "dens":
                densities = self.limits(statement, words[k + 1 : k + 3])
        self.population.add(kind, Batch(radii, densities))
        count = self.coefficient((*words, "")[0])
        filling.poured(self, fix, kind, count, self.means(statement, words))

    def means(self, statement: Statement, words: Sequence[str]) -> tuple[float, float] | None:
        """Means of r² and r³ of the diameters of ``fix pour``, which are uniform in a range; 1 by default."""
        if "diam" not in words:
            return census.moments((0.5, 0.5))
        style, *rest = words[words.index("diam") + 1 :]
        if style != "poly":
            return census.moments(self.diameters(statement, [style, *rest]))
        numbers = [self.number(statement, word) for word in rest[1 : 1 + 2 * int(rest[0])]]
        pairs = [(0.5 * size, share) for size, share in zip(numbers[::2], numbers[1::2], strict=False)]
        return census.moments((0.5, 0.5), pairs)

    def diameters(self, statement: Statement, words: Sequence[str]) -> tuple[float, float]:
        """Radii of ``one D``, ``range D D`` or ``poly N D P D P …``."""
        style = (*words, "")[0]
        if style == "one":
            ends = [words[1]] if len(words) > 1 else []
        elif style == "range":
            ends = list(words[1:3])
        elif style == "poly":
            count = int(words[1]) if len(words) > 1 and words[1].isdecimal() else 0
            ends = list(words[2 : 2 + 2 * min(count, len(words)) : 2])
        else:
            ends = list(words[:2])  # LAMMPS before 2011, LIGGGHTS before 3
        low, high = self.limits(statement, ends)
        return 0.5 * low, 0.5 * high

    def limits(self, statement: Statement, words: Sequence[str]) -> tuple[float, float]:
        """Smallest and largest of some positive numbers."""
        numbers = [self.number(statement, word) for word in words]
        if not numbers or min(numbers) <= 0.0 or not math.isfinite(max(numbers)):
            raise refused(statement, "have positive diameters and densities")
        return min(numbers), max(numbers)


def with_force(contact: ContactSettings, force: lammps_friction.Versions) -> ContactSettings:
    """A contact with its tangential force."""
    own = force.force
    friction = own.numbers["coefficient"] if own is not None else contact.friction
    return replace(
        contact, friction=friction, tangential=own, other_tangential=force.others, differs=force.what
    )


def sticky(settings: Settings) -> tuple[Settings, str]:
    """Settings without adhesion whose constant is 0, and what makes the force adhesive or plastic, in words."""
    setting = settings["normal"]
    name, *numbers = setting.words
    if name in PLASTIC:
        return settings, f"plastic deformation ({name})"
    if name not in ADHESIVE:
        return settings, ""
    if not is_zero(numbers[-1]):
        return settings, f"adhesion ({name})"
    material = replace(setting, words=("hertz/material", *numbers[:-1]))
    return {**settings, "normal": material, **elastic_limit(setting, name)}, ""


def elastic_limit(setting: Setting, name: str) -> Settings:
    """What models of adhesion leave of themselves if their constant is 0."""
    return {lammps_friction.ELASTIC: replace(setting, words=(name,))}


def mixed_since(settings: Settings) -> str:
    """The first version that mixes the numbers of two types; older ones take a linear spring with constant damping."""
    name = settings["normal"].words[0]
    usual = name == "hooke" and settings["damping"].words == ("velocity",)
    return "" if usual else MIXED_SINCE[name]


def mixed_resistance(settings: Settings, other: Settings, kind: str) -> tuple[str, ...]:
    """The words of rolling or twisting of two types: the geometric means of their numbers."""
    name, *numbers = settings[kind].words
    if kind not in other or len(other[kind].words) != len(settings[kind].words):
        return ("none",)
    try:
        pairs = [(float(x), float(y)) for x, y in zip(numbers, other[kind].words[1:], strict=True)]
        return (name, *(f"{math.sqrt(x * y):g}" for x, y in pairs))
    except ValueError:
        return (name,)


def mixed(settings: Settings, other: Settings) -> Settings | None:
    """Settings of a pair without its own: as in ``GranSubMod::mix_coeffs``; None if the models differ.

    Coefficients have their geometric mean, moduli E* with 1/E* = (1 − ν₁²)/E₁ + (1 − ν₂²)/E₂. The result for
    ``hertz/material``, and of adhesion whose constant is 0, is ``hertz`` with 4/3 E*.
    """
    a, b = settings["normal"].words, other["normal"].words
    if (
        a[0] != b[0]
        or settings["damping"].words != other["damping"].words
        or a[0] not in {**NORMAL, **ADHESIVE}
    ):
        return None
    try:
        first, second = ([float(word) for word in words[1:]] for words in (a, b))
        means = [math.sqrt(x * y) for x, y in zip(first, second, strict=True)]
        name = a[0]
        if name in ("hertz/material", *ADHESIVE):
            means[0] = 1.0 / sum((1.0 - x[2] ** 2) / x[0] for x in (first, second))
        if name == "hertz/material" or (name in ADHESIVE and means[-1] == 0.0):
            name, means = "hertz", [4.0 / 3.0 * means[0], means[1]]
    except (ValueError, ZeroDivisionError):
        return None
    mixture = dict(settings)
    line = settings["normal"]
    mixture["normal"] = Setting((name, *(repr(x) for x in means)), line.line, line.text)
    if name != a[0] and a[0] in ADHESIVE:
        mixture |= elastic_limit(line, a[0])
    if "limit_damping" in other:
        mixture["limit_damping"] = other["limit_damping"]
    for kind in ("rolling", "twisting"):
        if kind in mixture:
            mixture[kind] = replace(mixture[kind], words=mixed_resistance(settings, other, kind))
    return mixture
