"""What scripts of YADE say of the state of their grains: pressed by walls and servos, held by fixed ones, falling."""

import math
from pathlib import Path

import pytest

import hardlimit as hl
from hardlimit.checking import at_rest, loads
from hardlimit.checking.scripts.yade import read

SCRIPT = """from yade import geom, pack
stone = O.materials.append(FrictMat(young=1e7, poisson=0.3, frictionAngle=0.4, density=2500, label="stone"))
{bodies}
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Facet_Aabb(), Bo1_Wall_Aabb(), Bo1_Box_Aabb()]),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom(), Ig2_Facet_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom(), Ig2_Box_Sphere_ScGeom()],
        [Ip2_FrictMat_FrictMat_FrictPhys()], [Law2_ScGeom_FrictPhys_CundallStrack()]),
    NewtonIntegrator({gravity}damping=0.4),{engine}
]
O.dt = 1e-6
{end}
O.run(1000, True)
"""
DOWN = "gravity=(0, 0, -10), "
BOX = "O.bodies.append(geom.facetBox((0, 0, 0.1), (0.02, 0.02, 0.1), wallMask=31))\n"
CLOUD = "sp = pack.SpherePack()\nsp.makeCloud((-0.02, -0.02, 0), (0.02, 0.02, 0.1), rMean=0.002)\nsp.toSimulation()\n"
#: Pressure of a bed of these grains, over its height.
HEAVY = 0.59 * 2500 * 10


def script(bodies, gravity=DOWN, engine="", end=""):
    engine = f"\n    {engine}," * bool(engine)
    return SCRIPT.format(bodies=bodies, gravity=gravity, engine=engine, end=end)


def said(bodies, gravity=DOWN, engine="", end=""):
    """What check says of the grains of a script."""
    return hl.check(script(bodies, gravity, engine, end)).state


# --- pressed ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("word", ["goal", "sigma"])
def test_the_stresses_of_a_triaxial_cell_by_axes(word):
    """As in 2023.02a, and by their names in older versions; only those under stress control count."""
    controls = "stressControl_1=True, stressControl_2=False, stressControl_3=True, internalCompaction=False"
    engine = f"ThreeDTriaxialEngine({controls}, {word}1=-1e4, {word}2=-7e4, {word}3=-2e4)"
    assert said(CLOUD, "", engine).pressure == 1.5e4
    assert (
        said(CLOUD, "", engine.replace("stressControl_2=False", "stressControl_2=True")).pressure == 1e5 / 3
    )


def test_spheres_of_unknown_clumps_are_pressed_more_than_the_script_says():
    """In 2023.02a the spheres of clumps of 13 at 50 kPa overlap by 4.4 % of R; single ones would by 2 %."""
    clumps = "O.bodies.appendClumped(pack.regularHexa(pack.inSphere((0, 0, 0), float(size)), radius=1e-3, gap=0))\n"
    engine = "TriaxialStressController(goal1=-1e4, goal2=-1e4, goal3=-1e4, internalCompaction=False)"
    alone, clumped = said(CLOUD, "", engine), said(CLOUD + clumps, "", engine)
    assert (alone.pressure_is_least, clumped.pressure_is_least) == (False, True)
    assert alone.pressure == clumped.pressure == 1e4 and "spheres of a clump" in clumped.pressure_from


def test_a_grain_between_walls_that_press_it_has_no_impact():
    """Its overlap is what the walls make of it."""
    ball = "O.bodies.append(sphere((0, 0, 0), 0.01))\nlow = O.bodies.append(wall(-0.01, 2))\n"
    moved = "top = wall(0.01, 2)\ntop.state.vel = (0, 0, {})\nO.bodies.append(top)"
    pressed = said(ball, "", end=moved.format(-1e-3))
    assert (pressed.name, pressed.grains, pressed.overlap) == ("pressed", None, None)
    assert pressed.largest_stable_step > 0.0
    assert said(ball, "", end=moved.format(0)).grains == 1


def test_a_controller_that_keeps_the_stress_it_has_reached():
    """Its goal is the stress that it measures: that of the run before."""
    engine = "TriaxialStressController(goal1=-1e5, goal2=-1e5, goal3=-1e5, label='triax')"
    kept = "O.run(10)\ntriax.stressMask = 2\ntriax.goal2 = triax.stress(3)[1]\n"
    assert said(CLOUD, "", engine, kept).pressure == 1e5
    assert said(CLOUD, "", engine, kept.partition("\n")[2]).pressure is None  # it had none before
    assert said(CLOUD, "", engine, kept.replace("triax.stress(3)[1]", "stress_of_a_file")).pressure is None


def test_a_servo_on_the_lid_of_a_cylinder_has_its_force_over_the_area():
    wall = "O.bodies.append(geom.facetCylinder((0, 0, 0.05), 0.03, 0.1, segmentsNumber=20, wallMask={}))\n"
    lid = f"{wall.format(6)}lid = {wall.format(1)}"
    servo = "ServoPIDController(axis=[0, 0, 1], maxVelocity=1, ids=lid, target=50.0, kP=1, kI=1, kD=1)"
    area = 10 * 0.03**2 * math.sin(0.1 * math.pi)
    assert said(CLOUD + lid, engine=servo).pressure == pytest.approx(50.0 / area)
    for change in (("[0, 0, 1]", "[0, 1, 0]"), ("50.0", "force_of_a_file"), ("target=50.0, ", "")):
        assert said(CLOUD + lid, engine=servo.replace(*change)).pressure is None


def test_one_pressed_axis_bears_more_than_the_mean():
    """Stresses across are smaller under a lid, and under one controlled stress unless grains grow from all sides."""
    wall = "O.bodies.append(geom.facetCylinder((0, 0, 0.05), 0.03, 0.1, segmentsNumber=20, wallMask={}))\n"
    lid = f"{CLOUD}{wall.format(6)}lid = {wall.format(1)}"
    servo = "ServoPIDController(axis=[0, 0, 1], maxVelocity=1, ids=lid, target=50.0, kP=1, kI=1, kD=1)"
    cell = (
        "TriaxialStressController(goal1=-1e4, goal2=-1e4, goal3=-1e4, stressMask=1, internalCompaction=False)"
    )
    for bodies, engine, uniaxial in (
        (lid, servo, True),
        (CLOUD, cell, True),
        (CLOUD, cell.replace("stressMask=1", "stressMask=7"), False),
        (CLOUD, cell.replace("=False", "=True"), False),
    ):
        text = script(bodies, "", engine)
        state = hl.check(text).state
        mean = at_rest.under_piston(math.tan(0.4), state.stiffness_number) if uniaxial else 1.0
        same = hl.check(text, pressure=mean * state.pressure).state
        assert state.overlap == pytest.approx(same.overlap) and (mean < 0.8) is uniaxial
        ranges = zip(state.overlap_range, same.overlap_range, strict=True)
        least, most = (bound / overlap for bound, overlap in ranges)
        assert (least < 0.97 and most > 1.03) if uniaxial else least == most == pytest.approx(1.0)


def pressed(engine, end=""):
    """The sentence on grains that a controller presses."""
    return hl.check(script(CLOUD, "", engine, end)).sentence


@pytest.mark.parametrize(("engine", "compressed"), [
    ("PeriTriaxController(goal=(-1e4, -1e4, -.2), stressMask=3)", True),
    ("PeriTriaxController(goal=(-1e4, -.2, -1e4), stressMask=5)", True),
    ("PeriTriaxController(goal=(-1e4, -1e4, .2), stressMask=3)", False),
    ("PeriTriaxController(goal=(-1e4, -1e4, 0), stressMask=3)", False),
    ("PeriTriaxController(goal=(-1e4, -1e4, -1e4), stressMask=7)", False),
    ("PeriTriaxController(goal=(-1e4, -.2, -.2), stressMask=1)", False),
    ("TriaxialStressController(goal1=-1e4, goal2=-.1, goal3=-1e4, stressMask=5, internalCompaction=False)", True),
    ("TriaxialStressController(goal1=-1e4, goal2=-.1, goal3=-1e4, stressMask=5)", False),
    ("ThreeDTriaxialEngine(stressControl_2=False, goal1=-1e4, goal2=.1, goal3=-1e4, internalCompaction=False)", True),
    ("TriaxialCompressionEngine(sigmaIsoCompaction=-1e4, internalCompaction=False)", True),
    ("TriaxialCompressionEngine(sigmaIsoCompaction=-1e4, internalCompaction=False, autoCompressionActivation=0)",
     False),
])  # fmt: skip
def test_grains_bear_more_than_the_stresses_of_two_axes_while_the_third_is_compressed(engine, compressed):
    sentence = pressed(engine)
    assert "under 10 kPa (as the script says" in sentence
    assert (f"up to {loads.SHEARED:g} times that while one axis is compressed" in sentence) is compressed


def test_a_callback_that_changes_the_stress_is_said():
    """It may run at intervals, or when the controller is done, and be defined after the run begins."""
    engine = "PeriTriaxController(goal=(-1e4, -1e4, -1e4), stressMask=7, label='cell'{})"
    hook, until = ", doneHook='done()'", "as the script says, until a callback changes it"
    for line in ("cell.goal = (-1e4, -1e4, -.2)", "cell.stressMask = 3"):
        assert until in pressed(engine.format(hook), f"def done():\n    {line}")
        runner = "PyRunner(iterPeriod=10, command='done()')"
        assert until in pressed(f"{engine.format('')}, {runner}", f"def done():\n    {line}")
    assert until not in pressed(engine.format(hook), "def done():\n    O.pause()")
    assert until not in pressed(engine.format(""), "def done():\n    cell.goal = 3")


@pytest.mark.parametrize(
    "line", ["setContactFriction(0.1)", "O.dt = 1e-9", "O.cell.velGrad = Matrix3(0, 1, 0, 0, 0, 0, 0, 0, 0)"]
)
def test_what_a_controller_runs_when_it_is_done_is_quoted(line):
    engine = "PeriTriaxController(goal=(-1e4, -1e4, -1e4), stressMask=7, doneHook='done()')"
    for text, quoted in ((line, True), ("print(O.time)", False)):
        unknown = hl.check(script(CLOUD, "", engine, f"def done():\n    {text}")).unknown
        assert any("PeriTriaxController" in finding.what for finding in unknown) is quoted


def test_the_warning_of_damping_is_that_of_the_last_run():
    text = script(CLOUD, DOWN).replace("NewtonIntegrator(", "NewtonIntegrator(label='newton', ")
    ends = {end: hl.check(f"{text}newton.damping = {end}\nO.run(10)\n") for end in (0, 0.3)}
    said = {
        end: [w.what for w in verdict.warnings if "acts on spins" in w.what] for end, verdict in ends.items()
    }
    assert said[0] == [] and len(said[0.3]) == 1 and "damping 0.3" in said[0.3][0]


WALLS = "low = O.bodies.append(wall(0, axis=2))\ntop = wall(0.1, axis=2)\nO.bodies.append(top)\n"


@pytest.mark.parametrize("bodies", [WALLS + CLOUD, CLOUD + WALLS])
def test_a_wall_that_moves_towards_another_presses_what_is_between(bodies):
    """Without gravity; the number of the wall need not be known."""
    assert said(bodies, "", end="top.state.vel = (0, 0, -0.1)").name == "pressed"
    assert said(bodies, "", end="O.bodies[1].state.vel = (0, 0, -0.1)").name == "pressed"
    assert said(bodies, "").name == "gas"
    assert said(bodies, "", end="top.state.vel = (0, 0, 0.1)").name == "gas"  # away from them
    assert said(bodies, "", end="top.state.vel = (0.1, 0, 0)").name == "gas"  # along itself
    alone = bodies.replace("top = wall(0.1, axis=2)\nO.bodies.append(top)\n", "")
    assert said(alone, "", end="O.bodies[low].state.vel = (0, 0, 1)").name == "gas"


def test_ends_of_all_spheres_are_known_if_each_place_is():
    spheres = "".join(f"O.bodies.append(sphere((0, 0, {z}), 0.002))\n" for z in (0.002, 0.006, 0.01, 0.014))
    ends = "low, high = aabbExtrema()\nO.bodies.append([wall(low[2], axis=2), wall(high[2], axis=2)])\n"
    move = "top.state.vel = (0, 0, 0.5 * (low[2] - high[2]))\n"
    bodies = f"{spheres}{ends}top = wall(high[2], axis=2)\nO.bodies.append(top)\n"
    assert said(bodies, "", end=move).name == "pressed"
    assert said(f"{CLOUD}{bodies}", "", end=move).name == "gas"  # clouds end anywhere between their corners


@pytest.mark.parametrize(
    ("rate", "name"),
    [("-3 * Matrix3.Identity", "pressed"), ("Matrix3.Identity * 3", "gas"), ("Matrix3.Zero", "gas")],
)
def test_a_cell_that_shrinks_alike_along_all_axes(rate, name):
    cell = "O.periodic = True\nO.cell.setBox(1, 1, 1)\n"
    cloud = (
        "sp = pack.SpherePack()\nsp.makeCloud((0, 0, 0), (1, 1, 1), rMean=0.05, num=50, periodic=True)\n"
        "sp.toSimulation()\n"
    )
    assert said(cell + cloud, "", end=f"O.cell.velGrad = {rate}").name == name


# --- held by fixed ones, and beds in loops ------------------------------------------------------------------------


def test_grains_rest_on_fixed_ones_whose_numbers_are_not_known():
    cloud = f"O.periodic = True\nO.cell.setBox(1, 1, 1)\n{CLOUD}"
    fixed = "for k in range(int(len(O.bodies) / 10)):\n    O.bodies[k].state.blockedDOFs = 'xyzXYZ'\n"
    assert said(cloud + fixed).name == "rest"
    assert said(cloud).name == said(cloud + fixed.replace("xyzXYZ", "yXZ")).name == "gas"


@pytest.mark.parametrize("fixing", ["b.dynamic = False", "b.state.blockedDOFs = 'xyzXYZ'"])
@pytest.mark.parametrize("test", ["", "if isinstance(b.shape, Sphere):\n        "])
def test_a_script_in_which_no_grain_moves_is_refused(fixing, test):
    with pytest.raises(ValueError, match=r"^script: no grain moves freely$"):
        hl.check(script(BOX + CLOUD + f"for b in O.bodies:\n    {test}{fixing}\n"))
    assert said(BOX + CLOUD + f"for b in O.bodies:\n    {test}b.shape.color = (1, 0, 0)\n").name == "rest"


def test_loops_that_are_too_long_make_spheres_between_their_ends():
    loop = (
        "for i in range({0}):\n    for k in range({1}):\n        for j in range({0}):\n"
        "            O.bodies.append(sphere((0.004 * i - 0.018, 0.004 * j - 0.018, 0.01 + 0.0045 * k), 0.002))\n"
    )
    short, long = (said(BOX + loop.format(*numbers)) for numbers in ((3, 10), (30, 100)))
    assert "90 grains" in short.pressure_from
    density = 1000 if "default" in long.pressure_from else 2500
    assert long.pressure == pytest.approx(0.59 * density * 10 * (0.012 + 0.0045 * 99))


def test_a_rod_is_no_piston():
    """What is much narrower than the bed leaves the rest of it under its own weight."""
    rod = "rod = O.bodies.append(geom.facetBox((0, 0, 0.15), ({0}, {0}, 0.05)))\n"
    engine = "TranslationEngine(ids=rod, translationAxis=[0, 0, -1], velocity=0.1)"
    narrow, wide = (said(BOX + CLOUD + rod.format(half), engine=engine) for half in (0.005, 0.015))
    assert narrow.name == "flow"
    assert narrow.pressure == pytest.approx(HEAVY * 0.1)
    assert "without what moving walls add" in narrow.pressure_from
    assert wide.pressure is None
    assert (
        said(BOX + CLOUD + rod.format(0.005), engine=engine.replace("rod", "ids_of_a_file")).pressure is None
    )


def test_a_sphere_that_may_be_fixed_may_hold_the_bed():
    spheres = "for k in range(9):\n    O.bodies.append(sphere((0, 0, 0.01 + 0.003 * k), 0.002, fixed={}))\n"
    state = said(spheres.format("rod_of_a_file"))
    assert state.name == "rest"
    assert "2.8 cm from the floor" in state.pressure_from  # from the lowest sphere to the highest one
    assert said(spheres.format("False")).name == "gas"


def test_grains_that_are_put_back_lie_no_higher_than_the_walls():
    high = "plate = O.bodies.append(geom.facetBox((0, 0, 0.3), (0.01, 0.01, 0), wallMask=32))\n"
    reset = "ResetRandomPosition(virtPeriod=0.01, factoryFacets=plate, velocity=(0, 0, -2))"
    assert said(BOX + CLOUD + high, engine=reset).pressure == pytest.approx(HEAVY * 0.3)
    assert said(BOX + CLOUD + high).pressure == pytest.approx(HEAVY * 0.1)


def test_surfaces_made_of_triangles():
    """Their vertices are their ends; turned ones are in the ball around the origin."""
    square = (
        "import gts\nv = [gts.Vertex(-1, -1, 0), gts.Vertex(1, -1, 0), gts.Vertex(0, 1, 0)]\n"
        "e = [gts.Edge(v[0], v[1]), gts.Edge(v[1], v[2]), gts.Edge(v[2], v[0])]\n"
        "floor = gts.Surface()\nfloor.add(gts.Face(e[0], e[1], e[2]))\n"
    )
    placed = "floor.scale(0.1, 0.1, 1)\nfloor.translate(0, 0, -0.05)\n"
    used = "O.bodies.append(pack.gtsSurface2Facets(floor))\n"
    assert said(square + placed + used + CLOUD).pressure == pytest.approx(HEAVY * 0.15)
    copied = "other = gts.Surface()\nother.copy(floor)\nfloor = other\n"
    assert said(square + placed + copied + used + CLOUD).pressure == pytest.approx(HEAVY * 0.15)
    turned = "floor.scale(0.1, 0.1, 1)\nfloor.rotate(1, 0, 0, 0.4)\n"
    assert said(square + turned + used + CLOUD).pressure == pytest.approx(HEAVY * (0.1 + 0.1 * math.sqrt(2)))
    assert said(square.replace("Vertex(0, 1, 0)", "Vertex(*of_a_file)") + used + CLOUD).pressure is None


def test_the_box_around_a_lattice():
    lattice = (
        "ball, hole = pack.inSphere((0, 0, 0.1), 0.1), pack.inSphere((9, 9, 9), 1)\n"
        "ids = O.bodies.append(pack.regularOrtho(ball - hole, radius=0.005, gap=0))\n"
    )
    sizes = (
        "from yade import bodiesHandling\nsize = bodiesHandling.spheresPackDimensions(ids)\n"
        "O.bodies.append(geom.facetBox(size['center'], size['extends'] / 2.0 * 1.2))\n"
    )
    assert said(lattice + sizes).pressure == pytest.approx(HEAVY * 0.22)
    assert said(CLOUD + sizes).pressure is None


# --- few grains, and grains that fall -----------------------------------------------------------------------------

FALLING = "".join(f"ball{k} = O.bodies.append(sphere(({0.01 * k}, 0, 0), 0.002))\n" for k in range(3))


def test_spheres_that_fall_side_by_side_never_meet():
    """Their velocities along gravity may differ."""
    up = "O.bodies[ball1].state.vel[2] = 3\n"
    assert said(FALLING + up).never_meet
    assert "side by side along gravity" in str(hl.check(script(FALLING + up)))
    assert not said(FALLING + up.replace("[2]", "[0]")).never_meet
    assert not said(FALLING.replace("0.002", "0.006") + up).never_meet
    assert not said(FALLING + up + "O.bodies.append(wall(-1, axis=2))\n").never_meet
    assert not said(FALLING + up, "").never_meet


def test_the_gravity_of_other_integrators():
    text = script(FALLING, "").replace(
        "NewtonIntegrator(", "RungeKuttaCashKarp54Integrator([], gravity=(0, 0, -10), "
    )
    assert read(text, "", {}).stages[0].gravity == 10.0


def test_components_of_velocities():
    speeds = "O.bodies[ball0].state.vel[0] = 3\nO.bodies[ball0].state.vel[2] = -4\n"
    (speed,) = read(script(FALLING + speeds, ""), "", {}).stages[0].contents.speeds
    assert speed.value == 5.0
    unknown = speeds.replace("3", "of_a_file")
    assert not read(script(FALLING + unknown, ""), "", {}).stages[0].contents.speeds


def test_numbers_of_a_pack_are_those_of_spheres():
    """Their velocities move no wall."""
    push = "for i in {}:\n    O.bodies[i].state.vel[2] = -1\n"
    numbered = CLOUD.replace("sp.toSim", "ids = sp.toSim")
    assert said(BOX + numbered + push.format("ids")).pressure == pytest.approx(HEAVY * 0.1)
    assert said(BOX + numbered + push.format("ids_of_a_file")).pressure is None


def test_one_sphere_that_moves_among_fixed_ones():
    spheres = "".join(f"O.bodies.append(sphere(({0.01 * k}, 0, 0), 0.005, fixed=True))\n" for k in range(3))
    state = said(f"{spheres}O.bodies.append(sphere((0, 0, 0.02), 0.005))\n")
    assert (state.name, state.grains) == ("rest", 1)


@pytest.mark.parametrize("ratio", [0.6, 0.8])
def test_a_poisson_ratio_of_no_material(ratio):
    """YADE takes it. With 0.6 two spheres met at 4.47 m/s for 34.2 ms and overlapped by 5.198 % in 2023.02a."""
    text = (
        "m = O.materials.append(FrictMat(young=6e8, poisson={}, density=2600, frictionAngle=0.45))\n"
        "O.bodies.append(sphere((0, 0, 0), 1, material=m))\n"
        "O.bodies.append(sphere((2.001, 0, 0), 1, fixed=True, material=m))\n"
    )
    engines = script("", "", "", "").replace(
        "Ip2_FrictMat_FrictMat_FrictPhys", "Ip2_FrictMat_FrictMat_MindlinPhys"
    )
    engines = engines.replace("Law2_ScGeom_FrictPhys_CundallStrack", "Law2_ScGeom_MindlinPhys_Mindlin")
    engines = engines.replace("damping=0.4", "damping=0")
    wrong, right = (
        hl.check(engines.replace("stone", f"{text.format(value)}stone", 1), speed=4.47213595499958)
        for value in (ratio, 0.5)
    )
    modulus = (1 - ratio**2) / 0.75  # of the softer contact
    assert wrong.state.duration / right.state.duration == pytest.approx(modulus ** (2 / 5), rel=1e-3)
    assert any("is that of no material" in warning.what for warning in wrong.warnings)
    assert not any("is that of no material" in warning.what for warning in right.warnings)
    if ratio == 0.6:
        assert wrong.state.duration == pytest.approx(0.034211, rel=2e-3)
        assert wrong.state.overlap == pytest.approx(0.051982, rel=2e-3)


@pytest.mark.parametrize("physics", ["Frict", "Mindlin"])
def test_a_wall_without_a_modulus_exerts_no_force(physics):
    """The run is read nevertheless, and its grains are those of the other contacts."""
    soft = "O.bodies.append(facet([(0, 0, 1), (1, 0, 1), (0, 1, 1)], material=FrictMat(young=0)))\n"
    law = {"Frict": "FrictPhys_CundallStrack", "Mindlin": "MindlinPhys_Mindlin"}[physics]
    text = script(f"{BOX}{CLOUD}{soft}", end="O.run(10)\nO.dt = 2e-6")
    text = text.replace("FrictMat_FrictPhys", f"FrictMat_{physics}Phys").replace(
        "FrictPhys_CundallStrack", law
    )
    described = read(text, "", {})
    assert [stage.time_step for stage in described.stages] == [1e-6, 2e-6]
    assert {contact.wall for contact in described.stages[-1].contacts} == {None, "facets of stone"}
    assert any("without a force" in note.what for note in described.ignored)


# --- the evaluator --------------------------------------------------------------------------------------------------


def test_engines_that_may_be_there_and_versions_that_are_asked_for():
    text = script(BOX + CLOUD)
    maybe = text.replace("O.engines = [", "O.engines = ([Balancer()] if 'Balancer' in dir() else []) + [")
    state = hl.check(maybe)
    assert state.state.pressure == pytest.approx(HEAVY * 0.1)
    assert any("Balancer" in finding.where for finding in state.unknown)
    condition = "if yade.libVersions.getAllVersionsCpp()['mpi'][0][0] >= 3:\n    O.dt = 5e-7\n"
    assert read(script(CLOUD, end=condition), "", {}).stages[-1].time_step == 5e-7
    assert (
        read(script(CLOUD, end=condition.replace("libVersions", "of_a_file")), "", {}).stages[-1].time_step
        is None
    )


def test_engines_by_their_place():
    others = "O.engines[:k] + O.engines[k + 1:]"
    taken = f"k = O.engines.index(newton)\nO.engines = {others} + [NewtonIntegrator(gravity=(0, 0, -5))]\n"
    text = script(BOX + CLOUD, "label='newton', gravity=(0, 0, -10), ", end=taken)
    assert hl.check(text).state.pressure == pytest.approx(0.5 * HEAVY * 0.1)


def test_what_a_print_statement_of_python_2_runs():
    printed = script(BOX + CLOUD).replace("sp.toSimulation()", "print 'spheres:', sp.toSimulation()")
    assert hl.check(printed).state.pressure == pytest.approx(HEAVY * 0.1)


# --- the survey of scripts ------------------------------------------------------------------------------------------


def test_the_survey_lists_modules_apart(monkeypatch):
    """Python that sets contacts only in functions or classes that it does not run."""
    monkeypatch.syspath_prepend(Path(__file__).parents[2] / "studies")
    import survey

    engines = "O.engines = [InteractionLoop([], [Ip2_FrictMat_FrictMat_FrictPhys()], [])]"
    function = f"def make():\n    {engines}\n\n"
    assert survey.is_module(function)
    assert survey.is_module(
        f"{function}class Test(unittest.TestCase):\n    def setUp(self):\n        make()\n"
    )
    assert not survey.is_module(function + "make()\n")
    assert not survey.is_module(f"{function}def all():\n    make()\n\nall()\n")
    assert not survey.is_module(f"{function}{engines}\n")
    assert survey.OTHERS.search("Ip2_CohFrictMat_CohFrictMat_CohFrictPhys(setCohesionNow=True)")
    assert not survey.OTHERS.search("Ip2_CohFrictMat_CohFrictMat_CohFrictPhys(setCohesionNow=False)")


# --- open funnels -----------------------------------------------------------------------------------------------

BUNKER = "O.bodies.append(geom.facetBunker((0, 0, -0.2), 0.1, 0.05, 0.1, 0.1, 0.02{}))\n"
PIPE = "O.bodies.append(geom.facetCylinder((0, 0, 0.05), 0.06, 0.3, wallMask={}))\n"
LID, FLOOR = "O.bodies.append(wall(0.2, axis=2))\n", "O.bodies.append(wall(-0.3, axis=2))\n"


@pytest.mark.parametrize(("walls", "flows"), [
    (PIPE.format(5), True),
    (PIPE.format(6), False),
    (PIPE.format(7), False),
    (PIPE.format(4) + LID, True),
    (PIPE.format(4) + FLOOR, False),
    (PIPE.format(4) + PIPE.format(2), False),
    (PIPE.format("4, orientation=Quaternion((1, 0, 0), 1)"), False),
    (BUNKER.format(""), True),
    (BUNKER.format(", wallMask=6"), False),
    (BUNKER.format("") + FLOOR, False),
    (BOX, False),
])  # fmt: skip
def test_grains_flow_out_of_what_is_open_below(walls, flows):
    bodies = f"{walls}{CLOUD}"
    assert said(bodies).name == ("flow" if flows else "rest")
    sentence = hl.check(script(bodies)).sentence
    assert ("grains rest or flow in lasting contact under gravity" in sentence) is flows


@pytest.mark.parametrize(("mask", "down", "up"), [(5, True, False), (6, False, True)])
def test_the_lower_end_of_a_pipe_is_that_along_gravity(mask, down, up):
    for gravity, flows in ((DOWN, down), (DOWN.replace("-10", "10"), up)):
        assert said(f"{PIPE.format(mask)}{CLOUD}", gravity).name == ("flow" if flows else "rest")


# --- walls beside the fall --------------------------------------------------------------------------------------


@pytest.mark.parametrize(("walls", "axes"), [
    ("wall(0, axis=2)", {2}),
    ("wall(0, axis=0)", {0}),
    ("[wall(0, axis=1), wall(0, axis=0)]", {0, 1}),
    ("facet([(0, 0, 0), (1, 0, 0), (0, 1, 0)])", {2}),
    ("facet([(0, 0, 0), (1, 0, 0), (0, 0, 1)])", {1}),
    ("facet([(0, 0, 0), (1, 0, 0), (0, 0.1, 1)])", {0, 1, 2}),
    ("geom.facetBox((0, 0, 0.1), (0.1, 0.1, 0.2), wallMask=15)", {0, 1}),
    ("geom.facetBox((0, 0, 0.1), (0.1, 0.1, 0.2))", {0, 1, 2}),
    ("geom.facetCylinder((0, 0, 0), 0.1, 0.2, wallMask=4)", {0, 1}),
    ("geom.facetCylinder((0, 0, 0), 0.1, 0.2, wallMask=6)", {0, 1, 2}),
    ("ymport.stl('missing.stl')", {0, 1, 2}),
])  # fmt: skip
def test_walls_along_gravity_hold_no_grains(walls, axes):
    """Those whose directions are not known may."""
    bodies = f"from yade import ymport\nO.bodies.append({walls})\n{CLOUD}"
    for axis in range(3):
        gravity = f"gravity={tuple(-10 * (k == axis) for k in range(3))}, "
        assert (said(bodies, gravity).name != "gas") is (axis in axes)
