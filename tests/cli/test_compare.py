"""``hardlimit gas compare``: output, files and error messages."""

import re
from pathlib import Path

import pytest
import xarray as xr
from click.testing import CliRunner

import hardlimit as hl
from command_line import printed, refused, run
from conftest import lattice
from hardlimit.cli import main
from legible import assert_legible, coloured

ELASTIC = hl.LinearDashpot(stiffness=1e5, restitution=1.0)
FAST = ["--until", "1ms", "--samples", "5", "--workers", "1"]


@pytest.fixture
def start(tmp_path: Path) -> Path:
    return lattice(27, seed=1).write(tmp_path / "start.xyz")


def test_json_agrees_with_the_library(start: Path) -> None:
    output = printed(
        "gas", "compare", start, "--restitution", 0.8, "--stiffness", 2e5, "--replicas", 2, *FAST
    )
    law = hl.LinearDashpot(stiffness=2e5, restitution=0.8)
    f = hl.fidelity(hl.ParticleSystem.read(start), law=law, until=1e-3, samples=5, replicas=2)
    assert output["summary"] == str(f) and output["tc_nu"] == f.tc_nu
    assert output["models"] == list(f.models) and output["outcomes"]["soft"] == ["ok", "ok"]
    difference = output["variables"]["difference"]
    assert difference["dims"] == ["quantity", "model", "time", "statistic"]
    at = output["coordinates"]["quantity"].index("pressure"), output["models"].index("tc")
    assert difference["values"][at[0]][at[1]][-1][0] == f.final_difference("pressure", "tc").value


@pytest.mark.slow
def test_tables_pictures_and_files(tmp_path: Path) -> None:
    """Each replica from another random start; the same call finds them all in the store."""
    out, plot, store = tmp_path / "f.nc", tmp_path / "f.png", tmp_path / "store"
    options = ["--n", 40, "--replicas", 3, "--models", "soft", "--models", "tc", "--store", store, *FAST]
    text = run("gas", "compare", *options, "--out", out, "--plot", plot).stdout
    words = " ".join(text.split())
    assert "40 spheres" in text and "Difference from Newton’s equations at the end" in text
    assert " 3 replicas" in words and "fraction that overlap another" in text
    assert max(map(len, text.splitlines())) <= 100
    means = xr.open_dataset(out)
    assert means.model.values.tolist() == ["newton", "soft", "tc"] and coloured(plot) > 0.01
    again = run("gas", "compare", *options).stdout
    assert again in text and text.startswith(again)
    assert "was made with seed 0, not 5" in refused("gas", "compare", *options, "--seed", 5)
    assert "was made with another start; " in refused("gas", "compare", "--n", 41, *options[2:])


def test_one_replica_and_one_model(start: Path) -> None:
    text = run("gas", "compare", start, "--replicas", 1, *FAST).stdout
    words = " ".join(text.split())
    assert "one replica has no error bars" in words and "ask for more, such as --replicas 8" in words
    alone = run("gas", "compare", start, "--replicas", 2, "--models", "newton", *FAST).stdout
    assert "no rule to compare with" in " ".join(alone.split()) and "Difference" not in alone


def test_differences_that_are_not_resolved(start: Path) -> None:
    """Wide error bars are not agreement, unless that resolution is sufficient."""
    options = [start, "--stiffness", 1e5, "--replicas", 3, "--models", "soft", *FAST]
    text = " ".join(run("gas", "compare", *options).stdout.split())
    assert (
        "the rule soft is not resolved by cooling: ± " in text and "not significantly different" not in text
    )
    assert re.search(
        r"% with 3 replicas \(99 % confidence\); for ± 1 % about \d+ replicas would be needed\.", text
    )
    assert "? not resolved: bars over 1 %" in text and not re.search(r"\de[+-]?\d+ ?%", text)
    output = printed("gas", "compare", *options, "--resolution", 1)
    assert output["resolution"] == 1.0 and "is not significantly different" in output["summary"]
    needed = output["variables"]["replicas_needed"]
    assert needed["dims"] == ["quantity", "model"]
    at = output["coordinates"]["quantity"].index("cooling"), output["models"].index("soft")
    assert 2 <= needed["values"][at[0]][at[1]] <= 3


def test_four_rules_fit_a_narrow_terminal(start: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    text = run("gas", "compare", start, "--stiffness", 1e5, "--replicas", 3, *FAST).stdout
    assert max(map(len, text.splitlines())) <= 60
    rows = text.partition("at the end [%]")[2].partition("± standard error")[0]
    for name in ("temperature", "cooling", "dissipation", "pressure"):
        (row,) = (line for line in rows.splitlines() if line.startswith(f"{name} "))
        assert row.count("±") == 4 or name == "pressure"


def test_a_job_gives_start_law_and_end(tmp_path: Path) -> None:
    job = tmp_path / "job.toml"
    job.write_text(
        '[random]\nn = 30\npacking_fraction = 0.2\nradius = "1 mm"\ndensity = 2500\nrms_speed = 1\n'
        '[event_driven]\nrestitution = 0.7\nuntil = "0.5 ms"\nrule = "constant"\n'
    )
    output = printed("gas", "compare", job, "--replicas", 2, "--workers", 1, "--samples", 3)
    assert output["law"] == "LinearDashpot(stiffness=1000000.0, restitution=0.7)"
    assert output["coordinates"]["time"][-1] == 5e-4 and output["system"].startswith(
        "<ParticleSystem of 30 spheres"
    )


REFUSED = {
    "--models: got 'hard'": ["--models", "hard"],
    "--replicas: got 0": ["--replicas", 0],
    "--out: got 'x.csv', must end in .nc": ["--out", "x.csv"],
    "FILE: got 'nothing'": ["nothing"],
    "--resolution: got 0": ["--resolution", 0],
    "--engine: got 'lammps'": ["--engine", "lammps"],
    "--scheduler | --workers": ["--scheduler", "tcp://127.0.0.1:1", "--workers", 2],
    "No such option": ["--rule", "soft"],
}


@pytest.mark.parametrize("message", REFUSED)
def test_bad_input_is_refused_in_one_line(message: str) -> None:
    said = refused("gas", "compare", *REFUSED[message], "--n", 20, "--until", "1us")
    assert said.startswith(f"hardlimit gas compare: {message}")


@pytest.mark.slow
@pytest.mark.parametrize(
    "options", [{}, {"replicas": 1}, {"models": ("newton",)}, {"until": 0.0}, {"law": ELASTIC}]
)
def test_pictures_can_be_read(options: dict) -> None:
    law = hl.Viscoelastic(youngs_modulus=1e8, poisson_ratio=0.3, dissipative_time=2e-5)
    arguments = {"law": law, "until": 2e-3, "samples": 8, "replicas": 2} | options
    assert_legible(hl.fidelity(lattice(27, seed=2), **arguments).plot())


@pytest.mark.parametrize(
    ("words", "offered"),
    [
        (["gas", "comp"], {"plain,compare", "file,comp"}),
        (["gas", "start"], {"file,start"}),
        (["gas", "compare", "--replic"], {"plain,--replicas"}),
    ],
)
def test_completion(words: list[str], offered: set[str]) -> None:
    variables = {"COMP_WORDS": " ".join(["hardlimit", *words]), "COMP_CWORD": str(len(words))}
    env = variables | {"_HARDLIMIT_COMPLETE": "bash_complete"}
    completed = CliRunner().invoke(main, prog_name="hardlimit", env=env)
    assert set(completed.stdout.split()) == offered


DUMPS = Path(__file__).parents[1] / "boxes" / "data" / "dumps"
EXAMPLES = Path(__file__).parents[2] / "examples"


def test_a_dump_whose_grains_overlap() -> None:
    """Refused in one line with the largest overlap and the option; accepted with it, and said."""
    options = [EXAMPLES / "dump.gas.gz", "--stiffness", 2e3, "--frame", 1, "--models", "law", *FAST]
    message = refused("gas", "compare", *options)
    assert "overlap, gap -0.000" in message and "; --allowed-overlap accepts more, 0." in message
    needed = message.rpartition(" accepts more, ")[2].partition(" here")[0]
    output = printed("gas", "compare", *options, "--allowed-overlap", needed, "--replicas", 2)
    system = hl.ParticleSystem.read(options[0], frame=1, allowed_overlap=0.4)
    law = hl.LinearDashpot(stiffness=2e3, restitution=0.9)
    stored = hl.molecular_dynamics(system, law=law, until=0.0).series.contact_energy.values[0]
    assert output["energy_of_overlaps"] == pytest.approx(stored / system.kinetic_energy) and stored > 0.0
    assert output["largest_overlap"] == pytest.approx(float(needed), rel=1e-5)
    assert output["system"] == repr(system)


def test_walls_and_gravity_around_a_dump() -> None:
    """There is one replica, because the state is no gas."""
    bed = [DUMPS / "bed.liggghts", "--allowed-overlap", 0.01, "--gravity", 9.81, "--stiffness", 2e3]
    walls = [word for side in ("wall", "periodic", "wall") for word in ("--boundary", side)]
    text = run("gas", "compare", *bed, *walls, "--models", "law", *FAST).stdout
    assert "x wall, y periodic, z wall" in text and "energy of the overlaps / kinetic" in text
    words = " ".join(text.split())
    assert (
        "one replica has no error bars" in words and "more need a gas" in words and "--replicas" not in words
    )
    dense = refused("gas", "compare", EXAMPLES / "dump.bed", "--allowed-overlap", 0.01, *FAST)
    assert "density: missing in the file; --density gives it" in dense
