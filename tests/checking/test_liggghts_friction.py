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


def restitutions(force, terms, speed, slips, steps=6000):
    """β of spheres, by small steps of the contact with a fixed normal."""
    elastic, damping = 0.25 * force.powers.elastic, 0.25 * force.powers.damping
    step = force.collision(speed).duration / steps
    mass, x, v = force.effective_mass, 0.0, speed
    slip, spring = np.array(slips), np.zeros(len(slips))

    def push(x, v):
        value = force.stiffness * x**elastic + force.damping * x**damping * v
        return value if force.powers.attracts else max(value, 0.0)

    def half(x, v, dt):  # explicit midpoint
        middle = max(x + 0.5 * dt * v, 0.0), v - 0.5 * dt * push(x, v) / mass
        return x + dt * middle[1], v - dt * push(*middle) / mass

    while True:
        new, rate = half(x, v, step)
        if new <= 0.0:
            return -slip / slips
        power = 0.5 * (terms.loading if new > x else terms.unloading)
        spring *= (new / x) ** power if x > 0.0 else 1.0
        spring += terms.stiffness * (0.5 * (x + new)) ** (0.25 * terms.stiffness_power) * slip * step
        x, v = new, rate
        limit = terms.coefficient * abs(push(x, v))
        drag = terms.damping * x ** (0.25 * terms.damping_power) * slip
        held = np.clip(spring, -limit, limit)
        friction = np.where(held != spring, held, held + drag)
        if terms.limit == 0:  # without a spring
            friction = np.clip(drag, -limit, limit)
        spring = held
        slip = slip - step * friction / (mass / 3.5)


@pytest.mark.parametrize("name", SCRIPTS)
def test_restitution_is_that_in_liggghts(name):
    """30 random angles, directions and spins each."""
    script = SCRIPTS[name]
    description, contact = contact_of(script)
    assert not description.unknown
    normal = normal_contact(contact, script)
    terms = MODELS[contact.tangential.model].terms(contact.tangential.numbers, normal)
    tangents, real = MEASURED[name].T
    assert len(real) == 30
    got = restitutions(normal.force, terms, script["speed"], tangents * script["speed"])
    assert got == pytest.approx(real, abs=2e-3)


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("liggghts"), reason="no LIGGGHTS")
@pytest.mark.parametrize("name", SCRIPTS)
def test_restitution_of_other_angles(name):
    """As recorded, at angles that were not."""
    script, draw = SCRIPTS[name], random.Random(5)
    tangents = [math.tan(math.radians(draw.uniform(1.0, 85.0))) for _ in range(30)]
    _, real = recorder().measured(script, tangents, "other")
    _, contact = contact_of(script)
    normal = normal_contact(contact, script)
    terms = MODELS[contact.tangential.model].terms(contact.tangential.numbers, normal)
    got = restitutions(normal.force, terms, script["speed"], np.array(tangents) * script["speed"])
    assert got == pytest.approx(real, abs=2e-3)
