"""Sweep on a GPU with the kernel core/sweep/kernel.cu; chunks are streamed through the device."""

from __future__ import annotations

import math
from collections.abc import Generator, Iterable
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from ... import _core
from ..chunks import Chunks
from ..computation import Report, Values
from ..plan import MODELS, Plan
from ..variables import OF_BALL, VARIABLES

if TYPE_CHECKING:
    from concurrent.futures import ThreadPoolExecutor

    from .cuda_device import Gpu

#: Outcome of a point that the host must solve.
LEFT_TO_HOST: Final = 255

#: Results in the order of the kernel's struct Task.
RESULTS: Final = (
    *("n_contacts", "outcome", "relative_velocity", "separation_velocity"),
    *("effective_restitution", "restitution_ratio", "t_end", "t_floor_end"),
)

#: Size of the kernel's struct Task in 64-bit words.
TASK_FIELDS: Final = 2 + 3 * _core.law_place(2, 2) + 2 + 4 + len(RESULTS)

#: Largest number of points computed at a time: several waves of threads on the largest device, 0.2 GB of pinned memory.
POINTS: Final = 1 << 22


def check(plan: Any) -> None:
    """Refuse sweeps that the kernel does not support.

    Raises a ValueError unless the column has two balls, its law and model have a kernel, and all variables have one
    value per point.
    """
    if not isinstance(plan, Plan) or plan.balls != 2:
        need = "must be 'cpu' or 'dask' unless two balls are swept"
    elif not _core.has_gpu_kernel(plan.law, MODELS.index(plan.model)):
        need = f"must be 'cpu' or 'dask' for the law {plan.law} and the model {plan.model}"
    elif set(plan.variables) & set(OF_BALL):
        need = f"must be 'cpu' or 'dask' for {', '.join(OF_BALL)}"
    else:
        return
    raise ValueError(f"engine: got 'cuda', {need}")


def compute(
    computation: Any,
    chunks: Chunks,
    wanted: Iterable[int],
    threads: int,
    report: Report,
    scheduler: Any = None,
) -> Generator[tuple[int, Values], None, None]:
    """Yield each wanted chunk, one after the other."""
    from concurrent.futures import ThreadPoolExecutor

    from .cuda_device import open_gpu

    gpu = open_gpu()
    with ThreadPoolExecutor(threads) as pool:
        for chunk in wanted:
            yield chunk, compute_on(gpu, computation.part(chunks.box(chunk)), threads, pool, report)


def compute_on(gpu: Gpu, plan: Plan, threads: int, pool: ThreadPoolExecutor, report: Report) -> Values:
    """Compute a plan in pieces that fit the device: one is computed while another is copied to the host."""
    values: Values = {name: np.empty(plan.size, VARIABLES[name].dtype) for name in plan.variables}
    left: list[NDArray[np.int64]] = []
    pieces = Chunks.within(plan.shape, chunk_points(plan, gpu.room()))
    slots = [Slot(gpu, plan, math.prod(pieces.box_shape)) for _ in range(min(2, len(pieces)))]
    for k in range(len(pieces) + len(slots)):
        slot = slots[k % len(slots)]
        if k >= len(slots):  # finish the previous piece in this slot
            first, count = pieces.span(k - len(slots))
            results = slot.finish()
            parts = [(out[first : first + count], results[name]) for name, out in values.items()]
            list(pool.map(np.copyto, *zip(*parts, strict=True)))
            left.append(first + np.flatnonzero(results["outcome"] == LEFT_TO_HOST))
            report(first + count)
        if k < len(pieces):
            slot.start(plan.part(pieces.box(k)))
    _solve_on_host(plan, values, np.concatenate(left), threads)
    return values


def chunk_points(plan: Plan, room: int) -> int:
    """Points of a piece such that two fit into ``room`` bytes even without shared values."""
    varying = sum(len(v) > 1 for v in plan.values)
    each = sum(np.dtype(VARIABLES[name].dtype).itemsize for name in _kept(plan)) + 8 * (varying + 2)
    points = int(0.8 * room) // (2 * each) - 1024
    if points < 1:
        raise ValueError(f"engine: got 'cuda', must have more free memory on the device than {room} bytes")
    return min(points, POINTS)


def _kept(plan: Plan) -> list[str]:
    """Results of the kernel, always with the outcome."""
    return [name for name in RESULTS if name in plan.variables or name == "outcome"]


def _solve_on_host(plan: Plan, values: Values, points: NDArray[np.int64], threads: int) -> None:
    """Solve the points that the kernel leaves to the host: resting contacts, long sequences, invalid drops."""
    if not len(points):
        return
    some = plan.at(points)
    for name, solved in some.compute(0, some.size, threads).items():
        if solved.dtype.itemsize > values[name].dtype.itemsize:  # more than 255 contacts
            values[name] = values[name].astype(solved.dtype)
        values[name][points] = solved


class Slot:
    """Memory for one piece on the device and on the host (pinned), with its own stream."""

    def __init__(self, gpu: Gpu, plan: Plan, points: int) -> None:
        self.gpu = gpu
        self.kept = _kept(plan)
        self.stream = gpu.stream()
        self.inputs = gpu.memory(8 * input_words(plan, points), self.stream)
        self.results = gpu.memory(sum(_bytes(name, points) for name in self.kept), self.stream)
        self.count = 0

    def start(self, plan: Plan, copy_out: bool = True) -> None:
        """Start a piece."""
        self.count = plan.size
        words, addresses = self.inputs.host.view(np.uint64), self._addresses(self.results.address)
        write_task(plan, words, self.inputs.address, addresses)
        self.gpu.to_device(self.stream, self.inputs)
        if plan.restitution_at >= 0:
            self.gpu.launch(self.stream, "damping_ratios", self.inputs.address)
        self.gpu.launch(self.stream, "solve", self.inputs.address)
        if copy_out:
            self.gpu.to_host(self.stream, self.results)

    def finish(self) -> Values:
        """Results of the piece, valid until the next start."""
        self.gpu.wait(self.stream)
        host, count = self.results.host, self.count
        return {
            name: host[at : at + _bytes(name, count)].view(VARIABLES[name].dtype)[:count]
            for name, at in self._addresses(0).items()
        }

    def _addresses(self, start: int) -> dict[str, int]:
        """Address of each result if the first is at ``start``."""
        addresses = {}
        for name in self.kept:
            addresses[name] = start
            start += _bytes(name, self.count)
        return addresses


def _bytes(name: str, points: int) -> int:
    """Bytes of a result, a multiple of eight."""
    return -(-points * np.dtype(VARIABLES[name].dtype).itemsize // 8) * 8


def _restitutions(plan: Plan) -> list[int]:
    """Parameters that are coefficients of restitution: of the floor and of the pair."""
    places = [_core.law_place(side, 2) + plan.restitution_at for side in range(2)]
    return places if plan.restitution_at >= 0 else []


def input_words(plan: Plan, points: int) -> int:
    """64-bit words of the Task of a piece of so many points, with its values and ratios."""
    keys = [
        (v.__array_interface__["data"][0], len(v), s) for v, s in zip(plan.values, plan.strides, strict=True)
    ]
    lists = [*set(keys), *{keys[i] for i in _restitutions(plan)}]
    return TASK_FIELDS + sum(min(length, points) for _, length, _ in lists)


def write_task(plan: Plan, words: NDArray[np.uint64], address: int, results: dict[str, int]) -> None:
    """Write the kernel's Task, followed by the values, to the host's copy of the memory at ``address``."""
    end = TASK_FIELDS
    written: dict[tuple[int, int], int] = {}  # several parameters may share their values
    values = []
    for v in plan.values:
        key = (v.__array_interface__["data"][0], len(v))
        if key not in written:
            words[end : end + len(v)] = v.view(np.uint64)
            written[key] = end
            end += len(v)
        values.append(address + 8 * written[key])
    ratios = [0, 0]
    known: dict[int, int] = {}  # address of the ratios by that of the values
    for side, i in enumerate(_restitutions(plan)):
        if values[i] not in known:
            known[values[i]] = address + 8 * end
            end += len(plan.values[i])
        ratios[side] = known[values[i]]
    sizes = [len(v) for v in plan.values]
    setting = [plan.model == MODELS[1], *plan.densities, plan.restitution_at % 2**64]
    outputs = [results.get(name, 0) for name in RESULTS]
    fields = [0, plan.size, *values, *plan.strides, *sizes, *ratios, *setting, *outputs]
    words[:TASK_FIELDS] = np.array(fields, dtype=np.uint64)
