"""engine="cuda" without a GPU: the machine code, the kernel in an emulated block, and what is said when
something is missing.

Where a GPU is, its results are compared with the processor's bit by bit.
"""

import hashlib
import io
import os
import re
import shutil
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from importlib import resources, util
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from emulated_gpu import Emulated, build

import hardlimit as hl
from conftest import refusal
from hardlimit.sweep.engines import cuda, cuda_device
from hardlimit.sweep.plan import Plan, make_plan
from hardlimit.sweep.variables import OF_POINT

HERE = Path(__file__).parent
PAPER = hl.Column.paper()
ALL = list(OF_POINT)

needs_compiler = pytest.mark.skipif(
    not (util.find_spec("cuda") and util.find_spec("cuda.core")),
    reason="the extra hardlimit[cuda] is not installed",
)


def random_points(n: int, seed: int = 1) -> dict[str, xr.DataArray]:
    """A list of independent points, from ordinary to extreme, some of them invalid drops."""
    rng = np.random.default_rng(seed)
    swept = {
        "restitution": rng.uniform(0.02, 1.0, n),
        "gap": np.geomspace(1e-9, 0.1, n)[rng.permutation(n)],
        "radius_ratio": rng.uniform(0.3, 30.0, n),
        "stiffness": 10.0 ** rng.uniform(3, 9, n),
        "gravity": rng.choice([0.0, 1.62, 9.81], n),
        "velocity_1": rng.uniform(-2.0, 0.5, n),
    }
    return {name: xr.DataArray(v, dims="point") for name, v in swept.items()}


GRID = {"restitution": np.linspace(0.3, 1.0, 40), "gap": np.geomspace(1e-7, 1e-1, 30)}
MAPS: dict[str, dict[str, Any]] = {
    "grid": GRID,
    "adiabatic": {**GRID, "model": "adiabatic"},
    "list": random_points(700),
    "by damping": {"damping": np.geomspace(1.0, 1e5, 12), "gap": GRID["gap"]},
    "some results": {**GRID, "variables": ["separation_velocity", "n_contacts"]},
    "slow drops": {"height": 0.1 + np.geomspace(1e-12, 1e-3, 50), "restitution": [0.2, 0.9, 0.99]},
    "too deep": {"stiffness": np.geomspace(1e2, 1e6, 12), "gap": GRID["gap"][::3]},
    "nothing swept": {},
}


def plan_of(model: str = "newton", variables: list[str] | None = None, **swept: Any) -> Plan:
    by_damping = hl.Column.paper(law=hl.LinearDashpot(stiffness=5e7, damping=1e3))
    return make_plan(by_damping if "damping" in swept else PAPER, model, variables or ALL, swept)


def same_chunks(a: dict[str, Any], b: dict[str, Any]) -> bool:
    return a.keys() == b.keys() and all(a[k].tobytes() == b[k].tobytes() for k in a)


# --- the machine code ---------------------------------------------------------------------------------------


@needs_compiler
@pytest.mark.parametrize("arch", ["sm_80", "sm_90"])
def test_the_kernel_compiles_within_its_registers(arch: str) -> None:
    """A thread uses all registers; the spilled memory is a few hundred bytes at most."""
    log = io.StringIO()
    assert cuda_device.compile_kernel(arch, log)[:4] == b"\x7fELF"
    used = {
        name: (int(registers), int(stored), int(loaded))
        for name, stored, loaded, registers in re.findall(
            r"Compiling entry function '(\w+)'.*?(\d+) bytes spill stores, (\d+) bytes spill loads.*?"
            r"Used (\d+) registers",
            log.getvalue(),
            re.DOTALL,
        )
    }
    print(f"{arch}: (registers, bytes spilled, bytes read back) {used}")
    assert used.keys() == {"solve", "damping_ratios"}
    assert used["damping_ratios"][0] <= 128 and used["damping_ratios"][1:] == (0, 0)
    assert used["solve"][0] <= 128
    assert used["solve"][1] <= 1600 and used["solve"][2] <= 2800


def ptx_of_the_kernel() -> str:
    """PTX from NVRTC itself, because cuda-core would need a driver."""
    from cuda.bindings import nvrtc

    with cuda_device.kernel_source("sm_80") as (source, options):
        _, program = nvrtc.nvrtcCreateProgram(source.encode(), b"kernel.cu", 0, [], [])
        arguments = options.as_bytes("nvrtc")
        assert nvrtc.nvrtcCompileProgram(program, len(arguments), arguments) == (
            nvrtc.nvrtcResult.NVRTC_SUCCESS,
        )
    size = nvrtc.nvrtcGetPTXSize(program)[1]
    ptx = b" " * size
    nvrtc.nvrtcGetPTX(program, ptx)
    return ptx.decode()


@needs_compiler
def test_nothing_is_fused_or_approximated() -> None:
    ptx = ptx_of_the_kernel()
    kinds = set(re.findall(r"\b(?:fma|mad|div|sqrt|rsqrt|rcp|ex2|sin|cos)\.[\w.]*f(?:32|64)\b", ptx))
    assert kinds == {"div.rn.f64", "rcp.rn.f64", "sqrt.rn.f64"}
    assert "mul.rn.f64" in ptx and "add.rn.f64" in ptx  # rounded one by one: ptxas may not fuse them either


def test_the_package_has_the_headers() -> None:
    folder = Path(str(resources.files("hardlimit") / "core"))
    here = HERE.parents[1] / "core"
    assert (folder / "sweep" / "kernel.cu").is_file()
    for path in here.rglob("*.hpp"):
        assert (folder / path.relative_to(here)).is_file()


# --- the kernel in an emulated block ------------------------------------------------------------------------


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if shutil.which("g++") is None:
        pytest.skip("g++ is not installed")
    return build(
        HERE / "emulated_gpu.cpp",
        tmp_path_factory.mktemp("kernel") / "kernel.so",
        "-Wall",
        "-Wextra",
        "-Werror",
    )


def emulated(library: Path, plan: Plan, room: int = 1 << 40) -> dict[str, Any]:
    with ThreadPoolExecutor(2) as pool:
        return cuda.compute_on(Emulated(library, room), plan, 1, pool, lambda _: None)


LONG = {"adiabatic", "list", "by damping", "too deep"}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow if name in LONG else ()) for name in MAPS]
)
def test_a_block_returns_the_bits_of_the_processor(library: Path, name: str) -> None:
    plan = plan_of(**MAPS[name])
    assert same_chunks(emulated(library, plan), plan.compute(0, plan.size, 1))


def test_equal_values_are_written_once() -> None:
    points = {"restitution": np.linspace(0.3, 1.0, 900), "gap": np.geomspace(1e-7, 1e-1, 900)}
    plan = plan_of(**{name: xr.DataArray(v, dims="point") for name, v in points.items()})
    room = cuda.input_words(plan, 900) - cuda.TASK_FIELDS
    assert 3 * 900 <= room < 3 * 900 + len(plan.values)  # with one ratio for each ε of floor and pair
    words = np.zeros(cuda.TASK_FIELDS + room, np.uint64)
    cuda.write_task(plan, words, 0, {})


@pytest.mark.parametrize(
    ("swept", "room"),
    [(GRID, 350_000), pytest.param(MAPS["list"], 430_000, marks=pytest.mark.slow)],
    ids=["grid", "list"],
)
def test_maps_larger_than_the_device_come_in_chunks(library: Path, swept: dict[str, Any], room: int) -> None:
    plan = plan_of(**swept)
    assert cuda.chunk_points(plan, room) < plan.size / 2
    assert same_chunks(emulated(library, plan, room), plan.compute(0, plan.size, 1))


@pytest.mark.slow
def test_the_kernel_copies_no_flag_before_it_is_set(tmp_path: Path) -> None:
    """Shared memory is not initialized: bytes that are neither true nor false trap when copied."""
    sanitize = ("-fsanitize=bool,enum", "-fsanitize-undefined-trap-on-error")
    flags = ("-O1", *sanitize, "-ftrivial-auto-var-init=pattern")
    checked = build(HERE / "emulated_gpu.cpp", tmp_path / "checked.so", *flags)
    plan = plan_of(restitution=np.linspace(0.3, 1.0, 10), gap=[1e-6, 1e-4, 1e-2])
    out = tmp_path / "chunk.npz"
    script = (
        "import sys, numpy as np, test_cuda as t; from pathlib import Path\n"
        "plan = t.plan_of(restitution=np.linspace(0.3, 1.0, 10), gap=[1e-6, 1e-4, 1e-2])\n"
        "np.savez(sys.argv[2], **t.emulated(Path(sys.argv[1]), plan))"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    subprocess.run(
        [sys.executable, "-c", script, str(checked), str(out)], check=True, cwd=HERE, env=environment
    )
    assert same_chunks(dict(np.load(out)), plan.compute(0, plan.size, 1))


def test_most_points_are_solved_by_the_kernel(library: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    left = []
    monkeypatch.setattr(cuda, "_solve_on_host", lambda plan, chunk, points, threads: left.append(len(points)))
    plan = plan_of(**GRID)
    emulated(library, plan)
    assert left[0] < 0.01 * plan.size


def test_a_device_without_memory_is_one_line() -> None:
    refused = refusal(lambda: cuda.chunk_points(plan_of(**GRID), 1000))
    assert re.fullmatch("engine: got 'cuda', must have more free memory .* than 1000 bytes", refused)


# --- what is missing ----------------------------------------------------------------------------------------


def refused(expected: type[Exception]) -> str:
    cuda_device._opened_once.cache_clear()
    with pytest.raises(expected) as error:
        hl.sweep(PAPER, engine="cuda", gap=[1e-4])
    assert "\n" not in str(error.value)
    return str(error.value)


def test_without_the_packages(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cuda", None)
    assert "package cuda-core: pip install 'hardlimit[cuda]'" in refused(ImportError)


class OneDevice:
    """A fake device that records the threads in which it was made current."""

    def __init__(self) -> None:
        self.current: list[int] = []

    def make_current(self) -> None:
        self.current.append(threading.get_ident())


def test_the_device_is_current_in_every_thread_that_opens_it(monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[OneDevice] = []
    monkeypatch.setattr(cuda_device, "_require_packages", lambda: None)
    monkeypatch.setattr(cuda_device, "_require_device", lambda: None)
    monkeypatch.setattr(cuda_device, "Gpu", lambda: opened.append(OneDevice()) or opened[0])
    cuda_device._opened_once.cache_clear()
    threads = [threading.Thread(target=cuda_device.open_gpu) for _ in range(3)]
    for thread in threads:
        thread.start()
        thread.join()
    cuda_device.open_gpu()
    cuda_device._opened_once.cache_clear()
    assert len(opened) == 1
    assert {thread.ident for thread in threads} | {threading.get_ident()} == set(opened[0].current)


@needs_compiler
def test_without_the_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    from cuda.bindings import nvrtc

    def missing() -> None:
        raise RuntimeError("Failure finding libnvrtc.so")

    monkeypatch.setattr(nvrtc, "nvrtcVersion", missing)
    assert "NVRTC, package nvidia-cuda-nvrtc-cu12: pip install 'hardlimit[cuda]'" in refused(ImportError)


def driver_answers(monkeypatch: pytest.MonkeyPatch, answer: str) -> None:
    from cuda.bindings import driver

    def init(_: int) -> tuple[Any]:
        if answer == "missing":
            raise RuntimeError("libcuda.so.1 not found")
        return (getattr(driver.CUresult, answer),)

    monkeypatch.setattr(driver, "cuInit", init)


@needs_compiler
@pytest.mark.parametrize(
    ("answer", "said"),
    [
        ("missing", "must have an NVIDIA driver, none was found"),
        ("CUDA_ERROR_NO_DEVICE", "must have a CUDA device, the NVIDIA driver finds none"),
        ("CUDA_ERROR_SYSTEM_DRIVER_MISMATCH", "it reports CUDA_ERROR_SYSTEM_DRIVER_MISMATCH"),
    ],
)
def test_without_a_device(monkeypatch: pytest.MonkeyPatch, answer: str, said: str) -> None:
    driver_answers(monkeypatch, answer)
    assert said in refused(ValueError)


@needs_compiler
def test_the_driver_of_this_machine() -> None:
    """The real driver, or its absence."""
    try:
        cuda_device.open_gpu()
    except ValueError as error:
        assert re.match("engine: got 'cuda', must (have|be) ", str(error))


@pytest.mark.parametrize("model", ["newton", "independent"])
def test_other_laws_and_models_are_refused(model: str) -> None:
    soft = hl.Column.paper(law=hl.Viscoelastic(youngs_modulus=1e8, poisson_ratio=0.3, dissipative_time=1e-5))
    column = soft if model == "newton" else PAPER
    refused = refusal(lambda: hl.sweep(column, model=model, engine="cuda", gap=[1e-4]))
    assert re.match(f"engine: got 'cuda', must be .* for the law .* and the model {model}", refused)


# --- where a GPU is -----------------------------------------------------------------------------------------


@pytest.fixture
def gpu() -> cuda_device.Gpu:
    try:
        return cuda_device.open_gpu()
    except (ImportError, ValueError) as missing:
        pytest.skip(str(missing))


def digest(ds: xr.Dataset) -> str:
    return hashlib.sha256(b"".join(ds[name].values.tobytes() for name in sorted(ds))).hexdigest()


@pytest.mark.parametrize("model", ["newton", "adiabatic"])
def test_a_gpu_returns_the_bits_of_the_processor(gpu: cuda_device.Gpu, model: str) -> None:
    points = random_points(100_000)
    here, there = (hl.sweep(PAPER, model, engine, variables=ALL, **points) for engine in ("cpu", "cuda"))
    assert digest(here) == digest(there), gpu.name


def test_a_gpu_streams(gpu: cuda_device.Gpu, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cuda, "POINTS", 1000)
    here, there = (hl.sweep(PAPER, engine=engine, variables=ALL, **GRID) for engine in ("cpu", "cuda"))
    assert digest(here) == digest(there), gpu.name
