"""What is read from scripts of LIGGGHTS: models, properties per type and pair, walls and meshes, templates."""

import math

import pytest

import hardlimit as hl
from hardlimit.checking.scripts import read

HEAD = "units si\natom_style granular\nregion box block 0 1 0 1 0 1 units box\ncreate_box 2 box\n"
PROPERTIES = """
fix m1 all property/global youngsModulus peratomtype 5e6 &
    2e7
fix m2 all property/global poissonsRatio peratomtype 0.45 0.3
fix m3 all property/global coefficientRestitution peratomtypepair 2 &
    0.9 0.5 &
    0.5 0.7  # one number for each pair
fix m4 all property/global coefficientFriction peratomtypepair 2 0.5 0.5 0.5 0.5
"""
INSERT = """
fix pts1 all particletemplate/sphere 15485863 atom_type 1 density constant 2500 radius constant 0.0015
fix pts2 all particletemplate/sphere 15485867 atom_type 1 density constant 2600 radius uniform 0.002 0.004
fix pdd1 all particledistribution/discrete 32452843 2 pts1 0.3 pts2 0.7
fix ins all insert/stream seed 32452867 distributiontemplate pdd1 nparticles 10 insertion_face inface
"""
MODEL = "pair_style gran model hertz tangential history limitForce on\npair_coeff * *\n"
SCRIPT = f"{HEAD}{PROPERTIES}{MODEL}{INSERT}"


def words(contact):
    """The words of all settings."""
    return {name: setting.words for name, setting in contact.settings.items()}


def test_pairs_and_their_properties():
    text = SCRIPT.replace("atom_type 1 density constant 2600", "atom_type 2 density constant 2600")
    description = read(f"{text}timestep 1e-6\nrun 100\n")
    assert (description.code, description.stages[0].units) == ("liggghts", "si")
    contact, mixed, other = description.stages[0].contacts
    assert words(contact)["model"] == ("hertz",) and words(contact)["limitForce"] == ("on",)
    assert words(contact)["youngsModulus"] == ("5e6",) and words(contact)["coefficientRestitution"] == (
        "0.9",
    )
    assert words(other)["youngsModulus"] == ("2e7",) and words(other)["coefficientRestitution"] == ("0.7",)
    assert words(mixed)["coefficientRestitution"] == ("0.5",)
    modulus, ratio = (float(words(mixed)[name][0]) for name in ("youngsModulus", "poissonsRatio"))
    effective = 1.0 / ((1.0 - 0.45**2) / 5e6 + (1.0 - 0.3**2) / 2e7)
    assert 0.5 * modulus / (1.0 - ratio**2) == pytest.approx(effective, rel=1e-12)
    assert [quote.text.split()[1] for quote in mixed.quotes[1:]] == ["m1", "m2", "m3"]
    assert [note.what for note in description.ignored] == ["tangential history"]


def test_templates():
    grains = read(f"{SCRIPT}run 1\n").stages[0].grains
    assert list(grains) == ["1"]
    assert grains["1"].radii == (0.0015, 0.004) and grains["1"].densities == (2500.0, 2600.0)
    coarse = read(f"{HEAD}coarsegraining 2\n{PROPERTIES}{MODEL}{INSERT}run 1\n").stages[0].grains
    assert coarse["1"].radii == (0.003, 0.008)
    lines = "create_atoms 1 box\nset group all density 9\nset group all diameter 0.1\nrun 1\n"
    changed = read(f"{HEAD}{PROPERTIES}{MODEL}{lines}")
    assert changed.stages[0].grains["1"].densities == (9.0, 9.0)  # LIGGGHTS keeps the density


@pytest.mark.parametrize(
    "words,ends",
    [
        ("constant 0.003", (0.0015, 0.003)),
        ("uniform number 0.002 0.004", (0.0015, 0.004)),
        ("uniform mass 0.001 0.004", (0.001, 0.004)),
        ("gaussian number 0.002 0.0003", (0.0011, 0.0029)),  # drawn again beyond 3 σ
        ("gaussian mass 0.005 0.001", (0.0015, 0.008)),
        ("lognormal number -6.2 0.1", None),
        ("gaussian number 0.002 0.001", None),  # negative radii
        ("uniform number 0.002", None),
        ("uniform number", None),
        ("constant", None),
    ],
)
def test_distributions_of_templates(words, ends):
    description = read(f"{SCRIPT.replace('uniform 0.002 0.004', words)}run 1\n")
    radii = description.stages[0].grains["1"].radii
    assert radii is None if ends is None else radii == pytest.approx(ends)
    assert any(words in end.text for end in description.unknown) == (ends is None)


@pytest.mark.parametrize("style", ["pour", "pour/legacy"])
@pytest.mark.parametrize(
    "words,radii,densities",
    [
        ("diam uniform 0.004 0.006 dens uniform 2500 2600", (0.002, 0.003), (2500, 2600)),
        ("diam discrete 0.004 0.006 dens 2500 2500", (0.002, 0.003), (2500, 2500)),
        ("diam 0.004 0.004 dens gaussian 2500 10", (0.002, 0.002), (2470, 2530)),
        ("", (0.5, 0.5), (1.0, 1.0)),
        ("diam lognormal -5 0.1 dens 2500 2500", None, (2500, 2500)),
    ],
)
def test_pouring(style, words, radii, densities):
    """As LIGGGHTS before version 3."""
    line = f"fix ins all {style} 100 2 4567 region box vol 0.2 50 {words} vel uniform 0 0 0 0 -1\n"
    description = read(f"{HEAD}{PROPERTIES}{MODEL}{line}run 1\n")
    grains = description.stages[0].grains["2"]
    assert grains.radii == (None if radii is None else pytest.approx(radii))
    assert grains.densities == pytest.approx(densities) and bool(description.unknown) == (radii is None)


def test_two_dimensions():
    """There, LIGGGHTS takes the mass of a disk."""
    text = f"dimension 2\n{HEAD}{PROPERTIES}{MODEL}create_atoms 1 box\nset group all diameter 0.2 density 5\nrun 1\n"
    grains = read(text).stages[0].grains["1"]
    assert grains.densities is None and grains.masses == pytest.approx((0.05 * math.pi,) * 2)


def test_walls_and_meshes():
    text = f"""{SCRIPT}
fix cad all mesh/surface/stress file a.stl type 2
fix lid all mesh/surface file b.stl type 1
fix w1 all wall/gran model hertz tangential history mesh n_meshes 2 meshes cad lid limitForce on
fix w2 all wall/gran model hooke tangential history primitive type 2 zplane 0.0 limitForce off
fix w3 all wall/gran model hertz primitive type 1 zcylinder 0.05 0. 0. shear z 1.0
fix move all move/mesh mesh cad linear 1 0 0
fix m5 all property/global characteristicVelocity scalar 2.0
run 1
"""
    description = read(text)
    walls = {stage.wall: words(stage) for stage in description.stages[0].contacts if stage.wall}
    assert list(walls) == ["w1 (type 1)", "w1 (type 2)", "w2", "w3"]
    assert walls["w1 (type 1)"]["youngsModulus"] == ("5e6",) and walls["w1 (type 1)"]["limitForce"] == ("on",)
    assert walls["w1 (type 2)"]["coefficientRestitution"] == ("0.5",)
    assert walls["w2"]["model"] == ("hooke",) and walls["w2"]["characteristicVelocity"] == ("2.0",)
    pushes = {stage.wall: stage.pushes for stage in description.stages[0].contacts if stage.wall}
    assert pushes["w1 (type 1)"] is None and pushes["w2"] == ((0, 0, 1), (0, 0, -1))  # grains on both sides
    assert pushes["w3"] == ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0))
    said = [note.what for note in description.ignored]
    assert "a moving wall (move/mesh)" in said and "a moving wall (shear)" in said
    assert any("curvature" in note for note in said)


def test_hooke_stiffness_has_a_matrix():
    text = f"""{HEAD}{INSERT}
variable k equal 1e5
fix m1 all property/global kn peratomtypepair 2 ${{k}} 2e5 2e5 3e5
fix m2 all property/global gamman peratomtypepair 2 1 2 2 3
pair_style gran model hooke/stiffness
run 1
"""
    text = text.replace("pair_style gran ", "pair_style gran/omp ").replace("1 2 2 3", "v_g 2 2 3 every 1")
    contact = words(read(f"variable g equal 1\n{text}").stages[0].contacts[0])
    assert contact["kn"] == ("100000",) and contact["gamman"] == ("1.0",)


@pytest.mark.parametrize(
    "line,what",
    [
        ("pair_style gran model hertz cohesion sjkr2", "cohesion (sjkr2)"),
        ("pair_style gran model hertz cohesion easo/capillary/viscous", "cohesion (easo/capillary/viscous)"),
        ("fix w all wall/gran model hertz cohesion sjkr primitive type 1 zplane 0", "cohesion (sjkr)"),
        ("pair_style gran model hooke/hysteresis tangential history", "plastic"),
        ("fix t all particletemplate/multisphere 7 atom_type 1 density constant 1 nspheres 2", "clumps"),
        ("fix m all multisphere", "clumps"),
        ("fix c all couple/cfd couple_every 10 mpi", "drag of a fluid"),
        ("fix v all viscous 0.1", "viscous drag"),
        ("atom_style superquadric", "no spheres"),
    ],
)
def test_what_makes_hard_spheres_wrong(line, what):
    assert any(what in finding.what for finding in read(f"{SCRIPT}{line}\nrun 1\n").invalidates)


COHESIVE = """
pair_style gran model hertz cohesion {0}
fix w all wall/gran model hertz cohesion {0} primitive type 3 zplane 0
create_atoms 1 box
create_atoms 2 box
"""
DENSITY = "fix c1 all property/global cohesionEnergyDensity peratomtypepair 3 {}\n"
CAPILLARY = "fix c1 all property/global surfaceTension scalar {}\nfix c2 all property/global fluidViscosity scalar {}\n"


@pytest.mark.parametrize(
    "model,constants,sticky,types",
    [
        ("sjkr", DENSITY.format("0 0 0  0 0 0  0 0 0"), [], ()),
        ("sjkr2", DENSITY.format("0.0 0 0  0 0e5 0  0 0 7"), [], ()),
        ("sjkr", DENSITY.format("0 0 0  0 5 0  0 0 0"), [("2", "2")], ("2",)),
        ("sjkr2", DENSITY.format("0 5 0  5 0 0  0 0 0"), [("1", "2")], ("1", "2")),
        ("sjkr", DENSITY.format("0 0 5  0 0 0  5 0 0"), [("1", "wall")], ("1",)),
        ("easo/capillary/viscous", CAPILLARY.format(0, 0.0), [], ()),
        ("off", "", [], ()),
    ],
)
@pytest.mark.parametrize("before", [True, False])
def test_cohesion_concerns_contacts_whose_constant_is_not_0(model, constants, sticky, types, before):
    """Wherever the constants are: they count at the run."""
    lines = [HEAD.replace("box 2 reg", "box 3 reg"), constants, COHESIVE.format(model)]
    description = read("".join(lines if before else [lines[0], lines[2], lines[1]]) + "run 1\n")
    contacts = description.stages[0].contacts
    assert [contact.types for contact in contacts if contact.adhesion] == sticky and len(contacts) == 5
    assert {name for note in description.invalidates for name in note.types} == set(
        types
    ) and not description.unknown


def test_cohesion_may_begin_with_a_later_run():
    text = f"{HEAD}{COHESIVE.format('sjkr').replace('type 3', 'type 2')}"
    constants = "fix c1 all property/global cohesionEnergyDensity peratomtypepair 2 {0} {0} {0} {0}\nrun 1\n"
    description = read(text + constants.format(0) + constants.format(9))
    assert [any(contact.adhesion for contact in stage.contacts) for stage in description.stages] == [
        False,
        True,
    ]
    assert [note.types for note in description.invalidates] == [("1", "2")] * 2


@pytest.mark.parametrize(
    "line,must",
    [
        ("pair_style gran/hertz/history 1 0", "must be pair_style gran model NAME"),
        (
            "fix m1 all property/global youngsModulus peratomtype ${y}",
            "have values for y: give them with --var",
        ),
    ],
)
def test_what_cannot_be_read_is_refused(line, must):
    with pytest.raises(ValueError, match=must):
        read(f"{SCRIPT}{line}\nrun 1\n")


@pytest.mark.parametrize("name", ["hertz/lubricated", "hertz/magic", "hooke/magic"])
def test_a_model_that_is_not_known_is_said_once(name):
    """With the line that has it, for all its contacts."""
    text = f"{SCRIPT.replace('model hertz', f'model {name}')}create_atoms 2 box\nrun 1\n"
    (unknown,) = hl.check(text, speed=0.1).to_dict()["unknown"]
    assert f"pair_style gran model {name}" in unknown and unknown.startswith("line ")
    assert f"1–1, 1–2, 2–2: model {name} of LIGGGHTS is not known, only hertz, hooke" in unknown


@pytest.mark.parametrize("part", ["surface multicontact", "surface superquadric", "viscous stokes"])
def test_a_part_of_a_model_that_is_not_known_is_named(part):
    line = f"pair_style gran model hertz tangential history {part}"
    (unknown,) = read(f"{SCRIPT}{line}\nrun 1\n").unknown
    assert (unknown.text, unknown.part) == (line, part)
    sentence = hl.check(f"{SCRIPT}{line}\nrun 1\n").sentence
    assert sentence.endswith(f"{line} ({part} is not known).")


def test_what_is_unknown_is_quoted():
    lines = [
        "pair_style gran model hertz surface multicontact",
        "fix x all magic 1",
        "fix ins2 all insert/pack seed 1 distributiontemplate none",
    ]
    description = read(SCRIPT + "\n".join(lines) + "\nrun 1\n")
    assert [quote.text for quote in description.unknown] == lines
    assert description.stages[0].contacts == () and description.stages[0].grains["1"].radii is None


def test_gravity_on_some_grains_is_quoted():
    """A plate of grains that alone has a weight; gravity on all moving grains, or on more, is no news."""
    two = SCRIPT.replace("atom_type 1 density constant 2600", "atom_type 2 density constant 2600")
    some = "group plate type 1\nfix g plate gravity 9.81 vector 0 0 -1\nfix move {} nve/sphere\nrun 100\n"
    part = read(f"{two}{some.format('all')}")
    quoted = [quote.text for quote in part.unknown]
    assert part.stages[0].gravity is None
    assert any("fix g" in text and "other grains have no gravity" in text for text in quoted)
    assert not any("fix g" in quote.text for quote in read(f"{two}{some.format('plate')}").unknown)


def test_a_loop_that_deforms_alike_is_one_run():
    """Thousands of runs of a servo: the same stage as one run, with the steps of all."""
    loop = """
variable k loop 2000
label again
fix squeeze all deform 1 z erate -0.1
run 10
next k
jump SELF again
"""
    (stage,) = read(SCRIPT + loop).stages
    assert stage.steps == 20_000 and len(stage.pressed) == 1
    changed = loop.replace("-0.1", "-0.${k}").replace("2000", "3")
    assert len(read(SCRIPT + changed).stages) == 3
