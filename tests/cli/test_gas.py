"""``hardlimit gas`` as a user meets it: what it prints, what it writes, how it goes on, how it fails."""

import errno
import json
import os
import random
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import click
import numpy as np
import pytest

import hardlimit as hl
from command_line import printed, refused, run
from conftest import lattice, slow, wait_until
from hardlimit import plots
from hardlimit.boxes import checkpoint, files
from hardlimit.boxes.result import NEWTON_OUTCOMES
from hardlimit.cli.gas import gas
from hardlimit.cli.gas_job import GLASS_BEADS
from hardlimit.cli.program import Terminated, in_options, terminating_signals
from hardlimit.support import saving
from legible import assert_legible, assert_moves, coloured


@pytest.fixture
def start(tmp_path: Path) -> Path:
    """A file of 64 spheres."""
    return lattice(64, seed=1).write(tmp_path / "start.xyz")


FAST = ["--until", "10ms", "--samples", "10"]


# --- what it prints -----------------------------------------------------------------------------------------


def test_the_table_has_theory_beside_it(start: Path) -> None:
    text = run("gas", start, *FAST).stdout
    assert "64 spheres" in text and "rule constant, restitution 0.9" in text
    assert "theory" in text and "Enskog" in text and "Haff" in text and "outcome: ok" in text
    assert max(map(len, text.splitlines())) <= 100


def test_json_agrees_with_the_library(start: Path) -> None:
    output = printed("gas", start, "--restitution", 0.8, *FAST)
    result = hl.event_driven(hl.ParticleSystem.read(start), restitution=0.8, until=0.01, samples=10)
    assert output["n_collisions"] == result.n_collisions and output["outcome"] == {
        "name": "ok",
        "message": "ok",
    }
    assert output["series"]["granular_temperature"] == result.series.granular_temperature.values.tolist()
    assert output["series"]["pressure"][0] is None and len(output["series"]["time"]) == 11
    assert output["system"]["n"] == 64 and output["rule"] == "constant" and output["restitution"] == 0.8
    assert set(output["theory"]) == {
        "mean collision rate [1/s]",
        "mean pressure [Pa]",
        "granular temperature at the end [m²/s²]",
    }


def test_without_anything_it_is_a_gas_of_glass_beads() -> None:
    output = printed("gas", "--n", 300)
    system = hl.ParticleSystem.random(**(GLASS_BEADS | {"n": 300}))
    assert output["system"]["box"] == system.box.tolist()
    assert output["restitution"] == 0.9 and output["outcome"]["name"] == "ok"
    assert 5.0 < 2.0 * output["n_pair_collisions"] / 300 < 20.0


def test_a_random_start_from_options() -> None:
    output = printed(
        "gas", "--n", 50, "--dimension", 2, "--packing-fraction", 0.4, "--radius", "1mm", "--radius", "2mm",
        "--density", "1 g/cm^3", "--rms-speed", "10cm/s", "--seed", 3, "--boundary", "wall", "--boundary", "periodic",
        "--gravity", 0, "--gravity=-1.62", "--max-collisions", 100,
    )  # fmt: skip
    assert output["system"] | {"box": 0} == {
        "n": 50, "dimension": 2, "box": 0, "boundary": ["wall", "periodic"], "gravity": [0.0, -1.62],
        "packing_fraction": pytest.approx(0.4),
    }  # fmt: skip
    assert output["n_collisions"] == 100 and output["theory"] == {}


RULES = {
    "constant": (["--restitution", 0.5], ("constant", 0.5, None)),
    "tc": (["--rule", "tc", "--contact-duration", "10us"], ("tc", 0.9, None)),
    "law": (["--stiffness", "1e5", "--restitution", 0.8], ("law", None, "linear")),
    "named": (["--law", "linear", "--stiffness", "1e5", "--damping", 0.01], ("law", None, "linear")),
    "tc of a law": (
        ["--youngs-modulus", "1e8", "--poisson-ratio", 0.3, "--dissipative-time", "1us", "--rule", "tc",
         "--contact-duration", "1us"],
        ("tc", None, "viscoelastic"),
    ),
}  # fmt: skip


@pytest.mark.parametrize("which", RULES)
def test_rules_from_options(start: Path, which: str) -> None:
    options, (rule, restitution, law) = RULES[which]
    output = printed("gas", start, *options, *FAST)
    assert (output["rule"], output["restitution"]) == (rule, restitution)
    assert (output["law"] or {}).get("name") == law
    assert (output["contact_duration"] is not None) == (rule == "tc")


def test_a_collapse_is_said_and_is_no_failure(tmp_path: Path) -> None:
    heap = lattice(27, boundary="wall", gravity=9.81).write(tmp_path / "heap.xyz")
    text = " ".join(run("gas", heap, "--restitution", 0.3, "--until", 10).stdout.split())
    assert "outcome: inelastic collapse: particle" in text and "No theory: it has walls" in text
    output = printed("gas", heap, "--restitution", 0.3, "--until", 10)
    assert output["outcome"]["name"] == "collapse" and output["early_end"]["time"] == output["time"]
    assert set(output["early_end"]) == {"time", "position", "particles", "wall"}


# --- what it writes -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", [".xyz", ".extxyz", ".gsd"])
def test_a_trajectory_has_a_frame_for_every_sample(start: Path, tmp_path: Path, suffix: str) -> None:
    out = tmp_path / f"run{suffix}"
    assert f"written to {out}" in run("gas", start, *FAST, "--out", out).stdout.replace("\n", "")
    system = hl.ParticleSystem.read(start)
    for k in (0, 4, 10):
        then = hl.event_driven(system, restitution=0.9, until=0.001 * k).system
        frame = hl.ParticleSystem.read(out, frame=k)
        assert np.allclose(frame.positions, then.positions, rtol=0.0, atol=1e-12)
    assert hl.ParticleSystem.read(out) == hl.event_driven(system, restitution=0.9, until=0.01).system
    with pytest.raises(ValueError, match="frame: got 11"):
        hl.ParticleSystem.read(out, frame=11)


def test_it_saves_series_collisions_and_the_end(start: Path, tmp_path: Path) -> None:
    run("gas", start, *FAST, "--save", tmp_path / "run.nc")
    result = hl.event_driven(hl.ParticleSystem.read(start), restitution=0.9, until=0.01, samples=10, log=True)
    loaded = hl.load(tmp_path / "run.nc")
    assert loaded.collisions.equals(result.collisions) and loaded.series.equals(result.series)
    assert loaded.system == result.system


def test_an_outcome_names_options(tmp_path: Path) -> None:
    """Where that of Python names its functions and arguments."""
    words = " ".join(run("gas", "--n", 20, "--packing-fraction", 0.05, "--restitution", 0).stdout.split())
    assert "outcome: inelastic collapse: " in words and "; use --engine auto, or the rule tc" in words
    with click.Context(gas):
        said = in_options(NEWTON_OUTCOMES["events"].format(who="6 particles", where="at 0.1 s"))
    assert said.endswith("use --engine steps")


@pytest.mark.parametrize(
    ("suffix", "dimension"), [(".gif", 2), slow(".gif", 3), slow(".mp4", 2), slow(".mp4", 3)]
)
def test_a_film(tmp_path: Path, dimension: int, suffix: str) -> None:
    start = lattice(27, dimension, boundary=["periodic", *["wall"] * (dimension - 1)]).write(
        tmp_path / "start.xyz"
    )
    film = tmp_path / f"film{suffix}"
    run("gas", start, "--until", "5ms", "--samples", 4, "--animate", film, "--out", tmp_path / "run.xyz")
    assert_moves(film, 640, 5)
    assert hl.ParticleSystem.read(tmp_path / "run.xyz", frame=4).n == 27


@pytest.mark.parametrize(
    "which", ["disks", *(slow(which) for which in ("walls", "nothing", "cooling", "elastic", "law"))]
)
def test_plots_are_legible(tmp_path: Path, which: str) -> None:
    system = {"walls": lattice(27, boundary="wall"), "disks": lattice(49, 2)}.get(which, lattice(64))
    rule = {"law": {"law": hl.LinearDashpot(stiffness=1e5, restitution=0.8)}, "elastic": {"restitution": 1.0}}
    end = {"until": 0.0 if which == "nothing" else 0.05}
    result = hl.event_driven(system, **rule.get(which, {"restitution": 0.8}), **end)
    assert_legible(plots.gas(result))
    assert coloured(plots.save(result.plot(), tmp_path / "gas.png", 60)) > (
        0.0 if which == "nothing" else 3e-3
    )


def test_plot_from_the_command_line(start: Path, tmp_path: Path) -> None:
    run("gas", start, *FAST, "--plot", tmp_path / "gas.svg")
    assert b"<svg" in (tmp_path / "gas.svg").read_bytes()


# --- job files ----------------------------------------------------------------------------------------------

JOB = """
start = "start.xyz"

[law]
name = "linear"
stiffness = "100 N/mm"
restitution = 0.8

[event_driven]
rule = "tc"
contact_duration = "1 us"
until = "10 ms"
samples = 10
"""


def test_a_job_file(start: Path) -> None:
    job = start.with_name("job.toml")
    job.write_text(JOB)
    output = printed("gas", job)
    assert output["law"] == {"name": "linear", "stiffness": 1e5, "restitution": 0.8}
    assert (output["rule"], output["contact_duration"], output["time"]) == ("tc", 1e-6, 0.01)
    assert output["system"]["n"] == 64
    changed = printed("gas", job, "--stiffness", "1e6", "--until", "5ms", "--gravity", 9.81)
    assert changed["law"] == {"name": "linear", "stiffness": 1e6, "restitution": 0.8}
    assert changed["time"] == 0.005 and changed["system"]["gravity"] == [0.0, 0.0, -9.81]


BAD_JOBS = {
    "unknown": ("[event_driven]", "[event_driven]\nspeed = 1\n", "event_driven.speed: unknown, must be one of"),
    "both starts": ("[law]", "[random]\nn = 3\n[law]", "start | random: got both"),
    "two restitutions": ("[event_driven]", "[event_driven]\nrestitution = 1\n", "law | event_driven.restitution: got"),
    "unit": ('"10 ms"', '"10 mm"', "event_driven.until: got '10 mm', must be a number [s] or a time"),
    "no file": ("start.xyz", "none.xyz", "none.xyz: no such file"),
    "law": ("stiffness", "softness", "law.softness: unknown"),
    "half a sample": ("samples = 10", "samples = 0.5", "event_driven.samples: got 0.5, must be a whole number"),
}  # fmt: skip


@pytest.mark.parametrize("which", BAD_JOBS)
def test_bad_job_files(start: Path, which: str) -> None:
    old, new, message = BAD_JOBS[which]
    job = start.with_name("job.toml")
    assert old in JOB
    job.write_text(JOB.replace(old, new, 1))
    assert message in refused("gas", job)


# --- checkpoints --------------------------------------------------------------------------------------------


def test_a_run_goes_on(start: Path, tmp_path: Path) -> None:
    path = tmp_path / "run.checkpoint"
    run("gas", start, *FAST, "--checkpoint", path)
    longer = printed("gas", "--resume", path, "--until", "20ms")
    whole = printed("gas", start, "--until", "20ms", "--samples", 20)
    assert longer == whole
    run("gas", start, *FAST, "--checkpoint", path, "--out", tmp_path / "first.xyz")
    first = path.read_bytes()
    run("gas", "--resume", path, "--until", "20ms", "--out", tmp_path / "rest.xyz")
    path.write_bytes(first)
    run("gas", "--resume", path, "--until", "20ms", "--out", tmp_path / "first.xyz")
    run("gas", start, "--until", "20ms", "--samples", 20, "--out", tmp_path / "whole.xyz")
    assert (tmp_path / "first.xyz").read_bytes() == (tmp_path / "whole.xyz").read_bytes()
    assert np.allclose(
        hl.ParticleSystem.read(tmp_path / "rest.xyz", frame=9).positions,
        hl.event_driven(hl.ParticleSystem.read(start), restitution=0.9, until=0.02).system.positions,
        rtol=0.0,
        atol=1e-12,
    )
    run("gas", "--resume", path, "--until", "20ms")
    assert "--n: must be left out with --resume" in refused("gas", "--resume", path, "--n", 3)
    assert "FILE: must be left out with --resume" in refused("gas", start, "--resume", path)
    assert "--restitution: must be left out" in refused("gas", "--resume", path, "--restitution", 0.3)
    assert "until: got 0.001, must be >= 0.02" in refused("gas", "--resume", path, "--until", "1ms")


def test_outputs_of_a_resumed_run_are_refused_before_it_goes_on(start: Path, tmp_path: Path) -> None:
    path, newton, endless = (tmp_path / name for name in ("run.checkpoint", "newton", "endless"))
    run("gas", start, *FAST, "--checkpoint", path)
    kept = path.read_bytes()
    for option, name in (("--out", "rest.xyz"), ("--animate", "rest.gif")):
        refusal = refused("gas", "--resume", path, option, tmp_path / name)
        assert "is at the end of its run, no frame follows" in refusal and option in refusal
        assert not (tmp_path / name).exists()
    soft = ["--law", "linear", "--stiffness", "1e5", "--restitution", "0.9", "--engine", "events"]
    run("gas", start, *soft, "--until", "1ms", "--checkpoint", newton)
    plot = ["--plot", tmp_path / "x.png", "--until", "1h"]
    assert "--plot: must be left out" in refused("gas", "--resume", newton, *plot)
    run("gas", start, "--max-collisions", 50, "--samples", 5, "--checkpoint", endless)
    more = ["--max-collisions", 90, "--out", tmp_path / "rest.xyz"]
    assert "--out: requires --until" in refused("gas", "--resume", endless, *more)
    assert path.read_bytes() == kept


def test_a_run_may_end_between_two_samples(start: Path, tmp_path: Path) -> None:
    """Its last frame is of no sample: it is not in the trajectory of a run that goes on from there."""
    path, frames, whole = (tmp_path / name for name in ("run.checkpoint", "run.xyz", "whole.xyz"))
    run("gas", start, *FAST, "--checkpoint", path, "--out", frames)
    for until, count in (("10.5ms", 12), ("12.3ms", 14), ("15ms", 16)):
        run("gas", "--resume", path, "--until", until, "--out", frames)
        assert len(files.extended_xyz.times(frames)) == count
    run("gas", start, *FAST, "--checkpoint", path, "--out", whole)
    run("gas", "--resume", path, "--until", "15ms", "--out", whole)
    assert frames.read_bytes() == whole.read_bytes()


def test_a_trajectory_goes_into_a_pipe(start: Path, tmp_path: Path) -> None:
    frames, pipe = tmp_path / "run.xyz", tmp_path / "pipe.xyz"
    run("gas", start, *FAST, "--out", frames)
    os.mkfifo(pipe)
    with ThreadPoolExecutor() as pool:
        content = pool.submit(pipe.read_bytes)
        run("gas", start, *FAST, "--out", pipe)
        assert content.result() == frames.read_bytes()


@pytest.mark.parametrize("suffix", [".xyz", ".gsd"])
def test_the_trajectory_of_another_run_is_refused(suffix: str, start: Path, tmp_path: Path) -> None:
    path, frames = tmp_path / "run.checkpoint", tmp_path / f"run{suffix}"
    run("gas", start, "--until", "9ms", "--samples", 7, "--out", frames)
    other = frames.read_bytes()
    run("gas", start, *FAST, "--checkpoint", path)
    more = ["--resume", path, "--until", "20ms", "--out", frames]
    assert f"--out: got {frames}, must be the trajectory of this run" in refused("gas", *more)
    assert frames.read_bytes() == other
    run("gas", start, "--until", "5ms", "--samples", 5, "--out", frames)
    assert "it ends at 0.005 s, the checkpoint at 0.01 s" in refused("gas", *more)
    frames.write_bytes(b"no frames")
    assert "must be the trajectory of this run" in refused("gas", *more)


@pytest.fixture
def fail_at_frame(monkeypatch: pytest.MonkeyPatch) -> Callable[[int, BaseException], None]:
    """Makes writing one frame fail in the middle."""

    def fail(frame: int, error: BaseException) -> None:
        left = iter(range(frame))

        def write(*args: Any, write: Callable[..., None] = files.frame.write_rows) -> None:
            if next(left, None) is None:
                args[0].write(b"X 0.1 0.")
                monkeypatch.setattr(files.extended_xyz, "write_rows", write)
                raise error
            write(*args)

        monkeypatch.setattr(files.extended_xyz, "write_rows", write)

    return fail


FULL = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [(KeyboardInterrupt(), 130, "interrupted"), (Terminated(signal.SIGTERM), 143, "interrupted by SIGTERM"),
     (FULL, 1, "hardlimit gas: {frames}: cannot be written: No space left on device;")],
)  # fmt: skip
def test_a_run_that_is_ended_says_what_is_kept_and_goes_on(
    error: BaseException, code: int, said: str, start: Path, tmp_path: Path, fail_at_frame: Any
) -> None:
    path, frames, whole, series = (tmp_path / name for name in ("run.ck", "run.xyz", "whole.xyz", "run.nc"))
    series.write_bytes(b"former")
    run("gas", start, *FAST, "--out", whole)
    fail_at_frame(4, error)
    ended = run("gas", start, *FAST, "--checkpoint", path, "--out", frames, "--save", series, code=code)
    go_on = f"hardlimit gas --resume {path} --out {frames} --save {series}"
    (line,) = ended.stderr.split("\n")[-2:-1]
    said = said.format(frames=frames)
    assert line == f"{said} at 0.004 s of 0.01 s; kept {path}; kept {frames}; go on with: {go_on}"
    assert whole.read_bytes().startswith(frames.read_bytes())
    assert len(files.extended_xyz.times(frames)) == 4 and series.read_bytes() == b"former"
    run(*shlex.split(go_on)[1:])
    assert frames.read_bytes() == whole.read_bytes()
    assert sorted(entry.name for entry in tmp_path.iterdir()) == [
        "run.ck",
        "run.nc",
        "run.xyz",
        "start.xyz",
        "whole.xyz",
    ]


def test_ctrl_c_ends_a_random_start() -> None:
    former = signal.signal(signal.SIGALRM, signal.default_int_handler)
    signal.setitimer(signal.ITIMER_REAL, 0.3)
    try:
        ended = run("gas", "--n", 100_000, "--packing-fraction", 0.6, code=130)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, former)
    assert (ended.stdout, ended.stderr.strip()) == ("", "interrupted")


def test_without_a_checkpoint_a_full_disk_costs_frames_only(
    start: Path, tmp_path: Path, fail_at_frame: Any
) -> None:
    frames, expected = tmp_path / "run.xyz", run("gas", start, *FAST).stdout
    fail_at_frame(4, FULL)
    ended = run("gas", start, *FAST, "--out", frames, code=1)
    assert ended.stdout == expected
    assert ended.stderr == f"hardlimit gas: {frames}: cannot be written: No space left on device\n"
    assert len(files.extended_xyz.times(frames)) == 4
    fail_at_frame(2, KeyboardInterrupt())
    ended = run("gas", start, *FAST, "--out", frames, code=130)
    assert f"kept {frames}; a run goes on only from a --checkpoint\n" in ended.stderr


@pytest.mark.filterwarnings("default::hardlimit.CheckpointWarning")
def test_files_that_cannot_be_written_at_the_end(
    start: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The summary is printed, the other files are written, and each failure has its message."""

    def fail(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    series, picture, film, path = (tmp_path / name for name in ("run.nc", "run.png", "run.gif", "run.ck"))
    expected = run("gas", start, *FAST).stdout
    monkeypatch.setattr(saving, "write_all", fail)
    outputs = ["--save", series, "--plot", picture, "--animate", film]
    ended = run("gas", start, *FAST, *outputs, code=1)
    assert ended.stdout.startswith(expected.rstrip()) and ended.stdout.count("written to") == 2
    assert ended.stderr == f"hardlimit gas: {series}: cannot be written: No space left on device\n"
    assert picture.exists() and film.exists() and not series.exists()
    saved = iter(range(1))
    write = checkpoint.write
    monkeypatch.setattr(
        checkpoint, "write", lambda *a: write(*a) if next(saved, None) is not None else fail()
    )
    ended = run("gas", start, *FAST, "--checkpoint", path)
    assert ended.stdout == expected
    assert (
        ended.stderr.startswith("warning: ")
        and "No space left on device; kept the one of 0 s" in ended.stderr
    )
    monkeypatch.undo()
    run("gas", "--resume", path)


def test_an_interrupt_while_results_are_written_says_what_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*rest: object) -> None:
        raise KeyboardInterrupt

    path, frames = tmp_path / "run.ck", tmp_path / "run.xyz"
    with monkeypatch.context() as patch:
        patch.setattr(sys.modules["hardlimit.cli.gas"], "print_report", interrupted)
        ended = run("gas", *FAST, "--checkpoint", path, "--out", frames, code=130)
    summary = shlex.join(["hardlimit", "gas", "--resume", str(path)])
    line = f"interrupted after the end of the run; kept {path}, whose summary is printed by: {summary}; kept {frames}"
    assert " ".join(ended.stderr.split()) == line
    run("gas", "--resume", path)


def same_frames(path: Path, other: Path) -> bool:
    """Whether two trajectories are the same: XYZ files byte for byte."""
    if path.suffix == ".xyz":
        return path.read_bytes() == other.read_bytes()
    times = files.gsd_file.times(path)
    systems = [[hl.ParticleSystem.read(name, frame=k) for k in range(len(times))] for name in (path, other)]
    return times == files.gsd_file.times(other) and systems[0] == systems[1]


def ended_by(number: int, arguments: Sequence[object], checkpoint: Path, writes: int) -> tuple[int, str, str]:
    """Exit code, output and last line on stderr of a command that gets a signal after some checkpoints.

    Lines before it are the progress, on a slow machine.
    """
    command, former = [sys.executable, "-m", "hardlimit", *map(str, arguments)], stamp(checkpoint)
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        stamps: set[int] = set()

        def is_time() -> bool:
            stamps.add(stamp(checkpoint))
            return len(stamps - {former, 0}) > writes or process.poll() is not None

        wait_until(is_time)
        process.send_signal(number)
        output, errors = process.communicate(timeout=60)
    assert "Traceback" not in errors
    return process.returncode, output, errors.strip().split("\n")[-1]


def stamp(path: Path) -> int:
    return path.stat().st_mtime_ns if path.exists() else 0


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_a_signal_in_a_destructor_ends_the_command_after_it(name: str) -> None:
    """Python would drop what is raised in it, and the command would go on."""
    number, ends = getattr(signal, name), []

    class File:
        def close(self) -> None:
            signal.raise_signal(number)
            ends.append(time.monotonic())

        def __del__(self) -> None:
            self.close()

    with pytest.raises(KeyboardInterrupt), terminating_signals():
        File()
        time.sleep(3.0)
    assert len(ends) == 1 and time.monotonic() - ends[0] < 2.0


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals")
@pytest.mark.parametrize(
    ("name", "suffix", "rub"),
    [
        ("SIGINT", ".xyz", True),
        ("SIGTERM", ".gsd", False),
        ("SIGHUP", ".xyz", False),
        ("SIGKILL", ".xyz", False),
        ("SIGKILL", ".gsd", True),
    ],
)
def test_a_run_ended_by_a_signal_at_any_moment_goes_on(
    name: str, suffix: str, rub: bool, tmp_path: Path
) -> None:
    """The command that the line names leads to the same bits, trajectory included, and leaves no other files."""
    number, chance = getattr(signal, name), random.Random(f"{name}{suffix}{rub}")
    start = lattice(125, seed=1).write(tmp_path / "start.xyz")
    path, frames, whole = (tmp_path / name for name in ("run.ck", f"run{suffix}", f"whole{suffix}"))
    options = ["--heat", "1mW", "--until", "0.2", "--samples", "20"]
    options += ["--friction", "0.5", "--tangential-restitution", "0.3"] if rub else []
    expected = printed("gas", start, *options, "--out", whole)
    after_kill: list[object] = ["gas", "--resume", path, "--out", frames, "--json"]
    arguments = ["gas", start, *options, "--checkpoint", path, "--checkpoint-every", "1e-9", *after_kill[3:]]
    for _ in range(3):
        code, output, line = ended_by(number, arguments, path, chance.randrange(12))
        if code == 0:
            break
        arguments = after_kill
        if number == signal.SIGKILL:
            assert code == -number, line
        else:
            assert code == 128 + number and line.startswith("interrupted"), line
            if "after the end of the run" in line:
                assert f"kept {path}, " in line and line.endswith(f"kept {frames}")
                after_kill = after_kill[:3] + after_kill[5:]
                break
            assert line.endswith(f"; go on with: {shlex.join(map(str, ['hardlimit', *after_kill]))}"), line
    resumed = json.loads(output) if code == 0 else printed(*after_kill[:-1])
    assert {**resumed, "files": []} == {**expected, "files": []}
    assert same_frames(frames, whole)
    assert {entry.name for entry in tmp_path.iterdir()} == {start.name, path.name, frames.name, whole.name}


# --- bad input ----------------------------------------------------------------------------------------------

BAD = {
    "fraction": (["--packing-fraction", 0.7], "--packing-fraction: got 0.7, must be in (0, 0.62]"),
    "too many": (["--n", 2**31 - 1], "n: got 2147483647, must fit into the free memory: needs 644 GB"),
    "few": (["--n", 3], "--n | --packing-fraction: got 3 particles, must be more"),
    "law": (["--law", "linear"], "stiffness: missing, must be > 0"),
    "unit": (["--until", "10mm"], "until: got '10mm', must be a number [s]"),
    "frames": (["--max-collisions", 5, "--out", "run.xyz"], "--out: requires --until"),
    "frames of a film": (["--max-collisions", 5, "--animate", "a.gif"], "--animate: requires --until"),
    "trajectory": (["--out", "run.data"], "--out: got 'run.data', must end in .xyz, .extxyz or .gsd"),
    "save": (["--save", "run.zarr"], "--save: got 'run.zarr', must end in .nc"),
    "folder": (["--plot", "no/a.png"], "--plot: got 'no/a.png', must be in an existing folder"),
    "checkpoint": (["--checkpoint", "no/a"], "checkpoint: got 'no/a', must be a file in a folder"),
    "checkpoint without a file": (["--checkpoint-every", 5], "-every: must be left out without --checkpoint"),
    "file": (["box.pdb"], "FILE: got 'box.pdb', must end in .toml, .xyz"),
}  # fmt: skip


@pytest.mark.parametrize("which", BAD)
def test_bad_options(which: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    options, message = BAD[which]
    assert message in refused("gas", *options)
    assert list(tmp_path.iterdir()) == []


def test_a_random_option_with_a_file(start: Path) -> None:
    assert "n: must be left out with a start from a file" in refused("gas", start, "--n", 5)
    damaged = start.with_name("damaged.xyz")
    damaged.write_text(start.read_text()[:1000])
    assert "damaged.xyz: number of particles: got 64, must be >= 1 and the number of its lines" in refused(
        "gas", damaged
    )


@pytest.mark.parametrize(
    "bad", ["--rule=fish", "--restitution=1.5", "--until=-1", "--rule=tc", "--max-collisions=-3"]
)
def test_bad_arguments_are_refused_before_the_start_is_made(monkeypatch, bad):
    monkeypatch.setattr(hl.ParticleSystem, "random", lambda *_, **__: pytest.fail("the start was made"))
    assert refused("gas", "--n", "3000000", bad).startswith(
        f"hardlimit gas: --{'contact-duration' if 'tc' in bad else bad[2:].split('=')[0]}: "
    )


# --- a shaken wall ------------------------------------------------------------------------------------------


def test_a_wall_is_shaken(tmp_path: Path) -> None:
    """By options, by a job file, and from a file of particles."""
    options = ["--shake", "0.5mm:50Hz", "--wall", "z-"]
    numbers = shlex.split("--n 30 --packing-fraction 0.05 --gravity 9.81 --rms-speed 0.2 --until 10ms")
    output = printed("gas", *numbers, *options)
    wall = {"amplitude": 0.5e-3, "frequency": 50.0, "waveform": "sine", "phase": 0.0, "velocity": 0.0}
    assert output["system"]["walls"]["z-"].items() >= {"amplitude": 0.5e-3, "frequency": 50.0}.items()
    assert output["system"]["boundary"] == ["periodic", "periodic", "wall"]
    assert output["series"]["wall_work"][-1] != 0.0
    job = tmp_path / "job.toml"
    job.write_text(
        "[random]\nn = 30\npacking_fraction = 0.05\ngravity = 9.81\nrms_speed = 0.2\nshake = '0.5mm:50Hz'\n"
        "[event_driven]\nuntil = 0.01\n"
    )
    assert printed("gas", job)["series"] == output["series"]
    box = lattice(27, seed=1).replace(boundary="wall").write(tmp_path / "box.xyz")
    shaken = printed("gas", box, "--shake", "1e-5:80", "--wall", "x+", "--waveform", "triangle", *FAST)
    expected = wall | {"amplitude": 1e-5, "frequency": 80.0, "waveform": "triangle"}
    assert (
        shaken["system"]["walls"]["x+"].items() >= {k: v for k, v in expected.items() if k != "phase"}.items()
    )


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--wall", "z-"], "--wall: must be left out without --shake"),
        (["--shake", "1mm"], "--shake: got '1mm', must be an amplitude and a frequency"),
        (["--shake", "1mm:50s"], "--shake: got '50s', must be a number [Hz] or a frequency"),
        (["--shake", "1mm:50Hz", "--wall", "q"], "--wall: got 'q', must be one of"),
    ],
)
def test_a_bad_shake_is_refused(options: list[str], message: str) -> None:
    assert message in refused("gas", "--n", 10, *options)


def test_a_gas_is_heated(tmp_path: Path) -> None:
    """By an option, by a job file, and from a file of particles."""
    output = printed("gas", "--n", 30, "--packing-fraction", 0.1, "--heat", "1mW", "--until", "5ms")
    kicks = output["system"]["thermostat"]
    assert kicks["kind"] == "RandomKicks" and kicks["power"] == 1e-3 and output["theory"] == {}
    assert output["series"]["heat"][-1] > 0.0
    job = tmp_path / "job.toml"
    job.write_text("[random]\nn = 30\npacking_fraction = 0.1\nheat = '1mW'\n[event_driven]\nuntil = 0.005\n")
    assert printed("gas", job)["series"] == output["series"]
    box = lattice(27, seed=1).write(tmp_path / "box.xyz")
    assert printed("gas", box, "--heat", 1e-6, *FAST)["series"]["heat"][-1] != 0.0
    assert "--heat: got -1" in refused("gas", "--n", 10, "--heat", -1)
    assert "--heat-spins: got 1" in refused("gas", "--n", 10, "--heat-spins", 1)
    rubbing = ("gas", "--n", 30, "--friction", 0.5, "--tangential-restitution", 0.3, "--until", "5ms")
    spinning = printed(*rubbing, "--heat-spins", "1mW")
    assert (spinning["system"]["thermostat"]["power"], spinning["system"]["thermostat"]["rotational"]) == (
        0.0,
        1e-3,
    )
    assert spinning["series"]["rotational_temperature"][-1] > 0.0 < spinning["series"]["heat"][-1]


def test_a_box_is_sheared(tmp_path: Path) -> None:
    """By an option, by a job file, with Newton's equations, beside walls along z, and from a file of particles."""
    numbers = ["--n", 100, "--packing-fraction", 0.1, "--rms-speed", 0.2]
    output = printed("gas", *numbers, "--shear", "50/s", "--until", "20ms")
    assert output["system"]["boundary"] == ["periodic", "lees-edwards", "periodic"]
    assert output["system"]["shear_rate"] == 50.0 and output["theory"] == {}
    assert output["series"]["shear_work"][-1] != 0.0
    job = tmp_path / "job.toml"
    job.write_text(
        "[random]\nn = 100\npacking_fraction = 0.1\nrms_speed = 0.2\nshear = '50/s'\n[event_driven]\nuntil = 0.02\n"
    )
    assert printed("gas", job)["series"] == output["series"]
    stiff = ["--law", "linear", "--stiffness", 1e4, "--restitution", 0.9, "--engine", "events"]
    contacts = printed("gas", *numbers, "--shear", 50, "--until", "5ms", *stiff)
    assert contacts["series"]["shear_work"][-1] != 0.0 and contacts["energy_error"] < 1e-10
    shaken = printed("gas", *numbers, "--shear", 50, "--shake", "0.1mm:50Hz", "--until", "5ms")
    assert shaken["system"]["boundary"] == ["periodic", "lees-edwards", "wall"]
    high = ["--boundary", "periodic", "--boundary", "periodic", "--boundary", "lees-edwards"]
    assert printed("gas", *numbers, "--shear", -50, *high, *FAST)["system"]["shear_rate"] == -50.0
    still = lattice(27, seed=1).replace(velocities=np.zeros((27, 3)))
    moved = printed("gas", still.write(tmp_path / "box.xyz"), "--shear", 50, *FAST)
    assert moved["system"]["boundary"][1] == "lees-edwards"
    assert moved["series"]["granular_temperature"][0] < 1e-25 < moved["series"]["kinetic_energy"][0]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            ["--boundary", "wall"],
            "--shear: got the boundary wall, must be one with lees-edwards, or left out",
        ),
        (["--shake", "1mm:50Hz", "--wall", "y-"], "--shear: got walls along y, must be none along x and y"),
        (["--gravity", 9.81, "--boundary", "periodic", *["--boundary", "lees-edwards"] * 2], "boundary: got"),
    ],
)
def test_bad_shear_is_refused(options: list[Any], message: str) -> None:
    assert message in refused("gas", "--n", 100, "--shear", 10, *options)
    assert "--shear: got 'fast'" in refused("gas", "--shear", "fast")


DUMPS = Path(__file__).parents[1] / "boxes" / "data" / "dumps"
EXAMPLES = Path(__file__).parents[2] / "examples"


def test_a_dump_as_start() -> None:
    """With what it lacks from the options; a job names it as well."""
    bed = [EXAMPLES / "dump.bed", "--density", "2.5 g/cm3", "--allowed-overlap", 0.01]
    output = printed("gas", *bed, "--max-collisions", 10, "--frame", 0)
    system = hl.ParticleSystem.read(bed[0], frame=0, density=2500.0, allowed_overlap=0.01)
    assert output["n_collisions"] == 10 and output["system"]["n"] == 60 == system.n
    tilted = [DUMPS / "sheared.lammps.gz", "--units", "lj", "--allowed-overlap", 0.2, "--max-collisions", 5]
    assert "missing for a box that tilts; --shear gives it" in refused("gas", *tilted)
    assert "--shear: got 40, must be near the slope of the velocities" in refused(
        "gas", *tilted, "--shear", 40
    )
    text = run("gas", *tilted, "--shear", 2).stdout
    assert "y lees-edwards" in text and "largest overlap, of the sum of radii" in text


@pytest.mark.parametrize("option", [("--frame", 1), ("--units", "cgs"), ("--allowed-overlap", 0.1)])
def test_options_of_a_file_without_one(option: tuple[str, object]) -> None:
    message = refused("gas", *option)
    assert f"{option[0]}: got " in message and "must be left out without a start from a file" in message


def test_a_dump_in_a_job(tmp_path: Path) -> None:
    job = tmp_path / "job.toml"
    (tmp_path / "dump.bed").write_bytes((DUMPS / "bed.liggghts").read_bytes())
    job.write_text(
        'start = "dump.bed"\n[random]\nallowed_overlap = 0.01\nframe = 1\nboundary = "wall"\n'
        "[event_driven]\nmax_collisions = 5\nrestitution = 0.8\n"
    )
    assert printed("gas", job)["system"]["boundary"] == ["wall"] * 3
