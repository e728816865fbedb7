"""The command line as a user meets it: what it prints, what it writes, how it fails."""

import json
import os
import runpy
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from click.testing import CliRunner, Result

import hardlimit as hl
from hardlimit.cli import main
from hardlimit.cli.axes import axis
from hardlimit.column import files
from hardlimit.contact import law_parameters

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
HERTZ = ["--youngs-modulus", "5e7", "--poisson-ratio", "0.45"]


def run(*args: object, code: int = 0) -> Result:
    result = CliRunner().invoke(main, [str(arg) for arg in args], prog_name="hardlimit")
    assert result.exit_code == code, result.output
    return result


def refused(*args: object) -> str:
    """The one line on stderr with which bad input ends."""
    result = run(*args, code=2)
    assert result.stdout == ""
    lines = result.stderr.splitlines()
    assert len(lines) == 1 and "Traceback" not in lines[0], result.stderr
    return lines[0]


def printed(*args: object) -> dict:
    return json.loads(run(*args, "--json").stdout)


# --- help ---------------------------------------------------------------------------------------------------

COMMANDS = ["drop", "contact", "paper", "sweep", "explore", "completion"]


def test_help_lists_the_commands() -> None:
    for text in (run("--help").stdout, run().stdout):
        for name in COMMANDS:
            assert f"  {name} " in text


@pytest.mark.parametrize("name", COMMANDS)
def test_each_help_shows_an_example(name: str) -> None:
    text = run(name, "--help").stdout
    assert f"Example:\n    hardlimit {name} " in text
    assert max(map(len, text.splitlines())) <= 100


def test_version() -> None:
    assert hl.__version__ in run("--version").stdout


def test_options_of_laws_follow_the_records() -> None:
    text = run("drop", "--help").stdout
    for law in hl.LAWS.values():
        for name in law_parameters(law):
            assert f"--{name.replace('_', '-')} " in text


# --- drop ---------------------------------------------------------------------------------------------------


def test_drop_prints_contacts_and_comparison() -> None:
    text = run("drop").stdout
    assert max(map(len, text.splitlines())) <= 100
    for part in (
        "194.415",
        "220.195",
        "775.172",
        "0.171711",
        "3.72719",
        "0.125465",
        "adiabatic",
        "No: all 4",
    ):
        assert part in text
    assert "[m/s]" in text  # not taken for a style


def test_drop_as_json_is_the_result() -> None:
    found = printed("drop", "--restitution", 0.9, "--gap", 5e-4)
    r = hl.newton(hl.Column.paper(restitution=0.9, gap=5e-4))
    newton = found["models"]["newton"]
    assert newton["relative_velocity"] == r.relative_velocity and newton["n_contacts"] == 1
    assert newton["contacts"]["begin"] == r.contacts["begin"].values.tolist()
    assert found["models"].keys() == {"newton", "adiabatic", "independent"}
    assert found["column"]["law"] == {"name": "linear", "stiffness": 5e7, "restitution": 0.9}
    assert found["verdict"]["event_driven"] == "no"


@pytest.mark.parametrize(
    ("options", "answer"),
    [
        (["--gap", 5e-3], "yes"),
        (["--gap", 1e-4], "no"),
        (["--gap", 10.0], "undecided"),
        (["--restitution", 0.003], "undecided"),
    ],
)
def test_verdict(options: list[object], answer: str) -> None:
    assert printed("drop", *options)["verdict"]["event_driven"] == answer


def test_rebound_height_of_the_textbook() -> None:
    heights = printed("drop", "--restitution", 1, "--gap", 1e-12, "--mass", 1, "--mass", 1e-9)
    r1, r2 = 0.1, 0.01
    textbook = 9 * (0.6 + r1 + r2) - 8 * (2 * r1 + r2)
    assert heights["models"]["independent"]["rebound_heights"][1] == pytest.approx(textbook, rel=1e-7)


def test_drop_options_reach_the_column() -> None:
    column = printed("drop", "--radius-ratio", 5, "--density", 1000, "--height", 0.7, "--gravity", 1.62)[
        "column"
    ]
    assert column["balls"] == [{"radius": 0.05, "density": 1000.0}, {"radius": 0.01, "density": 1000.0}]
    assert column["height"] == 0.7 and column["gravity"] == 1.62
    balls = ["--radius", 0.1, "--radius", 0.05, "--radius", 0.02, "--density", 900, "--velocity", -1]
    law = [*HERTZ, "--restitution", 0.8, "--impact-speed", 3]
    column = printed("drop", *balls, *law)["column"]
    assert len(column["balls"]) == 3 and column["velocities"] == [-1.0] * 3
    assert column["law"]["name"] == "viscoelastic"


def test_options_override_the_file(tmp_path: Path) -> None:
    path = files.write(hl.Column.paper(gap=1e-3), tmp_path / "column.toml")
    assert printed("drop", path)["column"]["gaps"] == [1e-3]
    assert printed("drop", path, "--gap", 2e-3)["column"]["gaps"] == [2e-3]


def test_drop_writes_files(tmp_path: Path) -> None:
    names = {"plot": "drop.png", "save": "drop.nc", "toml": "drop.toml"}
    run("drop", *(x for name, file in names.items() for x in (f"--{name}", tmp_path / file)))
    assert (tmp_path / "drop.png").stat().st_size > 10_000
    assert files.read(tmp_path / "drop.toml") == hl.Column.paper()
    with xr.open_dataset(tmp_path / "drop.nc", group="newton/contacts", engine="h5netcdf") as contacts:
        assert contacts.sizes["contact"] == 5 and contacts.attrs["outcome"] == "ok"
    with xr.open_dataset(tmp_path / "drop.nc", group="independent/trajectory", engine="h5netcdf") as path:
        assert "position" in path


def test_drop_until() -> None:
    contacts = printed("drop", "--until", 5e-4)["models"]["newton"]["contacts"]["begin"]
    assert len(contacts) == 3 and max(contacts) <= 5e-4


def test_cradle_has_no_floor() -> None:
    text = run("drop", EXAMPLES / "newtons_cradle.toml").stdout
    assert "floor" not in text.replace("event-driven", "") and "final velocity of ball 5" in text


# --- contact ------------------------------------------------------------------------------------------------


def test_usual_formula() -> None:
    assert "Asked for 0.5, the usual DEM formula gives 0.5503" in run("contact", "--restitution", 0.5).stdout
    for asked, obtained in ((0.9, 0.9020), (0.7, 0.7182), (0.5, 0.5503), (0.3, 0.3971), (0.1, 0.2527)):
        found = printed("contact", "--restitution", asked)
        assert found["usual_formula"]["restitution"] == pytest.approx(obtained, abs=5e-5)
        assert found["restitution"][0] == pytest.approx(asked, rel=1e-13)


def test_contact_over_speeds() -> None:
    law = [*HERTZ, "--restitution", 0.7, "--impact-speed", 3]
    found = printed("contact", *law, "--speed", 3, "--speed", 0.1, "--other-radius", 0.02)
    assert found["restitution"][0] == pytest.approx(0.7, rel=1e-10) and found["restitution"][1] > 0.8
    assert found["effective_radius"] == pytest.approx(0.01 * 0.02 / 0.03)
    text = run("contact", *law).stdout
    assert "dissipative time" in text and "\n3 " in text


@pytest.mark.parametrize("law", [[], [*HERTZ, "--dissipative-time", 1e-5]])
def test_contact_plot(law: list[str], tmp_path: Path) -> None:
    run("contact", *law, "--plot", tmp_path / "contact.pdf")
    assert (tmp_path / "contact.pdf").read_bytes().startswith(b"%PDF")


# --- sweep --------------------------------------------------------------------------------------------------

MAP = ["--restitution", "0.4:1:7", "--gap", "1e-6:1e-2:9:log"]


def test_sweep_is_the_map(tmp_path: Path) -> None:
    found = printed("sweep", *MAP, "--out", tmp_path / "map.nc", "--plot", tmp_path / "map.png")
    assert found["points"] == 63 and found["sizes"] == {"restitution": 7, "gap": 9}
    assert found["outcomes"] == {"ok": 63}
    expected = hl.sweep(
        hl.Column.paper(), restitution=np.linspace(0.4, 1, 7), gap=np.geomspace(1e-6, 1e-2, 9)
    )
    with xr.open_dataset(tmp_path / "map.nc", engine="h5netcdf") as ds:
        for name in expected.data_vars:
            np.testing.assert_array_equal(ds[name], expected[name])
    assert (tmp_path / "map.png").stat().st_size > 10_000


def test_order_of_the_axes_is_that_of_the_options() -> None:
    assert list(printed("sweep", *MAP[2:], *MAP[:2])["sizes"]) == ["gap", "restitution"]


def test_sweep_resumes_a_store(tmp_path: Path) -> None:
    store = tmp_path / "map.zarr"
    first = printed("sweep", *MAP, "--out", store)
    assert "which exists: --resume" in refused("sweep", *MAP, "--out", store)
    again = printed("sweep", *MAP, "--out", store, "--resume")
    assert again["ranges"] == first["ranges"]


def test_sweep_job_file(tmp_path: Path) -> None:
    job = tmp_path / "job.toml"
    out = tmp_path / "difference.png"
    text = files.dumps(hl.Column.paper())
    job.write_text(
        f'{text}\n[sweep]\nmodel = "newton"\ndifference = "{out}"\n[sweep.axes]\ngap = [1e-4, 1e-3]\n'
        'restitution = "0.5:0.9:3"\n',
        encoding="utf-8",
    )
    assert printed("sweep", job)["sizes"] == {"gap": 2, "restitution": 3}
    assert out.exists()
    job.write_text(text + "\n[sweep]\ncolour = 1\n", encoding="utf-8")
    assert "sweep.colour: unknown" in refused("sweep", job)


def test_sweep_takes_a_tolerance(tmp_path: Path) -> None:
    options = [
        *HERTZ,
        "--dissipative-time",
        "1e-6:1e-4:5:log",
        "--gap",
        "1e-5,1e-4",
        "--out",
        tmp_path / "map.nc",
    ]
    printed("sweep", *options, "--tolerance", "1e-7", "--difference", tmp_path / "difference.png")
    assert (tmp_path / "difference.png").stat().st_size > 10_000
    assert xr.open_dataset(tmp_path / "map.nc").attrs["tolerance"] == 1e-7


def test_sweep_of_another_law() -> None:
    options = [*HERTZ, "--dissipative-time", "1e-6:1e-4:5:log", "--model", "independent"]
    assert printed("sweep", *options)["points"] == 5


@pytest.mark.parametrize(
    ("text", "values"),
    [("0.5", 0.5), ("1,2,4", [1, 2, 4]), ("0:1:3", [0, 0.5, 1]), ("1:100:3:log", [1, 10, 100])],
)
def test_axis(text: str, values: object) -> None:
    np.testing.assert_allclose(axis("gap", text), values)


# --- paper and explore --------------------------------------------------------------------------------------


def test_paper(tmp_path: Path) -> None:
    result = run("paper", "--figures", 2, "--out", tmp_path)
    assert "statements agree" in result.stdout and (tmp_path / "fig2.png").exists()
    assert max(map(len, result.stdout.splitlines())) <= 100


def test_explore_serves(monkeypatch: pytest.MonkeyPatch) -> None:
    from hardlimit.explorer import server

    calls: list[tuple[int, bool]] = []
    monkeypatch.setattr(server, "serve", lambda port, open_browser: calls.append((port, open_browser)))
    run("explore", "--port", 0, "--no-browser")
    assert calls == [(0, False)]


# --- bad input ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["drop", "--radius-1", -0.1], "radius_1: got -0.1, must be > 0 and finite"),
        (["drop", "--radius-2", 0], "radius_2: got 0, must be > 0 and finite"),
        (["drop", "--density", 0], "density: got 0, must be > 0 and finite"),
        (["drop", "--density", "nan"], "density: got nan, must be > 0 and finite"),
        (["drop", "--stiffness", -1], "stiffness: got -1, must be > 0 and finite"),
        (["drop", "--stiffness", 0], "stiffness: got 0, must be > 0 and finite"),
        (["drop", "--gap", -1e-4], "gap: got -0.0001, must be >= 0 and finite"),
        (["drop", "--gap", "inf"], "gap: got inf, must be >= 0 and finite"),
        (["drop", "--restitution", 0], "restitution: got 0, must be in (0, 1]"),
        (["drop", "--restitution", 1.5], "restitution: got 1.5, must be in (0, 1]"),
        (["drop", "--restitution", "nan"], "restitution: got nan, must be in (0, 1]"),
        (["drop", "--restitution", "much"], "got 'much', must be a number"),
        (["drop", "--restitution", 0.5, "--damping", 3], "restitution | damping"),
        (["drop", "--law", "viscoelastic"], "youngs_modulus: missing"),
        (["drop", *HERTZ], "dissipative_time | restitution + impact_speed: got neither"),
        (["drop", "--law", "linear", "--poisson-ratio", 0.3], "poisson_ratio: unknown"),
        (["drop", "--height", 0.05], "height: got 0.05, must be >= 0.1"),
        (["drop", "--height", 0.1], "height: got 0.1, nothing moves"),
        (["drop", "--radius", 0.1], "balls: got 1, must be two or more"),
        (["drop", "--radius", 0.1, "--radius-1", 0.1], "got both"),
        (["drop", "--radius-1", 0.1, "--radius-ratio", 3], "radius_ratio | radius_1: got both"),
        (["drop", "--density", 1, "--mass", 1], "density | mass: got both"),
        (["drop", "--gap", 0.1, "--gap", 0.1], "gap: got 2 values, must be 1"),
        (["drop", "--until", "nan"], "until: got nan, must be finite"),
        (
            ["drop", "--plot", "no folder/a.png"],
            "--plot: got 'no folder/a.png', must be in an existing folder",
        ),
        (["drop", "--plot", "picture.xyz"], "must end in one of"),
        (["drop", "--animate", "film.avi"], "must end in .mp4 or .gif"),
        (["drop", "--save", "no folder/a.nc"], "--save: got"),
        (["drop", "nowhere.toml"], "nowhere.toml: cannot be read"),
        (["drop", "--colour", "red"], "--colour"),
        (["contact", "--radius", -1], "radius: got -1, must be > 0 and finite"),
        (["contact", "--other-mass", 0], "other_mass: got 0, must be > 0 and finite"),
        (["contact", "--speed", 0], "speed: got 0, must be > 0 and finite"),
        (["contact", "--density", 1, "--mass", 1], "density | mass: got both"),
        (["paper", "--figures", "9"], "figures: got '9', must be among 2, 3, 4, 5, 6, 7, 8"),
        (["paper", "--density", 0], "density: got 0, must be > 0"),
        (["paper", "--format", "doc"], "format: got 'doc'"),
        (["paper", "--out", "/proc/figures"], "out: got '/proc/figures'"),
        (["sweep"], "axes: got none"),
        (["sweep", "--gap", "1:2"], "gap: got '1:2', must be a number, a list"),
        (["sweep", "--gap", "0:1:3:log"], "must have a start and a stop > 0"),
        (["sweep", "--gap", "1:2:0"], "gap: got 0 points"),
        (["sweep", "--gap", "-1:1:3"], "gap: got -1, must be >= 0"),
        (["sweep", "--restitution", "0.5:2:3"], "restitution: got 2, must be in (0, 1]"),
        (["sweep", *MAP, "--model", "magic"], "model: got 'magic'"),
        (["sweep", *MAP, "--engine", "steam"], "engine: got 'steam'"),
        (["sweep", *MAP, "--threads", 0], "threads: got 0"),
        (["sweep", *MAP, "--tolerance", 1e-9], "tolerance: got 1e-09, must not be given"),
        (["sweep", *MAP, "--out", "map.csv"], "--out: got 'map.csv', must end in .nc or .zarr"),
        (["sweep", *MAP, "--resume"], "--resume: needs --out"),
        (["sweep", *MAP, "--height", "0.5,0.6", "--plot", "a.png"], "must be one or two"),
        (["explore", "--port", "lots"], "--port"),
        (["jump"], "jump"),
    ],
)
def test_bad_input(args: list[object], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    line = refused(*args)
    assert line.startswith("hardlimit") and message in line
    assert list(tmp_path.iterdir()) == []


def test_broken_toml_is_one_line(tmp_path: Path) -> None:
    path = tmp_path / "broken.toml"
    path.write_text("height = \n", encoding="utf-8")
    assert "broken.toml: not valid TOML" in refused("drop", path) and "line 1" in refused("drop", path)
    path.write_text("height = 1\nhieght = 2\n", encoding="utf-8")
    assert "hieght: unknown" in refused("drop", path)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_unwritable_folder(tmp_path: Path) -> None:
    tmp_path.chmod(0o555)
    assert "must be writable" in refused("drop", "--plot", tmp_path / "drop.png")


def test_a_folder_is_no_file(tmp_path: Path) -> None:
    (tmp_path / "drop.png").mkdir()
    assert "must be writable" in refused("drop", "--plot", tmp_path / "drop.png")


# --- as a process -------------------------------------------------------------------------------------------


def test_module_runs_and_errors_go_to_stderr() -> None:
    command = [sys.executable, "-m", "hardlimit", "drop", "--gap", "-1"]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert (ended.returncode, ended.stdout) == (2, "")
    assert ended.stderr == "hardlimit drop: gap: got -1, must be >= 0 and finite\n"


def test_ctrl_c_ends_with_130() -> None:
    axes = ["--restitution", "0.4:1:30000", "--gap", "1e-6:1e-2:30000:log", "--variable", "n_contacts"]
    command = [sys.executable, "-m", "hardlimit", "sweep", *axes]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        time.sleep(3.0)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=30)
    assert process.returncode == 130 and out == "" and err.strip() == "interrupted"


# --- examples -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.toml")), ids=lambda p: p.stem)
def test_example_files_run(path: Path) -> None:
    if "[sweep]" in path.read_text(encoding="utf-8"):
        assert printed("sweep", path)["outcomes"] == {"ok": 3600}
    else:
        assert printed("drop", path)["models"]["newton"]["outcome"] == "ok"


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.py")), ids=lambda p: p.stem)
def test_example_scripts_run(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(path), run_name="__main__")
    assert capsys.readouterr().out
