"""convert: our own numbers against the laws of the core, every model of every code there and back, known facts about
codes, what was measured by running them, and the command line."""

import csv
import json
import math
import re
import shlex
import subprocess

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

import hardlimit as hl
from conftest import DATA, draws, log_floats, slow
from hardlimit import _core
from hardlimit.boxes.lammps import integration_error, program
from hardlimit.checking.scripts import CODES
from hardlimit.cli import main
from hardlimit.convert import formulas, texts
from hardlimit.convert.codes import Pair, Written, code, names
from hardlimit.convert.force import AdhesiveForce, ContactArea, Force, Powers, damping_for
from hardlimit.convert.wanted import LAWS

BALL = hl.Ball(radius=5e-4, density=7850.0)
BED = [hl.Ball(radius=r, density=2500.0) for r in (5e-4, 1e-3)]
STEEL = {"youngs_modulus": 2.1e11, "poisson_ratio": 0.3}
MODELS = [(c.name, m.name) for c in map(code, names()) for m in c.models]
RUNS = list(csv.DictReader((DATA / "code_restitution.csv").read_text("utf-8").splitlines()))

try:
    program.find(1)
    MISSING = ""
except ImportError as error:
    MISSING = str(error)

restitutions = st.one_of(
    st.floats(1e-3, 1.0), st.sampled_from([1e-3, 0.01, 0.135, math.exp(-2.0), 0.999, 1.0])
)


# --- one collision ------------------------------------------------------------------------------------------


@draws(25)
@given(restitution=st.floats(1e-3, 1.0), speed=log_floats(1e-3, 1e2), mass=log_floats(1e-9, 1e3))
def test_powers_agree_with_the_laws_of_the_core(restitution, speed, mass):
    """The numbers of ``Contact``, which come from closed forms and from a Taylor series."""
    ball = hl.Ball(radius=1e-3, mass=mass)
    for name, law in (
        ("linear", hl.LinearDashpot(stiffness=1e5, restitution=restitution)),
        ("tsuji", hl.Tsuji(youngs_modulus=1e7, poisson_ratio=0.2, restitution=restitution)),
        (
            "viscoelastic",
            hl.Viscoelastic(
                youngs_modulus=1e7, poisson_ratio=0.2, restitution=restitution, impact_speed=speed
            ),
        ),
    ):
        contact = law.between(ball)
        stiffness = contact.stiffness if name == "linear" else contact.elastic_prefactor
        force = Force.with_restitution(LAWS[name], stiffness, mass, restitution, speed)
        collision = force.collision(speed)
        assert collision.restitution == pytest.approx(restitution, rel=1e-10)
        assert collision.duration == pytest.approx(contact.duration(speed), rel=1e-10)
        at, rate = np.array([0.3 * collision.compression]), np.array([-0.1 * speed])
        assert force.force(at, rate) == pytest.approx(
            contact.force(at, rate), rel=1e-8, abs=1e-9 * collision.force
        )


@draws(25)
@given(ratio=st.floats(0.0, 0.95))
def test_a_force_that_attracts_follows_the_usual_formula(ratio):
    """ε = exp(−πζ/√(1 − ζ²)), linear and of Tsuji, and greatest compression and force of the closed solution."""
    expected = math.exp(-math.pi * ratio / math.sqrt(1.0 - ratio * ratio))
    for powers, factor in ((Powers(4, 0, True), 2.0), (Powers(6, 1, True), math.sqrt(5.0))):
        assert _core.power_collision(*powers.arguments, factor * ratio)[0] == pytest.approx(
            expected, abs=1e-12
        )
    _, duration, compression, force = _core.power_collision(4, 0, True, 2.0 * ratio)
    omega = math.sqrt(1.0 - ratio * ratio)
    t = np.linspace(0.0, math.pi / omega, 20001)
    x = np.exp(-ratio * t) * np.sin(omega * t) / omega
    v = np.exp(-ratio * t) * (np.cos(omega * t) - ratio * np.sin(omega * t) / omega)
    assert duration == pytest.approx(math.pi / omega, rel=1e-12)
    assert compression == pytest.approx(x.max(), rel=1e-7)
    assert force == pytest.approx((x + 2.0 * ratio * v).max(), rel=1e-7)


@pytest.mark.parametrize("powers", [(4, 0), (4, 2), (6, 0), (6, 1), (6, 2), (6, 6)])
@pytest.mark.parametrize("attracts", [False, True])
def test_damping_and_restitution_are_inverse(powers, attracts):
    form = Powers(*powers, attracts)
    dampings = [damping_for(form, e) for e in (1.0, 0.999, 0.7, 0.1, 1e-3)]
    assert dampings[0] == 0.0 and dampings == sorted(dampings)
    for damping, e in zip(dampings, (1.0, 0.999, 0.7, 0.1, 1e-3), strict=True):
        assert _core.power_collision(*form.arguments, damping)[0] == pytest.approx(e, abs=1e-11)


@given(
    st.sampled_from([(4, 0), (6, 1), (6, 2)]),
    st.floats(0.2, 1.0),
    st.floats(0.0, 3.0),
    st.floats(0.1, 10.0),
    st.floats(0.05, 20.0),
    st.booleans(),
)
@draws(200)
def test_cohesion_takes_no_energy_and_keeps_slow_bodies(powers, restitution, share, ratio, speed, attracts):
    """Without damping ε is 1; with damping it is less than without cohesion. The attraction is that of the area."""
    area = ContactArea("sjkr", 1.0, ratio)
    bare = Force.with_restitution(Powers(*powers, attracts), 1e3, 1e-3, restitution, speed)
    deepest = (bare.effective_mass / bare.stiffness * speed**2) ** (4.0 / (4.0 + powers[0]))
    if deepest > 0.2 * min(1.0, ratio):
        return
    w = share * bare.stiffness * deepest ** (0.25 * powers[0]) / float(area(deepest))
    sticky = AdhesiveForce(bare.powers, bare.stiffness, bare.damping, bare.effective_mass, w, area)
    assert sticky.force(np.array([deepest]), np.array([0.0]))[0] == pytest.approx(
        bare.force(np.array([deepest]), np.array([0.0]))[0] - w * float(area(deepest)),
        abs=1e-9 * bare.stiffness,
    )
    collision = sticky.collision(speed)
    if math.isnan(collision.restitution):
        assert collision.compression > 0.999 * min(1.0, ratio)
        return
    assert collision.restitution <= bare.collision(speed).restitution + 1e-7
    if share == 0.0:
        assert collision.restitution == pytest.approx(bare.collision(speed).restitution, abs=1e-7)
    undamped = AdhesiveForce(bare.powers, bare.stiffness, 0.0, bare.effective_mass, w, area).collision(speed)
    crushed = undamped.compression > 0.999 * min(1.0, ratio)
    assert crushed or undamped.restitution == pytest.approx(1.0, abs=1e-6)


@given(st.floats(0.05, 1.0), st.floats(0.0, 0.9), st.floats(0.2, 5.0), st.floats(0.01, 10.0))
@draws(200)
def test_cohesion_in_proportion_to_the_compression_softens_a_linear_spring(e, share, ratio, speed):
    area = ContactArea("sjkr2", 1.0, ratio)
    w = share * 1e4 / float(area(1.0))
    damping = Force.with_restitution(Powers(4, 0, True), 1e4, 1e-4, e, speed).damping
    sticky = AdhesiveForce(Powers(4, 0, True), 1e4, damping, 1e-4, w, area).collision(speed)
    soft = Force(Powers(4, 0, True), (1.0 - share) * 1e4, damping, 1e-4).collision(speed)
    assert sticky.restitution == pytest.approx(soft.restitution, abs=1e-6)
    if soft.restitution > 1e-3:
        assert sticky.duration == pytest.approx(soft.duration, rel=1e-5)
        assert sticky.compression == pytest.approx(soft.compression, rel=1e-6)


def test_areas_of_contact():
    """The circle in which spheres intersect, and a plane and a sphere; half of sjkr2's at a wall."""
    a, b, x = 1.0, 2.0, 0.1
    d = a + b - x
    half = (d * d + a * a - b * b) / (2.0 * d)
    assert ContactArea("sjkr", a, b)(x) == pytest.approx(math.pi * (a * a - half * half))
    assert ContactArea("sjkr", a, math.inf)(x) == pytest.approx(math.pi * (a * a - (a - x) ** 2))
    assert ContactArea("sjkr", a, 1e9)(x) == pytest.approx(ContactArea("sjkr", a, math.inf)(x))
    assert ContactArea("sjkr2", a, 1e9)(x) == pytest.approx(2.0 * ContactArea("sjkr2", a, math.inf)(x))


def test_an_overdamped_force_that_attracts_never_parts():
    restitution, duration, compression, _ = _core.power_collision(4, 0, True, 2.5)
    assert restitution == 0.0 and duration == math.inf and 0.0 < compression < 1.0
    sticky = hl.convert_back("hooke 1e4 5 damping velocity", BALL, code="lammps")
    assert sticky.restitution == 0.0 and math.isnan(sticky.time_step)


# --- every model of every code ------------------------------------------------------------------------------


def contacts(radius_1, radius_2):
    """A pair and a wall, as the codes see them."""
    balls = [hl.Ball(radius=r, density=2500.0) for r in (radius_1, radius_2)]
    mass, radius = _core.effective(*(b.mass for b in balls)), _core.effective(radius_1, radius_2)
    return (
        Pair("1 – 2", mass, radius, False, 1, 2),
        Pair("1 – wall", balls[0].mass, radius_1, True),
    )


@pytest.mark.parametrize("name,model", MODELS)
@given(
    restitution=restitutions,
    speed=log_floats(1e-3, 30.0),
    stiffness=log_floats(1e2, 1e9),
    radii=st.tuples(log_floats(1e-5, 0.1), log_floats(1e-5, 0.1)),
    attraction=st.booleans(),
    nu=st.floats(0.0, 0.5),
)
@settings(max_examples=4, deadline=None)
def test_there_and_back(name, model, restitution, speed, stiffness, radii, attraction, nu):
    """Numbers for a restitution give that restitution, and stand in the input."""
    of, source = code(name), code(name).model(model)
    for pair in contacts(*radii):
        written = Written(source, pair, speed, attraction, nu)
        numbers = written.numbers(stiffness, restitution)
        if numbers is None and source.spring.shortest**2 * stiffness > pair.mass:
            continue
        if numbers is None and source.damping.formula == "given" and restitution == 1.0:
            continue
        if numbers is None and source.damping.formula == "none" and restitution < 1.0:
            continue
        if numbers is None and source.input.least and (restitution < 0.1 or speed < 0.011):
            continue  # the code refuses them
        if numbers is None:  # the code's formula never damps so much
            most = formulas.FORMULAS[source.damping.formula](formulas.SMALLEST)
            strongest = written.force(
                {**written.numbers(stiffness, 0.9), source.damping.number: formulas.SMALLEST}
            )
            assert math.isfinite(most) and strongest.collision(speed).restitution > restitution
            continue
        text = texts.written(of, source, [(pair, numbers)], attraction, 1e-6)
        assert all(f"{value:.12g}" in text for value in numbers.values())
        force = written.force(numbers)
        assert force.stiffness == pytest.approx(stiffness, rel=1e-9)
        assert force.collision(speed).restitution == pytest.approx(
            restitution, abs=max(source.damping.tolerance, 1e-9)
        )


@pytest.mark.parametrize("name", CODES)
def test_an_input_tells_its_model(name):
    """The text of each model is read as that model alone, from pairs and from walls."""
    source = code(name)
    for model in source.models:
        given_as = {"stiffness": 1e5} if model.elastic == "hooke" else STEEL
        wanted = 1.0 if model.damping.formula == "none" else 0.8
        conversion = hl.convert(BALL, restitution=wanted, code=name, model=model.name, wall=False, **given_as)
        back = hl.convert_back(conversion.text, BALL, code=name)
        assert back.model.name == model.name
        assert back.restitution == pytest.approx(wanted, abs=max(model.damping.tolerance, 1e-9))


def test_files_name_their_source_and_what_they_were_checked_by():
    assert len(names()) >= 8 and RUNS
    for name in map(code, names()):
        assert name.models and name.sources
        assert name.version and all(source.startswith("https://") for source in name.sources)
        ran = {row["code"] for row in RUNS} | {"lammps"}
        assert (name.checked == "run") == (name.name in ran)
        assert len({model.name for model in name.models}) == len(name.models)


# --- known facts --------------------------------------------------------------------------------------------


def usually(name, model, restitution, attraction=False, wall=False):
    given_as = {"stiffness": 1e5} if code(name).model(model).elastic == "hooke" else STEEL
    conversion = hl.convert(
        BALL, restitution=restitution, code=name, model=model, attraction=attraction, **given_as
    )
    return conversion.models[0].contacts[1 if wall else 0].usual_restitution


@pytest.mark.parametrize(
    "name,model,restitution,attraction,wall,gives,digits",
    [
        ("lammps", "hooke-restitution", 0.7, False, False, 0.718, 5e-4),
        ("lammps", "hooke-restitution", 0.7, True, False, 0.7, 1e-9),
        ("lammps", "hertz-tsuji", 0.7, True, False, 0.778, 5e-4),
        ("lammps", "hertz-tsuji", 0.7, False, False, 0.788, 5e-4),
        ("liggghts", "hertz", 0.7, False, False, 0.718, 5e-4),
        ("yade", "viscel-tc-en", 0.7, False, False, 0.718, 5e-4),
        ("yade", "viscel-young-en", 0.9, False, False, 0.907, 5e-4),
        ("yade", "viscel-young-en", 0.7, False, True, 0.775, 5e-4),
        ("yade", "hertz-en", 0.99, False, False, 0.979, 5e-4),
        ("kratos", "hertz", 0.99, False, False, 0.979, 5e-4),
        ("kratos", "linear", 0.7, False, False, 0.7, 2e-4),
        ("mercurydpm", "linear-restitution", 0.7, False, False, 0.7, 1e-9),
        ("mfix", "lsd", 0.7, False, False, 0.7, 1e-9),
        ("mfix", "hertzian", 0.7, False, False, 0.7272, 5e-5),
        ("chrono", "hertz", 0.7, False, False, 0.718, 5e-4),
        ("mujoco", "direct", 0.7, False, False, 0.718, 5e-4),
        ("mujoco", "ratio", 0.7, False, True, 0.718, 5e-4),
    ],
)
def test_known_facts(name, model, restitution, attraction, wall, gives, digits):
    assert usually(name, model, restitution, attraction, wall) == pytest.approx(gives, abs=digits)


def test_mercury_wants_twice_the_effective_mass():
    """With the particle's mass for two that are equal it is right, with m_eff it is not."""
    pair = Pair("1 – 1", 0.5 * BALL.mass, 0.5 * BALL.radius, False)
    written = Written(code("mercurydpm").model("linear-restitution"), pair, 1.0)
    numbers = written.numbers(1e5, 0.7)
    assert numbers["mass"] == pytest.approx(BALL.mass) and numbers["restitution"] == pytest.approx(0.7)
    wrong = written.force({**numbers, "mass": 0.5 * BALL.mass}).collision(1.0)
    assert wrong.restitution == pytest.approx(0.7777, abs=1e-4)


def test_one_coefficient_does_not_serve_all_sizes():
    """LAMMPS' hooke with damping velocity: γ for the small ones gives the large ones another ε."""
    balls = [hl.Ball(radius=r, density=2500.0) for r in (5e-4, 1e-3)]
    conversion = hl.convert(
        balls, restitution=0.7, stiffness=1e5, code="lammps", model="hooke-velocity", wall=False
    )
    gammas = [row.numbers["damping"] for row in conversion.models[0].contacts]
    assert [row.pair for row in conversion.models[0].contacts] == ["1 – 1", "1 – 2", "2 – 2"]
    assert gammas == pytest.approx([contact.damping for contact in conversion.contacts], rel=1e-9)
    text = f"pair_coeff * * hooke 1e5 {gammas[0]!r} damping velocity limit_damping"
    assert hl.convert_back(text, balls[0], code="lammps").restitution == pytest.approx(0.7, abs=1e-9)
    assert hl.convert_back(text, balls[1], code="lammps").restitution > 0.85


@pytest.mark.parametrize("wall", [True, False])
def test_a_bed_is_a_matrix_over_types_where_the_code_has_one(wall):
    """LIGGGHTS: symmetric, each entry that of its contact, the wall a type of its own; YADE: the same as triples."""
    balls = [hl.Ball(radius=r, density=2500.0) for r in (5e-4, 1e-3, 7e-4)]
    options = {"restitution": 0.7, "stiffness": 1e5, "wall": wall}
    conversion = hl.convert(balls, code="liggghts", model="hooke-stiffness", **options)
    (line,) = [line for line in conversion.text.splitlines() if " gamman " in line]
    count, *entries = line.partition("peratomtypepair")[2].split()
    types = 3 + wall
    assert int(count) == types and len(entries) == types**2
    matrix = np.array(entries, dtype=float).reshape(types, types)
    np.testing.assert_array_equal(matrix, matrix.T)
    assert (f"primitive type {types} zplane" in conversion.text) == wall and (
        "wall/gran" in conversion.text
    ) == wall
    for row in conversion.models[0].contacts:
        first, second = row.pair.replace("wall", "4").split(" – ")
        assert matrix[int(first) - 1, int(second) - 1] == pytest.approx(row.numbers["damping"], rel=1e-11)
    text = hl.convert(balls, code="yade", model="viscel-tc-en", **options).text
    triples = re.findall(r"\((\d), (\d), ([\d.e-]+)\)", text.partition("Phys(tc=")[2].partition("en=")[0])
    assert [(int(i), int(j)) for i, j, _ in triples] == [
        (i, j) for i in range(types) for j in range(i, types)
    ]
    # Where a number that the code has only once would have to differ, they remain a choice.
    assert "choose" in hl.convert(balls, code="liggghts", model="hooke", **options).text


@pytest.mark.parametrize(
    "name,text,line",
    [
        ("liggghts", "model hooke/stiffness \nfix a all property/global kn peratomtypepair 2 1e5 1e5 1e5 2e5\n"
         "fix b all property/global gamman peratomtypepair 2 9. 9. 9. 9.",
         "contact: missing, must be one of 1-1, 1-2, 2-2, which have different forces in the input"),
        ("liggghts", "model hertz \nfix a all property/global youngsModulus peratomtype 1e9 2e9\n"
         "fix b all property/global poissonsRatio peratomtype 0.3 0.3\n"
         "fix c all property/global coefficientRestitution peratomtypepair 2 .7 .7 .7 .7",
         "contact: missing, must be one of 1-1, 1-2, 2-2"),
        ("lammps", "pair_coeff 1 1 hooke 1e5 0.01 damping velocity\npair_coeff 1 2 hooke 1e5 0.02 damping velocity",
         "contact: missing, must be one of 1-1, 1-2"),
    ],
)  # fmt: skip
def test_an_input_of_several_contacts_is_not_taken_for_its_first(name, text, line):
    with pytest.raises(ValueError) as caught:
        hl.convert_back(text, BALL, code=name)
    assert str(caught.value).startswith(line)
    same = re.sub("2e9|2e5", lambda x: x[0].replace("2", "1"), text).replace("0.02", "0.01")
    assert hl.convert_back(same, BALL, code=name).restitution > 0.5


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_mfix_counts_pairs_row_by_row(count):
    """One number for each pair of solids, of the upper triangle: 11, 12, …, 22, 23, …"""
    balls = [hl.Ball(radius=r, density=2500.0) for r in np.linspace(5e-4, 1e-3, count)]
    text = hl.convert(balls, restitution=0.7, stiffness=1e5, code="mfix", wall=False).text
    entries = [int(x) for x in re.findall(r"DES_EN_INPUT\((\d+)\)", text)]
    assert entries == list(range(1, count * (count + 1) // 2 + 1))


@pytest.mark.parametrize("name,model", [("chrono", "hooke-coefficients"), ("yade", "viscel")])
def test_numbers_that_hold_for_all_contacts_are_given_for_one(name, model):
    """Two sizes need different ones: the input has those of the first, and the others as comments."""
    balls = [hl.Ball(radius=r, density=2500.0) for r in (5e-4, 1e-3)]
    conversion = hl.convert(balls, restitution=0.7, stiffness=1e5, code=name, model=model)
    live = [line for line in conversion.text.splitlines() if not line.startswith(("#", "//"))]
    assert f"{conversion.models[0].contacts[0].numbers['damping']:.12g}" in "\n".join(live)
    assert f"{conversion.models[0].contacts[1].numbers['damping']:.12g}" not in "\n".join(live)
    alike = hl.convert(balls, restitution=0.7, code="liggghts", model="hertz", **STEEL)
    assert "choose" not in alike.text and "choose" in conversion.text


# --- ways to give the stiffness -----------------------------------------------------------------------------


@draws(15)
@given(restitution=st.floats(0.01, 1.0), law=st.sampled_from(sorted(LAWS)), wanted=log_floats(1e-8, 1e-3))
def test_duration_and_compression_are_met(restitution, law, wanted):
    """Of every contact; a coarse step, of which nothing is asked here."""
    options = {"restitution": restitution, "law": law, "code": "lammps", "speed": 0.3}
    for name, step in (("duration", 0.05 * wanted), ("compression", 0.3 * wanted)):
        conversion = hl.convert(BALL, time_step=step, **options, **{name: wanted})
        for contact in conversion.contacts:
            assert getattr(contact, name) == pytest.approx(wanted, rel=1e-9)


def test_a_modulus_makes_a_spring_that_goes_as_deep():
    """The linear spring of a modulus is compressed as far as the Hertz contact, undamped, at that speed."""
    options = {"restitution": 1.0, "speed": 0.7, "code": "lammps", **STEEL}
    linear, hertz = (hl.convert(BALL, law=law, **options).contacts for law in ("linear", "tsuji"))
    for shallow, other in zip(linear, hertz, strict=True):
        assert shallow.compression == pytest.approx(other.compression, rel=1e-10)


@pytest.mark.parametrize("name", ["hooke-restitution", "hooke-velocity"])
def test_the_time_step_makes_the_error_that_is_said(name):
    conversion = hl.convert(
        BALL, restitution=0.6, stiffness=1e5, code="lammps", model=name, restitution_error=5e-3, wall=False
    )
    step = conversion.models[0].contacts[0].time_step
    for factor, holds in ((1.0, True), (2.0, False)):
        again = hl.convert_back(conversion.text, BALL, code="lammps", time_step=factor * step)
        assert (again.restitution_error <= 5e-3) == holds


# --- what is printed --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", ["gran-hooke", "gran-hertz"])
def test_the_wall_of_gran_styles_is_live(model):
    """Pairs and walls have numbers of their own: a grain that falls meets the wall."""
    source = code("lammps").model(model)
    options = {"stiffness": 1e5} if source.elastic == "hooke" else {"duration": 1e-5, "law": "viscoelastic"}
    conversion = hl.convert(BALL, restitution=0.7, code="lammps", model=model, **options)
    live = [line for line in conversion.text.splitlines() if not line.startswith("#")]
    assert any(line.startswith("pair_style gran/") for line in live)
    assert any(line.startswith("fix floor1 type1 wall/gran") for line in live)
    for other in (None, hl.FLOOR):
        assert hl.convert_back(conversion.text, BALL, other, code="lammps").restitution == pytest.approx(
            0.7, abs=1e-9
        )


@pytest.mark.parametrize("balls", [[BALL], BED])
def test_the_wall_itself_is_never_a_comment(balls):
    """Whatever numbers are to be chosen, of every code that writes a wall."""
    for name in ("lammps", "liggghts"):
        for model in code(name).models:
            options = {"stiffness": 1e5} if model.elastic == "hooke" else {**STEEL}
            text = hl.convert(
                balls, restitution=0.7, code=name, model=model.name, restitution_error=0.05, **options
            ).text
            walls = [line for line in text.splitlines() if "wall/gran" in line]
            assert walls and not any(line.startswith("#") for line in walls)


def test_liggghts_is_told_of_hard_and_soft_particles():
    """It refuses Young's moduli above 1e9 and below 5e6 Pa without a command."""
    for modulus, line in ((2.1e11, "hard_particles yes"), (1e8, ""), (1e6, "soft_particles yes")):
        conversion = hl.convert(
            BALL, restitution=0.7, code="liggghts", model="hertz", youngs_modulus=modulus, poisson_ratio=0.3
        )
        said = [x for x in conversion.text.splitlines() if x.endswith("_particles yes")]
        assert said == ([line] if line else [])
    slack = hl.convert(BALL, restitution=0.02, code="liggghts", model="hertz", **STEEL).models[0].contacts[0]
    assert slack.numbers is None and math.isnan(slack.restitution)  # coefficientRestitution must exceed 0.05


def test_mujoco_refuses_grains_that_are_too_light():
    """Inertia below mjMINVAL, with the reason; a table of all codes leaves it out."""
    light, heavy = hl.Ball(radius=1e-4, density=7850.0), hl.Ball(radius=2e-4, density=7850.0)
    why = r"^radius \| mass: got a ball with a moment of inertia of 1\.32e-16 kg m², must be > 1e-15 kg m² in MuJoCo"
    with pytest.raises(ValueError, match=why):
        hl.convert([heavy, light], restitution=0.7, stiffness=1e3, code="mujoco")
    assert hl.convert(heavy, restitution=0.7, stiffness=1e3, code="mujoco").text
    codes = {model.code.name for model in hl.convert(light, restitution=0.7, stiffness=1e3).models}
    assert "mujoco" not in codes and "lammps" in codes


# --- the step that is printed -----------------------------------------------------------------------------------


@draws(20)
@given(
    powers=st.sampled_from([(4, 0), (4, 2), (6, 0), (6, 1), (6, 2)]),
    attracts=st.booleans(),
    restitution=st.floats(0.02, 0.999),
    error=log_floats(3e-4, 3e-2),
    share=st.sampled_from([1.0, 1.0, 0.97, 0.93, 0.9]),
)
def test_the_step_keeps_to_its_error_wherever_bodies_touch(powers, attracts, restitution, error, share):
    """At 1500 places between two steps, and with somewhat finer steps too."""
    form = Powers(*powers, attracts)
    force = Force(form, 1.0, damping_for(form, restitution), 1.0)
    step = share * integration_error.longest_step(force, 1.0, error)
    steps = force.collision(1.0).duration / step
    if steps < 1500.0:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(integration_error, "PHASES", (np.arange(1500) + 0.5) / 1500)
            assert integration_error.restitution_error(force, 1.0, step) <= error


@draws(20)
@given(step=st.floats(1e-9, 1e-3))
def test_the_step_is_not_rounded_up(step):
    source = code("lammps").model("hooke-velocity")
    pair = Pair("1 – 1", BALL.mass, BALL.radius, False)
    text = texts.written(code("lammps"), source, [(pair, {"stiffness": 1e5, "damping": 1.0})], False, step)
    said = float(text.splitlines()[-1].split()[1])
    assert 0.998 * step <= said <= step


# --- bad input ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "changed,line",
    [
        ({"restitution": 1.2}, "restitution: got 1.2, must be in [0.001, 1]"),
        ({"restitution": 0.0}, "restitution: got 0, must be in [0.001, 1]"),
        ({"speed": 0.0}, "speed: got 0, must be in (1e-100, 1e+100)"),
        (
            {"stiffness": None},
            "stiffness | youngs_modulus | duration | compression: got none, must be exactly one of them",
        ),
        (
            {"duration": 1e-5},
            "stiffness | youngs_modulus | duration | compression: got stiffness and duration, "
            "must be exactly one of them",
        ),
        ({"stiffness": -1.0}, "stiffness: got -1, must be > 0 and finite"),
        ({"stiffness": 1e-308}, "stiffness: got 1e-308, must give contacts with compressions [m]"),
        ({"stiffness": 1.7e308}, "stiffness: got 1.7e+308, must give contacts with"),
        ({"stiffness": None, "duration": 1e-300}, "duration: got 1e-300, must give contacts with"),
        ({"stiffness": None, "duration": 1e154}, "duration: got 1e+154, must give contacts with"),
        ({"stiffness": None, "youngs_modulus": 1e-308, "poisson_ratio": 0.3}, "youngs_modulus: got 1e-308"),
        ({"law": "hooke"}, "law: got 'hooke', must be one of linear, viscoelastic, tsuji"),
        (
            {"law": "tsuji"},
            "stiffness: got it with the law tsuji, must be youngs_modulus, duration or compression",
        ),
        ({"stiffness": None, "youngs_modulus": 1e9}, "poisson_ratio: missing, must be in (-1, 0.5]"),
        ({"code": "edem"}, "code: got 'edem', must be one of chrono, kratos, lammps"),
        ({"model": "hertz"}, "code: missing, must be given beside model"),
        ({"code": "yade", "model": "x"}, "model: got 'x', must be one of viscel, viscel-tc-en"),
        ({"code": "mfix", "model": "hertzian"}, "model: got 'hertzian', must have the elastic force"),
        (
            {"code": "kratos", "law": "viscoelastic", "stiffness": None, "duration": 1e-5},
            "code: got 'kratos'",
        ),
        ({"restitution_error": 1e-3, "time_step": 1e-6}, "restitution_error | time_step: got both"),
        ({"restitution_error": 0.5}, "restitution_error: got 0.5, must be in [1e-09, 0.05]"),
        ({"balls": []}, "balls: got 0, must be 1 to 30"),
        ({"balls": [3]}, "balls[0]: got 3, must be a Ball"),
    ],
)
def test_bad_input_is_refused_in_one_line(changed, line):
    with pytest.raises(ValueError) as caught:
        hl.convert(**{"balls": BALL, "restitution": 0.7, "stiffness": 1e5, **changed})
    assert str(caught.value).startswith(line) and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "text,line",
    [
        ("", "input: has no granular contacts"),
        (3, "input: got 3, must be a text"),
        ("hooke 1e5 1.7 damping coeff_restitution", "input: line 1: restitution: got 1.7, must be in (0, 1]"),
        ("hooke 0 0.7 damping coeff_restitution", "input: line 1: stiffness: got 0, must be > 0 and finite"),
        (
            "hooke 1 0.7 damping coeff_restitution\nhertz/material 1 .7 .3 damping tsuji",
            "input: line 2: got 'hertz/material 1 .7 .3 damping tsuji', must be the model on line 1",
        ),
    ],
)
def test_bad_text_is_refused_in_one_line(text, line):
    with pytest.raises(ValueError) as caught:
        hl.convert_back(text, BALL, code="lammps")
    assert str(caught.value).startswith(line)


@pytest.mark.parametrize(
    "ball,wanted",
    [
        (hl.Ball(2e-7, mass=2e39), {"restitution": 0.5, "duration": 3.5e-29, "speed": 5e22}),
        (
            hl.Ball(4.9e-11, mass=7.3e-29),
            {"restitution": 1.0, "duration": 2.2e25, "speed": 1.6e-49, "law": "linear"},
        ),
    ],
)
def test_numbers_beyond_double_precision_are_not_given_to_a_code(ball, wanted):
    hooke, coefficients = hl.convert(ball, **wanted, code="chrono", wall=False).models
    assert hooke.contacts[0].numbers is None and not hooke.text
    assert coefficients.contacts[0].restitution == pytest.approx(wanted["restitution"], abs=1e-6)


def test_contacts_beyond_double_precision_are_refused_in_one_line():
    line = r"^input: got contact_time [^\n]*, must give a compression and a duration within"
    with pytest.raises(ValueError, match=line):
        hl.convert_back("ViscElMat(tc=4e170, en=1., et=1.)", BALL, code="yade")


@draws(30)
@given(text=st.text(max_size=200))
def test_any_text_is_read_or_refused(text):
    for name in CODES:
        with pytest.raises(ValueError, match=r"^input: (has no granular contacts|line \d+: got)[^\n]*$"):
            hl.convert_back(text, BALL, code=name)


@draws(15)
@given(
    words=st.sampled_from(["velocity", "velocity limit_damping", "viscoelastic limit_damping"]),
    stiffness=log_floats(1e-8, 1e14),
    damping=st.one_of(st.just(0.0), log_floats(1e-12, 1e16)),
    speed=log_floats(1e-6, 1e3),
)
def test_any_numbers_give_a_collision(words, stiffness, damping, speed):
    text = f"hertz/material {stiffness!r} {damping!r} 0.3 damping {words}"
    obtained = hl.convert_back(text, BALL, code="lammps", speed=speed, time_step=1e-6)
    assert 0.0 <= obtained.restitution <= 1.0 + 1e-12 and obtained.force > 0.0 and obtained.compression > 0.0
    assert (obtained.duration == math.inf) == (obtained.restitution == 0.0)


# --- by running the codes -----------------------------------------------------------------------------------


def pair_of(row):
    """The contact of a run: of the smaller balls, or of a bed such as ``bed, 1 – 2``."""
    wall = row["contact"].endswith("wall")
    sizes = [5e-4, 1e-3]
    ends = [sizes[int(x) - 1] for x in re.findall(r"\d", row["contact"])] or [5e-4]
    balls = [hl.Ball(radius, density=7850.0) for radius in (ends * 2)[:2]]
    if wall:
        return Pair("", balls[0].mass, balls[0].radius, True)
    return Pair(
        "",
        _core.effective(*(b.mass for b in balls)),
        _core.effective(*(b.radius for b in balls)),
        False,
    )


@pytest.mark.parametrize("every", [16, slow(1)])
def test_what_the_codes_made_of_their_numbers(every):
    """LIGGGHTS, YADE, Kratos and MuJoCo, run by tools/verify_codes.py, within the error of their step: ε, duration."""
    for row in RUNS[::every]:
        source = code(row["code"])
        assert row["version"] == source.version
        speed, step = float(row["speed"]), float(row["time_step"])
        written = Written(source.model(row["model"]), pair_of(row), speed, row["attraction"] == "1")
        force = written.force(json.loads(row["numbers"]))
        said = force.collision(speed)
        error = force.error_of_step(speed, step)
        assert error < 1.5e-3
        assert float(row["restitution"]) == pytest.approx(said.restitution, abs=1.1 * error + 2e-6), row
        # ε says nothing of the stiffness where the damping follows from both; the duration does.
        assert float(row["duration"]) == pytest.approx(said.duration, abs=1.5 * step), row
        if row["contact"].startswith("bed"):  # one input for all its contacts, and what was wanted in each
            assert said.restitution == pytest.approx(0.7, abs=1e-9)


def test_every_model_was_run_with_pairs_and_walls():
    ran = {(row["code"], row["model"], row["contact"]) for row in RUNS}
    codes = [code(name) for name in ("kratos", "liggghts", "mujoco", "yade")]
    beds = ["bed, 1 – 1", "bed, 1 – 2", "bed, 2 – 2", "bed, 1 – wall", "bed, 2 – wall"]
    assert ran == {
        (c.name, m.name, contact)
        for c in codes
        for m in c.models
        if m.checked != "source"
        for contact in ("pair", "wall", *(beds if m.input.matrix else []))
    }


def lammps_lines(row, model, speed, time_step, wall):
    """An input of two spheres, or of one and a wall."""
    half = 20.0 * BALL.radius
    gap = 3.4 * time_step * speed
    text = texts.written(
        code("lammps"), model, [(row.pair, row.numbers)], row.attraction, time_step
    ).splitlines()
    lines = [
        "units si",
        "atom_style sphere",
        "boundary f f f",
        "comm_modify vel yes",
        "atom_modify map array",
    ]
    lines += [f"region box block {-half} {half} {-half} {half} {-half} {half}", "create_box 1 box"]
    lines += ["neighbor 0.0005 bin", "neigh_modify delay 0"]
    if wall:
        lines += ["pair_style zero 0.002", "pair_coeff * *"]
        lines += [f"create_atoms 1 single 0 0 {BALL.radius + gap!r}"]
        lines += [f"set atom 1 diameter {2 * BALL.radius} density {BALL.density} vz {-speed!r}"]
        lines += [line for line in text if line.startswith(("group", "fix", "timestep"))]
        lines += [f"variable v equal vz[1]/{speed}"]
    else:
        lines += ["create_atoms 1 single 0 0 0", f"create_atoms 1 single {2 * BALL.radius + gap!r} 0 0"]
        lines += [f"set atom {i} diameter {2 * BALL.radius} density {BALL.density}" for i in (1, 2)]
        lines += [f"set atom {i} vx {sign * 0.5 * speed!r}" for i, sign in ((1, 1), (2, -1))]
        lines += text
        lines += [f"variable v equal (vx[2]-vx[1])/{speed}"]
    return [*lines, "fix move all nve/sphere", "thermo_style custom step v_v"]


def lammps_cases():
    """All models with a pair and a wall; only two of them where tests are fast."""
    every = [(model.name, wall) for model in code("lammps").models for wall in (False, True)]
    fast = [("hooke-restitution", False), ("hertz-tsuji", True)]
    return [case if case in fast else pytest.param(*case, marks=pytest.mark.slow) for case in every]


class Row:
    """What one run needs."""

    def __init__(self, pair, numbers, attraction):
        self.pair, self.numbers, self.attraction = pair, numbers, attraction


@pytest.mark.skipif(bool(MISSING), reason=MISSING)
@pytest.mark.parametrize("name,wall", lammps_cases())
def test_lammps_does_what_is_said(name, wall, tmp_path):
    """The input as we write it, over ε and speed, clipped and not, within the error of the step."""
    model = code("lammps").model(name)
    mass, radius = (x if wall else 0.5 * x for x in (BALL.mass, BALL.radius))
    pair = Pair("", mass, radius, wall)
    stiffness = 1e4 if model.elastic == "hooke" else 1.5e8 * math.sqrt(radius)
    lmp = program.find(1)
    for restitution, speed, attraction in ((0.7, 1.0, False), (0.3, 0.1, True), (0.95, 3.0, True)):
        written = Written(model, pair, speed, attraction, 0.3)
        numbers = written.usual_numbers(stiffness, restitution) or written.numbers(stiffness, restitution)
        force = written.force(numbers)
        collision = force.collision(speed)
        step = collision.duration / 500.0
        lines = lammps_lines(Row(pair, numbers, attraction), model, speed, step, wall)
        lines += ["run 900", 'print "RESULT ${v}"']
        (tmp_path / "in.two").write_text("\n".join(lines) + "\n")
        command = lmp.command(1, "-in", "in.two", "-log", "none")
        done = subprocess.run(command, cwd=tmp_path, env=lmp.environment(), capture_output=True, text=True)
        said = [line for line in done.stdout.splitlines() if line.startswith("RESULT")]
        assert said, done.stdout[-500:]
        error = force.error_of_step(speed, step)
        assert abs(float(said[0].split()[1])) == pytest.approx(collision.restitution, abs=1.1 * error + 2e-6)


# --- the command line ---------------------------------------------------------------------------------------


def run(*arguments, **more):
    return CliRunner().invoke(main, ["convert", *arguments], **more)


BALLS = ("--radius", "0.5mm", "--density", "7850")


def test_the_command_line_says_what_the_function_says():
    arguments = ("--restitution", "0.7", "--stiffness", "100kN/m", "--code", "lammps", "--json")
    said = json.loads(run(*BALLS, *arguments).stdout)
    conversion = hl.convert(
        [hl.Ball(radius=5e-4, density=7850.0)], restitution=0.7, stiffness=1e5, code="lammps"
    )
    assert said == json.loads(json.dumps(conversion.to_dict()))


@pytest.mark.parametrize("width", ["80", slow("120")])
def test_the_tables_fit(width, monkeypatch):
    monkeypatch.setenv("COLUMNS", width)
    for more in ((), ("--code", "yade")):
        out = run(*BALLS, "--restitution", "0.7", "--stiffness", "1e5", *more)
        assert out.exit_code == 0
        told = [line for line in out.stdout.splitlines() if "(" not in line and "=" not in line]
        assert max(map(len, told)) <= int(width)
        assert "0.7182" in out.stdout


def test_input_is_read_from_the_command_line_a_file_and_standard_input(tmp_path):
    line = "pair_coeff * * hooke 1e5 0.7 damping coeff_restitution limit_damping"
    path = tmp_path / "in.bed"
    path.write_text(f"units si\n{line}\n")
    ways = (("--input", line), ("--read", str(path)), ("--input", "-"))
    for way in ways:
        out = run(*BALLS, "--code", "lammps", *way, "--json", input=line)
        assert json.loads(out.stdout)["restitution"] == pytest.approx(0.7182, abs=1e-4)
    assert "never attracts" in run(*BALLS, "--code", "lammps", "--input", line).stdout


@pytest.mark.parametrize(
    "arguments,line",
    [
        (("--restitution", "0.7"), "radius: missing, must be given"),
        ((*BALLS,), "restitution: missing, must be given unless there is an input"),
        ((*BALLS, "--restitution", "2", "--stiffness", "1"), "restitution: got 2, must be in [0.001, 1]"),
        ((*BALLS, "--input", "x"), "code: missing, must be one of lammps, liggghts, yade"),
        ((*BALLS, "--input", "x", "--read", "y"), "--input | --read: got both, must be one of them"),
        ((*BALLS, "--read", "no such file", "--code", "yade"), "--read: no such file: no such file"),
        (
            (*BALLS, "--input", "x", "--code", "yade", "--law", "linear"),
            "law: got linear, must be left out with input",
        ),
        (
            ("--radius", "1mm", "--radius", "2mm", "--density", "1", "--density", "2", "--density", "3"),
            "density: got 3",
        ),
    ],
)
def test_bad_options_end_in_one_line(arguments, line):
    out = CliRunner().invoke(main, ["convert", *arguments], standalone_mode=True)
    assert out.exit_code == 2 and line in out.stderr and out.stderr.count("\n") == 1


def documented():
    """The commands of the page, and the restitution that stands behind some of them."""
    page = (DATA.parents[1] / "docs" / "convert.md").read_text("utf-8").replace("\\\n", " ")
    lines = [line for line in page.splitlines() if line.startswith("hardlimit convert")]
    return [(shlex.split(line, comments=True)[2:], line.rpartition(" # ")[2]) for line in lines]


def test_the_commands_of_the_page_run():
    told = 0
    assert len(documented()) > 12
    for arguments, said in documented():
        out = run(*arguments, "--json")
        assert out.exit_code == 0, (arguments, out.output)
        if "--input" in arguments and said.replace(".", "").isdigit():
            assert json.loads(out.stdout)["restitution"] == pytest.approx(float(said), abs=6e-5)
            told += 1
    assert told >= 3


def test_mujoco_has_a_ratio_that_is_that_of_every_mass():
    """Pairs and walls of two sizes; none gives ε = 1, which stiffness and damping do."""
    balls = [hl.Ball(r, density=1000.0) for r in (0.01, 0.005)]
    wanted = {"stiffness": 1e5, "code": "mujoco"}
    conversion = hl.convert(balls, restitution=0.7, model="ratio", **wanted)
    ratios = {round(row.numbers["dampratio"], 9) for row in conversion.models[0].contacts}
    assert len(conversion.models[0].contacts) == 5 and len(ratios) == 1
    assert ratios.pop() == pytest.approx(0.1222, abs=5e-5)
    written = Written(code("mujoco").model("ratio"), Pair("1 – 1", 1.0, 1.0, False), 1.0)
    critical = written.force({"timeconst": 0.02, "dampratio": 1.0}).collision(1.0)
    assert critical.restitution == pytest.approx(math.exp(-2.0), abs=1e-9)
    direct, ratio = hl.convert(BALL, restitution=1.0, **wanted).models
    assert direct.contacts[0].numbers["damping"] == 0.0 and direct.contacts[0].restitution > 1.0 - 1e-12
    assert ratio.contacts[0].numbers is None and math.isnan(ratio.contacts[0].restitution)
    for stiffness, has in ((0.9, True), (1.1, False)):  # of that whose √(m/k) is the shortest
        hard = {**wanted, "stiffness": stiffness * 0.5 * BALL.mass / 3.2e-7**2, "wall": False}
        direct, ratio = hl.convert(BALL, restitution=0.7, **hard).models
        assert direct.contacts[0].numbers is not None and (ratio.contacts[0].numbers is not None) == has


def test_three_balls_of_the_page():
    """MuJoCo's velocities for them are quoted from a run; Newton's equations give those of a small ``solimp``."""
    ball = hl.Ball(0.01, density=1000.0)
    damping = hl.convert(ball, restitution=0.75, stiffness=1e5).contacts[0].damping
    law = hl.LinearDashpot(stiffness=1e5, damping=damping)
    three = hl.newton(hl.Column.cradle([ball] * 3, [1.0, 0.0, 0.0], law)).final_velocities
    np.testing.assert_allclose(three, [-0.051, 0.246, 0.805], atol=5e-4)


def test_numbers_of_the_page():
    """What its sentences say of fits and factors."""
    twice = math.sqrt(2.0) * formulas.tsuji_polynomial(0.7)
    assert _core.power_collision(6, 1, True, twice)[0] == pytest.approx(0.700, abs=1e-3)
    for wanted in np.linspace(0.1, 0.9, 17):
        ratio = math.sqrt(6.0) * formulas.thornton(float(wanted))
        assert _core.power_collision(6, 1, False, ratio)[0] == pytest.approx(wanted, abs=3e-4)
    conversion = hl.convert(BALL, restitution=0.5, code="chrono", model="hertz", **STEEL)
    assert conversion.models[0].contacts[0].numbers["restitution"] == pytest.approx(0.436, abs=1e-3)
