"""The pressure on grains at rest in scripts of YADE: from their number, the floor, and where they are made."""

import cmath
import math
import random

import pytest

import hardlimit as hl
from conftest import slow
from hardlimit.checking import at_rest
from hardlimit.checking.scripts import read

SCRIPT = """from yade import geom, pack, ymport
stone = O.materials.append(FrictMat(young=1e7, poisson=0.3, frictionAngle={angle}, density=2500, label="stone"))
{bodies}
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Facet_Aabb(), Bo1_Wall_Aabb(), Bo1_Box_Aabb()]),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom(), Ig2_Facet_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom(), Ig2_Box_Sphere_ScGeom()],
        [Ip2_FrictMat_FrictMat_FrictPhys()], [Law2_ScGeom_FrictPhys_CundallStrack()]),
    NewtonIntegrator(gravity={gravity}, damping=0.4),{engine}
]
O.dt = 1e-6
{end}
O.run(1000, True)
"""
CLOUD = "sp = pack.SpherePack()\nsp.makeCloud({}, {}, rMean={!r}{})\nsp.toSimulation()\n"
BOX = "O.bodies.append(geom.facetBox((0.01, 0.01, 0.05), (0.01, 0.01, 0.05), wallMask=31))\n"
IN_BOX = CLOUD.format((0, 0, 0.01), (0.02, 0.02, 0.09), 1e-3, "{}")
#: A predicate within which spheres are not counted.
HOLED = "holed = pack.inAlignedBox((0, 0, 0), (0.02, 0.02, 0.07)) - pack.inSphere((9, 9, 9), 1)\n"
FILLED = BOX + IN_BOX.format(", num=500")


def state(bodies, gravity=(0, 0, -9.81), engine="", end="", angle=0.4):
    """What check says of the grains of a script."""
    text = SCRIPT.format(bodies=bodies, gravity=gravity, engine=engine, end=end, angle=angle)
    said = hl.check(text, speed=0.1).state
    assert said is not None and said.name == "rest"
    return said


def weight_of(number, radius, area, gravity=9.81):
    """Pressure of so many grains on an area."""
    return number * 2500 * 4 / 3 * math.pi * radius**3 * gravity / area


@pytest.mark.parametrize("seed", [0, 1, *map(slow, range(2, 8))])
def test_the_weight_of_grains_between_walls_is_that_over_their_floor(seed):
    """In a box of facets, of plates, between six walls and in YADE's six boxes around corners, of any axis."""
    rng = random.Random(seed)
    half = [rng.uniform(0.01, 0.03) for _ in range(3)]
    middle = [rng.uniform(-0.1, 0.1) for _ in range(3)]
    low, high = (tuple(c + sign * h for c, h in zip(middle, half, strict=True)) for sign in (-1, 1))
    axis, sign = rng.randrange(3), rng.choice((-1, 1))
    gravity = tuple(sign * 4.0 if k == axis else 0 for k in range(3))
    area = math.prod(2 * h for k, h in enumerate(half) if k != axis)
    radius = 0.03 * min(half)
    number = int(2.5 * area / radius**2)
    cloud = CLOUD.format("low", "high", radius, f", num=int({number})")
    corners = f"low, high = Vector3{low}, Vector3{high}\n"
    plates = ""
    for k, (end, sign) in [(k, each) for k in range(3) for each in ((low, -1), (high, 1))]:
        centre = [end[k] + sign * 0.001 if j == k else c for j, c in enumerate(middle)]
        sizes = [0.001 if j == k else 1.2 * h for j, h in enumerate(half)]
        plates += f"O.bodies.append(box({centre}, {sizes}, fixed=True))\n"
    walls = "".join(
        f"O.bodies.append(wall({end}[{k}], axis={k}))\n" for k in range(3) for end in ("low", "high")
    )
    for container in (
        "O.bodies.append(geom.facetBox(0.5 * (low + high), (high - low) / 2))\n",
        "O.bodies.append(aabbWalls([low, high], thickness=0.001))\n",
        walls,
        plates,
    ):
        said = state(corners + container + cloud, gravity)
        assert said.pressure == pytest.approx(weight_of(number, radius, area, 4.0), rel=1e-9), container
        assert said.pressure_is_bound
        assert said.pressure_from == f"below {number} grains on the floor of the box"


@pytest.mark.parametrize("segments", [5, 10, 40])
def test_the_floor_of_a_cylinder_of_facets_is_a_polygon(segments):
    sizes = f"(0, 0, 0.05), 0.02, 0.1, segmentsNumber={segments}"
    cylinder = f"O.bodies.append(geom.facetCylinder({sizes}, wallMask={{}}))\n"
    cloud = CLOUD.format((-0.01, -0.01, 0.01), (0.01, 0.01, 0.09), 5e-4, ", num=3000")
    corners = [0.02 * cmath.exp(2j * math.pi * k / segments) for k in range(segments)]
    area = 0.5 * sum((corners[k - 1].conjugate() * corners[k]).imag for k in range(segments))
    for closed in (cylinder.format(6), cylinder.format(4) + "O.bodies.append(wall(0, 2))\n"):
        assert state(closed + cloud).pressure == pytest.approx(weight_of(3000, 5e-4, area))
    assert (
        "from the floor"
        in state(cylinder.format(4) + "O.bodies.append(wall(-0.1, 2))\n" + cloud).pressure_from
    )


@pytest.mark.parametrize(
    "cell",
    [
        "setBox(0.02, 0.03, 0.2)",
        "setBox((0.02, 0.03, 0.2))",
        "hSize = Matrix3(0.02, 0, 0, 0, 0.03, 0, 0, 0, 0.2)",
    ],
)
def test_a_periodic_cell_has_the_weight_on_its_floor_alone(cell):
    """Nothing beside carries a part of it."""
    bodies = f"O.periodic = True\nO.cell.{cell}\n{{}}" + CLOUD.format(
        (0, 0.01, 0.02), (0.02, 0.02, 0.15), 1e-3, ", num=900"
    )
    said = state(bodies.format("O.bodies.append(wall((0, 0, 0.01), 2))\n"))
    assert said.pressure == pytest.approx(weight_of(900, 1e-3, 0.0006)) and not said.pressure_is_bound
    for floor in ("wall(0.05, 2)", "box((0.01, 0.015, 0.005), (0.008, 0.015, 0.002), fixed=True)"):
        assert state(bodies.format(f"O.bodies.append({floor})\n")).pressure is None


@pytest.mark.parametrize(("bodies", "height"), [
    (BOX + IN_BOX.format(""), 0.09),
    ("O.bodies.append(wall(-0.01, 2))\n" + IN_BOX.format(", num=5000"), 0.1),
    ("O.bodies.append(box((0, 0, 0), (1, 1, 0.02), fixed=True))\n" + IN_BOX.format("").replace("0.01", "0.02"), 0.07),
    (BOX + IN_BOX.format("").replace("sp.toSimulation()", "for c, r in sp:\n    O.bodies.append(sphere(c, r))"), 0.09),
    (f"{BOX}{HOLED}O.bodies.append(pack.regularOrtho(holed, 1e-3, 0))\n", 0.07),
    ("O.bodies.append(wall(0, 2))\nO.bodies.append([sphere((0, 0, k * 1e-2), 2e-3) for k in range(1, 13)])\n", 0.048),
    ("O.bodies.append(wall(0, 2))\nO.bodies.append([sphere((0, 0, k), 2e-3) for k in range(1, 4)])\n", 0.012),
])  # fmt: skip
def test_no_bed_is_higher_than_where_its_grains_are_made(bodies, height):
    """Nor than all of them in one stack."""
    said = state(bodies, angle=0.4)
    assert said.pressure == pytest.approx(0.59 * 2500 * 9.81 * height) and said.pressure_is_bound
    assert ("in one stack" if "range" in bodies else "to where spheres are made") in said.pressure_from


def test_too_few_grains_for_a_layer_are_a_heap():
    """Below the top of a cone of 45° with the volume of the bed: V = π h³/3."""
    said = state(BOX + IN_BOX.format(", num=100"))
    height = (100 * 4e-9 / 0.59) ** (1.0 / 3.0)
    assert said.pressure == pytest.approx(0.59 * 2500 * 9.81 * height) and said.pressure_is_bound
    assert "heap of 100 grains" in said.pressure_from


def test_a_heap_of_grains_in_one_plane_is_a_triangle():
    """Of a layer one diameter deep: 120 of R 0.5 m rest 5.9 m high in 2023.02a, more than a cone of 4.7 m."""
    rows = "O.bodies.append([sphere((i + j / 2, {}, j + 0.5), 0.5) for i in range(15) for j in range(8)])\n"
    floor = "O.bodies.append(box((8, 0, -0.1), (60, 4, 0.1), fixed=True))\n"
    volume = 120 * 4 / 3 * math.pi * 0.5**3 / 0.59
    plane, deep = state(floor + rows.format(0)), state(floor + rows.format("2 * (j % 2)"))
    assert plane.pressure == pytest.approx(0.59 * 2500 * 9.81 * math.sqrt(volume / 1.0))
    assert deep.pressure == pytest.approx(0.59 * 2500 * 9.81 * (3 * volume / math.pi) ** (1 / 3))
    assert "in one plane" in plane.pressure_from


@pytest.mark.parametrize(("bodies", "height"), [
    ("O.bodies.append(geom.facetBox((0, 0, 0), (1, 1, 1)))\n", 1.4),
    ("O.bodies.append(geom.facetBox((0, 0, 0), (1, 1, 1), wallMask=47))\n", None),  # no bottom
    ("O.bodies.append(geom.facetCylinder((0, 0, 0), 1, 2))\n", 1.4),
    ("O.bodies.append(geom.facetCylinder((0, 0, 0), 1, 2, wallMask=5))\n", None),
    ("O.bodies.append(facet([(-1, -1, -1), (1, -1, -1), (0, 1, -1)]))\n", 1.4),
    ("O.bodies.append(facet([(-1, 0, -1), (1, 0, -1), (0, 0, 0.3)]))\n", None),  # it stands upright
    ("O.bodies.append(wall(0.4, 2))\nO.bodies.append(wall(-1, 2))\n", None),  # the sphere touches the upper one
])  # fmt: skip
def test_spheres_fall_on_what_is_below_them(bodies, height):
    """By the speed of this fall with half of the damping; without it, that of √(g d)."""
    sphere = "O.bodies.append(sphere((random.uniform(-9, 9), random.gauss(0, 1), random.uniform(0.1, 0.5)), 0.1))\n"
    text = SCRIPT.format(
        bodies=f"import random\n{bodies}{sphere}", gravity=(0, 0, -10), engine="", end="", angle=0.4
    )
    (said,) = [number for number in hl.check(text).inferred if number.what == "speed"]
    fallen = math.sqrt(2 * 0.6 * 10 * height) if height else math.sqrt(10 * 0.2)
    assert said.value == pytest.approx(fallen) and ("fall" in said.source) is bool(height)


CALLBACK = "\n    PyRunner(command='later()', iterPeriod=10),"


@pytest.mark.parametrize(("bodies", "engine", "end"), [
    (FILLED, CALLBACK, "def later():\n    O.bodies.append(wall(0.05, 2))"),
    (FILLED, CALLBACK, "def later():\n    O.bodies[0].state.vel = (0, 0, -1)"),
    (FILLED, "\n    PyRunner(command='O.bodies[3].state.pos = (0, 0, 0)', iterPeriod=10),", ""),
    (FILLED, "", "O.forces.addF(3, (0, 0, -10), permanent=True)"),
    (FILLED.replace("(0.01, 0.01, 0.05), w", "(0.01, float(input()), 0.05), w"), "", ""),
    (FILLED.replace("wallMask=31", "wallMask=15") + "O.bodies.append(ymport.stl('funnel.stl'))\n", "", ""),
    (FILLED + "O.bodies.append(ymport.text('spheres.txt'))\n", "", ""),
    (FILLED + "O.bodies.append(box((0.01, 0.01, 0.08), (0.002, 0.002, 0.002)))\n", "", ""),
    (FILLED, "\n    ForceEngine(ids=[7], force=(0, 0, -1)),", ""),
    ("O.bodies.append(wall(0, 2))\nO.bodies.append([sphere((0, 0, k), 2e-3) for k in range(1, 3)])\n", "", ""),
])  # fmt: skip
def test_there_is_no_pressure_where_something_is_not_known(bodies, engine, end):
    """Callbacks that add or move bodies, walls that press, forces, files that are not there; two grains."""
    assert state(FILLED).pressure is not None
    assert state(bodies, engine=engine, end=end).pressure is None


@pytest.mark.parametrize("more", [
    "O.bodies.append(box((0.01, 0.01, 0.02), (0.002, 0.002, 0.02), fixed=True))\n",
    "O.bodies.append(facet([(0, 0, 0.02), (0.01, 0, 0), (0, 0.01, 0)]))\n",
    "O.bodies.append(geom.facetBox((0.01, 0.01, 0.03), (0.005, 0.005, 0.01)))\n",
])  # fmt: skip
def test_a_floor_with_something_on_it_is_not_used(more):
    assert "from the floor" in state(FILLED + more).pressure_from


def test_the_pressure_is_that_in_yade():
    """YADE 2023.02a, a box of 16 mm without friction: 234 Pa on the floor, and a mean overlap of 0.0074 % of R in the
    lowest 4 mm, after 60 000 steps of 10 µs (unbalanced force 0.10).
    """
    box = "side = 0.016\nO.bodies.append(geom.facetBox((side/2, side/2, 0.05), (side/2, side/2, 0.05), wallMask=31))\n"
    said = state(
        box + CLOUD.format((0, 0, 0.001), (0.016, 0.016, 0.06), 1e-3, ", num=600, seed=1"), angle=0.0
    )
    assert said.pressure == pytest.approx(234, rel=0.04) and said.pressure > 234
    assert said.overlap == pytest.approx(7.4e-5, rel=0.06)


# --- grains that are not what their material and their numbers say -------------------------------------------------

CELL = """from yade import pack
O.periodic = True
O.cell.setBox(0.1, 0.1, 0.1)
O.materials.append(FrictMat(young=1e7, poisson=0.3, frictionAngle=0.4, density=2500))
sp = pack.SpherePack()
sp.makeCloud((0, 0, 0), (0.1, 0.1, 0.1), rMean=0.004, rRelFuzz=0.2, num={number}, periodic=True)
sp.toSimulation()
{end}
O.engines = [
    ForceResetter(), InsertionSortCollider([Bo1_Sphere_Aabb()]),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_FrictPhys()],
        [Law2_ScGeom_FrictPhys_CundallStrack()]),
    {engine},
    NewtonIntegrator(damping=0.2)]
O.dt = 0.5 * PWaveTimeStep()
O.run(1000, True)
"""
SQUEEZED = "PeriTriaxController(goal=(-1e4, -1e4, -1e4), stressMask=7)"
GROWING = "TriaxialStressController(goal1=-1e4, goal2=-1e4, goal3=-1e4, stressMask=7{})"


def cell(number=900, end="", engine=SQUEEZED):
    return hl.check(CELL.format(number=number, end=end, engine=engine))


def test_a_cloud_without_room_has_unknown_sizes():
    """YADE puts the largest spheres first and gives up: of 700 with φ = 0.9, 108 of the upper tenth of the radii."""
    filled, overfull = cell(), cell(number=3500)
    assert filled.rows[0].radius == pytest.approx(0.0032) and filled.state.largest_stable_step
    assert all(row.radius is None for row in overfull.rows) and "sizes" in overfull.missing
    assert overfull.time_step is None and overfull.state.largest_stable_step is None
    assert overfull.state.stiffness_number == pytest.approx(filled.state.stiffness_number)


@pytest.mark.parametrize(("fuzz", "number", "periodic", "placed"), [
    (0.0, 300, False, 0.25), (0.2, 300, False, 0.32), (0.5, 300, False, 0.36), (0.8, 2000, False, 0.34),
    (0.0, 2000, True, 0.28), (0.2, 300, True, 0.34), (0.0, 20, False, 0.2), (0.5, 60, False, 0.28),
])  # fmt: skip
def test_a_cloud_has_its_number_where_all_of_it_finds_place(fuzz, number, periodic, placed):
    """In YADE 2023.02a all are placed at the first packing fraction, and 0.34 to 0.93 of them at the second one."""
    low, high = sorted((placed, 0.31 if fuzz == 0.0 else 0.43))
    for phi, all_placed in ((0.98 * low, True), (high, False)):
        radius = (phi / (number * 4 / 3 * math.pi * (1 + fuzz * fuzz))) ** (1 / 3)
        cloud = f", rRelFuzz={fuzz}, num={number}, periodic={periodic}"
        text = CLOUD.format((0, 0, 0), (1, 1, 1), radius, cloud)
        stage = read(SCRIPT.format(bodies=text, gravity=(0, 0, 0), engine="", end="", angle=0.4)).stages[-1]
        assert (stage.contents.count == number) is all_placed
        known = all_placed or fuzz == 0.0
        assert (stage.grains["stone"].radii is not None) is known


def test_masses_that_a_script_sets_are_not_those_of_the_material():
    heavy = cell(end="for b in O.bodies:\n    b.state.mass = 1e-3 * b.shape.radius")
    assert heavy.time_step is None and all(row.duration is None for row in heavy.rows)
    assert "masses" in heavy.missing and heavy.state.largest_stable_step is None
    assert heavy.state.overlap == pytest.approx(cell().state.overlap, rel=0.12)  # without their unequal sizes


def test_one_layer_of_spheres_carries_what_is_prescribed_over_the_cell():
    """400 in a cell ten times as thick: overlaps in YADE are 12 times those of a packing in space."""
    assert cell().state.pressure == 1e4
    assert cell(end="for b in O.bodies:\n    b.state.blockedDOFs = 'zXY'").state.pressure is None


@pytest.mark.parametrize("option,grows", [("", True), (", internalCompaction=False", False)])
def test_spheres_that_a_controller_makes_larger_have_unknown_sizes(option, grows):
    """In YADE, 1000 in a box grow by a factor of 2.2 until they are under their pressure."""
    verdict = cell(engine=GROWING.format(option))
    assert (verdict.rows[0].radius is None) is grows
    assert any("radii that grow" in finding.what for finding in verdict.ignored) is grows
    assert verdict.state.pressure == 1e4 and (verdict.state.largest_stable_step is None) is grows


def test_a_stress_along_one_axis_is_not_the_mean():
    along = cell(engine=SQUEEZED.replace("stressMask=7", "stressMask=4")).state
    share = at_rest.under_piston(math.tan(0.4), along.stiffness_number)
    assert share < 0.8 and along.overlap < 0.9 * cell().state.overlap
    same = hl.check(CELL.format(number=900, end="", engine=SQUEEZED), pressure=share * along.pressure).state
    assert along.overlap == pytest.approx(same.overlap)


def test_soft_pressed_grains_have_a_wider_range():
    """1000 equal spheres with μ 0.55 in cells of YADE have φ z = 3.05 at κ_p = 100, 2.49 at 500 and 2.17 at 5000."""
    for young, carrying in ((2e6, 3.05), (1e7, 2.49), (1e8, 2.17)):
        text = (
            CELL.format(number=900, end="", engine=SQUEEZED)
            .replace("rRelFuzz=0.2, ", "")
            .replace("1e7", repr(young))
        )
        low, high = hl.check(
            text.replace("frictionAngle=0.4", "frictionAngle=atan(0.55)")
        ).state.overlap_range
        assert low < 4.0 * math.pi * 1e4 / (young * carrying) < high


def test_only_the_damping_of_the_last_run_is_warned_of():
    text = CELL.format(number=900, end="", engine=SQUEEZED).replace("damping=0.2", "damping=0.2, label='n'")
    verdict = hl.check(text + "n.damping = 0.1\nO.run(1000, True)\n")
    (warned,) = (warning.what for warning in verdict.warnings if "acts on spins" in warning.what)
    assert "0.1 of NewtonIntegrator" in warned


def test_contacts_that_do_not_depend_on_the_speed_have_one_row():
    """Also if ε differs by rounding, and nothing else is known."""
    text = CELL.format(number=3500, end="", engine=SQUEEZED)
    verdict = hl.check(text.replace("damping=0.2", "damping=0.4"))
    assert [row.speed for row in verdict.rows] == [None]
    assert not any("were chosen" in remark for remark in verdict.remarks)
