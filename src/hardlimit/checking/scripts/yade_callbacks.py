"""Functions that a YADE script runs during a simulation, and whether they change the scene."""

from __future__ import annotations

import ast
import re
import textwrap
from collections.abc import Collection
from typing import Any, Final

from .python import Evaluator, Instance
from .reader import names

#: Attributes that change only tangential forces.
TANGENTIAL: Final = names("""
frictionAngle frictAngle tangensOfFrictionAngle et es ks cs betas nonLin krot ktwist eta includeMoment mR mRtype alphaKr
alphaKtw etaRoll etaTwist momentRotationLaw always_use_moment_law inertia
""")
#: Those that change the normal force of contacts.
OF_CONTACTS: Final = names("""
young poisson en betan kn cn tc damping isDamped mat material engines isCohesive normalCohesion setCohesionNow
setCohesionOnNewContacts hertzian functors SPHmode
""")
#: Those that change contacts, grains or time steps while the script runs.
CHANGING: Final = (
    OF_CONTACTS
    | TANGENTIAL
    | names("density densityScaling gravity radius mass dynamic blockedDOFs dt active dead velGrad")
)
#: Calls that change bodies, or add forces to those of contacts.
FORCE_METHODS: Final = names("addF setPermF addForce addT setPermT addTorque addMove addRot")
TOUCHING: Final = FORCE_METHODS | names(
    "toSimulation growParticles growParticle load loadTmp reload reset setContactFriction"
)
#: Attributes that change what presses a bed.
OF_BEDS: Final = names("engines gravity radius mass density densityScaling dynamic blockedDOFs")
#: Attributes that change the stresses that a controller prescribes, or the axes along which it does.
OF_STRESSES: Final = names("""
goal goal1 goal2 goal3 sigma1 sigma2 sigma3 stressMask stresses sigmaIsoCompaction sigmaLateralConfinement
stressControl_1 stressControl_2 stressControl_3 target
""")
#: Functions that run a text that is not read.
HIDDEN: Final = ("exec", "execfile", "runpy", "run_path", "run_module", "import_module", "__import__")
#: Attributes of states: of walls, they move them.
PLACED: Final = ("vel", "angVel", "pos", "ori", "velGrad", "trsf")


def touches(part: ast.AST) -> bool:
    """Whether statements change contacts, bodies, engines or the time step."""
    return _changes(part, CHANGING - {"dead"}, (".bodies", ".materials"), frozenset())


def fills(part: ast.AST, again: bool = False) -> bool:
    """Whether statements change which bodies there are, their masses, or what pulls them, not only their contacts.

    ``again``: whether the script itself runs them as well, so that it is known where they append bodies.
    """
    known = {"append", "appendClumped"} if again else set()
    return _changes(part, OF_BEDS, (".bodies",), frozenset({"setContactFriction", "erase"} | known))


def appends(part: ast.AST) -> bool:
    """Whether statements append bodies."""
    return fills(part) and not fills(part, again=True)


def _changes(
    part: ast.AST, attributes: Collection[str], owners: tuple[str, ...], harmless: Collection[str]
) -> bool:
    """Whether statements set one of these attributes, or call what may, such as a method of these owners."""
    for node in ast.walk(part):
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        if any(isinstance(each, ast.Attribute) and each.attr in attributes for each in targets):
            return True
        if isinstance(node, ast.Call):
            owner, _, name = ast.unparse(node.func).rpartition(".")
            if name not in harmless and (name in TOUCHING or name in HIDDEN or owner.endswith(owners)):
                return True
    return False


def moves(part: ast.AST) -> bool:
    """Whether statements set places or velocities of bodies."""
    return _sets(part, PLACED)


def stresses(part: ast.AST) -> bool:
    """Whether statements set the stresses that a controller prescribes."""
    return _sets(part, OF_STRESSES)


def _sets(part: ast.AST, attributes: Collection[str]) -> bool:
    targets = [node for node in ast.walk(part) if isinstance(node, ast.Attribute)]
    return any(node.attr in attributes and isinstance(node.ctx, ast.Store) for node in targets)


def commands_of(engine: Instance) -> list[Any]:
    """What an engine runs: the command of a PyRunner, and what a controller runs when it is done."""
    hooks = [value for name, value in engine.attributes.items() if name.endswith("Hook") and value]
    return [engine.argument(0, "command", ""), *hooks] if engine.name == "PyRunner" else hooks


def parts_of(script: Evaluator, command: str) -> list[ast.AST]:
    """The functions that a command runs, and the command itself if it is understood."""
    pending, named = [command], dict[str, ast.FunctionDef]()
    while pending:
        new = script.functions.keys() & set(re.findall(r"\w+", pending.pop())) - named.keys()
        named |= {name: script.functions[name] for name in new}
        pending += [script.source(script.functions[name]) for name in new]
    try:
        return [*named.values(), ast.parse(textwrap.dedent(command))]
    except SyntaxError:
        return [*named.values()]


def uncalled(script: Evaluator) -> list[ast.FunctionDef]:
    """Functions that were not run here, although the script may run them."""
    named = {node.id for node in ast.walk(script.tree) if isinstance(node, ast.Name)}
    methods = [method for each in script.classes.values() for method in each.values()]
    functions = [*(function for name, function in script.functions.items() if name in named), *methods]
    return [function for function in functions if function not in script.executed]
