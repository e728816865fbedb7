"""What is noted of the engines and materials of a YADE scene, beside its contacts."""

from __future__ import annotations

import ast
from typing import Final

from .description import Note, Stage
from .python import Evaluator, Instance
from .reader import names
from .yade_callbacks import commands_of, parts_of, touches, uncalled
from .yade_contacts import LUBRICATED, PHYSICS, UNDAMPED_LAWS
from .yade_scene import MATERIALS, Scene, is_active

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
STICKY: Final = names("Coh JCFpm Cpm Wire Cap Luding Mortar")
#: Those of other forces than a spring and a dashpot.
OTHER_FORCES: Final = {
    "Lubrication": LUBRICATED,
    "Bubble": "contacts of bubbles (Bubble)",
    "CDM": "contacts that yield (CDM)",
}
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
#: Those of a fluid, which carries a part of the weight.
FLUIDS: Final = ("", "drag of a fluid", "a fluid", "buoyancy")
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
#: Engines that change neither contacts nor grains.
ENGINES: Final = names("""
ForceResetter InsertionSortCollider SpatialQuickSortCollider FlatGridCollider InteractionLoop NewtonIntegrator PyRunner
PeriodicPythonRunner PeriodicEngine DomainLimiter SnapshotEngine BoxFactory CircularFactory GravityEngine
GlobalStiffnessTimeStepper ResetRandomPosition IntrCallback ParallelEngine BoundDispatcher
""")


def force_of(engine: str) -> str:
    """What force an engine adds beside contacts, in words; empty if it adds none."""
    return next((what for sign, what in FORCES.items() if sign in engine), "")


def notes(scene: Scene, script: Evaluator) -> None:
    """What is in the engines beside normal contacts."""
    bodies = scene.bodies
    lone = len(bodies) == 1 and len(scene.spheres()) == 1
    if lone and not (bodies[0].several or scene.elsewhere):
        scene.ignore("only one sphere: its contact is that with another like it", bodies[0].quote)
    scene.unknown |= {body.quote: None for body in bodies if body.kind == "boxes" and not body.frozen}
    known = [material for material in scene.materials if material.name in MATERIALS]
    for instance in dict.fromkeys([*scene.used(""), *known]):
        quote, name = scene.at(instance), instance.name
        if instance.attributes.get("densityScaling", False):  # other masses than those of the grains
            scene.unknown[quote] = None
        strange = instance.attributes.keys() - {"**", *ATTRIBUTES[name].split()} if name in ATTRIBUTES else ()
        if strange:
            scene.unknown[quote] = None
            scene.refuse(quote, f"have known words, not {', '.join(sorted(strange))}")
        runner_note(scene, script, instance)
        if name.startswith(("Ip2_", "Law2_")) or (name.endswith("Mat") and name[:1].isupper()):
            contact_note(scene, instance)
        elif name in MOTION:
            scene.ignore(f"prescribed motion ({name})", quote)
        elif name == "GlobalStiffnessTimeStepper" and is_active(instance):
            scene.ignore("a time step that adapts (GlobalStiffnessTimeStepper)", quote)
        elif instance in scene.engines and name != "PyRunner":
            what = force_of(name)
            if what:
                scene.invalidate(f"{what} ({name})", quote)
            elif name not in ENGINES and not name.endswith("Recorder"):
                scene.unknown[quote] = None


def contact_note(scene: Scene, instance: Instance) -> None:
    """A material, functor or law that has other forces, or is not understood."""
    name, quote, attributes = instance.name, scene.at(instance), instance.attributes
    law, force = name.startswith("Law2_"), ""
    if any(sign in name for sign in STICKY) and name not in (*MATERIALS, *PHYSICS, *LAWS):
        force = f"adhesion or bonds ({name})"
    elif others := [words for sign, words in OTHER_FORCES.items() if sign in name]:
        force = others[0]
    elif name in (*LAWS, *UNDAMPED_LAWS) and attributes.get("includeAdhesion") not in (None, False, 0):
        force = "adhesion (includeAdhesion)"
    elif name == "ViscElMat" and attributes.get("lubrication", False):
        force = LUBRICATED
        scene.unknown[quote] = None
    if force:
        scene.invalidate(force, quote)
        scene.refuse(quote, f"be without {force}")
    elif name not in (*MATERIALS, *PHYSICS, *LAWS, *UNDAMPED_LAWS):
        scene.unknown[quote] = None
        known = LAWS if law else MATERIALS if name.endswith("Mat") else PHYSICS
        scene.refuse(quote, f"be one of {', '.join(known)}")
    elif law:
        scene.ignore(f"tangential forces ({name})", quote)


def runner_note(scene: Scene, script: Evaluator, runner: Instance) -> None:
    """A callback that changes contacts or grains."""
    commands = [command for command in commands_of(runner) if isinstance(command, str)]
    parts = [part for command in commands for part in parts_of(script, command)]
    script.executed |= {part for part in parts if isinstance(part, ast.FunctionDef)}
    if any(map(touches, parts)):
        scene.unknown[scene.at(runner)] = None


def callbacks(scene: Scene, script: Evaluator) -> None:
    """Functions that were not run here, although the script may run them."""
    for function in uncalled(script):
        if touches(function):
            header = f"def {function.name}({ast.unparse(function.args)})"
            scene.unknown[scene.quote(function.lineno, header)] = None


def missing_engines(scene: Scene) -> None:
    """Engines without which nothing moves or forces are never reset."""
    if (quote := scene.engines_quote) is None:
        return
    for part in ("ForceResetter", "Integrator"):
        if not any(part in engine.name for engine in scene.engines):
            scene.unknown[scene.quote(quote.line, f"no {part} in {quote.text}")] = None


ON_SPINS: Final = "acts on spins as well, along each axis"


def damping_note(scene: Scene, stage: Stage) -> None:
    """What the damping of the integrator does to friction."""
    damping = stage.numerical_damping
    for note in [note for note in scene.warnings if ON_SPINS in note.what]:
        del scene.warnings[note]  # of a run before
    if damping and any(contact.friction != 0.0 for contact in stage.contacts):
        integrators = scene.used("NewtonIntegrator")
        quote = scene.at(integrators[-1]) if integrators else None
        what = f"the damping {damping:g} of NewtonIntegrator {ON_SPINS}"
        scene.warnings[Note(f"{what}: β is without it", None, quote)] = None


#: Words of a script that flips a sheared cell, or lets its spheres be larger than YADE accepts.
FLIPPED: Final = ("flipCell", "flipFlippable", "allowBiggerThanPeriod")
#: Strain of a periodic cell up to which none needs to be flipped.
UNFLIPPED: Final = 1.0


def flip_note(scene: Scene, script: Evaluator, stage: Stage) -> None:
    """A periodic cell that is sheared on and on, which YADE refuses once its spheres span half of a side.

    The box around a sphere grows with the inclination of the cell; 2023.02a stops with ``Body larger than half of the
    cell size encountered``, seen between strains of 2.0 and 2.5 in a cell that is seven diameters wide.
    """
    if not stage.shear_rate or scene.strain is None or any(word in script.text for word in FLIPPED):
        return
    known = stage.steps is not None and stage.time_step is not None and script.repeats == 0
    if known and stage.shear_rate * (stage.steps or 0) * (stage.time_step or 0.0) <= UNFLIPPED:
        return
    what = "a cell that is sheared beyond a strain of about 2 must be flipped (O.cell.flipFlippable = True)"
    why = "else YADE stops once the box around a sphere exceeds half of a side"
    scene.warnings[Note(f"{what}: {why}", None, scene.strain[1])] = None


def sides_note(scene: Scene, stage: Stage) -> None:
    """YADE's viscoelastic law adds the velocity of an image in a sheared cell where it must subtract it.

    Seen in 2023.02a with two spheres across a side; grains then slide along the sides as a plug.
    """
    for law in scene.used("Law2_ScGeom_ViscElPhys_Basic") if stage.shear_rate else ():
        what = "ViscElPhys has the velocity of images in a sheared cell with the wrong sign"
        which = "contacts across its sides are wrong, those of FrictPhys are not"
        scene.warnings[Note(f"{what}: {which}", None, scene.at(law))] = None
