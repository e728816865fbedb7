"""Grains of a restart file are those that the script makes which writes it, if it lies in the same folder."""

import math

import pytest

import hardlimit as hl

MODEL = """
fix m1 all property/global youngsModulus peratomtype 5e6
fix m2 all property/global poissonsRatio peratomtype 0.45
fix m3 all property/global coefficientRestitution peratomtypepair 1 0.3
fix m4 all property/global coefficientFriction peratomtypepair 1 0.5
pair_style gran model hertz tangential history
pair_coeff * *
timestep 1e-5
fix floor all wall/gran model hertz tangential history primitive type 1 zplane 0.0
fix g all gravity 9.81 vector 0 0 -1
fix move all nve/sphere
"""
FILL = """units si
atom_style granular
boundary p p f
region box block 0 0.1 0 0.2 0 0.5 units box
create_box 1 box
{model}
fix pts all particletemplate/sphere 15485863 atom_type 1 density constant 2000 radius constant 0.002
fix pdd all particledistribution/discrete 32452843 1 pts 1.0
fix ins all insert/pack seed 49979687 distributiontemplate pdd insert_every once particles_in_region {count} region box
run 10000
write_restart {file}
"""
GO_ON = "units si\natom_style granular\nread_restart {file}\n{model}\nrun 10000\n"
#: N m g/A of 9000 grains.
COUNT = 9000
WEIGHT = COUNT * 2000.0 * 4.0 / 3.0 * math.pi * 0.002**3 * 9.81 / (0.1 * 0.2)


@pytest.fixture
def folder(tmp_path):
    """A folder with the script that fills the box and one that goes on."""

    def write(name="in.go_on", text=GO_ON, **words):
        values = {"model": MODEL, "count": COUNT, "file": "post/settled.restart", **words}
        (tmp_path / name).write_text(text.format(**values), encoding="utf-8")
        return tmp_path / name

    write("in.fill", FILL)
    return write


def test_the_grains_are_those_of_the_script_that_writes_the_file(folder):
    verdict = hl.check(folder())
    assert verdict.state.pressure == pytest.approx(WEIGHT) and not verdict.unknown
    assert any("as in.fill makes them, which writes it" in finding.what for finding in verdict.warnings)
    elsewhere = folder(file="post/../post/settled.restart")
    assert hl.check(elsewhere).state.pressure == pytest.approx(WEIGHT)
    moved = folder(file="other/settled.restart")
    assert hl.check(moved).state.pressure is None and "read_restart" in str(hl.check(moved).unknown)


def test_scripts_in_a_row(folder):
    """A script may go on where the one before it ended; grains that it adds come to those of the file."""
    more = FILL.partition("fix pts")[2].partition("run")[0]
    half = "region half block 0 0.1 0 0.2 0.25 0.5 units box\n"
    text = GO_ON.replace("run 10000\n", f"{half}fix pts{more}run 10000\nwrite_restart post/twice.restart\n")
    folder("in.more", text.replace("region box", "region half"))
    last = folder("in.last", file="post/twice.restart")
    state = hl.check(last).state
    assert state.pressure == pytest.approx(2.0 * WEIGHT)


@pytest.mark.parametrize("text", [
    FILL.replace("run 10000", "delete_atoms overlap 0.1 all all\nrun 10000"),  # how many are left is not known
    FILL.replace("particles_in_region {count}", "unheard {count}").replace("fix move", "fix other"),
    FILL.replace("units si", "units si\nread_restart other.restart"),
    FILL.replace("sphere 15485863", "multisphere 15485863"),
    FILL + "jump SELF\n",  # never ends
    FILL.replace("run 10000", "fix r all rigid/small molecule\nrun 10000"),
    FILL.replace("create_box", "bond_style harmonic\ncreate_box"),
    FILL.replace("write_restart", "# write_restart"),
])  # fmt: skip
def test_what_is_not_known_of_the_file_is_not_taken(folder, text):
    folder("in.fill", text)
    state = hl.check(folder()).state
    assert state.pressure is None or state.pressure_is_bound


def test_units_are_those_of_the_file(folder):
    without = folder(text=GO_ON.replace("units si\n", ""))
    assert hl.check(without).state.pressure == pytest.approx(WEIGHT) and hl.check(without).units == "si"
    other = folder(text=GO_ON.replace("units si", "units cgs"))
    assert hl.check(other).state.pressure is None


def test_two_scripts_that_write_the_file(folder):
    folder("in.again", FILL, count=10)
    verdict = hl.check(folder())
    assert verdict.state.pressure is None and "read_restart" in str(verdict.unknown)


def test_the_weight_of_grains_in_a_fluid_is_said_to_be_that_without_it(folder):
    """A fluid may carry a part of the weight, or add to it."""
    dragged = folder(
        model=f"{MODEL}fix cfd all couple/cfd couple_every 100 mpi\nfix f all couple/cfd/force\n"
    )
    assert "without the fluid" in hl.check(dragged).sentence
    assert "without the fluid" not in hl.check(folder()).sentence


@pytest.mark.parametrize("name", ["settled.7", "settled.39", "settled.end"])
def test_files_that_the_rounds_of_a_loop_write(folder, name):
    """Equal rounds are read once, unless they write files of different names; a long loop hides no file after it."""
    loop = "variable k loop {}\nlabel a\nrun 10\n{}next k\njump SELF a\nwrite_restart post/settled.end\n"
    rounds = (100_000, "print $k\n") if name.endswith("end") else (40, "write_restart post/settled.$k\n")
    folder("in.fill", FILL.replace("run 10000\n", loop.format(*rounds)))
    go_on = folder(file=f"post/{name}")
    assert hl.check(go_on).state.pressure == pytest.approx(WEIGHT)
    missing = hl.check(folder(file="post/settled.41"))
    assert missing.state.pressure is None and "read_restart" in str(missing.unknown)
