"""convert_back as a reader: each code's words, comments, continued lines, quotes, variables and units; what is printed
is read back for every model and contact; what is not understood is quoted with its line."""

import math
import re
from pathlib import Path

import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st
from test_generated import Written

import hardlimit as hl
from conftest import draws, log_floats, slow
from hardlimit.checking.scripts import CODES, read
from hardlimit.checking.scripts.formulas import NUMBER
from hardlimit.cli import main
from hardlimit.convert.codes import code
from hardlimit.convert.force import Force, Powers, damping_for

HERE = Path(__file__).parent
BALL = hl.Ball(radius=5e-4, density=7850.0)
BED = [hl.Ball(radius=r, density=2500.0) for r in (5e-4, 1e-3)]
STEEL = {"youngs_modulus": 2.1e11, "poisson_ratio": 0.3}
MODELS = [(name, model.name) for name in CODES for model in code(name).models]
#: One model of each code.
FIRST = [(name, code(name).models[0].name) for name in CODES]


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
    source = code(name).model(model)
    stiff = {"stiffness": 1e5} if source.elastic == "hooke" else STEEL
    restitution = 1.0 if source.damping.formula == "none" else restitution
    given_as = (
        {"duration": 2e-5, "law": "linear" if source.elastic == "hooke" else "tsuji"} if duration else stiff
    )
    options = {"restitution_error": 0.05, "attraction": attraction, **given_as}
    conversion = hl.convert(BED, restitution=restitution, speed=speed, code=name, model=model, **options)
    rows = conversion.models[0].contacts
    live = [line for line in conversion.text.splitlines() if not line.startswith(code(name).comment)]
    every = NAMES.get(name, NAMES["liggghts"])
    once = "choose those of one" in conversion.text and not source.input.apart
    for row, contact in zip(rows, every, strict=True):
        if row.numbers is None:
            continue  # the code cannot have this ε
        wall = row.pair.endswith("wall")
        first, second = (int(x) for x in re.findall(r"\d", row.pair + row.pair[0] * wall))
        bodies = {"ball": BED[first - 1], "other": hl.FLOOR if wall else BED[second - 1], "speed": speed}
        if once or source.input.shared:
            own = [f"{row.numbers[n]:.12g}" for n in row.numbers]
            if not all(any(number in line for line in live) for number in own):
                continue  # commented out
            named = (source.input.matrix and "types 1" in conversion.text) or (source.input.apart and wall)
            contact = contact if named else None
        elif source.input.once and not all(f"{row.numbers[n]:.12g}" in "\n".join(live) for n in row.numbers):
            continue
        again = back(conversion.text, name, contact=contact, **bodies)
        assert again.model is source and again.numbers == pytest.approx(row.numbers, rel=1e-11)
        assert again.restitution == pytest.approx(row.restitution, abs=1e-9)
        assert again.numerical_damping == 0.0 and bool(again.notes) == (name == "lammps" and "tsuji" in model)


@pytest.mark.parametrize("name", CODES)
def test_a_contact_that_is_not_named_is_asked_for(name):
    """Where contacts have different numbers: their names are listed, and each of them is understood."""
    for model in code(name).models:
        if model.input.shared and not model.input.matrix:
            continue
        spring = {"stiffness": 1e5} if model.elastic == "hooke" else STEEL
        text = hl.convert(
            BED, restitution=0.7, code=name, model=model.name, restitution_error=0.05, **spring
        ).text
        try:
            back(text, name)
        except ValueError as error:
            listed = re.fullmatch(
                r"contact: missing, must be one of (.*), which have different forces in the input",
                str(error),
            )
            assert listed, error
            for contact in listed[1].split(", "):
                assert back(text, name, contact=contact).model is model
            assert back(text, name, contact=contact.replace("-", " – ")).model is model
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
    assert refused(text).startswith(
        "contact: missing, must be one of 1-1, 1-2, 1-3, 1-4, 2-2, 2-3, 2-4, 3-3,"
    )


def test_a_wall_is_not_taken_for_balls():
    line = "fix w all wall/gran hooke 1e5 NULL 2e4 NULL 0.5 0 zplane 0 NULL"
    assert refused(line) == "input: got no contact of balls, only 1-w"
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
        ("lammps", "", "1-a, 1-b"),
        ("lammps", "unfix b", None),
        ("lammps", "fix b all wall/gran granular hooke 1e5 0.8 damping coeff_restitution zplane 0 1", None),
        ("liggghts", "", "1-a, 1-b"),
        ("liggghts", "unfix b", None),
        ("liggghts", "fix b all wall/gran model hooke/stiffness primitive type 1 xplane 0", None),
        (
            "liggghts",
            "unfix b\nfix c all mesh/surface file c type 2\nfix d all mesh/surface file d type 1\n"
            "fix a all wall/gran model hooke/stiffness mesh n_meshes 2 meshes c d",
            "1-a (type 1), 1-a (type 2)",
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
    line = f"must be one of {choices}, which have different forces in the input"
    assert refused(text, name, other=hl.FLOOR, contact="1-wall") == f"contact: got '1-wall', {line}"
    assert refused(text, name, other=hl.FLOOR).startswith("contact: missing")
    first, second = (back(text, name, other=hl.FLOOR, contact=choice) for choice in choices.split(", "))
    assert first.numbers != second.numbers
    if "unfix" not in after:
        named = text.replace("fix b", "fix wall")
        assert back(named, name, other=hl.FLOOR, contact="1-wall").numbers == second.numbers


# --- one reader ------------------------------------------------------------------------------------------------


def rows_and_back(verdict, text, speed):
    """Each contact of a script as ``check`` has it and as ``convert_back`` does, if both grains move."""
    name = verdict.code
    grains = read(text, code=name).stages[-1].grains
    frozen = {each.type for each in grains.values() if each.frozen}
    density = {each.type: each.densities[0] for each in grains.values()} if name == "yade" else {}  # kg/m³
    density |= {row.types[0]: row.density for row in verdict.rows}
    for row in verdict.rows:
        wall = row.types[1] == "wall"
        densities = [density.get(kind) for kind in row.types[: 2 - wall]]
        known = row.restitution is not None and None not in densities
        if known and row.wall != "fixed" and not frozen & {*row.types}:
            sizes = zip((row.radius, row.other_radius), densities, strict=False)
            balls = [hl.Ball(radius, density=value) for radius, value in sizes]
            ends = [str(int(x) + 1) if name == "yade" and x.isdecimal() else x for x in row.types]
            options = {
                "other": hl.FLOOR if wall else balls[-1],
                "speed": row.speed or speed,
                "contact": f"{ends[0]}-{(row.wall or 'wall') if wall else ends[1]}",
            }
            yield row, back(text, name, balls[0], **options)


@pytest.mark.parametrize("seed", [seed if seed < 6 else slow(seed) for seed in range(40)])
@pytest.mark.parametrize("name", ["lammps", "liggghts"])
def test_check_and_convert_agree_on_random_scripts(name, seed):
    """Where the newest version has another force, ``check`` has that of the version before as well."""
    script = Written(seed)
    getattr(script, name)()
    text = script.text()
    for row, obtained in rows_and_back(hl.check(text, code=name, speed=1.0), text, 1.0):
        older = row.other_versions[0] if obtained.notes else row
        assert obtained.restitution == pytest.approx(older.restitution, rel=1e-9), row
        assert obtained.duration == pytest.approx(older.duration, rel=1e-9), row


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
    obtained = back(text)
    assert obtained.model.name == "hooke-restitution" and not obtained.attraction
    assert obtained.restitution == pytest.approx(0.7182013610, abs=1e-8)


@draws(60)
@given(
    text=formatted(HERTZ),
    model=formatted(["pair_style", "gran", "model", "hertz", "tangential", "history", "limitForce", "on"]),
)
def test_the_form_of_a_liggghts_command_does_not_matter(text, model):
    """A matrix of two types, whose lines are continued."""
    moduli = "fix m1 all property/global youngsModulus peratomtype 1e9 &\n1e9\n"
    rest = f"{moduli}fix m2 all property/global poissonsRatio peratomtype .3 .3\n"
    obtained = back(f"{model}\n{rest}{text}", "liggghts")
    assert not obtained.attraction and obtained.restitution == pytest.approx(0.7182013610, abs=1e-8)


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


JUMPS = """label a
if '${x} > 0' then 'jump SELF b' else 'print c'
pair_coeff * * hooke 1e5 .7
label b"""


@pytest.mark.parametrize(
    "text,name,quoted",
    [
        ("units lj\nhooke 1e5 .7 damping velocity", "lammps", "got units lj, must be units si, cgs"),
        (
            "hooke 1e5 .7\nhooke 1e5 .8",
            "lammps",
            "line 2: got 'hooke 1e5 .8', must be the model on line 1, or part of",
        ),
        (
            "pair_coeff * * jkr 1e9 .7 .3 10",
            "lammps",
            "line 1: got 'pair_coeff * * jkr 1e9 .7 .3 10', must be without adhesion",
        ),
        ("pair_coeff * * hooke 1e5 .7 damping nothing", "lammps", "line 1: got 'damping nothing'"),
        ("pair_coeff * * hooke 1e5 .7 Damping velocity", "lammps", "line 1: got 'Damping velocity'"),
        ("pair_coeff * * hooke 1e5 .7 damping velocity & # c\n", "lammps", "line 1: got '&'"),
        (
            "pair_coeff * * hooke ${k} .7 damping velocity",
            "lammps",
            "line 1: got 'pair_coeff * * hooke ${k} .7 damping velocity', must have values for k",
        ),
        ("pair_coeff * * hooke 1e5 $(1/0)", "lammps", "must have variables that are known"),
        ("pair_coeff * * hooke 1e5 $(2**2)", "lammps", "must have variables that are known"),
        ("pair_coeff * * hooke 1d5 .7 damping velocity", "lammps", "have a number for stiffness, not 1d5"),
        (
            "pair_coeff * * hooke 1e5",
            "lammps",
            "line 1: got 'pair_coeff * * hooke 1e5', must have 2 words after hooke",
        ),
        ("pair_coeff * * hooke 1 '.7 damping", "lammps", "must close its quotes '"),
        ("include other.in", "lammps", "line 1: got 'include other.in', must be in a file"),
        (f"pair_style granular\n{JUMPS}\npair_coeff 1 1 hooke 1e5 .7", "lammps", "line 3: got"),
        (
            "hooke 1e5 .7\nfix d all damping/cundall 0.8 0.8",
            "lammps",
            "line 2: got 'fix d all damping/cundall 0.8 0.8', must be without",
        ),
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
        ("pair_style gran model hertz cohesion sjkr2", "liggghts", "must be without cohesion (sjkr2)"),
        ("pair_style gran model hooke viscous on", "liggghts", "got 'viscous on', must be viscous off"),
        (
            "pair_style gran model hertz limitforce on",
            "liggghts",
            "got 'limitforce on', must be a setting of model hertz",
        ),
        (
            "fix m all property/global kn peratomtypepair 2 1 2 3\nmodel hooke",
            "liggghts",
            "must be a number of types and one number for each",
        ),
        ("FrictMat(young=1e9,\n poisson=.3", "yade", "line 1: got 'FrictMat(young=1e9,', must be Python"),
        ("ViscElMat(tc=.1, en=.7, et=1, cohesion=3)", "yade", "must have known words, not cohesion"),
        (
            "FrictMat()\nIp2_FrictMat_FrictMat_Foo()\nNewtonIntegrator()",
            "yade",
            "line 2: got 'Ip2_FrictMat_FrictMat_Foo()', must be one of",
        ),
        (
            "FrictMat(young=E)\nIp2_FrictMat_FrictMat_MindlinPhys(en=.7)",
            "yade",
            "line 1: got 'FrictMat(young=E)', must have a known number for young, not E",
        ),
        (
            "ViscElMat(tc=.1, en=.7, et=1)\nm.en = 0.1",
            "yade",
            "line 2: got 'm.en = 0.1', must be an attribute of",
        ),
        ("NewtonIntegrator(damping=d)", "yade", "must have a number in [0, 1) for damping"),
        (
            "FrictMat()\nIp2_FrictMat_FrictMat_MindlinPhys()\nLaw2_ScGeom_MindlinPhys_Mindlin(includeAdhesion=True)",
            "yade",
            "line 3: got 'Law2_ScGeom_MindlinPhys_Mindlin(includeAdhesion=True)', must be without adhesion",
        ),
    ],
)
def test_what_is_not_understood_is_quoted_with_its_line(text, name, quoted):
    line = refused(text, name)
    assert quoted in line and line.startswith("input: ")


@pytest.mark.parametrize(
    "lines,stiffness",
    [
        ('variable k equal 1e4\nif "${soft} == 1" then "variable k equal 1e2"', None),
        ("variable k equal 1e4\nlabel a\nvariable k equal 2*${k}\njump SELF a", None),
        ("variable k equal 1e4\nif '1 > 0' then 'print x' else &\n 'variable k equal 1e2'", 1e4),
        ('variable b equal 2\nvariable k equal v_b*5e3\nif "1 > 0" then "variable b equal 3"', 1.5e4),
        ('variable k index 1e4 2e4\nif "1 > 0" then "next k"', 2e4),
        ('variable k equal 5\nif "1>0" then "jump SELF a"\nvariable k equal 1e4\nlabel a', 5.0),
        ('variable k equal 1e4\nif "1 > 0" then "print k" "variable b equal 2"', 1e4),
        ('variable k equal 1e4\nrun 100 every 10 "variable k equal 1e3"', 1e3),
    ],
)
def test_loops_and_conditions_are_followed(lines, stiffness):
    text = f"{lines}\npair_style granular\npair_coeff * * hooke ${{k}} 0.7 damping coeff_restitution"
    if stiffness is None:
        assert re.search(r"must (have values for (soft|k)|be part of a shorter loop)", refused(text))
    else:
        assert back(text).numbers["stiffness"] == stiffness


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
    obtained, other = back(text), back(same)
    limited = "limit_damping" in same
    if limited:
        assert obtained.attraction and not other.attraction
    else:
        assert obtained.restitution == pytest.approx(other.restitution, abs=1e-12)
    assert obtained.duration == pytest.approx(other.duration, rel=1e-12 if not limited else 0.1)


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
    si, cgs = (back(text.format(*numbers), "liggghts") for numbers in (("si", 1e8, 2.0), ("cgs", 1e9, 200.0)))
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
            restitution = force.numerically_damped(1.0, share).restitution
            assert restitution == pytest.approx(braked(p / 4, q / 4, damping, share, 1000), abs=2e-3)
            assert restitution == pytest.approx(e * math.sqrt((1 - share) / (1 + share)), abs=0.02)
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
    assert back(f"{MINDLIN}\nnewton.damping = 0.1", "yade").numerical_damping == 0.1
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
    obtained = back(text, "yade")
    assert obtained.model.name == model
    if gives is not None:
        assert obtained.restitution == pytest.approx(gives, abs=2e-4)


@pytest.mark.parametrize(
    "materials,contact_time,number",
    [
        (
            ("FrictMat(young=1e7, poisson=.3)", "FrictMat(young=1e9, poisson=.3)"),
            "",
            {"youngs_modulus": 2e7 / 1.01},
        ),
        (("ViscElMat(tc=1e-4, en=.9, et=1)", "ViscElMat(tc=3e-4, en=.7, et=1)"), "", {"contact_time": 2e-4}),
        (
            ("ViscElMat(tc=1e-4, en=.9, et=1)", "ViscElMat(tc=3e-4, en=.7, et=1)"),
            "tc=1e-4, et=1, ",
            {"contact_time": 1e-4},
        ),
    ],
)
def test_two_materials_that_differ_are_combined_as_by_yade(materials, contact_time, number):
    functor = "FrictMat_FrictMat_MindlinPhys" if "Frict" in materials[0] else "ViscElMat_ViscElMat_ViscElPhys"
    matches = "(0, 0, .9), (0, 1, .5), (1, 1, .3)"
    text = "\n".join([*materials, f"Ip2_{functor}({contact_time}en=MatchMaker(matches=[{matches}]))"])
    assert back(text, "yade", contact="1-1").numbers["restitution"] == 0.9
    numbers = back(text, "yade", contact="1-2").numbers
    assert numbers["restitution"] == 0.5 and numbers | number == pytest.approx(numbers)
    alone = text.replace(matches, "(0, 1, .5)")
    assert refused(alone, "yade", contact="1-1") == "contact: got '1-1', must be one of 1-2"
    assert back(alone, "yade").numbers == numbers


def test_frictphys_has_the_spring_of_yade():
    """kn = 2 E r1 E r2/(E r1 + E r2); undamped: the duration is π√(m/k); and the "
    "default numerical damping alone brakes."""
    text = "FrictMat(young=2e7, poisson=.2)\nIp2_FrictMat_FrictMat_FrictPhys()\nNewtonIntegrator()"
    obtained = back(text.replace("NewtonIntegrator()", ""), "yade", BED[0], other=BED[1])
    stiffness = 2.0 * 2e7 * 5e-4 * 1e-3 / 1.5e-3
    mass = BED[0].mass * BED[1].mass / (BED[0].mass + BED[1].mass)
    assert obtained.restitution == pytest.approx(1.0, abs=1e-12)
    assert obtained.duration == pytest.approx(math.pi * math.sqrt(mass / stiffness), rel=1e-9)
    assert back(text, "yade").restitution == pytest.approx(math.sqrt(0.8 / 1.2), abs=1e-9)


def test_names_whose_value_is_not_certain_are_not_taken():
    for lines in (
        "e = .7\nif x:\n    e = .5\n",
        "for e in x:\n    pass\n",
        "e = .7\ne += x\n",
        "e = .7\nwhile e > .5:\n    e -= .1\n",
        "e = random()\n",
    ):
        assert "must have a known number for en" in refused(lines + MINDLIN.replace("en=.7", "en=e"), "yade")


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
        assert "must have a known number for young, not 1" in refused(text, "yade")
    else:
        assert back(text, "yade").numbers["youngs_modulus"] == modulus


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
