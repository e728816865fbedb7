"""hl.sweep(store=…): finished chunks survive any interruption, and the final bytes are the same."""

import errno
import hashlib
import os
import shutil
import signal
import subprocess
import sys
import textwrap
import threading
import warnings
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from filelock import FileLock

import hardlimit as hl
from conftest import refusal, slow
from hardlimit.support import saving
from hardlimit.sweep import chunks as chunking
from hardlimit.sweep import store as storing
from hardlimit.sweep.computation import Computation, Coordinate, Values, Variable
from hardlimit.sweep.engines import ENGINES
from hardlimit.sweep.plan import make_plan
from hardlimit.sweep.store import Store

PAPER = hl.Column.paper()
GRID = {"restitution": np.linspace(0.3, 1.0, 9), "gap": np.geomspace(1e-6, 1e-2, 5), "height": 0.7}

#: For processes that import this module.
TESTS = [str(Path(__file__).parent), str(Path(__file__).parents[1])]


@pytest.fixture(autouse=True)
def small_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    """GRID has five chunks, the last one smaller."""
    monkeypatch.setattr(chunking, "POINTS", 10)
    monkeypatch.setattr(chunking, "POINTS_INTEGRATED", 10)


def files(folder: Path) -> dict[str, str]:
    """Hashes of all files of a folder."""
    return {
        str(f.relative_to(folder)): hashlib.sha256(f.read_bytes()).hexdigest()
        for f in folder.rglob("*")
        if f.is_file()
    }


def interrupted(path: Path, after: int, **swept: object) -> None:
    """A sweep that is interrupted after some points."""

    def stop(done: int, total: int) -> None:
        if done >= after:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        hl.sweep(PAPER, store=path, progress=stop, **{**GRID, **swept})


# --- what it holds ------------------------------------------------------------------------------------------


def test_a_store_holds_the_same_results(tmp_path: Path) -> None:
    stored = hl.sweep(PAPER, store=tmp_path / "map.zarr", **GRID)
    plain = hl.sweep(PAPER, **GRID)
    assert list(stored) == list(plain)
    xr.testing.assert_equal(stored, plain)
    for name in plain:
        assert stored[name].attrs.keys() == plain[name].attrs.keys()
    assert stored.attrs.items() >= {k: v for k, v in plain.attrs.items() if k != "wall_time_s"}.items()


def test_it_opens_with_xarray_alone(tmp_path: Path) -> None:
    hl.sweep(PAPER, store=tmp_path / "map.zarr", **GRID)
    ds = xr.open_zarr(tmp_path / "map.zarr")
    assert ds.n_contacts.dims == ("restitution", "gap")
    np.testing.assert_array_equal(ds.gap, GRID["gap"])
    assert float(ds.height) == 0.7 and "height" in ds.coords
    assert ds.gap.attrs == {"units": "m", "long_name": "gap between neighbouring balls Δh"}
    assert ds.t_end.attrs["units"] == "s" and ds.t_end.dtype == np.float64
    assert ds.outcome.flag_meanings.split()[0] == "ok" and ds.outcome.flag_values[0] == 0
    assert ds.attrs["model"] == "newton" and ds.attrs["column"] == repr(PAPER)
    assert ds.attrs["hardlimit_version"] and ds.attrs["Conventions"].startswith("CF-")
    assert not {"wall_time_s", "engine"} & ds.attrs.keys()


def test_it_is_read_when_used(tmp_path: Path) -> None:
    ds = hl.sweep(PAPER, store=tmp_path / "map.zarr", **GRID)
    assert not ds.n_contacts._in_memory
    ds.to_netcdf(tmp_path / "map.nc")
    with xr.open_dataset(tmp_path / "map.nc") as copy:
        xr.testing.assert_equal(copy, ds)


def test_points_in_a_list_and_a_single_point(tmp_path: Path) -> None:
    points = {"gap": xr.DataArray(np.geomspace(1e-6, 1e-2, 25), dims="point")}
    points["restitution"] = xr.DataArray(np.linspace(0.3, 1, 25), dims="point")
    for name, swept in {"list": points, "one": {"height": 0.7}}.items():
        xr.testing.assert_equal(hl.sweep(PAPER, store=tmp_path / name, **swept), hl.sweep(PAPER, **swept))
        opened = xr.open_zarr(tmp_path / name)
        assert set(opened.coords) == set(swept)
        xr.testing.assert_equal(hl.sweep(PAPER, store=tmp_path / name, **swept), opened)


def test_counts_above_a_byte_have_room(tmp_path: Path) -> None:
    column = hl.Column.paper(restitution=1.0, radius_2=1e-4, radius_1=0.1, height=4.0)
    swept = {"gap": np.geomspace(1e-11, 1e-4, 21)}
    stored, plain = hl.sweep(column, store=tmp_path / "map.zarr", **swept), hl.sweep(column, **swept)
    assert plain.n_contacts.max() > 255
    xr.testing.assert_equal(stored, plain)


def test_chunks_without_a_result_are_written_too(tmp_path: Path) -> None:
    """An array is NaN before it is written; such results must not count as a missing chunk."""
    swept = {**GRID, "height": 0.05}
    assert bool(hl.sweep(PAPER, store=tmp_path / "map.zarr", **swept).t_end.isnull().all())
    with Store(tmp_path / "map.zarr", *plan_and_chunks(swept)) as store:
        assert store.missing() == []


def plan_and_chunks(swept: dict[str, object]) -> tuple:
    plan = make_plan(PAPER, "newton", None, swept)
    return plan, chunking.Chunks.of(plan)


def test_an_unfinished_store_says_what_is_missing(tmp_path: Path) -> None:
    interrupted(tmp_path / "map.zarr", after=20)
    ds = xr.open_zarr(tmp_path / "map.zarr")
    missing = dict(zip(ds.outcome.flag_meanings.split(), ds.outcome.flag_values, strict=True))["not_computed"]
    assert int((ds.outcome == missing).sum()) == 45 - 20
    assert int((ds.n_contacts > 2**31).sum()) == 45 - 20
    assert bool((ds.t_end.isnull() == (ds.outcome == missing)).all())


# --- going on -----------------------------------------------------------------------------------------------


def test_only_what_is_missing_is_computed(tmp_path: Path) -> None:
    hl.sweep(PAPER, store=tmp_path / "whole.zarr", **GRID)
    interrupted(tmp_path / "map.zarr", after=20)
    told: list[int] = []
    hl.sweep(PAPER, store=tmp_path / "map.zarr", progress=lambda done, _: told.append(done), **GRID)
    assert sorted(set(told)) == [20, 30, 40, 45]  # what is done may be told again while a chunk is under way
    assert files(tmp_path / "map.zarr") == files(tmp_path / "whole.zarr")
    told.clear()
    hl.sweep(PAPER, store=tmp_path / "map.zarr", progress=lambda done, _: told.append(done), **GRID)
    assert set(told) == {45}


@pytest.mark.parametrize("name", ["n_contacts", "t_end", "outcome"])
@pytest.mark.parametrize("torn", [False, True], ids=["lost", "empty"])
def test_lost_and_empty_files_are_replaced(tmp_path: Path, name: str, torn: bool) -> None:
    path = tmp_path / "map.zarr"
    hl.sweep(PAPER, store=path, **GRID)
    whole = files(path)
    chunk = path / name / "c" / "4" / "0"
    chunk.unlink()
    if torn:
        chunk.touch()
    (chunk.parent / f"0.{'ab' * 16}.partial").write_bytes(b"half")
    told: list[int] = []
    hl.sweep(PAPER, store=path, progress=lambda done, _: told.append(done), **GRID)
    assert sorted(set(told)) == [40, 45]  # what is done may be told again while a chunk is under way
    assert files(path) == whole


def test_the_store_does_not_depend_on_threads(tmp_path: Path) -> None:
    for threads in (1, 3):
        hl.sweep(PAPER, store=tmp_path / str(threads), threads=threads, **GRID)
    assert files(tmp_path / "1") == files(tmp_path / "3")


KILLED_AT_EVERY_STEP = """
    import os, signal, sys
    from pathlib import Path
    import numpy as np
    import hardlimit as hl, zarr, xarray
    from hardlimit.sweep import chunks
    sys.path[:0] = {tests!r}
    from test_store import GRID, PAPER, files

    chunks.POINTS = 20
    swept = dict(GRID, restitution=GRID["restitution"][:3])
    folder, steps, limit = Path({folder!r}), 0, None

    def count(event, args):
        global steps
        inside = [a for a in args if isinstance(a, (str, Path)) and str(a).startswith(str(folder))]
        if limit is not None and inside:
            steps += 1
            if steps == limit:
                os.kill(os.getpid(), signal.SIGKILL)

    def run(name, at):
        global limit, steps
        child = os.fork()
        if child == 0:
            limit, steps = at, 0
            hl.sweep(PAPER, store=folder / name, variables=["n_contacts", "t_end"], **swept)
            os._exit(0)
        return os.waitpid(child, 0)[1]

    sys.addaudithook(count)
    hl.sweep(PAPER, gap=[1e-4])  # what xarray loads at first use, each child would load again
    assert run("whole", 0) == 0
    whole, at, killed = files(folder / "whole"), 1, 0
    while run(str(at), at) != 0:
        killed += 1
        assert run(str(at), at + 1) in (0, signal.SIGKILL)
        assert run(str(at), 0) == 0
        assert files(folder / str(at)) == whole, at
        at += 1
    assert [p.name for p in folder.iterdir() if p.name.startswith(".") and p.suffix != ".lock"] == []
    print(killed)
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.slow
def test_killed_at_every_step_it_ends_with_the_same_bytes(tmp_path: Path) -> None:
    """SIGKILL before each file access in turn, again while resuming, then a run to the end."""
    script = KILLED_AT_EVERY_STEP.format(tests=TESTS, folder=str(tmp_path))
    done = subprocess.run([sys.executable, "-c", textwrap.dedent(script)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 50


SLOW_SWEEP = """
    import sys
    import numpy as np
    import hardlimit as hl
    from hardlimit.sweep import chunks

    chunks.POINTS_INTEGRATED = {chunk}
    soft = hl.Column.paper(law=hl.Viscoelastic(youngs_modulus=1e8, poisson_ratio=0.3, dissipative_time=0.007))
    print("ready", flush=True)
    hl.sweep(soft, store=sys.argv[1], gap=np.geomspace(1e-6, 1e-2, {points}),
             progress=lambda done, _: print(done, flush=True))
"""


def slow_sweep(path: Path, chunk: int, points: int) -> subprocess.Popen:
    script = textwrap.dedent(SLOW_SWEEP.format(chunk=chunk, points=points))
    return subprocess.Popen(
        [sys.executable, "-c", script, str(path)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def under_way(run: subprocess.Popen) -> int:
    """Wait until the process reports finished points; returns their number."""
    for line in run.stdout:
        if line.strip().isdecimal() and int(line) > 0:
            return int(line)
    raise AssertionError(run.stderr.read())


@pytest.mark.slow
def test_interrupted_it_stops_within_the_chunk(tmp_path: Path) -> None:
    """The one chunk would take minutes."""
    points = 3_000_000
    run = slow_sweep(tmp_path / "map.zarr", chunk=points, points=points)
    done = under_way(run)
    run.send_signal(signal.SIGINT)
    told, errors = run.communicate(timeout=60)
    assert int(told.split()[-1] if told else done) < points / 10
    assert errors.rstrip().endswith("KeyboardInterrupt")
    assert bool((xr.open_zarr(tmp_path / "map.zarr").outcome == 255).all())


# --- damage -------------------------------------------------------------------------------------------------

SMALL = {"restitution": np.linspace(0.3, 1.0, 4), "gap": np.geomspace(1e-6, 1e-2, 5), "height": 0.7}
KEPT = {"variables": ["n_contacts", "final_velocity"], **SMALL}


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An undamaged store of two chunks."""
    path = tmp_path_factory.mktemp("finished") / "map.zarr"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(chunking, "POINTS", 10)
        hl.sweep(PAPER, store=path, **KEPT)
    return path


@cache
def undamaged() -> xr.Dataset:
    """The results of every repaired store."""
    return hl.sweep(PAPER, **KEPT)


def damaged(path: Path, finished: Path, *, said: bool) -> None:
    """The sweep gives the right results and the bytes of an undamaged store, or is refused in one line."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            ds = hl.sweep(PAPER, store=path, **KEPT)
        except ValueError as refused:
            assert str(refused).startswith(f"store: {path} ") and "\n" not in str(refused)
            return
    xr.testing.assert_equal(ds.load(), undamaged())
    assert files(path) == files(finished)
    words = [str(warning.message) for warning in caught]
    assert len(words) <= 1 and all(w.startswith(f"store: {path}: ") and "\n" not in w for w in words)
    assert words or not said


def every_file(folder: Path) -> list[Path]:
    files = sorted(f.relative_to(folder) for f in folder.rglob("*") if f.is_file())
    assert len(files) > 10
    return files


#: Every tenth file of a store; the slow tests take all.
some_or_all = pytest.mark.parametrize("step", [10, slow(1)])


@some_or_all
def test_a_flipped_byte_anywhere_is_found(tmp_path: Path, finished: Path, step: int) -> None:
    for number, file in enumerate(every_file(finished)[::step]):
        length = (finished / file).stat().st_size
        for at in {*range(0, length, 1 + length // 3), length - 2}:
            path = tmp_path / f"{number}-{at}"
            shutil.copytree(finished, path)
            content = bytearray((path / file).read_bytes())
            content[at] ^= 1 << (at % 8)
            (path / file).write_bytes(content)
            damaged(path, finished, said=file.name != "zarr.json")  # there, the layout does not matter


@some_or_all
def test_a_file_cut_short_or_replaced_is_found(tmp_path: Path, finished: Path, step: int) -> None:
    for number, file in enumerate(every_file(finished)[::step]):
        content = (finished / file).read_bytes()
        for i, other in enumerate((content[:-1], content[: len(content) // 2], b"[]", content + content)):
            path = tmp_path / f"{number}-{i}"
            shutil.copytree(finished, path)
            (path / file).write_bytes(other)
            damaged(path, finished, said=True)


@some_or_all
def test_missing_files_are_restored(tmp_path: Path, finished: Path, step: int) -> None:
    """Each file and each folder in turn; a missing chunk is no damage."""
    everything = sorted(f.relative_to(finished) for f in finished.rglob("*"))
    for number, gone in enumerate(everything[::step]):
        path = tmp_path / str(number)
        shutil.copytree(finished, path)
        shutil.rmtree(path / gone) if (path / gone).is_dir() else (path / gone).unlink()
        damaged(path, finished, said=gone.name == "zarr.json")


def test_damaged_chunks_are_counted(tmp_path: Path, finished: Path) -> None:
    path = tmp_path / "map.zarr"
    shutil.copytree(finished, path)
    file = path / "final_velocity" / "c" / "1" / "0" / "0"
    file.write_bytes(file.read_bytes()[:-1] + b"x")
    told: list[int] = []
    with pytest.warns(UserWarning, match=r"1 of 2 chunks are damaged and will be recomputed"):
        hl.sweep(PAPER, store=path, progress=lambda done, _: told.append(done), **KEPT)
    assert told[0] == 10 and told[-1] == 20


def test_without_its_group_a_store_with_chunks_is_refused(tmp_path: Path, finished: Path) -> None:
    """The sweep of the chunks is unknown."""
    path = tmp_path / "map.zarr"
    shutil.copytree(finished, path)
    (path / "zarr.json").write_text("[]")
    with pytest.raises(
        ValueError, match=r"has other contents, must be the store of a sweep with its zarr\.json"
    ):
        hl.sweep(PAPER, store=path, **KEPT)


def test_other_files_in_a_store_are_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "map.zarr"
    interrupted(path, after=20)
    mine = [
        "notes",
        "draft.partial",
        "t_end/notes",
        "t_end/c/0.partial",
        "outcome/c/4/mine.txt",
        "c/x.partial",
    ]
    for name in mine:
        (path / name).parent.mkdir(parents=True, exist_ok=True)
        (path / name).touch()
    half = path / "t_end" / "c" / "4" / f"0.{'ab' * 16}.partial"
    half.parent.mkdir(exist_ok=True)
    half.touch()
    hl.sweep(PAPER, store=path, **GRID)
    assert [name for name in mine if not (path / name).exists()] == []
    assert not half.exists()


# --- refusals -----------------------------------------------------------------------------------------------

OTHER = {
    "other values of the swept parameters": {"gap": np.geomspace(1e-6, 2e-2, 5)},
    "other values of the swept parameters ": {"height": 0.8},
    "other values of the swept parameters  ": {"restitution": xr.DataArray(GRID["restitution"], dims="row")},
    "model newton, not adiabatic": {"model": "adiabatic"},
    "variables effective_restitution, n_contacts": {"variables": ["n_contacts"]},
    "column Column(": {"column": hl.Column.paper(height=0.61)},
}


@pytest.mark.parametrize("message", OTHER)
def test_a_store_of_another_sweep_is_refused(tmp_path: Path, message: str) -> None:
    path = tmp_path / "map.zarr"
    hl.sweep(PAPER, store=path, **GRID)
    before = files(path)
    refused = refusal(lambda: hl.sweep(**{"column": PAPER, "store": path, **GRID, **OTHER[message]}))
    assert refused.startswith(f"store: {path} was made with {message.strip()}")
    assert files(path) == before


def test_a_store_of_another_tolerance_is_refused(tmp_path: Path) -> None:
    law = hl.Viscoelastic(youngs_modulus=5e7, poisson_ratio=0.45, restitution=0.7, impact_speed=3.0)
    soft = hl.Column.paper(law=law)
    path = tmp_path / "map.zarr"
    hl.sweep(soft, store=path, tolerance=1e-9, **GRID)
    with pytest.raises(ValueError, match=r"was made with tolerance 1e-09, not 2\.3283\d+e-10; repeat"):
        hl.sweep(soft, store=path, **GRID)


def test_a_store_of_another_version_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "map.zarr"
    hl.sweep(PAPER, store=path, **GRID)
    attributes = (path / "zarr.json").read_text()
    version = hl.sweep(PAPER).attrs["hardlimit_version"]
    fingerprint = xr.open_zarr(path).attrs["fingerprint"]
    older = attributes.replace(f'"{version}"', '"0.0.9"').replace(fingerprint, "0" * 64)
    (path / "zarr.json").write_text(older)
    with pytest.raises(ValueError, match=rf"was made with version 0\.0\.9, not {version}; repeat"):
        hl.sweep(PAPER, store=path, **GRID)


def test_other_folders_and_files_are_left_alone(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    for path, message in ((tmp_path, "has other contents"), (tmp_path / "notes.txt", "is a file")):
        with pytest.raises(ValueError, match=message):
            hl.sweep(PAPER, store=path, **GRID)
    xr.Dataset({"a": 1.0}).to_zarr(tmp_path / "other.zarr", consolidated=False)
    with pytest.raises(ValueError, match="has other contents"):
        hl.sweep(PAPER, store=tmp_path / "other.zarr", **GRID)
    assert (tmp_path / "notes.txt").read_text() == "mine"


def test_an_empty_folder_is_filled(tmp_path: Path) -> None:
    hl.sweep(PAPER, store=str(tmp_path), **GRID)
    assert (tmp_path / "zarr.json").exists()


@pytest.mark.parametrize("path", [3, "", "s3://bucket/map.zarr"])
def test_a_store_is_a_local_folder(path: object) -> None:
    with pytest.raises(ValueError, match=r"store: got .*, must be (a path|the path of a local folder)"):
        hl.sweep(PAPER, store=path, **GRID)


def test_two_writers_at_once_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "map.zarr"
    refused = pytest.raises(ValueError, match=r"map\.zarr is being written by another process")
    monkeypatch.setattr(saving.locked.__wrapped__, "__defaults__", (0.1,))
    with Store(path, *plan_and_chunks(GRID)), refused:
        hl.sweep(PAPER, store=path, **GRID)
    hl.sweep(PAPER, store=path, **GRID)
    with Store(path, *plan_and_chunks(GRID)):  # complete: anybody may read
        hl.sweep(PAPER, store=path, **GRID)


def test_the_lock_of_a_process_that_is_ending_is_awaited(tmp_path: Path) -> None:
    """A process that was killed keeps its lock until it is gone: the same call right after must not be refused."""
    path, locked, waiting = tmp_path / "map.zarr", threading.Event(), threading.Event()

    def hold() -> None:
        with saving.locked(path):
            locked.set()
            waiting.wait()

    other = threading.Thread(target=hold)
    other.start()
    locked.wait()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            FileLock, "acquire", lambda lock, acquire=FileLock.acquire: waiting.set() or acquire(lock)
        )
        ds = hl.sweep(PAPER, store=path, **GRID)
    other.join()
    xr.testing.assert_equal(ds, hl.sweep(PAPER, **GRID))


def test_two_may_make_a_store_at_once(tmp_path: Path) -> None:
    """One makes it while the other waits for the lock and then resumes it."""
    path = tmp_path / "map.zarr"
    is_new = storing._is_new

    def too_late(at: Path) -> bool:
        new = is_new(at)
        if new:
            patch.setattr(storing, "_is_new", is_new)
            hl.sweep(PAPER, store=path, **GRID)
        return new

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(storing, "_is_new", too_late)
        ds = hl.sweep(PAPER, store=path, **GRID)
    xr.testing.assert_equal(ds, hl.sweep(PAPER, **GRID))


# --- full disks and read-only folders -----------------------------------------------------------------------


@pytest.mark.parametrize("code", [errno.ENOSPC, slow(errno.EDQUOT), slow(errno.EIO)])
@pytest.mark.parametrize("name", [slow("n_contacts"), slow("t_end"), "outcome"])
def test_a_write_that_fails_is_one_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, code: int, name: str
) -> None:
    path = tmp_path / "map.zarr"
    hl.sweep(PAPER, store=tmp_path / "whole.zarr", **GRID)
    with monkeypatch.context() as patch:
        replace = Path.replace

        def fail(source: Path, target: Path) -> Path:
            if name in source.parts and str(target).endswith("c/3/0"):
                raise OSError(code, os.strerror(code))
            return replace(source, target)

        patch.setattr(Path, "replace", fail)
        with pytest.raises(OSError) as failed:
            hl.sweep(PAPER, store=path, **GRID)
    assert str(failed.value) == f"store: cannot write {path}: {os.strerror(code)}; finished chunks are kept"
    assert failed.value.errno == code
    with Store(path, *plan_and_chunks(GRID)) as store:
        assert store.missing() == [3, 4]
    outcome = xr.open_zarr(path).outcome
    assert bool((outcome[:6] == 0).all() and (outcome[6:] == 255).all())
    hl.sweep(PAPER, store=path, **GRID)
    assert files(path) == files(tmp_path / "whole.zarr")


def test_metadata_that_cannot_be_written_leave_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr(storing, "_replace", fail)
        with pytest.raises(OSError, match=r"store: cannot write .*map\.zarr: No space left on device"):
            hl.sweep(PAPER, store=tmp_path / "map.zarr", **GRID)
    assert list(tmp_path.iterdir()) == []  # no lock either


ON_A_FILE_SYSTEM = """
    import numpy as np
    import hardlimit as hl
    from hardlimit.sweep import chunks

    chunks.POINTS = 10_000
    try:
        swept = {{"gap": np.geomspace(1e-6, 1e-2, 45_000)}}
        hl.sweep(hl.Column.paper(), model="independent", store={path!r}, **swept)
    except OSError as error:
        print(error)
    else:
        print("done")
"""


def in_namespace(path: Path, before: str, after: str = "true") -> str:
    """Output of a sweep of 45000 points, 1.9 MB, in a process with its own file systems."""
    script = textwrap.dedent(ON_A_FILE_SYSTEM.format(path=str(path)))
    command = ["unshare", "-rm", "sh", "-ec", f'{before}; "$0" -c "$1"; {after}', sys.executable, script]
    return subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout.strip()


def can_mount() -> bool:
    probe = ["unshare", "-rm", "mount", "-t", "tmpfs", "tmpfs", "/mnt"]
    return shutil.which("unshare") is not None and subprocess.run(probe, capture_output=True).returncode == 0


def test_without_zarr_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "zarr", None)
    with pytest.raises(ValueError, match=r"store: got '.*map', needs Zarr: pip install 'hardlimit\[store\]'"):
        hl.sweep(PAPER, store=tmp_path / "map", **GRID)
    assert not (tmp_path / "map").exists()
    assert hl.sweep(PAPER, **GRID).sizes["restitution"] == 9


@pytest.mark.slow
@pytest.mark.skipif(not can_mount(), reason="may not mount")
def test_a_full_disk(tmp_path: Path) -> None:
    """A file system that is too small; then a larger one with the kept files."""
    disk, kept = tmp_path / "disk", tmp_path / "kept"
    disk.mkdir()
    mount = f"mount -t tmpfs -o size={{}} tmpfs {disk}"
    said = in_namespace(disk / "map.zarr", mount.format("1m"), f"cp -r {disk} {kept}")
    assert said == f"store: cannot write {disk}/map.zarr: No space left on device; finished chunks are kept"
    swept = {"gap": np.geomspace(1e-6, 1e-2, 45_000)}
    expected = hl.sweep(PAPER, model="independent", **swept)
    begun = xr.open_zarr(kept / "map.zarr").load()
    finished = begun.outcome != 255
    assert 9_000 <= finished.sum() <= 27_000
    xr.testing.assert_equal(
        begun[list(expected)].where(finished, drop=True), expected.where(finished, drop=True)
    )
    larger = f"{mount.format('16m')}; cp -r {kept}/. {disk}"
    assert in_namespace(disk / "map.zarr", larger, f"rm -r {kept}; cp -r {disk} {kept}") == "done"
    xr.testing.assert_equal(xr.open_zarr(kept / "map.zarr"), expected)


@pytest.mark.slow
@pytest.mark.skipif(not can_mount(), reason="may not mount")
def test_a_read_only_folder(tmp_path: Path) -> None:
    path = tmp_path / "map.zarr"
    read_only = f"mount --bind {tmp_path} {tmp_path}; mount -o remount,ro,bind {tmp_path}"
    refused = f"store: cannot write {path}: Read-only file system; finished chunks are kept"
    assert in_namespace(path, read_only) == refused
    assert in_namespace(path, "true") == "done"
    assert in_namespace(path, read_only) == "done"  # a complete store is only read
    (path / "outcome" / "c" / "2").unlink()
    assert in_namespace(path, read_only) == refused
    assert in_namespace(path, "true") == "done"


# --- memory -------------------------------------------------------------------------------------------------

MEMORY = """
    import resource, sys
    import numpy as np
    import hardlimit as hl, zarr, xarray

    def peak():
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss >> 10

    column, n = hl.Column.paper(), int(sys.argv[2])
    hl.sweep(column, model="independent", store=sys.argv[1] + "-first", gap=np.geomspace(1e-6, 1e-2, 1000))
    before = peak()
    swept = dict(restitution=np.linspace(0.3, 1, n), gap=np.geomspace(1e-6, 1e-2, 2000))
    hl.sweep(column, model="independent", store=sys.argv[1], **swept)
    print(peak() - before)
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="units of ru_maxrss")
def test_a_store_needs_no_memory_for_its_results(tmp_path: Path) -> None:
    """4e6 points have 168 MB of results; 64 MiB must suffice."""
    command = [sys.executable, "-c", textwrap.dedent(MEMORY), str(tmp_path / "map.zarr"), "2000"]
    assert int(subprocess.run(command, capture_output=True, text=True, check=True).stdout) < 64


# --- something other than columns ---------------------------------------------------------------------------


@dataclass(frozen=True)
class Powers:
    """x and its powers over a grid of x and an offset: a minimal computation."""

    x: np.ndarray
    offset: np.ndarray
    dims = ("x", "offset")
    results = {  # noqa: RUF012
        "square": Variable("float64", "1", "x² + offset"),
        "powers": Variable("float64", "1", "x, x², x³", ("power",), (3,)),
    }
    integrated = False

    @property
    def shape(self) -> tuple[int, ...]:
        return len(self.x), len(self.offset)

    @property
    def size(self) -> int:
        return len(self.x) * len(self.offset)

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        labels = {"x": self.x, "offset": self.offset, "power": np.array([1, 2, 3])}
        return tuple(Coordinate(name, name, values, "1", name) for name, values in labels.items())

    def attributes(self) -> dict[str, object]:
        return {"made_of": "powers"}

    def fingerprint(self) -> str:
        return repr((self.x.tolist(), self.offset.tolist()))

    def part(self, box: tuple[slice, ...]) -> "Powers":
        return Powers(self.x[box[0]], self.offset[box[1]])

    def compute(self, first: int, count: int, threads: int, progress: object = None) -> Values:
        x, offset = np.meshgrid(self.x, self.offset, indexing="ij")
        x, offset = x.ravel()[first : first + count], offset.ravel()[first : first + count]
        return {"square": x**2 + offset, "powers": np.stack([x, x**2, x**3], axis=1)}


@pytest.mark.parametrize("engine", ["cpu", "dask"])
def test_any_computation_can_be_stored(tmp_path: Path, engine: str) -> None:
    powers: Computation = Powers(np.linspace(0, 1, 9), np.linspace(1, 2, 5))
    chunks = chunking.Chunks.of(powers)
    for _ in range(2):
        with Store(tmp_path / "powers", powers, chunks) as store:
            for chunk, values in ENGINES[engine].compute(powers, chunks, store.missing()[:3], 1, print, None):
                store.write(chunk, values)
    with Store(tmp_path / "powers", powers, chunks) as store:
        assert store.missing() == []
        ds = store.dataset()
    assert ds.powers.dims == ("x", "offset", "power")
    xr.testing.assert_allclose(ds.square, ds.x**2 + ds.offset)
    xr.testing.assert_allclose(ds.powers, (ds.x**ds.power).broadcast_like(ds.powers))


@pytest.mark.slow
def test_the_command_reports_damaged_chunks(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "hardlimit", "sweep", "--restitution", "0.5:1:20", "--out", "map.zarr"]
    assert subprocess.run(command, cwd=tmp_path, capture_output=True).returncode == 0
    chunk = tmp_path / "map.zarr" / "t_end" / "c" / "0"
    chunk.write_bytes(chunk.read_bytes()[:-1])
    again = subprocess.run([*command, "--resume"], cwd=tmp_path, capture_output=True, text=True)
    assert again.returncode == 0
    said = again.stderr.splitlines()
    assert len(said) == 1 and said[0].startswith("hardlimit sweep: store: ")
    assert said[0].endswith("1 of 1 chunks are damaged and will be recomputed")
