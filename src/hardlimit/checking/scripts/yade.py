"""Evaluate a YADE script, which is Python: what it assigns and calls builds a scene. Nothing in it is executed."""

from __future__ import annotations

import ast
import math
import re
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Final

from .description import Description, Note, Quote
from .formulas import NUMBER
from .python import Evaluator, Instance, Unknown, Vector, flat
from .reader import names
from .yade_bodies import BodyCalls, body_of, spheres_of
from .yade_callbacks import CHANGING, FORCE_METHODS, HIDDEN, OF_CONTACTS, PLACED, touches
from .yade_contacts import SHAPE_NAMES
from .yade_container import Ends, is_number, shape_of, vector
from .yade_container import union as around_all
from .yade_extents import Drawn, computed, draw, ends_of_space, is_space, moved
from .yade_filling import volume_of
from .yade_scene import MATERIALS, Body, Push, Scene
from .yade_stages import DEFAULT_TIME_STEP, add_stage, description

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
#: Where a script revives a dead engine.
REVIVED: Final = re.compile(r"\.dead\s*=(?!\s*(True|1\b))|setattr")
IDENTITY: Final = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)  #: ``Matrix3.Identity``
#: Surfaces of triangles.
SURFACES: Final = ("sweptPolylines2gtsSurface", "Surface")
#: What keeps a body from moving by forces.
HELD: Final = (("dynamic", False), ("blockedDOFs", "xyzXYZ"))
#: A body by its number.
OF_NUMBER: Final = re.compile(r"O\.bodies\[(\w+)\](?:\.state)?")
#: Most bodies that a loop runs over one by one.
MAX_BODIES: Final = 1000


class Yade(Evaluator):
    """A script of YADE. What it builds is in ``scene``."""

    def __init__(
        self,
        text: str,
        file: str = "",
        variables: Mapping[str, str] = {},
        part: bool = False,
        folder: Path | None = None,
    ) -> None:
        self.given = {
            name: float(word) if NUMBER.fullmatch(word) else word for name, word in variables.items()
        }
        super().__init__(text, file, dict(self.given))
        self.names["__name__"] = "__main__"
        self.foreign: set[str] = set()  #: names of modules that are not known
        self.table: dict[str, Any] = {}
        self.of_spheres: set[str] = set()  #: names of loops over numbers of spheres
        self.of_walls: set[str] = set()  #: and over those of walls and boxes
        self.scene = Scene(file, part, REVIVED.search(text) is not None, self.instances)
        self.body_calls = BodyCalls(self.scene, self, folder)
        self.scene.engines = self.value(ast.parse(DEFAULT_ENGINES, mode="eval").body)
        self.instances.clear()
        self.label(self.scene.engines)

    # --- statements ---------------------------------------------------------------------------------------------

    def statement(self, node: ast.stmt) -> None:
        if isinstance(node, ast.ImportFrom) and (node.module or "").endswith("params.table"):
            self.names |= {name: value for name, value in self.table.items() if name not in self.given}
        super().statement(node)

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
            first = alias.name if inside else alias.name.partition(".")[0]
            self.foreign |= {alias.asname or alias.name, first}

    def tried(self, node: ast.Try | ast.TryStar) -> None:
        """``try``; what handles an error may change the scene as well."""
        super().tried(node)
        for handler in node.handlers:
            if any(map(touches, handler.body)):
                self.uncertain(handler, [handler.body])

    def forget(self, node: ast.AST) -> None:
        super().forget(node)
        self.names |= self.given

    def quoted(self, node: ast.AST) -> Quote:
        """The first line of a statement."""
        return self.scene.quote(getattr(node, "lineno", 1), self.source(node).partition("\n")[0])

    def not_understood(self, node: ast.AST, attribute: str = "") -> None:
        """Quote a statement, such as the assignment of an attribute."""
        quote = self.quoted(node)
        self.scene.unknown[quote] = None
        if attribute in OF_CONTACTS:
            self.scene.refuse(
                quote, "be an attribute of an object of the script, which always has this value"
            )

    # --- values -------------------------------------------------------------------------------------------------

    def items(self, node: ast.expr) -> list[Any] | None:
        """What an iteration runs over: also the centres and the smallest and largest radius of a SpherePack."""
        iterable = self.value(node)
        if isinstance(iterable, Instance) and iterable.name == "SpherePack":
            self.scene.filling.census.complete = False  # its loop runs over sizes here, not over spheres
            return spheres_of(iterable)
        if iterable == BODIES:
            number = len(self.scene.bodies)
            known = [self.scene.body_at(k) for k in range(min(number, MAX_BODIES))]
            return None if None in known or len(known) < number else known
        return super().items(node)

    def one_of(self, items: list[Any], text: str) -> Any:
        """A number between the smallest and the largest of these."""
        numbers = [float(item) for item in items if is_number(item)]
        known = numbers and len(numbers) == len(items)
        return Drawn(text, min(numbers), max(numbers)) if known else super().one_of(items, text)

    def binary(self, left: Any, sign: ast.operator, right: Any, node: ast.AST) -> Any:
        """An operation, also of numbers drawn at random, centres of spheres, and predicates."""
        value = computed(left, sign, right, self.source(node))
        for matrix, number in ((left, right), (right, left)):
            if isinstance(matrix, Instance) and matrix.name == "Matrix3" and is_number(number):
                parts = flat([matrix.arguments])
                if isinstance(sign, ast.Mult) and len(parts) == 9 and all(map(is_number, parts)):
                    scaled = tuple(number * part for part in parts)
                    return Instance("Matrix3", scaled, {}, matrix.line, self.source(node))
        return super().binary(left, sign, right, node) if value is None else value

    def unary(self, sign: ast.unaryop, value: Any, node: ast.expr) -> Any:
        """The opposite of a number drawn at random is one as well."""
        if isinstance(value, Drawn) and isinstance(sign, ast.USub):
            return Drawn(self.source(node), -value.high, -value.low)
        return super().unary(sign, value, node)

    def compared(self, node: ast.Compare, values: list[Any]) -> Any:
        """A comparison with a value that is not known. A feature that a script asks for is taken to be there."""
        if len(values) == 2 and isinstance(values[1], Unknown) and values[1].text.endswith("features"):
            return isinstance(node.ops[0], ast.In)
        asks = isinstance(values[0], Unknown) and "libVersions" in values[0].text
        if asks and isinstance(node.ops[0], ast.GtE):
            return True
        return super().compared(node, values)

    def member(self, owner: Any, name: str, node: ast.Attribute) -> Any:
        scene = self.scene
        if name == "O" and isinstance(owner, str):
            return SCENE  # as in yade.O
        if owner == "O":
            if name == "materials":
                return scene.materials
            if name == "engines":
                return list(scene.engines)  # YADE copies it
            if name == "dt" and (scene.time_step is not None or not scene.time_step_given):
                return scene.time_step or DEFAULT_TIME_STEP
        if owner == "Matrix3" and name == "Identity":
            return Instance("Matrix3", IDENTITY, {}, node.lineno, self.source(node))
        if owner in ("table", "params.table", "yade.params.table") and name in self.table:
            return self.table[name]
        if isinstance(owner, Instance) and name in MATERIALS.get(owner.name, {}):
            return owner.attributes.get(name, MATERIALS[owner.name][name])
        if isinstance(owner, Instance) and name in ("state", "shape") and body_of(owner):
            return owner
        return super().member(owner, name, node)

    def item(self, container: Any, place: ast.expr, node: ast.expr) -> Any:
        if container is self.scene.materials and isinstance(key := self.value(place), str):
            for material in self.scene.materials:
                if material.attributes.get("label") == key:
                    return material
        if container == BODIES and (body := self.scene.body_at(self.value(place))) is not None:
            return body
        return super().item(container, place, node)

    # --- assignments --------------------------------------------------------------------------------------------

    def assign(self, target: ast.expr, value: Any, node: ast.AST) -> None:
        """Names of the command line keep their values."""
        if isinstance(target, ast.Subscript) and isinstance(target.value, ast.Attribute):
            self.part_assigned(target.value, self.value(target.slice), value)
        if not (isinstance(target, ast.Name) and target.id in self.given and self.depth == 0):
            super().assign(target, value, node)

    def part_assigned(self, target: ast.Attribute, place: Any, value: Any) -> None:
        """A component of a velocity or a place, such as ``b.state.vel[1] = v``."""
        body, filling = body_of(self.value(target.value)), self.scene.filling
        if target.attr == "vel":
            before = filling.velocities.get(id(body), (0.0, 0.0, 0.0))
            known = place in (0, 1, 2) and is_number(value)
            parts = [value if k == place else part for k, part in enumerate(before)] if known else None
            self.scene.changed = True
            self.velocity_assigned(body, parts)
        sphere = self.is_sphere(body, ast.unparse(target.value))
        if target.attr in PLACED and (target.attr == "pos" or not sphere):
            self.wall_moved(target.attr, None)

    def assigned(self, owner: Any, name: str, value: Any, node: ast.AST) -> None:
        """An attribute. A change that may be made or not, or that is not understood, is quoted."""
        scene, body = self.scene, body_of(owner)
        scene.changed = True
        if name == "vel":
            self.velocity_assigned(body, value)
        sphere = self.is_sphere(body, owner)
        if name in PLACED and (name == "pos" or not sphere):
            self.wall_moved(name, value)
        if name == "vel" and not sphere:
            place = shape_of(owner) if isinstance(owner, Instance) else None
            is_wall = body is not None or self.is_wall(owner)
            scene.pushed = Push(
                vector(value), None if place is None else place[0], self.quoted(node), is_wall
            )
        if owner == "O":
            self.scene_assigned(name, value, node)
        elif owner == "O.cell":
            self.cell_assigned(name, value, node)
        elif body is not None and name in CHANGING:
            if self.repeats or not self.body_assigned(body, name, value, node):
                self.not_understood(node)
        elif isinstance(owner, Instance):
            if self.repeats and name in CHANGING and owner.attributes.get(name) != value:
                self.not_understood(node, name)
        elif name == "blockedDOFs" and isinstance(value, str) and not fixes(value):
            scene.locked = scene.locked if turns(value) else self.quoted(node)
            scene.planar |= is_planar(value)
        elif (name, value) in HELD and self.is_wall(owner):
            pass  # no force moves it, or it is a box that is quoted where it is made
        elif name in CHANGING:
            scene.weighed |= name == "mass"
            fixed = name == "blockedDOFs" and isinstance(value, str) and fixes(value)
            scene.some_fixed |= fixed or (name == "dynamic" and value in (False, 0))
            self.not_understood(node, name)
        super().assigned(owner, name, value, node)

    def loop(self, target: ast.expr, iterable: ast.expr, body: list[ast.stmt]) -> None:
        """A loop, also one that fixes all bodies, or all spheres."""
        certain = self.repeats == 0 and not self.scene.elsewhere and self.value(iterable) == BODIES
        if isinstance(target, ast.Name) and certain and fixes_each(target.id, body):
            for known in self.scene.bodies:
                known.frozen = True
            self.scene.filling.fixed = list(self.scene.filling.census.lots)
            self.scene.changed = True
            return
        if isinstance(target, ast.Name):
            numbers = self.value(iterable)
            from_pack = isinstance(numbers, Instance) and numbers.name == "toSimulation"
            of_walls = self.numbers_walls(numbers)
            self.of_spheres = self.of_spheres - {target.id} | ({target.id} if from_pack else set())
            self.of_walls = self.of_walls - {target.id} | ({target.id} if of_walls else set())
        super().loop(target, iterable, body)

    def is_sphere(self, body: Body | None, text: Any) -> bool:
        """Whether a body is a sphere; one of unknown number, if it is from ``SpherePack.toSimulation``."""
        return number_in(text) in self.of_spheres if body is None else body.kind == "sphere"

    def is_wall(self, text: Any) -> bool:
        """Whether a text stands for a wall or a box, by a number of a loop or that ``O.bodies.append`` returned."""
        name = number_in(text)
        return name in self.of_walls or self.numbers_walls(self.names.get(name))

    def numbers_walls(self, value: Any) -> bool:
        """Whether a value stands for the numbers of walls or boxes."""
        return isinstance(value, Unknown) and value.text in self.scene.filling.container.walls_only

    def wall_moved(self, name: str, value: Any) -> None:
        """The place or the velocity of a wall, or of an unknown body."""
        container = self.scene.filling.container
        if name == "vel":
            container.moves.append(vector(value))
        else:
            container.known = False

    def velocity_assigned(self, body: Body | None, value: Any) -> None:
        """The velocity of a body, or of an unknown one."""
        velocity = vector(value)
        if body is None or velocity is None or self.repeats or body.several:
            self.scene.filling.known = False
        else:
            self.scene.filling.velocities[id(body)] = velocity

    def cell_assigned(self, name: str, value: Any, node: ast.AST) -> None:
        """An attribute of ``O.cell``."""
        scene = self.scene
        if name in ("hSize", "refHSize"):
            scene.filling.cell = volume_of(value)
            return
        scene.filling.container.known = False
        if name in ("velGrad", "nextVelGrad"):
            quote = scene.quote(getattr(node, "lineno", 1), self.source(node))
            scene.strain = value, quote
            scene.ignore(f"a box that deforms (O.cell.{name})", quote)
        elif name in CHANGING:
            self.not_understood(node, name)

    def scene_assigned(self, name: str, value: Any, node: ast.AST) -> None:
        """An attribute of ``O``."""
        scene = self.scene
        if name == "periodic":
            scene.filling.periodic = value in (True, 1)
        if name == "dt":
            known = isinstance(value, int | float) and not isinstance(value, bool) and 0.0 < value < math.inf
            before, scene.time_step = scene.time_step, float(value) if known else None
            scene.time_step_given = True
            if self.repeats and scene.time_step != before:
                scene.time_step = None
            if scene.time_step is None:
                self.not_understood(node)
        elif name == "engines":
            parts = flat([value])
            engines = [part for part in parts if isinstance(part, Instance)]
            if len(engines) < len(parts) or (self.repeats and engines != scene.engines):
                self.not_understood(node, name)
            scene.engines, scene.engines_given = engines, True
            scene.engines_quote = scene.quote(getattr(node, "lineno", 1), self.source(node))
            self.label(engines)
        elif name in ("dynDt", "usesTimeStepper") and isinstance(value, bool | int):
            for stepper in scene.used("GlobalStiffnessTimeStepper"):
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
            body.planar = is_planar(value)
        elif name in ("mat", "material") and isinstance(value, Instance):
            body.material = self.scene.index(value)
        else:
            body.weighed |= name == "mass"
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

    # --- calls --------------------------------------------------------------------------------------------------

    def called(self, name: str, owner: Any, instance: Instance) -> Any:
        super().called(name, owner, instance)
        scene = self.scene
        scene.changed |= not (owner == "O" and name in ("run", "step")) and name not in PLAIN
        if isinstance(owner, list):
            return self.list_method(name, owner, instance)
        if owner == "O":
            return self.scene_method(name, instance)
        if owner == "O.bodies":
            return self.body_calls.method(name, instance)
        if owner == "O.cell" and name == "setBox":
            scene.filling.cell = vector(instance.argument(0, "size")) or vector(instance.arguments)
        if owner == "O.forces" and name in FORCE_METHODS:
            scene.invalidate(f"an additional force or displacement (O.forces.{name})", scene.at(instance))
            scene.filling.container.known = False
        if isinstance(owner, Instance) and owner.name == "SpherePack":
            self.body_calls.pack_method(name, owner, instance)
            return instance
        if name == "Omega":
            return SCENE
        if isinstance(owner, Instance) and (is_space(owner) or owner.name in SURFACES):
            return self.space_method(name, owner, instance)
        if (number := draw(name, owner, instance)) is not None:
            return number
        if self.body_calls.function(name, owner, instance):
            return instance
        return self.function(name, owner, instance)

    def space_method(self, name: str, space: Instance, instance: Instance) -> Any:
        """A method of a predicate or a surface."""
        moved(space, name, instance)
        ends = ends_of_space(space)
        if name == "is_closed":
            return True
        if ends is not None and name == "aabb":
            return Vector(ends[0]), Vector(ends[1])
        if ends is not None and name in ("dim", "center"):
            share = 1.0 if name == "dim" else 0.5
            sign = -1.0 if name == "dim" else 1.0
            return Vector(share * (high + sign * low) for low, high in zip(*ends, strict=True))
        return instance

    def function(self, name: str, owner: Any, instance: Instance) -> Any:
        """A function that makes no bodies."""
        arguments = instance.arguments
        if name == "readParamsFromTable":
            for key, value in instance.attributes.items():
                if key not in ("noTableOk", "unknownOk"):
                    self.table[key] = self.given.get(key, value)
            return instance
        if name in ("PWaveTimeStep", "RayleighWaveTimeStep"):
            step = wave_time(self.scene, rayleigh=name.startswith("R"))
            return Unknown(instance.text) if step is None else step
        if name == "SpherePWaveTimeStep":
            radius, density, young = (
                instance.argument(k, key) for k, key in enumerate(("radius", "density", "young"))
            )
            return radius / math.sqrt(young / density)
        if name == "typedEngine" and arguments:
            named = (engine for engine in self.scene.engines if engine.name == arguments[0])
            return next(named, Unknown(instance.text))
        if name == "isinstance" and len(arguments) == 2 and (body := body_of(arguments[0])) is not None:
            kind = arguments[1].text.rpartition(".")[2] if isinstance(arguments[1], Unknown) else ""
            return SHAPE_NAMES.get(body.kind) == kind
        if name == "revolutionSurfaceMeridians" and len(arguments) == 2 and not instance.attributes:
            sections, angles = arguments
            return [
                [(x * math.cos(angle), x * math.sin(angle), y) for x, y in section]
                for section, angle in zip(sections, angles, strict=True)
            ]
        if name == "runningInBatch":
            return False
        around = extent(self.scene) if name in ("aabbExtrema", "spheresPackDimensions") else None
        if around is not None:
            low, high = map(Vector, around)
            if name == "aabbExtrema":
                return low, high
            middle, size = Vector(0.5 * (low + high)), Vector(high - low)
            return {"min": low, "max": high, "center": middle, "extends": size}
        root = owner.partition(".")[0] if isinstance(owner, str) else name if owner is None else ""
        passed = (
            owner is None and name not in PLAIN and any(argument in (SCENE, BODIES) for argument in arguments)
        )
        hidden = name in (*HIDDEN, "setContactFriction") or name.startswith("growParticle")
        if name == "setContactFriction" and not self.repeats:
            self.set_friction(instance)
        elif hidden or root in self.foreign or passed:
            self.scene.unknown[self.scene.at(instance)] = None
        return instance

    def set_friction(self, instance: Instance) -> None:
        """``setContactFriction(angle)``: of the materials of bodies that move, and of their contacts."""
        scene = self.scene
        moving = {body.material for body in scene.bodies if not body.frozen}
        for k, material in enumerate(scene.materials):
            if k in moving or scene.elsewhere:
                material.attributes["frictionAngle"] = instance.argument(0, "angleRad")
        if any("frictAngle" in functor.attributes for functor in scene.used("Ip2_")):
            what = "setContactFriction changes contacts that last: new ones have the functor's frictAngle"
            scene.warnings[Note(what, None, scene.at(instance))] = None

    def list_method(self, name: str, owner: list[Any], instance: Instance) -> Any:
        """Methods of lists, and of ``O.materials`` and ``O.engines``."""
        scene, arguments = self.scene, instance.arguments
        if owner is scene.materials and name == "append":
            added = [argument for argument in flat(arguments) if isinstance(argument, Instance)]
            indices = [scene.index(material) for material in added]
            return indices[0] if len(indices) == 1 and not isinstance(arguments[0], list) else indices
        if name == "append" and arguments:
            owner.append(arguments[0])
        elif name == "extend" and arguments and isinstance(arguments[0], list | tuple):
            owner.extend(arguments[0])
        elif name == "insert" and len(arguments) == 2 and isinstance(arguments[0], int):
            owner.insert(*arguments)
        elif name == "index" and len(arguments) == 1 and arguments[0] in owner:
            return owner.index(arguments[0])
        else:
            return Unknown(instance.text)
        if re.search(r"\.engines\.(append|insert|extend)\(", instance.text):
            scene.ignore("a method of a copy of O.engines, which adds no engine", scene.at(instance))
        return None

    def scene_method(self, name: str, instance: Instance) -> Any:
        """Methods of ``O``."""
        scene, quote = self.scene, self.scene.at(instance)
        if name in ("run", "step"):
            steps = instance.argument(0, "steps", -1) if name == "run" else 1
            count = int(steps) if isinstance(steps, int | float) and 0 <= steps < 1e18 else None
            try:
                add_stage(scene, self, quote, count)
            except ArithmeticError:  # of numbers that no contact has
                scene.unknown[quote] = None
        elif name in ("load", "loadTmp", "reload"):
            if not scene.load():
                self.body_calls.from_file(instance)
        elif self.repeats and name.startswith("reset") and name != "resetTime":
            scene.unknown[quote] = None
        elif name in ("reset", "resetThisScene", "resetCurrentScene", "resetAllScenes"):
            scene.reset()
        elif name == "labeledEngine" and instance.arguments:
            return self.names.get(str(instance.arguments[0]), Unknown(instance.text))
        elif name in ("save", "saveTmp"):
            scene.save()
        elif name not in SCENE_METHODS:
            scene.unknown[quote] = None
        return Unknown(instance.text)


def wave_time(scene: Scene, rayleigh: bool) -> float | None:
    """Time in which a wave crosses the smallest sphere; None if sizes are not known."""
    times = []
    for body in scene.bodies:
        if body.kind == "sphere":
            material = scene.materials[body.material]
            young, poisson, density = (
                scene.number(material, name) for name in ("young", "poisson", "density")
            )
            if body.radii is None or body.weighed:
                return None
            if rayleigh:
                shear = young / (2.0 * (1.0 + poisson))
                time = math.pi * body.radii[0] / (0.1631 * poisson + 0.876605) * math.sqrt(density / shear)
            else:
                time = body.radii[0] * math.sqrt(density / young)
            times.append(time)
    if scene.elsewhere or scene.weighed or scene.growing or (rayleigh and not times):
        return None
    return min(times, default=1.0)  # YADE's value before there are spheres


def extent(scene: Scene) -> Ends | None:
    """The ends of all spheres if each is one of known place, or all are in lattices; None if they are not known."""
    spheres = [body for body in scene.bodies if body.kind == "sphere"]
    exact = all(body.ends is not None and (body.filled or not body.several) for body in spheres)
    return around_all([body.ends for body in spheres if body.ends]) if spheres and exact else None


def number_in(text: Any) -> str:
    """The name of the number of a body in a text such as ``O.bodies[k].state``; empty for others."""
    match = OF_NUMBER.fullmatch(text) if isinstance(text, str) else None
    return "" if match is None else match[1]


def fixes(degrees: str) -> bool:
    """Whether a body cannot move with these blocked degrees of freedom."""
    return set("xyz") <= set(degrees)


def is_planar(degrees: str) -> bool:
    """Whether a body moves in a plane with these blocked degrees of freedom."""
    return len(set("xyz") & set(degrees)) == 1


def turns(degrees: str) -> bool:
    """Whether a sphere turns as a free one, in a plane as well, or not at all if it is fixed."""
    spins = {axis for axis in "xyz" if axis.upper() not in degrees}
    fixed = {axis for axis in "xyz" if axis in degrees}
    return not spins if len(fixed) == 3 else len(spins) == 3 or (len(fixed) == 1 and fixed <= spins)


def fixes_each(name: str, body: list[ast.stmt]) -> bool:
    """Whether a loop over bodies of this name only fixes each of them, or each sphere."""
    if len(body) == 1 and isinstance(body[0], ast.If) and not body[0].orelse:
        test = ast.unparse(body[0].test)
        return test == f"isinstance({name}.shape, Sphere)" and fixes_each(name, body[0].body)
    texts = {ast.unparse(statement) for statement in body}
    fixing = {f"{name}{state}.blockedDOFs = 'xyzXYZ'" for state in ("", ".state")}
    return bool(texts) and texts <= fixing | {f"{name}.dynamic = False", f"{name}.dynamic = 0"}


def read(
    text: str, file: str, variables: Mapping[str, str], part: bool = False, folder: Path | None = None
) -> Description:
    """Describe a script of YADE; ``folder``: of files of spheres."""
    script = Yade(text, file, variables, part, folder)
    script.run()
    return description(script.scene, script)
