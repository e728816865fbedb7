"""What is read from scripts of YADE: materials, functors, bodies, engines, the time step."""

import math

import pytest

import hardlimit as hl
from hardlimit.checking.scripts import read

LOOP = """O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Facet_Aabb(), Bo1_Wall_Aabb(), Bo1_Box_Aabb()]),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom(), Ig2_Facet_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom(), Ig2_Box_Sphere_ScGeom()],
        [{}], [{}]),
    NewtonIntegrator({}),
]
"""
MINDLIN = ("Ip2_FrictMat_FrictMat_MindlinPhys(en=0.7, es=0.7)", "Law2_ScGeom_MindlinPhys_Mindlin()")
FRICT = ("Ip2_FrictMat_FrictMat_FrictPhys()", "Law2_ScGeom_FrictPhys_CundallStrack()")
VISCEL = ("Ip2_ViscElMat_ViscElMat_ViscElPhys()", "Law2_ScGeom_ViscElPhys_Basic()")
GLASS = "O.materials.append(FrictMat(young=1e7, poisson=0.3, density=2500, label='glass'))\n"
SPHERE = "O.bodies.append(sphere((0, 0, 0), 0.01))\n"


def numbers(contact):
    """The numbers of a contact; names as they are."""
    return {
        name: setting.words[0] if name == "physics" else float(setting.words[0])
        for name, setting in contact.settings.items()
    }


LATTICES = ("regularHexa", "regularOrtho")


def script(
    pair=MINDLIN, material=GLASS, bodies=SPHERE, integrator="damping=0", rest="O.dt = 1e-6\nO.run(10)\n"
):
    return f"from yade import pack\n{material}{bodies}{LOOP.format(*pair, integrator)}{rest}"


def test_a_script():
    description = read(script(integrator="gravity=(0, 0, -9.81), damping=0.3"))
    stage = description.stages[0]
    assert (description.code, description.stages[0].units, len(description.stages)) == (
        "yade",
        "si",
        1,
    ) and not description.unknown
    assert (stage.time_step, stage.time_step_given, stage.steps) == (1e-6, True, 10)
    assert (stage.gravity, stage.numerical_damping) == (9.81, 0.3)
    assert stage.grains["glass"].radii == (0.01, 0.01) and stage.grains["glass"].densities == (2500.0, 2500.0)
    (contact,) = stage.contacts
    assert contact.types == ("glass", "glass")
    assert numbers(contact) == {"physics": "MindlinPhys", "young": 1e7, "poisson": 0.3, "en": 0.7}


def test_defaults():
    """Of the material, the integrator, the functor and the time step."""
    stage = read(script(material="", integrator="", rest="O.run()\n")).stages[0]
    assert stage.numerical_damping == 0.2 and (stage.time_step, stage.time_step_given) == (1e-8, False)
    assert stage.steps is None and stage.gravity is None
    assert numbers(stage.contacts[0]) == {"physics": "MindlinPhys", "young": 1e7, "poisson": 0.3, "en": 0.7}
    assert stage.contacts[0].types == ("defaultMat", "defaultMat")
    bare = script(
        material="O.materials.append(FrictMat())\n", pair=("Ip2_FrictMat_FrictMat_MindlinPhys()", MINDLIN[1])
    )
    stage = read(bare).stages[0]
    assert numbers(stage.contacts[0]) == {
        "physics": "MindlinPhys",
        "young": 1e9,
        "poisson": 0.25,
        "betan": 0.0,
    }
    assert stage.grains["0"].densities == (1000.0, 1000.0)


@pytest.mark.parametrize(
    "keywords,expected",
    [
        ("kn=1e5, ks=1, cn=2, cs=1", {"kn": 1e5, "cn": 2.0}),
        ("tc=1e-3, en=0.7, et=1", {"tc": 1e-3, "en": 0.7}),
        ("young=1e6, en=0.7, et=1", {"young": 1e6, "en": 0.7}),
    ],
)
def test_viscoelastic_materials(keywords, expected):
    description = read(script(VISCEL, f"O.materials.append(ViscElMat({keywords}, density=2000))\n"))
    assert numbers(description.stages[0].contacts[0]) == {"physics": "ViscElPhys", **expected}


def test_two_materials():
    """Mindlin: moduli in series; ViscElMat: springs in series and means of tc and en."""
    steel = GLASS + "steel = O.materials.append(FrictMat(young=2e11, poisson=0.25, label='steel'))\n"
    bodies = "O.bodies.append([sphere((0, 0, 0), r, material=m) for r, m in 2 * [(0.01, 'glass'), (0.02, steel)]])\n"
    contacts = read(script(material=steel, bodies=bodies)).stages[0].contacts
    assert [contact.types for contact in contacts] == [
        ("glass", "glass"),
        ("glass", "steel"),
        ("steel", "steel"),
    ]
    mixed = numbers(contacts[1])
    effective = 1.0 / ((1.0 - 0.3**2) / 1e7 + (1.0 - 0.25**2) / 2e11)
    assert 0.5 * mixed["young"] / (1.0 - mixed["poisson"] ** 2) == pytest.approx(effective, rel=1e-12)
    both = "a = O.materials.append(ViscElMat({}))\nb = O.materials.append(ViscElMat({}))\n"
    bodies = "O.bodies.append([sphere((0, 0, z), 0.01, material=m) for z in (0, 1) for m in (a, b)])\n"
    for first, second, expected in (
        ("kn=1e5, cn=1, ks=1, cs=1", "kn=3e5, cn=3, ks=1, cs=1", {"kn": 1.5e5, "cn": 1.5}),
        ("tc=1e-3, en=.5, et=1", "tc=3e-3, en=.7, et=1", {"tc": 2e-3, "en": 0.6}),
    ):
        mixed = numbers(read(script(VISCEL, both.format(first, second), bodies)).stages[0].contacts[1])
        assert mixed.pop("physics") == "ViscElPhys" and mixed == pytest.approx(expected)
    bodies = "O.bodies.append([sphere((0, 0, z), 0.01, material=k) for z in (0, 1) for k in (0, 1)])\n"
    differ = read(script(FRICT, steel, bodies))
    assert numbers(differ.stages[0].contacts[1])["young"] == pytest.approx(2e7 / (1.0 + 1e7 / 2e11))


def test_match_makers():
    pair = (
        "Ip2_FrictMat_FrictMat_MindlinPhys(en=MatchMaker(matches=((a, a, .7), (a, b, .5)), val=.3))",
        MINDLIN[1],
    )
    material = (
        "a, b = O.materials.append([FrictMat(young=1e7, poisson=.3), FrictMat(young=1e7, poisson=.3)])\n"
    )
    bodies = "for k in (a, b, a, b):\n    O.bodies.append(sphere((0, 0, k), 0.01, material=k))\n"
    contacts = read(script(pair, material, bodies)).stages[0].contacts
    assert [numbers(contact)["en"] for contact in contacts] == [0.7, 0.5, 0.3]
    assert [contact.types for contact in contacts] == [("0", "0"), ("0", "1"), ("1", "1")]
    description = read(script((pair[0].replace(", val=.3", ""), pair[1]), material, bodies))
    assert [stage.types for stage in description.stages[0].contacts] == [("0", "0"), ("0", "1")]
    assert ["MatchMaker" in quote.text for quote in description.unknown] == [True]


def test_factories():
    lines = "O.engines += [BoxFactory(rMin=0.1, rMax=0.3, materialId=0)]\nO.run(1)\n"
    description = read(script(bodies="", rest=lines))
    assert description.stages[0].grains["glass"].radii == (0.1, 0.3) and not description.unknown
    last = GLASS + "O.materials.append(FrictMat(young=1e7, poisson=0.3, label='last'))\n"
    description = read(script(material=last, bodies="", rest=lines.replace(", materialId=0", "")))
    assert list(description.stages[0].grains) == ["last"]
    assert read(script(bodies="", rest=lines.replace("materialId=0", "materialId=kind()"))).unknown


@pytest.mark.parametrize("wrong", ["sizes = [1]\nsizes += 2\n", "sizes = 1\nsizes -= None\n", "sizes /= 0\n"])
def test_errors_of_python_leave_a_value_unknown(wrong):
    wrong, right = (read(script(rest=lines + "O.run(1)\n")).stages[0] for lines in (wrong, ""))
    assert wrong.grains == right.grains and wrong.steps == right.steps == 1


CLOUD = "sp = pack.SpherePack()\nsp.makeCloud((0, 0, 0), (1, 1, 1), {})\nsp.toSimulation(material='glass')\n"
PACK = CLOUD.format("rMean=0.05, rRelFuzz=0.2").rpartition("sp.toSimulation")[0]
FUNCTION = """
def add(r, n=2):
    for i in range(n):
        O.bodies.append(sphere((i, 0, 0), r))
add(0.1)
add(r=0.3, n=1)
"""


@pytest.mark.parametrize(
    "bodies,radii",
    [
        (CLOUD.format("rMean=0.05, rRelFuzz=0.2"), (0.04, 0.06)),
        (CLOUD.format(".05, .2, 99"), (0.04, 0.06)),
        (CLOUD.format("psdSizes=[.1, .2, .4], psdCumm=[0, .5, 1]"), (0.05, 0.2)),
        (CLOUD.format("psdSizes=[.1, .2, .4], psdCumm=[0, .5, 1], num=9"), None),  # may be scaled down
        (CLOUD.format("num=100"), (0.084195, 0.094187)),  # of porosity 0.75 and 0.65
        ("sp = pack.SpherePack()\nsp.load('a.txt')\nsp.toSimulation()\n", None),
        ("O.bodies.append(pack.regularHexa(pack.inSphere((0, 0, 0), 1), radius=0.1, gap=0))\n", (0.1, 0.1)),
        ("O.bodies.append(pack.regularOrtho(pack.inAlignedBox(a, b), 0.1, gap=0))\n", (0.1, 0.1)),
        (
            "sp = pack.randomDensePack(p, .1, rRelFuzz=.5, returnSpherePack=True)\nsp.toSimulation()\n",
            (0.05, 0.15),
        ),
        ("for i in range(3):\n    O.bodies.append(sphere((0, 0, i), radius=0.1 * (i + 1)))\n", (0.1, 0.3)),
        (
            "r = 0.1\nr *= 2\nO.bodies.append([utils.sphere([i, 0, 0], r / (i + 1)) for i in range(2)])\n",
            (0.1, 0.2),
        ),
        (FUNCTION, (0.1, 0.3)),
        ("import math\nO.bodies.append(sphere((0, 0, 0), math.sqrt(4) * 10**-1))\n", (0.2, 0.2)),
        ("O.bodies.append(sphere((0, 0, 0), random.uniform(.1, .2)))\n", (0.1, 0.2)),
        (PACK + "O.bodies.append([sphere(c, r) for c, r in sp])\n", (0.04, 0.06)),
        (PACK + "for s in sp: O.bodies.append(sphere(s[0], 2 * s[1]))\n", (0.08, 0.12)),
        (PACK + "O.bodies.append([sphere(c, radius=r) for c, r in sp.toList()])\n", (0.04, 0.06)),
        ("pack.SpherePack([((0, 0, k), 0.1 * k) for k in (1, 2)]).toSimulation()\n", (0.1, 0.2)),
        (PACK + "sp.scale(3)\nsp.toSimulation()\n", (0.12, 0.18)),
        (
            "balls = []\nfor k in 1, 2: balls += [sphere((0, 0, k), 0.1 * k)]\nO.bodies.append(balls)\n",
            (0.1, 0.2),
        ),
        ("O.bodies.append(ymport.text('a.txt'))\n", None),
    ],
)
def test_sizes(bodies, radii):
    description = read(script(bodies=bodies)).stages[0].grains["glass"].radii
    assert description == (None if radii is None else pytest.approx(radii, rel=1e-5))


def test_walls_and_frozen_spheres():
    material = GLASS + "O.materials.append(FrictMat(young=1e9, poisson=0.3, label='wall'))\n"
    bodies = """
O.bodies.append(sphere((0, 0, 0), 0.01, material='glass'))
O.bodies.append(geom.facetBox((0, 0, 0), (1, 1, 1), material='wall'))
O.bodies.append(wall(0, axis=2, material='glass'))
O.bodies.append(aabbWalls(material='glass'))
O.bodies.append(ymport.stl('a.stl', material='wall'))
"""
    contacts = [
        stage for stage in read(script(material=material, bodies=bodies)).stages[0].contacts if stage.wall
    ]
    assert [contact.wall for contact in contacts] == ["facets of wall", "walls of glass", "boxes of glass"]
    assert {contact.types for contact in contacts} == {("glass", "wall")}
    for word, frozen in (("fixed=True", True), ("dynamic=False", True), ("dynamic=True", False)):
        bodies = (
            f"O.bodies.append([sphere((0, 0, 0), 0.01, {word}), sphere((0, 0, 1), 0.01, material='wall')])\n"
        )
        description = read(
            script(material=material, bodies=bodies.replace(f"{word})", f"{word}, material='glass')"))
        )
        assert description.stages[0].grains["glass"].frozen is frozen
    both = "O.bodies.append([sphere((0, 0, 0), 1, fixed=True), sphere((0, 0, 3), 1)])\n"
    assert not read(script(bodies=both)).stages[0].grains["glass"].frozen


def test_fixed_bodies_whose_mass_is_in_the_formulas():
    """ViscElMat: boxes and fixed spheres, but neither walls nor facets. A box that is not fixed moves."""
    material = "O.materials.append(ViscElMat({}, density=2000))\n"
    for numbers, mass in (("tc=1e-3, en=0.7, et=1", 2000 * 0.048), ("kn=1, ks=1, cn=0, cs=0", None)):
        for body, counted in (
            ("box((0, 0, 0), (0.1, 0.2, 0.3), fixed=True)", mass),
            ("facet([(0, 0, 0), (1, 0, 0), (0, 1, 0)])", None),
        ):
            bodies = (
                f"O.bodies.append([sphere((0, 0, 0), 0.01), sphere((0, 0, 1), 0.02, fixed=True), {body}])\n"
            )
            description = read(script(VISCEL, material.format(numbers), bodies))
            (wall,) = (stage for stage in description.stages[0].contacts if stage.wall)
            assert wall.wall_mass == (None if counted is None else pytest.approx(counted))
            assert wall.wall_radius == (4 / 3 if wall.wall == "facets" else 1.0)
            assert description.stages[0].grains["0"].counted and not description.unknown
    bodies = f"{SPHERE}O.bodies.append(aabbWalls())\n"
    description = read(script(VISCEL, material.format("tc=1e-3, en=0.7, et=1"), bodies))
    assert [quote.text for quote in description.unknown] == ["aabbWalls()"]
    description = read(script(bodies=f"{SPHERE}O.bodies.append(box((0, 0, 0), (1, 1, 1)))\n"))
    assert [quote.text for quote in description.unknown] == ["box((0, 0, 0), (1, 1, 1))"]
    later = f"{SPHERE}k = O.bodies.append(box((0, 0, 0), (1, 1, 1)))\nO.bodies[k].dynamic = False\n"
    assert not read(script(bodies=later)).unknown
    assert (
        not read(script(bodies=f"{SPHERE}O.bodies.append(sphere((0, 0, 0), 1, fixed=True))\n"))
        .stages[0]
        .grains["glass"]
        .counted
    )


@pytest.mark.parametrize(
    "functor,wall,modulus,larger",
    [
        ("", "facet([(0, 0, 0), (1, 0, 0), (0, 1, 0)])", 3e7 / (1.0 + 2.0 * 100), 4 / 3),
        ("", "wall(0, axis=2)", 2e7 / (1.0 + 100), 1.0),
        ("hertzian=True", "facet([(0, 0, 0), (1, 0, 0), (0, 1, 0)])", 1e7, 2.0),
        ("hertzian=True", "wall(0, axis=2)", 1e7, 2.0),
    ],
)
def test_walls_of_another_modulus(functor, wall, modulus, larger):
    """CundallStrack's stiffness depends on the modulus and the size of each body: 2 R, with hertzian 1e8 R."""
    material = GLASS + "O.materials.append(FrictMat(young=1e9, poisson=0.3, density=1))\n"
    text = script(FRICT, material, f"O.bodies.append([sphere((0, 0, 0), 1, material=0), {wall}])\n")
    for name in "Facet", "Wall":
        text = text.replace(f"{name}_Sphere_ScGeom()", f"{name}_Sphere_ScGeom({functor})")
    description = read(text)
    (contact,) = (stage for stage in description.stages[0].contacts if stage.wall)
    expected = modulus if functor else modulus * 100
    assert numbers(contact)["young"] == pytest.approx(expected) and contact.wall_radius == pytest.approx(
        larger
    )
    assert not description.unknown


def test_the_time_step_of_waves():
    step = 0.5 * 0.01 * math.sqrt(2500 / 1e7)
    assert read(script(rest="O.dt = 0.5 * PWaveTimeStep()\n")).stages[0].time_step == pytest.approx(step)
    rayleigh = math.pi * 0.01 / (0.1631 * 0.3 + 0.876605) * math.sqrt(2500 / (1e7 / 2.6))
    assert read(script(rest="O.dt = utils.RayleighWaveTimeStep()\n")).stages[0].time_step == pytest.approx(
        rayleigh
    )
    unknown = read(script(bodies="O.bodies.append(ymport.text('a.txt'))\n", rest="O.dt = PWaveTimeStep()\n"))
    assert unknown.stages[0].time_step is None and any("PWave" in quote.text for quote in unknown.unknown)
    adapts = script(rest="O.engines = O.engines + [GlobalStiffnessTimeStepper()]\nO.run(1)\n")
    assert read(adapts).stages[0].time_step is None
    assert read(adapts.replace("Stepper()", "Stepper(active=False)")).stages[0].time_step == 1e-8


def test_engines_of_motion_are_named():
    lines = "O.engines += [CombinedKinematicEngine() + TranslationEngine() + RotationEngine()]\nO.run(1)\n"
    said = " ".join(note.what for note in read(script(rest=lines)).ignored)
    assert "CombinedKinematicEngine" in said and "TranslationEngine" in said
    facets = script().replace("Ig2_Facet_Sphere_ScGeom()", "Ig2_Facet_Sphere_ScGeom(hertzian=whether())")
    facets = facets.replace(SPHERE, SPHERE + "O.bodies.append(facet([(0, 0, 0), (1, 0, 0), (0, 1, 0)]))\n")
    assert "hertzian" in read(facets).unknown[0].text


def test_engines_that_are_dead_do_nothing_unless_they_are_revived():
    lines = "O.engines += [PeriTriaxController(dead=True, label='triax')]\nO.run(1)\n{}O.run(1)\n"
    pressed = [len(stage.pressed) for stage in read(script(rest=lines.format(""))).stages]
    assert pressed == [0]
    for revived in ("triax.dead = False\n", "def f():\n    triax.dead = 0\n"):
        assert read(script(rest=lines.format(revived))).stages[-1].pressed
    dead = "O.engines += [PeriTriaxController(label='triax')]\nO.run(1)\ntriax.dead = True\nO.run(1)\n"
    assert [len(stage.pressed) for stage in read(script(rest=dead)).stages] == [1, 0]


def test_additional_torques_displacements_and_scaled_masses_are_said():
    for call in (
        "addT(0, (0, 0, 1))",
        "setPermT(0, (0, 0, 1))",
        "addMove(0, (0, 0, 1))",
        "addRot(0, (0, 0, 1))",
    ):
        (note,) = read(script(rest=f"O.forces.{call}\nO.run(1)\n")).invalidates
        assert call.partition("(")[0] in note.what
    (quote,) = read(script(integrator="damping=0, densityScaling=True")).unknown
    assert "densityScaling" in quote.text
    (quote,) = read(script(rest="O.bodies[0].state.densityScaling = 2\nO.run(1)\n")).unknown
    assert "densityScaling" in quote.text


def test_stages_and_labels():
    """Labels of engines are names; a change at the integrator is a new stage."""
    text = script(
        integrator="damping=0.4, label='newton'",
        rest="O.dt = 1e-6\nO.run(5, True)\nO.run(5)\nnewton.damping = 0.1\nO.run(3)\n",
    )
    description = read(text).stages
    assert [(stage.numerical_damping, stage.steps) for stage in description] == [(0.4, 10), (0.1, 3)]


def test_callbacks_that_change_settings_are_quoted():
    for body, quoted in (
        ("print(O.iter)", False),
        ("newton.damping = 0.9", True),
        ("O.bodies.append(sphere((0,0,0), 1))", True),
    ):
        text = (
            f"def check():\n    {body}\n{script()}O.engines += [PyRunner(command='check()', iterPeriod=10)]\n"
        )
        assert any("PyRunner" in quote.text for quote in read(text + "O.run(1)\n").unknown) is quoted


@pytest.mark.parametrize(
    "pair,material,rest,what",
    [
        (
            (
                "Ip2_CohFrictMat_CohFrictMat_CohFrictPhys(setCohesionOnNewContacts=True)",
                "Law2_ScGeom6D_CohFrictPhys_CohesionMoment()",
            ),
            "O.materials.append(CohFrictMat(young=1e7, normalCohesion=1e6))\n",
            "",
            "adhesion",
        ),
        ((MINDLIN[0], "Law2_ScGeom_MindlinPhys_Mindlin(includeAdhesion=True)"), GLASS, "", "adhesion"),
        (
            MINDLIN,
            GLASS,
            "O.bodies.appendClumped([sphere((0, 0, 0), 1), sphere((0, 0, 1), 1)])\nO.run(1)\n",
            "clumps",
        ),
        (MINDLIN, GLASS, "O.engines += [LinearDragEngine(nu=0.1)]\nO.run(1)\n", "drag"),
        (VISCEL, "O.materials.append(ViscElMat(tc=1, en=1, et=1, lubrication=True))\n", "", "fluid"),
        (MINDLIN, GLASS, "O.forces.setPermF(0, (0, 0, 1))\nO.run(1)\n", "force"),
    ],
)
def test_what_makes_hard_spheres_wrong(pair, material, rest, what):
    assert any(what in finding.what for finding in read(script(pair, material, rest=rest)).invalidates)


def test_variables_replace_names_and_parameters():
    text = "en = 0.5\n" + script(("Ip2_FrictMat_FrictMat_MindlinPhys(en=en, es=en)", MINDLIN[1]))
    assert numbers(read(text).stages[0].contacts[0])["en"] == 0.5
    assert numbers(read(text, variables={"en": "0.9"}).stages[0].contacts[0])["en"] == 0.9
    table = "readParamsFromTable(noTableOk=True, en=0.6)\nfrom yade.params.table import *\n"
    assert numbers(read(table + text.partition("\n")[2]).stages[0].contacts[0])["en"] == 0.6


@pytest.mark.parametrize(
    "text,must",
    [
        (
            script(material="O.materials.append(FrictMat(young=E, poisson=.3))\n"),
            "have a known number for young, not E",
        ),
        (
            script(("Ip2_FrictMat_FrictMat_MindlinPhys(en=random())", MINDLIN[1])),
            "have a known number for en",
        ),
        (script(integrator="damping=d"), "have a number in .0, 1. for damping"),
        (
            script(bodies="O.bodies.append(sphere((0, 0, 0), 1, material='stone'))\n"),
            "have a material of the script",
        ),
        (script() + "def broken(:\n", "be Python"),
        ("O.engines = []\n", "has no granular contacts"),
    ],
)
def test_what_cannot_be_read_is_refused(text, must):
    with pytest.raises(ValueError, match=must) as caught:
        read(text)
    assert "\n" not in str(caught.value)


def test_python_2():
    assert read(script() + "print 'done', O.iter\nif 1: print O.dt\n").stages[0].contacts


def test_nothing_is_executed(tmp_path):
    """Neither files nor functions of Python are used."""
    target = tmp_path / "made"
    text = (
        script()
        + f"import os\nos.system('touch {target}')\nopen({str(target)!r}, 'w').write('x')\n__import__('os')\n"
    )
    assert read(text).stages and not target.exists()


def test_lists_of_materials_in_loops():
    """Materials loops in a loop with ``enumerate``, spheres in comprehensions with ``zip`` and several loops."""
    loops = (
        "mats = []\n"
        "for k, (E, e) in enumerate([(1e7, 0.8), (2e7, 0.5)]):\n"
        "    mats.append(O.materials.append(FrictMat(young=E, poisson=0.2, density=2500, label=f'm{k}')))\n"
    )
    bodies = (
        "O.bodies.append([sphere((0, 0, z), r, material=mats[0]) for z, r in zip((0, 1), (1e-3, 2e-3))])\n"
        "O.bodies.append([sphere((x, y, 0), 3e-3, material=mats[1]) for x in range(3) for y in range(4) if x != y])\n"
    )
    stage = read(script(material=loops, bodies=bodies)).stages[0]
    assert stage.grains["m0"].radii == (1e-3, 2e-3) and stage.grains["m1"].radii == (3e-3, 3e-3)


@pytest.mark.parametrize("numbers_of", ["dict(young=2e7, poisson=0.2)", "{'young': 2e7, 'poisson': 0.2}"])
def test_keywords_in_a_dictionary(numbers_of):
    text = script(material=f"given = {numbers_of}\nO.materials.append(FrictMat(density=2500, **given))\n")
    assert numbers(read(text).stages[0].contacts[0])["young"] == 2e7


def test_keywords_that_are_not_known_are_no_defaults():
    with pytest.raises(ValueError, match="known number for young"):
        read(script(material="O.materials.append(FrictMat(density=2500, **given))\n"))


@pytest.mark.parametrize("law", ["HertzWithLinearShear", "MindlinDeresiewitz"])
def test_laws_without_damping(law):
    description = read(script(pair=(MINDLIN[0], f"Law2_ScGeom_MindlinPhys_{law}()")))
    (contact,) = description.stages[0].contacts
    assert numbers(contact)["betan"] == 0.0 and contact.asked == 0.7 and not description.unknown


@pytest.mark.parametrize(
    ("words", "radii"),
    [
        # smallest and largest radius that YADE 2023.02a made with seed=3
        ("-1, 0.3333, 400, False, 0.95, seed=3", (0.028903, 0.057551)),
        (
            "rRelFuzz=0.3, num=500, porosity=0.8",
            (0.05403 * (0.2 / 0.35) ** (1 / 3), 0.10035 * (0.2 / 0.35) ** (1 / 3)),
        ),
        ("rRelFuzz=0.3, num=500", (0.0483, 0.10035)),  # smaller if they find no place: 0.05403 to 0.10035
        ("-1, 0.3333, later(), False, 0.95", None),
    ],
)
def test_a_cloud_of_a_number_of_spheres_with_a_porosity(words, radii):
    bodies = f"sp = SpherePack()\nsp.makeCloud((0, 0, 0), (1, 2, 1.5), {words})\nsp.toSimulation()\n"
    (grains,) = read(script(bodies=bodies)).stages[0].grains.values()
    assert grains.radii == (radii if radii is None else pytest.approx(radii, rel=5e-3))


@pytest.mark.parametrize(
    ("radius", "radii"),
    [
        ("random.uniform(0.02, 0.05)", (0.02, 0.05)),
        ("random.gauss(0.02, 0.01)", None),
        ("random.uniform(0, 1)", None),
    ],
)
def test_a_radius_drawn_at_random(radius, radii):
    bodies = f"O.bodies.append([sphere((0, 0, k), {radius}) for k in range(5)])\n"
    (grains,) = read(script(bodies=bodies)).stages[0].grains.values()
    assert grains.radii == radii


def test_a_long_loop_of_single_steps():
    rest = "O.dt = 1e-6\nfor k in range(15000):\n    O.step()\n    print(O.bodies[0].state.vel[2], k)\n"
    assert read(script(rest=rest)).stages[0].time_step == 1e-6


def test_numbers_of_a_class():
    """A class that only holds parameters; its names are not those of the script."""
    grain = "class Grain:\n    radius = 2e-3\n    en: float = 0.6\n    def radius_of(self): return 1\n"
    bodies = f"{grain}O.bodies.append(sphere((0, 0, 0), Grain.radius))\n"
    functor = "Ip2_FrictMat_FrictMat_MindlinPhys(en=Grain.en)"
    stage = read(script(bodies=bodies, pair=(functor, MINDLIN[1]))).stages[0]
    assert stage.grains["glass"].radii == (2e-3, 2e-3) and numbers(stage.contacts[0])["en"] == 0.6
    with pytest.raises(ValueError, match="known number for en"):
        read(script(bodies=bodies, pair=(functor.replace("Grain.en", "en"), MINDLIN[1])))


@pytest.mark.slow
@pytest.mark.parametrize(
    "bodies",
    [
        "O.bodies.append([sphere((i, j, k), 2e-3) for i in range(90) for j in range(90) for k in range(90)])\n",
        "for i in range(90):\n for j in range(90):\n  for k in range(90): O.bodies.append(sphere((i, j, k), 2e-3))\n",
        SPHERE.replace("0.01", "2e-3")
        + "while True:\n  for i in range(20000):\n    for j in range(20000): pass\n",
    ],
)
def test_a_large_lattice(bodies):
    assert read(script(bodies=bodies)).stages[0].grains["glass"].radii == (2e-3, 2e-3)


@pytest.mark.parametrize(
    "before,name",
    [
        ("o = Omega()", "o"),
        ("O2 = O", "O2"),
        ("import yade\no = yade.Omega()", "o"),
        ("from yade.wrapper import Omega as Scene\no = Scene()", "o"),
        ("import yade as y", "y.O"),
        ("from yade import *", "O"),
        ("", "Omega()"),
    ],
)
def test_the_scene_under_other_names(before, name):
    """Time step, bodies, materials, engines and runs."""
    text = f"{before}\n{script(rest='O.dt = 2e-5; O.run(7)')}".replace("O.", f"{name}.")
    stage = read(text).stages[0]
    assert (stage.time_step, stage.time_step_given, stage.steps) == (2e-5, True, 7)
    assert stage.grains["glass"].radii == (0.01, 0.01) and numbers(stage.contacts[0])["en"] == 0.7


@pytest.mark.parametrize(
    "rest,step",
    [
        ("setattr(O, 'dt', 2e-5)", 2e-5),
        ("step = PWaveTimeStep\nO.dt = 2 * step()", 2 * 0.01 * math.sqrt(2500 / 1e7)),
        ("O.dt = SpherePWaveTimeStep(0.01, 2500, 1e7)", 0.01 * math.sqrt(2500 / 1e7)),
        ("import sys\nO.dt = float(sys.argv[1]) if len(sys.argv) > 1 else 3e-6", 3e-6),
        ("import sys\ntry:\n    dt = float(sys.argv[1])\nexcept IndexError:\n    dt = 3e-6\nO.dt = dt", 3e-6),
        ("p = ArgumentParser()\np.add_argument('--dt', default=4e-6)\nO.dt = p.parse_args().dt", 4e-6),
        ("class Run:\n    def __init__(self, dt): O.dt = dt\nRun(5e-6)", 5e-6),
        ("def main():\n    O.dt = 6e-6\nif __name__ == '__main__':\n    main()", 6e-6),
        ("if 'VTK' in features:\n    O.dt = 7e-6", 7e-6),
        ("O.dt = 1e-6\nO.dt *= 8", 8e-6),
        ("O.dt = 9e-6\nif quick(): O.dt = 9e-6", 9e-6),
        ("O.dt = 1e-6 if quick() else 2e-6", None),
        ("if quick(): O.dt = 1e-6\nelse: O.dt = 2e-6", None),
    ],
)  # fmt: skip
def test_where_a_time_step_comes_from(rest, step):
    description = read(script(rest=rest + "\nO.run(1)\n"))
    assert description.stages[0].time_step == (None if step is None else pytest.approx(step))
    assert bool(description.unknown) is (step is None)


@pytest.mark.parametrize(
    "line",
    [
        "exec(open('more.py').read())",
        "from parameters import *",
        "from ours import make\nmake()",
        "prepare(O)",
        "O.switchScene()",
        "O.bodies.append(blocks())",
        "growParticles(2)",
        "if quick(): O.engines = []",
        "if quick(): O.materials[0].young = 1e6",
        "O.bodies[0].state.mass = 3",
        "if quick(): O.reset()",
        "if quick(): O.bodies.clear()",
        "match quick():\n    case 1: O.dt = 3",
        "O.materials[0].yuong = 1e6",
        "O.engines[-1].damp = 0.3",
        "class Setup:\n    def later(self): O.dt = 1e-3",
        "try:\n    O.bodies.append(sphere((0, 0, 2), 0.01))\nexcept: O.dt = 3",
        "def later(): newton.damping = 0.5\nstart(later)",
    ],
)
def test_what_may_change_the_scene_is_quoted(line):
    assert read(script(bodies=CLOUD.format(".05"), rest=f"{line}\nO.run(1)\n")).unknown


def test_engines_by_default():
    """YADE's own, with their labels, if a script sets none; their time step adapts."""
    text = f"{GLASS}{SPHERE}{SPHERE}newton.damping = 0.4\nnewton.gravity = (0, 0, -2)\nO.run(1)\n"
    stage = read(text).stages[0]
    assert (stage.time_step, stage.numerical_damping, stage.gravity) == (None, 0.4, 2.0)
    assert numbers(stage.contacts[0]) == {"physics": "FrictPhys", "young": 1e7}
    assert read(text.replace("O.run", "O.dynDt = False\nO.dt = 1e-6\nO.run")).stages[0].time_step == 1e-6
    for body, touched in (("facet([(0, 0, 0), (1, 0, 0), (0, 1, 0)])", True), ("wall(0, axis=2)", False)):
        contacts = (
            read(f"{text.rpartition('O.run')[0]}O.bodies.append({body})\nO.run(1)\n").stages[0].contacts
        )
        assert any(contact.wall for contact in contacts) is touched


@pytest.mark.parametrize(
    "rest,damping",
    [
        ("O.engines.append(NewtonIntegrator(damping=0.5))", 0.0),  # YADE copies the list
        ("O.engines = O.engines[:-1] + [NewtonIntegrator(damping=0.5)]", 0.5),
        ("O.engines[-1].damping = 0.5", 0.5),
        ("utils.typedEngine('NewtonIntegrator').damping = 0.5", 0.5),
    ],
)
def test_parts_of_the_engines(rest, damping):
    description = read(script(rest=f"{rest}\nO.run(1)\n"))
    assert description.stages[0].numerical_damping == damping and not description.unknown
    assert any("copy" in note.what for note in description.ignored) is (".append" in rest)


def test_fixed_spheres_of_another_size():
    """Bodies that are fixed later as well. A sphere that moves alone touches none like itself."""
    spheres = "".join(f"O.bodies.append(sphere((0, 0, {k}), {r}))\n" for k, r in enumerate((0.06, 0.02)))
    for fixed in ("O.bodies[0].dynamic = False", "O.bodies[0].state.blockedDOFs = 'xyzXYZ'", ""):
        bodies = f"{spheres}{fixed}\n" if fixed else spheres.replace("0.06)", "0.06, fixed=True)")
        grains = read(script(bodies=bodies)).stages[0].grains["glass"]
        assert grains.radii == (0.02, 0.02) and grains.fixed.radii == (0.06, 0.06)
        assert grains.partly_frozen and grains.alone and not grains.frozen
        assert [
            (row.wall, row.radius, row.other_radius) for row in hl.check(script(bodies=bodies), speed=1).rows
        ] == [("fixed", 0.02, 0.06)]
    both = script(bodies=spheres.replace("0.06)", "0.06, fixed=True)") + spheres.splitlines()[1] + "\n")
    assert {(row.wall, row.other_radius) for row in hl.check(both, speed=1).rows} == {
        ("fixed", 0.06),
        (None, 0.02),
    }


@pytest.mark.parametrize("missing", ["Bo1_Facet_Aabb()", "Ig2_Facet_Sphere_ScGeom()"])
def test_walls_that_touch_nothing(missing):
    bodies = SPHERE + SPHERE + "O.bodies.append(facet([(0, 0, 0), (1, 0, 0), (0, 1, 0)]))\n"
    assert any(stage.wall for stage in read(script(bodies=bodies)).stages[0].contacts)
    description = read(script(bodies=bodies).replace(missing, "None"))
    assert not any(stage.wall for stage in description.stages[0].contacts)
    assert any("facets without contacts" in note.what for note in description.ignored)


COHESIVE = (
    "O.materials.append([CohFrictMat(young=1e8, {}, label='a'), CohFrictMat(young=1e8, {}, label='b')])\n"
)
BOND = "normalCohesion=1e6, shearCohesion=1e6"


@pytest.mark.parametrize(
    "functor,first,second,sticky",
    [  # as seen in YADE 2023.02a
        ("", BOND, BOND, False),
        ("setCohesionOnNewContacts=True", BOND, BOND, True),
        ("setCohesionNow=True", BOND, BOND, True),
        ("setCohesionNow=True", BOND, BOND + ", isCohesive=False", False),
        ("setCohesionOnNewContacts=True", "poisson=0.3", BOND, False),
        ("setCohesionOnNewContacts=True", "normalCohesion=0, shearCohesion=1e6", BOND, False),
        ("setCohesionOnNewContacts=True", "normalCohesion=0, fragile=False", BOND, False),
        ("setCohesionOnNewContacts=True, normalCohesion=MatchMaker(algo='val', val=0)", BOND, BOND, False),
        ("setCohesionOnNewContacts=True", "normalCohesion=strength()", BOND, True),
    ],
)
def test_cohesion(functor, first, second, sticky):
    """Without cohesion, CohFrictPhys has the normal force of FrictPhys."""
    pair = (
        f"Ip2_CohFrictMat_CohFrictMat_CohFrictPhys({functor})",
        "Law2_ScGeom6D_CohFrictPhys_CohesionMoment()",
    )
    bodies = "O.bodies.append([sphere((0, 0, k), 0.01, material=m) for k, m in enumerate('ab')])\n"
    description = read(script(pair, COHESIVE.format(first, second), bodies))
    assert [finding.types for finding in description.invalidates if "adhesion" in finding.what] == [
        ("a", "b")
    ] * sticky
    assert [numbers(stage) for stage in description.stages[0].contacts] == [
        {"physics": "FrictPhys", "young": 1e8}
    ] * (not sticky)


def test_models_that_are_no_springs():
    fluid = "O.materials.append(ViscElMat(tc=1e-3, en=0.7, et=1, SPHmode=True, mu=1e-3))\n"
    description = read(script(VISCEL, fluid, SPHERE + SPHERE))
    assert not description.stages[0].contacts and "particle hydrodynamics" in description.invalidates[0].what


@pytest.mark.parametrize(
    "keywords,functor,expected",
    [  # as seen in YADE 2023.02a
        ("tc=1e-3, en=0.7", "", {"young": 1e9, "en": 0.7}),
        ("kn=1e4, cn=0.6, ks=1, cs=0, tc=1e-3, en=0.7", "", {"kn": 1e4, "cn": 0.6}),
        ("tc=1e-3, en=0.7, et=1, kn=1e4, cn=0.6, ks=1, cs=0", "", {"tc": 1e-3, "en": 0.7}),
        ("young=1e6, en=0.6", "", {"young": 1e6, "en": 0.6}),
        ("young=1e6, cn=0.5, cs=0, en=0.6", "", {"young": 1e6, "cn": 0.5}),
        ("young=1e6", "tc=1e-3, en=0.7, et=1", {"tc": 1e-3, "en": 0.7}),
        ("tc=1e-3, en=0.7, et=1", "en=0.5", {"tc": 1e-3, "en": 0.5}),
        ("kn=1e4, cn=0.6", "", None),
        ("young=1e6", "en=0.5, et=0.5", None),
        ("young=1e6", "", None),
    ],
)
def test_which_numbers_of_viscoelastic_materials_count(keywords, functor, expected):
    pair = (f"Ip2_ViscElMat_ViscElMat_ViscElPhys({functor})", VISCEL[1])
    description = read(script(pair, f"O.materials.append(ViscElMat({keywords}))\n", SPHERE + SPHERE))
    contacts = [numbers(stage) for stage in description.stages[0].contacts]
    assert contacts == ([] if expected is None else [{"physics": "ViscElPhys", **expected}])
    assert bool(description.unknown) is (expected is None)


def test_a_reset_begins_another_system():
    rest = "O.run(10)\nO.reset()\n" + script(rest="O.dt = 2e-6\nO.run(20)\n")
    assert [stage.system for stage in read(script(rest=rest)).stages] == [0, 1]


@pytest.mark.parametrize(("rest", "steps"), [
    ("O.saveTmp()\nO.dt = 1e-4\nO.run(10)\nO.loadTmp()\nO.run(20)\n", (1e-4, 1e-8)),
    ("O.dt = 2e-4\nO.save('a.xml')\nO.run(10)\nO.reset()\nO.load('a.xml')\nO.dt *= 2\nO.run(20)\n", (2e-4, 4e-4)),
])  # fmt: skip
def test_a_scene_is_loaded_as_it_was_saved(rest, steps):
    """With its time step, as in 2023.02a, and its spheres."""
    stages = read(script(rest=rest)).stages
    assert tuple(stage.time_step for stage in stages) == steps
    assert [stage.contents.count for stage in stages] == [1, 1]


@pytest.mark.parametrize(("name", "what"), [
    ("Ip2_FrictMatCDM_FrictMatCDM_MindlinPhysCDM", "contacts that yield"),
    ("Ip2_FrictMat_FrictMat_LubricationPhys", "a fluid between grains"),
    ("Ip2_BubbleMat_BubbleMat_BubblePhys", "contacts of bubbles"),
    ("Ip2_CpmMat_CpmMat_CpmPhys", "adhesion or bonds"),
])  # fmt: skip
def test_other_forces_are_named(name, what):
    findings = read(script((f"{name}()", MINDLIN[1]))).invalidates
    assert [finding.what.startswith(what) for finding in findings] == [True]


def test_lubricated_contacts_have_no_restitution_of_their_own():
    """That of 2023.02a depends on the speed: 0.865 where en = 0.9 without the fluid gives 0.907."""
    material = "O.materials.append(ViscElMat(young=1e5, poisson=0.5, en=0.9, et=1, density=2500{}))\n"
    for words, contacts in (("", 1), (", lubrication=True, viscoDyn=0.02, roughnessScale=1e-4", 0)):
        text = script(VISCEL, material.format(words), SPHERE + SPHERE)
        assert len(read(text).stages[0].contacts) == contacts
    assert "a fluid between grains" in hl.check(text).sentence


@pytest.mark.parametrize(("radius", "gap", "numbers"), [
    (0.05, 0, (537, 360, 5065, 3544, 882, 648)),
    (0.07, 0.02, (113, 78, 1164, 820, 176, 192)),
    (0.2, 0.1, (1, 0, 25, 17, 3, 4)),
    (0.03, 0.001, (2716, 1914, 23824, 16852, 4724, 3696)),
])  # fmt: skip
def test_the_spheres_of_a_lattice_are_counted(radius, gap, numbers):
    """As by 2023.02a."""
    spaces = (
        "inSphere((0, 0, 0), 0.5)",
        "inSphere((0.1, 0.2, 0.3), 1)",
        "inAlignedBox((0, 0, 0), (1, 1.3, 0.7))",
    )
    lattices = [f"{name}(pack.{space}, radius={radius}, gap={gap})" for space in spaces for name in LATTICES]
    for lattice, number in zip(lattices, numbers, strict=True):
        text = script(bodies=f"{SPHERE}O.bodies.append(pack.{lattice})\n")
        assert read(text).stages[0].contents.count == 1 + number
    repeated = script(bodies=f"{SPHERE}while more(): O.bodies.append(pack.{lattices[2]})\n")
    assert read(repeated).stages[0].contents.count is None


def test_the_speeds_of_factories_are_those_of_impacts():
    factory = "BoxFactory(maxParticles=9, rMin=1e-3, rMax=2e-3, vMin={0}, vMax={0}, materialId=0)"
    for speed in (100, 0.5):
        rest = f"O.engines += [{factory.format(speed)}]\nO.dt = 1e-6\nO.run(10)\n"
        said = [number for number in hl.check(script(rest=rest)).inferred if number.what == "speed"]
        assert [(number.value, "factory" in number.source) for number in said] == [(speed, True)]


@pytest.mark.parametrize("place", ["", "\n    label='glass', ", "label='glass', "])
def test_a_corrected_line_says_for_which_restitution_it_is(place):
    """The next check reads it, also behind the last line of a call."""
    material = f"O.materials.append(ViscElMat({place}density=2500, tc=1e-3, en=0.7, et=0.5))"
    text = script(VISCEL, f"{material}\n", SPHERE + SPHERE)
    (line,) = [line for line in hl.check(text, speed=0.1).corrected if "ViscElMat" in line]
    call, _, comment = line.partition("  # ")
    assert comment == "for a restitution of 0.7" and "en=0.679" in call
    verdict = hl.check(text.replace(material, f"O.materials.append({call})  # {comment}"), speed=0.1)
    assert not verdict.corrected
    assert [(row.restitution_asked, round(row.restitution, 4)) for row in verdict.rows] == [(0.7, 0.7)]


# --- friction -------------------------------------------------------------------------------------------------------

TWO = "a, b = O.materials.append([{}, {}])\nO.bodies.append([sphere((0, 0, k), 0.01, material=k) for k in (a, b)])\n"
FRICT_MAT = "FrictMat(young={}, poisson={}, frictionAngle={})"


def friction(pair, material, bodies=SPHERE + SPHERE, **more):
    """Coefficient and tangential force of the last contact, and the description."""
    description = read(script(pair, material, bodies, **more))
    contact = description.stages[-1].contacts[-1]
    return contact.friction, contact.tangential, description


def between_two(pair, first, second):
    """The same between two materials."""
    description = read(script(pair, TWO.format(first, second), ""))
    contact = next(each for each in description.stages[-1].contacts if each.types == ("0", "1"))
    return contact.friction, contact.tangential, description


def test_springs_of_two_materials():
    """k_s = ν k_n of each body, in series; Mindlin's 4 G*/E* as that of one material."""
    first, second = FRICT_MAT.format(1e7, 0.3, 0.4), FRICT_MAT.format(4e7, 0.2, 0.6)
    mu, tangential, _ = between_two(FRICT, first, second)
    assert mu == math.tan(0.4) and tangential.model == "FrictPhys"
    ratio = (2 * 3e6 * 8e6 / 11e6) / (2 * 1e7 * 4e7 / 5e7)
    assert tangential.numbers == {"friction_angle": 0.4, "poisson": pytest.approx(ratio)}
    _, tangential, _ = between_two(MINDLIN, first, second)
    shear = 1 / (1.7 * 2.6 / 1e7 + 1.8 * 2.4 / 4e7)
    nu, ratio = tangential.numbers["poisson"], 4 * shear * (0.91 / 1e7 + 0.96 / 4e7)
    assert 2 * (1 - nu) / (2 - nu) == pytest.approx(ratio, rel=1e-12)


@pytest.mark.parametrize(
    "functor,angle",
    [
        ("", 0.2),
        ("frictAngle=0.3", 0.3),
        ("frictAngle=math.radiansHP1(20)", math.pi / 9),
        ("frictAngle=MatchMaker(matches=((0, 1, 0.1),))", 0.1),
        ("frictAngle=MatchMaker(matches=((0, 0, 0.1),))", 0.4),
        ("frictAngle=MatchMaker(algo='max')", 0.6),
        ("frictAngle=MatchMaker(algo='harmAvg')", 0.3),
        ("frictAngle=MatchMaker(algo='val', val=0.7)", 0.7),
        ("frictAngle=MatchMaker(algo='zero')", 0.0),
        ("frictAngle=angles()", None),
        ("frictAngle=MatchMaker(algo='val', val=30)", None),  # radians
    ],
)
def test_the_angle_of_friction(functor, angle):
    pair = (f"Ip2_FrictMat_FrictMat_FrictPhys({functor})", FRICT[1])
    mu, tangential, description = between_two(pair, *(FRICT_MAT.format(1e7, 0.3, phi) for phi in (0.2, 0.6)))
    assert mu == (None if angle is None else pytest.approx(math.tan(angle)))
    assert (tangential is None) is (not angle) and bool(description.unknown) is (angle is None)
    assert any("radians" in note.what for note in description.warnings) is ("30" in functor)


def test_friction_that_the_script_changes():
    rest = "O.dt = 1e-6\nO.run(1)\nsetContactFriction(0.1)\nO.run(1)\nO.materials[0].frictionAngle = 0\nO.run(1)\n"
    stages = read(script(FRICT, GLASS, SPHERE + SPHERE, rest=rest)).stages
    assert [stage.contacts[0].friction for stage in stages] == pytest.approx(
        [math.tan(0.5), math.tan(0.1), 0]
    )
    fixed = "O.bodies.append(sphere((0, 0, 0), 0.01, fixed=True, material='floor'))\n"
    material = GLASS + "O.materials.append(FrictMat(frictionAngle=0.3, label='floor'))\n"
    sphere = SPHERE.replace("0.01", "0.01, material='glass'")
    contact = read(script(MINDLIN, material, sphere + fixed, rest=rest)).stages[1].contacts[-1]
    assert contact.types == ("glass", "floor") and contact.friction == pytest.approx(math.tan(0.1))
    pair = (FRICT[0].replace("()", "(frictAngle=0.2)"), FRICT[1])
    own = read(script(pair, GLASS, SPHERE + SPHERE, rest=rest))
    assert [stage.contacts[0].friction for stage in own.stages] == pytest.approx([math.tan(0.2)])
    assert any("setContactFriction" in note.what for note in own.warnings)
    unknown = read(script(FRICT, GLASS, SPHERE + SPHERE, rest="setContactFriction(final())\nO.run(1)\n"))
    assert unknown.stages[0].contacts[0].tangential is None and unknown.unknown


@pytest.mark.parametrize(
    "keywords,functor,expected",
    [
        ("tc=1e-3, en=0.7, et=0.5", "", {"et": 0.5}),
        ("tc=1e-3, en=0.7, et=0.5", "et=0.2", {"et": 0.2}),
        ("young=1e6", "tc=1e-3, en=0.7, et=1", {"et": 1.0}),
        ("kn=1e4, cn=0.6, ks=3, cs=2", "", {"ks": 3.0, "cs": 2.0}),
        ("kn=1e4, cn=0.6, ks=0, cs=0", "", {"ks": 0.0, "cs": 0.0}),
        ("young=1e6, en=0.6, poisson=0.3", "", {"poisson": 0.3}),
        ("young=1e6, en=0.6, poisson=0", "", {"poisson": 0.0}),
        ("young=1e6, cn=0.5, cs=0.3, poisson=0.3", "", {"poisson": 0.3, "cs": 0.3}),
        ("tc=1e-3, en=0.7, et=-0.5", "", None),
    ],
)
def test_which_tangential_numbers_of_viscoelastic_materials_count(keywords, functor, expected):
    pair = (f"Ip2_ViscElMat_ViscElMat_ViscElPhys({functor})", VISCEL[1])
    _, tangential, description = friction(
        pair, f"O.materials.append(ViscElMat({keywords}, frictionAngle=0.3))\n"
    )
    assert (None if tangential is None else dict(tangential.numbers)) == (
        expected and {"friction_angle": 0.3, **expected}
    )
    assert bool(description.unknown) is (expected is None)


@pytest.mark.parametrize(
    "functor,law,expected",
    [
        ("en=0.7", "Mindlin()", {}),
        ("en=0.7, es=0.4", "Mindlin()", {"es": 0.4}),
        ("es=0.4", "Mindlin()", {"es": 0.4}),
        ("betan=0.1, betas=0.2", "Mindlin()", {"betas": 0.2}),
        ("en=0.7, es=0.4", "HertzWithLinearShear()", {"nonLin": 0.0}),
        ("", "HertzWithLinearShear(nonLin=1)", {"nonLin": 1.0}),
        ("en=0.7, es=later()", "Mindlin()", None),
    ],
)
def test_damping_of_mindlin(functor, law, expected):
    pair = (f"Ip2_FrictMat_FrictMat_MindlinPhys({functor})", f"Law2_ScGeom_MindlinPhys_{law}")
    _, tangential, description = friction(pair, GLASS)
    assert bool(description.unknown) is (expected is None)
    if expected is not None:
        assert tangential.numbers == {"friction_angle": 0.5, "poisson": 0.3, **expected}
        assert tangential.model == ("MindlinPhys" if law == "Mindlin()" else "HertzWithLinearShear")


def test_es_alone_is_en():
    pair = ("Ip2_FrictMat_FrictMat_MindlinPhys(es=0.4)", MINDLIN[1])
    assert numbers(read(script(pair)).stages[0].contacts[0])["en"] == 0.4


@pytest.mark.parametrize("poisson,expected", [((0.0, 0.0), None), ((0.0, 0.3), 0.0), ((0.2, 0.2), 0.2)])
def test_a_spring_without_stiffness(poisson, expected):
    """YADE divides 0 by 0 if both ratios are 0."""
    pair = [FRICT_MAT.format(1e7, nu, 0.4) for nu in poisson]
    _, tangential, description = between_two(FRICT, *pair)
    assert (tangential and tangential.numbers["poisson"]) == expected
    assert bool(description.unknown) is (expected is None)


@pytest.mark.parametrize(
    "locked", ["O.bodies[1].state.blockedDOFs = 'XYZ'", "for b in bodies(): b.state.blockedDOFs = 'zXYZ'"]
)
def test_grains_that_cannot_turn(locked):
    mu, tangential, description = friction(FRICT, GLASS, SPHERE + SPHERE + f"{locked}\n")
    assert mu and tangential is None and any("blockedDOFs" in quote.text for quote in description.unknown)
    plane = locked.replace("zXYZ", "zXY").replace("'XYZ'", "'YZx'")
    assert friction(FRICT, GLASS, SPHERE + SPHERE + f"{plane}\n")[1] is not None
    smooth = GLASS.replace("poisson", "frictionAngle=0, poisson")
    assert not friction(FRICT, smooth, SPHERE + SPHERE + f"{locked}\n")[2].unknown


FACET = "O.bodies.append(facet([(0, 0, 0), (1, 0, 0), (0, 1, 0)]))\n"
TC = "O.materials.append(ViscElMat(tc=1e-3, en=0.7, et=0.5, {}frictionAngle={}))\n"
YADE_ES = "Ip2_FrictMat_FrictMat_MindlinPhys(en=0.7, es=0.4)"
KROT = "Ip2_FrictMat_FrictMat_MindlinPhys(krot=1e-3, ktwist=1e-4, eta={})"
COHESION = ("Ip2_CohFrictMat_CohFrictMat_CohFrictPhys()", "Law2_ScGeom6D_CohFrictPhys_CohesionMoment({})")
TRAPS = {
    "es": ((YADE_ES, MINDLIN[1]), GLASS, "es = 0.4 is no restitution"),
    "et": (VISCEL, TC.format("", 0.3), "et reverses"),
    "half the mass": (VISCEL, TC.format("", 0.3), "at facets, YADE computes kn, cn, ks and cs with half the mass"),
    "linear shear": ((MINDLIN[0], "Law2_ScGeom_MindlinPhys_HertzWithLinearShear()"), GLASS, "8 G* √R, in N/m^1.5"),
    "no tangential force": (
        (MINDLIN[0], "Law2_ScGeom_MindlinPhys_MindlinDeresiewitz()"),
        GLASS,
        "no tangential force",
    ),
    "damping without spring": (
        VISCEL,
        "O.materials.append(ViscElMat(kn=1e4, ks=0, cn=0, cs=1, frictionAngle=0))\n",
        "a damping cs that nothing limits",
    ),
    "damping": (FRICT, GLASS, "the damping 0.3 of NewtonIntegrator acts on spins"),
    "rolling": (
        (KROT.format(0.1), "Law2_ScGeom_MindlinPhys_Mindlin(includeMoment=True)"),
        GLASS,
        "krot = 0.001 and ktwist = 0.0001): an angular impulse of up to k ω t_c²/2 per collision, that",
    ),
    "rolling without limit": (
        (KROT.format(0), "Law2_ScGeom_MindlinPhys_Mindlin(includeMoment=True)"),
        GLASS,
        "not limited",
    ),
    "rolling without effect": ((KROT.format(0.1), MINDLIN[1]), GLASS, "without effect: the law lacks includeMoment"),
    "mR": (VISCEL, TC.format("mR=1e-4, ", 0.3), "(mR = 0.0001): an angular impulse of up to mR ω J_n"),
    "mRtype": (VISCEL, TC.format("mR=1e-4, mRtype=2, ", 0.3), "mR |R₁ω₁ + R₂ω₂| ω J_n"),
    "moments": (
        (COHESION[0], COHESION[1].format("always_use_moment_law=True")),
        "O.materials.append(CohFrictMat(momentRotationLaw=True, alphaKr=1, etaRoll=0.1))\n",
        "alphaKr = 1, alphaKtw = 2, etaRoll = 0.1",
    ),
    "moments without effect": (
        (COHESION[0], COHESION[1].format("")),
        "O.materials.append(CohFrictMat(momentRotationLaw=True))\n",
        "momentRotationLaw without effect",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", TRAPS)
def test_what_friction_really_does_is_said(name):
    pair, material, text = TRAPS[name]
    description = read(script(pair, material, SPHERE + SPHERE + FACET, integrator="damping=0.3"))
    notes = [note for note in description.warnings if text in note.what]
    assert notes and all(note.quote for note in notes)
    assert bool(description.unknown) is ("without spring" in name)
    assert all(note.types is None or "wall" in note.types for note in notes if "facets" in note.what)
    plain = read(script(FRICT, GLASS, SPHERE + SPHERE + FACET))
    assert not plain.warnings


def test_grains_without_friction_have_no_tangential_force():
    smooth = GLASS.replace("poisson", "frictionAngle=0, poisson")
    for pair in (FRICT, MINDLIN):
        mu, tangential, description = friction(pair, smooth)
        assert mu == 0.0 and tangential is None and not description.unknown
    assert not read(script(VISCEL, TC.format("", 0), SPHERE + SPHERE + FACET)).warnings


def test_the_viscoelastic_law_is_wrong_at_the_sides_of_a_sheared_cell():
    """Two spheres across a side of a cell: YADE 2023.02a pulls them along their relative motion."""
    cell = "O.periodic = True\nO.cell.setBox(1, 1, 1)\n"
    turned = "O.cell.velGrad = Matrix3(0, 5, 0, 0, 0, 0, 0, 0, 0)\n"
    viscoelastic = (
        "O.materials.append(ViscElMat(kn=1e3, ks=3e2, cn=1, cs=0, frictionAngle=0.4, density=2500))\n"
    )
    for pair, material, strain, wrong in (
        (VISCEL, viscoelastic, turned, True),
        (VISCEL, viscoelastic, "", False),
        (FRICT, GLASS, turned, False),
    ):
        text = script(pair, material, cell + SPHERE, rest=f"{strain}O.dt = 1e-6\nO.run(10)\n")
        notes = [note.what for note in read(text).warnings]
        assert any("wrong sign" in what for what in notes) is wrong
