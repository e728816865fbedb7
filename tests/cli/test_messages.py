"""Error messages name the option that was typed, the value given and the accepted values."""

from __future__ import annotations

import re
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from test_cli import COMMANDS, command, every_option

import hardlimit as hl
from bad_values import NO_QUANTITY
from command_line import printed, refused, run
from conftest import lattice, refusal, slow, typical
from hardlimit.cli.options import Quantity
from hardlimit.contact.contact import law_parameters
from hardlimit.support import validation

WORD = 2**31 - 1
EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def folder_of_measurements(folder: Path) -> Path:
    (folder / "impacts.csv").write_text(run("fit", "--example").stdout)
    return folder


# --- bounds -------------------------------------------------------------------------------------------------


def test_a_bound_in_a_message_is_accepted_and_short() -> None:
    """Over magnitudes, signs and both sides: six digits, rounded to the accepted side."""
    chance = np.random.default_rng(1)
    for _ in range(300):
        bound = float(chance.choice([-1.0, 1.0]) * 10 ** chance.uniform(-12, 12) * chance.uniform(1, 10))
        below = refusal(lambda b=bound: validation.number("x", b - abs(b), b, lowest_allowed=True))
        above = refusal(lambda b=bound: validation.number("x", b + abs(b), -np.inf, b, highest_allowed=True))
        for message in (below, above):
            text = re.search(r"must be [<>]= (\S+)", message)[1]
            assert len(re.sub(r"e.*|\D", "", text).lstrip("0")) <= 6, message
        told = float(re.search(r">= (\S+)", below)[1])
        assert validation.number("x", told, bound, lowest_allowed=True) == pytest.approx(bound, rel=1e-5)
        told = float(re.search(r"<= (\S+)", above)[1])
        number = validation.number("x", told, -np.inf, bound, highest_allowed=True)
        assert number == pytest.approx(bound, rel=1e-5)


@pytest.mark.parametrize(
    ("value", "lowest", "highest", "words"),
    [
        (1, 2, 20, "a whole number in [2, 20]"),
        (99, 313816, 2**62, "a whole number >= 313816"),
        ("a", 0, 2**63 - 1, "a whole number >= 0"),
        (1.5, -(2**31), WORD, "a whole number"),
        (10**30, 0, 2**62, "a whole number <= 4.61168e+18"),
        (-(10**30), -(2**31), WORD, "a whole number >= -2.14748e+09"),
    ],
)
def test_technical_bounds_are_named_only_if_exceeded(
    value: Any, lowest: int, highest: int, words: str
) -> None:
    assert refusal(lambda: validation.whole("x", value, lowest, highest)).endswith(f", must be {words}")


def test_a_time_before_the_release() -> None:
    column = hl.Column.paper()
    message = refusal(lambda: hl.newton(column, -1.0))
    assert message.startswith("until: got -1, must be >= -0.319275, the release")
    hl.newton(column, -0.319275)


def test_an_end_before_the_checkpoint(tmp_path: Path) -> None:
    path = tmp_path / "a.checkpoint"
    hl.event_driven(lattice(27), restitution=0.9, max_collisions=60, checkpoint=path)
    assert refusal(lambda: hl.resume(path, max_collisions=10)).endswith("must be a whole number >= 60")
    told = re.search(r"must be >= (\S+), the time", refusal(lambda: hl.resume(path, until=0.0)))[1]
    assert len(told.replace(".", "").lstrip("0")) <= 6
    hl.resume(path, until=float(told))


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("boundary", ["wall", "periodic"])
def test_a_position_in_a_message_is_accepted(boundary: str, seed: int) -> None:
    radius, edge = np.random.default_rng(seed).uniform(1.0, 2.0, 2) * (1.0, 10.0)

    def system(x: float) -> hl.ParticleSystem:
        return hl.ParticleSystem([[x, edge / 2]], [[0.0, 0.0]], radius, mass=1.0, box=edge, boundary=boundary)

    for outside in (-edge, 3.0 * edge):
        for told in re.search(
            r"must be in \[(.*), (.*)\], ", refusal(lambda at=outside: system(at))
        ).groups():
            assert len(told) <= 7
            system(float(told))


# --- alternatives -------------------------------------------------------------------------------------------


def test_alternatives_are_named() -> None:
    linear, viscoelastic = (
        partial(hl.LinearDashpot, stiffness=1e6),
        partial(hl.Viscoelastic, poisson_ratio=0.3),
    )
    need = "must be restitution or damping"
    assert refusal(linear) == f"restitution | damping: got neither, {need}"
    assert refusal(partial(linear, restitution=0.5, damping=1.0)).endswith(
        f"got restitution and damping, {need}"
    )
    refused_speed = refusal(partial(viscoelastic, youngs_modulus=1e8, impact_speed=1.0))
    assert refused_speed.endswith("impact_speed: got impact_speed, must be restitution + impact_speed")
    assert "got both, must be exactly one" in refusal(lambda: hl.Ball(0.1, density=1.0, mass=1.0))
    assert "got neither, must be exactly one" in refusal(lambda: hl.Ball(0.1))


# --- the command line: the option that was typed ------------------------------------------------------------


def beside(name: str, typed: str) -> list[str]:
    """The other options that must be given for an option to be checked."""
    parameter = typed[2:].replace("-", "_")
    if name == "convert":
        return beside_conversion(typed)
    words = {"fit": ["impacts.csv"], "sweep": ["--gap", "1um,2um"]}.get(name, [])
    law = next((law for law in hl.LAWS.values() if parameter in law_parameters(law)), None)
    if law is not None:
        common, choices = law.record["common"], law.record["alternatives"]
        choice = next((c for c in choices if parameter in {p["name"] for p in c}), choices[0])
        options = {p["name"]: typical(p) for p in [*common, *choice] if p["name"] != parameter}
        words = [*words, "--law", law.record["name"]]
        words += [f"--{p.replace('_', '-')}={value}" for p, value in options.items()]
    if name == "fit" and (typed.startswith("--other") or typed in ("--radius", "--density", "--mass")):
        pairs = {"--radius": "1mm", "--density": "2500", "--other-radius": "1mm", "--other-density": "2500"}
        pairs.pop({"--mass": "--density", "--other-mass": "--other-density"}.get(typed, typed))
        words += [word for pair in pairs.items() for word in pair]
    if name == "check":
        options = {"--radius": "1mm", "--density": "2500"} | (
            {} if law else {"--stiffness": 1, "--restitution": 1}
        )
        options.pop("--density" if typed == "--mass" else typed, None)
        words += [f"{option}={value}" for option, value in options.items()]
    if name == "gas" and typed in ("--restitution-error", "--time-step"):
        words += ["--engine", "steps", "--stiffness", "1e5", "--restitution", "0.5"]
    both = {"--friction": "0.5", "--tangential-restitution": "0.3"}
    if name == "gas" and typed in both:
        words += [word for option in both.items() if option[0] != typed for word in option]
    needed = {
        "--contact-duration": ["--rule", "tc"],
        "--checkpoint-every": ["--checkpoint", "run.checkpoint"],
    }
    return [*words, *(needed.get(typed, []) if name == "gas" else [])]


def beside_conversion(typed: str) -> list[str]:
    options = {"--radius": "1mm", "--density": "2500", "--restitution": "0.5", "--stiffness": "1e5"}
    instead = {"--mass": "--density", "--youngs-modulus": "--stiffness", "--duration": "--stiffness"}
    instead |= {"--compression": "--stiffness", "--poisson-ratio": "--stiffness"}
    options.pop(instead.get(typed, typed), None)
    options |= {
        "--youngs-modulus": {"--poisson-ratio": "0.3"},
        "--poisson-ratio": {"--youngs-modulus": "1e8"},
    }.get(typed, {})
    return [word for pair in options.items() for word in pair]


@pytest.mark.parametrize("name", [*COMMANDS, "gas compare"])
def test_messages_name_the_option_that_was_typed(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """For each option that takes a quantity: text that is no number, and nan, which no parameter accepts."""
    monkeypatch.chdir(folder_of_measurements(tmp_path))
    for typed in [o.opts[0] for of, o in every_option() if of == name and isinstance(o.type, Quantity)]:
        for value in NO_QUANTITY:
            message = refused(*name.split(), *beside(name, typed), f"{typed}={value}")
            named = message.removeprefix(f"hardlimit {name}: ").partition(": got")[0]
            assert typed in re.split(r" \| |\[", named), message


def test_messages_name_options_that_differ_from_the_parameter() -> None:
    said = "hardlimit stack: --balls: got 1, must be a whole number in [2, 20]"
    assert refused("stack", "--balls", 1) == said
    assert "--gap: got -1, must be >= 0" in refused("drop", "--gap=-1")
    three = [*["--radius", 0.1] * 3, "--density", 900]
    assert "--gap[1]: got -1" in refused("drop", *three, "--gap", 1, "--gap=-1")
    assert "--speed: got 0, must be > 0" in refused("stack", "--speed", 0)
    assert "--density | --mass: got both" in refused("drop", "--density", 1, "--mass", 1)


def test_messages_about_a_file_name_no_option(tmp_path: Path) -> None:
    (tmp_path / "job.toml").write_text("[random]\nn = 0\n")
    assert "gas: n: got 0" in refused("gas", tmp_path / "job.toml")
    assert "gas: --n: got 0" in refused("gas", tmp_path / "job.toml", "--n", 0)


# --- the command line: commands and files -------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "nearest"),
    [
        (["drpo"], "drop"),
        (["swep"], "sweep"),
        (["gas", "comapre"], "compare"),
        (["gas", "compair"], "compare"),
    ],
)
def test_the_nearest_command_is_suggested(words: list[str], nearest: str) -> None:
    message = refused(*words)
    assert f"No such command '{words[-1]}'. Did you mean '{nearest}'?" in message


def test_no_suggestion_for_an_unrelated_word(tmp_path: Path) -> None:
    assert refused("qqq") == "hardlimit: No such command 'qqq'."
    assert "must end in .toml" in refused("gas", "qqq")
    assert "no such file" in refused("gas", tmp_path / "compare.toml")


def test_the_help_of_gas_lists_compare() -> None:
    listed = run("gas", "--help").stdout.partition("Commands:\n")[2]
    assert re.match(r" +compare +Compare each rule", listed)


FILES = [
    ["drop", "{}.toml"],
    ["sweep", "{}.toml"],
    ["gas", "{}.toml"],
    ["gas", "{}.xyz"],
    ["gas", "{}.data"],
    ["gas", "--resume", "{}"],
    ["gas", "compare", "{}.toml"],
    ["fit", "{}.csv"],
    ["fit", "--column", "{}.toml", "{}.csv"],
    ["convert", "--radius", "1mm", "--density", "2500", "--code", "lammps", "--read", "{}"],
    ["check", "{}"],
    ["check", str(EXAMPLES / "in.granular_gas"), "--dump", "{}"],
]


@pytest.mark.parametrize("words", FILES, ids=" ".join)
def test_a_file_that_cannot_be_read_is_bad_input(words: list[str], tmp_path: Path) -> None:
    missing = tmp_path / "missing"
    assert re.search(f"{missing}[.a-z]*: no such file$", refused(*(w.format(missing) for w in words)))
    for ending in (".toml", ".csv", ".xyz", ".data", ""):
        (tmp_path / f"folder{ending}").mkdir()
    assert "cannot be read" in refused(*(w.format(tmp_path / "folder") for w in words))


SMALL = "--n 20 --packing-fraction 0.05 --until 1us"
SOFT = "--stiffness 1e-5 --restitution 0.9"
STIFF = "--stiffness 1e5 --restitution 0.9"
#: Wrong calls, and what the message says; ``refused`` checks that it has no words of Python.
WRONG = {
    f"gas {SMALL} {SOFT}": "--law: got linear --stiffness 1e-05 --restitution 0.9, must be stiffer",
    f"gas {SMALL} --engine events {SOFT}": "--law: got linear --stiffness 1e-05 --restitution 0.9, must be",
    f"gas {SMALL} --shake 1mm:50Hz --boundary periodic": "--shake: got 'z-', must be on an axis",
    f"gas {SMALL} --shake 0:50Hz": "--shake: got 0 and 50, must both be > 0",
    f"gas {SMALL} --heat 1 --engine lammps --stiffness 1e5 --restitution 0.9": "--heat: got random kicks, power 1 W",
    f"gas {SMALL} --shake 1mm:50Hz --engine lammps --stiffness 1e5 --restitution 0.9": "--shake: got z-, must be none",
    f"gas {SMALL} --law viscoelastic --stiffness 1e9": "--stiffness: unknown, Viscoelastic takes --youngs-modulus",
    f"gas {SMALL} --youngs-modulus 1e9 --poisson-ratio 0.3 --restitution 0.5 --law viscoelastic": "--impact-speed",
    "gas overlap.xyz": "particles 0 and 1 overlap, gap -0.005 m, must be >= -1e-11 m, 1e-09 of the sum of the radii",
    "gas empty.xyz": "empty.xyz: is empty, must have one frame or more",
    "gas pair.xyz --law linear": "--stiffness: missing, must be > 0",
    f"gas {SMALL} --friction 0.5": "--tangential-restitution: missing, must be given with --friction",
    f"gas {SMALL} --tangential-restitution 0.5": "--friction: missing, must be given with --tangential-restitution",
    f"gas {SMALL} --stiffness-ratio 2/7": "--stiffness-ratio: got 0.2857142857142857, must be left out without",
    f"gas {SMALL} {STIFF} --stiffness-ratio 2/7": "--friction: missing, must be given beside --stiffness-ratio",
    f"gas {SMALL} {STIFF} --friction 1 --tangential-restitution 0": "left out with a law, whose --friction says",
    f"gas {SMALL} --engine steps --friction 0.5": "--law: missing, must be given with its parameters for --engine",
    f"gas {SMALL} --rms-spin equl": "'10 rad/s', or equal",
    "gas pair.xyz --rms-spin 1": "--rms-spin: must be left out with a start from a file",
    f"gas compare {SMALL} --tangential-restitution 1": "--tangential-restitution: got 1.0, must be left out for a law",
    f"gas compare {SMALL} --friction 0.5 --tangential-restitution 2": "--tangential-restitution: got 2, must be in [",
    f"gas compare {SMALL} --store checkpoint": "--store: checkpoint is the checkpoint of a run, must be a store of",
    "fit speeds.csv": "speeds.csv: values without errors, or with 0: add a column restitution_error, or --scatter",
    "fit times.csv": "add a column time_error, or --scatter",
    "fit impacts.csv --law linear --free stiffness": "--radius: missing, must be given to fit stiffness",
    "fit impacts.csv --free ball": "options of the law | --free: got ball, must be parameters",
    "check in.lj": "FILE: has no granular contacts",
    "check in.lj --power 1 --speed 1": "--speed | --power | --shear: must be at most one",
    "contact --law tsuji": "must be --elastic-prefactor + --restitution or",
    "contact --other-radius 1mm --other-mass 1 --other-density 1": "--other-density | --other-mass: got both",
    "convert --radius 1mm --density 2500 --restitution 0.9 --youngs-modulus 1e9": "beside --youngs-modulus",
    "drop --radius 1 --radius-1 2": "--radius | --radius-1, --radius-2, --radius-ratio: got both",
    "sweep --gap 1:2:100000 --restitution 0.4:1:90000": "; --out FILE.zarr keeps them on disk, --variable keeps fewer",
    "stack --stiffness 1": "--law: got linear --stiffness 1.0 --restitution 0.7, must be stiffer",
    "cite hertz": "TOPIC: got 'hertz', must be one of newton",
}


@pytest.mark.parametrize("line", WRONG)
def test_messages_have_no_words_of_python(line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder_of_measurements(tmp_path))
    pair = hl.ParticleSystem([[0.02, 0.05], [0.04, 0.05]], np.zeros((2, 2)), 0.005, density=2500.0, box=0.1)
    written = pair.write("pair.xyz").read_text()
    for name, text in {
        "overlap.xyz": written.replace("0.04 ", "0.025 "),
        "empty.xyz": "",
        "speeds.csv": "speed,restitution\n0.1,0.9\n1,0.8\n",
        "times.csv": "time\n0\n0.5\n0.9\n1.2\n",
        "in.lj": "units lj\npair_style lj/cut 2.5\n",
    }.items():
        Path(name).write_text(text)
    hl.event_driven(pair, restitution=0.9, until=0.001, checkpoint="checkpoint")
    assert WRONG[line] in refused(*line.split())


def test_a_parameter_to_fit_may_be_spelled_as_its_option(tmp_path: Path) -> None:
    file = folder_of_measurements(tmp_path) / "impacts.csv"
    options = ["--youngs-modulus", "1e9", "--poisson-ratio", "0.3", "--impact-speed", "1", "--no-compare"]
    fitted = [
        printed("fit", file, *options, "--free", name, "--radius", "1cm", "--density", "1000")["parameters"]
        for name in ("restitution", "--restitution")
    ]
    assert fitted[0] == fitted[1] and list(fitted[0]) == ["restitution"]


def outputs(name: str) -> list[str]:
    """Options that name a file to write by its ending."""
    others = ("--checkpoint", "--resume", "--store", "--read", "--column", "--dump")
    options = [o for of, o in every_option() if of == name and (o.metavar or "").startswith("FILE")]
    return [o.opts[0] for o in options if o.opts[0] not in others]


MINIMAL = {
    "sweep": ["--gap", "1um,2um"],
    "fit": ["impacts.csv"],
    "gas": ["--n", "20", "--until", "1us"],
    "gas compare": ["--n", "20", "--until", "1us", "--replicas", "1"],
}


@pytest.mark.parametrize("name", [name for name in [*COMMANDS, "gas compare"] if outputs(name)])
def test_an_ending_that_is_not_known_is_refused_before_anything_is_computed(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder_of_measurements(tmp_path))
    before = sorted(tmp_path.iterdir())
    for module in ("drop.compare", "sweep.compute", "fit.fitted", "stack.best"):
        monkeypatch.setattr(f"hardlimit.cli.{module}", lambda *_, **__: pytest.fail("computed"))
    monkeypatch.setattr("hardlimit.boxes.starts.positions", lambda *_: pytest.fail("computed"))
    for typed in outputs(name):
        for file in ("file.abc", "file"):
            message = refused(*name.split(), *MINIMAL.get(name, []), typed, file)
            assert f"{typed}: got '{file}', must end in ." in message
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize(
    "name",
    [
        name if name in ("drop", "contact") else slow(name)
        for name in [*COMMANDS, "gas compare"]
        if "--plot" in outputs(name)
    ],
)
def test_every_picture_has_its_resolution(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder_of_measurements(tmp_path))
    run(*name.split(), *MINIMAL.get(name, []), "--plot", "plot.png", "--dpi", 40)
    with Image.open("plot.png") as picture:
        assert picture.info["dpi"] == pytest.approx((40, 40), abs=0.1)
        assert 100 <= min(picture.size) < max(picture.size) < 600  # 2.5 to 15 inches


# --- the command line: what help says of defaults ------------------------------------------------------------


def help_of(name: str, typed: str) -> str:
    return next(o.help for o in command(name).params if o.opts[0] == typed)


def test_help_tells_how_many_threads_there_are() -> None:
    from hardlimit.boxes.newton import PARTICLES_PER_THREAD, checked_threads

    assert checked_threads(None, PARTICLES_PER_THREAD) == 1
    assert f"one for each {PARTICLES_PER_THREAD} particles" in help_of("gas", "--threads")
    assert "1 with the engine dask" in help_of("sweep", "--threads")
