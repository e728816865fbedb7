"""The contacts of a YADE scene: which grains and walls meet, and the settings of their normal force."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Final

from .description import ContactSettings, Note, Quote, Setting, Settings
from .materials import one_material
from .python import Instance
from .yade_friction import LINEAR_LAW, SMOOTH_LAW, tangential_of, warnings
from .yade_numbers import Contact, entries
from .yade_scene import MATERIALS, OF_VISCOELASTIC, Scene

#: Functors that create contacts, with the material that they need.
PHYSICS: Final = {
    "Ip2_FrictMat_FrictMat_MindlinPhys": "FrictMat",
    "Ip2_FrictMat_FrictMat_FrictPhys": "FrictMat",
    OF_VISCOELASTIC: "ViscElMat",
    "Ip2_CohFrictMat_CohFrictMat_CohFrictPhys": "CohFrictMat",
}
#: Physics whose normal force is that of another.
LIKE: Final = {"CohFrictPhys": "FrictPhys"}
#: Laws that leave out the damping of MindlinPhys.
UNDAMPED_LAWS: Final = (LINEAR_LAW, SMOOTH_LAW)
#: Shapes in the names of functors.
SHAPE_NAMES: Final = {"sphere": "Sphere", "facets": "Facet", "walls": "Wall", "boxes": "Box"}
#: Radius of a body over that of the sphere that it touches: 1e8 with ``hertzian=True``.
SIZES: Final = {"facets": 2.0, "walls": 1.0, "boxes": 1.0}

#: What ``lubrication`` of ViscElMat does to a contact.
LUBRICATED: Final = "a fluid between grains (lubrication)"
#: Poisson's ratio of an incompressible material.
LARGEST_RATIO: Final = 0.5

#: Numbers of a contact with the objects that give them.
Numbers = dict[str, tuple[float, Instance]]


class Contacts:
    """The contacts that a scene has now."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.functors = functors(scene)
        self.kinds, self.grains = scene.kinds(), scene.grains()

    def settings(self) -> Iterator[ContactSettings]:
        """Pairs of materials, then walls, without damping if the law leaves it out."""
        laws = self.scene.used("Law2_ScGeom_MindlinPhys_")
        undamped = [law for law in laws if law.name in UNDAMPED_LAWS]
        for contact in (*self.of_grains(), *self.with_walls()):
            settings = contact.settings
            if undamped and settings["physics"].words[0] == "MindlinPhys":
                law, en = undamped[-1], settings.get("en")
                kept = {name: setting for name, setting in settings.items() if name not in ("en", "betan")}
                zero = Setting(("0.0",), law.line, law.text)
                restitution = None if en is None else float(en.words[0])
                contact = replace(contact, settings={**kept, "betan": zero}, asked=restitution)
            yield contact

    def of_grains(self) -> Iterator[ContactSettings]:
        """Pairs of materials whose grains meet."""
        name = self.scene.name
        for k, i in enumerate(self.kinds if self.touching("sphere") is not None else []):
            first = self.grains[name(i)]
            for j in self.kinds[k:]:
                fixed = first.frozen and self.grains[name(j)].frozen
                if fixed or (i == j and first.alone and not first.partly_frozen):
                    continue
                contact = self.between(i, j)
                if contact is not None and (force := normal_force(contact)):
                    yield with_friction(contact, ContactSettings(contact.types, None, *force))

    def with_walls(self) -> Iterator[ContactSettings]:
        """Grains that move, with walls, or in a part of a script without walls with ``wall`` of each material."""
        scene, name = self.scene, self.scene.name
        bodies = [body for body in scene.bodies if body.kind != "sphere"]
        walls = {(body.kind, body.material, body.mass): body.quote for body in bodies}
        assumed = scene.part and not walls
        for k in self.kinds if assumed else ():
            walls["walls", k, None] = scene.at(scene.materials[k])
        several = len({material for _, material, _ in walls}) > 1
        for i in (k for k in self.kinds if not self.grains[name(k)].frozen):
            for (kind, j, mass), quote in walls.items():
                size = self.touching(kind)
                contact = None if size is None else self.between(i, j, size, kind)
                if size is None or contact is None or (force := normal_force(contact)) is None:
                    continue
                counted = contact.physics == "ViscElPhys" and "en" in force[0] and kind == "boxes"
                if counted and mass is None:
                    scene.unknown[quote] = None  # its mass is in the formulas
                    continue
                label = name(j) if assumed else f"{kind} of {name(j)}" if several else kind
                larger = 2.0 if math.isinf(size) else 2.0 * size / (1.0 + size)
                # YADE takes a body without mass to have that of the sphere.
                formula_mass = (mass or None) if counted else None
                settings = ContactSettings(contact.types, label, *force, formula_mass, larger)
                yield with_friction(contact, settings)

    def touching(self, kind: str) -> float | None:
        """The size of bodies of this kind over that of a sphere in YADE's formulas; None if they touch no sphere."""
        scene, shape, size = self.scene, SHAPE_NAMES[kind], SIZES.get(kind, 1.0)
        meet = scene.used(f"Ig2_{shape}_Sphere_")
        seen = [*scene.used(f"Bo1_{shape}_Aabb"), *scene.used("FlatGridCollider")]
        if not (scene.apart or (meet and seen)):
            missing = f"Bo1_{shape}_Aabb" if meet else f"Ig2_{shape}_Sphere_…"
            what = f"{kind if kind in SIZES else 'spheres'} without contacts: no {missing}"
            scene.ignore(what, scene.engines_quote)
            return None
        for functor in meet:
            hertzian = functor.attributes.get("hertzian", False)
            if isinstance(hertzian, bool | int):
                size = math.inf if hertzian else size
            else:
                scene.unknown[scene.at(functor)] = None
        return size

    def between(self, i: int, j: int, wall: float | None = None, kind: str = "") -> Contact | None:
        """The contact of two materials, with its functor; None if there is no functor, or no law for it.

        ``wall`` is the size of a wall of the second material over that of the sphere.
        """
        scene = self.scene
        names = {scene.materials[k].name for k in (i, j)}
        functor = self.functors.get(scene.materials[i].name) if len(names) == 1 else None
        if functor is None and names <= MATERIALS.keys():
            functor = self.functors.get("FrictMat")  # the others are FrictMat as well
        if functor is None:
            return None
        contact = Contact(scene, functor, (i, j), wall, kind)
        if functor.name.startswith("Ip2_FrictMat") and 0.0 in contact.both("young"):
            scene.ignore("contacts without a force (young=0)", scene.at(functor))
            return None
        if (scene.used("Law2_") or not scene.apart) and not contact.laws:
            scene.unknown[scene.quote(functor.line, f"{functor.text} without its law")] = None
            return None
        return contact


def functors(scene: Scene) -> dict[str, Instance]:
    """The functors that make contacts, by the material that they read."""
    known = {PHYSICS[functor.name]: functor for functor in scene.used("Ip2_") if functor.name in PHYSICS}
    if scene.bare and scene.apart and not known:  # only one functor reads this material
        materials = scene.used("ViscElMat")[:1]
        return {material.name: replace(material, name=OF_VISCOELASTIC) for material in materials}
    return known


def sources(contact: Contact) -> list[Quote]:
    """The statements that a contact comes from."""
    return [contact.scene.at(source) for source in (*contact.pair, contact.functor)]


def with_friction(contact: Contact, settings: ContactSettings) -> ContactSettings:
    """With the coefficient of friction and the tangential force; None and quoted if they are not known."""
    scene = contact.scene
    friction, tangential = tangential_of(contact)
    scene.warnings |= dict.fromkeys(warnings(contact, tangential))
    locked = [body.locked for body in scene.spheres() if body.material in contact.ends]
    quotes = [quote for quote in (*locked, scene.locked) if quote is not None]
    if friction != 0.0 and (tangential is None or quotes):
        scene.unknown |= dict.fromkeys(quotes or sources(contact))
        tangential = None
    return replace(settings, friction=friction, tangential=tangential)


def normal_force(contact: Contact) -> tuple[Settings, tuple[Quote, ...]] | None:
    """The settings of a normal force with their quotes; None if they are not known, or if it is no spring."""
    scene, functor = contact.scene, contact.functor
    what = no_spring(contact)
    if what:
        scene.invalidates[Note(what, contact.types, scene.at(functor))] = None
        return None
    values = numbers(contact)
    if values is None:
        of_materials = functor.attributes.keys().isdisjoint(("en", "betan", "tc", "kn"))
        missing = contact.pair if of_materials else (functor,)
        scene.unknown.update(dict.fromkeys(scene.at(source) for source in missing))
        return None
    physics = LIKE.get(contact.physics, contact.physics)
    settings = {"physics": Setting((physics,), functor.line, functor.text)}
    for name, (value, source) in values.items():
        settings[name] = Setting((repr(value),), source.line, source.text)
    return settings, tuple(dict.fromkeys(sources(contact)))


def no_spring(contact: Contact) -> str:
    """Why a contact is none of a spring and a dashpot; empty if it is one."""
    functor, pair = contact.functor, contact.pair
    if contact.physics == "ViscElPhys" and all(each.attributes.get("SPHmode", False) for each in pair):
        return "smoothed-particle hydrodynamics (SPHmode)"
    if contact.physics == "ViscElPhys" and any(each.attributes.get("lubrication", False) for each in pair):
        return LUBRICATED  # ε changes with the speed
    if contact.physics != "CohFrictPhys":
        return ""
    bonds = [functor.attributes.get(name, False) for name in ("setCohesionNow", "setCohesionOnNewContacts")]
    cohesive = [material.attributes.get("isCohesive", True) for material in pair]
    cohesion = functor.attributes.get("normalCohesion")
    if isinstance(cohesion, Instance):
        cohesion = cohesion.attributes.get("val") if not list(entries(cohesion)) else 1.0
    of_pair = [material.attributes.get("normalCohesion", -1.0) for material in pair]
    strengths = of_pair if cohesion is None else [cohesion]
    positive = all(not isinstance(x, int | float) or x > 0.0 for x in strengths)
    return f"adhesion or bonds ({functor.name})" if any(bonds) and all(cohesive) and positive else ""


def numbers(contact: Contact) -> Numbers | None:
    """Numbers of a contact; None if one material cannot replace the two."""
    functor, material = contact.functor, contact.pair[0]
    if contact.physics == "ViscElPhys":
        return viscoelastic(contact)
    young = contact.both("young")
    if contact.physics.endswith("FrictPhys"):
        if "kn" in functor.attributes:
            return None  # a stiffness instead of the modulus
        mean = contact.mean_modulus(young)
        return None if mean is None else {"young": (mean, material)}
    first, second = zip(young, contact.both("poisson"), strict=True)
    modulus, ratio = first if first == second else one_material(first, second)
    if LARGEST_RATIO < ratio < 1.0:  # of no material: the modulus that makes the same spring, E/(1 − ν²)
        what = f"Poisson's ratio {ratio:g} is that of no material (at most {LARGEST_RATIO:g}), YADE's springs have it"
        contact.scene.warnings[Note(what, None, contact.scene.at(material))] = None
        modulus *= (1.0 - LARGEST_RATIO**2) / (1.0 - ratio**2)
        ratio = LARGEST_RATIO
    values = {"young": (modulus, material), "poisson": (ratio, material)}
    alone = "es" if "es" in functor.attributes else "en"  # which YADE takes for en if that is not given
    for name in ("en", "betan"):
        word = alone if name == "en" and "en" not in functor.attributes else name
        if word in functor.attributes:
            value = contact.matched(word)
            if value is None:
                return None
            values[name] = (value, functor)
    if "en" not in values and "betan" not in values:
        values["betan"] = (0.0, functor)
    return values


def viscoelastic(contact: Contact) -> Numbers | None:
    """ViscElMat: tc, en and et; or kn, cn, ks and cs; or Young's modulus and en. None if YADE refuses them.

    Of two materials, tc and en are means, and springs and dashpots are in series.
    """
    values: dict[str, float | None] = {}
    if contact.has_duration:
        values = {name: contact.mean(name) for name in ("tc", "en")}
    elif contact.have("kn", "cn", "ks", "cs"):
        values = {name: contact.in_series(name) for name in ("kn", "cn")}
    elif contact.have("en") or contact.have("cn", "cs"):
        values["young"] = contact.mean_modulus(contact.both("young"))
        if contact.have("cn", "cs"):
            values["cn"] = contact.in_series("cn")
        else:
            values["en"] = contact.mean("en")
    of_functor = {"tc", "en"} & contact.functor.attributes.keys()
    known = {
        name: (value, contact.functor if name in of_functor else contact.pair[0])
        for name, value in values.items()
        if value is not None
    }
    return known if known and len(known) == len(values) else None
