"""hl.sweep(store=…): whatever ends a run, what is finished stays, and the bytes in the end are the same."""

import errno
import hashlib
import os
import shutil
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import hardlimit as hl
from hardlimit.sweep import chunks as tiling
from hardlimit.sweep import store as storing
from hardlimit.sweep.plan import make_plan
from hardlimit.sweep.store import Store

PAPER = hl.Column.paper()
GRID = {"restitution": np.linspace(0.3, 1.0, 9), "gap": np.geomspace(1e-6, 1e-2, 5), "height": 0.7}


@pytest.fixture(autouse=True)
def small_tiles(monkeypatch: pytest.MonkeyPatch) -> None:
    """GRID makes five tiles, the last of them smaller."""
    monkeypatch.setattr(tiling, "POINTS", 10)
    monkeypatch.setattr(tiling, "POINTS_INTEGRATED", 10)


def files(folder: Path) -> dict[str, str]:
    """Every file of a folder, with its contents."""
    return {
        str(f.relative_to(folder)): hashlib.sha256(f.read_bytes()).hexdigest()
        for f in folder.rglob("*")
        if f.is_file()
    }


def interrupted(path: Path, after: int, **swept: object) -> None:
    """A sweep that ends after some points."""

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
    assert ds.gap.attrs == {"units": "m", "long_name": "gap between the balls Δh"}
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


def test_tiles_without_a_result_are_written_too(tmp_path: Path) -> None:
    """All NaN is what an array holds before it is written; it must not be taken for a missing tile."""
    swept = {**GRID, "height": 0.05}
    assert bool(hl.sweep(PAPER, store=tmp_path / "map.zarr", **swept).t_end.isnull().all())
    with Store(tmp_path / "map.zarr", *plan_and_tiles(swept)) as store:
        assert store.missing() == []


def plan_and_tiles(swept: dict[str, object]) -> tuple:
    plan = make_plan(PAPER, "newton", None, swept)
    return plan, tiling.Tiles.of(plan)


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
    assert told == [20, 30, 40, 45]
    assert files(tmp_path / "map.zarr") == files(tmp_path / "whole.zarr")
    told.clear()
    hl.sweep(PAPER, store=tmp_path / "map.zarr", progress=lambda done, _: told.append(done), **GRID)
    assert told == [45]


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
    (chunk.parent / "0.abc.partial").write_bytes(b"half")
    told: list[int] = []
    hl.sweep(PAPER, store=path, progress=lambda done, _: told.append(done), **GRID)
    assert told == [40, 45]
    assert files(path) == whole


def test_the_bytes_do_not_depend_on_threads(tmp_path: Path) -> None:
    for threads in (1, 3):
        hl.sweep(PAPER, store=tmp_path / str(threads), threads=threads, **GRID)
    assert files(tmp_path / "1") == files(tmp_path / "3")


KILLED_AT_EVERY_STEP = """
    import os, signal, sys
    from pathlib import Path
    import numpy as np
    import hardlimit as hl, zarr, xarray
    from hardlimit.sweep import chunks as tiles
    sys.path.insert(0, {tests!r})
    from test_store import GRID, PAPER, files

    tiles.POINTS = 20
    swept = dict(GRID, restitution=GRID["restitution"][:5])
    folder, steps, limit = Path({folder!r}), 0, None

    def count(event, args):
        global steps
        inside = [a for a in args if isinstance(a, (str, Path)) and str(a).startswith(str(folder))]
        if limit is not None and inside and event.startswith({events!r}):
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
    assert run("whole", 0) == 0
    whole, at, killed = files(folder / "whole"), 1, 0
    while run(str(at), at) != 0:
        killed += 1
        assert run(str(at), at + 1) in (0, signal.SIGKILL)
        assert run(str(at), 0) == 0
        assert files(folder / str(at)) == whole, at
        at += 1
    assert sorted(p.name for p in folder.iterdir() if p.name.startswith(".")) == []
    print(killed)
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.parametrize(
    "events", ["os.rename", pytest.param("", marks=pytest.mark.slow)], ids=["renames", "all"]
)
def test_killed_at_every_step_it_ends_with_the_same_bytes(tmp_path: Path, events: str) -> None:
    """SIGKILL before each access to the file system in turn, again while going on, then a run to the end."""
    script = KILLED_AT_EVERY_STEP.format(
        tests=str(Path(__file__).parent), folder=str(tmp_path), events=events
    )
    done = subprocess.run([sys.executable, "-c", textwrap.dedent(script)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > (10 if events else 60)


SLOW_SWEEP = """
    import sys
    import numpy as np
    import hardlimit as hl
    from hardlimit.sweep import chunks as tiles

    tiles.POINTS_INTEGRATED = {tile}
    soft = hl.Column.paper(law=hl.Viscoelastic(youngs_modulus=1e8, poisson_ratio=0.3, dissipative_time=0.015))
    print("ready", flush=True)
    hl.sweep(soft, store=sys.argv[1], gap=np.geomspace(1e-6, 1e-2, {points}),
             progress=lambda done, _: print(done, flush=True))
"""


def slow_sweep(path: Path, tile: int, points: int) -> subprocess.Popen:
    script = textwrap.dedent(SLOW_SWEEP.format(tile=tile, points=points))
    return subprocess.Popen(
        [sys.executable, "-c", script, str(path)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


@pytest.mark.slow
def test_killed_again_and_again_it_ends_with_the_same_bytes(tmp_path: Path) -> None:
    size = {"tile": 100, "points": 4000}
    assert slow_sweep(tmp_path / "whole.zarr", **size).communicate()[1] == ""
    kills, last = 0, ""
    while last != f"{size['points']}\n":
        with slow_sweep(tmp_path / "map.zarr", **size) as run:
            for _ in range(2 + kills % 5):
                last = run.stdout.readline() or last
            run.kill()
        kills += 1
    assert kills > 5
    assert slow_sweep(tmp_path / "map.zarr", **size).communicate()[1] == ""
    assert files(tmp_path / "map.zarr") == files(tmp_path / "whole.zarr")


def test_interrupted_it_stops_within_a_second(tmp_path: Path) -> None:
    """The one tile would take much longer."""
    import time

    run = slow_sweep(tmp_path / "map.zarr", tile=3_000_000, points=3_000_000)
    assert run.stdout.readline() == "ready\n"
    while not (tmp_path / "map.zarr").exists():
        time.sleep(0.05)
    time.sleep(0.5)
    began = time.perf_counter()
    run.send_signal(signal.SIGINT)
    errors = run.communicate()[1]
    assert time.perf_counter() - began < 1.0
    assert errors.rstrip().endswith("KeyboardInterrupt")
    assert bool((xr.open_zarr(tmp_path / "map.zarr").outcome == 255).all())


# --- refusals -----------------------------------------------------------------------------------------------

OTHER = {
    "other values of what is swept": {"gap": np.geomspace(1e-6, 2e-2, 5)},
    "other values of what is swept ": {"height": 0.8},
    "other values of what is swept  ": {"restitution": xr.DataArray(GRID["restitution"], dims="row")},
    "model newton, not adiabatic": {"model": "adiabatic"},
    "variables effective_restitution, n_contacts": {"variables": ["n_contacts"]},
    "column Column(": {"column": hl.Column.paper(height=0.61)},
}


@pytest.mark.parametrize("message", OTHER)
def test_a_store_of_another_sweep_is_refused(tmp_path: Path, message: str) -> None:
    path = tmp_path / "map.zarr"
    hl.sweep(PAPER, store=path, **GRID)
    before = files(path)
    with pytest.raises(ValueError) as refused:
        hl.sweep(**{"column": PAPER, "store": path, **GRID, **OTHER[message]})
    assert str(refused.value).startswith(f"store: {path} was made with {message.strip()}")
    assert "\n" not in str(refused.value)
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


def test_what_is_no_store_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    for path, message in ((tmp_path, "holds something else"), (tmp_path / "notes.txt", "is a file")):
        with pytest.raises(ValueError, match=message):
            hl.sweep(PAPER, store=path, **GRID)
    xr.Dataset({"a": 1.0}).to_zarr(tmp_path / "other.zarr", consolidated=False)
    with pytest.raises(ValueError, match="holds something else"):
        hl.sweep(PAPER, store=tmp_path / "other.zarr", **GRID)
    assert (tmp_path / "notes.txt").read_text() == "mine"


def test_an_empty_folder_is_filled(tmp_path: Path) -> None:
    hl.sweep(PAPER, store=str(tmp_path), **GRID)
    assert (tmp_path / "zarr.json").exists()


@pytest.mark.parametrize("path", [3, "", "s3://bucket/map.zarr"])
def test_a_store_is_a_local_folder(path: object) -> None:
    with pytest.raises(ValueError, match=r"store: got .*, must be the path of a local folder"):
        hl.sweep(PAPER, store=path, **GRID)


@pytest.mark.skipif(sys.platform == "win32", reason="no locks")
def test_two_writers_at_once_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "map.zarr"
    refused = pytest.raises(ValueError, match=r"map\.zarr is being written by another process")
    with Store(path, *plan_and_tiles(GRID)), refused:
        hl.sweep(PAPER, store=path, **GRID)
    hl.sweep(PAPER, store=path, **GRID)
    with Store(path, *plan_and_tiles(GRID)):  # complete: anybody may read
        hl.sweep(PAPER, store=path, **GRID)


# --- full disks and read-only folders -----------------------------------------------------------------------


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EDQUOT, errno.EIO])
@pytest.mark.parametrize("name", ["n_contacts", "t_end", "outcome"])
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
    assert str(failed.value) == f"store: cannot write {path}: {os.strerror(code)}; what is finished is kept"
    assert failed.value.errno == code
    with Store(path, *plan_and_tiles(GRID)) as store:
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
        patch.setattr(storing, "_write_metadata", fail)
        with pytest.raises(OSError, match=r"store: cannot write .*map\.zarr: No space left on device"):
            hl.sweep(PAPER, store=tmp_path / "map.zarr", **GRID)
    assert list(tmp_path.iterdir()) == []


ON_A_FILE_SYSTEM = """
    import numpy as np
    import hardlimit as hl
    from hardlimit.sweep import chunks as tiles

    tiles.POINTS = 10_000
    try:
        swept = {{"gap": np.geomspace(1e-6, 1e-2, 45_000)}}
        hl.sweep(hl.Column.paper(), model="independent", store={path!r}, **swept)
    except OSError as error:
        print(error)
    else:
        print("done")
"""


def in_namespace(path: Path, before: str, after: str = "true") -> str:
    """What a sweep of 45000 points, 1.9 MB, says in a process with file systems of its own."""
    script = textwrap.dedent(ON_A_FILE_SYSTEM.format(path=str(path)))
    command = ["unshare", "-rm", "sh", "-ec", f'{before}; "$0" -c "$1"; {after}', sys.executable, script]
    return subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout.strip()


def can_mount() -> bool:
    probe = ["unshare", "-rm", "mount", "-t", "tmpfs", "tmpfs", "/mnt"]
    return shutil.which("unshare") is not None and subprocess.run(probe, capture_output=True).returncode == 0


@pytest.mark.skipif(not can_mount(), reason="may not mount")
def test_a_full_disk(tmp_path: Path) -> None:
    """A real one, too small; then a larger one with what was kept."""
    disk, kept = tmp_path / "disk", tmp_path / "kept"
    disk.mkdir()
    mount = f"mount -t tmpfs -o size={{}} tmpfs {disk}"
    said = in_namespace(disk / "map.zarr", mount.format("1m"), f"cp -r {disk} {kept}")
    assert said == f"store: cannot write {disk}/map.zarr: No space left on device; what is finished is kept"
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


@pytest.mark.skipif(not can_mount(), reason="may not mount")
def test_a_read_only_folder(tmp_path: Path) -> None:
    path = tmp_path / "map.zarr"
    read_only = f"mount --bind {tmp_path} {tmp_path}; mount -o remount,ro,bind {tmp_path}"
    refused = f"store: cannot write {path}: Read-only file system; what is finished is kept"
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
    """4e6 points are 168 MB of results; 64 MiB must do."""
    command = [sys.executable, "-c", textwrap.dedent(MEMORY), str(tmp_path / "map.zarr"), "2000"]
    assert int(subprocess.run(command, capture_output=True, text=True, check=True).stdout) < 64
