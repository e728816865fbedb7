"""convert with friction: β0 there and back in every model of every code, known facts, what cannot be had, the text, and
the command line. test_friction_runs.py runs the text in the codes."""

import dataclasses
import json
import math
import re
import shlex

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

import hardlimit as hl
from conftest import draws, log_floats, refusal
from hardlimit.cli import main
from hardlimit.contact.friction import FrictionTerms
from hardlimit.convert.codes import code, names
from hardlimit.convert.force import Force, Powers, damping_for
from hardlimit.convert.friction import KAPPA, merged, restitution_of, solve_ratio
from hardlimit.convert.tangential import models_of

BALL = hl.Ball(radius=5e-4, density=2500.0)
STIFF = {"hooke": {"stiffness": 1e5}, "hertz": {"youngs_modulus": 1e9, "poisson_ratio": 0.3}}
RUBBING = [(c.name, m.name) for c in map(code, names()) for m in c.models if m.friction]
WALTON = {"friction": 0.5, "tangential_restitution": 0.33}


def converted(name, model, **changes):
    source = code(name).model(model)
    wanted = {"restitution": 1.0 if source.damping.formula == "none" else 0.7, **WALTON, **changes}
    (conversion,) = hl.convert(BALL, code=name, model=model, **STIFF[source.elastic], **wanted).models
    return conversion


# --- a gas --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "restitution,coefficient,ratio,beta",
    [
        (0.9, 0.5, 1.0, 0.959),
        (0.9, 0.5, 2.88, 0.380),
        (0.9, 0.5, 3.15, 0.327),
        (0.9, 0.5, 3.5, 0.268),
        (0.9, 0.1, 2.88, 0.380),
        (0.7, 0.5, 1.0, 0.687),
        (0.7, 0.5, 3.15, 0.355),
    ],
)
def test_a_spring_for_the_tangential_restitution_of_a_gas(restitution, coefficient, ratio, beta):
    """Both ways, unless a stiffer spring has it too. The numbers are those of a program apart from this one."""
    force = Force(Powers(4, 0), 1.0, damping_for(Powers(4, 0), restitution), 1.0)
    terms = FrictionTerms.of_model("spring", "total", coefficient=coefficient, stiffness=ratio / KAPPA)
    assert restitution_of(force, terms, 1.0) == pytest.approx(beta, abs=1.5e-3)
    wanted = {"restitution": restitution, "friction": coefficient, "tangential_restitution": beta}
    (contact,) = hl.convert(BALL, stiffness=1e5, wall=False, code="chrono", **wanted).contacts
    solved = KAPPA * contact.stiffness_ratio
    assert solved == pytest.approx(ratio, abs=0.05) if ratio > 2.0 else solved > 1.05


@draws(20)
@given(
    restitution=st.floats(0.05, 1.0),
    coefficient=log_floats(0.01, 5.0),
    beta=st.floats(-0.95, 0.9),
    law=st.sampled_from(["linear", "tsuji"]),
)
def test_our_own_law_has_the_tangential_restitution(restitution, coefficient, beta, law):
    """With the ratio of stiffnesses that is given; without one, no stiffness has it."""
    wanted = {"restitution": restitution, "friction": coefficient, "tangential_restitution": beta}
    (contact,) = hl.convert(
        BALL, duration=1e-5, law=law, wall=False, code="lammps", model=None, **wanted
    ).contacts
    ratio = contact.stiffness_ratio

    def reached(ratio):
        friction = hl.Friction(coefficient, stiffness_ratio=ratio)
        if law == "linear":
            own = hl.LinearDashpot(stiffness=contact.stiffness, restitution=restitution, friction=friction)
        else:
            own = hl.Tsuji(
                elastic_prefactor=contact.stiffness / math.sqrt(contact.effective_radius),
                restitution=restitution,
                friction=friction,
            )
        return own.between(BALL, BALL).effective_tangential_restitution()

    if math.isnan(ratio):
        assert not any(reached(x) >= beta for x in np.geomspace(0.01, 4.0 / KAPPA, 10))
    else:
        assert reached(ratio) == pytest.approx(beta, abs=2e-5)


def test_the_stiffer_of_two_solutions_is_taken():
    """Up to the ratio 4; below what that gives, and only there, the softer one."""

    def curve(x):
        return 1.0 - (x - 1.0) ** 2 / 10.0 if x > 1.0 else 2.0 * x - 1.0

    assert solve_ratio(curve, 0.5).value == pytest.approx(1.0 + math.sqrt(5.0))
    assert solve_ratio(curve, 0.0).value == pytest.approx(0.5)
    assert solve_ratio(curve, 1.1).value is None
    assert solve_ratio(curve, 0.5).highest == pytest.approx(1.0, abs=1e-3)
    assert merged([(0.0, 0.2), (0.1, 0.4), (0.5, 0.5)]) == ((0.0, 0.4), (0.5, 0.5))


# --- every model of every code ------------------------------------------------------------------------------


@pytest.mark.parametrize("name,model", RUBBING)
@given(
    restitution=st.floats(0.06, 1.0),
    coefficient=log_floats(0.01, 5.0),
    beta=st.floats(-0.98, 1.0),
    nu=st.floats(0.0, 0.5),
    speed=log_floats(0.02, 10.0),
)
@draws(2, 1)
def test_there_and_back(name, model, restitution, coefficient, beta, nu, speed):
    """Numbers give the β0 that is wanted, or it is outside what they can give; ε is as without friction."""
    source = code(name).model(model)
    wanted = {"friction": coefficient, "tangential_restitution": beta, "speed": speed, "poisson_ratio": nu}
    if source.elastic == "hertz":
        wanted |= {"law": "tsuji"}
    wanted["restitution"] = 1.0 if source.damping.formula == "none" else restitution
    options = {**wanted, "duration": 1e-5, "code": name, "model": model}
    (conversion,) = hl.convert(BALL, **options).models
    smooth = hl.convert(BALL, **{**options, "friction": None, "tangential_restitution": None}).models[0]
    for row, without in zip(conversion.contacts, smooth.contacts, strict=True):
        if row.numbers is None:
            continue  # the code cannot have this ε
        assert row.restitution == without.restitution
        if row.friction.numbers is None:
            assert conversion.text.count("\n") == 0 and "no numbers give" in conversion.text
            continue
        assert row.friction.tangential_restitution == pytest.approx(beta, abs=5e-4)
        assert any(low - 1e-3 <= beta <= high + 1e-3 for low, high in row.friction.reachable)
    unreachable = [
        row for row in conversion.contacts
        if row.friction and not any(low <= beta <= high for low, high in row.friction.reachable)
    ]  # fmt: skip
    if conversion.friction is None and any(row.numbers for row in conversion.contacts):
        assert unreachable or len(code(name).model(model).friction) > 1


@pytest.mark.parametrize("name,model", RUBBING)
def test_the_text_is_read_back(name, model):
    """By convert_back: μ, β0, and the same model; each number stands in the text."""
    wanted = 0.29571172073 if (name, model) == ("liggghts", "hooke") else 0.33
    for wall in (False, True):
        source = code(name).model(model)
        conversion = converted(name, model, tangential_restitution=wanted)
        row = conversion.contacts[1 if wall else 0]
        live = [line for line in conversion.text.splitlines() if not line.startswith("#")]
        for key, value in row.friction.numbers.items():
            if value and key not in ("tangential_damping", "ktToKnUser", "coefficient"):
                assert f"{value:.12g}" in "\n".join(live) or source.input.shared, (key, value)
        if name == "yade" and wall:
            continue  # the text has the numbers of one contact, or of pairs of materials
        ends = f"1-{2 if wall else 1}" if model == "viscel-tc-en" else f"1-{'wall' if wall else 1}"
        choose = "types 1 to" in conversion.text
        other = hl.FLOOR if wall else None
        named = {"code": name, "contact": ends if choose else None, "time_step": row.time_step}
        back = hl.convert_back(conversion.text, BALL, other, **named)
        assert back.friction.coefficient == pytest.approx(0.5, rel=1e-9)
        assert back.friction.effective_tangential_restitution == pytest.approx(wanted, abs=5e-4)
        error = back.friction.tangential_restitution_error_of_step
        if not (wall and "choose those of one" in conversion.text):
            assert row.friction.error_of_step == pytest.approx(error, rel=1e-3) and 1e-4 < error < 0.2
        angles = dict(back.friction.tangential_restitution)
        assert len(angles) == 18 and back.to_dict()["friction"]["coefficient"] == back.friction.coefficient
        law = back.friction.model
        assert law == row.friction.model or model.startswith("gran-")


def test_ways_to_give_friction_are_complete():
    """Their models exist, their texts occur in each input, and nothing of the smooth input is left."""
    for source in map(code, names()):
        ways = {way.name: way for way in source.friction}
        assert len(ways) == len(source.friction)
        assert {name for model in source.models for name in model.friction} == set(ways)
        for way in source.friction:
            form = models_of(source.name)[way.model]
            assert set(way.numbers) <= set(form.numbers)
            assert way.free in ("", "poisson_ratio", *form.numbers)
        for model in source.models:
            text = "\n".join(getattr(model.input, part) for part in ("head", "pair", "wall", "matrix"))
            for way in (ways[name] for name in model.friction):
                assert any(smooth in text for smooth in way.words), (model.name, way.name)
                rough = text
                for smooth, words in way.words.items():
                    rough = rough.replace(smooth, words)
                assert "frictionAngle=0.0" not in rough and "linear_nohistory" not in rough
                assert "{friction}" in rough or "{friction_angle}" in rough


def test_codes_without_known_friction_say_so():
    conversion = hl.convert(BALL, restitution=0.7, stiffness=1e5, code="mercurydpm", **WALTON)
    for model in conversion.models:
        assert "how this code computes friction is not known here" in model.text
        assert model.text.count("\n") == 0 and all(row.friction is None for row in model.contacts)


# --- known facts --------------------------------------------------------------------------------------------


def test_the_default_of_lammps_is_a_superball():
    """k_t NULL = 2/7 k_n: ρ = 1, β0 = 1 for every μ without damping."""
    for coefficient in (0.1, 0.5, 2.0):
        conversion = converted("lammps", "gran-hooke", restitution=1.0, friction=coefficient)
        for row in conversion.contacts:
            assert row.friction.usual_tangential_restitution == pytest.approx(1.0, abs=1e-6)
    damped = converted("lammps", "gran-hooke", restitution=0.7).contacts[0].friction
    assert 0.5 < damped.usual_tangential_restitution < 0.56  # γ_t NULL = γ_n/2


def test_walls_of_gran_styles_leave_out_the_styles_with_an_error():
    """fix wall/gran hooke/history of LAMMPS 2023 to 2026 takes another k_t."""
    for model in ("gran-hooke", "gran-hertz"):
        lines = converted("lammps", model).text.splitlines()
        assert [line for line in lines if line.startswith("pair_style gran/")]
        (wall,) = [line for line in lines if "wall/gran" in line]
        assert "wall/gran granular" in wall and "/history " not in wall.partition("tangential")[0]


def test_hooke_of_liggghts_has_four_values():
    """k_t is k_n, or 2/7 of it; the damping is that of the normal force, or off."""
    friction = converted("liggghts", "hooke").contacts[0].friction
    assert friction.numbers is None and math.isnan(friction.tangential_restitution)
    values = [low for low, high in friction.reachable if low == high]
    assert len(values) == 4 and values[0] == friction.usual_tangential_restitution  # k_t = k_n, damped
    undamped = [min(values, key=lambda x: abs(x - beta)) for beta in (0.2957, 0.6874)]
    assert undamped == pytest.approx([0.2957, 0.6874], abs=1e-4)
    text = converted("liggghts", "hooke").text
    assert "no numbers give 1 – 1 a tangential restitution of 0.33, only 0.1" in text
    assert "tangential_damping off" in converted("liggghts", "hooke", tangential_restitution=undamped[0]).text


def test_the_modulus_follows_where_poissons_ratio_is_free():
    """LIGGGHTS' and YADE's Hertz contacts have no other number: the normal force stays."""
    for name, model in (("liggghts", "hertz"), ("yade", "hertz-en")):
        numbers = [
            converted(name, model, tangential_restitution=beta).contacts[0].numbers for beta in (0.32, 0.36)
        ]
        ratios = [row["poisson_ratio"] for row in numbers]
        assert ratios[0] != ratios[1] and all(0.0 <= nu <= 0.5 for nu in ratios)
        plane = [row["youngs_modulus"] / (1.0 - row["poisson_ratio"] ** 2) for row in numbers]
        assert plane[0] == pytest.approx(plane[1], rel=1e-9) == pytest.approx(1e9 / 0.91, rel=1e-9)


def test_pairs_of_a_bed_have_the_same_friction():
    """k_t/k_n is that of all, since β0 depends on ratios; the matrix over types has μ for each pair."""
    balls = [hl.Ball(radius=r, density=2500.0) for r in (5e-4, 1e-3)]
    conversion = hl.convert(
        balls, restitution=0.7, stiffness=1e5, code="liggghts", model="hooke-stiffness", **WALTON
    )
    rows = conversion.models[0].contacts
    assert len({row.friction.numbers["stiffness"] for row in rows}) == 1
    (line,) = [line for line in conversion.text.splitlines() if "coefficientFriction" in line]
    assert line.partition("peratomtypepair")[2].split() == ["3", *["0.5"] * 9]


# --- bad input, and the command line ------------------------------------------------------------------------


@pytest.mark.parametrize(
    "changed,line",
    [
        ({"friction": None}, "friction: missing, must be > 0 and finite beside tangential_restitution"),
        (
            {"tangential_restitution": None},
            "tangential_restitution: missing, must be in (-1, 1] beside friction",
        ),
        ({"friction": 0.0}, "friction: got 0, must be > 0"),
        ({"friction": math.inf}, "friction: got inf, must be > 0"),
        ({"tangential_restitution": -1.0}, "tangential_restitution: got -1, must be in (-1, 1]"),
        ({"tangential_restitution": 1.1}, "tangential_restitution: got 1.1, must be in (-1, 1]"),
    ],
)
def test_bad_friction_is_refused(changed, line):
    message = refusal(lambda: hl.convert(BALL, restitution=0.7, stiffness=1e5, **{**WALTON, **changed}))
    assert message.startswith(line)


def test_hollow_balls_are_refused():
    """Particle codes have solid ones; without friction that is the same."""
    shell = hl.Ball(radius=5e-4, density=2500.0, inertia_factor=2.0 / 3.0)
    message = refusal(lambda: hl.convert(shell, restitution=0.7, stiffness=1e5, code="lammps", **WALTON))
    assert message.startswith("balls: got one with inertia_factor 0.666667, must be 0.4 with friction")
    assert hl.convert(shell, restitution=0.7, stiffness=1e5, code="lammps").text


def run(*arguments):
    return CliRunner().invoke(main, ["convert", "--radius", "0.5mm", "--density", "2500", *arguments])


ASKED = shlex.split("--restitution 0.7 --stiffness 1e5 --friction 0.5 --tangential-restitution 0.33")


def test_the_command_line_says_what_the_function_says():
    out = run(*ASKED, "--code", "lammps", "--json")
    conversion = hl.convert([BALL], restitution=0.7, stiffness=1e5, code="lammps", **WALTON)
    assert json.loads(out.stdout) == json.loads(json.dumps(conversion.to_dict()).replace("NaN", "null"))
    assert dataclasses.asdict(conversion.models[0].contacts[0])["friction"]["numbers"]["coefficient"] == 0.5


def test_one_code_computes():
    out = run(*ASKED, "--code", "mfix").stdout
    assert "How MFiX computes friction is not known here" in " ".join(out.split())


def test_tables_of_friction(monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    text = run(*ASKED).stdout
    assert re.search(r"lammps gran-hooke +all +0\.52\d +k_t 94009 +0\.33\n", text)
    assert re.search(r"liggghts hooke +all +0\.\d+ +impossible +–\n", text)
    assert "k_t/k_n = 0.9401" in " ".join(text.split()) and "How Chrono, Kratos" in " ".join(text.split())
    text = run(*ASKED, "--code", "yade", "--model", "viscel").stdout
    assert "Friction: ViscElPhys" in text and "−1 to 0.84" in text
    assert "Δβ: largest error of β by the time step." in " ".join(text.split())
    assert "Friction: no numbers have this β0" in run(*ASKED, "--code", "liggghts", "--model", "hooke").stdout


def test_an_input_with_friction_is_shown_with_its_angles():
    line = "pair_coeff * * hooke 1e5 0.7 damping coeff_restitution tangential linear_history 9e4 0 0.5 limit_damping"
    text = run("--code", "lammps", "--input", line).stdout
    back = hl.convert_back(line, BALL, code="lammps").friction
    assert "Friction: μ 0.5: sticks below" in " ".join(text.split())
    assert re.search(rf"β0 in a gas +{back.effective_tangential_restitution:.4g}\n", text)
    assert re.search(r"β near head-on +−0\.\d+\nβ at 30° ", text)
    assert text.count("near head-on") == 1
    smooth = hl.convert_back(line.replace(" 0.5 limit", " 0.0 limit"), BALL, code="lammps").friction
    assert smooth.coefficient == 0.0 and smooth.tangential_restitution == ()
