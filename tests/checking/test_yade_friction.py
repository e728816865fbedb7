"""β by the friction that is read from a script of YADE, against that recorded in YADE at random angles of impact."""

import csv
import importlib
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
from hardlimit.contact.friction import FrictionTerms
from hardlimit.contact.impact import tangential_restitution
from hardlimit.convert.codes import code
from hardlimit.convert.tangential import NormalContact
from hardlimit.convert.tangential.yade import MODELS

HERE = Path(__file__).parent
SCRIPTS = {
    table["name"]: table
    for table in tomllib.loads((HERE / "data/yade_friction.toml").read_text(encoding="utf-8"))["script"]
}
with (HERE.parent / "data/yade_friction.csv").open(encoding="utf-8") as file:
    ROWS = list(csv.DictReader(file))
MODEL = {model.name: model for model in MODELS}
#: The damping of YADE uses velocities of half a step before, and its pairs turn.
TOLERANCE = 2e-3


def bodies(stage, contact):
    """The two bodies, the first of which moves; None for a wall."""
    kinds = [stage.grains[name] for name in contact.types if name != "wall"]
    sizes = [(kind, kind.radii[0]) for kind in kinds]
    if kinds[0].fixed is not None:
        sizes[1] = kinds[0].fixed, kinds[0].fixed.radii[0]
    elif len(kinds) == 2 and kinds[0] is kinds[1]:
        sizes[1] = kinds[0], kinds[0].radii[1]
    known = []
    for kind, radius in sorted(sizes, key=lambda each: each[0].frozen):
        mass = 4.0 / 3.0 * math.pi * radius**3 * kind.densities[0]
        counted = mass if kind.counted and kind.frozen else None
        known.append(KnownBody(radius, math.inf if kind.frozen else mass, counted))
    return known if len(known) == 2 else [*known, None]


def normal_force(script):
    """The contact of a script, its two bodies, its force, and what the tangential force depends on."""
    description = read(script["text"])
    stage = description.stages[-1]
    assert not description.unknown
    (contact,) = (each for each in stage.contacts if list(each.types) == script["types"])
    both = bodies(stage, contact)
    model = force_of(code("yade"), contact, None)
    written = model.written(*both, script["speed"])
    force = written.force(model.numbers)
    return contact, both, force, NormalContact(written, model.numbers, force)


def expected(script, angles):
    """β at these angles by our reading of the script."""
    contact, both, normal, known = normal_force(script)
    terms = FrictionTerms(0.0)
    if contact.tangential is not None:
        terms = MODEL[contact.tangential.model].terms(contact.tangential.numbers, known)
        assert terms.coefficient == contact.friction
    inverse = sum(3.5 / body.mass for body in both if body is not None)
    return tangential_restitution(
        normal.powers.arguments,
        normal.stiffness,
        normal.damping,
        normal.effective_mass,
        terms,
        1.0 / inverse,
        script["speed"],
        script["speed"] * np.tan(angles),
    )


@pytest.mark.parametrize("name", SCRIPTS)
def test_tangential_restitution_is_that_in_the_code(name):
    rows = [row for row in ROWS if row["script"] == name]
    angles, measured = (
        np.array([float(row[column]) for row in rows]) for column in ("angle", "tangential_restitution")
    )
    assert len(rows) == 30
    np.testing.assert_allclose(expected(SCRIPTS[name], angles), measured, rtol=0, atol=TOLERANCE)


def test_numbers_that_are_not_given_are_those_of_the_code():
    for name in ("FrictMat, angle and ratio by default", "MindlinPhys betan at a wall"):
        contact, _, _, known = normal_force(SCRIPTS[name])
        terms, of_script = MODEL[contact.tangential.model].terms, dict(contact.tangential.numbers)
        of_script |= {"friction_angle": 0.5, "poisson": 0.25}
        none = dict.fromkeys(MODEL[contact.tangential.model].numbers)
        assert terms(none, known) == terms({}, known) == terms(of_script, known)


def materials(draw, kind, count):
    """Random materials of two, which YADE accepts together."""
    texts = []
    form = draw.choice(("kn", "tc")) if kind == "ViscElMat" else ""
    for _ in range(count):
        numbers = {"density": draw.uniform(1e3, 8e3), "frictionAngle": draw.uniform(0.05, 1.2)}
        if form == "kn":
            ranges = {"kn": (1e4, 1e5), "ks": (3e3, 1e5), "cn": (0.0, 0.8), "cs": (0.0, 0.8)}
        elif form == "tc":
            ranges = {"tc": (1e-4, 3e-4), "en": (0.4, 1.0), "et": (0.2, 1.0)}
        else:
            ranges = {"young": (1e7, 5e7), "poisson": (0.05, 0.5)}
        numbers |= {name: draw.uniform(*ends) for name, ends in ranges.items()}
        texts.append(f"{kind}({', '.join(f'{name}={value:.5g}' for name, value in numbers.items())})")
    return texts


def random_script(draw):
    """A contact of two bodies of random materials, sizes and numbers of the functor."""
    kind, physics, law = draw.choice(
        (
            ("FrictMat", "FrictPhys", "Law2_ScGeom_FrictPhys_CundallStrack"),
            ("FrictMat", "MindlinPhys", "Law2_ScGeom_MindlinPhys_Mindlin"),
            ("ViscElMat", "ViscElPhys", "Law2_ScGeom_ViscElPhys_Basic"),
            ("CohFrictMat", "CohFrictPhys", "Law2_ScGeom6D_CohFrictPhys_CohesionMoment"),
        )
    )
    rigid = physics == "CohFrictPhys"
    other = draw.choice(("sphere", "sphere", "fixed", *(() if rigid else ("Facet", "Wall", "Box"))))
    first, second = draw.uniform(1e-3, 3e-3), draw.uniform(1e-3, 3e-3)
    same = draw.random() < 0.5
    pair = other in ("sphere", "fixed")
    if pair and not same and physics != "MindlinPhys":
        first = second  # or the stiffness of two materials depends on the sizes
    words = []
    if physics == "MindlinPhys":
        words = draw.choice(
            (
                [],
                [f"en={draw.uniform(0.3, 1):.4f}"],
                [f"en={draw.uniform(0.3, 1):.4f}", f"es={draw.uniform(0.3, 1):.4f}"],
                [f"betan={draw.uniform(0, 0.3):.4f}", f"betas={draw.uniform(0, 0.3):.4f}"],
            )
        )
    elif draw.random() < 0.4:
        words = [f"frictAngle={draw.uniform(0.05, 1.2):.4f}"]
    k = 0 if same else 1
    body = {
        "sphere": f"sphere((0, 0, 0), {first!r}, material=0)",
        "fixed": f"sphere((0, 0, 0), {first!r}, fixed=True, material=0)",
        "Facet": f"facet([(-1, -1, 0), (1, -1, 0), (0, 2, 0)], material={k})",
        "Wall": f"wall(0, axis=2, material={k})",
        "Box": f"box((0, 0, -1e-3), (4e-3, 4e-3, 1e-3), fixed=True, material={k})",
    }[other]
    shape = "Sphere" if pair else other
    bounds = ", ".join(dict.fromkeys(("Bo1_Sphere_Aabb()", f"Bo1_{shape}_Aabb()")))
    text = f"""O.materials.append([{", ".join(materials(draw, kind, k + 1))}])
O.bodies.append({body})
O.bodies.append(sphere((0, 0, {first if pair else 0.0!r} + {second!r} + 1e-9), {second!r}, material={k if pair else 0}))
O.engines = [
    ForceResetter(),
    InsertionSortCollider([{bounds}]),
    InteractionLoop(
        [Ig2_{shape}_Sphere_ScGeom{"6D" if rigid else ""}()],
        [Ip2_{kind}_{kind}_{physics}({", ".join(words)})],
        [{law}()]),
    NewtonIntegrator(damping=0),
]
"""
    types = ["0", str(k)] if pair else ["0", "wall"]
    return {"text": text, "types": types, "speed": 1e-5 if physics == "MindlinPhys" else 1e-4}


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("yade") is None, reason="requires YADE")
@pytest.mark.parametrize("seed", range(2))
def test_random_scripts_in_yade(seed, monkeypatch):
    monkeypatch.syspath_prepend(HERE.parents[1] / "tools")
    verify = importlib.import_module("verify_yade_friction")
    script = random_script(random.Random(seed))
    duration = normal_force(script)[2].collision(script["speed"]).duration
    step = float(f"{duration / 2e4:.2g}")
    text = f"{script['text']}O.dt = {step}\nO.run({int(1.3 * duration / step) + 10}, True)\n"
    results = np.array(verify.measured(script | {"text": text, "name": str(seed)}))
    np.testing.assert_allclose(expected(script, results[:, 0]), results[:, 1], rtol=0, atol=TOLERANCE)


def test_every_script_was_measured():
    assert list(dict.fromkeys(row["script"] for row in ROWS)) == list(SCRIPTS)
