"""The GPU of this machine (through cuda-core), and the kernel compiled for it by NVRTC."""

from __future__ import annotations

import ctypes
import hashlib
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

THREADS_PER_BLOCK: Final = 128  # as in the kernel

#: The same bits as on a processor: no fused multiply-add, correctly rounded divisions and square roots.
SAME_BITS: Final = {"fma": False, "prec_div": True, "prec_sqrt": True, "ftz": False}


@dataclass
class Memory:
    """Memory of the device and its copy on the host."""

    address: int
    host: NDArray[np.uint8]
    on_device: Any = None
    on_host: Any = None


class Gpu:
    """The first CUDA device. Calls on one stream run in order; all but ``wait`` may return before they end.

    Tests have an emulated device with the same methods.
    """

    def __init__(self) -> None:
        from cuda import core

        self._device = core.Device()
        self.make_current()
        self.name: str = self._device.name
        code = core.ObjectCode.from_cubin(cubin(f"sm_{self._device.arch}"))
        self._kernels = {name: code.get_kernel(name) for name in ("solve", "damping_ratios")}
        self._pinned = core.LegacyPinnedMemoryResource()

    def make_current(self) -> None:
        """Make this device current in the calling thread."""
        self._device.set_current()

    def room(self) -> int:
        """Free memory in bytes."""
        from cuda.bindings import driver

        error, free, _ = driver.cuMemGetInfo()
        return int(free) if error == driver.CUresult.CUDA_SUCCESS else 0

    def stream(self) -> Any:
        """A new stream."""
        return self._device.create_stream()

    def memory(self, size: int, stream: Any) -> Memory:
        """New memory of ``size`` bytes, a multiple of eight; the host's copy is pinned: the device can access it."""
        on_device, on_host = self._device.allocate(size, stream=stream), self._pinned.allocate(size)
        whole = (ctypes.c_uint8 * size).from_address(int(on_host.handle))
        return Memory(int(on_device.handle), np.ctypeslib.as_array(whole), on_device, on_host)

    def to_device(self, stream: Any, memory: Memory) -> None:
        """Copy the memory from the host to the device."""
        memory.on_host.copy_to(memory.on_device, stream=stream)

    def to_host(self, stream: Any, memory: Memory) -> None:
        """Copy the memory from the device to the host."""
        memory.on_device.copy_to(memory.on_host, stream=stream)

    def launch(self, stream: Any, kernel: str, task: int) -> None:
        """Run a kernel with the task at this address on as many threads as are resident at once."""
        from cuda import core

        code = self._kernels[kernel]
        blocks = code.occupancy.max_active_blocks_per_multiprocessor(THREADS_PER_BLOCK, 0)
        grid = max(1, blocks) * self._device.properties.multiprocessor_count
        core.launch(stream, core.LaunchConfig(grid=grid, block=THREADS_PER_BLOCK), code, task)

    def wait(self, stream: Any) -> None:
        """Return when the work is done."""
        stream.sync()


def open_gpu() -> Gpu:
    """The GPU, made current in the calling thread; an error of one line if it is not available.

    Each thread that uses the GPU must call this, because the driver has a current device per thread. The kernel is
    compiled and loaded once.

    Raises an ImportError without the packages of the extra ``hardlimit[cuda]``.
    """
    gpu = _opened_once()
    gpu.make_current()
    return gpu


@cache
def _opened_once() -> Gpu:
    _require_packages()
    _require_device()
    return Gpu()


def _require_packages() -> None:
    install = "pip install 'hardlimit[cuda]'"
    try:
        from cuda import core  # noqa: F401
        from cuda.bindings import nvrtc
    except ImportError:
        raise ImportError(f"engine: got 'cuda', must have the package cuda-core: {install}") from None
    try:
        nvrtc.nvrtcVersion()
    except RuntimeError:
        need = "must have the compiler NVRTC, package nvidia-cuda-nvrtc-cu12"
        raise ImportError(f"engine: got 'cuda', {need}: {install}") from None


def _require_device() -> None:
    from cuda.bindings import driver, nvrtc

    try:
        (error,) = driver.cuInit(0)
    except RuntimeError:
        raise ValueError("engine: got 'cuda', must have an NVIDIA driver, none was found") from None
    if error == driver.CUresult.CUDA_ERROR_NO_DEVICE:
        raise ValueError("engine: got 'cuda', must have a CUDA device, the NVIDIA driver finds none")
    if error != driver.CUresult.CUDA_SUCCESS:
        need = f"must have a working NVIDIA driver, it reports {error.name}"
        raise ValueError(f"engine: got 'cuda', {need}")
    from cuda import core

    device = core.Device(0)
    known = nvrtc.nvrtcGetSupportedArchs()[1]
    if int(device.arch) not in [int(arch) for arch in known]:
        need = f"must be a device of compute capability {min(known) / 10} to {max(known) / 10}"
        have = f"{device.name} has {device.compute_capability.major}.{device.compute_capability.minor}"
        raise ValueError(f"engine: got 'cuda', {need}; {have}")


# --- the kernel ---------------------------------------------------------------------------------------------


@contextmanager
def _headers() -> Iterator[Path]:
    """The folder of the core's headers in the package."""
    with resources.as_file(resources.files("hardlimit") / "core") as folder:
        yield folder


@contextmanager
def kernel_source(arch: str) -> Iterator[tuple[str, Any]]:
    """Source of the kernel, and compiler options."""
    from cuda import core

    with _headers() as folder:
        options = core.ProgramOptions(
            name="kernel.cu",
            arch=arch,
            std="c++20",
            device_as_default_execution_space=True,
            include_path=[str(folder), str(folder / "sweep")],
            ptxas_options=["-v"],
            **SAME_BITS,
        )
        yield (folder / "sweep" / "kernel.cu").read_text(encoding="utf-8"), options


def compile_kernel(arch: str, logs: Any = None) -> bytes:
    """Machine code for ``arch`` (such as sm_90). Needs neither driver nor device."""
    from cuda import core

    with kernel_source(arch) as (source, options):
        return bytes(core.Program(source, "c++", options).compile("cubin", logs=logs).code)


def cubin(arch: str) -> bytes:
    """Machine code from the user's cache, or compiled, which takes some seconds."""
    kept = _cache_folder() / f"{_fingerprint()}-{arch}.cubin"
    with suppress(OSError):
        return kept.read_bytes()
    code = compile_kernel(arch)
    with suppress(OSError):  # the cache is optional
        kept.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=kept.parent, delete=False) as file:
            file.write(code)
        os.replace(file.name, kept)
    return code


def _cache_folder() -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "hardlimit"


def _fingerprint() -> str:
    """Hash of everything that the machine code depends on."""
    from cuda.bindings import nvrtc

    digest = hashlib.sha256(repr((nvrtc.nvrtcVersion(), SAME_BITS)).encode())
    with _headers() as folder:
        for path in sorted(p for p in folder.rglob("*") if p.suffix in (".hpp", ".cu")):
            digest.update(path.read_bytes())
    return digest.hexdigest()[:32]
