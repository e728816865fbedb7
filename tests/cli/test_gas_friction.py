"""Friction and spins on the command line of ``gas`` and ``gas compare``, and in their job files."""

import math
import shlex
from pathlib import Path

import numpy as np
import pytest

import hardlimit as hl
from command_line import printed, refused, run
from hardlimit.cli.gas_job import GLASS_BEADS
from hardlimit.support.formatting import digits

SMALL = ["--n", 40, "--packing-fraction", 0.1, "--until", "2ms", "--samples", 4]
SPRING = ["--stiffness", "1e5", "--restitution", 0.9]


def start(**more: object) -> hl.ParticleSystem:
    return hl.ParticleSystem.random(**(GLASS_BEADS | {"n": 40, "packing_fraction": 0.1} | more))


def law(**friction: object) -> hl.LinearDashpot:
    return hl.LinearDashpot(stiffness=1e5, restitution=0.9, friction=hl.Friction(**friction))


# --- options ------------------------------------------------------------------------------------------------


def test_a_constant_rule_with_friction() -> None:
    output = printed("gas", *SMALL, "--friction", 0.5, "--tangential-restitution", 0.3, "--rms-spin", "equal")
    system = start(rms_spin="equal")
    rule = {"restitution": 0.9, "friction": 0.5, "tangential_restitution": 0.3}
    result = hl.event_driven(system, **rule, until=0.002, samples=4)
    assert {name: output[name] for name in rule} == rule and output["law"] is None
    assert output["n_collisions"] == result.n_collisions > 10
    assert output["series"]["granular_temperature"] == result.series.granular_temperature.values.tolist()


def test_rough_grains_have_an_infinite_friction() -> None:
    """JSON has no infinity: null."""
    options = ["--friction", "inf", "--tangential-restitution", 1]
    assert printed("gas", *SMALL, *options)["friction"] is None
    assert printed("gas", *SMALL, "--friction", "infinite", *options[2:]) == printed("gas", *SMALL, *options)
    assert "friction inf, tangential restitution 1" in " ".join(run("gas", *SMALL, *options).stdout.split())


@pytest.mark.parametrize("engine", [[], ["--engine", "steps"]])
def test_a_law_with_friction(engine: list[str]) -> None:
    options = shlex.split("--friction 0.5 --stiffness-ratio 2/7 --tangential-damping 0.01 --limit spring")
    output = printed("gas", *SMALL, *SPRING, *options, *engine)
    expected = law(coefficient=0.5, stiffness_ratio=2 / 7, damping=0.01, limit="spring")
    assert (
        f"linear law: k {digits(1e5)} N/m, ε 0.9, μ 0.5"
        in run("gas", *SMALL, *SPRING, *options, *engine).stdout
    )
    assert output["law"]["friction"] == expected.friction.to_dict()
    if engine:
        result = hl.molecular_dynamics(start(), law=expected, until=0.002, samples=4, engine="steps")
        assert (
            output["n_contacts"] == result.n_contacts > 10 and output["energy_error"] == result.energy_error
        )
        for name in ("rotational_energy", "rotational_temperature", "temperature_ratio"):
            values = output["series"][name]
            assert values == result.series[name].values.tolist() and values[-1] > 0.0


def test_the_table_has_the_temperature_of_rotation() -> None:
    options = [
        *SMALL,
        *SPRING,
        *shlex.split("--friction 0.5 --engine steps --rms-spin 100 --inertia-factor 2/3"),
    ]
    text = " ".join(run("gas", *options).stdout.split())
    system = start(rms_spin=100.0, inertia_factor=2 / 3)
    result = hl.molecular_dynamics(
        system, law=law(coefficient=0.5), until=0.002, samples=4, engine="steps"
    ).system
    values = {
        "rotational temperature [m²/s²]": system.rotational_temperature,
        "rotational temperature at the end [m²/s²]": result.rotational_temperature,
        "temperature ratio θ = T_r/T at the end": result.rotational_temperature / result.granular_temperature,
    }
    for label, value in values.items():
        told = float(text.partition(label)[2].split()[0])
        assert told == pytest.approx(value, rel=1e-5), label
    assert "μ 0.5" in text and "chose" not in text


def test_theory_of_grains_that_rub_is_shown_in_place_of_that_of_smooth_ones() -> None:
    """Rate and pressure hold at the measured temperature; Haff's law does not."""
    rubbing = ["--friction", 0.5, "--tangential-restitution", 0.3]
    cooled = "granular temperature at the end [m²/s²]"
    smooth, rough = (printed("gas", *SMALL, *options)["theory"] for options in ([], rubbing))
    rotation = {"rotational temperature at the end [m²/s²]", "temperature ratio θ = T_r/T at the end"}
    assert set(rough) - set(smooth) == rotation and rough[cooled] < smooth[cooled]
    assert "Haff" in run("gas", *SMALL).stdout and "Haff" not in run("gas", *SMALL, *rubbing).stdout


# --- job files ----------------------------------------------------------------------------------------------

JOB = """
[random]
n = 40
packing_fraction = 0.1
rms_spin = "equal"
inertia_factor = "2/3"
[law]
name = "linear"
stiffness = "100 kN/m"
restitution = 0.9
friction = 0.5
stiffness_ratio = "2/7"
friction_model = "spring"
[event_driven]
until = "2 ms"
samples = 4
"""
CONSTANT = """
[random]
n = 40
packing_fraction = 0.1
rms_spin = "100 rad/s"
[event_driven]
restitution = 0.8
friction = 0.5
tangential_restitution = 0.3
until = "2 ms"
samples = 4
"""


@pytest.fixture
def job(tmp_path: Path) -> Path:
    path = tmp_path / "job.toml"
    path.write_text(JOB)
    return path


@pytest.fixture
def constant(tmp_path: Path) -> Path:
    path = tmp_path / "constant.toml"
    path.write_text(CONSTANT)
    return path


def test_a_job_has_the_keys_of_the_options(job: Path, constant: Path) -> None:
    options = shlex.split("--friction 0.5 --stiffness-ratio 2/7 --rms-spin equal --inertia-factor 2/3")
    for engine in ([], ["--engine", "steps"]):
        assert printed("gas", job, *engine) == printed("gas", *SMALL, *SPRING, *options, *engine)
    options = ["--restitution", 0.8, "--friction", 0.5, "--tangential-restitution", 0.3, "--rms-spin", "100"]
    assert printed("gas", constant) == printed("gas", *SMALL, *options)


def test_options_change_the_friction_of_a_job(job: Path, constant: Path) -> None:
    changed = printed("gas", job, "--friction", 0.1, "--tangential-stiffness", "10 kN/m")["law"]["friction"]
    assert changed["coefficient"] == 0.1 and changed["stiffness"] == 1e4 and "stiffness_ratio" not in changed
    assert (
        printed("gas", job, "--law", "linear", "--restitution", 0.5)["law"]["friction"]["coefficient"] == 0.5
    )
    output = printed("gas", constant, "--friction", 0.2, "--tangential-restitution", 1)
    assert (output["friction"], output["tangential_restitution"]) == (0.2, 1.0)


@pytest.mark.parametrize(
    ("text", "changed", "message"),
    [
        (JOB, ("friction = 0.5", "friction = -1"), "law.friction: got -1, must be >= 0"),
        (JOB, ("friction = 0.5\n", ""), "law.friction: missing, must be given beside --stiffness-ratio"),
        (JOB, ('"2/7"', '"2/0"'), "law.stiffness_ratio: got '2/0', must be a number without unit"),
        (JOB, ('"equal"', '"equl"'), "random.rms_spin: got 'equl', must be a number [rad/s] or"),
        (JOB, ("[event_driven]", "[event_driven]\nfriction = 0.5"), "law | event_driven.friction: got both"),
        (JOB, ("samples", "tangential_restitution = 0.5\nsamples"), "tangential_restitution: got 0.5, must be left"),
        (CONSTANT, ("tangential_restitution = 0.3", ""), "tangential_restitution: missing, must be given with"),
    ],
)  # fmt: skip
def test_wrong_jobs(tmp_path: Path, text: str, changed: tuple[str, str], message: str) -> None:
    path = tmp_path / "wrong.toml"
    path.write_text(text.replace(*changed))
    if "tangential" in message:  # a key of the job without its file
        assert message in run("gas", path, code=2).stderr
        return
    assert message in refused("gas", path)
    assert message in refused("gas", "compare", path, "--replicas", 1)


def test_friction_of_a_rule_beside_the_options_of_a_law(constant: Path) -> None:
    message = refused("gas", constant, "--stiffness", "1e5")
    assert (
        "event_driven.friction: must be left out with a contact law, whose friction --friction gives"
        in message
    )


# --- compare ------------------------------------------------------------------------------------------------


def compared(*options: object) -> dict:
    small = shlex.split("--n 30 --packing-fraction 0.2 --until 2ms --samples 2 --replicas 2 --workers 1")
    return printed("gas", "compare", *small, *options)


@pytest.mark.slow
def test_both_sides_of_a_comparison_rub(tmp_path: Path) -> None:
    """The constant rule has μ of the law, and the β0 that stands for it in a gas."""
    saved = tmp_path / "compared.nc"
    output = compared(*SPRING, "--friction", 0.5, "--rms-spin", "equal", "--models", "constant", "--models", "law",
                      "--out", saved)  # fmt: skip
    ball = hl.Ball(1e-3, density=2500.0)
    expected = law(coefficient=0.5).between(ball, ball).effective_tangential_restitution()
    assert (
        output["tangential_restitution"] == pytest.approx(expected, rel=1e-12) and output["engine"] == "steps"
    )
    assert output["variables"]["rotational_temperature"]["units"] == "m2/s2"
    loaded = hl.load(saved)
    assert loaded.summary() == output["summary"] and loaded.plan.law == law(coefficient=0.5)
    assert np.array_equal(loaded.start.angular_velocities, loaded.start.replace().angular_velocities)


def test_the_law_of_the_error_predicts_grains_that_rub() -> None:
    """From the spins of the start; not for grains that rub much more than measured ones, and not for other rules."""
    output = compared(*SPRING, "--friction", 0.5, "--models", "constant", "--models", "law")
    assert "The law of the error predicts " in output["summary"]
    predicted = output["predicted_cooling"]
    assert all(
        predicted[rule]["reason"] == "" and predicted[rule]["error"] > 0.0 for rule in ("constant", "law")
    )
    assert predicted["constant"]["value"] > predicted["law"]["value"]
    far = compared(*SPRING, "--friction", 5, "--models", "law")
    assert far["summary"].endswith("The law of the error is not known with this friction.")
    assert "got μ = 5, must be in [0, 2]" in far["predicted_cooling"]["law"]["reason"]
    smooth = compared(*SPRING, "--models", "constant")
    assert "not known with" not in smooth["summary"] and "tangential_restitution" not in smooth


def test_a_law_without_a_coefficient_of_friction_is_smooth() -> None:
    without = compared(*SPRING, "--models", "law")
    zero = compared(*SPRING, "--models", "law", "--friction", 0, "--tangential-restitution", 0)
    cooling = [output["variables"]["cooling"]["values"] for output in (zero, without)]
    assert np.array_equal(*cooling)
    assert math.isclose(zero["tc_nu"], without["tc_nu"])


# --- walls past which grains fall ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    "options",
    [
        ["--friction", 0.5, "--tangential-restitution", 0],
        [*SPRING, "--friction", 0.5],
        [*SPRING, "--friction", 0.5, "--engine", "steps"],
        [*SPRING, "--friction", 0.5, "--engine", "lammps"],
    ],
)
def test_walls_that_rub_do_not_fall(options: list) -> None:
    """Runs are computed in a frame that falls along periodic axes. Smooth walls do not notice."""
    slope = [*SMALL, *shlex.split("--gravity 3 --gravity 0 --gravity=-9")]
    slope += shlex.split("--boundary periodic --boundary periodic --boundary wall")
    message = refused("gas", *slope, *options)
    assert "--gravity: got a component along the periodic x, must be none with friction at walls" in message
    here = options[: -2 if "lammps" in options else None]
    run("gas", *SMALL, *shlex.split("--gravity 3 --gravity 0 --gravity 0"), *here)
    options[options.index(0.5)] = 0
    if "lammps" not in options:
        run("gas", *slope, *options)
