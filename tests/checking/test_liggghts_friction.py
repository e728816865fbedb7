"""Friction in scripts of LIGGGHTS: β of the numbers read, against runs of LIGGGHTS; what is said of it."""

import csv
import importlib.util
import math
import random
import shutil
import tomllib
from pathlib import Path

import numpy as np
import pytest

from hardlimit.checking.cases import force_of
from hardlimit.checking.contacts import KnownBody
from hardlimit.checking.scripts import read
from hardlimit.contact.impact import tangential_restitution
from hardlimit.convert.codes import code
from hardlimit.convert.tangential import NormalContact, liggghts

HERE = Path(__file__).parent
SCRIPTS = {
    table["name"]: table
    for table in tomllib.loads((HERE / "data/friction_liggghts.toml").read_text(encoding="utf-8"))["script"]
}
MODELS = {model.name: model for model in liggghts.MODELS}
with (HERE.parent / "data/friction_liggghts.csv").open(encoding="utf-8") as file:
    ROWS = list(csv.DictReader(file))
MEASURED = {
    name: np.array(
        [
            [float(row["tan_angle"]), float(row["tangential_restitution"])]
            for row in ROWS
            if row["script"] == name
        ]
    )
    for name in SCRIPTS
}


def recorder():
    """The tool that runs LIGGGHTS."""
    path = HERE.parents[1] / "tools/verify_liggghts_friction.py"
    spec = importlib.util.spec_from_file_location("verify_liggghts_friction", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def contact_of(script, text=None):
    """The contact that a script is about."""
    if text is None:
        tool = recorder()
        placed = tool.bodies(script, [1.0], random.Random(1))
        text = script["text"].replace("{grains}", tool.grains(script, placed)) + tool.RUN.format(**script)
    description = read(text)
    return description, next(
        row for row in description.stages[0].contacts if list(row.types) == script["types"]
    )


def normal_contact(contact, script):
    """Its normal force."""
    bodies = [
        KnownBody(radius, 4.0 / 3.0 * math.pi * radius**3 * density)
        for radius, density in zip(script["radii"], script["densities"], strict=True)
    ]
    first, second = (bodies[1], None) if script["types"][1] == "wall" else bodies
    known = force_of(code("liggghts"), contact, None)
    return NormalContact(
        known.written(first, second, script["speed"]), known.numbers, known(first, second, script["speed"])
    )


def restitutions(script, tangents):
    """β of spheres with the numbers that are read from a script."""
    description, contact = contact_of(script)
    assert not description.unknown
    normal, speed = normal_contact(contact, script), script["speed"]
    terms = MODELS[contact.tangential.model].terms(contact.tangential.numbers, normal)
    mass = normal.force.effective_mass
    return tangential_restitution(
        normal.force.powers.arguments,
        normal.force.stiffness,
        normal.force.damping,
        mass,
        terms,
        mass / 3.5,
        speed,
        np.array(tangents) * speed,
    )


def agree(script, tangents, real):
    """Whether β is that in LIGGGHTS to 2e-3. It may jump where surfaces stick or slip once more."""
    beside = [restitutions(script, np.array(tangents) * factor) for factor in (0.999, 1.0, 1.001)]
    return np.all((np.min(beside, axis=0) - 2e-3 <= real) & (real <= np.max(beside, axis=0) + 2e-3))


@pytest.mark.parametrize("name", SCRIPTS)
def test_restitution_is_that_in_liggghts(name):
    """30 random angles, directions and spins each."""
    tangents, real = MEASURED[name].T
    assert len(real) == 30
    assert agree(SCRIPTS[name], tangents, real)


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("liggghts"), reason="no LIGGGHTS")
@pytest.mark.parametrize("name", SCRIPTS)
def test_restitution_of_other_angles(name):
    """As recorded, at angles that were not."""
    draw = random.Random(5)
    tangents = [math.tan(math.radians(draw.uniform(1.0, 85.0))) for _ in range(30)]
    _, real = recorder().measured(SCRIPTS[name], tangents, "other")
    assert agree(SCRIPTS[name], tangents, real)
