"""``hardlimit gas --engine``: the same boxes under Newton's equations, as a user meets them."""

import pytest
import xarray as xr

import hardlimit as hl
from command_line import printed, refused, run
from conftest import lattice

LAW = ["--law", "linear", "--stiffness", "1e6", "--restitution", 0.9]


@pytest.fixture
def start(tmp_path):
    """A file of 27 spheres."""
    return lattice(27, seed=1).write(tmp_path / "start.xyz")


@pytest.mark.parametrize("engine", ["events", "steps"])
def test_json_agrees_with_the_library(start, engine):
    output = printed("gas", start, *LAW, "--engine", engine, "--until", "2ms", "--samples", 4)
    law = hl.LinearDashpot(stiffness=1e6, restitution=0.9)
    result = hl.molecular_dynamics(
        hl.ParticleSystem.read(start), law=law, until=0.002, engine=engine, samples=4
    )
    assert output["n_contacts"] == result.n_contacts > 0 and output["engine"] == engine
    assert output["outcome"]["name"] == "ok" and output["early_end"] is None
    assert output["series"]["kinetic_energy"] == result.series.kinetic_energy.values.tolist()
    assert output["law"] == {"name": "linear", "stiffness": 1e6, "restitution": 0.9}
    assert output["time_step"] == result.time_step and output["largest_cluster"] == result.largest_cluster


def test_the_table_and_the_file(start, tmp_path):
    options = ["--engine", "events", "--until", "2ms", "--save", tmp_path / "run.nc"]
    text = run("gas", start, *LAW, *options).stdout
    assert "27 spheres" in text and "outcome: ok" in text
    assert "Newton's equations, linear law: k 1e6 N/m, ε 0.9" in text
    assert max(map(len, text.splitlines())) <= 100
    with xr.open_datatree(tmp_path / "run.nc") as tree:
        assert tree["contacts"].sizes["contact"] > 0 and tree["final"].sizes["particle"] == 27


def test_the_input_of_lammps_alone(start, tmp_path):
    options, path = ["--engine", "lammps", "--until", "2ms", "--time-step", "0.5us"], tmp_path / "run"
    said = run("gas", start, *LAW, *options, "--write-input", path).stdout.replace("\n", "")
    assert str(path / "in.hardlimit") in said
    assert "pair_style granular" in (path / "in.hardlimit").read_text(encoding="utf-8")


def test_a_run_goes_on(start, tmp_path):
    """From its checkpoint, with the same bits, and with frames from there on."""
    path, until = tmp_path / "run.checkpoint", ["--until", "2ms"]
    printed("gas", start, *LAW, "--engine", "events", "--until", "1ms", "--samples", 4, "--checkpoint", path)
    longer = printed(
        "gas", "--resume", path, *until, "--out", tmp_path / "run.xyz", "--animate", tmp_path / "a.gif"
    )
    whole = printed("gas", start, *LAW, "--engine", "events", *until, "--samples", 8)
    assert longer["series"] == whole["series"] and len(longer["files"]) == 2
    assert hl.ParticleSystem.read(tmp_path / "run.xyz", frame=3).n == 27
    assert "--plot: must be left out" in refused("gas", "--resume", path, "--plot", tmp_path / "a.png")


LAMMPS = ["--engine", "lammps", *LAW]
REFUSED = {
    "--ranks: must be left out without --engine": ["--ranks", 2],
    "--law: missing, must be given with its parameters for --engine": ["--engine", "steps"],
    "rule: must be left out with --engine": ["--engine", "events", *LAW, "--rule", "tc"],
    "--plot: must be left out with --engine": ["--engine", "events", *LAW, "--plot", "a.png"],
    "--write-input: must be left out with --engine steps": ["--engine", "steps", *LAW, "--write-input", "a"],
    "--ranks: must be left out with --write-input": [*LAMMPS, "--write-input", "a", "--ranks", 2],
    "--time-step: got 0.001, must be left out": ["--engine", "events", *LAW, "--time-step", "1ms"],
    "--n: must be left out with --resume": ["--engine", "events", *LAW, "--resume", "a"],
}


@pytest.mark.parametrize("words", REFUSED)
def test_what_does_not_go_together_is_one_line(words, tmp_path):
    assert words in refused("gas", "--n", 27, *REFUSED[words])
