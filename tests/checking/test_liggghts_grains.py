"""What LIGGGHTS' scripts say of clumps, of grains that never meet, of servo walls and of beds with adhesion."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import hardlimit as hl
from hardlimit.checking import at_rest
from hardlimit.checking.scripts import clumps, meshes, read

HEAD = """units si
atom_style granular
boundary {boundary}
region box block 0 0.1 0 0.1 0 0.2 units box
create_box 1 box
fix m1 all property/global youngsModulus peratomtype 5e6
fix m2 all property/global poissonsRatio peratomtype 0.45
fix m3 all property/global coefficientRestitution peratomtypepair 1 0.9
fix m4 all property/global coefficientFriction peratomtypepair 1 {friction}
fix m5 all property/global characteristicVelocity scalar 1
pair_style gran model {model}
pair_coeff * *
timestep 1e-6
"""
GRAVITY = "fix g all gravity 9.81 vector 0 0 -1\n"
SPHERE = (
    "fix t all particletemplate/sphere 15485863 atom_type 1 density constant 2500 radius constant 0.001\n"
)
PACK = (
    "fix d all particledistribution/discrete 15485867 1 t 1.0\n"
    "fix ins all insert/pack seed 32452843 distributiontemplate d vel constant 0 0 -0.5 insert_every once"
    " overlapcheck yes region box volumefraction_region 0.1\n"
)
MOVE = "fix move all nve/sphere\nrun 1000\n"
WALL = "fix floor all wall/gran model hertz tangential history primitive type 1 zplane 0\n"


def head(boundary="f f f", friction=0.5, model="hertz tangential history"):
    """The begin of a script."""
    return HEAD.format(boundary=boundary, friction=friction, model=model)


# --- clumps -----------------------------------------------------------------------------------------------------


def test_the_volume_of_a_clump():
    """One sphere, a pair that touches, a lens, and many spheres against random points."""
    ball = 4.0 / 3.0 * math.pi
    ball_alone = np.array([[0.3, -2.0, 1.0, 1.0]])
    assert clumps.volume(ball_alone) == pytest.approx(ball, rel=1e-4)
    for axis in range(3):
        for apart, lens in ((2.0, 0.0), (1.0, math.pi * 5.0 / 12.0), (0.0, ball)):
            other = ball_alone + apart * np.eye(4)[axis]
            assert clumps.volume(np.vstack([ball_alone, other])) == pytest.approx(2.0 * ball - lens, rel=1e-4)
    draw = np.random.default_rng(4)
    many = np.column_stack([draw.uniform(-1.0, 1.0, (12, 3)), draw.uniform(0.2, 0.7, 12)])
    points = draw.uniform(-1.7, 1.7, (400_000, 3))
    inside = np.zeros(len(points), bool)
    for *centre, radius in many:
        inside |= ((points - centre) ** 2).sum(axis=1) < radius**2
    assert clumps.volume(many) == pytest.approx(3.4**3 * inside.mean(), rel=0.01)


ROD = "-0.0005 0 0 0.001 0.0005 0 0 0.001"
#: Two spheres of R = 1 mm, 1 mm apart.
ROD_VOLUME = 8.0 / 3.0 * math.pi * 1e-9 - math.pi * 5e-9 / 12.0
CLUMP = (
    "fix t all particletemplate/multisphere 15485863 atom_type 1 density constant 2500 nspheres 2 ntry 1000000"
    f" spheres {ROD} type 1\n"
)
BODIES = "fix ms all multisphere\nrun 1000\n"


def test_clumps_count_as_spheres_of_their_volume():
    script = head("p p p", 0.0) + CLUMP + PACK + BODIES
    description = read(script)
    (grains,) = description.stages[0].grains.values()
    radius = (0.75 / math.pi * ROD_VOLUME) ** (1.0 / 3.0)
    assert grains.radii == pytest.approx((radius, radius), rel=1e-4) and grains.densities == (2500.0, 2500.0)
    assert description.stages[0].contents.filled == pytest.approx(0.1 * 0.1 * 0.1 * 0.2)
    assert any("clumps" in note.what for note in description.invalidates) and not description.unknown
    verdict = hl.check(script, speed=0.1)
    spheres = hl.check(
        head("p p p", 0.0) + SPHERE.replace("constant 0.001", f"constant {grains.radii[0]!r}") + PACK + MOVE,
        speed=0.1,
    )
    assert verdict.rows[0].tc_nu == pytest.approx(spheres.rows[0].tc_nu) and verdict.rows[0].tc_nu > 0.0
    assert verdict.admissible is False and "clumps (particletemplate/multisphere)" in verdict.sentence
    assert [note.what for note in verdict.warnings] == ["clumps count as spheres of their volume and mass"]
    assert not hl.check(script.replace(CLUMP, ""), speed=0.1).rows[0].tc_nu
    coarse = read(script.replace("units si\n", "units si\ncoarsegraining 2\n"))
    assert coarse.stages[0].grains["1"].radii[0] == pytest.approx(2.0 * grains.radii[0])


def test_clumps_from_a_file(tmp_path):
    (tmp_path / "rod.txt").write_text("# a rod\n\n-0.5 0 0 1 # left\n0.5 0 0 1\n9 9 9 9\n", encoding="utf-8")
    path = tmp_path / "in.rods"
    from_file = CLUMP.replace(ROD, "file rod.txt scale 0.001")
    path.write_text(head() + from_file + PACK + BODIES, encoding="utf-8")
    inline = read(head() + CLUMP + PACK + BODIES).stages[0].grains["1"]
    assert read(path).stages[0].grains["1"].radii == pytest.approx(inline.radii)
    for wrong in (
        "file none.txt scale 0.001",
        "file rod.txt scale 0",
        "file rod.txt scale x",
        "0 0 0",
        "0 0 0 -1 0 0 0 1",
    ):
        path.write_text(head() + CLUMP.replace(ROD, wrong) + PACK + BODIES, encoding="utf-8")
        description = read(path)
        assert description.stages[0].grains["1"].radii is None
        assert "the spheres of the clump are not known" in description.unknown[0].text
        assert description.stages[0].grains["1"].densities == (2500.0, 2500.0)


def test_a_log_prints_the_radii_of_its_clumps():
    """A log without the file of the spheres."""
    template = CLUMP.replace(ROD, "file rod.txt scale 0.001")
    printed = (
        "Finished calculating properties of template\n"
        "   mass = 1.7e-05, radius of bounding sphere = 1.500000e-03, radius of equivalent sphere = 1.190551e-03\n"
    )
    log = "LIGGGHTS (Version LIGGGHTS-PUBLIC 3.8.0)\n" + head() + template + "{}" + PACK + BODIES
    assert read(log.format(printed)).stages[0].grains["1"].radii == (1.190551e-3, 1.190551e-3)
    assert read(log.format("")).stages[0].grains["1"].radii is None


def test_clumps_of_a_script_whose_log_lies_beside_it(tmp_path):
    """The file of the spheres is not there, but the log of an earlier run is."""
    template = CLUMP.replace(ROD, "file rod.txt scale 0.001")
    path, log = tmp_path / "in.rods", tmp_path / "log.rods"
    path.write_text(f"log log.rods\n{head()}{template}{PACK}{BODIES}", encoding="utf-8")
    assert read(path).stages[0].grains["1"].radii is None
    below = (
        "Finished\n   mass = 1, radius of bounding sphere = 1.5e-03, radius of equivalent sphere = 1.2e-03\n"
    )
    log.write_text(f"{head()}{template}{below}", encoding="utf-8")
    description = read(path)
    assert description.stages[0].grains["1"].radii == (1.2e-3, 1.2e-3) and not description.unknown
    assert "the sizes of clumps are those that log.rods prints" in [
        note.what for note in description.warnings
    ]
    log.write_text(f"{head()}{template.replace('nspheres 2', 'nspheres 3')}{below}", encoding="utf-8")
    assert read(path).stages[0].grains["1"].radii is None  # of another template


def test_grains_that_are_removed(tmp_path):
    """Their number is not known; those that fall freely go on to do so."""
    remove = "fix r all remove nevery 100 massrate 7 style delete seed 7 region box atomtype 1\n"
    stage = read(FALL.replace("fix move", remove + "fix move")).stages[0]
    assert (
        stage.contents.filled is None and stage.contents.never_meet and read(FALL).stages[0].contents.filled
    )


def test_long_clumps_are_said_to_be_rough_estimates():
    spheres = "-0.001 0 0 0.001 0 0 0 0.001 0.001 0 0 0.001"
    (note,) = read(
        head() + CLUMP.replace("nspheres 2", "nspheres 3").replace(ROD, spheres) + PACK + BODIES
    ).warnings[:1]
    assert "rough estimates" in note.what and note.types == ("1",)


def test_a_bed_of_clumps_has_a_softness_but_no_step():
    """Arms and moments of inertia of clumps are not those of spheres."""
    sides = "".join(
        f"fix {axis}{k} all wall/gran model hertz tangential history primitive type 1 {axis}plane {0.1 * k}\n"
        for axis in "xy"
        for k in (0, 1)
    )
    bed = head() + GRAVITY + WALL + sides + "{}" + PACK
    state = hl.check(bed.format(CLUMP) + BODIES).state
    assert state.name == "rest" and state.largest_stable_step is None and state.step_share is None
    radius = (0.75 / math.pi * ROD_VOLUME) ** (1.0 / 3.0)
    spheres = hl.check(bed.format(SPHERE.replace("constant 0.001", f"constant {radius!r}")) + MOVE).state
    assert state.stiffness_number == pytest.approx(spheres.stiffness_number, rel=1e-4)
    assert state.pressure == pytest.approx(2500.0 * 9.81 * 0.1 * 0.2, rel=1e-3)
    assert spheres.largest_stable_step is not None


@pytest.mark.parametrize("share,filled", [("mass_in_region 0.5", 2e-4), ("volumefraction_region 0.05", 1e-4)])
def test_what_fills_a_region_once(share, filled):
    script = head() + SPHERE + PACK.replace("volumefraction_region 0.1", share) + MOVE
    assert read(script).stages[0].contents.filled == pytest.approx(filled)
    assert read(script.replace("insert_every once", "insert_every 100")).stages[0].contents.filled is None


def test_shares_of_distributions():
    """Of the mass, or of the number of grains; a template without a share has no grains."""
    two = SPHERE + SPHERE.replace("fix t ", "fix u ").replace("0.001", "0.002")
    fill = PACK.replace("volumefraction_region 0.1", "particles_in_region 900")

    def lots(style, first, second):
        text = fill.replace("discrete 15485867 1 t 1.0", f"{style} 15485867 2 t {first} u {second}")
        return read(head() + two + text + MOVE).stages[0]

    by_mass, by_number = (lots(style, 0.5, 0.5).contents for style in ("discrete", "discrete/numberbased"))
    assert [lot.number for lot in by_mass.lots] == pytest.approx([800.0, 100.0])
    assert [lot.number for lot in by_number.lots] == pytest.approx([450.0, 450.0])
    alone = lots("discrete", 0, 1)
    assert alone.grains["1"].radii == (0.002, 0.002) and alone.contents.count == 900.0


# --- shear ------------------------------------------------------------------------------------------------------


def test_lees_edwards_boundaries_shear():
    script = (
        head("p p p", 0.0) + SPHERE + PACK.replace("0 0 -0.5", "0 0 0") + "fix le all lebc -100 true\n" + MOVE
    )
    verdict = hl.check(script)
    by_option = hl.check(script.replace("fix le all lebc -100 true\n", ""), shear_rate=100.0)
    assert verdict.quantity == "stress" and verdict.rows[0].tc_nu == pytest.approx(by_option.rows[0].tc_nu)
    assert not verdict.unknown and verdict.rows[0].tc_nu > 0.0
    unknown = read(script.replace("lebc -100", "lebc v_rate")).stages[0]
    assert unknown.shear_rate is None and "unknown rate" in unknown.driven[0].what


def test_a_shear_rate_gives_the_speed_up_to_half_packed_spheres():
    """Theory is measured there: see ``DENSEST_IN_SHEAR``."""
    packed = PACK.replace("0 0 -0.5", "0 0 0").replace("region 0.1", "region {}")
    script = head("p p p", 0.0) + SPHERE + packed + "fix le all lebc 100 true\n" + MOVE
    for phi in (0.49, 0.5):
        verdict = hl.check(script.format(phi))
        gas = hl.theory.Gas(1, 1e-3, 2500.0 * 4e-9 / 3.0 * math.pi, 4e-9 / 3.0 * math.pi / phi, 3)
        expected = math.sqrt(math.pi * gas.rotating(0.9, 0.0, 0.0).sheared_temperature(100.0))
        assert verdict.rows[0].speed == pytest.approx(expected, rel=0.01) and verdict.rows[0].tc_nu
        assert (
            hl.check(script.format(phi).replace("lebc 100", "lebc 200")).rows[0].tc_nu > verdict.rows[0].tc_nu
        )
    dense = hl.check(script.format(0.51))
    assert dense.rows[0].tc_nu is None and any(
        "up to a packing fraction of 0.5" in note for note in dense.remarks
    )
    heated = hl.check(script.format(0.5).replace("fix le all lebc 100 true\n", ""), power=1e-9)
    assert heated.rows[0].tc_nu is None


# --- grains that break, and those of two sizes for the same grains -----------------------------------------------

BREAKING = (
    "fix f all particletemplate/fragments 31 atom_type 1 density constant 2500 breakage_index 0.2 0.08\n"
    "fix fd all particledistribution/discrete 21 1 f 1.0\n"
    "fix break all break/particle seed 11 distributiontemplate fd energy_threshold 0.1 min_radius 0.0001\n"
)


def test_grains_have_the_numbers_before_they_break():
    """The model's force is Hertz', but between fragments of one grain."""
    bed = head("f f f") + GRAVITY + SPHERE + PACK + WALL + MOVE
    assert bed.count("hertz") == 2
    whole, breaking = (
        hl.check(bed),
        hl.check(bed.replace("hertz", "hertz/break").replace("fix move", BREAKING + "fix move")),
    )
    assert breaking.state == whole.state and whole.state.stiffness_number
    assert [row.duration for row in breaking.rows] == [row.duration for row in whole.rows]
    assert {what.what for what in breaking.invalidates} - {what.what for what in whole.invalidates} == {
        "grains that break (break/particle)"
    }
    assert any("before they break" in finding.what for finding in breaking.warnings) and not breaking.unknown
    assert any(
        "fragments of one grain" in note.what for note in read(bed.replace("hertz", "hertz/break")).ignored
    )


FINE = (
    "fix flow all massflow/mesh/face mesh m count once cg 4\n"
    "fix fine all insert/pack/face seed 7 {} cg {} region box\n"
)


@pytest.mark.parametrize("cg,radius", [(2, 0.0005), (1, 0.00025)])
def test_grains_of_another_coarse_graining_level(cg, radius):
    two = (head("f f f") + GRAVITY + SPHERE + PACK + WALL + MOVE).replace("box 1 box", "box 2 box")
    two = two.replace("peratomtypepair 1 0.9", "peratomtypepair 2 0.9 0.9 0.9 0.9").replace(
        "peratomtypepair 1 0.5", "peratomtypepair 2 0.5 0.5 0.5 0.5"
    )
    two = two.replace("peratomtype 5e6", "peratomtype 5e6 5e6").replace(
        "peratomtype 0.45", "peratomtype 0.45 0.45"
    )
    script = two.replace("fix move", FINE.format("type_offset 1 massflow_face flow", cg) + "fix move")
    grains = read(script).stages[0].grains
    assert grains["1"].radii == (0.001, 0.001) and grains["2"].radii == pytest.approx((radius, radius))
    assert hl.check(script).state.pressure and not read(script).unknown
    assert read(script).stages[0].contents.count is None
    again = FINE.replace("fix flow", "fix low").replace("fix fine", "fix finer").replace("cg 4", f"cg {cg}")
    again = again.format("type_offset 1 massflow_face low", 1)
    third = script.replace("box 2 box", "box 3 box").replace("fix move", f"{again}fix move")
    levels = read(third).stages[0].grains
    assert list(levels) == ["1", "2", "3"] and levels["3"].radii == pytest.approx((0.00025, 0.00025))
    assert levels["2"].radii == grains["2"].radii
    other = FINE.replace("fix f", "fix g").format("type_offset 1 massflow_face glow", cg)
    beside = script.replace("fix move", f"{other}fix move")
    assert read(beside).stages[0].grains == grains
    for unknown in ("massflow_face other type_offset 1", "type_offset 1"):
        assert read(script.replace("type_offset 1 massflow_face flow", unknown)).unknown


# --- grains that never meet -------------------------------------------------------------------------------------

FALL = head() + GRAVITY + SPHERE + PACK + MOVE
SINGLE = "create_atoms 1 single {} 0.05 0.1\n"
ATOMS = (
    head()
    + GRAVITY
    + "".join(SINGLE.format(0.01 * k + 0.03) for k in range(4))
    + "set type 1 diameter 0.004 density 9\n"
)


def never_meet(script):
    """Whether the grains of a script never meet."""
    return hl.check(script).state.never_meet


def test_grains_in_free_fall_never_meet():
    """LIGGGHTS itself counts no contact of 3094 such grains in 15,000 steps."""
    verdict = hl.check(FALL)
    assert verdict.state.never_meet and verdict.state.supposed_tc_nu is None and verdict.missing == ()
    assert verdict.admissible is None and "no grain meets another or a wall (t_c ν = 0)" in verdict.sentence
    assert verdict.state.to_dict()["never_meet"] is True
    assert never_meet(FALL.replace("boundary f f f", "boundary p p p")) and never_meet(
        FALL.replace(GRAVITY, "")
    )
    assert never_meet(ATOMS + MOVE)


@pytest.mark.parametrize(
    "old,new",
    [
        ("fix move", WALL + "fix move"),
        ("vel constant", "vel uniform"),
        ("overlapcheck yes", "overlapcheck no"),
        ("insert_every once", "insert_every 100"),
        ("insert/pack", "insert/stream"),
        ("run", "velocity all set 1 0 0\nrun"),
        ("run", "velocity all create 1.0 4\nrun"),
        ("run", "set atom 3 vx 1\nrun"),
        ("run", "set type 1 diameter 0.02\nrun"),
        ("run", "create_atoms 1 single 0.05 0.05 0.1\nrun"),
        ("run", "read_restart old\nrun"),
        ("run", "displace_atoms all random 0.1 0.1 0.1 3\nrun"),
        ("run", "fix slow all viscous 0.1\nrun"),
        ("run", "fix heat all langevin 1 1 1 3\nrun"),
        ("run", "fix b all wall/reflect zlo EDGE\nrun"),
        ("run", "fix stop all freeze\nrun"),
        ("run", "fix le all lebc 3.0\nrun"),
        ("run", WALL + "run 10\nunfix floor\nrun"),
        ("fix g all", "fix g half"),
        ("gravity 9.81", "gravity v_g"),
        ("fix move", GRAVITY.replace("fix g", "fix h").replace("0 0 -1", "1 0 0") + "fix move"),
        ("fix ins", PACK.splitlines()[1].replace("fix ins", "fix two").replace("-0.5", "-0.6") + "\nfix ins"),
    ],
)
def test_what_makes_grains_meet(old, new):
    changed = FALL.replace(old, new)
    assert changed != FALL and not never_meet(changed)


@pytest.mark.parametrize(
    "more",
    [
        SINGLE.format(0.061),
        SINGLE.format(0.061).replace("single", "random 5 3 NULL #"),
        "create_atoms 1 box\n",
    ],
)
def test_single_grains_that_overlap_meet(more):
    apart = SINGLE.format(0.061).replace("0.1\n", "0.11\n")
    assert never_meet(ATOMS.replace("set type", apart + "set type") + MOVE)
    script = ATOMS.replace("set type", more + "set type") + MOVE
    assert not never_meet(script)


def test_grains_meet_over_periodic_ends():
    script = ATOMS.replace("set type", SINGLE.format(0.001) + SINGLE.format(0.099) + "set type") + MOVE
    assert never_meet(script) and not never_meet(script.replace("boundary f", "boundary p"))


@pytest.mark.parametrize("velocity", ["", " vx 0 vz 0", " vz -3"])
def test_one_grain_meets_nothing_without_a_wall(velocity):
    """With a given speed it has the numbers of a contact at this speed."""
    alone = head() + GRAVITY + SINGLE.format(0.03) + f"set atom 1 diameter 0.004 density 9{velocity}\n" + MOVE
    verdict = hl.check(alone)
    assert verdict.state.never_meet and verdict.state.step_share is None and not verdict.corrected
    chosen = hl.check(alone, speed=0.1).state
    assert chosen.grains == 1 and chosen.duration and not chosen.never_meet
    assert not hl.check(alone.replace("run", WALL + "run")).state.never_meet


def test_two_grains_side_by_side_fall_alike():
    pair = ATOMS.partition("create_atoms")[0] + SINGLE.format(0.03) + SINGLE.format(0.05)
    script = pair + "set atom 1 diameter 0.004 density 9 vz 0\nset atom 2 diameter 0.004 density 9\n" + MOVE
    assert hl.check(script).state.never_meet
    meeting = script.replace("vz 0", "vx 1")
    assert hl.check(meeting).state.grains == 2


def test_the_speed_of_an_insertion_without_gravity():
    script = FALL.replace(GRAVITY, WALL)
    (speed,) = [number for number in hl.check(script).inferred if number.what == "speed"]
    assert (speed.value, speed.source) == (0.5, "the insertion")
    assert not hl.check(script.replace("0 0 -0.5", "0 0 0")).inferred


# --- servo walls ------------------------------------------------------------------------------------------------

SERVO = (
    "fix {name} all mesh/surface/stress/servo file plane.stl type 1 rotate axis 0 1 0 angle 90 com 0 0 0 ctrlPV force"
    " axis {axis} target_val 0.001 vel_max 0.2 kp 1\n"
)
SIX = "".join(
    SERVO.format(name=f"{axis}{k}", axis=" ".join(f"{(1 - 2 * k) * (axis == other)}" for other in "xyz"))
    for axis in "xyz"
    for k in (0, 1)
)
PLACES = "".join(
    f"variable p{axis}{k} equal f_{axis}{k}[{7 + n}]\n" for n, axis in enumerate("xyz") for k in (0, 1)
)
AREAS = "".join(
    f"variable A{a}{b} equal (v_p{a}1-v_p{a}0)*(v_p{b}1-v_p{b}0)\n" for a, b in ("xy", "xz", "yz")
)
PRESSED = "".join(
    f"variable f{axis} equal 2e4*v_A{across}\n"
    + "".join(f"fix_modify {axis}{k} servo/target_val v_f{axis}\n" for k in (0, 1))
    for axis, across in (("x", "yz"), ("y", "xz"), ("z", "xy"))
)
WALLS = "fix w all wall/gran model hertz tangential history mesh n_meshes 6 meshes x0 x1 y0 y1 z0 z1\n"
TRIAXIAL = head() + SPHERE + PACK + SIX + PLACES + AREAS + PRESSED + WALLS + MOVE


def test_servos_whose_force_is_a_pressure_times_an_area():
    stage = read(TRIAXIAL).stages[0]
    assert stage.pressure == pytest.approx(2e4) and stage.pressed
    kappa = (5e6 / (2.0 * (1.0 - 0.45**2)) / 2e4) ** (2.0 / 3.0)
    assert hl.check(TRIAXIAL).state.stiffness_number == pytest.approx(kappa, rel=1e-6)
    assert read(TRIAXIAL.replace("fx equal 2e4", "fx equal 5e4")).stages[0].pressure == pytest.approx(3e4)
    box = TRIAXIAL.replace("(v_px1-v_px0)*(v_py1-v_py0)", "ly*lx")
    assert read(box).stages[0].pressure == pytest.approx(2e4)


@pytest.mark.parametrize(
    "old,new",
    [
        ("fx equal 2e4*v_Ayz", "fx equal 2e4*v_Axy"),  # not across
        ("fx equal 2e4*v_Ayz", "fx equal v_Ayz"),
        ("(v_pz1-v_pz0)", "(v_pz1-v_px0)"),
        ("(v_pz1-v_pz0)", "(v_pz1-v_pz1)"),
        ("f_z1[9]", "f_z1[3]"),
        ("f_z1[9]", "f_other[9]"),
        ("fix_modify z1 servo/target_val v_fz\n", ""),  # then its force is 0.001 N
        ("fix_modify z1 servo/target_val v_fz\n", "fix_modify z1 servo/target_val 7\n"),
        (PRESSED, PRESSED + SERVO.format(name="z1", axis="0 0 -1")),  # made anew
        ("axis 0 0 1 target", "axis 0 1 1 target"),
    ],
)
def test_servos_of_unknown_pressure(old, new):
    changed = TRIAXIAL.replace(old, new)
    assert changed != TRIAXIAL and read(changed).stages[0].pressure is None


def test_servos_that_face_each_other():
    """Their constant forces act on the box; the mean over the axes counts."""
    forces = TRIAXIAL.replace(PLACES + AREAS + PRESSED, "")
    assert read(forces).stages[0].pressure == pytest.approx(0.001 * (1 / 0.01 + 2 / 0.02) / 3.0)
    other = forces.replace("axis 0 0 -1 target_val 0.001", "axis 0 0 -1 target_val 0.002")
    assert read(other).stages[0].pressure is None
    again = other.replace("fix w all", "fix_modify z1 target_val 0.001\nfix w all")
    assert read(again).stages[0].pressure == read(forces).stages[0].pressure


# --- adhesion ---------------------------------------------------------------------------------------------------

BED = (
    "{}"
    + GRAVITY
    + WALL
    + "fix x0 all wall/gran model hertz tangential history primitive type 1 xplane 0\n"
    + SPHERE
    + PACK
    + MOVE
)


@pytest.mark.parametrize(
    "model,plain",
    [
        ("hertz tangential history cohesion easo/capillary/viscous", "hertz tangential history"),
        ("hertz tangential history cohesion sjkr", "hertz tangential history"),
        ("jkr tangential history", "hertz tangential history"),
        ("hooke/hysteresis tangential history", "hooke tangential history"),
    ],
)
def test_a_bed_with_adhesion_has_the_stiffness_number_of_its_repulsion(model, plain):
    more = "".join(
        f"fix q{k} all property/global {name} peratomtypepair 1 3\n"
        for k, name in enumerate(
            ("cohesionEnergyDensity", "coefficientMaxElasticStiffness", "surfaceTension")
        )
    )
    other, verdict = hl.check(BED.format(head(model=plain))), hl.check(BED.format(head(model=model) + more))
    assert verdict.admissible is False and verdict.state.pressure == pytest.approx(other.state.pressure)
    assert verdict.state.stiffness_number == pytest.approx(other.state.stiffness_number, rel=1e-9)
    assert verdict.state.overlap is None and other.state.overlap is not None
    assert "without the adhesion, which adds to the overlap" in verdict.sentence


# --- grains of files that are not read, and numbers -------------------------------------------------------------

RESTART = (
    head().replace("region box block 0 0.1 0 0.1 0 0.2 units box\ncreate_box 1 box", "read_restart old")
    + GRAVITY
)
LID = WALL.replace("fix floor", "fix lid").replace("zplane 0", "zplane 0.25")


def test_what_is_set_of_grains_that_are_not_read():
    """Their density gives the pressure between two walls; their diameter, their sizes."""
    script = RESTART + WALL + LID + "set group all density 2000\n" + MOVE
    verdict = hl.check(script)
    assert (
        verdict.state.pressure == pytest.approx(0.59 * 2000.0 * 9.81 * 0.25)
        and verdict.state.pressure_is_bound
    )
    assert "25 cm between plane walls" in verdict.sentence and verdict.state.stiffness_number
    assert read(script).stages[0].grains["1"].radii is None and "read_restart old" in verdict.unknown[0].what
    sized = script.replace("density 2000", "density 2000 diameter 0.004")
    assert read(sized).stages[0].grains["1"].radii == (0.002, 0.002)
    for changed in (
        script.replace("set group all density 2000\n", ""),
        script.replace("set group all", "set region box"),
        script.replace(LID, ""),
        script.replace("set group all density 2000\n", "").replace(
            "read_restart", "set group all density 2000\nread_restart"
        ),
    ):
        assert changed != script and hl.check(changed).state.pressure is None


def test_one_grain_makes_no_bed():
    few = PACK.replace("volumefraction_region 0.1", "particles_in_region {}")
    clump = CLUMP.replace(ROD, "file none.txt")
    script = head() + GRAVITY + WALL + clump + few + BODIES
    assert hl.check(script.format(3)).state.pressure and hl.check(script.format(2)).state.pressure is None


def test_numbers_with_two_points():
    """LIGGGHTS 3.8 reads ``.0.0`` as 0 and ``-1.0.5`` as −1."""
    script = head() + GRAVITY.replace("0 0 -1", "0 .0.0 -1.0.5") + WALL + SPHERE + PACK + MOVE
    assert read(script).stages[0].down == (0.0, 0.0, -1.0)
    with pytest.raises(ValueError, match="must have a number, not x1"):
        read(script.replace(".0.0", "x1"))


# --- beside LIGGGHTS 3.8.0 --------------------------------------------------------------------------------------


def test_a_bed_of_rods_in_liggghts():
    """Run once in LIGGGHTS 3.8.0 for 40,000 steps of 10 µs: 1145 rods of 20.26169 g settle and press with 0.198775 N.

    It finds the volume of a rod with a million random points.
    """
    walls = WALL + LID.replace("0.25", "0.06")
    box = head("p p f", model="hertz tangential history").replace("0 0.1 0 0.1 0 0.2", "0 0.03 0 0.03 0 0.06")
    fill = PACK.replace("_region 0.1", "_region 0.15").replace("0 0 -0.5", "0 0 -0.2")
    state = hl.check(box + GRAVITY + walls + CLUMP + fill + BODIES).state
    assert state.pressure == pytest.approx(0.198775 / 0.03**2, rel=2e-3) and not state.pressure_is_bound
    rod = np.array(ROD.split(), float).reshape(2, 4)
    assert clumps.volume(rod) == pytest.approx(0.02026169 / 1145 / 2500.0, rel=2e-3)


# --- areas of meshes --------------------------------------------------------------------------------------------

#: A plate of 30 × 20 between z = 0 and 1, whose sides are left out.
PLATE = np.array(
    [
        [[x, y, z] for x, y in corners]
        for z, order in ((1.0, 1), (0.0, -1))
        for corners in (((0, 0), (30, 0), (30, 20))[::order], ((0, 0), (30, 20), (0, 20))[::order])
    ],
    float,
)


def written(path, binary, triangles=PLATE):
    """The plate, or other triangles, as an STL file."""
    if binary:
        records = np.zeros(len(triangles), meshes.BINARY)
        records["corners"] = triangles
        path.write_bytes(b" " * 80 + len(triangles).to_bytes(4, "little") + records.tobytes())
        return
    corners = ["".join(f"vertex {x} {y} {z}\n" for x, y, z in triangle) for triangle in triangles]
    facets = "".join(f"facet normal 0 0 1\nouter loop\n{text}endloop\nendfacet\n" for text in corners)
    path.write_text(f"solid plate\n{facets}endsolid plate\n", encoding="utf-8")


@pytest.mark.parametrize("binary", [False, True])
def test_a_force_acts_on_the_area_of_a_mesh(tmp_path, binary):
    """Turned as the script turns it, within the floor of the box."""
    written(tmp_path / "plane.stl", binary)
    path = tmp_path / "in.press"
    servo = SERVO.format(name="lid", axis="0 0 -1").replace("file plane.stl", "file plane.stl scale 0.001")
    wall = "fix w all wall/gran model hertz tangential history mesh n_meshes 1 meshes lid\n"

    def pressure(text):
        path.write_text(head() + SPHERE + PACK + text + wall + MOVE, encoding="utf-8")
        return read(path).stages[0].pressure

    level = servo.replace("rotate axis 0 1 0 angle 90 ", "")
    assert pressure(level) == pytest.approx(0.001 / (0.03 * 0.02), rel=1e-6)
    assert pressure(servo.replace("angle 90", "angle 60")) == pytest.approx(
        0.001 / (0.03 * 0.02 * 0.5), rel=1e-6
    )
    assert pressure(servo.replace("axis 0 0 -1", "axis 1 0 0")) == pytest.approx(
        0.001 / (0.03 * 0.02), rel=1e-6
    )
    assert pressure(level.replace("scale 0.001", "scale 1")) == pytest.approx(
        0.001 / 0.1**2
    )  # larger than the box
    assert pressure(level.replace("file plane.stl", "file none.stl")) == pytest.approx(0.001 / 0.1**2)


def turned_box(faces, rotation):
    """Triangles of some faces of a unit cube, by axis and side, after a rotation."""
    corners = []
    for axis, side in faces:
        square = np.insert(np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float), axis, side, axis=1)
        corners += [square[[0, 1, 2]], square[[0, 2, 3]]]
    return np.array(corners) @ rotation.as_matrix().T


SIDES = [(0, 0), (0, 1), (1, 0), (1, 1)]


@pytest.mark.parametrize("seed", range(10))
def test_meshes_that_hold_nothing(seed):
    """A grain stays on a gentle face, in a gentle valley and in a hollow; it leaves tubes, slopes and steep gutters."""
    random = np.random.default_rng(seed)
    axis, angle = random.normal(size=3) * (1, 1, 0), random.uniform(-80.0, 80.0)
    tilt = Rotation.from_rotvec(math.radians(angle) * axis / np.linalg.norm(axis))
    around, down = Rotation.from_euler("z", random.uniform(0, 360), degrees=True), (0.0, 0.0, -1.0)
    scale = 10.0 ** random.uniform(-150.0, 150.0)

    def sheds(faces, rotation):
        return meshes.sheds(scale * turned_box(faces, rotation), down, 15.0)

    assert sheds([(2, 0)], tilt) is (abs(angle) >= 15.0)
    assert sheds(SIDES, around) and not sheds([*SIDES, (2, 0)], around)
    assert not meshes.sheds(turned_box(SIDES, around), down, 15.0, opening=1.5)  # than a square of 1 has
    # Two faces that meet below in an edge at this angle.
    for slope in (0.0, 10.0, 20.0, 40.0):
        gutter = (
            around
            * Rotation.from_euler("y", slope, degrees=True)
            * Rotation.from_euler("x", 45, degrees=True)
        )
        assert sheds([(1, 0), (2, 0)], gutter) is (slope > 15.0)
    corner = Rotation.align_vectors([(0, 0, 1)], [(1, 1, 1)])[0]
    hollow = around * corner  # a corner of a cube, lowest
    assert not sheds([(0, 0), (1, 0), (2, 0)], hollow)
    assert sheds([(0, 1), (1, 1), (2, 1)], hollow)  # and highest
    high = np.concatenate([turned_box(SIDES, around), turned_box([(0, 0), (1, 0), (2, 0)], hollow) + 5.0])
    assert not meshes.sheds(high, down, 15.0) and meshes.sheds(high, down, 15.0, top=4.9)
    floor = turned_box([(2, 0)], around) + 5.0  # of another part
    both = np.concatenate([turned_box(SIDES, around), floor])
    assert not meshes.sheds(both, down, 15.0) and meshes.sheds(both, down, 15.0, top=4.9)


def test_grains_do_not_rest_on_a_chute(tmp_path):
    """In LIGGGHTS they bounce down one with 1.2 m/s and 0.03 contacts per grain, and leave the box."""
    path = tmp_path / "in.chute"
    mesh = "fix chute all mesh/surface file plane.stl type 1 scale 0.001 rotate axis 0 1 0 angle {angle}\n"
    wall = "fix w all wall/gran model hertz tangential history mesh n_meshes 1 meshes chute\n"
    written(tmp_path / "plane.stl", False, PLATE[:2])

    def checked(angle, more=""):
        path.write_text(
            head() + SPHERE + PACK + GRAVITY + mesh.format(angle=angle) + wall + more + MOVE, "utf-8"
        )
        return hl.check(path)

    chute = checked(30)
    assert (
        chute.admissible is None
        and "the fall down a mesh that is open below drives this box" in chute.sentence
    )
    assert checked(5).state.name == "rest"
    assert checked(30, WALL).state.name == "rest"
    moved = checked(30, LIFT.format(1).replace("mesh lid", "mesh chute"))
    assert moved.state.name != "gas"


# --- walls that move ----------------------------------------------------------------------------------------------

STAMP = (
    "fix lid all mesh/surface file lid.stl type 1\n"
    "fix walls all wall/gran model hertz tangential history mesh n_meshes 1 meshes lid\n"
)
LIFT = "fix lift all move/mesh mesh lid linear 0 0 {}\n"


@pytest.mark.parametrize("velocity", ["-0.01", "0.01"])
def test_a_piston_leaves_the_pressure_unknown(velocity):
    """Also once it has turned back. In LIGGGHTS, squeezing gels by 18 % takes 22 times their weight."""
    begin = head() + SPHERE + PACK + GRAVITY + WALL + STAMP
    still = hl.check(begin + MOVE).state
    assert still.name == "rest" and still.pressure is not None
    turned = "unfix lift\n" + LIFT.format("0.01") + "run 1000\n"
    moved = hl.check(begin + LIFT.format(velocity) + MOVE + turned).state
    assert moved.name == "flow" and (moved.pressure is None) is (velocity == "-0.01")
    if moved.pressure is not None:
        assert moved.pressure == pytest.approx(still.pressure)
        assert moved.pressure_from.endswith("without what moving walls add")


def test_walls_that_move_across_gravity_leave_the_weight():
    begin = head() + SPHERE + PACK + GRAVITY + WALL + STAMP
    moved = hl.check(begin + LIFT.replace("0 0 {}", "0.1 0 0") + MOVE).state
    assert moved.pressure_from.endswith(", without what moving walls add")


def test_a_servo_along_one_axis_has_less_stress_across():
    """1000 grains below a plate in LIGGGHTS: stresses across are 0.53 of that along, the mean overlap 6.0 %."""
    text = (
        head(friction=0.3)
        + SPHERE
        + PACK
        + SERVO.format(name="lid", axis="0 0 -1").replace("0.001", "255")
        + WALL
    )
    text += "fix w all wall/gran model hertz tangential history mesh n_meshes 1 meshes lid\n" + MOVE
    alone, isotropic = hl.check(text).state, hl.check(TRIAXIAL.replace("2e4", "25500")).state
    assert alone.pressure == pytest.approx(isotropic.pressure)
    share = at_rest.under_piston(0.3, alone.stiffness_number)
    same = hl.check(
        TRIAXIAL.replace("2e4", f"{share * 25500}").replace("peratomtypepair 1 0.5", "peratomtypepair 1 0.3")
    ).state
    assert share == pytest.approx((1.0 + 2.0 * 0.53) / 3.0, rel=at_rest.UNIAXIAL_ERROR)
    assert alone.overlap == pytest.approx(same.overlap, rel=1e-3)
    assert alone.overlap_range[0] < 0.0604 < alone.overlap_range[1]


def test_rolling_friction_of_several_pairs_is_one_warning():
    text = head(model="hertz tangential history rolling_friction cdt").replace("create_box 1", "create_box 2")
    for old in ("5e6", "0.45"):
        text = text.replace(f"peratomtype {old}", f"peratomtype {old} {old}")
    text = text.replace("pair 1 0.9", "pair 2 0.9 0.9 0.9 0.9").replace(
        "pair 1 0.5", "pair 2 0.5 0.5 0.5 0.5"
    )
    text += "fix m6 all property/global coefficientRollingFriction peratomtypepair 2 0.1 0.2 0.2 0.3\n"
    text += SPHERE + SPHERE.replace("fix t ", "fix u ").replace(
        "15485863 atom_type 1", "49979687 atom_type 2"
    )
    text += PACK.replace("1 t 1.0", "2 t 0.5 u 0.5") + MOVE
    said = [warning.what for warning in hl.check(text).warnings if "rolling_friction" in warning.what]
    assert len(set(said)) == 1 and "0.1 or 0.2 or 0.3 R_eff J_n" in said[0]
