"""hl.sweep(engine="dask"): a real scheduler and workers, each a process, some of them killed."""

import gc
import os
import signal
import subprocess
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

pytest.importorskip("distributed")

from distributed import Client, Future, LocalCluster
from test_store import files, under_way
from test_sweep import same_bits

import hardlimit as hl
from conftest import slow, wait_until
from hardlimit.support import cluster as connecting
from hardlimit.sweep import chunks as chunking
from hardlimit.sweep.engines import dask as cluster
from hardlimit.sweep.plan import make_plan

PAPER = hl.Column.paper()
#: Comes to rest after a long time: a slow kind of point, about 0.4 ms.
SOFT = hl.Column.paper(law=hl.Viscoelastic(youngs_modulus=1e8, poisson_ratio=0.3, dissipative_time=0.007))
GRID = {"restitution": np.linspace(0.3, 1.0, 40), "gap": np.geomspace(1e-6, 1e-2, 50)}
SLOW = {"gap": np.geomspace(1e-6, 1e-2, 4_000)}  # more than a second


def one_worker() -> LocalCluster:
    return LocalCluster(n_workers=1, threads_per_worker=1, processes=False, dashboard_address="127.0.0.1:0")


@pytest.fixture(autouse=True)
def small_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chunking, "POINTS", 120)
    monkeypatch.setattr(chunking, "POINTS_INTEGRATED", 200)


class Processes:
    """A scheduler and workers as a user starts them, ``dask scheduler`` and ``dask worker``."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.running: list[subprocess.Popen] = []
        self.address = ""

    def start(self, what: str, *options: str) -> subprocess.Popen:
        command = [sys.executable, "-m", f"distributed.cli.dask_{what}", *options, "--no-dashboard"]
        with open(self.folder / f"{what}-{len(self.running)}.log", "w") as log:
            process = subprocess.Popen(command, stdout=log, stderr=log, cwd=self.folder)
        self.running.append(process)
        return process

    def start_scheduler(self) -> subprocess.Popen:
        about = self.folder / "scheduler.json"
        process = self.start(
            "scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(about)
        )
        wait_until(lambda: about.exists() and '"address"' in about.read_text())
        self.address = about.read_text().split('"address": "')[1].split('"')[0]
        return process

    def start_worker(self) -> subprocess.Popen:
        return self.start("worker", self.address, "--nthreads", "1", "--no-nanny", "--host", "127.0.0.1")

    def stop(self) -> None:
        for process in self.running:
            process.kill()
            process.wait()


@pytest.fixture
def processes(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Processes]:
    running = Processes(tmp_path_factory.mktemp("cluster"))
    try:
        running.start_scheduler()
        yield running
    finally:
        running.stop()


@pytest.fixture(autouse=True)
def no_client_left() -> Iterator[None]:
    """A client that is garbage-collected while a thread starts would close itself there and deadlock."""
    yield
    gc.collect()


@pytest.fixture(scope="module")
def here(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The store of the slow sweep without a cluster."""
    path = tmp_path_factory.mktemp("here") / "map.zarr"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(chunking, "POINTS_INTEGRATED", 200)
        hl.sweep(SOFT, store=path, **SLOW)
    return path


def two_workers(processes: Processes) -> list[subprocess.Popen]:
    workers = [processes.start_worker() for _ in range(2)]
    with Client(processes.address, set_as_default=False) as client:
        client.wait_for_workers(2, timeout=30)
    return workers


# --- without processes --------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", ["newton", "adiabatic", "independent"])
def test_the_same_bits_as_without_a_cluster(model: str) -> None:
    told: list[int] = []
    here = hl.sweep(PAPER, model=model, **GRID)
    there = hl.sweep(PAPER, model=model, engine="dask", progress=lambda done, _: told.append(done), **GRID)
    assert same_bits(here, there)
    assert there.attrs["engine"] == "dask"
    assert told[0] == 0 and told[-1] == 2000 and told == sorted(set(told))


@pytest.mark.slow
def test_the_same_store_as_without_a_cluster(tmp_path: Path) -> None:
    hl.sweep(PAPER, store=tmp_path / "here", **GRID)
    hl.sweep(PAPER, store=tmp_path / "there", engine="dask", **GRID)
    assert files(tmp_path / "here") == files(tmp_path / "there")


@pytest.mark.slow
def test_counts_above_a_byte_in_some_chunks() -> None:
    column = hl.Column.paper(restitution=1.0, radius_2=1e-4, radius_1=0.1, height=4.0)
    swept = {"gap": np.geomspace(1e-3, 1e-11, 241)}
    here, there = hl.sweep(column, **swept), hl.sweep(column, engine="dask", **swept)
    assert here.n_contacts.dtype == there.n_contacts.dtype == np.uint32
    assert same_bits(here, there)


def test_an_open_client_stays_open() -> None:
    with one_worker() as local, Client(local, set_as_default=False) as client:
        for scheduler in (client, local, local.scheduler_address):
            assert same_bits(
                hl.sweep(PAPER, engine="dask", scheduler=scheduler, **GRID), hl.sweep(PAPER, **GRID)
            )
        assert client.submit(sum, [1, 2]).result() == 3


def test_an_error_of_the_caller_cancels_the_tasks() -> None:
    def fail(done: int, total: int) -> None:
        if done:
            raise KeyError("mine")

    with one_worker() as local, Client(local, set_as_default=False) as client:
        with pytest.raises(KeyError, match="mine"):
            hl.sweep(SOFT, engine="dask", scheduler=client, progress=fail, **SLOW)
        assert client.futures == {}
        wait_until(lambda: not any(client.processing().values()))


@pytest.mark.parametrize(
    ("job", "error", "closed"),
    [
        ("sweep", None, "cluster"),
        ("fidelity", KeyError("mine"), "client"),
        slow("sweep", None, "client"),
        slow("sweep", KeyError("mine"), "cluster"),
        slow("fidelity", None, "client"),
        slow("fidelity", KeyError("mine"), "cluster"),
    ],
)
def test_closing_a_cluster_of_this_process_during_the_work(
    job: str, error: Exception | None, closed: str
) -> None:
    """The message is one line; an error of the caller is not replaced by one of dask."""

    def close(done: int, total: int) -> None:
        if 0 < done < total:
            (client if closed == "client" else local).close()
            if error is not None:
                raise error

    with (
        one_worker() as local,
        Client(local, set_as_default=False) as client,
        pytest.raises(RuntimeError if error is None else KeyError) as told,
    ):
        if job == "sweep":
            hl.sweep(SOFT, engine="dask", scheduler=client, progress=close, **SLOW)
        else:
            law = hl.LinearDashpot(stiffness=1e6, restitution=0.9)
            options = {"until": 1e-4, "samples": 2, "replicas": 8, "models": ("newton",)}
            hl.fidelity(small_gas, law=law, scheduler=client, progress=close, **options)
    assert told.value is error or str(told.value).startswith(
        "scheduler: connection lost; a store keeps what is finished"
    )


def small_gas(seed: int) -> hl.ParticleSystem:
    return hl.ParticleSystem.random(20, 0.2, 1e-3, 2500.0, 1.0, seed=seed)


@pytest.mark.parametrize(
    ("who", "method", "job"),
    [(Client, "nthreads", "sweep"), (Future, "result", "sweep"), (Future, "result", "fidelity")],
)
def test_a_scheduler_that_no_longer_answers(
    monkeypatch: pytest.MonkeyPatch, who: type, method: str, job: str
) -> None:
    """An existing connection does not break; a new one fails."""

    def fail(*_: object, **__: object) -> None:
        raise OSError("Timed out trying to connect\nto it")

    monkeypatch.setattr(who, method, fail)
    with pytest.raises(RuntimeError, match="scheduler: connection lost") as refused:
        if job == "sweep":
            hl.sweep(PAPER, engine="dask", **GRID)
        else:
            with one_worker() as local:
                system = hl.ParticleSystem.random(20, 0.2, 1e-3, 2500.0, 1.0)
                law = hl.LinearDashpot(stiffness=1e6, restitution=0.9)
                hl.fidelity(system, law=law, until=1e-4, samples=2, scheduler=local.scheduler_address)
    assert "(Timed out trying to connect);" in str(refused.value) and "\n" not in str(refused.value)


@pytest.mark.slow
def test_large_chunks_cause_no_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    """A list of points carries its parameters; above 10 MiB distributed warns."""
    monkeypatch.setattr(chunking, "POINTS", 1 << 20)
    points = {"gap": xr.DataArray(np.geomspace(1e-6, 1e-2, 700_000), dims="point")}
    points["height"] = xr.DataArray(np.linspace(0.3, 0.6, 700_000), dims="point")
    swept = {"model": "independent", "variables": ["n_contacts"], **points}
    assert same_bits(hl.sweep(PAPER, engine="dask", **swept), hl.sweep(PAPER, **swept))


def test_every_chunk_comes_once() -> None:
    plan = make_plan(PAPER, "newton", None, GRID)
    chunks = chunking.Chunks.of(plan)
    came = [chunk for chunk, _ in cluster.compute(plan, chunks, range(len(chunks)), 1)]
    assert sorted(came) == list(range(20))


# --- refusals -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scheduler", ["tcp://127.0.0.1:1", slow("nowhere"), slow(3)])
def test_an_invalid_scheduler_is_refused(scheduler: object, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(connecting, "TIMEOUT", "0.5s")
    with pytest.raises(ValueError, match="must be the address of a scheduler that answers") as refused:
        hl.sweep(PAPER, engine="dask", scheduler=scheduler, **GRID)
    assert str(refused.value).startswith(f"scheduler: got {scheduler!r}")
    assert "\n" not in str(refused.value)


def test_a_missing_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ImportError, match=r"pip install 'hardlimit\[cluster\]'"):
        hl.sweep(PAPER, engine="dask", **GRID)


def test_a_worker_of_another_version_is_refused() -> None:
    with pytest.raises(RuntimeError, match=r"a worker has hardlimit .*, must be 0\.0\.9"):
        cluster._run(make_plan(PAPER, "newton", None, GRID), 1, "0.0.9")


# --- processes ----------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_workers_come_and_go(processes: Processes, tmp_path: Path, here: Path) -> None:
    """Each worker is killed in turn, the last one before the next starts, with finished, running and waiting chunks:
    none is lost or repeated."""
    workers = two_workers(processes)
    told: list[int] = []
    killed = 0

    def replace_one(done: int, total: int) -> None:
        nonlocal killed
        told.append(done)
        if done > (killed + 1) * total / 4:
            workers[killed].send_signal(signal.SIGKILL)
            workers[killed].wait()
            workers.append(processes.start_worker())
            killed += 1

    there = tmp_path / "there"
    hl.sweep(SOFT, store=there, engine="dask", scheduler=processes.address, progress=replace_one, **SLOW)
    assert killed == 3 and all(worker.returncode == -signal.SIGKILL for worker in workers[:3])
    assert told == list(range(0, 4_001, 200))
    assert files(there) == files(here)


@pytest.mark.slow
def test_the_scheduler_is_killed(processes: Processes, tmp_path: Path, here: Path) -> None:
    """One error; the store keeps the finished chunks, and another cluster continues."""
    two_workers(processes)
    told: list[int] = []

    def kill_it(done: int, total: int) -> None:
        told.append(done)
        if done > total / 4:
            processes.running[0].kill()

    with pytest.raises(RuntimeError, match="scheduler: connection lost"):
        hl.sweep(
            SOFT, store=tmp_path / "a", engine="dask", scheduler=processes.address, progress=kill_it, **SLOW
        )
    kept, told = told[-1], []
    hl.sweep(SOFT, store=tmp_path / "a", engine="dask", progress=lambda done, _: told.append(done), **SLOW)
    assert told[0] == kept > 1000 and told[-1] == 4000
    assert files(tmp_path / "a") == files(here)


AS_A_CALL_BEGINS = """
    import os
    import signal
    import threading
    import time
    from hardlimit.support import cluster

    async def nothing():
        pass

    with cluster.connection(None, "nothing") as client:
        client.loop.add_callback(time.sleep, 1.0)  # dask can't begin before
        threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
        client.sync(nothing)
"""


@pytest.mark.slow
def test_an_interrupt_at_the_start_of_a_call_is_the_only_error() -> None:
    command = [sys.executable, "-c", textwrap.dedent(AS_A_CALL_BEGINS)]
    run = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert run.stderr.startswith("Traceback") and run.stderr.rstrip().endswith("KeyboardInterrupt")
    assert "NameError" not in run.stderr


INTERRUPTED = """
    import sys
    import numpy as np
    import hardlimit as hl
    from hardlimit.sweep import chunks
    from hardlimit.sweep.plan import Plan

    compute = Plan.compute

    def telling(self, first, count, threads, progress):
        def tell(done):  # in a thread of a worker, while the kernel is at work
            print(done, flush=True)
            progress(done)

        return compute(self, first, count, threads, tell)

    Plan.compute = telling
    chunks.POINTS_INTEGRATED = {chunk}
    soft = hl.Column.paper(law=hl.Viscoelastic(youngs_modulus=1e8, poisson_ratio=0.3, dissipative_time=0.007))
    hl.sweep(soft, store=sys.argv[1], engine="dask", gap=np.geomspace(1e-6, 1e-2, {points}))
"""


@pytest.mark.slow
@pytest.mark.parametrize(("chunk", "points"), [(200, 600_000), (3_000_000, 6_000_000)])
def test_interrupted_it_stops_within_its_chunks(tmp_path: Path, chunk: int, points: int) -> None:
    """Without a stop it would take minutes."""
    store = tmp_path / "map.zarr"
    script = textwrap.dedent(INTERRUPTED.format(chunk=chunk, points=points))
    command = [sys.executable, "-c", script, str(store)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as run:
        under_way(run)
        os.kill(run.pid, signal.SIGINT)
        told, errors = run.communicate(timeout=60)
    assert errors.rstrip().endswith("KeyboardInterrupt")
    assert errors.startswith("Traceback")
    assert max(map(int, told.split()), default=0) < min(chunk + 1, points / 10)
    assert int((xr.open_zarr(store).outcome != 255).sum()) < points / 10
