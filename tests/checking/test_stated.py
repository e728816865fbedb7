"""What a script says is used, numbers beside it fill what is missing, and each inferred value is said."""

import math
import random
import re
import tempfile
from pathlib import Path

import numpy as np
import pytest

import hardlimit as hl
from command_line import refused, run
from conftest import slow
from hardlimit.checking import cases, corrections, stated, surroundings
from hardlimit.checking.contacts import Surroundings
from hardlimit.checking.scripts import read

FRICTIONLESS = "tangential linear_nohistory 0.0 0.0"
PAIR = f"pair_style granular\npair_coeff * * hooke 1e5 0.9 damping coeff_restitution {FRICTIONLESS}"
WITHOUT_SIZES = (
    f"units si\natom_style sphere\nread_data grains.data\n{PAIR}\nfix move all nve/sphere\nrun 100\n"
)


def saved(tmp_path, text, name="in.box"):
    """The path of a script."""
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return path


# --- the question, and numbers beside a script ------------------------------------------------------------------


def test_the_answer_begins_with_its_question(tmp_path):
    path = saved(tmp_path, WITHOUT_SIZES)
    verdict = hl.check(path, speed=0.3, packing_fraction=0.3)
    assert verdict.question == "May an event-driven simulation replace this?"
    assert str(verdict) == f"{verdict.question} {verdict.sentence}"
    assert verdict.to_dict()["question"] == verdict.question
    assert f"{verdict.question} Cannot be said: " in " ".join(run("check", path).stdout.split())


def test_numbers_beside_a_script_fill_what_it_does_not_say(tmp_path):
    """The same contacts as those of a script that states them; the file of their sizes need not be there."""
    path = saved(tmp_path, WITHOUT_SIZES)
    known = "set type 1 diameter 2e-3 density 2500"
    stated = WITHOUT_SIZES.replace("read_data grains.data", f"create_atoms 1 single 0 0 0\n{known}")
    options = {"speed": 0.3, "packing_fraction": 0.3}
    wanted = hl.check(stated.replace("run", "timestep 1e-6\nrun"), **options)
    verdict = hl.check(path, radius=1e-3, density=2500.0, time_step=1e-6, **options)
    assert verdict.rows == wanted.rows and not verdict.unknown and "within the error bar" in verdict.sentence
    by_mass = hl.check(
        path, radius=1e-3, mass=wanted.rows[0].density * 4e-9 / 3 * 3.141592653589793, **options
    )
    assert by_mass.rows[0].duration == pytest.approx(wanted.rows[0].duration)
    partly = hl.check(path, radius=1e-3, **options)
    assert partly.missing == ("masses",) and "--density" in partly.sentence
    for numbers in ({"radius": 1e-3}, {"density": 1.0}, {"mass": 1.0}):
        with pytest.raises(ValueError, match="must be left out: the script states that of all grains"):
            hl.check(stated, **numbers)
    with pytest.raises(ValueError, match=r"density \| mass: got both"):
        hl.check(path, density=1.0, mass=1.0)
    assert "--law" in refused("check", path, "--law", "linear")


def test_numbers_beside_a_script_have_its_units():
    """In cgs and micro units, lengths, densities and times are converted; in lj units they are taken as they are."""
    for units, length, density, time in (
        ("cgs", 1e-2, 1e3, 1.0),
        ("micro", 1e-6, 1e3, 1e-6),
        ("lj", 1, 1, 1),
    ):
        text = WITHOUT_SIZES.replace("units si", f"units {units}")
        row = hl.check(text, radius=2 * length, density=3 * density, time_step=4e-7 * time, speed=0.1).rows[0]
        same = text.replace(
            "read_data grains.data", "create_atoms 1 single 0 0 0\nset type 1 diameter 4 density 3"
        )
        other = hl.check(same.replace("run", "timestep 4e-7\nrun"), speed=0.1).rows[0]
        assert (row.duration, row.radius, row.steps_per_contact) == pytest.approx(
            (other.duration, other.radius, other.steps_per_contact)
        )


# --- the version of the code ------------------------------------------------------------------------------------


@pytest.mark.parametrize("version", ["22Jul2025", "22 Jul 2025", "22-Jul-2025_update2", "4Feb2025"])
def test_a_version_is_taken_as_that_of_a_log(version):
    """Tsuji's damping changed on 2 Sep 2026: before, the ε that is printed beside it is the only one."""
    text = WITHOUT_SIZES.replace("read_data grains.data", "create_atoms 1 single 0 0 0").replace(
        "hooke 1e5 0.9 damping coeff_restitution", "hertz 1e5 0.5 damping tsuji"
    )
    newest, old = hl.check(text, speed=0.1), hl.check(text, speed=0.1, version=version)
    (other,) = newest.rows[0].other_versions
    assert other.before == "2 Sep 2026" and not old.rows[0].other_versions
    assert old.rows[0].restitution == pytest.approx(other.restitution) != newest.rows[0].restitution
    assert any("before 2 Sep 2026" in remark for remark in newest.remarks)
    assert not any("before" in remark for remark in old.remarks)
    log = f"LAMMPS (22 Jul 2025)\n{text}Loop time of 1 on 1 procs\n"
    assert hl.check(log, speed=0.1).rows == old.rows
    assert hl.check(log, speed=0.1, version="3Sep2026").rows[0].restitution == newest.rows[0].restitution


@pytest.mark.parametrize(
    ("version", "code"), [("3.8.0", "lammps"), ("", "lammps"), ("22Jul2025", "liggghts")]
)
def test_a_version_is_one_of_the_code(version, code, tmp_path):
    with pytest.raises(ValueError, match=r"version: got .*, must be one such as"):
        hl.check(WITHOUT_SIZES, code=code, version=version)
    with pytest.raises(ValueError, match="version: got '22Jul2025', must be left out without a script"):
        hl.check(
            hl.Ball(1e-3, density=1.0),
            law=hl.LinearDashpot(stiffness=1.0, restitution=1.0),
            version="22Jul2025",
        )


def test_yade_before_2023_has_another_force():
    text = """
O.materials.append(FrictMat(young=1e7, poisson=0.2, density=2500, frictionAngle=0))
O.bodies.append([sphere((0, 0, 0), 1e-3), sphere((0, 0, 3e-3), 1e-3)])
O.engines = [ForceResetter(), InsertionSortCollider([Bo1_Sphere_Aabb()]), InteractionLoop([Ig2_Sphere_Sphere_ScGeom()],
    [Ip2_FrictMat_FrictMat_MindlinPhys(en=0.5, es=0.5)], [Law2_ScGeom_MindlinPhys_Mindlin()]),
    NewtonIntegrator(damping=0)]
O.dt = 1e-6
O.run(100)
"""
    newest, old = hl.check(text, speed=0.1).rows[0], hl.check(text, speed=0.1, version="2022.01a").rows[0]
    assert old.restitution == pytest.approx(newest.other_versions[0].restitution, abs=1e-6)
    assert old.duration > 1.02 * newest.duration and not old.other_versions


# --- packing and speeds of LAMMPS -------------------------------------------------------------------------------

#: Boltzmann's constant of each system of units (SI 2019).
BOLTZMANN = {"si": 1.380649e-23, "cgs": 1.380649e-16, "micro": 1.380649e-8, "lj": 1.0}
LENGTHS = {"si": 1.0, "cgs": 1e-2, "micro": 1e-6, "lj": 1.0}
TIMES = {"si": 1.0, "cgs": 1.0, "micro": 1e-6, "lj": 1.0}
END = f"{PAIR}\nfix move all nve/sphere\ntimestep 1e-7\nrun 100\n"


def box(*lines, edges=(1.0, 1.0, 1.0), units="si", boundary="p p p", types=1, end=END):
    """A script of LAMMPS with a box."""
    ends = " ".join(f"0 {edge!r}" for edge in edges)
    head = f"units {units}\natom_style sphere\nboundary {boundary}\nregion cell block {ends} units box"
    return "\n".join([head, f"create_box {types} cell", *lines, end])


def inferred(text, what, **options):
    """A number that follows from a script; None if none does."""
    numbers = {number.what: number for number in hl.check(text, **options).inferred}
    return numbers.get(what)


def drawn(seed):
    """A random number generator, and a variable's name from it."""
    rng = random.Random(seed)
    return rng, "".join(rng.choice("abcxyz_") for _ in range(rng.randint(1, 8))) + "q"


@pytest.mark.parametrize("seed", [*range(4), *map(slow, range(4, 12))])
def test_packing_and_speed_of_a_gas_follow_from_its_script(seed):
    """N, diameters and box give φ, and the temperature at which velocities are created gives √(πT)."""
    rng, name = drawn(seed)
    units, number = rng.choice(list(LENGTHS)), rng.randint(20, 5000)
    edges = [round(rng.uniform(1.0, 3.0), 4) for _ in range(3)]
    wanted, density = rng.uniform(0.01, 0.45), rng.uniform(1.0, 3.0)
    d = (6.0 * wanted * math.prod(edges) / (math.pi * number)) ** (1 / 3)
    mass = density * math.pi * d**3 / 6.0
    heat = mass * 10 ** rng.uniform(-4.0, 0.0) / BOLTZMANN[units]
    text = box(
        f"variable {name} equal {d!r}\nvariable n{name} index {number}",
        f"create_atoms 1 random ${{n{name}}} {rng.randint(1, 99)} cell overlap ${{{name}}}",
        f"set type 1 diameter ${{{name}}} density {density!r}\nvelocity all create {heat!r} 7",
        edges=edges,
        units=units,
    )
    phi, speed = inferred(text, "packing fraction"), inferred(text, "speed")
    assert phi.value == pytest.approx(wanted, rel=1e-9) and f"{number} grains in the box" in str(phi)
    own = math.sqrt(math.pi * BOLTZMANN[units] * heat / mass)
    assert speed.value == pytest.approx(own * LENGTHS[units] / TIMES[units], rel=1e-9) and speed.decides
    assert ("m/s" in str(speed)) is (units != "lj") and "velocities created at a temperature of" in str(speed)
    verdict = hl.check(text)
    assert not verdict.missing and verdict.rows[0].tc_nu > 0.0
    same = hl.check(text, speed=speed.value, packing_fraction=phi.value)
    assert same.sentence == verdict.sentence and not same.inferred


def test_what_is_given_comes_before_what_follows_from_the_script():
    text = box(
        "create_atoms 1 random 500 7 cell\nset type 1 diameter 0.05 density 2500\nvelocity all create 1e20 7"
    )
    verdict = hl.check(text, packing_fraction=0.3)
    assert [number.what for number in verdict.inferred] == ["speed"]
    assert verdict.rows[0].tc_nu > 2.0 * hl.check(text).rows[0].tc_nu
    assert [number.what for number in hl.check(text, speed=1.0).inferred] == ["packing fraction"]
    assert [number.what for number in hl.check(text, power=1e-6).inferred] == ["packing fraction"]


@pytest.mark.parametrize("seed", [0, *map(slow, range(1, 6))])
def test_grains_of_two_sizes_fill_what_both_do(seed):
    """A share of one type becomes another one, with another diameter."""
    rng, _ = drawn(seed)
    number, share = rng.randint(100, 1000), round(rng.uniform(0.1, 0.9), 3)
    small, large = rng.uniform(0.01, 0.05), rng.uniform(0.05, 0.09)
    text = box(
        f"create_atoms 1 random {number} 7 cell\nset type 1 diameter {small!r}",
        f"set type 1 type/fraction 2 {share} 77\nset type 2 diameter {large!r}",
        types=2,
    )
    volume = number * math.pi / 6.0 * ((1.0 - share) * small**3 + share * large**3)
    assert inferred(text, "packing fraction").value == pytest.approx(volume, rel=1e-9)
    other = text.replace("set type 2 diameter", "set group all diameter")
    assert inferred(other, "packing fraction").value == pytest.approx(number * math.pi / 6.0 * large**3)


def test_disks_fill_an_area_and_walls_end_the_box():
    grains = "create_atoms 1 random 100 7 cell\nset type 1 diameter 0.05"
    disks = box(f"dimension 2\n{grains}", edges=(1.0, 2.0, 1.0)).replace("dimension 2\n", "")
    disks = disks.replace("atom_style", "dimension 2\natom_style")
    assert inferred(disks, "packing fraction").value == pytest.approx(100 * math.pi * 0.025**2 / 2.0)
    wall = f"fix low all wall/gran granular hooke 1e5 0.9 damping coeff_restitution {FRICTIONLESS}"
    between = box(grains, f"{wall} zplane 0.2 0.7", boundary="p p f")
    ball = 100 * math.pi / 6.0 * 0.05**3
    assert inferred(between, "packing fraction").value == pytest.approx(ball / 0.5)
    tube = box(grains, f"{wall} zcylinder 0.3", boundary="f f p", edges=(1.0, 1.0, 2.0))
    assert inferred(tube, "packing fraction").value == pytest.approx(ball / (math.pi * 0.09 * 2.0))
    open_box = box(grains, boundary="p p f")
    assert (
        inferred(open_box, "packing fraction") is None and "packing" in hl.check(open_box, speed=1.0).missing
    )


#: Scripts whose number of grains, or whose velocities, only a run knows.
UNSURE = [
    "delete_atoms overlap 0.1 all all",
    "delete_atoms region part",
    "region part sphere 0.5 0.5 0.5 0.2 units box\ngroup some region part\nset group some diameter 0.03",
    "create_atoms 1 region part",
    "change_box all x final 0 2",
    "fix more all deposit 100 1 100 7 region part",
    "set type 1 type/subset 1 10 7",
]


@pytest.mark.parametrize("line", UNSURE)
def test_a_number_of_grains_that_only_a_run_knows_is_not_guessed(line):
    grains = "create_atoms 1 random 100 7 cell\nset type 1 diameter 0.05"
    part = "region part cone z 0.5 0.5 0.1 0.2 0 1 units box"
    assert inferred(box(grains), "packing fraction") is not None
    assert inferred(box(grains, part, line), "packing fraction") is None


def test_grains_that_overlap_when_they_are_made_have_no_speed_that_decides():
    """They push each other, unless they move apart before their velocities are created."""
    text = box("GRAINS\nset type 1 diameter 0.05 density 2500\nBEFORE\nvelocity all create 1e20 7")
    for grains, before, decides in (
        ("create_atoms 1 random 500 7 cell", "", False),
        ("create_atoms 1 random 500 7 cell overlap 0.049", "", False),
        ("create_atoms 1 random 500 7 cell overlap 0.05", "", True),
        ("create_atoms 1 random 500 7 cell", "minimize 0 0 100 100", True),
        ("create_atoms 1 random 500 7 cell", f"{PAIR}\nfix move all nve/sphere\nrun 1000", True),
        ("lattice sc 0.1\ncreate_atoms 1 box", "", True),
    ):
        verdict = hl.check(text.replace("GRAINS", grains).replace("BEFORE", before))
        speed = next(number for number in verdict.inferred if number.what == "speed")
        assert speed.decides is decides is ("overlap" not in speed.source), (grains, before)
        assert ("speeds" in verdict.missing) is not decides


@pytest.mark.parametrize("line", [
    "velocity all create ${heat} 7",
    "velocity some create 1e20 7",
    "velocity all create 1e20 7 sum yes",
    "velocity all ramp vx 0 1 y 0 1",
    'if "$(c_thermo_temp) > 1" then "velocity all create 1e20 7"',
])  # fmt: skip
def test_velocities_that_are_not_known_are_not_guessed(line):
    grains = "create_atoms 1 random 100 7 cell\nset type 1 diameter 0.05\ngroup some id 1:50"
    known = "velocity all create 1e20 7"
    assert inferred(box(grains, known), "speed") is not None
    for lines in ((known, line), (line, known)):
        try:
            assert inferred(box(grains, *lines), "speed") is None
        except ValueError as error:
            assert "have values for heat" in str(error)


@pytest.mark.parametrize(("style", "scale", "edges", "region", "number"), [
    # obtained with LAMMPS 22 Jul 2025, in si units
    ("sc", 0.19, (0.95, 1.14, 1.33), "", 210),
    ("sc", 0.128, (1.446, 1.868, 1.561), "block 0.471 1.175 0.43 1.401 0.408 INF", 378),
    ("sc", 0.112, (1.028, 1.09, 0.836), "sphere 0.292 0.296 0.368 0.46", 273),
    ("sc", 0.231, (1.288, 1.462, 1.918), "cylinder x 0.26 0.751 0.456 0.145 EDGE", 60),
    ("bcc", 0.269, (1.264, 1.95, 1.817), "", 525),
    ("bcc", 0.14, (1.61, 1.204, 1.173), "block 0.111 1.229 0.306 0.514 0.549 INF", 104),
    ("bcc", 0.136, (1.471, 1.337, 1.029), "sphere 0.565 0.174 0.367 0.258", 58),
    ("bcc", 0.161, (1.862, 1.053, 1.273), "cylinder y 0.81 0.154 0.695 0.374 EDGE", 351),
    ("fcc", 0.266, (1.33, 1.596, 1.862), "", 840),
    ("fcc", 0.273, (1.019, 0.985, 1.89), "block 0.435 0.996 0.198 0.513 0.26 INF", 48),
    ("fcc", 0.221, (1.306, 0.925, 0.846), "sphere 0.632 0.186 0.328 0.328", 49),
    ("fcc", 0.286, (1.973, 0.952, 1.375), "cylinder y 0.679 0.144 0.306 0.332 EDGE", 28),
])  # fmt: skip
def test_sites_of_a_lattice_are_counted_as_lammps_does(style, scale, edges, region, number):
    """In the whole box, or in a region."""
    lines = [f"lattice {style} {scale}", *([f"region r {region} units box"] if region else [])]
    lines += ["create_atoms 1 region r" if region else "create_atoms 1 box", "set type 1 diameter 0.05"]
    contents = read(box(*lines, edges=edges)).stages[-1].contents
    assert contents.count == number and contents.filled == pytest.approx(number * math.pi / 6.0 * 0.05**3)


def test_a_data_file_states_box_grains_and_velocities(tmp_path):
    rng = np.random.default_rng(3)
    at, velocities = rng.random((50, 3)), rng.normal(0.0, 0.3, (50, 3)) + 5.0
    rows = "\n".join(f"{k} 1 0.08 2500 {x} {y} {z}" for k, (x, y, z) in enumerate(at, 1))
    speeds = "\n".join(f"{k} {x!r} {y!r} {z!r} 0 0 0" for k, (x, y, z) in enumerate(velocities.tolist(), 1))
    text = f"grains\n\n50 atoms\n1 atom types\n\n0 1.5 xlo xhi\n-1 1 ylo yhi\n0 1 zlo zhi\n\nAtoms # sphere\n\n{rows}\n"
    saved(tmp_path, f"{text}\nVelocities\n\n{speeds}\n", "grains.data")
    verdict = hl.check(saved(tmp_path, WITHOUT_SIZES))
    phi, speed = verdict.inferred
    assert phi.value == pytest.approx(50 * math.pi / 6.0 * 0.08**3 / 3.0)
    heat = ((velocities - velocities.mean(axis=0)) ** 2).mean()
    assert speed.value == pytest.approx(math.sqrt(math.pi * heat)) and not verdict.missing
    saved(tmp_path, text, "grains.data")
    assert hl.check(tmp_path / "in.box").missing == ("speeds",)


def test_copies_of_a_box_have_the_same_packing():
    text = box("create_atoms 1 random 30 7 cell\nset type 1 diameter 0.05\nreplicate 2 1 3")
    contents = read(text).stages[-1].contents
    assert (contents.count, contents.volume) == (180.0, pytest.approx(6.0))


# --- speeds that do not decide ----------------------------------------------------------------------------------

FLOOR = f"fix low all wall/gran granular hooke 1e5 0.9 damping coeff_restitution {FRICTIONLESS} zplane"


@pytest.mark.parametrize("seed", [*range(3), *map(slow, range(3, 8))])
def test_poured_grains_fall_from_the_region_to_the_floor(seed):
    """√(v² + 2 g h), with the floor where the wall is, in any system of units."""
    rng, name = drawn(seed)
    units, g = rng.choice(list(LENGTHS)), rng.uniform(1.0, 20.0)
    floor, top, start = rng.uniform(0.0, 0.3), rng.uniform(0.5, 0.9), rng.choice([0.0, rng.uniform(0.1, 2.0)])
    text = box(
        f"variable {name} equal {top!r}",
        f"region slab block 0 1 0 1 0.45 ${{{name}}} units box\n{FLOOR} {floor!r} NULL",
        f"fix g all gravity {g!r} vector 0 0 -1",
        f"fix ins all pour 100 1 7 region slab diam one 0.02 dens 2500 2500 vel 0 0 0 0 {-start!r}",
        boundary="p p f",
        units=units,
    )
    speed = inferred(text, "speed")
    own = math.sqrt(start**2 + 2.0 * g * (top - floor))
    assert speed.value == pytest.approx(own * LENGTHS[units] / TIMES[units], rel=1e-9) and not speed.decides
    assert "from the insertion region" in str(speed) and ("speed of the insertion" in str(speed)) is (
        start > 0.0
    )
    verdict = hl.check(text)
    assert verdict.rows[0].speed == pytest.approx(speed.value) and verdict.rows[0].largest_overlap > 0.0
    assert verdict.admissible is False and "speeds" in verdict.missing


def test_the_fall_is_said_with_its_height():
    text = box(
        f"region slab block 0 1 0 1 0.01 0.02 units box\n{FLOOR} 0 NULL\nfix g all gravity 9.81 chute 0",
        "fix ins all pour 100 1 7 region slab diam one 0.002 dens 2500 2500",
        boundary="p p f",
    )
    assert str(inferred(text, "speed")) == "Speed 0.626 m/s: the fall of 2 cm from the insertion region."
    report = " ".join(run_text(text).split())
    assert "Speed 0.626 m/s" in report and "Not known: speeds" not in report
    side = text.replace("chute 0", "vector 1 0 0")
    assert "√(g d)" in str(inferred(side, "speed"))
    ends = text.replace(f"{FLOOR} 0 NULL", f"{FLOOR} NULL 1")
    assert "(at most: to the end of the box)" in str(inferred(ends, "speed"))


def run_text(text):
    """The report of a script."""
    with tempfile.TemporaryDirectory() as folder:
        return run("check", saved(Path(folder), text)).stdout


def test_without_another_speed_grains_at_rest_have_that_of_a_fall_by_a_diameter():
    text = box(
        "create_atoms 1 single 0.5 0.5 0.5\nset type 1 diameter 0.02 density 2500",
        f"{FLOOR} 0 NULL\nfix g all gravity 9.81 chute 20",
        boundary="p p f",
    )
    speed = inferred(text, "speed")
    assert speed.value == pytest.approx(math.sqrt(9.81 * 0.02)) and str(speed).endswith(
        "√(g d) of grains at rest."
    )


@pytest.mark.parametrize(("line", "speed"), [
    (f"{FLOOR} 0 NULL wiggle z 0.01 0.1", 0.01 * 2 * math.pi / 0.1),
    (f"{FLOOR} 0 NULL\nfix m all move wiggle 0 0 0.03 0.2", 0.03 * 2 * math.pi / 0.2),
    (f"{FLOOR} 0 NULL\nfix m all move linear 3 NULL 4", 5.0),
    ("velocity some set 1 0 0\nvelocity rest set -1 0 2", math.sqrt(8.0)),
])  # fmt: skip
def test_walls_and_groups_that_move_have_their_speed(line, speed):
    grains = "create_atoms 1 random 40 7 cell\nset type 1 diameter 0.02"
    grains += "\ngroup some id 1:20\ngroup rest subtract all some"
    verdict = hl.check(box(grains, line, boundary="p p f"))
    number = next(number for number in verdict.inferred if number.what == "speed")
    assert number.value == pytest.approx(speed) and not number.decides and verdict.admissible is not True


def test_hertz_contacts_without_any_speed_have_a_table():
    """At 0.01, 0.1 and 1 m/s, which decide nothing."""
    material = f"hertz/material 1e7 0.7 0.3 damping tsuji {FRICTIONLESS}"
    text = box(
        "create_atoms 1 random 9 3 NULL",
        end=END.replace("hooke 1e5 0.9 damping coeff_restitution", material),
    )
    verdict = hl.check(text)
    assert [row.speed for row in verdict.rows] == [0.01, 0.1, 1.0] and "speeds" in verdict.missing
    assert verdict.speeds_chosen and not verdict.inferred
    durations = [row.duration for row in verdict.rows]
    assert durations[0] / durations[2] == pytest.approx(100**0.2, rel=1e-6)


# --- corrected lines --------------------------------------------------------------------------------------------

MINDLIN = """
O.materials.append(FrictMat(young=1e7, poisson=0.2, density=2500, frictionAngle=0))
O.bodies.append([sphere((0, 0, 0), 1e-3), sphere((0, 0, 3e-3), 1e-3)])
O.engines = [ForceResetter(), InsertionSortCollider([Bo1_Sphere_Aabb()]), InteractionLoop([Ig2_Sphere_Sphere_ScGeom()],
    [Ip2_FrictMat_FrictMat_MindlinPhys(en={en}, es={en})], [Law2_ScGeom_MindlinPhys_Mindlin()]),
    NewtonIntegrator(damping={damping})]
O.dt = 1e-7
O.run(100)
"""


@pytest.mark.parametrize("damping", [0, 0.2, 0.4])
@pytest.mark.parametrize("en", [0.5, 0.9, 0.995, 0.999, 0.9999, 1])
def test_no_correction_removes_all_damping(en, damping):
    """YADE's formula has no number below 1 for an ε close to 1; elastic grains keep the damping of the integrator."""
    verdict = hl.check(MINDLIN.format(en=en, damping=damping), speed=0.1)
    for line in verdict.corrected:
        assert "restitution 1 in" not in line
        if "damping=0" in line:
            assert float(line.split()[-1]) < 1.0
    explained = [line for line in verdict.corrected if "which removes all damping" in line]
    assert bool(explained) is (0.99 < en < 1 and abs(verdict.rows[0].restitution_asked - en) < 1e-9
                               and abs(hl.check(MINDLIN.format(en=en, damping=0), speed=0.1).rows[0].restitution - en)
                               > 5e-3)  # fmt: skip


def test_the_step_of_a_state_replaces_that_of_an_error():
    """With its reason, and only if the script's is longer."""
    text = box("create_atoms 1 single 0 0 0\nset type 1 diameter 0.002 density 2500").replace("1e-7", "1e-5")
    description = read(text)
    examined = surroundings.examined(
        cases.of_script(description, [None])[0], Surroundings(), (0.3,), None, None
    )
    step = corrections.LargestStep(3e-6, "stable at 6 contacts per grain")
    assert corrections.lines("lammps", examined, 1e-3, True, step) == [
        "timestep 3e-06  # stable at 6 contacts per grain"
    ]
    assert corrections.lines("lammps", examined, 1e-3, True, step._replace(step=1e-4)) == []
    (own,) = corrections.lines("lammps", examined, 1e-3)
    assert own.startswith("timestep") and "#" not in own


# --- YADE -------------------------------------------------------------------------------------------------------

LOOP = """
O.engines = [ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb(), Bo1_Box_Aabb(), Bo1_Facet_Aabb()]), InteractionLoop(
    [Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom(), Ig2_Box_Sphere_ScGeom(), Ig2_Facet_Sphere_ScGeom()],
    [Ip2_FrictMat_FrictMat_MindlinPhys(en=0.8, es=0.8)], [Law2_ScGeom_MindlinPhys_Mindlin()]),
    NewtonIntegrator(damping=0, gravity=(0, 0, GRAVITY))]
O.dt = 1e-6
O.run(100)
"""
GLASS = "from yade import pack, ymport\nmat = O.materials.append(FrictMat(young=1e8, poisson=0.2, density=2500))\n"


def yade(bodies, gravity=0.0):
    """A script of YADE with these bodies."""
    return GLASS + bodies + LOOP.replace("GRAVITY", repr(gravity))


@pytest.mark.parametrize("seed", [0, *map(slow, range(1, 6))])
def test_spheres_in_a_periodic_cell_of_yade_have_a_packing(seed):
    rng, name = drawn(seed)
    number, radius, fuzz = rng.randint(30, 900), rng.uniform(0.001, 0.01), rng.choice([0.0, 0.3])
    cell = [round(rng.uniform(0.2, 0.9), 3) for _ in range(3)]
    number = min(number, int(0.3e-3 / (5.5 * radius**3)))  # more find no place
    sizes = f"rMean={radius!r}, rRelFuzz={fuzz}, num={number}"
    cloud = f"{name} = pack.SpherePack()\n{name}.makeCloud((0, 0, 0), {{}}, {sizes}{{}})\n"
    volume = 4.0 / 3.0 * math.pi * number * radius**3 * (1.0 + fuzz**2)
    for lines in (
        cloud.format(tuple(cell), ", periodic=True") + f"{name}.toSimulation()",
        f"O.periodic = True\nO.cell.setBox{tuple(cell)}\n"
        + cloud.format((0.1, 0.1, 0.1), "")
        + f"{name}.toSimulation()",
        f"O.periodic = True\nO.cell.hSize = Matrix3({cell[0]}, 0, 0.1, 0, {cell[1]}, 0, 0, 0, {cell[2]})\n"
        + cloud.format((0.1, 0.1, 0.1), "")
        + f"{name}.toSimulation(material=mat)",
    ):
        phi = inferred(yade(lines), "packing fraction")
        assert phi.value == pytest.approx(volume / math.prod(cell), rel=1e-9), lines
    assert (
        inferred(yade(cloud.format(tuple(cell), "") + f"{name}.toSimulation()"), "packing fraction") is None
    )


def test_spheres_of_yade_may_stand_in_files_beside_the_script(tmp_path):
    """ymport.text, textExt and SpherePack.load; without the file, the sizes are not known."""
    rng = np.random.default_rng(5)
    radii = rng.uniform(1e-3, 2e-3, 40)
    rows = "".join(
        f"{x} {y} {z} {r!r}\n" for (x, y, z), r in zip(rng.random((40, 3)), radii.tolist(), strict=True)
    )
    path, periodic = tmp_path / "box.py", "O.periodic = True\nO.cell.setBox(0.1, 0.1, 0.1)\n"
    readers = {
        "O.bodies.append(ymport.text('spheres.txt'))": 1.0,
        "O.bodies.append(ymport.text('spheres.txt', scale=2, material=mat))": 2.0,
        "O.bodies.append(ymport.textExt('spheres.txt', 'x_y_z_r', Vector3(0, 0, 1), 0.5))": 0.5,
        "sp = pack.SpherePack()\nsp.load('spheres.txt')\nsp.toSimulation()": 1.0,
    }
    for line, scale in readers.items():
        (tmp_path / "spheres.txt").unlink(missing_ok=True)
        saved(tmp_path, yade(periodic + line), "box.py")
        assert hl.check(path, speed=0.1).rows[0].radius is None
        saved(tmp_path, f"#format x_y_z_r\n{rows}", "spheres.txt")
        verdict = hl.check(path, speed=0.1)
        ends = verdict.rows[0].radius, verdict.rows[-1].radius
        assert ends == pytest.approx((scale * radii.min(), scale * radii.max())) and not verdict.unknown
        (phi,) = verdict.inferred
        assert phi.value == pytest.approx(4 / 3 * math.pi * scale**3 * (radii**3).sum() / 1e-3)
    saved(tmp_path, f"#format x_y_z_r_matId\n{rows}", "spheres.txt")
    assert hl.check(path, speed=0.1).unknown or "load" in line


@pytest.mark.parametrize(("floor", "height"), [
    ("O.bodies.append(wall(0.1, axis=2, material=mat))", 0.4),
    ("O.bodies.append(wall((5, 5, 0.2), 2))", 0.3),
    ("O.bodies.append(box((0, 0, 0), (1, 1, 0.05), fixed=True))", 0.45),
    ("O.bodies.append(facet([(0, 0, 0.1), (1, 0, 0.1), (0, 1, 0.1)]))", 0.4),
    ("O.bodies.append(geom.facetBox((0, 0, 0.5), (1, 1, 0.25)))", 0.25),
])  # fmt: skip
def test_spheres_of_yade_fall_on_what_is_below_them(floor, height):
    singles = "O.bodies.append(sphere((0, 0, 0.5), 0.01, material=mat))\nO.bodies.append(sphere((0.1, 0, 0.45), 0.01))"
    cloud = "sp = pack.SpherePack()\nsp.makeCloud((0, 0, 0.4), (1, 1, 0.5), rMean=0.01)\nsp.toSimulation()"
    for spheres, radius in (
        (singles, 0.01),
        (cloud, 0.0),
    ):  # a single sphere falls until its lowest point is there
        speed = inferred(yade(f"from yade import geom\n{spheres}\n{floor}\n", -9.81), "speed")
        assert speed.value == pytest.approx(math.sqrt(2 * 9.81 * (height - radius))) and not speed.decides
        assert "from where spheres are made" in str(speed)


def test_velocities_of_single_bodies_of_yade_are_read():
    two = "O.bodies.append([sphere((0, 0, 0), 1e-3), sphere((0, 0, 3e-3), 1e-3)])\n"
    known = f"{two}O.bodies[0].state.vel = (0, 0, 0.5)\nO.bodies[1].state.vel = Vector3(0, 0, -0.7)"
    assert inferred(yade(known), "speed").value == pytest.approx(1.2)
    for more in (
        "\nfor b in O.bodies: b.state.vel = random.random()*Vector3(1, 1, 1)",
        "\nO.bodies[0].state.vel = v0",
    ):
        assert inferred(yade(known + more), "speed") is None


@pytest.mark.parametrize("line", [
    "O.bodies.erase(3)",
    "for c, r in sp: O.bodies.append(sphere(c, r))",
    "O.bodies.append(sphere((0, 0, z), 1e-3) for z in rows)",
])  # fmt: skip
def test_a_number_of_spheres_that_is_not_known_is_not_guessed(line):
    cloud = "sp = pack.SpherePack()\nsp.makeCloud((0, 0, 0), (1, 1, 1), rMean=0.01, num=100, periodic=True)\n"
    cloud += "sp.toSimulation()\n"
    assert inferred(yade(cloud), "packing fraction") is not None
    assert inferred(yade(cloud + line), "packing fraction") is None


# --- LIGGGHTS ---------------------------------------------------------------------------------------------------

BEADS = """units {units}
atom_style granular
boundary {boundary}
region reg block 0 1 0 2 0 1 units box
create_box 1 reg
pair_style gran model hertz tangential off
fix m1 all property/global youngsModulus peratomtype 5e6
fix m2 all property/global poissonsRatio peratomtype 0.3
fix m3 all property/global coefficientRestitution peratomtypepair 1 0.9
fix pts1 all particletemplate/sphere 1 atom_type 1 density constant 2500 radius constant {radius}
fix pdd1 all particledistribution/discrete 7 1 pts1 1.0
{lines}
fix integr all nve/sphere
timestep 1e-6
run 100
"""


@pytest.mark.parametrize("seed", [0, *map(slow, range(1, 6))])
def test_liggghts_says_how_much_is_inserted(seed):
    """A volume fraction of a region, or a number of grains, that is inserted once."""
    rng, _ = drawn(seed)
    share, number, radius = rng.uniform(0.05, 0.4), rng.randint(20, 400), rng.uniform(0.005, 0.02)
    units, inner = rng.choice(["si", "cgs"]), rng.uniform(0.2, 0.9)
    ball = 4.0 / 3.0 * math.pi * radius**3
    region = f"region part block 0 1 0 2 0 {inner!r} units box\n"
    pack = "fix ins all insert/pack seed 7 distributiontemplate pdd1 insert_every {} region part {} {}"
    for every, word, value, wanted in (
        ("once", "volumefraction_region", share, share * inner),
        ("once", "particles_in_region", number, number * ball / 2.0),
        (100, "volumefraction_region", share, None),
    ):
        text = BEADS.format(
            units=units, boundary="p p p", radius=repr(radius), lines=region + pack.format(every, word, value)
        )
        phi = inferred(text, "packing fraction")
        assert phi is None if wanted is None else phi.value == pytest.approx(wanted, rel=1e-9), (every, word)


def test_grains_of_liggghts_fall_from_their_region():
    """Onto a primitive wall; onto a mesh at most to the end of the box."""
    lines = """region part block 0 1 0 2 0.7 0.8 units box
fix g all gravity 9.81 vector 0 0 -1
fix floor all wall/gran model hertz tangential off primitive type 1 zplane 0.3
fix ins all insert/rate/region seed 7 distributiontemplate pdd1 nparticles 500 particlerate 100 insert_every 10 &
    overlapcheck yes vel constant 0 0 -2 region part"""
    text = BEADS.format(units="si", boundary="p p f", radius=0.01, lines=lines)
    speed = inferred(text, "speed")
    assert speed.value == pytest.approx(math.sqrt(4.0 + 2 * 9.81 * 0.5)) and "insertion region" in str(speed)
    mesh = "fix cad all mesh/surface file a.stl type 1\n"
    mesh += "fix floor all wall/gran model hertz tangential off mesh n_meshes 1 meshes cad"
    lines = re.sub("fix floor .*", mesh, lines)
    speed = inferred(BEADS.format(units="si", boundary="p p f", radius=0.01, lines=lines), "speed")
    assert speed.value == pytest.approx(math.sqrt(4.0 + 2 * 9.81 * 0.8)) and "at most" in str(speed)


def test_a_belt_of_liggghts_has_its_speed():
    lines = "fix cad all mesh/surface file a.stl type 1\nfix move all move/mesh mesh cad linear 3. 0. 4.\n"
    lines += "fix belt all wall/gran model hertz tangential off mesh n_meshes 1 meshes cad"
    speed = inferred(BEADS.format(units="si", boundary="p p f", radius=0.01, lines=lines), "speed")
    assert speed.value == pytest.approx(5.0)


# --- nothing ends in an exception -------------------------------------------------------------------------------

WORDS = """
0 1 -1 1e300 1e-300 0.5 2 nan x y z all part none sc fcc hex bcc block sphere cylinder prism INF EDGE units box
lattice origin create set scale ramp random single region NULL overlap 0.01 v_a ${b} p f diam one poly range dens vel
side out volumefraction_region nparticles once particles_in_region insert_every zplane zcylinder 10 100 7 sum yes -inf
"""
STARTS = """lattice
region part
region part block
region part cylinder z
velocity
boundary
replicate
create_atoms 1
fix ins all pour
fix ins all deposit
fix ins all insert/pack seed 7 distributiontemplate pdd1
fix g all gravity
fix w all wall/gran granular hooke 1e5 0.9 damping coeff_restitution
fix m all move
change_box all
delete_atoms
set type 1 diameter
minimize"""
ARGUMENTS = (
    "0 1 -1 0.5 1e300 10**400 None 'x' x True (0,0,0) (1,1,1) (1,2) [] Vector3(0,0,1) float('nan') mat sp"
)
CALLS = """sp.makeCloud({})
sp.load({})
sp.add({})
sp.scale({})
sp.toSimulation()
O.cell.setBox({})
O.cell.hSize = Matrix3({})
O.periodic = ({})
O.bodies.append(wall({}))
O.bodies.append(box({}))
O.bodies.append(facet([{}]))
O.bodies.append(facet({}))
O.bodies.append(sphere({}))
O.bodies.append(geom.facetBox({}))
O.bodies.append(ymport.text({}))
O.bodies.append(ymport.textExt({}))
O.bodies[0].state.vel = ({})
O.bodies.erase({})
O.bodies.clear()"""


def assert_sound(text):
    """What follows from a script that is not refused is a positive number."""
    try:
        stages = read(text).stages
    except ValueError:
        return
    numbers = [stated.speed(stages), *map(stated.packing_fraction, stages)] if stages else []
    assert all(0.0 < number.value < math.inf for number in numbers if number is not None), text


@pytest.mark.parametrize("seed", [*range(4), *(slow(seed) for seed in range(4, 60))])
def test_statements_of_any_words_are_read_or_quoted(seed):
    """A number, or none; never an exception but a refusal."""
    rng = random.Random(seed)

    def some(starts, words, most, join):
        return rng.choice(starts), join.join(rng.choice(words) for _ in range(rng.randint(0, most)))

    for _ in range(10):
        lines = [" ".join(some(STARTS.split("\n"), WORDS.split(), 9, " ")) for _ in range(rng.randint(1, 6))]
        at = rng.randint(0, len(lines))
        grains = "create_atoms 1 random 100 7 cell\nset type 1 diameter 0.01"
        assert_sound(box(*lines[:at], grains, *lines[at:]))
        assert_sound(BEADS.format(units="si", boundary="p p f", radius=0.01, lines="\n".join(lines)))
        calls = [some(CALLS.split("\n"), ARGUMENTS.split(), 6, ", ") for _ in range(rng.randint(1, 6))]
        bodies = "\n".join(call.format(arguments) for call, arguments in calls)
        assert_sound(yade(f"sp = pack.SpherePack()\n{bodies}", rng.choice([0.0, -9.81])))


SHEARED = """units si
atom_style sphere
boundary p p p
region b prism 0 0.1 0 0.1 0 0.1 0 0 0
create_box 1 b
create_atoms 1 random 500 12345 NULL
set type 1 diameter 0.004 density 2500
pair_style granular
pair_coeff * * hooke 1e5 {} damping coeff_restitution
fix 1 all nve/sphere
fix 2 all deform 1 xy erate 100 remap v
timestep 1e-6
run 1000
pair_coeff * * hooke 1e5 0.95 damping coeff_restitution
run 1000
"""


def test_a_run_before_the_last_one_leaves_the_speed_of_the_steady_state():
    """Kinetic theory of shear is that of ε from 0.5 on; a run that packs the grains with less is no steady state."""
    packed, alone = hl.check(SHEARED.format(0.1)), hl.check(SHEARED.format(0.95))
    assert not any("No speed from" in remark for remark in packed.remarks)
    assert packed.missing == alone.missing == ()
    low = hl.check(SHEARED.format(0.95).replace("1e5 0.95", "1e5 0.1"))
    assert any("ε from 0.5 on" in remark for remark in low.remarks) and "speeds" in low.missing
