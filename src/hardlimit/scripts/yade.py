"""Materials, contacts, bodies and engines of a YADE script, which is Python. Nothing in it is executed."""

from __future__ import annotations

import ast
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

from .description import (
    WALL,
    ContactSettings,
    Description,
    Direction,
    Grains,
    Motion,
    Note,
    Quote,
    Range,
    Setting,
    Settings,
    Stage,
)
from .formulas import NUMBER
from .materials import one_material
from .motion import STEADY, UNKNOWN, strongest
from .population import union
from .python import Evaluator, Instance, Unknown, flat
from .statements import quoted, refusal

DEFAULT_TIME_STEP: Final = 1e-8  #: of a scene
NUMERICAL_DAMPING: Final = 0.2  #: NewtonIntegrator's default
#: A facet counts as a sphere of twice the radius, other walls as one of the same radius: 2/3 R over 1/2 R.
FACET_RADIUS: Final = 4.0 / 3.0
#: Materials that are read, with the defaults of their numbers.
MATERIALS: Final[dict[str, dict[str, float]]] = {
    "FrictMat": {"young": 1e9, "poisson": 0.25, "density": 1000.0},
    "ViscElMat": {"young": 1e9, "poisson": 0.25, "density": 1000.0},
}
FRICTION_ANGLE: Final = 0.5  #: default of these materials
DEFAULT_MATERIAL: Final = {"young": 1e7, "poisson": 0.3, "density": 1000.0, "label": "defaultMat"}
#: Functors that create contacts, with the material that they need.
PHYSICS: Final = {
    "Ip2_FrictMat_FrictMat_MindlinPhys": "FrictMat",
    "Ip2_FrictMat_FrictMat_FrictPhys": "FrictMat",
    "Ip2_ViscElMat_ViscElMat_ViscElPhys": "ViscElMat",
}
LAWS: Final = (
    "Law2_ScGeom_MindlinPhys_Mindlin",
    "Law2_ScGeom_FrictPhys_CundallStrack",
    "Law2_ScGeom_ViscElPhys_Basic",
)
#: Laws that leave out the damping of MindlinPhys.
UNDAMPED_LAWS: Final = (
    "Law2_ScGeom_MindlinPhys_HertzWithLinearShear",
    "Law2_ScGeom_MindlinPhys_MindlinDeresiewitz",
)
STICKY_PARTS: Final = "Coh JCFpm Cpm Wire Cap Luding Mortar Bubble Lubrication CDM Bshd"
STICKY: Final = tuple(STICKY_PARTS.split())
#: What adds forces beside contacts.
FORCES: Final = {
    "Drag": "drag",
    "Hydro": "drag of a fluid",
    "Flow": "a fluid",
    "Buoyancy": "buoyancy",
    "Capillarity": "capillary bridges",
    "Thermal": "heat",
    "Radial": "a radial force",
    "Interpolating": "an additional force",
    "ForceEngine": "an additional force",
    "Centrifugal": "an additional force",
}
MOTION_NAMES: Final = """
TranslationEngine RotationEngine HelixEngine HarmonicMotionEngine HarmonicRotationEngine BicyclePedalEngine
StepDisplacer ServoPIDController TriaxialStressController TriaxialCompressionEngine PeriTriaxController
PeriIsoCompressor Peri3dController CombinedKinematicEngine UniaxialStrainer KinemCTDEngine KinemSimpleShearBox
"""
MOTION: Final = frozenset(MOTION_NAMES.split())
#: Those that prescribe a stress or a strain of all grains.
PRESSING_NAMES: Final = """
TriaxialStressController TriaxialCompressionEngine PeriTriaxController PeriIsoCompressor Peri3dController
UniaxialStrainer ServoPIDController KinemCTDEngine KinemSimpleShearBox
"""
PRESSING: Final = frozenset(PRESSING_NAMES.split())
#: Those that move walls or grains steadily.
STEADY_MOTION: Final = ("TranslationEngine", "RotationEngine", "HelixEngine")
#: Amplitude and frequency of ``HarmonicMotionEngine``, with their defaults.
HARMONIC: Final = (("A", (0.0, 0.0, 0.0)), ("f", (0.0, 0.0, 0.0)))
#: Engines that change neither contacts nor grains.
ENGINE_NAMES: Final = """
ForceResetter InsertionSortCollider SpatialQuickSortCollider FlatGridCollider InteractionLoop NewtonIntegrator PyRunner
PeriodicPythonRunner PeriodicEngine DomainLimiter SnapshotEngine BoxFactory CircularFactory GravityEngine
GlobalStiffnessTimeStepper ResetRandomPosition IntrCallback ParallelEngine BoundDispatcher
"""
ENGINES: Final = frozenset(ENGINE_NAMES.split())
#: Functions that make bodies other than spheres: facets, walls and boxes.
SHAPES: Final = {
    "facet": "facets",
    **dict.fromkeys(
        ("facetBox", "facetCylinder", "facetSphere", "facetCone", "facetPolygon", "facetBunker"), "facets"
    ),
    **dict.fromkeys(
        ("facetHelix", "facetParallelepiped", "facetTorus", "stl", "gts", "gmsh", "unv", "iges"), "facets"
    ),
    "gtsSurface2Facets": "facets",
    "wall": "walls",
    "box": "boxes",
    "aabbWalls": "boxes",
}
#: Functions that make spheres of sizes that are not in the script.
FILES: Final = ("text", "textExt", "textClumps", "gengeo", "gengeoFile", "ele", "load", "loadTmp")
PACK_FILES: Final = (
    "load",
    "fromFile",
    "fromList",
    "particleSD",
    "particleSD2",
    "particleSD_2d",
    "makeOverlappingCloud",
)
CLUMPS: Final = (
    "appendClumped",
    "makeClumpCloud",
    "clump",
    "clumpTemplate",
    "replaceByClumps",
    "polyhedron",
    "tetra",
)
#: Attributes that change contacts or grains while the script runs.
CHANGING: Final = (
    "young",
    "poisson",
    "en",
    "betan",
    "kn",
    "cn",
    "tc",
    "damping",
    "radius",
    "mass",
    "mat",
    "material",
)


@dataclass(frozen=True)
class Body:
    """Spheres of one call, or a wall."""

    kind: str  #: "sphere", or what the wall is made of
    radii: Range | None
    material: int
    frozen: bool
    quote: Quote
    mass: float | None = None  #: of a box; None for other bodies, and if it is not known


class Yade(Evaluator):
    """A script of YADE."""

    def __init__(self, text: str, file: str = "", variables: Mapping[str, str] = {}) -> None:
        self.given = {
            name: float(word) if NUMBER.fullmatch(word) else word for name, word in variables.items()
        }
        super().__init__(text, file, dict(self.given))
        self.materials: list[Instance] = []
        self.bodies: list[Body] = []
        self.engines: list[Any] = []
        self.table: dict[str, Any] = {}
        self.time_step: float | None = None
        self.time_step_given = self.elsewhere = False
        self.strain: tuple[Any, Quote] | None = None  #: of the periodic cell, as velGrad
        self.stages: list[Stage] = []
        self.ignored: dict[Note, None] = {}
        self.invalidates: dict[Note, None] = {}
        self.unknown: dict[Quote, None] = {}

    def quote(self, line: int, text: str) -> Quote:
        return quoted(self.file, line, text)

    # --- what the script does -----------------------------------------------------------------------------------

    def assign(self, target: ast.expr, value: Any, node: ast.AST) -> None:
        """Names of the command line keep their values."""
        if not (isinstance(target, ast.Name) and target.id in self.given and self.depth == 0):
            super().assign(target, value, node)

    def forget(self, node: ast.AST) -> None:
        super().forget(node)
        self.names |= self.given

    def member(self, owner: Any, name: str, node: ast.Attribute) -> Any:
        if is_scene(owner):
            if name == "materials":
                return self.materials
            if name == "engines":
                return self.engines
            if name == "dt" and self.time_step is not None:
                return self.time_step
        if owner in ("table", "params.table", "yade.params.table") and name in self.table:
            return self.table[name]
        if isinstance(owner, Instance) and name in MATERIALS.get(owner.name, {}):
            return owner.attributes.get(name, MATERIALS[owner.name][name])
        return super().member(owner, name, node)

    def item(self, held: Any, place: ast.expr, node: ast.expr) -> Any:
        if held is self.materials:
            key = self.value(place)
            named = [
                one for one in self.materials if isinstance(key, str) and one.attributes.get("label") == key
            ]
            if named:
                return named[0]
        return super().item(held, place, node)

    def statement(self, node: ast.stmt) -> None:
        if isinstance(node, ast.ImportFrom) and (node.module or "").endswith("params.table"):
            self.names |= {name: one for name, one in self.table.items() if name not in self.given}
        super().statement(node)

    def assigned(self, owner: Any, name: str, value: Any, node: ast.AST) -> None:
        line, text = getattr(node, "lineno", 1), ast.unparse(node)
        if is_scene(owner) and name == "dt":
            self.time_step_given = True
            known = isinstance(value, int | float) and not isinstance(value, bool) and 0.0 < value < math.inf
            self.time_step = float(value) if known else None
            if not known:
                self.unknown[self.quote(line, text)] = None
        elif is_scene(owner) and name == "engines":
            self.engines = [one for one in flat([value]) if isinstance(one, Instance)]
            self.label(self.engines)
        elif name == "velGrad":
            self.strain = value, self.quote(line, text)
        elif isinstance(owner, Instance):
            owner.attributes[name] = value
        elif name in CHANGING:
            self.unknown[self.quote(line, text)] = None
        super().assigned(owner, name, value, node)

    def label(self, instances: Iterable[Any]) -> None:
        """Labels of engines and functors are names in the script."""
        for one in instances:
            if isinstance(one, Instance):
                name = one.attributes.get("label")
                if isinstance(name, str):
                    self.names[name] = one
                self.label(flat(one.arguments))

    def called(self, name: str, owner: Any, instance: Instance) -> Any:
        super().called(name, owner, instance)
        if isinstance(owner, list):
            return self.list_method(name, owner, instance)
        if is_scene(owner):
            return self.scene_method(name, instance)
        if owner in ("O.bodies", "yade.O.bodies"):
            if name in ("append", "appendClumped"):
                self.append(instance.arguments, clumped=name == "appendClumped")
            elif name in CLUMPS:
                self.clumps(instance)
            return Unknown(instance.text)
        if name == "sphere":
            self.sphere(instance)
        elif name in SHAPES:
            self.shape(instance)
        elif name in ("regularHexa", "regularOrtho", "randomDensePack", "hexaNet", "filterSpherePack"):
            self.packing(instance)
        elif isinstance(owner, Instance) and owner.name == "SpherePack":
            self.pack_method(name, owner, instance)
        elif name in FILES and owner != "export":
            self.from_file(instance)
        elif name in CLUMPS:
            self.clumps(instance)
        elif name in ("PWaveTimeStep", "RayleighWaveTimeStep"):
            step = self.wave_time(rayleigh=name.startswith("R"))
            return Unknown(instance.text) if step is None else step
        elif name == "readParamsFromTable":
            plain = {
                key: one for key, one in instance.attributes.items() if key not in ("noTableOk", "unknownOk")
            }
            self.table |= {**plain, **{key: one for key, one in self.given.items() if key in plain}}
        return instance

    def list_method(self, name: str, owner: list[Any], instance: Instance) -> Any:
        """Methods of lists, and of ``O.materials`` and ``O.engines``."""
        arguments = instance.arguments
        if owner is self.materials and name == "append":
            added = [one for one in flat(arguments) if isinstance(one, Instance)]
            indices = [self.index(one) for one in added]
            return indices[0] if len(indices) == 1 and not isinstance(arguments[0], list) else indices
        if name == "append" and arguments:
            owner.append(arguments[0])
        elif name == "extend" and arguments and isinstance(arguments[0], list | tuple):
            owner.extend(arguments[0])
        elif name == "insert" and len(arguments) == 2 and isinstance(arguments[0], int):
            owner.insert(*arguments)
        else:
            return Unknown(instance.text)
        if owner is self.engines:
            self.label(arguments)
        return None

    def scene_method(self, name: str, instance: Instance) -> Any:
        """Methods of ``O``."""
        if name in ("run", "step"):
            steps = instance.argument(0, "steps", -1) if name == "run" else 1
            count = int(steps) if isinstance(steps, int | float) and 0 <= steps < 1e18 else None
            self.stage(self.quote(instance.line, instance.text), count)
        elif name in ("load", "loadTmp"):
            self.from_file(instance)
        return Unknown(instance.text)

    # --- bodies -------------------------------------------------------------------------------------------------

    def index(self, material: Instance) -> int:
        """The number of a material, which is added to ``O.materials`` if it is new."""
        for k, one in enumerate(self.materials):
            if one is material:
                return k
        self.materials.append(material)
        return len(self.materials) - 1

    def material_of(self, instance: Instance, place: int = -1) -> int:
        """The material of a body: given by number, label or instance; the last one by default."""
        given = instance.argument(place, "material", -1)
        if isinstance(given, Instance):
            return self.index(given)
        if isinstance(given, str):
            labels = [one.attributes.get("label") for one in self.materials]
            if given in labels:
                return labels.index(given)
            raise refusal(
                instance.line, instance.text, f"have a material of the script, not {given}", self.file
            )
        if not self.materials:
            self.index(Instance("FrictMat", (), dict(DEFAULT_MATERIAL), instance.line, "default material"))
        if isinstance(given, int) and -len(self.materials) <= given < len(self.materials):
            return given % len(self.materials)
        if given is None:
            return len(self.materials) - 1
        raise refusal(instance.line, instance.text, "have a known material", self.file)

    def body(self, instance: Instance, kind: str, radii: Range | None, place: int = -1) -> Body:
        moves = instance.attributes.get("dynamic")
        frozen = bool(instance.attributes.get("fixed") is True or moves is False)
        material = self.material_of(instance, place)
        return Body(kind, radii, material, frozen, self.quote(instance.line, instance.text))

    def sphere(self, instance: Instance) -> None:
        """``sphere(center, radius, …)``."""
        radius = instance.argument(1, "radius")
        instance.made.append(self.body(instance, "sphere", as_range(radius)))

    def shape(self, instance: Instance) -> None:
        """Facets, walls and boxes."""
        found = self.body(instance, SHAPES[instance.name], None)
        if instance.name == "box":
            if not found.frozen:
                self.unknown[found.quote] = None  # it moves
            half = instance.argument(1, "extents")
            if isinstance(half, list | tuple) and len(half) == 3 and all(map(as_range, half)):
                density = self.number(self.materials[found.material], "density")
                found = replace(found, mass=8.0 * math.prod(half) * density)
        instance.made.append(found)

    def packing(self, instance: Instance) -> None:
        """Regular and random packings: ``(predicate, radius, …, rRelFuzz=)``."""
        source = instance.argument(1, "spherePack") if instance.name == "filterSpherePack" else None
        if isinstance(source, Instance):
            sizes = [one for one in source.made if not isinstance(one, Body)]
        else:
            place = 0 if instance.name == "hexaNet" else 1
            sizes = [fuzzy(instance.argument(place, "radius"), instance.attributes.get("rRelFuzz", 0.0))]
        if instance.attributes.get("returnSpherePack") is True:
            instance.name = "SpherePack"
            instance.made += sizes
        else:
            place = 2 if instance.name == "randomDensePack" else -1
            instance.made += [self.body(instance, "sphere", one, place) for one in sizes]

    def pack_method(self, name: str, pack: Instance, instance: Instance) -> None:
        """Methods of a SpherePack."""
        if name == "makeCloud":
            sizes = instance.argument(7, "psdSizes")
            if isinstance(sizes, list | tuple) and sizes and "num" not in instance.attributes:
                radii = union([as_range(one) for one in sizes])
                pack.made.append(None if radii is None else (0.5 * radii[0], 0.5 * radii[1]))
            elif sizes:
                pack.made.append(None)  # YADE may scale the sizes down
            else:
                pack.made.append(fuzzy(instance.argument(2, "rMean"), instance.argument(3, "rRelFuzz", 0.0)))
        elif name == "add":
            pack.made.append(as_range(instance.argument(1, "radius")))
        elif name in PACK_FILES:
            pack.made.append(None)
        elif name == "makeClumpCloud":
            self.clumps(instance)
            pack.made.append(None)
        elif name == "toSimulation":
            sizes = list(dict.fromkeys(pack.made)) or [None]
            self.bodies += [self.body(instance, "sphere", one) for one in sizes]

    def append(self, arguments: tuple[Any, ...], clumped: bool) -> None:
        """``O.bodies.append``: bodies, lists of them, or packings."""
        for one in flat(arguments):
            if isinstance(one, Instance):
                self.bodies += [body for body in one.made if isinstance(body, Body)]
                if clumped:
                    self.clumps(replace(one, name="appendClumped"))
            elif isinstance(one, Unknown):
                self.elsewhere = True

    def from_file(self, instance: Instance) -> None:
        """Spheres whose sizes are not in the script."""
        self.elsewhere = True
        self.unknown[self.quote(instance.line, instance.text)] = None

    def clumps(self, instance: Instance) -> None:
        note = Note(
            f"clumps or shapes that are no spheres ({instance.name})",
            None,
            self.quote(instance.line, instance.text),
        )
        self.invalidates[note] = None

    def wave_time(self, rayleigh: bool) -> float | None:
        """Time in which a wave crosses the smallest sphere; None if sizes are not known."""
        times = []
        for body in self.bodies:
            if body.kind == "sphere":
                material = self.materials[body.material]
                young, poisson, density = (
                    self.number(material, name) for name in ("young", "poisson", "density")
                )
                if body.radii is None:
                    return None
                if rayleigh:
                    shear = young / (2.0 * (1.0 + poisson))
                    time = (
                        math.pi * body.radii[0] / (0.1631 * poisson + 0.876605) * math.sqrt(density / shear)
                    )
                else:
                    time = body.radii[0] * math.sqrt(density / young)
                times.append(time)
        return min(times) if times and not self.elsewhere else None

    # --- what holds at a run ------------------------------------------------------------------------------------

    def number(self, instance: Instance, name: str) -> float:
        """A number of a material, or its default."""
        default = MATERIALS.get(instance.name, {"density": 1000.0}).get(name)
        found = instance.attributes.get(name, instance.attributes.get("**", default))
        if isinstance(found, bool) or not isinstance(found, int | float) or not math.isfinite(found):
            said = found.text if isinstance(found, Unknown) else found
            raise refusal(
                instance.line, instance.text, f"have a known number for {name}, not {said}", self.file
            )
        return float(found)

    def used(self, start: str) -> list[Instance]:
        """Instances whose name begins so: those of ``O.engines``, or all if there are none."""
        found: list[Instance] = []
        pending: list[Any] = list(self.engines) or list(self.instances)
        while pending:
            one = pending.pop(0)
            if isinstance(one, Instance) and one not in found:
                if one.name.startswith(start):
                    found.append(one)
                pending = [*flat(one.arguments), *flat(one.attributes.values()), *pending]
        return found

    def stage(self, quote: Quote, steps: int | None) -> None:
        """Note what holds now. A run with the same settings as that before continues its stage."""
        integrators = self.used("NewtonIntegrator")
        new = Stage(
            quote,
            self.step_now(),
            self.time_step_given,
            steps,
            tuple(self.contacts()),
            self.grains(),
            self.gravity(integrators),
            self.damping(integrators),
            self.down(integrators),
            *self.driven(),
        )
        if self.stages and replace(self.stages[-1], quote=quote, steps=steps) == new:
            old = self.stages[-1].steps
            both = None if steps is None or old is None else old + steps
            self.stages[-1] = replace(self.stages[-1], steps=both)
        else:
            self.stages.append(new)

    def step_now(self) -> float | None:
        """The time step; None if it is not known or an engine changes it."""
        if any(is_active(one) for one in self.used("GlobalStiffnessTimeStepper")):
            return None
        return self.time_step if self.time_step_given else DEFAULT_TIME_STEP

    def damping(self, integrators: list[Instance]) -> float | None:
        if not integrators:
            return None
        found = integrators[-1].argument(0, "damping", NUMERICAL_DAMPING)
        if not isinstance(found, int | float) or not 0.0 <= found < 1.0:
            one = integrators[-1]
            raise refusal(one.line, one.text, "have a number in [0, 1) for damping", self.file)
        return float(found)

    def gravity(self, integrators: list[Instance]) -> float | None:
        for one in [*integrators, *self.used("GravityEngine")]:
            found = one.attributes.get("gravity")
            if isinstance(found, tuple | list) and all(isinstance(x, int | float) for x in found):
                size = math.hypot(*found)
                return size or None
            if found is not None:
                self.unknown[self.quote(one.line, one.text)] = None
        return None

    def down(self, integrators: list[Instance]) -> Direction | None:
        """The direction of gravity."""
        for one in [*integrators, *self.used("GravityEngine")]:
            found = one.attributes.get("gravity")
            if isinstance(found, tuple | list) and all(isinstance(x, int | float) for x in found):
                size = math.hypot(*found)
                return tuple(x / size for x in found) if size else None
        return None

    def driven(self) -> tuple[tuple[Note, ...], tuple[Note, ...], float | None]:
        """What presses the grains, what else drives them, and the shear rate."""
        pressed = [
            Note(one.name, None, self.quote(one.line, one.text))
            for one in self.used("")
            if one.name in PRESSING
        ]
        if self.strain is None:
            return tuple(pressed), (), None
        value, quote = self.strain
        rates = flat([value.arguments]) if isinstance(value, Instance) else []
        if "Zero" in (value.text if isinstance(value, Unknown) else str(value)):
            return tuple(pressed), (), None  # Matrix3.Zero
        if len(rates) != 9 or not all(isinstance(x, int | float) for x in rates):
            return tuple(pressed), (Note("O.cell.velGrad", None, quote),), None
        sheared = [abs(x) for k, x in enumerate(rates) if k % 4 and x]
        growth, largest = rates[0] + rates[4] + rates[8], max(map(abs, rates))
        if growth < -1e-9 * largest:
            pressed.append(Note("a cell that shrinks (velGrad)", None, quote))
        other = (Note("O.cell.velGrad", None, quote),) if any(rates[::4]) or len(sheared) > 1 else ()
        return tuple(pressed), other, sheared[0] if len(sheared) == 1 and not other else None

    def motion(self) -> Motion | None:
        """The fastest motion of walls and of fixed spheres; which of them move is not read."""
        found: list[Motion | None] = []
        for one in self.used(""):
            if one.name == "HarmonicMotionEngine":
                sizes, rates = (one.attributes.get(name, default) for name, default in HARMONIC)
                vectors = all(
                    isinstance(each, list | tuple) and all(isinstance(x, int | float) for x in each)
                    for each in (sizes, rates)
                )
                waves = [
                    Motion(tuple(a * (k == axis) for k in range(3)), 2.0 * math.pi * f)
                    for axis, (a, f) in enumerate(zip(sizes, rates, strict=False) if vectors else ())
                ]
                found += waves or [UNKNOWN]
            elif one.name in MOTION and one.name not in PRESSING:
                found.append(STEADY if one.name in STEADY_MOTION else UNKNOWN)
        return strongest(found, self.down(self.used("NewtonIntegrator")))

    def name(self, k: int) -> str:
        """The name of a material: its label, or its number."""
        label = self.materials[k].attributes.get("label")
        return label if isinstance(label, str) and label else str(k)

    def spheres(self) -> list[Body]:
        """Spheres of the script, and those that factories will make."""
        found = [one for one in self.bodies if one.kind == "sphere"]
        for one in (*self.used("BoxFactory"), *self.used("CircularFactory")):
            given = one.attributes
            radii = union([as_range(given.get(name)) for name in ("rMin", "rMax")])
            number = given.get("materialId", 0)
            if isinstance(number, int) and 0 <= number < len(self.materials):
                sizes = None if "PSDsizes" in given else radii
                found.append(Body("sphere", sizes, number, False, self.quote(one.line, one.text)))
        return found

    def kinds(self) -> list[int]:
        """Materials of spheres, or all if the script makes none."""
        found = sorted({one.material for one in self.spheres()})
        return list(range(len(self.materials))) if self.elsewhere or not found else found

    def grains(self) -> dict[str, Grains]:
        grains = {}
        for k in self.kinds():
            held = [one for one in self.spheres() if one.material == k]
            radii = None if self.elsewhere else union([one.radii for one in held])
            density = self.number(self.materials[k], "density") if held or self.elsewhere else None
            frozen = bool(held) and not self.elsewhere and all(one.frozen for one in held)
            name, densities = self.name(k), None if density is None else (density, density)
            # ViscElPhys takes the mass of a fixed sphere; MindlinPhys does not.
            counted = self.materials[k].name == "ViscElMat" and any(
                PHYSICS.get(one.name) == "ViscElMat" for one in self.used("Ip2_")
            )
            partly = not frozen and any(one.frozen for one in held)
            grains[name] = Grains(name, radii, densities, None, frozen, counted, partly)
        return grains

    def contacts(self) -> Iterator[ContactSettings]:
        """Pairs of materials, then walls, without damping if the law leaves it out."""
        undamped = [one for one in self.used("Law2_ScGeom_MindlinPhys_") if one.name in UNDAMPED_LAWS]
        moves = self.motion()
        for contact in self.all_contacts():
            settings = contact.settings
            if undamped and settings["physics"].words[0] == "MindlinPhys":
                law, en = undamped[-1], settings.get("en")
                kept = {name: one for name, one in settings.items() if name not in ("en", "betan")}
                zero = Setting(("0.0",), law.line, law.text)
                asked = None if en is None else float(en.words[0])
                contact = replace(contact, settings={**kept, "betan": zero}, asked=asked)
            yield replace(contact, motion=moves)

    def all_contacts(self) -> Iterator[ContactSettings]:
        """The contacts, whose damping is that of the functor."""
        functors = {PHYSICS[one.name]: one for one in self.used("Ip2_") if one.name in PHYSICS}
        kinds = self.kinds()
        for i in kinds:
            for j in kinds[kinds.index(i) :]:
                found = self.between(functors, i, j)
                if found is not None:
                    types, friction = (self.name(i), self.name(j)), self.friction(functors, i, j)
                    yield ContactSettings(types, None, *found, friction=friction)
        walls = {(one.kind, one.material, one.mass): one.quote for one in self.bodies if one.kind != "sphere"}
        several = len({material for _, material, _ in walls}) > 1
        for i in kinds:
            for (kind, j, mass), quote in walls.items():
                found = self.between(functors, i, j)
                if found is None:
                    continue
                words, facets = found[0], kind == "facets"
                physics = words["physics"].words[0]
                counted = physics == "ViscElPhys" and "en" in words and kind == "boxes"
                young = {self.number(self.materials[k], "young") for k in (i, j)}
                if (counted and mass is None) or (facets and physics == "FrictPhys" and len(young) > 1):
                    self.unknown[quote] = None  # its mass and its modulus are in the formulas
                    continue
                name = f"{kind} of {self.name(j)}" if several else kind
                yield ContactSettings(
                    (self.name(i), WALL),
                    name,
                    *found,
                    mass if counted else None,
                    FACET_RADIUS if facets else 1.0,
                    friction=self.friction(functors, i, j),
                )

    def friction(self, functors: Mapping[str, Instance], i: int, j: int) -> float | None:
        """tan of the smaller angle of friction, or of the functor's; None if it is not known."""
        pair = self.materials[i], self.materials[j]
        functor = functors.get("ViscElMat") if {one.name for one in pair} == {"ViscElMat"} else None
        functor = functor or functors.get("FrictMat")
        if functor is not None and "frictAngle" in functor.attributes:
            try:
                angle = self.matched(functor, "frictAngle", (i, j))
            except ValueError:
                angle = None
            return None if angle is None else math.tan(angle)
        angles = [one.attributes.get("frictionAngle", FRICTION_ANGLE) for one in pair]
        known = all(isinstance(one, int | float) and not isinstance(one, bool) for one in angles)
        return math.tan(min(angles)) if known and not any("**" in one.attributes for one in pair) else None

    def between(
        self, functors: Mapping[str, Instance], i: int, j: int
    ) -> tuple[Settings, tuple[Quote, ...]] | None:
        """The settings of two materials; None if no functor makes their contacts."""
        pair = self.materials[i], self.materials[j]
        names = {one.name for one in pair}
        functor = functors.get("ViscElMat") if names == {"ViscElMat"} else None
        if functor is None and names <= MATERIALS.keys():
            functor = functors.get("FrictMat")  # a ViscElMat is a FrictMat
        if functor is None:
            return None
        numbers = self.numbers(functor, pair, (i, j))
        if numbers is None:
            self.unknown.update(dict.fromkeys(self.quote(one.line, one.text) for one in pair))
            return None
        found = {"physics": Setting((functor.name.rpartition("_")[2],), functor.line, functor.text)}
        for name, (value, source) in numbers.items():
            found[name] = Setting((repr(value),), source.line, source.text)
        quotes = dict.fromkeys(self.quote(one.line, one.text) for one in (*pair, functor))
        return found, tuple(quotes)

    def numbers(
        self, functor: Instance, pair: tuple[Instance, Instance], ends: tuple[int, int]
    ) -> dict[str, tuple[float, Instance]] | None:
        """Numbers of a contact with the object that gives them; None if one material cannot replace the two."""
        one = pair[0]
        if functor.name.endswith("ViscElPhys"):
            return self.viscoelastic(functor, pair, ends)
        young = [self.number(each, "young") for each in pair]
        if functor.name.endswith("FrictPhys"):
            mean = self.mean_modulus(young, ends)
            return None if mean is None else {"young": (mean, one)}
        ratios = [self.number(each, "poisson") for each in pair]
        modulus, ratio = young[0], ratios[0]
        if young[0] != young[1] or ratios[0] != ratios[1]:
            modulus, ratio = one_material((young[0], ratios[0]), (young[1], ratios[1]))
        found = {"young": (modulus, one), "poisson": (ratio, one)}
        for name in ("en", "betan"):
            if name in functor.attributes:
                value = self.matched(functor, name, ends)
                if value is None:
                    return None
                found[name] = (value, functor)
        if "en" not in found and "betan" not in found:
            found["betan"] = (0.0, functor)
        return found

    def viscoelastic(
        self, functor: Instance, pair: tuple[Instance, Instance], ends: tuple[int, int]
    ) -> dict[str, tuple[float, Instance]] | None:
        """ViscElMat: means of tc and en, twice the springs and dashpots in series, or Young's modulus."""
        one = pair[0]
        found: dict[str, tuple[float, Instance]] = {}
        for name in ("tc", "en"):
            if name in functor.attributes:
                value = self.matched(functor, name, ends)
                if value is None:
                    return None
                found[name] = (value, functor)
            elif all(name in each.attributes for each in pair):
                found[name] = (0.5 * sum(self.number(each, name) for each in pair), one)
        if "tc" in found and "en" in found:
            return found
        for name in ("kn", "cn"):
            if all(name in each.attributes for each in pair):
                values = [self.number(each, name) for each in pair]
                inverse = sum(1.0 / value for value in values if value)
                found[name] = (values[0] if values[0] == values[1] else 2.0 / inverse, one)
        if "kn" not in found:
            mean = self.mean_modulus([self.number(each, "young") for each in pair], ends)
            if mean is None:
                return None
            found["young"] = (mean, one)
        return found

    def mean_modulus(self, young: list[float], ends: tuple[int, int]) -> float | None:
        """The modulus of two springs 2 Y R in series; None if the sizes differ as well as the moduli."""
        if young[0] == young[1]:
            return young[0]
        sizes = union([one.radii for one in self.spheres() if one.material in ends])
        if sizes is None or sizes[0] != sizes[1]:
            return None
        return 2.0 * young[0] * young[1] / (young[0] + young[1])

    def matched(self, functor: Instance, name: str, ends: tuple[int, int]) -> float | None:
        """A number of a functor: the same for all contacts, or that of a MatchMaker; None if it has none."""
        given = functor.attributes[name]
        if isinstance(given, Instance) and given.name == "MatchMaker":
            for entry in entries(given):
                if sorted(entry[:2]) == sorted(ends):
                    return entry[2]
            given = given.attributes.get("val")
            if given is None:
                return None
        if isinstance(given, bool) or not isinstance(given, int | float):
            raise refusal(functor.line, functor.text, f"have a known number for {name}", self.file)
        return float(given)

    # --- the description ----------------------------------------------------------------------------------------

    def description(self) -> Description:
        """Run the script and describe it."""
        self.run()
        contacts = [one for stage in self.stages for one in stage.contacts]
        if not self.stages or not contacts:
            last = self.instances[-1] if self.instances else None
            self.stage(self.quote(last.line if last else 1, last.text if last else self.text[:80]), None)
        self.notes()
        found = Description(
            "yade",
            None,
            tuple(self.stages),
            tuple(self.ignored),
            tuple(self.invalidates),
            tuple(self.unknown),
        )
        if not any(stage.contacts for stage in found.stages) and not found.invalidates and not found.unknown:
            raise ValueError("script: has no granular contacts")
        return found

    def notes(self) -> None:
        """What is in the engines beside normal contacts."""
        for one in self.used(""):
            quote, name = self.quote(one.line, one.text), one.name
            if name.startswith(("Ip2_", "Law2_")) or (name.endswith("Mat") and name[:1].isupper()):
                self.contact_note(one, quote)
            elif name in MOTION:
                self.ignored[Note(f"prescribed motion ({name})", None, quote)] = None
            elif name.startswith("Ig2_") and one.attributes.get("hertzian"):
                self.unknown[quote] = None  # another radius at facets
            elif name == "GlobalStiffnessTimeStepper" and is_active(one):
                self.ignored[Note("a time step that adapts (GlobalStiffnessTimeStepper)", None, quote)] = None
            elif name == "PyRunner":
                self.runner_note(one, quote)
            elif one in self.engines:
                what = next((what for sign, what in FORCES.items() if sign in name), "")
                if what:
                    self.invalidates[Note(f"{what} ({name})", None, quote)] = None
                elif name not in ENGINES and not name.endswith("Recorder"):
                    self.unknown[quote] = None

    def contact_note(self, one: Instance, quote: Quote) -> None:
        name = one.name
        if any(sign in name for sign in STICKY):
            self.invalidates[Note(f"adhesion or bonds ({name})", None, quote)] = None
        elif name.startswith("Law2_"):
            if name not in (*LAWS, *UNDAMPED_LAWS):
                self.unknown[quote] = None
            elif one.attributes.get("includeAdhesion") not in (None, False, 0):
                self.invalidates[Note("adhesion (includeAdhesion)", None, quote)] = None
            else:
                self.ignored[Note(f"tangential forces ({name})", None, quote)] = None
        elif (name.startswith("Ip2_") and name not in PHYSICS) or (
            name.endswith("Mat") and name not in MATERIALS
        ):
            self.unknown[quote] = None

    def runner_note(self, one: Instance, quote: Quote) -> None:
        """A callback that changes contacts or grains."""
        command = one.argument(0, "command", "")
        if not isinstance(command, str):
            return
        names = [name for name in self.functions if name in command]
        bodies = [ast.unparse(self.functions[name]) for name in names] + [command]
        changed = (*CHANGING, "O.dt", "O.bodies.append", "O.bodies.erase", "O.engines", "O.materials")
        if any(
            f".{name} =" in body or (name.startswith("O.") and name in body)
            for body in bodies
            for name in changed
        ):
            self.unknown[quote] = None


def is_scene(owner: Any) -> bool:
    """Whether something is ``O``."""
    return isinstance(owner, str) and owner in ("O", "yade.O")


def is_active(engine: Instance) -> bool:
    """Whether an engine is neither dead nor inactive."""
    return not engine.attributes.get("dead", False) and bool(engine.attributes.get("active", True))


def as_range(value: Any) -> Range | None:
    """One known positive number as a range."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < math.inf:
        return None
    return float(value), float(value)


def fuzzy(mean: Any, fuzz: Any) -> Range | None:
    """Radii around a mean with a relative half-width."""
    known = as_range(mean)
    if known is None or isinstance(fuzz, bool) or not isinstance(fuzz, int | float) or not 0.0 <= fuzz < 1.0:
        return None
    return known[0] * (1.0 - fuzz), known[0] * (1.0 + fuzz)


def entries(matcher: Instance) -> Iterator[tuple[int, int, float]]:
    """Entries (number, number, value) of a MatchMaker."""
    matches = matcher.argument(0, "matches", ())
    for entry in matches if isinstance(matches, list | tuple) else ():
        numbers = isinstance(entry, list | tuple) and all(isinstance(x, int | float) for x in entry)
        if numbers and len(entry) == 3:
            yield int(entry[0]), int(entry[1]), float(entry[2])


def read(text: str, file: str, variables: Mapping[str, str]) -> Description:
    """Describe a script of YADE."""
    return Yade(text, file, variables).description()
