"""Grains that LIGGGHTS' ``fix insert/stream`` releases into open space, and grains on a lattice in free fall."""

import math

import pytest
from test_liggghts_grains import GRAVITY, MOVE, SINGLE, SPHERE, WALL, head

import hardlimit as hl
from hardlimit.checking.scripts import read
from hardlimit.checking.scripts.census import SQUARE, Lattice, lattice, spacing

#: A face of 0.1 m × 0.1 m in the plane z = 1, from two triangles.
CORNERS = [(-0.05, -0.05), (0.05, -0.05), (0.05, 0.05), (-0.05, 0.05)]
FACET = "facet normal 0 0 1\nouter loop\n{}endloop\nendfacet\n"


def face(height=lambda x, y: 1.0):
    """The text of an STL file."""
    points = [f"vertex {x} {y} {height(x, y)}\n" for x, y in CORNERS]
    facets = (FACET.format("".join(points[k] for k in corners)) for corners in ((0, 1, 2), (0, 2, 3)))
    return f"solid face\n{''.join(facets)}endsolid face\n"


MESH = "fix face all mesh/surface file face.stl type 1\n"
INSERT = (
    "fix d all particledistribution/discrete 15485867 1 t 1.0\n"
    "fix ins all insert/stream seed 32452867 distributiontemplate d nparticles 5000 vel constant 0 0 -1"
    " particlerate 100000 overlapcheck yes insertion_face face extrude_length 0.2\n"
)
STREAM = head() + GRAVITY + SPHERE + MESH + INSERT + MOVE
ACROSS = STREAM.replace("constant 0 0 -1", "constant 0 -0.3 -1")
#: Volume of a grain.
BALL = 4.0 / 3.0 * math.pi * 1e-9


@pytest.fixture
def checked(tmp_path):
    """The verdict on a script with its mesh in the same folder."""

    def check(script, mesh=None, **options):
        (tmp_path / "face.stl").write_text(face() if mesh is None else mesh, encoding="utf-8")
        (tmp_path / "in.stream").write_text(script, encoding="utf-8")
        return hl.check(tmp_path / "in.stream", **options)

    return check


def test_grains_of_a_straight_stream_never_meet(checked):
    """LIGGGHTS itself counts no contact of 1637 such grains in 30,000 steps."""
    verdict = checked(STREAM)
    assert verdict.state.never_meet and "no grain meets another or a wall (t_c ν = 0)" in verdict.sentence
    for same in (
        STREAM.replace(GRAVITY, ""),
        STREAM.replace("fix move", "fix r all scale/diameter 10 region box scale 0.5 1.0\nfix move"),
        STREAM.replace("fix move", "fix r all chem/shrink/core speciesA CO\nfix move"),
        STREAM.replace("type 1\n", "type 1 scale 2\n").replace("0 0 -1 part", "0 0 -0.1 part"),
    ):
        assert same != STREAM and checked(same).state.never_meet


@pytest.mark.parametrize(
    "old,new",
    [
        ("fix move", WALL + "fix move"),
        ("overlapcheck yes", "overlapcheck no"),
        ("constant 0 0 -1", "constant 0 0 1"),
        ("constant 0 0 -1", "constant 0 -0.3 -1"),
        ("constant 0 0 -1", "uniform 0 0 -1 0 0 -2"),
        ("0 0 -1\nfix t", "1 0 0\nfix t"),
        ("boundary f f f", "boundary f f p"),
        (" insertion_face face", " insertion_face other"),
        ("run", "create_atoms 1 single 0.05 0.05 0.1\nrun"),
        ("run", "fix r all scale/diameter 10 region box scale 1.5 1.0\nrun"),
        ("run", "fix r all scale/diameter 10 region box scale v_s 1.0\nrun"),
        ("run", "set type 1 diameter 0.02\nrun"),
        ("run", "velocity all set 1 0 0\nrun"),
        (
            "run",
            "run 5\nfix two"
            + INSERT.splitlines()[1].removeprefix("fix ins").replace("-1 p", "-2 p")
            + "\nrun",
        ),
    ],
)
def test_what_makes_grains_of_a_stream_meet(checked, old, new):
    changed = STREAM.replace(old, new)
    assert changed != STREAM and not checked(changed).state.never_meet


@pytest.mark.parametrize(
    "mesh",
    [
        face(lambda x, y: 1.0 + 0.1 * x),
        face(lambda x, y: 1.0 + x * y),
        "solid face\nendsolid face\n",
        face().replace("vertex", "point"),
    ],
)
def test_the_face_must_be_level_and_plane(checked, mesh):
    assert not checked(STREAM, mesh).state.never_meet and not checked(ACROSS, mesh).state.tc_nu_is_bound
    if "0.995" in mesh:  # a slope, without gravity
        assert checked(STREAM.replace(GRAVITY, ""), mesh).state.tc_nu_is_bound


def test_a_velocity_along_the_face_bounds_tc_nu(checked):
    """By Enskog's theory at this impact speed and the packing fraction behind the face.

    LIGGGHTS itself has 0.0028 contacts a grain, which is t_c ν, where the bound is 0.14 (R = 5 mm, 4000 grains/s).
    """
    verdict = checked(ACROSS)
    state, phi = verdict.state, 1e5 * BALL / (0.1 * 0.1 * 1.0)
    assert state.tc_nu_is_bound and not state.never_meet and state.impact_speed == pytest.approx(0.3)
    assert state.packing_fraction == pytest.approx(phi) and state.to_dict()["tc_nu_is_bound"] is True
    stated = checked(ACROSS, speed=0.3, packing_fraction=phi)
    assert state.supposed_tc_nu == pytest.approx(stated.rows[0].tc_nu) and not stated.state.tc_nu_is_bound
    assert verdict.admissible is None and "In the stream t_c ν is at most" in verdict.sentence
    assert any("along its face" in number.source and not number.decides for number in verdict.inferred)
    assert not checked(ACROSS, speed=0.3).state.tc_nu_is_bound
    for other in (
        "viscous 0.1",
        "addforce 0 0 -1",
        "couple/cfd couple_every 10 mpi",
        "mystery 1",
        "wall/reflect zlo EDGE",
    ):
        state = checked(ACROSS.replace("fix move", f"fix other all {other}\nfix move")).state
        assert not state.tc_nu_is_bound and not state.never_meet


@pytest.mark.parametrize(
    "old,new,phi",
    [
        ("particlerate 100000", f"massrate {1e5 * BALL * 2500.0!r}", 1.0),
        ("particlerate 100000", "particlerate 50000", 0.5),
        ("type 1\n", "type 1 scale 2\n", 0.25),
        ("type 1\n", "type 1 rotate axis 0 0 1 angle 30 rotate axis 0 0 1 angle 15\n", 1.0),
        ("constant 0 -0.3 -1", "constant 0 -0.3 -2", 0.5),
        ("discrete 15485867 1 t 1.0", "discrete 15485867 2 t 0.5 t 0.5", 1.0),
        ("particlerate 100000", "particlerate 2000000", None),
        ("particlerate 100000", "particlerate v_rate", None),
        ("radius constant 0.001", "radius uniform 0.001 0.002", None),
    ],
)
def test_the_packing_fraction_of_a_stream(checked, old, new, phi):
    script = ACROSS.replace(old, new)
    verdict = checked(script)
    assert script != ACROSS and verdict.state.tc_nu_is_bound is (phi is not None)
    if phi is not None:
        assert verdict.state.packing_fraction == pytest.approx(phi * 1e5 * BALL / 0.01)


def test_shares_of_two_sizes_in_a_stream(checked):
    """Shares are those of the mass: 0.3/V₁ and 0.7/V₂ of the number."""
    two = SPHERE.replace("fix t", "fix u").replace("0.001", "0.002")
    script = ACROSS.replace("fix face", two + "fix face").replace("1 t 1.0", "2 t 0.3 u 0.7")
    mean = 1.0 / (0.3 / BALL + 0.7 / (8.0 * BALL))
    assert checked(script).state.packing_fraction == pytest.approx(1e5 * mean / 0.01)


def test_a_stream_goes_on_after_a_restart(tmp_path):
    (tmp_path / "face.stl").write_text(face(), encoding="utf-8")
    for name, stream in (("straight", STREAM), ("across", ACROSS)):
        folder = tmp_path / name
        folder.mkdir()
        (folder / "face.stl").write_text(face(), encoding="utf-8")
        (folder / "in.first").write_text(f"{stream}write_restart post/a.restart\n", encoding="utf-8")
        again = stream.replace("create_box 1 box", "read_restart post/a.restart")
        (folder / "in.again").write_text(again, encoding="utf-8")
        state = hl.check(folder / "in.again").state
        assert state.never_meet is (name == "straight") and state.tc_nu_is_bound is (name == "across")
    (folder / "in.again").write_text(again.replace("-0.3 -1", "-0.4 -1"), encoding="utf-8")
    assert not hl.check(folder / "in.again").state.tc_nu_is_bound


# --- lattices -----------------------------------------------------------------------------------------------------

ON_SITES = (
    head()
    + GRAVITY
    + "lattice sc 0.01\nregion inside block 0.02 0.08 0.02 0.08 0.02 0.08 units box\ncreate_atoms 1 region inside\n"
    + "set group all density 500 diameter 0.01\n"
    + MOVE
)


def test_grains_that_touch_on_a_lattice_fall_together():
    assert hl.check(ON_SITES).state.never_meet
    assert hl.check(ON_SITES.replace("region inside\n", "box\n")).state.never_meet
    assert hl.check(
        ON_SITES.replace("lattice sc", "lattice fcc").replace("diameter 0.01", "diameter 0.007")
    ).state.never_meet


@pytest.mark.parametrize(
    "old,new",
    [
        ("diameter 0.01", "diameter 0.0101"),
        ("lattice sc", "lattice fcc"),
        ("lattice sc 0.01", "lattice sc 0.01 orient x 1 1 0"),
        ("boundary f f f", "boundary p f f"),
        ("fix move", WALL + "fix move"),
        ("run", "create_atoms 1 single 0.05 0.05 0.15\nrun"),
        ("run", "displace_atoms all random 0.1 0.1 0.1 3\nrun"),
        ("diameter 0.01", "diameter 0.01 vx 1"),
        ("region inside\n", "region inside ratio 0.5 4\n"),
    ],
)
def test_what_makes_grains_of_a_lattice_meet(old, new):
    changed = ON_SITES.replace(old, new)
    assert changed != ON_SITES and not hl.check(changed).state.never_meet


def test_the_least_distance_of_sites():
    expected = {"sc": 1.0, "bcc": math.sqrt(0.75), "fcc": math.sqrt(0.5), "sq": 1.0}
    for style, distance in expected.items():
        assert spacing(lattice(style, 0.3, 3, False), 3) == pytest.approx(0.3 * distance)
    flat = {"sq": 1.0, "sq2": math.sqrt(0.5), "hex": 1.0}
    for style, distance in flat.items():
        assert spacing(lattice(style, 0.3, 2, False), 2) == pytest.approx(0.3 * distance)
    assert spacing(Lattice(None, None), 3) is None and spacing(Lattice((), SQUARE), 3) is None


def test_single_grains_keep_their_number_if_they_get_the_type_that_they_have():
    script = head() + GRAVITY + WALL + "create_atoms 1 single 0.05 0.05 0.1\n{}" + MOVE
    sized = script.format("set atom 1 type 1 diameter 0.004 density 2500\n")
    assert read(sized).stages[0].contents.count == 1 and hl.check(sized).state.grains == 1
    two = sized.replace("create_box 1", "create_box 2").replace("type 1 diam", "type 2 diam")
    assert read(two).stages[0].contents.count is None


@pytest.mark.parametrize(
    "words,speed",
    [
        ("atom 1 vz -2", 2.0),
        ("atom 1 vx 3 vz -4", 4.0),  # across the floor
        ("type 1 vz -2", 2.0),
        ("group all vz -2", 2.0),
        ("atom * vz -2", 2.0),
        ("atom 1 vz v_drawn", None),
    ],
)
def test_velocities_that_set_gives_are_those_of_impacts(words, speed):
    draws = "variable drawn atom random(0,1,7)\n"
    text = (
        head()
        + WALL
        + draws
        + "create_atoms 1 single 0.05 0.05 0.1\nset type 1 diameter 0.004 density 2500\n"
    )
    state = hl.check(f"{text}set {words}\n{MOVE}").state
    assert state.grains == 1 and state.speed_is_chosen is (speed is None)
    assert state.impact_speed == pytest.approx(speed or 1.0)


def test_grains_that_set_gives_one_velocity_do_not_approach_each_other():
    two = (
        head()
        + SINGLE.format(0.03)
        + SINGLE.format(0.07)
        + "set type 1 diameter 0.004 density 2500\n{}"
        + MOVE
    )
    together = hl.check(two.format("set group all vz -2\n"))
    apart = hl.check(two.format("set atom 1 vx 2\nset atom 2 vx -1\n"))
    assert together.state.speed_is_chosen and apart.state.impact_speed == pytest.approx(3.0)
