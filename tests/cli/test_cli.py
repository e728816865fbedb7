"""The command line: output, files, exit codes and error messages."""

import json
import math
import os
import re
import resource
import runpy
import shlex
import signal
import socket
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from unittest import mock

import click
import numpy as np
import pytest
import xarray as xr

import hardlimit as hl
from command_line import printed, refused, run
from conftest import law_of, slow
from hardlimit import _core
from hardlimit.cli import main
from hardlimit.cli.gas import compare
from hardlimit.cli.sweep import axis
from hardlimit.column import files
from hardlimit.contact.contact import law_parameters
from legible import coloured

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
HERTZ = ["--youngs-modulus", "5e7", "--poisson-ratio", "0.45"]


# --- help ---------------------------------------------------------------------------------------------------

COMMANDS = [
    *("check", "drop", "contact", "convert", "fit", "stack", "paper", "sweep", "gas", "explore", "cite"),
    *("completion",),
]


def test_help_lists_the_commands() -> None:
    for text in (run("--help").stdout, run().stdout):
        for name in COMMANDS:
            assert f"  {name} " in text


def test_the_list_of_commands_says_what_each_does() -> None:
    """In a whole sentence each, on a terminal of 80 columns."""
    context = click.Context(main, info_name="hardlimit", terminal_width=80, **main.context_settings)
    listed = main.get_help(context).partition("Commands:\n")[2].partition("\n\n")[0].splitlines()
    assert [line.split()[0] for line in listed] == sorted(COMMANDS)
    assert all(line.endswith(".") and not line.endswith("...") for line in listed), listed


def command(name: str) -> click.Command:
    subcommand = main.get_command(click.Context(main), name)
    assert subcommand is not None
    return subcommand


@pytest.mark.parametrize("name", COMMANDS)
def test_the_line_in_the_list_is_the_first_of_the_commands_own_help(name: str) -> None:
    """The list is printed without importing the commands."""
    lines = run("--help").stdout.partition("Commands:\n")[2].partition("\n\n")[0].splitlines()
    listed = dict(line.split(maxsplit=1) for line in lines)
    assert listed[name] == command(name).get_short_help_str(80)
    assert command(name).name == name


def every_option() -> Iterator[tuple[str, click.Option]]:
    for name, subcommand in [*((name, command(name)) for name in COMMANDS), ("gas compare", compare)]:
        yield from ((name, option) for option in subcommand.params if isinstance(option, click.Option))


def test_every_option_is_explained() -> None:
    """In a sentence: words, then the unit."""
    for name, option in every_option():
        where, text = f"{name} {option.opts[0]}: {option.help}", option.help or ""
        assert re.match(r"[A-Z\u0391-\u03a9]\w|R[12]", text), where
        assert re.search(r"[.](  \[default: .*\])?$", text), where
        if getattr(option.type, "unit", "1") != "1":
            assert re.search(r"\[\S.*?\]", text.partition("  [default")[0]), where


@pytest.mark.parametrize("name", COMMANDS)
def test_each_help_shows_an_example(name: str) -> None:
    text = run(name, "--help").stdout
    assert f"Example:\n    hardlimit {name} " in text
    assert max(map(len, text.splitlines())) <= 100


@pytest.mark.parametrize("name", [*sorted(set(COMMANDS) - {"explore", "paper"}), slow("paper")])
def test_the_example_of_each_help_works(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    # Pictures have their own tests.
    monkeypatch.setattr("hardlimit.plots.save", lambda figure, path, *look: path)
    shown = run(name, "--help").stdout.partition("Example:\n")[2]
    example = shown.replace("\\\n", " ").splitlines()[0]
    words = example.partition(">")[0].split()
    assert words[0] == "hardlimit"
    run(*words[1:])


def test_version() -> None:
    assert hl.__version__ in run("--version").stdout


def test_verbose_version_lists_the_installation() -> None:
    lines = run("--version", "--verbose").stdout.splitlines()
    assert lines[0] == run("--version").stdout.strip()
    text = "\n".join(lines)
    assert _core.compiler() in text and _core.instruction_sets()[0] in text
    project = tomllib.loads((EXAMPLES.parent / "pyproject.toml").read_text())["project"]
    for extra in project["optional-dependencies"].keys() - {"dev", "docs", "test"}:
        assert re.search(rf"^  {extra}: +\S", text, re.MULTILINE)
    assert refused("--verbose") == "hardlimit: --verbose: only with --version"


def test_options_of_laws_follow_the_records() -> None:
    text = run("drop", "--help").stdout
    for law in hl.LAWS.values():
        for name in law_parameters(law):
            assert f"--{name.replace('_', '-')} " in text


# --- drop ---------------------------------------------------------------------------------------------------


def test_drop_prints_contacts_and_comparison() -> None:
    text = run("drop").stdout
    assert max(map(len, text.splitlines())) <= 100
    for part in ["194.415", "220.195", "775.172", "0.171711", "3.72719", "0.125465", "adiabatic"]:
        assert part in text
    assert "No: all 4" in text
    assert "[m/s]" in text  # not taken for a style


def test_drop_as_json_is_the_result() -> None:
    output = printed("drop", "--restitution", 0.9, "--gap", 5e-4)
    r = hl.newton(hl.Column.paper(restitution=0.9, gap=5e-4))
    newton = output["models"]["newton"]
    assert newton["relative_velocity"] == r.relative_velocity and newton["n_contacts"] == 1
    assert newton["contacts"]["begin"] == r.contacts["begin"].values.tolist()
    assert output["models"].keys() == {"newton", "adiabatic", "independent"}
    assert output["column"]["law"] == {"name": "linear", "stiffness": 5e7, "restitution": 0.9}
    assert output["verdict"]["event_driven"] == "no"


@pytest.mark.parametrize(
    ("options", "answer"),
    [
        (["--gap", 5e-3], "yes"),
        (["--gap", 1e-4], "no"),
        (["--gap", 10.0], "undecided"),
        (["--restitution", 0.003], "no"),
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
    options = ["--radius-ratio", 5, "--density", 1000, "--height", 0.7, "--gravity", 1.62]
    column = printed("drop", *options)["column"]
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
    run("drop", "--dpi", 60, *(x for name, file in names.items() for x in (f"--{name}", tmp_path / file)))
    assert coloured(tmp_path / "drop.png") > 0.02
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


@pytest.mark.parametrize("options", [["--json"], []])
def test_one_ball(options: list[str]) -> None:
    text = run("drop", "--radius", 0.05, "--restitution", 0.8, *options).stdout
    if options:
        output = json.loads(text)
        assert len(output["column"]["balls"]) == 1 and output["models"].keys() == {"newton", "independent"}
        speed = output["impact_speed"]
        for model in output["models"].values():
            assert model["rebound_heights"][0] == pytest.approx(0.05 + 0.64 * speed**2 / 2 / 9.81, rel=1e-3)
    else:
        assert "ball 1" in text and "ball 2" not in text and "nan" not in text and "t_f" not in text
        assert max(map(len, text.splitlines())) <= 100


@pytest.mark.parametrize(
    ("options", "where", "value"),
    [
        (["--gap", "1mm"], "gaps", [1e-3]),
        (["--gap", "10 um"], "gaps", [1e-5]),
        (["--height", "70 cm"], "height", 0.7),
        (["--gravity", "1.62 m/s^2"], "gravity", 1.62),
        (["--gravity", "162cm/s²"], "gravity", 1.62),
        (["--velocity", "-50 cm/s"], "velocities", [-0.5, -0.5]),
    ],
)
def test_units_of_options(options: list[str], where: str, value: object) -> None:
    assert printed("drop", *options)["column"][where] == value


def test_units_of_balls_and_laws() -> None:
    options = ["--density", "0.84 g/cm^3", "--stiffness", "5e4 N/mm", "--radius-2", "1 cm"]
    assert printed("drop", *options)["column"] == printed("drop")["column"]
    law = ["--youngs-modulus", "50 MPa", "--poisson-ratio", "0.45", "--dissipative-time", "10 us"]
    law_table = printed("drop", *law)["column"]["law"]
    assert law_table["youngs_modulus"] == 5e7 and law_table["dissipative_time"] == 1e-5


# --- contact ------------------------------------------------------------------------------------------------


def test_usual_formula() -> None:
    assert "a request for ε = 0.5 results in 0.5503" in run("contact", "--restitution", 0.5).stdout
    for requested, obtained in ((0.9, 0.9020), (0.7, 0.7182), (0.5, 0.5503), (0.3, 0.3971), (0.1, 0.2527)):
        output = printed("contact", "--restitution", requested)
        assert output["usual_formula"]["restitution"] == pytest.approx(obtained, abs=5e-5)
        assert output["restitution"][0] == pytest.approx(requested, rel=1e-13)


def test_contact_over_speeds() -> None:
    law = [*HERTZ, "--restitution", 0.7, "--impact-speed", 3]
    output = printed("contact", *law, "--speed", 3, "--speed", 0.1, "--other-radius", 0.02)
    assert output["restitution"][0] == pytest.approx(0.7, rel=1e-10) and output["restitution"][1] > 0.8
    assert output["effective_radius"] == pytest.approx(0.01 * 0.02 / 0.03)
    text = run("contact", *law).stdout
    assert "dissipative time" in text and "\n3 " in text


@pytest.mark.parametrize("law", sorted(hl.LAWS))
def test_speeds_are_shown_where_they_matter(law: str) -> None:
    """A duration may depend on the speed where the restitution does not."""
    law_object = law_of(law, 0.7)
    options = [f"--{name.replace('_', '-')}={value!r}" for name, value in law_object.parameters.items()]
    text = run("contact", "--law", law, *options).stdout
    contact = law_object.between(hl.Ball(0.01, density=840))
    same = all(f(0.01) == pytest.approx(f(10.0), rel=1e-12) for f in (contact.restitution, contact.duration))
    assert ("At any impact speed" in text) == same and ("\n0.01 " in text) == (not same)


@pytest.mark.parametrize("law", [[], slow([*HERTZ, "--dissipative-time", 1e-5])])
def test_contact_plot(law: list[str], tmp_path: Path) -> None:
    run("contact", *law, "--plot", tmp_path / "contact.pdf")
    assert (tmp_path / "contact.pdf").read_bytes().startswith(b"%PDF")


RUBBING = ["--restitution", 0.9, "--friction", 0.5, "--stiffness-ratio", 0.9]


def test_contact_with_friction_over_the_angle() -> None:
    """The numbers of the contact; angles with and without units, as numbers, lists and ranges."""
    (friction,) = printed("contact", *RUBBING, "--angle", "0deg:89deg")["friction"]
    law = hl.LinearDashpot(stiffness=5e7, restitution=0.9, friction=hl.Friction(0.5, stiffness_ratio=0.9))
    pair = law.between(hl.Ball(0.01, density=840.0))
    angles = np.radians([*range(0, 90, 5), 89])
    np.testing.assert_allclose(friction["angle"], angles, rtol=1e-12)
    np.testing.assert_array_equal(friction["tangential_restitution"], pair.tangential_restitution(angles))
    assert friction["sticks_below"] == pair.sticks_below()
    assert friction["slides_beyond"] == pair.slides_beyond()
    assert friction["effective_tangential_restitution"] == pair.effective_tangential_restitution()
    impact = pair.impact(1.0, math.tan(angles[9]))
    ratio = impact.tangential_impulse / impact.normal_impulse
    assert friction["impulse_ratio"][9] == pytest.approx(abs(ratio), rel=1e-9)
    for text, degrees in (
        ("30", [30]),
        ("30deg,1rad", [30, 57.29577951308232]),
        ("10:20:3", [10, 15, 20]),
        ("0.5:9.2deg", [0.5, 1, 1.5, 2, 2.5, 3, 3.5, 4, 4.5, 5, 5.5, 6, 6.5, 7, 7.5, 8, 8.5, 9, 9.2]),
    ):
        (again,) = printed("contact", *RUBBING, "--angle", text)["friction"]
        np.testing.assert_allclose(np.degrees(again["angle"]), degrees, rtol=1e-12)


def test_contact_takes_every_argument_of_friction() -> None:
    """As options; those that the law has too begin with tangential."""
    options = shlex.split("--friction 0.3 --tangential-stiffness 3e6 --tangential-damping 2.0 --limit spring")
    output = printed("contact", *options, "--inertia-factor", 0.5, "--angle", 20)
    friction = hl.Friction(0.3, stiffness=3e6, damping=2.0, limit="spring")
    law = hl.LinearDashpot(stiffness=5e7, restitution=0.7, friction=friction)
    pair = law.between(hl.Ball(0.01, density=840.0, inertia_factor=0.5))
    assert output["law"]["friction"] == law.friction.to_dict()
    assert output["friction"][0]["tangential_restitution"] == [pair.tangential_restitution(math.radians(20))]
    text = run("contact", *options).stdout
    assert "μ 0.3, k_t 3e6, γ_t 2, spring, spring limit" in text
    assert "do not slip while the bodies approach below" in " ".join(text.split())


def test_contact_with_friction_that_depends_on_the_speed(tmp_path: Path) -> None:
    """One column for each speed; one in all where the speed does not matter."""
    law = [*HERTZ, "--dissipative-time", 1e-5, "--friction", 0.3, "--speed", 0.1, "--speed", 3]
    output = printed("contact", *law, "--angle", "10:60:6")["friction"]
    assert [friction["speed"] for friction in output] == [0.1, 3.0]
    assert output[0]["tangential_restitution"] != output[1]["tangential_restitution"]
    text = run("contact", *law, "--plot", tmp_path / "beta.pdf").stdout
    assert "β at 0.1 m/s   β at 3 m/s" in text and "At 3 m/s, they do not slip" in " ".join(text.split())
    assert (tmp_path / "beta.pdf").read_bytes().startswith(b"%PDF")
    assert len(printed("contact", *RUBBING, "--speed", 0.1, "--speed", 3)["friction"]) == 1
    never = run("contact", "--friction", 0.5, "--friction-model", "none", "--damping-ratio", 0.5).stdout
    assert "never stick" in never and "slide" in never


@pytest.mark.parametrize(
    "options,line",
    [
        (["--angle", 30], "--angle: got 30, must be left out without friction"),
        (["--friction", 0.5, "--angle", "0:90"], "--angle: got 90, must be in [0, 90)"),
        (["--friction", 0.5, "--angle", "0:80:99999999"], "--angle: got 99999999 angles, must be in [1, 10000]"),
        (["--friction", 0.5, "--angle", "1m"], "--angle: got '1m', must be a number [deg] or an angle with its unit"),
        (["--friction", -1], "--friction: got -1, must be >= 0\n"),
        (["--stiffness-ratio", 0.5], "--friction: missing, must be given beside --stiffness-ratio"),
        (
            ["--friction", 1, "--stiffness-ratio", 1, "--tangential-stiffness", 1],
            "--stiffness-ratio | --tangential-stiffness: got both",
        ),
        (["--friction", 1, "--friction-model", "mindlin"], "--friction-model: got mindlin with a linear normal force"),
        (["--friction", 1, "--inertia-factor", 2], "--inertia-factor: got 2, must be in [1e-06, 1]"),
    ],
)  # fmt: skip
def test_contact_refuses_bad_friction(options: list[object], line: str) -> None:
    out = run("contact", *options, code=2)
    assert line in out.stderr and out.stderr.count("\n") == 1


# --- sweep --------------------------------------------------------------------------------------------------

MAP = ["--restitution", "0.4:1:7", "--gap", "1e-6:1e-2:9:log"]
MAP_AXES = {"restitution": np.linspace(0.4, 1, 7), "gap": np.geomspace(1e-6, 1e-2, 9)}


def test_sweep_is_the_map(tmp_path: Path) -> None:
    output = printed("sweep", *MAP, "--out", tmp_path / "map.nc", "--plot", tmp_path / "map.png")
    assert output["points"] == 63 and output["sizes"] == {"restitution": 7, "gap": 9}
    assert output["outcomes"] == {"ok": 63}
    expected = hl.sweep(hl.Column.paper(), **MAP_AXES)
    with xr.open_dataset(tmp_path / "map.nc", engine="h5netcdf") as ds:
        for name in expected.data_vars:
            np.testing.assert_array_equal(ds[name], expected[name])
    assert coloured(tmp_path / "map.png") > 0.2


def test_order_of_the_axes_is_that_of_the_options() -> None:
    assert list(printed("sweep", *MAP[2:], *MAP[:2])["sizes"]) == ["gap", "restitution"]


@pytest.mark.slow
def test_sweep_of_a_variable_with_one_value_per_ball(tmp_path: Path) -> None:
    """The ranges and the picture are those of one ball each; the default of the picture is the highest one."""
    words = ["sweep", *MAP, "--variable", "rebound_height"]
    ranges = printed(*words)["ranges"]
    ds = hl.sweep(hl.Column.paper(), variables=["rebound_height"], **MAP_AXES)
    for ball in (1, 2):
        values = ds.rebound_height.sel(ball=ball)
        assert ranges[f"rebound_height of ball {ball}"] == [float(values.min()), float(values.max())]
    assert "rebound_height of ball 2 [m]" in run(*words).stdout
    for name, options in {"highest": [], "2": ["--ball", "2"], "1": ["--ball", "1"]}.items():
        run(*words, "--plot", tmp_path / f"{name}.png", "--dpi", "50", *options)
    first, two, highest = ((tmp_path / f"{name}.png").read_bytes() for name in ("1", "2", "highest"))
    assert highest == two != first


def test_sweep_resumes_a_store(tmp_path: Path) -> None:
    store = tmp_path / "map.zarr"
    first = printed("sweep", *MAP, "--out", store)
    assert "must not exist unless --resume" in refused("sweep", *MAP, "--out", store)
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
    options = [*HERTZ, "--dissipative-time", "1e-6:1e-4:5:log", "--gap", "1e-5,1e-4"]
    files_of = ["--out", tmp_path / "map.nc", "--difference", tmp_path / "difference.png"]
    printed("sweep", *options, "--tolerance", "1e-7", *files_of)
    assert coloured(tmp_path / "difference.png") > 0.1
    assert xr.open_dataset(tmp_path / "map.nc").attrs["tolerance"] == 1e-7


def test_sweep_of_another_law() -> None:
    options = [*HERTZ, "--dissipative-time", "1e-6:1e-4:5:log", "--model", "independent"]
    assert printed("sweep", *options)["points"] == 5


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("1mm", 1e-3),
        ("1 mm,2e-3,3mm", [1e-3, 2e-3, 3e-3]),
        ("0mm:2mm:3", [0, 1e-3, 2e-3]),
        ("0.5", 0.5),
        ("1,2,4", [1, 2, 4]),
        ("0:1:3", [0, 0.5, 1]),
        ("1:100:3:log", [1, 10, 100]),
    ],
)
def test_axis(text: str, values: object) -> None:
    np.testing.assert_allclose(axis("gap", text, "m"), values)


# --- paper and explore --------------------------------------------------------------------------------------


@pytest.mark.slow
def test_paper(tmp_path: Path) -> None:
    result = run("paper", "--figures", 2, "--out", tmp_path)
    assert "statements agree" in result.stdout and (tmp_path / "fig2.png").exists()
    assert max(map(len, result.stdout.splitlines())) <= 100


@pytest.mark.parametrize("options, page", [((), ""), (("--gas",), "gas.html")])
def test_explore_serves(options: tuple[str, ...], page: str) -> None:
    with mock.patch("hardlimit.explorer.server.serve") as serve:
        run("explore", "--port", 0, "--no-browser", *options)
    serve.assert_called_once_with(0, False, page)


# --- bad input ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["drop", "--radius-1", -0.1], "--radius-1: got -0.1, must be > 0 and finite"),
        (["drop", "--radius-2", 0], "--radius-2: got 0, must be > 0 and finite"),
        (["drop", "--gap", "inf"], "gap: got inf, must be >= 0 and finite"),
        (["drop", "--restitution", 1.5], "restitution: got 1.5, must be in (0, 1]"),
        (["drop", "--restitution", "70 cm"], "restitution: got '70 cm', must be a number without unit"),
        (["drop", "--gap", "1 s"], "gap: got '1 s', must be a number [m] or a length with its unit"),
        (["drop", "--gap", "1 furlong"], "gap: got '1 furlong', must be a number [m] or a length"),
        (["drop", "--gap", "9**9**9 m"], "gap: got '9**9**9 m', must be a number [m] or a length"),
        (["drop", "--gap", "1e9999 mm"], "gap: got '1e9999 mm', must be finite"),
        (["drop", "--stiffness", "5 MPa"], "stiffness: got '5 MPa', must be a number [N/m] or a stiffness"),
        (["drop", "--radius", "1e200"], "radius"),
        (["drop", "--plot", "a" * 400], "--plot: got 'aaaa"),
        (["sweep", *MAP, "--out", "a" * 400 + ".zarr"], "must be the name of a file: File name too long"),
        (["drop", "--plot", "a\0b"], "must be a path without control characters"),
        (["drop", "--plot", ""], "--plot: got '', must be the name of a file"),
        (["sweep", "--gap", "1mm:1s:3"], "gap: got '1s', must be a number [m] or a length"),
        (["sweep", "--gap", "1,,2"], "gap: got '', must be a number"),
        (["sweep", "--gap", "1:2:99999999999"], "gap: got 99999999999 points, must be in [1, 1e+08]"),
        (["sweep", "--velocity", "-1e308:1e308:3"], "got '-1e308:1e308:3', must span a finite range"),
        (["completion", "tcsh"], "'tcsh' is not one of 'bash', 'zsh', 'fish'"),
        (
            ["drop", "--restitution", 0.5, "--damping", 3],
            "--restitution | --damping: got restitution and damping",
        ),
        (["drop", "--law", "viscoelastic"], "--youngs-modulus: missing"),
        (["drop", *HERTZ], "must be --dissipative-time or --restitution + --impact-speed"),
        (["drop", "--law", "linear", "--poisson-ratio", 0.3], "--poisson-ratio: unknown"),
        (["drop", "--height", 0.05], "height: got 0.05, must be >= 0.1"),
        (["drop", "--height", 0.1], "height: got 0.1, must be > 0.1 unless velocities are given"),
        (["drop", "--radius", 0.1, "--gap", "1mm"], "gap: got 0.001, must be left out for a column of one"),
        (["drop", "--radius-1", 0.1, "--radius-ratio", 3], "--radius-ratio | --radius-1: got both"),
        (["drop", "--gap", 0.1, "--gap", 0.1], "gap: got 2 values, must be 1"),
        (
            ["drop", "--plot", "no folder/a.png"],
            "--plot: got 'no folder/a.png', must be in an existing folder",
        ),
        (["drop", "--save", "no folder/a.nc"], "--save: got"),
        (["check", "--radius", "1mm", "--speed", ":1"], "--speed: got '', must be a number [m/s]"),
        (["drop", "--colour", "red"], "--colour"),
        (["contact", "--other-mass", 0], "--other-mass: got 0, must be > 0 and finite"),
        (["contact", "--speed", 0], "speed: got 0, must be > 0 and finite"),
        (["contact", "--density", 1, "--mass", 1], "--density | --mass: got both"),
        (["paper", "--figures", "9"], "figures: got '9', must be among 2, 3, 4, 5, 6, 7, 8"),
        (["paper", "--density", 0], "density: got 0, must be > 0"),
        (["paper", "--format", "doc"], "format: got 'doc'"),
        (["paper", "--out", "/proc/figures"], "out: got '/proc/figures'"),
        (["sweep"], "axes: got none"),
        (["sweep", "--gap", "1:2"], "gap: got '1:2', must be a number, a list"),
        (["sweep", "--gap", "0:1:3:log"], "must have a start and a stop > 0"),
        (["sweep", "--gap", "1:2:0"], "gap: got 0 points"),
        (["sweep", "--gap", "-1:1:3"], "gap: got -1, must be >= 0"),
        (["sweep", "--restitution", "0.5:2:3"], "restitution: got 1.25, must be in (0, 1]"),
        (["sweep", *MAP, "--model", "magic"], "model: got 'magic'"),
        (["sweep", *MAP, "--engine", "steam"], "engine: got 'steam'"),
        (["sweep", *MAP, "--threads", 0], "threads: got 0"),
        (["sweep", *MAP, "--tolerance", 1e-9], "tolerance: got 1e-09, must not be given"),
        (["sweep", *MAP, "--resume"], "--resume: must be given with --out"),
        (["sweep", *MAP, "--height", "0.5,0.6", "--plot", "a.png"], "must be one or two"),
        (
            ["sweep", *MAP, "--height", "0.5,0.6", "--difference", "a.png"],
            "--difference: got 3 swept parameters",
        ),
        (
            ["sweep", "--gap", "0,1", "--difference", "a.png"],
            "--difference: got 1 swept parameter, must be two",
        ),
        (
            ["sweep", *MAP, "--variable", "rebound_height", "--ball", "3"],
            "--ball: got 3, must be a whole number in [1, 2]",
        ),
        (
            ["sweep", *MAP, "--ball", "1"],
            "--ball: got 1, must be left out for n_contacts; rebound_height, final",
        ),
        (["explore", "--port", "lots"], "--port"),
        (["jump"], "jump"),
    ],
)
def test_bad_input(args: list[object], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    line = refused(*args)
    assert line.startswith("hardlimit") and message in line
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('model = "newton"', "out = 1", "sweep.out: got 1, must be text"),
        ('model = "newton"', "plot = true", "sweep.plot: got True, must be text"),
        ('model = "newton"', "variables = 3", "sweep.variables: got 3, must be text, or a list of them"),
        ('model = "newton"', "variables = [3]", "sweep.variables[0]: got 3, must be text"),
        ('model = "newton"', "threads = 1.5", "sweep.threads: got 1.5, must be a whole number"),
        ('model = "newton"', "colour = 1", "sweep.colour: unknown, must be one of model, engine"),
        ('"0.4:1:60"', "[]", "restitution: got an empty list, must hold at least one number"),
        ('"0.4:1:60"', "[[1]]", "sweep.axes.restitution[0]: got [1], must be a number"),
        ('"0.4:1:60"', "true", "sweep.axes.restitution: got True, must be a number, a list a,b,… or start"),
        ('"0.4:1:60"', "1979-05-27", "sweep.axes.restitution: got datetime.date"),
        ("[sweep]", "[[sweep]]", "sweep: got [{"),
        ("[sweep.axes]", "[sweep.axis]", "sweep.axis: unknown"),
        ("restitution = 0.7", "restitution = 0.7\nself = 1", "law.self: unknown, must be one of name, stiff"),
        ("radius = 0.1", "radius = 1e200", "balls[0].radius"),
        ("radius = 0.1", "self = 1", "balls[0].self: unknown, must be one of radius, density, mass"),
        ("radius = 0.1", f"radius = {'9' * 400}", "balls[0].radius: got 9999"),
        ("radius = 0.1", f"radius = {'9' * 5000}", "not valid TOML: Exceeds the limit"),
        ("radius = 0.1", 'radius = "1 s"', "balls[0].radius: got '1 s', must be a number [m] or a length"),
        ("height = 0.6", f"height = {'[' * 5000}{']' * 5000}", "not valid TOML"),
        ("height = 0.6", "height = {}", "height: got {}, must be a number [m] or a length with its unit"),
        ("gaps = [1e-4]", "gaps = {}", "such as '1 mm', or a list of them"),
        ('name = "linear"', "name = 3", "law.name: got 3, must be one of linear"),
        ('name = "linear"', "", "law.name: missing"),
    ],
)
def test_bad_job(old: str, new: str, message: str, tmp_path: Path) -> None:
    text = (EXAMPLES / "map.toml").read_text(encoding="utf-8")
    assert old in text
    path = tmp_path / "job.toml"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    assert message in refused("sweep", path)


def test_quantities_of_a_file(tmp_path: Path) -> None:
    text = (EXAMPLES / "map.toml").read_text(encoding="utf-8")
    for old, new in (
        ("height = 0.6", 'height = "60 cm"'),
        ("gaps = [1e-4]", 'gaps = ["0.1 mm"]'),
        ("radius = 0.1\n", 'radius = "10 cm"\n'),
        ("density = 840.0", 'density = "0.84 g/cm^3"'),
        ("stiffness = 5e7", 'stiffness = "5e4 N/mm"'),
        ('gap = "1e-6:1e-2:60:log"', 'gap = "1um:1cm:60:log"'),
    ):
        assert old in text
        text = text.replace(old, new)
    path = tmp_path / "job.toml"
    path.write_text(text, encoding="utf-8")
    assert printed("sweep", path)["ranges"] == printed("sweep", EXAMPLES / "map.toml")["ranges"]
    path.write_text(text.partition("[sweep]")[0], encoding="utf-8")
    assert files.read(path) == hl.Column.paper()


@pytest.mark.parametrize("option", ["--radius-2", "--radius-ratio"])
def test_a_second_ball_of_a_column_of_one(option: str, tmp_path: Path) -> None:
    path = tmp_path / "one.toml"
    text = (EXAMPLES / "map.toml").read_text(encoding="utf-8").partition("[sweep]")[0]
    ball = "[[balls]]\nradius = 0.01\ndensity = 840.0\n"
    assert ball in text
    path.write_text(text.replace(ball, "").replace("gaps = [1e-4]", "gaps = []"), encoding="utf-8")
    assert "must be left out for a column of one ball" in refused("drop", path, option, 0.5)
    run("drop", path)


def test_broken_toml_is_one_line(tmp_path: Path) -> None:
    path = tmp_path / "broken.toml"
    path.write_text("height = \n", encoding="utf-8")
    assert "broken.toml: not valid TOML" in refused("drop", path) and "line 1" in refused("drop", path)
    path.write_text("height = 1\nhieght = 2\n", encoding="utf-8")
    assert "hieght: unknown" in refused("drop", path)


def test_outputs_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "drop.png").mkdir()
    assert "must be writable" in refused("drop", "--plot", tmp_path / "drop.png")
    tmp_path.chmod(0o555)
    if os.geteuid() != 0:  # root may write anywhere
        assert "must be writable" in refused("drop", "--plot", tmp_path / "other.png")


# --- as a process -------------------------------------------------------------------------------------------


def test_module_runs_and_errors_go_to_stderr() -> None:
    command = [sys.executable, "-m", "hardlimit", "drop", "--gap", "-1"]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert (ended.returncode, ended.stdout) == (2, "")
    assert ended.stderr == "hardlimit drop: --gap: got -1, must be >= 0 and finite\n"


def process(
    *args: object, encoding: str = "utf-8", stdout: int = subprocess.PIPE, most_bytes: int | None = None
) -> subprocess.CompletedProcess[bytes]:
    """The command as a process; ``most_bytes`` is where a file it writes hits a limit, as on a full disk."""

    def limit() -> None:
        if most_bytes is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))

    return subprocess.run(
        [sys.executable, "-m", "hardlimit", *map(str, args)],
        env={**os.environ, "PYTHONIOENCODING": encoding, "PYTHONUTF8": "0"},
        stdout=stdout,
        stderr=subprocess.PIPE,
        timeout=120,
        preexec_fn=limit,
        check=False,
    )


@pytest.mark.parametrize("encoding", [slow("latin-1"), "ascii"])
@pytest.mark.parametrize("args", [slow(["drop", "--help"]), slow(["drop"]), ["drop", "--gap", "Δ"]])
def test_a_terminal_without_greek(args: list[str], encoding: str) -> None:
    ended = process(*args, encoding=encoding)
    assert ended.returncode == (2 if "Δ" in args else 0)
    assert len(ended.stderr.splitlines()) == (1 if "Δ" in args else 0)


@pytest.mark.parametrize(
    "args", [slow(["drop", "--help"]), ["drop"], slow(["drop", "--json"]), ["--version"]]
)
def test_standard_output_on_a_full_device(args: list[str]) -> None:
    with open("/dev/full", "wb") as full:
        ended = process(*args, stdout=full.fileno())
    assert ended.returncode == 1
    assert re.fullmatch(rb"hardlimit.*: output: cannot be written: No space left on device\n", ended.stderr)


@pytest.mark.parametrize("most_bytes", [0, slow(1000), slow(20_000)])
@pytest.mark.parametrize(
    "args",
    [
        slow(["drop", "--save", "a.nc"]),
        ["drop", "--toml", "a.toml"],
        slow(["sweep", "--gap", "1e-6:1e-2:3000:log", "--out", "a.nc"]),
    ],
)
def test_a_full_disk_leaves_nothing(args: list[str], most_bytes: int, tmp_path: Path) -> None:
    target = tmp_path / args[-1]
    ended = process(*args[:-1], target, most_bytes=most_bytes)
    if args[-1] == "a.toml" and most_bytes:
        assert ended.returncode == 0 and files.read(target) == hl.Column.paper()
        return
    assert ended.returncode == 1
    assert re.fullmatch(rb"hardlimit \w+: .*a\.\w+: cannot be written: [\w ]+\n", ended.stderr), ended.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("option", "most_bytes"), [("--toml", 0), slow("--save", 20_000)])
def test_an_existing_file_survives_a_full_disk(tmp_path: Path, option: str, most_bytes: int) -> None:
    target = tmp_path / ("a.toml" if option == "--toml" else "a.nc")
    target.write_bytes(b"precious")
    assert process("drop", option, target, most_bytes=most_bytes).returncode == 1
    assert target.read_bytes() == b"precious" and list(tmp_path.iterdir()) == [target]


@pytest.mark.parametrize("option", ["--save", "--toml"])
def test_a_device_is_written_directly(option: str) -> None:
    failed = run("drop", option, "/dev/full", code=1).stderr
    assert "/dev/full: cannot be written: No space left on device" in failed
    assert Path("/dev/full").is_char_device()


def test_drop_loads_only_what_it_needs() -> None:
    """A drop that prints a table starts fast: it imports no package that it does not need."""
    code = "import sys; from hardlimit.cli import main; main(['drop'], 'hardlimit', standalone_mode=False); "
    code += "print(*sys.modules)"
    printed = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    loaded = set(printed.splitlines()[-1].split())
    slow = {"xarray", "pandas", "matplotlib", "zarr", "h5py", "pint", "msgspec", "dask", "scipy", "asyncio"}
    assert loaded & slow == set()


@pytest.mark.parametrize("shell", ["bash", slow("zsh"), slow("fish")])
def test_completion(shell: str) -> None:
    script = run("completion", shell).stdout
    assert script.startswith("# Install with: hardlimit completion ") and f"{shell}_complete" in script
    variables = {"COMP_WORDS": "hardlimit drop --rad", "COMP_CWORD": "--rad" if shell == "fish" else "2"}
    env = os.environ | variables | {"_HARDLIMIT_COMPLETE": f"{shell}_complete"}
    command = [sys.executable, "-m", "hardlimit"]
    answer = subprocess.run(command, env=env, capture_output=True, text=True, check=True).stdout
    assert {"--radius", "--radius-1", "--radius-ratio"} <= set(re.findall(r"--[\w-]+", answer))


def test_bash_reads_the_completion() -> None:
    script = run("completion", "bash").stdout
    ended = subprocess.run(["bash", "-n"], input=script, capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stderr) == (0, "")


def test_explore_on_a_busy_port() -> None:
    with socket.create_server(("127.0.0.1", 0)) as busy:
        port = busy.getsockname()[1]
        assert f"port: got {port}, must be free" in refused("explore", "--port", port, "--no-browser")


def test_a_film_without_ffmpeg_names_the_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    assert "pip install 'hardlimit[film]'" in refused("drop", "--animate", tmp_path / "film.mp4")


#: A sweep that says when it has begun to compute.
ANNOUNCED = """
import contextlib, sys
from hardlimit.cli import main, sweep

@contextlib.contextmanager
def announce(*title):
    yield lambda done, total: print("computing", flush=True)

sweep.bar = announce
main(sys.argv[1:], "hardlimit")
"""


@pytest.mark.slow
def test_ctrl_c_ends_with_130() -> None:
    axes = ["--restitution", "0.4:1:30000", "--gap", "1e-6:1e-2:30000:log", "--variable", "n_contacts"]
    command = [sys.executable, "-c", ANNOUNCED, "sweep", *axes]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None and process.stdout.readline() == "computing\n"
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=60)
    assert process.returncode == 130 and err.strip() == "interrupted"


# --- examples -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.toml")), ids=lambda p: p.stem)
def test_example_files_run(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    if "[sweep]" in text:
        assert printed("sweep", path)["outcomes"] == {"ok": 3600}
    elif "[event_driven]" in text:
        assert printed("gas", path)["outcome"]["name"] == "ok"
    else:
        assert printed("drop", path)["models"]["newton"]["outcome"] == "ok"


LONG = {"blast", "map"}  # examples of more than two seconds


@pytest.mark.parametrize(
    "path", [slow(p) if p.stem in LONG else p for p in sorted(EXAMPLES.glob("*.py"))], ids=lambda p: p.stem
)
def test_example_scripts_run(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(path), run_name="__main__")
    assert capsys.readouterr().out
