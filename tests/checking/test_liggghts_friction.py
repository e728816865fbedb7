"""Friction in scripts of LIGGGHTS: β of the numbers read, against runs of LIGGGHTS; what is said of it."""

import csv
import importlib
import math
import random
import shutil
import sys
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
    for table in tomllib.loads((HERE / "data/liggghts_friction.toml").read_text(encoding="utf-8"))["script"]
}
MODELS = {model.name: model for model in liggghts.MODELS}
with (HERE.parent / "data/liggghts_friction.csv").open(encoding="utf-8") as file:
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
    tools = str(HERE.parents[1] / "tools")
    if tools not in sys.path:
        sys.path.append(tools)
    return importlib.import_module("verify_liggghts_friction")


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
    """Its normal force. In two dimensions, LIGGGHTS takes disks."""
    bodies = [
        KnownBody(
            radius, density * math.pi * radius**2 * (1.0 if script["dimension"] == 2 else 4.0 / 3.0 * radius)
        )
        for radius, density in zip(script["radii"], script["densities"], strict=True)
    ]
    first, second = (bodies[1], None) if script["types"][1] == "wall" else bodies
    known = force_of(code("liggghts"), contact, None)
    return NormalContact(
        known.written(first, second, script["speed"]), known.numbers, known(first, second, script["speed"])
    )


def restitutions(script, tangents):
    """β with the numbers that are read from a script."""
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
        mass / (1.0 + 1.0 / description.stages[0].grains["1"].inertia_factor),
        speed,
        np.array(tangents) * speed,
    )


def agree(script, tangents, real):
    """Whether each β is that in LIGGGHTS to 2e-3. It may jump where surfaces stick or slip once more."""
    beside = [restitutions(script, np.array(tangents) * factor) for factor in (0.999, 1.0, 1.001)]
    return (np.min(beside, axis=0) - 2e-3 <= real) & (real <= np.max(beside, axis=0) + 2e-3)


@pytest.mark.parametrize("name", SCRIPTS)
def test_restitution_is_that_in_liggghts(name):
    """30 random angles, directions and spins each."""
    tangents, real = MEASURED[name].T
    assert len(real) == 30
    assert agree(SCRIPTS[name], tangents, real).all()


def test_damping_that_outlasts_the_normal_force_is_not_modelled():
    """With kt 0 and limitForce on, LIGGGHTS brakes grains that overlap and do not push each other."""
    script = SCRIPTS["hooke/stiffness history, kt 0"]
    changed = {
        **script,
        "text": script["text"].replace("tangential history", "tangential history limitForce on"),
    }
    with pytest.raises(ValueError, match="kt: got 0 with limitForce on"):
        restitutions(changed, [1.0])


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("liggghts"), reason="no LIGGGHTS")
@pytest.mark.parametrize("name", SCRIPTS)
def test_restitution_of_other_angles(name):
    """As recorded, at others. With strong damping the phase of the time step decides in a band of 1.5°."""
    draw = random.Random(5)
    tangents = [math.tan(math.radians(draw.uniform(1.0, 85.0))) for _ in range(30)]
    _, real = recorder().measured(SCRIPTS[name], tangents, "other")
    agreeing = agree(SCRIPTS[name], tangents, real)
    assert agreeing.all() or ("strong damping" in name and agreeing.sum() >= 28)


# --- what is said -----------------------------------------------------------------------------------------------

GRAIN = "create_atoms 1 box\nset group all diameter 0.002 density 2500\n"
HEAD = "units si\natom_style granular\nregion box block 0 1 0 1 0 1 units box\ncreate_box {} box\n"
MATERIAL = """
fix m1 all property/global youngsModulus peratomtype 1e7
fix m2 all property/global poissonsRatio peratomtype 0.3
fix m3 all property/global coefficientRestitution peratomtypepair 1 {e}
fix m4 all property/global coefficientFriction peratomtypepair 1 {mu}
fix m5 all property/global characteristicVelocity scalar 1
fix m6 all property/global coefficientRollingFriction peratomtypepair 1 {roll}
fix m7 all property/global coefficientRollingViscousDamping peratomtypepair 1 {viscous}
fix m8 all property/global kn peratomtypepair 1 1e4
fix m9 all property/global kt peratomtypepair 1 {kt}
fix m10 all property/global gamman{absolute} peratomtypepair 1 {gamman}
fix m11 all property/global gammat{absolute} peratomtypepair 1 {gammat}
"""
NUMBERS = {
    "e": 0.8,
    "mu": 0.5,
    "roll": 0.1,
    "viscous": 0.3,
    "gamman": 9,
    "gammat": 4,
    "kt": 8e3,
    "absolute": "",
}


MOVE = "fix i all nve/sphere\n"


def script_of(model, **numbers):
    """One material, one type of grains."""
    return (
        HEAD.format(1)
        + MATERIAL.format(**(NUMBERS | numbers))
        + f"pair_style gran {model}\n{GRAIN}{MOVE}run 9\n"
    )


def said(model, **numbers):
    """The warnings."""
    return [note.what for note in read(script_of(model, **numbers)).warnings]


@pytest.mark.parametrize(
    "model,numbers,name,read_numbers",
    [
        ("model hooke tangential history", {}, "hooke history", {"ktToKnUser": None}),
        (
            "model hooke tangential history ktToKnUser on tangential_damping off",
            {},
            "hooke history",
            {"ktToKnUser": 1.0, "tangential_damping": 0.0},
        ),
        ("model hooke tangential no_history", {"mu": 0}, "hooke no_history", {"coefficient": 0.0}),
        ("model hertz tangential history", {}, "hertz history", {"coefficient": 0.5}),
        (
            "model hooke/stiffness tangential history",
            {},
            "hooke/stiffness history",
            {"stiffness": 8e3, "damping": 4.0},
        ),
        (
            "model hooke/stiffness tangential no_history absolute_damping on",
            {"absolute": "_abs"},
            "hooke/stiffness no_history",
            {"stiffness": 8e3, "absolute_damping": 4.0},
        ),
        (
            "model hertz/stiffness tangential history tangential_damping on",
            {},
            "hertz/stiffness history",
            {"damping": 4.0, "tangential_damping": 1.0},
        ),
    ],
)
def test_words_and_numbers(model, numbers, name, read_numbers):
    description = read(script_of(model, **numbers))
    force = description.stages[0].contacts[0].tangential
    assert force.model == name and read_numbers.items() <= force.numbers.items() and not description.unknown
    assert set(force.numbers) <= set(MODELS[name].numbers)


def test_shear_modulus_is_that_of_two_materials():
    text = f"""{HEAD.format(2)}
fix m1 all property/global youngsModulus peratomtype 1e7 4e7
fix m2 all property/global poissonsRatio peratomtype 0.3 0.1
fix m3 all property/global coefficientRestitution peratomtypepair 2 0.9 0.9 0.9 0.9
fix m4 all property/global coefficientFriction peratomtypepair 2 0.1 0.2 0.2 0.3
pair_style gran model hertz tangential history
fix w all wall/gran model hertz tangential history primitive type 2 zplane 0
{GRAIN}create_atoms 2 box
run 1
"""
    contacts = read(text).stages[0].contacts
    numbers = {
        contact.types: contact.tangential.numbers for contact in contacts if contact.types != ("2", "wall")
    }

    def modulus(*moduli_and_ratios):
        return 1.0 / sum(2.0 * (2.0 - nu) * (1.0 + nu) / e for e, nu in moduli_and_ratios)

    hard, soft = (4e7, 0.1), (1e7, 0.3)
    expected = {
        ("1", "1"): (0.1, (soft, soft)),
        ("1", "2"): (0.2, (soft, hard)),
        ("2", "2"): (0.3, (hard, hard)),
        ("1", "wall"): (0.2, (soft, hard)),
    }
    assert {
        types: (row["coefficient"], pytest.approx(row["shear_modulus"])) for types, row in numbers.items()
    } == {types: (mu, modulus(*pair)) for types, (mu, pair) in expected.items()}


@pytest.mark.parametrize(
    "model,numbers,part",
    [
        ("model hertz tangential custom", {}, "tangential custom"),
        ("model hooke tangential tan_luding", {}, "tangential tan_luding"),
        ("model hertz tangential history rolling_friction magic", {}, "rolling_friction magic"),
    ],
)
def test_what_is_not_known_is_quoted(model, numbers, part):
    description = read(script_of(model, **numbers))
    assert [quote.part for quote in description.unknown] == [part]
    assert (description.stages[0].contacts[0].tangential is None) == (part.split()[0] == "tangential")


@pytest.mark.parametrize("name", ["coefficientFriction", "kt", "gammat"])
def test_without_a_number_the_tangential_force_is_not_known(name):
    text = script_of("model hooke/stiffness tangential history").replace(f"global {name} ", "global other ")
    assert read(text).stages[0].contacts[0].tangential is None


SLIDING = "model {} tangential history {}"


@pytest.mark.parametrize(
    "model,numbers,words",
    [
        (SLIDING.format("hooke", ""), {}, ["k_t = k_n", "spring alone", "limitForce off", "steps fall"]),
        (SLIDING.format("hooke", "ktToKnUser off limitForce on"), {}, ["k_t = k_n", "spring alone"]),
        (SLIDING.format("hooke", "ktToKnUser on limitForce on"), {"e": 0.9}, ["spring alone"]),
        (SLIDING.format("hooke", "ktToKnUser on"), {"e": 1}, []),
        (SLIDING.format("hertz", "tangential_damping off"), {}, ["without γ_t", "limitForce off"]),
        (SLIDING.format("hertz", "limitForce on"), {}, ["spring alone"]),
        (SLIDING.format("hertz", ""), {"mu": 0}, []),
        (SLIDING.format("hertz/stiffness", ""), {}, ["spring alone", "limitForce off", "steps fall"]),
        (SLIDING.format("hertz", ""), {}, ["spring alone", "limitForce off"]),
        (SLIDING.format("hooke/stiffness", ""), {"gammat": 0, "gamman": 0}, []),
        (
            SLIDING.format("hooke/stiffness", "absolute_damping on"),
            {"absolute": "_abs", "gamman": 0},
            ["spring alone"],
        ),
        ("model hooke tangential no_history limitForce on", {}, ["no spring"]),
        ("model hertz tangential no_history limitForce on", {"e": 1}, ["no tangential force"]),
        (
            "model hertz tangential no_history",
            {},
            ["no spring", "limitForce off"],
        ),
        (
            "model hooke/stiffness tangential no_history limitForce on tangential_damping off",
            {},
            ["no tangential force"],
        ),
        (
            SLIDING.format("hooke/stiffness", "limitForce on"),
            {"kt": 0},
            ["kt is 0: the damping is not limited"],
        ),
        (SLIDING.format("hooke/stiffness", ""), {"kt": 0, "gammat": 0, "gamman": 0}, ["no tangential force"]),
        ("model hertz tangential off", {}, []),
        ("model hertz", {}, []),
    ],
)
def test_traps(model, numbers, words):
    """k_t = k_n; no spring; no damping while surfaces slip; limits in the attractive tail."""
    notes = said(model, **numbers)
    assert len(notes) == len(words)
    assert all(word in note for word, note in zip(words, notes, strict=True))


@pytest.mark.parametrize(
    "words,numbers,what",
    [
        ("cdt", {}, "of 0.1 R_eff J_n against ω_i − ω_j across the normal, and at most what stops it"),
        ("cdt torsionTorque on", {"roll": 0.25}, "of 0.25 R_eff J_n against ω_i − ω_j, and at most what"),
        (
            "epsd2",
            {},
            "of up to 0.1 R_eff J_n against ω_i − ω_j across the normal, and its spring may reverse",
        ),
        ("epsd", {}, "and more by its dashpot"),
        ("epsd", {"viscous": 0}, "of up to 0.1 R_eff J_n against ω_i − ω_j across the normal"),
        ("cdt", {"roll": 0}, ""),
        ("off", {}, ""),
    ],
)
def test_rolling_friction(words, numbers, what):
    """Its angular impulse in one collision."""
    notes = said(f"model hertz tangential off rolling_friction {words}", **numbers)
    assert [what in note for note in notes] == [True] * bool(what)


ROLLING = """
units si
atom_style granular
atom_modify map array
boundary f f f
newton off
communicate single vel yes
region box block -0.05 0.05 -0.05 0.05 -0.05 0.05 units box
create_box 1 box
neighbor 0.0005 bin
fix m1 all property/global youngsModulus peratomtype 1e8
fix m2 all property/global poissonsRatio peratomtype 0.3
fix m3 all property/global coefficientRestitution peratomtypepair 1 0.8
fix m4 all property/global coefficientRollingFriction peratomtypepair 1 0.1
fix m5 all property/global coefficientRollingViscousDamping peratomtypepair 1 0.3
pair_style gran model hertz tangential off rolling_friction {kind}
pair_coeff * *
create_atoms 1 single 0 0 0 units box
create_atoms 1 single 0 0 0.002000001 units box
set atom 1 diameter 0.002 density 2500 omegax {spin}
set atom 2 diameter 0.002 density 2500 vz -0.01 omegax -{spin}
"""


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("liggghts"), reason="no LIGGGHTS")
@pytest.mark.parametrize(
    "kind,spin,low,high",
    [
        ("cdt", 50.0, 0.999, 1.001),
        ("cdt", 0.5, 0.0, 0.445),  # all of the spin
        ("epsd2", 50.0, 0.9, 1.02),
        ("epsd", 50.0, 5.0, 9.0),  # by its dashpot
    ],
)
def test_spin_that_rolling_friction_takes(kind, spin, low, high):
    """The change of angular momentum over μ_r R_eff J_n, as the warnings say."""
    text = ROLLING.format(kind=kind, spin=spin)
    rows = recorder().velocities_after(text, 10000, 5e-8)
    mass, radius = 4.0 / 3.0 * math.pi * 1e-9 * 2500.0, 1e-3
    impulse = mass * abs(rows[0, 2])
    assert rows[0, 3] == pytest.approx(-rows[1, 3], abs=1e-6) and rows[0, 3] > -1e-6
    lost = 0.4 * mass * radius**2 * (spin - rows[0, 3])
    assert low <= lost / (0.1 * 0.5 * radius * impulse) <= high


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("liggghts"), reason="no LIGGGHTS")
@pytest.mark.parametrize("words,low,high", [("", 0.1, 0.2), (" limitForce on", 0.0, 2e-3)])
def test_time_steps_that_decide_on_restitution(words, low, high):
    """Where F_n changes its sign, stick and slip alternate, and the next step decides."""
    script = SCRIPTS["hooke history, ktToKnUser on, strong damping"]
    script |= {"text": script["text"].replace("ktToKnUser on", f"ktToKnUser on{words}")}
    tangents = [math.tan(math.radians(angle)) for angle in np.linspace(70.0, 80.0, 30)]
    runs = [script | {"time_step": script["time_step"] * k, "steps": 8000} for k in (3.0, 3.03, 3.1)]
    values = np.array([recorder().measured(run, tangents, "same")[1] for run in runs])
    assert low <= np.max(np.ptp(values, axis=0)) <= high


def test_a_trap_names_the_types_and_the_statement():
    text = f"""{HEAD.format(2)}
fix m1 all property/global youngsModulus peratomtype 1e7 4e7
fix m2 all property/global poissonsRatio peratomtype 0.3 0.1
fix m3 all property/global coefficientRestitution peratomtypepair 2 0.9 0.9 0.9 1
fix m4 all property/global coefficientFriction peratomtypepair 2 0 0.2 0.2 0.3
fix m5 all property/global characteristicVelocity scalar 1
pair_style gran model hooke tangential history limitForce on tangential_damping off
fix w all wall/gran model hertz tangential no_history primitive type 1 zplane 0 limitForce on
{GRAIN}create_atoms 2 box
{MOVE}run 1
"""
    notes = [(note.what.split()[0], note.types, note.quote.line) for note in read(text).warnings]
    assert notes == [
        ("k_t", ("1", "2"), 11),
        ("tangential_damping", ("1", "2"), 11),
        ("tangential", ("2",), 12),
    ]


@pytest.mark.parametrize(
    "dimension,fix,factor",
    [(3, "nve/sphere", 0.4), (2, "nve/sphere", 0.5), (3, "nve", math.inf), (3, "multisphere", 0.4)],
)
def test_moment_of_inertia(dimension, fix, factor):
    """LIGGGHTS takes grains in two dimensions as disks."""
    text = f"dimension {dimension}\n" + script_of("model hertz tangential history").replace("nve/sphere", fix)
    assert read(text).stages[0].grains["1"].inertia_factor == factor
