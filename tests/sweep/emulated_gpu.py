"""A GPU of one block, emulated on a processor (emulated_gpu.hpp): runs core/sweep/kernel.cu where there is no GPU."""

import ctypes
import subprocess
from importlib import resources
from pathlib import Path

import numpy as np

from hardlimit.sweep.engines import cuda_device

HERE = Path(__file__).parent


def build(source: Path, library: Path, *flags: str) -> Path:
    """Compile the kernel, as included by ``source``, with g++."""
    headers = Path(str(resources.files("hardlimit") / "core"))
    flags = ("-std=c++20", "-O2", "-ffp-contract=off", "-fPIC", "-shared", *flags)
    folders = [f"-I{headers}", f"-I{headers}/sweep", f"-I{HERE}"]
    before = ["-include", str(HERE / "emulated_gpu.hpp")]
    subprocess.run(["g++", *flags, *folders, *before, str(source), "-o", str(library)], check=True)
    return library


class Emulated:
    """One block on a processor, and memory that the device and the host share."""

    name = "emulated"

    def __init__(self, library: Path, room: int = 1 << 40) -> None:
        self.library = ctypes.CDLL(str(library))
        self.free = room

    def room(self) -> int:
        return self.free

    def stream(self) -> list[cuda_device.Memory]:
        return []

    def memory(self, size: int, stream: list[cuda_device.Memory]) -> cuda_device.Memory:
        on_device = np.zeros(-(-size // 8), np.uint64)
        return cuda_device.Memory(on_device.ctypes.data, np.zeros(size, np.uint8), on_device)

    def to_device(self, stream: list[cuda_device.Memory], memory: cuda_device.Memory) -> None:
        memory.on_device.view(np.uint8)[:] = memory.host

    def to_host(self, stream: list[cuda_device.Memory], memory: cuda_device.Memory) -> None:
        stream.append(memory)  # not before it is waited for

    def launch(self, stream: list[cuda_device.Memory], kernel: str, task: int) -> None:
        assert self.library[f"emulate_{kernel}"](ctypes.c_void_p(task)) == 0

    def wait(self, stream: list[cuda_device.Memory]) -> None:
        for memory in stream:
            memory.host[:] = memory.on_device.view(np.uint8)
        stream.clear()
