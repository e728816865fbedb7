"""Contacts and insertions of LIGGGHTS: ``pair_style gran``, properties, walls and particle templates."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

from ...convert.tangential import Tangential
from . import census, clumps, filling, granular_words, gravity, liggghts_friction, motion
from .description import ContactSettings, Note, Quote, Range, Setting, Settings
from .formulas import NUMBER
from .granular_words import PROPERTIES, Words, is_zero, unaccelerated
from .groups import MAX_TYPES
from .materials import one_material
from .population import Batch
from .state import DISK, SPHERE, Fix, State
from .statements import Statement, refused, same_word, settings

#: Properties that the models read; each depends on two types.
OF_CONTACT: Final = (
    *("youngsModulus", "poissonsRatio", "coefficientRestitution", "characteristicVelocity"),
    *("kn", "gamman", "gamman_abs", "cohesionEnergyDensity", "surfaceTension", "fluidViscosity"),
)
#: Normal models with plasticity or adhesion.
STICKY_MODELS: Final = (
    "hooke/hysteresis",
    "edinburgh",
    "edinburgh/stiffness",
    "luding",
    "thornton_ning",
    "jkr",
)
#: Words that LIGGGHTS takes as numbers.
OF_NUMBERS: Final = re.compile(r"[-+.\deE]*[.\d][-+.\deE]*")
#: Fixes that leave spins alone.
SPINLESS: Final = ("nve", "nve/limit", "nve/noforce", "move")
#: Models of cohesion with the properties to which their force is proportional.
COHESION: Final[dict[str, tuple[str, ...]]] = {
    **dict.fromkeys(("sjkr", "sjkr2"), ("cohesionEnergyDensity",)),
    **dict.fromkeys(
        ("easo/capillary/viscous", "washino/capillary/viscous"), ("surfaceTension", "fluidViscosity")
    ),
}


@dataclass(frozen=True)
class Property:
    """A global property."""

    statement: Statement
    kind: str  #: a key of ``PROPERTIES``
    values: tuple[str, ...]

    def types(self) -> int:
        """Number of types for which it is given; 0 for all."""
        return property_types(self.statement, self.kind, self.values)

    def between(self, i: int, j: int) -> tuple[str, str] | None:
        """The values of two types, or of the pair and of its mirror image; None if they are not given."""
        count = self.types()
        if self.kind == "scalar":
            return self.values[0], self.values[0]
        if max(i, j) > count:
            return None
        if self.kind == "peratomtype":
            return self.values[i - 1], self.values[j - 1]
        first, second = (self.values[1 + count * (a - 1) + b - 1] for a, b in ((i, j), (j, i)))
        if not same_word(first, second):
            raise refused(self.statement, f"have one number for {i}-{j} and {j}-{i}")
        return first, second

    def setting(self, word: str) -> Setting:
        """A setting that comes from this property."""
        return Setting((word,), self.statement.line, self.statement.text)


def property_types(statement: Statement, kind: str, values: Sequence[str]) -> int:
    """Number of types for which a property is given; 0 for a scalar."""
    if kind == "peratomtypepair":
        count = int(values[0]) if values and values[0].isdecimal() and len(values[0]) < 6 else 0
        if count < 1 or len(values) != 1 + count * count:
            raise refused(statement, "be a number of types and one number for each pair of types")
        return count
    if not values or (kind == "scalar" and len(values) != 1):
        raise refused(statement, "have its numbers")
    return 0 if kind == "scalar" else len(values)


def sticky(contact: ContactSettings) -> ContactSettings:
    """A contact without cohesion whose constants are 0, and with words for other adhesion or plasticity."""
    settings = contact.settings
    model, cohesion = (
        settings["model"].words[0],
        (settings["cohesion"].words if "cohesion" in settings else ("off",))[0],
    )
    if model in STICKY_MODELS:
        return replace(contact, adhesion=f"plastic deformation or adhesion ({model})")
    constants = [settings.get(name) for name in COHESION.get(cohesion, ())]
    if cohesion == "off" or (
        constants and all(constant is not None and is_zero(constant.words[0]) for constant in constants)
    ):
        return replace(
            contact, settings={name: setting for name, setting in settings.items() if name != "cohesion"}
        )
    return replace(contact, adhesion=f"cohesion ({cohesion})")


class Liggghts(State):
    """A script or log of LIGGGHTS."""

    def reset(self) -> None:
        """As the command ``clear``."""
        super().reset()
        self.model: tuple[Settings, Quote] | None = None
        self.properties: dict[str, Property] = {}
        self.templates: dict[str, tuple[int, Batch]] = {}
        self.distributions: dict[str, list[str]] = {}
        #: Of the mass, or of the number of grains, of the templates of each distribution.
        self.shares: dict[str, list[float | None]] = {}
        self.by_number: set[str] = set()  #: distributions with shares of the number
        self.meshes: dict[str, int] = {}
        self.coarse = 1.0
        self.levels: dict[int, float] = {}  #: of coarse graining, of types that ``insert/pack/face`` makes

    def statement(self, statement: Statement) -> None:
        """Read one statement. A part of a script may be ``model NAME …`` alone."""
        alone = statement.words[0] == "model"
        super().statement(
            replace(statement, words=("pair_style", "gran", *statement.words)) if alone else statement
        )

    def number(self, statement: Statement, word: str) -> float:
        """A number. The code takes words of its letters alone as C's ``atof`` does: 0 for ``.0.0``."""
        if OF_NUMBERS.fullmatch(word) and not NUMBER.fullmatch(word):
            begin = NUMBER.match(word)
            return float(begin[0]) if begin else 0.0
        return super().number(statement, word)

    # --- pair style, properties, walls --------------------------------------------------------------------------

    def command_pair_style(self, statement: Statement) -> None:
        self.last = statement
        if not statement.words[1:] or unaccelerated(statement.words[1]) != "gran":
            raise refused(statement, "be pair_style gran model NAME")
        self.model, self.granular = None, True
        if self.understood(statement, lambda: granular_words.gran_model(statement, statement.words[2:])):
            self.model = (self.words(statement, statement.words[2:]), statement.quote)

    def command_pair_coeff(self, statement: Statement) -> None:
        self.last = statement

    def command_coarsegraining(self, statement: Statement) -> None:
        self.coarse = self.number(statement, (*statement.words, "")[1])
        self.ignore("coarse graining: radii are those of the coarse grains", statement)

    def words(self, statement: Statement, words: Sequence[str]) -> Settings:
        """The settings of a model; what is special about it is noted."""
        parsed = granular_words.gran_model(statement, words)
        for what in parsed.beside:
            self.ignore(what, statement)
        for name, known in liggghts_friction.KNOWN_WORDS.items():
            kind = parsed.settings.get(name, known)[0]
            if kind not in known:
                self.unknown[replace(statement.quote, part=f"{name} {kind}")] = None
        return self.resolve(statement, settings(statement, parsed.settings))

    def own_fix(self, fix: Fix) -> bool:
        """Properties, walls, meshes, templates and insertions."""
        readers: dict[str, Callable[[Fix], None]] = {
            "property/global": self.property,
            "wall/gran": self.read_wall,
            "particletemplate/sphere": self.template,
            clumps.STYLE: self.clump,
            "particledistribution/discrete": self.distribution,
            "insert": self.insert,
            "mesh/surface": self.mesh,
            "move/mesh": self.moving_mesh,
            "pour": self.pour,
        }
        for style, read in readers.items():
            if fix.style.startswith(style):
                contacts = style in ("property/global", "wall/gran", "mesh/surface")
                if not self.understood(fix.statement, lambda read=read: read(fix), contacts):  # type: ignore[misc]
                    self.forget(fix)
                self.last = fix.statement
                return True
        return False

    def forget(self, fix: Fix) -> None:
        """Drop a fix that was not understood."""
        self.fixes = {name: other for name, other in self.fixes.items() if other is not fix}
        if fix.style.startswith(("particle", "insert", "pour")):
            self.population.from_elsewhere()

    def property(self, fix: Fix) -> None:
        """A property of types or of pairs of types. A later one replaces an earlier one of the same name."""
        name, kind, *values = (*fix.words, "", "")
        if kind not in PROPERTIES:
            return
        words = [word for word in values if word]
        if words[-2:-1] == ["every"]:
            words = words[:-2]
        if name in OF_CONTACT:
            words = [
                word if NUMBER.fullmatch(word) else repr(self.number(fix.statement, word)) for word in words
            ]
        elif name in liggghts_friction.PROPERTIES:  # as they are now; they need not be known
            known = [word if NUMBER.fullmatch(word) else self.coefficient(word) for word in words]
            words = [word if value is None else str(value) for word, value in zip(words, known, strict=True)]
        new = Property(fix.statement, kind, tuple(words))
        self.types = max(self.types, min(new.types(), MAX_TYPES))
        self.properties[name] = new

    def mesh(self, fix: Fix) -> None:
        """The material type of a mesh."""
        kind = self.option(fix, "type")
        self.meshes[fix.statement.words[1]] = self.type_of(kind) if kind else 0
        if fix.style.endswith(("servo", "6dof")):
            self.moving_mesh(fix)
        for word in ("surface_vel", "surface_ang_vel"):
            if word in fix.words:
                self.ignore(f"a moving wall ({word})", fix.statement)

    def moving_mesh(self, fix: Fix) -> None:
        """A mesh that moves."""
        self.ignore(f"a moving wall ({fix.style})", fix.statement)

    def pour(self, fix: Fix) -> None:
        """Pouring as before LIGGGHTS 3: ``pour`` and ``pour/legacy``, with ``diam`` and ``dens`` STYLE LO HI."""
        kind = self.type_of((*fix.words, "", "")[1])
        if fix.style not in ("pour", "pour/legacy") or not 1 <= kind <= MAX_TYPES:
            raise refused(fix.statement, "be fix pour/legacy with a type, or fix insert")
        limits: dict[str, Range | None] = {"diam": (1.0, 1.0), "dens": (1.0, 1.0)}
        limits |= self.random(fix, tuple(limits))
        diameters, densities = limits.values()
        radii = None if diameters is None else (0.5 * diameters[0], 0.5 * diameters[1])
        self.population.add(kind, Batch(radii, densities))
        filling.poured(self, fix, kind, self.coefficient(fix.words[0]), filling.alike(radii))

    def random(self, fix: Fix, names: Sequence[str]) -> dict[str, Range | None]:
        """Smallest and largest value after each of these words; None for a distribution without them, quoted."""
        limits: dict[str, Range | None] = {}
        words = fix.words
        for k, name in enumerate(words):
            if name in names:
                style, *rest = (*words[k + 1 :], "")
                if style in ("uniform", "gaussian") and rest[0] in ("number", "mass"):
                    del rest[0]
                if NUMBER.fullmatch(style):  # LO HI
                    style, rest = "uniform", [style, *rest]
                limits[name] = self.ends(fix, style, [word for word in rest if word])
                if limits[name] is None:
                    self.unknown[fix.statement.quote] = None
        if any(ends and not 0.0 < ends[0] <= ends[1] for ends in limits.values()):
            raise refused(fix.statement, "have positive sizes and densities")
        return limits

    def ends(self, fix: Fix, style: str, words: Sequence[str]) -> Range | None:
        """Smallest and largest value of a distribution; LIGGGHTS draws a Gaussian one again beyond 3σ."""
        count = {"constant": 1, "uniform": 2, "discrete": 2, "gaussian": 2}.get(style)
        if count is None:
            return None
        if len(words) < count:
            raise refused(fix.statement, f"have {count} number{'s' * (count > 1)} after {style}")
        first, last = (self.number(fix.statement, word) for word in (words[0], words[count - 1]))
        return (first - 3.0 * last, first + 3.0 * last) if style == "gaussian" else (first, last)

    def option(self, fix: Fix, name: str) -> str:
        """The word after a keyword of a fix; empty if it is missing."""
        words = (*fix.words, "")
        return words[words.index(name) + 1] if name in words[:-1] else ""

    def parsed_wall(self, fix: Fix) -> tuple[Words, list[int]]:
        """The words of a wall and the types of its material."""
        parsed = granular_words.gran_model(fix.statement, fix.words)
        rest = parsed.rest
        if "primitive" in rest:
            kind = self.type_of(self.option(fix, "type"))
            if not kind:
                raise refused(fix.statement, "have a type")
            return parsed, [kind]
        if "mesh" not in rest or "meshes" not in rest:
            raise refused(fix.statement, "have primitive or mesh n_meshes N meshes NAME …")
        count = self.option(fix, "n_meshes")
        at = rest.index("meshes") + 1
        names = rest[at : at + (int(count) if count.isdecimal() and len(count) < 5 else 0)]
        return parsed, sorted({self.meshes[name] for name in names if self.meshes.get(name)})

    def read_wall(self, fix: Fix) -> None:
        """Check a wall, and note what is special about it."""
        self.granular = True
        parsed, kinds = self.parsed_wall(fix)
        self.words(fix.statement, fix.words)
        if not kinds:
            raise refused(fix.statement, "name meshes with a type")
        if any(word.endswith("cylinder") for word in parsed.rest):
            self.ignore("curvature of a wall, which is taken as a plane", fix.statement)
        if "shear" in parsed.rest:
            self.ignore("a moving wall (shear)", fix.statement)

    def contacts(self) -> Iterator[ContactSettings]:
        """Pairs of types, then walls; cohesion whose constants are 0 is left out."""
        return map(sticky, self.all_contacts())

    def all_contacts(self) -> Iterator[ContactSettings]:
        """The contacts with their settings as given."""
        kinds = self.present()
        if self.model is not None:
            model, quote = self.model
            for i in kinds:
                for j in kinds[kinds.index(i) :]:
                    numbers, quotes = self.between(i, j)
                    yield ContactSettings(
                        (str(i), str(j)),
                        None,
                        {**model, **numbers, **self.rolling(model, i, j)},
                        (quote, *quotes),
                        friction=self.friction(model, i, j),
                        tangential=self.tangential(model, i, j),
                        motion=motion.strongest([motion.of_grains(self, k) for k in (i, j)]),
                    )
        for name, fix in self.fixes.items():
            if fix.style.startswith("wall/gran"):
                parsed, ends = self.parsed_wall(fix)
                model = settings(fix.statement, parsed.settings)
                shapes = [granular_words.pushes(word) for word in parsed.rest]
                pushes = next((shape for shape in shapes if shape is not None), None)
                moves = motion.strongest(
                    [motion.of_mesh(self, word) for word in parsed.rest], gravity.down(self)
                )
                sheds = motion.sheds(self, fix)
                belt = motion.strongest([motion.of_surface(self, word) for word in parsed.rest])
                for kind in kinds:
                    for end in ends:
                        numbers, quotes = self.between(kind, end)
                        wall = name if len(ends) == 1 else f"{name} (type {end})"
                        friction = self.friction(model, kind, end)
                        moving = motion.of_wall(self, parsed.rest, 0, friction != 0.0) or moves
                        moving = moving or (belt if friction != 0.0 else None)
                        contact = self.wall_contact(
                            kind,
                            wall,
                            {**model, **numbers, **self.rolling(model, kind, end)},
                            quotes=(fix.statement.quote, *quotes),
                            pushes=pushes,
                            friction=friction,
                            motion=moving,
                        )
                        yield replace(contact, tangential=self.tangential(model, kind, end), sheds=sheds)

    def note_friction(self, contacts: Sequence[ContactSettings]) -> None:
        """Note what the friction of the contacts really does."""
        for contact in contacts:
            for what in liggghts_friction.remarks(contact):
                self.warn(what, contact)
        for what, same in liggghts_friction.rolling_remarks(contacts):
            for contact in same:
                self.warn(what, contact)

    def inertia_factor(self, kind: int) -> float:
        """Disks in two dimensions; infinite if only fixes that leave spins alone move the grains."""
        own = self.integrators_of(kind)
        if own and all(fix.style in SPINLESS for fix in own):
            return math.inf
        return DISK if self.dimension == 2 else SPHERE

    def friction(self, model: Settings, i: int, j: int) -> float | None:
        """The coefficient of friction of two types; 0 if the model has no tangential forces."""
        if liggghts_friction.word(model, "tangential") == "off":
            return 0.0
        return liggghts_friction.first(self.values("coefficientFriction", i, j))

    def tangential(self, model: Settings, i: int, j: int) -> Tangential | None:
        """The tangential force between two types."""
        return liggghts_friction.tangential(model, lambda name: self.values(name, i, j))

    def values(self, name: str, i: int, j: int) -> tuple[float, float] | None:
        """The values of a property of two types; None if one of them is not known."""
        source = self.properties.get(name)
        pair = None if source is None else source.between(i, j)
        first, second = map(self.coefficient, pair or ("", ""))
        return None if first is None or second is None else (first, second)

    def rolling(self, model: Settings, i: int, j: int) -> Settings:
        """The properties of rolling friction of two types, if the model has it and they are known."""
        if liggghts_friction.word(model, "rolling_friction") == "off":
            return {}
        return {
            name: self.properties[name].setting(repr(pair[0]))
            for name in liggghts_friction.ROLLING_PROPERTIES
            if (pair := self.values(name, i, j)) is not None
        }

    def between(self, i: int, j: int) -> tuple[Settings, tuple[Quote, ...]]:
        """The properties of a pair of types. Two materials are replaced by one with the same effective modulus."""
        settings: Settings = {}
        quotes: dict[Quote, None] = {}
        values: dict[str, tuple[str, str]] = {}
        for name in OF_CONTACT:
            source = self.properties.get(name)
            pair = None if source is None else source.between(i, j)
            if source is not None and pair is not None:
                values[name] = pair
                settings[name] = source.setting(pair[0])
                quotes[source.statement.quote] = None
        moduli, ratios = values.get("youngsModulus"), values.get("poissonsRatio")
        if moduli and ratios and not (same_word(*moduli) and same_word(*ratios)):
            modulus, ratio = one_material(
                *((float(y), float(nu)) for y, nu in zip(moduli, ratios, strict=True))
            )
            settings["youngsModulus"] = replace(settings["youngsModulus"], words=(repr(modulus),))
            settings["poissonsRatio"] = replace(settings["poissonsRatio"], words=(repr(ratio),))
        return settings, tuple(quotes)

    # --- templates and insertions -------------------------------------------------------------------------------

    def template(self, fix: Fix) -> None:
        """Radius and density of a particle template."""
        kind = self.type_of(self.option(fix, "atom_type") or "1")
        limits = self.random(fix, ("radius", "density"))
        radii = limits.get("radius")
        if not 1 <= kind <= MAX_TYPES:
            raise refused(fix.statement, "have a type")
        if radii is not None:
            radii = (radii[0] * self.coarse, radii[1] * self.coarse)
        self.templates[fix.statement.words[1]] = (kind, Batch(radii, limits.get("density")))

    def clump(self, fix: Fix) -> None:
        """A template of clumps: their type and density, and the radius of the sphere of the same volume."""
        self.other_fix(fix)
        kind = self.type_of(self.option(fix, "atom_type") or "1")
        if not 1 <= kind <= MAX_TYPES:
            raise refused(fix.statement, "have a type")
        densities = self.random(fix, ("density",)).get("density")
        try:
            radius, half_extent = self.radii_of_clump(fix)
        except ValueError:
            self.quote_with(fix.statement, "the spheres of the clump are not known")
            self.templates[fix.statement.words[1]] = (kind, Batch(None, densities))
            return
        own = self.coarse * radius
        self.templates[fix.statement.words[1]] = (kind, Batch((own, own), densities))
        what = "clumps count as spheres of their volume and mass"
        if half_extent > clumps.ROUND * radius:
            what += ", although they are not round: speeds under shear and t_c ν are rough estimates"
        self.warnings[Note(what, (str(kind),), fix.statement.quote)] = None

    def radii_of_clump(self, fix: Fix) -> tuple[float, float]:
        """From the spheres of a template; if they are not there, from the log of the script beside it."""
        try:
            return clumps.radii(fix.words, self.folder)
        except ValueError:
            if self.folder is None or not self.log_name:
                raise
            printed = clumps.radii_in_log(fix.statement.words, self.folder / self.log_name)
        what = f"the sizes of clumps are those that {self.log_name} prints"
        self.warnings[Note(what, None, fix.statement.quote)] = None
        return printed

    def distribution(self, fix: Fix) -> None:
        """The templates of a distribution, and their shares; those without grains are left out."""
        name = fix.statement.words[1]
        pairs = [
            (word, self.coefficient(share)) for word, share in zip(*[iter(fix.words[2:])] * 2, strict=False)
        ]
        present = [pair for pair in pairs if pair[1] != 0.0] or pairs
        self.distributions[name] = [word for word, _ in present]
        self.shares[name] = [share for _, share in present]
        if fix.style.endswith("numberbased"):
            self.by_number.add(name)

    def insert(self, fix: Fix) -> None:
        """Insertion of a distribution."""
        if fix.style == "insert/pack/face":
            self.refine(fix)
            return
        name = self.option(fix, "distributiontemplate")
        templates = [self.templates.get(template) for template in self.distributions.get(name, [])]
        if not templates or None in templates:
            raise refused(fix.statement, "have a distribution of spheres")
        for template in templates:
            if template is not None:
                self.population.add(*template)
        known = [template for template in templates if template is not None]
        sizes = {template.radii for _, template in known}
        dense = {template.densities for _, template in known}
        filling.inserted(
            self,
            fix,
            known[0][0],
            sizes.pop() if len(sizes) == 1 else None,
            dense.pop() if len(dense) == 1 else None,
        )
        if fix.style.startswith("insert/stream"):
            filling.streamed(self, fix, self.volume_rate(fix, name, [each for _, each in known]))
        lot = self.filling.census.lots[-1]
        if len(known) > 1 and lot.number and (shares := self.numbers(name, [each for _, each in known])):
            means = [filling.alike(template.radii) for _, template in known]
            pairs = zip(known, shares, means, strict=True)
            self.filling.census.lots[-1:] = [
                census.lot(kind, share * lot.number, mean) for (kind, _), share, mean in pairs
            ]

    def refine(self, fix: Fix) -> None:
        """``insert/pack/face``: grains of another type and coarse-graining level for those that cross a face."""
        face = self.fixes.get(self.option(fix, "massflow_face"))
        level = self.coefficient(self.option(fix, "cg"))
        coarse = None if face is None else self.coefficient(self.option(face, "cg"))
        offset = self.coefficient(self.option(fix, "type_offset") or "0")
        if not level or not coarse or offset is None or not self.population.batches:
            raise refused(fix.statement, "name a face with a cg level that grains cross")
        batches = self.population.batches
        crossing = [kind for kind in batches if self.levels.get(kind) == coarse]
        for kind in crossing or [kind for kind in batches if kind not in self.levels]:
            fine = kind + int(offset)
            self.levels[fine] = level
            for batch in list(batches[kind]):
                low, high = batch.radii or (math.nan, math.nan)
                own = None if batch.radii is None else (level / coarse * low, level / coarse * high)
                self.population.add(fine, replace(batch, radii=own))
            filling.poured(self, fix, fine, None, None)

    def volume_rate(self, fix: Fix, name: str, templates: Sequence[Batch]) -> float | None:
        """Volume of grains that a stream makes per time; None if it is not known."""
        rate, mass_rate = (self.coefficient(self.option(fix, word)) for word in ("particlerate", "massrate"))
        densities = {template.densities for template in templates}
        dense = densities.pop() if len(densities) == 1 else None
        if mass_rate is not None and dense is not None and dense[0] == dense[1]:
            return mass_rate / dense[0]
        means = [filling.alike(template.radii) for template in templates]
        shares = self.numbers(name, templates) if len(templates) > 1 else [1.0]
        cubes = [mean[1] for mean in means if mean is not None]
        if rate is None or len(cubes) < len(means) or not shares:
            return None
        return rate * 4.0 / 3.0 * math.pi * math.fsum(a * b for a, b in zip(shares, cubes, strict=True))

    def numbers(self, name: str, templates: Sequence[Batch]) -> list[float]:
        """Shares of the number of grains of the templates of a distribution; empty if not known."""
        shares = self.shares[name]
        if name not in self.by_number:
            return numbers(templates, shares)
        known = [share for share in shares if share is not None and share > 0.0]
        return [share / math.fsum(known) for share in known] if len(known) == len(templates) else []

    def changed(self, keyword: str, value: float | None) -> Callable[[Batch], Batch]:
        """What a keyword of ``set`` does to grains. In LIGGGHTS, another diameter keeps the density."""
        if keyword == "diameter":
            radius = None if value is None else 0.5 * value * self.coarse
            return lambda batch: batch.with_radius(radius)
        return super().changed(keyword, value)


def numbers(templates: Sequence[Batch], masses: Sequence[float | None]) -> list[float]:
    """Shares of the number of grains of templates of one size each from those of the mass; empty if not known."""
    shares = []
    for template, mass in zip(templates, masses, strict=False):
        radii, densities = template.radii, template.densities
        if not mass or radii is None or densities is None or len({*radii}) + len({*densities}) > 2:
            return []
        shares.append(mass / (radii[0] ** 3 * densities[0]))
    return [share / math.fsum(shares) for share in shares] if len(shares) == len(templates) else []
