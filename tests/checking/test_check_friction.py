"""What check says of friction: numbers of each contact, the error of the time step, words, traps."""

import json
import math
import re
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hardlimit as hl
from command_line import printed, refused, run
from conftest import draws, log_floats, slow
from hardlimit.boxes.lammps import integration_error, program
from hardlimit.checking import cases, friction
from hardlimit.checking.contacts import CheckedContact, KnownBody
from hardlimit.checking.friction import CheckedFriction
from hardlimit.checking.friction_words import TRAPS, words
from hardlimit.checking.scripts import read
from hardlimit.contact import frictional_contact
from hardlimit.contact.friction import LIMITS, MODELS, FrictionTerms
from hardlimit.contact.impact import FrictionalContact, tangential_restitution
from hardlimit.convert.codes import code
from hardlimit.convert.force import Force, Powers

BALL = hl.Ball(1e-3, density=2500.0)
#: A box of equal spheres in LAMMPS, with the words of the contact.
LAMMPS = """units si
atom_style sphere
region box block 0 0.1 0 0.1 0 0.1
create_box 1 box
pair_style granular
pair_coeff * * {}
create_atoms 1 random 10 1 box
set type 1 diameter 0.002 density 2500
fix move all nve/sphere
timestep 1e-6
run 1
"""
LINE = "hooke 1e5 0.8 damping coeff_restitution tangential linear_history 9e4 0 0.5"
STIFF = {"stiffness": 1e5, "restitution": 1.0}


def checked(mu=0.5, law=STIFF, **options):
    """The check of a ball under the linear law."""
    law = hl.LinearDashpot(**law, friction=hl.Friction(mu, **options))
    return hl.check(BALL, law=law, speed=0.3, time_step=1e-6)


def said(verdict) -> str:
    return " ".join(finding.what for finding in verdict.warnings)


# --- numbers and words ----------------------------------------------------------------------------------------


def test_one_line_says_it_all() -> None:
    row = checked(stiffness_ratio=0.9).rows[0]
    assert words([row.friction]) == (
        "μ 0.5: sticks below 29°, slides beyond 71°; β −0.76 near head-on, +0.42 at 60°, 0.32 in a gas; "
        "tangential half period 0.56 t_c, 12 steps"
    )
    assert row.friction.steps_per_half_period == math.floor(row.friction.half_period * row.duration / 1e-6)
    assert 0.0 < row.friction.tangential_restitution_error_of_step < 0.2


def test_numbers_are_those_of_the_contact() -> None:
    """At both ends of sizes and speeds, with the moments of inertia of the bodies."""
    law = hl.Tsuji(
        youngs_modulus=1e8, poisson_ratio=0.3, restitution=0.8, friction=hl.Friction(0.3, damping_ratio=0.5)
    )
    hollow = hl.Ball(1e-3, density=2500.0, inertia_factor=2 / 3)
    for row in hl.check(hollow, law=law, speed=(0.1, 1.0)).rows:
        contact = law.between(*[hollow] * (1 if row.types[1] == "wall" else 2))
        numbers = row.friction
        assert numbers.model == "mindlin_rescale" and numbers.limit == "total" and numbers.coefficient == 0.3
        assert numbers.stiffness_ratio == pytest.approx(law.friction.stiffness_ratio, rel=1e-6)
        assert numbers.damping_ratio == pytest.approx(0.5, rel=1e-6)
        assert numbers.sticks_below == pytest.approx(contact.sticks_below(row.speed), rel=1e-6)
        assert numbers.slides_beyond == pytest.approx(contact.slides_beyond(row.speed), rel=1e-6)
        beta = contact.effective_tangential_restitution(row.speed)
        assert numbers.effective_tangential_restitution == pytest.approx(beta, rel=1e-6)
        angle, tabulated = numbers.tangential_restitution[9]
        impact = contact.impact(row.speed, row.speed * math.tan(angle))
        assert tabulated == pytest.approx(impact.tangential_restitution, abs=1e-8)


def unsized_of(script: str) -> str:
    """A script whose grains stand in a file that is not there."""
    lines = [line for line in script.splitlines() if not line.startswith(("create_atoms", "set "))]
    return "\n".join([*lines[:-1], "read_data grains.data", lines[-1], ""])


@pytest.mark.parametrize(("dimension", "beta"), [slow(3, 0.327), (2, 0.403)])
def test_systems_of_both_dimensions(dimension: int, beta: float) -> None:
    """The rule in a gas is that of the dimension, of solid spheres and disks."""
    law = hl.LinearDashpot(stiffness=1e5, restitution=0.9, friction=hl.Friction(0.5, stiffness_ratio=0.9))
    system = hl.ParticleSystem.random(
        n=20, packing_fraction=0.1, radius=1e-3, density=2500.0, rms_speed=0.1, dimension=dimension
    )
    verdict = hl.check(system, law=law)
    assert verdict.admissible is True
    assert "the same friction (rule law or constant with μ" in verdict.sentence
    assert verdict.rows[0].friction.effective_tangential_restitution == pytest.approx(beta, abs=1e-3)


def test_systems_have_the_spins_of_their_grains() -> None:
    """Each q of grains of one size, and of the smallest and the largest."""
    law = hl.LinearDashpot(stiffness=1e5, restitution=0.9, friction=hl.Friction(0.5, stiffness_ratio=0.9))

    def system(**grains) -> hl.ParticleSystem:
        places = [[x, 0.01, 0.01] for x in (0.01, 0.02, 0.03)]
        grains = {"radius": 1e-3, "density": 2500.0, "box": 0.04} | grains
        return hl.ParticleSystem(places, np.zeros((3, 3)), **grains)

    def betas(**grains) -> list[float]:
        rows = hl.check(system(**grains), law=law, speed=0.1).rows
        return [row.friction.effective_tangential_restitution for row in rows]

    def beta(first: float, second: float) -> float:
        balls = [hl.Ball(1e-3, density=2500.0, inertia_factor=q) for q in (first, second)]
        return law.between(*balls).effective_tangential_restitution(0.1)

    assert betas() == pytest.approx([beta(0.4, 0.4)])
    assert betas(inertia_factor=0.6) == pytest.approx([beta(0.6, 0.6)])
    mixed = [beta(0.3, 0.3), beta(0.3, 0.6), beta(0.6, 0.6)]
    assert betas(inertia_factor=[0.4, 0.6, 0.3]) == pytest.approx(mixed)
    ends = cases.sizes(system(radius=[1.5e-3, 1e-3, 2e-3]))
    assert [ball.radius for ball in ends] == [1e-3, 2e-3]


def test_the_error_is_not_known_of_grains_that_spin_differently() -> None:
    law = hl.LinearDashpot(stiffness=1e5, restitution=0.9, friction=hl.Friction(0.5, stiffness_ratio=0.9))
    places = np.stack(np.meshgrid(*[[0.005, 0.015]] * 3), axis=-1).reshape(-1, 3)
    grains = {"radius": 1e-3, "density": 2500.0, "box": 0.02}
    speeds = np.tile([[0.1, 0.0, 0.0], [-0.1, 0.0, 0.0]], (4, 1))
    for factors, known in ((0.4, True), (0.6, True), ([0.4, 0.6] * 4, False)):
        system = hl.ParticleSystem(places, speeds, inertia_factor=factors, **grains)
        rows = hl.check(system, law=law).rows
        assert all(("law" in row.error) is known for row in rows), factors


def test_what_is_not_known_is_left_out() -> None:
    """Numbers that do not depend on the unknown sizes stay."""
    assert (
        checked(0.0).rows[0].friction == CheckedFriction(0.0, "spring")
        and words([checked(0.0).rows[0].friction]) == ""
    )
    script = LAMMPS.format(LINE)
    unsized = hl.check(unsized_of(script), code="lammps").rows[0]
    assert unsized.radius is None and unsized.duration is None
    assert words([unsized.friction]).startswith(
        "μ 0.5: sticks below 36°, slides beyond 70°; β −0.57 near head-on"
    )
    # A damping per mass: ε depends on the mass, but not the angle at which they slip at touch.
    damped = script.replace("1e5 0.8 damping coeff_restitution", "1e5 5e3 damping mass_velocity")
    unsized = hl.check(unsized_of(damped.replace("9e4 0 0.5", "9e4 0.5 0.5")), code="lammps").rows[0].friction
    assert unsized.coefficient == 0.5 and unsized.damping_ratio == pytest.approx(0.5)
    assert words([unsized]) == "μ 0.5: β is not known"


def test_a_model_that_is_not_understood_says_so() -> None:
    unknown = words([CheckedFriction(0.3)])
    assert unknown == "μ 0.3: tangential model not understood"
    assert words([CheckedFriction(0.3, "mindlin", not_known="k_t is NULL")]) == "μ 0.3: k_t is NULL"
    assert words([CheckedFriction(None)]) == "μ is not known"


def test_json_and_dataset() -> None:
    verdict = checked(stiffness_ratio=0.9)
    content = json.loads(json.dumps(verdict.to_dict(), allow_nan=False))["contacts"][0]["friction"]
    assert content["coefficient"] == 0.5 and content["model"] == "spring" and content["limit"] == "total"
    angles, betas = zip(*content["tangential_restitution"], strict=True)
    assert angles == pytest.approx(np.radians(range(0, 90, 5))) and betas[0] == pytest.approx(
        -0.7600, abs=1e-3
    )
    assert verdict.contacts["sticks_below"].values == pytest.approx([math.atan(0.5 / 0.9)] * 2, abs=1e-4)
    assert verdict.contacts["sticks_below"].attrs["units"] == "rad"
    assert verdict.contacts["friction"].values.tolist() == [0.5, 0.5]


@pytest.mark.parametrize("width", [50, 80, 100])
def test_report(width: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Contacts with the same numbers share a line; warnings stand before the answer, each once."""
    monkeypatch.setenv("COLUMNS", str(width))
    line = LINE.replace("0.8", "0.6")
    (tmp_path / "in.box").write_text(
        LAMMPS.format(line) + f"fix w all wall/gran granular {line} zplane 0 1\nrun 1\n"
    )
    printed = run("check", tmp_path / "in.box", "--speed", 0.1).output
    assert max(map(len, printed.splitlines())) <= width
    text = " ".join(printed.split())
    assert text.count("μ 0.5: ") == 1 and "1–1, 1–wall μ 0.5: sticks below 39°, slides beyond 68°" in text
    assert "12–18 steps" in text and text.count("Warning: without limit_damping") == 1
    assert text.index("μ 0.5") < text.index("Warning") < text.index("Cannot be said")
    assert "Ignored" not in text and "Checked: normal contact, friction, time step, walls" in text


# --- from numbers on the command line -----------------------------------------------------------------------

GRAINS = ["--radius", "1mm", "--density", 2500]
SPRING = ["--stiffness", 1e4, "--restitution", 0.9]
#: The law of numbers and the words of LAMMPS for it: a stiffness or a modulus, ε, k_t or Poisson's ratio, γ_t/γ_n, μ.
SAME_FORCES = {
    "linear": (
        "hooke {0} {1} damping coeff_restitution tangential linear_history {2} {3} {4} limit_damping",
        ["--stiffness", "--tangential-stiffness"],
    ),
    "tsuji": (
        "hertz/material {0} {1} {2} damping coeff_restitution tangential mindlin_rescale NULL {3} {4} "
        "limit_damping",
        ["--youngs-modulus", "--poisson-ratio"],
    ),
}
#: What the names of a script differ in.
NAMED = ("model", "wall", "restitution_asked", "other_versions")


def close(own, script, where: str = "") -> None:
    """The same numbers in the mappings of two verdicts."""
    if isinstance(own, dict):
        for name in own.keys() - NAMED:
            close(own[name], script[name], f"{where}.{name}")
    elif isinstance(own, list):
        assert len(own) == len(script), where
        for k, pair in enumerate(zip(own, script, strict=True)):
            close(*pair, f"{where}[{k}]")
    else:
        assert own == (pytest.approx(script, rel=1e-6, abs=1e-9) if isinstance(own, float) else script), where


def compare_with_script(law: str, numbers: list[float], **conditions: float) -> dict:
    """The verdict of numbers on the command line, which is that of LAMMPS' script with them."""
    line, options = SAME_FORCES[law]
    line = line.format(*numbers)
    text = LAMMPS.format(line).replace("run 1", f"fix w all wall/gran granular {line} zplane 0 1\nrun 1")
    script = hl.check(text, code="lammps", **conditions)
    values = [f"--law={law}", f"--restitution={script.rows[0].restitution!r}"]
    values += [f"{name}={value!r}" for name, value in zip(options, (numbers[0], numbers[2]), strict=True)]
    values += [f"--damping-ratio={numbers[3]!r}", f"--friction={numbers[4]!r}", "--time-step=1us"]
    values += [f"--{name.replace('_', '-')}={value!r}" for name, value in conditions.items()]
    own = printed("check", *GRAINS, *values)
    assert [row["types"] for row in own["contacts"]] == [[1, 1], [1, "wall"]]
    for name in ("contacts", "state"):
        close(own[name], script.to_dict()[name], name)
    assert own["admissible"] == script.admissible
    return own


@draws(15)
@given(
    st.sampled_from(list(SAME_FORCES)),
    log_floats(1e3, 1e6),
    st.floats(0.5, 0.99),
    st.floats(0.05, 0.45),
    st.floats(0.0, 0.9),
    st.floats(0.05, 1.2),
    log_floats(1.0, 1e3),
)
def test_numbers_are_those_of_a_script(law, stiffness, restitution, second, damping, mu, pressure) -> None:
    """Grains and walls with friction, a gas, and grains under a pressure, whose stable step depends on k_t."""
    linear = law == "linear"
    numbers = [
        stiffness if linear else 1e3 * stiffness,
        restitution,
        stiffness * second if linear else second,
    ]
    own = compare_with_script(law, [*numbers, damping, mu], speed=0.3, pressure=pressure)
    assert own["state"]["largest_stable_step"] > 0.0 and own["state"]["name"] == "pressed"
    for row in own["contacts"]:
        assert row["friction"]["coefficient"] == mu and row["friction"]["limit"] == "total"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "numbers"),
    [("linear", [1e4, 0.9, 3e3, 0.4, 0.5]), ("tsuji", [1e7, 0.8, 0.3, 0.0, 0.2])],
)
def test_the_error_of_numbers_is_that_of_a_script(law, numbers) -> None:
    own = compare_with_script(law, numbers, speed=0.3, packing_fraction=0.3)["contacts"][0]
    assert own["error"]["law"][0] != own["frictionless_error"] and own["rule"] == "law"


def test_friction_of_numbers_is_said() -> None:
    """The line of the friction, the rule that has it, and the solid disks of two dimensions."""
    friction = ["--friction", 0.5, "--stiffness-ratio", "2/7"]
    text = " ".join(run("check", *GRAINS, *SPRING, "--speed", 0.3, *friction).stdout.split())
    assert "1–1, 1–wall μ 0.5: sticks below 59°, slides beyond" in text and "normal contact, friction" in text
    disks = printed("check", *GRAINS, *SPRING, "--speed", 0.3, *friction, "--dimension", 2)["contacts"][0]
    ball = hl.Ball(1e-3, density=2500.0, inertia_factor=0.5)
    law = hl.LinearDashpot(stiffness=1e4, restitution=0.9, friction=hl.Friction(0.5, stiffness_ratio=2 / 7))
    row = hl.check(ball, law=law, speed=0.3, dimension=2).rows[0].friction
    assert disks["friction"] == json.loads(json.dumps(row.to_dict()))
    smooth = printed("check", *GRAINS, *SPRING, "--speed", 0.3)["contacts"][0]
    assert smooth["friction"]["coefficient"] == 0.0


@pytest.mark.parametrize(
    ("typed", "line"),
    [
        ("--stiffness-ratio 1", "--friction: missing, must be given beside --stiffness-ratio"),
        ("--friction-model mindlin", "--friction: missing, must be given beside --friction-model"),
        ("--friction -1", "--friction: got -1, must be >= 0"),
        ("--friction 1kg", "--friction: got '1kg'"),
        (
            "--friction 1 --stiffness-ratio 1 --tangential-stiffness 1",
            "--stiffness-ratio | --tangential-stiff",
        ),
        ("--friction 1 --friction-model mindlin", "--friction-model"),
    ],
)
def test_bad_friction_of_numbers_is_refused_in_one_line(typed: str, line: str) -> None:
    assert line in refused("check", *GRAINS, *SPRING, *typed.split())


@pytest.mark.parametrize(
    "typed",
    [
        *("--friction 0.5", "--stiffness-ratio 0.5", "--tangential-stiffness 0.5", "--damping-ratio 0.5"),
        *("--tangential-damping 0.5", "--friction-model spring", "--limit total"),
    ],
)
def test_friction_is_that_of_the_script(typed: str, tmp_path: Path) -> None:
    (tmp_path / "in.box").write_text(LAMMPS.format(LINE))
    line = refused("check", tmp_path / "in.box", *typed.split())
    assert line.endswith(f"{typed.replace(' ', ': got ')}, must be left out with a file")


# --- traps ----------------------------------------------------------------------------------------------------


def test_superballs() -> None:
    """ρ = 1, the default of LAMMPS and ours."""
    assert "superballs" in said(checked()) and "β = +1.00" in said(checked())
    assert "superballs" not in said(checked(stiffness_ratio=0.9))


def test_sticking_grains_that_leave_as_smooth_ones() -> None:
    """ρ near 4, and k_t far too small."""
    for ratio in (8 / 7, 1.0, 1e-4):
        assert "leave as smooth ones do" in said(checked(stiffness_ratio=ratio))
    assert "leave as smooth ones do" not in said(checked(stiffness_ratio=0.9))


def test_no_static_friction() -> None:
    verdict = checked(model="none", damping_ratio=0.5, law={"stiffness": 1e5, "restitution": 0.8})
    assert "no static friction" in said(verdict)
    assert "no static friction; β −" in words([verdict.rows[0].friction])
    assert max(beta for _, beta in verdict.rows[0].friction.tangential_restitution) <= 0.0


def test_friction_that_adds_energy() -> None:
    """Mindlin's displacement and force, undamped, at ρ = 3.3 (β = −1.051 without slip); not the rescaled ones."""
    for model in MODELS[1:5]:
        rough = hl.Friction(5.0, stiffness_ratio=3.3 / 3.5, model=model)
        law = hl.Tsuji(youngs_modulus=1e8, poisson_ratio=0.1, restitution=1.0, friction=rough)
        verdict = hl.check(BALL, law=law, speed=0.1)
        assert ("friction adds energy: |β| reaches 1.0" in said(verdict)) == ("rescale" not in model)


def test_friction_in_the_attractive_end() -> None:
    """Each contact whose force attracts, unless the reader has said so in the words of the script."""
    row = CheckedContact(
        ("1", "1"), 1, None, "x", None, None, None, None, clipped=False, speed=1.0, restitution=0.7,
        friction=CheckedFriction(0.5, "x", limit="total"),
    )  # fmt: skip
    assert "where the normal force attracts" in TRAPS[-1](row)
    assert not TRAPS[-1](replace(row, clipped=True)) and not TRAPS[-1](replace(row, restitution=1.0))
    verdict = hl.check(
        LAMMPS.format("hooke 1e5 0.8 damping coeff_restitution tangential linear_history 9e4 0 0.5"),
        speed=0.1,
    )
    assert said(verdict).count("attracts") == 1


@pytest.mark.parametrize(("restitution", "shown"), [(0.9, False), (0.5, True)])
def test_attraction_that_hardly_changes_beta_is_no_warning(
    restitution: float, shown: bool, tmp_path: Path
) -> None:
    """It changes β by 0.005 and 0.13; --verbose tells of both."""
    line = f"hooke 1e5 {restitution} damping coeff_restitution tangential linear_history 9e4 0 0.5"
    file = tmp_path / "in.box"
    file.write_text(LAMMPS.format(line))
    verdict = hl.check(file, speed=0.1)
    change = verdict.rows[0].friction.changed_by_attraction
    assert (change > 0.02) == shown and verdict.rows[0].friction.changed_by_limit == 0.0
    assert [finding.minor for finding in verdict.warnings if "attracts" in finding.what] == [not shown]
    brief, whole = (run("check", str(file), "--speed", "0.1", *more).stdout for more in ((), ("--verbose",)))
    assert ("the normal force attracts" in " ".join(brief.split())) == shown
    assert "the normal force attracts" in " ".join(whole.split())


def test_walls_that_lost_their_friction() -> None:
    """LAMMPS 2 Aug 2023 to 22 Jul 2025 (PR 5007): β of the wall as it was and as it should be, first of all."""
    wall = "gran/hooke/history 1e5 9e4 10 0 0.5 1"
    script = LAMMPS.replace("pair_style granular\npair_coeff * * {}", f"pair_style {wall}\npair_coeff * *")
    script += f"fix w all wall/{wall} zplane 0 1\nrun 1\n".replace("wall/gran/hooke", "wall/gran hooke")
    was, is_now = "−1.00", "+0.21"
    for version, sentence in (
        ("2 Aug 2023", f"β at 45° is {was} in this version, and {is_now} since it was mended in 2026"),
        (None, f"β at 45° is {is_now}, and {was} from 2 Aug 2023 to 2026"),
    ):
        verdict = hl.check(
            script if version is None else f"LAMMPS ({version})\n{script}", code="lammps", speed=0.1
        )
        first, second = verdict.warnings[:2]
        assert first.what == sentence and first.types == ("1", "wall")
        assert "wall/gran hooke/history" in second.what and "PR 5007" in second.what
    row = hl.check(f"LAMMPS (23 Jun 2022)\n{script}", code="lammps", speed=0.1).rows[1].friction
    oblique = dict(row.tangential_restitution)[frictional_contact.ANGLES[9]]
    assert not row.other_versions and oblique == pytest.approx(0.21, abs=0.01)


# --- the error of the time step -------------------------------------------------------------------------------


def test_the_error_of_the_step_is_of_first_order() -> None:
    errors = [
        hl.check(
            BALL,
            law=hl.LinearDashpot(stiffness=1e5, restitution=0.8, friction=hl.Friction(0.4, stiffness_ratio=0.8)),
            speed=0.3, time_step=step,
        ).rows[0].friction.tangential_restitution_error_of_step
        for step in (1e-6, 1e-7, 1e-8, 1e-10)
    ]  # fmt: skip
    ratios = np.array(errors[:-1]) / errors[1:]
    assert ratios == pytest.approx([10.0, 10.0, 100.0], rel=0.6)


CONTACTS = {
    "linear": "hooke 2e4 0.05 damping velocity limit_damping tangential linear_history 1.6e4 0.7 0.4",
    "no history": "hooke 2e4 0.05 damping velocity limit_damping tangential linear_nohistory 0.7 0.4",
    "mindlin": "hertz 5e6 0.6 damping velocity limit_damping tangential mindlin_rescale 4e6 0.4 0.4",
}


try:
    ENGINE = program.find(1)
    MISSING = ""
except ImportError as error:
    MISSING = str(error)


@pytest.mark.skipif(bool(MISSING), reason=MISSING)
@pytest.mark.parametrize("name", CONTACTS)
def test_the_scheme_is_that_of_lammps(name: str, tmp_path: Path) -> None:
    """β of spheres that touch a wall at 16 phases of a step and at 4 angles, in eleven steps or so."""
    line, speed, tangents = CONTACTS[name], 0.3, np.array([0.1, 0.6, 1.2, 2.4])
    description = read(f"{LAMMPS.format(LINE)}fix w all wall/gran granular {line} zplane 0 1\nrun 1\n")
    setting = next(contact for contact in description.stages[-1].contacts if contact.wall)
    make = cases.force_of(code("lammps"), setting, None)
    ball = KnownBody(1e-3, BALL.mass)
    force, law = make(ball, None, speed), cases.friction_of(code("lammps"), setting, make)
    contact = friction.contact_of(law.terms, force, (ball, None), speed)
    step = force.collision(speed).duration / 11.3
    expected = in_lammps(ENGINE, line, speed, tangents, step, tmp_path)
    beta = integration_error.tangential_restitution(
        force, contact.terms, contact.tangential_mass, speed, speed * tangents, step
    )
    assert beta == pytest.approx(expected, abs=1e-6)


def in_lammps(
    engine: program.Program, line: str, speed: float, tangents: np.ndarray, step: float, folder: Path
) -> np.ndarray:
    """β from the velocities and spins after the contact, by phase and angle."""
    phases = integration_error.FEW_PHASES
    atoms = [
        f"create_atoms 1 single {0.01 * (i + 1):.6f} {0.01 * (j + 1):.6f} {1e-3 + (3 - phase) * speed * step:.17g}\n"
        f"set atom {i * len(tangents) + j + 1} vx {speed * tangent:.17g} vz {-speed:.17g}"
        for i, phase in enumerate(phases)
        for j, tangent in enumerate(tangents)
    ]
    size = 0.01 * (len(phases) + 1)
    (folder / "in.wall").write_text(f"""units si
atom_style sphere
boundary f f f
newton off
comm_modify vel yes
region box block 0 {size} 0 {size} 0 0.01
create_box 1 box
pair_style granular
pair_coeff * * hooke 1 0 damping velocity tangential linear_nohistory 0 0
{chr(10).join(atoms)}
set type 1 diameter 0.002 density 2500
fix w all wall/gran granular {line} zplane 0 NULL
fix move all nve/sphere
timestep {step:.17g}
run 60
write_dump all custom out.dump id vx omegay modify sort id format float %.17g
""")
    command = engine.command(1, "-in", "in.wall")
    ran = subprocess.run(command, cwd=folder, env=engine.environment(), capture_output=True, text=True)
    assert ran.returncode == 0, ran.stdout[-2000:]
    rows = np.loadtxt((folder / "out.dump").read_text().split("omegay")[1].splitlines()[1:])
    after = rows[:, 1] - 1e-3 * rows[:, 2]
    return -after.reshape(len(phases), len(tangents)) / (speed * tangents)


# --- any contact ----------------------------------------------------------------------------------------------


@draws(300, 25)
@given(
    powers=st.sampled_from([(4, 0), (6, 0), (6, 1), (6, 2)]),
    attracts=st.booleans(),
    model=st.sampled_from(MODELS),
    limit=st.sampled_from(LIMITS),
    mu=st.one_of(log_floats(1e-3, 1e2), st.just(math.inf)),
    stiffness=log_floats(1e-4, 1e3),
    damping=st.one_of(st.just(0.0), log_floats(1e-3, 3.0)),
    normal=st.one_of(st.just(0.0), log_floats(1e-3, 3.0)),
    ratio=st.floats(0.2, 1.0),
    speed=log_floats(1e-3, 1e2),
    step=st.one_of(st.none(), log_floats(1e-3, 3.0)),
    dimension=st.sampled_from([2, 3]),
)
def test_any_contact_has_numbers(
    powers, attracts, model, limit, mu, stiffness, damping, normal, ratio, speed, step, dimension
):
    """Nothing fails, numbers are in their ranges, and those of the table are those of the contact in SI units."""
    terms = FrictionTerms.of_model(
        model, limit, coefficient=mu, stiffness=0.0 if model == "none" else 1e4 * stiffness,
        stiffness_power=0 if model in ("spring", "none") or powers[0] == 4 else 2,
        damping=damping, damping_power=powers[1],
    )  # fmt: skip
    force = Force(Powers(*powers, attracts), 1e4, normal, 1e-4)
    contact = FrictionalContact(force.powers.arguments, (1e4, normal), 1e-4, ratio * 1e-4, terms)
    collision = force.collision(speed)
    step = None if step is None or not math.isfinite(collision.duration) else step * collision.duration
    results = friction.numbers(contact, force, speed, step, dimension)
    row = friction.friction_of(friction.FrictionLaw(mu, model), results)
    assert words([row]) and row.stiffness_ratio >= 0.0
    if not row.tangential_restitution:
        return
    angles, betas = map(np.array, zip(*row.tangential_restitution, strict=True))
    near = np.tan(angles[1:, None]) * (1.0 + np.array([-1e-8, 0.0, 1e-8]))  # β may jump where slip begins
    masses = contact.effective_mass, terms, contact.tangential_mass
    direct = tangential_restitution(contact.powers, *contact.coefficients, *masses, speed, speed * near)
    assert np.nanmin(np.abs(direct - betas[1:, None]), axis=1, initial=1.0).max() < 1e-6
    if row.sticks_below is not None and row.slides_beyond is not None:
        assert 0.0 <= row.sticks_below <= row.slides_beyond <= 0.5 * math.pi


def test_numbers_alone_may_be_answered_with_yes():
    """The wall beside them need not be there; a wall of a system is."""
    law = hl.LinearDashpot(stiffness=1e6, restitution=0.9, friction=hl.Friction(0.5))
    ball, gas = hl.Ball(1e-3, density=2500.0), {"speed": 0.3, "packing_fraction": 0.3}
    verdict = hl.check(ball, law=law, **gas)
    assert verdict.admissible is True
    assert verdict.sentence.endswith("This holds far from walls that rub.")
    smooth = hl.check(ball, law=hl.LinearDashpot(stiffness=1e6, restitution=0.9), **gas)
    assert smooth.admissible is True
    assert "walls" not in smooth.sentence
    box = hl.ParticleSystem.random(50, 0.1, radius=1e-3, density=2500.0, rms_speed=0.3, boundary="wall")
    assert hl.check(box, law=law).admissible is None


DAMPED = """units si
atom_style sphere
region box block 0 0.04 0 0.04 0 0.026
create_box 1 box
create_atoms 1 random 2000 7 box overlap 0.002 maxtry 500
set type 1 diameter 0.002 density 2500
pair_style gran/hooke/history {:.17g} {:.17g} {:.17g} NULL 0.3 1
pair_coeff * *
velocity all create 1e16 3
fix move all nve/sphere
timestep 1e-6
run 1
"""


@pytest.mark.parametrize("stiffness", [1e5, 2e3])
def test_a_stiffness_that_is_offered_or_asked_for_holds_with_what_must_stay_the_same(stiffness) -> None:
    numbers = np.array([stiffness, 2.0 / 7.0 * stiffness, 5000.0])
    verdict = hl.check(DAMPED.format(*numbers))
    assert verdict.admissible is (stiffness == 1e5)
    assert re.search(
        r"stiffness of \S+ N/m (from|instead of) \S+, with the same ε and k_t/k_n[;.]", verdict.sentence
    )
    _, value, needed = verdict.rows[0].spring
    assert value == stiffness
    factor = 1.001 * needed / value
    same = hl.check(DAMPED.format(*numbers * [factor, factor, math.sqrt(factor)]))
    assert same.admissible is True
    assert same.rows[0].restitution == pytest.approx(verdict.rows[0].restitution, abs=1e-6)
    stiffness_alone = hl.check(DAMPED.format(*numbers * [factor, 1.0, 1.0]))
    assert stiffness_alone.admissible is not True


def test_what_the_script_keeps_by_itself_is_not_asked_for() -> None:
    smooth = hl.check(
        BALL, law=hl.LinearDashpot(stiffness=1e4, restitution=0.9), speed=0.3, packing_fraction=0.3
    )
    assert re.search(r"instead of 1e4\.", smooth.sentence)
    damped = hl.check(
        BALL, law=hl.LinearDashpot(stiffness=1e4, damping=0.01), speed=0.3, packing_fraction=0.3
    )
    assert re.search(r"instead of 1e4, with the same ε\.", damped.sentence)


def test_hardly_any_friction_is_said_in_whole_sentences() -> None:
    friction = hl.Friction(1e-9)
    law = hl.LinearDashpot(stiffness=1e4, restitution=0.9, friction=friction)
    verdict = hl.check(BALL, law=law, speed=0.3, packing_fraction=0.3)
    assert "slides at every angle;" in words([verdict.rows[0].friction])
    assert "without, it cools less than 0.001 % too slowly" in verdict.sentence
