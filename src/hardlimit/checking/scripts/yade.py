"""Materials, contacts, bodies and engines of a YADE script, which is Python. Nothing in it is executed."""

from __future__ import annotations

import ast
import math
import re
import sys
import textwrap
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

from ...convert.tangential import Tangential
from .description import (
    WALL,
    ContactSettings,
    Contents,
    Description,
    Direction,
    Grains,
    Lot,
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
from .reader import Reader, names
from .statements import quoted, refusal
from .yade_container import Ends, is_number, vector
from .yade_container import union as around
from .yade_filling import (
    TEXTS,
    YadeFilling,
    cloud,
    ends_of,
    lot_of,
    mean_radius,
    obstacle,
    radii_in,
    uniform,
    volume_of,
)
from .yade_friction import FRICTION_ANGLE, Contact, mixed, tangential_of, warnings

DEFAULT_TIME_STEP: Final = 1e-8  #: of a scene
NUMERICAL_DAMPING: Final = 0.2  #: NewtonIntegrator's default
#: Radius of a body over that of the sphere that it touches: 1e8 with ``hertzian=True``.
SIZES: Final = {"facets": 2.0, "walls": 1.0, "boxes": 1.0}
#: The engines of a script that sets none.
DEFAULT_ENGINES: Final = """[
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Facet_Aabb(), Bo1_Box_Aabb()], label='collider'),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom(), Ig2_Facet_Sphere_ScGeom(), Ig2_Box_Sphere_ScGeom()],
        [Ip2_FrictMat_FrictMat_FrictPhys()], [Law2_ScGeom_FrictPhys_CundallStrack()], label='interactionLoop'),
    GlobalStiffnessTimeStepper(timeStepUpdateInterval=10, label='timeStepper'),
    NewtonIntegrator(label='newton'),
]"""
#: Materials that are read, with the defaults of their numbers.
MATERIALS: Final[dict[str, dict[str, float]]] = {
    name: {"young": 1e9, "poisson": 0.25, "density": 1000.0, "frictionAngle": FRICTION_ANGLE}
    for name in ("FrictMat", "ViscElMat", "CohFrictMat")
}
MATERIALS["CohFrictMat"]["normalCohesion"] = -1.0
MATERIALS["ViscElMat"]["mR"] = 0.0
DEFAULT_MATERIAL: Final = {"young": 1e7, "poisson": 0.3, "density": 1000.0, "label": "defaultMat"}
OF_VISCOELASTIC: Final = "Ip2_ViscElMat_ViscElMat_ViscElPhys"
#: Functors that create contacts, with the material that they need.
PHYSICS: Final = {
    "Ip2_FrictMat_FrictMat_MindlinPhys": "FrictMat",
    "Ip2_FrictMat_FrictMat_FrictPhys": "FrictMat",
    OF_VISCOELASTIC: "ViscElMat",
    "Ip2_CohFrictMat_CohFrictMat_CohFrictPhys": "CohFrictMat",
}
#: Attributes of each of these and of the integrator in YADE 2023.02a; others are misspelt, or of another version.
OF_MATERIALS: Final = "young poisson density frictionAngle id label dead ompThreads "
ATTRIBUTES: Final = {
    "FrictMat": OF_MATERIALS,
    "ViscElMat": OF_MATERIALS
    + "tc en et kn cn ks cs mR mRtype lubrication viscoDyn roughnessScale SPHmode mu "
    "KernFunctionPressure KernFunctionVisco",
    "CohFrictMat": OF_MATERIALS
    + "isCohesive alphaKr alphaKtw etaRoll etaTwist normalCohesion shearCohesion fragile momentRotationLaw",
    "Ip2_FrictMat_FrictMat_MindlinPhys": "gamma eta krot ktwist en es betan betas frictAngle label",
    "Ip2_FrictMat_FrictMat_FrictPhys": "kn ks frictAngle label",
    "Ip2_ViscElMat_ViscElMat_ViscElPhys": "tc en et frictAngle label",
    "Ip2_CohFrictMat_CohFrictMat_CohFrictPhys": "setCohesionNow setCohesionOnNewContacts normalCohesion shearCohesion"
    " frictAngle label cohesionDefinitionIteration",
    "NewtonIntegrator": "damping gravity maxVelocitySq exactAsphericalRot prevVelGrad warnNoForceReset kinSplit"
    " dampGravity mask densityScaling label dead ompThreads",
}
LAWS: Final = (
    "Law2_ScGeom_MindlinPhys_Mindlin",
    "Law2_ScGeom_FrictPhys_CundallStrack",
    "Law2_ScGeom_ViscElPhys_Basic",
    "Law2_ScGeom6D_CohFrictPhys_CohesionMoment",
)
#: Physics whose normal force is that of another.
LIKE: Final = {"CohFrictPhys": "FrictPhys"}
#: Laws that leave out the damping of MindlinPhys.
UNDAMPED_LAWS: Final = (
    "Law2_ScGeom_MindlinPhys_HertzWithLinearShear",
    "Law2_ScGeom_MindlinPhys_MindlinDeresiewitz",
)
STICKY: Final = names("Coh JCFpm Cpm Wire Cap Luding Mortar Bubble Lubrication CDM Bshd")
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
#: Engines that prescribe a stress or a strain of all grains.
PRESSING: Final = names("""
TriaxialStressController TriaxialCompressionEngine PeriTriaxController PeriIsoCompressor Peri3dController
ThreeDTriaxialEngine UniaxialStrainer ServoPIDController KinemCTDEngine KinemSimpleShearBox
""")
#: All that move something.
MOTION: Final = PRESSING | names("""
TranslationEngine RotationEngine HelixEngine HarmonicMotionEngine HarmonicRotationEngine BicyclePedalEngine
StepDisplacer CombinedKinematicEngine
""")
#: The stresses of those that prescribe one, and which of them are stresses by default: a bit for each.
PRESSURES: Final = {
    "PeriTriaxController": (("goal",), 0),
    "Peri3dController": (("goal",), 0),
    "TriaxialStressController": (("goal1", "goal2", "goal3"), 7),
    "PeriIsoCompressor": (("stresses",), 0),
    "TriaxialCompressionEngine": (("sigmaIsoCompaction",), 1),
}
#: Those that move walls or grains steadily.
STEADY_MOTION: Final = ("TranslationEngine", "RotationEngine", "HelixEngine")
#: Amplitude and frequency of ``HarmonicMotionEngine``, with their defaults.
HARMONIC: Final = (("A", (0.0, 0.0, 0.0)), ("f", (0.0, 0.0, 0.0)))
#: Engines that change neither contacts nor grains.
ENGINES: Final = names("""
ForceResetter InsertionSortCollider SpatialQuickSortCollider FlatGridCollider InteractionLoop NewtonIntegrator PyRunner
PeriodicPythonRunner PeriodicEngine DomainLimiter SnapshotEngine BoxFactory CircularFactory GravityEngine
GlobalStiffnessTimeStepper ResetRandomPosition IntrCallback ParallelEngine BoundDispatcher
""")
#: Functions that make bodies other than spheres: facets, walls and boxes.
SHAPES: Final = dict.fromkeys(
    names("""
    facet facetBox facetCylinder facetSphere facetCone facetPolygon facetBunker facetHelix facetParallelepiped
    facetTorus stl gts gmsh unv iges gtsSurface2Facets textFacets blockMeshFacets
    """),
    "facets",
) | {"wall": "walls", "box": "boxes", "aabbWalls": "boxes"}
#: Functions that make spheres of sizes that are not in the script.
FILES: Final = names("text textExt textClumps gengeo gengeoFile ele load loadTmp")
PACK_FILES: Final = names("load fromFile fromList particleSD particleSD2 particleSD_2d makeOverlappingCloud")
CLUMPS: Final = names("appendClumped makeClumpCloud clump clumpTemplate replaceByClumps polyhedron tetra")
#: Modules whose functions of the same names make no bodies.
READERS: Final = names("export pickle cPickle np numpy json yaml plot pd pandas")
#: Bodies that are no spheres, whose contacts are not read.
OTHER_SHAPES: Final = names("gridNode gridConnection pfacet chainedCylinder levelSetBody lsSimpleShape")
#: Attributes that change only tangential forces.
TANGENTIAL: Final = names("""
frictionAngle frictAngle tangensOfFrictionAngle et es ks cs betas nonLin krot ktwist eta includeMoment mR mRtype alphaKr
alphaKtw etaRoll etaTwist momentRotationLaw always_use_moment_law inertia
""")
#: Those that change the normal force of contacts.
OF_CONTACTS: Final = names("""
young poisson en betan kn cn tc damping mat material engines isCohesive normalCohesion setCohesionNow
setCohesionOnNewContacts hertzian functors SPHmode
""")
#: Those that change contacts, grains or time steps while the script runs.
CHANGING: Final = (
    OF_CONTACTS
    | TANGENTIAL
    | names("density densityScaling gravity radius mass dynamic blockedDOFs dt active dead")
)
#: Attributes of ``O`` that change neither contacts nor grains.
SCENE_NAMES: Final = names("""
trackEnergy timingEnabled stopAtIter stopAtTime subStepping subStep tags periodic miscParams numThreads speed iter time
""")
#: Methods of ``O`` that change neither contacts nor grains.
SCENE_METHODS: Final = names("""
pause wait resetTime exitNoBacktrace labeledEngine plugins lsTmp isChildClassOf childClassesNonrecursive
disableGdb realtime sceneToString tmpToFile tmpToString
""")
#: Where a script gets names from that cannot change the scene unseen.
KNOWN_MODULES: Final = sys.stdlib_module_names | names("""
yade numpy scipy matplotlib pylab pandas mpi4py minieigen minieigenHP gts vtk past builtins future h5py sklearn tqdm
IPython PyQt4 PyQt5 cPickle ConfigParser Queue StringIO sympy mpmath numba networkx seaborn cv2 PIL plotly meshio
""")
#: The scene and its bodies, by whatever name.
SCENE: Final = Unknown("O")
BODIES: Final = Unknown("O.bodies")
#: Functions that may have the scene or its bodies as an argument and leave it as it is.
PLAIN: Final = names("print len str repr type dir id list isinstance enumerate sorted")
#: Calls that change bodies, or add forces to those of contacts.
FORCE_METHODS: Final = names("addF setPermF addForce addT setPermT addTorque addMove addRot")
TOUCHING: Final = FORCE_METHODS | names(
    "toSimulation growParticles growParticle load loadTmp reload reset setContactFriction"
)
#: Where a script revives a dead engine.
REVIVED: Final = re.compile(r"\.dead\s*=(?!\s*(True|1\b))|setattr")
#: Most bodies that a loop runs over one by one.
MAX_BODIES: Final = 1000
#: Shapes in the names of functors.
SHAPE_NAMES: Final = {"sphere": "Sphere", "facets": "Facet", "walls": "Wall", "boxes": "Box"}
#: Functions that run a text that is not read.
HIDDEN: Final = ("exec", "execfile", "runpy", "run_path", "run_module", "import_module", "__import__")


#: Methods of a SpherePack that make spheres, and those that leave them where they are.
MADE: Final = ("makeCloud", "add")
UNMOVED: Final = ("psd", "relDensity", "save", "toFile", "aabb", "dim", "center", "hasClumps", "psdDistrib")
#: Attributes of states: of walls, they move them.
PLACED: Final = ("vel", "angVel", "pos", "ori", "velGrad", "trsf")


@dataclass(frozen=True)
class Centre(Unknown):
    """A centre of a sphere in a loop over a SpherePack, all of which are between these ends."""

    ends: tuple[Ends | None, ...] = (None,)


#: Spheres of unknown number.
UNCOUNTED: Final = Lot(0)


@dataclass
class Body:
    """Spheres of one call, or a wall."""

    kind: str  #: "sphere", or what the wall is made of
    radii: Range | None
    material: int
    frozen: bool
    quote: Quote
    mass: float | None = None  #: of a box; None for other bodies, and if it is not known
    several: bool = False  #: whether there may be more than one
    locked: Quote | None = None  #: what keeps it from turning as a free or a fixed sphere does
    lot: Lot = UNCOUNTED  #: of spheres: how many, and the sums of their radii
    ends: Ends | None = None  #: of spheres: between which they are made


class Yade(Reader, Evaluator):
    """A script of YADE."""

    code, version = "yade", None

    def __init__(
        self,
        text: str,
        file: str = "",
        variables: Mapping[str, str] = {},
        part: bool = False,
        folder: Path | None = None,
    ) -> None:
        self.folder = folder
        self.filling = YadeFilling()
        self.part = (
            part  #: whether this is a part of a script: at its end, and also at a ``wall`` that it lacks
        )
        self.given = {
            name: float(word) if NUMBER.fullmatch(word) else word for name, word in variables.items()
        }
        super().__init__(text, file, dict(self.given))
        self.names["__name__"] = "__main__"
        self.materials: list[Instance] = []
        self.bodies: list[Body] = []
        self.numbered = 0  #: bodies from the first on whose numbers are known
        self.engines_quote: Quote | None = None
        self.engines_given = False
        self.changed = True  #: whether anything may have changed since the last run
        self.saved: tuple[list[Instance], list[Body], list[Any], bool] | None = None
        self.foreign: set[str] = set()  #: names of modules that are not known
        self.table: dict[str, Any] = {}
        self.time_step: float | None = None
        self.time_step_given = self.elsewhere = False
        self.strain: tuple[Any, Quote] | None = None  #: of the periodic cell, as velGrad
        self.system = 0  #: number of the scene
        self.begin()
        self.locked: Quote | None = None  #: the same of bodies of which it is not known which ones they are
        self.revives = REVIVED.search(text) is not None
        self.engines: list[Any] = self.value(ast.parse(DEFAULT_ENGINES, mode="eval").body)
        self.instances.clear()
        self.label(self.engines)

    def quote(self, line: int, text: str) -> Quote:
        return quoted(self.file, line, text)

    def at(self, source: Instance) -> Quote:
        """The statement that makes something."""
        return self.quote(source.line, source.text)

    def ignore(self, what: str, quote: Quote | None) -> None:
        """Note what leaves head-on collisions as they are."""
        self.ignored[Note(what, None, quote)] = None

    def invalidate(self, what: str, quote: Quote) -> None:
        """Note what makes hard spheres wrong."""
        self.invalidates[Note(what, None, quote)] = None

    # --- what the script does -----------------------------------------------------------------------------------

    def assign(self, target: ast.expr, value: Any, node: ast.AST) -> None:
        """Names of the command line keep their values."""
        if not (isinstance(target, ast.Name) and target.id in self.given and self.depth == 0):
            super().assign(target, value, node)

    def forget(self, node: ast.AST) -> None:
        super().forget(node)
        self.names |= self.given

    def items(self, node: ast.expr) -> list[Any] | None:
        """What an iteration runs over: also the centres and the smallest and largest radius of a SpherePack."""
        iterable = self.value(node)
        if isinstance(iterable, Instance) and iterable.name == "SpherePack":
            self.filling.census.complete = False  # its loop runs over sizes here, not over spheres
            centre = Centre("a centre", tuple(iterable.attributes.get("ends", [None])))
            sizes = list(dict.fromkeys(size for size in iterable.made if not isinstance(size, Body))) or [
                None
            ]
            ends = [(None, None) if size is None else size for size in sizes]
            return [(centre, Unknown("a radius") if r is None else r) for end in ends for r in end]
        if iterable == BODIES:
            known = [self.body_at(k) for k in range(min(len(self.bodies), MAX_BODIES))]
            return None if None in known or len(known) < len(self.bodies) else known
        return super().items(node)

    def compared(self, node: ast.Compare, values: list[Any]) -> Any:
        """A comparison with a value that is not known. A feature that a script asks for is taken to be there."""
        if len(values) == 2 and isinstance(values[1], Unknown) and values[1].text.endswith("features"):
            return isinstance(node.ops[0], ast.In)
        return super().compared(node, values)

    def body_at(self, k: Any) -> Instance | None:
        """A body by its number; None if it is not known which one that is."""
        if not isinstance(k, int) or not -len(self.bodies) <= k < len(self.bodies) or self.elsewhere:
            return None
        while self.numbered < len(self.bodies) and not self.bodies[self.numbered].several:
            self.numbered += 1
        k %= len(self.bodies)
        if k >= self.numbered:
            return None
        body = self.bodies[k]
        return Instance("Body", (), {}, body.quote.line, body.quote.text, [body])

    def imported(self, node: ast.Import | ast.ImportFrom) -> None:
        """An import. A name of a module that is not known may stand for anything."""
        super().imported(node)
        inside = isinstance(node, ast.ImportFrom)
        for alias in node.names:
            root = "." * node.level + (node.module or "") if isinstance(node, ast.ImportFrom) else alias.name
            if root.partition(".")[0] in KNOWN_MODULES:
                continue
            if alias.name == "*":
                self.not_understood(node)
            self.foreign |= {
                alias.asname or alias.name,
                alias.name if inside else alias.name.partition(".")[0],
            }

    def not_understood(self, node: ast.AST, attribute: str = "") -> None:
        """Quote a statement, such as the assignment of an attribute."""
        quote = self.quoted(node)
        self.unknown[quote] = None
        if attribute in OF_CONTACTS:
            self.refuse(quote, "be an attribute of an object of the script, which always has this value")

    def quoted(self, node: ast.AST) -> Quote:
        """The first line of a statement."""
        return self.quote(getattr(node, "lineno", 1), self.source(node).partition("\n")[0])

    def refuse(self, quote: Quote, must: str) -> None:
        """Note a statement on which the force of contacts depends."""
        self.refused[str(refusal(quote.line, quote.text, must, self.file))] = None

    def tried(self, node: ast.Try | ast.TryStar) -> None:
        """``try``; what handles an error may change the scene as well."""
        super().tried(node)
        for handler in node.handlers:
            if any(map(touches, handler.body)):
                self.uncertain(handler, [handler.body])

    def member(self, owner: Any, name: str, node: ast.Attribute) -> Any:
        if name == "O" and isinstance(owner, str):
            return SCENE  # as in yade.O
        if owner == "O":
            if name == "materials":
                return self.materials
            if name == "engines":
                return list(self.engines)  # YADE copies it
            if name == "dt" and (self.time_step is not None or not self.time_step_given):
                return self.time_step or DEFAULT_TIME_STEP
        if owner in ("table", "params.table", "yade.params.table") and name in self.table:
            return self.table[name]
        if isinstance(owner, Instance) and name in MATERIALS.get(owner.name, {}):
            return owner.attributes.get(name, MATERIALS[owner.name][name])
        if isinstance(owner, Instance) and name in ("state", "shape") and body_of(owner):
            return owner
        return super().member(owner, name, node)

    def item(self, container: Any, place: ast.expr, node: ast.expr) -> Any:
        if container is self.materials:
            key = self.value(place)
            named = [
                material
                for material in self.materials
                if isinstance(key, str) and material.attributes.get("label") == key
            ]
            if named:
                return named[0]
        if container == BODIES and (body := self.body_at(self.value(place))) is not None:
            return body
        return super().item(container, place, node)

    def statement(self, node: ast.stmt) -> None:
        if isinstance(node, ast.ImportFrom) and (node.module or "").endswith("params.table"):
            self.names |= {name: value for name, value in self.table.items() if name not in self.given}
        super().statement(node)

    def assigned(self, owner: Any, name: str, value: Any, node: ast.AST) -> None:
        """An attribute. A change that may be made or not, or that is not understood, is quoted."""
        self.changed = True
        if name == "vel":
            self.velocity_assigned(owner, value)
        if owner == "O.cell" and name in ("hSize", "refHSize"):
            self.filling.cell = volume_of(value)
        elif owner == "O.cell":
            self.filling.container.known = False
        body = body_of(owner) if name in PLACED else None
        if name in PLACED and (name == "pos" or body is None or body.kind != "sphere"):
            self.filling.container.known = False
        if owner == "O":
            self.scene_assigned(name, value, node)
        elif owner == "O.cell" and name in ("velGrad", "nextVelGrad"):
            quote = self.quote(getattr(node, "lineno", 1), self.source(node))
            self.strain = value, quote
            self.ignore(f"a box that deforms (O.cell.{name})", quote)
        elif isinstance(owner, Instance):
            body = body_of(owner)
            if body is not None and name in CHANGING:
                if self.repeats or not self.body_assigned(body, name, value, node):
                    self.not_understood(node)
            elif self.repeats and name in CHANGING and owner.attributes.get(name) != value:
                self.not_understood(node, name)
        elif name == "blockedDOFs" and isinstance(value, str) and not fixes(value):
            self.locked = self.locked if turns(value) else self.quoted(node)
        elif name in CHANGING:
            self.not_understood(node, name)
        super().assigned(owner, name, value, node)

    def velocity_assigned(self, owner: Any, value: Any) -> None:
        """The velocity of a body, or of an unknown one."""
        body, velocity = body_of(owner), vector(value)
        if body is None or velocity is None or self.repeats or body.several:
            self.filling.known = False
        else:
            self.filling.velocities[id(body)] = velocity

    def scene_assigned(self, name: str, value: Any, node: ast.AST) -> None:
        """An attribute of ``O``."""
        if name == "periodic":
            self.filling.periodic = value in (True, 1)
        if name == "dt":
            known = isinstance(value, int | float) and not isinstance(value, bool) and 0.0 < value < math.inf
            before, self.time_step = self.time_step, float(value) if known else None
            self.time_step_given = True
            if self.repeats and self.time_step != before:
                self.time_step = None
            if self.time_step is None:
                self.not_understood(node)
        elif name == "engines":
            parts = flat([value])
            engines = [part for part in parts if isinstance(part, Instance)]
            if len(engines) < len(parts) or (self.repeats and engines != self.engines):
                self.not_understood(node, name)
            self.engines, self.engines_given = engines, True
            self.engines_quote = self.quote(getattr(node, "lineno", 1), self.source(node))
            self.label(self.engines)
        elif name in ("dynDt", "usesTimeStepper") and isinstance(value, bool | int):
            for stepper in self.used("GlobalStiffnessTimeStepper"):
                stepper.attributes["active"] = bool(value)
        elif name not in SCENE_NAMES:
            self.not_understood(node)

    def body_assigned(self, body: Body, name: str, value: Any, node: ast.AST) -> bool:
        """An attribute of a body; False if it is not understood."""
        if name == "dynamic" and isinstance(value, bool | int):
            body.frozen = not value
        elif name == "blockedDOFs" and isinstance(value, str):
            body.frozen = fixes(value)
            body.locked = None if turns(value) else self.quoted(node)
        elif name in ("mat", "material") and isinstance(value, Instance):
            body.material = self.index(value)
        else:
            return False
        return True

    def label(self, instances: Iterable[Any]) -> None:
        """Labels of engines and functors are names in the script."""
        for instance in instances:
            if isinstance(instance, Instance):
                name = instance.attributes.get("label")
                if isinstance(name, str):
                    self.names[name] = instance
                self.label(flat(instance.arguments))

    def called(self, name: str, owner: Any, instance: Instance) -> Any:
        super().called(name, owner, instance)
        self.changed |= not (owner == "O" and name in ("run", "step")) and name not in PLAIN
        if isinstance(owner, list):
            return self.list_method(name, owner, instance)
        if owner == "O":
            return self.scene_method(name, instance)
        if owner == "O.bodies":
            return self.bodies_method(name, instance)
        if owner == "O.cell" and name == "setBox":
            self.filling.cell = vector(instance.argument(0, "size")) or vector(instance.arguments)
        if owner == "O.forces" and name in FORCE_METHODS:
            self.invalidate(f"an additional force or displacement (O.forces.{name})", self.at(instance))
            self.filling.container.known = False
        if isinstance(owner, Instance) and owner.name == "SpherePack":
            self.pack_method(name, owner, instance)
            return instance
        if name == "Omega":
            return SCENE
        return self.new_bodies(name, owner, instance)

    def new_bodies(self, name: str, owner: Any, instance: Instance) -> Any:
        """Functions that make bodies or packings, and parameters of a table."""
        if name == "SpherePack" and instance.arguments and isinstance(instance.arguments[0], list | tuple):
            pairs = [
                entry for entry in instance.arguments[0] if isinstance(entry, tuple | list) and len(entry) > 1
            ]
            instance.made += [as_range(entry[1]) for entry in pairs] or [None]
        if name == "sphere":
            self.sphere(instance)
        elif name in SHAPES:
            self.shape(instance)
        elif name in ("regularHexa", "regularOrtho", "randomDensePack", "hexaNet", "filterSpherePack"):
            self.packing(instance)
        elif name in FILES and not (isinstance(owner, str) and owner.partition(".")[0] in READERS):
            self.from_file(instance)
        elif name in CLUMPS or name in OTHER_SHAPES:
            self.clumps(instance)
        elif name == "readParamsFromTable":
            for key, value in instance.attributes.items():
                if key not in ("noTableOk", "unknownOk"):
                    self.table[key] = self.given.get(key, value)
        else:
            return self.function(name, owner, instance)
        return instance

    def function(self, name: str, owner: Any, instance: Instance) -> Any:
        """A function that makes no bodies."""
        arguments = instance.arguments
        if name in ("PWaveTimeStep", "RayleighWaveTimeStep"):
            step = self.wave_time(rayleigh=name.startswith("R"))
            return Unknown(instance.text) if step is None else step
        if name == "SpherePWaveTimeStep":
            radius, density, young = (
                instance.argument(k, key) for k, key in enumerate(("radius", "density", "young"))
            )
            return radius / math.sqrt(young / density)
        if name == "typedEngine" and arguments:
            return next(
                (engine for engine in self.engines if engine.name == arguments[0]), Unknown(instance.text)
            )
        if name == "isinstance" and len(arguments) == 2 and (body := body_of(arguments[0])) is not None:
            kind = arguments[1].text.rpartition(".")[2] if isinstance(arguments[1], Unknown) else ""
            return SHAPE_NAMES.get(body.kind) == kind
        if name == "runningInBatch":
            return False
        root = owner.partition(".")[0] if isinstance(owner, str) else name if owner is None else ""
        passed = (
            owner is None and name not in PLAIN and any(argument in (SCENE, BODIES) for argument in arguments)
        )
        hidden = name in (*HIDDEN, "setContactFriction") or name.startswith("growParticle")
        if name == "setContactFriction" and not self.repeats:
            self.set_friction(instance)
        elif hidden or root in self.foreign or passed:
            self.unknown[self.at(instance)] = None
        return instance

    def set_friction(self, instance: Instance) -> None:
        """``setContactFriction(angle)``: of the materials of bodies that move, and of their contacts."""
        moving = {body.material for body in self.bodies if not body.frozen}
        for k, material in enumerate(self.materials):
            if k in moving or self.elsewhere:
                material.attributes["frictionAngle"] = instance.argument(0, "angleRad")
        if any("frictAngle" in functor.attributes for functor in self.used("Ip2_")):
            what = "setContactFriction changes contacts that last: new ones have the functor's frictAngle"
            self.warnings[Note(what, None, self.at(instance))] = None

    def list_method(self, name: str, owner: list[Any], instance: Instance) -> Any:
        """Methods of lists, and of ``O.materials`` and ``O.engines``."""
        arguments = instance.arguments
        if owner is self.materials and name == "append":
            added = [argument for argument in flat(arguments) if isinstance(argument, Instance)]
            indices = [self.index(material) for material in added]
            return indices[0] if len(indices) == 1 and not isinstance(arguments[0], list) else indices
        if name == "append" and arguments:
            owner.append(arguments[0])
        elif name == "extend" and arguments and isinstance(arguments[0], list | tuple):
            owner.extend(arguments[0])
        elif name == "insert" and len(arguments) == 2 and isinstance(arguments[0], int):
            owner.insert(*arguments)
        else:
            return Unknown(instance.text)
        if re.search(r"\.engines\.(append|insert|extend)\(", instance.text):
            what = "a method of a copy of O.engines, which adds no engine"
            self.ignore(what, self.at(instance))
        return None

    def scene_method(self, name: str, instance: Instance) -> Any:
        """Methods of ``O``."""
        if name in ("run", "step"):
            steps = instance.argument(0, "steps", -1) if name == "run" else 1
            count = int(steps) if isinstance(steps, int | float) and 0 <= steps < 1e18 else None
            self.stage(self.at(instance), count)
        elif name in ("load", "loadTmp", "reload"):
            self.loaded(instance)
        elif self.repeats and name.startswith("reset") and name != "resetTime":
            self.unknown[self.at(instance)] = None
        elif name in ("reset", "resetThisScene", "resetCurrentScene", "resetAllScenes"):
            self.system += 1
            self.materials.clear()
            self.bodies, self.numbered, self.filling = [], 0, YadeFilling()
            self.engines, self.engines_given, self.engines_quote = [], True, None
            self.elsewhere, self.time_step, self.time_step_given = False, None, False
        elif name == "labeledEngine" and instance.arguments:
            return self.names.get(str(instance.arguments[0]), Unknown(instance.text))
        elif name in ("save", "saveTmp"):
            self.saved = (list(self.materials), list(self.bodies), self.engines, self.elsewhere)
        elif name not in SCENE_METHODS:
            self.unknown[self.at(instance)] = None
        return Unknown(instance.text)

    def loaded(self, instance: Instance) -> None:
        """The scene from a file: the one that the script saved last, if it did."""
        if self.saved is None:
            self.from_file(instance)
            return
        self.materials[:], self.bodies[:], self.engines, self.elsewhere = self.saved
        self.numbered, self.filling.container.known = 0, False

    def bodies_method(self, name: str, instance: Instance) -> Any:
        """Methods of ``O.bodies``. The value is the number of a body, if it is known."""
        quote = self.at(instance)
        if name in ("clear", "replace") and self.repeats:
            self.unknown[quote] = None
        elif name in ("clear", "replace"):
            self.bodies, self.numbered, self.elsewhere = [], 0, False
            cell, periodic = self.filling.cell, self.filling.periodic
            self.filling = YadeFilling(cell=cell, periodic=periodic)
        if name in ("append", "appendClumped", "replace", "insertAtId"):
            before = len(self.bodies)
            self.append(instance, clumped=name == "appendClumped")
            new = range(before, len(self.bodies))
            if name == "append" and new and self.body_at(new[-1]):
                several = isinstance(instance.argument(0, "bodies"), list | tuple)
                return list(new) if several else new[-1]
        elif name in CLUMPS or "lump" in name:
            self.clumps(instance)
        elif name == "erase":
            self.filling.census.complete = False
            self.ignore("bodies that are removed (O.bodies.erase)", quote)
        elif name not in ("clear", "getRoundness"):
            self.unknown[quote] = None
        return Unknown(instance.text)

    # --- bodies -------------------------------------------------------------------------------------------------

    def index(self, material: Instance) -> int:
        """The number of a material, which is added to ``O.materials`` if it is new."""
        for k, known in enumerate(self.materials):
            if known is material:
                return k
        self.materials.append(material)
        return len(self.materials) - 1

    def material_of(self, instance: Instance, place: int = -1) -> int:
        """The material of a body: given by number, label or instance; the last one by default."""
        material = instance.argument(place, "material", -1)
        if isinstance(material, Unknown) and material.text in self.functions:
            # The function makes the material of each body.
            call = ast.parse(f"{material.text}()", mode="eval").body
            material = self.value(ast.copy_location(call, self.functions[material.text]))
        if isinstance(material, Instance):
            return self.index(material)
        if isinstance(material, str):
            labels = [known.attributes.get("label") for known in self.materials]
            if material in labels:
                return labels.index(material)
            raise refusal(
                instance.line, instance.text, f"have a material of the script, not {material}", self.file
            )
        if not self.materials:
            self.index(Instance("FrictMat", (), dict(DEFAULT_MATERIAL), instance.line, "default material"))
        if isinstance(material, int) and -len(self.materials) <= material < len(self.materials):
            return material % len(self.materials)
        if material is None:
            return len(self.materials) - 1
        raise refusal(instance.line, instance.text, "have a known material", self.file)

    def body(self, instance: Instance, kind: str, radii: Range | None, place: int = -1) -> Body:
        fixed, moves = (instance.attributes.get(name) for name in ("fixed", "dynamic"))
        frozen = fixed in (True, 1) or moves in (False, 0)
        material = self.material_of(instance, place)
        quote, several = self.at(instance), self.repeats > 0
        if not all(isinstance(value, bool | int | None) for value in (fixed, moves)):
            self.unknown[quote] = None
        return Body(
            kind=kind, radii=radii, material=material, frozen=frozen, quote=quote, mass=None, several=several
        )

    def sphere(self, instance: Instance) -> None:
        """``sphere(center, radius, …)``."""
        radius, centre = drawn(instance.argument(1, "radius")), vector(instance.argument(0, "center"))
        body = self.body(instance, "sphere", radius)
        body.lot = uniform(None if body.several else 1.0, radius)
        body.ends = None if body.frozen else self.made_ends(instance)
        instance.made.append(body)
        if centre is not None and not body.frozen:
            self.filling.places.append((centre, centre, radius[0] if radius else 0.0))

    def made_ends(self, instance: Instance) -> Ends | None:
        """Between which ends a sphere is made, or all spheres of the SpherePack over which a loop runs."""
        centre = instance.argument(0, "center")
        if not isinstance(centre, Centre):
            return ends_of(instance)
        known = [ends for ends in centre.ends if ends is not None]
        return around(known) if known and len(known) == len(centre.ends) else None

    def shape(self, instance: Instance) -> None:
        """Facets, walls and boxes."""
        body = self.body(instance, SHAPES[instance.name], None)
        body.several |= instance.name not in ("facet", "wall", "box")
        body.frozen |= instance.name != "box"
        obstacle(self.filling, instance)
        self.filling.container.add(instance)
        if instance.name == "box":
            half = instance.argument(1, "extents")
            if isinstance(half, list | tuple) and len(half) == 3 and all(as_range(x) or x == 0 for x in half):
                density = self.number(self.materials[body.material], "density")
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
        if instance.attributes.get("returnSpherePack") is True:
            instance.attributes["ends"] = [ends_of(instance)]
            instance.name = "SpherePack"
            instance.made += sizes
        else:
            place = 2 if instance.name == "randomDensePack" else -1
            spheres = [self.body(instance, "sphere", size, place) for size in sizes]
            instance.made += [replace(sphere, several=True, ends=ends_of(instance)) for sphere in spheres]

    def pack_method(self, name: str, pack: Instance, instance: Instance) -> None:
        """Methods of a SpherePack."""
        lots, before = pack.attributes.setdefault("lots", []), len(pack.made)
        number = cloud(self.filling, pack, instance) if name == "makeCloud" else 1.0
        if name not in ("toSimulation", "toList", *UNMOVED):
            pack.attributes.setdefault("ends", []).append(ends_of(instance, name) if name in MADE else None)
        if name == "makeCloud":
            sizes = instance.argument(7, "psdSizes")
            if isinstance(sizes, list | tuple) and sizes and "num" not in instance.attributes:
                radii = union([as_range(size) for size in sizes])
                pack.made.append(None if radii is None else (0.5 * radii[0], 0.5 * radii[1]))
            elif sizes:
                pack.made.append(None)  # YADE may scale the sizes down
            else:
                pack.made.append(fuzzy(mean_radius(instance), instance.argument(3, "rRelFuzz", 0.0)))
        elif name == "add":
            pack.made.append(as_range(instance.argument(1, "radius")))
        elif name in ("load", "fromFile") and (listed := radii_in(self.folder, instance, True)):
            pack.made.append((min(listed), max(listed)))
            lots.append(lot_of(listed))
        elif name in PACK_FILES:
            pack.made.append(None)
        elif name == "makeClumpCloud":
            self.clumps(instance)
            pack.made.append(None)
        elif name == "toSimulation":
            sizes = list(dict.fromkeys(pack.made)) or [None]
            spheres = [self.body(instance, "sphere", size) for size in sizes]
            self.bodies += [replace(sphere, several=True) for sphere in spheres]
            self.filling.census.lots += lots if self.repeats == 0 and lots else [UNCOUNTED]
            self.filling.container.spheres += pack.attributes.get("ends", [None])
            if "cell" in pack.attributes:
                self.filling.cell, self.filling.periodic = pack.attributes["cell"], True
        elif name == "scale":
            lots[:] = [UNCOUNTED] * len(lots)
            factor = as_range(instance.argument(0, "scaleFactor"))
            pack.made = [
                None if size is None or factor is None else (factor[0] * size[0], factor[0] * size[1])
                for size in pack.made
            ]
        elif name == "toList":
            instance.name, instance.made = "SpherePack", pack.made
        if len(pack.made) == before + 1 and name in ("makeCloud", "add") and not self.repeats:
            lots.append(
                uniform(number, pack.made[-1]) if instance.argument(7, "psdSizes") is None else UNCOUNTED
            )
        elif len(lots) < len(pack.made):
            lots.append(UNCOUNTED)

    def append(self, instance: Instance, clumped: bool) -> None:
        """``O.bodies.append``: bodies, lists of them, or packings."""
        for part in flat([*instance.arguments, *instance.attributes.values()]):
            bodies = (
                [body for body in part.made if isinstance(body, Body)] if isinstance(part, Instance) else []
            )
            self.bodies += bodies
            self.filling.census.lots += [body.lot for body in bodies if body.kind == "sphere"]
            self.filling.container.spheres += [body.ends for body in bodies if body.kind == "sphere"]
            if clumped and isinstance(part, Instance):
                self.clumps(replace(part, name="appendClumped"))
            other = isinstance(part, Instance) and part.name in (*CLUMPS, *OTHER_SHAPES)
            if isinstance(part, Unknown | Instance) and not bodies and not other:
                self.elsewhere = True
                if not (isinstance(part, Instance) and part.name in FILES):
                    self.unknown[self.at(instance)] = None

    def from_file(self, instance: Instance) -> None:
        """Spheres whose sizes are not in the script: in a text beside it, or not known."""
        listed = radii_in(self.folder, instance, False) if instance.name in TEXTS else None
        if listed is not None:
            body = self.body(instance, "sphere", (min(listed), max(listed)))
            body.several, body.lot = True, UNCOUNTED if self.repeats else lot_of(listed)
            instance.made.append(body)
            return
        self.elsewhere = True
        self.filling.census.complete = self.filling.known = False
        self.unknown[self.at(instance)] = None

    def clumps(self, instance: Instance) -> None:
        self.filling.container.known = False
        self.invalidate(f"clumps or shapes that are no spheres ({instance.name})", self.at(instance))

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
        if self.elsewhere or (rayleigh and not times):
            return None
        return min(times, default=1.0)  # YADE's value before there are spheres

    # --- what holds at a run ------------------------------------------------------------------------------------

    def number(self, instance: Instance, name: str) -> float:
        """A number of a material, or its default."""
        default = MATERIALS.get(instance.name, {"density": 1000.0}).get(name)
        value = instance.attributes.get(name, instance.attributes.get("**", default))
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            said = value.text if isinstance(value, Unknown) else value
            raise refusal(
                instance.line, instance.text, f"have a known number for {name}, not {said}", self.file
            )
        return float(value)

    @property
    def bare(self) -> bool:
        """Whether the script has no bodies, and no functors in ``O.engines`` that make contacts."""
        functors = self.engines_given and any(inside(self.engines, "Ip2_"))
        return not (functors or self.bodies or self.elsewhere)

    @property
    def apart(self) -> bool:
        """Whether a script makes engines and does not enter them in ``O.engines``, as a part of a script may."""
        parts = ("Ip2_", "Law2_", "NewtonIntegrator", *["ViscElMat"] * self.bare)
        entered = self.engines_given and not self.bare
        return not entered and any(instance.name.startswith(parts) for instance in self.instances)

    def used(self, start: str) -> list[Instance]:
        """Instances whose name begins so: those of ``O.engines``, or all of a script that makes them beside it.

        Without engines that are dead, if the script never revives one.
        """
        instances = inside(self.instances if self.apart else self.engines, start)
        return [each for each in instances if self.revives or not each.attributes.get("dead", False)]

    def stage(self, quote: Quote, steps: int | None) -> None:
        """Note what holds now. A run with the same settings as that before continues its stage."""
        if self.stages and not self.changed:
            self.longer(steps, self.contents(self.stages[-1]))
            return
        self.changed = False
        for instance in self.instances if self.bare else ():
            if instance.name in MATERIALS:
                self.index(instance)  # although the part does not append it
        integrators = self.used("NewtonIntegrator")
        pressed, driven, shear_rate = self.driven()
        new = Stage(
            quote=quote,
            time_step=self.step_now(),
            time_step_given=self.time_step_given,
            steps=steps,
            contacts=tuple(self.contacts()),
            grains=self.grains(),
            gravity=self.gravity(integrators),
            numerical_damping=self.damping(integrators),
            down=self.down(integrators),
            pressed=pressed,
            pressure=self.pressure(),
            driven=driven,
            shear_rate=shear_rate,
            system=self.system,
        )
        new = replace(new, contents=self.contents(new))
        if self.continues(new):
            self.longer(steps, self.contents(self.stages[-1]))
        else:
            self.stages.append(new)
            self.damping_note(new, integrators)
            self.sides_note(new)
            self.notes()
            if new.contacts:
                self.missing_engines()

    def damping_note(self, stage: Stage, integrators: list[Instance]) -> None:
        """What the damping of the integrator does to friction."""
        damping = stage.numerical_damping
        if damping and any(contact.friction != 0.0 for contact in stage.contacts):
            quote = self.at(integrators[-1]) if integrators else None
            what = f"the damping {damping:g} of NewtonIntegrator acts on spins as well, along each axis"
            self.warnings[Note(f"{what}: β is without it", None, quote)] = None

    def sides_note(self, stage: Stage) -> None:
        """YADE's viscoelastic law adds the velocity of an image in a sheared cell where it must subtract it.

        Seen in 2023.02a with two spheres across a side; grains then slide along the sides as a plug.
        """
        for law in self.used("Law2_ScGeom_ViscElPhys_Basic") if stage.shear_rate else ():
            what = "ViscElPhys has the velocity of images in a sheared cell with the wrong sign"
            which = "contacts across its sides are wrong, those of FrictPhys are not"
            self.warnings[Note(f"{what}: {which}", None, self.at(law))] = None

    def contents(self, stage: Stage) -> Contents:
        """What a run has in its cell; factories make an unknown number of spheres."""
        contents = self.filling.contents(stage)
        if self.elsewhere or any(self.used(name) for name in ("BoxFactory", "CircularFactory")):
            return replace(contents, count=None, filled=None)
        return contents if stage.down is None or not self.still() else self.filling.bed(contents, stage.down)

    def still(self) -> bool:
        """Whether no engine or callback moves walls, adds bodies or forces, or presses the grains."""
        forced = [
            name for name in (engine.name for engine in self.used("")) if any(sign in name for sign in FORCES)
        ]
        if self.strain is not None or forced or any(engine.name in MOTION for engine in self.used("")):
            return False
        commands = [engine.argument(0, "command", "") for engine in self.used("PyRunner")]
        if not all(isinstance(command, str) for command in commands):
            return False
        parts = [part for command in commands for part in self.parts_of(command)]
        return not any(touches(part) or moves(part) for part in (*parts, *self.uncalled()))

    def uncalled(self) -> list[ast.FunctionDef]:
        """Functions that were not run here, although the script may run them."""
        named = {node.id for node in ast.walk(self.tree) if isinstance(node, ast.Name)}
        methods = [method for each in self.classes.values() for method in each.values()]
        functions = [*(function for name, function in self.functions.items() if name in named), *methods]
        return [function for function in functions if function not in self.executed]

    def parts_of(self, command: str) -> list[ast.AST]:
        """The functions that a command runs, and the command itself if it is understood."""
        pending, named = [command], dict[str, ast.FunctionDef]()
        while pending:
            new = self.functions.keys() & set(re.findall(r"\w+", pending.pop())) - named.keys()
            named |= {name: self.functions[name] for name in new}
            pending += [self.source(self.functions[name]) for name in new]
        try:
            return [*named.values(), ast.parse(textwrap.dedent(command))]
        except SyntaxError:
            return [*named.values()]

    def step_now(self) -> float | None:
        """The time step; None if it is not known or an engine changes it."""
        if any(is_active(stepper) for stepper in self.used("GlobalStiffnessTimeStepper")):
            return None
        return self.time_step if self.time_step_given else DEFAULT_TIME_STEP

    def damping(self, integrators: list[Instance]) -> float | None:
        # A part of a script may set that of the integrator that YADE makes.
        integrators = integrators or [engine for engine in self.engines if "damping" in engine.attributes]
        if not integrators:
            return None
        damping = integrators[-1].argument(0, "damping", NUMERICAL_DAMPING)
        if not isinstance(damping, int | float) or not 0.0 <= damping < 1.0:
            integrator = integrators[-1]
            raise refusal(integrator.line, integrator.text, "have a number in [0, 1) for damping", self.file)
        return float(damping)

    def gravity(self, integrators: list[Instance]) -> float | None:
        for engine in [*integrators, *self.used("GravityEngine")]:
            gravity = engine.attributes.get("gravity")
            if isinstance(gravity, tuple | list) and all(isinstance(x, int | float) for x in gravity):
                size = math.hypot(*gravity)
                return size or None
            if gravity is not None:
                self.unknown[self.at(engine)] = None
        return None

    def down(self, integrators: list[Instance]) -> Direction | None:
        """The direction of gravity."""
        for engine in [*integrators, *self.used("GravityEngine")]:
            gravity = engine.attributes.get("gravity")
            if isinstance(gravity, tuple | list) and all(isinstance(x, int | float) for x in gravity):
                size = math.hypot(*gravity)
                return tuple(x / size for x in gravity) if size else None
        return None

    def driven(self) -> tuple[tuple[Note, ...], tuple[Note, ...], float | None]:
        """What presses the grains, what else drives them, and the shear rate."""
        pressed = [
            Note(engine.name, None, self.at(engine)) for engine in self.used("") if engine.name in PRESSING
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

    def pressure(self) -> float | None:
        """The pressure that a controller prescribes; None if there is none or several, or if it is not known."""
        engines = [engine for engine in self.used("") if engine.name in PRESSURES]
        if len(engines) != 1:
            return None
        (names, mask), engine = PRESSURES[engines[0].name], engines[0]
        values = flat([engine.attributes.get(name) for name in names])
        mask = engine.attributes.get("stressMask", mask)
        if engine.name == "PeriIsoCompressor":
            values, mask = values[-1:], 1
        if not isinstance(mask, int):
            return None
        values = [value for k, value in enumerate(values[:3]) if mask >> k & 1]
        if not values or not all(isinstance(x, int | float) and not isinstance(x, bool) for x in values):
            return None
        return abs(math.fsum(values)) / len(values) or None

    def motion(self) -> Motion | None:
        """The fastest motion of walls and of fixed spheres; which of them move is not read."""
        motions: list[Motion | None] = []
        for engine in self.used(""):
            if engine.name == "HarmonicMotionEngine":
                sizes, rates = (engine.attributes.get(name, default) for name, default in HARMONIC)
                vectors = all(
                    isinstance(each, list | tuple) and all(isinstance(x, int | float) for x in each)
                    for each in (sizes, rates)
                )
                waves = [
                    Motion(tuple(a * (k == axis) for k in range(3)), 2.0 * math.pi * f)
                    for axis, (a, f) in enumerate(zip(sizes, rates, strict=False) if vectors else ())
                ]
                motions += waves or [UNKNOWN]
            elif engine.name in MOTION and engine.name not in PRESSING:
                speed = engine.argument(-1, "velocity") if engine.name == "TranslationEngine" else None
                steady = STEADY
                if speed is not None and is_number(speed):
                    steady = replace(STEADY, velocity=abs(float(speed)))
                if engine.name == "RotationEngine":
                    steady = replace(STEADY, turning=self._angular_velocity(engine))
                motions.append(steady if engine.name in STEADY_MOTION else UNKNOWN)
        return strongest(motions, self.down(self.used("NewtonIntegrator")))

    @staticmethod
    def _angular_velocity(engine: Instance) -> Direction | None:
        """That of ``RotationEngine``; None if it is not known."""
        along, rate = vector(engine.attributes.get("rotationAxis")), engine.attributes.get("angularVelocity")
        if along is None or not any(along) or rate is None or not is_number(rate):
            return None
        return tuple(float(rate) * part / math.hypot(*along) for part in along)

    def name(self, k: int) -> str:
        """The name of a material: its label, or its number."""
        label = self.materials[k].attributes.get("label")
        return label if isinstance(label, str) and label else str(k)

    def spheres(self) -> list[Body]:
        """Spheres of the script, and those that factories will make."""
        spheres = [body for body in self.bodies if body.kind == "sphere"]
        for factory in (*self.used("BoxFactory"), *self.used("CircularFactory")):
            attributes = factory.attributes
            radii = union([as_range(attributes.get(name)) for name in ("rMin", "rMax")])
            number, quote = attributes.get("materialId", -1), self.at(factory)
            if isinstance(number, int) and -len(self.materials) <= number < len(self.materials):
                sizes = None if "PSDsizes" in attributes else radii
                material = number % len(self.materials)
                spheres.append(Body("sphere", sizes, material, False, quote, several=True))
            else:
                self.unknown[quote] = None
        return spheres

    def kinds(self) -> list[int]:
        """Materials of spheres, or all if the script makes none."""
        kinds = sorted({sphere.material for sphere in self.spheres()})
        return list(range(len(self.materials))) if self.elsewhere or not kinds else kinds

    def grains(self) -> dict[str, Grains]:
        """The grains of each material: those that move, if some do."""
        grains, several = {}, self.elsewhere or len(self.bodies) > 1
        for k in self.kinds():
            spheres = [sphere for sphere in self.spheres() if sphere.material == k]
            fixed = [sphere for sphere in spheres if sphere.frozen]
            moving = [sphere for sphere in spheres if not sphere.frozen]
            frozen = bool(fixed) and not self.elsewhere and not moving
            kind = self.grains_of(k, fixed if frozen else moving, frozen)
            if fixed and not frozen:
                kind = replace(kind, partly_frozen=True, fixed=self.grains_of(k, fixed, True))
            lone = len(moving) == 1 and not moving[0].several and several and not self.elsewhere
            grains[kind.type] = replace(kind, alone=lone)
        return grains

    def grains_of(self, k: int, spheres: list[Body], frozen: bool) -> Grains:
        """Spheres of one material."""
        radii = None if self.elsewhere and not frozen else union([sphere.radii for sphere in spheres])
        density = self.number(self.materials[k], "density") if spheres or self.elsewhere else None
        # ViscElPhys takes the mass of a fixed sphere; MindlinPhys does not.
        counted = self.materials[k].name == "ViscElMat" and any(
            PHYSICS.get(functor.name) == "ViscElMat" for functor in self.used("Ip2_")
        )
        densities = None if density is None else (density, density)
        return Grains(self.name(k), radii, densities, None, frozen, counted)

    def contacts(self) -> Iterator[ContactSettings]:
        """Pairs of materials, then walls, without damping if the law leaves it out."""
        undamped = [law for law in self.used("Law2_ScGeom_MindlinPhys_") if law.name in UNDAMPED_LAWS]
        moves = self.motion()
        functors = self.functors()
        for contact in (*self.pairs_of_grains(functors), *self.contacts_with_walls(functors)):
            settings = contact.settings
            if undamped and settings["physics"].words[0] == "MindlinPhys":
                law, en = undamped[-1], settings.get("en")
                kept = {name: setting for name, setting in settings.items() if name not in ("en", "betan")}
                zero = Setting(("0.0",), law.line, law.text)
                restitution = None if en is None else float(en.words[0])
                contact = replace(contact, settings={**kept, "betan": zero}, asked=restitution)
            yield replace(contact, motion=moves)

    def functors(self) -> dict[str, Instance]:
        """The functors that make contacts, by the material that they read."""
        functors = {
            PHYSICS[functor.name]: functor for functor in self.used("Ip2_") if functor.name in PHYSICS
        }
        if self.bare and self.apart and not functors:  # only one functor reads this material
            materials = self.used("ViscElMat")[:1]
            functors = {material.name: replace(material, name=OF_VISCOELASTIC) for material in materials}
        return functors

    def pairs_of_grains(self, functors: Mapping[str, Instance]) -> Iterator[ContactSettings]:
        """Pairs of materials whose grains meet."""
        kinds, grains = self.kinds(), self.grains()
        for i in kinds if self.touching("sphere") is not None else []:
            first = grains[self.name(i)]
            for j in kinds[kinds.index(i) :]:
                fixed = first.frozen and grains[self.name(j)].frozen
                if fixed or (i == j and first.alone and not first.partly_frozen):
                    continue
                parts = self.between(functors, i, j)
                if parts is not None:
                    types = (self.name(i), self.name(j))
                    friction, tangential = self.friction(functors, (i, j), types)
                    yield ContactSettings(types, None, *parts, friction=friction, tangential=tangential)

    def contacts_with_walls(self, functors: Mapping[str, Instance]) -> Iterator[ContactSettings]:
        """Grains that move, with walls, or in a part of a script without walls with ``wall`` of each material."""
        kinds, grains = self.kinds(), self.grains()
        walls = {
            (body.kind, body.material, body.mass): body.quote for body in self.bodies if body.kind != "sphere"
        }
        assumed = self.part and not walls
        for k in kinds if assumed else ():
            walls["walls", k, None] = self.at(self.materials[k])
        several = len({material for _, material, _ in walls}) > 1
        for i in sorted(k for k in kinds if not grains[self.name(k)].frozen):
            for (kind, j, mass), quote in walls.items():
                size = self.touching(kind)
                parts = None if size is None else self.between(functors, i, j, size)
                if parts is None or size is None:
                    continue
                words = parts[0]
                counted = words["physics"].words[0] == "ViscElPhys" and "en" in words and kind == "boxes"
                if counted and mass is None:
                    self.unknown[quote] = None  # its mass is in the formulas
                    continue
                name = self.name(j) if assumed else f"{kind} of {self.name(j)}" if several else kind
                larger = 2.0 if math.isinf(size) else 2.0 * size / (1.0 + size)
                # YADE takes a body without mass to have that of the sphere.
                formula_mass = (mass or None) if counted else None
                types = (self.name(i), WALL)
                friction, tangential = self.friction(functors, (i, j), types, size, kind)
                yield ContactSettings(
                    types, name, *parts, formula_mass, larger, friction=friction, tangential=tangential
                )

    def friction(
        self,
        functors: Mapping[str, Instance],
        ends: tuple[int, int],
        types: tuple[str, str],
        wall: float | None = None,
        kind: str = "",
    ) -> tuple[float | None, Tangential | None]:
        """The coefficient of friction and the tangential force of a contact; None and quoted if it is not known."""
        pair = self.materials[ends[0]], self.materials[ends[1]]
        functor = self.functor_of(functors, pair)
        assert functor is not None  # or there are no settings of its normal force
        contact = Contact(functor, pair, ends, wall, kind)
        friction, tangential = tangential_of(self, contact)
        self.warnings |= dict.fromkeys(warnings(self, contact, types, tangential))
        locked = [body.locked for body in self.spheres() if body.material in ends]
        quotes = [quote for quote in (*locked, self.locked) if quote is not None]
        if friction == 0.0 or (tangential is not None and not quotes):
            return friction, tangential
        sources = [self.at(source) for source in (*pair, functor)]
        self.unknown |= dict.fromkeys(quotes or sources)
        return friction, None

    def touching(self, kind: str) -> float | None:
        """The size of bodies of this kind over that of a sphere in YADE's formulas; None if they touch no sphere."""
        shape, size = (SHAPE_NAMES[kind], SIZES.get(kind, 1.0))
        meet = [functor for functor in self.used("Ig2_") if functor.name.startswith(f"Ig2_{shape}_Sphere_")]
        seen = [*self.used(f"Bo1_{shape}_Aabb"), *self.used("FlatGridCollider")]
        if not (self.apart or (meet and seen)):
            missing = f"Bo1_{shape}_Aabb" if meet else f"Ig2_{shape}_Sphere_…"
            what = f"{kind if kind in SIZES else 'spheres'} without contacts: no {missing}"
            self.ignore(what, self.engines_quote)
            return None
        for functor in meet:
            hertzian = functor.attributes.get("hertzian", False)
            if isinstance(hertzian, bool | int):
                size = math.inf if hertzian else size
            else:
                self.unknown[self.at(functor)] = None
        return size

    def functor_of(
        self, functors: Mapping[str, Instance], pair: tuple[Instance, Instance]
    ) -> Instance | None:
        """The functor that makes the contacts of two materials, with a law for them; None if there is none."""
        names = {material.name for material in pair}
        functor = functors.get(pair[0].name) if len(names) == 1 else None
        if functor is None and names <= MATERIALS.keys():
            functor = functors.get("FrictMat")  # the others are FrictMat as well
        if functor is None:
            return None
        laws, physics = self.used("Law2_"), functor.name.rpartition("_")[2]
        if (laws or not self.apart) and not any(f"_{physics}_" in law.name for law in laws):
            self.unknown[self.quote(functor.line, f"{functor.text} without its law")] = None
            return None
        return functor

    def between(
        self, functors: Mapping[str, Instance], i: int, j: int, wall: float | None = None
    ) -> tuple[Settings, tuple[Quote, ...]] | None:
        """The settings of two materials; None if no functor makes their contacts, or if they are no springs.

        ``wall`` is the size of a wall of the second material over that of the sphere.
        """
        pair = self.materials[i], self.materials[j]
        functor = self.functor_of(functors, pair)
        if functor is None:
            return None
        types = (self.name(i), self.name(j) if wall is None else WALL)
        what = self.no_spring(functor, pair)
        if what:
            self.invalidates[Note(what, types, self.at(functor))] = None
            return None
        numbers = self.numbers(functor, pair, (i, j), wall)
        if numbers is None:
            missing = (
                pair if functor.attributes.keys().isdisjoint(("en", "betan", "tc", "kn")) else (functor,)
            )
            self.unknown.update(dict.fromkeys(self.at(source) for source in missing))
            return None
        physics = functor.name.rpartition("_")[2]
        settings = {"physics": Setting((LIKE.get(physics, physics),), functor.line, functor.text)}
        for name, (value, source) in numbers.items():
            settings[name] = Setting((repr(value),), source.line, source.text)
        quotes = dict.fromkeys(self.at(source) for source in (*pair, functor))
        return settings, tuple(quotes)

    def no_spring(self, functor: Instance, pair: tuple[Instance, Instance]) -> str:
        """Why a contact is none of a spring and a dashpot; empty if it is one."""
        if functor.name.endswith("ViscElPhys") and all(
            material.attributes.get("SPHmode", False) for material in pair
        ):
            return "smoothed-particle hydrodynamics (SPHmode)"
        if not functor.name.endswith("CohFrictPhys"):
            return ""
        bonds = [
            functor.attributes.get(name, False) for name in ("setCohesionNow", "setCohesionOnNewContacts")
        ]
        cohesive = [material.attributes.get("isCohesive", True) for material in pair]
        cohesion = functor.attributes.get("normalCohesion")
        if isinstance(cohesion, Instance):
            cohesion = cohesion.attributes.get("val") if not list(entries(cohesion)) else 1.0
        strengths = (
            [material.attributes.get("normalCohesion", -1.0) for material in pair]
            if cohesion is None
            else [cohesion]
        )
        positive = all(not isinstance(x, int | float) or x > 0.0 for x in strengths)
        return f"adhesion or bonds ({functor.name})" if any(bonds) and all(cohesive) and positive else ""

    def numbers(
        self,
        functor: Instance,
        pair: tuple[Instance, Instance],
        ends: tuple[int, int],
        wall: float | None,
    ) -> dict[str, tuple[float, Instance]] | None:
        """Numbers of a contact with the object that gives them; None if one material cannot replace the two."""
        material = pair[0]
        if functor.name.endswith("ViscElPhys"):
            return self.viscoelastic(functor, pair, ends, wall)
        young = [self.number(each, "young") for each in pair]
        if functor.name.endswith("FrictPhys"):
            if "kn" in functor.attributes:
                return None  # a stiffness instead of the modulus
            mean = self.mean_modulus(young, ends, wall)
            return None if mean is None else {"young": (mean, material)}
        ratios = [self.number(each, "poisson") for each in pair]
        modulus, ratio = young[0], ratios[0]
        if young[0] != young[1] or ratios[0] != ratios[1]:
            modulus, ratio = one_material((young[0], ratios[0]), (young[1], ratios[1]))
        numbers = {"young": (modulus, material), "poisson": (ratio, material)}
        alone = "es" if "es" in functor.attributes else "en"  # which YADE takes for en if that is not given
        for name in ("en", "betan"):
            word = alone if name == "en" and "en" not in functor.attributes else name
            if word in functor.attributes:
                value = self.matched(functor, word, ends)
                if value is None:
                    return None
                numbers[name] = (value, functor)
        if "en" not in numbers and "betan" not in numbers:
            numbers["betan"] = (0.0, functor)
        return numbers

    def viscoelastic(
        self,
        functor: Instance,
        pair: tuple[Instance, Instance],
        ends: tuple[int, int],
        wall: float | None,
    ) -> dict[str, tuple[float, Instance]] | None:
        """ViscElMat: tc, en and et; or kn, cn, ks and cs; or Young's modulus and en. None if YADE refuses them.

        Of two materials, tc and en are means, and springs and dashpots are in series.
        """
        material = pair[0]

        def have(*names: str) -> bool:
            return all(name in each.attributes for each in pair for name in names)

        def mean(name: str) -> tuple[float, Instance] | None:
            if name not in functor.attributes:
                return 0.5 * sum(self.number(each, name) for each in pair), material
            value = self.matched(functor, name, ends)
            return None if value is None else (value, functor)

        numbers: dict[str, tuple[float, Instance] | None] = {}
        if have("tc", "en", "et") or {"tc", "en", "et"} <= functor.attributes.keys():
            numbers = {name: mean(name) for name in ("tc", "en")}
        elif have("kn", "cn", "ks", "cs"):
            numbers = {name: (self.in_series(name, pair), material) for name in ("kn", "cn")}
        elif have("en") or have("cn", "cs"):
            young = self.mean_modulus([self.number(each, "young") for each in pair], ends, wall)
            numbers["young"] = None if young is None else (young, material)
            numbers |= (
                {"cn": (self.in_series("cn", pair), material)} if have("cn", "cs") else {"en": mean("en")}
            )
        known = {name: value for name, value in numbers.items() if value is not None}
        return known if numbers and len(known) == len(numbers) else None

    def in_series(self, name: str, pair: tuple[Instance, Instance]) -> float:
        """Twice the number of two springs or dashpots in series; a zero is left out."""
        values = [self.number(each, name) for each in pair]
        inverse = sum(1.0 / value for value in values if value)
        return values[0] if values[0] == values[1] else 2.0 / inverse

    def mean_modulus(self, young: list[float], ends: tuple[int, int], wall: float | None) -> float | None:
        """The modulus of two springs 2 Y R in series; None if the sizes of grains differ as well as the moduli.

        ``wall`` is the size of the second body over that of the first: 2 s Y/(1 + s) is 2 s Y₁ Y₂/(Y₁ + s Y₂).
        """
        if wall is not None:
            return young[0] * (
                1.0 if math.isinf(wall) else (1.0 + wall) * young[1] / (young[0] + wall * young[1])
            )
        if young[0] == young[1]:
            return young[0]
        sizes = union([sphere.radii for sphere in self.spheres() if sphere.material in ends])
        if sizes is None or sizes[0] != sizes[1]:
            return None
        return 2.0 * young[0] * young[1] / (young[0] + young[1])

    def matched(
        self,
        functor: Instance,
        name: str,
        ends: tuple[int, int],
        values: tuple[float, float] | None = None,
    ) -> float | None:
        """A number of a functor: the same for all contacts, or that of a MatchMaker; None if it has none.

        ``values``: of the two materials, which a MatchMaker mixes for two that it does not list.
        """
        value = functor.attributes[name]
        if isinstance(value, Instance) and value.name == "MatchMaker":
            for entry in entries(value):
                if sorted(entry[:2]) == sorted(ends):
                    return entry[2]
            value = value.attributes.get("val") if values is None else mixed(value, values)
            if value is None:
                return None
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise refusal(functor.line, functor.text, f"have a known number for {name}", self.file)
        return float(value)

    # --- the description ----------------------------------------------------------------------------------------

    def description(self) -> Description:
        """Run the script and describe it."""
        self.run()
        contacts = [contact for stage in self.stages for contact in stage.contacts]
        if not self.stages or not contacts or (self.part and self.changed):
            last = self.instances[-1] if self.instances else None
            self.stage(self.quote(last.line if last else 1, last.text if last else self.text[:80]), None)
        self.notes()
        self.callbacks()
        description = self.described()
        if (
            not any(stage.contacts for stage in description.stages)
            and not description.invalidates
            and not description.unknown
        ):
            raise ValueError("script: has no granular contacts")
        return description

    def notes(self) -> None:
        """What is in the engines beside normal contacts."""
        if (
            len(self.bodies) == 1
            and len(self.spheres()) == 1
            and not (self.bodies[0].several or self.elsewhere)
        ):
            what = "only one sphere: its contact is that with another like it"
            self.ignore(what, self.bodies[0].quote)
        self.unknown |= {body.quote: None for body in self.bodies if body.kind == "boxes" and not body.frozen}
        known = [material for material in self.materials if material.name in MATERIALS]
        for instance in dict.fromkeys([*self.used(""), *known]):
            quote, name = self.at(instance), instance.name
            if instance.attributes.get("densityScaling", False):  # other masses than those of the grains
                self.unknown[quote] = None
            strange = (
                instance.attributes.keys()
                - {"**"}
                - set(ATTRIBUTES.get(name, " ".join(instance.attributes)).split())
            )
            if strange:
                self.unknown[quote] = None
                self.refuse(quote, f"have known words, not {', '.join(sorted(strange))}")
            if name.startswith(("Ip2_", "Law2_")) or (name.endswith("Mat") and name[:1].isupper()):
                self.contact_note(instance, quote)
            elif name in MOTION:
                self.ignore(f"prescribed motion ({name})", quote)
            elif name == "GlobalStiffnessTimeStepper" and is_active(instance):
                self.ignore("a time step that adapts (GlobalStiffnessTimeStepper)", quote)
            elif name == "PyRunner":
                self.runner_note(instance, quote)
            elif instance in self.engines:
                what = next((what for sign, what in FORCES.items() if sign in name), "")
                if what:
                    self.invalidate(f"{what} ({name})", quote)
                elif name not in ENGINES and not name.endswith("Recorder"):
                    self.unknown[quote] = None

    def missing_engines(self) -> None:
        """Engines without which nothing moves or forces are never reset."""
        engines = self.engines_quote
        for part in ("ForceResetter", "Integrator") if engines is not None and self.engines_given else ():
            if engines is not None and not any(part in engine.name for engine in self.engines):
                self.unknown[self.quote(engines.line, f"no {part} in {engines.text}")] = None

    def contact_note(self, instance: Instance, quote: Quote) -> None:
        name = instance.name
        law, force = name.startswith("Law2_"), ""
        if any(sign in name for sign in STICKY) and name not in (*MATERIALS, *PHYSICS, *LAWS):
            force = f"adhesion or bonds ({name})"
        elif name in (*LAWS, *UNDAMPED_LAWS) and instance.attributes.get("includeAdhesion") not in (
            None,
            False,
            0,
        ):
            force = "adhesion (includeAdhesion)"
        elif name == "ViscElMat" and instance.attributes.get("lubrication", False):
            force = "a fluid (lubrication)"
        if force:
            self.invalidate(force, quote)
            self.refuse(quote, f"be without {force}")
        elif name not in (*MATERIALS, *PHYSICS, *LAWS, *UNDAMPED_LAWS):
            self.unknown[quote] = None
            self.refuse(
                quote, f"be one of {', '.join(LAWS if law else MATERIALS if 'Mat' in name[-3:] else PHYSICS)}"
            )
        elif law:
            self.ignore(f"tangential forces ({name})", quote)

    def runner_note(self, instance: Instance, quote: Quote) -> None:
        """A callback that changes contacts or grains."""
        command = instance.argument(0, "command", "")
        if not isinstance(command, str):
            return
        parts = self.parts_of(command)
        self.executed |= {part for part in parts if isinstance(part, ast.FunctionDef)}
        if any(map(touches, parts)):
            self.unknown[quote] = None

    def callbacks(self) -> None:
        """Functions that were not run here, although the script may run them."""
        for function in self.uncalled():
            if touches(function):
                self.unknown[
                    self.quote(function.lineno, f"def {function.name}({ast.unparse(function.args)})")
                ] = None


def inside(instances: Iterable[Any], start: str) -> Iterator[Instance]:
    """These instances and those in their arguments whose name begins so, each once."""
    pending, seen = list(reversed([*instances])), set[int]()
    while pending:
        instance = pending.pop()
        if isinstance(instance, Instance) and id(instance) not in seen:
            seen.add(id(instance))
            if instance.name.startswith(start):
                yield instance
            pending += reversed(flat([*instance.arguments, *instance.attributes.values()]))


def touches(part: ast.AST) -> bool:
    """Whether statements change contacts, bodies, engines or the time step."""
    for node in ast.walk(part):
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        if any(isinstance(each, ast.Attribute) and each.attr in CHANGING - {"dead"} for each in targets):
            return True
        if isinstance(node, ast.Call):
            owner, _, name = ast.unparse(node.func).rpartition(".")
            if name in TOUCHING or name in HIDDEN or owner.endswith((".bodies", ".materials")):
                return True
    return False


def moves(part: ast.AST) -> bool:
    """Whether statements set places or velocities of bodies."""
    targets = [node for node in ast.walk(part) if isinstance(node, ast.Attribute)]
    return any(node.attr in PLACED and isinstance(node.ctx, ast.Store) for node in targets)


def body_of(value: Any) -> Body | None:
    """The body of ``sphere(…)``, ``wall(…)`` or ``O.bodies[…]``; None for anything else."""
    bodies = value.made if isinstance(value, Instance) else []
    return (
        bodies[0] if len(bodies) == 1 and isinstance(bodies[0], Body) and value.name != "SpherePack" else None
    )


def fixes(degrees: str) -> bool:
    """Whether a body cannot move with these blocked degrees of freedom."""
    return set("xyz") <= set(degrees)


def turns(degrees: str) -> bool:
    """Whether a sphere turns as a free one, in a plane as well, or not at all if it is fixed."""
    spins = {axis for axis in "xyz" if axis.upper() not in degrees}
    fixed = {axis for axis in "xyz" if axis in degrees}
    return not spins if len(fixed) == 3 else len(spins) == 3 or (len(fixed) == 1 and fixed <= spins)


def is_active(engine: Instance) -> bool:
    """Whether an engine is neither dead nor inactive."""
    return not engine.attributes.get("dead", False) and bool(engine.attributes.get("active", True))


def as_range(value: Any) -> Range | None:
    """One known positive number as a range."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < math.inf:
        return None
    return float(value), float(value)


def drawn(value: Any) -> Range | None:
    """A known positive number, or the ends of ``random.uniform``."""
    if isinstance(value, Instance) and value.name == "uniform" and len(value.arguments) == 2:
        ends = [as_range(end) for end in value.arguments]
        return union(ends)
    return as_range(value)


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


def read(
    text: str, file: str, variables: Mapping[str, str], part: bool = False, folder: Path | None = None
) -> Description:
    """Describe a script of YADE; ``folder``: of files of spheres."""
    return Yade(text, file, variables, part, folder).description()
