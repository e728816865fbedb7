"""Clumps in scripts of YADE: the force of a whole clump acts on single spheres."""

import math

import pytest

import hardlimit as hl

SCRIPT = """from yade import geom, pack
stone = O.materials.append(FrictMat(young=1e7, poisson=0.3, frictionAngle=0.4, density=2500, label="stone"))
{bodies}
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Facet_Aabb()]),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom(), Ig2_Facet_Sphere_ScGeom()],
        [Ip2_FrictMat_FrictMat_FrictPhys()], [Law2_ScGeom_FrictPhys_CundallStrack()]),
    NewtonIntegrator(gravity=(0, 0, -10), damping=0.4),{engine}
]
O.dt = 1e-6
{end}
O.run(1000, True)
"""
BOX = "O.bodies.append(geom.facetBox((0.02, 0.02, 0.1), (0.02, 0.02, 0.1), wallMask=31))\n"
CLOUD = (
    "sp = pack.SpherePack()\nsp.makeCloud((0.002, 0.002, 0), (0.038, 0.038, 0.1), rMean=0.002, num=300)\n"
    "sp.toSimulation()\n"
)


def union(distance):
    """Volume of two unit spheres at a distance, over that of one."""
    cap = 1 - 0.5 * distance
    return 2 - 2 * 0.25 * cap**2 * (3 - cap)


def said(bodies, engine="", end="", **options):
    """What check says of the grains of a script."""
    return hl.check(SCRIPT.format(bodies=bodies, engine=engine, end=end), **options).state


def packed(clumps, **options):
    return said(
        f"{BOX}sp = pack.SpherePack()\n"
        f"sp.makeClumpCloud((0.002, 0.002, 0), (0.038, 0.038, 0.1), [{clumps}], num=200)\nsp.toSimulation()\n",
        **options,
    )


@pytest.mark.parametrize("distance", [0.5, 1.5, 2.0])
def test_the_force_of_a_clump_acts_on_one_of_its_spheres(distance):
    """With the area of the sphere of its volume, so that κ_p is smaller than that of single spheres."""
    radius = 0.002
    pair = f"pack.SpherePack([((0, 0, 0), {radius}), (({distance * radius}, 0, 0), {radius})])"
    state, spheres = packed(pair), said(BOX + CLOUD)
    share = union(distance)
    bulk = 0.75 * 2.0 / share  # without discretization the mass is that of both spheres
    assert state.pressure == pytest.approx(bulk * 2500 * 10 * 0.1, rel=2e-3)
    assert state.pressure_is_bound
    assert "whole clumps on single spheres" in state.pressure_from
    assert ("overlaps in clumps" in state.pressure_from) == (distance < 2.0)
    own = packed(pair, pressure=1000.0)
    alone = said(BOX + CLOUD, pressure=1000.0)
    assert alone.stiffness_number / own.stiffness_number == pytest.approx(share ** (2 / 3), rel=2e-3)
    assert own.largest_stable_step is None
    assert spheres.largest_stable_step is not None


def test_a_clump_of_listed_spheres_is_one_of_their_volume():
    """``discretization`` makes its mass that of the volume; overlaps count once then."""
    spheres = "[sphere((0.02, 0.02, 0.05), 0.002, material=stone), sphere((0.021, 0.02, 0.05), 0.002, material=stone)]"
    plain = said(f"{BOX}for k in range(40):\n    O.bodies.appendClumped({spheres})\n")
    exact = said(f"{BOX}for k in range(40):\n    O.bodies.appendClumped({spheres}, discretization=20)\n")
    apart = said(f"{BOX}for k in range(40):\n    O.bodies.append({spheres})\n")
    assert plain.pressure == apart.pressure  # of the same spheres on the same floor
    ratio = union(0.5) ** (2 / 3)
    assert apart.stiffness_number / plain.stiffness_number == pytest.approx(ratio, rel=2e-3)
    assert plain.stiffness_number == exact.stiffness_number


def test_clumps_by_their_numbers():
    """``clump`` ties the bodies of these numbers; of unknown ones, all spheres at most."""
    spheres = "".join(
        f"O.bodies.append(sphere((0.01, 0.01, {0.01 + 0.005 * k}), 0.002, material=stone))\n"
        for k in range(4)
    )
    two, all_of_them, unclear = (
        said(f"{spheres}{BOX}O.bodies.clump({numbers})\n", pressure=1.0)
        for numbers in ("[0, 1]", "[0, 1, 2, 3]", "list_of_a_file")
    )
    free = said(spheres + BOX, pressure=1.0)
    for state, number in ((two, 2), (all_of_them, 4), (unclear, 4)):
        assert free.stiffness_number / state.stiffness_number == pytest.approx(number ** (2 / 3), rel=2e-3)


def test_numbers_of_bodies_after_a_clump_are_not_those_of_its_spheres():
    """The clump has a number as well."""
    spheres = "[sphere((0.01, 0.01, 0.01), 0.002), sphere((0.013, 0.01, 0.01), 0.002)]"
    text = f"O.bodies.appendClumped({spheres})\nO.bodies.append(sphere((0.02, 0.02, 0.05), 0.002))\n"
    fixed = "O.bodies[2].state.blockedDOFs = 'xyzXYZ'\n"
    assert hl.check(SCRIPT.format(bodies=text + fixed, engine="", end="")).unknown
    apart = text.replace("appendClumped", "append")
    assert not hl.check(SCRIPT.format(bodies=apart + fixed, engine="", end="")).unknown


@pytest.mark.parametrize(
    "template", ["relRadii=[1, 1], relPositions=[[1, 0, 0], [-1, 0, 0]]", "[1, 1], [[0, 1, 0], [0, 3, 0]]"]
)
def test_clumps_that_replace_spheres_have_their_volume_and_reach_farther(template):
    change = f"O.bodies.replaceByClumps([clumpTemplate({template})], [1.0])\n"
    state, spheres = said(BOX + CLOUD + change), said(BOX + CLOUD)
    assert spheres.pressure_from.startswith("below 300 grains")
    assert state.pressure == pytest.approx(
        spheres.pressure, rel=2e-3
    )  # two spheres that touch have their volume
    alone, own = (said(text, pressure=1000.0) for text in (BOX + CLOUD, BOX + CLOUD + change))
    assert alone.stiffness_number / own.stiffness_number == pytest.approx(2 ** (2 / 3), rel=2e-3)
    many = CLOUD.replace(", num=300", "")
    farther = (
        2 * 2 / 2 ** (1 / 3) - 1
    ) * 0.002  # of the ends of a clump whose centre is anywhere in the sphere
    higher = said(BOX + many + change).pressure / said(BOX + many).pressure
    assert higher == pytest.approx(0.75 * (0.1 + farther) / (0.59 * 0.1), rel=2e-3)


@pytest.mark.parametrize(
    "clumps",
    [
        "O.bodies.appendClumped(ymport.textClumps('of_a_file'))",
        "O.bodies.replaceByClumps(templates_of_a_file, [1.0])",
        "O.bodies.addToClump([0], 1)",
    ],
)
def test_clumps_of_unknown_size_have_no_pressure(clumps):
    assert said(f"{BOX}{CLOUD}{clumps}\n").pressure is None


def test_bodies_that_a_callback_appends_again_are_where_the_script_made_them():
    """Their number is not known, but how high they lie."""
    add = (
        "def add():\n    for k in range(5):\n"
        "        O.bodies.append(sphere((0.02, 0.02, 0.01 + 0.01 * k), 0.002, material=stone))\n"
    )
    runner = "\n    PyRunner(iterPeriod=1000, command='add()'),"
    state = said(f"{BOX}{add}add()\n", runner)
    assert state.pressure == pytest.approx(0.59 * 2500 * 10 * 0.052)
    assert "5.2 cm from the floor" in state.pressure_from
    assert said(f"{BOX}{add}add()\n").pressure < state.pressure  # of five spheres
    assert said(f"{BOX}{add}{CLOUD}", runner).pressure is None  # it is not known where


def test_products_of_lists_are_read():
    spheres = (
        "import itertools\nfor i, k in itertools.product(range(3), [0.01, 0.03]):\n"
        "    O.bodies.append(sphere((0.005 * i + 0.01, 0.02, k), 0.002, material=stone))\n"
    )
    state = said(BOX + spheres)
    assert "6 grains" in state.pressure_from
    assert state.pressure == said(BOX + spheres.replace("itertools.product", "product")).pressure
    assert math.isfinite(state.stiffness_number)
