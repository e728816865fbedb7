"""What scripts of LIGGGHTS say of their runs, where runs of LIGGGHTS once showed something else."""

import math

import pytest

import hardlimit as hl
from hardlimit.checking.scripts import read

HEAD = """units si
atom_style granular
boundary f f f
region box block 0 0.1 0 0.1 0 0.2 units box
create_box 1 box
fix m1 all property/global youngsModulus peratomtype {modulus}
fix m2 all property/global poissonsRatio peratomtype 0.3
fix m3 all property/global coefficientRestitution peratomtypepair 1 0.6
fix m4 all property/global coefficientFriction peratomtypepair 1 {friction}
fix m5 all property/global characteristicVelocity scalar 1
pair_style gran model {model} tangential history
pair_coeff * *
timestep 1e-6
"""
GRAVITY = "fix g all gravity 9.81 vector 0 0 -1\n"
SPHERE = (
    "fix t all particletemplate/sphere 15485863 atom_type 1 density constant 2500 radius constant 0.001\n"
)
DISTRIBUTION = "fix d all particledistribution/discrete 15485867 1 t 1.0\n"
INSERT = (
    "fix {name} all insert/pack seed 32452843 distributiontemplate d vel constant 0 0 {velocity} insert_every once"
    " overlapcheck yes region box {much}\n"
)
PACK = INSERT.format(name="ins", velocity=-0.5, much="volumefraction_region 0.1")
MOVE = "fix move all nve/sphere\n"
WALL = "fix {name} all wall/gran model {model} tangential history {wall}\n"
FLOOR = WALL.format(name="floor", model="hertz", wall="primitive type 1 zplane 0")
MESH = "fix belt all mesh/surface file belt.stl type 1{words}\n"
BELT = WALL.format(name="w", model="hertz", wall="mesh n_meshes 1 meshes belt")


def head(model="hertz", modulus=5e6, friction=0.5):
    """The begin of a script."""
    return HEAD.format(model=model, modulus=modulus, friction=friction)


def of_belt(words, friction=0.5):
    """The state of grains above a mesh with these words."""
    grains = SPHERE + DISTRIBUTION + PACK
    return hl.check(
        head(friction=friction) + GRAVITY + grains + MESH.format(words=words) + BELT + MOVE + "run 9\n"
    )


def test_a_belt_moves_its_grains():
    """A mesh whose surface moves stands still itself; its friction drags the grains."""
    still, moving = of_belt(""), of_belt(" surface_vel -4.5 0 0")
    assert (still.state.name, moving.state.name) == ("rest", "flow")
    (speed,) = [number.value for number in moving.inferred if number.what == "speed"]
    assert speed == 4.5 and any("surface_vel" in finding.what for finding in moving.ignored)
    assert of_belt(" surface_vel 0 0 0").state.name == "rest"
    assert of_belt(" surface_vel -4.5 0 0", friction=0).state.name == "rest"
    assert of_belt(" surface_ang_vel origin 0 0 0 axis 0 0 1 omega 3").state.name == "flow"


def test_a_body_that_moves_freely_presses_what_is_below_it():
    six = "com 0 0 0 vel 0 0 0 mass 40 moi 1 1 1 0 0 0"
    mesh = MESH.replace("mesh/surface", "mesh/surface/stress/6dof").format(words=f" {six}")
    verdict = hl.check(
        head() + GRAVITY + SPHERE + DISTRIBUTION + PACK + mesh + BELT + FLOOR + MOVE + "run 9\n"
    )
    assert "without the weight of the body that moves freely" in (verdict.state.pressure_from or "")
    assert any("6dof" in finding.what for finding in verdict.ignored)


# --- how many grains --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "much,count",
    [("volumefraction_region 0.1", 47747), ("mass_in_region 1.6e-5", 2), ("volumefraction_region 1e-6", 1)],
)
def test_a_volume_or_a_mass_is_a_number_of_grains(much, count):
    """LIGGGHTS rounds it at random: the larger number."""
    script = head() + GRAVITY + SPHERE + DISTRIBUTION + INSERT.format(name="ins", velocity=-0.5, much=much)
    text = script + FLOOR + MOVE + "run 9\n"
    assert read(text).stages[-1].contents.count == count
    assert hl.check(text).state.grains == (count if count <= 2 else None)


def test_spheres_of_two_sizes_have_no_number():
    other = SPHERE.replace("fix t", "fix u").replace("0.001", "0.002")
    both = "fix d all particledistribution/discrete 15485867 2 t 0.5 u 0.5\n"
    contents = (
        read(head() + GRAVITY + SPHERE + other + both + PACK + FLOOR + MOVE + "run 9\n").stages[-1].contents
    )
    assert contents.count is None and contents.filled == pytest.approx(0.1 * 0.1 * 0.1 * 0.2)


def test_grains_that_are_inserted_again_and_again_have_a_largest_number():
    """At the first step and every 1000 ones. In LIGGGHTS 4 x 250 lie beside each other on a wide floor."""
    again = INSERT.replace("insert_every once", "insert_every 1000")
    pack = again.format(name="ins", velocity=-0.5, much="particles_in_region 250")
    begin = (
        head().replace("boundary f f f", "boundary p p f") + GRAVITY + SPHERE + DISTRIBUTION + pack + FLOOR
    )
    runs = "run 1\nrun {steps}\nunfix ins\nrun 500000\n"
    few = begin + MOVE + runs.format(steps=3000)
    contents = read(few).stages[-1].contents
    assert contents.count is None and contents.most == 1000
    assert contents.most_filled == pytest.approx(1000 * 4.0 / 3.0 * math.pi * 1e-9)
    assert hl.check(few).sentence.startswith("No: grains, too few to cover the floor, come to rest")
    many = hl.check(begin + MOVE + runs.format(steps=40_000))
    assert "No: grains rest on each other" in many.sentence and many.state.pressure_is_bound
    weight = 41 * 250 * 4.0 / 3.0 * math.pi * 1e-9 * 2500.0 * 9.81 / 0.01
    assert many.state.pressure == pytest.approx(weight) and "below 10250 grains" in many.sentence
    # A number of steps that is not known, or a total number, leaves no bound of this kind.
    assert (
        read(few.replace("run 3000", "run ${long}"), variables={"long": "3000"}).stages[-1].contents.most
        == 1000
    )
    assert read(few.replace("insert_every 1000", "insert_every 0")).stages[-1].contents.most is None


@pytest.mark.parametrize(
    "count,words", [(10, "grains, too few to cover the floor, come to rest"), (9000, "grains rest on")]
)
def test_few_grains_on_a_wide_floor_do_not_rest_on_each_other(count, words):
    """LIGGGHTS: ten of them lie apart."""
    much = f"particles_in_region {count}"
    grains = SPHERE + DISTRIBUTION + INSERT.format(name="ins", velocity=-3, much=much)
    script = head().replace("boundary f f f", "boundary p p f") + GRAVITY + grains + FLOOR + MOVE + "run 9\n"
    assert hl.check(script).sentence.startswith(f"No: {words}")


# --- two grains, and speeds -------------------------------------------------------------------------------------

UNEQUAL = """create_atoms 1 single 0 0 0.0101 units box
create_atoms 1 single 0 0 -0.05 units box
set atom 1 diameter 0.02 density 2500 vz -0.4
set atom 2 diameter 0.1 density 7800
"""


def test_two_unequal_grains_meet_each_other_only():
    """Not others of their size. LIGGGHTS: 1.628 ms, 1.732 % of the smaller radius, 0.6000 in 1-µs steps."""
    verdict = hl.check(head(modulus=5e7, friction=0.3) + UNEQUAL + MOVE + "run 3000\n")
    (row,) = verdict.rows
    assert (row.radius, row.other_radius) == (0.01, 0.05)
    state = verdict.state
    assert (state.grains, state.impact_speed) == (2, 0.4)
    assert state.duration == pytest.approx(1.628e-3, rel=2e-3)
    assert state.overlap == pytest.approx(0.01732, rel=2e-3)
    assert state.restitution == pytest.approx(0.6, abs=1e-3)


def test_two_unequal_grains_meet_a_wall_one_by_one():
    """The small one is the denser one: their numbers belong together."""
    dense = UNEQUAL.replace("7800", "100").replace("vz -0.4", "")
    script = head(modulus=5e7) + GRAVITY + dense + FLOOR + MOVE + "run 9\n"
    walls = [row for row in hl.check(script, speed=0.1).rows if row.types[1] == "wall"]
    single = [
        hl.check(
            head(modulus=5e7)
            + GRAVITY
            + f"create_atoms 1 single 0 0 0.1\nset atom 1 diameter {diameter} density {density}\n"
            + FLOOR
            + MOVE
            + "run 9\n",
            speed=0.1,
        ).rows[-1]
        for diameter, density in ((0.02, 2500), (0.1, 100))
    ]
    assert [row.duration for row in walls] == pytest.approx([row.duration for row in single])


def speed_of(script):
    """The speed that a script states."""
    return [number.value for number in hl.check(script).inferred if number.what == "speed"]


def test_grains_that_are_inserted_towards_each_other():
    number = "particles_in_region 1"
    pair = [INSERT.format(name=f"ins{k}", velocity=v, much=number) for k, v in enumerate((1.0, -1.5))]
    both = head() + SPHERE + DISTRIBUTION + "".join(pair) + MOVE + "run 9\n"
    assert speed_of(both) == [2.5]
    assert speed_of(both.replace("-1.5", "1.0")) == []
    assert speed_of(both.replace("fix move", FLOOR.replace("zplane 0", "zplane 0") + "fix move")) == [2.5]


@pytest.mark.parametrize("velocity,speed", [("1 0 0", []), ("0 0 -1", [1.0]), ("0 0.6 -0.8", [0.8])])
def test_a_velocity_along_a_wall_is_no_impact(velocity, speed):
    grain = "create_atoms 1 single 0.05 0.05 0.01\nset atom 1 diameter 0.02 density 2500\n"
    text = head() + grain + FLOOR + MOVE + f"velocity all set {velocity} units box\nrun 9\n"
    assert speed_of(text) == pytest.approx(speed)
    cylinder = text.replace("zplane 0", "xcylinder 0.05 0.05 0.1")
    across = sum(float(part) ** 2 for part in velocity.split()[1:]) ** 0.5
    assert speed_of(cylinder) == pytest.approx([across] if across else [])


def test_grains_from_an_unknown_place_fall_through_the_box_at_most():
    """Not at the speed of their insertion: LIGGGHTS shows 1.8 m/s and more below a face that releases them at 1 m/s."""
    stream = (
        "fix face all mesh/surface file face.stl type 1\nfix ins all insert/stream seed 32452843 distributiontemplate d"
        " nparticles 900 particlerate 100 vel constant 0 0 -1 insertion_face face extrude_length 0.01\n"
    )
    script = (
        head() + GRAVITY + SPHERE + DISTRIBUTION + stream + MESH.format(words="") + BELT + MOVE + "run 9\n"
    )
    assert speed_of(script) == pytest.approx([(1.0 + 2.0 * 9.81 * 0.2) ** 0.5])
    assert "at most: through the whole of it" in hl.check(script).inferred[0].source
    assert speed_of(script.replace("gravity 9.81", "gravity 0")) == []


@pytest.mark.parametrize(
    ("steps", "falls"), [(100_000, True), (120_000, True), (200_000, False), (300_000, False)]
)
def test_runs_that_end_during_the_fall_are_said(steps, falls):
    """From 0.1 m/s, half of 20 cm takes 0.13 s, the whole 0.19 s. In runs of LIGGGHTS such grains still fall."""
    pack = INSERT.format(name="ins", velocity=-0.1, much="volumefraction_region 0.1")
    script = head() + GRAVITY + SPHERE + DISTRIBUTION + pack + FLOOR + MOVE + "run 1\n"
    verdict = hl.check(script + f"run {steps} upto\n")
    said = [remark for remark in verdict.remarks if "grains still fall" in remark]
    assert len(said) == falls and verdict.state.name == "rest"
    fallen = 100.0 * (0.1 * 0.1 + 0.5 * 9.81 * 0.1**2)
    if steps == 100_000:
        assert said == [
            f"The runs end after 100 ms, while grains still fall: {fallen:.1f} cm of up to 20 cm."
        ]


# --- bounds -----------------------------------------------------------------------------------------------------


def test_a_step_below_an_unknown_weight_is_a_bound():
    """Hertz' contacts are softer under less weight, so that longer steps are stable; springs are not."""
    side = WALL.format(name="side", model="hertz", wall="primitive type 1 zcylinder 0.05 0.05 0.05")
    hertz = head() + GRAVITY + SPHERE + DISTRIBUTION + PACK + FLOOR + side + MOVE + "run 9\n"
    verdict = hl.check(hertz)
    assert verdict.state.pressure_is_bound and verdict.state.step_is_bound
    assert "The step is at most" in verdict.sentence and "longest stable one, at least" in verdict.sentence
    spring = hl.check(hertz.replace("hertz", "hooke"))
    assert spring.state.pressure_is_bound and not spring.state.step_is_bound
    known = hl.check(hertz, pressure=100.0)
    assert not known.state.step_is_bound and "The step is 0" in known.sentence


LID = (
    "fix belt all mesh/surface/stress/servo file belt.stl type 1 com 0 0 0.2 ctrlPV force axis 0 0 1"
    " target_val {force} vel_max 1 kp 1 ki 0 kd 0\n"
)


def test_grains_that_were_pressed_more_before_hold_a_part_of_it():
    """LIGGGHTS: after 25.5 kPa, grains between walls with friction overlap by 3.4 % under 5.1 kPa, not by 2.4 %."""
    script = head() + GRAVITY + SPHERE + DISTRIBUTION + PACK + LID.format(force=-50) + BELT + MOVE + "run 9\n"
    pressed = hl.check(script).state
    assert pressed.pressure == pytest.approx(5000.0) and not pressed.pressure_is_least
    relieved = hl.check(script + "fix_modify belt target_val -10\nrun 9\n")
    state = relieved.state
    assert state.pressure == pytest.approx(1000.0) and state.pressure_is_least
    assert "they may hold a part of the 5 kPa before" in relieved.sentence
    assert "κ_p ≤" in relieved.sentence and "overlap at least" in relieved.sentence
    assert "The step is at least" in relieved.sentence
    assert not hl.check(script + "fix_modify belt target_val -90\nrun 9\n").state.pressure_is_least


# --- what moves -------------------------------------------------------------------------------------------------


def test_grains_without_an_integrator_stand_still():
    script = head() + GRAVITY + SPHERE + DISTRIBUTION + PACK + FLOOR + "run 9\n"
    assert any("no fix integrates" in note.what for note in hl.check(script).warnings)
    assert any("no fix integrates" in note.what for note in hl.check(f"{script}clear\n").warnings)
    moved = script.replace("run", MOVE + "run")
    assert not any("no fix integrates" in note.what for note in hl.check(moved).warnings)


@pytest.mark.parametrize("hold", ["unfix move", "fix hold all freeze"])
def test_runs_in_which_nothing_moves_any_more_decide_nothing(hold):
    """As heat that spreads in a bed that has settled."""
    script = head() + GRAVITY + SPHERE + DISTRIBUTION + PACK + FLOOR + MOVE + "run 9\n"
    later = script + f"{hold}\nfix g all gravity 1 vector 0 0 -1\nrun 9\n"
    assert hl.check(later).state == hl.check(script).state
    assert len(read(later).stages) == 1
