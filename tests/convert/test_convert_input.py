"""convert_back as a reader: each code's words, comments, continued lines, quotes, variables and units; what is printed
is read back for every model and contact; what is not understood is quoted with its line."""

import math
import re

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

import hardlimit as hl
from conftest import draws, log_floats, slow
from hardlimit.boxes.lammps import integration_error
from hardlimit.checking.scripts.formulas import NUMBER
from hardlimit.cli import main
from hardlimit.convert import texts
from hardlimit.convert.codes import Pair, code, names
from hardlimit.convert.force import Force, Powers, damping_for

BALL = hl.Ball(radius=5e-4, density=7850.0)
BED = [hl.Ball(radius=r, density=2500.0) for r in (5e-4, 1e-3)]
STEEL = {"youngs_modulus": 2.1e11, "poisson_ratio": 0.3}
MODELS = [(c.name, m.name) for c in map(code, names()) for m in c.models]
#: One model of each code; to find the constants for Kratos takes seconds.
FIRST = [(c.name, c.models[0].name) for c in map(code, names()) if c.name != "kratos"]


def back(text, name="lammps", ball=BALL, **more):
    return hl.convert_back(text, ball, code=name, **more)


def refused(text, name="lammps", **more):
    with pytest.raises(ValueError) as caught:
        back(text, name, **more)
    line = str(caught.value)
    assert "\n" not in line
    return line


# --- there and back -------------------------------------------------------------------------------------------

#: Contacts of a bed of two sizes and a wall, by their names in a code's input.
NAMES = {
    "liggghts": ["1-1", "1-2", "2-2", "1-wall", "2-wall"],
    "yade": ["1-1", "1-2", "2-2", "1-3", "2-3"],
    "mercurydpm": ["species_1_1", "species_1_2", "species_2_2", "species_1_wall", "species_2_wall"],
    "mujoco": ["ball1-ball1", "ball1-ball2", "ball2-ball2", "ball1-floor", "ball2-floor"],
}


@pytest.mark.parametrize("name,model", [m if m in FIRST else slow(*m) for m in MODELS])
@draws(3)
@given(
    restitution=st.floats(0.15, 0.99),
    speed=log_floats(0.02, 10.0),
    duration=st.booleans(),
    attraction=st.booleans(),
)
def test_the_text_of_a_bed_is_read_back(name, model, restitution, speed, duration, attraction):
    """Every contact that the text holds, by its name: the same ε, numbers and duration as were written."""
    found = code(name).model(model)
    stiff = {"stiffness": 1e5} if found.elastic == "hooke" else STEEL
    restitution = 1.0 if found.damping.formula == "none" else restitution
    given_as = (
        {"duration": 2e-5, "law": "linear" if found.elastic == "hooke" else "tsuji"} if duration else stiff
    )
    options = {"restitution_error": 0.05, "attraction": attraction, **given_as}
    made = hl.convert(BED, restitution=restitution, speed=speed, code=name, model=model, **options)
    rows = made.models[0].contacts
    live = [line for line in made.text.splitlines() if not line.startswith(code(name).comment)]
    every = NAMES.get(name, NAMES["liggghts"])
    once = "choose those of one" in made.text and not found.input.apart
    for row, contact in zip(rows, every, strict=True):
        if row.numbers is None:
            continue  # the code cannot have this ε
        wall = row.pair.endswith("wall")
        first, second = (int(x) for x in re.findall(r"\d", row.pair + row.pair[0] * wall))
        bodies = {"ball": BED[first - 1], "other": hl.FLOOR if wall else BED[second - 1], "speed": speed}
        if once or found.input.shared:
            own = [f"{row.numbers[n]:.12g}" for n in row.numbers]
            if not all(any(number in line for line in live) for number in own):
                continue  # commented out
            named = (found.input.matrix and "types 1" in made.text) or (found.input.apart and wall)
            contact = contact if named else None
        elif found.input.once and not all(f"{row.numbers[n]:.12g}" in "\n".join(live) for n in row.numbers):
            continue
        again = back(made.text, name, contact=contact, **bodies)
        assert again.model is found and again.numbers == pytest.approx(row.numbers, rel=1e-11)
        assert again.restitution == pytest.approx(row.restitution, abs=1e-9)
        assert again.numerical_damping == 0.0 and not again.notes


@pytest.mark.parametrize("name", [n if n in ("lammps", "yade") else slow(n) for n in names()])
def test_a_contact_that_is_not_named_is_asked_for(name):
    """Where contacts have different numbers: their names are listed, and each of them is understood."""
    for found in code(name).models:
        if found.input.shared and not found.input.matrix:
            continue
        asked = {"stiffness": 1e5} if found.elastic == "hooke" else STEEL
        text = hl.convert(
            BED, restitution=0.7, code=name, model=found.name, restitution_error=0.05, **asked
        ).text
        try:
            back(text, name)
        except ValueError as error:
            listed = re.fullmatch(
                r"contact: missing, must be one of (.*), which have different numbers in the input",
                str(error),
            )
            assert listed, error
            for one in listed[1].split(", "):
                assert back(text, name, contact=one).model is found
            assert back(text, name, contact=one.replace("-", " – ")).model is found
        assert re.match(r"contact: got '7-9', must be one of .", refused(text, name, contact="7-9"))


def test_ranges_of_types_are_those_of_lammps():
    """A later line overrides an earlier one; the order of types does not matter."""
    text = """
pair_style granular
pair_coeff * * hooke 1e5 0.5 damping coeff_restitution tangential linear_nohistory 0 0
pair_coeff 2*3 4 hooke 1e5 0.6 damping coeff_restitution tangential linear_nohistory 0 0
pair_coeff 4 1 hooke 1e5 0.7 damping coeff_restitution tangential linear_nohistory 0 0
group small type 1
fix a small wall/gran granular hooke 1e5 0.8 damping coeff_restitution tangential none zplane 0 NULL
fix b all wall/gran granular hooke 1e5 0.9 damping coeff_restitution tangential none zplane NULL 1
"""
    for contact, gives in (
        ("1-1", 0.5),
        ("4-4", 0.5),
        ("2-4", 0.6),
        ("4-3", 0.6),
        ("1-4", 0.7),
        ("4–1", 0.7),
    ):
        assert back(text, contact=contact).restitution == pytest.approx(gives, abs=1e-9)
    assert (
        refused(text)
        == "contact: missing, must be one of *-*, 2*3-4, 1-4, which have different numbers in the input"
    )


def test_a_wall_is_not_taken_for_balls():
    line = "fix w all wall/gran hooke 1e5 NULL 2e4 NULL 0.5 0 zplane 0 NULL"
    assert refused(line) == "input: got no contact of balls, only *-w"
    assert back(line, other=hl.FLOOR).model.name == "gran-hooke"
    pairs = "pair_style granular\npair_coeff * * hooke 1e5 0.7 damping coeff_restitution tangential none"
    for text in (f"{line}\n{pairs}", f"{pairs}\n{line}"):
        assert back(text, other=hl.FLOOR).model.name == "gran-hooke"
        assert back(text).restitution == pytest.approx(0.7, abs=1e-9)
    late = refused(f"{line} limit_damping", other=hl.FLOOR)
    assert late.startswith("input: line 1: got 'fix w all") and late.endswith(
        "must have limit_damping before zplane"
    )


WALLS = {
    "lammps": """group small type 1
fix a small wall/gran granular hooke 1e5 0.8 damping coeff_restitution zplane 0 NULL
fix b all wall/gran granular hooke 1e5 0.9 damping coeff_restitution xplane 0 NULL""",
    "liggghts": """fix m1 all property/global kn peratomtypepair 2 1e5 1e5 1e5 1e5
fix m2 all property/global gamman peratomtypepair 2 1e3 2e3 2e3 1e3
fix a all wall/gran model hooke/stiffness primitive type 1 zplane 0
fix b all wall/gran model hooke/stiffness limitForce on primitive type 2 xplane 0""",
}


@pytest.mark.parametrize(
    "name,after,choices",
    [
        ("lammps", "", "1-a, *-b"),
        ("lammps", "unfix b", None),
        ("lammps", "fix b all wall/gran granular hooke 1e5 0.8 damping coeff_restitution zplane 0 1", None),
        ("liggghts", "", "1-a, 1-b"),
        ("liggghts", "unfix b", None),
        ("liggghts", "fix b all wall/gran model hooke/stiffness primitive type 1 xplane 0", None),
        (
            "liggghts",
            "unfix b\nfix c all mesh/surface file c type 2\nfix d all mesh/surface file d type 1\n"
            "fix a all wall/gran model hooke/stiffness mesh n_meshes 2 meshes c d",
            "1-c, 1-d",
        ),
    ],
)
def test_walls_are_told_apart_by_their_names(name, after, choices):
    """Another fix of the same name replaces a wall."""
    text = f"{WALLS[name]}\n{after}"
    if choices is None:
        contact = "1-wall" if name == "liggghts" else None
        numbers = back(text, name, other=hl.FLOOR, contact=contact).numbers
        assert 0.8 in numbers.values() or 1e3 in numbers.values()
        return
    line = f"must be one of {choices}, which have different numbers in the input"
    assert refused(text, name, other=hl.FLOOR, contact="1-wall") == f"contact: got '1-wall', {line}"
    assert refused(text, name, other=hl.FLOOR).startswith("contact: missing")
    first, second = (back(text, name, other=hl.FLOOR, contact=one) for one in choices.split(", "))
    assert first.numbers != second.numbers
    if "unfix" not in after:
        named = text.replace("fix b", "fix wall")
        assert back(named, name, other=hl.FLOOR, contact="1-wall").numbers == second.numbers


# --- the words of LAMMPS and LIGGGHTS ---------------------------------------------------------------------------

HOOKE = [
    "pair_coeff",
    "1",
    "1",
    "hooke",
    "1e5",
    "0.7",
    "damping",
    "coeff_restitution",
    "tangential",
    "linear_nohistory",
    "1.0",
    "0.4",
    "limit_damping",
]
HERTZ = [
    "fix",
    "m3",
    "all",
    "property/global",
    "coefficientRestitution",
    "peratomtypepair",
    "2",
    "0.7",
    "0.7",
    "0.7",
    "0.7",
]


@st.composite
def formatted(draw, words):
    """The words of a command with any blanks, quotes, continued lines, comments and variables."""
    before, line = (
        draw(st.sampled_from(["", "# hooke 1e5 0.1 limit_damping\n", "\n\t\n", "print 'a # b'\n"])),
        "",
    )
    for k, word in enumerate(words):
        kind = draw(st.sampled_from(["plain", "plain", "single", "double", "variable", "string", "formula"]))
        number = NUMBER.fullmatch(word) and k > 2
        if kind in ("single", "double"):
            word = f"'{word}'" if kind == "single" else f'"{word}"'
        elif kind == "variable" and number:
            before += f"variable x{k} equal {word}*2/2 # {word}\n"
            word = f"${{x{k}}}"
        elif kind == "string" and k:
            before += f"variable x{k}\tstring {word}\n"
            word = f"${{x{k}}}"
        elif kind == "formula" and number and "e" not in word and "." in word:
            before += f"variable {chr(97 + k)} index {word} 3.0\n"
            word = draw(st.sampled_from([f"$({word}+0)", f"${chr(97 + k)}"]))
        elif draw(st.integers(0, 9)) == 0 and kind == "plain" and len(word) > 2:
            word = f"{word[:2]}&\n{word[2:]}"
        line += word + draw(st.sampled_from([" ", "\t", "   ", " &\n", " & \t\n\t", "\t&\n"]))
    tail = draw(
        st.sampled_from(["", "# no limit_damping", "#& .", "# damping tsuji limitForce off cohesion sjkr2"])
    )
    return (before + line + tail).replace("\n", draw(st.sampled_from(["\n", "\r\n"])))


@draws(60)
@given(text=formatted(HOOKE))
def test_the_form_of_a_lammps_command_does_not_matter(text):
    found = back(text)
    assert found.model.name == "hooke-restitution" and not found.attraction
    assert found.restitution == pytest.approx(0.7182013610, abs=1e-8)


@draws(60)
@given(
    text=formatted(HERTZ),
    model=formatted(["pair_style", "gran", "model", "hertz", "tangential", "history", "limitForce", "on"]),
)
def test_the_form_of_a_liggghts_command_does_not_matter(text, model):
    """A matrix of two types, whose lines are continued."""
    moduli = "fix m1 all property/global youngsModulus peratomtype 1e9 &\n1e9\n"
    rest = f"{moduli}fix m2 all property/global poissonsRatio peratomtype .3 .3\n"
    found = back(f"{model}\n{rest}{text}", "liggghts")
    assert not found.attraction and found.restitution == pytest.approx(0.7182013610, abs=1e-8)


@pytest.mark.parametrize(
    "text,gives",
    [
        ("hooke 1e5 0.7 damping coeff_restitution # no limit_damping", 0.7),
        (
            "# comment &\nhooke 1e5 0.1 damping coeff_restitution\nhooke 1e5 0.7 damping coeff_restitution",
            0.7,
        ),
        ("hooke 1e&\n5 0.7 damping coeff_&\nrestitution", 0.7),
        ("HOOKE 1 2\nhooke 1e5 0.7 damping coeff_restitution", 0.7),
        ('print """\nhooke 1e5 0.1 damping tsuji # not &\n"""\nhooke 1e5 0.7 damping coeff_restitution', 0.7),
        ("variable e index 0.7\nvariable e index 0.1\nhooke 1e5 ${e} damping coeff_restitution", 0.7),
        ("variable e string 0.1\nvariable e string 0.7\nhooke 1e5 $e damping coeff_restitution", 0.7),
        (
            "variable a equal 2^0.5\nvariable e equal v_a*v_a*0.35\nhooke 1e5 $e damping coeff_restitution",
            0.7,
        ),
        ("hooke 1e5 $(sqrt(0.49):%.3f) damping coeff_restitution", 0.7),
        ("\ufeffhooke 1e5 0.7 damping coeff_restitution", 0.7),
    ],
)
def test_words_are_those_of_lammps(text, gives):
    assert back(text).restitution == pytest.approx(gives, abs=1e-9)


@pytest.mark.parametrize(
    "text,name,quoted",
    [
        (
            "units si\nunits lj\nhooke 1e5 .7 damping velocity",
            "lammps",
            "line 2: got 'units lj', must be units si, cgs",
        ),
        (
            "variable e index .5 .7\nhooke 1e5 ${e} damping coeff_restitution\nnext e\njump SELF",
            "lammps",
            "line 2: got 'hooke 1e5 ${e} damping coeff_restitution', must have a number for restitution, not ${e}",
        ),
        ("if '1 > 0' then 'units cgs'", "lammps", "must be commands of the text itself"),
        ("if '1 > 0' then 'include a.in'", "lammps", "must be commands of the text itself"),
        (
            "label a\nif '1 > 0' then 'jump SELF a' else 'jump SELF b'\npair_coeff * * hooke 1e5 .7\nlabel b",
            "lammps",
            "line 3: got 'pair_coeff * * hooke 1e5 .7', must be a command that no jump skips",
        ),
        ("units real", "liggghts", "line 1: got 'units real', must be units si, cgs"),
        (
            "pair_style hybrid granular gran/hooke 1 1 1 1 1 1",
            "lammps",
            "line 1: got 'pair_style hybrid granular",
        ),
        (
            "\n\npair_coeff * * jkr 1e9 .7 .3 10 tangential none",
            "lammps",
            "line 3: got 'jkr 1e9', must be words of pair granular",
        ),
        ("pair_coeff * * hooke 1e5 .7 damping nothing", "lammps", "line 1: got 'damping nothing'"),
        ("pair_coeff * * hooke 1e5 .7 Damping velocity", "lammps", "line 1: got 'Damping velocity'"),
        ("pair_coeff * * hooke 1e5 .7 damping velocity & # c\n", "lammps", "line 1: got '&'"),
        (
            "pair_coeff * * hooke ${k} .7 damping velocity",
            "lammps",
            "line 1: got 'pair_coeff * * hooke ${k} .7 damping velocity', "
            "must have a number for stiffness, not ${k}",
        ),
        (
            "pair_coeff * * hooke 1e5 $(1/0) damping velocity",
            "lammps",
            "must have a number for damping, not $(1/0)",
        ),
        (
            "pair_coeff * * hooke 1e5 $(2**2) damping velocity",
            "lammps",
            "must have a number for damping, not $(2**2)",
        ),
        (
            "pair_coeff * * hooke 1d5 .7 damping velocity",
            "lammps",
            "must have a number for stiffness, not 1d5",
        ),
        (
            "pair_coeff * * hooke 1e5",
            "lammps",
            "line 1: got 'pair_coeff * * hooke 1e5', must have 2 words after hooke",
        ),
        ("pair_coeff * * hooke 1 '.7 damping", "lammps", "must close its quotes '"),
        ("include other.in", "lammps", "line 1: got 'include other.in', must be commands of the text itself"),
        ("if '1 > 0' then 'pair_coeff * * hooke 1e5 .7'", "lammps", "must be commands of the text itself"),
        (
            "pair_style gran/hooke 1e5 NULL 1e3 NULL 0.5",
            "lammps",
            "must be hooke, hooke/history, hertz/history with six numbers",
        ),
        (
            "pair_style gran/hooke 1e5 NULL 1e3 NULL 0.5 1 limit_dampin",
            "lammps",
            "line 1: got 'limit_dampin'",
        ),
        (
            "pair_style gran model hertz cohesion sjkr2",
            "liggghts",
            "got 'cohesion sjkr2', must be cohesion off",
        ),
        ("pair_style gran model hooke viscous on", "liggghts", "got 'viscous on', must be viscous off"),
        (
            "pair_style gran model hertz limitforce on",
            "liggghts",
            "got 'limitforce on', must be a setting of model hertz",
        ),
        (
            "fix w all wall/gran model hertz primitive type 1 zplane 0.0 cohesion sjkr",
            "liggghts",
            "got 'cohesion sjkr'",
        ),
        (
            "fix m all property/global kn peratomtypepair 2 1 2 3",
            "liggghts",
            "must be a number of types and one number for each",
        ),
        ("FrictMat(young=1e9,\n poisson=.3", "yade", "line 1: got 'FrictMat(young=1e9,', must be Python"),
        (
            "FrictMat(young=1e9, poisson=.3, cohesion=3)",
            "yade",
            "line 1: got 'cohesion=3.0', must be one of young, poisson",
        ),
        ("CohFrictMat(young=1e9, poisson=.3)", "yade", "line 1: got 'CohFrictMat(young=1"),
        (
            "Ip2_FrictMat_FrictMat_MindlinPhys(en=.7, gamma=1.)",
            "yade",
            "line 1: got 'gamma=1.0', must be one of en, betan",
        ),
        (
            "FrictMat(young=E, poisson=.3)\nIp2_FrictMat_FrictMat_MindlinPhys(en=.7)",
            "yade",
            "must have a number for youngs_modulus, not E",
        ),
        (
            "newton.damping = 0.1",
            "yade",
            "line 1: got 'newton.damping = 0.1', must be given in the constructor",
        ),
        ("NewtonIntegrator(damping=d)", "yade", "must have a number in [0, 1) for damping"),
        (
            "Law2_ScGeom_MindlinPhys_Mindlin(includeAdhesion=True)",
            "yade",
            "line 1: got 'Law2_ScGeom_MindlinPhys_Mindlin(includeAdhesion=True)'",
        ),
        (
            "mat->SetKn(1e5);\nmat->SetAdhesion(1.0);",
            "chrono",
            "line 2: got 'SetAdhesion(1.0)', must be without adhesion",
        ),
        (
            "sys.UseMaterialProperties(false);\nsys.SetContactForceModel(ChSystemSMC::Hooke);\nmat->SetKn(k);\nmat->SetGn(3.0);",
            "chrono",
            "line 3: got 'SetKn(k)', must have a number for stiffness, not k",
        ),
        (
            "EW_YOUNG = 1e9\nVW_POISSON = 0.3\nE_YOUNG(1) = "
            "2e9\nV_POISSON(1)=0.3\nDES_COLL_MODEL='HERTZIAN'\n"
            "DES_EN_WALL_INPUT(1) = 0.7",
            "mfix",
            "line 1: got 'EW_YOUNG = 1e9', must be as on line 3",
        ),
    ],
)
def test_what_is_not_understood_is_quoted_with_its_line(text, name, quoted):
    line = refused(text, name, other=hl.FLOOR if name == "mfix" else None)
    assert quoted in line and line.startswith("input: line ")


@pytest.mark.parametrize(
    "lines,known",
    [
        ('variable k equal 1e4\nif "${soft} == 1" then "variable k equal 1e2"', False),
        ("variable k equal 1e4\nif '1 > 0' then 'print x' else &\n 'variable k equal 1e2'", False),
        ('variable b equal 2\nvariable k equal v_b*5e3\nif "1 > 0" then "variable b equal 3"', False),
        ('variable k index 1e4 2e4\nif "1 > 0" then "next k"', False),
        ('variable k index 1e4 2e4\nif "1 > 0" then "next a k"', False),
        ('variable k equal 1e4\nrun 100 every 10 "variable k equal 1e3"', False),
        ("variable k equal 1e4\nlabel a\nvariable k equal 2*${k}\njump SELF a", False),
        ("variable k equal 1e4\nvariable k equal 2*${k}\njump SELF", False),
        ('variable k equal 5\nif "1>0" then "jump SELF a"\nvariable k equal 1e4\nlabel a', False),
        ("variable k equal 5\nvariable k equal 1e4\nlabel a\nvariable b equal 2\njump SELF a", True),
        ("label a\nvariable k equal 1e4\nnext i\njump SELF a", True),
        ('variable k equal 1e4\nif "1 > 0" then "print k" "variable b equal 2"', True),
        ('variable k equal 1e4\nif "1 > 0" then "jump SELF" else "print k"', True),
    ],
)
def test_variables_that_depend_on_loops_and_conditions_are_not_taken(lines, known):
    text = f"{lines}\npair_style granular\npair_coeff * * hooke ${{k}} 0.7 damping coeff_restitution"
    if known:
        assert back(text).numbers["stiffness"] == 1e4
    else:
        assert refused(text).endswith("must have a number for stiffness, not ${k}")


@pytest.mark.parametrize(
    "text,same",
    [
        (
            "hertz/material 1e9 0.7 0.3 tangential mindlin NULL 1 .4",
            "hertz/material 1e9 0.7 0.3 damping viscoelastic",
        ),
        ("pair_coeff 1 * hertz 1e8 1e6", "hertz 1e8 1e6 damping viscoelastic limit_damping"),
        ("pair_style gran/hooke 1e5 NULL 2e4 NULL 0.5 1", "hooke 1e5 2e4 damping mass_velocity"),
        ("pair_style gran/hooke/history/omp 1e5 NULL 2e4 NULL 0.5 1", "hooke 1e5 2e4 damping mass_velocity"),
        ("pair_style gran/hertz/history 1e8 NULL 1e6 NULL 0.5 1", "hertz 1e8 1e6 damping viscoelastic"),
        ("units cgs\nhooke 1e8 1e4 damping velocity", "hooke 1e5 10. damping velocity"),
        ("units cgs\nhertz/material 1e10 1e4 .3", "hertz/material 1e9 1e6 .3"),
        ("units cgs\npair_style gran/hertz/history 1e9 NULL 1e4 NULL 0.5 1", "hertz 1e8 1e6"),
        ("units micro\nhooke 1e8 1e2 damping mass_velocity", "hooke 1e5 1e8 damping mass_velocity"),
    ],
)
def test_common_inputs_of_lammps(text, same):
    one, other = back(text), back(same)
    limited = "limit_damping" in same
    if limited:
        assert one.attraction and not other.attraction
    else:
        assert one.restitution == pytest.approx(other.restitution, abs=1e-12)
    assert one.duration == pytest.approx(other.duration, rel=1e-12 if not limited else 0.1)


def test_units_are_those_of_the_whole_command():
    """LIGGGHTS in cgs: modulus and characteristic speed; the duration tells the stiffness."""
    text = """
units {}
pair_style gran model hooke limitForce on
fix m1 all property/global youngsModulus peratomtype {}
fix m2 all property/global poissonsRatio peratomtype 0.3
fix m3 all property/global coefficientRestitution peratomtypepair 1 0.7
fix m4 all property/global characteristicVelocity scalar {}
"""
    si, cgs = (back(text.format(*given), "liggghts") for given in (("si", 1e8, 2.0), ("cgs", 1e9, 200.0)))
    assert cgs.numbers == pytest.approx(si.numbers) and cgs.duration == pytest.approx(si.duration, rel=1e-12)


# --- YADE -------------------------------------------------------------------------------------------------------

MINDLIN = """O.materials.append(FrictMat(young=1e9, poisson=.3, frictionAngle=.5, density=2600))
Ip2_FrictMat_FrictMat_MindlinPhys(en=.7)"""


def braked(p, q, damping, share, steps):
    """ε of m dv/dt = −(x^p + C x^q v)(1 ± d): an independent solution by equal steps of the midpoint rule."""
    x, v, dt = 0.0, 1.0, 4.0 / steps

    def acceleration(x, v):
        force = x**p + damping * x**q * v if x > 0.0 else 0.0
        return -max(force, 0.0) * (1.0 + share if v > 0.0 else 1.0 - share)

    for k in range(10 * steps):
        half_x, half_v = x + 0.5 * dt * v, v + 0.5 * dt * acceleration(x, v)
        x, v = x + dt * half_v, v + dt * acceleration(half_x, half_v)
        if v < 0.0 and k > 10 and acceleration(x, v) == 0.0:
            return -v
    raise AssertionError


@pytest.mark.parametrize("share", [0.2, 0.05, 0.7])
def test_numerical_damping_of_yade(share):
    """Hertz and linear: our two phases against equal steps, and √((1 − d)/(1 + d)) for elastic contacts."""
    for p, q in ((4, 0), (6, 1)):
        for e in (0.9, 0.5):
            damping = damping_for(Powers(p, q), e)
            force = Force(Powers(p, q), 1.0, damping, 1.0)
            found = force.numerically_damped(1.0, share).restitution
            assert found == pytest.approx(braked(p / 4, q / 4, damping, share, 1000), abs=2e-3)
            assert found == pytest.approx(e * math.sqrt((1 - share) / (1 + share)), abs=0.02)
        elastic = Force(Powers(p, q), 1.0, 0.0, 1.0).numerically_damped(1.0, share)
        assert elastic.restitution == pytest.approx(math.sqrt((1 - share) / (1 + share)), abs=1e-9)
        assert math.isnan(elastic.duration)


def test_numerical_damping_is_read_and_said():
    without = back(MINDLIN, "yade")
    assert without.numerical_damping == 0.0 and without.restitution == pytest.approx(0.6998, abs=1e-4)
    assert "its default, 0.2, gives ε = 0.572" in without.notes[0]
    none = back(f"{MINDLIN}\nO.engines=[NewtonIntegrator(damping=0, gravity=(0,0,-9.81))]", "yade")
    assert none.restitution == without.restitution and not none.notes
    default = back(f"{MINDLIN}\nO.engines=[ForceResetter(), NewtonIntegrator()]", "yade")
    assert default.numerical_damping == 0.2 and default.restitution == pytest.approx(0.5725, abs=2e-4)
    assert default.restitution == pytest.approx(0.6998 * math.sqrt(0.8 / 1.2), abs=2e-3)
    assert default.to_dict()["numerical_damping"] == 0.2 and "wall" in default.notes[0]
    for model in code("yade").models:
        assert "NewtonIntegrator(damping=0)" in model.input.foot


@pytest.mark.parametrize(
    "text,model,gives",
    [
        (f"# NewtonIntegrator()\n{MINDLIN}", "hertz-en", 0.6998),
        (
            "E = 1e9\nnu, e = .3, .7\n"
            + MINDLIN.replace("1e9", "E").replace("=.3", "=nu").replace("en=.7", "en=e"),
            "hertz-en",
            0.6998,
        ),
        (MINDLIN.replace("en=.7", "betan=0.1"), "hertz-betan", None),
        (MINDLIN.replace("en=.7", "en=MatchMaker(matches=((0, 0, .7),))"), "hertz-en", 0.6998),
        (MINDLIN.replace("en=.7", ""), "hertz-betan", 1.0),
        (MINDLIN.replace("Mindlin", "Frict").replace("en=.7", ""), "frict", 1.0),
        (
            "m=ViscElMat(tc=1e-4*10, en=.7, et=1., density=2600, frictionAngle=radians)",
            "viscel-tc-en",
            0.7182,
        ),
        ("O.materials.append(ViscElMat(kn=1e5, ks=1e5, cn=2*5., cs=0))", "viscel", None),
    ],
)
def test_common_inputs_of_yade(text, model, gives):
    found = back(text, "yade")
    assert found.model.name == model
    if gives is not None:
        assert found.restitution == pytest.approx(gives, abs=2e-4)


@pytest.mark.parametrize(
    "materials,given,refusal",
    [
        (("FrictMat(young=1e7, poisson=.3)", "FrictMat(young=1e9, poisson=.3)"), "", True),
        (("FrictMat(young=1e7, poisson=.3)", "FrictMat(young=1e7, poisson=.3)"), "", False),
        (("ViscElMat(tc=1e-4, en=.9)", "ViscElMat(tc=3e-4, en=.7)"), "", True),
        (("ViscElMat(tc=1e-4, en=.9)", "ViscElMat(tc=1e-4, en=.7)"), "", False),
        (("ViscElMat(tc=1e-4, en=.9)", "ViscElMat(tc=3e-4, en=.7)"), "tc=2e-4, ", False),
    ],
)
def test_a_contact_of_two_materials_that_differ_is_refused(materials, given, refusal):
    functor = "FrictMat_FrictMat_MindlinPhys" if "Frict" in materials[0] else "ViscElMat_ViscElMat_ViscElPhys"
    matches = "(0, 0, .9), (0, 1, .5), (1, 1, .3)"
    lines = [*materials, f"Ip2_{functor}({given}en=MatchMaker(matches=[{matches}]))"]
    text = "\n".join(lines)
    assert back(text, "yade", contact="1-1").numbers["restitution"] == 0.9
    if not refusal:
        assert back(text, "yade", contact="1-2").numbers["restitution"] == 0.5
        return
    assert refused(text, "yade", contact="1-2") == "contact: got '1-2', must be one of 1-1, 2-2"
    alone = refused(text.replace(matches, "(0, 1, .5)"), "yade")
    assert alone.startswith("input: line 3: got 'Ip2_")
    assert alone.endswith("must match materials with the same numbers")


def test_frictphys_has_the_spring_of_yade():
    """kn = 2 E r1 E r2/(E r1 + E r2); undamped: the duration is π√(m/k); and the "
    "default numerical damping alone brakes."""
    text = "FrictMat(young=2e7, poisson=.2)\nIp2_FrictMat_FrictMat_FrictPhys()\nNewtonIntegrator()"
    found = back(text.replace("NewtonIntegrator()", ""), "yade", BED[0], other=BED[1])
    stiffness = 2.0 * 2e7 * 5e-4 * 1e-3 / 1.5e-3
    mass = BED[0].mass * BED[1].mass / (BED[0].mass + BED[1].mass)
    assert found.restitution == pytest.approx(1.0, abs=1e-12)
    assert found.duration == pytest.approx(math.pi * math.sqrt(mass / stiffness), rel=1e-9)
    assert back(text, "yade").restitution == pytest.approx(math.sqrt(0.8 / 1.2), abs=1e-9)


def test_names_whose_value_is_not_certain_are_not_taken():
    for lines in (
        "e = .7\nif x:\n    e = .5\n",
        "for e in x:\n    pass\n",
        "e = .7\ne += x\n",
        "e = .7\nwhile e > .5:\n    e -= .1\n",
        "e = random()\n",
    ):
        assert "number for restitution, not " in refused(lines + MINDLIN.replace("en=.7", "en=e"), "yade")


@pytest.mark.parametrize(
    "lines,stiffness",
    [
        ("double k = 1e4*log(std::exp(2));", 2e4),
        ("double k = 1e4*std::log10(100.);", 2e4),
        ("double k = 1e4*std::floor(-2.5 + 5);", 2e4),
        ("double n = 10, k = 1e4*n/4;", 2.5e4),
        ("int n = 2.5; double k = 1e4*n;", 2e4),
        ("this->k = 1e4; cfg.k = k; if (k == 2) f(k, x && k);", 1e4),
        ("double k = 1e4; k = 1e4;", 1e4),
        *(
            (lines, None)
            for lines in (
                "double k = 1e4; k *= 2;",
                "double k = 1e4; k += 2e4;",
                "int n = 1; n++; double k = 1e4*n;",
                "int n = 1; --n; double k = 1e4*n;",
                "double k = 1e4; k = 2e4;",
                "double k = 2e4; if (x) k = 1e4;",
                "double k = 1e4; cfg.k = 9e9;",
                "cfg->k = 9e9;",
                "double k = 1e4; read(&k);",
                "double k = 1e4; std::cin >> k;",
                "double k = 1e4; void f(double k) {",
                "double k = 1e4; void f(double& k) {",
                "double k = 1e4; { double k{2e4};",
                "for (int k = 1; k < 3; x())",
                "int n = 3; double k = 1e4*(n/2);",
                "auto n = 3; double k = 1e4*(n/2);",
                "double k = 1e4*(3/2);",
                "double k = 10^4;",
                "double k = 1e4*ln(10.);",
                "double k = 1e4*table.round(1.);",
            )
        ),
    ],
)
def test_variables_of_cpp_have_one_value(lines, stiffness):
    text = f"{lines}\nspecies->setStiffness(k); species->setDissipation(0.01);"
    if stiffness is not None:
        assert back(text, "mercurydpm").numbers["stiffness"] == pytest.approx(stiffness, rel=1e-12)
    else:
        line = refused(text, "mercurydpm")
        assert line == "input: line 2: got 'setStiffness(k)', must have a number for stiffness, not k"


def test_settings_of_one_owner_are_not_those_of_another():
    """Those of the system, which no other owner has, hold for all."""
    hertz = "sys.SetContactForceModel(ChSystemSMC::Hertz); a->SetYoungModulus(1e7); a->SetPoissonRatio(.3);"
    both = f"{hertz} a->SetRestitution(.9); b->SetRestitution(.5);"
    assert back(both, "chrono", contact="a").numbers["youngs_modulus"] == 1e7
    lacks = "; hertz lacks SetYoungModulus {youngs_modulus}, SetPoissonRatio {poisson_ratio}"
    assert refused(both, "chrono", contact="b").endswith(lacks)
    whole = f"{both} b->SetYoungModulus(1e8); b->SetPoissonRatio(.2);"
    assert back(whole, "chrono", contact="b").numbers["youngs_modulus"] == 1e8
    springs = "a->setStiffness(1e5); a->setDissipation(.1); b->setDissipation(.02);"
    assert back(springs, "mercurydpm", contact="a").numbers["damping"] == 0.1
    assert "linear lacks setStiffness" in refused(springs, "mercurydpm", contact="b")


@pytest.mark.parametrize(
    "lines,modulus",
    [
        ("E = 1e8\ndef f(a, y=E, *, z=2*E): return a*(y + z)\nE = 1e5\nE = f(1)", 3e8),
        ("import numpy as n, math\nE = 1e8*n.round(2.2)*math.floor(1.5)", 2e8),
        ("E = 1e8*foo.round(2)", None),
        ("E = 1e8*foo.e", None),
        ("E = 1e8*foo().range(3)", None),
    ],
)
def test_arithmetic_of_yade_scripts(lines, modulus):
    text = f"{lines}\n{MINDLIN.replace('1e9', 'E')}"
    if modulus is None:
        assert "must have a number for youngs_modulus, not 1" in refused(text, "yade")
    else:
        assert back(text, "yade").numbers["youngs_modulus"] == modulus


# --- what is printed --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", ["gran-hooke", "gran-hertz"])
def test_the_wall_of_gran_styles_is_live(model):
    """Pairs and walls have numbers of their own: a grain that falls meets the wall."""
    found = code("lammps").model(model)
    asked = {"stiffness": 1e5} if found.elastic == "hooke" else {"duration": 1e-5, "law": "viscoelastic"}
    made = hl.convert(BALL, restitution=0.7, code="lammps", model=model, **asked)
    live = [line for line in made.text.splitlines() if not line.startswith("#")]
    assert any(line.startswith("pair_style gran/") for line in live)
    assert any(line.startswith("fix floor1 type1 wall/gran") for line in live)
    for other in (None, hl.FLOOR):
        assert back(made.text, other=other).restitution == pytest.approx(0.7, abs=1e-9)


@pytest.mark.parametrize("balls", [[BALL], BED])
def test_the_wall_itself_is_never_a_comment(balls):
    """Whatever numbers are to be chosen, of every code that writes a wall."""
    for name in ("lammps", "liggghts"):
        for model in code(name).models:
            asked = {"stiffness": 1e5} if model.elastic == "hooke" else {**STEEL}
            text = hl.convert(
                balls, restitution=0.7, code=name, model=model.name, restitution_error=0.05, **asked
            ).text
            walls = [line for line in text.splitlines() if "wall/gran" in line]
            assert walls and not any(line.startswith("#") for line in walls)


def test_liggghts_is_told_of_hard_and_soft_particles():
    """It refuses Young's moduli above 1e9 and below 5e6 Pa without a command."""
    for modulus, line in ((2.1e11, "hard_particles yes"), (1e8, ""), (1e6, "soft_particles yes")):
        made = hl.convert(
            BALL, restitution=0.7, code="liggghts", model="hertz", youngs_modulus=modulus, poisson_ratio=0.3
        )
        said = [x for x in made.text.splitlines() if x.endswith("_particles yes")]
        assert said == ([line] if line else [])
    slack = hl.convert(BALL, restitution=0.02, code="liggghts", model="hertz", **STEEL).models[0].contacts[0]
    assert slack.numbers is None and math.isnan(slack.restitution)  # coefficientRestitution must exceed 0.05


def test_mujoco_refuses_grains_that_are_too_light():
    """Inertia below mjMINVAL: both ways, with the reason; a table of all codes leaves it out."""
    light, heavy = hl.Ball(radius=1e-4, density=7850.0), hl.Ball(radius=2e-4, density=7850.0)
    why = r"^radius \| mass: got a ball with a moment of inertia of 1\.32e-16 kg m², must be > 1e-15 kg m² in MuJoCo"
    with pytest.raises(ValueError, match=why):
        hl.convert([heavy, light], restitution=0.7, stiffness=1e3, code="mujoco")
    with pytest.raises(ValueError, match=why):
        back('solref="-1e9 -100"', "mujoco", light)
    assert hl.convert(heavy, restitution=0.7, stiffness=1e3, code="mujoco").text
    codes = {one.code.name for one in hl.convert(light, restitution=0.7, stiffness=1e3).models}
    assert "mujoco" not in codes and "lammps" in codes


# --- the step that is printed -----------------------------------------------------------------------------------


@draws(20)
@given(
    powers=st.sampled_from([(4, 0), (4, 2), (6, 0), (6, 1), (6, 2)]),
    attracts=st.booleans(),
    restitution=st.floats(0.02, 0.999),
    error=log_floats(3e-4, 3e-2),
    share=st.sampled_from([1.0, 1.0, 0.97, 0.93, 0.9]),
)
def test_the_step_keeps_to_its_error_wherever_bodies_touch(powers, attracts, restitution, error, share):
    """At 1500 places between two steps, and with somewhat finer steps too."""
    form = Powers(*powers, attracts)
    force = Force(form, 1.0, damping_for(form, restitution), 1.0)
    step = share * integration_error.longest_step(force, 1.0, error)
    steps = force.collision(1.0).duration / step
    if steps < 1500.0:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(integration_error, "PHASES", (np.arange(1500) + 0.5) / 1500)
            assert integration_error.restitution_error(force, 1.0, step) <= error


@draws(20)
@given(step=st.floats(1e-9, 1e-3))
def test_the_step_is_not_rounded_up(step):
    found = code("lammps").model("hooke-velocity")
    pair = Pair("1 – 1", BALL.mass, BALL.radius, False)
    text = texts.written(code("lammps"), found, [(pair, {"stiffness": 1e5, "damping": 1.0})], False, step)
    said = float(text.splitlines()[-1].split()[1])
    assert 0.998 * step <= said <= step


# --- the command line -------------------------------------------------------------------------------------------


def test_the_command_line_selects_a_contact():
    text = hl.convert(BED, restitution=0.7, stiffness=1e5, code="liggghts", model="hooke-stiffness").text
    sizes = (
        "convert",
        "--radius",
        "0.5mm",
        "--radius",
        "1mm",
        "--density",
        "2500",
        "--code",
        "liggghts",
        "--input",
        text,
    )
    out = CliRunner().invoke(main, [*sizes, "--contact", "1-2"])
    assert out.exit_code == 0 and "0.7" in out.stdout
    out = CliRunner().invoke(main, [*sizes])
    assert out.exit_code == 2 and "contact: missing, must be one of 1-1, 1-2" in out.stderr
    out = CliRunner().invoke(
        main, ["convert", *sizes[1:7], "--restitution", "0.7", "--stiffness", "1", "--contact", "1-2"]
    )
    assert out.exit_code == 2 and "contact: must be left out without input" in out.stderr
    out = CliRunner().invoke(
        main, ["convert", *sizes[1:3], "--density", "2500", "--code", "yade", "--input", MINDLIN]
    )
    assert out.exit_code == 0 and "NewtonIntegrator" in out.stdout
