"""Beds of YADE scripts between other walls: packings, random places, meshes, fixed grains, moving walls, fluids."""

import math
import struct

import numpy as np
import pytest
from test_yade_beds import BOX, CALLBACK, CLOUD, FILLED, HOLED, IN_BOX, SCRIPT, state, weight_of

import hardlimit as hl
from hardlimit.checking.scripts import read

FLOOR = "O.bodies.append(wall(0, 2))\n"
HEIGHT = 2500 * 9.81  #: weight of one metre of rock


def held(bodies, gravity=(0, 0, -9.81), engine="", end=""):
    """What check says of the grains of a script in any state."""
    text = SCRIPT.format(bodies=bodies, gravity=gravity, engine=engine, end=end, angle=0.4)
    return hl.check(text, speed=0.1).state


def described(text):
    """The last stage of a script."""
    return read(SCRIPT.format(bodies=text, gravity=(0, 0, -9.81), engine="", end="", angle=0.4)).stages[-1]


# --- where spheres are made -------------------------------------------------------------------------------------


@pytest.mark.parametrize(("packing", "phi"), [
    ("regularHexa({}, radius=1e-3, gap=0)", math.pi / math.sqrt(18)),
    ("regularHexa({}, radius=1e-3, gap=1e-4)", math.pi / math.sqrt(18) / 1.05**3),
    ("regularHexa({}, radius=1e-3, gap=1e-3)", 0.59),
    ("randomDensePack({}, radius=1e-3)", 0.64),
    ("regularOrtho({}, radius=1e-3, gap=0)", 0.59),
])  # fmt: skip
def test_a_packing_that_is_denser_than_a_bed_counts_as_dense_as_it_is(packing, phi):
    """A hexagonal one has π/√18 without gaps."""
    said = state(f"{BOX}{HOLED}O.bodies.append(pack.{packing.format('holed')})\n")
    assert said.pressure == pytest.approx(phi * HEIGHT * 0.07) and said.pressure_is_bound


@pytest.mark.parametrize(("space", "top"), [
    ("pack.inSphere((0, 0, 0.03), 0.02)", 0.048),  # of its highest sphere
    ("pack.inEllipsoid((0, 0, 0.03), (0.01, 0.01, 0.015))", 0.045),
    ("pack.inCylinder((0, 0, 0.02), (0, 0, 0.05), 0.01)", 0.06),
    ("pack.inParallelepiped((0, 0, 0.01), (0.01, 0, 0.01), (0, 0.01, 0.02), (0, 0, 0.03))", 0.04),
    ("pack.inSphere((0, 0, 0.03), 0.02) - pack.inSphere((0, 0, 0.06), 0.02)", 0.05),
    ("pack.inSphere((0, 0, 0.03), 0.02) & pack.inAlignedBox((-1, -1, 0.01), (1, 1, 0.04))", 0.04),
    ("pack.inSphere((0, 0, 0.03), 0.02) & pack.notInNotch((0, 0, 0), (0, 1, 0), (1, 0, 0), 0.01)", 0.05),
    ("pack.inSphere((0, 0, 0.03), 0.02) | pack.inSphere((0, 0, 0.06), 0.02)", 0.08),
    ("pack.inGtsSurface(pack.sweptPolylines2gtsSurface([[Vector3(0.01 * cos(a), 0.01 * sin(a), z)"
     " for a in linspace(0, 6, num=9, endpoint=True)] for z in (0.01, 0.05)]))", 0.05),
])  # fmt: skip
def test_predicates_say_where_packings_end(space, top):
    said = state(f"{FLOOR}O.bodies.append(pack.regularOrtho({space}, radius=1e-3, gap=0))\n")
    assert said.pressure == pytest.approx(0.59 * HEIGHT * top)


def test_clouds_in_the_box_around_a_surface_and_filtered_ones_end_with_it():
    funnel = (
        "thetas = linspace(0, 2 * pi, 8)\n"
        "rings = pack.revolutionSurfaceMeridians([[(0.02, 0.03), (0.01, 0.01)] for _ in thetas], thetas)\n"
        "surface = pack.sweptPolylines2gtsSurface(rings)\nspace = pack.inGtsSurface(surface)\n"
        "sp = pack.SpherePack()\nsp.makeCloud(*space.aabb(), rMean=1e-3)\n"
        "sp = pack.filterSpherePack(space, sp, returnSpherePack=True)\nsp.toSimulation()\n"
    )
    moved = "surface.translate(0, 0, 0.01)\nO.bodies.append(pack.gtsSurface2Facets(surface))\n"
    assert state(FLOOR + funnel).pressure == pytest.approx(0.64 * HEIGHT * 0.03)
    assert state(funnel + moved.partition("\n")[2]).pressure == pytest.approx(0.64 * HEIGHT * 0.02)
    turned = state(
        funnel + "surface.rotate(1, 0, 0, 0.3)\n" + moved
    ).pressure  # within a ball around the origin
    assert turned == pytest.approx(0.64 * HEIGHT * (0.03 + math.sqrt(3 * 0.02**2) - 0.01), rel=0.3)


def test_grains_at_random_places_are_below_the_highest_one():
    """Their places across gravity need not have an end."""
    for x in ("random.gauss(0, 1)", "0.01 * random.random()", "np.random.uniform(0, 1)"):
        spheres = f"for k in range(50):\n    O.bodies.append(sphere(({x}, 0, 0.01 + 0.02 * random.random()), 1e-3))\n"
        said = state(f"import random\nimport numpy as np\n{FLOOR}{spheres}")
        assert said.pressure == pytest.approx(0.59 * HEIGHT * 0.031)
    for z in ("random.gauss(0, 1)", "1 / random.random()", "lottery()"):
        assert state(f"import random\n{FLOOR}{spheres.replace('0.02 * random.random()', z)}").pressure is None


def test_a_moved_pack_is_where_it_is_moved():
    loop = "O.bodies.append([sphere(c + Vector3(0, 0, {}), r) for c, r in sp])\n"
    cloud = CLOUD.format((0, 0, 0.01), (0.02, 0.02, 0.03), 1e-3, "").replace("sp.toSimulation()\n", "")
    heights = {
        "sp.toSimulation()\n": 0.03,
        "sp.translate((0, 0, 0.05))\nsp.toSimulation()\n": 0.08,
        loop.format(0.02): 0.05,
        "sp.rotate((1, 0, 0), 0.5)\nsp.toSimulation()\n": 0.02 + 0.01 * math.sqrt(3),
    }
    for moved, height in heights.items():
        assert state(FLOOR.replace("0,", "-0.0,") + cloud + moved).pressure == pytest.approx(
            0.59 * HEIGHT * height
        )
    assert state(FLOOR + cloud + "sp.cellFill((1, 1, 1))\nsp.toSimulation()\n").pressure is None


def test_factories_make_no_bed_higher_than_themselves():
    box = "\n    BoxFactory(center=(0, 0, 0.05), extents=(0.01, 0.01, 0.02), rMin=1e-3, rMax=1e-3, materialId=0),"
    circle = "\n    CircularFactory(center=(0, 0, 0.05), radius=0.02, length=0, rMin=1e-3, rMax=1e-3, materialId=0),"
    for engine in (box, circle):
        assert state(BOX, engine=engine).pressure == pytest.approx(0.59 * HEIGHT * 0.07)
    assert state(BOX, engine=box.replace("(0, 0, 0.05)", "where()")).pressure is None
    diameters = box.replace("rMin=1e-3, rMax=1e-3", "PSDsizes=[1e-3, 4e-3], PSDcum=[0.5, 1.0]")
    text = SCRIPT.format(bodies=BOX, gravity=(0, 0, -9.81), engine=diameters, end="", angle=0.4)
    assert read(text).stages[-1].grains["stone"].radii == (5e-4, 2e-3)


@pytest.mark.parametrize(("number", "porosity", "fuzz", "smallest", "largest"), [
    (2000, 0.65, 0.2, 0.77268, 1.15849),
    (500, 0.65, 0.0, 0.9, 0.9),
    (300, 0.5, 0.3, 0.61086, 1.12873),
    (1000, 0.7, 0.33, 0.67099, 1.32967),
    (200, 0.65, 0.5, 0.50746, 1.49751),
])  # fmt: skip
def test_a_cloud_of_given_porosity_may_have_smaller_spheres(number, porosity, fuzz, smallest, largest):
    """Radii of YADE 2023.02a over that of the porosity asked, with seed 1 in a cube of 1 m."""
    cloud = f"sp = pack.SpherePack()\nsp.makeCloud((0, 0, 0), (1, 1, 1), -1, {fuzz}, {number}, False, {porosity})\n"
    low, high = described(f"{FLOOR}{cloud}sp.toSimulation()\n").grains["stone"].radii
    wanted = (0.75 * (1 - porosity) / (math.pi * (1 + fuzz**2) * number)) ** (1 / 3)
    assert low <= smallest * wanted and largest * wanted <= high
    assert high / wanted == pytest.approx(1 + fuzz) and low / wanted > 0.79 * (1 - fuzz)
    assert state(f"{FLOOR}{cloud}sp.toSimulation()\n").pressure == pytest.approx(0.59 * HEIGHT)


def test_facets_and_spheres_may_be_added_as_lists():
    together = BOX.replace("31))", "31) + [sphere((0.01, 0.01, 0.01 * k), 1e-3) for k in xrange(1, 7)])")
    description = read(SCRIPT.format(bodies=together, gravity=(0, 0, -1), engine="", end="", angle=0))
    assert description.stages[-1].contents.count == 6 and not description.unknown


def test_a_scene_that_is_loaded_has_its_walls_and_grains():
    moved = "O.saveTmp()\nO.bodies[0].state.pos = (0, 0, 1)"
    assert state(FILLED, end=moved).pressure is None
    assert state(FILLED, end=f"{moved}\nO.loadTmp()").pressure == state(FILLED).pressure


# --- walls ------------------------------------------------------------------------------------------------------

CORNERS = np.array([[0.0, 0.0, -1.0], [4.0, 0.0, -1.0], [0.0, 2.0, 3.0], [0.0, 0.0, 0.5]])


def stl(triangles, text):
    """A file of STL, as text or binary."""
    if text:
        loops = ["outer loop\n" + "".join(f"vertex {x} {y} {z}\n" for x, y, z in each) for each in triangles]
        return (
            "solid a\n"
            + "".join(f"facet normal 0 0 1\n{loop}endloop\nendfacet\n" for loop in loops)
            + "endsolid a\n"
        )
    rows = b"".join(struct.pack("<12fH", 0, 0, 1, *map(float, np.ravel(each)), 0) for each in triangles)
    return b"solid but binary".ljust(80) + struct.pack("<I", len(triangles)) + rows


def mesh(points):
    """A file of GMSH."""
    rows = "".join(f" {x} {y} {z} {k}\n" for k, (x, y, z) in enumerate(points, 1))
    return f"MeshVersionFormatted 2\nDimension\n3\n Vertices\n {len(points)}\n{rows} Triangles\n 1\n 1 2 3 1\nEnd\n"


@pytest.mark.parametrize(("call", "bottom"), [
    ("stl('{}.stl', scale=0.01)", -0.01),
    ("stl('{}.stl', scale=0.01, shift=(0, 0, -0.02))", -0.03),
    ("gmsh('{}.mesh', scale=0.01)", -0.01),
    ("gmsh('{}.mesh', scale=0.01, orientation=Quaternion((1, 0, 0), 0.3))", -0.01 * math.cos(0.3)),
    ("gmsh('{}.mesh', scale=0.01, orientation=aslant)", -0.01 * math.sqrt(4**2 + 2**2 + 3**2)),
])  # fmt: skip
def test_meshes_beside_the_script_say_where_walls_end(tmp_path, call, bottom):
    triangles = [CORNERS[:3], CORNERS[1:]]
    (tmp_path / "text.stl").write_text(stl(triangles, True))
    (tmp_path / "binary.stl").write_bytes(stl(triangles, False))
    for name in ("text", "binary"):
        (tmp_path / f"{name}.mesh").write_text(mesh(CORNERS))
        bodies = f"O.bodies.append(ymport.{call.format(name)})\n" + CLOUD.format(
            (0, 0, 0.01), (0.02, 0.02, 0.04), 1e-3, ""
        )
        path = tmp_path / "bed.py"
        path.write_text(SCRIPT.format(bodies=bodies, gravity=(0, 0, -9.81), engine="", end="", angle=0.4))
        assert hl.check(path, speed=0.1).state.pressure == pytest.approx(0.59 * HEIGHT * (0.04 - bottom))
        path.write_text(path.read_text().replace(f"{name}.", "other."))
        assert hl.check(path, speed=0.1).state.pressure is None
    (tmp_path / "other.stl").write_bytes(b"solid but binary".ljust(80) + struct.pack("<I", 9) + b"0" * 100)
    (tmp_path / "other.mesh").write_text("Vertices\n5\n0 0 0 1\n")
    assert hl.check(path, speed=0.1).state.pressure in (None, pytest.approx(0.59 * HEIGHT * 0.04))


def test_above_a_floor_it_does_not_matter_how_far_other_walls_reach():
    """If the floor is below all grains, wherever they are made."""
    funnel = "O.bodies.append(ymport.stl('funnel.stl'))\n"
    for floor in (FLOOR, BOX, "O.bodies.append(box((0.01, 0.01, -0.01), (0.02, 0.02, 0.01), fixed=True))\n"):
        assert state(floor + funnel + IN_AIR).pressure == pytest.approx(0.59 * HEIGHT * 0.09)
    for floor in (
        "",
        "O.bodies.append(wall(0.05, 2))\n",
        "O.bodies.append(box((0, 0, -0.01), (0.01, 1, 0.01), fixed=True))\n",
    ):
        assert state(floor + funnel + IN_AIR).pressure is None


IN_AIR = CLOUD.format((0, 0, 0.01), (0.02, 0.02, 0.09), 1e-3, "")


@pytest.mark.parametrize(("facets", "bottom"), [
    ("geom.facetSphere((0, 0, 0.03), 0.05)", -0.02),
    ("geom.facetCone((0, 0, 0.03), 0.05, 0.02, 0.08)", -0.01),
    ("geom.facetBunker((0, 0, -0.05), dBunker=0.1, dOutput=0.02, hBunker=0.1, hOutput=0.03, hPipe=0.02, wallMask=6)",
     -0.05),
    ("geom.facetCylinder((0, 0, 0.03), 0.03, 0.08, orientation=Quaternion((1, 0, 0), 0.5))",
     0.03 - 0.03 * math.sin(0.5) - 0.04 * math.cos(0.5)),
    ("geom.facetCylinder((0, 0, 0.03), 0.03, 0.08, orientation=aslant)", 0.03 - math.hypot(0.03, 0.03, 0.04)),
    ("geom.facetBox((0, 0, 0), (0.03, 0.04, 0), orientation=Quaternion(0.5, (1, 0, 0)))", -0.04 * math.sin(0.5)),
    ("geom.facetBox((0, 0, 0), (0.03, 0.04, 0), orientation=Quaternion((2, 0, 0), 0.5))",
     -0.04 * math.sin(2 * math.atan(2 * math.tan(0.25)))),
    ("geom.facetBox((0, 0, 0), (0.03, 0.04, 0), orientation=aslant)", -0.05),
])  # fmt: skip
def test_facets_of_functions_end_where_they_may_reach(facets, bottom):
    """Those turned in an unknown way in the ball around their box. As in YADE 2023.02a, an axis may have any length."""
    said = state(f"O.bodies.append({facets})\n{IN_AIR}")
    assert said.pressure == pytest.approx(0.59 * HEIGHT * (0.09 - bottom))


def test_walls_that_touch_nothing_hold_nothing():
    """YADE lets bodies meet that have a bit of their masks in common."""
    lid = "O.bodies.append(box((0.01, 0.01, 0.05), (1, 1, 0), fixed=True, mask={}))\n"
    assert state(FILLED + lid.format(0)).pressure_from == state(FILLED).pressure_from
    assert "from the floor" in state(FILLED + lid.format(1)).pressure_from


ROUGH = (
    "for x in range(10):\n    for y in range(10):\n"
    "        O.bodies.append(sphere((2e-3 * x, 2e-3 * y, {}), 1e-3, fixed=True))\n"
)
CELL = (
    "O.periodic = True\nO.cell.setBox(0.02, 0.02, 0.2)\n"
    "O.bodies.append(box((0.01, 0.01, 0.005), (1, 1, 0), fixed=True))\n"
)
LAYERS = CLOUD.format((0, 0, 0.008), (0.02, 0.02, 0.09), 1e-3, ", num=600")


def test_grains_that_do_not_move_are_a_part_of_the_floor():
    """Below the others, also at random heights; elsewhere they may carry a part of the weight."""
    for z in ("0.005", "0.005 + 2e-3 * random.random()"):
        said = state("import random\n" + CELL + ROUGH.format(z) + LAYERS)
        assert said.pressure == pytest.approx(weight_of(600, 1e-3, 4e-4)) and said.pressure_is_bound
    assert not state(CELL + LAYERS).pressure_is_bound
    assert state(CELL + ROUGH.format("0.03") + LAYERS).pressure == pytest.approx(0.59 * HEIGHT * 0.085)
    bare = CELL.partition("O.bodies")[0]
    assert state(bare + ROUGH.format("0.005") + LAYERS).pressure is None  # grains may fall between them


def test_a_bed_on_a_slope_presses_across_it():
    """In a periodic cell, where it is as high everywhere."""
    tilted = (9.81 * math.sin(0.2), 0, -9.81 * math.cos(0.2))
    said = held(CELL + ROUGH.format("0.005") + LAYERS, gravity=tilted)
    assert said.pressure == pytest.approx(weight_of(600, 1e-3, 4e-4, 9.81 * math.cos(0.2)))
    assert held(FILLED, gravity=tilted).pressure is None
    assert held(CELL + LAYERS, gravity=(6.0, 0, -5.9)).pressure is None


def test_the_pressure_below_a_slope_is_that_in_yade():
    """YADE 2023.02a: 500 grains of 2 mm in a periodic cell of 16 mm, on 64 that do not move at random heights, tilted
    by 0.2. They press the floor with 194.1 Pa after 150 000 steps of 0.3 PWaveTimeStep (unbalanced force 4e-4).
    """
    slope = (
        "import random\nO.periodic = True\nO.cell.setBox(0.016, 0.016, 0.12)\n"
        "O.bodies.append(box((0.008, 0.008, 0.02), (20, 20, 0), fixed=True))\n"
        "for x in range(8):\n    for y in range(8):\n        z = 0.02 + (random.random() - 0.5) * 2e-3\n"
        "        O.bodies.append(sphere((2e-3 * x, 2e-3 * y, z), 1e-3, fixed=True))\n"
    )
    cloud = CLOUD.format((0, 0, 0.022), (0.016, 0.016, 0.1), 1e-3, ", num=500, seed=1")
    said = held(slope + cloud, gravity=(9.81 * math.sin(0.2), 0, -9.81 * math.cos(0.2)))
    assert said.pressure == pytest.approx(194.1, rel=0.02) and said.pressure > 194.1


# --- what moves and presses -------------------------------------------------------------------------------------

ADDED = "what moving walls add"


@pytest.mark.parametrize(("engine", "end", "height"), [
    ("TranslationEngine(translationAxis=(1, 0, 0), velocity=0.1, ids=[0])", "", 0.09),
    ("TranslationEngine(translationAxis=(0, 0, 1), velocity=0.1, ids=[0])", "", None),
    ("TranslationEngine(translationAxis=where, velocity=0.1, ids=[0])", "", None),
    ("RotationEngine(rotationAxis=(0, 0, 1), angularVelocity=1, ids=[0])", "", 0.09),
    ("RotationEngine(rotationAxis=(1, 0, 0), angularVelocity=1, ids=[0])", "", math.hypot(0.02, 0.1)),
    ("RotationEngine(rotationAxis=(0, 1, 1), angularVelocity=1, ids=[0])", "", math.sqrt(0.02**2 * 1.5 + 0.1**2 / 2)),
    ("HarmonicMotionEngine(A=(0, 0, 1e-3), f=(0, 0, 10), ids=[0])", "", 0.09),
    ("", "O.bodies[0].state.vel = (0.1, 0, 0)", 0.09),
    ("", "O.bodies[0].state.vel = (0.1, 0, 0.1)", None),
    ("", "O.bodies[0].state.angVel = (0.1, 0, 0)", None),
    ("ServoPIDController(axis=(1, 0, 0), target=1, ids=[0])", "", None),
])  # fmt: skip
def test_walls_that_move_across_gravity_leave_a_bed_its_weight(engine, end, height):
    """Which is said to be that without what they add; in a drum no bed is higher than the circle in which it turns."""
    bodies = BOX + "O.bodies.append([wall(0, 2)] * 0)\n" + IN_AIR
    said = held(bodies, engine=f"\n    {engine}," if engine else "", end=end)
    if height is None:
        assert said.pressure is None
    else:
        assert said.pressure == pytest.approx(0.59 * HEIGHT * height) and ADDED in said.pressure_from
        assert said.stiffness_number > 0.0 and said.pressure_is_bound


def test_a_cylinder_that_turns_about_its_axis_is_as_wide_as_it_is():
    drum = "O.bodies.append(geom.facetCylinder((0, 0, 0), 0.04, 0.02))\n"
    cloud = CLOUD.format((-0.02, -0.02, -0.009), (0.02, 0.02, 0.009), 1e-3, "")
    for axis, height in {"(0, 0, 1)": 0.08, "(1, 0, 0)": math.hypot(0.08, 0.02)}.items():
        engine = f"\n    RotationEngine(rotationAxis={axis}, angularVelocity=1, ids=[0]),"
        for more in ("", "O.bodies.append(geom.facetBox((0, 0, 0), (0.01, 0.01, 0.01)))\n"):
            said = held(drum + cloud + more, gravity=(0, -9.81, 0), engine=engine)
            wide = 0.08 * math.sqrt(2) if more and axis == "(0, 0, 1)" else height
            assert said.pressure == pytest.approx(0.59 * HEIGHT * wide)


def test_the_number_of_grains_over_their_floor_is_not_used_where_walls_move():
    engine = "\n    TranslationEngine(translationAxis=(1, 0, 0), velocity=0.1, ids=[0]),"
    assert "from the floor" in held(FILLED, engine=engine).pressure_from


@pytest.mark.parametrize("engine", ["HydroForceEngine(ids=[7])", "FlowEngine()"])
def test_a_bed_in_a_fluid_has_its_weight_without_the_fluid(engine):
    said = state(FILLED, engine=f"\n    {engine},")
    assert said.pressure == state(FILLED).pressure
    assert said.pressure_from.endswith(", without the fluid")
    both = held(FILLED, engine=f"\n    {engine},\n    RotationEngine(rotationAxis=(0, 0, 1), ids=[0]),")
    assert both.pressure_from.endswith(f", without the fluid and {ADDED}")


@pytest.mark.parametrize(("body", "known"), [
    ("print(O.iter)", True),
    ("integrator.damping = 0.1", True),
    ("O.bodies.erase(3)", True),
    ("O.bodies[5].material.young = 1e6", True),
    ("O.bodies.append(sphere((0, 0, 1), 1e-3))", False),
    ("growParticles(1.1)", False),
    ("O.engines = O.engines + [ForceEngine(ids=[3])]", False),
    ("O.bodies[5].state.mass = 3", False),
    ("integrator.gravity = (0, 0, 1)", False),
    ("exec(open('more.py').read())", False),
])  # fmt: skip
def test_callbacks_that_change_no_weight_leave_the_pressure(body, known):
    said = state(FILLED, engine=CALLBACK, end=f"def later():\n    {body}\n")
    assert (said.pressure is not None) == known


HEAP = "O.bodies.append([sphere((0.003 * (k % 9), 0.003 * (k // 9), 0.7), 1e-3) for k in range(81)])\n"
#: Rings of radii 1 and 0.2, or 1 and 0, which a surface joins.
RINGS = (
    "def ring(r, z): return [Vector3(r * cos(a), r * sin(a), z) for a in linspace(0, 2 * pi, num=9, endpoint=True)]\n"
    "surface = pack.sweptPolylines2gtsSurface([ring(1, 0.6), ring({}, -0.5)], capEnd={})\n"
    "O.bodies.append(pack.gtsSurface2Facets(surface))\n"
)
SLOPE = "[(-1, -1, {0}), (1, -1, {0}), (0, 1, {1})]"


@pytest.mark.parametrize(("walls", "name"), [
    (f"O.bodies.append(facet({SLOPE.format(-0.6, 0.6)}))\n", "flow"),
    (f"O.bodies.append(facet({SLOPE.format(-0.4, 0.4)}))\n", "rest"),  # 22°: in 2023.02a a heap stays on it
    (f"O.bodies.append(facet({SLOPE.format(0, 0)}))\n", "rest"),
    ("O.bodies.append([facet([(-1, 0, 0), (1, 0, 0), (0, s, 0.6)]) for s in (-1, 1)])\n", "rest"),  # a valley
    (RINGS.format(0.2, False), "flow"),
    (RINGS.format(0.006, False), "flow"),
    (RINGS.format(0.004, False), "rest"),  # four diameters wide
    (RINGS.format(0.2, True), "rest"),
    (RINGS.format(0, False), "rest"),
    (RINGS.format(0.2, False) + FLOOR.replace("0", "-1", 1), "rest"),
    (RINGS.format(0.2, False) + "O.bodies.append(ymport.stl('floor.stl'))\n", "rest"),
    ("O.bodies.append(geom.facetBox((0, 0, 0), (1, 1, 0.6), wallMask=15))\n" + RINGS.format(0.2, False), "flow"),
])  # fmt: skip
def test_grains_pour_through_what_is_open_below(walls, name):
    """Slopes and funnels of facets whose lowest points are at their edges. A file that is not there may be a floor."""
    assert held(walls + HEAP).name == name


@pytest.mark.parametrize("text", [True, False])
def test_meshes_in_files_may_be_open_below(tmp_path, text):
    """A valley between two slopes holds grains, one of the slopes does not."""
    slopes = [[(0, -1, -1), (0, 1, -1), (s, 0, 0.5)] for s in (-1, 1)]
    for file, triangles in (("valley.stl", slopes), ("slope.stl", slopes[:1])):
        content = stl(triangles, text)
        (tmp_path / file).write_bytes(content.encode() if isinstance(content, str) else content)
    for file, name in (("valley", "rest"), ("slope", "flow")):
        path = tmp_path / "script.py"
        bodies = f"O.bodies.append(ymport.stl('{file}.stl'))\n{HEAP}"
        path.write_text(SCRIPT.format(bodies=bodies, gravity=(0, 0, -9.81), engine="", end="", angle=0.4))
        assert hl.check(path, speed=0.1).state.name == name


@pytest.mark.parametrize(("wall", "meets"), [
    ("facet([(-1, -1, 0.1), (1, -1, 0.1), (0, 1, 0.1)])", False),
    ("facet([(-1, -1, 0.0), (1, -1, 0.0), (0, 1, 0.1)])", True),
    ("facet([(1, 0, 0), (2, 0, 0), (2, 1, 0)])", False),
    ("facet([(-1, -1, 0), (1, -1, 0), (0, 1, 0)], noBound=True)", False),
    ("wall(0.1, 2)", False),
    ("wall(0, 2)", True),
    ("box((0, 0, 0.2), (1, 1, 0.1), fixed=True)", False),
    ("ymport.stl('floor.stl')", True),
])  # fmt: skip
def test_a_grain_beside_or_below_all_walls_falls_freely(wall, meets):
    bodies = f"O.bodies.append({wall})\nO.bodies.append(sphere((0, 0, 0.05), 1e-3))\n"
    text = SCRIPT.format(bodies=bodies, gravity=(0, 0, -9.81), engine="", end="", angle=0.4)
    assert hl.check(text).state.never_meet is not meets


@pytest.mark.parametrize(("moved", "name"), [
    ("for k in belt: O.bodies[k].state.vel = (0.2, 0, 0)", "flow"),
    ("for k in belt: O.bodies[k].state.vel = (0, 0, 0)", "rest"),
    ("for k in other: O.bodies[k].state.vel = (0.2, 0, 0)", "rest"),
    ("more = O.bodies.append(ymport.text('more.txt'))\nfor k in more: O.bodies[k].state.vel = (1, 0, 0)", "rest"),
    ("O.bodies[plate].state.vel = (0.2, 0, 0)", "flow"),
    ("O.bodies[plate].state.vel = (0, 0, 0.2)", "rest"),  # a piston
    ("O.bodies[plate].state.vel = (0.2, 0, 0)\nO.bodies[plate].state.vel = (0, 0, 0)", "rest"),
])  # fmt: skip
def test_a_belt_makes_grains_flow(moved, name):
    """In 2023.02a 500 grains on one of 0.2 m/s have 0.17 m/s after 0.8 s; its own place changes nothing."""
    plates = "plate = O.bodies.append(wall(-0.01, 2))\nbelt = O.bodies.append(ymport.stl('belt.stl'))\n"
    said = held(plates + CLOUD.format((0, 0, 0), (0.02, 0.02, 0.1), 1e-3, ", num=500"), end=moved)
    assert said.name == name


def test_walls_that_are_held_where_they_are_need_not_be_understood():
    for held_wall in ("O.bodies[top].dynamic = False", "O.bodies[top].state.blockedDOFs = 'xyzXYZ'"):
        bodies = f"sp = pack.SpherePack()\nsp.makeCloud((0, 0, 0), (1, 1, 1), rMean=0.1)\nsp.toSimulation()\n{FLOOR}"
        last = f"top = O.bodies.append(wall(1, 2))\n{held_wall}\n"
        text = SCRIPT.format(bodies=bodies + last, gravity=(0, 0, -9.81), engine="", end="", angle=0.4)
        assert not read(text).unknown
        assert read(text.replace("top =", "top = other =").replace("[top]", "[unknown]")).unknown


def test_grains_are_reset_to_the_facets_of_their_factory_only():
    """The bed is at most as high as these, above the floor."""
    facets = "high = O.bodies.append(geom.facetBox((0.01, 0.01, {}), (0.01, 0.01, 0), wallMask=16, noBound=True))\n"
    engine = "\n    ResetRandomPosition(virtPeriod=1, factoryFacets=high),"
    for height in (0.2, 0.4):
        said = state(BOX + IN_BOX.format("") + facets.format(height), engine=engine)
        assert said.pressure == pytest.approx(0.59 * HEIGHT * height)


def test_random_resets_put_grains_elsewhere():
    assert state(FILLED, engine="\n    ResetRandomPosition(virtPeriod=1),").pressure is None


def test_a_pedal_shakes_what_it_moves_along_gravity():
    """On circles of 1.2 m with 4/s: Γ = 1.2 · 16/9.81, and cos 45° of it across a tilted axis."""
    engine = "\n    BicyclePedalEngine(ids=[0], rotationAxis=({}), radius=1.2, angularVelocity=4),"
    for axis, share in (("0, 1, 0", 1.0), ("0, 3, 3", math.sqrt(0.5))):
        said = held(FILLED, engine=engine.format(axis))
        assert said.name == "shaken" and said.shaking == pytest.approx(1.2 * 16 / 9.81 * share)
    assert held(FILLED, engine=engine.format("0, 1, 0").replace("1.2", "size")).shaking is None


TRIAXIAL = (
    "ThreeDTriaxialEngine(sigma1=-1e4, sigma2=-2e4, sigma3=-3e4, internalCompaction=False{})",
    "PeriTriaxController(goal=(-1e5, -1e5, -1e5), stressMask=7),\n    TriaxialStressController(goal1=-3, dead=True)",
)


@pytest.mark.parametrize(("engine", "pressure"), [
    (TRIAXIAL[0].format(""), 2e4),
    (TRIAXIAL[0].format(", stressControl_2=False"), 2e4),
    (TRIAXIAL[0].format(", stressControl_1=0, stressControl_3=False"), 2e4),
    (TRIAXIAL[0].format(", stressControl_1=0"), 2.5e4),
    # It makes the spheres larger by default: in 2023.02a the mean stress is 20.00 kPa, radii grow by 1.42.
    (TRIAXIAL[0].replace("=False", "=True").format(", stressControl_1=0"), 2e4),
    (TRIAXIAL[0].replace(", internalCompaction=False", "").format(", stressControl_1=0"), 2e4),
    (TRIAXIAL[1], 1e5),
    (TRIAXIAL[1].replace("dead=True", "dead=False"), None),
])  # fmt: skip
def test_the_pressure_is_that_of_the_controller_that_is_not_dead(engine, pressure):
    said = held(FILLED, engine=f"\n    {engine},", end="revived.dead = False", gravity=(0, 0, 0))
    assert said.name == "pressed" and said.pressure == pressure


SHEARED = CELL.partition("O.bodies")[0] + CLOUD.format((0, 0, 0), (0.02, 0.02, 0.2), 1e-3, ", num=600")


def test_a_cell_that_is_sheared_far_must_be_flipped():
    """YADE 2023.02a stops at a strain of 2.3, seven diameters wide: Body larger than half of the cell size."""
    shear = "O.cell.velGrad = Matrix3(0, {}, 0, 0, 0, 0, 0, 0, 0)"

    def flips(rate, more=""):
        text = SCRIPT.format(
            bodies=SHEARED, gravity=(0, 0, 0), engine="", end=f"{shear.format(rate)}\n{more}", angle=0
        )
        return any("flipFlippable" in finding.what for finding in hl.check(text, speed=0.1).warnings)

    assert flips(2000) and not flips(500)  # in 1000 steps of 1 µs
    assert flips(500, "while True: O.run(1000, True)")
    assert not flips(2000, "O.cell.flipFlippable = True")
    assert not flips(2000, "for k in range(3):\n    O.cell.flipCell()")
