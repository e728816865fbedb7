"""One or two grains, and grains that meet walls only: the number is that of a contact at its impact."""

import math

import pytest

import hardlimit as hl

#: A free sphere above a fixed one, or above a facet.
PAIR = """
O.materials.append(FrictMat(young=1e7, poisson=0.25, density=2600, frictionAngle=0.0))
O.bodies.append([{bodies}])
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Facet_Aabb()]),
    InteractionLoop(
        [{meeting}],
        [Ip2_FrictMat_FrictMat_MindlinPhys(en=0.8)],
        [Law2_ScGeom_MindlinPhys_Mindlin()],
    ),
    NewtonIntegrator(damping=0, gravity=(0, 0, {gravity})),
]
O.dt = 1e-5
O.run(100)
"""
TWO = "sphere((0, 0, 0), 0.01), sphere((0, 0, 0.0201), 0.01)"
BOTH = "Ig2_Sphere_Sphere_ScGeom(), Ig2_Facet_Sphere_ScGeom()"
FACET = "facet([(-1, -1, 0), (1, -1, 0), (0, 1, 0)])"


def pair(bodies=TWO, meeting=BOTH, gravity=0):
    return PAIR.format(bodies=bodies, meeting=meeting, gravity=gravity)


def test_two_grains_have_the_numbers_of_their_impact():
    """YADE 2023.02a at 1 m/s, steps of 2 µs: overlap/R 0.0651327, ε 0.799948."""
    state = hl.check(pair(), speed=1.0).state
    assert (
        state.grains == 2 and state.name == "gas" and state.impact_speed == 1.0 and not state.speed_is_chosen
    )
    assert state.overlap == pytest.approx(0.0651327, rel=2e-4)
    assert state.restitution == pytest.approx(0.799948, rel=2e-4)
    assert state.stiffness_number is None and state.coordination is None


def test_without_a_speed_it_is_chosen_and_said():
    verdict = hl.check(pair())
    assert verdict.state.speed_is_chosen and verdict.state.impact_speed == 1.0
    assert "Two grains only: at 1 m/s (supposed; --speed gives another) ε = 0.8" in verdict.sentence
    assert "the force lasts " in verdict.sentence
    assert verdict.admissible is None


def test_few_grains_are_not_asked_for_a_packing():
    """They are no gas, and their speed may be in the script; a single grain without walls meets nothing."""
    two = LINED_UP.replace("run 10", "velocity one set 0.3 0 0\nvelocity two set -0.3 0 0\nrun 10")
    verdict = hl.check(two)
    assert (
        "Cannot be said: the law of the error is that of a gas of many grains. Two grains" in verdict.sentence
    )
    assert "at 0.6 m/s" in verdict.sentence and "known" not in f"{verdict}"
    alone = hl.check(two.replace("create_atoms 1 single 0.8 0.5 0.5\n", "").replace("velocity two", "#"))
    assert alone.state.never_meet and "no grain meets another" in alone.sentence


LINED_UP = """units si
atom_style sphere
region b block 0 1 0 1 0 1
create_box 1 b
create_atoms 1 single 0.2 0.5 0.5
create_atoms 1 single 0.8 0.5 0.5
group one id 1
group two id 2
set group all diameter 2e-3 density 2500
pair_style granular
pair_coeff * * hooke 1e4 0.8 damping coeff_restitution tangential linear_nohistory 0 0
fix i all nve/sphere
timestep 1e-6
run 10
"""


def test_a_fall_gives_the_speed_of_one_grain():
    verdict = hl.check(pair(f"{FACET}, sphere((0, 0, 0.5), 0.01)", gravity=-9.81))
    state = verdict.state
    assert state.grains == 1 and state.name == "rest" and "One grain only" in verdict.sentence
    assert state.impact_speed == pytest.approx(math.sqrt(2.0 * 9.81 * 0.49))  # from its lowest point


def test_grains_that_meet_only_walls():
    """Without a functor for spheres they do not meet each other, however many there are."""
    falling = "sphere((0.1 * k, 0, random.uniform(0.5, 1)), random.uniform(0.01, 0.02))"
    text = pair(FACET, "Ig2_Facet_Sphere_ScGeom()", -9.81)
    text = text.replace("O.engines", f"for k in range(30):\n    O.bodies.append({falling})\nO.engines")
    verdict = hl.check(text)
    assert verdict.state.grains == 0 and "Grains meet walls only" in verdict.sentence
    assert (
        "No: grains come to rest on walls under gravity" in verdict.sentence
        and "rest on each" not in verdict.sentence
    )
    many = hl.check(text.replace("Ig2_Facet_Sphere_ScGeom()", BOTH)).state
    assert many.grains is None and "in one stack" in many.pressure_from


@pytest.mark.parametrize("damping", [0.0, 20.0])
def test_the_longest_stable_step_of_an_isolated_contact(damping):
    """k_n/m of two spheres; with a dashpot at the velocity half a step before, h ω = 2 (√(1 + ζ²) − ζ)."""
    mass = 4.0 / 3.0 * math.pi * 1e-9 * 2500.0
    script = f"""units si
atom_style sphere
region b block 0 1 0 1 0 1
create_box 1 b
create_atoms 1 single 0.2 0.5 0.5
create_atoms 1 single 0.8 0.5 0.5
set group all diameter 2e-3 density 2500
pair_style granular
pair_coeff * * hooke 1e4 {damping} damping mass_velocity tangential linear_nohistory 0 0
fix i all nve/sphere
timestep 1e-6
run 10
"""
    state = hl.check(script.replace("mass_velocity", "velocity") if damping else script, speed=0.1).state
    omega = math.sqrt(2.0 * 1e4 / mass)
    zeta = damping / (2.0 * math.sqrt(0.5 * mass * 1e4)) if damping else 0.0
    expected = 2.0 * (math.sqrt(1.0 + zeta**2) - zeta) / omega
    assert state.grains == 2 and state.largest_stable_step == pytest.approx(expected)
    assert state.step_share == pytest.approx(1e-6 / expected)


def test_one_grain_touches_its_wall_only():
    """Its spring moves the whole mass: in LAMMPS, motion on the floor decays at 0.97 times this step, grows at 1.03."""
    contact = "granular hooke 1e4 0.05 damping velocity tangential linear_nohistory 0 0"
    bed = GAS.replace(
        "read_restart gas.bin", "create_atoms 1 single 0.5 0.5 0.1\nset group all diameter 2e-3 density 2500"
    )
    bed += f"fix w all wall/gran {contact} zplane 0 NULL\nfix g all gravity 9.81 vector 0 0 -1\nrun 10\n"
    state = hl.check(
        bed.replace("region b block 0 1 0 1 0 1", "boundary p p f\nregion b block 0 1 0 1 0 1")
    ).state
    mass = 4.0 / 3.0 * math.pi * 1e-9 * 2500.0
    omega, zeta = math.sqrt(1e4 / mass), 0.05 / (2.0 * math.sqrt(mass * 1e4))
    assert state.grains == 1
    assert state.largest_stable_step == pytest.approx(2.0 * (math.sqrt(1.0 + zeta**2) - zeta) / omega)


def test_more_than_two_grains_or_a_pressure_have_another_number():
    three = f"{TWO}, sphere((0, 0, 0.05), 0.01)"
    assert hl.check(pair(three), speed=1.0).state.grains is None
    pressed = hl.check(pair(), pressure=100.0).state
    assert pressed.grains is None and pressed.stiffness_number is not None


GAS = """units si
atom_style sphere
region b block 0 1 0 1 0 1
create_box 1 b
read_restart gas.bin
pair_style granular
pair_coeff * * hooke 1e4 0.02 damping velocity tangential linear_nohistory 0 0
fix i all nve/sphere
timestep 1e-6
run 10
"""


@pytest.mark.parametrize("options", [{}, {"speed": 0.3}, {"packing_fraction": 0.2}])
def test_a_gas_has_its_number_at_a_supposed_packing_and_speed(options):
    """The one that it has where both are given; the answer stays that it cannot be said."""
    size = {"radius": 1e-3, "density": 2500.0}
    verdict = hl.check(GAS, **size, **options)
    complete = hl.check(GAS, **size, **{"speed": 1.0, "packing_fraction": 0.1, **options})
    assert verdict.state.supposed_tc_nu == pytest.approx(complete.rows[0].tc_nu)
    assert complete.state.supposed_tc_nu is None and verdict.state.speed_is_chosen is ("speed" not in options)
    assert verdict.admissible is None and "(not both are known) t_c ν would be" in verdict.sentence


def test_few_grains_do_not_rest_on_each_other():
    single = hl.check(pair(f"{FACET}, sphere((0, 0, 0.5), 0.01)", gravity=-9.81))
    assert "No: the grain rests or rolls in lasting contact under gravity, which" in single.sentence
    two = hl.check(
        pair(f"{FACET}, {TWO.replace('0, 0, 0)', '0, 0, 0.1)').replace('0.0201', '0.2')}", gravity=-9.81)
    )
    assert "No: the two grains rest or roll in lasting contact under gravity, which" in two.sentence


ELASTIC = PAIR.replace("(en=0.8)", "()")
DROP = pair(f"{FACET}, sphere((0, 0, 0.5), 0.01)", gravity=-9.81).replace("(en=0.8)", "()")
HEAP = DROP.replace(
    "O.engines", "for k in range(30):\n    O.bodies.append(sphere((0, 0, 0.6 + k), 0.01))\nO.engines"
)


@pytest.mark.parametrize("text", [DROP, HEAP])
def test_elastic_grains_never_rest(text):
    """In YADE, 317 of them above a plane still have the energy of their fall after 2.5 s, and spread."""
    verdict = hl.check(text)
    assert verdict.state.name == "gas" and verdict.admissible is None
    assert "Cannot be said: elastic grains bounce for ever under gravity" in verdict.sentence
    for changed in (text.replace("damping=0,", "damping=0.1,"), text.replace("Phys()", "Phys(en=0.99)")):
        assert changed != text and hl.check(changed).state.name == "rest"
        assert hl.check(changed).admissible is False and " rest" in hl.check(changed).sentence
    rubbing = hl.check(text.replace("frictionAngle=0.0", "frictionAngle=0.4")).state
    assert rubbing.name == ("gas" if text == DROP else "rest")  # one alone falls straight down


def test_a_statement_that_is_not_understood_ends_with_a_full_stop():
    text = ELASTIC.format(bodies=TWO, meeting=BOTH, gravity=0).replace(
        "O.dt", "O.bodies[0].state.mass = 3\nO.dt"
    )
    assert hl.check(text).sentence.endswith("this is not understood: line 14: O.bodies[0].state.mass = 3.")


def test_the_step_of_one_contact_is_not_that_of_a_packing():
    text = pair(f"{FACET}, sphere((0, 0, 0.5), 0.01)", gravity=-9.81).replace("O.dt = 1e-5", "O.dt = 1e-3")
    (line,) = (line for line in hl.check(text).corrected if line.startswith("O.dt"))
    assert line.endswith("# 0.5 of the longest stable one")


def test_two_elastic_grains_never_rest_although_they_rub():
    """YADE 2023.02a: a sphere put on a fixed one still moves as fast after 115,000 steps."""
    two = "sphere((0, 0, 0), 0.01, fixed=True), sphere((0, 0, 0.05), 0.01)"
    text = pair(two, gravity=-9.81).replace("(en=0.8)", "()").replace("Angle=0.0", "Angle=0.4")
    verdict = hl.check(text)
    assert verdict.state.name == "gas" and "elastic grains bounce for ever" in verdict.sentence
    assert hl.check(text.replace("Phys()", "Phys(en=0.99)")).state.name == "rest"


@pytest.mark.parametrize("gap", [0.03, 0.0])
def test_one_grain_falls_on_a_fixed_one(gap):
    """Where they touch from the start its speed is not known."""
    bodies = f"sphere((0, 0, 0), 0.01, fixed=True), sphere((0, 0, {0.02 + gap}), 0.01)"
    state, falls = hl.check(pair(bodies, gravity=-9.81)).state, gap > 0
    assert state.grains == 2 and state.speed_is_chosen is not falls
    assert state.impact_speed == pytest.approx(math.sqrt(2 * 9.81 * (gap if falls else 0.01)))


def test_a_grain_that_slides_along_its_floor_does_not_hit_it():
    """Of a velocity that is set, the part along the wall is no impact speed."""
    body = f"{FACET}, sphere((0, 0, {{}}), 0.01)"
    for height, velocity, expected in (
        (0.02, (3, 0, -1), math.sqrt(1 + 2 * 9.81 * 0.01)),
        (0.02, (3, 0, 0), math.sqrt(2 * 9.81 * 0.01)),
        (0.01, (3, 0, 0), None),
    ):
        text = pair(body.format(height), gravity=-9.81)
        state = hl.check(text.replace("O.dt", f"O.bodies[1].state.vel = {velocity}\nO.dt")).state
        assert state.grains == 1 and state.speed_is_chosen is (expected is None)
        assert expected is None or state.impact_speed == pytest.approx(expected)
    slanted = FACET.replace("(0, 1, 0)", "(0, 1, 0.1)")
    text = pair(f"{slanted}, sphere((0, 0, 0.5), 0.01)", gravity=-9.81)
    assert hl.check(
        text.replace("O.dt", "O.bodies[1].state.vel = (9, 0, 0)\nO.dt")
    ).state.impact_speed == pytest.approx(9)


@pytest.mark.parametrize(("second", "velocity", "height"), [
    ((0, 0, 0.09), 0.0, 0.04),  # the lower one falls by 4 cm, the upper one to 2 cm above the floor: 6 cm
    ((0.005, 0, 0.14), 0.0, 0.11),
    ((0.5, 0, 0.14), 0.0, 0.13),
    ((0.5, 0, 0.14), 2.0, 0.13),
])  # fmt: skip
def test_two_grains_fall_from_where_they_are(second, velocity, height):
    bodies = f"{FACET}, sphere((0, 0, 0.05), 0.01), sphere({second}, 0.01)"
    text = pair(bodies, gravity=-9.81).replace("O.dt", f"O.bodies[2].state.vel = (0, 0, {velocity})\nO.dt")
    highest = max(height, 0.06 if second[2] == 0.09 else 0.0)
    state = hl.check(text).state
    assert state.impact_speed == pytest.approx(math.sqrt(velocity**2 + 2 * 9.81 * highest))


@pytest.mark.parametrize("down", [1.0, -1.0])
def test_a_grain_between_six_walls_falls_on_that_below(down):
    walls = "aabbWalls([(0, 0, 0), (1, 1, 1)], thickness=0)"
    text = pair("sphere((0.5, 0.5, 0.4), 0.01)", gravity=-9.81 * down)
    text = text.replace("O.engines", f"O.bodies.append({walls})\nO.engines").replace("Facet", "Box")
    height = 0.39 if down > 0 else 0.59
    assert hl.check(text).state.impact_speed == pytest.approx(math.sqrt(2 * 9.81 * height))


def test_a_grain_that_meets_nothing_has_no_impact():
    alone = hl.check(pair("sphere((0, 0, 0), 0.01)", gravity=-9.81))
    assert alone.state.never_meet and alone.state.grains is None and "One grain" not in alone.sentence
    assert not hl.check(pair(f"{FACET}, sphere((0, 0, 0.5), 0.01)", gravity=-9.81)).state.never_meet


def test_a_grain_that_is_not_damped_is_quoted():
    text = pair(TWO).replace("O.dt", "O.bodies[0].state.isDamped = False\nO.dt")
    assert any("isDamped" in finding.what for finding in hl.check(text, speed=1.0).unknown)


@pytest.mark.parametrize(("damping", "more", "velocity", "seen"), [
    (0.4, "", 0, 3.4139), (0.4, ", dampGravity=False", 0, 4.4145), (0.7, "", 0, 2.4133), (0.2, "", 1, 4.0421),
])  # fmt: skip
def test_the_damping_of_the_integrator_slows_the_fall(damping, more, velocity, seen):
    """``seen``: the largest speed downwards in YADE 2023.02a at intervals of 5 ms, from a height of 1 m."""
    text = pair(f"{FACET}, sphere((0, 0, 1.01), 0.01)", gravity=-9.81)
    text = text.replace("damping=0,", f"damping={damping}{more},")
    text = text.replace("O.dt", f"O.bodies[1].state.vel = (0, 0, {velocity})\nO.dt")
    assert hl.check(text).state.impact_speed == pytest.approx(seen, abs=9.81 * 5e-3)


@pytest.mark.parametrize(
    ("gravity", "meets"), [("(0, 0, {})", True), ("(0, {}, 0)", False), ("({}, 0, 0)", False)]
)
def test_a_grain_that_falls_beside_a_fixed_one_does_not_meet_it(gravity, meets):
    text = pair("sphere((0, 0, 0), 0.01, fixed=True), sphere((0, 0, 0.05), 0.01)", gravity=-9.81)
    text = text.replace("(0, 0, -9.81)", gravity.format(-9.81))
    verdict = hl.check(text)
    assert (verdict.state.name == "rest") is meets and verdict.state.never_meet is not meets
    assert ("no grain meets another" in verdict.sentence) is not meets
    moved = text.replace(
        "NewtonI", "TranslationEngine(velocity=1, translationAxis=(0, 1, 0), ids=[0]),\n    NewtonI"
    )
    assert not hl.check(moved).state.never_meet
