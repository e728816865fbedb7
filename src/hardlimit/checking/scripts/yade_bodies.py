"""Calls of a YADE script that make bodies: spheres, walls, packings, files of spheres."""

from __future__ import annotations

import ast
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from .description import Range
from .population import union
from .python import Evaluator, Instance, Unknown, flat
from .reader import names
from .statements import refusal
from .yade_clumps import (
    LATTICES,
    LEFT,
    TIED,
    Clumped,
    is_discretized,
    of_ends,
    of_lattice,
    of_packs,
    of_templates,
)
from .yade_container import Ends, vector
from .yade_container import union as around
from .yade_extents import (
    Centre,
    Drawn,
    around_ball,
    ends_of_facets,
    ends_of_rows,
    shifted,
    span,
    triangles_of,
)
from .yade_filling import (
    DENSITIES,
    TEXTS,
    cloud,
    ends_of,
    is_overfull,
    lot_of,
    mean_radius,
    obstacle,
    packed,
    spheres_in,
    uniform,
)
from .yade_lattices import centres
from .yade_scene import UNCOUNTED, Body, Scene, as_range

DEFAULT_MATERIAL: Final = {"young": 1e7, "poisson": 0.3, "density": 1000.0, "label": "defaultMat"}
#: Functions that make bodies other than spheres: facets, walls and boxes.
SHAPES: Final = dict.fromkeys(
    names("""
    facet facetBox facetCylinder facetSphere facetCone facetPolygon facetBunker facetHelix facetParallelepiped
    facetTorus stl gts gmsh unv iges gtsSurface2Facets textFacets blockMeshFacets
    """),
    "facets",
) | {"wall": "walls", "box": "boxes", "aabbWalls": "boxes"}
#: Those that make packings.
PACKINGS: Final = names("regularHexa regularOrtho randomDensePack hexaNet filterSpherePack")
#: Functions that make spheres of sizes that are not in the script.
FILES: Final = names("text textExt textClumps gengeo gengeoFile ele load loadTmp")
PACK_FILES: Final = names("load fromFile fromList particleSD particleSD2 particleSD_2d makeOverlappingCloud")
CLUMPS: Final = names("appendClumped makeClumpCloud clump clumpTemplate replaceByClumps polyhedron tetra")
#: Modules whose functions of the same names make no bodies.
READERS: Final = names("export pickle cPickle np numpy json yaml plot pd pandas")
#: Bodies that are no spheres, whose contacts are not read.
OTHER_SHAPES: Final = names("gridNode gridConnection pfacet chainedCylinder levelSetBody lsSimpleShape")
#: Methods of a SpherePack that make spheres, and those that leave them where they are.
MADE: Final = ("makeCloud", "add")
UNMOVED: Final = ("psd", "relDensity", "save", "toFile", "aabb", "dim", "center", "hasClumps", "psdDistrib")


@dataclass
class BodyCalls:
    """Calls that make bodies of a scene."""

    scene: Scene
    script: Evaluator
    folder: Path | None  #: of files of spheres

    def function(self, name: str, owner: Any, instance: Instance) -> bool:
        """A function that makes bodies or packings; False for others."""
        if name == "SpherePack" and instance.arguments and isinstance(instance.arguments[0], list | tuple):
            pairs = [
                entry for entry in instance.arguments[0] if isinstance(entry, tuple | list) and len(entry) > 1
            ]
            instance.made += [as_range(entry[1]) for entry in pairs] or [None]
        if name == "sphere":
            self.sphere(instance)
        elif name in SHAPES:
            self.shape(instance)
        elif name in PACKINGS:
            self.packing(instance)
        elif name in FILES and not (isinstance(owner, str) and owner.partition(".")[0] in READERS):
            self.from_file(instance)
        elif name in CLUMPS or name in OTHER_SHAPES:
            if name != "clumpTemplate":  # which makes no body
                self.clumps(instance)
        else:
            return False
        return True

    def method(self, name: str, instance: Instance) -> Any:
        """Methods of ``O.bodies``. The value is the number of a body, if it is known."""
        scene, quote = self.scene, self.scene.at(instance)
        if name in ("clear", "replace"):
            if self.script.repeats:
                scene.unknown[quote] = None
            else:
                scene.remove_bodies()
        if name in ("append", "appendClumped", "replace", "insertAtId"):
            before = len(scene.bodies)
            self.append(instance, clumped=name == "appendClumped")
            new = range(before, len(scene.bodies))
            if name == "append" and new and scene.body_at(new[-1]):
                several = isinstance(instance.argument(0, "bodies"), list | tuple)
                return list(new) if several else new[-1]
        elif name == "replaceByClumps":
            self.replaced(instance)
        elif name in CLUMPS or "lump" in name:
            self.clumps(instance, self.tied(name, instance))
        elif name == "erase":
            scene.filling.census.complete = False
            scene.ignore("bodies that are removed (O.bodies.erase)", quote)
        elif name not in ("clear", "getRoundness"):
            scene.unknown[quote] = None
        return Unknown(instance.text)

    def append(self, instance: Instance, clumped: bool) -> None:
        """``O.bodies.append``: bodies, lists of them, or packings."""
        scene, parts = self.scene, flat([*instance.arguments, *instance.attributes.values()])
        if parts and all(isinstance(part, Instance) and part.name in SHAPES for part in parts):
            scene.filling.container.walls_only.add(instance.text)
        for part in parts:
            elements = part.made if isinstance(part, Instance) else []
            bodies = [body for body in elements if isinstance(body, Body)]
            spheres = [body for body in bodies if body.kind == "sphere"]
            scene.bodies += bodies
            scene.filling.census.lots += [body.lot for body in spheres]
            scene.filling.fixed += [body.lot for body in spheres if body.frozen]
            scene.filling.container.spheres += [body.ends for body in spheres if not body.frozen]
            if isinstance(part, Instance) and not spheres and part.name not in LATTICES:
                walls = scene.filling.container.appended.setdefault(instance.text, [])
                walls.append(ends_of_facets(part, self.folder))
            scene.filling.container.fix([body.ends for body in spheres if body.frozen])
            scene.filling.container.unsure += [body.ends for body in spheres if body.unsure]
            if clumped and isinstance(part, Instance):
                own = of_lattice(part) if part.name != "sphere" else self.clumped(instance)
                self.clumps(replace(part, name="appendClumped"), own)
            other = isinstance(part, Instance) and part.name in (*CLUMPS, *OTHER_SHAPES, *LATTICES)
            if isinstance(part, Unknown | Instance) and not bodies and not other:
                scene.elsewhere = True
                if not (isinstance(part, Instance) and part.name in FILES):
                    scene.unknown[scene.at(instance)] = None

    def material_of(self, instance: Instance, place: int = -1) -> int:
        """The material of a body: given by number, label or instance; the last one by default."""
        materials, material = self.scene.materials, instance.argument(place, "material", -1)
        if isinstance(material, Unknown) and material.text in self.script.functions:
            # The function makes the material of each body.
            call = ast.parse(f"{material.text}()", mode="eval").body
            material = self.script.value(ast.copy_location(call, self.script.functions[material.text]))
        if isinstance(material, Instance):
            return self.scene.index(material)
        must = "have a known material"
        if isinstance(material, str):
            labels = [known.attributes.get("label") for known in materials]
            if material in labels:
                return labels.index(material)
            must = f"have a material of the script, not {material}"
        elif not materials:
            self.scene.index(
                Instance("FrictMat", (), dict(DEFAULT_MATERIAL), instance.line, "default material")
            )
        if isinstance(material, int) and -len(materials) <= material < len(materials):
            return material % len(materials)
        if material is None:
            return len(materials) - 1
        raise refusal(instance.line, instance.text, must, self.scene.file)

    def body(self, instance: Instance, kind: str, radii: Range | None, place: int = -1) -> Body:
        fixed, moves = (instance.attributes.get(name) for name in ("fixed", "dynamic"))
        frozen = fixed in (True, 1) or moves in (False, 0)
        material, quote = self.material_of(instance, place), self.scene.at(instance)
        unsure = not all(isinstance(value, bool | int | None) for value in (fixed, moves))
        if unsure:
            self.scene.unknown[quote] = None
        return Body(kind, radii, material, frozen, quote, several=self.script.repeats > 0, unsure=unsure)

    def sphere(self, instance: Instance) -> None:
        """``sphere(center, radius, …)``."""
        radius = drawn(instance.argument(1, "radius"))
        body = self.body(instance, "sphere", radius)
        body.lot = uniform(None if body.several else 1.0, radius)
        body.ends = made_ends(instance)
        instance.made.append(body)
        if (
            body.ends is not None
            and radius is not None
            and not isinstance(instance.argument(0, "center"), Centre)
        ):
            self.place(body, radius)

    def place(self, body: Body, radius: Range) -> None:
        """Where the centre of a sphere that falls is made."""
        if body.ends is not None and not body.frozen:
            low, high = (shifted(body.ends, (sign * radius[1],) * 3) for sign in (1.0, -1.0))
            assert low is not None and high is not None
            self.scene.filling.places.append((low[0], high[1], radius[0]))

    def shape(self, instance: Instance) -> None:
        """Facets, walls and boxes."""
        body = self.body(instance, SHAPES[instance.name], None)
        body.several |= instance.name not in ("facet", "wall", "box")
        body.frozen |= instance.name != "box"
        obstacle(self.scene.filling, instance)
        reach, mesh = ends_of_facets(instance, self.folder), triangles_of(instance, self.folder)
        self.scene.filling.container.add(instance, reach, mesh)
        self.scene.filling.container.known &= body.frozen  # a box that moves may lie on the grains
        if instance.name == "box":
            half = instance.argument(1, "extents")
            if isinstance(half, list | tuple) and len(half) == 3 and all(as_range(x) or x == 0 for x in half):
                density = self.scene.number(self.scene.materials[body.material], "density")
                body.mass = 8.0 * math.prod(half) * density
        instance.made.append(body)

    def packing(self, instance: Instance) -> None:
        """Regular and random packings: ``(predicate, radius, …, rRelFuzz=)``."""
        source = instance.argument(1, "spherePack") if instance.name == "filterSpherePack" else None
        if isinstance(source, Instance):
            sizes = [size for size in source.made if not isinstance(size, Body)]
        else:
            place = 0 if instance.name == "hexaNet" else 1
            sizes = [fuzzy(instance.argument(place, "radius"), instance.attributes.get("rRelFuzz", 0.0))]
        container = self.scene.filling.container
        container.packed = max(container.packed, packed(instance))
        if instance.attributes.get("returnSpherePack") is True:
            instance.attributes["ends"] = [ends_of(instance)]
            instance.name = "SpherePack"
            instance.made += sizes
        else:
            place = 2 if instance.name == "randomDensePack" else -1
            spheres = [self.body(instance, "sphere", size, place) for size in sizes]
            if instance.name in LATTICES and (places := centres(instance)) is not None:
                instance.made += self.of_lattice(spheres[0], places)
                return
            filled = instance.name in LATTICES
            instance.made += [
                replace(sphere, several=True, ends=ends_of(instance), filled=filled) for sphere in spheres
            ]

    def of_lattice(self, sphere: Body, places: np.ndarray) -> list[Body]:
        """The spheres of a lattice at these places, if there are any."""
        if not len(places) or sphere.radii is None:
            return []
        number = None if self.script.repeats else float(len(places))
        low, high = ends_of_rows(places)
        radius = sphere.radii[1]
        ends = tuple(x - radius for x in low), tuple(x + radius for x in high)
        lot = uniform(number, sphere.radii)
        return [replace(sphere, several=True, ends=ends, filled=True, lot=lot)]

    def pack_method(self, name: str, pack: Instance, instance: Instance) -> None:
        """Methods of a SpherePack."""
        lots, before = pack.attributes.setdefault("lots", []), len(pack.made)
        number = cloud(self.scene.filling, pack, instance) if name == "makeCloud" else 1.0
        self.place_pack(name, pack, instance)
        if name == "makeCloud":
            pack.made.append(cloud_radii(instance))
        elif name == "add":
            pack.made.append(as_range(instance.argument(1, "radius")))
        elif name in ("load", "fromFile") and (listed := spheres_in(self.folder, instance, True)):
            radii, ends = listed
            pack.made.append((min(radii), max(radii)))
            lots.append(lot_of(radii))
            self.listed(pack.attributes["ends"], ends)
        elif name in PACK_FILES:
            pack.made.append(None)
        elif name == "makeClumpCloud":
            templates = flat([instance.argument(2, "clumps")])
            self.clumps(instance, of_packs(templates, False))
            sizes = [size for each in templates if isinstance(each, Instance) for size in each.made]
            pack.made.append(union(sizes))
        elif name == "toSimulation":
            self.to_simulation(pack, instance)
        elif name == "scale":
            lots[:] = [UNCOUNTED] * len(lots)
            factor = as_range(instance.argument(0, "scaleFactor"))
            pack.made = [
                None if size is None or factor is None else (factor[0] * size[0], factor[0] * size[1])
                for size in pack.made
            ]
        elif name == "toList":
            instance.name, instance.made = "SpherePack", pack.made
        if len(pack.made) == before + 1 and name in MADE and not self.script.repeats:
            mean = mean_radius(instance) if name == "makeCloud" else None
            counted = instance.argument(7, "psdSizes") is None and (mean is None or mean[0] == mean[1])
            lots.append(uniform(number, pack.made[-1]) if counted else UNCOUNTED)
        elif len(lots) < len(pack.made):
            lots.append(UNCOUNTED)

    def place_pack(self, name: str, pack: Instance, instance: Instance) -> None:
        """Where the spheres of a SpherePack are after one of its methods."""
        ends = pack.attributes.setdefault("ends", [])
        by = vector(instance.argument(0, "vector")) if name == "translate" else None
        if name in (*MADE, "makeClumpCloud"):
            ends.append(ends_of(instance, "add" if name == "add" else "makeCloud"))
        elif by is not None:
            ends[:] = [shifted(each, by) for each in ends]
        elif name == "rotate" and None not in ends and ends:
            ends[:] = [around_ball(around(ends))]
        elif name not in ("toSimulation", "toList", *UNMOVED):
            ends.append(None)

    def listed(self, places: list[Ends | None], ends: Ends | None) -> None:
        """Spheres of a file are between these ends, and may be packed."""
        container = self.scene.filling.container
        places[-1:] = [ends]
        container.packed = max(container.packed, DENSITIES["randomDensePack"])

    def to_simulation(self, pack: Instance, instance: Instance) -> None:
        """The spheres of a SpherePack become bodies."""
        sizes = list(dict.fromkeys(pack.made)) or [None]
        spheres = [self.body(instance, "sphere", size) for size in sizes]
        filling, lots = self.scene.filling, pack.attributes["lots"]
        self.scene.bodies += [replace(sphere, several=True) for sphere in spheres]
        filling.census.lots += lots if self.script.repeats == 0 and lots else [UNCOUNTED]
        filling.container.spheres += pack.attributes.get("ends", [None])
        if "cell" in pack.attributes:
            filling.cell, filling.periodic = pack.attributes["cell"], True

    def from_file(self, instance: Instance) -> None:
        """Spheres whose sizes are not in the script: in a text beside it, or not known."""
        scene = self.scene
        listed = spheres_in(self.folder, instance, False) if instance.name in TEXTS else None
        if listed is not None:
            radii, ends = listed
            body = self.body(instance, "sphere", (min(radii), max(radii)))
            body.several, body.lot = True, UNCOUNTED if self.script.repeats else lot_of(radii)
            places: list[Ends | None] = [None]
            self.listed(places, ends)
            (body.ends,) = places
            instance.made.append(body)
            return
        scene.elsewhere = True
        scene.filling.census.complete = scene.filling.known = False
        scene.unknown[scene.at(instance)] = None

    def clumps(self, instance: Instance, own: Clumped | None = None) -> None:
        """Clumps of these sizes, or shapes of unknown ones."""
        filling = self.scene.filling
        filling.container.known &= own is not None
        filling.clumped = (filling.clumped or Clumped()).with_(own or Clumped(unknown=True))
        self.scene.counted = min(self.scene.counted, len(self.scene.bodies))  # a clump has a number as well
        what = f"clumps or shapes that are no spheres ({instance.name})"
        self.scene.invalidate(what, self.scene.at(instance))

    def clumped(self, call: Instance) -> Clumped | None:
        """The clump of the single spheres that a call appends; None if they are not known."""
        parts = [part for part in flat([*call.arguments]) if isinstance(part, Instance)]
        bodies = [body for part in parts for body in part.made if isinstance(body, Body)]
        single = bodies and all(body.kind == "sphere" and not body.several for body in bodies)
        return of_ends([body.ends for body in bodies], is_discretized(call)) if single else None

    def tied(self, name: str, call: Instance) -> Clumped | None:
        """The clump that a method of ``O.bodies`` makes; of all spheres if it is not known of which."""
        if name in LEFT:
            return Clumped()
        spheres = [body for body in self.scene.bodies if body.kind == "sphere"]
        if name not in TIED or self.scene.elsewhere or any(sphere.several for sphere in spheres):
            return None
        numbers = call.argument(0, "ids")
        known = [*map(self.scene.body_at, numbers)] if isinstance(numbers, list | tuple) else []
        chosen = [body for each in known if (body := body_of(each)) is not None]
        if name == "addToClump" or not chosen or len(chosen) < len(known):
            chosen = spheres
        return of_ends([sphere.ends for sphere in chosen], is_discretized(call))

    def replaced(self, call: Instance) -> None:
        """``replaceByClumps``: spheres become clumps of the same volume, which reach farther."""
        filling, own = self.scene.filling, of_templates(call)
        radii = union([body.radii for body in self.scene.bodies if body.kind == "sphere"])
        if own is not None and radii is not None and not self.scene.elsewhere:
            lots, farther = filling.census.lots, max(own.reach - 1.0, 0.0) * radii[1]
            filling.container.farther = max(filling.container.farther, farther)
            lots[:] = [lot._replace(cubes=lot.cubes and own.heavier * lot.cubes) for lot in lots]
            self.clumps(call, own)
        else:
            self.clumps(call)


def body_of(value: Any) -> Body | None:
    """The body of ``sphere(…)``, ``wall(…)`` or ``O.bodies[…]``; None for anything else."""
    bodies = value.made if isinstance(value, Instance) else []
    return (
        bodies[0] if len(bodies) == 1 and isinstance(bodies[0], Body) and value.name != "SpherePack" else None
    )


def spheres_of(pack: Instance) -> list[tuple[Centre, Any]]:
    """Centres and radii that stand for all spheres of a SpherePack: the smallest and the largest of each size."""
    centre = Centre("a centre", tuple(pack.attributes.get("ends", [None])))
    sizes = list(dict.fromkeys(size for size in pack.made if not isinstance(size, Body))) or [None]
    ends = [(None, None) if size is None else size for size in sizes]
    return [(centre, Unknown("a radius") if r is None else r) for end in ends for r in end]


def made_ends(instance: Instance) -> Ends | None:
    """Between which ends a sphere is made, or all spheres of the SpherePack over which a loop runs."""
    centre = instance.argument(0, "center")
    if not isinstance(centre, Centre):
        return ends_of(instance)
    known = [ends for ends in centre.ends if ends is not None]
    return around(known) if known and len(known) == len(centre.ends) else None


def cloud_radii(instance: Instance) -> Range | None:
    """The smallest and largest radius of ``makeCloud``."""
    sizes = instance.argument(7, "psdSizes")
    if isinstance(sizes, list | tuple) and sizes and "num" not in instance.attributes:
        diameters = union([as_range(size) for size in sizes])
        return None if diameters is None else (0.5 * diameters[0], 0.5 * diameters[1])
    if sizes:
        return None  # YADE may scale the sizes down
    mean, fuzz = mean_radius(instance), instance.argument(3, "rRelFuzz", 0.0)
    if mean is None or (fuzz != 0 and is_overfull(instance)):
        return None
    return union([fuzzy(end, fuzz) for end in mean])


def drawn(value: Any) -> Range | None:
    """A known positive number, or the ends of one that is drawn at random."""
    ends = span(value) if isinstance(value, Drawn) else None
    return union([as_range(end) for end in ends]) if ends is not None else as_range(value)


def fuzzy(mean: Any, fuzz: Any) -> Range | None:
    """Radii around a mean with a relative half-width."""
    known = as_range(mean)
    if known is None or isinstance(fuzz, bool) or not isinstance(fuzz, int | float) or not 0.0 <= fuzz < 1.0:
        return None
    return known[0] * (1.0 - fuzz), known[0] * (1.0 + fuzz)
