"""The stages of a YADE script: what holds in its scene at each run."""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Iterator
from dataclasses import replace
from itertools import chain, combinations
from typing import Any, Final, TypeGuard

from .description import (
    FEW,
    WALL,
    ContactSettings,
    Contents,
    Description,
    Direction,
    Motion,
    Note,
    Quote,
    Speed,
    Stage,
)
from .motion import STEADY, UNKNOWN, strongest
from .python import Evaluator, Instance, Unknown, flat
from .statements import refusal
from .yade_callbacks import appends, commands_of, fills, moves, parts_of, stresses, uncalled
from .yade_contacts import PHYSICS, Contacts
from .yade_container import Ends, axis_of, box_around, is_number, union, vector
from .yade_notes import (
    FLUIDS,
    MOTION,
    PRESSING,
    callbacks,
    damping_note,
    flip_note,
    force_of,
    missing_engines,
    notes,
    sides_note,
)
from .yade_scene import MATERIALS, Scene, is_active

DEFAULT_TIME_STEP: Final = 1e-8  #: of a scene
NUMERICAL_DAMPING: Final = 0.2  #: NewtonIntegrator's default
#: The stresses of those that prescribe one, and which of them are stresses by default: a bit for each.
PRESSURES: Final = {
    "PeriTriaxController": (("goal",), 0),
    "Peri3dController": (("goal",), 0),
    "TriaxialStressController": (("goal1", "goal2", "goal3"), 7),
    "ThreeDTriaxialEngine": (("goal1", "goal2", "goal3"), 7),
    "PeriIsoCompressor": (("stresses",), 0),
    "TriaxialCompressionEngine": (("sigmaIsoCompaction",), 1),
}
#: Those with a bit of ``stressMask`` for each axis.
BY_AXIS: Final = ("PeriTriaxController", "Peri3dController", "TriaxialStressController")
#: The axis that is left out where two axes have their bits.
BUT_ONE: Final = {6: 0, 5: 1, 3: 2}
#: Those that make spheres larger unless ``internalCompaction`` is off.
GROWING: Final = ("TriaxialStressController", "TriaxialCompressionEngine", "ThreeDTriaxialEngine")
#: The stress that a controller measures.
MEASURED: Final = re.compile(r"\.stress\(|\.meanStress\b")
#: Those that know gravity.
FALLING: Final = ("NewtonIntegrator", "GravityEngine", "RungeKuttaCashKarp54Integrator")
#: Those that move walls or grains steadily.
STEADY_MOTION: Final = ("TranslationEngine", "RotationEngine", "HelixEngine")
#: Those that may leave a bed under its own weight, and the cosine up to which they move across gravity.
ACROSS: Final = {"TranslationEngine", "RotationEngine", "HarmonicMotionEngine"}
LEVEL: Final = 1e-6
#: Most spheres that are looked at in pairs.
MOST_FALLING: Final = 300
X_AXIS: Final = (1.0, 0.0, 0.0)  #: of engines that turn, by default
#: Amplitude and frequency of ``HarmonicMotionEngine``, with their defaults.
HARMONIC: Final = (("A", (0.0, 0.0, 0.0)), ("f", (0.0, 0.0, 0.0)))


def description(scene: Scene, script: Evaluator) -> Description:
    """What a script says that was run. Without a run, what holds at its end."""
    contacts = [contact for stage in scene.stages for contact in stage.contacts]
    if not scene.stages or not contacts or (scene.part and scene.changed):
        last = scene.instances[-1] if scene.instances else None
        quote = scene.at(last) if last else scene.quote(1, script.text[:80])
        add_stage(scene, script, quote, None)
    notes(scene, script)
    callbacks(scene, script)
    if scene.stages and any(map(stresses, called_back(scene, script) or ())):
        scene.stages[-1] = replace(scene.stages[-1], pressure_changes=True)
    described = scene.described()
    granular = any(stage.contacts for stage in described.stages)
    spheres = [body for body in scene.bodies if body.kind == "sphere"]
    plain = all(functor.name in PHYSICS for functor in scene.used("Ip2_"))
    if not granular and plain and spheres and all(body.frozen for body in spheres) and not scene.elsewhere:
        raise ValueError("script: no grain moves freely")
    if not (granular or described.invalidates or described.unknown):
        raise ValueError("script: has no granular contacts")
    return described


def add_stage(scene: Scene, script: Evaluator, quote: Quote, steps: int | None) -> None:
    """Note what holds now. A run with the same settings as that before continues its stage."""
    if scene.stages and not scene.changed:
        scene.longer(steps, contents(scene, script, scene.stages[-1]))
        flip_note(scene, script, scene.stages[-1])
        return
    scene.changed = False
    for instance in scene.instances if scene.bare else ():
        if instance.name in MATERIALS:
            scene.index(instance)  # although the part does not append it
    stage = stage_now(scene, quote, steps)
    stage = replace(stage, contents=contents(scene, script, stage))
    if scene.continues(stage):
        scene.longer(steps, stage.contents)
        flip_note(scene, script, scene.stages[-1])
        return
    scene.stages.append(stage)
    damping_note(scene, stage)
    sides_note(scene, stage)
    flip_note(scene, script, stage)
    notes(scene, script)
    if stage.contacts:
        missing_engines(scene)


def stage_now(scene: Scene, quote: Quote, steps: int | None) -> Stage:
    """What holds now, without the contents of the cell."""
    scene.growing |= grows(scene)
    pressed, driven, shear_rate = driving(scene)
    step, contacts = time_step(scene), Contacts(scene)
    settings = [*contacts.settings()]
    gravity, down = weight(scene)
    moving = motion(scene, down)
    return Stage(
        quote=quote,
        time_step=step,
        time_step_given=scene.time_step_given,
        steps=steps,
        contacts=tuple(
            replace(contact, motion=moving, pushes=pushes_of(scene, contact)) for contact in settings
        ),
        grains=contacts.grains,
        gravity=gravity,
        numerical_damping=damping(scene),
        down=down,
        pressed=pressed,
        pressure=pressure(scene),
        uniaxial=uniaxial(scene),
        strained=strained(scene),
        driven=driven,
        shear_rate=shear_rate,
        system=scene.system,
    )


def pushes_of(scene: Scene, contact: ContactSettings) -> tuple[Direction, ...] | None:
    """The directions in which the walls of a contact push; None if they are not known, or may turn."""
    if contact.types[1] != WALL or scene.elsewhere or any(scene.used(name) for name in MOTION):
        return None
    return scene.filling.container.pushes


def contents(scene: Scene, script: Evaluator, stage: Stage) -> Contents:
    """What a run has in its cell; factories make an unknown number of spheres."""
    integrators = scene.used("NewtonIntegrator")
    whole = bool(integrators) and integrators[-1].attributes.get("dampGravity", True) in (False, 0)
    contents = scene.filling.contents(stage, 0.0 if whole else stage.numerical_damping or 0.0)
    factories = [*scene.used("BoxFactory"), *scene.used("CircularFactory")]
    moving = scene.filling.moving
    if contents.count is not None and moving is not None and 0 < moving <= FEW < contents.count:
        contents = replace(contents, count=moving)
    contents = replace(contents, speeds=(*contents.speeds, *launches(factories)))
    if scene.elsewhere or factories or any(map(appends, called_back(scene, script) or ())):
        contents = replace(contents, count=None, filled=None)
    if scene.elsewhere or stage.down is None or not has_own_weight(scene, script, stage.down):
        return contents
    if not factories and fall_apart(scene, stage.down):
        return replace(contents, never_meet=True)
    sources = [ends_of_factory(factory) for factory in factories]
    container = scene.filling.container
    for engine in scene.used("ResetRandomPosition"):  # to one of these facets
        facets = engine.attributes.get("factoryFacets")
        appended = container.appended.get(facets.text) if isinstance(facets, Unknown) else None
        walls = [*(appended or container.ends)] if facets else []
        sources.append(union([*filter(None, walls)]) if walls and None not in walls else None)
    turning = [
        vector(engine.attributes.get("rotationAxis", X_AXIS)) for engine in scene.used("RotationEngine")
    ]
    across = [axis for axis in turning if axis is None or not is_along(axis, stage.down)]
    if None in across or len(across) > 1:
        return contents
    moving = any(velocity is not None and any(velocity) for velocity in scene.filling.container.moves)
    moving = moving or any(scene.used(name) for name in ACROSS)
    return scene.filling.bed(contents, stage.down, sources, next(iter(across), None), moving)


def launches(factories: list[Instance]) -> Iterator[Speed]:
    """The largest velocity with which factories make spheres."""
    for factory in factories:
        speed = factory.attributes.get("vMax")
        if speed is not None and is_number(speed) and speed > 0.0:
            yield Speed(float(speed), "the velocity with which a factory makes spheres")


def fall_apart(scene: Scene, down: Direction) -> bool:
    """Whether spheres move beside each other and fixed ones along gravity, and beside or below all walls."""
    filling, along = scene.filling, axis_of(down)
    bodies = [body for body in scene.bodies if body.kind == "sphere"]
    single = not any(body.several for body in bodies)
    moved = any(body.frozen for body in bodies) and any(scene.used(name) for name in MOTION)
    if (
        along is None
        or not single
        or moved
        or not filling.known
        or filling.periodic
        or not filling.container.known
        or not filling.container.everywhere
    ):
        return False
    across = [k for k in range(3) if k != along[0]]
    velocities = [velocity for velocity in filling.velocities.values() if any(velocity[k] for k in across)]
    places = [body.ends for body in bodies if body.ends is not None]
    if velocities or not bodies or len(places) < len(bodies) or len(bodies) > MOST_FALLING:
        return False
    k, sign = along
    walls = [(ends, min(sign * end[k] for end in ends)) for ends in filling.container.walls]
    moving = [body.ends for body in bodies if body.ends is not None and not body.frozen]
    return not any(
        all(first[0][k] < second[1][k] and second[0][k] < first[1][k] for k in across)
        for first, second in chain(
            combinations(places, 2),
            (
                (ends, wall)
                for ends in moving
                for wall, low in walls
                if low < 0.5 * sign * (ends[0][k] + ends[1][k])
            ),
        )
    )


def is_along(axis: Direction, down: Direction) -> bool:
    """Whether an axis is that of gravity."""
    return abs(sum(a * b for a, b in zip(axis, down, strict=True))) > (1.0 - LEVEL) * math.hypot(*axis)


def has_own_weight(scene: Scene, script: Evaluator, down: Direction) -> bool:
    """Whether nothing but their weight, and walls that move across gravity, presses the grains where they are known.

    Engines and callbacks must add no bodies or forces; those of a fluid are left out here.
    """
    engines = {engine.name for engine in scene.used("")}
    forced = any(force_of(name) not in FLUIDS for name in engines)
    if scene.strain is not None or forced or engines & (MOTION - ACROSS):
        return False
    axes = [
        vector(engine.attributes.get("translationAxis"))
        for engine in scene.used("TranslationEngine")
        if not is_intruder(scene, engine, down)
    ]
    for move in (*axes, *scene.filling.container.moves):
        if move is None or abs(sum(a * b for a, b in zip(move, down, strict=True))) > LEVEL * math.hypot(
            *move
        ):
            return False
    parts = called_back(scene, script)
    if parts is None:
        return False
    return not any(
        fills(part, again=part in script.entered) or moves(part) for part in (*parts, *uncalled(script))
    )


def is_intruder(scene: Scene, engine: Instance, down: Direction) -> bool:
    """Whether an engine moves walls that are much narrower than the bed: the rest of it bears its own weight."""
    moved = engine.attributes.get("ids")
    return isinstance(moved, Unknown) and scene.filling.container.is_narrow(moved.text, down)


def called_back(scene: Scene, script: Evaluator) -> list[ast.AST] | None:
    """What the engines run: functions and commands; None if it is not known."""
    commands = [command for engine in scene.used("") for command in commands_of(engine)]
    if not all(isinstance(command, str) for command in commands):
        return None
    return [part for command in commands for part in parts_of(script, command)]


def ends_of_factory(factory: Instance) -> Ends | None:
    """Where a factory makes spheres; None if it is not known."""
    radius, length = factory.attributes.get("radius"), factory.attributes.get("length", 0.0)
    half = factory.attributes.get("extents")
    if factory.name == "CircularFactory" and radius is not None and is_number(radius) and is_number(length):
        half = (math.hypot(radius, 0.5 * length),) * 3
    return box_around(factory.attributes.get("center"), half)


def time_step(scene: Scene) -> float | None:
    """The time step; None if it is not known or an engine changes it."""
    if any(is_active(stepper) for stepper in scene.used("GlobalStiffnessTimeStepper")):
        return None
    return scene.time_step if scene.time_step_given else DEFAULT_TIME_STEP


def damping(scene: Scene) -> float | None:
    """The damping of the integrator; a part of a script may set that of the one that YADE makes."""
    integrators = scene.used("NewtonIntegrator") or [
        engine for engine in scene.engines if "damping" in engine.attributes
    ]
    if not integrators:
        return None
    damping = integrators[-1].argument(0, "damping", NUMERICAL_DAMPING)
    if not isinstance(damping, int | float) or not 0.0 <= damping < 1.0:
        integrator = integrators[-1]
        raise refusal(integrator.line, integrator.text, "have a number in [0, 1) for damping", scene.file)
    return float(damping)


def weight(scene: Scene) -> tuple[float | None, Direction | None]:
    """The magnitude and the direction of gravity."""
    for engine in [engine for name in FALLING for engine in scene.used(name)]:
        gravity = engine.attributes.get("gravity")
        if are_numbers(gravity):
            size = math.hypot(*gravity)
            return (size, tuple(x / size for x in gravity)) if size else (None, None)
        if gravity is not None:
            scene.unknown[scene.at(engine)] = None
    return None, None


def driving(scene: Scene) -> tuple[tuple[Note, ...], tuple[Note, ...], float | None]:
    """What presses the grains, what else drives them, and the shear rate."""
    pressing = [engine for engine in scene.used("") if engine.name in PRESSING]
    pressed = tuple(Note(engine.name, None, scene.at(engine)) for engine in pressing)
    pressed += squeezing(scene)
    if scene.strain is None:
        return pressed, (), None
    value, quote = scene.strain
    rates = flat([value.arguments]) if isinstance(value, Instance) else []
    if "Zero" in (value.text if isinstance(value, Unknown) else str(value)):
        return pressed, (), None  # Matrix3.Zero
    deformed = (Note("O.cell.velGrad", None, quote),)
    if len(rates) != 9 or not are_numbers(rates):
        return pressed, deformed, None
    sheared = [abs(x) for k, x in enumerate(rates) if k % 4 and x]
    if rates[0] + rates[4] + rates[8] < -1e-9 * max(map(abs, rates)):
        pressed += (Note("a cell that shrinks (velGrad)", None, quote),)
    if any(rates[::4]) or len(sheared) > 1:
        return pressed, deformed, None
    return pressed, (), sheared[0] if sheared else None


def grows(scene: Scene) -> bool:
    """Whether a controller makes the spheres larger until they are under its pressure."""
    growing = [
        engine for name in GROWING for engine in scene.used(name) if is_active(engine) and enlarges(engine)
    ]
    for engine in growing:
        scene.ignore("radii that grow (internalCompaction)", scene.at(engine))
    return bool(growing)


def enlarges(engine: Instance) -> bool:
    """Whether a controller makes the spheres larger, from all sides alike."""
    return engine.name in GROWING and engine.attributes.get("internalCompaction", True) not in (False, 0)


def squeezing(scene: Scene) -> tuple[Note, ...]:
    """A wall that moves towards another one, with all spheres between them, and no gravity that makes them a bed."""
    container, push = scene.filling.container, scene.pushed
    space = container.around
    if push is None or push.velocity is None or space is None or weight(scene)[0] is not None:
        return ()
    axes = [k for k, part in enumerate(push.velocity) if part]
    if len(axes) != 1:
        return ()
    (k,), small = axes, container.small(space)
    places = [face.at for face in container.faces if face.axis == k]
    below, above = (
        any(sign * at >= sign * end[k] - small for at in places)
        for sign, end in zip((-1.0, 1.0), space, strict=True)
    )
    away = push.place is not None and (push.place[0][k] > space[0][k] + small) == (push.velocity[k] > 0.0)
    if not (below and above) or away:
        return ()
    return (Note("walls that move against grains", None, push.quote),)


def pressure(scene: Scene) -> float | None:
    """The pressure that a controller prescribes; None if there is none or several, or if it is not known."""
    servos = scene.used("ServoPIDController")
    if servos:
        return pressure_of_servo(scene, servos)
    engine = controller(scene)
    planar = scene.planar or any(sphere.planar for sphere in scene.spheres())
    if engine is None or planar:  # one layer of spheres carries what the script has over the whole cell
        return None
    goals, mask = goals_of(engine)
    if mask is None:
        return None
    values = [value for k, value in enumerate(goals) if mask >> k & 1]
    before = scene.stages[-1] if scene.stages and scene.stages[-1].system == scene.system else None
    if any(isinstance(value, Unknown) and MEASURED.search(value.text) for value in values):
        # It keeps the stress that it has reached.
        same = before is not None and any(note.what == engine.name for note in before.pressed)
        return before.pressure if before is not None and same else None
    if not values or not are_numbers(values) or any(isinstance(x, bool) for x in values):
        return None
    return abs(math.fsum(values)) / len(values) or None


def controller(scene: Scene) -> Instance | None:
    """The controller of stresses; None if there is none, or several."""
    engines = [engine for engine in scene.used("") if engine.name in PRESSURES]
    engines = [engine for engine in engines if is_active(engine)] or engines
    return engines[0] if len(engines) == 1 else None


def goals_of(engine: Instance) -> tuple[list[Any], int | None]:
    """The goals of a controller along each axis, and a bit for each that is a stress; None if they are not known."""
    names, mask = PRESSURES[engine.name]
    old = {name: engine.attributes.get(name.replace("goal", "sigma")) for name in names}  # in older versions
    values = flat([engine.attributes.get(name, old[name]) for name in names])
    mask = engine.attributes.get("stressMask", mask)
    if engine.name == "ThreeDTriaxialEngine":
        controlled = [engine.attributes.get(f"stressControl_{k}", True) for k in (1, 2, 3)]
        mask = sum(1 << k for k, value in enumerate(controlled) if value in (True, 1))
        if enlarges(engine):
            mask = 7  # grains grow until the mean stress is that of all three
    if engine.name == "PeriIsoCompressor":
        values, mask = values[-1:], 1
    return values[:3], mask if isinstance(mask, int) else None


def strained(scene: Scene) -> bool:
    """Whether a controller keeps stresses along two axes and compresses the grains along the third one.

    ``TriaxialCompressionEngine`` does so by itself once the grains are confined.
    """
    engine = controller(scene)
    if engine is None or enlarges(engine):
        return False
    if engine.name == "TriaxialCompressionEngine":
        return engine.attributes.get("autoCompressionActivation", True) not in (False, 0)
    goals, mask = goals_of(engine)
    if mask not in BUT_ONE or len(goals) < 3:
        return False
    goal = goals[BUT_ONE[mask]]
    return not is_number(goal) or goal < 0.0 or (goal > 0.0 and engine.name == "ThreeDTriaxialEngine")


def uniaxial(scene: Scene) -> bool:
    """Whether a controller prescribes one of three stresses."""
    engines = [engine for name in BY_AXIS for engine in scene.used(name) if is_active(engine)]
    if any(map(enlarges, engines)):
        return False
    masks = [engine.attributes.get("stressMask", PRESSURES[engine.name][1]) for engine in engines]
    return all(mask in (1, 2, 4) for mask in masks) and bool(masks or scene.used("ServoPIDController"))


def pressure_of_servo(scene: Scene, servos: list[Instance]) -> float | None:
    """The target force of a servo on what closes a cylinder, over the area of this; None if one is not known."""
    force, axis = servos[0].attributes.get("target"), vector(servos[0].attributes.get("axis"))
    areas = [cylinder.area for cylinder in scene.filling.container.cylinders]
    if force is None or not is_number(force) or len(servos) > 1 or not areas or axis is None or any(axis[:2]):
        return None
    return abs(float(force)) / max(areas) or None


def motion(scene: Scene, down: Direction | None) -> Motion | None:
    """The fastest motion of walls and of fixed spheres; which of them move is not read."""
    motions: list[Motion | None] = []
    for engine in scene.used(""):
        if engine.name == "HarmonicMotionEngine":
            motions += shaking(engine) or [UNKNOWN]
        elif engine.name == "BicyclePedalEngine":
            motions.append(circling(engine, down))
        elif engine.name in STEADY_MOTION:
            steady, speed = STEADY, engine.argument(-1, "velocity")
            if engine.name == "TranslationEngine" and speed is not None and is_number(speed):
                steady = replace(STEADY, velocity=abs(float(speed)))
            elif engine.name == "RotationEngine":
                steady = replace(STEADY, turning=angular_velocity(engine))
            motions.append(steady)
        elif engine.name in MOTION - PRESSING:
            motions.append(UNKNOWN)
    if down is not None:
        motions += belt(scene, down)
    return strongest(motions, down)


def belt(scene: Scene, down: Direction) -> list[Motion]:
    """A wall to which the script gives a velocity across gravity, as to a belt; none if it is at rest, or a piston."""
    push = scene.pushed
    if push is None or push.velocity is None or not push.is_wall or not any(push.velocity):
        return []
    if is_along(push.velocity, down):
        return []
    return [replace(STEADY, velocity=math.hypot(*push.velocity), course=push.velocity)]


def shaking(engine: Instance) -> list[Motion]:
    """The oscillations of ``HarmonicMotionEngine`` along each axis; none if they are not known."""
    sizes, rates = (engine.attributes.get(name, default) for name, default in HARMONIC)
    if not (are_numbers(sizes) and are_numbers(rates)):
        return []
    return [
        Motion(tuple(a * (k == axis) for k in range(3)), 2.0 * math.pi * f)
        for axis, (a, f) in enumerate(zip(sizes, rates, strict=False))
    ]


def circling(engine: Instance, down: Direction | None) -> Motion:
    """That of ``BicyclePedalEngine``, which moves all points on circles across an axis: its part along gravity."""
    radius, rate = engine.attributes.get("radius"), engine.attributes.get("angularVelocity", 0.0)
    axis = vector(engine.attributes.get("rotationAxis", X_AXIS))
    if (
        axis is None
        or not any(axis)
        or down is None
        or radius is None
        or not is_number(radius)
        or not is_number(rate)
    ):
        return UNKNOWN
    along = sum(a * b for a, b in zip(axis, down, strict=True)) / math.hypot(*axis)
    size = abs(radius) * math.sqrt(max(1.0 - along * along, 0.0))
    return Motion(tuple(size * part for part in down), abs(float(rate)))


def angular_velocity(engine: Instance) -> Direction | None:
    """That of ``RotationEngine``; None if it is not known."""
    along, rate = vector(engine.attributes.get("rotationAxis")), engine.attributes.get("angularVelocity")
    if along is None or not any(along) or rate is None or not is_number(rate):
        return None
    return tuple(float(rate) * part / math.hypot(*along) for part in along)


def are_numbers(values: Any) -> TypeGuard[list[float] | tuple[float, ...]]:
    """Whether this is a list of known numbers."""
    return isinstance(values, list | tuple) and all(isinstance(x, int | float) for x in values)
